//! Panics that are answers: of a worker, and in the decoding of a file.

use crate::store::is_decoding;

/// How the names of threads begin on which a panic becomes a row or an error.
pub const WORKER: &str = "atlas-";

/// A panic in a worker becomes a row with its message, and one in the decoding of a file an error
/// that names the file: from now on this process says nothing else of them.
pub fn hush_workers() {
    let usual = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        let worker = std::thread::current()
            .name()
            .is_some_and(|name| name.starts_with(WORKER));
        if !worker && !is_decoding() {
            usual(panic);
        }
    }));
}
