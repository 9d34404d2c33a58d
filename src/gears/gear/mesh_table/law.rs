//! How does the mesh behave at one phase of its cycle, under every load of a table?

use super::super::friction::friction_direction;
use super::super::sharing::{
    Contact, ContactPair, ContactRegion, Face, HelicalFace, LoadSharing, MOST_PAIRS, PairPoint,
    PairSeries, SharedLoad, SharingError, pairs_at,
};
use super::{MeshTableError, MeshTableInputs, StiffnessLaw};
use crate::gear::flank_law::{FlankLaw, SecantContact};
use std::collections::BTreeSet;

/// The law of a mesh by its phase, from which a mesh table is computed.
#[derive(Debug, Clone)]
pub(super) struct PhaseLaw<'a, L> {
    pub flanks: &'a L,
    pub inputs: &'a MeshTableInputs,
    /// The pairs of helical gears as series, empty for spur gears: one entry per torque with
    /// [`Contact::Secant`], otherwise one entry.
    series: Vec<PairSeries>,
}

/// A share of a pair in the load below this is round-off of 0.
const NO_SHARE: f64 = 1e-12;

/// The lines of contact at one mesh phase.
enum Lines {
    Spur(Vec<ContactPair>),
    Helical(HelicalFace),
}

impl Lines {
    /// The lines of a law, given the series of its pairs if it is helical.
    fn new(
        law: &impl FlankLaw,
        series: Option<&PairSeries>,
        phase: f64,
        face: Face,
    ) -> Result<Self, SharingError> {
        let Some(series) = series else {
            return pairs_at(law, phase, face).map(Self::Spur);
        };
        let point =
            |s: f64, ahead: usize| (series.at(s)).unwrap_or_else(|| PairPoint::new(law, s, ahead));
        HelicalFace::of_points(law, &point, phase, face).map(Self::Helical)
    }

    fn sharing(&self, face: Face, misalignment: f64) -> Result<LoadSharing, SharingError> {
        match self {
            Self::Spur(pairs) => LoadSharing::new(pairs, face, misalignment),
            Self::Helical(lines) => lines.sharing(misalignment),
        }
    }

    /// Positions on the path of contact that carry load \[m\], and their shares in the load.
    fn bearing(&self, sharing: &LoadSharing, load: &SharedLoad) -> [Vec<f64>; 2] {
        match self {
            Self::Spur(pairs) => [
                pairs.iter().map(|pair| pair.position()).collect(),
                load.share.to_vec(),
            ],
            Self::Helical(_) => sharing.lines(load.deflection),
        }
    }

    /// Number of pairs of teeth that carry load somewhere on the face.
    fn loaded_pairs(
        &self,
        sharing: &LoadSharing,
        load: &SharedLoad,
        (flanks, phase): (&impl FlankLaw, f64),
    ) -> usize {
        match self {
            Self::Spur(_) => (load.share.iter())
                .filter(|share| **share > NO_SHARE)
                .count(),
            Self::Helical(_) => {
                let loaded = sharing.loaded_lines(load.deflection, NO_SHARE);
                let (path, helix) = (flanks.path(), flanks.helix());
                // The position at mid-face identifies the tooth.
                let tooth = |[place, position]: [f64; 2]| {
                    let way = position - helix * place - path.start;
                    (way / path.base_pitch - phase).round() as i64
                };
                loaded.map(tooth).collect::<BTreeSet<_>>().len()
            }
        }
    }
}

/// All loads at one mesh phase, misalignment by misalignment.
pub(super) struct Column {
    pub phase: f64,
    pub cells: Vec<PhaseState>,
}

/// A margin below this \[m\] (or \[N/m\]) has no sign: both formulas give the same load. Rounding may choose between
/// them on a whole stretch, if two pairs have equal gaps.
const NO_MARGIN: f64 = 1e-15;

impl Column {
    /// Distances from the kinks of the law, for all loads: the law is smooth while none of their signs changes.
    pub fn margins(&self) -> impl Iterator<Item = f64> {
        self.cells
            .iter()
            .flat_map(|cell| cell.margins.iter().copied())
    }

