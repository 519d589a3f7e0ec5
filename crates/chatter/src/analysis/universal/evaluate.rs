//! Upsilon and its derivative, for one number or several lanes.

use super::argument::Argument;
use super::chatter_map::{ChatterMap, GRAZE};
use super::constants::Constants;
use super::error::UniversalError;
use super::lap::Lap;
use super::scales::{Scales, lift};
use super::sequence::Sequences;
use crate::numerics::dispatch::{Kernel, dispatch};
use crate::numerics::{DoubleDouble, Real};

/// The universal function Upsilon for one restitution.
///
/// Values are accurate to a few units of rounding error relative to themselves, except near the zeros of Upsilon, where
/// the error is that small relative to the size of Upsilon around; the argument is taken as exact. Values too small for
/// the number type are zero, and a subnormal argument (below 2.2e-308) counts as zero. Near the ends of the doubles' range a value above 1e285 may come out infinite.
#[derive(Clone, Debug)]
pub struct Universal<R> {
    constants: Constants<R>,
    lap_end: R,
    exact: Exact,
    pub(super) lap: Lap<R>,
    scales: Scales<R>,
}

/// What the atlas computes with, whatever the number type.
#[derive(Clone, Copy, Debug)]
pub(super) struct Exact {
    pub constants: Constants<DoubleDouble>,
    pub lap_end: DoubleDouble,
}

/// Upsilon at a point, with its derivative and the impact that decides it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Evaluation<T> {
    /// Upsilon(x).
    pub value: T,
    /// Upsilon'(x): minus infinity at a lap's end eta^n x_e, where the graph has infinite slope on its left; zero for
    /// x <= 0.
    pub derivative: T,
    /// n of the lap eta^(n + 1) x_e < x <= eta^n x_e; negative above x_e by self-similarity; infinite for x <= 0.
    pub lap: T,
    /// u_1 in (g^-1(3/8), 3/8], the last impact but one; u* for x <= 0, where the impacts never end.
    pub u1: T,
}

impl<R: Real> Universal<R> {
    /// Prepares Upsilon for a restitution in the open interval (0, 1).
    ///
    /// # Errors
    /// [`UniversalError::Restitution`] where it is outside, or NaN.
    pub fn new(restitution: R) -> Result<Self, UniversalError> {
        let constants = Constants::new(restitution)?;
        let exact = Constants::new(restitution.to_double_double())?;
        let sequences = Sequences::new(exact);
        let lap_end = sequences.lap_end();
        Ok(Self {
            constants,
            lap_end: R::from_double_double(lap_end),
            exact: Exact {
                constants: exact,
                lap_end,
            },
            lap: Lap::new(&sequences),
            scales: Scales::new(&exact, lap_end),
        })
    }

    /// The same in double precision.
    pub(super) fn double(&self) -> Result<Universal<f64>, UniversalError> {
        Universal::new(self.constants.restitution.to_f64())
    }

    /// What the restitution determines in closed form.
    pub fn constants(&self) -> &Constants<R> {
        &self.constants
    }

    /// The map of one flight and impact.
    pub fn chatter_map(&self) -> ChatterMap<R> {
        ChatterMap::new(&self.constants)
    }

    /// x_e = Q(3/8): the end of lap 0.
    pub fn lap_end(&self) -> R {
        self.lap_end
    }

    pub(super) fn exact(&self) -> &Exact {
        &self.exact
    }

    /// The values of Q on lap 0: from eta x_e (excluded) to x_e.
    pub fn window(&self) -> (R, R) {
        (self.constants.eta * self.lap_end, self.lap_end)
    }

    /// Upsilon at `x`, on any number of lanes. To be inlined into a loop run by
    /// [`dispatch`](crate::numerics::dispatch::dispatch); for a single value see [`value`](Self::value).
    #[inline(always)]
    pub fn upsilon<T: Argument<Real = R>>(&self, x: T) -> T {
        let (inside, safe) = Self::inside(x);
        let placed = self.scales.place(safe, &self.lap.mark);
        let value = self.lap.value(placed.phase, placed.from_mark) * self.scales.value(&placed);
        T::select(inside, value, Self::outside(x))
    }

    /// Upsilon, its derivative, n and u_1 at `x`, on any number of lanes; to be inlined as [`upsilon`](Self::upsilon).
    #[inline(always)]
    pub fn evaluation<T: Argument<Real = R>>(&self, x: T) -> Evaluation<T> {
        let (inside, safe) = Self::inside(x);
        let placed = self.scales.place(safe, &self.lap.mark);
        let on_lap = self.lap.evaluate(placed.phase, placed.from_mark);
        let outside = Self::outside(x);
        let graze = T::splat(GRAZE);
        Evaluation {
            value: T::select(inside, on_lap.value * self.scales.value(&placed), outside),
            derivative: T::select(inside, on_lap.slope * self.scales.slope(&placed), outside),
            lap: T::select(inside, placed.lap, outside + T::splat(f64::INFINITY)),
            u1: T::select(
                inside,
                graze - graze * on_lap.root * on_lap.root,
                outside + lift(self.constants.chatter_fixed_point),
            ),
        }
    }

    /// Where Upsilon is to be computed, and `x` with something harmless elsewhere.
    #[inline(always)]
    fn inside<T: Argument<Real = R>>(x: T) -> (T::Mask, T) {
        let inside = T::splat(f64::MIN_POSITIVE).at_most(x) & x.is_finite();
        (inside, T::select(inside, x, T::splat(1.0)))
    }

    /// Zero for x <= 0 and subnormal x; NaN for NaN and for plus infinity, where Upsilon has no limit.
    #[inline(always)]
    fn outside<T: Argument<Real = R>>(x: T) -> T {
        T::select(
            x.less(T::splat(f64::MIN_POSITIVE)),
            T::splat(0.0),
            T::splat(f64::NAN),
        )
    }
}

struct Value<'a, R>(&'a Universal<R>, R);

impl<R: Real + Argument<Real = R>> Kernel for Value<'_, R> {
    type Output = R;
    #[inline(always)]
    fn run(self) -> R {
        self.0.upsilon(self.1)
    }
}

struct At<'a, R>(&'a Universal<R>, R);

impl<R: Real + Argument<Real = R>> Kernel for At<'_, R> {
    type Output = Evaluation<R>;
    #[inline(always)]
    fn run(self) -> Evaluation<R> {
        self.0.evaluation(self.1)
    }
}

impl<R: Real + Argument<Real = R>> Universal<R> {
    /// Upsilon(x); zero for x <= 0, NaN for NaN and infinity.
    pub fn value(&self, x: R) -> R {
        dispatch(Value(self, x))
    }

    /// Upsilon(x), its derivative, n and u_1.
    pub fn at(&self, x: R) -> Evaluation<R> {
        dispatch(At(self, x))
    }

    /// Upsilon''(x), to about half the digits: for Newton's method. NaN outside x > 0.
    pub fn curvature(&self, x: R) -> R {
        if !(x >= R::splat(f64::MIN_POSITIVE) && x.is_finite()) {
            return R::splat(f64::NAN);
        }
        let placed = self.scales.place(x, &self.lap.mark);
        let by_phase = self.lap.curvature(placed.phase, placed.from_mark);
        let rest = self.constants.one_minus_eta;
        // d phase / dx = -(eta^-n / x_e) / (1 - eta), and x eta^-n / x_e = 1 - (1 - eta) phase.
        by_phase * self.scales.slope(&placed) * (rest * placed.phase - R::ONE) / (rest * x)
    }
}
