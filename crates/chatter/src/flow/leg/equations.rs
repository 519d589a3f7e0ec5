//! The equations of a leg: its field, its guards, the surface that it ends at and the map there.

use super::{Jump, LegKind};
use crate::expressions::{Asked, Expr, Graph, Side, Sides, Symbol};
use crate::flow::modes::closed::{Closed, Grip};
use crate::flow::modes::equations::{ModeExprs, guard_functions};
use crate::flow::modes::guard::GuardKind;
use crate::flow::modes::limits::Limits;
use crate::flow::system::System;
use crate::flow::touch::stop;
use crate::model::{Mechanics, Model, Section, State};
use crate::numerics::dot;

/// The equations of a leg.
pub(super) struct Ending {
    pub graph: Graph,
    pub field: Vec<Expr>,
    pub guards: Vec<(GuardKind, Expr)>,
    pub surface: Option<Expr>,
    pub map: Vec<Expr>,
    pub held: Vec<Held>,
    /// Of the corners that its event alone asks for what is positive where it is.
    pub asked: Vec<(GuardKind, Expr)>,
}

/// A function that a mode holds at zero: gap and rate of a contact that is closed, the surface that is slid along.
pub(super) struct Held {
    function: Expr,
    /// What changes it by one; without it, the function's own slopes do.
    by: Option<Vec<Expr>>,
}

/// A map of states that are put onto what holds them first: forces of contact and friction keep gap and rates as they are, be they
/// zero or not, so that an orbit which never leaves a contact or a surface would be one of many.
pub(super) fn onto_what_holds(
    graph: &mut Graph,
    held: &[Held],
    map: &[Expr],
    time: Option<usize>,
) -> Vec<Expr> {
    let mut place: Vec<Expr> = (0..map.len()).map(|i| graph.state(i)).collect();
    for Held { function, by } in held {
        let (direction, part) = match by {
            Some(jump) => (jump.clone(), *function),
            None => {
                let slopes: Vec<Expr> = (0..map.len())
                    .map(|i| match time {
                        Some(time) if time == i => graph.number(0.0),
                        _ => graph.derivative(*function, Symbol::State(i)),
                    })
                    .collect();
                let squares: Vec<Expr> = slopes
                    .iter()
                    .map(|&slope| graph.mul(slope, slope))
                    .collect();
                let square = graph.sum(&squares);
                (slopes, graph.div(*function, square))
            }
        };
        let moved: Vec<Expr> = (direction.iter().enumerate())
            .map(|(i, &along)| {
                let step = graph.mul(along, part);
                let state = graph.state(i);
                graph.sub(state, step)
            })
            .collect();
        let known = place.clone();
        place = (moved.iter())
            .map(|&expr| graph.substitute(expr, &|symbol| at(&known, symbol)))
            .collect();
    }
    (map.iter())
        .map(|&image| graph.substitute(image, &|symbol| at(&place, symbol)))
        .collect()
}

pub(super) fn at(place: &[Expr], symbol: Symbol) -> Option<Expr> {
    match symbol {
        Symbol::State(i) => place.get(i).copied(),
        Symbol::Parameter(_) => None,
    }
}

/// The model in flight by this field alone, with these sections.
pub(super) fn bare(model: &Model, graph: &Graph, field: &[Expr], sections: Vec<Section>) -> Model {
    let states = (model.states.iter().zip(field)).map(|(state, &derivative)| State {
        derivative,
        ..state.clone()
    });
    Model {
        graph: graph.clone(),
        states: states.collect(),
        contacts: Vec::new(),
        sections,
        ..model.clone()
    }
}

/// When a guard vanishes, seen from a state in a mode.
pub(crate) struct Due {
    /// After this time, by its value and rate there.
    pub after: f64,
    /// How much later where the state is displaced.
    pub slopes: Vec<f64>,
}

impl System {
    /// When a guard of a mode vanishes, to first order; none where the mode has no such guard, or nothing changes it.
    pub(crate) fn due(
        &self,
        (mode, guard): (usize, GuardKind),
        parameters: &[f64],
        state: &[f64],
    ) -> Option<Due> {
        let kind = LegKind {
            mode,
            ends_at: Some(guard),
            jump: Jump::None,
        };
        let Ending {
            mut graph,
            field,
            surface,
            ..
        } = self.ending(kind)?;
        let surface = surface?;
        let slopes = (0..field.len()).map(|i| graph.derivative(surface, Symbol::State(i)));
        let slopes: Vec<Expr> = slopes.collect();
        let at = |&expr: &Expr| graph.evaluate(expr, state, parameters);
        let slopes: Vec<f64> = slopes.iter().map(at).collect();
        let field: Vec<f64> = field.iter().map(at).collect();
        let rate = dot(&slopes, &field);
        (rate != 0.0 && rate.is_finite()).then(|| Due {
            after: -at(&surface) / rate,
            slopes: slopes.iter().map(|slope| -slope / rate).collect(),
        })
    }

