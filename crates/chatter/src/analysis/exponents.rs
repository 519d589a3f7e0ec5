//! All Lyapunov exponents of a motion, from the derivative of its flow.
//!
//! Displacements are carried along by the variational equation through impacts, complete chatter, contact and release, and made
//! orthogonal again after each interval (Benettin et al. 1980), or earlier where one has nearly become a combination of the others.
//! What complete chatter, contact or sticking forgets has no exponent: it is minus infinity. Where there is no derivative in the
//! transient, displacements begin anew after the interval.

use crate::analysis::periodic::PeriodicError;
use crate::flow::{Column, FORGOTTEN, NoDerivative, Occurrence, System, Trajectory, may_forget};
use crate::model::Model;
use crate::numerics::{Matrix, balance, unit};
use core::ops::ControlFlow;

/// How exponents are averaged.
#[derive(Clone, Debug, PartialEq)]
pub struct Spec {
    /// Time from one orthogonalisation to the next: a period of the forcing, or about one cycle.
    pub interval: f64,
    /// Intervals that are passed over first.
    pub transient: u64,
    /// Intervals that are averaged over.
    pub intervals: u64,
}

/// The exponents.
#[derive(Clone, Debug, PartialEq)]
pub struct Exponents {
    /// In descending order; minus infinity where a direction is forgotten.
    pub values: Vec<f64>,
    /// Standard error of each, from averages over parts of the time.
    pub errors: Vec<f64>,
    /// The dimension of the attractor after Kaplan and Yorke.
    pub dimension: f64,
    /// The time averaged over.
    pub time: f64,
    /// The intervals that it consists of: fewer than asked for where the observer broke off.
    pub intervals: u64,
}

/// One that shrinks by this part between events is made orthogonal at once: later nothing would be left of it but rounding; …
const SHRUNK: f64 = 1e-4;
/// … and one that shrinks by this part anyhow.
const NEARLY_LOST: f64 = 1e-9;
/// One that grows to this size is made a unit again at once: an interval may be long, and numbers end.
const LARGE: f64 = 1e100;
/// Parts of the time whose averages are compared.
const PARTS: usize = 16;
/// An exponent is zero that grows displacements by less than this in an interval, or is within so many standard errors of it.
const ZERO: f64 = 1e-9;
const STANDARD_ERRORS: f64 = 3.0;
/// The length of a displacement is known to so many roundoffs.
const ROUNDOFFS: f64 = 2.0;
/// Steps of one interval.
const MOST_STEPS: usize = 10_000_000;

