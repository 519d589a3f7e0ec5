//! A branch of periodic orbits over a parameter, through grazes from one sequence of events to the next.
//!
//! Where a flight grazes, the orbit gains an impact: the leg is cut at its least gap, and the equations of the longer
//! sequence hold there with an impact of rate zero, which grows from then on (docs/periodic.md). Where an impact's rate falls to zero it
//! is taken out again. Neither is a decision of the flow, so neither depends on a tolerance.

use super::error::PeriodicError;
use super::itinerary::{Passage, Step};
use super::shooting::{Shooting, Workshop};
use crate::analysis::continuation::{
    Condition, Curve, Held, NewtonError, Problem, Settings, Singular, Station, StepError, locate,
    newton,
};
use crate::flow::GuardKind;
use crate::flow::leg::{Jump, Least, LegKind};
use crate::numerics::Complex;
use core::ops::ControlFlow;
use std::sync::Arc;

/// One orbit of a branch.
#[derive(Clone, Debug)]
pub struct Point {
    /// The free parameters.
    pub parameters: Vec<f64>,
    /// The period of the orbit.
    pub period: f64,
    /// Impacts a period; none where infinitely many.
    pub impacts: Option<u64>,
    /// All but the trivial one, the largest first.
    pub multipliers: Vec<Complex>,
    /// The state at the section, or just after an event.
    pub state: Vec<f64>,
    /// Largest residual of the equations.
    pub residual: f64,
    /// The latest correction against the size of the state.
    pub correction: f64,
}

impl Point {
    /// Whether all multipliers lie inside the unit circle.
    pub fn is_stable(&self) -> bool {
        self.multipliers.iter().all(|m| m.modulus() < 1.0)
    }
}

/// Kinds of special points.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SpecialKind {
    /// The parameter turns: a multiplier passes 1.
    Fold,
    /// A multiplier passes -1.
    PeriodDoubling,
    /// A complex pair passes the unit circle.
    NeimarkSacker,
    /// Two branches meet.
    BranchPoint,
    /// An impact loses its rate.
    ImpactGraze,
    /// A flight touches a contact.
    FlightGraze,
    /// Complete chatter ends exactly at release.
    ChatterBorder,
    /// Another guard is touched: contact is lost or gained for an instant, or a surface is reached.
    Touch,
}

impl SpecialKind {
    /// All kinds.
    pub const ALL: [Self; 8] = [
        Self::Fold,
        Self::PeriodDoubling,
        Self::NeimarkSacker,
        Self::BranchPoint,
        Self::ImpactGraze,
        Self::FlightGraze,
        Self::ChatterBorder,
        Self::Touch,
    ];

    /// Its name in results.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Fold => "fold",
            Self::PeriodDoubling => "period_doubling",
            Self::NeimarkSacker => "neimark_sacker",
            Self::BranchPoint => "branch_point",
            Self::ImpactGraze => "impact_graze",
            Self::FlightGraze => "flight_graze",
            Self::ChatterBorder => "chatter_border",
            Self::Touch => "touch",
        }
    }
}

/// A special point.
#[derive(Clone, Debug)]
pub struct Special {
    /// Which kind.
    pub kind: SpecialKind,
    /// The orbit there.
    pub point: Point,
    /// Estimated error of its parameter.
    pub error: f64,
    /// What vanishes there.
    pub residual: f64,
    /// Of a graze: whether the branch goes on beyond it, rather than turning back.
    pub persists: Option<bool>,
    /// Where it is on its branch: after so many points.
    pub place: usize,
    /// Its equations.
    pub(crate) seed: Option<Seed>,
}

/// Equations and a solution of them.
#[derive(Clone, Debug)]
pub(crate) struct Seed {
    pub shooting: Shooting<f64>,
    pub at: Vec<f64>,
}

/// How an end of a branch came about.
#[derive(Clone, Debug, PartialEq)]
pub enum End {
    /// The parameter left its range.
    Range,
    /// Complete chatter ends at release.
    ChatterBorder,
    /// More impacts a period than allowed: the branch accumulates at a border.
    Impacts(u64),
    /// More points than allowed.
    Points,
    /// The observer broke off.
    Interrupted,
    /// The equations have no solution beyond, for this reason.
    Lost(String),
    /// It came back to where it began.
    Closed,
}

impl core::fmt::Display for End {
    fn fmt(&self, out: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Range => write!(out, "end of the range"),
            Self::ChatterBorder => write!(out, "chatter border"),
            Self::Impacts(most) => write!(out, "more than {most} impacts a period"),
            Self::Points => write!(out, "as many points as allowed"),
            Self::Interrupted => write!(out, "broken off"),
            Self::Lost(why) => out.write_str(why),
            Self::Closed => write!(out, "where it began"),
        }
    }
}

