//! Stations along a solution curve, by pseudo-arclength.

use super::newton::{Condition, Corrected, NewtonError, newton};
use super::problem::Problem;
use crate::numerics::{Factored, Real, dot, moved, unit};

/// How a curve is followed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// First step, in parts of the solution's size.
    pub first_step: f64,
    /// No step is longer.
    pub longest_step: f64,
    /// Nor shorter: a curve that needs it ends.
    pub shortest_step: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            first_step: 1e-3,
            longest_step: 0.05,
            shortest_step: 1e-13,
        }
    }
}

/// A point of a curve.
#[derive(Clone, Debug)]
pub struct Station<R = f64> {
    /// The unknowns, free parameters last.
    pub at: Vec<R>,
    /// Direction of the curve, of length one where each unknown is measured by its size.
    pub tangent: Vec<R>,
    /// Of the correction that led to it.
    pub residual: f64,
    /// The latest correction against the solution's size: an estimate of the error.
    pub correction: f64,
    /// Sign of the determinant of the equations bordered by the tangent: it changes at a branch point.
    pub orientation: f64,
}

/// Why a curve has no next station.
#[derive(Clone, Debug, PartialEq)]
pub enum StepError {
    /// The shortest step fails, for this reason.
    TooShort(NewtonError),
}

/// A curve that is being followed: the latest station, and the step to the next one.
#[derive(Clone, Debug)]
pub struct Curve<R = f64> {
    /// Where it is.
    pub station: Station<R>,
    /// The next step.
    pub step: f64,
    settings: Settings,
}

/// Corrections that a step should need: with fewer it may grow, with more it shrinks.
const EASY: usize = 4;
const HARD: usize = 7;
/// The direction may turn by so much in a step: the cosine.
const LEAST_COSINE: f64 = 0.94;
/// From end to end a step goes the mean of the directions at both, but for so much: else it has led to another curve. Steps shorter than
/// this part of the longest lead nowhere else.
const MOST_ASKEW: f64 = 0.1;
const NEXT_DOOR: f64 = 1e-4;

/// The parameter stands still along a direction that has no more than this part of it.
const STANDS: f64 = 1e-9;

/// The tangent from the factors of equations bordered by a row that is not orthogonal to it.
fn along<R: Real>(factors: &Factored<R>, scales: &[f64]) -> Option<Vec<R>> {
    let size = scales.len();
    let mut tangent = factors.solve(&unit(size, size - 1));
    let length = length(&tangent, scales);
    if !(length > R::ZERO && length.is_finite()) {
        return None;
    }
    tangent.iter_mut().for_each(|x| *x = *x / length);
    Some(tangent)
}

/// The tangent of the curve at one of its points, on the side that a row that is not orthogonal to it points to.
///
/// # Errors
/// The equations have no meaning there, or are singular with that row.
pub fn tangent<R: Real>(
    problem: &mut dyn Problem<R>,
    at: &[R],
    row: &[R],
) -> Result<Vec<R>, NewtonError> {
    let linearised = problem.evaluate(at).map_err(NewtonError::Left)?;
    let factors = linearised.bordered([row]).factored();
    let factors = factors.ok_or(NewtonError::Singular)?;
    along(&factors, problem.scales()).ok_or(NewtonError::Singular)
}

pub(super) fn length<R: Real>(vector: &[R], scales: &[f64]) -> R {
    let measured = vector.iter().zip(scales);
    let square = measured.fold(R::ZERO, |sum, (&x, &scale)| {
        let x = x / R::splat(scale);
        sum + x * x
    });
    square.sqrt()
}

/// The condition of moving so far along its tangent.
fn ahead<R: Real>(station: &Station<R>, step: f64, scales: &[f64]) -> Condition<R> {
    let row: Vec<R> = (station.tangent.iter().zip(scales))
        .map(|(&x, scale)| x / R::splat(scale * scale))
        .collect();
    let value = dot(&row, &station.at) + R::splat(step);
    Condition { row, value }
}

impl<R: Real> Station<R> {
    /// Where a curve begins, in this direction: whether it turns is not known yet.
    pub fn beginning(found: Corrected<R>, tangent: Vec<R>) -> Self {
        Self {
            tangent,
            at: found.at,
            residual: found.residual,
            correction: found.correction,
            orientation: 0.0,
        }
    }

    /// A point of the curve near `start` at which one unknown has its value; the tangent lets the parameter grow.
    ///
    /// # Errors
    /// There is none nearby.
    pub fn near(
        problem: &mut dyn Problem<R>,
        start: &[R],
        fixed: usize,
    ) -> Result<Self, NewtonError> {
        let size = problem.unknowns();
        let condition = Condition::fixed(size, fixed, start[fixed]);
        let found = newton(problem, start, &[condition])?;
        let along = along(&found.factors, problem.scales()).ok_or(NewtonError::Singular)?;
        let grows = along[size - 1] >= R::ZERO;
        let station = Self {
            orientation: found.factors.determinant_sign(),
            at: found.at,
            tangent: along,
            residual: found.residual,
            correction: found.correction,
        };
        // Another unknown than the parameter may grow while that falls.
        Ok(if grows { station } else { station.reversed() })
    }

