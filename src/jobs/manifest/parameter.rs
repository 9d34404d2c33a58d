//! Parameters of a job: quantities on which its drives depend continuously. Computes points with parameter values
//! that the grid does not have.

use super::axis::AxisKey;
use super::diagnostic::{Issues, Span};
use super::modal_keys;
use super::point_resolver::PointResolver;
use super::reader::{self, default_of};
use super::schema::{self, Kind, MANIFEST};
use super::spec::{PointSpec, Variant};
use super::tree::{Node, Value};
use crate::units::{self, Dimension};
use std::collections::BTreeMap;

/// Tables whose keys describe the drive.
const DRIVE_TABLES: [&str; 6] = ["model", "gear", "shafts", "train", "mesh", "excitation"];

/// A key, load, torque or speed, on which a drive depends continuously.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    key: AxisKey,
    dimension: Dimension,
}

/// Why is a name not a parameter?
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ParameterError {
    /// The key does not exist, or does not describe the drive.
    #[error(
        "`{name}` is not a parameter of the drive{}; name load, torque, speed, or a quantity of model, \
         gear, shafts, train, mesh or excitation, such as mesh.half_gap, or a number of the modal file, such as \
         contact.stop.gap",
        near.as_ref().map_or(String::new(), |near| format!(", did you mean `{near}`?"))
    )]
    Unknown {
        /// The name.
        name: String,
        /// The nearest parameter.
        near: Option<String>,
    },
    /// The key takes no number, or whole numbers only.
    #[error("`{name}` is not continuous: it takes {takes}; name a key that takes a quantity")]
    NotContinuous {
        /// The key.
        name: String,
        /// The accepted values.
        takes: String,
    },
    /// Neither the manifest nor a default sets the value.
    #[error("`{name}` has no value in the manifest to change; write it there first")]
    NoValue {
        /// The key.
        name: String,
    },
}

impl Parameter {
    /// The parameter of an axis.
    fn new(key: AxisKey, dimension: Dimension) -> Self {
        Self { key, dimension }
    }

    /// Name in manifests and result files.
    pub fn name(&self) -> &str {
        self.key.name()
    }

    /// Dimension.
    pub fn dimension(&self) -> Dimension {
        self.dimension
    }

    /// SI unit, `1` if dimensionless.
    pub fn unit(&self) -> &'static str {
        self.dimension.unit()
    }

    /// The parameter with this name. Contact damping counts as a ratio.
    ///
    /// # Errors
    /// [`ParameterError`].
    pub fn named(name: &str) -> Result<Self, ParameterError> {
        let key = AxisKey::of(name);
        let dimension = match key {
            AxisKey::Load => Dimension::Ratio,
            AxisKey::Torque => Dimension::Torque,
            AxisKey::Speed => Dimension::AngularSpeed,
            AxisKey::Key(_) => dimension_of(name)?,
        };
        Ok(Self { key, dimension })
    }

    /// Reads a value as typed: a bare number in SI, or a number with a unit. Returns it in SI.
    ///
    /// # Errors
    /// A sentence about the fault.
    pub fn parse(&self, text: &str) -> Result<f64, String> {
        match text.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(value),
            _ => units::parse(text, self.dimension).map_err(|error| error.to_string()),
        }
    }
}

fn dimension_of(name: &str) -> Result<Dimension, ParameterError> {
    let table = name.split('.').next().unwrap_or_default();
    let of_drive = |_: &&_| DRIVE_TABLES.contains(&table) || modal_keys::is_modal_number_name(name);
    let key = modal_keys::find(name).filter(of_drive);
    match key {
        None => Err(ParameterError::Unknown {
            name: name.to_owned(),
            near: nearest(name),
        }),
        Some(key) => match key.kind {
            Kind::Quantity(dimension) => Ok(dimension),
            // A bare number is a ratio; `parameter` handles a value with a unit.
            Kind::ContactDamping => Ok(Dimension::Ratio),
            _ => Err(ParameterError::NotContinuous {
                name: name.to_owned(),
                takes: key.accepted(),
            }),
        },
    }
}

