//! What a motion of varying speed shows of itself.

use super::VaryingSpeed;
use super::powers::{Course, Powers};
use super::window::{Motions, seen_along};
use crate::model::{ActiveSet, COAST_FLANK, DRIVE_FLANK, LOAD_TERMS, Model, Quantity};
use crate::propagate::vectors::TERMS;

/// A window of the motion. Series are in `u = t/duration`.
#[derive(Debug, Clone, Copy)]
pub struct MovingWindow<'a> {
    pub(super) kernel: &'a VaryingSpeed,
    pub(super) motions: &'a Motions,
    /// Time at its start \[s\].
    pub time: f64,
    /// Its length \[s\].
    pub duration: f64,
    /// How much of its series is the window: 1, or less where an event ends it; u runs up to there.
    pub part: f64,
    /// Mesh cycle.
    pub cycle: u64,
    /// Mesh phase at its start.
    pub phase: f64,
    /// Mesh cycles that pass from there on, by powers of u.
    pub cycles: Course,
    /// What each load term is, by powers of u.
    pub loads: [Course; LOAD_TERMS],
    /// The closed contacts.
    pub contact: ActiveSet,
}

impl MovingWindow<'_> {
    /// Force of a contact \[N\]; none where it is open.
    pub fn force(&self, contact: usize) -> Option<&Powers> {
        let closed = self.motions.closed.iter();
        let mut pairs = closed.zip(&self.motions.forces);
        pairs
            .find(|(closed, _)| closed.contact == contact)
            .map(|(_, force)| force)
    }

    /// Deflection along the line of a contact \[m\].
    pub fn deflection(&self, contact: usize) -> &Powers {
        &self.motions.deflections[self.kernel.line_of(contact, self.motions)]
    }

    /// Force of the first mesh \[N\]: positive on its drive flank, negative on its coast flank.
    pub fn mesh_force(&self) -> Powers {
        let springs = 0..self.kernel.model.flank_springs;
        self.sum_of_forces(springs)
    }

    fn sum_of_forces(&self, contacts: impl Iterator<Item = usize>) -> Powers {
        let mut sum = [0.0; TERMS];
        for force in contacts.filter_map(|contact| self.force(contact)) {
            for (sum, f) in sum.iter_mut().zip(force) {
                *sum += f;
            }
        }
        sum
    }

    /// An output of the model, by its place among these.
    pub fn output(&self, index: usize) -> Powers {
        let mut out = [0.0; TERMS];
        let rows = self.kernel.outputs[index].each_ref().map(|row| &row[..]);
        seen_along(
            self.kernel.instructions,
            rows,
            &self.motions.components,
            &mut out,
        );
        if self.kernel.model.outputs[index].quantity.is_rate() {
            for j in 0..TERMS {
                let next = out.get(j + 1).copied().unwrap_or(0.0);
                out[j] = (j + 1) as f64 / self.duration * self.part * next;
            }
        }
        out
    }

    /// Force on a bearing \[N\], by its place among the model's.
    pub fn bearing(&self, index: usize) -> Powers {
        let kernel = self.kernel;
        let mut out = [0.0; TERMS];
        let rows = kernel.bearings[index].each_ref().map(|row| &row[..]);
        seen_along(
            kernel.instructions,
            rows,
            &self.motions.components,
            &mut out,
        );
        for (course, share) in self.loads.iter().zip(kernel.on_bearings[index]) {
            for (sum, a) in out.iter_mut().zip(course) {
                *sum += share * a;
            }
        }
        for (ripple, share) in self
            .motions
            .ripples
            .iter()
            .zip(&kernel.model.bearings[index].by_ripple)
        {
            for (sum, a) in out.iter_mut().zip(ripple) {
                *sum += share * a;
            }
        }
        for (closed, force) in self.motions.closed.iter().zip(&self.motions.forces) {
            let shares = &kernel.model.directions[closed.direction].on_bearings;
            if let Some(share) = shares.get(index) {
                for (sum, f) in out.iter_mut().zip(force) {
                    *sum += share * f;
                }
            }
        }
        out
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
    /// Mesh cycles a second.
    pub speed: f64,
    /// The contacts that are closed before.
    pub from: ActiveSet,
    /// The contacts that are closed after.
    pub to: ActiveSet,
    /// The one that opens or closes.
    pub contact: usize,
    /// Rate of its deflection against its surface \[m/s\].
    pub rate: f64,
}

/// Watches a motion.
pub trait Watch {
    /// A window was passed.
    fn window(&mut self, _window: &MovingWindow<'_>) {}

    /// A contact opened or closed.
    fn event(&mut self, _event: &MovingEvent) {}
}

/// Nobody watches.
impl Watch for () {}

/// A signal of a motion: what it is, and where it stands on a window.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MovingSignal {
    /// What it is.
    pub quantity: Quantity,
    /// Its place and direction; of a mesh its gears.
    pub name: String,
    place: Place,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Place {
    Deflection(usize),
    Force([usize; 2]),
    FirstForce,
    Bearing(usize),
    Output(usize),
}

impl MovingSignal {
    /// All signals of a model: force and deflection of every mesh, forces on bearings, other outputs.
    pub fn of_model(model: &Model) -> Vec<Self> {
        let own = |quantity, name: &str, place| Self {
            quantity,
            name: name.to_owned(),
            place,
        };
        let meshes = model.meshes.iter().flat_map(|mesh| {
            let force = match mesh.flanks {
                [DRIVE_FLANK, COAST_FLANK] => Place::FirstForce,
                flanks => Place::Force(flanks),
            };
            [
                own(Quantity::MeshForce, &mesh.name, force),
                own(
                    Quantity::MeshDeflection,
                    &mesh.name,
                    Place::Deflection(mesh.flanks[0]),
                ),
            ]
        });
        let bearings = (model.bearings.iter().enumerate()).map(|(index, bearing)| {
            own(Quantity::BearingForce, &bearing.name, Place::Bearing(index))
        });
        let outputs = (model.outputs.iter().enumerate())
            .map(|(index, output)| own(output.quantity, &output.name, Place::Output(index)));
        meshes.chain(bearings).chain(outputs).collect()
    }

    /// Whether it is the deflection of the first mesh, or its force; none of all else.
    pub fn first_mesh(&self) -> Option<bool> {
        match self.place {
            Place::Deflection(DRIVE_FLANK) => Some(true),
            Place::FirstForce => Some(false),
            _ => None,
        }
    }

    /// Its name in tables, `deflection`, `force` or the quantity with its place, and its unit.
    pub fn named(&self) -> [String; 2] {
        let name = match self.first_mesh() {
            Some(true) => "deflection".to_owned(),
            Some(false) => "force".to_owned(),
            None => format!("{} {}", self.quantity.name(), self.name),
        };
        [name, self.quantity.unit().to_owned()]
    }

    /// Its series on a window.
    pub fn on(&self, window: &MovingWindow<'_>) -> Powers {
        match self.place {
            Place::Deflection(contact) => *window.deflection(contact),
            Place::Force(flanks) => window.sum_of_forces(flanks.into_iter()),
            Place::FirstForce => window.mesh_force(),
            Place::Bearing(index) => window.bearing(index),
            Place::Output(index) => window.output(index),
        }
    }
}
