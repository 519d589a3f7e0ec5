//! Curves of chatter borders: each border orbit is looked for on a line across the curve, as far on as a step, near where the points
//! before it say that it lies. On one side of a border the orbit has no equations, so there is no system to follow by its arc length.

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
use crate::numerics::dot;

/// Parts of the interval that a border is looked for in.
const SAMPLES: usize = 6;
/// That interval, in steps to either side; and the least, in longest steps.
const WIDTH: f64 = 0.5;
const LEAST: f64 = 1e-6;
/// A border this near to where it was expected, in steps, is the curve's; farther off it may be another one's, and the step is halved.
const NEAR: f64 = 0.1;
/// Steps shorter than this part of the longest are not halved for that: the curve may have a corner.
const SHORT: f64 = 2e-3;
/// Steps are halved so often, and grow by this factor.
const HALVINGS: u32 = 12;
const GROWTH: f64 = 4.0;
/// The first step along the curve, in parts of the longest, and the interval that a border is looked for in there: nothing is known yet
/// of how fast it moves.
const FIRST: f64 = 0.01;
const ANYWHERE: f64 = 20.0;
/// The most that a curve is expected to turn from step to step, in radians; and what it turns by where a step that is no longer than the one before goes to
/// the same curve. Elsewhere a border is asked for halfway, too.
const TURN: f64 = 0.5;
const STRAIGHT: f64 = 0.05;
/// A curve that passes where it began by no more than this part of a step, heading as it did, by the cosine, has come back.
const BACK: f64 = 0.1;
const AS_BEFORE: f64 = 0.9;

/// Values of both parameters.
type Place = [f64; 2];

/// The same in longest steps, from some origin.
type Scaled = [f64; 2];

fn plus(a: Place, factor: f64, b: Place) -> Place {
    [a[0] + factor * b[0], a[1] + factor * b[1]]
}

fn norm([a, b]: Scaled) -> f64 {
    a.hypot(b)
}

fn cross([a, b]: Scaled, [c, d]: Scaled) -> f64 {
    a * d - b * c
}

struct Search<'m> {
    model: &'m Model,
    free: [usize; 2],
    specs: [BorderSpec; 2],
    /// The longest step in each parameter.
    longest: [f64; 2],
    /// Within which the curve is followed.
    ranges: [(f64, f64); 2],
}

/// A border on the curve, and the values of the parameters.
type Found = (Place, Border<f64>);

