//! Steps from where what a root or a power is taken of vanishes: onto a Hertzian contact, into a flow that the root of a pressure
//! drives.
//!
//! No series in time begins there, but the motion does (docs/piecewise.md). Without the root it is smooth, x(t); along it the root adds
//! g(t) = c t^q (1 + O(t)) to the field, q > -1. After a short time d the state is
//!
//! ```text
//! x(d) + d g(d)/(q + 1)        q = log2(g(d)/g(d/2))
//! ```
//!
//! but for a part of what is added that is as small as d is against the motion's own time, and as rounding is against the base at d: both
//! are least where d is the root of rounding. Where the root adds much in that time, g is asked again on the state so moved, and what is
//! new of it added likewise. From there on series reach, at first not far.

use super::Trajectory;
use crate::expressions::{Negligible, Operand};
use crate::flow::guard::Guard;
use crate::flow::program::Program;
use crate::flow::resolve::{Resolution, expand_within_reach, resolve};
use crate::flow::step::{NO_EVENT, Workspace};
use crate::flow::system::System;
use crate::numerics::polynomial::{horner, magnitude};
use crate::numerics::roots::{Crossing, first_root};
use crate::numerics::{Real, two_sum};

/// The base has to be so many times as large after the step as it is before, and as its rounding.
const GROWS: f64 = 1e3;
/// The step is lengthened until it is, by this factor, so many times.
const LONGER: f64 = 8.0;
const LENGTHENED: usize = 6;
/// What a power adds may grow with any exponent above -1; this far above it its integral is known.
const LEAST_EXPONENT: f64 = -0.99;
/// What a force adds to a rate has moved a place in the next round, and changed the force in the one after.
const ROUNDS: usize = 3;

impl<R: Real> Trajectory<R> {
    /// Moves the workspace off the point where one of the program's singular points vanishes, if that begins to grow there: where the
    /// motion begins or has just crossed a surface, or where a step has led from there but for rounding; or meets the surface that a step
    /// has so led to. On a leg that goes past everything also on where it is negative, as if the root were nothing there.
    pub(super) fn step_off_root(
        &self,
        system: &System,
        work: &mut Workspace<R>,
        (program, which): (&Program, usize),
    ) -> Option<Resolution> {
        let constants = &self.constants[self.mode].as_ref()?.tape;
        let plain = Program {
            tape: (program.tape).without_roots(which, constants, Negligible::Integrable)?,
            ..program.clone()
        };
        // Towards the surface steps have shrunk: not so the motion's own time.
        let load = |work: &mut Workspace<R>| {
            let class = self.load(work);
            work.tau = work.tau.max(self.longest_step);
            class
        };
        let class = load(work);
        expand_within_reach(work, &plain, class).ok()?;
        let base = work
            .expansion
            .series(program.tape.singular[which].slot)
            .to_vec();
        let (reach, tau) = (work.scaled_step, work.tau);
        if !(reach > R::ZERO && base.iter().all(|c| c.is_finite())) {
            return None;
        }
        let noise = R::splat(Workspace::<R>::NOISE);
        let slot = program.tape.singular[which].slot;
        let terms = work.expansion.size_of_terms(&plain.tape, constants, slot);
        let is_side = |guard: &Guard| guard.meets_corner() && guard.series == Operand::Series(slot);
        let is_here = base[0].abs() <= terms * noise && program.guards.iter().any(is_side);
        let (falls, rises) = (base[1] < R::ZERO, base[1] > R::ZERO);
        let begins = (is_here && rises) || self.has_come_to_a_corner(program);
        let ends_here = is_here && falls;
        if !(system.goes_past_roots() || begins || ends_here) {
            return None;
        }
        let least = base[0].abs().max(terms * noise) * R::splat(GROWS);
        let mut s = reach * R::splat(R::ROUNDOFF).sqrt();
        for _ in 0..LENGTHENED {
            if horner(&base, s) >= least || s > reach {
                break;
            }
            s *= R::splat(LONGER);
        }
        let grows = horner(&base, s) >= least && s <= reach;
        let ends = match grows {
            true => s,
            false if system.goes_past_roots() => negative_until(&base, reach)?,
            false if ends_here => s,
            false => return None,
        };
        load(work);
        work.horizon = work.horizon.min(ends * tau);
        let resolution = resolve(work, &plain, class, (self.touching, self.left)).ok()?;
        work.travel();
        let undisturbed = work.event == R::splat(NO_EVENT) && resolution.touched.is_none();
        if grows && undisturbed {
            self.add_root(work, (program, &plain));
        }
        let meets = work.event != R::splat(NO_EVENT);
        if !grows && !meets && !system.goes_past_roots() {
            return None;
        }
        Some(resolution)
    }

