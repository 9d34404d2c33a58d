//! What a structure looks like to the mesh: frequencies, damping, participations.

/// A linear structure in mass-normalised modal coordinates, as seen by the gear mesh.
///
/// Every vector has one entry a mode, in ascending frequency. Mode `i` obeys
/// `q'' + 2 ζ ω q' + ω² q = torque·F₀ − mesh·F + …` with `F₀` the static and `F` the
/// actual mesh force \[N\]; `q` is in m √kg.
#[derive(Debug, Clone, PartialEq)]
pub struct ModalStructure {
    /// Teeth of the pinion: mesh order per pinion revolution.
    pub teeth: u32,
    /// Teeth of the wheel, where known (needed for ripple on the wheel's shaft).
    pub wheel_teeth: Option<u32>,
    /// Mesh force at load = 1 \[N\].
    pub rated_force: f64,
    /// Undamped natural frequency ω \[rad/s\]; 0 for a rigid rotation.
    pub frequency: Vec<f64>,
    /// Modal damping ratio ζ \[1\], `0 ≤ ζ < 1`.
    pub damping: Vec<f64>,
    /// Participation of the mesh deflection \[1/√kg\].
    pub mesh: Vec<f64>,
    /// Derivative of `mesh` by the load centroid z_c \[1/(m √kg)\].
    pub mesh_tilt: Vec<f64>,
    /// Modal force of a unit static mesh force \[1/√kg\]: torques `+r₁` on the pinion
    /// side and `−r₂` on the wheel side.
    pub torque: Vec<f64>,
    /// Modal force of a unit torque on the pinion's shaft \[1/(m √kg)\], where known.
    pub pinion_torque: Option<Vec<f64>>,
    /// Modal force of a unit torque on the wheel's shaft \[1/(m √kg)\], where known.
    pub wheel_torque: Option<Vec<f64>>,
    /// Participation of a unit friction force \[1/√kg\].
    pub friction: Vec<f64>,
    /// Its part linear in the position along the path of contact \[1/(m √kg)\].
    pub friction_lever: Vec<f64>,
    /// Static flexibility of the modes left out, `Σ mesh²/ω²` \[m/N\]; 0 when none is
    /// left out or when it is to be ignored (no modal-truncation augmentation).
    pub residual_flexibility: f64,
}

impl ModalStructure {
    /// Number of modes N.
    pub fn modes(&self) -> usize {
        self.frequency.len()
    }
}
