//! One Taylor step: expand, find the first guard that vanishes, move there, and apply the impact if it is one.
//!
//! The same code runs on one trajectory and on lanes of many: no branch depends on a value. What cannot be certified
//! here (a near graze, several candidate roots, a field that is not finite) is reported as such and settled by
//! [`resolve`](resolve) for that trajectory alone, so a lane's result does not depend on its neighbours.

mod certificates;
pub(super) mod dense;
pub(super) mod flight;
pub(super) mod resolve;

use super::chatter::Tail;
use super::modes::guard::Transition;
use super::modes::program::{IMPACT_SCALARS, Program, ProgramConstants};
use super::system::Settings;
use super::touching::Touching;
use crate::expressions::{Expansion, MAX_ORDER, Operand, Tape};
use crate::numerics::dispatch::{Kernel, dispatch_narrow};
use crate::numerics::polynomial::{
    bernstein, horner, horner_with_slope, leading_with_slope, magnitude, sizes,
};
use crate::numerics::roots::Crossing;
use crate::numerics::{Mask, Real, Scalar, two_sum};
use certificates::{Ahead, SignCount, coefficient, falls_by_leading, falls_steadily};
use flight::{Outcome, later, reaches};

pub(crate) use crate::expressions::ORDER_CLASSES;

/// A step may outgrow the predicted one by this factor at most: beyond it the scaled coefficients say little.
pub(crate) const GROWTH: f64 = 4.0;

/// The unit of time is at most so many times as long as steps have been.
const AHEAD: f64 = 64.0;

/// And it must not fall below this part of the unit of time that the expansion was scaled with: so far inside, the sizes
/// of coefficients, which grow like powers of that unit, say nothing of how far the expansion reaches. A step as long as
/// they do say, after a release from a long rest, may be too short to leave the contact by more than rounding.
pub(crate) const LEAST_GROWTH: f64 = 1.0 / 16.0;

/// A value is told from zero if it exceeds this many roundoffs of the terms that it is the sum of. The sums have some
/// fifty terms of falling size, each wrong by a few roundoffs.
pub(crate) const NOISE_ROUNDOFFS: f64 = 32.0;

/// Two times that differ by less than so many roundoffs are one: what happens that little after the end of a run belongs to it.
pub(crate) const LATE_ROUNDOFFS: f64 = 8.0;

/// Truncation may take this part of the tolerance, so that at rounding level it adds little to what rounding does anyway:
/// a quarter costs one step in twenty and makes errors after a hundred impacts in chaos four times smaller.
const TRUNCATION_SHARE: f64 = 0.25;

/// A guard falls below zero by at least p'^2 / (2 p'') after a root: certainly further than noise if (p' s)^2 exceeds the
/// noise by this factor times the sum of the terms' sizes, of which s^2 p'' is at most the square of the order. Else it
/// may be a graze.
const GRAZE: f64 = 2.0 * (MAX_ORDER * MAX_ORDER) as f64;

/// Newton's method stops once a correction is this small relative to the root: the next would be its square.
const NEWTON_DONE: f64 = 1e-8;
const NEWTON_STEPS: usize = 6;

/// It begins with a step on so many leading terms and one on twice as many, where there are these.
const NEWTON_LEADING: usize = 6;

/// A restitution computed from rates may leave [0, 1] by this much.
const RESTITUTION_SLACK: f64 = 1e-12;

/// Longer than any time of interest, yet finite, so that products with zero stay zero.
pub(crate) const FOREVER: f64 = 1e30;

/// A step this short against what its expansion reaches, as from an event to the end of a run, says nothing of signs: what
/// changes within it is rounding.
const INSTANT: f64 = 1e-12;

/// The least step: one of a time that is kept as a sum of two numbers, and cannot tell even thousands of shorter ones; nor
/// do products of shorter ones keep their digits.
#[inline(always)]
pub(crate) fn least_step<S: Scalar>(time: S) -> S {
    const UNTOLD: f64 = 1e-12;
    const SHORTEST: f64 = 1e-290;
    let lowest = S::splat(S::ROUNDOFF * UNTOLD);
    (time.abs() * S::splat(S::ROUNDOFF)).mul_add(lowest, S::splat(SHORTEST))
}

/// Result code for a step without event.
pub(crate) const NO_EVENT: f64 = -1.0;

