//! Where the flow turns back at once to what is slid along at two places of an orbit at once, as on one that is its own mirror image. If the
//! slip that leads there is its own image backwards in time, as without damping, displacements come back as they were just there: the
//! equations are singular by those that bring the one turn about and put the other off, and with one of both turns alone they have a root that
//! is not simple. With both they have a simple one.

use super::graze::{THERE, moved};
use super::holds::sequence_holds;
use super::touch::{STAYS, Touched};
use crate::analysis::continuation::{
    Coincidence, Coincident, Condition, Curve, Problem, Station, coincidence, newton, tangent,
};
use crate::analysis::periodic::branch::walker::{Stop, Walker};
use crate::analysis::periodic::branch::{Limits, Point};
use crate::analysis::periodic::cycle::itinerary::Passage;
use crate::analysis::periodic::shooting::Shooting;
use crate::analysis::periodic::solved::{NOISE, Solved};
use crate::flow::GuardKind;
use crate::numerics::{Equations, Real, dot};

/// A point is on the way from another one along a direction if it is off by no more than this part of it.
const MOST_ASKEW: f64 = 0.1;

/// Two turns at once.
#[derive(Clone)]
pub(in crate::analysis::periodic::branch) struct Together {
    /// With both turns.
    pub shooting: Shooting<f64>,
    pub at: Vec<f64>,
    /// The steps that they are.
    pub turns: [usize; 2],
    /// The direction of the branch, to where both slips last.
    pub along: Vec<f64>,
}

impl Shooting<f64> {
    /// The equations with a turn and one more of the same surface, that which is nearest to be one, and the steps that both are.
    fn with_other_turn(
        &self,
        at: &[f64],
        (index, guard): (usize, GuardKind),
    ) -> Option<(Self, Vec<f64>, [usize; 2])> {
        let slides = self.after(index);
        let others = (0..self.steps.len()).filter(|&other| {
            let is_leg = matches!(self.steps[other].passage, Passage::Leg(_));
            is_leg && other != slides && self.mode_across(other, guard).is_some()
        });
        let turning = others.filter_map(|other| {
            let (mut both, guess, place) = self.with_turn_at_start(at, (other, guard)).ok()?;
            both.evaluate(&guess).ok()?;
            let first = index + usize::from(index >= place);
            let rate = both.latest.get(place)?.surface_rate.abs();
            Some((rate, both, guess, [first, place]))
        });
        let nearest = turning.min_by(|a, b| a.0.total_cmp(&b.0));
        nearest.map(|(_, both, guess, turns)| (both, guess, turns))
    }

    /// Numbers of the unknowns without those of the node of a step that takes no time.
    fn without_node(&self, numbers: &[f64], index: usize) -> Vec<f64> {
        let node = self.node_places(index);
        [&numbers[..node.start], &numbers[node.end..]].concat()
    }

    /// Where the flow turns at the start of a step and of another one at once; none where no other does.
    fn turns_together(&self, guess: &[f64], index: usize) -> Option<Touched> {
        let guard = self.steps[index].ends_at()?;
        let (mut both, start, turns) = self.with_other_turn(guess, (index, guard))?;
        let coincident = coincidence(&mut both, &start, turns).ok()?;
        // Steps come to nothing so far from there as equations are singular, however narrow the range is.
        let nodes = ..start.len() - both.workshop.free.len();
        if moved(&coincident.found.at[nodes], &start[nodes], both.scales()) > THERE {
            return None;
        }
        let (residual, correction) = (coincident.found.residual, coincident.found.correction);
        let (solved, along) = both.solved_together(coincident, turns)?;
        let (single, ..) = both.without_way_onto(&solved.at, turns[1]).ok()?;
        Some(Touched {
            at: both.without_node(&solved.at, turns[1]),
            told: both.without_node(&solved.told, turns[1]),
            index,
            residual,
            correction,
            error: solved.error,
            shooting: single,
            together: Some(Together {
                at: solved.at,
                shooting: both,
                turns,
                along,
            }),
        })
    }
}

