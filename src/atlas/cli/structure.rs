//! The vibration of a manifest's structure, for `atlas check`: natural frequencies, mesh resonances, base
//! period.

use super::campbell;
use super::point::number;
use super::resonances;
use crate::analysis::{ClosedMode, Frequencies, NaturalMode, excitation_period};
use crate::manifest::{Job, PointSpec, StructureSource};
use crate::numerics::integers::least_multiple;
use crate::report::{Campbell, Unit};
use crate::sweep::{Prepared, build, structures};
use crate::units::short;
use serde_json::{Value, json};
use std::f64::consts::TAU;

/// Harmonics of the mesh frequency whose resonances are listed.
const HARMONICS: u32 = 3;

/// Largest number of rows in the table of modes.
const MOST_ROWS: usize = 100;

/// Largest number of degrees of freedom for which modes are computed; such a computation takes a second or two.
const MOST_FREEDOMS: usize = 1500;

/// Largest rate of growth that counts as round-off, as a part of the largest frequency.
const ROUND_OFF: f64 = 1e-9;

/// The structure of a grid's first point.
pub struct Structure {
    frequencies: Frequencies,
    /// Mesh cycles per revolution of the driver.
    cycles: f64,
    /// Campbell diagram with the resonances.
    diagram: Campbell,
    /// Speed of the driver at which the modes are computed \[rad/s\].
    speed: f64,
    /// Number of structures in the grid.
    count: usize,
    base_period: Option<usize>,
}

impl Structure {
    /// The structure of a job's first point.
    ///
    /// # Errors
    /// The reason why there is none, as a sentence.
    pub fn of(job: &Job, first: &PointSpec, parts: &Prepared) -> Result<Self, String> {
        check_size(first)?;
        let structure = parts.structure(&first.model);
        let structure = structure.map_err(|error| error.to_string())?;
        let model = build::mean_model(&structure, first, parts.meshes());
        let model = model.map_err(|error| error.to_string())?;
        // The mean model has constant mesh stiffness and equal teeth: the periods of meshes and teeth come
        // from the train and from the table of teeth.
        let of_meshes = match &first.model.source {
            StructureSource::Train(train) => train.base_cycles().unwrap_or(1),
            _ => 1,
        };
        let of_teeth = (first.mesh.teeth.as_ref()).map_or(1, |teeth| teeth.base_cycles());
        Ok(Self {
            frequencies: Frequencies::of(&model),
            cycles: structure.cycles_per_turn(),
            diagram: campbell::of(job, &[], parts)?,
            speed: first.speed,
            count: structures(job),
            base_period: excitation_period(&model)
                .map(|period| least_multiple(least_multiple(period, of_meshes), of_teeth)),
        })
    }

    /// Speed of the driver \[rad/s\] at which a harmonic of the mesh frequency equals the natural frequency
    /// of a mode; `None` for a rigid-body motion.
    fn resonance(&self, mode: &NaturalMode, harmonic: u32) -> Option<f64> {
        let order = self.cycles * f64::from(harmonic);
        (mode.frequency > 0.0).then(|| mode.frequency / order)
    }

    fn is_in_grid(&self, speed: f64) -> bool {
        let [low, high] = self.diagram.grid;
        (low..=high).contains(&speed)
    }

    /// The closed contacts, in words.
    fn closed_contacts(&self) -> String {
        match self.frequencies.contacts.count() {
            0 => "none".to_owned(),
            1 if !self.frequencies.loaded && !self.frequencies.on_drive_flanks() => {
                "the first contact".to_owned()
            }
            _ if self.frequencies.on_drive_flanks() => "drive flanks".to_owned(),
            1 => "the contact that bears the static load".to_owned(),
            count => format!("the {count} contacts that bear the static load"),
        }
    }

    /// The unit of speeds.
    fn unit(&self) -> Unit {
        Unit::or_si(self.diagram.unit.as_deref(), "rad/s")
    }

    /// Label and text of each line about the structure.
    pub fn lines(&self) -> Vec<(String, String)> {
        let unit = self.unit();
        let base = match self.base_period {
            Some(1) => "1 mesh cycle".to_owned(),
            Some(cycles) => format!("{cycles} mesh cycles"),
            None => "none within 1024 mesh cycles".to_owned(),
        };
        let which = match self.count {
            1 => String::new(),
            count => format!(", the first of {count} structures"),
        };
        let mut lines = vec![
            ("base period".to_owned(), base),
            (
                "modes".to_owned(),
                format!(
                    "at {}{which}: with all contacts open, and with {} closed at the mean stiffness",
                    unit.amount(number, self.speed),
                    self.closed_contacts()
                ),
            ),
            (
                String::new(),
                format!(
                    "n x {}: the speed of the driver at which harmonic n of the mesh frequency equals the frequency of a \
                     closed mode; * marks speeds in the grid",
                    unit.text
                ),
            ),
        ];
        let mut row = |text: String| lines.push((String::new(), text));
        row(format!(
            "{:>4} {:>10} {:>8} {:>11} {:>8} {:>7} {}",
            "mode",
            "open Hz",
            "ratio",
            "closed Hz",
            "ratio",
            "contact",
            (1..=HARMONICS)
                .map(|harmonic| format!("{:>10}", format!("{harmonic} x {}", unit.text)))
                .collect::<String>()
        ));
        for (index, mode) in self.frequencies.open.iter().take(MOST_ROWS).enumerate() {
            row(self.row(index, mode));
        }
        let hidden = self.frequencies.open.len().saturating_sub(MOST_ROWS);
        if hidden > 0 {
            row(format!("… and {hidden} more modes"));
        }
        lines.extend(resonances::lines(&self.diagram, &unit));
        lines
    }

