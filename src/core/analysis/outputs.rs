//! Forces, torques, accelerations and rotations at places of the structure.
//!
//! Each output is `Σ gain·x(t)` over the blocks, rebuilt as a series on every window. A bearing adds the
//! static response of omitted modes to contact forces and loads. For an acceleration the sum is a
//! velocity v, and the blocks' equation gives its rate without differentiation of a series:
//!
//! ```text
//! v' = Σ gain·(A x + s + Σ r cos(ωt + φ) − Σ g F)
//! ```
//!
//! Mean and mean square are exact integrals, `∫ f² dt = Δ Σ a_n²/(2n+1)`, taken about the first
//! window's mean.

use super::config::Signals;
use super::modal_series::{ModalMotion, ModalSeries, Series, TERMS, add_multiple, padded};
use super::nvh::block_sums::BlockSums;
use super::precision::SignalSize;
use crate::model::{BearingOutput, DRIVE_FLANK, Model, NamedMesh, Output, Quantity};
use crate::numerics::statistics::standard_error;
use crate::propagate::Window;
use std::borrow::Cow;

/// Mesh cycles in a stretch, as for the other statistics.
const CYCLES_PER_STRETCH: u64 = 10;

/// The weights with which an output follows from the blocks, the excitation and the contacts.
#[derive(Debug, Clone)]
struct OutputWeights {
    /// Weights of both components of each block.
    gain: Vec<[f64; 2]>,
    constant: f64,
    /// Weight of the force along each direction; empty if none contributes.
    by_force: Vec<f64>,
    /// Weight of each ripple; empty if none contributes.
    by_ripple: Vec<f64>,
}

impl OutputWeights {
    /// The weights of a bearing, given with its index in the model, including the static response of omitted
    /// modes.
    fn of_bearing(model: &Model, (index, bearing): (usize, &BearingOutput)) -> Self {
        let shares = model
            .directions
            .iter()
            .map(|direction| &direction.on_bearings);
        let by_force = shares.map(|shares| shares.get(index).copied().unwrap_or(0.0));
        Self {
            gain: bearing.gain.clone(),
            constant: bearing.constant,
            by_force: by_force.collect(),
            by_ripple: bearing.by_ripple.clone(),
        }
    }

    fn of(model: &Model, output: &Output) -> Self {
        let coefficients = &output.gain;
        if !output.quantity.is_rate() {
            return Self {
                gain: coefficients.clone(),
                constant: 0.0,
                by_force: Vec::new(),
                by_ripple: Vec::new(),
            };
        }
        let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
        let rate = coefficients.iter().zip(&model.blocks).map(|(&c, block)| {
            let [first, second] = block.generator;
            [
                c[0] * first[0] + c[1] * second[0],
                c[0] * first[1] + c[1] * second[1],
            ]
        });
        let by_force = model.directions.iter().map(|direction| {
            let inputs = direction.gains.iter().map(|gain| gain.mesh_input);
            -coefficients
                .iter()
                .zip(inputs)
                .map(|(&c, g)| dot(c, g))
                .sum::<f64>()
        });
        let by_ripple = model.ripple.iter().map(|ripple| {
            let inputs = coefficients.iter().zip(&ripple.input);
            inputs.map(|(&c, &r)| dot(c, r)).sum::<f64>()
        });
        let constant = coefficients.iter().zip(&model.blocks);
        Self {
            gain: rate.collect(),
            constant: constant.map(|(&c, block)| dot(c, block.static_input)).sum(),
            by_force: by_force.collect(),
            by_ripple: by_ripple.collect(),
        }
    }
}

/// The quantities of every mesh.
const OF_MESH: [Quantity; 2] = [Quantity::MeshDeflection, Quantity::MeshForce];

/// Name and quantity of the requested outputs of a model, in the order of their series.
pub fn named(model: &Model, wanted: Signals) -> impl Iterator<Item = (String, Quantity)> {
    let bearings = (model.bearings.iter()).map(|bearing| (&bearing.name, Quantity::BearingForce));
    let outputs = (model.outputs.iter()).map(|output| (&output.name, output.quantity));
    let meshes =
        (model.meshes.iter()).flat_map(|mesh| OF_MESH.map(|quantity| (&mesh.name, quantity)));
    (bearings.chain(outputs).chain(meshes))
        .filter(move |(_, quantity)| wanted.has(*quantity))
        .map(|(name, quantity)| (format!("{} {name}", quantity.name()), quantity))
}

