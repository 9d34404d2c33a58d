//! A TOML document as a tree of values with their places. Values of grid axes are put into it, so that the same code
//! resolves points and text.

use super::diagnostic::{Diagnostic, DiagnosticKind, Issues, Span};
use super::syntax;
use crate::units::Dimension;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// A value and its place.
#[derive(Debug, Clone)]
pub(super) struct Node {
    pub span: Span,
    pub value: Value,
}

#[derive(Debug, Clone)]
pub(super) enum Value {
    Text(String),
    Integer(i64),
    Float(f64),
    /// A value of a grid axis in SI, with its dimension; a whole value also counts as an integer.
    Sample(f64, Dimension),
    Boolean(bool),
    /// A date or time; no key accepts one.
    Datetime,
    Array(Vec<Node>),
    Table(Vec<Entry>),
}

/// A key of a table with its value.
#[derive(Debug, Clone)]
pub(super) struct Entry {
    pub key: String,
    pub key_span: Span,
    pub node: Node,
}

impl Value {
    /// The type with its article, for messages.
    pub fn type_name(&self) -> &'static str {
        match self {
            Self::Text(_) => "a text",
            Self::Integer(_) => "an integer",
            Self::Float(_) | Self::Sample(..) => "a number",
            Self::Boolean(_) => "a boolean",
            Self::Datetime => "a date",
            Self::Array(_) => "an array",
            Self::Table(_) => "a table",
        }
    }
}

/// `1 entry`, `3 entries`.
pub fn entries(count: usize) -> String {
    match count {
        1 => "1 entry".to_owned(),
        count => format!("{count} entries"),
    }
}

impl Node {
    /// The entry of a table; `None` if it is absent, or if the node is not a table.
    pub fn entry(&self, key: &str) -> Option<&Entry> {
        match &self.value {
            Value::Table(entries) => entries.iter().find(|entry| entry.key == key),
            _ => None,
        }
    }

    /// The entries of a subtable; empty if there is no such table.
    pub fn entries(&self, key: &str) -> &[Entry] {
        match self.entry(key).map(|entry| &entry.node.value) {
            Some(Value::Table(entries)) => entries,
            _ => &[],
        }
    }

    /// The node at a dotted path of keys and array indices.
    pub fn at(&self, path: &str) -> Option<&Self> {
        path.split('.')
            .try_fold(self, |node, part| match &node.value {
                Value::Array(items) => items.get(part.parse::<usize>().ok()?),
                _ => Some(&node.entry(part)?.node),
            })
    }

    /// Number of values in it, including itself.
    pub fn size(&self) -> usize {
        1 + match &self.value {
            Value::Array(items) => items.iter().map(Self::size).sum(),
            Value::Table(entries) => entries.iter().map(|entry| entry.node.size()).sum(),
            _ => 0,
        }
    }

    /// Drops the entries of the subtable `table` for which `keep` is false.
    pub fn retain(&mut self, table: &str, keep: impl Fn(&str) -> bool) {
        let Value::Table(entries) = &mut self.value else {
            return;
        };
        for entry in entries.iter_mut().filter(|entry| entry.key == table) {
            if let Value::Table(inner) = &mut entry.node.value {
                inner.retain(|entry| keep(&entry.key));
            }
        }
    }

    /// Removes the key at a path from its table, or an element from its list; returns whether it existed.
    pub fn take_out(&mut self, path: &[&str]) -> bool {
        let Some((first, rest)) = path.split_first() else {
            return false;
        };
        match &mut self.value {
            Value::Table(entries) => {
                let Some(index) = entries.iter().position(|entry| entry.key == *first) else {
                    return false;
                };
                if rest.is_empty() {
                    entries.remove(index);
                    return true;
                }
                entries[index].node.take_out(rest)
            }
            Value::Array(items) => {
                let index = first.parse().ok().filter(|index| *index < items.len());
                index.is_some_and(|index: usize| {
                    if rest.is_empty() {
                        items.remove(index);
                        true
                    } else {
                        items[index].take_out(rest)
                    }
                })
            }
            _ => false,
        }
    }

