//! Fixed points of x -> K Upsilon(x) + mu, lap by lap (MATH.md 7).
//!
//! They lie on the explicit curve mu(x) = x - K Upsilon(x), with multiplier K Upsilon'(x). On each lap Upsilon is concave
//! for every restitution, so its derivative falls from a positive value at the lap's beginning to minus infinity at its
//! end, and each event below happens at most once.

use super::argument::Argument;
use super::error::UniversalError;
use super::evaluate::Universal;
use crate::numerics::root_between;
use crate::numerics::{DoubleDouble, Real, Scalar};
use core::ops::RangeInclusive;
use serde::{Deserialize, Serialize};

/// A located point of the curve of periodic points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Located<R> {
    /// Offset of the map.
    pub mu: R,
    /// Argument of Upsilon, K z + mu.
    pub x: R,
    /// The point of the map itself, z = Upsilon(x).
    pub z: R,
    /// How far the defining equation is from holding: multiplier less the one sought, zero at a graze, which is exact.
    pub residual: R,
}

/// The fixed points on one lap, or what is made of each.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Window<P> {
    /// n.
    pub lap: i64,
    /// Multiplier +1. Where there is none (K > 0 and n beyond the last fold), the stable window begins at the kink, at
    /// the grazing of lap n + 1.
    pub fold: Option<P>,
    /// Multiplier -1. Where there is none (K < 0 and n beyond the last), the window begins at the kink.
    pub period_doubling: Option<P>,
    /// Multiplier 0.
    pub superstable: P,
    /// The lap's end, u_1 = 3/8.
    pub grazing: P,
}

impl<P: Copy> Window<P> {
    /// Fold, period doubling and graze.
    pub fn ends(&self) -> [Option<P>; 3] {
        [self.fold, self.period_doubling, Some(self.grazing)]
    }

    /// What is made of each point.
    pub fn map<Q>(self, by: impl Fn(P) -> Q) -> Window<Q> {
        Window {
            lap: self.lap,
            fold: self.fold.map(&by),
            period_doubling: self.period_doubling.map(&by),
            superstable: by(self.superstable),
            grazing: by(self.grazing),
        }
    }
}

impl<R: Real + Argument<Real = R>> Universal<R> {
    /// The fixed points of z -> Upsilon(K z + mu) for each n of `laps`, over all mu.
    ///
    /// In double precision mu is good to 14 digits for r > 0.1, and to fewer where laps are long: for an atlas of full
    /// precision, prepare Upsilon in double-double and round.
    ///
    /// # Errors
    /// [`UniversalError::Slope`] where K is zero or not finite.
    pub fn windows(
        &self,
        slope: R,
        laps: RangeInclusive<i64>,
    ) -> Result<Vec<Window<Located<R>>>, UniversalError> {
        self.windows_remembered(slope, None, laps)
    }

    /// The same for orbits of which those that repeat obey this map, but which remember more than z: the period doubles where it
    /// does at another slope, at the same arguments of Upsilon.
    ///
    /// # Errors
    /// As for [`windows`](Self::windows).
    pub fn windows_remembered(
        &self,
        slope: R,
        doubling_slope: Option<R>,
        laps: RangeInclusive<i64>,
    ) -> Result<Vec<Window<Located<R>>>, UniversalError> {
        UniversalError::check_slope(slope)?;
        let window = |lap| self.window_remembered(slope, doubling_slope, lap);
        Ok(laps.map(window).collect())
    }

    /// One of these.
    pub(crate) fn window_remembered(
        &self,
        slope: R,
        doubling_slope: Option<R>,
        lap: i64,
    ) -> Window<Located<R>> {
        let mut window = self.window_of(slope, lap);
        if let Some(other) = doubling_slope {
            let doubling = self.window_of(other, lap).period_doubling;
            window.period_doubling = doubling.map(|located| Located {
                mu: located.x - slope * located.z,
                ..located
            });
        }
        window
    }

    /// The fixed points on one lap. Where K is zero or no number there are no events but the graze.
    pub(crate) fn window_of(&self, slope: R, lap: i64) -> Window<Located<R>> {
        let on_lap = OnLap::new(self, slope, lap);
        let multiplier = |value: f64| on_lap.with_multiplier(R::splat(value));
        // The derivative takes every value from minus infinity to a positive one, so zero always.
        let superstable = multiplier(0.0).unwrap_or_else(|| on_lap.graze());
        Window {
            lap,
            fold: multiplier(1.0),
            period_doubling: multiplier(-1.0),
            superstable,
            grazing: on_lap.graze(),
        }
    }

