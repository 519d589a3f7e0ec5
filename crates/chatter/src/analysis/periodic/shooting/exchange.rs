//! Events that change places. Where one is the knot of a table functions go on smoothly, and nothing happens to an orbit whose impact
//! comes before it and not after it any more. An impact and the tick of a clock, say, of which neither changes what the other does, lead to one
//! state in either order, as do an impact and the switch of a square wave, however that is spelled: the orbit goes on with a bend. Beside that
//! place the time between both is an unknown like others, of either sign.

use super::Shooting;
use super::at_jumps::differ;
use crate::analysis::continuation::{
    Condition, Left, NewtonError, Problem, Station, newton, tangent,
};
use crate::analysis::periodic::cycle::itinerary::{Passage, Step};
use crate::analysis::periodic::cycle::joint::forgets;
use crate::analysis::periodic::cycle::rotate::rotate;
use crate::analysis::periodic::error::PeriodicError;
use crate::expressions::{LookedUpIn, Side};
use crate::flow::leg::{Jump, LegKind};
use crate::flow::{Closed, GuardKind};
use crate::numerics::{Real, dot};

/// An event of an orbit after the exchange is where it was before, to this part of the states' sizes: where it is not, one of the events
/// changes what the other does.
const SMOOTH: f64 = 1e-6;

/// Events share an instant if the time between them is no more than this part of the period.
const ONE_INSTANT: f64 = 1e-10;

/// The legs of two events that may change places, the first of them first, and those of the same as they are afterwards.
struct Exchange {
    first: Step,
    second: Step,
}

/// The lookup and the step to the next piece, where a leg ends with a piece.
fn piece(kind: LegKind) -> Option<(usize, i64)> {
    let Some(GuardKind::Piece(lookup, side)) = kind.ends_at else {
        return None;
    };
    let by = match side {
        Side::Above => 1,
        Side::Below => -1,
        Side::Sliding => return None,
    };
    (kind.jump == Jump::None).then_some((lookup, by))
}

/// Whether a leg ends at the knot of a table.
fn is_knot_of_table<R: Real>(shooting: &Shooting<R>, kind: LegKind) -> bool {
    let lookups = &shooting.workshop.system.corners().lookups;
    let within = |(lookup, _): (usize, i64)| lookups.get(lookup).map(|of| &of.within);
    matches!(piece(kind).and_then(within), Some(LookedUpIn::Curve(_)))
}

/// Whether the leg ends with a jump that may leave another one as it is, or where a surface is crossed.
fn passes(kind: LegKind) -> bool {
    match kind.ends_at {
        Some(GuardKind::Gap(_) | GuardKind::Section(_)) => {
            matches!(kind.jump, Jump::Impact(_) | Jump::Reset(_))
        }
        Some(GuardKind::Switch(_)) => kind.jump == Jump::None,
        _ => false,
    }
}

impl<R: Real> Shooting<R> {
    /// Whether the event at the end of a step, or the one before, is the knot of a table: so nothing happens where they change places.
    pub(crate) fn is_knot(&self, index: usize) -> bool {
        let mut both = [self.before(index), index]
            .into_iter()
            .map(|k| &self.steps[k]);
        both.any(|step| {
            step.flight()
                .is_some_and(|kind| is_knot_of_table(self, kind))
        })
    }

    /// Whether the event at the end of a step may change places with the one before.
    pub(super) fn may_exchange(&self, index: usize) -> bool {
        self.exchange(index).is_some()
            || self.is_way_back(index)
            || self.cut_short(index).is_some()
            || self.led_onto(index).is_some()
    }

