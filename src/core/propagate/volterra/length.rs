//! How long is a window?

use super::shapes::TERMS;
use crate::model::{Block, Direction, Model, Release, Segment};
use crate::numerics::exponential::LARGEST_HALF_ARGUMENT;

/// Number of windows per mesh cycle, not rounded, that just satisfies the tolerance.
pub fn fewest_windows(model: &Model, tolerance: f64) -> f64 {
    0.5 * fastest_rate(model) * model.period() / largest_half_argument(tolerance)
}

/// Whether a closed contact makes the structure faster. Those of rigid stops and of dry friction do not: they
/// are constraints or constant forces.
fn stiffens(release: Release) -> bool {
    !(release.of_stop() || release.of_friction())
}

/// The longest window \[s\] for the tolerance if all contacts that can be closed together are closed, each on one of
/// these segments.
pub fn longest_joint(model: &Model, segments: &[&Segment], tolerance: f64) -> f64 {
    2.0 * largest_half_argument(tolerance) / joint_rate(model, segments)
}

/// Upper bound of the rates \[1/s\] of the structure with several contacts closed, except contacts on opposite sides
/// of one line or in one film. Springs along φᵢ add a matrix with the norm of `√(kᵢ kⱼ) φᵢ·φⱼ`, which is at most its
/// largest row sum.
fn joint_rate(model: &Model, segments: &[&Segment]) -> f64 {
    let open = (model.blocks.iter().map(Block::fastest)).fold(0.0, f64::max);
    let count = segments.len();
    let can_join = |i: usize, j: usize| {
        let one_line = model.line(segments[i]) == model.line(segments[j]);
        let opposite = one_line && model.contacts[i].side != model.contacts[j].side;
        !opposite && !model.are_in_same_film(i, j)
    };
    let spring = |i: &usize| stiffens(model.contacts[*i].release);
    let rows = (0..count).filter(spring).map(|i| {
        let [mut square, mut linear] = [0.0; 2];
        for j in (0..count).filter(spring).filter(|&j| can_join(i, j)) {
            let [direction, other] =
                [i, j].map(|contact| &model.directions[segments[contact].direction]);
            let [direct, inertial] =
                if i == j { direction.effect_bounds() } else { direction.effect_of(other) };
            let (own, other) = (segments[i], segments[j]);
            square += (own.stiffness.bound() * other.stiffness.bound()).sqrt() * inertial;
            linear += (own.damping * other.damping).sqrt() * (inertial + direct);
        }
        [square, linear]
    });
    let [square, linear] = rows.fold([0.0; 2], |all: [f64; 2], row| {
        [all[0].max(row[0]), all[1].max(row[1])]
    });
    (open * open + square).sqrt() + linear
}

/// Upper bound of the rates \[1/s\] with any one contact closed, and of the excitation.
pub fn fastest_rate(model: &Model) -> f64 {
    excitation(model).fold(fastest_structure_rate(model), f64::max)
}

/// Angular frequencies of the excitation \[rad/s\].
fn excitation(model: &Model) -> impl Iterator<Item = f64> {
    let errors = model.transmission_errors().map(|h| h.angular_frequency);
    errors.chain(model.ripple.iter().map(|r| r.angular_frequency))
}

/// Fastest rate \[1/s\] of the structure with all contacts open, and of the excitation.
pub fn fastest_of_open(model: &Model) -> f64 {
    let frequencies = model.blocks.iter().map(Block::fastest);
    excitation(model).fold(frequencies.fold(0.0, f64::max), f64::max)
}

/// Upper bound of the rates \[1/s\] of the structure with any one contact closed, without the excitation. A closed
/// spring moves an eigenvalue by at most the norm of the added matrix. Each contact has its units, N/m or N m/rad,
/// and acts along its direction only.
pub fn fastest_structure_rate(model: &Model) -> f64 {
    let frequencies = model.blocks.iter().map(Block::fastest);
    let open = frequencies.fold(0.0, f64::max);
    let effects: Vec<[f64; 2]> = (model.directions.iter())
        .map(Direction::effect_bounds)
        .collect();
    let springs = (model.contacts.iter()).filter(|contact| stiffens(contact.release));
    let cycles = springs.flat_map(|contact| &contact.cycles);
    cycles
        .flat_map(|cycle| &cycle.segments)
        .map(|segment| {
            let [direct, inertial] = effects[segment.direction];
            (open * open + segment.stiffness.bound() * inertial).sqrt()
                + segment.damping * (inertial + direct)
        })
        .fold(open, f64::max)
}

/// Smallest tolerance; smaller ones are raised to it. Its windows are about a hundred times shorter than
/// round-off requires.
const SMALLEST_TOLERANCE: f64 = 1e-64;

/// The half argument κ at which the first omitted coefficient, about `(2P+1) κ^P / (2P+1)!!`, reaches the tolerance.
fn largest_half_argument(tolerance: f64) -> f64 {
    let tolerance = tolerance.max(SMALLEST_TOLERANCE);
    let double_factorial: f64 = (1..=TERMS).map(|n| (2 * n + 1) as f64).product();
    let power = tolerance * double_factorial / (2 * TERMS + 1) as f64;
    power.powf(1.0 / TERMS as f64).min(LARGEST_HALF_ARGUMENT)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::fixtures;
    use crate::structure::StructureContact;

    /// A stop has the same rates in millimetres and in radians.
    #[test]
    fn rates_do_not_depend_on_the_units_of_a_contact() {
        let rate = |unit: f64| {
            let own = [0.9, 0.4];
            let mut structure = fixtures::structure(&[0.0, 900.0], 0.01, &own, &own);
            let participation = [0.5 * unit, -0.7 * unit];
            let stiffness = 3e8 / (unit * unit);
            let mut stop = StructureContact::stop(&participation, 5e-6 * unit, stiffness);
            stop.law.damping /= unit * unit;
            structure.contacts = vec![stop];
            let mesh = fixtures::constant_mesh(1e-5, 4e8);
            let point = fixtures::strong_rattle();
            fastest_structure_rate(&Model::new(&structure, &mesh, point).unwrap())
        };
        // The mesh is the stiffer one: ω² + k w².
        let known = (900.0_f64.powi(2) + 4e8 * (0.9 * 0.9 + 0.4 * 0.4)).sqrt();
        for unit in [1.0, 1e-3, 1e3, 30.0] {
            assert!(
                (rate(unit) / known - 1.0).abs() < 1e-12,
                "{unit}: {}",
                rate(unit)
            );
        }
    }
}
