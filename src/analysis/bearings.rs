//! What forces do the shafts exert on their bearings?
//!
//! `Σ gain·x(t)` over the blocks, springs and dampers, each rebuilt as a series on every window, and what modes that
//! are left out add as they follow contact forces and loads at rest. Mean and mean
//! square are exact integrals, `∫ f² dt = Δ Σ a_n²/(2n+1)`, taken about the first window's mean.

use super::modal_series::{ModalMotion, Series, TERMS};
use super::nvh::stretches::Stretches;
use crate::model::{BearingOutput, Model};
use crate::numerics::statistics::standard_error;
use crate::propagate::Window;
use std::borrow::Cow;

/// Mesh cycles in a stretch, as for the other statistics.
const CYCLES_PER_STRETCH: u64 = 10;

/// Bearing forces of a model, window after window.
#[derive(Debug, Clone)]
pub struct BearingForces {
    motion: ModalMotion<'static>,
    bearings: Vec<BearingOutput>,
    /// Of every direction of contact forces, what modes that are left out add on every bearing per unit of force.
    by_direction: Vec<Vec<f64>>,
    period: f64,
    /// The present window's forces.
    series: Vec<Series>,
    /// Mean force of the first window \[N\].
    centres: Vec<f64>,
    /// ∫ (f − centre) dt and ∫ (f − centre)² dt of each force.
    sums: Vec<Stretches<[f64; 2]>>,
    cycle: Option<u64>,
    cycles: u64,
}

/// Means and root mean squares about them \[N\], one a force.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct BearingStatistics {
    /// Means.
    pub mean: Vec<f64>,
    /// Root mean squares about them.
    pub rms: Vec<f64>,
}

impl BearingForces {
    /// The forces on all bearings that a model knows.
    pub fn new(model: &Model) -> Self {
        let count = model.bearings.len();
        Self {
            motion: ModalMotion::of(Cow::Owned(model.clone())),
            period: model.period(),
            series: vec![[0.0; TERMS]; count],
            centres: vec![0.0; count],
            sums: vec![Stretches::new([0.0; 2], CYCLES_PER_STRETCH); count],
            bearings: model.bearings.clone(),
            by_direction: (model.directions.iter())
                .map(|direction| direction.on_bearings.clone())
                .collect(),
            cycle: None,
            cycles: 0,
        }
    }

    /// Forgets everything accumulated.
    pub fn restart(&mut self) {
        self.sums.iter_mut().for_each(Stretches::restart);
        self.cycle = None;
        self.cycles = 0;
    }

    /// Series of the forces on the window shown last.
    pub fn series(&self) -> &[Series] {
        &self.series
    }

    /// Takes a window in.
    pub fn window(&mut self, window: &Window<'_>) {
        let modal = self.motion.on(window);
        for (series, bearing) in self.series.iter_mut().zip(&self.bearings) {
            series.fill(0.0);
            series[0] = bearing.constant;
            for (cosine, amplitude) in modal.ripples().zip(&bearing.by_ripple) {
                add(series, *amplitude, cosine);
            }
        }
        for closed in window.closed {
            let direction = window.segments[closed.contact].direction;
            for (series, share) in self.series.iter_mut().zip(&self.by_direction[direction]) {
                add(series, *share, closed.force);
            }
        }
        for mode in 0..window.first.len() {
            for row in 0..2 {
                let gains = || self.bearings.iter().map(|own| own.gain[mode][row]);
                if gains().all(|gain| gain == 0.0) {
                    continue;
                }
                let component = modal.component(mode, row);
                for (series, gain) in self.series.iter_mut().zip(gains()) {
                    add(series, gain, &component);
                }
            }
        }
        match self.cycle {
            None => {
                for (centre, series) in self.centres.iter_mut().zip(&self.series) {
                    *centre = series[0];
                }
            }
            Some(cycle) if cycle != window.cycle => self.advance(),
            Some(_) => {}
        }
        if self.cycle != Some(window.cycle) {
            self.cycle = Some(window.cycle);
            self.cycles += 1;
        }
        let tau = window.duration;
        for ((sums, series), centre) in self.sums.iter_mut().zip(&self.series).zip(&self.centres) {
            let mut about = *series;
            about[0] -= centre;
            let square: f64 = (about.iter().enumerate())
                .map(|(n, a)| a * a / (2 * n + 1) as f64)
                .sum();
            let open = sums.open();
            open[0] += tau * about[0];
            open[1] += tau * square;
        }
    }

    /// A mesh cycle is over.
    fn advance(&mut self) {
        self.sums.iter_mut().for_each(Stretches::advance);
    }

