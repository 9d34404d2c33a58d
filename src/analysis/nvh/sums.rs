//! What is added up over a stretch of cycles, and the statistics that follow from it.
//!
//! A statistic is a function of time averages. Its standard error is that of its
//! linearisation: the averages of a stretch, weighted by the derivatives at the averages of
//! the whole record, form a series in time whose mean has the error sought (delta method).

use super::losses::Losses;
use super::stretches::Summable;
use crate::analysis::outcome::{NvhErrors, NvhOutcome};
use crate::model::Flanks;
use crate::numerics::statistics::standard_error;
use num_complex::Complex64;

/// Sums over a stretch.
#[derive(Debug, Clone, Default)]
pub(super) struct Sums {
    /// Time \[s\].
    pub time: f64,
    /// ∫ ((δ − centre)/b)^j dt, j = 1 … 4.
    pub moments: [f64; 4],
    /// ∫ (F − centre)^j dt, j = 1, 2.
    pub force: [f64; 2],
    /// Energy lost in friction \[J\].
    pub loss: f64,
    /// Time in drive contact, free flight, coast contact and contact on both flanks \[s\].
    pub times: [f64; Flanks::COUNT],
    /// Entries into contact on the drive and on the coast flank.
    pub impacts: [f64; 2],
    /// Sum of |δ'| at entries \[m/s\].
    pub impact_speed: f64,
    /// Sum of δ'² at entries \[m²/s²\].
    pub impact_square: f64,
    /// Number and total length \[s\] of flights that ended.
    pub flights: [f64; 2],
    /// The same of contacts.
    pub touches: [f64; 2],
    /// ∫ δ e^{−ihωt} dt, h = 1, 2, ….
    pub harmonics: Vec<Complex64>,
}

impl Sums {
    /// Nothing, with room for some harmonics.
    pub(super) fn empty(harmonics: usize) -> Self {
        Self {
            harmonics: vec![Complex64::ZERO; harmonics],
            ..Self::default()
        }
    }
}

impl Summable for Sums {
    fn add(&mut self, other: &Self) {
        self.time += other.time;
        self.moments.add(&other.moments);
        self.force.add(&other.force);
        self.loss += other.loss;
        self.times.add(&other.times);
        self.impacts.add(&other.impacts);
        self.impact_speed += other.impact_speed;
        self.impact_square += other.impact_square;
        self.flights.add(&other.flights);
        self.touches.add(&other.touches);
        for (sum, value) in self.harmonics.iter_mut().zip(&other.harmonics) {
            *sum += value;
        }
    }

    fn clear(&mut self) {
        let mut harmonics = std::mem::take(&mut self.harmonics);
        harmonics.fill(Complex64::ZERO);
        *self = Self {
            harmonics,
            ..Self::default()
        };
    }
}

/// What powers are taken about, and the unit of deflections.
#[derive(Debug, Clone, Copy)]
pub(super) struct Origin {
    /// Mean δ \[m\] and F \[N\] of the first window: about zero, the spread of a mesh that
    /// hardly moves under load would drown in the round-off of its mean.
    pub centre: [f64; 2],
    /// Half gap b \[m\].
    pub half_gap: f64,
    /// Mass that meets in an impact \[kg\].
    pub effective_mass: f64,
}

/// Second and fourth central moments.
fn central([m1, m2, m3, m4]: [f64; 4]) -> [f64; 2] {
    [
        (m2 - m1 * m1).max(0.0),
        m4 - 4.0 * m1 * m3 + 6.0 * m1 * m1 * m2 - 3.0 * m1.powi(4),
    ]
}

/// The statistics that follow from sums alone; extremes and distributions are left at zero.
pub(super) fn statistics(sums: &Sums, origin: Origin) -> NvhOutcome {
    let moments = sums.moments.map(|m| m / sums.time);
    let [variance, fourth] = central(moments);
    let [force_first, force_square] = sums.force.map(|f| f / sums.time);
    let impacts = sums.impacts[0] + sums.impacts[1];
    NvhOutcome {
        deflection_mean: origin.centre[0] + origin.half_gap * moments[0],
        deflection_rms: origin.half_gap * variance.sqrt(),
        deflection_kurtosis: ratio(fourth, variance * variance),
        harmonics: (sums.harmonics.iter())
            .map(|sum| 2.0 * sum.norm() / sums.time)
            .collect(),
        force_mean: origin.centre[1] + force_first,
        force_std: (force_square - force_first * force_first).max(0.0).sqrt(),
        impacts: sums.impacts.map(|count| count as u64),
        impact_rate: impacts / sums.time,
        impact_velocity: ratio(sums.impact_speed, impacts),
        impact_power: 0.5 * origin.effective_mass * sums.impact_square / sums.time,
        rattle_index: sums.impact_speed / sums.time,
        fractions: sums.times.map(|t| t / sums.time),
        ..NvhOutcome::default()
    }
}

