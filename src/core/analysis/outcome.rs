//! What is known of one operating point after its analyses: the numbers that the result
//! files hold.

use super::called_off::CalledOff;
use super::evidence::{ChaosOutcome, EvidenceOutcome};
use super::poincare_sample::PoincareSample;
use super::power_outcome::PowerOutcome;
use crate::model::Flanks;
use crate::propagate::Stop;
use serde::{Deserialize, Serialize};

/// How the work on a point ended.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum Status {
    /// Every question asked was answered.
    Ok,
    /// The cycle budget ran out before the answers settled.
    NotConverged,
    /// There are answers, and the energy balance says that they are wrong.
    Inaccurate,
    /// The state left every physical range or became non-finite.
    Diverged,
    /// More events in one mesh cycle than `run.event_limit`.
    EventStorm,
    /// The point could not be computed (a panic, an impossible model, windows that do not get on).
    Failed,
}

impl Status {
    /// The word stored in result files.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Ok => "ok",
            Self::NotConverged => "not_converged",
            Self::Inaccurate => "inaccurate",
            Self::Diverged => "diverged",
            Self::EventStorm => "event_storm",
            Self::Failed => "failed",
        }
    }

    /// Whether nothing can be relied on of the motion: inaccurate, diverged, event_storm, failed.
    pub fn is_failure(&self) -> bool {
        !matches!(self, Self::Ok | Self::NotConverged)
    }
}

impl TryFrom<Stop> for Status {
    type Error = CalledOff;

    fn try_from(stop: Stop) -> Result<Self, CalledOff> {
        match stop {
            Stop::Diverged { .. } | Stop::FarStart { .. } => Ok(Self::Diverged),
            Stop::EventStorm { .. } => Ok(Self::EventStorm),
            Stop::Stuck { .. } | Stop::Refused { .. } | Stop::Backwards { .. } => Ok(Self::Failed),
            Stop::CalledOff { .. } => Err(CalledOff),
        }
    }
}

/// What kind of motion a point settles on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Class {
    /// In contact throughout, without an event in any measured cycle, and settled: repeats after
    /// this many mesh cycles, or follows what drives it without a period.
    SteadyContact(Option<u32>),
    /// Repeats after this many mesh cycles, with events.
    Periodic(u32),
    /// On a torus: neighbours part no faster than in proportion to time, and no short period.
    QuasiPeriodic,
    /// Neighbours part exponentially, and no trajectory was seen to leave that motion.
    Chaotic,
    /// Neighbours part exponentially for a time: some trajectories settled on another motion.
    TransientChaos,
    /// None of these within the cycle budget.
    NotConverged,
}

impl Class {
    /// The word stored in result files.
    pub fn name(&self) -> &'static str {
        match self {
            Self::SteadyContact(_) => "steady_contact",
            Self::Periodic(_) => "periodic",
            Self::QuasiPeriodic => "quasi_periodic",
            Self::Chaotic => "chaotic",
            Self::TransientChaos => "transient_chaos",
            Self::NotConverged => "not_converged",
        }
    }

    /// Whether neighbours part exponentially, for a time at least.
    pub fn is_chaos(&self) -> bool {
        matches!(self, Self::Chaotic | Self::TransientChaos)
    }

    /// Period in mesh cycles, where the motion has one.
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
    /// The exponents asked for, largest first; of a settled orbit without those that round-off hides.
    pub exponents: Vec<f64>,
    /// Standard error of each, from block averages; of a settled orbit how well its multipliers
    /// are known.
    pub errors: Vec<f64>,
    /// How many dimensions the motion fills, where the exponents asked for tell.
    pub dimension: Option<KaplanYorke>,
    /// Largest exponent from a twin trajectory, where one was integrated.
    pub twin: Option<f64>,
    /// Standard error of `twin`, from block averages.
    pub twin_stderr: Option<f64>,
    /// Whether twin and tangent agree within three standard errors of their difference.
    pub twin_agrees: Option<bool>,
    /// Where the exponents come from.
    pub method: LyapunovMethod,
    /// How they settled, where that was asked for and they are averages.
    pub course: Option<CourseOutcome>,
}