/// A branch of periodic orbits.
#[derive(Clone, Debug)]
pub struct Branch {
    /// Its orbits, in order.
    pub points: Vec<Point>,
    /// Its special points, in order.
    pub special: Vec<Special>,
    /// How its first and last ends came about.
    pub ends: [End; 2],
}

/// Within what a branch is followed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Of the last free parameter.
    pub range: (f64, f64),
    /// Impacts a period.
    pub impacts: u64,
    /// Points of one branch, to each side.
    pub points: usize,
    /// The longest step, in parts of the range.
    pub longest_step: f64,
}

/// One side of a branch.
struct Side {
    points: Vec<Point>,
    special: Vec<Special>,
    end: End,
}

/// This part of a step before a graze.
const NOT_QUITE: f64 = 1e-5;
/// Two orbits at one parameter that are this near, against their size, are one.
const SAME_ORBIT: f64 = 1e-8;
/// Where a new sequence begins its steps, against those before.
const CAREFUL: f64 = 0.05;
/// A graze that leads back to itself this often is no way on.
const MOST_GRAZES: usize = 4_000;
/// The last correction of Newton's method is a sample of what rounding does; errors are so many of it.
const NOISE: f64 = 16.0;
/// Points nearer than this to the latest, in parts of a step, are not kept: at a border they accumulate.
const CROWDED: f64 = 1e-6;

fn settings(limits: &Limits) -> Settings {
    Settings {
        first_step: 0.1 * limits.longest_step,
        longest_step: limits.longest_step,
        ..Settings::default()
    }
}

pub(crate) fn point(shooting: &Shooting<f64>, station: &Station) -> Point {
    let infinite = shooting.steps.iter().any(Step::is_stretch);
    let impacts = (shooting.steps.iter()).filter(|step| step.impact().is_some());
    let impacts = impacts.count() as u64;
    Point {
        parameters: shooting.free(&station.at).to_vec(),
        period: shooting.period(),
        impacts: (!infinite).then_some(impacts),
        multipliers: shooting.multipliers(),
        state: shooting.node(&station.at, 0).to_vec(),
        residual: station.residual,
        correction: station.correction,
    }
}

/// The guard whose sign says that the sequence no longer holds, and its value.
#[derive(Clone, Debug, PartialEq)]
enum Broken {
    /// The event at the end of this step is approached from the wrong side.
    Event(usize),
    /// This guard has a negative least value within this step.
    Inner(usize, GuardKind),
    /// This guard vanishes before the end of this step.
    Early(usize, GuardKind),
}

impl Broken {
    /// Positive while the sequence holds.
    fn value(&self, shooting: &Shooting<f64>, least: &[Vec<Least>]) -> Option<f64> {
        let smallest = |step: usize, guard: GuardKind, at_end: bool| {
            (least.get(step)?.iter())
                .filter(|l| l.guard == guard && l.at_end == at_end)
                .map(|l| l.value)
                .min_by(f64::total_cmp)
        };
        match *self {
            Self::Event(step) => Some(-shooting.latest.get(step)?.surface_rate),
            Self::Inner(step, guard) => smallest(step, guard, false),
            Self::Early(step, guard) => smallest(step, guard, true),
        }
    }
}

/// A guard that has just opened is known to rounding only: below so much of nothing it says nothing.
const NOTHING: f64 = -1e-13;

fn broken(shooting: &Shooting<f64>, least: &[Vec<Least>]) -> Vec<Broken> {
    let mut found = Vec::new();
    for (index, step) in shooting.steps.iter().enumerate() {
        let Some(landing) = shooting.latest.get(index) else {
            continue;
        };
        if let Passage::Leg(LegKind {
            ends_at: Some(guard),
            ..
        }) = step.passage
            && !matches!(guard, GuardKind::Section(_))
            && landing.surface_rate > 0.0
        {
            found.push(Broken::Event(index));
        }
        for least in least.get(index).into_iter().flatten() {
            let known = match (least.at_end, least.value < 0.0) {
                (_, false) => continue,
                (false, true) => Broken::Inner(index, least.guard),
                // What vanishes with the event itself is left to the next step.
                (true, true) if least.value < NOTHING => Broken::Early(index, least.guard),
                (true, true) => continue,
            };
            if !found.contains(&known) {
                found.push(known);
            }
        }
    }
    found
}

