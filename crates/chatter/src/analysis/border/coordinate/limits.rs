//! The linearising coordinates X and N of a chatter sequence, (M4), and their derivatives.
//!
//! One flight and impact is an analytic map of (u, nu) with a saddle at (u*, 0) whose multipliers are 1 / eta and lambda.
//! With U, V analytic and U(x, 0) - u* = x + O(x^2), V(0, y) = y + O(y^2), the orbit is
//!
//! ```text
//! u_k - u* = U(X eta^-k, N lambda^k) - u*,        nu_k = V(X eta^-k, N lambda^k)
//! ```
//!
//! On X = 0 therefore the errors of the limits have the following ratios from impact to impact (j = 1, 2, …):
//!
//! ```text
//! eta^k (u_k - u*)  -> X     eta lambda^j
//! nu_k / lambda^k   -> N     lambda^j
//! eta^k du_k        -> dX    lambda^j  and  eta lambda^j (from dN)
//! t_k               -> t_inf lambda^j
//! ```
//!
//! If lambda and eta depend on what is varied, k times each power occurs as well: a ratio to be eliminated twice.
//!
//! Where there are more than three states the surface of release points has coordinates z. Taken along the field f and W to v = a = 0,
//! as z_k = x_k - w W / b - (a / j) f, states after impacts tend to those of the point where the impacts accumulate. So do their
//! derivatives, less what f and W make of those of w and a:
//!
//! ```text
//! dz = dx - gamma W / b - alpha f,      gamma + alpha a = dw,      gamma L_(W / b) a + alpha j = da
//! ```
//!
//! An impact changes z by O(nu^2), and dz, where X changes along it, by O(nu^3 / eta^k):
//!
//! ```text
//! z_k               -> Z     lambda^j
//! dz_k              -> dZ    lambda^j  and  lambda^(j + 2) / eta
//! ```

use super::super::error::{BorderError, Lack};
use super::super::problem::Here;
use super::super::release::equations::ReleasePoint;
use super::sequence::{Impact, SHORTEST, Sequence};
use crate::analysis::universal::Constants;
use crate::numerics::{Estimate, Plan, Real, limit, ratios};
use serde::{Deserialize, Serialize};

/// Terms of an extrapolation lie so many impacts apart that the first ratio is about this: then rounding errors are
/// amplified little.
const TERM_RATIO: f64 = 0.6;

/// The sequence is followed until nu has shrunk to the unit roundoff to this power: further impacts have less tail but
/// more rounding error, since nu is known to a roundoff of the state.
const TAIL_POWER: f64 = 0.165;

/// Errors of X grow like eta^-k along the sequence. X is known to so many times what a roundoff of the state changes it by.
const NOISE_ROUNDOFFS: f64 = 10.0;

/// Rounding moves neighbouring limits alike: by so many times their difference.
const ALIKE: f64 = 8.0;

/// A sequence settles where u comes this near to u* for good, relative to u*.
const WITHIN: f64 = 0.5;

/// More ratios than this are never eliminated.
const MOST_ORDERS: usize = 24;

/// How far a sequence is followed and how its limits are taken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Extrapolation {
    /// Impacts of the chatter sequence to follow; chosen from the number type if not given.
    pub impacts: Option<usize>,
    /// Largest number of ratios to eliminate; as many as help if not given.
    pub orders: Option<usize>,
}

/// What is needed to take limits for one restitution.
#[derive(Clone, Debug)]
pub(crate) struct Limits<R> {
    pub constants: Constants<R>,
    /// du*/dr.
    fixed_point_slope: R,
    /// How many impacts of the chatter sequence to follow.
    pub impacts: usize,
    plan: Plan,
    /// How often each ratio occurs in derivatives along which the restitution changes.
    copies: usize,
    /// Error of X that the state's roundoff makes, relative to u*.
    noise: f64,
}

