//! A simulation as one JSON document.

use super::{Record, Subject, sentence, verification};
use crate::json::Json;
use crate::named::Named;
use crate::numbers::significant;
use crate::simulation::side_name;
use chatter::analysis::simulate::{Event, Outcome, Simulation, Verification};
use chatter::flow::Occurrence;
use chatter::numerics::Real;
use serde::ser::{Error, SerializeSeq};
use serde::{Serialize, Serializer};

/// A number, and its digits where a double does not hold them.
struct Value {
    number: f64,
    digits: Option<String>,
}

#[derive(Serialize)]
#[serde(bound = "")]
struct Document<'a, R: Real> {
    outcome: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<ErrorObject>,
    time: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    time_digits: Option<String>,
    state: Named<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    state_digits: Option<Named<String>>,
    closed: Vec<&'a str>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    sliding: Vec<&'a str>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    sticking: Vec<&'a str>,
    counts: Counts,
    events: Events<'a, R>,
    contact_phases: Phases<'a, R>,
    #[serde(skip_serializing_if = "Option::is_none")]
    verification: Option<verification::Object<'a>>,
    model: ModelObject<'a>,
    parameters: Named<f64>,
    start: Start,
    until: f64,
    impact_budget: u64,
    tolerance: f64,
    version: &'static str,
}

#[derive(Serialize)]
struct ErrorObject {
    kind: &'static str,
    message: String,
}

#[derive(Serialize)]
struct ModelObject<'a> {
    source: &'a str,
    title: Option<&'a str>,
}

#[derive(Serialize)]
struct Counts {
    flights: u64,
    impacts: u64,
    accumulations: u64,
    releases: u64,
    grazes: u64,
    sections: u64,
    switches: u64,
    ambiguities: u64,
}

#[derive(Serialize)]
struct Phase<'a> {
    contact: &'a str,
    start: f64,
    end: Option<f64>,
}

#[derive(Serialize)]
struct Start {
    time: f64,
    state: Named<f64>,
}

#[derive(Serialize, Default)]
struct EventObject<'a> {
    kind: &'static str,
    time: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    time_digits: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    contact: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    other: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    section: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    surface: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    event: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    side: Option<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    rate_before: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    rate_before_digits: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    rate_after: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    rate_after_digits: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    closes: Option<bool>,
    #[serde(skip_serializing_if = "Option::is_none")]
    impacts: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    error: Option<f64>,
    state: Named<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    state_digits: Option<Named<String>>,
}

/// The document.
pub fn document<'a, R: Real>(
    subject: &'a Subject,
    (simulation, record): (&'a Simulation<R>, &'a Record<R>),
    verified: Option<&'a Verification>,
) -> impl Serialize + 'a {
    let writer = Writer { subject };
    let (time, state) = (writer.value(simulation.time), &simulation.state);
    let counts = simulation.counts;
    let parameters = subject.model.parameter_values::<f64>(&[]);
    Document {
        outcome: simulation.outcome.name(),
        error: match &simulation.outcome {
            Outcome::Failed(error) => Some(ErrorObject {
                kind: error.name(),
                message: sentence(error, subject.model),
            }),
            _ => None,
        },
        time: time.number,
        time_digits: time.digits,
        state: writer.state(state),
        state_digits: writer.state_digits(state),
        closed: subject.contact_names(simulation.closed),
        sliding: subject.slid(&simulation.held),
        sticking: subject.stuck(&simulation.held),
        counts: Counts {
            flights: counts.flights,
            impacts: counts.impacts,
            accumulations: counts.accumulations,
            releases: counts.releases,
            grazes: counts.grazes,
            sections: counts.sections,
            switches: counts.switches,
            ambiguities: counts.ambiguities,
        },
        events: Events { subject, record },
        contact_phases: Phases { subject, record },
        verification: verified.map(|verified| verification::object(subject, verified)),
        model: ModelObject {
            source: subject.source,
            title: subject.model.title.as_deref(),
        },
        parameters: Named::new(subject.model.parameter_names(), parameters),
        start: Start {
            time: simulation.start_time.to_f64(),
            state: writer.state(&simulation.start_state),
        },
        until: subject.spec.until.to_f64(),
        impact_budget: subject.spec.impacts,
        tolerance: subject.spec.tolerance,
        version: env!("CARGO_PKG_VERSION"),
    }
}

