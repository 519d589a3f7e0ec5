//! Which sides and pieces follow at corners that the state lies on: all that could are asked whether they hold.

use super::Candidate;
use super::options::Choice;
use super::verdict::Verdict;
use crate::expressions::{Side, Sides, Surfaces};
use crate::flow::error::FlowError;
use crate::flow::modes::closed::Closed;
use crate::flow::modes::limits::Corner;
use crate::flow::modes::standing::STANDING_ORDERS;
use crate::flow::system::System;
use crate::flow::touch::with_terms;
use crate::flow::trajectory::{NoDerivative, Trajectory};
use crate::numerics::{Real, WithTerms, two_sum};

/// So many modes are asked at once at a corner of several surfaces, not more.
const MOST_CANDIDATES: usize = 81;

/// So often each of more corners is asked beside the others.
const MOST_ROUNDS: usize = 64;

/// A field here, and where the state may be as well.
pub(super) type Fields<R> = [Vec<WithTerms<R>>; 2];

/// What modes are asked by, and what asking them has shown beside their verdicts.
#[derive(Debug)]
pub(super) struct Asked<R> {
    /// The state, with its remainders, an instant later on the motion that met the corner: it is known no better.
    pub(super) later: (Vec<R>, Vec<R>),
    /// The surfaces that have been slid along, and what could not be told from zero of each: what rounding has left beside one is no
    /// motion beyond another corner either, where that is all that is left of its terms.
    held: Vec<(Corner, R)>,
    /// Surfaces that may be slid along, as the fields on their sides differ or are about to.
    pub(super) slippery: Surfaces,
    /// The largest size of each component of the fields that modes have: what is left of some is rounding of others, though it may be a
    /// constant that does not say so.
    pub(super) largest: Vec<R>,
    /// Likewise of the function of each corner, and of its derivatives, along these fields.
    fastest: Vec<(Corner, [R; STANDING_ORDERS])>,
    /// Some would leave a table.
    pub(super) outside: Option<FlowError>,
    /// The equations of some are singular here.
    pub(super) singular: Option<FlowError>,
}

impl<R: Real> Asked<R> {
    /// What could not be told from zero of a surface that has been slid along; of others nothing.
    pub(super) fn held(&self, corner: Corner) -> R {
        let of = self.held.iter().find(|(held, _)| *held == corner);
        of.map_or(R::ZERO, |&(_, level)| level)
    }

    /// What is rounding of the function of a corner, and of its derivatives, beside what they are in other modes.
    pub(super) fn rounding(&self, corner: Corner) -> [R; STANDING_ORDERS] {
        let of = self.fastest.iter().find(|(known, _)| *known == corner);
        of.map_or([R::ZERO; STANDING_ORDERS], |(_, most)| {
            most.map(|most| WithTerms::exact(most).level())
        })
    }

    /// Takes note of the function of a corner, and of its derivatives, in a mode.
    pub(super) fn note(&mut self, corner: Corner, orders: &[WithTerms<R>; STANDING_ORDERS]) {
        let known = self.fastest.iter().position(|(known, _)| *known == corner);
        let place = known.unwrap_or_else(|| {
            self.fastest.push((corner, [R::ZERO; STANDING_ORDERS]));
            self.fastest.len() - 1
        });
        for (most, order) in self.fastest[place].1.iter_mut().zip(orders) {
            if order.value.is_finite() {
                *most = most.max(order.value.abs());
            }
        }
    }
}

