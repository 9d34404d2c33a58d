//! Converts the contacts of a structure to contacts of the model: further meshes, stops, splines, stages of a
//! clutch spring.

use super::basis::Basis;
use super::direction::Directions;
use super::error::{ModelError, check_in_range};
use super::{
    Block, COAST_FLANK, Contact, Division, Drive, FlankError, MeshCycle, MeshHarmonic, Release,
    SAME_PHASE, Stiffness, TransmissionErrorHarmonic,
};
use crate::structure::{
    ContactLaw, FrictionPart, MOST_RATIO_CYCLES, SliderPart, StopPart, StructureContact,
};
use std::borrow::Cow;
use std::f64::consts::{PI, TAU};

/// A contact with its complete law. If it copies a flank of the first mesh, this is the law of that flank with equal
/// teeth and without a film: a tooth fault and the oil of the first mesh are not copied.
///
/// # Errors
/// [`ModelError::NoCopy`] if that flank has a property that no other contact can have.
pub(super) fn with_complete_law<'c>(
    contact: &'c StructureContact,
    drive: &Drive,
) -> Result<Cow<'c, StructureContact>, ModelError> {
    let Some(flank) = contact.copies else {
        return Ok(Cow::Borrowed(contact));
    };
    let of_coast = drive.coast.as_ref().filter(|_| flank == COAST_FLANK);
    let (mesh, errors, further) = match of_coast {
        Some(coast) => (&coast.mesh, &coast.transmission_error, &coast.further),
        None => (&drive.mesh, &drive.transmission_error, &drive.further),
    };
    let of_mesh = |error: &MeshHarmonic| error.cycles == 1;
    if !further.is_empty() || !errors.iter().all(of_mesh) {
        return Err(ModelError::NoCopy {
            contact: contact.name.clone(),
        });
    }
    // The error is relative to the contact's deflection. On coast flanks this deflection grows as that of the
    // drive flanks falls, so that the error changes its sign.
    let turned = if flank == COAST_FLANK { PI } else { 0.0 };
    let law = ContactLaw {
        gap: drive.half_gap,
        damping: drive.damping,
        phase: contact.law.phase,
        error: errors
            .iter()
            .map(|error| error.with_phase_lead(turned))
            .collect(),
        ..Division::law(mesh, drive.friction)
    };
    Ok(Cow::Owned(StructureContact {
        law,
        ..contact.clone()
    }))
}

impl Division {
    /// The law of a contact from divisions and a coefficient of friction. Gap, damping, phase and transmission
    /// error are 0.
    pub fn law(divisions: &[Self], friction: f64) -> ContactLaw {
        let off_middle = divisions.iter().any(|division| division.centre() != 0.0);
        let lacking = divisions.iter().any(|division| !division.error.is_none());
        let each = |any: bool| divisions.iter().filter(move |_| any);
        ContactLaw {
            stiffness: each(true)
                .map(|division| (division.end, *division.stiffness.coefficients()))
                .collect(),
            friction: each(friction != 0.0)
                .map(|division| division.friction.map(|part| friction * part))
                .collect(),
            centres: each(off_middle)
                .map(|division| division.load_centre)
                .collect(),
            lacking: each(lacking)
                .map(|division| *division.error.coefficients())
                .collect(),
            ..ContactLaw::default()
        }
    }
}

impl ContactLaw {
    /// The laws of the drive flanks and of the coast flanks of a mesh. The drive flanks have these divisions;
    /// the coast flanks have their mirror image about the phase `symmetry`. Gap, damping, phase and transmission
    /// error are those of this law, whose transmission error is that of the drive flanks.
    pub fn on_both_flanks(
        &self,
        divisions: &[Division],
        friction: f64,
        symmetry: f64,
    ) -> [Self; 2] {
        let coast = Division::mirrored(divisions, symmetry);
        [(divisions, 0.0), (&coast[..], PI)].map(|(divisions, turned)| Self {
            gap: self.gap,
            damping: self.damping,
            phase: self.phase,
            // The error is relative to the contact's deflection. On coast flanks this deflection grows as
            // that of the drive flanks falls, so that the error changes its sign.
            error: self
                .error
                .iter()
                .map(|harmonic| harmonic.with_phase_lead(turned))
                .collect(),
            ..Division::law(divisions, friction)
        })
    }
}

