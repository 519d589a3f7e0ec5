//! Ordinary steps of a trajectory in free flight, decided without a branch: one trajectory alone, or all lanes of a vector.
//!
//! Nearly all steps end in one of two ways: in an impact after which the trajectory flies on, or nowhere, as far as the expansion
//! reaches. What they change beside the state is a [`Flight`], a handful of numbers. Whatever is not certain to be ordinary (the
//! last impact of a chatter sequence, one that may be rounding, a restitution out of range) is left to the mode machine, which
//! begins from the numbers before.

use super::{FOREVER, ORDER_CLASSES, legal_rates};
use crate::flow::chatter::is_far_from_border;
use crate::flow::modes::at_contacts::IMPACT_SCALARS;
use crate::numerics::{Real, Scalar, two_sum};

/// An order is used up to this part of the time that it reaches: a prediction is not exact.
const REACH_USED: f64 = 0.95;

/// Rates smaller than so many roundoffs of the largest state are asked for their terms.
pub(crate) const ASKED_ROUNDOFFS: f64 = 1024.0;

/// What a step came to.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Outcome<S> {
    /// How long it was, and the rounding remainder of that.
    pub step: S,
    pub step_low: S,
    /// After an impact: rate before and after, acceleration, jerk, restitution here and that of an impact of vanishing rate.
    pub impact: [S; IMPACT_SCALARS],
    /// After an impact the predicted length of the flight, else [`FOREVER`].
    pub flight_time: S,
}

/// Whether a step without event goes all the way of the time left, whose product with a unit of time is rounded.
#[inline(always)]
pub(crate) fn reaches<S: Scalar>(step: S, remaining: S) -> S::Mask {
    (remaining * S::splat(1.0 - 4.0 * S::ROUNDOFF)).at_most(step)
}

/// The order class of the next step, as a number, and its unit of time: the lowest order that covers the predicted flight, of
/// those that reach so far.
#[inline(always)]
pub(crate) fn plan<S: Scalar>(flight_time: S, reach: &[S; ORDER_CLASSES]) -> (S, S) {
    let top = ORDER_CLASSES - 1;
    let (mut class, mut unit) = (S::splat(top as f64), reach[top]);
    // Every order is asked: where the answer cannot be foreseen, a branch costs more.
    for (index, &reach) in reach.iter().enumerate().rev() {
        let covers = flight_time.at_most(reach * S::splat(REACH_USED));
        class = S::select(covers, S::splat(index as f64), class);
        unit = S::select(covers, flight_time, unit);
    }
    (class, divisible(unit))
}

/// The nearest unit of time that orders divide: it over any of the first sixteen is a double, and so are products with few digits.
///
/// A coefficient is a rate times the unit over its order. Were that rounded, it would be in the same direction at each step with this
/// unit, and a periodic motion would gain or lose by it in each period. The reciprocal of an order up to sixteen is off by half a
/// roundoff at most, so that the product with it is rounded to the quotient.
#[inline(always)]
fn divisible<S: Scalar>(unit: S) -> S {
    // What all of these divide, but for a power of two.
    const ODD: f64 = (5 * 7 * 9 * 11 * 13) as f64;
    (unit * S::splat(1.0 / ODD)).short() * S::splat(ODD)
}

/// What is left of a predicted flight after a step that did not end it.
#[inline(always)]
pub(crate) fn rest_of_flight<S: Scalar>(flight_time: S, step: S) -> S {
    let forever = S::splat(FOREVER);
    let goes_on = flight_time.less(forever) & step.less(flight_time);
    S::select(goes_on, flight_time - step, forever)
}

/// The length of a flight that begins with a rate and no acceleration, to leading order; [`FOREVER`] where there is none or it begins with
/// another acceleration.
#[inline(always)]
pub(crate) fn time_by_jerk<R: Real>(rate: R, acceleration: R, jerk: R) -> R {
    let time = (R::splat(-6.0) * rate / jerk).sqrt();
    let falls_back = acceleration == R::ZERO && jerk < R::ZERO && rate >= R::ZERO;
    match falls_back && time.is_finite() {
        true => time,
        false => R::splat(FOREVER),
    }
}

/// How long a sequence of impacts may still go on after the latest, to leading order: its next flight and all that follow.
#[inline(always)]
pub(crate) fn rest_of_sequence<S: Scalar>(flight_time: S, at_rest: S) -> S {
    let (one, forever) = (S::splat(1.0), S::splat(FOREVER));
    let ends = flight_time.less(forever) & at_rest.less(one);
    S::select(ends, flight_time / (one - at_rest), forever)
}

