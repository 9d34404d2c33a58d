//! The sums over a stretch of cycles, and the statistics that follow from them.
//!
//! A statistic is a function of time averages. Its standard error is that of its linearisation (delta
//! method). Each stretch contributes one value: its averages, weighted by the derivatives at the averages of
//! the whole record. The mean of these values has the standard error of the statistic.

use super::block_sums::Summable;
use super::losses::Losses;
use crate::analysis::outcome::NvhStatistics;
use crate::model::{COAST_FLANK, DRIVE_FLANK, FlankState};
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
    /// Time in drive contact, free flight, coast contact and contact on both flanks \[s\].
    pub times: [f64; FlankState::COUNT],
    /// Sum of δ'² at entries into contact, on both flanks of the first mesh \[m²/s²\].
    pub impact_square: f64,
    /// Number and total length \[s\] of flights that ended.
    pub flights: [f64; 2],
    /// Number and total length \[s\] of contacts that ended.
    pub touches: [f64; 2],
    /// ∫ δ e^{−ihωt} dt at mesh orders h = 1, 2, ….
    pub harmonics: Vec<Complex64>,
    /// Sums of each contact, both flanks of the first mesh first.
    pub contacts: Vec<ContactSums>,
}

/// Sums of one contact over a stretch.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct ContactSums {
    /// ∫ s F dt \[N s\].
    pub force: f64,
    /// Time for which the contact is closed \[s\].
    pub closed: f64,
    /// Number of entries into contact.
    pub impacts: f64,
    /// Sum of |δ'| at entries \[m/s\].
    pub speed: f64,
    /// Energy lost in friction \[J\].
    pub loss: f64,
}

impl Sums {
    /// Empty sums for some harmonics and contacts.
    pub(super) fn empty(harmonics: usize, contacts: usize) -> Self {
        Self {
            harmonics: vec![Complex64::ZERO; harmonics],
            contacts: vec![ContactSums::default(); contacts],
            ..Self::default()
        }
    }

    /// Energy lost in friction on the flanks of the first mesh \[J\].
    pub(super) fn loss_of_first(&self) -> f64 {
        self.contacts[DRIVE_FLANK].loss + self.contacts[COAST_FLANK].loss
    }
}

impl Sums {
    /// Moves the centres down, by d half gaps for δ and by e newtons for F. The new sums follow from
    /// the sums about the present centres by the binomial formula.
    pub(super) fn recentre(&mut self, [d, e]: [f64; 2]) {
        let (t, [m1, m2, m3, m4]) = (self.time, self.moments);
        self.moments = [
            m1 + d * t,
            m2 + d * (2.0 * m1 + d * t),
            m3 + d * (3.0 * m2 + d * (3.0 * m1 + d * t)),
            m4 + d * (4.0 * m3 + d * (6.0 * m2 + d * (4.0 * m1 + d * t))),
        ];
        let [f1, f2] = self.force;
        self.force = [f1 + e * t, f2 + e * (2.0 * f1 + e * t)];
    }
}

impl Summable for Sums {
    fn add(&mut self, other: &Self) {
        self.time += other.time;
        self.moments.add(&other.moments);
        self.force.add(&other.force);
        self.times.add(&other.times);
        self.impact_square += other.impact_square;
        self.flights.add(&other.flights);
        self.touches.add(&other.touches);
        for (sum, value) in self.harmonics.iter_mut().zip(&other.harmonics) {
            *sum += value;
        }
        for (sum, other) in self.contacts.iter_mut().zip(&other.contacts) {
            sum.force += other.force;
            sum.closed += other.closed;
            sum.impacts += other.impacts;
            sum.loss += other.loss;
            sum.speed += other.speed;
        }
    }

    fn clear(&mut self) {
        let mut harmonics = std::mem::take(&mut self.harmonics);
        let mut contacts = std::mem::take(&mut self.contacts);
        harmonics.fill(Complex64::ZERO);
        contacts.fill(ContactSums::default());
        *self = Self {
            harmonics,
            contacts,
            ..Self::default()
        };
    }
}