/// Outputs of a model, window after window.
#[derive(Debug, Clone)]
pub struct Outputs {
    motion: ModalMotion<'static>,
    /// Weights of all outputs except those of meshes, which are last.
    weights: Vec<OutputWeights>,
    /// The meshes whose deflections and forces are requested.
    meshes: Vec<NamedMesh>,
    /// As returned by [`named`].
    names: Vec<(String, Quantity)>,
    period: f64,
    /// The outputs on the present window.
    series: Vec<Series>,
    /// Mean of each output in the first window.
    centres: Vec<f64>,
    /// Time \[s\], ∫ (f − centre) dt and ∫ (f − centre)² dt of each output.
    sums: Vec<BlockSums<[f64; 3]>>,
    cycle: Option<u64>,
    /// Whether the present cycle is not counted yet.
    open: bool,
    cycles: u64,
}

/// Means of outputs and root mean squares about them, one entry per output.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct OutputStatistics {
    /// Means.
    pub mean: Vec<f64>,
    /// Root mean squares about the means.
    pub rms: Vec<f64>,
}

impl Outputs {
    /// The requested outputs of a model; `None` if it has none of them.
    pub fn new(model: &Model, wanted: Signals) -> Option<Self> {
        let bearings = (model.bearings.iter().enumerate())
            .filter(|_| wanted.has(Quantity::BearingForce))
            .map(|bearing| OutputWeights::of_bearing(model, bearing));
        let outputs = (model.outputs.iter())
            .filter(|output| wanted.has(output.quantity))
            .map(|output| OutputWeights::of(model, output));
        let names: Vec<_> = named(model, wanted).collect();
        let count = names.len();
        (count > 0).then(|| Self {
            motion: ModalMotion::of(Cow::Owned(model.clone())),
            period: model.period(),
            series: vec![[0.0; TERMS]; count],
            centres: vec![0.0; count],
            sums: vec![BlockSums::new([0.0; 3], CYCLES_PER_STRETCH); count],
            weights: bearings.chain(outputs).collect(),
            meshes: if wanted.meshes { model.meshes.clone() } else { Vec::new() },
            names,
            cycle: None,
            open: false,
            cycles: 0,
        })
    }

    /// Forgets everything accumulated.
    pub fn restart(&mut self) {
        self.sums.iter_mut().for_each(BlockSums::restart);
        self.cycle = None;
        self.open = false;
        self.cycles = 0;
    }

    /// Appends the record of another trajectory of the same model. Both have whole mesh cycles. The sum can
    /// be evaluated but not continued.
    pub fn append(&mut self, other: &Self) {
        if other.cycle.is_none() {
            return;
        }
        self.finish();
        let mut other = other.clone();
        other.finish();
        if self.cycle.is_none() {
            self.centres.clone_from(&other.centres);
        }
        self.cycle = self.cycle.or(other.cycle);
        self.cycles += other.cycles;
        let centres = self.centres.iter().zip(&other.centres);
        for ((sums, others), (centre, own)) in
            self.sums.iter_mut().zip(&mut other.sums).zip(centres)
        {
            let shift = own - centre;
            others.each(|[time, first, square]| {
                *square += shift * (2.0 * *first + shift * *time);
                *first += shift * *time;
            });
            sums.append(others);
        }
    }

    /// Keeps only the complete stretches within the first `cycles`. The rest can be evaluated but not continued.
    pub fn cut(&mut self, cycles: u64) {
        self.finish();
        self.sums.iter_mut().for_each(|sums| sums.cut(cycles));
        let kept = |sums: &BlockSums<_>| sums.complete().len() as u64 * sums.length();
        self.cycles = self.sums.first().map_or(0, kept);
        if self.cycles == 0 {
            self.restart();
        }
    }

