//! Piecewise expressions: what a surface's sign chooses, whole parts, curves through given points, and the functions that
//! are made of them.
//!
//! Each is smooth where no surface is crossed. Plain evaluation chooses by value; a flow chooses by its mode, so that it
//! only ever sees the smooth pieces ([`corners`](crate::expressions::corners)).

mod decided;

use crate::expressions::curve::Curve;
use crate::expressions::{Expr, Function, Graph, Node};
use crate::numerics::{DoubleDouble, Real};
use std::sync::Arc;

/// What a choice by sign gives where its surface is exactly zero.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum Edge {
    /// The piece of the positive side: a comparison that includes equality.
    Above,
    /// The piece of the negative side: one that does not.
    Below,
    /// The mean of both, as the sign of zero.
    Middle,
}

/// Handle of a curve in the [`Graph`] that holds it.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub struct CurveId(u32);

/// Something that is true or false, as the first argument of `if`.
#[derive(Clone, PartialEq, Debug)]
pub enum Condition {
    /// The expression is positive, or zero as the edge says.
    Positive(Expr, Edge),
    /// Both hold.
    And(Box<Condition>, Box<Condition>),
    /// One holds at least.
    Or(Box<Condition>, Box<Condition>),
    /// It does not hold.
    Not(Box<Condition>),
}

/// Highest derivative of a curve that is not zero everywhere: its pieces are cubic.
const HIGHEST_DERIVATIVE: u8 = 3;

impl Edge {
    fn flipped(self) -> Self {
        match self {
            Self::Above => Self::Below,
            Self::Below => Self::Above,
            Self::Middle => Self::Middle,
        }
    }

    /// The value of a choice whose surface, and whose pieces on both sides, have these values.
    pub fn choose<R: Real>(self, surface: R, above: R, below: R) -> R {
        if surface > R::ZERO {
            above
        } else if surface < R::ZERO {
            below
        } else if surface == R::ZERO {
            match self {
                Self::Above => above,
                Self::Below => below,
                Self::Middle => (above + below) * R::splat(0.5),
            }
        } else {
            surface
        }
    }

    /// The piece that alone is chosen where the surface has this value, if one is.
    pub(crate) fn chosen(self, surface: f64, above: Expr, below: Expr) -> Option<Expr> {
        match (surface > 0.0, surface < 0.0, self) {
            (true, ..) => Some(above),
            (_, true, _) => Some(below),
            _ if surface != 0.0 => None,
            (.., Self::Above) => Some(above),
            (.., Self::Below) => Some(below),
            (.., Self::Middle) => None,
        }
    }
}

impl Graph {
    /// Whether any of the expressions is made of a choice, a whole part or a curve.
    pub fn has_corner(&self, exprs: &[Expr]) -> bool {
        let is_corner = |&part: &Expr| {
            matches!(
                self.node(part),
                Node::Switch { .. } | Node::Floor(_) | Node::Curve(..)
            )
        };
        self.reachable(exprs).iter().any(is_corner)
    }

    /// `above` where `surface` is positive, `below` where it is negative.
    ///
    /// A surface and its negative, its multiples by numbers, and the same terms in another order are one surface.
    pub fn switch(&mut self, surface: Expr, above: Expr, below: Expr, edge: Edge) -> Expr {
        if above == below && self.can_vanish(surface) {
            return above;
        }
        if let Some(value) = self.as_number(surface) {
            let sign = value.high();
            let chosen = if sign > 0.0 || sign == 0.0 && edge == Edge::Above {
                Some(above)
            } else if sign < 0.0 || sign == 0.0 && edge == Edge::Below {
                Some(below)
            } else if sign == 0.0 {
                let half = self.number(0.5);
                let both = self.add(above, below);
                Some(self.mul(half, both))
            } else {
                None
            };
            if let Some(chosen) = chosen {
                return chosen;
            }
        }
        if let Some(decided) = self.decided(surface, above, below, edge) {
            return decided;
        }
        let one = self.number(1.0);
        let (coefficient, rest) = self.split_coefficient(surface, one);
        let rest = self.same_sign(rest);
        let (canonical, is_negated) = self.one_surface(rest);
        let flipped = is_negated != (coefficient.high() < 0.0);
        if !flipped {
            return self.intern(Node::Switch {
                surface: canonical,
                above,
                below,
                edge,
            });
        }
        let minus_above = self.neg(above);
        if edge == Edge::Middle && minus_above == below {
            let sign = self.intern(Node::Switch {
                surface: canonical,
                above,
                below,
                edge,
            });
            return self.neg(sign);
        }
        self.intern(Node::Switch {
            surface: canonical,
            above: below,
            below: above,
            edge: edge.flipped(),
        })
    }

