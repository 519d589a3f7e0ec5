//! Branches from every orbit that a search finds. A piece of the work is what is followed from one orbit: pieces are independent, and what
//! two of them have in common is taken out when all are there, in their order.

use super::find::{Found, find_orbits, follow};
use super::log::{Known, Log};
use super::refused;
use super::wanted::{Branches, Orbits};
use crate::observer::Observer;
use crate::parallel::{each, lock};
use crate::refusal::Refusal;
use chatter::analysis::diagram::Share;
use chatter::analysis::periodic::{Branch, Distinct, End, PeriodicError, Record, Search, Start};
use chatter::model::Model;
use std::collections::BTreeSet;
use std::sync::Mutex;

/// The orbits, and what is followed from them.
struct Pieces<'a> {
    /// At the value where the orbits are.
    model: Model,
    wanted: &'a Branches,
    starts: Vec<Start>,
}

/// What is known of pieces.
struct Standing<'a> {
    log: Option<&'a mut Log>,
    /// How far those have come that were begun before.
    before: Known,
    found: Vec<Option<Vec<Branch>>>,
    done: BTreeSet<usize>,
    /// What tells orbits that lie on what was followed already.
    followed: Distinct,
}

/// What a share of the work came to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shared {
    /// Orbits of the share for which nothing is left to be done, …
    pub done: usize,
    /// … of so many in it, …
    pub orbits: usize,
    /// … of so many in all.
    pub all: usize,
}

impl<'a> Pieces<'a> {
    /// Looks for the orbits, unless they are known.
    fn new(
        model: &Model,
        (wanted, search): (&'a Branches, &Search),
        (known, log): (Option<Vec<Start>>, Option<&mut Log>),
        observer: &dyn Observer,
    ) -> Result<Self, Refusal> {
        let parameter = wanted.over.parameter;
        let (low, high) = wanted.over.limits.range;
        let mut model = model.clone();
        let own = model.parameter_values::<f64>(&[])[parameter];
        if !(low..=high).contains(&own) {
            let name = model.parameters[parameter].name.clone();
            model.set_parameter(&name, &format!("{:?}", 0.5 * (low + high)))?;
        }
        let starts = match known {
            Some(starts) => starts,
            None => {
                let orbits = Orbits {
                    spec: wanted.spec.clone(),
                    search: Some(*search),
                };
                let found = find_orbits(&model, &orbits, observer)?;
                let starts: Vec<Start> = found.iter().map(Start::from).collect();
                log.map_or(Ok(()), |log| log.starts(&starts))?;
                starts
            }
        };
        Ok(Self {
            model,
            wanted,
            starts,
        })
    }

    fn distinct(&self) -> Result<Distinct, Refusal> {
        let Branches { spec, over, .. } = self.wanted;
        Distinct::new(&self.model, spec, over).map_err(|error| refused(&error, &self.model))
    }

    fn standing<'b>(
        &self,
        before: Known,
        log: Option<&'b mut Log>,
    ) -> Result<Standing<'b>, Refusal> {
        Ok(Standing {
            log,
            done: before.done.clone(),
            before,
            found: vec![None; self.starts.len()],
            followed: self.distinct()?,
        })
    }

    /// What is followed from one orbit: nothing, where its equations cannot be solved over the parameter.
    fn follow(
        &self,
        piece: usize,
        standing: &Mutex<Standing<'_>>,
        observer: &dyn Observer,
    ) -> Result<Vec<Branch>, Refusal> {
        let over = &self.wanted.over;
        let (spec, before) = {
            let mut standing = lock(standing);
            let before = standing.before.parts.remove(&piece);
            let spec = standing.followed.spec(&self.starts[piece]);
            (spec, before.unwrap_or_default())
        };
        let mut keep = |record: &Record| lock(standing).keep(|log| log.part(piece, record));
        match follow(&self.model, (&spec, over), before, &mut keep, observer)? {
            Err(PeriodicError::Interrupted) => Err(Refusal::Interrupted),
            Err(_) => Ok(Vec::new()),
            Ok(found) => match found.iter().any(|b| b.ends.contains(&End::Interrupted)) {
                true => Err(Refusal::Interrupted),
                false => Ok(found),
            },
        }
    }

    /// Follows what is missing of a share; whether all of it is done.
    fn fill(
        &self,
        share: Share,
        shared: &Mutex<Standing<'_>>,
        observer: &dyn Observer,
    ) -> Result<bool, Refusal> {
        // What was done before tells of orbits on it.
        let again: Vec<usize> = {
            let standing = lock(shared);
            let is_followed = |piece: &usize| standing.before.parts.contains_key(piece);
            standing.done.iter().copied().filter(is_followed).collect()
        };
        for piece in again.into_iter().filter(|piece| *piece < self.starts.len()) {
            let found = self.follow(piece, shared, observer)?;
            lock(shared).take(piece, &self.starts[piece], found);
        }
        let missing: Vec<usize> = (share.pieces(self.starts.len() as u64))
            .map(|piece| piece as usize)
            .filter(|piece| !lock(shared).done.contains(piece))
            .collect();
        let filled = each(&missing, observer.stop(), |&piece| {
            let start = &self.starts[piece];
            let is_known = lock(shared).followed.knows(start).unwrap_or(true);
            let begun = lock(shared).before.parts.contains_key(&piece);
            if begun || !is_known {
                let found = self.follow(piece, shared, observer)?;
                lock(shared).take(piece, start, found);
            }
            let mut standing = lock(shared);
            standing.done.insert(piece);
            standing.keep(|log| log.done(piece))
        });
        match filled {
            Err(Refusal::Interrupted) => Ok(false),
            other => other.map(|_| true),
        }
    }

    /// The branches in the order of their orbits, each once; as far as the first that is missing, if not all are filled in.
    fn distinct_branches(
        &self,
        filled: bool,
        shared: &Mutex<Standing<'_>>,
        observer: &dyn Observer,
    ) -> Result<Found, Refusal> {
        let mut distinct = self.distinct()?;
        let mut branches = Vec::new();
        for (piece, start) in self.starts.iter().enumerate() {
            // What is no orbit over the parameter has no branch.
            if distinct.knows(start).unwrap_or(true) {
                continue;
            }
            let found = lock(shared).found[piece].take();
            let found = match found {
                Some(found) => Ok(found),
                None if filled => self.follow(piece, shared, observer),
                None => Err(Refusal::Interrupted),
            };
            let found = match found {
                Err(Refusal::Interrupted) => {
                    return Ok(Found {
                        branches,
                        complete: false,
                    });
                }
                other => other?,
            };
            let new = distinct.add(start, found);
            branches.extend(new.map_err(|error| refused(&error, &self.model))?);
        }
        Ok(Found {
            branches,
            complete: filled,
        })
    }
}

