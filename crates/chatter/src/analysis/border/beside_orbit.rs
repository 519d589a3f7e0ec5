//! How far the chatter of an orbit is from a border: X along the orbit's own impacts.

use super::coordinate::sequence::{Until, Verdict};
use super::problem::Problem;
use super::spec::BorderSpec;
use crate::analysis::universal::{ChatterMap, Constants};
use crate::model::Model;

/// X of (M4), negative where chatter is complete.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Distance {
    pub x: f64,
    /// The time of the impact that it is read from.
    pub time: f64,
}

/// Steps back along the chatter sequence reach u* to about this part: then the next term of the linearising function is as small.
const NEAR: f64 = 1e-7;
/// From a third on no impact, or none nearby, follows.
const LARGEST: f64 = 0.33;
/// So many are never needed.
const MOST_STEPS: usize = 200;

/// X of u with nu = 0, in units of u: lim eta^-m (g^-m(u) - u*).
fn linearised(constants: &Constants<f64>, u: f64) -> f64 {
    let map = ChatterMap::new(constants);
    let fixed = constants.chatter_fixed_point;
    let (mut u, mut growth) = (u, 1.0);
    for _ in 0..MOST_STEPS {
        if (u - fixed).abs() <= NEAR * fixed {
            break;
        }
        u = map.inverse(u);
        growth /= constants.eta;
    }
    (u - fixed) * growth
}

/// The distance from the nearest border in the coordinate X of the chatter that follows a state of an orbit. None where borders are
/// not defined, or no chatter follows.
pub(crate) fn distance(model: &Model, parameters: &[f64], start: &[f64]) -> Option<Distance> {
    let spec = BorderSpec::new(&model.parameters.first()?.name);
    let problem = Problem::new(model, &spec).ok()?;
    let value = parameters[problem.parameter];
    problem.release.check_forcing(parameters, value).ok()?;
    let until = Until::Verdict {
        excursions: problem.excursions,
        after: 0,
    };
    let sequence = problem.plain.follow(parameters, start, until).ok()?;
    if !matches!(sequence.verdict, Verdict::Complete | Verdict::Incomplete) {
        return None;
    }
    let releases = problem
        .release
        .all(&problem.model, &problem.plain.system, parameters);
    let begin = problem.model.time.map_or(0.0, |index| start[index]);
    let of = |release| {
        let constants = Problem::constants(value, release).ok()?;
        let local = (sequence.impacts.iter().enumerate()).skip(sequence.begins);
        // The later, the less is left of nu, which the linearising function takes for nothing.
        let (place, impact) = local
            .take_while(|(_, impact)| impact.local.acceleration < 0.0)
            .filter(|(_, impact)| 0.0 < impact.local.u() && impact.local.u() < LARGEST)
            .last()?;
        let u = impact.local.u();
        let shrunk = libm::exp(constants.ln_eta * place as f64);
        let x = linearised(&constants, u) * shrunk;
        x.is_finite().then_some(Distance {
            x,
            time: impact.time - begin,
        })
    };
    releases
        .iter()
        .filter_map(of)
        .min_by(|a, b| a.x.abs().total_cmp(&b.x.abs()))
}
