//! The text form as a regular expression, for editors that check a file as it is written.

use super::Dimension;
use super::expression::{PREFIXES, SYMBOLS};

/// A decimal number, as [`parse`](super::parse) reads it.
const NUMBER: &str = r"[+-]?(?:\d[\d_]*\.?[\d_]*|\.[\d_]*\d[\d_]*)(?:[eE][+-]?\d+)?";

impl Dimension {
    /// A regular expression (ECMA 262) for texts of this dimension; `None` if only bare numbers are accepted. It
    /// matches a number with a product or quotient of units. It does not add up powers: it refuses `"15 N"` as a
    /// length, but not `"15 N/mm"` as a force.
    pub fn pattern(self) -> Option<String> {
        let mut allowed = self.exponents()?.0.map(|exponent| exponent != 0);
        // A dimension with mass can be written with N or Pa, which contain m and s: N/m is kg/s². Allow m and
        // s.
        if allowed[0] {
            allowed[1] = true;
            allowed[2] = true;
        }
        let fits =
            |exponents: [i32; 4]| (exponents.iter().zip(allowed)).all(|(e, fits)| *e == 0 || fits);
        let named = |prefixed: bool| -> Vec<&str> {
            SYMBOLS
                .iter()
                .filter(|symbol| symbol.takes_prefix == prefixed && fits(symbol.exponents))
                .map(|symbol| symbol.text)
                // Omit the unit `1`. With it, the bare number `0.1` would match as `0.` with the unit `1`.
                .filter(|text| *text != "1")
                .collect()
        };
        let prefixes: String = PREFIXES.iter().map(|(prefix, _)| prefix).collect();
        let mut symbols = named(false).join("|");
        if !named(true).is_empty() {
            let bar = if symbols.is_empty() { "" } else { "|" };
            symbols += &format!("{bar}[{prefixes}]?(?:{})", named(true).join("|"));
        }
        let unit = format!(r"(?:{symbols})(?:\^[+-]?\d+|[²³])?");
        let joint = r"(?:\s*[*·⋅/]\s*|\s+)";
        Some(format!(r"^\s*{NUMBER}\s*{unit}(?:{joint}{unit})*\s*$"))
    }
}
