//! Advice on a valid manifest, for `atlas check`.

use crate::manifest::{Advice, AdviceKind, Place};
use serde_json::{Value, json};

/// Label and text of each line of advice. Equal advice on several keys is one line that names all these keys.
pub fn lines(advice: &[Advice]) -> Vec<(String, String)> {
    let mut groups: Vec<(AdviceKind, &str, Vec<String>)> = Vec::new();
    for word in advice {
        let place = match word.place {
            Some(Place::Line(line)) => format!("{} (line {line})", word.key),
            Some(Place::Set) => format!("{} (--set)", word.key),
            None => word.key.clone(),
        };
        match groups
            .iter_mut()
            .find(|(kind, message, _)| *kind == word.kind && *message == word.message)
        {
            Some((.., places)) => places.push(place),
            None => groups.push((word.kind, word.message.as_str(), vec![place])),
        }
    }
    let line = |(kind, message, places): (AdviceKind, &str, Vec<String>)| {
        (
            head(kind).to_owned(),
            format!("{}: {message}", places.join(", ")),
        )
    };
    groups.into_iter().map(line).collect()
}

fn head(kind: AdviceKind) -> &'static str {
    match kind {
        AdviceKind::Suspect => "warning",
        AdviceKind::NoEffect => "no effect",
    }
}

/// The advice as JSON, for programs.
pub fn json(advice: &[Advice]) -> Value {
    let each = advice.iter().map(|word| {
        let kind = match word.kind {
            AdviceKind::Suspect => "suspect",
            AdviceKind::NoEffect => "no_effect",
        };
        let line = match word.place {
            Some(Place::Line(line)) => Some(line),
            Some(Place::Set) | None => None,
        };
        let set = word.place == Some(Place::Set);
        json!({ "kind": kind, "key": word.key, "line": line, "set": set, "message": word.message })
    });
    Value::Array(each.collect())
}