    /// A point of the curve near `start`, with the same parameter unless that all but stands still along it, as in a family of orbits at one
    /// value: then with the same value of the unknown that changes most.
    ///
    /// # Errors
    /// There is none nearby.
    pub fn beside(problem: &mut dyn Problem<R>, start: &[R]) -> Result<Self, NewtonError> {
        let size = start.len();
        let scales = problem.scales().to_vec();
        // Where the equations are singular with the parameter held the direction is what they take to zero, only the longer.
        let mut with_held = |k: usize| tangent(problem, start, &unit(size, k));
        let along = with_held(size - 1);
        let along = along.or_else(|why| (0..size).find_map(|k| with_held(k).ok()).ok_or(why))?;
        let measured = |k: usize| (along[k].to_f64() / scales[k]).abs();
        let fixed = match measured(size - 1) > STANDS {
            true => size - 1,
            false => (0..size)
                .max_by(|&a, &b| measured(a).total_cmp(&measured(b)))
                .unwrap_or(size - 1),
        };
        Self::near(problem, start, fixed)
    }

    /// The point of the curve so far along this station's tangent.
    ///
    /// # Errors
    /// There is none nearby.
    pub fn ahead(
        &self,
        problem: &mut dyn Problem<R>,
        step: f64,
    ) -> Result<(Self, usize), NewtonError> {
        let scales = problem.scales().to_vec();
        let guess = moved(&self.at, &self.tangent, R::splat(step));
        let condition = ahead(self, step, &scales);
        let found = newton(problem, &guess, &[condition])?;
        let along = along(&found.factors, &scales).ok_or(NewtonError::Singular)?;
        let station = Self {
            orientation: found.factors.determinant_sign(),
            at: found.at,
            tangent: along,
            residual: found.residual,
            correction: found.correction,
        };
        Ok((station, found.steps))
    }

    /// The condition of lying on the plane across the curve here.
    pub fn across(&self, scales: &[f64]) -> Condition<R> {
        ahead(self, 0.0, scales)
    }

    /// How far ahead a point is, along the tangent.
    pub fn reach(&self, to: &[R], scales: &[f64]) -> R {
        let parts = (to.iter().zip(&self.at)).zip(self.tangent.iter().zip(scales));
        parts.fold(R::ZERO, |sum, ((&x, &from), (&along, &scale))| {
            sum + (x - from) * along / R::splat(scale * scale)
        })
    }

    /// How far away a point is.
    pub fn distance(&self, to: &[R], scales: &[f64]) -> R {
        let off: Vec<R> = to.iter().zip(&self.at).map(|(&x, &y)| x - y).collect();
        length(&off, scales)
    }

    /// By how much the way to another point of the curve differs from the mean of the directions at both: by the third order of how far
    /// it is, if they are on one curve.
    fn askew(&self, to: &Self, scales: &[f64]) -> f64 {
        let measured = |of: &dyn Fn(usize) -> R| -> Vec<f64> {
            let parts = scales.iter().enumerate();
            parts.map(|(i, scale)| of(i).to_f64() / scale).collect()
        };
        let way = measured(&|i| to.at[i] - self.at[i]);
        let mean = measured(&|i| to.tangent[i] + self.tangent[i]);
        let length = |vector: &[f64]| vector.iter().fold(0.0, |sum, x| sum + x * x).sqrt();
        let lengths = (length(&way), length(&mean));
        let apart = way
            .iter()
            .zip(&mean)
            .map(|(a, b)| a / lengths.0 - b / lengths.1);
        length(&apart.collect::<Vec<f64>>())
    }

    /// The same point, followed the other way.
    #[must_use]
    pub fn reversed(mut self) -> Self {
        self.tangent.iter_mut().for_each(|x| *x = -*x);
        self.orientation = -self.orientation;
        self
    }

    /// How the last unknown changes along the tangent.
    pub fn parameter_slope(&self) -> R {
        self.tangent.last().copied().unwrap_or(R::splat(f64::NAN))
    }

    /// The last unknown.
    pub fn parameter(&self) -> R {
        self.at.last().copied().unwrap_or(R::splat(f64::NAN))
    }
}

impl<R: Real> Curve<R> {
    /// From a station, along its tangent.
    pub fn new(station: Station<R>, settings: Settings) -> Self {
        Self {
            station,
            step: settings.first_step,
            settings,
        }
    }

    /// The next station; the curve itself stays where it is until it [`moves`](Self::moves) there. The length of the step is
    /// told with it.
    ///
    /// # Errors
    /// Even the shortest step leads to none.
    pub fn next(&mut self, problem: &mut dyn Problem<R>) -> Result<(Station<R>, f64), StepError> {
        let scales = problem.scales().to_vec();
        loop {
            let step = self.step;
            let failed = match self.station.ahead(problem, step) {
                Ok((station, steps)) => {
                    let cosine: f64 = (station.tangent.iter().zip(&self.station.tangent))
                        .zip(&scales)
                        .map(|((a, b), scale)| a.to_f64() / scale * (b.to_f64() / scale))
                        .sum();
                    let askew = self.station.askew(&station, &scales);
                    let goes_on =
                        step < NEXT_DOOR * self.settings.longest_step || askew < MOST_ASKEW;
                    if cosine >= LEAST_COSINE && goes_on {
                        if steps <= EASY {
                            self.step = (1.6 * step).min(self.settings.longest_step);
                        } else if steps >= HARD {
                            self.step = 0.5 * step;
                        }
                        return Ok((station, step));
                    }
                    NewtonError::Stalled {
                        correction: askew.max(1.0 - cosine),
                        steps,
                    }
                }
                Err(error) => error,
            };
            self.step = 0.4 * step;
            if self.step < self.settings.shortest_step {
                return Err(StepError::TooShort(failed));
            }
        }
    }

    /// Goes to a station.
    pub fn moves(&mut self, station: Station<R>) {
        self.station = station;
    }

    /// The direction anew, where the same solution is told by other equations: however short a step is, it would not go on in the old one.
    pub fn turns(&mut self, problem: &mut dyn Problem<R>) {
        if let Ok((turned, _)) = self.station.ahead(problem, 0.0) {
            self.station = turned;
        }
    }
}
