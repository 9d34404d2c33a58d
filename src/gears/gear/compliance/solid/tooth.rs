//! A tooth above its root circle as an elastic solid with free ends, by Ritz's method.
//!
//! Each displacement is a product of two factors. In the section the factor is a polynomial of the plane
//! tooth ([`super::super::plate`]) of lower degree, also for displacements along the axis. Along the face the
//! factor is a polynomial of [`FaceIntegrals`]. Energy and foot extend those of the plane problem to three
//! dimensions. Lengths are in root radii, stresses in Young's moduli.

use super::axial::{FaceIntegrals, add_product, mirror};
use crate::gear::Tooth;
use crate::gear::compliance::plate::{Basis, Force, Part, Resolution, interior, legendre};
use crate::numerics::linalg;
use crate::numerics::quadrature::GaussLegendre;
use faer::Mat;

/// Number of traction polynomials on the foot in each of the three directions.
pub(super) const FOOT: usize = 4;

/// The resolution of the section; see the tests of its convergence.
const SECTION: Resolution = Resolution {
    degree_across: 4,
    degree_along: 6,
    foot_modes: FOOT,
    harmonics: 0.0,
};

/// Resolution of the quadrature rules, for products of two polynomials of [`SECTION`].
const INTERIOR: Resolution = Resolution {
    degree_across: 8,
    degree_along: 10,
    ..SECTION
};

/// A tooth reduced to its foot and its loads. Modes of the foot are numbered by direction (radial, tangential,
/// axial), polynomial and wave along the face; loads by their waves.
pub(super) struct SolidTooth {
    /// Stiffness of the tooth at its foot: tractions by rows, displacements of the foot by columns.
    pub stiffness: Mat<f64>,
    /// Forces on the clamped foot under unit waves of load on the flank. One matrix per load case: modes by
    /// rows, waves by columns.
    pub forces: Vec<Mat<f64>>,
    /// Forces on the clamped foot under unit waves of force that act where the lines of force cross the
    /// centre line.
    pub places: Vec<Mat<f64>>,
    /// Displacements on a clamped foot where the lines of force cross the centre line: waves of displacement
    /// by rows, waves of load on the flank by columns.
    pub clamped: Vec<Mat<f64>>,
}

/// A polynomial on the foot in one direction: 0 radial, 1 tangential, 2 axial.
#[derive(Clone, Copy)]
struct FootMode {
    direction: usize,
    degree: usize,
}

impl FootMode {
    /// Index of its first wave among all modes.
    fn first(self, axial: &FaceIntegrals) -> usize {
        let waves = axial.numbers.len();
        match self.direction {
            2 => 2 * FOOT * waves + self.degree * axial.axial_numbers.len(),
            direction => (direction * FOOT + self.degree) * waves,
        }
    }

    fn waves(self, axial: &FaceIntegrals) -> &Mat<f64> {
        match self.direction {
            2 => &axial.axial_loads,
            _ => &axial.loads,
        }
    }
}

/// Number of modes of a foot.
pub(super) fn modes(axial: &FaceIntegrals) -> usize {
    FOOT * (2 * axial.numbers.len() + axial.axial_numbers.len())
}

impl SolidTooth {
    /// The tooth with a Poisson's ratio, loaded at roll angles of its involute. `None` if the numbers are not finite.
    pub fn new(
        tooth: &Tooth,
        poisson_ratio: f64,
        rolls: &[f64],
        axial: &FaceIntegrals,
    ) -> Option<Self> {
        let basis = Basis::new(tooth, &SECTION);
        let points = interior(tooth, &INTERIOR);
        let forces: Vec<Force> = rolls.iter().map(|&roll| Force::at(tooth, roll)).collect();
        let (modes, waves) = (modes(axial), axial.numbers.len());
        let mut solid = Self {
            stiffness: Mat::zeros(modes, modes),
            forces: vec![Mat::zeros(modes, waves); rolls.len()],
            places: vec![Mat::zeros(modes, waves); rolls.len()],
            clamped: vec![Mat::zeros(waves, waves); rolls.len()],
        };
        for symmetric in [false, true] {
            let part = Part {
                basis: &basis,
                symmetric,
            };
            solid.add(&part, tooth, poisson_ratio, &points, &forces, axial)?;
        }
        Some(solid)
    }

