//! Amplitude and phase of signals at multiples of every mesh frequency and every shaft speed.
//!
//! `c = 2/T ∫ f e^{−iωt} dt` is the exact integral of the windows' series, with t from the start of
//! mesh cycle 0: `f = … + |c| cos(ωt + arg c)`. Orders of a shaft or of a further mesh are integrated over
//! whole periods of that shaft or mesh. These are also whole cycles of the first mesh, so neither the mean
//! nor mesh orders leak into them. Standard errors follow from the components of c along and across it, over
//! successive stretches.

use super::config::{NvhConfig, OrderConfig};
use super::modal_series::Series;
use super::nvh::block_sums::{BlockSums, Summable};
use super::outcome::{OrderLine, SignalOrders};
use super::signal::Signal;
use crate::model::Model;
use crate::numerics::fourier::{ScaledWindow, add_lines};
use crate::numerics::statistics::standard_error;
use crate::propagate::Window;
use num_complex::Complex64;
use std::f64::consts::TAU;

/// Smallest number of mesh cycles in a stretch.
const CYCLES_PER_STRETCH: u64 = 10;

/// Integrals over a stretch.
#[derive(Debug, Clone)]
struct Sums {
    /// Length of the stretch \[s\].
    time: f64,
    /// `∫ (f − centre) e^{−iωt} dt`, by signal and multiple.
    lines: Vec<Vec<Complex64>>,
}

impl Summable for Sums {
    fn add(&mut self, other: &Self) {
        self.time += other.time;
        let pairs = self.lines.iter_mut().zip(&other.lines);
        for (sum, value) in pairs.flat_map(|(sums, values)| sums.iter_mut().zip(values)) {
            *sum += value;
        }
    }

    fn clear(&mut self) {
        self.time = 0.0;
        for sums in &mut self.lines {
            sums.fill(Complex64::ZERO);
        }
    }
}

/// The multiples of one frequency.
#[derive(Debug, Clone)]
struct Family {
    /// Name of the mesh or shaft whose frequency this is.
    reference: String,
    /// The frequency `[p, q]`: p periods in q mesh cycles.
    periods: [u32; 2],
    stretches: BlockSums<Sums>,
}

impl Family {
    fn new(reference: String, periods: [u32; 2], count: u32, signals: usize) -> Self {
        let empty = Sums {
            time: 0.0,
            lines: vec![vec![Complex64::ZERO; count as usize]; signals],
        };
        let period = u64::from(periods[1]);
        let length = CYCLES_PER_STRETCH.div_ceil(period) * period;
        Self {
            reference,
            periods,
            stretches: BlockSums::new(empty, length),
        }
    }

    /// The part of a record that is evaluated. It is the whole record (`all`) if its length is a whole number
    /// of periods, else all complete stretches. `None` without a complete stretch.
    fn counted(&self, all: bool) -> Option<Sums> {
        if all {
            return Some(self.stretches.total());
        }
        let mut closed = self.stretches.complete().iter();
        let mut sum = closed.next()?.clone();
        closed.for_each(|stretch| sum.add(stretch));
        Some(sum)
    }

    /// The lines of a signal from `sums`, the evaluated part of the record. They are exact if the motion
    /// `repeats` after a number of mesh cycles.
    fn lines(
        &self,
        signal: usize,
        sums: &Sums,
        mesh_period: f64,
        repeats: Option<u32>,
    ) -> Vec<OrderLine> {
        let line = |(index, sum): (usize, &Complex64)| {
            let multiple = index as u32 + 1;
            let [p, q] = self.periods;
            let order = f64::from(multiple) * f64::from(p) / f64::from(q);
            // A motion of period k contains multiples of 1/k of the mesh order.
            let turns = |k: u32| u64::from(multiple) * u64::from(p) * u64::from(k);
            let held = repeats.is_none_or(|k| turns(k).is_multiple_of(u64::from(q)));
            let value = if held { 2.0 / sums.time * sum } else { Complex64::ZERO };
            let amplitude = value.norm();
            let error = |part: fn(Complex64) -> f64| {
                if repeats.is_some() || amplitude == 0.0 {
                    return None;
                }
                let along = value.conj() / amplitude;
                let parts = self.stretches.complete().iter().map(|stretch| {
                    part(along * (2.0 / stretch.time * stretch.lines[signal][index]))
                });
                let error = standard_error(&parts.collect::<Vec<_>>());
                error.is_finite().then_some(error)
            };
            OrderLine {
                reference: self.reference.clone(),
                multiple,
                order,
                frequency: order / mesh_period,
                amplitude,
                stderr: error(|part| part.re),
                phase: (amplitude > 0.0).then(|| value.arg()),
                phase_stderr: error(|part| part.im).map(|error| error / amplitude),
            }
        };
        sums.lines[signal].iter().enumerate().map(line).collect()
    }
}

