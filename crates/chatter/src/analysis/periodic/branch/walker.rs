//! One side of a branch, station by station.

use super::holds::broken;
use super::limits::{End, Limits, station_at};
use super::record::{Record, Stand, Standing, Then};
use super::special::{Seed, Special};
use super::{Point, SpecialKind};
use crate::analysis::continuation::{Curve, NewtonError, Problem, Station, StepError};
use crate::analysis::periodic::cycle::itinerary::{Passage, Step};
use crate::analysis::periodic::diary::{Diary, Told};
use crate::analysis::periodic::shooting::Shooting;
use core::ops::ControlFlow;

/// One side of a branch.
pub(in crate::analysis::periodic) struct Side {
    pub points: Vec<Point>,
    pub special: Vec<Special>,
    pub end: End,
}

impl Side {
    /// The other side, where this one was broken off or has come back: there is none.
    pub(in crate::analysis::periodic) fn without_other(&self) -> Option<Self> {
        let all = matches!(self.end, End::Interrupted | End::Closed);
        all.then(|| Self {
            points: Vec::new(),
            special: Vec::new(),
            end: self.end.clone(),
        })
    }
}

/// Two orbits at one parameter that are this near, against their size, are one.
const SAME_ORBIT: f64 = 1e-8;
/// A graze that leads back to itself this often is no way on.
const MOST_GRAZES: usize = 4_000;
/// The last correction of Newton's method is a sample of what rounding does; errors are so many of it.
pub(super) const NOISE: f64 = 16.0;
/// Close to a graze is this part of the next step.
const CLOSE: f64 = 1e-4;
/// Points nearer than this to the latest, in parts of a step, are not kept: at a border they accumulate.
const CROWDED: f64 = 1e-6;

/// After so many stations what came about is recorded.
const STATIONS_A_RECORD: usize = 64;

/// What of a side is on record.
struct Recorded {
    points: usize,
    special: usize,
    /// Stations that were made then.
    stations: usize,
}

pub(super) struct Walker {
    pub shooting: Shooting<f64>,
    pub limits: Limits,
    pub points: Vec<Point>,
    pub special: Vec<Special>,
}

/// What a step came to.
pub(super) enum Stop {
    On,
    End(End),
}

/// What an orbit's sequence of events is.
fn passages(shooting: &Shooting<f64>) -> Vec<Passage> {
    shooting.steps.iter().map(|step| step.passage).collect()
}

impl Walker {
    /// At a station that nothing was followed from yet.
    pub(super) fn begin(&mut self, station: Station) -> Stand {
        self.settle(&station);
        Stand {
            here: Point::new(&mut self.shooting, &station),
            origin: (station.at.clone(), passages(&self.shooting)),
            station,
            step: self.limits.settings().first_step,
            grazes: 0,
            made: 0,
            since_kept: f64::INFINITY,
            borders: Vec::new(),
        }
    }

