//! Which sides and pieces follow at corners that the state lies on: all that could are asked whether they hold.

use super::{Candidate, INSTANT_ROUNDOFFS, Standing};
use crate::expressions::{Operand, Side, Sides, Surfaces};
use crate::flow::error::FlowError;
use crate::flow::guard::GuardKind;
use crate::flow::limits::Corner;
use crate::flow::program::STANDING_ORDERS;
use crate::flow::system::System;
use crate::flow::touch::with_terms;
use crate::flow::touching::Touching;
use crate::flow::trajectory::Trajectory;
use crate::numerics::{Real, WithTerms, two_sum};
use core::cmp::Ordering;

/// So many modes are asked at once at a corner of several surfaces, not more.
const MOST_CANDIDATES: usize = 81;

/// So often each of more corners is asked beside the others.
const MOST_ROUNDS: usize = 64;

/// A surface that may jump, and is so many times what cannot be told from zero, has jumped.
const JUMPS: f64 = 1024.0;

/// What may become of one corner.
#[derive(Clone, Copy, Debug)]
enum Choice {
    /// The side of a surface.
    Side(usize, Side),
    /// The piece of a lookup.
    Piece(usize, i64),
}

impl Choice {
    fn made(self, base: &Candidate) -> Candidate {
        let mut candidate = base.clone();
        match self {
            Self::Side(index, side) => candidate.sides = candidate.sides.with(index, side),
            Self::Piece(index, piece) => candidate.pieces[index] = piece,
        }
        candidate
    }
}

/// A field here, and where the state may be as well.
type Fields<R> = [Vec<WithTerms<R>>; 2];

/// What modes are asked by, and what asking them has shown beside their verdicts.
#[derive(Debug)]
struct Asked<R> {
    /// The state, with its remainders, an instant later on the motion that met the corner: it is known no better.
    later: (Vec<R>, Vec<R>),
    /// Surfaces that may be slid along, as the fields on their sides differ or are about to.
    slippery: Surfaces,
    /// Some would leave a table.
    outside: Option<FlowError>,
    /// The equations of some are singular here.
    singular: Option<FlowError>,
}

/// What a candidate says of the corners that are touched.
struct Verdict<R> {
    candidate: Candidate,
    /// Roots of its guards at the present state.
    roots: Vec<(GuardKind, u8)>,
    /// Nothing moves it off a corner.
    is_balanced: bool,
    /// Contacts that are closed stay so at least at first.
    contacts_stay: bool,
    /// On surfaces that closed contacts keep it on it is on the side that it leaves to with them; and they stick, if they can.
    opens_there: bool,
    /// On corners that nothing moves it off it is where plain evaluation says.
    is_plain: bool,
    /// Of what vanishes at corners that nothing moves it off it takes no root.
    is_smooth: bool,
    fields: Fields<R>,
}