/// The number of a type that a step works with, its inputs and its results.
#[derive(Clone, Debug)]
pub struct Workspace<S: Scalar> {
    pub(crate) expansion: Expansion<S>,
    /// For values at a point, so that the expansion of the step survives as dense output.
    pub(crate) point: Expansion<S>,
    pub(crate) bernstein: Vec<S>,

    /// Tape constants of the program and of its impacts.
    pub(crate) constants: Vec<S>,
    pub(crate) impact_constants: Vec<Vec<S>>,
    /// Whose they are, by edition; none where nobody says.
    edition: Option<u64>,
    /// State before the step, overwritten by the state after it; `low` is its rounding remainder.
    pub(crate) state: Vec<S>,
    pub(crate) low: Vec<S>,
    /// The state that is the time, if there is one.
    clock: Option<usize>,
    /// For each section its side, 1 or -1, or 0 where that is not known: before the step, then after it.
    pub(crate) sides: Vec<S>,
    /// For each section where it may be met in the step.
    met: Vec<S::Mask>,
    /// Unit of the scaled time.
    pub(crate) tau: S,
    /// The step is at most this long.
    pub(crate) horizon: S,
    /// Time where the step begins.
    pub(crate) time: S,
    /// The gap of a contact where the step begins, if that is known better than it can be computed.
    pub(crate) known_gap: Option<(usize, S)>,
    /// The longest step before it, or zero: what the settling of one trajectory's steps asks for.
    pub(crate) longest: S,
    /// Where nothing that must not vanish does so at the start of the step, and all numbers are finite.
    clear: S::Mask,
    /// How far an expansion of each order reaches; entries above the order used are kept.
    pub(crate) reach: [S; ORDER_CLASSES],
    /// How far the latest expansion reaches, in its unit of time.
    pub(crate) growth: S,

    /// Results: the scaled and the true length of the step, the index of the guard that ended it or [`NO_EVENT`].
    pub(crate) scaled_step: S,
    pub(crate) step: S,
    /// The rounding remainder of that length.
    pub(crate) step_low: S,
    pub(crate) event: S,
    /// After an impact: rate before and after, acceleration, jerk, restitution here and at rest, predicted length of the
    /// flight.
    pub(crate) impact: [S; IMPACT_SCALARS],
    pub(crate) flight_time: S,
    /// Base-two logarithm of the relative tolerance.
    log_tolerance: f64,
    /// When and how precisely chatter sequences are completed.
    pub(crate) tail: Tail,
}

