//! One trajectory with all that happens on it.
//!
//! ```text
//! Spec        how long, what stops it, what is sampled
//! simulate -> Simulation    events, contact phases, counts, samples, outcome
//! Verification              how far it agrees with a twin of twice the digits
//! ```
//!
//! ```
//! use chatter::analysis::simulate::{Spec, simulate};
//! use chatter::model::Model;
//! use std::ops::ControlFlow;
//!
//! let text = "
//! [flight]
//! y = 'v'
//! v = -9.81
//!
//! [[contact]]
//! gap = 'y'
//! impulse = { v = 1 }
//! restitution = 0.5
//!
//! [initial]
//! y = 1
//! v = 0
//! ";
//! let model = Model::from_toml(text, "ball")?;
//! let run = simulate::<f64>(&model, &Spec::until(10.0), &mut |_| ControlFlow::Continue(()))?;
//! assert_eq!(run.counts.accumulations, 1);
//! assert!(run.contact_phases[0].start < 1.355);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod fastest_rate;
mod place;
mod recorder;
mod result;
mod samples;
mod sink;
mod spec;
mod tolerance;
mod verify;

#[cfg(test)]
mod tests;

pub use crate::flow::EventKind;
pub use fastest_rate::FastestRate;
pub use place::UnknownPlace;
pub use result::{ContactPhase, Counts, Event, Outcome, Simulation};
pub use samples::Samples;
pub use sink::Sink;
pub use spec::{EventTarget, Sampling, Spec, SpecError, Stop};
pub use tolerance::WrongTolerance;
pub(crate) use tolerance::check_tolerance;
pub use verify::{EndError, Parting, Verification, digits};

use crate::flow::{FlowError, Occurrence, Settings, System, SystemError, Trajectory};
use crate::model::{Model, ModelError};
use crate::numerics::Real;
use core::fmt;
use core::ops::ControlFlow;
use recorder::Recorder;
use sink::Keeper;

/// The observer is asked every so many steps: often enough for a reaction within a blink even where each step has to be
/// settled by itself, too rarely to cost.
const STEPS_BETWEEN_REPORTS: u64 = 16;

/// So many steps one after the other, without an event, that do not change the time: the equations grow without bound at
/// a time that is reached to rounding, where each step is a part of what is left.
const MOST_AT_ONE_TIME: u32 = 10_000;

/// A chatter sequence is integrated until this share of its duration is left: no more than a line's width in a picture.
const LONGEST_TAIL: f64 = 1e-3;

/// How far a run is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Steps made.
    pub steps: u64,
    /// Time where it began.
    pub start: f64,
    /// Time reached.
    pub time: f64,
    /// Time where it ends at the latest.
    pub until: f64,
    /// Impacts so far.
    pub impacts: u64,
    /// Impacts it may have.
    pub impact_budget: u64,
}