/// The centres about which powers are summed, and the units of the statistics.
#[derive(Debug, Clone, Copy)]
pub(super) struct Origin {
    /// Mean δ \[m\] and F \[N\] of the first window. If the mesh hardly moves under load, the round-off of
    /// sums about zero would hide its motion.
    pub centre: [f64; 2],
    /// Half gap b \[m\].
    pub half_gap: f64,
    /// Effective mass of an impact \[kg\].
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
pub(super) fn statistics(sums: &Sums, origin: Origin) -> NvhStatistics {
    let moments = sums.moments.map(|m| m / sums.time);
    let [variance, fourth] = central(moments);
    let [force_first, force_square] = sums.force.map(|f| f / sums.time);
    let [impact_speed, impacts] = impact_speed(sums);
    let each = |of: fn(&ContactSums) -> f64| -> Vec<f64> {
        (sums.contacts.iter().map(|contact| of(contact) / sums.time)).collect()
    };
    NvhStatistics {
        deflection_mean: origin.centre[0] + origin.half_gap * moments[0],
        deflection_rms: origin.half_gap * variance.sqrt(),
        deflection_kurtosis: ratio(fourth, variance * variance),
        harmonics: (sums.harmonics.iter())
            .map(|sum| 2.0 * sum.norm() / sums.time)
            .collect(),
        force_mean: origin.centre[1] + force_first,
        force_std: (force_square - force_first * force_first).max(0.0).sqrt(),
        impact_rate: impacts / sums.time,
        impact_velocity: ratio(impact_speed, impacts),
        impact_power: 0.5 * origin.effective_mass * sums.impact_square / sums.time,
        rattle_index: impact_speed / sums.time,
        fractions: sums.times.map(|t| t / sums.time),
        contact_force: each(|contact| contact.force),
        contact_fraction: each(|contact| contact.closed),
        contact_impact_rate: each(|contact| contact.impacts),
        contact_rattle_index: each(|contact| contact.speed),
        ..NvhStatistics::default()
    }
}

/// A quotient; 0 if its denominator is not positive, as for a motionless mesh.
pub(super) fn ratio(numerator: f64, denominator: f64) -> f64 {
    if denominator > 0.0 { numerator / denominator } else { 0.0 }
}

/// How the sums of one stretch change the statistics, for their standard errors. The statistics are
/// linearised at the averages over all stretches, which are stored here.
struct Influence<'a> {
    total: &'a Sums,
    /// Averages of powers of the deflection.
    moments: [f64; 4],
    /// Standard deviation of the deflection in half gaps.
    spread: f64,
    /// Mean force about its centre, and its standard deviation \[N\].
    force: f64,
    force_spread: f64,
}

impl<'a> Influence<'a> {
    fn of(total: &'a Sums) -> Self {
        let moments = total.moments.map(|m| m / total.time);
        let [f1, f2] = total.force.map(|f| f / total.time);
        Self {
            total,
            moments,
            spread: central(moments)[0].sqrt(),
            force: f1,
            force_spread: (f2 - f1 * f1).max(0.0).sqrt(),
        }
    }

    fn variance(&self, [a1, a2, _, _]: [f64; 4]) -> f64 {
        a2 - 2.0 * self.moments[0] * a1
    }

    /// Influence on the standard deviation of the deflection in half gaps.
    fn rms(&self, s: &Sums) -> f64 {
        ratio(0.5 * self.variance(s.moments), self.spread)
    }

    /// Influence on the standard deviation of the force.
    fn force_std(&self, s: &Sums) -> f64 {
        let variance = s.force[1] - 2.0 * self.force * s.force[0];
        ratio(0.5 * variance, self.force_spread)
    }

    /// Influence on the amplitude of a mesh order.
    fn harmonic(&self, s: &Sums, h: usize) -> f64 {
        let sum = self.total.harmonics[h];
        ratio(2.0 * (sum.conj() * s.harmonics[h]).re, sum.norm())
    }

    /// Influence on the quotient of two sums; `None` if the denominator is zero.
    fn quotient<'p>(
        &self,
        pick: &'p dyn Fn(&Sums) -> [f64; 2],
    ) -> Option<impl Fn(&Sums) -> f64 + 'p> {
        let [over, under] = pick(self.total);
        let quotient = over / under;
        let rate = under / self.total.time;
        (under != 0.0).then_some(move |s: &Sums| {
            let [over, under] = pick(s);
            ratio(over - quotient * under, rate)
        })
    }
}

/// The influence of each stretch divided by its length in time, in order of time.
fn series(stretches: &[Sums], influence: &dyn Fn(&Sums) -> f64) -> Vec<f64> {
    stretches.iter().map(|s| influence(s) / s.time).collect()
}

/// Sum of the speeds of impacts on both flanks of the first mesh, and number of impacts.
fn impact_speed(s: &Sums) -> [f64; 2] {
    let [drive, coast] = [&s.contacts[0], &s.contacts[1]];
    [drive.speed + coast.speed, drive.impacts + coast.impacts]
}

