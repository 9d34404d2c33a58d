//! Does a drawing meet the assumptions of the flanks? Checks lengths, moduli, profiles and leads given by
//! points, and bores.

use super::compliance::LEAST_BODY_RATIO;
use super::{FlankCourse, GearError, GearPair, Tooth, non_negative, positive};
use std::f64::consts::FRAC_PI_2;

/// Part of a flank by which points may lie beyond its ends, to allow for rounded lengths in drawings.
const ON_FLANK: f64 = 1e-3;

/// Smallest thickness of a ring outside its roots \[modules\] that is solved as accurately as thicker ones.
const LEAST_RIM: f64 = 2.0;

/// Checks lengths, angles and moduli that the formulas rely on. A manifest has passed these checks
/// already; a caller of the library may not have.
pub(super) fn check_values(pair: &GearPair) -> Result<(), GearError> {
    if pair.helix_angle.is_nan() || pair.helix_angle.abs() >= FRAC_PI_2 {
        let value = pair.helix_angle;
        return Err(GearError::HelixAngle { value });
    }
    let form = &pair.form;
    let material = form.material;
    let relief = || {
        (form.tip_relief.iter())
            .chain(&form.root_relief)
            .chain(&form.end_relief)
    };
    let lengths = [
        ("module [m]", pair.module),
        ("pressure angle [rad]", pair.pressure_angle),
        ("face width [m]", pair.face_width),
        ("rack addendum [1]", form.rack.addendum),
        ("rack dedendum [1]", form.rack.dedendum),
        ("Young's modulus [Pa]", material[0].young_modulus),
        ("Young's modulus [Pa]", material[1].young_modulus),
    ]
    .into_iter()
    .chain(
        relief()
            .filter(|relief| relief.amount != 0.0)
            .map(|relief| ("length of relief [m]", relief.length)),
    )
    .chain(given(
        "centre distance [m]",
        std::slice::from_ref(&form.centre_distance),
    ))
    .chain(given("tip diameter [m]", &form.tip_diameter))
    .chain(given("bore [m]", &form.bore))
    .chain(given(
        "outer diameter of a ring [m]",
        std::slice::from_ref(&form.ring),
    ));
    for (quantity, value) in lengths {
        positive(quantity, value)?;
    }
    let amounts = [
        ("rack tip radius [1]", form.rack.tip_radius),
        ("thinning [m]", form.thinning[0]),
        ("thinning [m]", form.thinning[1]),
        ("Poisson's ratio [1]", material[0].poisson_ratio),
        ("Poisson's ratio [1]", material[1].poisson_ratio),
    ]
    .into_iter()
    .chain(relief().map(|relief| ("amount of relief [m]", relief.amount)));
    for (quantity, value) in amounts {
        non_negative(quantity, value)?;
    }
    for (quantity, value, limit) in [
        ("pressure angle [rad]", pair.pressure_angle, FRAC_PI_2),
        ("Poisson's ratio [1]", material[0].poisson_ratio, 0.5),
        ("Poisson's ratio [1]", material[1].poisson_ratio, 0.5),
    ] {
        if value >= limit {
            return Err(GearError::TooLarge {
                quantity,
                value,
                limit,
            });
        }
    }
    Ok(())
}

/// Checks that profiles and leads given by points lie on their flanks, with increasing positions.
pub(super) fn check_points(pair: &GearPair, teeth: &[Tooth; 2]) -> Result<(), GearError> {
    for (index, tooth) in teeth.iter().enumerate() {
        let [_, half] = pair.form.overhang[index].to_gear_face(0.0, pair.face_width);
        let [root, tip] =
            [tooth.form_roll, tooth.tip_roll].map(|roll| roll * tooth.base_radius.abs());
        let profile = [root.min(tip), root.max(tip)];
        for (course, points, [from, to]) in [
            (
                FlankCourse::Profile,
                &pair.form.profile_points[index],
                profile,
            ),
            (
                FlankCourse::Lead,
                &pair.form.lead_points[index],
                [-half, half],
            ),
        ] {
            let gear = index + 1;
            let count = points.points.len();
            if count == 1 {
                return Err(GearError::OnePoint { course, gear });
            }
            if let Some(point) = points.first_out_of_order() {
                return Err(GearError::PointOrder {
                    course,
                    gear,
                    point: point + 1,
                });
            }
            let slack = ON_FLANK * (to - from);
            let outside = |place: &f64| !(from - slack..=to + slack).contains(place);
            if let Some(place) = points.kinks().find(outside) {
                return Err(GearError::PointOffFlank {
                    course,
                    gear,
                    place,
                    from,
                    to,
                });
            }
        }
    }
    Ok(())
}

/// The values that the drawing states, with names.
fn given(
    quantity: &'static str,
    values: &[Option<f64>],
) -> impl Iterator<Item = (&'static str, f64)> {
    values.iter().flatten().map(move |value| (quantity, *value))
}

/// Returns the bores \[m\]; for a ring minus the outer diameter. Checks that they are known and that the
/// compliance of the bodies can be computed.
pub(super) fn bores(pair: &GearPair, teeth: &[Tooth; 2]) -> Result<[f64; 2], GearError> {
    let mut bores = [0.0; 2];
    for (index, tooth) in teeth.iter().enumerate() {
        let gear = index + 1;
        if let (1, Some(outer)) = (index, pair.form.ring) {
            let root = tooth.root_radius.abs();
            let ratio = outer / (2.0 * root);
            let least = 1.0 + LEAST_RIM * pair.module / root;
            if ratio < least {
                return Err(GearError::RingBody {
                    outer,
                    ratio,
                    least,
                });
            }
            bores[index] = -outer;
            continue;
        }
        let bore = pair.form.bore[index].ok_or(GearError::NoBore { gear })?;
        let ratio = 2.0 * tooth.root_radius / bore;
        if ratio < LEAST_BODY_RATIO {
            return Err(GearError::BodyRatio {
                gear,
                bore,
                ratio,
                least: LEAST_BODY_RATIO,
            });
        }
        bores[index] = bore;
    }
    Ok(bores)
}
