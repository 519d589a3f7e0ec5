//! The lines of the list: one an event, or one a sequence of impacts.

use super::{Teller, counted};
use crate::numbers::significant;
use crate::simulation::side_name;
use chatter::analysis::simulate::{ContactPhase, Event, EventDetail};
use chatter::flow::Closed;
use chatter::numerics::Real;

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

impl<R: Real> Teller<'_, R> {
    /// One line an event.
    pub(super) fn every_event(&self) -> Vec<Line<R>> {
        let events = self.simulation.events.iter();
        core::iter::once(self.start_line())
            .chain(events.map(|event| self.line(event)))
            .collect()
    }

    /// Impacts of one contact with ever smaller rates are one line, whatever sections they cross on the way.
    pub(super) fn summary(&self) -> Vec<Line<R>> {
        let mut lines = vec![self.start_line()];
        let mut rest = self.simulation.events.as_slice();
        while let Some(first) = rest.first() {
            let mut impacts = vec![first];
            let mut crossings = 0;
            let mut taken = 1;
            if is_impact(first) {
                while let Some(ahead) = rest[taken..].iter().position(|event| !is_section(event)) {
                    let next = &rest[taken + ahead];
                    if !continues(impacts[impacts.len() - 1], next) {
                        break;
                    }
                    impacts.push(next);
                    crossings += ahead as u64;
                    taken += ahead + 1;
                }
            }
            lines.push(match impacts.len() {
                1 => self.line(first),
                _ => self.sequence(&impacts, crossings),
            });
            rest = &rest[taken..];
        }
        lines
    }

    fn sequence(&self, impacts: &[&Event<R>], crossings: u64) -> Line<R> {
        let (first, last) = (impacts[0], impacts[impacts.len() - 1]);
        let rate = |event| self.detail(rate_before(event).unwrap_or(R::ZERO));
        let crossed = match crossings {
            0 => String::new(),
            _ => format!(", {}", counted(crossings, "section crossing")),
        };
        Line {
            time: first.time,
            what: counted(impacts.len() as u64, "impact"),
            place: self.subject.place(&first.detail).to_owned(),
            detail: format!(
                "until {}, rates {} to {}{crossed}",
                self.time(last.time),
                rate(first),
                rate(last)
            ),
        }
    }

    fn start_line(&self) -> Line<R> {
        let at_start = self.simulation.contact_phases.iter();
        let closed = at_start.take_while(|phase| phase.start == self.simulation.start_time);
        let closed = closed.fold(Closed::NONE, |closed, phase| closed.with(phase.contact));
        Line {
            time: self.simulation.start_time,
            what: "start".to_owned(),
            place: String::new(),
            detail: self.phase(closed),
        }
    }

    fn line(&self, event: &Event<R>) -> Line<R> {
        let detail = match event.detail {
            EventDetail::Impact {
                rate_before,
                rate_after,
                closes,
                ..
            } => {
                let (before, after) = (self.detail(rate_before), self.detail(rate_after));
                let closing = if closes { ", closes" } else { "" };
                format!("rate {before} -> {after}{closing}")
            }
            EventDetail::Accumulation { impacts, error, .. } => format!(
                "after {}, local error {}",
                counted(impacts, "impact"),
                significant(error, ERROR_DIGITS)
            ),
            EventDetail::Release { contact } => self.time_in_contact(contact, event.time),
            EventDetail::Graze { rate, .. } => format!("rate {}", self.detail(rate)),
            EventDetail::Section { .. } => String::new(),
            EventDetail::Corner { side, .. } => {
                side.map_or_else(String::new, |side| format!("to {}", side_name(side)))
            }
            EventDetail::Cascade { impacts, error, .. } => format!(
                "{} at one instant converge, rates known to {} of the greatest",
                counted(impacts, "collision"),
                significant(error, ERROR_DIGITS)
            ),
            EventDetail::Ambiguity { other, .. } => format!(
                "closes together with {}: which goes first changes the result",
                self.subject.model.contacts[other].name
            ),
        };
        Line {
            time: event.time,
            what: event.kind().name().to_owned(),
            place: self.subject.place(&event.detail).to_owned(),
            detail,
        }
    }

    fn time_in_contact(&self, contact: usize, end: R) -> String {
        let ended = |phase: &&ContactPhase<R>| phase.contact == contact && phase.end == Some(end);
        match self.simulation.contact_phases.iter().find(ended) {
            Some(phase) => format!("after {} in contact", self.detail(end - phase.start)),
            None => String::new(),
        }
    }
}

fn is_impact<R>(event: &Event<R>) -> bool {
    matches!(event.detail, EventDetail::Impact { .. })
}

fn is_section<R>(event: &Event<R>) -> bool {
    matches!(event.detail, EventDetail::Section { .. })
}

fn rate_before<R: Real>(event: &Event<R>) -> Option<R> {
    match event.detail {
        EventDetail::Impact { rate_before, .. } => Some(rate_before),
        _ => None,
    }
}

/// Whether `next` is the next impact of the sequence that `impact` belongs to.
fn continues<R: Real>(impact: &Event<R>, next: &Event<R>) -> bool {
    let place = |event: &Event<R>| match event.detail {
        EventDetail::Impact { contact, .. } => Some(contact),
        _ => None,
    };
    match (rate_before(impact), rate_before(next)) {
        (Some(rate), Some(next_rate)) => {
            place(impact) == place(next) && next_rate.abs() < rate.abs() * R::splat(1.0 - SAME_RATE)
        }
        _ => false,
    }
}
