//! The keys of a modal file.

use crate::manifest::schema::key::{
    ANY, BELOW_ONE, Key, Kind, NON_NEGATIVE, POSITIVE, bounds, integer, key, quantity, table,
};
use crate::units::Dimension::{
    Angle, AngularSpeed, Damping, Force, ForceByModalDisplacement, ForceByModalVelocity, Length,
    ModalDamping, ModalForce, ModalForceBySpeed, ModalStiffness, Participation,
    ParticipationByLength, Ratio, Stiffness, Velocity,
};

#[rustfmt::skip]
pub(super) const KEYS: &[Key] = &[
    integer("teeth", 1.0, 1000.0, "20").otherwise("1 without `mesh`; otherwise required")
        .about("Teeth of the pinion: mesh cycles per revolution."),
    integer("teeth_wheel", 1.0, 10_000.0, "30").otherwise("none; required by ripple on the wheel and by errors of its teeth")
        .about("Teeth of the wheel."),
    quantity("rated_force", Force, POSITIVE, "1330.0").otherwise("1 N without `mesh`; otherwise required")
        .about("Mesh force at load 1."),
    key("frequency", Kind::List("angular frequencies, one per mode"), ANY, "[0.0, 0.0, 4452.8]")
        .about("Natural angular frequencies of the mass-normalised modes, ascending. Rigid rotations have 0; a value \
                below 1e-8 of the highest frequency counts as 0."),
    quantity("frequency.*", AngularSpeed, NON_NEGATIVE, "4452.8"),
    key("damping", Kind::List("ratios, one per mode"), ANY, "[0.0, 0.0, 0.02]")
        .about("Damping ratios of the modes."),
    quantity("damping.*", Ratio, BELOW_ONE, "0.02"),
    key("mesh", Kind::List("numbers in 1/sqrt(kg), one per mode"), ANY, "[0.52, -0.43, 0.31]")
        .otherwise("none: an oscillator without flanks, and the manifest has no [mesh]")
        .about("Mesh deflection along the line of action per unit of each modal displacement."),
    quantity("mesh.*", Participation, ANY, "0.52"),
    key("displacement", Kind::List("numbers in 1/sqrt(kg), one per mode"), ANY, "[1.0, 0.0, 0.0]")
        .otherwise("the participation of the first contact, or the first mode")
        .about("Displacement that results show as the deflection, per unit of each modal displacement. Only without `mesh`."),
    quantity("displacement.*", Participation, ANY, "1.0"),
    key("torque", Kind::List("numbers in 1/sqrt(kg), one per mode"), ANY, "[0.52, -0.43, 0.31]").otherwise("0 without `mesh`; otherwise required")
        .about("Modal force of the mean load, per newton of the mesh force that balances it."),
    quantity("torque.*", Participation, ANY, "0.52"),
    key("mesh_tilt", Kind::List("numbers in 1/(m sqrt(kg)), one per mode"), ANY, "[0.0, 0.0, -0.21]").otherwise("0")
        .about("Derivative of `mesh` with respect to the position of the load across the face."),
    quantity("mesh_tilt.*", ParticipationByLength, ANY, "-0.21"),
    key("friction", Kind::List("numbers in 1/sqrt(kg), one per mode"), ANY, "[0.0, 0.0, 0.1]").otherwise("0")
        .about("Modal force of a unit friction force on the flanks at the pitch point."),
    quantity("friction.*", Participation, ANY, "0.1"),
    key("friction_lever", Kind::List("numbers in 1/(m sqrt(kg)), one per mode"), ANY, "[0.0, 0.0, 0.0]").otherwise("0")
        .about("Derivative of `friction` with respect to the distance from the pitch point along the line of action."),
    quantity("friction_lever.*", ParticipationByLength, ANY, "0.0"),
    key("mesh_coast", Kind::List("numbers in 1/sqrt(kg), one per mode"), ANY, "[0.52, -0.43, 0.12]")
        .otherwise("none: the coast flanks touch along the line of the drive flanks")
        .about("Deflection of the coast flanks along their line of action, with the sign of `mesh`. It grows as the \
                drive flanks approach. The coast flanks touch where it falls to minus the half gap. For rigid \
                rotations it equals `mesh`."),
    quantity("mesh_coast.*", Participation, ANY, "0.12"),
    key("mesh_tilt_coast", Kind::List("numbers in 1/(m sqrt(kg)), one per mode"), ANY, "[0.0, 0.0, 0.17]").otherwise("0")
        .about("Derivative of `mesh_coast` with respect to the position of the load across the face. Only with `mesh_coast`."),
    quantity("mesh_tilt_coast.*", ParticipationByLength, ANY, "0.17"),
    key("friction_coast", Kind::List("numbers in 1/sqrt(kg), one per mode"), ANY, "[0.0, 0.0, -0.1]").otherwise("0")
        .about("Modal force of a unit friction force on the coast flanks at the pitch point. On the pinion it acts \
                along (-cos alpha, -sin alpha), towards the axis of the pinion. On the wheel it acts in the opposite \
                direction. For comparison, `friction` acts along (cos alpha, -sin alpha) on the pinion. Only with \
                `mesh_coast`."),
    quantity("friction_coast.*", Participation, ANY, "-0.1"),
    key("friction_lever_coast", Kind::List("numbers in 1/(m sqrt(kg)), one per mode"), ANY, "[0.0, 0.0, 0.0]").otherwise("0")
        .about("Derivative of `friction_coast` with respect to the distance from the pitch point along the line of \
                action of the coast flanks. Only with `mesh_coast`."),
    quantity("friction_lever_coast.*", ParticipationByLength, ANY, "0.0"),
    key("torque_pinion", Kind::List("numbers in 1/(m sqrt(kg)), one per mode"), ANY, "[13.8, -11.4, 8.2]")
        .otherwise("none; required by ripple on the pinion")
        .about("Modal force of a unit torque on the pinion's shaft."),
    quantity("torque_pinion.*", ParticipationByLength, ANY, "13.8"),
    key("torque_wheel", Kind::List("numbers in 1/(m sqrt(kg)), one per mode"), ANY, "[-9.2, 7.6, -5.5]")
        .otherwise("none; required by ripple on the wheel")
        .about("Modal force of a unit torque on the wheel's shaft."),
    quantity("torque_wheel.*", ParticipationByLength, ANY, "-9.2"),
    key("damping_matrix", Kind::List("rows, one per mode, of numbers in 1/s"), ANY, "[[0.0, 0.0], [0.0, 12.0]]").otherwise("0")
        .about("Matrix of damping and coupling of the modes, in addition to the damping ratios. Its diagonal adds to \
                2 zeta omega. Entries of rigid motions below 1e-12 of the highest frequency count as 0 (round-off)."),
    key("damping_matrix.*", Kind::List("numbers in 1/s, one per mode"), ANY, "[0.0, 12.0]"),
    quantity("damping_matrix.*.*", ModalDamping, ANY, "12.0"),
    key("gyroscopic_matrix", Kind::List("rows, one per mode, of numbers"), ANY, "[[0.0, 0.3], [-0.3, 0.0]]").otherwise("0")
        .about("Gyroscopic coupling of the modes: a damping in 1/s per rad/s of the pinion's speed. The matrix must \
                be skew-symmetric."),
    key("gyroscopic_matrix.*", Kind::List("numbers, one per mode"), ANY, "[0.0, 0.3]"),
    quantity("gyroscopic_matrix.*.*", Ratio, ANY, "0.3"),
    key("stiffness_matrix", Kind::List("rows, one per mode, of numbers in 1/s^2"), ANY, "[[0.0, 4e3], [-4e3, 0.0]]").otherwise("0")
        .about("Matrix of cross-coupled stiffness of the modes. Its diagonal adds to omega^2. It need not be symmetric."),
    key("stiffness_matrix.*", Kind::List("numbers in 1/s^2, one per mode"), ANY, "[0.0, 4e3]"),
    quantity("stiffness_matrix.*.*", ModalStiffness, ANY, "4e3"),
    key("constant_load", Kind::List("numbers in N/sqrt(kg), one per mode"), ANY, "[0.0, 3.1, 1.9]").otherwise("0")
        .about("Modal force that does not depend on the load, such as a constant drag."),
    quantity("constant_load.*", ModalForce, ANY, "3.1"),
    key("load_by_speed", Kind::List("numbers in N s/(rad sqrt(kg)), one per mode"), ANY, "[0.0, 0.02, 0.01]").otherwise("0")
        .about("Modal force per rad/s of the pinion's speed, such as the mean of a viscous drag."),
    quantity("load_by_speed.*", ModalForceBySpeed, ANY, "0.02"),
    key("harmonic_load", Kind::List("tables"), ANY, r#"[{ name = "shaker", force = [0.0, 0.4, 0.2], amplitude = 30, cycles = [3, 5] }]"#).or("[]")
        .about("Loads that vary with time, one table `[[harmonic_load]]` per harmonic: F = force amplitude cos(2 pi \
                turns + phase). Their frequency must be proportional to the speed."),
    table("harmonic_load.*"),
    key("harmonic_load.*.name", Kind::Text, ANY, r#""shaker""#)
        .about("Name of the load."),
    key("harmonic_load.*.force", Kind::List("numbers in N/sqrt(kg), one per mode"), ANY, "[0.0, 0.4, 0.2]")
        .about("Modal force at amplitude 1."),
    quantity("harmonic_load.*.force.*", ModalForce, ANY, "0.4"),
    quantity("harmonic_load.*.amplitude", Ratio, NON_NEGATIVE, "30").or("1")
        .about("Factor on `force`. If `force` is the modal force of 1 N or 1 N*m, this is the amplitude in N or N*m."),
    key("harmonic_load.*.cycles", Kind::List("2 whole numbers"), ANY, "[3, 5]").of_length(2)
        .otherwise("none: `order` gives the frequency")
        .about("`[p, q]` for p turns of the load in q mesh cycles."),
    integer("harmonic_load.*.cycles.*", 1.0, 1000.0, "3"),
    quantity("harmonic_load.*.order", Ratio, POSITIVE, "1.5").otherwise("none; required without `cycles`")
        .about("Turns of the load per revolution of the pinion. It need not be a whole number."),
    quantity("harmonic_load.*.phase", Angle, ANY, r#""90 deg""#).or("0")
        .about("Phase of the cosine at time 0."),
    key("contact", Kind::List("tables"), ANY, r#"[{ name = "stop", participation = [0.0, 0.4], gap = "50 um", stiffness = "1e8 N/m" }]"#).or("[]")
        .about("Contacts in addition to the two flanks of the mesh, one table `[[contact]]` each: flanks of further \
                meshes, stops, splines, spring stages. A contact closes when d = sum of participation q - error \
                reaches its gap. Its force is F = stiffness (d - gap) + damping d'."),
    table("contact.*"),
    key("contact.*.name", Kind::Text, ANY, r#""stop""#)
        .about("Name of the contact."),
    key("contact.*.participation", Kind::List("numbers in 1/sqrt(kg), one per mode"), ANY, "[0.0, 0.4, -0.1]")
        .about("Deflection of the contact per unit of each modal displacement."),
    quantity("contact.*.participation.*", Participation, ANY, "0.4"),
    key("contact.*.force", Kind::List("numbers in 1/sqrt(kg), one per mode"), ANY, "[0.0, 0.41, -0.1]").otherwise("`participation`")
        .about("Modal force per newton of the contact's force, which acts with a minus sign. It differs from \
                `participation` if friction tilts the force."),
    quantity("contact.*.force.*", Participation, ANY, "0.41"),
    quantity("contact.*.gap", Length, ANY, r#""50 um""#)
        .about("Deflection at which the contact closes. It is negative if the contact is preloaded at rest."),
    quantity("contact.*.restitution", Ratio, bounds(0.0, false, 1.0, false), "0.8").otherwise("none: the contact has a stiffness")
        .about("Coefficient of restitution of a rigid stop, instead of stiffness and damping. An impact reverses the speed of \
                approach and multiplies it by this number. Impacts that accumulate bring the contact to rest on the stop \
                until its force vanishes. A rigid stop counts as two contacts: impact, rest. The kernel `volterra` is \
                necessary."),
    quantity("contact.*.stiffness", Stiffness, ANY, r#""1e8 N/m""#).otherwise("none; required without `levels` or `restitution`")
        .about("Stiffness of the closed contact, or its mean if it has harmonics. Not 0. Without harmonics it may be negative: \
                the contact then softens what acts beside it, and needs the kernel `volterra`."),
    key("contact.*.stiffness_harmonics", Kind::List("tables"), ANY, r#"[{ harmonic = 1, amplitude = "2e7 N/m" }]"#).or("[]")
        .about("Harmonics of the stiffness over the cycle of the contact."),
    table("contact.*.stiffness_harmonics.*"),
    integer("contact.*.stiffness_harmonics.*.harmonic", 1.0, 100.0, "1")
        .about("Multiple of the frequency of the contact's cycle."),
    quantity("contact.*.stiffness_harmonics.*.amplitude", Stiffness, NON_NEGATIVE, r#""2e7 N/m""#)
        .about("Amplitude of the harmonic."),
    quantity("contact.*.stiffness_harmonics.*.phase", Angle, ANY, r#""90 deg""#).or("0")
        .about("Phase of the cosine at phase 0 of the contact's cycle."),
    key("contact.*.levels", Kind::List("stiffnesses, one per part of the contact's cycle"), ANY, r#"["1e8 N/m", "7e7 N/m"]"#)
        .otherwise("none: `stiffness` holds")
        .about("Stiffness of each of several equal parts of the contact's cycle, instead of `stiffness`."),
    quantity("contact.*.levels.*", Stiffness, POSITIVE, r#""1e8 N/m""#),
    quantity("contact.*.damping", Damping, NON_NEGATIVE, r#""300 N*s/m""#).or("0")
        .about("Damping of the closed contact."),
    key("contact.*.cycles", Kind::List("2 whole numbers"), ANY, "[3, 5]").of_length(2).or("[1, 1]")
        .about("Speed of the contact's cycle: `[p, q]` for p of its cycles in q mesh cycles. It follows from the \
                numbers of teeth. For a mesh on a shaft with two gears, it is the ratio of their numbers of teeth."),
    integer("contact.*.cycles.*", 1.0, 10000.0, "3"),
    quantity("contact.*.phase", Ratio, ANY, "0.25").or("0")
        .about("Phase of the contact's cycle at time 0, in cycles of the contact."),
    key("contact.*.transmission_error", Kind::List("tables"), ANY, r#"[{ harmonic = 1, amplitude = "2 um" }]"#).or("[]")
        .about("Error of the contact, one table per harmonic of its cycle."),
    table("contact.*.transmission_error.*"),
    integer("contact.*.transmission_error.*.harmonic", 1.0, 1000.0, "1")
        .about("Multiple of the frequency of the contact's cycle."),
    quantity("contact.*.transmission_error.*.amplitude", Length, NON_NEGATIVE, r#""2 um""#)
        .about("Amplitude."),
    quantity("contact.*.transmission_error.*.phase", Angle, ANY, r#""90 deg""#).or("0")
        .about("Phase of the cosine at phase 0 of the contact's cycle."),
    key("slider", Kind::List("tables"), ANY, r#"[{ name = "clutch", participation = [0.0, 0.4], stiffness = "1e6 N/m", limit = "20 N" }]"#).or("[]")
        .about("Dry hysteresis, one table `[[slider]]` per element: a spring in series with a dry slider along d = sum of \
                participation q. The element starts without force. Several elements with one participation make an \
                Iwan set. Each counts as three contacts: slip forwards, slip backwards, stick. The kernel `volterra` is \
                necessary."),
    table("slider.*"),
    key("slider.*.name", Kind::Text, ANY, r#""clutch""#)
        .about("Name of the element."),
    key("slider.*.participation", Kind::List("numbers in 1/sqrt(kg), one per mode"), ANY, "[0.0, 0.4, -0.1]")
        .about("Deflection of the element per unit of each modal displacement."),
    quantity("slider.*.participation.*", Participation, ANY, "0.4"),
    quantity("slider.*.stiffness", Stiffness, POSITIVE, r#""1e6 N/m""#)
        .about("Stiffness of the spring while the slider sticks."),
    quantity("slider.*.limit", Force, POSITIVE, r#""20 N""#)
        .about("Friction force at which the slider slips."),
    key("dry_friction", Kind::List("tables"), ANY, r#"[{ name = "belt", participation = [0.0, 0.4], force = "20 N" }]"#).or("[]")
        .about("Dry friction that sticks, one table `[[dry_friction]]` per element, against a surface along d = sum of \
                participation q. It opposes the sliding with a constant force. Where the sliding stops, it holds the structure \
                exactly, until more than the static force would be necessary. Each counts as three contacts: slip \
                forwards, slip backwards, stick. The kernel `volterra` is necessary. It excludes rigid stops."),
    table("dry_friction.*"),
    key("dry_friction.*.name", Kind::Text, ANY, r#""belt""#)
        .about("Name of the element."),
    key("dry_friction.*.participation", Kind::List("numbers in 1/sqrt(kg), one per mode"), ANY, "[0.0, 0.4, -0.1]")
        .about("Deflection of the element per unit of each modal displacement."),
    quantity("dry_friction.*.participation.*", Participation, ANY, "0.4"),
    quantity("dry_friction.*.force", Force, POSITIVE, r#""20 N""#)
        .about("Force of sliding friction."),
    quantity("dry_friction.*.static_force", Force, POSITIVE, r#""25 N""#).otherwise("`force`")
        .about("Largest force of static friction. It is at least `force`."),
    quantity("dry_friction.*.belt_speed", Velocity, ANY, r#""0.2 m/s""#).or("0")
        .about("Speed of the surface along the line. The element sticks where the deflection grows at this speed."),
    key("bearing", Kind::List("tables"), ANY, r#"[{ name = "pinion 1 x", gain = [0.0, 2.1e7, -4.4e6] }]"#).or("[]")
        .about("Bearing forces to compute, one table `[[bearing]]` each."),
    table("bearing.*"),
    key("bearing.*.name", Kind::Text, ANY, r#""pinion 1 x""#)
        .about("Name of the bearing and direction of its force. Results use this name."),
    key("bearing.*.gain", Kind::List("numbers in N/(m sqrt(kg)), one per mode"), ANY, "[0.0, 2.1e7, -4.4e6]")
        .about("Force on the bearing per unit of each modal displacement."),
    quantity("bearing.*.gain.*", ForceByModalDisplacement, ANY, "2.1e7"),
    key("bearing.*.rate_gain", Kind::List("numbers in N s/(m sqrt(kg)), one per mode"), ANY, "[0.0, 110.0, -23.0]").otherwise("0: no dampers")
        .about("Force of the bearing's dampers per unit of each modal velocity."),
    quantity("bearing.*.rate_gain.*", ForceByModalVelocity, ANY, "110.0"),
];
