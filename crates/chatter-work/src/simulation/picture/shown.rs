//! What a figure shows of a simulation, as plain numbers.

use super::{Record, Subject};
use crate::refusal::Refusal;
use chatter::analysis::simulate::{Outcome, Samples, Simulation};
use chatter::flow::{Closed, EventKind, Occurrence};
use chatter::numerics::Real;
use std::collections::VecDeque;

/// After the last motion of a system that has come to rest, this part of the time before is shown.
const REST_SHOWN: f64 = 0.12;

/// Impacts and contact phases that can be told apart in one picture.
const MOST_IMPACTS: usize = 1500;
const MOST_PHASES: usize = 30;

/// The part of a simulation within a window of time.
pub struct Shown {
    /// Whether the beginning is left out though nobody said so.
    pub shortened: bool,
    /// First time shown.
    pub from: f64,
    /// Last time shown.
    pub to: f64,
    /// Times of the samples.
    pub times: Vec<f64>,
    /// For each state of the model its values.
    pub states: Vec<Vec<f64>>,
    /// Samples before which the state jumps.
    pub jumps: Vec<usize>,
    /// For each contact the times of its impacts.
    pub impacts: Vec<Vec<f64>>,
    /// Times and states of accumulations.
    pub accumulations: Vec<(f64, Vec<f64>)>,
    /// For each contact the intervals in which it is closed.
    pub contact_phases: Vec<Vec<(f64, f64)>>,
}

impl Shown {
    /// The part within `window`; without one, the latest part that can be told apart, up to the last motion.
    pub fn new<R: Real>(
        subject: &Subject,
        (simulation, record): (&Simulation<R>, &Record<R>),
        samples: &Samples<R>,
        window: Option<(f64, f64)>,
    ) -> Result<Self, Refusal> {
        let doubles = |values: &[R]| {
            values
                .iter()
                .map(|value| value.to_f64())
                .collect::<Vec<f64>>()
        };
        let mut times = doubles(&samples.times);
        let mut states: Vec<Vec<f64>> = samples.states.iter().map(|state| doubles(state)).collect();
        let (start, end) = (simulation.start_time.to_f64(), simulation.time.to_f64());
        let (mut from, mut to) = window.unwrap_or((start, end));
        if window.is_none() {
            let first_sample = times.first().copied();
            from = first_readable(simulation, record)?.max(first_sample.unwrap_or(start));
        }
        let shortened = window.is_none() && from > start;
        let rest = rests_from(subject, simulation, &times, &states);
        // What rests goes on to do so.
        if window.is_some() && (to <= start || (from >= end && rest.is_none())) {
            return Err(Refusal::input(format!(
                "--window: {from}:{to} has nothing of the run, which goes from time {start} to {end}"
            )));
        }
        if let Some(rest) = rest {
            if window.is_none() {
                to = rest + REST_SHOWN * (rest - from);
            }
            if to > end {
                times.push(to);
                states
                    .iter_mut()
                    .for_each(|values| values.extend(values.last().copied()));
            }
        }
        if to <= from {
            (from, to) = (start - 0.5, start + 0.5);
        }
        // One sample on either side, so that curves reach the edges.
        let first = times.partition_point(|&time| time < from).saturating_sub(1);
        let last = (times.partition_point(|&time| time <= to) + 1).min(times.len());
        let kept = first.min(last)..last;
        times = times[kept.clone()].to_vec();
        for values in &mut states {
            *values = values[kept.clone()].to_vec();
        }
        let differs = |place: usize| {
            states
                .iter()
                .any(|values| values[place] != values[place - 1])
        };
        let jumps = (1..times.len())
            .filter(|&place| times[place] == times[place - 1] && differs(place))
            .collect();
        let mut impacts = vec![Vec::new(); subject.model.contacts.len()];
        let mut accumulations = Vec::new();
        for noted in record.events() {
            let event = noted?.event;
            let time = event.time.to_f64();
            match event.detail {
                _ if !(from..=to).contains(&time) => {}
                Occurrence::Impact { contact, .. } => impacts[contact].push(time),
                Occurrence::Accumulation { .. } => {
                    accumulations.push((time, doubles(&event.state)))
                }
                _ => {}
            }
        }
        let mut contact_phases = vec![Vec::new(); subject.model.contacts.len()];
        for phase in record.contact_phases() {
            let phase = phase?;
            let (start, end) = (phase.start.to_f64(), phase.end.map_or(to, Real::to_f64));
            if start <= to && end >= from {
                contact_phases[phase.contact].push((start, end));
            }
        }
        Ok(Self {
            shortened,
            from,
            to,
            impacts,
            accumulations,
            contact_phases,
            jumps,
            times,
            states,
        })
    }
}

/// From when on impacts and contact phases are few enough.
fn first_readable<R: Real>(simulation: &Simulation<R>, record: &Record<R>) -> Result<f64, Refusal> {
    let (mut impacts, mut phases) = (VecDeque::new(), VecDeque::new());
    let latest = |times: &mut VecDeque<R>, most: usize, time: R| {
        times.push_back(time);
        if times.len() > most + 1 {
            times.pop_front();
        }
    };
    for noted in record.events() {
        let event = noted?.event;
        if event.kind == EventKind::Impact {
            latest(&mut impacts, MOST_IMPACTS, event.time);
        }
    }
    for phase in record.contact_phases() {
        latest(&mut phases, MOST_PHASES, phase?.start);
    }
    let first = |times: VecDeque<R>, most: usize| {
        let is_long = times.len() > most;
        times.front().copied().filter(|_| is_long)
    };
    let starts = [first(impacts, MOST_IMPACTS), first(phases, MOST_PHASES)];
    let start = simulation.start_time.to_f64();
    let starts = starts.into_iter().flatten();
    Ok(starts.fold(start, |latest, time| latest.max(time.to_f64())))
}

/// When the state changed for the last time, if it ended in contact.
fn rests_from<R: Real>(
    subject: &Subject,
    simulation: &Simulation<R>,
    times: &[f64],
    states: &[Vec<f64>],
) -> Option<f64> {
    if simulation.closed == Closed::NONE {
        return None;
    }
    let last = times.len().checked_sub(1)?;
    let rests = |place: usize| {
        subject
            .states()
            .all(|index| states[index][place] == states[index][last])
    };
    let first = (0..=last).rev().take_while(|&place| rests(place)).last()?;
    let known = first < last || simulation.outcome == Outcome::Rest;
    (known && first > 0).then(|| times[first])
}
