//! Models from TOML text.

use super::data_file::Loader;
use super::draft::{
    ContactDraft, Draft, FrictionDraft, ImpulseDraft, LabelDraft, Name, Place, SectionDraft,
    TableDraft,
};
use super::syntax::syntax_error;
use super::table::{Item, TableReader};
use crate::model::error::{ModelError, ModelErrorKind, ModelErrors};
use crate::model::model::Label;
use crate::model::{Direction, Model};

use crate::expressions::{ParseErrorKind, nearest};
use std::borrow::Cow;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// What may stand at the top of a file besides tables.
const TOP: &[&str] = &["title", "source", "simultaneous"];
const TABLE_NAMES: &[&str] = &[
    "parameters",
    "definitions",
    "table",
    "flight",
    "contact",
    "section",
    "event",
    "initial",
    "labels",
    "drawing",
];
/// The tables, as they are written.
pub(in crate::model) const TABLES: &str = "[parameters], [definitions], [table.NAME], [flight], [[contact]], [section.NAME], [[event]], [initial], [labels] or [drawing]";
const CONTACT: &[&str] = &["name", "gap", "impulse", "restitution", "reset", "friction"];
const FRICTION: &[&str] = &["coefficient", "along", "rate"];
const EVENT: &[&str] = &["name", "surface", "direction", "reset"];
const SECTION: &[&str] = &["surface", "direction"];
const LABEL: &[&str] = &["text", "unit"];

impl Model {
    /// Reads a model file (its language: `models/` and the guide). `name` is what errors call the text, usually the
    /// path of the file.
    ///
    /// # Errors
    /// All that is wrong with the text, each with its place.
    pub fn from_toml(text: &str, name: &str) -> Result<Self, ModelErrors> {
        Self::from_toml_with(text, name, &mut |_| Err(NO_FILES.to_owned()))
    }

    /// Reads a model file whose tables may stand in files of their own. `load` gives the text of such a file, or says why
    /// it cannot: it is asked for what the model calls it, once for each table that names it.
    ///
    /// # Errors
    /// All that is wrong with the model, and the first thing that is wrong with each of the files, each with its place.
    pub fn from_toml_with(
        text: &str,
        name: &str,
        load: &mut Loader<'_>,
    ) -> Result<Self, ModelErrors> {
        let (document, syntax) = DeTable::parse_recoverable(text);
        let mut reader = TableReader::new(text, name);
        for error in &syntax {
            let (kind, span) = syntax_error(text, error);
            let place = reader.place(span);
            let known = |other: &ModelError| *other.kind == kind && other.place == place;
            if !reader.errors.iter().any(known) {
                reader.report(kind, &place);
            }
        }
        let draft = read(&mut reader, document.get_ref(), load);
        let mut errors = match draft.assemble(reader.errors) {
            Ok(model) => return Ok(model),
            Err(errors) => errors,
        };
        if errors
            .iter()
            .any(|error| matches!(*error.kind, ModelErrorKind::Syntax { .. }))
        {
            // What else seems wrong may follow from a line that could not be read, except for errors within expressions.
            errors.retain(|error| error.kind.is_local());
        }
        // Quotes alone do not make an expression of what is none.
        let no_expressions: Vec<Place> = (errors.iter())
            .filter(|error| error.kind.is_no_expression())
            .map(|error| error.place.clone())
            .collect();
        errors.retain(|error| {
            !matches!(*error.kind, ModelErrorKind::Unquoted { .. })
                || !no_expressions.iter().any(|part| error.place.holds(part))
        });
        errors.sort_by_key(|error| error.within(name));
        Err(ModelErrors::new(errors))
    }
}

/// Why a model that is given as text has no tables in files.
const NO_FILES: &str = "the model is read as a text, without the files beside it";

/// A line that gives a missing key.
pub(in crate::model) fn example(key: &str) -> &'static str {
    match key {
        "gap" => "gap = \"y\"",
        "impulse" => "impulse = { v = 1 }",
        "restitution" => "restitution = 0.8",
        "reset" => "reset = { v = \"-r*v\" }",
        "coefficient" => "coefficient = 0.3",
        "along" => "along = { s = 1 }",
        "rate" => "rate = \"s - belt\"",
        "at" => "at = [0, \"y\"]",
        "size" => "size = [1, 0.5]         # of a round one: radius = 0.5",
        "from" => "from = [-1, 0]",
        "to" => "to = [1, 0]",
        "x" => "x = [0, 1, 2]",
        "y" => "y = [0, 0.5, 0]         # or both from a file: file = \"points.csv\"",
        _ => "surface = \"y - 1\"",
    }
}

