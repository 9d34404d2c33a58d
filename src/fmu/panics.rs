//! Catches panics, and keeps their messages for the importer's logger instead of the error stream.

use std::cell::RefCell;
use std::panic::{self, AssertUnwindSafe};
use std::sync::Once;

thread_local! {
    static LAST: RefCell<String> = const { RefCell::new(String::new()) };
}

/// Stores panic messages of this library from now on instead of printing them. The library contains its own copy of the
/// standard library, so that this affects no other code.
pub fn keep() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        panic::set_hook(Box::new(|panic| {
            LAST.with_borrow_mut(|last| *last = panic.to_string());
        }));
    });
}

/// Runs `work`. After a panic, the error is the panic message.
pub fn caught<T>(work: impl FnOnce() -> T) -> Result<T, String> {
    panic::catch_unwind(AssertUnwindSafe(work)).map_err(|_| {
        let message = LAST.with_borrow_mut(std::mem::take);
        format!("{message}; this is an error of the library, please report it with the FMU")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_becomes_a_sentence() {
        keep();
        assert_eq!(caught(|| 3), Ok(3));
        let message = caught(|| panic!("out of steam")).unwrap_err();
        assert!(
            message.contains("out of steam") && message.contains("panics.rs"),
            "{message}"
        );
    }
}
