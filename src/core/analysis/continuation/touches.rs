//! Which contacts does an orbit close and open, and how far is it from a change of this sequence?
//!
//! The depth of a contact is `s δ − b` with the gap b; it is negative while the contact is open. If an extreme of the
//! depth is zero, the orbit grazes the contact from outside (a maximum) or from inside (a minimum), and the contact
//! sequence changes.

use crate::analysis::modal_series::{ModalMotion, Series, padded};
use crate::model::Model;
use crate::numerics::legendre::{derivative, evaluate, transforms24};
use crate::numerics::roots::sign_changes;
use crate::propagate::{Event, Observer, Window};
use std::collections::BTreeMap;

/// Round-off of the derivative of a series, relative to the sum of the sizes of the series' terms.
const SLOPE_NOISE: f64 = 1024.0 * f64::EPSILON;

/// An extreme of the depth of a contact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extreme {
    /// The contact.
    pub contact: usize,
    /// Whether the extreme is a minimum.
    pub is_minimum: bool,
    /// Time from the start of the period, in cycles.
    pub time: f64,
    /// Depth \[half gaps\]; negative if the contact is open.
    pub depth: f64,
}

/// Contact changes and extremes of the depths over a period of an orbit.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Touches {
    /// Contact changes in order: the contact, and whether it closes.
    pub sequence: Vec<(usize, bool)>,
    /// Extremes of the depths by window, then by contact, then in order of time.
    pub extremes: Vec<Extreme>,
}

impl Touches {
    /// Whether two sequences are the same up to a cyclic shift.
    pub fn is_cyclic_shift_of(&self, other: &Self) -> bool {
        let (a, b) = (&self.sequence, &other.sequence);
        a.len() == b.len()
            && (a.is_empty()
                || (0..a.len()).any(|shift| (0..a.len()).all(|i| a[(i + shift) % a.len()] == b[i])))
    }

    /// The smallest distance of an extreme from its surface \[half gaps\].
    pub fn margin(&self) -> Option<f64> {
        self.extremes
            .iter()
            .map(|e| e.depth.abs())
            .min_by(f64::total_cmp)
    }

    /// Number of contact changes over the period, counted by the signs of the depths at their extremes. The
    /// grazing extreme is omitted, because its depth is round-off.
    pub fn changes_besides_graze(&self, graze: &Extreme) -> usize {
        let same = |e: &&Extreme| e.contact == graze.contact && e.is_minimum == graze.is_minimum;
        let grazing = (self.extremes.iter().filter(same))
            .min_by(|a, b| a.depth.abs().total_cmp(&b.depth.abs()));
        let mut closed: BTreeMap<usize, Vec<bool>> = BTreeMap::new();
        for extreme in self.extremes.iter().filter(|e| Some(*e) != grazing) {
            closed
                .entry(extreme.contact)
                .or_default()
                .push(extreme.depth > 0.0);
        }
        let changes = |states: &Vec<bool>| {
            (0..states.len())
                .filter(|&i| states[i] != states[(i + 1) % states.len()])
                .count()
        };
        closed.values().map(changes).sum()
    }

    /// Half of the largest difference of two extremes of one contact's depth \[half gaps\].
    pub fn swing(&self) -> f64 {
        let mut bounds: BTreeMap<usize, [f64; 2]> = BTreeMap::new();
        for extreme in &self.extremes {
            let range = bounds.entry(extreme.contact).or_insert([extreme.depth; 2]);
            *range = [range[0].min(extreme.depth), range[1].max(extreme.depth)];
        }
        let swings = bounds.values().map(|[low, high]| 0.5 * (high - low));
        swings.fold(0.0, f64::max)
    }

    /// The sequence as text: each contact's number from 1, with `+` if it closes and `-` if it opens.
    pub fn text(&self) -> String {
        let word = |&(contact, closes): &(usize, bool)| {
            let sign = if closes { '+' } else { '-' };
            format!("{}{sign}", contact + 1)
        };
        self.sequence.iter().map(word).collect::<Vec<_>>().join(" ")
    }

