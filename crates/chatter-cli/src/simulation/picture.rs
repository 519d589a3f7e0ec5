//! A simulation as a figure: the history of each state, and the phase portrait.

use super::Subject;
use chatter::analysis::simulate::{EventKind, Samples, Sampling, Simulation};
use chatter::expressions::{Expr, Node, Symbol};
use chatter::flow::Closed;
use chatter::model::{Label, Mechanics};
use chatter::numerics::Real;
use chatter_io::figures::{
    Axis, Color, Figure, Legend, Line, Marker, Markers, Panel, Sharing, Spans, variable,
};

/// Points a step: straight lines between them look smooth.
pub const SAMPLING: Sampling = Sampling::Dense { per_step: 24 };

/// Width of a figure with one column of panels, and with two, in millimetres.
const NARROW: f64 = 110.0;
const WIDE: f64 = 178.0;

/// Room below and above a history, as a part of its extent; ticks of impacts stand in the lower one.
const ROOM_BELOW: f64 = 0.10;
const ROOM_ABOVE: f64 = 0.06;
/// Height of a tick, as a part of the extent.
const TICK: f64 = 0.045;
/// More ticks than this are a black bar.
const MOST_TICKS: usize = 4000;
/// After the last motion of a system that has come to rest, this part of the time before is shown.
const REST_SHOWN: f64 = 0.12;

/// Bands of the contacts, in order; further ones start again.
const BANDS: [Color; 3] = [
    Color::rgb(196, 207, 222),
    Color::rgb(243, 205, 180),
    Color::rgb(190, 224, 205),
];

/// Widths of the lines of the motion, and of the jumps at impacts.
const CURVE: f64 = 0.8;
const JUMP: f64 = 0.4;

/// Draws the samples, which were taken as [`SAMPLING`] says.
pub fn draw<R: Real>(
    subject: &Subject,
    simulation: &Simulation<R>,
    samples: &Samples<R>,
) -> Figure {
    let artist = Artist::new(subject, simulation, samples);
    let states: Vec<usize> = subject.states().collect();
    let portrait = artist.portrait();
    let panels = states.len() + usize::from(portrait.is_some());
    let mut figure = Figure::new();
    for (place, &index) in states.iter().enumerate() {
        figure = figure.panel(artist.history(index, place == 0));
    }
    if let Some(portrait) = portrait {
        figure = figure.panel(portrait);
    }
    figure = if panels > 3 {
        figure.columns(2).width(WIDE)
    } else {
        figure.width(NARROW).sharing(Sharing::Nothing)
    };
    let title = subject.model.title.as_deref().unwrap_or(subject.source);
    let parameters = subject.model.parameter_values::<f64>(&[]);
    let values = subject.model.parameters.iter().zip(parameters);
    let values: Vec<String> = values
        .map(|(parameter, value)| format!("{} = {value}", parameter.name))
        .collect();
    figure.title(title).caption(format!(
        "{title} ({}) with {}, from time {} to {}. Bands: contact; ticks: impacts; discs: accumulations. Made by \
         chatter {}.",
        subject.source,
        values.join(", "),
        simulation.start_time.to_f64(),
        simulation.time.to_f64(),
        env!("CARGO_PKG_VERSION")
    ))
}

struct Artist<'a, R> {
    subject: &'a Subject<'a>,
    simulation: &'a Simulation<R>,
    samples: &'a Samples<R>,
    times: Vec<f64>,
    /// The times shown.
    shown: (f64, f64),
}

impl<'a, R: Real> Artist<'a, R> {
    fn new(subject: &'a Subject, simulation: &'a Simulation<R>, samples: &'a Samples<R>) -> Self {
        let times: Vec<f64> = samples.times.iter().map(|time| time.to_f64()).collect();
        let (start, end) = (simulation.start_time.to_f64(), simulation.time.to_f64());
        let mut artist = Self {
            subject,
            simulation,
            samples,
            times,
            shown: (start, if end > start { end } else { start + 1.0 }),
        };
        if let Some(rest) = artist.rests_from() {
            artist.shown.1 = artist.shown.1.min(rest + REST_SHOWN * (rest - start));
        }
        artist
    }