    /// Whether only friction in contacts that are open all through a mode depends on the side of a surface, and of those that vanish with it: nothing
    /// happens where it is crossed.
    pub(crate) fn rubs_nowhere(&self, mode: usize, surface: usize) -> bool {
        let Some((grip, _, on)) = self.origin_of(mode) else {
            return false;
        };
        let alike = self.alike(surface);
        let mut asked = alike
            .members()
            .filter(|&of| on.active.surfaces.contains(of));
        let mut rubs = self
            .rubbing()
            .iter()
            .filter(|of| alike.contains(of.surface));
        on.rubbing_alone.contains(surface)
            && asked.all(|of| on.rubbing_alone.contains(of))
            && rubs.all(|of| !grip.closed.contains(of.contact))
    }

    /// Whether a guard of a mode is the surface of such friction.
    pub(crate) fn is_idle(&self, mode: usize, guard: GuardKind) -> bool {
        matches!(guard, GuardKind::Switch(surface) if self.rubs_nowhere(mode, surface))
    }

    /// The mode between two events of one instant in the other order, where these lead from mode to mode, the first and then the second: what the
    /// second changes has changed there. None where something opens or closes, or a slide begins or ends, or where it holds no motion.
    pub(crate) fn in_other_order(&self, [before, between, after]: [usize; 3]) -> Option<usize> {
        let (grip, mut sides, on_before) = self.origin_of(before)?;
        let (grip_between, sides_between, on_between) = self.origin_of(between)?;
        let (grip_after, sides_after, _) = self.origin_of(after)?;
        let known = (on_before.followed.surfaces).or(on_between.followed.surfaces);
        if grip != grip_between || grip != grip_after {
            return None;
        }
        for surface in 0..self.corners().surfaces.len() {
            let all = [sides, sides_between, sides_after].map(|sides| sides.get(surface));
            let changes = all.iter().any(|side| *side != all[0]);
            if changes && all.contains(&Side::Sliding) {
                return None;
            }
            // Sides that nothing asks for before the second event say nothing.
            if all[1] != all[2] || !known.contains(surface) {
                sides = sides.with(surface, all[2]);
            }
        }
        let mode = self.meet(grip, sides);
        self.program(mode).map(|_| mode)
    }

    /// How the gap of a contact that a mode holds beside others would open if that one alone were let go: its acceleration and its jerk. None where it
    /// holds no other, or no motion is without it.
    pub(crate) fn let_go(
        &self,
        (mode, contact): (usize, usize),
        parameters: &[f64],
        state: &[f64],
    ) -> Option<[f64; 2]> {
        let (grip, sides, _) = self.origin_of(mode)?;
        let others = Grip {
            closed: grip.closed.without(contact),
            ..grip
        };
        if others.closed == Closed::NONE || others.closed == grip.closed || grip.has_idle() {
            return None;
        }
        self.gap_moves((self.meet(others, sides), contact), parameters, state)
    }

    /// The acceleration of a contact's gap, and its jerk, in a mode in which that is open.
    pub(crate) fn gap_moves(
        &self,
        (mode, contact): (usize, usize),
        parameters: &[f64],
        state: &[f64],
    ) -> Option<[f64; 2]> {
        let kind = LegKind {
            mode,
            ends_at: Some(GuardKind::Gap(contact)),
            jump: Jump::None,
        };
        let ending = self.ending(kind)?;
        let (mut graph, field) = (ending.graph, ending.field);
        let rate = graph.lie_derivative(ending.surface?, &field);
        let acceleration = graph.lie_derivative(rate, &field);
        let jerk = graph.lie_derivative(acceleration, &field);
        Some([acceleration, jerk].map(|expr| graph.evaluate(expr, state, parameters)))
    }

    /// The field of a mode at a state.
    pub(crate) fn field_of(
        &self,
        mode: usize,
        parameters: &[f64],
        state: &[f64],
    ) -> Option<Vec<f64>> {
        let kind = LegKind {
            mode,
            ends_at: None,
            jump: Jump::None,
        };
        let Ending { graph, field, .. } = self.ending(kind)?;
        let at = |&expr: &Expr| graph.evaluate(expr, state, parameters);
        Some(field.iter().map(at).collect())
    }

    /// Whether the event of a section that is met in a mode leads onto a contact from wherever it comes, on whichever sides: it keeps the gap that the mode
    /// holds closed, or closes it.
    pub(crate) fn lands_on(&self, (mode, section): (usize, usize), contact: usize) -> bool {
        let model = self.model();
        let (Some(reset), Some((grip, ..))) =
            (&model.sections[section].reset, self.origin_of(mode))
        else {
            return false;
        };
        let mut graph = model.graph.clone();
        let gap = model.contacts[contact].gap;
        let after = graph.substitute(gap, &|symbol| at(reset, symbol));
        let is_kept = after == gap && grip.carrying().contains(contact);
        is_kept || after == graph.number(0.0)
    }

