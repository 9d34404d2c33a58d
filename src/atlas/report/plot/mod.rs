//! Pictures in SVG and PNG of a folder with results, a trace or a run-up, and of a mesh table, from files alone.
//!
//! Each kind of picture is first a list of shapes on a [`canvas`], and one module turns it into SVG or PNG. The same
//! files give the same bytes.

mod axis;
mod axis_units;
mod basins;
mod bifurcation;
mod branches;
mod campbell;
mod canvas;
mod categories;
mod cells;
mod class_rows;
mod clip;
mod column;
mod convergence;
mod curves;
mod display;
mod draw;
mod error;
mod evidence;
mod hatch;
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
mod picture_kind;
mod point_style;
mod ramp;
mod recording;
mod request;
mod results;
mod run_up;
mod section;
mod shares;
mod spectral;
mod spectrum;
mod trace;
mod waterfall;

use std::path::{Path, PathBuf};

use strum::VariantArray;

use crate::report::followed::Followed;
use crate::store::{ColumnHead, TableKind, record_paths};
use axis_units::AxisUnits;
use mesh::MeshCurves;
use recording::Recording;
use results::Results;

pub(super) use axis::PREFIXABLE;
pub(super) use basins::slice_axes;
pub use campbell::{Campbell, Contacts, ModeLine, NEAR_GRID, Ray, Resonance};
pub(super) use categories::colour as category_colour;
pub use column::{ColumnName, NoColumn, PictureRequest};
pub(crate) use display::Unit;
pub use display::{Amount, Display, Log, NoAmount};
pub use error::PlotError;
pub use machine::pictures as machine_pictures;
pub(super) use marker::{colour as kind_colour, name as kind_name};
pub(super) use motion::Motion;
pub use picture::{Drawn, Picture};
pub use picture_kind::PictureKind;
pub(super) use ramp::VIRIDIS;
pub use request::{DEFAULT_ORDERS, PlotRequest};

/// Message if a picture of a mesh is requested from something else.
const MESH_NEEDED: &str =
    "this picture needs a mesh table, a file that `atlas table MANIFEST` writes";

/// Message if a Campbell diagram is requested from results.
const CAMPBELL_APART: &str = "results contain no natural frequencies; `atlas plot m.toml --what campbell` computes \
                              them from a manifest";

/// Message if a picture of followed orbits is requested, but there are none.
const FOLLOWED_NEEDED: &str = "there is no branches.parquet; `atlas follow` writes it";

/// A source of pictures: a folder, which may have several kinds of contents at once, or a table file.
struct Source {
    results: Option<Results>,
    /// Followed orbits, and the units of their axes.
    followed: Option<(Followed, AxisUnits)>,
    recording: Option<Recording>,
    mesh: Option<MeshCurves>,
    /// A folder that `atlas runup` wrote.
    run_up: Option<PathBuf>,
}

/// Draws the requested pictures, or all that the data of a folder or of a table file allow. Columns of several folders
/// go into one picture.
///
/// # Errors
/// There is nothing to plot, a file cannot be read, or a requested item does not exist.
pub fn plot(paths: &[PathBuf], request: &PlotRequest) -> Result<Drawn, PlotError> {
    let mut drawn = drawn(paths, request)?;
    drawn.say_what_was_thinned();
    Ok(drawn)
}

fn drawn(paths: &[PathBuf], request: &PlotRequest) -> Result<Drawn, PlotError> {
    let request = &column::completed(request)?;
    let mut drawn = Drawn::default();
    let (mut columns, mut kinds) = (Vec::new(), Vec::new());
    for requested in &request.what {
        match requested {
            PictureRequest::Kind(what) => kinds.push(*what),
            PictureRequest::Column(column) => columns.push(column.clone()),
        }
    }
    let cut = kinds.contains(&PictureKind::Orders);
    kinds.retain(|what| *what != PictureKind::Orders);
    if let (Some(&what), [_, _, ..]) = (kinds.first(), paths) {
        return Err(PlotError::OneFolder { what });
    }
    let mut all = Vec::new();
    for path in paths {
        all.push(Source::read(path, &request.display.units)?);
    }
    if request.what.is_empty() {
        for found in &all {
            drawn.append(found.draw_all(request)?);
        }
        return Ok(drawn);
    }
    if let ([path], [found]) = (paths, &all[..]) {
        for what in kinds {
            drawn.append(found.draw_one(what, path, request)?);
        }
    }
    if columns.is_empty() && !cut {
        return Ok(drawn);
    }
    let results: Result<Vec<&Results>, PlotError> = (paths.iter().zip(&all))
        .map(|(path, found)| found.results_with_points(path, &columns))
        .collect();
    let sources = column::named(&results?);
    drawn.append(column::draw(&sources, &columns, request)?);
    if cut {
        drawn.append(column::draw_orders(&sources, request)?);
    }
    Ok(drawn)
}