    /// Adds the part that is odd or even about the centre line, as in the plane. K is the stiffness and B the work of
    /// the foot's modes. With `A = (K + Bᵀ B)⁻¹` and `C = B A Bᵀ` the stiffness of the foot is `C⁻¹ − 1`. The forces of
    /// a load f on the foot are `C⁻¹ B A f`.
    fn add(
        &mut self,
        part: &Part,
        tooth: &Tooth,
        poisson_ratio: f64,
        points: &[[f64; 3]],
        forces: &[Force],
        axial: &FaceIntegrals,
    ) -> Option<()> {
        let (foot, rows) = foot(part, tooth, axial);
        let mut stiffness = stiffness(part, poisson_ratio, points, axial);
        stiffness += linalg::product(foot.transpose(), foot.as_ref());
        let lower = linalg::cholesky(&stiffness)?;
        let (columns, waves, freedoms) = (rows.len(), axial.numbers.len(), stiffness.nrows());
        let loads = forces.len() * waves;
        let mut solved = Mat::zeros(freedoms, columns + 2 * loads);
        for column in 0..columns {
            for row in 0..freedoms {
                solved[(row, column)] = foot[(column, row)];
            }
        }
        for (index, force) in forces.iter().enumerate() {
            let on_flank = part.work(force.flank, force.direction);
            let on_centre = part.work_on_centre_line(force.height, force.direction);
            for (work, first) in [(on_flank, columns), (on_centre, columns + loads)] {
                let work = Mat::from_fn(work.len(), 1, |row, _| work[row]);
                let at = [0, first + index * waves];
                add_product(&mut solved, at, &work, &axial.loads, 1.0);
            }
        }
        linalg::solve_lower(&lower, &mut solved);
        let at_foot = solved.as_ref().subcols(0, columns);
        let flexibility = linalg::product(at_foot.transpose(), at_foot);
        let root = linalg::cholesky(&flexibility)?;
        let mut inverse = Mat::identity(columns, columns);
        linalg::solve_lower(&root, &mut inverse);
        linalg::solve_upper(&root, &mut inverse);
        for (i, &row) in rows.iter().enumerate() {
            for (j, &column) in rows.iter().enumerate() {
                let unit = if i == j { 1.0 } else { 0.0 };
                self.stiffness[(row, column)] = 0.5 * (inverse[(i, j)] + inverse[(j, i)]) - unit;
            }
        }
        for index in 0..forces.len() {
            let at = |first: usize| solved.as_ref().subcols(first + index * waves, waves);
            let (load, place) = (at(columns), at(columns + loads));
            let moved = linalg::product(at_foot.transpose(), load);
            let place_moved = linalg::product(at_foot.transpose(), place);
            let foot_displacement = linalg::product(inverse.as_ref(), moved.as_ref());
            let held_place = linalg::product(inverse.as_ref(), place_moved.as_ref());
            for (i, &row) in rows.iter().enumerate() {
                for wave in 0..waves {
                    self.forces[index][(row, wave)] = foot_displacement[(i, wave)];
                    self.places[index][(row, wave)] = held_place[(i, wave)];
                }
            }
            self.clamped[index] += linalg::product(place.transpose(), load)
                - linalg::product(place_moved.transpose(), foot_displacement.as_ref());
        }
        Some(())
    }
}

/// Integrals over the foot of products of its modes and the displacements, and the indices of these modes.
fn foot(part: &Part, tooth: &Tooth, axial: &FaceIntegrals) -> (Mat<f64>, Vec<usize>) {
    let half_angle = tooth.root_half_angle;
    // The axial polynomials have the parity of the radial ones.
    let plane = part.modes(FOOT);
    let of = |direction: usize| move |degree: usize| FootMode { direction, degree };
    let radial = || plane.iter().copied().filter(|mode| *mode < FOOT);
    let tangential = plane
        .iter()
        .copied()
        .filter_map(|mode| mode.checked_sub(FOOT));
    let modes: Vec<FootMode> = (radial().map(of(0)))
        .chain(tangential.map(of(1)))
        .chain(radial().map(of(2)))
        .collect();
    let [along_x, others] = [0, 1].map(|component| part.products(component).count());
    let in_plane_displacements = along_x + others;
    let rule = GaussLegendre::new(SECTION.degree_across + FOOT + 4);
    let mut sections: Vec<Mat<f64>> = (modes.iter())
        .map(|mode| {
            Mat::zeros(
                if mode.direction == 2 { others } else { in_plane_displacements },
                1,
            )
        })
        .collect();
    for (place, weight) in rule.nodes.iter().zip(&rule.weights) {
        let (sin, cos) = (place * half_angle).sin_cos();
        let polynomials = legendre(*place, FOOT);
        let radial = part.work([sin, cos], [sin, cos]);
        let tangential = part.work([sin, cos], [cos, -sin]);
        let upright = part.work([sin, cos], [0.0, 1.0]);
        for (mode, section) in modes.iter().zip(&mut sections) {
            let moved = [&radial[..], &tangential, &upright[along_x..]][mode.direction];
            let scale = weight * ((mode.degree as f64 + 0.5) * half_angle).sqrt();
            for (row, moved) in moved.iter().enumerate() {
                section[(row, 0)] += scale * polynomials[mode.degree][0] * moved;
            }
        }
    }
    let rows: Vec<usize> = (modes.iter())
        .flat_map(|mode| {
            let first = mode.first(axial);
            first..first + mode.waves(axial).ncols()
        })
        .collect();
    let freedoms =
        in_plane_displacements * axial.loads.nrows() + others * axial.axial_loads.nrows();
    // Built with modes by columns, so that `add_product` takes sections and waves untransposed.
    let mut foot = Mat::zeros(freedoms, rows.len());
    let mut column = 0;
    for (mode, section) in modes.iter().zip(&sections) {
        let first = match mode.direction {
            2 => in_plane_displacements * axial.loads.nrows(),
            _ => 0,
        };
        add_product(&mut foot, [first, column], section, mode.waves(axial), 1.0);
        column += mode.waves(axial).ncols();
    }
    (foot.transpose().to_owned(), rows)
}

