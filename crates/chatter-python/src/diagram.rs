//! Orbit diagrams.

use crate::arrays::columns as arrays;
use crate::asked::Asked;
use crate::errors::{raised, unreadable};
use crate::interruptible::{Listener, interruptible};
use crate::model::{Core, assignments};
use chatter::analysis::diagram::{Record, Share, Threads};
use chatter_work::Observer;
use chatter_work::Refusal;
use chatter_work::diagram::{
    Beginning, Begun, Columns, Order, Produced, Request, Work, columns, journal_of,
    merge as merged, produce, produce_in_memory, shard_journal, small_share,
};
use chatter_work::options::{
    AtOption, Count, ObserveOption, Quantity, SpanOption, StartOption, SweepOption, ThreadCount,
};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// A finished diagram.
struct Answer {
    order: Order,
    columns: Columns,
}

fn request(core: &Core, asked: &Asked) -> PyResult<Request> {
    let record = match asked.get::<String>("record")?.as_deref() {
        None => None,
        Some("samples") => Some(Record::Samples),
        Some("classes") => Some(Record::Classes),
        Some(_) => return Err(unreadable("record", "expected `samples` or `classes`")),
    };
    let observe: Vec<ObserveOption> = asked.texts("observe")?;
    let sweeps: Vec<SweepOption> = asked.texts("sweep")?;
    // A model keeps what was set into it; what is swept takes its place.
    let others = |pairs: &[(String, String)]| {
        let mut kept = assignments(pairs);
        kept.retain(|one| sweeps.iter().all(|sweep| sweep.name() != one.name));
        kept
    };
    Ok(Request {
        set: others(&core.set),
        initial: others(&core.initial),
        sweeps,
        section: asked.get("section")?,
        at: asked.texts::<AtOption>("at")?,
        period: asked.get("period")?,
        every: asked.text::<Count>("every")?,
        observe: observe.into_iter().map(|one| one.0).collect(),
        transient: asked.text("transient")?,
        keep: asked.text::<Count>("keep")?,
        start: asked.text::<StartOption>("start")?,
        chunk: asked.text::<Count>("chunk")?,
        bounds: asked.texts::<SpanOption>("box")?,
        seed: asked.text("seed")?,
        longest_period: asked.text::<Count>("longest_period")?,
        period_tolerance: asked.text::<Quantity>("period_tolerance")?,
        exponent: asked.get("exponent")?.unwrap_or(false),
        record,
        longest_return: asked.text::<Quantity>("longest_return")?,
        most_impacts: asked.text::<Count>("most_impacts")?,
        tolerance: asked.text::<Quantity>("tolerance")?,
        out: asked.table()?,
        plot: None,
        shear: None,
    })
}

fn threads(count: Option<&str>) -> PyResult<Threads> {
    match count {
        None => Ok(Threads::available()),
        Some(count) => match ThreadCount::from_str(count) {
            Ok(ThreadCount(count)) => Ok(Threads::new(count)),
            Err(error) => Err(unreadable("threads", error)),
        },
    }
}

/// Computes a diagram. `asked` has its options by name, as texts in the notation of the command line; `out` is the table to be
/// written, `journal` the file that keeps what is done.
#[pyfunction]
#[pyo3(signature = (core, asked, journal=None, shard=None, progress=None))]
pub fn diagram<'py>(
    py: Python<'py>,
    core: &Core,
    asked: &Bound<'py, PyDict>,
    journal: Option<PathBuf>,
    shard: Option<(u64, u64)>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Option<Bound<'py, PyDict>>> {
    let asked = Asked(asked);
    let threads = threads(asked.get::<String>("threads")?.as_deref())?;
    let request = request(core, &asked)?;
    let source = core.source();
    let shard = share(shard)?;
    let answer = interruptible(py, progress, move |listener| {
        let order = request.order(source)?;
        if let Some(share) = shard {
            return only(&order, share, threads, listener).map(|()| None);
        }
        let journal = journal.or_else(|| order.target().map(journal_of));
        let answer = match journal {
            Some(path) => kept(order, Beginning::At(path), threads, listener),
            None => in_memory(order, threads, listener),
        };
        answer.map(Some)
    })?;
    answer
        .map_err(raised)?
        .map(|answer| told(py, answer))
        .transpose()
}

/// A share, as (NUMBER, COUNT).
pub fn share(shard: Option<(u64, u64)>) -> PyResult<Option<Share>> {
    let read = |(number, of)| {
        Share::new(number, of)
            .ok_or_else(|| unreadable("shard", "expected (NUMBER, COUNT), NUMBER from 1 to COUNT"))
    };
    shard.map(read).transpose()
}

