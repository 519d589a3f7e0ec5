//! Whether the sequence of events still holds along a solution of its equations.

use super::graze::{LEAST_HEIGHT, is_told};
use crate::analysis::continuation::{Left, Problem, Station, locate};
use crate::analysis::periodic::cycle::itinerary::Passage;
use crate::analysis::periodic::shooting::Shooting;
use crate::flow::GuardKind;
use crate::flow::leg::{Jump, Least};
use crate::model::Direction;

/// The guard whose sign says that the sequence no longer holds, and its value.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Broken {
    /// The event at the end of this step is approached from the wrong side.
    Event(usize),
    /// This guard has a negative least value within this step.
    Inner(usize, GuardKind),
    /// This guard vanishes before the end of this step.
    Early(usize, GuardKind),
    /// This step begins beyond the guard that ends it: a contact that cannot stay closed, a stick that would slip at once.
    Beyond(usize, GuardKind),
    /// The event at the end of this step has passed the one before, and nothing else is to happen.
    Passed(usize),
    /// The jump before does not take the state across the surface of the event of this step.
    Carried(usize),
    /// Of the collisions of one instant another would come before that of this step.
    Order(usize),
}

impl Broken {
    /// The step that no longer holds.
    pub(super) fn step(&self) -> usize {
        match *self {
            Self::Event(index)
            | Self::Inner(index, _)
            | Self::Early(index, _)
            | Self::Beyond(index, _)
            | Self::Passed(index)
            | Self::Carried(index)
            | Self::Order(index) => index,
        }
    }

    /// In words.
    pub(crate) fn told(&self, shooting: &Shooting<f64>) -> String {
        let named = |guard| shooting.workshop.named(guard);
        match *self {
            Self::Event(index) => format!("event {index} of the orbit is met from the wrong side"),
            Self::Inner(index, guard) => format!(
                "on the way to event {index} of the orbit there is {}",
                named(guard)
            ),
            Self::Early(index, guard) => {
                format!("before event {index} of the orbit comes {}", named(guard))
            }
            Self::Beyond(index, guard) => format!(
                "event {index} of the orbit would come where what it ends begins: {}",
                named(guard)
            ),
            Self::Passed(index) => {
                let before = shooting.before(index);
                format!("events {before} and {index} of the orbit change places")
            }
            Self::Carried(index) => format!(
                "the jump before event {index} of the orbit would no longer cross its surface"
            ),
            Self::Order(index) if shooting.steps[index].impact().is_none() => format!(
                "surfaces that are crossed at one instant, that of event {index} of the orbit among them, no longer are"
            ),
            Self::Order(index) => format!(
                "collisions that share an instant come in another order: that of event {index} of the orbit is no longer the fastest"
            ),
        }
    }

    /// Positive while the sequence holds.
    pub(crate) fn value(&self, shooting: &Shooting<f64>, least: &[Vec<Least>]) -> Option<f64> {
        let value_of = |step: usize, guard: GuardKind, at_end: bool| {
            smallest(least, (step, guard), at_end).map(|least| least.value)
        };
        match *self {
            Self::Event(step) => {
                let rate = shooting.latest.get(step)?.surface_rate.abs();
                Some(if is_met_wrongly(shooting, least, step) {
                    -rate
                } else {
                    rate
                })
            }
            Self::Inner(step, guard) => value_of(step, guard, false),
            Self::Early(step, guard) | Self::Beyond(step, guard) => value_of(step, guard, true),
            Self::Passed(step) => Some(shooting.latest.get(step)?.duration),
            Self::Carried(step) => shooting.carried(step, least),
            Self::Order(step) => Some(shooting.precedence(step)?.0),
        }
    }
}

/// A guard that has just opened is known to rounding only: so small a part of what it is elsewhere on the orbit says nothing, …
const NOTHING: f64 = 1e-13;
/// … or so small a part of the states, where it is no larger part of them anywhere.
const NOWHERE: f64 = 1e-12;

