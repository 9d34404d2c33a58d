//! Functions of FMI 2.0 whose arguments differ from those of FMI 3.0. Functions with equal arguments are in `both`,
//! unsupported ones in `absent`.

use super::both::{get, set};
use super::export::exported;
use super::foreign::{CallbacksOf, Handle, ImporterValues, Logger, Opaque, RequestedValues, Text};
use super::instance::{Instance, Refusal};
use super::resource_path::of_uri;
use std::ffi::{c_char, c_int};

/// The kind of FMU: co-simulation.
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

    fn fmi2SetupExperiment(
        instance: Handle,
        _tolerance_given: c_int,
        _tolerance: f64,
        start: f64,
        _stop_given: c_int,
        _stop: f64,
    ) -> c_int {
        instance.call(|instance| instance.set_start(start))
    }

    fn fmi2EnterInitializationMode(instance: Handle) -> c_int {
        instance.call(Instance::enter_initialization)
    }

    fn fmi2GetReal(instance: Handle, references: ImporterValues<u32>, count: usize, values: RequestedValues<f64>) -> c_int {
        instance.call(|instance| get(references, values, count, |reference| instance.number(reference)))
    }

    fn fmi2GetInteger(
        instance: Handle,
        references: ImporterValues<u32>,
        count: usize,
        values: RequestedValues<c_int>,
    ) -> c_int {
        instance.call(|instance| {
            get(references, values, count, |reference| {
                Ok(c_int::try_from(instance.count(reference)?).unwrap_or(c_int::MAX))
            })
        })
    }

    fn fmi2SetReal(instance: Handle, references: ImporterValues<u32>, count: usize, values: ImporterValues<f64>) -> c_int {
        instance.call(|instance| set(instance, references, values, count))
    }

    fn fmi2SetRealInputDerivatives(
        instance: Handle,
        references: ImporterValues<u32>,
        count: usize,
        orders: ImporterValues<c_int>,
        values: ImporterValues<f64>,
    ) -> c_int {
        instance.call(|instance| {
            let given = orders.list(count)?.iter().zip(values.list(count)?);
            let mut all = references.list(count)?.iter().zip(given);
            all.try_for_each(|(reference, (order, value))| instance.set_rate(*reference, *order, *value))
        })
    }

    fn fmi2DoStep(instance: Handle, time: f64, length: f64, _no_way_back: c_int) -> c_int {
        instance.call(|instance| instance.step(time, length))
    }

    fn fmi2GetRealStatus(instance: Handle, kind: c_int, value: RequestedValues<f64>) -> c_int {
        instance.call(|instance| {
            if kind != LAST_SUCCESSFUL_TIME {
                return Err(Refusal::error(NOT_PENDING));
            }
            value.list(1)?[0] = instance.time();
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