    /// The statistics so far and their standard errors, whole cycles having been integrated.
    pub fn statistics(&self) -> [BearingStatistics; 2] {
        let time = self.cycles as f64 * self.period;
        let mut found = [BearingStatistics::default(), BearingStatistics::default()];
        for (sums, centre) in self.sums.iter().zip(&self.centres) {
            let mut sums = sums.clone();
            sums.advance();
            let [first, square] = sums.total().map(|sum| sum / time);
            let rms = (square - first * first).max(0.0).sqrt();
            let length = sums.length() as f64 * self.period;
            let error = |influence: &dyn Fn(&[f64; 2]) -> f64| {
                let series: Vec<f64> = sums.closed().iter().map(influence).collect();
                standard_error(&series) / length
            };
            found[0].mean.push(centre + first);
            found[0].rms.push(rms);
            found[1].mean.push(error(&|s| s[0]));
            let weight = if rms > 0.0 { 0.5 / rms } else { 0.0 };
            found[1]
                .rms
                .push(error(&|s| weight * (s[1] - 2.0 * first * s[0])));
        }
        found
    }
}

fn add(sum: &mut Series, factor: f64, series: &[f64]) {
    for (value, x) in sum.iter_mut().zip(series) {
        *value += factor * x;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Division, Drive, InitialState, OperatingPoint, fixtures};
    use crate::numerics::legendre::{at_start, evaluate};
    use crate::numerics::quadrature::GaussLegendre;
    use crate::propagate::{Counters, Event, Kernel, Observer, Volterra};
    use crate::shaft::{BearingGain, ModalStructure, StaticShare};

    fn model() -> Model {
        let gain = |name: &str, gain: [f64; 3]| BearingGain {
            name: name.to_owned(),
            gain: gain.to_vec(),
            rate_gain: gain.iter().map(|g| 1e-4 * g).collect(),
            left_out: StaticShare::default(),
        };
        let structure = ModalStructure {
            damping: vec![0.0, 0.01, 0.02],
            bearings: vec![
                gain("pinion 1 x", [0.0, 3e7, -2e7]),
                gain("wheel 2 y", [0.0, 1e7, 4e7]),
            ],
            ..fixtures::structure(
                &[0.0, 4288.0, 8171.0],
                0.0,
                &[0.61, 0.72, -0.48],
                &[0.61, 0.33, 0.05],
            )
        };
        let drive = Drive {
            mesh: Division::levels(&[4.444e8, 4.444e8, 3.333e8], &[]),
            ..fixtures::two_level_mesh(10e-6)
        };
        let point = OperatingPoint {
            load: 0.1,
            speed: 1200.0,
        };
        Model::new(&structure, &drive, point).unwrap()
    }

    /// Compares forces with the kernel's own states, and adds up their squares by a Gauss
    /// rule about no mean.
    struct Check {
        forces: BearingForces,
        gains: Vec<Vec<[f64; 2]>>,
        gauss: GaussLegendre,
        worst: f64,
        time: f64,
        sums: Vec<[f64; 2]>,
    }

    impl Observer for Check {
        const WINDOWS: bool = true;

        fn window(&mut self, window: &Window<'_>) {
            self.forces.window(window);
            self.time += window.duration;
            for (i, series) in self.forces.series().iter().enumerate() {
                let states = self.gains[i].iter().zip(window.first);
                let exact: f64 = (states.zip(window.second))
                    .map(|((g, q), v)| g[0] * q + g[1] * v)
                    .sum();
                self.worst = self.worst.max((at_start(series) - exact).abs());
                for (x, w) in self.gauss.nodes.iter().zip(&self.gauss.weights) {
                    let (force, weight) = (evaluate(series, *x), 0.5 * w * window.duration);
                    self.sums[i][0] += weight * force;
                    self.sums[i][1] += weight * force * force;
                }
            }
        }

        fn event(&mut self, _: &Event) {}
    }

    #[test]
    fn forces_are_those_of_the_states_and_their_statistics_exact() {
        let model = model();
        let kernel = Volterra::new(&model, f64::EPSILON, 1000);
        let mut trajectory = model.start(&InitialState::Static);
        let mut check = Check {
            forces: BearingForces::new(&model),
            gains: model.bearings.iter().map(|b| b.gain.clone()).collect(),
            gauss: GaussLegendre::new(20),
            worst: 0.0,
            time: 0.0,
            sums: vec![[0.0; 2]; 2],
        };
        let mut workspace = kernel.workspace();
        kernel
            .advance(
                330,
                &mut trajectory,
                &mut workspace,
                &mut check,
                &mut Counters::default(),
            )
            .unwrap();
        let [values, errors] = check.forces.statistics();
        for i in 0..2 {
            let [mean, square] = check.sums[i].map(|sum| sum / check.time);
            let rms = (square - mean * mean).sqrt();
            assert!(
                rms > 1.0 && check.worst < 1e-9 * rms,
                "{rms} {:e}",
                check.worst
            );
            assert!((values.mean[i] - mean).abs() < 1e-9 * rms);
            assert!((values.rms[i] / rms - 1.0).abs() < 1e-9);
            assert!(errors.rms[i] > 0.0 && errors.rms[i] < 0.5 * rms);
        }
    }
}
