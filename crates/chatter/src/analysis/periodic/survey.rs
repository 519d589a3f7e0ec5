//! All that hangs together over a range of a parameter: a branch, those beyond the borders at its ends, and those that leave at its
//! special points.

use super::aside::Aside;
use super::branch::{
    ACCUMULATES, Branch, End, Limits, Near, Point, Seed, Special, SpecialKind, Wanted, beside,
    follow, sequence_holds,
};
use super::cycle::itinerary::Step;
use super::cycle::settle::Patience;
use super::cycle::settle::cycle::Cycle;
use super::diary::Diary;
use super::error::PeriodicError;
use super::orbit::{Orbit, settled_if};
use super::shooting::{Shooting, Workshop};
use crate::analysis::continuation::{Problem, Singular, Station};
use crate::numerics::Real;
use core::ops::ControlFlow;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// What is followed beside the first branch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Beside {
    /// Branches that leave at period doublings are followed to this depth, …
    pub doublings: usize,
    /// … and those that leave at branch points.
    pub branch_points: usize,
}

/// Beyond a border orbits are looked for at these parts of the range.
const HOPS: [f64; 7] = [0.05, 0.02, 0.01, 3e-3, 1e-3, 3e-4, 1e-4];
/// The motion beside a border is asked ever closer to it, by this factor, as near as this.
const CLOSER: f64 = 0.7;
const CLOSEST: f64 = 1e-6;
/// Where none is found there, at these parts of what is left of the range.
const FARTHER: [f64; 4] = [0.1, 0.2, 0.4, 0.7];
/// Arcs beside a border are looked for up to so many impacts, or more if more are followed: those of fewer may be far from it.
const BESIDE_BORDER: u64 = 40;
/// Which way the parameter goes at an end so many points before it tell.
const BACK: usize = 60;
/// Borders that are passed in one survey.
const MOST_HOPS: usize = 8;
/// What settles beyond a border may be told as so many times around an orbit.
const MOST_AROUND: f64 = 4.0;
/// So many branches are followed to see whether they come to a border.
const MOST_TRIED: usize = 6;
/// The first displacements along a branch that leaves another, against the size of the orbit: the farthest at which the solution is a motion.
const ASIDE: [f64; 4] = [2e-3, 4e-4, 8e-5, 1.6e-5];

/// The branches, the first through the orbit at a solution.
pub(crate) fn survey(
    workshop: &Arc<Workshop>,
    (shooting, at): (&Shooting<f64>, &[f64]),
    (limits, beside): (&Limits, Beside),
    (state, patience): (&[f64], Patience),
    diary: &mut Diary<'_>,
) -> Result<Vec<Branch>, PeriodicError> {
    let mut branches = vec![follow(shooting, at, limits, diary)?];
    let mut next = 0;
    let mut hops = 0;
    while next < branches.len() {
        if branches[next].ends.contains(&End::Interrupted) {
            return Ok(branches);
        }
        for way in ends(&branches[next]) {
            if !way.accumulates() || hops >= MOST_HOPS {
                continue;
            }
            let (low, high) = limits.range;
            // What was followed already may come here by itself.
            let nearest = HOPS[HOPS.len() - 1] * (high - low);
            let mut others = branches.iter().enumerate();
            if others.any(|(index, other)| index != next && comes_to(other, &way, nearest)) {
                continue;
            }
            let asked = (workshop, limits, (state, patience));
            let mut followed: Vec<Branch> = Vec::new();
            for (ahead, (shooting, at), told) in beyond(asked, &way) {
                // What is there and does not come here is no continuation, from whichever of its orbits it is followed.
                if is_known(&followed, told) {
                    continue;
                }
                // Of arcs those near to the border have as many impacts as they have.
                let wide = Limits {
                    impacts: told.1.map_or(0, |own| own + 1).max(limits.impacts),
                    ..*limits
                };
                // Where no branch begins after all what was found stays.
                let Ok(found) = follow(&shooting, &at, &wide, diary) else {
                    continue;
                };
                let is_broken_off = found.ends.contains(&End::Interrupted);
                if is_broken_off || comes_to(&found, &way, ahead.abs()) {
                    hops += 1;
                    if let Some(found) = within(found, limits.impacts) {
                        add(&mut branches, found, limits);
                    }
                    break;
                }
                followed.push(found);
                if followed.len() >= MOST_TRIED {
                    break;
                }
            }
        }
        next += 1;
    }
    leave(&mut branches, (limits, beside), diary)?;
    Ok(branches)
}

