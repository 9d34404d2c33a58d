//! What does load sharing need to know about a tooth pair? Where its flanks touch, how compliant it is, and
//! how much material is missing from its flanks.

use super::compliance::hertz;
use super::{FaceCoupling, Flanks, PairCompliance, PathOfContact};
use std::sync::Arc;

/// The law of one pair of teeth along the path of contact.
///
/// At mesh phase φ in \[0, 1) the pairs are at `s = start + (φ + j) base_pitch`, for all integers j within the reach.
/// Pairs of helical gears are at these positions at mid-face, and `z tan β_b` further at z \[m\] from mid-face. Forces
/// and deflections are along the line of action in the transverse section. Loads are per width of face.
pub trait FlankLaw: Sync {
    /// The path of contact.
    fn path(&self) -> PathOfContact;

    /// Slope of the lines of contact in the plane of action `tan β_b` \[1\]: change of a pair's position on
    /// the path per length of face. 0 for spur gears.
    fn helix(&self) -> f64 {
        0.0
    }

    /// Where pairs can touch under load \[m\]: the path of contact, and positions off the path at which tip edges touch
    /// their mates. The gap off the path is part of [`Self::relief`].
    fn reach(&self) -> [f64; 2] {
        let path = self.path();
        [path.start, path.end]
    }

    /// Compliance of a pair at s within the reach; off the path the compliance at the nearer end.
    fn compliance(&self, s: f64) -> PairCompliance;

    /// Displacement of the gear bodies at the pair at s, under a unit line load on the pair `ahead` base pitches
    /// further \[m²/N\]. Exchanging the two pairs gives the same value. 0 if the pairs are not coupled, which is the
    /// default.
    fn coupling(&self, _s: f64, _ahead: usize) -> f64 {
        0.0
    }

    /// Elastic coupling of the slices of the face; `None` if they are independent.
    fn face_coupling(&self) -> Option<Arc<FaceCoupling>> {
        None
    }

    /// Material that reliefs remove from both flanks at s, and off the path the gap under the tip edge, along
    /// the line of action \[m\].
    fn relief(&self, s: f64) -> f64;

    /// Material missing besides relief \[m\], at s and at z \[m\] from mid-face: crowning,
    /// errors of form.
    fn deviation(&self, _s: f64, _z: f64) -> f64 {
        0.0
    }

    /// Approach of the flanks by their contact under a line load \[N/m\], and its derivative:
    /// \[m\] and \[m²/N\]. By default linear, as in [`Self::compliance`].
    fn contact(&self, s: f64, line_load: f64) -> [f64; 2] {
        let hertz = self.compliance(s).hertz;
        [hertz * line_load, hertz]
    }

    /// Positions on the line of action where compliance or relief has a kink \[m\], in any order.
    fn kinks(&self) -> Vec<f64> {
        Vec::new()
    }
}

/// Forwards methods of [`FlankLaw`] to the law in a field.
macro_rules! forward {
    ($law:tt: $($method:ident($($argument:ident: $kind:ty),*) -> $value:ty;)*) => {
        $(fn $method(&self $(, $argument: $kind)*) -> $value {
            self.$law.$method($($argument),*)
        })*
    };
}
pub(super) use forward;

/// A law with a linear contact. Its contact compliance is the secant of the contact of another law at a line load.
#[derive(Debug, Clone, Copy)]
pub struct SecantContact<'a, L> {
    /// The law.
    pub law: &'a L,
    /// Line load at which the flattening equals that of the law \[N/m\], > 0.
    pub line_load: f64,
}

impl<L: FlankLaw> FlankLaw for SecantContact<'_, L> {
    forward! { law:
        path() -> PathOfContact;
        helix() -> f64;
        reach() -> [f64; 2];
        coupling(s: f64, ahead: usize) -> f64;
        face_coupling() -> Option<Arc<FaceCoupling>>;
        relief(s: f64) -> f64;
        deviation(s: f64, z: f64) -> f64;
        kinks() -> Vec<f64>;
    }

    fn compliance(&self, s: f64) -> PairCompliance {
        let [approach, _] = self.law.contact(s, self.line_load);
        PairCompliance {
            hertz: approach / self.line_load,
            ..self.law.compliance(s)
        }
    }
}

/// A law on a face with independent slices, as in thin-slice models.
#[derive(Debug, Clone, Copy)]
pub struct IndependentSlices<'a, L>(
    /// The law.
    pub &'a L,
);

impl<L: FlankLaw> FlankLaw for IndependentSlices<'_, L> {
    forward! { 0:
        path() -> PathOfContact;
        helix() -> f64;
        reach() -> [f64; 2];
        compliance(s: f64) -> PairCompliance;
        coupling(s: f64, ahead: usize) -> f64;
        relief(s: f64) -> f64;
        deviation(s: f64, z: f64) -> f64;
        contact(s: f64, line_load: f64) -> [f64; 2];
        kinks() -> Vec<f64>;
    }
}

