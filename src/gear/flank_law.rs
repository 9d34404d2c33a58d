//! What load sharing has to know of a tooth pair: where it meets, how it yields, what is
//! missing from its flanks.

use super::{Flanks, PairCompliance, PathOfContact};

/// The law of one pair of teeth along the path of contact.
///
/// At mesh phase φ in \[0, 1) the pairs stand at `s = start + (φ + j) base_pitch`, j whole, as far as the reach goes.
pub trait FlankLaw: Sync {
    /// The path of contact.
    fn path(&self) -> PathOfContact;

    /// Where pairs can touch under load \[m\]: the path, unless tip edges meet their mates off it, across a
    /// gap that is part of [`Self::relief`].
    fn reach(&self) -> [f64; 2] {
        let path = self.path();
        [path.start, path.end]
    }

    /// Compliance of a pair at s within the reach; off the path that of its nearer end.
    fn compliance(&self, s: f64) -> PairCompliance;

    /// What the gear bodies give at the pair at s under a unit line load on the pair `ahead`
    /// base pitches further, both in contact, and the other way round \[m²/N\]. 0: a body of
    /// its own for every pair.
    fn coupling(&self, _s: f64, _ahead: usize) -> f64 {
        0.0
    }

    /// Material removed from both flanks at s, and off the path the gap under the tip edge \[m\].
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

/// A law whose contact is linear, with the secant compliance that it has at a line load.
#[derive(Debug, Clone, Copy)]
pub struct SecantContact<'a, L> {
    /// The law.
    pub law: &'a L,
    /// Line load at which the flattening is that of the law \[N/m\], > 0.
    pub line_load: f64,
}

impl<L: FlankLaw> FlankLaw for SecantContact<'_, L> {
    fn path(&self) -> PathOfContact {
        self.law.path()
    }

    fn reach(&self) -> [f64; 2] {
        self.law.reach()
    }

    fn compliance(&self, s: f64) -> PairCompliance {
        let [approach, _] = self.law.contact(s, self.line_load);
        PairCompliance {
            hertz: approach / self.line_load,
            ..self.law.compliance(s)
        }
    }

    fn coupling(&self, s: f64, ahead: usize) -> f64 {
        self.law.coupling(s, ahead)
    }

    fn relief(&self, s: f64) -> f64 {
        self.law.relief(s)
    }

    fn deviation(&self, s: f64, z: f64) -> f64 {
        self.law.deviation(s, z)
    }

    fn kinks(&self) -> Vec<f64> {
        self.law.kinks()
    }
}

impl FlankLaw for Flanks {
    fn path(&self) -> PathOfContact {
        self.path()
    }

    fn reach(&self) -> [f64; 2] {
        self.reach()
    }

    fn compliance(&self, s: f64) -> PairCompliance {
        self.compliance(s)
    }

    fn coupling(&self, s: f64, ahead: usize) -> f64 {
        let gears = self.coupled(s, ahead);
        gears.map_or(0.0, |[pinion, wheel]| pinion + wheel)
    }

    fn relief(&self, s: f64) -> f64 {
        self.relief(s) + self.tip_gap(s)
    }

    fn deviation(&self, _s: f64, z: f64) -> f64 {
        self.lead(z)
    }

    /// Weber & Banaschek's approach. It goes with `w (C − ½ h ln w)`, h the linear law's
    /// compliance, which gives its derivative.
    fn contact(&self, s: f64, line_load: f64) -> [f64; 2] {
        let approach = self.hertz_approach(s, line_load);
        let hertz = self.compliance(s).hertz;
        [approach, approach / line_load - 0.5 * hertz]
    }

    /// Where reliefs begin, and the ends of the path.
    fn kinks(&self) -> Vec<f64> {
        let path = self.path();
        [self.relief_starts(), vec![path.start, path.end]].concat()
    }
}

impl Flanks {
    /// Material that both flanks lack at position s \[m\]: tip and root relief, crowning and slope of the profiles.
    pub fn relief(&self, s: f64) -> f64 {
        let (form, path) = (&self.pair.form, self.path());
        let s = s.clamp(path.start, path.end);
        let (before, after) = (s - path.start, path.end - s);
        let place = (before - after) / (path.end - path.start);
        form.tip_relief[0].at(after)
            + form.tip_relief[1].at(before)
            + form.root_relief[0].at(before)
            + form.root_relief[1].at(after)
            + form.profile[0].at(place)
            + form.profile[1].at(-place)
    }

    /// Material that both flanks lack at z from mid-face \[m\]: crowning and slope of the leads, end relief.
    pub fn lead(&self, z: f64) -> f64 {
        let (form, half) = (&self.pair.form, 0.5 * self.face_width);
        let own = |gear: usize| {
            let ends = form.end_relief[gear];
            form.lead[gear].at(z / half) + ends.at(half - z) + ends.at(half + z)
        };
        own(0) + own(1)
    }

    /// Positions along the line of action where relief has a kink \[m\].
    pub(super) fn relief_starts(&self) -> Vec<f64> {
        let (path, form) = (self.path(), &self.pair.form);
        let ([tip_1, tip_2], [root_1, root_2]) = (&form.tip_relief, &form.root_relief);
        let from_end = [tip_1, root_2].map(|relief| (relief, path.end - relief.length));
        let from_start = [tip_2, root_1].map(|relief| (relief, path.start + relief.length));
        (from_end.into_iter().chain(from_start))
            .filter(|(relief, _)| relief.amount != 0.0)
            .map(|(_, place)| place)
            .collect()
    }
}
