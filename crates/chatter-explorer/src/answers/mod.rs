//! Questions and their answers, one file each.

mod border;
mod branches;
mod check;
mod curve;
mod diagram;
mod file;
mod history;
mod returns;
mod universal;

use crate::question::{self, ModelQuestion};
use crate::record::{Kind, Sink};
use crate::refused;
use chatter::analysis::diagram::Threads;
use chatter_work::data_files::DataFiles;
use chatter_work::{Observer, Refusal};
use core::ops::ControlFlow;
use core::sync::atomic::{AtomicBool, Ordering};
use core::time::Duration;
use file::Extension;
use serde::{Deserialize, Serialize};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// Between two reports of progress.
const BETWEEN_REPORTS: Duration = Duration::from_millis(150);

/// What questions are answered with.
#[derive(Clone, Debug)]
pub struct Context {
    /// The model that the page begins with: its name and text.
    pub model: (String, String),
    /// The files that tables of that model stand in. No others are read.
    pub files: DataFiles,
    /// Who computes.
    pub threads: Threads,
}

/// What can be asked.
#[derive(Clone, Copy)]
enum Topic {
    /// What there is to start from.
    Start,
    /// What a model is, and what is wrong with it.
    Check,
    /// Orbits over one or two parameters.
    Diagram,
    /// One motion.
    History,
    /// The curve of its return map.
    Returns,
    /// Periodic orbits over a parameter.
    Branches,
    /// Special points in two parameters.
    Curve,
    /// Border orbits over a parameter.
    Border,
    /// The universal map near one of them.
    Universal,
}

const TOPICS: [(&str, Topic); 9] = [
    ("start", Topic::Start),
    ("check", Topic::Check),
    ("diagram", Topic::Diagram),
    ("history", Topic::History),
    ("returns", Topic::Returns),
    ("branches", Topic::Branches),
    ("curve", Topic::Curve),
    ("border", Topic::Border),
    ("universal", Topic::Universal),
];

/// A topic, and the file that is wanted of it: `diagram.svg`.
fn topic(asked: &str) -> Option<(Topic, Option<Extension>)> {
    let (name, extension) = match asked.split_once('.') {
        Some((name, extension)) => (name, Some(Extension::of(extension)?)),
        None => (asked, None),
    };
    let mut known = TOPICS.iter().filter(|(known, _)| *known == name);
    let (_, topic) = known.next()?;
    let has_files = !matches!(topic, Topic::Start | Topic::Check);
    (extension.is_none() || has_files).then_some((*topic, extension))
}

/// Whether this can be asked.
pub fn is_known(asked: &str) -> bool {
    topic(asked).is_some()
}

/// Answers a question: `asked` is its name, `body` the rest of it as JSON. The answer ends with a record of kind
/// [`Kind::End`], after one of kind [`Kind::Refusal`] if there is none. It ends early once `stop` is set.
pub fn answer(asked: &str, body: &[u8], context: &Context, sink: &mut dyn Sink, stop: &AtomicBool) {
    let answering = Answering {
        context,
        sink: Mutex::new(sink),
        told: Mutex::new(Instant::now()),
        stop,
    };
    // A fault of ours must not end the connection without a word.
    let outcome = catch_unwind(AssertUnwindSafe(|| answering.answer(asked, body)));
    let refusal = match outcome {
        Ok(Ok(())) => None,
        Ok(Err(refusal)) => Some(refusal),
        Err(_) => Some(Refusal::Output(
            "the computation broke down; this is a fault of chatter".to_owned(),
        )),
    };
    if let Some(refusal) = refusal {
        let about = serde_json::from_slice::<About>(body).unwrap_or_default();
        let (name, text) = about
            .model
            .map_or_else(Default::default, |model| (model.name, model.text));
        let document = refused::document(&refusal, &name, &text);
        drop(answering.document_of(Kind::Refusal, &document));
    }
    let _ = answering.put(Kind::End, &[]);
}

/// The model that any question is about.
#[derive(Default, Deserialize)]
struct About {
    model: Option<ModelQuestion>,
}