    /// Whether motion begins here, or a surface has just been crossed: what vanishes here has then not been come to by motion along it.
    fn has_come_to_a_corner(&self, program: &Program) -> bool {
        let touched = |index: usize| self.touching.get(index) > 0;
        let mut guards = program.guards.iter().enumerate();
        let impact = guards
            .clone()
            .any(|(index, guard)| touched(index) && guard.closing().is_some());
        let corner = guards.any(|(index, guard)| touched(index) && guard.meets_corner());
        !impact && (corner || self.started_at == self.time)
    }

    /// Adds what the root has added to the state by the end of the step that was made without it: what it adds along the motion without
    /// it, what that in turn changes, and so on.
    fn add_root(&self, work: &mut Workspace<R>, (program, plain): (&Program, &Program)) {
        let Some(constants) = &self.constants[self.mode] else {
            return;
        };
        let step = work.step;
        let size = work.state.len();
        let low = vec![R::ZERO; size];
        let parts = [R::ONE, R::splat(0.5)];
        let path = parts
            .map(|part| -> Vec<R> { (0..size).map(|i| work.dense().state(i, part)).collect() });
        let mut moved = path.clone();
        let mut rates = |program: &Program, states: &[Vec<R>; 2]| {
            [0, 1].map(|k| -> Vec<R> {
                work.expand_at(&program.tape, &constants.tape, (&states[k], &low), step);
                (0..size).map(|i| work.point.series(i)[1]).collect()
            })
        };
        let mut known = rates(plain, &path);
        let mut by = vec![R::ZERO; size];
        for _ in 0..ROUNDS {
            let found = rates(program, &moved);
            for i in 0..size {
                let [end, middle] = [0, 1].map(|k| found[k][i] - known[k][i]);
                let grown = Grown::new(end, middle);
                by[i] += grown.by(R::ONE);
                for (state, part) in moved.iter_mut().zip(parts) {
                    state[i] += grown.by(part);
                }
            }
            known = found;
        }
        for (i, by) in by.into_iter().enumerate() {
            (work.state[i], work.low[i]) = two_sum(work.state[i], work.low[i] + by);
        }
        // Series reach about as far as the base is from zero.
        work.reach.iter_mut().for_each(|reach| *reach = step);
    }
}

/// The integral of a rate that grows as a power of time from the start of a step, where it has a finite one.
struct Grown<R> {
    whole: R,
    /// That of time in the integral.
    power: f64,
}

impl<R: Real> Grown<R> {
    /// From the rate at the end of the step, times its length, and in its middle.
    fn new(end: R, middle: R) -> Self {
        let exponent = libm::log2((end / middle).to_f64());
        if end == R::ZERO || !(exponent > LEAST_EXPONENT && exponent.is_finite()) {
            return Self {
                whole: R::ZERO,
                power: 1.0,
            };
        }
        let power = exponent + 1.0;
        Self {
            whole: end / R::splat(power),
            power,
        }
    }

    /// After a part of the step.
    fn by(&self, part: R) -> R {
        self.whole * R::splat(libm::pow(part.to_f64(), self.power))
    }
}

/// As far as a base that is negative, or becomes so at once, stays negative: at most to the end of the reach.
fn negative_until<R: Real>(base: &[R], reach: R) -> Option<R> {
    let below: Vec<R> = base.iter().map(|&c| -c).collect();
    let noise = R::splat(Workspace::<R>::NOISE);
    let level = magnitude(&below, reach) * noise;
    let begins = usize::from(below[0] <= level);
    let rest = &below[begins..];
    if horner(rest, reach * R::splat(R::ROUNDOFF).sqrt()) <= R::ZERO {
        return None;
    }
    let level = magnitude(rest, reach) * noise;
    Some(first_root(rest, reach, Crossing::Falling, level).map_or(reach, |root| root.at))
}
