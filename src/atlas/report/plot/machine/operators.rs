//! Rotating tables: the cost of a dense product against its working set, and that of a window of
//! the structured kernel.

use super::super::categories::colour;
use super::super::panel::Panel;
use super::{Curve, draw_curves, logarithmic, mark_caches, sizes, titled};
use crate::report::plot::picture::Picture;
use crate::store::Characteristics;

pub(super) fn draw(machine: &Characteristics) -> Option<Picture> {
    let mut curves: Vec<Curve> = Vec::new();
    for row in &machine.operators {
        let name = match row.key.kernel.as_str() {
            "matvec" => format!("product, dimension {}", row.key.dimension),
            "volterra" => "volterra window".to_owned(),
            other => other.replacen("volterra", "volterra window", 1),
        };
        let place = [row.key.working_set as f64, row.figure.value];
        match curves.iter_mut().find(|curve| curve.name == name) {
            Some(curve) => curve.places.push(place),
            None => curves.push(Curve {
                name,
                colour: colour(0),
                places: vec![place],
            }),
        }
    }
    if curves.is_empty() {
        return None;
    }
    // Blues and greens for products, warm colours for the structured kernel.
    let (mut cool, mut warm) = ([0, 2, 4].into_iter().cycle(), [3, 1].into_iter().cycle());
    for curve in &mut curves {
        let number = match curve.name.starts_with("volterra") {
            true => warm.next(),
            false => cool.next(),
        };
        curve.colour = colour(number.unwrap_or_default());
    }
    let title = "What a product costs while tables rotate";
    let mut canvas = titled(title, machine);
    let panel = Panel {
        left: 92.0,
        right: 740.0,
        top: 86.0,
        bottom: 536.0,
        across: sizes("working set: all tables in rotation", curves.iter()),
        up: logarithmic("time of a product or window", "s", curves.iter()),
    };
    panel.frame(&mut canvas, true);
    mark_caches(&mut canvas, &panel, machine);
    draw_curves(&mut canvas, &panel, &curves);
    Some(Picture::new("machine-operators".into(), canvas))
}
