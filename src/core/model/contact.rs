//! What is a one-sided contact, and which contacts are closed?

use super::{MeshCycle, Release, Segment};
use crate::numerics::integers::least_multiple;
use strum::IntoStaticStr;

/// Index of the drive flank among the contacts of a gear pair.
pub const DRIVE_FLANK: usize = 0;

/// Index of the coast (back) flank among the contacts of a gear pair.
pub const COAST_FLANK: usize = 1;

/// Largest number of contacts of a model.
pub const MOST_CONTACTS: usize = 128;

/// Contacts per word of a set.
const WORD: usize = u64::BITS as usize;

/// Number of closed contacts that is rarely exceeded. Up to this number, kernels use smaller arrays.
pub const SEVERAL_CONTACTS: usize = 16;

/// The set of closed contacts of a model, by their indices in [`super::Model::contacts`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct ActiveSet(u128);

impl ActiveSet {
    /// No contact is closed: free flight.
    pub const FREE: Self = Self(0);
    /// The drive flank alone.
    pub const DRIVE: Self = Self(1 << DRIVE_FLANK);
    /// The coast flank alone.
    pub const COAST: Self = Self(1 << COAST_FLANK);

    /// The set with a contact added, or removed if it is in the set.
    pub fn toggled(self, contact: usize) -> Self {
        Self(self.0 ^ (1 << contact))
    }

    /// The contacts of either set.
    pub fn union(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// The contacts of this set that another set does not contain.
    pub fn without(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }

    /// Whether a contact is closed.
    pub fn holds(self, contact: usize) -> bool {
        // Test a bit of a 64-bit word: a shift of all 128 bits takes several instructions.
        let [first, further] = self.words();
        let word = if contact < WORD { first } else { further };
        word >> (contact % WORD) & 1 != 0
    }

    /// Whether any contact is closed.
    pub fn touching(self) -> bool {
        self.0 != 0
    }

    /// The closed contacts, in order.
    pub fn iter(self) -> impl Iterator<Item = usize> + Clone {
        let mut rest = self.0;
        std::iter::from_fn(move || {
            let next = (rest != 0).then(|| rest.trailing_zeros() as usize)?;
            rest &= rest - 1;
            Some(next)
        })
    }

    /// Number of closed contacts.
    pub fn count(self) -> usize {
        self.0.count_ones() as usize
    }

    /// The closed contact, if exactly one is closed.
    pub fn only(self) -> Option<usize> {
        (self.count() == 1).then(|| self.0.trailing_zeros() as usize)
    }

    /// +1 on the drive flank, −1 on the coast flank, 0 in free flight and if both flanks touch.
    pub fn sign(self) -> f64 {
        match self.flanks() {
            FlankState::Drive => 1.0,
            FlankState::Coast => -1.0,
            FlankState::Free | FlankState::Both => 0.0,
        }
    }

    /// The state of the flanks of the gear pair.
    pub fn flanks(self) -> FlankState {
        match (self.holds(DRIVE_FLANK), self.holds(COAST_FLANK)) {
            (true, false) => FlankState::Drive,
            (false, false) => FlankState::Free,
            (false, true) => FlankState::Coast,
            (true, true) => FlankState::Both,
        }
    }

    /// The name of the flanks' state in result files.
    pub fn name(self) -> &'static str {
        self.flanks().name()
    }

    /// The set as sums of `2^index`: the first 64 contacts, then the others with indices from 0.
    pub fn words(self) -> [u64; 2] {
        [self.0 as u64, (self.0 >> WORD) as u64]
    }

    /// The set from its [`Self::words`].
    pub fn of_words([first, further]: [u64; 2]) -> Self {
        Self(u128::from(first) | u128::from(further) << WORD)
    }
}

/// The state of the two flanks of a gear pair.
#[derive(Debug, Clone, Copy, PartialEq, Eq, IntoStaticStr)]
#[strum(serialize_all = "snake_case")]
pub enum FlankState {
    /// The drive flank touches.
    Drive,
    /// Free flight.
    Free,
    /// The coast (back) flank touches.
    Coast,
    /// Both touch: the mesh is tight.
    Both,
}

impl FlankState {
    /// Number of states.
    pub const COUNT: usize = 4;

    /// Index into statistics: drive, free, coast, both.
    pub fn index(self) -> usize {
        self as usize
    }

    /// Whether the drive flank and whether the coast flank touches.
    pub fn closed(self) -> [bool; 2] {
        let both = self == Self::Both;
        [both || self == Self::Drive, both || self == Self::Coast]
    }

