#![allow(clippy::unwrap_used)]
use super::*;
use crate::model::{Drive, Model, OperatingPoint, TrajectoryState};
use crate::propagate::{Kernel, Tangents};
use crate::structure::{ContactLaw, HarmonicLoad, MeshHarmonic, ModalStructure, StructureContact};
use std::f64::consts::TAU;

/// A gap of the mesh that no motion here crosses.
const WIDE: f64 = 100.0;

/// Records every event.
#[derive(Default)]
struct Events(Vec<Event>);

impl Observer for Events {
    const WINDOWS: bool = false;

    fn event(&mut self, event: &Event) {
        self.0.push(*event);
    }
}

/// A rigid stop at a gap. `moves` are the harmonics of its own motion.
fn stop(
    participation: &[f64],
    gap: f64,
    restitution: f64,
    moves: &[MeshHarmonic],
) -> [StructureContact; 2] {
    let law = ContactLaw {
        gap,
        error: moves.to_vec(),
        ..ContactLaw::default()
    };
    StructureContact::plain("stop".to_owned(), participation.to_vec(), law).rigid(restitution)
}

/// A structure with a mesh period, whose mesh never comes into contact.
fn model(structure: &ModalStructure, period: f64) -> Model {
    let point = OperatingPoint {
        load: 0.0,
        speed: TAU / period,
    };
    Model::new(structure, &Drive::constant(WIDE, 1.0), point).unwrap()
}

/// `q'' + 2 ζ ω q' + ω² q = load + amplitude cos(Ω t + phase)` in front of a rigid stop.
#[derive(Clone, Copy)]
struct Oscillator {
    natural: f64,
    ratio: f64,
    load: f64,
    amplitude: f64,
    frequency: f64,
    phase: f64,
    gap: f64,
    restitution: f64,
}

const FORCED: Oscillator = Oscillator {
    natural: 1.0,
    ratio: 0.02,
    load: 0.0,
    amplitude: 1.0,
    frequency: 2.4,
    phase: 0.0,
    gap: 0.1,
    restitution: 0.8,
};

/// A motion with one impact per period of the load: speed before the impact, phase of the load at the impact,
/// displacement and velocity as functions of the time since the impact, trace of the derivative of the map over a
/// period.
struct Orbit {
    speed: f64,
    phase: f64,
    trace: f64,
    free: [f64; 2],
    forced: [f64; 2],
}

impl Oscillator {
    fn structure(&self) -> ModalStructure {
        let mut structure = ModalStructure::of_modes(&[self.natural], self.ratio, &[1.0], &[1.0]);
        structure.contacts = stop(&[1.0], self.gap, self.restitution, &[]).into();
        structure.constant_load = vec![self.load];
        if self.amplitude != 0.0 {
            structure.harmonic_loads = vec![HarmonicLoad {
                name: "load".to_owned(),
                force: vec![self.amplitude],
                turns_per_cycle: 1.0,
                phase: self.phase,
            }];
        }
        structure
    }

    fn period(&self) -> f64 {
        TAU / self.frequency
    }

    fn model(&self) -> Model {
        model(&self.structure(), self.period())
    }

    fn turned(&self) -> f64 {
        self.natural * (1.0 - self.ratio * self.ratio).sqrt()
    }

    /// `e^{−ζωt} (a cos νt + b sin νt) + c cos Ωt + d sin Ωt`, and its rate.
    fn at(&self, orbit: &Orbit, time: f64) -> [f64; 2] {
        let (nu, decay) = (self.turned(), self.ratio * self.natural);
        let ([a, b], [c, d]) = (orbit.free, orbit.forced);
        let (sin, cos) = (nu * time).sin_cos();
        let fade = (-decay * time).exp();
        let (s, k) = (self.frequency * time).sin_cos();
        let free = fade * (a * cos + b * sin);
        [
            free + c * k + d * s,
            fade * nu * (b * cos - a * sin) - decay * free + self.frequency * (d * k - c * s),
        ]
    }