/// The largest of the first states, and whether all are finite.
#[inline(always)]
pub(crate) fn largest<S: Scalar>(states: &[S], coordinates: usize) -> (S, S::Mask) {
    let (mut largest, mut nothing) = (S::splat(0.0), S::splat(0.0));
    for (index, &state) in states.iter().enumerate() {
        if index < coordinates {
            largest = largest.max(state.abs());
        }
        nothing = state.mul_add(S::splat(0.0), nothing);
    }
    (largest, nothing.is_finite())
}

/// Time left until a trajectory stops.
#[inline(always)]
pub(crate) fn remaining<S: Scalar>((horizon, horizon_low): (S, S), (time, time_low): (S, S)) -> S {
    (horizon - time) + (horizon_low - time_low)
}

/// Flights shorter than this are a roundoff of the time, or of the longest step before.
#[inline(always)]
pub(crate) fn negligible<S: Scalar>(time: S, longest_step: S) -> S {
    time.abs().max(longest_step) * S::splat(S::ROUNDOFF)
}

/// A later time, as a sum of two numbers, of which a step is another. Steps of a periodic motion are rounded in the same direction in
/// each period: without the remainder of that, time would drift away from the states.
#[inline(always)]
pub(crate) fn later<S: Scalar>((time, low): (S, S), (step, step_low): (S, S)) -> (S, S) {
    let (time, error) = two_sum(time, step);
    two_sum(time, error + (low + step_low))
}

/// What an ordinary step asks of a trajectory beside its state.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Flight<S> {
    /// Time, and its rounding remainder.
    pub time: S,
    pub time_low: S,
    /// When the trajectory stops next, likewise.
    pub horizon: S,
    pub horizon_low: S,
    /// How long the flight is predicted to last, or what is left of that.
    pub flight_time: S,
    pub longest_step: S,
    /// Restitution that the border of complete chatter was computed for, and that border.
    pub restitution: S,
    pub border: S,
}

/// What an ordinary step makes of it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Course<S> {
    pub time: S,
    pub time_low: S,
    pub flight_time: S,
    pub longest_step: S,
}

impl<S: Scalar> Flight<S> {
    /// Time left until the trajectory stops.
    #[inline(always)]
    pub fn remaining(&self) -> S {
        remaining((self.horizon, self.horizon_low), (self.time, self.time_low))
    }

    /// What a step makes of a flight that ended `nowhere`, or in an impact that concerns one contact alone and has been applied
    /// (`at_impact`); `largest` is that of the model's states after it. With where it is an ordinary step: elsewhere the numbers
    /// mean nothing.
    #[inline(always)]
    pub fn follow(
        &self,
        outcome: &Outcome<S>,
        (nowhere, at_impact): (S::Mask, S::Mask),
        largest: S,
    ) -> (Course<S>, S::Mask) {
        let (zero, one) = (S::splat(0.0), S::splat(1.0));
        let step = outcome.step;
        let [rate, after, acceleration, jerk, restitution, at_rest] = outcome.impact;
        let (time, time_low) = later((self.time, self.time_low), (step, outcome.step_low));
        let longest_step = self.longest_step.max(step);
        let is_step = negligible(time, self.longest_step).less(step);
        let glides = nowhere & !reaches(step, self.remaining());

        let least = largest * S::splat(ASKED_ROUNDOFFS * S::ROUNDOFF);
        let is_impact = rate.less(-least) & legal_rates(rate, after);
        let flies_on = zero.less(after)
            & zero.less(restitution)
            & acceleration.less(zero)
            & negligible(time, longest_step).less(outcome.flight_time);
        // Elsewhere the border is another, or the end of the sequence near.
        let same = at_rest.at_most(self.restitution) & self.restitution.at_most(at_rest);
        let is_far =
            at_rest.less(one) & same & is_far_from_border((after, acceleration, jerk), self.border);
        let bounces = at_impact & is_impact & flies_on & is_far;

        let rest = rest_of_flight(self.flight_time, step);
        let course = Course {
            time,
            time_low,
            flight_time: S::select(at_impact, outcome.flight_time, rest),
            longest_step,
        };
        (course, is_step & (glides | bounces))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn orders_divide_units_of_time(unit in 1e-280_f64..1.0, exponent in -60_i32..60) {
            let near = unit * f64::from(exponent).exp2();
            let unit = divisible(near);
            prop_assert!((unit / near - 1.0).abs() < 1e-7);
            prop_assert_eq!(divisible(unit), unit);
            for order in 1..=16 {
                let order = f64::from(order);
                let share = unit * (1.0 / order);
                prop_assert_eq!(share.mul_add(order, -unit), 0.0);
                prop_assert_eq!(share.mul_add(8.5, -(share * 8.5)), 0.0);
            }
        }
    }
}
