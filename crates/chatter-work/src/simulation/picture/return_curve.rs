//! The curve that a return map of one dimension is: that of a system of two states that is not forced, where what is looked at
//! holds one of them.

use super::side::Quantity;
use super::wanted::{At, Axes, Shows, panels};
use super::{Record, Subject};
use crate::diagram::{Ready, produce_rows};
use crate::observer::Observer;
use crate::options::{Assignment, SweepOption};
use crate::refusal::Refusal;
use crate::source::set_initial;
use chatter::analysis::diagram::{Row, Spec, Threads};
use chatter::analysis::return_map::{ReturnSpec, Sampling};
use chatter::analysis::simulate::EventKind;
use chatter::expressions::{Expr, Symbol};
use chatter::flow::Place;
use chatter::model::Model;
use chatter::numerics::Real;

/// Values at which the curve is sampled.
const VALUES: u32 = 400;
/// How far it goes beyond the points that are there, as a part of their extent.
const ROOM: f64 = 0.15;
/// Digits of its ends, which are read by people.
const DIGITS: usize = 6;

/// How the curve is sampled: a sweep over initial values, of which the first return is kept.
#[derive(Clone, Debug, PartialEq)]
pub struct ReturnCurve {
    /// The state that is mapped.
    pub name: String,
    /// The other one, which starts where it is held.
    pub held: String,
    /// Its value there.
    pub level: f64,
    /// The sweep, as an option has it.
    pub sweep: String,
    /// The section at whose crossings orbits are looked at.
    pub section: Option<String>,
    /// The events at which they are looked at, without a section.
    pub kind: Option<EventKind>,
}

impl ReturnCurve {
    /// Of the return map that `axes` name, from what a run does within a window; none where it is no curve, or where there
    /// are too few points to tell its ends.
    ///
    /// # Errors
    /// The axes name nothing, or what was noted cannot be read.
    pub fn find<R: Real>(
        subject: &Subject,
        record: &Record<R>,
        window: (f64, f64),
        axes: &[Axes],
    ) -> Result<Option<Self>, Refusal> {
        match panels(subject, axes)?[..] {
            [Shows::Returns(what, at)] => {
                let states = states_at(record, at, window)?;
                Ok(Self::of(subject.model, (what, at), &states))
            }
            _ => Ok(None),
        }
    }

    /// Whether a model can have one: whether it has two states and is not forced.
    pub fn possible(model: &Model) -> bool {
        model.states.len() == 2 && model.time.is_none()
    }

    /// Of a quantity at events, from the states at them.
    pub(super) fn of(
        model: &Model,
        (what, at): (Quantity, At),
        states: &[Vec<f64>],
    ) -> Option<Self> {
        let (true, Quantity::State(free), [first, _, ..]) = (Self::possible(model), what, states)
        else {
            return None;
        };
        let surface = match (at, &model.contacts[..]) {
            (At::Section(section), _) => model.sections[section].surface,
            (At::Kind(_), [contact]) => contact.gap,
            (At::Kind(_), _) => return None,
        };
        let held = 1 - free;
        if states_in(model, surface) != [held] {
            return None;
        }
        let values = || states.iter().map(|state| state[free]);
        let low = values().fold(f64::INFINITY, f64::min);
        let high = values().fold(f64::NEG_INFINITY, f64::max);
        let room = match high > low {
            true => ROOM * (high - low),
            false if high != 0.0 => ROOM * high.abs(),
            false => 0.1,
        };
        let (name, level) = (
            &model.states[free].name,
            on_surface(model, surface, (held, first)),
        );
        let (from, to) = (readable(low - room), readable(high + room));
        let (section, kind) = match at {
            At::Section(section) => (Some(model.sections[section].name.clone()), None),
            At::Kind(kind) => (None, Some(kind)),
        };
        Some(Self {
            name: name.clone(),
            held: model.states[held].name.clone(),
            level,
            sweep: format!("initial:{name}={from}:{to}:{VALUES}"),
            section,
            kind,
        })
    }

    /// Values, and what they are mapped to, in order; NaN where nothing returns.
    ///
    /// # Errors
    /// It cannot be followed there, or the work is stopped.
    pub fn points(
        &self,
        model: &Model,
        observer: &dyn Observer,
    ) -> Result<(Vec<f64>, Vec<f64>), Refusal> {
        let mut model = model.clone();
        let level = Assignment::new(&self.held, &self.level.to_string());
        set_initial(&mut model, &[level])?;
        let sweep: SweepOption = self.sweep.parse().map_err(Refusal::Output)?;
        let spec = Spec::new(sweep.range(&mut model)?, &self.name, 0, 1);
        let at = Sampling::Event {
            kind: self.kind.unwrap_or(EventKind::Section),
            at: self.section.clone(),
        };
        let ready = Ready::new(model, &ReturnSpec::new(at), &spec)?;
        let mut points = Vec::new();
        let take = &mut |row: Row| {
            let next = row.samples.first().copied().unwrap_or(f64::NAN);
            points.push((ready.sweep.values(row.row)[0], next));
            Ok(())
        };
        // As many returns as a single run has: more threads would gain nothing.
        if !produce_rows(&ready, (Threads::new(1), take), observer)? {
            return Err(Refusal::Interrupted);
        }
        points.sort_unstable_by(|one, other| one.0.total_cmp(&other.0));
        Ok(points.into_iter().unzip())
    }
}