    /// The surface on which a sum vanishes, and whether it is the sum's negative: of all sums that differ in sign and order
    /// alone the one that was a surface first.
    fn one_surface(&mut self, sum: Expr) -> (Expr, bool) {
        let Node::Sum(terms) = self.node(sum).clone() else {
            return (sum, false);
        };
        let sorted = |mut terms: Vec<Expr>| {
            terms.sort_unstable();
            terms
        };
        let negated: Vec<Expr> = terms.iter().map(|&term| self.neg(term)).collect();
        let minus_sum = self.sum(&negated);
        // The negative of what is itself the negative of a sum has that one's terms.
        let negated = match self.node(minus_sum) {
            Node::Sum(terms) => terms.to_vec(),
            _ => negated,
        };
        let terms = negated.iter().map(|&term| self.neg(term)).collect();
        let (terms, negated) = (sorted(terms), sorted(negated));
        if let Some(&known) = self.surfaces.get(&terms) {
            return (known, false);
        }
        if let Some(&known) = self.surfaces.get(&negated) {
            return (known, true);
        }
        let is_negated = minus_sum < sum;
        let (terms, surface) = if is_negated {
            (negated, minus_sum)
        } else {
            (terms, sum)
        };
        self.surfaces.insert(terms, surface);
        (surface, is_negated)
    }

    /// `|x|`.
    pub fn abs(&mut self, x: Expr) -> Expr {
        let minus_x = self.neg(x);
        self.switch(x, x, minus_x, Edge::Above)
    }

    /// 1 where x is positive, -1 where it is negative, 0 at zero.
    pub fn sign(&mut self, x: Expr) -> Expr {
        let (plus, minus) = (self.number(1.0), self.number(-1.0));
        self.switch(x, plus, minus, Edge::Middle)
    }

    /// 1 where x is zero or more, else 0.
    pub fn step(&mut self, x: Expr) -> Expr {
        let (one, zero) = (self.number(1.0), self.number(0.0));
        self.switch(x, one, zero, Edge::Above)
    }

    /// The larger one.
    pub fn max(&mut self, a: Expr, b: Expr) -> Expr {
        let difference = self.sub(a, b);
        self.switch(difference, a, b, Edge::Above)
    }

    /// The smaller one.
    pub fn min(&mut self, a: Expr, b: Expr) -> Expr {
        let difference = self.sub(a, b);
        self.switch(difference, b, a, Edge::Above)
    }

    /// x, or the bound that it exceeds: the smaller one of `high` and the larger one of `low` and x, told by the sides of `low`
    /// and `high` on which x is, which other choices may share.
    pub fn clamp(&mut self, x: Expr, low: Expr, high: Expr) -> Expr {
        let inside = self.min(x, high);
        let outside = self.min(low, high);
        let above_low = self.sub(x, low);
        self.switch(above_low, inside, outside, Edge::Above)
    }

    /// The largest whole number that does not exceed x.
    pub fn floor(&mut self, x: Expr) -> Expr {
        if let Some(value) = self.as_number(x) {
            return self.number_exact(floor(value));
        }
        self.intern(Node::Floor(x))
    }