/// All such guards, after an evaluation.
pub(crate) fn broken(shooting: &Shooting<f64>, least: &[Vec<Least>]) -> Vec<Broken> {
    let closure = &shooting.workshop.closure;
    let states = (shooting.state_sizes().iter().enumerate())
        .filter(|(index, _)| !closure.is_phase(*index))
        .fold(0.0_f64, |most, (_, size)| most.max(*size));
    let size = |guard: GuardKind| {
        let all = least.iter().flatten().filter(|least| least.guard == guard);
        let size = all.fold(0.0_f64, |most, least| most.max(least.size));
        if size > NOWHERE * states {
            size
        } else {
            states
        }
    };
    let mut found = Vec::new();
    for (index, step) in shooting.steps.iter().enumerate() {
        let Some(landing) = shooting.latest.get(index) else {
            continue;
        };
        if step.is_at_once() {
            let follows = found.contains(&Broken::Event(index.saturating_sub(1)));
            if !follows && (shooting.precedence(index)).is_some_and(|(first, _)| first < 0.0) {
                found.push(Broken::Order(index));
            }
            if !follows && (shooting.carried(index, least)).is_some_and(|beyond| beyond < 0.0) {
                found.push(Broken::Carried(index));
            }
            continue;
        }
        if landing.duration < 0.0 && !shooting.is_way_back(index) {
            found.push(Broken::Passed(index));
            continue;
        }
        // What is met from the wrong side was met from the right one before: its last least value is beyond that. (Of impacts both are
        // told: the flight tells what rounding leaves of one.)
        let mut beyond = None;
        if is_met_wrongly(shooting, least, index) {
            found.push(Broken::Event(index));
            if step.impact().is_none() {
                beyond = last_of_its_own(shooting, least, index);
            }
        }
        for least in least.get(index).into_iter().flatten() {
            if least.value >= 0.0 || beyond.is_some_and(|last| core::ptr::eq(last, least)) {
                continue;
            }
            if shooting.is_just_released(index, least) {
                continue;
            }
            // What vanishes with the event itself is left to the next step.
            let is_known = least.value < -NOTHING * size(least.guard);
            // Where roots have no slope beyond their surface, the rate with which that is met turns there: the event, and no way beyond it.
            let is_event = !is_known
                && step.impact().is_none()
                && step.ends_at() == Some(least.guard)
                && landing.duration - least.time <= NOWHERE * landing.duration;
            let known = match least.at_end {
                false if is_event => continue,
                false => Broken::Inner(index, least.guard),
                true if !is_known || shooting.ends_at_once_after(index, least.guard) => continue,
                true if shooting.is_rounding_of_gap(index, least) => continue,
                true if step.ends_at() == Some(least.guard) => Broken::Beyond(index, least.guard),
                true => Broken::Early(index, least.guard),
            };
            if !found.contains(&known) {
                found.push(known);
            }
        }
    }
    let found = without_vanished(shooting, without_passed(shooting, found));
    without_followers(shooting, found)
}

/// Less what breaks because the step before ends within the wall already, and nothing between them leads out of it: of a mass that would stick
/// there every step until it leaves breaks at one place, and only the flight that came to it says why.
fn without_followers(shooting: &Shooting<f64>, found: Vec<Broken>) -> Vec<Broken> {
    let goes_on = |index: usize| match shooting.steps[index].passage {
        Passage::Leg(kind) => kind.jump == Jump::None,
        _ => false,
    };
    let follows = |broken: &Broken| match *broken {
        Broken::Early(index, guard @ GuardKind::Gap(_)) => {
            let before = shooting.before(index);
            goes_on(before) && found.contains(&Broken::Early(before, guard))
        }
        _ => false,
    };
    let first: Vec<Broken> = (found.iter())
        .filter(|broken| !follows(broken))
        .cloned()
        .collect();
    if first.is_empty() { found } else { first }
}

/// Less what breaks because a crossing and its way back become one: the stay between them is over, and what it was beyond is touched.
fn without_vanished(shooting: &Shooting<f64>, mut found: Vec<Broken>) -> Vec<Broken> {
    let vanished = found.iter().filter_map(|broken| match broken {
        Broken::Event(index) => shooting.crossing_that_vanishes(*index),
        _ => None,
    });
    for first in vanished.collect::<Vec<usize>>() {
        let next = shooting.after(first);
        let beside = [first, next, shooting.after(next)];
        let guards = [beside[0], beside[1]].map(|index| shooting.steps[index].ends_at());
        found.retain(|broken| match broken {
            Broken::Inner(step, guard) => {
                !(beside.contains(step) && guards.contains(&Some(*guard)))
            }
            _ => true,
        });
    }
    found
}

/// The smallest of the least values of a guard on the way of a step, or at its end.
pub(crate) fn smallest(
    least: &[Vec<Least>],
    (step, guard): (usize, GuardKind),
    at_end: bool,
) -> Option<&Least> {
    (least.get(step)?.iter())
        .filter(|least| least.guard == guard && least.at_end == at_end)
        .min_by(|a, b| a.value.total_cmp(&b.value))
}

