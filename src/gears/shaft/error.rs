//! What can go wrong between the description of a structure and its modes?

use crate::structure::ModeCount;

/// Why a structure could not be assembled, solved or reduced.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ShaftError {
    /// The drawing of the gears is not a pair that meshes.
    #[error(transparent)]
    Gear(#[from] crate::gear::GearError),
    /// Shafts, gears and couplings do not form a train.
    #[error(transparent)]
    Train(#[from] super::train::TrainError),
    /// A quantity that must be finite is not.
    #[error("{quantity} is {value}, but must be finite")]
    NotFinite {
        /// Name of the quantity, with its unit.
        quantity: &'static str,
        /// The value found.
        value: f64,
    },
    /// A hollow section without a wall.
    #[error("bore {bore} m leaves no wall in a section of {diameter} m; make the bore smaller")]
    NoWall {
        /// Bore \[m\].
        bore: f64,
        /// Outer diameter \[m\].
        diameter: f64,
    },
    /// The gear lies outside its span.
    #[error(
        "the gear of shaft {shaft} is at {position} of its span; it must be strictly between 0 and 1"
    )]
    GearPosition {
        /// 1 = pinion, 2 = wheel.
        shaft: usize,
        /// Fraction of the span.
        position: f64,
    },
    /// A stretch of shaft without elements.
    #[error(
        "{stretch} has no beam element; give it at least one (more elements make the highest modes more accurate)"
    )]
    NoElement {
        /// Name of the stretch.
        stretch: &'static str,
    },
    /// A shaft is free to move as a rigid body other than by rotating about its axis.
    #[error(
        "shaft {shaft} is not held {direction}: give one of its bearings a stiffness there (only the rotation about the axis may be free)"
    )]
    NotHeld {
        /// 1 = pinion, 2 = wheel.
        shaft: usize,
        /// The free motion.
        direction: &'static str,
    },
    /// Rolling elements that do not fit next to each other.
    #[error(
        "{count} rolling elements of {diameter} m touch: on their pitch circle neighbours are {room:.6e} m apart; correct \
         their number, their diameter or the pitch diameter"
    )]
    ElementsTouch {
        /// Number of rolling elements.
        count: u32,
        /// Diameter of the rolling elements \[m\].
        diameter: f64,
        /// Distance of the centres of neighbours \[m\].
        room: f64,
    },
    /// A groove with a radius below that of its ball.
    #[error(
        "the groove of a ball bearing has {conformity} ball diameters as its radius, but must be wider than the ball: \
         between 0.5 and 1; usual values are 0.52 and 0.53"
    )]
    NoGroove {
        /// Radius of the groove over the ball's diameter.
        conformity: f64,
    },
    /// The tier has pedestals, but they are not described.
    #[error(
        "kind = \"pedestal\" needs a pedestal for each of the four bearings; give shafts.pedestals"
    )]
    NoPedestals,
    /// An assembly call with the index of a node that does not exist.
    #[error("node {node} does not exist; the assembly has {nodes} nodes, counted from 0")]
    NoSuchNode {
        /// The index given.
        node: usize,
        /// Nodes present.
        nodes: usize,
    },
    /// A degree of freedom was tied to one that is not free (fixed, tied or carried), or to itself.
    #[error(
        "node {node} has a degree of freedom tied to node {master}, where that degree of freedom is itself tied; tie it to a free one"
    )]
    TiedToBound {
        /// Node of the tied degree of freedom.
        node: usize,
        /// Node of its master.
        master: usize,
    },
    /// Mass and stiffness are not square matrices of equal size.
    #[error(
        "mass ({mass_rows} x {mass_columns}) and stiffness ({stiffness_rows} x {stiffness_columns}) must be square and of one size"
    )]
    Shape {
        /// Rows of the mass matrix.
        mass_rows: usize,
        /// Columns of the mass matrix.
        mass_columns: usize,
        /// Rows of the stiffness matrix.
        stiffness_rows: usize,
        /// Columns of the stiffness matrix.
        stiffness_columns: usize,
    },
    /// An entry of a matrix is infinite or not a number.
    #[error(
        "the {matrix} matrix has a non-finite entry in row {row}, column {column}; check the inputs for infinities"
    )]
    NonFinite {
        /// `mass` or `stiffness`.
        matrix: &'static str,
        /// Row, from 0.
        row: usize,
        /// Column, from 0.
        column: usize,
    },
    /// A matrix that must be symmetric is not.
    #[error(
        "the {matrix} matrix is not symmetric: row {row}, column {column} is {}, but its mirror image is {}",
        entries[0], entries[1]
    )]
    Asymmetric {
        /// `mass` or `stiffness`.
        matrix: &'static str,
        /// Row below the diagonal, from 0.
        row: usize,
        /// Column, from 0.
        column: usize,
        /// The entry at this position and its mirror image above the diagonal.
        entries: [f64; 2],
    },
    /// The mass matrix is not positive definite.
    #[error(
        "the mass matrix is not positive definite: a degree of freedom has no inertia; give it inertia or constrain it"
    )]
    MassNotPositiveDefinite,
    /// The diameters of the parts of a gear body do not increase outwards.
    #[error(
        "gear {gear}: the diameter of {outside} is {outer_diameter} m, but must be greater than the diameter of \
         {inside}, {inner_diameter} m; correct gear.hub_diameter or gear.rim_diameter"
    )]
    BodyParts {
        /// 1 = pinion, 2 = wheel.
        gear: usize,
        /// The inner part.
        inside: &'static str,
        /// Its diameter \[m\].
        inner_diameter: f64,
        /// The part that must be outside of it.
        outside: &'static str,
        /// Its diameter \[m\].
        outer_diameter: f64,
    },
    /// A hub reaches beyond the bearings of its shaft.
    #[error(
        "shaft {shaft}: the hub is {length} m long, but the space from gear to bearing is {room} m; \
         shorten gear.hub_length (or gear.body_length, its default)"
    )]
    HubBeyondBearings {
        /// 1 = pinion, 2 = wheel.
        shaft: usize,
        /// Length of the hub \[m\].
        length: f64,
        /// Largest length that fits \[m\].
        room: f64,
    },
    /// The stiffness matrix has a negative eigenvalue beyond round-off.
    #[error(
        "the stiffness matrix has the negative eigenvalue {eigenvalue} rad²/s²; check for a negative spring stiffness"
    )]
    StiffnessIndefinite {
        /// The eigenvalue \[rad²/s²\].
        eigenvalue: f64,
    },
    /// The number of rigid-body modes is not the expected one.
    #[error(
        "the structure has {found} rigid-body modes, but {expected} are expected; check bearings and constraints"
    )]
    RigidModes {
        /// Number according to the supports.
        expected: usize,
        /// Number of eigenvalues that are zero within round-off.
        found: usize,
    },
    /// The number of requested modes is below the least or above the available number.
    #[error(transparent)]
    ModeCount(#[from] ModeCount),
    /// A damping override whose mode is not elastic.
    #[error(
        "the damping of mode {mode} cannot be overridden: only modes {first} to {last} are elastic and computed (counted from 1)"
    )]
    DampingOverride {
        /// Requested mode, from 1.
        mode: usize,
        /// First elastic mode, from 1.
        first: usize,
        /// Last computed mode, from 1.
        last: usize,
    },
    /// A modal damping ratio outside `[0, 1)`.
    #[error("the modal damping ratio is {ratio}, but must be at least 0 and less than 1")]
    DampingRatio {
        /// The ratio.
        ratio: f64,
    },
    /// The eigensolver did not converge.
    #[error("the symmetric eigensolver did not converge on {size} degrees of freedom")]
    NoConvergence {
        /// Order of the problem.
        size: usize,
    },
    /// The static deflection beyond the computed modes did not converge.
    #[error(
        "the iteration for the deflection of the bearings beyond the {modes} computed modes did not converge; compute \
         more modes"
    )]
    NoStaticShape {
        /// Modes computed.
        modes: usize,
    },
    /// A computed mode does not satisfy its equation.
    #[error(
        "mode {mode} of {size} degrees of freedom violates its equation by {residual:.1e} of its terms, which is more \
         than round-off: the eigensolver failed; use fewer elements or fewer modes"
    )]
    Residual {
        /// Mode, from 1.
        mode: usize,
        /// Order of the problem.
        size: usize,
        /// Norm of `K φ − ω² M φ` over that of its terms' moduli, rows scaled by inertia.
        residual: f64,
    },
}

/// `value` if it is finite.
pub(super) fn finite(quantity: &'static str, value: f64) -> Result<f64, ShaftError> {
    if value.is_finite() {
        Ok(value)
    } else {
        Err(ShaftError::NotFinite { quantity, value })
    }
}
