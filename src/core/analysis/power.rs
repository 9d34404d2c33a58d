//! How much power does the vibration take in, and what dissipates it?
//!
//! The terms of the energy balance ([`super::energy`]), summed over whole mesh cycles:
//!
//! ```text
//! loads + error + stiffness = contact + structure + friction + stored        means over the record \[W]
//! ```
//!
//! For a periodic motion, the last window is followed by the first one, and the step between them is
//! included.

use super::energy::{Balance, Cause, WindowEndContacts};
use super::modal_series::ModalMotion;
use super::nvh::block_sums::BlockSums;
use super::power_outcome::PowerOutcome;
use crate::model::{Model, TrajectoryState};
use crate::numerics::statistics::standard_error;
use crate::propagate::{Event, Observer, Window};
use std::borrow::Cow;

/// Mesh cycles in a stretch, as for the other statistics.
const CYCLES_PER_STRETCH: u64 = 10;

/// Indices of the time \[s\] and of the gain of stored energy \[J\] in [`Sums`]. The works of all causes
/// \[J\] come first.
const TIME_INDEX: usize = Cause::COUNT;
const STORED_INDEX: usize = Cause::COUNT + 1;

/// Sums over a stretch.
type Sums = [f64; Cause::COUNT + 2];

/// Works on the vibration of a trajectory.
#[derive(Debug, Clone)]
pub struct Power {
    balance: Balance<'static>,
    /// Contacts at the start of the first window.
    first_contacts: Option<WindowEndContacts>,
    /// Energy stored at the end of the last cycle \[J\]; before that, at the start of the first window.
    energy: f64,
    sums: BlockSums<Sums>,
    repeats: bool,
}

impl Power {
    /// The power of a model's vibration, before the first window.
    pub fn new(model: &Model) -> Self {
        Self {
            balance: Balance::new(ModalMotion::of(Cow::Owned(model.clone()))),
            first_contacts: None,
            energy: 0.0,
            sums: BlockSums::new(Sums::default(), CYCLES_PER_STRETCH),
            repeats: false,
        }
    }

    /// Forgets everything accumulated.
    pub fn restart(&mut self) {
        self.balance.restart();
        self.first_contacts = None;
        self.sums.restart();
        self.repeats = false;
    }

    /// Marks the measured motion as periodic, after integration of whole periods.
    pub fn repeats(&mut self) {
        self.repeats = true;
    }

    /// Appends the record of another trajectory of the same model. The sum can be evaluated but not
    /// continued.
    pub fn append(&mut self, other: &Self) {
        self.first_contacts = self
            .first_contacts
            .take()
            .or_else(|| other.first_contacts.clone());
        self.sums.append(&other.sums);
    }

    /// Keeps the complete stretches within the first `cycles` of those measured.
    pub fn cut(&mut self, cycles: u64) {
        self.sums.cut(cycles);
    }

    /// Ends a mesh cycle, with the trajectory at its end.
    pub fn cycle(&mut self, end: &TrajectoryState) {
        if let Some(energy) = self.balance.stored_at(end) {
            self.sums.current()[STORED_INDEX] += energy - self.energy;
            self.energy = energy;
        }
        self.sums.advance();
    }

    /// Mean powers and their standard errors after whole mesh cycles; `None` before any window. Errors have
    /// no meaning for a periodic motion.
    pub fn outcome(&self) -> Option<[PowerOutcome; 2]> {
        let first_contacts = self.first_contacts.as_ref()?;
        let mut total = self.sums.total();
        if self.repeats {
            self.balance.step_to(first_contacts, &mut |cause, work| {
                total[cause as usize] += work;
                total[STORED_INDEX] += work;
            });
        }
        let mean = powers(|place, sense| sense * total[place] / total[TIME_INDEX]);
        let errors = powers(|place, _| {
            let stretches = self.sums.complete().iter();
            let series: Vec<f64> = stretches.map(|s| s[place] / s[TIME_INDEX]).collect();
            standard_error(&series)
        });
        Some([mean, errors])
    }
}

impl Observer for Power {
    const WINDOWS: bool = true;

    fn window(&mut self, window: &Window<'_>) {
        if self.first_contacts.is_none() {
            self.first_contacts = Some(WindowEndContacts::start(self.balance.model(), window));
            self.energy = self.balance.stored_before(window);
        }
        let sums = self.sums.current();
        sums[TIME_INDEX] += window.duration;
        let mut work = |cause: Cause, work: f64| sums[cause as usize] += work;
        self.balance.window(window, &mut work);
    }

    fn event(&mut self, event: &Event) {
        self.balance.event(event);
    }
}

/// Powers from a function of an index in the sums and a sign. The works of loads, error and stiffness are
/// inputs, the others are outputs.
fn powers(of: impl Fn(usize, f64) -> f64) -> PowerOutcome {
    let come = |cause: Cause| of(cause as usize, 1.0);
    let go = |cause: Cause| of(cause as usize, -1.0);
    PowerOutcome {
        loads: come(Cause::Loads),
        error: come(Cause::Error),
        stiffness: come(Cause::Stiffness),
        contact: go(Cause::Contact),
        structure: go(Cause::Structure),
        friction: go(Cause::Friction),
        stored: of(STORED_INDEX, 1.0),
    }
}