/// Accumulates orders while a trajectory is integrated.
#[derive(Debug, Clone)]
pub struct Orders {
    /// Mesh period \[s\].
    period: f64,
    signals: Vec<Signal>,
    /// Mean of each signal in the first window.
    centres: Vec<f64>,
    families: Vec<Family>,
    cycle: Option<u64>,
    /// Whether the present cycle is not counted yet.
    open: bool,
    /// The present window's signals.
    series: Vec<Series>,
    repeats: Option<u32>,
}

impl Orders {
    /// The orders of a model that `config` requests; `all` contains every requested output.
    pub fn new(model: &Model, config: &OrderConfig, all: &NvhConfig) -> Self {
        let signals = Signal::requested(model, config.signals, all.computed());
        let count = signals.len();
        let mut known = Vec::new();
        let meshes = model.meshes.iter().filter(|mesh| {
            let new = !known.contains(&mesh.cycles);
            known.push(mesh.cycles);
            new
        });
        let meshes = meshes.enumerate().map(|(number, mesh)| {
            let name = if number == 0 { "mesh".to_owned() } else { format!("mesh {}", mesh.name) };
            Family::new(name, mesh.cycles, config.mesh, count)
        });
        let shafts = model.shafts.iter().filter(|_| config.shafts > 0);
        let shafts =
            shafts.map(|(name, turns)| Family::new(name.clone(), *turns, config.shafts, count));
        Self {
            period: model.period(),
            families: meshes.chain(shafts).collect(),
            centres: vec![0.0; signals.len()],
            series: Vec::with_capacity(signals.len()),
            signals,
            cycle: None,
            open: false,
            repeats: None,
        }
    }

    /// Forgets everything accumulated.
    pub fn restart(&mut self) {
        self.cycle = None;
        self.open = false;
        self.repeats = None;
        for family in &mut self.families {
            family.stretches.restart();
        }
    }

    /// Marks the measured motion as periodic, after integration of whole periods: its orders are exact.
    pub fn repeats(&mut self, period: u32) {
        self.repeats = Some(period);
    }

    /// Appends the record of another trajectory of the same model. Both have whole mesh cycles. Phases agree
    /// because both count time from the start of mesh cycle 0. The sum can be evaluated but not continued.
    pub(in crate::analysis) fn append(&mut self, other: &Self) {
        if other.cycle.is_none() {
            return;
        }
        self.finish();
        let mut other = other.clone();
        other.finish();
        self.cycle = self.cycle.or(other.cycle);
        // The centres of both records may differ, because a constant has no lines over whole periods.
        for (family, other_family) in self.families.iter_mut().zip(&other.families) {
            family.stretches.append(&other_family.stretches);
        }
    }

    /// Keeps only the complete stretches within the first `cycles`. The rest can be evaluated but not continued.
    pub(in crate::analysis) fn cut(&mut self, cycles: u64) {
        self.finish();
        for family in &mut self.families {
            family.stretches.cut(cycles);
        }
        let is_empty = |family: &Family| family.stretches.complete().is_empty();
        if self.families.iter().all(is_empty) {
            self.restart();
        }
    }

    /// Adds a window, with the series of the outputs.
    pub fn window(&mut self, window: &Window<'_>, outputs: &[Series]) {
        self.series.clear();
        let signals = self.signals.iter();
        (self.series).extend(signals.map(|signal| signal.series(window, outputs)));
        match self.cycle {
            None => {
                for (centre, series) in self.centres.iter_mut().zip(&self.series) {
                    *centre = series[0];
                }
            }
            Some(cycle) if cycle != window.cycle => self.finish(),
            Some(_) => {}
        }
        self.cycle = Some(window.cycle);
        self.open = true;
        for (series, centre) in self.series.iter_mut().zip(&self.centres) {
            series[0] -= centre;
        }
        for family in &mut self.families {
            let [p, q] = family.periods;
            let slowest = TAU * f64::from(p) / (f64::from(q) * self.period);
            let cycle = window.cycle % u64::from(q);
            let middle = window.start + 0.5 * window.duration;
            let stretch = ScaledWindow {
                duration: window.duration,
                half_turn: 0.5 * slowest * window.duration,
                phase: slowest * (cycle as f64 * self.period + middle),
            };
            let sums = family.stretches.current();
            sums.time += window.duration;
            add_lines(stretch, &self.series, &mut sums.lines);
        }
    }

    /// Counts the last integrated cycle, which is complete although no later window follows.
    fn finish(&mut self) {
        if std::mem::take(&mut self.open) {
            for family in &mut self.families {
                family.stretches.advance();
            }
        }
    }

