//! An optional table.

use crate::manifest::diagnostic::Issues;
use crate::manifest::reader::{Child, Section};

/// `Some(None)` if absent, `None` if faulty.
pub(super) fn optional<T>(
    section: &Section,
    issues: &mut Issues,
    name: &str,
    read: impl FnOnce(&Section, &mut Issues) -> Option<T>,
) -> Option<Option<T>> {
    match section.child(issues, name) {
        Child::Absent => Some(None),
        Child::Invalid => None,
        Child::Present(table) => read(&table, issues).map(Some),
    }
}
