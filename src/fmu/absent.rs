//! Functions of FMI 2.0 and 3.0 that this FMU does not support, such as those for model exchange and scheduled
//! execution. Importers refuse a library without them.

use super::export::exported;
use super::foreign::{Handle, Logger, Logger3, Opaque};
use super::instance::Refusal;
use std::ffi::c_int;

/// Functions for values that no variable has: further types, integers to be set, derivatives of outputs, clocks. They
/// accept only empty requests.
macro_rules! of_no_variable {
    ($($name:ident($($argument:ident: $type:ty),*);)*) => {
        exported! { $(
            fn $name(instance: Handle, _references: Opaque, variables: usize, $($argument: $type),*) -> c_int {
                instance.call(|_| match variables {
                    0 => Ok(()),
                    _ => Err(Refusal::error(concat!(stringify!($name), ": no variable of the drive allows this"))),
                })
            }
        )* }
    };
}

of_no_variable! {
    fmi2GetBoolean(_values: Opaque);
    fmi2SetBoolean(_values: Opaque);
    fmi2GetString(_values: Opaque);
    fmi2SetString(_values: Opaque);
    fmi2SetInteger(_values: Opaque);
    fmi2GetRealOutputDerivatives(_orders: Opaque, _values: Opaque);
    fmi3GetFloat32(_values: Opaque, _count: usize);
    fmi3SetFloat32(_values: Opaque, _count: usize);
    fmi3GetInt8(_values: Opaque, _count: usize);
    fmi3SetInt8(_values: Opaque, _count: usize);
    fmi3GetUInt8(_values: Opaque, _count: usize);
    fmi3SetUInt8(_values: Opaque, _count: usize);
    fmi3GetInt16(_values: Opaque, _count: usize);
    fmi3SetInt16(_values: Opaque, _count: usize);
    fmi3GetUInt16(_values: Opaque, _count: usize);
    fmi3SetUInt16(_values: Opaque, _count: usize);
    fmi3GetInt32(_values: Opaque, _count: usize);
    fmi3SetInt32(_values: Opaque, _count: usize);
    fmi3GetUInt32(_values: Opaque, _count: usize);
    fmi3SetUInt32(_values: Opaque, _count: usize);
    fmi3SetInt64(_values: Opaque, _count: usize);
    fmi3GetUInt64(_values: Opaque, _count: usize);
    fmi3SetUInt64(_values: Opaque, _count: usize);
    fmi3GetBoolean(_values: Opaque, _count: usize);
    fmi3SetBoolean(_values: Opaque, _count: usize);
    fmi3GetString(_values: Opaque, _count: usize);
    fmi3SetString(_values: Opaque, _count: usize);
    fmi3GetBinary(_sizes: Opaque, _values: Opaque, _count: usize);
    fmi3SetBinary(_sizes: Opaque, _values: Opaque, _count: usize);
    fmi3GetClock(_values: Opaque);
    fmi3SetClock(_values: Opaque);
    fmi3GetIntervalDecimal(_intervals: Opaque, _qualifiers: Opaque);
    fmi3GetIntervalFraction(_counters: Opaque, _resolutions: Opaque, _qualifiers: Opaque);
    fmi3GetShiftDecimal(_shifts: Opaque);
    fmi3GetShiftFraction(_counters: Opaque, _resolutions: Opaque);
    fmi3SetIntervalDecimal(_intervals: Opaque);
    fmi3SetIntervalFraction(_counters: Opaque, _resolutions: Opaque);
    fmi3SetShiftDecimal(_shifts: Opaque);
    fmi3SetShiftFraction(_counters: Opaque, _resolutions: Opaque);
    fmi3GetOutputDerivatives(_orders: Opaque, _values: Opaque, _count: usize);
}

/// Functions that an importer must not call on this FMU. They return an error.
macro_rules! not_provided {
    ($($name:ident($($argument:ident: $type:ty),*);)*) => {
        exported! { $(
            fn $name(instance: Handle, $($argument: $type),*) -> c_int {
                instance.call(|_| Err(Refusal::error(concat!(stringify!($name), " is not provided"))))
            }
        )* }
    };
}

not_provided! {
    fmi2GetDirectionalDerivative(_unknowns: Opaque, _m: usize, _knowns: Opaque, _n: usize, _seed: Opaque, _out: Opaque);
    fmi2CancelStep();
    fmi2GetStatus(_kind: c_int, _value: Opaque);
    fmi2GetIntegerStatus(_kind: c_int, _value: Opaque);
    fmi2GetStringStatus(_kind: c_int, _value: Opaque);
    fmi3GetNumberOfVariableDependencies(_reference: u32, _count: Opaque);
    fmi3GetVariableDependencies(_reference: u32, _elements: Opaque, _independents: Opaque, _of: Opaque, _kinds: Opaque, _count: usize);
    fmi3GetDirectionalDerivative(_unknowns: Opaque, _m: usize, _knowns: Opaque, _n: usize, _seed: Opaque, _k: usize, _out: Opaque, _l: usize);
    fmi3GetAdjointDerivative(_unknowns: Opaque, _m: usize, _knowns: Opaque, _n: usize, _seed: Opaque, _k: usize, _out: Opaque, _l: usize);
    fmi3EnterConfigurationMode();
    fmi3ExitConfigurationMode();
    fmi3EnterEventMode();
    fmi3EnterStepMode();
    fmi3EvaluateDiscreteStates();
    fmi3UpdateDiscreteStates(_again: Opaque, _end: Opaque, _nominals: Opaque, _values: Opaque, _defined: Opaque, _next: Opaque);
    fmi3EnterContinuousTimeMode();
    fmi3CompletedIntegratorStep(_no_way_back: u8, _event: Opaque, _end: Opaque);
    fmi3SetTime(_time: f64);
    fmi3SetContinuousStates(_states: Opaque, _count: usize);
    fmi3GetContinuousStateDerivatives(_rates: Opaque, _count: usize);
    fmi3GetEventIndicators(_indicators: Opaque, _count: usize);
    fmi3GetContinuousStates(_states: Opaque, _count: usize);
    fmi3GetNominalsOfContinuousStates(_nominals: Opaque, _count: usize);
    fmi3GetNumberOfEventIndicators(_count: Opaque);
    fmi3GetNumberOfContinuousStates(_count: Opaque);
    fmi3ActivateModelPartition(_clock: u32, _time: f64);
}

/// Refuses to make an instance, and logs the reason.
fn refused(logger: Logger3, environment: Opaque) -> Handle {
    let only = || Err(Refusal::error("this FMU is for co-simulation"));
    Handle::make(Logger::Three(logger, environment), only)
}

exported! {
    fn fmi3InstantiateModelExchange(
        _name: Opaque,
        _token: Opaque,
        _resources: Opaque,
        _visible: u8,
        _logging: u8,
        environment: Opaque,
        logger: Logger3,
    ) -> Handle {
        refused(logger, environment)
    }

    fn fmi3InstantiateScheduledExecution(
        _name: Opaque,
        _token: Opaque,
        _resources: Opaque,
        _visible: u8,
        _logging: u8,
        environment: Opaque,
        logger: Logger3,
        _update: Opaque,
        _lock: Opaque,
        _unlock: Opaque,
    ) -> Handle {
        refused(logger, environment)
    }
}
