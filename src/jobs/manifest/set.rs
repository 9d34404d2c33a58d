//! Keys whose values a command changes: `mesh.half_gap=20 um`.
//!
//! Each change is a separate source, so that messages quote it. The key may be dotted; indices of list entries
//! start at 0. The value is TOML, or a text without quotes if it is not TOML. Without a value, the key or the element
//! of a list is removed.

use super::diagnostic::{Diagnostic, DiagnosticKind, Issues, Span};
use super::grid::Axes;
use super::grid_dimension::GridDimension;
use super::modal_keys;
use super::syntax;
use super::tree::{self, MissingElement, Node, Value};
use toml::de::DeTable;

/// A key with a changed value.
#[derive(Debug)]
pub(super) struct Changed {
    path: Vec<String>,
    key_span: Span,
    /// For a number of the modal file, its new value, or `None` to remove it; `None` for other keys.
    of_file: Option<Node>,
}

impl Changed {
    /// Whether the key names a number of the modal file.
    pub fn is_of_modal_file(&self) -> bool {
        self.path[0] != "grid" && modal_keys::is_modal_number_name(&self.name())
    }

    fn name(&self) -> String {
        self.path.join(".")
    }
}

/// Puts every change of a key of the manifest into the tree. Faulty changes are omitted and reported. Returns
/// the changes that gave a value, and all changes of numbers of the modal file, which are not applied yet.
pub(super) fn apply(tree: &mut Node, changes: &[String], issues: &Issues) -> Vec<Changed> {
    let mut applied = Vec::new();
    for change in changes {
        let change = modal_keys::in_quotes(change);
        let source = issues.add_source("--set".to_owned(), change.to_string());
        let Some((mut changed, node)) = read(source, &change, issues) else {
            continue;
        };
        if changed.is_of_modal_file() {
            changed.of_file = node;
            applied.push(changed);
            continue;
        }
        let path: Vec<&str> = changed.path.iter().map(String::as_str).collect();
        let Some(node) = node else {
            if !tree.take_out(&path) {
                issues.push(nothing_to_remove(&changed));
            }
            continue;
        };
        match tree.put(&path, node) {
            Ok(()) => applied.push(changed),
            Err(end) => {
                let remedy = format!(
                    "elements count from 0; set `{}` as a whole instead",
                    end.holder
                );
                issues.push(no_element(&changed, end).remedy(remedy));
            }
        }
    }
    applied
}

/// Puts the changes of numbers of the modal file into its tree, which is part of the manifest's.
pub(super) fn apply_to_modal_file(tree: &mut Node, changes: &[Changed], issues: &Issues) {
    for changed in changes.iter().filter(|changed| changed.is_of_modal_file()) {
        let name = changed.name();
        match &changed.of_file {
            Some(node) => {
                if let Err(end) = modal_keys::put(tree, &name, node.clone()) {
                    issues.push(no_element(changed, end).remedy(
                        "indices in brackets count from 1; write the list or the table in the modal file first",
                    ));
                }
            }
            None if !modal_keys::take_out(tree, &name) => issues.push(nothing_to_remove(changed)),
            None => {}
        }
    }
}

fn nothing_to_remove(changed: &Changed) -> Diagnostic {
    let file = if changed.is_of_modal_file() { "modal file" } else { "manifest" };
    Diagnostic::new(
        DiagnosticKind::UnknownKey,
        changed.key_span,
        &changed.name(),
        format!("`{}` is not in the {file}", changed.name()),
    )
    .label("nothing to remove")
    .remedy(format!(
        "--set KEY= removes a key from the {file}; give a value, or remove this --set"
    ))
}

fn no_element(changed: &Changed, end: MissingElement) -> Diagnostic {
    Diagnostic::new(
        DiagnosticKind::UnknownKey,
        changed.key_span,
        &changed.name(),
        format!(
            "`{}` names an element that does not exist: `{}` {}",
            changed.name(),
            end.holder,
            end.why
        ),
    )
    .label("no such element")
    .suggestion(end.near.map(|near| format!("`{near}`")))
}

/// Reports changes of keys that an axis of the grid varies: they have no effect.
pub(super) fn check_axes(tree: &Node, changes: &[Changed], axes: &Axes, issues: &Issues) {
    for changed in changes {
        let name = changed.name();
        let place = (axes.valid.iter()).position(|axis| axis.axis.name() == name);
        let Some(place) = place else {
            continue;
        };
        let index = GridDimension::of(&axes.dimensions, place);
        let dimension = &axes.dimensions[index];
        let remedy = if tree.at("grid").and_then(|grid| grid.entry(&name)).is_none() {
            "it is a column of grid.points: set grid.points to another list or file".to_owned()
        } else if dimension.is_tied() && !dimension.sampled {
            let tied = (dimension.axes.iter()).filter(|axis| **axis != place);
            let tied: Vec<&str> = tied.map(|axis| axes.valid[*axis].axis.name()).collect();
            format!(
                "give the axis as many values, {}, as {}, which is tied to it: --set 'grid.\"{name}\"={{ values = [...] }}'",
                dimension.length,
                tied.join(" and "),
            )
        } else {
            format!("set the axis: --set 'grid.\"{name}\"=VALUE'")
        };
        let message = format!("`{name}` has no effect: the grid varies it");
        Diagnostic::new(
            DiagnosticKind::Inconsistent,
            changed.key_span,
            &name,
            message,
        )
        .label("no effect")
        .remedy(remedy)
        .report(issues);
    }
}

