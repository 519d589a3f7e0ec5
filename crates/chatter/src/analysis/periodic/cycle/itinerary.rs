//! An orbit as a sequence of legs, read off a trajectory.

use super::trace::Instant;
use crate::analysis::periodic::error::PeriodicError;
use crate::expressions::Side;
use crate::flow::leg::{Jump, LegKind, StretchKind};
use crate::flow::{Closed, GuardKind, Occurrence, System, Trajectory};
use crate::numerics::stored::{list, number};
use serde::{Deserialize, Serialize};

/// A part of an orbit between two of its nodes.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Step {
    pub passage: Passage,
    /// The piece of each lookup in the mode that it ends in.
    pub pieces: Vec<i64>,
    /// What happens at its end; of a stretch, all that happens. Equations do without it.
    #[serde(skip)]
    pub told: Vec<Occurrence<f64>>,
    /// Contacts that are closed after it.
    pub closed: Closed,
    /// First guess.
    #[serde(with = "list")]
    pub start: Vec<f64>,
    #[serde(with = "number")]
    pub duration: f64,
}

/// How a part of an orbit is travelled.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) enum Passage {
    /// By the smooth flow of one mode, for a time that is an unknown, up to a surface.
    Leg(LegKind),
    /// The same for a time that is given: whole periods of the forcing.
    Timed(LegKind),
    /// By following the flow through whatever happens.
    Stretch(StretchKind),
}

impl Step {
    /// For whole periods of the forcing in the mode that a trajectory is in, nothing happening.
    pub(crate) fn timed(trajectory: &Trajectory<f64>, start: Vec<f64>, duration: f64) -> Self {
        Self {
            passage: Passage::Timed(LegKind {
                mode: trajectory.mode,
                ends_at: None,
                jump: Jump::None,
            }),
            pieces: trajectory.pieces().to_vec(),
            told: Vec::new(),
            closed: trajectory.closed(),
            start,
            duration,
        }
    }

    /// The contact of the impact at its end.
    pub(crate) fn impact(&self) -> Option<usize> {
        match self.passage {
            Passage::Leg(LegKind {
                jump: Jump::Impact(contact),
                ..
            }) => Some(contact),
            _ => None,
        }
    }

    pub(crate) fn is_stretch(&self) -> bool {
        matches!(self.passage, Passage::Stretch(_))
    }

    /// The guard that ends it; none where a time does.
    pub(crate) fn ends_at(&self) -> Option<GuardKind> {
        match self.passage {
            Passage::Leg(kind) => kind.ends_at,
            Passage::Stretch(kind) => kind.last.ends_at,
            Passage::Timed(_) => None,
        }
    }

    /// The mode that it ends in.
    pub(crate) fn mode(&self) -> usize {
        match self.passage {
            Passage::Leg(kind) | Passage::Timed(kind) => kind.mode,
            Passage::Stretch(kind) => kind.last.mode,
        }
    }
}

/// Times that differ by less than this part of themselves, or of the period, are one.
const SAME_INSTANT: f64 = 8.0 * f64::EPSILON;

