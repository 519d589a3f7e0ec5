//! From one sequence of events to the next, where an impact comes in or goes out.

use super::holds::{Broken, break_before, first_break, smallest};
use super::together::begins;
use super::touch::Touched;
use crate::analysis::continuation::{Curve, Problem, Station, tangent};
use crate::analysis::periodic::branch::limits::End;
use crate::analysis::periodic::branch::walker::{Stop, Walker};
use crate::analysis::periodic::branch::{Point, Special, SpecialKind};
use crate::analysis::periodic::condition::Bordered;
use crate::analysis::periodic::error::PeriodicError;
use crate::analysis::periodic::orbit::shorter;
use crate::analysis::periodic::shooting::{Exchanged, Shooting, station_after};
use crate::analysis::periodic::solved::roundoff;
use crate::flow::GuardKind;
use crate::flow::leg::Least;

/// This part of a step before a graze.
const NOT_QUITE: f64 = 1e-5;
/// This part of a step is no way from where the sequence of events breaks.
const BESIDE: f64 = 1e-2;
/// Flights are told from rounding of the gap if they are so many times as high.
pub(super) const LEAST_HEIGHT: f64 = 1e4;
/// Where they are no more than so many times as high, that is why no solution is found, and multipliers have few digits.
pub(in crate::analysis::periodic::branch) const SMALL_HEIGHT: f64 = 1e6;
/// A graze that Newton's method finds farther from where it is looked for, against the size of the orbit, is another one.
pub(in crate::analysis::periodic::branch) const THERE: f64 = 1e-3;
/// Orbits of a branch are solved to so small a part of their size, and so are places that are told from their guards.
const SOLVED: f64 = 1e-12;
/// A part of a direction that is less than this is rounding.
const FLAT: f64 = 1e-6;
/// Where a new sequence begins its steps, against those before.
pub(super) const CAREFUL: f64 = 0.05;

impl Walker {
    /// Whether a gap has its least value where its rate turns at the end of a step, with the surface that ends it.
    fn touches_at_turn(&mut self, station: &Station, index: usize, contact: usize) -> bool {
        let least = self.shooting.least(&station.at);
        least.is_ok_and(|least| {
            let known = (&*station.at, &*least);
            self.shooting.touches_at_turn(known, (index, contact))
        })
    }

    /// Whether a step follows an impact that has no rate left.
    fn follows_graze(&self, index: usize) -> bool {
        let count = self.shooting.steps.len();
        let before = self.shooting.before(index);
        let rate = |index: usize| {
            let landing = self.shooting.latest.get(index);
            landing.map_or(0.0, |landing| landing.surface_rate.abs())
        };
        let most = (0..count).map(rate).fold(0.0, f64::max);
        self.shooting.steps[before].impact().is_some() && rate(before) <= NOT_QUITE * most
    }