    /// When the state changed for the last time, if that is before the end and after the start.
    fn rests_from(&self) -> Option<f64> {
        if self.simulation.closed == Closed::NONE {
            return None;
        }
        let last = self.times.len().checked_sub(1)?;
        let same = |place: usize| {
            let mut states = self.subject.states();
            states.all(|index| self.samples.states[index][place] == self.simulation.state[index])
        };
        let first_same = (0..=last).rev().take_while(|&place| same(place)).last()?;
        (first_same < last && first_same > 0).then(|| self.times[first_same])
    }

    fn values(&self, index: usize) -> Vec<f64> {
        self.samples.states[index]
            .iter()
            .map(|value| value.to_f64())
            .collect()
    }

    fn events(&self, kind: EventKind) -> impl Iterator<Item = (f64, &[R])> {
        let events = self.simulation.events.iter();
        events
            .filter(move |event| event.kind() == kind)
            .map(|event| (event.time.to_f64(), event.state.as_slice()))
    }

    fn history(&self, index: usize, with_legend: bool) -> Panel {
        let values = self.values(index);
        let (low, high) = extent(&values);
        let size = if high > low {
            high - low
        } else {
            low.abs().max(1.0)
        };
        let floor = low - ROOM_BELOW * size;
        let time = Axis::new("time $t$").range(self.shown.0, self.shown.1);
        let axis = axis_of(
            &self.subject.model.states[index].name,
            self.subject.model.states[index].label.as_ref(),
        );
        let mut panel = Panel::new(time, axis.range(floor, high + ROOM_ABOVE * size));
        for (contact, described) in self.subject.model.contacts.iter().enumerate() {
            let phases = self
                .simulation
                .contact_phases
                .iter()
                .filter(|phase| phase.contact == contact);
            let end = self.shown.1;
            let intervals: Vec<(f64, f64)> = phases
                .map(|phase| (phase.start.to_f64(), phase.end.map_or(end, Real::to_f64)))
                .collect();
            if !intervals.is_empty() {
                let band = Spans::new(intervals).color(BANDS[contact % BANDS.len()]);
                panel.add(if with_legend {
                    band.label(format!("contact: {}", described.name))
                } else {
                    band
                });
            }
        }
        let impacts: Vec<f64> = self
            .events(EventKind::Impact)
            .map(|(time, _)| time)
            .collect();
        if !impacts.is_empty() && impacts.len() <= MOST_TICKS {
            let x = impacts
                .iter()
                .flat_map(|&time| [time, time, f64::NAN])
                .collect();
            let y = impacts
                .iter()
                .flat_map(|_| [floor, floor + TICK * size, f64::NAN])
                .collect();
            let ticks = Line::new(x, y).color(Color::VERMILION).width(0.5);
            panel.add(if with_legend {
                ticks.label("impact")
            } else {
                ticks
            });
        }
        self.add_curve(&mut panel, &self.times, &values);
        let accumulations = self.events(EventKind::Accumulation);
        let (x, y): (Vec<f64>, Vec<f64>) = accumulations
            .map(|(time, state)| (time, state[index].to_f64()))
            .unzip();
        if !x.is_empty() {
            let discs = Markers::new(x, y)
                .marker(Marker::Disc)
                .size(3.2)
                .color(Color::INK);
            panel.add(if with_legend {
                discs.label("accumulation")
            } else {
                discs
            });
        }
        panel.legend(if with_legend {
            Legend::Above
        } else {
            Legend::Hidden
        })
    }

