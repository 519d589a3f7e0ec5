//! What can be wrong with a model.

use super::draft::Place;
use super::names::{alternatives, listed};
use crate::expressions::{ParseError, ParseErrorKind};
use core::fmt;
use core::ops::Range;

/// Everything wrong with a model, in the order of the file.
#[derive(Clone, Debug)]
pub struct ModelErrors(Vec<ModelError>);

impl ModelErrors {
    pub(super) fn new(mut errors: Vec<ModelError>) -> Self {
        errors.sort_by_key(|error| error.place.span.start);
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

    /// Name of the file, or of the expression that was given by itself.
    pub fn source_name(&self) -> &str {
        &self.place.source.name
    }

    /// Where, in bytes of the text.
    pub fn span(&self) -> Range<usize> {
        self.place.span.clone()
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
    SingleBrackets,
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
    /// A restitution outside [0, 1).
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

impl fmt::Display for ModelErrorKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Syntax { message } => write!(f, "not valid TOML: {message}"),
            Self::Unquoted { .. } => write!(f, "an expression must stand in quotes"),
            Self::Empty => write!(f, "the model is empty"),
            Self::NoFlight => write!(f, "the model has no [flight] table"),
            Self::NoStates => write!(f, "[flight] has no equations"),
            Self::NotANumber { text } => write!(f, "`{text}` is not a number"),
            Self::MissingValue => write!(f, "a value is missing"),
            Self::DuplicateKey { key } => write!(f, "`{key}` is given twice"),
            Self::UnknownTable { name, .. } => write!(f, "unknown table [{name}]"),
            Self::SingleBrackets => write!(f, "a contact stands in double brackets"),
            Self::NothingInitial { .. } => write!(f, "the model has no initial values"),
            Self::UnknownKey { key, table, .. } => write!(f, "unknown key `{key}` in {table}"),
            Self::WrongType {
                what,
                expected,
                found,
            } => {
                write!(f, "{what} must be {expected}, not {found}")
            }
            Self::MissingKeys { table, keys } => {
                write!(f, "{table} has no {}", alternatives(keys))
            }
            Self::DuplicateName { name, .. } => write!(f, "`{name}` is defined twice"),
            Self::ReservedName { name, role, .. } => {
                write!(f, "`{name}` cannot be the name of a {role}")
            }
            Self::InvalidName { name, role } => {
                write!(f, "{name:?} cannot be the name of a {role}")
            }
            Self::Expression { error, .. } => write!(f, "{}", error.kind),
            Self::ImpulseOnUnknownState { name, .. } => {
                write!(f, "impulse on `{name}`, which is not a state")
            }
            Self::ImpulseOnTime => write!(f, "impulse on time"),
            Self::NoImpulse => write!(f, "the impulse changes nothing"),
            Self::InitialOfUnknownState { name, .. } => {
                write!(f, "initial value of `{name}`, which is not a state")
            }
            Self::NoInitial { state } => write!(f, "state `{state}` has no initial value"),
            Self::LabelOfUnknownName { name, .. } => {
                write!(
                    f,
                    "label of `{name}`, which is neither a state nor a parameter"
                )
            }
            Self::TimeEquation => write!(f, "`t` is time and has no equation"),
            Self::ParameterNotConstant { on, role } => {
                write!(f, "a parameter cannot depend on {role} `{on}`")
            }
            Self::InitialNotConstant { on, role } => {
                write!(f, "an initial value cannot depend on {role} `{on}`")
            }
            Self::Circle { role, names } if names.len() == 2 => {
                write!(f, "{role} `{}` depends on itself", names[0])
            }
            Self::Circle { role, names } => {
                write!(
                    f,
                    "{role}s depend on each other in a circle: {}",
                    names.join(" -> ")
                )
            }
            Self::Restitution { value } => write!(f, "restitution {value} is outside 0 <= r < 1"),
            Self::NotFinite { what, value } => write!(f, "{what} is {value}"),
            Self::UnknownDirection { found, .. } => write!(f, "unknown direction {found:?}"),
            Self::UnknownName { name, role, .. } => write!(f, "the model has no {role} `{name}`"),
        }
    }
}

