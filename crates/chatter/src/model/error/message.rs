//! The words for what is wrong with a model: a title, a label at the underlined text, and help.

use super::ModelErrorKind;
use crate::expressions::{CURVE_KINDS, CurveError, OUTSIDES, ParseErrorKind};
use crate::model::names::{alternatives, listed};
use crate::model::source::data_file::DataFileError;
use core::fmt;

impl fmt::Display for ModelErrorKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Syntax { message } => write!(f, "not valid TOML: {message}"),
            Self::Unquoted { .. } => write!(f, "an expression must stand in quotes"),
            Self::Empty => write!(f, "the model is empty"),
            Self::NoFlight => write!(f, "the model has no [flight] table"),
            Self::NoStates => write!(f, "[flight] has no equations"),
            Self::NotANumber { text } => write!(f, "`{text}` is not a number"),
            Self::OutOfRange { text } => {
                write!(f, "{}", ParseErrorKind::NumberOutOfRange(text.clone()))
            }
            Self::MissingValue => write!(f, "a value is missing"),
            Self::DuplicateKey { key } => write!(f, "`{key}` is given twice"),
            Self::UnknownTable { name, .. } => write!(f, "unknown table [{name}]"),
            Self::SingleBrackets { .. } => write!(f, "a contact stands in double brackets"),
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
                write!(f, "`{name}` is not a state, and only states jump")
            }
            Self::ImpulseOnTime => write!(f, "time does not jump"),
            Self::ResetBesideImpulse { key } => {
                write!(f, "both `reset` and `{key}` say what an impact does")
            }
            Self::SlidingRateUnknown => {
                write!(f, "which rate of sliding the friction opposes is not said")
            }
            Self::FrictionCoefficient { value } => write!(f, "coefficient of friction {value}"),
            Self::FrictionBesideReset => write!(f, "friction in a contact with `reset`"),
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
            Self::Restitution { value } => write!(f, "restitution {value} is outside 0 <= r <= 1"),
            Self::NotFinite { what, value } => write!(f, "{what} is {value}"),
            Self::UnknownDirection { found, .. } => write!(f, "unknown direction {found:?}"),
            Self::UnknownLaw { found, .. } => {
                write!(f, "unknown law of simultaneous impacts {found:?}")
            }
            Self::UnknownKind { found, .. } => write!(f, "unknown kind of table {found:?}"),
            Self::UnknownOutside { found, .. } => {
                write!(f, "a table cannot be {found:?} outside")
            }
            Self::BothKeys { table, key, other } => {
                write!(f, "{table} has both `{other}` and `{key}`")
            }
            Self::KeyWithout { table, key, other } => {
                write!(f, "{table} has `{key}` and no `{other}`")
            }
            Self::WrongLength {
                what,
                found,
                expected,
            } => write!(f, "{what} must be {expected}, not {found}"),
            Self::WrongColumn { found } => write!(f, "{found} is no column"),
            Self::TableNotConstant { on } => write!(f, "a table cannot depend on `{on}`"),
            Self::DataFile { file, error } => match error {
                DataFileError::Unavailable { reason } => {
                    write!(f, "cannot read `{file}`: {reason}")
                }
                _ => write!(f, "{error} in `{file}`"),
            },
            Self::Curve { table, error } => write!(f, "table `{table}`: {error}"),
            Self::UnknownName { name, role, .. } => write!(f, "the model has no {role} `{name}`"),
        }
    }
}

