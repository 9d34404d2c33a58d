//! The `atlas` binary; the code is in [`gearatlas::cli`].

fn main() -> std::process::ExitCode {
    gearatlas::store::ProgramRecord::set_commit(gearatlas::COMMIT);
    gearatlas::cli::main()
}
