//! How far a run in doubles can be believed: beside a twin in double-double.
//!
//! The error told with an accumulation is local: it leaves out what the errors before it have grown to, which in chaotic
//! motion soon is all there is. The twin starts from the model as it is written, so that the difference of the two has
//! everything in it: rounding of the parameters, steps, events, completed sequences, and the growth of all these.

use super::result::{ContactPhase, Event, Outcome, Simulation};
use super::samples::Samples;
use super::sink::Sink;
use super::spec::Spec;
use super::{Progress, SimulateError, simulate_into};
use crate::flow::Occurrence;
use crate::model::Model;
use crate::numerics::{DoubleDouble, Real, Scalar};
use core::iter::Peekable;
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
    pub run: Option<(f64, Occurrence<f64>)>,
    /// What its twin does.
    pub twin: Option<(f64, Occurrence<f64>)>,
}

impl Verification {
    /// The largest error of the time of an event.
    pub fn worst_time(&self) -> f64 {
        self.times.iter().fold(0.0, |worst, &off| worst.max(off))
    }

    /// Follows the twin of a run and compares. Progress is the twin's; none if the observer breaks off.
    ///
    /// # Errors
    /// As for [`simulate`](super::simulate).
    pub fn of(
        model: &Model,
        spec: &Spec,
        run: &Simulation<f64>,
        observer: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
    ) -> Result<Option<Self>, SimulateError> {
        Self::beside(model, spec, run, &mut run.events.iter().cloned(), observer)
    }

    /// Like [`of`](Self::of), for a run whose events a sink has taken: they are asked for as the twin comes to its own.
    ///
    /// # Errors
    /// As for [`simulate`](super::simulate).
    pub fn beside(
        model: &Model,
        spec: &Spec,
        run: &Simulation<f64>,
        events: &mut dyn Iterator<Item = Event<f64>>,
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
        let mut comparison = Comparison {
            events: events.peekable(),
            times: Vec::new(),
            latest: None,
            parting: None,
            is_over: false,
            ends_with_event,
        };
        let twin = simulate_into(model, &twin_spec, observer, &mut comparison)?;
        if twin.outcome == Outcome::Interrupted {
            return Ok(None);
        }
        Ok(Some(comparison.finish(run, &twin)))
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

/// Compares the events of a run with those of its twin while that comes to them.
struct Comparison<'a> {
    events: Peekable<&'a mut dyn Iterator<Item = Event<f64>>>,
    times: Vec<f64>,
    /// Differences at the latest event that both have.
    latest: Option<EndError>,
    parting: Option<Parting>,
    /// The runs have parted, or the run has no further events to compare with.
    is_over: bool,
    ends_with_event: bool,
}

impl Comparison<'_> {
    /// The run's next event is another one than the twin's, or only one of them has one.
    fn part(&mut self, twin: Option<&Event<DoubleDouble>>) {
        self.is_over = true;
        let run = self.events.peek();
        if run.is_none() && (twin.is_none() || self.ends_with_event) {
            return;
        }
        self.parting = Some(Parting {
            after: self.times.len(),
            run: run.map(told),
            twin: twin.map(told),
        });
    }

    fn finish(mut self, run: &Simulation<f64>, twin: &Simulation<DoubleDouble>) -> Verification {
        if !self.is_over {
            self.part(None);
        }
        let end = if self.ends_with_event {
            self.latest.filter(|_| self.parting.is_none())
        } else if run.outcome.name() == twin.outcome.name() {
            Some(EndError {
                time: off(run.time, twin.time),
                state: differences(&run.state, &twin.state),
            })
        } else {
            None
        };
        Verification {
            times: self.times,
            parting: self.parting,
            end,
        }
    }
}

impl Sink<DoubleDouble> for Comparison<'_> {
    fn samples(&mut self, _: usize, _: &Samples<DoubleDouble>) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }

    fn event(&mut self, theirs: &Event<DoubleDouble>) -> ControlFlow<()> {
        while !self.is_over {
            let mine = self.events.peek();
            if let Some(mine) = mine.filter(|mine| same(mine, theirs)) {
                let time = off(mine.time, theirs.time);
                self.times.push(time);
                self.latest = Some(EndError {
                    time,
                    state: differences(&mine.state, &theirs.state),
                });
                self.events.next();
                break;
            }
            // A sequence is completed after more impacts in one run than in the other.
            if completes(mine, Some(theirs)) {
                break;
            } else if completes(Some(theirs), mine) {
                // The time of an impact that the twin has completed is not known.
                self.times.push(f64::NAN);
                self.events.next();
            } else {
                self.part(Some(theirs));
            }
        }
        ControlFlow::Continue(())
    }

    fn contact_phase(&mut self, _: u64, _: &ContactPhase<DoubleDouble>) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

fn off(value: f64, exact: DoubleDouble) -> f64 {
    (DoubleDouble::from(value) - exact).abs().to_f64()
}

fn differences(state: &[f64], exact: &[DoubleDouble]) -> Vec<f64> {
    let pairs = state.iter().zip(exact);
    pairs.map(|(&value, &exact)| off(value, exact)).collect()
}

fn told<R: Real>(event: &Event<R>) -> (f64, Occurrence<f64>) {
    (event.time.to_f64(), event.detail.to_f64())
}

/// Whether two events are of one kind at one place.
fn same<R: Real, S: Real>(a: &Event<R>, b: &Event<S>) -> bool {
    a.kind == b.kind && a.detail.place() == b.detail.place()
}

/// Whether the first is the end of a sequence that the second still belongs to.
fn completes<R: Real, S: Real>(end: Option<&Event<R>>, impact: Option<&Event<S>>) -> bool {
    let (Some(end), Some(impact)) = (end, impact) else {
        return false;
    };
    matches!(end.detail, Occurrence::Accumulation { .. })
        && matches!(impact.detail, Occurrence::Impact { .. })
        && end.detail.place() == impact.detail.place()
}
