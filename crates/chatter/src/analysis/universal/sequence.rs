//! The chatter sequence back from a point to u*, in double-double: Q and P as limits.
//!
//! Q(u_1) = lim (u_i - u*) / eta^i and prod h(u_i) / lambda converge like eta^i. Every difference below is carried by
//! its own exact factor, never formed by subtraction, and the limit is reached by Richardson extrapolation with the
//! known ratios eta^m, eta^2m, … (m impacts between terms). Two sequences are followed side by side, so that the distance
//! between their Q keeps its digits too.

use super::chatter_map::{BackStep, ChatterMap, Departure, GRAZE};
use super::constants::Constants;
use super::doubling::{Doubled, doubled_maps};
use crate::numerics::{DoubleDouble, Real};

/// Chatter sequences for one restitution.
pub(super) struct Sequences {
    pub constants: Constants<DoubleDouble>,
    pub map: ChatterMap<DoubleDouble>,
    doubled: Vec<Doubled>,
}

/// Where a sequence starts.
#[derive(Clone, Copy, Debug)]
pub(super) struct Start {
    u: DoubleDouble,
    /// u - u*.
    excess: DoubleDouble,
}

/// Limits along a sequence and its distance from another one, the reference.
#[derive(Clone, Copy, Debug)]
pub(super) struct Limits {
    /// eta Q(u_1).
    pub own: DoubleDouble,
    /// eta Q of the reference.
    pub reference: DoubleDouble,
    /// Difference of the two over the difference of the starts; the derivative where they are equal.
    pub quotient: DoubleDouble,
    /// prod_{i >= 2} h(u_i) / lambda.
    pub product: DoubleDouble,
}

/// Terms of a Richardson extrapolation: with ratios at most 1/2 the remainder is below 2^-120.
const TERMS: usize = 17;
/// Impacts between terms are chosen so that the first ratio is at most this.
const RATIO: f64 = 0.5;

/// The limit of a sequence a + b k^i + c k^2i + …, k the `ratio`.
fn extrapolate(mut terms: [DoubleDouble; TERMS], ratio: DoubleDouble) -> DoubleDouble {
    let mut power = DoubleDouble::ONE;
    for left in (1..TERMS).rev() {
        power *= ratio;
        let scale = DoubleDouble::ONE / (DoubleDouble::ONE - power);
        for i in 0..left {
            // The change is small where terms agree: it costs no digits.
            let change = terms[i + 1] - terms[i];
            terms[i] = terms[i + 1] + change * power * scale;
        }
    }
    terms[0]
}

/// One of two sequences at some index.
#[derive(Clone, Copy)]
struct Member {
    u: DoubleDouble,
    excess: DoubleDouble,
    /// The excess over eta^i.
    scaled: DoubleDouble,
}

impl Member {
    fn new(start: Start) -> Self {
        Self {
            u: start.u,
            excess: start.excess,
            scaled: start.excess,
        }
    }

    /// A step that multiplies the excess by `contraction` times `multiplier`, the latter being its limit.
    fn advance(
        &mut self,
        fixed: DoubleDouble,
        contraction: DoubleDouble,
        multiplier: DoubleDouble,
    ) {
        self.excess *= contraction * multiplier;
        self.scaled *= contraction;
        self.u = fixed + self.excess;
    }
}

struct Pair<'a> {
    of: &'a Sequences,
    fixed: BackStep<DoubleDouble>,
    own: Member,
    reference: Member,
    /// Difference of the members over eta^i and over that of their starts.
    quotient: DoubleDouble,
    product: DoubleDouble,
}

impl Pair<'_> {
    fn step(&mut self, level: Option<&Doubled>) {
        let one = DoubleDouble::ONE;
        let c = &self.of.constants;
        let (a, b) = (&self.own, &self.reference);
        let (own, reference, difference, product, multiplier) = match level {
            None => {
                let map = &self.of.map;
                let at_a = map.departure(a.u, a.excess, &self.fixed);
                let at_b = map.departure(b.u, b.excess, &self.fixed);
                let none = Departure::none();
                (
                    at_a.contraction(&none, c.lambda),
                    at_b.contraction(&none, c.lambda),
                    at_a.contraction(&at_b, c.lambda),
                    at_a.product(),
                    c.eta,
                )
            }
            Some(level) => {
                let (p_a, p_b, p_between) = level.factor.pair(a.u, b.u);
                let over = one / level.multiplier;
                let difference = one + (a.excess + b.u) * p_a + b.u * b.excess * p_between;
                (
                    (one + a.u * p_a) * over,
                    (one + b.u * p_b) * over,
                    difference * over,
                    level.product.at(a.u) / level.fixed_product,
                    level.multiplier,
                )
            }
        };
        self.own.advance(c.chatter_fixed_point, own, multiplier);
        self.reference
            .advance(c.chatter_fixed_point, reference, multiplier);
        self.quotient *= difference;
        self.product *= product;
    }
}

