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
//! Where there are more than three states the surface of release points has coordinates z. Taken along the field and W to
//! v = a = 0, as z_k = x_k - w W / b - (a / j) f, they tend to those of the point where the impacts accumulate; an impact
//! changes them by O(nu^3), and so do their derivatives, taken in the same way, where X changes along them:
//!
//! ```text
//! z_k               -> Z     lambda^j
//! dz_k              -> dZ    lambda^j  and  lambda^(j + 2) / eta
//! ```

use super::super::release::equations::ReleaseEquations;
use super::super::release::equations::ReleasePoint;
use super::sequence::Sequence;
use crate::analysis::universal::Constants;
use crate::numerics::{Estimate, Plan, Real, dot, limit};
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
    impacts: usize,
    plan: Plan,
    lambda_powers: Vec<R>,
    eta_lambda_powers: Vec<R>,
    slope_powers: Vec<R>,
    /// Error of X that the state's roundoff makes, relative to u*.
    noise: f64,
    /// The same with those that occur twice where the restitution changes.
    parameter_powers: Vec<R>,
    place_powers: Vec<R>,
}

impl<R: Real> Limits<R> {
    pub(crate) fn new(
        constants: Constants<R>,
        release: &ReleasePoint<R>,
        extrapolation: Extrapolation,
    ) -> Self {
        let ln_lambda = constants.ln_lambda.to_f64();
        let stride = (libm::log(TERM_RATIO) / ln_lambda).round().max(1.0) as usize;
        let tail = TAIL_POWER * libm::log(R::ROUNDOFF) / ln_lambda;
        let impacts = extrapolation
            .impacts
            .unwrap_or((libm::ceil(tail) as usize).max(4));
        // u* = g(u*, r) with dg/dr = g / r and dg/du = 1 / eta.
        let fixed_point_slope = constants.chatter_fixed_point / constants.restitution
            * (-constants.eta / constants.one_minus_eta);
        let powers = |first: R| {
            (1..MOST_ORDERS)
                .scan(first, |power, _| {
                    *power *= constants.lambda;
                    Some(*power)
                })
                .collect::<Vec<R>>()
        };
        let lambda_powers = powers(R::ONE);
        let eta_lambda_powers = powers(constants.eta);
        let sorted = |mut ratios: Vec<R>| {
            ratios.sort_by(|a, b| b.partial_cmp(a).unwrap_or(core::cmp::Ordering::Equal));
            ratios
        };
        let slope_powers = sorted([&lambda_powers[..], &eta_lambda_powers[..]].concat());
        let mixed = powers(constants.lambda * constants.lambda / constants.eta);
        let place_powers = sorted([&lambda_powers[..], &mixed[..]].concat());
        let is_constant = release.restitution_slope == R::ZERO
            && release.restitution_by.iter().all(|x| *x == R::ZERO);
        let copies = if is_constant { 1 } else { 2 };
        let repeated = |powers: &[R]| -> Vec<R> {
            let each = powers
                .iter()
                .flat_map(|&ratio| core::iter::repeat_n(ratio, copies));
            each.collect()
        };
        let parameter_powers = repeated(&slope_powers);
        let place_powers = repeated(&place_powers);
        Self {
            constants,
            fixed_point_slope,
            impacts,
            plan: Plan {
                stride,
                orders: extrapolation.orders.unwrap_or(MOST_ORDERS),
            },
            lambda_powers,
            eta_lambda_powers,
            slope_powers,
            parameter_powers,
            place_powers,
            noise: NOISE_ROUNDOFFS * R::ROUNDOFF,
        }
    }

    /// How many impacts of the chatter sequence to follow.
    pub(crate) fn impacts(&self) -> usize {
        self.impacts
    }

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
        let far = |k: &usize| self.distance(sequence.impacts[*k].local.u()) > WITHIN;
        (sequence.begins..=nearest)
            .rev()
            .find(far)
            .map_or(sequence.begins, |k| k + 1)
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
    pub(crate) fn set_noise(&mut self, sequence: &Sequence<R>, end: usize) {
        let Some(last) = sequence.impacts.get(end) else {
            return;
        };
        let states = last
            .local
            .slopes
            .first()
            .map_or(0, |slope| slope.state.len());
        let sum: f64 = (0..states)
            .map(|i| {
                let size = (sequence.impacts.iter()).fold(0.0_f64, |most, impact| {
                    most.max(impact.state[i].abs().to_f64())
                });
                last.local.u_slope(i).abs().to_f64() * size
            })
            .sum();
        let shrunk = libm::exp(self.constants.ln_eta.to_f64() * end as f64);
        let fixed_point = self.constants.chatter_fixed_point.to_f64();
        let amplified = (sum * shrunk / fixed_point).max(1.0);
        self.noise = NOISE_ROUNDOFFS * R::ROUNDOFF * amplified;
    }

    fn power(&self, base: R, exponent: usize) -> R {
        (0..exponent).fold(R::ONE, |power, _| power * base)
    }

