//! Scaling of the speed of integration: the time of a mesh cycle over modes and over operating points, and
//! the gain from threads.

use super::super::axis::{Axis, range};
use super::super::canvas::{Anchor, Canvas, Colour, INK, SOFT};
use super::super::categories::colour;
use super::super::panel::{LABEL_SIZE, Panel};
use super::bandwidth::threads;
use super::{Curve, draw_curves, logarithmic, titled};
use crate::report::plot::picture::Picture;
use crate::store::{Characteristics, Measurement, SolverKey};

/// Number of modes for the scaling over points and threads; if it was not measured, the nearest number that
/// was.
const MODES: u64 = 40;

/// Width and left ends of the three panels \[px\].
const WIDTH: f64 = 170.0;
const LEFT: [f64; 3] = [76.0, 384.0, 690.0];

type Row = Measurement<SolverKey>;

pub(super) fn draw(machine: &Characteristics) -> Option<Picture> {
    let modes = machine.solver.iter().map(|row| row.key.modes);
    let modes = modes.min_by_key(|modes| modes.abs_diff(MODES))?;
    // Only the scaling over points, at `modes` modes, varies the number of points. All other rows have the
    // usual number.
    let usual = machine.solver.iter().filter(|row| row.key.modes != modes);
    let usual = usual.map(|row| row.key.points).next();
    let usual = usual.unwrap_or(machine.solver[0].key.points);
    let title = "Depth and breadth: modes of a trajectory, points and threads of a campaign";
    let mut canvas = titled(title, machine);
    let note = "blue: closed_modes, by the sharing of its tables";
    canvas.label([LEFT[0] - 40.0, 66.0], note, SOFT);
    let time = |row: &Row| 1.0 / row.figure.value;

    let depth = curves(machine, |row| {
        let wanted = row.key.threads == 1 && row.key.points == usual;
        wanted.then(|| [row.key.modes as f64, time(row)])
    });
    times(
        &mut canvas,
        LEFT[0],
        "depth: modes, one thread",
        "modes",
        &depth,
    );

    let mut breadth = curves(machine, |row| {
        let wanted = row.key.threads == 1 && row.key.modes == modes;
        wanted.then(|| [row.key.points as f64, time(row)])
    });
    breadth.retain(|curve| curve.places.len() > 1);
    let head = format!("breadth: points, {modes} modes, one thread");
    times(&mut canvas, LEFT[1], &head, "operating points", &breadth);

    let gains = curves(machine, |row| {
        let threads = row.key.threads as f64;
        let wanted = row.key.points == usual && row.key.modes == modes;
        wanted.then_some([threads, row.key.efficiency * threads])
    });
    gain(
        &mut canvas,
        &format!("breadth: threads, {modes} modes"),
        gains,
    );
    Some(Picture::new("machine-solver".into(), canvas))
}

/// The number of the colour of a kernel.
pub(super) fn kernel_colour(kernel: &str) -> usize {
    if kernel == "volterra" { 3 } else { 0 }
}

/// One curve for `volterra`, and one per sharing of the tables of `closed_modes`. `place` gives the place of a row;
/// `None` to leave it out.
fn curves(machine: &Characteristics, place: impl Fn(&Row) -> Option<[f64; 2]>) -> Vec<Curve> {
    let mut curves: Vec<Curve> = Vec::new();
    for row in &machine.solver {
        let Some(place) = place(row) else {
            continue;
        };
        let name = match row.key.kernel.as_str() {
            "volterra" => "volterra".to_owned(),
            _ => row.key.tables.clone(),
        };
        match curves.iter_mut().find(|curve| curve.name == name) {
            Some(curve) => curve.places.push(place),
            None => curves.push(Curve {
                name,
                colour: shade(colour(kernel_colour(&row.key.kernel)), &row.key.tables),
                places: vec![place],
            }),
        }
    }
    for curve in &mut curves {
        curve.places.sort_by(|a, b| a[0].total_cmp(&b[0]));
    }
    curves
}

/// The colour for a sharing of tables: darker if each node has a copy, and darkest if each thread has one.
fn shade(Colour(r, g, b): Colour, tables: &str) -> Colour {
    let part = match tables {
        "node" => 0.75,
        "private" => 0.55,
        _ => 1.0,
    };
    let dim = |channel: u8| (part * f64::from(channel)) as u8;
    Colour(dim(r), dim(g), dim(b))
}

fn panel(left: f64, across: Axis, up: Axis) -> Panel {
    Panel::new([left, left + WIDTH], [96.0, 536.0], across, up)
}

fn head(canvas: &mut Canvas, panel: &Panel, text: &str) {
    let at = [panel.left - 40.0, 86.0];
    canvas.text(at, text, LABEL_SIZE, INK, Anchor::Start);
}

fn times(canvas: &mut Canvas, left: f64, name: &str, across: &str, curves: &[Curve]) {
    if curves.is_empty() {
        return;
    }
    let [low, high] = range(curves.iter().flat_map(|c| c.places.iter().map(|p| p[0])));
    let across = Axis::logarithmic(across, "1", [low / 1.15, high * 1.15]);
    let panel = panel(
        left,
        across,
        logarithmic("time of a mesh cycle", "s", curves.iter()),
    );
    panel.frame(canvas, true);
    head(canvas, &panel, name);
    draw_curves(canvas, &panel, curves);
}

fn gain(canvas: &mut Canvas, name: &str, mut curves: Vec<Curve>) {
    if curves.is_empty() {
        return;
    }
    let places = || curves.iter().flat_map(|curve| &curve.places);
    let most = range(places().map(|place| place[0]))[1];
    let highest = range(places().map(|place| place[1]))[1].max(most);
    let up = if most > 8.0 {
        Axis::logarithmic("gain over one thread", "1", [0.8, 1.15 * highest])
    } else {
        Axis::linear("gain over one thread", "1", [0.0, 1.1 * highest])
    };
    let panel = panel(LEFT[2], threads(most), up);
    panel.frame(canvas, true);
    head(canvas, &panel, name);
    curves.push(Curve {
        name: "ideal".to_owned(),
        colour: SOFT,
        places: vec![[1.0, 1.0], [most, most]],
    });
    draw_curves(canvas, &panel, &curves);
}
