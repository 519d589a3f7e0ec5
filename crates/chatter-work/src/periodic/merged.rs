//! One journal of branches from those of shares.

use super::job::Job;
use super::log::{Begun, Known, Log};
use crate::journals::{journal_of, parts};
use crate::observer::Observer;
use crate::refusal::Refusal;
use std::path::{Path, PathBuf};

/// Puts what these journals know into that of the branches which are to be written to `out`.
///
/// # Errors
/// A journal is of other branches, cannot be read, or is in use.
pub fn merge(
    journals: &[PathBuf],
    out: &Path,
    observer: &dyn Observer,
) -> Result<(Job, Log), Refusal> {
    let own = journal_of(out);
    let parts = parts(journals, &own, Begun::open)?;
    let job = parts[0].job.clone();
    for part in &parts {
        if part.job != job {
            return Err(Refusal::input(format!(
                "`{}` is a part of other branches than `{}`: it has {}",
                part.path().display(),
                parts[0].path().display(),
                job.difference(&part.job)
            )));
        }
    }
    let mut log = Log::find(&own, &job, observer)?;
    let known: Result<Vec<Known>, Refusal> = (parts.into_iter())
        .map(|part| Ok(part.read(observer)?.before()))
        .collect();
    let mut known = known?;
    let starts = known
        .iter_mut()
        .filter_map(|known| known.starts.take())
        .next();
    if let Some(starts) = starts {
        if log.known().starts.is_none() {
            log.starts(&starts)?;
        }
        for piece in 0..starts.len() {
            let how_far = |known: &&Known| (known.done.contains(&piece), known.parts[&piece].len());
            let furthest = (known.iter())
                .filter(|known| known.parts.contains_key(&piece))
                .max_by_key(how_far);
            let Some(furthest) = furthest.filter(|_| !log.known().parts.contains_key(&piece))
            else {
                continue;
            };
            for record in &furthest.parts[&piece] {
                log.part(piece, record)?;
            }
            if furthest.done.contains(&piece) {
                log.done(piece)?;
            }
        }
    }
    drop(log);
    let log = Log::find(&own, &job, observer)?;
    Ok((job, log))
}
