//! The keys of the table `[job]`.

use crate::manifest::schema::key::{ANY, Key, Kind, integer, key, table};

#[rustfmt::skip]
pub(super) const KEYS: &[Key] = &[
    table("job")
        .about("Name of the job and seed of its random numbers."),
    key("job.name", Kind::Text, ANY, r#""flex80""#)
        .about("Name of the job. Results go to the folder results/NAME unless `atlas run --out` gives another. Up to \
                100 letters, digits, `-`, `_` or `.`; the first must not be `-` or `.`."),
    integer("job.seed", 0.0, 9.2e18, "7").or("1")
        .about("Seed of every random stream. The same seed gives the same bits. Another seed gives other tangent \
                vectors, twins and probes, and so another sample of every estimate."),
];