impl<'i> TableReader<'i> {
    /// What stands at the top under this key; a wrong name is reported, and taken for the nearest right one that is
    /// not there itself.
    fn meant_at_top(
        &mut self,
        key: &Name,
        value: &Spanned<DeValue<'i>>,
        items: &[Item<'_, 'i>],
    ) -> &'static str {
        let known = TOP
            .iter()
            .chain(TABLE_NAMES)
            .find(|&&known| known == key.text);
        if let Some(known) = known {
            return known;
        }
        let is_table = matches!(value.get_ref(), DeValue::Table(_) | DeValue::Array(_));
        if !is_table {
            return self.meant(key, "the top of the file", TOP, items);
        }
        let name = key.text.clone();
        let nearest = nearest(&name, TABLE_NAMES.iter().copied());
        let meant = free(nearest.as_deref(), TABLE_NAMES, items);
        self.report(ModelErrorKind::UnknownTable { name, nearest }, &key.place);
        meant
    }

    /// What stands in a table under this key; a wrong name is reported, and taken for the nearest right one that is
    /// not there itself, so that nothing further is missed for it. Empty where there is none.
    pub(in crate::model) fn meant(
        &mut self,
        key: &Name,
        table: &str,
        known: &'static [&'static str],
        items: &[Item<'_, 'i>],
    ) -> &'static str {
        if let Some(known) = known.iter().find(|&&known| known == key.text) {
            return known;
        }
        let nearest = nearest(&key.text, known.iter().copied());
        let meant = free(nearest.as_deref(), known, items);
        let (key_text, table) = (key.text.clone(), table.to_owned());
        let kind = ModelErrorKind::UnknownKey {
            key: key_text,
            table,
            known,
            nearest,
        };
        self.report(kind, &key.place);
        meant
    }
}

fn free(nearest: Option<&str>, known: &[&'static str], items: &[Item]) -> &'static str {
    let meant = known.iter().copied().find(|&known| Some(known) == nearest);
    let taken = items.iter().any(|item| Some(&*item.key.text) == nearest);
    meant.filter(|_| !taken).unwrap_or_default()
}

fn read<'i>(reader: &mut TableReader<'i>, document: &DeTable<'i>, load: &mut Loader<'_>) -> Draft {
    let mut draft = Draft::new(reader.whole());
    let items = reader.items(document);
    for Item { key, value } in &items {
        match reader.meant_at_top(key, value, &items) {
            "title" => draft.title = reader.string("title", value),
            "source" => draft.source = reader.string("source", value),
            "simultaneous" => {
                draft.simultaneous = reader.simultaneous(value).unwrap_or_default();
            }
            "parameters" => {
                draft.parameters = reader
                    .entries("[parameters]", "a table [parameters]", value)
                    .unwrap_or_default();
            }
            "definitions" => {
                draft.definitions = reader
                    .entries("[definitions]", "a table [definitions]", value)
                    .unwrap_or_default();
            }
            "initial" => {
                draft.initial = reader
                    .entries("[initial]", "a table [initial]", value)
                    .unwrap_or_default();
            }
            "flight" => {
                let place = key.place.clone();
                let entries = reader.entries("[flight]", "a table [flight]", value);
                draft.flight = Some((place, entries));
            }
            "contact" => draft.contacts = contacts(reader, value),
            "section" => draft.sections.extend(sections(reader, value)),
            "event" => {
                let events = events(reader, value);
                draft.sections.extend(events);
            }
            "labels" => draft.labels = labels(reader, value),
            "drawing" => draft.drawing = reader.drawing(value),
            "table" => draft.tables = tables(reader, value, load),
            _ => {}
        }
    }
    draft
}

const CONTACT_TABLE: &str = "a table [[contact]]";

fn contacts<'i>(reader: &mut TableReader<'i>, value: &Spanned<DeValue<'i>>) -> Vec<ContactDraft> {
    match value.get_ref() {
        DeValue::Array(array) => array
            .iter()
            .filter_map(|value| contact(reader, value))
            .collect(),
        // Named in the brackets, as sections are.
        DeValue::Table(table) if are_named(table) => {
            let items = reader.table("contact", CONTACT_TABLE, value);
            let contacts = items.into_iter().flatten().map(|Item { key, value }| {
                let (name, place) = (Some(key.text), reader.place(value.span()));
                reader.report(ModelErrorKind::SingleBrackets { name }, &place);
                contact(reader, value)
            });
            contacts.flatten().collect()
        }
        DeValue::Table(_) => {
            let place = reader.place(value.span());
            reader.report(ModelErrorKind::SingleBrackets { name: None }, &place);
            contact(reader, value).into_iter().collect()
        }
        _ => {
            reader.wrong_type("contact".to_owned(), CONTACT_TABLE, value);
            Vec::new()
        }
    }
}

