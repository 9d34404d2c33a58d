//! How do rigid stops and sticking dry friction change the states of a model, and with what forces do they hold it?

use super::stop::{product, pushed};
use super::{ActiveSet, Constraint, Model, Release, Segment, Stop};
use crate::numerics::linalg;
use faer::Mat;

/// Distance from a stop, and speed times the mesh period, of a state on the stop. Both are relative to the half gap and
/// to the gap of the stop.
const ON_STOP: f64 = 1e-13;

/// Subtracts a multiple of a column from a state, given by its first and second components.
fn subtract_column(
    column: impl Iterator<Item = [f64; 2]>,
    amount: f64,
    [first, second]: [&mut [f64]; 2],
) {
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
    /// The stop to which a contact belongs.
    pub fn stop_of(&self, contact: usize) -> Option<Stop> {
        let has_contact = |stop: &&Stop| stop.impact == contact || stop.rest() == contact;
        self.stops.iter().find(has_contact).copied()
    }

    /// Whether a contact is the rest on a rigid stop.
    pub fn is_rest(&self, contact: usize) -> bool {
        self.contacts[contact].release == Release::Rest
    }

    /// Whether a contact is a constraint that holds the structure: the rest on a rigid stop, or the stick of
    /// dry friction.
    pub fn is_constraint(&self, contact: usize) -> bool {
        matches!(
            self.contacts[contact].release,
            Release::Rest | Release::Grip
        )
    }

    /// Whether a contact is neither a state of dry friction nor a rest on a rigid stop: a spring, a damper, a state of
    /// a dry slider, or an impact.
    pub fn is_spring(&self, contact: usize) -> bool {
        let release = self.contacts[contact].release;
        !(release.of_friction() || release == Release::Rest)
    }

    /// Index of the direction of a contact's deflection δ on a segment. For a constraint this is the
    /// direction of its force, because the quantity of its line is no deflection.
    pub fn motion_direction_index(&self, contact: usize, segment: &Segment) -> usize {
        let constraint = self
            .constraints()
            .find(|constraint| constraint.contact == contact);
        constraint.map_or(segment.direction, |constraint| constraint.direction)
    }

    /// All constraints of the structure: stops, then dry friction.
    pub fn constraints(&self) -> impl Iterator<Item = Constraint> {
        let stops = self.stops.iter().map(|stop| stop.constraint());
        stops.chain(self.frictions.iter().map(|friction| friction.constraint()))
    }

    /// Direct contribution of inputs of the blocks to the quantity of a line.
    pub fn direct_increase(&self, line: usize, input: &[[f64; 2]]) -> f64 {
        let direct = self.lines[line].direct.iter().zip(input);
        direct.map(|(row, input)| product(*row, *input)).sum()
    }

    /// Direct reduction of the quantity of a line by a unit force along a direction; 0 for the force of the
    /// line itself.
    pub fn direct_reduction(&self, line: usize, direction: usize) -> f64 {
        let force = &self.directions[direction];
        if force.line == line {
            return 0.0;
        }
        let direct = self.lines[line].direct.iter().zip(&force.gains);
        direct
            .map(|(row, gain)| product(*row, gain.mesh_input))
            .sum()
    }

    /// Direct contribution of constant inputs and ripples to the quantity of a line, at a time \[s\] within a
    /// mesh cycle.
    pub(super) fn direct_loads(&self, line: usize, cycle: u64, time: f64) -> f64 {
        let rows = &self.lines[line].direct;
        let constant = rows.iter().zip(&self.blocks);
        let constant: f64 = constant
            .map(|(row, block)| product(*row, block.static_input))
            .sum();
        let of_ripple = |ripple: &super::Ripple| {
            self.direct_increase(line, &ripple.input) * ripple.phase_at(cycle, time).cos()
        };
        if rows.is_empty() {
            0.0
        } else {
            constant + self.ripple.iter().map(of_ripple).sum::<f64>()
        }
    }

    /// Deflection along a direction, `w·x`, and its rate, `r·x`, from a state or a tangent, given by its first and
    /// second components.
    pub fn deflection_along(&self, direction: usize, [first, second]: [&[f64]; 2]) -> [f64; 2] {
        let gains = self.directions[direction].gains.iter();
        let parts = gains.zip(first.iter().zip(second));
        parts.fold([0.0; 2], |sum, (gain, (x, y))| {
            let pair = [*x, *y];
            [
                sum[0] + product(gain.deflection, pair),
                sum[1] + product(gain.rate, pair),
            ]
        })
    }

    /// Applies an impulse along a direction \[N s\]: subtracts this multiple of g from a state or a tangent.
    /// The rate δ' falls by ρ times the impulse.
    pub fn push_along(&self, direction: usize, impulse: f64, parts: [&mut [f64]; 2]) {
        let along = self.directions[direction].gains.iter();
        subtract_column(along.map(|gain| gain.mesh_input), impulse, parts);
    }

    /// Subtracts a multiple of `A g` from a state or a tangent. A includes the dampers of the closed
    /// contacts. δ falls by ρ times the amount. The effect equals that of two opposite impulses in quick
    /// succession.
    pub fn shift_along(
        &self,
        direction: usize,
        amount: f64,
        (active, segments): (ActiveSet, &[Segment]),
        [first, second]: [&mut [f64]; 2],
    ) {
        let gains = &self.directions[direction].gains;
        let moved = self.blocks.iter().zip(gains);
        let moved =
            moved.map(|(block, gain)| block.generator.map(|row| product(row, gain.mesh_input)));
        subtract_column(moved, amount, [&mut *first, &mut *second]);
        let springs = active.iter().filter(|contact| self.is_spring(*contact));
        for segment in springs.map(|contact| &segments[contact]) {
            let spring_gains = self.gains(segment);
            let damped = -segment.damping * pushed(spring_gains, gains) * amount;
            let along = spring_gains.iter().map(|gain| gain.mesh_input);
            subtract_column(along, damped, [&mut *first, &mut *second]);
        }
    }

    /// The constraints that hold a state with these closed contacts.
    pub fn active_constraints(&self, active: ActiveSet) -> Vec<Constraint> {
        let is_active = |constraint: &Constraint| active.holds(constraint.contact);
        self.constraints().filter(is_active).collect()
    }

    /// The closed rests that stay closed while the structure hits another stop, each with its impulse per
    /// unit impulse of that stop. Also the change of the rate at that stop by a unit impulse \[1/kg\]. A rest
    /// that would have to pull opens. Dry friction has no impulse.
    pub fn impulses_at_rests(
        &self,
        stop: Stop,
        active: ActiveSet,
    ) -> (Vec<(Constraint, f64)>, f64) {
        let gains = |direction: usize| &self.directions[direction].gains[..];
        let stop_gains = gains(stop.direction);
        let mut constraints = self.active_constraints(active);
        constraints.retain(|other| self.is_rest(other.contact));
        loop {
            let moved: Vec<f64> = (constraints.iter())
                .map(|other| -pushed(gains(other.direction), stop_gains))
                .collect();
            let shares = self.forces_against(&constraints, &moved);
            let least = (0..shares.len()).min_by(|a, b| shares[*a].total_cmp(&shares[*b]));
            let Some(pulls) = least.filter(|index| shares[*index] < 0.0) else {
                let contributions = constraints.iter().zip(&shares);
                let contributions = contributions
                    .map(|(other, share)| share * pushed(stop_gains, gains(other.direction)));
                let push = stop.push + contributions.sum::<f64>();
                return (constraints.into_iter().zip(shares).collect(), push);
            };
            constraints.remove(pulls);
        }
    }

    /// Changes the rates of a state or a tangent along constraints to `levels` \[m/s\], by impulses of the
    /// constraints.
    pub fn set_rates(
        &self,
        constraints: &[Constraint],
        levels: &[f64],
        [first, second]: [&mut [f64]; 2],
    ) {
        let rates: Vec<f64> = (constraints.iter().zip(levels))
            .map(|(constraint, level)| {
                self.deflection_along(constraint.direction, [&*first, &*second])[1] - level
            })
            .collect();
        for (constraint, impulse) in constraints
            .iter()
            .zip(self.forces_against(constraints, &rates))
        {
            self.push_along(constraint.direction, impulse, [&mut *first, &mut *second]);
        }
    }

    /// Moves a state or a tangent to the positions and rates `levels` of constraints \[m, m/s\]. Dry friction
    /// constrains no position.
    pub fn move_to_levels(
        &self,
        constraints: &[Constraint],
        levels: &[(Option<f64>, f64)],
        closed: (ActiveSet, &[Segment]),
        [first, second]: [&mut [f64]; 2],
    ) {
        let excess: Vec<f64> = (constraints.iter().zip(levels))
            .map(|(constraint, (level, _))| {
                let deflection =
                    self.deflection_along(constraint.direction, [&*first, &*second])[0];
                level.map_or(0.0, |level| deflection - level)
            })
            .collect();
        if levels.iter().any(|(level, _)| level.is_some()) {
            for (constraint, amount) in constraints
                .iter()
                .zip(self.forces_against(constraints, &excess))
            {
                self.shift_along(
                    constraint.direction,
                    amount,
                    closed,
                    [&mut *first, &mut *second],
                );
            }
        }
        let rates: Vec<f64> = levels.iter().map(|level| level.1).collect();
        self.set_rates(constraints, &rates, [first, second]);
    }

    /// Positions and rates of the surfaces of constraints along their lines \[m, m/s\], at a time \[s\]
    /// within a mesh cycle. Dry friction has a rate only.
    pub fn levels(
        &self,
        constraints: &[Constraint],
        cycle: u64,
        time: f64,
    ) -> Vec<(Option<f64>, f64)> {
        let of_hold = |constraint: &Constraint| {
            if let Some(friction) = self.friction_of(constraint.contact) {
                return (None, friction.belt_speed);
            }
            let line = &self.lines[self.directions[constraint.direction].line];
            let (error, rate) = line.transmission_error_at(cycle, time);
            let gap = self
                .stop_of(constraint.contact)
                .map_or(0.0, |stop| self.contacts[stop.impact].half_gap);
            (Some(error + gap), rate)
        };
        constraints.iter().map(of_hold).collect()
    }

    /// Subtracts the forces of constraints, `Σ g λ`, from the derivative of a state, so that δ'' vanishes.
    pub(super) fn apply_constraints(
        &self,
        active: ActiveSet,
        (cycle, time): (u64, f64),
        slope: &mut [f64],
    ) {
        let constraints = self.active_constraints(active);
        let forces = self.holding_forces(&constraints, (cycle, time), slope);
        for (constraint, force) in constraints.iter().zip(forces) {
            self.push_along(constraint.direction, force, halves(slope));
        }
    }

    /// Forces \[N\] of constraints that make all their δ'' zero, from the derivative of a state without these
    /// forces.
    fn holding_forces(
        &self,
        constraints: &[Constraint],
        (cycle, time): (u64, f64),
        slope: &[f64],
    ) -> Vec<f64> {
        let n = self.blocks.len();
        let accelerations: Vec<f64> = (constraints.iter())
            .map(|constraint| {
                let direction = &self.directions[constraint.direction];
                let gains = direction.gains.iter().enumerate();
                let deflection =
                    gains.map(|(i, gain)| product(gain.rate, [slope[i], slope[n + i]]));
                let line = &self.lines[direction.line];
                let error_accelerations = (line.transmission_error.iter()).map(|harmonic| {
                    let turned = harmonic.turned(cycle, time) + harmonic.phase;
                    harmonic.amplitude * harmonic.angular_frequency.powi(2) * turned.cos()
                });
                deflection.chain(error_accelerations).sum()
            })
            .collect();
        self.forces_against(constraints, &accelerations)
    }

    /// Forces (or impulses) of constraints that together reduce δ'' (or δ') along each of them by `removed`.
    fn forces_against(&self, constraints: &[Constraint], removed: &[f64]) -> Vec<f64> {
        match constraints {
            [] => Vec::new(),
            [only] => vec![removed[0] / only.push],
            _ => {
                let gains = |index: usize| &self.directions[constraints[index].direction].gains[..];
                let matrix = Mat::from_fn(constraints.len(), constraints.len(), |i, j| {
                    pushed(gains(i), gains(j))
                });
                linalg::solve(matrix.as_ref(), removed)
            }
        }
    }

    /// Forces \[N\] of all constraints, in the order of [`Self::constraints`]. For an open constraint it is
    /// the force that would be needed in addition to the acting ones.
    pub fn forces_of_constraints(
        &self,
        segments: &[Segment],
        active: ActiveSet,
        (cycle, time): (u64, f64),
        state: &[f64],
    ) -> Vec<f64> {
        let contacts = self.constraints().map(|constraint| constraint.contact);
        let without = contacts.fold(ActiveSet::FREE, ActiveSet::toggled);
        let mut slope = vec![0.0; state.len()];
        self.derivative(
            segments,
            active.without(without),
            cycle,
            time,
            state,
            &mut slope,
        );
        let constraints = self.active_constraints(active);
        let mut forces = self
            .holding_forces(&constraints, (cycle, time), &slope)
            .into_iter();
        self.apply_constraints(active, (cycle, time), &mut slope);
        let mut force = |constraint: Constraint| {
            if active.holds(constraint.contact) {
                forces.next()
            } else {
                self.holding_forces(&[constraint], (cycle, time), &slope)
                    .pop()
            }
        };
        self.constraints().filter_map(&mut force).collect()
    }

    /// Adds the rests of a state at the start of a mesh cycle to the closed contacts: the state is on their stops
    /// without speed, and all of them push.
    pub(super) fn with_rests(
        &self,
        segments: &[Segment],
        mut active: ActiveSet,
        cycle: u64,
        state: &[f64],
    ) -> ActiveSet {
        if self.stops.is_empty() {
            return active;
        }
        let of_stops: Vec<Constraint> = self.stops.iter().map(|stop| stop.constraint()).collect();
        let levels = self.levels(&of_stops, cycle, 0.0);
        for (stop, (level, level_rate)) in of_stops.iter().zip(levels) {
            let parts = state.split_at(self.blocks.len());
            let [deflection, rate] = self.deflection_along(stop.direction, parts.into());
            let level = level.unwrap_or_default();
            let noise = ON_STOP * (self.half_gap + level.abs());
            let [off, speed] = [deflection - level, (rate - level_rate) * self.period()];
            if off.abs() <= noise && speed.abs() <= noise {
                active = active.union(ActiveSet::FREE.toggled(stop.contact));
            }
        }
        loop {
            let forces = self.forces_of_constraints(segments, active, (cycle, 0.0), state);
            let pulls = |(stop, force): &(&Constraint, f64)| {
                active.holds(stop.contact) && (*force <= 0.0 || force.is_nan())
            };
            let Some((stop, _)) = of_stops.iter().zip(forces).find(pulls) else {
                return active;
            };
            active = active.toggled(stop.contact);
        }
    }

    /// Moves a state that is beyond stops onto them, at the start of a mesh cycle, and removes its approach
    /// to them. If this moves the state beyond another stop, that stop is included.
    pub(super) fn move_onto_stops(&self, segments: &[Segment], cycle: u64, state: &mut [f64]) {
        let of_stops: Vec<Constraint> = self.stops.iter().map(|stop| stop.constraint()).collect();
        let levels = self.levels(&of_stops, cycle, 0.0);
        let (mut reached, mut targets): (Vec<Constraint>, Vec<(Option<f64>, f64)>) =
            Default::default();
        loop {
            let before = reached.len();
            for (stop, &(level, level_rate)) in of_stops.iter().zip(&levels) {
                let [first, second] = halves(state);
                let [deflection, rate] = self.deflection_along(stop.direction, [&*first, &*second]);
                if !reached.contains(stop) && level.is_some_and(|level| deflection > level) {
                    reached.push(*stop);
                    targets.push((level, level_rate + (rate - level_rate).min(0.0)));
                }
            }
            if reached.len() == before {
                return;
            }
            let closed = (ActiveSet::FREE, segments);
            self.move_to_levels(&reached, &targets, closed, halves(state));
        }
    }
}