/// One event, as it stands in the document.
pub fn event<R: Real>(subject: &Subject, event: &Event<R>) -> Json {
    let writer = Writer { subject };
    Json::of(&writer.event(event))
}

/// Events become objects one by one, as they are written.
struct Events<'a, R> {
    subject: &'a Subject<'a>,
    record: &'a Record<R>,
}

impl<R: Real> Serialize for Events<'_, R> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let writer = Writer {
            subject: self.subject,
        };
        let mut list = serializer.serialize_seq(None)?;
        for noted in self.record.events() {
            let noted = noted.map_err(S::Error::custom)?;
            list.serialize_element(&writer.event(&noted.event))?;
        }
        list.end()
    }
}

/// So do contact phases.
struct Phases<'a, R> {
    subject: &'a Subject<'a>,
    record: &'a Record<R>,
}

impl<R: Real> Serialize for Phases<'_, R> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut list = serializer.serialize_seq(None)?;
        for phase in self.record.contact_phases() {
            let phase = phase.map_err(S::Error::custom)?;
            list.serialize_element(&Phase {
                contact: &self.subject.model.contacts[phase.contact].name,
                start: phase.start.to_f64(),
                end: phase.end.map(Real::to_f64),
            })?;
        }
        list.end()
    }
}

struct Writer<'a> {
    subject: &'a Subject<'a>,
}

impl<'a> Writer<'a> {
    fn digits<R: Real>(&self, value: R) -> Option<String> {
        let wanted = self.subject.digits;
        (!wanted.fit_double()).then(|| significant(value, wanted.0))
    }

    fn value<R: Real>(&self, value: R) -> Value {
        Value {
            number: value.to_f64(),
            digits: self.digits(value),
        }
    }

    fn state<R: Real>(&self, state: &[R]) -> Named<f64> {
        let subject = self.subject;
        let named = |index: usize| (subject.state_name(index).to_owned(), state[index].to_f64());
        Named(subject.states().map(named).collect())
    }

    fn state_digits<R: Real>(&self, state: &[R]) -> Option<Named<String>> {
        let subject = self.subject;
        let named = |index: usize| {
            Some((
                subject.state_name(index).to_owned(),
                self.digits(state[index])?,
            ))
        };
        let digits: Option<Vec<_>> = subject.states().map(named).collect();
        digits.filter(|_| !subject.digits.fit_double()).map(Named)
    }

    fn event<R: Real>(&self, event: &Event<R>) -> EventObject<'a> {
        let time = self.value(event.time);
        let place = Some(self.subject.place(&event.detail));
        let mut object = EventObject {
            kind: event.kind.name(),
            time: time.number,
            time_digits: time.digits,
            contact: place,
            state: self.state(&event.state),
            state_digits: self.state_digits(&event.state),
            ..EventObject::default()
        };
        let mut rates = |before: R, after: R| {
            let (before, after) = (self.value(before), self.value(after));
            (object.rate_before, object.rate_before_digits) = (Some(before.number), before.digits);
            (object.rate_after, object.rate_after_digits) = (Some(after.number), after.digits);
        };
        object.side = event.detail.side().map(side_name);
        match event.detail {
            Occurrence::Impact {
                rate_before,
                rate_after,
                closes,
                ..
            } => {
                rates(rate_before, rate_after);
                object.closes = Some(closes);
            }
            Occurrence::Graze { rate, .. } => rates(rate, rate),
            Occurrence::Ambiguity { other, .. } => {
                object.other = Some(&self.subject.model.contacts[other].name);
            }
            Occurrence::Accumulation { impacts, error, .. }
            | Occurrence::Cascade { impacts, error, .. } => {
                object.impacts = Some(impacts);
                object.error = Some(error);
            }
            Occurrence::Section { .. } => object.section = object.contact.take(),
            Occurrence::Reset { .. } => object.event = object.contact.take(),
            Occurrence::Switch { .. } | Occurrence::Slide { .. } | Occurrence::Leave { .. } => {
                object.surface = object.contact.take();
            }
            _ => {}
        }
        object
    }
}

impl<T> Default for Named<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}
