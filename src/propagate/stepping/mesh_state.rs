//! What do the contacts look like at one instant, and what changes on the way to the next?

use crate::model::{Contact, MOST_CONTACTS, Release};

/// What a contact looks like at one instant.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct MeshState {
    pub time: f64,
    pub deflection: f64,
    pub rate: f64,
    /// Gap \[m\] and its rate \[m/s\].
    pub gap: [f64; 2],
}

impl MeshState {
    /// Push of a contact's spring \[N/m\] and damper \[N s/m\] on its side \[N\].
    pub fn push(&self, side: f64, [stiffness, damping]: [f64; 2]) -> f64 {
        side * self.force(side, [stiffness, damping])
    }

    /// Force of a contact's spring \[N/m\] and damper \[N s/m\] along its direction \[N\].
    pub fn force(&self, side: f64, [stiffness, damping]: [f64; 2]) -> f64 {
        let [gap, opening] = self.gap.map(|value| side * value);
        stiffness * (self.deflection - gap) + damping * (self.rate - opening)
    }
}

/// Where between two instants a contact changes its state.
#[derive(Debug, Clone, Copy)]
pub(super) struct Change {
    /// Whether it closes.
    pub closes: bool,
    /// Fraction of the way.
    pub fraction: f64,
    /// Whether it is at its surface; else its push passes zero.
    pub on_surface: bool,
}

impl Change {
    /// The change of a contact of some stiffness \[N/m\] and damping \[N s/m\] that is `closed`; none
    /// where it stays what it is.
    pub fn between(
        [old, new]: [&MeshState; 2],
        contact: &Contact,
        closed: bool,
        law: [f64; 2],
    ) -> Option<Self> {
        let side = contact.side;
        let by_force = contact.release == Release::Force;
        let pushes = || new.push(side, law) > 0.0;
        let closes =
            contact.is_reached(new.deflection, new.rate, new.gap) && (!by_force || pushes());
        if closes == closed {
            return None;
        }
        let [level, goal] = [old, new].map(|mesh| side * mesh.gap[0]);
        // What was compressed closes by its push, and by it every contact lets go that never pulls.
        let on_surface = !by_force || (closes && side * (old.deflection - level) <= 0.0);
        let (left, change) = match on_surface {
            true => {
                let change = (new.deflection - old.deflection) - (goal - level);
                (level - old.deflection, change)
            }
            false => {
                let [before, after] = [old, new].map(|mesh| mesh.push(side, law));
                (-before, after - before)
            }
        };
        let fraction = match change == 0.0 {
            true => 1.0,
            false => (left / change).clamp(0.0, 1.0),
        };
        Some(Self {
            closes,
            fraction,
            on_surface,
        })
    }
}

/// All contacts at one instant, in order.
pub(super) type MeshStates = [MeshState; MOST_CONTACTS];
