//! The end of complete chatter, without integrating infinitely many impacts.
//!
//! Well inside the sticking region (MATH.md 5) the post-impact rate shrinks by the restitution r from impact to impact,
//! and time and state converge with the ratios r, r^2, r^3, … exactly, by linearisation along the line of rest states.
//! So Richardson's extrapolation with these ratios gains an order from each further impact. Samples are taken every few
//! impacts, such that the first ratio is about one half: then rounding errors grow tenfold at most, for any r.

use super::border_value::border_value;
use crate::numerics::Real;

/// Chatter is completed only where u lies below this fraction of the border value u*: no question is left there.
const SAFE_FRACTION: f64 = 0.5;

/// For decelerating release (negative jerk) chatter is complete anyway; extrapolation waits until |u| is small.
const SAFE_NEGATIVE: f64 = -0.25;

/// Ratio of successive samples that stride over impacts aims at.
const SAMPLE_RATIO: f64 = 0.5;

/// Samples kept.
const MAX_SAMPLES: usize = 14;

/// Extrapolations agree to this many roundoffs of the sequence's remaining extent: about what the weights amplify.
const AGREEMENT_ROUNDOFFS: f64 = 32.0;

/// A quantity that changes by less than this part of itself in the remaining sequence need only be right to half a
/// roundoff of itself.
const EXTENT_SHARE: f64 = 64.0;

/// One sampled impact.
#[derive(Clone, Debug)]
struct Sample<R> {
    time: (R, R),
    state: Vec<(R, R)>,
}

/// Where a chatter sequence ends.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Accumulation<R> {
    /// Time from the latest impact to the end.
    pub after: R,
    /// Change of the state from the latest impact to the end.
    pub change: Vec<R>,
    /// Estimated error of the time.
    pub error: f64,
}

/// Local coordinates after an impact.
#[derive(Clone, Copy, Debug)]
pub(crate) struct LocalPoint<R> {
    pub rate: R,
    pub acceleration: R,
    pub jerk: R,
    /// Restitution of an impact of vanishing rate.
    pub restitution: R,
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
    /// Time of the first impact of the sequence.
    began: R,
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
            began: R::ZERO,
            tail,
        }
    }

    /// Forgets all that it saw.
    pub(crate) fn restart(&mut self) {
        *self = Self::new(self.tail);
    }

    /// Another event came between: the sequence so far is no geometric one.
    pub(crate) fn interrupt(&mut self) {
        self.contact = None;
        self.samples.clear();
    }

    /// Takes note of an impact; time and state come with their rounding remainders. Returns the end of the sequence as
    /// soon as it is certain to rounding.
    #[inline(always)]
    pub(crate) fn observe(
        &mut self,
        contact: usize,
        local: LocalPoint<R>,
        time: (R, R),
        state: (&[R], &[R]),
    ) -> Option<Accumulation<R>> {
        let falls_back = local.acceleration < R::ZERO;
        if !falls_back {
            self.interrupt();
            return None;
        }
        let restitution = local.restitution.to_f64();
        let u = (local.jerk * local.rate / (local.acceleration * local.acceleration)).to_f64();
        if restitution != self.restitution {
            self.adapt(restitution);
        }
        if !(u < SAFE_FRACTION * self.border && u > SAFE_NEGATIVE) {
            self.interrupt();
            return None;
        }
        if self.contact != Some(contact) {
            self.interrupt();
            self.contact = Some(contact);
            self.began = time.0;
            self.until_sample = 0;
        }
        if self.until_sample > 0 {
            self.until_sample -= 1;
            return None;
        }
        self.sample(time, state)
    }

    /// Finds the border value and how often to sample for another restitution.
    fn adapt(&mut self, restitution: f64) {
        self.restitution = restitution;
        self.border = border_value(restitution);
        let steps = libm::ceil(libm::log(SAMPLE_RATIO) / libm::log(restitution));
        self.stride = if steps >= 1.0 {
            steps.min(1e9) as u32
        } else {
            1
        };
    }

    /// Samples an impact and extrapolates.
    fn sample(&mut self, time: (R, R), state: (&[R], &[R])) -> Option<Accumulation<R>> {
        self.until_sample = self.stride - 1;
        if self.samples.len() == MAX_SAMPLES {
            self.samples.remove(0);
        }
        let state = state
            .0
            .iter()
            .copied()
            .zip(state.1.iter().copied())
            .collect();
        self.samples.push(Sample { time, state });
        let elapsed = time.0 - self.began;
        let end = self.extrapolate()?;
        if end.after > elapsed * R::splat(self.tail.longest) {
            return None;
        }
        Some(end)
    }

    fn extrapolate(&self) -> Option<Accumulation<R>> {
        const FEWEST: usize = 3;
        let latest = self.samples.last()?;
        if self.samples.len() < FEWEST {
            return None;
        }
        let time = self.limit(|sample| sample.time)?;
        let change: Option<Vec<Limit<R>>> = (0..latest.state.len())
            .map(|i| self.limit(|sample| sample.state[i]))
            .collect();
        let floor = R::splat(R::ROUNDOFF) * (latest.time.0.abs() + time.distance.abs());
        Some(Accumulation {
            after: time.distance,
            change: change?.iter().map(|limit| limit.distance).collect(),
            error: time.error.max(floor).to_f64(),
        })
    }

    /// Richardson's tableau, column by column, for one quantity's distance from its latest sample; none while its last
    /// two entries disagree.
    fn limit(&self, value: impl Fn(&Sample<R>) -> (R, R)) -> Option<Limit<R>> {
        let now = value(self.samples.last()?);
        let mut column: Vec<R> = self
            .samples
            .iter()
            .map(|sample| {
                let (high, low) = value(sample);
                (high - now.0) + (low - now.1)
            })
            .collect();
        let extent = column.iter().fold(R::ZERO, |most, c| most.max(c.abs()));
        let mut before = R::ZERO;
        let mut power = 1.0;
        let ratio = libm::pow(self.restitution, f64::from(self.stride));
        while column.len() > 1 {
            before = column[column.len() - 1];
            power *= ratio;
            let weight = R::splat(power) / (R::ONE - R::splat(power));
            column = column
                .windows(2)
                .map(|pair| (pair[1] - pair[0]).mul_add(weight, pair[1]))
                .collect();
        }
        let distance = column[0];
        let error = (distance - before).abs();
        let scale = extent.max(now.0.abs() * R::splat(1.0 / EXTENT_SHARE));
        (error <= R::splat(AGREEMENT_ROUNDOFFS * self.tail.precision) * scale)
            .then_some(Limit { distance, error })
    }
}

/// An extrapolated quantity.
struct Limit<R> {
    distance: R,
    error: R,
}
