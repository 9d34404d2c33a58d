//! The results of an operating point after its analyses. The result files contain them.

use super::evidence::{ChaosOutcome, EvidenceOutcome};
use super::interrupt::Interrupted;
use super::poincare_sample::PoincareSample;
use super::power_outcome::PowerOutcome;
use crate::model::FlankState;
use crate::propagate::Stop;
use serde::{Deserialize, Serialize};
use strum::IntoStaticStr;

/// How the work on a point ended.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, IntoStaticStr)]
#[strum(serialize_all = "snake_case")]
pub enum Status {
    /// All requested results are complete.
    Ok,
    /// The cycle budget ran out before the results settled.
    NotConverged,
    /// There are results, but the energy balance does not close.
    Inaccurate,
    /// The state left every physical range or became non-finite.
    Diverged,
    /// More events in one mesh cycle than `run.event_limit`.
    EventStorm,
    /// The point could not be computed: a panic, an impossible model, windows without progress, contacts without a
    /// table, or a drive that stops or turns back.
    Failed,
}

impl Status {
    /// The word stored in result files.
    pub fn name(&self) -> &'static str {
        self.into()
    }

    /// Whether the results are unreliable: inaccurate, diverged, event_storm, failed.
    pub fn is_failure(&self) -> bool {
        !matches!(self, Self::Ok | Self::NotConverged)
    }
}

impl TryFrom<Stop> for Status {
    type Error = Interrupted;

    fn try_from(stop: Stop) -> Result<Self, Interrupted> {
        match stop {
            Stop::Diverged { .. } | Stop::FarStart { .. } => Ok(Self::Diverged),
            Stop::EventStorm { .. } => Ok(Self::EventStorm),
            Stop::Stuck { .. } | Stop::Refused { .. } | Stop::Backwards { .. } => Ok(Self::Failed),
            Stop::Interrupted { .. } => Err(Interrupted),
        }
    }
}

/// Kind of motion on which a point settles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, IntoStaticStr)]
#[strum(serialize_all = "snake_case")]
pub enum Class {
    /// In contact throughout, without an event in any measured cycle, and settled: repeats after this number
    /// of mesh cycles, or follows an excitation without a period.
    SteadyContact(Option<u32>),
    /// Repeats after this number of mesh cycles, with events.
    Periodic(u32),
    /// On a torus: neighbours separate at most in proportion to time, and there is no short period.
    QuasiPeriodic,
    /// Neighbours separate exponentially, and no trajectory left this motion.
    Chaotic,
    /// Neighbours separate exponentially for a time: some trajectories settled on another motion.
    TransientChaos,
    /// The motion fits no other class within the cycle budget.
    NotConverged,
}

impl Class {
    /// The word stored in result files.
    pub fn name(&self) -> &'static str {
        self.into()
    }

    /// Whether neighbours separate exponentially, at least for a time.
    pub fn is_chaos(&self) -> bool {
        matches!(self, Self::Chaotic | Self::TransientChaos)
    }

    /// Period in mesh cycles, if the motion has one.
    pub fn period(&self) -> Option<u32> {
        match self {
            Self::SteadyContact(period) => *period,
            Self::Periodic(k) => Some(*k),
            _ => None,
        }
    }
}

/// Lyapunov exponents of a point, all per mesh cycle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct LyapunovOutcome {
    /// The requested exponents, largest first; for a settled orbit without those that round-off hides.
    pub exponents: Vec<f64>,
    /// Standard error of each exponent, from block averages; for a settled orbit the accuracy of its multipliers.
    pub errors: Vec<f64>,
    /// Dimension of the motion, if the requested exponents determine it.
    pub dimension: Option<KaplanYorke>,
    /// Largest exponent from a twin trajectory, if one was integrated.
    pub twin: Option<f64>,
    /// Standard error of `twin`, from block averages.
    pub twin_stderr: Option<f64>,
    /// Whether twin and tangent agree within three standard errors of their difference.
    pub twin_agrees: Option<bool>,
    /// Method that gave the exponents.
    pub method: LyapunovMethod,
    /// Running estimates, if requested and the exponents are averages.
    pub convergence: Option<ConvergenceOutcome>,
}