    /// Whether the same number of pairs carries load in both columns, under every load.
    pub fn loads_as(&self, other: &Self) -> bool {
        let mut cells = self.cells.iter().zip(&other.cells);
        cells.all(|(own, other)| own.loaded_pairs == other.loaded_pairs)
    }

    /// The indices of the margins whose signs differ between two columns, beyond [`NO_MARGIN`]. Columns with such a
    /// margin have different formulas.
    pub fn kinks_before(&self, other: &Self) -> Vec<usize> {
        let signs = self.margins().zip(other.margins()).enumerate();
        signs
            .filter(|(_, (a, b))| a.abs().min(b.abs()) > NO_MARGIN && (*a > 0.0) != (*b > 0.0))
            .map(|(number, _)| number)
            .collect()
    }
}

/// Behaviour of the mesh at one phase under one load.
pub(super) struct PhaseState {
    pub stiffness: f64,
    pub centre: f64,
    pub transmission_error: f64,
    pub tangent_error: f64,
    pub friction: f64,
    pub friction_lever: f64,
    pub contact_fraction: f64,
    /// Number of pairs that carry load. It steps where a pair takes up load, so no polynomial has to follow it.
    pub loaded_pairs: f64,
    pub share: [f64; MOST_PAIRS],
    /// Distances from the kinks of the law (see [`LoadSharing::distribute_with_margins`]).
    pub margins: Vec<f64>,
    /// The part of the face in contact, if slices are coupled.
    touching: ContactRegion,
    /// Line load on each slice; empty if not requested.
    pub pattern: Vec<f64>,
}

impl PhaseState {
    /// All values that polynomials follow, in the order of [`PhaseLaw::quantities`].
    pub fn values_mut(&mut self) -> [&mut f64; 7 + MOST_PAIRS] {
        let [first, second, third] = &mut self.share;
        [
            &mut self.stiffness,
            &mut self.transmission_error,
            &mut self.tangent_error,
            &mut self.centre,
            &mut self.friction,
            &mut self.friction_lever,
            &mut self.contact_fraction,
            first,
            second,
            third,
        ]
    }
}

/// A value of the law, and the scale of its errors.
#[derive(Debug, Clone, Copy)]
pub(super) struct Quantity {
    pub name: &'static str,
    pub value: f64,
    pub scale: f64,
}

impl<'a, L: FlankLaw> PhaseLaw<'a, L> {
    pub fn new(flanks: &'a L, inputs: &'a MeshTableInputs) -> Self {
        let mut law = Self {
            flanks,
            inputs,
            series: Vec::new(),
        };
        if flanks.helix() != 0.0 {
            law.series = match inputs.contact {
                Contact::Secant => (inputs.torque.iter())
                    .map(|torque| PairSeries::new(&law.secant(*torque)))
                    .collect(),
                Contact::Linear | Contact::LoadDependent => vec![PairSeries::new(flanks)],
            };
        }
        law
    }

