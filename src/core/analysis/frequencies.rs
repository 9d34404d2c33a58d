//! Natural frequencies of the structure, with all contacts open, and with those contacts closed that carry
//! the static load.
//!
//! With open contacts every block has a pair of eigenvalues `−ζω ± ω√(ζ² − 1)`, also if the modes are
//! coupled. Dry sliders stick in small vibrations. Their springs therefore count as closed contacts, also in
//! the modes with open contacts. With contacts j closed by springs k_j and dampers c_j along w_j, the modes
//! are the undamped modes of
//!
//! ```text
//! (K + Σ k w wᵀ) φ = ω² φ,      φᵀ φ = 1,      2ζω = φᵀ (C + Σ c w wᵀ) φ
//! ```
//!
//! with the symmetric parts of K and C. Gyroscopic terms, cross-coupled springs and friction are omitted
//! because they shift the modes little. `Σ k (wᵀφ)²/ω²` is the part of a mode's elastic energy in the
//! contacts. If the static load closes no contact, the drive flanks count as closed, or the first contact of
//! an oscillator.

use crate::model::{ActiveSet, Block, DRIVE_FLANK, Model};
use crate::numerics::linalg::symmetric_eigen;
use faer::Mat;

/// A mode, given by its pair of eigenvalues `λ, λ'`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NaturalMode {
    /// Natural frequency `ω = √(λ λ')` \[rad/s\]; 0 for a rigid motion.
    pub frequency: f64,
    /// Decay `ζω = −(λ + λ')/2` \[1/s\]; negative if the motion grows.
    pub decay: f64,
}

impl NaturalMode {
    /// Damping ratio ζ; `None` for a rigid motion.
    pub fn ratio(&self) -> Option<f64> {
        (self.frequency > 0.0).then(|| self.decay / self.frequency)
    }
}

/// Largest squared frequency that counts as round-off of zero, relative to the largest squared frequency.
const RIGID: f64 = 1e-13;

/// A mode with closed contacts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClosedMode {
    /// Frequency and decay.
    pub mode: NaturalMode,
    /// Part of the mode's elastic energy that the closed contacts store.
    pub mesh_share: f64,
}

/// Modes of a structure, in ascending frequency.
#[derive(Debug, Clone, PartialEq)]
pub struct Frequencies {
    /// Modes with all contacts open, and dry sliders stuck.
    pub open: Vec<NaturalMode>,
    /// Modes with [`Self::contacts`] closed at their mean stiffness; empty if the eigenvalues are not found.
    pub closed: Vec<ClosedMode>,
    /// The closed contacts: those with a stiffness that carry the static load, if any, without dry sliders.
    pub contacts: ActiveSet,
    /// Whether the closed contacts carry the static load.
    pub loaded: bool,
}

impl Frequencies {
    /// The frequencies of a model.
    pub fn of(model: &Model) -> Self {
        let mut open: Vec<NaturalMode> = if model.sliders.is_empty() {
            let of_block = |block: &Block| NaturalMode {
                frequency: block.natural_frequency(),
                decay: 0.0 - block.growth(),
            };
            model.blocks.iter().map(of_block).collect()
        } else {
            let stuck = closed_modes(model, ActiveSet::FREE).unwrap_or_default();
            stuck.into_iter().map(|natural| natural.mode).collect()
        };
        open.sort_by(|a, b| a.frequency.total_cmp(&b.frequency));
        // Rigid stops and dry friction have no stiffness. Other contacts may have a negative mean stiffness.
        let stiff = |contact: &usize| {
            let contact = &model.contacts[*contact];
            let stands = contact.release.of_stop() || contact.release.of_friction();
            !stands && contact.cycles[0].mean_stiffness() > 0.0
        };
        let stops = (0..model.contacts.len()).filter(|contact| !stiff(contact));
        let stops = stops.fold(ActiveSet::FREE, ActiveSet::toggled);
        let bearing = model.bearing_contacts().without(stops);
        let contacts = match bearing {
            ActiveSet::FREE if model.has_flanks() => ActiveSet::DRIVE,
            ActiveSet::FREE if model.contacts.len() > model.flank_springs => {
                ActiveSet::FREE.toggled(model.flank_springs).without(stops)
            }
            bearing => bearing,
        };
        let mut closed = closed_modes(model, contacts).unwrap_or_default();
        closed.sort_by(|a, b| a.mode.frequency.total_cmp(&b.mode.frequency));
        Self {
            open,
            closed,
            contacts,
            loaded: bearing != ActiveSet::FREE,
        }
    }

