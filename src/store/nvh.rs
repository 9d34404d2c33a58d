//! The NVH columns of `points.parquet`: every statistic and its standard error.

use super::PointRow;
use super::table::{Column, Value};
use crate::analysis::{NvhErrors, NvhOutcome};

type Number = fn(&NvhOutcome) -> Option<f64>;
type Numbers = fn(&NvhOutcome) -> &[f64];
type ErrorNumber = fn(&NvhErrors) -> f64;
type ErrorNumbers = fn(&NvhErrors) -> &[f64];

/// The columns, in file order.
pub(super) fn nvh_columns() -> Vec<Column<PointRow>> {
    [
        fraction_columns(),
        deflection_columns(),
        force_columns(),
        impact_columns(),
        duration_columns(),
        bearing_columns(),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// What extremes say of themselves: they have no standard error.
const SEEN: &str = "largest seen: of a motion that does not repeat it grows with the record";

fn number(name: &str, unit: &str, description: &str, get: Number) -> Column<PointRow> {
    let value = move |row: &PointRow| row.outcome.nvh.as_ref().and_then(get);
    Column::new(name, unit, description, Value::F64(Box::new(value)))
}

fn count(name: &str, description: &str, get: fn(&NvhOutcome) -> u64) -> Column<PointRow> {
    let value = move |row: &PointRow| row.outcome.nvh.as_ref().map(get);
    Column::new(name, "1", description, Value::U64(Box::new(value)))
}

/// A statistic and, in the column after it, its standard error.
fn known(
    name: &str,
    unit: &str,
    description: &str,
    get: Number,
    error: ErrorNumber,
) -> [Column<PointRow>; 2] {
    let stderr = move |row: &PointRow| {
        let errors = row.outcome.nvh.as_ref()?.stderr.as_ref()?;
        // Infinite where too little was seen for an error bar.
        Some(error(errors)).filter(|error| !error.is_infinite())
    };
    [
        number(name, unit, description, get),
        Column::new(
            &format!("{name}_stderr"),
            unit,
            &error_words(name),
            Value::F64(Box::new(stderr)),
        ),
    ]
}

/// A list of statistics and, in the column after it, their standard errors.
fn known_list(
    name: &str,
    unit: &str,
    description: &str,
    get: Numbers,
    error: ErrorNumbers,
) -> [Column<PointRow>; 2] {
    // Empty where the statistic does not exist.
    let values = Value::List(Box::new(move |row: &PointRow| {
        let values = row.outcome.nvh.as_ref().map(get);
        values.filter(|list| !list.is_empty())
    }));
    let stderr = Value::List(Box::new(move |row: &PointRow| {
        let errors = error(row.outcome.nvh.as_ref()?.stderr.as_ref()?);
        let finite = errors.iter().all(|error| !error.is_infinite());
        (finite && !errors.is_empty()).then_some(errors)
    }));
    [
        Column::new(name, unit, description, values),
        Column::new(&format!("{name}_stderr"), unit, &error_words(name), stderr),
    ]
}

fn error_words(name: &str) -> String {
    format!("Standard error of {name}; null where the motion repeats and its value is exact")
}

fn fraction_columns() -> Vec<Column<PointRow>> {
    [
        known(
            "fraction_drive",
            "1",
            "Fraction of time in contact on the drive flank",
            |found| Some(found.fractions[0]),
            |error| error.fractions[0],
        ),
        known(
            "fraction_free",
            "1",
            "Fraction of time out of contact",
            |found| Some(found.fractions[1]),
            |error| error.fractions[1],
        ),
        known(
            "fraction_coast",
            "1",
            "Fraction of time in contact on the coast flank",
            |found| Some(found.fractions[2]),
            |error| error.fractions[2],
        ),
    ]
    .into_iter()
    .flatten()
    .collect()
}

fn deflection_columns() -> Vec<Column<PointRow>> {
    let mut columns = Vec::new();
    columns.extend(known(
        "dte_mean",
        "m",
        "Mean dynamic transmission error (mesh deflection)",
        |found| Some(found.dte_mean),
        |error| error.dte_mean,
    ));
    columns.extend(known(
        "dte_rms",
        "m",
        "Root mean square of the deflection about its mean",
        |found| Some(found.dte_rms),
        |error| error.dte_rms,
    ));
    columns.push(number(
        "dte_pp",
        "m",
        &format!("Largest minus smallest deflection; {SEEN}"),
        |found| Some(found.dte_pp),
    ));
    columns.push(number(
        "dte_crest",
        "1",
        &format!("Largest |deflection - mean| over dte_rms; {SEEN}"),
        |found| Some(found.dte_crest),
    ));
    columns.extend(known(
        "dte_kurtosis",
        "1",
        "Fourth central moment over squared variance",
        |found| Some(found.dte_kurtosis),
        |error| error.dte_kurtosis,
    ));
    columns.extend(known_list(
        "harmonics",
        "m",
        "Amplitude of the deflection at mesh orders 1, 2, ...",
        |found| &found.harmonics,
        |error| &error.harmonics,
    ));
    columns.extend(known_list(
        "suborders",
        "m",
        "Amplitude of the deflection at mesh orders 1/4, 1/3, 1/2, 2/3, 3/4: exact where the motion repeats, else root mean square over windows of 24 mesh cycles, noise within 1/24 order included",
        |found| &found.suborders,
        |error| &error.suborders,
    ));
    columns
}

fn force_columns() -> Vec<Column<PointRow>> {
    let mut columns = Vec::new();
    columns.extend(known(
        "force_mean",
        "N",
        "Mean mesh force",
        |found| Some(found.force_mean),
        |error| error.force_mean,
    ));
    columns.extend(known(
        "force_std",
        "N",
        "Standard deviation of the mesh force",
        |found| Some(found.force_std),
        |error| error.force_std,
    ));
    columns.push(number(
        "force_peak",
        "N",
        &format!("Largest |mesh force|; {SEEN}"),
        |found| Some(found.force_peak),
    ));
    columns
}

fn impact_columns() -> Vec<Column<PointRow>> {
    let mut columns = Vec::new();
    columns.extend(known(
        "impact_rate",
        "1/s",
        "Entries into contact a second",
        |found| Some(found.impact_rate),
        |error| error.impact_rate,
    ));
    columns.push(count(
        "impacts_drive",
        "Entries into contact on the drive flank over the measured cycles",
        |found| found.impacts[0],
    ));
    columns.push(count(
        "impacts_coast",
        "Entries into contact on the coast flank over the measured cycles",
        |found| found.impacts[1],
    ));
    columns.extend(known(
        "impact_velocity",
        "m/s",
        "Mean |deflection rate| on entry into contact; 0 without impacts",
        |found| Some(found.impact_velocity),
        |error| error.impact_velocity,
    ));
    columns.extend(known_list(
        "impact_velocity_quantiles",
        "m/s",
        "|Deflection rate| on entry into contact below which 50, 90 and 99 % of the impacts lie; null without impacts",
        |found| &found.impact_velocity_quantiles,
        |error| &error.impact_velocity_quantiles,
    ));
    columns.push(number(
        "impact_velocity_max",
        "m/s",
        &format!("Largest |deflection rate| on entry into contact; {SEEN}"),
        |found| found.impact_velocity_max,
    ));
    columns
}

fn duration_columns() -> Vec<Column<PointRow>> {
    let mut columns = vec![count(
        "flights",
        "Flights that began and ended in the measured cycles",
        |found| found.flights.count,
    )];
    columns.extend(known(
        "flight_mean",
        "s",
        "Mean length of a flight between two contacts",
        |found| found.flights.mean,
        |error| error.flight_mean,
    ));
    columns.extend(known(
        "flight_median",
        "s",
        "Median length of a flight between two contacts",
        |found| found.flights.median,
        |error| error.flight_median,
    ));
    columns.push(count(
        "contacts",
        "Contacts that began and ended in the measured cycles",
        |found| found.contacts.count,
    ));
    columns.extend(known(
        "contact_mean",
        "s",
        "Mean length of a contact between two flights",
        |found| found.contacts.mean,
        |error| error.contact_mean,
    ));
    columns.extend(known(
        "contact_median",
        "s",
        "Median length of a contact between two flights",
        |found| found.contacts.median,
        |error| error.contact_median,
    ));
    columns
}

fn bearing_columns() -> Vec<Column<PointRow>> {
    const ORDER: &str = "in the order of shafts (pinion, wheel), bearings (first, second) and directions (line of centres, across, axial) that have a stiffness, or of the modal file";
    [
        known_list(
            "bearing_mean",
            "N",
            &format!("Mean force of the shaft on each bearing, {ORDER}"),
            |found| &found.bearing_mean,
            |error| &error.bearing_mean,
        ),
        known_list(
            "bearing_rms",
            "N",
            &format!("Root mean square of each bearing force about its mean, {ORDER}"),
            |found| &found.bearing_rms,
            |error| &error.bearing_rms,
        ),
    ]
    .into_iter()
    .flatten()
    .collect()
}
