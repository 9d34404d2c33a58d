//! Where does a window start, and which stretch of a schedule, or joint stretch, does it follow?

use super::joint_stretch::JointStretch;
use super::table_requests::LineView;
use super::tables::Schedule;
use crate::model::ActiveSet;

/// Times closer than this part of a mesh period are equal. Breakpoints are farther apart.
pub(super) const SAME_TIME: f64 = 1e-12;

/// Where a window starts.
#[derive(Debug, Clone, Copy)]
pub(super) struct Position {
    /// Mesh cycle.
    pub cycle: u64,
    /// Time within it \[s\].
    pub time: f64,
    /// The cell that starts here, if the position is on the cell grid of the schedule.
    pub aligned: Option<usize>,
    /// Contacts that opened or closed at their surface at this time.
    pub crossed: ActiveSet,
    /// Contacts that opened or closed at this time because their force vanished.
    pub forceless: ActiveSet,
}

/// The stretch that a window follows.
#[derive(Clone, Copy)]
pub(super) enum WindowSource<'t> {
    /// A stretch of a schedule: at most one contact is closed.
    Schedule(&'t Schedule, usize),
    /// A joint stretch: several contacts are closed, or the model has dry sliders, rigid stops or dry friction.
    Joint(&'t JointStretch),
}

impl<'t> WindowSource<'t> {
    /// The lines of all contacts.
    #[inline]
    pub fn views(self) -> &'t [LineView] {
        match self {
            Self::Schedule(schedule, stretch) => &schedule.views_of_stretch[stretch],
            Self::Joint(stretch) => &stretch.views,
        }
    }

    /// Index of a contact's line among the views.
    pub fn place_of(self, contact: usize) -> usize {
        let sees = |view: &LineView| view.contacts.contains(&contact);
        self.views().iter().position(sees).unwrap_or(0)
    }

    /// Whether this is a joint stretch.
    pub fn is_joint(self) -> bool {
        matches!(self, Self::Joint(_))
    }
}

/// Moves to a breakpoint, where a schedule returns to its cell grid. If a gap or line changes at the start of the
/// schedule's next stretch, no contact counts as on its surface.
pub(super) fn align(
    position: &mut Position,
    track: WindowSource<'_>,
    stop: f64,
    cell: Option<usize>,
) {
    position.time = stop;
    position.aligned = cell;
    // Stiffness and force may jump at a breakpoint.
    position.forceless = ActiveSet::FREE;
    let turned = match track {
        WindowSource::Schedule(schedule, _) => {
            let next = cell.and_then(|cell| schedule.grid.stretch_from(cell));
            schedule.grid.turned[next.unwrap_or(0)]
        }
        // On a joint stretch `crossed` keeps its contacts.
        WindowSource::Joint(_) => false,
    };
    if turned {
        position.crossed = ActiveSet::FREE;
    }
}