    /// Series of the outputs on the last window.
    pub fn series(&self) -> &[Series] {
        &self.series
    }

    /// Rebuilds the outputs on a window.
    pub fn rebuild(&mut self, window: &Window<'_>) -> &[Series] {
        let modal = self.motion.on(window);
        let (places, meshes) = self.series.split_at_mut(self.weights.len());
        for (mesh, series) in self.meshes.iter().zip(meshes.chunks_exact_mut(2)) {
            series[0] = deflection(mesh, window, &modal);
            series[1] = force(mesh, window);
        }
        for (series, weights) in places.iter_mut().zip(&self.weights) {
            series.fill(0.0);
            series[0] = weights.constant;
        }
        for block in 0..window.first.len() {
            for row in 0..2 {
                if self
                    .weights
                    .iter()
                    .all(|weights| weights.gain[block][row] == 0.0)
                {
                    continue;
                }
                let component = modal.component(block, row);
                for (series, weights) in places.iter_mut().zip(&self.weights) {
                    add_multiple(weights.gain[block][row], &component, series);
                }
            }
        }
        for closed in window.closed {
            let direction = window.segments[closed.contact].direction;
            let force = padded(closed.force);
            for (series, weights) in places.iter_mut().zip(&self.weights) {
                add_multiple(
                    weights.by_force.get(direction).copied().unwrap_or(0.0),
                    &force,
                    series,
                );
            }
        }
        for (index, ripple) in modal.ripples().enumerate() {
            for (series, weights) in places.iter_mut().zip(&self.weights) {
                add_multiple(
                    weights.by_ripple.get(index).copied().unwrap_or(0.0),
                    ripple,
                    series,
                );
            }
        }
        &self.series
    }

    /// Adds a window.
    pub fn window(&mut self, window: &Window<'_>) {
        self.rebuild(window);
        match self.cycle {
            None => {
                for (centre, series) in self.centres.iter_mut().zip(&self.series) {
                    *centre = series[0];
                }
            }
            Some(cycle) if cycle != window.cycle => self.finish(),
            Some(_) => {}
        }
        if self.cycle != Some(window.cycle) {
            self.cycle = Some(window.cycle);
            self.cycles += 1;
        }
        self.open = true;
        let tau = window.duration;
        for ((sums, series), centre) in self.sums.iter_mut().zip(&self.series).zip(&self.centres) {
            let mut about = *series;
            about[0] -= centre;
            let square: f64 = (about.iter().enumerate())
                .map(|(n, a)| a * a / (2 * n + 1) as f64)
                .sum();
            let current = sums.current();
            current[0] += tau;
            current[1] += tau * about[0];
            current[2] += tau * square;
        }
    }

    /// Counts the last integrated cycle, which is complete although no later window follows.
    fn finish(&mut self) {
        if std::mem::take(&mut self.open) {
            self.sums.iter_mut().for_each(BlockSums::advance);
        }
    }

    /// Statistics and standard errors of the outputs of a quantity, after whole cycles.
    pub fn statistics(&self, quantity: Quantity) -> [OutputStatistics; 2] {
        let mut statistics = [OutputStatistics::default(), OutputStatistics::default()];
        let outputs = self.names.iter().zip(self.sums.iter().zip(&self.centres));
        for (_, (sums, centre)) in outputs.filter(|((_, kind), _)| *kind == quantity) {
            let mut sums = sums.clone();
            if self.open {
                sums.advance();
            }
            let [first, rms] = self.about_centre(&sums);
            let length = sums.length() as f64 * self.period;
            let error = |influence: &dyn Fn(&[f64; 3]) -> f64| {
                let series: Vec<f64> = sums.complete().iter().map(influence).collect();
                standard_error(&series) / length
            };
            statistics[0].mean.push(centre + first);
            statistics[0].rms.push(rms);
            statistics[1].mean.push(error(&|s| s[1]));
            let weight = if rms > 0.0 { 0.5 / rms } else { 0.0 };
            statistics[1]
                .rms
                .push(error(&|s| weight * (s[2] - 2.0 * first * s[1])));
        }
        statistics
    }

