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

use crate::expressions::{Negligible, Operand};
use crate::flow::modes::guard::Guard;
use crate::flow::modes::program::Program;
use crate::flow::step::resolve::{Resolution, Unsettled, expand_within_reach, resolve};
use crate::flow::step::{NO_EVENT, Workspace};
use crate::flow::system::System;
use crate::flow::touching::Touching;
use crate::flow::trajectory::Trajectory;
use crate::numerics::polynomial::{horner, magnitude};
use crate::numerics::roots::{Crossing, first_root};
use crate::numerics::{Real, dot, two_sum};

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
    pub(in crate::flow::trajectory) fn step_off_root(
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
        // Where no surface says on which side motion is, nothing turns that motion with slopes, or that the root does not move at all.
        let is_beside = !system.goes_past_roots() && bases.iter().all(|base| !base.ends_a_side);
        let passes = is_beside && self.has_slopes(program, slots);
        if !(system.goes_past_roots() || begins || ends_here || rests || passes) {
            return Err(None);
        }
        let is_held = || system.goes_past_roots() || self.has_slopes(program, slots);
        if rests && !(is_held() || self.are_drawn_back(system, program, slots)) {
            return Err(None);
        }
        let has_grown = |s: R| {
            moving().all(|base| {
                let value = horner(&base.series, s);
                let size = if passes { value.abs() } else { value };
                size >= base.least()
            })
        };
        let flat = self.begins_flat(program, slots);
        // What is left out is as small as one more power of it.
        let omitted = flat.map_or(2.0, |order| f64::from(order) + 1.0);
        let mut s = reach * R::splat(libm::pow(R::ROUNDOFF, 1.0 / omitted));
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
        if is_beside && !self.goes_on_alike(work, (program, plain)) {
            return Err(None);
        }
        let meets = work.event != R::splat(NO_EVENT);
        if grows && !meets && resolution.touched.is_none() {
            match (flat, &bases[..]) {
                // What has come to zero, and stays there, has no root.
                (Some(_), [_]) if rests => {}
                (Some(_), [base]) => {
                    self.add_flat_root(work, (program, plain), (slots[0], horner(&base.series, s)))
                }
                _ => self.add_root(work, (program, plain)),
            }
        }
        if !grows && !meets && !system.goes_past_roots() {
            return Err(near);
        }
        Ok(resolution)
    }

    /// Whether motion goes on from the end of a step that was made without roots, and what ends the mode is at both its ends about the
    /// same with them.
    fn goes_on_alike(
        &self,
        work: &mut Workspace<R>,
        (program, plain): (&Program, &Program),
    ) -> bool {
        let Some(constants) = &self.constants[self.mode] else {
            return false;
        };
        let end = (work.state.clone(), work.low.clone());
        let mut at = |tape, (state, low): (&[R], &[R])| {
            work.expand_at(tape, &constants.tape, (state, low), R::ONE);
            let value = |guard: &Guard| match guard.series {
                Operand::Series(slot) => work.point.series(slot)[0],
                Operand::Constant(index) => constants.tape[index],
            };
            let moves = (0..state.len()).all(|i| work.point.series(i)[1].is_finite());
            let values: Vec<R> = program.guards.iter().map(value).collect();
            (moves, values)
        };
        let ends: [(&[R], &[R]); 2] = [(&self.state, &self.low), (&end.0, &end.1)];
        let [(_, is_alike), goes_on] = ends.map(|end| {
            let ((_, without), (moves, with)) = (at(&plain.tape, end), at(&program.tape, end));
            let is_alike = (with.iter().zip(&without)).all(|(&with, &without)| {
                with == without || (with - without).abs() <= without.abs() * R::splat(0.5)
            });
            (moves, is_alike)
        });
        is_alike && goes_on == (true, true)
    }

    /// Whether the field has slopes where these series vanish: motion along which they do is the only one then.
    pub(in crate::flow::trajectory) fn has_slopes(
        &self,
        program: &Program,
        vanishing: &[usize],
    ) -> bool {
        (self.constants[self.mode].as_ref()).is_some_and(|constants| {
            (vanishing.iter()).all(|&slot| program.tape.has_slope_at(slot, &constants.tape))
        })
    }

    /// Whether the roots of all these series draw them back to zero.
    fn are_drawn_back(&self, system: &System, program: &Program, slots: &[usize]) -> bool {
        let keeps = |kind| self.keeps_to_zero(system, kind).unwrap_or(false);
        (slots.iter())
            .all(|&slot| side_of(program, slot).is_some_and(|(_, guard)| keeps(guard.kind)))
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
        let Some(mut moved) = Moved::new(self, work, plain) else {
            return;
        };
        for _ in 0..ROUNDS {
            moved.again(work, program, |_| R::ONE);
        }
        moved.finish(work);
    }

    /// The same where the base begins with its second derivative, or a later one: the root changes as much of it as it has. Along the
    /// motion without it the base becomes `base`, and the root would take k of that: so it is y^2 of that, y^2 = 1 - k y, and its root y
    /// times as large. What columns of derivatives have added they take by a part of itself, which the second time tells.
    fn add_flat_root(
        &self,
        work: &mut Workspace<R>,
        (program, plain): (&Program, &Program),
        (slot, base): (usize, R),
    ) {
        let Some(unmoved) = Moved::new(self, work, plain) else {
            return;
        };
        let mut moved = unmoved.clone();
        moved.again(work, program, |_| R::ONE);
        let taken = (base - moved.value(work, program, slot)) / base;
        let part = R::splat(2.0) / (taken + taken.mul_add(taken, R::splat(4.0)).sqrt());
        let size = self.coordinates;
        let (of_state, of_columns) = (
            |i: usize| if i < size { part } else { R::ZERO },
            |i: usize| if i < size { R::ZERO } else { R::ONE },
        );
        let mut moved = unmoved.clone();
        moved.again(work, program, of_state);
        if self.state.len() > size {
            moved.known = unmoved.known;
            moved.again(work, program, of_columns);
            let first = moved.by.clone();
            moved.again(work, program, of_columns);
            for (by, first) in moved.by.chunks_mut(size).zip(first.chunks(size)).skip(1) {
                let more: Vec<R> = by
                    .iter()
                    .zip(first)
                    .map(|(&by, &first)| by - first)
                    .collect();
                let square = dot(first, first);
                if square > R::ZERO {
                    let share = R::ONE - dot(&more, first) / square;
                    by.iter_mut()
                        .zip(first)
                        .for_each(|(by, &first)| *by = first / share);
                }
            }
        }
        moved.finish(work);
    }

    /// By which derivative, above the first, the one base here begins.
    fn begins_flat(&self, program: &Program, slots: &[usize]) -> Option<u8> {
        let [slot] = slots else {
            return None;
        };
        let roots = side_of(program, *slot).map(|(index, _)| self.touching.get(index))?;
        (roots > 1 && roots != Touching::BALANCED).then_some(roots)
    }
}