/// The part of a branch that has no more impacts a period than these, from the one end or the other.
fn within(mut branch: Branch, impacts: u64) -> Option<Branch> {
    let is_over = |point: &Point| point.impacts.is_some_and(|own| own > impacts);
    // Of several that graze at once some are told with more than these: they stay with the outermost.
    let told_at = |s: &Special| (s.place, s.told_as());
    let count = branch.points.len();
    let Some(first) = branch.points.iter().position(is_over) else {
        return Some(branch);
    };
    let last = branch.points.iter().rposition(is_over).unwrap_or(first) + 1;
    // At the graze that leads to more than these there are none yet.
    if first > 0 {
        branch.points.truncate(first);
        let is_before = |s: &Special| s.place < first || s.place == first && !is_over(&s.point);
        let outermost = branch.special.iter().rfind(|s| is_before(s)).map(told_at);
        let is_kept = |s: &Special| is_before(s) || Some(told_at(s)) == outermost;
        branch.special.retain(is_kept);
        branch.ends[1] = End::Impacts(impacts);
    } else if last < count {
        branch.points.drain(..last);
        let is_after = |s: &Special| s.place > last || s.place == last && !is_over(&s.point);
        let outermost = branch.special.iter().find(|s| is_after(s)).map(told_at);
        let is_kept = |s: &Special| is_after(s) || Some(told_at(s)) == outermost;
        branch.special.retain(is_kept);
        branch.special.iter_mut().for_each(|s| s.place -= last);
        branch.ends[0] = End::Impacts(impacts);
    } else {
        return None;
    }
    Some(branch)
}

/// Value, impacts and period of an orbit.
type Shown = (f64, Option<u64>, f64);

/// Orbits of the other kind beyond a border, complete chatter or impacts that are counted, each with how far beyond: those that the
/// motion of the orbit at the border shows beside it, and then what settles there.
fn beyond<'a>(
    (workshop, limits, (state, patience)): (&'a Arc<Workshop>, &'a Limits, (&'a [f64], Patience)),
    way: &'a Way,
) -> impl Iterator<Item = (f64, (Shooting<f64>, Vec<f64>), Shown)> + 'a {
    let wants_infinite = way.end != End::ChatterBorder;
    let (low, high) = limits.range;
    let is_inside = move |ahead: &f64| (low..=high).contains(&(way.value + ahead));
    let left = match way.direction > 0.0 {
        true => high - way.value,
        false => way.value - low,
    };
    // Arcs may lie to both sides of the border that they accumulate at, and say nothing of where chatter is complete.
    let both =
        move |part: f64| [way.direction, -way.direction].map(|side| side * part * (high - low));
    let near_border = Limits {
        impacts: limits.impacts.max(BESIDE_BORDER),
        ..*limits
    };
    let fits = move |orbit: &Orbit| {
        orbit.impacts.is_none() == wants_infinite
            && orbit
                .impacts
                .is_none_or(|impacts| impacts <= near_border.impacts)
            && is_as_long(orbit.period.to_f64(), way.period)
    };
    let near = core::iter::successors(Some(HOPS[0]), |part| Some(part * CLOSER));
    let near = near.take_while(|part| *part > CLOSEST).flat_map(both);
    let near = near.filter(is_inside);
    // Over the parameter alone, and as states go along the branch.
    let ways = [None, Some(&*way.along)].into_iter();
    let ways = ways.filter(|along| along.is_none_or(|along| !along.is_empty()));
    let by_motion = ways.flat_map(move |along| near.clone().map(move |ahead| (ahead, along)));
    let by_motion = by_motion.filter_map(move |(ahead, along)| {
        let seed = way.seed.as_ref()?;
        let distance = (way.value + ahead - seed.at.last()?) / (high - low);
        let wanted = Wanted {
            infinite: Some(wants_infinite),
            is_it: fits,
        };
        let (mut shooting, station) = beside((seed, &near_border), (distance, along), &wanted)?;
        shooting.evaluate(&station.at).ok()?;
        let told = (station.parameter(), shooting.impacts(), shooting.period());
        Some((ahead, (shooting, station.at), told))
    });
    let far = FARTHER.iter().map(move |part| way.direction * part * left);
    let anywhere = HOPS.into_iter().flat_map(both).chain(far);
    let by_settling = anywhere.filter(is_inside).filter_map(move |ahead| {
        let mut quiet = |_: f64| ControlFlow::Continue(());
        let value = way.value + ahead;
        // It may turn out to go around more than once.
        let may_fit = |cycle: &Cycle| {
            let around = (cycle.duration() / way.period).round();
            let impacts: Option<u64> = cycle.steps.iter().map(Step::impacts).sum();
            (1.0..=MOST_AROUND).contains(&around)
                && impacts.is_none_or(|all| all as f64 <= around * limits.impacts as f64)
        };
        let from = (state, patience);
        let orbit = settled_if(workshop, &[value], from, &may_fit, &mut quiet).ok()?;
        let told = (value, orbit.impacts, orbit.period.to_f64());
        fits(&orbit).then_some((ahead, (orbit.shooting, orbit.at), told))
    });
    by_motion.chain(by_settling)
}

