//! Curves of chatter borders: the border orbit found anew at each value of the second parameter, near where the two before it
//! say it lies. On one side of a border the orbit has no equations, so there is nothing to follow by its arc length.

use super::super::branch::{
    End, Kept, Ledger, Limits, Point, Side, SpecialKind, Then, damaged, joined,
};
use super::super::diary::{Diary, Told};
use super::super::error::PeriodicError;
use super::SpecialCurve;
use super::start::failed;
use crate::analysis::border::{Border, BorderSpec};
use crate::analysis::border_search::{border_near, borders_in};
use crate::model::Model;

/// Parts of the interval that a border is looked for in.
const SAMPLES: usize = 6;
/// That interval, in steps of the border to either side; and the least, in parts of the border's own value.
const WIDTH: f64 = 0.5;
const LEAST: f64 = 1e-6;
/// Steps are halved so often.
const HALVINGS: u32 = 12;
/// The first step along the curve, in parts of the others.
const FIRST: f64 = 0.01;

struct Search<'m> {
    model: &'m Model,
    free: [usize; 2],
    spec: BorderSpec,
}

impl Search<'_> {
    fn at(&self, value: f64) -> Result<Model, PeriodicError> {
        let mut model = self.model.clone();
        let name = model.parameters[self.free[1]].name.clone();
        let set = model.set_parameter(&name, &format!("{value:?}"));
        set.map_err(failed)?;
        Ok(model)
    }

    /// The border nearest to a value of the first parameter, no further than so much.
    fn near(&self, second: f64, (value, width): (f64, f64)) -> Option<Border<f64>> {
        let model = self.at(second).ok()?;
        let found = borders_in::<f64>(&model, &self.spec, value - width, value + width).ok()?;
        found.nearest(value)
    }
}

fn point(border: &Border<f64>, second: f64, monitors: usize) -> Point {
    Point {
        parameters: vec![border.value.value, second],
        period: border.period.value,
        impacts: None,
        multipliers: Vec::new(),
        modulus_error: f64::NAN,
        state: border.release.state.clone(),
        monitors: vec![f64::NAN; monitors],
        residual: 0.0,
        correction: border.value.error,
    }
}

/// Follows the border nearest to the model's values over the second parameter, to both sides.
pub(crate) fn follow(
    model: &Model,
    (free, monitors): ([usize; 2], usize),
    limits: &Limits,
    diary: &mut Diary<'_>,
) -> Result<SpecialCurve, PeriodicError> {
    let parameters = model.parameter_values::<f64>(&[]);
    let [value, second] = free.map(|index| parameters[index]);
    let mut spec = BorderSpec::new(&model.parameters[free[0]].name);
    let first = border_near::<f64>(model, &spec, value).map_err(failed)?;
    spec.samples = SAMPLES;
    let search = Search { model, free, spec };
    let (low, high) = limits.range;
    let longest = limits.longest_step * (high - low);
    let mut sides: Vec<Side> = Vec::new();
    for (sign, edge) in [(-1.0, low), (1.0, high)] {
        if let Some(side) = sides.last().and_then(Side::without_other) {
            sides.push(side);
            continue;
        }
        let (mut points, ended) = on_record(diary)?;
        let mut ledger = Ledger::new(None, (&points, &[]), points.len());
        let mut known = vec![(second, first.value.value)];
        known.extend(
            points
                .iter()
                .map(|point| (point.parameters[1], point.parameters[0])),
        );
        let end = ended.unwrap_or_else(|| {
            let end = loop {
                if points.len() >= limits.points {
                    break End::Points;
                }
                let (here, border) = known[known.len() - 1];
                if sign * (edge - here) <= 0.0 {
                    break End::Range;
                }
                let slope = match known.len().checked_sub(2).map(|before| known[before]) {
                    Some((there, before)) => (border - before) / (here - there),
                    None => 0.0,
                };
                let usual = if known.len() == 1 {
                    FIRST * longest
                } else {
                    longest
                };
                let mut found = None;
                for halving in 0..HALVINGS {
                    let step = usual / f64::from(1_u32 << halving);
                    let next = if step >= sign * (edge - here) {
                        edge
                    } else {
                        here + sign * step
                    };
                    let ahead = slope * (next - here);
                    let width = (WIDTH * ahead.abs()).max(LEAST * border.abs());
                    // Nothing is known yet of how fast it moves.
                    let width = if known.len() == 1 { 1e3 * width } else { width };
                    found = search
                        .near(next, (border + ahead, width))
                        .map(|b| (next, b));
                    if found.is_some() {
                        break;
                    }
                }
                let Some((next, border)) = found else {
                    break End::Lost("no border is found nearby".to_owned());
                };
                if limits.beyond_other(border.value.value).is_some() {
                    break End::Range;
                }
                known.push((next, border.value.value));
                let told = point(&border, next, monitors);
                let broken_off = diary.tell(Told::Orbit(&told)).is_break();
                points.push(told);
                let then = (Then::Points, points.len());
                if ledger.keep((&points, &[]), then, diary).is_break() || broken_off {
                    break End::Interrupted;
                }
            };
            ledger.close((&points, &[]), end, diary)
        });
        sides.push(Side {
            points,
            special: Vec::new(),
            end,
        });
    }
    let branch = joined(sides, point(&first, second, monitors))?;
    Ok(SpecialCurve::of(SpecialKind::ChatterBorder, branch))
}

/// Points of a side that are on record, and how it ended.
fn on_record(diary: &mut Diary<'_>) -> Result<(Vec<Point>, Option<End>), PeriodicError> {
    let Kept { points, then, .. } = Kept::read(diary, None)?;
    if points.iter().any(|point| point.parameters.len() != 2) {
        return Err(damaged());
    }
    match then {
        None | Some(Then::Points) => Ok((points, None)),
        Some(Then::Ended(end)) => Ok((points, Some(end))),
        Some(Then::On(_)) => Err(damaged()),
    }
}
