//! The keys of the table `[run]`.

use crate::manifest::schema::key::{
    ANY, Key, Kind, LARGEST_COUNT, choice, integer, key, quantity, table,
};
use crate::units::Dimension::{ModalDisplacement, ModalVelocity};

#[rustfmt::skip]
pub(super) const KEYS: &[Key] = &[
    table("run").otherwise("the defaults of its keys")
        .about("Number of mesh cycles, kernel and initial state of each point."),
    integer("run.transient", 0.0, LARGEST_COUNT, "500").or("200")
        .about("Mesh cycles discarded before measuring if no periodic orbit is found."),
    integer("run.cycles", 1.0, LARGEST_COUNT, "100000").otherwise("160000, or 40000 if no analysis has a `stop_at_stderr`")
        .about("Largest number of mesh cycles measured per point, over all its trajectories. A point stops earlier if \
                its results have settled."),
    choice("run.kernel", &["volterra", "closed_modes", "stepping", "auto"], r#""stepping""#)
        .or(r#""auto""#)
        .about("Kernel that computes the motion. `auto` takes `closed_modes` for each point if this kernel accepts \
                the drive and is faster, otherwise `volterra`. `atlas check` and `kernels` in `run.json` report the \
                kernel and the reason. `volterra` is exact to round-off and accepts every drive. `closed_modes` is as \
                exact. It is faster up to about twenty modes and with many contacts. It requires a piecewise constant \
                stiffness. It computes the eigenvectors of each set of closed contacts once for all loads and, \
                without gyroscopic terms, all speeds. If the sets are few, `tables/` keeps them. `stepping` takes \
                fixed steps."),
    integer("run.steps", 16.0, 1e6, "8192").or("4096").because("every point being computed needs 60 bytes of memory per step")
        .about("Number of steps per mesh cycle with kernel = \"stepping\". More steps make the result more accurate. \
                Only with this kernel."),
    choice("run.instructions", &["auto", "portable"], r#""portable""#).or(r#""auto""#)
        .about("Instruction set. `auto`: the widest vector instructions of the processor. `portable`: only the \
                instructions of every x86-64 processor, for the same bits on every machine. `portable` is slower. It \
                allows the kernels `volterra`, `stepping` and `auto`."),
    key("run.initial", Kind::InitialState, ANY, r#""rest""#).or(r#""static""#)
        .about("Initial state. `static`: static equilibrium under the mean load, in contact. `rest`: all modal \
                coordinates 0. A table gives a modal state."),
    key("run.initial.displacement", Kind::List("numbers in m sqrt(kg), one per retained mode"), ANY, "[0.0, 1e-6]")
        .about("Initial mass-normalised modal displacements, one per retained mode in ascending frequency."),
    quantity("run.initial.displacement.*", ModalDisplacement, ANY, "1e-6"),
    key("run.initial.velocity", Kind::List("numbers in m sqrt(kg)/s, one per retained mode"), ANY, "[0.0, 1e-3]")
        .about("Initial mass-normalised modal velocities, one per retained mode in ascending frequency."),
    quantity("run.initial.velocity.*", ModalVelocity, ANY, "1e-3"),
    key("run.settle", Kind::Boolean, ANY, "false").or("true")
        .about("Seek an attracting periodic orbit by Newton's method instead of waiting for the motion to decay to \
                it. This saves most cycles of periodic points."),
    integer("run.audit_cycles", 0.0, LARGEST_COUNT, "50").otherwise("20, or `run.cycles` if that is less")
        .about("Mesh cycles over which the energy balance is checked, at most `run.cycles`. 0 disables the check."),
    integer("run.event_limit", 1.0, LARGEST_COUNT, "5000").or("1000")
        .about("Largest number of events in one mesh cycle. A point with more events ends with status `event_storm`."),
];
