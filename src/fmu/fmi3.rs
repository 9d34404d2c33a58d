//! The functions of FMI 3.0 that this FMU provides; the others are in [`super::absent`].

use super::export::exported;
use super::fmi2::{deserialize, serialize};
use super::foreign::{
    Handle, ImporterValues, Logger, Logger3, Opaque, RequestedValues, SavedState, StatePointer,
    Text,
};
use super::instance::{Instance, Refusal};
use std::ffi::{c_char, c_int};
use std::path::Path;

/// Requires one value per variable, because no variable is an array.
fn one_each(count: usize, values: usize) -> Result<(), Refusal> {
    if count == values {
        return Ok(());
    }
    let sentence =
        format!("there are {values} values for {count} variables, none of which is an array");
    Err(Refusal::error(sentence))
}

exported! {
    fn fmi3GetVersion() -> *const c_char {
        c"3.0".as_ptr()
    }

    fn fmi3SetDebugLogging(instance: Handle, _on: u8, _count: usize, _categories: Opaque) -> c_int {
        instance.call(|_| Ok(()))
    }

    fn fmi3InstantiateCoSimulation(
        _name: Opaque,
        token: Text,
        resources: Text,
        _visible: u8,
        _logging: u8,
        event_mode: u8,
        _early_return: u8,
        _required: Opaque,
        required_count: usize,
        environment: Opaque,
        logger: Logger3,
        _update: Opaque,
    ) -> Handle {
        Handle::make(Logger::Three(logger, environment), || {
            if event_mode != 0 {
                return Err(Refusal::error("this FMU has no event mode"));
            }
            if required_count != 0 {
                return Err(Refusal::error("this FMU has no intermediate variables"));
            }
            Instance::new(Path::new(resources.read()?), token.read()?)
        })
    }

    fn fmi3FreeInstance(instance: Handle) {
        instance.free();
    }

    fn fmi3EnterInitializationMode(
        instance: Handle,
        _tolerance_given: u8,
        _tolerance: f64,
        start: f64,
        _stop_given: u8,
        _stop: f64,
    ) -> c_int {
        instance.call(|own| {
            own.set_start(start)?;
            own.enter_initialization()
        })
    }

    fn fmi3ExitInitializationMode(instance: Handle) -> c_int {
        instance.call(Instance::exit_initialization)
    }

    fn fmi3Terminate(instance: Handle) -> c_int {
        instance.call(Instance::terminate)
    }

    fn fmi3Reset(instance: Handle) -> c_int {
        instance.call(|own| {
            own.reset();
            Ok(())
        })
    }

    fn fmi3GetFloat64(
        instance: Handle,
        references: ImporterValues<u32>,
        count: usize,
        values: RequestedValues<f64>,
        value_count: usize,
    ) -> c_int {
        instance.call(|own| {
            one_each(count, value_count)?;
            let pairs = references.list(count)?.iter().zip(values.list(count)?);
            for (reference, value) in pairs {
                *value = own.number(*reference)?;
            }
            Ok(())
        })
    }

    fn fmi3SetFloat64(
        instance: Handle,
        references: ImporterValues<u32>,
        count: usize,
        values: ImporterValues<f64>,
        value_count: usize,
    ) -> c_int {
        instance.call(|own| {
            one_each(count, value_count)?;
            let mut pairs = references.list(count)?.iter().zip(values.list(count)?);
            pairs.try_for_each(|(reference, value)| own.set(*reference, *value))
        })
    }

    fn fmi3GetInt64(
        instance: Handle,
        references: ImporterValues<u32>,
        count: usize,
        values: RequestedValues<i64>,
        value_count: usize,
    ) -> c_int {
        instance.call(|own| {
            one_each(count, value_count)?;
            let pairs = references.list(count)?.iter().zip(values.list(count)?);
            for (reference, value) in pairs {
                *value = own.count(*reference)?;
            }
            Ok(())
        })
    }

    fn fmi3GetFMUState(instance: Handle, state: StatePointer) -> c_int {
        instance.call(|own| state.overwrite(own.state()))
    }

    fn fmi3SetFMUState(instance: Handle, state: SavedState) -> c_int {
        instance.call(|own| own.set_state(state.read()?))
    }

    fn fmi3FreeFMUState(instance: Handle, state: StatePointer) -> c_int {
        instance.call(|_| state.free())
    }

    fn fmi3SerializedFMUStateSize(instance: Handle, state: SavedState, size: RequestedValues<usize>) -> c_int {
        instance.call(|_| {
            size.list(1)?[0] = state.read()?.bytes().len();
            Ok(())
        })
    }

    fn fmi3SerializeFMUState(instance: Handle, state: SavedState, bytes: RequestedValues<u8>, size: usize) -> c_int {
        instance.call(|_| serialize(state, bytes, size))
    }

    fn fmi3DeserializeFMUState(instance: Handle, bytes: ImporterValues<u8>, size: usize, state: StatePointer) -> c_int {
        instance.call(|_| deserialize(bytes, size, state))
    }

    fn fmi3DoStep(
        instance: Handle,
        time: f64,
        length: f64,
        _no_way_back: u8,
        event_needed: RequestedValues<u8>,
        terminate: RequestedValues<u8>,
        early: RequestedValues<u8>,
        last_time: RequestedValues<f64>,
    ) -> c_int {
        instance.call(|own| {
            let done = own.step(time, length);
            for answer in [event_needed, terminate, early] {
                answer.answer(0);
            }
            last_time.answer(own.time());
            done
        })
    }
}
