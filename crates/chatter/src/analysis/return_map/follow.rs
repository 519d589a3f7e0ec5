//! Orbits of a return map side by side in one fleet.

use super::ReturnMap;
use super::look::Look;
use crate::analysis::map::{Arrival, Command, NoReturn, Origin, Passage, Start};
use crate::analysis::simulate::EventKind;
use crate::expressions::Formula;
use crate::flow::{
    FlowError, GuardKind, Next, Occurrence, Trajectory, Workspace, impacts_may_forget, may_forget,
    run_fleet,
};
use crate::numerics::{DoubleDouble, WithTerms, two_sum};
use core::sync::atomic::AtomicBool;
use std::sync::Mutex;

/// Into so many parts is the time that a return may take divided, so that an orbit that never returns can be called off
/// between them.
const PATIENCE_PARTS: u64 = 64;

/// A state counts as lying on a section if the surface function is this small against the state: it was stored.
const ON_SECTION: f64 = 1e-12;

/// A start is at a look if it is this near to one, in periods.
const SAME_LOOK: f64 = 1e-12;

/// The size that a surface function is compared with.
fn largest(point: &[f64]) -> f64 {
    point.iter().fold(1.0_f64, |most, x| most.max(x.abs()))
}

pub(super) struct Follower<'m, 'v> {
    map: &'m ReturnMap,
    swept: &'m [usize],
    visit: &'v mut dyn FnMut(Arrival<'_>) -> Command,
    work: Workspace<f64>,
    scratch: Vec<f64>,
    /// Whether displacements are carried along.
    is_tangent: bool,
    /// Whether impacts of which nobody else needs to hear may forget them.
    impacts_forget: bool,
}

/// What is known of one orbit beside its trajectory.
struct Orbit {
    orbit: usize,
    parameters: Vec<f64>,
    passage: Passage,
    /// Time of the latest return.
    since: f64,
    /// Where the present flight began; NaN in a contact phase or where a start cut it.
    takeoff: f64,
    clock: Clock,
}

/// What the orbit's horizon means.
enum Clock {
    /// So many parts of the time that a return may take are over.
    Patience(u64),
    /// So many periods since the origin are over at the next look.
    Strobe {
        origin: f64,
        period: DoubleDouble,
        count: u64,
    },
}

/// So many steps at most show what sizes coordinates have on the way.
const MOST_SHOWN: usize = 1000;

/// The states after the steps of so long a way from a point of the image, and what the terms of its rates make on it.
pub(super) fn on_the_way(
    map: &ReturnMap,
    parameters: &[f64],
    point: &[f64],
    duration: f64,
) -> Vec<f64> {
    let every: Vec<usize> = (0..parameters.len()).collect();
    let mut nobody = |_: Arrival<'_>| Command::Retire;
    let work = map.spare.take().unwrap_or_else(|| map.workspace());
    let mut follower = Follower::with(map, &every, &mut nobody, work);
    let states = follower.shown(parameters, point, duration);
    map.spare.put(follower.work);
    states
}

/// A workspace for one short way after the other: what it has compiled is of use for the next one.
#[derive(Debug, Default)]
pub(super) struct Spare(Mutex<Option<Workspace<f64>>>);

impl Spare {
    fn take(&self) -> Option<Workspace<f64>> {
        self.0.lock().map_or(None, |mut work| work.take())
    }

    fn put(&self, work: Workspace<f64>) {
        if let Ok(mut place) = self.0.lock() {
            *place = Some(work);
        }
    }
}

impl Clone for Spare {
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl<'m, 'v> Follower<'m, 'v> {
    pub(super) fn new(
        map: &'m ReturnMap,
        swept: &'m [usize],
        visit: &'v mut dyn FnMut(Arrival<'_>) -> Command,
    ) -> Self {
        Self::with(map, swept, visit, map.workspace())
    }

