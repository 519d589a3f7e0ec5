//! The orbits of a model over the windows near a border, and those that the one-dimensional map predicts: an analysis with
//! a table of its own, and what the figure is drawn from.

use super::Subject;
use super::refused::refused;
use crate::observer::Observer;
use crate::parallel;
use crate::refusal::Refusal;
use chatter::analysis::border::{
    Border, BorderSpec, PredictedWindow, Prediction, Simulator, WindowComparison,
};
use chatter::numerics::Real;
use chatter_files::tables::{Dataset, Table};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Values of the parameter.
pub const COLUMNS: usize = 500;
/// Passages left out and kept for each value.
const TRANSIENT: usize = 150;
const KEPT: usize = 100;
/// Predicted passages of which the edges are told: extremes of few passages would be chance.
const KEPT_FOR_EDGES: usize = 4000;
/// Room beyond the outermost windows, as a part of what they span.
const ROOM: f64 = 0.04;

/// Orbits over the same values of the parameter, told by their states after the first impact.
#[derive(Clone, Debug, PartialEq)]
pub struct Overlay {
    /// The first and the last value of the parameter.
    pub range: (f64, f64),
    /// The predicted windows.
    pub windows: Vec<PredictedWindow>,
    /// The state that is drawn, by its place: the first that is no phase.
    pub coordinate: usize,
    /// What the model does.
    pub simulated: Orbits,
    /// What the one-dimensional map predicts.
    pub predicted: Orbits,
    /// For each value of the parameter it, and the lowest and the highest of many predicted places.
    pub edges: Vec<(f64, f64, f64)>,
}

/// Passages of orbits: of each the parameter, the state after its first impact, and the coordinate less that for z = 0 at
/// that parameter, which does not depend on the passage before.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Orbits {
    /// The parameter.
    pub parameter: Vec<f64>,
    /// The states.
    pub states: Vec<Vec<f64>>,
    /// The coordinate, straightened.
    pub straight: Vec<f64>,
}

impl Orbits {
    fn extend(&mut self, other: Self) {
        self.parameter.extend(other.parameter);
        self.states.extend(other.states);
        self.straight.extend(other.straight);
    }

    fn truncate(&mut self, count: usize) {
        self.parameter.truncate(count);
        self.states.truncate(count);
        self.straight.truncate(count);
    }

    /// Places in the figure.
    pub fn points(&self) -> impl Iterator<Item = (f64, f64)> {
        (self.parameter.iter().copied()).zip(self.straight.iter().copied())
    }
}

/// Follows both over the windows that were asked for.
///
/// # Errors
/// The border has no prediction, or the observer stopped the work.
pub fn overlay<R: Real>(
    subject: &Subject,
    (spec, border, compared): (&BorderSpec, &Border<R>, &[WindowComparison]),
    observer: &dyn Observer,
) -> Result<Overlay, Refusal> {
    let prediction = Prediction::exact(border).map_err(refused)?;
    let simulator = Simulator::new(subject.model, spec, border).map_err(refused)?;
    let (first, last) = subject.laps(border);
    let coordinate = coordinate(border);
    let (low, high) = span(&prediction, (first, last), compared);
    let orbits = |parameter: f64, states: Vec<Vec<f64>>| {
        let distance = parameter - prediction.border;
        let zero = prediction.states.at(0.0, distance)[coordinate];
        Orbits {
            parameter: vec![parameter; states.len()],
            straight: states
                .iter()
                .map(|state| state[coordinate] - zero)
                .collect(),
            states,
        }
    };
    let values: Vec<f64> = (0..COLUMNS)
        .map(|column| low + (high - low) * column as f64 / (COLUMNS - 1) as f64)
        .collect();
    let done = AtomicUsize::new(0);
    let columns = parallel::each(&values, observer.stop(), |&parameter| {
        let orbit = simulator.orbit(parameter, TRANSIENT, KEPT);
        let passages = orbit.map_or_else(|_| Vec::new(), |orbit| orbit.passages);
        let states = passages.into_iter().map(|passage| passage.state);
        let simulated = orbits(parameter, states.collect());
        let passages = prediction.orbit(parameter, TRANSIENT, KEPT_FOR_EDGES);
        let states = (passages.iter()).map(|passage| prediction.state(parameter, passage));
        let mut predicted = orbits(parameter, states.collect());
        let places = predicted.straight.iter();
        let (low, high) = places.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &y| {
            (low.min(y), high.max(y))
        });
        predicted.truncate(KEPT);
        let part = (done.fetch_add(1, Ordering::Relaxed) + 1) as f64 / COLUMNS as f64;
        observer.progress(part, &|| "orbits".to_owned());
        Ok((simulated, predicted, (parameter, low, high)))
    })?;
    let (mut simulated, mut predicted) = (Orbits::default(), Orbits::default());
    let mut edges = Vec::new();
    for (ours, theirs, edge) in columns {
        simulated.extend(ours);
        predicted.extend(theirs);
        edges.push(edge);
    }
    if simulated.parameter.is_empty() {
        observer.remark("no orbit of the model stays near the border over these windows");
    }
    Ok(Overlay {
        range: (low, high),
        windows: (first..=last).map(|lap| prediction.window(lap)).collect(),
        coordinate,
        simulated,
        predicted,
        edges,
    })
}

