//! Resolves points that were not resolved in advance: other combinations of a large grid, and points outside the grid.

use super::axis::AxisKey;
use super::combinations::Combinations;
use super::diagnostic::Issues;
use super::expression::Expression;
use super::grid::GridAxis;
use super::grid_dimension::GridDimension;
use super::modal_keys;
use super::modal_tree::ModalFile;
use super::reader::Section;
use super::schema::MANIFEST;
use super::sections::{Context, resolve};
use super::spec::{PointSpec, Variant};
use super::tree::Node;
use crate::shaft::Housing;
use crate::units::Dimension;
use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

/// Message about inconsistent values if no section gives a reason.
pub(super) const INCONSISTENT: &str = "the values do not fit together, and no section gives the reason: this is \
    an error of atlas, please report it with the manifest";

/// Key of the half gap. Where it varies, the thinning of the drawn teeth changes to give it.
pub(super) const HALF_GAP: &str = "mesh.half_gap";

/// The tree of a manifest, kept to resolve combinations that were not judged, and points outside the grid.
#[derive(Debug, Clone)]
pub struct PointResolver(Arc<KeptPoint>);

#[derive(Debug)]
struct KeptPoint {
    tree: Node,
    keys: Vec<GridAxis>,
    combinations: Combinations,
    /// Whether the grid gives a torque instead of a load. The torque then stays constant when the rated
    /// torque changes.
    has_torque: bool,
    base_dir: PathBuf,
    modal_files: HashMap<PathBuf, Option<Arc<ModalFile>>>,
    /// The tree of the modal file with the values that commands set.
    modal_tree: Option<Node>,
    /// Whether axes or commands change that tree.
    modal_changed: bool,
    /// Axes given by expressions. Each comes after the axes in its expression.
    derived: Vec<(AxisKey, Dimension, Expression)>,
    housings: HashMap<PathBuf, Option<Arc<Housing>>>,
    torque_curves: HashMap<PathBuf, Option<Vec<[f64; 2]>>>,
}

impl PointResolver {
    /// `axes` has the model keys first, so that the index of a model key is also that of its axis.
    pub(super) fn new(
        mut tree: Node,
        axes: Vec<GridAxis>,
        dimensions: &[GridDimension],
        context: Context,
    ) -> Self {
        // The tree now has the values of the axes. Of `[grid]`, a point only needs the order.
        tree.retain("grid", |key| matches!(key, "order" | "along"));
        let changed_modal_tree = modal_keys::detach(&mut tree);
        let file = || context.modal_files.values().flatten().next();
        Self(Arc::new(KeptPoint {
            tree,
            modal_changed: changed_modal_tree.is_some(),
            modal_tree: changed_modal_tree.or_else(|| file().map(|file| file.tree.clone())),
            combinations: Combinations::new(&axes, dimensions),
            has_torque: axes.iter().any(|axis| axis.axis.key == AxisKey::Torque),
            keys: axes.into_iter().filter(GridAxis::is_model_key).collect(),
            base_dir: context.base_dir.to_path_buf(),
            modal_files: context.modal_files,
            housings: context.housings,
            torque_curves: context.torque_curves,
            derived: Vec::new(),
        }))
    }

    /// This resolver, with axes given by expressions.
    pub(super) fn deriving(self, expressions: Vec<(String, Expression)>) -> Self {
        let with_dimension = |(name, expression): (String, Expression)| {
            let of_axis = |key: &&GridAxis| key.axis.name() == name;
            let dimension = self.0.keys.iter().find(of_axis).map(GridAxis::dimension);
            let dimension = dimension.unwrap_or(Dimension::Ratio);
            (AxisKey::of(&name), dimension, expression)
        };
        let derived = expressions.into_iter().map(with_dimension).collect();
        let mut kept = self.0;
        if let Some(kept) = Arc::get_mut(&mut kept) {
            kept.derived = derived;
        }
        Self(kept)
    }

    /// Axes given by expressions, with their dimensions. Each comes after the axes in its expression.
    pub(super) fn derived(&self) -> &[(AxisKey, Dimension, Expression)] {
        &self.0.derived
    }

    /// Whether an expression gives an axis.
    pub fn is_derived(&self, name: &str) -> bool {
        self.0.derived.iter().any(|(key, ..)| key.name() == name)
    }

