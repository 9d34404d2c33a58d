//! Typed reading of a table: every accessor checks type, unit and range by the schema, records faults and returns
//! `None`, so that one pass finds every fault.

mod default;
mod value;

pub(super) use default::default_of;
pub(super) use value::{EXACT, Given, meant};

use super::diagnostic::{Diagnostic, DiagnosticKind, Issues, Span};
use super::schema::{self, Key, Kind, Schema};
use super::tree::{Entry, Node, Value, entries};
use std::str::FromStr;

/// A struct whose fields are read one by one. All are read before the first missing field makes the result `None`, so
/// that all faults are found.
macro_rules! all_of {
    ($type:ident $(::$variant:ident)? { $($field:ident: $value:expr),+ $(, ..$rest:expr)? $(,)? }) => {{
        $(let $field = $value;)+
        Some($type $(::$variant)? { $($field: $field?,)+ $(..$rest)? })
    }};
}
pub(super) use all_of;

/// All values, or `None` if one is missing. Every one is read, so that all faults are found.
pub(super) fn all_or_none<T>(values: impl Iterator<Item = Option<T>>) -> Option<Vec<T>> {
    let values: Vec<Option<T>> = values.collect();
    values.into_iter().collect()
}

/// A table of a file, with its dotted path.
#[derive(Debug, Clone)]
pub(super) struct Section<'t> {
    /// Dotted path, empty for the top level of a file.
    pub path: String,
    /// Place for reports of missing keys: the table's header.
    pub span: Span,
    entries: &'t [Entry],
    schema: Schema,
    /// The list in which faults are recorded.
    pub issues: &'t Issues,
}

impl<'t> Section<'t> {
    /// The top level of a file.
    pub fn root(node: &'t Node, issues: &'t Issues, schema: Schema) -> Self {
        let entries = match &node.value {
            Value::Table(entries) => entries.as_slice(),
            _ => &[],
        };
        let span = Span {
            end: node.span.start,
            ..node.span
        };
        Self {
            path: String::new(),
            span,
            entries,
            schema,
            issues,
        }
    }

