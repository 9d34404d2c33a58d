//! The involute function and its inverse.

/// `inv α = tan α − α`, the polar angle of an involute at pressure angle α \[rad\].
pub fn involute(angle: f64) -> f64 {
    angle.tan() - angle
}

/// The angle in \[0, π/2) whose involute is `value ≥ 0` \[rad\].
///
/// Newton's iteration from above, where the function is convex: `tan α − α ≥ α³/3` and
/// `α = atan(inv α + α)` bound the root.
pub fn inverse_involute(value: f64) -> f64 {
    if value <= 0.0 {
        return 0.0;
    }
    let mut angle = (3.0 * value)
        .cbrt()
        .min((value + std::f64::consts::FRAC_PI_2).atan());
    loop {
        let tangent = angle.tan();
        let next = angle - (tangent - angle - value) / (tangent * tangent);
        // From above every step decreases, until round-off reverses it.
        if next >= angle || next.is_nan() {
            return angle;
        }
        angle = next;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tabulated_involutes() {
        // Tables of the involute function to seven places.
        for (degrees, value) in [(14.5, 0.0055448), (20.0, 0.0149044), (25.0, 0.0299753)] {
            assert!((involute(f64::to_radians(degrees)) - value).abs() < 5e-8);
        }
    }

    #[test]
    fn the_inverse_undoes_the_involute() {
        for degrees in [0.5f64, 2.0, 11.0, 20.0, 33.3, 60.0, 85.0] {
            let angle = degrees.to_radians();
            let back = inverse_involute(involute(angle));
            // A relative error ε of inv α changes α by ε inv α / tan² α < ε α / 3. The
            // subtraction in inv α cancels all but α³/3 of α.
            let lost = f64::EPSILON * (1.0 + 3.0 / angle.powi(2));
            assert!((back / angle - 1.0).abs() < 4.0 * lost, "{degrees}: {back}");
        }
        assert_eq!(inverse_involute(0.0), 0.0);
    }
}
