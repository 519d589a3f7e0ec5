//! What must stay positive on the way of a leg.

use super::equations::bare;
use super::{Flyer, Leg, MOST_STEPS, left_domain, place};
use crate::expressions::{Expr, Graph, Tape};
use crate::flow::Occurrence;
use crate::flow::error::FlowError;
use crate::flow::modes::guard::GuardKind;
use crate::flow::system::System;
use crate::model::{Direction, Section};
use crate::numerics::two_sum;

/// What must stay positive on the way.
#[derive(Clone, Debug)]
pub(super) struct Watch {
    /// Stops where a guard's rate rises through zero, and at the section; none where nothing is watched.
    pub(super) system: Option<System>,
    guards: Vec<GuardKind>,
    /// How many of them: the others are asked for at the end alone.
    on_the_way: usize,
    /// The section whose crossings are told, after the guards.
    section: Option<usize>,
    /// Guards that are events, whose functions may have either sign: after all others it is told where their rates fall through
    /// zero.
    events: Vec<Event>,
    graph: Graph,
    /// All guards, and their rates.
    pub(super) values: Tape,
    pub(super) rates: Tape,
}

/// An event among the guards.
#[derive(Clone, Copy, Debug)]
struct Event {
    guard: usize,
    /// Whether it comes about on the way up, too.
    either: bool,
}

impl Event {
    /// The side of its surface that a leg begins on.
    fn side(self, value: f64, rate: f64, duration: f64) -> f64 {
        let at_zero = value.abs() <= AT_ZERO * (rate * duration).abs();
        if at_zero { rate } else { value }
    }

    /// How far an extreme is from being an event, where it comes near to one from this side. What rises above zero may fall.
    fn margin(self, side: &mut f64, value: f64, is_least: bool) -> Option<f64> {
        let above = *side > 0.0;
        if self.either || above {
            return (above == is_least).then_some(if above { value } else { -value });
        }
        if is_least {
            return None;
        }
        if value > 0.0 {
            *side = 1.0;
        }
        (value <= 0.0).then_some(-value)
    }

    /// The same at the end of a leg.
    fn at_end(self, side: f64, value: f64) -> Option<f64> {
        match (side > 0.0, self.either) {
            (true, _) => Some(value),
            (false, true) => Some(-value),
            (false, false) => None,
        }
    }
}

/// The value of an event's function that a leg begins with is zero if it is this small against what its rate makes of it on
/// the way.
const AT_ZERO: f64 = 1e-12;

/// An inner least value of a guard, or its value at the end of a leg that another guard ends; a crossing of the section that is
/// watched, with the value zero.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Least {
    pub guard: GuardKind,
    /// Since the start of the leg.
    pub time: f64,
    pub value: f64,
    /// How large the guard is on the leg, about.
    pub size: f64,
    /// The state there.
    pub state: Vec<f64>,
    /// Whether this is the end of the leg.
    pub at_end: bool,
}

/// The guard of what a leg begins with is known to this part of what it changes by on the leg.
const JUST_OPENED: f64 = 1e-9;
/// A guard that the leg begins on and whose rate turns within this part of the leg, as where a stick ends, is least where it begins.
const AT_ONCE: f64 = 1e-12;
/// So does one that falls no farther until then, by the rate that it begins with or by a jerk, than this part of what it is on the
/// leg, or would be with the rate that it ends with: contacts open with no rate and no acceleration, and rounding of these turns before
/// the jerk tells. (After an impact the gap rises, however little: that is a flight.)
const NO_WAY: f64 = 1e-12;