    /// Whether the drive flanks alone are closed.
    pub fn on_drive_flanks(&self) -> bool {
        self.contacts.only() == Some(DRIVE_FLANK)
    }
}

/// A contact as a spring \[N/m\] and a damper \[N s/m\] along its line.
struct Spring {
    along: Vec<f64>,
    stiffness: f64,
    damping: f64,
}

fn closed_modes(model: &Model, contacts: ActiveSet) -> Option<Vec<ClosedMode>> {
    let n = model.modes();
    let stuck = model.sliders.iter().map(|slider| slider.spring());
    let springs: Vec<Spring> = (contacts.iter().chain(stuck))
        .map(|contact| {
            let cycle = &model.contacts[contact].cycles[0];
            let [along, _] = model.participations(cycle.segments[0].direction);
            Spring {
                along,
                stiffness: cycle.mean_stiffness(),
                damping: cycle.segments[0].damping,
            }
        })
        .collect();
    let entry = |matrix: Matrix, i: usize, j: usize| match model.basis.coupled() {
        Some(coupled) => {
            let rows = match matrix {
                Matrix::Stiffness => &coupled.stiffness,
                Matrix::Damping => &coupled.damping,
            };
            0.5 * (rows[i * n + j] + rows[j * n + i])
        }
        None if i == j => {
            let [_, [stiffness, damping]] = model.blocks[i].generator;
            match matrix {
                Matrix::Stiffness => 0.0 - stiffness,
                Matrix::Damping => 0.0 - damping,
            }
        }
        None => 0.0,
    };
    // A mode that no spring of the structure or of a contact restrains stays exactly rigid.
    let held_by = |i: usize| springs.iter().any(|spring| spring.along[i] != 0.0);
    let (constrained, loose): (Vec<usize>, Vec<usize>) = (0..model.modes_of_structure())
        .partition(|&i| held_by(i) || (0..n).any(|j| entry(Matrix::Stiffness, i, j) != 0.0));
    let all = |matrix: Matrix| {
        Mat::from_fn(constrained.len(), constrained.len(), |i, j| {
            let (i, j) = (constrained[i], constrained[j]);
            let of = |spring: &Spring| {
                let value = match matrix {
                    Matrix::Stiffness => spring.stiffness,
                    Matrix::Damping => spring.damping,
                };
                value * spring.along[i] * spring.along[j]
            };
            entry(matrix, i, j) + springs.iter().map(of).sum::<f64>()
        })
    };
    let (squares, shapes) = symmetric_eigen(&all(Matrix::Stiffness))?;
    let damping = all(Matrix::Damping);
    let noise = RIGID
        * squares
            .iter()
            .fold(0.0_f64, |most, square| most.max(*square));
    let of_shape = |(k, &square): (usize, &f64)| {
        let shape = shapes.col(k);
        let image = &damping * shape;
        let decay: f64 = shape.iter().zip(image.iter()).map(|(a, b)| a * b).sum();
        let stored = |spring: &Spring| {
            let along = constrained.iter().zip(shape.iter());
            let along: f64 = along.map(|(&i, a)| spring.along[i] * a).sum();
            spring.stiffness * along * along
        };
        let rigid = square <= noise;
        ClosedMode {
            mode: NaturalMode {
                frequency: if rigid { 0.0 } else { square.sqrt() },
                decay: 0.5 * decay,
            },
            mesh_share: if rigid { 0.0 } else { springs.iter().map(stored).sum::<f64>() / square },
        }
    };
    let rigid = loose.into_iter().map(|i| ClosedMode {
        mode: NaturalMode {
            frequency: 0.0,
            decay: 0.5 * entry(Matrix::Damping, i, i),
        },
        mesh_share: 0.0,
    });
    Some(
        rigid
            .chain(squares.iter().enumerate().map(of_shape))
            .collect(),
    )
}

