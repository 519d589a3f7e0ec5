//! Which panels a figure has, from their names.

use super::Subject;
use super::side::Quantity;
use crate::refusal::Refusal;
use chatter::analysis::simulate::EventKind;

/// What a panel shows, by name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Axes {
    /// Something upwards over something across.
    Over {
        /// Across: the time, a quantity, or `impact`, the number of the impact.
        x: String,
        /// Upwards: a quantity, `rate_before` of impacts, or what `x` is the `next` time: `next:SECTION`, `next:impact`.
        y: String,
    },
    /// The mechanism at the last time shown.
    Drawing,
}

/// Across, of impacts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Along {
    /// Their numbers.
    Number,
    /// Their times.
    Time,
}

/// At which events a return map looks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum At {
    /// Where a section is crossed.
    Section(usize),
    /// At events of a kind at any contact.
    Kind(EventKind),
}

/// What a panel shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shows {
    /// A quantity over time.
    History(Quantity),
    /// One quantity against another.
    Portrait(Quantity, Quantity),
    /// Gap against rate, or the first two states.
    UsualPortrait,
    /// The rates of impacts.
    Impacts(Along),
    /// A quantity at such an event against what it is at the next one.
    Returns(Quantity, At),
    /// The mechanism.
    Mechanism,
}

/// The panels wanted; the history of each state and the portrait if none are.
///
/// # Errors
/// A name is none that is known.
pub fn panels(subject: &Subject, axes: &[Axes]) -> Result<Vec<Shows>, Refusal> {
    if axes.is_empty() {
        let histories = subject
            .states()
            .map(|index| Shows::History(Quantity::State(index)));
        return Ok(histories.chain([Shows::UsualPortrait]).collect());
    }
    let names = Names::new(subject);
    axes.iter().map(|axes| names.panel(axes)).collect()
}

/// What can be named.
struct Names<'a> {
    subject: &'a Subject<'a>,
    time: &'a str,
    quantities: Vec<(String, Quantity)>,
}

impl<'a> Names<'a> {
    fn new(subject: &'a Subject) -> Self {
        let model = subject.model;
        let states = subject
            .states()
            .map(|index| (subject.state_name(index).to_owned(), Quantity::State(index)));
        let contacts = model
            .contacts
            .iter()
            .enumerate()
            .flat_map(|(index, contact)| {
                [
                    (format!("gap at {}", contact.name), Quantity::Gap(index)),
                    (format!("rate at {}", contact.name), Quantity::Rate(index)),
                ]
            });
        Self {
            subject,
            time: model.time.map_or("t", |time| &model.states[time].name),
            quantities: states.chain(contacts).collect(),
        }
    }

    fn panel(&self, axes: &Axes) -> Result<Shows, Refusal> {
        let (x, y) = match axes {
            Axes::Drawing if self.subject.model.drawing.is_empty() => {
                let refusal = Refusal::input("the model has no drawing");
                return Err(refusal.help("add a [drawing] to it, as docs/drawing.md says"));
            }
            Axes::Drawing => return Ok(Shows::Mechanism),
            Axes::Over { x, y } => (x.as_str(), y.as_str()),
        };
        let across = [self.time, IMPACT];
        if let Some(place) = y.strip_prefix(NEXT) {
            return Ok(Shows::Returns(self.quantity(x, &[])?, self.place(place)?));
        }
        if y == RATE && self.known(y).is_none() {
            return match x {
                _ if x == self.time => Ok(Shows::Impacts(Along::Time)),
                IMPACT => Ok(Shows::Impacts(Along::Number)),
                _ => Err(unknown(x, &across)),
            };
        }
        let up = self.quantity(y, &[RATE])?;
        match x == self.time {
            true => Ok(Shows::History(up)),
            false => Ok(Shows::Portrait(self.quantity(x, &[self.time])?, up)),
        }
    }

    fn known(&self, name: &str) -> Option<Quantity> {
        let mut named = self.quantities.iter().filter(|(known, _)| known == name);
        named.next().map(|(_, quantity)| *quantity)
    }

    fn quantity(&self, name: &str, others: &[&str]) -> Result<Quantity, Refusal> {
        self.known(name).ok_or_else(|| {
            let quantities = self.quantities.iter().map(|(name, _)| name.as_str());
            let known: Vec<&str> = others.iter().copied().chain(quantities).collect();
            unknown(name, &known)
        })
    }

    fn place(&self, name: &str) -> Result<At, Refusal> {
        let sections = &self.subject.model.sections;
        if let Some(index) = sections.iter().position(|section| section.name == name) {
            return Ok(At::Section(index));
        }
        let kinds = [EventKind::Impact, EventKind::Release];
        let kind = kinds.into_iter().find(|kind| kind.name() == name);
        kind.map(At::Kind).ok_or_else(|| {
            let sections = sections.iter().map(|section| section.name.as_str());
            let kinds = kinds.iter().map(|kind| kind.name());
            unknown(name, &sections.chain(kinds).collect::<Vec<&str>>())
        })
    }
}

const IMPACT: &str = "impact";
const RATE: &str = "rate_before";
const NEXT: &str = "next:";

fn unknown(name: &str, known: &[&str]) -> Refusal {
    Refusal::input(format!(
        "`{name}` cannot be drawn here: there is `{}`",
        known.join("`, `")
    ))
    .did_you_mean(chatter::expressions::nearest(name, known.iter().copied()))
}
