//! `modelDescription.xml` of FMI 2.0 and 3.0.

use super::description::{Description, Role, Variable};
use crate::units::Dimension;
use std::fmt::Write as _;

/// Name of the library in the archive, without its extension.
pub const MODEL_IDENTIFIER: &str = "atlas_fmu";

/// Category of all messages.
const CATEGORY: &str = "logStatusError";

/// A version of FMI.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Version {
    /// 2.0.
    Two,
    /// 3.0.
    Three,
}

/// A text as the value of an attribute, with escapes.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            // XML 1.0 cannot represent most control characters.
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out
}

/// The unit of a dimension, with `.` instead of `*`; `None` for a ratio.
fn unit(dimension: Dimension) -> Option<String> {
    (dimension != Dimension::Ratio).then(|| dimension.unit().replace('*', "."))
}

impl Description {
    /// The text of `modelDescription.xml` for a version of FMI. `token` identifies the resources.
    pub fn xml(&self, version: Version, token: &str) -> String {
        let mut out = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
        self.head(version, token, &mut out);
        self.units(&mut out);
        _ = writeln!(
            out,
            "<LogCategories><Category name=\"{CATEGORY}\" description=\"What was refused, and why\"/></LogCategories>"
        );
        // A fifth of a mesh period resolves a mesh cycle; 1000 periods are long enough to show rattle.
        _ = writeln!(
            out,
            "<DefaultExperiment startTime=\"0\" stopTime=\"{:?}\" stepSize=\"{:?}\"/>",
            1000.0 * self.period,
            0.2 * self.period
        );
        out.push_str("<ModelVariables>\n");
        for (reference, variable) in self.variables.iter().enumerate() {
            define(version, reference, variable, &mut out);
        }
        out.push_str("</ModelVariables>\n<ModelStructure>\n");
        self.structure(version, &mut out);
        out.push_str("</ModelStructure>\n</fmiModelDescription>\n");
        out
    }

    fn head(&self, version: Version, token: &str, out: &mut String) {
        // Structured names may have ASCII characters only, even in quotes.
        let ascii = self
            .variables
            .iter()
            .all(|variable| variable.name.is_ascii());
        let convention = if ascii { "structured" } else { "flat" };
        let (number, attribute, abilities) = match version {
            Version::Two => (
                "2.0",
                "guid",
                "canHandleVariableCommunicationStepSize=\"true\" canInterpolateInputs=\"true\" \
                 canGetAndSetFMUstate=\"true\" canSerializeFMUstate=\"true\"",
            ),
            Version::Three => (
                "3.0",
                "instantiationToken",
                "canHandleVariableCommunicationStepSize=\"true\" canGetAndSetFMUState=\"true\" canSerializeFMUState=\"true\"",
            ),
        };
        _ = writeln!(
            out,
            "<fmiModelDescription fmiVersion=\"{number}\" modelName=\"{}\" {attribute}=\"{}\" \
             generationTool=\"atlas {}\" variableNamingConvention=\"{convention}\">",
            escaped(&self.name),
            escaped(token),
            env!("CARGO_PKG_VERSION"),
        );
        _ = writeln!(
            out,
            "<CoSimulation modelIdentifier=\"{MODEL_IDENTIFIER}\" {abilities}/>"
        );
    }

    fn units(&self, out: &mut String) {
        let mut known: Vec<Dimension> = Vec::new();
        for variable in &self.variables {
            let dimension = variable.dimension;
            if unit(dimension).is_some() && !known.contains(&dimension) {
                known.push(dimension);
            }
        }
        out.push_str("<UnitDefinitions>\n");
        for dimension in known {
            let Some(unit) = unit(dimension) else {
                continue;
            };
            let powers = dimension.powers().unwrap_or_default();
            let mut base = String::new();
            for (name, power) in ["kg", "m", "s", "rad"].into_iter().zip(powers) {
                if power != 0 {
                    _ = write!(base, " {name}=\"{power}\"");
                }
            }
            _ = write!(out, "<Unit name=\"{unit}\"><BaseUnit{base}/>");
            if dimension == Dimension::AngularSpeed {
                let factor = 60.0 / std::f64::consts::TAU;
                _ = write!(out, "<DisplayUnit name=\"rpm\" factor=\"{factor:?}\"/>");
            }
            out.push_str("</Unit>\n");
        }
        out.push_str("</UnitDefinitions>\n");
    }

    /// Writes the lists of outputs, with their dependencies, and of initial unknowns.
    fn structure(&self, version: Version, out: &mut String) {
        // FMI 2.0 counts variables from 1; FMI 3.0 names value references.
        let (first, attribute) = match version {
            Version::Two => (1, "index"),
            Version::Three => (0, "valueReference"),
        };
        let numbered = || (first..).zip(&self.variables);
        let inputs: Vec<String> = numbered()
            .filter(|(_, variable)| matches!(variable.role, Role::Input(_)))
            .map(|(number, _)| number.to_string())
            .collect();
        let inputs = inputs.join(" ");
        for (kind, list) in [("Output", "Outputs"), ("InitialUnknown", "InitialUnknowns")] {
            let tag = match version {
                Version::Two => "Unknown",
                Version::Three => kind,
            };
            if version == Version::Two {
                _ = writeln!(out, "<{list}>");
            }
            for (number, variable) in numbered().filter(|(_, variable)| variable.role.is_output()) {
                let dependencies = match (kind, variable.feeds_through) {
                    ("Output", false) => " dependencies=\"\"".to_owned(),
                    ("Output", true) => format!(" dependencies=\"{inputs}\""),
                    _ => String::new(),
                };
                _ = writeln!(out, "<{tag} {attribute}=\"{number}\"{dependencies}/>");
            }
            if version == Version::Two {
                _ = writeln!(out, "</{list}>");
            }
        }
    }
}

/// Writes the element of a variable.
fn define(version: Version, reference: usize, variable: &Variable, out: &mut String) {
    let whole = variable.role.is_whole();
    let (causality, variability, initial) = match variable.role {
        Role::Time => ("independent", "continuous", ""),
        Role::Parameter(_) => ("parameter", "fixed", " initial=\"exact\""),
        Role::Input(_) => ("input", "continuous", ""),
        _ if whole => ("output", "discrete", " initial=\"calculated\""),
        _ => ("output", "continuous", " initial=\"calculated\""),
    };
    let head = format!(
        "name=\"{}\" valueReference=\"{reference}\" description=\"{}\" causality=\"{causality}\" \
         variability=\"{variability}\"{initial}",
        escaped(&variable.name),
        escaped(&variable.about),
    );
    let start = variable
        .start
        .map_or(String::new(), |start| format!(" start=\"{start:?}\""));
    let unit = match unit(variable.dimension) {
        Some(unit) if !whole => format!(" unit=\"{unit}\""),
        _ => String::new(),
    };
    _ = match (version, whole) {
        (Version::Two, true) => writeln!(out, "<ScalarVariable {head}><Integer/></ScalarVariable>"),
        (Version::Two, false) => {
            writeln!(
                out,
                "<ScalarVariable {head}><Real{unit}{start}/></ScalarVariable>"
            )
        }
        (Version::Three, true) => writeln!(out, "<Int64 {head}/>"),
        (Version::Three, false) => writeln!(out, "<Float64 {head}{unit}{start}/>"),
    };
}