/// Averages the growth of displacements along the motion from the model's initial state. The observer hears of the share that
/// is done.
///
/// # Errors
/// The model cannot be compiled, or its motion ends.
pub fn exponents(
    model: &Model,
    spec: &Spec,
    observer: &mut dyn FnMut(f64) -> ControlFlow<()>,
) -> Result<Exponents, PeriodicError> {
    if !(spec.interval > 0.0 && spec.interval.is_finite()) {
        return Err(PeriodicError::BadPeriod {
            value: spec.interval,
        });
    }
    let model = &model.with_telling_numbers(&[]);
    let n = model.states.len();
    let moving: Vec<usize> = (0..n).filter(|&i| Some(i) != model.time).collect();
    let columns = vec![Column::State; moving.len()];
    let system = System::with_columns(model, &columns).map_err(PeriodicError::System)?;
    let parameters = model.parameter_values::<f64>(&[]);
    let initial = model.initial_state(&parameters);
    let of_one_state_each = || -> Vec<Vec<f64>> { moving.iter().map(|&i| unit(n, i)).collect() };
    let mut frame = of_one_state_each();
    let start = [initial, frame.concat()].concat();
    let (mut work, mut trajectory) =
        (system.trajectory_from(&parameters, &start)).map_err(PeriodicError::Start)?;
    let begin = trajectory.time();
    // Lengths say what is forgotten in units that the motion itself takes for like ones, before it forgets any.
    let mut units = vec![1.0; n];
    let mut are_natural = false;
    let mut growth: Vec<Vec<f64>> = Vec::new();
    let total = spec.transient + spec.intervals;
    for interval in 0..total {
        if interval % 8 == 0 && observer(interval as f64 / total as f64).is_break() {
            break;
        }
        put(&frame, &units, (&system, &mut trajectory))?;
        trajectory.set_horizon(begin + spec.interval * (interval + 1) as f64);
        let mut steps = 0;
        let mut logarithms = vec![0.0; moving.len()];
        let mut forgets = trajectory.is_held(&system);
        let mut whole = frame.clone();
        loop {
            let told = (trajectory.advance_to_horizon(&system, &mut work))
                .map_err(PeriodicError::Ended)?;
            steps += 1;
            if steps > MOST_STEPS {
                return Err(PeriodicError::NotSettled {
                    time: trajectory.time(),
                    nearest: f64::NAN,
                });
            }
            // On the way to an attractor displacements may begin anew; along it there is nothing to average.
            let why_none = trajectory.no_derivative();
            if let Some(why) = why_none.filter(|_| interval >= spec.transient) {
                return Err(no_derivative(model, why));
            }
            forgets |= told.is_some_and(|told| may_forget(model, &told));
            if !are_natural && !forgets {
                take(&mut whole, &units, &trajectory, model);
            }
            let is_over = told == Some(Occurrence::Horizon);
            if why_none.is_some() {
                if is_over {
                    frame = of_one_state_each();
                    trajectory.drop_ties();
                    break;
                }
                continue;
            }
            let is_large = trajectory.is_between_steps()
                && (trajectory.state()[n..].iter()).any(|x| x.abs() > LARGE);
            if is_over || (!are_natural && is_large) {
                take(&mut frame, &units, &trajectory, model);
                if !are_natural {
                    are_natural = true;
                    units = natural_units(&whole, &moving, n);
                    for (displacement, &i) in frame.iter_mut().zip(&moving) {
                        (displacement.iter_mut().zip(&units))
                            .for_each(|(x, unit)| *x *= units[i] / unit);
                    }
                }
                add(&mut logarithms, &orthonormal(&mut frame, &moving, forgets));
                if is_over {
                    break;
                }
                put(&frame, &units, (&system, &mut trajectory))?;
                forgets = trajectory.is_held(&system);
            } else if are_natural && trajectory.is_between_steps() {
                let mut ahead = frame.clone();
                take(&mut ahead, &units, &trajectory, model);
                let grown = orthonormal(&mut ahead, &moving, forgets);
                let least = (grown.iter()).fold(f64::INFINITY, |least, &x| least.min(libm::exp(x)));
                let between = told.is_none() && !trajectory.follows_sequence();
                let is_due = is_large || least < NEARLY_LOST || (between && least < SHRUNK);
                if is_due && !trajectory.has_caused_more(&system, &mut work) {
                    frame = ahead;
                    add(&mut logarithms, &grown);
                    put(&frame, &units, (&system, &mut trajectory))?;
                    forgets = trajectory.is_held(&system);
                }
            }
        }
        if interval >= spec.transient {
            growth.push(logarithms);
        }
    }
    if growth.is_empty() {
        return Err(PeriodicError::Interrupted);
    }
    Ok(averaged(&growth, spec.interval))
}

fn no_derivative(model: &Model, why: NoDerivative) -> PeriodicError {
    let name = |contact: usize| model.contacts[contact].name.clone();
    match why {
        NoDerivative::Order(contact) => PeriodicError::OrderMatters {
            contact: name(contact),
        },
        NoDerivative::Direction(surface) => PeriodicError::Unfollowed {
            what: format!(
                "motion that begins where `{}` is zero, against friction along its direction",
                model.surfaces[surface]
            ),
        },
        NoDerivative::Joint(contact) => PeriodicError::Unfollowed {
            what: format!(
                "an impact at `{}` that others feel at the same instant by Moreau's law",
                name(contact)
            ),
        },
    }
}

/// Puts displacements, told in these units, beside a state.
fn put(
    frame: &[Vec<f64>],
    units: &[f64],
    (system, trajectory): (&System, &mut Trajectory<f64>),
) -> Result<(), PeriodicError> {
    let columns: Vec<f64> = (frame.iter())
        .flat_map(|displacement| displacement.iter().zip(units).map(|(y, unit)| y * unit))
        .collect();
    (trajectory.replace_columns(system, &columns)).map_err(PeriodicError::Ended)
}

