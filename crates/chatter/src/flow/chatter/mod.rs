//! The end of complete chatter, without integrating infinitely many impacts.
//!
//! Well inside the sticking region (MATH.md 5) the post-impact rate shrinks by the restitution r from impact to impact,
//! and time and state converge with the ratios r, r^2, r^3, … exactly, by linearisation along the line of rest states.
//! So Richardson's extrapolation with these ratios gains an order from each further impact. Samples are taken every few
//! impacts, such that the first ratio is about one half: then rounding errors grow tenfold at most, for any r.
//!
//! Where r changes with time or state, the ratios are those of the point where the sequence ends (MATH.md 10): the point
//! is extrapolated with r there, which the point in turn gives, until neither moves.

pub(super) mod border_value;
mod limit;
mod pace;
mod tableau;

pub(crate) use limit::{
    Flight, SequenceConstants, SequenceExprs, SequenceMap, SequenceTapes, Turn,
};

use limit::LimitPoint;
use pace::Pace;
pub(crate) use pace::REMEMBERED;
use tableau::{Limit, Weights, extrapolate};

use super::step::FOREVER;
use crate::numerics::{Real, Scalar, two_sum};
use border_value::border_value;

/// Chatter is completed only where u lies below this fraction of the border value u*: no question is left there.
const SAFE_FRACTION: f64 = 0.5;

/// Whether an impact after which a flight begins like this belongs to no sequence that can be completed yet: u = jerk rate /
/// acceleration^2 is not between bounds. Not divided: a division costs more than all else here.
#[inline(always)]
pub(crate) fn is_far_from_border<S: Scalar>(
    (rate, acceleration, jerk): (S, S, S),
    border: S,
) -> S::Mask {
    let (above, below) = (jerk * rate, acceleration * acceleration);
    !(above.less(S::splat(SAFE_FRACTION) * border * below)
        & (S::splat(SAFE_NEGATIVE) * below).less(above))
}

/// For decelerating release (negative jerk) chatter is complete anyway; extrapolation waits until |u| is small.
const SAFE_NEGATIVE: f64 = -0.25;

/// Ratio of successive samples that stride over impacts aims at.
const SAMPLE_RATIO: f64 = 0.5;

/// Fewer samples than this say nothing about what the tableau leaves.
const FEWEST_SAMPLES: usize = 3;

/// Samples kept.
const MAX_SAMPLES: usize = 14;

/// Extrapolations agree to this many roundoffs of the sequence's remaining extent: about what the weights amplify.
const AGREEMENT_ROUNDOFFS: f64 = 32.0;

/// A quantity that changes by less than this part of itself in the remaining sequence need only be right to half a
/// roundoff of itself.
const EXTENT_SHARE: f64 = 64.0;

/// Sampling starts again where the ratio of samples leaves this range: beyond it rounding errors grow, or samples are few.
const SAMPLE_RATIOS: core::ops::Range<f64> = 0.1..0.7;

/// The restitution at the limit is found by repeating the extrapolation with it. It matters less with each sample, so
/// that a round gains digits; a sequence in which this many do not suffice is followed further.
const ROUNDS: usize = 12;

/// The restitution at the limit is known once a round moves it by this many roundoffs.
const SETTLED_ROUNDOFFS: f64 = 16.0;

/// Time and state converge with the powers of the restitution at the limit only where that of the impacts is near to it, by this
/// part of it. Where none is left at rest they converge faster than with any ratio, and are followed to the end.
const NEAR_LIMIT: f64 = 0.5;

/// One sampled impact.
#[derive(Clone, Debug)]
struct Sample<R> {
    time: (R, R),
    /// Restitution of the impact.
    restitution: R,
    /// The model's states.
    state: Vec<(R, R)>,
    /// Per column of derivatives: that of the time, then those of the point.
    events: Vec<R>,
}

impl<R: Real> Sample<R> {
    /// Whether the impact's restitution is near that of a limit.
    fn is_near(&self, limit: R) -> bool {
        (self.restitution - limit).abs() <= R::splat(NEAR_LIMIT) * limit
    }
}

/// Where a chatter sequence ends.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Accumulation<R> {
    /// Time from the latest impact to the end.
    pub after: R,
    /// Change of the state from the latest impact to the end.
    pub change: Vec<R>,
    /// The derivatives of the end's time, one a column; none where the latest impact is taken for the end.
    pub late: Vec<R>,
    /// Estimated error of the time.
    pub error: f64,
}

