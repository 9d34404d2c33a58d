//! A tooth above its root circle as an elastic plate, by Ritz's method.
//!
//! The plate reaches from the foot, the arc of the root circle between the ends of the fillets, to
//! the tip circle. Its displacements are products of Legendre polynomials of ξ = x/w(y) and of the
//! height y, with w the half thickness of a straight taper close to the tooth's. The taper keeps the
//! products from becoming nearly dependent; the boundary of the plate is the true profile. The
//! products contain every rigid motion and every uniform strain.
//!
//! Tractions of the foot are sums of Legendre polynomials of its angle, radial and tangential. The
//! fillets end tangent to the root circle, so the body has no corner there and the
//! tractions vanish at the foot's ends: few terms are enough.
//!
//! Lengths are in root radii and stresses in Young's moduli, so compliances come out times E
//! per unit width. Parts even and odd about the centre line are solved separately.

use crate::gear::Tooth;
use crate::numerics::linalg;
use crate::numerics::quadrature::GaussLegendre;
use faer::Mat;

/// How finely a gear is resolved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Resolution {
    /// Degree of the plate's polynomials across the tooth.
    pub degree_across: usize,
    /// Degree of the plate's polynomials along the tooth.
    pub degree_along: usize,
    /// Number of polynomials of the traction on the foot per direction: an even number, at most 24.
    pub foot_modes: usize,
    /// Highest harmonic of the ring, times the half angle of the foot.
    pub harmonics: f64,
}

/// A taper narrower than this part of its foot would make the polynomials of a pointed tooth
/// steep.
const LEAST_TAPER: f64 = 0.25;

/// A plate reduced to its foot and its loads. Modes of the foot are numbered radial first, by
/// degree; the polynomials are orthonormal in the angle.
pub(super) struct Plate {
    /// Stiffness of the plate at its foot: tractions by rows, displacements of the foot by columns.
    pub stiffness: Mat<f64>,
    /// Forces on the body below the clamped foot under a unit force on the flank, mode by mode, for each
    /// load.
    pub forces: Vec<Vec<f64>>,
    /// Displacements along the force by unit displacements of the foot, at the point where the line of force crosses
    /// the centre line. They equal the forces on the foot of a unit force at this point.
    pub places: Vec<Vec<f64>>,
    /// Displacement at the same point by a unit force on the flank, with the foot clamped.
    pub clamped: Vec<f64>,
}

/// A unit force on a flank: its point of action, the height at which its line crosses the tooth's
/// centre line, and its direction.
#[derive(Debug, Clone, Copy)]
pub(super) struct Force {
    pub flank: [f64; 2],
    pub height: f64,
    pub direction: [f64; 2],
}

impl Force {
    pub fn at(tooth: &Tooth, roll: f64) -> Self {
        let point = tooth.flank(roll);
        let (sin, cos) = tooth.force_angle(roll).sin_cos();
        let unit = tooth.root_radius.abs();
        Self {
            flank: [point.x / unit, point.y / unit],
            height: tooth.base_radius.abs() / cos / unit,
            direction: [-cos, -(tooth.sense() * sin)],
        }
    }
}

impl Plate {
    /// The plate of a tooth with a Poisson's ratio (of plane stress), loaded at the roll angles of its involute.
    /// `None` if the numbers are not finite.
    pub fn new(
        tooth: &Tooth,
        poisson_ratio: f64,
        rolls: &[f64],
        resolution: &Resolution,
    ) -> Option<Self> {
        let basis = Basis::new(tooth, resolution);
        let points = interior(tooth, resolution);
        let forces: Vec<Force> = rolls.iter().map(|&roll| Force::at(tooth, roll)).collect();
        let modes = resolution.foot_modes;
        let mut plate = Self {
            stiffness: Mat::zeros(2 * modes, 2 * modes),
            forces: vec![vec![0.0; 2 * modes]; rolls.len()],
            places: vec![vec![0.0; 2 * modes]; rolls.len()],
            clamped: vec![0.0; rolls.len()],
        };
        for symmetric in [false, true] {
            let part = Part {
                basis: &basis,
                symmetric,
            };
            plate.add(&part, tooth, poisson_ratio, &points, &forces, resolution)?;
        }
        Some(plate)
    }

