//! What a panic says, kept for the importer's logger instead of the error stream.

use std::cell::RefCell;
use std::panic::{self, AssertUnwindSafe};
use std::sync::Once;

thread_local! {
    static LAST: RefCell<String> = const { RefCell::new(String::new()) };
}

/// From now on panics of this library are kept and not printed. The standard library is a part of this one, so that nobody
/// else's are.
pub fn keep() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        panic::set_hook(Box::new(|panic| {
            LAST.with_borrow_mut(|last| *last = panic.to_string());
        }));
    });
}

/// Does something; what a panic says instead.
pub fn caught<T>(work: impl FnOnce() -> T) -> Result<T, String> {
    panic::catch_unwind(AssertUnwindSafe(work)).map_err(|_| {
        let said = LAST.with_borrow_mut(std::mem::take);
        format!("{said}; this is an error of the library, please report it with the FMU")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_becomes_a_sentence() {
        keep();
        assert_eq!(caught(|| 3), Ok(3));
        let said = caught(|| panic!("out of steam")).unwrap_err();
        assert!(
            said.contains("out of steam") && said.contains("panics.rs"),
            "{said}"
        );
    }
}