/// An end of a branch.
struct Way {
    end: End,
    value: f64,
    /// The period there.
    period: f64,
    /// To which side the parameter went.
    direction: f64,
    /// The special point nearest to it, and the direction of the branch there, if it is known.
    seed: Option<Seed>,
    along: Vec<f64>,
    /// The latest grazes of as many different numbers of impacts, the latest first.
    grazes: Vec<f64>,
}

impl Way {
    /// Whether complete chatter ends there, or as many impacts as are followed come to nothing.
    fn accumulates(&self) -> bool {
        match self.end {
            End::ChatterBorder | End::Impacts(_) => true,
            End::Rounding(impacts) => impacts >= ACCUMULATES,
            _ => false,
        }
    }

    /// What arcs tend to, by their latest grazes, which come nearer to it in one ratio; and how far from it the latest one is.
    fn limit(&self) -> Option<(f64, f64)> {
        let [last, before, first] = self.grazes[..] else {
            return None;
        };
        // Aitken's extrapolation.
        let (step, earlier) = (last - before, before - first);
        let limit = last + step * step / (earlier - step);
        limit.is_finite().then_some((limit, (limit - last).abs()))
    }
}

/// How each end came about, and where.
fn ends(branch: &Branch) -> Vec<Way> {
    let backwards: Vec<&Point> = branch.points.iter().rev().collect();
    let forwards: Vec<&Point> = branch.points.iter().collect();
    let from_first: Vec<&Special> = branch.special.iter().collect();
    let from_last: Vec<&Special> = branch.special.iter().rev().collect();
    let both = [
        (&branch.ends[0], forwards, from_first),
        (&branch.ends[1], backwards, from_last),
    ];
    let ways = both.into_iter();
    ways.filter_map(|(end, points, special)| way(end, &points, &special))
        .collect()
}

/// An end, with the points and special points from there on.
fn way(end: &End, points: &[&Point], special: &[&Special]) -> Option<Way> {
    let last = points.first()?;
    let back = points.get(points.len().min(BACK) - 1)?;
    let nearest = special.first();
    let border = nearest
        .filter(|nearest| *end == End::ChatterBorder && nearest.kind == SpecialKind::ChatterBorder);
    let value = border.map_or(last.parameter(), |border| border.point.parameter());
    let mut grazes: Vec<(u64, f64)> = Vec::new();
    for graze in special.iter().filter(|special| special.kind.is_graze()) {
        if let Some(impacts) = graze.point.impacts
            && grazes.last().is_none_or(|(later, _)| impacts < *later)
        {
            grazes.push((impacts, graze.point.parameter()));
        }
    }
    grazes.truncate(3);
    Some(Way {
        end: end.clone(),
        value,
        period: last.period,
        direction: if last.parameter() > back.parameter() {
            1.0
        } else {
            -1.0
        },
        seed: nearest.and_then(|nearest| nearest.seed.clone()),
        along: border.map_or_else(Vec::new, |border| border.leaves.clone()),
        grazes: grazes.into_iter().map(|(_, value)| value).collect(),
    })
}

