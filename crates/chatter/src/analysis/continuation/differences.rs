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
    // Rows that are orthogonal to no direction but by chance.
    let rows: Vec<Vec<R>> = (equations..size)
        .map(|k| {
            let entry = |(i, scale): (usize, &f64)| {
                R::splat(
                    libm::sin(1.0 + (k - equations + 1) as f64 * (1.0 + 1.7 * i as f64)) / scale,
                )
            };
            scales.iter().enumerate().map(entry).collect()
        })
        .collect();
    let factors = (linearised.bordered(rows.iter().map(|row| &**row)))
        .factored()
        .ok_or_else(|| Left::because("the equations are singular"))?;
    let mut gradient = vec![R::ZERO; size];
    for (k, row) in rows.iter().enumerate() {
        let along = factors.solve(&unit(size, equations + k));
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