/// Local coordinates after an impact.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LocalPoint<R> {
    pub rate: R,
    pub acceleration: R,
    pub jerk: R,
    /// Restitution of the impact, and of one of vanishing rate there.
    pub restitution: R,
    pub at_rest: R,
}

/// When and how precisely a chatter sequence is completed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Tail {
    /// See [`Settings::longest_tail`](super::Settings::longest_tail).
    pub longest: f64,
    /// Relative error of a step: roundoff, or the tolerance where that is larger.
    pub precision: f64,
}

/// Watches one trajectory's impacts for a sequence that can be completed.
#[derive(Clone, Debug)]
pub(crate) struct ChatterTracker<R> {
    contact: Option<usize>,
    restitution: f64,
    border: f64,
    stride: u32,
    until_sample: u32,
    samples: Vec<Sample<R>>,
    /// By how much the columns' latest extrapolations were uncertain, relative to their extents.
    unsettled: R,
    /// Time of the first impact of the sequence.
    began: R,
    pace: Pace<R>,
    tail: Tail,
}

impl<R: Real> ChatterTracker<R> {
    /// A tracker that has seen nothing.
    pub(crate) fn new(tail: Tail) -> Self {
        Self {
            contact: None,
            restitution: f64::NAN,
            border: 0.0,
            stride: 1,
            until_sample: 0,
            samples: Vec::new(),
            unsettled: R::splat(f64::MAX),
            began: R::ZERO,
            pace: Pace::new(),
            tail,
        }
    }

    /// Forgets all that it saw.
    pub(crate) fn restart(&mut self) {
        *self = Self::new(self.tail);
    }

    /// Whether a sequence is being watched.
    pub(crate) fn has_samples(&self) -> bool {
        !self.samples.is_empty()
    }

    /// Another event came between: the sequence so far is no geometric one.
    pub(crate) fn interrupt(&mut self) {
        self.contact = None;
        self.samples.clear();
    }

    /// Takes note of how long an impact's own sequence would last to leading order, [`FOREVER`] where it does not fall back.
    #[inline(always)]
    pub(crate) fn keep_pace(&mut self, contact: usize, time: R, rest: R) {
        self.pace.observe(contact, time, rest);
    }

    /// As [`keep_pace`](Self::keep_pace), for impacts that so many more follow that they are not remembered.
    #[inline(always)]
    pub(crate) fn pass_over(&mut self, contact: usize, impacts: usize) {
        self.pace.pass_over(contact, impacts);
    }

    /// Restitution that the border of complete chatter was computed for last, and that border.
    pub(crate) fn border(&self) -> (f64, f64) {
        (self.restitution, self.border)
    }

    /// How long the impacts of a contact may still go on after the latest, whatever came between them.
    pub(crate) fn rest_of_impacts(&self, contact: usize) -> R {
        self.pace.rest(contact, R::splat(FOREVER))
    }

    /// The same, at most, of impacts that only those of other contacts bring about; `Err` where they need not come to an end.
    pub(crate) fn rest_of_collapse(&self, contact: usize) -> Result<R, ()> {
        self.pace.rest_of_collapse(contact, R::splat(FOREVER))
    }

    /// Whether an impact may belong to a sequence that can be completed; else what was seen before it is no such sequence.
    #[inline(always)]
    pub(crate) fn may_complete(&mut self, local: LocalPoint<R>) -> bool {
        let falls_back = local.acceleration < R::ZERO;
        if !falls_back {
            self.interrupt();
            return false;
        }
        let restitution = local.at_rest.to_f64();
        if restitution != self.restitution {
            self.restitution = restitution;
            self.border = border_value(restitution);
        }
        let flight = (local.rate, local.acceleration, local.jerk);
        let may_complete = !is_far_from_border(flight, R::splat(self.border));
        if !may_complete {
            self.interrupt();
        }
        may_complete
    }

    /// Takes note of an impact that [`may_complete`](Self::may_complete); time and state come with their rounding remainders.
    /// Returns the end of the sequence as soon as it is certain to rounding.
    #[inline(always)]
    pub(crate) fn observe(
        &mut self,
        (contact, local): (usize, LocalPoint<R>),
        time: (R, R),
        state: (&[R], &[R]),
        map: &mut SequenceMap<'_, R>,
    ) -> Option<Accumulation<R>> {
        if self.contact != Some(contact) {
            self.interrupt();
            self.contact = Some(contact);
            self.began = time.0;
            self.stride = stride(self.restitution);
            self.until_sample = 0;
        }
        if self.until_sample > 0 {
            self.until_sample -= 1;
            return None;
        }
        self.sample((time, local), state, map)
    }

