//! The table of every key: of a manifest, and of a modal file.

use super::{Bounds, Key, Kind};
use crate::units::Dimension;
use Dimension::{
    Angle, AngularSpeed, Density, Force, ForceByDisplacement, Inertia, Length, Mass,
    ModalDisplacement, ModalVelocity, Participation, ParticipationByLength, Pressure, Ratio,
    Stiffness, TiltStiffness, Torque,
};
use Kind::{Boolean, Choice, List, Text};
use std::f64::consts::FRAC_PI_4;

const fn bounds(min: f64, min_open: bool, max: f64, max_open: bool) -> Bounds {
    Bounds {
        min,
        min_open,
        max,
        max_open,
    }
}

const INF: f64 = f64::INFINITY;
const ANY: Bounds = bounds(-INF, true, INF, true);
const POSITIVE: Bounds = bounds(0.0, true, INF, true);
const NON_NEGATIVE: Bounds = bounds(0.0, false, INF, true);
/// Damping ratios: the kernels take underdamped and undamped modes only.
const BELOW_ONE: Bounds = bounds(0.0, false, 1.0, true);

const fn key(path: &'static str, kind: Kind, bounds: Bounds, example: &'static str) -> Key {
    Key {
        path,
        kind,
        bounds,
        example,
        why: "",
    }
}

impl Key {
    const fn because(self, why: &'static str) -> Self {
        Self { why, ..self }
    }
}

const fn table(path: &'static str) -> Key {
    key(path, Kind::Table, ANY, "")
}

const fn quantity(
    path: &'static str,
    dimension: Dimension,
    bounds: Bounds,
    example: &'static str,
) -> Key {
    key(path, Kind::Quantity(dimension), bounds, example)
}

const fn integer(path: &'static str, min: f64, max: f64, example: &'static str) -> Key {
    key(path, Kind::Integer, bounds(min, false, max, false), example)
}

/// Poisson's ratio of a common isotropic material.
const POISSON: Bounds = bounds(0.0, false, 0.5, true);

/// Counts that only memory and patience limit; the bound catches slips of the pen.
pub(super) const MANY: f64 = 1e9;

/// Fewest measured cycles from which an exponent gets an error bar: 32 blocks of ten.
pub(in crate::manifest) const FEWEST_CYCLES: u64 = 320;

/// Model kinds: the rigid-body tiers, flexible shafts, modes from a file.
const MODEL_KINDS: [&str; 6] = [
    "torsional",
    "translational",
    "tilting",
    "pedestal",
    "flexible",
    "modal",
];