/// Takes them from there.
fn take(frame: &mut [Vec<f64>], units: &[f64], trajectory: &Trajectory<f64>, model: &Model) {
    let n = units.len();
    for (displacement, column) in frame.iter_mut().zip(trajectory.state()[n..].chunks(n)) {
        for ((x, y), unit) in displacement.iter_mut().zip(column).zip(units) {
            *x = y / unit;
        }
        // Displacements are compared at one time: what rounding leaves of another would never shrink.
        if let Some(time) = model.time {
            displacement[time] = 0.0;
        }
    }
}

fn add(sums: &mut [f64], terms: &[f64]) {
    (sums.iter_mut().zip(terms)).for_each(|(sum, term)| *sum += term);
}

/// Units of the states in which displacements, unit vectors an interval before, are of like size.
fn natural_units(frame: &[Vec<f64>], moving: &[usize], states: usize) -> Vec<f64> {
    let mut map = Matrix::zeros(moving.len(), moving.len());
    for (column, displacement) in frame.iter().enumerate() {
        for (row, &i) in moving.iter().enumerate() {
            map[(row, column)] = displacement[i];
        }
    }
    let mut units = vec![1.0; states];
    for (&i, unit) in moving.iter().zip(balance(&mut map)) {
        units[i] = unit;
    }
    units
}

/// Makes displacements orthogonal, of length one; the logarithms of the lengths that they had, one that was forgotten has none.
fn orthonormal(frame: &mut [Vec<f64>], moving: &[usize], forgets: bool) -> Vec<f64> {
    let mut logarithms = Vec::with_capacity(frame.len());
    for k in 0..frame.len() {
        let (done, rest) = frame.split_at_mut(k);
        let vector = &mut rest[0];
        let before = length(vector);
        // Twice is enough (Kahan).
        for _ in 0..2 {
            for other in done.iter() {
                let along = crate::numerics::dot(vector, other);
                vector
                    .iter_mut()
                    .zip(other)
                    .for_each(|(x, o)| *x -= along * o);
            }
        }
        let after = length(vector);
        let is_left = match forgets {
            true => after > FORGOTTEN * before.max(1.0),
            false => after > 0.0,
        };
        if after.is_finite() && is_left {
            logarithms.push(libm::log(after));
            vector.iter_mut().for_each(|x| *x /= after);
            continue;
        }
        logarithms.push(f64::NEG_INFINITY);
        // Any direction that is not taken.
        for &i in moving {
            vector.fill(0.0);
            vector[i] = 1.0;
            for _ in 0..2 {
                for other in done.iter() {
                    let along = crate::numerics::dot(vector, other);
                    vector
                        .iter_mut()
                        .zip(other)
                        .for_each(|(x, o)| *x -= along * o);
                }
            }
            let rest = length(vector);
            if rest > 0.1 / (moving.len() as f64) {
                vector.iter_mut().for_each(|x| *x /= rest);
                break;
            }
        }
    }
    logarithms
}

fn length(vector: &[f64]) -> f64 {
    crate::numerics::dot(vector, vector).sqrt()
}

/// How far the growth of a displacement swings about one that is steady, as a part of all the time: what the place where a period
/// is cut off makes of its average, which all parts of the time may have in common.
fn swing(growth: &[Vec<f64>], k: usize, steady: f64) -> f64 {
    let (mut off, mut most) = (0.0, 0.0_f64);
    for row in growth {
        off += row[k] - steady;
        most = most.max(off.abs());
    }
    most / growth.len() as f64
}