/// Periods to both sides of a border are the same there, and differ by no more than this part of them within a hop.
const AS_LONG: f64 = 0.3;
/// What continues a branch beyond a border comes back to it: as near as this part of how far beyond it was looked for.
const COMES_BACK: f64 = 0.1;
/// What grazes of arcs tend to is nearer to their border than the last of them, by this part.
const TENDS: f64 = 0.5;

fn is_as_long(one: f64, other: f64) -> bool {
    (one - other).abs() <= AS_LONG * other
}

/// Whether a branch that was found so far beyond an end of another comes to that end, where chatter ends, or impacts accumulate.
fn comes_to(found: &Branch, way: &Way, ahead: f64) -> bool {
    ends(found).iter().any(|other| {
        let kinds = [&other.end, &way.end].map(|end| *end == End::ChatterBorder);
        if !other.accumulates() || kinds[0] == kinds[1] || !is_as_long(other.period, way.period) {
            return false;
        }
        let (border, arcs) = if kinds[0] { (other, way) } else { (way, other) };
        // Up to a number of impacts, or to rounding, arcs come near to the border, and no farther: there they say what they tend to.
        let tends =
            { arcs.limit() }.map(|(limit, left)| (limit - border.value).abs() <= TENDS * left);
        let comes_back = |part: f64| (other.value - way.value).abs() <= part * ahead;
        match arcs.end {
            End::Impacts(_) => tends.unwrap_or_else(|| comes_back(1.0)),
            _ => comes_back(COMES_BACK) || tends == Some(true),
        }
    })
}

/// Adds a branch, unless it was followed before and is only reached once more: from another of its orbits, or another turn of their
/// phases. Whether it is new.
fn add(branches: &mut Vec<Branch>, found: Branch, limits: &Limits) -> bool {
    let near = Near::over(limits.range);
    let is_broken_off = found.ends.contains(&End::Interrupted);
    let is_new = is_broken_off
        || !branches
            .iter()
            .any(|b| found.shares_special(&b.special, near));
    if is_new {
        branches.push(found);
    }
    is_new
}

/// Whether a branch is known to have an orbit there with so many impacts and so long a period.
fn is_known(branches: &[Branch], (value, impacts, period): (f64, Option<u64>, f64)) -> bool {
    branches.iter().any(|branch| {
        branch.points.windows(2).any(|pair| {
            let (a, b) = (pair[0].parameter(), pair[1].parameter());
            let is_like = pair[0].impacts == impacts && is_as_long(pair[0].period, period);
            is_like && a.min(b) <= value && value <= a.max(b)
        })
    })
}

