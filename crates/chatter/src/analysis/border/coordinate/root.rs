//! The border as the smooth root X(p) = 0.

use super::super::error::{BorderError, Lack};
use super::super::problem::Problem;
use super::super::release::equations::{Place, ReleasePoint};
use super::super::release::forcing::Turn;
use super::limits::{Extrapolation, Limits};
use super::sequence::{Impact, Sequence};
use crate::numerics::{Estimate, Matrix, Real, dot};

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

/// Where a direct loop through the surface of release points has a multiplier nearer to 1 than this, border orbits are not alone:
/// something is conserved.
const ALONE: f64 = 1e-6;

/// X and its derivative at a parameter value, with the sequence that they were taken from: up to the last impact that still
/// approaches the border.
#[derive(Clone, Debug)]
pub(crate) struct Point<R> {
    pub value: R,
    /// Its slope is that of orbits that return to it.
    pub release: ReleasePoint<R>,
    pub limits: Limits<R>,
    pub sequence: Sequence<R>,
    /// The impact from which on so many are followed as limits need.
    pub settles: usize,
    /// How many impacts were followed.
    pub followed: usize,
    pub x: Estimate<R>,
    /// dX/dp, release point included.
    pub slope: Estimate<R>,
    /// How the release point moves with the parameter, its coordinates fixed.
    pub held_slope: Vec<R>,
    pub held_restitution: R,
    /// How orbits remember where they were released.
    pub memory: Memory<R>,
    /// The place on the surface of release points where the impacts accumulate.
    place: Vec<R>,
    /// The phases with the periods by which the orbit advances until then.
    pub turns: Vec<Turn<R>>,
    /// What leads to the release point to which orbits from it return.
    pub shift: Vec<R>,
    /// What that changes X by.
    pub x_shift: R,
}

/// One loop through the surface of release points, to first order in its coordinates.
#[derive(Clone, Debug)]
pub(crate) struct Memory<R> {
    /// How coordinates return: a row for each, a column for each that they begin with.
    pub returns: Matrix<R>,
    /// What the parameter adds.
    pub by_parameter: Vec<R>,
    /// What the rate at release adds.
    pub by_rate: Vec<R>,
    /// How well that is known.
    pub by_rate_error: Vec<R>,
    /// dX by the coordinates.
    pub covector: Vec<R>,
}

impl<R: Real> Memory<R> {
    /// Of so many coordinates, without rows yet.
    fn nothing(dimensions: usize) -> Self {
        Self {
            returns: Matrix::zeros(0, dimensions),
            by_parameter: Vec::new(),
            by_rate: Vec::new(),
            by_rate_error: Vec::new(),
            covector: Vec::new(),
        }
    }

    /// What coordinates come to where each loop adds this: (I - sign returns)^-1 of it; `None` where that has no answer.
    pub(crate) fn settled(&self, added: &[R], sign: f64) -> Option<Vec<R>> {
        let size = added.len();
        let mut rows = Matrix::identity(size);
        for i in 0..size {
            for (entry, &back) in rows.row_mut(i).iter_mut().zip(self.returns.row(i)) {
                *entry -= R::splat(sign) * back;
            }
        }
        if size == 0 {
            return Some(Vec::new());
        }
        let factors = rows.factored()?;
        let small = |column: Vec<R>| column.iter().all(|x| x.abs().to_f64() * ALONE <= 1.0);
        (factors.inverse().all(small)).then(|| factors.solve(added))
    }
}

impl<R: Real> Point<R> {
    /// The size of the parameter, or what of it changes X by one.
    pub(crate) fn parameter_scale(&self) -> f64 {
        let unit = 1.0 / self.slope.value.abs().to_f64();
        self.value.abs().to_f64().max(unit)
    }

