//! The common functions and the co-simulation functions of FMI 2.0.

use super::export::exported;
use super::foreign::{
    CallbacksOf, Handle, ImporterValues, Logger, Opaque, RequestedValues, SavedState, StatePointer,
    Text,
};
use super::instance::{Instance, Refusal};
use super::resource_path::of_uri;
use gearatlas_jobs::fmu::LiveState;
use std::ffi::{c_char, c_int};

/// Kind of FMU: co-simulation.
const CO_SIMULATION: c_int = 1;

/// Kind of status: the time up to which steps succeeded.
const LAST_SUCCESSFUL_TIME: c_int = 2;

/// Kind of status: whether the FMU wants to end the simulation.
const TERMINATED: c_int = 3;

const NOT_PENDING: &str = "no step is pending";

exported! {
    fn fmi2GetTypesPlatform() -> *const c_char {
        c"default".as_ptr()
    }

    fn fmi2GetVersion() -> *const c_char {
        c"2.0".as_ptr()
    }

    fn fmi2SetDebugLogging(instance: Handle, _on: c_int, _count: usize, _categories: Opaque) -> c_int {
        instance.call(|_| Ok(()))
    }

    fn fmi2Instantiate(
        name: Text,
        kind: c_int,
        token: Text,
        resources: Text,
        callbacks: CallbacksOf,
        _visible: c_int,
        _logging: c_int,
    ) -> Handle {
        let Some(logger) = Logger::two(callbacks, name) else {
            return Handle::NONE;
        };
        Handle::make(logger, || {
            if kind != CO_SIMULATION {
                return Err(Refusal::error("this FMU is for co-simulation"));
            }
            Instance::new(&of_uri(resources.read()?), token.read()?)
        })
    }

    fn fmi2FreeInstance(instance: Handle) {
        instance.free();
    }

    fn fmi2SetupExperiment(
        instance: Handle,
        _tolerance_given: c_int,
        _tolerance: f64,
        start: f64,
        _stop_given: c_int,
        _stop: f64,
    ) -> c_int {
        instance.call(|own| own.set_start(start))
    }

    fn fmi2EnterInitializationMode(instance: Handle) -> c_int {
        instance.call(Instance::enter_initialization)
    }

    fn fmi2ExitInitializationMode(instance: Handle) -> c_int {
        instance.call(Instance::exit_initialization)
    }

    fn fmi2Terminate(instance: Handle) -> c_int {
        instance.call(Instance::terminate)
    }

    fn fmi2Reset(instance: Handle) -> c_int {
        instance.call(|own| {
            own.reset();
            Ok(())
        })
    }

    fn fmi2GetReal(instance: Handle, references: ImporterValues<u32>, count: usize, values: RequestedValues<f64>) -> c_int {
        instance.call(|own| {
            let pairs = references.list(count)?.iter().zip(values.list(count)?);
            for (reference, value) in pairs {
                *value = own.number(*reference)?;
            }
            Ok(())
        })
    }

    fn fmi2GetInteger(
        instance: Handle,
        references: ImporterValues<u32>,
        count: usize,
        values: RequestedValues<c_int>,
    ) -> c_int {
        instance.call(|own| {
            let pairs = references.list(count)?.iter().zip(values.list(count)?);
            for (reference, value) in pairs {
                *value = c_int::try_from(own.count(*reference)?).unwrap_or(c_int::MAX);
            }
            Ok(())
        })
    }

    fn fmi2SetReal(instance: Handle, references: ImporterValues<u32>, count: usize, values: ImporterValues<f64>) -> c_int {
        instance.call(|own| {
            let mut pairs = references.list(count)?.iter().zip(values.list(count)?);
            pairs.try_for_each(|(reference, value)| own.set(*reference, *value))
        })
    }

    fn fmi2GetFMUstate(instance: Handle, state: StatePointer) -> c_int {
        instance.call(|own| state.overwrite(own.state()))
    }

    fn fmi2SetFMUstate(instance: Handle, state: SavedState) -> c_int {
        instance.call(|own| own.set_state(state.read()?))
    }

    fn fmi2FreeFMUstate(instance: Handle, state: StatePointer) -> c_int {
        instance.call(|_| state.free())
    }

    fn fmi2SerializedFMUstateSize(instance: Handle, state: SavedState, size: RequestedValues<usize>) -> c_int {
        instance.call(|_| {
            size.list(1)?[0] = state.read()?.bytes().len();
            Ok(())
        })
    }

    fn fmi2SerializeFMUstate(instance: Handle, state: SavedState, bytes: RequestedValues<u8>, size: usize) -> c_int {
        instance.call(|_| serialize(state, bytes, size))
    }

    fn fmi2DeSerializeFMUstate(instance: Handle, bytes: ImporterValues<u8>, size: usize, state: StatePointer) -> c_int {
        instance.call(|_| deserialize(bytes, size, state))
    }

    fn fmi2SetRealInputDerivatives(
        instance: Handle,
        references: ImporterValues<u32>,
        count: usize,
        orders: ImporterValues<c_int>,
        values: ImporterValues<f64>,
    ) -> c_int {
        instance.call(|own| {
            let given = orders.list(count)?.iter().zip(values.list(count)?);
            let mut all = references.list(count)?.iter().zip(given);
            all.try_for_each(|(reference, (order, value))| own.set_rate(*reference, *order, *value))
        })
    }

    fn fmi2DoStep(instance: Handle, time: f64, length: f64, _no_way_back: c_int) -> c_int {
        instance.call(|own| own.step(time, length))
    }

    fn fmi2GetRealStatus(instance: Handle, kind: c_int, value: RequestedValues<f64>) -> c_int {
        instance.call(|own| {
            if kind != LAST_SUCCESSFUL_TIME {
                return Err(Refusal::error(NOT_PENDING));
            }
            value.list(1)?[0] = own.time();
            Ok(())
        })
    }

    fn fmi2GetBooleanStatus(instance: Handle, kind: c_int, value: RequestedValues<c_int>) -> c_int {
        instance.call(|_| {
            if kind != TERMINATED {
                return Err(Refusal::error(NOT_PENDING));
            }
            value.list(1)?[0] = 0;
            Ok(())
        })
    }
}

/// Writes the bytes of a state if they have room.
pub fn serialize(
    state: SavedState,
    bytes: RequestedValues<u8>,
    size: usize,
) -> Result<(), Refusal> {
    let own = state.read()?.bytes();
    let room = bytes.list(size)?.get_mut(..own.len());
    let few = || {
        Refusal::error(format!(
            "the state has {} bytes, the room {size}",
            own.len()
        ))
    };
    room.ok_or_else(few)?.copy_from_slice(&own);
    Ok(())
}

/// Stores the state from some bytes.
pub fn deserialize(
    bytes: ImporterValues<u8>,
    size: usize,
    state: StatePointer,
) -> Result<(), Refusal> {
    let live = LiveState::of_bytes(bytes.list(size)?).map_err(Refusal::error)?;
    state.fill(live)
}
