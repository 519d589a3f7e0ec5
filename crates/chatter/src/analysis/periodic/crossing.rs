//! Where an orbit crosses the section: no part of its equations, so that a crossing which comes or goes, or changes places with an
//! impact, is nothing that happens to the orbit.

use super::cycle::itinerary::{Passage, Step};
use super::cycle::rotate::rotate;
use super::cycle::settle::cycle::from_first_turn;
use super::error::PeriodicError;
use super::shooting::{AT_ENDS, Shooting};
use crate::flow::leg::{Jump, Least, LegKind};
use crate::flow::{GuardKind, Settings};

impl Shooting<f64> {
    /// The step that ends with a crossing of the section, if one does.
    fn section_step(&self) -> Option<usize> {
        let section = GuardKind::Section(self.workshop.section?);
        (self.steps.iter()).position(|step| step.ends_at() == Some(section))
    }

    /// Whether the equations have a crossing of the section among their events.
    pub(crate) fn begins_at_section(&self) -> bool {
        self.section_step().is_some()
    }

    /// States that an orbit is known by, wherever it is told from: those after its events, and where it crosses the section; where
    /// nothing happens, that at which its forcing begins.
    pub(crate) fn landmarks(&mut self, at: &[f64]) -> Vec<Vec<f64>> {
        if let Some((other, guess)) = self.told_from_phase_zero(at) {
            return vec![other.node(&guess, 0).to_vec()];
        }
        let nodes = (0..self.steps.len()).map(|index| self.node(at, index).to_vec());
        let mut found: Vec<Vec<f64>> = nodes.collect();
        let crossings = self.crossings_on_the_way(at).into_iter();
        found.extend(crossings.map(|crossing| crossing.state));
        found
    }

    /// The crossings of the section that are no nodes.
    fn crossings_on_the_way(&mut self, at: &[f64]) -> Vec<Least> {
        let Some(section) = self.workshop.section.map(GuardKind::Section) else {
            return Vec::new();
        };
        let least = self.least(at).unwrap_or_default();
        let crossings = least.into_iter().flatten();
        let crossings = crossings.filter(|least| least.guard == section);
        // A leg that the section itself ends does not look for it.
        let ends = |step: &Step| step.ends_at() == Some(section);
        let legs = (0..self.steps.len()).filter(|&index| ends(&self.steps[index]));
        let others = legs.flat_map(|index| self.crossings_of_leg(at, index));
        crossings.chain(others).collect()
    }

    /// How often a period crosses the section.
    pub(crate) fn crossings(&mut self, at: &[f64]) -> usize {
        let section = self.workshop.section.map(GuardKind::Section);
        let ends = |step: &&Step| section.is_some() && step.ends_at() == section;
        self.steps.iter().filter(ends).count() + self.crossings_on_the_way(at).len()
    }

    /// How often a period returns: to the section, or without one, in a model of events alone, to that of them which comes most seldom.
    pub(crate) fn returns(&mut self, at: &[f64]) -> usize {
        if self.workshop.section.is_some() || !self.workshop.is_map_by_events() {
            return self.crossings(at);
        }
        let ends = |event: usize| {
            let event = Some(GuardKind::Section(event));
            let ends = |step: &&Step| step.ends_at() == event;
            self.steps.iter().filter(ends).count()
        };
        let counts = (0..self.workshop.model.sections.len()).map(ends);
        counts.filter(|&count| count > 0).min().unwrap_or(0)
    }

    /// Of an orbit whose only event is one crossing of the section, the others on its way; of one on which nothing happens, all.
    pub(crate) fn other_crossings(&self, at: &[f64]) -> Vec<Least> {
        match self.steps.len() {
            1 => self.crossings_of_leg(at, 0),
            _ => Vec::new(),
        }
    }

    /// The crossings of the section on the way of a leg that another crossing of it ends, or none.
    fn crossings_of_leg(&self, at: &[f64], index: usize) -> Vec<Least> {
        let only = &self.steps[index];
        let Some(section) = self.workshop.section.map(GuardKind::Section) else {
            return Vec::new();
        };
        let (Some(kind), Some(place)) = (only.flight(), self.duration_place(index)) else {
            return Vec::new();
        };
        let goes_around = matches!(only.passage, Passage::Around(_));
        if !(goes_around || kind.ends_at == Some(section)) {
            return Vec::new();
        }
        let on_the_way = LegKind {
            ends_at: None,
            ..kind
        };
        let Some(leg) = self.workshop.leg(on_the_way) else {
            return Vec::new();
        };
        let parameters = self.parameters_of(&self.workshop.parameters(self.free(at)), only);
        let mut flyer = leg.flyer(&Settings::default());
        let way = (self.node(at, index), at[place]);
        let seen = leg.least(&mut flyer, &parameters, way, &|guard| guard == section);
        let inside = match goes_around {
            true => 0.0..at[place],
            false => AT_ENDS * at[place]..(1.0 - AT_ENDS) * at[place],
        };
        let mut seen = seen.unwrap_or_default();
        seen.retain(|least| least.guard == section && inside.contains(&least.time));
        seen
    }

