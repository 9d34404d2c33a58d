//! What do rigid stops do to the states of a model, and with what forces do they hold it?

use super::stop::{product, pushed};
use super::{ActiveSet, Model, Release, Segment, Stop};
use crate::numerics::linalg;
use faer::Mat;

/// Takes a multiple of a column off a state, given by its first and second components.
fn take(column: impl Iterator<Item = [f64; 2]>, amount: f64, [first, second]: [&mut [f64]; 2]) {
    for ([a, b], (x, y)) in column.zip(first.iter_mut().zip(second)) {
        *x -= amount * a;
        *y -= amount * b;
    }
}

/// First and second components of a state.
fn halves(state: &mut [f64]) -> [&mut [f64]; 2] {
    let (first, second) = state.split_at_mut(state.len() / 2);
    [first, second]
}

impl Model {
    /// The stop that a contact is a part of.
    pub fn stop_of(&self, contact: usize) -> Option<Stop> {
        let own = |stop: &&Stop| stop.impact == contact || stop.rest() == contact;
        self.stops.iter().find(own).copied()
    }

    /// Whether a contact is the rest on a rigid stop.
    pub fn is_rest(&self, contact: usize) -> bool {
        self.contacts[contact].release == Release::Rest
    }

    /// The direction along which a contact moves on a segment: of the rest on a stop that of its impacts.
    pub fn direction_of_motion(&self, contact: usize, segment: &Segment) -> usize {
        let rest = self.stop_of(contact).filter(|_| self.is_rest(contact));
        rest.map_or(segment.direction, |stop| stop.direction)
    }

    /// What inputs of the blocks add at once to what a line shows.
    pub fn added_at_once(&self, line: usize, input: &[[f64; 2]]) -> f64 {
        let direct = self.lines[line].direct.iter().zip(input);
        direct.map(|(row, input)| product(*row, *input)).sum()
    }

    /// What a unit force along a direction takes off at once from what a line shows, its own force left out.
    pub fn taken_at_once(&self, line: usize, direction: usize) -> f64 {
        let force = &self.directions[direction];
        if force.line == line {
            return 0.0;
        }
        let direct = self.lines[line].direct.iter().zip(&force.gains);
        direct.map(|(row, own)| product(*row, own.mesh_input)).sum()
    }

    /// What constant inputs and ripples add at once to what a line shows, at a time \[s\] within a mesh cycle.
    pub(super) fn loads_at_once(&self, line: usize, cycle: u64, time: f64) -> f64 {
        let rows = &self.lines[line].direct;
        let constant = rows.iter().zip(&self.blocks);
        let constant: f64 = constant
            .map(|(row, own)| product(*row, own.static_input))
            .sum();
        let of_ripple = |ripple: &super::Ripple| {
            self.added_at_once(line, &ripple.input) * ripple.phase_at(cycle, time).cos()
        };
        if rows.is_empty() {
            0.0
        } else {
            constant + self.ripple.iter().map(of_ripple).sum::<f64>()
        }
    }

    /// What the deflection and its rate at a stop feel of a state or a tangent, given by its first and second components: `w·x`
    /// and `r·x`.
    pub fn felt_at_stop(&self, stop: Stop, [first, second]: [&[f64]; 2]) -> [f64; 2] {
        let gains = self.directions[stop.direction].gains.iter();
        let parts = gains.zip(first.iter().zip(second));
        parts.fold([0.0; 2], |sum, (own, (x, y))| {
            let pair = [*x, *y];
            [
                sum[0] + product(own.deflection, pair),
                sum[1] + product(own.rate, pair),
            ]
        })
    }

    /// Takes a multiple of g off a state or a tangent: an impulse of a stop \[N s\]. The rate δ' falls by ρ times as much.
    pub fn push_from_stop(&self, stop: Stop, impulse: f64, parts: [&mut [f64]; 2]) {
        let along = self.directions[stop.direction].gains.iter();
        take(along.map(|own| own.mesh_input), impulse, parts);
    }

