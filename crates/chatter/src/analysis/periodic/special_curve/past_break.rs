//! On past where the sequence of events changes in another way, as where an impact begins to come, or to leave, on the other side of a corner of
//! the force: beyond, the curve is begun anew from the orbit that the motion has there.

use super::Known;
use super::follower::Follower;
use super::past_touch::{Onward, holds, side_that_holds};
use super::start::{Begun, Grazed, begin_at_graze};
use crate::analysis::continuation::{Condition as Row, Curve, Problem, Station, newton};
use crate::analysis::periodic::branch::{SpecialKind, VANISHED, legal, moved};
use crate::analysis::periodic::closure::Closure;
use crate::analysis::periodic::condition::{Bordered, Condition};
use crate::analysis::periodic::cycle::itinerary::{Passage, Step};
use crate::analysis::periodic::shooting::Shooting;
use crate::numerics::{Complex, dot};

/// So far beyond such a place orbits are looked for, in parts of the longest step, …
const BEYOND: [f64; 6] = [1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1];
/// … and the curve is no farther from it than so many times that.
const NEAR: f64 = 10.0;
/// Where the curve turns back at such a place orbits of the other sequence are so far from those that were looked for, in that way.
const ASIDE_OF_CORNER: [f64; 4] = [1.0, 2.0, 4.0, 8.0];
/// The motion is followed so far beside the curve of a graze, against that way.
const ASIDE: [f64; 2] = [0.1, 10.0];
/// Without a way that takes no time its unknowns are within so much of where they were, against their sizes.
const NEAR_ONTO: f64 = 1e-4;
/// Two such places this near, or one that nothing leads on from, in parts of the parameters' sizes, are one: the curve has turned back.
const SAME: f64 = 1e-8;
/// The curve stands still in the plane of parameters where no more than this part of its direction lies there, or, at a place that is told from
/// it, than this.
const STANDS: f64 = 0.1;
const AT_REST: f64 = 1e-4;
/// Multipliers jump where they change by so many times what they change by on as long a way before, and by more than rounding.
const JUMPS: f64 = 100.0;
const ROUNDING: f64 = 1e-9;

impl Follower {
    /// Where the sequence of events changes at a station: on with what the motion shows beyond. The place is told (`touch`) if multipliers jump
    /// there, with what is left there of what vanishes, and how that changes along the curve; without that it is told already.
    pub(super) fn past_break(
        &mut self,
        curve: &mut Curve,
        (station, bordered): (&Station, &Bordered),
        vanishes: Option<(f64, f64)>,
    ) -> Option<Bordered> {
        let free = self.shooting.free(&station.at).to_vec();
        if self.has_passed(&free) {
            return None;
        }
        self.shooting.evaluate(&station.at).ok()?;
        // Where something shrinks to nothing the curve stands still in the plane of parameters: on over these alone.
        let over = self.over_the_parameters(station);
        let ways = || [Some(station), over.as_ref()].into_iter().flatten();
        let found = BEYOND.iter().find_map(|part| {
            let distance = part * self.limits.longest_step;
            ways().find_map(|way| Some((self.begun_beyond(way, distance)?, distance)))
        });
        let Some((onward, distance)) = found else {
            self.passed = Some((free, 0));
            return None;
        };
        if let Some(vanishes) = vanishes
            && self.multipliers_jump((station, bordered), &onward, distance)
        {
            self.note(SpecialKind::Touch, station, vanishes);
        }
        let anew = self.goes_on(onward, curve);
        self.passed = Some((free, self.points.len()));
        Some(anew)
    }

    /// Whether the sequence of events has changed at such parameters just now: the curve has turned back. Nor is it followed where no step leads on
    /// from one such place to the next.
    fn has_passed(&self, free: &[f64]) -> bool {
        let sizes = &self.shooting.workshop.sizes;
        (self.passed.as_ref()).is_some_and(|(known, points)| {
            moved(known, free, sizes) <= SAME || self.points.len() <= *points
        })
    }

