//! Steps the drive of an FMU.
//!
//! The mean rotation θ is that of a rigid body. The torques on the shafts accelerate it, `θ'' = α(t)`; no
//! mesh force acts on it. Torques are constant or linear in time over a step. θ is then a cubic polynomial,
//! known before the step, and the mesh phase follows it.

use super::FmuError;
use super::description::Role;
use super::inputs::Input;
use super::live::{LiveState, copy};
use super::sensors::{Sensors, contact};
use crate::manifest::PointSpec;
use crate::model::Model;
use crate::propagate::varying_speed::{Motion, SpeedInterval, VaryingSpeed, Workspace};
use crate::propagate::{Counters, InstructionSet, Stop};
use crate::structure::ModalStructure;

/// A drive that can be stepped, with its workspace.
#[derive(Debug)]
pub struct Plant {
    kernel: VaryingSpeed,
    sensors: Sensors,
    workspace: Workspace,
    start: Motion,
    /// Mean speed of the pinion at the start \[rad/s\].
    speed: f64,
    /// Copy of the motion before the step, restored if the step fails.
    before: Motion,
}

impl Plant {
    /// Prepares the drive of a point for steps, from its structure and model.
    ///
    /// # Errors
    /// Torques do not turn it, or it cannot be integrated at varying speed.
    pub(super) fn new(
        point: &PointSpec,
        structure: &ModalStructure,
        model: &Model,
        set: InstructionSet,
    ) -> Result<Self, FmuError> {
        let kernel = VaryingSpeed::new(structure, model, point.run.event_limit, set)?;
        kernel.mean_acceleration([0.0; 2]).ok_or(FmuError::Held)?;
        let start = kernel.start(&model.start(&point.run.initial));
        Ok(Self {
            sensors: Sensors::new(model, structure),
            workspace: kernel.workspace(),
            before: start.clone(),
            start,
            speed: point.speed,
            kernel,
        })
    }

    /// Sets a state to the start of the motion.
    pub fn begin(&self, live: &mut LiveState) {
        live.motion = Some(self.start.clone());
        live.speed = self.speed;
        live.events = 0;
    }

    /// Whether a motion can belong to this drive.
    pub fn accepts(&self, motion: &Motion) -> bool {
        let contacts = self.kernel.model().contacts.len();
        motion.state.len() == self.start.state.len()
            && motion.state.iter().all(|number| number.is_finite())
            && (0.0..1.0).contains(&motion.phase)
            && motion.contact.iter().all(|contact| contact < contacts)
    }

    /// Steps a state by `length` \[s\] without allocation. A state without a motion, or a failed step, changes nothing.
    ///
    /// # Errors
    /// The drive comes to rest, its motion diverges, or more events fall in a mesh cycle than are allowed.
    pub fn step(&mut self, live: &mut LiveState, length: f64) -> Result<(), Stop> {
        let Some(motion) = &mut live.motion else {
            return Ok(());
        };
        copy(&mut self.before, motion);
        let input_at =
            |input: Input, time: f64| live.inputs[input.place()] + time * live.rates[input.place()];
        let acceleration = |time: f64| {
            let torques = [Input::Pinion, Input::Wheel].map(|input| input_at(input, time));
            // `new` has checked that the drive turns freely.
            self.kernel.mean_acceleration(torques).unwrap_or_default()
        };
        let first = acceleration(0.0);
        let growth = acceleration(length) - first;
        let mut stretch = SpeedInterval::steady(length, live.speed, 0.0);
        stretch.rotation[2] = 0.5 * first;
        stretch.rotation[3] = growth / length / 6.0;
        let mut counters = Counters::default();
        let [load, pinion, wheel] = [Input::Load, Input::Pinion, Input::Wheel];
        let [torque, reaction] = &mut stretch.torques;
        for (course, input) in [
            (&mut stretch.load, load),
            (torque, pinion),
            (reaction, wheel),
        ] {
            (course[0], course[1]) = (live.inputs[input.place()], live.rates[input.place()]);
        }
        motion.time = live.time;
        if let Err(stop) = self.kernel.advance(
            motion,
            &stretch,
            &mut self.workspace,
            &mut (),
            &mut counters,
        ) {
            copy(motion, &self.before);
            return Err(stop);
        }
        live.speed += length * (first + 0.5 * growth);
        live.inputs = Input::ALL.map(|input| input_at(input, length));
        live.time += length;
        live.events += counters.events;
        Ok(())
    }

