//! `[job]`.

use crate::manifest::schema::key::{ANY, Key, Kind, integer, key, table};

#[rustfmt::skip]
pub(super) const KEYS: &[Key] = &[
    table("job")
        .about("Name of the job and root of its random numbers."),
    key("job.name", Kind::Text, ANY, r#""flex80""#)
        .about("Name of the job. Results go to the folder results/NAME unless `atlas run --out` says \
                otherwise: up to 100 letters, digits, `-`, `_` or `.`, the first no `-` or `.`."),
    integer("job.seed", 0.0, 9.2e18, "7").or("1")
        .about("Root of every random stream. The same seed gives the same bits; another one gives \
                other tangents, twins and probes, and with them another draw of every estimate."),
];