/// Follows what leaves at special points.
fn leave(
    branches: &mut Vec<Branch>,
    (limits, beside): (&Limits, Beside),
    diary: &mut Diary<'_>,
) -> Result<(), PeriodicError> {
    // Branch, and how often a branch has been left on the way to it.
    let mut open: Vec<(usize, usize, usize)> =
        (0..branches.len()).map(|index| (index, 0, 0)).collect();
    let near = Near::over(limits.range);
    let mut passed: Vec<Special> = Vec::new();
    let mut next = 0;
    while next < open.len() {
        let (index, doublings, branch_points) = open[next];
        next += 1;
        let all = branches[index].special.clone();
        for (place, special) in all.iter().enumerate() {
            // What is gone around more than once from there on is a branch that is known.
            if comes_again_at(&branches[index], place) {
                continue;
            }
            let (sign, deeper) = match special.kind {
                SpecialKind::PeriodDoubling if doublings < beside.doublings => {
                    (-1.0, (doublings + 1, branch_points))
                }
                // Where several impacts lose their rates at once orbits with others of them leave, too.
                kind if (kind == SpecialKind::BranchPoint
                    || kind.is_graze() && !special.leaves.is_empty())
                    && branch_points < beside.branch_points =>
                {
                    (1.0, (doublings, branch_points + 1))
                }
                _ => continue,
            };
            // Of what leaves at the mirror image of a point nothing is new but states.
            let is_passed = |known: &Special| {
                (known.kind == special.kind && known.shares_orbit(special, near))
                    || known.is_image_of(special, near)
            };
            // What leaves here may have come by itself: the far end of a doubled branch is a doubling of the same one again, and a
            // branch without a symmetry begins and ends where that is lost.
            let is_met =
                |known: &Special| meet(known, special) && known.shares_orbit(special, near);
            let others = branches.iter().enumerate().filter(|other| other.0 != index);
            let of_others = others.flat_map(|(_, other)| &other.special);
            if passed.iter().any(is_passed) || { of_others }.any(is_met) {
                continue;
            }
            passed.push(special.clone());
            let Some((shooting, at)) = leaving(special, sign) else {
                continue;
            };
            if let Ok(branch) = follow(&shooting, &at, limits, diary) {
                let is_over = |end: &End| matches!(end, End::Impacts(_));
                let is_nothing = branch.points.len() == 1 && branch.ends.iter().all(is_over);
                if is_nothing || !add(branches, branch, limits) {
                    continue;
                }
                open.push((branches.len() - 1, deeper.0, deeper.1));
                if matches!(branches.last(), Some(b) if b.ends.contains(&End::Interrupted)) {
                    return Ok(());
                }
            }
        }
    }
    Ok(())
}

/// Whether a branch ends at one of its special points since its orbits go more than once around those of another from there on.
fn comes_again_at(branch: &Branch, place: usize) -> bool {
    let ends = [0, branch.special.len() - 1].into_iter().zip(&branch.ends);
    let mut here = ends.filter(|(last, _)| *last == place);
    here.any(|(_, end)| *end == End::Again(branch.special[place].kind))
}

/// Whether two branches that have such special points for one orbit meet there: each is what leaves the other.
fn meet(one: &Special, other: &Special) -> bool {
    let kinds = [one.kind, other.kind];
    kinds.iter().all(|kind| is_left_at(*kind)) && kinds.contains(&SpecialKind::BranchPoint)
}

/// Whether other branches leave there.
const fn is_left_at(kind: SpecialKind) -> bool {
    matches!(kind, SpecialKind::BranchPoint | SpecialKind::PeriodDoubling)
}

/// An orbit on the branch that leaves another at a special point: once, or twice around it. Beyond where events come or go equations have
/// solutions that are no motion, and such a place may be near.
fn leaving(special: &Special, sign: f64) -> Option<(Shooting<f64>, Vec<f64>)> {
    let all = ASIDE.iter().map(|&far| leaving_by(special, sign, far));
    let motion = (all.flatten()).find_map(|(mut shooting, at)| {
        sequence_holds(&mut shooting, &at).then_some((shooting, at))
    });
    motion.or_else(|| leaving_by(special, sign, ASIDE[0]))
}

/// The same, so far aside, against the size of the orbit.
fn leaving_by(special: &Special, sign: f64, far: f64) -> Option<(Shooting<f64>, Vec<f64>)> {
    let seed = special.seed.as_ref()?;
    let mut shooting = seed.shooting.clone();
    if sign > 0.0 && special.leaves.len() == seed.at.len() {
        let there = Station {
            at: seed.at.clone(),
            tangent: special.leaves.clone(),
            residual: special.residual,
            correction: special.error,
            orientation: 1.0,
        };
        let (next, _) = there.ahead(&mut shooting, far).ok()?;
        shooting.adopt(&next.at);
        return Some((shooting, next.at));
    }
    let singular = Singular::near(&mut shooting, &seed.at, sign).ok()?;
    let mut aside = Aside::new(&shooting, &seed.at, &singular, far)?;
    let at = aside.close(&[])?;
    Some((aside.shooting, at))
}
