//! What rests at the end of a stretch that is followed as a whole, and the forces on it: these may touch zero on the way, where the
//! stretch would end too soon.

use super::Shooting;
use crate::analysis::continuation::{Left, Problem};
use crate::analysis::periodic::branch::VANISHED;
use crate::analysis::periodic::cycle::itinerary::{Passage, Step};
use crate::analysis::periodic::error::PeriodicError;
use crate::flow::leg::{Jump, Least, LegKind, StretchKind};
use crate::flow::{Closed, GuardKind, Settings};

/// The way from where the mode that a stretch ends in begins.
struct Rest {
    /// The stretch, and its way at rest.
    whole: StretchKind,
    /// Since the start of the stretch.
    began: f64,
    state: Vec<f64>,
    closed: Closed,
}

impl Shooting<f64> {
    /// After an evaluation.
    fn rest(&self, index: usize, at: &[f64]) -> Option<Rest> {
        let Passage::Stretch(whole) = self.steps[index].passage else {
            return None;
        };
        let (clock, instants) = self.instants_within(index, at);
        // Where a force all but vanishes the motion may be released there by rounding: what comes after the last of the chatter says nothing.
        let mut left = whole.accumulations;
        let first = instants.into_iter().find(|instant| {
            left -= usize::from(instant.ends_chatter()).min(left);
            left == 0 && instant.mode_after == whole.last.mode
        })?;
        Some(Rest {
            whole,
            began: first.time - clock,
            state: first.state,
            closed: first.closed,
        })
    }

    /// The inner least values of the forces on closed contacts, by step, the times since its start: on legs, and on the ways at rest that
    /// stretches end with.
    pub(crate) fn least_forces(&mut self, at: &[f64]) -> Result<Vec<(usize, Least)>, Left> {
        self.evaluate(at)?;
        let mut found: Vec<(usize, Least)> = Vec::new();
        for (index, all) in self.least(at)?.into_iter().enumerate() {
            found.extend(all.into_iter().map(|least| (index, least)));
            let Some(rest) = self.rest(index, at) else {
                continue;
            };
            let Some(leg) = self.workshop.leg(rest.whole.last) else {
                continue;
            };
            let parameters = self.workshop.parameters(self.free(at));
            let all = self.parameters_of(&parameters, &self.steps[index]);
            let way = (&*rest.state, self.latest[index].duration - rest.began);
            if way.1 <= 0.0 {
                continue;
            }
            let mut flyer = leg.flyer(&Settings::default());
            let seen = leg.least(&mut flyer, &all, way, &|_| false);
            found.extend(seen.map_err(Left::because)?.into_iter().map(|least| {
                let time = rest.began + least.time;
                (index, Least { time, ..least })
            }));
        }
        found.retain(|(_, least)| matches!(least.guard, GuardKind::Reaction(_)) && !least.at_end);
        Ok(found)
    }

    /// The steps of a stretch whose way at rest a guard touches: up to halfway to there, in a given time, and on as legs.
    pub(crate) fn with_touch_at_rest(
        &self,
        at: &[f64],
        index: usize,
        least: &Least,
    ) -> Result<[Step; 3], PeriodicError> {
        let unfollowed = || PeriodicError::Unfollowed {
            what: "a touch within what is followed as a whole".to_owned(),
        };
        let rest = self.rest(index, at).ok_or_else(unfollowed)?;
        let (kind, way) = (rest.whole.last, least.time - rest.began);
        let waits = LegKind {
            ends_at: None,
            jump: Jump::None,
            ..kind
        };
        let leg = self.workshop.leg(waits).filter(|_| way > 0.0);
        let leg = leg.ok_or_else(unfollowed)?;
        let parameters = self.workshop.parameters(self.free(at));
        let whole = Step {
            closed: rest.closed,
            told: Vec::new(),
            ..self.steps[index].clone()
        };
        let all = self.parameters_of(&parameters, &whole);
        let mut flyer = leg.flyer(&Settings::default());
        let halfway = leg.fly(&mut flyer, &all, &rest.state, 0.5 * way);
        let halfway = halfway.map_err(|_| unfollowed())?.image;
        let rests = Step {
            passage: Passage::Stretch(rest.whole.up_to(waits)),
            start: self.node(at, index).to_vec(),
            duration: rest.began + 0.5 * way,
            ..whole.clone()
        };
        let touches = Step {
            passage: Passage::Leg(LegKind {
                ends_at: Some(least.guard),
                ..waits
            }),
            start: halfway,
            duration: 0.5 * way,
            ..whole
        };
        let leaves = Step {
            passage: Passage::Leg(kind),
            start: least.state.clone(),
            duration: self.latest[index].duration - least.time,
            ..self.steps[index].clone()
        };
        Ok([rests, touches, leaves])
    }

    /// Whether a contact that opens strikes again after next to no time.
    pub(crate) fn opening_vanishes(&self, at: &[f64]) -> bool {
        let period = self.period();
        self.steps.iter().enumerate().any(|(index, step)| {
            let Some(GuardKind::Reaction(contact)) = step.ends_at() else {
                return false;
            };
            let flight = self.after(index);
            let strikes = self.steps[flight].impact() == Some(contact);
            let place = self.duration_place(flight).filter(|_| strikes);
            place.is_some_and(|place| at[place] < VANISHED * period)
        })
    }

    /// How many chatter sequences come to their end.
    pub(crate) fn accumulations(&self) -> usize {
        let ends = |step: &Step| match step.passage {
            Passage::Stretch(kind) => kind.accumulations,
            _ => 0,
        };
        self.steps.iter().map(ends).sum()
    }
}
