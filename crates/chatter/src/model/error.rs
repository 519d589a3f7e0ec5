//! What can be wrong with a model.

pub(super) mod diagnostic;
mod message;
pub(super) mod visible;

use super::source::data_file::DataFileError;
use super::source::draft::{Place, SourceText};
use crate::expressions::{CurveError, ParseError};
use core::fmt;
use core::ops::Range;
use std::sync::Arc;

/// Everything wrong with a model, in the order of the file.
#[derive(Clone, Debug)]
pub struct ModelErrors(Vec<ModelError>);

impl ModelErrors {
    pub(super) fn new(errors: Vec<ModelError>) -> Self {
        Self(errors)
    }

    /// At least one error.
    pub fn errors(&self) -> &[ModelError] {
        &self.0
    }
}

impl core::error::Error for ModelErrors {}

/// One thing wrong with a model, and where. [`Display`](fmt::Display) gives the whole message with the text underlined.
#[derive(Clone, Debug)]
pub struct ModelError {
    pub(super) kind: Box<ModelErrorKind>,
    pub(super) place: Place,
    pub(super) related: Option<Box<(Place, String)>>,
}

impl ModelError {
    pub(super) fn new(kind: ModelErrorKind, place: &Place) -> Self {
        Self {
            kind: Box::new(kind),
            place: place.clone(),
            related: None,
        }
    }

    pub(super) fn with_related(mut self, place: &Place, label: String) -> Self {
        self.related = Some(Box::new((place.clone(), label)));
        self
    }

    /// What is wrong.
    pub fn kind(&self) -> &ModelErrorKind {
        &self.kind
    }

    /// What is wrong with a text given by itself, such as an option: `name` is what messages call it, `known` are the
    /// names it may use.
    pub fn of_expression(name: &str, text: &str, error: ParseError, known: &[&str]) -> Self {
        let place = Place::whole(name, text).inside(error.span.clone());
        let known = known.iter().map(|&name| name.to_owned()).collect();
        Self::new(ModelErrorKind::Expression { error, known }, &place)
    }

    /// The same, in a text that messages call `name`.
    #[must_use]
    pub fn with_source_name(mut self, name: &str) -> Self {
        let text = self.place.source.text.clone();
        let name = name.to_owned();
        self.place.source = Arc::new(SourceText { name, text });
        self
    }

    /// Name of the file, or of the expression that was given by itself.
    pub fn source_name(&self) -> &str {
        &self.place.source.name
    }

    /// Where, in bytes of the text.
    pub fn span(&self) -> Range<usize> {
        self.place.span.clone()
    }

    /// Where it stands, or shows, in the text of this name: what is wrong in another file is told where that is named.
    pub(super) fn within(&self, name: &str) -> usize {
        match &self.related {
            Some(related) if self.place.source.name != name => related.0.span.start,
            _ => self.place.span.start,
        }
    }

    /// Line and column (in characters) where it starts, both from 1.
    pub fn line_and_column(&self) -> (usize, usize) {
        let text = &self.place.source.text;
        let before = text.get(..self.place.span.start).unwrap_or(text);
        let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
        let line = before.matches('\n').count() + 1;
        (line, before[line_start..].chars().count() + 1)
    }
}

impl core::error::Error for ModelError {}

/// What a name stands for.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Role {
    /// A state.
    State,
    /// A parameter.
    Parameter,
    /// A definition.
    Definition,
    /// A table.
    Table,
    /// A contact.
    Contact,
    /// A section.
    Section,
    /// Time.
    Time,
}

impl fmt::Display for Role {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::State => "state",
            Self::Parameter => "parameter",
            Self::Definition => "definition",
            Self::Table => "table",
            Self::Contact => "contact",
            Self::Section => "section",
            Self::Time => "time",
        })
    }
}

