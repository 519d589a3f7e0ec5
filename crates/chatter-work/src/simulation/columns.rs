//! A simulation as columns in memory.

use super::{Record, Subject};
use crate::columns::Column;
use crate::refusal::Refusal;
use chatter::analysis::simulate::{Event, Samples};
use chatter::flow::Occurrence;
use chatter::numerics::Real;

/// Times and states.
pub struct Motion {
    /// The times, and what doubles leave of them.
    pub times: [Vec<f64>; 2],
    /// The states proper, one after the other, and what doubles leave of them.
    pub states: [Vec<f64>; 2],
    /// Which contacts were closed, one after the other.
    pub closed: Vec<bool>,
}

/// The high and the low part of numbers, of which the latter are all zero where doubles hold them.
fn parts<R: Real>(numbers: impl Iterator<Item = R>) -> [Vec<f64>; 2] {
    let (mut high, mut low) = (Vec::new(), Vec::new());
    for number in numbers {
        let wide = number.to_double_double();
        high.push(number.to_f64());
        low.push(if number.is_finite() { wide.low() } else { 0.0 });
    }
    [high, low]
}

/// The samples of a run.
pub fn motion<R: Real>(subject: &Subject, samples: &Samples<R>) -> Motion {
    let states = (subject.states()).flat_map(|index| samples.states[index].iter().copied());
    let contacts = 0..subject.model.contacts.len();
    Motion {
        times: parts(samples.times.iter().copied()),
        states: parts(states),
        closed: contacts
            .flat_map(|contact| samples.closed.iter().map(move |set| set.contains(contact)))
            .collect(),
    }
}

/// The events of a run.
pub struct Events {
    /// Times, and states just after the events, one state after the other.
    pub motion: Motion,
    /// What is told of each by its kind: names of kinds in `kind`, of contacts and sections in `place`.
    pub columns: Vec<Column>,
    /// The contacts, sections and surfaces.
    pub places: Vec<String>,
}

/// The rates of the gap before and after an event; NaN where it has none.
pub fn rates<R: Real>(event: &Event<R>) -> [f64; 2] {
    match event.detail {
        Occurrence::Impact {
            rate_before,
            rate_after,
            ..
        } => [rate_before, rate_after].map(Real::to_f64),
        Occurrence::Graze { rate, .. } => [rate.to_f64(); 2],
        _ => [f64::NAN; 2],
    }
}

/// Reads the events that were noted.
///
/// # Errors
/// They cannot be read.
pub fn events<R: Real>(subject: &Subject, record: &Record<R>) -> Result<Events, Refusal> {
    let mut places = Vec::new();
    let (mut times, mut kinds) = (Vec::new(), Vec::new());
    let (mut before, mut after, mut error) = (Vec::new(), Vec::new(), Vec::new());
    let (mut impacts, mut closes) = (Vec::new(), Vec::new());
    let mut states: Vec<Vec<R>> = vec![Vec::new(); subject.model.states.len()];
    for noted in record.events() {
        let event = noted?.event;
        times.push(event.time);
        for (values, value) in states.iter_mut().zip(&event.state) {
            values.push(*value);
        }
        kinds.push(event.kind.name());
        places.push(subject.place(&event.detail).to_owned());
        let rates = rates(&event);
        let (mut count, mut off, mut stays) = (0, f64::NAN, 0);
        match event.detail {
            Occurrence::Impact { closes, .. } => {
                count = 1;
                stays = i64::from(closes);
            }
            Occurrence::Accumulation { impacts, error, .. }
            | Occurrence::Cascade { impacts, error, .. } => {
                count = impacts as i64;
                off = error;
            }
            _ => {}
        }
        before.push(rates[0]);
        after.push(rates[1]);
        impacts.push(count);
        error.push(off);
        closes.push(stays);
    }
    let count = times.len();
    let motion = Motion {
        times: parts(times.into_iter()),
        states: parts((subject.states()).flat_map(|index| states[index].iter().copied())),
        closed: Vec::new(),
    };
    debug_assert_eq!(places.len(), count);
    Ok(Events {
        motion,
        columns: vec![
            Column::words("kind", kinds),
            Column::floats("rate_before", before),
            Column::floats("rate_after", after),
            Column::integers("impacts", impacts),
            Column::floats("error", error),
            Column::integers("closes", closes),
        ],
        places,
    })
}

/// From when to when each contact was closed: its number, start and end, which is NaN where the run ended before.
///
/// # Errors
/// They cannot be read.
pub fn contact_phases<R: Real>(record: &Record<R>) -> Result<[Column; 3], Refusal> {
    let (mut contacts, mut starts, mut ends) = (Vec::new(), Vec::new(), Vec::new());
    for phase in record.contact_phases() {
        let phase = phase?;
        contacts.push(phase.contact as i64);
        starts.push(phase.start.to_f64());
        ends.push(phase.end.map_or(f64::NAN, Real::to_f64));
    }
    Ok([
        Column::integers("contact", contacts),
        Column::floats("start", starts),
        Column::floats("end", ends),
    ])
}
