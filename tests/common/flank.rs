//! A flank whose law consists of functions, for closed forms.

use gearatlas::gear::{FlankLaw, PairCompliance, PathOfContact};

type Law<T> = Box<dyn Fn(f64) -> T + Sync>;

pub struct FunctionFlank {
    pub path: PathOfContact,
    /// Slope of the lines of contact in the plane of action.
    pub helix: f64,
    pub compliance: Law<PairCompliance>,
    /// Compliance of the bodies between a pair at s and a pair some base pitches ahead.
    pub coupling: Box<dyn Fn(f64, usize) -> f64 + Sync>,
    pub relief: Law<f64>,
    /// Deviation of the flank over s and z \[m\].
    pub deviation: Box<dyn Fn(f64, f64) -> f64 + Sync>,
    pub kinks: Vec<f64>,
    /// Approach and its derivative by line load, if the contact is not linear.
    pub contact: Option<Law<[f64; 2]>>,
}

impl FunctionFlank {
    /// The same stiffness times width \[N/m²\] everywhere, and rigid gear bodies.
    pub fn constant(path: PathOfContact, stiffness: f64) -> Self {
        let compliance = split(1.0 / stiffness, 0.0);
        Self {
            path,
            helix: 0.0,
            compliance: Box::new(move |_| compliance),
            coupling: Box::new(|_, _| 0.0),
            relief: Box::new(|_| 0.0),
            deviation: Box::new(|_, _| 0.0),
            kinks: Vec::new(),
            contact: None,
        }
    }
}

/// Splits a compliance of teeth and contact, and one of the bodies, into their parts.
pub fn split(tooth: f64, foundation: f64) -> PairCompliance {
    PairCompliance {
        tooth: [0.3 * tooth, 0.5 * tooth],
        hertz: 0.2 * tooth,
        foundation: [0.4 * foundation, 0.6 * foundation],
    }
}

impl FlankLaw for FunctionFlank {
    fn path(&self) -> PathOfContact {
        self.path
    }

    fn helix(&self) -> f64 {
        self.helix
    }

    fn compliance(&self, s: f64) -> PairCompliance {
        (self.compliance)(s)
    }

    fn coupling(&self, s: f64, ahead: usize) -> f64 {
        (self.coupling)(s, ahead)
    }

    fn relief(&self, s: f64) -> f64 {
        (self.relief)(s)
    }

    fn deviation(&self, s: f64, z: f64) -> f64 {
        (self.deviation)(s, z)
    }

    fn contact(&self, s: f64, line_load: f64) -> [f64; 2] {
        let hertz = self.compliance(s).hertz;
        let linear = [hertz * line_load, hertz];
        self.contact.as_ref().map_or(linear, |law| law(line_load))
    }

    fn kinks(&self) -> Vec<f64> {
        self.kinks.clone()
    }
}

/// A path with the given contact ratio; the pitch point is at mesh phase 0.3 of the first pair.
pub fn path(contact_ratio: f64) -> PathOfContact {
    let base_pitch = 11.8e-3;
    PathOfContact {
        base_pitch,
        start: -0.3 * base_pitch,
        end: (contact_ratio - 0.3) * base_pitch,
        pitch_point: 0.0,
    }
}

/// The default drive's force at 50 N m \[N\] and its face \[m\].
pub fn default_force() -> f64 {
    50.0 / (0.04 * 20f64.to_radians().cos())
}

pub const FACE_WIDTH: f64 = 0.02;

/// Stiffness times width of the default drive's mesh \[N/m²\].
pub const STIFFNESS: f64 = 4e8 / FACE_WIDTH;

/// Misalignment of the default drive's published case \[rad\].
pub const MISALIGNMENT: f64 = 1e-3;
