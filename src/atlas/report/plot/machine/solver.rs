//! Depth and breadth: a cycle's time over modes on one thread, and the gain from threads.

use super::super::axis::{Axis, range};
use super::super::canvas::{Anchor, Canvas, Colour, INK, SOFT};
use super::super::categories::colour;
use super::super::panel::{LABEL_SIZE, Panel};
use super::bandwidth::threads;
use super::{Curve, draw_curves, logarithmic, titled};
use crate::report::plot::picture::Picture;
use crate::store::{Characteristics, Measurement, SolverKey};

/// Modes at which the gain from threads is shown, where it was measured.
const MODES: u64 = 40;

/// A shade darker where every operating point has tables of its own.
const KERNELS: [(&str, usize); 3] = [("volterra", 3), ("spectral", 0), ("fused", 4)];

pub(super) fn draw(machine: &Characteristics) -> Option<Picture> {
    let modes = machine.solver.iter().map(|row| row.key.modes);
    let modes = modes.min_by_key(|modes| modes.abs_diff(MODES))?;
    let mut canvas = titled(
        "Depth and breadth: modes of a trajectory, threads of a campaign",
        machine,
    );
    depth(&mut canvas, machine);
    breadth(&mut canvas, machine, modes);
    Some(Picture::new("machine-solver".into(), canvas))
}

/// A curve of every kernel and kind of tables, where it has places.
fn curves(
    machine: &Characteristics,
    wanted: impl Fn(&Measurement<SolverKey>) -> bool,
    place: impl Fn(&Measurement<SolverKey>) -> Option<[f64; 2]>,
) -> Vec<Curve> {
    let mut curves = Vec::new();
    for (kernel, number) in KERNELS {
        for (tables, name) in [
            ("shared", "one table"),
            ("node", "one a node"),
            ("eight", "eight tables"),
        ] {
            let own = |row: &&Measurement<SolverKey>| {
                row.key.kernel == kernel && row.key.tables == tables && wanted(row)
            };
            let places: Vec<[f64; 2]> = machine
                .solver
                .iter()
                .filter(own)
                .filter_map(&place)
                .collect();
            if !places.is_empty() {
                curves.push(Curve {
                    name: format!("{kernel}, {name}"),
                    colour: match tables {
                        "shared" => colour(number),
                        _ => darker(colour(number), tables == "eight"),
                    },
                    places,
                });
            }
        }
    }
    curves
}

fn darker(Colour(r, g, b): Colour, much: bool) -> Colour {
    let part = if much { 0.55 } else { 0.78 };
    let dim = |channel: u8| (part * f64::from(channel)) as u8;
    Colour(dim(r), dim(g), dim(b))
}

fn depth(canvas: &mut Canvas, machine: &Characteristics) {
    let curves = curves(
        machine,
        |row| row.key.threads == 1,
        |row| Some([row.key.modes as f64, 1.0 / row.figure.value]),
    );
    if curves.is_empty() {
        return;
    }
    let [low, high] = range(curves.iter().flat_map(|c| c.places.iter().map(|p| p[0])));
    let panel = Panel {
        left: 80.0,
        right: 300.0,
        top: 96.0,
        bottom: 536.0,
        across: Axis::logarithmic("modes", "1", [low / 1.15, high * 1.15]),
        up: logarithmic("time of a mesh cycle", "s", curves.iter()),
    };
    panel.frame(canvas, true);
    canvas.text(
        [panel.left, 86.0],
        "depth, one thread",
        LABEL_SIZE,
        INK,
        Anchor::Start,
    );
    draw_curves(canvas, &panel, &curves);
}

fn breadth(canvas: &mut Canvas, machine: &Characteristics, modes: u64) {
    let mut curves = curves(
        machine,
        |row| row.key.modes == modes,
        |row| {
            let threads = row.key.threads as f64;
            Some([threads, row.key.efficiency? * threads])
        },
    );
    let places = || curves.iter().flat_map(|curve| &curve.places);
    let most = range(places().map(|place| place[0]))[1];
    let highest = range(places().map(|place| place[1]))[1].max(most);
    if curves.is_empty() {
        return;
    }
    let across = threads(most);
    let up = match most > 8.0 {
        true => Axis::logarithmic("gain over one thread", "1", [0.8, 1.15 * highest]),
        false => Axis::linear("gain over one thread", "1", [0.0, 1.1 * highest]),
    };
    let panel = Panel {
        left: 560.0,
        right: 800.0,
        top: 96.0,
        bottom: 536.0,
        across,
        up,
    };
    panel.frame(canvas, true);
    let title = format!("breadth, {modes} modes");
    canvas.text([panel.left, 86.0], &title, LABEL_SIZE, INK, Anchor::Start);
    curves.push(Curve {
        name: "ideal".to_owned(),
        colour: SOFT,
        places: vec![[1.0, 1.0], [most, most]],
    });
    draw_curves(canvas, &panel, &curves);
}
