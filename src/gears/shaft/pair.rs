//! From an assembly with two rigid gear shafts to the modes their mesh feels.
//!
//! Two parallel shafts along z, x along the line of centres from pinion to wheel, y across
//! it. Rotations are right-handed but for the wheel's about z, which is counted in the
//! wheel's own sense of running, so that both gears roll forward together. The mesh
//! deflection is
//!
//! ```text
//! δ = r_b1 θz1 − r_b2 θz2 + n·(u1 − u2) + z_c n·((θ1 − θ2) × e_z),   n = (sin α, cos α, 0)
//! ```
//!
//! in the transverse section. On helical gears the mesh force F has the axial part `F tan β_b` at the pitch
//! point, +z on the pinion and −z on the wheel; by the same measure axial motion of that point deflects the mesh:
//!
//! ```text
//! δ += tan β_b e_z·((u2 + θ2 × r2) − (u1 + θ1 × r1)),   r1 = (r_w1, 0, 0),   r2 = (−r_w2, 0, 0)
//! ```
//!
//! `mesh` is δ at z_c = 0 per unit modal coordinate, `mesh_tilt` its derivative by z_c. Places across the face
//! are counted from the middle of the common face, which may lie off the middle of the gear bodies, where the nodes are:
//! there a body has moved by `u + z₀ θ × e_z`.
//! The two rigid rotations are given as the neutral one (no deflection, no torque) followed
//! by the relative one.
//!
//! Friction acts along `t = (cos α, −sin α, 0)`, `+t` on the pinion and `−t` on the wheel, at
//! the distance s from the pitch point along n. Its moments about the two axes follow from
//! that point of attack: `−(r₁ sin α + s)` on θz1 and `r₂ sin α − s` on θz2. `friction` is the
//! part at the pitch point, where the flanks roll and the neutral rotation feels nothing;
//! `friction_lever` the part linear in s.
//!
//! The coast flanks touch along the mirror image of the drive flanks' line of action. Their
//! deflection is counted as that of the drive flanks, along `n' = (−sin α, cos α, 0)`, so that it
//! grows with the same rotation and they touch where it is negative; then F < 0, and its axial part has
//! changed its sign with it. At the distance s
//! from the pitch point along n' the pinion slides over the wheel along `t' = (cos α, sin α, 0)`,
//! and friction, which goes with |F| = −F, acts along −t'.

use super::assembly::{AssembledMatrices, Assembly, Freedom};
use super::drive::{self, Drag, Support};
use super::error::ShaftError;
use super::modes::{Modes, orientation};
use super::projection;
use crate::gear::GearPair;
use crate::structure::StaticShare;
use crate::structure::{
    BearingGain, FlankParticipation, ModalStructure, ModeCount, MotionKind, PlaceMotion,
    TurningFrame,
};

/// The neutral and the relative rotation.
pub(super) const RIGID_MODES: usize = 2;

/// Two gear shafts in an assembly.
#[derive(Debug)]
pub(super) struct PairedShafts<'a> {
    pub gears: &'a GearPair,
    /// Pinion shaft, wheel shaft.
    pub shafts: [ShaftNodes; 2],
    /// Damping ratio of the elastic modes.
    pub damping: f64,
    /// `(mode, ratio)` overrides, modes counted from 1.
    pub damping_overrides: &'a [(usize, f64)],
    /// Pinion shaft, wheel shaft.
    pub drag: [Drag; 2],
}

/// Nodes of one shaft that loads act on.
#[derive(Debug, Clone, Copy)]
pub(super) struct ShaftNodes {
    /// Free end of the overhang.
    pub end: usize,
    /// The gear body.
    pub gear: usize,
    /// Both bearings.
    pub supports: [Support; 2],
}