/// A quotient whose denominator may be zero (a motionless mesh): then 0.
pub(super) fn ratio(numerator: f64, denominator: f64) -> f64 {
    if denominator > 0.0 {
        numerator / denominator
    } else {
        0.0
    }
}

/// Standard errors of [`statistics`], from stretches of equal length that make up `total`;
/// those of distributions are left at zero.
pub(super) fn errors(
    stretches: &[Sums],
    total: &Sums,
    origin: Origin,
    losses: Option<&Losses>,
) -> NvhErrors {
    let half_gap = origin.half_gap;
    // Of the mean over stretches of a weighted sum of their time averages.
    let error = |influence: &dyn Fn(&Sums) -> f64| {
        let series: Vec<f64> = stretches.iter().map(|s| influence(s) / s.time).collect();
        standard_error(&series)
    };
    // Of the quotient of two sums.
    let of_quotient = |pick: &dyn Fn(&Sums) -> [f64; 2]| {
        let [over, under] = pick(total);
        if under == 0.0 {
            return f64::INFINITY;
        }
        let quotient = over / under;
        let rate = under / total.time;
        error(&|s| {
            let [over, under] = pick(s);
            ratio(over - quotient * under, rate)
        })
    };
    let [m1, m2, m3, m4] = total.moments.map(|m| m / total.time);
    let [variance, fourth] = central([m1, m2, m3, m4]);
    let spread = variance.sqrt();
    let kurtosis = ratio(fourth, variance * variance);
    let of_variance = |[a1, a2, _, _]: [f64; 4]| a2 - 2.0 * m1 * a1;
    let of_fourth = |[a1, a2, a3, a4]: [f64; 4]| {
        let by_first = -4.0 * m3 + 12.0 * m1 * m2 - 12.0 * m1.powi(3);
        a4 - 4.0 * m1 * a3 + 6.0 * m1 * m1 * a2 + by_first * a1
    };
    let [f1, f2] = total.force.map(|f| f / total.time);
    let force_spread = (f2 - f1 * f1).max(0.0).sqrt();
    let harmonics = (0..total.harmonics.len()).map(|h| {
        let sum = total.harmonics[h];
        error(&|s| ratio(2.0 * (sum.conj() * s.harmonics[h]).re, sum.norm()))
    });
    let mut found = NvhErrors {
        deflection_mean: half_gap * error(&|s| s.moments[0]),
        deflection_rms: half_gap * error(&|s| ratio(0.5 * of_variance(s.moments), spread)),
        deflection_kurtosis: error(&|s| {
            let change = of_fourth(s.moments) - 2.0 * kurtosis * variance * of_variance(s.moments);
            ratio(change, variance * variance)
        }),
        harmonics: harmonics.collect(),
        force_mean: error(&|s| s.force[0]),
        force_std: error(&|s| ratio(0.5 * (s.force[1] - 2.0 * f1 * s.force[0]), force_spread)),
        impact_rate: error(&|s| s.impacts[0] + s.impacts[1]),
        impact_velocity: of_quotient(&|s| [s.impact_speed, s.impacts[0] + s.impacts[1]]),
        impact_power: 0.5 * origin.effective_mass * error(&|s| s.impact_square),
        rattle_index: error(&|s| s.impact_speed),
        flight_mean: of_quotient(&|s| [s.flights[1], s.flights[0]]),
        contact_mean: of_quotient(&|s| [s.touches[1], s.touches[0]]),
        fractions: [0, 1, 2, 3].map(|i| error(&|s| s.times[i])),
        power_loss: f64::INFINITY,
        power_transmitted: f64::INFINITY,
        efficiency: f64::INFINITY,
        ..NvhErrors::default()
    };
    if let Some(losses) = losses {
        // What goes through the mesh counts in the sense that it has on the whole.
        let through = |s: &Sums| losses.base_speed() * (s.force[0] + origin.centre[1] * s.time);
        let sense = through(total).signum();
        let quotient = of_quotient(&|s| [s.loss, sense * through(s)]);
        losses.tell_errors(quotient, error(&|s| s.loss), &mut found);
    }
    found
}
