//! Which coordinates are phases, and how the time of a forcing goes on at other parameters.

use super::translations::Translations;
use crate::analysis::map::{Carry, CoordinateKind};
use crate::expressions::{Expr, Formula, Function, Graph, Node, Symbol};
use crate::model::{Model, Phase};
use std::collections::BTreeSet;

/// What the equations know of their states, the surfaces that are looked at among them.
#[derive(Clone, Debug)]
pub(super) struct Phases {
    /// Continues the model's own: holds the rates of phases.
    graph: Graph,
    phases: Vec<Phase>,
    translations: Translations,
    equations: Vec<Formula<f64>>,
    /// What stands in one sine or cosine with time, if time is no phase.
    with_time: BTreeSet<Symbol>,
}

/// Rates have changed by one factor, and equations are the same after a period, up to so much: far above what rounding
/// leaves of either, far below any change that is meant.
const SAME: f64 = 1e-9;

/// A period is looked into at so many times.
const LOOKS: u32 = 7;

impl Phases {
    pub(super) fn new(model: &Model) -> Self {
        let mut graph = model.graph.clone();
        let mut equations = model.equations();
        equations.extend(model.sections.iter().map(|section| section.surface));
        let phases = model.phases_in(&mut graph, &equations);
        Self {
            with_time: model.time.map_or_else(BTreeSet::new, |time| {
                beside(&graph, &equations, Symbol::State(time))
            }),
            equations: (equations.iter())
                .map(|&equation| Formula::new(&graph, equation))
                .collect(),
            graph,
            phases,
            translations: Translations::new(model, &equations),
        }
    }

    fn phase(&self, state: usize) -> Option<&Phase> {
        self.phases.iter().find(|phase| phase.state == state)
    }

    fn rates(&self, phase: &Phase, parameters: &[f64]) -> Vec<f64> {
        let rates = phase.rates().iter();
        rates
            .map(|&rate| self.graph.evaluate(rate, &[], parameters))
            .collect()
    }

    /// What each state is at these parameters, where a look is taken once in `look`, if that is fixed.
    pub(super) fn kinds(
        &self,
        model: &Model,
        parameters: &[f64],
        look: Option<f64>,
    ) -> Vec<CoordinateKind> {
        let initial = model.initial_state(parameters);
        let translations = self.translations.at(parameters, &initial);
        let kind = |state: usize| {
            let found = self.phase(state);
            let free = translations.iter().find(|free| free.state == state);
            if let Some(free) = free {
                CoordinateKind::Idle {
                    others: free.others.clone(),
                }
            } else if let Some(period) =
                found.and_then(|phase| phase.period(&self.graph, parameters))
            {
                CoordinateKind::Phase { period }
            } else if let Some(period) = look
                && model.time == Some(state)
                && self.repeats(model, parameters, &initial, period)
            {
                CoordinateKind::Phase { period }
            } else {
                CoordinateKind::Plain
            }
        };
        (0..model.states.len()).map(kind).collect()
    }

    /// Whether the equations are the same a period later, tried at a state.
    fn repeats(&self, model: &Model, parameters: &[f64], state: &[f64], period: f64) -> bool {
        let Some(time) = model.time else {
            return true;
        };
        let mut state = state.to_vec();
        let mut scratch = Vec::new();
        self.equations.iter().all(|equation| {
            let mut at = |turns: f64| {
                state[time] = period * turns;
                equation.evaluate(&state, parameters, &mut scratch)
            };
            let looks = (0..LOOKS).map(|look| f64::from(look) / f64::from(LOOKS));
            let pairs: Vec<(f64, f64)> = looks.map(|turns| (at(turns), at(turns + 1.0))).collect();
            let size = (pairs.iter()).fold(0.0_f64, |most, (a, b)| most.max(a.abs()).max(b.abs()));
            // Where there is no value, there is none to contradict.
            (pairs.iter()).all(|(a, b)| a.is_nan() || b.is_nan() || (a - b).abs() <= SAME * size)
        })
    }