    fn with(
        map: &'m ReturnMap,
        swept: &'m [usize],
        visit: &'v mut dyn FnMut(Arrival<'_>) -> Command,
        work: Workspace<f64>,
    ) -> Self {
        let is_tangent = map.system.dimension() > map.system.coordinates();
        Self {
            work,
            scratch: Vec::new(),
            is_tangent,
            impacts_forget: is_tangent && map.model.contacts.iter().any(impacts_may_forget),
            map,
            swept,
            visit,
        }
    }

    /// See [`on_the_way`].
    fn shown(&mut self, parameters: &[f64], point: &[f64], duration: f64) -> Vec<f64> {
        let start = Start {
            swept: parameters.to_vec(),
            origin: Origin::Image(point.to_vec()),
        };
        let mut states = Vec::new();
        let Some((_, mut trajectory)) = self.begin(0, &start) else {
            return states;
        };
        let system = &self.map.system;
        trajectory.set_horizon_parts(two_sum(trajectory.time(), duration));
        for _ in 0..MOST_SHOWN {
            let told = trajectory.advance_to_horizon(system, &mut self.work);
            if told.is_err() {
                break;
            }
            states.extend(trajectory.state());
            if let Ok(Some(Occurrence::Horizon)) = told {
                break;
            }
        }
        let rates = trajectory.rates(system).into_iter().flatten();
        states.extend(rates.map(|rate| rate.terms * duration));
        states
    }

    pub(super) fn run(mut self, starts: &[Start], stop: &AtomicBool) {
        let mut orbits = Vec::with_capacity(starts.len());
        let mut trajectories = Vec::with_capacity(starts.len());
        for (index, start) in starts.iter().enumerate() {
            if let Some((orbit, trajectory)) = self.begin(index, start) {
                orbits.push(orbit);
                trajectories.push(trajectory);
            }
        }
        let map = self.map;
        run_fleet(
            &map.system,
            &map.settings,
            self.swept,
            &mut trajectories,
            stop,
            |place, trajectory, told| self.hear(&mut orbits[place], trajectory, told),
        );
    }

    /// The first trajectory of an orbit; none if it is given up before it has started.
    fn begin(&mut self, index: usize, start: &Start) -> Option<(Orbit, Trajectory<f64>)> {
        let mut orbit = Orbit {
            orbit: index,
            parameters: self.parameters(&start.swept),
            passage: Passage::default(),
            since: 0.0,
            takeoff: f64::NAN,
            clock: Clock::Patience(0),
        };
        let mut start = start.clone();
        // A trajectory needs a first state that is admissible; where none is, its orbit never enters the fleet.
        loop {
            let (time, point) = self.origin(&orbit, &start.origin);
            let told = Trajectory::start(
                &self.map.system,
                &mut self.work,
                &orbit.parameters,
                time,
                &point,
            )
            .map_err(NoReturn::Failed)
            .and_then(|mut trajectory| {
                self.place(&mut orbit, &mut trajectory, &start.origin)
                    .map(|()| trajectory)
            });
            match told {
                Ok(trajectory) => return Some((orbit, trajectory)),
                Err(reason) => match self.arrive(&orbit, &point, Err(reason)) {
                    Command::Restart(next) => {
                        orbit.parameters = self.parameters(&next.swept);
                        start = next;
                    }
                    Command::Continue | Command::Retire => return None,
                },
            }
        }
    }

    fn parameters(&self, swept: &[f64]) -> Vec<f64> {
        let values: Vec<(usize, f64)> = self
            .swept
            .iter()
            .copied()
            .zip(swept.iter().copied())
            .collect();
        self.map.model.parameter_values(&values)
    }

    /// Time and state of an origin.
    fn origin(&self, orbit: &Orbit, origin: &Origin) -> (f64, Vec<f64>) {
        let model = &self.map.model;
        let point = match origin {
            Origin::Initial => model.initial_state(&orbit.parameters),
            Origin::Point(point) | Origin::Image(point) => point.clone(),
        };
        (model.time.map_or(0.0, |index| point[index]), point)
    }

    /// Puts a trajectory at an origin, at the orbit's parameters, and sets the orbit's counters back.
    fn place(
        &mut self,
        orbit: &mut Orbit,
        trajectory: &mut Trajectory<f64>,
        origin: &Origin,
    ) -> Result<(), NoReturn> {
        let system = &self.map.system;
        let (time, point) = self.origin(orbit, origin);
        trajectory
            .restart(system, &mut self.work, time, &point)
            .map_err(NoReturn::Failed)?;
        let states = &point[..system.coordinates()];
        if let (Origin::Image(_), Some(surface)) = (origin, self.map.look.section()) {
            let value = surface.evaluate(states, &orbit.parameters, &mut self.scratch);
            if value.abs() <= ON_SECTION * largest(states) {
                trajectory.leave(system, GuardKind::Section(0));
            }
        }
        if self.is_tangent {
            let mut displacement = point[states.len()..].to_vec();
            // Motions are compared at one time.
            if let Some(time) = self.map.model.time {
                displacement[time] = 0.0;
            }
            self.replace(trajectory, &displacement)
                .map_err(NoReturn::Failed)?;
        }
        orbit.passage = self.setting_out(trajectory);
        orbit.since = time;
        orbit.takeoff = f64::NAN;
        orbit.clock = match &self.map.look {
            Look::Event { .. } => Clock::Patience(0),
            Look::Stroboscopic { period } => {
                let period = self.possible(strobe_period(period, &orbit.parameters))?;
                Clock::Strobe {
                    origin: match origin {
                        Origin::Point(_) => self.look_before(time, orbit, period.high()),
                        _ => time,
                    },
                    period,
                    count: 0,
                }
            }
        };
        self.set_horizon(orbit, trajectory);
        self.let_pass(orbit, trajectory);
        Ok(())
    }

    /// Impacts that nobody looks at are counted, not told, as long as they are not too many.
    fn let_pass(&self, orbit: &Orbit, trajectory: &mut Trajectory<f64>) {
        trajectory.let_pass(
            match self.map.look.looks_at(EventKind::Impact) || self.impacts_forget {
                true => 0,
                false => self.map.most_impacts.saturating_sub(orbit.passage.impacts),
            },
        );
    }

    /// The latest look up to a time at which an orbit starts: looks are whole periods from where the model starts, so that orbits from
    /// anywhere are seen in one phase.
    fn look_before(&self, time: f64, orbit: &Orbit, period: f64) -> f64 {
        let Some(clock) = self.map.model.time else {
            return time;
        };
        let start = self.map.model.initial_state(&orbit.parameters)[clock];
        let turns = (time - start) / period;
        if (turns - turns.round()).abs() <= SAME_LOOK * turns.abs().max(1.0) {
            time
        } else {
            start + turns.floor() * period
        }
    }

    /// A period that a return can take.
    fn possible(&self, period: DoubleDouble) -> Result<DoubleDouble, NoReturn> {
        let limit = self.map.longest_return;
        let value = period.high();
        if !(value > 0.0 && value.is_finite()) {
            Err(NoReturn::Period { value })
        } else if value > limit {
            Err(NoReturn::Time { limit })
        } else {
            Ok(period)
        }
    }

    fn set_horizon(&self, orbit: &mut Orbit, trajectory: &mut Trajectory<f64>) {
        let horizon = match &mut orbit.clock {
            Clock::Patience(part) => {
                let share = (*part + 1) as f64 / PATIENCE_PARTS as f64;
                (orbit.since + self.map.longest_return * share, 0.0)
            }
            Clock::Strobe {
                origin,
                period,
                count,
            } => {
                *count += 1;
                let time =
                    DoubleDouble::from(*origin) + *period * DoubleDouble::from(*count as f64);
                (time.high(), time.low())
            }
        };
        trajectory.set_horizon_parts(horizon);
    }

    /// Takes in what happened to a trajectory, and the impacts before that of which nothing was told.
    #[inline]
    fn hear(
        &mut self,
        orbit: &mut Orbit,
        trajectory: &mut Trajectory<f64>,
        told: Result<&Occurrence<f64>, FlowError>,
    ) -> Next {
        if let Some((count, latest, before)) = trajectory.untold() {
            orbit.passage.impacts += count;
            orbit.passage.flight_time = latest - before.unwrap_or(orbit.takeoff);
            orbit.takeoff = latest;
        }
        let next = self.take_in(orbit, trajectory, told);
        if next == Next::Continue {
            self.let_pass(orbit, trajectory);
        }
        next
    }

    #[inline]
    fn take_in(
        &mut self,
        orbit: &mut Orbit,
        trajectory: &mut Trajectory<f64>,
        told: Result<&Occurrence<f64>, FlowError>,
    ) -> Next {
        let occurrence = match told {
            Ok(occurrence) => occurrence,
            Err(error) => return self.report(orbit, trajectory, Err(NoReturn::Failed(error))),
        };
        if self.is_tangent {
            orbit.passage.forgets |= may_forget(&self.map.model, occurrence);
        }
        match *occurrence {
            Occurrence::Impact { contact, .. } => {
                orbit.passage.impacts += 1;
                orbit.passage.flight_time = trajectory.time() - orbit.takeoff;
                orbit.takeoff = trajectory.time();
                if self.map.look.sees(EventKind::Impact, contact) {
                    return self.returned(orbit, trajectory);
                }
                if orbit.passage.impacts > self.map.most_impacts {
                    let limit = self.map.most_impacts;
                    return self.report(orbit, trajectory, Err(NoReturn::Impacts { limit }));
                }
            }
            Occurrence::Section { section } => {
                if self.map.look.sees(EventKind::Section, section) {
                    return self.returned(orbit, trajectory);
                }
            }
            Occurrence::Accumulation { contact, .. } => {
                orbit.passage.accumulations += 1;
                orbit.takeoff = f64::NAN;
                if self.map.look.sees(EventKind::Accumulation, contact) {
                    return self.returned(orbit, trajectory);
                }
            }
            Occurrence::Cascade { contact, .. } => {
                // Infinitely many as well, after which what touches is at rest, if only for that instant.
                orbit.passage.accumulations += 1;
                if self.map.look.sees(EventKind::Cascade, contact) {
                    return self.returned(orbit, trajectory);
                }
            }
            Occurrence::Ambiguity { contact, .. } => {
                orbit.passage.ambiguities += 1;
                if self.map.look.sees(EventKind::Ambiguity, contact) {
                    return self.returned(orbit, trajectory);
                }
            }
            Occurrence::Capture { .. } => orbit.takeoff = f64::NAN,
            Occurrence::Release { contact } => {
                orbit.takeoff = trajectory.time();
                if self.map.look.sees(EventKind::Release, contact) {
                    return self.returned(orbit, trajectory);
                }
            }
            Occurrence::Graze { contact, .. } => {
                if self.map.look.sees(EventKind::Graze, contact) {
                    return self.returned(orbit, trajectory);
                }
            }
            Occurrence::Horizon => return self.on_time(orbit, trajectory),
            ref corner => {
                if let (Some(kind), Some(place)) = (corner.kind(), corner.place())
                    && self.map.look.sees(kind, place.index())
                {
                    return self.returned(orbit, trajectory);
                }
            }
        }
        Next::Continue
    }

    /// The orbit's horizon was reached.
    fn on_time(&mut self, orbit: &mut Orbit, trajectory: &mut Trajectory<f64>) -> Next {
        match &mut orbit.clock {
            Clock::Strobe { .. } => self.returned(orbit, trajectory),
            Clock::Patience(part) => {
                *part += 1;
                if *part >= PATIENCE_PARTS {
                    let limit = self.map.longest_return;
                    return self.report(orbit, trajectory, Err(NoReturn::Time { limit }));
                }
                self.set_horizon(orbit, trajectory);
                Next::Continue
            }
        }
    }

    #[inline]
    fn returned(&mut self, orbit: &mut Orbit, trajectory: &mut Trajectory<f64>) -> Next {
        let time = trajectory.time();
        let mut told = None;
        let mut passage = Passage {
            return_time: time - orbit.since,
            ..orbit.passage
        };
        if self.is_tangent {
            passage.ambiguities += u64::from(trajectory.no_derivative().is_some());
            match self.across_motion(trajectory, passage.return_time) {
                Ok(point) => told = point,
                Err(error) => return self.report(orbit, trajectory, Err(NoReturn::Failed(error))),
            }
        }
        if let Clock::Patience(part) = &mut orbit.clock {
            *part = 0;
        }
        orbit.since = time;
        orbit.passage = self.setting_out(trajectory);
        self.set_horizon(orbit, trajectory);
        let point = told.as_deref().unwrap_or(trajectory.state());
        // A command is only moved where there is something to obey: of the wide load of what was just written narrowly a return would wait.
        match self.arrive(orbit, point, Ok(passage)) {
            Command::Continue => Next::Continue,
            command => self.obey(orbit, trajectory, (command, false)),
        }
    }

    /// What is known of the way to the next return before it begins.
    fn setting_out(&self, trajectory: &Trajectory<f64>) -> Passage {
        Passage {
            flight_time: f64::NAN,
            forgets: self.is_tangent && trajectory.is_held(&self.map.system),
            ..Passage::default()
        }
    }

    /// Takes from the displacement what it has of the motion, and what the state is held against. In the middle of something the trajectory
    /// has to go on as it is: then what is to be told in place of its state.
    fn across_motion(
        &mut self,
        trajectory: &mut Trajectory<f64>,
        return_time: f64,
    ) -> Result<Option<Vec<f64>>, FlowError> {
        let system = &self.map.system;
        let left = self.without_motion(trajectory, return_time);
        let may_replace = (left.is_some() || trajectory.is_held(system))
            && trajectory.is_between_steps()
            && !trajectory.follows_sequence()
            && !trajectory.has_caused_more(system, &mut self.work);
        let (state, column) = trajectory.state().split_at(system.coordinates());
        if may_replace {
            // What holds the state holds its displacements: what rounding takes off that need not die out as they do.
            let left = left.unwrap_or_else(|| column.to_vec());
            self.replace(trajectory, &left)?;
            return Ok(None);
        }
        Ok(left.map(|left| [state, &left].concat()))
    }

    /// What is left of the displacement without what it has of the direction of motion, each coordinate measured by its own size: that neither
    /// grows nor shrinks, and would hide what does. None where motions are compared at one time, or where the state is at rest.
    fn without_motion(&self, trajectory: &Trajectory<f64>, return_time: f64) -> Option<Vec<f64>> {
        let is_simultaneous = matches!(self.map.look, Look::Stroboscopic { .. });
        if self.map.model.time.is_some() || is_simultaneous {
            return None;
        }
        let system = &self.map.system;
        let (state, column) = trajectory.state().split_at(system.coordinates());
        let rates = trajectory.rates(system)?;
        // What is held does not move, whatever rounding says: its size by that would be rounding, too.
        let told = |rate: &WithTerms<f64>| match rate.value.abs() > rate.level() {
            true => rate.value,
            false => 0.0,
        };
        let rates: Vec<f64> = rates[..state.len()].iter().map(told).collect();
        let (mut shared, mut square) = (0.0, 0.0);
        for ((x, rate), entry) in state.iter().zip(&rates).zip(column) {
            let size = x.abs() + rate.abs() * return_time;
            if size > 0.0 {
                let rate = rate / size;
                shared += entry / size * rate;
                square += rate * rate;
            }
        }
        let along = shared / square;
        // At rest there is no direction of motion.
        let left = column.iter().zip(&rates);
        along
            .is_finite()
            .then(|| left.map(|(entry, rate)| entry - along * rate).collect())
    }

    /// Gives a trajectory another displacement.
    fn replace(
        &mut self,
        trajectory: &mut Trajectory<f64>,
        displacement: &[f64],
    ) -> Result<(), FlowError> {
        trajectory.replace_columns(&self.map.system, displacement)
    }

    fn report(
        &mut self,
        orbit: &mut Orbit,
        trajectory: &mut Trajectory<f64>,
        passage: Result<Passage, NoReturn>,
    ) -> Next {
        let failed = passage.is_err();
        let command = self.arrive(orbit, trajectory.state(), passage);
        self.obey(orbit, trajectory, (command, failed))
    }

    /// Does what the visitor says of an orbit that has come to a point, or has failed to.
    fn obey(
        &mut self,
        orbit: &mut Orbit,
        trajectory: &mut Trajectory<f64>,
        (mut command, mut failed): (Command, bool),
    ) -> Next {
        loop {
            let start = match command {
                Command::Continue if !failed => return Next::Continue,
                Command::Continue | Command::Retire => return Next::Retire,
                Command::Restart(start) => start,
            };
            if !start
                .swept
                .iter()
                .zip(self.swept)
                .all(|(value, &index)| orbit.parameters[index].to_bits() == value.to_bits())
            {
                orbit.parameters = self.parameters(&start.swept);
                trajectory.set_parameters(&orbit.parameters);
            }
            match self.place(orbit, trajectory, &start.origin) {
                Ok(()) => return Next::Continue,
                Err(reason) => {
                    failed = true;
                    let (_, point) = self.origin(orbit, &start.origin);
                    command = self.arrive(orbit, &point, Err(reason));
                }
            }
        }
    }

    #[inline]
    fn arrive(
        &mut self,
        orbit: &Orbit,
        point: &[f64],
        passage: Result<Passage, NoReturn>,
    ) -> Command {
        (self.visit)(Arrival {
            orbit: orbit.orbit,
            point,
            parameters: &orbit.parameters,
            passage,
        })
    }
}

/// The period at parameter values that count as exact, as they do in the equations.
pub(super) fn strobe_period(period: &Formula<DoubleDouble>, parameters: &[f64]) -> DoubleDouble {
    let exact: Vec<DoubleDouble> = parameters.iter().map(|&value| value.into()).collect();
    period.evaluate(&[], &exact, &mut Vec::new())
}