fn averaged(growth: &[Vec<f64>], interval: f64) -> Exponents {
    let count = growth[0].len();
    let mean = |rows: &[Vec<f64>], k: usize| {
        rows.iter().map(|row| row[k]).sum::<f64>() / (rows.len() as f64 * interval)
    };
    let part = growth.len().div_ceil(PARTS);
    let mut found: Vec<(f64, f64)> = (0..count)
        .map(|k| {
            let value = mean(growth, k);
            let parts: Vec<f64> = growth.chunks(part).map(|rows| mean(rows, k)).collect();
            let size = parts.len() as f64;
            let spread: f64 = parts.iter().map(|x| (x - value) * (x - value)).sum();
            // A single average says nothing of its error, a direction that is forgotten has none. What rounding does to a
            // displacement in each interval does not average out.
            let error = if !value.is_finite() {
                0.0
            } else if parts.len() > 1 {
                let standard = (spread / (size * (size - 1.0))).sqrt();
                standard.max(swing(growth, k, value * interval) / interval)
                    + ROUNDOFFS * f64::EPSILON / interval
            } else {
                f64::NAN
            };
            (value, error)
        })
        .collect();
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    Exponents {
        dimension: dimension(&found, ZERO / interval),
        values: found.iter().map(|(value, _)| *value).collect(),
        errors: found.iter().map(|(_, error)| *error).collect(),
        time: growth.len() as f64 * interval,
        intervals: growth.len() as u64,
    }
}

