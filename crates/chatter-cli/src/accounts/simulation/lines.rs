//! The lines of the list: one an event, or one a sequence of impacts.

use super::ends::Ends;
use super::{MOST_LINES, Teller, counted};
use crate::numbers::significant;
use crate::simulation::{Noted, side_name};
use chatter::analysis::simulate::Event;
use chatter::flow::{Closed, Occurrence};
use chatter::numerics::Real;
use chatter_files::FileError;

/// Digits of an estimated error.
const ERROR_DIGITS: u32 = 2;

/// Rates that differ by less than this part are those of a periodic orbit, not of a chatter sequence.
const SAME_RATE: f64 = 1e-6;

/// One line of the list.
pub(super) struct Line<R> {
    pub time: R,
    pub what: String,
    pub place: String,
    pub detail: String,
}

/// What becomes a line.
#[derive(Clone)]
pub(super) enum Item<R> {
    /// The start, with the contacts that are closed there.
    Start(Closed),
    /// One event.
    Event(Noted<R>),
    /// Impacts of one contact with ever smaller rates, and sections crossed between them.
    Sequence {
        first: Event<R>,
        last: Event<R>,
        impacts: u64,
        crossings: u64,
    },
}

/// A sequence of impacts that may go on.
struct Open<R> {
    first: Noted<R>,
    last: Event<R>,
    impacts: u64,
    crossings: u64,
    /// Sections crossed since: part of the sequence if it goes on.
    since: Ends<Item<R>>,
}

impl<R: Real> Open<R> {
    fn begin(first: Noted<R>) -> Self {
        Self {
            last: first.event.clone(),
            first,
            impacts: 1,
            crossings: 0,
            since: Ends::new(MOST_LINES / 2),
        }
    }

    fn end(self, items: &mut Ends<Item<R>>) {
        items.push(match self.impacts {
            1 => Item::Event(self.first),
            impacts => Item::Sequence {
                first: self.first.event,
                last: self.last,
                impacts,
                crossings: self.crossings,
            },
        });
        items.append(self.since);
    }
}

impl<R: Real> Teller<'_, R> {
    /// One item an event.
    pub(super) fn every_event(
        &self,
    ) -> Result<impl Iterator<Item = Result<Item<R>, FileError>>, FileError> {
        let events = (self.record.events()).map(|noted| noted.map(Item::Event));
        Ok(core::iter::once(Ok(self.start()?)).chain(events))
    }

    /// Impacts of one contact with ever smaller rates are one line, whatever sections they cross on the way.
    pub(super) fn summary(&self) -> Result<Ends<Item<R>>, FileError> {
        let mut items = Ends::new(MOST_LINES / 2);
        items.push(self.start()?);
        let mut open: Option<Open<R>> = None;
        for noted in self.record.events() {
            let noted = noted?;
            if let Some(mut sequence) = open.take() {
                if is_section(&noted.event) {
                    sequence.since.push(Item::Event(noted));
                    open = Some(sequence);
                    continue;
                }
                if continues(&sequence.last, &noted.event) {
                    let crossed =
                        core::mem::replace(&mut sequence.since, Ends::new(MOST_LINES / 2));
                    sequence.crossings += crossed.len();
                    sequence.impacts += 1;
                    sequence.last = noted.event;
                    open = Some(sequence);
                    continue;
                }
                sequence.end(&mut items);
            }
            if is_impact(&noted.event) {
                open = Some(Open::begin(noted));
            } else {
                items.push(Item::Event(noted));
            }
        }
        if let Some(sequence) = open {
            sequence.end(&mut items);
        }
        Ok(items)
    }

    /// The contacts that are closed at the start.
    fn start(&self) -> Result<Item<R>, FileError> {
        let mut closed = Closed::NONE;
        for phase in self.record.contact_phases() {
            let phase = phase?;
            if phase.start != self.simulation.start_time {
                break;
            }
            closed = closed.with(phase.contact);
        }
        Ok(Item::Start(closed))
    }

    /// The line of an item.
    pub(super) fn line(&self, item: &Item<R>) -> Line<R> {
        match item {
            Item::Start(closed) => Line {
                time: self.simulation.start_time,
                what: "start".to_owned(),
                place: String::new(),
                detail: self.mode(*closed, &self.simulation.start_held),
            },
            Item::Event(noted) => self.event_line(noted),
            Item::Sequence {
                first,
                last,
                impacts,
                crossings,
            } => self.sequence_line((first, last), *impacts, *crossings),
        }
    }

    fn sequence_line(
        &self,
        (first, last): (&Event<R>, &Event<R>),
        impacts: u64,
        crossings: u64,
    ) -> Line<R> {
        let rate = |event| self.detail(rate_before(event).unwrap_or(R::ZERO));
        let crossed = match crossings {
            0 => String::new(),
            _ => format!(", {}", counted(crossings, "section crossing")),
        };
        Line {
            time: first.time,
            what: counted(impacts, "impact"),
            place: self.subject.place(&first.detail).to_owned(),
            detail: format!(
                "until {}, rates {} to {}{crossed}",
                self.time(last.time),
                rate(first),
                rate(last)
            ),
        }
    }

    fn event_line(&self, noted: &Noted<R>) -> Line<R> {
        let event = &noted.event;
        let detail = match event.detail {
            Occurrence::Impact {
                rate_before,
                rate_after,
                closes,
                ..
            } => {
                let (before, after) = (self.detail(rate_before), self.detail(rate_after));
                let closing = if closes { ", closes" } else { "" };
                format!("rate {before} -> {after}{closing}")
            }
            Occurrence::Accumulation { impacts, error, .. } => format!(
                "after {}, local error {}",
                counted(impacts, "impact"),
                significant(error, ERROR_DIGITS)
            ),
            Occurrence::Release { .. } => match noted.closed_since {
                Some(since) => format!("after {} in contact", self.detail(event.time - since)),
                None => String::new(),
            },
            Occurrence::Graze { rate, .. } => format!("rate {}", self.detail(rate)),
            Occurrence::Cascade { impacts, error, .. } => format!(
                "{} at one instant converge, rates known to {} of the greatest",
                counted(impacts, "collision"),
                significant(error, ERROR_DIGITS)
            ),
            Occurrence::Ambiguity { other, .. } => format!(
                "closes together with {}: which goes first changes the result",
                self.subject.model.contacts[other].name
            ),
            _ => {
                let side = event.detail.side().map(side_name);
                side.map_or_else(String::new, |side| format!("to {side}"))
            }
        };
        Line {
            time: event.time,
            what: event.kind.name().to_owned(),
            place: self.subject.place(&event.detail).to_owned(),
            detail,
        }
    }
}

fn is_impact<R>(event: &Event<R>) -> bool {
    matches!(event.detail, Occurrence::Impact { .. })
}

fn is_section<R>(event: &Event<R>) -> bool {
    matches!(event.detail, Occurrence::Section { .. })
}

fn rate_before<R: Real>(event: &Event<R>) -> Option<R> {
    match event.detail {
        Occurrence::Impact { rate_before, .. } => Some(rate_before),
        _ => None,
    }
}

/// Whether `next` is the next impact of the sequence that `impact` belongs to.
fn continues<R: Real>(impact: &Event<R>, next: &Event<R>) -> bool {
    let place = |event: &Event<R>| match event.detail {
        Occurrence::Impact { contact, .. } => Some(contact),
        _ => None,
    };
    match (rate_before(impact), rate_before(next)) {
        (Some(rate), Some(next_rate)) => {
            place(impact) == place(next) && next_rate.abs() < rate.abs() * R::splat(1.0 - SAME_RATE)
        }
        _ => false,
    }
}
