//! Whether a branch has come back to where it began.

use crate::analysis::continuation::{Problem, Station, locate};
use crate::analysis::periodic::branch::Point;
use crate::analysis::periodic::branch::changes::holds::sequence_holds;
use crate::analysis::periodic::branch::kept::Walked;
use crate::analysis::periodic::branch::limits::{End, station_at};
use crate::analysis::periodic::branch::special::Near;
use crate::analysis::periodic::branch::walker::Walker;
use crate::analysis::periodic::cycle::itinerary::Passage;
use crate::analysis::periodic::shooting::Shooting;

/// Two orbits at one parameter that are this near, against their size, are one.
const SAME_ORBIT: f64 = 1e-8;

/// What lies between two stations is no farther from both than so many times what these are apart: steps turn by little.
const BETWEEN: f64 = 4.0;

/// What an orbit's sequence of events is.
pub(in crate::analysis::periodic) fn passages(shooting: &Shooting<f64>) -> Vec<Passage> {
    shooting.steps.iter().map(|step| step.passage).collect()
}

/// The orbit that a side began with: nodes, times and parameters, and the sequence of events.
#[derive(Clone, Copy)]
pub(in crate::analysis::periodic) struct Began<'o> {
    pub origin: &'o [f64],
    pub passages: &'o [Passage],
}

/// Where a station is, seen from an orbit.
struct Past {
    /// How far past it, along the tangent of the station.
    along: f64,
    /// How far away, against the size of the orbit.
    distance: f64,
}

impl Shooting<f64> {
    /// Where a station is, seen from an orbit whose events come in this order but for so many that it is told later. Phases may be
    /// turns further.
    fn past(&self, station: &Station, (origin, by): (&[f64], usize)) -> Option<Past> {
        let parameters = self.workshop.parameters(self.free(&station.at));
        let turns = self.workshop.closure.turns(&parameters).ok()?;
        let (sizes, scales) = (self.state_sizes(), self.scales());
        let mut past = Past {
            along: 0.0,
            distance: 0.0,
        };
        for place in station.at.len() - self.parameters()..station.at.len() {
            let gone = (station.at[place] - origin[place]) / scales[place];
            past.along += gone * station.tangent[place] / scales[place];
            past.distance = past.distance.max(gone.abs());
        }
        let count = self.steps.len();
        for k in 0..count {
            let own = (k + by) % count;
            let nodes = (self.node(origin, k), self.node(&station.at, own));
            let (rest, difference) = self.workshop.closure.apart(&turns, nodes, &sizes);
            past.distance = past.distance.max(difference.distance);
            let tangent = self.node(&station.tangent, own);
            let parts = rest.iter().zip(tangent).zip(&sizes);
            past.along += parts
                .map(|((x, by), size)| x / size * (by / size))
                .sum::<f64>();
        }
        Some(past)
    }

    /// By how many events later orbits are told that two stations lie to either side of one for, and how far before it these are.
    fn lie_around(&self, ends: (&Station, &Station), began: Began<'_>) -> Vec<(usize, (f64, f64))> {
        let own = passages(self);
        let (origin, kinds) = (began.origin, began.passages);
        let count = own.len();
        if count != kinds.len() {
            return Vec::new();
        }
        let rotations =
            (0..count).filter(|by| (0..count).all(|k| own[(k + by) % count] == kinds[k]));
        let apart = self.past(ends.1, (&ends.0.at, 0));
        let reach = apart.map_or(f64::INFINITY, |apart| BETWEEN * apart.distance);
        let passed = rotations.filter_map(|by| {
            let past = |station| self.past(station, (origin, by));
            let (before, after) = (past(ends.0)?, past(ends.1)?);
            let lies_around = before.along < 0.0 && after.along >= 0.0;
            let is_near = before.distance.min(after.distance) <= reach;
            (lies_around && is_near).then_some((by, (-before.along, -after.along)))
        });
        passed.collect()
    }
}