/// Kaplan and Yorke's dimension: so many exponents as have a sum that is not negative, and the share of the next. One that its error
/// does not tell from zero, as the one along the flow, is zero if it is negative, or the nearest to zero where none is: a positive one
/// whose error is large is still more likely that than none.
fn dimension(found: &[(f64, f64)], nothing: f64) -> f64 {
    let may_vanish =
        |&(value, error): &(f64, f64)| value.abs() <= nothing.max(STANDARD_ERRORS * error);
    // They are in descending order.
    let nearest = found
        .iter()
        .rposition(|one| may_vanish(one) && one.0 >= 0.0);
    let any_below = found.iter().any(|one| may_vanish(one) && one.0 < 0.0);
    let mut sum = 0.0;
    for (k, one) in found.iter().enumerate() {
        let is_zero = one.0.abs() <= nothing
            || may_vanish(one) && (one.0 < 0.0 || !any_below && nearest == Some(k));
        let value = if is_zero { 0.0 } else { one.0 };
        if sum + value < 0.0 {
            let share = if value.is_finite() { sum / -value } else { 0.0 };
            return k as f64 + share;
        }
        sum += value;
    }
    found.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_dimension_of_a_short_average_is_of_what_it_found() {
        // Lorenz's attractor, after a few turns: a positive exponent whose error is a third of it.
        let few = [(0.948, 0.36), (-0.032, 0.17), (-14.58, 0.3)];
        assert!((dimension(&few, 1e-9) - (2.0 + 0.948 / 14.58)).abs() < 1e-12);
        let cycle = [(1e-5, 1e-4), (-0.3, 0.01)];
        assert_eq!(dimension(&cycle, 1e-9), 1.0);
        let torus = [(1e-5, 1e-4), (-2e-5, 1e-4), (-0.3, 0.01)];
        assert!((dimension(&torus, 1e-9) - 2.0).abs() < 1e-4);
    }

    fn of(text: &str, spec: &Spec) -> Exponents {
        let model = Model::from_toml(text, "test").unwrap();
        exponents(&model, spec, &mut |_| ControlFlow::Continue(())).unwrap()
    }

    #[test]
    fn a_damped_oscillator_loses_its_damping() {
        let spec = Spec {
            interval: 1.0,
            transient: 40,
            intervals: 400,
        };
        let found = of(
            "[flight]\nx = 'v'\nv = '-x - 0.2*v + cos(t)'\n[initial]\nx = 0\nv = 0\n",
            &spec,
        );
        assert!(
            (found.values.iter().sum::<f64>() + 0.2).abs() < 1e-10,
            "{found:?}"
        );
        assert!(
            found.values.iter().all(|value| (value + 0.1).abs() < 0.02),
            "{found:?}"
        );
        assert_eq!(found.dimension, 0.0);
    }

    #[test]
    fn what_shrinks_by_much_is_not_forgotten() {
        let spec = Spec {
            interval: 1.0,
            transient: 4,
            intervals: 64,
        };
        let found = of(
            "[flight]\nx = '-x'\ny = 'x - 40*y'\nz = 'y - 400*z'\n[initial]\nx = 1\ny = 1\nz = 1\n",
            &spec,
        );
        for (value, expected) in found.values.iter().zip([-1.0, -40.0, -400.0]) {
            assert!(
                (value - expected).abs() < 1e-9 * expected.abs(),
                "{found:?}"
            );
        }
    }

    #[test]
    fn impacts_contract_by_the_square_of_restitution() {
        // The sum of exponents is the logarithm of what volumes shrink by: r^2 at an impact, e^-0.3 a unit of time.
        let text = "[flight]\nx = 'v'\nv = '-x - 0.3*v + cos(2*t)'\n[[contact]]\ngap = '0 - x'\nimpulse = { v = -1 }\n\
                    restitution = 0.6\n[initial]\nx = -1\nv = 0\n";
        let period = core::f64::consts::TAU / 2.0;
        let spec = Spec {
            interval: period,
            transient: 200,
            intervals: 600,
        };
        let found = of(text, &spec);
        let model = Model::from_toml(text, "test").unwrap();
        let until = |periods: f64| {
            let spec = crate::analysis::simulate::Spec::until(period * periods);
            let run = crate::analysis::simulate::simulate::<f64>(&model, &spec, &mut |_| {
                ControlFlow::Continue(())
            });
            run.unwrap().counts.impacts as f64
        };
        let impacts = (until(800.0) - until(200.0)) / (600.0 * period);
        let expected = -0.3 + 2.0 * impacts * libm::log(0.6);
        let sum: f64 = found.values.iter().sum();
        assert!((sum - expected).abs() < 1e-8, "{sum} {expected}");
    }

    /// The rimless wheel: what is left of the energy at each step is cos(2 a)^2, the time of a step an integral.
    #[test]
    fn errors_know_of_periods_that_are_cut_off() {
        let (a, slope): (f64, f64) = (0.3, 0.15);
        let left = libm::cos(2.0 * a) * libm::cos(2.0 * a);
        let gained = 2.0 * (libm::cos(slope - a) - libm::cos(slope + a));
        let start = left * gained / (1.0 - left);
        let slowness =
            |theta: f64| 1.0 / (start + 2.0 * (libm::cos(slope - a) - libm::cos(theta))).sqrt();
        let (parts, width) = (1000, 2.0 * a / 1000.0);
        let time: f64 = (0..parts)
            .map(|k| {
                let at = slope - a + f64::from(k) * width;
                let middle = slowness(at + 0.5 * width);
                (slowness(at) + 4.0 * middle + slowness(at + width)) * width / 6.0
            })
            .sum();
        let expected = libm::log(left) / time;
        let text = "[flight]\nth = 'w'\nw = 'sin(th)'\n[[event]]\nname = 'strike'\nsurface = 'th - 0.45'\n\
                    direction = 'rising'\nreset = { th = '-0.15', w = 'cos(0.6)*w' }\n[initial]\nth = '-0.1'\nw = 0.4\n";
        for (interval, intervals) in [(1.0, 400), (0.37, 1000), (2.3, 150)] {
            let spec = Spec {
                interval,
                transient: 100,
                intervals,
            };
            let found = of(text, &spec);
            let off = (found.values[1] - expected).abs();
            assert!(
                off <= found.errors[1] && found.errors[1] < 0.02,
                "{off:e} {found:?}"
            );
            assert!(
                found.values[0].abs() <= found.errors[0].max(1e-12),
                "{found:?}"
            );
        }
    }

    #[test]
    fn complete_chatter_forgets_two_directions() {
        let text = include_str!("../../../../models/pressure_relief_valve.toml");
        let mut model = Model::from_toml(text, "valve").unwrap();
        model.set_parameter("q", "0.0195").unwrap();
        let spec = Spec {
            interval: 3.526_655_749_659_584,
            transient: 20,
            intervals: 100,
        };
        let found = exponents(&model, &spec, &mut |_| ControlFlow::Continue(())).unwrap();
        assert!(found.values[0].abs() < 1e-9, "{found:?}");
        assert_eq!(found.values[1..], [f64::NEG_INFINITY; 2]);
        assert_eq!(found.dimension.round(), 1.0);
    }
}
