//! Which tables does a job write, and with which columns?

use super::file::Shard;
use super::nvh::ListElement;
use super::point_row::AxisColumn;
use super::refined::RefinedColumns;
use super::samples::SampleColumns;
use super::table_kind::TableKind;

/// The tables and columns of a job.
#[derive(Debug, Clone, Default)]
pub struct ResultLayout {
    /// The grid's axes, slowest first.
    pub axes: Vec<AxisColumn>,
    /// Names of tied axes, whose values change together, group by group.
    pub tied: Vec<Vec<String>>,
    /// The tables that the analyses of the job request.
    pub requested: Vec<TableKind>,
    /// The axis along which the state is carried, if any; `transitions.parquet` is written then.
    pub swept: Option<AxisColumn>,
    /// The axes of the slices in `basins.parquet`; `None` if it is not written.
    pub basin_axes: Option<[AxisColumn; 2]>,
    /// How the grid is refined; `None` for a full grid.
    pub refined: Option<RefinedColumns>,
    /// How values of axes were drawn; `None` without distributions.
    pub samples: Option<SampleColumns>,
    /// Names of the elements of lists, in order, for lists with the same names in all structures of the job.
    pub elements: Vec<(ListElement, Vec<String>)>,
    /// The part of a split job; `None` for the whole job.
    pub shard: Option<Shard>,
}