impl Search<'_> {
    fn scaled(&self, from: Place, to: Place) -> Scaled {
        [0, 1].map(|k| (to[k] - from[k]) / self.longest[k])
    }

    /// So far on from a place in a direction.
    fn moved(&self, place: Place, step: f64, ahead: Scaled) -> Place {
        plus(place, step, [0, 1].map(|k| self.longest[k] * ahead[k]))
    }

    /// The border nearest to a place on a line through it, no farther from it than so much: one parameter is varied, the other
    /// follows it.
    fn on_line(&self, through: Place, along: Scaled, width: f64) -> Option<Found> {
        let over = usize::from(along[1].abs() > along[0].abs());
        let held = 1 - over;
        let names = self.free.map(|index| &self.model.parameters[index].name);
        let slope = along[held] * self.longest[held] / (along[over] * self.longest[over]);
        let mut model = self.model.clone();
        let number = |value: f64| format!("{value:?}");
        model
            .set_parameter(names[over], &number(through[over]))
            .ok()?;
        let line = if slope == 0.0 {
            number(through[held])
        } else {
            let [at, from] = [held, over].map(|k| through[k]);
            format!("({at:?}) + ({slope:?})*({} - ({from:?}))", names[over])
        };
        model.set_parameter(names[held], &line).ok()?;
        let reach = width * self.longest[over] * along[over].abs() / norm(along);
        let value = through[over];
        let found = borders_in::<f64>(&model, &self.specs[over], value - reach, value + reach);
        let border = found.ok()?.nearest(value)?;
        let mut place = through;
        place[over] = border.value.value;
        place[held] += slope * (border.value.value - value);
        Some((place, border))
    }

    /// The edge that lies nearest between a place within the ranges and one beyond: the parameter, its value there, and how far it is, in
    /// parts of the way.
    fn edge(&self, from: Place, to: Place) -> Option<(usize, f64, f64)> {
        let edges = [0, 1].map(|k| {
            let (low, high) = self.ranges[k];
            let edge = to[k].clamp(low, high);
            (edge != to[k]).then(|| (k, edge, (edge - from[k]) / (to[k] - from[k])))
        });
        let passed = edges.into_iter().flatten();
        passed.min_by(|a, b| a.2.total_cmp(&b.2))
    }

    /// The border after one place, on a line through another where it is expected, if it lies so near to there that it is the curve's.
    fn after(&self, here: Place, expected: Place, along: Scaled) -> Option<Found> {
        let step = norm(self.scaled(here, expected));
        let found = self.on_line(expected, along, (WIDTH * step).max(LEAST))?;
        let off = norm(self.scaled(expected, found.0));
        (off <= NEAR * step || step <= SHORT).then_some(found)
    }

    /// The border at the edge that the way from a place on the curve to another one passes.
    fn at_edge(&self, here: Place, to: Place) -> Option<Found> {
        let (held, value, part) = self.edge(here, to)?;
        let mut through = plus(here, part, plus(to, -1.0, here));
        through[held] = value;
        let mut along = [0.0; 2];
        along[1 - held] = 1.0;
        let (place, border) = self.after(here, through, along)?;
        let is_within = self.edge(here, place).is_none();
        is_within.then_some((place, border))
    }

    /// A place beside another on the curve, a little farther on in the second parameter, or in the first one where the curve turns.
    fn beside(&self, begin: Place) -> Option<Place> {
        [1, 0].into_iter().find_map(|held| {
            let [mut ahead, mut across] = [[0.0; 2]; 2];
            (ahead[held], across[1 - held]) = (1.0, 1.0);
            let steps = (0..HALVINGS).map(|halving| FIRST / f64::from(1_u32 << halving));
            steps.into_iter().find_map(|step| {
                let on = [step, -step].map(|by| self.moved(begin, by, ahead));
                let inside = on.into_iter().find(|&on| self.edge(begin, on).is_none())?;
                let found = self.on_line(inside, across, ANYWHERE * step);
                found.map(|(place, _)| place)
            })
        })
    }

    /// The direction in which the curve goes on from the latest of three places, or two, and how fast that turns.
    fn heading(&self, known: &[Place]) -> Option<(Scaled, f64)> {
        let [.., before, here] = known else {
            return None;
        };
        let latest = self.scaled(*before, *here);
        let length = norm(latest);
        let turning = match known {
            [.., first, _, _] => {
                let earlier = self.scaled(*first, *before);
                let turned = cross(earlier, latest).atan2(dot(&earlier, &latest));
                turned / (0.5 * (norm(earlier) + length))
            }
            _ => 0.0,
        };
        (length > 0.0).then(|| (latest.map(|part| part / length), turning))
    }

    /// The next border along the curve, at most a longest step on.
    fn next(&self, known: &[Place]) -> Option<Found> {
        let here = *known.last()?;
        let (heading, turning) = self.heading(known)?;
        let latest = norm(self.scaled(known[known.len() - 2], here));
        let usual = (GROWTH * latest).min(1.0);
        // Where the curve is expected so far on, and across it there.
        let expected = |step: f64| {
            let turned = (0.5 * turning * (latest + step)).clamp(-TURN, TURN);
            let (sin, cos) = (libm::sin(turned), libm::cos(turned));
            let ahead = [
                cos * heading[0] - sin * heading[1],
                sin * heading[0] + cos * heading[1],
            ];
            let place = self.moved(here, step, ahead);
            (place, [-ahead[1], ahead[0]], turned)
        };
        (0..HALVINGS).find_map(|halving| {
            let step = usual / f64::from(1_u32 << halving);
            let (place, across, turned) = expected(step);
            if self.edge(here, place).is_some() {
                return self.at_edge(here, place);
            }
            let (place, border) = self.after(here, place, across)?;
            if self.edge(here, place).is_some() {
                return self.at_edge(here, place);
            }
            let (halfway, across, _) = expected(0.5 * step);
            let is_sure = step <= latest && turned.abs() <= STRAIGHT;
            let is_on_it = is_sure || self.after(here, halfway, across).is_some();
            is_on_it.then_some((place, border))
        })
    }

    /// Whether nothing of the curve lies within the ranges beyond the latest place.
    fn has_ended(&self, known: &[Place]) -> bool {
        let [.., before, here] = known else {
            return false;
        };
        [0, 1].into_iter().any(|k| {
            let ((low, high), forward) = (self.ranges[k], here[k] - before[k]);
            (forward < 0.0 && here[k] <= low) || (forward > 0.0 && here[k] >= high)
        })
    }

    /// Whether a step from the latest place to another passes where the curve began.
    fn comes_back(&self, known: &[Place], to: Place) -> bool {
        let [before, begin, _, _, .., here] = known else {
            return false;
        };
        let [step, left] = [to, *begin].map(|to| self.scaled(*here, to));
        let set_out = self.scaled(*before, *begin);
        let length = norm(step);
        let headed = dot(&step, &set_out) / (length * norm(set_out));
        let along = dot(&step, &left) / length;
        let off = cross(step, left) / length;
        headed > AS_BEFORE && (0.0..=length).contains(&along) && off.abs() <= BACK * length
    }
}

