//! How the pairs of teeth share the load over the mesh phase: a panel a torque, a line a pair.

use super::data::MeshCurves;
use super::labels::{self, Named};
use super::spread;
use crate::report::plot::axis::Axis;
use crate::report::plot::canvas::{Anchor, Canvas, INK};
use crate::report::plot::categories::colour;
use crate::report::plot::error::PlotError;
use crate::report::plot::panel::{Panel, TICK_SIZE};
use crate::report::plot::picture::{Drawn, Picture};
use crate::report::plot::what::What;

/// Pairs of teeth that a table keeps.
const PAIRS: usize = 3;
/// Colours of the pairs: dark enough for lines.
const COLOURS: [usize; PAIRS] = [0, 3, 4];
/// Most panels.
const MOST: usize = 3;
const LEFT: f64 = 92.0;
const RIGHT: f64 = 855.0;
const TOP: f64 = 96.0;
const HEIGHT: f64 = 150.0;
const GAP: f64 = 40.0;

pub(super) fn draw(mesh: &MeshCurves) -> Result<Drawn, PlotError> {
    let aligned = mesh.aligned();
    let torques = spread(mesh.torque.len(), MOST);
    let title = format!("{}: load shares of the pairs of teeth", mesh.name);
    let held = mesh.misalignment_text(aligned);
    let mut canvas = Canvas::titled(&title, &format!("{held}  ·  pair 0 came into contact last"));
    let mut top = TOP;
    for (place, &torque) in torques.iter().enumerate() {
        let pair = |pair: usize| {
            Some(Named {
                curve: mesh.curve("share", [aligned, torque], [pair, PAIRS])?,
                name: format!("pair {pair}"),
                colour: colour(COLOURS[pair]),
            })
        };
        let mut lines: Vec<Named> = (0..PAIRS).filter_map(pair).collect();
        if lines.is_empty() {
            return Err(PlotError::Unfit {
                what: What::Sharing,
                reason: "the table has no array `share` with three values at every node".into(),
            });
        }
        // At a contact ratio below 2 the third pair never bears anything.
        lines.retain(|line| line.curve.iter().any(|[_, share]| share.abs() > 1e-9));
        let panel = Panel {
            left: LEFT,
            right: RIGHT,
            top,
            bottom: top + HEIGHT,
            across: Axis::linear("mesh phase", "1", [0.0, 1.0]),
            up: Axis::linear("load share", "1", [-0.05, 1.05]),
        };
        panel.frame(&mut canvas, place + 1 == torques.len());
        let at = [LEFT, top - 8.0];
        canvas.text(at, &mesh.torque_text(torque), TICK_SIZE, INK, Anchor::Start);
        labels::draw(&mut canvas, &panel, &lines, "");
        top += HEIGHT + GAP;
    }
    canvas.height = top - GAP + 64.0;
    let name = format!("{}-sharing", mesh.name);
    Ok(Drawn::one(Picture::new(name, canvas)))
}
