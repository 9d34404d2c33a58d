//! Breakpoints of contacts that nearly coincide: every kernel passes them, and the motion is that of coinciding
//! breakpoints.

use super::right;
use gearatlas::model::{
    CoastFlank, Division, Drive, FlankError, InitialState, MeshHarmonic, Model, OperatingPoint,
    Release, Stiffness,
};
use gearatlas::propagate::{
    ClosedModes, Counters, Event, Kernel, KernelChoice, KernelUse, Observer, Stop, TableError,
    Window,
};
use gearatlas::structure::{ContactLaw, FlankParticipation, ModalStructure, StructureContact};

/// Every kernel.
pub const KERNELS: [KernelChoice; 3] = [
    KernelChoice::Volterra,
    KernelChoice::ClosedModes,
    KernelChoice::Stepping { steps: 3200 },
];

/// Kind of the two breakpoints.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Of {
    /// Steps of one stiffness.
    Levels,
    /// Steps of the stiffness of the drive and of the coast flank, which have separate lines.
    Flanks,
    /// Kinks of the stiffness of flanks that are mirror images of one another.
    Kinks,
    /// A kink of the coast flank, and the ends of the cycle.
    Ends,
    /// A step of the gap of one flank and of the stiffness of the other; the flanks never pull.
    Gap,
    /// Steps of the stiffness of the mesh and of a further contact.
    Further,
}

/// All kinds.
pub const ALL: [Of; 6] = [
    Of::Levels,
    Of::Flanks,
    Of::Kinks,
    Of::Ends,
    Of::Gap,
    Of::Further,
];

/// Two breakpoints of one kind, and the kernel.
#[derive(Debug, Clone, Copy)]
pub struct Case {
    pub of: Of,
    /// Mesh phase of the first, in units of 1/32.
    pub place: u8,
    /// Distance of the two \[cycles\].
    pub apart: f64,
    /// Index in [`KERNELS`].
    pub kernel: usize,
}

/// Compared cycles.
const CYCLES: u64 = 3;
const EVENT_LIMIT: u32 = 1000;

/// The bytes select kernel, kind, place, and the distance: its sign, its exponent from −16 to −6 and a digit.
pub fn breakpoints(data: &[u8]) {
    let byte = |place: usize| data.get(place).copied().unwrap_or_default();
    let size = f64::from(byte(4) % 90 + 10) / 10.0 * 10.0_f64.powi(-16 + i32::from(byte(3) % 11));
    _ = passes(Case {
        of: ALL[usize::from(byte(1)) % ALL.len()],
        place: byte(2) % 30 + 1,
        apart: if byte(5) % 2 == 0 { size } else { -size },
        kernel: usize::from(byte(0)) % KERNELS.len(),
    });
}

/// Checks a case; returns whether its kernel supports it.
pub fn passes(case: Case) -> bool {
    let Ok(found) = motion(case) else {
        return false;
    };
    let together = Case { apart: 0.0, ..case };
    let Ok(exact) = motion(together) else {
        return false;
    };
    judge(case, found, exact);
    true
}

/// Compares a motion with that of coinciding breakpoints.
pub fn judge(case: Case, found: Result<Motion, Stop>, exact: Result<Motion, Stop>) {
    let (found, exact) = match (found, exact) {
        (Ok(found), Ok(exact)) => (found, exact),
        stopped => {
            right(false, || format!("{case:?}: {stopped:?}"));
            return;
        }
    };
    right(found.windows <= 2 * exact.windows + 100, || {
        format!("{case:?}: {} windows, not {}", found.windows, exact.windows)
    });
    right((found.shown - CYCLES as f64).abs() < 1e-9, || {
        format!("{case:?}: windows of {} cycles were shown", found.shown)
    });
    let events = |motion: &Motion| -> Vec<_> {
        let events = motion.events.iter();
        events
            .map(|&(_, contact, closes)| (contact, closes))
            .collect()
    };
    right(events(&found) == events(&exact), || {
        format!("{case:?}: {:?}, not {:?}", found.events, exact.events)
    });
    // Allowed distance of neighbouring motions after three cycles.
    let most = 1e-8 + 1e3 * case.apart.abs();
    for (own, other) in found.events.iter().zip(&exact.events) {
        right((own.0 - other.0).abs() < most, || {
            format!("{case:?}: an event at {} and not at {}", own.0, other.0)
        });
    }
}

/// The compared motion.
#[derive(Debug, Default)]
pub struct Motion {
    /// Time \[cycles\], contact, whether it closes.
    pub events: Vec<(f64, usize, bool)>,
    /// Cycles covered by windows.
    shown: f64,
    windows: u64,
    period: f64,
}

impl Observer for Motion {
    const WINDOWS: bool = true;

    fn window(&mut self, window: &Window<'_>) {
        self.shown += window.duration / self.period;
    }

    fn event(&mut self, event: &Event) {
        let time = event.cycle as f64 + event.time / self.period;
        self.events.push((time, event.contact, event.closes()));
    }
}

