//! How are the slices of a face coupled elastically? Displacements of the teeth and bodies of a pair under loads that
//! vary along the face, in waves.
//!
//! A line load `Σ q_n φ_n(t)` on one pair, t = z/b + ½ the place on a face of width b,
//!
//! ```text
//! φ_0 = 1,   φ_n = √2 cos(n π t)
//! ```
//!
//! moves the pairs by `Σ_nm C_nm q_m φ_n(t)`. Teeth and bodies are solids with free ends ([`super::solid`]). A uniform
//! load is assumed to displace the pairs like plane gears and to cause none of the other waves. Under a uniform load
//! the slices are therefore independent.

use super::body::series;
use super::solid::{SolidGear, wave_count};
use crate::gear::{Flanks, MOST_PAIRS, PathOfContact, Tooth};
use crate::numerics::legendre;
use crate::numerics::quadrature::GaussLegendre;
use faer::Mat;
use std::sync::OnceLock;

/// Number of positions on the path of contact at which the pair is solved.
const NODES: usize = 9;

/// Number of terms of the series through these positions; the omitted terms are below 1e-4 of the first.
const TERMS: usize = 7;

/// Compliance of a pair of gears to loads that vary along the face, solved at the first use.
#[derive(Debug, Clone)]
pub struct FaceCoupling {
    flanks: Box<Flanks>,
    solved: OnceLock<Option<Solved>>,
}

/// Any two values compare as equal: the coupling follows from the drawing, and [`Flanks`] compares drawings.
impl PartialEq for FaceCoupling {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

/// Compliances as series along the path of contact; rows and columns are the waves from the first on.
#[derive(Debug, Clone)]
struct Solved {
    same_pair: PositionSeries,
    /// Compliances between pairs 1, 2 … base pitches apart, as functions of the position of the pair behind.
    ahead: Vec<PositionSeries>,
}

/// Legendre series of a matrix between two positions.
#[derive(Debug, Clone)]
struct PositionSeries {
    range: [f64; 2],
    wave_count: usize,
    series: Vec<Vec<f64>>,
}

impl FaceCoupling {
    /// The compliance of spur gears on their common face.
    pub(in crate::gear) fn of(flanks: &Flanks) -> Self {
        Self {
            flanks: Box::new(flanks.clone()),
            solved: OnceLock::new(),
        }
    }

    /// Number of waves besides the uniform one, n ≥ 1.
    pub fn wave_count(&self) -> usize {
        let height = |tooth: &Tooth| tooth.tip_radius - tooth.root_radius;
        let lowest = height(&self.flanks.teeth[0]).min(height(&self.flanks.teeth[1]));
        wave_count(self.flanks.face_width / lowest) - 1
    }

    /// Matrix `C_nm` of the waves n, m ≥ 1 for a pair at position s \[m\], symmetric \[m²/N\]. Positions beyond the
    /// path of contact count as its end. As for plane gears, the displacement is taken where the line of force crosses
    /// the centre line of each tooth. `None` if the numbers are not finite.
    pub fn of_pair(&self, s: f64) -> Option<Mat<f64>> {
        Some(self.solved()?.same_pair.at(s))
    }

    /// Displacements of the pair at position s, by rows, under waves of load on the pair `ahead` base pitches
    /// further, by columns \[m²/N\]. The transpose exchanges the pairs. `None` unless 1 ≤ `ahead` < [`MOST_PAIRS`].
    pub fn coupling(&self, s: f64, ahead: usize) -> Option<Mat<f64>> {
        Some(self.solved()?.ahead.get(ahead.checked_sub(1)?)?.at(s))
    }

    fn solved(&self) -> Option<&Solved> {
        self.solved.get_or_init(|| self.solve()).as_ref()
    }

