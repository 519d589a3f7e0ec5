//! For which n and K there is chaos, and over which mu.
//!
//! Just beyond the graze of lap n the map falls like a square root towards the lap's end and goes on with the slope s of
//! the next lap's beginning, s = K sup Upsilon' (lambda^2 / eta)^(n - 1). In y = e - x, with A = e - F(e),
//!
//! ```text
//! y -> A - k sqrt(y)   (y > 0),      y -> A + s y   (y < 0)
//! ```
//!
//! holds ever better the smaller A is, and the orbits of one point on lap n and m on lap n - 1 are stable for A between
//! (3/4) s^2m k^2 / S and (s^m k / (S - 1))^2, S = 1 + s + … + s^m. As m grows these windows overlap for s < 1/4, leave gaps
//! of chaos for 1/4 < s < 2/3, and do not exist for s > 2/3, where all is chaos; for s > 1 the next fixed point is born at a
//! fold, away from the graze.

use super::super::argument::Argument;
use super::super::error::UniversalError;
use super::super::evaluate::Universal;
use super::periodic::Atlas;
use crate::numerics::Real;
use core::ops::RangeInclusive;

/// What lies on the other side of the graze of a lap, by the slope s there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Regime {
    /// s < -1: the fixed point beyond is unstable.
    Unstable,
    /// -1 < s < 0: it is stable; no chaos.
    Hysteresis,
    /// 0 < s < 1/4: windows of added periods overlap; no chaos.
    Adding,
    /// 1/4 < s < 2/3: windows of added periods, and chaos between them.
    Alternating,
    /// 2/3 < s < 1: chaos without windows.
    Chaos,
    /// s > 1: the next fixed point is born at a fold.
    Fold,
}

impl Regime {
    /// s above which windows of added periods leave gaps, above which there are none, and above which folds are.
    pub const LIMITS: [f64; 3] = [0.25, 2.0 / 3.0, 1.0];

    fn of(slope: f64) -> Self {
        let [gaps, none, fold] = Self::LIMITS;
        match slope {
            s if s < -1.0 => Self::Unstable,
            s if s < 0.0 => Self::Hysteresis,
            s if s < gaps => Self::Adding,
            s if s < none => Self::Alternating,
            s if s < fold => Self::Chaos,
            _ => Self::Fold,
        }
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Unstable => "unstable",
            Self::Hysteresis => "hysteresis",
            Self::Adding => "adding",
            Self::Alternating => "alternating",
            Self::Chaos => "chaos",
            Self::Fold => "fold",
        }
    }
}

/// Chaos next to the windows of a lap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Chaos<R> {
    /// n.
    pub lap: i64,
    /// s: slope of the map to the right of the end of the lap.
    pub kink_slope: R,
    /// What that makes of the neighbourhood of the graze.
    pub regime: Regime,
    /// The slopes K at which s takes the values [`Regime::LIMITS`]: there is chaos next to the graze for K above the first.
    pub slopes: [R; 3],
    /// Where the stable fixed point of the lap ends in chaos: the accumulation of its period doublings; the period doubling
    /// itself where it is subcritical or its cascade breaks off; none where there is none.
    pub onset: Option<R>,
    /// Where the stable fixed point of the next lap is born and chaos ends, if it lies beyond the onset.
    pub end: Option<R>,
    /// The part of the values of mu between onset and end at which an orbit has a positive Lyapunov exponent.
    pub share: Option<f64>,
}

/// Values of mu at which exponents are taken, iterates passed over and used for each, and the least that counts as positive:
/// what the latter leave uncertain.
const VALUES: usize = 256;
const TRANSIENT: usize = 1000;
const ITERATES: usize = 2000;
const POSITIVE: f64 = 0.01;

impl<R: Real + Argument<Real = R>> Universal<R> {
    /// Chaos next to the windows of these laps.
    ///
    /// # Errors
    /// [`UniversalError::Slope`] where K is zero or not finite.
    pub fn chaos(
        &self,
        slope: R,
        laps: RangeInclusive<i64>,
    ) -> Result<Vec<Chaos<R>>, UniversalError> {
        let scaling = self.scaling(slope)?;
        let double = self.double()?;
        let atlas = Atlas::new(self, slope, &double);
        let c = self.constants();
        let chaos = laps.map(|lap| {
            let ln_ratio = c.ln_lambda + c.ln_lambda - c.ln_eta;
            let kink_slope = scaling.kink_slope * (ln_ratio * R::splat((lap - 1) as f64)).exp();
            let (onset, end) = atlas.chaotic(lap);
            let share = onset.zip(end).map(|(onset, end)| {
                positive_share(&double, slope.to_f64(), onset.to_f64(), end.to_f64())
            });
            Chaos {
                lap,
                kink_slope,
                regime: Regime::of(kink_slope.to_f64()),
                slopes: Regime::LIMITS.map(|limit| R::splat(limit) * slope / kink_slope),
                onset,
                end,
                share,
            }
        });
        Ok(chaos.collect())
    }
}

