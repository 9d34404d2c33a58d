//! Pictures of columns over one axis. They have one curve per column, value of a second axis, results folder
//! and direction of a sweep.

use std::collections::BTreeMap;

use super::Source;
use super::labelled::Labelled;
use super::map::file_part;
use super::measured::marks;
use super::plan::{Axes, Curve, Key, Plan};
use super::series::Series;
use crate::report::numbers::plural;
use crate::report::plot::axis::{Axis, range};
use crate::report::plot::canvas::Canvas;
use crate::report::plot::display::{Log, Scale};
use crate::report::plot::error::PlotError;
use crate::report::plot::picture::{Drawn, Picture};
use crate::report::plot::request::PlotRequest;

pub(super) fn draw(
    sources: &[Source<'_>],
    group: &[Vec<Series>],
    request: &PlotRequest,
) -> Result<Drawn, PlotError> {
    let axes = axes(sources, request)?;
    let names = names(group);
    let unit = (group.iter().flatten().next()).map_or("", |series| &series.unit);
    let label = label(&names, group);
    let scale = Scale::new(&label, unit, &request.display)?;
    let Plans {
        order,
        plans,
        dropped,
    } = Plans::of(sources, group, &axes, &scale);
    let first = &sources[0].results;
    let over = &first.summary.axes[axes.over[0]];
    let marks = |measured| marks(measured, &names, unit, over, &scale);
    let measured = request.measured.as_ref().map(marks).transpose()?.flatten();
    let name_of = |key: &Key| &*group[key[2]][key[0]].name;
    let mut extent = Extent::default();
    for name in &names {
        let all = plans.values().flat_map(|plan| &plan.curves);
        let named = all.filter(|(key, _)| name_of(key) == *name);
        extent.reach(named.map(|(_, curve)| curve), &scale);
    }
    let floors = std::mem::take(&mut extent.floors);
    extent.reach(measured.iter(), &scale);
    let across = extent.across();
    let across = first.axis(over, |name, unit| match request.display.log {
        Some(Log::X | Log::Xy) => {
            let [first, last] = range(across.iter().copied());
            let margin = (last / first).max(1.0).powf(0.02);
            Axis::logarithmic(name, unit, [first / margin, last * margin])
        }
        Some(Log::Y) | None => Axis::for_grid(name, unit, &across),
    });
    let up = scale.axis(range(extent.ends.into_iter()));
    let mut drawn = Drawn::sliced(&label, order.len(), order.len() + dropped);
    let job_names: Vec<&str> = sources.iter().map(|source| &*source.name).collect();
    let by = axes.by.iter().flatten().next();
    let by = by.and_then(|&by| first.summary.axes.get(by));
    let along = (request.over.is_some() || by.is_some()).then_some(&*over.name);
    let file = file(
        &names,
        group,
        [along, by.map(|axis| &*axis.name)],
        &job_names,
    );
    for suffix in &order {
        let plan = &plans[suffix];
        let title = format!(
            "{}: {} over {}",
            job_names.join(", "),
            names.join(", "),
            over.name
        );
        let points = plural(plan.points, "point");
        let others = (measured.as_ref()).map(|curve| plural(curve.dots.len(), "measured point"));
        let others = others.unwrap_or_default();
        let shared_values = plan.shared_values().join(", ");
        let hidden = names.iter().zip(&floors).map(|(name, floor)| {
            let named = plan.curves.iter().filter(|(key, _)| name_of(key) == *name);
            let dots = named.flat_map(|(_, curve)| &curve.dots);
            dots.filter(|dot| dot.value < *floor).count()
        });
        let below = match hidden.sum() {
            0 => String::new(),
            count => format!("{} of round-off below the axis", plural(count, "value")),
        };
        let errors = if plan.curves.values().any(|curve| curve.barred) {
            plan.evidence.words()
        } else {
            String::new()
        };
        let mut canvas = Canvas::titled(
            &title,
            &first.subtitle(&[
                &shared_values,
                &points,
                &others,
                &plan.joins.join("; "),
                &below,
                &errors,
            ]),
        );
        let picture = Labelled {
            sources,
            group,
            axes: &axes,
            plan,
            names: &names,
            measured: measured.as_ref(),
        };
        picture.draw(&mut canvas, &across, &up);
        drawn
            .pictures
            .push(Picture::new(format!("{file}{suffix}"), canvas));
    }
    Ok(drawn)
}

/// The ranges of the curves on both axes.
#[derive(Default)]
struct Extent {
    across: Vec<f64>,
    ends: Vec<f64>,
    /// For each column, the shown value below which its values are round-off.
    floors: Vec<f64>,
}

impl Extent {
    /// Extends the ranges by the curves of one column, without values of round-off.
    fn reach<'a>(&mut self, curves: impl Iterator<Item = &'a Curve>, scale: &Scale) {
        let dots: Vec<_> = curves.flat_map(|curve| &curve.dots).collect();
        let values = dots.iter().map(|dot| dot.value);
        let [_, largest] = range(values.filter(|value| value.is_finite()));
        let floor = scale.floor(largest).unwrap_or(f64::NEG_INFINITY);
        self.floors.push(floor);
        for dot in dots {
            self.across.push(dot.x);
            let bar = [dot.low, dot.high, dot.value].into_iter();
            let bar = bar.filter(|value| value.is_finite() && *value >= floor);
            self.ends.extend(bar);
        }
    }

    /// The distinct values along the axis, ascending.
    fn across(&mut self) -> Vec<f64> {
        let mut across = std::mem::take(&mut self.across);
        across.sort_by(f64::total_cmp);
        across.dedup();
        across
    }
}

