//! Settles the steps that a [`step`](super) could not certify: full root isolation on every guard.

use super::flight::reaches;
use super::{GROWTH, LATE_ROUNDOFFS, LEAST_GROWTH, NO_EVENT, Workspace, least_step};
use crate::expressions::Operand;
use crate::flow::error::FlowError;
use crate::flow::modes::guard::{Guard, GuardKind, Transition};
use crate::flow::modes::program::Program;
use crate::flow::sections::crossing::SectionPath;
use crate::flow::system::System;
use crate::flow::touching::{Left, Touching};
use crate::numerics::Real;
use crate::numerics::polynomial::{horner_with_slope, magnitude};
use crate::numerics::roots::{Crossing, Root, RootKind, first_root};

/// How a settled step ends, beyond the workspace's event code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Resolution {
    /// A guard that is touched, not crossed, at the end of the step.
    pub touched: Option<usize>,
    /// The step ends within the remaining time, not at it.
    pub shortened: bool,
    /// A section was crossed without the state lying on it: an impact made its function jump.
    pub jumped: bool,
}

/// The unit of time shrinks by [`LEAST_GROWTH`] while an expansion overflows or reaches less far than that, this many
/// times at most.
const SHRINKS: usize = 40;

/// Towards a singular point a step goes half the way or a quarter; this many times that is beyond it.
const BEYOND: f64 = 16.0;

/// A first root may lie this many halvings of the step close to its start: all that a double can be halved.
const HALVINGS: usize = 1100;

/// Expands again at the highest order and finds the first event with certainty. The workspace holds the inputs of the
/// step; afterwards its step and event are set, the state is not moved yet.
pub(crate) fn resolve<R: Real>(
    work: &mut Workspace<R>,
    program: &Program,
    class: usize,
    (touching, left): (Touching, Left<R>),
) -> Result<Resolution, Unsettled> {
    expand_within_reach(work, program, class)?;
    let least = least_step(work.time);
    let stalls = |work: &Workspace<R>| work.scaled_step * work.tau <= least && work.horizon > least;
    if work.is_clear() && !stalls(work) {
        return first_event(work, program, (touching, left));
    }
    let Some((which, after)) = work.singularity(program) else {
        // Towards a singular point that is left behind steps have shrunk: not so the motion's own time.
        work.tau = work.tau.max(work.longest);
        expand_within_reach(work, program, class)?;
        return match work.is_clear() && !stalls(work) {
            true => first_event(work, program, (touching, left)),
            false => Err(Unsettled::NotFinite),
        };
    };
    // The singular point cannot be told from here. Neither can what lies there: an impact comes first, and ends it.
    work.scaled_step = (work.scaled_step * R::splat(BEYOND)).min(work.horizon / work.tau);
    let resolution = first_event(work, program, (touching, left))?;
    let ends = work.event != R::splat(NO_EVENT) || resolution.touched.is_some();
    if ends {
        Ok(resolution)
    } else {
        let after = after.to_f64();
        Err(Unsettled::Singular { which, after })
    }
}

/// Expands, in a shorter unit of time where the expansion overflows or says little of what it reaches.
pub(crate) fn expand_within_reach<R: Real>(
    work: &mut Workspace<R>,
    program: &Program,
    class: usize,
) -> Result<(), Unsettled> {
    let mut tries = 0;
    loop {
        work.expand_only(program, class);
        let is_step = work.scaled_step.is_finite() && work.scaled_step > R::ZERO;
        let is_finite = is_step && expansion_is_finite(work, program);
        if is_finite && (work.growth >= R::splat(LEAST_GROWTH) || tries == SHRINKS) {
            return Ok(());
        }
        if !is_finite && let Some((which, after)) = work.singularity(program) {
            let after = after.to_f64();
            return Err(Unsettled::Singular { which, after });
        }
        tries += 1;
        if tries > SHRINKS {
            return Err(Unsettled::NotFinite);
        }
        work.tau *= R::splat(LEAST_GROWTH);
    }
}

