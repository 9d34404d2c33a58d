//! One file per table of the manifest, and the order in which they depend on each other:
//! structure, then mesh, excitation, run and analyses.

mod analyses;
mod backlash;
mod coast;
pub(super) mod contact_law;
mod continuation;
mod covariant;
mod drawn_mesh;
mod drive_kind;
mod excitation;
mod film;
mod flank_points;
mod friction;
mod gear;
mod ineffective_keys;
mod job;
mod mesh;
mod modal_state;
mod model;
mod orbits;
mod oscillator;
mod poincare;
mod run;
mod runup;
mod shafts;
mod slice;
mod slices;
mod sliders;
mod tooth_fault;
mod torque_curve;
mod train;

use super::grid::is_carried;
use super::modal_tree::ModalFile;
use super::reader::Section;
use super::spec::{MeshSpec, ModelSpec, StructureSource, Variant};
use crate::shaft::{Housing, Tier};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use backlash::MeshContext;
pub(super) use continuation::read as read_continuation;
use drive_kind::{DriveKind, is_kind};
pub(super) use job::read as read_job;
pub(super) use runup::read as read_run_up;

/// Whether a key of `[shafts]` or of one shaft has an effect in a tier.
pub(super) fn has_effect(tier: Tier, key: &str) -> bool {
    ineffective_keys::has_effect(DriveKind::Rigid(tier), key)
}

impl Variant {
    /// Shares equal parts with another variant.
    pub(super) fn share(&mut self, other: &Self) {
        if self.mesh.stiffness == other.mesh.stiffness {
            self.mesh.stiffness = other.mesh.stiffness.clone();
        }
        share(&mut self.excitation, &other.excitation);
        share(&mut self.run, &other.run);
        share(&mut self.analyses, &other.analyses);
    }
}

fn share<T: PartialEq>(target: &mut Arc<T>, other: &Arc<T>) {
    if target == other {
        *target = Arc::clone(other);
    }
}

/// Data that the resolution of every combination of the grid uses, such as files that were read.
#[derive(Debug)]
pub(super) struct Context<'a> {
    /// Start of relative paths in the manifest.
    pub base_dir: &'a Path,
    /// Modal files read so far; `None` for a faulty one, which has been reported.
    pub modal_files: HashMap<PathBuf, Option<Arc<ModalFile>>>,
    /// Housing files, in the same way.
    pub housings: HashMap<PathBuf, Option<Arc<Housing>>>,
    /// Files of torque curves, in the same way: angles \[rad\] and torques \[N m\].
    pub torque_curves: HashMap<PathBuf, Option<Vec<[f64; 2]>>>,
    /// Whether an axis of the grid or a changed parameter gives `mesh.half_gap`. The thinning of a drawing
    /// with backlash then changes to give it.
    pub half_gap_varies: bool,
    /// The last drive, which points of the same structure share.
    pub last_drive: Option<StructureSource>,
}

impl<'a> Context<'a> {
    pub fn new(base_dir: &'a Path) -> Self {
        Self {
            base_dir,
            modal_files: HashMap::new(),
            housings: HashMap::new(),
            torque_curves: HashMap::new(),
            half_gap_varies: false,
            last_drive: None,
        }
    }

    /// The last drive if `source` equals it, otherwise `source`, which becomes the last drive.
    fn shared(&mut self, source: StructureSource) -> StructureSource {
        let shared = match &self.last_drive {
            Some(last) if *last == source => last.clone(),
            _ => source,
        };
        self.last_drive = Some(shared.clone());
        shared
    }
}

/// Reads the tables of a point: all except `[job]`, `[grid]`, `[continuation]` and `[runup]`. `None` if one of
/// these tables is faulty, but some contradictions between tables are only reported.
pub(super) fn resolve(root: &Section, context: &mut Context) -> Option<Variant> {
    let model = model::read(root, context);
    let mesh = if oscillator::has_no_mesh(root, context) {
        oscillator::mesh(root, model.as_ref())
    } else {
        flanks(root, model.as_ref(), context.half_gap_varies)
    };

    let source = model.as_ref().map(|model| &model.source);
    let excitation = root.optional("excitation", |section| {
        excitation::read(section, source, mesh.as_ref(), context)
    });
    sliders::check(root, model.as_ref());
    film::check(root, mesh.as_ref());
    slices::check_residual_flexibility(root, model.as_ref(), mesh.as_ref());
    let retained = model.as_ref().map(|model| model.retained);
    let run = run::read(root, retained);
    let analyses = root.optional("analyses", |section| {
        analyses::read(section, model.as_ref(), run.as_ref(), is_carried(root))
    });
    Some(Variant {
        model: model?,
        mesh: mesh?,
        excitation: Arc::new(excitation?.unwrap_or_default()),
        run: Arc::new(run?),
        analyses: Arc::new(analyses?.unwrap_or_default()),
    })
}

/// The required table `[mesh]`.
fn flanks(root: &Section, model: Option<&ModelSpec>, gap_varies: bool) -> Option<MeshSpec> {
    // A faulty modal file, which has been reported, may have no mesh.
    if model.is_none() && is_kind(root, "modal") && root.entry("mesh").is_none() {
        return None;
    }
    let drawn = model.and_then(|model| model.source.gears());
    root.required_child("mesh").and_then(|section| {
        // A modal file has no drawing; `[gear]` is read if a part of the mesh needs it.
        let gears = drawn.or_else(|| model::gears_for_modal_file(root, &section));
        let gears = if gap_varies {
            gears.map(|gears| backlash::thinned(&section, gears))
        } else {
            gears
        };
        let mesh_context = MeshContext {
            gears: gears.as_ref(),
            faulty_drawing: gears.is_none() && model::is_drawn(root, &section, model.is_some()),
            source: model.map(|model| &model.source),
        };
        mesh::read(&section, mesh_context)
    })
}
