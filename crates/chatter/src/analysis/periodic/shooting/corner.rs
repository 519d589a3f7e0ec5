//! Corners that only the event at the end of a step asks for, such as that of a map by a clock: the state may stand still between two of
//! its points, and so such a corner is passed by no motion. How far the event is from one is a function of the leg's end.

use super::Shooting;
use crate::analysis::continuation::{Left, Problem};
use crate::analysis::periodic::cycle::itinerary::{Passage, Step};
use crate::analysis::periodic::cycle::rotate::rotate;
use crate::analysis::periodic::error::PeriodicError;
use crate::expressions::{Asked, Side, Sides, Symbol};
use crate::flow::leg::{Flyer, Jump, Leg, LegKind};
use crate::flow::{Grip, GuardKind, Settings, System};
use crate::numerics::Real;
use std::sync::Arc;

/// The end of a leg, seen from a corner, or its beginning, seen from what ends it.
#[derive(Clone, Debug)]
pub(super) struct Watched<R: Real> {
    step: usize,
    /// Whether where the step begins, and not at its end.
    at_start: bool,
    guard: GuardKind,
    leg: Arc<Leg>,
    flyer: Flyer<R>,
}

impl<R: Real> Watched<R> {
    /// The step at whose end it is watched, or its beginning, and the guard that vanishes there.
    pub(super) fn place(&self) -> ((usize, bool), GuardKind) {
        ((self.step, self.at_start), self.guard)
    }
}

/// A moment, in parts of the period.
const MOMENT: f64 = 1e-7;
/// Corners within corners, as conditions are nested.
const DEEPEST: usize = 16;

/// What an event asks for that the motion before it does not.
fn asked_by(system: &System, kind: LegKind) -> Asked {
    let program = system.program(kind.mode);
    let asked = program.map(|program| match kind.jump {
        Jump::None => Asked::default(),
        Jump::Impact(contact) | Jump::Stop(contact) => program.asked_at_impacts[contact],
        Jump::Reset(section) => program.asked_at_resets[section],
    });
    asked.unwrap_or_default()
}

/// The mode on these sides and, of what is asked for there and is not known of the other side, on those where a state is.
pub(in crate::analysis::periodic) fn mode_there(
    system: &System,
    (grip, mut sides, pieces): (Grip, Sides, &mut [i64]),
    asked: &dyn Fn(usize) -> Asked,
    (mut known, (state, parameters)): (Asked, (&[f64], &[f64])),
) -> usize {
    let plain = (system.corners()).at(&system.model().graph, state, parameters);
    let mut mode = system.meet(grip, sides);
    for _ in 0..DEEPEST {
        let new = asked(mode).without(known);
        if new.is_empty() {
            break;
        }
        for surface in new.surfaces.members() {
            sides = sides.with(surface, plain.0.get(surface));
        }
        for lookup in new.lookups.members() {
            pieces[lookup] = plain.1[lookup];
        }
        known = known.or(new);
        mode = system.meet(grip, sides);
    }
    mode
}

impl<R: Real> Shooting<R> {
    /// The number of the function that vanishes where the event is at the corner that is watched.
    pub(crate) fn corner_function(&self) -> usize {
        self.user_function(self.workshop.monitors.len())
    }

    /// Whether a guard is a corner that only the event at the end of a step asks for.
    pub(crate) fn asks(&self, index: usize, guard: GuardKind) -> bool {
        let Passage::Leg(kind) = self.steps[index].passage else {
            return false;
        };
        let asked = asked_by(&self.workshop.system, kind);
        match guard {
            GuardKind::Switch(surface) => asked.surfaces.contains(surface),
            GuardKind::Piece(lookup, _) => asked.lookups.contains(lookup),
            _ => false,
        }
    }

    /// Whether a guard is that friction at the impact that a step ends with begins, or ceases, to stop the sliding of its contact.
    pub(crate) fn stops_about(&self, index: usize, guard: GuardKind) -> bool {
        let contact = self.steps[index].impact();
        let rubbing = contact.and_then(|of| self.workshop.system.rubbing_at(of));
        matches!((guard, rubbing), (GuardKind::Leave(surface, _), Some(of)) if of.surface == surface)
    }

