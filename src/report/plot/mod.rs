//! Pictures of a results or trace folder, in SVG and PNG, from its Parquet files alone, and of
//! a mesh table.
//!
//! Each kind of picture is a list of shapes on a [`canvas`] first, and one place makes SVG
//! or PNG of it. Same files, same bytes.

mod axis;
mod basins;
mod bifurcation;
mod branches;
mod canvas;
mod categories;
mod cells;
mod class_rows;
mod curves;
mod draw;
mod error;
mod horizon;
mod kicks;
mod lambda_curve;
mod lambda_map;
mod lettering;
mod machine;
mod marker;
mod mesh;
mod motion;
mod multipliers;
mod orbits;
mod over_axis;
mod panel;
mod phase;
mod picture;
mod ramp;
mod recording;
mod results;
mod section;
mod shares;
mod spectrum;
mod trace;
mod what;

use std::path::Path;

use strum::VariantArray;

use crate::report::followed::Followed;
use crate::store::{TableKind, record_paths};
use mesh::MeshCurves;
use recording::Recording;
use results::Results;

pub use error::PlotError;
pub use machine::pictures as machine_pictures;
pub use picture::{Drawn, Picture};
pub use what::{PlotRequest, What};

/// What pictures of a mesh need.
const MESH_NEEDED: &str = "a mesh table is needed, a file that `atlas table list` shows";

/// What pictures of followed orbits need.
const FOLLOWED_NEEDED: &str = "there is no branches.parquet; `atlas follow` writes it";

/// What was given: a folder, which may be of several kinds at once, or a table file.
struct Source {
    results: Option<Results>,
    followed: Option<Followed>,
    recording: Option<Recording>,
    mesh: Option<MeshCurves>,
}

/// Draws what was asked for, or all that the data of a folder or of a table file allow.
///
/// # Errors
/// There is nothing to plot, a file cannot be read, or what was asked for is not there.
pub fn plot(path: &Path, request: &PlotRequest) -> Result<Drawn, PlotError> {
    let found = Source::read(path)?;
    let mut drawn = Drawn::default();
    if request.what.is_empty() {
        for &what in What::VARIANTS {
            match found.draw(what, request) {
                Ok(pictures) => drawn.append(pictures),
                Err(PlotError::Unfit { what, reason }) if found.can_hold(what) => {
                    drawn.notes.push(format!("{}: {reason}", what.name()));
                }
                Err(PlotError::Unfit { .. }) => {}
                Err(error) => return Err(error),
            }
        }
        return Ok(drawn);
    }
    for &what in &request.what {
        match found.draw(what, request) {
            Ok(pictures) => drawn.append(pictures),
            Err(PlotError::Unfit { what, reason }) => {
                return Err(PlotError::NotAvailable {
                    what,
                    path: path.to_path_buf(),
                    reason,
                    available: found.available(),
                });
            }
            Err(error) => return Err(error),
        }
    }
    Ok(drawn)
}

impl Source {
    fn read(path: &Path) -> Result<Self, PlotError> {
        if path.is_file() {
            return Ok(Self {
                results: None,
                followed: None,
                recording: None,
                mesh: Some(MeshCurves::read(path)?),
            });
        }
        let holds = |kind: TableKind| path.join(kind.file_name()).exists();
        // Where a record is, there were tables.
        let recorded = record_paths(path).is_ok_and(|records| !records.is_empty());
        let has_results = recorded || holds(TableKind::Points);
        let has_trace = holds(TableKind::Trace);
        let has_orbits = holds(TableKind::Branches);
        if !has_results && !has_trace && !has_orbits {
            return Err(PlotError::Nothing {
                folder: path.to_path_buf(),
            });
        }
        Ok(Self {
            results: has_results.then(|| Results::read(path)).transpose()?,
            followed: Followed::read(path)?,
            recording: has_trace.then(|| Recording::read(path)).transpose()?,
            mesh: None,
        })
    }

