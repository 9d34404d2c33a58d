//! Which contacts carry a constant load, and with what forces?
//!
//! Contact i is a spring k across a gap. It pushes towards one side only. Everything else is linear. The
//! elastic motions are eliminated. With the rigid motions y that deflect contacts, and the stretches p by which
//! the springs of the contacts are compressed (negative for open contacts),
//!
//! ```text
//! p = c + A y − B F,      F = k max(0, p),      Hᵀ (f − Gᵀ F) = 0
//! ```
//!
//! with the participations A of the stretches in y, the participations G of the contact forces, the
//! flexibility B of the structure, and the rigid motions H that closed contacts restrain. The other part of
//! the rigid load f is a drift. It must not move an open contact towards closing.
//!
//! Without friction G = A and B = Bᵀ, and the solution is the minimum over y and forces λ of the convex energy
//! `½ λᵀ B λ − fᵀ y + Σ ½ k max(0, p)²`, `p = c + A y − B λ`. It is quadratic between the points where
//! contacts close, so Newton steps with exact line searches end after a finite number of steps (J. Sun, On
//! piecewise quadratic Newton and trust region problems, Math. Program. 76, 1997). Friction and unsymmetric
//! springs are then added in steps. In each step their contribution is a load, which is updated until the
//! closed contacts stay the same. This fails if contacts lock. Then every combination of closed contacts is
//! tried, for up to sixteen contacts. If none is in balance, there is no equilibrium. With more contacts the
//! question remains open. Contacts that nothing stretches, such as those of dry sliders, stay open and do not
//! count.

use super::ActiveSet;
use super::error::NoStaticState;
use crate::numerics::linalg;
use crate::numerics::linalg::{add_scaled, dot};
use faer::Mat;

/// Round-off of a sum, relative to its terms.
pub(super) const ROUND_OFF: f64 = 1e-12;

/// Rigid motions coincide if the sine of their angle is below this. A drift below this fraction of the forces
/// on rigid motions is zero. Participations come from eigenvectors and have errors of this size.
const SAME_MOTION: f64 = 1e-9;

/// Largest number of Newton steps. If it is exceeded, the energy counts as without a minimum. Sixteen
/// contacts need about twenty steps.
const MOST_STEPS: usize = 300;

/// Largest number of contacts for which every combination is tried.
const MOST_TRIED: usize = 16;

/// Largest number of updates of the load by friction within a step. If it is exceeded, the step is too large.
const MOST_RENEWALS: usize = 20;

/// Largest fraction of the friction that a step adds, which is that of the first step, and the smallest fraction.
/// A step that fails is halved, and the step after one that succeeds is doubled.
const PARTS: [f64; 2] = [0.125, 1e-6];

/// `Σ |a b|`.
pub(super) fn dot_of_moduli(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a * b).abs()).sum()
}

/// The largest modulus.
fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most, value| value.abs().max(most))
}

/// Orthonormal rows that span the given ones. A row within [`SAME_MOTION`] of the span of earlier rows adds
/// none.
pub(super) fn span<'a>(rows: impl Iterator<Item = &'a [f64]>) -> Vec<Vec<f64>> {
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for row in rows {
        let rest = linalg::orthogonal_part(row, &basis);
        let size = dot(&rest, &rest).sqrt();
        if size > SAME_MOTION * dot(row, row).sqrt() {
            basis.push(rest.iter().map(|a| a / size).collect());
        }
    }
    basis
}

/// A contact in static equilibrium. Its stretch and its force are positive where it is compressed. A list over
/// contacts has one entry per contact. A list over rigid motions has one entry per rigid motion that deflects
/// contacts.
#[derive(Debug, Clone)]
pub(super) struct StaticContact {
    /// Stretch without forces at y = 0, c \[m\].
    pub offset: f64,
    /// Sum of the moduli of the terms of this stretch \[m\].
    pub size: f64,
    /// Stiffness k \[N/m\].
    pub stiffness: f64,
    /// Participations A of the rigid motions in its stretch.
    pub along: Vec<f64>,
    /// Participations G of its force in the loads on the rigid motions.
    pub push: Vec<f64>,
    /// Reduction B of its stretch by a unit force of each contact \[m/N\].
    pub compliance: Vec<f64>,
}

