//! On which parts of the cycle do windows with several closed contacts lie, and how long are they?

use super::grid::{FEWEST, ROUNDING};
use super::length::{fewest_windows, longest_joint};
use super::table_requests::{LineView, TableRequests, place};
use super::window_stiffness::WindowStiffness;
use crate::model::{Contact, Model, Segment};

/// Relative excess of a window's length over its segment that counts as round-off: the ends of both are
/// rounded differently.
const ROUNDED_APART: f64 = 1e-9;

/// Ratio of the longest allowed window to existing lengths above which a new length is worth its tables.
const WORTH_ITS_TABLES: f64 = 8.0;

/// A part of a mesh cycle on which no contact changes its segment.
#[derive(Debug)]
pub struct JointStretch {
    /// Its end \[s\].
    pub end: f64,
    /// Segment of every contact.
    pub segments: Vec<usize>,
    /// Window table of every contact.
    pub windows: Vec<usize>,
    /// Solution operator of every contact, among those of its window table; `None` if its stiffness varies.
    pub feedback: Vec<Option<usize>>,
    /// The lines of all contacts.
    pub views: Vec<LineView>,
}

/// Whether any two contacts of a model can be closed together. Those on opposite sides of one line cannot, nor can
/// layers of one film.
pub fn can_join(model: &Model) -> bool {
    let lines = |contact: &Contact| {
        let mut lines: Vec<usize> = Vec::new();
        for segment in contact.cycles.iter().flat_map(|cycle| &cycle.segments) {
            place(&mut lines, model.line(segment));
        }
        lines
    };
    let contacts = &model.contacts;
    (contacts.iter().enumerate()).any(|(i, contact)| {
        contacts[..i].iter().enumerate().any(|(j, other)| {
            let [own, others] = [contact, other].map(lines);
            let one_line = contact.cycles == other.cycles || (own.len() == 1 && own == others);
            (contact.side == other.side || !one_line) && !model.are_in_same_film(i, j)
        })
    })
}

/// The longest windows \[s\] that may start in the given segments, one per contact. A window is always solved
/// whole and may extend beyond a segment. If stiffness or gap error vary on the segment, the excess is less
/// than the segment's length.
fn longest(model: &Model, segments: &[&Segment], tolerance: f64) -> f64 {
    let constant = |segment: &Segment| {
        let [_, bends @ ..] = segment.error.coefficients();
        segment.stiffness.is_constant() && bends.iter().all(|a| *a == 0.0)
    };
    let bent = segments.iter().filter(|segment| !constant(segment));
    let shortest = bent.fold(f64::INFINITY, |least, s| least.min(s.end - s.start));
    let of_any = 1.0 / fewest_windows(model, tolerance).max(FEWEST);
    (model.period() * shortest.min(of_any)).min(longest_joint(model, segments, tolerance))
}

/// The longest window \[s\] that counts as having the given length.
fn with_rounding(model: &Model, length: f64) -> f64 {
    length * (1.0 + ROUNDED_APART) + ROUNDING * model.period()
}

/// Index of the window length for the given segments, one per contact: the longest allowed one. Every segment's grid
/// has a length, but several closed contacts may need a shorter one.
fn joint_length(model: &Model, segments: &[&Segment], lengths: &[f64], tolerance: f64) -> usize {
    let limit = with_rounding(model, longest(model, segments, tolerance));
    let by_length = |a: &usize, b: &usize| lengths[*a].total_cmp(&lengths[*b]);
    let fitting = (0..lengths.len()).filter(|&index| lengths[index] <= limit);
    (fitting.max_by(by_length))
        .or_else(|| (0..lengths.len()).min_by(by_length))
        .unwrap_or(0)
}

/// Parts of a mesh cycle on which no contact changes its segment: start and end as mesh phases, and the segment of
/// every contact.
fn parts(model: &Model, cycle: u64) -> impl Iterator<Item = ([f64; 2], Vec<usize>)> {
    let mut start = 0.0;
    (model.segment_ends(cycle).into_iter()).map(move |end| {
        let inside = 0.5 * (start + end);
        let segments = (model.contacts.iter())
            .map(|contact| {
                let segments = &contact.cycle(cycle).segments;
                segments.partition_point(|segment| segment.end <= inside)
            })
            .collect();
        ([std::mem::replace(&mut start, end), end], segments)
    })
}

/// The segments of all contacts with these numbers.
fn segments_of<'m>(model: &'m Model, cycle: u64, numbers: &[usize]) -> Vec<&'m Segment> {
    (model.contacts.iter().zip(numbers))
        .map(|(contact, &number)| &contact.cycle(cycle).segments[number])
        .collect()
}

/// The window lengths \[s\] that are missing in `lengths`: where contacts closed together need shorter windows, and
/// where the only suitable lengths belong to a much shorter segment.
pub fn missing_lengths(model: &Model, cycles: u64, lengths: &[f64], tolerance: f64) -> Vec<f64> {
    let all = (0..cycles).flat_map(|cycle| {
        parts(model, cycle).map(move |(_, numbers)| {
            longest(model, &segments_of(model, cycle, &numbers), tolerance)
        })
    });
    let mut limits: Vec<f64> = all.collect();
    limits.sort_by(f64::total_cmp);
    let mut missing = Vec::new();
    for limit in limits {
        let most = with_rounding(model, limit);
        let fits = |length: &f64| (limit / WORTH_ITS_TABLES..=most).contains(length);
        if !lengths.iter().chain(&missing).any(fits) {
            missing.push(limit);
        }
    }
    missing
}

