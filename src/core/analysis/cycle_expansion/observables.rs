//! Which quantities are averaged over orbits, and their sums over mesh cycles.
//!
//! What is summed is additive along a trajectory; a root mean square follows from two sums.

use crate::analysis::modal_series::padded;
use crate::analysis::nvh::rule::Rules;
use crate::model::{Flanks, Model};
use crate::numerics::legendre::variation;
use crate::propagate::{Event, InstructionSet, Observer, Window};
use serde::{Deserialize, Serialize};

/// Sums of a mesh cycle.
pub const SUMS: usize = 7;

/// Sums over mesh cycles: of the mean deflection in half gaps and of its square, of the force that
/// presses flanks together and its largest value \[N\], of the share of free flight, of events, and
/// of the growth of the fastest tangent.
pub type Sums = [f64; SUMS];

/// Place of the growth among the sums, which no observer sees.
pub const GROWTH: usize = 6;

/// What is averaged.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum ExpansionQuantity {
    /// Mean mesh deflection \[m\].
    DeflectionMean,
    /// Its root mean square about the mean \[m\].
    DeflectionRms,
    /// Mean force that presses flanks together, on either side \[N\].
    ContactForce,
    /// Mean over mesh cycles of the largest such force in each \[N\].
    CyclePeak,
    /// Share of the time in free flight.
    FractionFree,
    /// Contact-state changes a mesh cycle.
    EventsPerCycle,
    /// Largest Lyapunov exponent \[1/cycle\].
    LambdaMax,
}

impl ExpansionQuantity {
    /// All of them, in the order of result files.
    pub const ALL: [Self; 7] = [
        Self::DeflectionMean,
        Self::DeflectionRms,
        Self::ContactForce,
        Self::CyclePeak,
        Self::FractionFree,
        Self::EventsPerCycle,
        Self::LambdaMax,
    ];

    /// The word stored in result files.
    pub fn name(self) -> &'static str {
        match self {
            Self::DeflectionMean => "deflection_mean",
            Self::DeflectionRms => "deflection_rms",
            Self::ContactForce => "contact_force",
            Self::CyclePeak => "cycle_peak",
            Self::FractionFree => "fraction_free",
            Self::EventsPerCycle => "events_per_cycle",
            Self::LambdaMax => "lambda_max",
        }
    }

    /// Its value from sums averaged over mesh cycles.
    pub fn of(self, sums: &Sums, half_gap: f64) -> f64 {
        let [mean, square, force, peak, free, events, growth] = *sums;
        match self {
            Self::DeflectionMean => half_gap * mean,
            Self::DeflectionRms => half_gap * (square - mean * mean).max(0.0).sqrt(),
            Self::ContactForce => force,
            Self::CyclePeak => peak,
            Self::FractionFree => free,
            Self::EventsPerCycle => events,
            Self::LambdaMax => growth,
        }
    }

    /// Its value from sums near `about`, but for a constant, to first order in their distance: what
    /// the standard error of a function of averages is taken of.
    pub fn linear(self, sums: &Sums, about: &Sums, half_gap: f64) -> f64 {
        match self {
            Self::DeflectionRms => {
                let root = self.of(about, half_gap) / half_gap;
                half_gap * (sums[1] - 2.0 * about[0] * sums[0]) / (2.0 * root)
            }
            _ => self.of(sums, half_gap),
        }
    }
}

/// Adds up what is averaged, mesh cycle by mesh cycle.
pub struct Cycles<'m> {
    model: &'m Model,
    set: InstructionSet,
    sums: Sums,
    peak: f64,
}

impl<'m> Cycles<'m> {
    /// Nothing added yet.
    pub fn new(model: &'m Model) -> Self {
        Self {
            model,
            set: InstructionSet::best(),
            sums: [0.0; SUMS],
            peak: 0.0,
        }
    }

    /// The sums of the mesh cycle that is over, for the next to begin.
    pub fn close(&mut self) -> Sums {
        let mut sums = std::mem::replace(&mut self.sums, [0.0; SUMS]);
        sums[3] = std::mem::take(&mut self.peak);
        sums
    }
}

impl Observer for Cycles<'_> {
    const WINDOWS: bool = true;

    fn window(&mut self, window: &Window<'_>) {
        let share = window.duration / self.model.period();
        let half_gap = self.model.half_gap;
        let deflection = padded(window.deflection);
        self.sums[0] += share * deflection[0] / half_gap;
        for (n, a) in deflection.iter().enumerate() {
            let a = a / half_gap;
            self.sums[1] += share * a * a / (2 * n + 1) as f64;
        }
        let closed = window.closed.iter();
        for closed in closed.filter(|closed| self.model.of_mesh(closed.contact)) {
            let side = self.model.contacts[closed.contact].side;
            let force = padded(closed.force).map(|f| side * f);
            self.sums[2] += share * force[0];
            if force[0] + variation(&force) > self.peak {
                let largest = Rules::shared().maximum(self.set, &force);
                self.peak = self.peak.max(largest);
            }
        }
        if window.contact.flanks() == Flanks::Free {
            self.sums[4] += share;
        }
    }

    fn event(&mut self, _: &Event) {
        self.sums[5] += 1.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{InitialState, fixtures};
    use crate::propagate::{Counters, Kernel, Volterra};
    use crate::structure::StructureContact;

    /// A preloaded stop of a mode that the flanks do not feel bears a force that is not theirs.
    #[test]
    fn the_contact_force_is_that_of_the_flanks() {
        let mean = |with_stop: bool| {
            let mut structure =
                fixtures::structure(&[900.0, 700.0], 0.02, &[1.0, 0.0], &[1.0, 0.0]);
            if with_stop {
                structure.contacts = vec![StructureContact::stop(&[0.0, 1.0], -1e-6, 1e8)];
            }
            let drive = fixtures::two_level_mesh(1e-5);
            let model = Model::new(&structure, &drive, fixtures::strong_rattle()).unwrap();
            let kernel = Volterra::new(&model, f64::EPSILON, 1000);
            let mut trajectory = model.start(&InitialState::Static);
            let mut cycles = Cycles::new(&model);
            kernel
                .advance(
                    3,
                    &mut trajectory,
                    &mut kernel.workspace(),
                    &mut cycles,
                    &mut Counters::default(),
                )
                .unwrap();
            let sums = cycles.close();
            [2, 3].map(|index| sums[index])
        };
        let (alone, beside) = (mean(false), mean(true));
        for (alone, beside) in alone.into_iter().zip(beside) {
            assert!(
                alone > 1.0 && (beside / alone - 1.0).abs() < 1e-9,
                "{beside} {alone}"
            );
        }
    }
}
