//! Follows one trajectory: its events are noted, its samples written as they come.

use super::expectation::{StepWatch, kept_in_memory};
use super::table::SampleTable;
use super::{Expectation, Record, Subject, event_table, sentence};
use crate::observer::Observer;
use crate::refusal::Refusal;
use chatter::analysis::simulate::{
    ContactPhase, Event, Progress as Reached, Samples, SimulateError, Simulation, Sink, SpecError,
    simulate_into,
};
use chatter::model::Model;
use chatter::numerics::Real;
use chatter_files::atomic_file::folder_of;
use core::cell::Cell;
use core::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Where the samples of a run go while it goes on.
pub enum Rows<'a> {
    /// Nowhere: there are none.
    None,
    /// Into the table that will stand at this path.
    Table(&'a Path),
    /// Nowhere: the table at this path has the events for its rows.
    Events(&'a Path),
    /// To whoever takes them, as doubles are too few for some.
    Memory,
}

/// A run that has come to its end.
pub struct Followed<'a, R> {
    /// How it ended.
    pub simulation: Simulation<R>,
    /// What happened on it.
    pub record: Record<R>,
    /// Its samples, where they were to be kept in memory.
    pub samples: Option<Samples<R>>,
    table: Option<SampleTable<'a>>,
}

impl<R: Real> Followed<'_, R> {
    /// Puts the table in its place, where there is one.
    ///
    /// # Errors
    /// It cannot be written.
    pub fn write(&mut self, subject: &Subject, rows: &Rows) -> Result<(), Refusal> {
        match (rows, self.table.take()) {
            (_, Some(table)) => table.finish(&self.simulation)?,
            (Rows::Events(path), None) => {
                event_table::write(subject, (&self.simulation, &self.record), path)?;
            }
            _ => {}
        }
        Ok(())
    }
}

/// Follows the trajectory from the model's initial state.
///
/// # Errors
/// The run cannot begin, or what it hands over cannot be written.
pub fn follow<'a, R: Real>(
    subject: &'a Subject,
    rows: &Rows,
    observer: &dyn Observer,
) -> Result<Followed<'a, R>, Refusal> {
    let table = match *rows {
        Rows::Events(path) => {
            event_table::check(subject, path)?;
            None
        }
        Rows::Table(path) => {
            if let Some(remark) = Expectation::of_table(subject, path).remark() {
                observer.remark(&remark);
            }
            Some(SampleTable::create(subject, path)?)
        }
        Rows::Memory => {
            Expectation::in_memory(subject)?;
            None
        }
        Rows::None => None,
    };
    let path = match *rows {
        Rows::Events(path) | Rows::Table(path) => Some(path),
        Rows::None | Rows::Memory => None,
    };
    let began = Instant::now();
    let mut stiffness = Some(StepWatch::new(subject));
    let show = |reached: &Reached, rows: u64| {
        observer.progress(part_done(reached), &|| {
            let rate = reached.steps as f64 / began.elapsed().as_secs_f64();
            let (time, impacts) = (reached.time, reached.impacts);
            let rows = match rows {
                0 => String::new(),
                rows => format!(", {rows} rows"),
            };
            format!("time {time:.6}, {impacts} impacts{rows}, {rate:.2e} steps/s")
        });
    };
    let going_on = || observer.going_on();
    let reached = Cell::new(None);
    let folder = folder(path);
    let (dimension, contacts) = (subject.model.states.len(), subject.model.contacts.len());
    let mut listener = Listener {
        subject,
        table,
        samples: matches!(rows, Rows::Memory).then(|| Samples {
            times: Vec::new(),
            states: vec![Vec::new(); dimension],
            closed: Vec::new(),
        }),
        record: Record::new(&folder, dimension, contacts),
        failure: None,
        reached: &reached,
        rows: 0,
        show: &show,
        going_on: &going_on,
    };
    let simulation: Simulation<R> = simulate_into(
        subject.model,
        subject.spec,
        &mut |now| {
            let remark = stiffness.as_ref().and_then(|watch| watch.remark(now));
            if let Some(remark) = remark {
                stiffness = None;
                observer.remark(&remark);
            }
            show(now, 0);
            reached.set(Some(*now));
            going_on()
        },
        &mut listener,
    )
    .map_err(|error| refused(&error, subject.model))?;
    let Listener {
        table,
        samples,
        record,
        failure,
        ..
    } = listener;
    match failure {
        Some(failure) => Err(failure),
        None => Ok(Followed {
            simulation,
            record,
            samples,
            table,
        }),
    }
}