impl PairedShafts<'_> {
    /// The `retained` lowest of the `modes` lowest modes of the assembly; see
    /// [`FlexibleDrive::modes`](super::FlexibleDrive::modes).
    pub fn modes(
        &self,
        assembly: &Assembly,
        modes: usize,
        retained: usize,
        mta: bool,
    ) -> Result<ModalStructure, ShaftError> {
        let matrices = assembly.matrices()?;
        if modes < RIGID_MODES {
            return Err(ModeCount {
                requested: modes,
                least: RIGID_MODES,
                available: matrices.mass.nrows(),
            }
            .into());
        }
        let solution = Modes::lowest(&matrices.mass, &matrices.stiffness, modes, RIGID_MODES)?;
        let damping = modal_damping(self.damping, self.damping_overrides, modes, RIGID_MODES)?;
        Ok((self.structure(&matrices, &solution, damping)?).truncated(retained, mta)?)
    }

    /// Participations of all computed modes, rigid pair and signs settled.
    fn structure(
        &self,
        matrices: &AssembledMatrices,
        computed: &Modes,
        mut damping: Vec<f64>,
    ) -> Result<ModalStructure, ShaftError> {
        use Freedom::{RotationX, RotationY, RotationZ, X, Y, Z};
        let [base_1, base_2] = self.gears.base_radii();
        let [pitch_1, pitch_2] = self.gears.operating_pitch_radii()?;
        let (sin, cos) = self.gears.operating_pressure_angle()?.sin_cos();
        let axial = self.gears.base_helix_angle().tan();
        let [pinion, wheel] = [self.shafts[0].gear, self.shafts[1].gear];
        let supports =
            ["pinion", "wheel"]
                .into_iter()
                .zip(&self.shafts)
                .flat_map(|(name, shaft)| {
                    (1..)
                        .zip(shaft.supports)
                        .map(move |(number, support)| (format!("{name} {number}"), support))
                });
        let bearings = BearingTerms::of_supports(matrices, supports.clone());
        let solution = &BearingTerms::with_shapes(&bearings, matrices, computed)?;
        let modes = damping.len();
        damping.resize(solution.squared_frequency.len(), 0.0);
        let participation =
            |terms: &[(usize, Freedom, f64)]| solution.participation(&matrices.functional(terms));

        let middle = self.gears.form.face_middle;
        // Displacements of the bodies' middles as those of the middle of the common face.
        let at_face = |terms: &[(usize, Freedom, f64)]| {
            let turned = terms
                .iter()
                .filter_map(|&(node, freedom, weight)| match freedom {
                    X => Some((node, RotationY, middle * weight)),
                    Y => Some((node, RotationX, -middle * weight)),
                    _ => None,
                });
            participation(&terms.iter().copied().chain(turned).collect::<Vec<_>>())
        };

        // Of the flanks whose line of action leans towards the wheel's axis by `lean` sin α.
        let flank = |lean: f64| {
            let sin = lean * sin;
            FlankParticipation {
                mesh: at_face(&[
                    (pinion, RotationZ, base_1),
                    (pinion, X, sin),
                    (pinion, Y, cos),
                    (wheel, X, -sin),
                    (wheel, Y, -cos),
                    (wheel, RotationZ, -base_2),
                    (pinion, Z, -axial),
                    (pinion, RotationY, axial * pitch_1),
                    (wheel, Z, axial),
                    (wheel, RotationY, axial * pitch_2),
                ]),
                // n·(θ × e_z) = sin α θy − cos α θx
                tilt: participation(&[
                    (pinion, RotationY, sin),
                    (pinion, RotationX, -cos),
                    (wheel, RotationY, -sin),
                    (wheel, RotationX, cos),
                ]),
                friction: at_face(&[
                    (pinion, X, lean * cos),
                    (pinion, Y, -lean * sin),
                    (wheel, X, -lean * cos),
                    (wheel, Y, lean * sin),
                    (pinion, RotationZ, -pitch_1 * lean * sin),
                    (wheel, RotationZ, pitch_2 * lean * sin),
                ]),
                lever: participation(&[(pinion, RotationZ, -lean), (wheel, RotationZ, -lean)]),
                residual_flexibility: 0.0,
            }
        };
        let [mut drive, mut coast] = [1.0, -1.0].map(flank);
        let mut pinion_torque = participation(&[(self.shafts[0].end, RotationZ, 1.0)]);
        let mut wheel_torque = participation(&[(self.shafts[1].end, RotationZ, 1.0)]);

        let gears = [("pinion", pinion), ("wheel", wheel)];
        let turning = gears.map(|(name, node)| (name.to_owned(), node));
        let kinds = [MotionKind::Body, MotionKind::Gear];
        let turning = kinds.into_iter().flat_map(|kind| {
            let gears = turning.clone().into_iter();
            gears.map(move |(name, node)| (kind, name, (node, 1.0)))
        });
        let mut motions = place_motions(matrices, solution, supports, turning);

        let signs = orientation(&drive.mesh[..modes], RIGID_MODES, solution);
        let [w_1, w_2] = [drive.mesh[0], drive.mesh[1]];
        let norm = w_1.hypot(w_2);
        // The pinion turns forward in the neutral mode.
        let forward = (w_2 * pinion_torque[0] - w_1 * pinion_torque[1]).signum();
        let settle = |column: &mut [f64]| {
            let [a, b] = [column[0], column[1]];
            column[0] = forward * (w_2 * a - w_1 * b) / norm;
            column[1] = (w_1 * a + w_2 * b) / norm;
            for (value, sign) in column[RIGID_MODES..].iter_mut().zip(&signs) {
                *value *= sign;
            }
        };
        for column in [&mut pinion_torque, &mut wheel_torque].into_iter().chain(
            [&mut drive, &mut coast].into_iter().flat_map(|flank| {
                [
                    &mut flank.mesh,
                    &mut flank.tilt,
                    &mut flank.friction,
                    &mut flank.lever,
                ]
            }),
        ) {
            settle(column);
        }
        for motion in &mut motions {
            settle(&mut motion.gain);
        }
        let mut torque: Vec<f64> = (pinion_torque.iter().zip(&wheel_torque))
            .map(|(one, two)| base_1 * one - base_2 * two)
            .collect();
        // Zero by construction; only round-off of the rotation is removed.
        drive.mesh[0] = 0.0;
        coast.mesh[0] = 0.0;
        torque[0] = 0.0;
        // Shafts turn in their bearings; the neutral rotation grows without bound.
        let bearings = BearingTerms::gains(&bearings, solution, [modes, RIGID_MODES], settle);
        let [constant_load, load_by_speed] = self.mean_drag(&torque);

        let with_shapes = ModalStructure {
            teeth: self.gears.teeth[0],
            wheel_teeth: Some(self.gears.teeth[1]),
            frame: TurningFrame::default(),
            rated_force: self.gears.rated_force(),
            frequency: solution.frequencies(),
            damping,
            mesh: drive.mesh,
            mesh_tilt: drive.tilt,
            torque,
            pinion_torque: Some(pinion_torque),
            wheel_torque: Some(wheel_torque),
            friction: drive.friction,
            friction_lever: drive.lever,
            residual_flexibility: 0.0,
            coast: Some(coast),
            contacts: Vec::new(),
            bearings,
            torques: Vec::new(),
            motions,
            coupling: None,
            constant_load,
            load_by_speed,
            harmonic_loads: Vec::new(),
        };
        Ok(ModalStructure {
            coupling: projection::coupling(matrices, computed, settle).0,
            ..with_shapes.truncated(modes, false)?
        })
    }

    /// Modal forces of the mean drag, constant and by the pinion's speed; empty where there is
    /// none. The motor keeps the speed: it meets the pinion's own drag where that acts, and
    /// against a drag `T_d` on the wheel its torque grows by `T_d r_b1/r_b2`, so that the mesh
    /// bears `T_d/r_b2` more.
    fn mean_drag(&self, torque: &[f64]) -> [Vec<f64>; 2] {
        let [_, base] = self.gears.base_radii();
        let wheel = self.drag[1];
        let by_speed = wheel.viscous * drive::wheel_speed(self.gears);
        [wheel.constant, by_speed].map(|drag| {
            if drag == 0.0 {
                Vec::new()
            } else {
                torque.iter().map(|t| t * (drag / base)).collect()
            }
        })
    }
}