/// The first event within the workspace's step, which it shortens.
fn first_event<R: Real>(
    work: &mut Workspace<R>,
    program: &Program,
    (touching, left): (Touching, Left<R>),
) -> Result<Resolution, Unsettled> {
    work.event = R::splat(NO_EVENT);
    let mut touched = None;
    let whole = work.scaled_step;
    let ends_the_run = reaches(whole * work.tau, work.horizon);
    // In units of the step, what rounding leaves open of the time at its end.
    let open = work.time.abs() * R::splat(LATE_ROUNDOFFS * R::ROUNDOFF) / work.tau;
    for (index, guard) in program.guards.iter().enumerate() {
        if guard.is_balanced(touching.get(index)) {
            continue;
        }
        let Some(p) = work.guard_series(guard.series, touching.get(index)) else {
            continue;
        };
        // A contact may keep the state exactly on a corner that it was leaving when it closed.
        if guard.meets_corner() && p.iter().all(|&coefficient| coefficient == R::ZERO) {
            continue;
        }
        let width = work.scaled_step;
        let busy = touched.is_some() || work.event >= R::ZERO;
        let at_end = ends_the_run && !busy;
        let found = if let Some(section) = guard.section() {
            let path = section_path(work, program, guard, (p, section), touching.get(index));
            (path.first(width)).or_else(|| path.at_end(width, open).filter(|_| at_end))
        } else if let GuardKind::Outside(..) = guard.kind {
            let terms = size_of_terms(work, program, guard);
            first_clearly_below(p, width, (Workspace::<R>::NOISE, terms))
        } else {
            let is_left = touching.get(index) > 0;
            let is_known = |contact| work.known_gap.is_some_and(|(known, _)| known == contact);
            let is_known = guard.closing().is_some_and(is_known);
            let terms = if is_left || is_known || guard.is_affine {
                R::ZERO
            } else {
                size_of_terms(work, program, guard)
            };
            // So may it keep a contact closed without a force, in a mode that has just begun.
            if guard.opening().is_some() && !is_left && vanishes(work, program, guard, p) {
                continue;
            }
            let risen_by = if is_left {
                0
            } else {
                left.positive_coefficients(index, p, work.tau)
            };
            match risen_by {
                0 => first_closing(p, width, (Workspace::<R>::NOISE, terms), is_left),
                count => first_closing(
                    &risen(p, count),
                    width,
                    (Workspace::<R>::NOISE, terms),
                    true,
                ),
            }
            .map_err(|Stuck| Unsettled::Stuck(index))?
            .or_else(|| closing_at_end(p, width, open).filter(|_| at_end))
        };
        let Some(root) = found else { continue };
        work.scaled_step = root.at;
        match root.kind {
            RootKind::Crossing => {
                work.event = R::splat(index as f64);
                touched = None;
            }
            RootKind::Touching => {
                work.event = R::splat(NO_EVENT);
                touched = Some(index);
            }
        }
    }
    let jumped = find_sides(work, program, touching);
    Ok(Resolution {
        touched,
        shortened: work.scaled_step < whole,
        jumped,
    })
}

/// The first section that is crossed where the trajectory is, by the sides that it comes from, and whether by a jump; an impact ahead
/// says how far its series tell. The workspace holds the inputs of a step; afterwards its sides and event are those of a step of no
/// length.
pub(crate) fn crossed_here<R: Real>(
    work: &mut Workspace<R>,
    program: &Program,
    class: usize,
    (touching, flight_time): (Touching, R),
) -> Option<bool> {
    work.expand_only(program, class);
    work.scaled_step = R::ZERO;
    work.event = R::splat(NO_EVENT);
    for (index, guard) in program.guards.iter().enumerate() {
        let (Some(section), Some(p)) = (
            guard.section(),
            work.guard_series(guard.series, touching.get(index)),
        ) else {
            continue;
        };
        let path = section_path(work, program, guard, (p, section), touching.get(index));
        let path = SectionPath {
            reach: path.reach.min(flight_time / work.tau),
            ..path
        };
        if let Some(jumped) = path.crossed_at_start() {
            work.event = R::splat(index as f64);
            find_sides(work, program, touching);
            return Some(jumped);
        }
    }
    None
}

fn section_path<'p, R: Real>(
    work: &Workspace<R>,
    program: &Program,
    guard: &Guard,
    (series, section): (&'p [R], usize),
    touching: u8,
) -> SectionPath<'p, R> {
    let terms = if touching == 0 {
        size_of_terms(work, program, guard)
    } else {
        R::ZERO
    };
    // What rounding leaves open is told by how far the motion goes, and not by how far a polynomial reaches.
    let seen = match work.longest > R::ZERO {
        true => (work.longest * R::splat(GROWTH) / work.tau).max(work.scaled_step),
        false => work.growth,
    };
    SectionPath {
        series,
        crossing: guard.crossing,
        side: work.sides[section],
        kept: R::splat(guard.side),
        terms,
        // What begins with a zero is not rounded like what it comes to far away.
        reach: match touching {
            1.. if work.scaled_step > R::ZERO => work.growth.min(work.scaled_step),
            _ => work.growth.min(seen),
        },
        noise: Workspace::<R>::NOISE,
    }
}

