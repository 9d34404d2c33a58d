//! Computes the outputs of an FMU from its state.
//!
//! Rotations, torques and bearing forces are sums over the components of the state. The omitted modes add
//! shares of loads and contact forces to the bearing forces.
//! A contact has the force `k (δ − s b) + c (δ' − s b')`, with rates of transmission errors and gaps at the
//! present speed.

use super::description::Role;
use super::inputs::Input;
use super::live::LiveState;
use crate::model::{ActiveSet, LOAD_TERMS, LoadTerm, Model, Segment};
use crate::propagate::varying_speed::Motion;
use crate::structure::ModalStructure;
use std::f64::consts::TAU;

/// A shaft whose rotation is an output.
#[derive(Debug)]
struct Shaft {
    /// Turns of the shaft per mesh cycle.
    turns: f64,
    /// Vibration of the shaft's rotation and of its speed, per unit of both components of each block.
    gains: [Vec<[f64; 2]>; 2],
}

/// Coefficients by which the outputs of a model follow from its state.
#[derive(Debug)]
pub struct Sensors {
    shafts: [Shaft; 2],
    /// Mesh cycles per radian of the pinion.
    cycles_per_radian: f64,
    /// Force of the omitted modes on every bearing, per unit of each load term.
    on_bearings: Vec<[f64; LOAD_TERMS]>,
}

impl Sensors {
    /// The outputs of a model of a structure.
    pub fn new(model: &Model, structure: &ModalStructure) -> Self {
        let shaft = |turns: f64, torque: &Option<Vec<f64>>| Shaft {
            turns,
            gains: model.block_gains_of(torque.as_deref().unwrap_or_default()),
        };
        let cycles_per_turn = structure.cycles_per_turn();
        let wheel = structure.wheel_teeth.map_or(f64::NAN, f64::from);
        Self {
            shafts: [
                shaft(1.0 / cycles_per_turn, &structure.pinion_torque),
                shaft(1.0 / wheel, &structure.wheel_torque),
            ],
            cycles_per_radian: cycles_per_turn / TAU,
            on_bearings: model.load_terms(structure).on_bearings,
        }
    }

    /// The value of an output that is a real number; NaN for other roles.
    pub fn value(&self, model: &Model, live: &LiveState, motion: &Motion, role: Role) -> f64 {
        let look = ModelView {
            model,
            motion,
            pace: live.speed * self.cycles_per_radian * model.period(),
        };
        match role {
            Role::Angle(shaft) => {
                let Shaft { turns, gains } = &self.shafts[shaft];
                let cycles = motion.cycle as f64 * turns;
                TAU * (cycles + motion.phase * turns) + look.sum(&gains[0])
            }
            Role::Speed(shaft) => {
                let Shaft { turns, gains } = &self.shafts[shaft];
                let mean = live.speed * TAU * self.cycles_per_radian * turns;
                mean + look.sum(&gains[1])
            }
            Role::Deflection(mesh) => look.deflection(model.meshes[mesh].flanks[0])[0],
            Role::Force(mesh) => {
                let force = |contact| model.meshes[mesh].sign(contact) * look.force(contact);
                look.closed(mesh).iter().map(force).sum()
            }
            Role::Bearing(bearing) => self.bearing(&look, live, bearing),
            Role::Torque(place) => look.sum(&model.outputs[place].gain),
            Role::Time | Role::Parameter(_) | Role::Input(_) | Role::Contact(_) | Role::Events => {
                f64::NAN
            }
        }
    }

    fn bearing(&self, look: &ModelView<'_>, live: &LiveState, bearing: usize) -> f64 {
        let gains = &look.model.bearings[bearing];
        let mut force = look.sum(&gains.gain);
        for (term, share) in self.on_bearings[bearing].iter().enumerate() {
            force += share * load_term(live, term);
        }
        for (ripple, share) in look.model.ripple.iter().zip(&gains.by_ripple) {
            force += share * ripple.phase_at(look.motion.cycle, look.time()).cos();
        }
        for contact in look.motion.contact.iter() {
            let shares = &look.model.directions[look.segment(contact).direction].on_bearings;
            if let Some(share) = shares.get(bearing).filter(|share| **share != 0.0) {
                force += share * look.force(contact);
            }
        }
        force
    }
}

