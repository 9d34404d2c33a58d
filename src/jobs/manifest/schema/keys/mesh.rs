//! The keys of the table `[mesh]`.

use crate::manifest::schema::key::{
    ANY, BELOW_ONE, Key, Kind, NON_NEGATIVE, POSITIVE, bounds, choice, integer, key, quantity,
    table,
};
use crate::units::Dimension::{Angle, Length, Ratio, Stiffness, Viscosity};

/// Default of the three keys for the backlash. One of them is needed, unless the drawing determines the
/// backlash.
const BACKLASH: &str =
    "from the other backlash keys, or from the drawing if it has thinning or a centre distance";

/// Default of the keys of the two-level law.
const TWO_LEVELS: &str = "none; required by the two-level law";

#[rustfmt::skip]
pub(super) const KEYS: &[Key] = &[
    table("mesh").otherwise("the table is required, unless a modal file has no mesh")
        .about("The gear mesh: backlash, stiffness over the mesh cycle, contact damping, friction."),
    quantity("mesh.half_gap", Length, POSITIVE, r#""15 um""#).otherwise(BACKLASH)
        .about("Half of the backlash along the line of action. Contact is lost while the mesh deflection is less than \
                this distance from the middle of the gap. If the drawing determines the backlash too, both must \
                agree. As an axis of the grid, or changed by a fit, it replaces the backlash of the drawing: the \
                thinning of both gears changes alike, for this mesh only."),
    quantity("mesh.normal_backlash", Length, POSITIVE, r#""30 um""#).otherwise(BACKLASH)
        .about("Backlash normal to the flanks, instead of `half_gap`. Divided by cos beta_b it is the backlash along \
                the transverse line of action, which is twice the half gap."),
    quantity("mesh.circumferential_backlash", Length, POSITIVE, r#""32 um""#).otherwise(BACKLASH)
        .about("Backlash along the operating pitch circle, instead of `half_gap`. Needs [gear]."),
    choice("mesh.stiffness", &["table", "piecewise", "continuous", "fourier", "constant"], r#""piecewise""#)
        .about("Source of the stiffness over the mesh cycle. `constant`: `mean_stiffness`. `piecewise`: equal \
                segments, from `values` or the two-level law (two pairs of teeth in contact, then one). `continuous`: \
                the two-level law with an exact step; without the keys of that law, the stiffness computed from \
                [gear]. `table`: computed from [gear], averaged over equal segments. `fourier`: `mean_stiffness` and \
                `stiffness_harmonics`."),
    quantity("mesh.mean_stiffness", Stiffness, POSITIVE, r#""4e8 N/m""#)
        .otherwise("none; required with \"constant\", \"fourier\" and by the two-level law")
        .about("Mean of the mesh stiffness over the mesh cycle."),
    quantity("mesh.contact_ratio", Ratio, bounds(1.0, true, 2.0, false), "1.6").otherwise(TWO_LEVELS)
        .about("Mean number of pairs of teeth in contact. Two pairs are in contact over the first `contact_ratio - 1` \
                of the mesh cycle."),
    quantity("mesh.single_pair_drop", Ratio, BELOW_ONE, "0.25").otherwise(TWO_LEVELS)
        .about("Relative drop of the stiffness from two pairs in contact to one."),
    integer("mesh.segments", 1.0, 10_000.0, "120").on_further_meshes().or("60")
        .about("Number of equal segments of the mesh cycle, for \"piecewise\" with two levels and for \"table\". A \
                segment that contains a step takes the mean over its width. With resolution = \"secant\", the \
                stiffness is not averaged, and neighbouring segments are joined if load centroid and friction allow \
                it."),
    key("mesh.values", Kind::List("stiffnesses, one per segment of the mesh cycle"), ANY, r#"["4.4e8 N/m", "3.3e8 N/m"]"#)
        .otherwise("none: the two-level law holds")
        .about("Stiffness of each equal segment of the mesh cycle, with \"piecewise\". Replaces the two-level law."),
    quantity("mesh.values.*", Stiffness, POSITIVE, r#""4.4e8 N/m""#),
    key("mesh.stiffness_harmonics", Kind::List("tables"), ANY, r#"[{ harmonic = 1, amplitude = "4e7 N/m", phase = "180 deg" }]"#).or("[]")
        .about("Harmonics of the stiffness over the mesh cycle, with \"fourier\": k = mean_stiffness + sum of \
                amplitude cos(2 pi harmonic t/T + phase)."),
    table("mesh.stiffness_harmonics.*"),
    integer("mesh.stiffness_harmonics.*.harmonic", 1.0, 100.0, "2")
        .about("Multiple of the mesh frequency."),
    quantity("mesh.stiffness_harmonics.*.amplitude", Stiffness, NON_NEGATIVE, r#""4e7 N/m""#)
        .about("Amplitude of the harmonic."),
    quantity("mesh.stiffness_harmonics.*.phase", Angle, ANY, r#""180 deg""#).or("0")
        .about("Phase of the cosine at mesh phase 0."),
    quantity("mesh.friction", Ratio, BELOW_ONE, "0.05").or("0")
        .about("Coulomb friction coefficient on the flanks. The friction force reverses when the contact passes the \
                pitch point, which the drawing of the gears gives. Pairs in contact share the load evenly, or as \
                computed from [gear]. With a modal file, friction needs [gear]. Bevel gears have no friction."),
    choice("mesh.friction_law", &["constant", "schlenk"], r#""schlenk""#).or(r#""constant""#)
        .about("Source of the friction coefficient. `constant`: the value of `friction`. `schlenk`: the mean \
                coefficient of ISO/TR 14179-2, 0.048 (w/(v rho))^0.2 eta^-0.05 Ra^0.25 X_L. The mean load and speed of \
                each point set this coefficient. It is constant over the mesh cycle. `schlenk` needs the drawing of a \
                pair on parallel axes. Line loads below 150 N/mm count as 150 N/mm. Speeds above 50 m/s count as 50 \
                m/s. The column friction_coefficient gives the value."),
    quantity("mesh.roughness", Length, bounds(1e-8, false, 2e-5, false), r#""0.5 um""#)
        .otherwise("none; required with friction_law = \"schlenk\"")
        .about("Arithmetic mean roughness Ra, averaged over both flanks. Only with friction_law = \"schlenk\"."),
    quantity("mesh.oil_viscosity", Viscosity, bounds(1e-4, false, 10.0, false), r#""20 mPa*s""#)
        .otherwise("none; required with friction_law = \"schlenk\"")
        .about("Dynamic viscosity of the oil at its operating temperature. Only with friction_law = \"schlenk\"."),
    quantity("mesh.oil_factor", Ratio, bounds(0.1, false, 3.0, false), "0.8").or("1")
        .about("Oil factor X_L: 1 mineral oil, 0.8 polyalphaolefin or ester, about 0.6 polyglycol, 1.3 phosphoric \
                ester, 1.5 traction fluid. Only with friction_law = \"schlenk\"."),
    quantity("mesh.misalignment", Angle, bounds(-0.02, false, 0.02, false), r#""0.5 mrad""#).on_further_meshes().or("0")
        .about("Angle between the unloaded flanks in the plane of action. It moves the load to one end of the face \
                and reduces the stiffness. Only if the mesh is computed from [gear]."),
    key("mesh.shaft_tilt", Kind::Boolean, ANY, "true").on_further_meshes().or("false")
        .about("Add the tilt of the shafts under the mean load to the misalignment. Only if the mesh is computed from \
                [gear]."),
    choice("mesh.contact", &["load_dependent", "linear"], r#""linear""#).on_further_meshes().or(r#""load_dependent""#)
        .about("Law of the contact between the flanks of a mesh computed from [gear]. `load_dependent`: the law of \
                Weber & Banaschek, whose contact stiffens with the load. It takes the secant at the mean load on one \
                pair (at the rated load if the mean is 0). `linear`: an approach proportional to the force, 4 (1 - \
                nu^2)/(pi E) for equal gears. This law makes meshes of solid gears 20 to 60 % too stiff."),
    choice("mesh.face", &["coupled", "independent"], r#""independent""#).on_further_meshes().or(r#""coupled""#)
        .about("Load distribution over the face in a mesh computed from [gear], if flanks are misaligned or leads \
                modified. `coupled`: elasticity in three dimensions. Unloaded parts of teeth and bodies support \
                loaded parts. `independent`: each slice of the face bears load alone. Such thin-slice models \
                overestimate the load of a misaligned face. Helical gears and resolution = \"pairs\" always use \
                `independent`."),
    choice("mesh.resolution", &["secant", "mean_load", "pairs"], r#""pairs""#).on_further_meshes()
        .or(r#""secant""#)
        .about("Law of a mesh computed from [gear] at forces other than the mean load. `secant`: one spring with the \
                secant stiffness from the first touch of the flanks to the mean load. It is exact at both. If contact \
                spreads along the face (misaligned, helical, modified leads), it uses the mean of the tangent \
                stiffness. Its force does not jump when a pair of teeth engages. It accepts all gears. `mean_load`: \
                one spring with the tangent stiffness at the mean load. When a pair engages, its stiffness jumps. Its \
                force also jumps, unless the force equals the mean load. run.kernel = \"closed_modes\" requires \
                `mean_load`. `pairs`: one spring per pair of teeth, each behind its own gap, which includes relief. \
                Stiffness, load centroid and friction then follow the force at every instant, without jumps. `pairs` \
                accepts loads of 0. It requires spur gears and run.kernel = \"volterra\" or \"stepping\"."),
    integer("mesh.slices", 1.0, 4.0, "4").or("1")
        .about("Number of slices of the face, each with separate springs. Only with resolution = \"pairs\". Use more \
                than one if the flanks are misaligned or the shafts tilt. The model has room for 16 springs on both \
                flanks and all pairs. This allows 4 slices with at most two pairs in contact (tip edges included), \
                and 2 slices with three pairs."),
    key("mesh.contact_damping", Kind::ContactDamping, BELOW_ONE, "0.05")
        .about("Viscous damping in contact. A bare number or a percentage is the damping ratio `c / (2 sqrt(k m))`, \
                with the mean stiffness k and the reduced mass m of the two shafts with the gears of the mesh, along the line \
                of action: `1/m = r_b1^2/J_1 + r_b2^2/J_2`. J is the inertia of a whole shaft about its axis, as a rigid \
                body, with all gears and discs on it, or of a loose gear alone. Shafts behind couplings, such as an \
                engine or a car, and carriers of planets do not count. A text such as \"1483 N*s/m\" is the coefficient c itself."),
    choice("mesh.release", &["deflection", "force"], r#""force""#).or(r#""deflection""#)
        .about("Condition that opens a closed contact. It also holds for further contacts of a modal file. \
                `deflection`: the deflection returns to the gap. Just before, the damper pulls. `force`: the force of \
                spring and damper falls to zero, so the contact never pulls. If the flanks have not separated, \
                contact closes again when this force rises to zero. run.kernel = \"closed_modes\" requires \
                `deflection`."),
    key("mesh.tooth_fault", Kind::List("tables"), ANY, r#"[{ gear = "pinion", tooth = 3, stiffness = 0.7 }]"#).or("[]")
        .about("Single teeth unlike the others, one table `[[mesh.tooth_fault]]` each: a crack, a pit or a pitch error. Pairs \
                in contact share the load evenly, unless mesh.resolution = \"pairs\" makes each a spring. The mesh then repeats after a revolution of the gear, and with faults of both gears \
                after the least common multiple of the teeth, at most 10 000 mesh cycles. Needs [gear]."),
    table("mesh.tooth_fault.*"),
    choice("mesh.tooth_fault.*.gear", &["pinion", "wheel"], r#""wheel""#)
        .about("Gear of the tooth."),
    integer("mesh.tooth_fault.*.tooth", 1.0, 100_000.0, "3")
        .about("Number of the tooth in the order in which the teeth engage. Tooth 1 engages at the start of the mesh cycle at time 0."),
    quantity("mesh.tooth_fault.*.stiffness", Ratio, bounds(0.0, true, 1.0, false), "0.7").or("1")
        .about("Part of the stiffness that the pairs of this tooth keep, on both flanks. If both teeth of a pair have faults, their \
                compliances add."),
    quantity("mesh.tooth_fault.*.crack", Length, NON_NEGATIVE, r#""1.5 mm""#).or("0")
        .about("Depth of a crack at the root of the tooth, through the whole face, across the section where the tangent of the \
                fillet makes 30 degrees with the centre line of the tooth. At most 60 % of this section. A crack opens only \
                under load on its own flank."),
    quantity("mesh.tooth_fault.*.loss", Length, ANY, r#""20 um""#).or("0")
        .about("Material removed from the flanks of the tooth, along the line of action, at most a module. It is negative if \
                the flanks protrude."),
    choice("mesh.tooth_fault.*.flanks", &["both", "drive", "coast"], r#""drive""#).or(r#""both""#)
        .about("Flanks with the loss, or with the crack at their root. A pit is on one flank. With a pitch error, one flank of \
                the tooth lacks material and the other protrudes: give two tables."),
    table("mesh.film")
        .about("Film of oil that approaching flanks squeeze out of their gap. Its force is F = 3 sqrt(2) pi viscosity L \
                (R/h)^1.5 (-h'), the force of a full film of thickness h between two cylinders. L is the length of a line \
                of contact, R the reduced radius of curvature at the pitch point. Separating flanks and closed flanks \
                have no film. Needs [gear] and run.kernel = \"volterra\" or \"auto\"."),
    quantity("mesh.film.viscosity", Viscosity, bounds(1e-4, false, 10.0, false), r#""20 mPa*s""#)
        .about("Dynamic viscosity of the oil at its operating temperature."),
    quantity("mesh.film.thickness", Length, bounds(1e-8, true, 1e-2, false), r#""80 um""#).or(r#""50 um""#)
        .about("Thickness at which the film begins to act. It begins at the middle of the gap if the gap is narrower."),
    quantity("mesh.film.least_thickness", Length, bounds(1e-9, false, 1e-4, false), r#""0.5 um""#).or(r#""1 um""#)
        .about("Thickness at which the flanks touch: about the height of their roughness."),
    integer("mesh.film.layers", 1.0, 20.0, "8").or("5")
        .about("Number of layers of constant damping that replace the law. The speed lost through a layer is exact if no \
                other force acts. The error of the place where flanks stop falls with the square of this number."),
    choice("mesh.coast_flank", &["mirrored", "same_line"], r#""same_line""#)
        .otherwise(r#""mirrored", or "same_line" if a modal file has no participations of the coast flanks"#)
        .about("Line of action of the coast flanks. `mirrored`: the line of action of the drive flanks, mirrored \
                about the line of centres. Stiffness, load centroid, friction and flank modifications are mirrored in \
                phase. `same_line`: the line of action of the drive flanks. The coast flanks then have the properties \
                of the drive flanks at the same phase."),
    quantity("mesh.coast_symmetry", Ratio, bounds(0.0, false, 1.0, true), "0.05")
        .otherwise("from [gear], or from the two-level law, (contact_ratio + 1/2)/2; required without both")
        .about("Mesh phase, in cycles, at which a tooth of the pinion is on the line of centres. The coast flanks \
                mirror the drive flanks about this phase. Half a cycle more or less is equivalent. Only with mirrored \
                coast flanks and a varying stiffness or friction."),
];