    fn draw(&self, what: What, request: &PlotRequest) -> Result<Drawn, PlotError> {
        let unfit = |reason: &str| PlotError::Unfit {
            what,
            reason: reason.into(),
        };
        if let Some(curves) = &self.mesh {
            return mesh::draw(what, curves);
        }
        if let What::Branches | What::Curves = what {
            let Some(followed) = &self.followed else {
                return Err(unfit(FOLLOWED_NEEDED));
            };
            return match what {
                What::Curves => curves::draw(followed, self.results.as_ref()),
                _ => Ok(branches::draw(followed, self.results.as_ref())),
            };
        }
        match (what, &self.results, &self.recording) {
            (What::Mesh | What::Sharing | What::Contact, _, _) => Err(unfit(MESH_NEEDED)),
            (What::Trace, _, Some(recording)) => Ok(trace::draw(recording)),
            (What::Phase, _, Some(recording)) => Ok(phase::of_trace(recording)),
            (What::Trace, _, None) => Err(unfit("a folder from `atlas trace` is needed")),
            (_, Some(results), _) => of_results(what, results, request),
            (_, None, _) => Err(unfit("a folder from `atlas run` is needed")),
        }
    }

    /// Whether this kind of picture belongs to this kind of folder or file.
    fn can_hold(&self, what: What) -> bool {
        match what {
            What::Trace => self.recording.is_some(),
            What::Mesh | What::Sharing | What::Contact => self.mesh.is_some(),
            _ if self.mesh.is_some() => false,
            What::Branches => self.followed.is_some(),
            What::Curves => (self.followed.as_ref()).is_some_and(|own| own.second.is_some()),
            What::Phase => self.results.is_some() || self.recording.is_some(),
            // Only where they were asked for: most results have neither.
            What::Shares => self.holds(TableKind::Attractors),
            What::Basins => self.holds(TableKind::Basins),
            What::Multipliers | What::Kicks => self.holds(TableKind::Orbits),
            // Few jobs ask for it: no word where none did.
            What::Horizon => (self.results.as_ref()).is_some_and(|results| {
                results.folder.join(TableKind::Horizon.file_name()).exists()
            }),
            _ => self.results.is_some(),
        }
    }

    /// Whether the results have a table.
    fn holds(&self, kind: TableKind) -> bool {
        let folder = self.results.as_ref().map(|results| &results.folder);
        folder.is_some_and(|folder| folder.join(kind.file_name()).exists())
    }

    /// Names of the pictures that the data allow.
    fn available(&self) -> String {
        let request = PlotRequest::default();
        let fitting =
            (What::VARIANTS.iter().copied()).filter(|&what| self.draw(what, &request).is_ok());
        let names: Vec<&str> = fitting.map(What::name).collect();
        match names.is_empty() {
            true => "none".into(),
            false => names.join(", "),
        }
    }
}

fn of_results(what: What, results: &Results, request: &PlotRequest) -> Result<Drawn, PlotError> {
    let unfit = |reason: &str| PlotError::Unfit {
        what,
        reason: reason.into(),
    };
    if results.summary.all.is_empty() {
        return Err(unfit("points.parquet holds no point"));
    }
    let over = request.over.as_deref();
    let cells = cells::Cells::new(results);
    match what {
        What::Lambda if results.summary.all.iter().all(|p| p.lambda.is_none()) => Err(unfit(
            "no point has an exponent; ask for `lyapunov` in the manifest's [analyses], with enough cycles",
        )),
        What::Lambda => match cells {
            Some(cells) if over.is_none() => Ok(lambda_map::draw(results, &cells)),
            _ => Ok(lambda_curve::draw(results, results.along(what, over)?)),
        },
        What::Classes => match cells {
            Some(cells) if over.is_none() => Ok(lambda_map::draw_classes(results, &cells)),
            _ => Ok(class_rows::draw(results, results.along(what, over)?)),
        },
        What::Bifurcation => bifurcation::draw(results, results.along(what, over)?),
        What::Shares => shares::draw(results, results.along(what, over)?),
        What::Basins => basins::draw(results, request),
        What::Multipliers => multipliers::draw(results, request),
        What::Kicks => kicks::draw(results, request),
        What::Spectrum => spectrum::draw(results, request),
        What::Horizon => horizon::draw(results, request),
        What::Phase => phase::of_results(results, request),
        What::Trace => Err(unfit("a folder from `atlas trace` is needed")),
        What::Mesh | What::Sharing | What::Contact => Err(unfit(MESH_NEEDED)),
        What::Branches | What::Curves => Err(unfit(FOLLOWED_NEEDED)),
    }
}

#[cfg(test)]
mod tests;