impl<S: Scalar> Workspace<S> {
    /// Scratch space for programs whose tapes are given.
    pub(crate) fn new<'a>(
        tapes: impl Iterator<Item = &'a Tape>,
        (dimension, clock, sections): (usize, Option<usize>, usize),
        settings: &Settings,
    ) -> Self {
        let zero = S::splat(0.0);
        let tapes: Vec<&Tape> = tapes.collect();
        let tolerance = settings.tolerance.max(S::ROUNDOFF);
        Self {
            expansion: Expansion::new(&tapes).with_backend(settings.backend),
            point: Expansion::new(&tapes).with_backend(settings.backend),
            bernstein: vec![zero; MAX_ORDER + 1],
            constants: Vec::new(),
            impact_constants: Vec::new(),
            edition: None,
            state: vec![zero; dimension],
            low: vec![zero; dimension],
            clock,
            sides: vec![zero; sections],
            met: vec![S::Mask::splat(false); sections],
            tau: zero,
            horizon: zero,
            time: zero,
            known_gap: None,
            longest: zero,
            clear: S::Mask::splat(true),
            reach: [zero; ORDER_CLASSES],
            growth: zero,
            scaled_step: zero,
            step: zero,
            step_low: zero,
            event: zero,
            impact: [zero; IMPACT_SCALARS],
            flight_time: zero,
            log_tolerance: libm::log2(tolerance * TRUNCATION_SHARE),
            tail: Tail {
                longest: settings.longest_tail,
                precision: tolerance,
            },
        }
    }

    /// Whether a state is the time.
    pub(crate) fn is_clock(&self, state: usize) -> bool {
        self.clock == Some(state)
    }

    /// What the latest step came to.
    #[inline(always)]
    pub(crate) fn outcome(&self) -> Outcome<S> {
        Outcome {
            step: self.step,
            step_low: self.step_low,
            impact: self.impact,
            flight_time: self.flight_time,
        }
    }

    /// Relative size below which a polynomial's value is noise: it is known to rounding wherever it is evaluated, however
    /// far from the solution its truncation may be.
    pub(crate) const NOISE: f64 = NOISE_ROUNDOFFS * S::ROUNDOFF;

    /// Expands the flow at order class `class` and finds how far each order reaches.
    #[inline(always)]
    pub(crate) fn expand(&mut self, program: &Program, class: usize) {
        let order = S::ORDERS[class];
        self.expansion.run(
            &program.tape,
            &self.constants,
            &self.state,
            &self.low,
            self.tau,
            order,
        );
        if let Some((contact, gap)) = self.known_gap
            && let Some((_, slot)) = program.gap_series(contact)
        {
            self.expansion.set(slot, 0, gap);
        }
        let dimension = self.state.len();
        let mut worst = [S::splat(0.0); ORDER_CLASSES];
        for slot in 0..dimension {
            self.expansion.tail_ratios(slot, class + 1, &mut worst);
        }
        for guard in &program.guards {
            if let (true, Operand::Series(slot)) = (guard.is_expanded, guard.series) {
                self.expansion.tail_ratios(slot, class + 1, &mut worst);
            }
        }
        let mut growth = S::splat(GROWTH);
        for (m, &worst) in worst.iter().enumerate().take(class + 1) {
            let exponent = (S::splat(self.log_tolerance) - worst.coarse_log2())
                * S::splat(1.0 / S::ORDERS[m] as f64);
            growth = exponent.coarse_exp2().min(S::splat(GROWTH));
            self.reach[m] = self.tau * growth;
        }
        growth = growth.min((self.expansion).resolved(&program.tape, &self.constants, GROWTH));
        self.reach[class] = self.tau * growth;
        let mut wanted = growth;
        let is_cut = self.horizon.less(self.reach[class]);
        if is_cut.any() {
            wanted = S::select(is_cut, self.horizon / self.tau, growth);
        }
        let (regular, clear) =
            (self.expansion).regular(&program.tape, &self.constants, wanted, &mut self.bernstein);
        let is_near = regular.less(wanted);
        self.reach[class] = S::select(is_near, self.tau * regular, self.reach[class]);
        self.growth = S::select(is_near, regular, growth);
        self.scaled_step = regular;
        self.clear = clear & self.is_finite();
    }

    /// Whether the expansion has no coefficient that is no number: what is wrong somewhere is so in the first or last of
    /// some state.
    #[inline(always)]
    fn is_finite(&self) -> S::Mask {
        let order = self.expansion.order();
        let mut nothing = S::splat(0.0);
        for slot in 0..self.state.len() {
            let series = self.expansion.series(slot);
            nothing = (series[1].abs() + series[order].abs()).mul_add(S::splat(0.0), nothing);
        }
        nothing.is_finite()
    }

    /// The polynomial of a guard, its `touching` leading coefficients divided out: roots known to lie at the start.
    #[inline(always)]
    pub(crate) fn guard_series(&self, series: Operand, touching: u8) -> Option<&[S]> {
        match series {
            Operand::Series(slot) => Some(&self.expansion.series(slot)[usize::from(touching)..]),
            Operand::Constant(_) => None,
        }
    }

    /// Shortens the step to the first guard's zero. Returns where this is certain.
    #[inline(always)]
    pub(crate) fn locate(&mut self, program: &Program, touching: Touching) -> S::Mask {
        self.event = S::splat(NO_EVENT);
        let step = self.scaled_step * self.tau;
        let mut certain = self.clear
            & step.is_finite()
            & least_step(self.time).less(step)
            & S::splat(LEAST_GROWTH).at_most(self.growth);
        let mut relative = S::splat(Self::NOISE);
        let ends_the_run = reaches(step, self.horizon);
        if ends_the_run.any() {
            // What the time at the end leaves open is settled with more care.
            let late = self.time.abs() * S::splat(4.0 * LATE_ROUNDOFFS * S::ROUNDOFF) / step;
            relative = S::select(ends_the_run, relative + late, relative);
        }
        let mut sections_met = false;
        for (index, guard) in program.guards.iter().enumerate() {
            let Operand::Series(slot) = guard.series else {
                continue;
            };
            let roots = touching.get(index);
            if guard.is_balanced(roots) {
                continue;
            }
            let p = &self.expansion.series(slot)[usize::from(roots)..];
            let end = self.scaled_step;
            let start = p[0];
            let sizes = sizes(&p[1..], end);
            let rest = sizes.all * end;
            let noise = (rest + start.abs()) * relative;
            let mut settled = (rest + noise).less(start.abs());
            let must_be_positive = if let Some(section) = guard.section() {
                let side = &mut self.sides[section];
                let here = sign(start);
                let is_known = S::splat(0.0).less(side.abs());
                let agrees = S::splat(0.0).less(*side * here) & S::splat(0.0).less(start.abs());
                certain = certain
                    & (agrees | (!is_known & noise.less(start.abs())))
                    & (self.growth * S::splat(INSTANT)).less(end);
                *side = here;
                self.met[section] = S::Mask::splat(false);
                false
            } else {
                certain = certain & noise.less(start);
                true
            };
            if settled.all() {
                continue;
            }
            let ahead = Ahead {
                start,
                end,
                noise,
                beyond: sizes.beyond,
            };
            // A section is hardly ever crossed, and a gap closes where its leading terms say so.
            let mut guess = None;
            let mut is_expected = false;
            if roots == 1 && guard.closing().is_some() {
                // The unit of time of a flight that has just begun is its predicted length.
                guess = Some(S::splat(1.0).min(end));
                is_expected = leading_quadratic(p, end).less(S::splat(0.0)).any();
            } else if must_be_positive {
                let (root, is_real) = quadratic_root(p);
                is_expected = (is_real & is_inside(root, end)).any();
                guess = Some(root);
            }
            if !is_expected {
                let value;
                (settled, value) = ahead.has_no_event(p, guard, settled, &mut self.bernstein);
                if let Some(section) = guard.section() {
                    let keeps_side = settled & S::splat(0.0).less(start * value);
                    self.met[section] = !keeps_side;
                    sections_met = sections_met || !keeps_side.all();
                }
                if settled.all() {
                    continue;
                }
            }
            let guess = match guess {
                Some(guess) => guess,
                None => quadratic_root(p).0,
            };
            let (root, converged, slope) = newton(p, guess, end);
            let root_inside = is_inside(root, end) & converged;
            let drop = slope * root;
            let is_clear = (noise * (rest + start.abs()) * S::splat(GRAZE)).less(drop * drop);
            let candidate = root_inside & is_clear & noise.less(start) & !settled;
            let mut falls = falls_by_leading(p, root, sizes.beyond);
            if (candidate & !falls).any() {
                falls = falls | falls_steadily(p, root);
            }
            let mut found = candidate & falls;
            if !must_be_positive && found.any() {
                // A root that cannot be told from the end of the step may coincide with what happens there.
                found = found & noise.less(horner(p, end).abs());
            }
            settled = settled | found;
            let mut at = root;
            if !settled.all() && is_expected {
                (settled, _) = ahead.has_no_event(p, guard, settled, &mut self.bernstein);
            }
            if !settled.all() {
                let n = p.len();
                bernstein(p, end, &mut self.bernstein);
                let count = SignCount::of(&self.bernstein[..n], noise);
                let positive = noise.less(start);
                let none = count.none
                    | (count.one & !positive & S::Mask::splat(guard.crossing == Crossing::Falling));
                let one =
                    count.one & (positive | S::Mask::splat(guard.crossing == Crossing::Either));
                let need = one & !settled;
                if need.any() {
                    let guess = count.first_change * end * S::splat(1.0 / (n - 1) as f64);
                    let (second, converged, _) = newton(p, guess, end);
                    let inside = is_inside(second, end) & converged;
                    let good = need & inside;
                    at = S::select(good, second, at);
                    found = found | good;
                    settled = settled | good;
                }
                settled = settled | none;
            }
            certain = certain & settled;
            self.scaled_step = S::select(found, at, self.scaled_step);
            self.event = S::select(found, S::splat(index as f64), self.event);
        }
        if sections_met {
            certain = certain & self.find_sides(program, touching);
        }
        if program.roots_at_sides {
            // Towards a root that vanishes with its rate steps become shorter than the time is known.
            let is_event = S::splat(NO_EVENT).less(self.event);
            certain = certain & (is_event | !self.is_untold());
        }
        certain & !self.is_crowded(program, touching)
    }

    /// Whether the step is shorter than the time is known, or, near time zero, than numbers have digits for its square.
    #[inline(always)]
    pub(crate) fn is_untold(&self) -> S::Mask {
        const NOTHING: f64 = 1e-100;
        let least = (self.time.abs()).mul_add(S::splat(S::ROUNDOFF), S::splat(NOTHING));
        (self.scaled_step * self.tau).at_most(least)
    }

    /// Finds on which side of the sections that may be [`met`](Self::met) the step ends. Returns where this is certain.
    #[inline(always)]
    fn find_sides(&mut self, program: &Program, touching: Touching) -> S::Mask {
        let mut certain = S::Mask::splat(true);
        let end = self.scaled_step;
        for (index, guard) in program.guards.iter().enumerate() {
            let Some(section) = guard.section() else {
                continue;
            };
            let met = self.met[section];
            if !met.any() {
                continue;
            }
            let Some(p) = self.guard_series(guard.series, touching.get(index)) else {
                continue;
            };
            let value = horner(p, end);
            let noise = magnitude(p, end) * S::splat(Self::NOISE);
            let crossed = self.ends_step(index);
            certain = certain & (!met | crossed | noise.less(value.abs()));
            let begins = self.sides[section];
            let ends = S::select(crossed, -begins, sign(value));
            self.sides[section] = S::select(met, ends, begins);
        }
        certain
    }

    /// Where a gap closes at the end of the step and that of another contact cannot be told from zero there.
    #[inline(always)]
    fn is_crowded(&self, program: &Program, touching: Touching) -> S::Mask {
        let mut crowded = S::Mask::splat(false);
        if program.gaps < 2 {
            return crowded;
        }
        for (index, guard) in program.guards.iter().enumerate() {
            if guard.closing().is_some() {
                let here = self.ends_step(index);
                for other in 0..program.guards.len() {
                    if other != index && here.any() {
                        crowded = crowded | (here & self.closes_too(program, other, touching));
                    }
                }
            }
        }
        crowded
    }

    /// Where this guard ended the step.
    #[inline(always)]
    pub(crate) fn ends_step(&self, index: usize) -> S::Mask {
        let code = S::splat(index as f64);
        code.at_most(self.event) & self.event.at_most(code)
    }

    /// Where the gap that is this guard cannot be told from zero at the end of the step.
    #[inline(always)]
    pub(crate) fn closes_too(
        &self,
        program: &Program,
        index: usize,
        touching: Touching,
    ) -> S::Mask {
        let guard = &program.guards[index];
        let (Some(_), Operand::Series(slot)) = (guard.closing(), guard.series) else {
            return S::Mask::splat(false);
        };
        let p = &self.expansion.series(slot)[usize::from(touching.get(index))..];
        let noise = magnitude(p, self.scaled_step) * S::splat(Self::NOISE);
        horner(p, self.scaled_step).abs().at_most(noise)
    }

    /// Makes a step, in the lanes where it can be certified.
    #[inline(always)]
    pub(crate) fn try_step(
        &mut self,
        program: &Program,
        class: usize,
        touching: Touching,
    ) -> S::Mask {
        self.expand(program, class);
        let certain = self.locate(program, touching);
        if certain.any() {
            self.finish(program);
        }
        certain
    }

    /// Moves the state to the end of the step and applies the impact where one ended it.
    #[inline(always)]
    fn finish(&mut self, program: &Program) {
        self.travel();
        self.collide(program);
    }

    /// Moves the state to the end of the step.
    #[inline(always)]
    pub(crate) fn travel(&mut self) {
        let s = self.scaled_step;
        self.step = s * self.tau;
        self.step_low = s.mul_add(self.tau, -self.step);
        for (slot, (state, low)) in self.state.iter_mut().zip(&mut self.low).enumerate() {
            if self.clock == Some(slot) {
                (*state, *low) = later((*state, *low), (self.step, self.step_low));
                continue;
            }
            let increment = horner(&self.expansion.series(slot)[1..], s).mul_add(s, *low);
            (*state, *low) = two_sum(*state, increment);
        }
        self.flight_time = S::splat(FOREVER);
        self.keep_unit();
    }

    /// The value of a series at the end of the step, so many of whose roots lie at its start, and the size of the terms that it is the
    /// sum of there.
    #[inline(always)]
    pub(crate) fn value_at_end(&self, tape: &Tape, slot: usize, roots: u8) -> (S, S) {
        let end = AtEnd {
            series: &self.expansion.series(slot)[usize::from(roots)..],
            scaled_step: self.scaled_step,
            roots,
        };
        let terms = (self.expansion).size_of_terms(tape, &self.constants, slot);
        (dispatch_narrow(end), terms)
    }

    /// The unit of time grows no farther than steps do: where events end them early, polynomials would reach farther and farther,
    /// and what rounding leaves open that far away says nothing of signs here. It stays what it was, by which such polynomials are
    /// scaled exactly.
    #[inline(always)]
    fn keep_unit(&mut self) {
        const TOP: usize = ORDER_CLASSES - 1;
        if self.expansion.order() == S::ORDERS[TOP] {
            let reach = self.reach[TOP];
            let is_far = (self.step * S::splat(AHEAD)).less(reach);
            self.reach[TOP] = S::select(is_far, reach.min(self.tau), reach);
        }
    }

    /// Applies the impact that ended the step, if it is one that leaves the rates of closed contacts as they are.
    #[inline(always)]
    pub(crate) fn collide(&mut self, program: &Program) {
        for (index, guard) in program.guards.iter().enumerate() {
            let Transition::Impact { contact } = guard.transition else {
                continue;
            };
            let here = self.ends_step(index);
            if here.any() {
                self.collide_at(program, contact, here);
            }
        }
    }

    /// Applies the impact map (M1) of a contact in the lanes of `here`, and predicts how long the next flight lasts.
    #[inline(always)]
    pub(crate) fn collide_at(&mut self, program: &Program, contact: usize, here: S::Mask) {
        let Some(impact) = program.impacts[contact].as_ref() else {
            return;
        };
        let constants = &self.impact_constants[contact];
        (self.point).settle(&impact.tape, constants, &self.state, &self.low);
        for (i, scalar) in self.impact.iter_mut().enumerate() {
            let value = self.point.value(&impact.tape, constants, i);
            *scalar = S::select(here, value, *scalar);
        }
        // An impact that no restitution in [0, 1] explains is reported, and leaves the state as it was before.
        let legal = here & legal_rates(self.impact[0], self.impact[1]);
        for (k, &i) in impact.changed.iter().enumerate() {
            let place = IMPACT_SCALARS + k;
            let value = self.point.value(&impact.tape, constants, place);
            let low = self.point.output_remainder(&impact.tape, place);
            self.state[i] = S::select(legal, value, self.state[i]);
            self.low[i] = S::select(legal, low, self.low[i]);
        }
        let [_, rate, acceleration, jerk, _, _] = self.impact;
        let time = flight_time(rate, acceleration, jerk);
        self.flight_time = S::select(here, time, self.flight_time);
    }
}

