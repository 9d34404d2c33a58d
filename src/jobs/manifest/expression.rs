//! Expressions that give the values of an axis from other axes: `"0.01 * speed^2"`.
//!
//! Names are those of axes. Their values and the result are in SI. A name needs single quotes if it has characters
//! other than letters, digits, `_`, `.` and indices in brackets. The crate `exmex` reads the rest: numbers, `+ - * /
//! ^`, parentheses, functions such as `sqrt`, `sin` and `exp`, and the constant `pi`.

use super::axis::AxisKey;
use crate::units;
use exmex::{Express, FlatEx};

/// The accepted expressions, in words.
pub(super) const ACCEPTED: &str = "numbers, axes of the grid by name, pi, + - * / ^, parentheses, and functions such as sqrt(x), sin(x) or exp(x); for example \
     \"0.01 * speed^2\"";

/// Operators between two values.
const OPERATORS: [char; 5] = ['*', '/', '+', '-', '^'];

/// A value as a function of other axes.
#[derive(Debug, Clone)]
pub struct Expression {
    text: String,
    parsed: FlatEx<f64>,
}

impl Expression {
    /// Whether a text is an expression instead of a quantity such as `10 um`, whose unit may be misspelt.
    pub(super) fn is_expression(text: &str) -> bool {
        let text = text.trim();
        let number = text.trim_start_matches(['+', '-']);
        let digits = number_length(number);
        let behind = number[digits..].trim_start();
        // A unit follows a number without an operator.
        let is_quantity = digits > 0 && !behind.starts_with(OPERATORS);
        let joins = behind.contains(OPERATORS) || behind.contains(['(', '[', '.', '\'']);
        let is_axis = !AxisKey::of(text).is_model_key();
        !is_quantity
            && (joins || is_axis)
            && text.parse::<f64>().is_err()
            && units::parse_any(text).is_err()
    }

    /// Reads a text.
    ///
    /// # Errors
    /// The fault, in words.
    pub(super) fn parse(text: &str) -> Result<Self, String> {
        let marked = marked(text)?;
        let parsed = exmex::parse::<f64>(&marked).map_err(|error| error.to_string())?;
        let text = text.trim().to_owned();
        Ok(Self { text, parsed })
    }

    /// The original text.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The axes that it depends on.
    pub fn names(&self) -> &[String] {
        self.parsed.var_names()
    }

    /// The value of the expression in SI for these values of the axes.
    ///
    /// # Errors
    /// A sentence with the expression and the values if the result is not finite.
    pub fn value(&self, of: impl Fn(&str) -> f64) -> Result<f64, String> {
        let values: Vec<f64> = self.names().iter().map(|name| of(name)).collect();
        let result = self.parsed.eval(&values).unwrap_or(f64::NAN);
        if result.is_finite() {
            return Ok(result);
        }
        let at = self.names().iter().zip(&values);
        let at: Vec<String> = at
            .map(|(name, value)| format!("{name} = {value}"))
            .collect();
        Err(format!(
            "`{}` is {result}, not a finite number, at {}",
            self.text,
            at.join(", ")
        ))
    }
}

/// The text with every name of an axis in braces. The parser accepts any characters in braces.
fn marked(text: &str) -> Result<String, String> {
    let mut out = String::with_capacity(text.len() + 8);
    let mut rest = text;
    // For the top level and every open parenthesis, whether the last operator there is a power.
    let mut has_power = vec![false];
    while let Some(first) = rest.chars().next() {
        let length = match first {
            '\'' => {
                let end = rest[1..].find('\'').ok_or("a single quote is not closed")?;
                out += &format!("{{{}}}", &rest[1..=end]);
                end + 2
            }
            '{' | '}' => return Err("braces have no meaning".to_owned()),
            'a'..='z' | 'A'..='Z' | '_' => {
                let length = name_length(rest);
                let (name, behind) = rest.split_at(length);
                match name {
                    _ if behind.trim_start().starts_with('(') => out += name,
                    "pi" => out += "PI",
                    _ => out += &format!("{{{name}}}"),
                }
                length
            }
            // The parser does not know exponents, such as 1e-3.
            '0'..='9' | '.' => {
                let length = number_length(rest);
                let number = rest[..length].parse::<f64>();
                out += &number.map_err(|error| error.to_string())?.to_string();
                length
            }
            // The parser applies a sign before a power; here the power comes first.
            '+' | '-' if out.trim_end().is_empty() || out.trim_end().ends_with(['(', ',']) => {
                out += if first == '-' { "0-" } else { "0+" };
                1
            }
            '+' | '-' if out.trim_end().ends_with(OPERATORS) => {
                return Err(format!(
                    "a sign follows an operator: write ({first} ...) in parentheses"
                ));
            }
            other => {
                match other {
                    '(' => has_power.push(false),
                    ')' => _ = has_power.pop(),
                    '^' if has_power.last() == Some(&true) => {
                        let remedy = "(a^b)^c or a^(b^c)";
                        return Err(format!("a power of a power needs parentheses: {remedy}"));
                    }
                    _ if other == ',' || OPERATORS.contains(&other) => {
                        has_power
                            .last_mut()
                            .into_iter()
                            .for_each(|power| *power = other == '^');
                    }
                    _ => {}
                }
                out.push(other);
                other.len_utf8()
            }
        };
        rest = &rest[length..];
    }
    Ok(out)
}

