//! The functions with equal arguments in FMI 2.0 and FMI 3.0, and common parts of other functions.

use super::export::exported;
use super::foreign::{Handle, ImporterValues, RequestedValues, SavedState, StatePointer};
use super::instance::{Instance, Refusal};
use gearatlas_jobs::fmu::LiveState;
use std::ffi::c_int;

/// Exports each function under its names in both versions.
macro_rules! of_both {
    ($(fn $two:ident, $three:ident $arguments:tt $(-> $answer:ty)? $body:block)*) => {
        exported! { $(
            fn $two $arguments $(-> $answer)? $body
            fn $three $arguments $(-> $answer)? $body
        )* }
    };
}

of_both! {
    fn fmi2FreeInstance, fmi3FreeInstance(instance: Handle) {
        instance.free();
    }

    fn fmi2ExitInitializationMode, fmi3ExitInitializationMode(instance: Handle) -> c_int {
        instance.call(Instance::exit_initialization)
    }

    fn fmi2Terminate, fmi3Terminate(instance: Handle) -> c_int {
        instance.call(Instance::terminate)
    }

    fn fmi2Reset, fmi3Reset(instance: Handle) -> c_int {
        instance.call(|instance| {
            instance.reset();
            Ok(())
        })
    }

    fn fmi2GetFMUstate, fmi3GetFMUState(instance: Handle, state: StatePointer) -> c_int {
        instance.call(|instance| state.overwrite(instance.state()))
    }

    fn fmi2SetFMUstate, fmi3SetFMUState(instance: Handle, state: SavedState) -> c_int {
        instance.call(|instance| instance.set_state(state.read()?))
    }

    fn fmi2FreeFMUstate, fmi3FreeFMUState(instance: Handle, state: StatePointer) -> c_int {
        instance.call(|_| state.free())
    }

    fn fmi2SerializedFMUstateSize, fmi3SerializedFMUStateSize(instance: Handle, state: SavedState, size: RequestedValues<usize>) -> c_int {
        instance.call(|_| {
            size.list(1)?[0] = state.read()?.bytes().len();
            Ok(())
        })
    }

    fn fmi2SerializeFMUstate, fmi3SerializeFMUState(instance: Handle, state: SavedState, bytes: RequestedValues<u8>, size: usize) -> c_int {
        instance.call(|_| serialize(state, bytes, size))
    }

    fn fmi2DeSerializeFMUstate, fmi3DeserializeFMUState(instance: Handle, bytes: ImporterValues<u8>, size: usize, state: StatePointer) -> c_int {
        instance.call(|_| deserialize(bytes, size, state))
    }
}

/// Writes one value per variable to the importer's memory.
pub fn get<T: Copy>(
    references: ImporterValues<u32>,
    values: RequestedValues<T>,
    count: usize,
    mut of: impl FnMut(u32) -> Result<T, Refusal>,
) -> Result<(), Refusal> {
    for (reference, value) in references.list(count)?.iter().zip(values.list(count)?) {
        *value = of(*reference)?;
    }
    Ok(())
}

/// Sets one value per variable.
pub fn set(
    instance: &mut Instance,
    references: ImporterValues<u32>,
    values: ImporterValues<f64>,
    count: usize,
) -> Result<(), Refusal> {
    let mut pairs = references.list(count)?.iter().zip(values.list(count)?);
    pairs.try_for_each(|(reference, value)| instance.set(*reference, *value))
}

/// Writes the bytes of a state to the importer's memory. An error if they do not fit.
fn serialize(state: SavedState, bytes: RequestedValues<u8>, size: usize) -> Result<(), Refusal> {
    let serialized = state.read()?.bytes();
    let room = bytes.list(size)?.get_mut(..serialized.len());
    let few = || {
        Refusal::error(format!(
            "the state has {} bytes, the room {size}",
            serialized.len()
        ))
    };
    room.ok_or_else(few)?.copy_from_slice(&serialized);
    Ok(())
}

/// Makes a state from bytes, and stores it in the importer's variable.
fn deserialize(bytes: ImporterValues<u8>, size: usize, state: StatePointer) -> Result<(), Refusal> {
    let live = LiveState::of_bytes(bytes.list(size)?).map_err(Refusal::error)?;
    state.fill(live)
}
