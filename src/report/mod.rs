//! Summaries and figures from result files and tables; knows nothing of how results came to be.

mod branches;
mod coexistence;
mod error;
mod followed;
mod heat;
mod machine_page;
mod numbers;
mod operator_summary;
mod plot;
mod point;
mod summary;
mod table_summary;
mod text;
mod transitions;

pub use branches::{Attractor, branches, read_attractors};
pub use coexistence::{Coexistence, Ending};
pub use error::ReportError;
pub use followed::{Explained, Explaining, Explanation, FollowedSummary};
pub use machine_page::machine_page;
pub use numbers::{size_text, to_digits};
pub use operator_summary::OperatorSummary;
pub use plot::{Drawn, Picture, PlotError, PlotRequest, What, machine_pictures, plot};
pub use point::{Axis, ClassCount, PointSummary};
pub use summary::Summary;
pub use table_summary::{ArraySummary, TableSummary};
pub use text::{Style, render, render_branches};
pub use transitions::TransitionSummary;