    /// Watches how far the event at the end of a step is from a corner that it asks for.
    pub(crate) fn watch_corner(
        &mut self,
        step: usize,
        guard: GuardKind,
    ) -> Result<(), PeriodicError> {
        self.watch((step, false), guard)
    }

    /// Watches how far a step that begins is from what would end it.
    pub(crate) fn watch_start(
        &mut self,
        step: usize,
        guard: GuardKind,
    ) -> Result<(), PeriodicError> {
        self.watch((step, true), guard)
    }

    /// Watches a guard at the end of a step, or where it begins.
    pub(crate) fn watch(
        &mut self,
        (step, at_start): (usize, bool),
        guard: GuardKind,
    ) -> Result<(), PeriodicError> {
        let unknown = || PeriodicError::Unfollowed {
            what: "a corner that no event asks for".to_owned(),
        };
        let Passage::Leg(kind) = self.steps[step].passage else {
            return Err(unknown());
        };
        let to_corner = LegKind {
            ends_at: Some(guard),
            ..kind
        };
        let leg = self.workshop.leg(to_corner).ok_or_else(unknown)?;
        let flyer = leg.flyer(&Settings::default());
        self.corner = Some(Watched {
            step,
            at_start,
            guard,
            leg,
            flyer,
        });
        Ok(())
    }

    /// How far it is, and the derivatives of that.
    pub(super) fn corner_value(&mut self, at: &[R]) -> Result<(R, Vec<R>), Left> {
        let none = || Left::because("no corner is watched");
        let mut watched = self.corner.take().ok_or_else(none)?;
        let found = self.flown_to(&mut watched, at);
        self.corner = Some(watched);
        found
    }

    fn flown_to(&self, watched: &mut Watched<R>, at: &[R]) -> Result<(R, Vec<R>), Left> {
        let Watched {
            step,
            at_start,
            leg,
            flyer,
            ..
        } = watched;
        let place = self.duration_place(*step);
        let place = place.ok_or_else(|| Left::because("a corner at the end of no leg"))?;
        let parameters = self.workshop.parameters(self.free(at));
        let all = self.parameters_of(&parameters, &self.steps[*step]);
        let node = self.node(at, *step);
        let landing = match at_start {
            true => leg.fly_a_moment(flyer, &all, node, R::ZERO),
            false => leg.fly(flyer, &all, node, at[place]),
        };
        let landing = landing.map_err(Left::because)?;
        let (n, free) = (self.workshop.model.states.len(), self.workshop.free.len());
        let mut gradient = vec![R::ZERO; at.len()];
        let node = self.places[*step];
        gradient[node..node + n].copy_from_slice(&landing.surface_slopes[..n]);
        gradient[at.len() - free..].copy_from_slice(&landing.surface_slopes[n..]);
        if !*at_start {
            gradient[place] = landing.surface_rate;
        }
        Ok((landing.surface, gradient))
    }
}

/// The same orbit with another piece of what the event at the end of a step does.
pub(crate) struct BeyondCorner {
    pub shooting: Shooting<f64>,
    pub at: Vec<f64>,
    /// That step.
    pub step: usize,
    /// How far apart both pieces take the state, but for whole turns of phases, against the sizes of states.
    pub jump: f64,
    /// How much their slopes differ.
    pub kink: f64,
}

fn unfollowed(what: &str) -> PeriodicError {
    PeriodicError::Unfollowed {
        what: what.to_owned(),
    }
}