/// Where a branch or a curve in two parameters comes back, between two stations, to where it began: to the same orbit, told from any of its
/// events; and how far that is from the first. The parameters alone do not tell: where it began beside a fold a step goes past it, and to the
/// same side of where it began. The problem is what is solved, the equations of the orbit among it.
pub(in crate::analysis::periodic) fn returned(
    problem: &mut dyn Problem<f64>,
    shooting: &Shooting<f64>,
    (ends, step): ((&Station, &Station), f64),
    began: Began<'_>,
) -> Option<(Station, f64)> {
    let passed = shooting.lie_around(ends, began).into_iter();
    { passed }.find_map(|(by, left)| {
        let past = |station: &Station| shooting.past(station, (began.origin, by));
        let found = locate(problem, ends.0, step, left, &mut |_, station| {
            Some(-past(station)?.along)
        });
        found.filter(|(here, _)| past(here).is_some_and(|past| past.distance <= SAME_ORBIT))
    })
}

impl Walker {
    /// Where the branch comes back, between two stations, to where it began, and how far that is from the first.
    fn returns(
        &mut self,
        ends: (&Station, &Station),
        step: f64,
        began: &Walked,
    ) -> Option<(Station, f64)> {
        let known = Began {
            origin: &began.origin,
            passages: &began.passages,
        };
        let reader = self.shooting.clone();
        returned(&mut self.shooting, &reader, (ends, step), known)
            .or_else(|| self.returns_elsewhere(ends, step, began))
    }

    /// How the branch ends between two stations, if it comes back there to where it began, be it that the sequence of events breaks beyond.
    pub(in crate::analysis::periodic::branch) fn ends_where_it_began(
        &mut self,
        (from, to): (&Station, &Station),
        (step, breaks): (f64, bool),
        began: &Walked,
        here: &Point,
    ) -> Option<End> {
        let (last, ahead) = self.returns((from, to), step, began)?;
        // What breaks on the way may do so before that.
        if breaks && !sequence_holds(&mut self.shooting, &last.at) {
            return None;
        }
        self.settle(&last);
        let there = Point::new(&mut self.shooting, &last);
        let end = self.between(from, &last, ahead, (here, &there));
        let comes_back = (last.parameter_slope() > 0.0) != began.rises;
        Some(end.unwrap_or(if comes_back { End::Back } else { End::Closed }))
    }

    /// The same of an orbit that is told from one of its crossings of the section: it may come back with another of them for that one.
    /// So it does at the parameter of where it began.
    fn returns_elsewhere(
        &mut self,
        (from, to): (&Station, &Station),
        step: f64,
        began: &Walked,
    ) -> Option<(Station, f64)> {
        let value = began.origin.last().copied()?;
        let passes = (from.parameter() - value) * (to.parameter() - value) < 0.0;
        if !passes || self.shooting.other_crossings(&to.at).is_empty() {
            return None;
        }
        let (here, ahead) = station_at(&mut self.shooting, (from, to), step, value)?;
        let shooting = &self.shooting;
        let parameters = shooting.workshop.parameters(shooting.free(&here.at));
        let turns = shooting.workshop.closure.turns(&parameters).ok()?;
        let others = shooting.other_crossings(&here.at);
        let others: Vec<Vec<f64>> = others.into_iter().map(|least| least.state).collect();
        let origin = [shooting.node(&began.origin, 0).to_vec()];
        let sizes = shooting.state_sizes();
        let closure = &shooting.workshop.closure;
        let is_same = closure.share(&turns, (&others, &origin), &sizes, SAME_ORBIT);
        is_same.then_some((here, ahead))
    }

    /// What has come back along itself, by way of its mirror image, is told as far as where it turned: its special points say where.
    pub(in crate::analysis::periodic::branch) fn forget_way_back(&mut self) {
        let (all, count) = (&self.special, self.special.len());
        let near = Near::over(self.limits.range);
        let is_image = |k: usize| all[k].is_like(&all[count - 1 - k], near);
        if count > 0 && (0..count / 2).all(is_image) {
            self.points.truncate(all[count / 2].place);
            self.special.truncate(count.div_ceil(2));
        }
    }
}
