//! One Taylor step: expand, find the first guard that vanishes, move there, and apply the impact if it is one.
//!
//! The same code runs on one trajectory and on lanes of many: no branch depends on a value. What cannot be certified
//! here (a near graze, several candidate roots, a field that is not finite) is reported as such and settled by
//! [`resolve`](resolve) for that trajectory alone, so a lane's result does not depend on its neighbours.

mod certificates;
pub(super) mod dense;
mod end;
pub(super) mod flight;
mod newton;
pub(super) mod resolve;
mod single;

use super::chatter::Tail;
use super::modes::at_contacts::IMPACT_SCALARS;
use super::modes::program::Program;
use super::system::Settings;
use super::touching::Touching;
use crate::expressions::{Expansion, MAX_ORDER, Operand, Tape};
use crate::numerics::polynomial::{bernstein, horner, magnitude, sizes};
use crate::numerics::roots::Crossing;
use crate::numerics::{Mask, Scalar};
use certificates::{Ahead, SignCount, falls_by_leading, falls_steadily};
use flight::{Outcome, reaches};
use newton::{is_inside, leading_quadratic, newton, quadratic_root};

pub(crate) use crate::expressions::ORDER_CLASSES;
pub(crate) use end::{flight_time, legal_rates};

/// A step may outgrow the predicted one by this factor at most: beyond it the scaled coefficients say little.
pub(crate) const GROWTH: f64 = 4.0;

/// Nor may a step be less than this part of the unit of time that the expansion was scaled with: so far inside, the sizes
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
            if crossed.any() {
                certain = certain & !(crossed & self.meets_corner(program, touching));
            }
            let begins = self.sides[section];
            let ends = S::select(crossed, -begins, sign(value));
            self.sides[section] = S::select(met, ends, begins);
        }
        certain
    }

    /// Where a surface at which formulas change cannot be told from zero at the end of the step: what follows there says whether a section
    /// is crossed.
    #[inline(always)]
    fn meets_corner(&self, program: &Program, touching: Touching) -> S::Mask {
        let mut met = S::Mask::splat(false);
        for (index, guard) in program.guards.iter().enumerate() {
            if guard.meets_corner()
                && let Operand::Series(slot) = guard.series
            {
                met = met | self.vanishes_at_end(slot, touching.get(index));
            }
        }
        met
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
        self.vanishes_at_end(slot, touching.get(index))
    }

    /// Where a series, so many of whose roots lie at the start, cannot be told from zero at the end of the step.
    #[inline(always)]
    fn vanishes_at_end(&self, slot: usize, roots: u8) -> S::Mask {
        let p = &self.expansion.series(slot)[usize::from(roots)..];
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
}

/// 1, or -1 for what is negative.
#[inline(always)]
fn sign<S: Scalar>(value: S) -> S {
    S::select(value.less(S::splat(0.0)), S::splat(-1.0), S::splat(1.0))
}