/// The divisions of a law.
fn divisions(law: &ContactLaw) -> Vec<Division> {
    (law.stiffness.iter().enumerate())
        .map(|(piece, &(end, series))| Division {
            end,
            stiffness: Stiffness::series(series),
            error: (law.lacking.get(piece))
                .map_or(FlankError::NONE, |error| FlankError::series(*error)),
            load_centre: law.centres.get(piece).copied().unwrap_or_default(),
            friction: law.friction.get(piece).copied().unwrap_or_default(),
        })
        .collect()
}

/// Whether a contact is a constraint that holds the structure.
fn holds(law: &ContactLaw) -> bool {
    let sticks = matches!(law.dry_friction, Some(FrictionPart::Stick { .. }));
    sticks || law.stop == Some(StopPart::Rest)
}

/// The side of a contact; 0 if it exerts forces in both directions.
fn side(law: &ContactLaw) -> f64 {
    match (law.slider, law.dry_friction) {
        (Some(SliderPart::Backwards), _) | (_, Some(FrictionPart::Backwards)) => -1.0,
        (Some(SliderPart::Spring), _) | (_, Some(FrictionPart::Stick { .. })) => 0.0,
        _ => 1.0,
    }
}

/// Checks that the stiffness of a contact is above 0 everywhere, or constant and negative. A negative stiffness softens
/// parallel contacts. An element of dry friction has its force in place of the stiffness, which must be above 0.
///
/// # Errors
/// [`ModelError::OutOfRange`].
fn check_stiffness(law: &ContactLaw, divisions: &[Division]) -> Result<(), ModelError> {
    let smallest = (divisions
        .iter()
        .map(|division| division.stiffness.smallest()))
    .reduce(f64::min);
    let smallest = smallest.unwrap_or(0.0);
    let [name, accepted] = match law.dry_friction {
        Some(_) => ["force of dry friction", "above 0 N"],
        None => [
            "contact stiffness",
            "above 0 N/m, or constant and below 0 N/m",
        ],
    };
    let softens = law.dry_friction.is_none() && smallest < 0.0 && law.is_constant();
    check_in_range(name, smallest, smallest > 0.0 || softens, accepted)
}