    /// The extreme of the same contact and kind that is nearest in time to the given one. The orbit has a
    /// period of `period` cycles.
    pub fn nearest(&self, to: &Extreme, period: f64) -> Option<&Extreme> {
        let time_difference = |e: &Extreme| {
            let d = (e.time - to.time).rem_euclid(period);
            d.min(period - d)
        };
        (self.extremes.iter())
            .filter(|e| e.contact == to.contact && e.is_minimum == to.is_minimum)
            .min_by(|a, b| time_difference(a).total_cmp(&time_difference(b)))
    }
}

/// Observes the touches and the motion of an orbit.
#[derive(Debug)]
pub struct TouchObserver<'m> {
    model: &'m Model,
    /// Created at the first window that does not contain the required deflection.
    motion: Option<ModalMotion<'m>>,
    /// Last sign of the rate of every depth: whether the depth was increasing.
    rising: Vec<Option<bool>>,
    /// For every contact, a possible extreme at the start of the period. It is an extreme if the rate of the depth has
    /// the opposite sign at the end of the period.
    start_extremes: Vec<Option<Extreme>>,
    touches: Touches,
    sums: [f64; 3],
    /// Smallest and largest δ, largest |F|.
    bounds: [f64; 3],
}

impl<'m> TouchObserver<'m> {
    /// An observer before the first window.
    pub fn new(model: &'m Model) -> Self {
        Self {
            model,
            motion: None,
            rising: vec![None; model.contacts.len()],
            start_extremes: vec![None; model.contacts.len()],
            touches: Touches::default(),
            sums: [0.0; 3],
            bounds: [f64::INFINITY, f64::NEG_INFINITY, 0.0],
        }
    }

    /// The touches of a whole period. If a depth turns exactly at the start of the period, no window contains
    /// this extreme. It is added here.
    pub fn of_period(self) -> Touches {
        let mut touches = self.touches;
        let extremes_at_start = (self.start_extremes.into_iter().flatten())
            .filter(|extreme| self.rising[extreme.contact] == Some(!extreme.is_minimum));
        touches.extremes.splice(0..0, extremes_at_start);
        touches
    }

    /// The motion of the mesh.
    pub fn motion(&self) -> super::map::Motion {
        let [time, sum, square_sum] = self.sums;
        let mean = sum / time;
        super::map::Motion {
            rms: (square_sum / time - mean * mean).max(0.0).sqrt(),
            mean,
            smallest: self.bounds[0],
            largest: self.bounds[1],
            force_peak: self.bounds[2],
        }
    }

    /// The depth of a contact over a window \[m\].
    pub(super) fn depth(&mut self, contact: usize, window: &Window<'_>) -> Series {
        let contact_data = &self.model.contacts[contact];
        let segment = &window.segments[contact];
        let line = self.model.line(segment);
        let closed_contact = window
            .closed
            .iter()
            .find(|closed| closed.contact == contact);
        let mut out = if let Some(closed) = closed_contact {
            padded(closed.deflection)
        } else if line == self.model.line(&window.segments[0]) {
            padded(window.deflection)
        } else if let Some(along) = window.along.get(contact) {
            padded(along)
        } else {
            let motion = self
                .motion
                .get_or_insert_with(|| ModalMotion::new(self.model));
            motion.on(window).along(segment.direction)
        };
        for a in &mut out {
            *a *= contact_data.side;
        }
        if segment.error.is_none() {
            out[0] -= contact_data.half_gap;
            return out;
        }
        let time = |x: f64| window.start + 0.5 * window.duration * (1.0 + x);
        let gap = transforms24().interpolate(
            &transforms24()
                .nodes()
                .map(|x| contact_data.gap(segment, time(x))[0]),
        );
        std::array::from_fn(|n| out[n] - gap[n])
    }
}

