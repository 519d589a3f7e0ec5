//! States that the equations know only up to whole periods: the time of a periodic forcing, the angle of a cam.

mod sensitivity;

use super::Model;
use crate::expressions::{Expr, Folding, Function, Graph, Node, Symbol};
use crate::numerics::{DoubleDouble, Real};

/// A state that enters vector field, gaps, impulses and restitutions through trigonometric functions only, of arguments
/// that grow with it at rates that no state changes. A shift by a whole number of all their periods leaves the equations
/// as they are.
#[derive(Clone, Debug, PartialEq)]
pub struct Phase {
    /// Place of the state.
    pub state: usize,
    /// How fast each of the arguments grows with the state.
    rates: Vec<Expr>,
}

/// Two rates have a common period if their ratio is a fraction with a denominator up to this, …
const LARGEST_DENOMINATOR: i64 = 1000;

/// … to so many roundoffs.
const SAME_RATIO: f64 = 64.0 * f64::EPSILON;

impl Phase {
    /// How fast each argument grows with the state.
    pub fn rates(&self) -> &[Expr] {
        &self.rates
    }

    /// The shortest time in which all arguments grow by whole turns; `None` if there is none at these parameters: rates
    /// without a common measure, or all zero.
    pub fn period<R: Real>(&self, graph: &Graph, parameters: &[R]) -> Option<R> {
        let rates: Vec<R> = (self.rates.iter())
            .map(|&rate| graph.evaluate(rate, &[], parameters))
            .filter(|&rate| rate != R::ZERO)
            .collect();
        let first = *rates.first()?;
        // All rates in units of the first: numerators over one denominator.
        let mut numerators: Vec<i64> = Vec::new();
        let mut denominator = 1;
        for &rate in &rates {
            let (over, under) = fraction((rate / first).to_f64().abs())?;
            let common = denominator / greatest_common_divisor(denominator, under) * under;
            for numerator in &mut numerators {
                *numerator *= common / denominator;
            }
            numerators.push(over * (common / under));
            denominator = common;
            if denominator > LARGEST_DENOMINATOR {
                return None;
            }
        }
        let measure = numerators.into_iter().fold(0, greatest_common_divisor);
        let turn = R::from_double_double(DoubleDouble::PI) * R::splat(2.0);
        Some(turn / first.abs() * R::splat(denominator as f64) / R::splat(measure as f64))
    }
}

/// The simplest fraction equal to a positive number, by its continued fraction.
fn fraction(value: f64) -> Option<(i64, i64)> {
    let (mut before, mut now) = ((0, 1), (1, 0));
    let mut rest = value;
    loop {
        let whole = rest.floor();
        if whole.is_nan() || whole > (LARGEST_DENOMINATOR * LARGEST_DENOMINATOR) as f64 {
            return None;
        }
        let next = (
            whole as i64 * now.0 + before.0,
            whole as i64 * now.1 + before.1,
        );
        if next.1 > LARGEST_DENOMINATOR {
            return None;
        }
        (before, now) = (now, next);
        if (now.0 as f64 / now.1 as f64 - value).abs() <= SAME_RATIO * value {
            return Some(now);
        }
        rest = 1.0 / (rest - whole);
    }
}

pub(crate) fn greatest_common_divisor(a: i64, b: i64) -> i64 {
    if b == 0 {
        a
    } else {
        greatest_common_divisor(b, a % b)
    }
}

/// How an expression changes when a state grows by a period.
#[derive(Clone, Copy, PartialEq)]
enum Change {
    /// Not at all, since the state does not occur.
    Free,
    /// Not at all, since the state is inside periodic functions.
    Periodic,
    /// By this rate times the period.
    Drift(Expr),
    /// On average so, in steps: a multiple of the whole part of what grows by the second rate.
    Stairs(Expr, Expr),
    /// In some other way.
    Other,
}

