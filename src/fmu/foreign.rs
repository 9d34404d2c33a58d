//! Conversion of the importer's data to Rust and back: the only code that uses its pointers.
//!
//! Only the importer makes values of these types, when it calls a function that this library exports. The
//! standard defines what they point to. During the call this is a text that ends with 0, as many values as an argument
//! of the call states, or a result of an earlier call. Null pointers are refused, except for empty
//! lists.

#![allow(unsafe_code)]

use super::instance::{Instance, Refusal};
use super::panics::caught;
use gearatlas_jobs::fmu::LiveState;
use std::ffi::{CStr, CString, c_char, c_int, c_void};

/// Status of a call in both versions: done.
pub const OK: c_int = 0;
/// Status: not done, and the state is unchanged.
pub const DISCARD: c_int = 2;
/// Status: an error, after which the instance remains usable.
pub const ERROR: c_int = 3;
/// Status: an error, after which the instance is not usable.
pub const FATAL: c_int = 4;

/// A pointer that is passed back to the importer unchanged, or ignored.
#[repr(transparent)]
#[derive(Clone, Copy)]
pub struct Opaque(*mut c_void);

/// A text.
#[repr(transparent)]
#[derive(Clone, Copy)]
pub struct Text(*const c_char);

impl Text {
    /// The text of a call.
    pub fn read<'a>(self) -> Result<&'a str, Refusal> {
        if self.0.is_null() {
            return Err(Refusal::error("a text is a null pointer"));
        }
        // SAFETY: the importer passed the pointer as a text that ends with 0.
        let text = unsafe { CStr::from_ptr(self.0) };
        text.to_str()
            .map_err(|_| Refusal::error("a text is not UTF-8"))
    }
}

/// Values from the importer.
#[repr(transparent)]
#[derive(Clone, Copy)]
pub struct ImporterValues<T>(*const T);

impl<T: Copy> ImporterValues<T> {
    /// The first `count` values.
    pub fn list<'a>(self, count: usize) -> Result<&'a [T], Refusal> {
        match (count, self.0.is_null()) {
            (0, _) => Ok(&[]),
            (_, true) => Err(Refusal::error("a list is a null pointer")),
            // SAFETY: the importer passed the pointer with this number of values.
            (_, false) => Ok(unsafe { std::slice::from_raw_parts(self.0, count) }),
        }
    }
}

/// Memory of the importer for requested values.
#[repr(transparent)]
#[derive(Clone, Copy)]
pub struct RequestedValues<T>(*mut T);

impl<T: Copy> RequestedValues<T> {
    /// The first `count` values.
    pub fn list<'a>(self, count: usize) -> Result<&'a mut [T], Refusal> {
        match (count, self.0.is_null()) {
            (0, _) => Ok(&mut []),
            (_, true) => Err(Refusal::error("a list is a null pointer")),
            // SAFETY: the importer passed the pointer as room for this number of values. No other reference
            // to them exists.
            (_, false) => Ok(unsafe { std::slice::from_raw_parts_mut(self.0, count) }),
        }
    }

    /// Writes one value, unless the pointer is null.
    pub fn answer(self, value: T) {
        if !self.0.is_null() {
            // SAFETY: the importer passed the pointer as room for one value.
            unsafe { self.0.write(value) }
        }
    }
}

/// A state that the importer keeps.
#[repr(transparent)]
#[derive(Clone, Copy)]
pub struct SavedState(*mut LiveState);

impl SavedState {
    /// The state.
    pub fn read<'a>(self) -> Result<&'a LiveState, Refusal> {
        // SAFETY: FMI allows the importer to pass only a null pointer, or one that `StatePointer` made and has not
        // freed.
        let live = unsafe { self.0.as_ref() };
        live.ok_or_else(|| Refusal::error("there is no state to read"))
    }
}

/// The importer's variable for a state.
#[repr(transparent)]
#[derive(Clone, Copy)]
pub struct StatePointer(*mut *mut LiveState);

impl StatePointer {
    fn place<'a>(self) -> Result<&'a mut *mut LiveState, Refusal> {
        // SAFETY: the importer passed the pointer as its variable for a state.
        let place = unsafe { self.0.as_mut() };
        place.ok_or_else(|| Refusal::error("a place for a state is a null pointer"))
    }

    /// Stores a copy of a state in the variable. A state that the variable contains is overwritten.
    pub fn overwrite(self, live: &LiveState) -> Result<(), Refusal> {
        let place = self.place()?;
        // SAFETY: the pointer is null, or this type made it and has not freed it.
        match unsafe { place.as_mut() } {
            Some(old) => old.copy(live),
            None => *place = Box::into_raw(Box::new(live.clone())),
        }
        Ok(())
    }

    /// Stores a new state in the variable. The previous value of the variable is ignored.
    pub fn fill(self, live: LiveState) -> Result<(), Refusal> {
        *self.place()? = Box::into_raw(Box::new(live));
        Ok(())
    }

