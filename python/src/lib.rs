//! The compiled half of the Python package `gearatlas`. It calls the library and converts its results for Python. The
//! lock of the interpreter is released during computations and reading.

mod attended;
mod cycle_map;
mod errors;
mod followed;
mod manifest;
mod measured;
mod point;
mod results;
mod run;
mod sensitivity;
mod structure;
mod table;
mod toml_values;
mod trace;

/// Functions for the package `gearatlas`; not for direct use.
#[pyo3::pymodule]
mod _gearatlas {
    #[pymodule_export]
    use crate::cycle_map::CycleMap;
    #[pymodule_export]
    use crate::followed::follow;
    #[pymodule_export]
    use crate::manifest::Manifest;
    #[pymodule_export]
    use crate::measured::{conversion, read_measured};
    #[pymodule_export]
    use crate::point::Point;
    #[pymodule_export]
    use crate::results::{present_tables, read_runs, read_table};
    #[pymodule_export]
    use crate::run::run;
    #[pymodule_export]
    use crate::sensitivity::sensitivity;
    #[pymodule_export]
    use crate::structure::structure;
    #[pymodule_export]
    use crate::table::Table;
    #[pymodule_export]
    use crate::trace::trace;

    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        gearatlas::sweep::silence_reported_panics();
        gearatlas::store::ProgramRecord::set_commit(gearatlas::COMMIT);
        let program = gearatlas::store::ProgramRecord::current();
        module.add("__version__", program.version)?;
        module.add("COMMIT", program.commit)
    }
}
