//! The knots of a table, from its keys or from a file that it names.

use super::data_file::{DataFileError, Where};
use super::data_file::{Loader, Wanted, read_columns};
use super::draft::{Column, Content, Formula, KnotsDraft, Name, Place, SourceText};
use super::table::{Item, TableReader};
use crate::expressions::{
    CURVE_KINDS, CurveKind, Graph, OUTSIDES, Outside, ParseErrorKind, nearest,
};
use crate::model::error::{ModelError, ModelErrorKind};
use crate::numerics::DoubleDouble;
use std::sync::Arc;
use toml::Spanned;
use toml::de::DeValue;

const KEYS: &[&str] = &["file", "columns", "x", "y", "kind", "outside", "slopes"];

/// What stands in a table, before its numbers are put together.
#[derive(Default)]
struct Keys {
    file: Option<(String, Place)>,
    columns: Option<([Wanted; 2], [Place; 2])>,
    x: Option<Column>,
    y: Option<Column>,
    kind: CurveKind,
    outside: Option<(Outside, Place)>,
    slopes: Option<Column>,
}

impl<'i> TableReader<'i> {
    /// What stands in the table `name`; `None` where its knots cannot be known, which is reported.
    pub fn knots(
        &mut self,
        name: &Name,
        items: &[Item<'_, 'i>],
        load: &mut Loader<'_>,
    ) -> Option<KnotsDraft> {
        let table = format!("[table.{}]", name.text);
        let before = self.errors.len();
        let mut keys = Keys::default();
        let mut given: Vec<(&'static str, Place)> = Vec::new();
        for Item { key, value } in items {
            let meant = self.meant(key, &table, KEYS, items);
            given.push((meant, key.place.clone()));
            match meant {
                "file" => {
                    let place = self.place(value.span());
                    keys.file = self.string("file", value).map(|file| (file, place));
                }
                "columns" => keys.columns = self.columns(value),
                "x" => keys.x = self.column("x", value),
                "y" => keys.y = self.column("y", value),
                "kind" => keys.kind = self.kind(value).unwrap_or_default(),
                "outside" => keys.outside = self.outside(value),
                "slopes" => keys.slopes = self.slopes(value),
                _ => {}
            }
        }
        self.check_keys(table, name, &given);
        if self.errors.len() > before {
            return None;
        }
        let [x, y] = match (keys.file, keys.x, keys.y) {
            (Some(file), ..) => self.load(name, file, keys.columns, load)?,
            (None, Some(x), Some(y)) => [x, y],
            _ => return None,
        };
        Some(KnotsDraft {
            kind: keys.kind,
            outside: keys.outside,
            x,
            y,
            slopes: keys.slopes,
        })
    }

    /// Numbers stand in the table or in a file.
    fn check_keys(&mut self, table: String, name: &Name, given: &[(&'static str, Place)]) {
        let place = |key: &str| {
            given
                .iter()
                .find(|(given, _)| *given == key)
                .map(|(_, place)| place)
        };
        if place("file").is_some() {
            for key in ["x", "y"] {
                if let Some(place) = place(key) {
                    let (table, other) = (table.clone(), "file");
                    self.report(ModelErrorKind::BothKeys { table, key, other }, place);
                }
            }
            return;
        }
        let missing = ["x", "y"].into_iter().filter(|key| place(key).is_none());
        let keys: Vec<&'static str> = missing.collect();
        if let Some(place) = place("columns") {
            let (key, other) = ("columns", "file");
            let table = table.clone();
            self.report(ModelErrorKind::KeyWithout { table, key, other }, place);
        } else if !keys.is_empty() {
            self.report(ModelErrorKind::MissingKeys { table, keys }, &name.place);
        }
    }

    fn kind(&mut self, value: &Spanned<DeValue<'i>>) -> Option<CurveKind> {
        let found = self.string("kind", value)?;
        let kind = CurveKind::from_name(&found);
        if kind.is_none() {
            let nearest = nearest(&found, CURVE_KINDS.iter().copied());
            let place = self.place(value.span());
            self.report(ModelErrorKind::UnknownKind { found, nearest }, &place);
        }
        kind
    }

    fn outside(&mut self, value: &Spanned<DeValue<'i>>) -> Option<(Outside, Place)> {
        let found = self.string("outside", value)?;
        let place = self.place(value.span());
        let outside = Outside::from_name(&found);
        if outside.is_none() {
            let nearest = nearest(&found, OUTSIDES.iter().copied());
            self.report(ModelErrorKind::UnknownOutside { found, nearest }, &place);
        }
        Some((outside?, place))
    }

    fn slopes(&mut self, value: &Spanned<DeValue<'i>>) -> Option<Column> {
        let slopes = self.column("slopes", value)?;
        self.is_pair("slopes", slopes.numbers.len(), &slopes.place)
            .then_some(slopes)
    }

    fn is_pair(&mut self, what: &str, found: usize, place: &Place) -> bool {
        if found != 2 {
            let what = what.to_owned();
            let expected = "two, for the first and the last";
            let expected = if what == "columns" {
                "two, for x and y"
            } else {
                expected
            };
            let kind = ModelErrorKind::WrongLength {
                what,
                found,
                expected,
            };
            self.report(kind, place);
        }
        found == 2
    }

    fn columns(&mut self, value: &Spanned<DeValue<'i>>) -> Option<([Wanted; 2], [Place; 2])> {
        let Some(array) = value.get_ref().as_array() else {
            self.wrong_type(
                "columns".to_owned(),
                "an array of two names or numbers",
                value,
            );
            return None;
        };
        let place = self.place(value.span());
        if !self.is_pair("columns", array.len(), &place) {
            return None;
        }
        let mut wanted = Vec::with_capacity(2);
        let mut places = Vec::with_capacity(2);
        for value in array {
            let place = self.place(value.span());
            let found = match value.get_ref() {
                DeValue::String(name) => Some(Wanted::Name(name.to_string())),
                DeValue::Integer(number) => {
                    let number = usize::from_str_radix(number.as_str(), number.radix()).ok();
                    number.filter(|&number| number > 0).map(Wanted::Number)
                }
                _ => None,
            };
            if found.is_none() {
                let found = self.written(&place).to_owned();
                self.report(ModelErrorKind::WrongColumn { found }, &place);
            }
            wanted.push(found?);
            places.push(place);
        }
        Some((wanted.try_into().ok()?, places.try_into().ok()?))
    }

    /// An array of numbers, or of expressions that are numbers.
    fn column(&mut self, what: &str, value: &Spanned<DeValue<'i>>) -> Option<Column> {
        let Some(array) = value.get_ref().as_array() else {
            self.wrong_type(what.to_owned(), "an array of numbers", value);
            return None;
        };
        let place = self.place(value.span());
        let mut column = Column {
            source: Arc::clone(&place.source),
            place,
            numbers: Vec::with_capacity(array.len()),
            spans: Vec::with_capacity(array.len()),
        };
        // A file that holds something else has it in every line: the first is enough.
        for value in array {
            let formula = self.formula(format!("each of {what}"), value);
            let number = match self.constant(&formula) {
                Ok(number) => number?,
                Err(error) => {
                    self.errors.push(error);
                    return None;
                }
            };
            column.numbers.push(number);
            column.spans.push(value.span());
        }
        Some(column)
    }

    /// The value of a number, or of an expression that depends on nothing; `None` where it is none, which has been
    /// reported.
    fn constant(&self, formula: &Formula) -> Result<Option<DoubleDouble>, ModelError> {
        let text = match &formula.content {
            Content::Number(number) => return Ok(Some(*number)),
            Content::Broken => return Ok(None),
            Content::Text(text) => text,
        };
        let mut graph = Graph::default();
        let error = match graph.parse(text, &|_| None, &[]) {
            Ok(expr) => return Ok(Some(graph.evaluate(expr, &[], &[]))),
            Err(error) => error,
        };
        let place = formula.place.inside(error.span.clone());
        let kind = match &error.kind {
            ParseErrorKind::UnknownName(on) if error.suggestion.is_none() => {
                ModelErrorKind::TableNotConstant { on: on.clone() }
            }
            ParseErrorKind::UnknownFunction(on) if self.tables.contains(on) => {
                ModelErrorKind::TableNotConstant { on: on.clone() }
            }
            _ => ModelErrorKind::Expression {
                error,
                known: Vec::new(),
            },
        };
        Err(ModelError::new(kind, &place))
    }

    /// Both columns of a file.
    fn load(
        &mut self,
        name: &Name,
        (file, place): (String, Place),
        columns: Option<([Wanted; 2], [Place; 2])>,
        load: &mut Loader<'_>,
    ) -> Option<[Column; 2]> {
        let refused = |error: DataFileError| ModelErrorKind::DataFile {
            file: file.clone(),
            error,
        };
        let text = match load(&file) {
            Ok(text) => text,
            Err(reason) => {
                self.report(refused(DataFileError::Unavailable { reason }), &place);
                return None;
            }
        };
        let source = Arc::new(SourceText {
            name: file.clone(),
            text,
        });
        let (wanted, places) = columns.unwrap_or_else(|| {
            let first_two = [Wanted::Number(1), Wanted::Number(2)];
            (first_two, [place.clone(), place.clone()])
        });
        let column = |numbers: super::data_file::Numbers| Column {
            place: place.clone(),
            numbers: numbers.numbers,
            source: Arc::clone(&source),
            spans: numbers.spans,
        };
        match read_columns(&source.text, &wanted) {
            Ok(columns) => Some(columns.map(column)),
            Err((error, at)) => {
                let kind = refused(error);
                let error = match at {
                    Where::File => ModelError::new(kind, &place),
                    Where::Wanted(order) => ModelError::new(kind, &places[order]),
                    Where::Text(span) => {
                        let source = Arc::clone(&source);
                        let verbatim = None;
                        let there = Place {
                            source,
                            span,
                            verbatim,
                        };
                        ModelError::new(kind, &there).with_related(&place, read_for(&name.text))
                    }
                };
                self.errors.push(error);
                None
            }
        }
    }
}

/// The words where a model names the file in which something is wrong.
pub(in crate::model) fn read_for(table: &str) -> String {
    format!("read here for table `{table}`")
}
