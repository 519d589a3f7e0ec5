//! How a run compares with its twin in double-double, as text and as JSON.

use super::follow::{part_done, refused};
use super::{Record, Subject};
use crate::named::Named;
use crate::numbers::{concise, significant};
use crate::observer::Observer;
use crate::refusal::Refusal;
use chatter::analysis::simulate::{Outcome, Progress, Simulation, Verification, digits};
use chatter::flow::{EventKind, Occurrence};
use serde::Serialize;

/// Digits of a difference.
const ERROR_DIGITS: u32 = 2;
/// Digits of the times at which runs part ways.
const TIME_DIGITS: u32 = 9;

/// Follows the twin of a run and compares; none where the run or its twin was interrupted.
///
/// # Errors
/// The twin cannot begin, or the run's events cannot be read back.
pub fn verify(
    subject: &Subject,
    (simulation, record): (&Simulation<f64>, &Record<f64>),
    observer: &dyn Observer,
) -> Result<Option<Verification>, Refusal> {
    if simulation.outcome == Outcome::Interrupted {
        return Ok(None);
    }
    let mut unread = None;
    let mut events = record.events().map_while(|noted| match noted {
        Ok(noted) => Some(noted.event),
        Err(error) => {
            unread = Some(error);
            None
        }
    });
    let (model, spec) = (subject.model, subject.spec);
    let mut show = |reached: &Progress| {
        observer.progress(part_done(reached), &|| {
            format!(
                "the twin: time {:.6}, {} impacts",
                reached.time, reached.impacts
            )
        });
        observer.going_on()
    };
    let verified = Verification::beside(model, spec, simulation, &mut events, &mut show);
    let verified = verified.map_err(|error| refused(&error, model))?;
    match unread {
        Some(error) => Err(error.into()),
        None => Ok(verified),
    }
}

/// The comparison, for a document.
#[derive(Serialize)]
pub struct Object<'a> {
    /// Events that both runs have.
    events: usize,
    /// By how much the times of these are off; null where the twin has completed the sequence before.
    event_time_errors: Vec<Option<f64>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    parting: Option<PartingObject<'a>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    time_error: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    state_errors: Option<Named<f64>>,
}

#[derive(Serialize)]
struct PartingObject<'a> {
    run: Option<Next<'a>>,
    twin: Option<Next<'a>>,
}

#[derive(Serialize)]
struct Next<'a> {
    time: f64,
    kind: &'static str,
    place: &'a str,
}

fn next<'a>(subject: &'a Subject, event: Option<(f64, Occurrence<f64>)>) -> Option<Next<'a>> {
    event.map(|(time, detail)| Next {
        time,
        kind: detail.kind().map_or("", EventKind::name),
        place: subject.place(&detail),
    })
}

/// As a member of the JSON document.
pub fn object<'a>(subject: &'a Subject, verification: &Verification) -> Object<'a> {
    let end = verification.end.as_ref();
    Object {
        events: verification.times.len(),
        event_time_errors: (verification.times.iter())
            .map(|&off| off.is_finite().then_some(off))
            .collect(),
        parting: verification.parting.as_ref().map(|parting| PartingObject {
            run: next(subject, parting.run),
            twin: next(subject, parting.twin),
        }),
        time_error: end.map(|end| end.time),
        state_errors: end.map(|end| {
            let named = |index: usize| (subject.state_name(index).to_owned(), end.state[index]);
            Named(subject.states().map(named).collect())
        }),
    }
}

/// As lines after the account.
pub fn text(
    subject: &Subject,
    (simulation, record): (&Simulation<f64>, &Record<f64>),
    verification: &Verification,
) -> Result<String, Refusal> {
    let error = |off: f64| significant(off, ERROR_DIGITS);
    let mut text = "  beside a twin in double-double\n".to_owned();
    let count = verification.times.len();
    if count > 0 {
        let mut fewest = None;
        for (noted, &off) in record.events().zip(&verification.times) {
            if off.is_finite() {
                let known = digits(noted?.event.time, off);
                fewest = Some(fewest.map_or(known, |fewest: u32| fewest.min(known)));
            }
        }
        let all = match &verification.parting {
            None => "all events",
            Some(_) => "the first events",
        };
        text += &format!(
            "    {all} ({count}) agree, their times to {} digits, off by {} at most\n",
            fewest.unwrap_or(0),
            error(verification.worst_time())
        );
    }
    if let Some(parting) = &verification.parting {
        let told = |event| match next(subject, event) {
            Some(Next { time, kind, place }) => {
                format!("{kind} {place} at {}", concise(time, TIME_DIGITS))
            }
            None => "no further event".to_owned(),
        };
        text += &format!(
            "    here the runs part ways: {}, in the twin {}\n",
            told(parting.run),
            told(parting.twin)
        );
    }
    match &verification.end {
        Some(end) => {
            let names = || subject.states().map(|index| subject.state_name(index));
            let width = names().map(|name| name.chars().count()).max().unwrap_or(0);
            for (index, name) in subject.states().zip(names()) {
                let off = end.state[index];
                text += &format!(
                    "    {name:width$}   {} digits agree, off by {}\n",
                    digits(simulation.state[index], off),
                    error(off)
                );
            }
        }
        None => text += "    the runs end in different ways\n",
    }
    Ok(text)
}