impl LyapunovOutcome {
    /// Standard error of the largest exponent; infinite if there is none.
    pub fn stderr(&self) -> f64 {
        self.errors.first().copied().unwrap_or(f64::INFINITY)
    }
}

/// Kaplan–Yorke dimension of the states once per mesh cycle \[1\].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct KaplanYorke {
    /// The dimension.
    pub value: f64,
    /// Standard error of the dimension, from block averages.
    pub stderr: f64,
}

/// Running estimates of the exponents over the cycles measured.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ConvergenceOutcome {
    /// Number of mesh cycles behind each estimate.
    pub cycles: Vec<f64>,
    /// Running means of the growth \[1/cycle\]: all estimates of the largest exponent, then those of the next
    /// one.
    pub exponents: Vec<f64>,
    /// Standard errors of the estimates.
    pub errors: Vec<f64>,
}

/// Method that gave a Lyapunov exponent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, IntoStaticStr)]
#[strum(serialize_all = "snake_case")]
pub enum LyapunovMethod {
    /// Average growth of tangent vectors over the measured cycles.
    Tangent,
    /// Multipliers of the settled periodic orbit: `ln|μ| / k`.
    Multipliers,
    /// Weighted average of growth over a motion on a torus, which converges faster.
    Birkhoff,
}

impl LyapunovMethod {
    /// The word stored in result files.
    pub fn name(&self) -> &'static str {
        self.into()
    }
}

/// NVH statistics over the measured cycles; integrals use the windows' polynomials.
///
/// Statistics of a periodic motion are exact. For any other motion, extremes are the largest of `cycles`
/// mesh cycles and grow with the record; the statistics in `values` have standard errors.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct NvhOutcome {
    /// Mesh cycles in the statistics.
    pub cycles: u64,
    /// The statistics that have standard errors.
    pub values: NvhStatistics,
    /// Standard errors of [`Self::values`], infinite for a statistic with too few data; `None` for periodic motions and
    /// short records.
    pub stderr: Option<NvhStatistics>,
    /// Largest minus smallest δ \[m\].
    pub deflection_pp: f64,
    /// Largest |δ − mean| \[m\].
    pub deflection_peak: f64,
    /// Largest |δ − mean| over RMS \[1\].
    pub deflection_crest: f64,
    /// Largest |mesh force| \[N\].
    pub force_peak: f64,
    /// Coulomb friction coefficient of the flanks; `None` if the geometry of the gears is unknown.
    pub friction_coefficient: Option<f64>,
    /// Impacts (entries into contact) on the drive and on the coast flank.
    pub impacts: [u64; 2],
    /// Largest |δ'| at entry into contact \[m/s\].
    pub impact_velocity_max: Option<f64>,
    /// Number of complete flights: their start and their end lie in the measurement.
    pub flights: u64,
    /// Number of complete contacts: their start and their end lie in the measurement.
    pub contacts: u64,
}