/// The end of a series, so many of whose roots lie at its start.
struct AtEnd<'a, S> {
    series: &'a [S],
    scaled_step: S,
    roots: u8,
}

impl<S: Scalar> Kernel for AtEnd<'_, S> {
    type Output = S;

    #[inline(always)]
    fn run(self) -> S {
        let end = horner(self.series, self.scaled_step);
        (0..self.roots).fold(end, |value, _| value * self.scaled_step)
    }
}

/// 1, or -1 for what is negative.
#[inline(always)]
fn sign<S: Scalar>(value: S) -> S {
    S::select(value.less(S::splat(0.0)), S::splat(-1.0), S::splat(1.0))
}

/// Whether the rate after an impact is one that a restitution in [0, 1] gives, up to rounding.
#[inline(always)]
pub(crate) fn legal_rates<S: Scalar>(before: S, after: S) -> S::Mask {
    let slack = before.abs() * S::splat(RESTITUTION_SLACK);
    let separating = (-slack).at_most(after) & after.at_most(slack - before);
    // An incoming rate that rounding has taken away: there is nothing to reverse.
    S::splat(0.0).at_most(before) | separating
}

/// Time to the next impact to leading order, eq. (3); [`FOREVER`] where there is none.
#[inline(always)]
pub(crate) fn flight_time<S: Scalar>(rate: S, acceleration: S, jerk: S) -> S {
    let nu = -acceleration;
    // That of the equation, times nu^2.
    let radicand = (jerk * rate).mul_add(S::splat(-8.0 / 3.0), nu * nu);
    let root = radicand.max(S::splat(0.0)).sqrt();
    let time = S::splat(4.0) * rate / (nu + root);
    let falls_back =
        S::splat(0.0).less(nu) & S::splat(0.0).at_most(radicand) & S::splat(0.0).at_most(rate);
    S::select(falls_back & time.is_finite(), time, S::splat(FOREVER))
}

