//! Which forces do the omitted modes exert on the bearings, if they follow their loads statically?

/// Static force on a bearing \[N\] per unit of each load of a structure, from the omitted modes:
/// `Σ gain f/ω²` with the modal force f of the load. The f of a contact force has the reversed sign, as
/// [`StructureContact::force`](super::StructureContact::force).
#[derive(Debug, Clone, Default, PartialEq, serde::Serialize)]
pub struct OmittedModeForces {
    /// Per unit force on the drive flanks. The four entries are the share at mid-face without friction \[1\],
    /// its derivative with respect to the load centroid \[1/m\], the share of the friction force \[1\], and
    /// the share of the lever of friction \[1/m\].
    pub drive: [f64; 4],
    /// Per unit force on the coast flanks.
    pub coast: [f64; 4],
    /// Per unit force on every further contact, with the entries of `drive`.
    pub contacts: Vec<[f64; 4]>,
    /// Per unit of [`ModalStructure::torque`](super::ModalStructure::torque).
    pub torque: f64,
    /// Per unit torque on the pinion's and on the wheel's shaft \[1/m\].
    pub shaft_torques: [f64; 2],
    /// Under [`ModalStructure::constant_load`](super::ModalStructure::constant_load) \[N\], including the
    /// force of springs with displaced bases.
    pub constant_load: f64,
    /// Under [`ModalStructure::load_by_speed`](super::ModalStructure::load_by_speed), per unit speed \[N
    /// s/rad\].
    pub load_by_speed: f64,
    /// Under the centrifugal load of [`TurningFrame`](super::TurningFrame), per unit of Ω² \[N s²/rad²\].
    pub frame_load: f64,
    /// Amplitude under every harmonic load \[N\].
    pub harmonic_loads: Vec<f64>,
}
