//! Where what a root is taken of comes to zero flat, its rate with it: flow through an orifice that turns round.
//!
//! Let b' = a + h r on the side where r is the root of |b|. In the time s of dt = 2 r ds this is r' = a + h r, a' = 2 alpha r, linear at
//! a = r = 0, with l^2 - h l - 2 alpha = 0: where the root draws back, h < 0, and a falls, alpha < 0, a node for all h^2 > -8 alpha.
//! What is stiff against how fast it is driven comes to it, and reaches it in a finite time; on the other side one motion leads off it,
//! that of the saddle there. Where a stays zero, so does b: no other motion begins where the root draws back.
//!
//! Derivatives of b, other than the first, are those of the root here. What the motion without it does says to which side it goes on.

use crate::expressions::{Expansion, Operand, Side, Symbol};
use crate::flow::error::FlowError;
use crate::flow::modes::guard::GuardKind;
use crate::flow::modes::program::Program;
use crate::flow::step::resolve::Resolution;
use crate::flow::step::{ORDER_CLASSES, Workspace};
use crate::flow::system::System;
use crate::flow::touch::{after_roots, series_after_roots};
use crate::flow::touching::Touching;
use crate::flow::trajectory::Trajectory;
use crate::flow::trajectory::rest::undecided::BALANCE_LEVELS;
use crate::numerics::{Real, WithTerms, dot, two_sum};
use core::cmp::Ordering;

/// What goes to zero as t^m has b b'' / 2 b'^2 = (m - 1)/2m: nothing for m = 1, a quarter for m = 2.
const FLAT: f64 = 0.125;
/// That of the highest m which counts, 1 - (m - 1)/m.
const LEAST_PART: f64 = 0.25;

/// A displacement that is small against the terms of what a root is taken of, and not against what rounding leaves of its rate.
const BESIDE: f64 = 1e-8;

impl<R: Real> Trajectory<R> {
    /// Where a step cannot be settled, or is shorter than the time is known, since what a root is taken of comes to zero flat: that
    /// surface is met, and the state put onto it.
    pub(in crate::flow::trajectory) fn come_to_root(
        &self,
        system: &System,
        work: &mut Workspace<R>,
        (program, singular): (&Program, Option<usize>),
    ) -> Option<Resolution> {
        let class = self.load(work);
        work.expand_only(program, class);
        let untold = singular.map(|which| program.tape.singular[which].slot);
        let near = (program.guards.iter().enumerate()).find_map(|(index, guard)| {
            let GuardKind::Switch(surface) = guard.kind else {
                return None;
            };
            let slot = root_of(program, guard.kind)?;
            let is_told = work.is_told(program, slot);
            let series = work.expansion.series(slot);
            let after = match untold == Some(slot) && series[0] == R::ZERO {
                true => R::ZERO,
                false => comes_flat(series, is_told)?,
            };
            let is_near = after * work.tau <= self.negligible() || untold == Some(slot);
            (is_near && after * work.tau <= work.horizon).then_some((index, surface, after))
        });
        let (index, surface, after) = near?;
        if system.corners().is_disc(surface) {
            return Some(self.come_to_zero(system, work, (index, after)));
        }
        // There series end, and say nothing beyond their first terms.
        work.scaled_step = R::ZERO;
        work.event = R::splat(index as f64);
        work.travel();
        if after > R::ZERO {
            let leading = |slot: usize| {
                let series = work.expansion.series(slot);
                series[2].mul_add(after, series[1]) * after
            };
            let by: Vec<R> = (0..work.state.len()).map(leading).collect();
            for ((x, low), by) in work.state.iter_mut().zip(&mut work.low).zip(by) {
                (*x, *low) = two_sum(*x, *low + by);
            }
            work.step = after * work.tau;
        }
        let (value, gradient) =
            self.surface_with_gradient(system, surface, (&work.state, &work.low))?;
        let square = dot(&gradient, &gradient);
        if square == R::ZERO {
            return None;
        }
        for ((x, low), &g) in work.state.iter_mut().zip(&mut work.low).zip(&gradient) {
            (*x, *low) = two_sum(*x, *low - g * (value / square));
        }
        // Whatever is displaced comes to it as well.
        for column in work.state[self.coordinates..].chunks_mut(self.coordinates) {
            let off = dot(&gradient, column) / square;
            (column.iter_mut().zip(&gradient)).for_each(|(x, &g)| *x -= g * off);
        }
        Some(Resolution {
            touched: None,
            shortened: true,
            jumped: false,
        })
    }

    /// The function of a surface, as it is on the sides of the present mode, and its gradient, at a state.
    pub(in crate::flow::trajectory) fn surface_with_gradient(
        &self,
        system: &System,
        surface: usize,
        (state, low): (&[R], &[R]),
    ) -> Option<(R, Vec<R>)> {
        let (_, _, on_sides) = system.origin_of(self.mode)?;
        let mut graph = on_sides.mechanics.graph.clone();
        let expr = on_sides.surfaces[surface];
        let states: Vec<Symbol> = (0..self.coordinates).map(Symbol::State).collect();
        let mut exprs = graph.gradient(expr, &states);
        exprs.push(expr);
        let mut values = graph.evaluate_all(&exprs, &state[..self.coordinates], &self.parameters);
        let plain = values.pop()?;
        // What the remainders of the state add to it.
        let value = plain + dot(&values, &low[..self.coordinates]);
        Some((value, values))
    }