    /// Whether the impacts accumulate at the release point.
    pub(crate) fn closes(&self) -> bool {
        let (mut missed, mut way) = (0.0, 0.0);
        for (i, &end) in self.place.iter().enumerate() {
            let impacts = self.sequence.impacts.iter();
            way += impacts.fold(0.0_f64, |most, impact| {
                most.max((impact.state[i] - end).abs().to_f64())
            });
            let [turned, _] = Turn::of(&self.turns, i);
            missed += (end - self.release.state[i] - turned).abs().to_f64();
        }
        missed <= CLOSED * way
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
        near: &Place,
        settles: usize,
        extrapolation: Extrapolation,
    ) -> Result<Point<R>, BorderError> {
        let mut release = self.release_point(value, near)?;
        let mut limits = Limits::new(Self::constants(value, &release)?, &release, extrapolation);
        let parameters = self.parameters(value);
        let most = settles + limits.impacts;
        let start = (release.contact, &*release.state);
        let mut sequence = self.variation(&parameters, start, settles, most)?;
        if sequence.impacts.len() <= sequence.begins {
            return Err(Lack::Chatter.at(value));
        }
        let followed = sequence.impacts.len();
        sequence.impacts.truncate(limits.nearest(&sequence) + 1);
        limits.set_noise(&sequence);
        let x = limits.x(&sequence);
        let (held_slope, held_restitution) = (release.slope.clone(), release.restitution_slope);
        let mut turns = self.releases[release.contact].turns(&parameters);
        let place: Vec<R> = (0..self.states())
            .map(|i| limits.place(&sequence, i))
            .collect();
        for turn in &mut turns {
            let way = place[turn.state] - release.state[turn.state];
            turn.count = libm::round((way / turn.period).to_f64()) as i64;
        }
        let (mut missed, mut memory) = (Vec::new(), Memory::nothing(release.free.len()));
        for &i in &release.free {
            let [turned, turned_slope] = Turn::of(&turns, i);
            let by = |weights: &Vec<R>| limits.place_slope(&sequence, i, weights);
            missed.push(place[i] - release.state[i] - turned);
            let returns: Vec<R> = release.directions.iter().map(|d| by(d).value).collect();
            memory.returns.push(&returns);
            (memory.by_parameter).push(by(&release.slope).value - turned_slope);
            let by_rate = by(&release.jump);
            memory.by_rate.push(by_rate.value);
            memory.by_rate_error.push(R::splat(by_rate.error));
        }
        let back = |j: usize| (0..release.free.len()).map(move |i| (i, j));
        for (j, weights) in release.directions.iter().enumerate() {
            let back: Vec<R> = back(j).map(|place| memory.returns[place]).collect();
            let restitution = dot(&release.restitution_by, &back);
            let slope = limits.x_slope(&sequence, weights, restitution);
            memory.covector.push(slope.value);
        }
        let settled =
            |added: &[R]| (memory.settled(added, 1.0)).ok_or_else(|| Lack::Alone.at(value));
        let shift = settled(&missed)?;
        let moved = settled(&memory.by_parameter)?;
        release.follow_orbit(&moved);
        let slope = limits.x_slope(&sequence, &release.slope, release.restitution_slope);
        Ok(Point {
            value,
            limits,
            sequence,
            settles,
            followed,
            x,
            slope,
            held_slope,
            held_restitution,
            x_shift: dot(&memory.covector, &shift),
            shift: release.along(&shift),
            memory,
            place,
            turns,
            release,
        })
    }