/// Stiffness of the solid, free to float: twice the energy is
/// `∫ (λ (εx + εy + εz)² + 2 G (εx² + εy² + εz²) + G (γxy² + γxz² + γyz²)) dV`.
fn stiffness(
    part: &Part,
    poisson_ratio: f64,
    points: &[[f64; 3]],
    axial: &FaceIntegrals,
) -> Mat<f64> {
    let [shear, lame] = moduli(poisson_ratio);
    // Polynomials of the displacements along x, and of those along y and z, at the points: values and
    // derivatives by x and y.
    let samples = [0, 1].map(|component| {
        let count = part.products(component).count();
        let mut samples = [0; 3].map(|_| Mat::<f64>::zeros(count, points.len()));
        for (point, &[x, y, weight]) in points.iter().enumerate() {
            let values = part.basis.at([x, y]);
            let scale = weight.sqrt();
            for (row, (i, j)) in part.products(component).enumerate() {
                let [by_x, by_y] = values.gradient(i, j);
                samples[0][(row, point)] = scale * values.value(i, j);
                samples[1][(row, point)] = scale * by_x;
                samples[2][(row, point)] = scale * by_y;
            }
        }
        samples
    });
    let [u, v] = &samples;
    let integral =
        |one: &Mat<f64>, other: &Mat<f64>| linalg::product(one.as_ref(), other.transpose());
    let stiff = lame + 2.0 * shear;
    let (x, y) = (0, u[0].nrows() * axial.mass.nrows());
    let z = y + v[0].nrows() * axial.mass.nrows();
    let freedoms = z + v[0].nrows() * axial.axial_mass.nrows();
    let mut out = Mat::zeros(freedoms, freedoms);
    let mut add = |at: [usize; 2], one: &Mat<f64>, other: &Mat<f64>, face: &Mat<f64>, modulus| {
        add_product(&mut out, at, &integral(one, other), face, modulus);
    };
    add([x, x], &u[1], &u[1], &axial.mass, stiff);
    add([x, x], &u[2], &u[2], &axial.mass, shear);
    add([x, x], &u[0], &u[0], &axial.shear, shear);
    add([y, y], &v[2], &v[2], &axial.mass, stiff);
    add([y, y], &v[1], &v[1], &axial.mass, shear);
    add([y, y], &v[0], &v[0], &axial.shear, shear);
    add([z, z], &v[0], &v[0], &axial.stretch, stiff);
    add([z, z], &v[1], &v[1], &axial.axial_mass, shear);
    add([z, z], &v[2], &v[2], &axial.axial_mass, shear);
    add([y, x], &v[2], &u[1], &axial.mass, lame);
    add([y, x], &v[1], &u[2], &axial.mass, shear);
    add([z, x], &v[0], &u[1], &axial.mixed, lame);
    add([z, x], &v[1], &u[0], &axial.crossed, shear);
    add([z, y], &v[0], &v[2], &axial.mixed, lame);
    add([z, y], &v[2], &v[0], &axial.crossed, shear);
    mirror(&mut out);
    out
}

/// Shear modulus and Lamé's first constant, in Young's moduli.
pub(super) fn moduli(poisson_ratio: f64) -> [f64; 2] {
    let nu = poisson_ratio;
    [0.5 / (1.0 + nu), nu / ((1.0 + nu) * (1.0 - 2.0 * nu))]
}
