//! Comparison of kernels with closed forms.

use super::candidate::Candidate;
use super::drives::{self, quiet, structure};
use super::report::worse;
use super::{CheckError, Line, Subjects};
use crate::model::{
    ActiveSet, Drive, DriveShaft, InitialState, Model, OperatingPoint, TorqueRipple,
};
use crate::shaft::{RigidDrive, Tier};
use nalgebra::{DMatrix, Schur};
use std::f64::consts::PI;

/// Compares the multipliers of kernels with the eigenvalues of a product of matrix exponentials. In constant
/// contact a mesh cycle is one affine map.
pub fn multipliers(subjects: &Subjects) -> Result<Vec<Line>, CheckError> {
    let mut lines = Vec::new();
    let mut exact = Vec::new();
    for case in &subjects.cases {
        let model = case.in_constant_contact().model()?;
        exact.push((constant_contact_exponents(&model)?, model));
    }
    for kernel in &subjects.kernels {
        let mut worst = 0.0f64;
        for (exponents, model) in &exact {
            let start = model.start(&InitialState::Static);
            let multipliers = kernel.on(model)?.multipliers(model, &start)?;
            let multipliers = multipliers.ok_or(CheckError::Missing {
                what: "an eigenvalue of the kernel's map",
            })?;
            for (multipliers, exact) in multipliers.iter().zip(exponents) {
                worst = worse(worst, (multipliers.norm().ln() - exact).abs());
            }
            if multipliers.len() != exponents.len() {
                worst = f64::NAN;
            }
        }
        lines.push(Line::at_most(
            format!(
                "{}: ln|multiplier| in contact, {} drives",
                kernel.name,
                exact.len()
            ),
            "eigenvalues of matrix exponentials",
            worst,
            1e-11,
            "1/cycle",
        ));
    }
    Ok(lines)
}

/// Exponents per cycle of the affine map of constant contact, the largest first. The map is the product of
/// matrix exponentials of the linear part of [`Model::derivative`], without neutral blocks.
///
/// Exponentials (Padé, scaling and squaring) and eigenvalues (Schur) are computed by nalgebra. Kernels and
/// their multipliers do not use this library.
///
/// # Errors
/// [`CheckError::Missing`] if an eigenvalue does not converge.
pub fn constant_contact_exponents(model: &Model) -> Result<Vec<f64>, CheckError> {
    /// Size of a state at which the constant part of the derivative disappears in round-off.
    const LARGE: f64 = 1e6;
    /// Largest number of steps of the Schur iteration per row.
    const STEPS_PER_ROW: usize = 1000;
    let n = model.modes();
    let components: Vec<usize> = (0..2 * n)
        .filter(|i| !model.neutral.contains(&(i % n)))
        .collect();
    let m = components.len();
    let natural = model.blocks.iter().map(|block| block.natural_frequency());
    let fastest = natural.fold(2e4, f64::max);
    // Divide velocities by the fastest frequency, which keeps the entries of the matrix similar in size.
    let unit = |i: usize| if i < n { 1.0 } else { fastest };
    let mut map = DMatrix::<f64>::identity(m, m);
    for (index, segment) in model.first_cycle().segments.iter().enumerate() {
        let field = |state: &[f64]| {
            let mut out = vec![f64::NAN; 2 * n];
            let segments = vec![*segment; model.contacts.len()];
            model.derivative(&segments, ActiveSet::DRIVE, 0, 0.0, state, &mut out);
            out
        };
        let offset = field(&vec![0.0; 2 * n]);
        let column = |&j: &usize| {
            let mut state = vec![0.0; 2 * n];
            state[j] = LARGE * unit(j);
            field(&state)
        };
        let columns: Vec<Vec<f64>> = components.iter().map(column).collect();
        let duration = model.first_cycle().end(index) - model.first_cycle().start(index);
        let generator = DMatrix::from_fn(m, m, |row, column| {
            let i = components[row];
            duration * (columns[column][i] - offset[i]) / (LARGE * unit(i))
        });
        map = generator.exp() * map;
    }
    let schur =
        Schur::try_new(map, f64::EPSILON, STEPS_PER_ROW * m).ok_or(CheckError::Missing {
            what: "an eigenvalue of the exponentials",
        })?;
    let moduli = schur.complex_eigenvalues();
    let mut exponents: Vec<f64> = moduli.iter().map(|z| z.norm().ln()).collect();
    exponents.sort_by(|a, b| b.total_cmp(a));
    Ok(exponents)
}

