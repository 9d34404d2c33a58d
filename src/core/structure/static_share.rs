//! How much do omitted modes load the bearings if they follow their loads statically?

/// Static force on a bearing \[N\] per unit of each load of a structure, from the omitted modes:
/// `Σ gain f/ω²` with the modal force f of the load. A force of a flank acts with a minus sign.
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize)]
pub struct OmittedModeForces {
    /// Per a unit force on the drive flanks: at mid-face and without friction \[1\], by the load centroid \[1/m\],
    /// by the friction force \[1\], by its lever \[1/m\].
    pub drive: [f64; 4],
    /// Per one on the coast flanks.
    pub coast: [f64; 4],
    /// Per one on every further contact.
    pub contacts: Vec<[f64; 4]>,
    /// Per [`ModalStructure::torque`](super::ModalStructure::torque).
    pub torque: f64,
    /// Per a unit torque on the pinion's and the wheel's shaft \[1/m\].
    pub shaft_torques: [f64; 2],
    /// Per [`ModalStructure::constant_load`](super::ModalStructure::constant_load) \[N\].
    pub constant_load: f64,
    /// Per [`ModalStructure::load_by_speed`](super::ModalStructure::load_by_speed) \[N s/rad\].
    pub load_by_speed: f64,
    /// Per the load of [`TurningFrame`](super::TurningFrame) \[N s²/rad²\].
    pub frame_load: f64,
    /// Per every harmonic load \[N\].
    pub harmonic_loads: Vec<f64>,
}