    /// Samples an impact and extrapolates.
    fn sample(
        &mut self,
        (time, local): ((R, R), LocalPoint<R>),
        (state, low): (&[R], &[R]),
        map: &mut SequenceMap<'_, R>,
    ) -> Option<Accumulation<R>> {
        let best = stride(self.restitution);
        if best != self.stride {
            let ratio = libm::pow(self.restitution, f64::from(self.stride));
            if !SAMPLE_RATIOS.contains(&ratio) {
                self.samples.clear();
                self.stride = best;
            }
        }
        self.until_sample = self.stride - 1;
        if self.samples.len() == MAX_SAMPLES {
            self.samples.remove(0);
        }
        let count = map.coordinates();
        self.samples.push(Sample {
            time,
            restitution: local.restitution,
            state: (state.iter().copied().zip(low.iter().copied()))
                .take(count)
                .collect(),
            events: map.events((state, low)),
        });
        // What the tops of flights make of the sequence is no matter of its impacts.
        let at_rest = match map.turn {
            Some(_) => map.restitution((state, low)),
            None => local.at_rest,
        };
        let far = (self.samples.iter()).position(|sample| sample.is_near(at_rest));
        self.samples.drain(..far.unwrap_or(self.samples.len()));
        if self.samples.len() < FEWEST_SAMPLES {
            self.unsettled = R::splat(f64::MAX);
            return None;
        }
        let elapsed = time.0 - self.began;
        let end = self.end((state, low), map)?;
        if end.after > elapsed * R::splat(self.tail.longest) {
            return None;
        }
        Some(end)
    }

    /// The end of the sequence; none while it is not certain to rounding.
    fn end(
        &mut self,
        (state, low): (&[R], &[R]),
        map: &mut SequenceMap<'_, R>,
    ) -> Option<Accumulation<R>> {
        let (limits, at) = self.limits(map)?;
        let latest = self.samples.last()?;
        let roundoffs = R::splat(AGREEMENT_ROUNDOFFS * self.tail.precision);
        let uncertain = |limit: &Limit<R>, now: R| {
            let scale = limit.extent.max(now.abs() * R::splat(1.0 / EXTENT_SHARE));
            if limit.error > R::ZERO {
                limit.error / scale
            } else {
                limit.error
            }
        };
        let is_certain = |limit, now| uncertain(limit, now) <= roundoffs;
        let mut points = limits.state.iter().zip(&latest.state);
        let certain = is_certain(&limits.time, latest.time.0)
            && points.all(|(limit, now)| is_certain(limit, now.0));
        if !certain {
            return None;
        }
        // Rounding in a column grows as its impacts' rates fall: what another sample does not improve is as certain as
        // it can be.
        let count = map.coordinates();
        // Where an impact leaves a coordinate no choice, as friction that stops, its derivative at the point is what rounding leaves
        // of the one at a fixed time.
        let fixed = |place: usize| match place % (count + 1) {
            0 => R::ZERO,
            i => state[(place / (count + 1) + 1) * count + i - 1],
        };
        let worst = (limits.events.iter().zip(&latest.events).enumerate())
            .map(|(place, (limit, &now))| uncertain(limit, now.abs().max(fixed(place).abs())))
            .fold(R::ZERO, |worst, error| worst.max(error));
        let improves = worst < self.unsettled * R::splat(0.5);
        self.unsettled = worst;
        if worst > roundoffs && improves {
            return None;
        }
        let time = limits.time;
        let mut change: Vec<R> = limits.state.iter().map(|limit| limit.distance).collect();
        let mut times = Vec::with_capacity(map.columns());
        let columns = limits.events.chunks(count + 1);
        for (index, (column, now)) in columns.zip(latest.events.chunks(count + 1)).enumerate() {
            let late = now[0] + column[0].distance;
            times.push(late);
            for i in 0..count {
                // Time runs alike in what is displaced: a rounding of it would last while all else dies out.
                if map.is_clock(i) {
                    change.push(R::ZERO);
                    continue;
                }
                let place = (index + 1) * count + i;
                // From the point's derivative to that at a fixed time, which the state holds.
                let moved = (now[i + 1] - state[place]) - at.field[i] * late;
                change.push(moved + (column[i + 1].distance - low[place]));
            }
        }
        let floor = R::splat(R::ROUNDOFF) * (latest.time.0.abs() + time.distance.abs());
        Some(Accumulation {
            after: time.distance,
            change,
            late: times,
            error: time.error.max(time.expected).max(floor).to_f64(),
        })
    }

