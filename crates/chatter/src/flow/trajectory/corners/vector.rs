//! Vectors whose direction the field asks for, as dry friction in the plane asks for that of sliding.
//!
//! Let a be such a vector, n = a/|a|, and a' = g + C n. Where a is zero any l of the unit disc may be in the place of n; motion stays there
//! with l = -C^-1 g while |l| < 1. So a' = C (n - l), and where C is negative, as that of friction is, no other motion begins there. It
//! leaves as a = alpha n t where |l| > 1, with alpha n = C (n - l); and as a = alpha n t^2 + (alpha n_1 + beta n) t^3 + .. where l comes
//! to the circle and goes on beyond, n = l there, with n_1 at right angles to it, by
//!
//! ```text
//! 2 alpha n - C n_1 = -C l_1
//! 3 (beta n + alpha n_1) - C n_2 = -C l_2 + C_1 (n_1 - l_1)        n_2 = m - n |n_1|^2 / 2, m at right angles to n
//! ```
//!
//! coefficients being those of powers of t. With B what the components of n add to the field, the state is that of the motion that stays
//! and B C^-1 a, beside what that changes in the field, in its first order. Directions follow a stiff law, |a| n' = C (n - l) at right
//! angles to n: they soon forget what is left out of them, and their series beyond those terms diverges.

use super::Candidate;
use crate::expressions::Side;
use crate::flow::error::FlowError;
use crate::flow::modes::closed::Closed;
use crate::flow::modes::guard::GuardKind;
use crate::flow::modes::limits::Corner;
use crate::flow::modes::program::{Program, ProgramConstants};
use crate::flow::modes::standing::StandingTapes;
use crate::flow::step::resolve::{Resolution, expand_within_reach};
use crate::flow::step::{NO_EVENT, Workspace};
use crate::flow::system::System;
use crate::flow::touch::with_terms;
use crate::flow::trajectory::{StepResult, Trajectory};
use crate::numerics::linear::solve;
use crate::numerics::{Real, dot, two_sum};

/// Roots of the squared length of a vector where it is left along a straight line, and where with no rate.
const AT_ONCE: u8 = 2;
const SLOWLY: u8 = 4;

/// What is left out is as small as this power of the time that the first step takes.
const LEFT_OUT_AT_ONCE: f64 = 2.0;
const LEFT_OUT_SLOWLY: f64 = 4.0;

/// Directions follow forces within so short a part of the time in which those change that it takes this many steps over one by
/// which directions that have been left out are forgotten.
const SHORTEST: f64 = 1e-5;

/// More halvings than a number has digits.
const HALVINGS: usize = 256;

/// What a vector does that is zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Leaves {
    Stays,
    /// It leaves: its squared length has so many roots here.
    After(u8),
    Untold,
}

/// A guard that is the squared length of a vector which is being left, its surface, and roots.
type Left = (usize, u8);

/// What holds a vector at zero, at a state.
struct Holding<R> {
    l: Vec<R>,
    rate: Vec<R>,
    /// C, row by row.
    changes: Vec<Vec<R>>,
    /// Of each component of n what it adds to the field.
    directions: Vec<Vec<R>>,
}

/// The state with its remainders where a vector has these components.
type Displaced<'a, R> = dyn Fn(&[R]) -> Option<(Vec<R>, Vec<R>)> + 'a;

impl<R: Real> Holding<R> {
    fn at(tapes: &StandingTapes, constants: &[R], start: (&[R], &[R])) -> Option<Self> {
        let size = tapes.components.outputs.len();
        let values: Vec<R> = (with_terms(&tapes.holding, constants, start).into_iter())
            .map(|value| value.value)
            .collect();
        let coordinates = (values.len() / size.max(1)).checked_sub(size + 2)?;
        if coordinates == 0 || !values.iter().all(|value| value.is_finite()) {
            return None;
        }
        let (l, rest) = values.split_at(size);
        let (rate, rest) = rest.split_at(size);
        let (changes, directions) = rest.split_at(size * size);
        let rows = |of: &[R], width: usize| of.chunks(width).map(<[R]>::to_vec).collect();
        Some(Self {
            l: l.to_vec(),
            rate: rate.to_vec(),
            changes: rows(changes, size),
            directions: rows(directions, coordinates),
        })
    }