/// The keys of a manifest.
#[rustfmt::skip]
pub(in crate::manifest) static MANIFEST: &[Key] = &[
    table("job"),
    key("job.name", Text, ANY, r#""flex80""#),
    integer("job.seed", 0.0, 9.2e18, "1"),
    table("model"),
    key("model.kind", Choice(&MODEL_KINDS), ANY, r#""flexible""#),
    integer("model.modes", 2.0, 1000.0, "40"),
    integer("model.retained", 1.0, 1000.0, "20"),
    key("model.mta", Boolean, ANY, "true"),
    quantity("model.damping", Ratio, BELOW_ONE, "0.01"),
    key("model.damping_overrides", List("tables"), ANY, "[{ mode = 7, ratio = 0.02 }]"),
    table("model.damping_overrides.*"),
    integer("model.damping_overrides.*.mode", 1.0, 1000.0, "7"),
    quantity("model.damping_overrides.*.ratio", Ratio, BELOW_ONE, "0.02"),
    key("model.file", Text, ANY, r#""drive.modal.toml""#),
    table("gear"),
    key("gear.teeth", List("2 integers: pinion, wheel"), ANY, "[20, 30]"),
    integer("gear.teeth.*", 5.0, 1000.0, "20"),
    quantity("gear.module", Length, POSITIVE, r#""4 mm""#),
    quantity("gear.pressure_angle", Angle, bounds(0.0, true, FRAC_PI_4, true), r#""20 deg""#),
    quantity("gear.face_width", Length, POSITIVE, r#""20 mm""#),
    key("gear.body_length", List("2 lengths: pinion, wheel"), ANY, r#"["70 mm", "40 mm"]"#),
    quantity("gear.body_length.*", Length, POSITIVE, r#""70 mm""#),
    quantity("gear.rated_torque", Torque, POSITIVE, r#""50 N*m""#),
    key("gear.profile_shift", List("2 coefficients: pinion, wheel"), ANY, "[0.3, -0.1]"),
    quantity("gear.profile_shift.*", Ratio, bounds(-5.0, false, 5.0, false), "0.3"),
    table("gear.rack"),
    quantity("gear.rack.addendum", Ratio, POSITIVE, "1.0"),
    quantity("gear.rack.dedendum", Ratio, POSITIVE, "1.25"),
    quantity("gear.rack.tip_radius", Ratio, NON_NEGATIVE, "0.38"),
    key("gear.thinning", Kind::Quantity(Length), NON_NEGATIVE, r#""30 um""#),
    quantity("gear.thinning.*", Length, NON_NEGATIVE, r#""30 um""#),
    quantity("gear.centre_distance", Length, POSITIVE, r#""100.5 mm""#),
    key("gear.tip_diameter", List("2 lengths: pinion, wheel"), ANY, r#"["88 mm", "128 mm"]"#),
    quantity("gear.tip_diameter.*", Length, POSITIVE, r#""88 mm""#),
    table("gear.tip_relief"),
    key("gear.tip_relief.amount", Kind::Quantity(Length), NON_NEGATIVE, r#""10 um""#),
    quantity("gear.tip_relief.amount.*", Length, NON_NEGATIVE, r#""10 um""#),
    key("gear.tip_relief.length", Kind::Quantity(Length), POSITIVE, r#""3 mm""#),
    quantity("gear.tip_relief.length.*", Length, POSITIVE, r#""3 mm""#),
    table("gear.root_relief"),
    key("gear.root_relief.amount", Kind::Quantity(Length), NON_NEGATIVE, r#""10 um""#),
    quantity("gear.root_relief.amount.*", Length, NON_NEGATIVE, r#""10 um""#),
    key("gear.root_relief.length", Kind::Quantity(Length), POSITIVE, r#""3 mm""#),
    quantity("gear.root_relief.length.*", Length, POSITIVE, r#""3 mm""#),
    key("gear.bore", Kind::Quantity(Length), POSITIVE, r#""35 mm""#),
    quantity("gear.bore.*", Length, POSITIVE, r#""35 mm""#),
    key("gear.young_modulus", Kind::Quantity(Pressure), POSITIVE, r#""206 GPa""#),
    quantity("gear.young_modulus.*", Pressure, POSITIVE, r#""206 GPa""#),
    key("gear.poisson_ratio", Kind::Quantity(Ratio), POISSON, "0.3"),
    quantity("gear.poisson_ratio.*", Ratio, POISSON, "0.3"),
    table("shafts"),
    quantity("shafts.young_modulus", Pressure, POSITIVE, r#""206 GPa""#),
    quantity("shafts.shear_modulus", Pressure, POSITIVE, r#""79 GPa""#),
    quantity("shafts.density", Density, POSITIVE, r#""7850 kg/m^3""#),
    quantity("shafts.shear_coefficient", Ratio, bounds(0.0, true, 1.0, false), "0.9"),
    key("shafts.elements", List("3 integers: overhang, first bearing to gear, gear to second bearing"), ANY, "[3, 5, 7]"),
    integer("shafts.elements.*", 1.0, 100.0, "5"),
    quantity("shafts.span", Length, POSITIVE, r#""120 mm""#),
    quantity("shafts.overhang", Length, POSITIVE, r#""40 mm""#),
    quantity("shafts.gear_position", Ratio, bounds(0.0, true, 1.0, true), "0.45"),
    table("shafts.bearings"),
    key("shafts.bearings.line_of_centres", Kind::Quantity(Stiffness), POSITIVE, r#""1.25e8 N/m""#),
    quantity("shafts.bearings.line_of_centres.*", Stiffness, POSITIVE, r#""1.25e8 N/m""#),
    key("shafts.bearings.across", Kind::Quantity(Stiffness), POSITIVE, r#""1e8 N/m""#),
    quantity("shafts.bearings.across.*", Stiffness, POSITIVE, r#""1e8 N/m""#),
    key("shafts.bearings.tilt", Kind::Quantity(TiltStiffness), NON_NEGATIVE, r#""2e4 N*m/rad""#),
    quantity("shafts.bearings.tilt.*", TiltStiffness, NON_NEGATIVE, r#""2e4 N*m/rad""#),
    key("shafts.bearings.axial", List("2 stiffnesses: first bearing, second bearing"), ANY, r#"["1e8 N/m", 0]"#),
    quantity("shafts.bearings.axial.*", Stiffness, NON_NEGATIVE, r#""1e8 N/m""#),
    table("shafts.pedestals"),
    key("shafts.pedestals.line_of_centres", Kind::Quantity(Stiffness), POSITIVE, r#""4e8 N/m""#),
    quantity("shafts.pedestals.line_of_centres.*", Stiffness, POSITIVE, r#""4e8 N/m""#),
    key("shafts.pedestals.across", Kind::Quantity(Stiffness), POSITIVE, r#""3e8 N/m""#),
    quantity("shafts.pedestals.across.*", Stiffness, POSITIVE, r#""3e8 N/m""#),
    key("shafts.pedestals.mass", Kind::Quantity(Mass), POSITIVE, r#""3 kg""#),
    quantity("shafts.pedestals.mass.*", Mass, POSITIVE, r#""3 kg""#),
    table("shafts.<shaft>"),
    quantity("shafts.<shaft>.diameter", Length, POSITIVE, r#""22 mm""#),
    quantity("shafts.<shaft>.end_inertia", Inertia, NON_NEGATIVE, r#""2e-3 kg*m^2""#),
    quantity("shafts.<shaft>.span", Length, POSITIVE, r#""120 mm""#),
    quantity("shafts.<shaft>.overhang", Length, POSITIVE, r#""40 mm""#),
    quantity("shafts.<shaft>.gear_position", Ratio, bounds(0.0, true, 1.0, true), "0.45"),
    table("shafts.<shaft>.bearings"),
    key("shafts.<shaft>.bearings.line_of_centres", Kind::Quantity(Stiffness), POSITIVE, r#""1.25e8 N/m""#),
    quantity("shafts.<shaft>.bearings.line_of_centres.*", Stiffness, POSITIVE, r#""1.25e8 N/m""#),
    key("shafts.<shaft>.bearings.across", Kind::Quantity(Stiffness), POSITIVE, r#""1e8 N/m""#),
    quantity("shafts.<shaft>.bearings.across.*", Stiffness, POSITIVE, r#""1e8 N/m""#),
    key("shafts.<shaft>.bearings.tilt", Kind::Quantity(TiltStiffness), NON_NEGATIVE, r#""2e4 N*m/rad""#),
    quantity("shafts.<shaft>.bearings.tilt.*", TiltStiffness, NON_NEGATIVE, r#""2e4 N*m/rad""#),
    key("shafts.<shaft>.bearings.axial", List("2 stiffnesses: first bearing, second bearing"), ANY, r#"["1e8 N/m", 0]"#),
    quantity("shafts.<shaft>.bearings.axial.*", Stiffness, NON_NEGATIVE, r#""1e8 N/m""#),
    table("shafts.<shaft>.pedestals"),
    key("shafts.<shaft>.pedestals.line_of_centres", Kind::Quantity(Stiffness), POSITIVE, r#""4e8 N/m""#),
    quantity("shafts.<shaft>.pedestals.line_of_centres.*", Stiffness, POSITIVE, r#""4e8 N/m""#),
    key("shafts.<shaft>.pedestals.across", Kind::Quantity(Stiffness), POSITIVE, r#""3e8 N/m""#),
    quantity("shafts.<shaft>.pedestals.across.*", Stiffness, POSITIVE, r#""3e8 N/m""#),
    key("shafts.<shaft>.pedestals.mass", Kind::Quantity(Mass), POSITIVE, r#""3 kg""#),
    quantity("shafts.<shaft>.pedestals.mass.*", Mass, POSITIVE, r#""3 kg""#),
    table("mesh"),
    quantity("mesh.half_gap", Length, POSITIVE, r#""15 um""#),
    quantity("mesh.normal_backlash", Length, POSITIVE, r#""30 um""#),
    quantity("mesh.circumferential_backlash", Length, POSITIVE, r#""32 um""#),
    key("mesh.stiffness", Choice(&["table", "piecewise", "continuous", "constant"]), ANY, r#""piecewise""#),
    quantity("mesh.mean_stiffness", Stiffness, POSITIVE, r#""4e8 N/m""#),
    quantity("mesh.contact_ratio", Ratio, bounds(1.0, true, 2.0, false), "1.6"),
    quantity("mesh.single_pair_drop", Ratio, BELOW_ONE, "0.25"),
    integer("mesh.segments", 1.0, 10_000.0, "60"),
    key("mesh.values", List("stiffnesses, one a segment of the mesh cycle"), ANY, r#"["4.4e8 N/m", "3.3e8 N/m"]"#),
    quantity("mesh.values.*", Stiffness, POSITIVE, r#""4.4e8 N/m""#),
    quantity("mesh.friction", Ratio, BELOW_ONE, "0.05"),
    quantity("mesh.misalignment", Angle, bounds(-0.02, false, 0.02, false), r#""0.5 mrad""#),
    key("mesh.shaft_tilt", Boolean, ANY, "true"),
    key("mesh.contact_damping", Kind::ContactDamping, BELOW_ONE, "0.05"),
    table("excitation"),
    key("excitation.transmission_error", List("tables"), ANY, r#"[{ harmonic = 1, amplitude = "5 um" }]"#),
    table("excitation.transmission_error.*"),
    integer("excitation.transmission_error.*.harmonic", 1.0, 1000.0, "1"),
    quantity("excitation.transmission_error.*.amplitude", Length, NON_NEGATIVE, r#""5 um""#),
    quantity("excitation.transmission_error.*.phase", Angle, ANY, r#""90 deg""#),
    integer("excitation.table_harmonics", 0.0, 100.0, "10"),
    key("excitation.torque_ripple", List("tables"), ANY, r#"[{ shaft = "pinion", order = 2, amplitude = "3 N*m" }]"#),
    table("excitation.torque_ripple.*"),
    key("excitation.torque_ripple.*.shaft", Choice(&["pinion", "wheel"]), ANY, r#""pinion""#),
    quantity("excitation.torque_ripple.*.order", Ratio, POSITIVE, "2"),
    quantity("excitation.torque_ripple.*.amplitude", Torque, NON_NEGATIVE, r#""3 N*m""#),
    quantity("excitation.torque_ripple.*.phase", Angle, ANY, r#""90 deg""#),
    table("grid"),
    key("grid.load", Kind::Axis(Ratio), POSITIVE, "{ from = 0.05, to = 0.30, count = 8 }"),
    key("grid.speed", Kind::Axis(AngularSpeed), POSITIVE, r#"{ values = ["600 rad/s", "700 rad/s"] }"#),
    key("grid.order", Choice(&["independent", "sweep-up", "sweep-down", "both"]), ANY, r#""independent""#),
    key("grid.along", Text, ANY, r#""speed""#),
    table("run"),
    integer("run.transient", 0.0, MANY, "200"),
    integer("run.cycles", 1.0, MANY, "800"),
    key("run.kernel", Choice(&["volterra", "stepping", "dyadic", "hermite", "spectral", "fused"]), ANY, r#""volterra""#),
    key("run.tolerance", Kind::Tolerance, bounds(1e-16, false, 1e-3, false), r#""roundoff""#),
    integer("run.steps", 16.0, 1e6, "4096").because("each is kept: 60 bytes of every point at work"),
    integer("run.cells", 1.0, 1e4, "60"),
    integer("run.event_grid", 1.0, MANY, "6000"),
    key("run.instructions", Choice(&["auto", "portable"]), ANY, r#""auto""#),
    key("run.initial", Kind::Initial, ANY, r#""static""#),
    key("run.initial.displacement", List("numbers in m sqrt(kg), one a retained mode"), ANY, "[0.0, 1e-6]"),
    quantity("run.initial.displacement.*", ModalDisplacement, ANY, "1e-6"),
    key("run.initial.velocity", List("numbers in m sqrt(kg)/s, one a retained mode"), ANY, "[0.0, 1e-3]"),
    quantity("run.initial.velocity.*", ModalVelocity, ANY, "1e-3"),
    key("run.settle", Boolean, ANY, "true"),
    integer("run.audit_cycles", 0.0, MANY, "20"),
    integer("run.event_limit", 1.0, MANY, "1000"),
    table("analyses"),
    table("analyses.lyapunov"),
    integer("analyses.lyapunov.exponents", 1.0, 2000.0, "1"),
    quantity("analyses.lyapunov.stop_at_stderr", Ratio, POSITIVE, "0.01"),
    integer("analyses.lyapunov.align", 0.0, MANY, "100"),
    key("analyses.lyapunov.twin", Boolean, ANY, "true"),
    key("analyses.lyapunov.norm", Choice(&["energy", "raw"]), ANY, r#""energy""#),
    table("analyses.poincare"),
    integer("analyses.poincare.samples", 1.0, MANY, "200"),
    key("analyses.poincare.section", Choice(&["strobe", "entry", "turning"]), ANY, r#""strobe""#),
    quantity("analyses.poincare.phase", Ratio, bounds(0.0, false, 1.0, true), "0.25"),
    integer("analyses.poincare.refine", 0.0, 50.0, "6"),
    table("analyses.nvh"),
    integer("analyses.nvh.harmonics", 0.0, 1000.0, "10"),
    key("analyses.nvh.spectrum", Boolean, ANY, "true"),
    key("analyses.nvh.bearings", Boolean, ANY, "true"),
    table("analyses.multistability"),
    integer("analyses.multistability.initial_conditions", 1.0, 1e6, "32"),
    quantity("analyses.multistability.decades", Ratio, bounds(0.0, false, 12.0, false), "4"),
    integer("analyses.multistability.transient", 0.0, MANY, "2000"),
    integer("analyses.multistability.cycles", FEWEST_CYCLES as f64, MANY, "2000"),
    table("analyses.multistability.slice"),
    key("analyses.multistability.slice.modes", List("2 integers: modes, counted from 1"), ANY, "[3, 7]"),
    integer("analyses.multistability.slice.modes.*", 1.0, 1000.0, "3"),
    key("analyses.multistability.slice.of", Choice(&["displacement", "velocity"]), ANY, r#""displacement""#),
    quantity("analyses.multistability.slice.extent", Length, POSITIVE, r#""30 um""#),
    integer("analyses.multistability.slice.count", 1.0, 512.0, "48"),
    table("analyses.orbits"),
    key("analyses.orbits.periods", List("whole numbers from 1 to 64: mesh cycles"), ANY, "[1, 2]"),
    integer("analyses.orbits.periods.*", 1.0, 64.0, "2"),
    integer("analyses.orbits.guesses", 1.0, 10_000.0, "16"),
    integer("analyses.orbits.cycles", 1.0, 1e6, "400"),
    key("analyses.orbits.floquet", Boolean, ANY, "true"),
    table("analyses.horizon"),
    integer("analyses.horizon.twins", 2.0, 10_000.0, "16"),
    quantity("analyses.horizon.separation", Ratio, bounds(1e-12, false, 0.1, false), "1e-6"),
    integer("analyses.horizon.cycles", 1.0, 100_000.0, "60"),
    integer("analyses.horizon.averages", 1.0, 1e6, "400"),
];

/// The keys of a modal file.
#[rustfmt::skip]
pub(in crate::manifest) static MODAL_FILE: &[Key] = &[
    integer("teeth", 1.0, 1000.0, "20"),
    integer("teeth_wheel", 1.0, 10_000.0, "30"),
    quantity("rated_force", Force, POSITIVE, "1330.0"),
    key("frequency", List("angular frequencies, one a mode"), ANY, "[0.0, 0.0, 4452.8]"),
    quantity("frequency.*", AngularSpeed, NON_NEGATIVE, "4452.8"),
    key("damping", List("ratios, one a mode"), ANY, "[0.0, 0.0, 0.02]"),
    quantity("damping.*", Ratio, BELOW_ONE, "0.02"),
    key("mesh", List("numbers in 1/sqrt(kg), one a mode"), ANY, "[0.52, -0.43, 0.31]"),
    quantity("mesh.*", Participation, ANY, "0.52"),
    key("torque", List("numbers in 1/sqrt(kg), one a mode"), ANY, "[0.52, -0.43, 0.31]"),
    quantity("torque.*", Participation, ANY, "0.52"),
    key("mesh_tilt", List("numbers in 1/(m sqrt(kg)), one a mode"), ANY, "[0.0, 0.0, -0.21]"),
    quantity("mesh_tilt.*", ParticipationByLength, ANY, "-0.21"),
    key("friction", List("numbers in 1/sqrt(kg), one a mode"), ANY, "[0.0, 0.0, 0.1]"),
    quantity("friction.*", Participation, ANY, "0.1"),
    key("friction_lever", List("numbers in 1/(m sqrt(kg)), one a mode"), ANY, "[0.0, 0.0, 0.0]"),
    quantity("friction_lever.*", ParticipationByLength, ANY, "0.0"),
    key("torque_pinion", List("numbers in 1/(m sqrt(kg)), one a mode"), ANY, "[13.8, -11.4, 8.2]"),
    quantity("torque_pinion.*", ParticipationByLength, ANY, "13.8"),
    key("torque_wheel", List("numbers in 1/(m sqrt(kg)), one a mode"), ANY, "[-9.2, 7.6, -5.5]"),
    quantity("torque_wheel.*", ParticipationByLength, ANY, "-9.2"),
    key("bearing", List("tables"), ANY, r#"[{ name = "pinion 1 line", gain = [0.0, 2.1e7, -4.4e6] }]"#),
    table("bearing.*"),
    key("bearing.*.name", Text, ANY, r#""pinion 1 line""#),
    key("bearing.*.gain", List("numbers in N/(m sqrt(kg)), one a mode"), ANY, "[0.0, 2.1e7, -4.4e6]"),
    quantity("bearing.*.gain.*", ForceByDisplacement, ANY, "2.1e7"),
];
