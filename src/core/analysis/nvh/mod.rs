//! Noise, vibration and harshness: statistics of deflection, force and impacts.
//!
//! All integrals are those of the windows' polynomials, without sampling:
//!
//! ```text
//! ∫ δ dt = Δ a₀,   ∫ δ² dt = Δ Σ a_n²/(2n+1),   ∫ δ³, δ⁴: Gauss rule, exact to round-off
//! ∫ δ e^{−iωt} dt = Σ a_n ∫ P_n e^{−iωt} dt     (Bessel functions, or the same Gauss rule)
//! ```
//!
//! A periodic motion is measured over whole periods and has exact statistics. Any other motion has standard
//! errors from averages over successive stretches of ten mesh cycles.

pub(super) mod block_sums;
mod contacts;
mod fourier;
mod lanes;
mod losses;
mod peaks;
pub(super) mod rule;
mod sample;
mod sums;

use super::modal_series::{Series, padded};
use super::outcome::{NvhOutcome, NvhStatistics};
use crate::model::{Model, Release};
use crate::numerics::statistics::{FEWEST_VALUES, standard_error};
use crate::propagate::{Event, InstructionSet, Observer, Window};
use block_sums::BlockSums;
use contacts::{Contacts, FLANKS};
use fourier::Fourier;
use losses::Losses;
use peaks::{Extremes, Peaks};
use rule::Rules;
use std::borrow::Cow;
use sums::{Origin, Sums, ratio};

/// Mesh cycles in a stretch, as for the exponents.
const CYCLES_PER_STRETCH: u64 = 10;

/// Probabilities of the quantiles of impact speeds.
const QUANTILES: [f64; 3] = [0.5, 0.9, 0.99];

/// Accumulates statistics while a trajectory is integrated.
#[derive(Debug, Clone)]
pub struct Nvh {
    rules: &'static Rules,
    set: InstructionSet,
    origin: Origin,
    /// Whether the origin is that of another trajectory. Windows then do not change it.
    shares_origin: bool,
    /// First and present mesh cycle; `None` before the first window.
    cycles: Option<[u64; 2]>,
    /// Whether the present cycle is still to be counted.
    open: bool,
    /// Number of complete mesh cycles.
    over: u64,
    stretches: BlockSums<Sums>,
    peaks: Peaks,
    contacts: Contacts,
    /// `None` if no orders are requested.
    fourier: Option<Fourier>,
    repeats: Option<u32>,
    /// `None` if the geometry of the gears is unknown.
    losses: Option<Losses>,
    /// For every contact, its index in the statistics of forces, and its side.
    places: Vec<(usize, f64)>,
}

impl Nvh {
    /// Statistics of a model with amplitudes at the first `harmonics` mesh orders. If `harmonics` is 0,
    /// fractions of the mesh order are omitted too.
    pub fn new(model: &Model, harmonics: usize) -> Self {
        let set = InstructionSet::best();
        let places: Vec<(usize, f64)> = (model.contacts.iter().enumerate())
            .map(|(contact, contact_data)| {
                if model.of_mesh(contact) {
                    (usize::from(contact_data.side < 0.0), contact_data.side)
                } else {
                    // The spring of a dry slider and the stick of dry friction have no side.
                    let has_force = matches!(contact_data.release, Release::Stick | Release::Grip);
                    let side = if has_force { 1.0 } else { contact_data.side };
                    (contact - model.flank_springs + FLANKS, side)
                }
            })
            .collect();
        let reported = model.contacts.len() - model.flank_springs + FLANKS;
        Self {
            rules: Rules::shared(),
            set,
            origin: Origin {
                centre: [0.0; 2],
                half_gap: model.half_gap,
                effective_mass: model.effective_mass,
            },
            shares_origin: false,
            cycles: None,
            open: false,
            over: 0,
            stretches: BlockSums::new(Sums::empty(harmonics, reported), CYCLES_PER_STRETCH),
            peaks: Peaks::new(),
            contacts: Contacts::new(model),
            fourier: (harmonics > 0).then(|| Fourier::new(set, model.period(), harmonics)),
            repeats: None,
            losses: Losses::of(model),
            places,
        }
    }

    /// Empty statistics for another trajectory of the same model. If these statistics already contain a
    /// window, both records have the same origin.
    pub fn for_same_model(&self) -> Self {
        let mut other = self.clone();
        other.restart();
        other.shares_origin |= self.cycles.is_some();
        other
    }

    /// Forgets everything accumulated.
    pub fn restart(&mut self) {
        self.cycles = None;
        self.open = false;
        self.over = 0;
        self.stretches.restart();
        self.peaks.restart();
        self.contacts.restart();
        if let Some(fourier) = &mut self.fourier {
            fourier.restart();
        }
        self.repeats = None;
    }

    /// Marks the measured motion as periodic, after integration of whole periods: its statistics are exact.
    pub fn repeats(&mut self, period: u32) {
        self.repeats = Some(period);
    }