    /// Goes on past the first place where the sequence of events breaks.
    pub(in crate::analysis::periodic::branch) fn pass(
        &mut self,
        curve: &mut Curve,
        step: f64,
        broken: Vec<Broken>,
        here: &mut Point,
    ) -> Stop {
        let from = curve.station.clone();
        let mut reader = self.shooting.clone();
        let first = first_break(
            &mut self.shooting,
            (&mut reader, None),
            (&from, step),
            broken,
        );
        let first =
            first.map(|first| break_before(&mut self.shooting, &mut reader, (&from, step), first));
        let Some((broken, station, reached)) = first else {
            if let Some(end) = self.ends_with_strike(&from, here) {
                return Stop::End(end);
            }
            let end = End::Lost("the sequence of events changes".to_owned());
            return Stop::Broken(end, Box::new(from));
        };
        if let Some(edge) = self.limits.beyond(station.parameter())
            && let Some(end) = self.ends_at_edge((&from, &station), (reached, edge), here)
        {
            return Stop::End(end);
        }
        // One of two that share an instant, of which a jump makes the other unneeded, goes out or comes in.
        let passes = match broken {
            Broken::Passed(index) => {
                (self.hold_vanishes((curve, reached), (&station, index), here))
                    .or_else(|| self.crossing_vanishes((curve, reached), (&station, index), here))
            }
            Broken::Early(index, guard @ (GuardKind::Switch(_) | GuardKind::Piece(..)))
            | Broken::Beyond(index, guard @ (GuardKind::Switch(_) | GuardKind::Piece(..))) => {
                (self.hold_comes_in((curve, reached), (&station, index, guard), here)).or_else(
                    || self.crossing_comes_in((curve, reached), (&station, index, guard), here),
                )
            }
            _ => None,
        };
        if let Some(stop) = passes {
            return stop;
        }
        if self.shooting.flight_breaks(&station.at, &broken)
            && let Some(stop) = self.flight_ends(Some((&station, reached)), curve, here)
        {
            return stop;
        }
        self.settle(&station);
        // With a stay that is over a corner within it shares the instant of the crossing and of the way back.
        if let Broken::Passed(index) = broken
            && !(self.shooting).stay_with_corner_vanishes(&station.at, index)
        {
            return self.exchange((curve, step, reached), (station, index), here);
        }
        if let Broken::Event(index)
        | Broken::Early(index, GuardKind::Switch(_) | GuardKind::Section(_))
        | Broken::Beyond(index, GuardKind::Switch(_) | GuardKind::Section(_)) = broken
            && let Some(end) = self.shrinks(&from, (&station, reached), (index, here))
        {
            return Stop::End(end);
        }
        self.settle(&station);
        // Of such a flight rounding says where the curve goes, too.
        if let Broken::Event(index) | Broken::Inner(index, GuardKind::Gap(_)) = broken
            && !self.is_flight(&station, index)
            && self.stays_closed(curve, here)
        {
            return Stop::On;
        }
        self.settle(&station);
        // Where what begins with a release has come to nothing, rounding says in which way it breaks.
        if self.shooting.opening_vanishes(&station.at) {
            let end = End::Lost(broken.told(&self.shooting));
            return Stop::Broken(end, Box::new(station));
        }
        // Special points before it.
        let there = Point::new(&mut self.shooting, &station);
        // Where an impact loses its rate multipliers have a pole: not quite there.
        let close = reached * (1.0 - NOT_QUITE);
        let mut just_before = from.clone();
        if let Ok((nearly, _)) = from.ahead(&mut self.shooting, close) {
            self.settle(&nearly);
            let near = Point::new(&mut self.shooting, &nearly);
            let before = here.clone();
            let points = (&before, &near);
            if let Some(end) = self.between_beside_graze((&from, &nearly), close, points, false) {
                return Stop::End(end);
            }
            just_before = nearly;
        }
        // What is left of slips that come to nothing with the impact before them breaks in whichever way rounding says.
        if let Some(end) = self.ends_with_strike(&from, &there) {
            return Stop::End(end);
        }
        self.settle(&station);
        let is_less = |walker: &mut Self, roundoffs: f64| match broken {
            Broken::Inner(index, GuardKind::Gap(contact)) => {
                !walker
                    .shooting
                    .is_resolved(&station.at, (index, contact), roundoffs)
            }
            _ => false,
        };
        let as_rounding = End::Rounding(there.impacts.unwrap_or_default());
        if is_less(self, LEAST_HEIGHT) {
            // An impact that leaves no rate is followed by a stay where the acceleration leads nowhere, and not by a flight.
            return match broken {
                Broken::Inner(index, GuardKind::Gap(contact))
                    if self
                        .shooting
                        .is_plastic((self.shooting.before(index), contact)) =>
                {
                    Stop::Broken(as_rounding, Box::new(station))
                }
                _ => Stop::End(as_rounding),
            };
        }
        let is_small = is_less(self, SMALL_HEIGHT);
        if let Broken::Early(index, guard) = broken
            && self.shooting.asks(index, guard)
        {
            return self.comes_to_corner((curve, step), (&station, index, guard), here, &there);
        }
        // Of the equations as they are; a fold may lie between.
        let headings = (
            self.heading_known(&just_before),
            self.heading_known(&station),
        );
        let (known, before) = (self.special.len(), self.shooting.clone());
        let outcome = match broken {
            Broken::Inner(index, GuardKind::Gap(contact))
            | Broken::Early(index, GuardKind::Gap(contact))
                if self.touches_at_turn(&station, index, contact) =>
            {
                let longer = (self.shooting).with_impact_at_turn(&station.at, (index, contact));
                let touched = longer.map_err(|error| error.to_string());
                let touched = touched.and_then(Touched::solve);
                touched.and_then(|touched| self.impacts_come_in(&station, touched, &there))
            }
            // Of stays that vanish at once, as those of a symmetric orbit, one may be over by rounding before the other is.
            Broken::Inner(_, guard @ GuardKind::Switch(_))
                if let Some(first) = self.shooting.stay_over(&station.at, guard) =>
            {
                self.lose(&station, first, &there)
            }
            Broken::Inner(index, GuardKind::Reaction(contact))
            | Broken::Early(index, GuardKind::Reaction(contact))
                if let Ok(next) =
                    self.released_before_corner(&station, (index, contact), &there) =>
            {
                Ok(next)
            }
            Broken::Inner(index, guard) => self.gain(&station, (index, guard), &there),
            // What it is told by is the touch of the surface that it comes back to, and not how slowly.
            Broken::Event(index) if self.shooting.has_come_back(&station.at, index) => {
                Err(broken.told(&self.shooting))
            }
            // A flight that begins with a release shrinks to nothing with the jerk there, and rounding is what is left of its impact.
            Broken::Event(index) if !self.is_flight(&station, index) => {
                Err(broken.told(&self.shooting))
            }
            Broken::Event(index) => self.lose(&station, index, &there),
            // The rate that turns is that of the impact, and the flight after it begins where it does.
            Broken::Beyond(index, GuardKind::Switch(_)) if self.follows_graze(index) => {
                self.lose(&station, self.shooting.before(index), &there)
            }
            Broken::Early(index, GuardKind::Switch(_))
                if self.shooting.steps[index].impact().is_some() =>
            {
                self.lose(&station, index, &there)
            }
            // What is crossed instead, where a stay beyond another surface is over.
            Broken::Early(index, GuardKind::Switch(_))
                if let Some((first, _)) = self.shooting.stay_that_vanishes(&station.at)
                    && first == index =>
            {
                self.lose(&station, index, &there)
            }
            // Friction that is too weak to stop what slides slows it as much; other impacts of the same chatter do the like beside it.
            Broken::Early(index, guard) if self.shooting.stops_about(index, guard) => {
                Err(broken.told(&self.shooting))
            }
            Broken::Early(index, GuardKind::Reaction(contact)) => {
                self.opens_at_event(&station, (index, contact), &there)
            }
            Broken::Early(index, guard) => {
                self.meets_with_event(&station, (index, guard), &there);
                Err(broken.told(&self.shooting))
            }
            Broken::Beyond(index, guard)
                if let Some(touched) = self.sticks_just_hold(&station, (index, guard)) =>
            {
                self.slips_come_in(touched, &there)
            }
            Broken::Beyond(index, GuardKind::Reaction(contact))
                if let Ok(next) = self.flies_from_rest(&station, (index, contact), &there) =>
            {
                Ok(next)
            }
            Broken::Beyond(index, guard) => {
                let slides = matches!(guard, GuardKind::Leave(..));
                let met = match slides {
                    true => (index, guard),
                    false => (self.shooting.before(index), guard),
                };
                // Where the field goes on as it is nothing happens to the orbit.
                let goes_on = !slides && self.shooting.is_smooth(index);
                if !self.meets_with_event(&station, met, &there) && !goes_on {
                    self.begins_at_its_end((&from, &station), &broken, &there);
                }
                Err(broken.told(&self.shooting))
            }
            Broken::Carried(_) => {
                self.begins_at_its_end((&from, &station), &broken, &there);
                Err(broken.told(&self.shooting))
            }
            Broken::Passed(index) => self.lose(&station, index, &there),
            Broken::Order(_) => Err(broken.told(&self.shooting)),
        };
        if outcome.is_err() && is_small {
            return Stop::End(as_rounding);
        }
        // A touch that nothing came of, and that is elsewhere than where the sequence breaks, is none of this way.
        let scale = self.shooting.scales().last().copied().unwrap_or(1.0);
        let way = (station.parameter() - from.parameter()).abs();
        let is_elsewhere = |special: &Special| {
            let off = (special.point.parameter() - station.parameter()).abs();
            special.kind == SpecialKind::Touch && off > BESIDE * way + NOT_QUITE * scale
        };
        if outcome.is_err()
            && self.special.len() > known
            && self.special.last().is_some_and(is_elsewhere)
        {
            self.special.pop();
        }
        if let (Broken::Inner(_, GuardKind::Reaction(_)), Err(why)) = (&broken, &outcome) {
            return Stop::Over(End::Lost(why.clone()));
        }
        // Where crossings come or go the equations themselves turn.
        let forward = match self.latest_change().map(|special| special.kind) {
            Some(SpecialKind::Touch) => headings.0,
            _ => headings.1,
        };
        // An orbit that goes more than once around a simple one from here on: it has met that at its graze.
        if let Ok(next) = &outcome
            && goes_around(&self.shooting, &next.at)
        {
            self.tell_as_loss((before, known), &station, &there);
            let kind = self.special.last().map(|special| special.kind);
            return Stop::End(kind.map_or(End::Range, End::Again));
        }
        match self.goes_on(outcome, (curve, forward), here) {
            Stop::End(end @ End::Lost(_)) => Stop::Broken(end, Box::new(station)),
            other => other,
        }
    }