impl Observer for TouchObserver<'_> {
    const WINDOWS: bool = true;
    const LINES: bool = true;

    fn window(&mut self, window: &Window<'_>) {
        let half_gap = self.model.half_gap;
        let start = window.cycle as f64 + window.start / self.model.period();
        let length = window.duration / self.model.period();
        let deflection = padded(window.deflection);
        let square: f64 = (deflection.iter().enumerate())
            .map(|(n, a)| a * a / (2 * n + 1) as f64)
            .sum();
        for (sum, value) in self.sums.iter_mut().zip([1.0, deflection[0], square]) {
            *sum += window.duration * value;
        }
        let mut widen_bounds = |series: &Series, x: f64, peak: bool| {
            let value = evaluate(series, x);
            if peak {
                self.bounds[2] = self.bounds[2].max(value.abs())
            } else {
                self.bounds[0] = self.bounds[0].min(value);
                self.bounds[1] = self.bounds[1].max(value);
            }
        };
        let force = padded(window.force);
        for x in [-1.0, 1.0] {
            widen_bounds(&deflection, x, false);
            widen_bounds(&force, x, true);
        }
        for (series, peak) in [(&deflection, false), (&force, true)] {
            let slope = derivative(series);
            let size: f64 = series.iter().map(|a| a.abs()).sum();
            let mut rising = Some(evaluate(&slope, -1.0) > 0.0);
            sign_changes(
                transforms24(),
                &slope,
                SLOPE_NOISE * size,
                &mut rising,
                |x, _| widen_bounds(series, x, peak),
            );
        }
        for contact in 0..self.model.contacts.len() {
            let depth = self.depth(contact, window);
            let size: f64 = depth.iter().map(|a| a.abs()).sum();
            let noise = SLOPE_NOISE * (size + self.model.contacts[contact].half_gap.abs());
            let (mut rising, extremes) = (self.rising[contact], &mut self.touches.extremes);
            let before = extremes.len();
            sign_changes(
                transforms24(),
                &derivative(&depth),
                noise,
                &mut rising,
                |x, is_minimum| {
                    extremes.push(Extreme {
                        contact,
                        is_minimum,
                        time: start + 0.5 * length * (1.0 + x),
                        depth: evaluate(&depth, x) / half_gap,
                    });
                },
            );
            if self.rising[contact].is_none() {
                let odd = (extremes.len() - before) % 2 == 1;
                self.start_extremes[contact] = rising.map(|last| Extreme {
                    contact,
                    is_minimum: last != odd,
                    time: start,
                    depth: evaluate(&depth, -1.0) / half_gap,
                });
            }
            self.rising[contact] = rising;
        }
    }

    fn event(&mut self, event: &Event) {
        self.touches.sequence.push((event.contact, event.closes()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{
        ActiveSet, COAST_FLANK, DRIVE_FLANK, Division, FlankError, InitialState, MeshHarmonic,
        STIFFNESS_TERMS, fixtures,
    };
    use crate::propagate::{Counters, Kernel, Volterra};
    use crate::structure::StructureContact;

    /// The depth of a contact at both ends of every window.
    struct WindowEndDepths<'m> {
        watch: TouchObserver<'m>,
        contact: usize,
        seen: Vec<[f64; 2]>,
    }

    impl Observer for WindowEndDepths<'_> {
        const WINDOWS: bool = true;

        fn window(&mut self, window: &Window<'_>) {
            let depth = self.watch.depth(self.contact, window);
            self.seen.push([-1.0, 1.0].map(|x| evaluate(&depth, x)));
        }
    }

    /// The depths of two contacts agree with the states. One contact is a distant end stop, with an error, on a line
    /// that windows do not contain. The other is the drive flank with relieved teeth.
    #[test]
    fn a_contact_is_as_deep_as_the_states_say() {
        let own = [0.9, 0.4, 0.2];
        let mut structure = fixtures::structure(&[0.0, 900.0, 4000.0], 0.01, &own, &own);
        let mut stop = StructureContact::stop(&[0.5, -0.7, 0.3], 1e-3, 3e8);
        stop.law.error = vec![MeshHarmonic::new(1, 2e-6, 0.4)];
        structure.contacts = vec![stop];
        let mut drive = fixtures::two_level_mesh(1e-5);
        drive.mesh = Division::levels(&[4e8, 3e8], &[0.6]);
        // The flank errors of both divisions are three micrometres where the divisions meet.
        for (division, bend) in drive.mesh.iter_mut().zip([1e-6, 2e-6]) {
            let mut series = [0.0; STIFFNESS_TERMS];
            (series[0], series[2]) = (3e-6 - bend, bend);
            division.error = FlankError::series(series);
        }
        let model = Model::new(&structure, &drive, fixtures::strong_rattle()).unwrap();
        for contact in [DRIVE_FLANK, model.contacts.len() - 1] {
            depths_are_those_of_states(&model, contact);
        }
    }

    /// A deflection that falls and rises has a minimum in the middle, where two windows meet, and a maximum at the
    /// start of the period.
    #[test]
    fn an_extreme_where_the_period_begins_is_seen() {
        let own = [0.9, 0.4];
        let structure = fixtures::structure(&[0.0, 900.0], 0.01, &own, &own);
        let drive = fixtures::two_level_mesh(1e-5);
        let model = Model::new(&structure, &drive, fixtures::strong_rattle()).unwrap();
        let mut watch = TouchObserver::new(&model);
        for (half, slope) in [(0.0, -1e-6), (0.5, 1e-6)] {
            watch.window(&Window {
                along: &[],
                cycle: 4,
                start: half * model.period(),
                duration: 0.5 * model.period(),
                segments: &model.segments_at(4, 0.0),
                contact: ActiveSet::FREE,
                deflection: &[5e-6, slope],
                force: &[0.0],
                closed: &[],
                first: &[],
                second: &[],
            });
        }
        let touches = watch.of_period();
        for contact in [DRIVE_FLANK, COAST_FLANK] {
            let side = model.contacts[contact].side;
            let own: Vec<&Extreme> = (touches.extremes.iter())
                .filter(|extreme| extreme.contact == contact)
                .collect();
            let [begin, middle] = own[..] else {
                panic!("{own:?}");
            };
            assert_eq!(
                [begin, middle].map(|e| e.is_minimum),
                [side < 0.0, side > 0.0]
            );
            for (extreme, time, deflection) in [(begin, 4.0, 6e-6), (middle, 4.5, 4e-6)] {
                assert!((extreme.time - time).abs() < 1e-12, "{extreme:?}");
                let depth = (side * deflection - 1e-5) / 1e-5;
                assert!((extreme.depth - depth).abs() < 1e-12, "{extreme:?} {depth}");
            }
        }
    }

    fn depths_are_those_of_states(model: &Model, contact: usize) {
        let kernel = Volterra::new(model, f64::EPSILON, 1000);
        let mut workspace = kernel.workspace();
        let mut trajectory = model.start(&InitialState::Static);
        let mut depths = Vec::new();
        for _ in 0..5 {
            let depth = |state: &[f64], cycle: u64| {
                let segment = &model.segments_at(cycle, 0.0)[contact];
                let contact = &model.contacts[contact];
                contact.side * model.deflection_on(segment, cycle, state, 0.0).0
                    - contact.gap(segment, 0.0)[0]
            };
            let before = depth(&trajectory.state, trajectory.cycle);
            let mut ends = WindowEndDepths {
                watch: TouchObserver::new(model),
                contact,
                seen: Vec::new(),
            };
            let mut counters = Counters::default();
            (kernel.advance(1, &mut trajectory, &mut workspace, &mut ends, &mut counters)).unwrap();
            let after = depth(&trajectory.state, trajectory.cycle);
            let (first, last) = (ends.seen[0][0], ends.seen[ends.seen.len() - 1][1]);
            assert!((first - before).abs() < 1e-17, "{first} {before}");
            assert!((last - after).abs() < 1e-17, "{last} {after}");
            for pair in ends.seen.windows(2) {
                assert!((pair[0][1] - pair[1][0]).abs() < 1e-17, "{pair:?}");
            }
            depths.push(after);
        }
        assert!(
            depths.iter().any(|depth| (depth - depths[0]).abs() > 1e-7),
            "{depths:?}"
        );
    }
}
