//! Which calls does an instance accept in which state, and what does it return? This is independent of the
//! version of FMI.

use super::foreign::{DISCARD, ERROR};
use gearatlas_jobs::fmu::{Drive, INPUTS, LiveState, Mode, Plant, Role};
use std::borrow::Cow;
use std::ffi::c_int;
use std::path::Path;

/// Largest difference between the times of importer and instance, relative to the larger of step and time.
const SAME_TIME: f64 = 1e-9;

/// Largest part of a step by which these times may differ, unless the rounding of the time is larger.
const PART_OF_STEP: f64 = 1e-2;

/// Why a call is refused.
#[derive(Debug)]
pub enum Refusal {
    /// A step failed. The state is as before the step.
    Discard(String),
    /// The call is not allowed in the present mode, its arguments are wrong, or a plant or state is not possible.
    Error(Cow<'static, str>),
}

impl Refusal {
    /// A refusal with the status [`ERROR`].
    pub fn error(sentence: impl Into<Cow<'static, str>>) -> Self {
        Self::Error(sentence.into())
    }

    /// Status that a refused call returns.
    pub fn status(&self) -> c_int {
        match self {
            Self::Discard(_) => DISCARD,
            Self::Error(_) => ERROR,
        }
    }

    /// The reason, in words.
    pub fn sentence(&self) -> &str {
        match self {
            Self::Discard(sentence) => sentence,
            Self::Error(sentence) => sentence,
        }
    }
}

/// An FMU instance: its drive, its state and its plant.
pub struct Instance {
    drive: Drive,
    live: LiveState,
    /// The plant, and the parameters for which it was built.
    plant: Option<(Vec<f64>, Plant)>,
}

impl Instance {
    /// The instance for a folder of resources; the token must be that of the FMU.
    pub fn new(resources: &Path, token: &str) -> Result<Self, Refusal> {
        let drive =
            Drive::open(resources, token).map_err(|error| Refusal::error(error.to_string()))?;
        let live = at_start(&drive);
        Ok(Self {
            drive,
            live,
            plant: None,
        })
    }

    /// Restores the state after instantiation.
    pub fn reset(&mut self) {
        self.live = at_start(&self.drive);
    }

    fn require(&self, modes: &[Mode], what: &str) -> Result<(), Refusal> {
        if modes.contains(&self.live.mode) {
            return Ok(());
        }
        let mode = self.live.mode.name();
        Err(Refusal::error(format!("{what} is not allowed {mode}")))
    }

    /// Sets the time of the start.
    pub fn set_start(&mut self, time: f64) -> Result<(), Refusal> {
        self.require(&[Mode::Instantiated], "setting up the experiment")?;
        if !time.is_finite() {
            return Err(Refusal::error(format!("the start time is {time}")));
        }
        self.live.time = time;
        Ok(())
    }

    /// Begins the initialization.
    pub fn enter_initialization(&mut self) -> Result<(), Refusal> {
        self.require(&[Mode::Instantiated], "entering initialization mode")?;
        self.live.mode = Mode::Initialization;
        Ok(())
    }

    /// Builds the plant and ends the initialization.
    pub fn exit_initialization(&mut self) -> Result<(), Refusal> {
        self.require(&[Mode::Initialization], "leaving initialization mode")?;
        self.prepare()?;
        self.live.mode = Mode::Step;
        Ok(())
    }

    /// Ends the simulation.
    pub fn terminate(&mut self) -> Result<(), Refusal> {
        self.require(&[Mode::Step], "terminating")?;
        self.live.mode = Mode::Terminated;
        Ok(())
    }

    /// Builds the plant if necessary. If there is no motion, sets it to its start.
    fn prepare(&mut self) -> Result<(), Refusal> {
        let known = |entry: &(Vec<f64>, Plant)| same_bits(&entry.0, &self.live.parameters);
        if !self.plant.as_ref().is_some_and(known) {
            self.plant = Some(self.build(&self.live.parameters)?);
        }
        if let (Some((_, plant)), None) = (&self.plant, &self.live.motion) {
            plant.begin(&mut self.live);
        }
        Ok(())
    }

    fn build(&self, parameters: &[f64]) -> Result<(Vec<f64>, Plant), Refusal> {
        let plant = self.drive.plant(parameters);
        let plant = plant.map_err(|error| Refusal::error(error.to_string()))?;
        Ok((parameters.to_vec(), plant))
    }

    fn role(&self, reference: u32) -> Result<Role, Refusal> {
        let variable = self.drive.description().variables.get(reference as usize);
        variable
            .map(|variable| variable.role)
            .ok_or_else(|| Refusal::error(format!("there is no value reference {reference}")))
    }

    fn name(&self, reference: u32) -> &str {
        let variable = self.drive.description().variables.get(reference as usize);
        variable.map_or("", |variable| variable.name.as_str())
    }

    /// The plant and the state, for reading outputs. In initialization mode the plant is built if necessary.
    fn ready(&mut self) -> Result<(&Plant, &LiveState), Refusal> {
        self.require(
            &[Mode::Initialization, Mode::Step, Mode::Terminated],
            "reading an output",
        )?;
        if self.live.mode == Mode::Initialization {
            self.prepare()?;
        }
        match &self.plant {
            Some((_, plant)) => Ok((plant, &self.live)),
            None => Err(no_motion()),
        }
    }

