use super::*;
use proptest::prelude::*;
use std::f64::consts::PI;

#[test]
fn units_of_the_data_sheet_are_read() {
    use Dimension::*;
    let cases: [(&str, Dimension, f64); 33] = [
        ("15 um", Length, 1.5e-5),
        ("15 µm", Length, 1.5e-5),
        ("15 μm", Length, 1.5e-5),
        ("15um", Length, 1.5e-5),
        ("4 mm", Length, 4e-3),
        ("-3.5 cm", Length, -0.035),
        ("1200 rad/s", AngularSpeed, 1200.0),
        ("11_460 rpm", AngularSpeed, 11460.0 * (PI / 30.0)),
        ("50 Hz", AngularSpeed, 50.0 * (2.0 * PI)),
        ("50 N*m", Torque, 50.0),
        ("50 N m", Torque, 50.0),
        ("50 N·m", Torque, 50.0),
        ("50 Nm", Torque, 50.0),
        ("4e8 N/m", Stiffness, 4e8),
        ("400 N/um", Stiffness, 4e8),
        ("400 kN/mm", Stiffness, 4e8),
        ("206 GPa", Pressure, 206e9),
        ("206000 N/mm^2", Pressure, 206e9),
        ("46 mPa*s", Viscosity, 0.046),
        ("7850 kg/m^3", Density, 7850.0),
        ("7.85 g/cm³", Density, 7850.0),
        ("7.85e-9 t/mm^3", Density, 7850.0),
        ("2e-3 kg*m^2", Inertia, 2e-3),
        ("2000 kg*mm²", Inertia, 2e-3),
        ("1483 N*s/m", Damping, 1483.0),
        ("3 N*m*s/rad", Drag, 3.0),
        ("20 deg", Angle, 20.0 * (PI / 180.0)),
        ("2e4 N*m/rad", TiltStiffness, 2e4),
        ("5 %", Ratio, 0.05),
        ("3 ms", Time, 3e-3),
        ("1330 N", Force, 1330.0),
        ("1.33 kN", Force, 1330.0),
        ("-0 um", Length, 0.0),
    ];
    for (text, dimension, value) in cases {
        let read = parse(text, dimension).unwrap_or_else(|error| panic!("{text}: {error}"));
        assert_eq!(read.to_bits(), value.to_bits(), "{text}: {read} != {value}");
        assert_eq!(parse_any(text), Ok((value, dimension)), "{text}");
    }
}

#[test]
fn a_unit_of_the_wrong_kind_says_what_was_found() {
    let error = parse("15 N", Dimension::Length).unwrap_err();
    assert_eq!(
        error,
        QuantityError::WrongKind {
            unit: "N".to_owned(),
            found: Some(Dimension::Force),
            wanted: Dimension::Length
        }
    );
    assert_eq!(error.to_string(), "`N` is a unit of force, not a length");
    // A torque differs from a tilt stiffness, and a rate per second from an angular speed.
    assert!(parse("2e4 N*m", Dimension::TiltStiffness).is_err());
    assert!(parse("3 1/s", Dimension::AngularSpeed).is_err());
    // Modal coordinates have no text form.
    assert!(parse("3 m", Dimension::ModalDisplacement).is_err());
}

#[test]
fn texts_that_are_no_quantity_are_told_apart() {
    let kind = |text: &str| parse(text, Dimension::Length).unwrap_err();
    let text = |t: &str| t.to_owned();
    assert_eq!(
        kind("fast"),
        QuantityError::NotANumber { text: text("fast") }
    );
    assert_eq!(kind(""), QuantityError::NotANumber { text: text("") });
    assert_eq!(
        kind("nan m"),
        QuantityError::NotANumber {
            text: text("nan m")
        }
    );
    assert_eq!(kind("15"), QuantityError::MissingUnit { text: text("15") });
    assert_eq!(
        kind("0,5 mm"),
        QuantityError::DecimalComma {
            text: text("0,5 mm")
        }
    );
    assert_eq!(
        kind("15 furlong"),
        QuantityError::UnknownUnit {
            unit: text("furlong")
        }
    );
    assert_eq!(
        kind("15 m*"),
        QuantityError::UnknownUnit { unit: text("m*") }
    );
    assert_eq!(
        kind("15 m^x"),
        QuantityError::UnknownUnit { unit: text("m^x") }
    );
    assert_eq!(
        kind("1e400 m"),
        QuantityError::NotFinite {
            text: text("1e400 m")
        }
    );
    assert_eq!(
        kind("1e99999999999 m"),
        QuantityError::NotFinite {
            text: text("1e99999999999 m")
        }
    );
}