    /// The motion in closed form, with the restitution r and the speed v before the impact. With the free part h,
    /// periodicity at the stop gives h(0) = h(T), and the law of impact gives h'(T) − h'(0) = (1 + r) v. All terms are
    /// linear in v, and the amplitude of the forced part is known.
    fn orbit(&self) -> Orbit {
        let (omega, nu, r) = (self.natural, self.turned(), self.restitution);
        let (decay, time) = (self.ratio * omega, self.period());
        let fade = (-decay * time).exp();
        let (sin, cos) = (nu * time).sin_cos();
        let ratio = (1.0 - fade * cos) / (fade * sin);
        let before = -decay + nu * ratio;
        let after = fade * (before * cos - (nu + decay * ratio) * sin);
        let lift = (1.0 + r) / (after - before);
        let rest = 1.0 - lift * after;
        let (stiff, viscous) = (
            omega * omega - self.frequency * self.frequency,
            2.0 * decay * self.frequency,
        );
        let size = self.amplitude / stiff.hypot(viscous);
        let [p, q, s] = [
            lift * lift + (rest / self.frequency).powi(2),
            -2.0 * self.gap * lift,
            self.gap * self.gap - size * size,
        ];
        let speed = (-q + (q * q - 4.0 * p * s).sqrt()) / (2.0 * p);
        let forced = [self.gap - lift * speed, rest * speed / self.frequency];
        let phase = viscous.atan2(stiff) - forced[1].atan2(forced[0]);
        let pressed = self.amplitude * phase.cos() - omega * omega * self.gap;
        let own = fade * (cos + decay / nu * sin);
        let other = fade * (cos - decay / nu * sin);
        let trace = -r * (own + other) + (1.0 + r) * pressed / speed * fade * sin / nu;
        Orbit {
            speed,
            phase,
            trace,
            free: [lift * speed, lift * speed * ratio],
            forced,
        }
    }

    /// The same oscillator with the phase of load for which the impact of the orbit is at `part` of the
    /// cycle. Also returns the state at the start of a cycle.
    fn on_orbit(&self, part: f64) -> (Self, [f64; 2]) {
        let orbit = self.orbit();
        let own = Self {
            phase: orbit.phase - TAU * part,
            ..*self
        };
        (own, self.at(&orbit, (1.0 - part) * self.period()))
    }
}

fn kernel(model: &Model) -> Volterra<'_> {
    Volterra::new(model, f64::EPSILON, 1000)
}

fn advance<O: Observer>(
    model: &Model,
    start: &[f64],
    cycles: u64,
    observer: &mut O,
) -> Result<TrajectoryState, End> {
    let mut trajectory = TrajectoryState::new(model, start.to_vec(), 0);
    let kernel = kernel(model);
    let (mut workspace, mut counters) = (kernel.workspace(), Counters::default());
    kernel.advance(
        cycles,
        &mut trajectory,
        &mut workspace,
        observer,
        &mut counters,
    )?;
    Ok(trajectory)
}

/// The derivative of the map over some cycles, one column per unit tangent, and the trajectory after them.
fn tangents(model: &Model, start: &[f64], cycles: u64) -> (Vec<Vec<f64>>, TrajectoryState) {
    let n = model.modes();
    let mut trajectory = TrajectoryState::new(model, start.to_vec(), 0);
    let mut tangents = Tangents::zeros(n, 2 * n);
    for i in 0..2 * n {
        tangents.vector_mut(i)[i] = 1.0;
    }
    let kernel = kernel(model);
    let (mut workspace, mut counters) = (kernel.workspace(), Counters::default());
    for _ in 0..cycles {
        kernel
            .advance_cycle(
                &mut trajectory,
                &mut tangents,
                &mut workspace,
                &mut (),
                &mut counters,
            )
            .unwrap();
    }
    let columns = (0..2 * n).map(|i| tangents.vector(i).to_vec()).collect();
    (columns, trajectory)
}

/// Impacts in a list of events: closings of a contact, each followed by its opening at the same time.
fn impacts(events: &[Event], contact: usize) -> Vec<Event> {
    let pairs = events
        .windows(2)
        .filter(|pair| pair[0].contact == contact && pair[0].closes());
    pairs
        .map(|pair| {
            let [hit, left] = [pair[0], pair[1]];
            assert!(left.contact == contact && !left.closes() && left.time == hit.time);
            assert!(hit.rate > 0.0 && left.rate <= 0.0);
            hit
        })
        .collect()
}