    /// Where the way over a surface and back, to slide along it from there, takes no time any more at a station: on without it. Nothing happens to
    /// the orbit there, but with that way the equations have a second solution, in which it never takes any.
    pub(super) fn past_way_onto(
        &mut self,
        curve: &mut Curve,
        station: &Station,
    ) -> Option<Bordered> {
        let count = self.shooting.steps.len();
        let left = |station: &Station, index: usize| {
            let place = self.shooting.duration_place(index)?;
            station.at.get(place).copied()
        };
        // One that has just come in grows.
        let is_over = |&index: &usize| {
            self.shooting.has_come_back(&station.at, index)
                && left(station, index) <= left(&curve.station, index)
        };
        let index = (0..count).find(is_over)?;
        let free = self.shooting.free(&station.at).to_vec();
        if self.has_passed(&free) {
            return None;
        }
        let shorter = self.shooting.without_way_onto(&station.at, index);
        let (shorter, guess, _) = shorter.ok()?;
        let (mut onward, _) = self.leads_on(shorter, (&guess, NEAR_ONTO), &BEYOND)?;
        onward.shooting.evaluate(&onward.station.at).ok()?;
        let anew = self.goes_on(onward, curve);
        self.passed = Some((free, self.points.len()));
        Some(anew)
    }

    /// A direction's part in the plane of parameters, against their sizes.
    fn in_parameters(&self, station: &Station) -> Vec<f64> {
        let tangent = self.shooting.free(&station.tangent).iter();
        let parts = tangent.zip(&self.shooting.workshop.sizes);
        parts.map(|(by, size)| by / size).collect()
    }

    /// Where a curve all but stands still in the plane of parameters: the station from which it goes on in its direction there.
    fn over_the_parameters(&self, station: &Station) -> Option<Station> {
        let parts = self.in_parameters(station);
        let length = dot(&parts, &parts).sqrt();
        if !(length > 0.0 && length < STANDS) {
            return None;
        }
        let mut tangent = vec![0.0; station.tangent.len()];
        let free = tangent.len() - parts.len();
        let onto = tangent[free..].iter_mut();
        for (by, own) in onto.zip(self.shooting.free(&station.tangent)) {
            *by = own / length;
        }
        Some(Station {
            tangent,
            ..station.clone()
        })
    }

    /// The time that comes to nothing soonest along a curve, and how it changes with the parameters.
    pub(super) fn shrinks(&self, station: &Station) -> (f64, f64) {
        let parts = self.in_parameters(station);
        let length = dot(&parts, &parts).sqrt();
        let places = (0..self.shooting.steps.len())
            .filter_map(|index| self.shooting.duration_place(index))
            .filter(|&place| station.tangent[place] < 0.0);
        let left = places.map(|place| (station.at[place].abs(), station.tangent[place] / length));
        let soonest = left.min_by(|a, b| (a.0 / a.1.abs()).total_cmp(&(b.0 / b.1.abs())));
        soonest.unwrap_or((station.residual, 1.0))
    }

    /// Whether a time has all but come to nothing where the curve stands still in the plane of parameters: as it is in them to its square
    /// beside the place.
    pub(super) fn has_shrunk(&self, station: &Station) -> bool {
        let parts = self.in_parameters(station);
        let stands = dot(&parts, &parts).sqrt() < AT_REST;
        let most = VANISHED * self.shooting.period();
        let mut places = (0..self.shooting.steps.len())
            .filter(|&index| !self.shooting.is_way_back(index))
            .filter_map(|index| self.shooting.duration_place(index));
        stands && places.any(|place| station.at[place] <= most && station.tangent[place] < 0.0)
    }

    /// The curve so far beyond a station, with another sequence of events.
    fn begun_beyond(&self, station: &Station, distance: f64) -> Option<Onward> {
        let guess: Vec<f64> = (station.at.iter().zip(&station.tangent))
            .map(|(x, by)| x + by * distance)
            .collect();
        let steps = self.shooting.current_steps(&guess);
        let own = Beside {
            grazed: self.grazing.and_then(|grazing| {
                let step = &steps[grazing];
                Some((step.impact()?, grazing, step.duration))
            }),
            shooting: self.shooting.clone(),
            at: guess,
        };
        let goes_on = |begun: Begun| self.goes_on_from(begun, station, distance);
        let of_motion = |beside: &Beside| self.begun_from(beside).and_then(goes_on);
        let found = (self.up_to_graze(&own).into_iter()).find_map(goes_on);
        let found = found.or_else(|| of_motion(&own));
        found.or_else(|| (self.beside_graze(&own, distance).iter()).find_map(of_motion))
    }

