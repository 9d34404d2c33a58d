//! With what force do the spring and damper of a contact push, and what is the rate of this force?

use super::crossing::Margin;
use crate::model::{MeshGain, Model, Segment};

/// Round-off of a difference of positions, relative to the size of the positions.
const AT_LIMIT: f64 = 1e-14;

/// The push `s F = k (s δ − b) + c (s δ' − b')` of a contact \[N\], and its rate \[N/s\], on a segment in a
/// state with the time derivative `slope`. For an open contact they are those that it would have if closed.
pub(super) fn push(
    model: &Model,
    contact: usize,
    segment: &Segment,
    (cycle, time): (u64, f64),
    state: &[f64],
    slope: &[f64],
) -> Margin {
    let (contact_data, period) = (&model.contacts[contact], model.period());
    let (deflection, rate) = model.deflection_on(segment, cycle, state, time);
    let acceleration = acceleration(model, segment, (cycle, time), slope);
    let [gap, opening] = contact_data.gap(segment, time);
    let [stiffening, curvature] = segment.bends_at(time / period);
    let [indentation, approach, quickening] = [
        contact_data.side * deflection - gap,
        contact_data.side * rate - opening,
        contact_data.side * acceleration - curvature / (period * period),
    ];
    Margin {
        value: contact_data.side * contact_data.force(segment, time, deflection, rate),
        rate: stiffening / period * indentation
            + segment.stiffness_at(time / period) * approach
            + segment.damping * quickening,
    }
}

/// Round-off of the stretch of a slider's spring, or of the deflection at a rigid stop \[m\], from the size
/// of the positions whose difference it is.
pub(super) fn round_off(model: &Model, contact: usize, state: &[f64]) -> f64 {
    let slider = model.sliders.iter().find(|slider| slider.has(contact));
    let place = slider.map_or(0.0, |slider| state[slider.block].abs());
    let parts = model.stop_of(contact).map_or(0.0, |stop| {
        let gains = &model.directions[stop.direction].gains;
        let (first, second) = state.split_at(gains.len());
        let parts = gains.iter().zip(first.iter().zip(second));
        let size = |(gain, (x, y)): (&MeshGain, (&f64, &f64))| {
            (gain.deflection[0] * x).abs() + (gain.deflection[1] * y).abs()
        };
        parts.map(size).sum()
    });
    AT_LIMIT * (model.contacts[contact].half_gap.abs() + place + parts)
}

/// The velocity `s δ'` \[m/s\] of a slipping slider, and its rate \[m/s²\], in a state with its time derivative.
pub(super) fn sliding(
    model: &Model,
    slip: usize,
    segment: &Segment,
    (cycle, time): (u64, f64),
    (state, slope): (&[f64], &[f64]),
) -> Margin {
    let side = model.contacts[slip].side;
    let (_, rate) = model.deflection_on(segment, cycle, state, time);
    Margin {
        value: side * rate,
        rate: side * acceleration(model, segment, (cycle, time), slope),
    }
}

/// Second derivative of the deflection along the line of a segment \[m/s²\].
fn acceleration(model: &Model, segment: &Segment, (cycle, time): (u64, f64), slope: &[f64]) -> f64 {
    let n = model.modes();
    let mut acceleration = 0.0;
    for (i, gain) in model.gains(segment).iter().enumerate() {
        acceleration += gain.rate[0] * slope[i] + gain.rate[1] * slope[n + i];
    }
    for h in &model.lines[model.line(segment)].transmission_error {
        let turned = h.turned(cycle, time) + h.phase;
        acceleration += h.amplitude * h.angular_frequency.powi(2) * turned.cos();
    }
    acceleration
}
