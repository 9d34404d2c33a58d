//! Where does the motion pierce a section of its phase space?
//!
//! * strobe: once per mesh cycle, at a chosen mesh phase;
//! * entry: on entry into drive contact, δ = +b with δ' > 0; release: at its end; the same for coast contact;
//! * extremum: at a sign change of δ'. These are the certified roots of the derivative of each window's
//!   series;
//! * force maximum: where the rate of a positive mesh force changes from positive to negative, found in the
//!   same way. A force that decreases from entry into contact on has its maximum at the entry;
//! * surface: where a linear combination of modal displacements and velocities has a given value.
//!
//! At mesh phase 0 the sample is the trajectory's state. All other samples are evaluated on the kernel's
//! windows, so that sampling has no influence on the motion.

use super::modal_series::{Series, padded};
use super::poincare_sample::{PoincareSample, SampleKind};
use super::surface::{Surface, SurfaceWatch};
use crate::model::{COAST_FLANK, DRIVE_FLANK, Model, TrajectoryState};
use crate::numerics::legendre::{at_end, derivative, evaluate, transforms24};
use crate::numerics::roots::sign_changes;
use crate::propagate::{Event, Observer, Window};
use serde::Serialize;

/// Settings of Poincaré samples.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct PoincareConfig {
    /// Number of samples that are kept, the last ones of the measured cycles.
    pub samples: usize,
    /// The section on which samples are taken.
    pub section: Section,
    /// How often the interval between two neighbouring points of a chain is halved if their motions differ; 0
    /// for never.
    pub refine: u32,
}

/// The section of phase space on which samples are taken.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub enum Section {
    /// Once per mesh cycle.
    Strobe {
        /// Mesh phase in \[0, 1).
        phase: f64,
    },
    /// On every entry into drive contact.
    Entry,
    /// At every extreme of the deflection.
    Extremum,
    /// Where drive contact ends.
    Release,
    /// On every entry into coast contact.
    CoastEntry,
    /// Where coast contact ends.
    CoastRelease,
    /// At every maximum of a positive mesh force.
    ForceMaximum,
    /// On a surface of phase space.
    Surface(Surface),
}

impl Section {
    /// The event at which a section is sampled on windows: its contact, whether the contact closes, and the
    /// kind of sample. `None` for other sections.
    fn event(&self) -> Option<(usize, bool, SampleKind)> {
        match self {
            Self::Release => Some((DRIVE_FLANK, false, SampleKind::Release)),
            Self::CoastEntry => Some((COAST_FLANK, true, SampleKind::CoastEntry)),
            Self::CoastRelease => Some((COAST_FLANK, false, SampleKind::CoastRelease)),
            _ => None,
        }
    }
}

impl Default for Section {
    /// The strobe at the start of every mesh cycle.
    fn default() -> Self {
        Self::Strobe { phase: 0.0 }
    }
}

/// Tolerance on the boundary between two windows, in mesh periods: a few units in the last place.
const JOINT: f64 = 8.0 * f64::EPSILON;

/// Round-off of the derivative of a 24-term series, in units of the sum of its terms' sizes. Differentiation
/// multiplies the last term by about a hundred.
const SLOPE_NOISE: f64 = 1024.0 * f64::EPSILON;

/// Largest initial capacity for samples.
const LARGEST_CAPACITY: usize = 4096;

/// The last samples of a section.
#[derive(Debug, Clone)]
pub struct Poincare {
    keep: usize,
    section: Section,
    period: f64,
    half_gap: f64,
    samples: Vec<PoincareSample>,
    next: usize,
    /// Mesh cycle of the last strobe sample that a window gave.
    strobed: Option<u64>,
    /// End of the last window: time within the mesh cycle \[s\] and δ \[m\].
    end: Option<(f64, f64)>,
    /// Last sign of δ' (or of the rate of the force): whether it was positive.
    rising: Option<bool>,
    /// Scale of the round-off of the mesh force \[N\]: the mean stiffness times the half gap.
    force: f64,
    surface: Option<Box<SurfaceWatch>>,
    /// The last window, for sections at events.
    last: Option<KeptWindow>,
    /// An event whose window has not been observed yet.
    pending_event: Option<Event>,
}

/// The data of a window that a later event needs.
#[derive(Debug, Clone, Copy)]
struct KeptWindow {
    cycle: u64,
    start: f64,
    duration: f64,
    deflection: Series,
}

impl Poincare {
    /// Keeps the last `keep` samples of a section.
    pub fn new(model: &Model, section: Section, keep: usize) -> Self {
        Self {
            keep,
            surface: match &section {
                Section::Surface(surface) if keep > 0 => {
                    Some(Box::new(SurfaceWatch::new(model, surface)))
                }
                _ => None,
            },
            section,
            force: model.half_gap * model.first_cycle().mean_stiffness(),
            last: None,
            pending_event: None,
            period: model.period(),
            half_gap: model.half_gap,
            samples: Vec::with_capacity(keep.min(LARGEST_CAPACITY)),
            next: 0,
            strobed: None,
            end: None,
            rising: None,
        }
    }