    fn exchange(&self, index: usize) -> Option<Exchange> {
        if self.steps.len() < 2 {
            return None;
        }
        let (before, after) = (self.before(index), self.after(index));
        let [first, second, next] = [before, index, after].map(|k| &self.steps[k]);
        let (Passage::Leg(one), Passage::Leg(other), Passage::Leg(_)) =
            (first.passage, second.passage, next.passage)
        else {
            return None;
        };
        let moved = |pieces: &[i64], (lookup, by): (usize, i64)| {
            let mut pieces = pieces.to_vec();
            pieces[lookup] += by;
            pieces
        };
        // Across the end of a cycle pieces are numbered a turn on.
        let wraps = index == 0;
        let opens_none = {
            let closed = self.closed_before(before);
            first.closed == closed && second.closed == closed
        };
        let in_other_order = || {
            let modes = [first.mode(), second.mode(), next.mode()];
            let between = self.workshop.system.in_other_order(modes);
            between.filter(|_| opens_none)
        };
        // The mode between the event and the end of the piece in the other order: where a function jumps from piece to piece other events may
        // come about by that, and what it is compared with may be on the other side from there on.
        let beside_piece = |event: LegKind, (ends, changes, kept): (LegKind, bool, usize)| {
            if !(is_knot_of_table(self, ends) || passes(event)) {
                return None;
            }
            match changes {
                false => Some(kept),
                true => in_other_order().filter(|_| passes(event)),
            }
        };
        match (piece(one), piece(other)) {
            // The event, then the end of a piece.
            (None, Some(by)) => {
                let changes = next.mode() != second.mode();
                let between = beside_piece(one, (other, changes, one.mode))?;
                let passes = wraps || first.pieces == second.pieces;
                passes.then(|| Exchange {
                    first: Step {
                        passage: Passage::Leg(LegKind {
                            mode: one.mode,
                            ..other
                        }),
                        closed: self.closed_before(before),
                        told: Vec::new(),
                        ..first.clone()
                    },
                    second: Step {
                        passage: Passage::Leg(LegKind {
                            mode: between,
                            ..one
                        }),
                        pieces: moved(&first.pieces, by),
                        closed: first.closed,
                        told: first.told.clone(),
                        ..second.clone()
                    },
                })
            }
            // The end of a piece, then the event.
            (Some(by), None) => {
                let changes = first.mode() != second.mode();
                let between = beside_piece(other, (one, changes, next.mode()))?;
                let passes = wraps || moved(&first.pieces, by) == second.pieces;
                passes.then(|| Exchange {
                    first: Step {
                        passage: Passage::Leg(LegKind {
                            mode: one.mode,
                            ..other
                        }),
                        closed: second.closed,
                        told: second.told.clone(),
                        ..first.clone()
                    },
                    second: Step {
                        passage: Passage::Leg(LegKind {
                            mode: between,
                            ..one
                        }),
                        pieces: first.pieces.clone(),
                        closed: second.closed,
                        told: Vec::new(),
                        ..second.clone()
                    },
                })
            }
            (None, None) => {
                if !(passes(one) && passes(other) && one.ends_at != other.ends_at) {
                    return None;
                }
                let in_pieces = wraps || first.pieces == second.pieces;
                let between = in_other_order().filter(|_| in_pieces)?;
                // What only a state on the other side asks for is not met from this one.
                if !(self.meets(one.mode, other.ends_at) && self.meets(between, one.ends_at)) {
                    return None;
                }
                Some(Exchange {
                    first: Step {
                        passage: Passage::Leg(LegKind {
                            mode: one.mode,
                            ..other
                        }),
                        closed: second.closed,
                        told: second.told.clone(),
                        ..first.clone()
                    },
                    second: Step {
                        passage: Passage::Leg(LegKind {
                            mode: between,
                            ..one
                        }),
                        told: first.told.clone(),
                        ..second.clone()
                    },
                })
            }
            _ => None,
        }
    }

    /// Whether a mode has a guard to meet.
    pub(in crate::analysis::periodic) fn meets(
        &self,
        mode: usize,
        guard: Option<GuardKind>,
    ) -> bool {
        let origin = self.workshop.system.origin_of(mode);
        origin.is_some_and(|(.., on)| match guard {
            Some(GuardKind::Switch(surface)) => on.followed.surfaces.contains(surface),
            Some(GuardKind::Piece(lookup, _)) => on.followed.lookups.contains(lookup),
            _ => true,
        })
    }

    /// Whether what a step ends at is that the sliding of a contact turns.
    pub(crate) fn is_turn(&self, contact: usize, ends_at: GuardKind) -> bool {
        let rubbing = self.workshop.system.rubbing_at(contact);
        rubbing.is_some_and(|rubbing| ends_at == GuardKind::Switch(rubbing.surface))
    }
}