/// Length of the name at the start of a text, including its indices in brackets.
fn name_length(text: &str) -> usize {
    let mut inside = false;
    text.find(|c: char| {
        let in_name = match c {
            '[' => !std::mem::replace(&mut inside, true),
            ']' => std::mem::replace(&mut inside, false),
            ',' => inside,
            _ => c.is_ascii_alphanumeric() || c == '_' || c == '.',
        };
        !in_name
    })
    .unwrap_or(text.len())
}

/// Length of the number at the start of a text.
fn number_length(text: &str) -> usize {
    let digits = |text: &str, from: usize| {
        text[from..]
            .find(|c: char| !c.is_ascii_digit())
            .map_or(text.len(), |end| from + end)
    };
    let mut end = digits(text, 0);
    if !text.starts_with(|c: char| c.is_ascii_digit() || c == '.') {
        return 0;
    }
    if text[end..].starts_with('.') {
        end = digits(text, end + 1);
    }
    if text[end..].starts_with(['e', 'E']) {
        let exponent_start = end + 1 + usize::from(text[end + 1..].starts_with(['+', '-']));
        let exponent = digits(text, exponent_start);
        if exponent > exponent_start {
            end = exponent;
        }
    }
    end
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_those_of_the_arithmetic() {
        let at = |name: &str| match name {
            "speed" => 3.0,
            "load" => 0.25,
            "harmonic_load.shaker.force[1]" => 7.0,
            "stiffness_matrix[1,2]" => 11.0,
            "contact.end stop.gap" => 5e-6,
            other => panic!("{other}"),
        };
        let value = |text: &str| Expression::parse(text).unwrap().value(at).unwrap();
        for (text, wanted) in [
            ("0.01 * speed^2", 0.01 * 9.0),
            ("-speed^2", -9.0),
            ("1e-3*speed", 1e-3 * 3.0),
            ("2e3 - load", 2e3 - 0.25),
            ("2 * (-speed^2) + (+1)", -17.0),
            ("2 ^ (-1)", 0.5),
            ("(2^3)^2 + 2^(1^2) * 3^2", 82.0),
            ("sqrt(speed + 1)", 2.0),
            ("max(-1, -load^2)", -0.0625),
            ("max(speed^2, load^2)", 9.0),
            ("sin(pi / 2) * harmonic_load.shaker.force[1]", 7.0),
            ("stiffness_matrix[1,2] / 2", 5.5),
            ("2 * 'contact.end stop.gap'", 1e-5),
            ("2 ^ (speed - 1) / load", 16.0),
        ] {
            assert_eq!(value(text), wanted, "{text}");
        }
        let names = Expression::parse("speed * load + speed").unwrap();
        assert_eq!(names.names(), ["load", "speed"]);
    }

    #[test]
    fn faults_are_told() {
        for wrong in [
            "speed * ",
            "(speed",
            "2 * 'load",
            "{speed}",
            "speed load",
            "nofun(speed)",
            "2 * -speed",
            "2^3^2",
            "(speed^2 + 1)^2^load",
        ] {
            assert!(Expression::parse(wrong).is_err(), "{wrong}");
        }
        let endless = Expression::parse("1 / (speed - 3)")
            .unwrap()
            .value(|_| 3.0)
            .unwrap_err();
        assert!(
            endless.contains("1 / (speed - 3)") && endless.contains("speed = 3"),
            "{endless}"
        );
    }

    #[test]
    fn quantities_are_no_expressions() {
        for text in [
            "10 um",
            "10 unm",
            "-3 N*s/m",
            "1e-5",
            "2",
            "300 rpm",
            "points.csv",
            "5 %",
            "up",
            "1e5 N/sm",
        ] {
            assert!(
                text == "points.csv" || !Expression::is_expression(text),
                "{text}"
            );
        }
        for text in [
            "speed",
            "0.01 * speed^2",
            "-load/2",
            "2*load",
            "1e-3*speed",
            "sqrt(load)",
            "(load)",
        ] {
            assert!(Expression::is_expression(text), "{text}");
        }
    }
}