/// Whether an orbit's equations are solved by what is no motion: through a wall, or with events in another order.
pub(crate) fn is_broken(
    shooting: &mut Shooting<f64>,
    at: &[f64],
) -> Result<bool, crate::analysis::continuation::Left> {
    shooting.evaluate(at)?;
    let least = shooting.least(at)?;
    Ok(!broken(shooting, &least).is_empty())
}

/// The same but for the step that grazes.
pub(crate) fn broken_at(shooting: &mut Shooting<f64>, at: &[f64], grazing: Option<usize>) -> bool {
    let Ok(least) = shooting.least(at) else {
        return true;
    };
    let graze = |broken: &Broken| match (grazing, broken) {
        (Some(index), Broken::Event(step)) => *step == index,
        // The touch itself, seen from either side of it.
        (Some(index), Broken::Inner(step, _)) => *step == index || *step == index + 1,
        _ => false,
    };
    broken(shooting, &least).iter().any(|broken| !graze(broken))
}

fn tests(multipliers: &[Complex]) -> (f64, f64) {
    // Products of real factors and of |1 + m|^2 for pairs.
    let product = |shift: f64| {
        let mut product = 1.0_f64;
        for m in multipliers {
            if m.im == 0.0 {
                product *= (shift + m.re).signum();
            }
        }
        product
    };
    let pair = (multipliers.iter())
        .filter(|m| m.im > 0.0)
        .map(|m| m.modulus() - 1.0)
        .max_by(f64::total_cmp)
        .unwrap_or(f64::NAN);
    (product(1.0), pair)
}

/// 1 + m of the multiplier nearest to -1.
fn doubling_value(multipliers: &[Complex]) -> Option<f64> {
    (multipliers.iter())
        .filter(|m| m.im == 0.0)
        .map(|m| 1.0 + m.re)
        .min_by(|a, b| a.abs().total_cmp(&b.abs()))
}

impl Shooting<f64> {
    /// The tangent of the curve at a solution of the equations and of one more row.
    fn tangent(&mut self, at: &[f64], row: &[f64]) -> Result<Vec<f64>, NewtonError> {
        let size = at.len();
        let linearised = self.evaluate(at).map_err(NewtonError::Left)?;
        let mut bordered = crate::numerics::Matrix::zeros(size, size);
        for i in 0..size - 1 {
            bordered
                .row_mut(i)
                .copy_from_slice(linearised.jacobian.row(i));
        }
        bordered.row_mut(size - 1).copy_from_slice(row);
        let factors = bordered.factored().ok_or(NewtonError::Singular)?;
        let mut right = vec![0.0; size];
        right[size - 1] = 1.0;
        let mut tangent = factors.solve(&right);
        let length = (tangent.iter().zip(self.scales()))
            .map(|(x, scale)| (x / scale) * (x / scale))
            .sum::<f64>()
            .sqrt();
        if !(length > 0.0 && length.is_finite()) {
            return Err(NewtonError::Singular);
        }
        tangent.iter_mut().for_each(|x| *x /= length);
        Ok(tangent)
    }

    /// The same orbit with an impact of rate zero where a guard has its least value on a step.
    pub(crate) fn with_event(
        &self,
        at: &[f64],
        index: usize,
        least: &Least,
    ) -> Result<(Self, Vec<f64>), PeriodicError> {
        let mut steps = self.current_steps(at);
        let Passage::Leg(kind) = steps[index].passage else {
            return Err(PeriodicError::Unfollowed {
                what: "a graze within what is followed as a whole".to_owned(),
            });
        };
        let GuardKind::Gap(contact) = least.guard else {
            return Err(PeriodicError::Unfollowed {
                what: "a guard that is touched and is no gap".to_owned(),
            });
        };
        let whole = steps[index].clone();
        let first = Step {
            passage: Passage::Leg(LegKind {
                mode: kind.mode,
                ends_at: Some(least.guard),
                jump: Jump::Impact(contact),
            }),
            duration: least.time,
            told: Vec::new(),
            closed: self.closed_before(index),
            ..whole.clone()
        };
        let second = Step {
            start: least.state.clone(),
            duration: whole.duration - least.time,
            ..whole
        };
        steps.splice(index..=index, [first, second]);
        let free = self.free(at).to_vec();
        let shooting = Self::new(&self.workshop, steps, self.counts.clone())?;
        let at = shooting.guess(&free);
        Ok((shooting, at))
    }