    /// Tells the place where one part of an orbit touches and the impact of another part loses its rate as the latter, whichever was found first:
    /// the latest special point is of the equations without the touch, after so many others.
    fn tell_as_loss(
        &mut self,
        (mut before, known): (Shooting<f64>, usize),
        station: &Station,
        there: &Point,
    ) {
        let comes_in = self.shooting.struck() > before.struck();
        let is_known = comes_in && before.evaluate(&station.at).is_ok();
        let Some(index) = before.without_rate().filter(|_| is_known) else {
            return;
        };
        let told = self.special.split_off(known);
        let longer = core::mem::replace(&mut self.shooting, before);
        if self.lose(station, index, there).is_err() {
            self.special.truncate(known);
            self.special.extend(told);
            self.shooting = longer;
        }
    }

    /// On with two events in another order. At the knot of a table that is nothing that happens to the orbit; elsewhere the place is told.
    fn exchange(
        &mut self,
        (curve, step, reached): (&mut Curve, f64, f64),
        (station, index): (Station, usize),
        here: &mut Point,
    ) -> Stop {
        self.settle(&station);
        let there = Point::new(&mut self.shooting, &station);
        if let Some(end) = self.between(&curve.station, &station, reached, (here, &there)) {
            return Stop::End(end);
        }
        self.settle(&station);
        // There, and not where the step begins: a fold may lie between.
        let forward = self.heading_known(&station);
        let exchanged = self.shooting.exchanged(&station.at, index);
        let may_change = exchanged.is_ok();
        let shows = match &exchanged {
            Ok(exchanged) => Shooting::order_shows(exchanged).unwrap_or(true),
            // One that only a state before the other asks for, as the corner of a force that a clock switches on and off.
            Err(_) => !self.shooting.is_smooth(self.shooting.before(index)),
        };
        let next = exchanged.map_err(|error| error.to_string());
        let mut next = next.and_then(|exchanged| begins_exchanged(exchanged, &station));
        // Where the other order leads to another state derivatives say nothing.
        let is_told = !self.shooting.is_knot(index) && (shows || may_change && next.is_err());
        if is_told {
            self.note_exchange(&station, index, &there);
        }
        // Both halves of an orbit that is its own mirror image come to such a place at once.
        for _ in 0..self.shooting.steps.len() {
            let Ok((shooting, station)) = &next else {
                break;
            };
            let Some(index) = shooting.passes_there(station) else {
                break;
            };
            next = (shooting.exchanged(&station.at, index))
                .map_err(|error| error.to_string())
                .and_then(|exchanged| begins_exchanged(exchanged, station));
        }
        match next {
            Ok((shooting, next)) => {
                self.shooting = shooting;
                self.settle(&next);
                self.shooting.adopt(&next.at);
                let is_flat = self.is_flat(&next);
                if is_told && let Some(special) = self.special.last_mut() {
                    // Where a stay is over the parameter stands still, and rounding says where it goes.
                    let forward = forward.filter(|_| !is_flat);
                    special.persists =
                        forward.map(|forward| next.parameter_slope() * forward > 0.0);
                }
                self.begins_anew((next, step), curve, here);
                Stop::On
            }
            Err(why) => Stop::Broken(End::Lost(why), Box::new(station)),
        }
    }