    /// Adds the part that is odd or even about the centre line.
    ///
    /// K is the stiffness, B the work of the foot's modes at the displacements a, and f a load. With the tractions q
    /// and displacements U of the foot `K a = f − Bᵀ q`, `B a = U`. K is singular (the plate floats), but
    /// `A = (K + Bᵀ B)⁻¹` exists. With `C = B A Bᵀ` the solution is `q = C⁻¹ B A f − (C⁻¹ − 1) U`,
    /// `a = (A − A Bᵀ C⁻¹ B A) f + A Bᵀ C⁻¹ U`.
    fn add(
        &mut self,
        part: &Part,
        tooth: &Tooth,
        poisson_ratio: f64,
        points: &[[f64; 3]],
        forces: &[Force],
        resolution: &Resolution,
    ) -> Option<()> {
        let modes = part.modes(resolution.foot_modes);
        let foot = part.foot(tooth, &modes, resolution);
        let mut stiffness = part.stiffness(poisson_ratio, points);
        stiffness += linalg::product(foot.transpose(), foot.as_ref());
        let lower = linalg::cholesky(&stiffness)?;
        let columns = modes.len();
        let count = forces.len();
        // L⁻¹ times three groups of columns: Bᵀ, the loads, and the points whose displacement is computed.
        let mut solved = Mat::zeros(part.freedoms(), columns + 2 * count);
        for column in 0..columns {
            for row in 0..part.freedoms() {
                solved[(row, column)] = foot[(column, row)];
            }
        }
        for (index, force) in forces.iter().enumerate() {
            let on_flank = part.work(force.flank, force.direction);
            let on_centre = part.work_on_centre_line(force.height, force.direction);
            for row in 0..part.freedoms() {
                solved[(row, columns + index)] = on_flank[row];
                solved[(row, columns + count + index)] = on_centre[row];
            }
        }
        linalg::solve_lower(&lower, &mut solved);
        let at_foot = solved.as_ref().subcols(0, columns);
        let loads = solved.as_ref().subcols(columns, count);
        let places = solved.as_ref().subcols(columns + count, count);
        let flexibility = linalg::product(at_foot.transpose(), at_foot);
        let root = linalg::cholesky(&flexibility)?;
        let mut inverse = Mat::identity(columns, columns);
        linalg::solve_lower(&root, &mut inverse);
        linalg::solve_upper(&root, &mut inverse);
        let load_moves = linalg::product(at_foot.transpose(), loads);
        let place_moves = linalg::product(at_foot.transpose(), places);
        let foot_displacement = linalg::product(inverse.as_ref(), load_moves.as_ref());
        let held_place = linalg::product(inverse.as_ref(), place_moves.as_ref());
        for (i, &row) in modes.iter().enumerate() {
            for (j, &column) in modes.iter().enumerate() {
                let unit = if i == j { 1.0 } else { 0.0 };
                self.stiffness[(row, column)] = 0.5 * (inverse[(i, j)] + inverse[(j, i)]) - unit;
            }
        }
        for index in 0..count {
            for (i, &row) in modes.iter().enumerate() {
                self.forces[index][row] = foot_displacement[(i, index)];
                self.places[index][row] = held_place[(i, index)];
            }
            let free: f64 = (0..part.freedoms())
                .map(|row| places[(row, index)] * loads[(row, index)])
                .sum();
            let by_foot: f64 = (0..columns)
                .map(|i| place_moves[(i, index)] * foot_displacement[(i, index)])
                .sum();
            self.clamped[index] += free - by_foot;
        }
        Some(())
    }
}

/// The polynomials of a plate.
pub(super) struct Basis {
    across: usize,
    along: usize,
    /// Middle and half length of the range of heights.
    height: [f64; 2],
    /// Half thickness of the taper in the middle, and its increase from there to the tip.
    taper: [f64; 2],
    /// Direction in which the tooth points: 1 outwards, -1 towards the axis.
    sense: f64,
}

/// Values of the polynomials at a point with their derivatives by x and y.
pub(super) struct Values {
    across: Vec<[f64; 2]>,
    along: Vec<[f64; 2]>,
    /// ∂ξ/∂x, ∂ξ/∂y and dη/dy.
    slopes: [f64; 3],
}

impl Values {
    /// Value of a product.
    pub fn value(&self, i: usize, j: usize) -> f64 {
        self.across[i][0] * self.along[j][0]
    }

    /// Derivatives of a product by x and y.
    pub fn gradient(&self, i: usize, j: usize) -> [f64; 2] {
        let ([value, slope], [high, rise]) = (self.across[i], self.along[j]);
        let [by_x, by_y, up] = self.slopes;
        [slope * by_x * high, slope * by_y * high + value * rise * up]
    }
}

