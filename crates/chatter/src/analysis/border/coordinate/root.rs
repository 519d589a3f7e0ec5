//! The border as the smooth root X(p) = 0.

use super::super::error::BorderError;
use super::super::problem::{PARAMETER_COLUMN, Problem, STATES, exactly};
use super::super::release::equations::ReleasePoint;
use super::super::release::forcing::Turn;
use super::limits::{Extrapolation, Limits};
use super::sequence::Sequence;
use crate::numerics::Estimate;
use crate::numerics::{DoubleDouble, Real};

/// Newton's method gives up after so many steps: from where it starts each gains two digits at first.
const NEWTON_STEPS: usize = 30;

/// So often a correction may not be the smallest so far: away from the root each sequence shows only so much of its X.
const PATIENCE: usize = 2;

/// A correction of so many roundoffs of the parameter is no correction.
const NEWTON_DONE: f64 = 2.0;

/// Where corrections stop shrinking the error of X must be as small as the roundoff to this power, 4e-7 for doubles, else
/// there is no root, or not enough of the sequence is near it to tell.
const SETTLED_POWER: f64 = 0.4;

/// At a root dX/dp is known at least to this part of itself, and the sequence comes at least this near to u*, relative
/// to u*.
const VAGUE: f64 = 0.1;
const APART: f64 = 0.05;

/// Roots this near to each other, relative to the parameter, are one found twice.
const SAME_ROOT: f64 = 8.0 * f64::EPSILON;

/// Chatter ends at the release point where the orbit began if the distance is this small against the way there. Release
/// points lie apart: there is nothing in between.
const CLOSED: f64 = 1e-7;

/// X and its derivative at a parameter value, with the sequence that they were taken from.
#[derive(Clone, Debug)]
pub(crate) struct Point<R> {
    pub value: R,
    pub release: ReleasePoint<R>,
    pub limits: Limits<R>,
    pub sequence: Sequence<R>,
    /// The impact from which on so many are followed as limits need.
    pub settles: usize,
    /// The last impact that still approaches the border.
    pub end: usize,
    pub x: Estimate<R>,
    /// dX/dp, release point included.
    pub slope: Estimate<R>,
}

impl<R: Real> Point<R> {
    /// The size of the parameter, or what of it changes X by one.
    pub(crate) fn parameter_scale(&self) -> f64 {
        let unit = 1.0 / self.slope.value.abs().to_f64();
        self.value.abs().to_f64().max(unit)
    }

    /// The phases with the periods by which the orbit advances from release to the accumulation of its impacts; `None`
    /// if they do not accumulate at the release point.
    pub(crate) fn turns(&self, problem: &Problem) -> Option<Vec<Turn<R>>> {
        let mut turns = problem.release.turns(&problem.parameters(self.value));
        let (mut missed, mut way) = (0.0, 0.0);
        for i in 0..STATES {
            let end = self
                .limits
                .accumulation_state(&self.sequence, self.end, i)
                .value;
            let begin = self.release.state[i];
            let impacts = self.sequence.impacts.iter();
            way += impacts.fold(0.0_f64, |most, impact| {
                most.max((impact.state[i] - end).abs().to_f64())
            });
            let mut distance = end - begin;
            if let Some(turn) = turns.iter_mut().find(|turn| turn.state == i) {
                let count = libm::round((distance / turn.period).to_f64());
                turn.count = count as i64;
                distance -= turn.period * R::splat(count);
            }
            missed += distance.abs().to_f64();
        }
        (missed <= CLOSED * way).then_some(turns)
    }
}

/// A parameter value where X vanishes.
#[derive(Clone, Debug)]
pub(crate) struct Root<R> {
    pub point: Point<R>,
    /// Estimated error of the parameter value.
    pub error: f64,
}

impl Root<f64> {
    /// Whether two searches came to the same root.
    pub(crate) fn is_same(&self, other: &Self) -> bool {
        let off = (self.point.value - other.point.value).abs();
        off <= SAME_ROOT * self.point.value.abs() + self.error + other.error
    }
}

impl Problem {
    /// X and dX/dp at a parameter value near a border.
    pub(crate) fn point<R: Real>(
        &self,
        value: R,
        near: &[DoubleDouble],
        settles: usize,
        extrapolation: Extrapolation,
    ) -> Result<Point<R>, BorderError> {
        let release = self.release_point(value, near)?;
        let mut limits = Limits::new(Self::constants(value, &release)?, &release, extrapolation);
        let parameters = self.parameters(value);
        let most = settles + limits.impacts();
        let sequence = self.variation(&parameters, &release.state, settles, most)?;
        if sequence.impacts.len() <= sequence.begins {
            return Err(BorderError::NotConverged {
                value: value.to_f64(),
                residual: f64::NAN,
            });
        }
        let end = limits.nearest(&sequence);
        limits.set_noise(&sequence, end);
        let x = limits.x(&sequence, end);
        let mut weights = release.slope.clone();
        weights.push(R::ONE);
        debug_assert_eq!(weights.len(), PARAMETER_COLUMN + 1);
        let slope = limits.x_slope(&sequence, end, &weights, true);
        Ok(Point {
            value,
            release,
            limits,
            sequence,
            settles,
            end,
            x,
            slope,
        })
    }