#[test]
fn a_number_too_small_is_zero_and_an_exponent_has_digits() {
    for exponent in ["-400", "-99999999999", "-2147483648"] {
        let text = format!("1e{exponent} um");
        assert_eq!(parse(&text, Dimension::Length), Ok(0.0), "{text}");
    }
    for unit in ["e", "e_", "e-_"] {
        let error = parse(&format!("1{unit} m"), Dimension::Length).unwrap_err();
        assert!(
            matches!(error, QuantityError::UnknownUnit { .. }),
            "{error}"
        );
    }
}

/// Exponents that would overflow are refused, both single and summed.
#[test]
fn powers_without_bound_are_no_unit() {
    let wrapping = "10 um*m^-2147483648*m^-2147483648";
    let huge = format!("1 m{}", "*Gm^9*Gm^-9".repeat(1000));
    assert!(parse(wrapping, Dimension::Length).is_err());
    assert_eq!(parse(&huge, Dimension::Length), Ok(1.0));
    for text in [
        "1 m^10",
        "1 m^-2147483648",
        "1 m^2147483647",
        "1 m^99999999999",
    ] {
        assert!(parse_any(text).is_err(), "{text}");
    }
    let long = format!("1 m{}", "*kN^9".repeat(100_000));
    assert!(parse_any(&long).is_err());
}

#[test]
fn every_dimension_reads_its_own_units() {
    for (dimension, _) in TEXT_FORMS {
        for unit in dimension.units().split(", ") {
            let read = parse(&format!("1 {unit}"), dimension);
            assert!(
                matches!(read, Ok(v) if v > 0.0),
                "{unit} for {dimension:?}: {read:?}"
            );
        }
        if dimension != Dimension::Ratio {
            assert_eq!(
                parse(&format!("1 {}", dimension.unit()), dimension),
                Ok(1.0)
            );
        }
    }
}

proptest! {
    /// A double written in SI units reads back as the same double.
    #[test]
    fn si_text_round_trips(value in proptest::num::f64::NORMAL, index in 0..TEXT_FORMS.len()) {
        let (dimension, _) = TEXT_FORMS[index];
        let text = format!("{value:e} {}", dimension.unit());
        prop_assert_eq!(parse(&text, dimension).map(f64::to_bits), Ok(value.to_bits()));
    }

    /// A decimal prefix gives the same double as the shifted decimal exponent.
    #[test]
    fn decimal_prefixes_are_exact(mantissa in -1_000_000_i64..1_000_000, exponent in -20_i32..20) {
        for (unit, ten) in [("mm", -3), ("um", -6), ("nm", -9), ("km", 3)] {
            let shifted: f64 = format!("{mantissa}e{}", exponent + ten).parse().unwrap();
            let read = parse(&format!("{mantissa}e{exponent} {unit}"), Dimension::Length);
            prop_assert_eq!(read, Ok(shifted));
        }
    }

    /// Angles and speeds convert back within a few rounding errors.
    #[test]
    fn revolutions_round_trip(value in 1e-6..1e6_f64) {
        let rpm = parse(&format!("{value} rpm"), Dimension::AngularSpeed).unwrap();
        prop_assert!((rpm * 60.0 / (2.0 * PI) - value).abs() <= 4.0 * f64::EPSILON * value);
        let degrees = parse(&format!("{value} deg"), Dimension::Angle).unwrap();
        prop_assert!((degrees.to_degrees() - value).abs() <= 4.0 * f64::EPSILON * value);
        let hertz = parse(&format!("{value} Hz"), Dimension::AngularSpeed).unwrap();
        let per_minute = parse(&format!("{value} rev/min"), Dimension::AngularSpeed).unwrap();
        prop_assert!((hertz / 60.0 - per_minute).abs() <= 4.0 * f64::EPSILON * per_minute);
    }

    /// No text makes the parser panic.
    #[test]
    fn any_text_is_answered(text in "\\PC{0,24}") {
        let _ = parse_any(&text);
    }

    /// No unit-like text makes the parser panic.
    #[test]
    fn any_unit_like_text_is_answered(text in "[-+]?[0-9._]{0,4}[eE]?[-+0-9]{0,3} ?[mNkgsradPu°µ%^*/ 0-9²³]{0,9}") {
        if let Ok((value, _)) = parse_any(&text) {
            prop_assert!(value.is_finite());
        }
    }
}

#[test]
fn long_numbers_have_a_short_form() {
    assert_eq!(short(1234.56, 1), "1234.6");
    assert_eq!(short(1.2345e150, 1), "1.23e150");
    assert_eq!(short(-1.2345e150, 0), "-1.23e150");
}
