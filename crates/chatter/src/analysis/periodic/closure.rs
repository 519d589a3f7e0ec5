//! What a state must be after one period: the same, but for whole turns of its phases and for how far it has come.

use super::error::PeriodicError;
use crate::analysis::return_map::translations::{Translation, Translations};
use crate::expressions::{Expr, Graph};
use crate::model::{Model, Phase};
use crate::numerics::Real;

/// The phases of a model with their periods as functions of the free parameters, and the states that nothing depends on.
#[derive(Clone, Debug)]
pub(crate) struct Closure {
    graph: Graph,
    turning: Vec<Turning>,
    pub idle: Vec<Translation>,
    pub time: Option<usize>,
}

#[derive(Clone, Debug)]
struct Turning {
    state: usize,
    period: Period,
    /// How fast it grows, where no state changes that, and the derivatives of that.
    rate: Option<(Expr, Vec<Expr>)>,
}

#[derive(Clone, Debug)]
enum Period {
    /// That of a phase, and the derivatives of its rates by each free parameter.
    Phase(Phase, Vec<Vec<Expr>>),
    /// An expression, and its derivatives.
    Given(Expr, Vec<Expr>),
}

/// By how much a phase grows in a turn, and its derivatives by the free parameters.
#[derive(Clone, Debug)]
pub(crate) struct Turn<R> {
    pub state: usize,
    pub period: R,
    pub slopes: Vec<R>,
    /// The time that a turn takes, and its derivatives, where no state changes that.
    pub lap: Option<Lap<R>>,
}

/// The time of a turn, and its derivatives by the free parameters.
#[derive(Clone, Debug)]
pub(crate) struct Lap<R> {
    pub time: R,
    pub slopes: Vec<R>,
}

/// How two states differ.
#[derive(Clone, Debug)]
pub(crate) struct Difference {
    /// What is left after whole turns, each state in units of its size.
    pub distance: f64,
    /// Whole turns of each phase, in the order of the closure.
    pub turns: Vec<i64>,
}

/// Whether equations are after a period what they were, as far as some states and times can tell: late ones, after all ramps.
fn repeats(
    graph: &Graph,
    equations: &[Expr],
    parameters: &[f64],
    (initial, time, period): (&[f64], usize, f64),
) -> bool {
    let place = |k: usize| {
        let part = |i: usize| libm::sin((1.0 + i as f64) * (0.7 + 1.3 * k as f64));
        let moved = initial.iter().enumerate();
        let mut state: Vec<f64> = moved
            .map(|(i, x)| x + part(i) * if *x == 0.0 { 1.0 } else { x.abs() })
            .collect();
        state[time] = (LATE + 0.381_966 * k as f64) * period;
        state
    };
    equations.iter().all(|&equation| {
        let pairs = (0..LOOKS).map(|k| {
            let mut state = place(k);
            let now = graph.evaluate(equation, &state, parameters);
            state[time] += period;
            (now, graph.evaluate(equation, &state, parameters))
        });
        let known: Vec<(f64, f64)> = pairs
            .filter(|(now, later)| now.is_finite() && later.is_finite())
            .collect();
        let size = known
            .iter()
            .fold(0.0_f64, |most, (now, _)| most.max(now.abs()));
        known
            .iter()
            .all(|(now, later)| (now - later).abs() <= REPEATED * size)
    })
}

/// So many states are looked at, from so many periods on; equations that differ by no more than this part of what they are repeat.
const LOOKS: usize = 8;
const LATE: f64 = 50.0;
const REPEATED: f64 = 1e-6;

/// Free parameters are looked at this part of their size away from the model's values, too.
const ASIDE: f64 = 1e-3;

/// A period is a multiple of another up to so much.
const SAME: f64 = 1e-9;

impl Closure {
    /// Of a model whose time has this period, if it is said, with the section at which its orbits can be told: one that repeats
    /// less often than the equations would make them longer. Sections that change nothing are no part of the motion, but where
    /// they alone say what time is, or what happens: to and fro across a section a pendulum's angle is no phase.
    pub(crate) fn with_section(
        model: &Model,
        free: &[usize],
        given: Option<Expr>,
        section: Option<usize>,
    ) -> Result<(Self, Option<usize>), PeriodicError> {
        let all: Vec<usize> = (0..model.sections.len()).collect();
        let events: Vec<usize> = (all.iter().copied())
            .filter(|&index| model.sections[index].reset.is_some())
            .collect();
        let closure = match Self::new(model, free, given, &events) {
            Err(PeriodicError::NoPeriod) => {
                return Ok((Self::new(model, free, given, &all)?, section));
            }
            found => found?,
        };
        let Some(own) = section else {
            return Ok((closure, None));
        };
        let with = Self::new(model, free, given, &[&*events, &[own]].concat());
        let parameters = model.parameter_values::<f64>(&[]);
        let fits = |other: &Self| match (closure.turns(&parameters), other.turns(&parameters)) {
            (Ok(own), Ok(other)) => {
                own.len() == other.len()
                    && (own.iter().zip(&other)).all(|(a, b): (&Turn<f64>, &Turn<f64>)| {
                        a.state == b.state && (a.period - b.period).abs() <= SAME * a.period
                    })
            }
            _ => false,
        };
        if with.as_ref().is_ok_and(fits) {
            return Ok((closure, section));
        }
        let nothing_else_happens =
            model.time.is_none() && model.contacts.is_empty() && events.is_empty();
        if nothing_else_happens {
            return Ok((with?, section));
        }
        Ok((closure, None))
    }

