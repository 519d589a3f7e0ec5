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
//!
//! Of roots that begin at one instant, or so near to it that none but a shorter step would keep away from them, x(t) is without all.

use super::Trajectory;
use crate::expressions::{Negligible, Operand};
use crate::flow::guard::Guard;
use crate::flow::program::Program;
use crate::flow::resolve::{Resolution, Unsettled, expand_within_reach, resolve};
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
    /// has so led to. Along what stays there, if nothing else can begin there. On a leg that goes past everything also on where it is negative, as if
    /// the root were nothing there.
    pub(super) fn step_off_root(
        &self,
        system: &System,
        work: &mut Workspace<R>,
        (program, which): (&Program, usize),
    ) -> Option<Resolution> {
        let mut slots = vec![program.tape.singular[which].slot];
        let mut plain = self.without(program, which)?;
        loop {
            match self.step_without(system, work, (program, &plain), &slots) {
                Ok(resolution) => return Some(resolution),
                // What begins at the same instant is nearer than the step is long.
                Err(Some(near)) => {
                    slots.push(plain.tape.singular[near].slot);
                    plain = self.without(&plain, near)?;
                }
                Err(None) => return None,
            }
        }
    }

    /// The program without the roots of one of its singular points.
    fn without(&self, program: &Program, which: usize) -> Option<Program> {
        let constants = &self.constants[self.mode].as_ref()?.tape;
        Some(Program {
            tape: (program.tape).without_roots(which, constants, Negligible::Integrable)?,
            ..program.clone()
        })
    }

    /// Makes the step, if it can be, with what is `plain` in it, the roots of these series being left out. Else says which other
    /// singular point is in its way, if one is.
    fn step_without(
        &self,
        system: &System,
        work: &mut Workspace<R>,
        (program, plain): (&Program, &Program),
        slots: &[usize],
    ) -> Result<Resolution, Option<usize>> {
        // Towards the surface steps have shrunk: not so the motion's own time.
        let load = |work: &mut Workspace<R>| {
            let class = self.load(work);
            work.tau = work.tau.max(self.longest_step);
            class
        };
        let class = load(work);
        match expand_within_reach(work, plain, class) {
            Err(Unsettled::Singular { which, .. }) => return Err(Some(which)),
            Err(_) => return Err(work.vanishing(plain)),
            Ok(()) => {}
        }
        let (reach, tau) = (work.scaled_step, work.tau);
        let bases = bases(work, (program, plain), slots);
        let is_finite = |base: &Base<R>| base.series.iter().all(|c| c.is_finite());
        if !(reach > R::ZERO && bases.iter().all(is_finite)) {
            return Err(None);
        }
        let here = || bases.iter().filter(|base| base.is_here);
        let begins =
            here().any(|base| base.moves() > R::ZERO) || self.has_come_to_a_corner(program);
        let ends_here = here().any(|base| base.moves() < R::ZERO);
        // What stays where it vanishes adds nothing, and moves nothing off.
        let moving = || bases.iter().filter(|base| !base.rests(reach));
        let rests = moving().next().is_none();
        if !(system.goes_past_roots() || begins || ends_here || rests) {
            return Err(None);
        }
        if rests && !(system.goes_past_roots() || self.has_slopes(program, slots)) {
            return Err(None);
        }
        let has_grown = |s: R| moving().all(|base| horner(&base.series, s) >= base.least());
        let mut s = reach * R::splat(R::ROUNDOFF).sqrt();
        for _ in 0..LENGTHENED {
            if has_grown(s) || s > reach {
                break;
            }
            s *= R::splat(LONGER);
        }
        let grows = has_grown(s) && s <= reach;
        let near = match grows || system.goes_past_roots() {
            true => None,
            false => work.singularity(plain).map(|(near, _)| near),
        };
        let ends = match grows {
            true if rests => reach,
            true => s,
            false if system.goes_past_roots() => {
                negative_until(&bases[0].series, reach).ok_or(None)?
            }
            false if ends_here => s,
            false => return Err(near),
        };
        load(work);
        work.horizon = work.horizon.min(ends * tau);
        let resolution = resolve(work, plain, class, (self.touching, self.left));
        let resolution = resolution.map_err(|_| near)?;
        work.travel();
        let meets = work.event != R::splat(NO_EVENT);
        if grows && !meets && resolution.touched.is_none() {
            self.add_root(work, (program, plain));
        }
        if !grows && !meets && !system.goes_past_roots() {
            return Err(near);
        }
        Ok(resolution)
    }

    /// Whether the field has slopes where these series vanish: motion along which they do is the only one then.
    pub(super) fn has_slopes(&self, program: &Program, vanishing: &[usize]) -> bool {
        (self.constants[self.mode].as_ref()).is_some_and(|constants| {
            (vanishing.iter()).all(|&slot| program.tape.has_slope_at(slot, &constants.tape))
        })
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

/// What a root is taken of, along the motion without it.
struct Base<R> {
    series: Vec<R>,
    /// What cannot be told from zero where the step begins.
    rounding: R,
    /// Whether it vanishes on a surface, and the step begins there.
    is_here: bool,
}

impl<R: Real> Base<R> {
    /// The first of its derivatives that is not zero, or zero.
    fn moves(&self) -> R {
        let moving = self.series[1..].iter().find(|&&c| c != R::ZERO);
        moving.copied().unwrap_or(R::ZERO)
    }

    /// Whether nothing moves it from zero.
    fn rests(&self, reach: R) -> bool {
        magnitude(&self.series, reach) <= self.rounding
    }

    /// What it has grown to after a step off the root.
    fn least(&self) -> R {
        self.series[0].abs().max(self.rounding) * R::splat(GROWS)
    }
}

/// What the latest expansion says of these series. All but the first are known to be as good as here.
fn bases<R: Real>(
    work: &Workspace<R>,
    (program, plain): (&Program, &Program),
    slots: &[usize],
) -> Vec<Base<R>> {
    (slots.iter().enumerate())
        .map(|(place, &slot)| {
            let series = work.expansion.series(slot).to_vec();
            let terms = (work.expansion).size_of_terms(&plain.tape, &work.constants, slot);
            let rounding = terms * R::splat(Workspace::<R>::NOISE);
            let is_side =
                |guard: &Guard| guard.meets_corner() && guard.series == Operand::Series(slot);
            let is_near = place > 0 || series[0].abs() <= rounding;
            Base {
                is_here: is_near && program.guards.iter().any(is_side),
                series,
                rounding,
            }
        })
        .collect()
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
