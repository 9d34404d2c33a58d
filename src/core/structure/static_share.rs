//! What modes that are left out do to bearings while they follow their loads at rest.

/// Static force on a bearing \[N\] per unit of each load of a structure, from the modes that are left out:
/// `Σ gain f/ω²`, f the modal force of the load. A force of a flank acts with a minus sign.
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize)]
pub struct StaticShare {
    /// Of a unit force on the drive flanks: at mid-face and without friction \[1\], by the load centroid \[1/m\],
    /// by the friction force \[1\], by its lever \[1/m\].
    pub drive: [f64; 4],
    /// Of one on the coast flanks.
    pub coast: [f64; 4],
    /// Of one of every further contact.
    pub contacts: Vec<[f64; 4]>,
    /// Of [`ModalStructure::torque`](super::ModalStructure::torque).
    pub torque: f64,
    /// Of a unit torque on the pinion's and the wheel's shaft \[1/m\].
    pub shaft_torques: [f64; 2],
    /// Of [`ModalStructure::constant_load`](super::ModalStructure::constant_load) \[N\].
    pub constant_load: f64,
    /// Of [`ModalStructure::load_by_speed`](super::ModalStructure::load_by_speed) \[N s/rad\].
    pub load_by_speed: f64,
    /// Of the load of [`TurningFrame`](super::TurningFrame) \[N s²/rad²\].
    pub frame_load: f64,
    /// Of every harmonic load \[N\].
    pub harmonic_loads: Vec<f64>,
}