const GAP: f64 = 10e-6;

/// A unit mass between stops at ± [`GAP`], on a spring κ², with the damping ratio ζ and a harmonic force.
struct ShakenMass {
    speed: f64,
    /// Constant force \[N/√kg\].
    push: f64,
    /// Phase of the excitation, so that the mass reaches the stop within a mesh cycle.
    phase: f64,
}

impl ShakenMass {
    const NATURAL: f64 = 4000.0;
    const RATIO: f64 = 0.02;

    fn forcing(&self) -> f64 {
        20.0 * self.speed
    }

    /// `κ² − ω²` and `2 ζ κ ω`.
    fn impedance(&self) -> [f64; 2] {
        let forcing = self.forcing();
        [
            Self::NATURAL * Self::NATURAL - forcing * forcing,
            2.0 * Self::RATIO * Self::NATURAL * forcing,
        ]
    }

    /// Amplitude of the force at which the mass just reaches a stop, `A = d √((κ² − ω²)² + (2 ζ κ ω)²)`. Here
    /// d is the distance of the stop from the deflection under the constant force.
    fn grazing(&self) -> f64 {
        let [stiff, loss] = self.impedance();
        (GAP - self.push / (Self::NATURAL * Self::NATURAL)) * stiff.hypot(loss)
    }

    fn model(&self, amplitude: f64) -> Result<Model, CheckError> {
        let mut structure = structure(&[Self::NATURAL], Self::RATIO, &[1.0], &[1.0]);
        structure.rated_force = 1.0;
        structure.pinion_torque = Some(vec![1.0]);
        let drive = Drive {
            torque_ripple: vec![TorqueRipple {
                shaft: DriveShaft::Pinion,
                // The mesh frequency, because the pinion has 20 teeth.
                order: 20.0,
                amplitude,
                phase: self.phase,
            }],
            ..quiet(GAP, &[1.44e8], &[], 480.0)
        };
        let point = OperatingPoint {
            load: self.push,
            speed: self.speed,
        };
        Ok(Model::new(&structure, &drive, point)?)
    }

    /// Whether a motion that starts in the forced vibration reaches a stop within two mesh cycles.
    fn touches(&self, kernel: &Candidate, amplitude: f64) -> Result<bool, CheckError> {
        let model = self.model(amplitude)?;
        let [stiff, loss] = self.impedance();
        let size = amplitude / stiff.hypot(loss);
        let angle = self.phase - loss.atan2(stiff);
        let start = model.start(&InitialState::Modal {
            displacement: vec![self.push / (Self::NATURAL * Self::NATURAL) + size * angle.cos()],
            velocity: vec![-size * self.forcing() * angle.sin()],
        });
        Ok(!kernel.on(&model)?.passage(&start, 2)?.events.is_empty())
    }
}

/// The amplitude of excitation at which the mass first touches a stop, by bisection between "no event" and
/// "some events".
pub fn grazing(subjects: &Subjects) -> Result<Vec<Line>, CheckError> {
    let mut lines = Vec::new();
    for kernel in &subjects.kernels {
        let mut worst = 0.0f64;
        for speed in [120.0, 190.0, 205.0, 300.0] {
            for (push, phase) in [(0.0, -2.0), (40.0, 0.3), (90.0, 1.7)] {
                let case = ShakenMass { speed, push, phase };
                let exact = case.grazing();
                let (mut never, mut always) = (0.9 * exact, 1.1 * exact);
                while always - never > 1e-12 * exact {
                    let middle = 0.5 * (never + always);
                    if case.touches(kernel, middle)? { always = middle } else { never = middle }
                }
                worst = worse(worst, (0.5 * (never + always) / exact - 1.0).abs());
            }
        }
        lines.push(Line::at_most(
            format!("{}: amplitude that touches a stop", kernel.name),
            "d sqrt((k - w^2)^2 + c^2 w^2)",
            worst,
            1e-11,
            "relative",
        ));
    }
    Ok(lines)
}

