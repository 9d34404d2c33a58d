//! Gauss collocation: one step of an implicit Runge–Kutta method of order 2s.
//!
//! ```text
//! K_i = f(t + c_i h, y + h Σ a_ij K_j),     y⁺ = y + h Σ b_i K_i
//! ```
//!
//! `c` are the zeros of the shifted Legendre polynomial, `a_ij = ∫₀^{c_i} ℓ_j`, `b_i = ∫₀¹ ℓ_i`
//! (Hairer, Lubich & Wanner, Geometric Numerical Integration, II.1.3). All weights are
//! positive and all coefficients below one, so round-off is not amplified. The stages are
//! found by fixed-point sweeps: with L the rate of the system, sweep m leaves an error of
//! about `(L h)^{m+2}/(m+2)!`, and the caller keeps `L h ≤ 1`.

/// Number of fixed-point sweeps per step. At `L h = 1` the error after them is 1/22! = 9·10⁻²². 18 sweeps
/// would be enough.
const SWEEPS: usize = 20;

/// Nodes and coefficients of an s-stage rule.
#[derive(Debug, Clone)]
pub(super) struct GaussRule {
    /// Nodes c in (0, 1).
    pub nodes: Vec<f64>,
    /// Weights b.
    pub weights: Vec<f64>,
    /// Coefficients a, row by row.
    coefficients: Vec<f64>,
}

impl GaussRule {
    /// The rule with `stages` stages.
    pub fn new(stages: usize) -> Self {
        let mut nodes = Vec::with_capacity(stages);
        let mut weights = Vec::with_capacity(stages);
        for i in 0..stages {
            // Zeros of P_s in descending order from the usual cosine guess.
            let mut x = (std::f64::consts::PI * (i as f64 + 0.75) / (stages as f64 + 0.5)).cos();
            // Newton's method converges within five steps from this guess. Three more leave a margin.
            for _ in 0..8 {
                let (value, slope) = legendre(stages, x);
                x -= value / slope;
            }
            let (_, slope) = legendre(stages, x);
            nodes.push(0.5 * (1.0 - x));
            weights.push(1.0 / ((1.0 - x * x) * slope * slope));
        }
        let mut coefficients = Vec::with_capacity(stages * stages);
        for &c in &nodes {
            for j in 0..stages {
                // ℓ_j has degree s − 1, so that the rule itself, scaled to [0, c], is exact.
                let sum: f64 = nodes
                    .iter()
                    .zip(&weights)
                    .map(|(&m, &b)| b * lagrange(&nodes, j, c * m))
                    .sum();
                coefficients.push(c * sum);
            }
        }
        Self {
            nodes,
            weights,
            coefficients,
        }
    }

    /// Number of stages s.
    pub fn stages(&self) -> usize {
        self.nodes.len()
    }

    /// Solves the stages of a step of length `h` from `start`. Afterwards `work` contains the stage states
    /// `start + h Σ a_ij K_j` and the stage slopes K_i, both s × n.
    ///
    /// `derivative(fraction, state, out)` is the vector field at a fraction of the step.
    pub fn solve(
        &self,
        start: &[f64],
        h: f64,
        work: &mut StageWork,
        mut derivative: impl FnMut(f64, &[f64], &mut [f64]),
    ) {
        let n = start.len();
        let s = self.stages();
        derivative(0.0, start, &mut work.slopes[..n]);
        for i in 1..s {
            work.slopes.copy_within(..n, i * n);
        }
        for _ in 0..SWEEPS {
            for i in 0..s {
                let stage = &mut work.states[i * n..(i + 1) * n];
                stage.fill(0.0);
                for j in 0..s {
                    let a = h * self.coefficients[i * s + j];
                    let slope = &work.slopes[j * n..(j + 1) * n];
                    for (value, k) in stage.iter_mut().zip(slope) {
                        *value += a * k;
                    }
                }
                for (value, y) in stage.iter_mut().zip(start) {
                    *value += y;
                }
            }
            for i in 0..s {
                derivative(
                    self.nodes[i],
                    &work.states[i * n..(i + 1) * n],
                    &mut work.slopes[i * n..(i + 1) * n],
                );
            }
        }
    }

    /// The increment `h Σ b_i K_i` of component `component` after [`Self::solve`].
    pub fn increment(&self, work: &StageWork, h: f64, component: usize) -> f64 {
        let n = work.slopes.len() / self.stages();
        let sum: f64 = self
            .weights
            .iter()
            .enumerate()
            .map(|(i, b)| b * work.slopes[i * n + component])
            .sum();
        h * sum
    }
}

