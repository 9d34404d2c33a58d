//! The `atlas` binary; everything it does is in [`atlas::cli`].

fn main() -> std::process::ExitCode {
    atlas::cli::main()
}
