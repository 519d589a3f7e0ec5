//! How the orbits of a diagram are looked at and where they start.

use super::SweepOption;
use crate::diagram;
use chatter::analysis::diagram::Observed;
use chatter::analysis::simulate::EventKind;
use chatter::expressions::{is_name, nearest};

/// `EXPR`, or `NAME=EXPR`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ObserveOption(pub Observed);

impl std::str::FromStr for ObserveOption {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text.trim().is_empty() {
            return Err("expected an expression, such as y2".to_owned());
        }
        Ok(Self(match text.split_once('=') {
            Some((name, expression)) => {
                let name = name.trim();
                if !is_name(name) {
                    return Err(format!("`{name}` is no name: expected NAME=EXPR"));
                }
                Observed {
                    name: name.to_owned(),
                    expression: expression.trim().to_owned(),
                }
            }
            None => Observed::plain(text.trim()),
        }))
    }
}

/// `KIND[:NAME]`, or `NAME=EXPR`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum AtOption {
    /// Samples are taken at events.
    Event {
        /// The kind of event.
        kind: EventKind,
        /// The contact or section.
        name: Option<String>,
    },
    /// One value is looked at.
    Value(SweepOption),
}

impl std::str::FromStr for AtOption {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if let Some(value) = SweepOption::single(text) {
            return Ok(Self::Value(value));
        }
        let (kind, name) = match text.split_once(':') {
            Some((kind, name)) => (kind.trim(), Some(name.trim().to_owned())),
            None => (text.trim(), None),
        };
        let known = EventKind::ALL.into_iter();
        match known.clone().find(|known| known.name() == kind) {
            Some(kind) => Ok(Self::Event { kind, name }),
            None => Err(unknown("event", kind, known.map(|kind| kind.name()))),
        }
    }
}

/// Where orbits start.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StartOption {
    /// At the initial state.
    Fresh,
    /// Where the orbit at the next lower value ended.
    CarryUp,
    /// Where the orbit at the next higher value ended.
    CarryDown,
    /// One orbit of each kind.
    CarryBoth,
    /// At so many random points.
    Random(u64),
}

impl std::str::FromStr for StartOption {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        const KNOWN: [&str; 5] = ["fresh", "carry", "carry:down", "carry:both", "random:COUNT"];
        let other = |text: &str| Err(unknown("start", text, KNOWN.into_iter()));
        match text.trim().split_once(':') {
            None => match text.trim() {
                "fresh" => Ok(Self::Fresh),
                "carry" | "carry-up" => Ok(Self::CarryUp),
                "carry-down" => Ok(Self::CarryDown),
                "carry-both" => Ok(Self::CarryBoth),
                text => other(text),
            },
            Some(("carry", way)) => match way.trim() {
                "up" => Ok(Self::CarryUp),
                "down" => Ok(Self::CarryDown),
                "both" => Ok(Self::CarryBoth),
                _ => other(text.trim()),
            },
            Some(("random", count)) => match count.trim().parse() {
                Ok(count) if count > 0 => Ok(Self::Random(count)),
                _ => Err(format!(
                    "`{count}` is no number of random starts: expected a whole number from 1"
                )),
            },
            Some((text, _)) => other(text),
        }
    }
}

/// `auto`, or a slope.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShearOption(pub diagram::Shear);

impl std::str::FromStr for ShearOption {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text.trim() == "auto" {
            return Ok(Self(diagram::Shear::Fitted));
        }
        match text.trim().parse::<f64>() {
            Ok(slope) if slope.is_finite() => Ok(Self(diagram::Shear::Slope(slope))),
            _ => Err("expected `auto` or a slope, such as 3.2".to_owned()),
        }
    }
}

fn unknown<'a>(what: &str, name: &str, known: impl Iterator<Item = &'a str> + Clone) -> String {
    let list: Vec<&str> = known.clone().collect();
    let hint = match nearest(name, known) {
        Some(name) => format!("; did you mean `{name}`?"),
        None => String::new(),
    };
    format!(
        "unknown {what} `{name}`: expected one of {}{hint}",
        list.join(", ")
    )
}
