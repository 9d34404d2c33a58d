//! Campbell diagram: natural frequencies over the speed, the rays of mesh and shaft orders, and their
//! intersections, the resonances.

use serde::Serialize;

use super::axis::{Axis, range};
use super::canvas::{Anchor, BLUE, Canvas, Colour, FAINT, INK, RED, SOFT, WHITE};
use super::display::{Display, Unit};
use super::lettering::fitted;
use super::panel::{BOTTOM, LEFT, Panel, TICK_SIZE, TOP};
use super::picture::Drawn;
use crate::report::numbers::number;

const RIGHT: f64 = 690.0;
/// Distance from the diagram to its key, right end of the canvas, and text size of the key \[px\].
const KEY_DISTANCE: f64 = 86.0;
const CANVAS_RIGHT: f64 = 946.0;
const KEY_SIZE: f64 = 11.5;
/// Largest number of resonances listed beside the diagram.
const MOST_LISTED: usize = 19;
/// Smallest share of a mode's elastic energy in the closed contacts for which the mode is drawn bold.
const IN_MESH: f64 = 0.05;
/// Colour of the natural frequencies of modes with open contacts.
const PALE: Colour = Colour(0xa8, 0xa8, 0xa8);

/// Largest relative distance of a listed resonance from the speeds of the grid. A resonance just outside the
/// grid is listed too, because its peak extends into the grid.
pub const NEAR_GRID: f64 = 0.1;

/// A natural frequency over the speed.
#[derive(Debug, Clone, PartialEq)]
pub struct ModeLine {
    /// Number of the mode, from 1 in ascending frequency.
    pub mode: usize,
    /// Frequency at each of [`Campbell::speeds`] \[Hz\].
    pub frequencies: Vec<f64>,
    /// Share of its elastic energy that the closed contacts store, the largest over the speeds; 0 if they are open.
    pub mesh_share: f64,
}

/// An excitation whose frequency is proportional to the speed.
#[derive(Debug, Clone, PartialEq)]
pub struct Ray {
    /// Name of the excitation, such as `2 × mesh`.
    pub name: String,
    /// Periods per revolution of the pinion.
    pub order: f64,
    /// Whether it is an order of the mesh, not of a shaft.
    pub of_mesh: bool,
}

/// Contents of a Campbell diagram.
#[derive(Debug, Clone, PartialEq)]
pub struct Campbell {
    /// Name of the job.
    pub job: String,
    /// Unit for speeds in the manifest, if any.
    pub unit: Option<String>,
    /// Load and closed contacts for which modes were computed, as text.
    pub words: String,
    /// Lowest and highest speed of the grid \[rad/s\].
    pub grid: [f64; 2],
    /// Pinion speeds at which modes were computed, ascending \[rad/s\]; the diagram ends at the last.
    pub speeds: Vec<f64>,
    /// Modes with all contacts open.
    pub open: Vec<ModeLine>,
    /// Modes with the contacts closed that carry the static load.
    pub closed: Vec<ModeLine>,
    /// Excitations.
    pub rays: Vec<Ray>,
}

/// State of the contacts that carry the static load.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Contacts {
    /// Closed, with their mean stiffness.
    Closed,
    /// Open, like all other contacts.
    Open,
}

impl Contacts {
    /// `closed` or `open`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Closed => "closed",
            Self::Open => "open",
        }
    }
}

/// A resonance: an excitation has a natural frequency at a speed of the grid, or within [`NEAR_GRID`] of it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Resonance {
    /// Pinion speed \[rad/s\].
    pub speed: f64,
    /// Natural frequency at the crossing \[Hz\].
    pub frequency: f64,
    /// The crossing excitation, such as `2 × mesh`.
    pub excitation: String,
    /// Contact state of its mode.
    pub contacts: Contacts,
    /// The mode, from 1.
    pub mode: usize,
    /// Largest share, over all speeds, of its elastic energy that the closed contacts store; 0 if they are open.
    pub mesh_share: f64,
}