/// Possible pictures of a results folder.
#[derive(Debug, Clone, PartialEq)]
pub struct Drawable {
    /// Kinds of pictures.
    pub kinds: Vec<PictureKind>,
    /// Every column, by its name in requests.
    pub columns: Vec<ColumnHead>,
}

/// Lists the possible pictures of a results folder.
///
/// # Errors
/// The folder cannot be read.
pub fn drawable(path: &Path) -> Result<Drawable, PlotError> {
    let found = Source::read(path, &[])?;
    Ok(Drawable {
        kinds: found.available(),
        columns: match &found.results {
            Some(results) => column::listed(results)?,
            None => Vec::new(),
        },
    })
}

impl Source {
    fn read(path: &Path, units: &[String]) -> Result<Self, PlotError> {
        if path.is_file() {
            return Ok(Self {
                results: None,
                followed: None,
                recording: None,
                mesh: Some(MeshCurves::read(path)?),
                run_up: None,
            });
        }
        let holds = |kind: TableKind| path.join(kind.file_name()).exists();
        // A record of a run proves that there were tables. If they are lost, reading them gives the error.
        let recorded = record_paths(path).is_ok_and(|records| !records.is_empty());
        let has_results = recorded || holds(TableKind::Points);
        let has_trace = holds(TableKind::Trace);
        let has_orbits = holds(TableKind::Branches);
        let run_up = holds(TableKind::Signals).then(|| path.to_path_buf());
        if !has_results && !has_trace && !has_orbits && run_up.is_none() {
            return Err(PlotError::Nothing {
                folder: path.to_path_buf(),
            });
        }
        let results = has_results.then(|| Results::read(path, units));
        let followed = Followed::read(path)?.map(|followed| {
            let shown = AxisUnits::new(&followed.axes, &followed.units, units);
            (followed, shown)
        });
        Ok(Self {
            results: results.transpose()?,
            followed,
            recording: has_trace.then(|| Recording::read(path)).transpose()?,
            mesh: None,
            run_up,
        })
    }

    /// Draws all that the data allow, and notes what was left out.
    fn draw_all(&self, request: &PlotRequest) -> Result<Drawn, PlotError> {
        let mut drawn = Drawn::default();
        let usual = |what: &&PictureKind| match what {
            PictureKind::Orders | PictureKind::Campbell => false,
            PictureKind::Waterfall => {
                let varies = |results: &Results| !results.varied().is_empty();
                self.holds(TableKind::Spectra) && self.results.as_ref().is_some_and(varies)
            }
            _ => true,
        };
        for &what in PictureKind::VARIANTS.iter().filter(usual) {
            match self.draw(what, request) {
                Ok(pictures) => drawn.append(pictures),
                Err(PlotError::Unfit { what, reason }) if self.can_hold(what) => {
                    drawn.notes.push(format!("{}: {reason}", what.name()));
                }
                Err(PlotError::Unfit { .. }) => {}
                Err(error) => return Err(error),
            }
        }
        if let Some(results) = &self.results {
            drawn.append(column::draw_deflection_rms(results, request)?);
        }
        Ok(drawn)
    }

    /// Draws a requested kind.
    fn draw_one(
        &self,
        what: PictureKind,
        path: &Path,
        request: &PlotRequest,
    ) -> Result<Drawn, PlotError> {
        self.draw(what, request).map_err(|error| match error {
            PlotError::Unfit { what, reason } => {
                let names: Vec<&str> = self
                    .available()
                    .into_iter()
                    .map(PictureKind::name)
                    .collect();
                PlotError::NotAvailable {
                    what,
                    path: path.to_path_buf(),
                    reason,
                    available: if names.is_empty() { "none".into() } else { names.join(", ") },
                }
            }
            error => error,
        })
    }

    /// The results, which must have points. The error suggests a kind of picture if a name in `columns` resembles it.
    fn results_with_points(
        &self,
        path: &Path,
        columns: &[ColumnName],
    ) -> Result<&Results, PlotError> {
        let results = self.results.as_ref();
        (results.filter(|results| !results.summary.all.is_empty())).ok_or_else(|| {
            let folder = path.to_path_buf();
            let kinds: Vec<String> = PictureKind::names().collect();
            let misspelt = columns.iter().find_map(|column| {
                let name = column.to_string();
                let nearest = column::nearest(&name, &kinds);
                (!nearest.is_empty()).then_some((name, nearest))
            });
            match misspelt {
                Some((name, nearest)) => PlotError::UnknownColumn {
                    name,
                    is_text: false,
                    nearest,
                    folder,
                },
                None => PlotError::NoColumns { folder },
            }
        })
    }