    /// Whether time can be carried between the parameters in `values`, of which those in `moving` differ: whether there is
    /// a time at which all that depends on it is in the phase that it was in.
    pub(super) fn can_carry(
        &self,
        model: &Model,
        moving: &[usize],
        values: &[Vec<f64>],
        look: &dyn Fn(&[f64]) -> Option<f64>,
    ) -> bool {
        let Some(time) = model.time else {
            return true;
        };
        let strobed = |parameters: &Vec<f64>| {
            look(parameters).is_some_and(|period| {
                // Values without a period have no orbit that could be carried.
                !(period > 0.0 && period.is_finite())
                    || self.repeats(model, parameters, &model.initial_state(parameters), period)
            })
        };
        if values.iter().all(strobed) {
            return true;
        }
        let Some(phase) = self.phase(time) else {
            // Time goes on as it is, which is right unless a phase jumps.
            return !(moving.iter())
                .any(|&index| self.with_time.contains(&Symbol::Parameter(index)));
        };
        let [first, rest @ ..] = values else {
            return true;
        };
        let first = self.rates(phase, first);
        rest.iter().all(|parameters| {
            let rates = self.rates(phase, parameters);
            let factors = (first.iter().zip(&rates)).filter(|(a, b)| **a != 0.0 || **b != 0.0);
            let factors: Vec<f64> = factors.map(|(a, b)| b / a).collect();
            factors
                .windows(2)
                .all(|pair| (pair[0] - pair[1]).abs() <= SAME * pair[0].abs())
                && factors
                    .iter()
                    .all(|factor| factor.is_finite() && *factor != 0.0)
        })
    }

    /// A point carried to other parameters. `looks` are the times from look to look before and after, where fixed.
    pub(super) fn carried(
        &self,
        model: &Model,
        carry: &Carry<'_>,
        looks: Option<(f64, f64)>,
    ) -> Vec<f64> {
        let mut point = carry.end.to_vec();
        if let Some(time) = model.time {
            point[time] = self.time(model, time, carry, looks);
        }
        point
    }

    fn time(
        &self,
        model: &Model,
        time: usize,
        carry: &Carry<'_>,
        looks: Option<(f64, f64)>,
    ) -> f64 {
        if let Some((before, after)) = looks
            && self.repeats(model, carry.before, carry.end, before)
            && self.repeats(model, carry.after, carry.end, after)
        {
            // Whole periods after the start: in the phase of the start, without their rounding errors.
            return remainder(carry.origin[time], before) / before * after;
        }
        let end = carry.end[time];
        let Some(phase) = self.phase(time) else {
            return end;
        };
        let before = self.rates(phase, carry.before);
        let after = self.rates(phase, carry.after);
        let turning = (before.iter().zip(&after)).find(|(a, b)| **a != 0.0 && **b != 0.0);
        let factor = turning.map_or(1.0, |(before, after)| before / after);
        // In the first period, where time has most digits.
        match phase.period(&self.graph, carry.before) {
            Some(period) => remainder(end, period) * factor,
            None => end * factor,
        }
    }
}

/// What is left after whole periods, from zero to a period.
fn remainder(value: f64, period: f64) -> f64 {
    let rest = value - (value / period).floor() * period;
    if (0.0..period).contains(&rest) {
        rest
    } else {
        0.0
    }
}

/// What stands with a symbol in the argument of any one sine, cosine or tangent.
fn beside(graph: &Graph, equations: &[Expr], symbol: Symbol) -> BTreeSet<Symbol> {
    let mut found = BTreeSet::new();
    for expr in graph.reachable(equations) {
        if let Node::Call(Function::Sin | Function::Cos | Function::Tan, argument) =
            graph.node(expr)
        {
            let symbols = graph.symbols(*argument);
            if symbols.contains(&symbol) {
                found.extend(symbols);
            }
        }
    }
    found
}
