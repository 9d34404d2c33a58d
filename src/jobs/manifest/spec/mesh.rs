//! The resolved gear mesh.

use crate::gear::{
    CycleDivision, EvenSharing, FaultyTeeth, GearError, GearPair, MeanFriction, MeshTableSpec,
};
use crate::model::{Film, OUT_OF_REACH, Release, StiffnessHarmonic};
use serde::Serialize;
use std::f64::consts::TAU;
use std::sync::Arc;

/// The gear mesh.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MeshSpec {
    /// Backlash half gap b \[m\], > 0.
    pub half_gap: f64,
    /// Scale of lengths \[m\] of an oscillator, which has no flanks: its half gap is out of reach.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub length: Option<f64>,
    /// Stiffness over the mesh cycle.
    pub stiffness: StiffnessSpec,
    /// Contact damping.
    pub damping: DampingSpec,
    /// Coulomb friction on the flank, which reverses at the pitch point.
    pub friction: FrictionSpec,
    /// Sliding of pairs over the mesh cycle; `None` without friction, or with a table, which includes it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sliding: Option<EvenSharing>,
    /// Angle between the flanks in the plane of action before the load acts, ε₀ \[rad\]; 0 without a table.
    pub misalignment: f64,
    /// Line of action of the coast flanks.
    pub coast: CoastSpec,
    /// Rule for opening a closed contact.
    pub release: Release,
    /// Teeth that differ from the others, if any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub teeth: Option<Arc<FaultyTeeth>>,
    /// The film of oil, if any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub film: Option<Film>,
}

impl MeshSpec {
    /// The length scale of tolerances \[m\]: the half gap, or the scale of an oscillator.
    pub fn scale(&self) -> f64 {
        self.length.unwrap_or(self.half_gap)
    }

    /// This mesh of an oscillator with another length scale \[m\]. Its flanks are out of reach.
    pub fn measured_by(&self, length: f64) -> Self {
        Self {
            half_gap: OUT_OF_REACH * length,
            length: Some(length),
            ..self.clone()
        }
    }
}

/// Coulomb friction coefficient μ_f.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub enum FrictionSpec {
    /// A constant value \[1\].
    Constant(f64),
    /// Depends on the mean load and the speed of a point.
    Mean {
        /// Oil and roughness.
        law: MeanFriction,
        /// The drawing.
        gears: Arc<GearPair>,
    },
}

impl FrictionSpec {
    /// The constant value \[1\]; `None` for a law.
    pub fn constant(&self) -> Option<f64> {
        match self {
            Self::Constant(value) => Some(*value),
            Self::Mean { .. } => None,
        }
    }

    /// Whether there is any friction.
    pub fn acts(&self) -> bool {
        self.constant() != Some(0.0)
    }

    /// The coefficient \[1\] under a mean mesh force \[N\] at a pinion speed \[rad/s\].
    ///
    /// # Errors
    /// As [`MeanFriction::coefficient`].
    pub fn coefficient(&self, force: f64, speed: f64) -> Result<f64, GearError> {
        match self {
            Self::Constant(value) => Ok(*value),
            Self::Mean { law, gears } => law.coefficient(gears, force, speed),
        }
    }
}

/// The line of action of the coast flanks.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub enum CoastSpec {
    /// The line of action of the drive flanks, with a force in the opposite direction.
    SameLine,
    /// The mirror image of the drive flanks' line of action, at mirrored mesh phases.
    Mirrored {
        /// Mesh phase at which a tooth of the pinion is on the line of centres, in cycles.
        symmetry: f64,
    },
}

/// Number of phases per period of the highest harmonic at which extremes of a Fourier series are searched for.
const PLACES_PER_PERIOD: u32 = 256;

/// Least number of phases per mesh cycle for this search.
const LEAST_PLACES: u32 = 4096;

