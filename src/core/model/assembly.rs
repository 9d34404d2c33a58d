//! The contacts of a model: springs and film layers of both flanks of the first mesh, then those of the structure.

use super::basis::Basis;
use super::contact::base_cycles;
use super::direction::Directions;
use super::error::{ModelError, check_in_range};
use super::{
    Block, Contact, Division, Drive, FilmLayer, MOST_CONTACTS, MeshCycle, MeshHarmonic, Release,
    Slider, TransmissionErrorHarmonic,
};
use super::{bearing, flank_springs, one_set, structure_contacts};
use crate::structure::{
    FlankParticipation, FrictionPart, MOST_BASE_CYCLES, ModalStructure, SliderPart, StopPart,
};
use std::borrow::Cow;

/// A rotation about the shafts does not tilt them. A tilt of such a rotation below this fraction of the
/// largest tilt of any mode is round-off.
const TILT_NOISE: f64 = 1e-9;

/// Input of the assembly of contacts.
pub struct Assembly<'a> {
    pub structure: &'a ModalStructure,
    pub drive: &'a Drive,
    pub basis: &'a Basis,
    pub blocks: &'a [Block],
    pub sliders: &'a [Slider],
    /// Mesh cycle \[s\].
    pub period: f64,
}

/// The contacts, and the directions of their forces on the blocks.
pub struct Assembled {
    pub contacts: Vec<Contact>,
    /// Number of contacts of the two flanks: springs and layers of the film.
    pub flank_springs: usize,
    pub directions: Directions,
}

/// The drive flanks or the coast flanks of the first mesh.
struct Side {
    /// The divisions of its springs, by mesh cycle and spring. Without faulty teeth there is one cycle.
    springs: Vec<Vec<Vec<Division>>>,
    flank: FlankParticipation,
    error: Vec<TransmissionErrorHarmonic>,
    /// Static force on every bearing per unit force of the flank, with the entries of `OmittedModeForces::drive`.
    on_bearings: Vec<[f64; 4]>,
}

/// Selects divisions from those of all springs of a flank in one mesh cycle.
type Divisions<'f> = &'f dyn for<'d> Fn(&'d [Vec<Division>]) -> Cow<'d, [Division]>;

