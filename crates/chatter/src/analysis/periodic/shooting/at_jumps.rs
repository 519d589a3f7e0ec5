//! Corners that happen to share the instant of an impact or a reset, as the switch of a square wave does at which a body is struck: beside the
//! orbit one of them comes first, and there is one derivative only if it is the same in either order.

use super::{Passage, Shooting, Step};
use crate::analysis::continuation::Left;
use crate::analysis::periodic::cycle::rotate::a_turn_later;
use crate::expressions::{Expr, Graph, Side, Symbol};
use crate::flow::leg::{Jump, LegKind};
use crate::flow::{Corner, GuardKind, SAME_DERIVATIVE, Settings};
use crate::numerics::{Matrix, dot};

/// What is no farther apart than so many roundoffs of the time comes at one instant: which is first is rounding.
const ONE_INSTANT: f64 = 64.0 * f64::EPSILON;
/// Two surfaces are always met together if the slopes of their times agree to this part.
const SAME_SLOPES: f64 = 1e-9;

/// The function of a corner, and its derivatives along states.
struct Function {
    corner: Corner,
    value: Expr,
    slopes: Vec<Expr>,
}

struct Functions {
    graph: Graph,
    all: Vec<Function>,
}

/// A mode with the pieces of lookups in it.
pub(super) struct Regime {
    pub mode: usize,
    pub pieces: Vec<i64>,
}

/// A corner that shares the instant of a jump.
struct Met {
    corner: Corner,
    /// Of a lookup the lower of the pieces that meet there.
    low: i64,
    rises: bool,
    /// How much later it is met where the state is displaced.
    slopes: Vec<f64>,
    function: usize,
}

/// What happens at an instant: a jump, or a corner whose function has these derivatives.
enum Happening<'f> {
    Jump(LegKind),
    Corner(&'f Graph, &'f [Expr]),
}

fn is_one(a: &[f64], b: &[f64]) -> bool {
    let mut pairs = a.iter().zip(b);
    pairs.all(|(a, b)| (a - b).abs() <= SAME_SLOPES * a.abs().max(b.abs()))
}

/// Times of a surface of these slopes where the field is this one, later where the state is displaced.
fn later(slopes: &[f64], field: &[f64]) -> Vec<f64> {
    let rate = dot(slopes, field);
    slopes.iter().map(|slope| -slope / rate).collect()
}

/// Displacements that come `late`, by another field from then on.
fn shifted(of: &Matrix<f64>, by: &[f64], late: &[f64]) -> Matrix<f64> {
    let mut shifted = of.clone();
    for (i, by) in by.iter().enumerate() {
        for (entry, late) in shifted.row_mut(i).iter_mut().zip(late) {
            *entry += by * late;
        }
    }
    shifted
}

/// Whether two derivatives of states of these sizes are not the same.
pub(super) fn differ(one: &Matrix<f64>, other: &Matrix<f64>, sizes: &[f64]) -> bool {
    let n = sizes.len();
    let scaled = |of: &Matrix<f64>, i: usize, j: usize| of.row(i)[j] * sizes[j] / sizes[i];
    let places = || (0..n).flat_map(|i| (0..n).map(move |j| (i, j)));
    let largest = places().fold(0.0_f64, |most, (i, j)| most.max(scaled(one, i, j).abs()));
    let off = |(i, j): (usize, usize)| (scaled(one, i, j) - scaled(other, i, j)).abs();
    places().any(|place| off(place) > SAME_DERIVATIVE * largest)
}

impl Shooting<f64> {
    /// What comes at the instant of a jump, a corner or another jump, where the derivative depends on which of both is met first: at a point
    /// that was evaluated last.
    pub(crate) fn order_at_jumps(&self, at: &[f64]) -> Result<Option<GuardKind>, Left> {
        let jumps = |step: &Step| match step.passage {
            Passage::Leg(kind) if kind.jump != Jump::None => Some(kind),
            _ => None,
        };
        let all: Vec<(usize, LegKind)> = (self.steps.iter().enumerate())
            .filter_map(|(index, step)| Some((index, jumps(step)?)))
            .collect();
        let steps = self.current_steps(at);
        let parameters = self.workshop.parameters(self.free(at));
        for &(index, kind) in &all {
            let next = self.after(index);
            if let Some(&(_, other)) = all.iter().find(|(jump, _)| *jump == next)
                && next != index
                && steps[next].duration.abs() <= ONE_INSTANT * self.time_at(&steps[next].start)
                && self.order_of_jumps(&steps, (index, kind), other, &parameters)?
            {
                return Ok(other.ends_at);
            }
        }
        if self.workshop.system.corners().is_empty() {
            return Ok(None);
        }
        let functions = self.functions();
        for (index, kind) in all {
            let met = self.corner_at_jump((&steps, &functions), (index, kind), &parameters)?;
            if let Some(met) = met {
                return Ok(Some(match met {
                    Corner::Surface(index) => GuardKind::Switch(index),
                    Corner::Lookup(index) => GuardKind::Piece(index, Side::Above),
                }));
            }
        }
        Ok(None)
    }