/// Whether a table that should be a contact holds contacts by their names.
fn are_named(table: &DeTable<'_>) -> bool {
    let is_contact = |(key, value): (&Spanned<Cow<'_, str>>, &Spanned<DeValue<'_>>)| {
        matches!(value.get_ref(), DeValue::Table(_)) && !CONTACT.contains(&key.get_ref().as_ref())
    };
    !table.is_empty() && table.iter().all(is_contact)
}

fn contact<'i>(reader: &mut TableReader<'i>, value: &Spanned<DeValue<'i>>) -> Option<ContactDraft> {
    let items = reader.table("contact", CONTACT_TABLE, value)?;
    let mut contact = ContactDraft {
        name: None,
        place: reader.place(value.span()),
        gap: None,
        impulse: None,
        restitution: None,
        reset: None,
        friction: None,
    };
    for Item { key, value } in &items {
        match reader.meant(key, "[[contact]]", CONTACT, &items) {
            "name" => {
                let place = reader.place(value.span());
                let text = reader.string("name of a contact", value);
                contact.name = text.map(|text| Name { text, place });
            }
            "gap" => contact.gap = Some(reader.formula("gap".to_owned(), value)),
            "restitution" => {
                contact.restitution = Some(reader.formula("restitution".to_owned(), value));
            }
            "impulse" => {
                let place = reader.place(value.span());
                let components = reader.entries("impulse", "a table such as { v = 1 }", value);
                contact.impulse = Some(ImpulseDraft { place, components });
            }
            "reset" => contact.reset = Some(reset(reader, value)),
            "friction" => contact.friction = friction(reader, value),
            _ => {}
        }
    }
    Some(contact)
}

fn reset<'i>(reader: &mut TableReader<'i>, value: &Spanned<DeValue<'i>>) -> ImpulseDraft {
    let place = reader.place(value.span());
    let components = reader.entries("reset", "a table such as { v = \"-r*v\" }", value);
    ImpulseDraft { place, components }
}

fn friction<'i>(
    reader: &mut TableReader<'i>,
    value: &Spanned<DeValue<'i>>,
) -> Option<FrictionDraft> {
    const EXPECTED: &str = "a table such as { coefficient = 0.3, along = { s = 1 } }";
    let items = reader.table("friction", EXPECTED, value)?;
    let mut friction = FrictionDraft {
        place: reader.place(value.span()),
        coefficient: None,
        along: None,
        rate: None,
    };
    for Item { key, value } in &items {
        match reader.meant(key, "friction", FRICTION, &items) {
            "coefficient" => {
                friction.coefficient = Some(reader.formula("coefficient".to_owned(), value));
            }
            "rate" => friction.rate = Some(reader.formula("rate".to_owned(), value)),
            "along" => {
                let place = reader.place(value.span());
                let components = reader.entries("along", "a table such as { s = 1 }", value);
                friction.along = Some(ImpulseDraft { place, components });
            }
            _ => {}
        }
    }
    Some(friction)
}