impl Shooting<f64> {
    /// Whether the last event leaves what events alone move on the sides of surfaces that the orbit begins on: (M1) leave such a counter free, as which
    /// side holds is a matter of modes, and these are to come back. After an evaluation.
    pub(crate) fn counters_come_back(&self, at: &[f64]) -> bool {
        let workshop = &self.workshop;
        let (system, model) = (&workshop.system, &workshop.model);
        let (graph, corners) = (&system.model().graph, system.corners());
        let stands = |state: usize| {
            let rate = graph.as_number(model.states[state].derivative);
            rate.is_some_and(|rate| rate.to_f64() == 0.0)
        };
        let is_counter = |symbol: &Symbol| match *symbol {
            Symbol::State(state) => workshop.closure.is_idle(state) && stands(state),
            Symbol::Parameter(_) => true,
        };
        let Some(last) = self.latest.last() else {
            return true;
        };
        let parameters = workshop.parameters(self.free(at));
        let [(begins, _), (ends, _)] =
            [self.node(at, 0), &last.image].map(|state| corners.at(graph, state, &parameters));
        let mut told = (corners.surfaces.iter().enumerate())
            .filter(|(_, surface)| graph.symbols(**surface).iter().all(is_counter));
        told.all(|(index, _)| begins.get(index) == ends.get(index))
    }

    /// The same orbit where the event at the end of a step is beyond these corners that it asks for.
    pub(crate) fn beyond_corners(
        &mut self,
        at: &[f64],
        (index, corners): (usize, &[GuardKind]),
    ) -> Result<BeyondCorner, PeriodicError> {
        let failed = |left: Left| unfollowed(&left.to_string());
        let steps = self.with_other_pieces(at, (index, corners))?;
        let (mut shooting, mut guess) = self.like(steps, at)?;
        self.evaluate(at).map_err(failed)?;
        shooting.evaluate(&guess).map_err(failed)?;
        let (own, others) = (&self.latest[index], &shooting.latest[index]);
        let parameters = self.workshop.parameters(self.free(at));
        let turns = self.workshop.closure.turns(&parameters)?;
        let (sizes, scales) = (
            self.state_sizes(),
            &self.scales[at.len() - self.workshop.free.len()..],
        );
        let images = (&*others.image, &*own.image);
        let apart = self.workshop.closure.difference(&turns, images, &sizes);
        let mut kink = 0.0_f64;
        for (i, size) in sizes.iter().enumerate() {
            for (k, by) in sizes.iter().chain(scales).enumerate() {
                let differ = own.image_slopes[(i, k)] - others.image_slopes[(i, k)];
                kink = kink.max((differ * by / size).abs());
            }
        }
        let mut step = index;
        if apart.turns.iter().any(|turns| *turns != 0) {
            // As where an angle is kept below a turn: what is left of a period ends so many turns later.
            let mut steps = shooting.steps.clone();
            if index + 1 < steps.len() {
                let cycle = (&mut *steps, &*self.counts);
                rotate(&self.workshop, &parameters, cycle, index + 1)?;
                step = steps.len() - 1;
            }
            let counts = self.counts.iter().zip(&apart.turns);
            let counts = counts.map(|(count, turns)| count - turns).collect();
            (shooting, guess) = shooting.like_with(steps, counts, &guess)?;
        }
        Ok(BeyondCorner {
            shooting,
            at: guess,
            step,
            jump: apart.distance,
            kink,
        })
    }

    /// A leg that an impact comes in at the end of, and the pieces of lookups on it: what that impact alone asks for, as its restitution, is on the
    /// side where the state is, whichever event it was that the motion went on to before.
    pub(crate) fn to_impact(
        &self,
        at: &[f64],
        kind: LegKind,
        (touch, step): (&[f64], &Step),
    ) -> (LegKind, Vec<i64>) {
        let system = &self.workshop.system;
        let mut pieces = step.pieces.clone();
        let Some((grip, sides, on_sides)) = system.origin_of(kind.mode) else {
            return (kind, pieces);
        };
        let model = &self.workshop.model;
        let parameters = self.workshop.parameters(self.free(at));
        let sides = self.sliding_sides(sides, kind, (touch, &parameters));
        // A moment before, the gap closes: with no rate at all corners that go by that have no side.
        let by = -MOMENT * self.period();
        let rates = model.states.iter().map(|state| {
            let rate: f64 = (model.graph).evaluate(state.derivative, touch, &parameters);
            rate
        });
        let before: Vec<f64> = touch.iter().zip(rates).map(|(x, f)| x + by * f).collect();
        let asked = |mode: usize| asked_by(system, LegKind { mode, ..kind });
        let known = (on_sides.followed, (&*before, &*parameters));
        let mode = mode_there(system, (grip, sides, &mut pieces), &asked, known);
        (LegKind { mode, ..kind }, pieces)
    }