impl Watch {
    /// Watches the guards of a mode of the system, those that are asked for at the end alone, and a section.
    pub(super) fn new(
        system: &System,
        graph: &mut Graph,
        field: &[Expr],
        [guards, asked]: [Vec<(GuardKind, Expr)>; 2],
        section: Option<usize>,
    ) -> Self {
        let model = system.model();
        let coordinates = field.len();
        let crossed = section.and_then(|section| {
            let of = |(guard, _): &&(GuardKind, Expr)| *guard == GuardKind::Section(section);
            Some((section, guards.iter().find(of)?.1))
        });
        let mut watched: Vec<(GuardKind, Expr)> = (guards.into_iter())
            .filter(|(guard, _)| match guard {
                GuardKind::Section(index) => system.is_event(*index),
                _ => true,
            })
            .collect();
        let on_the_way = watched.len();
        watched.extend(asked);
        let rates: Vec<Expr> = (watched.iter())
            .map(|&(_, function)| graph.lie_derivative(function, field))
            .collect();
        let events: Vec<Event> = (watched.iter().enumerate())
            .filter_map(|(guard, (kind, _))| match kind {
                GuardKind::Section(index) => Some(Event {
                    guard,
                    either: model.sections[*index].direction == Direction::Either,
                }),
                _ => None,
            })
            .collect();
        let functions: Vec<Expr> = watched.iter().map(|&(_, function)| function).collect();
        let surface = |surface: Expr, direction: Direction| Section {
            name: String::new(),
            surface,
            direction,
            reset: None,
        };
        let turning = rates[..on_the_way].iter();
        let turning = turning.map(|&rate| surface(rate, Direction::Rising));
        // A guard falls where its section is crossed.
        let crossing = crossed.map(|(section, function)| {
            let direction = match model.sections[section].direction {
                Direction::Either => Direction::Either,
                Direction::Rising | Direction::Falling => Direction::Falling,
            };
            surface(function, direction)
        });
        let falling = events
            .iter()
            .map(|event| surface(rates[event.guard], Direction::Falling));
        let turning: Vec<Section> = turning.chain(crossing).chain(falling).collect();
        let stops = (!turning.is_empty())
            .then(|| System::new(&bare(model, graph, field, turning)).ok())
            .flatten()
            .map(System::past_roots);
        Self {
            system: stops,
            guards: watched.iter().map(|&(guard, _)| guard).collect(),
            on_the_way,
            section: crossed.map(|(section, _)| section),
            events,
            values: Tape::new(graph, coordinates, &[], &functions),
            rates: Tape::new(graph, coordinates, &[], &rates),
            graph: graph.clone(),
        }
    }
}

