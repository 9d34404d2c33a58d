//! Every key of a manifest, a modal file and a housing file: values, range, default and meaning. Users of these tables
//! are the readers' defaults, errors about unknown keys, grid axes, messages about accepted values, the manual and the
//! JSON Schema.

mod key;
mod keys;
#[cfg(test)]
mod tests;

pub(in crate::manifest) use key::{
    ANY, Bounds, DefaultValue, Key, Kind, OtherTables, POSITIVE, SEED, SHARED, VARIABLE_TABLES,
    choice, draws_one_gear, integer, quantity,
};
pub(in crate::manifest) use keys::{FEWEST_CYCLES, HOUSING_FILE, MANIFEST, MODAL_FILE, OF_MESH};

/// The keys of a file, table by table.
pub(in crate::manifest) type Schema = &'static [&'static [Key]];

/// All keys of a file.
pub(in crate::manifest) fn all(schema: Schema) -> impl Iterator<Item = &'static Key> {
    schema.iter().flat_map(|keys| keys.iter())
}

/// A number as people write it: `0.05`, `4.4e8`.
pub(in crate::manifest) fn number(value: f64) -> String {
    let magnitude = value.abs();
    if value == 0.0 || (1e-3..1e6).contains(&magnitude) {
        format!("{value}")
    } else {
        format!("{value:e}")
    }
}

/// The schema's form of a path: indices become `*`, `pinion` and `wheel` in `[shafts]` become `<shaft>`.
fn pattern(path: &str) -> String {
    let mut out = String::with_capacity(path.len() + 4);
    for (i, segment) in path.split('.').enumerate() {
        if i > 0 {
            out.push('.');
        }
        let is_index = segment.bytes().all(|b| b.is_ascii_digit()) && !segment.is_empty();
        let is_shaft = i == 1 && out == "shafts." && matches!(segment, "pinion" | "wheel");
        out.push_str(match (is_index, is_shaft) {
            (true, _) => "*",
            (_, true) => "<shaft>",
            _ => segment,
        });
    }
    out
}

/// The name of a shared key in its original table, and the group that it belongs to: `shafts.rest` for
/// `shafts.<shaft>.rest`.
fn shared_form(pattern: &str) -> Option<(String, OtherTables)> {
    SHARED.iter().find_map(|&(table, of, which)| {
        let rest = pattern.strip_prefix(table)?;
        let whole = rest.is_empty() || rest.starts_with('.');
        whole.then(|| (format!("{of}{rest}"), which))
    })
}

/// The entry for a dotted path such as `excitation.torque_ripple.0.order`. An element of a pair, such as `gear.bore.1`,
/// has the entry of its key.
pub(in crate::manifest) fn find(schema: Schema, path: &str) -> Option<&'static Key> {
    let pattern = pattern(path);
    named(schema, &pattern).or_else(|| {
        let both = pattern.strip_suffix(".*")?;
        named(schema, both).filter(|key| key.pair.is_some())
    })
}

/// The entry for a pattern, possibly in another table.
fn named(schema: Schema, pattern: &str) -> Option<&'static Key> {
    let exact = |wanted: &str| all(schema).find(|key| key.path == wanted);
    let shared = || {
        let (form, which) = shared_form(pattern)?;
        exact(&form).filter(|key: &&Key| key.elsewhere == which)
    };
    exact(pattern).or_else(shared)
}

/// The names of the keys directly below a path (`""` for the top level).
pub(in crate::manifest) fn children(schema: Schema, path: &str) -> Vec<&'static str> {
    let pattern = pattern(path);
    let mut names = below(schema, &pattern, |_| true);
    if let Some((shared, which)) = shared_form(&pattern) {
        names.extend(below(schema, &shared, |key| key.elsewhere == which));
    }
    names
}

fn below(schema: Schema, pattern: &str, wanted: impl Fn(&Key) -> bool) -> Vec<&'static str> {
    let prefix = match pattern {
        "" => String::new(),
        pattern => format!("{pattern}."),
    };
    let mut names = Vec::new();
    for key in all(schema).filter(|key| wanted(key)) {
        match key.path.strip_prefix(&prefix) {
            Some("<shaft>") => names.extend(["pinion", "wheel"]),
            Some(rest) if !rest.contains('.') && rest != "*" => names.push(rest),
            _ => {}
        }
    }
    names
}

/// Length limit of a name for which a similar name is searched \[bytes\].
const LONGEST_MISSPELT: usize = 120;

/// The nearest of some names, if any is similar enough.
pub(in crate::manifest) fn nearest<'n>(name: &str, known: &[&'n str]) -> Option<&'n str> {
    // The work grows with the length, and no known name is half as long.
    if name.len() > LONGEST_MISSPELT {
        return None;
    }
    let folded = name.to_lowercase().replace('-', "_");
    known
        .iter()
        .map(|&candidate| (strsim::damerau_levenshtein(&folded, candidate), candidate))
        .filter(|&(distance, candidate)| {
            let longer = candidate.chars().count().max(folded.chars().count());
            distance * 3 <= longer || (folded.len() >= 4 && candidate.contains(&folded))
        })
        .min_by_key(|&(distance, _)| distance)
        .map(|(_, candidate)| candidate)
}

/// The nearest of some dotted paths, by the whole path or its last part.
pub(in crate::manifest) fn nearest_path<'n>(name: &str, paths: &[&'n str]) -> Option<&'n str> {
    let last = |path: &&'n str| path.rsplit('.').next().unwrap_or(path);
    let last: Vec<&str> = paths.iter().map(last).collect();
    let by_last = || {
        let near = nearest(name, &last)?;
        last.iter().position(|part| *part == near).map(|i| paths[i])
    };
    nearest(name, paths).or_else(by_last)
}

/// Words in quotes, separated by commas.
pub(in crate::manifest) fn quoted(words: &[&str]) -> String {
    let quoted: Vec<String> = words.iter().map(|word| format!("\"{word}\"")).collect();
    quoted.join(", ")
}

/// The tables with a key of exactly this name, except entries of lists and the table of either shaft.
pub(in crate::manifest) fn tables_with_key(schema: Schema, name: &str) -> Vec<&'static str> {
    all(schema)
        .filter_map(|key| key.path.rsplit_once('.'))
        .filter(|&(home, last)| last == name && !home.contains(['*', '<']))
        .map(|(home, _)| home)
        .collect()
}
