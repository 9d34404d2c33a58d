//! When does a contact open or close?
//!
//! The margin of a contact is positive while its state lasts: `b − s δ` for an open one, `s δ − b` for a closed one.
//! The contact opens or closes at the earliest time at which its margin becomes negative. After an event, the margin of
//! its contact is zero at the start of the next window. The search divides this root out of the series.

use super::{Counters, Event, Observer, Stop};
use crate::model::{ActiveSet, Contact};
use crate::numerics::arithmetic::Arithmetic;
use crate::numerics::legendre::Transforms;
use crate::numerics::roots::{Search, earliest_exit, exit_of_falling};

/// Position of an event on a window, and the contact that opens or closes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Crossing {
    /// Position on the window, in \[−1, 1\].
    pub x: f64,
    /// The contact.
    pub contact: usize,
}

/// Round-off of a sum of a hundred terms, relative to the sum of their sizes.
pub const ROUND_OFF: f64 = 16.0 * f64::EPSILON;

/// The margin of a contact, positive while its state lasts: `scale δ + shift`.
#[derive(Debug, Clone, Copy)]
pub struct Margin {
    /// The contact.
    pub contact: usize,
    /// Whether it is closed.
    pub closed: bool,
    /// Factor of δ, ±1.
    pub scale: f64,
    /// ± the half gap \[m\].
    pub shift: f64,
}

impl Margin {
    /// The margin of a contact that is closed or open. `index` is its index among the contacts of its model.
    pub fn new(contact: &Contact, index: usize, closed: bool) -> Self {
        let inside = if closed { 1.0 } else { -1.0 };
        Self {
            contact: index,
            closed,
            scale: inside * contact.side,
            shift: -inside * contact.half_gap,
        }
    }

    /// The margins of contacts with the same deflection. An open contact opposite to a closed one is omitted, because
    /// the closed one opens first.
    pub fn of(contacts: &[Contact], active: ActiveSet) -> impl Iterator<Item = Self> {
        let has_opposite = move |side: f64| {
            let mut closed = active.iter().map(|contact| &contacts[contact]);
            closed.any(|other| other.side == -side)
        };
        (contacts.iter().enumerate())
            .filter(move |(index, contact)| active.holds(*index) || !has_opposite(contact.side))
            .map(move |(index, contact)| Self::new(contact, index, active.holds(index)))
    }
}

/// Largest number of windows per cell of the grid and per event. It allows for windows that breakpoints cut,
/// and for the short windows between an event and the next cell.
const WINDOWS_OF_EACH: u64 = 8;

/// Counts, limits and reports the events of one mesh cycle, and limits its windows.
#[derive(Debug, Clone, Copy)]
pub struct Changes {
    /// Events in this cycle.
    event_count: u32,
    /// Largest number of events in a cycle.
    limit: u32,
    /// Windows in this cycle.
    windows: u64,
    /// Windows of a cycle if none is cut.
    planned: u64,
}

impl Changes {
    /// A cycle before its first event. At most `limit` events are allowed; without cuts, the cycle has
    /// `planned` windows.
    pub fn new(limit: u32, planned: usize) -> Self {
        Self {
            event_count: 0,
            limit,
            windows: 0,
            planned: planned as u64,
        }
    }

    /// Counts a window that starts at `time` \[s\] of a mesh cycle of `period` \[s\].
    ///
    /// # Errors
    /// [`Stop::Stuck`] if the cycle has more windows than its grid and its events can cause.
    pub fn count_window(&mut self, cycle: u64, time: f64, period: f64) -> Result<(), Stop> {
        self.windows += 1;
        let accounted = 1 + self.planned + u64::from(self.event_count);
        if self.windows <= WINDOWS_OF_EACH * accounted {
            Ok(())
        } else {
            Err(Stop::Stuck {
                cycle,
                phase: time / period,
                windows: self.windows,
            })
        }
    }

    /// Counts and reports one more event.
    ///
    /// # Errors
    /// [`Stop::EventStorm`] beyond the limit.
    pub fn meet<O: Observer>(
        &mut self,
        event: &Event,
        observer: &mut O,
        counters: &mut Counters,
    ) -> Result<(), Stop> {
        self.event_count += 1;
        if self.event_count > self.limit {
            return Err(Stop::EventStorm {
                cycle: event.cycle,
                limit: self.limit,
            });
        }
        counters.events += 1;
        observer.event(event);
        Ok(())
    }
}

