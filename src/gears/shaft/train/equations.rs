//! Homogeneous linear equations over the speeds of bodies, solved exactly.
//!
//! Each equation is reduced by the others when it is added, so a solution needs no second pass. All
//! speeds should follow from one of them, the *reference*: it is eliminated last.

use super::ratio::Ratio;

/// An unknown with a ratio whose integers are too large.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct RatioTooLarge(pub usize);

/// Reduced equations.
#[derive(Debug, Clone)]
pub(super) struct Equations {
    unknowns: usize,
    reference: usize,
    /// Each equation with the unknown that it determines. This unknown has the coefficient 1 there and 0 in
    /// all other equations.
    rows: Vec<(usize, Vec<Ratio>)>,
}

impl Equations {
    pub fn new(unknowns: usize, reference: usize) -> Self {
        Self {
            unknowns,
            reference,
            rows: Vec::new(),
        }
    }

    /// Adds `Σ part · unknown = 0`. Returns whether the reference may still be nonzero.
    pub fn add(
        &mut self,
        terms: impl IntoIterator<Item = (usize, Ratio)>,
    ) -> Result<bool, RatioTooLarge> {
        let mut coefficients = vec![Ratio::ZERO; self.unknowns];
        for (unknown, part) in terms {
            coefficients[unknown] = coefficients[unknown] + part;
        }
        for (given, row) in &self.rows {
            eliminate(&mut coefficients, row, *given)?;
        }
        let left = |unknown: &usize| coefficients[*unknown] != Ratio::ZERO;
        let others = (0..self.unknowns).filter(|unknown| *unknown != self.reference);
        let Some(given) = others.chain([self.reference]).find(left) else {
            return Ok(true);
        };
        let unit = coefficients[given];
        for part in coefficients.iter_mut().filter(|part| **part != Ratio::ZERO) {
            *part = *part / unit;
        }
        is_short(&coefficients)?;
        for (_, row) in &mut self.rows {
            eliminate(row, &coefficients, given)?;
        }
        self.rows.push((given, coefficients));
        Ok(given != self.reference)
    }

    /// Value of an unknown if the reference is 1; `None` if it is undetermined.
    pub fn value(&self, unknown: usize) -> Option<Ratio> {
        if unknown == self.reference {
            return Some(Ratio::ONE);
        }
        let (_, row) = self.rows.iter().find(|(given, _)| *given == unknown)?;
        let free = (row.iter().enumerate())
            .any(|(at, part)| at != unknown && at != self.reference && *part != Ratio::ZERO);
        (!free).then_some(Ratio::ZERO - row[self.reference])
    }
}

/// Eliminates the unknown `given` from an equation, by means of the equation that determines this unknown.
fn eliminate(row: &mut [Ratio], by: &[Ratio], given: usize) -> Result<(), RatioTooLarge> {
    let times = row[given];
    if times == Ratio::ZERO {
        return Ok(());
    }
    for (part, other) in row.iter_mut().zip(by) {
        if *other != Ratio::ZERO {
            *part = *part - *other * times;
        }
    }
    is_short(row)
}

fn is_short(row: &[Ratio]) -> Result<(), RatioTooLarge> {
    let long = row.iter().position(|part| *part == Ratio::TOO_LARGE);
    long.map_or(Ok(()), |unknown| Err(RatioTooLarge(unknown)))
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn ratio(over: i128, under: i128) -> Ratio {
        Ratio::new(over, under)
    }

    /// Willis: 19 sun + 56 ring = 75 carrier; a held ring gives 75/19.
    #[test]
    fn a_held_member_leaves_one_way_to_turn() {
        let mut set = Equations::new(3, 1);
        let willis = [(0, ratio(19, 1)), (1, ratio(-75, 1)), (2, ratio(56, 1))];
        assert_eq!(set.add(willis), Ok(true));
        assert_eq!(
            [0, 1, 2].map(|own| set.value(own)),
            [None, Some(Ratio::ONE), None]
        );
        assert_eq!(set.add([(2, Ratio::ONE)]), Ok(true));
        assert_eq!(set.value(0), Some(ratio(75, 19)));
        assert_eq!(set.value(2), Some(Ratio::ZERO));
        // A redundant equation changes nothing, a contradictory one stops the reference.
        assert_eq!(set.add([(0, ratio(19, 1)), (1, ratio(-75, 1))]), Ok(true));
        assert_eq!(set.clone().add([(0, Ratio::ONE)]), Ok(false));
    }

    #[test]
    fn long_ratios_are_told() {
        let mut chain = Equations::new(3, 0);
        let large = ratio(i128::MAX, 1);
        assert_eq!(chain.add([(1, Ratio::ONE), (0, large)]), Ok(true));
        assert_eq!(
            chain.add([(2, Ratio::ONE), (1, large)]),
            Err(RatioTooLarge(0))
        );
    }
}