impl<R: Real> Here<'_, R> {
    /// What the restitution at a release point determines.
    pub(crate) fn limits(&self, release: &ReleasePoint<R>) -> Result<Limits<R>, BorderError> {
        let restitution = Lack::Restitution(release.restitution.to_f64());
        let constants = Constants::new(release.restitution).map_err(|_| self.lacks(restitution))?;
        let extrapolation = self.problem.spec.extrapolation;
        let ln_lambda = constants.ln_lambda.to_f64();
        let stride = (libm::log(TERM_RATIO) / ln_lambda).round().max(1.0) as usize;
        let tail = TAIL_POWER * libm::log(R::ROUNDOFF) / ln_lambda;
        let impacts = extrapolation
            .impacts
            .unwrap_or((libm::ceil(tail) as usize).max(SHORTEST + 1));
        // u* = g(u*, r) with dg/dr = g / r and dg/du = 1 / eta.
        let fixed_point_slope = constants.chatter_fixed_point / constants.restitution
            * (-constants.eta / constants.one_minus_eta);
        let changes = |x: &R| *x != R::ZERO;
        let is_constant =
            !changes(&release.restitution_slope) && !release.restitution_by.iter().any(changes);
        Ok(Limits {
            constants,
            fixed_point_slope,
            impacts,
            plan: Plan {
                stride,
                orders: extrapolation.orders.unwrap_or(MOST_ORDERS),
            },
            copies: if is_constant { 1 } else { 2 },
            noise: NOISE_ROUNDOFFS * R::ROUNDOFF,
        })
    }
}

impl<R: Real> Limits<R> {
    /// The impact where a sequence stops approaching u* for good: where it departs, it does so from impact to impact. Before
    /// that, u may cross u* more than once.
    pub(crate) fn nearest(&self, sequence: &Sequence<R>) -> usize {
        let begins = sequence.begins;
        let local = sequence.impacts.iter().skip(begins);
        let distances: Vec<f64> = local
            .take_while(|impact| impact.local.acceleration < R::ZERO)
            .map(|impact| self.distance(impact.local.u()))
            .collect();
        let departs = (1..distances.len())
            .rev()
            .take_while(|&k| distances[k - 1] <= distances[k])
            .count();
        begins + distances.len().saturating_sub(1 + departs)
    }

    /// The impact from which on a sequence that comes near u* is within half of it: limits are taken from there.
    pub(crate) fn settles(&self, sequence: &Sequence<R>) -> usize {
        let nearest = self.nearest(sequence);
        let impacts = sequence.impacts.iter().enumerate();
        let far = |impact: &Impact<R>| self.distance(impact.local.u()) > WITHIN;
        (impacts.take(nearest + 1).skip(sequence.begins))
            .filter(|(_, impact)| far(impact))
            .last()
            .map_or(sequence.begins, |(k, _)| k + 1)
    }

    /// |u - u*| / u*.
    pub(crate) fn distance(&self, u: R) -> f64 {
        let fixed_point = self.constants.chatter_fixed_point;
        ((u - fixed_point).abs() / fixed_point).to_f64()
    }

    /// |X| to leading order, counted from where the chatter sequence begins: how far a sequence is from the border.
    pub(crate) fn rough_distance(&self, sequence: &Sequence<R>) -> f64 {
        let nearest = self.nearest(sequence);
        let Some(impact) = sequence.impacts.get(nearest) else {
            return f64::INFINITY;
        };
        let shrunk = libm::exp(self.constants.ln_eta.to_f64() * (nearest - sequence.begins) as f64);
        self.distance(impact.local.u()) * shrunk
    }

    /// Learns from the columns of a sequence by how much roundoff of the state changes X.
    pub(crate) fn set_noise(&mut self, sequence: &Sequence<R>) {
        let Some(last) = sequence.impacts.last() else {
            return;
        };
        let states = last.local.place.len();
        let sum: f64 = (0..states)
            .map(|i| {
                let size = (sequence.impacts.iter()).fold(0.0_f64, |most, impact| {
                    most.max(impact.state[i].abs().to_f64())
                });
                last.local.u_slope(i).abs().to_f64() * size
            })
            .sum();
        let end = sequence.impacts.len() - 1;
        let shrunk = libm::exp(self.constants.ln_eta.to_f64() * end as f64);
        let fixed_point = self.constants.chatter_fixed_point.to_f64();
        let amplified = (sum * shrunk / fixed_point).max(1.0);
        self.noise = NOISE_ROUNDOFFS * R::ROUNDOFF * amplified;
    }