    fn new(
        model: &Model,
        free: &[usize],
        given: Option<Expr>,
        sections: &[usize],
    ) -> Result<Self, PeriodicError> {
        let mut graph = model.graph.clone();
        let mut equations = model.equations();
        equations.extend(sections.iter().map(|&index| model.sections[index].surface));
        let phases = model.phases_in(&mut graph, &equations);
        let parameters = model.parameter_values::<f64>(&[]);
        let initial = model.initial_state(&parameters);
        // What nothing depends on at the model's values alone, as time where a force is zero, something does as they change.
        let translations = Translations::new(model, &equations);
        let mut idle = translations.at(&parameters, &initial);
        if !idle.is_empty() && !free.is_empty() {
            let mut beside = parameters.clone();
            (free.iter()).for_each(|&index| beside[index] += ASIDE * (1.0 + beside[index].abs()));
            let there = translations.at(&beside, &initial);
            idle.retain(|known| there.iter().any(|other| other.state == known.state));
        }
        if given.is_some() && model.time.is_none() && phases.is_empty() {
            return Err(PeriodicError::Autonomous);
        }
        let slopes = |graph: &mut Graph, exprs: &[Expr]| -> Vec<Vec<Expr>> {
            let by = |&parameter| model.derivatives_by_parameter(graph, exprs, parameter);
            free.iter().map(by).collect()
        };
        let rate = |graph: &mut Graph, state: usize| {
            let rate = model.states[state].derivative;
            let steady = !graph.depends_on_state(rate);
            steady.then(|| (rate, slopes(graph, &[rate]).concat()))
        };
        let mut turning = Vec::new();
        for phase in phases {
            let is_idle = idle.iter().any(|free| free.state == phase.state);
            if is_idle {
                continue;
            }
            if let (Some(given), true) = (given, model.time == Some(phase.state)) {
                let value = graph.evaluate(given, &[], &parameters);
                if let Some(own) = phase.period(&graph, &parameters) {
                    let turns = value / own;
                    if (turns - turns.round()).abs() > SAME * turns || turns < 0.5 {
                        return Err(PeriodicError::OtherPeriod { value, own });
                    }
                }
                continue;
            }
            let rates = slopes(&mut graph, phase.rates());
            turning.push(Turning {
                rate: rate(&mut graph, phase.state),
                state: phase.state,
                period: Period::Phase(phase, rates),
            });
        }
        if let (Some(time), Some(period)) = (model.time, given) {
            let value = graph.evaluate(period, &[], &parameters);
            if !repeats(&graph, &equations, &parameters, (&initial, time, value)) {
                return Err(PeriodicError::NoRepeat { value });
            }
            let by = slopes(&mut graph, &[period]);
            turning.push(Turning {
                rate: rate(&mut graph, time),
                state: time,
                period: Period::Given(period, by.into_iter().map(|by| by[0]).collect()),
            });
        }
        let known = |time: usize| turning.iter().any(|turning| turning.state == time);
        // A section may be all that says what time is.
        let asks_all = sections.len() == model.sections.len();
        let is_idle = |time: usize| asks_all && idle.iter().any(|free| free.state == time);
        if (model.time).is_some_and(|time| !known(time) && !is_idle(time)) {
            return Err(PeriodicError::NoPeriod);
        }
        Ok(Self {
            graph,
            turning,
            idle,
            time: model.time,
        })
    }

    /// Leaves free some states more that nothing depends on between events. A phase among them, as a count that enters by its remainder, is
    /// to come back shifted by whole turns all the same.
    pub(crate) fn frees(&mut self, states: Vec<usize>) {
        for state in states {
            if !self.is_idle(state) {
                let others = Vec::new();
                self.idle.push(Translation { state, others });
            }
        }
    }

    /// The periods at a parameter set.
    pub(crate) fn turns<R: Real>(&self, parameters: &[R]) -> Result<Vec<Turn<R>>, PeriodicError> {
        let at = |expr: Expr| self.graph.evaluate(expr, &[], parameters);
        let turn = |turning: &Turning| {
            let (period, slopes): (R, Vec<R>) = match &turning.period {
                Period::Phase(phase, slopes) => {
                    let period = phase.period(&self.graph, parameters)?;
                    let slope = |by: &Vec<Expr>| {
                        (phase.rates().iter().zip(by))
                            .map(|(&rate, &slope)| (at(rate), at(slope)))
                            .find(|(rate, _)| *rate != R::ZERO)
                            .map_or(R::ZERO, |(rate, slope)| -period * slope / rate)
                    };
                    (period, slopes.iter().map(slope).collect())
                }
                Period::Given(period, slopes) => {
                    (at(*period), slopes.iter().map(|&slope| at(slope)).collect())
                }
            };
            let lap = turning.rate.as_ref().and_then(|(rate, by)| {
                let rate = at(*rate);
                let time = (period / rate).abs();
                let slope = |(&slope, &by): (&R, &Expr)| time * (slope / period - at(by) / rate);
                (rate != R::ZERO).then(|| Lap {
                    time,
                    slopes: slopes.iter().zip(by).map(slope).collect(),
                })
            });
            let positive = period > R::ZERO && period.is_finite();
            positive.then_some(Turn {
                state: turning.state,
                period,
                slopes,
                lap,
            })
        };
        let found: Option<Vec<_>> = self.turning.iter().map(turn).collect();
        found.ok_or(PeriodicError::NoPeriod)
    }

