//! Finds keys that do not exist.

use super::diagnostic::{Diagnostic, DiagnosticKind, Issues};

use super::schema::{self, Kind, Schema};
use super::tree::{Entry, Node, Value};

/// Reports every unknown key below `node`. The reader of the grid checks the grid's axes.
pub(super) fn check(issues: &Issues, node: &Node, schema: Schema) {
    check_table(issues, node, "", schema);
}

fn check_table(issues: &Issues, node: &Node, path: &str, schema: Schema) {
    let Value::Table(entries) = &node.value else {
        return;
    };
    for entry in entries {
        let child = if path.is_empty() {
            entry.key.clone()
        } else {
            format!("{path}.{}", entry.key)
        };
        // A quoted key that contains dots is not a path of nested keys.
        let known = (!entry.key.contains('.'))
            .then(|| schema::find(schema, &child))
            .flatten();
        match known.map(|key| key.kind) {
            None if path == "grid" => {}
            None => issues.push_with(|| unknown(entry, path, &child, schema)),
            Some(Kind::Table | Kind::InitialState) => {
                check_table(issues, &entry.node, &child, schema)
            }
            Some(Kind::List(_)) => check_list(issues, &entry.node, &child, schema),
            Some(_) => {}
        }
    }
}

fn check_list(issues: &Issues, node: &Node, path: &str, schema: Schema) {
    if let Value::Array(items) = &node.value {
        for (i, item) in items.iter().enumerate() {
            check_table(issues, item, &format!("{path}.{i}"), schema);
        }
    }
}

fn unknown(entry: &Entry, path: &str, child: &str, schema: Schema) -> Diagnostic {
    let siblings = schema::children(schema, path);
    let what = match (&entry.node.value, path.is_empty()) {
        (Value::Table(_), true) => format!("there is no table [{child}]"),
        _ => format!("there is no key `{child}`"),
    };
    let in_train = path == "train" || path.starts_with("train.");
    // With a train, the tables of other kinds of drive have no effect.
    let homes: Vec<&str> = (schema::tables_with_key(schema, &entry.key).into_iter())
        .filter(|home| {
            !in_train
                || !["gear", "shafts"]
                    .iter()
                    .any(|prefix| home.starts_with(prefix))
        })
        .collect();
    let suggestion = schema::nearest(&entry.key, &siblings)
        .map(|near| format!("`{near}`"))
        .or_else(|| {
            (!homes.is_empty())
                .then(|| format!("`{}` belongs in [{}]", entry.key, homes.join("] or [")))
        });
    let place = match path {
        "" => "at the top of the file".to_owned(),
        path => format!("in `{path}`"),
    };
    Diagnostic::new(DiagnosticKind::UnknownKey, entry.key_span, child, what)
        .label("unknown")
        .accepted(format!("{place}: {}", siblings.join(", ")))
        .suggestion(suggestion)
}