    /// Whether each component of n takes from its own.
    fn draws(&self) -> bool {
        (self.changes.iter().enumerate()).all(|(i, row)| row[i] < R::ZERO)
    }

    /// C times this.
    fn of(&self, vector: &[R]) -> Vec<R> {
        self.changes.iter().map(|row| dot(row, vector)).collect()
    }

    /// n and alpha with alpha n = C (n - l), where |l| > 1.
    fn at_once(&self) -> Option<(Vec<R>, R)> {
        let right = self.of(&self.l);
        let n = |alpha: R| {
            let mut rows = self.changes.clone();
            rows.iter_mut()
                .enumerate()
                .for_each(|(i, row)| row[i] -= alpha);
            solve(&rows, &right)
        };
        let is_long = |alpha: R| n(alpha).map(|n| dot(&n, &n) > R::ONE);
        // Without bound of it n would become shorter.
        let mut bracket = (
            R::ZERO,
            self.changes
                .iter()
                .flatten()
                .fold(R::ZERO, |m, c| m.max(c.abs())),
        );
        for _ in 0..HALVINGS {
            if !is_long(bracket.1)? {
                break;
            }
            bracket = (bracket.1, bracket.1 + bracket.1);
        }
        for _ in 0..HALVINGS {
            let middle = (bracket.0 + bracket.1) * R::splat(0.5);
            match is_long(middle)? {
                true => bracket.0 = middle,
                false => bracket.1 = middle,
            }
        }
        let n = n(bracket.1)?;
        (bracket.1 > R::ZERO).then_some((n, bracket.1))
    }

    /// alpha and m with `times` alpha n - C m = right, m at right angles to n.
    fn along(&self, n: &[R], times: f64, right: &[R]) -> Option<(R, Vec<R>)> {
        let mut rows: Vec<Vec<R>> = (self.changes.iter().zip(n))
            .map(|(row, &n)| {
                let first = n * R::splat(times);
                [first].into_iter().chain(row.iter().map(|&c| -c)).collect()
            })
            .collect();
        rows.push([R::ZERO].into_iter().chain(n.iter().copied()).collect());
        let mut right = right.to_vec();
        right.push(R::ZERO);
        let mut found = solve(&rows, &right)?;
        let m = found.split_off(1);
        Some((found[0], m))
    }

    /// What is added to the state with this vector, B C^-1 a.
    fn added(&self, a: &[R]) -> Option<Vec<R>> {
        let by = solve(&self.changes, a)?;
        let coordinates = self.directions.first()?.len();
        let sum = |i: usize| {
            let parts = by.iter().zip(&self.directions);
            parts.fold(R::ZERO, |sum, (&by, direction)| {
                by.mul_add(direction[i], sum)
            })
        };
        Some((0..coordinates).map(sum).collect())
    }
}

/// The mode that stays where a vector is zero.
struct Staying<'t, R> {
    program: &'t Program,
    constants: &'t ProgramConstants<R>,
    tapes: &'t StandingTapes,
    holding: &'t [R],
}

impl<R: Real> Staying<'_, R> {
    fn holding(&self, start: (&[R], &[R])) -> Option<Holding<R>> {
        Holding::at(self.tapes, self.holding, start)
    }

    fn field(&self, start: (&[R], &[R])) -> Vec<R> {
        let field = with_terms(&self.program.field, &self.constants.field, start);
        field.into_iter().map(|rate| rate.value).collect()
    }
}

