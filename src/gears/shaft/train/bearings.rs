//! How are the rolling bearings of a train loaded in equilibrium under its mean load, and how stiff are they there?
//!
//! Shafts, couplings, given springs and meshes at their mean stiffness make the linear part K of the equilibrium
//!
//! ```text
//! K u + Σ Bᵀ F(B u) = f
//! ```
//!
//! B u is the motion of an inner ring relative to its outer ring, or of a shaft towards a stop, and F is its
//! force. Springs K₀ replace F, so that the linear part is definite. With `C = B (K + Bᵀ K₀ B)⁻¹ Bᵀ` the
//! unknowns are one force p per row of all B ([`super::balance`]).

use super::balance::{EquilibriumProblem, OneSidedSupport, SupportLaw};
use super::contacts::Terms;
use super::nodes::Assembled;
use super::speeds::{Layout, sense};
use super::{MeshLaw, TrainDrive, TrainError};
use crate::numerics::linalg::add_scaled;
use crate::numerics::linalg::{cholesky, product, solve_lower, solve_upper};
use crate::shaft::assembly::{AssembledMatrices, Freedom};
use crate::shaft::error::ShaftError;
use crate::shaft::modes::Modes;
use crate::shaft::rolling::{RING_FREEDOMS, Ring, RollingLoad};
use crate::structure::ContactLaw;
use faer::Mat;
use nalgebra::{DMatrix, DVector};

/// A thrust below this part of the radial load counts as zero.
const NO_THRUST: f64 = 1e-9;

/// Mean stiffness of a mesh divided by its face width \[N/m²\], for steel spur gears: 20 N/(mm µm) (ISO 6336-1).
const MESH: f64 = 2e10;

/// Assumed stiffness of a coupling without torsional springs \[N m/rad\], which does not affect its torque.
const LOCKED_STIFFNESS: f64 = 1e5;

/// A rolling bearing under the mean load of its train.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadedBearing {
    /// Name of the shaft and number of the bearing on it, or name of the loose gear or planet.
    pub name: String,
    /// Displacement of the inner ring relative to the outer one: x, y, z \[m\], tilts about x and y \[rad\].
    pub moved: Ring,
    /// Load on the bearing.
    pub bears: RollingLoad,
}

/// A mesh as a spring.
struct MeshSpring {
    /// Deflection of the mesh, as a sum of the free freedoms.
    row: Vec<f64>,
    /// Mean stiffness of the mesh \[N/m\].
    stiffness: f64,
}

impl TrainDrive {
    /// Rolling bearings that can move, under the load [`bearing_load`](Self::bearing_load); empty if this is `None`.
    ///
    /// # Errors
    /// Those of [`modes`](Self::modes) for layout, assembly and bearings.
    pub fn loaded_bearings(&self) -> Result<Vec<LoadedBearing>, ShaftError> {
        let layout = self.layout()?;
        let assembled = self.assembled(&layout)?;
        let loaded = self.loaded(&layout, &assembled)?;
        Ok(loaded.into_iter().map(|(_, bearing)| bearing).collect())
    }

    /// Gives the rolling bearings of an assembly their stiffness under the mean load.
    pub(super) fn load_bearings(
        &self,
        layout: &Layout,
        assembled: &mut Assembled,
    ) -> Result<(), ShaftError> {
        for (number, bearing) in self.loaded(layout, assembled)? {
            let support = &mut assembled.supports[number].1;
            support.contacts = bearing.bears.stiffness;
            let (node, base) = (support.node, support.base);
            (assembled.assembly).add_stiffness(node, base, &bearing.bears.stiffness)?;
        }
        Ok(())
    }