fn nearest(name: &str) -> Option<String> {
    if modal_keys::is_modal_number_name(name) {
        return modal_keys::nearest(name);
    }
    let paths: Vec<&str> = (schema::all(MANIFEST))
        .filter(|key| matches!(key.kind, Kind::Quantity(_) | Kind::ContactDamping))
        .map(|key| key.path)
        .filter(|path| {
            !path.contains(['*', '<'])
                && DRIVE_TABLES.contains(&path.split('.').next().unwrap_or_default())
        })
        .chain(["load", "torque", "speed"])
        .collect();
    schema::nearest_path(name, &paths).map(str::to_owned)
}

impl PointResolver {
    /// A parameter that has a value at `point`. Contact damping has the dimension of its value in the manifest.
    ///
    /// # Errors
    /// [`ParameterError`].
    pub fn parameter(&self, point: &PointSpec, name: &str) -> Result<Parameter, ParameterError> {
        let mut parameter = Parameter::named(name)?;
        if let Some(Node {
            value: Value::Text(text),
            ..
        }) = self.node(name)
            && schema::find(MANIFEST, name).is_some_and(|key| key.kind == Kind::ContactDamping)
            && let Ok((_, dimension)) = units::parse_any(text)
        {
            parameter.dimension = dimension;
        }
        match self.value(point, &parameter) {
            Some(_) => Ok(parameter),
            None => Err(ParameterError::NoValue {
                name: name.to_owned(),
            }),
        }
    }

    /// Load or torque, speed, and the continuous keys of mesh and excitation that the manifest sets.
    pub fn continuous_keys(&self) -> Vec<String> {
        let load = if self.has_torque() { "torque" } else { "load" };
        let mut names = vec![load.to_owned(), "speed".to_owned()];
        for table in ["mesh", "excitation"] {
            if let Some(node) = self.node(table) {
                gather(node, table, &mut names);
            }
        }
        names
    }

    /// The value of a parameter at a point, in SI; `None` if neither the manifest nor a default sets it.
    pub fn value(&self, point: &PointSpec, parameter: &Parameter) -> Option<f64> {
        let name = match &parameter.key {
            AxisKey::Load => return Some(point.load),
            AxisKey::Torque => return Some(point.load * point.model.source.rated_torque()?),
            AxisKey::Speed => return Some(point.speed),
            AxisKey::Key(name) => name,
        };
        if let Some(place) = self.axis(name) {
            return point.axis_values.get(place).copied();
        }
        let key = modal_keys::find(name).filter(|_| self.has_place(name))?;
        let default = || default_of(key).filter(|_| matches!(key.kind, Kind::Quantity(_)));
        let node = self.node(name).or_else(|| Some(&default()?.node))?;
        match &node.value {
            Value::Text(text) => units::parse(text, parameter.dimension).ok(),
            Value::Float(value) | Value::Sample(value, _) => Some(*value),
            Value::Integer(value) => Some(*value as f64),
            _ => None,
        }
    }

    /// The torque \[N m\] of a point, if the grid has torques.
    fn value_of_torque(&self, point: &PointSpec) -> Option<f64> {
        let rated = point.model.source.rated_torque()?;
        self.has_torque().then_some(point.load * rated)
    }