    fn solve(&self) -> Option<Solved> {
        let PathOfContact {
            start,
            end,
            base_pitch,
            ..
        } = self.flanks.path();
        let rule = GaussLegendre::new(NODES);
        let places = |[low, high]: [f64; 2]| -> Vec<f64> {
            let place = |x: &f64| 0.5 * (low + high) + 0.5 * (high - low) * x;
            rule.nodes.iter().map(place).collect()
        };
        // The first positions are those of a single pair. Then follow, for each distance of two pairs, the positions
        // of the pair behind and those of the pair ahead.
        let ranges: Vec<[f64; 2]> = (0..MOST_PAIRS)
            .map(|ahead| [start, (end - ahead as f64 * base_pitch).max(start)])
            .collect();
        let mut positions = places(ranges[0]);
        for (ahead, range) in ranges.iter().enumerate().skip(1) {
            let near = places(*range);
            positions.extend(&near);
            positions.extend(near.iter().map(|s| s + ahead as f64 * base_pitch));
        }
        let total_wave_count = self.wave_count() + 1;
        let flanks = &self.flanks;
        let materials = &flanks.pair.form.material;
        let gears: Vec<SolidGear> = [0, 1]
            .into_iter()
            .map(|gear| {
                let tooth = &flanks.teeth[gear];
                let rolls: Vec<f64> = positions.iter().map(|s| flanks.roll(*s)[gear]).collect();
                SolidGear::new(
                    tooth,
                    flanks.pair.teeth[gear],
                    2.0 * tooth.root_radius / flanks.bores[gear],
                    materials[gear].poisson_ratio,
                    flanks.face_width,
                    total_wave_count,
                    &rolls,
                )
            })
            .collect::<Option<_>>()?;
        let modulus = [0, 1].map(|gear| materials[gear].young_modulus);
        // Displacements refer to the centre line and loads to the flank, so the matrix is not exactly symmetric. Take
        // the symmetric part.
        let same_pair = PositionSeries::new(&rule, ranges[0], total_wave_count - 1, |node| {
            Mat::from_fn(total_wave_count - 1, total_wave_count - 1, |i, j| {
                let of = |gear: usize, i: usize, j: usize| {
                    gears[gear].same_tooth[node][(i + 1, j + 1)] / modulus[gear]
                };
                0.5 * (of(0, i, j) + of(1, i, j) + of(0, j, i) + of(1, j, i))
            })
        });
        let ahead = (1..MOST_PAIRS)
            .map(|ahead| {
                let first = NODES * (2 * ahead - 1);
                PositionSeries::new(&rule, ranges[ahead], total_wave_count - 1, |node| {
                    let (near, far) = (first + node, first + NODES + node);
                    // On the wheel the order is reversed: the tooth of the pair behind is the tooth ahead.
                    let pinion = gears[0].coupling(ahead, [far, near]);
                    let wheel = gears[1].coupling(ahead, [near, far]);
                    Mat::from_fn(total_wave_count - 1, total_wave_count - 1, |i, j| {
                        pinion[(j + 1, i + 1)] / modulus[0] + wheel[(i + 1, j + 1)] / modulus[1]
                    })
                })
            })
            .collect();
        Some(Solved { same_pair, ahead })
    }
}

impl PositionSeries {
    fn new(
        rule: &GaussLegendre,
        range: [f64; 2],
        wave_count: usize,
        at: impl Fn(usize) -> Mat<f64>,
    ) -> Self {
        let matrices: Vec<Mat<f64>> = (0..NODES).map(at).collect();
        let entry = |entry: usize| {
            let value = |node: usize| matrices[node][(entry % wave_count, entry / wave_count)];
            series(rule, TERMS, &value, 1.0)
        };
        Self {
            range,
            wave_count,
            series: (0..wave_count * wave_count).map(entry).collect(),
        }
    }

    fn at(&self, s: f64) -> Mat<f64> {
        let [low, high] = self.range;
        let s = s.clamp(low, high);
        let place = if high > low { (2.0 * s - low - high) / (high - low) } else { 0.0 };
        let mut polynomials = [0.0; TERMS];
        legendre::polynomials(place, &mut polynomials);
        Mat::from_fn(self.wave_count, self.wave_count, |i, j| {
            let series = &self.series[j * self.wave_count + i];
            series.iter().zip(&polynomials).map(|(a, p)| a * p).sum()
        })
    }
}
