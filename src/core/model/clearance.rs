//! Is there clearance between opposite flanks on one line?
//!
//! A contact of side +1 closes where δ rises to its gap b, a contact of side −1 where −δ rises to its gap.
//! Both are closed at once if the sum of the gaps is negative: teeth that are too thick by more than the backlash jam.
//! Kernels assume that at most one of two facing contacts on a line touches.

use super::SAME_PHASE;
use super::contact::Contact;
use super::direction::Direction;
use super::error::ModelError;
use super::mesh::MeshCycle;
use super::release::Release;
use crate::numerics::integers::least_multiple;

/// Number of intervals between the samples of a segment, whose error has eight terms.
const PLACES: usize = 32;

/// Checks that the sum of the gaps of two facing contacts on one line is never negative.
///
/// # Errors
/// [`ModelError::Jammed`].
pub(super) fn has_room(contacts: &[Contact], directions: &[Direction]) -> Result<(), ModelError> {
    let least = |contact: &Contact| {
        let segments = contact.cycles.iter().flat_map(|cycle| &cycle.segments);
        let bounds = segments.map(|segment| -> f64 {
            let [mean, others @ ..] = segment.error.coefficients();
            mean - others.iter().map(|a| a.abs()).sum::<f64>()
        });
        contact.half_gap + bounds.fold(f64::INFINITY, f64::min)
    };
    let bounds: Vec<f64> = contacts.iter().map(least).collect();
    let is_solid =
        |contact: &Contact| contact.release != Release::Film && !contact.release.of_friction();
    let solid = || (contacts.iter().enumerate()).filter(|(_, contact)| is_solid(contact));
    for (i, one) in solid() {
        let facing = solid().filter(|(j, c)| *j > i && c.side != one.side);
        for (_, other) in facing.filter(|(j, _)| bounds[i] + bounds[*j] < 0.0) {
            let count = least_multiple(one.cycles.len(), other.cycles.len());
            for cycle in 0..count {
                let [a, b] = [one, other].map(|c| &c.cycles[cycle % c.cycles.len()]);
                let room = one.half_gap + other.half_gap + smallest_sum(a, b, directions);
                if room < 0.0 {
                    return Err(ModelError::Jammed { lack: -room });
                }
            }
        }
    }
    Ok(())
}

/// The smallest sum of the errors of two contacts \[m\] while they are on one line.
fn smallest_sum(a: &MeshCycle, b: &MeshCycle, directions: &[Direction]) -> f64 {
    let line = |direction: usize| directions[direction].line;
    let mut least = f64::INFINITY;
    for segment in &a.segments {
        for k in 0..=PLACES {
            let part = k as f64 / PLACES as f64;
            let phase = segment.start + part * (segment.end - segment.start);
            // A common breakpoint belongs to two segments of `b`: use the one on the side of this segment.
            let edge = SAME_PHASE.min(0.5 * (segment.end - segment.start));
            let inside = phase.clamp(segment.start + edge, segment.end - edge);
            let other = b.segment_at(inside * b.period);
            if line(segment.direction) == line(other.direction) {
                least = least.min(segment.error_at(phase)[0] + other.error_at(phase)[0]);
            }
        }
    }
    least
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{Division, FlankError, Model, STIFFNESS_TERMS, fixtures};

    /// Flanks that are too thick by less than the half gap, by more than it on a part of a division, and by
    /// more than it on a whole division.
    #[test]
    fn flanks_thicker_than_the_backlash_are_refused() {
        let structure = fixtures::structure(&[0.0, 900.0], 0.01, &[0.9, 0.4], &[0.9, 0.4]);
        let made = |mean: f64, slope: f64| {
            let mut drive = fixtures::two_level_mesh(1e-5);
            let mut series = [0.0; STIFFNESS_TERMS];
            (series[0], series[1]) = (mean, slope);
            drive.mesh[1].error = FlankError::series(series);
            Model::new(&structure, &drive, fixtures::strong_rattle()).map(|_| ())
        };
        assert_eq!(made(-9e-6, 0.5e-6), Ok(()));
        let lack = |made: Result<(), ModelError>| match made {
            Err(ModelError::Jammed { lack }) => lack,
            other => panic!("{other:?}"),
        };
        assert!((lack(made(-9e-6, 2e-6)) - 2e-6).abs() < 1e-12);
        assert!((lack(made(-12e-6, 0.0)) - 4e-6).abs() < 1e-12);
    }

    /// One flank lacks 15 µm where the other is 15 µm too thick, and the opposite from phase 0.11 on. Rounding may
    /// put a sample at this phase on either side of the breakpoint.
    #[test]
    fn errors_of_two_segments_are_not_mixed() {
        let structure = fixtures::structure(&[0.0, 900.0], 0.01, &[0.9, 0.4], &[0.9, 0.4]);
        let drive = fixtures::constant_mesh(1e-5, 4e8);
        let model = Model::new(&structure, &drive, fixtures::strong_rattle()).unwrap();
        let cycle = |means: [f64; 2]| {
            let mut divisions = Division::levels(&[4e8; 2], &[0.11]);
            for (division, mean) in divisions.iter_mut().zip(means) {
                let mut series = [0.0; STIFFNESS_TERMS];
                series[0] = mean;
                division.error = FlankError::series(series);
            }
            MeshCycle::new(1.0 / 170.0, &divisions, &[0, 0], 0.0)
        };
        let [a, b] = [[-15e-6, 15e-6], [15e-6, -15e-6]].map(cycle);
        assert_eq!(smallest_sum(&a, &b, &model.directions), 0.0);
        assert_eq!(smallest_sum(&b, &a, &model.directions), 0.0);
        assert_eq!(smallest_sum(&a, &a, &model.directions), -30e-6);
    }

    /// One contact has two cycles, the facing one three: they meet in six combinations.
    #[test]
    fn all_combinations_of_cycles_are_checked() {
        let structure = fixtures::structure(&[0.0, 900.0], 0.01, &[0.9, 0.4], &[0.9, 0.4]);
        let drive = fixtures::constant_mesh(1e-5, 4e8);
        let model = Model::new(&structure, &drive, fixtures::strong_rattle()).unwrap();
        let mut contacts = model.contacts.clone();
        let [sound, mut thick] = [0, 0].map(|_| contacts[0].cycles[0].clone());
        let mut series = [0.0; STIFFNESS_TERMS];
        series[0] = -12e-6;
        thick.segments[0].error = FlankError::series(series);
        contacts[0].cycles = vec![sound.clone(), thick.clone()];
        contacts[1].cycles = vec![thick, sound.clone(), sound];
        let found = has_room(&contacts, &model.directions);
        assert!(matches!(found, Err(ModelError::Jammed { .. })), "{found:?}");
    }
}
