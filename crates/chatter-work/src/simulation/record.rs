//! What happened on a run, written down as it happens: in flat memory, and read as often as it has to be told.

use chatter::analysis::simulate::{ContactPhase, Event};
use chatter::expressions::Side;
use chatter::flow::{EventKind, Occurrence, Place};
use chatter::numerics::{DoubleDouble, Real};
use chatter_files::FileError;
use chatter_files::record_log::{RecordLog, Records};
use std::path::Path;

/// Bytes of a number, with what a double leaves of it.
const NUMBER: usize = 16;
/// Bytes of an event before its state: kind, flag, place, other place, impacts, error, then time, two rates and the time
/// since which a contact was closed.
const EVENT: usize = 2 + 4 + 4 + 8 + 8 + 4 * NUMBER;
/// Bytes of a contact phase: contact, whether it has ended, start, end.
const PHASE: usize = 4 + 1 + 2 * NUMBER;

/// Sides by number, from one; zero for none.
const SIDES: [Side; 3] = [Side::Above, Side::Below, Side::Sliding];

/// An event, and what is told of it beside.
#[derive(Clone, Debug)]
pub struct Noted<R> {
    /// What happened.
    pub event: Event<R>,
    /// For a release, since when the contact was closed.
    pub closed_since: Option<R>,
}

/// Events and contact phases of a run, in order.
pub struct Record<R> {
    dimension: usize,
    events: RecordLog,
    phases: RecordLog,
    /// For each contact its latest phase that has ended.
    ended: Vec<Option<ContactPhase<R>>>,
    bytes: Vec<u8>,
}

impl<R: Real> Record<R> {
    /// An empty one, of so many states and contacts; should it grow long, on the disk of `folder`.
    pub fn new(folder: &Path, dimension: usize, contacts: usize) -> Self {
        Self {
            dimension,
            events: RecordLog::new(folder, EVENT + dimension * NUMBER),
            phases: RecordLog::new(folder, PHASE),
            ended: vec![None; contacts],
            bytes: Vec::new(),
        }
    }

    /// How many events there are.
    pub fn len(&self) -> u64 {
        self.events.len()
    }

    /// Whether nothing has happened.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Takes note of an event.
    pub fn event(&mut self, event: &Event<R>) -> Result<(), FileError> {
        let (mut flag, mut other, mut impacts, mut error) = (false, 0, 0, 0.0);
        let mut rates = [R::ZERO; 2];
        let mut since = R::splat(f64::NAN);
        match event.detail {
            Occurrence::Impact {
                rate_before,
                rate_after,
                closes,
                ..
            } => (rates, flag) = ([rate_before, rate_after], closes),
            Occurrence::Graze { rate, .. } => rates = [rate, rate],
            Occurrence::Accumulation {
                impacts: count,
                error: size,
                ..
            }
            | Occurrence::Cascade {
                impacts: count,
                error: size,
                ..
            } => (impacts, error) = (count, size),
            Occurrence::Ambiguity { other: place, .. } => other = place,
            Occurrence::Release { contact } => {
                let ended = self.ended[contact].filter(|phase| phase.end == Some(event.time));
                if let Some(phase) = ended {
                    (since, flag) = (phase.start, true);
                }
            }
            _ => {
                let known = |side| SIDES.iter().position(|&known| known == side);
                other = (event.detail.side().and_then(known)).map_or(0, |place| place + 1);
            }
        }
        let kind = EventKind::ALL.iter().position(|&kind| kind == event.kind);
        self.bytes.clear();
        self.bytes.push(kind.unwrap_or(0) as u8);
        self.bytes.push(u8::from(flag));
        let place = event.detail.place().map_or(0, Place::index);
        for place in [place, other] {
            self.bytes.extend_from_slice(&(place as u32).to_le_bytes());
        }
        self.bytes.extend_from_slice(&impacts.to_le_bytes());
        self.bytes.extend_from_slice(&error.to_le_bytes());
        for number in [event.time, rates[0], rates[1], since] {
            put(&mut self.bytes, number);
        }
        for &number in &event.state {
            put(&mut self.bytes, number);
        }
        self.events.push(&self.bytes)
    }

