//! How the cascade scales from lap n to n + 1, and its limits (MATH.md 7).

use super::argument::Argument;
use super::error::UniversalError;
use super::evaluate::Universal;
use crate::numerics::Real;

/// Scaling laws of the windows of z -> Upsilon(K z + mu) for large n.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scaling<R> {
    /// eta: ratio of positions mu and x from n to n + 1, and of the widths of windows.
    pub position_ratio: R,
    /// lambda^2 / eta: ratio of slopes.
    pub slope_ratio: R,
    /// c in Upsilon(x) = Upsilon(x_e) + c sqrt(x_e - x) + … at the end of lap 0.
    pub graze_coefficient: R,
    /// lambda^4 / eta: ratio of the distances from the event next to the graze (period doubling for K > 0, fold for
    /// K < 0) to the graze.
    pub graze_ratio: R,
    /// That distance in mu is this times `graze_ratio`^n to leading order: 3 (K c / 2)^2 for K > 0, and for K < 0, where
    /// the fold turns back, -(K c / 2)^2.
    pub graze_distance: R,
    /// K Upsilon' to the right of the graze of lap n + 1 is this times `slope_ratio`^n.
    pub kink_slope: R,
    /// The last n with a fold for K > 0, or with a period doubling for K < 0, before which |K Upsilon'| exceeds one at
    /// the beginning of the lap: n_c, not rounded.
    pub last_smooth_birth: R,
}

impl<R: Real + Argument<Real = R>> Universal<R> {
    /// The scaling laws for slope K.
    ///
    /// # Errors
    /// [`UniversalError::Slope`] where K is zero or not finite.
    pub fn scaling(&self, slope: R) -> Result<Scaling<R>, UniversalError> {
        UniversalError::check_slope(slope)?;
        let c = self.constants();
        let lambda_squared = c.lambda * c.lambda;
        let (_, by_root_of_phase) = self.lap.at_graze();
        // phase = (x_e - x) / ((1 - eta) x_e).
        let graze_coefficient = by_root_of_phase / (c.one_minus_eta * self.lap_end()).sqrt();
        let half = slope * graze_coefficient * R::splat(0.5);
        let kink_slope = slope * self.greatest_slope();
        Ok(Scaling {
            position_ratio: c.eta,
            slope_ratio: lambda_squared / c.eta,
            graze_coefficient,
            graze_ratio: lambda_squared * lambda_squared / c.eta,
            graze_distance: half * half * R::splat(if slope > R::ZERO { 3.0 } else { -1.0 }),
            kink_slope,
            last_smooth_birth: kink_slope.abs().ln() / (c.ln_eta - c.ln_lambda - c.ln_lambda),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::{DoubleDouble, Scalar};

    #[test]
    fn windows_approach_their_scaling() {
        for (r, n) in [(0.3, 60), (0.8, 300)] {
            let universal = Universal::new(DoubleDouble::from(r)).unwrap();
            for slope in [1.0, -1.0] {
                let scaling = universal.scaling(DoubleDouble::from(slope)).unwrap();
                let windows = universal
                    .windows(DoubleDouble::from(slope), n..=n + 1)
                    .unwrap();
                let next_to_graze = |k: usize| {
                    let w = &windows[k];
                    let event = if slope > 0.0 {
                        w.period_doubling
                    } else {
                        w.fold
                    };
                    w.grazing.mu - event.unwrap().mu
                };
                let close = |a: DoubleDouble, b: DoubleDouble, tolerance: f64| {
                    assert!(
                        (a / b - DoubleDouble::ONE).abs().to_f64() < tolerance,
                        "{r} {slope} {a} {b}"
                    );
                };
                // Corrections are of the order of (lambda^2 / eta)^n, relative.
                let small = libm::exp(libm::log(scaling.slope_ratio.to_f64()) * n as f64);
                let expected = scaling.graze_distance * scaling.graze_ratio.powi(n as i32);
                close(next_to_graze(0), expected, 100.0 * small);
                close(
                    next_to_graze(1) / next_to_graze(0),
                    scaling.graze_ratio,
                    100.0 * small,
                );
                close(
                    windows[1].superstable.mu / windows[0].superstable.mu,
                    scaling.position_ratio,
                    100.0 * small,
                );
            }
        }
    }

    #[test]
    fn smooth_births_end_where_said() {
        for r in [0.1, 0.5, 0.8, 0.95] {
            let universal = Universal::new(r).unwrap();
            for slope in [0.5, 1.0, 4.6, -2.0] {
                let last = universal.scaling(slope).unwrap().last_smooth_birth;
                for window in universal.windows(slope, -5..=200).unwrap() {
                    let birth = if slope > 0.0 {
                        window.fold
                    } else {
                        window.period_doubling
                    };
                    assert_eq!(
                        birth.is_some(),
                        window.lap as f64 <= last,
                        "{r} {slope} {last}"
                    );
                }
            }
        }
    }
}
