//! The list of the variables of an FMU, which the model description and the library share.

use super::FmuError;
use super::inputs::{INPUTS, Input, at_start};
use super::names::{of_key, part};
use crate::manifest::{Job, Parameter, PointSpec};
use crate::structure::ModalStructure;
use crate::units::Dimension;
use std::collections::BTreeSet;

/// The quantity that a variable represents.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// Time.
    Time,
    /// A key of the manifest, by index into [`Description::parameters`].
    Parameter(usize),
    /// An input.
    Input(Input),
    /// Rotation of a shaft where its torque acts: 0 for the pinion, 1 for the wheel.
    Angle(usize),
    /// Speed of a shaft where its torque acts: 0 for the pinion, 1 for the wheel.
    Speed(usize),
    /// Deflection of a mesh, by index.
    Deflection(usize),
    /// Force of a mesh, by index.
    Force(usize),
    /// Flanks of a mesh that touch, by the index of the mesh.
    Contact(usize),
    /// Force on a bearing, by index.
    Bearing(usize),
    /// Torque in a shaft or coupling, by index.
    Torque(usize),
    /// Number of openings and closings of contacts.
    Events,
}

impl Role {
    /// Whether the values of the variable are whole numbers.
    pub fn is_whole(self) -> bool {
        matches!(self, Self::Contact(_) | Self::Events)
    }

    /// Whether the FMU computes the variable.
    pub fn is_output(self) -> bool {
        !matches!(self, Self::Time | Self::Parameter(_) | Self::Input(_))
    }
}

/// A variable. Its value reference is its index in the list.
#[derive(Debug, Clone, PartialEq)]
pub struct Variable {
    /// Name.
    pub name: String,
    /// One sentence for the importer.
    pub about: String,
    /// Dimension of its values, which gives the unit.
    pub dimension: Dimension,
    /// The quantity that it represents.
    pub role: Role,
    /// Value before the importer sets one.
    pub start: Option<f64>,
    /// Whether an input changes the variable without delay.
    pub feeds_through: bool,
}

/// The variables of an FMU.
#[derive(Debug, Clone)]
pub struct Description {
    /// Name of the model.
    pub name: String,
    /// The variables, in the order of their value references.
    pub variables: Vec<Variable>,
    /// Keys of the manifest that the importer may change.
    pub parameters: Vec<Parameter>,
    /// Mesh period at the start \[s\].
    pub period: f64,
}

impl Variable {
    fn new(
        name: impl Into<String>,
        about: impl Into<String>,
        dimension: Dimension,
        role: Role,
    ) -> Self {
        Self {
            name: name.into(),
            about: about.into(),
            dimension,
            role,
            start: None,
            feeds_through: false,
        }
    }
}

const SHAFTS: [&str; 2] = ["pinion", "wheel"];

impl Description {
    /// The variables for a point of a job; `structure` is the structure of the point.
    ///
    /// # Errors
    /// The structure has no participation of a torque on one of the two shafts, or two variables would have one name.
    pub fn new(job: &Job, point: &PointSpec, structure: &ModalStructure) -> Result<Self, FmuError> {
        let mut all = vec![Variable::new("time", "Time", Dimension::Time, Role::Time)];
        let parameters = parameters(job, point, &mut all);
        inputs(at_start(structure, point)?, &mut all);
        shafts(&mut all);
        meshes(structure, &mut all);
        bearings(structure, &mut all);
        all.push(Variable::new(
            "events",
            "Number of times that a contact has opened or closed",
            Dimension::Ratio,
            Role::Events,
        ));
        let mut names = BTreeSet::new();
        let twice = all
            .iter()
            .find(|variable| !names.insert(variable.name.as_str()));
        if let Some(Variable { name, .. }) = twice {
            return Err(FmuError::DuplicateName { name: name.clone() });
        }
        Ok(Self {
            name: job.name.clone(),
            variables: all,
            parameters,
            period: std::f64::consts::TAU / (structure.cycles_per_turn() * point.speed),
        })
    }

    /// Values of the parameters before the importer sets any.
    pub fn parameters_at_start(&self) -> Vec<f64> {
        let start_of = |variable: &Variable| match variable.role {
            Role::Parameter(_) => variable.start,
            _ => None,
        };
        self.variables.iter().filter_map(start_of).collect()
    }

    /// Values of the inputs before the importer sets any.
    pub fn inputs_at_start(&self) -> [f64; INPUTS] {
        let of = |role| self.variables.iter().find(|variable| variable.role == role);
        Input::ALL.map(|input| {
            of(Role::Input(input))
                .and_then(|variable| variable.start)
                .unwrap_or(0.0)
        })
    }
}

