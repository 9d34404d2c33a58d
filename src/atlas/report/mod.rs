//! Summaries and pictures from result files and tables. This module computes no motion.

mod branches;
mod coexistence;
mod error;
mod followed;
mod heat;
mod lifetimes;
mod machine_page;
mod numbers;
mod orbits;
mod page;
mod plot;
mod point;
mod rattle;
mod refined;
mod summary;
mod table_summary;
mod text;
mod tied;
mod transitions;

pub use branches::{Attractor, branches, read_attractors};
pub use coexistence::{Coexistence, Ending};
pub use error::ReportError;
pub use followed::FollowedSummary;
pub use lifetimes::{LifetimeRange, Lifetimes};
pub use machine_page::machine_page;
pub use numbers::{size_text, to_digits};
pub use orbits::{MissedSearch, Orbit, OrbitCount, Orbits};
pub use page::{PageRequest, ResultsPage, results_page};
pub(crate) use plot::Unit;
pub use plot::{
    Amount, Campbell, ColumnName, Contacts, DEFAULT_ORDERS, Display, Drawable, Drawn, Log,
    ModeLine, NEAR_GRID, NoAmount, NoColumn, Picture, PictureKind, PictureRequest, PlotError,
    PlotRequest, Ray, Resonance, drawable, machine_pictures, plot,
};
pub use point::{Axis, ChaosLife, ClassCount, PointSummary, Verdict};
pub use rattle::Rattle;
pub use summary::Summary;
pub use table_summary::{QuantitySummary, TableSummary};
pub use text::{Style, counted, render, render_branches};
pub use transitions::TransitionSummary;