impl StaticContact {
    /// Whether a rigid motion, the load or another contact can stretch it.
    fn may_close(&self) -> bool {
        let moves = |gains: &[f64]| gains.iter().any(|gain| *gain != 0.0);
        self.offset > 0.0 || moves(&self.along) || moves(&self.compliance)
    }
}

/// A static state.
#[derive(Debug, Clone, Default)]
pub(super) struct StaticState {
    /// Forces of all contacts \[N\]; 0 if open.
    pub forces: Vec<f64>,
    /// Rigid motions y \[m √kg\].
    pub place: Vec<f64>,
    /// The contacts assumed closed.
    pub closed: ActiveSet,
    /// Part of the rigid load that the closed contacts do not carry \[N/√kg\].
    pub drift: Vec<f64>,
}

/// Contacts under a rigid load.
#[derive(Debug, Clone)]
pub(super) struct Contacts {
    pub contacts_at_rest: Vec<StaticContact>,
    /// Load f on the rigid motions \[N/√kg\].
    pub load: Vec<f64>,
}

impl Contacts {
    /// Stretch of each contact \[m\] under contact forces, at a position of the rigid motions.
    pub fn stretches(&self, forces: &[f64], place: &[f64]) -> Vec<f64> {
        let stretch = |static_contact: &StaticContact| {
            static_contact.offset + dot(&static_contact.along, place)
                - dot(&static_contact.compliance, forces)
        };
        self.contacts_at_rest.iter().map(stretch).collect()
    }

    /// Round-off of the stretch of a contact \[m\].
    pub fn noise(&self, contact: usize, forces: &[f64], place: &[f64]) -> f64 {
        let static_contact = &self.contacts_at_rest[contact];
        let moved = dot_of_moduli(&static_contact.along, place)
            + dot_of_moduli(&static_contact.compliance, forces);
        ROUND_OFF * (static_contact.size + moved)
    }

    /// The contacts that are stretched beyond round-off.
    pub fn stretched(&self, forces: &[f64], place: &[f64]) -> ActiveSet {
        let stretches = self.stretches(forces, place);
        (0..stretches.len())
            .filter(|&contact| stretches[contact] > self.noise(contact, forces, place))
            .fold(ActiveSet::FREE, ActiveSet::toggled)
    }

    /// The balance with exactly these contacts closed, with forces of any sign, that is nearest to a position y of
    /// the rigid motions. With the rigid motion `H h` from this position,
    ///
    /// ```text
    /// (B + 1/k) F − A H h = c + A y,      Hᵀ Gᵀ F = Hᵀ f
    /// ```
    fn with_closed(&self, closed: ActiveSet, place: &[f64]) -> StaticState {
        let among: Vec<usize> = closed.iter().collect();
        let constrained = span(among.iter().map(|&i| &self.contacts_at_rest[i].along[..]));
        let (count, order) = (among.len(), among.len() + constrained.len());
        let matrix = Mat::from_fn(order, order, |i, j| match (i < count, j < count) {
            (true, true) => {
                let static_contact = &self.contacts_at_rest[among[i]];
                let spring = if i == j { 1.0 / static_contact.stiffness } else { 0.0 };
                static_contact.compliance[among[j]] + spring
            }
            (true, false) => -dot(
                &self.contacts_at_rest[among[i]].along,
                &constrained[j - count],
            ),
            (false, true) => dot(
                &self.contacts_at_rest[among[j]].push,
                &constrained[i - count],
            ),
            (false, false) => 0.0,
        });
        let right: Vec<f64> = (among.iter())
            .map(|&i| self.contacts_at_rest[i].offset + dot(&self.contacts_at_rest[i].along, place))
            .chain(
                constrained
                    .iter()
                    .map(|constrained| dot(&self.load, constrained)),
            )
            .collect();
        let solution = match order {
            0 => Vec::new(),
            _ => linalg::solve(matrix.as_ref(), &right),
        };
        let mut forces = vec![0.0; self.contacts_at_rest.len()];
        let mut drift = self.load.clone();
        let mut size = largest(&drift);
        for (&contact, &force) in among.iter().zip(&solution) {
            forces[contact] = force;
            let push = &self.contacts_at_rest[contact].push;
            add_scaled(&mut drift, -force, push);
            size = size.max(force.abs() * largest(push));
        }
        let mut place = place.to_vec();
        for (constrained, shift) in constrained.iter().zip(&solution[count..]) {
            add_scaled(&mut place, *shift, constrained);
            let part = dot(&drift, constrained);
            add_scaled(&mut drift, -part, constrained);
        }
        if largest(&drift) <= SAME_MOTION * size {
            drift.fill(0.0);
        }
        StaticState {
            forces,
            place,
            closed,
            drift,
        }
    }