/// Follows the trajectory from the model's initial state, at the model's parameter values, until something stops it.
///
/// The observer hears of progress every few steps and may break off; what was computed before is kept. So it is when
/// the equations leave their domain or the mechanics do not determine what follows: see [`Outcome`].
///
/// # Errors
/// The specification does not fit the model, the model cannot be compiled, or the initial state is not a state that a
/// trajectory can start from.
pub fn simulate<R: Real>(
    model: &Model,
    spec: &Spec,
    observer: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Result<Simulation<R>, SimulateError> {
    let mut keeper = Keeper::new();
    let mut simulation = simulate_into(model, spec, observer, &mut keeper)?;
    simulation.events = keeper.events;
    simulation.contact_phases = keeper.contact_phases;
    for (kept, handed_over) in simulation.samples.iter_mut().zip(keeper.samples) {
        if !handed_over.is_empty() {
            *kept = handed_over;
        }
    }
    Ok(simulation)
}

/// Like [`simulate`], with events, contact phases and samples handed over as they come, so that memory does not grow with
/// them: all of them by the end, and none are in the result. Samples for a picture ([`Sampling::Smooth`]) are kept. The sink
/// may break off, too.
///
/// # Errors
/// As for [`simulate`].
pub fn simulate_into<R: Real>(
    model: &Model,
    spec: &Spec,
    observer: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
    sink: &mut dyn Sink<R>,
) -> Result<Simulation<R>, SimulateError> {
    model.check_defined().map_err(SimulateError::Model)?;
    let model = &model.with_telling_numbers(&[]);
    let system = System::new(model).map_err(SimulateError::System)?;
    let settings = Settings {
        tolerance: spec.tolerance,
        longest_tail: LONGEST_TAIL,
        ..Settings::default()
    };
    let mut work = system.workspace::<R>(&settings);
    let parameters = model.parameter_values::<R>(&[]);
    let state = model.initial_state(&parameters);
    let start = model.time.map_or(R::ZERO, |index| state[index]);
    let mut targets = spec.targets(model, start.to_double_double())?;
    let until = R::from_double_double(spec.until);
    if until.partial_cmp(&start) != Some(core::cmp::Ordering::Greater) || !until.is_finite() {
        return Err(SpecError::Until {
            start: start.to_f64(),
            until: until.to_f64(),
        }
        .into());
    }
    check_restitution(model, &parameters, &state, start)?;
    let mut trajectory = Trajectory::start(&system, &mut work, &parameters, start, &state)
        .map_err(SimulateError::Start)?;
    let mut recorder = Recorder::new(&spec.sampling, &state, (&system, &trajectory));
    let begun = recorder.follow_phases(&trajectory, sink);
    let stops_at_rest = spec.stops.contains(&Stop::Rest) && model.time.is_none();
    let mut steps: u64 = 0;
    let (mut latest, mut at_one_time) = (trajectory.time(), 0);

    let outcome = loop {
        if begun.is_break() {
            break Outcome::Interrupted;
        }
        if steps.is_multiple_of(STEPS_BETWEEN_REPORTS) {
            let progress = Progress {
                steps,
                start: start.to_f64(),
                time: trajectory.time().to_f64(),
                until: until.to_f64(),
                impacts: recorder.counts.impacts,
                impact_budget: spec.impacts,
            };
            if observer(&progress).is_break() {
                break Outcome::Interrupted;
            }
        }
        steps += 1;
        let within = recorder.within_sequence(&system, &mut work, &trajectory, sink);
        if within.is_break() {
            break Outcome::Interrupted;
        }
        let occurrence = match trajectory.advance(&system, &mut work, until) {
            Ok(occurrence) => occurrence,
            // What a root is taken of may have been nothing but for rounding: only a step tells.
            Err(error @ FlowError::LeftDomain { time, .. }) if time == start.to_f64() => {
                return Err(SimulateError::Start(error));
            }
            Err(error) => break Outcome::Failed(error),
        };
        if matches!(occurrence, None | Some(Occurrence::Horizon))
            && stops_at_rest
            && recorder.at_rest(&system, &mut work, &trajectory)
        {
            break Outcome::Rest;
        }
        let sampled = recorder.motion(&work.dense(), &trajectory, sink);
        if sampled.is_break() {
            break Outcome::Interrupted;
        }
        if occurrence.is_some() || trajectory.time() != latest {
            (latest, at_one_time) = (trajectory.time(), 0);
        }
        at_one_time += 1;
        if at_one_time > MOST_AT_ONE_TIME {
            break Outcome::Failed(FlowError::LeftDomain {
                time: trajectory.time().to_f64(),
                state: trajectory.state().iter().map(|x| x.to_f64()).collect(),
            });
        }
        match occurrence {
            None => {}
            Some(Occurrence::Horizon) => break Outcome::Horizon,
            Some(occurrence) => {
                let told = recorder.event(occurrence, &trajectory, sink);
                if let Some(target) = targets.reached_by(recorder.latest()) {
                    break Outcome::Event(target);
                }
                if recorder.counts.impacts >= spec.impacts {
                    break Outcome::ImpactBudget;
                }
                if told.is_break() {
                    break Outcome::Interrupted;
                }
            }
        }
    };
    Ok(recorder.finish(outcome, (&system, &trajectory), sink))
}

/// A restitution that depends on parameters alone is wrong from the start, not only at the first impact.
fn check_restitution<R: Real>(
    model: &Model,
    parameters: &[R],
    state: &[R],
    time: R,
) -> Result<(), SimulateError> {
    for (contact, described) in model.contacts.iter().enumerate() {
        let restitution = described.restitution;
        let value = (model.graph.evaluate(restitution, state, parameters)).to_f64();
        if !model.graph.depends_on_state(restitution) && !(0.0..=1.0).contains(&value) {
            let time = time.to_f64();
            return Err(SimulateError::Start(FlowError::Restitution {
                time,
                contact,
                value,
            }));
        }
    }
    Ok(())
}

/// Why a simulation cannot begin.
#[derive(Clone, Debug)]
pub enum SimulateError {
    /// The specification is wrong by itself or does not fit the model.
    Spec(SpecError),
    /// Some formula of the model has no value at its parameters.
    Model(ModelError),
    /// The model cannot be compiled.
    System(SystemError),
    /// No trajectory starts from the initial state.
    Start(FlowError),
}

impl From<SpecError> for SimulateError {
    fn from(error: SpecError) -> Self {
        Self::Spec(error)
    }
}

impl fmt::Display for SimulateError {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Spec(error) => error.fmt(out),
            Self::Model(error) => error.fmt(out),
            Self::System(error) => error.fmt(out),
            Self::Start(error) => error.fmt(out),
        }
    }
}

impl core::error::Error for SimulateError {}
