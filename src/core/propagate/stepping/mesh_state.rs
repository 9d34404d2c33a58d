//! What are the states of the contacts at one instant, and what changes before the next?

use crate::model::{Contact, Release};

/// The state of a contact at one instant.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct MeshState {
    pub time: f64,
    pub deflection: f64,
    pub rate: f64,
    /// Gap \[m\] and its rate \[m/s\].
    pub gap: [f64; 2],
}

impl MeshState {
    /// Push \[N\] of a contact's spring \[N/m\] and damper \[N s/m\]; positive under compression, on either
    /// side.
    pub fn push(&self, side: f64, [stiffness, damping]: [f64; 2]) -> f64 {
        side * self.force(side, [stiffness, damping])
    }

    /// Force of a contact's spring \[N/m\] and damper \[N s/m\] along its direction \[N\].
    pub fn force(&self, side: f64, [stiffness, damping]: [f64; 2]) -> f64 {
        let [gap, opening] = self.gap.map(|value| side * value);
        stiffness * (self.deflection - gap) + damping * (self.rate - opening)
    }
}

/// A change of a contact's state between two instants.
#[derive(Debug, Clone, Copy)]
pub(super) struct Change {
    /// Whether it closes.
    pub closes: bool,
    /// Position between the instants, from 0 to 1.
    pub fraction: f64,
    /// Whether the contact is on its surface there. If not, its push passes zero.
    pub on_surface: bool,
}

impl Change {
    /// The change of a contact with a stiffness \[N/m\] and a damping \[N s/m\] that is `closed` or open; `None` if
    /// its state does not change.
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
        // With release at zero force, a contact that is compressed already closes where its push becomes positive, and
        // every contact opens where its push vanishes.
        let on_surface = !by_force || (closes && side * (old.deflection - level) <= 0.0);
        let (left, change) = if on_surface {
            let change = (new.deflection - old.deflection) - (goal - level);
            (level - old.deflection, change)
        } else {
            let [before, after] = [old, new].map(|mesh| mesh.push(side, law));
            (-before, after - before)
        };
        let fraction = if change == 0.0 { 1.0 } else { (left / change).clamp(0.0, 1.0) };
        Some(Self {
            closes,
            fraction,
            on_surface,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAW: [f64; 2] = [4e8, 1000.0];

    fn contact(side: f64, release: Release) -> Contact {
        Contact {
            band: f64::INFINITY,
            side,
            half_gap: 1e-5,
            cycles: Vec::new(),
            release,
        }
    }

    /// An instant from the deflection and the gap of a contact towards its side \[µm\], at constant rates \[m/s\].
    fn state_of(side: f64, [deflection, gap]: [f64; 2], [rate, opening]: [f64; 2]) -> MeshState {
        MeshState {
            time: 0.0,
            deflection: side * 1e-6 * deflection,
            rate: side * rate,
            gap: [1e-6 * gap, opening],
        }
    }

    #[test]
    fn pushes_are_those_of_spring_and_damper() {
        for side in [1.0, -1.0] {
            // 2 µm beyond a gap that opens 10 mm/s slower than the deflection grows.
            let state = state_of(side, [12.0, 10.0], [0.03, 0.02]);
            assert!((state.push(side, LAW) - 810.0).abs() < 1e-9);
            assert!((state.force(side, LAW) - side * 810.0).abs() < 1e-9);
        }
    }

    /// Deflection and gap on straight lines meet at their intersection.
    #[test]
    fn a_surface_that_moves_is_met_where_the_lines_cross() {
        for side in [1.0, -1.0] {
            let contact = contact(side, Release::Deflection);
            for (deflection, gap, closes, fraction) in [
                ([8.0, 12.0], [10.0, 10.0], true, 0.5),
                ([8.0, 12.0], [9.0, 11.0], true, 0.5),
                ([8.0, 12.0], [11.0, 10.0], true, 0.6),
                ([12.0, 11.0], [10.0, 12.0], false, 2.0 / 3.0),
                ([12.0, 6.0], [10.0, 8.0], false, 0.5),
            ] {
                let [old, new] =
                    [0, 1].map(|i| state_of(side, [deflection[i], gap[i]], [0.0, 0.0]));
                let change = Change::between([&old, &new], &contact, !closes, LAW).unwrap();
                assert!(change.closes == closes && change.on_surface);
                assert!(
                    (change.fraction - fraction).abs() < 1e-12,
                    "{}",
                    change.fraction
                );
                assert!(Change::between([&old, &new], &contact, closes, LAW).is_none());
            }
            // Beyond the surface from the start, the change is immediate.
            let [old, new] =
                [[11.0, 10.0], [14.0, 10.0]].map(|places| state_of(side, places, [0.0; 2]));
            let change = Change::between([&old, &new], &contact, false, LAW).unwrap();
            assert_eq!((change.closes, change.fraction), (true, 0.0));
        }
    }

    /// A contact that never pulls opens where its push passes zero, and a compressed one closes there.
    #[test]
    fn a_contact_that_never_pulls_changes_with_its_push() {
        for side in [1.0, -1.0] {
            let contact = contact(side, Release::Force);
            // 2 µm deep, moving away: pushes of 800 N - 600 N and of 800 N - 1000 N.
            let [pushing, pulling] =
                [-0.6, -1.0].map(|rate| state_of(side, [12.0, 10.0], [rate, 0.0]));
            let opening_change =
                Change::between([&pushing, &pulling], &contact, true, LAW).unwrap();
            assert!(!opening_change.closes && !opening_change.on_surface);
            assert!(
                (opening_change.fraction - 0.5).abs() < 1e-12,
                "{}",
                opening_change.fraction
            );
            let back = Change::between([&pulling, &pushing], &contact, false, LAW).unwrap();
            assert!(back.closes && !back.on_surface);
            assert!((back.fraction - 0.5).abs() < 1e-12, "{}", back.fraction);
            assert!(Change::between([&pulling, &pulling], &contact, false, LAW).is_none());
            // From outside, it closes at its surface.
            let outside = state_of(side, [9.0, 10.0], [0.3, 0.0]);
            let inside = state_of(side, [12.0, 10.0], [0.3, 0.0]);
            let closing_change =
                Change::between([&outside, &inside], &contact, false, LAW).unwrap();
            assert!(
                closing_change.closes
                    && closing_change.on_surface
                    && (closing_change.fraction - 1.0 / 3.0).abs() < 1e-12
            );
        }
    }
}
