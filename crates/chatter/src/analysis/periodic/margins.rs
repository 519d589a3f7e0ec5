//! How near an orbit is to losing its sequence of events.

use super::branch::legal;
use super::cycle::itinerary::{Passage, Step};
use super::cycle::trace::{Instant, Tracer};
use super::error::PeriodicError;
use super::orbit::{cleaned, failed, told_start};
use super::shooting::{INCOMPLETE, Shooting, Workshop};
use crate::analysis::continuation::{NewtonError, Problem};
use crate::analysis::universal::{ChatterMap, Constants};
use crate::flow::leg::{Jump, Least};
use crate::flow::{Closed, GuardKind, Occurrence};
use core::ops::ControlFlow;

/// How near an orbit is to losing its sequence of events.
#[derive(Clone, Debug, PartialEq)]
pub struct Margin {
    /// What kind.
    pub kind: MarginKind,
    /// At which contact, surface or other guard.
    pub guard: GuardKind,
    /// When, since the start.
    pub time: f64,
    /// Zero where the sequence changes.
    pub value: f64,
}

/// Kinds of margins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MarginKind {
    /// The slowest impact.
    ImpactRate,
    /// The least gap of flights.
    LeastGap,
    /// The least acceleration that a closed contact keeps from being.
    LeastReaction,
    /// The least value of another guard: of the function of a surface or an event, of what is left of a piece of a table.
    LeastValue,
    /// The least jerk at a release.
    ReleaseJerk,
    /// The coordinate X of a chatter border, negative where chatter is complete; where friction makes flights fall more slowly than they rise,
    /// minus the ratio of both accelerations at its end.
    Border,
}

impl MarginKind {
    /// Its name in results.
    pub const fn name(self) -> &'static str {
        match self {
            Self::ImpactRate => "impact_rate",
            Self::LeastGap => "least_gap",
            Self::LeastReaction => "least_reaction",
            Self::LeastValue => "least_value",
            Self::ReleaseJerk => "release_jerk",
            Self::Border => "border",
        }
    }
}

/// The smallest of each kind of margin, at each guard.
pub(super) fn margins(
    shooting: &mut Shooting<f64>,
    at: &[f64],
) -> Result<Vec<Margin>, PeriodicError> {
    let left = |left| failed(&NewtonError::Left(left));
    shooting.evaluate(at).map_err(left)?;
    let all = shooting.least(at).map_err(left)?;
    let mut found: Vec<Margin> = Vec::new();
    let mut note = |kind: MarginKind, guard: GuardKind, time: f64, value: f64| {
        let known = (found.iter_mut()).find(|m| m.kind == kind && m.guard == guard);
        match known {
            Some(known) if known.value <= value => {}
            Some(known) => (known.time, known.value) = (time, value),
            None => found.push(Margin {
                kind,
                guard,
                time,
                value,
            }),
        }
    };
    let mut time = 0.0;
    let workshop = shooting.workshop.clone();
    for (index, step) in shooting.steps.iter().enumerate() {
        let landing = &shooting.latest[index];
        for least in &all[index] {
            let crosses = workshop.section.map(GuardKind::Section) == Some(least.guard);
            if !crosses && (!least.at_end || shooting.turns_up_after(index, (least, &all))) {
                let mut value = least.value;
                let kind = match least.guard {
                    GuardKind::Gap(_) => MarginKind::LeastGap,
                    GuardKind::Reaction(contact) => {
                        let opens = shooting.let_go(step, contact, &least.state);
                        value = opens.map_or(value, |[acceleration, _]| -acceleration);
                        MarginKind::LeastReaction
                    }
                    _ => MarginKind::LeastValue,
                };
                note(kind, least.guard, time + least.time, value);
            }
        }
        time += landing.duration;
        if let (Some(guard), Some(beyond)) = (step.ends_at(), shooting.carried(index, &all)) {
            note(MarginKind::LeastValue, guard, time, beyond);
        }
        if let Some(contact) = step.impact() {
            note(
                MarginKind::ImpactRate,
                GuardKind::Gap(contact),
                time,
                -landing.surface_rate,
            );
        }
        if let Some(GuardKind::Reaction(contact)) = step.ends_at() {
            // Minus the reaction is the acceleration that it keeps from being, where it is the only one that is closed.
            let opens = shooting.let_go(step, contact, &landing.image);
            note(
                MarginKind::ReleaseJerk,
                GuardKind::Reaction(contact),
                time,
                opens.map_or(-landing.surface_rate, |[_, jerk]| jerk),
            );
        }
    }
    found.extend(borders(shooting, at));
    Ok(found)
}