impl Model {
    /// The states of which the equations have only the phase, with their rates in `graph`, which continues the model's
    /// own.
    pub fn phases(&self, graph: &mut Graph) -> Vec<Phase> {
        self.phases_in(graph, &self.equations())
    }

    /// The states of which these expressions have only the phase, with their rates in `graph`, which continues the
    /// model's own.
    pub fn phases_in(&self, graph: &mut Graph, equations: &[Expr]) -> Vec<Phase> {
        (0..self.states.len())
            .filter_map(|state| phase(graph, equations, state))
            .collect()
    }

    /// Whatever moves the state: vector field, impulses, gaps and restitutions. Of resets what they change: a state that
    /// stays as it is moves nothing.
    pub fn equations(&self) -> Vec<Expr> {
        let stays = |&(state, &after): &(usize, &Expr)| matches!(self.graph.node(after), Node::Symbol(Symbol::State(own)) if *own == state);
        let changed = |reset: &[Expr]| -> Vec<Expr> {
            let all = reset.iter().enumerate();
            // A state that a reset adds to is moved as it was: what is added counts.
            let added = |(state, &after): (usize, &Expr)| match self.graph.node(after) {
                Node::Sum(terms) => {
                    let is_own = |term: &Expr| matches!(self.graph.node(*term), Node::Symbol(Symbol::State(own)) if *own == state);
                    let adds = terms.iter().any(is_own);
                    // What is kept below a turn comes back as a whole.
                    let wraps = terms.iter().any(|&term| self.is_whole(term));
                    let rest = terms.iter().copied().filter(|term| !is_own(term));
                    if adds && !wraps {
                        rest.collect()
                    } else {
                        vec![after]
                    }
                }
                _ => vec![after],
            };
            all.filter(|one| !stays(one)).flat_map(added).collect()
        };
        let contacts = self.contacts.iter();
        (self.field().into_iter())
            .chain(contacts.flat_map(|contact| {
                let friction = contact.friction.iter().flat_map(|friction| {
                    let along = friction.along.iter().copied();
                    along.chain([friction.coefficient, friction.rate])
                });
                let after = contact.reset.as_deref().map(changed).unwrap_or_default();
                let impulse = contact.impulse.iter().copied().chain(after);
                (impulse.chain(friction)).chain([contact.gap, contact.restitution])
            }))
            .chain(self.sections.iter().flat_map(|section| {
                let after = section.reset.as_deref().map(changed).unwrap_or_default();
                (after.into_iter()).chain(section.reset.as_ref().map(|_| section.surface))
            }))
            .collect()
    }
}

impl Model {
    /// Whether this is a multiple of a whole part.
    fn is_whole(&self, expr: Expr) -> bool {
        match self.graph.node(expr) {
            Node::Floor(_) => true,
            Node::Product(factors) => factors.iter().any(|&factor| self.is_whole(factor)),
            _ => false,
        }
    }
}

