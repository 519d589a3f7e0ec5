//! Work beside the interpreter: on a thread of its own, while Python's looks for Ctrl-C and shows progress.

use chatter_work::Observer;
use pyo3::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// How often signals are looked for: below what a person notices.
const BETWEEN_LOOKS: Duration = Duration::from_millis(50);

/// Between two reports of progress.
const BETWEEN_REPORTS: Duration = Duration::from_millis(100);

/// How long an interrupted computation may take to put away what it has done. One that cannot be stopped, which holds no
/// file, goes on unheard after that until it is through.
const LONGEST_STOP: Duration = Duration::from_secs(5);

/// The small threads of the computation hold hundreds of trajectories at once.
const STACK: usize = 64 << 20;

/// What the computation has said.
#[derive(Default)]
struct Said {
    progress: Option<(f64, String)>,
    reported: Option<Instant>,
    remarks: Vec<String>,
}

/// Keeps what is said until Python looks.
#[derive(Default)]
pub struct Listener {
    stop: AtomicBool,
    wanted: bool,
    said: Mutex<Said>,
}

impl Observer for Listener {
    fn progress(&self, done: f64, message: &dyn Fn() -> String) {
        if !self.wanted {
            return;
        }
        let mut said = self.said.lock().unwrap_or_else(PoisonError::into_inner);
        if said
            .reported
            .is_none_or(|at| at.elapsed() >= BETWEEN_REPORTS)
        {
            said.progress = Some((done, message()));
            said.reported = Some(Instant::now());
        }
    }

    fn remark(&self, text: &str) {
        let mut said = self.said.lock().unwrap_or_else(PoisonError::into_inner);
        said.remarks.push(text.to_owned());
    }

    fn stop(&self) -> &AtomicBool {
        &self.stop
    }
}

/// Does the work while other Python threads run. `progress`, where there is one, is called with the part that is done and a
/// message; remarks become warnings.
///
/// # Errors
/// Ctrl-C, or what `progress` raises: the work has been told to stop then.
pub fn interruptible<T: Send + 'static>(
    py: Python<'_>,
    progress: Option<Py<PyAny>>,
    work: impl FnOnce(&Listener) -> T + Send + 'static,
) -> PyResult<T> {
    let listener = Arc::new(Listener {
        wanted: progress.is_some(),
        ..Listener::default()
    });
    let (end, ended) = channel();
    let theirs = Arc::clone(&listener);
    std::thread::Builder::new()
        .stack_size(STACK)
        .spawn(move || {
            // Nobody waits for it any more where it could not be stopped.
            let _ = end.send(work(&theirs));
        })?;
    py.detach(move || {
        loop {
            let result = ended.recv_timeout(BETWEEN_LOOKS);
            if let Err(error) = look(&listener, progress.as_ref()) {
                listener.stop.store(true, Ordering::Relaxed);
                drop(ended.recv_timeout(LONGEST_STOP));
                return Err(error);
            }
            match result {
                Ok(result) => return Ok(result),
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => {
                    return Err(pyo3::exceptions::PyRuntimeError::new_err(
                        "the computation broke down; this is a fault of chatter",
                    ));
                }
            }
        }
    })
}

/// Tells Python what was said, and lets it raise.
fn look(listener: &Listener, progress: Option<&Py<PyAny>>) -> PyResult<()> {
    let (said, remarks) = {
        let mut said = listener.said.lock().unwrap_or_else(PoisonError::into_inner);
        (said.progress.take(), core::mem::take(&mut said.remarks))
    };
    Python::attach(|py| {
        py.check_signals()?;
        for remark in remarks {
            py.import("chatter._errors")?
                .call_method1("warn", (remark,))?;
        }
        if let (Some(progress), Some((done, message))) = (progress, said) {
            progress.call1(py, (done, message))?;
        }
        Ok(())
    })
}