#[test]
fn the_orbit_of_one_impact_a_period_is_that_of_its_closed_form() {
    for (part, natural, ratio) in [(0.3, 1.0, 0.02), (0.85, 1.0, 0.0), (0.6, 1.1, 0.01)] {
        let (own, start) = Oscillator {
            natural,
            ratio,
            ..FORCED
        }
        .on_orbit(part);
        let orbit = own.orbit();
        let model = own.model();
        let mut observed = Events::default();
        let end = advance(&model, &start, 4, &mut observed).unwrap();
        let off = (0..2).map(|i| (end.state[i] - start[i]).abs());
        let off = off.fold(0.0, f64::max);
        let hits = impacts(&observed.0, 2);
        assert_eq!((hits.len(), observed.0.len()), (4, 8));
        let wrong = hits
            .iter()
            .map(|hit| (hit.rate - orbit.speed).abs() + (hit.time - part * own.period()).abs());
        let wrong = wrong.fold(0.0, f64::max);
        let (columns, _) = tangents(&model, &start, 1);
        let trace = columns[0][0] + columns[1][1];
        let product = columns[0][0] * columns[1][1] - columns[0][1] * columns[1][0];
        // The sum of the exponents: 2 ln r − 2 ζ ω T.
        let sum = 2.0 * own.restitution.ln() - 2.0 * ratio * natural * own.period();
        println!(
            "orbit off by {off:.1e}, impacts by {wrong:.1e}, sum of exponents by {:.1e}, trace by {:.1e}",
            product.ln() - sum,
            trace - orbit.trace
        );
        assert!(off < 1e-12 && wrong < 1e-12);
        assert!((product.ln() - sum).abs() < 1e-12);
        assert!((trace - orbit.trace).abs() < 1e-12 * (1.0 + trace.abs()));
    }
}

/// Budd & Dux 1994, `q'' + q = cos ωt`: speed of impact and time after a crest of the load.
#[test]
fn impacts_of_budd_and_dux_are_met() {
    for (frequency, gap, speed, time) in [
        (2.8, 0.0, 0.3361772700, 1.0926345564),
        (2.6, -0.1, 0.7936900987, 1.1403234170),
    ] {
        let (own, start) = Oscillator {
            ratio: 0.0,
            frequency,
            gap,
            ..FORCED
        }
        .on_orbit(0.4);
        let mut observed = Events::default();
        advance(&own.model(), &start, 1, &mut observed).unwrap();
        let hit = impacts(&observed.0, 2)[0];
        assert!((hit.rate - speed).abs() < 1e-10, "{}", hit.rate);
        let crest = -own.phase / frequency;
        let late = (hit.time - crest).rem_euclid(own.period());
        assert!((late - time).abs() < 1e-10, "{late}");
    }
}

/// The multiplier is −1 if `1 + trace + r² e^{−2ζωT} = 0`, with the restitution r.
#[test]
fn the_orbit_doubles_where_its_closed_form_says() {
    let at = |frequency: f64| Oscillator {
        frequency,
        ..FORCED
    };
    let left = |own: &Oscillator| {
        let shrunk = (-2.0 * own.ratio * own.natural * own.period()).exp();
        1.0 + own.orbit().trace + own.restitution.powi(2) * shrunk
    };
    let (mut low, mut high) = (2.4, 2.5);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if left(&at(middle)) > 0.0 { low = middle } else { high = middle }
    }
    let (own, start) = at(low).on_orbit(0.3);
    let (columns, _) = tangents(&own.model(), &start, 1);
    let trace = columns[0][0] + columns[1][1];
    let product = columns[0][0] * columns[1][1] - columns[0][1] * columns[1][0];
    println!("doubling at {low}, off by {:.1e}", 1.0 + trace + product);
    assert!((1.0 + trace + product).abs() < 1e-12);
    for (frequency, period) in [(low - 0.004, 1), (low + 0.004, 2)] {
        let (own, mut start) = at(frequency).on_orbit(0.3);
        start[1] += 1e-3;
        let settled = advance(&own.model(), &start, 4000, &mut ()).unwrap().state;
        let again = |cycles| {
            let end = advance(&own.model(), &settled, cycles, &mut ())
                .unwrap()
                .state;
            (end[0] - settled[0]).abs() + (end[1] - settled[1]).abs()
        };
        assert!(again(period) < 1e-9, "{frequency}: {}", again(period));
        assert!(period == 1 || again(1) > 1e-3, "{}", again(1));
    }
}