    /// Appends the record of another trajectory of the same model. Both have whole mesh cycles.
    ///
    /// Flights, contacts and windows of sub-orders that are incomplete where the records meet are omitted.
    /// The sum can be evaluated but not continued.
    pub fn append(&mut self, other: &Self) {
        if other.cycles.is_none() {
            return;
        }
        self.finish();
        let mut other = other.finished();
        if self.cycles.is_none() && !self.shares_origin {
            self.origin.centre = other.origin.centre;
        }
        self.cycles = self.cycles.or(other.cycles);
        let [deflection, force] = [0, 1].map(|i| other.origin.centre[i] - self.origin.centre[i]);
        if [deflection, force] != [0.0; 2] {
            let shift = [deflection / self.origin.half_gap, force];
            (other.to_mut().stretches).each(|sums| sums.recentre(shift));
        }
        self.over += other.over;
        self.stretches.append(&other.stretches);
        self.peaks.append(&other.peaks);
        self.contacts.append(&other.contacts);
        if let (Some(fourier), Some(other)) = (&mut self.fourier, &other.fourier) {
            fourier.suborders.append(&other.suborders);
        }
    }

    /// Keeps the complete stretches within the first `cycles` of those measured. Impact speeds, durations of
    /// contacts and flights, and sub-orders also keep the cycles after these.
    pub fn cut(&mut self, cycles: u64) {
        self.finish();
        self.stretches.cut(cycles);
        self.peaks.cut(cycles);
        self.over = self.over.min(cycles);
    }

    /// Series for a stop rule, each with the name of its column. A series has one value per complete stretch,
    /// and its mean has the error of the statistic. Statistics that the motion does not have are omitted,
    /// such as impact speeds without impacts.
    pub fn statistics_for_stop_rule(&self) -> Vec<(&'static str, Vec<f64>)> {
        if self.cycles.is_none() {
            return Vec::new();
        }
        let Self {
            stretches, origin, ..
        } = &*self.finished();
        sums::statistics_for_stop_rule(stretches.complete(), &stretches.total(), *origin)
    }

    /// Mesh cycles per complete stretch, and per value of [`Self::statistics_for_stop_rule`].
    pub fn stretch(&self) -> u64 {
        self.stretches.length()
    }

    /// The statistics after whole mesh cycles; `None` before any window.
    pub fn outcome(&self) -> Option<NvhOutcome> {
        let [first, present] = self.cycles?;
        let mut closed = self.finished();
        let mut total = closed.stretches.total();
        if self.repeats.is_some() {
            (closed.to_mut().contacts).close_circle(first, present + 1, &mut total);
        }
        let mut values = sums::statistics(&total, self.origin);
        let extremes = closed.peaks.record();
        let mean = values.deflection_mean;
        let peaks = |of: fn(&Extremes, f64) -> f64| -> (Vec<f64>, Vec<f64>) {
            let found = (closed.peaks).quantiles(self.repeats, |cycle| of(cycle, mean));
            found.into_iter().flatten().unzip()
        };
        let deflection_peak_errors;
        (values.deflection_peak_quantiles, deflection_peak_errors) = peaks(Extremes::reach);
        let force_peak_errors;
        (values.force_peak_quantiles, force_peak_errors) = peaks(|cycle, _| cycle.force);
        if let Some(losses) = &self.losses {
            let of_contacts = total
                .contacts
                .iter()
                .map(|contact| contact.loss / total.time);
            losses.write_statistics(of_contacts.collect(), &mut values);
        }
        let speeds = QUANTILES.map(|share| closed.contacts.speed(share));
        if let [Some(a), Some(b), Some(c)] = speeds {
            values.impact_velocity_quantiles = vec![a.0, b.0, c.0];
        }
        let medians = closed.contacts.medians();
        let mean_of = |[count, time]: [f64; 2]| (count > 0.0).then(|| time / count);
        values.flight_mean = mean_of(total.flights);
        values.contact_mean = mean_of(total.touches);
        [values.flight_median, values.contact_median] = medians.map(|median| Some(median?.0));

        let mut suborder_errors = Vec::new();
        if let Some(Fourier { suborders, .. }) = &closed.fourier {
            values.suborders = match self.repeats {
                Some(period) => suborders.of_periodic(period, total.time),
                None => {
                    let [rms, errors] = suborders.of_windows(standard_error);
                    suborder_errors = errors;
                    rms
                }
            };
        }
        let stretches = closed.stretches.complete();
        let has_errors = self.repeats.is_none() && stretches.len() >= FEWEST_VALUES;
        let stderr = has_errors.then(|| {
            let error = |known: Option<(f64, f64)>| known.map_or(f64::INFINITY, |(_, e)| e);
            let errors = sums::errors(stretches, &total, self.origin, self.losses.as_ref());
            // Deflection peaks are distances from the mean, so an error of the mean moves all of them. Force peaks are
            // the largest forces.
            let of_peaks = deflection_peak_errors.iter();
            NvhStatistics {
                suborders: suborder_errors,
                deflection_peak_quantiles: of_peaks
                    .map(|e| e.hypot(errors.deflection_mean))
                    .collect(),
                force_peak_quantiles: force_peak_errors,
                impact_velocity_quantiles: if values.impact_velocity_quantiles.is_empty() {
                    Vec::new()
                } else {
                    speeds.map(error).to_vec()
                },
                flight_median: Some(error(medians[0])),
                contact_median: Some(error(medians[1])),
                ..errors
            }
        });
        let deflection_peak = extremes.reach(mean);
        Some(NvhOutcome {
            cycles: closed.over,
            deflection_pp: extremes.largest - extremes.smallest,
            deflection_peak,
            deflection_crest: ratio(deflection_peak, values.deflection_rms),
            force_peak: extremes.force,
            friction_coefficient: self.losses.as_ref().map(Losses::friction),
            impacts: [0, 1].map(|flank| total.contacts[flank].impacts as u64),
            impact_velocity_max: closed.contacts.fastest(),
            flights: total.flights[0] as u64,
            contacts: total.touches[0] as u64,
            values,
            stderr,
        })
    }