impl Shooting<f64> {
    /// Whether a gap or a force has its least value on a step at the end of that, where something else happens, and none that is less on the next
    /// one: as at the knot of a table, or on a surface where the field has a corner.
    fn turns_up_after(&self, index: usize, (least, all): (&Least, &[Vec<Least>])) -> bool {
        let (before, after) = (self.before(index), self.after(index));
        let (step, next) = (&self.steps[index], &self.steps[after]);
        let is_watched = |closed: Closed| match least.guard {
            GuardKind::Gap(contact) => !closed.contains(contact),
            GuardKind::Reaction(contact) => closed.contains(contact),
            _ => false,
        };
        let is_leg = step.flight().is_some_and(|kind| kind.jump == Jump::None);
        let goes_on = is_leg && next.has_own_time() && next.ends_at() != Some(least.guard);
        let of_it = |of: usize| all[of].iter().filter(|other| other.guard == least.guard);
        // It was more where the step begins, which is where the one before ends.
        let was_more = of_it(before).any(|other| other.at_end && other.value > least.value);
        goes_on
            && [self.closed_before(index), step.closed]
                .into_iter()
                .all(is_watched)
            && was_more
            && of_it(index).all(|other| other.at_end || other.value > least.value)
            && of_it(after).all(|other| other.value > least.value)
    }

    /// How the gap of a contact that is held beside others at this state of a step would open if that one alone were let go.
    fn let_go(&self, step: &Step, contact: usize, state: &[f64]) -> Option<[f64; 2]> {
        let known = self.parameters_of(&self.latest_parameters()?, step);
        let system = &self.workshop.system;
        system.let_go((step.mode(), contact), &known, state)
    }
}

/// u of an impact near release (docs/periodic.md, M6): the scaled rate after it, with which complete chatter is told from
/// incomplete.
struct Local {
    /// How many impacts of the sequence came before it.
    place: usize,
    time: f64,
    u: f64,
    restitution: f64,
}

/// From a third on the next impact, if there is one, is no impact of the sequence.
const LARGEST: f64 = 1.0 / 3.0;
/// Where u has fallen below this part of u*, what is left is far from release.
const LEAST: f64 = 0.5;
/// Iterated back, u is near u* where the next term of the linearising function is as small.
const NEAR: f64 = 1e-7;
/// So many steps are never needed.
const MOST_BACK: usize = 400;

/// The coordinate X of the border of each contact that an orbit chatters at (docs/periodic.md), where it comes near enough to one
/// for that to have a meaning.
fn borders(shooting: &Shooting<f64>, at: &[f64]) -> Vec<Margin> {
    let workshop = &shooting.workshop;
    let parameters = workshop.parameters(shooting.free(at));
    let contacts = 0..workshop.model.contacts.len();
    let Some(instants) = followed(shooting, at, &parameters) else {
        return Vec::new();
    };
    let period = shooting.period();
    let margin = |contact: usize| {
        let told = |time: f64, value: f64| {
            let time = time - instants[0].time;
            value.is_finite().then_some(Margin {
                kind: MarginKind::Border,
                guard: GuardKind::Gap(contact),
                time: time - period * (time / period).floor(),
                value,
            })
        };
        if let Some((time, fall)) = fall_at_end(workshop, &parameters, &instants, contact) {
            return told(time, -fall);
        }
        let local = sequence(workshop, &parameters, &instants, (contact, period))?;
        let constants = Constants::new(local.last()?.restitution).ok()?;
        let fixed = constants.chatter_fixed_point;
        // The later, the less is left of nu, which the linearising function takes for nothing.
        let last = (local.iter()).rfind(|local| (LEAST * fixed..LARGEST).contains(&local.u))?;
        let value =
            linearised(&constants, last.u) * libm::exp(constants.ln_eta * last.place as f64);
        told(last.time, value)
    };
    contacts.filter_map(margin).collect()
}

/// Accelerations of rise and fall that differ by less than this part are one.
const ALIKE: f64 = 1e-6;

