//! The largest Lyapunov exponent of orbits: how a displacement grows that the derivative carries along.
//!
//! The samples are those of the map, whether or not exponents are asked for. Where an orbit has all of its samples, an orbit of the
//! tangent map goes the same way from the first of them on. Both are at the same places until rounding parts them, and on the same
//! attractor then.

use super::aperiodic::grows;
use crate::analysis::diagram::run::row::{Outcome, Row};
use crate::analysis::diagram::sweep::Sweep;
use crate::analysis::map::{Arrival, Command, CoordinateKind, Map, Origin, Start};
use crate::flow::FORGOTTEN;
use core::sync::atomic::AtomicBool;

/// A displacement turns into the direction that grows most over this part of as many steps as are counted afterwards, and over so many
/// at least.
const TURNING: f64 = 0.1;
const LEAST_TURNING: u64 = 8;

fn turning(steps: u64) -> u64 {
    ((steps as f64 * TURNING) as u64).max(LEAST_TURNING)
}

/// A displacement that grows or shrinks by more than this is made a unit again.
const LARGE: f64 = 1e90;

/// Logarithms of growth, step by step.
#[derive(Clone, Debug, Default)]
pub(in crate::analysis::diagram) struct Growth(Vec<f64>);

impl Growth {
    /// The exponent, of an orbit that repeats after so many samples over whole periods: what a part of one grows by is no mean.
    pub(in crate::analysis::diagram) fn mean(&self, period: Option<usize>) -> f64 {
        let counted = &self.0;
        let left_over = match period {
            Some(period) if period <= counted.len() => counted.len() % period,
            _ => 0,
        };
        let counted = &counted[left_over..];
        counted.iter().sum::<f64>() / counted.len() as f64
    }

    /// Whether it is positive beyond chance.
    pub(in crate::analysis::diagram) fn is_chaotic(&self) -> bool {
        grows(&self.0)
    }
}

/// Units in which displacements of coordinates of these kinds and sizes can be compared, whatever the model's are. What is always
/// zero may vary as much as anything else.
pub(in crate::analysis::diagram) fn units(kinds: &[CoordinateKind], sizes: &[f64]) -> Vec<f64> {
    let unit = |(kind, &size): (&CoordinateKind, &f64)| match *kind {
        CoordinateKind::Phase { period } => period,
        CoordinateKind::Plain | CoordinateKind::Idle { .. } => size,
    };
    let mut units: Vec<f64> = kinds.iter().zip(sizes).map(unit).collect();
    let is_unit = |unit: &f64| *unit > 0.0 && unit.is_finite();
    let largest = units.iter().copied().filter(is_unit).fold(0.0, f64::max);
    let instead = if largest > 0.0 { largest } else { 1.0 };
    for unit in &mut units {
        if !is_unit(unit) {
            *unit = instead;
        }
    }
    units
}

/// Where an orbit of the tangent map starts whose displacement is told in these units.
#[derive(Clone, Debug)]
pub(in crate::analysis::diagram) struct Displaced {
    pub point: Vec<f64>,
    pub units: Vec<f64>,
}

impl Displaced {
    /// An orbit's first sample, displaced by as many units in every direction.
    pub(in crate::analysis::diagram) fn evenly(mut point: Vec<f64>, units: Vec<f64>) -> Self {
        point.extend_from_slice(&units);
        Self { point, units }
    }

    fn length(&self, displacement: &[f64]) -> f64 {
        let of_units = displacement.iter().zip(&self.units).map(|(x, u)| x / u);
        of_units.map(|x| x * x).sum::<f64>().sqrt()
    }
}

