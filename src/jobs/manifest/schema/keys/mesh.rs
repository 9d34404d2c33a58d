//! `[mesh]`.

use crate::manifest::schema::key::{
    ANY, BELOW_ONE, Key, Kind, NON_NEGATIVE, POSITIVE, bounds, choice, integer, key, quantity,
    table,
};
use crate::units::Dimension::{Angle, Length, Ratio, Stiffness, Viscosity};

/// One of three keys gives the backlash, or the drawing does.
const BACKLASH: &str = "from the other keys of backlash, or from the drawing where it has thinning or a centre distance";

/// The keys of the two-level law.
const TWO_LEVELS: &str = "none; required by the two-level law";

#[rustfmt::skip]
pub(super) const KEYS: &[Key] = &[
    table("mesh")
        .about("The gear mesh: backlash, stiffness over the mesh cycle, contact damping, friction."),
    quantity("mesh.half_gap", Length, POSITIVE, r#""15 um""#).otherwise(BACKLASH)
        .about("Half of the backlash along the line of action. Contact is lost while the mesh deflection is \
                within this distance of the middle of the gap. Must agree with the drawing where that states \
                the backlash."),
    quantity("mesh.normal_backlash", Length, POSITIVE, r#""30 um""#).otherwise(BACKLASH)
        .about("Backlash normal to the flanks. Along the transverse line of action it is 1/cos beta_b as much, twice \
                the half gap. Instead of `half_gap`."),
    quantity("mesh.circumferential_backlash", Length, POSITIVE, r#""32 um""#).otherwise(BACKLASH)
        .about("Backlash along the operating pitch circle, which needs [gear]. Instead of `half_gap`."),
    choice("mesh.stiffness", &["table", "piecewise", "continuous", "fourier", "constant"], r#""piecewise""#)
        .about("Where the stiffness over the mesh cycle comes from. `constant`: `mean_stiffness`. `piecewise`: \
                equal segments, from `values` or the two-level law (two pairs of teeth in contact, then one). \
                `continuous`: the two-level law with its step where it is, or without the keys of that law the \
                course computed from [gear]. `table`: computed from [gear], with means over equal segments. \
                `fourier`: `mean_stiffness` and `stiffness_harmonics`."),
    quantity("mesh.mean_stiffness", Stiffness, POSITIVE, r#""4e8 N/m""#)
        .otherwise("none; required with \"constant\", \"fourier\" and by the two-level law")
        .about("Mean of the mesh stiffness over the mesh cycle."),
    quantity("mesh.contact_ratio", Ratio, bounds(1.0, true, 2.0, false), "1.6").otherwise(TWO_LEVELS)
        .about("Mean number of pairs of teeth in contact. Two pairs are in contact over the first \
                `contact_ratio - 1` of the mesh cycle."),
    quantity("mesh.single_pair_drop", Ratio, BELOW_ONE, "0.25").otherwise(TWO_LEVELS)
        .about("By which part the stiffness of one pair is less than that of two."),
    integer("mesh.segments", 1.0, 10_000.0, "120").or("60")
        .about("Equal segments of the mesh cycle, of \"piecewise\" with two levels and of \"table\". A segment \
                that straddles a step has the mean over its width. With resolution = \"secant\" the stiffness is as it is: \
                segments that need no means of their own for load centroid and friction are joined."),
    key("mesh.values", Kind::List("stiffnesses, one a segment of the mesh cycle"), ANY, r#"["4.4e8 N/m", "3.3e8 N/m"]"#)
        .otherwise("none: the two-level law holds")
        .about("Stiffness of each equal segment of the mesh cycle, with \"piecewise\". Replaces the two-level law."),
    quantity("mesh.values.*", Stiffness, POSITIVE, r#""4.4e8 N/m""#),
    key("mesh.stiffness_harmonics", Kind::List("tables"), ANY, r#"[{ harmonic = 1, amplitude = "4e7 N/m", phase = "180 deg" }]"#).or("[]")
        .about("Harmonics of the stiffness over the mesh cycle, with \"fourier\": \
                k = mean_stiffness + sum of amplitude cos(2 pi harmonic t/T + phase)."),
    table("mesh.stiffness_harmonics.*"),
    integer("mesh.stiffness_harmonics.*.harmonic", 1.0, 100.0, "2")
        .about("Multiple of the mesh frequency."),
    quantity("mesh.stiffness_harmonics.*.amplitude", Stiffness, NON_NEGATIVE, r#""4e7 N/m""#)
        .about("Amplitude of the harmonic."),
    quantity("mesh.stiffness_harmonics.*.phase", Angle, ANY, r#""180 deg""#).or("0")
        .about("Phase of the cosine at mesh phase 0."),
    quantity("mesh.friction", Ratio, BELOW_ONE, "0.05").or("0")
        .about("Coulomb friction coefficient on the flanks. The force turns round where teeth pass the pitch point, by \
                the drawing of the gears: pairs in contact share the load evenly, or as a mesh computed from [gear] \
                has it. Of a modal file it needs [gear], and bevel gears have none."),
    choice("mesh.friction_law", &["constant", "schlenk"], r#""schlenk""#).or(r#""constant""#)
        .about("Where the coefficient of friction comes from. `constant`: `friction`. `schlenk`: the mean coefficient \
                of ISO/TR 14179-2, 0.048 (w/(v rho))^0.2 eta^-0.05 Ra^0.25 X_L, at the mean load and the speed of each \
                point and constant over the mesh cycle; it needs the drawing of a pair on parallel axes. Line loads below 150 N/mm \
                count as that, speeds above 50 m/s as that. The column friction_coefficient has what it gives."),
    quantity("mesh.roughness", Length, bounds(1e-8, false, 2e-5, false), r#""0.5 um""#)
        .otherwise("none; required with friction_law = \"schlenk\"")
        .about("Arithmetic roughness Ra, the mean of both flanks. Only with friction_law = \"schlenk\"."),
    quantity("mesh.oil_viscosity", Viscosity, bounds(1e-4, false, 10.0, false), r#""20 mPa*s""#)
        .otherwise("none; required with friction_law = \"schlenk\"")
        .about("Dynamic viscosity of the oil at its temperature. Only with friction_law = \"schlenk\"."),
    quantity("mesh.oil_factor", Ratio, bounds(0.1, false, 3.0, false), "0.8").or("1")
        .about("Factor of the kind of oil, X_L: 1 mineral oil, 0.8 polyalphaolefin or ester, about 0.6 polyglycol, \
                1.3 phosphoric ester, 1.5 traction fluid. Only with friction_law = \"schlenk\"."),
    quantity("mesh.misalignment", Angle, bounds(-0.02, false, 0.02, false), r#""0.5 mrad""#).or("0")
        .about("Angle between the flanks in the plane of action before a load acts. Only where the mesh is \
                computed from [gear]: the load moves to one end of the face and the mesh softens."),
    key("mesh.shaft_tilt", Kind::Boolean, ANY, "true").or("false")
        .about("Whether the tilt of the shafts under the mean load adds to the misalignment. Only where the mesh \
                is computed from [gear]."),
    choice("mesh.contact", &["load_dependent", "linear"], r#""linear""#).or(r#""load_dependent""#)
        .about("How the flanks of a mesh computed from [gear] flatten. `load_dependent`: by Weber & Banaschek, which stiffens \
                with the load: with the secant at the mean load on one pair (the rated one where there is none). `linear`: \
                in proportion to the force whatever the load, 4 (1 - nu^2)/(pi E) for equal gears, which makes meshes of \
                solid gears 20 to 60 % too stiff."),
    choice("mesh.face", &["coupled", "independent"], r#""independent""#).or(r#""coupled""#)
        .about("How the places of the face of a mesh computed from [gear] bear together where the flanks are misaligned \
                or their leads modified. `coupled`: teeth and gear bodies carry along the face, by elasticity in \
                three dimensions, so that what is not loaded supports what is. `independent`: each slice of the \
                face for itself, as thin-slice models have it, which load too much of a misaligned face. Spur \
                gears alone are coupled, and those with resolution = \"pairs\" are not."),
    choice("mesh.resolution", &["secant", "mean_load", "pairs"], r#""pairs""#).or(r#""secant""#)
        .about("What a mesh computed from [gear] is away from the mean load. `secant`: one spring that touches where the \
                flanks do and is right under the mean load, with the stiffness of the secant between the two. Where contact \
                spreads along the face (misaligned, helical, modified leads) it has the mean of the tangent stiffness. Its force \
                does not jump where a pair of teeth takes hold. All gears have it. \
                `mean_load`: the tangent at the mean load. Its stiffness steps where a pair takes hold, and so does \
                its force unless it is the mean load. run.kernel = \"closed_modes\" knows this one alone. `pairs`: every pair of \
                teeth is a spring across a gap of its own, relief included, so that stiffness, load centroid and \
                friction follow the force of every instant, from the first touch on, without jumps. Takes loads of 0 \
                too, and needs spur gears and run.kernel = \"volterra\" or \"stepping\"."),
    integer("mesh.slices", 1.0, 4.0, "4").or("1")
        .about("Slices of the face, each of which has springs of its own, with resolution = \"pairs\". More than one \
                where the flanks are misaligned or the shafts tilt, which the slices follow at every instant. Of both \
                flanks and all pairs there is room for 16 springs: of 4 slices where two pairs are in contact at most, \
                tip edges included, and of 2 where three are."),
    key("mesh.contact_damping", Kind::ContactDamping, BELOW_ONE, "0.05")
        .about("Viscous damping in contact. A bare number or a percentage is the damping ratio `c / (2 sqrt(k m))` \
                with the mean stiffness and the mass that the mesh feels of the rigid rotations; a text such as \
                \"1483 N*s/m\" is the coefficient c itself."),
    choice("mesh.release", &["deflection", "force"], r#""force""#).or(r#""deflection""#)
        .about("Where a closed contact lets go, further contacts of a modal file included. `deflection`: where the \
                deflection is back at the gap; just before that the damper pulls. `force`: where the force of \
                spring and damper falls to zero, so that it never pulls; a contact that has not come free since \
                takes hold again where that force rises to zero. run.kernel = \"closed_modes\" needs `deflection`."),
    choice("mesh.coast_flank", &["mirrored", "same_line"], r#""same_line""#)
        .otherwise(r#""mirrored", or "same_line" where a modal file has no participations of the coast flanks"#)
        .about("Where the coast flanks touch. `mirrored`: along their own line of action, the mirror image of that of \
                the drive flanks about the line of centres, with stiffness, load centroid, friction and what is \
                missing from the flanks mirrored in phase. `same_line`: along the line of the drive flanks, \
                pushed from behind, all as theirs at the same phase."),
    quantity("mesh.coast_symmetry", Ratio, bounds(0.0, false, 1.0, true), "0.05")
        .otherwise("from [gear]; without it from the two-level law, (contact_ratio + 1/2)/2; required where neither is there")
        .about("Mesh phase, in cycles, at which a tooth of the pinion stands on the line of centres: so long after it \
                the coast flanks have what the drive flanks had as long before it. Half a cycle more or less is the \
                same. Only with mirrored coast flanks and a stiffness that varies or friction."),
];
