//! Typed reading of a table: every accessor checks type, unit and range by the schema, records faults and returns
//! `None`, so that one pass finds every fault.

mod default;
mod value;

pub(super) use value::{
    choice, in_range, integer, meant, quantity, quantity_unbounded, wrong_type, wrong_unit,
};

use super::diagnostic::{Diagnostic, DiagnosticKind, Issues, Span};
use super::schema::{self, Key, Kind, Schema};
use super::tree::{Entry, Node, Value, entries};

/// A table of a file, with its dotted path.
#[derive(Debug, Clone)]
pub(super) struct Section<'t> {
    /// Dotted path, empty for the top level of a file.
    pub path: String,
    /// Place for reports of missing keys: the table's header.
    pub span: Span,
    entries: &'t [Entry],
    schema: Schema,
}

/// A subtable that may be absent.
#[derive(Debug)]
pub(super) enum Child<'t> {
    Absent,
    /// Not a table; reported.
    Invalid,
    Present(Section<'t>),
}

impl<'t> Section<'t> {
    /// The top level of a file.
    pub fn root(node: &'t Node, schema: Schema) -> Self {
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

    /// The header of a table as shown to the user.
    fn title(&self) -> String {
        if self.path.is_empty() {
            "the file".to_owned()
        } else {
            format!("`{}`", self.path)
        }
    }

    /// Records that a key is missing.
    pub fn missing(&self, issues: &mut Issues, name: &str) {
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
        issues.push(diagnostic);
    }

    /// A subtable.
    pub fn child(&self, issues: &mut Issues, name: &str) -> Child<'t> {
        let Some(entry) = self.entry(name) else {
            return Child::Absent;
        };
        let path = self.path_of(name);
        match Self::of_node(&entry.node, path.clone(), self.schema) {
            Some(mut section) => {
                section.span = entry.key_span;
                Child::Present(section)
            }
            None => {
                wrong_type(issues, &entry.node, &path, self.spec(&path));
                Child::Invalid
            }
        }
    }