    /// Whether samples come from windows and events instead of [`Self::push`].
    pub fn needs_windows(&self) -> bool {
        self.keep > 0 && self.section != Section::default()
    }

    /// Records a trajectory at the start of a mesh cycle.
    pub fn push(&mut self, model: &Model, trajectory: &TrajectoryState) {
        if self.needs_windows() {
            return;
        }
        let (deflection, velocity) = model.deflection(&trajectory.state, 0.0);
        self.keep(PoincareSample {
            cycle: trajectory.cycle,
            phase: 0.0,
            deflection,
            velocity,
            kind: SampleKind::Strobe,
        });
    }

    /// Forgets all samples.
    pub fn restart(&mut self) {
        self.samples.clear();
        self.next = 0;
        self.pending_event = None;
    }

    /// The samples kept, oldest first.
    pub fn take(&mut self) -> Vec<PoincareSample> {
        self.samples.rotate_left(self.next);
        self.next = 0;
        std::mem::take(&mut self.samples)
    }

    fn keep(&mut self, sample: PoincareSample) {
        if self.samples.len() < self.keep {
            self.samples.push(sample);
        } else if self.keep > 0 {
            self.samples[self.next] = sample;
            self.next = (self.next + 1) % self.keep;
        }
    }

    /// The sample at position x of a window.
    fn at(&self, window: &Window<'_>, x: f64, kind: SampleKind) -> PoincareSample {
        self.on(&KeptWindow::of(window), x, kind)
    }

    /// The sample at position x of a kept window.
    fn on(&self, kept: &KeptWindow, x: f64, kind: SampleKind) -> PoincareSample {
        let slope = derivative(&kept.deflection);
        let time = kept.start + 0.5 * kept.duration * (x + 1.0);
        PoincareSample {
            cycle: kept.cycle,
            phase: self.phase(time),
            deflection: evaluate(&kept.deflection, x),
            velocity: 2.0 / kept.duration * evaluate(&slope, x),
            kind,
        }
    }

    /// Keeps the sample at an event on a window.
    fn keep_event_sample(&mut self, kept: &KeptWindow, event: &Event, kind: SampleKind) {
        let sample = self.on(kept, kept.place(event.time), kind);
        self.keep(PoincareSample {
            cycle: event.cycle,
            phase: self.phase(event.time),
            ..sample
        });
    }

    /// Maxima of a positive mesh force.
    fn force_maxima(&mut self, window: &Window<'_>) {
        if window.closed.is_empty() {
            self.rising = Some(true);
            return;
        }
        let series = padded(window.force);
        let size: f64 = series.iter().map(|a| a.abs()).sum();
        let noise = SLOPE_NOISE * (size + self.force);
        let mut rising = self.rising;
        let slope = derivative(&series);
        sign_changes(transforms24(), &slope, noise, &mut rising, |x, minimum| {
            if !minimum && evaluate(&series, x) > 0.0 {
                self.keep(self.at(window, x, SampleKind::ForceMaximum));
            }
        });
        self.rising = rising;
    }

    /// Crossings of a surface.
    fn cross(&mut self, window: &Window<'_>) {
        let Some(mut surface) = self.surface.take() else {
            return;
        };
        surface.crossings(window, |x, rises| {
            let kind = if rises { SampleKind::SurfaceUp } else { SampleKind::SurfaceDown };
            self.keep(self.at(window, x, kind));
        });
        self.surface = Some(surface);
    }

    /// Mesh phase in \[0, 1) of a time within the cycle. The end of the cycle has the largest phase below 1.
    fn phase(&self, time: f64) -> f64 {
        (time / self.period).clamp(0.0, 1.0 - 0.5 * f64::EPSILON)
    }

    /// Keeps the sample at a mesh phase if the phase lies in the window. A phase on the boundary between two
    /// windows belongs to the later one.
    fn strobe(&mut self, window: &Window<'_>, phase: f64) {
        let tau = window.duration;
        let time = phase * self.period;
        if self.strobed == Some(window.cycle) || time >= window.start + tau - JOINT * self.period {
            return;
        }
        self.strobed = Some(window.cycle);
        let x = (2.0 * (time - window.start) / tau - 1.0).clamp(-1.0, 1.0);
        let sample = self.at(window, x, SampleKind::Strobe);
        self.keep(PoincareSample { phase, ..sample });
    }

