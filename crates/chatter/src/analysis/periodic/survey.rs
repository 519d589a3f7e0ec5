//! All that hangs together over a range of a parameter: a branch, those beyond the borders at its ends, and those that leave at its
//! special points.

use super::aside::Aside;
use super::branch::{Branch, End, Limits, Near, Point, Special, SpecialKind, follow};
use super::cycle::settle::Patience;
use super::diary::Diary;
use super::error::PeriodicError;
use super::orbit::settled;
use super::shooting::{Shooting, Workshop};
use crate::analysis::continuation::{Singular, Station};
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
/// Where none is found there, at these parts of what is left of the range.
const FARTHER: [f64; 4] = [0.1, 0.2, 0.4, 0.7];
/// Which way the parameter goes at an end so many points before it tell.
const BACK: usize = 60;
/// Borders that are passed in one survey.
const MOST_HOPS: usize = 8;
/// Where fewer impacts than these come to nothing they do not accumulate at a border, beyond which chatter is complete: a lone one may
/// be that of a part left to itself.
const ACCUMULATES: u64 = 4;
/// The first displacement along a branch that leaves another, against the size of the orbit.
const ASIDE: f64 = 2e-3;

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
            let wants_infinite = match way.end {
                End::Impacts(_) => true,
                End::Rounding(impacts) => impacts >= ACCUMULATES,
                _ => false,
            };
            let crosses = wants_infinite || way.end == End::ChatterBorder;
            if !crosses || hops >= MOST_HOPS {
                continue;
            }
            let (low, high) = limits.range;
            let left = match way.direction > 0.0 {
                true => high - way.value,
                false => way.value - low,
            };
            // Arcs may lie to both sides of the border that they accumulate at, and say nothing of where chatter is complete.
            let sides = match wants_infinite {
                true => &[way.direction, -way.direction][..],
                false => &[way.direction][..],
            };
            let near = HOPS.iter().flat_map(|part| {
                let hop = part * (high - low);
                sides.iter().map(move |side| side * hop)
            });
            let far = FARTHER.iter().map(|part| way.direction * part * left);
            for ahead in near.chain(far) {
                let beyond = way.value + ahead;
                if beyond < limits.range.0 || beyond > limits.range.1 {
                    continue;
                }
                let mut quiet = |_: f64| ControlFlow::Continue(());
                let Ok(orbit) = settled(workshop, &[beyond], state, patience, &mut quiet) else {
                    continue;
                };
                let fits = orbit.impacts.is_none() == wants_infinite
                    && orbit
                        .impacts
                        .is_none_or(|impacts| impacts <= limits.impacts)
                    && (!wants_infinite || is_as_long(orbit.period.to_f64(), way.period));
                if !fits {
                    continue;
                }
                let told = (beyond, orbit.impacts, orbit.period.to_f64());
                if !is_known(&branches, told) {
                    let found = follow(&orbit.shooting, &orbit.at, limits, diary)?;
                    let is_broken_off = found.ends.contains(&End::Interrupted);
                    // Complete chatter that is there, and is not what the border parts from these arcs, does not continue them.
                    if wants_infinite && !(is_broken_off || comes_to(&found, &way, ahead.abs())) {
                        continue;
                    }
                    hops += 1;
                    add(&mut branches, found, limits);
                }
                break;
            }
        }
        next += 1;
    }
    leave(&mut branches, (limits, beside), diary)?;
    Ok(branches)
}

/// An end of a branch.
struct Way {
    end: End,
    value: f64,
    /// The period there.
    period: f64,
    /// To which side the parameter went.
    direction: f64,
}

/// How each end came about, and where.
fn ends(branch: &Branch) -> Vec<Way> {
    let backwards: Vec<&Point> = branch.points.iter().rev().collect();
    let forwards: Vec<&Point> = branch.points.iter().collect();
    let both = [(&branch.ends[0], forwards), (&branch.ends[1], backwards)];
    let ways = both.into_iter().map(|(end, points)| way(end, &points));
    ways.flatten().collect()
}

/// An end, with the points from there on.
fn way(end: &End, points: &[&Point]) -> Option<Way> {
    let last = points.first()?;
    let back = points.get(points.len().min(BACK) - 1)?;
    Some(Way {
        end: end.clone(),
        value: last.parameter(),
        period: last.period,
        direction: if last.parameter() > back.parameter() {
            1.0
        } else {
            -1.0
        },
    })
}

/// Periods to both sides of a border are the same there, and differ by no more than this part of them within a hop.
const AS_LONG: f64 = 0.3;
/// What continues a branch beyond a border comes back to it: as near as this part of how far beyond it was looked for.
const COMES_BACK: f64 = 0.1;

fn is_as_long(one: f64, other: f64) -> bool {
    (one - other).abs() <= AS_LONG * other
}

/// Whether a branch that was found so far beyond an end of another comes to that end, where chatter ends, or impacts accumulate.
fn comes_to(found: &Branch, way: &Way, ahead: f64) -> bool {
    let accumulates =
        |end: &End| matches!(end, End::ChatterBorder | End::Impacts(_) | End::Rounding(_));
    ends(found).iter().any(|other| {
        // Up to a number of impacts arcs come near to the border, and no farther.
        let is_short = [&other.end, &way.end]
            .iter()
            .any(|end| matches!(end, End::Impacts(_)));
        let part = if is_short { 1.0 } else { COMES_BACK };
        accumulates(&other.end)
            && (other.value - way.value).abs() <= part * ahead
            && is_as_long(other.period, way.period)
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
        let special = branches[index].special.clone();
        for special in &special {
            let (sign, deeper) = match special.kind {
                SpecialKind::PeriodDoubling if doublings < beside.doublings => {
                    (-1.0, (doublings + 1, branch_points))
                }
                SpecialKind::BranchPoint if branch_points < beside.branch_points => {
                    (1.0, (doublings, branch_points + 1))
                }
                _ => continue,
            };
            let is_passed =
                |known: &Special| known.kind == special.kind && known.shares_orbit(special, near);
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
                if !add(branches, branch, limits) {
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

/// Whether two branches that have such special points for one orbit meet there: each is what leaves the other.
fn meet(one: &Special, other: &Special) -> bool {
    let kinds = [one.kind, other.kind];
    kinds.iter().all(|kind| is_left_at(*kind)) && kinds.contains(&SpecialKind::BranchPoint)
}

/// Whether other branches leave there.
const fn is_left_at(kind: SpecialKind) -> bool {
    matches!(kind, SpecialKind::BranchPoint | SpecialKind::PeriodDoubling)
}

/// An orbit on the branch that leaves another at a special point: once, or twice around it.
fn leaving(special: &Special, sign: f64) -> Option<(Shooting<f64>, Vec<f64>)> {
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
        let (next, _) = there.ahead(&mut shooting, ASIDE).ok()?;
        shooting.adopt(&next.at);
        return Some((shooting, next.at));
    }
    let singular = Singular::near(&mut shooting, &seed.at, sign).ok()?;
    let mut aside = Aside::new(&shooting, &seed.at, &singular, ASIDE)?;
    let at = aside.close(&[])?;
    Some((aside.shooting, at))
}