    /// The rolling bearings under the mean load, with their indices among the supports.
    fn loaded(
        &self,
        layout: &Layout,
        assembled: &Assembled,
    ) -> Result<Vec<(usize, LoadedBearing)>, ShaftError> {
        let Some(load) = self.bearing_load else {
            return Ok(Vec::new());
        };
        let matrices = assembled.assembly.matrices()?;
        let all = self.yielding(&matrices, layout, assembled)?;
        let mut coasting = vec![false; layout.meshes.len()];
        let mut solved;
        let mut moved;
        loop {
            let meshes = self.mesh_springs(&coasting, &matrices, layout, assembled)?;
            let statics = self.statics((load, &all, &meshes), &matrices, layout, assembled)?;
            solved = statics.solve();
            let (Ok(force) | Err(force)) = &solved;
            moved = statics.moved(force);
            let pulling = statics.pulling(force).filter(|mesh| !coasting[*mesh]);
            let pulling: Vec<usize> = pulling.collect();
            if pulling.is_empty() || solved.is_err() {
                break;
            }
            for mesh in pulling {
                coasting[mesh] = true;
            }
        }
        let lost = solved.is_err();
        let mut at = 0;
        let mut rolling_bearings = Vec::new();
        for element in &all {
            let rows = element.rows.len();
            if let Some((number, moved, bears)) = element.rolling(&moved.as_slice()[at..at + rows])
            {
                let name = assembled.supports[number].0.clone();
                rolling_bearings.push((number, LoadedBearing { name, moved, bears }));
            }
            at += rows;
        }
        let farthest = rolling_bearings.iter().max_by(|(_, a), (_, b)| {
            let far = |bearing: &LoadedBearing| {
                bearing.moved[..3]
                    .iter()
                    .fold(0.0_f64, |m, d| m.max(d.abs()))
            };
            far(a).total_cmp(&far(b))
        });
        if let Some((_, element)) = farthest.filter(|_| lost) {
            return Err(ShaftError::Train(TrainError::BearingsGiveWay {
                bearing: element.name.clone(),
                moved: element.moved,
                load,
            }));
        }
        for (number, element) in &rolling_bearings {
            let rolling = assembled.supports[*number].1.stiffness.rolling;
            let angle = rolling.map_or(0.0, |rolling| rolling.contact_angle);
            let [x, y, thrust, ..] = element.bears.load;
            // The sign of a thrust within round-off is meaningless.
            if angle != 0.0 && angle.signum() * thrust < -NO_THRUST * x.hypot(y) {
                return Err(ShaftError::Train(TrainError::AgainstAngle {
                    bearing: element.name.clone(),
                    thrust: element.bears.load[2],
                    angle: angle.to_degrees(),
                }));
            }
        }
        Ok(rolling_bearings)
    }

    /// The one-sided supports: rolling bearings and stops.
    fn yielding(
        &self,
        matrices: &AssembledMatrices,
        layout: &Layout,
        assembled: &Assembled,
    ) -> Result<Vec<OneSidedSupport>, ShaftError> {
        let mut all = Vec::new();
        let of_shafts: usize = self.shafts.iter().map(|shaft| shaft.bearings.len()).sum();
        for (number, (_, support)) in assembled.supports.iter().enumerate() {
            let Some(rolling) = support.stiffness.rolling else {
                continue;
            };
            // Shafts carry inner rings; loose gears and planets, which follow, carry outer rings.
            let sign = if number < of_shafts { 1.0 } else { -1.0 };
            let rows: Vec<_> = (Freedom::ALL[..RING_FREEDOMS].iter())
                .map(|&freedom| {
                    let base = support.base.map(|node| (node, freedom, -sign));
                    let terms = [(support.node, freedom, sign)].into_iter().chain(base);
                    matrices.functional(&terms.collect::<Terms>())
                })
                .collect();
            let law = rolling.law()?;
            let mut place = Ring::default();
            [place[0], place[1]] =
                (self.base_place(number, layout, assembled)).map(|part| sign * part);
            // A bearing whose shaft is mounted rigidly has no rows. It carries any load.
            if rows.iter().flatten().any(|&part| part != 0.0) {
                all.push(OneSidedSupport {
                    rows,
                    typical: law.typical().to_vec(),
                    law: SupportLaw::Rolling(law, number, place),
                });
            }
        }
        for (number, stop) in self.stops.iter().enumerate() {
            let stiffness = mean(&stop.law);
            all.push(OneSidedSupport {
                rows: vec![matrices.functional(&self.approach(number, assembled))],
                typical: vec![stiffness],
                law: SupportLaw::Stop {
                    gap: stop.law.gap,
                    stiffness,
                },
            });
        }
        Ok(all)
    }