/// A share of a diagram, into its journal beside the table.
fn only(order: &Order, share: Share, threads: Threads, listener: &Listener) -> Result<(), Refusal> {
    let Some(out) = &order.out else {
        return Err(Refusal::input(
            "--shard needs --out, which its journal is named after",
        ));
    };
    let work = Work {
        share,
        beginning: Beginning::At(shard_journal(out, share)),
        threads,
    };
    let produced = produce(order, work, listener)?;
    if let Some(remark) = small_share(&produced.ready.sweep, share) {
        listener.remark(&remark);
    }
    match produced.complete {
        true => Ok(()),
        false => Err(Refusal::Interrupted),
    }
}

/// Puts the journals of shares together, computes what none of them has, and writes the table.
#[pyfunction]
#[pyo3(signature = (journals, out, threads_wanted=None, progress=None))]
pub fn merge<'py>(
    py: Python<'py>,
    journals: Vec<PathBuf>,
    out: PathBuf,
    threads_wanted: Option<String>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let threads = threads(threads_wanted.as_deref())?;
    let answer = interruptible(py, progress, move |listener| {
        let order = merged(&journals, (&out, None), listener)?;
        kept(order, Beginning::At(journal_of(&out)), threads, listener)
    })?;
    told(py, answer.map_err(raised)?)
}

/// Goes on with a diagram that was broken off: that of the table `path`, or that whose journal stands there. `None` where the
/// table is complete.
#[pyfunction]
#[pyo3(signature = (path, threads_wanted=None, progress=None))]
pub fn resume<'py>(
    py: Python<'py>,
    path: PathBuf,
    threads_wanted: Option<String>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Option<Bound<'py, PyDict>>> {
    let threads = threads(threads_wanted.as_deref())?;
    let answer = interruptible(py, progress, move |listener| {
        resumed(&path, threads, listener)
    })?;
    answer
        .map_err(raised)?
        .map(|answer| told(py, answer))
        .transpose()
}

fn resumed(path: &Path, threads: Threads, listener: &Listener) -> Result<Option<Answer>, Refusal> {
    if let Some(begun) = Begun::open(&journal_of(path))? {
        begun.of_this_version()?;
        let order = begun.header.clone().order(path, None, listener)?;
        return kept(
            order,
            Beginning::Resumed(Box::new(begun)),
            threads,
            listener,
        )
        .map(Some);
    }
    if chatter_files::Format::of_table(path).is_ok() && path.exists() {
        return Ok(None);
    }
    let Some(begun) = Begun::open(path)? else {
        return Err(Refusal::input(format!(
            "there is nothing to resume: neither `{}` nor `{}`",
            path.display(),
            journal_of(path).display()
        )));
    };
    begun.of_this_version()?;
    let header = begun.header.clone();
    let order = Order {
        job: header.job,
        model_text: header.model_text,
        out: None,
        plot: None,
        shear: None,
    };
    kept(
        order,
        Beginning::Resumed(Box::new(begun)),
        threads,
        listener,
    )
    .map(Some)
}

fn in_memory(order: Order, threads: Threads, listener: &Listener) -> Result<Answer, Refusal> {
    let (ready, rows, complete) = produce_in_memory(&order, threads, listener)?;
    if !complete {
        return Err(Refusal::Interrupted);
    }
    let columns = columns(&mut ready.source(&rows, complete))?;
    Ok(Answer { order, columns })
}

/// A diagram with a journal, which goes when the table is written, and stays where there is none.
fn kept(
    order: Order,
    beginning: Beginning,
    threads: Threads,
    listener: &Listener,
) -> Result<Answer, Refusal> {
    let mut produced = produce(&order, Work::whole(beginning, threads), listener)?;
    if !produced.complete {
        return Err(Refusal::Interrupted);
    }
    produced.write(&order, listener)?;
    let Produced { mut store, .. } = produced;
    let columns = columns(&mut store)?;
    if order.target().is_some() {
        store.remove()?;
    }
    Ok(Answer { order, columns })
}

fn told(py: Python<'_>, answer: Answer) -> PyResult<Bound<'_, PyDict>> {
    let job = &answer.order.job;
    let dict = PyDict::new(py);
    dict.set_item("orbits", arrays(py, answer.columns.orbits)?)?;
    dict.set_item("samples", arrays(py, answer.columns.samples)?)?;
    let specification =
        serde_json::to_string(job).map_err(|error| raised(Refusal::Output(error.to_string())))?;
    dict.set_item("specification", specification)?;
    dict.set_item("model", &answer.order.model_text)?;
    Ok(dict)
}
