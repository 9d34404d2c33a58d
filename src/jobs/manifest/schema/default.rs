//! A key's default as a value. The table of keys has it as text for a file.

use super::{DefaultValue, Key, Kind};
use crate::units;

impl Key {
    fn default_text(&self) -> &'static str {
        match self.default {
            DefaultValue::Value(text) => text,
            other => unreachable!("`{}` has no default: {other:?}", self.path),
        }
    }

    fn no_such_default(&self) -> ! {
        let text = self.default_text();
        unreachable!("`{}` cannot have the default {text}", self.path)
    }

    /// A default that is a whole number.
    pub fn default_integer(&self) -> u64 {
        let number = self.default_text().parse();
        number.unwrap_or_else(|_| self.no_such_default())
    }

    /// A default that is `true` or `false`.
    pub fn default_boolean(&self) -> bool {
        let word = self.default_text().parse();
        word.unwrap_or_else(|_| self.no_such_default())
    }

    /// A default that is one of the key's words.
    pub fn default_word(&self) -> &'static str {
        let word = quoted(self.default_text());
        match (self.kind, word) {
            (Kind::Choice(choices), Some(word)) if choices.contains(&word) => word,
            (Kind::Initial, Some(word)) => word,
            _ => self.no_such_default(),
        }
    }

    /// A default that is a list of words; `elements` has the accepted words.
    pub fn default_words(&self, elements: &Self) -> Vec<&'static str> {
        let known = |text: &'static str| match (elements.kind, quoted(text.trim())) {
            (Kind::Choice(choices), Some(word)) if choices.contains(&word) => word,
            _ => self.no_such_default(),
        };
        self.listed().map(known).collect()
    }

    /// The elements of a list, as text.
    fn listed(&self) -> impl Iterator<Item = &'static str> {
        let inner = self.default_text().strip_prefix('[');
        match inner.and_then(|rest| rest.strip_suffix(']')) {
            Some(inner) => inner.split(','),
            None => self.no_such_default(),
        }
    }

    /// A default that is a quantity, in SI.
    pub fn default_quantity(&self) -> f64 {
        self.quantity_in(self.default_text())
    }

    /// A default that is a list of quantities in SI; `elements` has their dimension.
    pub fn default_quantities(&self, elements: &Self) -> Vec<f64> {
        let numbers = self.listed().map(str::trim);
        numbers.map(|number| elements.quantity_in(number)).collect()
    }

    fn quantity_in(&self, text: &str) -> f64 {
        let value = match (self.kind, quoted(text)) {
            (Kind::Quantity(dimension), Some(text)) => units::parse(text, dimension).ok(),
            _ => text.parse().ok(),
        };
        value.unwrap_or_else(|| self.no_such_default())
    }
}

/// The text inside a pair of quotes.
fn quoted(text: &str) -> Option<&str> {
    text.strip_prefix('"')?.strip_suffix('"')
}
