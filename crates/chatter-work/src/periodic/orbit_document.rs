//! Periodic orbits as one JSON document.

use super::Subject;
use crate::json::{Json, Object};
use crate::refusal::Refusal;
use crate::simulation::sentence;
use chatter::analysis::periodic::Orbit;
use chatter::analysis::simulate::{Event, Simulation, Spec, simulate};
use chatter::numerics::Complex;
use core::ops::ControlFlow;

/// The document: one orbit, or a list of all that were found.
///
/// # Errors
/// An orbit cannot be followed for its events.
pub fn document(subject: &Subject, orbits: &[Orbit], all: bool) -> Result<Object, Refusal> {
    let mut objects = Vec::new();
    for orbit in orbits {
        objects.push(Json::from(object(subject, orbit)?));
    }
    let start = Object::new(subject.digits);
    let told = match (all, objects.pop()) {
        (false, Some(one)) => start.with("orbit", one),
        (true, last) => {
            objects.extend(last);
            start.with("orbits", objects)
        }
        (false, None) => start.with("orbit", Json::Null),
    };
    let parameters = subject.model.parameter_values::<f64>(&[]);
    Ok(told
        .with("model", about(subject))
        .named("parameters", &subject.model.parameter_names(), &parameters)
        .with("version", env!("CARGO_PKG_VERSION")))
}

/// The model, as documents name it.
pub(super) fn about(subject: &Subject) -> Object {
    let title = subject.model.title.as_deref();
    Object::new(subject.digits)
        .with("source", subject.source)
        .with("title", title.map_or(Json::Null, Json::from))
}

/// Multipliers as a list of real and imaginary parts.
pub(super) fn multipliers(values: &[Complex]) -> Vec<Json> {
    let one = |value: &Complex| {
        Object::new(crate::numbers::Digits::DOUBLE)
            .with("re", value.re)
            .with("im", value.im)
            .into()
    };
    values.iter().map(one).collect()
}

fn object(subject: &Subject, orbit: &Orbit) -> Result<Object, Refusal> {
    let names = subject.model.state_names();
    let events = events_of(subject, orbit)?;
    let margins = orbit.margins.iter().map(|margin| {
        Object::new(subject.digits)
            .with("kind", margin.kind.name())
            .with("where", subject.place(margin.guard))
            .with("time", margin.time)
            .with("value", margin.value)
            .into()
    });
    let turns = orbit.turns.iter().filter(|(_, count)| *count != 0);
    let turns = turns.fold(Object::new(subject.digits), |object, (state, count)| {
        object.with(&subject.model.states[*state].name, *count)
    });
    let section = match orbit.section {
        Some(section) => Json::from(subject.model.sections[section].name.as_str()),
        None => Json::Null,
    };
    let impacts = orbit
        .impacts
        .map_or(Json::Null, |count| Json::Integer(count as i64));
    Ok(Object::new(subject.digits)
        .number("period", orbit.period)
        .named("start", &names, &orbit.start)
        .named("section", &names, &orbit.start)
        .with("section_name", section)
        .with("events", event_list(subject, &events))
        .with("impacts", impacts)
        .with("complete_chatter", Json::Bool(orbit.impacts.is_none()))
        .with("turns", turns)
        .with("multipliers", multipliers(&orbit.multipliers))
        .maybe("trivial_multiplier", orbit.trivial_multiplier)
        .with("residual", orbit.residual)
        .with("error", orbit.correction)
        .with("stable", Json::Bool(orbit.is_stable()))
        .with("neutral", Json::Bool(orbit.is_neutral()))
        .with("margins", margins.collect::<Vec<Json>>()))
}

/// What happens in one period, with times from its start.
///
/// # Errors
/// The orbit cannot be followed.
pub fn events_of(subject: &Subject, orbit: &Orbit) -> Result<Vec<Event<f64>>, Refusal> {
    let run = run_of(subject, orbit)?;
    let begin = run.start_time;
    let mut events = run.events;
    for event in &mut events {
        event.time -= begin;
    }
    // What a period begins with is told at its end: at the start it depends on rounding whether it was.
    let period = orbit.period.high();
    let late = LATE * period;
    let again: Vec<_> = (events.iter())
        .filter(|event| event.time >= period - late)
        .map(|event| (event.kind, event.detail.place()))
        .collect();
    events
        .retain(|event| event.time > late || !again.contains(&(event.kind, event.detail.place())));
    Ok(events)
}

/// Events at the very end of a period belong to it, in parts of it; those at the very start come again there.
const LATE: f64 = 1e-9;

/// One period, followed from its start.
fn run_of(subject: &Subject, orbit: &Orbit) -> Result<Simulation<f64>, Refusal> {
    let mut model = subject.model.clone();
    for (state, &value) in model.states.iter_mut().zip(&orbit.start) {
        state.initial = model.graph.number_exact(value);
    }
    for (parameter, &value) in model.parameters.iter_mut().zip(&orbit.parameters) {
        parameter.value = model.graph.number(value);
    }
    let start = model.time.map_or(0.0, |index| orbit.start[index].high());
    let until = start + orbit.period.high() * (1.0 + LATE);
    simulate::<f64>(&model, &Spec::until(until), &mut |_| {
        ControlFlow::Continue(())
    })
    .map_err(|error| {
        let message = match &error {
            chatter::analysis::simulate::SimulateError::Start(error) => {
                sentence(error, subject.model)
            }
            error => error.to_string(),
        };
        Refusal::Unfinished {
            message,
            help: None,
        }
    })
}

fn event_list(subject: &Subject, events: &[Event<f64>]) -> Vec<Json> {
    let data_files = crate::data_files::DataFiles::new();
    let spec = Spec::until(0.0);
    let as_simulation = crate::simulation::Subject {
        model: subject.model,
        spec: &spec,
        source: subject.source,
        text: subject.text,
        data_files: &data_files,
        digits: crate::numbers::Digits::DOUBLE,
        time_was_given: true,
    };
    (events.iter())
        .map(|event| crate::simulation::document::event(&as_simulation, event))
        .collect()
}