    /// The limits of all that converges, with the ratios that hold there.
    fn limits(&self, map: &mut SequenceMap<'_, R>) -> Option<(Limits<R>, LimitPoint<R>)> {
        let latest = self.samples.last()?;
        let settled = R::splat(SETTLED_ROUNDOFFS * R::ROUNDOFF);
        let count = map.coordinates();
        let zero = vec![R::ZERO; count * (1 + map.columns())];
        let (mut point, mut low) = (zero.clone(), zero);
        for (i, &(high, rest)) in latest.state.iter().enumerate() {
            (point[i], low[i]) = (high, rest);
        }
        for (column, now) in latest.events.chunks(count + 1).enumerate() {
            point[(column + 1) * count..][..count].copy_from_slice(&now[1..]);
        }
        let mut at = map.at(&point, &low);
        let mut slopes_moved = R::splat(f64::MAX);
        for _ in 0..ROUNDS {
            if !(at.restitution >= R::ZERO && at.restitution < R::ONE) {
                return None;
            }
            let limits = self.extrapolate(&at);
            for (i, (limit, &(high, rest))) in limits.state.iter().zip(&latest.state).enumerate() {
                (point[i], low[i]) = two_sum(high, rest + limit.distance);
            }
            let columns = limits.events.chunks(count + 1);
            for (column, (limit, now)) in (columns.zip(latest.events.chunks(count + 1))).enumerate()
            {
                for i in 0..count {
                    point[(column + 1) * count + i] = now[i + 1] + limit[i + 1].distance;
                }
            }
            let next = map.at(&point, &low);
            let moved = (next.restitution - at.restitution).abs();
            let slopes = (next.slopes.iter().zip(&at.slopes))
                .map(|(&now, &before)| (now - before).abs())
                .fold(R::ZERO, R::max);
            let largest = (next.slopes.iter()).fold(R::ZERO, |most, slope| most.max(slope.abs()));
            let known = slopes <= settled * largest || slopes >= slopes_moved * R::splat(0.5);
            slopes_moved = slopes;
            at = next;
            if moved <= settled * at.restitution && known {
                let all_near = (self.samples.iter()).all(|sample| sample.is_near(at.of_impacts));
                return all_near.then_some((limits, at));
            }
        }
        None
    }

    /// Extrapolates everything with one restitution and its derivatives.
    fn extrapolate(&self, at: &LimitPoint<R>) -> Limits<R> {
        let samples = &self.samples;
        let weights = Weights::new(at.restitution, &at.slopes, self.stride, samples.len());
        let width = samples.first().map_or(0, |sample| sample.state.len()) + 1;
        let mut events = vec![None; at.slopes.len() * width];
        let mut quantity = |place: usize, value: &dyn Fn(&Sample<R>) -> (R, R)| {
            let now = samples.last().map_or((R::ZERO, R::ZERO), value);
            let away = |(high, low): (R, R)| (high - now.0) + (low - now.1);
            let mut values: Vec<R> = samples.iter().map(|sample| away(value(sample))).collect();
            let mut derivatives: Vec<Vec<R>> = (0..at.slopes.len())
                .map(|column| {
                    let place = column * width + place;
                    let now = samples
                        .last()
                        .map_or(R::ZERO, |sample| sample.events[place]);
                    samples
                        .iter()
                        .map(|sample| sample.events[place] - now)
                        .collect()
                })
                .collect();
            let (limit, along) = extrapolate(&mut values, &mut derivatives, &weights);
            for (column, limit) in along.into_iter().enumerate() {
                events[column * width + place] = Some(limit);
            }
            limit
        };
        let time = quantity(0, &|sample| sample.time);
        let state = (1..width)
            .map(|place| quantity(place, &|sample| sample.state[place - 1]))
            .collect();
        Limits {
            time,
            state,
            events: events.into_iter().flatten().collect(),
        }
    }
}

/// How often to sample the impacts of a sequence.
fn stride(restitution: f64) -> u32 {
    let steps = libm::ceil(libm::log(SAMPLE_RATIO) / libm::log(restitution));
    if steps >= 1.0 {
        steps.min(1e9) as u32
    } else {
        1
    }
}

/// Limits of everything that a sample holds, in its order.
struct Limits<R> {
    time: Limit<R>,
    state: Vec<Limit<R>>,
    events: Vec<Limit<R>>,
}