impl Shooting<f64> {
    /// A coincidence in longer numbers, and the direction of its curve; none where the equations do not hold there.
    pub(super) fn solved_together(
        &self,
        coincident: Coincident,
        conditions: [usize; 2],
    ) -> Option<(Solved, Vec<f64>)> {
        let Coincident {
            found,
            column,
            unfolds,
            along,
        } = coincident;
        let mut all = found.at.clone();
        all.push(unfolds);
        let long = column.iter().map(|&x| x.into()).collect::<Vec<_>>();
        let (solved, unfolds) = self.refined_by(found, &all, |fine, at| {
            let mut equations = Coincidence::with_column(fine, conditions, long.clone());
            let left = equations.evaluate(at).ok()?.residual;
            Some(left.iter().map(|x| x.to_f64()).collect())
        });
        // They come at once if the equations hold there.
        let unfolds = *unfolds.first()?;
        let off: Vec<f64> = column.iter().map(|by| by * unfolds).collect();
        (self.apart(&off) <= NOISE * f64::EPSILON).then_some((solved, along))
    }
}

impl Touched {
    /// The same where the flow turns at the start of a step: with another such place, if both come at once.
    pub(in crate::analysis::periodic::branch) fn solve_turn(
        (shooting, guess, index): (Shooting<f64>, Vec<f64>, usize),
    ) -> Result<Self, String> {
        match shooting.turns_together(&guess, index) {
            Some(touched) => Ok(touched),
            None => Self::solve((shooting, guess, index)),
        }
    }
}

impl Together {
    /// How fast each of both slips comes to last along the branch, and how far along it the first one lasts so long.
    fn slips(&mut self, duration: f64) -> Option<([f64; 2], f64)> {
        let mut grow = [0.0; 2];
        for (grows, turn) in grow.iter_mut().zip(self.turns) {
            let (_, slopes) = self.shooting.monitor(turn, &self.at).ok()?;
            // The rate with which the surface is left comes back to nothing in half the time that the way back takes.
            let slows = self.shooting.latest.get(turn)?.surface_acceleration;
            *grows = -2.0 * dot(&slopes, &self.along) / slows;
        }
        let ahead = duration / grow[0];
        let all = grow.iter().all(|grows| *grows > 0.0) && ahead.is_finite();
        all.then_some((grow, ahead))
    }

    /// The first station with both slips, which last so long there.
    fn with_slips(&mut self, duration: f64) -> Result<(Shooting<f64>, Station), String> {
        let told = |error: &dyn core::fmt::Display| error.to_string();
        let (grow, ahead) = (self.slips(duration)).ok_or("slips that do not grow at once")?;
        let beside = along(&self.at, &self.along, ahead);
        let mut steps = self.shooting.current_steps(&beside);
        for (turn, grows) in self.turns.into_iter().zip(grow) {
            if let Passage::AtOnce(kind) = steps[turn].passage {
                steps[turn].passage = Passage::Leg(kind);
            }
            steps[turn].duration = grows * ahead;
        }
        let longer = self.shooting.like(steps, &beside);
        let (mut longer, mut guess) = longer.map_err(|error| told(&error))?;
        longer.evaluate(&guess).map_err(|left| told(&left))?;
        for (turn, grows) in self.turns.into_iter().zip(grow) {
            // What slides from there on begins as much later.
            let next = longer.after(turn);
            guess[longer.node_places(next)].copy_from_slice(&longer.latest[turn].image);
            if let Some(place) = longer.duration_place(next) {
                guess[place] -= grows * ahead;
            }
        }
        let place = longer.duration_place(self.turns[0]);
        let place = place.ok_or("a slip without duration")?;
        let fixed = Condition::fixed(guess.len(), place, guess[place]);
        let found = newton(&mut longer, &guess, core::slice::from_ref(&fixed));
        let found = found.map_err(|error| told(&error))?;
        let is_there = moved(&found.at, &guess, longer.scales()) <= THERE
            && sequence_holds(&mut longer, &found.at);
        if !is_there {
            return Err("no motion slips on where friction would have to hold too much".to_owned());
        }
        let along = tangent(&mut longer, &found.at, &fixed.row).map_err(|error| told(&error))?;
        Ok((longer, Station::beginning(found, along)))
    }