impl<R: Real> Trajectory<R> {
    /// Chooses sides at corners that the state lies on.
    pub(super) fn choose_sides(
        &mut self,
        system: &System,
        (touched, met): (&[Corner], Option<Corner>),
    ) -> Result<(), FlowError> {
        let now = self.standing_sides();
        let held = (self.standings(system)?.iter())
            .filter(|s| matches!(s.corner, Corner::Surface(k) if now.side(k) == Side::Sliding))
            .map(|standing| (standing.corner, standing.surface.level()))
            .collect();
        let mut asked = Asked {
            later: self.an_instant_later(system)?,
            held,
            largest: vec![R::ZERO; self.state.len()],
            fastest: Vec::new(),
            slippery: Surfaces::default(),
            outside: None,
            singular: None,
        };
        // A corner that is touched only in some of the modes has its own options there.
        let mut touched = touched.to_vec();
        let verdicts = loop {
            touched.sort_by_key(|&corner| system.corner_expr(corner));
            let all = self.candidates(system, (&touched, met), &now, &mut asked)?;
            let candidates = match all {
                Some(all) => all,
                None => vec![self.one_by_one(system, (&touched, met), &now, &mut asked)?],
            };
            let mut verdicts: Vec<Verdict<R>> = Vec::new();
            let mut more = None;
            // Where bodies hold each other forces cancel: what is left of them is told from rounding by what they are in other modes.
            let rounds = if self.closed == Closed::NONE { 1 } else { 2 };
            for _ in 0..rounds {
                verdicts.clear();
                for candidate in &candidates {
                    if !self.ask_beside(system, candidate, (&touched, &mut asked))? {
                        continue;
                    }
                    let standings = self.standings(system)?;
                    more = (standings.iter())
                        .find(|s| !touched.contains(&s.corner) && self.is_touched(system, s))
                        .map(|standing| standing.corner)
                        .or(more);
                    let candidate = self.standing_sides();
                    verdicts.extend(self.verdict(system, candidate, (&touched, &mut asked))?);
                }
            }
            let Some(more) = more else { break verdicts };
            touched.push(more);
        };
        self.take_verdict(system, verdicts, (&now, &touched), asked)
    }

    /// Enters the one mode that says of itself that it holds.
    fn take_verdict(
        &mut self,
        system: &System,
        mut verdicts: Vec<Verdict<R>>,
        (now, touched): (&Candidate, &[Corner]),
        mut asked: Asked<R>,
    ) -> Result<(), FlowError> {
        // What comes to rest by ever shorter swings, as preloads bring it to, has a rate in the end that the accelerations of both sides
        // undo within a rounding of the time: by that it leads nowhere.
        let rests = (verdicts.iter()).fold(Surfaces::default(), |all, v| all.or(v.rests));
        verdicts.retain(|v| v.comes_back.without(rests) == v.comes_back);
        if verdicts.iter().any(|verdict| verdict.contacts_stay) {
            verdicts.retain(|verdict| verdict.contacts_stay);
        } else {
            self.forget_what_lets_go(system, &mut verdicts, now);
        }
        forget_what_may_push(&mut verdicts);
        // Where a root begins as they open there is none until then.
        if verdicts.iter().any(|v| v.opens_there && v.is_smooth) {
            verdicts.retain(|verdict| verdict.opens_there);
        }
        let agree = (verdicts.iter()).all(|v| {
            let noise = asked.largest.iter().map(|&f| WithTerms::exact(f).level());
            let differ = |((a, b), noise): ((&WithTerms<R>, &WithTerms<R>), R)| {
                (a.value - b.value).abs() > noise
            };
            let [own, first] = [v, &verdicts[0]].map(|verdict| &verdict.fields);
            vanishes(own, first) || !own[0].iter().zip(&first[0]).zip(noise).any(differ)
        });
        // Bodies that touch at rest, as if they did not: a force that begins as a root of how far they are pressed has no series there.
        if agree && verdicts.iter().any(|verdict| verdict.is_smooth) {
            verdicts.retain(|verdict| verdict.is_smooth);
        }
        if verdicts.len() > 1 && !agree {
            self.forget_what_presses(system, &mut verdicts, (touched, &mut asked))?;
        }
        let place = match verdicts.len() {
            0 => {
                self.try_sides(system, now)?;
                return Err(asked
                    .outside
                    .or(asked.singular)
                    .or_else(|| self.rest_on_kink(system, touched))
                    .unwrap_or_else(|| self.no_mode(system, touched)));
            }
            1 => 0,
            _ => {
                let current = verdicts.iter().position(|v| v.candidate == *now);
                let mut plain = (0..verdicts.len()).filter(|&place| verdicts[place].is_plain);
                match (current, plain.next(), plain.next()) {
                    (Some(place), ..) if agree || verdicts[place].is_balanced => place,
                    _ if agree => 0,
                    (_, Some(place), None) => place,
                    _ => {
                        self.try_sides(system, now)?;
                        return Err(FlowError::NotUnique {
                            time: self.time.to_f64(),
                            surfaces: names(system, touched),
                        });
                    }
                }
            }
        };
        let verdict = verdicts.swap_remove(place);
        if system.gaps_have_corners()
            && self.try_sides(system, now)?
            && let Some(refused) = self.leaves_kink(system, (now, &verdict.candidate))?
        {
            return Err(refused);
        }
        self.try_sides(system, &verdict.candidate)?;
        for (kind, roots) in verdict.roots {
            self.touch(system, kind, roots);
        }
        if self.carries_columns()
            && let Some((surface, _)) = self.vector_left(system, self.program(system)?)
        {
            self.no_derivative = Some(NoDerivative::Direction(surface));
        }
        // A rounding error beside what is slid along from here on would be a side.
        self.stay_on_surfaces(system)?;
        self.rest_on_surfaces(system, &verdict.lies_beside);
        Ok(())
    }