    /// Puts `node` at a path of keys and array indices, creating tables on the way.
    ///
    /// # Errors
    /// [`MissingElement`] if the path names an element of a list that does not exist.
    pub fn put(&mut self, path: &[&str], node: Node) -> Result<(), MissingElement> {
        let is_index = |part: &str| part.parse::<usize>().is_ok();
        let mut place = self;
        for (depth, part) in path.iter().enumerate() {
            let missing_element = |why: String, parts: usize| MissingElement {
                why,
                holder: path[..parts].join("."),
                near: None,
            };
            let kind = place.value.type_name();
            place = match &mut place.value {
                Value::Array(items) => {
                    let length = items.len();
                    let item = part.parse::<usize>().ok().and_then(|i| items.get_mut(i));
                    item.ok_or_else(|| missing_element(format!("has {}", entries(length)), depth))?
                }
                Value::Table(entries) => {
                    let index = entries.iter().position(|entry| entry.key == *part);
                    if index.is_none() && depth > 0 && is_index(part) {
                        return Err(missing_element(format!("is {kind}"), depth));
                    }
                    // Do not create a table in place of a list.
                    let below = path.get(depth + 1);
                    if index.is_none() && below.is_some_and(|below| is_index(below)) {
                        return Err(missing_element("is not given".to_owned(), depth + 1));
                    }
                    let index = index.unwrap_or_else(|| {
                        entries.push(Entry {
                            key: (*part).to_owned(),
                            key_span: node.span,
                            node: Node {
                                span: node.span,
                                value: Value::Table(Vec::new()),
                            },
                        });
                        entries.len() - 1
                    });
                    &mut entries[index].node
                }
                _ => return Err(missing_element(format!("is {kind}"), depth)),
            };
        }
        *place = node;
        Ok(())
    }
}

/// Where a path leaves the tree: it names an element that does not exist.
#[derive(Debug)]
pub(super) struct MissingElement {
    /// The path up to the node without such an element.
    pub holder: String,
    /// Reason as a predicate of that node: `has 1 entry`, `is a text`, `is not given`.
    pub why: String,
    /// The nearest existing path, if known.
    pub near: Option<String>,
}

/// Parses a file already added to `issues`. Records syntax errors; the tree has the readable part.
pub(super) fn parse(source: usize, issues: &Issues) -> Node {
    let text = issues.text(source);
    let (table, errors) = match DeTable::parse(&text) {
        Ok(table) => (table, Vec::new()),
        // Read only a limited part: every further message about a fault takes hundreds of bytes.
        Err(error) => {
            let read = looked_at(&text, &error);
            let unread = (read.len() < text.len()).then_some(read.len());
            issues.unread.set(unread);
            DeTable::parse_recoverable(read)
        }
    };
    syntax::report(source, &text, &errors, issues);
    of_table(source, table, issues)
}

/// A document of a source as a tree.
pub(super) fn of_table(source: usize, table: Spanned<DeTable<'_>>, issues: &Issues) -> Node {
    let span = at(source, &table.span());
    let value = convert_table(source, table.into_inner(), issues);
    Node { span, value }
}

/// Bytes after the first syntax error that are searched for others.
const BEHIND: usize = 16_384;

/// The text up to the end of a line at least [`BEHIND`] bytes after its first syntax error.
fn looked_at<'t>(text: &'t str, first: &toml::de::Error) -> &'t str {
    let start = first.span().map_or(0, |span| span.end);
    let far = text.floor_char_boundary(start.saturating_add(BEHIND));
    let end = text[far..]
        .find('\n')
        .map_or(text.len(), |line| far + line + 1);
    // A very long line is cut.
    &text[..text.floor_char_boundary(end.min(far + BEHIND))]
}

fn at(source: usize, span: &std::ops::Range<usize>) -> Span {
    Span {
        source,
        start: span.start,
        end: span.end,
    }
}

fn convert_table(source: usize, table: DeTable<'_>, issues: &Issues) -> Value {
    let entries = table
        .into_iter()
        .map(|(key, value)| Entry {
            key_span: at(source, &key.span()),
            key: key.into_inner().into_owned(),
            node: convert(source, value, issues),
        })
        .collect();
    Value::Table(entries)
}

fn convert(source: usize, value: Spanned<DeValue<'_>>, issues: &Issues) -> Node {
    let span = at(source, &value.span());
    let value = match value.into_inner() {
        DeValue::String(text) => Value::Text(text.into_owned()),
        DeValue::Integer(integer) => match i64::from_str_radix(integer.as_str(), integer.radix()) {
            Ok(integer) => Value::Integer(integer),
            Err(_) => {
                let message = format!("`{integer}` does not fit in 64 bits");
                Diagnostic::new(DiagnosticKind::OutOfRange, span, "", message).report(issues);
                Value::Integer(0)
            }
        },
        // Text that is not a number has been reported as a syntax error.
        DeValue::Float(float) => Value::Float(float.as_str().parse().unwrap_or(f64::NAN)),
        DeValue::Boolean(boolean) => Value::Boolean(boolean),
        DeValue::Datetime(_) => Value::Datetime,
        DeValue::Array(items) => Value::Array(
            items
                .into_iter()
                .map(|item| convert(source, item, issues))
                .collect(),
        ),
        DeValue::Table(table) => convert_table(source, table, issues),
    };
    Node { span, value }
}