    /// The value of an output that is a real number, NaN for other roles; `None` if the state has no motion yet.
    pub fn value(&self, live: &LiveState, role: Role) -> Option<f64> {
        let motion = live.motion.as_ref()?;
        Some(self.sensors.value(self.kernel.model(), live, motion, role))
    }

    /// The value of an output that is a whole number; `None` for other outputs, or if the state has no motion
    /// yet.
    pub fn count(&self, live: &LiveState, role: Role) -> Option<i64> {
        let motion = live.motion.as_ref()?;
        match role {
            Role::Events => Some(i64::try_from(live.events).unwrap_or(i64::MAX)),
            Role::Contact(mesh) => Some(contact(self.kernel.model(), motion, mesh)),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fmu::{Drive, Mode};
    use crate::manifest::ManifestText;
    use crate::model::Quantity;
    use crate::propagate::varying_speed::{
        Instant, MotionObserver, MovingSignal, VaryingSpeedWindow,
    };
    use crate::store::TableStore;
    use std::path::Path;

    /// Quickstart with a ripple and with omitted modes that add to the static forces on bearings.
    fn drive() -> Drive {
        let text = include_str!("../../../manifests/quickstart.toml");
        let changes = [
            "model.retained=9".to_owned(),
            "model.mta=true".to_owned(),
            "excitation.torque_ripple=[{ shaft = \"wheel\", order = 3, amplitude = 2 }]".to_owned(),
        ];
        let changes = &changes;
        let job = ManifestText { text, changes }.job("m.toml", Path::new(""));
        let job = job.unwrap();
        let point = job.points.at(0);
        Drive::new(job, point, TableStore::in_memory()).unwrap()
    }

    fn begun(drive: &Drive, plant: &Plant) -> LiveState {
        let description = drive.description();
        let mut live = LiveState {
            mode: Mode::Step,
            parameters: description.parameters_at_start(),
            inputs: description.inputs_at_start(),
            rates: [0.0; 3],
            time: 0.0,
            speed: 0.0,
            events: 0,
            motion: None,
        };
        plant.begin(&mut live);
        live
    }

    /// The signals at the end of the last window.
    struct Last {
        signals: Vec<MovingSignal>,
        instant: Instant,
        values: Vec<f64>,
    }

    impl MotionObserver for Last {
        fn window(&mut self, window: &VaryingSpeedWindow<'_>) {
            window.evaluate_at(window.part, true, &mut self.instant);
            let values = self
                .signals
                .iter()
                .map(|signal| signal.value(window, &self.instant));
            self.values = values.collect();
        }
    }

    /// Outputs of a state equal the kernel's signals at the end of its window.
    #[test]
    fn outputs_are_those_of_the_kernel() {
        let drive = drive();
        let mut plant = drive
            .plant(&drive.description().parameters_at_start())
            .unwrap();
        let mut live = begun(&drive, &plant);
        let kernel = plant.kernel.clone();
        let (mut workspace, mut counters) = (kernel.workspace(), Counters::default());
        let mut last = Last {
            signals: MovingSignal::of_model(kernel.model()),
            instant: Instant::new(&kernel),
            values: Vec::new(),
        };
        let role = |quantity, place| match quantity {
            Quantity::MeshForce => Some(Role::Force(place)),
            Quantity::MeshDeflection => Some(Role::Deflection(place)),
            Quantity::BearingForce => Some(Role::Bearing(place)),
            Quantity::Torque => Some(Role::Torque(place)),
            _ => None,
        };
        (live.inputs, live.rates) = ([9.0, -7.0, 0.05], [150.0, 20.0, 0.3]);
        let (length, mut compared, mut touching) = (1.1e-4, 0, 0);
        for _ in 0..400 {
            let mut motion = live.motion.clone().unwrap();
            let before = (live.inputs, live.speed);
            plant.step(&mut live, length).unwrap();
            // The torque is linear in time, so the rotation is a cubic polynomial.
            let mut stretch = SpeedInterval::steady(length, before.1, before.0[2]);
            let at = |inputs: [f64; 3]| kernel.mean_acceleration([inputs[0], inputs[1]]).unwrap();
            let [first, end] = [at(before.0), at(live.inputs)];
            stretch.rotation[2] = 0.5 * first;
            stretch.rotation[3] = (end - first) / (6.0 * length);
            stretch.load[1] = live.rates[2];
            for shaft in 0..2 {
                (stretch.torques[shaft][0], stretch.torques[shaft][1]) =
                    (before.0[shaft], live.rates[shaft]);
            }
            (kernel.advance(
                &mut motion,
                &stretch,
                &mut workspace,
                &mut last,
                &mut counters,
            ))
            .unwrap();
            assert_eq!(motion.cycle, live.motion.as_ref().unwrap().cycle);
            touching += u32::from(motion.contact.touching());
            let mut places = std::collections::HashMap::new();
            for (signal, exact) in last.signals.iter().zip(&last.values) {
                let place = places.entry(signal.quantity.name()).or_insert(0);
                if let Some(role) = role(signal.quantity, *place) {
                    let found = plant.value(&live, role).unwrap();
                    let scale = match role {
                        Role::Deflection(_) => 1e-5,
                        Role::Torque(_) => 10.0,
                        _ => 1000.0,
                    };
                    let error = (found - exact).abs();
                    assert!(error < 1e-8 * scale, "{role:?}: {found} {exact}");
                    compared += 1;
                }
                *place += 1;
            }
        }
        assert!(
            compared > 4000 && live.events > 100,
            "{compared} {}",
            live.events
        );
        assert!((50..350).contains(&touching), "{touching}");
        assert!(live.speed > 640.0, "{}", live.speed);
    }

    #[test]
    fn a_step_that_fails_changes_nothing() {
        let drive = drive();
        let mut plant = drive
            .plant(&drive.description().parameters_at_start())
            .unwrap();
        let mut live = begun(&drive, &plant);
        plant.step(&mut live, 1e-3).unwrap();
        live.inputs[0] = -1e5;
        let before = live.clone();
        let stop = plant.step(&mut live, 0.1).unwrap_err();
        assert!(matches!(stop, Stop::Backwards { .. }), "{stop}");
        let (motion, kept) = (
            live.motion.as_ref().unwrap(),
            before.motion.as_ref().unwrap(),
        );
        assert_eq!(
            (motion, live.speed, live.inputs),
            (kept, before.speed, before.inputs)
        );
    }

    /// A gear pair takes its load as torques on both shafts. Start values come from the manifest.
    #[test]
    fn variables_are_those_of_the_manifest() {
        let drive = drive();
        let description = drive.description();
        let [pinion, wheel, load] = description.inputs_at_start();
        assert!((pinion - 5.0).abs() < 1e-8 && (wheel + 7.5).abs() < 1e-8 && load == 0.0);
        let start = |name: &str| {
            let own = description
                .variables
                .iter()
                .find(|variable| variable.name == name);
            own.and_then(|own| own.start)
        };
        assert_eq!(start("start.load"), Some(0.1));
        assert_eq!(start("mesh.half_gap"), Some(1e-5));
        assert_eq!(
            start("excitation.transmission_error[0].amplitude"),
            Some(5e-6)
        );
        assert_eq!(start("mesh.force"), None);
        // Torques act on bearings at once through the omitted modes.
        let feeds = |name: &str| {
            description
                .variables
                .iter()
                .any(|variable| variable.name == name && variable.feeds_through)
        };
        assert!(feeds("bearing.'pinion 1 y'") && !feeds("mesh.force"));
    }
}