/// When chatter of a contact ends whose flights fall with another acceleration than they rise, as friction along the gap makes them, and the one in
/// parts of the other there. If it is nothing flights come back no more: what is left of the sequence is held in the air.
fn fall_at_end(
    workshop: &Workshop,
    parameters: &[f64],
    instants: &[Instant],
    contact: usize,
) -> Option<(f64, f64)> {
    let hit = |instant: &Instant| (instant.impact()).filter(|(hit, _)| *hit == contact);
    let ends = instants.iter().enumerate().filter(|(_, end)| {
        end.told.iter().any(|told| match *told {
            Occurrence::Accumulation { contact: of, .. } => of == contact,
            Occurrence::Slide { .. } => true,
            _ => false,
        })
    });
    let falls = ends.filter_map(|(place, end)| {
        let impacts = instants[..place].iter().enumerate().rev();
        let mut impacts = impacts.filter_map(|(at, instant)| Some((at, hit(instant)?.1)));
        let latest: [(usize, f64); LEAST_IMPACTS] =
            core::array::from_fn(|_| impacts.next()).map(|impact| impact.unwrap_or((0, f64::NAN)));
        let last = latest[0].0;
        let slows = latest
            .windows(2)
            .all(|pair| pair[0].1.abs() < pair[1].1.abs());
        // An impact whose rate is rounding may close the contact at the end itself.
        let is_open =
            |instant: &Instant| instant.closed == Closed::NONE || instant.time == end.time;
        let flies = instants[last..place].iter().all(is_open);
        if !(slows && flies) {
            return None;
        }
        // The top of the last flights may share the instant of the impact before.
        let modes = |at: usize| (instants[at].mode, instants[at].mode_after);
        let (fall, rise) = latest.windows(2).find_map(|pair| {
            let both = [pair[0].0, pair[1].0].map(modes);
            (both[0] == both[1] && both[0].0 != both[0].1).then_some(both[0])
        })?;
        let last = &instants[last];
        let known = workshop.system.with_pieces(parameters, &last.pieces);
        let moves = |mode: usize| {
            workshop
                .system
                .gap_moves((mode, contact), &known, &end.state)
        };
        let ratio = moves(fall)?[0] / moves(rise)?[0];
        ((ratio - 1.0).abs() > ALIKE).then_some((end.time, ratio))
    });
    falls.min_by(|a, b| a.1.total_cmp(&b.1))
}

/// Nearer to a border than this, in parts of the period from the end of chatter to release, or of X, an orbit is at it.
const AT_BORDER: f64 = 1e-3;

/// Whether equations that Newton's method leaves near a solution are left at a chatter border.
pub(super) fn leaves_at_border(shooting: &Shooting<f64>, at: &[f64], error: &NewtonError) -> bool {
    // Whatever else has no meaning beyond, as a table without more rows, says nothing of chatter.
    let is_left = matches!(error, NewtonError::Left(left) if left.what == INCOMPLETE);
    shooting.steps.iter().any(Step::is_stretch) && is_at_border(shooting, at, is_left)
}

/// Whether an orbit is released as its complete chatter ends, as far as numbers can tell; whether its equations are left there for chatter that has no
/// end.
fn is_at_border(shooting: &Shooting<f64>, at: &[f64], is_left: bool) -> bool {
    // Beside rounding chatter may seem incomplete, and nothing be released after it.
    let released_at_once = match shortest_contact(shooting, at) {
        Some(shortest) => shortest <= AT_BORDER * shooting.period(),
        None => is_left || falls_short(shooting, at),
    };
    released_at_once
        || borders(shooting, at)
            .iter()
            .any(|border| border.value.abs() <= AT_BORDER)
}

/// Whether the motion has less complete chatter than the orbit is followed through, as right beyond a border, where rounding lets its equations pass.
fn falls_short(shooting: &Shooting<f64>, at: &[f64]) -> bool {
    (shooting.steps.iter().enumerate()).any(|(index, step)| {
        let Passage::Stretch(kind) = step.passage else {
            return false;
        };
        let (_, instants) = shooting.instants_within(index, at);
        let ends = instants.iter().filter_map(Instant::accumulated);
        ends.count() < kind.accumulations
    })
}

/// The shortest time from the end of complete chatter to the release after it, if anything is released.
pub(super) fn shortest_contact(shooting: &Shooting<f64>, at: &[f64]) -> Option<f64> {
    let all = (0..shooting.steps.len()).flat_map(|index| {
        let (_, instants) = shooting.instants_within(index, at);
        let contact_lasts = |(place, instant): (usize, &Instant)| {
            let (contact, _) = instant.accumulated()?;
            // At a border nothing may be left of it, nor of its release.
            if !instant.closed.contains(contact) {
                return Some(0.0);
            }
            let release = instants[place..].iter().find(|next| next.is_release())?;
            Some(release.time - instant.time)
        };
        let all: Vec<f64> = instants
            .iter()
            .enumerate()
            .filter_map(contact_lasts)
            .collect();
        all
    });
    all.min_by(f64::total_cmp)
}