    /// How a guard that is what a root is taken of begins to move along the motion without roots that vanish here: and by
    /// which of its derivatives. None for other guards.
    pub(in crate::flow::trajectory) fn moves_off_root(
        &self,
        system: &System,
        kind: GuardKind,
    ) -> Result<Option<(Ordering, u8)>, FlowError> {
        let program = self.program(system)?;
        let (Some(slot), Some(constants)) = (root_of(program, kind), &self.constants[self.mode])
        else {
            return Ok(None);
        };
        let unit = self.reach[ORDER_CLASSES - 1];
        let unit = unit.max(self.longest_step).max(R::splat(f64::MIN_POSITIVE));
        let start = (&self.state[..], &self.low[..]);
        let tape = &program.tape;
        let Some(series) = series_after_roots(tape, &constants.tape, start, (slot, unit)) else {
            return Ok(None);
        };
        if !series.iter().all(|c| c.value.is_finite()) {
            return Ok(None);
        }
        let instant = match self.met {
            Some(_) => self.instant() / unit,
            None => R::ZERO,
        };
        let least = series[0].level() * R::splat(BALANCE_LEVELS);
        let is_clear = |k: usize, c: &WithTerms<R>| {
            let next = series.get(k + 1).map_or(R::ZERO, |next| next.value);
            let later = next.abs() * R::splat((k + 1) as f64) * instant;
            // What turns back before it can be told from zero has not begun.
            let turn = c.value / -next;
            let rises = (0..k).fold(c.value.abs(), |rises, _| rises * turn);
            let turns = turn > R::ZERO && rises <= least;
            !turns && c.value.abs() > (c.level() * R::splat(BALANCE_LEVELS)).max(later)
        };
        let moving = (series.iter().enumerate().skip(1)).find(|&(k, c)| is_clear(k, c));
        let Some((order, moving)) = moving else {
            return Ok(Some((Ordering::Equal, 0)));
        };
        let order = order.min(usize::from(Touching::BALANCED) - 1) as u8;
        Ok(Some(match moving.value > R::ZERO {
            true => (Ordering::Greater, order),
            false => (Ordering::Less, order),
        }))
    }

    /// Whether motion along zero of what a guard says is the only one: its root draws it back as soon as it has left that, or moves
    /// nothing, as in an orifice that is shut.
    pub(in crate::flow::trajectory) fn keeps_to_zero(
        &self,
        system: &System,
        kind: GuardKind,
    ) -> Result<bool, FlowError> {
        let program = self.program(system)?;
        let (Some(slot), Some(constants), GuardKind::Switch(surface)) =
            (root_of(program, kind), &self.constants[self.mode], kind)
        else {
            return Ok(false);
        };
        let Some((_, gradient)) =
            self.surface_with_gradient(system, surface, (&self.state, &self.low))
        else {
            return Ok(false);
        };
        let square = dot(&gradient, &gradient);
        let terms = (gradient.iter().zip(&self.state)).map(|(&g, &x)| (g * x).abs());
        let terms = terms.fold(R::ZERO, R::max);
        let scale = if terms > R::ZERO { terms } else { R::ONE };
        let side = R::splat(if self.regime.get(surface) == Side::Below {
            -1.0
        } else {
            1.0
        });
        let Some(without) = after_roots(&program.tape, slot, &constants.tape) else {
            return Ok(false);
        };
        let rates = |tape, (state, low): (&[R], &[R])| {
            let mut expansion = Expansion::new(&[tape]);
            expansion.run(tape, &constants.tape, state, low, R::ONE, 1);
            expansion
        };
        // Now, or a moment before or after: what the root is multiplied by may begin or end here, as the opening of a valve does.
        let unit = (self.reach.iter()).fold(self.longest_step, |most, &reach| most.max(reach));
        let moment = unit * R::splat(R::ROUNDOFF).sqrt();
        let still = rates(&without, (&self.state, &self.low));
        let (mut draws, mut moves) = (false, false);
        for time in [R::ZERO, moment, -moment] {
            let (mut state, mut low) = (self.state.clone(), self.low.clone());
            for (i, (&g, (x, low))) in (gradient.iter())
                .zip(state.iter_mut().zip(&mut low))
                .enumerate()
            {
                let by = g * side * scale * R::splat(BESIDE) / square;
                let rate = still.series(i)[1];
                let drift = if rate.is_finite() {
                    rate * time
                } else {
                    R::ZERO
                };
                (*x, *low) = two_sum(*x, *low + by + drift);
            }
            let [own, plain] = [&program.tape, &without].map(|tape| rates(tape, (&state, &low)));
            let differs = |slot: usize| own.series(slot)[1] != plain.series(slot)[1];
            draws = draws || own.series(slot)[1] < plain.series(slot)[1];
            moves = moves || differs(slot) || (0..self.state.len()).any(differs);
        }
        Ok(draws || !moves)
    }
}

/// When a series that falls flat to zero is there, as t^m does after m times what its rate says. Where it cannot be told from zero, its
/// rate being no larger than what comes after, it is.
fn comes_flat<R: Real>(series: &[R], is_told: bool) -> Option<R> {
    let [value, rate, bend] = *series.first_chunk()?;
    let part = (value / rate) * (bend / rate);
    if !is_told && part.abs() > R::splat(FLAT) {
        return Some(R::ZERO);
    }
    let is_flat = value >= R::ZERO && rate < R::ZERO && part > R::splat(FLAT);
    let order = R::ONE / (R::ONE - (part + part)).max(R::splat(LEAST_PART));
    is_flat.then(|| value / -rate * order)
}

/// The series that vanishes where a guard does, if a root is taken of it in this mode.
pub(in crate::flow::trajectory) fn root_of(program: &Program, kind: GuardKind) -> Option<usize> {
    let own = program.guards.iter().find(|guard| guard.kind == kind)?;
    match own.series {
        Operand::Series(slot) if program.tape.takes_root_of(own.series) => Some(slot),
        _ => None,
    }
}
