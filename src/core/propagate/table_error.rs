//! Why can a kernel with tables not be used for a model, and how large are its tables?

/// Reasons why a model has no tables, or why kept tables do not fit it.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum TableError {
    /// The flanks have a transmission error under load, and tables cannot represent it exactly.
    #[error(
        "kernels with tables cannot follow the exact error of the loaded flanks; set run.kernel = \"volterra\", or \
         set excitation.table_harmonics to a number of harmonics (0 omits the error)"
    )]
    FlankError,
    /// Stiffness varies within a segment.
    #[error(
        "the mesh stiffness varies within its segments, which tables of matrix exponentials cannot \
         follow; set `stiffness = \"piecewise\"`"
    )]
    VaryingStiffness,
    /// The eigenvectors of a segment are too nearly parallel.
    #[error(
        "the eigenvectors of a mesh segment are nearly parallel: a propagator rebuilt from them is off by {error:.1e} \
         of its largest entry, but at most 1e-11 is allowed (condition number {condition:.1e}); the contact may be \
         critically damped"
    )]
    Defective {
        /// Condition number of their basis.
        condition: f64,
        /// Error of a propagator rebuilt from them, relative to its largest entry.
        error: f64,
    },
    /// An undamped mode in resonance with a harmonic.
    #[error(
        "an undamped mode is in resonance with the harmonic at {frequency:.6e} rad/s; raise the damping ratio of this \
         mode above 0"
    )]
    Resonance {
        /// Angular frequency of the harmonic \[rad/s\].
        frequency: f64,
    },
    /// Contacts open when their force vanishes.
    #[error(
        "tables cannot represent contacts that open when their force vanishes; set mesh.release = \"deflection\" or \
         run.kernel = \"volterra\""
    )]
    Release,
    /// Dry sliders.
    #[error(
        "the kernels closed_modes and stepping cannot follow the sliders of dry hysteresis; set run.kernel = \"volterra\""
    )]
    Slider,
    /// Rigid stops.
    #[error(
        "the kernels closed_modes and stepping cannot follow rigid stops; set run.kernel = \"volterra\", or give \
         contact.*.stiffness in place of contact.*.restitution"
    )]
    RigidStop,
    /// Dry friction that sticks.
    #[error(
        "the kernels closed_modes and stepping cannot follow dry friction; set run.kernel = \"volterra\""
    )]
    DryFriction,
    /// A negative stiffness.
    #[error(
        "the kernels closed_modes and stepping cannot follow contacts with a negative stiffness; set run.kernel = \"volterra\""
    )]
    Softening,
    /// A film of oil.
    #[error(
        "the kernels closed_modes and stepping cannot follow a film of oil; set run.kernel = \"volterra\", or remove \
         mesh.film"
    )]
    Film,
    /// Kept tables belong to another model.
    #[error(
        "the kept tables have no array `{name}` that fits this model; delete the folder `tables/`, and the next run \
         computes them again"
    )]
    Kept {
        /// The array.
        name: &'static str,
    },
    /// Too many contacts, or too many systems to number them.
    #[error(
        "{contacts} contacts may be closed in too many ways: tables take at most {most} contacts, with few levels of \
         stiffness; set run.kernel = \"volterra\""
    )]
    TooManySets {
        /// Contacts of the drive.
        contacts: usize,
        /// Largest number of contacts.
        most: usize,
    },
    /// Tables would exceed the limit of size.
    #[error(
        "the tables of the {} sets of closed contacts need {:.0} MB, but at most {:.0} MB are kept; keep fewer modes \
         or fewer levels of stiffness",
        size.systems, megabytes(size.bytes), megabytes(*most)
    )]
    TooLarge {
        /// The required size.
        size: TableSize,
        /// The limit \[bytes\].
        most: usize,
    },
}

impl TableError {
    /// Whether the model itself is the reason, so that another kernel may be used.
    pub fn concerns_the_model(&self) -> bool {
        !matches!(self, Self::Kept { .. })
    }

    /// The cause: the message up to its first colon or semicolon, without remedy.
    pub fn cause(&self) -> String {
        let text = self.to_string();
        text.split([':', ';']).next().unwrap_or_default().to_owned()
    }
}

/// Bytes in megabytes.
pub fn megabytes(bytes: usize) -> f64 {
    1e-6 * bytes as f64
}

/// Size of a kernel's tables.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TableSize {
    /// Linear systems that have tables.
    pub systems: usize,
    /// Size of all tables \[bytes\].
    pub bytes: usize,
}
