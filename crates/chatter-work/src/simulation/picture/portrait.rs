//! The phase portrait: gap against rate of the only contact, else the first two states.

use super::shown::Shown;
use super::{Subject, add_curve, axis_of};
use chatter::expressions::{Expr, Graph, Node, Symbol};
use chatter::model::Mechanics;
use chatter_figures::{Axis, Color, Legend, Marker, Markers, Panel};

const DISC: f64 = 3.2;

/// The portrait; none where there is but one state.
pub fn panel(subject: &Subject, shown: &Shown) -> Option<Panel> {
    let sides = of_contact(subject, shown).or_else(|| of_states(subject, shown))?;
    Some(portrait(shown, sides))
}

/// One state against another.
pub fn of(subject: &Subject, shown: &Shown, (x, y): (usize, usize)) -> Panel {
    let side = |index| Side::of_state(subject, shown, index);
    portrait(shown, (side(x), side(y)))
}

fn portrait(shown: &Shown, (x, y): (Side, Side)) -> Panel {
    let mut panel = Panel::new(x.axis, y.axis);
    add_curve(&mut panel, &shown.jumps, &x.values, &y.values);
    if !x.marks.is_empty() {
        let discs = Markers::new(x.marks, y.marks).marker(Marker::Disc);
        panel.add(discs.size(DISC).color(Color::INK));
    }
    panel.legend(Legend::Hidden)
}

/// One axis, what is drawn along it, and where accumulations are on it.
struct Side {
    axis: Axis,
    values: Vec<f64>,
    marks: Vec<f64>,
}

impl Side {
    fn of_state(subject: &Subject, shown: &Shown, index: usize) -> Self {
        let state = &subject.model.states[index];
        let accumulations = shown.accumulations.iter();
        Self {
            axis: axis_of(&state.name, state.label.as_ref()),
            values: shown.states[index].clone(),
            marks: accumulations.map(|(_, state)| state[index]).collect(),
        }
    }

    fn of_expression(
        subject: &Subject,
        shown: &Shown,
        graph: &Graph,
        expr: Expr,
        label: String,
    ) -> Self {
        if let Node::Symbol(Symbol::State(index)) = graph.node(expr) {
            return Self::of_state(subject, shown, *index);
        }
        let parameters = subject.model.parameter_values::<f64>(&[]);
        let value = |state: &[f64]| graph.evaluate(expr, state, &parameters);
        let mut state = vec![0.0; shown.states.len()];
        let values = (0..shown.times.len()).map(|place| {
            for (x, series) in state.iter_mut().zip(&shown.states) {
                *x = series[place];
            }
            value(&state)
        });
        let values = values.collect();
        let marks = shown.accumulations.iter().map(|(_, state)| value(state));
        Self {
            axis: Axis::new(label),
            values,
            marks: marks.collect(),
        }
    }
}

fn of_states(subject: &Subject, shown: &Shown) -> Option<(Side, Side)> {
    let mut states = subject.states();
    let (first, second) = (states.next()?, states.next()?);
    let side = |index| Side::of_state(subject, shown, index);
    Some((side(first), side(second)))
}

fn of_contact(subject: &Subject, shown: &Shown) -> Option<(Side, Side)> {
    let [contact] = subject.model.contacts.as_slice() else {
        return None;
    };
    let mechanics = Mechanics::new(subject.model).ok()?;
    let derived = mechanics.contacts.first()?;
    let side = |expr, what: &str| {
        let label = format!("{what} at {}", contact.name);
        Side::of_expression(subject, shown, &mechanics.graph, expr, label)
    };
    Some((side(derived.gap, "gap"), side(derived.rate, "gap rate")))
}