/// A mass that falls onto an undamped spring and bounces without end. The load gives the acceleration a, and
/// `ω² = k Σ w²`. Over the half gap b the mass reaches the speed `v = √(2 a b)`. Then times
/// `2 (π − atan(ω v / a)) / ω` in contact with the spring and times `2 v / a` in free flight alternate.
pub fn bouncing(subjects: &Subjects) -> Result<Vec<Line>, CheckError> {
    let (participation, stiffness) = (1.3f64, 4e8f64);
    let structure = structure(&[0.0], 0.0, &[participation], &[participation]);
    let drive = quiet(GAP, &[stiffness], &[], 0.0);
    let point = OperatingPoint {
        load: 0.05,
        speed: 1200.0,
    };
    let model = Model::new(&structure, &drive, point)?;
    let pull = participation * participation * structure.rated_force * point.load;
    let natural = participation * stiffness.sqrt();
    let speed = (2.0 * pull * GAP).sqrt();
    let contact = 2.0 * (PI - (natural * speed / pull).atan()) / natural;
    let flight = 2.0 * speed / pull;
    let bounces = subjects.extent.pick(100, 10_000);
    let exact = |event: usize| {
        let whole = (event / 2) as f64 * (contact + flight);
        let rest = if event % 2 == 1 { contact } else { 0.0 };
        speed / pull + whole + rest
    };
    let last = exact(2 * bounces - 1);
    let cycles = (last / model.period()).ceil() as u64;
    let mut lines = Vec::new();
    for kernel in &subjects.kernels {
        let passage = kernel
            .on(&model)?
            .passage(&model.start(&InitialState::Rest), cycles)?;
        let mut worst = if passage.events.len() < 2 * bounces { f64::NAN } else { 0.0 };
        for (index, event) in passage.events.iter().take(2 * bounces).enumerate() {
            let time = event.cycle as f64 + event.time / model.period();
            worst = worse(worst, (time - exact(index) / model.period()).abs());
        }
        lines.push(Line::at_most(
            format!("{}: times of {bounces} bounces", kernel.name),
            "parabolas and half sines in turn",
            worst,
            // The error grows with the square of the number of bounces, because a drift of the energy changes
            // their period.
            subjects.extent.pick(1e-10, 1e-6) * kernel.round_off,
            "cycles",
        ));
    }
    Ok(lines)
}

/// Two rigid bodies on the mesh spring, `ω = √(k (r₁²/J₁ + r₂²/J₂))`. The angle of the multipliers gives ω
/// after all steps: drawing, assembly, modes, kernel.
pub fn rigid_pair(subjects: &Subjects) -> Result<Vec<Line>, CheckError> {
    let shafts = drives::shafts()?;
    let radii = shafts.gears.base_radii().into_iter();
    let parts = radii
        .zip(drives::inertias(&shafts))
        .map(|(radius, inertia)| radius * radius / inertia);
    let inverse_mass: f64 = parts.sum();
    let stiffness = 4e8;
    let exact = (stiffness * inverse_mass).sqrt();
    let pair = RigidDrive {
        tier: Tier::Torsional,
        gears: shafts.gears,
        shafts: shafts.shafts,
        pedestals: None,
        density: shafts.density,
        damping: 0.0,
        damping_overrides: Vec::new(),
        gyroscopic: false,
    };
    let drive = quiet(GAP, &[stiffness], &[], 0.0);
    // A mesh cycle is shorter than half a period, so that the angle determines the frequency.
    let point = OperatingPoint {
        load: 1.0,
        speed: 4000.0,
    };
    let model = Model::new(&pair.modes(2, 2, false)?, &drive, point)?;
    let mut lines = Vec::new();
    for kernel in &subjects.kernels {
        let start = model.start(&InitialState::Static);
        let multipliers = kernel.on(&model)?.multipliers(&model, &start)?;
        let multipliers = multipliers.and_then(|multipliers| multipliers.first().copied());
        let leading = multipliers.ok_or(CheckError::Missing {
            what: "a multiplier of the pair",
        })?;
        let frequency = leading.arg().abs() / model.period();
        lines.push(Line::at_most(
            format!("{}: rigid pair, {exact:.0} rad/s", kernel.name),
            "sqrt(k (r1^2/J1 + r2^2/J2))",
            (frequency / exact - 1.0).abs(),
            1e-12,
            "relative",
        ));
    }
    Ok(lines)
}
