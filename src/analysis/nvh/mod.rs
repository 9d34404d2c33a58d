//! What would be heard and felt: statistics of deflection, force and impacts.
//!
//! Every integral is taken from the windows' polynomials, none from samples:
//!
//! ```text
//! ∫ δ dt = Δ a₀,   ∫ δ² dt = Δ Σ a_n²/(2n+1),   ∫ δ³, δ⁴: Gauss rule, exact to round-off
//! ∫ δ e^{−iωt} dt = Σ a_n ∫ P_n e^{−iωt} dt     (Bessel series of the exponential)
//! ```
//!
//! A motion that repeats is measured over whole periods and has exact statistics; any other
//! gets standard errors from its averages over successive stretches of ten mesh cycles.

mod contacts;
mod fourier;
mod losses;
pub(super) mod rule;
pub(super) mod stretches;
mod sums;

use super::modal_series::{Series, padded};
use super::outcome::{DurationOutcome, NvhErrors, NvhOutcome};
use crate::model::Model;
use crate::numerics::legendre::variation;
use crate::numerics::statistics::{FEWEST_BLOCKS, standard_error};
use crate::propagate::{Event, Observer, Window};
use contacts::Contacts;
use fourier::Fourier;
use losses::Losses;
use rule::{Rule, Rules, SHORT, falls_off};
use stretches::Stretches;
use sums::{Origin, Sums, ratio};

/// Mesh cycles in a stretch, as for the exponents.
const CYCLES_PER_STRETCH: u64 = 10;

/// Shares at which the speeds of impacts are told.
const SHARES: [f64; 3] = [0.5, 0.9, 0.99];

/// Accumulates statistics while a trajectory is integrated.
#[derive(Debug, Clone)]
pub struct Nvh {
    period: f64,
    rules: &'static Rules,
    origin: Origin,
    /// First and present mesh cycle; none before any window.
    cycles: Option<[u64; 2]>,
    stretches: Stretches<Sums>,
    smallest: f64,
    largest: f64,
    force_peak: f64,
    contacts: Contacts,
    /// None where no orders were asked for.
    fourier: Option<Fourier>,
    repeats: Option<u32>,
    /// None where no drawing says how the gears roll.
    losses: Option<Losses>,
}

impl Nvh {
    /// Statistics of a model with amplitudes at the first `harmonics` mesh orders; without
    /// any, fractions of the mesh order are left out as well.
    pub fn new(model: &Model, harmonics: usize) -> Self {
        let mesh_frequency = std::f64::consts::TAU / model.period();
        Self {
            period: model.period(),
            rules: Rules::shared(),
            origin: Origin {
                centre: [0.0; 2],
                half_gap: model.half_gap,
                effective_mass: model.effective_mass,
            },
            cycles: None,
            stretches: Stretches::new(Sums::empty(harmonics), CYCLES_PER_STRETCH),
            smallest: f64::INFINITY,
            largest: f64::NEG_INFINITY,
            force_peak: 0.0,
            contacts: Contacts::new(model),
            fourier: (harmonics > 0).then(|| Fourier::new(mesh_frequency, harmonics)),
            repeats: None,
            losses: Losses::of(model),
        }
    }

    /// Forgets everything accumulated.
    pub fn restart(&mut self) {
        self.cycles = None;
        self.stretches.restart();
        self.smallest = f64::INFINITY;
        self.largest = f64::NEG_INFINITY;
        self.force_peak = 0.0;
        self.contacts.restart();
        if let Some(fourier) = &mut self.fourier {
            fourier.suborders.restart();
        }
        self.repeats = None;
    }

    /// Says that the motion measured repeats after `period` mesh cycles, whole periods of
    /// which were integrated: its statistics are exact.
    pub fn repeats(&mut self, period: u32) {
        self.repeats = Some(period);
    }