    /// Orbits beside a graze, which pass the contact by on one of its sides: those of the equations without the impact, as well as they
    /// are solved. (What hits with a little rate soon is elsewhere.)
    fn beside_graze(&self, own: &Beside, distance: f64) -> Vec<Beside> {
        let Some((contact, grazing, into)) = own.grazed else {
            return Vec::new();
        };
        let Ok((shorter, start, merged)) = self.shooting.without_event(&own.at, grazing) else {
            return Vec::new();
        };
        let free = start.len() - shorter.parameters();
        let size = self.shooting.workshop.sizes[0];
        let aside = ASIDE.into_iter().flat_map(|part| [part, -part]);
        let beside = aside.map(|part| {
            let (mut shooting, mut at) = (shorter.clone(), start.clone());
            at[free] += part * distance * size;
            let held = Row::held(&at, free..at.len());
            if let Ok(found) = newton(&mut shooting, &at, &held) {
                at = found.at;
            }
            let _ = shooting.evaluate(&at);
            Beside {
                shooting,
                at,
                grazed: Some((contact, merged, into)),
            }
        });
        beside.collect()
    }

    /// The curve that the motion shows from such an orbit.
    fn begun_from(&self, beside: &Beside) -> Option<Begun> {
        let (shooting, at) = (&beside.shooting, &beside.at);
        let workshop = &shooting.workshop;
        let free = shooting.free(at).to_vec();
        let node = beside.best_node()?;
        let closed = shooting.closed_before(node);
        let state = legal(workshop, &free, (closed, shooting.node(at, node)))?;
        let steps = shooting.current_steps(at);
        let grazed = beside.grazed.map(|(contact, step, into)| {
            let way = (step + steps.len() - node) % steps.len();
            let before = (0..way).map(|k| steps[(node + k) % steps.len()].duration);
            Grazed {
                contact,
                time: before.sum::<f64>() + into,
            }
        });
        let monitor = match self.condition {
            Condition::Monitor(index) => index.checked_sub(shooting.user_function(0)),
            Condition::Singular(_) => None,
        };
        // The period of a forcing changes with the parameters.
        let turns = workshop.closure.turns(&workshop.parameters(&free)).ok()?;
        let lap = Closure::time_of(&turns, &shooting.counts);
        let known = Known {
            kind: self.kind,
            monitor: monitor.filter(|_| self.kind == SpecialKind::Monitor),
            state,
            period: lap.map_or_else(
                || steps.iter().map(|step| step.duration).sum(),
                |lap| lap.time,
            ),
        };
        begin_at_graze(workshop, &free, (&known, grazed)).ok()
    }

    /// The curve from there on, if it has another sequence of events, as many impacts, and begins where this one ends.
    fn goes_on_from(&self, begun: Begun, station: &Station, distance: f64) -> Option<Onward> {
        let Begun {
            shooting: mut beyond,
            at,
            condition,
            grazing,
        } = begun;
        let own = &self.shooting;
        let is_other =
            beyond.impacts() == own.impacts() && !same_sequence(&own.steps, &beyond.steps);
        if !is_other {
            return None;
        }
        beyond.told.clone_from(&own.told);
        let sizes = &own.workshop.sizes;
        let bordered = condition.near(&mut beyond, &at, None).ok()?;
        let there = Station::near(&mut bordered.of(&mut beyond), &at, at.len() - 1).ok()?;
        let gone = |shooting: &Shooting<f64>, to: &Station| -> Vec<f64> {
            let parts = shooting.free(&to.at).iter().zip(own.free(&station.at));
            (parts.zip(sizes))
                .map(|((to, from), size)| (to - from) / size)
                .collect()
        };
        let there = match holds(&mut beyond, &at, grazing) {
            true => {
                let along = beyond.free(&there.tangent).iter().zip(sizes);
                let along: Vec<f64> = along.map(|(by, size)| by / size).collect();
                match dot(&along, &gone(&beyond, &there)) < 0.0 {
                    true => there.reversed(),
                    false => there,
                }
            }
            // The curve has a corner there, and may turn back in the parameter: it goes on where its events come in that order.
            false => {
                let distances = ASIDE_OF_CORNER.map(|part| part * distance);
                let known = (&mut beyond, &bordered);
                side_that_holds(known, &there, grazing, &distances)?.0
            }
        };
        let gone = gone(&beyond, &there);
        if gone.iter().any(|part| part.abs() > NEAR * distance) {
            return None;
        }
        if !self.limits.hold(&there) {
            return None;
        }
        beyond.evaluate(&there.at).ok()?;
        Some(Onward {
            shooting: beyond,
            condition,
            grazing,
            bordered,
            station: there,
        })
    }