/// A force on a bearing as a sum of freedoms.
#[derive(Debug)]
pub(super) struct BearingTerms {
    name: String,
    /// By displacements \[N/m\] and by velocities \[N s/m\].
    springs: Vec<f64>,
    dampers: Vec<f64>,
}

impl BearingTerms {
    /// Those of every bearing, by its name, that the assembly can load, springs and dampers: along the line of
    /// centres, across it, axially.
    pub fn of_supports(
        matrices: &AssembledMatrices,
        supports: impl Iterator<Item = (String, Support)>,
    ) -> Vec<Self> {
        let mut all = Vec::new();
        for (name, support) in supports {
            let [damper_x, damper_y] = support.stiffness.damping;
            let plane = |[x, y]: [f64; 2]| vec![(Freedom::X, x), (Freedom::Y, y)];
            for (direction, freedom, dampers) in [
                ("x", Freedom::X, plane(damper_x)),
                ("y", Freedom::Y, plane(damper_y)),
                ("axial", Freedom::Z, Vec::new()),
            ] {
                let springs = support.row(freedom);
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
                // Nothing there, or nothing that could load it.
                if acts(&springs) || acts(&dampers) {
                    all.push(Self {
                        name: format!("{name} {direction}"),
                        springs,
                        dampers,
                    });
                }
            }
        }
        all
    }