impl Leg {
    /// The inner least values of all guards on the way, in order of time, and the values at the end of those that do not
    /// end the leg; also those of any that is negative where it begins, and of what ends what is held, as though they were at its
    /// end. Guards that the leg begins on are zero there: what is left of them is rounding.
    ///
    /// # Errors
    /// As for [`fly`](Self::fly).
    pub(crate) fn least(
        &self,
        flyer: &mut Flyer<f64>,
        parameters: &[f64],
        (x, duration): (&[f64], f64),
        begins_on: &dyn Fn(GuardKind) -> bool,
    ) -> Result<Vec<Least>, FlowError> {
        let (Some(system), Some(work)) = (&self.watch.system, &mut flyer.watching) else {
            return Ok(Vec::new());
        };
        let clock = self.time.map_or(0.0, |index| x[index]);
        place(system, (&mut flyer.watcher, work), parameters, clock, x)?;
        let Some((_, trajectory)) = &mut flyer.watcher else {
            return Err(left_domain(clock, x));
        };
        trajectory.set_horizon_parts(two_sum(clock, duration));
        let constants = (flyer.at_watch)
            .constants(&self.watch.values, &self.watch.graph, parameters)
            .to_vec();
        let Watch { guards, events, .. } = &self.watch;
        let count = guards.len();
        let (mut began, mut rates) = (vec![0.0; count], vec![0.0; count]);
        let low = vec![0.0; x.len()];
        let mut found: Vec<Least> = Vec::new();
        let expansion = &mut flyer.expansion;
        expansion.evaluate_past_roots(&self.watch.values, &constants, (x, &low), &mut began);
        for (value, guard) in began.iter_mut().zip(guards) {
            if begins_on(*guard) {
                *value = 0.0;
            }
        }
        let of_rates =
            (flyer.at_watch_start).constants(&self.watch.rates, &self.watch.graph, parameters);
        expansion.evaluate_past_roots(&self.watch.rates, of_rates, (x, &low), &mut rates);
        let mut sides: Vec<f64> = (events.iter())
            .map(|event| event.side(began[event.guard], rates[event.guard], duration))
            .collect();
        let mut sizes: Vec<f64> = (began.iter().zip(&rates))
            .map(|(value, rate)| value.abs().max((rate * duration).abs()))
            .collect();
        let mut values = vec![0.0; count];
        let on_the_way = self.watch.on_the_way;
        let first_fall = on_the_way + usize::from(self.watch.section.is_some());
        for _ in 0..MOST_STEPS {
            let told = trajectory.advance_to_horizon(system, work)?;
            let Some(told) = told else { continue };
            let state = trajectory.state();
            let time = trajectory.time() - clock;
            let here = (state, &low[..]);
            expansion.evaluate_past_roots(&self.watch.values, &constants, here, &mut values);
            for (size, value) in sizes.iter_mut().zip(&values) {
                *size = size.max(value.abs());
            }
            let least = |guard: usize, value: f64, at_end: bool| Least {
                guard: guards[guard],
                time,
                value,
                size: sizes[guard],
                state: state.to_vec(),
                at_end,
            };
            let event = |guard: usize| events.iter().position(|event| event.guard == guard);
            match told {
                Occurrence::Section { section }
                    if section == on_the_way && section < first_fall =>
                {
                    found.extend(self.watch.section.map(|section| Least {
                        guard: GuardKind::Section(section),
                        time,
                        value: 0.0,
                        size: 0.0,
                        state: state.to_vec(),
                        at_end: false,
                    }));
                }
                Occurrence::Section { section } => {
                    let fall = section.checked_sub(first_fall);
                    let guard = fall.map_or(section, |place| events[place].guard);
                    if begins_on(guards[guard]) && time <= AT_ONCE * duration {
                        continue;
                    }
                    let value = match event(guard) {
                        Some(place) => {
                            let side = &mut sides[place];
                            events[place].margin(side, values[guard], fall.is_none())
                        }
                        None => Some(values[guard]),
                    };
                    found.extend(value.map(|value| least(guard, value, false)));
                }
                Occurrence::Horizon => {
                    let mut last = vec![0.0; count];
                    expansion.evaluate_past_roots(&self.watch.rates, of_rates, here, &mut last);
                    let comes_nowhere = |least: &Least| {
                        let guard = guards.iter().position(|guard| *guard == least.guard);
                        let part = least.time / duration;
                        begins_on(least.guard)
                            && part * part * part <= NO_WAY
                            && guard.is_some_and(|guard| {
                                let size = sizes[guard].max((last[guard] * duration).abs());
                                rates[guard] <= 0.0 && -rates[guard] * least.time <= NO_WAY * size
                            })
                    };
                    found.retain(|least| {
                        matches!(least.guard, GuardKind::Section(_)) || !comes_nowhere(least)
                    });
                    let ends_it = |guard: usize| Some(guards[guard]) == self.kind.ends_at;
                    let others = (0..count).filter(|&guard| !ends_it(guard));
                    let at_end = |guard: usize| match event(guard) {
                        Some(place) => events[place].at_end(sides[place], values[guard]),
                        None => Some(values[guard]),
                    };
                    found.extend(
                        others.filter_map(|guard| {
                            at_end(guard).map(|value| least(guard, value, true))
                        }),
                    );
                    let begins_beyond = |&guard: &usize| {
                        let by = match ends_it(guard) {
                            true => sizes[guard],
                            false => (values[guard] - began[guard]).abs(),
                        };
                        let holds = ends_it(guard) && !matches!(guards[guard], GuardKind::Gap(_));
                        event(guard).is_none() && (holds || began[guard] < -JUST_OPENED * by)
                    };
                    found.extend((0..on_the_way).filter(begins_beyond).map(|guard| Least {
                        time: 0.0,
                        state: x.to_vec(),
                        ..least(guard, began[guard], true)
                    }));
                    return Ok(found);
                }
                _ => {}
            }
        }
        Err(left_domain(clock, x))
    }
}
