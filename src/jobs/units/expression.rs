//! Unit expressions such as `kg*m^2`, `N*m/rad`, `kN/mm`. Each becomes a power of ten, a factor and the
//! exponents of kg, m, s and rad.

use std::f64::consts::PI;

/// Exponents of kg, m, s, rad. The angle counts as a dimension, so that a torque differs from a tilt stiffness, and a
/// rate per second from an angular speed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Exponents(pub [i32; 4]);

/// A unit: `10^ten · factor` in SI. `factor` is 1 for every decimal unit.
#[derive(Debug, Clone, Copy)]
pub(super) struct Unit {
    pub ten: i32,
    pub factor: f64,
    pub exponents: Exponents,
}

/// The error for an expression: its part that is not a unit.
pub(super) struct UnitError {
    pub part: String,
}

/// A unit symbol and its value in SI, `10^ten · factor`.
pub(super) struct Symbol {
    pub text: &'static str,
    ten: i32,
    factor: f64,
    pub exponents: [i32; 4],
    pub takes_prefix: bool,
}

const fn symbol(text: &'static str, ten: i32, factor: f64, exponents: [i32; 4]) -> Symbol {
    Symbol {
        text,
        ten,
        factor,
        exponents,
        takes_prefix: false,
    }
}

const fn prefixable(text: &'static str, ten: i32, factor: f64, exponents: [i32; 4]) -> Symbol {
    Symbol {
        text,
        ten,
        factor,
        exponents,
        takes_prefix: true,
    }
}

pub(super) const SYMBOLS: [Symbol; 17] = [
    prefixable("m", 0, 1.0, [0, 1, 0, 0]),
    prefixable("g", -3, 1.0, [1, 0, 0, 0]),
    prefixable("s", 0, 1.0, [0, 0, 1, 0]),
    prefixable("N", 0, 1.0, [1, 1, -2, 0]),
    prefixable("Nm", 0, 1.0, [1, 2, -2, 0]),
    prefixable("Pa", 0, 1.0, [1, -1, -2, 0]),
    prefixable("rad", 0, 1.0, [0, 0, 0, 1]),
    prefixable("Hz", 0, 2.0 * PI, [0, 0, -1, 1]),
    symbol("rpm", 0, PI / 30.0, [0, 0, -1, 1]),
    symbol("rev", 0, 2.0 * PI, [0, 0, 0, 1]),
    symbol("deg", 0, PI / 180.0, [0, 0, 0, 1]),
    symbol("°", 0, PI / 180.0, [0, 0, 0, 1]),
    symbol("min", 0, 60.0, [0, 0, 1, 0]),
    symbol("h", 0, 3600.0, [0, 0, 1, 0]),
    symbol("%", -2, 1.0, [0, 0, 0, 0]),
    symbol("1", 0, 1.0, [0, 0, 0, 0]),
    symbol("t", 3, 1.0, [1, 0, 0, 0]),
];

/// Metric prefixes and their powers of ten. Two code points of the micro sign are in use: U+00B5 and U+03BC.
pub(super) const PREFIXES: [(char, i32); 10] = [
    ('G', 9),
    ('M', 6),
    ('k', 3),
    ('c', -2),
    ('m', -3),
    ('u', -6),
    ('µ', -6),
    ('μ', -6),
    ('n', -9),
    ('p', -12),
];

/// Largest absolute power of a factor. A larger one is a typing error.
const MAX_POWER: u32 = 9;

/// Reads a unit expression without blanks at its ends.
pub(super) fn parse(text: &str) -> Result<Unit, UnitError> {
    let mut unit = Unit {
        ten: 0,
        factor: 1.0,
        exponents: Exponents([0; 4]),
    };
    let mut rest = text;
    let mut sign = 1;
    loop {
        rest = rest.trim_start();
        let end = rest
            .find(|c: char| c.is_whitespace() || matches!(c, '*' | '·' | '⋅' | '/'))
            .unwrap_or(rest.len());
        let (factor, after) = rest.split_at(end);
        multiply(&mut unit, factor, sign).ok_or_else(|| UnitError {
            part: if factor.is_empty() { text } else { factor }.to_owned(),
        })?;
        rest = after.trim_start();
        let Some(separator) = rest.chars().next() else {
            return Ok(unit);
        };
        sign = if separator == '/' { -1 } else { 1 };
        if matches!(separator, '*' | '·' | '⋅' | '/') {
            rest = &rest[separator.len_utf8()..];
        }
    }
}

fn multiply(unit: &mut Unit, factor: &str, sign: i32) -> Option<()> {
    let (name, power) = split_power(factor)?;
    let (prefix, symbol) = find(name)?;
    let power = sign * power;
    unit.ten = unit.ten.checked_add(power * (prefix + symbol.ten))?;
    unit.factor *= symbol.factor.powi(power);
    for (total, exponent) in unit.exponents.0.iter_mut().zip(symbol.exponents) {
        *total = total.checked_add(power * exponent)?;
    }
    Some(())
}

/// Splits `m^2` or `m²` into the name and the power; `None` if the power is 0, too large or not a whole number.
fn split_power(factor: &str) -> Option<(&str, i32)> {
    let (name, power) = if let Some(name) = factor.strip_suffix('²') {
        (name, 2)
    } else if let Some(name) = factor.strip_suffix('³') {
        (name, 3)
    } else if let Some((name, power)) = factor.split_once('^') {
        (name, power.parse().ok()?)
    } else {
        (factor, 1)
    };
    (power != 0 && i32::unsigned_abs(power) <= MAX_POWER).then_some((name, power))
}

fn find(name: &str) -> Option<(i32, &'static Symbol)> {
    let exact = |text: &str| SYMBOLS.iter().find(|symbol| symbol.text == text);
    if let Some(symbol) = exact(name) {
        return Some((0, symbol));
    }
    let first = name.chars().next()?;
    let (_, ten) = PREFIXES.iter().find(|(prefix, _)| *prefix == first)?;
    let symbol = exact(&name[first.len_utf8()..])?;
    symbol.takes_prefix.then_some((*ten, symbol))
}