/// A question while it is answered.
struct Answering<'a> {
    context: &'a Context,
    sink: Mutex<&'a mut dyn Sink>,
    /// When progress was told last.
    told: Mutex<Instant>,
    stop: &'a AtomicBool,
}

impl Answering<'_> {
    fn answer(&self, asked: &str, body: &[u8]) -> Result<(), Refusal> {
        match topic(asked) {
            Some((Topic::Start, _)) => check::start(self),
            Some((Topic::Check, _)) => check::answer(self, &question::read(body)?),
            Some((Topic::Diagram, None)) => diagram::answer(self, &question::read(body)?),
            Some((Topic::History, None)) => history::answer(self, &question::read(body)?),
            Some((Topic::Returns, None)) => returns::answer(self, &question::read(body)?),
            Some((Topic::Branches, None)) => branches::answer(self, &question::read(body)?),
            Some((Topic::Curve, None)) => curve::answer(self, &question::read(body)?),
            Some((Topic::Border, None)) => border::answer(self, &question::read(body)?),
            Some((Topic::Universal, None)) => universal::answer(self, &question::read(body)?),
            Some((Topic::Diagram, Some(kind))) => diagram::file(self, &question::read(body)?, kind),
            Some((Topic::History, Some(kind))) => history::file(self, &question::read(body)?, kind),
            Some((Topic::Returns, Some(kind))) => returns::file(self, &question::read(body)?, kind),
            Some((Topic::Branches, Some(kind))) => {
                branches::file(self, &question::read(body)?, kind)
            }
            Some((Topic::Curve, Some(kind))) => curve::file(self, &question::read(body)?, kind),
            Some((Topic::Border, Some(kind))) => border::file(self, &question::read(body)?, kind),
            Some((Topic::Universal, Some(kind))) => {
                universal::file(self, &question::read(body)?, kind)
            }
            None => Err(Refusal::input(format!("there is no question `{asked}`"))),
        }
    }

    fn put(&self, kind: Kind, content: &[u8]) -> ControlFlow<()> {
        let mut sink = self.sink.lock().unwrap_or_else(PoisonError::into_inner);
        let taken = sink.put(kind, content);
        if taken.is_break() {
            self.stop.store(true, Ordering::Relaxed);
        }
        taken
    }

    /// Hands a record over.
    fn say(&self, kind: Kind, content: &[u8]) -> Result<(), Refusal> {
        match self.put(kind, content) {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(Refusal::Interrupted),
        }
    }

    fn document(&self, document: &impl Serialize) -> Result<(), Refusal> {
        self.document_of(Kind::Document, document)
    }

    fn document_of(&self, kind: Kind, document: &impl Serialize) -> Result<(), Refusal> {
        let text = serde_json::to_string(document);
        self.say(
            kind,
            text.map_err(|error| Refusal::Output(error.to_string()))?
                .as_bytes(),
        )
    }

    fn numbers(&self, kind: Kind, numbers: &[f64]) -> Result<(), Refusal> {
        let bytes: Vec<u8> = numbers
            .iter()
            .flat_map(|number| number.to_le_bytes())
            .collect();
        self.say(kind, &bytes)
    }

    /// A file: the length of its name, its name, its content.
    fn file(&self, name: &str, content: &[u8]) -> Result<(), Refusal> {
        let length = (name.len() as u32).to_le_bytes();
        self.say(Kind::File, &[&length, name.as_bytes(), content].concat())
    }
}

impl Observer for Answering<'_> {
    fn progress(&self, done: f64, message: &dyn Fn() -> String) {
        let _ = done;
        let mut told = self.told.lock().unwrap_or_else(PoisonError::into_inner);
        if told.elapsed() < BETWEEN_REPORTS {
            return;
        }
        *told = Instant::now();
        let _ = self.put(Kind::Progress, message().as_bytes());
    }

    fn remark(&self, text: &str) {
        let _ = self.put(Kind::Remark, text.as_bytes());
    }

    fn stop(&self) -> &AtomicBool {
        self.stop
    }
}
