//! What a run is going to take, said before it has taken it.

use super::Subject;
use crate::numbers::{Digits, full};
use crate::refusal::Refusal;
use chatter::analysis::simulate::{FastestRate, Progress, Sampling, Spec};
use chatter::model::Model;
use chatter::numerics::Real;
use chatter_files::atomic_file::free_space;
use core::cell::OnceCell;
use std::path::Path;

/// Rows that are many: their table has gigabytes, and takes minutes.
const MANY_ROWS: f64 = 1e8;

/// Steps that are many: they take half an hour or more.
const MANY_STEPS: f64 = 1e9;
/// The same for a stiff model, whose author may not know: some ten seconds.
const MANY_STIFF_STEPS: f64 = 1e7;

/// Steps from which the others are estimated: some hundredths of a second.
const FIRST_STEPS: u64 = 20_000;

/// Bytes of a number in a table.
const NUMBER: f64 = 8.0;

/// How large a table becomes if the run lasts as long as it may.
#[derive(Clone, Debug, PartialEq)]
pub struct Expectation {
    /// Its rows; none if they come as the run has them.
    pub rows: Option<f64>,
    /// Its bytes.
    pub bytes: Option<f64>,
    /// Bytes that the disk has left.
    pub free: Option<u64>,
}

/// So many numbers are kept in memory at most: eight gigabytes, and as many again where they are handed on.
const MOST_KEPT: f64 = (1_u64 << 30) as f64;

/// Refuses more rows than memory is to keep.
///
/// # Errors
/// There are more.
pub fn kept_in_memory(subject: &Subject, rows: f64) -> Result<(), Refusal> {
    let most = MOST_KEPT / columns(subject) as f64;
    if rows <= most {
        return Ok(());
    }
    let (rows, bytes) = (
        format!("{rows:.1e}"),
        size(rows * columns(subject) as f64 * NUMBER),
    );
    Err(Refusal::input(format!(
        "{rows} samples, about {bytes}, are more than is kept in memory: {most:.1e} are"
    ))
    .help("a longer interval, or `chatter simulate --sample INTERVAL --out FILE.npz`, which keeps them in a file"))
}

/// The numbers in a row: time, states, and what each contact does.
fn columns(subject: &Subject) -> usize {
    1 + subject.states().count() + subject.model.contacts.len()
}

impl Expectation {
    /// Of the table at `path`.
    pub fn of_table(subject: &Subject, path: &Path) -> Self {
        let rows = Self::rows(subject);
        Self {
            rows,
            bytes: rows.map(|rows| rows * columns(subject) as f64 * NUMBER),
            free: free_space(path),
        }
    }

    /// Rows of a run that lasts as long as it may.
    fn rows(subject: &Subject) -> Option<f64> {
        let parameters = subject.model.parameter_values::<f64>(&[]);
        let initial = subject.model.initial_state(&parameters);
        let start = subject.model.time.map_or(0.0, |time| initial[time]);
        match subject.spec.sampling.first() {
            Some(Sampling::Every(interval)) if interval.to_f64() > 0.0 => {
                Some((subject.spec.until.to_f64() - start) / interval.to_f64())
            }
            _ => None,
        }
    }

    /// Refuses a run whose samples memory is not to keep, where nothing but its time is to end it.
    ///
    /// # Errors
    /// There will be too many.
    pub fn in_memory(subject: &Subject) -> Result<(), Refusal> {
        let spec = subject.spec;
        let ends_by_time = subject.time_was_given && spec.stops.is_empty();
        match Self::rows(subject) {
            Some(rows) if ends_by_time && spec.impacts == Spec::IMPACT_BUDGET => {
                kept_in_memory(subject, rows)
            }
            _ => Ok(()),
        }
    }

    /// What there is to say if it is more than may be meant.
    pub fn remark(&self) -> Option<String> {
        let (rows, bytes) = (self.rows?, self.bytes?);
        let over = self.free.filter(|&free| bytes > free as f64);
        if rows < MANY_ROWS && over.is_none() {
            return None;
        }
        let disk = match over {
            Some(free) => format!(", and the disk has {} left", size(free as f64)),
            None => String::new(),
        };
        Some(format!(
            "up to {rows:.1e} rows are asked for, about {}{disk}; Ctrl-C ends the run and keeps what is done",
            size(bytes)
        ))
    }
}

/// Bytes, to two digits.
fn size(bytes: f64) -> String {
    const UNITS: [&str; 6] = ["kB", "MB", "GB", "TB", "PB", "EB"];
    let mut value = bytes / 1e3;
    for unit in UNITS {
        if value < 1e3 {
            return format!("{value:.1} {unit}");
        }
        value /= 1e3;
    }
    format!("{bytes:.1e} bytes")
}

/// Looks at how far steps lead, and says once that there will be many.
pub struct StepWatch<'a> {
    subject: &'a Subject<'a>,
    /// Once it has been asked for: a model that is refused has none, and a short run needs none.
    fastest: OnceCell<Option<FastestRate>>,
}

impl<'a> StepWatch<'a> {
    /// For a run that begins.
    pub fn new(subject: &'a Subject<'a>) -> Self {
        Self {
            subject,
            fastest: OnceCell::new(),
        }
    }

    /// What there is to say, once that is known.
    pub fn remark(&self, reached: &Progress) -> Option<String> {
        if reached.steps < FIRST_STEPS {
            return None;
        }
        let begun = reached.time - reached.start;
        let mean = begun / reached.steps as f64;
        let by_time = (reached.until - reached.time) / mean;
        let left = (reached.impact_budget - reached.impacts) as f64;
        let by_impacts = left * reached.steps as f64 / reached.impacts as f64;
        // Whichever comes first ends the run; no impact so far says nothing.
        let steps = by_time.min(by_impacts);
        let fastest = (self.fastest).get_or_init(|| FastestRate::at_start(self.subject.model));
        let limit = (*fastest).filter(|fastest| fastest.rate * mean > SLOWEST);
        let stiff = limit.is_some_and(|limit| limit.is_stiff());
        // Also where no time has passed at all.
        if steps < if stiff { MANY_STIFF_STEPS } else { MANY_STEPS } {
            return None;
        }
        let model = self.subject.model;
        let why = match limit {
            Some(fastest) => format!("{}; they are", limiting(model, &fastest)),
            None => "steps are".to_owned(),
        };
        Some(format!(
            "{why} {mean:.1e} long on average: to time {} there are about {steps:.1e} of them; Ctrl-C ends the run and keeps \
             what is done",
            full(reached.until, Digits::DOUBLE)
        ))
    }
}

/// What limits the steps, in words.
pub fn limiting(model: &Model, fastest: &FastestRate) -> String {
    let name = |index: usize| &model.states[index].name;
    let (state, with) = (name(fastest.state), name(fastest.with));
    let between = match fastest.state == fastest.with {
        true => format!("`{state}` changes"),
        false => format!("`{state}` and `{with}` change each other"),
    };
    let stiff = if fastest.is_stiff() {
        "the model is stiff: "
    } else {
        ""
    };
    format!(
        "{stiff}{between} at a rate of {:.1e}, which limits the steps",
        fastest.rate
    )
}

/// A rate limits steps that are longer than this part of its reciprocal: below it something else does, such as impacts.
const SLOWEST: f64 = 0.1;