impl<R: Real> Trajectory<R> {
    /// Chooses sides at corners that the state lies on.
    pub(super) fn choose_sides(
        &mut self,
        system: &System,
        (touched, met): (&[Corner], Option<Corner>),
    ) -> Result<(), FlowError> {
        let now = self.standing_sides();
        let mut asked = Asked {
            later: self.an_instant_later(system)?,
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
            for candidate in candidates {
                if !self.ask_beside(system, &candidate, (&touched, &mut asked))? {
                    continue;
                }
                let standings = self.standings(system)?;
                more = (standings.iter())
                    .find(|s| !touched.contains(&s.corner) && self.is_touched(s))
                    .map(|standing| standing.corner)
                    .or(more);
                let candidate = self.standing_sides();
                verdicts.extend(self.verdict(system, candidate, (&touched, &mut asked))?);
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
        asked: Asked<R>,
    ) -> Result<(), FlowError> {
        if verdicts.iter().any(|verdict| verdict.contacts_stay) {
            verdicts.retain(|verdict| verdict.contacts_stay);
        }
        if verdicts.iter().any(|verdict| verdict.opens_there) {
            verdicts.retain(|verdict| verdict.opens_there);
        }
        let agree = (verdicts.iter()).all(|v| vanishes(&v.fields, &verdicts[0].fields));
        // Bodies that touch at rest, as if they did not: a force that begins as a root of how far they are pressed has no series there.
        if agree && verdicts.iter().any(|verdict| verdict.is_smooth) {
            verdicts.retain(|verdict| verdict.is_smooth);
        }
        let place = match verdicts.len() {
            0 => {
                self.try_sides(system, now)?;
                return Err(asked
                    .outside
                    .or(asked.singular)
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
        self.try_sides(system, &verdict.candidate)?;
        for (kind, roots) in verdict.roots {
            self.touch(system, kind, roots);
        }
        // A rounding error beside what is slid along from here on would be a side.
        self.stay_on_surfaces(system)
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
                wider.extend(options.into_iter().map(|option| option.made(&base)));
            }
            if wider.len() > MOST_CANDIDATES {
                return Ok(None);
            }
            candidates = wider;
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
            if let Some(slides) = slides {
                found = slides.made(&found);
            }
        }
        for _ in 0..MOST_ROUNDS {
            let before = found.clone();
            for &corner in touched {
                if self.holds_for(system, &found, (corner, touched, asked))? {
                    continue;
                }
                for option in self.options(system, (corner, met), &found, (touched, asked))? {
                    let option = option.made(&found);
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
    fn ask(
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
    fn ask_beside(
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

    /// Whether the field differs on the two sides of a surface, so that it may be slid along; all else as in `base`.
    fn jumps(
        &mut self,
        system: &System,
        index: usize,
        (base, touched, asked): (&Candidate, &[Corner], &mut Asked<R>),
    ) -> Result<bool, FlowError> {
        if let Some(rubs) = system.rubbing().iter().find(|r| r.surface == index) {
            return Ok(self.grip().carrying().contains(rubs.contact));
        }
        let agree = |fields: &[Fields<R>]| match fields {
            [above, below] => Some(vanishes(above, below)),
            _ => None,
        };
        let mut known = agree(&self.fields_beside(system, index, (base, touched, asked))?);
        let free = base.sliding_nowhere();
        if known != Some(false) && free != *base {
            // What is slid along elsewhere may be so on one of these sides only, or hide the jump: of three bodies that hold each
            // other one pair is at rest whatever rubs between them.
            known = agree(&self.fields_beside(system, index, (&free, touched, asked))?).or(known);
        }
        match known {
            Some(true) => self.is_held_by_nothing(system, index, (base, touched, asked)),
            _ => Ok(true),
        }
    }

    /// The fields on the sides of a surface, as far as there are modes.
    fn fields_beside(
        &mut self,
        system: &System,
        index: usize,
        (base, touched, asked): (&Candidate, &[Corner], &mut Asked<R>),
    ) -> Result<Vec<Fields<R>>, FlowError> {
        let mut fields = Vec::with_capacity(2);
        for side in [Side::Above, Side::Below] {
            if self.ask_beside(system, &base.with_side(index, side), (touched, asked))? {
                fields.push(self.fields_here(system, asked)?);
            }
        }
        Ok(fields)
    }

    /// The state, with its remainders, so long after a corner has been met as may be until it is: where none was met, the state itself.
    fn an_instant_later(&self, system: &System) -> Result<(Vec<R>, Vec<R>), FlowError> {
        let field = self.field_at(system, (&self.state, &self.low))?;
        Ok(match self.met {
            Some(_) if field.iter().all(|f| f.value.is_finite()) => {
                self.after(self.negligible() * R::splat(INSTANT_ROUNDOFFS), &field)
            }
            _ => (self.state.clone(), self.low.clone()),
        })
    }

    /// The state, with its remainders, after so short a time along a field.
    fn after(&self, time: R, field: &[WithTerms<R>]) -> (Vec<R>, Vec<R>) {
        let (mut state, mut low) = (self.state.clone(), self.low.clone());
        for ((x, low), f) in state.iter_mut().zip(&mut low).zip(field) {
            (*x, *low) = two_sum(*x, f.value.mul_add(time, *low));
        }
        (state, low)
    }

    /// Whether sliding along a surface on which both fields agree is not at its end, as where friction begins that has nothing to hold
    /// yet: its share of either side is no quotient of what vanishes.
    fn is_held_by_nothing(
        &mut self,
        system: &System,
        index: usize,
        (base, touched, asked): (&Candidate, &[Corner], &mut Asked<R>),
    ) -> Result<bool, FlowError> {
        let candidate = base.with_side(index, Side::Sliding);
        if !self.ask_beside(system, &candidate, (touched, asked))? {
            return Ok(false);
        }
        let standings = self.standings(system)?;
        let own = (standings.iter()).find(|s| s.corner == Corner::Surface(index));
        Ok(own.is_some_and(|own| {
            let lasts = |(_, orders): &(_, [WithTerms<R>; STANDING_ORDERS])| {
                let is_smooth = orders.iter().all(|order| order.value.is_finite());
                is_smooth && orders[0].value > own.level(orders)
            };
            !own.guards.is_empty() && own.guards.iter().all(lasts)
        }))
    }

    /// The field of the present mode at the state, and an instant later.
    fn fields_here(&self, system: &System, asked: &Asked<R>) -> Result<Fields<R>, FlowError> {
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

    /// What may become of one corner beside what `base` has chosen, the sides first.
    fn options(
        &mut self,
        system: &System,
        (corner, met): (Corner, Option<Corner>),
        base: &Candidate,
        (touched, asked): (&[Corner], &mut Asked<R>),
    ) -> Result<Vec<Choice>, FlowError> {
        match corner {
            Corner::Surface(index) => {
                let jumps = self.jumps(system, index, (base, touched, &mut *asked))?;
                if jumps {
                    asked.slippery = asked.slippery.with(index);
                }
                let sides = [Side::Above, Side::Below, Side::Sliding];
                let possible = &sides[..if jumps { 3 } else { 2 }];
                Ok((possible.iter())
                    .map(|&side| Choice::Side(index, side))
                    .collect())
            }
            Corner::Lookup(index) => {
                let stays = vec![Choice::Piece(index, base.pieces[index])];
                if !self.ask(system, base, asked)? {
                    return Ok(stays);
                }
                let standings = self.standings(system)?;
                let Some(own) = standings.iter().find(|s| s.corner == corner) else {
                    return Ok(stays);
                };
                // A knot that cannot be told from the argument is as large as that.
                let level = own.surface_level() * R::splat(2.0);
                let level = level.max(R::splat(f64::MIN_POSITIVE));
                let (graph, corners) = (&system.model().graph, system.corners());
                let at = |value: R| corners.piece_at(graph, index, value.to_double_double());
                let value = own.surface.value;
                let mut near = vec![base.pieces[index]];
                near.retain(|&piece| at(value - level) <= piece && piece <= at(value + level));
                near.extend([at(value - level), at(value), at(value + level)]);
                if met == Some(corner) && near.iter().all(|&piece| piece == base.pieces[index]) {
                    // The end that is nearer, where rounding says that neither is reached.
                    let gaps = own
                        .guards
                        .iter()
                        .map(|(_, orders)| orders[0].value.to_f64());
                    let gaps: Vec<f64> = gaps.collect();
                    let by = if gaps.first() < gaps.get(1) { -1 } else { 1 };
                    near.push(base.pieces[index] + by);
                }
                let mut options: Vec<Choice> = Vec::new();
                for (place, &piece) in near.iter().enumerate() {
                    if !near[..place].contains(&piece) {
                        options.push(Choice::Piece(index, piece));
                    }
                }
                Ok(options)
            }
        }
    }

    /// What the present mode says of itself; none where it does not hold.
    fn verdict(
        &self,
        system: &System,
        candidate: Candidate,
        (touched, asked): (&[Corner], &mut Asked<R>),
    ) -> Result<Option<Verdict<R>>, FlowError> {
        if let Some(contact) = self.jam(system) {
            asked.singular = Some(self.jammed(contact));
            return Ok(None);
        }
        let fields = self.fields_here(system, asked)?;
        if !fields[0].iter().all(|f| f.value.is_finite()) {
            asked.singular = self.singular_here(system);
            return Ok(None);
        }
        let mut verdict = Verdict {
            candidate,
            roots: Vec::new(),
            is_balanced: false,
            contacts_stay: true,
            opens_there: true,
            is_plain: true,
            is_smooth: true,
            fields,
        };
        // What an instant changes says nothing yet.
        let later = self.standings_at(system, (&asked.later.0, &asked.later.1))?;
        for (standing, later) in self.standings(system)?.iter().zip(&later) {
            if !touched.contains(&standing.corner) {
                continue;
            }
            let is_slid = matches!(standing.corner, Corner::Surface(k)
                if verdict.candidate.sides.get(k) == Side::Sliding);
            let may_slide = matches!(standing.corner, Corner::Surface(k)
                if asked.slippery.contains(k));
            let is_surface = standing.corner.is_surface();
            if is_slid && standing.guards.is_empty() {
                return Ok(None);
            }
            for ((kind, orders), (_, later)) in standing.guards.iter().zip(&later.guards) {
                // The surface of a side is touched, whatever rounding says, unless it has jumped at another corner; the ends of sliding
                // or of a piece may be far.
                let is_end = is_slid || !is_surface;
                let level = standing.level(orders) * R::splat(if is_end { 1.0 } else { JUMPS });
                let is_clear = orders[0].value.abs() > level
                    && (is_end || self.may_jump(system, standing.corner));
                let is_far = is_clear && orders[0].value > level;
                // What follows the first that decides may be infinite, as the derivative of a root that begins here.
                let moving = (orders.iter().enumerate().skip(1)).find(|&(k, order)| {
                    let level = order.level().max(change(order.value, later[k].value));
                    !order.value.is_finite() || order.value.abs() > level
                });
                // Nor does what is far from its end ask for them, as a share of fields along which a root begins.
                if is_far && orders[0].value.is_finite() {
                    continue;
                }
                let decides = orders.iter().take(1).chain(moving.map(|(_, order)| order));
                let leaves = if decides.into_iter().all(|order| order.value.is_finite()) {
                    if is_clear && orders[0].value < -level {
                        return Ok(None);
                    }
                    moving.map(|(order, moving)| (moving.value > R::ZERO, order as u8))
                } else {
                    let begins = (standing.corner, *kind);
                    match self.moves_by_a_root(system, begins, &verdict.fields[0])? {
                        Some(Ordering::Greater) => Some((true, 1)),
                        Some(Ordering::Less) => Some((false, 1)),
                        Some(Ordering::Equal)
                            if !may_slide && self.may_rest_at(system, *kind)? =>
                        {
                            None
                        }
                        _ => {
                            asked.singular = self.singular_here(system);
                            return Ok(None);
                        }
                    }
                };
                match leaves {
                    Some((false, _)) => return Ok(None),
                    Some((true, roots)) => verdict.roots.push((*kind, roots)),
                    None => {
                        verdict.is_balanced = true;
                        verdict.opens_there &=
                            is_slid || self.opens_there(system, standing.corner)?;
                        verdict.is_plain &= is_slid || self.is_plain(system, standing);
                        verdict.is_smooth &= self.root_at(system, *kind)?.is_none();
                        verdict.roots.push((*kind, Touching::BALANCED));
                    }
                }
            }
        }
        verdict.contacts_stay = self.contacts_stay(system);
        Ok(Some(verdict))
    }

    /// Whether what is zero at a corner has corners itself.
    fn may_jump(&self, system: &System, corner: Corner) -> bool {
        match corner {
            Corner::Surface(index) => (system.corners()).is_nested(&system.model().graph, index),
            Corner::Lookup(_) => false,
        }
    }

    /// Where a guard without a derivative, the root of something that vanishes here, is a moment later, as long as steps off roots
    /// are; none if it has no value there.
    fn moves_by_a_root(
        &self,
        system: &System,
        (corner, kind): (Corner, GuardKind),
        field: &[WithTerms<R>],
    ) -> Result<Option<Ordering>, FlowError> {
        let unit = (self.reach.iter()).fold(self.longest_step, |most, &reach| most.max(reach));
        let moment = unit * R::splat(R::ROUNDOFF).sqrt();
        let (state, low) = self.after(moment, field);
        let standings = self.standings_at(system, (&state, &low))?;
        let value = (standings.iter().filter(|s| s.corner == corner))
            .flat_map(|standing| &standing.guards)
            .find(|(other, _)| *other == kind)
            .map(|(_, orders)| orders[0]);
        Ok(
            value.and_then(|value| match value.value.abs() > value.level() {
                true => value.value.partial_cmp(&R::ZERO),
                false => value.value.is_finite().then_some(Ordering::Equal),
            }),
        )
    }

    /// Whether no other motion begins where a guard vanishes than one that it vanishes along: no root of it has a slope without bound
    /// there.
    fn may_rest_at(&self, system: &System, kind: GuardKind) -> Result<bool, FlowError> {
        let (program, root) = (self.program(system)?, self.root_at(system, kind)?);
        Ok(root.is_none_or(|slot| self.has_slopes(program, &[slot])))
    }

    /// The series that vanishes where a guard does, if a root is taken of it in the present mode.
    fn root_at(&self, system: &System, kind: GuardKind) -> Result<Option<usize>, FlowError> {
        let program = self.program(system)?;
        let own = program.guards.iter().find(|guard| guard.kind == kind);
        Ok(own
            .and_then(|guard| match guard.series {
                Operand::Series(slot) => Some(slot),
                Operand::Constant(_) => None,
            })
            .filter(|&slot| program.tape.singular.iter().any(|s| s.slot == slot)))
    }

    /// That what must not vanish in the present mode does so.
    fn singular_here(&self, system: &System) -> Option<FlowError> {
        let state = &self.state[..self.coordinates];
        let (kind, expression) = system.singular_at(self.mode, state, &self.parameters)?;
        Some(FlowError::Singular {
            time: self.time.to_f64(),
            kind,
            expression,
        })
    }

    /// Whether plain evaluation takes the piece of a corner that the state is on.
    fn is_plain(&self, system: &System, standing: &Standing<R>) -> bool {
        let value = standing.surface.value;
        match standing.corner {
            Corner::Surface(index) => {
                self.regime.get(index) == system.corners().side_at(index, value)
            }
            Corner::Lookup(index) => {
                let graph = &system.model().graph;
                let wide = value.to_double_double();
                self.pieces[index] == system.corners().piece_at(graph, index, wide)
            }
        }
    }

    fn no_mode(&self, system: &System, touched: &[Corner]) -> FlowError {
        FlowError::NoMode {
            time: self.time.to_f64(),
            surfaces: names(system, touched),
        }
    }
}

/// Whether two fields move the state alike: their difference is rounding, or no larger than what an
/// instant changes it by.
fn vanishes<R: Real>(a: &Fields<R>, b: &Fields<R>) -> bool {
    let later = a[1].iter().zip(&b[1]);
    (a[0].iter().zip(&b[0]).zip(later)).all(|((a, b), (a_later, b_later))| {
        let (now, then) = (a.value - b.value, a_later.value - b_later.value);
        now.abs() <= change(now, then).max(a.level() + b.level())
    })
}

/// By how much an instant changes a number; of one that has no value then nothing is known.
fn change<R: Real>(now: R, then: R) -> R {
    let change = (then - now).abs();
    if change.is_finite() { change } else { R::ZERO }
}

fn names(system: &System, corners: &[Corner]) -> Vec<String> {
    corners
        .iter()
        .map(|&corner| system.corner_name(corner))
        .collect()
}
