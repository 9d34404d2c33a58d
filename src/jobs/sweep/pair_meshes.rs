//! How does a mesh become divisions if every pair of teeth is a separate spring? Single teeth may differ.

use super::mesh_divisions::spring_divisions;
use super::mesh_error::MeshError;
use super::shared::SharedValues;
use crate::gear::{
    Contact, Face, FaultyFlanks, FaultyTeeth, FlankLaw, Flanks, MeshSprings, MeshTableSpec,
    SecantContact,
};
use crate::manifest::{CoastSpec, PointSpec};
use crate::model::{Division, SAME_PHASE, ToothCycles};
use std::sync::Arc;

/// The divisions of the mesh cycle for every spring of a mesh. The spring that touches first is the first one.
pub(super) struct PairDivisions {
    /// Divisions of every spring, if all teeth are equal.
    pub alike: Vec<Vec<Division>>,
    /// Divisions of the springs of drive and coast flanks in every mesh cycle of a revolution, if single teeth differ;
    /// otherwise empty.
    pub tooth_cycles: ToothCycles,
}

/// The data from which the springs of pairs are made.
pub(super) struct PairSprings<'a> {
    pub spec: &'a MeshTableSpec,
    pub misalignment: f64,
    /// Slices of the face.
    pub slices: usize,
    /// Force \[N\] at which the linearised contact has the same flattening as the real one (its secant). It
    /// has no effect if the contact is linear.
    pub force: f64,
}

impl PairSprings<'_> {
    /// The divisions of a point, with the stiffness of absent springs \[N/m\].
    pub fn divisions(
        &self,
        point: &PointSpec,
        stiffness: f64,
        known: &SharedValues<Arc<MeshSprings>>,
    ) -> Result<PairDivisions, MeshError> {
        let flanks = Flanks::new(&self.spec.gears)?;
        let alike = self.springs(&flanks, None, known)?;
        let cycles = match &point.mesh.teeth {
            None => Default::default(),
            Some(teeth) => [
                self.cycles(&flanks, (teeth, 0), known)?,
                match point.mesh.coast {
                    CoastSpec::Mirrored { .. } => self.cycles(&flanks, (teeth, 1), known)?,
                    CoastSpec::SameLine => Vec::new(),
                },
            ],
        };
        let all = cycles.iter().flatten().flatten().chain([&alike]);
        let most = all.map(|springs| springs.most()).max().unwrap_or(0);
        let divisions =
            |springs: &MeshSprings| spring_divisions(springs, self.misalignment, stiffness, most);
        let alike = divisions(&alike);
        let [drive, coast] = cycles.map(|of_flank| -> Vec<Vec<Vec<Division>>> {
            let of_cycle = |springs: Option<Arc<MeshSprings>>| match springs {
                Some(springs) => divisions(&springs),
                None => alike.clone(),
            };
            of_flank.into_iter().map(of_cycle).collect()
        });
        let coast = match &point.mesh.teeth {
            Some(teeth) if !coast.is_empty() => mirrored(&coast, teeth.coast_turn()),
            _ => coast,
        };
        Ok(PairDivisions {
            alike,
            tooth_cycles: [drive, coast],
        })
    }

    /// The springs of a flank in every mesh cycle of a revolution; `None` in cycles with equal teeth.
    fn cycles(
        &self,
        flanks: &Flanks,
        (teeth, flank): (&FaultyTeeth, usize),
        known: &SharedValues<Arc<MeshSprings>>,
    ) -> Result<Vec<Option<Arc<MeshSprings>>>, MeshError> {
        (0..teeth.base_cycles())
            .map(|cycle| {
                let differs = self.faulty(flanks, teeth, [flank, cycle]).differ();
                differs
                    .then(|| self.springs(flanks, Some((teeth, [flank, cycle])), known))
                    .transpose()
            })
            .collect()
    }

    fn faulty<'l, L>(
        &self,
        law: &'l L,
        teeth: &'l FaultyTeeth,
        [flank, cycle]: [usize; 2],
    ) -> FaultyFlanks<'l, L> {
        FaultyFlanks {
            law,
            teeth,
            face_width: self.spec.gears.face_width,
            flank,
            cycle,
        }
    }

    /// The springs of the pairs of teeth on slices of the face, of equal teeth or of a cycle with faults.
    fn springs(
        &self,
        flanks: &Flanks,
        faults: Option<(&FaultyTeeth, [usize; 2])>,
        known: &SharedValues<Arc<MeshSprings>>,
    ) -> Result<Arc<MeshSprings>, MeshError> {
        let gears = &self.spec.gears;
        let line_load = match self.spec.contact {
            Contact::Linear => None,
            Contact::Secant | Contact::LoadDependent => Some(self.force / gears.face_width),
        };
        let (misalignment, slices) = (self.misalignment, self.slices);
        let key = format!("{gears:?} {line_load:?} {misalignment:e} {slices} {faults:?}");
        if let Some(springs) = known.get(&key) {
            return Ok(springs);
        }
        let springs = Arc::new(match line_load {
            None => self.of_law(flanks, faults)?,
            Some(line_load) => {
                let law = SecantContact {
                    law: flanks,
                    line_load,
                };
                self.of_law(&law, faults)?
            }
        });
        known.keep(key, &springs);
        Ok(springs)
    }

    fn of_law(
        &self,
        law: &impl FlankLaw,
        faults: Option<(&FaultyTeeth, [usize; 2])>,
    ) -> Result<MeshSprings, MeshError> {
        let face = Face {
            width: self.spec.gears.face_width,
            slices: self.slices,
        };
        let springs = match faults {
            None => MeshSprings::new(law, face, self.misalignment),
            Some((teeth, which)) => {
                MeshSprings::new(&self.faulty(law, teeth, which), face, self.misalignment)
            }
        };
        Ok(springs?)
    }
}

/// The cycles of coast flanks as mirror images of cycles of drive flanks: the time t becomes `turn − t`
/// \[cycles\]. `drive` has the springs of every cycle.
fn mirrored(drive: &[Vec<Vec<Division>>], turn: f64) -> Vec<Vec<Vec<Division>>> {
    let (whole, rest) = (turn.floor(), turn - turn.floor());
    let count = drive.len() as i64;
    (0..count)
        .map(|cycle| {
            // Up to the phase `rest`, a coast cycle mirrors one drive cycle; from there on, the drive cycle
            // before it.
            let [early, late] = [0, 1]
                .map(|before| &drive[(whole as i64 - cycle - before).rem_euclid(count) as usize]);
            let spliced = |(early, late): (&Vec<Division>, &Vec<Division>)| {
                let [early, late] =
                    [early, late].map(|divisions| Division::mirrored(divisions, 0.5 * rest));
                let within = |division: &Division| division.end <= rest + SAME_PHASE;
                let mut all: Vec<Division> = early.into_iter().filter(within).collect();
                all.extend(late.into_iter().filter(|division| !within(division)));
                all
            };
            early.iter().zip(late).map(spliced).collect()
        })
        .collect()
}
