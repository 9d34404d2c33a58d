//! When a trajectory leaves its contact state.
//!
//! The margin of a state is positive inside it: `b − δ` and `b + δ` in free flight, `δ − b`
//! on the drive flank, `−δ − b` on the coast flank. A state is left at the earliest
//! moment a margin becomes negative. After an event the surface just crossed is a known
//! root at the window's start; it is divided out rather than stepped over.

use super::Counters;
use crate::model::{Contact, Surface};
use crate::numerics::arithmetic::Arithmetic;
use crate::numerics::legendre::Transforms;
use crate::numerics::roots::{Search, earliest_exit, exit_of_falling};

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

/// A window's deflection, and what is known of it.
#[derive(Debug, Clone, Copy)]
pub struct WindowDeflection<'a, const P: usize> {
    /// Legendre series of δ \[m\].
    pub series: &'a [f64; P],
    /// Contact state where the window starts.
    pub contact: Contact,
    /// The surface that the window starts on, if it starts on one just crossed.
    pub crossed: Option<Surface>,
    /// Round-off of the series \[m\].
    pub noise: f64,
    /// What the half gap has on top, as a series \[m\]; none where it is constant.
    pub widening: Option<&'a [f64; P]>,
}

/// The first crossing on `[−1, limit]` of a window.
#[inline(always)]
pub fn first_crossing<const P: usize, A: Arithmetic<P>>(
    transforms: &Transforms<P>,
    deflection: WindowDeflection<'_, P>,
    half_gap: f64,
    limit: f64,
    counters: &mut Counters,
) -> Option<Crossing> {
    let WindowDeflection {
        series,
        contact,
        crossed,
        noise,
        widening,
    } = deflection;
    let mut take = |search: Search, surface: Surface| {
        counters.bisections += u64::from(search.bisections);
        counters.newton_steps += u64::from(search.newton_steps);
        counters.grazings += u64::from(search.grazings);
        search.exit.map(|x| Crossing { x, surface })
    };
    // Inside it a state's margin is positive.
    let margin = |surface: Surface| {
        let inside = if contact.touching() { 1.0 } else { -1.0 };
        let mut margin = A::scaled(series, inside * surface.sign(), -inside * half_gap);
        if let Some(widening) = widening {
            for n in 0..P {
                margin[n] -= inside * widening[n];
            }
        }
        margin
    };
    if !contact.touching()
        && widening.is_none()
        && let Some(surface) = ahead::<P, A>(transforms, deflection, half_gap)
    {
        let search = exit_of_falling::<P, A>(transforms, &margin(surface), limit);
        counters.certified += u64::from(search.certified);
        return take(search, surface);
    }
    let surfaces: &[Surface] = match contact {
        Contact::Drive => &[Surface::Drive],
        Contact::Coast => &[Surface::Coast],
        Contact::Free => &[Surface::Drive, Surface::Coast],
    };
    let mut first: Option<Crossing> = None;
    let mut certified = true;
    for &surface in surfaces {
        let mut margin = margin(surface);
        let mut noise = noise;
        if crossed == Some(surface) {
            margin = A::quotient(transforms, &margin);
            noise *= DEFLATION_NOISE;
        }
        let limit = first.map_or(limit, |c| c.x);
        let search = earliest_exit::<P, A>(transforms, &margin, limit, noise);
        certified &= search.certified;
        first = take(search, surface).or(first);
    }
    counters.certified += u64::from(certified);
    first
}

/// The surface that a free flight heads for without turning; none where it may turn, or starts beyond a surface or on the one ahead. The surface
/// behind is left at once and for good, and needs no look.
#[inline(always)]
fn ahead<const P: usize, A: Arithmetic<P>>(
    transforms: &Transforms<P>,
    deflection: WindowDeflection<'_, P>,
    half_gap: f64,
) -> Option<Surface> {
    let slope = A::derivative(transforms, deflection.series);
    if slope[0].abs() <= A::bounds(&slope).variation {
        return None;
    }
    let (surface, behind) = match slope[0] > 0.0 {
        true => (Surface::Drive, Surface::Coast),
        false => (Surface::Coast, Surface::Drive),
    };
    let start = A::bounds(deflection.series).start;
    let beyond = start.abs() > half_gap && deflection.crossed != Some(behind);
    if beyond || deflection.crossed == Some(surface) {
        return None;
    }
    Some(surface)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::arithmetic::Portable;
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
        let deflection = WindowDeflection {
            series: &series,
            contact,
            crossed,
            noise: 1e-14,
            widening: None,
        };
        let found = first_crossing::<_, Portable>(t, deflection, 1.0, 1.0, &mut counters);
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