    /// Samples every position in a window at which δ' changes its sign.
    fn keep_extrema(&mut self, window: &Window<'_>) {
        let series = padded(window.deflection);
        let size: f64 = series.iter().map(|a| a.abs()).sum();
        let noise = SLOPE_NOISE * (size + self.half_gap);
        // The last sign of δ', from one window to the next.
        let mut rising = self.rising;
        let slope = derivative(&series);
        sign_changes(transforms24(), &slope, noise, &mut rising, |x, minimum| {
            let kind = if minimum { SampleKind::Minimum } else { SampleKind::Maximum };
            self.keep(self.at(window, x, kind));
        });
        self.rising = rising;
    }
}

impl KeptWindow {
    fn of(window: &Window<'_>) -> Self {
        Self {
            cycle: window.cycle,
            start: window.start,
            duration: window.duration,
            deflection: padded(window.deflection),
        }
    }

    /// The position of a time within the cycle.
    fn place(&self, time: f64) -> f64 {
        (2.0 * (time - self.start) / self.duration - 1.0).clamp(-1.0, 1.0)
    }
}

impl Observer for Poincare {
    const WINDOWS: bool = true;

    fn window(&mut self, window: &Window<'_>) {
        if !self.needs_windows() {
            return;
        }
        match &self.section {
            Section::Strobe { phase } => self.strobe(window, *phase),
            Section::Entry => {
                self.end = Some((window.start + window.duration, at_end(window.deflection)));
            }
            Section::Extremum => self.keep_extrema(window),
            Section::ForceMaximum => self.force_maxima(window),
            Section::Surface(_) => self.cross(window),
            Section::Release | Section::CoastEntry | Section::CoastRelease => {
                let kept = KeptWindow::of(window);
                if let (Some(event), Some((.., kind))) =
                    (self.pending_event.take(), self.section.event())
                {
                    self.keep_event_sample(&kept, &event, kind);
                }
                self.last = Some(kept);
            }
        }
    }

    fn event(&mut self, event: &Event) {
        if let Some((contact, closes, kind)) = self.section.event() {
            if self.keep == 0 || event.contact != contact || event.closes() != closes {
                return;
            }
            // A kernel that cuts its windows at events passes the event after the window that ends at it.
            // Other kernels pass the event before the window that contains it.
            let behind = |kept: &KeptWindow| {
                let end = kept.start + kept.duration;
                kept.cycle == event.cycle && event.time <= end + JOINT * self.period
            };
            match self.last.filter(behind) {
                Some(kept) => self.keep_event_sample(&kept, event, kind),
                None => self.pending_event = Some(*event),
            }
            return;
        }
        if !self.needs_windows()
            || self.section != Section::Entry
            || !(event.closes() && event.contact == DRIVE_FLANK)
        {
            return;
        }
        // A kernel that cuts its windows at events has δ at the end of the last window. Other kernels
        // determine the time at which their δ equals b.
        let window_end = self
            .end
            .filter(|(time, _)| (time - event.time).abs() <= JOINT * self.period);
        self.keep(PoincareSample {
            cycle: event.cycle,
            phase: self.phase(event.time),
            deflection: window_end.map_or(self.half_gap, |(_, deflection)| deflection),
            velocity: event.rate,
            kind: SampleKind::Entry,
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{ActiveSet, fixtures};
    use crate::propagate::ClosedContact;

    /// The round-off of a force is relative to the mean stiffness times the half gap. In a force of ten
    /// newtons, a maximum is found if it is ten micronewtons high, and not if it is round-off.
    #[test]
    fn maxima_of_a_light_force_are_seen() {
        let structure = fixtures::structure(&[0.0, 900.0], 0.01, &[1.0, 0.5], &[1.0, 0.5]);
        let drive = fixtures::two_level_mesh(1e-5);
        let model = Model::new(&structure, &drive, fixtures::strong_rattle()).unwrap();
        for (height, seen) in [(1e-5, 1), (1e-11, 0)] {
            let mut section = Poincare::new(&model, Section::ForceMaximum, 10);
            let force = [10.0, 0.0, -height];
            section.window(&Window {
                along: &[],
                cycle: 4,
                start: 0.0,
                duration: 0.1 * model.period(),
                segments: &model.segments_at(4, 0.0),
                contact: ActiveSet::DRIVE,
                deflection: &[1e-5],
                force: &force,
                closed: &[ClosedContact {
                    contact: DRIVE_FLANK,
                    deflection: &[1e-5],
                    force: &force,
                }],
                first: &[],
                second: &[],
            });
            let samples = section.take();
            assert_eq!(samples.len(), seen, "{height}: {samples:?}");
            assert!(
                samples
                    .iter()
                    .all(|sample| (sample.phase - 0.05).abs() < 1e-9),
                "{samples:?}"
            );
        }
    }
}
