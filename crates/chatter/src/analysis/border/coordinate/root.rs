//! The border as the smooth root X(p) = 0.

use super::super::error::{BorderError, Lack};
use super::super::problem::{Here, Problem};
use super::super::release::equations::{Place, ReleasePoint};
use super::super::release::forcing::Turn;
use super::limits::Limits;
use super::sequence::Sequence;
use crate::numerics::{
    Equations, Estimate, Factored, Linearised, Matrix, Newton, Real, Scalar, dot, moved,
};

/// Newton's method gives up after so many steps: from where it starts each gains two digits at first.
const NEWTON_STEPS: usize = 30;

/// So often a correction may not be the smallest so far: away from the root each sequence shows only so much of its X.
const PATIENCE: usize = 2;

/// A correction of so many roundoffs is no correction.
const NEWTON_DONE: f64 = 2.0;

/// Where corrections stop shrinking the error of X must be as small as the roundoff to this power, 4e-7 for doubles, else
/// there is no root, or not enough of the sequence is near it to tell.
const SETTLED_POWER: f64 = 0.4;

/// X is asked of so many impacts after the nearest one, where its error is larger than the roundoff of a double to this power.
const LATER: usize = 6;
const VAGUE_POWER: f64 = 0.6;

/// At a root dX/dp is known at least to this part of itself, and the sequence comes at least this near to u*, relative
/// to u*.
const VAGUE: f64 = 0.1;
const APART: f64 = 0.05;

/// Chatter ends at the release point where the orbit began if the distance is this small against the way there. Release
/// points lie apart: there is nothing in between.
const CLOSED: f64 = 1e-7;

/// Where a direct loop through the surface of release points has a multiplier nearer to 1 than this, border orbits are not alone:
/// something is conserved.
const ALONE: f64 = 1e-6;

/// X and its derivative at a parameter value, with the sequence that they were taken from: up to the last impact that still
/// approaches the border.
#[derive(Clone, Debug)]
pub(crate) struct Point<'p, R> {
    pub here: Here<'p, R>,
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
    /// How coordinates return from a unit of each.
    pub returns: Vec<Vec<R>>,
    /// What the parameter adds.
    pub by_parameter: Vec<R>,
    /// What the rate at release adds.
    pub by_rate: Vec<Estimate<R>>,
    /// dX by the coordinates.
    pub covector: Vec<R>,
}

impl<R: Real> Memory<R> {
    /// What coordinates come to where each loop adds this: (I - sign returns)^-1 of it; `None` where that has no answer.
    pub(crate) fn settled(&self, added: &[R], sign: f64) -> Option<Vec<R>> {
        let mut rows = Matrix::identity(added.len());
        for (j, returned) in self.returns.iter().enumerate() {
            for (i, &back) in returned.iter().enumerate() {
                rows[(i, j)] -= R::splat(sign) * back;
            }
        }
        regular(&rows, ALONE).map(|factors| factors.solve(added))
    }
}

/// The factors of what does not return of changes, where none returns but for less than this part.
pub(crate) fn regular<R: Real>(rows: &Matrix<R>, least: f64) -> Option<Factored<R>> {
    let small = |column: Vec<R>| column.iter().all(|x| x.abs().to_f64() * least <= 1.0);
    (rows.factored()).filter(|factors| factors.inverse().all(small))
}

impl<R: Real> Point<'_, R> {
    /// The size of the parameter, or what of it changes X by one.
    pub(crate) fn parameter_scale(&self) -> f64 {
        let unit = 1.0 / self.slope.value.abs().to_f64();
        self.here.value.abs().to_f64().max(unit)
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
pub(crate) struct Root<'p, R> {
    pub point: Point<'p, R>,
    /// Estimated error of the parameter value.
    pub error: f64,
}