    /// Notes where two events share their instant.
    fn note_exchange(&mut self, station: &Station, index: usize, there: &Point) {
        let place = self.shooting.duration_place(index);
        let (left, by) = place.map_or((0.0, 1.0), |k| (station.at[k], station.tangent[k]));
        let off = (left / by * station.parameter_slope()).abs();
        let error = off + SOLVED * station.parameter().abs();
        self.note(SpecialKind::Touch, there, &station.at, error, left.abs());
        self.tell_no_multipliers();
    }

    /// Notes where a surface is met with the event at the end of a step, as by what has a corner there, or where a step that slides along it
    /// could as well go across. Whether such a place is found.
    fn meets_with_event(
        &mut self,
        station: &Station,
        (index, guard): (usize, GuardKind),
        there: &Point,
    ) -> bool {
        // At the knot of a table nothing happens.
        if !matches!(guard, GuardKind::Switch(_) | GuardKind::Leave(..)) {
            return false;
        }
        self.settle(station);
        if let GuardKind::Leave(surface, _) = guard {
            let begins = (index, GuardKind::Switch(surface));
            let touched = self.shooting.turned_at_start(&station.at, begins).ok();
            let is_found = touched.is_some();
            if let Some(touched) = touched {
                self.note_touch(there, touched);
            }
            return is_found;
        }
        let mut watching = self.shooting.clone();
        let Ok(met) = watching.at_corner(&station.at, (index, guard)) else {
            return false;
        };
        if !self.shooting.has_kink_at_end(&met.at, (index, guard)) {
            self.note_met(there, &met);
        }
        true
    }

