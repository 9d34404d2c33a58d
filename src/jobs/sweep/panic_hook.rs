//! Panics that become results: in a worker, and while decoding a file.

use crate::store::is_decoding;

/// Prefix of the names of threads on which a panic becomes a row or an error.
pub const WORKER: &str = "atlas-";

/// Silences panics that are reported in another way: a panic in a worker becomes a row with its message, and one while
/// decoding becomes an error that names the file.
pub fn silence_reported_panics() {
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