/// Stiffness over the mesh cycle.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub enum StiffnessSpec {
    /// One value \[N/m\].
    Constant(f64),
    /// Equal segments of the mesh cycle, one value each \[N/m\]. The two-level law (`mean_stiffness`, `contact_ratio`,
    /// `single_pair_drop`, `segments`) becomes this: the double-pair level over the first `contact_ratio − 1` of the
    /// cycle, and `(1 − drop)` times this level over the rest, with the given mean.
    Piecewise(Arc<[f64]>),
    /// The two-level law with the exact transition, not on a segment's border.
    Continuous(TwoLevels),
    /// A Fourier series: its mean \[N/m\] and its harmonics.
    Fourier(f64, Arc<[StiffnessHarmonic]>),
    /// Computed from the drawing of the gears.
    Table(Arc<MeshTableSpec>),
}

impl StiffnessSpec {
    /// Whether it may vary over the mesh cycle.
    pub fn varies(&self) -> bool {
        match self {
            Self::Constant(_) => false,
            Self::Piecewise(values) => values.iter().any(|value| *value != values[0]),
            Self::Continuous(levels) => levels.divisions().0.len() > 1,
            Self::Fourier(_, harmonics) => !harmonics.is_empty(),
            Self::Table(_) => true,
        }
    }

    /// Whether pairs of teeth are separate springs.
    pub fn is_of_pairs(&self) -> bool {
        matches!(self, Self::Table(table) if matches!(table.division, CycleDivision::Pairs { .. }))
    }

    /// Smallest and largest stiffness over the mesh cycle \[N/m\]. For a Fourier series, the error is below
    /// 1/10 000 of the sum of the amplitudes. `None` for a table, which is computed later.
    pub fn extremes(&self) -> Option<[f64; 2]> {
        let levels = match self {
            Self::Constant(value) => vec![*value],
            Self::Piecewise(values) => values.to_vec(),
            Self::Continuous(levels) => levels.divisions().0,
            Self::Fourier(mean, harmonics) => {
                let highest = harmonics.iter().map(|term| term.harmonic).max();
                let places = LEAST_PLACES.max(PLACES_PER_PERIOD * highest.unwrap_or(0));
                (0..places)
                    .map(|place| {
                        let phase = f64::from(place) / f64::from(places);
                        let terms = harmonics.iter().map(|term| {
                            let angle = TAU * f64::from(term.harmonic) * phase + term.phase;
                            term.amplitude * angle.cos()
                        });
                        mean + terms.sum::<f64>()
                    })
                    .collect()
            }
            Self::Table(_) => return None,
        };
        let pick = |better: fn(f64, f64) -> f64| levels.iter().copied().reduce(better);
        Some([pick(f64::min)?, pick(f64::max)?])
    }

    /// Mean over the mesh cycle \[N/m\]; `None` for a table, which is computed later.
    pub fn mean(&self) -> Option<f64> {
        match self {
            Self::Constant(value) => Some(*value),
            Self::Piecewise(values) => Some(values.iter().sum::<f64>() / values.len() as f64),
            Self::Continuous(levels) => Some(levels.mean()),
            Self::Fourier(mean, _) => Some(*mean),
            Self::Table(_) => None,
        }
    }
}

/// Stiffness with two pairs of teeth in mesh, then with one.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct TwoLevels {
    /// Stiffness before the transition \[N/m\].
    pub double_pair: f64,
    /// Stiffness after the transition \[N/m\].
    pub single_pair: f64,
    /// Mesh phase of the transition, in cycles, in \[0, 1\].
    pub transition: f64,
}

impl TwoLevels {
    /// Mean over the mesh cycle \[N/m\].
    pub fn mean(&self) -> f64 {
        self.transition * self.double_pair + (1.0 - self.transition) * self.single_pair
    }

    /// Stiffness of the divisions of the cycle \[N/m\] and the phases between them.
    pub fn divisions(&self) -> (Vec<f64>, Vec<f64>) {
        match self.transition {
            0.0 => (vec![self.single_pair], Vec::new()),
            1.0 => (vec![self.double_pair], Vec::new()),
            phase => (vec![self.double_pair, self.single_pair], vec![phase]),
        }
    }
}

/// Contact damping.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub enum DampingSpec {
    /// Ratio ζ_m of `c = 2 ζ_m √(k_mean m_e)`, with the mass m_e of
    /// [`ModalStructure::mesh_mass`](crate::structure::ModalStructure::mesh_mass).
    Ratio(f64),
    /// The coefficient itself \[N s/m\].
    Coefficient(f64),
}
