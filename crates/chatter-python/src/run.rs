//! One trajectory.

use crate::arrays::{columns, floats, matrix};
use crate::errors::{raised, unreadable};
use crate::interruptible::{Listener, interruptible};
use crate::model::Core;
use chatter::analysis::simulate::{Counts, Outcome, Sampling, Spec};
use chatter::model::Model;
use chatter::numerics::{DoubleDouble, Real};
use chatter_work::Refusal;
use chatter_work::columns::Column;
use chatter_work::numbers::{Digits, significant};
use chatter_work::options::{Count, Precision, Quantity, StopOption};
use chatter_work::simulation::columns::{Events, Motion, contact_phases, events, motion};
use chatter_work::simulation::{
    Followed, Request, Rows, SampleOption, Subject, follow, sentence, start_time,
};
use numpy::PyReadonlyArray1;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::str::FromStr;
use std::sync::Arc;

/// All of a run, as doubles and what they leave.
struct Answer {
    outcome: &'static str,
    message: String,
    /// Why it could not go on, where it could not.
    failed: bool,
    start: f64,
    time: f64,
    state: Vec<f64>,
    /// To all the digits that were asked for.
    texts: Vec<String>,
    closed: Vec<String>,
    counts: Counts,
    motion: Option<Motion>,
    events: Events,
    phases: [Column; 3],
}

/// What is asked of the run, but for the digits.
struct Question {
    model: Arc<Model>,
    source: String,
    spec: Spec,
    digits: Digits,
    time_was_given: bool,
}

/// Follows one trajectory. `times` are sampled where there are any, else what `sample` says.
#[pyfunction]
#[pyo3(signature = (core, *, until=None, impacts=None, stop=vec![], tolerance=None, sample=None, times=None, digits=17,
                    progress=None))]
#[allow(clippy::too_many_arguments)]
pub fn simulate<'py>(
    py: Python<'py>,
    core: &Core,
    until: Option<String>,
    impacts: Option<u64>,
    stop: Vec<String>,
    tolerance: Option<String>,
    sample: Option<String>,
    times: Option<PyReadonlyArray1<'py, f64>>,
    digits: u32,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let digits = Precision::from_str(&digits.to_string())
        .map_err(|error| unreadable("digits", error))?
        .0;
    let mut stops = Vec::new();
    for text in stop {
        let stop = StopOption::from_str(&text).map_err(|error| unreadable("stop", error))?;
        stops.push(stop.0);
    }
    let mut model = (*core.model).clone();
    let request = Request {
        until: until.map(Quantity),
        impacts: impacts.map(Count),
        stops,
        tolerance: tolerance.map(Quantity),
    };
    let mut spec = request.spec(&mut model).map_err(raised)?;
    match (times, sample) {
        (Some(times), _) => {
            let times = times.as_array();
            let start = start_time(&model);
            // What is written as the start is meant to be it.
            let time = |&time: &f64| match time == start.to_f64() {
                true => start,
                false => DoubleDouble::from(time),
            };
            spec.sampling = vec![Sampling::At(times.iter().map(time).collect())];
        }
        (None, Some(sample)) => {
            let option = SampleOption::from_str(&sample);
            let option = option.map_err(|error| unreadable("sample", error))?;
            spec.sampling
                .extend(option.sampling(&mut model).map_err(raised)?);
        }
        (None, None) => {}
    }
    let question = Question {
        model: Arc::clone(&core.model),
        source: core.name.clone(),
        spec,
        digits,
        time_was_given: request.until.is_some(),
    };
    let answer = interruptible(py, progress, move |listener| {
        if question.digits.fit_double() {
            answer::<f64>(&question, listener)
        } else {
            answer::<DoubleDouble>(&question, listener)
        }
    })?;
    told(py, answer.map_err(raised)?)
}