/// A ball dropped from a height h with the restitution r bounces for `√(2h/g) (1 + r) / (1 − r)`.
#[test]
fn a_bouncing_ball_comes_to_rest_in_time() {
    for (period, restitution) in [(0.37, 0.7), (5.0, 0.7), (0.9, 0.3), (4.0, 0.9)] {
        let ball = Oscillator {
            natural: 0.0,
            ratio: 0.0,
            load: 9.81,
            amplitude: 0.0,
            frequency: TAU / period,
            gap: 0.2,
            restitution,
            ..FORCED
        };
        let model = ball.model();
        let mut observed = Events::default();
        let first = (2.0 / 9.81_f64).sqrt();
        let ends = first * (1.0 + restitution) / (1.0 - restitution);
        let cycles = (ends / period).ceil() as u64 + 1;
        let end = advance(&model, &[-0.8, 0.0], cycles, &mut observed).unwrap();
        let when = |event: &Event| event.cycle as f64 * period + event.time;
        let mut time = first;
        let mut wrong = 0.0_f64;
        for (n, hit) in impacts(&observed.0, 2).iter().enumerate() {
            wrong = wrong.max((when(hit) - time).abs());
            time += 2.0 * first * restitution.powi(n as i32 + 1);
        }
        let last = observed.0.last().unwrap();
        assert!(last.contact == 3 && last.closes());
        println!(
            "r = {restitution}: {} events, impacts off by {wrong:.1e} s, rest by {:.1e} s",
            observed.0.len(),
            when(last) - ends
        );
        let tolerance = 1e-12 * ends;
        assert!(wrong < tolerance && (when(last) - ends).abs() < tolerance);
        assert_eq!(end.contact, ActiveSet::FREE.toggled(3));
        assert!((end.state[0] - 0.2).abs() < 1e-15 && end.state[1].abs() < 1e-15);
    }
}

/// On a table with the acceleration `a cos Ωt` a ball rests while `g + a cos Ωt > 0`. Either the table moves, or the
/// load varies.
#[test]
fn a_ball_leaves_a_vibrating_table_where_its_force_ends() {
    let (g, a, frequency) = (9.81_f64, 13.0, 7.0);
    let turn = (-g / a).acos();
    let period = TAU / frequency;
    let ball = Oscillator {
        natural: 0.0,
        ratio: 0.0,
        load: g,
        amplitude: a,
        frequency,
        phase: -0.4,
        gap: 0.0,
        restitution: 0.4,
    };
    let moving = {
        let mut structure = Oscillator {
            amplitude: 0.0,
            ..ball
        }
        .structure();
        // δ = q − e with e'' = −a cos(Ωt + phase) has the equation of q under that load.
        let shake = MeshHarmonic::new(1, a / (frequency * frequency), ball.phase);
        structure.contacts = stop(&[1.0], 0.0, 0.4, &[shake]).into();
        model(&structure, period)
    };
    let level = |time: f64| {
        let (sin, cos) = (frequency * time + ball.phase).sin_cos();
        let size = a / (frequency * frequency);
        [size * cos, -size * frequency * sin]
    };
    let leaves = (turn - ball.phase) / frequency;
    for (model, start) in [(ball.model(), [0.0, 0.0]), (moving, level(0.0))] {
        let mut observed = Events::default();
        let end = advance(&model, &start, 3, &mut observed).unwrap();
        // It starts at rest on the table.
        assert!(observed.0[0].contact == 3 && !observed.0[0].closes());
        println!("leaves {:.1e} s off", observed.0[0].time - leaves);
        assert!((observed.0[0].time - leaves).abs() < 1e-13);
        // It flies until it lands: relative flight from rest at `leaves`.
        let path = |t: f64| {
            let [now, then] = [t, leaves].map(|t| (frequency * t + ball.phase).sin_cos());
            let size = a / (frequency * frequency);
            let past = t - leaves;
            0.5 * g * past * past - size * (now.1 - then.1 + frequency * past * then.0)
        };
        let (mut low, mut high) = (leaves + 0.2 * period, leaves + 0.9 * period);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if path(middle) < 0.0 { low = middle } else { high = middle }
        }
        let hit = observed.0.iter().find(|event| event.contact == 2).unwrap();
        let time = hit.cycle as f64 * period + hit.time;
        println!("lands {:.1e} s off", time - low);
        assert!((time - low).abs() < 1e-12);
        // In two of the three cycles accumulating impacts bring it to rest on the table again.
        let again = observed
            .0
            .iter()
            .filter(|event| event.contact == 3 && event.closes());
        assert_eq!(again.count(), 2, "{:?}", end.contact);
    }
}

