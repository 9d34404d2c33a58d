//! Exports functions from the library under their names.

/// Exports functions under their own names. Only [`crate::foreign`] dereferences the pointers in their
/// arguments.
macro_rules! exported {
    ($(fn $name:ident($($argument:ident: $type:ty),* $(,)?) $(-> $answer:ty)? $body:block)*) => { $(
        // SAFETY: the standard defines the name, and no other function has it.
        #[allow(unsafe_code)]
        #[unsafe(no_mangle)]
        pub extern "C" fn $name($($argument: $type),*) $(-> $answer)? $body
    )* };
}

pub(crate) use exported;
