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
    /// Scale of lengths \[m\] of an oscillator, which has no flanks: the half gap is out of reach then.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub length: Option<f64>,
    /// Stiffness over the mesh cycle.
    pub stiffness: StiffnessSpec,
    /// Contact damping.
    pub damping: DampingSpec,
    /// Coulomb friction on the flank, which turns round at the pitch point.
    pub friction: FrictionSpec,
    /// Where pairs slide over the mesh cycle; none without friction, and with a table, which says it itself.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sliding: Option<EvenSharing>,
    /// Angle between the flanks in the plane of action before the load acts, ε₀ \[rad\]; 0
    /// without a table.
    pub misalignment: f64,
    /// Where the coast flanks touch.
    pub coast: CoastSpec,
    /// When contacts let go.
    pub release: Release,
    /// Teeth unlike the others, if any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub teeth: Option<Arc<FaultyTeeth>>,
    /// The film of oil, if any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub film: Option<Film>,
}

impl MeshSpec {
    /// What tolerances measure lengths by \[m\]: the half gap, or the scale of an oscillator.
    pub fn scale(&self) -> f64 {
        self.length.unwrap_or(self.half_gap)
    }

    /// The same of an oscillator whose lengths are measured by this one \[m\]: no motion reaches its flanks.
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
    /// One value \[1\].
    Constant(f64),
    /// By the mean load and the speed of a point.
    Mean {
        /// Oil and roughness.
        law: MeanFriction,
        /// The drawing.
        gears: Arc<GearPair>,
    },
}

impl FrictionSpec {
    /// The one value \[1\]; none where a law gives it.
    pub fn constant(&self) -> Option<f64> {
        match self {
            Self::Constant(value) => Some(*value),
            Self::Mean { .. } => None,
        }
    }

    /// Whether there is any.
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

/// Along which line of action the coast flanks touch.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub enum CoastSpec {
    /// That of the drive flanks, pushed from behind.
    SameLine,
    /// Its mirror image, at the mesh phases that mirror those of the drive flanks.
    Mirrored {
        /// Mesh phase at which a tooth of the pinion stands on the line of centres, in cycles.
        symmetry: f64,
    },
}

/// Places of a mesh cycle at which a Fourier series is looked at for its extremes.
const FOURIER_PLACES: u32 = 4096;

/// Stiffness over the mesh cycle.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub enum StiffnessSpec {
    /// One value \[N/m\].
    Constant(f64),
    /// Equal segments of the mesh cycle, one value each \[N/m\]. The two-level law
    /// (`mean_stiffness`, `contact_ratio`, `single_pair_drop`, `segments`) is resolved to
    /// this: double-pair level over the first `contact_ratio − 1` of the cycle, the
    /// single-pair level `(1 − drop)` times it over the rest, with the given mean.
    Piecewise(Arc<[f64]>),
    /// The same law, its transition where it is and not on a segment's border.
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

    /// Whether pairs of teeth are springs of their own.
    pub fn is_of_pairs(&self) -> bool {
        matches!(self, Self::Table(table) if matches!(table.division, CycleDivision::Pairs { .. }))
    }

    /// Smallest and largest over the mesh cycle \[N/m\], of a Fourier series to a part in 10 000 of its
    /// harmonics; of a table they are known when the table is made.
    pub fn extremes(&self) -> Option<[f64; 2]> {
        let levels = match self {
            Self::Constant(value) => vec![*value],
            Self::Piecewise(values) => values.to_vec(),
            Self::Continuous(levels) => levels.divisions().0,
            Self::Fourier(mean, harmonics) => (0..FOURIER_PLACES)
                .map(|place| {
                    let phase = f64::from(place) / f64::from(FOURIER_PLACES);
                    let terms = harmonics.iter().map(|term| {
                        term.amplitude * (TAU * f64::from(term.harmonic) * phase + term.phase).cos()
                    });
                    mean + terms.sum::<f64>()
                })
                .collect(),
            Self::Table(_) => return None,
        };
        let pick = |better: fn(f64, f64) -> f64| levels.iter().copied().reduce(better);
        Some([pick(f64::min)?, pick(f64::max)?])
    }

    /// Mean over the mesh cycle \[N/m\]; of a table it is known when the table is made.
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
    /// Stiffness after it \[N/m\].
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
    /// Ratio ζ_m of `c = 2 ζ_m √(k_mean m_e)`, `1/m_e = Σ mesh²` over the rigid modes
    /// (over all modes where there is no rigid mode).
    Ratio(f64),
    /// The coefficient itself \[N s/m\].
    Coefficient(f64),
}