/// What each picture will draw.
struct Plans {
    /// The keys of `plans`, in the order of the pictures.
    order: Vec<String>,
    /// The key is the file-name suffix of the slice of the grid that the picture shows.
    plans: BTreeMap<String, Plan>,
    /// Number of slices that no picture shows.
    dropped: usize,
}

impl Plans {
    fn of(sources: &[Source<'_>], group: &[Vec<Series>], axes: &Axes, scale: &Scale) -> Self {
        let mut plans = Self {
            order: Vec::new(),
            plans: BTreeMap::new(),
            dropped: 0,
        };
        for (place, source) in sources.iter().enumerate() {
            let mut free = vec![axes.over[place]];
            free.extend(axes.by[place]);
            let (slices, all) = source.results.slices_of_both(&free);
            plans.dropped += all - slices.len();
            for slice in &slices {
                if !plans.plans.contains_key(&slice.suffix) {
                    plans.order.push(slice.suffix.clone());
                }
                let plan = plans.plans.entry(slice.suffix.clone()).or_default();
                plan.take(place, source, slice, &group[place], axes, scale);
            }
        }
        plans
    }
}

/// The distinct names of the columns.
fn names(group: &[Vec<Series>]) -> Vec<&str> {
    let mut names: Vec<&str> = Vec::new();
    for series in group.iter().flatten() {
        if !names.contains(&&*series.name) {
            names.push(&series.name);
        }
    }
    names
}

/// The common label of the columns, for the vertical axis.
fn label(names: &[&str], group: &[Vec<Series>]) -> String {
    match (names, &group[0][..]) {
        ([name], [series]) if !series.part.is_empty() => format!("{name}, {}", series.part),
        ([name], _) => (*name).to_owned(),
        _ => common(names),
    }
}

/// The beginning of file names: the columns, the axes of the curves, and the jobs after the first.
fn file(
    names: &[&str],
    group: &[Vec<Series>],
    [over, by]: [Option<&str>; 2],
    jobs: &[&str],
) -> String {
    let mut file = names.join("+");
    if let ([_], [series]) = (names, &group[0][..]) {
        file += &file_part(&series.part);
    }
    let mut file = file.replace(' ', "-");
    if let Some(over) = over {
        file += &format!("-over-{over}");
    }
    if let Some(by) = by {
        file += &format!("-by-{by}");
    }
    if jobs.len() > 1 {
        file += &format!("-with-{}", jobs[1..].join("+"));
    }
    file
}

/// The common label of some columns of one unit: the first words of the first name that occur in all names,
/// else all names.
fn common(names: &[&str]) -> String {
    let first = names.first().copied().unwrap_or_default();
    let parts = first.split('_').take_while(|part| {
        let begins = |name: &&str| name.split('_').any(|word| word == *part);
        names.iter().all(begins)
    });
    let shared: Vec<&str> = parts.collect();
    if shared.is_empty() { names.join(", ") } else { shared.join("_") }
}

/// The axis along the curves, and the axis by which they differ.
fn axes(sources: &[Source<'_>], request: &PlotRequest) -> Result<Axes, PlotError> {
    let first = sources[0].results;
    let along = |name: Option<&str>, except: Option<&str>| first.along_any(name, except);
    let over = along(request.over.as_deref(), request.by.as_deref())?;
    let over_name = &first.summary.axes[over].name;
    if request.by.as_ref() == Some(over_name) {
        return Err(PlotError::SameAxis {
            name: over_name.clone(),
        });
    }
    let mut axes = Axes {
        over: Vec::new(),
        by: Vec::new(),
        values: Vec::new(),
    };
    for source in sources {
        let results = source.results;
        axes.over.push(results.along_any(Some(over_name), None)?);
        let by = request
            .by
            .as_deref()
            .map(|name| results.along_any(Some(name), None));
        let by = by.transpose()?;
        axes.by.push(by);
        axes.values
            .extend(by.iter().flat_map(|&by| &results.summary.axes[by].values));
    }
    axes.values.sort_by(f64::total_cmp);
    axes.values.dedup();
    Ok(axes)
}