impl Sequences {
    pub(super) fn new(constants: Constants<DoubleDouble>) -> Self {
        let map = ChatterMap::new(&constants);
        let doubled = doubled_maps(&map, &constants);
        Self {
            constants,
            map,
            doubled,
        }
    }

    /// The point u = (3/8)(1 - sigma); the graze for sigma = 0.
    pub(super) fn at(&self, sigma: DoubleDouble) -> Start {
        let u = DoubleDouble::from(GRAZE) * (DoubleDouble::ONE - sigma);
        Start {
            u,
            excess: u - self.constants.chatter_fixed_point,
        }
    }

    /// The pole of g, u = 1/3 (sigma = 1/9): close to u* where r is small.
    pub(super) fn at_pole(&self) -> Start {
        let number = DoubleDouble::from;
        let lambda = self.constants.lambda;
        Start {
            u: number(1.0) / number(3.0),
            // 6 u* = 2 - lambda - lambda^2.
            excess: lambda * (DoubleDouble::ONE + lambda) / number(6.0),
        }
    }

    /// Follows the sequence from `own` to u*, and beside it that from `reference`.
    pub(super) fn limits(&self, own: Start, reference: Start) -> Limits {
        let c = &self.constants;
        let mut pair = Pair {
            of: self,
            fixed: self.map.back_step(c.chatter_fixed_point),
            own: Member::new(own),
            reference: Member::new(reference),
            quotient: DoubleDouble::ONE,
            product: DoubleDouble::ONE,
        };
        let mut level = None;
        for next in &self.doubled {
            while pair.reference.u > next.end || pair.own.u > next.end {
                pair.step(level);
            }
            level = Some(next);
        }
        let multiplier = level.map_or(c.eta, |level| level.multiplier);
        let stride = (libm::log(RATIO) / libm::log(multiplier.to_f64()))
            .ceil()
            .max(1.0) as u32;
        let mut ratio = DoubleDouble::ONE;
        for _ in 0..stride {
            ratio *= multiplier;
        }
        let terms: [_; TERMS] = core::array::from_fn(|_| {
            let term = [
                pair.own.scaled,
                pair.reference.scaled,
                pair.quotient,
                pair.product,
            ];
            for _ in 0..stride {
                pair.step(level);
            }
            term
        });
        let [own, reference, quotient, product] =
            core::array::from_fn(|k| extrapolate(terms.map(|term| term[k]), ratio));
        Limits {
            own,
            reference,
            quotient,
            product,
        }
    }

    /// x_e = Q(3/8).
    pub(super) fn lap_end(&self) -> DoubleDouble {
        let graze = self.at(DoubleDouble::ZERO);
        self.limits(graze, graze).own / self.constants.eta
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::Scalar;

    #[test]
    fn limits_agree_with_the_plain_definition() {
        // Plain iteration of (8) and (12) in 130 digits.
        let sequences = Sequences::new(Constants::new("0.8".parse().unwrap()).unwrap());
        let graze = sequences.at(DoubleDouble::ZERO);
        let limits = sequences.limits(graze, graze);
        let end: DoubleDouble = "0.06322200160173044962606561495147184636952"
            .parse()
            .unwrap();
        let value: DoubleDouble = "-0.01825894979490287049077536165287874039168"
            .parse()
            .unwrap();
        assert!(((sequences.lap_end() - end) / end).abs().to_f64() < 1e-30);
        let ratio = limits.product / sequences.constants.lambda;
        let upsilon = -ratio * ratio / DoubleDouble::from(8.0);
        assert!(((upsilon - value) / value).abs().to_f64() < 1e-30);
    }

    #[test]
    fn doubled_and_plain_ways_meet() {
        for restitution in ["0.96", "0.99", "0.999"] {
            let sequences = Sequences::new(Constants::new(restitution.parse().unwrap()).unwrap());
            let plain = Sequences {
                constants: sequences.constants,
                map: sequences.map,
                doubled: Vec::new(),
            };
            assert!(!sequences.doubled.is_empty());
            for sigma in [0.0, 0.2, 0.5] {
                let sigma = DoubleDouble::from(sigma);
                let graze = plain.at(DoubleDouble::ZERO);
                let short = sequences.limits(sequences.at(sigma), graze);
                let long = plain.limits(plain.at(sigma), graze);
                for (a, b) in [
                    (short.own, long.own),
                    (short.quotient, long.quotient),
                    (short.product, long.product),
                ] {
                    assert!(
                        ((a - b) / b).abs().to_f64() < 2e-28,
                        "{restitution} {sigma} {a} {b}"
                    );
                }
            }
        }
    }
}