struct Passing<'m>(&'m Model);

impl KernelUse for Passing<'_> {
    type Output = Result<Motion, Stop>;

    fn with<K: Kernel + Sync>(self, kernel: &K) -> Self::Output {
        moved(self.0, kernel)
    }
}

/// The motion of a model by a kernel.
///
/// # Errors
/// The kernel stops.
pub fn moved<K: Kernel>(model: &Model, kernel: &K) -> Result<Motion, Stop> {
    let mut trajectory = model.start(&InitialState::Static);
    let mut counters = Counters::default();
    let mut motion = Motion {
        period: model.period(),
        ..Motion::default()
    };
    let mut workspace = kernel.workspace();
    kernel.advance(
        CYCLES,
        &mut trajectory,
        &mut workspace,
        &mut motion,
        &mut counters,
    )?;
    motion.windows = counters.windows;
    Ok(motion)
}

/// The motion of a case; an error if its kernel does not support it.
pub fn motion(case: Case) -> Result<Result<Motion, Stop>, TableError> {
    let model = model(case);
    let kept = || ClosedModes::arrays(&model).map(Box::new);
    KERNELS[case.kernel].apply(&model, EVENT_LIMIT, kept, Passing(&model))
}

/// The model of a case: a rigid and two elastic modes that rattle.
pub fn model(case: Case) -> Model {
    let own = [1.0, 0.3, 0.2];
    let mut structure = ModalStructure {
        teeth: 20,
        wheel_teeth: Some(30),
        rated_force: 1330.0,
        ..ModalStructure::of_modes(&[0.0, 3000.0, 5200.0], 0.02, &own, &own)
    };
    let place = f64::from(case.place) / 32.0;
    let other = place + case.apart;
    let levels = |stiffness: &[f64], at: &[f64]| Division::levels(stiffness, at);
    let bent = |mean: f64| Stiffness::series([mean, 4e7, -2e7, 0.0, 0.0, 0.0, 0.0, 0.0]);
    let mut drive = Drive {
        half_gap: 1e-5,
        mesh: levels(&[4.4e8, 3.3e8], &[place]),
        further: Vec::new(),
        damping: 1483.0,
        friction: 0.0,
        release: Release::Deflection,
        coast: None,
        transmission_error: vec![MeshHarmonic::new(1, 5e-6, 0.0)],
        torque_ripple: Vec::new(),
        imposed_motion: Vec::new(),
        tooth_cycles: Default::default(),
        film: None,
    };
    let coast = |mesh: Vec<Division>| CoastFlank {
        mesh,
        further: Vec::new(),
        transmission_error: vec![MeshHarmonic::new(1, 5e-6, 0.0)],
    };
    match case.of {
        Of::Levels => {
            let (first, last) = (place.min(other), place.max(other));
            if first < last {
                drive.mesh = levels(&[4.4e8, 4e8, 3.3e8], &[first, last]);
            }
            return built(&structure, &drive);
        }
        Of::Flanks => drive.coast = Some(coast(levels(&[3e8, 4.1e8], &[other]))),
        Of::Kinks | Of::Ends => {
            for (division, mean) in drive.mesh.iter_mut().zip([4e8, 3.4e8]) {
                division.stiffness = bent(mean);
            }
            let symmetry = match case.of {
                Of::Kinks => place + 0.5 * case.apart,
                _ => 0.5 + 0.5 * case.apart,
            };
            drive.coast = Some(coast(Division::mirrored(&drive.mesh, symmetry)));
        }
        Of::Gap => {
            drive.release = Release::Force;
            drive.mesh[1].error = FlankError::series([1e-6, 3e-7, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
            drive.coast = Some(coast(levels(&[3e8, 4.1e8], &[other])));
        }
        Of::Further => {
            let series = |mean: f64| [mean, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
            let participation = vec![0.4, -0.5, 0.6];
            structure.contacts = vec![StructureContact {
                name: "stop".to_owned(),
                force: participation.clone(),
                tilt: Vec::new(),
                rubbing: Default::default(),
                sliding: 0.0,
                participation,
                cycles: [1, 1],
                law: ContactLaw {
                    gap: 5e-6,
                    stiffness: vec![(other, series(1e8)), (1.0, series(1.4e8))],
                    damping: 50.0,
                    ..ContactLaw::default()
                },
                copies: None,
            }];
        }
    }
    if drive.coast.is_some() {
        structure.coast = Some(FlankParticipation {
            mesh: vec![1.0, -0.3, 0.4],
            tilt: vec![0.0; own.len()],
            friction: own.to_vec(),
            lever: vec![0.0; own.len()],
            residual_flexibility: 0.0,
        });
    }
    built(&structure, &drive)
}

fn built(structure: &ModalStructure, drive: &Drive) -> Model {
    let point = OperatingPoint {
        load: 0.05,
        speed: 1200.0,
    };
    Model::new(structure, drive, point).expect("a model")
}