/// What one instant by itself is: its guard, and the jump there. None where it is more than one event.
pub(super) fn single(instant: &Instant) -> Option<LegKind> {
    let guard = instant.guard?;
    let mut jump = Jump::None;
    let mut events = 0;
    for told in &instant.told {
        match *told {
            Occurrence::Impact { contact, .. } => {
                jump = Jump::Impact(contact);
                events += 1;
            }
            Occurrence::Reset { section } => {
                jump = Jump::Reset(section);
                events += 1;
            }
            // Where a jump leads to the other side of a surface, or onto it, the mode after it says so.
            Occurrence::Switch { .. }
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

/// The steps from just after `instants[0]` to just after the last of them.
pub(crate) fn read(instants: &[Instant]) -> Result<Vec<Step>, PeriodicError> {
    let mut steps: Vec<Step> = Vec::new();
    let span = match instants {
        [first, .., last] => last.time - first.time,
        _ => 0.0,
    };
    let mut from = 0;
    let mut open: Option<(usize, usize, Vec<Occurrence<f64>>)> = None;
    for (index, instant) in instants.iter().enumerate().skip(1) {
        if instant.only_touches() {
            continue;
        }
        let kind = single(instant);
        if let Some((begin, accumulations, mut told)) = open.take() {
            told.extend(&instant.told);
            let Some(last) = kind else {
                let more = usize::from(instant.accumulated().is_some());
                open = Some((begin, accumulations + more, told));
                continue;
            };
            steps.push(stretch(
                &instants[begin],
                instant,
                (accumulations, last, told),
            ));
            from = index;
            continue;
        }
        if let Some(kind) = kind {
            let before = &instants[from];
            let duration = instant.time - before.time;
            if duration <= SAME_INSTANT * instant.time.abs().max(span)
                && (kind.jump == Jump::None || gives_jump(&mut steps, kind.jump))
            {
                // Two names for one event, as where a surface is met and held: no motion lies between them.
                from = index;
                continue;
            }
            steps.push(Step {
                passage: Passage::Leg(kind),
                pieces: instant.pieces.clone(),
                told: instant.told.clone(),
                closed: instant.closed,
                start: before.state.clone(),
                duration,
            });
            from = index;
            continue;
        }
        // A chatter sequence begins with its first impact.
        let impacts = instant.accumulated().map_or(0, |count| count as usize);
        let accumulations = usize::from(instant.accumulated().is_some());
        let mut begin = from;
        let mut told = instant.told.clone();
        for _ in 1..impacts {
            match steps.pop() {
                Some(step) if step.impact().is_some() => {
                    told.splice(0..0, step.told);
                    begin -= 1;
                }
                Some(step) => {
                    steps.push(step);
                    break;
                }
                None => break,
            }
        }
        open = Some((begin, accumulations, told));
    }
    if let Some((_, accumulations, told)) = open {
        let impacts = told
            .iter()
            .any(|told| matches!(told, Occurrence::Impact { .. }));
        let what = match accumulations {
            0 if impacts => "several impacts, or an impact and another event, at one instant",
            0 => "several events at one instant",
            _ => "complete chatter without a single event after it",
        };
        return Err(PeriodicError::Unfollowed {
            what: what.to_owned(),
        });
    }
    Ok(steps)
}

/// Lets the event before, which changes nothing by itself, make a jump; whether it can.
fn gives_jump(steps: &mut [Step], jump: Jump) -> bool {
    match steps.last_mut().map(|step| &mut step.passage) {
        Some(Passage::Leg(kind)) if kind.jump == Jump::None => {
            kind.jump = jump;
            true
        }
        _ => false,
    }
}

fn stretch(
    begin: &Instant,
    end: &Instant,
    (accumulations, last, told): (usize, LegKind, Vec<Occurrence<f64>>),
) -> Step {
    let hits = |told: &&Occurrence<f64>| matches!(told, Occurrence::Impact { .. });
    let impacts = match accumulations {
        0 => told.iter().filter(hits).count(),
        _ => 0,
    };
    Step {
        passage: Passage::Stretch(StretchKind {
            closed: begin.closed,
            on: begin.impact().map(|(contact, _)| contact),
            accumulations,
            impacts,
            last,
        }),
        pieces: end.pieces.clone(),
        told,
        closed: end.closed,
        start: begin.state.clone(),
        duration: end.time - begin.time,
    }
}

/// How many surfaces are slid along in a mode, and contacts closed.
pub(crate) fn held(system: &System, mode: usize) -> usize {
    let Some((grip, sides, _)) = system.origin_of(mode) else {
        return 0;
    };
    let slides = (0..system.corners().surfaces.len()).filter(|&k| sides.get(k) == Side::Sliding);
    2 * grip.carrying().contacts().count() + slides.count()
}