    /// Takes a multiple of `A g` off, A with the dampers of closed contacts: δ falls by ρ times as much, and what remains is
    /// moved as by two opposite impulses one shortly after the other.
    pub fn shift_from_stop(
        &self,
        stop: Stop,
        amount: f64,
        (active, segments): (ActiveSet, &[Segment]),
        [first, second]: [&mut [f64]; 2],
    ) {
        let gains = &self.directions[stop.direction].gains;
        let moved = self.blocks.iter().zip(gains);
        let moved =
            moved.map(|(block, own)| block.generator.map(|row| product(row, own.mesh_input)));
        take(moved, amount, [&mut *first, &mut *second]);
        let springs = active
            .iter()
            .filter(|own| !self.contacts[*own].release.of_stop());
        for segment in springs.map(|contact| &segments[contact]) {
            let own = self.gains(segment);
            let damped = -segment.damping * pushed(own, gains) * amount;
            let along = own.iter().map(|own| own.mesh_input);
            take(along, damped, [&mut *first, &mut *second]);
        }
    }

    /// The stops that hold a state with these contacts closed.
    pub fn held(&self, active: ActiveSet) -> Vec<Stop> {
        let held = |stop: &&Stop| active.holds(stop.rest());
        self.stops.iter().filter(held).copied().collect()
    }

    /// Which of the stops that hold the structure go on while another one is hit, with their impulses per unit of its own;
    /// and by how much a unit impulse then changes the rate at that one \[1/kg\]. A stop that would have to pull lets go.
    pub fn held_beside(&self, stop: Stop, mut held: Vec<Stop>) -> (Vec<(Stop, f64)>, f64) {
        let gains = |stop: &Stop| &self.directions[stop.direction].gains[..];
        loop {
            let moved: Vec<f64> = (held.iter())
                .map(|other| -pushed(gains(other), gains(&stop)))
                .collect();
            let shares = self.against(&held, &moved);
            let least = (0..shares.len()).min_by(|a, b| shares[*a].total_cmp(&shares[*b]));
            let Some(pulls) = least.filter(|own| shares[*own] < 0.0) else {
                let beside = held.iter().zip(&shares);
                let beside = beside.map(|(own, share)| share * pushed(gains(&stop), gains(own)));
                let push = stop.push + beside.sum::<f64>();
                return (held.into_iter().zip(shares).collect(), push);
            };
            held.remove(pulls);
        }
    }

    /// Takes the rates at stops off a state, which moves them at the rates `levels` \[m/s\], or off a tangent.
    pub fn still(&self, held: &[Stop], levels: &[f64], [first, second]: [&mut [f64]; 2]) {
        let rates: Vec<f64> = (held.iter().zip(levels))
            .map(|(stop, level)| self.felt_at_stop(*stop, [&*first, &*second])[1] - level)
            .collect();
        for (stop, impulse) in held.iter().zip(self.against(held, &rates)) {
            self.push_from_stop(*stop, impulse, [&mut *first, &mut *second]);
        }
    }

    /// Moves a state onto stops, which stand at `levels` with these rates \[m, m/s\], and takes its rates there; or a tangent.
    pub fn seat(
        &self,
        held: &[Stop],
        levels: &[[f64; 2]],
        closed: (ActiveSet, &[Segment]),
        [first, second]: [&mut [f64]; 2],
    ) {
        let beyond: Vec<f64> = (held.iter().zip(levels))
            .map(|(stop, level)| self.felt_at_stop(*stop, [&*first, &*second])[0] - level[0])
            .collect();
        for (stop, amount) in held.iter().zip(self.against(held, &beyond)) {
            self.shift_from_stop(*stop, amount, closed, [&mut *first, &mut *second]);
        }
        let rates: Vec<f64> = levels.iter().map(|level| level[1]).collect();
        self.still(held, &rates, [first, second]);
    }

    /// Where the surfaces of stops stand along their lines, and their rates \[m, m/s\], at a time \[s\] within a mesh cycle.
    pub fn levels_of_stops(&self, stops: &[Stop], cycle: u64, time: f64) -> Vec<[f64; 2]> {
        let of_stop = |stop: &Stop| {
            let line = &self.lines[self.directions[stop.direction].line];
            let (error, rate) = line.transmission_error_at(cycle, time);
            [error + self.contacts[stop.impact].half_gap, rate]
        };
        stops.iter().map(of_stop).collect()
    }