/// The coordinate of the nearest border, if there is one that can be told.
pub(super) fn border_coordinate(shooting: &Shooting<f64>, at: &[f64]) -> Option<f64> {
    let all = borders(shooting, at).into_iter().map(|border| border.value);
    all.min_by(|a, b| a.abs().total_cmp(&b.abs()))
}

/// What happens in three periods from the first node on.
fn followed(shooting: &Shooting<f64>, at: &[f64], parameters: &[f64]) -> Option<Vec<Instant>> {
    let workshop = &shooting.workshop;
    let start = cleaned(&told_start(shooting, at), &shooting.state_sizes());
    // What has just been released may be rounding of its gap below it.
    let start = legal(workshop, shooting.free(at), (Closed::NONE, &start))?;
    let tracer = Tracer::new(&workshop.system, parameters, &start, None);
    let mut tracer = tracer.ok()?;
    let mut instants = vec![tracer.start(&start)];
    let mut quiet = |_: f64| ControlFlow::Continue(());
    let until = instants[0].time + 3.0 * shooting.period();
    (tracer.follow((until, usize::MAX / 2), &mut instants, &mut quiet)).ok()?;
    Some(instants)
}

/// The impacts at a contact that follow its longest flight, up to the last that another one follows before the next such flight.
fn sequence(
    workshop: &Workshop,
    parameters: &[f64],
    instants: &[Instant],
    (contact, period): (usize, f64),
) -> Option<Vec<Local>> {
    // Flights end with an impact there, and begin with one or with a release.
    let hits = |instant: &Instant| instant.impact().is_some_and(|(hit, _)| hit == contact);
    let ends: Vec<usize> = (1..instants.len())
        .filter(|&k| hits(&instants[k]))
        .collect();
    let flight = |&end: &usize| {
        let leaves = |instant: &Instant| hits(instant) || instant.is_release();
        let begin = (0..end).rev().find(|&k| leaves(&instants[k]))?;
        Some(instants[end].time - instants[begin].time)
    };
    // A flight that began before the first instant ends once more, and what follows is whole.
    let limit = instants[0].time + 2.0 * period;
    let first = (ends.iter().copied())
        .filter(|end| instants[*end].time <= limit)
        .filter_map(|end| Some((end, flight(&end)?)))
        .max_by(|a, b| a.1.total_cmp(&b.1))?
        .0;
    let mut found = Vec::new();
    let all = ends.iter().filter(|&&end| {
        end >= first && instants[end].time < instants[first].time + (1.0 - SAME_FLIGHT) * period
    });
    for (place, &end) in all.enumerate() {
        let instant = &instants[end];
        let Some((grip, _, on)) = workshop.system.origin_of(instant.mode_after) else {
            break;
        };
        if grip.closed != Closed::NONE {
            break;
        }
        let known = workshop.system.with_pieces(parameters, &instant.pieces);
        let mechanics = &on.mechanics.contacts[contact];
        let of = |expr| on.mechanics.graph.evaluate(expr, &instant.state, &known);
        let (rate, acceleration, jerk) = (
            of(mechanics.rate),
            of(mechanics.acceleration),
            of(mechanics.jerk),
        );
        if !(acceleration < 0.0 && rate > 0.0 && jerk > 0.0) {
            // What is held comes nearer to release the later it is: a sequence may begin before.
            if found.is_empty() {
                continue;
            }
            break;
        }
        found.push(Local {
            place,
            time: instant.time,
            u: jerk * rate / (acceleration * acceleration),
            restitution: of(mechanics.restitution),
        });
    }
    (found.len() >= LEAST_IMPACTS).then_some(found)
}

/// Fewer impacts are no chatter.
const LEAST_IMPACTS: usize = 4;
/// The same flight a period later is known to this part of it.
const SAME_FLIGHT: f64 = 1e-6;

/// X of u where nu is nothing: lim eta^-m (g^-m(u) - u*).
fn linearised(constants: &Constants<f64>, u: f64) -> f64 {
    let map = ChatterMap::new(constants);
    let fixed = constants.chatter_fixed_point;
    let (mut u, mut growth) = (u, 1.0);
    for _ in 0..MOST_BACK {
        if (u - fixed).abs() <= NEAR * fixed {
            break;
        }
        u = map.inverse(u);
        growth /= constants.eta;
    }
    (u - fixed) * growth
}