    /// The orders of every signal after whole mesh cycles; those of shafts and further meshes only after a complete
    /// stretch.
    pub fn outcome(&self) -> Vec<SignalOrders> {
        if self.cycle.is_none() {
            return Vec::new();
        }
        let mut closed = self.clone();
        closed.finish();
        let families: Vec<(&Family, Sums)> = (closed.families.iter())
            .filter_map(|family| {
                let all = self.repeats.is_some() || family.periods[1] == 1;
                Some((family, family.counted(all)?))
            })
            .collect();
        let orders = |(index, signal): (usize, &Signal)| SignalOrders {
            signal: signal.name.clone(),
            unit: signal.unit.to_owned(),
            lines: (families.iter())
                .flat_map(|(family, sums)| family.lines(index, sums, self.period, self.repeats))
                .collect(),
        };
        self.signals.iter().enumerate().map(orders).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::config::Signals;
    use crate::analysis::modal_series::cosine_series;
    use crate::model::fixtures::{constant_mesh, one_mode};
    use crate::model::{NamedMesh, OperatingPoint};
    use crate::numerics::random::Stream;
    use crate::structure::ModalStructure;

    /// Passes windows with the sum of two waves: one of mesh order 1 with a fluctuating amplitude, one of the
    /// pinion's order 2.
    fn show(orders: &mut Orders, cycles: std::ops::Range<u64>) {
        for cycle in cycles {
            let amplitude = 3.0 + Stream::new(5, cycle, 0).normal();
            for part in 0..4 {
                let (start, tau) = (0.25 * f64::from(part), 0.25);
                let turned = |order: f64| TAU * order * (cycle as f64 + start);
                let mesh = cosine_series(TAU, turned(1.0) + 0.3, tau);
                let shaft = cosine_series(TAU * 0.4, turned(0.4) + 0.7, tau);
                let mut sum: Series = std::array::from_fn(|n| amplitude * mesh[n] + 2.0 * shaft[n]);
                sum[0] += 10.0;
                let window = Window {
                    cycle,
                    start,
                    duration: tau,
                    deflection: &sum,
                    force: &[0.0],
                    ..Window::default()
                };
                orders.window(&window, &[]);
            }
        }
    }

    /// A pinion of five teeth, with settings.
    fn config() -> (Model, OrderConfig, NvhConfig) {
        let structure = ModalStructure {
            teeth: 5,
            ..one_mode(1.0)
        };
        let point = OperatingPoint {
            load: 0.0,
            speed: TAU / 5.0,
        };
        let model = Model::new(&structure, &constant_mesh(1.0, 1.0), point).unwrap();
        let config = OrderConfig {
            signals: Signals {
                deflection: true,
                ..Signals::NONE
            },
            mesh: 2,
            shafts: 3,
        };
        let all = NvhConfig {
            harmonics: 0,
            outputs: Signals::NONE,
            power: false,
            spectrum: None,
            orders: Some(config),
            stop_at_stderr: None,
        };
        (model, config, all)
    }

    /// The same wave is an order of the pinion, of a mesh with two periods in five cycles, and of a slow shaft.
    #[test]
    fn every_mesh_and_shaft_has_its_orders() {
        let (mut model, config, all) = config();
        model.meshes.push(NamedMesh {
            name: "c and d".to_owned(),
            flanks: [2, 3],
            cycles: [2, 5],
        });
        model.shafts.push(("shaft slow".to_owned(), [2, 15]));
        let mut orders = Orders::new(&model, &config, &all);
        show(&mut orders, 0..720);
        let found = orders.outcome();
        for (reference, multiple) in [("pinion", 2), ("mesh c and d", 1), ("shaft slow", 3)] {
            let mut lines = found[0].lines.iter();
            let line = lines.find(|own| own.reference == reference && own.multiple == multiple);
            let line = line.unwrap();
            assert!((line.order - 0.4).abs() < 1e-15 && (line.frequency - 0.4).abs() < 1e-15);
            assert!(
                (line.amplitude - 2.0).abs() < 4.0 * line.stderr.unwrap(),
                "{line:?}"
            );
            assert!((line.phase.unwrap() - 0.7).abs() < 4.0 * line.phase_stderr.unwrap());
        }
    }

    #[test]
    fn a_record_in_two_parts_has_the_orders_of_the_whole() {
        let (model, config, all) = config();
        let record = |cycles: std::ops::Range<u64>| {
            let mut orders = Orders::new(&model, &config, &all);
            show(&mut orders, cycles);
            orders
        };
        let whole = record(7..727).outcome();
        let mut parts = record(7..367);
        parts.append(&record(367..727));
        let parts = parts.outcome();
        // A cut record is that of its first part.
        let mut cut = record(7..727);
        cut.cut(360);
        assert_eq!(cut.outcome(), record(7..367).outcome());
        let (whole, parts) = (&whole[0].lines, &parts[0].lines);
        assert_eq!(whole.len(), 2 + 3);
        for (a, b) in whole.iter().zip(parts) {
            assert!((a.amplitude - b.amplitude).abs() < 1e-12, "{a:?} {b:?}");
            let (a, b) = (a.stderr.unwrap(), b.stderr.unwrap());
            assert!((a - b).abs() < 1e-12, "{a} {b}");
        }
        // The first of the mesh and the second of the pinion.
        for (line, exact) in [(&parts[0], 3.0), (&parts[3], 2.0)] {
            assert!((line.amplitude - exact).abs() < 4.0 * line.stderr.unwrap());
        }
    }
}
