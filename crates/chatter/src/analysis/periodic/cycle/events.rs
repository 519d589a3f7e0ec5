//! What happens at one instant of a trajectory: one event, or collisions that share its time.

use super::itinerary::{Passage, Step};
use super::trace::Instant;
use crate::expressions::{Expr, Side};
use crate::flow::leg::{Jump, LegKind};
use crate::flow::{Closed, Grip, GuardKind, Occurrence, System};
use crate::model::Simultaneous;

/// What one instant by itself is: its guard, and the jump there. None where it is more than one event.
pub(super) fn single(instant: &Instant) -> Option<LegKind> {
    let guard = instant.guard?;
    let mut jump = Jump::None;
    let mut events = 0;
    // Contacts that open without a force change nothing, whichever is first; those that go on together touch all the while.
    let releases = |told: &Occurrence<f64>| {
        matches!(told, Occurrence::Release { .. } | Occurrence::Graze { .. })
    };
    let only_releases = instant.is_release() && instant.told.iter().all(releases);
    for told in &instant.told {
        match *told {
            _ if only_releases => events = 1,
            Occurrence::Impact { contact, .. } => {
                jump = Jump::Impact(contact);
                events += 1;
            }
            Occurrence::Reset { section } => {
                jump = Jump::Reset(section);
                events += 1;
            }
            // Where a jump leads to the other side of a surface, or onto it, or off a contact, the mode after it says so.
            Occurrence::Release { .. }
            | Occurrence::Switch { .. }
            | Occurrence::Slide { .. }
            | Occurrence::Leave { .. }
            | Occurrence::Stick { .. }
            | Occurrence::Slip { .. }
                if jump != Jump::None => {}
            Occurrence::Release { .. }
            | Occurrence::Switch { .. }
            | Occurrence::Slide { .. }
            | Occurrence::Leave { .. }
            | Occurrence::Stick { .. }
            | Occurrence::Slip { .. } => events += 1,
            Occurrence::Capture { .. } | Occurrence::Section { .. } | Occurrence::Horizon => {}
            Occurrence::Graze { .. }
            | Occurrence::Accumulation { .. }
            | Occurrence::Cascade { .. }
            | Occurrence::Ambiguity { .. } => return None,
        }
    }
    if events > 1 {
        return None;
    }
    if let GuardKind::Gap(contact) = guard
        && jump != Jump::Impact(contact)
    {
        return None;
    }
    Some(LegKind {
        mode: instant.mode,
        ends_at: Some(guard),
        jump,
    })
}

/// A rate of sliding is zero that is no more than so many roundoffs of what any state has a part in it, or friction may have had at the
/// impact.
const STOPPED_ROUNDOFFS: f64 = 16.0;
/// How a function changes with a state is told by so small a part of that.
const LITTLE: f64 = 1e-8;

/// Whether a contact slides the other way after an impact, against the friction of which the impact has no map of its own.
fn slides_back((system, parameters): (&System, &[f64]), instant: &Instant, contact: usize) -> bool {
    let model = system.model();
    let rubbing = system.rubbing_at(contact);
    let friction = model.contacts[contact].friction.as_ref();
    let (Some(rubbing), Some(friction), Some((_, sides, _))) =
        (rubbing, friction, system.origin_of(instant.mode))
    else {
        return false;
    };
    let known = system.with_pieces(parameters, &instant.pieces);
    let at = |of| model.graph.evaluate(of, &instant.state, &known);
    let (rate, coefficient): (f64, f64) = (at(friction.rate), at(friction.coefficient));
    coefficient > 0.0
        && rate * sides.get(rubbing.surface).sign() < 0.0
        && !stops((system, parameters), instant, contact)
}

/// The impulse of a contact at an impact.
fn impulse((system, parameters): (&System, &[f64]), instant: &Instant, contact: usize) -> f64 {
    let change = instant.told.iter().find_map(|told| match *told {
        Occurrence::Impact {
            contact: hit,
            rate_before,
            rate_after,
            ..
        } if hit == contact => Some(rate_after - rate_before),
        _ => None,
    });
    let origin = system.origin_of(instant.mode);
    let (Some(change), Some((_, _, on))) = (change, origin) else {
        return 0.0;
    };
    let known = system.with_pieces(parameters, &instant.pieces);
    let of = on.mechanics.contacts[contact].rate_per_impulse;
    let each: f64 = on.mechanics.graph.evaluate(of, &instant.state, &known);
    change / each
}

