//! One basis of the spectral kernel, ready for use: its operators, the deflection in its
//! coordinates, and what moves them over a time.

use super::DenseError;
use super::basis::{Basis, POWERS};
use super::cell_model::CellModel;
use super::conditioning::Conditioning;
use super::exponential;
use super::generator::Generator;
use super::kept::{Reader, Writer};
use super::matrix::{Operator, numbers_of};
use super::waves;
use faer::Mat;

/// One basis, ready for use.
#[derive(Debug)]
pub struct SpectralTable<'t> {
    /// W⁻¹ and W.
    pub inverse: Operator<'t>,
    pub matrix: Operator<'t>,
    pub alpha: Vec<f64>,
    pub nu: Vec<f64>,
    /// |λ| of the waves.
    pub sizes: Vec<f64>,
    /// Growth of the fastest growing wave \[1/s\]; none grows without friction.
    pub growth: f64,
    /// Deflection in terms of u and v.
    pub gains: [Vec<f64>; 2],
    /// Deflection of the slow group, row k times the k-th power of time; rows of `slow`.
    pub polynomial: Vec<f64>,
    /// Slow coordinates with their constants.
    pub slow: usize,
    /// Gᵏ/k!, row by row.
    powers: Vec<Vec<f64>>,
    /// δ'' as a row over z.
    pub curvature: Vec<f64>,
    /// Factors over the whole cell.
    pub whole: Factors,
    pub conditioning: Conditioning,
}

/// What moves spectral coordinates over a time.
#[derive(Debug, Clone)]
pub struct Factors {
    pub time: f64,
    cosine: Vec<f64>,
    sine: Vec<f64>,
    /// `e^{Gt}`, row by row.
    slow: Vec<f64>,
}

impl Factors {
    pub fn new(lanes: usize, slow: usize) -> Self {
        Self {
            time: f64::NAN,
            cosine: vec![0.0; lanes],
            sine: vec![0.0; lanes],
            slow: vec![0.0; slow * slow],
        }
    }
}

impl<'t> SpectralTable<'t> {
    /// The basis of a generator, on cells of a class.
    pub fn new(
        generator: &Generator,
        cell_model: &CellModel<'_>,
        class: usize,
        touching: bool,
    ) -> Result<Self, DenseError> {
        let (grid, layout) = (&cell_model.grid, &cell_model.layout);
        let basis = Basis::new(generator, grid.period, touching)?;
        let lanes = basis.alpha.len();
        let slow = basis.slow + 2;
        let row = Mat::from_fn(1, layout.dimension(), |_, j| generator.deflection[j]);
        let seen = &row * &basis.matrix;
        let slow_row = Mat::from_fn(1, slow, |_, j| seen[(0, 2 * lanes + j)]);
        let mut polynomial: Vec<f64> = (basis.powers.iter())
            .flat_map(|power| {
                let row = &slow_row * power;
                (0..slow).map(move |j| row[(0, j)])
            })
            .collect();
        // A nilpotent group's polynomial ends early.
        while polynomial.len() > slow
            && polynomial[polynomial.len() - slow..]
                .iter()
                .all(|p| *p == 0.0)
        {
            polynomial.truncate(polynomial.len() - slow);
        }
        let duration = grid.classes[class].duration;
        let propagator = exponential::propagator(generator, grid.rate, duration);
        let conditioning = Conditioning {
            segment: grid.classes[class].segment,
            touching,
            condition: basis.condition,
            reconstruction: basis.reconstruction(&propagator, duration, layout.modes, grid.rate),
        };
        conditioning.check()?;
        let flat = |power: &Mat<f64>| {
            (0..slow * slow)
                .map(|i| power[(i / slow, i % slow)])
                .collect()
        };
        let table = Self {
            inverse: Operator::new(basis.inverse.as_ref()),
            matrix: Operator::new(basis.matrix.as_ref()),
            gains: [0, lanes].map(|from| (from..from + lanes).map(|j| seen[(0, j)]).collect()),
            polynomial,
            slow,
            powers: basis.powers.iter().map(flat).collect(),
            alpha: basis.alpha,
            nu: basis.nu,
            conditioning,
            ..Self::empty(generator)
        };
        Ok(table.completed(duration))
    }

    /// Nothing but what the generator gives at once.
    fn empty(generator: &Generator) -> Self {
        Self {
            inverse: Operator::new(Mat::zeros(0, 0).as_ref()),
            matrix: Operator::new(Mat::zeros(0, 0).as_ref()),
            alpha: Vec::new(),
            nu: Vec::new(),
            sizes: Vec::new(),
            growth: 0.0,
            gains: [Vec::new(), Vec::new()],
            polynomial: Vec::new(),
            slow: 0,
            powers: Vec::new(),
            curvature: generator.curvature(),
            whole: Factors::new(0, 0),
            conditioning: Conditioning {
                segment: 0,
                touching: false,
                condition: f64::NAN,
                reconstruction: f64::NAN,
            },
        }
    }

    /// With what follows from the rest, for cells of a length.
    fn completed(mut self, duration: f64) -> Self {
        let rates = self.alpha.iter().zip(&self.nu);
        self.sizes = rates.map(|(a, n)| a.hypot(*n)).collect();
        self.growth = self.alpha.iter().fold(0.0, |most: f64, a| most.max(*a));
        let mut whole = Factors::new(self.alpha.len(), self.slow);
        self.prepare(duration, &mut whole);
        self.whole = whole;
        self
    }