impl LyapunovOutcome {
    /// Standard error of the largest exponent; infinite where there is none.
    pub fn stderr(&self) -> f64 {
        self.errors.first().copied().unwrap_or(f64::INFINITY)
    }
}

/// Kaplan–Yorke dimension of the states once a mesh cycle \[1\].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct KaplanYorke {
    /// The dimension.
    pub value: f64,
    /// Its standard error, from block averages.
    pub stderr: f64,
}

/// Running estimates of the exponents over the cycles measured.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CourseOutcome {
    /// Mesh cycles measured at each place.
    pub cycles: Vec<f64>,
    /// Mean growth so far \[1/cycle\]: of the largest exponent at all places, then of the next.
    pub exponents: Vec<f64>,
    /// Standard errors of these.
    pub errors: Vec<f64>,
}

/// Where a Lyapunov exponent comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
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
        match self {
            Self::Tangent => "tangent",
            Self::Multipliers => "multipliers",
            Self::Birkhoff => "birkhoff",
        }
    }
}

/// NVH statistics over the measured cycles; integrals are taken from the windows'
/// polynomials.
///
/// Those of a motion that repeats are exact. Of any other, extremes are the largest of `cycles`
/// mesh cycles and grow with the record; everything else has a standard error.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct NvhOutcome {
    /// Mesh cycles that the statistics are of.
    pub cycles: u64,
    /// Mean mesh deflection δ \[m\].
    pub deflection_mean: f64,
    /// Root mean square of δ about its mean \[m\].
    pub deflection_rms: f64,
    /// Largest minus smallest δ \[m\].
    pub deflection_pp: f64,
    /// Largest |δ − mean| \[m\].
    pub deflection_peak: f64,
    /// Largest |δ − mean| of a mesh cycle that 99 and 99.9 % of the cycles do not exceed \[m\].
    pub deflection_peak_quantiles: Vec<f64>,
    /// Largest |δ − mean| over RMS \[1\].
    pub deflection_crest: f64,
    /// Fourth central moment over squared variance \[1\].
    pub deflection_kurtosis: f64,
    /// Amplitudes of δ at mesh orders 1, 2, … \[m\].
    pub harmonics: Vec<f64>,
    /// Amplitudes of δ at mesh orders 1/4, 1/3, 1/2, 2/3, 3/4 \[m\]; of a motion that does
    /// not repeat, root mean squares over windows of 24 mesh cycles. Empty where not asked
    /// for or before one window.
    pub suborders: Vec<f64>,
    /// Mean mesh force \[N\].
    pub force_mean: f64,
    /// Standard deviation of the mesh force \[N\].
    pub force_std: f64,
    /// Largest |mesh force| \[N\].
    pub force_peak: f64,
    /// Largest |mesh force| of a mesh cycle that 99 and 99.9 % of the cycles do not exceed \[N\].
    pub force_peak_quantiles: Vec<f64>,
    /// Mean power lost in friction on the flanks \[W\]; none where it is not known at which places they touch.
    pub power_loss: Option<f64>,
    /// Mean power that goes through the mesh from the pinion to the wheel, `F r_b1 Ω₁` \[W\]; none without a drawing.
    pub power_transmitted: Option<f64>,
    /// One less the loss over the modulus of what goes through; none where nothing does.
    pub efficiency: Option<f64>,
    /// Coulomb friction coefficient of the flanks; none without a drawing.
    pub friction_coefficient: Option<f64>,
    /// Power that the vibration takes in and gives off; none where not asked for.
    pub power: Option<PowerOutcome>,
    /// Impacts (entries into contact) on the drive and on the coast flank.
    pub impacts: [u64; 2],
    /// Impacts a second \[1/s\].
    pub impact_rate: f64,
    /// Mean |δ'| at entry into contact \[m/s\].
    pub impact_velocity: f64,
    /// Kinetic energy that meets in impacts a second, `½ m_e Σ δ'²/t` \[W\].
    pub impact_power: f64,
    /// Sum of |δ'| at entries into contact a second, `Σ |δ'|/t` \[m/s²\].
    pub rattle_index: f64,
    /// Median, 90 % and 99 % quantiles of |δ'| at entry into contact \[m/s\]; empty without impacts.
    pub impact_velocity_quantiles: Vec<f64>,
    /// Largest |δ'| at entry into contact \[m/s\].
    pub impact_velocity_max: Option<f64>,
    /// Flights between two contacts.
    pub flights: DurationOutcome,
    /// Contacts between two flights.
    pub contacts: DurationOutcome,
    /// Mean force that presses each contact together \[N\]: drive and coast flank of the first mesh, then further contacts in
    /// the order of the model.
    pub contact_force: Vec<f64>,
    /// Fraction of time while each contact is closed.
    pub contact_fraction: Vec<f64>,
    /// Impacts a second of each contact \[1/s\].
    pub contact_impact_rate: Vec<f64>,
    /// `Σ |δ'|/t` of each contact \[m/s²\].
    pub contact_rattle_index: Vec<f64>,
    /// Power lost in friction on each contact at the speeds of the mean rotation \[W\]; empty where no drawing says how the
    /// gears roll.
    pub contact_loss: Vec<f64>,
    /// Mean force of the shafts on every bearing and direction \[N\]; empty where not asked for.
    pub bearing_mean: Vec<f64>,
    /// Root mean square about the mean \[N\].
    pub bearing_rms: Vec<f64>,
    /// Mean torque in every shaft and coupling \[N m\]; empty where not asked for.
    pub torque_mean: Vec<f64>,
    /// Root mean square about the mean \[N m\].
    pub torque_rms: Vec<f64>,
    /// Root mean square of the acceleration of every bearing's place and direction \[m/s²\]; empty
    /// where not asked for.
    pub acceleration_rms: Vec<f64>,
    /// Root mean square of the angular acceleration of every body \[rad/s²\].
    pub angular_acceleration_rms: Vec<f64>,
    /// Root mean squares of the deflections of all meshes about their means \[m\]; empty where not asked for.
    pub mesh_deflection_rms: Vec<f64>,
    /// Those of their forces \[N\].
    pub mesh_force_rms: Vec<f64>,
    /// Fraction of time in drive contact alone, free flight, coast contact alone, and contact on both
    /// flanks.
    pub fractions: [f64; Flanks::COUNT],
    /// Standard errors; none for a motion that repeats and for short records.
    pub stderr: Option<NvhErrors>,
}