/// Whether an impact has stopped the sliding of its contact by friction.
fn stops((system, parameters): (&System, &[f64]), instant: &Instant, contact: usize) -> bool {
    let model = system.model();
    let Some(friction) = &model.contacts[contact].friction else {
        return false;
    };
    let known = system.with_pieces(parameters, &instant.pieces);
    let at = |state: &[f64], of| model.graph.evaluate(of, state, &known);
    let rate = at(&instant.state, friction.rate);
    // What a state has a part in; and, as of time after many turns, what it changes by when displaced by as much as it is, were that linear.
    let part = |i: usize| {
        let displaced = |by: f64| {
            let mut state = instant.state.clone();
            state[i] -= by * state[i];
            (at(&state, friction.rate) - rate).abs() / by
        };
        displaced(1.0).max(displaced(LITTLE))
    };
    let coefficient = at(&instant.state, friction.coefficient);
    let impulse = impulse((system, parameters), instant, contact);
    let by_friction = |(i, &along): (usize, &Expr)| {
        let mut state = instant.state.clone();
        state[i] += coefficient * impulse * at(&instant.state, along);
        (at(&state, friction.rate) - rate).abs()
    };
    let parts = (0..instant.state.len()).map(part);
    let parts = parts.chain(friction.along.iter().enumerate().map(by_friction));
    let largest = parts.fold(0.0, f64::max);
    coefficient > 0.0 && rate.abs() <= STOPPED_ROUNDOFFS * f64::EPSILON * largest
}

/// The events of an instant: the one that ends the way to it, and what shares its time.
pub(super) struct Events {
    pub first: LegKind,
    pub then: Vec<Passage>,
}

/// Contacts whose flights end at one instant, at most, for whose collisions all orders are compared.
const MOST_TOGETHER: usize = 3;

impl Events {
    /// None where the instant is more than can be told apart.
    pub(super) fn of(
        (system, parameters): (&System, &[f64]),
        instant: &Instant,
        span: f64,
    ) -> Option<Self> {
        let alone = single(instant);
        if let Some(Jump::Impact(contact)) = alone.map(|first| first.jump)
            && slides_back((system, parameters), instant, contact)
        {
            return None;
        }
        let alone = alone.map(|mut first| {
            if let Jump::Impact(contact) = first.jump
                && stops((system, parameters), instant, contact)
            {
                first.jump = Jump::Stop(contact);
            }
            Self {
                first,
                then: Vec::new(),
            }
        });
        alone
            .or_else(|| Self::corners((system, parameters), instant, span))
            .or_else(|| Self::collisions(system, instant))
            .or_else(|| Self::thrown(system, instant))
    }

    /// An event that throws bodies at what they rest on, or are put onto by it: impacts at its instant, however the orbit is displaced.
    fn thrown(system: &System, instant: &Instant) -> Option<Self> {
        let (&told, others) = instant.told.split_first()?;
        let Occurrence::Reset { section } = told else {
            return None;
        };
        let by_two = system.simultaneous() == Simultaneous::Binary && system.rubbing().is_empty();
        if !by_two || instant.guard != Some(GuardKind::Section(section)) {
            return None;
        }
        let first = LegKind {
            mode: instant.mode,
            ends_at: instant.guard,
            jump: Jump::Reset(section),
        };
        let mut then = Vec::new();
        for (told, (mode, _)) in others.iter().zip(instant.came_in.iter().skip(1)) {
            match *told {
                Occurrence::Impact { contact, .. } => {
                    if !system.lands_on((first.mode, section), contact) {
                        return None;
                    }
                    let (_, sides, _) = system.origin_of(*mode)?;
                    then.push(Passage::AtOnce(LegKind {
                        mode: system.meet(Grip::NONE, sides),
                        ends_at: Some(GuardKind::Gap(contact)),
                        jump: Jump::Impact(contact),
                    }));
                }
                // The mode after the jumps says so.
                Occurrence::Capture { .. }
                | Occurrence::Release { .. }
                | Occurrence::Switch { .. }
                | Occurrence::Slide { .. }
                | Occurrence::Leave { .. }
                | Occurrence::Stick { .. }
                | Occurrence::Slip { .. } => {}
                _ => return None,
            }
        }
        (!then.is_empty()).then_some(Self { first, then })
    }