/// Equations after an exchange, with a guess of their solution and the new number of each event.
pub(crate) struct Exchanged {
    pub shooting: Shooting<f64>,
    pub guess: Vec<f64>,
    pub numbers: Vec<usize>,
    /// Where the last step stood among the unknowns, if it is the first one now.
    last: Option<usize>,
    /// The step between both events.
    pub between: usize,
}

impl Exchanged {
    /// A direction of the unknowns as they were, in the order that they have now.
    pub(crate) fn direction(&self, before: &[f64]) -> Vec<f64> {
        let mut direction = match self.last {
            None => before.to_vec(),
            Some(last) => {
                let (nodes, free) = before.split_at(before.len() - self.shooting.parameters());
                [&nodes[last..], &nodes[..last], free].concat()
            }
        };
        let place = |index: usize| self.shooting.duration_place(index);
        if let Some(between) = place(self.between) {
            let early = direction[between];
            direction[between] = -early;
            let beside = [
                self.shooting.before(self.between),
                self.shooting.after(self.between),
            ];
            for beside in beside {
                if let Some(beside) = place(beside) {
                    direction[beside] += early;
                }
            }
        }
        direction
    }

    /// Where the time between both events stands among the unknowns: it is to grow.
    pub(crate) fn grows(&self) -> Option<usize> {
        self.shooting.duration_place(self.between)
    }
}

impl Shooting<f64> {
    /// The step whose event has passed the one before, which it may, at a point.
    pub(crate) fn passed(&self, at: &[f64]) -> Option<usize> {
        (0..self.steps.len()).find(|&index| {
            let duration = self.duration_place(index).map_or(0.0, |place| at[place]);
            duration < 0.0 && self.exchange(index).is_some()
        })
    }

    /// The step whose event passes the one before at a station, but for rounding, on the way along the curve, and may.
    pub(crate) fn passes_there(&self, station: &Station) -> Option<usize> {
        let instant = ONE_INSTANT * self.period();
        (0..self.steps.len()).find(|&index| {
            self.duration_place(index).is_some_and(|place| {
                station.at[place].abs() <= instant
                    && station.tangent[place] < 0.0
                    && self.exchange(index).is_some()
            })
        })
    }

    /// The equations with the event at the end of a step before the one that it has passed.
    pub(crate) fn exchanged(&self, at: &[f64], index: usize) -> Result<Exchanged, PeriodicError> {
        let mut steps = self.current_steps(at);
        let count = steps.len();
        let mut numbers: Vec<usize> = (0..count).collect();
        let (mut whole, mut index) = (self.clone(), index);
        let last = (index == 0).then(|| self.places[count - 1]);
        if index == 0 {
            // Functions of the user's are told at the first node.
            if !self.workshop.monitors.is_empty() {
                return Err(unfollowed());
            }
            let parameters = self.workshop.parameters(self.free(at));
            let cycle = (&mut *steps, &*self.counts);
            rotate(&self.workshop, &parameters, cycle, count - 1)?;
            numbers
                .iter_mut()
                .for_each(|number| *number = self.after(*number));
            index = 1;
            whole.steps.clone_from(&steps);
        }
        let Exchange { first, second } = whole.exchange(index).ok_or_else(unfollowed)?;
        let (early, next) = (steps[index].duration, self.after(index));
        steps[index - 1].duration += early;
        steps[next].duration += early;
        let (before, own) = (steps[index - 1].duration, -early);
        steps[index - 1] = Step {
            duration: before,
            start: steps[index - 1].start.clone(),
            ..first
        };
        steps[index] = Step {
            duration: own,
            start: steps[index].start.clone(),
            ..second
        };
        numbers.iter_mut().for_each(|number| {
            *number = match *number {
                same if same == index => index - 1,
                same if same + 1 == index => index,
                other => other,
            }
        });
        let mut shooting = Self::new(&self.workshop, steps, self.counts.clone())?;
        shooting.keep_sizes(&self.state_sizes());
        shooting.told.clone_from(&self.told);
        // It is told after the same event as before.
        shooting.told_node = (self.told_node.filter(|&node| node < count))
            .map(|node| shooting.after(numbers[self.before(node)]));
        shooting.stands_for_section = self.stands_for_section;
        let mut guess = shooting.guess(self.free(at));
        // The state between both is another one now.
        let left = |left: Left| PeriodicError::NoConvergence {
            how: left.to_string(),
        };
        shooting.evaluate(&guess).map_err(left)?;
        let image = shooting.latest[index - 1].image.clone();
        let place = shooting.places[index];
        guess[place..place + image.len()].copy_from_slice(&image);
        Ok(Exchanged {
            shooting,
            guess,
            numbers,
            last,
            between: index,
        })
    }

