//! When a trajectory leaves its contact state.
//!
//! The margin of a state is positive inside it: `b − δ` and `b + δ` in free flight, `δ − b`
//! on the drive flank, `−δ − b` on the coast flank. A state is left at the earliest
//! moment a margin becomes negative. After an event the surface just crossed is a known
//! root at the window's start; it is divided out rather than stepped over.

use super::Counters;
use crate::model::{Contact, Surface};
use crate::numerics::legendre::{self, Transforms};
use crate::numerics::roots::earliest_exit;

/// Where and through which surface a window's trajectory leaves its contact state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Crossing {
    /// Place on the window, in \[−1, 1\].
    pub x: f64,
    /// Surface crossed.
    pub surface: Surface,
}

/// Dividing out a root amplifies round-off by about the square of the series' length.
const DEFLATION_NOISE: f64 = 64.0;

/// The first crossing on `[−1, limit]` of a window whose deflection is the Legendre series
/// `deflection` \[m\], with fused multiply-adds where asked for; `crossed` is the surface that the window starts on, if it starts on
/// one just crossed, and `noise` the round-off of the series \[m\].
#[inline(always)]
pub fn first_crossing<const P: usize, const FUSED: bool>(
    transforms: &Transforms<P>,
    deflection: &[f64; P],
    contact: Contact,
    half_gap: f64,
    crossed: Option<Surface>,
    limit: f64,
    noise: f64,
    counters: &mut Counters,
) -> Option<Crossing> {
    let surfaces: &[Surface] = match contact {
        Contact::Drive => &[Surface::Drive],
        Contact::Coast => &[Surface::Coast],
        Contact::Free => &[Surface::Drive, Surface::Coast],
    };
    let mut first: Option<Crossing> = None;
    let mut certified = true;
    for &surface in surfaces {
        let inside = if contact.touching() { 1.0 } else { -1.0 };
        let mut margin = *deflection;
        for a in &mut margin {
            *a *= inside * surface.sign();
        }
        margin[0] -= inside * half_gap;
        let mut noise = noise;
        if crossed == Some(surface) {
            margin = legendre::divide_out_start::<P, FUSED>(&margin);
            noise *= DEFLATION_NOISE;
        }
        let limit = first.map_or(limit, |c| c.x);
        let search = earliest_exit::<P, FUSED>(transforms, &margin, limit, noise);
        certified &= search.certified;
        counters.bisections += u64::from(search.bisections);
        counters.newton_steps += u64::from(search.newton_steps);
        counters.grazings += u64::from(search.grazings);
        if let Some(x) = search.exit {
            first = Some(Crossing { x, surface });
        }
    }
    counters.certified += u64::from(certified);
    first
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::legendre::transforms24;

    fn cross(
        f: impl Fn(f64) -> f64,
        contact: Contact,
        crossed: Option<Surface>,
    ) -> (Option<Crossing>, Counters) {
        let t = transforms24();
        let nodes = *t.nodes();
        let series = t.interpolate(&std::array::from_fn(|j| f(nodes[j])));
        let mut counters = Counters::default();
        let found = first_crossing::<_, false>(
            t,
            &series,
            contact,
            1.0,
            crossed,
            1.0,
            1e-14,
            &mut counters,
        );
        (found, counters)
    }

    #[test]
    fn free_flight_hits_the_nearer_surface_first() {
        // Through −1 at x = −0.5, through +1 at x = 0.5.
        let (c, _) = cross(|x| 2.0 * x, Contact::Free, None);
        let c = c.unwrap();
        // Starts outside (δ = −2): leaves at once through the coast surface.
        assert_eq!((c.x, c.surface), (-1.0, Surface::Coast));
        let (c, _) = cross(
            |x| 1.9 * x * x * x + 0.3,
            Contact::Free,
            Some(Surface::Coast),
        );
        assert_eq!(c.unwrap().surface, Surface::Drive);
    }

    #[test]
    fn a_short_touch_is_entered_and_left() {
        // Touches the drive surface on an interval of 1e-6 around x = 0.2.
        let f = |x: f64| 1.0 - (x - 0.2) * (x - 0.2 - 1e-6);
        let (entry, _) = cross(f, Contact::Free, None);
        let entry = entry.unwrap();
        assert!((entry.x - 0.2).abs() < 1e-8);
        // From the entry on, the entry itself is divided out and the release is found.
        let g = move |x: f64| f(entry.x + 0.5 * (x + 1.0));
        let (release, _) = cross(g, Contact::Drive, Some(Surface::Drive));
        let dwell = 0.5 * (release.unwrap().x + 1.0);
        assert!((dwell - 1e-6).abs() < 2e-8, "{dwell}");
    }

    #[test]
    fn settled_windows_are_certified_and_grazing_is_counted() {
        let (c, counters) = cross(|x| 0.5 + 0.2 * x, Contact::Free, None);
        assert_eq!((c, counters.certified), (None, 1));
        let (c, counters) = cross(|x| 1.0 - (x - 0.1) * (x - 0.1), Contact::Free, None);
        assert_eq!(c, None);
        assert!(counters.grazings >= 1);
    }
}