impl Campbell {
    /// Intersections of rays and natural frequencies at speeds of the grid or near them, by speed.
    pub fn resonances(&self) -> Vec<Resonance> {
        let [low, high] = self.grid;
        let near = low * (1.0 - NEAR_GRID)..=high * (1.0 + NEAR_GRID);
        let closed = self.closed.iter().map(|mode| (Contacts::Closed, mode));
        let open = self.open.iter().map(|mode| (Contacts::Open, mode));
        let mut found = Vec::new();
        for (contacts, mode) in closed.chain(open) {
            for ray in &self.rays {
                let crossings = self.meetings(mode, ray).into_iter();
                found.extend(crossings.filter(|(speed, _)| near.contains(speed)).map(
                    |(speed, frequency)| Resonance {
                        speed,
                        frequency,
                        excitation: ray.name.clone(),
                        contacts,
                        mode: mode.mode,
                        mesh_share: mode.mesh_share,
                    },
                ));
            }
        }
        found.sort_by(|a, b| a.speed.total_cmp(&b.speed));
        found
    }

    /// Intersections of a ray with the line of a mode: speed \[rad/s\] and frequency \[Hz\]. The frequency of
    /// the mode is linear between the speeds.
    fn meetings(&self, mode: &ModeLine, ray: &Ray) -> Vec<(f64, f64)> {
        let slope = ray.order / std::f64::consts::TAU;
        let above: Vec<(f64, f64)> = (self.speeds.iter().zip(&mode.frequencies))
            .map(|(&speed, &frequency)| (speed, slope * speed - frequency))
            .collect();
        let between = above.windows(2).filter_map(|pair| {
            let [(from, a), (to, b)] = [pair[0], pair[1]];
            // An intersection exactly at the end of an interval counts in the next interval only.
            let crosses = (a <= 0.0 && b > 0.0) || (a >= 0.0 && b < 0.0);
            let speed = from + (to - from) * a / (a - b);
            crosses.then_some((speed, slope * speed))
        });
        between.collect()
    }

    /// The diagram.
    pub fn draw(&self, display: &Display) -> Drawn {
        const SI: &str = "rad/s";
        let units: Vec<String> = display.units.iter().chain(&self.unit).cloned().collect();
        let unit = Unit::first(&units, SI).unwrap_or_else(|| Unit::fitting(SI, 1.0));
        let title = format!("{}: Campbell diagram", self.job);
        let mut canvas = Canvas::titled(&title, &self.words);
        let last = self.speeds.last().copied().unwrap_or(1.0);
        let of_mesh = self.rays.iter().filter(|ray| ray.of_mesh);
        let steepest = range(of_mesh.map(|ray| ray.order))[1] / std::f64::consts::TAU;
        let panel = Panel::new(
            [LEFT, RIGHT],
            [TOP, BOTTOM],
            Axis::linear("speed", SI, [0.0, last]).in_unit("speed", &unit.text, unit.factor),
            Axis::linear("frequency", "Hz", [0.0, 1.02 * steepest * last]),
        );
        // Shade the range of the speeds of the grid.
        let [low, high] = self.grid.map(|speed| panel.x(speed));
        canvas.rectangle(
            [low, TOP],
            [high.max(low + 1.5), BOTTOM],
            Colour(0xf3, 0xf3, 0xee),
        );
        panel.frame(&mut canvas, true);
        for mode in &self.open {
            self.line(&mut canvas, &panel, mode, true);
        }
        for mode in &self.closed {
            self.line(&mut canvas, &panel, mode, false);
        }
        self.rays(&mut canvas, &panel);
        let crossings = self.resonances();
        for resonance in &crossings {
            let at = panel.at(resonance.speed, resonance.frequency);
            if at[1] < TOP {
                continue;
            }
            let (edge, fill) = match resonance.contacts {
                Contacts::Open => (PALE, WHITE),
                Contacts::Closed if resonance.mesh_share < IN_MESH => (INK, WHITE),
                Contacts::Closed => (INK, RED),
            };
            canvas.disc(at, 4.4, edge);
            canvas.disc(at, 3.2, fill);
        }
        canvas.outline([LEFT, TOP], [RIGHT, BOTTOM], INK, 1.0);
        self.key(&mut canvas, &crossings, &unit);
        Drawn::one("campbell", canvas)
    }