    /// Mean minus centre, and root mean square about the mean, of an output with sums over whole cycles.
    fn about_centre(&self, sums: &BlockSums<[f64; 3]>) -> [f64; 2] {
        let time = self.cycles as f64 * self.period;
        let [_, first, square] = sums.total().map(|sum| sum / time);
        [first, (square - first * first).max(0.0).sqrt()]
    }

    /// Mean and root mean square about it of every output, by the name of its signal.
    pub fn sizes(&self) -> Vec<(&str, SignalSize)> {
        let outputs = self.sums.iter().zip(&self.centres);
        let size = |(sums, centre): (&BlockSums<[f64; 3]>, &f64)| {
            let [first, rms] = self.about_centre(sums);
            SignalSize {
                mean: centre + first,
                rms,
            }
        };
        (self.names.iter().map(|(name, _)| name.as_str()))
            .zip(outputs.map(size))
            .collect()
    }
}

/// Deflection of a mesh along the line of its drive flank.
fn deflection(mesh: &NamedMesh, window: &Window<'_>, modal: &ModalSeries<'_>) -> Series {
    let [drive, _] = mesh.flanks;
    let shown = window.closed.iter().find(|closed| closed.contact == drive);
    match shown {
        _ if drive == DRIVE_FLANK => padded(window.deflection),
        Some(closed) => padded(closed.deflection),
        None => modal.along(window.segments[drive].direction),
    }
}