    /// The limit of a quantity that is multiplied by one more `growth` at each impact.
    fn scaled_limit(
        &self,
        sequence: &Sequence<R>,
        end: usize,
        growth: R,
        ratios: &[R],
        quantity: impl Fn(usize) -> R,
    ) -> Estimate<R> {
        let mut scale = self.power(growth, sequence.begins);
        let terms: Vec<R> = (sequence.begins..=end)
            .map(|k| {
                let term = quantity(k) * scale;
                scale *= growth;
                term
            })
            .collect();
        let Some(mut found) = limit(&terms, ratios, self.plan) else {
            return Estimate {
                value: R::splat(f64::NAN),
                error: f64::INFINITY,
            };
        };
        // Rounding of the last terms shows in the limit without them.
        if let Some((_, earlier)) = terms.split_last()
            && let Some(without) = limit(earlier, ratios, self.plan)
        {
            let moved = (found.value - without.value).abs().to_f64();
            found.error = found.error.max(ALIKE * moved);
        }
        let growth = libm::exp(-self.constants.ln_eta.to_f64() * end as f64);
        let noise = self.noise * growth * found.value.abs().to_f64();
        found.error = found.error.max(noise);
        found
    }

    /// X, from the impacts up to number `end`.
    pub(crate) fn x(&self, sequence: &Sequence<R>, end: usize) -> Estimate<R> {
        let mut x = self.x_without(sequence, end, &self.eta_lambda_powers);
        x.error = (x.error).max(self.noise * self.constants.chatter_fixed_point.to_f64());
        x
    }

    /// X where it is not quite zero: the tail of its derivative times X is removed, too.
    #[cfg(test)]
    pub(crate) fn x_off_border(&self, sequence: &Sequence<R>, end: usize) -> Estimate<R> {
        self.x_without(sequence, end, &self.parameter_powers)
    }

    fn x_without(&self, sequence: &Sequence<R>, end: usize, ratios: &[R]) -> Estimate<R> {
        self.scaled_limit(sequence, end, self.constants.eta, ratios, |k| {
            sequence.impacts[k].local.u() - self.constants.chatter_fixed_point
        })
    }

    /// The derivative of X along a combination of columns, along which the restitution at release changes so much.
    pub(crate) fn x_slope(
        &self,
        sequence: &Sequence<R>,
        end: usize,
        weights: &[R],
        restitution_slope: R,
    ) -> Estimate<R> {
        let shift = self.fixed_point_slope * restitution_slope;
        let ratios = if restitution_slope == R::ZERO {
            &self.slope_powers
        } else {
            &self.parameter_powers
        };
        self.scaled_limit(sequence, end, self.constants.eta, ratios, |k| {
            let local = &sequence.impacts[k].local;
            (weights.iter().enumerate())
                .map(|(column, &weight)| weight * local.u_slope(column))
                .fold(-shift, |sum, part| sum + part)
        })
    }

    /// The coordinates of the release point where the impacts accumulate, and their derivatives along combinations of
    /// columns.
    pub(crate) fn accumulation_place(
        &self,
        sequence: &Sequence<R>,
        end: usize,
        (release, parameters, free): (&ReleaseEquations, &[R], &[usize]),
        along: &[Vec<R>],
    ) -> Vec<(Estimate<R>, Vec<Estimate<R>>)> {
        // For each impact the coordinates, then their derivatives.
        let projected: Vec<Vec<Vec<R>>> = (sequence.impacts[..=end].iter())
            .map(|impact| {
                let states = impact
                    .local
                    .slopes
                    .first()
                    .map_or(0, |slope| slope.state.len());
                let state = &impact.state[..states];
                let [field, jump, slopes] = release.around(state, parameters);
                let by_jump = dot(&slopes, &jump);
                let onto = |x: &[R], rate: R, acceleration: R| -> Vec<R> {
                    let late = (acceleration - rate * by_jump) / impact.local.jerk;
                    free.iter()
                        .map(|&i| x[i] - rate * jump[i] - late * field[i])
                        .collect()
                };
                let local = &impact.local;
                let mut all = vec![onto(state, local.rate, local.acceleration)];
                for weights in along {
                    let sum = |of: &dyn Fn(usize) -> R| {
                        (weights.iter().enumerate()).fold(R::ZERO, |sum, (c, &w)| sum + w * of(c))
                    };
                    let moved: Vec<R> = (0..states)
                        .map(|i| sum(&|c| local.slopes[c].state[i]))
                        .collect();
                    let rate = sum(&|c| local.slopes[c].rate);
                    let acceleration = sum(&|c| local.slopes[c].acceleration);
                    all.push(onto(&moved, rate, acceleration));
                }
                all
            })
            .collect();
        let settles = |which: usize, i: usize, ratios: &[R]| {
            self.scaled_limit(sequence, end, R::ONE, ratios, |k| projected[k][which][i])
        };
        (0..free.len())
            .map(|i| {
                let slopes = (1..=along.len()).map(|c| settles(c, i, &self.place_powers));
                (settles(0, i, &self.lambda_powers), slopes.collect())
            })
            .collect()
    }

    /// N.
    pub(crate) fn amplitude(&self, sequence: &Sequence<R>, end: usize) -> Estimate<R> {
        let growth = R::ONE / self.constants.lambda;
        self.scaled_limit(sequence, end, growth, &self.lambda_powers, |k| {
            sequence.impacts[k].local.nu()
        })
    }

    /// When the impacts accumulate.
    pub(crate) fn accumulation(&self, sequence: &Sequence<R>, end: usize) -> Estimate<R> {
        self.scaled_limit(sequence, end, R::ONE, &self.lambda_powers, |k| {
            sequence.impacts[k].time
        })
    }

    /// One component of the state where the impacts accumulate.
    pub(crate) fn accumulation_state(
        &self,
        sequence: &Sequence<R>,
        end: usize,
        component: usize,
    ) -> Estimate<R> {
        self.scaled_limit(sequence, end, R::ONE, &self.lambda_powers, |k| {
            sequence.impacts[k].state[component]
        })
    }
}
