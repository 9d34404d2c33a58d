//! How do the freedoms of a train deflect its contacts?
//!
//! A flank with the normal n at the pitch point P, between both gears, has the deflection
//! `δ = n·(u₁ + θ₁ × (P − O₁)) − n·(u₂ + θ₂ × (P − O₂))`, with the middles O of the gears. n is a unit vector
//! in the transverse section. Flanks of helical gears add `∓tan β_b` along the axis of the first gear, minus
//! if that is right-handed and rotates forwards. For a load off mid-face P moves along the pitch line, for a
//! pair off the pitch point along n. Friction acts on the first gear along `cos α m − sin α t`, on coast
//! flanks along `−cos α m − sin α t`, and in the opposite direction on the second.

use super::axes::{Axis, PitchPoint};
use super::nodes::Assembled;
use super::speeds::{Layout, sense};
use super::{GearPlace, TrainDrive};
use crate::shaft::assembly::{AssembledMatrices, Freedom};
use crate::structure::ModalStructure;
use nalgebra::Vector3;

/// A sum of freedoms: node, freedom, coefficient.
pub(super) type Terms = Vec<(usize, Freedom, f64)>;

const DISPLACEMENTS: [Freedom; 3] = [Freedom::X, Freedom::Y, Freedom::Z];
const ROTATIONS: [Freedom; 3] = [Freedom::RotationX, Freedom::RotationY, Freedom::RotationZ];

/// Motions at the flanks of one side, as sums of freedoms; see
/// [`FlankParticipation`](crate::structure::FlankParticipation).
#[derive(Debug)]
pub(super) struct FlankTerms {
    pub mesh: Terms,
    pub tilt: Terms,
    pub friction: Terms,
    pub lever: Terms,
}

/// One gear of a mesh.
#[derive(Debug)]
struct Side {
    node: usize,
    axis: Axis,
    centre: Vector3<f64>,
    /// 1 for the first gear, −1 for the second.
    sign: f64,
}

impl Side {
    fn terms(&self, freedoms: [Freedom; 3], vector: Vector3<f64>, out: &mut Terms) {
        for (freedom, value) in freedoms.into_iter().zip(self.axis.local(vector)) {
            if value != 0.0 {
                out.push((self.node, freedom, self.sign * value));
            }
        }
    }
}

/// Relative motion of both sides along a direction at a point.
fn along(sides: &[Side; 2], point: Vector3<f64>, direction: Vector3<f64>) -> Terms {
    let mut out = Terms::new();
    for side in sides {
        side.terms(DISPLACEMENTS, direction, &mut out);
        side.terms(ROTATIONS, (point - side.centre).cross(&direction), &mut out);
    }
    out
}

/// Derivative of the relative motion of both sides along `direction` as the point moves by `step`.
fn moved(sides: &[Side; 2], step: Vector3<f64>, direction: Vector3<f64>) -> Terms {
    let mut out = Terms::new();
    for side in sides {
        side.terms(ROTATIONS, step.cross(&direction), &mut out);
    }
    out
}

impl TrainDrive {
    /// The drive flanks and the coast flanks of a mesh, both with the sign of the drive flanks'
    /// deflection.
    pub(super) fn flanks(
        &self,
        gears: [GearPlace; 2],
        (pitch_point, pressure_angle): (&PitchPoint, f64),
        layout: &Layout,
        assembled: &Assembled,
    ) -> [FlankTerms; 2] {
        let sides = [0, 1].map(|index| {
            let place = gears[index];
            let axis = layout.axes[place.shaft];
            Side {
                node: assembled.gear(self, place),
                axis,
                centre: axis.at(self.gear(place).at),
                sign: [1.0, -1.0][index],
            }
        });
        // The first gear rotates towards its drive flanks.
        let sense = match layout.mesh_speeds[self.body_of(gears[0])] {
            speed if speed < 0.0 => -1.0,
            _ => 1.0,
        };
        let forward = pitch_point.forward * sense;
        let (sin, cos) = pressure_angle.sin_cos();
        // The deflection is measured in the transverse section. There the flanks' normal is a unit vector,
        // and `thrust` is the additional axial part.
        let helix = self.gear(gears[0]).base_helix_angle().tan();
        let thrust = sides[0].axis.along() * (-sense * helix);
        [1.0, -1.0].map(|lean| {
            let normal = forward * cos + pitch_point.across * (lean * sin);
            let tangent = pitch_point.across * (lean * cos) - forward * sin;
            FlankTerms {
                mesh: along(&sides, pitch_point.point, normal + thrust),
                tilt: moved(&sides, pitch_point.pitch_line, normal),
                friction: along(&sides, pitch_point.point, tangent),
                lever: moved(&sides, normal, tangent),
            }
        })
    }

    /// Loads whose work is the tilt of the flanks of every mesh, in the order of the first flanks and the contacts of
    /// the structure. `first` are the flanks of the first mesh.
    pub(super) fn tilt_loads(
        &self,
        first: &[FlankTerms; 2],
        layout: &Layout,
        assembled: &Assembled,
        matrices: &AssembledMatrices,
    ) -> Vec<Vec<f64>> {
        let mut loads: Vec<Vec<f64>> = first
            .iter()
            .map(|flank| matrices.functional(&flank.tilt))
            .collect();
        for (mesh, pitch_point) in self.meshes.iter().zip(&layout.meshes[1..]) {
            let place = (pitch_point, mesh.pressure_angle);
            let [drive, coast] = self.flanks(mesh.gears, place, layout, assembled);
            loads.push(matrices.functional(&drive.tilt));
            // The deflection of a contact of coast flanks has the opposite sign.
            let opposite = matrices
                .functional(&coast.tilt)
                .into_iter()
                .map(|part| -part);
            loads.push(opposite.collect());
        }
        loads
    }

    /// Twist of a coupling, first shaft relative to the second, in the direction of rotation.
    pub(super) fn twist(&self, coupling: usize, layout: &Layout, assembled: &Assembled) -> Terms {
        let coupling = &self.couplings[coupling];
        let sense = sense(layout.speeds[coupling.shafts[0]]);
        let end = |end: usize| assembled.at(coupling.shafts[end], coupling.at[end]);
        vec![
            (end(0), Freedom::RotationZ, sense),
            (end(1), Freedom::RotationZ, -sense),
        ]
    }

    /// Motion of a shaft towards a stop.
    pub(super) fn approach(&self, stop: usize, assembled: &Assembled) -> Terms {
        let stop = &self.stops[stop];
        let node = assembled.at(stop.shaft, stop.at);
        let towards = Vector3::from(stop.direction).normalize();
        (DISPLACEMENTS.into_iter().zip(towards.iter()))
            .filter(|(_, part)| **part != 0.0)
            .map(|(freedom, part)| (node, freedom, *part))
            .collect()
    }
}

/// Static tilt of every flank beyond the computed modes, as [`ModalStructure::tilt_residuals`]. The columns of
/// `structure` have the deflections under the tilt loads from `first` on.
pub(super) fn tilt_residuals(structure: &ModalStructure, first: usize) -> Vec<[f64; 2]> {
    (structure.tilt_columns().enumerate())
        .map(|(flank, [mesh, tilt])| {
            let under_load = |column: &[f64]| column.get(first + flank).copied().unwrap_or(0.0);
            if tilt.is_empty() { [0.0; 2] } else { [mesh, tilt].map(under_load) }
        })
        .collect()
}
