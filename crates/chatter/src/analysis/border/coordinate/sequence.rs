//! The impact sequence that follows a state, and how it ends.

use super::local::{Local, LocalTape};
use crate::flow::{FlowError, Occurrence, System, Trajectory, Workspace};
use crate::numerics::Real;
use serde::{Deserialize, Serialize};

/// A flight is local, one of a chatter sequence, if it starts with a < 0 and lasts at most this many nu / j. At the
/// border of the last local flight, a graze, it lasts 3/2 of it to leading order (eq. (3) with s = 0). Where j < 0 it
/// lasts at most 2 w / nu, and this many w / nu are allowed.
const LOCAL_FLIGHT: f64 = 3.0;

/// So many local flights one after the other are a chatter sequence.
const SEQUENCE: usize = 3;

/// Fewer impacts are no chatter sequence.
pub(crate) const SHORTEST: usize = SEQUENCE + 1;

/// No impact at the contact for so many steps: the trajectory does not come back.
const STEPS_WITHOUT_IMPACT: usize = 2_000;

/// More impacts than this are not followed: a sequence at restitution 0.99 has some two thousand.
const MOST_IMPACTS: usize = 5_000;

/// An impact counts as a graze if its rate is this small against the largest rate of the sequence: rates go
/// with the root of the distance, which is halved to rounding.
pub(crate) const GRAZE: f64 = 1e-4;

/// A horizon that no flight reaches.
pub(crate) const NO_HORIZON: f64 = 1e12;

/// How an impact sequence ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Verdict {
    /// Infinitely many impacts, then contact.
    Complete,
    /// After finitely many impacts close to each other, a long flight.
    Incomplete,
    /// Complete chatter, and contact until a release point other than the one where the sequence began.
    Elsewhere,
    /// No chatter sequence within what was followed.
    NoChatter,
    /// As many impacts as asked for were followed.
    Stopped,
}

/// One impact of a sequence.
#[derive(Clone, Debug)]
pub(crate) struct Impact<R> {
    pub time: R,
    /// State after it, columns included.
    pub state: Vec<R>,
    pub rate_before: R,
    pub local: Local<R>,
    /// Whether the flight before it was a long one.
    pub arrives: bool,
}

/// The impacts from a state on.
#[derive(Clone, Debug)]
pub(crate) struct Sequence<R> {
    pub impacts: Vec<Impact<R>>,
    pub verdict: Verdict,
    /// Number of the first impact after which flights are local up to the end.
    pub begins: usize,
    /// Where the contact that complete chatter ends in is released: with a verdict, if it is.
    pub released: Option<Vec<R>>,
}

/// A compiled system and the local coordinates of its contacts.
#[derive(Clone, Debug)]
pub(crate) struct Follower {
    pub system: System,
    pub locals: Vec<LocalTape>,
}

/// Where to stop: whatever comes first, complete chatter at the latest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Until {
    /// After so many impacts.
    pub impacts: usize,
    /// After so many long flights, at the impact that ends the last of them; where no long flight follows.
    pub arrivals: usize,
    /// Where more long flights than these come before chatter.
    pub excursions: usize,
    /// At the end of the first chatter sequence that ends after so many impacts.
    pub after: usize,
}

impl Until {
    /// Nowhere.
    pub(crate) const NEVER: Self = Self {
        impacts: usize::MAX,
        arrivals: usize::MAX,
        excursions: usize::MAX,
        after: usize::MAX,
    };

    /// Impacts that are followed at most: counted anew for each sequence, or only if there may be so many.
    fn is_too_long<R>(self, sequence: &Sequence<R>) -> bool {
        let before = match self.arrivals {
            usize::MAX => 0,
            _ => sequence.begins,
        };
        let is_counted = self.impacts < usize::MAX && self.after == usize::MAX;
        !is_counted && sequence.impacts.len() - before >= MOST_IMPACTS
    }
}