    /// Of verdicts in flight those that would press the contact which is at rest here hold only if they do so with it closed.
    fn forget_what_presses(
        &mut self,
        system: &System,
        verdicts: &mut Vec<Verdict<R>>,
        (touched, asked): (&[Corner], &mut Asked<R>),
    ) -> Result<(), FlowError> {
        if self.closed != Closed::NONE {
            return Ok(());
        }
        let mut kept = Vec::new();
        for verdict in verdicts.drain(..) {
            if self.try_sides(system, &verdict.candidate)?
                && let Some(contact) = self.presses_at_rest(system)?
            {
                self.enter(system, Closed::NONE.with(contact))?;
                let sides = self.standing_sides();
                let holds = self.verdict(system, sides, (touched, asked))?;
                self.enter(system, Closed::NONE)?;
                if holds.is_none_or(|held| !held.contacts_stay) {
                    continue;
                }
            }
            kept.push(verdict);
        }
        *verdicts = kept;
        Ok(())
    }

    /// The one contact that is at rest here, if the present mode, in which it is open, would close it.
    fn presses_at_rest(&self, system: &System) -> Result<Option<usize>, FlowError> {
        let mut pressed = None;
        for contact in 0..system.contacts() {
            let [gap, rate, acceleration, _] = self.local_values(system, contact)?;
            if gap.value.abs() > gap.level() || rate.value.abs() > rate.level() {
                continue;
            }
            if pressed.is_some() {
                return Ok(None);
            }
            pressed = Some((contact, acceleration.value < -acceleration.level()));
        }
        Ok(pressed.and_then(|(contact, is_pressed)| is_pressed.then_some(contact)))
    }

    /// What contacts rub that do not stay says nothing of the motion that follows: of verdicts that differ in nothing else one is left,
    /// on the side that it was on where there is such.
    fn forget_what_lets_go(
        &self,
        system: &System,
        verdicts: &mut Vec<Verdict<R>>,
        now: &Candidate,
    ) {
        let carrying = self.grip().carrying();
        let rubbed = |candidate: &Candidate| {
            let of_carrying = system
                .rubbing()
                .iter()
                .filter(|r| carrying.contains(r.contact));
            of_carrying.fold(candidate.clone(), |free, r| {
                free.with_side(r.surface, Side::Above)
            })
        };
        let stays = |verdict: &Verdict<R>| verdict.candidate.sides == now.sides;
        verdicts.sort_by_key(|verdict| !stays(verdict));
        let mut kept: Vec<Candidate> = Vec::new();
        verdicts.retain(|verdict| {
            let free = rubbed(&verdict.candidate);
            let is_new = !kept.contains(&free);
            kept.extend(is_new.then_some(free));
            is_new
        });
    }

    /// All combinations of what may become of corners that are touched, those within others first: what a corner is a
    /// function of may jump at them. None where they are too many.
    fn candidates(
        &mut self,
        system: &System,
        (touched, met): (&[Corner], Option<Corner>),
        now: &Candidate,
        asked: &mut Asked<R>,
    ) -> Result<Option<Vec<Candidate>>, FlowError> {
        // Each has two sides at least.
        if touched.len() > MOST_CANDIDATES.ilog2() as usize {
            return Ok(None);
        }
        let mut candidates = vec![now.clone()];
        for &corner in touched {
            let mut wider: Vec<Candidate> = Vec::new();
            for mut base in candidates {
                // What is slid along may be so on the right sides of other corners only.
                if self.ask_beside(system, &base, (touched, asked))? {
                    base = self.standing_sides();
                }
                let options = self.options(system, (corner, met), &base, (touched, asked))?;
                for option in options {
                    wider.push(self.choose(system, (option, &base), (touched, asked))?);
                }
            }
            if wider.len() > MOST_CANDIDATES {
                return Ok(None);
            }
            candidates = wider;
        }
        // What one corner brings into use, as a clock that puts on a brake does friction, may be slid along on that side of it only.
        let mut place = 0;
        while touched.len() > 1 && place < candidates.len() {
            let base = candidates[place].clone();
            for &corner in touched {
                if matches!(corner, Corner::Surface(k) if base.side(k) == Side::Sliding)
                    || !self.ask_beside(system, &base, (touched, asked))?
                {
                    continue;
                }
                let options = self.options(system, (corner, met), &base, (touched, asked))?;
                let slides = (options.iter()).find(|o| matches!(o, Choice::Side(_, Side::Sliding)));
                if let Some(&slides) = slides {
                    let slides = self.choose(system, (slides, &base), (touched, asked))?;
                    if !candidates.contains(&slides) {
                        candidates.push(slides);
                    }
                }
            }
            if candidates.len() > MOST_CANDIDATES {
                return Ok(None);
            }
            place += 1;
        }
        candidates.retain(|candidate| self.slide_alike(system, candidate.sides));
        Ok(Some(candidates))
    }