    /// Notes where a step begins exactly where its own guard would end it, or where a jump leads just onto a surface.
    fn begins_at_its_end(
        &mut self,
        (from, to): (&Station, &Station),
        broken: &Broken,
        there: &Point,
    ) {
        let mut value = |station: &Station| {
            self.shooting.evaluate(&station.at).ok()?;
            let least = self.shooting.least(&station.at).ok()?;
            broken.value(&self.shooting, &least)
        };
        let (before, residual) = (value(from), value(to).map_or(0.0, f64::abs));
        let parameter = to.parameter();
        let slope = before.map(|before| (before - residual) / (from.parameter() - parameter));
        let off = slope.map_or(0.0, |slope| (residual / slope).abs());
        let error = off + SOLVED * parameter.abs();
        self.settle(to);
        self.note(SpecialKind::Touch, there, &to.at, error, residual);
    }

    /// Whether the flight before an impact, if it begins with a release of the same contact, can be told from rounding of the gap.
    fn is_flight(&self, station: &Station, index: usize) -> bool {
        let before = self.shooting.before(index);
        let Some(contact) = self.shooting.steps[index].impact() else {
            return true;
        };
        if !self.shooting.holds(before, contact) {
            return true;
        }
        let [release, flight] = [before, index].map(|k| &self.shooting.latest[k]);
        let (_, terms) = self.shooting.gap_rate(&station.at, (index, contact));
        let height = match self.shooting.steps[before].ends_at() {
            // From rest with this jerk, and back to the contact: a quartic.
            Some(GuardKind::Reaction(of)) if of == contact => {
                27.0 / 1536.0 * (release.surface_rate * flight.duration.powi(3)).abs()
            }
            // Thrown off by a corner, from rest and back with this rate: a cubic, or a quartic if there is none.
            _ => {
                let rate = 4.0 / 27.0 * (flight.surface_rate * flight.duration).abs();
                rate + (flight.surface_acceleration * flight.duration.powi(2)).abs() / 32.0
            }
        };
        is_told(height, terms, LEAST_HEIGHT)
    }

    /// Whether the parameter stands still to first order: it does over the rate of an impact that the orbit forgets.
    pub(in crate::analysis::periodic::branch) fn is_flat(&self, station: &Station) -> bool {
        let scale = self.shooting.scales().last().copied().unwrap_or(1.0);
        station.parameter_slope().abs() <= FLAT * scale
    }

    /// On from where the sequence of events changes, the parameter having gone so before.
    pub(in crate::analysis::periodic::branch) fn goes_on(
        &mut self,
        outcome: Result<Station, String>,
        (curve, forward): (&mut Curve, Option<f64>),
        here: &mut Point,
    ) -> Stop {
        match outcome {
            Ok(next) => {
                // The shortest way that tells: a longer one may pass a fold.
                let steps = [curve.step, self.limits.longest_step].map(|step| CAREFUL * step);
                let onward = match self.is_flat(&next) {
                    true => steps.into_iter().find_map(|step| {
                        (next.ahead(&mut self.shooting, step))
                            .map_or(forward, |(ahead, _)| gone((&next, &ahead)))
                    }),
                    false => Some(next.parameter_slope()),
                };
                let both = forward.zip(onward);
                let persists = both.map(|(forward, onward)| onward * forward > 0.0);
                self.tell_persists(match self.told_with_one_before() {
                    // The way to both turns as often as at each.
                    Some(before) => persists.map(|persists| persists == before),
                    None => persists,
                });
                self.settle(&next);
                self.begins_anew((next, CAREFUL * curve.step), curve, here);
                Stop::On
            }
            Err(why) => Stop::End(End::Lost(why)),
        }
    }

    /// A flight touches: an impact comes in. The new equations, at their first station.
    fn gain(
        &mut self,
        station: &Station,
        (index, guard): (usize, GuardKind),
        there: &Point,
    ) -> Result<Station, String> {
        let least = (self.shooting.least(&station.at)).map_err(|left| left.to_string())?;
        let touching = smallest(&least, (index, guard), false)
            .ok_or("the touch is lost")?
            .clone();
        if self.shooting.begins_at(index, guard) {
            // Elsewhere it is the way from the surface that touches it once more.
            let turned = (self.shooting).turned_at_start(&station.at, (index, guard));
            if let Ok(touched) = turned {
                self.note_touch(there, touched);
                return Err(
                    "beyond a surface that was crossed the flow turns back to it".to_owned(),
                );
            }
        }
        if guard.opposite().is_some() {
            return self.crosses(station, (index, &touching), there);
        }
        if let GuardKind::Reaction(_) = guard {
            return self.opens(station, (index, &touching), there);
        }
        let touched = self.shooting.touched(&station.at, (index, &touching));
        if !matches!(guard, GuardKind::Gap(_)) {
            match touched {
                Ok(touched) => self.note_touch(there, touched),
                Err(_) => self.note(
                    SpecialKind::Touch,
                    there,
                    &station.at,
                    SOLVED * station.parameter().abs(),
                    touching.value.abs(),
                ),
            }
            let named = self.shooting.workshop.named(guard);
            return Err(format!(
                "the orbit comes to {named}, and no motion leads beyond"
            ));
        }
        self.impacts_come_in(station, touched?, there)
    }