/// What a run hands over while it goes on.
struct Listener<'a, 'b, R> {
    subject: &'b Subject<'b>,
    table: Option<SampleTable<'a>>,
    samples: Option<Samples<R>>,
    record: Record<R>,
    /// Why nothing more can be taken.
    failure: Option<Refusal>,
    /// How far the run is, and the rows written.
    reached: &'b Cell<Option<Reached>>,
    rows: u64,
    show: &'b dyn Fn(&Reached, u64),
    going_on: &'b dyn Fn() -> ControlFlow<()>,
}

impl<R> Listener<'_, '_, R> {
    /// Goes on unless something could not be written, or the run is to stop.
    fn taken(&mut self, outcome: Result<(), Refusal>) -> ControlFlow<()> {
        if let Err(failure) = outcome {
            self.failure = Some(failure);
            return ControlFlow::Break(());
        }
        (self.going_on)()
    }
}

impl<R: Real> Sink<R> for Listener<'_, '_, R> {
    fn samples(&mut self, _: usize, samples: &Samples<R>) -> ControlFlow<()> {
        let taken = match (&mut self.table, &mut self.samples) {
            (Some(table), _) => table.take(samples).map_err(Refusal::from),
            (None, Some(kept)) => {
                kept.times.extend_from_slice(&samples.times);
                kept.closed.extend_from_slice(&samples.closed);
                for (values, next) in kept.states.iter_mut().zip(&samples.states) {
                    values.extend_from_slice(next);
                }
                kept_in_memory(self.subject, kept.times.len() as f64)
            }
            (None, None) => return ControlFlow::Continue(()),
        };
        self.rows += samples.len() as u64;
        if let (Some(mut reached), Some(time)) = (self.reached.get(), samples.times.last()) {
            reached.time = time.to_f64();
            (self.show)(&reached, self.rows);
        }
        self.taken(taken)
    }

    fn event(&mut self, event: &Event<R>) -> ControlFlow<()> {
        let noted = self.record.event(event);
        self.taken(noted.map_err(Refusal::from))
    }

    fn contact_phase(&mut self, number: u64, phase: &ContactPhase<R>) -> ControlFlow<()> {
        let noted = self.record.contact_phase(number, phase);
        self.taken(noted.map_err(Refusal::from))
    }
}

/// Where what does not fit memory is kept while it is needed: on the disk that the table will be on, if there is one.
fn folder(path: Option<&Path>) -> PathBuf {
    path.map_or_else(std::env::temp_dir, |path| folder_of(path).to_path_buf())
}

/// By time or by impacts, whichever is nearer to its end.
pub(super) fn part_done(reached: &Reached) -> f64 {
    let by_time = (reached.time - reached.start) / (reached.until - reached.start);
    let by_impacts = reached.impacts as f64 / reached.impact_budget as f64;
    by_time.max(by_impacts)
}

/// A run that could not begin: what was asked for is wrong.
pub(super) fn refused(error: &SimulateError, model: &Model) -> Refusal {
    match error {
        SimulateError::Spec(error) => {
            let refusal = Refusal::input(error);
            match error {
                SpecError::UnknownPlace(error) => refusal.did_you_mean(error.suggestion()),
                _ => refusal,
            }
        }
        SimulateError::Model(error) => Refusal::from(error.clone()),
        SimulateError::System(error) => Refusal::input(error),
        SimulateError::Start(error) => Refusal::input(sentence(error, model)),
    }
}