    /// Newton's method on X(p) = 0 from a value close enough for the sequence to come near u*.
    pub(crate) fn root<R: Real>(
        &self,
        guess: R,
        near: &[DoubleDouble],
        settles: usize,
        extrapolation: Extrapolation,
        within: (f64, f64),
    ) -> Result<Root<R>, BorderError> {
        let mut value = guess;
        let mut near = near.to_vec();
        let mut before = f64::INFINITY;
        let mut residual = f64::NAN;
        let mut stalls = 0;
        let settled = libm::pow(R::ROUNDOFF, SETTLED_POWER);
        for _ in 0..NEWTON_STEPS {
            let point = self.point(value, &near, settles, extrapolation)?;
            near = exactly(&point.release.state);
            let correction = point.x.value / point.slope.value;
            residual = point.x.value.to_f64();
            let size = correction.abs().to_f64();
            let next = value - correction;
            if !(next.to_f64() >= within.0 && next.to_f64() <= within.1) {
                break;
            }
            let floor = NEWTON_DONE * R::ROUNDOFF * value.abs().to_f64();
            stalls += usize::from(size >= before);
            if size <= floor || stalls > PATIENCE {
                let rate = point.slope.value.abs().to_f64();
                let error = (point.x.error / rate).max(size).max(floor);
                let last = &point.sequence.impacts[point.end].local;
                let vague = point.slope.error > VAGUE * point.slope.value.abs().to_f64();
                let apart = point.limits.distance(last.u()) > APART;
                if error.is_nan() || error * rate > settled || vague || apart {
                    break;
                }
                return Ok(Root { point, error });
            }
            before = before.min(size);
            value = next;
        }
        Err(BorderError::NotConverged {
            value: value.to_f64(),
            residual,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::spec::BorderSpec;
    use super::*;
    use crate::model::Model;
    use crate::numerics::Scalar;

    const VALVE: &str = include_str!("../../../../../../models/pressure_relief_valve.toml");

    /// X(p) and X(x) by differences, against the columns.
    #[test]
    fn slopes_of_x_are_its_differences() {
        const STEP: f64 = 1e-20;
        const LAST: usize = 60;
        let mut model = Model::from_toml(VALVE, "valve").unwrap();
        for (parameter, value) in [
            ("q", "0.02005600568931228428251703106969"),
            ("kappa", "1.25"),
            ("r", "0.8"),
        ] {
            model
                .set_parameter("q", "0.02005600568931228428251703106969")
                .unwrap();
            let problem = Problem::new(&model, &BorderSpec::new(parameter)).unwrap();
            let value: DoubleDouble = value.parse().unwrap();
            let near = exactly(&[0.0, 0.0, 10.0]);
            let settings = Extrapolation::default();
            let at = |shift: f64| {
                let value = value + DoubleDouble::from(shift);
                problem.point(value, &near, 0, settings).unwrap()
            };
            let (low, middle, high) = (at(-STEP), at(0.0), at(STEP));
            // The same impacts for all: where the sequence departs, X is no longer what it was.
            let x = |point: &Point<DoubleDouble>| {
                point.limits.x_off_border(&point.sequence, LAST).value
            };
            let difference = (x(&high) - x(&low)) / DoubleDouble::from(2.0 * STEP);
            let off = ((difference - middle.slope.value) / difference)
                .abs()
                .to_f64();
            assert!(
                off < 1e-7,
                "{parameter}: {difference} {}",
                middle.slope.value
            );
        }
        let problem = Problem::new(&model, &BorderSpec::new("q")).unwrap();
        let value: DoubleDouble = "0.02005600568931228428251703106969".parse().unwrap();
        let near = exactly(&[0.0, 0.0, 10.0]);
        let point = problem
            .point(value, &near, 0, Extrapolation::default())
            .unwrap();
        let parameters = problem.parameters(value);
        for i in 1..STATES {
            let shifted = |shift: f64| {
                let mut state = point.sequence.impacts[0].state[..STATES].to_vec();
                state[i] += DoubleDouble::from(shift);
                let sequence = problem.variation(&parameters, &state, 0, 70).unwrap();
                point.limits.x_off_border(&sequence, LAST).value
            };
            let difference = (shifted(STEP) - shifted(-STEP)) / DoubleDouble::from(2.0 * STEP);
            let state = &point.sequence.impacts[0].state[..STATES];
            let sequence = problem.variation(&parameters, state, 0, 70).unwrap();
            let mut weights = vec![DoubleDouble::ZERO; STATES + 1];
            weights[i] = DoubleDouble::ONE;
            let slope = point.limits.x_slope(&sequence, LAST, &weights, false);
            let off = ((difference - slope.value) / difference).abs().to_f64();
            assert!(off < 1e-7, "{i}: {difference} {}", slope.value);
        }
    }
}
