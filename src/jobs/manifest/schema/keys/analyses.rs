//! The keys of the table `[analyses]`.

use crate::manifest::schema::key::{
    ANY, Key, Kind, LARGEST_COUNT, POSITIVE, bounds, choice, integer, key, quantity, table,
};
use crate::units::Dimension::{Length, ModalDisplacement, ModalVelocity, Ratio, Velocity};

/// Smallest number of measured cycles for an exponent with an error bar: 32 blocks of ten.
pub(in crate::manifest) const FEWEST_CYCLES: u64 = 320;

const ABSENT: &str = "not computed";

/// Quantities for spectra and orders.
pub(super) const SIGNALS: &[&str] = &[
    "deflection",
    "force",
    "bearings",
    "torques",
    "accelerations",
    "meshes",
];

#[rustfmt::skip]
pub(super) const KEYS: &[Key] = &[
    table("analyses").otherwise("only the motion itself is computed")
        .about("Selects the analyses of each point, one table per analysis. `{}` takes its defaults. An analysis \
                without a table is not computed."),
    table("analyses.lyapunov").otherwise(ABSENT)
        .about("Lyapunov exponents per mesh cycle, with error bars."),
    integer("analyses.lyapunov.exponents", 1.0, 2000.0, "2").or("1")
        .about("Number of exponents, the largest first. The limit is twice the number of retained modes that are not \
                neutral, plus one if drag damps the neutral rotation. Each exponent costs one tangent vector."),
    quantity("analyses.lyapunov.stop_at_stderr", Ratio, POSITIVE, "0.01").otherwise("none: all of `run.cycles` are measured")
        .about("Standard error of the largest exponent, per mesh cycle, at which measuring stops. A point ends early \
                if its error cannot reach this value within `run.cycles`. It then reports how many cycles that would \
                take."),
    choice("analyses.lyapunov.effort", &["verified", "survey"], r#""survey""#).or(r#""verified""#)
        .about("Evidence behind the error bars of a motion that does not settle. `verified` measures eight \
                trajectories and reads errors at 40000 cycles, then at twice as many, and so on. The coverage of \
                these errors was measured. `survey` measures one trajectory and reads its error at 2000 cycles, for \
                quick maps. Its errors are not verified."),
    integer("analyses.lyapunov.lifetime", 1.0, LARGEST_COUNT, "10000").otherwise("the bound that the measured cycles give")
        .about("Lower bound of the mean life of chaos, in mesh cycles, to be shown at 95 % confidence. This takes \
                three times as many chaotic cycles if no trajectory leaves the chaos."),
    key("analyses.lyapunov.chains", Kind::Boolean, ANY, "true").or("false")
        .about("Keep the growth of every trajectory, averaged over ten mesh cycles, in the columns `chain_lengths` \
                and `chain_growth`."),
    integer("analyses.lyapunov.align", 0.0, LARGEST_COUNT, "200").or("100")
        .about("Mesh cycles discarded after the transient while the tangent vectors align with the Lyapunov directions."),
    key("analyses.lyapunov.twin", Kind::Boolean, ANY, "false").or("true")
        .about("Follow a second trajectory, the twin, beside the first. It gives the largest exponent without tangent vectors."),
    quantity("analyses.lyapunov.separation", Ratio, bounds(1e-12, false, 0.1, false), "1e-8").or("1e-7")
        .about("Initial distance of the twin from the first trajectory, in half gaps. A larger distance biases the \
                exponent, and `twin_agrees` allows for this bias. With a smaller distance, round-off biases the \
                exponent."),
    integer("analyses.lyapunov.course", 0.0, 1000.0, "100").or("0")
        .about("Number of running estimates to keep of every exponent and its standard error, over the measured \
                cycles. `atlas plot --what convergence` draws them."),
    choice("analyses.lyapunov.norm", &["energy", "raw"], r#""raw""#).or(r#""energy""#)
        .about("Norm in which growth is measured. `raw` adds metres to metres per second; use it only to see the \
                resulting distortion."),
    table("analyses.poincare").otherwise(ABSENT)
        .about("Poincaré samples, from which bifurcation diagrams and phase portraits are drawn."),
    integer("analyses.poincare.samples", 1.0, LARGEST_COUNT, "100").otherwise("200, or `run.cycles` if a strobe has fewer")
        .about("Largest number of samples kept per point. The last samples of the measured cycles are kept."),
    choice("analyses.poincare.section",
           &["strobe", "entry", "extremum", "release", "coast_entry", "coast_release", "force_maximum", "surface"],
           r#""entry""#).or(r#""strobe""#)
        .about("Section of phase space on which samples are taken. `strobe`: a mesh phase, once per mesh cycle. \
                `entry`, `release`: beginning and end of drive contact. `coast_entry`, `coast_release`: beginning and \
                end of coast contact. `extremum`: every extreme of the mesh deflection. `force_maximum`: every \
                positive maximum of the mesh force. `surface`: the surface in `analyses.poincare.surface`."),
    table("analyses.poincare.surface").otherwise("no surface")
        .about("A surface of phase space, on which a linear combination of modal displacements and velocities has a \
                given value. Required with section = \"surface\", and only allowed there."),
    key("analyses.poincare.surface.displacement", Kind::List("numbers in 1/sqrt(kg), one per retained mode"), ANY, "[1.0, 0.0]")
        .otherwise("all 0")
        .about("Coefficients of the mass-normalised modal displacements, in ascending frequency."),
    quantity("analyses.poincare.surface.displacement.*", Ratio, ANY, "1.0"),
    key("analyses.poincare.surface.velocity", Kind::List("numbers in s/sqrt(kg), one per retained mode"), ANY, "[0.0, 1e-4]")
        .otherwise("all 0")
        .about("Coefficients of the modal velocities."),
    quantity("analyses.poincare.surface.velocity.*", Ratio, ANY, "1e-4"),
    quantity("analyses.poincare.surface.level", Length, ANY, r#""10 um""#).or("0")
        .about("Value of the combination on the surface."),
    choice("analyses.poincare.surface.direction", &["both", "rising", "falling"], r#""rising""#).or(r#""both""#)
        .about("Crossings to count: all, or only crossings with a rising or a falling combination."),
    quantity("analyses.poincare.phase", Ratio, bounds(0.0, false, 1.0, true), "0.25").or("0")
        .about("Mesh phase of the strobe, in cycles. Only with section = \"strobe\"."),
    integer("analyses.poincare.refine", 0.0, 50.0, "6").or("0")
        .about("Number of halvings of the interval between neighbours with different motion, to locate the change. \
                Only if `grid.order` carries the state."),
    table("analyses.nvh").otherwise(ABSENT)
        .about("Statistics of noise, vibration and harshness (NVH): deflection, mesh force, contact."),
    integer("analyses.nvh.harmonics", 0.0, 1000.0, "5").or("10")
        .about("Number of harmonics of the mesh frequency whose deflection amplitudes are kept."),
    quantity("analyses.nvh.stop_at_stderr", Ratio, bounds(0.0, true, 1.0, true), "0.02")
        .otherwise("none: statistics run as long as the point is measured")
        .about("Relative standard error at which NVH statistics stop, for a motion that does not repeat. Fractions of \
                time are relative to 1. Means are relative to the root mean square of their signal. Orders and \
                spectral lines are relative to a sine with the root mean square of their signal. Powers of the \
                balance are relative to the largest one. Other averages are relative to their value. Without \
                `analyses.lyapunov` the point then ends. With `analyses.lyapunov.stop_at_stderr` it ends when both \
                errors are small enough."),
    table("analyses.nvh.spectrum").otherwise("no spectra")
        .about("Spectra (spectra.parquet): exact lines of a motion that repeats, averaged power of any other motion."),
    key("analyses.nvh.spectrum.signals", Kind::List("signals"), ANY, r#"["force", "bearings"]"#).or(r#"["deflection", "force"]"#)
        .about("Signals whose spectra are computed: mesh deflection, mesh force, bearing forces, torques in shafts \
                and couplings, accelerations at bearings and of rotating bodies, or deflection and force of every mesh."),
    choice("analyses.nvh.spectrum.signals.*", SIGNALS, r#""bearings""#),
    integer("analyses.nvh.spectrum.highest_order", 1.0, 100.0, "32").or("10")
        .about("Highest multiple of the mesh frequency in the spectra."),
    integer("analyses.nvh.spectrum.resolution", 8.0, 1024.0, "64").or("32")
        .about("Smallest number of spectral lines per mesh order for a motion that does not repeat. It equals the \
                mesh cycles per segment. A segment is lengthened to whole periods of the excitation if it becomes at \
                most four times as long. Shaft orders then lie on lines."),
    table("analyses.nvh.orders").otherwise("no orders")
        .about("Amplitude and phase at multiples of the frequency of every mesh and of the speed of every shaft (orders.parquet)."),
    key("analyses.nvh.orders.signals", Kind::List("signals"), ANY, r#"["bearings", "torques"]"#).or(r#"["deflection", "force"]"#)
        .about("Signals whose orders are computed. The same signals as for spectra are available."),
    choice("analyses.nvh.orders.signals.*", SIGNALS, r#""torques""#),
    integer("analyses.nvh.orders.mesh", 0.0, 1000.0, "5").or("10")
        .about("Highest multiple of the frequency of each mesh; all multiples from 1 on are computed."),
    integer("analyses.nvh.orders.shafts", 0.0, 1000.0, "8").or("4")
        .about("Highest multiple of the speed of each shaft. Multiples beside that of the mesh are its sidebands. Averages run \
                over whole revolutions that are whole mesh cycles."),
    key("analyses.nvh.bearings", Kind::Boolean, ANY, "true").or("false")
        .about("Compute the mean and RMS of the bearing forces."),
    key("analyses.nvh.torques", Kind::Boolean, ANY, "true").or("false")
        .about("Compute the mean and RMS of the torques in flexible shafts and couplings."),
    key("analyses.nvh.accelerations", Kind::Boolean, ANY, "true").or("false")
        .about("Compute the RMS of accelerations at bearings and of angular accelerations of shafts."),
    key("analyses.nvh.meshes", Kind::Boolean, ANY, "true").or("false")
        .about("Compute the RMS of the deflection and of the force of every mesh."),
    key("analyses.nvh.power", Kind::Boolean, ANY, "true").or("false")
        .about("Compute the power balance of the vibration. Loads, transmission error and varying stiffness feed \
                power in. Contact damping, structural damping and friction take power out."),
    table("analyses.multistability").otherwise(ABSENT)
        .about("Find the motions that coexist, and the share of each, with probes from many initial states."),
    integer("analyses.multistability.initial_conditions", 1.0, 1e6, "64").or("32")
        .about("Number of probes per point. The first starts from `run.initial`."),
    quantity("analyses.multistability.decades", Ratio, bounds(0.0, false, 12.0, false), "8").or("4")
        .about("Range of energy of the other probes, in decades, centred on the energy that closes the half gap."),
    integer("analyses.multistability.transient", 0.0, LARGEST_COUNT, "2000").otherwise("`run.transient`")
        .about("Mesh cycles of each probe that are discarded."),
    integer("analyses.multistability.cycles", FEWEST_CYCLES as f64, LARGEST_COUNT, "2000").otherwise("`run.cycles`, limited to 320 to 4000")
        .about("Largest number of mesh cycles measured per probe."),
    table("analyses.multistability.slice").otherwise("no slice")
        .about("A plane of initial states through `run.initial`, for pictures of basins of attraction. Two modes span \
                it, or the displacement and velocity of one mode."),
    key("analyses.multistability.slice.modes", Kind::List("2 integers: modes, counted from 1"), ANY, "[3, 7]").of_length(2)
        .otherwise("none; required without `mode`")
        .about("The two modes that span the plane. They must differ, be retained, and deflect the mesh."),
    integer("analyses.multistability.slice.modes.*", 1.0, 1000.0, "3"),
    integer("analyses.multistability.slice.mode", 1.0, 1000.0, "1").otherwise("none; required without `modes`")
        .about("One mode whose displacement and velocity span the plane (x, v), instead of `modes`. The horizontal \
                axis is its mesh deflection, the vertical axis its rate of mesh deflection."),
    quantity("analyses.multistability.slice.speed", Velocity, POSITIVE, r#""0.1 m/s""#)
        .otherwise("`extent`, multiplied by the mode's scale in the energy norm")
        .about("Half the height of the plane (x, v), as rate of mesh deflection. Only with `mode`."),
    choice("analyses.multistability.slice.of", &["displacement", "velocity"], r#""velocity""#).or(r#""displacement""#)
        .about("Modal coordinates that vary: displacements or velocities. Only with `modes`."),
    quantity("analyses.multistability.slice.extent", Length, POSITIVE, r#""30 um""#)
        .about("Half the side of the plane, as the mesh deflection of one mode alone."),
    integer("analyses.multistability.slice.count", 1.0, 512.0, "96").or("48")
        .about("Number of cells along each side. The number of initial states is its square."),
    table("analyses.orbits").otherwise(ABSENT)
        .about("Periodic orbits, stable or not. Newton's method seeks them from close returns of the motion and from \
                given states."),
    key("analyses.orbits.periods", Kind::List("whole numbers from 1 to 64: mesh cycles"), ANY, "[1, 2, 4]").or("[1, 2]")
        .about("Periods to seek, in mesh cycles. The base period is the period of the excitation. If a tooth of a gear \
                with 20 teeth has a fault, the base period is 20 mesh cycles. A period that is not a multiple of the \
                base period counts base periods: 2 then seeks orbits of 40 mesh cycles."),
    integer("analyses.orbits.periods.*", 1.0, 64.0, "2"),
    integer("analyses.orbits.guesses", 1.0, 10_000.0, "32").or("16")
        .about("Number of Newton searches per period."),
    integer("analyses.orbits.cycles", 1.0, 1e6, "1000").or("400")
        .about("Mesh cycles of motion that supply the first guesses."),
    key("analyses.orbits.floquet", Kind::Boolean, ANY, "false").or("true")
        .about("Keep all Floquet multipliers, in addition to the stability."),
    integer("analyses.orbits.returns", 1.0, 1000.0, "20").or("10")
        .about("Number of returns to each orbit over which a small kick is followed. The kick is 1e-5 half gaps in \
                the direction of strongest growth."),
    key("analyses.orbits.states", Kind::List("tables"), ANY, "[{ displacement = [0.0, 1e-6], velocity = [0.0, 1e-3] }]").or("[]")
        .about("Further initial states of the search for every period, each a modal state as in `run.initial`. If a \
                state leads to no orbit, its row in orbits.parquet gives the reason."),
    table("analyses.orbits.states.*"),
    key("analyses.orbits.states.*.displacement", Kind::List("numbers in m sqrt(kg), one per retained mode"), ANY, "[0.0, 1e-6]")
        .about("Mass-normalised modal displacements, one per retained mode in ascending frequency."),
    quantity("analyses.orbits.states.*.displacement.*", ModalDisplacement, ANY, "1e-6"),
    key("analyses.orbits.states.*.velocity", Kind::List("numbers in m sqrt(kg)/s, one per retained mode"), ANY, "[0.0, 1e-3]")
        .about("Mass-normalised modal velocities, one per retained mode in ascending frequency."),
    quantity("analyses.orbits.states.*.velocity.*", ModalVelocity, ANY, "1e-3"),
    table("analyses.horizon").otherwise(ABSENT)
        .about("Prediction horizon of chaotic motion, and convergence of averages. Needs `analyses.lyapunov`."),
    integer("analyses.horizon.twins", 2.0, 10_000.0, "32").or("16")
        .about("Number of pairs of neighbouring trajectories to follow."),
    quantity("analyses.horizon.separation", Ratio, bounds(1e-12, false, 0.1, false), "1e-8").or("1e-6")
        .about("Initial distance of each pair, in half gaps."),
    integer("analyses.horizon.cycles", 1.0, 100_000.0, "100").or("60")
        .about("Mesh cycles over which each pair is followed."),
    integer("analyses.horizon.averages", 1.0, 1e6, "1000").or("400")
        .about("Mesh cycles in the longest averages."),
    table("analyses.covariant").otherwise(ABSENT)
        .about("Covariant Lyapunov vectors of motion that does not repeat: local exponents, and the angle between \
                growing and shrinking directions. Needs `analyses.lyapunov`."),
    integer("analyses.covariant.vectors", 1.0, 2000.0, "4").or("2")
        .about("Number of vectors, from the largest exponent on. The limit is twice the number of retained modes that \
                are not neutral, plus one if drag damps the neutral rotation."),
    integer("analyses.covariant.cycles", FEWEST_CYCLES as f64, LARGEST_COUNT, "5000").or("1000")
        .about("Mesh cycles measured. With v vectors, each cycle keeps v(v + 1)/2 numbers in memory; the limit is 1 GiB in total."),
    integer("analyses.covariant.align", 1.0, LARGEST_COUNT, "500").or("200")
        .about("Mesh cycles discarded at each end while the vectors align with the Lyapunov directions."),
];