    fn line(&self, canvas: &mut Canvas, panel: &Panel, mode: &ModeLine, open: bool) {
        let places = self.speeds.iter().zip(&mode.frequencies);
        let places: Vec<_> = places
            .filter(|(_, frequency)| panel.y(**frequency) >= panel.top)
            .map(|(speed, frequency)| panel.at(*speed, *frequency))
            .collect();
        match open {
            true => canvas.dashed_line(&places, PALE, 1.1),
            false if mode.mesh_share < IN_MESH => canvas.line(&places, BLUE, 0.9),
            false => canvas.line(&places, BLUE, 2.4),
        }
    }

    /// Draws the rays, with their names where they leave the diagram. A name that would cover another is left
    /// out.
    fn rays(&self, canvas: &mut Canvas, panel: &Panel) {
        let mut taken: Vec<f64> = Vec::new();
        let last = self.speeds.last().copied().unwrap_or(1.0);
        for ray in &self.rays {
            let end = ray.order / std::f64::consts::TAU * last;
            let (from, to) = (panel.at(0.0, 0.0), panel.at(last, end));
            let beyond = ((from[1] - panel.top) / (from[1] - to[1])).min(1.0);
            let to = [0, 1].map(|axis| from[axis] + beyond * (to[axis] - from[axis]));
            if ray.of_mesh {
                canvas.line(&[from, to], RED, 1.3)
            } else {
                canvas.dashed_line(&[from, to], RED, 1.0)
            }
            let baseline = to[1] + 0.35 * TICK_SIZE;
            if taken
                .iter()
                .all(|other| (other - baseline).abs() > TICK_SIZE)
            {
                let (name, size) = fitted(&brief(&ray.name), TICK_SIZE, 8.0, KEY_DISTANCE - 17.0);
                canvas.text([to[0] + 6.0, baseline], &name, size, RED, Anchor::Start);
                taken.push(baseline);
            }
        }
    }

    fn key(&self, canvas: &mut Canvas, crossings: &[Resonance], unit: &Unit) {
        let x = RIGHT + KEY_DISTANCE;
        let mut y = TOP + 6.0;
        let mut say = |canvas: &mut Canvas, text: &str, colour: Colour| {
            let (text, size) = fitted(text, KEY_SIZE, 8.0, CANVAS_RIGHT - x);
            canvas.text([x, y], &text, size, colour, Anchor::Start);
            y += 16.5;
        };
        let named = [
            ("bold: closed mode that deflects the mesh", BLUE),
            ("thin: closed mode, other", BLUE),
            ("dashed: mode, contacts open", SOFT),
            ("dashed rays: turns of shafts", RED),
            ("shaded: speeds of the grid", SOFT),
        ];
        for (text, colour) in named {
            say(canvas, text, colour);
        }
        let of = |contacts: Contacts| crossings.iter().filter(move |one| one.contacts == contacts);
        let (closed, open) = (of(Contacts::Closed).count(), of(Contacts::Open).count());
        let near = format!(
            "resonances within ± {:.0} % of the grid:",
            100.0 * NEAR_GRID
        );
        say(canvas, &near, INK);
        say(canvas, &format!("{closed} with contacts closed"), INK);
        // List the resonances of the modes with the largest share of energy in the contacts, by speed.
        let mut leading: Vec<&Resonance> = of(Contacts::Closed).collect();
        leading.sort_by(|a, b| b.mesh_share.total_cmp(&a.mesh_share));
        leading.truncate(MOST_LISTED);
        leading.sort_by(|a, b| a.speed.total_cmp(&b.speed));
        for resonance in &leading {
            let text = format!(
                "{} {}: {}, mode {}",
                number(resonance.speed * unit.factor),
                unit.text,
                brief(&resonance.excitation),
                resonance.mode
            );
            let bold = resonance.mesh_share >= IN_MESH;
            say(canvas, &text, if bold { INK } else { SOFT });
        }
        if leading.len() < closed {
            let text = format!(
                "… {} more, with less mesh deflection",
                closed - leading.len()
            );
            say(canvas, &text, SOFT);
        }
        say(canvas, &format!("{open} with contacts open: grey"), SOFT);
        canvas.line(&[[x - 8.0, TOP], [x - 8.0, BOTTOM]], FAINT, 1.0);
    }
}

