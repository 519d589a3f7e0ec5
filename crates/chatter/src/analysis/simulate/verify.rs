//! How far a run in doubles can be believed: beside a twin in double-double.
//!
//! The error told with an accumulation is local: it leaves out what the errors before it have grown to, which in chaotic
//! motion soon is all there is. The twin starts from the model as it is written, so that the difference of the two has
//! everything in it: rounding of the parameters, steps, events, completed sequences, and the growth of all these.

use super::result::{Event, EventDetail, Outcome, Simulation};
use super::spec::Spec;
use super::{Progress, SimulateError, simulate};
use crate::model::Model;
use crate::numerics::{DoubleDouble, Real, Scalar};
use core::ops::ControlFlow;

/// A run that was ended by an event is followed by its twin for this part of its duration more: the event may be late.
const LATER: f64 = 1e-2;

/// How a run in doubles compares with its twin.
#[derive(Clone, Debug, PartialEq)]
pub struct Verification {
    /// By how much the times of the run's events are off, in order, up to where the runs part ways.
    pub times: Vec<f64>,
    /// Where they part ways.
    pub parting: Option<Parting>,
    /// By how much time and state at the end are off; none where the runs end in different ways, or with an event that the
    /// twin does not come to.
    pub end: Option<EndError>,
}

/// Differences at the end.
#[derive(Clone, Debug, PartialEq)]
pub struct EndError {
    /// Of the time.
    pub time: f64,
    /// Of each state.
    pub state: Vec<f64>,
}

/// The first event that one run has and the other has not.
#[derive(Clone, Debug, PartialEq)]
pub struct Parting {
    /// How many events the runs have in common.
    pub after: usize,
    /// What the run does next, and when; none where it ends.
    pub run: Option<(f64, EventDetail<f64>)>,
    /// What its twin does.
    pub twin: Option<(f64, EventDetail<f64>)>,
}

impl Verification {
    /// The largest error of the time of an event.
    pub fn worst_time(&self) -> f64 {
        self.times.iter().fold(0.0, |worst, &off| worst.max(off))
    }

    /// Follows the twin of a run and compares. Progress is the twin's; none if the observer breaks off.
    ///
    /// # Errors
    /// As for [`simulate`].
    pub fn of(
        model: &Model,
        spec: &Spec,
        run: &Simulation<f64>,
        observer: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
    ) -> Result<Option<Self>, SimulateError> {
        let mut twin_spec = Spec {
            impacts: u64::MAX,
            tolerance: 0.0,
            sampling: Vec::new(),
            ..spec.clone()
        };
        let ends_with_event = match run.outcome {
            Outcome::Event(_) | Outcome::ImpactBudget | Outcome::Interrupted => true,
            Outcome::Horizon | Outcome::Rest | Outcome::Failed(_) => false,
        };
        if ends_with_event {
            // Impacts that one of the runs completes count in the other.
            let later = (run.time - run.start_time) * LATER;
            twin_spec.until = DoubleDouble::from(run.time) + later.max(f64::MIN_POSITIVE).into();
            twin_spec.stops = Vec::new();
        }
        let twin: Simulation<DoubleDouble> = simulate(model, &twin_spec, observer)?;
        if twin.outcome == Outcome::Interrupted {
            return Ok(None);
        }
        Ok(Some(compare(run, &twin, ends_with_event)))
    }
}

/// How many significant digits a number has that is off by so much: all of a double's where it is off by nothing.
pub fn digits(value: f64, off: f64) -> u32 {
    const ALL: f64 = 16.0;
    if off == 0.0 {
        return ALL as u32;
    }
    let digits = -libm::log10(off / value.abs());
    if digits > 0.0 {
        libm::floor(digits.min(ALL)) as u32
    } else {
        0
    }
}

fn compare(
    run: &Simulation<f64>,
    twin: &Simulation<DoubleDouble>,
    ends_with_event: bool,
) -> Verification {
    let mut times = Vec::new();
    let (mut next, mut other) = (0, 0);
    let mut latest = None;
    let parting = loop {
        let (mine, theirs) = (run.events.get(next), twin.events.get(other));
        match (mine, theirs) {
            (None, None) => break None,
            (None, Some(_)) if ends_with_event => break None,
            (Some(mine), Some(theirs)) if same(mine, theirs) => {
                times.push(off(mine.time, theirs.time));
                latest = Some((mine, theirs));
                next += 1;
                other += 1;
                continue;
            }
            _ => {}
        }
        // A sequence is completed after more impacts in one run than in the other.
        if completes(mine, theirs) {
            other += 1;
        } else if completes(theirs, mine) {
            // The time of an impact that the twin has completed is not known.
            times.push(f64::NAN);
            next += 1;
        } else {
            break Some(Parting {
                after: next,
                run: mine.map(told),
                twin: theirs.map(told),
            });
        }
    };
    let end = if ends_with_event {
        latest
            .filter(|_| parting.is_none())
            .map(|(mine, theirs)| EndError {
                time: off(mine.time, theirs.time),
                state: differences(&mine.state, &theirs.state),
            })
    } else if run.outcome.name() == twin.outcome.name() {
        Some(EndError {
            time: off(run.time, twin.time),
            state: differences(&run.state, &twin.state),
        })
    } else {
        None
    };
    Verification {
        times,
        parting,
        end,
    }
}

fn off(value: f64, exact: DoubleDouble) -> f64 {
    (DoubleDouble::from(value) - exact).abs().to_f64()
}

fn differences(state: &[f64], exact: &[DoubleDouble]) -> Vec<f64> {
    let pairs = state.iter().zip(exact);
    pairs.map(|(&value, &exact)| off(value, exact)).collect()
}

fn told<R: Real>(event: &Event<R>) -> (f64, EventDetail<f64>) {
    (event.time.to_f64(), event.detail.to_f64())
}

/// Whether two events are of one kind at one place.
fn same<R: Real, S: Real>(a: &Event<R>, b: &Event<S>) -> bool {
    a.kind() == b.kind() && a.detail.place() == b.detail.place()
}

/// Whether the first is the end of a sequence that the second still belongs to.
fn completes<R: Real, S: Real>(end: Option<&Event<R>>, impact: Option<&Event<S>>) -> bool {
    let (Some(end), Some(impact)) = (end, impact) else {
        return false;
    };
    matches!(end.detail, EventDetail::Accumulation { .. })
        && matches!(impact.detail, EventDetail::Impact { .. })
        && end.detail.place() == impact.detail.place()
}