/// The driver of an idle gear with rigid flanks of restitution e and wide backlash oscillates with Γ times the
/// acceleration that the drag gives the gear. The gear meets one flank once in n periods at the phase φ of the load,
/// `sin φ = πn (1 − e) / ((1 + e) Γ)`. It doubles its period at `Γ² = (πn (1 − e) / (1 + e))² + 4 (1 + e²)² / (1 + e)⁴`
/// (the map of a ball on a shaken table, Holmes 1982).
#[test]
fn rigid_gear_rattle_doubles_where_its_closed_form_says() {
    for (restitution, n, published) in [
        (0.5_f64, 1_u32, 1.526824),
        (0.7, 1, 1.170731),
        (0.9, 1, 1.016311),
        (0.7, 2, f64::NAN),
    ] {
        let (e, drag, frequency) = (restitution, 2.0, 3.0);
        let turns = 0.5 * TAU * f64::from(n);
        let least = turns * (1.0 - e) / (1.0 + e);
        let swing = least.hypot(2.0 * (1.0 + e * e) / (1.0 + e).powi(2));
        assert!(
            published.is_nan() || (swing - published).abs() < 1e-6,
            "{swing}"
        );
        // The other phase with the same sine belongs to a saddle.
        let (phase, time) = (0.5 * TAU - (least / swing).asin(), 0.3 * TAU / frequency);
        let gear = Oscillator {
            natural: 0.0,
            ratio: 0.0,
            load: drag,
            amplitude: drag * swing,
            frequency,
            phase: phase - frequency * time,
            gap: 0.05,
            restitution,
        };
        // The start of the cycle follows from the impact at `time` with the speed `speed`, backwards along
        // the free flight.
        let size = gear.amplitude / (frequency * frequency);
        let speed = drag * turns / frequency + size * frequency * phase.sin();
        let [sin, cos] = [gear.phase.sin(), gear.phase.cos()];
        let start = [
            gear.gap - speed * time + 0.5 * drag * time * time - size * (cos - phase.cos())
                + size * frequency * phase.sin() * time,
            speed - drag * time + size * frequency * (sin - phase.sin()),
        ];
        let model = gear.model();
        let mut observed = Events::default();
        let end = advance(&model, &start, n.into(), &mut observed).unwrap();
        let hit = impacts(&observed.0, 2)[0];
        assert!((hit.rate - speed).abs() < 1e-12 && (hit.time - time).abs() < 1e-12);
        assert_eq!(observed.0.len(), 2);
        let off = (0..2).map(|i| (end.state[i] - start[i]).abs());
        assert!(off.fold(0.0, f64::max) < 1e-12);
        let (columns, _) = tangents(&model, &start, n.into());
        let trace = columns[0][0] + columns[1][1];
        println!("e = {e}: multiplier −1 off by {:.1e}", 1.0 + trace + e * e);
        assert!((1.0 + trace + e * e).abs() < 1e-11);
    }
}

/// Without restitution a body stays where it hits, while a force presses it.
#[test]
fn without_restitution_the_first_impact_is_the_last() {
    let own = Oscillator {
        restitution: 0.0,
        load: 3.0,
        ..FORCED
    };
    let mut observed = Events::default();
    advance(&own.model(), &[-1.0, 0.0], 3, &mut observed).unwrap();
    let names: Vec<_> = (observed
        .0
        .iter()
        .map(|event| (event.contact, event.closes())))
    .collect();
    assert_eq!(names, [(2, true), (2, false), (3, true)]);
    assert_eq!(observed.0[0].time, observed.0[2].time);
}

/// Impacts that do not end within the event limit end the integration with the corresponding error.
#[test]
fn impacts_without_end_are_given_up() {
    let own = Oscillator {
        restitution: 0.999,
        load: 3.0,
        ..FORCED
    };
    let stop = advance(&own.model(), &[0.099, 0.0], 30, &mut ()).unwrap_err();
    assert!(
        matches!(stop, End::EventStorm { limit: 1000, .. }),
        "{stop}"
    );
}