    /// The limit of a quantity that is multiplied by one more `growth` at each impact. The errors have the ratios lambda, lambda^2, …,
    /// each times each of these, so often.
    fn scaled_limit(
        &self,
        sequence: &Sequence<R>,
        growth: R,
        (firsts, copies): (&[R], usize),
        quantity: impl Fn(&Impact<R>) -> R,
    ) -> Estimate<R> {
        let ratios = ratios(firsts, self.constants.lambda, MOST_ORDERS - 1, copies);
        let mut scale = (0..sequence.begins).fold(R::ONE, |power, _| power * growth);
        let terms: Vec<R> = (sequence.impacts.iter().skip(sequence.begins))
            .map(|impact| {
                let term = quantity(impact) * scale;
                scale *= growth;
                term
            })
            .collect();
        let taken = |terms: &[R]| limit(terms, &ratios, self.plan);
        let mut found = taken(&terms);
        // Rounding of the last terms shows in the limit without them.
        let without = taken(&terms[..terms.len().saturating_sub(1)]);
        let moved = (found.value - without.value).abs().to_f64();
        found.error = found.error.max(ALIKE * moved);
        let end = sequence.impacts.len() - 1;
        let growth = libm::exp(-self.constants.ln_eta.to_f64() * end as f64);
        let noise = self.noise * growth * found.value.abs().to_f64();
        found.error = found.error.max(noise);
        found
    }

    /// X, from the impacts of a sequence that is followed to where it is nearest to the border.
    pub(crate) fn x(&self, sequence: &Sequence<R>) -> Estimate<R> {
        let mut x = self.x_without(sequence, &[self.constants.eta], 1);
        x.error = (x.error).max(self.noise * self.constants.chatter_fixed_point.to_f64());
        x
    }

    /// X where it is not quite zero: the tail of its derivative times X is removed, too.
    #[cfg(test)]
    pub(crate) fn x_off_border(&self, sequence: &Sequence<R>) -> Estimate<R> {
        self.x_without(sequence, &[R::ONE, self.constants.eta], self.copies)
    }

    fn x_without(&self, sequence: &Sequence<R>, firsts: &[R], copies: usize) -> Estimate<R> {
        self.scaled_limit(sequence, self.constants.eta, (firsts, copies), |impact| {
            impact.local.u() - self.constants.chatter_fixed_point
        })
    }

    /// The derivative of X along a combination of columns, along which the restitution where the impacts accumulate changes by what
    /// the coordinates of that place make of it, and by so much.
    pub(crate) fn x_along(
        &self,
        sequence: &Sequence<R>,
        release: &ReleasePoint<R>,
        weights: &[R],
        held_restitution: R,
    ) -> Estimate<R> {
        let changes = release.restitution_by.iter().zip(&release.free);
        let changes = changes.filter(|(by, _)| **by != R::ZERO);
        let restitution = changes.fold(held_restitution, |sum, (&by, &i)| {
            sum + by * self.place_slope(sequence, i, weights).value
        });
        self.x_slope(sequence, weights, restitution)
    }

    /// The same, along which it changes by so much in all.
    pub(crate) fn x_slope(
        &self,
        sequence: &Sequence<R>,
        weights: &[R],
        restitution_slope: R,
    ) -> Estimate<R> {
        let shift = self.fixed_point_slope * restitution_slope;
        let copies = if restitution_slope == R::ZERO {
            1
        } else {
            self.copies
        };
        let Constants { eta, .. } = self.constants;
        self.scaled_limit(sequence, eta, (&[R::ONE, eta], copies), |impact| {
            (weights.iter().enumerate())
                .map(|(column, &weight)| weight * impact.local.u_slope(column))
                .fold(-shift, |sum, part| sum + part)
        })
    }

    /// A component of the place where the impacts accumulate.
    pub(crate) fn place(&self, sequence: &Sequence<R>, i: usize) -> Estimate<R> {
        let place = |impact: &Impact<R>| impact.local.place[i];
        self.scaled_limit(sequence, R::ONE, (&[R::ONE], 1), place)
    }

    /// Its derivative along a combination of columns.
    pub(crate) fn place_slope(
        &self,
        sequence: &Sequence<R>,
        i: usize,
        weights: &[R],
    ) -> Estimate<R> {
        let Constants { lambda, eta, .. } = self.constants;
        let firsts = [R::ONE, lambda * lambda / eta];
        let along = |impact: &Impact<R>| impact.local.place_along(i, weights);
        self.scaled_limit(sequence, R::ONE, (&firsts, self.copies), along)
    }

    /// N.
    pub(crate) fn amplitude(&self, sequence: &Sequence<R>) -> Estimate<R> {
        let growth = R::ONE / self.constants.lambda;
        self.scaled_limit(sequence, growth, (&[R::ONE], 1), |impact| impact.local.nu())
    }

    /// When the impacts accumulate.
    pub(crate) fn accumulation(&self, sequence: &Sequence<R>) -> Estimate<R> {
        self.scaled_limit(sequence, R::ONE, (&[R::ONE], 1), |impact| impact.time)
    }
}
