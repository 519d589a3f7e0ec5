//! Branches of periodic orbits, as documents, with what keeps them: journals, tables, shares.

use crate::asked::Asked;
use crate::diagram::share;
use crate::errors::{raised, unreadable};
use crate::interruptible::{Listener, interruptible};
use crate::model::Core;
use crate::periodic::written;
use chatter_work::Refusal;
use chatter_work::journals::{is_of_branches, journal_of};
use chatter_work::numbers::Digits;
use chatter_work::periodic::{
    Beginning, Begun, Job, Shared, Sought, Subject, branch_document, holds_branches,
    merge as merged, produce, produce_share, write,
};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use std::path::{Path, PathBuf};

/// Branches: the job, and the document.
type Told = (String, String);

/// What is to be followed, and the table to be written.
fn job(core: &Core, asked: &Asked) -> PyResult<(Job, Option<PathBuf>)> {
    let search = asked.get::<u64>("all")?.map(|periods| -> PyResult<Sought> {
        Ok(Sought {
            periods,
            starts: asked.get("starts")?,
            seed: asked.get("seed")?,
        })
    });
    let search = search.transpose()?;
    if search.is_none() {
        for name in ["starts", "seed"] {
            if asked.get::<u64>(name)?.is_some() {
                return Err(unreadable(
                    name,
                    "it is about the search of --all, and there is none",
                ));
            }
        }
    }
    let range = asked.get("range")?;
    let job = Job {
        version: env!("CARGO_PKG_VERSION").to_owned(),
        model: core.name.clone(),
        model_text: core.text.clone(),
        data_files: core.data_files.clone(),
        set: core.set.clone(),
        initial: core.initial.clone(),
        search,
        period: asked.get("period")?,
        section: asked.get("section")?,
        monitors: asked.get("monitors")?.unwrap_or_default(),
        parameter: asked.get("parameter")?.unwrap_or_default(),
        range: range.unwrap_or_default(),
        impacts: asked.get("impacts")?,
        points: asked.get("points")?,
        step: asked.get("step")?,
        doublings: asked.get("doublings")?.unwrap_or(0),
        branch_points: asked.get("branch_points")?.unwrap_or(0),
        plane: None,
    };
    Ok((job, asked.table()?))
}

/// The branches of periodic orbits over a range of a parameter. `asked` has options by name, expressions as texts; `through` is an
/// orbit at the model's value of the parameter: all its states in order where it starts, and its period; `out` among them is the
/// table to be written, `journal` the file that keeps how far branches have come; with `shard` a share alone is followed.
#[pyfunction]
#[pyo3(signature = (core, asked, journal=None, shard=None, through=None, progress=None))]
pub fn branches(
    py: Python<'_>,
    core: &Core,
    asked: &Bound<'_, PyDict>,
    journal: Option<PathBuf>,
    shard: Option<(u64, u64)>,
    through: Option<(Vec<f64>, f64)>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Option<Told>> {
    let (job, out) = job(core, &Asked(asked))?;
    let shard = share(shard)?;
    let told = interruptible(py, progress, move |listener| match (shard, &out) {
        (Some(share), Some(out)) => {
            let (Shared { done, orbits, .. }, _) = produce_share(&job, (share, out), listener)?;
            match done < orbits {
                true => Err(Refusal::Interrupted),
                false => Ok(None),
            }
        }
        (Some(_), None) => Err(Refusal::input(
            "--shard needs --out, which its journal is named after",
        )),
        (None, _) => {
            let journal = journal.or_else(|| out.as_deref().map(journal_of));
            let beginning = journal.map_or(Beginning::Nowhere, Beginning::At);
            followed(&job, (beginning, through), out.as_deref(), listener).map(Some)
        }
    })?;
    told.map_err(raised)
}

/// Puts the journals of shares together, follows what none of them has, and writes the table.
#[pyfunction]
#[pyo3(signature = (journals, out, progress=None))]
pub fn merge_branches(
    py: Python<'_>,
    journals: Vec<PathBuf>,
    out: PathBuf,
    progress: Option<Py<PyAny>>,
) -> PyResult<Told> {
    let told = interruptible(py, progress, move |listener| {
        let (job, log) = merged(&journals, &out, listener)?;
        followed(&job, (Beginning::Open(log), None), Some(&out), listener)
    })?;
    told.map_err(raised)
}

/// Goes on with branches that were broken off: those of the table `path`, or those whose journal stands there.
#[pyfunction]
#[pyo3(signature = (path, progress=None))]
pub fn resume_branches(
    py: Python<'_>,
    path: PathBuf,
    progress: Option<Py<PyAny>>,
) -> PyResult<Told> {
    let told = interruptible(py, progress, move |listener| {
        let (begun, out) = match Begun::open(&journal_of(&path))? {
            Some(begun) => (Some(begun), Some(&*path)),
            None => (Begun::open(&path)?, None),
        };
        let begun = begun.ok_or_else(|| {
            Refusal::input(format!(
                "there is nothing to resume: neither `{}` nor `{}`",
                path.display(),
                journal_of(&path).display()
            ))
        })?;
        let job = begun.job.clone();
        let beginning = Beginning::Begun(Box::new(begun));
        followed(&job, (beginning, None), out, listener)
    })?;
    told.map_err(raised)
}

/// Whether the first of these files that is a journal is one of branches, or, with no journal among them, the first that is there a
/// table of branches.
#[pyfunction]
pub fn of_branches(py: Python<'_>, paths: Vec<PathBuf>) -> bool {
    py.detach(|| {
        is_of_branches(&paths)
            || paths
                .iter()
                .any(|path| holds_branches(path).unwrap_or(false))
    })
}

/// Follows what is missing. Without a table its journal stays.
fn followed(
    job: &Job,
    (beginning, through): (Beginning, Option<(Vec<f64>, f64)>),
    out: Option<&Path>,
    listener: &Listener,
) -> Result<Told, Refusal> {
    let mut ready = job.ready()?;
    ready.wanted.spec.through = through;
    let produced = produce(job, &ready, beginning, listener)?;
    if !produced.complete {
        return Err(Refusal::Interrupted);
    }
    let subject = Subject {
        model: &ready.model,
        source: &job.model,
        text: &job.model_text,
        monitors: &ready.wanted.spec.monitors,
        free: vec![ready.wanted.over.parameter],
        digits: Digits::DOUBLE,
    };
    let document = written(&branch_document(&subject, &produced.branches))?;
    if let Some(out) = out {
        write(&subject, &job.set, &produced.branches, out)?;
        produced.forget_journal()?;
    }
    Ok((written(job)?, document))
}