    /// Whether the event at the end of a step comes at the instant of the one before, in whichever order.
    pub(crate) fn shares_instant(&self, at: &[f64], index: usize) -> bool {
        let duration = self.duration_place(index).map_or(0.0, |place| at[place]);
        duration.abs() <= ONE_INSTANT * self.time_at(self.node(at, index))
    }

    /// The time that what shares an instant at a state is told apart by.
    fn time_at(&self, state: &[f64]) -> f64 {
        let clock = self.workshop.model.time;
        self.period()
            .max(clock.map_or(0.0, |place| state[place].abs()))
    }

    /// The regime that a step is followed by.
    pub(super) fn regime_after(
        &self,
        steps: &[Step],
        index: usize,
        parameters: &[f64],
    ) -> Result<Regime, Left> {
        let next = self.after(index);
        let pieces = match next <= index && !steps[next].pieces.is_empty() {
            true => {
                let later = a_turn_later(&self.workshop, parameters, (steps, &self.counts));
                later.map_err(Left::because)?[next].pieces.clone()
            }
            false => steps[next].pieces.clone(),
        };
        Ok(Regime {
            mode: steps[next].mode(),
            pieces,
        })
    }

    /// Whether a jump and the one after it, at the same instant, could come in another order with another derivative. What the one brings about
    /// comes after it, and two names of one surface are one.
    fn order_of_jumps(
        &self,
        steps: &[Step],
        (index, kind): (usize, LegKind),
        other: LegKind,
        parameters: &[f64],
    ) -> Result<bool, Left> {
        let system = &self.workshop.system;
        let next = self.after(index);
        let Some(state) = self.before_jump(&steps[index], kind, parameters) else {
            return Ok(false);
        };
        let a = Regime {
            mode: kind.mode,
            pieces: steps[index].pieces.clone(),
        };
        let due = |guard: Option<GuardKind>| {
            let known = system.with_pieces(parameters, &a.pieces);
            guard.and_then(|guard| system.due((a.mode, guard), &known, &state))
        };
        let (Some(own), Some(others)) = (due(kind.ends_at), due(other.ends_at)) else {
            return Ok(false);
        };
        let comes_with = others.after.abs() > ONE_INSTANT * self.time_at(&state);
        if comes_with || is_one(&own.slopes, &others.slopes) {
            return Ok(false);
        }
        let b = self.regime_after(steps, index, parameters)?;
        let d = self.regime_after(steps, next, parameters)?;
        let mode = system.in_other_order([a.mode, b.mode, d.mode]);
        let Some(mode) = mode.filter(|_| b.pieces == d.pieces) else {
            return Ok(true);
        };
        let c = Regime {
            mode,
            pieces: a.pieces.clone(),
        };
        let both = [&Happening::Jump(kind), &Happening::Jump(other)];
        let matters = self.order_matters_at(both, &state, [&a, &b, &c, &d], parameters);
        Ok(matters != Some(false))
    }

    /// The functions of surfaces, and the arguments of lookups.
    fn functions(&self) -> Functions {
        let system = &self.workshop.system;
        let corners = system.corners();
        let mut graph = system.model().graph.clone();
        let surfaces = (0..corners.surfaces.len()).filter(|&index| !corners.is_disc(index));
        let surfaces = surfaces.map(|index| (Corner::Surface(index), corners.surfaces[index]));
        let lookups = corners.lookups.iter().enumerate();
        let lookups = lookups.map(|(index, of)| (Corner::Lookup(index), of.argument));
        let all = surfaces.chain(lookups).map(|(corner, value)| {
            let by = |state: usize| graph.derivative(value, Symbol::State(state));
            Function {
                corner,
                value,
                slopes: (0..self.workshop.model.states.len()).map(by).collect(),
            }
        });
        let all = all.collect();
        Functions { graph, all }
    }