/// The value of a state at which a surface that depends on it alone is met, from one that is there but for rounding: what starts a
/// roundoff before the surface would meet it at once.
fn on_surface(model: &Model, surface: Expr, (held, state): (usize, &[f64])) -> f64 {
    let mut graph = model.graph.clone();
    let slope = graph.derivative(surface, Symbol::State(held));
    let parameters = model.parameter_values(&[]);
    let [value, slope] = [surface, slope].map(|expr| graph.evaluate(expr, state, &parameters));
    let level = state[held] - value / slope;
    if level.is_finite() {
        level
    } else {
        state[held]
    }
}

/// The states just after the events that are meant, within a window.
pub(super) fn states_at<R: Real>(
    record: &Record<R>,
    at: At,
    (from, to): (f64, f64),
) -> Result<Vec<Vec<f64>>, Refusal> {
    let mut states = Vec::new();
    for noted in record.events() {
        let event = noted?.event;
        let is_meant = match at {
            At::Kind(kind) => event.kind == kind,
            At::Section(section) => event.detail.place() == Some(Place::Section(section)),
        };
        if is_meant && (from..=to).contains(&event.time.to_f64()) {
            states.push(event.state.iter().map(|value| value.to_f64()).collect());
        }
    }
    Ok(states)
}

/// The states that an expression depends on.
fn states_in(model: &Model, expr: Expr) -> Vec<usize> {
    let symbols = model.graph.symbols(expr);
    let states = 0..model.states.len();
    states
        .filter(|&index| symbols.contains(&Symbol::State(index)))
        .collect()
}

/// The nearest number of a few digits.
fn readable(value: f64) -> f64 {
    let behind = DIGITS - 1;
    format!("{value:.behind$e}").parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::super::side::Quantity;
    use super::super::wanted::At;
    use super::ReturnCurve;
    use crate::observer::Silent;
    use chatter::analysis::simulate::EventKind;
    use chatter::model::Model;

    const BALL: &str = "[parameters]\nr = 0.7\n[flight]\ny = \"v\"\nv = -2\n[[contact]]\nname = \"floor\"\ngap = \"y\"\n\
         impulse = { v = 1 }\nrestitution = \"r\"\n[section.apex]\nsurface = \"v\"\ndirection = \"falling\"\n[initial]\ny = 1\nv = 0\n";

    #[test]
    fn a_ball_rises_to_a_part_of_the_height_that_it_fell_from() {
        let ball = Model::from_toml(BALL, "ball").unwrap();
        let states = [vec![1.0, 0.0], vec![0.49, 0.0], vec![0.2401, 0.0]];
        let apex = (Quantity::State(0), At::Section(0));
        let curve = ReturnCurve::of(&ball, apex, &states).unwrap();
        assert_eq!((&*curve.held, curve.level), ("v", 0.0));
        assert_eq!(curve.sweep, "initial:y=0.126115:1.11399:400");
        let (heights, next) = curve.points(&ball, &Silent::default()).unwrap();
        assert_eq!(heights.len(), 400);
        for (height, next) in heights.iter().zip(next) {
            assert!((next - 0.49 * height).abs() < 1e-14, "{height} {next}");
        }
        // Without loss it comes back to where it was.
        let mut elastic = ball.clone();
        elastic.set_parameter("r", "1").unwrap();
        let (heights, next) = curve.points(&elastic, &Silent::default()).unwrap();
        for (height, next) in heights.iter().zip(next) {
            assert!((next - height).abs() < 1e-14, "{height} {next}");
        }
        // At the floor: the speed after one impact against that after the next.
        let speeds = [vec![0.0, 1.4], vec![0.0, 0.98]];
        let impacts = (Quantity::State(1), At::Kind(EventKind::Impact));
        let curve = ReturnCurve::of(&ball, impacts, &speeds).unwrap();
        let (speeds, next) = curve.points(&ball, &Silent::default()).unwrap();
        for (speed, next) in speeds.iter().zip(next) {
            assert!((next - 0.7 * speed).abs() < 1e-14, "{speed} {next}");
        }
    }

    #[test]
    fn what_has_more_dimensions_has_no_curve() {
        let ball = Model::from_toml(BALL, "ball").unwrap();
        let states = [vec![1.0, 0.0], vec![0.49, 0.0]];
        // The section holds the velocity, not the height; and one point has no next.
        assert_eq!(
            ReturnCurve::of(&ball, (Quantity::State(1), At::Section(0)), &states),
            None
        );
        let apex = (Quantity::State(0), At::Section(0));
        assert_eq!(ReturnCurve::of(&ball, apex, &states[..1]), None);
        let forced = BALL.replace("v = -2", "v = \"-2 + cos(t)\"");
        let forced = Model::from_toml(&forced, "forced").unwrap();
        assert_eq!(ReturnCurve::of(&forced, apex, &states), None);
    }
}
