//! Branches as they are asked for, with a journal that keeps how far they have come.

use super::curves::find_curves;
use super::find::find_branches;
use super::job::{Job, Ready};
use super::log::{Begun, Log};
use super::several::{Shared, find_share};
use crate::journals::shard_journal;
use crate::observer::Observer;
use crate::refusal::Refusal;
use chatter::analysis::diagram::Share;
use chatter::analysis::periodic::{Branch, SpecialKind};
use std::path::{Path, PathBuf};

/// Where it is kept how far branches have come.
pub enum Beginning {
    /// Nowhere.
    Nowhere,
    /// In the journal of this name.
    At(PathBuf),
    /// In one that is there.
    Begun(Box<Begun>),
    /// In one that is open.
    Open(Log),
}

/// Branches, and the journal in which they are.
pub struct Produced {
    /// The branches; those that the observer stopped end there.
    pub branches: Vec<Branch>,
    /// Of curves in two parameters, of which kind of points each is.
    pub kinds: Vec<SpecialKind>,
    /// The functions that are watched.
    pub monitors: Vec<String>,
    /// Whether the observer let the work come to its end.
    pub complete: bool,
    log: Option<Log>,
}

/// Follows what is missing.
///
/// # Errors
/// There are no branches, or the journal is another's or cannot be written.
pub fn produce(
    job: &Job,
    ready: &Ready,
    beginning: Beginning,
    observer: &dyn Observer,
) -> Result<Produced, Refusal> {
    let mut log = match beginning {
        Beginning::Nowhere => None,
        Beginning::At(journal) => Some(Log::find(&journal, job, observer)?),
        Beginning::Begun(begun) => Some(begun.read(observer)?),
        Beginning::Open(log) => Some(log),
    };
    let found = match &job.plane {
        None => find_branches(&ready.model, &ready.wanted, log.as_mut(), observer).map(|found| {
            let monitors = ready.wanted.spec.monitors.clone();
            (found.branches, Vec::new(), monitors, found.complete)
        }),
        Some(plane) => find_curves(ready, plane, log.as_mut(), observer).map(|found| {
            let (kinds, branches) = found.curves.into_iter().unzip();
            (branches, kinds, found.monitors, found.complete)
        }),
    };
    match found {
        Ok((branches, kinds, monitors, complete)) => Ok(Produced {
            branches,
            kinds,
            monitors,
            complete,
            log,
        }),
        Err(refusal) => {
            // Nothing is kept of nothing.
            if let Some(log) = log.filter(Log::is_empty) {
                log.remove()?;
            }
            Err(refusal)
        }
    }
}

impl Produced {
    /// Whether a journal keeps them.
    pub fn is_kept(&self) -> bool {
        self.log.is_some()
    }

    /// Deletes the journal, where there is one: the branches are written.
    ///
    /// # Errors
    /// It cannot be deleted.
    pub fn forget_journal(self) -> Result<(), Refusal> {
        self.log.map_or(Ok(()), Log::remove)
    }
}

/// Follows a share of the orbits that a search finds, into a journal of its own beside `out`; and the path of that.
///
/// # Errors
/// What is asked makes no sense, or the journal is another's or cannot be written.
pub fn produce_share(
    job: &Job,
    (share, out): (Share, &Path),
    observer: &dyn Observer,
) -> Result<(Shared, PathBuf), Refusal> {
    let Ready { model, wanted, .. } = job.ready()?;
    let journal = shard_journal(out, share);
    let mut log = Log::find(&journal, job, observer)?;
    let shared = find_share(&model, &wanted, (share, &mut log), observer)?;
    Ok((shared, journal))
}