    /// Closed contacts that pull and open contacts that overlap, each with the size of its fault \[m\].
    fn faults(&self, rest: &StaticState) -> Vec<(usize, f64)> {
        let stretches = self.stretches(&rest.forces, &rest.place);
        let excess = |contact: usize| {
            if rest.closed.holds(contact) {
                -rest.forces[contact] / self.contacts_at_rest[contact].stiffness
            } else {
                stretches[contact]
            }
        };
        (0..self.contacts_at_rest.len())
            .map(|contact| (contact, excess(contact)))
            // This form of the condition makes a NaN a fault.
            .filter(|&(contact, excess)| {
                let noise = self.noise(contact, &rest.forces, &rest.place);
                !(excess <= noise && noise.is_finite())
            })
            .collect()
    }

    /// Whether the drift moves an open contact towards closing, beyond round-off.
    fn drifts_into_one(&self, rest: &StaticState) -> bool {
        self.contacts_at_rest
            .iter()
            .enumerate()
            .any(|(contact, static_contact)| {
                let noise = SAME_MOTION * dot_of_moduli(&static_contact.along, &rest.drift);
                !rest.closed.holds(contact) && dot(&static_contact.along, &rest.drift) > noise
            })
    }

    /// The state of least energy of contacts without friction, by Newton steps from another state. `None` if
    /// there is none.
    fn least_energy(&self, from: &StaticState) -> Option<StaticState> {
        let (mut forces, mut place) = (from.forces.clone(), from.place.clone());
        for _ in 0..MOST_STEPS {
            let next = self.with_closed(self.stretched(&forces, &place), &place);
            if self.faults(&next).is_empty() {
                if !self.drifts_into_one(&next) {
                    return Some(next);
                }
                (forces, place) = (next.forces, next.place);
                let zero = vec![0.0; forces.len()];
                self.descend(&mut forces, &mut place, [&zero, &next.drift]);
                continue;
            }
            let difference = |to: &[f64], from: &[f64]| -> Vec<f64> {
                to.iter().zip(from).map(|(a, b)| a - b).collect()
            };
            let way = [
                difference(&next.forces, &forces),
                difference(&next.place, &place),
            ];
            self.descend(&mut forces, &mut place, [&way[0], &way[1]]);
        }
        None
    }