/// The quadratic that p begins with, at s.
#[inline(always)]
fn leading_quadratic<S: Scalar>(p: &[S], s: S) -> S {
    coefficient(p, 2).mul_add(s, p[1]).mul_add(s, p[0])
}

/// The smaller positive root of the leading quadratic, the next impact in the flight of eq. (3), and where it is one; elsewhere
/// any number.
#[inline(always)]
fn quadratic_root<S: Scalar>(p: &[S]) -> (S, S::Mask) {
    let zero = S::splat(0.0);
    let (c, b) = (p[0], p[1]);
    let a = coefficient(p, 2);
    let radicand = b.mul_add(b, S::splat(-4.0) * a * c);
    let two_c = c + c;
    let root = two_c / (radicand.max(zero).sqrt() - b);
    (root, zero.at_most(radicand))
}

/// Whether a place is on (0, end].
#[inline(always)]
fn is_inside<S: Scalar>(place: S, end: S) -> S::Mask {
    S::splat(0.0).less(place) & place.at_most(end)
}

/// Newton's method from a guess; each lane stops when its own correction is small, whatever the others do. Also tells the
/// slope at the root.
#[inline(always)]
fn newton<S: Scalar>(p: &[S], guess: S, end: S) -> (S, S::Mask, S) {
    let zero = S::splat(0.0);
    let far = end + end;
    let usable = is_inside(guess, far);
    let mut at = S::select(usable, guess, end);
    let mut done = !usable;
    // The leading terms bring the guess close at a part of the cost: a few of them where it may be far, more when it is near.
    let mut inverse = zero;
    if let (Some(few), Some(more)) = (p.first_chunk(), p.first_chunk::<{ 2 * NEWTON_LEADING }>()) {
        let next;
        (next, inverse) = chebyshev(few, at);
        at = S::select(usable & is_inside(next, far), next, at);
        let (value, slope) = leading_with_slope(more, at);
        // From where the step of Chebyshev's began: twice, since it was a long one. What comes of slopes that differ more is mended below.
        for _ in 0..2 {
            inverse = nearer_inverse(inverse, slope).0;
        }
        let next = at - value * inverse;
        at = S::select(usable & is_inside(next, far), next, at);
    }
    let mut last_slope = zero;
    // The square of what double-double has to reach is not reached by what suffices for a double; nor is that of the error of an
    // inverse by more than its root.
    let least = NEWTON_DONE * (S::ROUNDOFF * 1e16).sqrt();
    let (least, close) = (S::splat(least), S::splat(least.sqrt()));
    for _ in 0..NEWTON_STEPS {
        let (value, slope) = horner_with_slope(p, at);
        let (nearer, miss) = nearer_inverse(inverse, slope);
        let is_close = miss.abs().at_most(close);
        inverse = nearer;
        if !is_close.all() {
            inverse = S::select(is_close, nearer, S::splat(1.0) / slope);
        }
        let correction = value * inverse;
        last_slope = S::select(done, last_slope, slope);
        at = S::select(done, at, at - correction);
        let small = correction.abs().at_most(at.abs() * least);
        done = done | small;
        if done.all() {
            break;
        }
    }
    (at, done & usable, last_slope)
}