    /// On with an impact that comes in where it has no rate yet, and those at other contacts that touch there as well.
    fn impacts_come_in(
        &mut self,
        station: &Station,
        touched: Touched,
        there: &Point,
    ) -> Result<Station, String> {
        if let Some(next) = self.gain_together(station, &touched, there) {
            return Ok(next);
        }
        let others = self.others_that_touch(&touched);
        let (told, before) = (self.special.len(), self.shooting.clone());
        let alone = self.impact_comes_in(station, touched, there);
        if others == 0
            || alone
                .as_ref()
                .is_ok_and(|next| begins(&self.shooting, next))
        {
            return alone;
        }
        let with_alone = core::mem::replace(&mut self.shooting, before);
        match self.gain_beyond(station, (told, others), there) {
            Some(next) => Ok(next),
            None => {
                self.shooting = with_alone;
                alone
            }
        }
    }

    /// On with an impact that comes in where it has no rate yet.
    pub(super) fn impact_comes_in(
        &mut self,
        station: &Station,
        touched: Touched,
        there: &Point,
    ) -> Result<Station, String> {
        let Touched {
            shooting: mut longer,
            at,
            told: known,
            index,
            residual,
            correction,
            error,
            ..
        } = touched;
        let direction = |shooting: &mut Shooting<f64>, at: &[f64]| rate_grows(shooting, at, index);
        let mut along = direction(&mut longer, &at)?;
        self.settle(station);
        let has_pole = self.shooting.grazes();
        let takes_off = longer.impact_takes_off(index);
        let mut at = at;
        let before = core::mem::replace(&mut self.shooting, longer);
        let opens = station.tangent.last().is_some_and(|&along| along < 0.0);
        self.note(graze(opens), there, &known, error, residual);
        if has_pole {
            self.tell_no_multipliers();
            self.tells_with_one_before();
        }
        if takes_off {
            let slipping = self.shooting.with_slip(&at, index).ok();
            let slipping = slipping.and_then(|(mut slipping, start, place)| {
                let along = direction(&mut slipping, &start).ok()?;
                let parts = slipping.parts_by_slip((&start, &along), index);
                (along[place] > 0.0 && parts).then_some((slipping, start, along))
            });
            let Some(next) = slipping else {
                self.shooting = before;
                return Err(
                    "the impact takes the state off a surface that it slides along".to_owned(),
                );
            };
            (self.shooting, at, along) = next;
        }
        Ok(Station {
            at,
            tangent: along,
            residual,
            correction,
            orientation: 0.0,
        })
    }

    /// Tells the latest graze, beside an impact that has no rate yet, with the one at which that came in, if both are one place: the way between them
    /// is of no length, and says neither which way the gap goes nor whether the branch goes on.
    fn tells_with_one_before(&mut self) {
        let [.., first, latest] = &mut self.special[..] else {
            return;
        };
        let off = (first.point.parameter() - latest.point.parameter()).abs();
        if first.kind.is_graze() && off <= first.error + latest.error {
            latest.kind = first.kind;
            latest.persists = first.persists;
            let value = first.point.parameters.last().copied();
            if let (Some(told), Some(value)) = (latest.point.parameters.last_mut(), value) {
                *told = value;
            }
        }
    }

    /// Whether the branch went on at the graze before the latest, where that is told with it.
    fn told_with_one_before(&self) -> Option<bool> {
        let [.., first, latest] = &self.special[..] else {
            return None;
        };
        let is_one = latest.kind.is_graze()
            && first.told_as() == latest.told_as()
            && first.persists == latest.persists;
        first.persists.filter(|_| is_one)
    }

