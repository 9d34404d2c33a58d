//! `[run]`.

use crate::manifest::schema::key::{ANY, Key, Kind, MANY, choice, integer, key, quantity, table};
use crate::units::Dimension::{ModalDisplacement, ModalVelocity};

#[rustfmt::skip]
pub(super) const KEYS: &[Key] = &[
    table("run").otherwise("the defaults of its keys")
        .about("How long a point is computed, with which kernel, and from which state."),
    integer("run.transient", 0.0, MANY, "500").or("200")
        .about("Mesh cycles discarded before anything is measured, of a motion that finds no periodic orbit."),
    integer("run.cycles", 1.0, MANY, "100000").otherwise("160000, or 40000 where no analysis has a `stop_at_stderr`")
        .about("Most mesh cycles measured, of all trajectories of a point together. A point stops earlier once its answers \
                are settled."),
    choice("run.kernel", &["volterra", "closed_modes", "stepping", "auto"], r#""stepping""#)
        .or(r#""auto""#)
        .about("How the motion is computed. `auto` takes, at each point by its own drive, `closed_modes` where that takes the drive and is faster, else \
                `volterra`; `atlas check` and `kernels` in `run.json` say which and why. \
                `volterra` is exact to round-off and takes every drive. `closed_modes` is as exact and faster up to some \
                twenty modes, and with many contacts; it makes the eigenvectors of each set of closed \
                contacts once for all loads and, without gyroscopic terms, speeds, keeps those of few sets in `tables/`, and takes constant levels of stiffness. `stepping` takes fixed steps."),
    integer("run.steps", 16.0, 1e6, "8192").or("4096").because("each is kept: 60 bytes of every point at work")
        .about("Steps a mesh cycle of `stepping`, which sets its accuracy. Only with that kernel."),
    choice("run.instructions", &["auto", "portable"], r#""portable""#).or(r#""auto""#)
        .about("Whether the processor's widest instructions are used, or only those that every x86-64 processor \
                has, for the same bits everywhere. `portable` is slower and takes `volterra`, `stepping` or `auto`."),
    key("run.initial", Kind::Initial, ANY, r#""rest""#).or(r#""static""#)
        .about("Where the state starts: `static` equilibrium under the mean load, in contact; `rest`, all modal \
                coordinates 0; or a table with a modal state."),
    key("run.initial.displacement", Kind::List("numbers in m sqrt(kg), one a retained mode"), ANY, "[0.0, 1e-6]")
        .about("Modal displacements at the start, mass-normalised, one a retained mode in ascending frequency."),
    quantity("run.initial.displacement.*", ModalDisplacement, ANY, "1e-6"),
    key("run.initial.velocity", Kind::List("numbers in m sqrt(kg)/s, one a retained mode"), ANY, "[0.0, 1e-3]")
        .about("Modal velocities at the start, mass-normalised, one a retained mode in ascending frequency."),
    quantity("run.initial.velocity.*", ModalVelocity, ANY, "1e-3"),
    key("run.settle", Kind::Boolean, ANY, "false").or("true")
        .about("Whether an attracting periodic orbit is sought by Newton's method instead of waiting until the \
                motion has decayed to it. It saves most cycles of periodic points."),
    integer("run.audit_cycles", 0.0, MANY, "50").otherwise("20, or `run.cycles` where that is less")
        .about("Mesh cycles over which the balance of energy is checked; 0 for no check. At most `run.cycles`."),
    integer("run.event_limit", 1.0, MANY, "5000").or("1000")
        .about("Most events in one mesh cycle; a point with more ends with status `event_storm`."),
];
