//! Which tables does a job write, and with which axes?

use super::build;
use super::parts::structures;
use crate::analysis::{SliceConfig, SliceOf};
use crate::manifest::{Axis, GridDimension, Job, Refine, StructureSource, Variant};
use crate::model::{InitialState, Quantity};
use crate::store::{
    AxisColumn, ListElement, RefinedColumns, ResultLayout, SampleColumns, Shard, TableKind,
};
use crate::structure::MotionKind;
use strum::VariantArray;

/// The tables of a job (of a shard of it).
pub(super) fn layout(job: &Job, shard: Option<Shard>) -> ResultLayout {
    let variants = job.points.variants();
    let requested = |kind: &&TableKind| variants.iter().any(|v| kind.is_requested(&v.analyses));
    let tables = TableKind::VARIANTS.iter().filter(requested);
    let column = |axis: &Axis| AxisColumn {
        name: axis.name().to_owned(),
        unit: axis.unit.clone(),
    };
    ResultLayout {
        axes: job.axes.iter().map(column).collect(),
        tied: (job.dimensions.iter())
            .filter(|dimension| dimension.is_tied())
            .map(|dimension| {
                dimension
                    .axes
                    .iter()
                    .map(|&axis| job.axes[axis].name().to_owned())
                    .collect()
            })
            .collect(),
        requested: tables.copied().collect(),
        swept: job
            .carried
            .as_ref()
            .map(|carried| column(&job.axes[carried.axis])),
        basin_axes: variants
            .iter()
            .find_map(|v| v.analyses.multistability?.slice)
            .map(slice_axes),
        refined: job.refine.as_ref().map(|refine| refined(job, refine)),
        samples: sample_columns(job),
        elements: elements(job),
        shard,
    }
}

/// Names of the elements of lists, if the first and the last variant agree. These two have the ends of every
/// axis.
fn elements(job: &Job) -> Vec<(ListElement, Vec<String>)> {
    let variants = job.points.variants();
    let (Some(first), Some(last)) = (variants.first(), variants.last()) else {
        return Vec::new();
    };
    if !variants
        .iter()
        .any(|variant| variant.analyses.nvh.is_some())
    {
        return Vec::new();
    }
    let mut found = names(first);
    if structures(job) > 1 {
        let last = names(last);
        found.retain(|name| last.contains(name));
    }
    found
}

/// Names in columns of contacts for the flanks that an oscillator does not have.
pub const NO_FLANKS: [&str; 2] = ["no drive flank", "no coast flank"];

fn names(variant: &Variant) -> Vec<(ListElement, Vec<String>)> {
    let flanks = match variant.mesh.length {
        None => ["drive flank", "coast flank"],
        Some(_) => NO_FLANKS,
    };
    let flanks = flanks.map(str::to_owned);
    let contacts = match &variant.model.source {
        StructureSource::Train(train) => train.contact_names(),
        StructureSource::Modal(structure) => {
            let further = structure
                .contacts
                .iter()
                .map(|contact| contact.name.clone());
            flanks.into_iter().chain(further).collect()
        }
        StructureSource::Rigid(_) | StructureSource::Flexible(_) => flanks.to_vec(),
    };
    let mut all = vec![(ListElement::Contacts, contacts)];
    if variant.analyses.nvh.is_some_and(|nvh| nvh.outputs.any()) {
        all.extend(names_of_outputs(variant));
    }
    all
}

fn names_of_outputs(variant: &Variant) -> Vec<(ListElement, Vec<String>)> {
    let Ok(structure) = build::structure(&variant.model) else {
        return Vec::new();
    };
    let moving = |kind: MotionKind| {
        let motions = structure.motions.iter();
        let of_kind = motions.filter(move |motion| motion.kind == kind);
        of_kind.map(|motion| motion.name.clone()).collect()
    };
    let bearings = structure
        .bearings
        .iter()
        .map(|bearing| bearing.name.clone());
    let meshes = structure.mesh_names();
    let torques = structure.torques.iter().map(|torque| torque.name.clone());
    vec![
        (
            ListElement::Output(Quantity::BearingForce),
            bearings.collect(),
        ),
        (ListElement::Output(Quantity::Torque), torques.collect()),
        (
            ListElement::Output(Quantity::Acceleration),
            moving(MotionKind::Place),
        ),
        (
            ListElement::Output(Quantity::AngularAcceleration),
            moving(MotionKind::Body),
        ),
        (
            ListElement::Output(Quantity::MeshDeflection),
            meshes.clone(),
        ),
        (ListElement::Output(Quantity::MeshForce), meshes),
    ]
}

/// How the grid is refined.
fn refined(job: &Job, refine: &Refine) -> RefinedColumns {
    let mut varied = (job.axes.iter()).filter(|axis| axis.values.len() > 1);
    let mut name = || varied.next().map_or("", Axis::name).to_owned();
    let start = match &job.points.variants()[0].run.initial {
        InitialState::Static => "static",
        InitialState::Rest => "rest",
        InitialState::Modal { .. } => "modal",
    };
    RefinedColumns {
        nested: refine.nested,
        axes: [name(), name()],
        by: refine.by_words(),
        start: start.to_owned(),
    }
}

/// How values of axes are drawn; `None` without distributions.
pub fn sample_columns(job: &Job) -> Option<SampleColumns> {
    let samples = job.samples.as_ref()?;
    let first = samples.axes.first().map_or(0, |(axis, _)| *axis);
    let dimension = GridDimension::of(&job.dimensions, first);
    let carried = job.carried.as_ref();
    let swept = carried.map(|carried| GridDimension::of(&job.dimensions, carried.axis));
    let faster = (dimension + 1..job.dimensions.len()).filter(|place| Some(*place) != swept);
    let inside: usize = faster.map(|place| job.dimensions[place].length).product();
    let chain_length = carried.map_or(1, |carried| carried.length * carried.directions.len());
    Some(SampleColumns {
        axes: (samples.axes.iter())
            .map(|(axis, _)| job.axes[*axis].name().to_owned())
            .collect(),
        design: samples.design.name().to_owned(),
        samples: samples.count,
        rows: job.dimensions[dimension].length,
        stride: chain_length * inside,
    })
}

/// The quantities along the axes of a slice; modes are counted from 0.
fn slice_axes(slice: SliceConfig) -> [AxisColumn; 2] {
    let axis = |name: &str, mode: usize, unit: &str| AxisColumn {
        name: format!("{name} {}", mode + 1),
        unit: unit.to_owned(),
    };
    let [first, second] = slice.modes;
    let deflection = |mode| axis("mesh deflection by mode", mode, "m");
    match slice.of {
        SliceOf::Displacement => [deflection(first), deflection(second)],
        SliceOf::Velocity => [first, second].map(|mode| AxisColumn {
            name: format!("velocity of mode {} as mesh deflection", mode + 1),
            unit: "m".to_owned(),
        }),
        SliceOf::PhasePlane => [
            deflection(first),
            axis("rate of mesh deflection by mode", second, "m/s"),
        ],
    }
}
