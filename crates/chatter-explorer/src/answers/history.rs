//! One motion: its samples, events and contact phases.

use super::Answering;
use super::file::{Extension, stem};
use crate::question::HistoryQuestion;
use crate::record::Kind;
use chatter::analysis::simulate::{EventKind, Outcome, Samples, Sampling, Simulation, Spec};
use chatter::expressions::{Expr, Graph};
use chatter::model::{Mechanics, Model};
use chatter::numerics::DoubleDouble;
use chatter_work::numbers::Digits;
use chatter_work::simulation::{
    Followed, Record, Request, Rows, SampleOption, Subject, follow, picture, sentence, start_time,
};
use chatter_work::source::Loaded;
use chatter_work::{Refusal, options};
use serde_json::{Value, json};

/// A page shows no more impacts, and no shorter parts of what is shown.
const MOST_IMPACTS: u64 = 200_000;
const RESOLUTION: f64 = 2e-4;
/// Contacts whose gaps and rates are told beside the states.
const MOST_CONTACTS: usize = 8;

/// A motion that can be followed.
pub(super) struct Asked {
    pub loaded: Loaded,
    spec: Spec,
    pub window: Option<(f64, f64)>,
    duration: DoubleDouble,
    time_was_given: bool,
}

pub(super) fn asked(answering: &Answering, question: &HistoryQuestion) -> Result<Asked, Refusal> {
    let mut loaded = question.model.load(&answering.context.files)?;
    let (until, window) = question.times()?;
    let time_was_given = until.is_some();
    let request = Request {
        until,
        impacts: Some(options::Count(MOST_IMPACTS)),
        ..Request::default()
    };
    let mut spec = request.spec(&mut loaded.model)?;
    if !time_was_given {
        // The limit of impacts is that of the page: it does not wait for them.
        spec.until = start_time(&loaded.model) + DoubleDouble::from(Request::USUAL_TIME);
    }
    let window = match window {
        Some(window) => Some(window.values(&mut loaded.model, "--window")?),
        None => None,
    };
    let duration = spec.until - start_time(&loaded.model);
    Ok(Asked {
        loaded,
        spec,
        window,
        duration,
        time_was_given,
    })
}

impl Asked {
    pub fn subject<'a>(&'a self, question: &'a HistoryQuestion) -> Subject<'a> {
        Subject {
            model: &self.loaded.model,
            spec: &self.spec,
            source: &question.model.name,
            text: &self.loaded.text,
            data_files: &self.loaded.data_files,
            digits: Digits::DOUBLE,
            time_was_given: self.time_was_given,
        }
    }
}

/// The motion: a document that says which columns follow, and these.
pub fn answer(answering: &Answering, question: &HistoryQuestion) -> Result<(), Refusal> {
    let mut asked = asked(answering, question)?;
    let shown = match asked.window {
        Some((from, to)) => DoubleDouble::from(to - from),
        None => asked.duration,
    };
    asked.spec.sampling = vec![Sampling::Smooth {
        resolution: shown * DoubleDouble::from(RESOLUTION),
        window: asked.window.map(|(from, to)| (from.into(), to.into())),
    }];
    let subject = asked.subject(question);
    let Followed {
        mut simulation,
        record,
        ..
    } = follow::<f64>(&subject, &Rows::None, answering)?;
    if simulation.outcome == Outcome::Interrupted {
        return Err(Refusal::Interrupted);
    }
    let samples = simulation.samples.pop().unwrap_or_else(|| Samples {
        times: Vec::new(),
        states: vec![Vec::new(); subject.model.states.len()],
        closed: Vec::new(),
    });
    let told = Told::new(&subject, &simulation, &record, &samples, asked.window)?;
    answering.document(&told.document)?;
    told.columns
        .iter()
        .try_for_each(|column| answering.numbers(Kind::Numbers, column))
}

/// An answer.
struct Told {
    document: Value,
    columns: Vec<Vec<f64>>,
}

