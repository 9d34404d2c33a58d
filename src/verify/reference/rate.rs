//! What is the fastest rate in a model? It determines the longest step.

use crate::model::Model;

/// Upper bound \[1/s\] of the rates with any one contact closed: natural frequencies including the contact's spring and
/// damper, decay, excitation.
pub(super) fn fastest_rate(model: &Model) -> f64 {
    let mut natural = 0.0f64;
    let mut decay = 0.0f64;
    for block in &model.blocks {
        natural = natural.max(block.fastest());
        decay = decay.max(block.growth().abs());
    }
    let segments = (model.contacts.iter())
        .flat_map(|contact| &contact.cycles)
        .flat_map(|cycle| &cycle.segments);
    let structure = segments
        .map(|segment| {
            let [direct, inertial] = model.directions[segment.direction].effect_bounds();
            let stiffness = segment.stiffness.bound();
            (natural * natural + stiffness * inertial).sqrt()
                + segment.damping * inertial
                + stiffness * direct
        })
        .fold(natural, f64::max);
    let error = model.transmission_errors().map(|h| h.angular_frequency);
    let ripple = model.ripple.iter().map(|r| r.angular_frequency);
    error
        .chain(ripple)
        .fold(structure + 2.0 * decay, f64::max)
        // A free body has no rate. The mesh cycle then determines the step.
        .max(1.0 / model.period())
}