impl Follower {
    /// Follows the impacts at a contact from a state, columns included. Whatever happens at other contacts away from chatter
    /// at this one is a part of the way.
    pub(crate) fn follow<R: Real>(
        &self,
        parameters: &[R],
        (contact, start): (usize, &[R]),
        until: Until,
    ) -> Result<Sequence<R>, FlowError> {
        let system = &self.system;
        let local_tape = &self.locals[contact];
        let mut scratch = local_tape.scratch(parameters);
        let (mut work, mut trajectory) = system.trajectory_from(parameters, start)?;
        let mut sequence = Sequence {
            impacts: Vec::new(),
            verdict: Verdict::NoChatter,
            begins: 0,
            released: None,
        };
        // Until when the present flight is local.
        let mut limit: Option<R> = None;
        let mut quiet = 0;
        let mut excursions = 0;
        while quiet < STEPS_WITHOUT_IMPACT && !until.is_too_long(&sequence) {
            quiet += 1;
            match trajectory.advance(system, &mut work, R::splat(NO_HORIZON))? {
                Some(Occurrence::Impact {
                    contact: touched,
                    rate_before,
                    ..
                }) => {
                    if touched != contact {
                        // A flight that another contact cuts is none of a chatter sequence.
                        limit = None;
                        continue;
                    }
                    quiet = 0;
                    let arrives = limit.is_none_or(|limit| trajectory.time() > limit);
                    if arrives && sequence.is_chatter(until.after) {
                        sequence.verdict = Verdict::Incomplete;
                        return Ok(sequence);
                    }
                    let (state, low) = (trajectory.state(), &trajectory.low);
                    let local = local_tape.at(&mut scratch, state, low);
                    if arrives {
                        if excursions == until.excursions {
                            return Ok(sequence);
                        }
                        sequence.begins = sequence.impacts.len();
                        excursions += 1;
                    }
                    limit = local_flight(&local).map(|length| trajectory.time() + length);
                    sequence.impacts.push(Impact {
                        time: trajectory.time(),
                        state: trajectory.state().to_vec(),
                        rate_before,
                        local,
                        arrives,
                    });
                    if sequence.impacts.len() == until.impacts || excursions == until.arrivals {
                        sequence.verdict = Verdict::Stopped;
                        return Ok(sequence);
                    }
                }
                Some(
                    Occurrence::Accumulation {
                        contact: closes, ..
                    }
                    | Occurrence::Capture { contact: closes },
                ) if closes == contact => {
                    sequence.verdict = Verdict::Complete;
                    // Where a verdict is asked for.
                    if until.impacts == usize::MAX && until.arrivals == usize::MAX {
                        sequence.released =
                            until_release(system, &mut work, &mut trajectory, contact);
                    }
                    return Ok(sequence);
                }
                Some(Occurrence::Horizon) => break,
                _ => {}
            }
        }
        if sequence.is_chatter(until.after) && !until.is_too_long(&sequence) {
            sequence.verdict = Verdict::Incomplete;
        }
        Ok(sequence)
    }
}

/// Goes on until a contact is released, and says where.
pub(crate) fn until_release<R: Real>(
    system: &System,
    work: &mut Workspace<R>,
    trajectory: &mut Trajectory<R>,
    contact: usize,
) -> Option<Vec<R>> {
    for _ in 0..STEPS_WITHOUT_IMPACT {
        let next = trajectory.advance(system, work, R::splat(NO_HORIZON));
        match next.ok()? {
            Some(Occurrence::Release { contact: opened }) if opened == contact => {
                return Some(trajectory.state().to_vec());
            }
            Some(Occurrence::Horizon) => return None,
            _ => {}
        }
    }
    None
}

impl<R: Real> Sequence<R> {
    /// Whether the latest impacts follow each other closely, the last of them later than impact number `after`.
    fn is_chatter(&self, after: usize) -> bool {
        self.impacts.len() > after.max(self.begins + SEQUENCE)
    }

    /// The largest rate before an impact.
    pub(crate) fn largest_rate(&self) -> f64 {
        let rates = self.impacts.iter().map(|impact| impact.rate_before);
        rates.fold(0.0_f64, |most, rate| most.max(rate.abs().to_f64()))
    }

    /// The rate of the first impact if it is a graze: then the normal form of a border has no finite slope.
    pub(crate) fn grazing_start(&self) -> Option<f64> {
        let rate = self.impacts.first()?.rate_before.to_f64();
        (rate.abs() <= GRAZE * self.largest_rate()).then_some(rate)
    }

    /// How many long flights there are.
    pub(crate) fn arrivals(&self) -> usize {
        self.impacts.iter().filter(|impact| impact.arrives).count()
    }
}

/// How long a flight may last to be a local one; `None` where it cannot be one.
fn local_flight<R: Real>(local: &Local<R>) -> Option<R> {
    if local.acceleration >= R::ZERO {
        return None;
    }
    let scale = if local.jerk > R::ZERO {
        local.nu() / local.jerk
    } else {
        local.rate / local.nu()
    };
    Some(scale * R::splat(LOCAL_FLIGHT))
}