    /// The modes of a solution followed by what the springs of each bearing, as a load, deflect beyond them.
    pub fn with_shapes(
        all: &[Self],
        matrices: &AssembledMatrices,
        solution: &Modes,
    ) -> Result<Modes, ShaftError> {
        let loads: Vec<Vec<f64>> = all.iter().map(|own| own.springs.clone()).collect();
        solution.with_static_shapes(&matrices.mass, &matrices.stiffness, &loads)
    }

    /// The gains in a solution of `modes` modes and the static shapes behind them, one a bearing: `settle` is what
    /// turns a participation as the solution has it into that of the structure; rotations do not load a
    /// bearing with any of the `rigid` first. Of the static shapes a bearing feels its own.
    pub fn gains(
        all: &[Self],
        solution: &Modes,
        [modes, rigid]: [usize; 2],
        settle: impl Fn(&mut [f64]),
    ) -> Vec<BearingGain> {
        (all.iter().enumerate())
            .map(|(number, own)| {
                let column = |functional: &[f64]| {
                    let mut column = solution.participation(functional);
                    settle(&mut column);
                    column[..rigid].fill(0.0);
                    column[modes..].fill(0.0);
                    column
                };
                let mut gain = column(&own.springs);
                if let Some(shape) = gain[modes..].get_mut(number) {
                    *shape = 1.0;
                }
                BearingGain {
                    name: own.name.clone(),
                    gain,
                    rate_gain: if acts(&own.dampers) { column(&own.dampers) } else { Vec::new() },
                    left_out: StaticShare::default(),
                }
            })
            .collect()
    }
}

fn acts(force: &[f64]) -> bool {
    force.iter().any(|&coefficient| coefficient != 0.0)
}

/// Motions of every bearing's place on its shaft and on what it stands on, in each direction that
/// is free, and of nodes that turn: what, its name, its node and the sense in which it runs.
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

/// Damping ratios of modes: one of the elastic ones, with `(mode, ratio)` overrides, modes counted
/// from 1; the `rigid` first have none.
pub(super) fn modal_damping(
    ratio: f64,
    overrides: &[(usize, f64)],
    modes: usize,
    rigid: usize,
) -> Result<Vec<f64>, ShaftError> {
    for ratio in std::iter::once(ratio).chain(overrides.iter().map(|&(_, ratio)| ratio)) {
        if !(0.0..1.0).contains(&ratio) {
            return Err(ShaftError::DampingRatio { ratio });
        }
    }
    let mut damping = vec![ratio; modes];
    damping[..rigid].fill(0.0);
    for &(mode, ratio) in overrides {
        if mode <= rigid || mode > modes {
            return Err(ShaftError::DampingOverride {
                mode,
                first: rigid + 1,
                last: modes,
            });
        }
        damping[mode - 1] = ratio;
    }
    Ok(damping)
}
