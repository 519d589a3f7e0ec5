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
        let ends: Vec<(End, f64, f64)> = ends(&branches[next]);
        for (end, value, direction) in ends {
            let wants_infinite = match end {
                End::Impacts(_) => true,
                End::Rounding(impacts) => impacts >= ACCUMULATES,
                _ => false,
            };
            let crosses = wants_infinite || end == End::ChatterBorder;
            if !crosses || hops >= MOST_HOPS {
                continue;
            }
            let (low, high) = limits.range;
            let left = match direction > 0.0 {
                true => high - value,
                false => value - low,
            };
            let near = HOPS.iter().map(|part| part * (high - low));
            for ahead in near.chain(FARTHER.iter().map(|part| part * left)) {
                let beyond = value + direction * ahead;
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
                        .is_none_or(|impacts| impacts <= limits.impacts);
                if !fits {
                    continue;
                }
                if !is_known(&branches, beyond, orbit.impacts) {
                    hops += 1;
                    let found = follow(&orbit.shooting, &orbit.at, limits, diary)?;
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

/// How each end came about, where it is, and to which side the parameter went.
fn ends(branch: &Branch) -> Vec<(End, f64, f64)> {
    let value = |point: Option<&Point>| point.map(Point::parameter);
    let mut found = Vec::new();
    let points = &branch.points;
    let count = points.len();
    let trend = |a: Option<f64>, b: Option<f64>| match (a, b) {
        (Some(a), Some(b)) if b > a => 1.0,
        _ => -1.0,
    };
    if let Some(first) = value(points.first()) {
        let back = value(points.get(count.min(60) - 1));
        found.push((branch.ends[0].clone(), first, trend(back, Some(first))));
    }
    if let Some(last) = value(points.last()) {
        let back = value(points.get(count.saturating_sub(60)));
        found.push((branch.ends[1].clone(), last, trend(back, Some(last))));
    }
    found
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

/// Whether a branch is known to have such an orbit there.
fn is_known(branches: &[Branch], value: f64, impacts: Option<u64>) -> bool {
    branches.iter().any(|branch| {
        branch.points.windows(2).any(|pair| {
            let (a, b) = (pair[0].parameter(), pair[1].parameter());
            pair[0].impacts == impacts && a.min(b) <= value && value <= a.max(b)
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
