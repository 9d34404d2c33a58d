//! The three contact states and the two surfaces between them.

/// Contact state of the mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Contact {
    /// Drive flank: δ ≥ b.
    Drive,
    /// Free flight: |δ| < b.
    Free,
    /// Coast (back) flank: δ ≤ −b.
    Coast,
}

impl Contact {
    /// s of the force law: +1 drive, 0 free, −1 coast.
    pub fn sign(self) -> f64 {
        match self {
            Self::Drive => 1.0,
            Self::Free => 0.0,
            Self::Coast => -1.0,
        }
    }

    /// Whether the mesh transmits force.
    pub fn touching(self) -> bool {
        self != Self::Free
    }

    /// Index into per-state statistics: drive, free, coast.
    pub fn index(self) -> usize {
        match self {
            Self::Drive => 0,
            Self::Free => 1,
            Self::Coast => 2,
        }
    }

    /// The word stored in result files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Drive => "drive",
            Self::Free => "free",
            Self::Coast => "coast",
        }
    }

    /// The state of a mesh with deflection δ and rate δ', for half gap b and its rate b'; on a
    /// surface the rates decide.
    pub fn classify(deflection: f64, rate: f64, [half_gap, opening]: [f64; 2]) -> Self {
        if deflection > half_gap || (deflection == half_gap && rate > opening) {
            Self::Drive
        } else if deflection < -half_gap || (deflection == -half_gap && rate < -opening) {
            Self::Coast
        } else {
            Self::Free
        }
    }

    /// Distance \[m\] by which a deflection lies inside this state; negative outside.
    pub fn clearance(self, deflection: f64, half_gap: f64) -> f64 {
        match self {
            Self::Drive => deflection - half_gap,
            Self::Free => half_gap - deflection.abs(),
            Self::Coast => -deflection - half_gap,
        }
    }

    /// The first surface on the way to another state; none where it is this one.
    pub fn towards(self, target: Self) -> Option<Surface> {
        match (self, target) {
            _ if self == target => None,
            (Self::Drive, _) | (Self::Free, Self::Drive) => Some(Surface::Drive),
            _ => Some(Surface::Coast),
        }
    }

    /// The surfaces through which the state is left.
    pub fn surfaces(self) -> &'static [Surface] {
        match self {
            Self::Drive => &[Surface::Drive],
            Self::Coast => &[Surface::Coast],
            Self::Free => &[Surface::Drive, Surface::Coast],
        }
    }

    /// The state on the other side of a surface.
    pub fn across(self, surface: Surface) -> Self {
        match (self, surface) {
            (Self::Free, Surface::Drive) => Self::Drive,
            (Self::Free, Surface::Coast) => Self::Coast,
            (Self::Drive | Self::Coast, _) => Self::Free,
        }
    }
}

/// A switching surface.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Surface {
    /// δ = +b.
    Drive,
    /// δ = −b.
    Coast,
}

impl Surface {
    /// δ/b on the surface.
    pub fn sign(self) -> f64 {
        match self {
            Self::Drive => 1.0,
            Self::Coast => -1.0,
        }
    }
}
