//! How far is a load from the next kink of its law?
//!
//! Under a given force all quantities of a mesh are smooth in the mesh phase while the same parts of the same pairs are
//! in contact. A pair takes up load at one end of its face, and later is in contact all along the face. Pairs also swap
//! their order of contact. At each of these phases a difference of two lengths changes its sign.

use super::LoadSharing;

/// Margin of a comparison that has no effect.
const FAR: f64 = 1.0;

impl LoadSharing {
    /// The margins of [`Self::distribute_with_margins`] for independent slices, at an approach.
    pub(super) fn margins(&self, approach: f64) -> Vec<f64> {
        let mut margins = Vec::new();
        if !self.spans.is_empty() {
            return margins;
        }
        // If no gap varies across the face except by misalignment, the slices form one ramp.
        let slices = if self.even { self.face.slices } else { 1 };
        for zone in self.ramps.chunks(slices * self.pairs) {
            let of = |pair: usize| {
                let ramps = zone.iter().filter(move |ramp| ramp.pair == pair);
                ramps.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], ramp| {
                    [low.min(ramp.low), high.max(ramp.high)]
                })
            };
            let reach: Vec<[f64; 2]> = (0..self.pairs).map(of).collect();
            margins.extend(reach.iter().flat_map(|ends| ends.map(|end| approach - end)));
            let partly = |[low, high]: [f64; 2]| approach >= low && approach < high;
            for (one, a) in reach.iter().enumerate() {
                for b in &reach[one + 1..] {
                    let matters = partly(*a) || partly(*b);
                    margins.push(if matters { a[0] - b[0] } else { FAR });
                }
            }
        }
        margins.extend(&self.line_load_excess[..self.pairs]);
        margins
    }
}
