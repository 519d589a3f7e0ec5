//! Where a section is crossed within a step, and on which side of it the step ends: see [`sides`](super::sides).

use crate::numerics::Real;
use crate::numerics::polynomial::{horner, horner_with_slope, magnitude};
use crate::numerics::roots::{Crossing, Root, RootKind, first_root};

/// The function of a section along a step, roots that are known to lie at its start divided out.
#[derive(Clone, Copy)]
pub(crate) struct SectionPath<'a, R> {
    pub series: &'a [R],
    pub crossing: Crossing,
    /// The side that the trajectory comes from; zero if that is not known.
    pub side: R,
    /// The side that the motion is on from here, where its field is that of a side of this very surface; zero otherwise.
    pub kept: R,
    /// The sizes, added up, of the terms that the value at the start is the sum of.
    pub terms: R,
    /// How far the series reaches, however short the step is: rounding is told by the size that it has there.
    pub reach: R,
    /// Relative size of rounding.
    pub noise: f64,
}

/// How a path stands to its section where it begins.
struct Start<R> {
    /// Coefficients below this one make no difference that could be told from zero.
    order: usize,
    /// The sign just after the start.
    sign: R,
    /// That is not the side that the trajectory comes from, and the change counts.
    crossed: bool,
}

/// Newton's method from the start converges at once: what is left of the way is rounding.
const NEWTON_STEPS: usize = 4;

/// Start and end of a step are approached by so many halvings of the distance to them, in search of a sign.
const HALVINGS: i32 = 100;

impl<R: Real> SectionPath<'_, R> {
    fn start(&self) -> Option<Start<R>> {
        let largest = magnitude(self.series, self.reach);
        let level = largest.max(self.terms) * R::splat(self.noise);
        // It is nowhere as far from zero as that, as where the trajectory rests in it.
        if largest <= level {
            return None;
        }
        let (order, sign) = if self.series[0].abs() > level {
            (0, unit(self.series[0]))
        } else {
            // As far away as the function can be told from zero, and by the coefficient that brings that about.
            let mut away = (0..=HALVINGS).rev().map(|k| self.reach * halved(k));
            let at = away.find(|&at| horner(self.series, at).abs() > level)?;
            let (mut order, mut largest, mut power) = (0, R::ZERO, R::ONE);
            for (k, &c) in self.series.iter().enumerate().skip(1) {
                power *= at;
                if (c * power).abs() > largest {
                    (order, largest) = (k, (c * power).abs());
                }
            }
            self.on_its_side((order, unit(horner(self.series, at))))
        };
        let counts = self.crossing == Crossing::Either || sign < R::ZERO;
        Some(Start {
            order,
            sign,
            crossed: self.side * sign < R::ZERO && counts,
        })
    }

    /// The field says on which side of its own surface it goes on, and not what the function comes to far away: a short flight on the
    /// other side would be passed over.
    fn on_its_side(&self, found: (usize, R)) -> (usize, R) {
        let leads = |&(_, &c): &(usize, &R)| c * self.kept > R::ZERO;
        let mut rising = self.series.iter().enumerate().skip(1).filter(leads);
        match (self.kept * found.1 < R::ZERO, rising.next()) {
            (true, Some((order, _))) => (order, self.kept),
            _ => found,
        }
    }

    /// Where the section is crossed first in (0, width), or at 0 if the trajectory has come from its other side. A crossing
    /// that cannot be told from the end, and so from what happens there, is left for what follows.
    pub(crate) fn first(&self, width: R) -> Option<Root<R>> {
        // The trajectory may run within the surface, as one at rest does in that of its velocity: then there is no start.
        let start = self.start()?;
        let rest = &self.series[start.order..];
        let root = if start.crossed {
            Root {
                at: self.passing(&start),
                kind: RootKind::Crossing,
            }
        } else {
            first_root(rest, width, self.crossing, self.level(rest, width))?
        };
        let is_distinct = || {
            let middle = (root.at + width) * R::splat(0.5);
            [middle, width]
                .iter()
                .any(|&s| horner(rest, s).abs() > self.level(rest, width))
        };
        (root.at < width && is_distinct()).then_some(root)
    }

    /// Whether the section is crossed where the path begins; and if so, whether by a jump.
    pub(crate) fn crossed_at_start(&self) -> Option<bool> {
        let start = self.start().filter(|start| start.crossed)?;
        Some(start.order == 0)
    }

    /// The crossing at the end of a step that stops short of it by no more than rounding, that of the time included, which leaves so
    /// much `open`.
    pub(crate) fn at_end(&self, width: R, open: R) -> Option<Root<R>> {
        let at_end = Root {
            at: width,
            kind: RootKind::Crossing,
        };
        let start = self.start()?;
        if start.crossed {
            return Some(at_end);
        }
        let rest = &self.series[start.order..];
        let (value, slope) = horner_with_slope(rest, width);
        let side = self.sign_before(rest, width, start.sign);
        let counts = self.crossing == Crossing::Either || side > R::ZERO;
        let unclear = value.abs() <= self.level(rest, width).max(slope.abs() * open);
        (counts && unclear && side * slope < R::ZERO).then_some(at_end)
    }

    /// The side on which a step of this length ends without a crossing that was told.
    pub(crate) fn side_at(&self, width: R) -> R {
        match self.start() {
            Some(start) if !start.crossed => {
                self.sign_before(&self.series[start.order..], width, start.sign)
            }
            _ => self.side,
        }
    }

    /// The side just after a crossing that ended the step.
    pub(crate) fn side_after(&self, width: R) -> R {
        match (self.crossing, self.start()) {
            (Crossing::Falling, _) => R::splat(-1.0),
            (Crossing::Either, Some(start)) if start.crossed => start.sign,
            (Crossing::Either, _) => -self.side_at(width),
        }
    }

    fn level(&self, series: &[R], width: R) -> R {
        magnitude(series, width) * R::splat(self.noise)
    }

    /// Where a function that cannot be told from zero at the start is zero: there, or what is left of the way to it.
    fn passing(&self, start: &Start<R>) -> R {
        let ahead = self.side * self.series[0] > R::ZERO;
        if start.order != 1 || !ahead {
            return R::ZERO;
        }
        let mut at = R::ZERO;
        for _ in 0..NEWTON_STEPS {
            let (value, slope) = horner_with_slope(self.series, at);
            at -= value / slope;
        }
        at.max(R::ZERO)
    }

    /// The sign of a series just before `width`, by the nearest value that can be told from zero.
    fn sign_before(&self, series: &[R], width: R, otherwise: R) -> R {
        let level = self.level(series, width);
        let mut distance = R::ZERO;
        for k in (0..=HALVINGS).rev() {
            let value = horner(series, width - distance);
            if value.abs() > level {
                return unit(value);
            }
            distance = width * halved(k);
        }
        otherwise
    }
}

fn unit<R: Real>(value: R) -> R {
    if value < R::ZERO {
        R::splat(-1.0)
    } else {
        R::ONE
    }
}

fn halved<R: Real>(times: i32) -> R {
    R::splat(libm::ldexp(1.0, -times))
}
