//! Corners that happen to share the instant of an impact or a reset, as the switch of a square wave does at which a body is struck: beside the
//! orbit one of them comes first, and there is one derivative only if it is the same in either order.

use super::{Passage, Shooting, Step};
use crate::analysis::continuation::Left;
use crate::analysis::periodic::cycle::rotate::a_turn_later;
use crate::expressions::{Expr, Graph, Side, Symbol};
use crate::flow::leg::{Jump, LegKind};
use crate::flow::{Corner, SAME_DERIVATIVE, Settings};
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
struct Regime {
    mode: usize,
    pieces: Vec<i64>,
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

fn less(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

impl Shooting<f64> {
    /// The corner that comes at the instant of a jump, where the derivative depends on which of both is met first: at a point that was
    /// evaluated last.
    pub(crate) fn corner_at_jump(&self, at: &[f64]) -> Result<Option<Corner>, Left> {
        let jumps = |step: &Step| match step.passage {
            Passage::Leg(kind) if kind.jump != Jump::None => Some(kind),
            _ => None,
        };
        let all: Vec<(usize, LegKind)> = (self.steps.iter().enumerate())
            .filter_map(|(index, step)| Some((index, jumps(step)?)))
            .collect();
        if all.is_empty() || self.workshop.system.corners().is_empty() {
            return Ok(None);
        }
        let functions = self.functions();
        let steps = self.current_steps(at);
        let parameters = self.workshop.parameters(self.free(at));
        for (index, kind) in all {
            if let Some(met) =
                self.order_at_jump((&steps, &functions), (index, kind), &parameters)?
            {
                return Ok(Some(met));
            }
        }
        Ok(None)
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
    fn order_at_jump(
        &self,
        (steps, functions): (&[Step], &Functions),
        (index, kind): (usize, LegKind),
        parameters: &[f64],
    ) -> Result<Option<Corner>, Left> {
        let (step, next) = (&steps[index], self.after(index));
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
        let pieces = match next <= index && !step.pieces.is_empty() {
            true => {
                let later = a_turn_later(&self.workshop, parameters, (steps, &self.counts));
                later.map_err(Left::because)?[next].pieces.clone()
            }
            false => steps[next].pieces.clone(),
        };
        let after = Regime {
            mode: steps[next].mode(),
            pieces,
        };
        while let Some(first) = met.pop() {
            let (mut together, others): (Vec<Met>, Vec<Met>) =
                (met.into_iter()).partition(|other| is_one(&other.slopes, &first.slopes));
            met = others;
            let corner = first.corner;
            let slopes = (&functions.graph, &*functions.all[first.function].slopes);
            together.push(first);
            let [before, after] = [&before, &after]
                .map(|regime| [false, true].map(|crossed| self.across(regime, &together, crossed)));
            let ([Some(a), Some(c)], [Some(b), Some(d)]) = (before, after) else {
                return Ok(Some(corner));
            };
            let regimes = [&a, &b, &c, &d];
            if self.order_matters_at(kind, (&state, slopes), regimes, parameters) != Some(false) {
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
        let clock = self
            .workshop
            .model
            .time
            .map_or(0.0, |place| state[place].abs());
        let time = self.period().max(clock);
        let Some(field) = system.field_of(regime.mode, &known, state) else {
            return Vec::new();
        };
        let at = |expr: &Expr| graph.evaluate(*expr, state, &known);
        let met = functions
            .all
            .iter()
            .enumerate()
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

    /// Whether a jump and a corner of these slopes, met at a state, lead elsewhere or have another derivative in the other order: between
    /// both regimes (before both, after the jump, after the corner, after both). None where that cannot be told.
    fn order_matters_at(
        &self,
        kind: LegKind,
        (state, (graph, slopes)): (&[f64], (&Graph, &[Expr])),
        [a, b, c, d]: [&Regime; 4],
        parameters: &[f64],
    ) -> Option<bool> {
        let system = &self.workshop.system;
        let n = state.len();
        let field = |regime: &Regime, at: &[f64]| {
            let known = system.with_pieces(parameters, &regime.pieces);
            system.field_of(regime.mode, &known, at)
        };
        // The jump by itself, and how much later it comes where the state is displaced.
        let jump = |regime: &Regime| {
            let known = system.with_pieces(parameters, &regime.pieces);
            let leg = self.workshop.leg(LegKind {
                mode: regime.mode,
                ..kind
            })?;
            let landing = leg.at_once(&mut leg.flyer(&Settings::default()), &known, state);
            let mut derivative = Matrix::identity(n);
            for i in 0..n {
                let row = &landing.image_slopes.row(i)[..n];
                derivative.row_mut(i).copy_from_slice(row);
            }
            let late = system
                .due((regime.mode, kind.ends_at?), &known, state)?
                .slopes;
            Some((landing.image, derivative, late))
        };
        let by_corner = |regime: &Regime, at: &[f64]| -> Vec<f64> {
            let known = system.with_pieces(parameters, &regime.pieces);
            slopes
                .iter()
                .map(|&slope| graph.evaluate(slope, at, &known))
                .collect()
        };
        let identity = Matrix::identity(n);
        let (image, first, late) = jump(a)?;
        let (fa, fb, fc, fd) = (
            field(a, state)?,
            field(b, &image)?,
            field(c, state)?,
            field(d, &image)?,
        );
        let own = by_corner(b, &image);
        if dot(&own, &fb) * dot(&by_corner(a, state), &fa) <= 0.0 {
            return Some(true);
        }
        // The jump, then the corner.
        let jumped = shifted(
            &first.times(&shifted(&identity, &fa, &late)),
            &fb,
            &negative(&late),
        );
        let corner_late = jumped.apply_transposed(&later(&own, &fb));
        let one = shifted(&jumped, &less(&fb, &fd), &corner_late);
        // The corner, then the jump.
        let corner_late = later(&by_corner(a, state), &fa);
        let crossed = shifted(&identity, &less(&fa, &fc), &corner_late);
        let (other_image, second, late) = jump(c)?;
        let late = crossed.apply_transposed(&late);
        let other = shifted(
            &second.times(&shifted(&crossed, &fc, &late)),
            &fd,
            &negative(&late),
        );
        let entries =
            |of: &Matrix<f64>| -> Vec<f64> { (0..n).flat_map(|i| of.row(i).to_vec()).collect() };
        let (one, other) = (entries(&one), entries(&other));
        let sizes = self.state_sizes();
        let scaled = |(place, entry): (usize, &f64)| entry * sizes[place % n] / sizes[place / n];
        let largest = one
            .iter()
            .enumerate()
            .map(scaled)
            .fold(0.0_f64, |most, x| most.max(x.abs()));
        let off = less(&one, &other);
        let off = off
            .iter()
            .enumerate()
            .map(scaled)
            .fold(0.0_f64, |most, x| most.max(x.abs()));
        let mut apart = less(&image, &other_image).into_iter().zip(&sizes);
        Some(
            off > SAME_DERIVATIVE * largest
                || apart.any(|(apart, size)| apart.abs() > SAME_DERIVATIVE * size),
        )
    }
}

fn negative(of: &[f64]) -> Vec<f64> {
    of.iter().map(|x| -x).collect()
}