    /// Counts the last integrated cycle, which is complete although no later window follows.
    pub(super) fn finish(&mut self) {
        if std::mem::take(&mut self.open) {
            self.advance();
        }
    }

    /// These statistics, including the last integrated cycle.
    fn finished(&self) -> Cow<'_, Self> {
        let mut nvh = Cow::Borrowed(self);
        if self.open {
            nvh.to_mut().finish();
        }
        nvh
    }

    /// Ends a mesh cycle.
    fn advance(&mut self) {
        self.over += 1;
        if let Some(fourier) = &mut self.fourier {
            fourier.advance(&mut self.stretches.current().harmonics);
        }
        self.stretches.advance();
        self.peaks.advance();
    }
}

impl Observer for Nvh {
    const WINDOWS: bool = true;

    fn states(&self) -> bool {
        false
    }

    fn window(&mut self, window: &Window<'_>) {
        let tau = window.duration;
        let rooms;
        let [deflection, force] = match [window.deflection, window.force].map(<&Series>::try_from) {
            [Ok(deflection), Ok(force)] => [deflection, force],
            _ => {
                rooms = [padded(window.deflection), padded(window.force)];
                rooms.each_ref()
            }
        };
        match self.cycles {
            None => {
                self.cycles = Some([window.cycle; 2]);
                if !self.shares_origin {
                    self.origin.centre = [deflection[0], force[0]];
                }
            }
            Some([first, present]) if present != window.cycle => {
                self.cycles = Some([first, window.cycle]);
                self.finish();
            }
            Some(_) => {}
        }
        self.open = true;

        let (rules, set) = (self.rules, self.set);
        let Origin {
            centre, half_gap, ..
        } = self.origin;
        let turn = self.fourier.as_ref().map_or(0.0, |f| f.half_turn(tau));
        let at_nodes = rules.evaluate_at_nodes(set, deflection, centre[0], turn);
        let of_force =
            (force.iter().any(|f| *f != 0.0)).then(|| at_nodes.at_same_nodes(set, force));
        self.peaks.window(&at_nodes, of_force.as_ref());

        let sums = self.stretches.current();
        sums.time += tau;
        let flanks = window.contact.flanks();
        sums.times[flanks.index()] += tau;
        for (contact_sums, closed) in sums.contacts.iter_mut().zip(flanks.closed()) {
            contact_sums.closed += if closed { tau } else { 0.0 };
        }
        let first = (deflection[0] - centre[0]) / half_gap;
        let second = first * first + at_nodes.square() / (half_gap * half_gap);
        let [third, fourth] = at_nodes.powers(set, centre[0], half_gap);
        for (sum, moment) in sums.moments.iter_mut().zip([first, second, third, fourth]) {
            *sum += tau * moment;
        }
        let about = force[0] - centre[1];
        sums.force[0] += tau * about;
        sums.force[1] += tau * about * about;
        if let Some(force) = &of_force {
            sums.force[1] += tau * force.square();
        }
        if let Some(losses) = &self.losses {
            losses.each(set, window, of_force.as_ref(), |contact, lost| {
                sums.contacts[self.places[contact].0].loss += lost;
            });
        }
        for closed in window.closed {
            let (place, side) = self.places[closed.contact];
            let contact = &mut sums.contacts[place];
            contact.force += tau * side * closed.force[0];
            // Several springs of a flank may be closed at once.
            if place >= FLANKS {
                contact.closed += tau;
            }
        }
        if let Some(fourier) = &mut self.fourier {
            fourier.add(window, &at_nodes);
        }
    }

    fn event(&mut self, event: &Event) {
        let place = self.places[event.contact];
        self.contacts.event(event, place, self.stretches.current());
    }
}