impl Told {
    fn new(
        subject: &Subject,
        simulation: &Simulation<f64>,
        record: &Record<f64>,
        samples: &Samples<f64>,
        window: Option<(f64, f64)>,
    ) -> Result<Self, Refusal> {
        let model = subject.model;
        let mut names = vec!["time".to_owned()];
        let mut columns = vec![samples.times.clone()];
        for index in subject.states() {
            names.push(model.states[index].name.clone());
            columns.push(samples.states[index].clone());
        }
        let derived = Derived::new(model);
        for (name, expr) in &derived.quantities {
            names.push(name.clone());
            columns.push(along(&derived.graph, *expr, model, samples));
        }
        let mut places: Vec<String> = Vec::new();
        let mut events: Vec<Vec<f64>> = vec![Vec::new(); 5 + names.len() - 1];
        let parameters = model.parameter_values::<f64>(&[]);
        for noted in record.events() {
            let event = noted?.event;
            if window.is_some_and(|(from, to)| !(from..=to).contains(&event.time)) {
                continue;
            }
            let place = subject.place(&event.detail);
            let known = places.iter().position(|known| known == place);
            let place = known.unwrap_or_else(|| {
                places.push(place.to_owned());
                places.len() - 1
            });
            let kind = EventKind::ALL.iter().position(|kind| *kind == event.kind);
            let [before, after] = chatter_work::simulation::rates(&event);
            let of_event = [
                event.time,
                kind.unwrap_or_default() as f64,
                place as f64,
                before,
                after,
            ];
            let states = subject.states().map(|index| event.state[index]);
            let quantities = derived.quantities.iter();
            let values = quantities
                .map(|(_, expr)| derived.graph.evaluate(*expr, &event.state, &parameters));
            let all = of_event.into_iter().chain(states).chain(values);
            events
                .iter_mut()
                .zip(all)
                .for_each(|(column, value)| column.push(value));
        }
        let mut phases = vec![Vec::new(); 3];
        for phase in record.contact_phases() {
            let phase = phase?;
            let end = phase.end.unwrap_or(f64::NAN);
            if window.is_some_and(|(from, to)| phase.start > to || end < from) {
                continue;
            }
            let values = [phase.contact as f64, phase.start, end];
            phases
                .iter_mut()
                .zip(values)
                .for_each(|(column, value)| column.push(value));
        }
        let kinds: Vec<&str> = EventKind::ALL.iter().map(|kind| kind.name()).collect();
        let contacts: Vec<&str> = model
            .contacts
            .iter()
            .map(|contact| &*contact.name)
            .collect();
        let message = match &simulation.outcome {
            Outcome::Failed(error) => sentence(error, model),
            Outcome::ImpactBudget => format!("stopped after {} impacts", simulation.counts.impacts),
            Outcome::Rest => "at rest for ever".to_owned(),
            _ => String::new(),
        };
        let counts = simulation.counts;
        let document = json!({
            "outcome": simulation.outcome.name(),
            "message": message,
            "start": simulation.start_time,
            "time": simulation.time,
            "state": subject.states().map(|index| simulation.state[index]).collect::<Vec<f64>>(),
            "states": names[1..=subject.states().count()],
            "quantities": names[1..],
            "columns": [names.len(), events.len(), phases.len()],
            "kinds": kinds,
            "places": places,
            "drawn": model.drawing.iter().map(|shape| shape.numbers.len()).collect::<Vec<usize>>(),
            "contacts": contacts,
            "counts": {
                "impacts": counts.impacts,
                "accumulations": counts.accumulations,
                "releases": counts.releases,
                "grazes": counts.grazes,
                "sections": counts.sections,
            },
        });
        columns.extend(events);
        columns.extend(phases);
        for shape in &model.drawing {
            let along = |expr: &Expr| along(&model.graph, *expr, model, samples);
            columns.extend(shape.numbers.iter().map(along));
        }
        Ok(Self { document, columns })
    }
}

/// What is told beside the states: gap and rate of each contact.
struct Derived {
    graph: Graph,
    quantities: Vec<(String, Expr)>,
}

impl Derived {
    fn new(model: &Model) -> Self {
        let Ok(mechanics) = Mechanics::new(model) else {
            return Self {
                graph: model.graph.clone(),
                quantities: Vec::new(),
            };
        };
        let contacts = model
            .contacts
            .iter()
            .zip(&mechanics.contacts)
            .take(MOST_CONTACTS);
        let quantities = contacts.flat_map(|(contact, derived)| {
            let name = &contact.name;
            [
                (format!("gap at {name}"), derived.gap),
                (format!("rate at {name}"), derived.rate),
            ]
        });
        Self {
            quantities: quantities.collect(),
            graph: mechanics.graph,
        }
    }
}

/// The values of an expression at samples.
fn along(graph: &Graph, expr: Expr, model: &Model, samples: &Samples<f64>) -> Vec<f64> {
    let parameters = model.parameter_values::<f64>(&[]);
    // Behind the states is time, for drawings of models that have none among them.
    let mut state = vec![0.0; samples.states.len() + 1];
    let values = (0..samples.len()).map(|place| {
        for (x, values) in state.iter_mut().zip(&samples.states) {
            *x = values[place];
        }
        state[samples.states.len()] = samples.times[place];
        graph.evaluate(expr, &state, &parameters)
    });
    values.collect()
}

/// The motion as a file.
pub fn file(
    answering: &Answering,
    question: &HistoryQuestion,
    kind: Extension,
) -> Result<(), Refusal> {
    let stem = stem(&question.model.name, "history");
    written(answering, question, (&stem, kind))
}

/// The motion as a file of this name.
pub fn written(
    answering: &Answering,
    question: &HistoryQuestion,
    (stem, kind): (&str, Extension),
) -> Result<(), Refusal> {
    let mut asked = asked(answering, question)?;
    if kind.is_picture() {
        let axes = question.panels()?;
        asked.spec.sampling = vec![picture::sampling(asked.duration, asked.window)];
        let subject = asked.subject(question);
        picture::check(&subject, &axes)?;
        let mut followed = follow::<f64>(&subject, &Rows::None, answering)?;
        let samples = followed.simulation.samples.pop();
        let samples = samples.ok_or(Refusal::Interrupted)?;
        let run = (&followed.simulation, &followed.record);
        let picture = picture::draw(&subject, run, &samples, asked.window, &axes, answering)?;
        return answering.figure(stem, kind, &picture.figure);
    }
    let sample = question.rows()?;
    let by_events = sample == SampleOption::Events;
    let sampling = sample.sampling(&mut asked.loaded.model)?;
    asked.spec.sampling = sampling.into_iter().collect();
    let subject = asked.subject(question);
    answering.tables(stem, kind, |path| {
        let rows = match by_events {
            true => Rows::Events(path),
            false => Rows::Table(path),
        };
        follow::<f64>(&subject, &rows, answering)?.write(&subject, &rows)
    })
}