/// A step that was made without roots, and what they add to it.
#[derive(Clone)]
struct Moved<'t, R> {
    constants: &'t [R],
    step: R,
    /// States at its end and in its middle.
    moved: [Vec<R>; 2],
    /// What has been added at the end.
    by: Vec<R>,
    /// Rates, times the step, that are in these already.
    known: [Vec<R>; 2],
}

/// The parts of a step that rates are asked at.
const PARTS: [f64; 2] = [1.0, 0.5];

impl<'t, R: Real> Moved<'t, R> {
    fn new(
        trajectory: &'t Trajectory<R>,
        work: &mut Workspace<R>,
        plain: &Program,
    ) -> Option<Self> {
        let constants = &trajectory.constants[trajectory.mode].as_ref()?.tape;
        let size = work.state.len();
        let at = |part: f64| -> Vec<R> {
            (0..size)
                .map(|i| work.dense().state(i, R::splat(part)))
                .collect()
        };
        let path = PARTS.map(at);
        let mut step = Self {
            constants,
            step: work.step,
            moved: path,
            by: vec![R::ZERO; size],
            known: [Vec::new(), Vec::new()],
        };
        step.known = step.rates(work, plain);
        Some(step)
    }

    /// Expands the program where a part of the step has led.
    fn expand(&self, work: &mut Workspace<R>, program: &Program, part: usize) {
        let (moved, low) = (&self.moved[part], vec![R::ZERO; self.by.len()]);
        work.expand_at(&program.tape, self.constants, (moved, &low), self.step);
    }

    fn rates(&self, work: &mut Workspace<R>, program: &Program) -> [Vec<R>; 2] {
        [0, 1].map(|part| {
            self.expand(work, program, part);
            let rate = |i: usize| work.point.series(i)[1];
            (0..self.by.len()).map(rate).collect()
        })
    }

    /// Adds what the program's rates have more than is known, so many times in each component.
    fn again(&mut self, work: &mut Workspace<R>, program: &Program, times: impl Fn(usize) -> R) {
        let found = self.rates(work, program);
        for i in 0..self.by.len() {
            let [end, middle] = [0, 1].map(|k| found[k][i] - self.known[k][i]);
            let grown = Grown::new(end, middle);
            self.by[i] += times(i) * grown.by(R::ONE);
            for (state, part) in self.moved.iter_mut().zip(PARTS) {
                state[i] += times(i) * grown.by(R::splat(part));
            }
        }
        self.known = found;
    }

    /// A series' value at the end.
    fn value(&self, work: &mut Workspace<R>, program: &Program, slot: usize) -> R {
        self.expand(work, program, 0);
        work.point.series(slot)[0]
    }

    /// Ends the step where what was added has led.
    fn finish(self, work: &mut Workspace<R>) {
        for (i, by) in self.by.into_iter().enumerate() {
            (work.state[i], work.low[i]) = two_sum(work.state[i], work.low[i] + by);
        }
        // Series reach about as far as the base is from zero.
        work.reach.iter_mut().for_each(|reach| *reach = self.step);
    }
}

/// The guard that ends a side where this series vanishes, if one does, and its place.
fn side_of(program: &Program, slot: usize) -> Option<(usize, &Guard)> {
    (program.guards.iter().enumerate())
        .find(|(_, guard)| guard.meets_corner() && guard.series == Operand::Series(slot))
}

/// What a root is taken of, along the motion without it.
struct Base<R> {
    series: Vec<R>,
    /// What cannot be told from zero where the step begins.
    rounding: R,
    /// Whether it vanishes on a surface.
    ends_a_side: bool,
    /// Whether the step begins there.
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
            let is_near = place > 0 || series[0].abs() <= rounding;
            let ends_a_side = side_of(program, slot).is_some();
            Base {
                ends_a_side,
                is_here: is_near && ends_a_side,
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
