//! The `atlas` binary; the code is in [`gearatlas::cli`].

/// Short computations of many points allocate and free small parts without end.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() -> std::process::ExitCode {
    gearatlas::store::ProgramRecord::set_commit(gearatlas::COMMIT);
    gearatlas::cli::main()
}