impl<R: Real + Argument<Real = R>> Atlas<'_, R> {
    /// Onset and end of chaos.
    fn chaotic(&self, lap: i64) -> (Option<R>, Option<R>) {
        let (universal, slope) = (self.family.universal, self.family.slope);
        let window = universal.window_of(slope, lap);
        let Some(doubling) = window.period_doubling else {
            return (None, None);
        };
        let cascade = self.cascade(lap);
        let onset = cascade.map_or(doubling.mu, |cascade| cascade.accumulation);
        let rises = slope > R::ZERO;
        let next = universal.window_of(slope, if rises { lap - 1 } else { lap + 1 });
        // Without a fold the next fixed point begins at this graze; for K < 0 there always is one.
        let end = next.fold.unwrap_or(window.grazing).mu;
        let beyond = if rises { end > onset } else { end < onset };
        (Some(onset), beyond.then_some(end))
    }
}

fn positive_share(universal: &Universal<f64>, slope: f64, onset: f64, end: f64) -> f64 {
    let positive = (0..VALUES).filter(|&k| {
        let mu = onset + (end - onset) * (k as f64 + 0.5) / VALUES as f64;
        // The critical point's image lies in the attractor, or is attracted by it.
        let mut x = mu;
        for _ in 0..TRANSIENT {
            x = slope * universal.value(x) + mu;
        }
        let mut sum = 0.0;
        for _ in 0..ITERATES {
            let at = universal.at(x);
            sum += libm::log((slope * at.derivative).abs());
            x = slope * at.value + mu;
        }
        sum / ITERATES as f64 > POSITIVE
    });
    positive.count() as f64 / VALUES as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::DoubleDouble;

    #[test]
    fn limits_of_the_slope_are_where_windows_meet() {
        // Ends of the window with m added points, over k^2.
        let ends = |s: f64, m: i32| {
            let sum: f64 = (0..=m).map(|i| libm::pow(s, f64::from(i))).sum();
            let power = libm::pow(s, 2.0 * f64::from(m));
            (0.75 * power / sum, power / ((sum - 1.0) * (sum - 1.0)))
        };
        const MANY: i32 = 40;
        for (limit, side) in [
            (0.25, -1.0),
            (0.25, 1.0),
            (2.0 / 3.0, -1.0),
            (2.0 / 3.0, 1.0),
        ] {
            let s = limit + side * 0.01;
            let (this, next) = (ends(s, MANY), ends(s, MANY + 1));
            assert_eq!(this.0 < next.1, s < 0.25, "{s}");
            assert_eq!(this.0 < this.1, s < 2.0 / 3.0, "{s}");
        }
    }

    #[test]
    fn chaos_is_where_it_is_said_to_be() {
        let universal = Universal::new(DoubleDouble::from(0.8)).unwrap();
        let of = |laps| universal.chaos(DoubleDouble::ONE, laps).unwrap();
        for window in &[of(5..=20), of(70..=80)].concat() {
            let s = window.kink_slope.to_f64();
            // The slope to the right of the lap's end, by Upsilon itself.
            let end = universal.window_of(DoubleDouble::ONE, window.lap).grazing.x;
            let beside = universal
                .at(end * DoubleDouble::from(1.0 + 1e-12))
                .derivative
                .to_f64();
            assert!((beside / s - 1.0).abs() < 1e-9);
            let fold = universal.window_of(DoubleDouble::ONE, window.lap - 1).fold;
            assert_eq!(window.regime == Regime::Fold, fold.is_some());
            let limit = window.slopes[2];
            let at_limit = universal.scaling(limit).unwrap().last_smooth_birth.to_f64();
            assert!((at_limit - (window.lap - 1) as f64).abs() < 1e-6);
            if window.lap <= 15 {
                assert!(window.share.unwrap() > 0.7, "{window:?}");
            }
            if window.lap > 75 {
                assert_eq!(window.regime, Regime::Adding);
                assert!(window.share.unwrap() < 0.05, "{window:?}");
            }
        }
    }
}