    /// The same orbit without the event at the end of a step, which leaves the state as it is.
    fn without_event(&self, at: &[f64], index: usize) -> Result<(Self, Vec<f64>), PeriodicError> {
        let mut steps = self.current_steps(at);
        let count = steps.len();
        let next = (index + 1) % count;
        let same_mode = matches!(
            (steps[index].passage, steps[next].passage),
            (Passage::Leg(a), Passage::Leg(b)) if a.mode == b.mode
        );
        if count < 2 || next == 0 || !same_mode {
            return Err(PeriodicError::Unfollowed {
                what: "the loss of an event between different modes".to_owned(),
            });
        }
        let merged = Step {
            start: steps[index].start.clone(),
            duration: steps[index].duration + steps[next].duration,
            ..steps[next].clone()
        };
        steps.splice(index..=next, [merged]);
        let free = self.free(at).to_vec();
        let shooting = Self::new(&self.workshop, steps, self.counts.clone())?;
        let at = shooting.guess(&free);
        Ok((shooting, at))
    }

    /// The steps with their nodes as they are at a point.
    pub(crate) fn current_steps(&self, at: &[f64]) -> Vec<Step> {
        let mut copy = self.clone();
        copy.adopt(at);
        for index in 0..copy.steps.len() {
            if let Some(place) = copy.duration_place(index) {
                copy.steps[index].duration = at[place];
            }
        }
        copy.steps
    }

    fn closed_before(&self, index: usize) -> crate::flow::Closed {
        let count = self.steps.len();
        self.steps[(index + count - 1) % count].closed
    }
}

/// Follows a branch from one of its orbits to both sides.
pub(crate) fn follow(
    workshop: &Arc<Workshop>,
    shooting: &Shooting<f64>,
    at: &[f64],
    limits: &Limits,
    observer: &mut dyn FnMut(&Point) -> ControlFlow<()>,
) -> Result<Branch, PeriodicError> {
    let _ = workshop;
    let mut sides = Vec::new();
    let mut begin = shooting.clone();
    let last = at.len() - 1;
    let station =
        Station::near(&mut begin, at, last).map_err(|error| PeriodicError::NoConvergence {
            how: error.to_string(),
        })?;
    begin
        .evaluate(&station.at)
        .map_err(|left| PeriodicError::NoConvergence {
            how: left.to_string(),
        })?;
    let first = point(&begin, &station);
    for forward in [false, true] {
        let start = if forward {
            station.clone()
        } else {
            station.clone().reversed()
        };
        let walker = Walker {
            shooting: begin.clone(),
            limits: *limits,
            points: Vec::new(),
            special: Vec::new(),
        };
        // What is broken off, or has come back, has no other side.
        let all = match sides.last() {
            Some(Side {
                end: end @ (End::Interrupted | End::Closed),
                ..
            }) => Some(end.clone()),
            _ => None,
        };
        sides.push(match all {
            Some(end) => Side {
                points: Vec::new(),
                special: Vec::new(),
                end,
            },
            None => walker.walk(start, observer),
        });
    }
    let (forward, back) = (sides.pop(), sides.pop());
    let (Some(forward), Some(mut back)) = (forward, back) else {
        return Err(PeriodicError::Interrupted);
    };
    let behind = back.points.len();
    back.points.reverse();
    back.special.reverse();
    for special in &mut back.special {
        special.place = behind - special.place;
    }
    let mut points = back.points;
    points.push(first);
    points.extend(forward.points);
    let mut special = back.special;
    special.extend(forward.special.into_iter().map(|mut special| {
        special.place += behind + 1;
        special
    }));
    Ok(Branch {
        points,
        special,
        ends: [back.end, forward.end],
    })
}

struct Walker {
    shooting: Shooting<f64>,
    limits: Limits,
    points: Vec<Point>,
    special: Vec<Special>,
}

/// What a step came to.
enum Stop {
    On,
    End(End),
}

/// What an orbit's sequence of events is.
fn passages(shooting: &Shooting<f64>) -> Vec<Passage> {
    shooting.steps.iter().map(|step| step.passage).collect()
}

