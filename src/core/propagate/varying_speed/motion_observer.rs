//! What can an observer see of a motion with varying speed?

use super::VaryingSpeed;
use super::powers::{Course, Powers, value};
use super::rows::Rows;
use super::window::{WindowSeries, along, states_at};
use crate::model::{ActiveSet, DRIVE_FLANK, LOAD_TERMS, Model, Quantity};
use crate::propagate::vectors::Aligned;

/// A window of the motion. Series are in u from 0 to `part`.
#[derive(Debug, Clone, Copy)]
pub struct VaryingSpeedWindow<'a> {
    pub(super) kernel: &'a VaryingSpeed,
    pub(super) motions: &'a WindowSeries,
    /// Time at its start \[s\].
    pub time: f64,
    /// Its length \[s\].
    pub duration: f64,
    /// The last u: 1, or less if an event ends the window.
    pub part: f64,
    /// Mesh cycle.
    pub cycle: u64,
    /// Mesh phase at its start.
    pub phase: f64,
    /// Mesh cycles since the start, by powers of u.
    pub cycles: Course,
    /// Every load term, by powers of u.
    pub loads: [Course; LOAD_TERMS],
    /// The closed contacts.
    pub contact: ActiveSet,
}

impl VaryingSpeedWindow<'_> {
    /// Force of a contact \[N\]; `None` if it is open.
    pub fn force(&self, contact: usize) -> Option<&Powers> {
        let closed = self.motions.closed.iter();
        let mut pairs = closed.zip(&self.motions.forces);
        pairs
            .find(|(closed, _)| closed.contact == contact)
            .map(|(_, force)| force)
    }

    /// Deflection along the line of a contact \[m\].
    pub fn deflection(&self, contact: usize) -> &Powers {
        &self.motions.deflections[self.motions.line_of[contact]]
    }

    /// Moves `instant` to a position in the window. Computes the states of the blocks only if they are read.
    pub fn evaluate_at(&self, place: f64, reads_states: bool, instant: &mut Instant) {
        instant.place = place;
        if !reads_states {
            return;
        }
        let padded = self.kernel.system.padded;
        let Instant { states, rates, .. } = instant;
        states_at(
            self.kernel.instructions,
            place,
            padded,
            &self.motions.components,
            states,
            rates,
        );
        let scale = self.part / self.duration;
        rates
            .iter_mut()
            .flat_map(|own| own.iter_mut())
            .for_each(|rate| *rate *= scale);
    }

    /// Sum of the forces of some contacts at a position \[N\].
    fn sum_of_forces(&self, contacts: impl Iterator<Item = usize>, place: f64) -> f64 {
        contacts
            .filter_map(|contact| self.force(contact))
            .map(|force| value(force, place))
            .sum()
    }

    /// Static force of omitted modes on a bearing \[N\].
    fn left_out(&self, index: usize, place: f64) -> f64 {
        let kernel = self.kernel;
        let shares = kernel.on_bearings[index].iter().zip(&self.loads);
        let loads: f64 = shares
            .map(|(share, course)| share * value(course, place))
            .sum();
        let ripples = (self.motions.ripples.iter()).zip(&kernel.model.bearings[index].by_ripple);
        let ripples: f64 = ripples
            .map(|(ripple, share)| share * value(ripple, place))
            .sum();
        let closed = self.motions.closed.iter().zip(&self.motions.forces);
        let forces: f64 = closed
            .filter_map(|(closed, force)| {
                let shares = &kernel.model.directions[closed.direction].on_bearings;
                Some(shares.get(index)? * value(force, place))
            })
            .sum();
        loads + ripples + forces
    }
}

/// The blocks at a position in a window.
#[derive(Debug, Clone)]
pub struct Instant {
    place: f64,
    states: [Aligned; 2],
    rates: [Aligned; 2],
}

impl Instant {
    /// Allocates an instant.
    pub fn new(kernel: &VaryingSpeed) -> Self {
        let room = || [0, 1].map(|_| Aligned::zeros(kernel.system.padded));
        Self {
            place: 0.0,
            states: room(),
            rates: room(),
        }
    }
}