/// The key and the value, if any, of a text `KEY=VALUE`; `None` if it is not such a text, which is reported.
fn read(source: usize, text: &str, issues: &Issues) -> Option<(Changed, Option<Node>)> {
    let span = |start: usize, end: usize| Span { source, start, end };
    let Some((key, value)) = text.split_once('=') else {
        let message = format!("`{text}` is not of the form KEY=VALUE");
        return Diagnostic::new(DiagnosticKind::Syntax, span(0, text.len()), "", message)
            .label("no `=`")
            .remedy("write for example --set mesh.half_gap=\"20 um\"")
            .fail(issues);
    };
    let key_span = span(0, key.trim_end().len());
    let Some(path) = parts(key) else {
        let message = format!("`{}` is not a key", key.trim());
        let remedy = "give a dotted name such as mesh.half_gap; for an axis of the grid, grid.\"mesh.half_gap\" with its quotes";
        return Diagnostic::new(DiagnosticKind::Syntax, key_span, "", message)
            .label("here")
            .remedy(remedy)
            .fail(issues);
    };
    let changed = Changed {
        path,
        key_span,
        of_file: None,
    };
    let bare = value.trim();
    if bare.is_empty() {
        return Some((changed, None));
    }
    let start = text.len() - value.trim_start().len();
    let value_span = span(start, start + bare.len());
    let node = match DeTable::parse(text) {
        Ok(table) => {
            let root = tree::of_table(source, table, issues);
            let levels = (0..changed.path.len()).try_fold(root, |node, _| only(node));
            levels.or_else(|| {
                let message = "one --set changes several keys";
                Diagnostic::new(
                    DiagnosticKind::Syntax,
                    span(0, text.len()),
                    &changed.name(),
                    message,
                )
                .label("more than KEY=VALUE")
                .remedy("give each key a separate --set")
                .fail(issues)
            })?
        }
        Err(error) if bare.starts_with(['[', '{', '"', '\'']) => {
            syntax::report(source, text, &[error], issues);
            return None;
        }
        Err(_) => Node {
            span: value_span,
            value: Value::Text(bare.to_owned()),
        },
    };
    Some((changed, Some(node)))
}

/// The parts of a dotted key; `None` if the text is not a key.
fn parts(key: &str) -> Option<Vec<String>> {
    let text = format!("{key}=0");
    let issues = Issues::default();
    let mut node = tree::of_table(0, DeTable::parse(&text).ok()?, &issues);
    let mut parts = Vec::new();
    while let Value::Table(entries) = &node.value {
        parts.push(entries.first()?.key.clone());
        node = only(node)?;
    }
    (!parts.is_empty()).then_some(parts)
}

/// The value of the only entry of a table.
fn only(node: Node) -> Option<Node> {
    match node.value {
        Value::Table(mut entries) if entries.len() == 1 => entries.pop().map(|entry| entry.node),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(text: &str) -> (Vec<String>, Value) {
        let issues = Issues::default();
        let source = issues.add_source("--set".to_owned(), text.to_owned());
        let (changed, node) = read(source, text, &issues).unwrap();
        assert_eq!(issues.count(), 0, "{text}");
        (changed.path, node.unwrap().value)
    }

    #[test]
    fn a_key_without_a_value_is_taken_out() {
        let take = |change: &str| {
            let issues = Issues::default();
            let text = "[run]\ncycles = 3\nsteps = 1\n[[a.b]]\nc = 1\n";
            let source = issues.add_source("m.toml".to_owned(), text.to_owned());
            let mut root = tree::parse(source, &issues);
            apply(&mut root, &[change.to_owned()], &issues);
            let left = [&["run", "steps"][..], &["a", "b", "0", "c"]];
            (left.map(|path| root.take_out(path)), issues.count())
        };
        assert_eq!(take("run.steps="), ([false, true], 0));
        assert_eq!(take("a.b.0.c = "), ([true, false], 0));
        for element in ["a.b.0=", "a.b="] {
            assert_eq!(take(element), ([true, false], 0), "{element}");
        }
        for absent in [
            "run.transient=",
            "run.cycles.x=",
            "a.b.1.c=",
            "a.b.1=",
            "a.b.c=",
        ] {
            assert_eq!(take(absent), ([true, true], 1), "{absent}");
        }
    }

    #[test]
    fn values_are_toml_or_bare_texts() {
        let text = |value: Value| match value {
            Value::Text(text) => text,
            other => panic!("{other:?}"),
        };
        for typed in ["mesh.half_gap=20 um", "mesh.half_gap = \"20 um\""] {
            let (path, found) = value(typed);
            assert_eq!(path, ["mesh", "half_gap"]);
            assert_eq!(text(found), "20 um");
        }
        assert_eq!(text(value("mesh.stiffness=constant").1), "constant");
        assert!(matches!(value("run.cycles=300").1, Value::Integer(300)));
        assert!(matches!(value("run.settle=false").1, Value::Boolean(false)));
        let (path, found) = value("grid.\"mesh.half_gap\"={ values = [1e-5] }");
        assert_eq!(path, ["grid", "mesh.half_gap"]);
        assert!(matches!(found, Value::Table(entries) if entries.len() == 1));
        let (path, _) = value("excitation.torque_ripple.0.order=2");
        assert_eq!(path, ["excitation", "torque_ripple", "0", "order"]);
    }

    #[test]
    fn faults_are_in_the_text() {
        for (typed, kind, start) in [
            ("mesh.half_gap", DiagnosticKind::Syntax, 0),
            ("=3", DiagnosticKind::Syntax, 0),
            ("mesh.half gap=3", DiagnosticKind::Syntax, 0),
            ("a=1\nb=2", DiagnosticKind::Syntax, 0),
        ] {
            let issues = Issues::default();
            let source = issues.add_source("--set".to_owned(), typed.to_owned());
            assert!(read(source, typed, &issues).is_none(), "{typed}");
            let fault = &issues.found.borrow()[0];
            assert_eq!((fault.kind, fault.span.start), (kind, start), "{typed}");
        }
    }
}
