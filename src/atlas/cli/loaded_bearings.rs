//! The loads of a train's rolling bearings in its static equilibrium, for `atlas check`.

use crate::manifest::{PointSpec, StructureSource};
use crate::report::to_digits;
use crate::shaft::LoadedBearing;
use serde_json::{Value, json};

/// Values below this fraction of the largest value are round-off and shown as 0.
const ROUND_OFF: f64 = 1e-12;

/// The rolling bearings of a point's drive in static equilibrium, and the load of the drive.
pub struct LoadedBearings {
    load: f64,
    bearings: Result<Vec<LoadedBearing>, String>,
}

impl LoadedBearings {
    /// The bearings of a point; `None` if the drive is not a train or has no loaded rolling bearings.
    pub fn of(point: &PointSpec) -> Option<Self> {
        let StructureSource::Train(train) = &point.model.source else {
            return None;
        };
        Some(Self {
            load: train.bearing_load?,
            bearings: (train.loaded_bearings()).map_err(|error| error.to_string()),
        })
    }

    /// Label and text of each line about the bearings.
    pub fn lines(&self) -> Vec<(String, String)> {
        let head = "bearings".to_owned();
        let bearings = match &self.bearings {
            Ok(bearings) => bearings,
            Err(error) => return vec![(head, error.clone())],
        };
        let mut lines = vec![(
            head,
            format!(
                "rolling bearings at rest under {} x the rated torque: load, displacement and stiffness of the inner \
                 ring, and the rolling elements that bear",
                to_digits(self.load, 4)
            ),
        )];
        let mut row = |text: String| lines.push((String::new(), text));
        row(format!(
            "{:<20} {:>30} {:>27} {:>33} {:>22} {:>8}",
            "bearing",
            "load x, y, axial N",
            "moved x, y, axial um",
            "stiffness x, y, axial N/m",
            "tilt x, y N m/rad",
            "elements"
        ));
        let cells = |values: &[f64], width: usize| {
            let largest = values
                .iter()
                .fold(0.0_f64, |most, value| most.max(value.abs()));
            let cells = values.iter().map(|value| {
                let shown = if value.abs() > ROUND_OFF * largest { *value } else { 0.0 };
                format!("{:>width$}", to_digits(shown, 3))
            });
            cells.collect::<String>()
        };
        for bearing in bearings {
            let stiffness: Vec<f64> = (0..5).map(|i| bearing.bears.stiffness[i][i]).collect();
            let moved = bearing.moved.map(|part| 1e6 * part);
            row(format!(
                "{:<20} {} {} {} {} {:>8}",
                bearing.name,
                cells(&bearing.bears.load[..3], 10),
                cells(&moved[..3], 9),
                cells(&stiffness[..3], 11),
                cells(&stiffness[3..], 11),
                bearing.bears.elements
            ));
        }
        lines
    }

    /// The bearings as JSON, for programs.
    pub fn json(&self) -> Value {
        match &self.bearings {
            Ok(bearings) => {
                let each = bearings.iter().map(|bearing| {
                    json!({
                        "name": bearing.name,
                        "load": bearing.bears.load,
                        "displacement": bearing.moved,
                        "stiffness": bearing.bears.stiffness,
                        "elements": bearing.bears.elements,
                        "largest_element_force": bearing.bears.largest,
                    })
                });
                json!({ "at_load": self.load, "bearings": each.collect::<Vec<_>>() })
            }
            Err(error) => json!({ "at_load": self.load, "error": error }),
        }
    }
}
