//! TOML values as drafts see them, with their places.

use super::draft::{Content, Entry, Formula, Name, Place, SourceText};
use crate::expressions::nearest;
use crate::model::direction::{DIRECTIONS, Direction};
use crate::model::error::{ModelError, ModelErrorKind};
use crate::model::simultaneous::{LAWS, Simultaneous};
use crate::numerics::DoubleDouble;
use core::ops::Range;
use std::sync::Arc;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

const EXPRESSION: &str = "an expression in quotes or a number";

/// A value with its key.
pub(in crate::model) struct Item<'t, 'i> {
    pub key: Name,
    pub value: &'t Spanned<DeValue<'i>>,
}

/// Reads values, and keeps what is wrong with them.
pub(in crate::model) struct TableReader<'i> {
    text: &'i str,
    source: Arc<SourceText>,
    pub errors: Vec<ModelError>,
    /// Names of the tables of knots, which none of them may depend on.
    pub tables: Vec<String>,
}

impl<'i> TableReader<'i> {
    pub fn new(text: &'i str, name: &str) -> Self {
        let (name, owned) = (name.to_owned(), text.to_owned());
        let source = Arc::new(SourceText { name, text: owned });
        Self {
            text,
            source,
            errors: Vec::new(),
            tables: Vec::new(),
        }
    }

    pub fn place(&self, span: Range<usize>) -> Place {
        let source = Arc::clone(&self.source);
        Place {
            source,
            span,
            verbatim: None,
        }
    }

    /// The file as such.
    pub fn whole(&self) -> Place {
        Place::named(&self.source.name)
    }

    pub fn report(&mut self, kind: ModelErrorKind, place: &Place) {
        self.errors.push(ModelError::new(kind, place));
    }

    /// The entries of a table in the order of the file.
    pub fn items<'t>(&self, table: &'t DeTable<'i>) -> Vec<Item<'t, 'i>> {
        let mut items: Vec<Item> = (table.iter())
            .map(|(key, value)| {
                let place = self.place(key.span());
                let text = key.get_ref().to_string();
                Item {
                    key: Name { text, place },
                    value,
                }
            })
            .collect();
        items.sort_by_key(|item| item.key.place.span.start);
        items
    }

    pub fn wrong_type(
        &mut self,
        what: String,
        expected: &'static str,
        value: &Spanned<DeValue<'i>>,
    ) {
        let found = type_words(value.get_ref());
        let place = self.place(value.span());
        self.report(
            ModelErrorKind::WrongType {
                what,
                expected,
                found,
            },
            &place,
        );
    }

    pub fn string(&mut self, what: &str, value: &Spanned<DeValue<'i>>) -> Option<String> {
        let text = value.get_ref().as_str().map(str::to_owned);
        if text.is_none() {
            self.wrong_type(what.to_owned(), "a text in quotes", value);
        }
        text
    }

    pub fn table<'t>(
        &mut self,
        what: &str,
        expected: &'static str,
        value: &'t Spanned<DeValue<'i>>,
    ) -> Option<Vec<Item<'t, 'i>>> {
        if let Some(table) = value.get_ref().as_table() {
            return Some(self.items(table));
        }
        self.wrong_type(what.to_owned(), expected, value);
        // In brackets too many: it is read on, so that nothing further is missed for it.
        let mut all = value.get_ref().as_array()?.iter();
        match (all.next(), all.next()) {
            (Some(only), None) => only.get_ref().as_table().map(|table| self.items(table)),
            _ => None,
        }
    }

    /// A table of expressions.
    pub fn entries(
        &mut self,
        what: &str,
        expected: &'static str,
        value: &Spanned<DeValue<'i>>,
    ) -> Option<Vec<Entry>> {
        let items = self.table(what, expected, value)?;
        let entry = |item: Item<'_, 'i>| {
            let formula = self.formula(format!("`{}` of {what}", item.key.text), item.value);
            Entry {
                name: item.key,
                formula,
            }
        };
        Some(items.into_iter().map(entry).collect())
    }

    /// An expression or a number; anything else is reported.
    pub fn formula(&mut self, what: String, value: &Spanned<DeValue<'i>>) -> Formula {
        let mut place = self.place(value.span());
        let content = match value.get_ref() {
            // Nothing after `=`, which the reader of TOML has reported.
            DeValue::String(_) if place.span.is_empty() => Content::Broken,
            DeValue::String(text) => {
                place.verbatim = self.offset(text);
                Content::Text(text.to_string())
            }
            DeValue::Float(number) => self.number(number.as_str(), 10, &place),
            DeValue::Integer(number) => self.number(number.as_str(), number.radix(), &place),
            _ => {
                self.wrong_type(what, EXPRESSION, value);
                Content::Broken
            }
        };
        Formula { content, place }
    }

    fn number(&mut self, digits: &str, radix: u32, place: &Place) -> Content {
        let number: Option<DoubleDouble> = match radix {
            // Not a number, which the reader of TOML has reported.
            10 if digits.is_empty() => return Content::Broken,
            10 => digits.parse().ok(),
            _ => (u64::from_str_radix(digits, radix).ok())
                .and_then(|value| value.to_string().parse().ok()),
        };
        let Some(number) = number else {
            let text = self.written(place).to_owned();
            self.report(ModelErrorKind::NotANumber { text }, place);
            return Content::Broken;
        };
        if number.is_lost_of(digits) {
            let text = self.written(place).to_owned();
            self.report(ModelErrorKind::OutOfRange { text }, place);
            return Content::Broken;
        }
        Content::Number(number)
    }

    /// What stands there.
    pub fn written(&self, place: &Place) -> &'i str {
        self.text.get(place.span.clone()).unwrap_or_default()
    }

    /// One of the directions.
    pub fn direction(&mut self, value: &Spanned<DeValue<'i>>) -> Option<Direction> {
        let found = self.string("direction", value)?;
        match Direction::from_name(&found) {
            Some(direction) => Some(direction),
            None => {
                let nearest = nearest(&found, DIRECTIONS.iter().copied());
                let place = self.place(value.span());
                self.report(ModelErrorKind::UnknownDirection { found, nearest }, &place);
                None
            }
        }
    }

    /// A law of simultaneous impacts.
    pub fn simultaneous(&mut self, value: &Spanned<DeValue<'i>>) -> Option<Simultaneous> {
        let found = self.string("simultaneous", value)?;
        let law = Simultaneous::from_name(&found);
        if law.is_none() {
            let nearest = nearest(&found, LAWS.iter().copied());
            let place = self.place(value.span());
            self.report(ModelErrorKind::UnknownLaw { found, nearest }, &place);
        }
        law
    }

    /// Where a string's content starts, if the reader took it from the text as it stands.
    fn offset(&self, content: &str) -> Option<usize> {
        let start = (content.as_ptr() as usize).checked_sub(self.text.as_ptr() as usize)?;
        let same = self.text.get(start..start + content.len())? == content;
        same.then_some(start)
    }
}

fn type_words(value: &DeValue) -> &'static str {
    match value {
        DeValue::String(_) => "a text",
        DeValue::Integer(_) | DeValue::Float(_) => "a number",
        DeValue::Boolean(_) => "true or false",
        DeValue::Datetime(_) => "a date",
        DeValue::Array(_) => "an array",
        DeValue::Table(_) => "a table",
    }
}