/// The inverse of a slope from that of one nearby, and by what part that was off, of which the square is left.
#[inline(always)]
fn nearer_inverse<S: Scalar>(nearby: S, slope: S) -> (S, S) {
    let miss = (-slope).mul_add(nearby, S::splat(1.0));
    (nearby.mul_add(miss, nearby), miss)
}

/// A step of Chebyshev's method on a few terms: it triples the digits where Newton's doubles them. With the inverse of the slope.
#[inline(always)]
fn chebyshev<S: Scalar>(p: &[S; NEWTON_LEADING], at: S) -> (S, S) {
    const LAST: usize = NEWTON_LEADING - 1;
    let mut half_bend = p[LAST] * S::splat((LAST * (LAST - 1) / 2) as f64);
    for k in (2..LAST).rev() {
        half_bend = half_bend.mul_add(at, p[k] * S::splat((k * (k - 1) / 2) as f64));
    }
    let (value, slope) = leading_with_slope(p, at);
    let inverse = S::splat(1.0) / slope;
    let (newton, bend) = (value * inverse, half_bend * inverse);
    (at - (newton * newton).mul_add(bend, newton), inverse)
}

/// What one trajectory asks for beside its steps: one kernel, so that the interpreter is compiled once.
enum Task<'a, R> {
    /// The expansion of a step alone.
    Expansion(&'a Program, usize),
    /// An expansion of the lowest order from another state, which leaves that of the step as it is.
    Point {
        tape: &'a Tape,
        constants: &'a [R],
        state: &'a [R],
        low: &'a [R],
        tau: R,
    },
    /// The outputs of a tape at a state and its remainders.
    Values {
        tape: &'a Tape,
        constants: &'a [R],
        state: &'a [R],
        low: &'a [R],
        values: &'a mut [R],
    },
}

