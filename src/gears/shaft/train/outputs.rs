//! Which forces and motions do the modes cause in bearings and at observed points?

use crate::shaft::assembly::{AssembledMatrices, Freedom};
use crate::shaft::drive::Support;
use crate::shaft::error::ShaftError;
use crate::shaft::modes::Modes;
use crate::structure::{BearingGain, MotionKind, OmittedModeForces, PlaceMotion};

/// A force on a bearing as a sum of freedoms.
#[derive(Debug)]
pub(super) struct BearingTerms {
    name: String,
    /// Coefficients of displacements \[N/m\] and of velocities \[N s/m\].
    springs: Vec<f64>,
    dampers: Vec<f64>,
    /// Force without displacements \[N\].
    at_zero: f64,
}

impl BearingTerms {
    /// Forces of all bearings that the assembly can load, springs and dampers, with names: along the line of
    /// centres, across it, axially. Each support comes with the displacement of its base from the nominal position, in x
    /// and y \[m\].
    pub fn of_supports<'a>(
        matrices: &AssembledMatrices,
        supports: impl Iterator<Item = (&'a (String, Support), [f64; 2])>,
    ) -> Vec<Self> {
        let mut all = Vec::new();
        for ((name, support), base_place) in supports {
            let [damper_x, damper_y] = support.stiffness.damping;
            let plane = |[x, y]: [f64; 2]| vec![(Freedom::X, x), (Freedom::Y, y)];
            for (direction, freedom, dampers) in [
                ("x", Freedom::X, plane(damper_x)),
                ("y", Freedom::Y, plane(damper_y)),
                ("axial", Freedom::Z, Vec::new()),
            ] {
                let springs = support.row(freedom);
                let at_zero = -(springs.iter())
                    .map(|&(along, value)| match along {
                        Freedom::X => value * base_place[0],
                        Freedom::Y => value * base_place[1],
                        _ => 0.0,
                    })
                    .sum::<f64>();
                let [springs, dampers] = [springs, dampers].map(|parts| {
                    let terms: Vec<_> = (parts.into_iter())
                        .filter(|&(_, value)| value != 0.0)
                        .flat_map(|(freedom, value)| {
                            let base = support.base.map(|node| (node, freedom, -value));
                            std::iter::once((support.node, freedom, value)).chain(base)
                        })
                        .collect();
                    matrices.functional(&terms)
                });
                // Skip directions without a spring or damper that could be loaded.
                if acts(&springs) || acts(&dampers) {
                    all.push(Self {
                        name: format!("{name} {direction}"),
                        springs,
                        dampers,
                        at_zero,
                    });
                }
            }
        }
        all
    }

    /// The modes of a solution, followed by the deflections beyond them under the springs of each bearing as loads, and
    /// under `further` loads.
    pub fn with_shapes(
        all: &[Self],
        further: Vec<Vec<f64>>,
        matrices: &AssembledMatrices,
        solution: &Modes,
    ) -> Result<Modes, ShaftError> {
        let springs = all.iter().map(|support| support.springs.clone());
        let loads: Vec<Vec<f64>> = springs.chain(further).collect();
        solution.with_static_shapes(&matrices.mass, &matrices.stiffness, &loads)
    }

    /// The gains in a solution of `modes` modes and the static shapes after them, one entry per bearing.
    /// `to_structure_modes` converts a participation in the solution to the modes of the structure. The first `rigid`
    /// modes are rotations and do not load a bearing. A static shape loads only its bearing.
    pub fn gains(
        all: &[Self],
        solution: &Modes,
        [modes, rigid]: [usize; 2],
        to_structure_modes: impl Fn(&mut [f64]),
    ) -> Vec<BearingGain> {
        (all.iter().enumerate())
            .map(|(number, support)| {
                let column = |functional: &[f64]| {
                    let mut column = solution.participation(functional);
                    to_structure_modes(&mut column);
                    column[..rigid].fill(0.0);
                    column[modes..].fill(0.0);
                    column
                };
                let mut gain = column(&support.springs);
                if let Some(shape) = gain[modes..].get_mut(number) {
                    *shape = 1.0;
                }
                BearingGain {
                    name: support.name.clone(),
                    gain,
                    rate_gain: if acts(&support.dampers) {
                        column(&support.dampers)
                    } else {
                        Vec::new()
                    },
                    left_out: OmittedModeForces {
                        constant_load: support.at_zero,
                        ..OmittedModeForces::default()
                    },
                }
            })
            .collect()
    }
}

fn acts(force: &[f64]) -> bool {
    force.iter().any(|&coefficient| coefficient != 0.0)
}

/// Motions in each free direction of every bearing's place on its shaft and on its support, and the rotations of some
/// nodes. `turning` has the kind and name of each rotation, its node and its direction (±1).
pub(super) fn place_motions(
    matrices: &AssembledMatrices,
    solution: &Modes,
    supports: impl Iterator<Item = (String, Support)>,
    turning: impl Iterator<Item = (MotionKind, String, (usize, f64))>,
) -> Vec<PlaceMotion> {
    const DIRECTIONS: [(&str, Freedom); 3] =
        [("x", Freedom::X), ("y", Freedom::Y), ("axial", Freedom::Z)];
    let places = supports.flat_map(|(name, support)| {
        let base = support.base.map(|node| (format!("{name} base"), node));
        std::iter::once((name, support.node)).chain(base)
    });
    let directions = places.flat_map(|(name, node)| {
        DIRECTIONS.map(|(direction, freedom)| {
            let name = format!("{name} {direction}");
            (MotionKind::Place, name, (node, freedom, 1.0))
        })
    });
    let rotations =
        turning.map(|(kind, name, (node, sense))| (kind, name, (node, Freedom::RotationZ, sense)));
    (directions.chain(rotations))
        .filter_map(|(kind, name, term)| {
            let place = matrices.functional(&[term]);
            acts(&place).then(|| PlaceMotion {
                name,
                kind,
                gain: solution.participation(&place),
            })
        })
        .collect()
}