impl Assembly<'_> {
    /// Assembles the contacts.
    ///
    /// # Errors
    /// Springs that cannot share a residual flexibility, an invalid contact, too many contacts, too long a base period.
    pub fn contacts(&self) -> Result<Assembled, ModelError> {
        let mut directions = Directions::default();
        let mut contacts = self.flanks(&mut directions)?;
        let flank_springs = contacts.len();
        for number in 0..self.structure.contacts.len() {
            contacts.push(self.of_structure(number, flank_springs, &mut directions)?);
        }
        one_set::merge(&mut contacts);
        let (name, count) = ("number of contacts", contacts.len() as f64);
        let fits = count <= MOST_CONTACTS as f64;
        check_in_range(name, count, fits, "at most 128, both flanks included")?;
        let (name, base) = ("base period of all contacts", base_cycles(&contacts));
        let fits = base <= MOST_BASE_CYCLES;
        check_in_range(name, base as f64, fits, "at most 10000 mesh cycles")?;
        Ok(Assembled {
            contacts,
            flank_springs,
            directions,
        })
    }

    /// The springs of both flanks, alternating, then the layers of the film.
    fn flanks(&self, directions: &mut Directions) -> Result<Vec<Contact>, ModelError> {
        let (structure, drive) = (self.structure, self.drive);
        let [drive_teeth, coast_teeth] = &drive.tooth_cycles;
        let of_drive_flank = structure.drive_flank();
        let drive_side = Side {
            springs: springs((&drive.mesh, &drive.further), drive_teeth, &of_drive_flank)?,
            flank: self.turned(&of_drive_flank),
            error: self.errors(&drive.transmission_error),
            on_bearings: bearing::on_each(structure, |share| share.drive),
        };
        let coast_side = match &drive.coast {
            None => None,
            Some(coast) => {
                let of_coast_flank = structure.coast.as_ref().unwrap_or(&of_drive_flank);
                Some(Side {
                    springs: springs((&coast.mesh, &coast.further), coast_teeth, of_coast_flank)?,
                    flank: self.turned(of_coast_flank),
                    error: self.errors(&coast.transmission_error),
                    on_bearings: bearing::on_each(structure, |share| match structure.coast {
                        Some(_) => share.coast,
                        None => share.drive,
                    }),
                })
            }
        };
        // The cycles of a spring or layer on each flank, with the side of the flank.
        let mut on_flanks = |divisions: Divisions<'_>, damping: f64| {
            let on_drive = self.cycles(&drive_side, divisions, damping, directions);
            let on_coast = match &coast_side {
                None => on_drive.clone(),
                Some(side) => self.cycles(side, divisions, damping, directions),
            };
            [(1.0, on_drive), (-1.0, on_coast)]
        };
        let mut contacts = Vec::new();
        for number in 0..=drive.further.len() {
            // The first spring of a flank has the damper of the flank.
            let damping = if number == 0 { drive.damping } else { 0.0 };
            let cycles = on_flanks(&|springs| Cow::from(&springs[number]), damping);
            contacts.extend(cycles.map(|(side, cycles)| Contact {
                side,
                half_gap: drive.half_gap,
                cycles,
                release: release(drive.release, damping),
                band: f64::INFINITY,
            }));
        }
        // A layer has the error of the first spring, also at a faulty tooth: it ends where this spring closes.
        for layer in self.film_layers() {
            let [from, to] = layer.distance;
            let cycles = on_flanks(
                &|springs| springs[0].iter().map(Division::without_spring).collect(),
                layer.damping,
            );
            contacts.extend(cycles.map(|(side, cycles)| Contact {
                side,
                half_gap: drive.half_gap - from,
                cycles,
                release: Release::Film,
                band: from - to,
            }));
        }
        Ok(contacts)
    }

    /// The layers of the film of oil.
    fn film_layers(&self) -> Vec<FilmLayer> {
        let film = self.drive.film.as_ref();
        film.map_or_else(Vec::new, |film| film.layers(self.drive.half_gap))
    }

    /// The mesh cycles of a contact on a flank, with a damping \[N s/m\]. `divisions` are those of the contact in
    /// a mesh cycle with the given springs of the flank.
    fn cycles(
        &self,
        side: &Side,
        divisions: Divisions<'_>,
        damping: f64,
        directions: &mut Directions,
    ) -> Vec<MeshCycle> {
        let cycle = |springs: &Vec<Vec<Division>>| {
            let divisions = divisions(springs);
            let which = directions.of_flank(
                &side.flank,
                &divisions,
                self.drive.friction,
                &side.error,
                &side.on_bearings,
                (self.basis, self.blocks),
            );
            MeshCycle::new(self.period, &divisions, &which, damping)
        };
        side.springs.iter().map(cycle).collect()
    }

    /// The transmission error of a flank over time.
    fn errors(&self, of_mesh: &[MeshHarmonic]) -> Vec<TransmissionErrorHarmonic> {
        (of_mesh.iter())
            .map(|harmonic| TransmissionErrorHarmonic::of_mesh(harmonic, self.period))
            .collect()
    }

    /// Participations of a flank in the rotated modes. Entries of `mesh` for rotations that do not deflect the flank
    /// are exactly zero.
    fn turned(&self, flank: &FlankParticipation) -> FlankParticipation {
        let basis = self.basis;
        let independent =
            (basis.rigid().split_last()).map_or(&[][..], |(_, independent)| independent);
        FlankParticipation {
            mesh: without_rotations(basis.turn(&flank.mesh), independent),
            tilt: tilt_without_round_off(basis.turn(&flank.tilt), independent),
            friction: basis.turn(&flank.friction),
            lever: basis.turn(&flank.lever),
            residual_flexibility: flank.residual_flexibility,
        }
    }

    /// The model's contact for contact `number` of the structure.
    fn of_structure(
        &self,
        number: usize,
        flank_springs: usize,
        directions: &mut Directions,
    ) -> Result<Contact, ModelError> {
        let structure_contact =
            &structure_contacts::with_complete_law(&self.structure.contacts[number], self.drive)?;
        let release = match (
            structure_contact.law.slider,
            structure_contact.law.stop,
            structure_contact.law.dry_friction,
        ) {
            (Some(SliderPart::Spring), ..) => Release::Stick,
            (Some(_), ..) => Release::Slip,
            (_, Some(StopPart::Impact { .. }), _) => Release::Impact,
            (_, Some(StopPart::Rest), _) => Release::Rest,
            (.., Some(FrictionPart::Stick { .. })) => Release::Grip,
            (.., Some(_)) => Release::Rub,
            (None, None, None) => release(self.drive.release, structure_contact.law.damping),
        };
        let slider = (self.sliders.iter())
            .find(|slider| slider.has(flank_springs + number))
            .map(|slider| slider.block);
        let on_bearings = bearing::on_each(self.structure, |share| {
            share.contacts.get(number).copied().unwrap_or_default()
        });
        let to = (self.basis, self.blocks, slider);
        structure_contacts::contact(
            structure_contact,
            release,
            self.period,
            directions,
            &on_bearings,
            to,
        )
    }
}

