//! Load shares of the pairs of teeth over the mesh phase: a panel for each of some torques, one line per pair.

use super::data::{Curve, MeshCurves};
use super::labels::{self, Named};
use super::spread;
use crate::gear::MOST_PAIRS;
use crate::report::plot::axis::Axis;
use crate::report::plot::canvas::{Canvas, INK};
use crate::report::plot::categories::colour;
use crate::report::plot::panel::{LEFT, Panel};
use crate::report::plot::picture::Drawn;
use std::collections::BTreeMap;

/// Numbers of the colours of the pairs; these colours are dark enough for lines.
const COLOURS: [usize; MOST_PAIRS] = [0, 3, 4];
/// Tolerance for the shares of one pair on both sides of a piece's end.
const SAME_PAIR: f64 = 1e-6;
/// Largest number of panels.
const MOST_PANELS: usize = 3;
const RIGHT: f64 = 855.0;
const TOP: f64 = 96.0;
const HEIGHT: f64 = 150.0;
const GAP: f64 = 40.0;

pub(super) fn draw(mesh: &MeshCurves) -> Drawn {
    let aligned = mesh.aligned();
    let torques = spread(mesh.table.torque.len(), MOST_PANELS);
    let title = format!("{}: load shares of the pairs of teeth", mesh.name);
    let held = mesh.misalignment_text(aligned);
    let mut canvas = Canvas::titled(
        &title,
        &format!("{held}  ·  pair 0 is the last pair that came into contact before mesh phase 0"),
    );
    let mut top = TOP;
    for (place, &torque) in torques.iter().enumerate() {
        let slots: Vec<Curve> = (0..MOST_PAIRS)
            .map(|pair| mesh.curve(&mesh.table.share, [aligned, torque], [pair, MOST_PAIRS]))
            .collect();
        // If the contact ratio is below 2, the third pair never carries load.
        let is_loaded = |curve: &Curve| curve.iter().any(|[_, share]| share.abs() > 1e-9);
        let lines: Vec<Named> = (shares_by_pair(&slots, mesh.table.breaks.len() - 1).into_iter())
            .filter(|(_, curve)| is_loaded(curve))
            .map(|(pair, curve)| Named {
                curve,
                name: match pair {
                    -1 => "next pair".to_owned(),
                    _ => format!("pair {pair}"),
                },
                colour: colour(COLOURS[pair.rem_euclid(MOST_PAIRS as i32) as usize]),
            })
            .collect();
        let panel = Panel::new(
            [LEFT, RIGHT],
            [top, top + HEIGHT],
            Axis::linear("mesh phase", "1", [0.0, 1.0]),
            Axis::linear("load share", "1", [-0.05, 1.05]),
        );
        panel.frame(&mut canvas, place + 1 == torques.len());
        canvas.label([LEFT, top - 8.0], &mesh.torque_text(torque), INK);
        labels::draw(&mut canvas, &panel, &lines, "");
        top += HEIGHT + GAP;
    }
    canvas.height = top - GAP + 64.0;
    let name = format!("{}-sharing", mesh.name);
    Drawn::one(name, canvas)
}

/// The load share of each pair, by the number of the pair. `slots` are the shares in the order of the table:
/// the newest pair, the pair before it, and so on. All curves have the same number of samples on each piece
/// of the cycle. When a new pair comes within reach, every other pair moves to the next slot. The code finds these
/// mesh phases from the condition that the share of every pair is continuous.
fn shares_by_pair(slots: &[Curve], pieces: usize) -> BTreeMap<i32, Curve> {
    let samples = slots[0].len() / pieces;
    let mut shares_by_pair: BTreeMap<i32, Curve> = BTreeMap::new();
    let mut new_pairs = 0;
    for piece in 0..pieces {
        let first = piece * samples;
        if piece > 0 {
            let before: Vec<f64> = slots.iter().map(|slot| slot[first - 1][1]).collect();
            let behind: Vec<f64> = slots.iter().map(|slot| slot[first][1]).collect();
            let step = |behind: &[f64], before: &[f64]| -> f64 {
                let pairs = behind.iter().zip(before);
                pairs.map(|(behind, before)| (behind - before).abs()).sum()
            };
            let share_dropped = before[before.len() - 1];
            let up = step(&behind[1..], &before) + behind[0].abs() + share_dropped.abs();
            if up + SAME_PAIR < step(&behind, &before) {
                new_pairs += 1;
            }
        }
        for (slot, pair) in slots.iter().zip(-new_pairs..) {
            let shares = &slot[first..first + samples];
            shares_by_pair.entry(pair).or_default().extend(shares);
        }
    }
    shares_by_pair
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A pair comes within reach at 0.8 of the cycle and carries no load before its end. It does not take over the line
    /// of another pair.
    #[test]
    fn a_pair_keeps_its_line_where_the_next_one_comes() {
        let curve = |values: [f64; 6]| -> Curve {
            let phases = [0.0, 0.5, 0.5, 0.8, 0.8, 1.0];
            phases
                .into_iter()
                .zip(values)
                .map(|(at, share)| [at, share])
                .collect()
        };
        let slots = [
            curve([0.4, 0.7, 0.7, 1.0, 0.0, 0.4]),
            curve([0.6, 0.3, 0.3, 0.0, 1.0, 0.6]),
            curve([0.0; 6]),
        ];
        let found = shares_by_pair(&slots, 3);
        let shares = |pair: i32| -> Vec<f64> { found[&pair].iter().map(|at| at[1]).collect() };
        assert_eq!(shares(0), [0.4, 0.7, 0.7, 1.0, 1.0, 0.6]);
        assert_eq!(shares(1), [0.6, 0.3, 0.3, 0.0, 0.0, 0.0]);
        assert_eq!(shares(-1), [0.0, 0.4]);
        assert_eq!(found.len(), 4);
    }
}
