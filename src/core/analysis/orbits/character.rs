//! How robust is a periodic orbit, and how does it lose its stability?

use super::kick::{KICK, KickedTrajectory};
use super::shooting::PeriodicOrbit;
use crate::analysis::continuation::touches::TouchObserver;
use crate::analysis::norm::EnergyNorm;
use crate::model::{Model, TrajectoryState};
use crate::propagate::{Counters, Kernel, Stop};
use num_complex::Complex64;
use serde::{Deserialize, Serialize};
use strum::IntoStaticStr;

/// Smallest modulus of the leading multiplier at which a stable orbit counts as near a bifurcation.
const NEAR_THE_CIRCLE: f64 = 0.9;

/// Bifurcation at which the leading multiplier crosses the unit circle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, IntoStaticStr)]
#[strum(serialize_all = "snake_case")]
pub enum Bifurcation {
    /// At +1: a fold (saddle-node), or a symmetry that breaks.
    Fold,
    /// At −1: the period doubles.
    Flip,
    /// As a complex pair: a torus begins.
    NeimarkSacker,
}

impl Bifurcation {
    /// The word stored in result files.
    pub fn name(self) -> &'static str {
        self.into()
    }

    /// The bifurcation that a leading multiplier indicates. `None` if it lies well inside the unit circle: there, a
    /// complex pair may still become real.
    fn of(leading: Complex64) -> Option<Self> {
        (leading.norm() >= NEAR_THE_CIRCLE).then_some(if leading.im != 0.0 {
            Self::NeimarkSacker
        } else if leading.re < 0.0 {
            Self::Flip
        } else {
            Self::Fold
        })
    }
}

/// Properties of an orbit besides its multipliers.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Character {
    /// Whether all multipliers lie inside the unit circle by more than round-off.
    pub stable: bool,
    /// How the orbit gains or loses stability; `None` if its leading multiplier is well inside the unit circle.
    pub bifurcation: Option<Bifurcation>,
    /// Contact-state changes in a period.
    pub events: u64,
    /// Largest minus smallest δ \[m\].
    pub deflection_pp: f64,
    /// Smallest distance of an extreme of a contact's depth from its surface, in half gaps. At 0 the orbit grazes,
    /// and the event sequence changes. `None` if no depth has an extreme.
    pub grazing_margin: Option<f64>,
    /// Growth, over one period of the full system, of a kick of [`KICK`] in the direction of
    /// strongest growth.
    pub kick_growth: f64,
    /// Growth of the kick over one period in the linearised system: the largest singular value of the monodromy
    /// matrix.
    pub kick_growth_linear: f64,
}

/// The strobe states of an orbit's period, and its character.
///
/// # Errors
/// [`Stop`] as for any integration.
pub fn of<K: Kernel>(
    model: &Model,
    kernel: &K,
    norm: &EnergyNorm,
    orbit: &PeriodicOrbit,
    workspace: &mut K::Workspace,
) -> Result<(Vec<TrajectoryState>, Character), Stop> {
    let mut counters = Counters::default();
    let mut watch = TouchObserver::new(model);
    let mut points = Vec::with_capacity(orbit.period as usize);
    let mut state = orbit.start.clone();
    for _ in 0..orbit.period {
        points.push(state.clone());
        kernel.advance(1, &mut state, workspace, &mut watch, &mut counters)?;
    }
    let events = counters.events;
    let motion = watch.motion();
    let [kicked, kicked_linear] =
        KickedTrajectory::new(model, norm, orbit).after_return(kernel, workspace)?;
    let character = Character {
        stable: orbit.attracts(),
        bifurcation: Bifurcation::of(orbit.multipliers.first().copied().unwrap_or_default()),
        events,
        deflection_pp: motion.largest - motion.smallest,
        grazing_margin: watch.of_period().margin(),
        kick_growth: kicked / KICK,
        kick_growth_linear: kicked_linear / KICK,
    };
    Ok((points, character))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::orbits::shooting::shoot;
    use crate::model::{InitialState, OperatingPoint, fixtures};
    use crate::propagate::Volterra;
    use crate::structure::StructureContact;
    use num_complex::c64;

    /// The margin of an orbit that nearly reaches an end stop is its distance from the stop, whatever its
    /// distance from the flanks.
    #[test]
    fn the_margin_is_that_of_any_contact() {
        // Without the transmission error, the depth of the stop depends on δ alone.
        let mut drive = fixtures::two_level_mesh(1e-5);
        drive.transmission_error.clear();
        let point = OperatingPoint {
            load: 2.0,
            speed: 300.0,
        };
        let of_stop = |gap: Option<f64>| {
            let mut structure = fixtures::structure(&[900.0], 0.05, &[1.0], &[1.0]);
            let stop = gap.map(|gap| StructureContact::stop(&[1.0], gap, 1e8));
            structure.contacts = stop.into_iter().collect();
            let model = Model::new(&structure, &drive, point).unwrap();
            let kernel = Volterra::new(&model, f64::EPSILON, 1000);
            let (norm, mut workspace) = (EnergyNorm::new(&model), kernel.workspace());
            let mut start = model.start(&InitialState::Static);
            let mut counters = Counters::default();
            (kernel.advance(300, &mut start, &mut workspace, &mut (), &mut counters)).unwrap();
            let orbit = shoot(&model, &kernel, &norm, &start, 1, &mut workspace)
                .unwrap()
                .unwrap();
            let (_, character) = of(&model, &kernel, &norm, &orbit, &mut workspace).unwrap();
            let mut watch = TouchObserver::new(&model);
            let mut state = orbit.start.clone();
            (kernel.advance(1, &mut state, &mut workspace, &mut watch, &mut counters)).unwrap();
            (character, watch.motion().largest)
        };
        let (alone, largest) = of_stop(None);
        let (at_crossing, _) = of_stop(Some(largest + 1e-8));
        assert!(alone.grazing_margin.unwrap() > 0.1, "{alone:?}");
        let margin = at_crossing.grazing_margin.unwrap();
        assert!((margin - 1e-3).abs() < 1e-9, "{margin}");
        assert!((at_crossing.deflection_pp / alone.deflection_pp - 1.0).abs() < 1e-9);
    }

    #[test]
    fn only_a_multiplier_near_the_circle_or_outside_is_said_to_cross_it() {
        for (multiplier, crossing) in [
            (c64(1.3, 0.0), Some(Bifurcation::Fold)),
            (c64(0.95, 0.0), Some(Bifurcation::Fold)),
            (c64(-1.29, 0.0), Some(Bifurcation::Flip)),
            (c64(-0.91, 0.0), Some(Bifurcation::Flip)),
            (c64(0.6, 0.8), Some(Bifurcation::NeimarkSacker)),
            (c64(0.5, 0.2), None),
            (c64(-0.6, 0.6), None),
            (c64(0.4, 0.0), None),
            (c64(-0.89, 0.0), None),
        ] {
            assert_eq!(Bifurcation::of(multiplier), crossing, "{multiplier}");
        }
    }
}
