//! Where and how the mesh force acts on the blocks: the line of action, the load centroid and
//! the friction of a segment.

use super::{Block, Division, Drive, MeshGain};

/// Participations of a structure, in a model's basis, one entry a mode.
pub(super) struct Participations {
    /// Of the mesh deflection \[1/√kg\].
    pub mesh: Vec<f64>,
    /// Its derivative by the load centroid \[1/(m √kg)\].
    pub tilt: Vec<f64>,
    /// Of a friction force at the pitch point \[1/√kg\].
    pub friction: Vec<f64>,
    /// Its part linear in the position along the path of contact \[1/(m √kg)\].
    pub lever: Vec<f64>,
}

impl Participations {
    /// The distinct directions of the divisions, `w = mesh + z_c tilt` and
    /// `g = w + μ (Λ₀ friction + Λ₁ lever)` of every block, and which one each division has.
    pub fn directions(&self, drive: &Drive, blocks: &[Block]) -> (Vec<Vec<MeshGain>>, Vec<usize>) {
        let mut directions: Vec<Vec<MeshGain>> = Vec::new();
        let which = (drive.mesh.iter())
            .map(|division| {
                let direction = self.direction(division, drive.friction, blocks);
                let known = directions.iter().position(|known| *known == direction);
                known.unwrap_or_else(|| {
                    directions.push(direction);
                    directions.len() - 1
                })
            })
            .collect();
        (directions, which)
    }

    fn direction(&self, division: &Division, friction: f64, blocks: &[Block]) -> Vec<MeshGain> {
        let [turn, lever] = division.friction;
        (blocks.iter().enumerate())
            .map(|(i, block)| {
                let w = self.mesh[i] + division.load_centre * self.tilt[i];
                let rubbing = turn * self.friction[i] + lever * self.lever[i];
                MeshGain::mode(block, w, w + friction * rubbing)
            })
            .collect()
    }
}
