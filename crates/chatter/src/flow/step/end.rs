//! The end of a step: the state moves there, and an impact is applied where one ended it.

use super::flight::later;
use super::{FOREVER, Workspace};
use crate::expressions::{ORDER_CLASSES, Tape};
use crate::flow::modes::at_contacts::IMPACT_SCALARS;
use crate::flow::modes::guard::Transition;
use crate::flow::modes::program::Program;
use crate::numerics::dispatch::{Kernel, dispatch_narrow};
use crate::numerics::polynomial::horner;
use crate::numerics::{Mask, Scalar, two_sum};

/// The unit of time is at most so many times as long as steps have been.
const AHEAD: f64 = 64.0;

/// A restitution computed from rates may leave [0, 1] by this much.
const RESTITUTION_SLACK: f64 = 1e-12;

impl<S: Scalar> Workspace<S> {
    /// Moves the state to the end of the step and applies the impact where one ended it.
    #[inline(always)]
    pub(super) fn finish(&mut self, program: &Program) {
        self.travel();
        self.collide(program);
    }

    /// Moves the state to the end of the step.
    #[inline(always)]
    pub(crate) fn travel(&mut self) {
        let s = self.scaled_step;
        self.step = s * self.tau;
        self.step_low = s.mul_add(self.tau, -self.step);
        for (slot, (state, low)) in self.state.iter_mut().zip(&mut self.low).enumerate() {
            if self.clock == Some(slot) {
                (*state, *low) = later((*state, *low), (self.step, self.step_low));
                continue;
            }
            let increment = horner(&self.expansion.series(slot)[1..], s).mul_add(s, *low);
            (*state, *low) = two_sum(*state, increment);
        }
        self.flight_time = S::splat(FOREVER);
        self.keep_unit();
    }

    /// The value of a series at the end of the step, so many of whose roots lie at its start, and the size of the terms that it is the
    /// sum of there.
    #[inline(always)]
    pub(crate) fn value_at_end(&self, tape: &Tape, slot: usize, roots: u8) -> (S, S) {
        let end = AtEnd {
            series: &self.expansion.series(slot)[usize::from(roots)..],
            scaled_step: self.scaled_step,
            roots,
        };
        let terms = (self.expansion).size_of_terms(tape, &self.constants, slot);
        (dispatch_narrow(end), terms)
    }

    /// The unit of time grows no farther than steps do: where events end them early, polynomials would reach farther and farther,
    /// and what rounding leaves open that far away says nothing of signs here. It stays what it was, by which such polynomials are
    /// scaled exactly.
    #[inline(always)]
    fn keep_unit(&mut self) {
        const TOP: usize = ORDER_CLASSES - 1;
        if self.expansion.order() == S::ORDERS[TOP] {
            let reach = self.reach[TOP];
            let is_far = (self.step * S::splat(AHEAD)).less(reach);
            self.reach[TOP] = S::select(is_far, reach.min(self.tau), reach);
        }
    }

    /// Applies the impact that ended the step, if it is one that leaves the rates of closed contacts as they are.
    #[inline(always)]
    pub(crate) fn collide(&mut self, program: &Program) {
        for (index, guard) in program.guards.iter().enumerate() {
            let Transition::Impact { contact } = guard.transition else {
                continue;
            };
            let here = self.ends_step(index);
            if here.any() {
                self.collide_at(program, contact, here);
            }
        }
    }

    /// Applies the impact map (M1) of a contact in the lanes of `here`, and predicts how long the next flight lasts.
    #[inline(always)]
    pub(crate) fn collide_at(&mut self, program: &Program, contact: usize, here: S::Mask) {
        let Some(impact) = program.impacts[contact].as_ref() else {
            return;
        };
        let constants = &self.impact_constants[contact];
        (self.point).settle(&impact.tape, constants, &self.state, &self.low);
        for (i, scalar) in self.impact.iter_mut().enumerate() {
            let value = self.point.value(&impact.tape, constants, i);
            *scalar = S::select(here, value, *scalar);
        }
        // An impact that no restitution in [0, 1] explains is reported, and leaves the state as it was before.
        let legal = here & legal_rates(self.impact[0], self.impact[1]);
        for (k, &i) in impact.changed.iter().enumerate() {
            let place = IMPACT_SCALARS + k;
            let value = self.point.value(&impact.tape, constants, place);
            let low = self.point.output_remainder(&impact.tape, place);
            self.state[i] = S::select(legal, value, self.state[i]);
            self.low[i] = S::select(legal, low, self.low[i]);
        }
        let [_, rate, acceleration, jerk, _, _] = self.impact;
        let time = flight_time(rate, acceleration, jerk);
        self.flight_time = S::select(here, time, self.flight_time);
    }
}

/// The end of a series, so many of whose roots lie at its start.
struct AtEnd<'a, S> {
    series: &'a [S],
    scaled_step: S,
    roots: u8,
}

impl<S: Scalar> Kernel for AtEnd<'_, S> {
    type Output = S;

    #[inline(always)]
    fn run(self) -> S {
        let end = horner(self.series, self.scaled_step);
        (0..self.roots).fold(end, |value, _| value * self.scaled_step)
    }
}

/// Whether the rate after an impact is one that a restitution in [0, 1] gives, up to rounding.
#[inline(always)]
pub(crate) fn legal_rates<S: Scalar>(before: S, after: S) -> S::Mask {
    let slack = before.abs() * S::splat(RESTITUTION_SLACK);
    let separating = (-slack).at_most(after) & after.at_most(slack - before);
    // An incoming rate that rounding has taken away: there is nothing to reverse.
    S::splat(0.0).at_most(before) | separating
}

/// Time to the next impact to leading order, eq. (3); [`FOREVER`] where there is none.
#[inline(always)]
pub(crate) fn flight_time<S: Scalar>(rate: S, acceleration: S, jerk: S) -> S {
    let nu = -acceleration;
    // That of the equation, times nu^2.
    let radicand = (jerk * rate).mul_add(S::splat(-8.0 / 3.0), nu * nu);
    let root = radicand.max(S::splat(0.0)).sqrt();
    let time = S::splat(4.0) * rate / (nu + root);
    let falls_back =
        S::splat(0.0).less(nu) & S::splat(0.0).at_most(radicand) & S::splat(0.0).at_most(rate);
    S::select(falls_back & time.is_finite(), time, S::splat(FOREVER))
}