    /// Takes note of a contact phase that has begun, or of its end.
    pub fn contact_phase(&mut self, number: u64, phase: &ContactPhase<R>) -> Result<(), FileError> {
        self.bytes.clear();
        let contact = phase.contact as u32;
        self.bytes.extend_from_slice(&contact.to_le_bytes());
        self.bytes.push(u8::from(phase.end.is_some()));
        put(&mut self.bytes, phase.start);
        put(&mut self.bytes, phase.end.unwrap_or(R::ZERO));
        if phase.end.is_some() {
            self.ended[phase.contact] = Some(*phase);
        }
        if number < self.phases.len() {
            self.phases.replace(number, &self.bytes)
        } else {
            self.phases.push(&self.bytes)
        }
    }

    /// All events, in order.
    pub fn events(&self) -> impl Iterator<Item = Result<Noted<R>, FileError>> {
        let read = move |bytes: &[u8]| read_event(bytes, self.dimension);
        Reading {
            records: self.events.read(),
            read,
        }
    }

    /// All contact phases, in order of their start.
    pub fn contact_phases(&self) -> impl Iterator<Item = Result<ContactPhase<R>, FileError>> {
        Reading {
            records: self.phases.read(),
            read: read_phase,
        }
    }
}

/// Goes through a log.
struct Reading<'a, F> {
    records: Records<'a>,
    read: F,
}

impl<T, F: Fn(&[u8]) -> T> Iterator for Reading<'_, F> {
    type Item = Result<T, FileError>;

    fn next(&mut self) -> Option<Result<T, FileError>> {
        let read = &self.read;
        self.records.next().map(|bytes| bytes.map(read)).transpose()
    }
}

fn put<R: Real>(bytes: &mut Vec<u8>, number: R) {
    let number = number.to_double_double();
    bytes.extend_from_slice(&number.high().to_le_bytes());
    bytes.extend_from_slice(&number.low().to_le_bytes());
}

/// Takes bytes from the front.
struct Cursor<'a>(&'a [u8]);

impl Cursor<'_> {
    fn take<const N: usize>(&mut self) -> [u8; N] {
        let (taken, rest) = self.0.split_at(N);
        self.0 = rest;
        taken.try_into().expect("as many as were split off")
    }

    fn place(&mut self) -> usize {
        u32::from_le_bytes(self.take()) as usize
    }

    fn number<R: Real>(&mut self) -> R {
        let [high, low] = [(); 2].map(|()| f64::from_le_bytes(self.take()));
        // What is not finite has no parts.
        let number = if high.is_finite() {
            DoubleDouble::sum(high, low)
        } else {
            high.into()
        };
        R::from_double_double(number)
    }
}

fn read_event<R: Real>(bytes: &[u8], dimension: usize) -> Noted<R> {
    let mut bytes = Cursor(bytes);
    let [kind, flag] = bytes.take();
    let (place, other) = (bytes.place(), bytes.place());
    let impacts = u64::from_le_bytes(bytes.take());
    let error = f64::from_le_bytes(bytes.take());
    let [time, rate_before, rate_after, since] = [(); 4].map(|()| bytes.number());
    let (contact, flag) = (place, flag != 0);
    let side = SIDES[other.saturating_sub(1).min(SIDES.len() - 1)];
    let kind = EventKind::ALL[usize::from(kind)];
    let detail = match kind {
        EventKind::Impact => Occurrence::Impact {
            contact,
            rate_before,
            rate_after,
            closes: flag,
        },
        EventKind::Accumulation => Occurrence::Accumulation {
            contact,
            impacts,
            error,
        },
        EventKind::Release => Occurrence::Release { contact },
        EventKind::Graze => Occurrence::Graze {
            contact,
            rate: rate_before,
        },
        EventKind::Section => Occurrence::Section { section: place },
        EventKind::Cascade => Occurrence::Cascade {
            contact,
            impacts,
            error,
        },
        EventKind::Ambiguity => Occurrence::Ambiguity { contact, other },
        EventKind::Switch => Occurrence::Switch {
            surface: place,
            side,
        },
        EventKind::Slide => Occurrence::Slide { surface: place },
        EventKind::Leave => Occurrence::Leave {
            surface: place,
            side,
        },
        EventKind::Stick => Occurrence::Stick { contact },
        EventKind::Slip => Occurrence::Slip { contact, side },
        EventKind::Reset => Occurrence::Reset { section: place },
    };
    let is_release = matches!(detail, Occurrence::Release { .. });
    Noted {
        event: Event {
            time,
            state: (0..dimension).map(|_| bytes.number()).collect(),
            kind,
            detail,
        },
        closed_since: (is_release && flag).then_some(since),
    }
}