    /// The equilibrium of the train under a part of its rated load.
    fn statics<'a>(
        &self,
        (load, all, meshes): (f64, &'a [OneSidedSupport], &[MeshSpring]),
        matrices: &AssembledMatrices,
        layout: &Layout,
        assembled: &Assembled,
    ) -> Result<EquilibriumProblem<'a>, ShaftError> {
        let functional = |terms: &[(usize, Freedom, f64)]| matrices.functional(terms);
        let node = assembled.at(self.driver, self.shafts[self.driver].torque_at);
        let driving = functional(&[(node, Freedom::RotationZ, sense(layout.speeds[self.driver]))]);
        let mut force = vec![0.0; driving.len()];
        let power = self.power(layout, assembled, &driving, functional);
        add_scaled(&mut force, load * self.pair.rated_force(), &power);
        let [constant, _] = self.brakes(layout, assembled, &driving, functional);
        add_scaled(&mut force, 1.0, &constant);
        for term in self.pin_forces(layout, assembled) {
            add_scaled(&mut force, 1.0, &functional(&[term]));
        }

        let mut stiffness = self.linear_part(meshes, matrices, layout, assembled);
        let rows = || all.iter().flat_map(|element| &element.rows);
        let typical: Vec<f64> = all
            .iter()
            .flat_map(|element| element.typical.clone())
            .collect();
        for (row, typical_stiffness) in rows().zip(&typical) {
            add_spring(&mut stiffness, row, *typical_stiffness);
        }
        let Some(lower) = cholesky(&stiffness) else {
            let springs = rows().zip(typical.iter().copied());
            return Err(self.without_balance(matrices, springs, assembled));
        };
        let columns: Vec<&Vec<f64>> = rows().chain([&force]).collect();
        let mut shapes = Mat::from_fn(force.len(), columns.len(), |i, j| columns[j][i]);
        solve_lower(&lower, &mut shapes);
        solve_upper(&lower, &mut shapes);
        let size = typical.len();
        let picked: Vec<&Vec<f64>> = rows().chain(meshes.iter().map(|mesh| &mesh.row)).collect();
        let picks = Mat::from_fn(picked.len(), force.len(), |i, j| picked[i][j]);
        let displacements = product(picks.as_ref(), shapes.as_ref());
        Ok(EquilibriumProblem {
            all,
            free: DVector::from_fn(size, |i, _| displacements[(i, size)]),
            compliance: DMatrix::from_fn(size, size, |i, j| displacements[(i, j)]),
            typical: DVector::from_vec(typical),
            meshes: (
                DVector::from_fn(meshes.len(), |i, _| displacements[(size + i, size)]),
                DMatrix::from_fn(meshes.len(), size, |i, j| displacements[(size + i, j)]),
            ),
        })
    }

    /// Why a train has no equilibrium although its rolling bearings and stops are springs.
    fn without_balance<'r>(
        &self,
        matrices: &AssembledMatrices,
        springs: impl Iterator<Item = (&'r Vec<f64>, f64)>,
        assembled: &Assembled,
    ) -> ShaftError {
        let mut with_springs = matrices.clone();
        for (row, stiffness) in springs {
            add_spring(&mut with_springs.stiffness, row, stiffness);
        }
        let rigid = self.rotations();
        match Modes::lowest(&with_springs.mass, &with_springs.stiffness, rigid, rigid) {
            Err(error) => self.name_unsupported(error, &with_springs, assembled),
            Ok(_) => ShaftError::NoConvergence {
                size: with_springs.mass.nrows(),
            },
        }
    }

    /// Every mesh as a spring along its drive flanks, or along its coast flanks if the mesh coasts.
    fn mesh_springs(
        &self,
        coasting: &[bool],
        matrices: &AssembledMatrices,
        layout: &Layout,
        assembled: &Assembled,
    ) -> Result<Vec<MeshSpring>, ShaftError> {
        let of_first = MESH * self.pair.face_width;
        let angle = self.pair.operating_pressure_angle()?;
        let further = self.meshes.iter().map(|mesh| {
            let width = mesh.gears.map(|place| self.gear(place).width);
            let width = width[0].min(width[1]);
            let mean_stiffness = match &mesh.law {
                MeshLaw::OfFirst { .. } => of_first,
                MeshLaw::Own(flanks) => mean(&flanks[0]),
                MeshLaw::Drawn(_) => MESH * width,
            };
            (mesh.gears, mesh.pressure_angle, mean_stiffness)
        });
        let meshes = std::iter::once((self.gears, angle, of_first)).chain(further);
        let meshes = meshes.zip(layout.meshes.iter().zip(coasting));
        Ok(meshes
            .map(|((gears, angle, mean_stiffness), (pitch_point, coasts))| {
                let flanks = self.flanks(gears, (pitch_point, angle), layout, assembled);
                MeshSpring {
                    row: matrices.functional(&flanks[usize::from(*coasts)].mesh),
                    stiffness: mean_stiffness,
                }
            })
            .collect())
    }

    /// K: shafts, given springs, meshes, a torsional spring for each coupling without one, and one spring per rotation
    /// that deflects no contact. Loads are in balance along those rotations, so these springs carry no force.
    fn linear_part(
        &self,
        meshes: &[MeshSpring],
        matrices: &AssembledMatrices,
        layout: &Layout,
        assembled: &Assembled,
    ) -> Mat<f64> {
        let mut stiffness = matrices.stiffness.clone();
        for mesh in meshes {
            add_spring(&mut stiffness, &mesh.row, mesh.stiffness);
        }
        for (number, coupling) in self.couplings.iter().enumerate() {
            if coupling.stiffness[3] == 0.0 {
                let stages = coupling.stages.iter();
                let stages: f64 = stages.map(|stage| mean(&stage.law)).sum();
                let row = matrices.functional(&self.twist(number, layout, assembled));
                add_spring(
                    &mut stiffness,
                    &row,
                    if stages > 0.0 { stages } else { LOCKED_STIFFNESS },
                );
            }
        }
        let groups = self.connected();
        let shafts = (self.shafts.iter().enumerate())
            .map(|(index, shaft)| assembled.at(index, shaft.torque_at));
        let nodes: Vec<usize> = shafts.chain(assembled.loose.iter().copied()).collect();
        for free in self.free_of_contacts(&groups) {
            let bodies = (0..nodes.len()).filter(|&body| groups[body] == free);
            let turns = bodies.clone().any(|body| layout.speeds[body] != 0.0);
            let speed = |body: usize| if turns { layout.speeds[body] } else { 1.0 };
            let terms: Terms = bodies
                .map(|body| (nodes[body], Freedom::RotationZ, speed(body)))
                .collect();
            let row = matrices.functional(&terms);
            let largest = (row.iter().enumerate().filter(|(_, part)| **part != 0.0))
                .map(|(place, _)| stiffness[(place, place)])
                .fold(0.0, f64::max);
            add_spring(
                &mut stiffness,
                &row,
                if largest > 0.0 { largest } else { LOCKED_STIFFNESS },
            );
        }
        stiffness
    }
}

/// Mean stiffness of a contact over its cycle \[N/m\].
fn mean(law: &ContactLaw) -> f64 {
    let mut from = 0.0;
    let pieces = law.stiffness.iter().map(|(end, series)| {
        let part = (end - from) * series[0];
        from = *end;
        part
    });
    pieces.sum()
}

/// Adds a spring against a sum of freedoms.
fn add_spring(stiffness: &mut Mat<f64>, row: &[f64], value: f64) {
    let parts = || row.iter().enumerate().filter(|(_, part)| **part != 0.0);
    for (i, a) in parts() {
        for (j, b) in parts() {
            stiffness[(i, j)] += value * a * b;
        }
    }
}