impl ModelErrorKind {
    /// The words at the underlined text.
    pub fn label(&self) -> Option<String> {
        Some(match self {
            Self::Unquoted { .. } => "not a number, so TOML needs quotes here".to_owned(),
            Self::NotANumber { .. } => "expected a number such as 0.5, 12 or 1e-3".to_owned(),
            Self::OutOfRange { .. } => {
                "expected zero, or a number that can be told from it".to_owned()
            }
            Self::MissingValue => "expected a number, or an expression in quotes".to_owned(),
            Self::DuplicateKey { .. } => "the second time".to_owned(),
            Self::SingleBrackets { name: None } => "expected [[contact]]".to_owned(),
            Self::SingleBrackets { name: Some(name) } => {
                format!("expected [[contact]], and in it name = \"{name}\"")
            }
            Self::UnknownTable { .. } => format!("expected {}", crate::model::source::file::TABLES),
            Self::NothingInitial { .. } => "where do these states start?".to_owned(),
            Self::NoStates => "expected d/dt of at least one state".to_owned(),
            Self::UnknownKey { known, .. } => format!("expected {}", alternatives(known)),
            Self::MissingKeys { .. } => "incomplete".to_owned(),
            Self::DuplicateName { role, .. } => format!("here as a {role}"),
            Self::ReservedName { meaning, .. } => format!("means {meaning} in expressions"),
            Self::InvalidName { .. } => "expected a letter, then letters, digits or _".to_owned(),
            Self::ImpulseOnUnknownState { states, .. }
            | Self::InitialOfUnknownState { states, .. } => match &states[..] {
                [] => "there is no state".to_owned(),
                states => format!("expected {}", alternatives(states)),
            },
            Self::ImpulseOnTime => "an impact takes no time".to_owned(),
            Self::ResetBesideImpulse { .. } => {
                "expected either `reset`, or `impulse` and `restitution`".to_owned()
            }
            Self::SlidingRateUnknown => {
                "expected a `rate`, such as rate = \"vx - radius*w\"".to_owned()
            }
            Self::FrictionCoefficient { .. } => "expected zero or more".to_owned(),
            Self::FrictionBesideReset => {
                "a reset says all that an impact does; friction needs `impulse` and `restitution`"
                    .to_owned()
            }
            Self::NoImpulse => "expected a component that is not zero".to_owned(),
            Self::NoInitial { .. } => "where does it start?".to_owned(),
            Self::TimeEquation => "d/dt of time is 1".to_owned(),
            Self::ParameterNotConstant { .. } | Self::InitialNotConstant { .. } => {
                "changes in time".to_owned()
            }
            Self::Circle { .. } => "the value of this needs itself".to_owned(),
            Self::Restitution { .. } => "expected a number from 0 to 1".to_owned(),
            Self::NotFinite { .. } => "expected a finite value".to_owned(),
            Self::UnknownDirection { .. } => {
                format!(
                    "expected {}",
                    alternatives(crate::model::direction::DIRECTIONS)
                )
            }
            Self::UnknownLaw { .. } => {
                format!(
                    "expected {}",
                    alternatives(crate::model::simultaneous::LAWS)
                )
            }
            Self::UnknownKind { .. } => format!("expected {}", alternatives(CURVE_KINDS)),
            Self::UnknownOutside { .. } => format!("expected {}", alternatives(OUTSIDES)),
            Self::BothKeys { .. } => "expected one of them".to_owned(),
            Self::KeyWithout { .. } => "says nothing by itself".to_owned(),
            Self::WrongColumn { .. } => "expected a name or a number from 1".to_owned(),
            Self::TableNotConstant { .. } => {
                "expected a number, or an expression of numbers".to_owned()
            }
            Self::DataFile { error, .. } => error.label()?,
            Self::Curve { error, .. } => match error {
                CurveError::Lengths { .. } => "expected as many as in x".to_owned(),
                CurveError::NotIncreasing { .. } => "expected a larger number".to_owned(),
                CurveError::NotFinite { .. } | CurveError::SlopeNotFinite { .. } => {
                    "expected a finite number".to_owned()
                }
                CurveError::PeriodNotClosed { first, .. } => format!("expected {first} again"),
                CurveError::OutsideOfPeriodic => "leave this out".to_owned(),
                CurveError::SlopesOfKind { .. } => "only a `cubic` table takes them".to_owned(),
                CurveError::TooFew { .. }
                | CurveError::TooMany { .. }
                | CurveError::Overflow { .. } => {
                    return None;
                }
            },
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
            | Self::WrongLength { .. }
            | Self::LabelOfUnknownName { .. } => return None,
        })
    }

