//! Straight lines through samples.

/// A line through points by least squares.
#[derive(Clone, Copy, Debug, Default)]
pub struct LineFit {
    count: f64,
    mean_x: f64,
    mean_y: f64,
    xx: f64,
    xy: f64,
    yy: f64,
}

impl LineFit {
    /// Welford's updating formulas: no digits are lost where the points are far from zero.
    pub fn add(&mut self, x: f64, y: f64) {
        if !y.is_finite() {
            return;
        }
        self.count += 1.0;
        let before = (x - self.mean_x, y - self.mean_y);
        self.mean_x += before.0 / self.count;
        self.mean_y += before.1 / self.count;
        self.xx += before.0 * (x - self.mean_x);
        self.xy += before.0 * (y - self.mean_y);
        self.yy += before.1 * (y - self.mean_y);
    }

    /// Squared correlation: one for points on a line.
    pub fn quality(&self) -> f64 {
        self.xy * self.xy / (self.xx * self.yy)
    }

    /// To four digits, which is what the axis says.
    pub fn slope(&self) -> f64 {
        let slope = self.xy / self.xx;
        if slope.is_finite() {
            format!("{slope:.3e}").parse().unwrap_or(slope)
        } else {
            0.0
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_fitted_to_its_slope() {
        let mut fit = LineFit::default();
        for k in 0..100 {
            let x = f64::from(k) * 1e-5;
            let noise = if k % 2 == 0 { 1e-9 } else { -1e-9 };
            fit.add(x, 5.0 - 3.25 * x + noise);
        }
        assert_eq!(fit.slope(), -3.25);
        assert!(fit.quality() > 0.999 && fit.quality() <= 1.0 + 1e-12);
        assert_eq!(LineFit::default().slope(), 0.0);
    }
}
