//! The leading-order coefficients at a value of the parameter.

use crate::analysis::border::{
    BorderError, BorderSpec, Lack, LeadingOrder, Problem, leading_order,
};
use crate::model::Model;
use crate::numerics::Real;

/// The leading-order coefficients at a parameter value near a border, as the paper has them at q = 0.020056: for the
/// release point whose chatter is nearest to one.
///
/// # Errors
/// As for [`borders_in`](super::borders_in), and [`BorderError::NotCrossed`] if the section is not crossed.
pub fn leading_order_at<R: Real>(
    model: &Model,
    spec: &BorderSpec,
    value: R,
) -> Result<LeadingOrder<R>, BorderError> {
    let problem = Problem::new(model, spec)?;
    let at = problem.at(value.to_f64())?;
    let releases = at.release_points()?.into_iter();
    let samples = releases.map(|release| (at.sample(release.clone()), release));
    let nearest = samples.min_by(|(a, _), (b, _)| a.distance.total_cmp(&b.distance));
    let (sample, release) = nearest.ok_or_else(|| at.lacks(Lack::Release))?;
    let point = problem.at(value)?.point(&release.place(), sample.settles)?;
    Ok(leading_order(&point, &point.chart())??)
}