/// Force of a mesh.
fn force(mesh: &NamedMesh, window: &Window<'_>) -> Series {
    if mesh.flanks[0] == DRIVE_FLANK {
        return padded(window.force);
    }
    let mut sum = [0.0; TERMS];
    for closed in window
        .closed
        .iter()
        .filter(|c| mesh.flanks.contains(&c.contact))
    {
        add_multiple(mesh.sign(closed.contact), &padded(closed.force), &mut sum);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{
        Division, Drive, DriveShaft, InitialState, OperatingPoint, TorqueRipple, fixtures,
    };
    use crate::numerics::legendre::{at_start, evaluate};
    use crate::numerics::quadrature::GaussLegendre;
    use crate::propagate::{Counters, Kernel, Observer, Volterra};
    use crate::structure::{
        BearingGain, ModalStructure, MotionKind, OmittedModeForces, PlaceMotion,
    };

    const ALL: Signals = Signals {
        bearings: true,
        accelerations: true,
        ..Signals::NONE
    };

    fn model() -> Model {
        let gain = |name: &str, gain: [f64; 3]| BearingGain {
            name: name.to_owned(),
            gain: gain.to_vec(),
            rate_gain: gain.iter().map(|g| 1e-4 * g).collect(),
            left_out: OmittedModeForces::default(),
        };
        let structure = ModalStructure {
            damping: vec![0.0, 0.01, 0.02],
            bearings: vec![
                gain("pinion 1 x", [0.0, 3e7, -2e7]),
                gain("wheel 2 y", [0.0, 1e7, 4e7]),
            ],
            motions: vec![PlaceMotion {
                name: "pinion 1 x".to_owned(),
                kind: MotionKind::Place,
                gain: vec![0.1, 0.4, -0.3],
            }],
            pinion_torque: Some(vec![16.0, 2.0, 8.0]),
            ..fixtures::structure(
                &[0.0, 4288.0, 8171.0],
                0.0,
                &[0.61, 0.72, -0.48],
                &[0.61, 0.33, 0.05],
            )
        };
        let drive = Drive {
            mesh: Division::levels(&[4.444e8, 4.444e8, 3.333e8], &[]),
            torque_ripple: vec![TorqueRipple {
                shaft: DriveShaft::Pinion,
                order: 2.0,
                amplitude: 1.5,
                phase: 0.3,
            }],
            ..fixtures::two_level_mesh(10e-6)
        };
        let point = OperatingPoint {
            load: 0.1,
            speed: 1200.0,
        };
        Model::new(&structure, &drive, point).unwrap()
    }

    /// Compares outputs with the kernel's states, and rates with the model's vector field. Integrates the
    /// outputs and their squares by a Gauss rule, without a centre, per stretch of ten cycles.
    struct Check {
        model: Model,
        outputs: Outputs,
        gauss: GaussLegendre,
        worst: Vec<f64>,
        time: f64,
        sums: Vec<[f64; 2]>,
        stretches: Vec<Vec<[f64; 2]>>,
    }

    impl Observer for Check {
        const WINDOWS: bool = true;

        fn window(&mut self, window: &Window<'_>) {
            self.outputs.window(window);
            self.time += window.duration;
            let stretch = (window.cycle / CYCLES_PER_STRETCH) as usize;
            self.stretches.resize(stretch + 1, vec![[0.0; 2]; 3]);
            let state = [window.first, window.second].concat();
            let mut slope = vec![0.0; state.len()];
            let (segments, active) = (window.segments, window.contact);
            let (cycle, time) = (window.cycle, window.start);
            (self.model).derivative(segments, active, cycle, time, &state, &mut slope);
            for (i, series) in self.outputs.series().iter().enumerate() {
                let bearings = self
                    .model
                    .bearings
                    .iter()
                    .map(|bearing| (&bearing.gain, &state));
                let accelerations = self
                    .model
                    .outputs
                    .iter()
                    .map(|output| (&output.gain, &slope));
                let (gain, seen) = bearings.chain(accelerations).nth(i).unwrap();
                let pairs = gain
                    .iter()
                    .zip(seen.iter().zip(&seen[window.first.len()..]));
                let exact: f64 = pairs.map(|(g, (q, v))| g[0] * q + g[1] * v).sum();
                self.worst[i] = self.worst[i].max((at_start(series) - exact).abs());
                for (x, w) in self.gauss.nodes.iter().zip(&self.gauss.weights) {
                    let (value, weight) = (evaluate(series, *x), 0.5 * w * window.duration);
                    for sums in [&mut self.sums[i], &mut self.stretches[stretch][i]] {
                        sums[0] += weight * value;
                        sums[1] += weight * value * value;
                    }
                }
            }
        }
    }

    #[test]
    fn outputs_are_those_of_the_states_and_their_statistics_exact() {
        let model = model();
        let kernel = Volterra::new(&model, f64::EPSILON, 1000);
        let mut trajectory = model.start(&InitialState::Static);
        let mut check = Check {
            model: model.clone(),
            outputs: Outputs::new(&model, ALL).unwrap(),
            gauss: GaussLegendre::new(20),
            worst: vec![0.0; 3],
            time: 0.0,
            sums: vec![[0.0; 2]; 3],
            stretches: Vec::new(),
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
        let forces = check.outputs.statistics(Quantity::BearingForce);
        let accelerations = check.outputs.statistics(Quantity::Acceleration);
        let sizes = check.outputs.sizes();
        let names: Vec<&str> = sizes.iter().map(|(name, _)| *name).collect();
        assert_eq!(names.len(), 3, "{names:?}");
        for (i, ([values, errors], own)) in [(&forces, 0), (&forces, 1), (&accelerations, 0)]
            .into_iter()
            .enumerate()
        {
            let [mean, square] = check.sums[i].map(|sum| sum / check.time);
            let rms = (square - mean * mean).sqrt();
            let worst = check.worst[i];
            assert!(rms > 1.0 && worst < 1e-9 * rms, "{i}: {rms} {worst:e}");
            assert!((values.mean[own] - mean).abs() < 1e-9 * rms);
            assert!((values.rms[own] / rms - 1.0).abs() < 1e-9);
            let size = &sizes[i].1;
            assert!((size.mean - mean).abs() < 1e-9 * rms && (size.rms / rms - 1.0).abs() < 1e-9);
            assert!(errors.rms[own] > 0.0 && errors.rms[own] < 0.5 * rms);
            // Standard error from the sums of stretches about the mean: σ = √(mean square), dσ = d(σ²)/(2σ).
            let time = 10.0 * check.model.period();
            let stretches = check.stretches.iter().map(|sums| sums[i]);
            let [means, squares]: [Vec<f64>; 2] = [
                stretches.clone().map(|[first, _]| first / time).collect(),
                stretches
                    .map(|[first, second]| (second - 2.0 * mean * first) / time / (2.0 * rms))
                    .collect(),
            ];
            for (found, series) in [(errors.mean[own], &means), (errors.rms[own], &squares)] {
                let exact = standard_error(series);
                assert!((found / exact - 1.0).abs() < 1e-6, "{i}: {found} {exact}");
            }
        }
    }

    /// Passes every window to a closure.
    struct WindowForwarder<'a>(&'a mut dyn FnMut(&Window<'_>));

    impl Observer for WindowForwarder<'_> {
        const WINDOWS: bool = true;

        fn window(&mut self, window: &Window<'_>) {
            (self.0)(window);
        }
    }

    #[test]
    fn a_record_in_two_parts_has_the_statistics_of_the_whole() {
        let model = model();
        let kernel = Volterra::new(&model, f64::EPSILON, 1000);
        let mut trajectory = model.start(&InitialState::Static);
        let mut workspace = kernel.workspace();
        let mut record = |cycles: u64, watch: &mut dyn FnMut(&Window<'_>)| {
            let mut counters = Counters::default();
            let mut show = WindowForwarder(watch);
            (kernel.advance(
                cycles,
                &mut trajectory,
                &mut workspace,
                &mut show,
                &mut counters,
            ))
            .unwrap();
        };
        let new = || Outputs::new(&model, ALL).unwrap();
        let (mut whole, mut first, mut second) = (new(), new(), new());
        record(100, &mut |_| {});
        for part in [&mut first, &mut second] {
            record(240, &mut |window| {
                whole.window(window);
                part.window(window);
            });
        }
        assert_ne!(first.centres, second.centres);
        first.append(&second);
        for quantity in [Quantity::BearingForce, Quantity::Acceleration] {
            let (a, b) = (whole.statistics(quantity), first.statistics(quantity));
            assert!(!a[0].rms.is_empty());
            for i in 0..a[0].rms.len() {
                let rms = a[0].rms[i];
                assert!((a[0].mean[i] - b[0].mean[i]).abs() < 1e-12 * rms);
                assert!((a[0].rms[i] / b[0].rms[i] - 1.0).abs() < 1e-12);
                assert!((a[1].mean[i] / b[1].mean[i] - 1.0).abs() < 1e-9);
                assert!((a[1].rms[i] / b[1].rms[i] - 1.0).abs() < 1e-9);
            }
        }
        // A record appended to an empty one is unchanged.
        let mut empty = new();
        empty.append(&whole);
        let quantity = Quantity::BearingForce;
        assert_eq!(empty.statistics(quantity), whole.statistics(quantity));
    }

    struct Recorded(Outputs);

    impl Observer for Recorded {
        const WINDOWS: bool = true;

        fn window(&mut self, window: &Window<'_>) {
            self.0.window(window);
        }
    }

    #[test]
    fn a_cut_record_is_that_of_its_first_cycles() {
        let model = model();
        let kernel = Volterra::new(&model, f64::EPSILON, 1000);
        let mut trajectory = model.start(&InitialState::Static);
        let mut workspace = kernel.workspace();
        let mut recorded = Recorded(Outputs::new(&model, ALL).unwrap());
        let mut advance = |recorded: &mut Recorded, cycles: u64| {
            let counters = &mut Counters::default();
            let state = &mut trajectory;
            let done = kernel.advance(cycles, state, &mut workspace, recorded, counters);
            done.unwrap();
        };
        advance(&mut recorded, 100);
        let first = recorded.0.clone();
        advance(&mut recorded, 70);
        let mut later = Recorded(Outputs::new(&model, ALL).unwrap());
        advance(&mut later, 100);
        let mut outputs = recorded.0;
        outputs.cut(100);
        let statistics = |outputs: &Outputs| outputs.statistics(Quantity::BearingForce);
        assert_eq!(statistics(&outputs), statistics(&first));
        for other in [first, later.0] {
            outputs.cut(0);
            outputs.append(&other);
            assert_eq!(statistics(&outputs), statistics(&other));
        }
    }
}
