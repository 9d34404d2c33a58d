//! The drive for timing kernels: the default drive, from the manifest `flex80` at the time of the build, with any
//! number of its modes.

use super::error::MeasurementError;
use crate::manifest::{self, DampingSpec, FrictionSpec, StiffnessSpec, StructureSource};
use crate::model::{Division, Drive, InitialState, Model, OperatingPoint, TrajectoryState};
use crate::propagate::{Counters, Kernel, Volterra};
use crate::shaft::FlexibleDrive;
use crate::structure::ModalStructure;
use std::path::Path;

const MANIFEST: &str = include_str!("../../../manifests/flex80.toml");

/// Largest number of events allowed in a mesh cycle.
pub const EVENT_LIMIT: u32 = 10_000;

/// Mesh cycles after which the drive has settled into rattle.
const TRANSIENT: u64 = 60;

/// Relative rise of the stiffness from the first to the last of sixty levels, in addition to the two levels
/// of the default mesh. It makes all levels different.
const SLOPE: f64 = 0.02;

/// A mesh of the default drive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mesh {
    /// Two levels of stiffness, as in the default manifest.
    TwoLevels,
    /// A separate level for each of sixty segments, as a computed mesh has.
    SixtyLevels,
}

/// The default drive.
#[derive(Debug, Clone)]
pub struct DefaultDrive {
    shafts: FlexibleDrive,
    levels: Vec<f64>,
    drive: Drive,
}

impl DefaultDrive {
    /// Reads the built-in manifest.
    pub fn new() -> Result<Self, MeasurementError> {
        let missing = |what| MeasurementError::Drive { what };
        let job = manifest::parse(MANIFEST, "manifests/flex80.toml", Path::new(""))
            .map_err(|_| missing("a manifest that can be read"))?;
        let point = job.points.first().ok_or(missing("an operating point"))?;
        let (
            StructureSource::Flexible(shafts),
            StiffnessSpec::Piecewise(levels),
            DampingSpec::Coefficient(damping),
            FrictionSpec::Constant(friction),
        ) = (
            &point.model.source,
            &point.mesh.stiffness,
            &point.mesh.damping,
            &point.mesh.friction,
        )
        else {
            return Err(missing("flexible shafts and a piecewise mesh"));
        };
        Ok(Self {
            shafts: (**shafts).clone(),
            levels: levels.to_vec(),
            drive: Drive {
                damping: *damping,
                friction: *friction,
                release: point.mesh.release,
                transmission_error: point.excitation.transmission_error.clone(),
                ..Drive::constant(point.mesh.half_gap, 0.0)
            },
        })
    }

    /// Structure of the default drive with its lowest `modes` modes.
    pub fn structure(&self, modes: usize) -> Result<ModalStructure, MeasurementError> {
        Ok(self.shafts.modes(modes, modes, false)?)
    }

    /// System of the default drive at an operating point.
    pub fn model(
        &self,
        structure: &ModalStructure,
        mesh: Mesh,
        point: OperatingPoint,
    ) -> Result<Model, MeasurementError> {
        let mut levels = self.levels.clone();
        if mesh == Mesh::SixtyLevels {
            let count = levels.len() as f64;
            for (i, level) in levels.iter_mut().enumerate() {
                *level *= 1.0 + SLOPE * ((i as f64 + 0.5) / count - 0.5);
            }
        }
        let drive = Drive {
            mesh: Division::levels(&levels, &[]),
            ..self.drive.clone()
        };
        Ok(Model::new(structure, &drive, point)?)
    }
}

/// The kernel `volterra` with the settings of a usual run.
pub fn volterra(model: &Model) -> Volterra<'_> {
    Volterra::new(model, f64::EPSILON, EVENT_LIMIT)
}

/// The state of a model after [`TRANSIENT`] mesh cycles from its static equilibrium.
pub fn settled(model: &Model) -> Result<TrajectoryState, MeasurementError> {
    let kernel = volterra(model);
    let mut trajectory = model.start(&InitialState::Static);
    let mut workspace = kernel.workspace();
    let mut counters = Counters::default();
    kernel.advance(
        TRANSIENT,
        &mut trajectory,
        &mut workspace,
        &mut (),
        &mut counters,
    )?;
    Ok(trajectory)
}

#[cfg(test)]
mod tests {
    use super::*;

    const POINT: OperatingPoint = OperatingPoint {
        load: 0.05,
        speed: 1200.0,
    };

    #[test]
    fn every_segment_of_sixty_levels_is_its_own() {
        let drive = DefaultDrive::new().unwrap();
        let structure = drive.structure(6).unwrap();
        for (mesh, segments) in [(Mesh::TwoLevels, 2), (Mesh::SixtyLevels, 60)] {
            let model = drive.model(&structure, mesh, POINT).unwrap();
            assert_eq!(model.first_cycle().segments.len(), segments);
            let mut levels: Vec<f64> = (model.first_cycle().segments.iter())
                .map(|segment| segment.stiffness.coefficients()[0])
                .collect();
            levels.sort_by(f64::total_cmp);
            levels.dedup();
            assert_eq!(levels.len(), segments);
        }
    }

    #[test]
    fn it_rattles() {
        let drive = DefaultDrive::new().unwrap();
        let structure = drive.structure(20).unwrap();
        let model = drive.model(&structure, Mesh::SixtyLevels, POINT).unwrap();
        let mut trajectory = settled(&model).unwrap();
        let kernel = volterra(&model);
        let (mut counters, mut workspace) = (Counters::default(), kernel.workspace());
        kernel
            .advance(50, &mut trajectory, &mut workspace, &mut (), &mut counters)
            .unwrap();
        assert!(counters.events > 50, "{}", counters.events);
    }
}
