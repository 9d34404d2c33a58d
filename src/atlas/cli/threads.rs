//! The option `--threads`.

use clap::Args;

/// Worker threads.
#[derive(Debug, Args)]
pub struct Threads {
    /// Start this many worker threads [default: one per core that this process may use].
    #[arg(short = 'j', long = "threads", value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub asked: Option<u32>,
}

impl Threads {
    /// The number of threads, if given.
    pub fn count(&self) -> Option<usize> {
        self.asked.map(|n| n as usize)
    }
}