/// Whether no coefficient of a guard can be told from zero by the terms that its value is the sum of.
fn vanishes<R: Real>(work: &Workspace<R>, program: &Program, guard: &Guard, p: &[R]) -> bool {
    let level = size_of_terms(work, program, guard) * R::splat(Workspace::<R>::NOISE);
    p.iter().all(|coefficient| coefficient.abs() <= level)
}

/// What the value of a guard where the step begins is rounded against.
fn size_of_terms<R: Real>(work: &Workspace<R>, program: &Program, guard: &Guard) -> R {
    match guard.series {
        Operand::Series(slot) => {
            (work.expansion).size_of_terms(&program.tape, &work.constants, slot)
        }
        Operand::Constant(_) => R::ZERO,
    }
}

/// Finds on which side of each section the step ends. Returns whether it ends by a jump across one.
fn find_sides<R: Real>(work: &mut Workspace<R>, program: &Program, touching: Touching) -> bool {
    let width = work.scaled_step;
    let mut jumped = false;
    for (index, guard) in program.guards.iter().enumerate() {
        let (Some(section), Some(p)) = (
            guard.section(),
            work.guard_series(guard.series, touching.get(index)),
        ) else {
            continue;
        };
        let path = section_path(work, program, guard, (p, section), touching.get(index));
        let side = if work.event == R::splat(index as f64) {
            jumped = width == R::ZERO && path.crossed_at_start() == Some(true);
            path.side_after(width)
        } else {
            path.side_at(width)
        };
        work.sides[section] = side;
    }
    jumped
}

/// Why a step cannot be settled; the caller knows time and state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Unsettled {
    /// The field has no finite expansion here.
    NotFinite,
    /// This guard was just left and does not grow.
    Stuck(usize),
    /// Something that must not vanish does.
    Singular {
        /// What: its place in the program's tape.
        which: usize,
        /// In what time.
        after: f64,
    },
}

impl Unsettled {
    /// The error to report, at the state where the step began.
    pub(crate) fn into_error<R: Real>(
        self,
        (time, state): (R, &[R]),
        (system, program): (&System, &Program),
    ) -> FlowError {
        match self {
            Self::NotFinite => FlowError::LeftDomain {
                time: time.to_f64(),
                state: state.iter().map(|x| x.to_f64()).collect(),
            },
            Self::Singular { which, after } => FlowError::Singular {
                time: time.to_f64() + after,
                kind: program.tape.singular[which].kind,
                expression: program.vanishing[which].clone(),
            },
            Self::Stuck(guard) => match program.guards[guard].transition {
                Transition::Impact { contact }
                | Transition::AskImpact { contact }
                | Transition::Collide { contact }
                | Transition::HandOver { contact }
                | Transition::Open { contact }
                | Transition::Jam { contact } => FlowError::UndecidedRelease {
                    time: time.to_f64(),
                    contact,
                },
                Transition::Meet(corner) | Transition::Part(corner) => FlowError::NoMode {
                    time: time.to_f64(),
                    surfaces: vec![system.corner_name(corner)],
                },
                // Sections may have either sign, and are never stuck; nor are the ends of tables, which nothing leaves.
                Transition::Cross { .. }
                | Transition::Reset { .. }
                | Transition::LeaveTable { .. }
                | Transition::LeaveDomain => FlowError::NoMode {
                    time: time.to_f64(),
                    surfaces: Vec::new(),
                },
            },
        }
    }
}

/// Whether states and guards have finite values all along the step: no root can be told among others.
fn expansion_is_finite<R: Real>(work: &Workspace<R>, program: &Program) -> bool {
    let guards = program
        .guards
        .iter()
        .filter_map(|guard| match guard.series {
            Operand::Series(slot) => Some(slot),
            Operand::Constant(_) => None,
        });
    (0..work.state.len())
        .chain(guards)
        .all(|slot| magnitude(work.expansion.series(slot), work.scaled_step).is_finite())
}

/// The zero at the end of a step that stops short of it by no more than rounding, that of the time included, which leaves so much
/// `open`.
fn closing_at_end<R: Real>(p: &[R], width: R, open: R) -> Option<Root<R>> {
    let (value, slope) = horner_with_slope(p, width);
    let noise = magnitude(p, width) * R::splat(Workspace::<R>::NOISE);
    let level = noise.max(slope.abs() * open);
    let closes = p[0] > level && value <= level && slope * width < -noise;
    closes.then_some(Root {
        at: width,
        kind: RootKind::Crossing,
    })
}

