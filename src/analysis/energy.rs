//! Does the energy balance close?
//!
//! Over any stretch, with u the modal velocities,
//!
//! ```text
//! Δ(½Σ(v² + ω²q²) + ½k(δ − s b)²) = ∫ T·u dt                   torques
//!     − ∫ F e' dt − ∫ F s b' dt                               transmission error, half gap
//!     − ∫ Σ 2ζω u² dt − ∫ c (δ' − s b')² dt                   damping, structure and mesh
//!     − ∫ F (g − w)·u dt                                      friction
//!     + ∫ ½ k' (δ − s b)² dt                                  stiffness that varies
//!     + Σ Δ(½ k (δ − s b)²)                                   steps of stiffness, direction, gap
//! ```
//!
//! Every integrand is a product of Legendre series. The modal velocities are rebuilt
//! ([`super::modal_series`]) from the state at each window's start and the force series,
//! independently of how the kernel moved the state on. The residual is relative to the sum
//! of all absolute works and the largest energy stored: of a drive at rest under its load no work
//! is done, and what is left of the balance is the round-off of what is stored.

use super::modal_series::{ModalMotion, Series, TERMS, cosine_series, padded};
use crate::model::{Contact, Model, STIFFNESS_TERMS, Segment, TrajectoryState};
use crate::numerics::legendre::{at_end, at_start, derivative, evaluate, transforms8};
use crate::numerics::quadrature::GaussLegendre;
use crate::propagate::{Event, Observer, Window};
use std::sync::OnceLock;

/// Residual above which a kernel without errors of its own has failed. Of a thousand random
/// drives no valid row is above 1e-11.
pub const LARGEST_RESIDUAL: f64 = 1e-9;

/// What is to be said of a motion whose energy balance does not close; none where it does.
pub fn objection(residual: f64) -> Option<String> {
    // Written so that a residual that is not a number is objected to.
    let closes = residual <= LARGEST_RESIDUAL;
    (!closes).then(|| {
        format!(
            "the energy balance misses by {residual:.1e} of the energy at work (at most {LARGEST_RESIDUAL:.0e} is round-off): the kernel does not follow this drive, another run.kernel may"
        )
    })
}

/// Audits the energy balance of a trajectory made of companion blocks.
#[derive(Debug, Clone)]
pub struct EnergyAudit<'m> {
    model: &'m Model,
    motion: ModalMotion<'m>,
    start: Option<f64>,
    balance: f64,
    turnover: f64,
    /// Largest energy stored, all of its parts by their size \[J\].
    stored: f64,
    last: Option<Last>,
    /// Exact for the square of a deflection times the slope of a stiffness.
    rule: &'static GaussLegendre,
}

/// How the last window ended.
#[derive(Debug, Clone, Copy)]
struct Last {
    segment: Segment,
    contact: Contact,
    /// Mesh phase, in cycles.
    phase: f64,
    /// δ \[m\].
    deflection: f64,
}

impl<'m> EnergyAudit<'m> {
    /// An audit that starts with the first window shown.
    pub fn new(model: &'m Model) -> Self {
        static RULE: OnceLock<GaussLegendre> = OnceLock::new();
        Self {
            model,
            motion: ModalMotion::new(model),
            start: None,
            balance: 0.0,
            turnover: 0.0,
            stored: 0.0,
            last: None,
            rule: RULE.get_or_init(|| GaussLegendre::new(TERMS + STIFFNESS_TERMS)),
        }
    }

    /// Relative residual of the balance up to `end`, which is where the last window shown
    /// ended; none when nothing was shown or nothing moved.
    pub fn residual(&self, end: &TrajectoryState) -> Option<f64> {
        let (start, last) = (self.start?, self.last?);
        let n = self.model.modes();
        let (first, second) = end.state.split_at(n);
        let deflection = self.model.deflection_on(&last.segment, &end.state, 0.0).0;
        let stored = self.structure(first, second)
            + self.spring(&last.segment, last.contact, 1.0, deflection);
        let imbalance = stored - start - self.balance;
        let at_work = self.turnover + self.stored;
        (at_work > 0.0).then(|| imbalance.abs() / at_work)
    }

    fn structure(&self, first: &[f64], second: &[f64]) -> f64 {
        let mut energy = 0.0;
        for (i, block) in self.model.blocks.iter().enumerate() {
            if self.model.neutral.contains(&i) {
                continue;
            }
            let omega = block.natural_frequency();
            energy += second[i] * second[i] + (omega * first[i]).powi(2);
        }
        0.5 * energy
    }

    /// Energy of the mesh at a phase, in cycles.
    fn spring(&self, segment: &Segment, contact: Contact, phase: f64, deflection: f64) -> f64 {
        if contact.touching() {
            let [gap, _] = self.model.gap_on(segment, phase * self.model.period());
            let stretch = deflection - contact.sign() * gap;
            0.5 * segment.stiffness_at(phase) * stretch * stretch
        } else {
            0.0
        }
    }

    /// Energies whose round-off the balance is made of: those of structure and mesh, and of the
    /// torques over what they have turned. The stretch of the mesh is a small difference, known to the
    /// round-off of what it is the difference of.
    fn magnitude(&self, window: &Window<'_>, phase: f64, deflection: f64) -> f64 {
        let model = self.model;
        let mut turned = 0.0;
        let mut room = model.half_gap + deflection.abs();
        let gains = model.gains(window.segment);
        for (i, block) in model.blocks.iter().enumerate() {
            if !model.neutral.contains(&i) {
                turned += (block.static_input[1] * window.first[i]).abs();
                room += (gains[i].deflection[0] * window.first[i]).abs();
            }
        }
        let mesh = match window.contact.touching() {
            true => {
                let stretch = (deflection - window.contact.sign() * model.half_gap).abs();
                let known = stretch + f64::EPSILON * room;
                window.segment.stiffness_at(phase) * known * room
            }
            false => 0.0,
        };
        self.structure(window.first, window.second) + turned + mesh
    }

