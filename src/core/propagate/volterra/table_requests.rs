//! Which tables of windows are needed: one a length and direction, found while the cycle is laid out.

use super::window_stiffness::WindowStiffness;
use crate::model::Model;

/// The contacts that see the same deflection.
#[derive(Debug, Clone, PartialEq)]
pub struct LineView {
    /// Their line.
    pub line: usize,
    /// Window table whose rows are those of the line.
    pub window: usize,
    /// The contacts.
    pub contacts: Vec<usize>,
}

/// Window tables while it is found out which are needed: one a length and direction, with the
/// lines on which its force is felt besides.
#[derive(Default)]
pub struct TableRequests {
    pub kinds: Vec<(usize, usize)>,
    pub closures: Vec<Vec<WindowStiffness>>,
    /// Whether the stiffness varies on some window that no table has.
    pub varying: Vec<bool>,
    pub felt: Vec<Vec<usize>>,
}

impl TableRequests {
    /// The window table of a length and direction.
    pub fn window(&mut self, length: usize, direction: usize) -> usize {
        let window = place(&mut self.kinds, (length, direction));
        self.closures.resize(self.kinds.len(), Vec::new());
        self.varying.resize(self.kinds.len(), false);
        self.felt.resize(self.kinds.len(), Vec::new());
        window
    }

    /// The lines of contacts in their directions, for windows of a length.
    /// That of the contact `first` comes first.
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
                    // Beside the own direction only the line matters: one table serves it.
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

    /// What closes a contact on windows that start anywhere in its segment.
    pub fn close(&mut self, window: usize, closure: WindowStiffness) -> Option<usize> {
        if closure.varies() {
            self.varying[window] = true;
            return None;
        }
        Some(place(&mut self.closures[window], closure))
    }

    pub fn feel(&mut self, window: usize, line: usize) {
        place(&mut self.felt[window], line);
    }
}

/// Place of a value in a list, appended where it is new.
pub fn place<T: PartialEq>(known: &mut Vec<T>, value: T) -> usize {
    known.iter().position(|k| *k == value).unwrap_or_else(|| {
        known.push(value);
        known.len() - 1
    })
}