impl<R: Real> Trajectory<R> {
    fn staying<'t>(
        &'t self,
        system: &'t System,
        mode: usize,
        surface: usize,
    ) -> Option<Staying<'t, R>> {
        let program = system.program(mode)?;
        let constants = self.constants.get(mode)?.as_ref()?;
        let found = |tapes: &StandingTapes| tapes.corner == Corner::Surface(surface);
        let place = program.standings.iter().position(found)?;
        Some(Staying {
            program,
            constants,
            tapes: &program.standings[place],
            holding: &constants.standings[place][4],
        })
    }

    /// The candidate that stays where touched vectors are zero which it leaves, if it leaves any: the direction of those has no value
    /// here, and what stays says how all else moves.
    pub(super) fn at_zeros(
        &self,
        system: &System,
        candidate: &Candidate,
        touched: &[Corner],
    ) -> Option<Candidate> {
        let left = touched.iter().filter_map(|&corner| match corner {
            Corner::Surface(index) if system.corners().is_disc(index) => Some(index),
            _ => None,
        });
        let staying = left.fold(candidate.clone(), |all, index| {
            all.with_side(index, Side::Sliding)
        });
        (staying != *candidate).then_some(staying)
    }

    /// What a vector does that is zero, all else being as in the candidate.
    pub(super) fn leaves_zero(
        &mut self,
        system: &System,
        surface: usize,
        candidate: &Candidate,
    ) -> Result<Leaves, FlowError> {
        let leaves = match self.try_sides(system, &candidate.with_side(surface, Side::Sliding))? {
            true => self.leaves_zero_here(system, surface)?,
            false => Leaves::Untold,
        };
        self.try_sides(system, candidate)?;
        Ok(leaves)
    }

    /// The same in the present mode, which stays there.
    fn leaves_zero_here(&mut self, system: &System, surface: usize) -> Result<Leaves, FlowError> {
        let holding = (self.staying(system, self.mode, surface))
            .and_then(|staying| staying.holding((&self.state, &self.low)));
        if !holding.is_some_and(|holding| holding.draws()) {
            return Ok(Leaves::Untold);
        }
        let standings = self.standings_on_surfaces(system)?;
        let own = standings
            .iter()
            .find(|s| s.corner == Corner::Surface(surface));
        let Some((own, (_, orders))) = own.and_then(|own| Some((own, own.guards.first()?))) else {
            return Ok(Leaves::Untold);
        };
        let (room, level) = (orders[0].value, own.level(orders));
        let moving = orders[1..]
            .iter()
            .position(|order| order.value.abs() > order.level());
        Ok(match moving {
            _ if !room.is_finite() => Leaves::Untold,
            _ if room > level => Leaves::Stays,
            _ if room < -level => Leaves::After(AT_ONCE),
            None => Leaves::Stays,
            Some(k) if orders[k + 1].value > R::ZERO => Leaves::Stays,
            Some(0) => Leaves::After(SLOWLY),
            Some(_) => Leaves::Untold,
        })
    }

    /// The vector that is zero here and is being left, if one is: its surface, and roots of its squared length.
    pub(in crate::flow::trajectory) fn vector_left(
        &self,
        system: &System,
        program: &Program,
    ) -> Option<Left> {
        let left = |(index, surface): (usize, usize)| {
            let roots = self.touching.get(index);
            matches!(roots, AT_ONCE | SLOWLY).then_some((surface, roots))
        };
        (program.guards.iter().enumerate())
            .filter_map(|(index, guard)| match guard.kind {
                GuardKind::Switch(surface) if system.corners().is_disc(surface) => {
                    Some((index, surface))
                }
                _ => None,
            })
            .find_map(left)
    }

    /// The step that leaves it.
    pub(in crate::flow::trajectory) fn leave_zero(
        &self,
        system: &System,
        work: &mut Workspace<R>,
        (surface, roots): Left,
    ) -> Result<StepResult<R>, FlowError> {
        let left = self.step_off_zero(system, work, (surface, roots));
        left.ok_or_else(|| match self.singular_near(system) {
            Some((_, singular)) => singular,
            None => self.left_domain(),
        })
    }

    fn step_off_zero(
        &self,
        system: &System,
        work: &mut Workspace<R>,
        (surface, roots): Left,
    ) -> Option<StepResult<R>> {
        let mode = system.meet(self.grip(), self.regime.with(surface, Side::Sliding));
        let staying = self.staying(system, mode, surface)?;
        let holding = staying.holding((&self.state, &self.low))?;
        let class = self.load(work);
        work.load_constants(staying.constants);
        work.tau = work.tau.max(self.longest_step);
        expand_within_reach(work, staying.program, class).ok()?;
        let reach = work.scaled_step * work.tau;
        let power = match roots {
            AT_ONCE => LEFT_OUT_AT_ONCE,
            _ => LEFT_OUT_SLOWLY,
        };
        let part = libm::pow(R::ROUNDOFF, 1.0 / power);
        let changes = dot(&holding.rate, &holding.rate).sqrt();
        let longest = match roots {
            AT_ONCE => reach,
            // There is no start from which all thirty digits could be had.
            _ if part < SHORTEST => return None,
            _ => reach.min(R::ONE / changes),
        };
        let step = (longest * R::splat(part)).max(self.negligible() * R::splat(2.0));
        let step = step.min(work.horizon);
        work.scaled_step = step / work.tau;
        work.event = R::splat(NO_EVENT);
        work.travel();
        let size = self.coordinates;
        let still = (work.state.clone(), work.low.clone());
        let at = |a: &[R]| -> Option<(Vec<R>, Vec<R>)> {
            let (mut state, mut low) = still.clone();
            for ((x, low), by) in state.iter_mut().zip(&mut low).zip(holding.added(a)?) {
                (*x, *low) = two_sum(*x, *low + by);
            }
            Some((state, low))
        };
        let scaled = |of: &[R], by: R| -> Vec<R> { of.iter().map(|&x| x * by).collect() };
        let (a, share) = match roots {
            AT_ONCE => {
                let (n, alpha) = holding.at_once()?;
                (scaled(&n, alpha * step), 0.5)
            }
            _ => (
                self.leave_slowly(&staying, &holding, (&at, step))?,
                1.0 / 3.0,
            ),
        };
        let (mut state, mut low) = at(&a)?;
        let [with, without] = [(&state, &low), (&still.0, &still.1)]
            .map(|(state, low)| staying.field((&state[..size], &low[..size])));
        for (((x, low), with), without) in (state.iter_mut().zip(&mut low)).zip(with).zip(without) {
            (*x, *low) = two_sum(*x, *low + (with - without) * step * R::splat(share));
        }
        (work.state, work.low) = (state, low);
        work.reach.iter_mut().for_each(|reach| *reach = step);
        work.state
            .iter()
            .all(|x| x.is_finite())
            .then(|| StepResult {
                crowd: Closed::NONE,
                gap: None,
                ..self.result(work)
            })
    }

    /// The vector after a short time where what is in place of its direction has come to the circle, and goes on.
    fn leave_slowly(
        &self,
        staying: &Staying<'_, R>,
        holding: &Holding<R>,
        (at, step): (&Displaced<'_, R>, R),
    ) -> Option<Vec<R>> {
        let length = dot(&holding.l, &holding.l).sqrt();
        let n: Vec<R> = holding.l.iter().map(|&l| l / length).collect();
        let right: Vec<R> = holding.of(&holding.rate).into_iter().map(|c| -c).collect();
        let (alpha, first) = holding.along(&n, 2.0, &right)?;
        if alpha <= R::ZERO {
            return None;
        }
        let square = step * step;
        let begun: Vec<R> = n.iter().map(|&n| n * alpha * square).collect();
        let (state, low) = at(&begun)?;
        let there = staying.holding((&state, &low))?;
        let off: Vec<R> = first
            .iter()
            .zip(&holding.rate)
            .map(|(&n, &l)| n - l)
            .collect();
        let second: Vec<R> = (0..n.len())
            .map(|i| {
                let bend = (there.l[i] - holding.l[i] - holding.rate[i] * step) / square;
                n[i].mul_add(dot(&first, &first) * R::splat(0.5), bend)
            })
            .collect();
        let (of_second, changed, known) = (holding.of(&second), there.of(&off), holding.of(&off));
        let right: Vec<R> = (0..n.len())
            .map(|i| {
                let by_change = (changed[i] - known[i]) / step;
                by_change - of_second[i] - first[i] * alpha * R::splat(3.0)
            })
            .collect();
        let (beta, _) = holding.along(&n, 3.0, &right)?;
        let cubic = |i: usize| n[i].mul_add(beta, first[i] * alpha) * step;
        Some(
            (0..n.len())
                .map(|i| n[i].mul_add(alpha, cubic(i)) * square)
                .collect(),
        )
    }

    /// Where a vector has come to zero but for a time that is shorter than rounding. The state stays: there the direction is known yet.
    pub(in crate::flow::trajectory) fn come_to_zero(
        &self,
        system: &System,
        work: &mut Workspace<R>,
        (guard, after): (usize, R),
    ) -> Resolution {
        work.scaled_step = R::ZERO;
        work.event = R::splat(guard as f64);
        work.travel();
        work.step = after * work.tau;
        if let Some(clock) = system.model().time {
            let (x, low) = (work.state[clock], work.low[clock]);
            (work.state[clock], work.low[clock]) = two_sum(x, low + work.step);
        }
        Resolution {
            touched: None,
            shortened: true,
            jumped: false,
        }
    }
}