    /// The value of a variable of floating-point type.
    pub fn number(&mut self, reference: u32) -> Result<f64, Refusal> {
        let role = self.role(reference)?;
        match role {
            Role::Time => Ok(self.live.time),
            Role::Parameter(place) => Ok(self.live.parameters[place]),
            Role::Input(input) => Ok(self.live.inputs[input.place()]),
            _ if role.is_whole() => Err(self.of_other_type(reference)),
            _ => {
                let (plant, live) = self.ready()?;
                plant.value(live, role).ok_or_else(no_motion)
            }
        }
    }

    /// The value of an integer variable.
    pub fn count(&mut self, reference: u32) -> Result<i64, Refusal> {
        let role = self.role(reference)?;
        if !role.is_whole() {
            return Err(self.of_other_type(reference));
        }
        let (plant, live) = self.ready()?;
        plant.count(live, role).ok_or_else(no_motion)
    }

    fn of_other_type(&self, reference: u32) -> Refusal {
        Refusal::error(format!("{} is of another type", self.name(reference)))
    }

    /// Sets a parameter or an input.
    pub fn set(&mut self, reference: u32, value: f64) -> Result<(), Refusal> {
        let role = self.role(reference)?;
        if !value.is_finite() {
            let name = self.name(reference);
            return Err(Refusal::error(format!("{name} cannot be {value}")));
        }
        match role {
            Role::Parameter(place) => {
                self.require(
                    &[Mode::Instantiated, Mode::Initialization],
                    "setting a parameter",
                )?;
                self.live.parameters[place] = value;
                // The motion must start again, in a plant with the new parameters.
                self.live.motion = None;
            }
            Role::Input(input) => {
                let modes = [Mode::Instantiated, Mode::Initialization, Mode::Step];
                self.require(&modes, "setting an input")?;
                self.live.inputs[input.place()] = value;
                self.live.rates[input.place()] = 0.0;
            }
            _ => {
                let name = self.name(reference);
                return Err(Refusal::error(format!("{name} cannot be set")));
            }
        }
        Ok(())
    }

    /// Sets the rate at which an input changes from its present value.
    pub fn set_rate(&mut self, reference: u32, order: c_int, value: f64) -> Result<(), Refusal> {
        let role = self.role(reference)?;
        let Role::Input(input) = role else {
            let name = self.name(reference);
            return Err(Refusal::error(format!("{name} is not an input")));
        };
        if order != 1 || !value.is_finite() {
            let name = self.name(reference);
            return Err(Refusal::error(format!(
                "derivative {order} of {name} cannot be {value}; only finite first derivatives are possible"
            )));
        }
        let modes = [Mode::Instantiated, Mode::Initialization, Mode::Step];
        self.require(&modes, "setting the rate of an input")?;
        self.live.rates[input.place()] = value;
        Ok(())
    }

    /// Time \[s\].
    pub fn time(&self) -> f64 {
        self.live.time
    }

    /// Advances from a time over a step of some length \[s\].
    pub fn step(&mut self, time: f64, length: f64) -> Result<(), Refusal> {
        self.require(&[Mode::Step], "a step")?;
        if !(length > 0.0 && length.is_finite()) {
            return Err(Refusal::error(format!("a step has the length {length}")));
        }
        let last_end = self.live.time;
        // `same` below is false for a NaN, which is therefore refused.
        let rounding = 4.0 * f64::EPSILON * time.abs();
        let tolerance =
            (SAME_TIME * length.max(time.abs())).min((PART_OF_STEP * length).max(rounding));
        let same = (time - last_end).abs() <= tolerance;
        if !same {
            return Err(Refusal::error(format!(
                "a step starts at time {time}, but the last one ended at {last_end}"
            )));
        }
        let Some((_, plant)) = &mut self.plant else {
            return Err(no_motion());
        };
        // Use the importer's time, because two separate sums of steps would drift apart.
        self.live.time = time;
        plant.step(&mut self.live, length).map_err(|stop| {
            self.live.time = last_end;
            Refusal::Discard(stop.to_string())
        })
    }

    /// State of the instance.
    pub fn state(&self) -> &LiveState {
        &self.live
    }

    /// Restores another state. Refuses it without any change if it belongs to another drive.
    pub fn set_state(&mut self, live: &LiveState) -> Result<(), Refusal> {
        let foreign = || Refusal::error("the state is of another drive");
        if live.parameters.len() != self.live.parameters.len() {
            return Err(foreign());
        }
        if let Some(motion) = &live.motion {
            let known = |entry: &&(Vec<f64>, Plant)| same_bits(&entry.0, &live.parameters);
            let built = match self.plant.as_ref().filter(known) {
                Some(_) => None,
                None => Some(self.build(&live.parameters)?),
            };
            let plant = built.as_ref().or(self.plant.as_ref());
            if !plant.is_some_and(|(_, plant)| plant.accepts(motion)) {
                return Err(foreign());
            }
            if built.is_some() {
                self.plant = built;
            }
        }
        self.live.copy(live);
        Ok(())
    }
}

/// Whether two lists of numbers have equal bits.
fn same_bits(a: &[f64], b: &[f64]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits())
}

fn no_motion() -> Refusal {
    Refusal::error("there is no motion yet")
}

/// The state after instantiation.
fn at_start(drive: &Drive) -> LiveState {
    let description = drive.description();
    LiveState {
        mode: Mode::Instantiated,
        parameters: description.parameters_at_start(),
        inputs: description.inputs_at_start(),
        rates: [0.0; INPUTS],
        time: 0.0,
        speed: 0.0,
        events: 0,
        motion: None,
    }
}