    /// The period of the forcing: that of time, else that of a phase that turns by itself.
    pub(crate) fn forcing(&self, parameters: &[f64]) -> Option<f64> {
        let turns = self.turns(parameters).ok()?;
        let of_time = turns.iter().find(|turn| Some(turn.state) == self.time);
        let lap = |turn: &Turn<f64>| Some(turn.lap.as_ref()?.time);
        of_time.and_then(lap).or_else(|| turns.iter().find_map(lap))
    }

    /// The time that whole turns of phases take, and its derivatives by the free parameters: that of the first phase which
    /// turns by itself.
    pub(crate) fn time_of<R: Real>(turns: &[Turn<R>], counts: &[i64]) -> Option<Lap<R>> {
        turns.iter().zip(counts).find_map(|(turn, &count)| {
            let lap = turn.lap.as_ref().filter(|_| count != 0)?;
            let times = R::splat(count.unsigned_abs() as f64);
            Some(Lap {
                time: lap.time * times,
                slopes: lap.slopes.iter().map(|&slope| slope * times).collect(),
            })
        })
    }

    /// How `after` differs from `before`.
    pub(crate) fn difference(
        &self,
        turns: &[Turn<f64>],
        states: (&[f64], &[f64]),
        sizes: &[f64],
    ) -> Difference {
        self.apart(turns, states, sizes).1
    }

    /// The same, and by how much in each state, after whole turns.
    pub(crate) fn apart(
        &self,
        turns: &[Turn<f64>],
        (before, after): (&[f64], &[f64]),
        sizes: &[f64],
    ) -> (Vec<f64>, Difference) {
        let mut rest: Vec<f64> = after.iter().zip(before).map(|(a, b)| a - b).collect();
        for free in &self.idle {
            for &(other, times) in &free.others {
                rest[other] -= times * rest[free.state];
            }
        }
        for free in self.idle.iter().filter(|free| !self.is_phase(free.state)) {
            rest[free.state] = 0.0;
        }
        let mut counts = Vec::with_capacity(turns.len());
        for turn in turns {
            let count = (rest[turn.state] / turn.period).round();
            rest[turn.state] -= count * turn.period;
            counts.push(count as i64);
        }
        let distance =
            (rest.iter().zip(sizes)).fold(0.0_f64, |most, (x, size)| most.max(x.abs() / size));
        let difference = Difference {
            distance,
            turns: counts,
        };
        (rest, difference)
    }

    /// A state so many turns of each phase later.
    pub(crate) fn later<R: Real>(turns: &[Turn<R>], counts: &[i64], state: &[f64]) -> Vec<f64> {
        let mut state = state.to_vec();
        for (turn, &times) in turns.iter().zip(counts) {
            state[turn.state] += turn.period.to_f64() * times as f64;
        }
        state
    }

    /// Whether two orbits share one of the states that they are known by.
    pub(crate) fn share(
        &self,
        turns: &[Turn<f64>],
        (one, other): (&[Vec<f64>], &[Vec<f64>]),
        sizes: &[f64],
        near: f64,
    ) -> bool {
        let is_near =
            |a: &Vec<f64>, b: &Vec<f64>| self.difference(turns, (a, b), sizes).distance < near;
        one.iter().any(|a| other.iter().any(|b| is_near(a, b)))
    }

    /// Whether a state is a phase, which comes back shifted by whole turns.
    pub(crate) fn is_phase(&self, state: usize) -> bool {
        self.turning.iter().any(|turning| turning.state == state)
    }

    /// The displacement of a state as one of the orbit, as a sum of displacements of states: less what translations take along.
    pub(crate) fn displacement(&self, state: usize) -> Vec<(usize, f64)> {
        let taken = self.idle.iter().flat_map(|free| {
            let along = free.others.iter().filter(|(other, _)| *other == state);
            along.map(|&(_, times)| (free.state, -times))
        });
        core::iter::once((state, 1.0)).chain(taken).collect()
    }

    /// States that a displacement of which is no displacement of the orbit.
    pub(crate) fn is_idle(&self, state: usize) -> bool {
        self.idle.iter().any(|free| free.state == state)
    }

    /// Whether a displacement of the model that is none of the orbit moves a state.
    pub(crate) fn is_carried(&self, state: usize) -> bool {
        let others = |free: &Translation| free.others.iter().any(|&(other, _)| other == state);
        (self.idle.iter()).any(|free| free.state == state || others(free))
    }
}
