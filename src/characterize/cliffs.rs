//! Where a cost jumps as the working set grows, and which cache that is.
//!
//! Costs are compared over steps of the working set. A cliff is an unbroken climb by a quarter
//! or more altogether; it stands where the cost passes the geometric middle between its foot and
//! its top. It belongs to the reported cache whose size is nearest, if it is within a factor of
//! two.

use crate::topology::Cache;

/// A climb by less than this is none.
const LEAST_RISE: f64 = 1.25;

/// A step that rises by less than this ends a climb.
const LEAST_STEP: f64 = 1.04;

/// Factor between a cliff and the size of its cache.
const NEAR: f64 = 2.0;

/// A jump of the cost.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Jump {
    /// Working set at the middle of the jump \[bytes\].
    pub size: f64,
    /// Working set before and after it \[bytes\].
    pub between: [f64; 2],
    /// Cost after over cost before.
    pub ratio: f64,
}

/// The jumps of a curve (working set, cost), in ascending order of the working set.
pub fn jumps(curve: &[[f64; 2]]) -> Vec<Jump> {
    let mut found = Vec::new();
    let mut foot = 0;
    while foot + 1 < curve.len() {
        let mut top = foot;
        while top + 1 < curve.len() && curve[top + 1][1] >= LEAST_STEP * curve[top][1] {
            top += 1;
        }
        let ratio = curve[top][1] / curve[foot][1];
        if top > foot && ratio >= LEAST_RISE {
            found.push(Jump {
                size: middle(&curve[foot..=top]),
                between: [curve[foot][0], curve[top][0]],
                ratio,
            });
        }
        foot = top.max(foot + 1);
    }
    found
}

/// Where a climb passes the geometric middle of its ends, interpolated in logarithms.
fn middle(climb: &[[f64; 2]]) -> f64 {
    let (first, last) = (climb[0], climb[climb.len() - 1]);
    let half = (first[1] * last[1]).sqrt();
    let pair = climb
        .windows(2)
        .find(|pair| pair[1][1] >= half)
        .unwrap_or(&climb[climb.len() - 2..]);
    let part = (half / pair[0][1]).ln() / (pair[1][1] / pair[0][1]).ln();
    pair[0][0] * (pair[1][0] / pair[0][0]).powf(part)
}

/// The cache that a jump belongs to.
pub fn cache_of(jump: &Jump, caches: &[Cache]) -> Option<usize> {
    let distance = |cache: &&Cache| (jump.size / cache.size as f64).ln().abs();
    caches
        .iter()
        .filter(|cache| cache.size > 0)
        .min_by(|a, b| distance(a).total_cmp(&distance(b)))
        .filter(|cache| distance(cache) <= NEAR.ln())
        .map(|cache| cache.level)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cache(level: usize, size: u64) -> Cache {
        Cache {
            level,
            size,
            line: Some(64),
            count: 1,
            shared_by: 1,
        }
    }

    /// Flat, ×2 beyond 48 KiB, ×3 beyond 35 MB, with two per cent of noise.
    fn curve() -> Vec<[f64; 2]> {
        (0..40)
            .map(|i| {
                let size = 8192.0 * 2f64.powf(f64::from(i) / 2.0);
                let cost = match size {
                    size if size < 49152.0 => 1.0,
                    size if size < 35e6 => 2.0,
                    _ => 6.0,
                };
                [size, cost * (1.0 + 0.02 * f64::from(i % 2))]
            })
            .collect()
    }

    #[test]
    fn steps_are_found_at_their_caches() {
        let caches = [cache(1, 49152), cache(2, 2 << 20), cache(3, 35 << 20)];
        let found = jumps(&curve());
        assert_eq!(found.len(), 2, "{found:?}");
        for (jump, (level, size, ratio)) in found.iter().zip([(1, 49152.0, 2.0), (3, 35e6, 3.0)]) {
            assert_eq!(cache_of(jump, &caches), Some(level));
            assert!(jump.between[0] < size && size < jump.between[1] * 1.01);
            assert!((jump.size / size).ln().abs() < 0.4, "{jump:?}");
            assert!((jump.ratio / ratio - 1.0).abs() < 0.05, "{jump:?}");
        }
    }

    #[test]
    fn a_jump_far_from_any_cache_belongs_to_none() {
        let jump = Jump {
            size: 512e3,
            between: [4e5, 6e5],
            ratio: 2.0,
        };
        assert_eq!(cache_of(&jump, &[cache(1, 49152), cache(2, 2 << 20)]), None);
        assert_eq!(cache_of(&jump, &[]), None);
    }

    #[test]
    fn flat_and_falling_curves_have_none() {
        let flat: Vec<[f64; 2]> = (1..20).map(|i| [f64::from(i), 5.0]).collect();
        assert_eq!(jumps(&flat), []);
        let falling: Vec<[f64; 2]> = (1..20)
            .map(|i| [f64::from(i), 1.0 / f64::from(i)])
            .collect();
        assert_eq!(jumps(&falling), []);
        assert_eq!(jumps(&[[1.0, 1.0]]), []);
        assert_eq!(jumps(&[]), []);
    }
}