/// Assumed growth of round-off when a root is divided out. The worst case is about the square of the series'
/// length.
const DEFLATION_NOISE: f64 = 64.0;

/// A contact in the search for events on a window.
#[derive(Debug, Clone, Copy)]
pub struct Guard<'a, const P: usize> {
    /// Its margin without the gap error.
    pub margin: Margin,
    /// Whether it opened or closed at the start of the window.
    pub crossed: bool,
    /// Addition to its half gap as a series \[m\], if any.
    pub gap_error: Option<&'a [f64; P]>,
}

impl<const P: usize> Guard<'_, P> {
    /// A guard for finding the position where `sign` times a series becomes negative. `crossed` means that the series
    /// is zero at its start.
    pub fn of_sign(sign: f64, crossed: bool) -> Self {
        Self {
            margin: Margin {
                contact: 0,
                closed: true,
                scale: sign,
                shift: 0.0,
            },
            crossed,
            gap_error: None,
        }
    }
}

/// The first event on `[−1, limit]` of a window, for contacts with the same deflection; `None` if there is none.
///
/// * `series`: Legendre series of δ \[m\], with round-off `noise` \[m\].
#[inline(always)]
pub fn first_crossing<const P: usize, A: Arithmetic<P>>(
    transforms: &Transforms<P>,
    series: &[f64; P],
    noise: f64,
    guards: &[Guard<'_, P>],
    limit: f64,
    counters: &mut Counters,
) -> Option<Crossing> {
    if let Some(guard) = ahead::<P, A>(transforms, series, guards) {
        let search = exit_of_falling::<P, A>(transforms, &margin_of::<P, A>(guard, series), limit);
        counters.certified += u64::from(search.certified);
        return crossing_of(search, guard.margin.contact, counters);
    }
    let mut first: Option<Crossing> = None;
    let mut certified = true;
    for guard in guards {
        let mut margin = margin_of::<P, A>(guard, series);
        let mut noise = noise;
        if guard.crossed {
            margin = A::quotient(transforms, &margin);
            noise *= DEFLATION_NOISE;
        }
        let limit = if let Some(first) = first { first.x } else { limit };
        let search = earliest_exit::<P, A>(transforms, &margin, limit, noise);
        certified &= search.certified;
        first = crossing_of(search, guard.margin.contact, counters).or(first);
    }
    counters.certified += u64::from(certified);
    first
}

/// The margin of a contact along a deflection.
#[inline(always)]
fn margin_of<const P: usize, A: Arithmetic<P>>(
    guard: &Guard<'_, P>,
    series: &[f64; P],
) -> [f64; P] {
    let Margin { scale, shift, .. } = guard.margin;
    let mut margin = A::scaled(series, scale, shift);
    if let Some(gap_error) = guard.gap_error {
        // An open contact's margin grows with its gap.
        let inside = if guard.margin.closed { 1.0 } else { -1.0 };
        for n in 0..P {
            margin[n] -= inside * gap_error[n];
        }
    }
    margin
}

/// The event at the exit that a search found, if any.
fn crossing_of(search: Search, contact: usize, counters: &mut Counters) -> Option<Crossing> {
    counters.bisections += u64::from(search.bisections);
    counters.newton_steps += u64::from(search.newton_steps);
    counters.grazings += u64::from(search.grazings);
    search.exit.map(|x| Crossing { x, contact })
}

/// The contact that the deflection approaches monotonically, if `guards` are two opposite open contacts without gap
/// errors. `None` if the deflection may turn, starts beyond a surface, or starts on the surface ahead. A contact that
/// has just opened may be beyond the surface behind by round-off, and the deflection does not return to it.
#[inline(always)]
fn ahead<'g, 'a, const P: usize, A: Arithmetic<P>>(
    transforms: &Transforms<P>,
    series: &[f64; P],
    guards: &'g [Guard<'a, P>],
) -> Option<&'g Guard<'a, P>> {
    let [one, other] = guards else { return None };
    let open = |guard: &Guard<'_, P>| !guard.margin.closed && guard.gap_error.is_none();
    if !(open(one) && open(other) && one.margin.scale == -other.margin.scale) {
        return None;
    }
    let slope = A::derivative(transforms, series);
    if slope[0].abs() <= A::bounds(&slope).variation {
        return None;
    }
    let (ahead, behind) =
        if slope[0] * one.margin.scale < 0.0 { (one, other) } else { (other, one) };
    let start = A::bounds(series).start;
    let outside = |guard: &Guard<'_, P>| guard.margin.scale * start + guard.margin.shift < 0.0;
    let beyond = outside(ahead) || (outside(behind) && !behind.crossed);
    (!(beyond || ahead.crossed)).then_some(ahead)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::{COAST_FLANK, DRIVE_FLANK, Release};
    use crate::numerics::arithmetic::Portable;
    use crate::numerics::legendre::transforms24;

    fn cross(
        f: impl Fn(f64) -> f64,
        active: ActiveSet,
        crossed: Option<usize>,
    ) -> (Option<Crossing>, Counters) {
        let t = transforms24();
        let nodes = *t.nodes();
        let series = t.interpolate(&std::array::from_fn(|j| f(nodes[j])));
        let mut counters = Counters::default();
        let contacts = [1.0, -1.0].map(|side| Contact {
            band: f64::INFINITY,
            side,
            half_gap: 1.0,
            cycles: Vec::new(),
            release: Release::Deflection,
        });
        let guards: Vec<_> = Margin::of(&contacts, active)
            .map(|margin| Guard {
                margin,
                crossed: crossed == Some(margin.contact),
                gap_error: None,
            })
            .collect();
        let found = first_crossing::<_, Portable>(t, &series, 1e-14, &guards, 1.0, &mut counters);
        (found, counters)
    }

    /// Too many windows without an event end the cycle. The error contains the mesh phase.
    #[test]
    fn windows_that_do_not_get_on_are_given_up() {
        let mut changes = Changes::new(100, 9);
        let mut count = || changes.count_window(7, 0.5e-3, 2e-3);
        for _ in 0..80 {
            assert_eq!(count(), Ok(()));
        }
        let stop = count().unwrap_err();
        let stuck = Stop::Stuck {
            cycle: 7,
            phase: 0.25,
            windows: 81,
        };
        assert_eq!(stop, stuck);
        assert!(stop.to_string().contains("mesh phase 0.25"));
        // An event allows more windows.
        let event = Event {
            cycle: 7,
            time: 0.5e-3,
            from: ActiveSet::FREE,
            to: ActiveSet::DRIVE,
            contact: DRIVE_FLANK,
            rate: 1.0,
        };
        changes
            .meet(&event, &mut (), &mut Counters::default())
            .unwrap();
        assert_eq!(changes.count_window(7, 0.5e-3, 2e-3), Ok(()));
    }

    #[test]
    fn free_flight_hits_the_nearer_surface_first() {
        // Through −1 at x = −0.5, through +1 at x = 0.5.
        let (c, _) = cross(|x| 2.0 * x, ActiveSet::FREE, None);
        let c = c.unwrap();
        // Starts outside (δ = −2): leaves at once through the coast surface.
        assert_eq!((c.x, c.contact), (-1.0, COAST_FLANK));
        let (c, _) = cross(
            |x| 1.9 * x * x * x + 0.3,
            ActiveSet::FREE,
            Some(COAST_FLANK),
        );
        assert_eq!(c.unwrap().contact, DRIVE_FLANK);
    }

    #[test]
    fn a_short_touch_is_entered_and_left() {
        // Touches the drive surface on an interval of 1e-6 around x = 0.2.
        let f = |x: f64| 1.0 - (x - 0.2) * (x - 0.2 - 1e-6);
        let (entry, _) = cross(f, ActiveSet::FREE, None);
        let entry = entry.unwrap();
        assert!((entry.x - 0.2).abs() < 1e-8);
        // From the entry on, the entry itself is divided out and the release is found.
        let g = move |x: f64| f(entry.x + 0.5 * (x + 1.0));
        let (release, _) = cross(g, ActiveSet::DRIVE, Some(DRIVE_FLANK));
        let dwell = 0.5 * (release.unwrap().x + 1.0);
        assert!((dwell - 1e-6).abs() < 2e-8, "{dwell}");
    }

    #[test]
    fn settled_windows_are_certified_and_grazing_is_counted() {
        let (c, counters) = cross(|x| 0.5 + 0.2 * x, ActiveSet::FREE, None);
        assert_eq!((c, counters.certified), (None, 1));
        let (c, counters) = cross(|x| 1.0 - (x - 0.1) * (x - 0.1), ActiveSet::FREE, None);
        assert_eq!(c, None);
        assert!(counters.grazings >= 1);
    }
}