    /// Sides with that on which the contact of an impact slides at a state, where nothing but its friction asks for it.
    fn sliding_sides(
        &self,
        sides: Sides,
        kind: LegKind,
        (state, parameters): (&[f64], &[f64]),
    ) -> Sides {
        let system = &self.workshop.system;
        let rubbing = kind.jump.impact().and_then(|of| system.rubbing_at(of));
        match rubbing.filter(|of| system.rubs_nowhere(kind.mode, of.surface)) {
            Some(of) => {
                let (plain, _) = (system.corners()).at(&system.model().graph, state, parameters);
                sides.with(of.surface, plain.get(of.surface))
            }
            None => sides,
        }
    }

    /// Whether two modes move alike, and differ at most in what impacts and resets alone ask for.
    pub(crate) fn moves_alike(&self, one: usize, other: usize) -> bool {
        let system = &self.workshop.system;
        let both = (system.origin_of(one), system.origin_of(other));
        let (Some((grip, sides, on)), Some((other_grip, other_sides, other_on))) = both else {
            return false;
        };
        let mut followed = on.followed.surfaces.members();
        grip == other_grip
            && on.followed == other_on.followed
            && followed.all(|surface| {
                sides.get(surface) == other_sides.get(surface) || system.rubs_nowhere(one, surface)
            })
    }

    /// The steps, of which one ends beyond these corners.
    fn with_other_pieces(
        &self,
        at: &[f64],
        (index, corners): (usize, &[GuardKind]),
    ) -> Result<Vec<Step>, PeriodicError> {
        let mut steps = self.current_steps(at);
        let Passage::Leg(mut kind) = steps[index].passage else {
            return Err(unfollowed("a corner at the end of no leg"));
        };
        let system = &self.workshop.system;
        let (grip, mut sides, _) = (system.origin_of(kind.mode))
            .ok_or_else(|| unfollowed("a mode that holds no motion"))?;
        let pieces = &mut steps[index].pieces;
        for corner in corners {
            match *corner {
                GuardKind::Switch(surface) => {
                    let other = match sides.get(surface) {
                        Side::Below => Side::Above,
                        Side::Above | Side::Sliding => Side::Below,
                    };
                    sides = sides.with(surface, other);
                }
                GuardKind::Piece(lookup, side) => {
                    pieces[lookup] += if side == Side::Above { 1 } else { -1 };
                }
                _ => return Err(unfollowed("a corner without sides")),
            }
        }
        // What only the other side asks for is as the state there says.
        let parameters = self.workshop.parameters(self.free(at));
        let there = self.before_event(at, index)?;
        let asked = |mode: usize| asked_by(system, LegKind { mode, ..kind });
        let known = (asked_by(system, kind), (&*there, &*parameters));
        kind.mode = mode_there(system, (grip, sides, pieces), &asked, known);
        steps[index].passage = Passage::Leg(kind);
        Ok(steps)
    }

    /// The state at the end of a leg, before its event changes it.
    pub(crate) fn before_event(&self, at: &[f64], index: usize) -> Result<Vec<f64>, PeriodicError> {
        let (Passage::Leg(kind), Some(place)) =
            (self.steps[index].passage, self.duration_place(index))
        else {
            return Err(unfollowed("a corner at the end of no leg"));
        };
        let plain = LegKind {
            jump: Jump::None,
            ..kind
        };
        let leg = self.workshop.leg(plain);
        let leg = leg.ok_or_else(|| unfollowed("a mode that holds no motion"))?;
        let parameters = self.workshop.parameters(self.free(at));
        let all = self.parameters_of(&parameters, &self.steps[index]);
        let mut flyer = leg.flyer(&Settings::default());
        let landing = leg.fly(&mut flyer, &all, self.node(at, index), at[place]);
        Ok(landing
            .map_err(|error| unfollowed(&error.to_string()))?
            .image)
    }
}
