//! `[analyses]`.

use crate::manifest::schema::key::{
    ANY, Key, Kind, MANY, POSITIVE, bounds, choice, integer, key, quantity, table,
};
use crate::units::Dimension::{Length, ModalDisplacement, ModalVelocity, Ratio, Velocity};

/// Fewest measured cycles from which an exponent gets an error bar: 32 blocks of ten.
pub(in crate::manifest) const FEWEST_CYCLES: u64 = 320;

const ABSENT: &str = "not computed";

/// What spectra and orders may be taken of.
const SIGNALS: &[&str] = &[
    "deflection",
    "force",
    "bearings",
    "torques",
    "accelerations",
];

#[rustfmt::skip]
pub(super) const KEYS: &[Key] = &[
    table("analyses").otherwise("nothing is computed besides the motion")
        .about("What is computed of each point, a table for each analysis; `{}` takes its defaults. An analysis \
                without a table is not computed."),
    table("analyses.lyapunov").otherwise(ABSENT)
        .about("Lyapunov exponents per mesh cycle, with error bars."),
    integer("analyses.lyapunov.exponents", 1.0, 2000.0, "2").or("1")
        .about("Number of exponents, the largest first. At most twice the retained modes that are not neutral, \
                and one more where drag damps the neutral rotation; each costs a tangent vector."),
    quantity("analyses.lyapunov.stop_at_stderr", Ratio, POSITIVE, "0.01").otherwise("none: all of `run.cycles` are measured")
        .about("Standard error of the largest exponent, per mesh cycle, at which measuring stops. A point ends early where \
                its error would not come down to this within `run.cycles`, and says how many cycles it would take."),
    choice("analyses.lyapunov.effort", &["verified", "survey"], r#""survey""#).or(r#""verified""#)
        .about("How much evidence an error bar takes of a motion that does not settle. `verified` measures eight trajectories \
                and reads errors at 40000 cycles, then at twice as many, and so on: the coverage of these errors was \
                measured. `survey` measures one trajectory and looks at 2000 cycles, for quick maps; its errors are not \
                verified."),
    integer("analyses.lyapunov.lifetime", 1.0, MANY, "10000").otherwise("what the error bar shows")
        .about("Lower bound of the mean life of chaos, in mesh cycles, that is to be shown at 95 %. It takes three times as \
                many chaotic cycles, where no trajectory leaves."),
    key("analyses.lyapunov.chains", Kind::Boolean, ANY, "true").or("false")
        .about("Whether the averages of growth over ten mesh cycles are kept of every trajectory, in the columns \
                `chain_lengths` and `chain_growth`."),
    integer("analyses.lyapunov.align", 0.0, MANY, "200").or("100")
        .about("Mesh cycles discarded after the transient, in which the tangents turn into their directions."),
    key("analyses.lyapunov.twin", Kind::Boolean, ANY, "false").or("true")
        .about("Whether a second trajectory beside the first gives the largest exponent independently of tangents."),
    quantity("analyses.lyapunov.separation", Ratio, bounds(1e-12, false, 0.1, false), "1e-8").or("1e-7")
        .about("Distance of that trajectory, in half gaps. What a finite distance does to the exponent grows with \
                it, and `twin_agrees` allows for that; round-off does the opposite."),
    integer("analyses.lyapunov.course", 0.0, 1000.0, "100").or("0")
        .about("Places over the measured cycles at which running estimates of every exponent and their standard \
                errors are kept (`atlas plot --what convergence`)."),
    choice("analyses.lyapunov.norm", &["energy", "raw"], r#""raw""#).or(r#""energy""#)
        .about("Norm in which growth is measured. `raw` adds metres to metres a second and is there to show what \
                that does."),
    table("analyses.poincare").otherwise(ABSENT)
        .about("Poincaré samples, from which bifurcation diagrams and phase portraits are drawn."),
    integer("analyses.poincare.samples", 1.0, MANY, "100").otherwise("200, or `run.cycles` where a strobe has fewer")
        .about("Most samples kept of each point, the last ones of the measured cycles."),
    choice("analyses.poincare.section",
           &["strobe", "entry", "extremum", "release", "coast_entry", "coast_release", "force_maximum", "surface"],
           r#""entry""#).or(r#""strobe""#)
        .about("Where samples are taken: once a mesh cycle; where drive (coast) contact begins or ends; at every \
                extreme of the mesh deflection; at every maximum of a positive mesh force; or on the surface of \
                `analyses.poincare.surface`."),
    table("analyses.poincare.surface").otherwise("no surface")
        .about("A surface of phase space, where a linear combination of modal displacements and velocities takes a \
                value. Only with section = \"surface\", which needs it."),
    key("analyses.poincare.surface.displacement", Kind::List("numbers in 1/sqrt(kg), one a retained mode"), ANY, "[1.0, 0.0]")
        .otherwise("0 each")
        .about("Coefficients of the modal displacements, which are mass-normalised, in ascending frequency."),
    quantity("analyses.poincare.surface.displacement.*", Ratio, ANY, "1.0"),
    key("analyses.poincare.surface.velocity", Kind::List("numbers in s/sqrt(kg), one a retained mode"), ANY, "[0.0, 1e-4]")
        .otherwise("0 each")
        .about("Coefficients of the modal velocities."),
    quantity("analyses.poincare.surface.velocity.*", Ratio, ANY, "1e-4"),
    quantity("analyses.poincare.surface.level", Length, ANY, r#""10 um""#).or("0")
        .about("The value that the combination takes."),
    choice("analyses.poincare.surface.direction", &["both", "rising", "falling"], r#""rising""#).or(r#""both""#)
        .about("Whether only crossings count at which the combination rises, or falls."),
    quantity("analyses.poincare.phase", Ratio, bounds(0.0, false, 1.0, true), "0.25").or("0")
        .about("Mesh phase of the strobe, in cycles. Only with section = \"strobe\"."),
    integer("analyses.poincare.refine", 0.0, 50.0, "6").or("0")
        .about("How often the interval between neighbours whose motion differs is halved, to place the change. Only \
                where `grid.order` carries the state."),
    table("analyses.nvh").otherwise(ABSENT)
        .about("Statistics of noise, vibration and harshness: deflection, mesh force, contact."),
    integer("analyses.nvh.harmonics", 0.0, 1000.0, "5").or("10")
        .about("Harmonics of the mesh frequency whose amplitudes of the deflection are kept."),
    quantity("analyses.nvh.stop_at_stderr", Ratio, bounds(0.0, true, 1.0, true), "0.02")
        .otherwise("none: statistics are gathered as long as the point is measured")
        .about("Relative standard error at which no more NVH statistics are gathered of a motion that does not repeat. Every \
                time average counts against its value (a mean against the root mean square of its signal, a power of the balance against \
                its largest one), every order and \
                line of a spectrum against a sine of the signal's root mean square, fractions of time against 1. Without \
                `analyses.lyapunov` the point is done then; with `analyses.lyapunov.stop_at_stderr` it is done when both \
                errors are small enough."),
    table("analyses.nvh.spectrum").otherwise("no spectra")
        .about("Spectra (spectra.parquet). Of a motion that repeats they are its exact lines, of any other averaged power."),
    key("analyses.nvh.spectrum.signals", Kind::List("signals"), ANY, r#"["force", "bearings"]"#).or(r#"["deflection", "force"]"#)
        .about("Of what: the mesh deflection, the mesh force, bearing forces, torques in shafts and couplings, accelerations \
                at bearings and of rotating bodies."),
    choice("analyses.nvh.spectrum.signals.*", SIGNALS, r#""bearings""#),
    integer("analyses.nvh.spectrum.highest_order", 1.0, 100.0, "32").or("10")
        .about("Highest multiple of the mesh frequency."),
    integer("analyses.nvh.spectrum.resolution", 8.0, 1024.0, "64").or("32")
        .about("Lines to a mesh order, at least, of a motion that does not repeat: mesh cycles in a segment. It is \
                raised to whole periods of the excitation where these are no longer than four times as many, so that \
                shaft orders stand on lines."),
    table("analyses.nvh.orders").otherwise("no orders")
        .about("Amplitude and phase at multiples of the mesh frequency and of both shafts' speeds (orders.parquet)."),
    key("analyses.nvh.orders.signals", Kind::List("signals"), ANY, r#"["bearings", "torques"]"#).or(r#"["deflection", "force"]"#)
        .about("Of what, as for spectra."),
    choice("analyses.nvh.orders.signals.*", SIGNALS, r#""torques""#),
    integer("analyses.nvh.orders.mesh", 0.0, 1000.0, "5").or("10")
        .about("Multiples of the mesh frequency: 1, 2, ... up to this."),
    integer("analyses.nvh.orders.shafts", 0.0, 1000.0, "8").or("4")
        .about("Multiples of the speed of the pinion's and of the wheel's shaft, below the number of teeth. They are taken over whole \
                revolutions."),
    key("analyses.nvh.bearings", Kind::Boolean, ANY, "true").or("false")
        .about("Whether mean and RMS of the bearing forces are computed."),
    key("analyses.nvh.torques", Kind::Boolean, ANY, "true").or("false")
        .about("Whether mean and RMS of the torques in flexible shafts and couplings are computed."),
    key("analyses.nvh.accelerations", Kind::Boolean, ANY, "true").or("false")
        .about("Whether the RMS of accelerations at bearings and of angular accelerations of shafts is computed."),
    key("analyses.nvh.power", Kind::Boolean, ANY, "true").or("false")
        .about("Whether the power balance of the vibration is computed: the power that loads, transmission error and varying \
                stiffness feed in, and that contact damping, damping of the structure and friction take out."),
    table("analyses.multistability").otherwise(ABSENT)
        .about("Probes from many initial states: which motions coexist, and the share of each."),
    integer("analyses.multistability.initial_conditions", 1.0, 1e6, "64").or("32")
        .about("Probes of each point. The first starts from `run.initial`."),
    quantity("analyses.multistability.decades", Ratio, bounds(0.0, false, 12.0, false), "8").or("4")
        .about("Decades of energy that the other probes are spread over, about the energy that closes the half gap."),
    integer("analyses.multistability.transient", 0.0, MANY, "2000").otherwise("`run.transient`")
        .about("Mesh cycles of each probe discarded."),
    integer("analyses.multistability.cycles", FEWEST_CYCLES as f64, MANY, "2000").otherwise("`run.cycles`, from 320 to 4000")
        .about("Most mesh cycles of each probe measured."),
    table("analyses.multistability.slice").otherwise("no slice")
        .about("A plane of initial states through `run.initial`, from which basins of attraction are drawn: along \
                two modes, or the phase plane of one."),
    key("analyses.multistability.slice.modes", Kind::List("2 integers: modes, counted from 1"), ANY, "[3, 7]").of_length(2)
        .otherwise("none, where `mode` is given")
        .about("The two modes that span the plane: different, retained, and felt by the mesh."),
    integer("analyses.multistability.slice.modes.*", 1.0, 1000.0, "3"),
    integer("analyses.multistability.slice.mode", 1.0, 1000.0, "1").otherwise("none, where `modes` are given")
        .about("The mode whose displacement (across) and velocity (up) span the plane instead, both as mesh \
                deflection and its rate: the plane (x, v) of an oscillator with one degree of freedom."),
    quantity("analyses.multistability.slice.speed", Velocity, POSITIVE, r#""0.1 m/s""#)
        .otherwise("`extent`, times the mode's scale in the energy norm")
        .about("Half the height of the plane (x, v), as rate of the mesh deflection. Only with `mode`."),
    choice("analyses.multistability.slice.of", &["displacement", "velocity"], r#""velocity""#).or(r#""displacement""#)
        .about("Whether modal displacements or velocities are varied. Only with `modes`."),
    quantity("analyses.multistability.slice.extent", Length, POSITIVE, r#""30 um""#)
        .about("Half the side of the plane, as mesh deflection of one mode alone."),
    integer("analyses.multistability.slice.count", 1.0, 512.0, "96").or("48")
        .about("Cells along each side; their square is the number of initial states."),
    table("analyses.orbits").otherwise(ABSENT)
        .about("Periodic orbits, stable or not, sought by Newton's method from near returns of the motion and from \
                states that are given."),
    key("analyses.orbits.periods", Kind::List("whole numbers from 1 to 64: mesh cycles"), ANY, "[1, 2, 4]").or("[1, 2]")
        .about("Periods that are sought, in mesh cycles."),
    integer("analyses.orbits.periods.*", 1.0, 64.0, "2"),
    integer("analyses.orbits.guesses", 1.0, 10_000.0, "32").or("16")
        .about("Newton searches for each period."),
    integer("analyses.orbits.cycles", 1.0, 1e6, "1000").or("400")
        .about("Mesh cycles of motion that first guesses are taken from."),
    key("analyses.orbits.floquet", Kind::Boolean, ANY, "false").or("true")
        .about("Whether all Floquet multipliers are kept, besides the verdict on stability."),
    integer("analyses.orbits.returns", 1.0, 1000.0, "20").or("10")
        .about("Returns to each orbit that a kick of 1e-5 half gaps, in the direction of strongest growth, is followed over."),
    key("analyses.orbits.states", Kind::List("tables"), ANY, "[{ displacement = [0.0, 1e-6], velocity = [0.0, 1e-3] }]").or("[]")
        .about("Further states that every period is sought from, each as `run.initial` takes a modal state. One that \
                leads to no orbit has a row of its own in orbits.parquet, which says why."),
    table("analyses.orbits.states.*"),
    key("analyses.orbits.states.*.displacement", Kind::List("numbers in m sqrt(kg), one a retained mode"), ANY, "[0.0, 1e-6]")
        .about("Modal displacements, mass-normalised, one a retained mode in ascending frequency."),
    quantity("analyses.orbits.states.*.displacement.*", ModalDisplacement, ANY, "1e-6"),
    key("analyses.orbits.states.*.velocity", Kind::List("numbers in m sqrt(kg)/s, one a retained mode"), ANY, "[0.0, 1e-3]")
        .about("Modal velocities, mass-normalised, one a retained mode in ascending frequency."),
    quantity("analyses.orbits.states.*.velocity.*", ModalVelocity, ANY, "1e-3"),
    table("analyses.horizon").otherwise(ABSENT)
        .about("How far ahead chaotic motion can be foretold, and how averages settle. Needs `analyses.lyapunov`."),
    integer("analyses.horizon.twins", 2.0, 10_000.0, "32").or("16")
        .about("Pairs of neighbouring trajectories that are followed."),
    quantity("analyses.horizon.separation", Ratio, bounds(1e-12, false, 0.1, false), "1e-8").or("1e-6")
        .about("Distance at which they start, in half gaps."),
    integer("analyses.horizon.cycles", 1.0, 100_000.0, "100").or("60")
        .about("Mesh cycles that each pair is followed."),
    integer("analyses.horizon.averages", 1.0, 1e6, "1000").or("400")
        .about("Mesh cycles in the longest averages."),
    table("analyses.covariant").otherwise(ABSENT)
        .about("Covariant Lyapunov vectors of motion that does not repeat: local exponents, and the angle between \
                growing and shrinking directions. Needs `analyses.lyapunov`."),
    integer("analyses.covariant.vectors", 1.0, 2000.0, "4").or("2")
        .about("Number of vectors, those of the largest exponents. At most twice the retained modes that are not neutral, \
                and one more where drag damps the neutral rotation."),
    integer("analyses.covariant.cycles", FEWEST_CYCLES as f64, MANY, "5000").or("1000")
        .about("Mesh cycles measured. With v vectors each keeps v(v + 1)/2 numbers in memory, 1 GiB at most in all."),
    integer("analyses.covariant.align", 1.0, MANY, "500").or("200")
        .about("Mesh cycles discarded at either end, in which the vectors turn into their directions."),
];