    /// The corner that shares the instant of a jump and gives another derivative where it comes before that.
    fn corner_at_jump(
        &self,
        (steps, functions): (&[Step], &Functions),
        (index, kind): (usize, LegKind),
        parameters: &[f64],
    ) -> Result<Option<Corner>, Left> {
        let step = &steps[index];
        let image = &self.latest[index].image;
        let before = Regime {
            mode: kind.mode,
            pieces: step.pieces.clone(),
        };
        let here = self.met(functions, &before, (image, parameters));
        if here.is_empty() {
            return Ok(None);
        }
        // Of what the jump takes the state across, or to, it is the jump that says when.
        let Some(state) = self.before_jump(step, kind, parameters) else {
            return Ok(None);
        };
        let own = kind.ends_at.and_then(|own| {
            let known = self.workshop.system.with_pieces(parameters, &before.pieces);
            self.workshop.system.due((kind.mode, own), &known, &state)
        });
        let with_own = |met: &Met| {
            own.as_ref()
                .is_some_and(|own| is_one(&own.slopes, &met.slopes))
        };
        let comes_too = |met: &Met| here.iter().any(|other| other.corner == met.corner);
        let mut met = self.met(functions, &before, (&state, parameters));
        met.retain(|met| comes_too(met) && !with_own(met));
        if met.is_empty() {
            return Ok(None);
        }
        let after = self.regime_after(steps, index, parameters)?;
        while let Some(first) = met.pop() {
            let (mut together, others): (Vec<Met>, Vec<Met>) =
                (met.into_iter()).partition(|other| is_one(&other.slopes, &first.slopes));
            met = others;
            let corner = first.corner;
            let slopes = &functions.all[first.function].slopes;
            let by_corner = Happening::Corner(&functions.graph, slopes);
            let mut all = here.iter();
            if all.any(|here| here.corner == corner && here.rises != first.rises) {
                return Ok(Some(corner));
            }
            together.push(first);
            let [before, after] = [&before, &after]
                .map(|regime| [false, true].map(|crossed| self.across(regime, &together, crossed)));
            let ([Some(a), Some(c)], [Some(b), Some(d)]) = (before, after) else {
                return Ok(Some(corner));
            };
            let regimes = [&a, &b, &c, &d];
            let both = [&Happening::Jump(kind), &by_corner];
            if self.order_matters_at(both, &state, regimes, parameters) != Some(false) {
                return Ok(Some(corner));
            }
        }
        Ok(None)
    }

    /// The corners that are met at a state.
    fn met(
        &self,
        functions: &Functions,
        regime: &Regime,
        (state, parameters): (&[f64], &[f64]),
    ) -> Vec<Met> {
        let system = &self.workshop.system;
        let graph = &functions.graph;
        let known = system.with_pieces(parameters, &regime.pieces);
        let time = self.time_at(state);
        let Some(field) = system.field_of(regime.mode, &known, state) else {
            return Vec::new();
        };
        let at = |expr: &Expr| graph.evaluate(*expr, state, &known);
        let is_idle = |corner: Corner| match corner {
            Corner::Surface(index) => system.rubs_nowhere(regime.mode, index),
            Corner::Lookup(_) => false,
        };
        let met = functions
            .all
            .iter()
            .enumerate()
            .filter(|(_, function)| !is_idle(function.corner))
            .filter_map(|(number, function)| {
                let slopes: Vec<f64> = function.slopes.iter().map(at).collect();
                let rate = dot(&slopes, &field);
                let near = rate.abs() * ONE_INSTANT * time;
                let value = at(&function.value);
                let low = match function.corner {
                    Corner::Surface(_) => (value.abs() <= near).then_some(0)?,
                    Corner::Lookup(index) => {
                        let piece = regime.pieces[index];
                        let slots = system.corners().slots_of::<f64>(graph, index, piece)?;
                        match [1, 0].map(|end| (value - slots[end]).abs() <= near) {
                            [true, _] => piece,
                            [false, true] => piece - 1,
                            _ => return None,
                        }
                    }
                };
                (rate != 0.0 && rate.is_finite()).then(|| Met {
                    corner: function.corner,
                    low,
                    rises: rate > 0.0,
                    slopes: later(&slopes, &field),
                    function: number,
                })
            });
        met.collect()
    }