    /// The first station on the side on which the flow sticks at both places at once, as far from there as such slips last on the other; within
    /// limits, if there is one.
    pub(in crate::analysis::periodic::branch) fn without_slips(
        &mut self,
        limits: &Limits,
    ) -> Option<(Shooting<f64>, Station)> {
        let mut turns = self.turns;
        turns.sort_unstable_by(|a, b| b.cmp(a));
        let mut steps = self.shooting.current_steps(&self.at);
        let mut at = self.at.clone();
        let mut tangent: Vec<f64> = self.along.iter().map(|x| -x).collect();
        for turn in turns {
            // Nodes of later steps are the first to go, so that places of the others are what they were.
            (at, tangent) = (
                self.shooting.without_node(&at, turn),
                self.shooting.without_node(&tangent, turn),
            );
            steps.remove(turn);
        }
        let (mut shorter, _) = self.shooting.like(steps, &self.at).ok()?;
        let there = Station {
            at,
            tangent,
            residual: 0.0,
            correction: 0.0,
            orientation: 0.0,
        };
        let period = self.shooting.period();
        let mut found = STAYS.iter().filter_map(|part| {
            let (_, ahead) = self.slips(part * period)?;
            let (next, _) = there.ahead(&mut shorter, ahead).ok()?;
            let expected = along(&there.at, &there.tangent, ahead);
            let off = next.distance(&expected, shorter.scales());
            let holds = sequence_holds(&mut shorter, &next.at);
            (holds && off <= MOST_ASKEW * ahead).then_some(next)
        });
        let farthest = found.next()?;
        let inside = |next: &Station| limits.beyond(next.parameter()).is_none();
        let next = match inside(&farthest) {
            true => farthest,
            false => found.find(inside).unwrap_or(farthest),
        };
        Some((shorter, next))
    }
}

fn along(from: &[f64], direction: &[f64], ahead: f64) -> Vec<f64> {
    let parts = from.iter().zip(direction);
    parts.map(|(x, by)| x + ahead * by).collect()
}

impl Walker {
    /// Where the stick that a step is begins with a force that friction just holds, if another one does so at once.
    pub(super) fn sticks_just_hold(
        &self,
        station: &Station,
        (index, guard): (usize, GuardKind),
    ) -> Option<Touched> {
        let GuardKind::Leave(surface, _) = guard else {
            return None;
        };
        let begins = (index, GuardKind::Switch(surface));
        let turn = self.shooting.with_turn_at_start(&station.at, begins);
        let (turn, guess, index) = turn.ok()?;
        turn.turns_together(&guess, index)
    }

    /// On from there with the slips that come in.
    pub(super) fn slips_come_in(
        &mut self,
        mut touched: Touched,
        there: &Point,
    ) -> Result<Station, String> {
        let together = touched.together.take();
        self.note_touch(there, touched);
        let mut together = together.ok_or("one slip alone comes in")?;
        let period = self.shooting.period();
        let mut found = Err("a stick is over, and no slip begins there".to_owned());
        for part in STAYS {
            let with = together.with_slips(part * period);
            let is_inside = |next: &Station| self.limits.beyond(next.parameter()).is_none();
            match with {
                Ok((longer, next)) if is_inside(&next) => {
                    found = Ok((longer, next));
                    break;
                }
                // Beyond the range if there is none within it.
                other if found.is_err() => found = other,
                _ => {}
            }
        }
        let (longer, next) = found?;
        self.shooting = longer;
        self.settle(&next);
        Ok(next)
    }

    /// The same where steps towards that place come to nothing. Whether that is so.
    pub(in crate::analysis::periodic::branch) fn slips_begin(
        &mut self,
        curve: &mut Curve,
        here: &mut Point,
    ) -> bool {
        let (station, told) = (curve.station.clone(), self.special.len());
        self.settle(&station);
        let forward = self.heading_known(&station);
        let sticks = self.shooting.steps.iter().enumerate();
        let sticks = sticks.filter_map(|(index, step)| Some((index, step.ends_at()?)));
        let mut places = sticks.filter_map(|stick| self.sticks_just_hold(&station, stick));
        let is_ahead = |touched: &Touched| {
            let value = touched.at.last().copied().unwrap_or(f64::NAN);
            forward.is_some_and(|forward| (value - station.parameter()) * forward > 0.0)
        };
        let Some(touched) = places.find(is_ahead) else {
            return false;
        };
        drop(places);
        let outcome = self.slips_come_in(touched, &here.clone());
        let begins = matches!(self.goes_on(outcome, (curve, forward), here), Stop::On);
        if !begins {
            self.special.truncate(told);
            self.settle(&station);
        }
        begins
    }
}
