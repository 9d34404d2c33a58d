//! The onset of rattle in closed form: the load below which the drive flank loses contact.
//!
//! While contact lasts, the motion is linear. At a given speed, the depth of the drive flank's contact under load L
//! is `d(t; L) = d₀(t) + L d₁(t)`, computed from the orbits at two loads without separation. It vanishes at time t
//! under the load `−d₀/d₁`. The largest of these loads is the onset; the orbit then grazes the flank from inside. The
//! stiffness must not depend on the load.

use super::drive::{DriveMap, ParametricDrive};
use super::map::{CycleMap, MapError, MapParameters};
use super::orbit::{Orbit, OrbitCondition, find};
use super::touches::TouchObserver;
use crate::analysis::modal_series::Series;
use crate::model::{DRIVE_FLANK, InitialState};
use crate::numerics::legendre::evaluate;
use crate::propagate::{Observer, Window};

/// The onset of rattle at a value of the other parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Onset {
    /// The parameters at the onset. The load among them is the largest one under which contact is lost.
    pub at: MapParameters,
    /// Time of the graze from the start of the excitation's period \[mesh cycles\].
    pub phase: f64,
    /// Largest modulus of the multipliers; below 1, the orbit is stable down to the onset.
    pub radius: f64,
}

/// Largest number of loads tried, each twice the previous one, until contact lasts.
const MOST_DOUBLINGS: u32 = 14;

/// Number of intervals between the sampled positions of a window.
const PLACES: usize = 48;

/// Number of steps of the search for the phase at which the load that keeps contact is largest. Each step removes a
/// third of the interval.
const NARROWINGS: usize = 80;

/// The depth of the drive flank's contact over a period.
struct Depths<'m> {
    watch: TouchObserver<'m>,
    windows: Vec<(f64, f64, Series)>,
    period: f64,
}

impl Observer for Depths<'_> {
    const WINDOWS: bool = true;

    fn window(&mut self, window: &Window<'_>) {
        let depth = self.watch.depth(DRIVE_FLANK, window);
        let start = window.cycle as f64 + window.start / self.period;
        self.windows
            .push((start, window.duration / self.period, depth));
    }
}

/// The onset at the parameters `at`. The entry `load` of `at` is replaced by the load at the onset. `None` if
/// the drive does not stay in contact under any load tried.
///
/// # Errors
/// [`MapError`].
pub fn onset<F: ParametricDrive>(
    map: &mut DriveMap<'_, F>,
    at: MapParameters,
    load: usize,
) -> Result<Option<Onset>, MapError> {
    let mut high = at;
    high[load] = at[load].abs().max(0.5);
    let mut orbit_in_contact = None;
    for _ in 0..MOST_DOUBLINGS {
        if let Some(orbit) = in_contact(map, high)? {
            orbit_in_contact = Some(orbit);
            break;
        }
        high[load] *= 2.0;
    }
    let Some(one) = orbit_in_contact else {
        return Ok(None);
    };
    let mut higher = high;
    higher[load] *= 2.0;
    let Some(other) = in_contact(map, higher)? else {
        return Ok(None);
    };
    let a = depths(map, &one)?;
    let b = depths(map, &other)?;
    let unit = 1.0 / (higher[load] - high[load]);
    let needed = |window: usize, x: f64| {
        let (first, second) = (evaluate(&a[window].2, x), evaluate(&b[window].2, x));
        let by_load = (second - first) * unit;
        if by_load > 0.0 { high[load] - first / by_load } else { f64::NEG_INFINITY }
    };
    let place = |i: usize| 2.0 * i as f64 / PLACES as f64 - 1.0;
    let places = (0..a.len()).flat_map(|w| (0..=PLACES).map(move |i| (w, i)));
    let Some((window, i)) =
        places.max_by(|x, y| needed(x.0, place(x.1)).total_cmp(&needed(y.0, place(y.1))))
    else {
        return Ok(None);
    };
    // A position on the border of two windows has neighbours in both windows.
    let (count, ends) = (a.len(), [place(1), place(PLACES - 1)]);
    let mut stretches = vec![(
        window,
        place(i.saturating_sub(1)),
        place((i + 1).min(PLACES)),
    )];
    match i {
        0 => stretches.push(((window + count - 1) % count, ends[1], 1.0)),
        PLACES => stretches.push(((window + 1) % count, -1.0, ends[0])),
        _ => {}
    }
    let highest = stretches.into_iter().map(|(window, mut low, mut up)| {
        for _ in 0..NARROWINGS {
            let third = (up - low) / 3.0;
            if needed(window, low + third) < needed(window, up - third) {
                low += third
            } else {
                up -= third
            }
        }
        (window, 0.5 * (low + up))
    });
    let Some((window, x)) = highest.max_by(|a, b| needed(a.0, a.1).total_cmp(&needed(b.0, b.1)))
    else {
        return Ok(None);
    };
    let mut found = at;
    found[load] = needed(window, x);
    let (start, length, _) = a[window];
    let radius = one.multipliers.first().map_or(0.0, |m| m.norm());
    Ok(Some(Onset {
        at: found,
        phase: start + 0.5 * length * (1.0 + x),
        radius,
    }))
}

/// The orbit on which the drive flank stays in contact; `None` if any contact opens or closes, or if none is found.
fn in_contact<F: ParametricDrive>(
    map: &mut DriveMap<'_, F>,
    at: MapParameters,
) -> Result<Option<Orbit>, MapError> {
    let start = map.model(at)?.start(&InitialState::Static);
    let guess = map.coordinates(&start.state);
    let unit = map.unit();
    let orbit = find(map, &guess, at, unit, &OrbitCondition::Parameters).ok();
    Ok(orbit.filter(|orbit| {
        orbit.details.touches.sequence.is_empty() && map.state(&orbit.u).contact.holds(DRIVE_FLANK)
    }))
}

fn depths<F: ParametricDrive>(
    map: &mut DriveMap<'_, F>,
    orbit: &Orbit,
) -> Result<Vec<(f64, f64, Series)>, MapError> {
    let model = map.model(orbit.at)?.clone();
    let mut watch = Depths {
        watch: TouchObserver::new(&model),
        windows: Vec::new(),
        period: model.period(),
    };
    let mut state = map.state(&orbit.u);
    map.advance(orbit.at, u64::from(orbit.period), &mut state, &mut watch)?;
    Ok(watch.windows)
}