/// What is wrong with a model.
#[derive(Clone, PartialEq, Debug)]
pub enum ModelErrorKind {
    /// Not TOML.
    Syntax {
        /// What the TOML reader found and expected.
        message: String,
    },
    /// An expression without quotes, which TOML cannot hold.
    Unquoted {
        /// The expression.
        text: String,
    },
    /// A value that starts as a number, but is none.
    NotANumber {
        /// The value.
        text: String,
    },
    /// A number that is too small to be told from zero.
    OutOfRange {
        /// As it is written.
        text: String,
    },
    /// Nothing after `=`.
    MissingValue,
    /// A key or table that is there already.
    DuplicateKey {
        /// The key.
        key: String,
    },
    /// Nothing there.
    Empty,
    /// No equations of motion: no `[flight]`.
    NoFlight,
    /// `[flight]` has no state in it.
    NoStates,
    /// A table that means nothing.
    UnknownTable {
        /// Its name.
        name: String,
        /// The one probably meant.
        nearest: Option<String>,
    },
    /// A key that means nothing.
    UnknownKey {
        /// The key.
        key: String,
        /// The table it is in.
        table: String,
        /// What may stand there.
        known: &'static [&'static str],
        /// The one probably meant.
        nearest: Option<String>,
    },
    /// A value of the wrong type.
    WrongType {
        /// What the value is for.
        what: String,
        /// The types that would do, in words.
        expected: &'static str,
        /// The type found, in words.
        found: &'static str,
    },
    /// A contact as `[contact]`.
    SingleBrackets {
        /// The contact's name, where it stands in the brackets.
        name: Option<String>,
    },
    /// Keys that must be there are not.
    MissingKeys {
        /// The table they are missing from.
        table: String,
        /// The keys.
        keys: Vec<&'static str>,
    },
    /// One name for two things.
    DuplicateName {
        /// The name.
        name: String,
        /// What it stands for here.
        role: Role,
        /// What it stood for already.
        first: Role,
    },
    /// A name that the language uses.
    ReservedName {
        /// The name.
        name: String,
        /// What it was to stand for.
        role: Role,
        /// What it means to the language.
        meaning: &'static str,
    },
    /// Not a name at all.
    InvalidName {
        /// The text.
        name: String,
        /// What it was to stand for.
        role: Role,
    },
    /// Not an expression, or one with an unknown name.
    Expression {
        /// What is wrong with it.
        error: ParseError,
        /// The names it may use.
        known: Vec<String>,
    },
    /// An impulse on something that is no state.
    ImpulseOnUnknownState {
        /// The name.
        name: String,
        /// The states there are.
        states: Vec<String>,
        /// The one probably meant.
        nearest: Option<String>,
    },
    /// An impulse on time.
    ImpulseOnTime,
    /// A contact with a reset, and with an impulse or a restitution beside it.
    ResetBesideImpulse {
        /// The key that says the same twice.
        key: &'static str,
    },
    /// Friction along a direction of several states, or of none, whose rate of sliding is not given.
    SlidingRateUnknown,
    /// A coefficient of friction below zero.
    FrictionCoefficient {
        /// The coefficient.
        value: f64,
    },
    /// Friction in a contact with a reset.
    FrictionBesideReset,
    /// An impulse of zero length.
    NoImpulse,
    /// The initial value of something that is no state.
    InitialOfUnknownState {
        /// The name.
        name: String,
        /// The states there are.
        states: Vec<String>,
        /// The one probably meant.
        nearest: Option<String>,
    },
    /// No initial values at all.
    NothingInitial {
        /// The states.
        states: Vec<String>,
    },
    /// A state without initial value.
    NoInitial {
        /// The state.
        state: String,
    },
    /// A label for something that is neither state nor parameter.
    LabelOfUnknownName {
        /// The name.
        name: String,
        /// The one probably meant.
        nearest: Option<String>,
    },
    /// An equation for time.
    TimeEquation,
    /// A parameter that depends on more than parameters.
    ParameterNotConstant {
        /// What it depends on.
        on: String,
        /// What that is.
        role: Role,
    },
    /// An initial value that depends on the state.
    InitialNotConstant {
        /// What it depends on.
        on: String,
        /// What that is.
        role: Role,
    },
    /// Parameters or definitions that depend on themselves.
    Circle {
        /// What they are.
        role: Role,
        /// The circle: each depends on the next, the last is the first.
        names: Vec<String>,
    },
    /// A restitution outside [0, 1].
    Restitution {
        /// Its value.
        value: f64,
    },
    /// A parameter or an initial value that is not finite.
    NotFinite {
        /// What has this value.
        what: String,
        /// The value.
        value: f64,
    },
    /// Not a direction of crossing.
    UnknownDirection {
        /// What was found.
        found: String,
        /// The one probably meant.
        nearest: Option<String>,
    },
    /// Not a kind of table.
    UnknownKind {
        /// What was found.
        found: String,
        /// The one probably meant.
        nearest: Option<String>,
    },
    /// Not what a table may be outside.
    UnknownOutside {
        /// What was found.
        found: String,
        /// The one probably meant.
        nearest: Option<String>,
    },
    /// Two keys of which there can be one.
    BothKeys {
        /// The table they are in.
        table: String,
        /// One of them.
        key: &'static str,
        /// The other.
        other: &'static str,
    },
    /// A key that says nothing without another.
    KeyWithout {
        /// The table it is in.
        table: String,
        /// The key.
        key: &'static str,
        /// The one that is missing.
        other: &'static str,
    },
    /// A list that is too long or too short.
    WrongLength {
        /// What the list is for.
        what: String,
        /// How many there are.
        found: usize,
        /// How many there must be, in words.
        expected: &'static str,
    },
    /// A column that is neither a name nor a number from 1.
    WrongColumn {
        /// What was found.
        found: String,
    },
    /// A number of a table that depends on something.
    TableNotConstant {
        /// What it depends on.
        on: String,
    },
    /// A file of numbers that cannot be used.
    DataFile {
        /// What the model calls it.
        file: String,
        /// What is wrong with it.
        error: DataFileError,
    },
    /// Points that no curve of the kind goes through.
    Curve {
        /// The table.
        table: String,
        /// What is wrong with them.
        error: CurveError,
    },
    /// Not a law of simultaneous impacts.
    UnknownLaw {
        /// What was found.
        found: String,
        /// The one probably meant.
        nearest: Option<String>,
    },
    /// No parameter or state of this name can be set.
    UnknownName {
        /// The name.
        name: String,
        /// What it was taken for.
        role: Role,
        /// What there is.
        known: Vec<String>,
        /// The one probably meant.
        nearest: Option<String>,
    },
}
