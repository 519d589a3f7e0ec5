//! Where the n-impact orbit is predicted to be born, to double its period and to graze.

use super::prediction::Prediction;

/// A fixed point of the predicted map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PredictedPoint {
    /// Parameter value, p* + mu / M.
    pub parameter: f64,
    /// mu.
    pub mu: f64,
    /// X of the first impact.
    pub x: f64,
    /// z = Upsilon(x).
    pub z: f64,
}

/// What is predicted for the orbit with one number of impacts. On it mu(x) = x - K Upsilon(x), and the multiplier is
/// K Upsilon'(x) (MATH.md 7).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PredictedWindow {
    /// n: impacts after the first one, in each passage.
    pub lap: u32,
    /// Multiplier 1; none beyond some n, where orbits are born at the graze of others.
    pub fold: Option<PredictedPoint>,
    /// Multiplier 0.
    pub superstable: Option<PredictedPoint>,
    /// Multiplier -1.
    pub period_doubling: Option<PredictedPoint>,
    /// Where the last impact grazes.
    pub grazing: PredictedPoint,
}

/// A lap begins behind its left end, which belongs to the next: so near to it, in the root of the distance.
const BEGINNING: f64 = 1.0 - 1e-12;

/// Halvings that exhaust the digits of a double.
const HALVINGS: usize = 120;

impl Prediction {
    /// The window of the orbit with n + 1 impacts, n the lap.
    pub fn window(&self, lap: u32) -> PredictedWindow {
        let constants = self.universal().constants();
        let end = self.universal().lap_end() * libm::exp(constants.ln_eta * f64::from(lap));
        let width = end * constants.one_minus_eta;
        // The slope of Upsilon falls from the lap's beginning to minus infinity at its end, like the root of the distance.
        let place = |y: f64| end - width * y * y;
        let with_multiplier = |multiplier: f64| {
            let wanted = multiplier / self.slope;
            let beyond = |y: f64| self.universal().at(place(y)).derivative - wanted;
            let (mut low, mut high) = (0.0_f64, BEGINNING);
            if beyond(high) < 0.0 {
                return None;
            }
            for _ in 0..HALVINGS {
                let middle = 0.5 * (low + high);
                if middle <= low || middle >= high {
                    break;
                }
                if beyond(middle) < 0.0 {
                    low = middle;
                } else {
                    high = middle;
                }
            }
            Some(self.fixed_point(place(high)))
        };
        PredictedWindow {
            lap,
            fold: with_multiplier(1.0),
            superstable: with_multiplier(0.0),
            period_doubling: with_multiplier(-1.0),
            grazing: self.fixed_point(end),
        }
    }

    fn fixed_point(&self, x: f64) -> PredictedPoint {
        let z = self.universal().value(x);
        let mu = (-self.slope).mul_add(z, x);
        PredictedPoint {
            parameter: self.parameter(mu),
            mu,
            x,
            z,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::orbit::{BorderSpec, border_near};
    use super::*;
    use crate::model::Model;

    const VALVE: &str = include_str!("../../../../../models/pressure_relief_valve.toml");

    #[test]
    fn predicted_points_are_fixed_points_with_their_multipliers() {
        let model = Model::from_toml(VALVE, "valve").unwrap();
        let border = border_near::<f64>(&model, &BorderSpec::new("q"), 0.02).unwrap();
        let prediction = Prediction::exact(&border).unwrap();
        for lap in 5..60 {
            let window = prediction.window(lap);
            let points = [
                (window.fold.unwrap(), 1.0),
                (window.superstable.unwrap(), 0.0),
                (window.period_doubling.unwrap(), -1.0),
            ];
            for (point, multiplier) in points {
                let z = prediction.next(point.mu, point.z);
                assert!((z - point.z).abs() <= 1e-12 * point.x, "{lap}");
                let slope = prediction.slope * prediction.universal().at(point.x).derivative;
                assert!((slope - multiplier).abs() < 1e-6, "{lap}: {slope}");
                let passage = prediction.passage(point.mu, point.z);
                assert_eq!(passage.impacts, Some(u64::from(lap) + 1));
            }
            assert!(window.fold.unwrap().mu < window.period_doubling.unwrap().mu);
            assert!(window.period_doubling.unwrap().mu < window.grazing.mu);
        }
    }
}