/// Weighs rows by their exponents, each in an orbit of the tangent map of its own. Rows without a start, and those whose displacement
/// cannot be carried as far as their samples, remain without.
pub(in crate::analysis::diagram) fn weigh(
    tangent: &dyn Map,
    sweep: &Sweep,
    rows: &mut [(Row, Option<Displaced>)],
    stop: &AtomicBool,
) {
    let mut orbits: Vec<Stretching<'_>> = rows
        .iter_mut()
        .filter_map(|(row, displaced)| Some(Stretching::new(row, displaced.as_ref()?, sweep)))
        .collect();
    let starts: Vec<Start> = (orbits.iter())
        .map(|orbit| orbit.start(sweep, orbit.displaced.point.clone()))
        .collect();
    tangent.follow(&sweep.swept, &starts, stop, &mut |arrival| {
        orbits[arrival.orbit].arrive(sweep, &arrival)
    });
}

/// A displacement that is carried along an orbit.
struct Stretching<'a> {
    row: &'a mut Row,
    displaced: &'a Displaced,
    /// Samples until growth is counted.
    turning: u64,
    /// Returns until the next sample.
    until_sample: u64,
    /// Its length at the latest return.
    length: f64,
    /// Logarithm of what it has grown by since the latest sample.
    pending: f64,
    growth: Growth,
}

impl<'a> Stretching<'a> {
    fn new(row: &'a mut Row, displaced: &'a Displaced, sweep: &Sweep) -> Self {
        let displacement = &displaced.point[displaced.units.len()..];
        Self {
            row,
            turning: turning(sweep.spec().keep - 1),
            until_sample: sweep.spec().every,
            length: displaced.length(displacement),
            displaced,
            pending: 0.0,
            growth: Growth::default(),
        }
    }

    fn start(&self, sweep: &Sweep, point: Vec<f64>) -> Start {
        Start {
            swept: sweep.parameters(self.row.row),
            origin: Origin::Image(point),
        }
    }

    fn arrive(&mut self, sweep: &Sweep, arrival: &Arrival<'_>) -> Command {
        let Ok(passage) = &arrival.passage else {
            return Command::Retire;
        };
        if passage.ambiguities > 0 {
            return Command::Retire;
        }
        let displacement = &arrival.point[self.displaced.units.len()..];
        let length = self.displaced.length(displacement);
        let grown = length / self.length;
        if !grown.is_finite() {
            return Command::Retire;
        }
        let is_forgotten = grown <= 0.0 || passage.forgets && grown <= FORGOTTEN;
        self.pending += match is_forgotten {
            true => f64::NEG_INFINITY,
            false => libm::log(grown),
        };
        self.until_sample -= 1;
        if self.until_sample == 0 {
            self.until_sample = sweep.spec().every;
            let grown = core::mem::take(&mut self.pending);
            // What was forgotten while the displacement still turned says nothing of where the orbit goes on.
            if self.turning > 0 {
                self.turning -= 1;
            } else {
                self.growth.0.push(grown);
                let is_over = self.growth.0.len() as u64 + 1 >= sweep.spec().keep;
                if is_over || grown == f64::NEG_INFINITY {
                    self.conclude();
                    return Command::Retire;
                }
            }
        }
        self.length = length;
        let is_sized = (1.0 / LARGE..=LARGE).contains(&length);
        if is_sized && !is_forgotten {
            return Command::Continue;
        }
        let mut point = arrival.point.to_vec();
        let again = &mut point[self.displaced.units.len()..];
        match is_forgotten {
            true => again.copy_from_slice(&self.displaced.units),
            false => again.iter_mut().for_each(|x| *x /= length),
        }
        self.length = self.displaced.length(again);
        Command::Restart(self.start(sweep, point))
    }

    /// Notes the exponent, which says more about chaos than samples do.
    fn conclude(&mut self) {
        let row = &mut *self.row;
        let period = (row.period > 0).then_some(row.period as usize);
        row.exponent = self.growth.mean(period);
        let aperiodic = [Outcome::Chaotic, Outcome::Quasiperiodic, Outcome::Unsettled];
        if !aperiodic.contains(&row.outcome) || row.exponent.is_nan() {
            return;
        }
        row.outcome = match (self.growth.is_chaotic(), row.outcome) {
            (true, _) => Outcome::Chaotic,
            (false, Outcome::Chaotic) => Outcome::Unsettled,
            (false, outcome) => outcome,
        };
    }
}
