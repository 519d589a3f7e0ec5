//! Events that change the state, and impacts that take it across corners.

use super::Trajectory;
use super::recurrence::Latest;
use super::start::is_inside;
use crate::expressions::Surfaces;
use crate::flow::error::FlowError;
use crate::flow::modes::at_contacts::IMPACT_SCALARS;
use crate::flow::modes::closed::Closed;
use crate::flow::modes::limits::Corner;
use crate::flow::occurrence::Occurrence;
use crate::flow::step::{FOREVER, Workspace, flight_time, legal_rates};
use crate::flow::system::System;
use crate::flow::touch::with_terms;
use crate::flow::touching::Touching;
use crate::numerics::{Real, WithTerms};

/// Events without time passing between them: more than so many do not come to an end.
const MOST_RESETS: usize = 1000;

/// A way back to the surface of an event that takes less than this part of the longest step takes no time.
const NO_TIME: f64 = 1e-13;

/// The functions of surfaces that a state lies on.
struct Here<R> {
    corners: Vec<(usize, WithTerms<R>)>,
    events: Vec<(usize, WithTerms<R>)>,
}

/// Surfaces that a reset has left the state on.
#[derive(Default)]
struct Kept {
    surfaces: Surfaces,
    events: Vec<usize>,
}

impl<R: Real> Trajectory<R> {
    /// Changes the state as the event of a section says, on whose surface it lies or across which it has just jumped.
    pub(super) fn reset(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
        (section, jumped): (usize, bool),
    ) -> Result<Occurrence<R>, FlowError> {
        self.burst += 1;
        if self.burst > MOST_RESETS {
            return Err(self.switches_without_end());
        }
        let before = self.surface(system, section)?;
        let here = match jumped {
            true => None,
            false => Some(self.surfaces_here(system, section)?),
        };
        let shifts = self.apply_reset(system, work, (section, jumped))?;
        // Where the event's surface is a corner's, too, the motion says on which side it goes on, and not a rounding error.
        let surface = system.model().sections[section].surface;
        let met = (system.corners().surface(surface)).filter(|_| !jumped);
        let kept = match here {
            Some(here) => self.kept_of(system, here)?,
            None => Kept::default(),
        };
        self.met_with = kept.surfaces;
        let met = met.or(kept.surfaces.members().next());
        let begun = self.begin_anew(system, work, met.map(Corner::Surface));
        self.met_with = Surfaces::default();
        begun?;
        self.shift_columns(system, work, &shifts, -R::ONE)?;
        // On which side of its own surface it has put the state is found anew: that is no crossing.
        self.sides.set(section, R::ZERO);
        if !jumped {
            self.follow_itself(system, section, before)?;
        }
        self.touch_latest(system, (section, &kept.events))?;
        self.may_have_crossed = true;
        Ok(Occurrence::Reset { section })
    }

    /// Goes on from a state that was put somewhere, as from a start; tells of contacts that have opened.
    fn begin_anew(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
        met: Option<Corner>,
    ) -> Result<(), FlowError> {
        let closed = self.closed;
        self.tracker.interrupt();
        self.sequence = 0;
        self.latest_impact = None;
        self.flight_time = R::splat(FOREVER);
        self.enter(system, Closed::NONE)?;
        self.touching = Touching::NONE;
        self.met = met;
        self.settle_corners(system, None)?;
        self.classify(system, work, None)?;
        for contact in closed.contacts().filter(|&c| !self.closed.contains(c)) {
            self.pending.push_back(Occurrence::Release { contact });
        }
        Ok(())
    }

    /// Whether an impact has left the gap of its contact open.
    pub(super) fn is_moved(
        &self,
        system: &System,
        contact: usize,
        gap: &WithTerms<R>,
    ) -> Result<bool, FlowError> {
        if !self.program(system)?.moves_gap.contains(contact) {
            return Ok(false);
        }
        if is_inside(gap) {
            return Err(FlowError::JumpsInside {
                time: self.time.to_f64(),
                contact,
                gap: gap.value.to_f64(),
            });
        }
        Ok(gap.value > gap.level())
    }

    /// What follows an impact, applied already, that has moved the gap of its contact, as a blow does which wears a stop: the next
    /// flight does not begin with the gap closed, and no sequence goes on.
    pub(super) fn moved_apart(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
        contact: usize,
        &[rate_before, rate_after, ..]: &[R; IMPACT_SCALARS],
    ) -> Result<Option<Occurrence<R>>, FlowError> {
        if !self.program(system)?.moves_gap.contains(contact)
            || rate_before >= R::ZERO
            || !legal_rates(rate_before, rate_after)
        {
            return Ok(None);
        }
        let [gap] = self.local_up_to(system, contact)?;
        if !self.is_moved(system, contact, &gap)? {
            return Ok(None);
        }
        self.begin_anew(system, work, None)?;
        self.may_have_crossed = true;
        Ok(Some(Occurrence::Impact {
            contact,
            rate_before,
            rate_after,
            closes: false,
        }))
    }