    /// The statistics so far, whole mesh cycles having been integrated; none before any window.
    pub fn outcome(&self) -> Option<NvhOutcome> {
        let [first, present] = self.cycles?;
        // The cycle integrated last is over, though no window has shown it.
        let mut closed = self.clone();
        closed.advance();
        let mut total = closed.stretches.total();
        if self.repeats.is_some() {
            (closed.contacts).close_circle(first, present + 1, &mut total);
        }
        let mut found = sums::statistics(&total, self.origin);
        found.cycles = present - first + 1;
        found.deflection_pp = self.largest - self.smallest;
        let reach =
            (self.largest - found.deflection_mean).max(found.deflection_mean - self.smallest);
        found.deflection_crest = ratio(reach, found.deflection_rms);
        found.force_peak = self.force_peak;
        if let Some(losses) = &self.losses {
            losses.tell(total.loss / total.time, &mut found);
        }
        found.impact_velocity_max = closed.contacts.fastest();

        let speeds = SHARES.map(|share| closed.contacts.speed(share));
        if let [Some(a), Some(b), Some(c)] = speeds {
            found.impact_velocity_quantiles = vec![a.0, b.0, c.0];
        }
        let medians = closed.contacts.medians();
        let stay = |[count, time]: [f64; 2], median: Option<(f64, f64)>| DurationOutcome {
            count: count as u64,
            mean: (count > 0.0).then(|| time / count),
            median: median.map(|(value, _)| value),
        };
        found.flights = stay(total.flights, medians[0]);
        found.contacts = stay(total.touches, medians[1]);

        let mut suborder_errors = Vec::new();
        if let Some(Fourier { suborders, .. }) = &closed.fourier {
            found.suborders = match self.repeats {
                Some(period) => suborders.of_periodic(period, total.time),
                None => {
                    let [values, errors] = suborders.of_windows(standard_error);
                    suborder_errors = errors;
                    values
                }
            };
        }
        let stretches = closed.stretches.closed();
        if self.repeats.is_none() && stretches.len() >= FEWEST_BLOCKS {
            let error = |known: Option<(f64, f64)>| known.map_or(f64::INFINITY, |(_, e)| e);
            found.stderr = Some(NvhErrors {
                suborders: suborder_errors,
                impact_velocity_quantiles: match found.impact_velocity_quantiles.is_empty() {
                    true => Vec::new(),
                    false => speeds.map(error).to_vec(),
                },
                flight_median: error(medians[0]),
                contact_median: error(medians[1]),
                ..sums::errors(stretches, &total, self.origin, self.losses.as_ref())
            });
        }
        Some(found)
    }

    /// A mesh cycle is over.
    fn advance(&mut self) {
        self.stretches.advance();
        if let Some(fourier) = &mut self.fourier {
            fourier.suborders.advance(self.period);
        }
    }

    /// Extremes of a window whose bounds do not show that it holds no new one.
    fn extremes<const M: usize>(
        &mut self,
        rule: &Rule<M>,
        deflection: &Series,
        force: &Series,
        values: &[f64; M],
    ) {
        let spread = variation(deflection);
        if deflection[0] + spread > self.largest {
            self.largest = self.largest.max(rule.maximum(deflection, values));
        }
        if deflection[0] - spread < self.smallest {
            self.smallest = self.smallest.min(rule.minimum(deflection, values));
        }
        if force[0].abs() + variation(force) > self.force_peak {
            // Contact damping pulls before it lets go: either sign may be the larger.
            let values = rule.values(force);
            let [high, low] = [rule.maximum(force, &values), rule.minimum(force, &values)];
            self.force_peak = self.force_peak.max(high).max(-low);
        }
    }

    /// Adds a window by a rule that serves it.
    fn add<const M: usize>(
        &mut self,
        rule: &Rule<M>,
        window: &Window<'_>,
        deflection: &Series,
        force: &Series,
    ) {
        let tau = window.duration;
        let values = rule.values(deflection);
        self.extremes(rule, deflection, force, &values);

        let Origin {
            centre, half_gap, ..
        } = self.origin;
        let sums = self.stretches.open();
        sums.time += tau;
        sums.times[window.contact.flanks().index()] += tau;
        let powers = rule.powers(&values, centre[0], half_gap);
        for (moment, power) in sums.moments.iter_mut().zip(powers) {
            *moment += tau * power;
        }
        if let Some(losses) = &self.losses {
            sums.loss += losses.over(window);
        }
        let mut about = *force;
        about[0] -= centre[1];
        sums.force[0] += tau * about[0];
        for (n, f) in about.iter().enumerate() {
            sums.force[1] += tau * f * f / (2 * n + 1) as f64;
        }
        if let Some(fourier) = &mut self.fourier {
            fourier.add(window, deflection, rule, &values, &mut sums.harmonics);
        }
    }
}

impl Observer for Nvh {
    const WINDOWS: bool = true;

    fn window(&mut self, window: &Window<'_>) {
        let tau = window.duration;
        let deflection = padded(window.deflection);
        let force = padded(window.force);
        match &mut self.cycles {
            None => {
                self.cycles = Some([window.cycle; 2]);
                self.origin.centre = [deflection[0], force[0]];
            }
            Some([_, present]) if *present != window.cycle => {
                *present = window.cycle;
                self.advance();
            }
            Some(_) => {}
        }
        let turns = self.fourier.as_ref().map_or(0.0, |f| f.half_turn(tau));
        if turns <= Rule::<SHORT>::WIDEST_TURN && falls_off(&deflection, self.origin.centre[0]) {
            self.add(&self.rules.short, window, &deflection, &force);
        } else {
            self.add(&self.rules.long, window, &deflection, &force);
        }
    }

    fn event(&mut self, event: &Event) {
        self.contacts.event(event, self.stretches.open());
    }
}
