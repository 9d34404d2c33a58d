//! What the importer hands over, as Rust has it, and what goes back: all use of its pointers.
//!
//! The types here are made by the importer alone, in the call of a function that this library exports. The standard says what
//! they point to: for the time of the call a text that ends with 0, as many values as the call says, or what an earlier call
//! returned. A null pointer is refused, except that an empty list may be one.

#![allow(unsafe_code)]

use super::instance::{Instance, Refusal};
use super::panics::caught;
use gearatlas_jobs::fmu::Live;
use std::ffi::{CStr, CString, c_char, c_int, c_void};

/// What a call ends with, in both versions.
pub const OK: c_int = 0;
/// Not done; the state is as before.
pub const DISCARD: c_int = 2;
/// Wrong; the instance goes on.
pub const ERROR: c_int = 3;
/// The instance is no more.
pub const FATAL: c_int = 4;

/// A pointer that is handed back as it is, or not looked at.
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
        // SAFETY: the importer handed it over as a text that ends with 0.
        let text = unsafe { CStr::from_ptr(self.0) };
        text.to_str()
            .map_err(|_| Refusal::error("a text is not UTF-8"))
    }
}

/// Values that the importer gives.
#[repr(transparent)]
#[derive(Clone, Copy)]
pub struct Given<T>(*const T);

impl<T: Copy> Given<T> {
    /// So many of them.
    pub fn list<'a>(self, count: usize) -> Result<&'a [T], Refusal> {
        match (count, self.0.is_null()) {
            (0, _) => Ok(&[]),
            (_, true) => Err(Refusal::error("a list is a null pointer")),
            // SAFETY: the importer handed it over as so many values.
            (_, false) => Ok(unsafe { std::slice::from_raw_parts(self.0, count) }),
        }
    }
}

/// Room for values that the importer asks for.
#[repr(transparent)]
#[derive(Clone, Copy)]
pub struct Asked<T>(*mut T);

impl<T: Copy> Asked<T> {
    /// So many of them.
    pub fn list<'a>(self, count: usize) -> Result<&'a mut [T], Refusal> {
        match (count, self.0.is_null()) {
            (0, _) => Ok(&mut []),
            (_, true) => Err(Refusal::error("a list is a null pointer")),
            // SAFETY: the importer handed it over as room for so many values, which nothing else here refers to.
            (_, false) => Ok(unsafe { std::slice::from_raw_parts_mut(self.0, count) }),
        }
    }

    /// Answers with one value, where there is room for it.
    pub fn answer(self, value: T) {
        if !self.0.is_null() {
            // SAFETY: the importer handed it over as room for one value.
            unsafe { self.0.write(value) }
        }
    }
}

/// A state that the importer keeps.
#[repr(transparent)]
#[derive(Clone, Copy)]
pub struct Kept(*mut Live);

impl Kept {
    /// The state.
    pub fn read<'a>(self) -> Result<&'a Live, Refusal> {
        // SAFETY: it is null or what `Slot` made, for the importer returns only what it was given and has not freed.
        let live = unsafe { self.0.as_ref() };
        live.ok_or_else(|| Refusal::error("there is no state to read"))
    }
}

/// Where the importer keeps a state.
#[repr(transparent)]
#[derive(Clone, Copy)]
pub struct Slot(*mut *mut Live);

impl Slot {
    fn place<'a>(self) -> Result<&'a mut *mut Live, Refusal> {
        // SAFETY: the importer handed it over as the place of a state.
        let place = unsafe { self.0.as_mut() };
        place.ok_or_else(|| Refusal::error("a place for a state is a null pointer"))
    }

    /// Keeps a state there, in place of one that is there already.
    pub fn overwrite(self, live: &Live) -> Result<(), Refusal> {
        let place = self.place()?;
        // SAFETY: it is null or what this type made and has not freed.
        match unsafe { place.as_mut() } {
            Some(old) => old.copy(live),
            None => *place = Box::into_raw(Box::new(live.clone())),
        }
        Ok(())
    }

    /// Keeps a new state there, whatever there was.
    pub fn fill(self, live: Live) -> Result<(), Refusal> {
        *self.place()? = Box::into_raw(Box::new(live));
        Ok(())
    }