    /// What is positive as long as friction at an impact does what it does: all of it leaves some of the sliding, or, where it stops that, would turn sliding of
    /// either side.
    fn slips(
        &self,
        mechanics: &mut Mechanics,
        (sides, jump): (Sides, Jump),
    ) -> Vec<(GuardKind, Expr)> {
        let (Jump::Impact(contact) | Jump::Stop(contact)) = jump else {
            return Vec::new();
        };
        let Some(rubbing) = self.rubbing_at(contact) else {
            return Vec::new();
        };
        if self.corners().is_disc(rubbing.surface) {
            return Vec::new();
        }
        let stops = matches!(jump, Jump::Stop(_));
        let own = sides.get(rubbing.surface);
        let both = [Side::Above, Side::Below].into_iter();
        let all = both.filter(|side| stops || *side == own);
        let left = all.filter_map(|side| {
            let left = mechanics.left_sliding(contact, side)?;
            let is_negative = stops == (side == Side::Above);
            let function = match is_negative {
                true => mechanics.graph.neg(left),
                false => left,
            };
            Some((GuardKind::Leave(rubbing.surface, side), function))
        });
        left.collect()
    }

    pub(super) fn ending(&self, kind: LegKind) -> Option<Ending> {
        let (grip, sides, on_sides) = self.origin_of(kind.mode)?;
        let mut mechanics = on_sides.mechanics.clone();
        let exprs = ModeExprs::new(&mut mechanics, grip)?;
        let limits = Limits::new(
            &mut mechanics,
            (self.corners(), on_sides),
            (self.rubbing(), grip.carrying(), sides),
            &exprs,
        );
        let contacts = mechanics.contacts.clone();
        let stop = match kind.jump {
            Jump::Stop(contact) => Some(stop(&mut mechanics, contact)?.stop),
            _ => None,
        };
        let slips = self.slips(&mut mechanics, (sides, kind.jump));
        let mut graph = mechanics.graph;
        let sections = &on_sides.sections;
        let mut guards = guard_functions(&mut graph, &contacts, (sections, &limits), &exprs);
        guards.retain(|&(guard, ..)| !self.is_idle(kind.mode, guard));
        let mut map: Vec<Expr> = match kind.jump {
            Jump::None => (0..exprs.field.len()).map(|i| graph.state(i)).collect(),
            Jump::Impact(contact) | Jump::Stop(contact) => {
                contacts.get(contact)?.after_impact.clone()
            }
            Jump::Reset(section) => sections.get(section)?.reset.clone()?,
        };
        if let Some(stop) = stop {
            let hit = map.clone();
            for (after, added) in map.iter_mut().zip(stop) {
                let added = graph.substitute(added, &|symbol| at(&hit, symbol));
                *after = graph.add(*after, added);
            }
        }
        let slid_along = (on_sides.followed.surfaces.members())
            .filter(|&index| sides.get(index) == Side::Sliding)
            .map(|index| Held {
                function: on_sides.surfaces[index],
                by: None,
            });
        let in_contact = (grip.carrying().contacts())
            .filter_map(|index| contacts.get(index))
            .flat_map(|contact| {
                [(contact.gap, None), (contact.rate, Some(&contact.jump))].map(|(function, by)| {
                    let by = by.cloned();
                    Held { function, by }
                })
            });
        let held: Vec<Held> = in_contact.chain(slid_along).collect();
        // What roots are taken of must not become negative, and nothing else may keep it from that.
        let mut guards: Vec<(GuardKind, Expr)> = (guards.into_iter())
            .map(|(guard, _, function)| (guard, function))
            .collect();
        let of_field = graph.radicands(&exprs.field);
        let mut roots = Vec::new();
        for (index, &radicand) in on_sides.radicands.iter().enumerate() {
            let kept = guards.iter().map(|&(_, function)| function);
            let mut kept = kept.chain(held.iter().map(|held| held.function));
            if of_field.contains(&radicand)
                && graph.depends_on_state(radicand)
                && !kept.any(|function| graph.factor_of(radicand, function).is_some())
            {
                roots.push((GuardKind::Root(index), radicand));
            }
        }
        guards.extend(roots);
        let asked = match kind.jump {
            Jump::None => Asked::default(),
            Jump::Impact(contact) | Jump::Stop(contact) => limits.impacts[contact],
            Jump::Reset(section) => limits.resets[section],
        };
        let mut asked = on_sides.guards_of(&mut graph, (self.corners(), sides), asked);
        asked.extend(slips);
        // What is a corner for the event alone may be where it comes.
        let all = guards.iter().copied();
        let surface = match kind.ends_at {
            Some(wanted) => {
                let mut all = all.chain(asked.iter().copied());
                Some(all.find(|(guard, _)| *guard == wanted)?.1)
            }
            None => None,
        };
        Some(Ending {
            graph,
            field: exprs.field,
            guards,
            surface,
            map,
            held,
            asked,
        })
    }
}