/// Converts a contact of a structure to a contact of the model.
///
/// * `on_bearings`: static force on each bearing per unit of its force
///   ([`crate::structure::OmittedModeForces`]).
/// * `slider`: index of the block with the position of the slider to which the contact belongs, if any.
///
/// # Errors
/// [`ModelError::OutOfRange`].
pub(super) fn contact(
    source: &StructureContact,
    release: Release,
    period: f64,
    directions: &mut Directions,
    on_bearings: &[[f64; 4]],
    (basis, blocks, slider): (&Basis, &[Block], Option<usize>),
) -> Result<Contact, ModelError> {
    let [p, q] = source.cycles;
    let law = &source.law;
    let divisions = divisions(law);
    check_stiffness(law, &divisions)?;
    check_in_range(
        "contact damping",
        law.damping,
        law.damping >= 0.0,
        "at least 0 N s/m",
    )?;
    check_in_range("contact gap", law.gap, true, "finite")?;
    let accepted = "a ratio of whole numbers from 1 to 10000";
    for count in [p, q] {
        let inside = (1..=MOST_RATIO_CYCLES).contains(&count);
        check_in_range("cycles of a contact", f64::from(count), inside, accepted)?;
    }
    let ratio = f64::from(p) / f64::from(q);
    let error: Vec<_> = (law.error.iter())
        .map(|harmonic| {
            let turns_per_cycle = harmonic.turns_per_cycle() * ratio;
            TransmissionErrorHarmonic {
                angular_frequency: TAU * turns_per_cycle / period,
                turns_per_cycle,
                amplitude: harmonic.amplitude,
                phase: harmonic.phase + TAU * harmonic.turns_per_cycle() * law.phase,
            }
        })
        .collect();
    let [mut w, mut g] = [&source.participation, &source.force].map(|column| basis.turn(column));
    let columns = [&source.tilt, &source.rubbing[0], &source.rubbing[1]];
    let [mut tilt, along, lever] = columns.map(|column| match column.as_slice() {
        [] => vec![0.0; w.len()],
        column => basis.turn(column),
    });
    // In rotations that deflect no contact, w and tilt are round-off of the transformation. Set them to 0, and remove w
    // from g, which has the same round-off.
    for &i in basis.without_contact() {
        g[i] -= w[i];
        w[i] = 0.0;
        tilt[i] = 0.0;
    }
    if let Some(block) = slider {
        w[block] = -1.0;
    }
    let holds = holds(law);
    let mut known: Vec<([f64; 3], usize)> = Vec::new();
    let mut direction = |division: &Division| {
        let [turn, arm] = division.friction;
        let law = [division.centre(), turn, arm];
        if let Some(&(_, same)) = known.iter().find(|(known_law, _)| *known_law == law) {
            return same;
        }
        let off = |i: usize| law[0] * tilt[i];
        let participation: Vec<f64> = (0..w.len()).map(|i| w[i] + off(i)).collect();
        let acts: Vec<f64> = (0..w.len())
            .map(|i| g[i] + off(i) + turn * along[i] + arm * lever[i])
            .collect();
        let weights = [1.0, law[0], turn, arm];
        let on_bearings = (on_bearings.iter())
            .map(|share| -share.iter().zip(weights).map(|(s, w)| s * w).sum::<f64>())
            .collect();
        let gains = basis.gains(blocks, &participation, &acts);
        let added = if holds {
            directions.add_stop_direction((&gains, blocks), &error, on_bearings)
        } else {
            directions.add(gains, -arm * source.sliding, &error, on_bearings)
        };
        known.push((law, added));
        added
    };
    let cycles = (0..q)
        .map(|number| {
            let start = law.phase + f64::from(number) * ratio;
            let within = stretch(&divisions, start, ratio);
            let which: Vec<usize> = within.iter().map(&mut direction).collect();
            MeshCycle::new(period, &within, &which, law.damping)
        })
        .collect::<Vec<_>>();
    let alike = cycles.iter().all(|cycle| *cycle == cycles[0]);
    Ok(Contact {
        band: f64::INFINITY,
        side: side(law),
        half_gap: law.gap,
        cycles: if alike { cycles[..1].to_vec() } else { cycles },
        release,
    })
}

