//! By which rule does a closed contact open?

use serde::Serialize;
use strum::EnumString;

/// The rule for opening a closed contact.
///
/// The force `k (δ − s b) + c (δ' − s b')` of an opening contact changes its sign while the contact is still
/// compressed, because the damper pulls. The variants state where the contact opens.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, EnumString)]
#[strum(serialize_all = "snake_case")]
pub enum Release {
    /// Where δ falls back to the gap: the force of spring and damper may have either sign.
    #[default]
    Deflection,
    /// Where the force falls to zero: the contact never pulls. It closes where δ rises to the
    /// gap, or, while it is still compressed, where the force of spring and damper rises to zero.
    Force,
    /// Where the velocity of its slider vanishes: the slip of a dry slider.
    Slip,
    /// Where a slip begins: the spring of a dry slider, which pulls and pushes.
    Stick,
    /// Where the flanks no longer approach: a layer of a film of oil, which does not pull. The next layer replaces it
    /// where the film is squeezed to the thickness of that layer.
    Film,
    /// At the instant of closing: the impact on a rigid stop.
    Impact,
    /// Where its force falls to zero: the rest of the structure on a rigid stop.
    Rest,
    /// Where the speed of sliding vanishes: a slip of dry friction, whose force is constant.
    Rub,
    /// Where its force exceeds that of static friction: dry friction that sticks.
    Grip,
}

impl Release {
    /// Whether a closing at an approach speed \[m/s\] is an impact of surfaces. It is not if a compressed contact
    /// closes again by its force, and never for sliders, films, rests and dry friction.
    pub fn is_struck(self, approach: f64) -> bool {
        match self {
            Self::Deflection | Self::Impact => true,
            Self::Force => approach > 0.0,
            Self::Slip | Self::Stick | Self::Film | Self::Rest | Self::Rub | Self::Grip => false,
        }
    }

    /// Whether a contact with a spring or damper opens where its force vanishes, so that it never pulls.
    pub fn is_by_force(self) -> bool {
        matches!(self, Self::Force | Self::Film)
    }

    /// Whether it belongs to a state of a dry slider.
    pub fn of_slider(self) -> bool {
        matches!(self, Self::Slip | Self::Stick)
    }

    /// Whether it belongs to a state of dry friction.
    pub fn of_friction(self) -> bool {
        matches!(self, Self::Rub | Self::Grip)
    }

    /// Whether it closes at a surface, so that nothing on the other side of its line is in reach while it is closed.
    pub fn has_surface(self) -> bool {
        !(self.of_slider() || self.of_friction())
    }

    /// Whether it belongs to a part of a rigid stop.
    pub fn of_stop(self) -> bool {
        matches!(self, Self::Impact | Self::Rest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// With release by force a contact may close while its surfaces separate: that is not an impact.
    #[test]
    fn what_takes_hold_while_it_parts_is_not_struck() {
        for (law, approach, struck) in [
            (Release::Force, 1e-3, true),
            (Release::Force, 0.0, false),
            (Release::Force, -1e-3, false),
            (Release::Deflection, 1e-3, true),
            (Release::Deflection, -1e-3, true),
            (Release::Slip, 1e-3, false),
            (Release::Film, 1e-3, false),
            (Release::Impact, 1e-3, true),
            (Release::Rest, 1e-3, false),
            (Release::Rub, 1e-3, false),
            (Release::Grip, 1e-3, false),
        ] {
            assert_eq!(law.is_struck(approach), struck, "{law:?} {approach}");
        }
    }
}