/// How long stays in one state last.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct DurationOutcome {
    /// Stays that began and ended while measured.
    pub count: u64,
    /// Mean length \[s\].
    pub mean: Option<f64>,
    /// Median length \[s\].
    pub median: Option<f64>,
}

/// Standard errors of NVH statistics, each in the unit of the statistic of its name;
/// infinite where too little was seen.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs, reason = "named and described as in NvhOutcome")]
pub struct NvhErrors {
    pub deflection_mean: f64,
    pub deflection_rms: f64,
    pub deflection_peak_quantiles: Vec<f64>,
    pub deflection_kurtosis: f64,
    pub harmonics: Vec<f64>,
    pub suborders: Vec<f64>,
    pub force_mean: f64,
    pub force_std: f64,
    pub force_peak_quantiles: Vec<f64>,
    pub power_loss: f64,
    pub power_transmitted: f64,
    pub efficiency: f64,
    pub power: Option<PowerOutcome>,
    pub impact_rate: f64,
    pub impact_velocity: f64,
    pub impact_power: f64,
    pub rattle_index: f64,
    pub impact_velocity_quantiles: Vec<f64>,
    pub flight_mean: f64,
    pub flight_median: f64,
    pub contact_mean: f64,
    pub contact_median: f64,
    pub contact_force: Vec<f64>,
    pub contact_fraction: Vec<f64>,
    pub contact_impact_rate: Vec<f64>,
    pub contact_rattle_index: Vec<f64>,
    pub contact_loss: Vec<f64>,
    pub bearing_mean: Vec<f64>,
    pub bearing_rms: Vec<f64>,
    pub torque_mean: Vec<f64>,
    pub torque_rms: Vec<f64>,
    pub acceleration_rms: Vec<f64>,
    pub angular_acceleration_rms: Vec<f64>,
    pub mesh_deflection_rms: Vec<f64>,
    pub mesh_force_rms: Vec<f64>,
    pub fractions: [f64; Flanks::COUNT],
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
    /// Its standard error; none where it is exact and where too little was seen.
    pub stderr: Option<f64>,
}