/// The joint stretches of a mesh cycle, with windows of the given lengths \[s\].
pub fn joint_stretches(
    model: &Model,
    cycle: u64,
    lengths: &[f64],
    tolerance: f64,
    requests: &mut TableRequests,
) -> Vec<JointStretch> {
    parts(model, cycle)
        .map(|([start, end], segments)| {
            let inside = 0.5 * (start + end);
            let contact_segments = segments_of(model, cycle, &segments);
            let directions: Vec<usize> = contact_segments
                .iter()
                .map(|segment| segment.direction)
                .collect();
            let length = joint_length(model, &contact_segments, lengths, tolerance);
            let views = requests.views(model, length, &directions, 0);
            let windows: Vec<usize> = (directions.iter())
                .map(|&direction| requests.window(length, direction))
                .collect();
            for &window in &windows {
                for view in &views {
                    requests.request_response(window, view.line);
                }
            }
            let feedback = (contact_segments.iter().zip(&windows))
                .map(|(segment, &window)| {
                    let time = model.period() * inside;
                    requests.close(
                        window,
                        WindowStiffness::new(model, segment, time, lengths[length]),
                    )
                })
                .collect();
            JointStretch {
                end: model.period() * end,
                segments,
                windows,
                feedback,
                views,
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{CoastFlank, Division, Drive, Stiffness, TrajectoryState, fixtures};
    use crate::propagate::{Counters, Kernel, Volterra};
    use crate::structure::StructureContact;

    /// A stretch ends where any contact changes its segment, and contains the segments that hold there.
    #[test]
    fn a_stretch_has_the_segments_about_its_middle() {
        let structure = fixtures::structure(&[0.0], 0.0, &[1.3], &[1.3]);
        let point = fixtures::strong_rattle();
        let model = Model::new(&structure, &fixtures::two_level_mesh(1e-5), point).unwrap();
        let lengths = [0.05 * model.period()];
        let found = joint_stretches(
            &model,
            0,
            &lengths,
            f64::EPSILON,
            &mut TableRequests::default(),
        );
        let ends: Vec<f64> = found.iter().map(|own| own.end / model.period()).collect();
        assert_eq!(ends, [0.6, 1.0]);
        assert_eq!(found[0].segments, [0, 0]);
        assert_eq!(found[1].segments, [1, 1]);
    }

    /// Only a short segment uses its window length: the cycle takes at most twice as many windows as without
    /// it.
    #[test]
    fn a_short_segment_has_windows_of_its_own() {
        let structure = fixtures::structure(&[0.0, 3000.0], 0.01, &[1.0, 0.3], &[1.0, 0.3]);
        let series = [4e8, 4e7, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        let bent = |end: f64| Division {
            stiffness: Stiffness::series(series),
            ..Division::level(end, 4e8)
        };
        let mut drive = fixtures::constant_mesh(1e-5, 4e8);
        drive.mesh = vec![bent(0.6), bent(1.0)];
        let windows = |symmetry: f64| {
            let mesh = Division::mirrored(&drive.mesh, symmetry);
            let coast = CoastFlank {
                mesh,
                further: Vec::new(),
                transmission_error: Vec::new(),
            };
            let drive = Drive {
                coast: Some(coast),
                ..drive.clone()
            };
            let model = Model::new(&structure, &drive, fixtures::strong_rattle()).unwrap();
            Volterra::new(&model, f64::EPSILON, 100)
                .tables
                .most_windows()
        };
        let apart = [4e-12, 1e-8, 1e-6].map(|apart| windows(0.3 + apart));
        for own in apart {
            assert!(own <= 2 * windows(0.3), "{apart:?}");
        }
    }

    /// Parallel stops have the rate of one stop with their total stiffness: the result agrees with shorter windows.
    #[test]
    fn windows_are_as_short_as_all_closed_contacts_ask_for() {
        let count = 12;
        let mut structure = fixtures::structure(&[1000.0], 0.02, &[1.0], &[1.0]);
        let stop = |i: usize| {
            let gap = 1e-5 + 1e-8 * i as f64;
            StructureContact::stop(&[1.0], gap, 1.4e9 / count as f64)
        };
        structure.contacts = (0..count).map(stop).collect();
        // The flanks never touch.
        let drive = fixtures::constant_mesh(5e-3, 1e4);
        let model = Model::new(&structure, &drive, fixtures::strong_rattle()).unwrap();
        let end = |tolerance: f64| {
            let kernel = Volterra::new(&model, tolerance, 1000);
            let mut trajectory = TrajectoryState::new(&model, vec![1.05e-5, 0.0], 0);
            let mut counters = Counters::default();
            (kernel.advance(
                1,
                &mut trajectory,
                &mut kernel.workspace(),
                &mut (),
                &mut counters,
            ))
            .unwrap();
            trajectory.state
        };
        let (own, exact) = (end(f64::EPSILON), end(1e-24));
        let off = (own[0] - exact[0]).abs() / 1e-5;
        assert!(off < 1e-12, "{off:e}");
    }
}
