//! The maps g^-2, g^-4, g^-8, … as polynomials, for restitutions near one.
//!
//! As r -> 1 the fixed points 0 and u* merge, one impact changes almost nothing, and a sequence to u* takes of the order
//! of 1 / (1 - r) impacts. Write g^-1 = F_0 and
//!
//! ```text
//! F_k(u) = g^-(2^k)(u) = u + u (u - u*) p_k(u),      u - u* -> (u - u*) (1 + u p_k),     u -> u (1 + (u - u*) p_k)
//! ```
//!
//! Composing F_k with itself gives p_{k+1} = p_k + (1 + (u - u*) p_k)(1 + u p_k) p_k(F_k(u)) without any cancellation,
//! and p_k is smooth on an interval that halves with each k. So 1 / (1 - r) impacts cost log2 of that many steps. The
//! product of h(u_i) / lambda doubles likewise.

use super::chatter_map::ChatterMap;
use super::chebyshev::{Chebyshev, Grid};
use super::constants::Constants;
use crate::numerics::{DoubleDouble, Real};

/// 2^k impacts back in one.
#[derive(Clone, Debug)]
pub(super) struct Doubled {
    /// The polynomials hold on [0, end].
    pub end: DoubleDouble,
    /// p_k.
    pub factor: Chebyshev,
    /// prod h(u_i) / lambda over the 2^k points that follow.
    pub product: Chebyshev,
    /// eta^(2^k), as the polynomial has it at u*: so the sequences that follow have no drift.
    pub multiplier: DoubleDouble,
    /// One, as the polynomial has it: the product at u*.
    pub fixed_product: DoubleDouble,
}

/// Below this 1 - eta, doubled maps are worth their making; above it 250 plain steps reach every digit.
const DOUBLE_BELOW: f64 = 0.06;
/// No map contracts by more than this at u*: beyond, u* = 0.3 (1 - r) would leave its interval of 0.2 / 2^k. Few steps
/// are left then.
const CONTRACTED: f64 = 0.6;
/// End of the interval of p_1; p_0 has its singularities at -r/3 and -3r/8, so that [`SAMPLES`] resolve 32 digits.
const FIRST_END: f64 = 0.1;
const SAMPLES: usize = 46;

/// p_0(u) = (g^-1(u) - u) / (u (u - u*)), from the factors of the cubic.
fn first_factor(
    map: &ChatterMap<DoubleDouble>,
    c: &Constants<DoubleDouble>,
    u: DoubleDouble,
) -> DoubleDouble {
    let number = DoubleDouble::from;
    let step = map.back_step(u);
    let fixed_root = map.back_step(c.chatter_fixed_point).root;
    let numerator = c.lambda * step.h * (step.h + number(2.0) + c.lambda) + c.restitution;
    let length = number(12.0) * u + number(3.0) * c.restitution + step.root;
    -(number(24.0) * numerator) / (step.h * (step.root + fixed_root) * length)
}

/// The doubled maps k = 1, 2, … that shorten the way to u*; none where the plain way is short.
pub(super) fn doubled_maps(
    map: &ChatterMap<DoubleDouble>,
    c: &Constants<DoubleDouble>,
) -> Vec<Doubled> {
    let mut levels: Vec<Doubled> = Vec::new();
    if c.one_minus_eta.to_f64() >= DOUBLE_BELOW {
        return levels;
    }
    let grid = Grid::new(SAMPLES);
    let mut end = DoubleDouble::from(FIRST_END);
    let mut ln_multiplier = c.ln_eta;
    while 2.0 * ln_multiplier.to_f64() > libm::log(CONTRACTED) {
        ln_multiplier += ln_multiplier;
        let mut factors = Vec::with_capacity(SAMPLES);
        let mut products = Vec::with_capacity(SAMPLES);
        for u in grid.points(DoubleDouble::ZERO, end) {
            let excess = u - c.chatter_fixed_point;
            let evaluate = |u| match levels.last() {
                Some(level) => (level.factor.at(u), level.product.at(u)),
                None => (first_factor(map, c, u), map.back_step(u).h / c.lambda),
            };
            let (p, product) = evaluate(u);
            let stretch = DoubleDouble::ONE + excess * p;
            let (p_there, product_there) = evaluate(u * stretch);
            factors.push(p + stretch * (DoubleDouble::ONE + u * p) * p_there);
            products.push(product * product_there);
        }
        let factor = grid.interpolate(DoubleDouble::ZERO, end, &factors);
        let product = grid.interpolate(DoubleDouble::ZERO, end, &products);
        let fixed = c.chatter_fixed_point;
        levels.push(Doubled {
            end,
            multiplier: DoubleDouble::ONE + fixed * factor.at(fixed),
            fixed_product: product.at(fixed),
            factor,
            product,
        });
        end *= DoubleDouble::from(0.5);
    }
    levels
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::Scalar;

    #[test]
    fn doubled_maps_are_the_plain_map_iterated() {
        for restitution in [0.96, 0.999] {
            let c = Constants::new(DoubleDouble::from(restitution)).unwrap();
            let map = ChatterMap::new(&c);
            for (k, level) in doubled_maps(&map, &c).iter().enumerate() {
                assert!(level.factor.tail() < 1e-30, "{}", level.factor.tail());
                assert!(level.product.tail() < 1e-30);
                for part in [0.05, 0.3, 1.0] {
                    let u = level.end * DoubleDouble::from(part);
                    let p = level.factor.at(u);
                    let there = u + u * (u - c.chatter_fixed_point) * p;
                    let (mut v, mut product) = (u, DoubleDouble::ONE);
                    for _ in 0..1_u32 << (k + 1) {
                        product *= map.back_step(v).h / c.lambda;
                        v = map.inverse(v);
                    }
                    assert!(((v - there) / v).abs().to_f64() < 1e-28);
                    let off = (product - level.product.at(u)) / product;
                    assert!(off.abs().to_f64() < 1e-28, "{k} {off}");
                }
            }
        }
    }
}