/// The value of a load term, by its number in [`LoadTerm`].
fn load_term(live: &LiveState, term: usize) -> f64 {
    let input = |input: Input| live.inputs[input.place()];
    let is = |known: LoadTerm| known as usize == term;
    if is(LoadTerm::Rated) {
        input(Input::Load)
    } else if is(LoadTerm::Speed) {
        live.speed
    } else if is(LoadTerm::SpeedSquared) {
        live.speed * live.speed
    } else if is(LoadTerm::PinionTorque) {
        input(Input::Pinion)
    } else if is(LoadTerm::WheelTorque) {
        input(Input::Wheel)
    } else {
        1.0
    }
}

/// Which flanks of a mesh touch: 1 the drive flank, −1 the coast flank, 0 none, 2 both.
pub fn contact(model: &Model, motion: &Motion, mesh: usize) -> i64 {
    let [drive, coast] = model.meshes[mesh].flanks;
    let closed = motion.contact;
    let flanks = if drive == 0 {
        closed_flanks(model, closed)
    } else {
        [closed.holds(drive), closed.holds(coast)]
    };
    match flanks {
        [true, true] => 2,
        [true, false] => 1,
        [false, true] => -1,
        [false, false] => 0,
    }
}

/// Whether any spring of the drive flank of the first mesh is closed, and whether any spring of its coast
/// flank is. Contacts 0, 2, … are springs of the drive flank, contacts 1, 3, … springs of the coast flank.
fn closed_flanks(model: &Model, closed: ActiveSet) -> [bool; 2] {
    if model.flank_springs == 2 {
        return closed.flanks().closed();
    }
    [0, 1].map(|flank| {
        (flank..model.flank_springs)
            .step_by(2)
            .any(|contact| closed.holds(contact) && !model.is_of_film(contact))
    })
}

/// A model at an instant of its motion.
struct ModelView<'a> {
    model: &'a Model,
    motion: &'a Motion,
    /// Speed of the drive, divided by the speed of the model.
    pace: f64,
}

impl ModelView<'_> {
    /// Time within the mesh cycle at the model's speed \[s\].
    fn time(&self) -> f64 {
        self.motion.phase * self.model.period()
    }

    fn sum(&self, gains: &[[f64; 2]]) -> f64 {
        let (first, second) = self.motion.state.split_at(self.model.modes());
        let pairs = gains.iter().zip(first.iter().zip(second));
        pairs.map(|(gain, (x, y))| gain[0] * x + gain[1] * y).sum()
    }

    fn segment(&self, contact: usize) -> &Segment {
        self.model.contacts[contact]
            .cycle(self.motion.cycle)
            .segment_at(self.time())
    }

    /// Deflection along the line of a contact \[m\] and its rate \[m/s\].
    fn deflection(&self, contact: usize) -> [f64; 2] {
        let (segment, cycle) = (self.segment(contact), self.motion.cycle);
        let (deflection, rate) =
            self.model
                .deflection_on(segment, cycle, &self.motion.state, self.time());
        let line = &self.model.lines[self.model.line(segment)];
        let (_, error_rate) = line.transmission_error_at(cycle, self.time());
        [deflection, rate + (1.0 - self.pace) * error_rate]
    }

    /// Force of a closed contact \[N\].
    fn force(&self, contact: usize) -> f64 {
        let (contact_data, segment) = (&self.model.contacts[contact], self.segment(contact));
        let [deflection, rate] = self.deflection(contact);
        let [_, opening] = contact_data.gap(segment, self.time());
        // The contact assumes the gap's rate at the model's speed.
        let rate = rate + contact_data.side * (1.0 - self.pace) * opening;
        contact_data.force(segment, self.time(), deflection, rate)
    }

    /// The closed contacts of a mesh.
    fn closed(&self, mesh: usize) -> ActiveSet {
        let flanks = self.model.meshes[mesh].flanks;
        let closed = self.motion.contact;
        let of_mesh = |contact: usize| {
            if mesh == 0 { self.model.of_mesh(contact) } else { flanks.contains(&contact) }
        };
        let closed = closed.iter().filter(|contact| of_mesh(*contact));
        closed.fold(ActiveSet::FREE, ActiveSet::toggled)
    }
}
