//! One orbit of a diagram while it is followed.

mod aperiodic;
mod classify;
mod embedding;
pub(super) mod exponent;
pub(super) mod same_orbit;
mod tail;

use self::aperiodic::{Evidence, evidence};
use self::classify::{Repetition, Settled, Way};
use self::embedding::Embedding;
use self::exponent::{Displaced, units};
use self::tail::Tail;
use super::run::row::{Outcome, Row, Started};
use super::spec::observable::Scratch;
use super::spec::{Exponent, Spec};
use super::sweep::Sweep;
use crate::analysis::map::{Arrival, CoordinateKind, Map, NoReturn, Passage};

/// Counts returns, keeps samples, and draws the conclusions.
#[derive(Debug)]
pub(super) struct Column {
    pub row: u64,
    pub start: Started,
    /// Returns until the next sample.
    until_sample: u64,
    /// Samples that have not been passed over yet.
    transient: u64,
    /// The way since the latest sample.
    way: Option<Passage>,
    samples: Vec<f64>,
    ways: Vec<Way>,
    tail: Tail,
    kinds: Vec<CoordinateKind>,
    /// The largest size of each coordinate at any return so far.
    largest: Vec<f64>,
    /// What sizes coordinates have, on the way from sample to sample, too.
    sizes: Vec<f64>,
    origin: Vec<f64>,
    end: Vec<f64>,
    orbit: Vec<f64>,
    /// The point of the first sample.
    first: Vec<f64>,
    /// Whether the orbit has a derivative no longer.
    is_ambiguous: bool,
}

/// What an orbit needs next.
pub(super) enum Need {
    /// Its next point.
    Next,
    /// Nothing: here is its result, and whence the exponent, if that is asked for.
    Done(Box<Row>, Option<Displaced>),
}

impl Column {
    pub(super) fn new(sweep: &Sweep, row: u64, start: Started, origin: Vec<f64>) -> Self {
        let spec = sweep.spec();
        Self {
            row,
            start,
            until_sample: spec.every,
            transient: spec.transient,
            way: None,
            samples: Vec::new(),
            ways: Vec::new(),
            tail: Tail::new(sweep.coordinates().len(), judged(spec)),
            kinds: Vec::new(),
            largest: vec![0.0; sweep.coordinates().len()],
            sizes: Vec::new(),
            origin,
            end: Vec::new(),
            orbit: Vec::new(),
            first: Vec::new(),
            is_ambiguous: false,
        }
    }

    /// The orbit could not start, and starts elsewhere.
    pub(super) fn restart(&mut self, start: Started, origin: Vec<f64>) {
        (self.start, self.origin) = (start, origin);
    }

    /// Whether the orbit has come to any point yet.
    pub(super) fn has_begun(&self, sweep: &Sweep) -> bool {
        self.until_sample < sweep.spec().every
            || self.transient < sweep.spec().transient
            || !self.ways.is_empty()
    }

    /// Takes in that the orbit has come to a point, or to none.
    #[inline]
    pub(super) fn arrive(
        &mut self,
        map: &dyn Map,
        sweep: &Sweep,
        arrival: &Arrival<'_>,
        scratch: &mut Scratch,
    ) -> Need {
        let passage = match &arrival.passage {
            Ok(passage) => passage,
            Err(reason) => return Need::Done(Box::new(self.fail(sweep, reason)), None),
        };
        let way = match &self.way {
            Some(way) => way.then(passage),
            None => *passage,
        };
        for (most, x) in self.largest.iter_mut().zip(arrival.point) {
            *most = most.max(x.abs());
        }
        self.until_sample -= 1;
        if self.until_sample > 0 {
            self.way = Some(way);
            return Need::Next;
        }
        let spec = sweep.spec();
        self.way = None;
        self.until_sample = spec.every;
        if self.transient > 0 {
            self.transient -= 1;
            return Need::Next;
        }
        if self.ways.is_empty() {
            self.reserve(sweep);
            self.first = arrival.point.to_vec();
        }
        for observable in &sweep.observables {
            let value = observable.value(arrival.point, &way, arrival.parameters, scratch);
            self.samples.push(value);
        }
        self.is_ambiguous |= way.ambiguities > 0;
        self.tail.push(arrival.point);
        self.ways.push(Way {
            impacts: way.impacts,
            accumulations: way.accumulations,
            time: way.return_time,
        });
        if (self.ways.len() as u64) < spec.keep {
            return Need::Next;
        }
        self.conclude(map, sweep, arrival)
    }

    /// The first sample is about to be kept.
    fn reserve(&mut self, sweep: &Sweep) {
        let spec = sweep.spec();
        // More than this grow as they come.
        let keep = spec.keep.min(RESERVED) as usize;
        self.samples.reserve(keep * sweep.observables.len());
        self.ways.reserve(keep);
        self.tail.reserve(keep);
    }