impl Standing<'_> {
    fn keep(&mut self, keep: impl FnOnce(&mut Log) -> Result<(), Refusal>) -> Result<(), Refusal> {
        self.log.as_mut().map_or(Ok(()), |log| keep(log))
    }

    fn take(&mut self, piece: usize, start: &Start, found: Vec<Branch>) {
        // Where it fails, orbits on these branches are followed, too, and taken out in the end.
        let _ = self.followed.add(start, found.clone());
        self.found[piece] = Some(found);
    }
}

/// All branches from the orbits that a search finds.
pub(super) fn from_several(
    model: &Model,
    (wanted, search): (&Branches, &Search),
    log: Option<&mut Log>,
    observer: &dyn Observer,
) -> Result<Found, Refusal> {
    let mut log = log;
    let mut before = log.as_mut().map(|log| log.before()).unwrap_or_default();
    let known = (before.starts.take(), log.as_deref_mut());
    let pieces = Pieces::new(model, (wanted, search), known, observer)?;
    if pieces.starts.is_empty() {
        return Err(Refusal::input("no periodic orbit was found to follow")
            .help("try more starts: --starts, or more periods: --all"));
    }
    let shared = Mutex::new(pieces.standing(before, log)?);
    let filled = pieces.fill(Share::WHOLE, &shared, observer)?;
    pieces.distinct_branches(filled, &shared, observer)
}

/// Follows what is missing of a share of the orbits that a search finds.
///
/// # Errors
/// What is asked makes no sense, or the log cannot be written.
pub fn find_share(
    model: &Model,
    wanted: &Branches,
    (share, log): (Share, &mut Log),
    observer: &dyn Observer,
) -> Result<Shared, Refusal> {
    let search = wanted.search.ok_or_else(|| {
        Refusal::input("--shard needs --all: what is followed from one orbit is one piece of work")
    })?;
    let mut before = log.before();
    let known = (before.starts.take(), Some(&mut *log));
    let pieces = Pieces::new(model, (wanted, &search), known, observer)?;
    let all = pieces.starts.len();
    let of_share: Vec<usize> = (share.pieces(all as u64))
        .map(|piece| piece as usize)
        .collect();
    let told = |done: &BTreeSet<usize>| Shared {
        done: of_share.iter().filter(|piece| done.contains(piece)).count(),
        orbits: of_share.len(),
        all,
    };
    let known = told(&before.done);
    if known.done == known.orbits {
        return Ok(known);
    }
    let shared = Mutex::new(pieces.standing(before, Some(log))?);
    pieces.fill(share, &shared, observer)?;
    let standing = lock(&shared);
    Ok(told(&standing.done))
}
