//! The `atlas` binary; everything it does is in [`atlas::cli`].

fn main() -> std::process::ExitCode {
    atlas::store::ProgramRecord::set_commit(atlas::COMMIT);
    atlas::cli::main()
}