/// The last inner least value of the guard that ends a step.
fn last_of_its_own<'l>(
    shooting: &Shooting<f64>,
    least: &'l [Vec<Least>],
    index: usize,
) -> Option<&'l Least> {
    let guard = shooting.steps[index].ends_at()?;
    let mut all = least.get(index)?.iter().rev();
    all.find(|least| least.guard == guard && !least.at_end)
}

/// Whether the event at the end of a step is met from the wrong side: guards fall there, and what is an event on the way up and down
/// comes back from beyond.
fn is_met_wrongly(shooting: &Shooting<f64>, least: &[Vec<Least>], index: usize) -> bool {
    let (step, workshop) = (&shooting.steps[index], &shooting.workshop);
    let (Some(guard), Some(landing)) = (step.ends_at(), shooting.latest.get(index)) else {
        return false;
    };
    if step.is_stretch() {
        return false;
    }
    let GuardKind::Section(section) = guard else {
        return landing.surface_rate > 0.0;
    };
    let told = &workshop.model.sections[section];
    if !workshop.system.is_event(section) {
        return false;
    }
    if told.direction != Direction::Either {
        return landing.surface_rate > 0.0;
    }
    let last = last_of_its_own(shooting, least, index);
    last.zip(shooting.latest_parameters())
        .is_some_and(|(last, known)| {
            let beyond: f64 = (workshop.model.graph).evaluate(told.surface, &last.state, &known);
            last.value < 0.0 && landing.surface_rate * beyond < 0.0
        })
}

/// Less what breaks because two events have passed each other.
fn without_passed(shooting: &Shooting<f64>, mut found: Vec<Broken>) -> Vec<Broken> {
    let steps = &shooting.steps;
    let passed: Vec<usize> = (found.iter())
        .filter_map(|broken| match broken {
            Broken::Passed(index) => Some(*index),
            _ => None,
        })
        .collect();
    for index in passed {
        let before = shooting.before(index);
        let beside = [before, index, shooting.after(index)];
        let own = [steps[before].ends_at(), steps[index].ends_at()];
        // What has been released is closed before that.
        let closed = own.map(|guard| match guard {
            Some(GuardKind::Reaction(contact)) => Some(GuardKind::Gap(contact)),
            _ => None,
        });
        let guards = [own, closed].concat();
        found.retain(|broken| match broken {
            Broken::Inner(step, guard)
            | Broken::Early(step, guard)
            | Broken::Beyond(step, guard) => {
                !(beside.contains(step) && guards.contains(&Some(*guard)))
            }
            _ => true,
        });
    }
    found
}

/// Whether an orbit's equations are solved by what is no motion: through a wall, with events in another order, or with a counter that does not come back.
pub(crate) fn is_broken(shooting: &mut Shooting<f64>, at: &[f64]) -> Result<bool, Left> {
    shooting.evaluate(at)?;
    let least = shooting.least(at)?;
    Ok(!broken(shooting, &least).is_empty() || !shooting.counters_come_back(at))
}

/// Whether they have a value there, and the motion has that sequence of events.
pub(crate) fn sequence_holds(shooting: &mut Shooting<f64>, at: &[f64]) -> bool {
    is_broken(shooting, at).is_ok_and(|broken| !broken)
}

/// This part of a leg before a graze, or after it, is the touch itself.
const AT_TOUCH: f64 = 1e-5;

/// Least values on the way, but for those of the touch itself at the end of a step that grazes, as seen from either side of it: there the gap
/// is zero, and so is all that vanishes with its rate, to rounding.
pub(crate) fn least_beside(
    shooting: &mut Shooting<f64>,
    at: &[f64],
    grazing: Option<usize>,
) -> Result<Vec<Vec<Least>>, Left> {
    let mut least = shooting.least(at)?;
    let Some((index, contact)) =
        grazing.and_then(|index| Some((index, shooting.steps[index].impact()?)))
    else {
        return Ok(least);
    };
    let is_touch = |l: &Least| l.guard == GuardKind::Gap(contact) || is_nothing(l);
    let way = |step: usize| AT_TOUCH * shooting.latest[step].duration.abs();
    let after = shooting.after(index);
    let (begins, left) = (way(after), way(index));
    let end = shooting.latest[index].duration - left;
    if let Some(all) = least.get_mut(index) {
        all.retain(|l| l.at_end || l.time < end || !is_touch(l));
    }
    if let Some(all) = least.get_mut(after) {
        all.retain(|l| l.at_end || l.time > begins || !is_touch(l));
    }
    Ok(least)
}