    /// Whether multipliers beyond are not those that the curve came to a station with.
    fn multipliers_jump(
        &mut self,
        (station, bordered): (&Station, &Bordered),
        onward: &Onward,
        distance: f64,
    ) -> bool {
        let own = self.shooting.clone();
        let here = self.multipliers_at(station);
        let before = station
            .clone()
            .reversed()
            .ahead(&mut bordered.of(&mut self.shooting), distance);
        let before = before.map(|(before, _)| self.multipliers_at(&before));
        self.shooting = onward.shooting.clone();
        let grazing = core::mem::replace(&mut self.grazing, onward.grazing);
        let beyond = self.multipliers_at(&onward.station);
        self.grazing = grazing;
        self.shooting = own;
        let usual = before.map_or(0.0, |before| apart(&before, &here));
        apart(&beyond, &here) > JUMPS * usual + ROUNDING
    }

    fn multipliers_at(&mut self, station: &Station) -> Vec<Complex> {
        match self.shooting.evaluate(&station.at) {
            Ok(_) => self.told(station).multipliers,
            Err(_) => Vec::new(),
        }
    }
}

/// An orbit that the motion is followed from, and of a graze the contact, the step on which it is, and how long after its start.
pub(super) struct Beside {
    pub shooting: Shooting<f64>,
    pub at: Vec<f64>,
    pub grazed: Option<(usize, usize, f64)>,
}

impl Beside {
    /// The node to follow the motion from: after the fastest impact, or where the longest flight begins.
    pub(super) fn best_node(&self) -> Option<usize> {
        let shooting = &self.shooting;
        let steps = shooting.current_steps(&self.at);
        let rate = |node: usize| {
            let before = shooting.before(node);
            let hits = steps[before].impact().is_some();
            let landing = shooting.latest.get(before).filter(|_| hits);
            landing.map_or(0.0, |landing| landing.surface_rate.abs())
        };
        let nodes = (0..steps.len()).filter(|&node| !steps[node].is_at_once());
        nodes.max_by(|&a, &b| {
            let lasts = steps[a].duration.total_cmp(&steps[b].duration);
            rate(a).total_cmp(&rate(b)).then(lasts)
        })
    }
}

/// How far multipliers are from the nearest of others, where those that are not told are zero.
fn apart(all: &[Complex], others: &[Complex]) -> f64 {
    let zero = [Complex { re: 0.0, im: 0.0 }];
    let one_way = |all: &[Complex], others: &[Complex]| {
        let nearest = |m: &Complex| {
            let off = others.iter().chain(&zero);
            let off = off.map(|o| (m.re - o.re).hypot(m.im - o.im));
            off.fold(f64::INFINITY, f64::min)
        };
        all.iter().map(nearest).fold(0.0, f64::max)
    };
    one_way(all, others).max(one_way(others, all))
}

/// Whether two orbits go through the same legs, from wherever they are told.
fn same_sequence(own: &[Step], others: &[Step]) -> bool {
    let count = |steps: &[Step], passage: Passage| {
        steps.iter().filter(|step| step.passage == passage).count()
    };
    own.len() == others.len()
        && (own.iter()).all(|step| count(own, step.passage) == count(others, step.passage))
}
