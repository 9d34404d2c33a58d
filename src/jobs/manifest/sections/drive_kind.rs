//! Which kind of drive do `[gear]` and `[shafts]` describe?

use crate::manifest::reader::Section;
use crate::manifest::tree::Value;
use crate::shaft::Tier;

/// How `[gear]` and `[shafts]` become a structure.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum DriveKind {
    /// Rigid bodies.
    Rigid(Tier),
    /// Flexible shafts.
    Flexible,
    /// Not understood; the tables are still read, so that their faults are found as well.
    Faulty,
}

impl DriveKind {
    pub(super) fn of(name: &str) -> Self {
        let tier = Tier::ALL.into_iter().find(|tier| tier.name() == name);
        tier.map_or(Self::Flexible, Self::Rigid)
    }

    /// The value of `model.kind`.
    pub(super) fn name(self) -> Option<&'static str> {
        match self {
            Self::Rigid(tier) => Some(tier.name()),
            Self::Flexible => Some("flexible"),
            Self::Faulty => None,
        }
    }
}

/// Whether `model.kind` is `name`.
pub(super) fn is_kind(root: &Section, name: &str) -> bool {
    let model = root.entry("model").map(|entry| &entry.node);
    let kind = model.and_then(|model| model.entry("kind"));
    matches!(kind.map(|kind| &kind.node.value), Some(Value::Text(kind)) if kind == name)
}