/// Whether a guard touches zero, to rounding.
pub(super) fn is_nothing(least: &Least) -> bool {
    least.value.abs() <= NOWHERE * least.size.abs()
}

/// A gap that touches as well is so many roundoffs of its terms at most.
const TOUCHES_AS_WELL: f64 = 16.0;

/// What touches as well where a step grazes, each with the step that it does so on: on the way, or at its end where a gap turns with the surface that ends it.
pub(super) fn touches_beside(
    shooting: &mut Shooting<f64>,
    at: &[f64],
    grazing: usize,
) -> Result<Vec<(usize, Least)>, Left> {
    let least = least_beside(shooting, at, Some(grazing))?;
    let mut found = Vec::new();
    for (index, all) in least.iter().enumerate() {
        // A gap that is the sum of larger terms is known to roundoffs of these.
        let is_rounding = |l: &Least| match l.guard {
            GuardKind::Gap(contact) => {
                let terms = shooting.gap_rate(at, (index, contact)).1;
                !is_told(l.value.abs(), terms, TOUCHES_AS_WELL)
            }
            _ => false,
        };
        let touching = || all.iter().filter(|l| is_nothing(l) || is_rounding(l));
        let turns = |l: &Least| match l.guard {
            GuardKind::Gap(contact) => shooting.touches_at_turn((at, &least), (index, contact)),
            _ => false,
        };
        // A touch at the end is one just before it, too.
        let at_turn = touching().filter(|l| l.at_end && turns(l));
        let on_way = touching().filter(|l| !l.at_end && !turns(l));
        found.extend(at_turn.chain(on_way).map(|l| (index, l.clone())));
    }
    Ok(found)
}

/// What breaks, but for the step that grazes: after an evaluation there.
pub(crate) fn broken_beside(
    shooting: &mut Shooting<f64>,
    at: &[f64],
    grazing: Option<usize>,
) -> Result<Vec<Broken>, Left> {
    let least = least_beside(shooting, at, grazing)?;
    // What only an impact asks for, as its restitution, changes nothing where that has no rate.
    let is_graze = |broken: &Broken| match *broken {
        Broken::Event(step) => grazing == Some(step),
        Broken::Early(step, guard) => grazing == Some(step) && shooting.asks(step, guard),
        _ => false,
    };
    // What touches as well all along, as the other wall does of an orbit that is its own mirror image, does so to rounding.
    let touches = |broken: &Broken| match *broken {
        Broken::Inner(step, guard @ GuardKind::Gap(_)) if grazing.is_some() => {
            smallest(&least, (step, guard), false).is_some_and(is_nothing)
        }
        _ => false,
    };
    let found = broken(shooting, &least);
    Ok(found
        .into_iter()
        .filter(|broken| !is_graze(broken) && !touches(broken))
        .collect())
}

/// The first place, between a station and the one `step` ahead of it, where one of these breaks, and how far ahead it is. One step may graze all
/// along.
pub(crate) fn first_break(
    problem: &mut dyn Problem<f64>,
    (reader, grazing): (&mut Shooting<f64>, Option<usize>),
    (from, step): (&Station, f64),
    broken: Vec<Broken>,
) -> Option<(Broken, Station, f64)> {
    let mut first: Option<(Broken, Station, f64)> = None;
    let (far, _) = from.ahead(problem, step).ok()?;
    for broken in broken {
        let mut value = |station: &Station| {
            reader.evaluate(&station.at).ok()?;
            let least = least_beside(reader, &station.at, grazing).ok()?;
            // A least value that is not there yet is one that has not been reached.
            Some(broken.value(reader, &least).unwrap_or(1.0))
        };
        let start = value(from).unwrap_or(1.0);
        let start = if start > 0.0 {
            start
        } else {
            f64::MIN_POSITIVE
        };
        let ends = (start, value(&far).unwrap_or(-1.0));
        let found = locate(problem, from, step, ends, &mut |_, station| value(station));
        let Some((station, at)) = found else {
            continue;
        };
        let comes_first = first.as_ref().is_none_or(|(other, _, known)| {
            let tie = TIE * step.abs();
            match (loses(reader, other, &broken), loses(reader, &broken, other)) {
                (true, _) => at < known - tie,
                (_, true) => at < known + tie,
                _ => at < *known,
            }
        });
        if comes_first {
            first = Some((broken, station, at));
        }
    }
    first
}

/// What passes zero comes below this part of what it is to both sides.
const VANISHES: f64 = 1e-4;

