//! How much of an unsettled motion was measured, and how long does chaos last? The result files hold these
//! numbers.

use crate::numerics::poisson::rate_interval;
use serde::{Deserialize, Serialize};

/// How much of a motion that does not settle was measured.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct EvidenceOutcome {
    /// Trajectories that were measured.
    pub trajectories: u32,
    /// Whether the error bars meet the conditions under which their coverage was measured.
    pub verified: bool,
    /// Correlation time of the growth of neighbours \[mesh cycles\], from its block error.
    pub correlation_cycles: Option<f64>,
    /// Effective sample size of the averages of growth over ten cycles, as ArviZ defines it.
    pub ess: Option<f64>,
    /// Split R-hat of the same averages.
    pub rhat: Option<f64>,
    /// Frequency of the strongest line of the strobe deflection that is not a simple multiple of the mesh
    /// frequency \[1/cycle\], on a torus.
    pub rotation_number: Option<f64>,
    /// Averages of growth over ten cycles, one trajectory after another, if requested.
    pub chains: Option<GrowthRecord>,
}

/// Averages of the growth of neighbours in every trajectory.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct GrowthRecord {
    /// Number of averages of every trajectory.
    pub lengths: Vec<f64>,
    /// The averages \[1/cycle\], one trajectory after another.
    pub growth: Vec<f64>,
}

/// How long chaos lasts, and on which motions it ends.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct ChaosOutcome {
    /// Mesh cycles in chaos, of all trajectories together.
    pub cycles: u64,
    /// Trajectories that left chaos.
    pub exits: u32,
    /// Trajectories that were measured.
    pub trajectories: u32,
    /// Motions on which these trajectories ended, the most frequent first: class, period, number of trajectories.
    pub ended_on: Option<String>,
    /// Averages over the chaotic parts, if every trajectory left chaos.
    #[serde(rename = "left")]
    pub averages_before_exit: Option<ChaosAverages>,
}

/// Averages over chaos that every trajectory left, each with its standard error.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct ChaosAverages {
    /// Largest exponent \[1/cycle\].
    pub lambda: [f64; 2],
    /// Root mean square of the deflection about its mean \[m\].
    pub deflection_rms: Option<[f64; 2]>,
    /// Standard deviation of the mesh force \[N\].
    pub force_std: Option<[f64; 2]>,
    /// Mean speed of impacts \[m/s\].
    pub impact_velocity: Option<[f64; 2]>,
}

impl ChaosOutcome {
    /// Mean life of chaos \[cycles\]: chaotic cycles over exits; `None` without an exit.
    pub fn lifetime(&self) -> Option<f64> {
        (self.exits > 0).then(|| self.cycles as f64 / f64::from(self.exits))
    }

    /// 95 % interval of the mean life \[cycles\], from the exact interval of a Poisson rate. Without an exit,
    /// the lower end is a bound at 95 %, a third of the chaotic cycles, and there is no upper end.
    pub fn interval(&self) -> (f64, Option<f64>) {
        let cycles = self.cycles as f64;
        if self.exits == 0 {
            return (cycles / 3.0, None);
        }
        let [slow, fast] = rate_interval(u64::from(self.exits), cycles);
        (1.0 / fast, Some(1.0 / slow))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_life_of_chaos_has_the_interval_of_a_poisson_rate() {
        let chaos = |exits| ChaosOutcome {
            cycles: 30_000,
            exits,
            ..ChaosOutcome::default()
        };
        assert_eq!(chaos(0).lifetime(), None);
        assert_eq!(chaos(0).interval(), (10_000.0, None));
        assert_eq!(chaos(3).lifetime(), Some(10_000.0));
        // For three events: 0.6187 to 8.7673.
        let (low, high) = chaos(3).interval();
        assert!((low / (30_000.0 / 8.7673) - 1.0).abs() < 1e-4, "{low}");
        assert!(
            (high.unwrap() / (30_000.0 / 0.6187) - 1.0).abs() < 1e-4,
            "{high:?}"
        );
    }
}