/// Statistics that have standard errors, or these errors, each in the unit of its statistic.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct NvhStatistics {
    /// Mean mesh deflection δ \[m\].
    pub deflection_mean: f64,
    /// Root mean square of δ about its mean \[m\].
    pub deflection_rms: f64,
    /// Quantiles (99 and 99.9 %) of the largest |δ − mean| per mesh cycle \[m\].
    pub deflection_peak_quantiles: Vec<f64>,
    /// Fourth central moment over squared variance \[1\].
    pub deflection_kurtosis: f64,
    /// Amplitudes of δ at mesh orders 1, 2, … \[m\].
    pub harmonics: Vec<f64>,
    /// Amplitudes of δ at mesh orders 1/4, 1/3, 1/2, 2/3, 3/4 \[m\]; root mean squares over windows of 24
    /// mesh cycles if the motion does not repeat. Empty if not requested or before one window.
    pub suborders: Vec<f64>,
    /// Mean mesh force \[N\].
    pub force_mean: f64,
    /// Standard deviation of the mesh force \[N\].
    pub force_std: f64,
    /// Quantiles (99 and 99.9 %) of the largest |mesh force| per mesh cycle \[N\].
    pub force_peak_quantiles: Vec<f64>,
    /// Mean power lost in friction on the flanks \[W\]; `None` if the geometry of the gears is unknown.
    pub power_loss: Option<f64>,
    /// Mean power through the mesh from the pinion to the wheel, `F r_b1 Ω₁` \[W\]; `None` if the geometry of
    /// the gears is unknown.
    pub power_transmitted: Option<f64>,
    /// One minus the loss over the modulus of the transmitted power; `None` if no power is transmitted.
    pub efficiency: Option<f64>,
    /// Power input and output of the vibration; `None` if not requested.
    pub power: Option<PowerOutcome>,
    /// Impacts per second \[1/s\].
    pub impact_rate: f64,
    /// Mean |δ'| at entry into contact \[m/s\].
    pub impact_velocity: f64,
    /// Kinetic energy of impacts per second, `½ m_e Σ δ'²/t` \[W\].
    pub impact_power: f64,
    /// Sum of |δ'| at entries into contact per second, `Σ |δ'|/t` \[m/s²\].
    pub rattle_index: f64,
    /// Median, 90 % and 99 % quantiles of |δ'| at entry into contact \[m/s\]; empty without impacts.
    pub impact_velocity_quantiles: Vec<f64>,
    /// Mean length of a flight \[s\].
    pub flight_mean: Option<f64>,
    /// Median length of a flight \[s\].
    pub flight_median: Option<f64>,
    /// Mean length of a contact \[s\].
    pub contact_mean: Option<f64>,
    /// Median length of a contact \[s\].
    pub contact_median: Option<f64>,
    /// Mean compressive force of each contact \[N\]: drive and coast flank of the first mesh, then further
    /// contacts in the order of the model.
    pub contact_force: Vec<f64>,
    /// Fraction of time with each contact closed.
    pub contact_fraction: Vec<f64>,
    /// Impacts per second of each contact \[1/s\].
    pub contact_impact_rate: Vec<f64>,
    /// `Σ |δ'|/t` of each contact \[m/s²\].
    pub contact_rattle_index: Vec<f64>,
    /// Power lost in friction on each contact at the speeds of the mean rotation \[W\]; empty if the geometry
    /// of the gears is unknown.
    pub contact_loss: Vec<f64>,
    /// Mean force of the shafts on every bearing and direction \[N\]; empty if not requested.
    pub bearing_mean: Vec<f64>,
    /// Root mean square of these forces about their means \[N\].
    pub bearing_rms: Vec<f64>,
    /// Mean torque in every shaft and coupling \[N m\]; empty if not requested.
    pub torque_mean: Vec<f64>,
    /// Root mean square of these torques about their means \[N m\].
    pub torque_rms: Vec<f64>,
    /// Root mean square of the acceleration of every bearing's place and direction \[m/s²\]; empty if not
    /// requested.
    pub acceleration_rms: Vec<f64>,
    /// Root mean square of the angular acceleration of every body \[rad/s²\].
    pub angular_acceleration_rms: Vec<f64>,
    /// Root mean squares of the deflections of all meshes about their means \[m\]; empty if not requested.
    pub mesh_deflection_rms: Vec<f64>,
    /// Root mean squares of the forces of all meshes about their means \[N\].
    pub mesh_force_rms: Vec<f64>,
    /// Fraction of time in drive contact alone, free flight, coast contact alone, and contact on both
    /// flanks.
    pub fractions: [f64; FlankState::COUNT],
}

/// One line of an amplitude spectrum.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct SpectrumLine {
    /// Frequency \[Hz\].
    pub frequency: f64,
    /// Multiple of the mesh frequency \[1\].
    pub order: f64,
    /// Amplitude: peak value of an equivalent sine, in the signal's unit.
    pub amplitude: f64,
    /// Standard error of the amplitude; `None` if the line is exact or the record too short.
    pub stderr: Option<f64>,
}