    /// The critical point of a lap: where Upsilon' = 0.
    pub fn critical_point(&self, lap: i64) -> R {
        let on_lap = OnLap::new(self, R::ONE, lap);
        on_lap
            .with_multiplier(R::ZERO)
            .unwrap_or_else(|| on_lap.graze())
            .x
    }

    /// The greatest slope of Upsilon on lap 0: the one on the right of eta x_e. On lap n it is this times
    /// (lambda^2 / eta)^n.
    pub fn greatest_slope(&self) -> R {
        OnLap::new(self, R::ONE, 0).multiplier_at(R::ONE)
    }
}

/// One lap, in the square root of the phase: there the curve is smooth up to the graze, and points next to it are told
/// apart although their x are not.
struct OnLap<'a, R> {
    universal: &'a Universal<R>,
    slope: R,
    /// eta^n x_e.
    end: DoubleDouble,
    /// lambda^2n.
    value_scale: R,
    /// Multiplier over the derivative by the phase.
    multiplier_scale: R,
}

impl<'a, R: Real + Argument<Real = R>> OnLap<'a, R> {
    fn new(universal: &'a Universal<R>, slope: R, lap: i64) -> Self {
        let exact = universal.exact();
        let c = &exact.constants;
        let n = DoubleDouble::from(lap as f64);
        let end = (c.ln_eta * n).exp() * exact.lap_end;
        let ln_value_scale = c.ln_lambda * (n + n);
        let ln_ratio = ln_value_scale - c.ln_eta * n;
        let multiplier_scale = -ln_ratio.exp() / (exact.lap_end * c.one_minus_eta);
        Self {
            universal,
            slope,
            end,
            value_scale: R::from_double_double(ln_value_scale.exp()),
            multiplier_scale: R::from_double_double(multiplier_scale) * slope,
        }
    }

    fn slope_by_phase(&self, root: R) -> R {
        let lap = &self.universal.lap;
        let phase = root * root;
        lap.evaluate(phase, lap.distance_from_pole(phase)).slope
    }

    fn multiplier_at(&self, root: R) -> R {
        self.slope_by_phase(root) * self.multiplier_scale
    }

    fn with_multiplier(&self, multiplier: R) -> Option<Located<R>> {
        let target = multiplier / self.multiplier_scale;
        // The derivative by the phase falls from plus infinity at the graze.
        let mut low = R::ONE;
        if self.slope_by_phase(low) > target || !target.is_finite() {
            return None;
        }
        const SHRINK: f64 = 1.0 / 16.0;
        while self.slope_by_phase(low) <= target {
            low *= R::splat(SHRINK);
        }
        let high = (low * R::splat(1.0 / SHRINK)).min(R::ONE);
        let root = root_between(
            |root| (self.slope_by_phase(root) - target) * root,
            low,
            high,
        )?;
        Some(self.located(root, self.multiplier_at(root) - multiplier))
    }

    fn located(&self, root: R, residual: R) -> Located<R> {
        let lap = &self.universal.lap;
        let phase = root * root;
        let z = lap.value(phase, lap.distance_from_pole(phase)) * self.value_scale;
        let drop = phase.to_double_double() * self.universal.exact().constants.one_minus_eta;
        let x = self.end * (DoubleDouble::ONE - drop);
        // One rounding, at the end.
        let mu = x - (self.slope.to_double_double() * z.to_double_double());
        Located {
            mu: R::from_double_double(mu),
            x: R::from_double_double(x),
            z,
            residual,
        }
    }