    /// The same orbit, on which nothing happens, told from where the phase of its forcing is a whole number of turns; none where it
    /// is.
    pub(crate) fn told_from_phase_zero(&mut self, at: &[f64]) -> Option<(Self, Vec<f64>)> {
        let [only] = &self.steps[..] else {
            return None;
        };
        let Passage::Timed(_) = only.passage else {
            return None;
        };
        let parameters = self.workshop.parameters(self.free(at));
        let turns = self.workshop.closure.turns(&parameters).ok()?;
        let forced = turns.iter().zip(&self.counts);
        let (turn, &count) = forced
            .filter(|(turn, _)| turn.lap.is_some())
            .find(|(_, count)| **count != 0)?;
        let gone = self.node(at, 0)[turn.state] / turn.period;
        let part = match count > 0 {
            true => gone.ceil() - gone,
            false => gone - gone.floor(),
        };
        if part == 0.0 {
            return None;
        }
        let wait = part * turn.lap.as_ref()?.time;
        self.told_later(at, wait)
    }

    /// The same orbit, on which nothing happens, told so much later.
    pub(in crate::analysis::periodic) fn told_later(
        &mut self,
        at: &[f64],
        wait: f64,
    ) -> Option<(Self, Vec<f64>)> {
        let parameters = self.workshop.parameters(self.free(at));
        let turns = self.workshop.closure.turns(&parameters).ok()?;
        let mut steps = self.current_steps(at);
        steps[0].start = self.flown_on(at, wait)?;
        let known = (&*self.workshop, &*parameters);
        from_first_turn(known, &mut steps, &turns, &self.counts);
        self.like(steps, at).ok()
    }

    /// The node of an event at whose instant the section is crossed: on which leg, if on any, is rounding.
    fn node_at_section(&self, at: &[f64], index: usize) -> Option<Least> {
        let goes_on = |step: &Step| matches!(step.passage, Passage::Leg(_));
        if !goes_on(&self.steps[index]) {
            return None;
        }
        let section = GuardKind::Section(self.workshop.section?);
        let parameters = self.workshop.parameters(self.free(at));
        let (state, time) = (self.node(at, index), at[self.duration_place(index)?]);
        let is_on = self.workshop.is_on_section(state, &parameters, time);
        is_on.then(|| Least {
            guard: section,
            time: 0.0,
            value: 0.0,
            size: 0.0,
            state: state.to_vec(),
            at_end: false,
        })
    }

    /// The crossing of the section nearest to the state that was told last, and the step that it is on.
    fn crossing(&mut self, at: &[f64]) -> Option<(usize, Least)> {
        let section = GuardKind::Section(self.workshop.section?);
        let least = self.least(at).ok()?;
        let crossings = (least.into_iter().enumerate()).flat_map(|(index, all)| {
            let here = all.into_iter().filter(|least| least.guard == section);
            here.map(move |least| (index, least))
        });
        let at_events = (0..self.steps.len())
            .filter_map(|index| Some((index, self.node_at_section(at, index)?)));
        let mut crossings = crossings.chain(at_events);
        let Some(told) = &self.told else {
            return crossings.next();
        };
        let parameters = self.workshop.parameters(self.free(at));
        let turns = self.workshop.closure.turns(&parameters).ok()?;
        let sizes = self.state_sizes();
        let off = |(_, least): &(usize, Least)| {
            let difference =
                (self.workshop.closure).difference(&turns, (told, &least.state), &sizes);
            difference.distance
        };
        crossings.min_by(|a, b| off(a).total_cmp(&off(b)))
    }

    /// The state that the orbit is told from: at the section, or where that is not crossed, after one of its events.
    pub(crate) fn told_state(&mut self, at: &[f64]) -> Vec<f64> {
        let state = match self.section_step() {
            Some(_) => self.node(at, 0).to_vec(),
            None => match self.crossing(at) {
                Some((_, crossing)) => crossing.state,
                None => self.told_after_event(at),
            },
        };
        self.told = Some(state.clone());
        state
    }