    /// Hands its numbers over.
    pub fn keep(&self, out: &mut Writer) {
        let terms = self.polynomial.len() / self.slow;
        let extents = [self.alpha.len(), self.slow, terms, self.powers.len()];
        out.push("extents", "1", &extents.map(|count| count as f64));
        let touching = f64::from(u8::from(self.conditioning.touching));
        out.push("touching", "1", &[touching]);
        out.push("condition", "1", &[self.conditioning.condition]);
        out.push("reconstruction", "1", &[self.conditioning.reconstruction]);
        out.push("inverse", "mixed", self.inverse.numbers());
        out.push("matrix", "mixed", self.matrix.numbers());
        out.push("growth", "1/s", &self.alpha);
        out.push("frequency", "rad/s", &self.nu);
        out.push("gain_real", "mixed", &self.gains[0]);
        out.push("gain_imaginary", "mixed", &self.gains[1]);
        out.push("polynomial", "mixed", &self.polynomial);
        for power in &self.powers {
            out.push("slow_powers", "mixed", power);
        }
    }

    /// The basis whose numbers were handed over, on cells of a class.
    pub fn read(
        kept: &mut Reader<'t>,
        generator: &Generator,
        cell_model: &CellModel<'_>,
        class: usize,
        touching: bool,
    ) -> Result<Self, DenseError> {
        const EXTENTS: &str = "extents";
        let d = cell_model.layout.dimension();
        let class = &cell_model.grid.classes[class];
        let lanes = kept.lanes(EXTENTS)?;
        let [slow, terms, powers] = [
            kept.count(EXTENTS)?,
            kept.count(EXTENTS)?,
            kept.count(EXTENTS)?,
        ];
        if slow < 2 || !(1..=POWERS + 1).contains(&terms) || !(1..=POWERS + 1).contains(&powers) {
            return Err(DenseError::Kept { name: EXTENTS });
        }
        let conditioning = Conditioning {
            segment: class.segment,
            touching,
            condition: kept.number("condition")?,
            reconstruction: kept.number("reconstruction")?,
        };
        conditioning.check()?;
        let length = 2 * lanes + slow;
        let mut operator = |name, rows, columns| {
            let numbers = kept.take(name, numbers_of(rows, columns))?;
            Operator::lent(numbers, rows, columns).ok_or(DenseError::Kept { name })
        };
        let table = Self {
            inverse: operator("inverse", length, d)?,
            matrix: operator("matrix", d, length)?,
            alpha: kept.take("growth", lanes)?.to_vec(),
            nu: kept.take("frequency", lanes)?.to_vec(),
            gains: [
                kept.take("gain_real", lanes)?.to_vec(),
                kept.take("gain_imaginary", lanes)?.to_vec(),
            ],
            polynomial: kept.take("polynomial", terms * slow)?.to_vec(),
            slow,
            powers: (0..powers)
                .map(|_| Ok(kept.take("slow_powers", slow * slow)?.to_vec()))
                .collect::<Result<_, DenseError>>()?,
            conditioning,
            ..Self::empty(generator)
        };
        Ok(table.completed(class.duration))
    }

    /// Factors over a time.
    pub fn prepare(&self, time: f64, factors: &mut Factors) {
        let lanes = self.alpha.len();
        waves::factors(
            [&self.alpha, &self.nu],
            time,
            &mut factors.cosine[..lanes],
            &mut factors.sine[..lanes],
        );
        let entries = self.slow * self.slow;
        factors.slow[..entries].fill(0.0);
        for power in self.powers.iter().rev() {
            for (entry, p) in factors.slow[..entries].iter_mut().zip(power) {
                *entry = *entry * time + p;
            }
        }
        factors.time = time;
    }

    /// Moves spectral coordinates in place.
    pub fn advance(&self, factors: &Factors, y: &mut [f64], spare: &mut [f64]) {
        let lanes = self.alpha.len();
        let (u, rest) = y.split_at_mut(lanes);
        let (v, rest) = rest.split_at_mut(lanes);
        waves::turn([&factors.cosine[..lanes], &factors.sine[..lanes]], u, v);
        let old = &mut spare[..self.slow];
        old.copy_from_slice(&rest[..self.slow]);
        let rows = factors.slow[..self.slow * self.slow].chunks_exact(self.slow);
        for (new, row) in rest.iter_mut().zip(rows) {
            *new = row.iter().zip(&*old).map(|(g, x)| g * x).sum();
        }
    }
}

/// The deflection of a stretch in closed form.
pub(super) struct Guard<'t> {
    pub table: &'t SpectralTable<'t>,
    pub amplitudes: [&'t [f64]; 2],
    pub polynomial: [f64; POWERS + 1],
    /// Powers of time in use.
    pub terms: usize,
}

impl Guard<'_> {
    /// δ, δ', δ'' at a time.
    pub fn at(&self, time: f64) -> [f64; 3] {
        let table = self.table;
        let [a, b, c] = waves::sum([&table.alpha, &table.nu], self.amplitudes, time);
        let [mut value, mut slope, mut half_curvature] = [0.0; 3];
        for q in self.polynomial[..self.terms].iter().rev() {
            half_curvature = half_curvature * time + slope;
            slope = slope * time + value;
            value = value * time + q;
        }
        [a + value, b + slope, c + 2.0 * half_curvature]
    }

    /// Bounds of the polynomial's first three derivatives up to a time.
    pub fn bounds(&self, time: f64) -> [f64; 3] {
        let mut bounds = [0.0; 3];
        for (order, bound) in bounds.iter_mut().enumerate() {
            for k in (order + 1..self.terms).rev() {
                let falling: usize = (k - order..=k).product();
                *bound = *bound * time + falling as f64 * self.polynomial[k].abs();
            }
        }
        bounds
    }
}