    /// Where an event has left the state on its own surface, which it was on but for rounding, the flight begins with a zero of
    /// it: so the next one is found however soon it comes, as after an impact. Where it has put it before its surface, the next one is
    /// found if that can be told.
    fn follow_itself(
        &mut self,
        system: &System,
        section: usize,
        before: Option<[WithTerms<R>; 3]>,
    ) -> Result<(), FlowError> {
        let after = self.surface(system, section)?;
        let (Some(before), Some(after)) = (before, after) else {
            return Ok(());
        };
        self.latest_resets
            .resize(system.model().sections.len(), None);
        let now = self.time_parts();
        let latest = self.latest_resets[section].map_or(Latest::first(now), |l| l.then(now));
        self.latest_resets[section] = Some(latest);
        let instant = self.instant();
        if latest.is_lost(&before, &after) || latest.has_vanished(instant) {
            return Err(self.switches_without_end());
        }
        let ([before, ..], [after, rate, acceleration]) = (before, after);
        if after.value.abs() > (before.value.abs() + before.level()).max(after.level()) {
            return Ok(());
        }
        // It comes back at once, and again, with no time left between. What moves as little as rounding does not come back: it rested
        // there, and leaves.
        let moves = rate.value.abs() > rate.level();
        let back = -(rate.value / acceleration.value) * R::splat(2.0);
        if moves && back > R::ZERO && back <= self.longest_step * R::splat(NO_TIME) {
            return Err(self.switches_without_end());
        }
        self.touch_event(system, section, if moves { 1 } else { 2 })
    }

    /// Where other events came at this very instant, or would have, had it been their direction, and the state still lies on their
    /// surfaces, the flight begins with zeros of these, too.
    fn touch_latest(
        &mut self,
        system: &System,
        (section, kept): (usize, &[usize]),
    ) -> Result<(), FlowError> {
        let now = self.time_parts();
        for other in (0..system.model().sections.len()).filter(|&other| other != section) {
            let came =
                (self.latest_resets.get(other)).is_some_and(|l| l.is_some_and(|l| l.is_at(now)));
            let is_kept = kept.contains(&other);
            if !came && !is_kept {
                continue;
            }
            let Some([value, rate, _]) = self.surface(system, other)? else {
                continue;
            };
            let rests = is_kept || value.value.abs() <= value.level();
            if rests && rate.value.abs() > rate.level() {
                self.touch_event(system, other, 1)?;
            }
        }
        Ok(())
    }

    /// The surfaces of corners and of events other than this one that the state lies on, as far as an instant of the motion tells.
    fn surfaces_here(&self, system: &System, section: usize) -> Result<Here<R>, FlowError> {
        let instant = self.instant();
        let is_here = |value: &WithTerms<R>, rate: R| {
            value.value.abs() <= (rate.abs() * instant).max(value.level())
        };
        let corners = self.corner_values(system)?.into_iter();
        let corners = corners.filter(|(_, value, rate)| is_here(value, *rate));
        let mut here = Here {
            corners: corners.map(|(corner, value, _)| (corner, value)).collect(),
            events: Vec::new(),
        };
        for other in (0..system.model().sections.len()).filter(|&other| other != section) {
            if let Some([value, rate, _]) = self.surface(system, other)?
                && is_here(&value, rate.value)
            {
                here.events.push((other, value));
            }
        }
        Ok(here)
    }

    /// Those of them that a reset has left the state on: what is not moved is where it was, and no nearer known for being written anew.
    fn kept_of(&self, system: &System, here: Here<R>) -> Result<Kept, FlowError> {
        let stays = |before: &WithTerms<R>, after: &WithTerms<R>| {
            (after.value - before.value).abs() <= before.level().max(after.level())
        };
        let mut kept = Kept::default();
        if !here.corners.is_empty() {
            for (surface, after, _) in self.corner_values(system)? {
                let mut before = here.corners.iter().filter(|(known, _)| *known == surface);
                if before.any(|(_, before)| stays(before, &after)) {
                    kept.surfaces = kept.surfaces.with(surface);
                }
            }
        }
        for (section, before) in here.events {
            if let Some([after, ..]) = self.surface(system, section)?
                && stays(&before, &after)
            {
                kept.events.push(section);
            }
        }
        Ok(kept)
    }