impl Basis {
    pub fn new(tooth: &Tooth, resolution: &Resolution) -> Self {
        let (unit, sense) = (tooth.root_radius.abs(), tooth.sense());
        let (foot, ends) = tooth.root_half_angle.sin_cos();
        // The foot of an inner tooth is highest in its middle.
        let low = if sense > 0.0 { ends } else { 1.0 };
        let tip = tooth.flank(tooth.tip_roll);
        let top = tooth.tip_radius.abs() / unit;
        let narrow = (tip.x / unit).max(LEAST_TAPER * foot);
        Self {
            across: resolution.degree_across,
            along: resolution.degree_along,
            height: [0.5 * (top + low), 0.5 * (top - low)],
            taper: [0.5 * (narrow + foot), 0.5 * (narrow - foot)],
            sense,
        }
    }

    pub fn at(&self, [x, y]: [f64; 2]) -> Values {
        let [middle, half] = self.height;
        let eta = (y - middle) / half;
        let width = self.taper[0] + self.taper[1] * eta;
        let xi = x / width;
        Values {
            across: legendre(xi, self.across),
            along: legendre(eta, self.along),
            slopes: [
                1.0 / width,
                -xi * self.taper[1] / (half * width),
                1.0 / half,
            ],
        }
    }
}

/// Legendre polynomials up to a degree with their derivatives.
pub(super) fn legendre(x: f64, degree: usize) -> Vec<[f64; 2]> {
    let mut all = vec![[1.0, 0.0], [x, 1.0]];
    for n in 1..degree {
        let k = n as f64;
        let ([value, _], [before, slope_before]) = (all[n], all[n - 1]);
        all.push([
            ((2.0 * k + 1.0) * x * value - k * before) / (k + 1.0),
            slope_before + (2.0 * k + 1.0) * value,
        ]);
    }
    all.truncate(degree + 1);
    all
}

/// The displacements that are mirror images about the centre line (as of the radial part of a force), or
/// those with the opposite sign.
pub(super) struct Part<'a> {
    pub basis: &'a Basis,
    pub symmetric: bool,
}