/// Series with one value per stretch, in order of time, by the names of columns. The mean of each series has
/// the error of its statistic. Contains only statistics that the motion has.
pub(super) fn statistics_for_stop_rule(
    stretches: &[Sums],
    total: &Sums,
    origin: Origin,
) -> Vec<(&'static str, Vec<f64>)> {
    let all = Influence::of(total);
    let mut watched = Vec::new();
    if all.spread > 0.0 {
        let rms = |s: &Sums| origin.half_gap * all.rms(s);
        watched.push(("deflection_rms", series(stretches, &rms)));
    }
    if all.force_spread > 0.0 {
        watched.push(("force_std", series(stretches, &|s| all.force_std(s))));
    }
    if let Some(speed) = all.quotient(&impact_speed) {
        watched.push(("impact_velocity", series(stretches, &speed)));
    }
    if total.harmonics.first().is_some_and(|sum| sum.norm() > 0.0) {
        watched.push(("harmonics", series(stretches, &|s| all.harmonic(s, 0))));
    }
    watched
}

/// Standard errors of [`statistics`], from stretches of equal length that make up `total`;
/// those of distributions are left at zero.
pub(super) fn errors(
    stretches: &[Sums],
    total: &Sums,
    origin: Origin,
    losses: Option<&Losses>,
) -> NvhStatistics {
    let half_gap = origin.half_gap;
    let all = Influence::of(total);
    // Standard error of the mean over stretches of a weighted sum of their time averages.
    let error = |influence: &dyn Fn(&Sums) -> f64| standard_error(&series(stretches, influence));
    let of_quotient = |pick: &dyn Fn(&Sums) -> [f64; 2]| {
        (all.quotient(pick)).map_or(f64::INFINITY, |influence| error(&influence))
    };
    let [m1, m2, m3, _] = all.moments;
    let [variance, fourth] = central(all.moments);
    let kurtosis = ratio(fourth, variance * variance);
    let of_fourth = |[a1, a2, a3, a4]: [f64; 4]| {
        let by_first = -4.0 * m3 + 12.0 * m1 * m2 - 12.0 * m1.powi(3);
        a4 - 4.0 * m1 * a3 + 6.0 * m1 * m1 * a2 + by_first * a1
    };
    let each = |of: fn(&ContactSums) -> f64| -> Vec<f64> {
        let contacts = 0..total.contacts.len();
        contacts
            .map(|contact| error(&|s| of(&s.contacts[contact])))
            .collect()
    };
    let harmonics = (0..total.harmonics.len()).map(|h| error(&|s| all.harmonic(s, h)));
    let mut errors = NvhStatistics {
        deflection_mean: half_gap * error(&|s| s.moments[0]),
        deflection_rms: half_gap * error(&|s| all.rms(s)),
        deflection_kurtosis: error(&|s| {
            let change = of_fourth(s.moments) - 2.0 * kurtosis * variance * all.variance(s.moments);
            ratio(change, variance * variance)
        }),
        harmonics: harmonics.collect(),
        contact_force: each(|contact| contact.force),
        contact_fraction: each(|contact| contact.closed),
        contact_impact_rate: each(|contact| contact.impacts),
        contact_rattle_index: each(|contact| contact.speed),
        force_mean: error(&|s| s.force[0]),
        force_std: error(&|s| all.force_std(s)),
        impact_rate: error(&|s| impact_speed(s)[1]),
        impact_velocity: of_quotient(&impact_speed),
        impact_power: 0.5 * origin.effective_mass * error(&|s| s.impact_square),
        rattle_index: error(&|s| impact_speed(s)[0]),
        flight_mean: Some(of_quotient(&|s| [s.flights[1], s.flights[0]])),
        contact_mean: Some(of_quotient(&|s| [s.touches[1], s.touches[0]])),
        fractions: [0, 1, 2, 3].map(|i| error(&|s| s.times[i])),
        ..NvhStatistics::default()
    };
    if let Some(losses) = losses {
        // Power through the mesh is positive in its mean direction.
        let through = |s: &Sums| losses.base_speed() * (s.force[0] + origin.centre[1] * s.time);
        let sense = through(total).signum();
        let quotient = of_quotient(&|s| [s.loss_of_first(), sense * through(s)]);
        errors.contact_loss = each(|contact| contact.loss);
        losses.write_errors(quotient, error(&|s| s.loss_of_first()), &mut errors);
    }
    errors
}
