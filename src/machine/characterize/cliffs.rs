//! Where a cost jumps as the working set grows, and which cache that is.
//!
//! Costs are compared over steps of the working set. A cliff is an unbroken climb by a quarter
//! or more altogether; it stands where the cost passes the geometric middle between its foot and
//! its top. It belongs to the reported cache whose size is nearest, if it is within a factor of
//! two.

use crate::store::Cliff;
use crate::topology::Cache;

/// A climb by less than this is none.
const LEAST_RISE: f64 = 1.25;

/// A step that rises by less than this ends a climb.
const LEAST_STEP: f64 = 1.04;

/// Factor between a cliff and the size of its cache.
const NEAR: f64 = 2.0;

/// The cliffs of a curve (working set, cost) of what `of` says, in ascending order of the working
/// set.
pub fn cliffs(of: &str, curve: &[[f64; 2]], caches: &[Cache]) -> Vec<Cliff> {
    let mut found = Vec::new();
    let mut foot = 0;
    while foot + 1 < curve.len() {
        let mut top = foot;
        while top + 1 < curve.len() && curve[top + 1][1] >= LEAST_STEP * curve[top][1] {
            top += 1;
        }
        let ratio = curve[top][1] / curve[foot][1];
        if top > foot && ratio >= LEAST_RISE {
            let size = middle(&curve[foot..=top]);
            found.push(Cliff {
                of: of.to_owned(),
                size,
                from: curve[foot][0],
                to: curve[top][0],
                ratio,
                cache: cache_of(size, caches),
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

/// The cache that a cliff at this working set belongs to.
fn cache_of(size: f64, caches: &[Cache]) -> Option<usize> {
    let distance = |cache: &&Cache| (size / cache.size as f64).ln().abs();
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
        let found = cliffs("x", &curve(), &caches);
        assert_eq!(found.len(), 2, "{found:?}");
        for (cliff, (level, size, ratio)) in found.iter().zip([(1, 49152.0, 2.0), (3, 35e6, 3.0)]) {
            assert_eq!((&*cliff.of, cliff.cache), ("x", Some(level)));
            assert!(cliff.from < size && size < cliff.to * 1.01);
            assert!((cliff.size / size).ln().abs() < 0.4, "{cliff:?}");
            assert!((cliff.ratio / ratio - 1.0).abs() < 0.05, "{cliff:?}");
        }
    }

    #[test]
    fn a_cliff_far_from_any_cache_belongs_to_none() {
        let caches = [cache(1, 49152), cache(2, 2 << 20)];
        assert_eq!(cache_of(512e3, &caches), None);
        assert_eq!(cache_of(512e3, &[]), None);
    }

    #[test]
    fn flat_and_falling_curves_have_none() {
        let flat: Vec<[f64; 2]> = (1..20).map(|i| [f64::from(i), 5.0]).collect();
        assert_eq!(cliffs("x", &flat, &[]), []);
        let falling: Vec<[f64; 2]> = (1..20)
            .map(|i| [f64::from(i), 1.0 / f64::from(i)])
            .collect();
        assert_eq!(cliffs("x", &falling, &[]), []);
        assert_eq!(cliffs("x", &[[1.0, 1.0]], &[]), []);
        assert_eq!(cliffs("x", &[], &[]), []);
    }
}
