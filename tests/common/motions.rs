//! Random drives with a known kind of motion: integrable, linear, or contracting under a forcing without a period.

use super::advance::advance;
use super::structure;
use gearatlas::analysis::EnergyNorm;
use gearatlas::model::{
    Division, Drive, DriveShaft, InitialState, MeshHarmonic, Model, OperatingPoint, Release,
    TorqueRipple, TrajectoryState,
};
use gearatlas::numerics::random::Stream;
use gearatlas::propagate::Volterra;
use gearatlas::structure::ModalStructure;

/// Reason for the regularity of a motion.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// One undamped mode between constant springs, without excitation: energy is conserved, and a conservative system
    /// of one degree of freedom is integrable.
    Integrable,
    /// Like [`Kind::Integrable`], with additional undamped modes without an effect on the mesh.
    Beside,
    /// Undamped modes in permanent contact with a constant stiffness, with excitation by the transmission error:
    /// linear.
    Linear,
    /// Damped modes in permanent contact under ripple without a period: linear.
    Rippled,
    /// Modes in permanent contact with a stiffness of several levels: linear with periodic coefficients.
    Parametric,
    /// A damped drive that rattles under ripple without a period.
    Torus,
}

impl Kind {
    pub const ALL: [Self; 6] = [
        Self::Integrable,
        Self::Beside,
        Self::Linear,
        Self::Rippled,
        Self::Parametric,
        Self::Torus,
    ];
}

/// A drive with an initial state.
pub struct Planted {
    pub model: Model,
    pub start: TrajectoryState,
}

/// Fractions of a period per mesh cycle that are far from every rational number.
const IRRATIONAL: [f64; 4] = [
    std::f64::consts::SQRT_2,
    1.618_033_988_749_895,
    2.236_067_977_499_79,
    std::f64::consts::FRAC_1_PI,
];

/// The drive for a seed.
pub fn planted(kind: Kind, seed: u64) -> Planted {
    let mut stream = Stream::new(seed, kind as u64, 77);
    let mut between = |low: f64, high: f64| low + (high - low) * stream.uniform();
    let decades = |between: &mut dyn FnMut(f64, f64) -> f64, low: f64, high: f64| {
        10f64.powf(between(low.log10(), high.log10()))
    };
    let half_gap = decades(&mut between, 1e-6, 1e-4);
    let mut point = OperatingPoint {
        load: decades(&mut between, 3e-3, 0.5),
        speed: decades(&mut between, 50.0, 2000.0),
    };
    let rippled = matches!(kind, Kind::Rippled | Kind::Torus);
    let lasting = matches!(kind, Kind::Linear | Kind::Rippled | Kind::Parametric);
    let felt = match kind {
        Kind::Linear | Kind::Rippled | Kind::Parametric => 1 + (between(0.0, 4.0) as usize),
        _ => 1,
    };
    let unfelt = match kind {
        Kind::Beside => 1 + (between(0.0, 3.0) as usize),
        _ => 0,
    };
    let mut frequency: Vec<f64> = (0..felt + unfelt)
        .map(|_| decades(&mut between, 300.0, 20_000.0))
        .collect();
    if between(0.0, 1.0) < 0.3 {
        frequency[0] = 0.0;
    }
    let mesh: Vec<f64> = (0..felt + unfelt)
        .map(|mode| if mode < felt { between(0.4, 1.5) } else { 0.0 })
        .collect();
    let ratio = if rippled { between(0.005, 0.05) } else { 0.0 };
    let levels = match kind {
        Kind::Parametric => 2 + (between(0.0, 5.0) as usize),
        Kind::Torus => 2,
        _ => 1,
    };
    let mean = decades(&mut between, 3e7, 1e9);
    let stiffness: Vec<f64> = (0..levels).map(|_| mean * between(0.7, 1.3)).collect();
    let structure = ModalStructure {
        pinion_torque: Some(mesh.iter().map(|w| 20.0 * w).collect()),
        ..structure(&frequency, ratio, &mesh, &vec![1.0; felt + unfelt])
    };
    if lasting {
        // The load is large enough for permanent contact.
        point.load = between(1.0, 3.0);
    }
    let drive = Drive {
        coast: None,
        half_gap,
        mesh: Division::levels(&stiffness, &[]),
        damping: match kind {
            Kind::Rippled => between(200.0, 2000.0),
            Kind::Torus => between(800.0, 4000.0),
            _ => 0.0,
        },
        friction: 0.0,
        release: Release::Deflection,
        transmission_error: match kind {
            Kind::Linear => {
                let amplitude = 0.1e-6 * between(0.0, 1.0);
                vec![MeshHarmonic::new(1, amplitude, between(0.0, 6.0))]
            }
            Kind::Torus => vec![MeshHarmonic::new(1, between(1e-6, 5e-6), 0.0)],
            _ => Vec::new(),
        },
        torque_ripple: if rippled {
            vec![TorqueRipple {
                shaft: DriveShaft::Pinion,
                order: IRRATIONAL[between(0.0, 4.0) as usize],
                amplitude: if lasting { between(0.1, 2.0) } else { between(0.5, 4.0) },
                phase: between(0.0, 6.0),
            }]
        } else {
            Vec::new()
        },
        further: Vec::new(),
        imposed_motion: Vec::new(),
        film: None,
        tooth_cycles: Default::default(),
    };
    let model = Model::new(&structure, &drive, point).unwrap();
    let mut start = model.start(&InitialState::Static);
    let norm = EnergyNorm::new(&model);
    // A kick of some half gaps.
    let kick = norm.unit() * if lasting { 0.02 } else { decades(&mut between, 0.3, 300.0) };
    for &i in norm.weighted_components() {
        start.state[i] += kick * between(-1.0, 1.0) / norm.weights()[i];
    }
    let start = TrajectoryState::new(&model, start.state, 0);
    Planted { model, start }
}

/// Whether two motions of a drive from distant states become one, within 1e-9 half gaps. Then the excitation alone
/// determines both.
pub fn contracts(model: &Model, start: &TrajectoryState, cycles: u64) -> bool {
    let norm = EnergyNorm::new(model);
    let kernel = Volterra::new(model, f64::EPSILON, 10_000);
    let mut other = start.state.clone();
    for &i in norm.weighted_components() {
        other[i] += norm.unit() / norm.weights()[i];
    }
    let other = TrajectoryState::new(model, other, start.cycle);
    let [one, two] = [start, &other].map(|from| advance(&kernel, from, cycles));
    norm.distance(&one.state, &two.state) <= 1e-9 * norm.unit()
}
