//! Where a function of the stations vanishes between two of them.

use super::curve::Station;
use super::problem::Problem;
use crate::numerics::Bracket;

/// More are never needed.
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
    if ends.0 == 0.0 {
        return Some((from.clone(), 0.0));
    }
    // Zero at the far end is negative: as the near end of the next step it is found again.
    let far = if ends.1 == 0.0 {
        -f64::MIN_POSITIVE
    } else {
        ends.1
    };
    let mut bracket = Bracket::new((0.0, ends.0), (step, far))?;
    let mut best: Option<(Station, f64, f64)> = None;
    for _ in 0..MOST_STEPS {
        let Some(at) = bracket.place().filter(|_| bracket.width() > DONE * step) else {
            break;
        };
        let found = from.ahead(problem, at).ok().and_then(|(station, _)| {
            let value = value(problem, &station)?;
            Some((station, value))
        });
        let here = found.as_ref().map_or(far, |(_, value)| *value);
        if let Some((station, value)) = found
            && (best.as_ref()).is_none_or(|(.., known)| value.abs() < known.abs())
        {
            best = Some((station, at, value));
        }
        if here == 0.0 {
            break;
        }
        bracket.narrow(at, here);
    }
    best.map(|(station, at, _)| (station, at))
}
