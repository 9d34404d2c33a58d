//! The initial states of a slice.
//!
//! A plane through the initial state x₀ of the point along two modes i and j, in squares:
//!
//! ```text
//! x = x₀ + x eᵢ/wᵢ + y eⱼ/wⱼ
//! ```
//!
//! with the participations w of the mesh deflection, so that x and y are the mesh deflections due to the
//! displacements \[m\]. The modes are those of the undamped structure, for coupled modes too. Rigid rotations are
//! combined so that only the last of them deflects the mesh. A slice of velocities gives mode i the velocity
//! `s x/wᵢ`, with s \[rad/s\] the mode's scale in energy. This velocity has as much energy as the displacement x. The
//! phase plane of one mode i varies its displacement by x/wᵢ and its velocity by y/wᵢ, so that y is the rate of the
//! mesh deflection \[m/s\].

use crate::analysis::norm::modal_scales;
use crate::model::{Model, TrajectoryState};
use serde::Serialize;
use strum::{EnumString, IntoStaticStr};

/// Participation, relative to the root of the sum of squares, below which a mode does not move the mesh:
/// round-off of the modes of an assembly is about 1e-13.
const NEGLIGIBLE: f64 = 1e-9;

/// Quantities that a slice varies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, IntoStaticStr, EnumString)]
#[strum(serialize_all = "snake_case")]
pub enum SliceOf {
    /// Modal displacements.
    Displacement,
    /// Modal velocities.
    Velocity,
    /// Displacement and velocity of one mode.
    #[strum(serialize = "phase plane")]
    PhasePlane,
}

impl SliceOf {
    /// The word in manifests and result files.
    pub fn name(self) -> &'static str {
        self.into()
    }
}

/// Settings of a slice of initial states.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SliceConfig {
    /// Two different modes, counted from 0; for a phase plane the same mode twice.
    pub modes: [usize; 2],
    /// Varied quantities.
    pub of: SliceOf,
    /// Half the side of the slice \[m of mesh deflection\], > 0.
    pub extent: f64,
    /// Half the height of a phase plane \[m/s of the mesh deflection's rate\], > 0. With `None`, this rate has the
    /// energy of a displacement by `extent`.
    pub speed: Option<f64>,
    /// Cells along each side, at least 1.
    pub count: u32,
}

/// Why a slice is impossible. Modes are counted from 1.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum SliceError {
    /// Both modes are the same.
    #[error("a slice needs two different modes, but both are mode {mode}")]
    OneMode {
        /// The mode.
        mode: usize,
    },
    /// The model does not have this mode.
    #[error("a slice along mode {mode} is not possible: {retained} modes are retained")]
    NoSuchMode {
        /// The mode.
        mode: usize,
        /// Number of retained modes.
        retained: usize,
    },
    /// The mode does not move the mesh.
    #[error(
        "a slice along mode {mode} is not possible, because this mode does not deflect the mesh (only the last of the \
         rigid rotations does); take one of the modes {possible}"
    )]
    NoDeflection {
        /// The mode.
        mode: usize,
        /// Ranges of possible modes.
        possible: String,
    },
}

/// A slice of a model's state space.
#[derive(Debug, Clone, PartialEq)]
pub struct Plane {
    /// Indices of the varied displacements and velocities among those of all modes.
    components: [usize; 2],
    /// Change of each of them per metre of mesh deflection, or per metre per second of its rate.
    scale: [f64; 2],
    /// Change of the state per unit of each axis of the slice.
    along: [Vec<f64>; 2],
    /// Half the length of each side.
    extent: [f64; 2],
    count: u32,
}

