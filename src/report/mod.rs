//! Summaries and figures from result files and tables; knows nothing of how results came to be.

mod branches;
mod coexistence;
mod heat;
mod machine_page;
mod operator_summary;
mod plot;
mod summary;
mod table_summary;
mod text;
mod transitions;

pub use branches::{Attractor, branches, read_attractors, render_branches};
pub use coexistence::{Coexistence, Ending};
pub use machine_page::machine_page;
pub use operator_summary::OperatorSummary;
pub use plot::{Drawn, Picture, PlotError, PlotRequest, What, machine_pictures, plot};
pub use summary::{Axis, ClassCount, PointSummary, ReportError, Summary};
pub use table_summary::{ArraySummary, TableSummary, size_text};
pub use text::{Style, render, to_digits};
pub use transitions::TransitionSummary;