/// From where to where the windows reach, with room.
fn span(
    prediction: &Prediction,
    (first, last): (i64, i64),
    compared: &[WindowComparison],
) -> (f64, f64) {
    // Far from the border an orbit is born at a fold or at its graze; the next lap begins where this one's graze is not.
    let ends = |window: PredictedWindow| {
        let begins = window.fold.unwrap_or(window.grazing);
        let doubles = window.period_doubling.unwrap_or(window.grazing);
        [begins, window.superstable, doubles].map(|point| point.parameter)
    };
    let predicted = [first, last].map(|lap| ends(prediction.window(lap)));
    let located = compared.iter().filter(|window| {
        let lap = window.predicted.lap;
        lap == first || lap == last
    });
    let located = located.flat_map(|window| [window.located.fold, window.located.period_doubling]);
    let all = || {
        let located = located.clone().flatten().map(|point| point.value);
        predicted.into_iter().flatten().chain(located)
    };
    let low = all().fold(f64::INFINITY, f64::min);
    let high = all().fold(f64::NEG_INFINITY, f64::max);
    let room = ROOM * (high - low);
    (low - room, high + room)
}

/// The coordinate after the first impact that is no phase; else the first.
fn coordinate<R: Real>(border: &Border<R>) -> usize {
    let is_phase = |i: usize| border.turns.iter().any(|turn| turn.state == i);
    let coordinates = || border.section.iter().copied();
    coordinates()
        .find(|&i| !is_phase(i))
        .or_else(|| coordinates().next())
        .unwrap_or(0)
}

/// What `origin` says of a row.
const ORIGINS: [&str; 2] = ["simulated", "predicted"];

impl Overlay {
    /// One table: `origin`, `simulated` or `predicted`; the parameter; the states after the first impact; and
    /// `straightened`, what the figure shows.
    pub fn dataset(&self, subject: &Subject) -> Dataset {
        let both = [&self.simulated, &self.predicted];
        let numbers = |of: &dyn Fn(&Orbits) -> Vec<f64>| -> Vec<f64> {
            both.iter().flat_map(|orbits| of(orbits)).collect()
        };
        let origins = ORIGINS.iter().zip(both);
        let origins: Vec<String> = origins
            .flat_map(|(name, orbits)| vec![(*name).to_owned(); orbits.parameter.len()])
            .collect();
        let mut table = Table::new("orbits").column("origin", origins).column(
            subject.parameter,
            numbers(&|orbits| orbits.parameter.clone()),
        );
        for (place, state) in subject.model.states.iter().enumerate() {
            let of = |orbits: &Orbits| orbits.states.iter().map(|state| state[place]).collect();
            table = table.column(state.name.as_str(), numbers(&of));
        }
        let straight = numbers(&|orbits| orbits.straight.clone());
        Dataset::new().table(table.column("straightened", straight))
    }
}
