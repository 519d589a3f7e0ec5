//! Where a function of the stations vanishes between two of them.

use super::curve::Station;
use super::problem::Problem;

/// A bracket is halved at the latest after two steps of the secant, so that no function takes more.
const MOST_STEPS: usize = 120;
/// A bracket this short, against the step that it began with, is a point.
const DONE: f64 = 1e-15;

/// The station between `from` and the one `step` ahead of it where `value` vanishes; `ends` are its values at both. Stations
/// that cannot be corrected, or have no value, count as the far end.
///
/// None if the ends have the same sign.
pub fn locate(
    problem: &mut dyn Problem<f64>,
    from: &Station,
    step: f64,
    ends: (f64, f64),
    value: &mut dyn FnMut(&mut dyn Problem<f64>, &Station) -> Option<f64>,
) -> Option<(Station, f64)> {
    let sign = |x: f64| if x > 0.0 { 1.0 } else { -1.0 };
    let (mut low, mut high) = ((0.0, ends.0), (step, ends.1));
    if ends.0 == 0.0 {
        return Some((from.clone(), 0.0));
    }
    if sign(ends.0) == sign(ends.1) {
        return None;
    }
    let mut best: Option<(Station, f64, f64)> = None;
    // The secant's values: that of an end which has not moved twice is halved (Illinois).
    let mut weights = (low.1, high.1);
    let mut latest = 0.0;
    let mut width_before = step;
    for index in 0..MOST_STEPS {
        let width = high.0 - low.0;
        if width <= DONE * step {
            break;
        }
        let secant = low.0 - weights.0 * width / (weights.1 - weights.0);
        let inside = secant > low.0 && secant < high.0;
        let slow = index % 3 == 2 && width > 0.5 * width_before;
        if index % 3 == 2 {
            width_before = width;
        }
        let at = if inside && !slow {
            secant
        } else {
            0.5 * (low.0 + high.0)
        };
        let found = from.ahead(problem, at).ok().and_then(|(station, _)| {
            let value = value(problem, &station)?;
            Some((station, value))
        });
        let here = found.as_ref().map_or(ends.1, |(_, value)| *value);
        if let Some((station, value)) = found
            && (best.as_ref()).is_none_or(|(.., known)| value.abs() < known.abs())
        {
            best = Some((station, at, value));
        }
        if here == 0.0 {
            break;
        }
        if sign(here) == sign(low.1) {
            low = (at, here);
            weights = (
                here,
                if latest < 0.0 {
                    0.5 * weights.1
                } else {
                    weights.1
                },
            );
            latest = -1.0;
        } else {
            high = (at, here);
            weights = (
                if latest > 0.0 {
                    0.5 * weights.0
                } else {
                    weights.0
                },
                here,
            );
            latest = 1.0;
        }
    }
    best.map(|(station, at, _)| (station, at))
}