    /// Frees the state that is there, if any.
    pub fn free(self) -> Result<(), Refusal> {
        let place = std::mem::replace(self.place()?, std::ptr::null_mut());
        if !place.is_null() {
            // SAFETY: this type made it, and the importer has it no more.
            drop(unsafe { Box::from_raw(place) });
        }
        Ok(())
    }
}

/// What FMI 2.0 calls with a message: a function of C with any number of arguments.
// SAFETY: a type, which calls nothing.
pub type Logger2 =
    Option<unsafe extern "C" fn(Opaque, *const c_char, c_int, *const c_char, *const c_char, ...)>;

/// What FMI 3.0 calls with one.
// SAFETY: a type, which calls nothing.
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

/// Them, as a call has them.
#[repr(transparent)]
#[derive(Clone, Copy)]
pub struct CallbacksOf(*const Callbacks);

/// Where messages go.
pub enum Logger {
    /// To an importer of FMI 2.0, with the name of the instance.
    Two(Logger2, Opaque, CString),
    /// To one of FMI 3.0.
    Three(Logger3, Opaque),
}

impl Logger {
    /// That of an importer of FMI 2.0; none where it gives no functions.
    pub fn two(callbacks: CallbacksOf, name: Text) -> Option<Self> {
        // SAFETY: the importer handed it over as its functions, which stay where they are while there is an instance.
        let callbacks = unsafe { callbacks.0.as_ref() }?;
        let name = name.read().ok().and_then(|name| CString::new(name).ok());
        Some(Self::Two(
            callbacks.logger,
            callbacks.environment,
            name.unwrap_or_default(),
        ))
    }

    /// Hands a message over.
    pub fn say(&self, status: c_int, message: &str) {
        let message = CString::new(message.replace('\0', " ")).unwrap_or_default();
        let category = c"logStatusError".as_ptr();
        match self {
            Self::Two(Some(logger), environment, name) => {
                let (name, message) = (name.as_ptr(), message.as_ptr());
                // SAFETY: the importer gave it as this function; the format takes one text.
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
                // SAFETY: the importer gave it as this function.
                unsafe { logger(*environment, status, category, message.as_ptr()) }
            }
            Self::Two(None, ..) | Self::Three(None, _) => {}
        }
    }
}

/// An instance as the importer holds it.
#[repr(transparent)]
#[derive(Clone, Copy)]
pub struct Handle(*mut c_void);

/// An instance and its logger; no instance after a panic.
struct Held {
    instance: Option<Instance>,
    logger: Logger,
}

impl Handle {
    /// No instance.
    pub const NONE: Self = Self(std::ptr::null_mut());

    /// Makes an instance; none where that is refused, with a message.
    pub fn make(logger: Logger, make: impl FnOnce() -> Result<Instance, Refusal>) -> Self {
        super::panics::keep();
        let refusal = match caught(make) {
            Ok(Ok(instance)) => {
                let instance = Some(instance);
                return Self(Box::into_raw(Box::new(Held { instance, logger })).cast());
            }
            Ok(Err(refusal)) => refusal.sentence().to_owned(),
            Err(said) => said,
        };
        // A panic of the importer's function is none of ours.
        logger.say(ERROR, &refusal);
        Self::NONE
    }

    fn held<'a>(self) -> Option<&'a mut Held> {
        // SAFETY: it is null or what `make` made and `free` has not freed; the importer makes one call at a time with it.
        unsafe { self.0.cast::<Held>().as_mut() }
    }

    /// Lets an instance act; the status is its answer, and a refusal goes to the logger.
    pub fn call(self, act: impl FnOnce(&mut Instance) -> Result<(), Refusal>) -> c_int {
        let Some(Held { instance, logger }) = self.held() else {
            return ERROR;
        };
        let Some(own) = instance else {
            return FATAL;
        };
        let (status, sentence) = match caught(|| act(own)) {
            Ok(Ok(())) => return OK,
            Ok(Err(refusal)) => (refusal.status(), refusal.sentence().to_owned()),
            Err(said) => {
                *instance = None;
                (FATAL, said)
            }
        };
        logger.say(status, &sentence);
        status
    }

    /// Frees an instance, if it is one.
    pub fn free(self) {
        if !self.0.is_null() {
            // SAFETY: `make` made it, and the importer has it no more.
            let held = unsafe { Box::from_raw(self.0.cast::<Held>()) };
            _ = caught(|| drop(held));
        }
    }
}