    /// Its name in result files.
    pub fn name(self) -> &'static str {
        self.into()
    }
}

/// A one-sided contact: a spring and a damper across a gap, along the direction of each segment of its cycle.
///
/// A contact closes if `side δ` rises to the gap, with the deflection δ along that direction. For the coast flank of a
/// gear pair this direction is opposite to its push (`side` −1), so that the δ of both flanks grows with the relative
/// rotation.
#[derive(Debug, Clone, PartialEq)]
pub struct Contact {
    /// s: +1 closes where δ rises to the gap, −1 where it falls to minus the gap. 0 for the spring of a dry slider and
    /// for sticking dry friction, which exert forces in both directions.
    pub side: f64,
    /// Half gap b \[m\]. [`Self::gap`] adds the error of loaded flanks. For a slip of a dry slider it is the stretch
    /// F/k of its spring.
    pub half_gap: f64,
    /// Its mesh cycles in a base period. The sequence repeats.
    pub cycles: Vec<MeshCycle>,
    /// Rule for opening. Without a damper the rules by deflection and by force are equal, and this is
    /// [`Release::Deflection`].
    pub release: Release,
    /// For a layer of a film, the depth \[m\] beyond which the next layer replaces it; infinite for other
    /// contacts.
    pub band: f64,
}

/// Number of mesh cycles after which all given contacts repeat.
pub(super) fn base_cycles(contacts: &[Contact]) -> usize {
    let lengths = contacts.iter().map(|contact| contact.cycles.len());
    lengths.fold(1, least_multiple)
}

impl Contact {
    /// The mesh cycle with a number.
    pub fn cycle(&self, number: u64) -> &MeshCycle {
        match self.cycles.len() {
            1 => &self.cycles[0],
            count => &self.cycles[(number % count as u64) as usize],
        }
    }

    /// Gap \[m\] and its rate \[m/s\] at a time \[s\] within a segment, its ends included.
    pub fn gap(&self, segment: &Segment, time: f64) -> [f64; 2] {
        let period = self.cycles[0].period;
        let [error, slope] = segment.error_at(time / period);
        [self.half_gap + error, slope / period]
    }

    /// Distance \[m\] of δ from the surface: positive inside a closed contact and outside an open one, negative on the
    /// other side.
    pub fn margin(&self, closed: bool, deflection: f64, gap: f64) -> f64 {
        if closed { self.side * deflection - gap } else { gap - self.side * deflection }
    }

    /// Friction force ±F \[N\] while a dry slider or dry friction slips; `None` for other contacts.
    pub fn constant_force(&self, segment: &Segment) -> Option<f64> {
        let force = self.side * segment.stiffness.mean();
        match self.release {
            Release::Slip => Some(force * self.half_gap),
            Release::Rub => Some(force),
            _ => None,
        }
    }

    /// Whether a deflection and its rate close the contact at a time \[s\] within its segment. Neither
    /// release rule needs the history of the motion: a compressed contact is open only if its spring and
    /// damper together would pull.
    pub fn closes(&self, segment: &Segment, time: f64, deflection: f64, rate: f64) -> bool {
        let pushes = || self.side * self.force(segment, time, deflection, rate) > 0.0;
        let gap = self.gap(segment, time);
        self.is_reached(deflection, rate, gap)
            && (self.release == Release::Deflection || pushes())
            && self.side * deflection - gap[0] < self.band
    }

    /// Whether a deflection is beyond the surface of the contact, for its gap and the rate of the gap.
    /// Exactly on the surface the rates decide.
    pub fn is_reached(&self, deflection: f64, rate: f64, [gap, opening]: [f64; 2]) -> bool {
        let (reach, approach) = (self.side * deflection, self.side * rate);
        reach > gap || (reach == gap && approach > opening)
    }

    /// Force \[N\] of the closed contact along its direction, `k (δ − s b) + c (δ' − s b')`, at a time \[s\] within its
    /// segment. For a slip it is the constant force.
    pub fn force(&self, segment: &Segment, time: f64, deflection: f64, rate: f64) -> f64 {
        if let Some(limit) = self.constant_force(segment) {
            return limit;
        }
        let [gap, opening] = self.gap(segment, time);
        segment.stiffness_at(time / self.cycles[0].period) * (deflection - self.side * gap)
            + segment.damping * (rate - self.side * opening)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Division, FlankError, Stiffness};