    /// What is left of x after the whole multiples of m below it: in `[0, m)` for positive m.
    pub fn modulo(&mut self, x: Expr, m: Expr) -> Expr {
        let turns = self.div(x, m);
        let whole = self.floor(turns);
        let whole = self.mul(m, whole);
        self.sub(x, whole)
    }

    /// `sqrt(x^2 + y^2)`.
    pub fn hypot(&mut self, x: Expr, y: Expr) -> Expr {
        let two = self.number(2.0);
        let (x, y) = (self.power(x, two), self.power(y, two));
        let square = self.add(x, y);
        self.sqrt(square)
    }

    /// The angle of the point (x, y), in (-pi, pi]: by the inverse tangent of a quotient of at most one in each of the four
    /// sectors around the axes. Behind the origin it jumps.
    pub fn atan2(&mut self, y: Expr, x: Expr) -> Expr {
        let pi = self.pi();
        let half = self.number(0.5);
        let quarter = self.mul(half, pi);
        let beside = self.sub(x, y);
        let above = self.add(x, y);
        let slope = self.div(y, x);
        let right = self.call(Function::Atan, slope);
        let inverse = self.div(x, y);
        let inverse = self.call(Function::Atan, inverse);
        let top = self.sub(quarter, inverse);
        let bottom = self.sub(top, pi);
        let left = {
            let upper = self.add(right, pi);
            let lower = self.sub(right, pi);
            self.switch(y, upper, lower, Edge::Above)
        };
        let first = self.switch(above, right, bottom, Edge::Above);
        let second = self.switch(above, top, left, Edge::Above);
        self.switch(beside, first, second, Edge::Above)
    }

    /// `yes` where a condition holds, `no` where it does not.
    pub fn choose(&mut self, condition: &Condition, yes: Expr, no: Expr) -> Expr {
        match condition {
            Condition::Positive(surface, edge) => self.switch(*surface, yes, no, *edge),
            Condition::And(a, b) => {
                let both = self.choose(b, yes, no);
                self.choose(a, both, no)
            }
            Condition::Or(a, b) => {
                let either = self.choose(b, yes, no);
                self.choose(a, yes, either)
            }
            Condition::Not(condition) => self.choose(condition, no, yes),
        }
    }

    /// Holds a curve, so that expressions may use it.
    pub fn add_curve(&mut self, curve: Curve) -> CurveId {
        let id = CurveId(u32::try_from(self.curves.len()).expect("2^32 curves exceed memory"));
        self.curves.push(Arc::new(curve));
        id
    }

    /// The curve of that name.
    pub fn curve_named(&self, name: &str) -> Option<CurveId> {
        let place = self.curves.iter().position(|curve| curve.name() == name)?;
        Some(CurveId(place as u32))
    }

    /// The curve behind a handle of this graph.
    pub fn curve(&self, id: CurveId) -> &Arc<Curve> {
        &self.curves[id.0 as usize]
    }

    /// Names of all curves, each once.
    pub fn curve_names(&self) -> impl Iterator<Item = &str> {
        let names = self.curves.iter().map(|curve| curve.name()).enumerate();
        let is_first = |&(place, name): &(usize, &str)| {
            let before = &self.curves[..place];
            before.iter().all(|curve| curve.name() != name)
        };
        names.filter(is_first).map(|(_, name)| name)
    }

    /// A curve, or a derivative of it, at an argument.
    pub fn curve_at(&mut self, id: CurveId, argument: Expr, derivative: u8) -> Expr {
        if derivative > HIGHEST_DERIVATIVE {
            return self.number(0.0);
        }
        self.intern(Node::Curve(id, argument, derivative))
    }
}

/// The largest whole number that does not exceed x.
pub(crate) fn floor<R: Real>(x: R) -> R {
    let wide = x.to_double_double();
    let whole = libm::floor(wide.high());
    let below = if whole == wide.high() {
        libm::floor(wide.low())
    } else {
        0.0
    };
    R::from_double_double(DoubleDouble::from(whole) + DoubleDouble::from(below))
}
