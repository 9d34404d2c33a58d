//! Gives functions their names in the library.

/// Exports functions under their own names. Only [`crate::foreign`] follows the pointers in their arguments.
macro_rules! exported {
    ($(fn $name:ident($($argument:ident: $type:ty),* $(,)?) $(-> $answer:ty)? $body:block)*) => { $(
        // SAFETY: the name is one of the standard, and stands here once.
        #[allow(unsafe_code)]
        #[unsafe(no_mangle)]
        pub extern "C" fn $name($($argument: $type),*) $(-> $answer)? $body
    )* };
}

pub(crate) use exported;