impl Plane {
    /// The slice of a model.
    ///
    /// # Errors
    /// The modes are equal, or one does not exist or does not move the mesh.
    pub fn new(model: &Model, config: &SliceConfig) -> Result<Self, SliceError> {
        let n = model.modes();
        if let Some(mode) = config.modes.into_iter().find(|&mode| mode >= n) {
            return Err(SliceError::NoSuchMode {
                mode: mode + 1,
                retained: n,
            });
        }
        if config.of != SliceOf::PhasePlane && config.modes[0] == config.modes[1] {
            return Err(SliceError::OneMode {
                mode: config.modes[0] + 1,
            });
        }
        let [participations, _] = model.participations(model.first_cycle().segments[0].direction);
        let participation = |mode: usize| participations[mode];
        let whole = (0..n).map(|mode| participation(mode).powi(2)).sum::<f64>();
        let deflects = |mode: usize| participation(mode).abs() > NEGLIGIBLE * whole.sqrt();
        if let Some(mode) = config.modes.into_iter().find(|&mode| !deflects(mode)) {
            return Err(SliceError::NoDeflection {
                mode: mode + 1,
                possible: ranges((0..n).filter(|&mode| deflects(mode)).map(|mode| mode + 1)),
            });
        }
        let scales = modal_scales(model);
        let displaced = |mode: usize| (mode, 1.0 / participation(mode));
        let moving = |mode: usize| (n + mode, 1.0 / participation(mode));
        // Velocity with the same energy as a displacement by a metre of mesh deflection.
        let as_energetic = |mode: usize| {
            let (component, scale) = moving(mode);
            (component, scales[mode] * scale)
        };
        let extent = config.extent;
        let [mode, _] = config.modes;
        let ([first, second], extent) = match config.of {
            SliceOf::Displacement => (config.modes.map(displaced), [extent; 2]),
            SliceOf::Velocity => (config.modes.map(as_energetic), [extent; 2]),
            SliceOf::PhasePlane => {
                let speed = config.speed.unwrap_or(scales[mode] * extent);
                ([displaced(mode), moving(mode)], [extent, speed])
            }
        };
        let along = [first, second].map(|(component, scale)| {
            let mut modes = vec![0.0; 2 * n];
            modes[component] = scale;
            model.basis.state_of_turned(&modes)
        });
        Ok(Self {
            components: [first.0, second.0],
            scale: [first.1, second.1],
            along,
            extent,
            count: config.count,
        })
    }

    /// Number of cells.
    pub(super) fn cells(&self) -> usize {
        self.count as usize * self.count as usize
    }

    /// Column and row of a cell, counted row by row.
    pub(super) fn column_row(&self, cell: usize) -> [u32; 2] {
        let count = self.count as usize;
        [(cell % count) as u32, (cell / count) as u32]
    }

    /// Centre of a cell \[m; m/s for the second of a phase plane\].
    pub(super) fn centre(&self, cell: usize) -> [f64; 2] {
        let count = f64::from(self.count);
        let places = self.column_row(cell);
        [0, 1].map(|axis| self.extent[axis] * ((2.0 * f64::from(places[axis]) + 1.0) / count - 1.0))
    }

    /// The initial state of a cell.
    pub(super) fn state(
        &self,
        model: &Model,
        start: &TrajectoryState,
        cell: usize,
    ) -> TrajectoryState {
        let mut state = start.state.clone();
        for (along, place) in self.along.iter().zip(self.centre(cell)) {
            for (x, d) in state.iter_mut().zip(along) {
                *x += d * place;
            }
        }
        TrajectoryState::new(model, state, start.cycle)
    }

    /// A state projected on the slice, in the units of [`Self::centre`].
    pub(super) fn place(&self, model: &Model, start: &TrajectoryState, state: &[f64]) -> [f64; 2] {
        let difference: Vec<f64> = state.iter().zip(&start.state).map(|(x, y)| x - y).collect();
        let modes = model.basis.turned_modes(&difference);
        [0, 1].map(|axis| modes[self.components[axis]] / self.scale[axis])
    }
}