    fn work(&mut self, value: f64) {
        self.balance += value;
        self.turnover += value.abs();
    }

    /// Series over a window in contact of what the flanks lack on the side that touches, s e.
    fn lack(&self, window: &Window<'_>) -> Series {
        let segment = window.segment;
        let place = |time: f64| segment.place(time / self.model.period());
        let ends = [window.start, window.start + window.duration].map(place);
        let series = transforms8().restrict(segment.error.coefficients(), ends[0], ends[1]);
        padded(&series.map(|a| window.contact.sign() * a))
    }

    /// Work of a stiffness that varies over a window in contact, `deflection` being without what
    /// the flanks lack.
    fn stiffening(&mut self, window: &Window<'_>, deflection: &Series) {
        let segment = window.segment;
        if segment.stiffness.is_constant() {
            return;
        }
        let slope = segment.stiffness.slope();
        let level = window.contact.sign() * self.model.half_gap;
        let mut work = 0.0;
        for (x, weight) in self.rule.nodes.iter().zip(&self.rule.weights) {
            let time = window.start + 0.5 * window.duration * (1.0 + x);
            let place = segment.place(time / self.model.period());
            let stretch = evaluate(deflection, *x) - level;
            work += weight * evaluate(&slope, place) * stretch * stretch;
        }
        // dk/dt dt: from the window's place to time, from the segment's place to phase.
        let phase_rate = 2.0 / (segment.end - segment.start) / self.model.period();
        self.work(0.25 * window.duration * phase_rate * work);
    }

    /// Works of torques, friction and structural damping over a window.
    fn structural_work(&mut self, window: &Window<'_>, force: &Series) {
        let tau = window.duration;
        let model = self.model;
        let series = self.motion.on(window);
        let (mut torque, mut friction, mut damping) = (0.0, 0.0, 0.0);
        let gains = model.gains(window.segment);
        for (i, block) in model.blocks.iter().enumerate() {
            if model.neutral.contains(&i) {
                continue;
            }
            let velocity = series.component(i, 1);
            let (g, s) = (gains[i].mesh_input[1], block.static_input[1]);
            torque += s * tau * velocity[0];
            for (ripple, course) in model.ripple.iter().zip(series.ripples()) {
                torque += ripple.input[i][1] * integral(course, &velocity, tau);
            }
            friction -= (g - gains[i].deflection[0]) * integral(force, &velocity, tau);
            damping += 2.0 * block.growth() * integral(&velocity, &velocity, tau);
        }
        self.work(torque);
        self.work(friction);
        self.work(damping);
    }
}

impl Observer for EnergyAudit<'_> {
    const WINDOWS: bool = true;

    fn window(&mut self, window: &Window<'_>) {
        let tau = window.duration;
        let deflection = padded(window.deflection);
        let force = padded(window.force);
        let phase = window.start / self.model.period();
        let at = at_start(&deflection);
        let spring = self.spring(window.segment, window.contact, phase, at);
        self.stored = self.stored.max(self.magnitude(window, phase, at));
        if self.start.is_none() {
            self.start = Some(self.structure(window.first, window.second) + spring);
        }
        if let Some(last) = self.last
            && last.segment != *window.segment
        {
            let turned = last.segment.direction != window.segment.direction
                || !(last.segment.error.is_none() && window.segment.error.is_none());
            // Where nothing turns the spring is as long on both sides, and an event finds no energy.
            if turned || last.contact == window.contact {
                let before = if turned { last.deflection } else { at };
                let before = self.spring(&last.segment, last.contact, last.phase, before);
                self.work(spring - before);
            }
        }
        self.last = Some(Last {
            segment: *window.segment,
            contact: window.contact,
            phase: (window.start + tau) / self.model.period(),
            deflection: at_end(&deflection),
        });

        if window.contact.touching() {
            for h in &self.model.transmission_error {
                // e' = −a ω sin(ωt + φ) = a ω cos(ωt + φ + π/2).
                let phase =
                    h.angular_frequency * window.start + h.phase + std::f64::consts::FRAC_PI_2;
                let rate = cosine_series(h.angular_frequency, phase, tau);
                let work = integral(&force, &rate, tau) * h.amplitude * h.angular_frequency;
                self.work(-work);
            }
            let mut deflection = deflection;
            if !window.segment.error.is_none() {
                let lack = self.lack(window);
                let opening = derivative(&lack).map(|d| 2.0 / tau * d);
                self.work(-integral(&force, &opening, tau));
                for (d, lack) in deflection.iter_mut().zip(&lack) {
                    *d -= lack;
                }
            }
            let rate = derivative(&deflection).map(|d| 2.0 / tau * d);
            self.work(-window.segment.damping * integral(&rate, &rate, tau));
            self.stiffening(window, &deflection);
        }
        self.structural_work(window, &force);
    }

    fn event(&mut self, _: &Event) {}
}

/// `∫ a b dt` over a window.
fn integral(a: &Series, b: &Series, tau: f64) -> f64 {
    let mut sum = 0.0;
    for n in 0..TERMS {
        sum += a[n] * b[n] / (2 * n + 1) as f64;
    }
    tau * sum
}