    /// Moves forces and positions to the minimum of the energy along a direction. The slope of the energy is
    /// piecewise linear and increasing.
    fn descend(&self, forces: &mut [f64], place: &mut [f64], way: [&[f64]; 2]) {
        let stretches = self.stretches(forces, place);
        let given: Vec<f64> = (self.contacts_at_rest.iter())
            .map(|static_contact| dot(&static_contact.compliance, way[0]))
            .collect();
        let rates: Vec<f64> = (self.contacts_at_rest.iter().zip(&given))
            .map(|(static_contact, given)| dot(&static_contact.along, way[1]) - given)
            .collect();
        let [elastic, stiffening] = [dot(forces, &given), dot(way[0], &given)];
        let constant = elastic - dot(&self.load, way[1]);
        let slope = |t: f64| {
            let springs = (0..rates.len()).map(|i| {
                let stretch = (stretches[i] + t * rates[i]).max(0.0);
                self.contacts_at_rest[i].stiffness * stretch * rates[i]
            });
            constant + t * stiffening + springs.sum::<f64>()
        };
        let mut bends: Vec<f64> = (stretches.iter().zip(&rates))
            .map(|(stretch, rate)| -stretch / rate)
            .filter(|t| t.is_finite() && *t > 0.0)
            .collect();
        bends.sort_by(f64::total_cmp);
        // Beyond the last bend the slope is linear.
        bends.push(2.0 * bends.last().copied().unwrap_or(0.0) + 2.0);
        let rising = bends.iter().position(|&t| slope(t) >= 0.0);
        let end = rising.unwrap_or(bends.len() - 1);
        let [low, high] = [if end == 0 { 0.0 } else { bends[end - 1] }, bends[end]];
        let step = low - slope(low) * (high - low) / (slope(high) - slope(low));
        // If round-off hides the slope, use the full step.
        let step = if step > 0.0 && step.is_finite() { step } else { 1.0 };
        add_scaled(forces, step, way[0]);
        add_scaled(place, step, way[1]);
    }

    /// These contacts, which have no friction, with the fraction `part` of the friction of `other`.
    fn towards(&self, other: &Self, part: f64) -> Self {
        let mixed = |own: &[f64], other: &[f64]| -> Vec<f64> {
            let pairs = own.iter().zip(other);
            pairs
                .map(|(own, other)| own + part * (other - own))
                .collect()
        };
        let contacts_at_rest = (self.contacts_at_rest.iter().zip(&other.contacts_at_rest))
            .map(|(own, other)| StaticContact {
                push: mixed(&own.push, &other.push),
                compliance: mixed(&own.compliance, &other.compliance),
                ..own.clone()
            })
            .collect();
        Self {
            contacts_at_rest,
            load: self.load.clone(),
        }
    }

    /// These contacts, with the effect of the friction of `other` under given forces as an additional load.
    fn loaded_by(&self, other: &Self, forces: &[f64]) -> Self {
        let mut loaded = self.clone();
        for (own, other) in loaded
            .contacts_at_rest
            .iter_mut()
            .zip(&other.contacts_at_rest)
        {
            own.offset -= dot(&other.compliance, forces) - dot(&own.compliance, forces);
        }
        for ((own, other), force) in self
            .contacts_at_rest
            .iter()
            .zip(&other.contacts_at_rest)
            .zip(forces)
        {
            add_scaled(&mut loaded.load, *force, &own.push);
            add_scaled(&mut loaded.load, -force, &other.push);
        }
        loaded
    }

    /// The contacts that may close.
    fn closable(&self) -> Vec<usize> {
        (0..self.contacts_at_rest.len())
            .filter(|&contact| self.contacts_at_rest[contact].may_close())
            .collect()
    }

    /// The first static state among all combinations of closed contacts, near a position. `None` if there is
    /// none, or too many contacts.
    fn any_at(&self, place: &[f64]) -> Option<StaticState> {
        let tried = self.closable();
        if tried.len() > MOST_TRIED {
            return None;
        }
        let combination = |bits: u32| {
            let closed = (tried.iter().enumerate()).filter(|(place, _)| bits >> place & 1 == 1);
            closed
                .map(|(_, contact)| *contact)
                .fold(ActiveSet::FREE, ActiveSet::toggled)
        };
        (0..1_u32 << tried.len())
            .map(|bits| self.with_closed(combination(bits), place))
            .find(|rest| self.faults(rest).is_empty() && !self.drifts_into_one(rest))
    }

