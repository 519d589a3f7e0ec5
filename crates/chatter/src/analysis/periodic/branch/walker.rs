//! One side of a branch, station by station.

use super::holds::broken;
use super::limits::{End, Limits, station_at};
use super::special::{Seed, Special};
use super::{Point, SpecialKind};
use crate::analysis::continuation::{Curve, NewtonError, Problem, Station, StepError};
use crate::analysis::periodic::cycle::itinerary::{Passage, Step};
use crate::analysis::periodic::shooting::Shooting;
use core::ops::ControlFlow;

/// One side of a branch.
pub(super) struct Side {
    pub points: Vec<Point>,
    pub special: Vec<Special>,
    pub end: End,
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
    pub(super) fn walk(
        mut self,
        start: Station,
        observer: &mut dyn FnMut(&Point) -> ControlFlow<()>,
    ) -> Side {
        let mut curve = Curve::new(start, self.limits.settings());
        let mut here = {
            let _ = self.shooting.evaluate(&curve.station.at);
            Point::new(&mut self.shooting, &curve.station)
        };
        let origin = (curve.station.clone(), passages(&self.shooting));
        let mut grazes = 0;
        let mut made = 0;
        let mut since_kept = f64::INFINITY;
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
                match self.pass(&mut curve, step, broken, &mut here) {
                    Stop::On => {
                        at_graze = true;
                        if observer(&here).is_break() {
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
                    Stop::End(end) => break end,
                }
            }
            made += 1;
            if made > 3 && self.returns((&curve.station, &next), step, &origin) {
                break End::Closed;
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
            if observer(&here).is_break() {
                break End::Interrupted;
            }
        };
        Side {
            points: self.points,
            special: self.special,
            end,
        }
    }

    /// Whether the branch comes back, between two stations, to where it began: to the same orbit, told from any of its events.
    fn returns(
        &mut self,
        (from, to): (&Station, &Station),
        step: f64,
        (origin, kinds): &(Station, Vec<Passage>),
    ) -> bool {
        let own = passages(&self.shooting);
        let target = origin.parameter();
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
                    shooting.node(&origin.at, k),
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