    /// Whether both events are impacts, and the orbit comes to a rest later on that holds all that these can change: it forgets their order.
    fn rests_after_both(&self, index: usize) -> bool {
        let both = [self.before(index), index].map(|k| self.steps[k].impact());
        let [Some(one), Some(other)] = both else {
            return false;
        };
        let (system, contacts) = (&self.workshop.system, Closed::NONE.with(one).with(other));
        let mut modes = self.steps.iter().map(Step::mode);
        modes.any(|mode| forgets(system, mode, contacts))
    }

    /// Whether it shows in derivatives which of both comes first.
    pub(crate) fn order_shows(exchanged: &Exchanged) -> Result<bool, PeriodicError> {
        if exchanged.shooting.rests_after_both(exchanged.between) {
            return Ok(false);
        }
        let left = |left: Left| PeriodicError::NoConvergence {
            how: left.to_string(),
        };
        let back = exchanged
            .shooting
            .exchanged(&exchanged.guess, exchanged.between)?;
        let [one, other] = [exchanged, &back].map(|of| {
            let chain = of.between - 1..of.between + 1;
            of.shooting.clone().derivative(&of.guess, chain)
        });
        let sizes = exchanged.shooting.state_sizes();
        Ok(differ(&one.map_err(left)?, &other.map_err(left)?, &sizes))
    }

    /// The same, solved at these free parameters.
    pub(crate) fn exchanged_and_solved(
        &self,
        at: &[f64],
        index: usize,
    ) -> Result<(Self, Vec<f64>), PeriodicError> {
        let Exchanged {
            mut shooting,
            guess,
            ..
        } = self.exchanged(at, index)?;
        let rows = Condition::held(&guess, guess.len() - shooting.parameters()..guess.len());
        let failed = |error: NewtonError| PeriodicError::NoConvergence {
            how: error.to_string(),
        };
        let found = newton(&mut shooting, &guess, &rows).map_err(failed)?;
        shooting.adopt(&found.at);
        Ok((shooting, found.at))
    }
}

/// A station of equations after an exchange, near a guess: the curve goes on in this direction, or, where it bends sharply there, in
/// that in which this unknown grows.
pub(crate) fn station_after(
    problem: &mut dyn Problem<f64>,
    (guess, direction): (&[f64], &[f64]),
    grows: Option<usize>,
) -> Result<Station, NewtonError> {
    let scales = problem.scales().to_vec();
    let row: Vec<f64> = (direction.iter().zip(&scales))
        .map(|(x, scale)| x / (scale * scale))
        .collect();
    let value = dot(&row, guess);
    let held = Condition {
        row: row.clone(),
        value,
    };
    let order_matters = || {
        NewtonError::Left(Left::because(
            "two events change places, and the order in which they come matters",
        ))
    };
    let found = newton(problem, guess, &[held]).map_err(|error| match error {
        NewtonError::Stalled { correction, .. } if correction > SMOOTH => order_matters(),
        other => other,
    })?;
    let far = (found.at.iter().zip(guess).zip(&scales))
        .any(|((x, guess), scale)| (x - guess).abs() > SMOOTH * scale);
    if far {
        return Err(order_matters());
    }
    let mut along = tangent(problem, &found.at, &row)?;
    if grows.is_some_and(|place| along[place] < 0.0) {
        along.iter_mut().for_each(|x| *x = -*x);
    }
    Ok(Station::beginning(found, along))
}

fn unfollowed() -> PeriodicError {
    PeriodicError::Unfollowed {
        what: "two events that may not change places".to_owned(),
    }
}