    /// Takes off the derivative of a state what the stops on which it rests push, `Σ g λ`, so that no δ'' is left.
    pub(super) fn hold(&self, active: ActiveSet, (cycle, time): (u64, f64), slope: &mut [f64]) {
        if self.stops.is_empty() {
            return;
        }
        let held = self.held(active);
        let forces = self.holding(&held, (cycle, time), slope);
        for (stop, force) in held.iter().zip(forces) {
            self.push_from_stop(*stop, force, halves(slope));
        }
    }

    /// Forces \[N\] of stops that take all δ'' from the derivative of a state without them.
    fn holding(&self, held: &[Stop], (cycle, time): (u64, f64), slope: &[f64]) -> Vec<f64> {
        let n = self.blocks.len();
        let gains = |stop: &Stop| &self.directions[stop.direction].gains[..];
        let quickening: Vec<f64> = (held.iter())
            .map(|stop| {
                let own = gains(stop).iter().enumerate();
                let felt = own.map(|(i, own)| product(own.rate, [slope[i], slope[n + i]]));
                let line = &self.lines[self.directions[stop.direction].line];
                let curved = (line.transmission_error.iter()).map(|own| {
                    let turned = own.turned(cycle, time) + own.phase;
                    own.amplitude * own.angular_frequency.powi(2) * turned.cos()
                });
                felt.chain(curved).sum()
            })
            .collect();
        self.against(held, &quickening)
    }

    /// Forces or impulses of stops that together take off rates or accelerations at them.
    fn against(&self, held: &[Stop], taken: &[f64]) -> Vec<f64> {
        match held {
            [] => Vec::new(),
            [only] => vec![taken[0] / only.push],
            _ => {
                let gains = |stop: usize| &self.directions[held[stop].direction].gains[..];
                let matrix =
                    Mat::from_fn(held.len(), held.len(), |i, j| pushed(gains(i), gains(j)));
                linalg::solve(matrix.as_ref(), taken)
            }
        }
    }

    /// Forces \[N\] that the stops on which a state rests bear, in the order of the stops; of the others those that would
    /// hold them alone.
    pub fn forces_of_stops(
        &self,
        segments: &[Segment],
        active: ActiveSet,
        (cycle, time): (u64, f64),
        state: &[f64],
    ) -> Vec<f64> {
        let rests = self.stops.iter().map(|stop| stop.rest());
        let without = rests.fold(ActiveSet::FREE, ActiveSet::toggled);
        let mut slope = vec![0.0; state.len()];
        self.derivative(
            segments,
            active.without(without),
            cycle,
            time,
            state,
            &mut slope,
        );
        let (held, open): (Vec<Stop>, Vec<Stop>) = self
            .stops
            .iter()
            .partition(|stop| active.holds(stop.rest()));
        let mut forces = self.holding(&held, (cycle, time), &slope).into_iter();
        self.hold(active, (cycle, time), &mut slope);
        let mut alone = (open.iter()).map(|stop| self.holding(&[*stop], (cycle, time), &slope)[0]);
        (self.stops.iter())
            .filter_map(
                |stop| {
                    if active.holds(stop.rest()) { forces.next() } else { alone.next() }
                },
            )
            .collect()
    }

    /// Moves a state that is beyond stops onto them, at the start of a mesh cycle, and stops its approach there.
    pub(super) fn seat_on_stops(&self, segments: &[Segment], cycle: u64, state: &mut [f64]) {
        for &stop in &self.stops {
            let [[level, level_rate]] = self.levels_of_stops(&[stop], cycle, 0.0)[..] else {
                continue;
            };
            let [first, second] = halves(state);
            let [felt, rate] = self.felt_at_stop(stop, [&*first, &*second]);
            if felt > level {
                let kept = [level, level_rate + (rate - level_rate).min(0.0)];
                let closed = (ActiveSet::FREE, segments);
                self.seat(&[stop], &[kept], closed, halves(state));
            }
        }
    }
}
