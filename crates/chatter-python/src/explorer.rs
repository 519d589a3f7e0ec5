//! The explorer in a notebook: questions of its page are answered as by the server, without one.

use crate::model::Core;
use chatter::analysis::diagram::Threads;
use chatter_explorer::{Context, Kind, PAGE, Sink, answer};
use core::ops::ControlFlow;
use core::time::Duration;
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// Models nest deeply.
const STACK: usize = 64 << 20;
/// Records that go together in one message, and how long they wait for others.
const BLOCK: usize = 128 << 10;
const LONGEST_WAIT: Duration = Duration::from_millis(40);

/// A question that is being answered.
#[pyclass(frozen, module = "chatter._chatter")]
pub struct Question {
    stop: Arc<AtomicBool>,
}

#[pymethods]
impl Question {
    /// Ends the work.
    fn stop(&self) {
        self.stop.store(true, Ordering::Relaxed);
    }
}

/// The files of the page: names and texts.
#[pyfunction]
pub fn explorer_page() -> Vec<(&'static str, &'static str)> {
    PAGE.iter().map(|asset| (asset.path, asset.text)).collect()
}

/// Answers a question of the page on a thread of its own. `put` is called with bytes, of one record or several, until the
/// last one has come.
#[pyfunction]
pub fn explorer_answer(
    core: &Core,
    asked: String,
    body: Vec<u8>,
    put: Py<PyAny>,
) -> PyResult<Question> {
    let context = Context {
        model: (core.name.clone(), core.text.clone()),
        files: core.data_files.clone(),
        threads: Threads::available(),
    };
    let stop = Arc::new(AtomicBool::new(false));
    let theirs = Arc::clone(&stop);
    std::thread::Builder::new()
        .stack_size(STACK)
        .spawn(move || {
            let mut calls = Calls {
                put,
                bytes: Vec::new(),
                sent: Instant::now(),
            };
            answer(&asked, &body, &context, &mut calls, &theirs);
        })?;
    Ok(Question { stop })
}

/// Records that go to Python.
struct Calls {
    put: Py<PyAny>,
    bytes: Vec<u8>,
    sent: Instant,
}

impl Sink for Calls {
    fn put(&mut self, kind: Kind, content: &[u8]) -> ControlFlow<()> {
        self.bytes.extend_from_slice(&kind.head(content.len()));
        self.bytes.extend_from_slice(content);
        let waits =
            kind != Kind::End && self.bytes.len() < BLOCK && self.sent.elapsed() < LONGEST_WAIT;
        if waits {
            return ControlFlow::Continue(());
        }
        let bytes = core::mem::take(&mut self.bytes);
        self.sent = Instant::now();
        let taken =
            Python::attach(|py| self.put.call1(py, (PyBytes::new(py, &bytes),)).map(|_| ()));
        match taken {
            Ok(()) => ControlFlow::Continue(()),
            Err(_) => ControlFlow::Break(()),
        }
    }
}