fn point(place: Place, border: &Border<f64>, monitors: usize) -> Point {
    Point {
        parameters: place.to_vec(),
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

/// Follows the border nearest to the model's values to both sides, first to where the second parameter falls.
pub(crate) fn follow(
    model: &Model,
    (free, monitors): ([usize; 2], usize),
    limits: &Limits,
    diary: &mut Diary<'_>,
) -> Result<SpecialCurve, PeriodicError> {
    let parameters = model.parameter_values::<f64>(&[]);
    let [value, second] = free.map(|index| parameters[index]);
    let mut specs = free.map(|index| BorderSpec::new(&model.parameters[index].name));
    let first = border_near::<f64>(model, &specs[0], value).map_err(failed)?;
    specs.iter_mut().for_each(|spec| spec.samples = SAMPLES);
    let begin = [first.value.value, second];
    let span = limits.range.1 - limits.range.0;
    let span_of_first = match limits.other {
        Some((low, high)) => high - low,
        None if begin[0] == 0.0 => span,
        None => begin[0].abs(),
    };
    let search = Search {
        model,
        free,
        specs,
        longest: [span_of_first, span].map(|span| limits.longest_step * span),
        ranges: [
            limits.other.unwrap_or((f64::NEG_INFINITY, f64::INFINITY)),
            limits.range,
        ],
    };
    let beside = search.beside(begin).map(|beside| {
        let to = plus(beside, -1.0, begin);
        if to[1] < 0.0 {
            to.map(|part| -part)
        } else {
            to
        }
    });
    let mut sides: Vec<Side> = Vec::new();
    for sign in [-1.0, 1.0] {
        if let Some(side) = sides.last().and_then(Side::without_other) {
            sides.push(side);
            continue;
        }
        let (mut points, ended) = on_record(diary)?;
        let mut ledger = Ledger::new(None, (&points, &[]), points.len());
        let before = beside.map(|to| plus(begin, -sign, to));
        let told = points
            .iter()
            .map(|point| [point.parameters[0], point.parameters[1]]);
        let mut known: Vec<Place> = before.into_iter().chain([begin]).chain(told).collect();
        let end = ended.unwrap_or_else(|| {
            let end = loop {
                if points.len() >= limits.points {
                    break End::Points;
                }
                if !points.is_empty() && known.last() == Some(&begin) {
                    break End::Closed;
                }
                if search.has_ended(&known) {
                    break End::Range;
                }
                let Some((mut place, mut border)) = search.next(&known) else {
                    break End::Lost("no border is found nearby".to_owned());
                };
                if search.comes_back(&known, place) {
                    (place, border) = (begin, first.clone());
                }
                known.push(place);
                let told = point(place, &border, monitors);
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
    let branch = joined(sides, point(begin, &first, monitors))?;
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