/// How a spectrum was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum SpectrumMethod {
    /// Exact lines of a motion that repeats.
    Fourier,
    /// Averaged power of overlapping windows.
    Welch,
}

impl SpectrumMethod {
    /// The word stored in result files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Fourier => "fourier",
            Self::Welch => "welch",
        }
    }
}

/// A spectrum of one signal.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Spectrum {
    /// `deflection`, `force`, or `bearing`, `torque`, `acceleration` or `angular acceleration` with a place.
    pub signal: String,
    /// Unit of the signal.
    pub unit: String,
    /// How the lines were found.
    pub method: SpectrumMethod,
    /// Noise bandwidth of a line \[Hz\]; none of exact lines.
    pub bandwidth: Option<f64>,
    /// Its lines, ascending in frequency.
    pub lines: Vec<SpectrumLine>,
}

/// A signal at one order, `amplitude cos(ωt + phase)` with t from the start of mesh cycle 0.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OrderLine {
    /// What the order is a multiple of: `mesh`, `pinion`, `wheel`, or a further mesh or shaft by its name.
    pub reference: String,
    /// Which multiple.
    pub multiple: u32,
    /// Multiple of the mesh frequency \[1\].
    pub order: f64,
    /// Frequency \[Hz\].
    pub frequency: f64,
    /// Peak value, in the signal's unit; of a motion that does not repeat that of the part that
    /// keeps its phase.
    pub amplitude: f64,
    /// Its standard error; none where it is exact and where too little was seen.
    pub stderr: Option<f64>,
    /// Phase \[rad\]; none where there is no amplitude.
    pub phase: Option<f64>,
    /// Its standard error \[rad\].
    pub phase_stderr: Option<f64>,
}

/// A signal at its orders.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SignalOrders {
    /// As of [`Spectrum`].
    pub signal: String,
    /// Unit of the signal.
    pub unit: String,
    /// Mesh orders, then those of both shafts.
    pub lines: Vec<OrderLine>,
}

/// Everything known of one point.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PointOutcome {
    /// How the work ended.
    pub status: Status,
    /// One sentence: why this status and this class.
    pub reason: String,
    /// Kind of motion; absent when the point was not integrated to an end.
    pub class: Option<Class>,
    /// Lyapunov exponents, when asked for.
    pub lyapunov: Option<LyapunovOutcome>,
    /// NVH statistics, when asked for.
    pub nvh: Option<NvhOutcome>,
    /// Spectra, when asked for.
    pub spectra: Vec<Spectrum>,
    /// Amplitudes and phases at orders, when asked for.
    pub orders: Vec<SignalOrders>,
    /// Poincaré samples, when asked for.
    pub poincare: Vec<PoincareSample>,
    /// Contact-state changes per measured cycle.
    pub events_per_cycle: Option<f64>,
    /// Energy imbalance over the audited cycles, relative to the energy turned over and stored.
    pub energy_residual: Option<f64>,
    /// How much was seen of a motion that does not settle.
    pub evidence: Option<EvidenceOutcome>,
    /// How long chaos lasts, where there was any.
    pub chaos: Option<ChaosOutcome>,
    /// Tangencies met, over the whole simulation.
    pub grazing_count: u64,
    /// Mesh cycles integrated in all, transient and probes included (the twin not counted).
    pub cycles: u64,
    /// Mesh cycles measured.
    pub measured_cycles: u64,
}

impl PointOutcome {
    /// A point of which nothing is known but how its work ended.
    pub fn unanswered(status: Status, reason: String) -> Self {
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
