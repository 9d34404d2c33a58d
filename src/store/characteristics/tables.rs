//! The columns of every measurement's file.

use super::rows::{
    ArithmeticRow, BandwidthRow, Figure, LatencyRow, MountainRow, OperatorRow, RoofRow, SolverRow,
};
use crate::store::table::{Column, Table, columns};

/// The columns of a measurement: what was measured, then its figure.
fn table<R: 'static>(
    keys: Vec<Column<R>>,
    [name, unit, description]: [&str; 3],
    get: fn(&R) -> &Figure,
) -> Table<R> {
    let named = |part: &str| format!("{name}_{part}");
    let of = |what: &str| format!("{what} ({description})");
    let figure = columns![row: R;
        f64 name, unit, get(row).value, &of("Median over rounds of the best repetition of each");
        f64 &named("best"), unit, get(row).best, &of("Best repetition");
        f64 &named("median"), unit, get(row).median, &of("Median repetition");
        f64 &named("spread"), "1", get(row).spread,
            "Part of the value within which another run's lies with 95 %";
        u64 "rounds", "1", get(row).rounds, "Rounds";
        u64 "repetitions", "1", get(row).repetitions, "Repetitions of all rounds";
    ];
    Table::new(keys.into_iter().chain(figure).collect())
}

/// `mountain.parquet`.
pub fn mountain() -> Table<MountainRow> {
    let keys = columns![row: MountainRow;
        u64 "size", "B", row.size, "Size of the buffer";
        u64 "stride", "B", row.stride, "From line to line";
    ];
    table(keys, ["bandwidth", "B/s", "bytes read a second"], |row| {
        &row.bandwidth
    })
}

/// `operators.parquet`.
pub fn operators() -> Table<OperatorRow> {
    let keys = columns![row: OperatorRow;
        text "kernel", "", row.kernel.as_str(), "matvec, volterra or spectral";
        u64 "dimension", "1", row.dimension, "Rows of the dense operator";
        u64 "count", "1", row.count, "Tables in rotation";
        u64 "working_set", "B", row.working_set, "Bytes of all of them";
    ];
    table(keys, ["time", "s", "time of a product or window"], |row| {
        &row.time
    })
}

/// `bandwidth.parquet`.
pub fn bandwidth() -> Table<BandwidthRow> {
    let keys = columns![row: BandwidthRow;
        text "kernel", "", row.kernel.as_str(), "What was run";
        text "placement", "", row.placement.as_str(), "compact, scattered or nodes";
        u64 "threads", "1", row.threads, "Threads";
        u32 "cpu_node", "1", row.cpu_node, "Node of the threads";
        u32 "memory_node", "1", row.memory_node, "Node of the memory";
        u64 "array", "B", row.array, "Size of each array";
        u64 "bytes", "B", row.bytes, "Bytes read and written a repetition";
    ];
    table(keys, ["bandwidth", "B/s", "bytes a second"], |row| {
        &row.bandwidth
    })
}

/// `latency.parquet`.
pub fn latency() -> Table<LatencyRow> {
    let keys = columns![row: LatencyRow;
        u64 "size", "B", row.size, "Size of the buffer";
        text "order", "", row.order.as_str(), "pages or hops";
        bool "huge_pages", "", row.huge_pages, "Whether they were asked for";
        u32 "cpu_node", "1", row.cpu_node, "Node of the thread";
        u32 "memory_node", "1", row.memory_node, "Node of the memory";
    ];
    table(keys, ["latency", "s", "time of a load"], |row| &row.latency)
}

/// `arithmetic.parquet`.
pub fn arithmetic() -> Table<ArithmeticRow> {
    let keys = columns![row: ArithmeticRow;
        text "isa", "", row.isa.as_str(), "Instruction set";
        u64 "threads", "1", row.threads, "Threads";
    ];
    table(keys, ["rate", "1/s", "operations a second"], |row| {
        &row.rate
    })
}

/// `solver.parquet`.
pub fn solver() -> Table<SolverRow> {
    let keys = columns![row: SolverRow;
        text "kernel", "", row.kernel.as_str(), "What was run";
        text "tables", "", row.tables.as_str(), "shared, node or eight";
        u64 "modes", "1", row.modes, "Modes";
        u64 "threads", "1", row.threads, "Threads";
        u64 "table_bytes", "B", row.table_bytes, "Bytes of one table";
        f64 "efficiency", "1", row.efficiency, "Rate over that of one thread times the threads";
    ];
    table(
        keys,
        ["rate", "1/s", "mesh cycles a second, all threads"],
        |row| &row.rate,
    )
}

/// `roofline.parquet`.
pub fn roofline() -> Table<RoofRow> {
    Table::new(columns![row: RoofRow;
        text "kernel", "", row.kernel.as_str(), "What was run";
        u64 "modes", "1", row.modes, "Modes";
        f64 "operations", "1", row.operations, "Operations of a mesh cycle";
        f64 "bytes_read", "B", row.bytes_read, "Bytes of tables read a cycle";
        f64 "bytes_distinct", "B", row.bytes_distinct, "Different bytes of tables read a cycle";
        f64 "intensity", "1/B", row.intensity, "Operations over different bytes";
        f64 "rate", "1/s", row.rate, "Operations a second";
    ])
}