    fn row(&self, index: usize, open: &NaturalMode) -> String {
        let mut text = format!("{:>4} {}", index + 1, columns(open, [10, 8]));
        if let Some(ClosedMode { mode, mesh_share }) = self.frequencies.closed.get(index) {
            let share = if mode.frequency > 0.0 {
                format!("{:.1} %", 100.0 * mesh_share)
            } else {
                "-".to_owned()
            };
            text += &format!(" {} {share:>7} ", columns(mode, [11, 8]));
            for harmonic in 1..=HARMONICS {
                let speed = self.resonance(mode, harmonic);
                text += &match speed {
                    None => format!("{:>9} ", "-"),
                    Some(speed) => {
                        let mark = if self.is_in_grid(speed) { '*' } else { ' ' };
                        let speed = resonances::speed(speed * self.unit().factor);
                        format!("{speed:>9}{mark}")
                    }
                };
            }
        }
        // The largest frequency is the scale of round-off, because a rigid mode has the frequency 0.
        let frequencies = self.frequencies.open.iter().map(|mode| mode.frequency);
        let largest = frequencies.fold(0.0, f64::max);
        let note = match open.ratio() {
            Some(ratio) if ratio > 1.0 => "  overdamped when open",
            _ if open.decay < -ROUND_OFF * largest => "  grows when open",
            _ => "",
        };
        text.trim_end().to_owned() + note
    }

    /// The structure as JSON, for programs.
    pub fn json(&self) -> Value {
        let mode = |mode: &NaturalMode| {
            json!({
                "frequency_hz": mode.frequency / TAU,
                "damping_ratio": mode.ratio(),
                "decay": mode.decay,
            })
        };
        let closed = |ClosedMode {
                          mode: natural_mode,
                          mesh_share,
                      }: &ClosedMode| {
            let speeds = (1..=HARMONICS).map(|harmonic| self.resonance(natural_mode, harmonic));
            let mut value = mode(natural_mode);
            value["mesh_share"] = json!(mesh_share);
            value["resonant_speeds"] = json!(speeds.collect::<Vec<_>>());
            value
        };
        json!({
            "count": self.count,
            "speed": self.speed,
            "base_period": self.base_period,
            "closed_contacts": self.frequencies.contacts.iter().map(|c| c + 1).collect::<Vec<_>>(),
            "resonances": self.diagram.resonances(),
            "open": self.frequencies.open.iter().map(mode).collect::<Vec<_>>(),
            "closed": self.frequencies.closed.iter().map(closed).collect::<Vec<_>>(),
        })
    }
}

/// Checks that the structure of a point has at most `MOST_FREEDOMS` degrees of freedom.
///
/// # Errors
/// It has more, or their number is unknown; the text is a sentence.
pub fn check_size(point: &PointSpec) -> Result<(), String> {
    let freedoms = match &point.model.source {
        StructureSource::Flexible(drive) => 12 * (1 + drive.elements.iter().sum::<usize>()),
        StructureSource::Train(train) => train.freedoms().map_err(|error| error.to_string())?,
        StructureSource::Rigid(_) | StructureSource::Modal(_) => 0,
    };
    if freedoms > MOST_FREEDOMS {
        return Err(format!(
            "not computed here, because {freedoms} degrees of freedom take long (limit: {MOST_FREEDOMS})"
        ));
    }
    Ok(())
}

/// Frequency \[Hz\] and damping ratio of a mode, in columns of these widths.
fn columns(mode: &NaturalMode, [frequency, ratio]: [usize; 2]) -> String {
    match mode.ratio() {
        None => format!("{:>frequency$} {:>ratio$}", "rigid", "-"),
        Some(value) => {
            let hertz = mode.frequency / TAU;
            let decimals = (3.0 - hertz.log10().floor()).clamp(1.0, 4.0) as usize;
            format!(
                "{:>frequency$} {:>ratio$}",
                short(hertz, decimals),
                short(value, 4)
            )
        }
    }
}