/// Whether an event has not passed the one before, but jumped beyond it, on the way to the station `step` ahead, which was evaluated last: it is met from the wrong
/// side, and the time between both has no zero. So it is where a low flight is solved for backwards in time.
pub(in crate::analysis::periodic::branch) fn jumps_back(
    shooting: &Shooting<f64>,
    (from, step): (&Station, f64),
    broken: &[Broken],
) -> bool {
    broken.iter().any(|broken| {
        let Broken::Passed(index) = *broken else {
            return false;
        };
        let (Some(landing), Some(place)) =
            (shooting.latest.get(index), shooting.duration_place(index))
        else {
            return false;
        };
        let is_wrong = landing.surface_rate > 0.0 && shooting.steps[index].impact().is_some();
        if !is_wrong {
            return false;
        }
        let ends = (from.at[place], landing.duration);
        let mut least = f64::INFINITY;
        let found = locate(
            &mut shooting.clone(),
            from,
            step,
            ends,
            &mut |_, station| {
                let lasts = station.at[place];
                least = least.min(lasts.abs());
                Some(lasts)
            },
        );
        found.is_some() && least > VANISHES * ends.0.abs().min(ends.1.abs())
    })
}

/// So often what breaks hides something that did before it.
const HIDDEN: usize = 4;
/// This part of the way before a break.
const NOT_QUITE: f64 = 1e-5;

/// What breaks before a place that was found, if something does: at the end of the step it may have come to hold again, or break in another
/// way, as the end of a stick after an impact that then loses its rate. Not of what breaks where the step begins, up to what makes two places one.
pub(super) fn break_before(
    problem: &mut dyn Problem<f64>,
    reader: &mut Shooting<f64>,
    (from, step): (&Station, f64),
    mut first: (Broken, Station, f64),
) -> (Broken, Station, f64) {
    for _ in 0..HIDDEN {
        let close = first.2 * (1.0 - NOT_QUITE);
        if close <= TIE * step.abs() {
            break;
        }
        let Ok((before, _)) = from.ahead(problem, close) else {
            break;
        };
        if reader.evaluate(&before.at).is_err() {
            break;
        }
        let least = reader.least(&before.at).unwrap_or_default();
        let mut hidden = broken(reader, &least);
        hidden.retain(|hidden| !is_rounding_of(reader, (&first.0, hidden), &before));
        if hidden.is_empty() {
            break;
        }
        match first_break(problem, (reader, None), (from, close), hidden) {
            Some(earlier) if earlier.2 < close => first = earlier,
            _ => break,
        }
    }
    first
}

/// Whether what breaks beside an impact that loses its rate is that the flight after it is lower than rounding of the gap.
fn is_rounding_of(
    reader: &mut Shooting<f64>,
    (first, hidden): (&Broken, &Broken),
    station: &Station,
) -> bool {
    match *hidden {
        Broken::Inner(step, GuardKind::Gap(contact)) if loses(reader, first, hidden) => {
            let begins = reader.flight_begins(step);
            let follows = reader.before(begins) == first.step();
            follows && !reader.is_resolved(&station.at, (step, contact), LEAST_HEIGHT)
        }
        _ => false,
    }
}

/// Where an impact loses its rate the flight after it begins to go through the wall: both are told at one place, up to this part of a
/// step. So are both where a branch meets one on which each half of an orbit grazes.
const TIE: f64 = 1e-6;

/// Whether of what breaks at one place the one is an impact that loses its rate, and the other a flight that touches, or one that
/// begins on the surface that the rate crosses at the impact; or the one is an event that is touched with a corner, which it takes the state from.
fn loses(shooting: &Shooting<f64>, one: &Broken, other: &Broken) -> bool {
    if let (Broken::Inner(step, GuardKind::Section(event)), Broken::Inner(with, corner)) =
        (one, other)
    {
        let is_corner = matches!(corner, GuardKind::Switch(_));
        return step == with && is_corner && shooting.workshop.system.is_event(*event);
    }
    let impact = match *one {
        Broken::Event(impact) => impact,
        // Where drag turns with that rate its surface comes before the impact.
        Broken::Early(impact, guard @ GuardKind::Switch(_)) if !shooting.asks(impact, guard) => {
            impact
        }
        _ => return false,
    };
    let follows = match *other {
        Broken::Inner(_, GuardKind::Gap(_)) => true,
        Broken::Beyond(step, GuardKind::Switch(_)) | Broken::Passed(step) => {
            step == shooting.after(impact)
        }
        _ => false,
    };
    follows && shooting.steps[impact].impact().is_some()
}