struct Single<'w, 'a, R: Real> {
    work: &'w mut Workspace<R>,
    task: Task<'a, R>,
}

impl<R: Real> Kernel for Single<'_, '_, R> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let Self { work, task } = self;
        match task {
            Task::Expansion(program, class) => work.expand(program, class),
            Task::Point {
                tape,
                constants,
                state,
                low,
                tau,
            } => (work.point).run(tape, constants, state, low, tau, R::ORDERS[0]),
            Task::Values {
                tape,
                constants,
                state,
                low,
                values,
            } => work.point.evaluate(tape, constants, state, low, values),
        }
    }
}

impl<R: Real> Workspace<R> {
    /// Expands, and leaves what follows to the caller.
    pub(crate) fn expand_only(&mut self, program: &Program, class: usize) {
        self.run(Task::Expansion(program, class));
    }

    /// Expands to the lowest order from a state and its remainders, into [`point`](Self::point).
    pub(crate) fn expand_at(
        &mut self,
        tape: &Tape,
        constants: &[R],
        (state, low): (&[R], &[R]),
        tau: R,
    ) {
        self.run(Task::Point {
            tape,
            constants,
            state,
            low,
            tau,
        });
    }

    /// Values of a tape's outputs at a point.
    pub(crate) fn values_at(
        &mut self,
        tape: &Tape,
        constants: &[R],
        (state, low): (&[R], &[R]),
        values: &mut [R],
    ) {
        self.run(Task::Values {
            tape,
            constants,
            state,
            low,
            values,
        });
    }