/// The divisions of a mesh cycle in which a contact passes `ratio` of its own cycles, from its phase `start`.
fn stretch(divisions: &[Division], start: f64, ratio: f64) -> Vec<Division> {
    let mut out: Vec<Division> = Vec::new();
    let mut from = start;
    let same = SAME_PHASE * ratio;
    while from < start + ratio - same {
        let phase = from.rem_euclid(1.0);
        let phase = if 1.0 - phase < same { 0.0 } else { phase };
        let index = (divisions.iter())
            .position(|division| phase < division.end - same)
            .unwrap_or(divisions.len() - 1);
        let begin = if index == 0 { 0.0 } else { divisions[index - 1].end };
        let division = &divisions[index];
        let to = (from + division.end - phase).min(start + ratio);
        let length = division.end - begin;
        let place = |phase: f64| {
            let place = (2.0 * phase - begin - division.end) / length;
            // A place within rounding of an end is this end.
            if (place.abs() - 1.0).abs() < 1e-9 { place.signum() } else { place }
        };
        out.push(Division {
            end: (to - start) / ratio,
            stiffness: division
                .stiffness
                .part(place(phase), place(phase + to - from)),
            error: division.error.part(place(phase), place(phase + to - from)),
            ..*division
        });
        from = to;
    }
    if let Some(last) = out.last_mut() {
        last.end = 1.0;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Model, fixtures};
    use crate::structure::ContactLaw;

    #[test]
    fn a_slower_cycle_is_cut_into_those_of_the_mesh() {
        // Three cycles of the contact in five of the mesh. Its stiffness has two levels and a step at 0.4.
        let divisions = Division::levels(&[2.0, 1.0], &[0.4]);
        let ratio = 0.6;
        for number in 0..5 {
            let start = 0.25 + f64::from(number) * ratio;
            let within = stretch(&divisions, start, ratio);
            assert_eq!(within.last().map(|division| division.end), Some(1.0));
            let mut before = 0.0;
            for division in &within {
                let middle = start + ratio * 0.5 * (before + division.end);
                let level = if middle.rem_euclid(1.0) < 0.4 { 2.0 } else { 1.0 };
                assert_eq!(division.stiffness.mean(), level, "{number} {middle}");
                before = division.end;
            }
        }
    }

    /// The contact has one cycle in a thousand mesh cycles. Its step is 1e-12 of its cycle before the end of
    /// a mesh cycle.
    #[test]
    fn a_cycle_is_covered_to_its_end() {
        let divisions = Division::levels(&[2.0, 1.0], &[1e-3 - 1e-12]);
        for start in [0.0, 0.999, 1e-3 - 2e-12] {
            let within = stretch(&divisions, start, 1e-3);
            assert_eq!(within.last().map(|division| division.end), Some(1.0));
            let ends = within.windows(2);
            assert!(ends.into_iter().all(|pair| pair[0].end < pair[1].end));
        }
    }

    #[test]
    fn a_course_of_stiffness_goes_on_where_it_is_cut() {
        let series = [3.0, 0.7, -0.2, 0.1, 0.0, 0.0, 0.0, 0.0];
        let divisions = [Division {
            stiffness: Stiffness::series(series),
            ..Division::level(1.0, 1.0)
        }];
        let within = stretch(&divisions, 0.8, 1.5);
        let mut before = 0.0;
        for division in &within {
            for x in [-0.9, 0.1, 0.8] {
                let at = before + 0.5 * (x + 1.0) * (division.end - before);
                let phase = (0.8 + 1.5 * at).rem_euclid(1.0);
                let exact = divisions[0].stiffness.at(2.0 * phase - 1.0);
                assert!((division.stiffness.at(x) - exact).abs() < 1e-13, "{phase}");
            }
            before = division.end;
        }
    }

    #[test]
    fn cycles_of_a_contact_are_bounded() {
        let mut structure = fixtures::structure(&[0.0, 3000.0], 0.01, &[1.0, 0.3], &[1.0, 0.3]);
        let drive = fixtures::two_level_mesh(1e-5);
        let mut build = |cycles: [u32; 2], law: ContactLaw| {
            structure.contacts = vec![StructureContact {
                cycles,
                ..StructureContact::plain("stop".to_owned(), vec![0.2, 0.5], law)
            }];
            Model::new(&structure, &drive, fixtures::strong_rattle())
        };
        let law = ContactLaw {
            gap: 1e-5,
            stiffness: vec![(1.0, [1e8, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0])],
            ..ContactLaw::default()
        };
        for cycles in [[1, 1], [MOST_RATIO_CYCLES, 1], [1, MOST_RATIO_CYCLES]] {
            let model = build(cycles, law.clone()).unwrap();
            // A single level of stiffness is the same in every cycle.
            assert_eq!(model.contacts[2].cycles.len(), 1);
        }
        for wrong in [0, MOST_RATIO_CYCLES + 1] {
            for cycles in [[wrong, 1], [1, wrong]] {
                let expected = ModelError::OutOfRange {
                    name: "cycles of a contact",
                    value: f64::from(wrong),
                    accepted: "a ratio of whole numbers from 1 to 10000",
                };
                assert_eq!(build(cycles, law.clone()).unwrap_err(), expected);
            }
        }
        let soft = vec![(1.0, [0.0; 8])];
        let bad = [
            ContactLaw {
                gap: f64::NAN,
                ..law.clone()
            },
            ContactLaw {
                damping: -1.0,
                ..law.clone()
            },
            ContactLaw {
                stiffness: soft,
                ..law
            },
        ];
        for (law, about) in bad.into_iter().zip(["gap", "damping", "stiffness"]) {
            let refused = build([1, 1], law).unwrap_err();
            let about = format!("contact {about}");
            assert!(matches!(refused, ModelError::OutOfRange { name, .. } if name == about));
        }
    }
}