    /// A contact whose gap grows from 11 to 13 µm and whose stiffness grows from 3e8 to 5e8 N/m within a millisecond.
    fn contact(side: f64, release: Release) -> Contact {
        let division = Division {
            stiffness: Stiffness::series([4e8, 1e8, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
            error: FlankError::series([2e-6, 1e-6, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
            ..Division::level(1.0, 4e8)
        };
        Contact {
            side,
            half_gap: 10e-6,
            cycles: vec![MeshCycle::new(1e-3, &[division], &[0], 1000.0)],
            release,
            band: f64::INFINITY,
        }
    }

    #[test]
    fn forces_are_those_of_spring_and_damper() {
        for side in [1.0, -1.0] {
            let contact = contact(side, Release::Deflection);
            let segment = &contact.cycle(3).segments[0];
            // A quarter through the cycle: gap 11.5 µm, opening at 2 mm/s, 3.5e8 N/m.
            let [gap, opening] = contact.gap(segment, 0.25e-3);
            assert!((gap - 11.5e-6).abs() < 1e-20 && (opening - 2e-3).abs() < 1e-16);
            let force = contact.force(segment, 0.25e-3, side * 13.5e-6, side * 0.012);
            assert!((force - side * (3.5e8 * 2e-6 + 1000.0 * 0.01)).abs() < 1e-9);
            let margins = [true, false].map(|closed| contact.margin(closed, side * 13.5e-6, gap));
            assert!((margins[0] - 2e-6).abs() < 1e-20 && (margins[1] + 2e-6).abs() < 1e-20);
        }
    }

    /// By deflection, a contact is closed if it is compressed, or on its surface and approaching. By force, it must
    /// also push.
    #[test]
    fn contacts_close_by_their_law() {
        for side in [1.0, -1.0] {
            let laws = [Release::Deflection, Release::Force].map(|law| contact(side, law));
            let [gap, opening] = laws[0].gap(&laws[0].cycles[0].segments[0], 0.5e-3);
            let closes = |depth: f64, approach: f64| {
                [0, 1].map(|law| {
                    let (own, deflection): (&Contact, _) = (&laws[law], side * (gap + depth));
                    let segment = &own.cycles[0].segments[0];
                    own.closes(segment, 0.5e-3, deflection, side * (opening + approach))
                })
            };
            // 1 µm of 4e8 N/m is 400 N. The damper of 1000 N s/m cancels it at 0.4 m/s.
            assert_eq!(closes(1e-6, -0.3), [true, true]);
            assert_eq!(closes(1e-6, -0.5), [true, false]);
            assert_eq!(closes(-1e-6, 0.5), [false, false]);
            assert_eq!(closes(0.0, 0.1), [true, true]);
            assert_eq!(closes(0.0, 0.0), [false, false]);
            assert_eq!(closes(0.0, -0.1), [false, false]);
        }
    }

    #[test]
    fn sets_hold_what_is_toggled() {
        let all = [1, 4, 15, 63, 64, 127];
        let set = all.into_iter().fold(ActiveSet::FREE, ActiveSet::toggled);
        assert_eq!(set.iter().collect::<Vec<_>>(), all);
        assert_eq!((set.count(), set.only()), (6, None));
        assert_eq!(set.words(), [(1 << 63) + 0x8012, (1 << 63) + 1]);
        assert_eq!(ActiveSet::of_words(set.words()), set);
        assert!((0..MOST_CONTACTS).all(|contact| set.holds(contact) == all.contains(&contact)));
        let one = [1, 15, 63, 64, 127]
            .into_iter()
            .fold(set, ActiveSet::toggled);
        let other = ActiveSet::COAST.toggled(2);
        let drive = [4, 15, 64]
            .into_iter()
            .fold(ActiveSet::FREE, ActiveSet::toggled);
        assert_eq!(
            drive.union(other).iter().collect::<Vec<_>>(),
            [1, 2, 4, 15, 64]
        );
        assert_eq!(
            drive.toggled(2).without(other).iter().collect::<Vec<_>>(),
            [4, 15, 64]
        );
        assert_eq!((one.only(), one.touching()), (Some(4), true));
        assert_eq!(
            (one.toggled(4), ActiveSet::FREE.touching()),
            (ActiveSet::FREE, false)
        );
        let both = ActiveSet::DRIVE.toggled(COAST_FLANK);
        let all = [ActiveSet::DRIVE, ActiveSet::FREE, ActiveSet::COAST, both];
        assert_eq!(all.map(ActiveSet::sign), [1.0, 0.0, -1.0, 0.0]);
        assert_eq!(all.map(ActiveSet::name), ["drive", "free", "coast", "both"]);
        assert_eq!(all.map(|set| set.flanks().index()), [0, 1, 2, 3]);
        // Other contacts do not count as flanks.
        assert_eq!(one.flanks(), FlankState::Free);
    }
}
