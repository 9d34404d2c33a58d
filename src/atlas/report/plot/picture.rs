//! A drawn picture before it is written to a file.

use super::canvas::Canvas;
use super::draw;
use super::error::PlotError;

/// A picture, not yet in a file format.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// File name without extension.
    pub name: String,
    pub(super) canvas: Canvas,
}

impl Picture {
    /// `name` may contain names of axes; characters that do not fit into a file name are replaced.
    pub(super) fn new(name: String, canvas: Canvas) -> Self {
        let fits = |c: char| !c.is_control() && c != '/';
        let name = name.chars().map(|c| if fits(c) { c } else { '_' });
        Self {
            name: name.collect(),
            canvas,
        }
    }

    /// The picture as an SVG document, 960 pixels wide.
    ///
    /// # Errors
    /// The drawing library fails.
    pub fn svg(&self) -> Result<String, PlotError> {
        draw::svg(&self.canvas)
    }

    /// The picture as a PNG file, 1920 pixels wide.
    ///
    /// # Errors
    /// The drawing library fails.
    pub fn png(&self) -> Result<Vec<u8>, PlotError> {
        draw::png(&self.canvas)
    }
}

/// Drawn pictures, with notes on what is not drawn.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Drawn {
    /// The pictures, by kind.
    pub pictures: Vec<Picture>,
    /// Omitted data with the reasons, one sentence each.
    pub notes: Vec<String>,
}

impl Drawn {
    pub(super) fn one(name: impl Into<String>, canvas: Canvas) -> Self {
        Self {
            pictures: vec![Picture::new(name.into(), canvas)],
            notes: Vec::new(),
        }
    }

    /// A start without pictures, with a note on the picture `name` if only `drawn` of `all` slices will be drawn.
    pub(super) fn sliced(name: &str, drawn: usize, all: usize) -> Self {
        let mut notes = Vec::new();
        if drawn < all {
            notes.push(format!(
                "{name}: only the first {drawn} of {all} slices are drawn"
            ));
        }
        Self {
            pictures: Vec::new(),
            notes,
        }
    }

    /// Adds a note for each picture with marks that were left out because they overlap others: their number.
    pub(super) fn say_what_was_thinned(&mut self) {
        for picture in self
            .pictures
            .iter()
            .filter(|picture| picture.canvas.left_out > 0)
        {
            self.notes.push(format!(
                "{}: {} marks and line points that lie within a pixel of others",
                picture.name, picture.canvas.left_out
            ));
        }
    }

    /// Appends the pictures and notes of another.
    pub fn append(&mut self, other: Self) {
        self.pictures.extend(other.pictures);
        self.notes.extend(other.notes);
    }
}
