//! Summaries and figures from result files; knows nothing of how results came to be.

mod coexistence;
mod heat;
mod plot;
mod summary;
mod text;
mod transitions;

pub use coexistence::{Coexistence, Ending};
pub use plot::{Drawn, Picture, PlotError, PlotRequest, What, plot};
pub use summary::{Axis, ClassCount, PointSummary, ReportError, Summary};
pub use text::{Style, render};
pub use transitions::TransitionSummary;