fn answer<R: Real>(question: &Question, listener: &Listener) -> Result<Answer, Refusal> {
    let nothing = Default::default();
    let subject = Subject {
        model: &question.model,
        spec: &question.spec,
        source: &question.source,
        text: "",
        data_files: &nothing,
        digits: question.digits,
        time_was_given: question.time_was_given,
    };
    let rows = match question.spec.sampling.is_empty() {
        true => Rows::None,
        false => Rows::Memory,
    };
    let Followed {
        simulation,
        record,
        samples,
        ..
    } = follow::<R>(&subject, &rows, listener)?;
    let message = match &simulation.outcome {
        Outcome::Failed(error) => sentence(error, subject.model),
        Outcome::Horizon => "the end of time is reached".to_owned(),
        Outcome::ImpactBudget => format!("stopped after {} impacts", simulation.counts.impacts),
        Outcome::Event(target) => format!("stopped at the {target}"),
        Outcome::Rest => "at rest for ever".to_owned(),
        Outcome::Interrupted => return Err(Refusal::Interrupted),
    };
    let state = || subject.states().map(|index| simulation.state[index]);
    Ok(Answer {
        outcome: simulation.outcome.name(),
        message,
        failed: matches!(simulation.outcome, Outcome::Failed(_)),
        start: simulation.start_time.to_f64(),
        time: simulation.time.to_f64(),
        state: state().map(Real::to_f64).collect(),
        texts: (std::iter::once(simulation.time).chain(state()))
            .map(|value| significant(value, question.digits.0))
            .collect(),
        closed: (subject.contact_names(simulation.closed).into_iter())
            .map(str::to_owned)
            .collect(),
        counts: simulation.counts,
        motion: samples.map(|samples| motion(&subject, &samples)),
        events: events(&subject, &record)?,
        phases: contact_phases(&record)?,
    })
}

fn told(py: Python<'_>, answer: Answer) -> PyResult<Bound<'_, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("outcome", answer.outcome)?;
    dict.set_item("message", answer.message)?;
    dict.set_item("failed", answer.failed)?;
    dict.set_item("start_time", answer.start)?;
    dict.set_item("time", answer.time)?;
    dict.set_item("state", answer.state)?;
    dict.set_item("texts", answer.texts)?;
    dict.set_item("closed_at_end", answer.closed)?;
    let counts = PyDict::new(py);
    let named = [
        ("flights", answer.counts.flights),
        ("impacts", answer.counts.impacts),
        ("accumulations", answer.counts.accumulations),
        ("releases", answer.counts.releases),
        ("grazes", answer.counts.grazes),
        ("sections", answer.counts.sections),
        ("switches", answer.counts.switches),
        ("ambiguities", answer.counts.ambiguities),
    ];
    for (name, count) in named {
        counts.set_item(name, count)?;
    }
    dict.set_item("counts", counts)?;
    dict.set_item(
        "motion",
        answer.motion.map(|motion| moved(py, motion)).transpose()?,
    )?;
    let of_events = columns(py, answer.events.columns)?;
    of_events.set_item("place", answer.events.places)?;
    of_events.set_item("motion", moved(py, answer.events.motion)?)?;
    dict.set_item("events", of_events)?;
    dict.set_item("phases", columns(py, answer.phases)?)?;
    Ok(dict)
}

/// Times, what doubles leave of them, states, what doubles leave of them, closed contacts.
type Moved<'py> = [Bound<'py, PyAny>; 5];

fn moved(py: Python<'_>, motion: Motion) -> PyResult<Moved<'_>> {
    let [times, times_low] = motion.times;
    let [states, states_low] = motion.states;
    let count = times.len();
    let rows = |values: usize| values.checked_div(count).unwrap_or(0);
    let (of_states, of_contacts) = (rows(states.len()), rows(motion.closed.len()));
    Ok([
        floats(py, times),
        floats(py, times_low),
        matrix(py, states, of_states, count)?,
        matrix(py, states_low, of_states, count)?,
        matrix(py, motion.closed, of_contacts, count)?,
    ])
}