    fn graze(&self) -> Located<R> {
        self.located(R::ZERO, R::ZERO)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RESTITUTIONS: [f64; 9] = [1e-6, 0.01, 0.1, 0.3, 0.5, 0.8, 0.95, 0.999, 1.0 - 1e-9];

    /// Without it, an event could happen twice on a lap.
    #[test]
    fn upsilon_is_concave_on_each_lap() {
        for r in RESTITUTIONS {
            let universal = Universal::new(r).unwrap();
            let on_lap = OnLap::new(&universal, 1.0, 0);
            let slopes: Vec<f64> = (1..=4000)
                .map(|k| on_lap.multiplier_at(f64::from(k) / 4000.0))
                .collect();
            assert!(slopes.windows(2).all(|pair| pair[0] < pair[1]), "{r}");
            assert_eq!(slopes.last(), Some(&universal.greatest_slope()));
            assert!(universal.greatest_slope() > 0.0);
        }
    }

    #[test]
    fn events_satisfy_their_equations() {
        const GRAZING: usize = 1;
        for r in RESTITUTIONS {
            let (double, fine) = (
                Universal::new(r).unwrap(),
                Universal::new(DoubleDouble::from(r)).unwrap(),
            );
            for slope in [1.0, -1.0, 4.6, 0.3, -7.0] {
                let windows = double.windows(slope, 0..=60).unwrap();
                let exact = fine.windows(DoubleDouble::from(slope), 0..=60).unwrap();
                for (window, exact) in windows.iter().zip(&exact) {
                    let events = [
                        (Some(window.superstable), Some(exact.superstable), 0.0),
                        (Some(window.grazing), Some(exact.grazing), 0.0),
                        (window.fold, exact.fold, 1.0),
                        (window.period_doubling, exact.period_doubling, -1.0),
                    ];
                    for (k, (event, exact, multiplier)) in events.into_iter().enumerate() {
                        assert_eq!(event.is_some(), exact.is_some());
                        let (Some(event), Some(exact)) = (event, exact) else {
                            continue;
                        };
                        // A double phase near one says less of x where laps are long.
                        let long = 1.0 / double.constants().eta;
                        let steep = 0.1 * (slope * double.greatest_slope()).abs();
                        assert!(
                            event.residual.abs() < 1e-13 * long.sqrt().max(steep),
                            "{r} {slope} {event:?}"
                        );
                        // Low parts near the end of the doubles' range underflow.
                        let digits = if event.x > 1e-100 { 1e-27 } else { 1e-20 };
                        assert!(
                            exact.residual.abs().to_f64() < digits * long.max(steep),
                            "{exact:?}"
                        );
                        let size = exact.mu.abs().to_f64() + exact.x.to_f64();
                        let off = (DoubleDouble::from(event.mu) - exact.mu).abs().to_f64();
                        assert!(
                            off < 1e-14 * size + 2e-15 * long * size,
                            "{r} {slope} {event:?} {exact:?}"
                        );
                        // Upsilon of the located point, by the other way.
                        let at = fine.at(exact.x);
                        let off = DoubleDouble::from(slope) * at.value + exact.mu - exact.x;
                        assert!(off.abs().to_f64() < 1e-10 * size, "{r} {slope} {exact:?}");
                        // Next to the graze, x itself cannot be told from it.
                        let apart = (window.grazing.x - event.x) / event.x;
                        if k != GRAZING && apart > 1e-8 {
                            let here = slope * at.derivative.to_f64();
                            assert!((here - multiplier).abs() < 1e-12, "{r} {slope} {here}");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn a_slope_of_zero_is_refused() {
        let universal = Universal::new(0.8).unwrap();
        for value in [0.0, f64::NEG_INFINITY] {
            assert_eq!(
                universal.windows(value, 0..=1).err(),
                Some(UniversalError::Slope { value })
            );
        }
    }

    /// Folds stop where the greatest slope falls below 1 / K; for K > 0 what begins a window is then the kink.
    #[test]
    fn events_are_in_their_order() {
        let universal = Universal::new(0.8).unwrap();
        for slope in [1.0, 3.0, -1.0, -3.0] {
            let windows = universal.windows(slope, 0..=80).unwrap();
            for pair in windows.windows(2) {
                let (later, window) = (&pair[1], &pair[0]);
                let first = if slope > 0.0 {
                    window.fold
                } else {
                    window.period_doubling
                };
                let last = if slope > 0.0 {
                    window.period_doubling
                } else {
                    window.fold
                }
                .unwrap();
                let greatest = slope.abs()
                    * universal.greatest_slope()
                    * libm::pow(
                        universal.constants().lambda.powi(2) / universal.constants().eta,
                        window.lap as f64,
                    );
                assert_eq!(first.is_some(), greatest > 1.0);
                let begin = first.map_or(later.grazing, |first| first);
                assert!(begin.x < window.superstable.x);
                assert!(window.superstable.x < last.x && last.x < window.grazing.x);
                assert!(begin.mu < window.superstable.mu && window.superstable.mu < last.mu);
                assert_eq!(window.grazing.mu > last.mu, slope > 0.0);
            }
            assert!(windows.iter().any(|w| w.fold.is_some()));
        }
    }
}
