//! The columns of every measurement's file.

use super::rows::{
    ArithmeticRow, BandwidthRow, Figure, LatencyRow, MountainRow, OperatorRow, RoofRow, SolverRow,
};
use crate::store::table::{Column, Table, Value};

fn count<R>(name: &str, unit: &str, description: &str, get: fn(&R) -> u64) -> Column<R>
where
    R: 'static,
{
    let value = Value::U64(Box::new(move |row: &R| Some(get(row))));
    Column::new(name, unit, description, value)
}

fn node<R: 'static>(name: &str, description: &str, get: fn(&R) -> Option<u32>) -> Column<R> {
    Column::new(name, "1", description, Value::U32(Box::new(get)))
}

fn number<R: 'static>(
    name: &str,
    unit: &str,
    description: &str,
    get: fn(&R) -> Option<f64>,
) -> Column<R> {
    Column::new(name, unit, description, Value::F64(Box::new(get)))
}

fn text<R: 'static>(name: &str, description: &str, get: fn(&R) -> &str) -> Column<R> {
    let value = Value::Text(Box::new(move |row: &R| Some(get(row))));
    Column::new(name, "", description, value)
}

/// The columns of a figure.
fn figure<R: 'static>(
    name: &str,
    unit: &str,
    description: &str,
    get: fn(&R) -> &Figure,
) -> Vec<Column<R>> {
    let column = |suffix: &str, unit: &str, what: &str, part: fn(&Figure) -> Option<f64>| {
        let value = Value::F64(Box::new(move |row: &R| part(get(row))));
        Column::new(&format!("{name}{suffix}"), unit, what, value)
    };
    let of = |what: &str| format!("{what} ({description})");
    let counted = |name: &str, what: &str, part: fn(&Figure) -> u64| {
        let value = Value::U64(Box::new(move |row: &R| Some(part(get(row)))));
        Column::new(name, "1", what, value)
    };
    vec![
        column(
            "",
            unit,
            &of("Median over rounds of the best repetition of each"),
            |f| Some(f.value),
        ),
        column("_best", unit, &of("Best repetition"), |f| Some(f.best)),
        column("_median", unit, &of("Median repetition"), |f| {
            Some(f.median)
        }),
        column(
            "_spread",
            "1",
            "Part of the value within which another run's lies with 95 %",
            |f| f.spread,
        ),
        counted("rounds", "Rounds", |f| f.rounds),
        counted("repetitions", "Repetitions of all rounds", |f| {
            f.repetitions
        }),
    ]
}

fn table<R>(keys: Vec<Column<R>>, figure: Vec<Column<R>>) -> Table<R> {
    Table::new(keys.into_iter().chain(figure).collect())
}

const KERNEL: &str = "What was run";
const THREADS: &str = "Threads";

/// `mountain.parquet`.
pub fn mountain() -> Table<MountainRow> {
    table(
        vec![
            count("size", "B", "Size of the buffer", |r: &MountainRow| r.size),
            count("stride", "B", "From line to line", |r| r.stride),
        ],
        figure("bandwidth", "B/s", "bytes read a second", |r| &r.bandwidth),
    )
}

/// `operators.parquet`.
pub fn operators() -> Table<OperatorRow> {
    table(
        vec![
            text(
                "kernel",
                "matvec, volterra or spectral",
                |r: &OperatorRow| &r.kernel,
            ),
            count("dimension", "1", "Rows of the dense operator", |r| {
                r.dimension
            }),
            count("count", "1", "Tables in rotation", |r| r.count),
            count("working_set", "B", "Bytes of all of them", |r| {
                r.working_set
            }),
        ],
        figure("time", "s", "time of a product or window", |r| &r.time),
    )
}

/// `bandwidth.parquet`.
pub fn bandwidth() -> Table<BandwidthRow> {
    table(
        vec![
            text("kernel", KERNEL, |r: &BandwidthRow| &r.kernel),
            text("placement", "compact, scattered or nodes", |r| &r.placement),
            count("threads", "1", THREADS, |r| r.threads),
            node("cpu_node", "Node of the threads", |r| r.cpu_node),
            node("memory_node", "Node of the memory", |r| r.memory_node),
            count("array", "B", "Size of each array", |r| r.array),
            count("bytes", "B", "Bytes read and written a repetition", |r| {
                r.bytes
            }),
        ],
        figure("bandwidth", "B/s", "bytes a second", |r| &r.bandwidth),
    )
}

/// `latency.parquet`.
pub fn latency() -> Table<LatencyRow> {
    let huge = Value::Bool(Box::new(|row: &LatencyRow| Some(row.huge_pages)));
    table(
        vec![
            count("size", "B", "Size of the buffer", |r: &LatencyRow| r.size),
            text("order", "pages or hops", |r| &r.order),
            Column::new("huge_pages", "", "Whether they were asked for", huge),
            node("cpu_node", "Node of the thread", |r| Some(r.cpu_node)),
            node("memory_node", "Node of the memory", |r| Some(r.memory_node)),
        ],
        figure("latency", "s", "time of a load", |r| &r.latency),
    )
}

/// `arithmetic.parquet`.
pub fn arithmetic() -> Table<ArithmeticRow> {
    table(
        vec![
            text("isa", "Instruction set", |r: &ArithmeticRow| &r.isa),
            count("threads", "1", THREADS, |r| r.threads),
        ],
        figure("rate", "1/s", "operations a second", |r| &r.rate),
    )
}

/// `solver.parquet`.
pub fn solver() -> Table<SolverRow> {
    let mut columns = vec![
        text("kernel", KERNEL, |r: &SolverRow| &r.kernel),
        text("tables", "shared, node or eight", |r| &r.tables),
        count("modes", "1", "Modes", |r| r.modes),
        count("threads", "1", THREADS, |r| r.threads),
        count("table_bytes", "B", "Bytes of one table", |r| r.table_bytes),
    ];
    columns.push(number(
        "efficiency",
        "1",
        "Rate over that of one thread times the threads",
        |r| r.efficiency,
    ));
    let cycles = "mesh cycles a second, all threads";
    let rate = figure("rate", "1/s", cycles, |r: &SolverRow| &r.rate);
    table(columns, rate)
}

/// `roofline.parquet`.
pub fn roofline() -> Table<RoofRow> {
    Table::new(vec![
        text("kernel", KERNEL, |r: &RoofRow| &r.kernel),
        count("modes", "1", "Modes", |r| r.modes),
        number("operations", "1", "Operations of a mesh cycle", |r| {
            Some(r.operations)
        }),
        number("bytes_read", "B", "Bytes of tables read a cycle", |r| {
            Some(r.bytes_read)
        }),
        number(
            "bytes_distinct",
            "B",
            "Different bytes of tables read a cycle",
            |r| Some(r.bytes_distinct),
        ),
        number("intensity", "1/B", "Operations over different bytes", |r| {
            Some(r.intensity)
        }),
        number("rate", "1/s", "Operations a second", |r| Some(r.rate)),
    ])
}