fn read_phase<R: Real>(bytes: &[u8]) -> ContactPhase<R> {
    let mut bytes = Cursor(bytes);
    let contact = bytes.place();
    let [ended] = bytes.take();
    let (start, end) = (bytes.number(), bytes.number());
    ContactPhase {
        contact,
        start,
        end: (ended != 0).then_some(end),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all<T>(read: impl Iterator<Item = Result<T, FileError>>) -> Vec<T> {
        read.map(Result::unwrap).collect()
    }

    fn comes_back<R: Real>(number: impl Fn(u32) -> R) {
        let details = |k: u32| -> Occurrence<R> {
            let contact = k as usize % 3;
            match k % 8 {
                0 => Occurrence::Impact {
                    contact,
                    rate_before: -number(k),
                    rate_after: number(k + 1),
                    closes: k.is_multiple_of(2),
                },
                1 => Occurrence::Accumulation {
                    contact,
                    impacts: u64::MAX - u64::from(k),
                    error: 1e-14,
                },
                2 => Occurrence::Release { contact },
                3 => Occurrence::Graze {
                    contact,
                    rate: number(k),
                },
                4 => Occurrence::Section { section: 127 },
                5 => Occurrence::Cascade {
                    contact,
                    impacts: 7,
                    error: f64::MIN_POSITIVE,
                },
                6 => [
                    Occurrence::Slide { surface: 5 },
                    Occurrence::Leave {
                        surface: 5,
                        side: Side::Above,
                    },
                    Occurrence::Slip {
                        contact: 5,
                        side: Side::Below,
                    },
                ][contact],
                _ => Occurrence::Ambiguity { contact, other: 2 },
            }
        };
        let mut record = Record::new(&std::env::temp_dir(), 3, 3);
        let events: Vec<Event<R>> = (0..20_000)
            .map(|k| Event {
                time: number(k),
                state: vec![number(k + 2), -number(k + 3), R::splat(f64::INFINITY)],
                kind: details(k).kind().expect("an event"),
                detail: details(k),
            })
            .collect();
        let phase = |k: u32, end| ContactPhase {
            contact: (k as usize + 1) % 3,
            start: number(k),
            end,
        };
        for (k, event) in (0..).zip(&events) {
            record.contact_phase(k.into(), &phase(k, None)).unwrap();
            if k > 0 {
                // The one before ends where this event is.
                let ended = phase(k - 1, Some(event.time));
                record.contact_phase((k - 1).into(), &ended).unwrap();
            }
            record.event(event).unwrap();
        }
        for _ in 0..2 {
            let noted = all(record.events());
            assert_eq!(noted.len() as u64, record.len());
            for (k, (noted, event)) in (0..).zip(noted.iter().zip(&events)) {
                assert_eq!(noted.event, *event);
                let is_release = k % 8 == 2;
                assert_eq!(noted.closed_since, is_release.then(|| number(k - 1)));
            }
            let phases = all(record.contact_phases());
            for (k, phase_read) in (0..).zip(&phases) {
                let end = (k < 19_999).then(|| number(k + 1));
                assert_eq!(*phase_read, phase(k, end));
            }
            assert_eq!(phases.len(), 20_000);
        }
    }

    #[test]
    fn what_was_noted_comes_back_to_the_last_digit() {
        comes_back(|k| f64::from(k) * 0.1 + 0.3);
        comes_back(|k| DoubleDouble::PI * DoubleDouble::from(f64::from(k) + 0.1));
    }
}