/// A guard whose so many lowest coefficients are known not to be negative, without those that vanish at its start.
fn risen<R: Real>(p: &[R], count: usize) -> Vec<R> {
    let known = p[..count].iter().map(|&c| c.max(R::ZERO));
    let zeros = known.clone().take_while(|&c| c == R::ZERO).count();
    known
        .chain(p[count..].iter().copied())
        .skip(zeros)
        .collect()
}

/// Where a function is first below zero by more than rounding, its value at the start being the sum of terms of this size: what is no
/// surface, but a place to keep to.
fn first_clearly_below<R: Real>(p: &[R], width: R, (noise, terms): (f64, R)) -> Option<Root<R>> {
    let level = magnitude(p, width).max(terms) * R::splat(noise);
    let mut above = p.to_vec();
    above[0] += level + level;
    if above[0] <= R::ZERO {
        return Some(Root {
            at: R::ZERO,
            kind: RootKind::Crossing,
        });
    }
    first_root(&above, width, Crossing::Falling, level)
        .filter(|root| root.kind == RootKind::Crossing)
}

/// A guard that was just left does not grow.
struct Stuck;

/// The first zero of a gap or reaction, which is positive at the start up to noise; and the value there is the sum of terms
/// of this size.
fn first_closing<R: Real>(
    p: &[R],
    width: R,
    (noise, terms): (f64, R),
    left: bool,
) -> Result<Option<Root<R>>, Stuck> {
    // What was left from rest by a higher derivative than roots are counted begins with more of them.
    let more = p.iter().take_while(|&&c| left && c == R::ZERO).count();
    let p = if more < p.len() { &p[more..] } else { p };
    let start = p[0];
    let noise_within = |end: R| magnitude(p, end) * R::splat(noise);
    let level = noise_within(width).max(terms * R::splat(noise));
    if start > level {
        return Ok(first_root(p, width, Crossing::Falling, level));
    }
    if !left && let Some(at) = turns_at_once(p, (noise, terms)).filter(|&at| at <= width) {
        return Ok(Some(Root {
            at,
            kind: RootKind::Touching,
        }));
    }
    if start > noise_within(width) {
        return Ok(first_root(p, width, Crossing::Falling, noise_within(width)));
    }
    if start <= R::ZERO && left {
        return Err(Stuck);
    }
    if start <= R::ZERO {
        // On the surface up to rounding: an inward rate is an impact now, an outward one leaves it.
        if p.len() < 2 || p[1] <= R::ZERO {
            return Ok(Some(Root {
                at: R::ZERO,
                kind: RootKind::Crossing,
            }));
        }
        return first_closing(&p[1..], width, (noise, R::ZERO), true);
    }
    // Positive, but small against what the guard reaches later: search pieces that double in length, each with the
    // noise of its own size.
    let mut end = width;
    for _ in 0..HALVINGS {
        if start > noise_within(end) {
            break;
        }
        end *= R::splat(0.5);
    }
    let mut begin = R::ZERO;
    while end <= width {
        let piece = shifted(p, begin);
        let length = end - begin;
        if let Some(root) = first_root(&piece, length, Crossing::Falling, noise_within(end)) {
            return Ok(Some(Root {
                at: begin + root.at,
                kind: root.kind,
            }));
        }
        begin = end;
        end = end + end;
    }
    Ok(None)
}

/// Where a guard that is zero up to rounding falls no deeper than rounding before it rises: a graze, whatever sign its value
/// has. Rounding is that of the value it begins with, which is the sum of terms of this size, and of the way to there.
fn turns_at_once<R: Real>(p: &[R], (noise, terms): (f64, R)) -> Option<R> {
    let &[_, slope, bend, ..] = p else {
        return None;
    };
    let at = -slope / (bend + bend);
    let level = magnitude(p, at.abs()).max(terms) * R::splat(noise);
    let turns = slope <= R::ZERO && bend > R::ZERO && slope * slope <= R::splat(4.0) * bend * level;
    turns.then_some(at)
}

/// Coefficients of s -> p(begin + s).
fn shifted<R: Real>(p: &[R], begin: R) -> Vec<R> {
    let mut shifted = p.to_vec();
    if begin == R::ZERO {
        return shifted;
    }
    for first in 0..p.len() {
        for k in (first..p.len() - 1).rev() {
            let above = shifted[k + 1];
            shifted[k] = above.mul_add(begin, shifted[k]);
        }
    }
    shifted
}
