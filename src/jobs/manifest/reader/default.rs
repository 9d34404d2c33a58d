//! Keys that may be absent: reads them like others if they are given, otherwise uses the schema's default.

use super::Section;
use crate::manifest::schema::Key;

impl Section<'_> {
    /// The schema's entry of a key of this table.
    fn key(&self, name: &str) -> &'static Key {
        self.spec(&self.path_of(name))
    }

    /// A whole number that fits its type, or its default.
    pub fn integer_or_default<T: TryFrom<u64>>(&self, name: &str) -> Option<T> {
        if self.has(name) {
            self.integer(name)
        } else {
            T::try_from(self.key(name).default_integer()).ok()
        }
    }

    /// `true` or `false`, or its default.
    pub fn boolean_or_default(&self, name: &str) -> Option<bool> {
        if self.has(name) {
            self.boolean(name)
        } else {
            Some(self.key(name).default_boolean())
        }
    }

    /// A quantity in SI, or its default.
    pub fn quantity_or_default(&self, name: &str) -> Option<f64> {
        if self.has(name) {
            self.quantity(name)
        } else {
            Some(self.key(name).default_quantity())
        }
    }

    /// One of the schema's words, or its default.
    pub fn choice_or_default(&self, name: &str) -> Option<&'static str> {
        if self.has(name) {
            self.choice(name)
        } else {
            Some(self.key(name).default_word())
        }
    }

    /// Two quantities in SI, or their default.
    pub fn pair_or_default(&self, name: &str) -> Option<[f64; 2]> {
        if self.has(name) {
            self.pair(name)
        } else {
            self.default_list(name).try_into().ok()
        }
    }

    /// Two quantities in SI, one for both, or the default of both.
    pub fn one_or_pair_or_default(&self, name: &str) -> Option<[f64; 2]> {
        if self.has(name) {
            self.one_or_pair(name)
        } else {
            Some([self.key(name).default_quantity(); 2])
        }
    }

    /// A list of whole numbers, or its default.
    pub fn whole_numbers_or_default(&self, name: &str) -> Option<Vec<u64>> {
        if self.has(name) {
            self.whole_numbers(name)
        } else {
            let numbers = self.default_list(name).into_iter();
            Some(numbers.map(|number| number as u64).collect())
        }
    }

    /// A list of the schema's words, or its default.
    pub fn choices_or_default(&self, name: &str) -> Option<Vec<&'static str>> {
        if self.has(name) {
            self.choices(name)
        } else {
            let elements = self.key(&format!("{name}.*"));
            Some(self.key(name).default_words(elements))
        }
    }

    fn default_list(&self, name: &str) -> Vec<f64> {
        let elements = self.key(&format!("{name}.*"));
        self.key(name).default_quantities(elements)
    }
}
