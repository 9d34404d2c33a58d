//! What load sharing has to know of a tooth pair: where it meets, how it yields, what is
//! missing from its flanks.

/// The path of contact on the line of action. Positions s \[m\] count from the pitch point
/// in the sense in which contacts move, pinion driving.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathOfContact {
    /// Distance of successive pairs along the line of action \[m\].
    pub base_pitch: f64,
    /// Where a pair comes into contact, < 0 \[m\].
    pub start: f64,
    /// Where it leaves contact, > 0 \[m\].
    pub end: f64,
    /// The pitch point, where sliding reverses \[m\].
    pub pitch_point: f64,
}

/// How one pair yields: compliance times face width \[m²/N\], `[pinion, wheel]`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairCompliance {
    /// The teeth themselves.
    pub tooth: [f64; 2],
    /// The contact of the flanks.
    pub hertz: f64,
    /// The gear bodies below the teeth, common to all pairs in contact.
    pub foundation: [f64; 2],
}

/// The law of one pair of teeth along the path of contact.
///
/// At mesh phase φ in \[0, 1) the pairs in contact stand at `s = start + (φ + j) base_pitch`,
/// j = 0, 1, …, as far as the path goes.
pub trait FlankLaw: Sync {
    /// The path of contact.
    fn path(&self) -> PathOfContact;

    /// Compliance of a pair at s, `start ≤ s ≤ end`.
    fn compliance(&self, s: f64) -> PairCompliance;

    /// Material removed from both flanks at s \[m\].
    fn relief(&self, s: f64) -> f64;

    /// What is missing besides relief \[m\], at s and at z \[m\] from mid-face: crowning,
    /// errors of form.
    fn deviation(&self, _s: f64, _z: f64) -> f64 {
        0.0
    }

    /// Approach of the flanks by their contact under a line load \[N/m\], and its derivative:
    /// \[m\] and \[m²/N\]. Linear, as in [`Self::compliance`], unless the law knows better.
    fn contact(&self, s: f64, line_load: f64) -> [f64; 2] {
        let hertz = self.compliance(s).hertz;
        [hertz * line_load, hertz]
    }

    /// Positions inside the path where compliance or relief has a kink \[m\].
    fn kinks(&self) -> Vec<f64> {
        Vec::new()
    }
}