    /// A table without entries, for an optional one.
    pub fn empty_child(&self, name: &str) -> Section<'t> {
        Self {
            path: self.path_of(name),
            span: self.span,
            entries: &[],
            schema: self.schema,
        }
    }

    /// A required subtable.
    pub fn required_child(&self, issues: &mut Issues, name: &str) -> Option<Section<'t>> {
        match self.child(issues, name) {
            Child::Present(section) => Some(section),
            Child::Invalid => None,
            Child::Absent => {
                self.missing(issues, name);
                None
            }
        }
    }

    /// A table as a value.
    fn of_node(node: &'t Node, path: String, schema: Schema) -> Option<Self> {
        match &node.value {
            Value::Table(entries) => Some(Self {
                path,
                span: node.span,
                entries,
                schema,
            }),
            _ => None,
        }
    }

    pub fn required(&self, issues: &mut Issues, name: &str) -> Option<&'t Entry> {
        let entry = self.entry(name);
        if entry.is_none() {
            self.missing(issues, name);
        }
        entry
    }

    /// A required quantity in SI.
    pub fn quantity(&self, issues: &mut Issues, name: &str) -> Option<f64> {
        let entry = self.required(issues, name)?;
        let path = self.path_of(name);
        quantity(issues, &entry.node, &path, self.spec(&path))
    }

    /// A required whole number.
    pub fn integer(&self, issues: &mut Issues, name: &str) -> Option<u64> {
        let entry = self.required(issues, name)?;
        let path = self.path_of(name);
        integer(issues, &entry.node, &path, self.spec(&path))
    }

    /// A whole number, or `default`, which depends on other keys.
    pub fn integer_or(&self, issues: &mut Issues, name: &str, default: u64) -> Option<u64> {
        if self.has(name) { self.integer(issues, name) } else { Some(default) }
    }

    /// A required whole number that counts things in memory.
    pub fn count(&self, issues: &mut Issues, name: &str) -> Option<usize> {
        let count = self.integer(issues, name)?;
        usize::try_from(count).ok()
    }

    /// A whole number that counts things in memory, or `default`, which depends on other keys.
    pub fn count_or(&self, issues: &mut Issues, name: &str, default: usize) -> Option<usize> {
        let count = self.integer_or(issues, name, default as u64)?;
        usize::try_from(count).ok()
    }

    /// `true` or `false`.
    pub fn boolean(&self, issues: &mut Issues, name: &str) -> Option<bool> {
        let entry = self.required(issues, name)?;
        if let Value::Boolean(value) = entry.node.value {
            return Some(value);
        }
        let path = self.path_of(name);
        wrong_type(issues, &entry.node, &path, self.spec(&path));
        None
    }

    /// A required text.
    pub fn text(&self, issues: &mut Issues, name: &str) -> Option<&'t str> {
        let entry = self.required(issues, name)?;
        if let Value::Text(text) = &entry.node.value {
            return Some(text);
        }
        let path = self.path_of(name);
        wrong_type(issues, &entry.node, &path, self.spec(&path));
        None
    }

    /// A required list of texts, with this many elements if a length is given.
    pub fn texts(
        &self,
        issues: &mut Issues,
        name: &str,
        length: Option<usize>,
    ) -> Option<Vec<&'t str>> {
        let items = self.list(issues, name, length)?;
        let spec = self.spec(&self.path_of(&format!("{name}.*")));
        let texts: Vec<_> = (items.iter().enumerate())
            .map(|(i, item)| match &item.value {
                Value::Text(text) => Some(text.as_str()),
                _ => {
                    wrong_type(issues, item, &self.path_of(&format!("{name}.{i}")), spec);
                    None
                }
            })
            .collect();
        texts.into_iter().collect()
    }

    /// One of the schema's words for this key, which is required.
    pub fn choice(&self, issues: &mut Issues, name: &str) -> Option<&'static str> {
        let entry = self.required(issues, name)?;
        let path = self.path_of(name);
        choice(issues, &entry.node, &path, self.spec(&path))
    }

    /// A list with the schema's words as elements.
    pub fn choices(&self, issues: &mut Issues, name: &str) -> Option<Vec<&'static str>> {
        let items = self.list(issues, name, None)?;
        let spec = self.spec(&self.path_of(&format!("{name}.*")));
        // Read every element before failing, so that all faults are found.
        let words: Vec<_> = (items.iter().enumerate())
            .map(|(i, item)| choice(issues, item, &self.path_of(&format!("{name}.{i}")), spec))
            .collect();
        words.into_iter().collect()
    }

    /// The elements of a list; `None` if it is not a list or has another length than expected.
    pub fn list(
        &self,
        issues: &mut Issues,
        name: &str,
        length: Option<usize>,
    ) -> Option<&'t [Node]> {
        let entry = self.required(issues, name)?;
        let path = self.path_of(name);
        let spec = self.spec(&path);
        let Value::Array(items) = &entry.node.value else {
            wrong_type(issues, &entry.node, &path, spec);
            return None;
        };
        match length {
            Some(length) if length != items.len() => {
                issues.push(
                    Diagnostic::new(
                        DiagnosticKind::WrongType,
                        entry.node.span,
                        &path,
                        format!("`{path}` has {}, not {length}", entries(items.len())),
                    )
                    .label(format!("{length} entries are needed"))
                    .accepted(match spec.kind {
                        Kind::List(_) => spec.accepted(),
                        _ => format!(
                            "give one value for both, or a pair [first, second]: {}",
                            spec.accepted()
                        ),
                    }),
                );
                None
            }
            _ => Some(items),
        }
    }

    /// A list of quantities in SI.
    pub fn quantities(
        &self,
        issues: &mut Issues,
        name: &str,
        length: Option<usize>,
    ) -> Option<Vec<f64>> {
        let items = self.list(issues, name, length)?;
        let element = self.path_of(name) + ".*";
        let spec = self.spec(&element);
        // Read every element before failing, so that all faults are found.
        let values: Vec<_> = items
            .iter()
            .enumerate()
            .map(|(i, item)| quantity(issues, item, &self.path_of(&format!("{name}.{i}")), spec))
            .collect();
        values.into_iter().collect()
    }

    /// A list of lists of quantities in SI.
    pub fn rows(&self, issues: &mut Issues, name: &str) -> Option<Vec<Vec<f64>>> {
        let items = self.list(issues, name, None)?;
        let spec = self.spec(&self.path_of(&format!("{name}.*.*")));
        // Read every element before failing, so that all faults are found.
        let rows: Vec<Option<Vec<f64>>> = (items.iter().enumerate())
            .map(|(i, item)| {
                let path = self.path_of(&format!("{name}.{i}"));
                let Value::Array(cells) = &item.value else {
                    wrong_type(issues, item, &path, self.spec(&path));
                    return None;
                };
                let values: Vec<_> = (cells.iter().enumerate())
                    .map(|(j, cell)| quantity(issues, cell, &format!("{path}.{j}"), spec))
                    .collect();
                values.into_iter().collect()
            })
            .collect();
        rows.into_iter().collect()
    }

    /// A list of whole numbers of fixed length.
    pub fn integers<const N: usize>(&self, issues: &mut Issues, name: &str) -> Option<[u64; N]> {
        self.list(issues, name, Some(N))?;
        self.whole_numbers(issues, name)?.try_into().ok()
    }

    /// A list of whole numbers.
    pub fn whole_numbers(&self, issues: &mut Issues, name: &str) -> Option<Vec<u64>> {
        let items = self.list(issues, name, None)?;
        let element = self.path_of(name) + ".*";
        let spec = self.spec(&element);
        let values: Vec<_> = items
            .iter()
            .enumerate()
            .map(|(i, item)| integer(issues, item, &self.path_of(&format!("{name}.{i}")), spec))
            .collect();
        values.into_iter().collect()
    }

    /// Two quantities in SI, `[first, second]`.
    pub fn pair(&self, issues: &mut Issues, name: &str) -> Option<[f64; 2]> {
        self.quantities(issues, name, Some(2))?.try_into().ok()
    }

    /// Two quantities in SI, `[first, second]`, or one for both.
    pub fn one_or_pair(&self, issues: &mut Issues, name: &str) -> Option<[f64; 2]> {
        // A key of both gears has one value in the table of one gear.
        let of_one = self.spec(&self.path_of(name)).is_of_one_gear(&self.path);
        match self.entry(name).map(|entry| &entry.node.value) {
            Some(Value::Array(_)) if !of_one => self.pair(issues, name),
            _ => self.quantity(issues, name).map(|value| [value; 2]),
        }
    }

    /// The tables of a list, empty if the key is absent.
    pub fn tables(&self, issues: &mut Issues, name: &str) -> Option<Vec<Section<'t>>> {
        if !self.has(name) {
            return Some(Vec::new());
        }
        let items = self.list(issues, name, None)?;
        let sections: Vec<_> = items
            .iter()
            .enumerate()
            .map(|(i, item)| {
                let path = self.path_of(&format!("{name}.{i}"));
                let section = Self::of_node(item, path.clone(), self.schema);
                if section.is_none() {
                    wrong_type(issues, item, &path, self.spec(&path));
                }
                section
            })
            .collect();
        sections.into_iter().collect()
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

    /// Warns of keys without effect because of another choice, with the reason. The caller must not read them: they may
    /// hold anything.
    pub fn without_effect(&self, issues: &mut Issues, names: &[&str], why: &str, remedy: &str) {
        for entry in names.iter().filter_map(|name| self.entry(name)) {
            let path = self.path_of(&entry.key);
            issues.push(
                Diagnostic::new(
                    DiagnosticKind::NoEffect,
                    entry.key_span,
                    &path,
                    format!("`{path}` has no effect {why}"),
                )
                .label("not used")
                .remedy(remedy),
            );
        }
    }

    /// Records keys that repeat another key: which of the two is meant is unknown. `what` ends the sentence "both ...".
    pub fn given_twice(&self, issues: &mut Issues, names: &[&str], other: &str, what: &str) {
        for entry in names.iter().filter_map(|name| self.entry(name)) {
            let path = self.path_of(&entry.key);
            issues.push(
                Diagnostic::new(
                    DiagnosticKind::Inconsistent,
                    entry.key_span,
                    &path,
                    format!("`{path}` and `{}` both {what}", self.path_of(other)),
                )
                .label("given twice")
                .remedy("keep one of the two"),
            );
        }
    }

    /// Place of a key's value; the table's header if it is absent.
    pub fn span_of(&self, name: &str) -> Span {
        self.entry(name).map_or(self.span, |entry| entry.node.span)
    }
}