/// Ascending numbers as text. Neighbouring numbers form ranges, for example `2, 4 … 9, 12`.
fn ranges(numbers: impl Iterator<Item = usize>) -> String {
    let mut runs: Vec<[usize; 2]> = Vec::new();
    for number in numbers {
        match runs.last_mut() {
            Some([_, last]) if *last + 1 == number => *last = number,
            _ => runs.push([number, number]),
        }
    }
    let words = runs.iter().map(|[first, last]| match last - first {
        0 => first.to_string(),
        1 => format!("{first}, {last}"),
        _ => format!("{first} … {last}"),
    });
    words.collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::super::tests::model;
    use super::*;
    use crate::analysis::norm::EnergyNorm;
    use crate::analysis::norm::tests::dragged;
    use crate::model::InitialState;

    fn slice_config(modes: [usize; 2], of: SliceOf) -> SliceConfig {
        SliceConfig {
            modes,
            of,
            extent: 3.0,
            speed: None,
            count: 5,
        }
    }

    #[test]
    fn a_displacement_is_the_deflection_it_causes() {
        let model = model();
        let start = model.start(&InitialState::Static);
        let plane = Plane::new(&model, &slice_config([1, 3], SliceOf::Displacement)).unwrap();
        let deflection = |state: &TrajectoryState| model.deflection(&state.state, 0.0);
        let [centre, rate] = [deflection(&start).0, deflection(&start).1];
        assert_eq!(plane.cells(), 25);
        for cell in 0..25 {
            let [x, y] = plane.centre(cell);
            let state = plane.state(&model, &start, cell);
            assert!((deflection(&state).0 - centre - x - y).abs() < 1e-14);
            assert_eq!(deflection(&state).1, rate);
            let [back, up] = plane.place(&model, &start, &state.state);
            assert!((back - x).abs() < 1e-14 && (up - y).abs() < 1e-14);
        }
        assert_eq!(plane.state(&model, &start, 12), start);
        // Centres of five cells over −3 … 3.
        assert!((plane.centre(0)[0] + 2.4).abs() < 1e-15);
        assert!((plane.centre(23)[1] - 2.4).abs() < 1e-15);
    }

    /// A step of a velocity has the energy of the same step of a displacement.
    #[test]
    fn a_velocity_has_the_energy_of_a_displacement() {
        let model = model();
        let norm = EnergyNorm::new(&model);
        let start = model.start(&InitialState::Static);
        let away = |of| {
            let plane = Plane::new(&model, &slice_config([2, 3], of)).unwrap();
            let far = |cell| norm.distance(&plane.state(&model, &start, cell).state, &start.state);
            [far(10), far(2), far(24)]
        };
        let [displaced, moving] = [away(SliceOf::Displacement), away(SliceOf::Velocity)];
        for (a, b) in displaced.iter().zip(moving) {
            assert!((a - b).abs() < 1e-14 * a, "{a} {b}");
        }
    }

    /// Upwards in the phase plane, only the rate of the mesh deflection grows, by the value on the vertical
    /// axis.
    #[test]
    fn a_phase_plane_is_deflection_and_rate_of_one_mode() {
        let model = model();
        let start = model.start(&InitialState::Static);
        let config = SliceConfig {
            speed: Some(0.2),
            ..slice_config([2, 2], SliceOf::PhasePlane)
        };
        let plane = Plane::new(&model, &config).unwrap();
        let before = model.deflection(&start.state, 0.0);
        for cell in 0..25 {
            let [x, y] = plane.centre(cell);
            let state = plane.state(&model, &start, cell);
            let after = model.deflection(&state.state, 0.0);
            assert!((after.0 - before.0 - x).abs() < 1e-14);
            assert!((after.1 - before.1 - y).abs() < 1e-14, "{after:?} {y}");
            let moved = (0..8).filter(|&i| state.state[i] != start.state[i]);
            assert!(moved.into_iter().all(|i| [2, 6].contains(&i)));
        }
        assert!((plane.centre(24)[1] - 0.16).abs() < 1e-15);
        // By default a state at the top has the same energy as a state at the right border.
        let plane = Plane::new(&model, &slice_config([2, 2], SliceOf::PhasePlane)).unwrap();
        let norm = EnergyNorm::new(&model);
        let far = |cell| norm.distance(&plane.state(&model, &start, cell).state, &start.state);
        assert!((far(14) / far(22) - 1.0).abs() < 1e-14);
    }

    /// A negligible drag couples the modes. It changes neither the cells nor their places.
    #[test]
    fn a_slice_runs_along_modes_whatever_couples_them() {
        let (plain, dragged) = (model(), dragged(1e-9));
        let starts = [&plain, &dragged].map(|model| TrajectoryState::new(model, vec![0.0; 8], 0));
        for config in [
            slice_config([1, 2], SliceOf::Displacement),
            slice_config([1, 3], SliceOf::Velocity),
            slice_config([1, 1], SliceOf::PhasePlane),
        ] {
            let [one, other] = [&plain, &dragged].map(|model| Plane::new(model, &config).unwrap());
            for cell in 0..25 {
                let state = one.state(&plain, &starts[0], cell).state;
                let coupled = other.state(&dragged, &starts[1], cell).state;
                let modes = dragged.basis.turned_modes(&coupled);
                for (a, b) in state.iter().zip(&modes) {
                    assert!((a - b).abs() < 1e-7, "{state:?} {modes:?}");
                }
                let [x, y] = one.centre(cell);
                let [back, up] = other.place(&dragged, &starts[1], &coupled);
                assert!((back - x).abs() < 1e-7 && (up - y).abs() < 1e-7);
            }
        }
        let weightless = slice_config([0, 2], SliceOf::Displacement);
        assert!(Plane::new(&dragged, &weightless).is_err());
    }

    #[test]
    fn a_slice_needs_two_modes_that_the_mesh_feels() {
        let model = model();
        let refused = |modes| {
            let config = slice_config(modes, SliceOf::Displacement);
            Plane::new(&model, &config).unwrap_err().to_string()
        };
        assert_eq!(
            refused([2, 2]),
            "a slice needs two different modes, but both are mode 3"
        );
        assert!(refused([1, 4]).starts_with("a slice along mode 5 is not possible: 4 modes"));
        let weightless = refused([0, 2]);
        assert!(
            weightless
                .contains("mode 1 is not possible, because this mode does not deflect the mesh")
        );
        assert!(weightless.ends_with("modes 2 … 4"), "{weightless}");
    }
}