/// Two coupled modes, a stop whose force acts in another direction than its deflection, a second stop and a spring.
fn coupled(restitution: f64) -> ModalStructure {
    let mut structure = ModalStructure::of_modes(&[1.0, 2.7], 0.03, &[1.0, 0.5], &[1.0, 0.2]);
    let first = StructureContact {
        force: vec![0.9, 0.7],
        ..StructureContact::plain(
            "first".to_owned(),
            vec![1.0, 0.6],
            ContactLaw {
                gap: 0.1,
                ..ContactLaw::default()
            },
        )
    };
    let mut spring = StructureContact::stop(&[0.2, 0.9], 0.15, 40.0);
    spring.law.damping = 0.8;
    structure.contacts = first.rigid(restitution).into();
    structure.contacts.extend(stop(
        &[-0.4, 1.0],
        0.12,
        restitution,
        &[MeshHarmonic::new(1, 0.02, 0.5)],
    ));
    structure.contacts.push(spring);
    structure.constant_load = vec![0.5, 0.4];
    structure.harmonic_loads = vec![HarmonicLoad {
        name: "load".to_owned(),
        force: vec![1.0, -0.8],
        turns_per_cycle: 1.0,
        phase: 0.3,
    }];
    structure
}

/// Tangents through impacts, accumulations, rests and releases agree with differences of trajectories.
#[test]
fn tangents_are_differences_of_trajectories() {
    let model = model(&coupled(0.5), 2.9);
    let settled = advance(&model, &[0.0; 4], 3, &mut ()).unwrap();
    let mut rests = 0;
    for cycle in 0..6 {
        let from = advance(&model, &settled.state, cycle, &mut ())
            .unwrap()
            .state;
        let mut observed = Events::default();
        advance(&model, &from, 1, &mut observed).unwrap();
        rests += observed
            .0
            .iter()
            .filter(|own| model.is_rest(own.contact))
            .count();
        let (columns, _) = tangents(&model, &from, 1);
        for (i, column) in columns.iter().enumerate() {
            let step = 1e-6;
            let moved = |sign: f64| {
                let mut start = from.clone();
                start[i] += sign * step;
                advance(&model, &start, 1, &mut ()).unwrap().state
            };
            let (ahead, behind) = (moved(1.0), moved(-1.0));
            for k in 0..4 {
                let slope = (ahead[k] - behind[k]) / (2.0 * step);
                assert!(
                    (slope - column[k]).abs() < 1e-5 * (1.0 + slope.abs()),
                    "{cycle} {i} {k}: {slope} {}",
                    column[k]
                );
            }
        }
    }
    assert!(rests > 2, "{rests}");
}

/// Springs with the stiffness k, and dampers for the same restitution, converge to the rigid stop like 1/√k.
#[test]
fn stiff_springs_tend_to_the_rigid_stop() {
    let (own, start) = FORCED.on_orbit(0.3);
    let exact = own.orbit().speed;
    let log = own.restitution.ln();
    let ratio = -log / log.hypot(0.5 * TAU);
    let mut errors = Vec::new();
    for stiffness in [1e5, 4e5, 1.6e6, 6.4e6] {
        let mut spring = StructureContact::stop(&[1.0], own.gap, stiffness);
        spring.law.damping = 2.0 * ratio * f64::sqrt(stiffness);
        let structure = ModalStructure {
            contacts: vec![spring],
            ..own.structure()
        };
        let model = model(&structure, own.period());
        let settled = advance(&model, &start, 300, &mut ()).unwrap().state;
        let mut observed = Events::default();
        advance(&model, &settled, 1, &mut observed).unwrap();
        let hit = observed.0.iter().find(|event| event.closes()).unwrap();
        errors.push((hit.rate - exact).abs());
    }
    let ratios: Vec<f64> = errors.windows(2).map(|pair| pair[0] / pair[1]).collect();
    println!("{errors:?} {ratios:?}");
    assert!(
        ratios.iter().all(|ratio| (ratio - 2.0).abs() < 0.1),
        "{ratios:?}"
    );
    assert!((ratios[2] - 2.0).abs() < (ratios[0] - 2.0).abs());
}