/// Adds one variable per continuous quantity of the manifest: load, speed, and quantities of mesh and
/// excitation. Returns the keys of these quantities.
fn parameters(job: &Job, point: &PointSpec, all: &mut Vec<Variable>) -> Vec<Parameter> {
    let mut parameters = Vec::new();
    for key in job.between.continuous_keys() {
        let Ok(parameter) = job.between.parameter(point, &key) else {
            continue;
        };
        let Some(start) = job.between.value(point, &parameter) else {
            continue;
        };
        let (name, about) = match key.as_str() {
            "speed" => (
                "start.speed".to_owned(),
                "Speed of the pinion at the start".to_owned(),
            ),
            "load" | "torque" => (
                format!("start.{key}"),
                "Load at the start: it sets the initial state and the stiffness of a mesh computed from a drawing".to_owned(),
            ),
            _ => (of_key(&key), format!("Key {key} of the manifest")),
        };
        let role = Role::Parameter(parameters.len());
        all.push(Variable {
            start: Some(start),
            ..Variable::new(name, about, parameter.dimension(), role)
        });
        parameters.push(parameter);
    }
    parameters
}

fn inputs(starts: [f64; INPUTS], all: &mut Vec<Variable>) {
    let torque = |shaft: &str| {
        (
            format!("{shaft}.torque"),
            format!("Torque on the {shaft}'s shaft, positive in the direction of its rotation"),
            Dimension::Torque,
        )
    };
    for (input, start) in Input::ALL.into_iter().zip(starts) {
        let (name, about, dimension) = match input {
            Input::Pinion => torque(SHAFTS[0]),
            Input::Wheel => torque(SHAFTS[1]),
            Input::Load => (
                "load".to_owned(),
                "Rated torques on all shafts, in balance, that act beside the two torques, as a fraction".to_owned(),
                Dimension::Ratio,
            ),
        };
        all.push(Variable {
            start: Some(start),
            ..Variable::new(name, about, dimension, Role::Input(input))
        });
    }
}

fn shafts(all: &mut Vec<Variable>) {
    for (place, shaft) in SHAFTS.into_iter().enumerate() {
        all.push(Variable::new(
            format!("{shaft}.angle"),
            format!("Rotation of the {shaft}'s shaft where its torque acts, vibration included"),
            Dimension::Angle,
            Role::Angle(place),
        ));
        all.push(Variable::new(
            format!("{shaft}.speed"),
            format!("Speed of the {shaft}'s shaft where its torque acts, vibration included"),
            Dimension::AngularSpeed,
            Role::Speed(place),
        ));
    }
}

fn meshes(structure: &ModalStructure, all: &mut Vec<Variable>) {
    let names = structure.mesh_names();
    for (number, gears) in names.iter().enumerate() {
        let path = if names.len() == 1 {
            "mesh".to_owned()
        } else {
            format!("mesh.{}", part(gears))
        };
        for (what, about, dimension, role) in [
            (
                "force",
                "Force, positive on the drive flank and negative on the coast flank",
                Dimension::Force,
                Role::Force(number),
            ),
            (
                "deflection",
                "Deflection along the line of action of the drive flank, 0 in the middle of the gap",
                Dimension::Length,
                Role::Deflection(number),
            ),
            (
                "contact",
                "1 drive flank, -1 coast flank, 0 none, 2 both",
                Dimension::Ratio,
                Role::Contact(number),
            ),
        ] {
            all.push(Variable::new(
                format!("{path}.{what}"),
                format!("{about}: mesh of {gears}"),
                dimension,
                role,
            ));
        }
    }
}

fn bearings(structure: &ModalStructure, all: &mut Vec<Variable>) {
    for (place, bearing) in structure.bearings.iter().enumerate() {
        let (name, share) = (&bearing.name, &bearing.left_out);
        let variable = Variable::new(
            format!("bearing.{}", part(name)),
            format!("Force of the shaft on the bearing: {name}"),
            Dimension::Force,
            Role::Bearing(place),
        );
        all.push(Variable {
            feeds_through: share.torque != 0.0 || share.shaft_torques != [0.0; 2],
            ..variable
        });
    }
    for (place, torque) in structure.torques.iter().enumerate() {
        let name = &torque.name;
        all.push(Variable::new(
            format!("torque.{}", part(name)),
            format!("Torque: {name}"),
            Dimension::Torque,
            Role::Torque(place),
        ));
    }
}