    /// The state after the event that the orbit is told from: the same along all of a sequence of events, and where that has become another
    /// one, perhaps begun with another of its events, the one nearest to the state that was told last.
    fn told_after_event(&mut self, at: &[f64]) -> Vec<f64> {
        if self.told_node.is_none_or(|node| node >= self.steps.len()) {
            self.told_node = Some(self.nearest_node(at).unwrap_or(0));
        }
        self.node(at, self.told_node.unwrap_or(0)).to_vec()
    }

    fn nearest_node(&self, at: &[f64]) -> Option<usize> {
        let told = self.told.as_deref()?;
        let parameters = self.workshop.parameters(self.free(at));
        let turns = self.workshop.closure.turns(&parameters).ok()?;
        let sizes = self.state_sizes();
        let off = |&index: &usize| {
            let states = (told, self.node(at, index));
            let difference = (self.workshop.closure).difference(&turns, states, &sizes);
            difference.distance
        };
        (0..self.steps.len()).min_by(|a, b| off(a).total_cmp(&off(b)))
    }

    /// The values of the user's functions there.
    pub(crate) fn monitored(&mut self, at: &[f64]) -> Vec<f64> {
        if self.workshop.monitors.is_empty() {
            return Vec::new();
        }
        let state = self.told_state(at);
        let parameters = self.workshop.parameters(self.free(at));
        let monitors = self.workshop.monitors.iter();
        monitors
            .map(|monitor| monitor.at(&self.workshop.model.graph, &state, &parameters))
            .collect()
    }

    /// The same orbit without crossings of the section among its events, where others are left to tell where it is.
    pub(crate) fn without_section(self, at: Vec<f64>) -> (Self, Vec<f64>) {
        let (mut shooting, mut at) = (self, at);
        let told = shooting
            .section_step()
            .map(|_| shooting.node(&at, 0).to_vec());
        while let Some(index) = shooting.section_step() {
            let Ok((shorter, guess, _)) = shooting.without_event(&at, index) else {
                break;
            };
            (shooting, at) = (shorter, guess);
        }
        shooting.told = told;
        (shooting, at)
    }

    /// The same orbit told from the section, with its crossing for an event. None where it is not crossed.
    pub(crate) fn with_section(
        &mut self,
        at: &[f64],
    ) -> Result<Option<(Self, Vec<f64>)>, PeriodicError> {
        let section = self.workshop.section;
        let (Some((index, crossing)), Some(section)) = (self.crossing(at), section) else {
            return Ok(None);
        };
        let mut steps = self.current_steps(at);
        let whole = steps[index].clone();
        let (Passage::Leg(kind) | Passage::Timed(kind) | Passage::Around(kind)) = whole.passage
        else {
            return Ok(None);
        };
        let crosses = Passage::Leg(LegKind {
            ends_at: Some(GuardKind::Section(section)),
            jump: Jump::None,
            ..kind
        });
        let mut stands_for_it = false;
        let begin = match whole.passage {
            Passage::Timed(_) | Passage::Around(_) => {
                let period = steps.iter().map(|step| step.duration).sum();
                steps = vec![Step {
                    passage: crosses,
                    start: crossing.state,
                    duration: period,
                    ..whole
                }];
                0
            }
            // The event at whose instant it is crossed stands for it.
            _ if crossing.time <= AT_ENDS * whole.duration => {
                stands_for_it = true;
                index
            }
            _ if crossing.time >= (1.0 - AT_ENDS) * whole.duration => {
                stands_for_it = true;
                let mut next = self.after(index);
                while steps[next].is_at_once() {
                    next = self.after(next);
                }
                next
            }
            _ => {
                let first = Step {
                    passage: crosses,
                    duration: crossing.time,
                    told: Vec::new(),
                    closed: self.closed_before(index),
                    ..whole.clone()
                };
                let second = Step {
                    start: crossing.state,
                    duration: whole.duration - crossing.time,
                    ..whole
                };
                steps.splice(index..=index, [first, second]);
                index + 1
            }
        };
        let parameters = self.workshop.parameters(self.free(at));
        rotate(
            &self.workshop,
            &parameters,
            (&mut steps, &self.counts),
            begin,
        )?;
        let turns = self.workshop.closure.turns(&parameters)?;
        let known = (&*self.workshop, &*parameters);
        from_first_turn(known, &mut steps, &turns, &self.counts);
        let (mut shooting, at) = self.like(steps, at)?;
        shooting.stands_for_section = stands_for_it;
        Ok(Some((shooting, at)))
    }
}