/// Helical teeth bend and flatten in their normal section. A line of contact has the length
/// `dz/cos β_b` on a part dz of the face. A line load w_n across it therefore is w_n per width
/// of face along the transverse line of action. The approach of the flanks along that line is 1/cos β_b times
/// the one along their normal. With the compliance C_n of the spur pair of the normal section
///
/// ```text
/// F_n = w_n dz/cos β_b,   F = F_n cos β_b = w_n dz,   x = x_n/cos β_b = C_n w_n/cos β_b
/// ```
///
/// ISO 6336-1 multiplies the stiffness of that pair by cos β, 2 % less at 30°. The coupling of pairs comes from the
/// gear bodies, which are not inclined. It is that of the ring in the transverse section.
impl FlankLaw for Flanks {
    fn path(&self) -> PathOfContact {
        self.path()
    }

    fn helix(&self) -> f64 {
        self.base_helix[1]
    }

    fn reach(&self) -> [f64; 2] {
        self.reach()
    }

    fn compliance(&self, s: f64) -> PairCompliance {
        let Some(section) = &self.normal_section else {
            return self.compliance(s);
        };
        let [cos, _] = self.base_helix;
        let normal = section.compliance(s / cos);
        PairCompliance {
            tooth: normal.tooth.map(|part| part / cos),
            hertz: normal.hertz / cos,
            foundation: normal.foundation.map(|part| part / cos),
        }
    }

    fn coupling(&self, s: f64, pairs_ahead: usize) -> f64 {
        let gears = self.coupled(s, pairs_ahead);
        gears.map_or(0.0, |[pinion, wheel]| pinion + wheel)
    }

    fn face_coupling(&self) -> Option<Arc<FaceCoupling>> {
        self.face_coupling.clone()
    }

    fn relief(&self, s: f64) -> f64 {
        self.relief(s) / self.base_helix[0] + self.tip_gap(s)
    }

    fn deviation(&self, _s: f64, z: f64) -> f64 {
        self.lead(z) / self.base_helix[0]
    }

    /// Weber & Banaschek's approach. It varies as `w (C − ½ h ln w)` with the linear law's
    /// compliance h, `2/π Σ (1 − ν²)/E`; hence its derivative.
    fn contact(&self, s: f64, line_load: f64) -> [f64; 2] {
        let [cos, _] = self.base_helix;
        let approach = match &self.normal_section {
            None => self.hertz_approach(s, line_load),
            Some(section) => section.hertz_approach(s / cos, line_load) / cos,
        };
        let slope = 0.5 * hertz::linear(&self.pair.form.material) / cos;
        [approach, approach / line_load - slope]
    }

    /// Starts of reliefs, ends of the path, and positions on the path at which virtual teeth end.
    fn kinks(&self) -> Vec<f64> {
        let (path, [cos, _]) = (self.path(), self.base_helix);
        let mut kinks = [self.relief_starts(), vec![path.start, path.end]].concat();
        if let Some(section) = &self.normal_section {
            let section_path = section.path();
            let ends = [
                (section_path.start, path.start),
                (section_path.end, path.end),
            ]
            .into_iter();
            let early = ends.filter(|(place, end)| *place != end / cos);
            kinks.extend(early.map(|(place, _)| place * cos));
        }
        kinks
    }
}

impl Flanks {
    /// Material missing from both flanks at position s \[m\]: tip and root relief, crowning and slope of the profiles,
    /// profiles given by points.
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
            + (0..2)
                .map(|gear| form.profile_points[gear].at(self.roll_length(gear, s)))
                .sum::<f64>()
    }

    /// Material missing from both flanks at z from the middle of the common face \[m\]: crowning and slope of the
    /// leads, end relief, leads given by points.
    pub fn lead(&self, z: f64) -> f64 {
        let form = &self.pair.form;
        let of_gear = |gear: usize| {
            let (ends, overhang) = (form.end_relief[gear], &form.overhang[gear]);
            let [z, half] = overhang.to_gear_face(z, self.face_width);
            form.lead[gear].at(z / half)
                + ends.at(half - z)
                + ends.at(half + z)
                + form.lead_points[gear].at(z)
        };
        of_gear(0) + of_gear(1)
    }

    /// Positions along the line of action where relief has a kink \[m\].
    pub(super) fn relief_starts(&self) -> Vec<f64> {
        let (path, form) = (self.path(), &self.pair.form);
        let ([tip_1, tip_2], [root_1, root_2]) = (&form.tip_relief, &form.root_relief);
        let from_end = [tip_1, root_2].map(|relief| (relief, path.end - relief.length));
        let from_start = [tip_2, root_1].map(|relief| (relief, path.start + relief.length));
        let reliefs = (from_end.into_iter().chain(from_start))
            .filter(|(relief, _)| relief.amount != 0.0)
            .map(|(_, place)| place);
        let points = (0..2).flat_map(|gear| {
            let kinks = form.profile_points[gear].kinks();
            kinks.map(move |length| self.at_roll_length(gear, length))
        });
        reliefs.chain(points).collect()
    }
}

#[cfg(test)]
mod tests;