    /// The static state of the contacts `frictional` near another state. `self` has the same contacts without
    /// friction. If there is no such state, the error has the faults of the last state found.
    fn with_friction(
        &self,
        frictional: &Self,
        from: &StaticState,
    ) -> Result<StaticState, Vec<(usize, f64)>> {
        let mut rest = from.clone();
        let mut faults = Vec::new();
        for _ in 0..MOST_RENEWALS {
            let found = frictional.with_closed(rest.closed, &rest.place);
            faults = frictional.faults(&found);
            if faults.is_empty() && !frictional.drifts_into_one(&found) {
                return Ok(found);
            }
            let forces: Vec<f64> = found.forces.iter().map(|force| force.max(0.0)).collect();
            match self.loaded_by(frictional, &forces).least_energy(&rest) {
                Some(next) => rest = next,
                None => break,
            }
        }
        Err(faults)
    }
}

/// The static state of the contacts `whole`, from a starting state. `smooth` has the same contacts without
/// friction and with a symmetric flexibility.
///
/// # Errors
/// [`NoStaticState`] if friction is so large, or the flexibility so far from symmetric, that contacts lock.
pub(super) fn static_state(
    smooth: &Contacts,
    whole: &Contacts,
    from: &StaticState,
) -> Result<StaticState, NoStaticState> {
    let no_state = |faults: Vec<(usize, f64)>, friction: f64| NoStaticState {
        excess: faults.iter().fold(0.0, |most, fault| fault.1.max(most)),
        contacts: faults.into_iter().map(|(contact, _)| contact).collect(),
        friction,
        untried: None,
    };
    let Some(mut rest) = smooth.least_energy(from) else {
        let last = smooth.with_closed(smooth.stretched(&from.forces, &from.place), &from.place);
        return Err(no_state(smooth.faults(&last), 0.0));
    };
    let differ = |(own, other): (&StaticContact, &StaticContact)| {
        own.push != other.push || own.compliance != other.compliance
    };
    if !smooth
        .contacts_at_rest
        .iter()
        .zip(&whole.contacts_at_rest)
        .any(differ)
    {
        return Ok(rest);
    }
    let [mut step, least] = PARTS;
    let mut part = 0.0;
    while part < 1.0 {
        let next: f64 = f64::min(part + step, 1.0);
        match smooth.with_friction(&smooth.towards(whole, next), &rest) {
            Ok(found) => (rest, part, step) = (found, next, f64::min(2.0 * step, PARTS[0])),
            Err(faults) if step < least => {
                let count = whole.closable().len();
                return whole.any_at(&rest.place).ok_or_else(|| NoStaticState {
                    untried: (count > MOST_TRIED).then_some([count, MOST_TRIED]),
                    ..no_state(faults, next)
                });
            }
            Err(_) => step *= 0.5,
        }
    }
    Ok(rest)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Nothing can stretch twenty of the contacts: only the last one is tried.
    #[test]
    fn contacts_that_nothing_stretches_are_not_tried() {
        let static_contact = |felt: f64| StaticContact {
            offset: -1.0,
            size: 1.0,
            stiffness: 2.0,
            along: vec![felt],
            push: vec![felt],
            compliance: vec![0.0; 21],
        };
        let mut contacts_at_rest = vec![static_contact(0.0); 21];
        contacts_at_rest[20] = static_contact(1.0);
        let contacts = Contacts {
            contacts_at_rest,
            load: vec![3.0],
        };
        assert_eq!(contacts.closable(), [20]);
        let rest = contacts.any_at(&[0.0]).unwrap();
        assert_eq!((rest.forces[20], rest.place), (3.0, vec![2.5]));
    }
}