    /// The law with the secant of its contact under a torque.
    fn secant(&self, torque: f64) -> SecantContact<'a, L> {
        SecantContact {
            law: self.flanks,
            line_load: torque / self.inputs.base_radius / self.inputs.face_width,
        }
    }

    /// Whether slices of the face are elastically coupled and do not all carry the same load.
    pub fn is_coupled(&self) -> bool {
        let Self { flanks, inputs, .. } = self;
        let half = 0.5 * inputs.face_width;
        let slices = inputs.slices as f64;
        let gap_error = |border: usize| {
            let place = (2.0 * border as f64 / slices - 1.0) * half;
            flanks.deviation(flanks.path().pitch_point, place)
        };
        let is_misaligned = inputs.misalignment.iter().any(|angle| *angle != 0.0);
        let uneven = || (1..=inputs.slices).any(|border| gap_error(border) != gap_error(0));
        flanks.face_coupling().is_some() && (is_misaligned || uneven())
    }

    /// Stiffness, load shares and errors at a mesh phase, under every load of the table. The search for the contact
    /// starts from the contact of the column `near`, if given.
    pub fn column(&self, phase: f64, near: Option<&Column>) -> Result<Column, MeshTableError> {
        let cells = (self.cells(phase, near))
            .map_err(|source| MeshTableError::Sharing { phase, source })?;
        Ok(Column { phase, cells })
    }

    /// The columns at several phases; the search at each starts from the contact at the phase before.
    pub fn columns(
        &self,
        phases: impl IntoIterator<Item = f64>,
    ) -> Result<Vec<Column>, MeshTableError> {
        let mut columns: Vec<Column> = Vec::new();
        for phase in phases {
            columns.push(self.column(phase, columns.last())?);
        }
        Ok(columns)
    }

    fn cells(&self, phase: f64, near: Option<&Column>) -> Result<Vec<PhaseState>, SharingError> {
        let Self { flanks, inputs, .. } = *self;
        let face = Face {
            width: inputs.face_width,
            slices: inputs.slices,
        };
        let pitch_point = flanks.path().pitch_point;
        // Force on the flanks, to which friction is proportional, over the force along the transverse line
        // of action.
        let inclined = flanks.helix().hypot(1.0);
        let mut cells = Vec::with_capacity(inputs.misalignment.len() * inputs.torque.len());
        for &misalignment in &inputs.misalignment {
            for (number, &torque) in inputs.torque.iter().enumerate() {
                let series = self.series.get(number).or(self.series.last());
                let force = torque / inputs.base_radius;
                let lines = match inputs.contact {
                    Contact::Secant => Lines::new(&self.secant(torque), series, phase, face)?,
                    Contact::Linear | Contact::LoadDependent => {
                        Lines::new(flanks, series, phase, face)?
                    }
                };
                let sharing = match (&lines, inputs.contact) {
                    (_, Contact::Linear | Contact::Secant) => lines.sharing(face, misalignment)?,
                    (Lines::Helical(lines), Contact::LoadDependent) => {
                        (lines.clone()).sharing_under(flanks, misalignment, force)?
                    }
                    (Lines::Spur(_), Contact::LoadDependent) => {
                        LoadSharing::under(flanks, phase, face, misalignment, force)?
                    }
                };
                let start = near.map(|column| &column.cells[cells.len()].touching);
                let nothing = ContactRegion::default();
                let (load, margins, touching) =
                    sharing.distribute_from(force, start.unwrap_or(&nothing));
                let stiffness = match inputs.stiffness {
                    StiffnessLaw::Tangent => load.stiffness,
                    // x(0) bends where another pair becomes the first to touch. There a margin of the order of pairs
                    // changes its sign.
                    StiffnessLaw::Secant => {
                        force / (load.deflection - sharing.distribute(0.0).deflection)
                    }
                };
                let [positions, share] = lines.bearing(&sharing, &load);
                let positions: Vec<f64> = positions.iter().map(|s| s - pitch_point).collect();
                let friction = friction_direction(&positions, &share);
                let pattern = if inputs.pattern {
                    let pairs = sharing.pattern(force);
                    (0..inputs.slices)
                        .map(|slice| pairs.iter().skip(slice).step_by(inputs.slices).sum())
                        .collect()
                } else {
                    Vec::new()
                };
                cells.push(PhaseState {
                    stiffness,
                    centre: load.centre,
                    transmission_error: load.deflection,
                    tangent_error: load.deflection - force / stiffness,
                    friction: friction.direction * inclined,
                    friction_lever: friction.lever * inclined,
                    contact_fraction: load.contact_fraction,
                    loaded_pairs: lines.loaded_pairs(&sharing, &load, (flanks, phase)) as f64,
                    share: load.share,
                    margins,
                    touching,
                    pattern,
                });
            }
        }
        Ok(cells)
    }

    /// All quantities that polynomials must follow, stiffness first. The scale of deflections is
    /// the deflection of the mesh by the load.
    pub fn quantities(&self, cell: &PhaseState) -> [Quantity; 7 + MOST_PAIRS] {
        let deflection = cell.transmission_error - cell.tangent_error;
        let (width, pitch) = (self.inputs.face_width, self.flanks.path().base_pitch);
        let share = |pair: usize| ("load share", cell.share[pair], 1.0);
        [
            ("stiffness", cell.stiffness, cell.stiffness),
            ("transmission error", cell.transmission_error, deflection),
            ("tangent error", cell.tangent_error, deflection),
            ("load centroid", cell.centre, width),
            ("friction direction", cell.friction, 1.0),
            ("friction lever", cell.friction_lever, pitch),
            ("loaded part", cell.contact_fraction, 1.0),
            share(0),
            share(1),
            share(2),
        ]
        .map(|(name, value, scale)| Quantity { name, value, scale })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gear::{Flanks, GearPair, IndependentSlices, Modification, ToothForm, fixtures};
    use crate::numerics::point_course::PointCourse;

    fn flanks(crowning: f64) -> (GearPair, Flanks) {
        flanks_with(crowning, &[])
    }

    /// The pinion's lead is crowned, or goes through points.
    fn flanks_with(crowning: f64, points: &[[f64; 2]]) -> (GearPair, Flanks) {
        let crowned = Modification {
            crowning,
            ..Modification::default()
        };
        let through = PointCourse {
            points: points.to_vec(),
            ..PointCourse::default()
        };
        let form = ToothForm {
            bore: [Some(30e-3), Some(40e-3)],
            lead: [crowned, Modification::default()],
            lead_points: [through, PointCourse::default()],
            ..ToothForm::default()
        };
        let pair = fixtures::pair([20, 30], form);
        let flanks = Flanks::new(&pair).unwrap();
        (pair, flanks)
    }

    /// The coupling of slices matters if their loads differ: with misalignment or crowning.
    #[test]
    fn a_face_is_coupled_where_it_bears_unevenly() {
        // Material missing on one half of the face only, and equally everywhere.
        let [one_end, other_end] = [[2e-6, 0.0, 0.0], [0.0, 0.0, 2e-6]].map(|missing| {
            let places = [-10e-3, 0.0, 10e-3].into_iter().zip(missing);
            places
                .map(|(place, depth)| [place, depth])
                .collect::<Vec<_>>()
        });
        for (crowning, points, angle, coupled) in [
            (0.0, &[][..], 0.0, false),
            (0.0, &[], 2e-4, true),
            (3e-6, &[], 0.0, true),
            (3e-6, &[], 2e-4, true),
            (0.0, &one_end[..], 0.0, true),
            (0.0, &other_end[..], 0.0, true),
            (0.0, &[[-10e-3, 2e-6], [10e-3, 2e-6]], 0.0, false),
        ] {
            let (pair, flanks) = flanks_with(crowning, points);
            let inputs = MeshTableInputs {
                misalignment: vec![angle],
                ..MeshTableInputs::of_gears(&pair)
            };
            let law = PhaseLaw::new(&flanks, &inputs);
            assert_eq!(law.is_coupled(), coupled, "{crowning} {angle}");
            let independent = IndependentSlices(&flanks);
            let alone = PhaseLaw::new(&independent, &inputs);
            assert!(!alone.is_coupled());
        }
    }

    /// A column is the shared load of the pairs there: stiffness, error and pattern.
    #[test]
    fn a_column_is_what_the_pairs_bear() {
        let (pair, flanks) = flanks(3e-6);
        let inputs = MeshTableInputs {
            misalignment: vec![-1e-4, 2e-4],
            torque: vec![20.0, 60.0],
            slices: 8,
            pattern: true,
            ..MeshTableInputs::of_gears(&pair)
        };
        let law = PhaseLaw::new(&flanks, &inputs);
        let face = Face {
            width: inputs.face_width,
            slices: 8,
        };
        let phase = 0.2;
        let column = law.column(phase, None).unwrap();
        let pairs = pairs_at(&flanks, phase, face).unwrap();
        for (row, angle) in inputs.misalignment.iter().enumerate() {
            let sharing = LoadSharing::new(&pairs, face, *angle).unwrap();
            for (place, torque) in inputs.torque.iter().enumerate() {
                let cell = &column.cells[row * 2 + place];
                let force = torque / inputs.base_radius;
                let load = sharing.distribute(force);
                assert_eq!(cell.stiffness, load.stiffness);
                assert_eq!(cell.transmission_error, load.deflection);
                assert_eq!((cell.centre, cell.share), (load.centre, load.share));
                let total_force: f64 = cell
                    .pattern
                    .iter()
                    .map(|line| line * face.width / 8.0)
                    .sum();
                assert!(
                    (total_force / force - 1.0).abs() < 1e-9,
                    "{total_force} {force}"
                );
            }
        }
    }
}
