//! Which kernels and drives do the checks use, and how much do they integrate?

use super::CheckError;
use super::candidate::{self, Candidate};
use super::drives::{self, Case};
use strum::IntoStaticStr;

/// Amount of integration.
#[derive(Debug, Clone, Copy, PartialEq, Eq, IntoStaticStr)]
#[strum(serialize_all = "lowercase")]
pub enum Extent {
    /// Some seconds.
    Quick,
    /// Many minutes: more cycles of each drive.
    Full,
}

impl Extent {
    /// The word used in reports.
    pub fn name(self) -> &'static str {
        self.into()
    }

    /// One of two amounts.
    pub(super) fn pick<T>(self, quick: T, full: T) -> T {
        match self {
            Self::Quick => quick,
            Self::Full => full,
        }
    }
}

/// Kernels and drives of the checks.
pub struct Subjects {
    /// Amount of integration.
    pub extent: Extent,
    /// The kernels under test. Checks of a single kernel use the last one.
    pub kernels: Vec<Candidate>,
    /// The drives on which kernels are tested; the default drive last.
    pub cases: Vec<Case>,
    /// More operating points of the default drive, for comparisons of kernels over single cycles.
    pub grid: Vec<Case>,
}

impl Subjects {
    /// All kernels of this machine on the built-in drives.
    ///
    /// # Errors
    /// The built-in drives cannot be assembled.
    pub fn all(extent: Extent) -> Result<Self, CheckError> {
        Ok(Self {
            extent,
            kernels: candidate::kernels(),
            cases: drives::cases()?,
            grid: drives::grid()?,
        })
    }

    /// The default drive: the last case.
    pub(super) fn default_drive(&self) -> Result<&Case, CheckError> {
        self.cases.last().ok_or(CheckError::Missing {
            what: "a drive to test on",
        })
    }

    /// The kernel for checks of a single kernel: the last one.
    pub(super) fn kernel(&self) -> Result<&Candidate, CheckError> {
        self.kernels.last().ok_or(CheckError::Missing {
            what: "a kernel to test",
        })
    }
}