    /// Sets the mesh and the excitation of a point by its axis values, and its model if values of the modal
    /// file change. `None` if the manifest would be faulty with these values.
    pub(super) fn resolve(&self, point: &mut PointSpec) -> Option<()> {
        let resolved = self.combined(&point.axis_values, Vec::new(), None).ok()?;
        if self.0.modal_changed {
            point.model = resolved.model;
        }
        point.mesh = resolved.mesh;
        point.excitation = resolved.excitation;
        Some(())
    }

    /// The node at a dotted path of the manifest, or at the name of a number of the modal file.
    pub(super) fn node(&self, path: &str) -> Option<&Node> {
        if !modal_keys::is_modal_number_name(path) {
            return self.0.tree.at(path);
        }
        let file = self.0.modal_tree.as_ref()?;
        file.at(&modal_keys::path(file, path).ok()?.join("."))
    }

    /// Whether a key can have a value. A key of the manifest always can, a number of the modal file only if
    /// its list or table exists.
    pub(super) fn has_place(&self, name: &str) -> bool {
        let file = self.0.modal_tree.as_ref();
        !modal_keys::is_modal_number_name(name)
            || file.is_some_and(|file| modal_keys::path(file, name).is_ok())
    }

    /// Whether the points of the grid have a torque instead of a load.
    pub(super) fn has_torque(&self) -> bool {
        self.0.has_torque
    }

    /// The index of a model key among the axes.
    pub(super) fn axis(&self, name: &str) -> Option<usize> {
        self.0.keys.iter().position(|key| key.axis.name() == name)
    }

    /// Resolves the values of the model keys at a point after putting further nodes into the tree, each at
    /// its path. The error is a sentence about inconsistent values.
    pub(super) fn resolved_with(
        &self,
        point: &PointSpec,
        nodes: Vec<(&str, Node)>,
    ) -> Result<Variant, String> {
        let like = Variant {
            model: point.model.clone(),
            mesh: point.mesh.clone(),
            excitation: point.excitation.clone(),
            run: point.run.clone(),
            analyses: point.analyses.clone(),
        };
        self.combined(&point.axis_values, nodes, Some(&like))
    }

    /// All combinations of the grid.
    pub(super) fn combinations(&self) -> &Combinations {
        &self.0.combinations
    }

    /// The values of the model keys of a combination.
    pub(super) fn values(&self, number: usize) -> Vec<f64> {
        let places = self.0.combinations.places(number);
        let values = self.0.keys.iter().zip(places);
        values.map(|(key, i)| key.axis.values.get(i)).collect()
    }

    /// Resolves values of the model keys after putting further nodes into the tree. Shares the parts that are equal to
    /// those of `like`. The error is a sentence about inconsistent values.
    pub(super) fn combined(
        &self,
        values: &[f64],
        nodes: Vec<(&str, Node)>,
        like: Option<&Variant>,
    ) -> Result<Variant, String> {
        let kept = &*self.0;
        let mut tree = kept.tree.clone();
        let samples = kept.keys.iter().zip(values);
        let samples = samples.map(|(key, value)| (key.axis.name(), key.sample(*value)));
        let of_file = nodes
            .iter()
            .any(|(name, _)| modal_keys::is_modal_number_name(name));
        if let Some(file) = (kept.modal_tree.as_ref()).filter(|_| kept.modal_changed || of_file) {
            modal_keys::attach(&mut tree, file.clone());
        }
        let mut varies = false;
        for (name, node) in samples.chain(nodes) {
            varies |= name == HALF_GAP;
            if modal_keys::put(&mut tree, name, node).is_err() {
                return Err(format!("`{name}` is neither a key nor an axis"));
            }
        }
        let issues = Issues::default();
        let mut context = Context::new(&kept.base_dir);
        context.half_gap_varies = varies;
        context.modal_files.clone_from(&kept.modal_files);
        context.housings.clone_from(&kept.housings);
        context.torque_curves.clone_from(&kept.torque_curves);
        context.last_drive = like.map(|like| like.model.source.clone());
        let resolved = resolve(&Section::root(&tree, &issues, MANIFEST), &mut context);
        let diagnostics = issues.found.borrow();
        let fault = diagnostics
            .iter()
            .find(|diagnostic| !diagnostic.kind.is_warning());
        match (resolved, fault) {
            (Some(mut resolved), None) => {
                if let Some(like) = like {
                    resolved.share(like);
                }
                Ok(resolved)
            }
            (_, Some(fault)) => Err(fault.message.clone()),
            (None, None) => Err(INCONSISTENT.to_owned()),
        }
    }
}