    /// An impact has lost its rate, or a surface is no longer crossed: it goes out.
    pub(in crate::analysis::periodic::branch) fn lose(
        &mut self,
        station: &Station,
        index: usize,
        there: &Point,
    ) -> Result<Station, String> {
        if self.shooting.steps[index].impact().is_some()
            && let Some(next) = (self.lose_together(station, there))
                .or_else(|| self.give_way(station, index, there))
        {
            return Ok(next);
        }
        let known = match self.shooting.crossing_that_vanishes(index) {
            Some(first) => Some((self.shooting.clone(), station.at.clone(), first)),
            None => self.shooting.with_corner_after_stay(&station.at, index),
        };
        let Some((stays, at, first)) = known else {
            return self.without(&station.at, (index, None), there);
        };
        let told = |error: PeriodicError| error.to_string();
        let (stays, at, first) = stays.with_one_stay((at, first)).map_err(told)?;
        let (touching, start, index) = stays.without_way_back(&at, first).map_err(told)?;
        let before = core::mem::replace(&mut self.shooting, touching);
        let next = self.without(&start, (index, Some(first)), there);
        if next.is_err() {
            self.shooting = before;
        }
        next
    }

    /// On without an event, which ends a step, or without a crossing and its way back.
    pub(super) fn without(
        &mut self,
        start: &[f64],
        (index, crossing): (usize, Option<usize>),
        there: &Point,
    ) -> Result<Station, String> {
        let told = |error: &dyn core::fmt::Display| error.to_string();
        let found = self.shooting.solved(&Bordered::Monitor(index), start);
        let found = found.map_err(|error| told(&error))?;
        if moved(&found.at, start, self.shooting.scales()) > THERE {
            return Err("where an event vanishes only another place is found".to_owned());
        }
        let is_impact = self.shooting.steps[index].impact().is_some();
        let kind = if is_impact {
            graze(true)
        } else {
            SpecialKind::Touch
        };
        if !is_impact && self.has_told((&self.shooting, &found.told, index), found.error) {
            self.special.pop();
        }
        self.note(kind, there, &found.told, found.error, found.residual);
        if is_impact && let Some(special) = self.special.last_mut() {
            special.point.impacts = special.point.impacts.map(|n| n - 1);
        }
        // They are told of the orbit without the event.
        if is_impact || self.shooting.crosses_slowly() {
            self.tell_no_multipliers();
        }
        if !is_impact && crossing.is_none() {
            return Err("an event that is no impact is only touched".to_owned());
        }
        let mut merged = self.shooting.without_event(&found.at, index);
        if merged.is_err()
            && self.shooting.steps.len() == 1
            && let Ok(Some((longer, at))) = self.shooting.with_section(&found.at)
        {
            // Without its last event the orbit of an autonomous system is told from the section.
            let index = longer.steps.iter().position(|step| step.impact().is_some());
            merged = longer.without_event(&at, index.unwrap_or(0));
        }
        let (mut shorter, guess, merged) = merged.map_err(|error| told(&error))?;
        let next = Station::beside(&mut shorter, &guess).map_err(|error| told(&error))?;
        shorter.evaluate(&next.at).map_err(|left| told(&left))?;
        if let Some(special) = self.special.last_mut() {
            (special.point.multipliers, special.point.modulus_error) = match shorter.grazes() {
                true => (Vec::new(), f64::NAN),
                false => shorter.multipliers_known(),
            };
        }
        // To the side where the gap stays open.
        let guard = self.shooting.steps[index].ends_at();
        let beside = [index, self.shooting.after(index)].map(|k| self.shooting.steps[k].mode());
        let turns = !self.shooting.moves_alike(beside[0], beside[1]) && shorter.turns(merged);
        // Of several least values that the gap has on the way the one that was touched; where that was the only event the way begins and ends
        // with it.
        let touched_at = self.shooting.latest[index].duration;
        let is_only = self.shooting.steps.len() == 1;
        let gap = |shooting: &mut Shooting<f64>, station: &Station| {
            let least = shooting.least(&station.at).ok()?;
            // Where the way ends with a corner at that very instant, rounding says whether the least value is on the way or at its end.
            let is_kind = |l: &&Least| match is_only {
                true => l.at_end == turns,
                false => l.at_end || !turns,
            };
            let own_guard = |l: &&Least| Some(l.guard) == guard;
            let all = (least.get(merged)?.iter())
                .filter(own_guard)
                .filter(is_kind);
            let off = |l: &Least| match is_only {
                true => l.value,
                false => (l.time - touched_at).abs(),
            };
            let own = all.min_by(|a, b| off(a).total_cmp(&off(b)));
            own.map(|l| l.value)
        };
        let probe = 1e-6;
        let mut opens = |station: &Station| {
            let (ahead, _) = station.ahead(&mut shorter, probe).ok()?;
            gap(&mut shorter, &ahead)
        };
        let reversed = next.clone().reversed();
        let (up, down) = (opens(&next), opens(&reversed));
        let forward = match (up, down) {
            (Some(up), Some(down)) => up >= down,
            (Some(_), None) => true,
            _ => false,
        };
        if is_impact && let Some(special) = self.special.last_mut() {
            special.kind = graze(forward);
        }
        let next = if forward { next } else { reversed };
        if is_impact && stays_without_rate(&mut shorter, &next) {
            return Err("beyond, an impact has no rate, as of what is at rest".to_owned());
        }
        self.shooting = shorter;
        Ok(next)
    }
}