    /// The motion as a curve that is broken where an impact makes the state jump, and the jumps as thin lines.
    fn add_curve(&self, panel: &mut Panel, x: &[f64], y: &[f64]) {
        let jumps: Vec<usize> = (1..self.times.len())
            .filter(|&place| self.times[place] == self.times[place - 1])
            .filter(|&place| (x[place], y[place]) != (x[place - 1], y[place - 1]))
            .collect();
        let jump_line = |side: &[f64]| {
            let ends = jumps
                .iter()
                .flat_map(|&place| [side[place - 1], side[place], f64::NAN]);
            ends.collect::<Vec<f64>>()
        };
        panel.add(
            Line::new(jump_line(x), jump_line(y))
                .color(Color::GREY)
                .width(JUMP),
        );
        let curve = |side: &[f64]| {
            let mut broken = Vec::with_capacity(side.len() + jumps.len());
            let mut from = 0;
            for &place in &jumps {
                broken.extend_from_slice(&side[from..place]);
                broken.push(f64::NAN);
                from = place;
            }
            broken.extend_from_slice(&side[from..]);
            broken
        };
        panel.add(
            Line::new(curve(x), curve(y))
                .color(Color::BLUE)
                .width(CURVE),
        );
    }

    /// Gap and rate of the only contact, else the first two states.
    fn portrait(&self) -> Option<Panel> {
        let (x, y) = self
            .portrait_of_contact()
            .or_else(|| self.portrait_of_states())?;
        let mut panel = Panel::new(x.axis, y.axis);
        self.add_curve(&mut panel, &x.values, &y.values);
        if !x.marks.is_empty() {
            panel.add(
                Markers::new(x.marks, y.marks)
                    .marker(Marker::Disc)
                    .size(3.2)
                    .color(Color::INK),
            );
        }
        Some(panel.legend(Legend::Hidden))
    }

    fn portrait_of_states(&self) -> Option<(Side, Side)> {
        let mut states = self.subject.states();
        let (first, second) = (states.next()?, states.next()?);
        let side = |index: usize| {
            let state = &self.subject.model.states[index];
            let accumulations = self.events(EventKind::Accumulation);
            Side {
                axis: axis_of(&state.name, state.label.as_ref()),
                values: self.values(index),
                marks: accumulations
                    .map(|(_, state)| state[index].to_f64())
                    .collect(),
            }
        };
        Some((side(first), side(second)))
    }

    fn portrait_of_contact(&self) -> Option<(Side, Side)> {
        let [contact] = self.subject.model.contacts.as_slice() else {
            return None;
        };
        let mechanics = Mechanics::new(self.subject.model).ok()?;
        let parameters = self.subject.model.parameter_values::<f64>(&[]);
        let side = |expr: Expr, what: &str| {
            let axis = match mechanics.graph.node(expr) {
                Node::Symbol(Symbol::State(index)) => {
                    let state = &self.subject.model.states[*index];
                    axis_of(&state.name, state.label.as_ref())
                }
                _ => Axis::new(format!("{what} at {}", contact.name)),
            };
            let value = |state: &[f64]| mechanics.graph.evaluate(expr, state, &parameters);
            let mut state = vec![0.0; self.samples.states.len()];
            let mut values = Vec::with_capacity(self.times.len());
            for place in 0..self.times.len() {
                for (x, series) in state.iter_mut().zip(&self.samples.states) {
                    *x = series[place].to_f64();
                }
                values.push(value(&state));
            }
            let accumulations = self.events(EventKind::Accumulation);
            let marks = accumulations.map(|(_, state)| {
                let state: Vec<f64> = state.iter().map(|x| x.to_f64()).collect();
                value(&state)
            });
            Side {
                axis,
                values,
                marks: marks.collect(),
            }
        };
        let derived = &mechanics.contacts[0];
        Some((side(derived.gap, "gap"), side(derived.rate, "gap rate")))
    }
}

/// One axis of the phase portrait, what is drawn along it, and where accumulations are on it.
struct Side {
    axis: Axis,
    values: Vec<f64>,
    marks: Vec<f64>,
}

fn axis_of(name: &str, label: Option<&Label>) -> Axis {
    let text = label.and_then(|label| label.text.clone());
    let axis = Axis::new(text.unwrap_or_else(|| variable(name)));
    match label.and_then(|label| label.unit.clone()) {
        Some(unit) => axis.unit(unit),
        None => axis,
    }
}

fn extent(values: &[f64]) -> (f64, f64) {
    let finite = values.iter().filter(|value| value.is_finite());
    let (low, high) = finite.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &value| {
        (low.min(value), high.max(value))
    });
    if low <= high { (low, high) } else { (0.0, 1.0) }
}