    /// The combination that holds corner by corner, found from the one that slides along all it can: each takes what holds beside the
    /// others until none changes, as bodies in a row do that rub. Whether it holds as a whole is asked like of any other.
    fn one_by_one(
        &mut self,
        system: &System,
        (touched, met): (&[Corner], Option<Corner>),
        now: &Candidate,
        asked: &mut Asked<R>,
    ) -> Result<Candidate, FlowError> {
        let mut found = now.clone();
        for &corner in touched {
            if matches!(corner, Corner::Surface(index) if now.side(index) == Side::Sliding) {
                continue;
            }
            let options = self.options(system, (corner, met), &found, (touched, asked))?;
            let slides = (options.iter()).find(|o| matches!(o, Choice::Side(_, Side::Sliding)));
            if let Some(&slides) = slides {
                found = self.choose(system, (slides, &found), (touched, asked))?;
            }
        }
        for _ in 0..MOST_ROUNDS {
            let before = found.clone();
            for &corner in touched {
                if self.holds_for(system, &found, (corner, touched, asked))? {
                    continue;
                }
                for option in self.options(system, (corner, met), &found, (touched, asked))? {
                    let option = self.choose(system, (option, &found), (touched, asked))?;
                    if self.holds_for(system, &option, (corner, touched, asked))? {
                        found = option;
                        break;
                    }
                }
            }
            if found == before {
                break;
            }
        }
        Ok(found)
    }

    /// Whether a candidate holds as far as one of the corners goes.
    fn holds_for(
        &mut self,
        system: &System,
        candidate: &Candidate,
        (corner, touched, asked): (Corner, &[Corner], &mut Asked<R>),
    ) -> Result<bool, FlowError> {
        if !self.ask_beside(system, candidate, (touched, asked))? {
            return Ok(false);
        }
        let verdict = self.verdict(system, candidate.clone(), (&[corner], asked))?;
        Ok(verdict.is_some())
    }

    /// Whether contacts that carry and rub by one rate slide one way, or stick all.
    fn slide_alike(&self, system: &System, sides: Sides) -> bool {
        let carrying = self.grip().carrying();
        let rubbing = (system.rubbing().iter()).filter(|rubs| carrying.contains(rubs.contact));
        let rate = |surface: usize| system.corner_expr(Corner::Surface(surface));
        rubbing.clone().all(|one| {
            rubbing.clone().all(|other| {
                rate(one.surface) != rate(other.surface)
                    || sides.get(one.surface) == sides.get(other.surface)
            })
        })
    }

    /// As [`try_sides`](Self::try_sides); a piece beyond the end of a table is none, and noted.
    pub(super) fn ask(
        &mut self,
        system: &System,
        candidate: &Candidate,
        asked: &mut Asked<R>,
    ) -> Result<bool, FlowError> {
        match self.try_sides(system, candidate) {
            Err(outside @ FlowError::OutsideTable { .. }) => {
                asked.outside = Some(outside);
                Ok(false)
            }
            tried => tried,
        }
    }

    /// As [`ask`](Self::ask), with all other corners put right.
    pub(super) fn ask_beside(
        &mut self,
        system: &System,
        candidate: &Candidate,
        (touched, asked): (&[Corner], &mut Asked<R>),
    ) -> Result<bool, FlowError> {
        Ok(self.ask(system, candidate, asked)? && self.pass_others(system, touched, asked)?)
    }