    fn draw(&self, what: PictureKind, request: &PlotRequest) -> Result<Drawn, PlotError> {
        if let Some(curves) = &self.mesh {
            return mesh::draw(what, curves);
        }
        if let PictureKind::Spectrogram | PictureKind::Tracks = what {
            let folder = self.run_up.as_ref();
            let folder =
                folder.ok_or_else(|| what.unfit("give a folder that `atlas runup` wrote"))?;
            return run_up::draw(folder, what, request);
        }
        if let PictureKind::Branches | PictureKind::Curves = what {
            let Some((followed, shown)) = &self.followed else {
                return Err(what.unfit(FOLLOWED_NEEDED));
            };
            return match what {
                PictureKind::Curves => curves::draw(followed, shown, self.results.as_ref()),
                _ => Ok(branches::draw(followed, shown, self.results.as_ref())),
            };
        }
        match (what, &self.results, &self.recording) {
            (PictureKind::Mesh | PictureKind::Sharing | PictureKind::Contact, _, _) => {
                Err(what.unfit(MESH_NEEDED))
            }
            (PictureKind::Trace, _, Some(recording)) => Ok(trace::draw(recording)),
            (PictureKind::Phase, _, Some(recording)) => Ok(phase::of_trace(recording)),
            (PictureKind::Trace, _, None) => {
                Err(what.unfit("give a folder that `atlas trace` wrote"))
            }
            (_, Some(results), _) => of_results(what, results, request),
            (_, None, _) => Err(what.unfit("give a folder that `atlas run` wrote")),
        }
    }

    /// Whether this source has the tables that this kind of picture needs.
    fn can_hold(&self, what: PictureKind) -> bool {
        match what {
            PictureKind::Trace => self.recording.is_some(),
            PictureKind::Spectrogram | PictureKind::Tracks => self.run_up.is_some(),
            PictureKind::Mesh | PictureKind::Sharing | PictureKind::Contact => self.mesh.is_some(),
            _ if self.mesh.is_some() => false,
            PictureKind::Branches => self.followed.is_some(),
            PictureKind::Curves => {
                (self.followed.as_ref()).is_some_and(|(followed, _)| followed.second.is_some())
            }
            PictureKind::Phase => self.results.is_some() || self.recording.is_some(),
            // These pictures need a table that exists only if the job requested it.
            PictureKind::Shares => self.holds(TableKind::Attractors),
            PictureKind::Basins => self.holds(TableKind::Basins),
            PictureKind::Multipliers | PictureKind::Kicks => self.holds(TableKind::Orbits),
            PictureKind::Convergence => {
                (self.results.as_ref()).is_some_and(convergence::has_history)
            }
            // Few jobs request a horizon. Without its table, no note says that the picture is left out.
            PictureKind::Horizon => (self.results.as_ref()).is_some_and(|results| {
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

    /// The pictures that the data allow.
    fn available(&self) -> Vec<PictureKind> {
        let request = PlotRequest::default();
        let all = PictureKind::VARIANTS.iter().copied();
        all.filter(|&what| self.draw(what, &request).is_ok())
            .collect()
    }
}

fn of_results(
    what: PictureKind,
    results: &Results,
    request: &PlotRequest,
) -> Result<Drawn, PlotError> {
    if results.summary.all.is_empty() {
        return Err(what.unfit("points.parquet has no points"));
    }
    let over = request.over.as_deref();
    let cells = cells::Cells::new(results);
    match what {
        PictureKind::Lambda if results.summary.all.iter().all(|p| p.lambda.is_none()) => Err(what.unfit(
            "no point has an exponent; add `lyapunov = {}` to [analyses] of the manifest, with enough cycles",
        )),
        PictureKind::Lambda => match cells {
            Some(cells) if over.is_none() => Ok(lambda_map::draw(results, &cells)),
            _ => Ok(lambda_curve::draw(results, results.along(what, over)?)),
        },
        PictureKind::Classes => match cells {
            Some(cells) if over.is_none() => Ok(lambda_map::draw_classes(results, &cells)),
            _ => Ok(class_rows::draw(results, results.along(what, over)?)),
        },
        PictureKind::Bifurcation => bifurcation::draw(results, results.along(what, over)?),
        PictureKind::Shares => shares::draw(results, results.along(what, over)?),
        PictureKind::Basins => basins::draw(results, request),
        PictureKind::Multipliers => multipliers::draw(results, request),
        PictureKind::Kicks => kicks::draw(results, request),
        PictureKind::Spectrum => spectrum::draw(results, request),
        PictureKind::Waterfall => waterfall::draw(results, request),
        PictureKind::Campbell => Err(what.unfit(CAMPBELL_APART)),
        PictureKind::Orders => column::draw_orders(&column::named(&[results]), request),
        PictureKind::Horizon => horizon::draw(results, request),
        PictureKind::Convergence => convergence::draw(results, request),
        PictureKind::Phase => phase::of_results(results, request),
        PictureKind::Trace => Err(what.unfit("give a folder that `atlas trace` wrote")),
        PictureKind::Spectrogram | PictureKind::Tracks => Err(what.unfit("give a folder that `atlas runup` wrote")),
        PictureKind::Mesh | PictureKind::Sharing | PictureKind::Contact => Err(what.unfit(MESH_NEEDED)),
        PictureKind::Branches | PictureKind::Curves => Err(what.unfit(FOLLOWED_NEEDED)),
    }
}

#[cfg(test)]
mod tests;