fn phase(graph: &mut Graph, equations: &[Expr], state: usize) -> Option<Phase> {
    let mut changes = vec![Change::Free; graph.len()];
    let mut rates: Vec<Expr> = Vec::new();
    for expr in graph.reachable(equations) {
        changes[expr.index()] = match graph.node(expr).clone() {
            Node::Number(_) | Node::Pi => Change::Free,
            Node::Symbol(symbol) if symbol == Symbol::State(state) => {
                Change::Drift(graph.number(1.0))
            }
            Node::Symbol(_) => Change::Free,
            Node::Sum(terms) => sum(graph, &terms, &changes, &mut rates),
            Node::Product(factors) => product(graph, &factors, &changes),
            Node::Power(base, exponent) => bounded(&[base, exponent], &changes),
            Node::Call(Function::Sin | Function::Cos | Function::Tan, argument) => {
                match changes[argument.index()] {
                    Change::Drift(rate) => {
                        rates.push(rate);
                        Change::Periodic
                    }
                    change => change,
                }
            }
            Node::Curve(id, argument, _) => {
                match (changes[argument.index()], graph.curve(id).period()) {
                    (Change::Drift(rate), Some(period)) => {
                        // As a sine whose argument turns once while the curve's goes through its period.
                        let (two, pi) = (graph.number(2.0), graph.pi());
                        let period = graph.number_exact(period);
                        let turns = graph.div(rate, period);
                        rates.push(graph.product(&[two, pi, turns]));
                        Change::Periodic
                    }
                    _ => bounded(&[argument], &changes),
                }
            }
            Node::Floor(argument) => match changes[argument.index()] {
                Change::Drift(rate) => Change::Stairs(rate, rate),
                _ => bounded(&[argument], &changes),
            },
            Node::Call(_, argument) => bounded(&[argument], &changes),
            Node::Switch {
                surface,
                above,
                below,
                ..
            } => bounded(&[surface, above, below], &changes),
        };
    }
    let change = |equation: &Expr| changes[equation.index()];
    let returns = equations
        .iter()
        .all(|equation| matches!(change(equation), Change::Free | Change::Periodic));
    (returns && !rates.is_empty()).then_some(Phase { state, rates })
}

fn sum(graph: &mut Graph, terms: &[Expr], changes: &[Change], rates: &mut Vec<Expr>) -> Change {
    let mut drift = Vec::new();
    let mut stairs = Vec::new();
    let mut change = Change::Free;
    for term in terms {
        match changes[term.index()] {
            Change::Free => {}
            Change::Periodic => change = Change::Periodic,
            Change::Drift(rate) => drift.push(rate),
            Change::Stairs(rate, of) => {
                drift.push(rate);
                stairs.push(of);
            }
            Change::Other => return Change::Other,
        }
    }
    if drift.is_empty() {
        return change;
    }
    // Rates are of what has a value.
    let before = graph.set_folding(Folding::Continued);
    let total = graph.sum(&drift);
    graph.set_folding(before);
    if stairs.is_empty() {
        return Change::Drift(total);
    }
    // x - m floor(x/m) comes back where x/m grows by one, as a sine whose argument turns once.
    if total != graph.number(0.0) {
        return Change::Other;
    }
    for of in stairs {
        let (two, pi) = (graph.number(2.0), graph.pi());
        rates.push(graph.product(&[two, pi, of]));
    }
    Change::Periodic
}

fn product(graph: &mut Graph, factors: &[Expr], changes: &[Change]) -> Change {
    let drifts = |factor: &Expr| {
        matches!(
            changes[factor.index()],
            Change::Drift(_) | Change::Stairs(..)
        )
    };
    if !factors.iter().any(drifts) {
        return bounded(factors, changes);
    }
    let mut rate = Vec::new();
    let mut drifting = 0;
    let mut stairs = None;
    for &factor in factors {
        match changes[factor.index()] {
            Change::Drift(by) => {
                drifting += 1;
                rate.push(by);
            }
            Change::Stairs(by, of) => {
                drifting += 1;
                rate.push(by);
                stairs = Some(of);
            }
            Change::Free if !graph.depends_on_state(factor) => rate.push(factor),
            _ => return Change::Other,
        }
    }
    if drifting != 1 {
        return Change::Other;
    }
    let before = graph.set_folding(Folding::Continued);
    let rate = graph.product(&rate);
    graph.set_folding(before);
    match stairs {
        Some(of) => Change::Stairs(rate, of),
        None => Change::Drift(rate),
    }
}