    /// Newton's method on X(p) = 0 from a value close enough for the sequence to come near u*.
    pub(crate) fn root<R: Real>(
        &self,
        guess: R,
        near: &Place,
        settles: usize,
        extrapolation: Extrapolation,
        within: (f64, f64),
    ) -> Option<Root<R>> {
        let mut value = guess;
        let mut near = near.clone();
        let mut before = f64::INFINITY;
        let mut stalls = 0;
        let settled = libm::pow(R::ROUNDOFF, SETTLED_POWER);
        for _ in 0..NEWTON_STEPS {
            let point = self.point(value, &near, settles, extrapolation).ok()?;
            let correction = (point.x.value + point.x_shift) / point.slope.value;
            let moved: Vec<R> = (point.release.slope.iter().zip(&point.shift))
                .map(|(&slope, &shift)| shift - slope * correction)
                .collect();
            near = point.release.moved(&moved, R::ONE);
            let scales = point.release.state.iter().map(|x| x.abs().to_f64() + 1.0);
            let shift = (point.shift.iter().zip(scales)).fold(0.0_f64, |most, (x, scale)| {
                most.max(x.abs().to_f64() / scale)
            });
            let by_value = correction.abs().to_f64();
            let size = by_value.max(shift * point.parameter_scale());
            let next = value - correction;
            if !(next.to_f64() >= within.0 && next.to_f64() <= within.1) {
                break;
            }
            let floor = NEWTON_DONE * R::ROUNDOFF * value.abs().to_f64();
            stalls += usize::from(size >= before);
            if size <= floor || stalls > PATIENCE {
                let rate = point.slope.value.abs().to_f64();
                let error = (point.x.error / rate).max(by_value).max(floor);
                let vague = point.slope.error > VAGUE * point.slope.value.abs().to_f64();
                let last = point.sequence.impacts.last();
                let apart = |last: &Impact<R>| point.limits.distance(last.local.u()) > APART;
                let is_none = error.is_nan() || error * rate > settled || vague;
                return (!is_none && !last.is_none_or(apart)).then_some(Root { point, error });
            }
            before = before.min(size);
            value = next;
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::spec::BorderSpec;
    use super::*;
    use crate::model::Model;
    use crate::numerics::{DoubleDouble, Scalar, unit};

    const VALVE: &str = include_str!("../../../../../../models/pressure_relief_valve.toml");

    const STATES: usize = 3;

    /// A limit by differences, against what the columns say.
    fn check(name: &str, x: impl Fn(f64) -> DoubleDouble, slope: DoubleDouble) {
        const STEP: f64 = 1e-20;
        let difference = (x(STEP) - x(-STEP)) / DoubleDouble::from(2.0 * STEP);
        let off = ((difference - slope) / difference).abs().to_f64();
        assert!(off < 1e-7, "{name}: {difference} {slope}");
    }

    /// X(p) and X(x), from the same impacts for all: where the sequence departs, X is no longer what it was.
    #[test]
    fn slopes_of_x_are_its_differences() {
        const LAST: usize = 60;
        const BORDER: &str = "0.02005600568931228428251703106969";
        let mut model = Model::from_toml(VALVE, "valve").unwrap();
        model.set_parameter("q", BORDER).unwrap();
        let near = Place {
            contact: 0,
            state: [0.0, 0.0, 10.0].map(DoubleDouble::from).to_vec(),
        };
        for (parameter, value) in [("q", BORDER), ("kappa", "1.25"), ("r", "0.8")] {
            let problem = Problem::new(&model, &BorderSpec::new(parameter)).unwrap();
            let value: DoubleDouble = value.parse().unwrap();
            let at = |shift: f64| {
                let value = value + DoubleDouble::from(shift);
                (problem.point(value, &near, 0, Extrapolation::default())).unwrap()
            };
            let x = |shift: f64| {
                let mut point = at(shift);
                point.sequence.impacts.truncate(LAST + 1);
                point.limits.x_off_border(&point.sequence).value
            };
            let point = at(0.0);
            check(parameter, x, point.slope.value);
            if parameter != "q" {
                continue;
            }
            let parameters = problem.parameters(value);
            let from = |i: usize, shift: f64| {
                let mut state = point.sequence.impacts[0].state[..STATES].to_vec();
                state[i] += DoubleDouble::from(shift);
                (problem.variation(&parameters, (0, &state), 0, LAST + 1)).unwrap()
            };
            for i in 1..STATES {
                let x = |shift: f64| point.limits.x_off_border(&from(i, shift)).value;
                let weights = unit(STATES + 1, i);
                let slope = (point.limits).x_slope(&from(i, 0.0), &weights, DoubleDouble::ZERO);
                check(&format!("state {i}"), x, slope.value);
            }
        }
    }
}