    pub fn entry(&self, name: &str) -> Option<&'t Entry> {
        self.entries.iter().find(|entry| entry.key == name)
    }

    pub fn entries(&self) -> &'t [Entry] {
        self.entries
    }

    pub fn has(&self, name: &str) -> bool {
        self.entry(name).is_some()
    }

    /// Whether a key below this table is given, by its dotted path relative to it.
    pub fn has_below(&self, path: &str) -> bool {
        let (first, rest) = path.split_once('.').unwrap_or((path, ""));
        self.entry(first)
            .is_some_and(|entry| rest.is_empty() || entry.node.at(rest).is_some())
    }

    /// The dotted path of a key of this table.
    pub fn path_of(&self, name: &str) -> String {
        if self.path.is_empty() {
            name.to_owned()
        } else {
            format!("{}.{name}", self.path)
        }
    }

    /// The schema's entry for a path, which must exist.
    pub fn spec(&self, path: &str) -> &'static Key {
        schema::find(self.schema, path)
            .unwrap_or_else(|| unreachable!("`{path}` is read but not in the schema"))
    }

    /// The name of the table in messages.
    fn title(&self) -> String {
        if self.path.is_empty() {
            "the file".to_owned()
        } else {
            format!("`{}`", self.path)
        }
    }

    /// Records that a key is missing.
    pub fn missing(&self, name: &str) {
        let path = self.path_of(name);
        let spec = self.spec(&path);
        let mut diagnostic = Diagnostic::new(
            DiagnosticKind::MissingKey,
            self.span,
            &path,
            match spec.kind {
                Kind::Table => format!("the table [{path}] is missing"),
                _ => format!("`{path}` is missing"),
            },
        )
        .label(format!("{} must have `{name}`", self.title()))
        .accepted(spec.accepted());
        if spec.kind != Kind::Table {
            diagnostic = diagnostic.remedy(format!("add {name} = {}", spec.example));
        }
        self.issues.push(diagnostic);
    }

    /// A subtable: `Some(None)` if absent; `None` if the value is not a table, which is reported.
    pub fn child(&self, name: &str) -> Option<Option<Self>> {
        let Some(entry) = self.entry(name) else {
            return Some(None);
        };
        match self.of_node(&entry.node, self.path_of(name)) {
            Some(section) => Some(Some(Self {
                span: entry.key_span,
                ..section
            })),
            None => self.given(name, |given| given.wrong_type()),
        }
    }

    /// A subtable; one without entries if it is absent.
    pub fn child_or_empty(&self, name: &str) -> Option<Self> {
        let empty = || Self {
            path: self.path_of(name),
            ..self.bare()
        };
        Some(self.child(name)?.unwrap_or_else(empty))
    }

    /// A required subtable.
    pub fn required_child(&self, name: &str) -> Option<Section<'t>> {
        let child = self.child(name)?;
        if child.is_none() {
            self.missing(name);
        }
        child
    }

    /// The section of a node; `None` if the node is not a table.
    fn of_node(&self, node: &'t Node, path: String) -> Option<Self> {
        match &node.value {
            Value::Table(entries) => Some(Self {
                path,
                span: node.span,
                entries,
                schema: self.schema,
                issues: self.issues,
            }),
            _ => None,
        }
    }

    /// A key, or its default; reports a key that has neither.
    pub fn required(&self, name: &str) -> Option<&'t Entry> {
        let default = || default_of(self.spec(&self.path_of(name)));
        let entry = self.entry(name).or_else(default);
        if entry.is_none() {
            self.missing(name);
        }
        entry
    }

    /// Reads the value of a key, or its default.
    fn given<T>(&self, name: &str, read: impl FnOnce(Given) -> Option<T>) -> Option<T> {
        let node = &self.required(name)?.node;
        let path = &self.path_of(name);
        read(Given {
            issues: self.issues,
            node,
            path,
            spec: self.spec(path),
        })
    }

    /// A quantity in SI, or its default.
    pub fn quantity(&self, name: &str) -> Option<f64> {
        self.given(name, |given| given.quantity())
    }

    /// A whole number that fits its type, or its default.
    pub fn integer<T: TryFrom<u64>>(&self, name: &str) -> Option<T> {
        T::try_from(self.given(name, |given| given.integer())?).ok()
    }

    /// A whole number, or `default`, which depends on other keys.
    pub fn integer_or<T: TryFrom<u64>>(&self, name: &str, default: T) -> Option<T> {
        if self.has(name) { self.integer(name) } else { Some(default) }
    }

    /// `true` or `false`.
    pub fn boolean(&self, name: &str) -> Option<bool> {
        self.given(name, |given| match given.node.value {
            Value::Boolean(value) => Some(value),
            _ => given.wrong_type(),
        })
    }

    /// A text, or its default.
    pub fn text(&self, name: &str) -> Option<&'t str> {
        match &self.required(name)?.node.value {
            Value::Text(text) => Some(text),
            _ => self.given(name, |given| given.wrong_type()),
        }
    }

    /// One of the schema's words for this key, or its default.
    pub fn choice(&self, name: &str) -> Option<&'static str> {
        self.given(name, |given| given.choice())
    }

    /// The variant that one of the schema's words names.
    pub fn variant<T: FromStr>(&self, name: &str) -> Option<T> {
        self.choice(name)?.parse().ok()
    }

    /// The elements of a list; `None` if it is not a list or has another length than expected.
    pub fn list(&self, name: &str, length: Option<usize>) -> Option<&'t [Node]> {
        let Value::Array(items) = &self.required(name)?.node.value else {
            return self.given(name, |given| given.wrong_type());
        };
        let Some(length) = length.filter(|length| *length != items.len()) else {
            return Some(items);
        };
        let path = self.path_of(name);
        let spec = self.spec(&path);
        let message = format!("`{path}` has {}, not {length}", entries(items.len()));
        self.fault(DiagnosticKind::WrongType, name, message)
            .label(format!("{length} entries are needed"))
            .accepted(match spec.kind {
                Kind::List(_) => spec.accepted(),
                _ => format!(
                    "give one value for both, or a pair [first, second]: {}",
                    spec.accepted()
                ),
            })
            .fail(self.issues)
    }

    /// The elements of a list, each read by a function.
    fn elements<T>(
        &self,
        name: &str,
        length: Option<usize>,
        read: impl Fn(Given, &'t Node) -> Option<T>,
    ) -> Option<Vec<T>> {
        let items = self.list(name, length)?;
        let spec = self.spec(&self.path_of(&format!("{name}.*")));
        all_or_none(items.iter().enumerate().map(|(i, node)| {
            let given = Given {
                issues: self.issues,
                node,
                path: &self.path_of(&format!("{name}.{i}")),
                spec,
            };
            read(given, node)
        }))
    }

    /// A list of texts, with this many elements if a length is given.
    pub fn texts(&self, name: &str, length: Option<usize>) -> Option<Vec<&'t str>> {
        self.elements(name, length, |given, node| match &node.value {
            Value::Text(text) => Some(text.as_str()),
            _ => given.wrong_type(),
        })
    }

    /// A list with the schema's words as elements.
    pub fn choices(&self, name: &str) -> Option<Vec<&'static str>> {
        self.elements(name, None, |given, _| given.choice())
    }

    /// A list of quantities in SI.
    pub fn quantities(&self, name: &str, length: Option<usize>) -> Option<Vec<f64>> {
        self.elements(name, length, |given, _| given.quantity())
    }

    /// A list of lists of quantities in SI.
    pub fn rows(&self, name: &str) -> Option<Vec<Vec<f64>>> {
        let spec = self.spec(&self.path_of(&format!("{name}.*.*")));
        self.elements(name, None, |given, node| {
            let Value::Array(cells) = &node.value else {
                return given.wrong_type();
            };
            all_or_none(cells.iter().enumerate().map(|(j, node)| {
                let path = &format!("{}.{j}", given.path);
                let cell = Given {
                    node,
                    path,
                    spec,
                    ..given
                };
                cell.quantity()
            }))
        })
    }

    /// A list of whole numbers of fixed length.
    pub fn integers<const N: usize>(&self, name: &str) -> Option<[u64; N]> {
        self.list(name, Some(N))?;
        self.whole_numbers(name)?.try_into().ok()
    }

    /// A list of whole numbers.
    pub fn whole_numbers(&self, name: &str) -> Option<Vec<u64>> {
        self.elements(name, None, |given, _| given.integer())
    }

    /// Two quantities in SI, `[first, second]`.
    pub fn pair(&self, name: &str) -> Option<[f64; 2]> {
        self.quantities(name, Some(2))?.try_into().ok()
    }

    /// Three quantities in SI.
    pub fn triple(&self, name: &str) -> Option<[f64; 3]> {
        self.quantities(name, Some(3))?.try_into().ok()
    }

    /// Two quantities in SI, `[first, second]`, or one for both.
    pub fn one_or_pair(&self, name: &str) -> Option<[f64; 2]> {
        // A key that may have one value per gear in `[gear]` has a single value in the table of one gear. There a list
        // is a fault.
        let of_one = self.spec(&self.path_of(name)).is_of_one_gear(&self.path);
        match self.entry(name).map(|entry| &entry.node.value) {
            Some(Value::Array(_)) if !of_one => self.pair(name),
            _ => self.quantity(name).map(|value| [value; 2]),
        }
    }

    /// The tables of a list, empty if the key is absent.
    pub fn tables(&self, name: &str) -> Option<Vec<Section<'t>>> {
        if !self.has(name) {
            return Some(Vec::new());
        }
        self.elements(name, None, |given, node| {
            let section = self.of_node(node, given.path.to_owned());
            section.or_else(|| given.wrong_type())
        })
    }

    /// This table, with faults recorded in another list.
    pub fn recording_in<'s>(&self, issues: &'s Issues) -> Section<'s>
    where
        't: 's,
    {
        Section {
            issues,
            ..self.clone()
        }
    }

    /// This table without its entries, for keys that have no effect.
    pub fn bare(&self) -> Section<'t> {
        Section {
            entries: &[],
            ..self.clone()
        }
    }

    /// This table if its keys have an effect, otherwise the table without its entries.
    pub fn if_effective(&self, effective: bool) -> Section<'t> {
        if effective { self.clone() } else { self.bare() }
    }

    /// Warns of keys without effect because of another choice, with the reason. The caller must not read
    /// them: they may have any value.
    pub fn without_effect(&self, names: &[&str], why: &str, remedy: &str) {
        for entry in names.iter().filter_map(|name| self.entry(name)) {
            let path = self.path_of(&entry.key);
            let message = format!("`{path}` has no effect {why}");
            Diagnostic::new(DiagnosticKind::NoEffect, entry.key_span, &path, message)
                .label("not used")
                .remedy(remedy)
                .report(self.issues);
        }
    }

    /// Records keys that give the same quantity as the key `other`. `what` ends the sentence "both ...".
    pub fn given_twice(&self, names: &[&str], other: &str, what: &str) {
        for entry in names.iter().filter_map(|name| self.entry(name)) {
            let path = self.path_of(&entry.key);
            let message = format!("`{path}` and `{}` both {what}", self.path_of(other));
            Diagnostic::new(DiagnosticKind::Inconsistent, entry.key_span, &path, message)
                .label("given twice")
                .remedy("keep one of the two")
                .report(self.issues);
        }
    }

    /// The tables of a list, read by a function; all are read before failing.
    pub fn each<T>(
        &self,
        name: &str,
        read: impl FnMut(&Section<'t>) -> Option<T>,
    ) -> Option<Vec<T>> {
        all_or_none(self.tables(name)?.iter().map(read))
    }

    /// A fault in the value of a key, or in its absence.
    pub fn fault(
        &self,
        kind: DiagnosticKind,
        name: &str,
        message: impl Into<String>,
    ) -> Diagnostic {
        Diagnostic::new(kind, self.span_of(name), &self.path_of(name), message)
    }

    /// The fault of a value that contradicts others.
    pub fn inconsistent(&self, name: &str, message: impl Into<String>) -> Diagnostic {
        self.fault(DiagnosticKind::Inconsistent, name, message)
    }

    /// A fault of the whole table.
    pub fn whole_fault(&self, kind: DiagnosticKind, message: impl Into<String>) -> Diagnostic {
        Diagnostic::new(kind, self.span, &self.path, message)
    }

    /// An optional table: `Some(None)` if absent, `None` if faulty.
    pub fn optional<T>(
        &self,
        name: &str,
        read: impl FnOnce(&Section) -> Option<T>,
    ) -> Option<Option<T>> {
        match self.child(name)? {
            Some(table) => read(&table).map(Some),
            None => Some(None),
        }
    }

    /// A key that may be absent: `Some(None)` if it is, `None` if it is faulty.
    pub fn if_given<T>(
        &self,
        name: &str,
        read: impl FnOnce(&Self, &str) -> Option<T>,
    ) -> Option<Option<T>> {
        if self.has(name) { read(self, name).map(Some) } else { Some(None) }
    }

    /// Place of a key's value; the table's header if it is absent.
    pub fn span_of(&self, name: &str) -> Span {
        self.entry(name).map_or(self.span, |entry| entry.node.span)
    }
}