impl<'p, R: Real> Here<'p, R> {
    /// X and dX/dp near a border.
    pub(crate) fn point(self, near: &Place, settles: usize) -> Result<Point<'p, R>, BorderError> {
        let mut release = self.release(near)?;
        let mut limits = self.limits(&release)?;
        let most = settles + limits.impacts;
        let start = (release.contact, &*release.state);
        let mut sequence = self.variation(start, settles, most)?;
        if sequence.impacts.len() <= sequence.begins {
            return Err(self.lacks(Lack::Chatter));
        }
        let followed = sequence.impacts.len();
        let later = sequence.impacts.split_off(limits.nearest(&sequence) + 1);
        limits.set_noise(&sequence);
        let mut x = limits.x(&sequence);
        // Where that is vague, as N is large, what comes after the nearest impact says more: N has died out while X has hardly grown.
        if x.error.is_nan() || x.error > libm::pow(f64::ROUNDOFF, VAGUE_POWER) {
            let mut shown = sequence.impacts.len();
            for impact in later.into_iter().take(LATER) {
                let is_near = limits.distance(impact.local.u()) <= APART;
                sequence.impacts.push(impact);
                limits.set_noise(&sequence);
                let later = limits.x(&sequence);
                if is_near && later.error < x.error {
                    (x, shown) = (later, sequence.impacts.len());
                }
            }
            sequence.impacts.truncate(shown);
            limits.set_noise(&sequence);
        }
        let (held_slope, held_restitution) = (release.slope.clone(), release.restitution_slope);
        let ends: Vec<Estimate<R>> = (0..self.problem.states())
            .map(|i| limits.place(&sequence, i))
            .collect();
        let place = Estimate::values(&ends);
        let turns = self.turns(&release.state, &place);
        let free = || release.free.iter().copied();
        let returning = |weights: &Vec<R>| -> Vec<Estimate<R>> {
            free()
                .map(|i| limits.place_slope(&sequence, i, weights))
                .collect()
        };
        let turned = |i: usize| Turn::of(&turns, i);
        // Away from the border few impacts show where they accumulate: what cannot be told from zero would lead astray by what X makes of it.
        let vague = libm::pow(R::ROUNDOFF, VAGUE_POWER);
        let missed = |is_told: bool| -> Vec<R> {
            let off = |i: usize| {
                let off = place[i] - release.state[i] - turned(i)[0];
                let told = ends[i].error <= vague || off.abs().to_f64() > ends[i].error;
                if told == is_told { off } else { R::ZERO }
            };
            free().map(off).collect()
        };
        let [missed, untold] = [true, false].map(missed);
        let returns: Vec<Vec<R>> = (release.directions.iter())
            .map(|direction| Estimate::values(&returning(direction)))
            .collect();
        let by_parameter = Estimate::values(&returning(&release.slope))
            .into_iter()
            .zip(free());
        let x_along =
            |weights: &Vec<R>| limits.x_along(&sequence, &release, weights, R::ZERO).value;
        let memory = Memory {
            by_parameter: by_parameter.map(|(back, i)| back - turned(i)[1]).collect(),
            by_rate: returning(&release.jump),
            covector: release.directions.iter().map(x_along).collect(),
            returns,
        };
        let settled =
            |added: &[R]| (memory.settled(added, 1.0)).ok_or_else(|| self.lacks(Lack::Alone));
        let shift = settled(&missed)?;
        let unknown = dot(&memory.covector, &settled(&untold)?);
        x.error = x.error.max(unknown.abs().to_f64());
        let moved = settled(&memory.by_parameter)?;
        release.follow_orbit(&moved);
        let slope = limits.x_slope(&sequence, &release.slope, release.restitution_slope);
        Ok(Point {
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
            here: self,
        })
    }
}

/// X(p) = 0, from point to point: each is looked for where the one before leads.
struct Closing<'p, R> {
    problem: &'p Problem,
    near: Place,
    settles: usize,
    within: (f64, f64),
    latest: Option<Point<'p, R>>,
}

impl<R: Real> Equations<R> for Closing<'_, R> {
    /// Beyond where the root may lie, or no sequence comes near u*.
    type Left = ();

    fn evaluate(&mut self, at: &[R]) -> Result<Linearised<R>, ()> {
        let value = at[0];
        if let Some(before) = &self.latest {
            if !(self.within.0..=self.within.1).contains(&value.to_f64()) {
                return Err(());
            }
            let by = value - before.here.value;
            let by = moved(&before.shift, &before.release.slope, by);
            self.near = before.release.moved(&by, R::ONE);
        }
        let here = self.problem.at(value).map_err(drop)?;
        let point = here.point(&self.near, self.settles).map_err(drop)?;
        let linearised = Linearised {
            residual: vec![point.x.value + point.x_shift],
            jacobian: Matrix::from_rows(&[vec![point.slope.value]]),
        };
        self.latest = Some(point);
        Ok(linearised)
    }

    /// In parts of the parameter, however large what changes X by one is.
    fn size(&self, at: &[R], correction: &[R]) -> f64 {
        let Some(point) = &self.latest else {
            return f64::INFINITY;
        };
        let states = point.shift.iter().zip(&point.release.state);
        let scale = point.parameter_scale();
        let size = states.fold(correction[0].abs().to_f64(), |most, (x, state)| {
            most.max(scale * x.abs().to_f64() / (state.abs().to_f64() + 1.0))
        });
        let value = at[0].abs().to_f64();
        size / if value > 0.0 { value } else { scale }
    }
}

impl Problem {
    /// The root that Newton's method leads to from a value close enough for the sequence to come near u*.
    pub(crate) fn root<R: Real>(
        &self,
        guess: R,
        near: &Place,
        settles: usize,
        within: (f64, f64),
    ) -> Option<Root<'_, R>> {
        let settled = libm::pow(R::ROUNDOFF, SETTLED_POWER);
        let newton = Newton {
            steps: NEWTON_STEPS,
            settled: f64::INFINITY,
            stalls: PATIENCE,
            ..Newton::to_rounding::<R>(NEWTON_DONE)
        };
        let mut closing = Closing {
            problem: self,
            near: near.clone(),
            settles,
            within,
            latest: None,
        };
        let found = newton.solve(&mut closing, &[guess]).ok()?;
        let point = closing.latest?;
        let rate = point.slope.value.abs().to_f64();
        let floor = NEWTON_DONE * R::ROUNDOFF * point.here.value.abs().to_f64();
        let by_value = (found.at[0] - point.here.value).abs().to_f64();
        let error = (point.x.error / rate).max(by_value).max(floor);
        let is_known = error * rate <= settled && point.slope.error <= VAGUE * rate;
        let last = point.sequence.impacts.last()?;
        let is_near = point.limits.distance(last.local.u()) <= APART;
        (is_known && is_near).then_some(Root { point, error })
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
                problem.at(value).unwrap().point(&near, 0).unwrap()
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
            let from = |i: usize, shift: f64| {
                let mut state = point.sequence.impacts[0].state[..STATES].to_vec();
                state[i] += DoubleDouble::from(shift);
                (point.here.variation((0, &state), 0, LAST + 1)).unwrap()
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
