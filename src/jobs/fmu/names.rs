//! Names of variables by the structured convention of FMI: parts between dots. A part that is not an identifier has
//! quotes.

/// A part of a name, in quotes if it is not an identifier.
pub fn part(name: &str) -> String {
    let first = |c: char| c.is_ascii_alphabetic() || c == '_';
    let plain = name.starts_with(first) && name.chars().all(|c| first(c) || c.is_ascii_digit());
    if plain {
        name.to_owned()
    } else {
        format!("'{}'", name.replace('\\', "\\\\").replace('\'', "\\'"))
    }
}

/// The name of the variable for a key of the manifest. Keys and names count the elements of lists from 0.
pub fn of_key(key: &str) -> String {
    let mut name = String::new();
    for piece in key.split('.') {
        if !piece.is_empty() && piece.bytes().all(|b| b.is_ascii_digit()) {
            name += &format!("[{piece}]");
        } else {
            name += if name.is_empty() { "" } else { "." };
            name += &part(piece);
        }
    }
    name
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_identifier_is_quoted() {
        for (name, written) in [
            ("wheel_2", "wheel_2"),
            ("pinion 1 x", "'pinion 1 x'"),
            ("2nd", "'2nd'"),
            ("", "''"),
            (r"it's \ é", r"'it\'s \\ é'"),
        ] {
            assert_eq!(part(name), written);
        }
        let key = "excitation.transmission_error.0.amplitude";
        assert_eq!(of_key(key), "excitation.transmission_error[0].amplitude");
    }
}
