//! Functions of FMI 3.0 whose arguments differ from those of FMI 2.0. Functions with equal arguments are in `both`,
//! unsupported ones in `absent`.

use super::both::{get, set};
use super::export::exported;
use super::foreign::{Handle, ImporterValues, Logger, Logger3, Opaque, RequestedValues, Text};
use super::instance::{Instance, Refusal};
use std::ffi::{c_char, c_int};
use std::path::Path;

/// Refuses a request without exactly one value per variable, because no variable is an array.
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

    fn fmi3EnterInitializationMode(
        instance: Handle,
        _tolerance_given: u8,
        _tolerance: f64,
        start: f64,
        _stop_given: u8,
        _stop: f64,
    ) -> c_int {
        instance.call(|instance| {
            instance.set_start(start)?;
            instance.enter_initialization()
        })
    }

    fn fmi3GetFloat64(
        instance: Handle,
        references: ImporterValues<u32>,
        count: usize,
        values: RequestedValues<f64>,
        value_count: usize,
    ) -> c_int {
        instance.call(|instance| {
            one_each(count, value_count)?;
            get(references, values, count, |reference| instance.number(reference))
        })
    }

    fn fmi3SetFloat64(
        instance: Handle,
        references: ImporterValues<u32>,
        count: usize,
        values: ImporterValues<f64>,
        value_count: usize,
    ) -> c_int {
        instance.call(|instance| {
            one_each(count, value_count)?;
            set(instance, references, values, count)
        })
    }

    fn fmi3GetInt64(
        instance: Handle,
        references: ImporterValues<u32>,
        count: usize,
        values: RequestedValues<i64>,
        value_count: usize,
    ) -> c_int {
        instance.call(|instance| {
            one_each(count, value_count)?;
            get(references, values, count, |reference| instance.count(reference))
        })
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
        instance.call(|instance| {
            let done = instance.step(time, length);
            for answer in [event_needed, terminate, early] {
                answer.answer(0);
            }
            last_time.answer(instance.time());
            done
        })
    }
}