    /// Puts the present candidate right where it says that other corners are clearly passed. Whether that is possible.
    fn pass_others(
        &mut self,
        system: &System,
        touched: &[Corner],
        asked: &mut Asked<R>,
    ) -> Result<bool, FlowError> {
        let count = system.corners().surfaces.len() + system.corners().lookups.len();
        for _ in 0..count {
            let standings = self.standings(system)?;
            let others = (standings.iter()).filter(|s| !touched.contains(&s.corner));
            let Some(further) = others.filter_map(|s| self.beyond(system, s)).next() else {
                break;
            };
            if !self.ask(system, &further, asked)? {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// The state, with its remainders, so long after a corner has been met as may be until it is: where none was met, the state itself.
    fn an_instant_later(&self, system: &System) -> Result<(Vec<R>, Vec<R>), FlowError> {
        let field = self.field_at(system, (&self.state, &self.low))?;
        Ok(match self.met {
            Some(_) if field.iter().all(|f| f.value.is_finite()) => {
                self.after(self.instant(), &field)
            }
            _ => (self.state.clone(), self.low.clone()),
        })
    }

    /// The state, with its remainders, after so short a time along a field.
    pub(super) fn after(&self, time: R, field: &[WithTerms<R>]) -> (Vec<R>, Vec<R>) {
        let (mut state, mut low) = (self.state.clone(), self.low.clone());
        for ((x, low), f) in state.iter_mut().zip(&mut low).zip(field) {
            (*x, *low) = two_sum(*x, f.value.mul_add(time, *low));
        }
        (state, low)
    }

    /// The field of the present mode at the state, and an instant later.
    pub(super) fn fields_here(
        &self,
        system: &System,
        asked: &Asked<R>,
    ) -> Result<Fields<R>, FlowError> {
        let here = self.field_at(system, (&self.state, &self.low))?;
        let later = self.field_at(system, (&asked.later.0, &asked.later.1))?;
        Ok([here, later])
    }

    /// The field of the present mode at another state.
    fn field_at(
        &self,
        system: &System,
        start: (&[R], &[R]),
    ) -> Result<Vec<WithTerms<R>>, FlowError> {
        let program = self.program(system)?;
        let Some(constants) = &self.constants[self.mode] else {
            return Ok(Vec::new());
        };
        Ok(with_terms(&program.field, &constants.field, start))
    }

    fn no_mode(&self, system: &System, touched: &[Corner]) -> FlowError {
        let is_lookup = |corner: &&Corner| matches!(corner, Corner::Lookup(_));
        if let Some(&lookup) = touched.iter().find(is_lookup) {
            return FlowError::HeldAtLookup {
                time: self.time.to_f64(),
                argument: system.corner_name(lookup),
            };
        }
        FlowError::NoMode {
            time: self.time.to_f64(),
            surfaces: names(system, touched),
        }
    }
}

/// Of modes of one motion those are left in which all contacts push, and of these the ones in which most stick that do not slide: they
/// say when it ends.
fn forget_what_may_push<R: Real>(verdicts: &mut Vec<Verdict<R>>) {
    let is_behind: Vec<bool> = (verdicts.iter())
        .map(|verdict| {
            let rank = |verdict: &Verdict<R>| (!verdict.contacts_push, verdict.loose);
            let mut others = (verdicts.iter()).filter(|other| rank(other) < rank(verdict));
            others.any(|other| vanishes(&other.fields, &verdict.fields))
        })
        .collect();
    let mut places = is_behind.into_iter();
    verdicts.retain(|_| places.next() == Some(false));
}

/// Whether two fields move the state alike: their difference is rounding, or no larger than what an
/// instant changes it by.
pub(super) fn vanishes<R: Real>(a: &Fields<R>, b: &Fields<R>) -> bool {
    let later = a[1].iter().zip(&b[1]);
    (a[0].iter().zip(&b[0]).zip(later)).all(|((a, b), (a_later, b_later))| {
        let (now, then) = (a.value - b.value, a_later.value - b_later.value);
        now.abs() <= change(now, then).max(a.level() + b.level())
    })
}

/// By how much an instant changes a number; of one that has no value then nothing is known.
pub(super) fn change<R: Real>(now: R, then: R) -> R {
    let change = (then - now).abs();
    if change.is_finite() { change } else { R::ZERO }
}

fn names(system: &System, corners: &[Corner]) -> Vec<String> {
    corners
        .iter()
        .map(|&corner| system.corner_name(corner))
        .collect()
}