    /// Where a leg comes to, before the jump at its end.
    fn before_jump(&self, step: &Step, kind: LegKind, parameters: &[f64]) -> Option<Vec<f64>> {
        let plain = LegKind {
            jump: Jump::None,
            ..kind
        };
        let leg = self.workshop.leg(plain)?;
        let known = self.parameters_of(parameters, step);
        let flyer = &mut leg.flyer(&Settings::default());
        let landing = leg.fly(flyer, &known, &step.start, step.duration).ok()?;
        Some(landing.image)
    }

    /// A regime before corners are crossed, or after it.
    fn across(&self, regime: &Regime, met: &[Met], crossed: bool) -> Option<Regime> {
        let system = &self.workshop.system;
        let (grip, mut sides, _) = system.origin_of(regime.mode)?;
        let mut pieces = regime.pieces.clone();
        for corner in met {
            let is_above = corner.rises == crossed;
            match corner.corner {
                Corner::Surface(index) if is_above => sides = sides.with(index, Side::Above),
                Corner::Surface(index) => sides = sides.with(index, Side::Below),
                Corner::Lookup(index) => pieces[index] = corner.low + i64::from(is_above),
            }
        }
        let mode = system.meet(grip, sides);
        system.program(mode).map(|_| Regime { mode, pieces })
    }

    /// Whether two happenings of one instant, met at a state, lead elsewhere or have another derivative in the other order: in the regimes before
    /// both, after the first, after the second and after both. None where that cannot be told.
    fn order_matters_at(
        &self,
        [first, second]: [&Happening<'_>; 2],
        state: &[f64],
        [a, b, c, d]: [&Regime; 4],
        parameters: &[f64],
    ) -> Option<bool> {
        let one = self.one_after_the_other([(first, a), (second, b)], d, (state, parameters))?;
        let other = self.one_after_the_other([(second, a), (first, c)], d, (state, parameters))?;
        let sizes = self.state_sizes();
        let mut apart = one.0.iter().zip(&other.0).zip(&sizes);
        Some(
            differ(&one.1, &other.1, &sizes)
                || apart.any(|((a, b), size)| (a - b).abs() > SAME_DERIVATIVE * size),
        )
    }

    /// Where happenings of one instant lead, each in its regime, and the derivative of the state at a given time after both.
    fn one_after_the_other(
        &self,
        order: [(&Happening<'_>, &Regime); 2],
        last: &Regime,
        (state, parameters): (&[f64], &[f64]),
    ) -> Option<(Vec<f64>, Matrix<f64>)> {
        let system = &self.workshop.system;
        let known = |regime: &Regime| system.with_pieces(parameters, &regime.pieces);
        let field = |regime: &Regime, at: &[f64]| system.field_of(regime.mode, &known(regime), at);
        let mut derivative = Matrix::identity(state.len());
        let mut state = state.to_vec();
        for (place, (happening, regime)) in order.into_iter().enumerate() {
            let next = order.get(place + 1).map_or(last, |(_, next)| next);
            let before = field(regime, &state)?;
            let (image, map, late) = match *happening {
                Happening::Jump(kind) => {
                    let kind = LegKind {
                        mode: regime.mode,
                        ..kind
                    };
                    let leg = self.workshop.leg(kind)?;
                    let flyer = &mut leg.flyer(&Settings::default());
                    let landing = leg.at_once(flyer, &known(regime), &state);
                    let mut map = Matrix::identity(state.len());
                    for i in 0..state.len() {
                        let row = &landing.image_slopes.row(i)[..state.len()];
                        map.row_mut(i).copy_from_slice(row);
                    }
                    let due = system.due((kind.mode, kind.ends_at?), &known(regime), &state)?;
                    (landing.image, map, due.slopes)
                }
                Happening::Corner(graph, slopes) => {
                    let known = known(regime);
                    let at = |&slope: &Expr| graph.evaluate(slope, &state, &known);
                    let slopes: Vec<f64> = slopes.iter().map(at).collect();
                    let map = Matrix::identity(state.len());
                    (state.clone(), map, later(&slopes, &before))
                }
            };
            let late = derivative.apply_transposed(&late);
            let after: Vec<f64> = field(next, &image)?.iter().map(|f| -f).collect();
            derivative = shifted(
                &map.times(&shifted(&derivative, &before, &late)),
                &after,
                &late,
            );
            state = image;
        }
        Some((state, derivative))
    }
}