/// The short name of an excitation: `2 × mesh of a and b` becomes `2 × a/b`.
fn brief(name: &str) -> String {
    name.replace("mesh of ", "").replace(" and ", "/")
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn diagram() -> Campbell {
        let mode = |mode: usize, frequencies: [f64; 3], mesh_share: f64| ModeLine {
            mode,
            frequencies: frequencies.to_vec(),
            mesh_share,
        };
        let ray = |name: &str, order: f64, of_mesh: bool| Ray {
            name: name.into(),
            order,
            of_mesh,
        };
        Campbell {
            job: "case".into(),
            unit: Some("rpm".into()),
            words: "load 0.1".into(),
            grid: [TAU * 80.0, TAU * 180.0],
            speeds: vec![TAU * 10.0, TAU * 100.0, TAU * 200.0],
            open: vec![mode(1, [500.0; 3], 0.0)],
            // The second frequency rises with the speed.
            closed: vec![
                mode(1, [2000.0; 3], 0.9),
                mode(2, [2910.0, 3000.0, 3100.0], 0.01),
            ],
            rays: vec![
                ray("1 × mesh", 20.0, true),
                ray("2 × mesh", 40.0, true),
                ray("pinion", 1.0, false),
            ],
        }
    }

    #[test]
    fn resonances_are_where_rays_meet_modes_in_or_near_the_grid() {
        use Contacts::{Closed, Open};
        let crossings = |diagram: &Campbell| -> Vec<(String, Contacts, usize)> {
            let found = diagram.resonances().into_iter();
            found
                .map(|one| (one.excitation, one.contacts, one.mode))
                .collect()
        };
        let resonance = |ray: &str, contacts, mode| (ray.to_owned(), contacts, mode);
        let mut diagram = diagram();
        let found = diagram.resonances();
        // Order 2 × mesh meets the first mode at 50 and the second at 73.7 revolutions per second. Only the second
        // meeting is within a tenth of 80.
        let near = [
            resonance("2 × mesh", Closed, 2),
            resonance("1 × mesh", Closed, 1),
            resonance("1 × mesh", Closed, 2),
        ];
        assert_eq!(crossings(&diagram), near);
        assert!((found[1].speed / TAU - 100.0).abs() < 1e-9);
        // 20 n = 2900 + n between 100 and 200 revolutions per second.
        assert!((found[2].speed / TAU - 2900.0 / 19.0).abs() < 1e-9);
        assert!((found[2].frequency - 20.0 * 2900.0 / 19.0).abs() < 1e-6);
        // Orders 1 and 2 of the mesh meet the open mode of 500 Hz at 25 and 12.5 revolutions per second.
        diagram.grid = [TAU * 27.0, TAU * 30.0];
        assert_eq!(crossings(&diagram), [resonance("1 × mesh", Open, 1)]);
        diagram.grid = [TAU * 28.0, TAU * 30.0];
        assert_eq!(crossings(&diagram), []);
    }

    #[test]
    fn the_diagram_names_rays_resonances_and_units() {
        use crate::report::plot::canvas::Shape;
        let canvas = diagram().draw(&Display::default());
        let shapes = &canvas.pictures[0].canvas.shapes;
        let texts: Vec<&str> = (shapes.iter())
            .filter_map(|shape| match shape {
                Shape::Text { text, .. } => Some(&**text),
                _ => None,
            })
            .collect();
        for wanted in [
            "speed [rpm]",
            "frequency [kHz]",
            "2 × mesh",
            "resonances within ± 10 % of the grid:",
            "3 with contacts closed",
            "0 with contacts open: grey",
            "6000 rpm: 1 × mesh, mode 1",
        ] {
            assert!(texts.contains(&wanted), "{wanted} is not in {texts:?}");
        }
        let discs = shapes
            .iter()
            .filter(|shape| matches!(shape, Shape::Disc { .. }));
        assert_eq!(discs.count(), 6);
    }
}