    /// Frees the stored state, if any.
    pub fn free(self) -> Result<(), Refusal> {
        let place = std::mem::replace(self.place()?, std::ptr::null_mut());
        if !place.is_null() {
            // SAFETY: this type made the pointer, and the importer's variable no longer contains it.
            drop(unsafe { Box::from_raw(place) });
        }
        Ok(())
    }
}

/// The logger of FMI 2.0: a C function with any number of arguments.
// SAFETY: this is a type. It calls nothing.
pub type Logger2 =
    Option<unsafe extern "C" fn(Opaque, *const c_char, c_int, *const c_char, *const c_char, ...)>;

/// The logger of FMI 3.0.
// SAFETY: this is a type. It calls nothing.
pub type Logger3 = Option<unsafe extern "C" fn(Opaque, c_int, *const c_char, *const c_char)>;

/// The functions of an importer of FMI 2.0.
#[repr(C)]
pub struct Callbacks {
    logger: Logger2,
    allocate: Opaque,
    free: Opaque,
    finished: Opaque,
    environment: Opaque,
}

/// A pointer to the functions of an importer of FMI 2.0.
#[repr(transparent)]
#[derive(Clone, Copy)]
pub struct CallbacksOf(*const Callbacks);

/// The receiver of messages.
pub enum Logger {
    /// An importer of FMI 2.0, with the name of the instance.
    Two(Logger2, Opaque, CString),
    /// An importer of FMI 3.0.
    Three(Logger3, Opaque),
}

impl Logger {
    /// The logger of an importer of FMI 2.0; `None` if it gives no functions.
    pub fn two(callbacks: CallbacksOf, name: Text) -> Option<Self> {
        // SAFETY: the importer passed the pointer to its functions, which it keeps as long as the instance
        // exists.
        let callbacks = unsafe { callbacks.0.as_ref() }?;
        let name = name.read().ok().and_then(|name| CString::new(name).ok());
        Some(Self::Two(
            callbacks.logger,
            callbacks.environment,
            name.unwrap_or_default(),
        ))
    }

    /// Sends a message.
    pub fn log(&self, status: c_int, message: &str) {
        let message = CString::new(message.replace('\0', " ")).unwrap_or_default();
        let category = c"logStatusError".as_ptr();
        match self {
            Self::Two(Some(logger), environment, name) => {
                let (name, message) = (name.as_ptr(), message.as_ptr());
                // SAFETY: the importer passed this function. The format has one text as its argument.
                unsafe {
                    logger(
                        *environment,
                        name,
                        status,
                        category,
                        c"%s".as_ptr(),
                        message,
                    )
                }
            }
            Self::Three(Some(logger), environment) => {
                // SAFETY: the importer passed this function.
                unsafe { logger(*environment, status, category, message.as_ptr()) }
            }
            Self::Two(None, ..) | Self::Three(None, _) => {}
        }
    }
}

/// The importer's handle of an instance.
#[repr(transparent)]
#[derive(Clone, Copy)]
pub struct Handle(*mut c_void);

/// An instance and its logger. After a panic there is no instance.
struct InstanceBox {
    instance: Option<Instance>,
    logger: Logger,
}

impl Handle {
    /// No instance.
    pub const NONE: Self = Self(std::ptr::null_mut());

    /// Makes an instance. After a failure, logs a message and returns [`Self::NONE`].
    pub fn make(logger: Logger, make: impl FnOnce() -> Result<Instance, Refusal>) -> Self {
        super::panics::keep();
        let refusal = match caught(make) {
            Ok(Ok(instance)) => {
                let instance = Some(instance);
                return Self(Box::into_raw(Box::new(InstanceBox { instance, logger })).cast());
            }
            Ok(Err(refusal)) => refusal.sentence().to_owned(),
            Err(reason) => reason,
        };
        // A panic in the importer's logger is not caught.
        logger.log(ERROR, &refusal);
        Self::NONE
    }

    fn instance_box<'a>(self) -> Option<&'a mut InstanceBox> {
        // SAFETY: the pointer is null, or `make` made it and `free` has not freed it. The importer makes one
        // call at a time.
        unsafe { self.0.cast::<InstanceBox>().as_mut() }
    }

    /// Calls an instance and returns the status of the call. The reason of a refusal goes to the logger.
    pub fn call(self, act: impl FnOnce(&mut Instance) -> Result<(), Refusal>) -> c_int {
        let Some(InstanceBox { instance, logger }) = self.instance_box() else {
            return ERROR;
        };
        let Some(alive) = instance else {
            return FATAL;
        };
        let (status, sentence) = match caught(|| act(alive)) {
            Ok(Ok(())) => return OK,
            Ok(Err(refusal)) => (refusal.status(), refusal.sentence().to_owned()),
            Err(reason) => {
                *instance = None;
                (FATAL, reason)
            }
        };
        logger.log(status, &sentence);
        status
    }

    /// Frees an instance, unless the handle is null.
    pub fn free(self) {
        if !self.0.is_null() {
            // SAFETY: `make` made the pointer, and the importer no longer uses it.
            let held = unsafe { Box::from_raw(self.0.cast::<InstanceBox>()) };
            _ = caught(|| drop(held));
        }
    }
}
