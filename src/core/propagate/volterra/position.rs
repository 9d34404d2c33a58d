//! Where does a window start, and what is it laid on?

use super::joint_stretch::JointStretch;
use super::table_requests::LineView;
use super::tables::Schedule;
use crate::model::ActiveSet;

/// Times closer than this part of a mesh period are one; breakpoints are farther apart.
pub(super) const SAME_TIME: f64 = 1e-12;

/// Where a window starts.
#[derive(Debug, Clone, Copy)]
pub(super) struct Position {
    /// Mesh cycle.
    pub cycle: u64,
    /// Time within it \[s\].
    pub time: f64,
    /// The cell that starts here, when on the cell grid of the schedule.
    pub aligned: Option<usize>,
    /// Contacts that opened or closed here at their surface.
    pub crossed: ActiveSet,
    /// Contacts that opened or closed here because their force vanished.
    pub forceless: ActiveSet,
}

/// What a window is laid on.
#[derive(Clone, Copy)]
pub(super) enum Track<'t> {
    /// A stretch of a schedule: at most one contact is closed.
    Schedule(&'t Schedule, usize),
    /// Several contacts are closed.
    Joint(&'t JointStretch),
}

impl<'t> Track<'t> {
    /// The lines of all contacts.
    #[inline]
    pub fn views(self) -> &'t [LineView] {
        match self {
            Self::Schedule(schedule, stretch) => &schedule.sights_of_stretch[stretch],
            Self::Joint(stretch) => &stretch.views,
        }
    }

    /// Place of a contact's line.
    pub fn place_of(self, contact: usize) -> usize {
        let sees = |view: &LineView| view.contacts.contains(&contact);
        self.views().iter().position(sees).unwrap_or(0)
    }

    /// Whether several contacts are closed.
    pub fn is_joint(self) -> bool {
        matches!(self, Self::Joint(_))
    }
}

/// Takes up the cell grid again at a breakpoint. Beyond a change of gap or line nothing stands
/// on a surface any more.
pub(super) fn align(position: &mut Position, track: Track<'_>, stop: f64, cell: Option<usize>) {
    position.time = stop;
    position.aligned = cell;
    // Stiffness steps there, and the force with it.
    position.forceless = ActiveSet::FREE;
    let turned = match track {
        Track::Schedule(schedule, _) => {
            let next = cell.and_then(|cell| schedule.grid.stretch_from(cell));
            schedule.grid.turned[next.unwrap_or(0)]
        }
        // Whatever stands on a surface is found there again.
        Track::Joint(_) => false,
    };
    if turned {
        position.crossed = ActiveSet::FREE;
    }
}
