//! What can be wrong with a train as a whole?

/// Why shafts, gears and couplings do not form a train.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TrainError {
    /// Two axes that are neither parallel nor intersect.
    #[error(
        "gears `{}` and `{}` cannot mesh: their axes are skew, {distance:.3e} m apart; axes must be \
         parallel (spur gears) or intersect (bevel gears)",
        gears[0], gears[1]
    )]
    SkewAxes {
        /// The gears.
        gears: [String; 2],
        /// Distance of the axes \[m\].
        distance: f64,
    },
    /// Two gears on one axis.
    #[error("gears `{}` and `{}` cannot mesh, because they are on the same axis; put one of them on another axis", gears[0], gears[1])]
    OneAxis {
        /// The gears.
        gears: [String; 2],
    },
    /// Internal teeth that no gear can mesh with.
    #[error(
        "gears `{}` and `{}` cannot mesh: one of the two may be internal, on a parallel axis and with more teeth than \
         the other",
        gears[0], gears[1]
    )]
    NotInside {
        /// The gears.
        gears: [String; 2],
    },
    /// Planets that cannot be assembled.
    #[error(
        "`{planet}` does not fit between the teeth at {angle:.6} degrees from `{first}`: with {} and {} teeth of \
         the central gears, planets fit at whole multiples of 360/{} degrees; move it to {nearest:.6} degrees, or \
         change a number of teeth",
        teeth[0], teeth[1], teeth[0] + teeth[1]
    )]
    Assembly {
        /// The planet.
        planet: String,
        /// The first planet of its set.
        first: String,
        /// Its angle \[degrees\].
        angle: f64,
        /// Teeth of the external and of the internal central gear.
        teeth: [u32; 2],
        /// The nearest possible angle \[degrees\].
        nearest: f64,
    },
    /// Planets that touch each other.
    #[error(
        "planets `{}` and `{}` touch: their axes are {apart:.6e} m apart, but their tip diameter is {tip:.6e} m; use \
         fewer planets, or change the numbers of teeth",
        planets[0], planets[1]
    )]
    PlanetsTouch {
        /// The planets.
        planets: [String; 2],
        /// Distance of their axes \[m\].
        apart: f64,
        /// Their tip diameter \[m\].
        tip: f64,
    },
    /// A part that is not on the axis of a planetary set.
    #[error(
        "`{what}` is not on the axis of the carrier `{carrier}`: carrier, sun, ring, and what couplings join to them across \
         the axis, have this axis and direction"
    )]
    OffCentre {
        /// The part.
        what: String,
        /// The shaft of the pins.
        carrier: String,
    },
    /// A bearing that is not isotropic in the rotating frame of the carrier.
    #[error(
        "{bearing} is not the same in all directions, or has dampers, rolling elements or \
         cross-coupled springs, but the model turns with the carrier `{carrier}`; give it equal x and y alone, or hold the \
         carrier"
    )]
    UnequalBearing {
        /// The bearing.
        bearing: String,
        /// The shaft of the pins.
        carrier: String,
    },
    /// A stop across the axis in the rotating frame of the carrier.
    #[error(
        "the stop of shaft `{shaft}` acts across the axis, but the model turns with the carrier `{carrier}`, where this stop \
         would turn; give it the direction [0, 0, 1] or [0, 0, -1], remove it, or hold the carrier"
    )]
    StopAcross {
        /// The shaft.
        shaft: String,
        /// The shaft of the pins.
        carrier: String,
    },
    /// A mesh without a planet on a shaft in a rotating frame.
    #[error(
        "gear `{gear}` meshes with no planet, but its shaft `{shaft}` moves with planets, whose frame turns with the \
         carrier; give the gear a shaft of its own, and join both shafts by a [[train.coupling]] with `twist` (and \
         `axial`) alone"
    )]
    GearBesidePlanets {
        /// The gear.
        gear: String,
        /// Its shaft.
        shaft: String,
    },
    /// The first mesh has no planet.
    #[error(
        "`{}` and `{}` are the first mesh, but neither is a planet: name the sun and a planet in `train.gears`, and these \
         two in a [[train.mesh]]",
        gears[0], gears[1]
    )]
    FirstOfPlanets {
        /// The gears.
        gears: [String; 2],
    },
    /// The mean load pushes the shafts out of their rolling bearings.
    #[error(
        "the bearings do not hold the train under {load} of its rated load: the inner ring of bearing `{bearing}` moves by \
         {:.3e}, {:.3e}, {:.3e} m (x, y, axial) without equilibrium; give another bearing of the shaft a contact angle of \
         the other sign, or a spring `axial` or `tilt`",
        moved[0], moved[1], moved[2]
    )]
    BearingsGiveWay {
        /// The bearing with the largest motion.
        bearing: String,
        /// Displacement of its inner ring in the last step \[m, rad\].
        moved: [f64; 5],
        /// Load as a fraction of the rated one.
        load: f64,
    },
    /// A thrust in the direction in which a bearing with a contact angle cannot carry it.
    #[error(
        "bearing `{bearing}` has a thrust of {thrust:.3e} N along its shaft, but with a contact angle of {angle:.4} degrees \
         it bears only thrust of the other sign; change the sign of its contact angle, or give another bearing the thrust"
    )]
    AgainstAngle {
        /// The bearing.
        bearing: String,
        /// Axial load of the shaft on it \[N\].
        thrust: f64,
        /// Its contact angle \[degrees\].
        angle: f64,
    },
    /// A shaft that is free within the clearance of its rolling bearings.
    #[error(
        "shaft `{shaft}` is not held {direction}: under {load} of the rated load its rolling bearings bear nothing there \
         (largest radial clearance {clearance:.3e} m); raise train.bearing_load, reduce the clearance, or give a bearing a \
         spring `axial` or `tilt`"
    )]
    HeldByNoElement {
        /// The shaft.
        shaft: String,
        /// The free motion.
        direction: &'static str,
        /// Load as a fraction of the rated one.
        load: f64,
        /// Largest clearance of its bearings \[m\].
        clearance: f64,
    },
    /// Two sets that would share one frame at different speeds.
    #[error(
        "{what} moves across the axis with the sets of the carriers `{}` and `{}`, which turn at different speeds: its \
         forces there would turn in one of their frames; give each set shafts of its own, and join them by a \
         [[train.coupling]] with `twist` (and `axial`) alone",
        carriers[0], carriers[1]
    )]
    TwoFrames {
        /// The part that joins them.
        what: String,
        /// The shafts of the pins.
        carriers: [String; 2],
    },
    /// A carrier that is a planet of another one.
    #[error(
        "the carrier `{planet}` is one of the planets, and planets carry no planets; name the shaft of a carrier, a sun or a \
         ring, or one that is coupled to it"
    )]
    CarrierIsPlanet {
        /// The planet.
        planet: String,
    },
    /// A mesh of two planets.
    #[error(
        "`{}` and `{}` are planets: planets mesh with gears on the axis of their carrier alone; name such a gear, and join \
         two sets by a [[train.coupling]]",
        gears[0], gears[1]
    )]
    PlanetsMesh {
        /// The planets.
        gears: [String; 2],
    },
    /// Members of planetary sets whose speeds do not follow from that of the driver.
    #[error(
        "the train can turn in two ways: the speeds of {free} do not follow from that of the driver `{driver}`; hold one \
         member of their planetary set, the ring, the sun or the carrier: give its shaft motion = \"lateral\" or \
         \"none\", or couple it to a shaft that is held"
    )]
    NothingHeld {
        /// The members.
        free: String,
        /// The driving shaft.
        driver: String,
    },
    /// Gears that rotate as one body.
    #[error(
        "gears `{}` and `{}` do not roll on each other: their shafts and the carrier turn at one speed, or stand still; \
         check what is held, and what couplings join",
        gears[0], gears[1]
    )]
    NotRolling {
        /// The gears.
        gears: [String; 2],
    },
    /// More than one held member, which locks the set.
    #[error("`{}` and `{}` are both held, so the planetary set cannot turn; release one of them", held[0], held[1])]
    AllHeld {
        /// The members.
        held: [String; 2],
    },
    /// Bevel gears whose pitch circles do not touch.
    #[error(
        "gears `{}` and `{}` cannot mesh: their pitch circles are at least {apart:.3e} m apart; move one \
         along its axis, or change a number of teeth",
        gears[0], gears[1]
    )]
    PitchCircles {
        /// The gears.
        gears: [String; 2],
        /// Their distance \[m\].
        apart: f64,
    },
    /// Spur gears side by side whose faces do not overlap.
    #[error(
        "gears `{}` and `{}` cannot mesh: their faces are {gap:.3e} m apart along the axis; move one along its shaft",
        gears[0], gears[1]
    )]
    FacesApart {
        /// The gears.
        gears: [String; 2],
        /// Gap between them \[m\].
        gap: f64,
    },
    /// More finite elements than allowed.
    #[error(
        "section {} of shaft `{shaft}` needs {elements_of_section:.3e} beam elements of at most \
         {element:.3e} m; with {elements:.3e} elements in total the train would have {freedoms:.3e} degrees \
         of freedom, and matrices of {gigabytes:.3e} GB; at most 4000 of either are allowed",
        place[1] + 1
    )]
    TooFine {
        /// Shaft and section with the most elements, from 0.
        place: [usize; 2],
        /// The name of the shaft.
        shaft: String,
        /// The longest allowed element in this section \[m\].
        element: f64,
        /// Elements of this section.
        elements_of_section: f64,
        /// Elements of the train.
        elements: f64,
        /// Upper limit of its degrees of freedom.
        freedoms: f64,
        /// Size of its matrices \[GB\].
        gigabytes: f64,
    },
    /// Two paths through the train that give a shaft different speeds.
    #[error(
        "the train locks: two meshes require `{body}` to turn at {} and at {} times the speed of the driver; \
         check the numbers of teeth",
        speeds[0], speeds[1]
    )]
    Locked {
        /// The shaft or gear.
        body: String,
        /// Both speeds.
        speeds: [f64; 2],
    },
    /// A joint with which the train cannot rotate at any speeds.
    #[error(
        "the train locks: with what joins `{}` and `{}`, these or the driver `{driver}` cannot turn; check the numbers of teeth, and \
         what couplings join",
        bodies[0], bodies[1]
    )]
    Contradiction {
        /// The joined bodies.
        bodies: [String; 2],
        /// The driving shaft.
        driver: String,
    },
    /// A mesh drives a shaft that cannot rotate.
    #[error(
        "`{body}` is driven, but its `motion` prevents its rotation; set motion = \"all\" or \"rotation\""
    )]
    Held {
        /// The shaft.
        body: String,
    },
    /// A gear or shaft without a connection to the first mesh.
    #[error(
        "the speed of `{body}` is undetermined: no mesh and no coupling connects it with the first mesh; add one"
    )]
    Apart {
        /// The gear or shaft.
        body: String,
    },
    /// An output on a shaft that does not rotate.
    #[error(
        "shaft `{shaft}` has an `output` but does not turn: its `motion` holds it, or no mesh and no coupling turns it; give this `output` \
         to a shaft that turns"
    )]
    Idle {
        /// The shaft.
        shaft: String,
    },
    /// An output on the driving shaft.
    #[error(
        "the driving shaft `{driver}` has an `output`: its power would go through no mesh; give `output` to the shafts that drive \
         machines"
    )]
    OutputOfDriver {
        /// The driving shaft.
        driver: String,
    },
    /// The driving shaft is not connected with the first gear, or without planets has another speed.
    #[error(
        "the driving shaft `{driver}` does not turn with the first gear of `train.gears`: make the mesh \
         nearest to the motor the first one; in a train with planets, connect the motor with them"
    )]
    Driver {
        /// The driving shaft.
        driver: String,
    },
    /// A speed whose ratio needs integers that are too large.
    #[error(
        "the speed of `{body}` is too long a ratio of whole numbers: too many numbers of teeth on the way from the first mesh have \
         no common divisors; choose others"
    )]
    LongRatio {
        /// The shaft or gear.
        body: String,
    },
    /// A mesh whose cycles have no short common period with those of the first one.
    #[error(
        "the mesh of `{}` and `{}` has {p} cycles in {q} cycles of the first mesh, but at most 10000 are allowed; \
         choose other numbers of teeth",
        gears[0], gears[1]
    )]
    LongPeriod {
        /// The gears.
        gears: [String; 2],
        /// Number of cycles of this mesh in `q` cycles of the first mesh.
        p: u64,
        /// Number of cycles of the first mesh.
        q: u64,
    },
    /// Meshes whose cycles have no short common period.
    #[error(
        "the meshes with a varying stiffness repeat together only after {cycles} cycles of the first mesh, but at \
         most 10000 are allowed; choose numbers of teeth with common divisors, or a constant stiffness"
    )]
    LongTogether {
        /// Cycles of the first mesh; the largest integer if they are more.
        cycles: usize,
    },
    /// A part beyond the ends of its shaft.
    #[error("{what} of shaft `{shaft}` is at {at} m, but the shaft reaches from 0 to {length} m")]
    OffShaft {
        /// The shaft.
        shaft: String,
        /// The part.
        what: &'static str,
        /// Its position \[m\].
        at: f64,
        /// Length of the shaft \[m\].
        length: f64,
    },
    /// A rigid shaft without inertia.
    #[error("shaft `{shaft}` has no sections and no inertia: give it a disc or sections")]
    NoInertia {
        /// The shaft.
        shaft: String,
    },
    /// A shaft is free to move other than by rotating about its axis.
    #[error(
        "shaft `{shaft}` is not held {direction}: give a bearing a stiffness there, or set its motion to \"rotation\""
    )]
    NotHeld {
        /// The shaft.
        shaft: String,
        /// The free motion.
        direction: &'static str,
    },
    /// A loose gear is free to move other than by rotating about its axis.
    #[error("gear `{gear}` is not held {direction} on its shaft: give `loose.{key}`")]
    LooseNotHeld {
        /// The gear.
        gear: String,
        /// The free motion.
        direction: &'static str,
        /// Key that would hold it.
        key: &'static str,
    },
    /// A housing under a shaft in a rotating frame.
    #[error(
        "bearing {bearing} of shaft `{shaft}` cannot stand on the housing: the shaft moves with planets, whose frame turns \
         with the carrier, and a housing that is seen to turn has no constant stiffness there; remove `housing` from this \
         bearing and give it equal x and y, or hold the carrier"
    )]
    TurningHousing {
        /// The shaft.
        shaft: String,
        /// Number of its bearing, from 1.
        bearing: usize,
    },
    /// A housing that supports no bearing.
    #[error(
        "no bearing stands on the housing, whose nodes are {nodes}; give bearings the name of a node, such as \
         housing = {first}"
    )]
    UnusedHousing {
        /// Its nodes.
        nodes: String,
        /// The first of them.
        first: String,
    },
    /// A bearing that is not at the position of its node.
    #[error(
        "bearing {bearing} of shaft `{shaft}` is {distance:.6e} m from node `{node}` of the housing, but at most \
         {most:.0e} m are allowed; correct its position, or the position of the node in the housing file"
    )]
    BearingOffNode {
        /// The shaft.
        shaft: String,
        /// Number of its bearing, from 1.
        bearing: usize,
        /// The node.
        node: String,
        /// Their distance \[m\].
        distance: f64,
        /// Largest accepted distance \[m\].
        most: f64,
    },
    /// A bearing of a rigidly mounted shaft on a housing.
    #[error(
        "bearing {bearing} of shaft `{shaft}` stands on the housing, but `motion` mounts the shaft rigidly; set motion = \
         \"all\" or \"lateral\", or remove `housing` from the bearing"
    )]
    RigidMount {
        /// The shaft.
        shaft: String,
        /// Number of its bearing, from 1.
        bearing: usize,
    },
    /// A housing that nothing holds.
    #[error(
        "the housing is free to move as a rigid body; include its supports to the ground in its stiffness matrix, or \
         leave out the freedoms that the ground holds"
    )]
    FloatingHousing,
    /// A coupling between shafts on axes of different directions.
    #[error(
        "the coupling joins shafts `{}` and `{}`, but their axes have different directions; choose shafts on one axis",
        shafts[0], shafts[1]
    )]
    CouplingAxes {
        /// The shafts.
        shafts: [String; 2],
    },
    /// A coupling between shafts that are not on one axis.
    #[error(
        "the coupling joins shafts `{}` and `{}`, but their axes are {distance:.3e} m apart; choose shafts on one axis",
        shafts[0], shafts[1]
    )]
    CouplingOffAxis {
        /// The shafts.
        shafts: [String; 2],
        /// Distance of the axes \[m\].
        distance: f64,
    },
    /// A coupling with a radial stiffness between positions that do not coincide.
    #[error(
        "the coupling joins shafts `{}` and `{}` across a gap of {gap:.3e} m, where its radial stiffness would create \
         an unbalanced moment; choose positions `at` that coincide in space, or lengthen one of the shafts",
        shafts[0], shafts[1]
    )]
    CouplingGap {
        /// The shafts.
        shafts: [String; 2],
        /// Length of the gap along the axis \[m\].
        gap: f64,
    },
}
