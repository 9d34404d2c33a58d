//! Which window tables do the windows of a cycle need? There is one table per length and direction.

use super::window_stiffness::WindowStiffness;
use crate::model::Model;

/// Contacts with the same deflection.
#[derive(Debug, Clone, PartialEq)]
pub struct LineView {
    /// Their line.
    pub line: usize,
    /// Window table with the rows of that line.
    pub window: usize,
    /// The contacts.
    pub contacts: Vec<usize>,
}

/// The required window tables: one per length and direction of a force, with the lines whose response to this force is
/// needed.
#[derive(Default)]
pub struct TableRequests {
    pub kinds: Vec<(usize, usize)>,
    pub closures: Vec<Vec<WindowStiffness>>,
    /// Whether the stiffness varies on some window without a tabulated operator.
    pub varying: Vec<bool>,
    pub response_lines: Vec<Vec<usize>>,
}

impl TableRequests {
    /// The window table of a length and direction.
    pub fn window(&mut self, length: usize, direction: usize) -> usize {
        let window = place(&mut self.kinds, (length, direction));
        self.closures.resize(self.kinds.len(), Vec::new());
        self.varying.resize(self.kinds.len(), false);
        self.response_lines.resize(self.kinds.len(), Vec::new());
        window
    }

    /// The lines of contacts in their directions, for windows of a length. The line of the contact `first` comes
    /// first.
    pub fn views(
        &mut self,
        model: &Model,
        length: usize,
        directions: &[usize],
        first: usize,
    ) -> Vec<LineView> {
        let mut views: Vec<LineView> = Vec::new();
        let others = (0..directions.len()).filter(|&contact| contact != first);
        for contact in std::iter::once(first).chain(others) {
            let direction = directions[contact];
            let line = model.directions[direction].line;
            match views.iter_mut().find(|view| view.line == line) {
                Some(view) => view.contacts.push(contact),
                None => {
                    // For the other contacts only the line matters, so one table serves each line.
                    let known = (self.kinds.iter())
                        .position(|kind| kind.0 == length && model.directions[kind.1].line == line);
                    let window = match known.filter(|_| contact != first) {
                        Some(known) => known,
                        None => self.window(length, direction),
                    };
                    views.push(LineView {
                        line,
                        window,
                        contacts: vec![contact],
                    });
                }
            }
        }
        for view in &mut views {
            view.contacts.sort_unstable();
        }
        views
    }

    /// Requests the solution operator of a contact on windows that start anywhere in its segment. Returns its index, or
    /// `None` if the stiffness varies.
    pub fn close(&mut self, window: usize, closure: WindowStiffness) -> Option<usize> {
        if closure.varies() {
            self.varying[window] = true;
            return None;
        }
        Some(place(&mut self.closures[window], closure))
    }

    pub fn request_response(&mut self, window: usize, line: usize) {
        place(&mut self.response_lines[window], line);
    }
}

/// Index of a value in a list. The value is appended if it is new.
pub fn place<T: PartialEq>(known: &mut Vec<T>, value: T) -> usize {
    known.iter().position(|k| *k == value).unwrap_or_else(|| {
        known.push(value);
        known.len() - 1
    })
}