impl Part<'_> {
    /// Degrees across and along the tooth of every product in the displacements along x (component 0) or y
    /// (1).
    pub fn products(&self, component: usize) -> impl Iterator<Item = (usize, usize)> {
        let parity = usize::from(self.symmetric) ^ component;
        let along = self.basis.along;
        (parity..=self.basis.across)
            .step_by(2)
            .flat_map(move |i| (0..=along).map(move |j| (i, j)))
    }

    fn freedoms(&self) -> usize {
        (self.basis.across + 1) * (self.basis.along + 1)
    }

    /// The modes of the foot in this part, of `count` in either direction.
    pub fn modes(&self, count: usize) -> Vec<usize> {
        let parity = usize::from(self.symmetric);
        let radial = (1 - parity..count).step_by(2);
        radial
            .chain((parity..count).step_by(2).map(|m| count + m))
            .collect()
    }

    /// Work of a unit force at a place and in a direction, on each of [`Self::products`].
    pub fn work(&self, place: [f64; 2], direction: [f64; 2]) -> Vec<f64> {
        let values = self.basis.at(place);
        (0..2)
            .flat_map(|component| {
                let values = &values;
                self.products(component)
                    .map(move |(i, j)| direction[component] * values.value(i, j))
            })
            .collect()
    }

    /// As [`Self::work`], at a height on the centre line. Below the foot the displacement is extrapolated by its
    /// change up to the same height above the foot. Polynomials diverge fast below the foot, and their slope there is
    /// less accurate than their values.
    pub fn work_on_centre_line(&self, height: f64, direction: [f64; 2]) -> Vec<f64> {
        let depth = 1.0 - height;
        if self.basis.sense * depth <= 0.0 {
            return self.work([0.0, height], direction);
        }
        let at_foot = self.work([0.0, 1.0], direction);
        let above = self.work([0.0, 1.0 + depth], direction);
        (at_foot.iter().zip(above))
            .map(|(at_foot, above)| 2.0 * at_foot - above)
            .collect()
    }

    /// Stiffness of the plate, free to float: twice the energy of displacements is
    /// `∫ (εx² + 2 ν εx εy + εy² + ½ (1 − ν) γ²) dA/(1 − ν²)`.
    fn stiffness(&self, poisson_ratio: f64, points: &[[f64; 3]]) -> Mat<f64> {
        let shear = (0.5 * (1.0 - poisson_ratio)).sqrt();
        let energy = 1.0 / (1.0 - poisson_ratio * poisson_ratio);
        // Normal strains at the points, then shear strains, of the displacements along x and y.
        let mut strains =
            [0, 1].map(|component| Mat::zeros(self.products(component).count(), 2 * points.len()));
        for (index, &[x, y, weight]) in points.iter().enumerate() {
            let values = self.basis.at([x, y]);
            let scale = (weight * energy).sqrt();
            for (component, strains) in strains.iter_mut().enumerate() {
                for (row, (i, j)) in self.products(component).enumerate() {
                    let gradient = values.gradient(i, j);
                    strains[(row, index)] = scale * gradient[component];
                    strains[(row, points.len() + index)] = scale * shear * gradient[1 - component];
                }
            }
        }
        let [along_x, along_y] = &strains;
        let mut contracted = along_y.clone();
        for index in 0..points.len() {
            for row in 0..contracted.nrows() {
                contracted[(row, index)] *= poisson_ratio;
            }
        }
        let squares =
            [along_x, along_y].map(|part| linalg::product(part.as_ref(), part.transpose()));
        let cross = linalg::product(contracted.as_ref(), along_x.transpose());
        let first = along_x.nrows();
        Mat::from_fn(self.freedoms(), self.freedoms(), |i, j| {
            match (i < first, j < first) {
                (true, true) => squares[0][(i, j)],
                (false, true) => cross[(i - first, j)],
                (true, false) => cross[(j - first, i)],
                (false, false) => squares[1][(i - first, j - first)],
            }
        })
    }

    /// Integrals over the foot of products of its modes and the displacements.
    fn foot(&self, tooth: &Tooth, modes: &[usize], resolution: &Resolution) -> Mat<f64> {
        let half_angle = tooth.root_half_angle;
        let rule = GaussLegendre::new(resolution.degree_across + resolution.foot_modes + 4);
        let mut foot = Mat::zeros(modes.len(), self.freedoms());
        for (place, weight) in rule.nodes.iter().zip(&rule.weights) {
            let (sin, cos) = (place * half_angle).sin_cos();
            let polynomials = legendre(*place, resolution.foot_modes);
            let radial = self.work([sin, cos], [sin, cos]);
            let tangential = self.work([sin, cos], [cos, -sin]);
            for (row, &mode) in modes.iter().enumerate() {
                let (degree, moved) = match mode.checked_sub(resolution.foot_modes) {
                    None => (mode, &radial),
                    Some(degree) => (degree, &tangential),
                };
                // The factor that makes the mode orthonormal in the angle, times the angle per unit of `place`.
                let scale = weight * ((degree as f64 + 0.5) * half_angle).sqrt();
                for (column, moved) in moved.iter().enumerate() {
                    foot[(row, column)] += scale * polynomials[degree][0] * moved;
                }
            }
        }
        foot
    }
}

/// Quadrature points `[x, y, weight]` on half the plate, with double weight. Along the tooth the variable is the
/// parameter of fillet or involute, across the tooth the angle about the gear's axis.
pub(super) fn interior(tooth: &Tooth, resolution: &Resolution) -> Vec<[f64; 3]> {
    let unit = tooth.root_radius.abs();
    let across = GaussLegendre::new(resolution.degree_across + 1);
    let [joint, root] = tooth.fillet_range();
    let curves = [
        (root, joint, true),
        (tooth.form_roll, tooth.tip_roll, false),
    ];
    let mut points = Vec::new();
    for (from, to, fillet) in curves {
        let rule = GaussLegendre::new(if fillet {
            3 * resolution.degree_along / 4
        } else {
            resolution.degree_along + 6
        });
        for (node, weight) in rule.nodes.iter().zip(&rule.weights) {
            let parameter = 0.5 * (from + to) + 0.5 * (to - from) * node;
            let point = if fillet { tooth.fillet(parameter) } else { tooth.flank(parameter) };
            let radius = point.x.hypot(point.y);
            let angle = point.x.atan2(point.y);
            let rise = tooth.sense() * (point.x * point.dx + point.y * point.dy) / radius;
            let area = radius * angle * rise * 0.5 * (to - from) * weight / (unit * unit);
            for (place, across) in across.nodes.iter().zip(&across.weights) {
                let share = 0.5 * (1.0 + place);
                let (sin, cos) = (share * angle).sin_cos();
                points.push([radius * sin / unit, radius * cos / unit, area * across]);
            }
        }
    }
    points
}

#[cfg(test)]
#[path = "plate_tests.rs"]
mod tests;