    /// Lets the flight begin with so many zeros of the surface of an event.
    fn touch_event(&mut self, system: &System, section: usize, roots: u8) -> Result<(), FlowError> {
        let guards = &self.program(system)?.guards;
        if let Some(index) = guards.iter().position(|g| g.section() == Some(section)) {
            self.touching.set(index, roots);
        }
        Ok(())
    }

    fn switches_without_end(&self) -> FlowError {
        FlowError::SwitchesWithoutEnd {
            time: self.time.to_f64(),
            count: self.burst,
        }
    }

    /// The function of the surface of an event, its rate and its acceleration.
    fn surface(
        &self,
        system: &System,
        section: usize,
    ) -> Result<Option<[WithTerms<R>; 3]>, FlowError> {
        let program = self.program(system)?;
        let (Some(Some(tapes)), Some(constants)) =
            (program.resets.get(section), &self.constants[self.mode])
        else {
            return Ok(None);
        };
        let start = (&self.state[..], &self.low[..]);
        let values = with_terms(&tapes.surface, &constants.resets[section][2], start);
        Ok(Some([values[0], values[1], values[2]]))
    }

    fn apply_reset(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
        (section, jumped): (usize, bool),
    ) -> Result<Vec<R>, FlowError> {
        let by_motion = self.ask_at_reset(system, section)?;
        let program = self.program(system)?;
        let (Some(Some(tapes)), Some(constants)) =
            (program.resets.get(section), &self.constants[self.mode])
        else {
            return Ok(Vec::new());
        };
        let constants = constants.resets[section].clone();
        // What has jumped across its surface comes when that has which made it jump.
        let shifts = if jumped {
            self.shifts.clone()
        } else {
            let mut crossing = vec![R::ZERO; tapes.crossing.outputs.len()];
            let start = (&self.state[..], &self.low[..]);
            work.values_at(&tapes.crossing, &constants[1], start, &mut crossing);
            let shift = |&slope: &R| -(slope / crossing[0]);
            crossing[1..].iter().map(shift).collect()
        };
        self.shift_columns(system, work, &shifts, R::ONE)?;
        let mut after = self.state.clone();
        let start = (&self.state[..], &self.low[..]);
        work.values_at(&tapes.after, &constants[0], start, &mut after);
        // What is put at a distance from another state is there to the digits of the distance, not of where that is.
        let mut remainders: Vec<R> = (0..after.len())
            .map(|i| work.point.output_remainder(&tapes.after, i))
            .collect();
        // A whole part jumps at a whole number: where no motion says which, it is that of the very number that it is taken of.
        if !by_motion
            && let Some((_, _, on_sides)) = system.origin_of(self.mode)
            && let Some(Some(whole)) = on_sides.whole_resets.get(section)
        {
            let graph = &on_sides.mechanics.graph;
            let state = &self.state[..self.coordinates];
            let values = graph.evaluate_all(whole, state, &self.parameters);
            for (index, value) in values.into_iter().enumerate() {
                if after[index] != value {
                    (after[index], remainders[index]) = (value, R::ZERO);
                }
            }
        }
        if !after.iter().all(|x| x.is_finite()) {
            return Err(self.left_domain());
        }
        self.state.copy_from_slice(&after);
        self.low.copy_from_slice(&remainders);
        Ok(shifts)
    }

    /// As [`after_impact`](Self::after_impact) where the impact may have taken the state across corners.
    pub(super) fn after_impact_at_corners(
        &mut self,
        system: &System,
        work: &mut Workspace<R>,
        contact: usize,
        mut impact: [R; IMPACT_SCALARS],
    ) -> Result<Option<Occurrence<R>>, FlowError> {
        let fall = self.mode;
        let has_slid = self.rub_at_impact(system, contact, (impact[1] - impact[0], None))?;
        let changes = self.settle_corners(system, None)? || self.mode != fall;
        if changes {
            self.keep_contacts(system, work, &[])?;
        }
        if changes || !has_slid {
            // What follows is moved by another field, or from another state.
            let [_, rate, acceleration, jerk] = self.local(system, contact)?;
            if !has_slid {
                impact[1] = rate.value;
            }
            impact[2] = acceleration.value;
            impact[3] = jerk.value;
            self.flight_time = flight_time(impact[1], impact[2], impact[3]);
        }
        self.follow_tops(system, (contact, fall, changes), &mut impact[5]);
        let program = self.program(system)?;
        self.after_impact(system, work, program, (contact, &impact))
    }
}