    pub(super) fn walk(mut self, stand: Stand, diary: &mut Diary<'_>) -> Side {
        let Stand {
            station,
            step,
            mut here,
            origin,
            mut grazes,
            mut made,
            mut since_kept,
            ..
        } = stand;
        let mut curve = Curve::new(station, self.limits.settings());
        curve.step = step;
        self.settle(&curve.station);
        let mut recorded = Recorded {
            points: self.points.len(),
            special: self.special.len(),
            stations: made,
        };
        // At a graze multipliers have a pole: what changes its sign is looked for from close by.
        let mut at_graze = false;
        let end = loop {
            if self.points.len() >= self.limits.points || grazes > MOST_GRAZES {
                break End::Points;
            }
            if core::mem::take(&mut at_graze)
                && let Ok((close, _)) =
                    (curve.station).ahead(&mut self.shooting, CLOSE * curve.step)
            {
                self.settle(&close);
                here = Point::new(&mut self.shooting, &close);
                curve.moves(close);
            }
            let (next, step) = match curve.next(&mut self.shooting) {
                Ok(found) => found,
                Err(StepError::TooShort(error)) => {
                    // Where a crossing and the way back become one, no time is left between them.
                    let count = self.shooting.steps.len();
                    self.settle(&curve.station);
                    let before = self.shooting.clone();
                    if let Some(index) = (0..count).find(|&k| self.shooting.comes_back(k)) {
                        grazes += 1;
                        let forward = curve.station.parameter_slope();
                        let outcome = self.lose(&curve.station.clone(), index, &here.clone());
                        match self.goes_on(outcome, (&mut curve, forward), &mut here) {
                            Stop::On => {
                                at_graze = true;
                                continue;
                            }
                            Stop::End(_) => self.shooting = before,
                        }
                    }
                    grazes += 1;
                    if self.hop(&mut curve, &mut here) {
                        at_graze = true;
                        continue;
                    }
                    if self.shooting.steps.iter().any(Step::is_stretch)
                        && matches!(error, NewtonError::Left(_))
                    {
                        self.note(
                            SpecialKind::ChatterBorder,
                            &here,
                            &curve.station.at,
                            1e-13,
                            0.0,
                        );
                        break End::ChatterBorder;
                    }
                    break End::Lost(error.to_string());
                }
            };
            // The landings of the last correction belong to a point that differs by less than its square.
            let least = self.shooting.least(&next.at).unwrap_or_default();
            let broken = broken(&self.shooting, &least);
            if !broken.is_empty() {
                grazes += 1;
                let before = self.shooting.clone();
                match self.pass(&mut curve, step, broken, &mut here) {
                    Stop::On => {
                        at_graze = true;
                        if diary.tell(Told::Orbit(&here)).is_break() {
                            break End::Interrupted;
                        }
                        if self.leaves(&here) {
                            break End::Range;
                        }
                        if here
                            .impacts
                            .is_some_and(|impacts| impacts > self.limits.impacts)
                        {
                            break End::Impacts(self.limits.impacts);
                        }
                        continue;
                    }
                    Stop::End(end @ End::Lost(_)) => {
                        self.shooting = before;
                        if !self.hop(&mut curve, &mut here) {
                            break end;
                        }
                        at_graze = true;
                        continue;
                    }
                    Stop::End(end) => break end,
                }
            }
            made += 1;
            if made > 3 && self.returns((&curve.station, &next), step, &origin) {
                break End::Closed;
            }
            if let Some((contact, station, ahead)) = self.leaves_theory(&curve.station, &next, step)
            {
                self.settle(&station);
                let last = Point::new(&mut self.shooting, &station);
                if let Some(end) = self.between(&curve.station, &station, ahead, (&here, &last)) {
                    break end;
                }
                self.points.push(last);
                break End::Lost(format!(
                    "contact `{contact}` would have a restitution outside 0 <= r <= 1"
                ));
            }
            let there = Point::new(&mut self.shooting, &next);
            let edge = self.limits.beyond(there.parameter());
            if let Some(edge) = edge
                && let Some((station, step)) =
                    station_at(&mut self.shooting, (&curve.station, &next), step, edge)
            {
                self.settle(&station);
                let last = Point::new(&mut self.shooting, &station);
                if let Some(end) = self.between(&curve.station, &station, step, (&here, &last)) {
                    break end;
                }
                self.points.push(last);
                break End::Range;
            }
            if let Some(end) = self.between(&curve.station, &next, step, (&here, &there)) {
                break end;
            }
            if edge.is_some() {
                break End::Range;
            }
            self.settle(&next);
            curve.moves(next);
            self.shooting.adopt(&curve.station.at);
            here = there;
            since_kept += step;
            if since_kept > CROWDED * self.limits.longest_step {
                self.points.push(here.clone());
                since_kept = 0.0;
            }
            let broken_off = diary.tell(Told::Orbit(&here)).is_break();
            if broken_off || made >= recorded.stations + STATIONS_A_RECORD {
                let stand = Stand {
                    station: curve.station.clone(),
                    step: curve.step,
                    here: here.clone(),
                    origin: origin.clone(),
                    grazes,
                    made,
                    since_kept,
                    borders: Vec::new(),
                };
                let standing = Standing::of(&self.shooting, &stand);
                let kept = self.record(&mut recorded, Then::On(Box::new(standing)), diary);
                recorded.stations = made;
                if broken_off || kept.is_break() {
                    break End::Interrupted;
                }
            }
        };
        if end != End::Interrupted {
            // What cannot be kept is broken off.
            let kept = self.record(&mut recorded, Then::Ended(end.clone()), diary);
            if kept.is_break() {
                return self.side(End::Interrupted);
            }
        }
        self.side(end)
    }

    pub(super) fn side(self, end: End) -> Side {
        Side {
            points: self.points,
            special: self.special,
            end,
        }
    }

    /// Tells of what came about since the record before.
    fn record(
        &self,
        recorded: &mut Recorded,
        then: Then,
        diary: &mut Diary<'_>,
    ) -> ControlFlow<()> {
        let new = (
            &self.points[recorded.points..],
            &self.special[recorded.special..],
        );
        let record = Record::new(&self.shooting.workshop.system, new, then);
        (recorded.points, recorded.special) = (self.points.len(), self.special.len());
        diary.tell(Told::Record(&record))
    }

    /// Whether the branch comes back, between two stations, to where it began: to the same orbit, told from any of its events.
    fn returns(
        &mut self,
        (from, to): (&Station, &Station),
        step: f64,
        (origin, kinds): &(Vec<f64>, Vec<Passage>),
    ) -> bool {
        let own = passages(&self.shooting);
        let target = origin[origin.len() - 1];
        let between = (from.parameter() - target) * (to.parameter() - target) <= 0.0;
        if !between || own.len() != kinds.len() {
            return false;
        }
        let Some((here, _)) = station_at(&mut self.shooting, (from, to), step, target) else {
            return false;
        };
        let shooting = &self.shooting;
        let parameters = shooting.workshop.parameters(shooting.free(&here.at));
        let Ok(turns) = shooting.workshop.closure.turns(&parameters) else {
            return false;
        };
        let sizes = shooting.state_sizes();
        let count = own.len();
        (0..count).any(|by| {
            let same = (0..count).all(|k| own[(k + by) % count] == kinds[k]);
            // Phases may be turns further.
            let near = |k: usize| {
                let nodes = (
                    shooting.node(origin, k),
                    shooting.node(&here.at, (k + by) % count),
                );
                let difference = shooting.workshop.closure.difference(&turns, nodes, &sizes);
                difference.distance <= SAME_ORBIT
            };
            same && (0..count).all(near)
        })
    }

    /// The landings of a station, which trials may have overwritten.
    pub(super) fn settle(&mut self, station: &Station) {
        let _ = self.shooting.evaluate(&station.at);
    }

    fn leaves(&self, point: &Point) -> bool {
        self.limits.beyond(point.parameter()).is_some()
    }

    pub(super) fn note(
        &mut self,
        kind: SpecialKind,
        point: &Point,
        at: &[f64],
        error: f64,
        residual: f64,
    ) {
        self.special.push(Special {
            kind,
            point: point.clone(),
            error,
            residual,
            persists: None,
            above: None,
            monitor: None,
            place: self.points.len(),
            seed: Some(Seed {
                shooting: self.shooting.clone(),
                at: at.to_vec(),
            }),
        });
    }
}