/// Of a function that has no period of its own.
fn bounded(operands: &[Expr], changes: &[Change]) -> Change {
    let mut change = Change::Free;
    for operand in operands {
        match changes[operand.index()] {
            Change::Free => {}
            Change::Periodic => change = Change::Periodic,
            Change::Drift(_) | Change::Stairs(..) | Change::Other => return Change::Other,
        }
    }
    change
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::Scalar;

    /// Phases of x' = 1, y' = the formula, with omega = 3, and their periods over a turn.
    fn periods(formula: &str) -> Vec<(String, Option<f64>)> {
        let text = format!(
            "[parameters]\nomega = 3.0\nrho = 2.0\n[flight]\nx = \"1\"\ny = \"v\"\nv = \"{formula}\"\n\
             [[contact]]\nname = \"floor\"\ngap = \"y\"\nimpulse = {{ v = 1 }}\nrestitution = \"0.5\"\n\
             [initial]\nx = 0.0\ny = 0.0\nv = 0.0\n"
        );
        let model = Model::from_toml(&text, "test").unwrap();
        let mut graph = model.graph.clone();
        let parameters = model.parameter_values::<f64>(&[]);
        let phases = model.phases(&mut graph);
        let turn = core::f64::consts::TAU;
        let period = |phase: &Phase| phase.period(&graph, &parameters).map(|p| p / turn);
        phases
            .iter()
            .map(|phase| (model.states[phase.state].name.clone(), period(phase)))
            .collect()
    }

    #[test]
    fn common_periods_of_all_arguments() {
        for (formula, expected) in [
            ("cos(omega*x + rho) - y", Some(1.0 / 3.0)),
            ("sin(2*x)*cos(3*x)^2 - y", Some(1.0)),
            ("sin(0.5*x) + sin(omega*x/4) - y", Some(4.0)),
            (
                "sin(1.5*x + exp(cos(omega*x))) - y*tan(omega*x)",
                Some(2.0 / 3.0),
            ),
            ("sin(-omega*x) + rho^y", Some(1.0 / 3.0)),
            ("sin(0.1*x) + sin(0.3*x) + sin(0.7*x)", Some(10.0)),
            ("sin(x) + sin(sqrt(rho)*x)", None),
            ("mod(x, 1) - y", Some(1.0 / core::f64::consts::TAU)),
            (
                "if(mod(x, rho) < 0.5, 1, -1)",
                Some(2.0 / core::f64::consts::TAU),
            ),
            (
                "mod(3*x, omega)*mod(x, 2)",
                Some(2.0 / core::f64::consts::TAU),
            ),
        ] {
            match &periods(formula)[..] {
                [(state, period)] => {
                    assert_eq!(state, "x", "{formula}");
                    assert_eq!(period.is_some(), expected.is_some(), "{formula}");
                    let off = period.unwrap_or(0.0) - expected.unwrap_or(0.0);
                    assert!(off.abs() < 1e-14, "{formula}: {period:?}");
                }
                other => panic!("{formula}: {other:?}"),
            }
        }
    }

    #[test]
    fn what_does_not_return_is_no_phase() {
        for formula in [
            "x - y",
            "cos(x) - x",
            "cos(x^2)",
            "cos(x*y)",
            "cos(omega)*x",
            "x*cos(x)",
            "-y",
        ] {
            assert_eq!(periods(formula), [], "{formula}");
        }
    }

    #[test]
    fn a_shift_by_the_period_changes_nothing() {
        let text = include_str!("../../../../models/cam_follower.toml");
        let model = Model::from_toml(text, "cam").unwrap();
        let mut graph = model.graph.clone();
        let phases = model.phases(&mut graph);
        assert_eq!(phases.len(), 1);
        let parameters = model.parameter_values::<DoubleDouble>(&[]);
        let period = phases[0].period(&graph, &parameters).unwrap();
        let at = |angle: DoubleDouble| {
            let state = [DoubleDouble::ONE, DoubleDouble::ONE, angle];
            graph.evaluate(model.contacts[0].gap, &state, &parameters)
        };
        let angle = DoubleDouble::from(0.7);
        let off = (at(angle) - at(angle + period)).abs().to_f64();
        assert!(off < 1e-30, "{off}");
    }
}