/// The springs of a flank in series with its residual flexibility, as [`Side::springs`]. `alike` are the first and
/// the further springs of equal teeth; `teeth` the springs in every cycle if single teeth differ.
///
/// # Errors
/// As [`flank_springs::of_flank`].
fn springs(
    alike: (&[Division], &[Vec<Division>]),
    teeth: &[Vec<Vec<Division>>],
    flank: &FlankParticipation,
) -> Result<Vec<Vec<Vec<Division>>>, ModelError> {
    if teeth.is_empty() {
        return Ok(vec![flank_springs::of_flank(alike.0, alike.1, flank)?]);
    }
    (teeth.iter())
        .map(|springs| flank_springs::of_flank(&springs[0], &springs[1..], flank))
        .collect()
}

/// Release rule of a contact with a damping \[N s/m\]. Without a damper the force vanishes where δ returns to
/// the gap, so that both rules are equal.
fn release(asked: Release, damping: f64) -> Release {
    if damping > 0.0 { asked } else { Release::Deflection }
}

/// A participation without the round-off of the transformation. By construction of the basis, the entries of
/// the `rigid` blocks, which do not deflect the mesh, are zero.
fn without_rotations(mut mesh: Vec<f64>, rigid: &[usize]) -> Vec<f64> {
    for &i in rigid {
        mesh[i] = 0.0;
    }
    mesh
}

/// A tilt whose entries in the `rigid` blocks are zero if they are only round-off: a rotation about the shafts does not
/// tilt them.
fn tilt_without_round_off(mut tilt: Vec<f64>, rigid: &[usize]) -> Vec<f64> {
    let noise = TILT_NOISE * tilt.iter().fold(0.0_f64, |most, t| most.max(t.abs()));
    for &i in rigid {
        if tilt[i].abs() <= noise {
            tilt[i] = 0.0;
        }
    }
    tilt
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tilts_of_rotations_are_kept_beyond_round_off() {
        let kept = tilt_without_round_off(vec![1e-12, 0.5, -1.0, 1e-12], &[0, 1]);
        assert_eq!(kept, [0.0, 0.5, -1.0, 1e-12]);
        assert_eq!(
            without_rotations(vec![0.5, 0.1, 1e-17], &[2]),
            [0.5, 0.1, 0.0]
        );
    }
}