/// Stage values of one step, s × n.
#[derive(Debug, Clone)]
pub(super) struct StageWork {
    /// Stage states Y.
    pub states: Vec<f64>,
    /// Stage slopes K.
    slopes: Vec<f64>,
}

impl StageWork {
    /// Stage values for a rule with `stages` stages and a state of length `n`.
    pub fn new(stages: usize, n: usize) -> Self {
        Self {
            states: vec![0.0; stages * n],
            slopes: vec![0.0; stages * n],
        }
    }
}

/// A state as a compensated sum (Kahan 1965): its value, and the accumulated round-off.
#[derive(Debug, Clone)]
pub(super) struct Compensated {
    /// The value.
    pub value: Vec<f64>,
    /// The round-off of the value.
    rest: Vec<f64>,
}

impl Compensated {
    /// An exact value.
    pub fn new(value: Vec<f64>) -> Self {
        let rest = vec![0.0; value.len()];
        Self { value, rest }
    }

    /// Adds to one component.
    pub fn add(&mut self, component: usize, increment: f64) {
        let increment = increment + self.rest[component];
        let old = self.value[component];
        let new = old + increment;
        // Knuth's two-sum is exact for summands of any size.
        let back = new - old;
        self.rest[component] = (old - (new - back)) + (increment - back);
        self.value[component] = new;
    }

    /// Copies another state of the same length.
    pub fn copy_from(&mut self, other: &Self) {
        self.value.copy_from_slice(&other.value);
        self.rest.copy_from_slice(&other.rest);
    }
}

/// `(P_n, P_n')` at x.
fn legendre(n: usize, x: f64) -> (f64, f64) {
    let (mut before, mut value) = (1.0, x);
    for k in 2..=n {
        let k = k as f64;
        let next = ((2.0 * k - 1.0) * x * value - (k - 1.0) * before) / k;
        before = value;
        value = next;
    }
    (value, n as f64 * (x * value - before) / (x * x - 1.0))
}

/// `ℓ_j(x)` on the given nodes.
fn lagrange(nodes: &[f64], j: usize, x: f64) -> f64 {
    (0..nodes.len())
        .filter(|&m| m != j)
        .map(|m| (x - nodes[m]) / (nodes[j] - nodes[m]))
        .product()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rule_integrates_powers_to_its_degree() {
        for s in [2, 3, 8] {
            let rule = GaussRule::new(s);
            for power in 0..2 * s {
                let sum: f64 = (0..s)
                    .map(|i| rule.weights[i] * rule.nodes[i].powi(power as i32))
                    .sum();
                assert!((sum - 1.0 / (power as f64 + 1.0)).abs() < 1e-15);
            }
            // Σ_j a_ij c_j^q = c_i^{q+1}/(q+1) for q < s: the stage order.
            for i in 0..s {
                for q in 0..s as i32 {
                    let sum: f64 = (0..s)
                        .map(|j| rule.coefficients[i * s + j] * rule.nodes[j].powi(q))
                        .sum();
                    let exact = rule.nodes[i].powi(q + 1) / f64::from(q + 1);
                    assert!((sum - exact).abs() < 1e-15);
                }
            }
        }
    }

    /// Error of the unit oscillator after one period in `steps` steps.
    fn error(stages: usize, steps: usize) -> f64 {
        let rule = GaussRule::new(stages);
        let mut work = StageWork::new(stages, 2);
        let mut y = Compensated::new(vec![1.0, 0.0]);
        let h = std::f64::consts::TAU / steps as f64;
        for _ in 0..steps {
            rule.solve(&y.value, h, &mut work, |_, y, out| {
                out[0] = y[1];
                out[1] = -y[0];
            });
            for i in 0..2 {
                y.add(i, rule.increment(&work, h, i));
            }
        }
        (y.value[0] - 1.0).hypot(y.value[1])
    }

    #[test]
    fn observed_order_is_twice_the_stages() {
        for stages in [1, 2, 3] {
            let order = (error(stages, 20) / error(stages, 40)).log2();
            assert!((order - 2.0 * stages as f64).abs() < 0.05, "{order}");
        }
        // Eight stages are at round-off with a unit step.
        assert!(error(8, 7) < 2e-15, "{:e}", error(8, 7));
    }

    #[test]
    fn compensation_keeps_what_plain_sums_lose() {
        let mut sum = Compensated::new(vec![1.0]);
        let mut plain = 1.0;
        for _ in 0..1_000_000 {
            sum.add(0, 1e-17);
            plain += 1e-17;
        }
        assert_eq!(plain, 1.0);
        assert!((sum.value[0] - 1.0 - 1e-11).abs() < 3e-16);
    }
}