/// Equations in which two events have changed places, and their first station, from one of those before.
fn begins_exchanged(
    mut exchanged: Exchanged,
    from: &Station,
) -> Result<(Shooting<f64>, Station), String> {
    let direction = exchanged.direction(&from.tangent);
    let guess = (&*exchanged.guess, &*direction);
    let grows = exchanged.grows();
    let next = station_after(&mut exchanged.shooting, guess, grows);
    let next = next.map_err(|error| error.to_string())?;
    Ok((exchanged.shooting, next))
}

/// The direction of a curve in which the rate of the impact at the end of a step grows.
pub(super) fn rate_grows(
    shooting: &mut Shooting<f64>,
    at: &[f64],
    index: usize,
) -> Result<Vec<f64>, String> {
    let gradient = shooting.monitor(index, at);
    let (_, gradient) = gradient.map_err(|left| left.to_string())?;
    let tangent = tangent(shooting, at, &gradient);
    let mut tangent = tangent.map_err(|error| error.to_string())?;
    // Against the gap.
    if crate::numerics::dot(&gradient, &tangent) > 0.0 {
        tangent.iter_mut().for_each(|x| *x = -*x);
    }
    Ok(tangent)
}

/// So far on an impact that is one has a rate, of more than this part of others.
const ONWARD: f64 = 1e-3;
const STANDS: f64 = 1e-10;

/// Whether an impact that has lost its rate gains none on the way from a station: that of a mass which, once it strikes no more, stands still where
/// it is touched.
fn stays_without_rate(shooting: &mut Shooting<f64>, station: &Station) -> bool {
    if shooting.evaluate(&station.at).is_err() {
        return false;
    }
    let Some(index) = shooting.without_rate() else {
        return false;
    };
    let onward = station.ahead(shooting, ONWARD);
    onward.is_ok_and(|(onward, _)| shooting.evaluate(&onward.at).is_ok())
        && shooting.slower_than(STANDS).contains(&index)
}

/// How far the parameter has gone between two stations, if that is more than rounding of it: all orbits of a family may have one value.
fn gone((from, to): (&Station, &Station)) -> Option<f64> {
    let by = to.parameter() - from.parameter();
    (by.abs() > roundoff(to.parameter())).then_some(by)
}

/// Whether the height of a flight is more than so many roundoffs of the terms that the gap is the sum of.
pub(in crate::analysis::periodic::branch) fn is_told(
    height: f64,
    terms: f64,
    roundoffs: f64,
) -> bool {
    height.is_nan() || height > roundoffs * f64::EPSILON * terms
}

/// Whether an orbit goes more than once around another one. Where several impacts lose their rate at once they are left out one by one: what is
/// left of them tells no parts from each other.
fn goes_around(shooting: &Shooting<f64>, at: &[f64]) -> bool {
    let (mut shooting, mut at) = (shooting.clone(), at.to_vec());
    for _ in 0..=shooting.steps.len() {
        if shorter(&shooting, &at).is_ok_and(|part| part.is_some()) {
            return true;
        }
        let left = shooting
            .evaluate(&at)
            .is_ok()
            .then(|| shooting.without_rate());
        let without = left
            .flatten()
            .map(|index| shooting.without_event(&at, index));
        let Some(Ok((fewer, guess, _))) = without else {
            return false;
        };
        (shooting, at) = (fewer, guess);
    }
    false
}

/// How far a solution is from where it was looked for, against the sizes of the unknowns.
pub(in crate::analysis::periodic) fn moved(found: &[f64], from: &[f64], sizes: &[f64]) -> f64 {
    let parts = found.iter().zip(from).zip(sizes);
    parts.fold(0.0_f64, |most, ((x, from), size)| {
        most.max((x - from).abs() / size)
    })
}

/// The kind of a graze where the gap of the flight opens, or closes, as the parameter grows: whichever way it is met.
pub(super) const fn graze(opens: bool) -> SpecialKind {
    if opens {
        SpecialKind::ImpactGraze
    } else {
        SpecialKind::FlightGraze
    }
}