    fn run(&mut self, task: Task<'_, R>) {
        dispatch_narrow(Single { work: self, task });
    }

    /// Whether arguments that must not vanish are told from zero.
    pub(crate) fn is_clear(&self) -> bool {
        self.clear
    }

    /// Which of the program's singular points the expansion reaches no further for than `scaled_step`, and how far away it is.
    pub(crate) fn singularity(&mut self, program: &Program) -> Option<(usize, R)> {
        let step = self.scaled_step;
        let (which, reach) = (self.expansion).singularity(&program.tape, &self.constants, step)?;
        Some((which, reach * self.tau))
    }

    /// Whether a series of the latest expansion is told from zero at its start, by the bounds of its rounding.
    pub(crate) fn is_told(&mut self, program: &Program, slot: usize) -> bool {
        (self.expansion)
            .is_told(&program.tape, &self.constants, slot)
            .all()
    }

    /// Which of the program's singular points is not positive, or cannot be told from zero, or is nearer by its rate than the shortest step
    /// that was tried: that which is nearest, where series say no more.
    pub(crate) fn vanishing(&self, program: &Program) -> Option<usize> {
        let distance = |slot: usize| {
            let series = self.expansion.series(slot);
            let terms = (self.expansion).size_of_terms(&program.tape, &self.constants, slot);
            let distance = (series[0].abs() / series[1]).abs().to_f64();
            let vanishes = series[0] <= terms * R::splat(Self::NOISE) || distance <= 1.0;
            vanishes.then_some(if distance.is_nan() {
                f64::INFINITY
            } else {
                distance
            })
        };
        (program.tape.singular.iter().enumerate())
            .filter_map(|(which, singular)| Some((which, distance(singular.slot)?)))
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .map(|(which, _)| which)
    }

    /// Sets the constants of a program for a single trajectory.
    #[inline(always)]
    pub(crate) fn load_constants(&mut self, constants: &ProgramConstants<R>) {
        if self.edition != Some(constants.edition) {
            self.edition = Some(constants.edition);
            self.constants.clone_from(&constants.tape);
            self.impact_constants.clone_from(&constants.impacts);
        }
    }
}