    /// What to do about it.
    pub fn help(&self) -> Option<String> {
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
            | Self::UnknownLaw { nearest, .. }
            | Self::UnknownKind { nearest, .. }
            | Self::UnknownOutside { nearest, .. }
            | Self::UnknownName { nearest, .. } => format!("did you mean `{}`?", nearest.as_ref()?),
            Self::UnknownTable { nearest, .. } => {
                let nearest = nearest.as_deref()?;
                let in_brackets = crate::model::source::file::TABLES.split([',', ' ']).find(|table| table.trim_matches(['[', ']']) == nearest);
                format!("did you mean {}?", in_brackets.map_or_else(|| format!("[{nearest}]"), str::to_owned))
            }
            Self::NotANumber { text } => format!("write {}", meant_number(text)?),
            Self::Expression { error, known } => match (error.help(), &error.kind) {
                (None, ParseErrorKind::UnknownName(_)) if known.is_empty() => return None,
                (None, ParseErrorKind::UnknownName(_)) => format!("known here: {}", listed(known)),
                (help, _) => help?,
            },
            Self::MissingKeys { keys, .. } => {
                let examples: Vec<&str> = keys.iter().map(|key| crate::model::source::file::example(key)).collect();
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
            Self::DataFile { error, .. } => error.help()?,
            Self::Curve { error, .. } => match error {
                CurveError::NotIncreasing { value, before, .. } if value == before => {
                    "a table has one value at each x: a jump is a table of kind `steps`, or the sum of two tables"
                        .to_owned()
                }
                CurveError::PeriodNotClosed { .. } => {
                    "the period is the range of x: the last point is the first again".to_owned()
                }
                _ => return None,
            },
            Self::Restitution { .. } => "an impact turns rate v into -r v".to_owned(),
            Self::DuplicateName { .. }
            | Self::DuplicateKey { .. }
            | Self::MissingValue
            | Self::SingleBrackets { .. }
            | Self::BothKeys { .. }
            | Self::KeyWithout { .. }
            | Self::WrongLength { .. }
            | Self::WrongColumn { .. }
            | Self::TableNotConstant { .. }
            | Self::Syntax { .. }
            | Self::WrongType { .. }
            | Self::ReservedName { .. }
            | Self::InvalidName { .. }
            | Self::ImpulseOnTime
            | Self::ResetBesideImpulse { .. }
            | Self::SlidingRateUnknown
            | Self::FrictionCoefficient { .. }
            | Self::FrictionBesideReset
            | Self::NoImpulse
            | Self::Circle { .. }
            | Self::OutOfRange { .. }
            | Self::NotFinite { .. } => return None,
        })
    }
}

/// The number that is meant by one of another language: with a comma, without the zero, with what ends a line.
fn meant_number(text: &str) -> Option<String> {
    let bare = text.trim_end_matches([';', ',', 'f']).trim_end();
    let plain = bare.replacen(',', ".", 1).replacen("+-", "-", 1);
    let value: f64 = plain.parse().ok().filter(|value: &f64| value.is_finite())?;
    let (sign, digits) = match plain.strip_prefix(['-', '+']) {
        Some(digits) => (&plain[..1], digits),
        None => ("", &plain[..]),
    };
    let digits = match digits.find(|c: char| c != '0') {
        _ if value == 0.0 => "0.0",
        // A number that begins with its point, or with zeros that are not needed.
        Some(first) => &digits[first..],
        None => return None,
    };
    let digits = match digits.starts_with('.') {
        true => format!("0{digits}"),
        false => digits.to_owned(),
    };
    Some(match digits.strip_suffix('.') {
        Some(whole) => format!("{sign}{whole}.0"),
        None => format!("{sign}{}", digits.replace(".e", ".0e")),
    })
}
