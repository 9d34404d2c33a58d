//! Which elements of dry friction stick in a state of a model, and which slip?

use super::{ActiveSet, DryFriction, Model, Segment};

/// Round-off of a speed, relative to the sizes of its terms.
const ROUND_OFF: f64 = 1e-13;

impl Model {
    /// The element of dry friction to which a contact belongs.
    pub fn friction_of(&self, contact: usize) -> Option<DryFriction> {
        let has_contact = |friction: &&DryFriction| friction.has(contact);
        self.frictions.iter().find(has_contact).copied()
    }

    /// Speed v of sliding in a state \[m/s\], and its round-off \[m/s\]. The state is given by its first and
    /// second components.
    pub fn sliding_speed(&self, friction: DryFriction, [first, second]: [&[f64]; 2]) -> [f64; 2] {
        let gains = self.directions[friction.direction].gains.iter();
        let terms = gains.zip(first.iter().zip(second)).map(|(gain, (x, y))| {
            let [a, b] = [gain.rate[0] * x, gain.rate[1] * y];
            [a + b, a.abs() + b.abs()]
        });
        let u = friction.belt_speed;
        let [speed, size] = terms.fold([-u, u.abs()], |sum, term| {
            [sum[0] + term[0], sum[1] + term[1]]
        });
        [speed, ROUND_OFF * size]
    }

    /// Adds the states of all elements of dry friction to the closed contacts. An element whose speed of
    /// sliding is zero sticks, unless it would need more than the static force.
    pub(super) fn with_frictions(
        &self,
        segments: &[Segment],
        mut active: ActiveSet,
        at: (u64, f64),
        state: &[f64],
    ) -> ActiveSet {
        let (first, second) = state.split_at(self.blocks.len());
        for &friction in &self.frictions {
            let [speed, noise] = self.sliding_speed(friction, [first, second]);
            let to_close = if speed.abs() <= noise {
                friction.stick()
            } else {
                friction.slip_towards(speed)
            };
            active = active.toggled(to_close);
        }
        // Elements are released one at a time, the one with the largest excess first.
        loop {
            let forces = self.forces_of_constraints(segments, active, at, state);
            let overcome = (self.frictions.iter().zip(&forces[self.stops.len()..]))
                .filter(|(friction, force)| {
                    active.holds(friction.stick()) && force.abs() > friction.static_force
                })
                .max_by(|(a, f), (b, g)| {
                    let excess = [f.abs() - a.static_force, g.abs() - b.static_force];
                    excess[0].total_cmp(&excess[1])
                });
            let Some((friction, force)) = overcome else {
                return active;
            };
            active = active
                .toggled(friction.stick())
                .toggled(friction.slip_towards(*force));
        }
    }
}
