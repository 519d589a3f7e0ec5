//! Returns of a trajectory to where it was: the instants that tell them.

use super::sizes::size;
use crate::analysis::periodic::closure::Turn;
use crate::analysis::periodic::cycle::events::single;
use crate::analysis::periodic::cycle::itinerary::{is_several, struck};
use crate::analysis::periodic::cycle::trace::Instant;
use crate::analysis::periodic::shooting::Workshop;

/// A return this near is one; others are tried where time runs out.
pub(super) const NEAR: [f64; 4] = [1e-9, 1e-6, 1e-4, 1e-2];

/// A return that is not as near as the first of these is none after more instants: the equations of so long a cycle take minutes, and
/// what has not settled is nearer to a shorter one.
pub(super) const MOST_LOOSE: usize = 240;

/// Events whose times differ by so many roundoffs may share an instant.
pub(super) const ONE_INSTANT: f64 = 8.0;

/// The instants that may tell returns, the best first: the latest crossing of the section, the latest release, the fastest impact of
/// late, and, without any of the latter two, the latest of all others that shares its time with none.
pub(super) fn landmarks(instants: &[Instant], section: Option<usize>) -> Vec<usize> {
    let late = instants.len() / 2;
    let crossed = section.and_then(|section| {
        instants
            .iter()
            .rposition(|instant| instant.crosses(section))
    });
    // Where a release shares its instant with something else, no step ends.
    let released = (instants.iter())
        .rposition(|instant| instant.is_release() && single(instant).is_some())
        .or_else(|| instants.iter().rposition(Instant::is_release));
    // Where several contacts collide may be the middle of their chatter.
    let several = |at: &Instant| is_several(struck(core::slice::from_ref(at), at.time));
    let by_itself = |at: &Instant| at.impact().is_some() && !several(at);
    let is_known = instants[late..].iter().any(by_itself);
    let rate = |at: &Instant| {
        let (_, rate) = at.impact()?;
        (!is_known || by_itself(at)).then_some(rate)
    };
    let fastest = (instants.iter().enumerate().skip(late))
        .filter_map(|(index, instant)| Some((index, rate(instant)?)))
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .and_then(|(_, fastest)| {
            // The latest that is as fast.
            instants.iter().rposition(|instant| {
                rate(instant).is_some_and(|other| other <= fastest * (1.0 - 1e-6))
            })
        });
    let mut found: Vec<usize> = [crossed, released, fastest].into_iter().flatten().collect();
    found.dedup();
    if released.or(fastest).is_none() {
        let crosses = |index: usize| section.is_some_and(|s| instants[index].crosses(s));
        let shares = |(a, b): (usize, usize)| match (instants.get(a), instants.get(b)) {
            (Some(a), Some(b)) => {
                (a.time - b.time).abs() <= ONE_INSTANT * f64::EPSILON * b.time.abs()
            }
            _ => false,
        };
        let is_last = |index: &usize| !shares((index + 1, *index));
        let is_alone = |index: &usize| {
            !crosses(*index)
                && is_last(index)
                && !index
                    .checked_sub(1)
                    .is_some_and(|before| shares((before, *index)))
        };
        let latest = instants.len().checked_sub(1);
        // Of those that share an instant the last, which what comes after it tells.
        let whole = (0..latest.unwrap_or(0)).rev().find(is_last);
        let alone = (0..instants.len())
            .rev()
            .find(is_alone)
            .or(whole)
            .or(latest);
        found.extend(alone.filter(|alone| !found.contains(alone)));
    }
    found
}

/// What one landmark tells as a return is none where another tells one in less than this part of the time: where events share an instant, which
/// of them comes first is rounding, and differs from turn to turn.
const SOONER: f64 = 0.75;

/// The others may be so many times as far apart.
const LOOSER: f64 = 10.0;

/// The instants of the latest return nearer than `near`; otherwise how near the nearest is. The last instant may have more to tell, such
/// as the surface that a reset takes the state across, and then is like none before it.
pub(super) fn latest_return(
    workshop: &Workshop,
    turns: &[Turn<f64>],
    (instants, section): (&[Instant], Option<usize>),
    near: (&[f64], f64),
) -> Result<(usize, usize), f64> {
    let found = return_among(workshop, turns, (instants, section), near);
    match (&found, instants) {
        (Err(nearest), [complete @ .., _]) if nearest.is_infinite() => {
            return_among(workshop, turns, (complete, section), near)
        }
        _ => found,
    }
}

fn return_among(
    workshop: &Workshop,
    turns: &[Turn<f64>],
    (instants, section): (&[Instant], Option<usize>),
    (sizes, near): (&[f64], f64),
) -> Result<(usize, usize), f64> {
    let mut nearest = f64::INFINITY;
    let mut found: Option<(usize, usize)> = None;
    let time = |(first, last): (usize, usize)| instants[last].time - instants[first].time;
    for last in landmarks(instants, section) {
        // What is settling is no nearer after one turn than after several.
        let near = if found.is_some() { LOOSER * near } else { near };
        let earliest = if near > NEAR[0] {
            last.saturating_sub(MOST_LOOSE)
        } else {
            0
        };
        for first in (earliest..last).rev() {
            let (a, b) = (&instants[first], &instants[last]);
            let is_alike =
                a.guard == b.guard && a.mode_after == b.mode_after && a.told.len() == b.told.len();
            if !is_alike {
                continue;
            }
            let difference = (workshop.closure).difference(turns, (&a.state, &b.state), sizes);
            // What dies out comes back to nothing, and not to where it was. Where states that nothing depends on have got to says nothing.
            let held = |index: usize| !workshop.closure.is_carried(index);
            let [before, now] = [a, b].map(|instant| size(&instant.state, held));
            let shrinks = turns.is_empty() && (before / now - 1.0).abs() > near.sqrt();
            if difference.distance <= near && !shrinks {
                if found.is_none_or(|known| time((first, last)) < SOONER * time(known)) {
                    found = Some((first, last));
                }
                break;
            }
            nearest = nearest.min(difference.distance);
        }
    }
    found.ok_or(nearest)
}