    /// Collisions as they came. None where the law of those that share an instant is not one of two bodies at a time.
    fn collisions(system: &System, instant: &Instant) -> Option<Self> {
        let (grip, sides, on_sides) = system.origin_of(instant.mode)?;
        let (_, sides_after, _) = system.origin_of(instant.mode_after)?;
        let mut active = on_sides.followed.surfaces.members();
        let slides = active.any(|k| sides.get(k) == Side::Sliding);
        let is_met = matches!(instant.guard, Some(GuardKind::Gap(_)));
        let by_two = system.simultaneous() == Simultaneous::Binary && system.rubbing().is_empty();
        if !by_two || !instant.in_one_mode || sides != sides_after || slides || !is_met {
            return None;
        }
        let flight = system.meet(Grip::NONE, sides);
        let (mut touching, mut flights) = (grip.closed, 0);
        let mut found: Option<Self> = None;
        for told in &instant.told {
            let contact = match *told {
                Occurrence::Impact { contact, .. } => contact,
                Occurrence::Capture { .. } => continue,
                _ => return None,
            };
            let is_struck = touching.contains(contact);
            let kind = LegKind {
                mode: if is_struck { flight } else { instant.mode },
                ends_at: Some(GuardKind::Gap(contact)),
                jump: Jump::Impact(contact),
            };
            match &mut found {
                None if is_struck => return None,
                None => {
                    found = Some(Self {
                        first: kind,
                        then: Vec::new(),
                    });
                }
                Some(known) if is_struck => known.then.push(Passage::AtOnce(kind)),
                Some(known) => known.then.push(Passage::Together(kind)),
            }
            flights += usize::from(!is_struck);
            touching = touching.with(contact);
        }
        found.filter(|_| flights <= MOST_TOGETHER)
    }

    /// Whether nothing happens but that a surface is crossed, or the end of a piece.
    pub(super) fn is_corner(&self) -> bool {
        let ends = matches!(
            self.first.ends_at,
            Some(GuardKind::Switch(_) | GuardKind::Piece(..))
        );
        ends && self.first.jump == Jump::None && self.then.is_empty()
    }

    /// What is told of the first of them.
    pub(super) fn told<'i>(&self, instant: &'i Instant) -> &'i [Occurrence<f64>] {
        let count = if self.then.is_empty() {
            instant.told.len()
        } else {
            1
        };
        &instant.told[..count]
    }

    /// The steps of a way that ends with them: nodes are told from the state after all, by what each did to its rate.
    pub(super) fn steps(
        &self,
        (system, parameters): (&System, &[f64]),
        (way, instant): (Step, &Instant),
    ) -> Vec<Step> {
        if self.first.jump == Jump::None {
            // Corners leave the state as it is.
            let others = self.then.iter().zip(instant.told.iter().skip(1));
            let others = others.map(|(&passage, &told)| Step {
                passage,
                told: vec![told],
                start: instant.state.clone(),
                duration: 0.0,
                ..way.clone()
            });
            let others: Vec<Step> = others.collect();
            return core::iter::once(way).chain(others).collect();
        }
        let mut state = instant.state.clone();
        let mut closed = way.closed;
        let own = usize::from(self.first.jump.impact().is_some());
        let impacts: Vec<_> = (instant.told.iter().zip(&instant.came_in))
            .filter_map(|(told, (_, pieces))| match *told {
                Occurrence::Impact {
                    contact,
                    rate_before,
                    rate_after,
                    ..
                } => Some((told, pieces, contact, rate_after - rate_before)),
                _ => None,
            })
            .skip(own)
            .collect();
        let mut found: Vec<Step> = Vec::new();
        for (&passage, &(told, pieces, contact, change)) in self.then.iter().zip(&impacts).rev() {
            let known = system.with_pieces(parameters, pieces);
            let mut step = Step {
                passage,
                pieces: pieces.clone(),
                told: vec![*told],
                closed,
                start: Vec::new(),
                duration: 0.0,
            };
            closed = Closed::NONE;
            if let Some((_, _, on)) = system.origin_of(step.mode()) {
                let graph = &on.mechanics.graph;
                let jump = &on.mechanics.contacts[contact].jump;
                let by: Vec<f64> = (jump.iter())
                    .map(|&along| change * graph.evaluate(along, &state, &known))
                    .collect();
                state.iter_mut().zip(by).for_each(|(x, by)| *x -= by);
            }
            step.start.clone_from(&state);
            found.push(step);
        }
        found.push(Step { closed, ..way });
        found.reverse();
        found
    }
}