impl ModelErrorKind {
    /// The words at the underlined text.
    pub(super) fn label(&self) -> Option<String> {
        Some(match self {
            Self::Unquoted { .. } => "not a number, so TOML needs quotes here".to_owned(),
            Self::NotANumber { .. } => "expected a number such as 0.5, 12 or 1e-3".to_owned(),
            Self::MissingValue => "expected a number, or an expression in quotes".to_owned(),
            Self::DuplicateKey { .. } => "the second time".to_owned(),
            Self::SingleBrackets => "expected [[contact]]".to_owned(),
            Self::UnknownTable { .. } => format!("expected {}", super::file::TABLES),
            Self::NothingInitial { .. } => "where do these states start?".to_owned(),
            Self::NoStates => "expected d/dt of at least one state".to_owned(),
            Self::UnknownKey { known, .. } => format!("expected {}", alternatives(known)),
            Self::MissingKeys { .. } => "incomplete".to_owned(),
            Self::DuplicateName { role, .. } => format!("here as a {role}"),
            Self::ReservedName { meaning, .. } => format!("means {meaning} in expressions"),
            Self::InvalidName { .. } => "expected a letter, then letters, digits or _".to_owned(),
            Self::ImpulseOnUnknownState { states, .. }
            | Self::InitialOfUnknownState { states, .. } => {
                format!("expected {}", alternatives(states))
            }
            Self::ImpulseOnTime => "an impact takes no time".to_owned(),
            Self::NoImpulse => "expected a component that is not zero".to_owned(),
            Self::NoInitial { .. } => "where does it start?".to_owned(),
            Self::TimeEquation => "d/dt of time is 1".to_owned(),
            Self::ParameterNotConstant { .. } | Self::InitialNotConstant { .. } => {
                "changes in time".to_owned()
            }
            Self::Circle { .. } => "the value of this needs itself".to_owned(),
            Self::Restitution { .. } => "expected a number from 0 to below 1".to_owned(),
            Self::NotFinite { .. } => "expected a finite value".to_owned(),
            Self::UnknownDirection { .. } => {
                format!("expected {}", alternatives(super::direction::DIRECTIONS))
            }
            Self::UnknownName { known, .. } if known.is_empty() => return None,
            Self::UnknownName { known, .. } => format!("expected {}", alternatives(known)),
            Self::Expression { error, .. } => match error.kind {
                ParseErrorKind::UnknownName(_) => "stands for nothing".to_owned(),
                _ => return None,
            },
            Self::Syntax { .. }
            | Self::Empty
            | Self::NoFlight
            | Self::WrongType { .. }
            | Self::LabelOfUnknownName { .. } => return None,
        })
    }

    /// What to do about it.
    pub(super) fn help(&self) -> Option<String> {
        Some(match self {
            Self::Unquoted { text } => format!("write \"{text}\""),
            Self::Empty | Self::NoFlight | Self::NoStates => {
                "[flight] gives d/dt of each state:\n[flight]\ny = \"v\"\nv = -9.81".to_owned()
            }
            Self::UnknownKey { nearest, .. }
            | Self::ImpulseOnUnknownState { nearest, .. }
            | Self::InitialOfUnknownState { nearest, .. }
            | Self::LabelOfUnknownName { nearest, .. }
            | Self::UnknownDirection { nearest, .. }
            | Self::UnknownName { nearest, .. } => format!("did you mean `{}`?", nearest.as_ref()?),
            Self::UnknownTable { nearest, .. } => format!("did you mean [{}]?", nearest.as_ref()?),
            Self::Expression { error, known } => match (error.help(), &error.kind) {
                (None, ParseErrorKind::UnknownName(_)) if known.is_empty() => return None,
                (None, ParseErrorKind::UnknownName(_)) => format!("known here: {}", listed(known)),
                (help, _) => help?,
            },
            Self::MissingKeys { keys, .. } => {
                let examples: Vec<&str> = keys.iter().map(|key| super::file::example(key)).collect();
                format!("add, for example:\n{}", examples.join("\n"))
            }
            Self::NothingInitial { states } => {
                let lines: Vec<String> = states.iter().map(|state| format!("{state} = 0")).collect();
                format!("add, for example:\n[initial]\n{}", lines.join("\n"))
            }
            Self::NoInitial { state } => format!("add {state} = 0 (or another start) to [initial]"),
            Self::TimeEquation => "to start at another time than 0, set t in [initial]".to_owned(),
            Self::ParameterNotConstant { .. } => {
                "a quantity that depends on the state belongs in [definitions]; parameters may use parameters"
                    .to_owned()
            }
            Self::InitialNotConstant { .. } => "it may use parameters".to_owned(),
            Self::Restitution { value } if *value == 1.0 => {
                "at r = 1 nothing is lost and chatter never ends; use a value such as 0.999".to_owned()
            }
            Self::Restitution { .. } => "an impact turns rate v into -r v".to_owned(),
            Self::DuplicateName { .. }
            | Self::DuplicateKey { .. }
            | Self::MissingValue
            | Self::NotANumber { .. }
            | Self::SingleBrackets
            | Self::Syntax { .. }
            | Self::WrongType { .. }
            | Self::ReservedName { .. }
            | Self::InvalidName { .. }
            | Self::ImpulseOnTime
            | Self::NoImpulse
            | Self::Circle { .. }
            | Self::NotFinite { .. } => return None,
        })
    }
}
