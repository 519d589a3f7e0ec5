//! Where the n-impact orbit is predicted to be born, to double its period and to graze.

use super::map::Prediction;
use crate::analysis::universal::{Located, Window};
use serde::{Deserialize, Serialize};

/// A fixed point of the predicted map.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
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

/// What is predicted for the orbit with one number of impacts, `lap` of them after the first one in each passage. On it
/// mu(x) = x - K Upsilon(x), and the multiplier is K Upsilon'(x) (MATH.md 7). There is no fold beyond some n, where orbits are born
/// at the graze of others.
pub type PredictedWindow = Window<PredictedPoint>;

impl Prediction {
    /// The window of the orbit with n + 1 impacts, n the lap: that of the universal map's atlas, in the parameter.
    pub fn window(&self, lap: i64) -> PredictedWindow {
        // What is remembered does not move orbits that repeat, but their doubling.
        let doubling = self.memory.as_ref().map(|memory| memory.doubling_slope);
        let window = (self.universal()).window_remembered(self.slope, doubling, lap);
        window.map(|Located { mu, x, z, .. }| PredictedPoint {
            parameter: self.parameter(mu),
            mu,
            x,
            z,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::spec::BorderSpec;
    use super::*;
    use crate::analysis::border_search::border_near;
    use crate::model::Model;

    const VALVE: &str = include_str!("../../../../../../models/pressure_relief_valve.toml");

    #[test]
    fn predicted_points_are_fixed_points_with_their_multipliers() {
        let model = Model::from_toml(VALVE, "valve").unwrap();
        let border = border_near::<f64>(&model, &BorderSpec::new("q"), 0.02).unwrap();
        let prediction = Prediction::exact(&border).unwrap();
        for lap in 5..60 {
            let window = prediction.window(lap);
            let points = [
                (window.fold.unwrap(), 1.0),
                (window.superstable, 0.0),
                (window.period_doubling.unwrap(), -1.0),
            ];
            for (point, multiplier) in points {
                let x = prediction.slope.mul_add(point.z, point.mu);
                let (passage, z) = prediction.passage(x, point.z, Vec::new());
                assert!((z - point.z).abs() <= 1e-12 * point.x, "{lap}");
                let slope = prediction.slope * prediction.universal().at(point.x).derivative;
                assert!((slope - multiplier).abs() < 1e-6, "{lap}: {slope}");
                assert_eq!(passage.impacts, Some(lap as u64 + 1));
            }
            assert!(window.fold.unwrap().mu < window.period_doubling.unwrap().mu);
            assert!(window.period_doubling.unwrap().mu < window.grazing.mu);
        }
    }
}