/// Method that gave a spectrum.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, IntoStaticStr)]
#[strum(serialize_all = "snake_case")]
pub enum SpectrumMethod {
    /// Exact lines of a motion that repeats.
    Fourier,
    /// Averaged power of overlapping segments.
    Welch,
}

impl SpectrumMethod {
    /// The word stored in result files.
    pub fn name(self) -> &'static str {
        self.into()
    }
}

/// A spectrum of one signal.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Spectrum {
    /// `deflection`, `force`, or `bearing`, `torque`, `acceleration` or `angular acceleration` with a place.
    pub signal: String,
    /// Unit of the signal.
    pub unit: String,
    /// Method that gave the lines.
    pub method: SpectrumMethod,
    /// Noise bandwidth of a line \[Hz\]; `None` for exact lines.
    pub bandwidth: Option<f64>,
    /// Lines of the spectrum, ascending in frequency.
    pub lines: Vec<SpectrumLine>,
}

/// A signal at one order, `amplitude cos(ωt + phase)` with t from the start of mesh cycle 0.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OrderLine {
    /// Reference of the order: `mesh`, `pinion`, `wheel`, or a further mesh or shaft by its name.
    pub reference: String,
    /// Multiple of the reference.
    pub multiple: u32,
    /// Multiple of the mesh frequency \[1\].
    pub order: f64,
    /// Frequency \[Hz\].
    pub frequency: f64,
    /// Peak value, in the signal's unit. For a motion that does not repeat, it is the peak value of the part
    /// with a constant phase.
    pub amplitude: f64,
    /// Standard error of the amplitude; `None` if the line is exact or the record too short.
    pub stderr: Option<f64>,
    /// Phase \[rad\]; `None` if the amplitude is zero.
    pub phase: Option<f64>,
    /// Standard error of the phase \[rad\].
    pub phase_stderr: Option<f64>,
}

/// A signal at its orders.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SignalOrders {
    /// As in [`Spectrum`].
    pub signal: String,
    /// Unit of the signal.
    pub unit: String,
    /// Orders of the meshes, then of the shafts.
    pub lines: Vec<OrderLine>,
}

/// All results of one point.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PointOutcome {
    /// How the work ended.
    pub status: Status,
    /// One sentence: why this status and this class.
    pub reason: String,
    /// Kind of motion; absent if the point was not integrated to its end.
    pub class: Option<Class>,
    /// Lyapunov exponents, if requested.
    pub lyapunov: Option<LyapunovOutcome>,
    /// NVH statistics, if requested.
    pub nvh: Option<NvhOutcome>,
    /// Spectra, if requested.
    pub spectra: Vec<Spectrum>,
    /// Amplitudes and phases at orders, if requested.
    pub orders: Vec<SignalOrders>,
    /// Poincaré samples, if requested.
    pub poincare: Vec<PoincareSample>,
    /// Contact-state changes per measured cycle.
    pub events_per_cycle: Option<f64>,
    /// Energy imbalance over the audited cycles, relative to the absolute works and the stored energy.
    pub energy_residual: Option<f64>,
    /// How much of a motion that does not settle was measured.
    pub evidence: Option<EvidenceOutcome>,
    /// Life of chaos, if there was any.
    pub chaos: Option<ChaosOutcome>,
    /// Tangencies over the whole simulation.
    pub grazing_count: u64,
    /// Mesh cycles integrated in total. Transient and probes are included, the twin is not.
    pub cycles: u64,
    /// Mesh cycles measured.
    pub measured_cycles: u64,
}

impl PointOutcome {
    /// The outcome of a point without results.
    pub fn without_results(status: Status, reason: String) -> Self {
        Self {
            status,
            reason,
            class: None,
            lyapunov: None,
            nvh: None,
            spectra: Vec::new(),
            orders: Vec::new(),
            poincare: Vec::new(),
            events_per_cycle: None,
            energy_residual: None,
            evidence: None,
            chaos: None,
            grazing_count: 0,
            cycles: 0,
            measured_cycles: 0,
        }
    }
}
