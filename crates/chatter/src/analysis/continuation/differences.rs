//! Derivatives by differences, of what has no others.

use super::problem::{Left, Problem};
use crate::numerics::{Real, moved, unit};

/// A function at a solution of a problem's equations, with a gradient that is right along its solutions: all that Newton's
/// method needs beside the equations themselves. Across them the function may be anything.
///
/// With N the directions that solve the linear equations, one for each free parameter, and rows R with R N = 1, the
/// gradient is the sum of R weighted with the differences along N.
///
/// # Errors
/// The function has no value there, or the equations are singular.
pub fn differenced<R, P, F>(problem: &mut P, at: &[R], mut value: F) -> Result<(R, Vec<R>), Left>
where
    R: Real,
    P: Problem<R>,
    F: FnMut(&mut P, &[R]) -> Result<R, Left>,
{
    let size = at.len();
    let linearised = problem.evaluate(at)?;
    let equations = linearised.residual.len();
    let scales = problem.scales().to_vec();
    // Rows that are orthogonal to no direction but by chance: along a curve such chances come, so that they only lead to others.
    let mut rows: Vec<Vec<R>> = (equations..size)
        .map(|k| {
            let entry = |(i, scale): (usize, &f64)| {
                R::splat(
                    libm::sin(1.0 + (k - equations + 1) as f64 * (1.0 + 1.7 * i as f64)) / scale,
                )
            };
            scales.iter().enumerate().map(entry).collect()
        })
        .collect();
    let directions = |rows: &[Vec<R>]| -> Result<Vec<Vec<R>>, Left> {
        let factors = (linearised.bordered(rows.iter().map(|row| &**row)))
            .factored()
            .ok_or_else(|| Left::because("the equations are singular"))?;
        let along = |k: usize| factors.solve(&unit(size, k));
        Ok((equations..size).map(along).collect())
    };
    rows = orthonormal(directions(&rows)?, &scales);
    let mut gradient = vec![R::ZERO; size];
    for (row, along) in rows.iter().zip(directions(&rows)?) {
        let reach = (along.iter().zip(&scales)).fold(0.0_f64, |most, (x, scale)| {
            most.max(x.abs().to_f64() / scale)
        });
        let step = R::splat(libm::cbrt(R::ROUNDOFF) / reach.max(f64::MIN_POSITIVE));
        let mut beside = |by: R| value(problem, &moved(at, &along, by));
        let slope = (beside(step)? - beside(-step)?) / (step + step);
        for (entry, &weight) in gradient.iter_mut().zip(row) {
            *entry += slope * weight;
        }
    }
    let here = value(problem, at)?;
    Ok((here, gradient))
}

/// Rows whose products with these directions, made orthogonal and as long as one in units of the scales, are one and zero.
fn orthonormal<R: Real>(directions: Vec<Vec<R>>, scales: &[f64]) -> Vec<Vec<R>> {
    let product = |a: &[R], b: &[R]| -> R {
        (a.iter().zip(b)).fold(R::ZERO, |sum, (&x, &y)| x.mul_add(y, sum))
    };
    let mut units: Vec<Vec<R>> = Vec::with_capacity(directions.len());
    for direction in directions {
        let mut own: Vec<R> = (direction.iter().zip(scales))
            .map(|(&x, &scale)| x / R::splat(scale))
            .collect();
        // Twice: of nearly parallel ones once leaves little but rounding.
        for _ in 0..2 {
            for other in &units {
                let share = product(&own, other);
                for (x, &y) in own.iter_mut().zip(other) {
                    *x -= share * y;
                }
            }
            let length = product(&own, &own).sqrt();
            own.iter_mut().for_each(|x| *x = *x / length);
        }
        units.push(own);
    }
    for row in &mut units {
        for (x, &scale) in row.iter_mut().zip(scales) {
            *x = *x / R::splat(scale);
        }
    }
    units
}