impl Walker {
    fn walk(mut self, start: Station, observer: &mut dyn FnMut(&Point) -> ControlFlow<()>) -> Side {
        let mut curve = Curve::new(start, settings(&self.limits));
        let mut here = {
            let _ = self.shooting.evaluate(&curve.station.at);
            point(&self.shooting, &curve.station)
        };
        let origin = (curve.station.clone(), passages(&self.shooting));
        let mut grazes = 0;
        let mut made = 0;
        let mut since_kept = f64::INFINITY;
        // At a graze multipliers have a pole: the first step from one has no sign changes to tell.
        let mut leaves_graze = false;
        let end = loop {
            if self.points.len() >= self.limits.points || grazes > MOST_GRAZES {
                break End::Points;
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
                        leaves_graze = true;
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
            let there = point(&self.shooting, &next);
            let ended = self.leaves(&there);
            let step = if ended {
                match self.edge(&curve.station, step, &there) {
                    Some((station, edge)) => {
                        self.between(&curve.station, &station, edge, (&here, &there));
                        self.settle(&station);
                        let last = point(&self.shooting, &station);
                        self.points.push(last);
                        break End::Range;
                    }
                    None => step,
                }
            } else {
                step
            };
            if !core::mem::take(&mut leaves_graze) {
                self.between(&curve.station, &next, step, (&here, &there));
            }
            if ended {
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
        let ends = (from.parameter() - target, to.parameter() - target);
        if ends.0 * ends.1 > 0.0 || own.len() != kinds.len() {
            return false;
        }
        let found = locate(&mut self.shooting, from, step, ends, &mut |_, station| {
            Some(station.parameter() - target)
        });
        let Some((here, _)) = found else {
            return false;
        };
        let scales = self.shooting.scales();
        (0..own.len()).any(|by| {
            let same = (0..own.len()).all(|k| own[(k + by) % own.len()] == kinds[k]);
            same && {
                let turned = self.shooting.rotated(&here.at, by);
                (turned.iter().zip(&origin.at).zip(scales))
                    .all(|((a, b), scale)| (a - b).abs() <= SAME_ORBIT * scale)
            }
        })
    }

    /// The landings of a station, which trials may have overwritten.
    fn settle(&mut self, station: &Station) {
        let _ = self.shooting.evaluate(&station.at);
    }

    fn leaves(&self, point: &Point) -> bool {
        let (low, high) = self.limits.range;
        point
            .parameters
            .last()
            .is_some_and(|&p| p < low || p > high)
    }

    /// The station at the edge of the range.
    fn edge(&mut self, from: &Station, step: f64, there: &Point) -> Option<(Station, f64)> {
        let (low, high) = self.limits.range;
        let edge = if *there.parameters.last()? < low {
            low
        } else {
            high
        };
        let ends = (from.parameter() - edge, there.parameters.last()? - edge);
        locate(&mut self.shooting, from, step, ends, &mut |_, station| {
            Some(station.parameter() - edge)
        })
    }

    fn note(&mut self, kind: SpecialKind, point: &Point, at: &[f64], error: f64, residual: f64) {
        self.special.push(Special {
            kind,
            point: point.clone(),
            error,
            residual,
            persists: None,
            place: self.points.len(),
            seed: Some(Seed {
                shooting: self.shooting.clone(),
                at: at.to_vec(),
            }),
        });
    }

    /// Special points between two stations with the same sequence of events.
    fn between(
        &mut self,
        from: &Station,
        to: &Station,
        step: f64,
        (here, there): (&Point, &Point),
    ) {
        let size = from.at.len();
        let (before, after) = (from.tangent[size - 1], to.tangent[size - 1]);
        let mut kinds = Vec::new();
        if from.orientation * to.orientation < 0.0 {
            // Where branches meet, one of them may turn.
            kinds.push(SpecialKind::BranchPoint);
        } else if before * after < 0.0 {
            kinds.push(SpecialKind::Fold);
        }
        let (tests_here, tests_there) = (tests(&here.multipliers), tests(&there.multipliers));
        if tests_here.0 * tests_there.0 < 0.0 {
            kinds.push(SpecialKind::PeriodDoubling);
        }
        if tests_here.1 * tests_there.1 < 0.0 {
            kinds.push(SpecialKind::NeimarkSacker);
        }
        for kind in kinds {
            self.find(kind, from, step, (before, after), (here, there));
        }
    }

    fn find(
        &mut self,
        kind: SpecialKind,
        from: &Station,
        step: f64,
        (before, after): (f64, f64),
        (here, there): (&Point, &Point),
    ) {
        // The problem is what is evaluated; its copy tells multipliers of the stations found.
        let mut reader = self.shooting.clone();
        let mut multipliers = |station: &Station| {
            reader.evaluate(&station.at).ok()?;
            Some(reader.multipliers())
        };
        let found = match kind {
            SpecialKind::Fold => locate(
                &mut self.shooting,
                from,
                step,
                (before, after),
                &mut |_, station| station.tangent.last().copied(),
            ),
            SpecialKind::BranchPoint => {
                self.branch_point(from, step, (before, after));
                return;
            }
            SpecialKind::PeriodDoubling => {
                let value = |m: &[Complex]| {
                    let size = doubling_value(m)?.abs();
                    Some(tests(m).0 * size)
                };
                let (Some(a), Some(b)) = (value(&here.multipliers), value(&there.multipliers))
                else {
                    return;
                };
                locate(&mut self.shooting, from, step, (a, b), &mut |_, station| {
                    value(&multipliers(station)?)
                })
            }
            SpecialKind::NeimarkSacker => locate(
                &mut self.shooting,
                from,
                step,
                (tests(&here.multipliers).1, tests(&there.multipliers).1),
                &mut |_, station| {
                    let value = tests(&multipliers(station)?).1;
                    value.is_finite().then_some(value)
                },
            ),
            _ => None,
        };
        let Some((station, _)) = found else {
            return;
        };
        let rough = station.parameter();
        let mut refined = station.clone();
        let mut error = NOISE * f64::EPSILON * rough.abs();
        let mut residual = f64::NAN;
        let sign = match kind {
            SpecialKind::Fold => Some(1.0),
            SpecialKind::PeriodDoubling => Some(-1.0),
            _ => None,
        };
        if let Some(sign) = sign
            && let Ok(singular) = Singular::near(&mut self.shooting, &station.at, sign)
        {
            let mut held = Held::singular(&mut self.shooting, singular);
            if let Ok(found) = newton(&mut held, &station.at, &[]) {
                let last = found.at.len() - 1;
                let scale = held.scales()[last];
                let moved = (found.at[last] - rough).abs();
                // Nearer than where the sign changed, or something else was found.
                if moved
                    <= 1e-3
                        * (from.parameter() - there.parameters.last().copied().unwrap_or(rough))
                            .abs()
                            .max(1e-9 * scale)
                {
                    refined.at = found.at;
                    error = error.max(NOISE * found.correction * scale);
                    residual = found.residual;
                }
            }
        }
        self.settle(&refined);
        let mut here = point(&self.shooting, &refined);
        if residual.is_nan() {
            residual = match kind {
                SpecialKind::NeimarkSacker => tests(&here.multipliers).1.abs(),
                _ => refined.residual,
            };
        }
        here.correction = refined.correction;
        let at = refined.at.clone();
        self.note(kind, &here, &at, error, residual);
    }

    /// A point where branches meet. The equations are singular there, so it is found from stations around it: the
    /// polynomial through what vanishes, a multiplier less one or, on a branch that turns, the tangent's part along the
    /// parameter.
    fn branch_point(&mut self, from: &Station, step: f64, (before, after): (f64, f64)) {
        let turns = before * after < 0.0;
        let mut reader = self.shooting.clone();
        let mut value = |station: &Station| {
            if turns {
                return station.tangent.last().copied();
            }
            reader.evaluate(&station.at).ok()?;
            let found = reader.multipliers();
            (found.iter().filter(|m| m.im == 0.0))
                .map(|m| m.re - 1.0)
                .min_by(|a, b| a.abs().total_cmp(&b.abs()))
        };
        let mut ends = (0.0, step);
        let mut fit: Option<(f64, Vec<f64>)> = None;
        // Around the first root of the polynomial the next one is fitted more closely.
        for width in [1.0, 0.2, 0.04] {
            let (low, high) = match fit {
                None => ends,
                Some((root, ..)) => {
                    let half: f64 = 0.5 * width * step;
                    ((root - half).max(0.0), (root + half).min(step))
                }
            };
            ends = (low, high);
            let mut places = Vec::new();
            let mut values = Vec::new();
            let mut stations = Vec::new();
            for k in 0..FITTED {
                let angle = core::f64::consts::PI * (k as f64 + 0.5) / FITTED as f64;
                let at = 0.5 * (low + high) - 0.5 * (high - low) * libm::cos(angle);
                let Ok((station, _)) = from.ahead(&mut self.shooting, at) else {
                    continue;
                };
                let Some(here) = value(&station) else {
                    continue;
                };
                places.push(at);
                values.push(here);
                stations.push(station);
            }
            let Some(root) = root_of(&places, &values, ends) else {
                break;
            };
            let at: Vec<f64> = (0..from.at.len())
                .map(|i| {
                    let component: Vec<f64> = stations.iter().map(|s| s.at[i]).collect();
                    interpolated(&places, &component, root)
                })
                .collect();
            let earlier = fit.as_ref().map(|(_, at)| at[at.len() - 1]);
            let error = earlier.map_or(step, |earlier| (earlier - at[at.len() - 1]).abs());
            fit = Some((root, at.clone()));
            if width < 0.1 {
                let station = Station {
                    at,
                    ..stations[0].clone()
                };
                self.settle(&station);
                let here = point(&self.shooting, &station);
                let residual = interpolated(&places, &values, root).abs();
                let noise = NOISE * f64::EPSILON * station.parameter().abs();
                let at = station.at.clone();
                self.note(
                    SpecialKind::BranchPoint,
                    &here,
                    &at,
                    error.max(noise),
                    residual,
                );
            }
        }
    }

    /// Goes on past the first place where the sequence of events breaks.
    fn pass(
        &mut self,
        curve: &mut Curve,
        step: f64,
        broken: Vec<Broken>,
        here: &mut Point,
    ) -> Stop {
        let from = curve.station.clone();
        // The earliest of them along the curve.
        let mut first: Option<(Broken, Station, f64)> = None;
        for broken in broken {
            let mut reader = self.shooting.clone();
            let mut value = |station: &Station| {
                reader.evaluate(&station.at).ok()?;
                let least = reader.least(&station.at).ok()?;
                // A least value that is not there yet is one that has not been reached.
                Some(broken.value(&reader, &least).unwrap_or(1.0))
            };
            let start = value(&from).unwrap_or(1.0);
            let start = if start > 0.0 {
                start
            } else {
                f64::MIN_POSITIVE
            };
            let Ok((far, _)) = from.ahead(&mut self.shooting, step) else {
                continue;
            };
            let end = value(&far).unwrap_or(-1.0);
            let found = locate(
                &mut self.shooting,
                &from,
                step,
                (start, end),
                &mut |_, station| value(station),
            );
            if let Some((station, at)) = found
                && first.as_ref().is_none_or(|(.., known)| at < *known)
            {
                first = Some((broken, station, at));
            }
        }
        let Some((broken, station, reached)) = first else {
            return Stop::End(End::Lost("the sequence of events changes".to_owned()));
        };
        self.settle(&station);
        // Special points before it.
        let there = point(&self.shooting, &station);
        // Where an impact loses its rate multipliers have a pole: not quite there.
        let close = reached * (1.0 - NOT_QUITE);
        if let Ok((nearly, _)) = from.ahead(&mut self.shooting, close) {
            self.settle(&nearly);
            let near = point(&self.shooting, &nearly);
            let before = here.clone();
            self.between(&from, &nearly, close, (&before, &near));
        }
        self.settle(&station);
        let forward = station.tangent[station.tangent.len() - 1];
        let outcome = match broken {
            Broken::Inner(index, guard) => self.gain(&station, (index, guard), &there),
            Broken::Event(index) => self.lose(&station, index, &there),
            Broken::Early(index, guard) => Err(format!(
                "another event comes before event {index} of the orbit: {guard:?}"
            )),
        };
        match outcome {
            Ok(next) => {
                if let Some(special) = self.special.last_mut() {
                    let onward = next.tangent[next.tangent.len() - 1];
                    special.persists = Some(onward * forward > 0.0);
                }
                self.settle(&next);
                *here = point(&self.shooting, &next);
                let careful = Settings {
                    first_step: (CAREFUL * curve.step).max(1e-9),
                    ..settings(&self.limits)
                };
                *curve = Curve::new(next, careful);
                Stop::On
            }
            Err(why) => Stop::End(End::Lost(why)),
        }
    }

    /// A flight touches: an impact comes in. The new equations, at their first station.
    fn gain(
        &mut self,
        station: &Station,
        (index, guard): (usize, GuardKind),
        there: &Point,
    ) -> Result<Station, String> {
        let told = |error: &dyn core::fmt::Display| error.to_string();
        let least = (self.shooting.least(&station.at)).map_err(|left| left.to_string())?;
        let touching = (least[index].iter())
            .filter(|l| l.guard == guard && !l.at_end)
            .min_by(|a, b| a.value.total_cmp(&b.value))
            .ok_or("the touch is lost")?
            .clone();
        if !matches!(guard, GuardKind::Gap(_)) {
            self.note(
                SpecialKind::Touch,
                there,
                &station.at,
                1e-12,
                touching.value.abs(),
            );
            return Err("a guard is touched that no event follows".to_owned());
        }
        let (mut longer, guess) = (self.shooting.with_event(&station.at, index, &touching))
            .map_err(|error| told(&error))?;
        let mut held = Held::monitor(&mut longer, index);
        let found = newton(&mut held, &guess, &[]).map_err(|error| told(&error))?;
        let error = NOISE * found.correction * held.scales()[found.at.len() - 1];
        let (_, gradient) = (longer.monitor(index, &found.at)).map_err(|left| told(&left))?;
        let mut tangent = longer
            .tangent(&found.at, &gradient)
            .map_err(|error| told(&error))?;
        // The impact's rate is to grow: against the gap.
        if crate::numerics::dot(&gradient, &tangent) > 0.0 {
            tangent.iter_mut().for_each(|x| *x = -*x);
        }
        let next = Station {
            at: found.at.clone(),
            tangent,
            residual: found.residual,
            correction: found.correction,
            orientation: 0.0,
        };
        let mut point = there.clone();
        if let (Some(at), Some(found)) = (point.parameters.last_mut(), found.at.last()) {
            *at = *found;
        }
        self.shooting = longer;
        self.note(
            SpecialKind::FlightGraze,
            &point,
            &found.at,
            error.max(NOISE * f64::EPSILON * next.parameter().abs()),
            found.residual,
        );
        Ok(next)
    }

    /// An impact has lost its rate: it goes out.
    fn lose(&mut self, station: &Station, index: usize, there: &Point) -> Result<Station, String> {
        let told = |error: &dyn core::fmt::Display| error.to_string();
        let mut held = Held::monitor(&mut self.shooting, index);
        let found = newton(&mut held, &station.at, &[]).map_err(|error| told(&error))?;
        let error = NOISE * found.correction * held.scales()[found.at.len() - 1];
        let is_impact = self.shooting.steps[index].impact().is_some();
        let mut at_graze = there.clone();
        if let (Some(at), Some(found)) = (at_graze.parameters.last_mut(), found.at.last()) {
            *at = *found;
        }
        let kind = if is_impact {
            SpecialKind::ImpactGraze
        } else {
            SpecialKind::Touch
        };
        let error = error.max(NOISE * f64::EPSILON * station.parameter().abs());
        self.note(kind, &at_graze, &found.at, error, found.residual);
        if !is_impact {
            return Err("an event that is no impact is only touched".to_owned());
        }
        let (mut shorter, guess) =
            (self.shooting.without_event(&found.at, index)).map_err(|error| told(&error))?;
        let last = guess.len() - 1;
        let next = Station::near(&mut shorter, &guess, last).map_err(|error| told(&error))?;
        shorter.evaluate(&next.at).map_err(|left| told(&left))?;
        if let Some(special) = self.special.last_mut() {
            // Told of the orbit without the impact.
            special.point.multipliers = shorter.multipliers();
            special.point.impacts = special.point.impacts.map(|n| n - 1);
        }
        // To the side where the gap stays open.
        let guard = match self.shooting.steps[index].passage {
            Passage::Leg(kind) => kind.ends_at,
            _ => None,
        };
        let gap = |shooting: &mut Shooting<f64>, station: &Station| {
            let least = shooting.least(&station.at).ok()?;
            (least.get(index)?.iter())
                .filter(|l| Some(l.guard) == guard && !l.at_end)
                .map(|l| l.value)
                .min_by(f64::total_cmp)
        };
        let probe = 1e-6;
        let mut opens = |station: &Station| {
            let (ahead, _) = station.ahead(&mut shorter, probe).ok()?;
            gap(&mut shorter, &ahead)
        };
        let reversed = next.clone().reversed();
        let (up, down) = (opens(&next), opens(&reversed));
        let forward = match (up, down) {
            (Some(up), Some(down)) => up >= down,
            (Some(_), None) => true,
            _ => false,
        };
        self.shooting = shorter;
        Ok(if forward { next } else { reversed })
    }
}

/// Stations that a polynomial is fitted to.
const FITTED: usize = 8;

/// The polynomial through points, in Lagrange's form.
fn interpolated(places: &[f64], values: &[f64], at: f64) -> f64 {
    let mut sum = 0.0;
    for (i, (&x, &y)) in places.iter().zip(values).enumerate() {
        let weight: f64 = (places.iter().enumerate())
            .filter(|(k, _)| *k != i)
            .map(|(_, other)| (at - other) / (x - other))
            .product();
        sum += weight * y;
    }
    sum
}

/// Where it vanishes between the ends, by bisection.
fn root_of(places: &[f64], values: &[f64], (mut low, mut high): (f64, f64)) -> Option<f64> {
    if places.len() < FITTED / 2 {
        return None;
    }
    let at = |x: f64| interpolated(places, values, x);
    let sign = at(low) > 0.0;
    if sign == (at(high) > 0.0) {
        return None;
    }
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if (at(middle) > 0.0) == sign {
            low = middle;
        } else {
            high = middle;
        }
    }
    Some(0.5 * (low + high))
}

/// Condition rows that hold all free parameters but the last.
pub(crate) fn held_parameters(at: &[f64], free: usize) -> Vec<Condition<f64>> {
    (at.len() - free..at.len() - 1)
        .map(|index| Condition::fixed(at.len(), index, at[index]))
        .collect()
}