fn events<'i>(reader: &mut TableReader<'i>, value: &Spanned<DeValue<'i>>) -> Vec<SectionDraft> {
    const EXPECTED: &str = "a table [[event]]";
    let tables: Vec<&Spanned<DeValue<'i>>> = match value.get_ref() {
        DeValue::Array(array) => array.iter().collect(),
        _ => vec![value],
    };
    let mut events = Vec::with_capacity(tables.len());
    for (index, value) in tables.iter().enumerate() {
        let Some(items) = reader.table("event", EXPECTED, value) else {
            continue;
        };
        let place = reader.place(value.span());
        let text = if tables.len() == 1 {
            "event".to_owned()
        } else {
            format!("event{}", index + 1)
        };
        let mut event = SectionDraft {
            name: Name { text, place },
            surface: None,
            direction: Direction::Either,
            reset: None,
            is_event: true,
        };
        for Item { key, value } in &items {
            match reader.meant(key, "[[event]]", EVENT, &items) {
                "name" => {
                    let place = reader.place(value.span());
                    if let Some(text) = reader.string("name of an event", value) {
                        event.name = Name { text, place };
                    }
                }
                "surface" => event.surface = Some(reader.formula("surface".to_owned(), value)),
                "direction" => {
                    event.direction = reader.direction(value).unwrap_or(Direction::Either);
                }
                "reset" => event.reset = Some(reset(reader, value)),
                _ => {}
            }
        }
        events.push(event);
    }
    events
}

fn sections<'i>(reader: &mut TableReader<'i>, value: &Spanned<DeValue<'i>>) -> Vec<SectionDraft> {
    const EXPECTED: &str = "a table [section.NAME]";
    let items = reader.table("section", EXPECTED, value).unwrap_or_default();
    let mut sections = Vec::with_capacity(items.len());
    for Item { key: name, value } in items {
        let Some(items) = reader.table(&format!("`{}` in section", name.text), EXPECTED, value)
        else {
            continue;
        };
        let mut section = SectionDraft {
            name,
            surface: None,
            direction: Direction::Either,
            reset: None,
            is_event: false,
        };
        let table = format!("[section.{}]", section.name.text);
        for Item { key, value } in &items {
            match reader.meant(key, &table, SECTION, &items) {
                "surface" => section.surface = Some(reader.formula("surface".to_owned(), value)),
                "direction" => {
                    section.direction = reader.direction(value).unwrap_or(Direction::Either)
                }
                _ => {}
            }
        }
        sections.push(section);
    }
    sections
}

fn tables<'i>(
    reader: &mut TableReader<'i>,
    value: &Spanned<DeValue<'i>>,
    load: &mut Loader<'_>,
) -> Vec<TableDraft> {
    const EXPECTED: &str = "a table [table.NAME]";
    let items = reader.table("table", EXPECTED, value).unwrap_or_default();
    reader.tables = items.iter().map(|item| item.key.text.clone()).collect();
    let table = |Item { key: name, value }| {
        let what = format!("`{}` in table", name.text);
        let items = reader.table(&what, EXPECTED, value)?;
        let knots = reader.knots(&name, &items, load);
        Some(TableDraft { name, knots })
    };
    items.into_iter().filter_map(table).collect()
}

fn labels<'i>(reader: &mut TableReader<'i>, value: &Spanned<DeValue<'i>>) -> Vec<LabelDraft> {
    let items = reader
        .table("labels", "a table [labels]", value)
        .unwrap_or_default();
    let mut labels = Vec::with_capacity(items.len());
    for Item { key: name, value } in items {
        let mut label = Label::default();
        if let Some(text) = value.get_ref().as_str() {
            label.text = Some(text.to_owned());
        } else {
            const EXPECTED: &str = "a text in quotes or a table with text and unit";
            let what = format!("label of `{}`", name.text);
            let items = reader.table(&what, EXPECTED, value).unwrap_or_default();
            for Item { key, value } in &items {
                match reader.meant(key, &what, LABEL, &items) {
                    "text" => label.text = reader.string("text of a label", value),
                    "unit" => label.unit = reader.string("unit of a label", value),
                    _ => {}
                }
            }
        }
        labels.push(LabelDraft { name, label });
    }
    labels
}

impl ModelErrorKind {
    /// Whether the error stands by itself, whatever the rest of the file says.
    fn is_local(&self) -> bool {
        match self {
            Self::Syntax { .. }
            | Self::Unquoted { .. }
            | Self::NotANumber { .. }
            | Self::OutOfRange { .. }
            | Self::MissingValue => true,
            Self::DuplicateKey { .. } => true,
            Self::DataFile { .. } | Self::Curve { .. } | Self::TableNotConstant { .. } => true,
            Self::Expression { .. } => self.is_no_expression(),
            _ => false,
        }
    }

    /// Whether it is a text that would be no expression with any names.
    fn is_no_expression(&self) -> bool {
        match self {
            Self::Expression { error, .. } => !matches!(error.kind, ParseErrorKind::UnknownName(_)),
            _ => false,
        }
    }
}
