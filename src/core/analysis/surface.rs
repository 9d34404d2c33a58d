//! Where does a linear combination of modal displacements and velocities have a given value?
//!
//! The combination is rebuilt as a series on every window, from the blocks' motion. The crossings are the
//! certified roots of that series.

use super::modal_series::{ModalMotion, Series, TERMS};
use crate::model::Model;
use crate::numerics::legendre::transforms24;
use crate::numerics::roots::sign_changes;
use crate::propagate::Window;
use serde::Serialize;
use std::borrow::Cow;

/// A surface of phase space, `Σ (a_i q_i + b_i q_i') = level`, in the structure's modes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Surface {
    /// Coefficients a of the modal displacements \[1/√kg\], one per mode.
    pub displacement: Vec<f64>,
    /// Coefficients b of the modal velocities \[s/√kg\], one per mode.
    pub velocity: Vec<f64>,
    /// Value of the combination on the surface \[m\].
    pub level: f64,
    /// `true` if only crossings towards larger values count, `false` if only those towards smaller values
    /// count, `None` for both.
    pub rising: Option<bool>,
}

/// Round-off of a combination, in units of the sum of its terms' sizes: series of modal motion are accurate
/// to a hundred units in the last place.
const NOISE: f64 = 128.0 * f64::EPSILON;

/// Finds the crossings of a surface, window after window.
#[derive(Debug, Clone)]
pub struct SurfaceWatch {
    motion: ModalMotion<'static>,
    /// Coefficients of the blocks' components.
    weights: Vec<[f64; 2]>,
    level: f64,
    rising: Option<bool>,
    /// Whether the motion was above the surface at the end of the last window.
    above: Option<bool>,
}

impl SurfaceWatch {
    /// The surface of a model.
    pub fn new(model: &Model, surface: &Surface) -> Self {
        let n = model.modes();
        // The combination of modal values, converted to weights of the blocks' components.
        let weight = |component: usize| {
            let mut unit = vec![0.0; 2 * n];
            unit[component] = 1.0;
            let [displacement, velocity] = model.basis.modes(&unit);
            let of = |a: &[f64], q: &[f64]| a.iter().zip(q).map(|(a, q)| a * q).sum::<f64>();
            of(&surface.displacement, &displacement) + of(&surface.velocity, &velocity)
        };
        Self {
            motion: ModalMotion::of(Cow::Owned(model.clone())),
            weights: (0..n).map(|i| [weight(i), weight(n + i)]).collect(),
            level: surface.level,
            rising: surface.rising,
            above: None,
        }
    }

    /// Passes every position in a window at which the surface is crossed to `visit`, with whether the
    /// combination rises there.
    pub fn crossings(&mut self, window: &Window<'_>, mut visit: impl FnMut(f64, bool)) {
        let modal = self.motion.on(window);
        let mut combination: Series = [0.0; TERMS];
        combination[0] = -self.level;
        let mut size = self.level.abs();
        for (i, weights) in self.weights.iter().enumerate() {
            for (row, weight) in weights.iter().enumerate().filter(|(_, w)| **w != 0.0) {
                for (sum, term) in combination.iter_mut().zip(modal.component(i, row)) {
                    *sum += weight * term;
                    size += (weight * term).abs();
                }
            }
        }
        let wanted = self.rising;
        let noise = NOISE * size;
        sign_changes(
            transforms24(),
            &combination,
            noise,
            &mut self.above,
            |x, rises| {
                if wanted.is_none_or(|wanted| wanted == rises) {
                    visit(x, rises);
                }
            },
        );
    }
}