/// A contact opens or closes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MovingEvent {
    /// Time \[s\].
    pub time: f64,
    /// Mesh cycle.
    pub cycle: u64,
    /// Mesh phase.
    pub phase: f64,
    /// Mesh cycles per second.
    pub speed: f64,
    /// The closed contacts before the event.
    pub from: ActiveSet,
    /// The closed contacts after the event.
    pub to: ActiveSet,
    /// The contact that opens or closes.
    pub contact: usize,
    /// Rate of its deflection relative to its surface \[m/s\].
    pub rate: f64,
}

/// Observes a motion.
pub trait MotionObserver {
    /// Called after a window.
    fn window(&mut self, _window: &VaryingSpeedWindow<'_>) {}

    /// Called at an event.
    fn event(&mut self, _event: &MovingEvent) {}
}

/// No observer.
impl MotionObserver for () {}

/// A signal of a motion, and how it is computed on a window.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MovingSignal {
    /// The quantity.
    pub quantity: Quantity,
    /// Its position and direction; for a mesh, its gears.
    pub name: String,
    place: SignalSource,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum SignalSource {
    Deflection(usize),
    /// Of a mesh, as an index of the model's meshes.
    Force(usize),
    Bearing(usize),
    Output(usize),
}

impl MovingSignal {
    /// All signals of a model: force and deflection of every mesh, forces on bearings, other outputs.
    pub fn of_model(model: &Model) -> Vec<Self> {
        let signal = |quantity, name: &str, place| Self {
            quantity,
            name: name.to_owned(),
            place,
        };
        let meshes = model.meshes.iter().enumerate().flat_map(|(index, mesh)| {
            [
                signal(Quantity::MeshForce, &mesh.name, SignalSource::Force(index)),
                signal(
                    Quantity::MeshDeflection,
                    &mesh.name,
                    SignalSource::Deflection(mesh.flanks[0]),
                ),
            ]
        });
        let bearings = (model.bearings.iter().enumerate()).map(|(index, bearing)| {
            signal(
                Quantity::BearingForce,
                &bearing.name,
                SignalSource::Bearing(index),
            )
        });
        let outputs = (model.outputs.iter().enumerate()).map(|(index, output)| {
            signal(output.quantity, &output.name, SignalSource::Output(index))
        });
        meshes.chain(bearings).chain(outputs).collect()
    }

    /// Whether it is the deflection of the first mesh (`true`) or its force (`false`); `None` for other signals.
    pub fn first_mesh(&self) -> Option<bool> {
        match self.place {
            SignalSource::Deflection(DRIVE_FLANK) => Some(true),
            SignalSource::Force(0) => Some(false),
            _ => None,
        }
    }

    /// Its name in tables (`deflection`, `force`, or the quantity with its position) and its unit.
    pub fn named(&self) -> [String; 2] {
        let name = match self.first_mesh() {
            Some(true) => "deflection".to_owned(),
            Some(false) => "force".to_owned(),
            None => format!("{} {}", self.quantity.name(), self.name),
        };
        [name, self.quantity.unit().to_owned()]
    }

    /// Whether its value needs the states of the blocks. Deflections and forces of contacts are known as series.
    pub fn reads_states(&self) -> bool {
        matches!(
            self.place,
            SignalSource::Bearing(_) | SignalSource::Output(_)
        )
    }

    /// Its value at an instant of a window.
    pub fn value(&self, window: &VaryingSpeedWindow<'_>, instant: &Instant) -> f64 {
        let (kernel, place) = (window.kernel, instant.place);
        let sum = |rows: &Rows, states: &[Aligned; 2]| along(kernel.instructions, rows, states);
        match self.place {
            SignalSource::Deflection(contact) => value(window.deflection(contact), place),
            SignalSource::Force(0) => window.sum_of_forces(0..kernel.model.flank_springs, place),
            SignalSource::Force(index) => {
                let mesh = &kernel.model.meshes[index];
                let of = |&flank: &usize| {
                    mesh.sign(flank) * window.sum_of_forces(std::iter::once(flank), place)
                };
                mesh.flanks.iter().map(of).sum()
            }
            SignalSource::Bearing(index) => {
                sum(&kernel.bearings[index], &instant.states) + window.left_out(index, place)
            }
            SignalSource::Output(index) if kernel.model.outputs[index].quantity.is_rate() => {
                sum(&kernel.outputs[index], &instant.rates)
            }
            SignalSource::Output(index) => sum(&kernel.outputs[index], &instant.states),
        }
    }
}