/// A matrix of the structure.
#[derive(Clone, Copy)]
enum Matrix {
    Stiffness,
    Damping,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{OperatingPoint, fixtures};
    use crate::structure::{Coupling, ModalStructure, StructureContact};

    fn of(structure: &ModalStructure) -> Frequencies {
        let point = OperatingPoint {
            load: 1.0,
            speed: 1.0,
        };
        let drive = fixtures::constant_mesh(1.0, 3.0);
        Frequencies::of(&Model::new(structure, &drive, point).unwrap())
    }

    /// One mode of frequency 2 on a mesh of stiffness 3: `ω² = 4 + 3 w²`.
    #[test]
    fn one_mode_on_its_mesh() {
        let found = of(&ModalStructure::of_modes(&[2.0], 0.1, &[2.0], &[1.0]));
        assert_eq!(found.open[0].frequency, 2.0);
        assert!((found.open[0].ratio().unwrap() - 0.1).abs() < 1e-15);
        let closed = found.closed[0];
        assert!((closed.mode.frequency - 4.0).abs() < 1e-14);
        assert!((closed.mesh_share - 0.75).abs() < 1e-15);
        assert!(found.on_drive_flanks());
        let coasting = Frequencies {
            contacts: ActiveSet::COAST,
            ..found.clone()
        };
        assert!(!coasting.on_drive_flanks());
        assert!((closed.mode.decay - 0.2).abs() < 1e-15);
    }

    /// A stuck slider of stiffness 5 on the mode: `ω² = 4 + 5` open, `4 + 5 + 3 w²` closed. The slider
    /// stores 5/21 of the elastic energy of the closed mode.
    #[test]
    fn a_stuck_slider_is_a_spring() {
        let mut structure = ModalStructure::of_modes(&[2.0], 0.0, &[2.0], &[1.0]);
        structure.contacts = StructureContact::slider("element", &[1.0], 5.0, 1.0).into();
        let found = of(&structure);
        assert_eq!(found.open.len(), 1);
        assert!((found.open[0].frequency - 3.0).abs() < 1e-14);
        assert!((found.closed[0].mode.frequency - 21f64.sqrt()).abs() < 1e-14);
        assert!((found.closed[0].mesh_share - 17.0 / 21.0).abs() < 1e-14);
    }

    /// Two rotations: one stays rigid, the other vibrates on the mesh, `ω² = k Σ w²`.
    #[test]
    fn a_rigid_pair_keeps_one_rotation() {
        let found = of(&ModalStructure::of_modes(
            &[0.0, 0.0],
            0.0,
            &[0.6, -0.8],
            &[0.6, -0.8],
        ));
        assert!(found.open.iter().all(|mode| mode.ratio().is_none()));
        assert_eq!(found.closed[0].mode.frequency, 0.0);
        assert!((found.closed[1].mode.frequency - 3f64.sqrt()).abs() < 1e-15);
        assert!((found.closed[1].mesh_share - 1.0).abs() < 1e-15);
    }

    /// A rotor that whirls: `ω = √(k + p²/4) ± p/2` with the gyroscopic term p.
    #[test]
    fn gyroscopic_terms_split_a_pair() {
        let structure = ModalStructure {
            coupling: Some(Coupling {
                damping: vec![0.0; 4],
                gyroscopic: vec![0.0, 0.6, -0.6, 0.0],
                stiffness: vec![0.0; 4],
            }),
            ..ModalStructure::of_modes(&[2.0, 2.0], 0.0, &[0.0, 1.0], &[0.0, 1.0])
        };
        let found = of(&structure);
        for (mode, side) in found.open.iter().zip([-0.3, 0.3]) {
            assert!((mode.frequency - (4.09f64.sqrt() + side)).abs() < 1e-13);
            assert!(mode.decay.abs() < 1e-14);
        }
    }

    #[test]
    fn an_overdamped_mode_has_a_ratio_above_one() {
        let mut structure = ModalStructure::of_modes(&[2.0], 0.0, &[1.0], &[1.0]);
        structure.damping[0] = 2.5;
        let found = of(&structure);
        assert!((found.open[0].ratio().unwrap() - 2.5).abs() < 1e-14);
    }
}