    /// What sizes the coordinates have: at all returns, where the orbit started, where orbits of the map start, and on the way of
    /// another return. One that is zero at all samples, as across a section, has a size elsewhere; one that has died out had it
    /// before.
    fn find_sizes(&mut self, map: &dyn Map, arrival: &Arrival<'_>) {
        let mut elsewhere = Tail::new(arrival.point.len(), usize::MAX);
        elsewhere.push(&self.origin);
        elsewhere.push(&map.initial_point(arrival.parameters));
        if let Some(&Way { time, .. }) = self.ways.last() {
            elsewhere.push(&map.on_the_way(arrival.parameters, arrival.point, time));
        }
        elsewhere.relate(&self.kinds);
        let mut before = self.largest.clone();
        // How far something has come says nothing of what is told relative to it.
        for kind in &self.kinds {
            if let CoordinateKind::Idle { others } = kind {
                others.iter().for_each(|&(other, _)| before[other] = 0.0);
            }
        }
        let sizes = self.tail.sizes().into_iter().zip(elsewhere.sizes());
        let finite = |size: f64| if size.is_finite() { size } else { 0.0 };
        self.sizes = (sizes.zip(before))
            .map(|((size, there), before)| size.max(finite(there)).max(finite(before)))
            .collect();
    }

    /// What the samples show of a period, and how many of the latest returns are one, or all that there is.
    fn repetition(&self, sweep: &Sweep) -> (Repetition, usize) {
        let settled = Settled {
            points: &self.tail,
            kinds: &self.kinds,
            sizes: &self.sizes,
            ways: &self.ways,
        };
        let spec = sweep.spec();
        let repetition = settled.repetition(spec.longest_period, spec.period_tolerance);
        let period = (repetition.period()).filter(|_| !settled.has_died_out());
        (repetition, period.unwrap_or(self.ways.len()))
    }

    fn aperiodic(&self) -> Outcome {
        let of = (&*self.kinds, &*self.sizes);
        match evidence(&Embedding::new(&self.tail, JUDGED as usize, of)) {
            Evidence::Chaotic => Outcome::Chaotic,
            Evidence::Quasiperiodic => Outcome::Quasiperiodic,
            Evidence::None => Outcome::Unsettled,
        }
    }

    /// All samples are there.
    fn conclude(&mut self, map: &dyn Map, sweep: &Sweep, arrival: &Arrival<'_>) -> Need {
        let spec = sweep.spec();
        self.kinds = map.coordinate_kinds(arrival.parameters);
        self.tail.relate(&self.kinds);
        self.find_sizes(map, arrival);
        if sweep.carries() {
            self.end = arrival.point.to_vec();
        }
        let (repetition, recent) = self.repetition(sweep);
        let period = repetition.period();
        let first = self.ways.len() - recent;
        let chatters = chatters(&self.ways[first..]);
        let settled = match repetition {
            Repetition::Cycle(_) => Outcome::Periodic,
            _ if chatters && !sweep.compares() => Outcome::CompleteChatter,
            Repetition::Approach => Outcome::Unsettled,
            Repetition::None => self.aperiodic(),
        };
        if sweep.compares() && settled != Outcome::Unsettled {
            self.orbit = self.tail.latest(period.unwrap_or(COMPARED), &self.kinds);
        }
        let outcome = if !self.samples.iter().all(|value| value.is_finite()) {
            Outcome::NotFinite
        } else if chatters {
            Outcome::CompleteChatter
        } else {
            settled
        };
        let mut row = self.take(sweep, outcome);
        row.period = period.unwrap_or(0) as u64;
        row.impacts_per_return = mean_impacts(&self.ways[first..]);
        let is_smooth = spec.exponent == Exponent::Largest && !self.is_ambiguous;
        let displaced = is_smooth.then(|| {
            let units = units(&self.kinds, &self.sizes);
            Displaced::evenly(core::mem::take(&mut self.first), units)
        });
        Need::Done(Box::new(row), displaced)
    }

    /// The orbit has no next point.
    fn fail(&mut self, sweep: &Sweep, reason: &NoReturn) -> Row {
        let impacts = mean_impacts(&self.ways);
        let mut row = self.take(sweep, Outcome::from(reason));
        row.impacts_per_return = impacts;
        row
    }

    fn take(&mut self, sweep: &Sweep, outcome: Outcome) -> Row {
        let samples = core::mem::take(&mut self.samples);
        Row {
            row: self.row,
            start: self.start,
            outcome,
            period: 0,
            impacts_per_return: f64::NAN,
            exponent: f64::NAN,
            samples: if sweep.records() { samples } else { Vec::new() },
            origin: core::mem::take(&mut self.origin),
            sizes: if self.orbit.is_empty() {
                Vec::new()
            } else {
                self.sizes.clone()
            },
            orbit: core::mem::take(&mut self.orbit),
            end: core::mem::take(&mut self.end),
        }
    }
}

/// So many of the latest points are judged; shorter transients and longer orbits say no more.
const JUDGED: u64 = 4096;

/// How many of the latest points a column keeps.
fn judged(spec: &Spec) -> usize {
    // Twice the longest period, so that it can be seen to repeat.
    let periods = spec.longest_period.min(spec.keep / 2).saturating_mul(2);
    periods.max(JUDGED).min(spec.keep) as usize
}

/// So many points of an orbit that does not repeat are compared with others.
const COMPARED: usize = 64;

/// Room for so many samples is made at once.
const RESERVED: u64 = 1 << 16;

fn chatters(ways: &[Way]) -> bool {
    ways.iter().any(|way| way.accumulations > 0)
}

fn mean_impacts(ways: &[Way]) -> f64 {
    if chatters(ways) {
        return f64::INFINITY;
    }
    let sum: u64 = ways.iter().map(|way| way.impacts).sum();
    sum as f64 / ways.len() as f64
}