    /// The new values of the axes given by expressions that depend on changed parameters, except axes among these
    /// parameters. The error is a sentence about an expression without a value.
    fn derived_of(
        &self,
        point: &PointSpec,
        values: &[(&Parameter, f64)],
    ) -> Result<Vec<(Parameter, f64)>, String> {
        let mut changed: BTreeMap<&str, f64> = (values.iter())
            .map(|(given_key, value)| (given_key.name(), *value))
            .collect();
        let mut derived_values = Vec::new();
        for (key, dimension, expression) in self.derived() {
            let has_changed = |name: &String| changed.contains_key(name.as_str());
            if changed.contains_key(key.name()) || !expression.names().iter().any(has_changed) {
                continue;
            }
            let value_of = |name: &str| {
                let parameter = Parameter::new(AxisKey::of(name), Dimension::Ratio);
                self.value(point, &parameter).unwrap_or(f64::NAN)
            };
            let value = expression
                .value(|name| changed.get(name).copied().unwrap_or_else(|| value_of(name)));
            let value = value.map_err(|why| format!("`{}`: {why}", key.name()))?;
            changed.insert(key.name(), value);
            derived_values.push((Parameter::new(key.clone(), *dimension), value));
        }
        Ok(derived_values)
    }

    /// The point with other values of some parameters.
    ///
    /// # Errors
    /// A sentence if the manifest would be faulty with these values.
    pub fn changed(
        &self,
        point: &PointSpec,
        values: &[(&Parameter, f64)],
    ) -> Result<PointSpec, String> {
        let derived = self.derived_of(point, values)?;
        let mut out = point.clone();
        let mut torque = self.value_of_torque(point);
        let mut nodes: Vec<(&str, Node)> = Vec::new();
        let assignments = values.iter().copied();
        for (parameter, value) in
            assignments.chain(derived.iter().map(|(key, value)| (key, *value)))
        {
            match &parameter.key {
                AxisKey::Load => (out.load, torque) = (value, None),
                AxisKey::Torque => {
                    out.load = point.model.load_of_torque(value);
                    torque = Some(value);
                }
                AxisKey::Speed => out.speed = value,
                AxisKey::Key(name) => {
                    in_range(name, value, parameter.dimension)?;
                    let value = Value::Sample(value, parameter.dimension);
                    let span = Span::start_of(0);
                    nodes.push((name, Node { span, value }));
                }
            }
        }
        if !(out.speed > 0.0 && out.speed.is_finite() && out.load.is_finite()) {
            return Err("a speed must be above 0 rad/s, and a load must be finite".to_owned());
        }
        if nodes.is_empty() {
            return Ok(out);
        }
        let Variant {
            model,
            mesh,
            excitation,
            run,
            analyses,
        } = self.resolved_with(point, nodes)?;
        // The rated torque may have changed.
        if let Some(torque) = torque {
            out.load = model.load_of_torque(torque);
        }
        Ok(PointSpec {
            model,
            mesh,
            excitation,
            run,
            analyses,
            ..out
        })
    }
}

fn in_range(name: &str, value: f64, dimension: Dimension) -> Result<(), String> {
    let Some(key) = modal_keys::find(name) else {
        return Ok(());
    };
    if dimension == Dimension::Damping || key.bounds.contain(value) {
        return Ok(());
    }
    let issues = Issues::default();
    let node = Node {
        span: Span::start_of(issues.add_source(String::new(), String::new())),
        value: Value::Sample(value, dimension),
    };
    let given = reader::Given {
        issues: &issues,
        node: &node,
        path: name,
        spec: key,
    };
    _ = given.in_range(value, dimension);
    let diagnostics = issues.found.borrow();
    Err(diagnostics
        .first()
        .map_or_else(String::new, |fault| fault.message.clone()))
}

/// Adds the names of continuous keys below a node.
fn gather(node: &Node, path: &str, names: &mut Vec<String>) {
    match &node.value {
        Value::Table(entries) => (entries.iter())
            .for_each(|entry| gather(&entry.node, &format!("{path}.{}", entry.key), names)),
        Value::Array(items) => (items.iter().enumerate())
            .for_each(|(i, item)| gather(item, &format!("{path}.{i}"), names)),
        _ if Parameter::named(path).is_ok() => names.push(path.to_owned()),
        _ => {}
    }
}
