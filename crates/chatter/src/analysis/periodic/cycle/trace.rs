//! A trajectory as the instants at which something happens, with the modes between them.

use crate::analysis::periodic::error::PeriodicError;
use crate::flow::{Closed, GuardKind, Occurrence, System, Trajectory, Workspace};
use core::ops::ControlFlow;

/// Something that happened, in the time of one instant.
#[derive(Clone, Debug)]
pub(crate) struct Instant {
    pub time: f64,
    /// The mode and the pieces of lookups before it, and the guard that ended it; no guard where it is the end of a
    /// chatter sequence.
    pub mode: usize,
    pub pieces: Vec<i64>,
    pub guard: Option<GuardKind>,
    pub told: Vec<Occurrence<f64>>,
    /// The mode and the pieces that each of what is told came in.
    pub came_in: Vec<(usize, Vec<i64>)>,
    /// After it.
    pub state: Vec<f64>,
    pub closed: Closed,
    pub mode_after: usize,
    /// Whether the maps of all its impacts are those of that mode and these pieces.
    pub in_one_mode: bool,
    /// Whether it is an event that the jump of the instant before has brought about, at the same time.
    pub is_caused: bool,
    /// The section that is crossed at the instant of another event.
    pub with_section: Option<usize>,
    /// Whether a surface is crossed where a flight between impacts turns round.
    pub is_top: bool,
}

impl Instant {
    /// The impact, if this is just one.
    pub(crate) fn impact(&self) -> Option<(usize, f64)> {
        self.told.iter().find_map(|told| match *told {
            Occurrence::Impact {
                contact,
                rate_before,
                ..
            } => Some((contact, rate_before)),
            _ => None,
        })
    }

    /// Contacts that the state lies on after impacts and that are open: those that were struck, and those that were held and are thrown off.
    pub(crate) fn lies_on(&self, system: &System) -> Closed {
        self.lies_on_beside(system, self.closed)
    }

    /// The same while these are closed, be it between its impacts.
    pub(super) fn lies_on_beside(&self, system: &System, closed: Closed) -> Closed {
        let impacts = self.told.iter().filter_map(|told| match *told {
            Occurrence::Impact { contact, .. } => Some(contact),
            _ => None,
        });
        let struck = impacts.fold(Closed::NONE, |all, contact| all.with(contact));
        open_beside(system, (self.mode, struck), closed)
    }

    /// Whether a flight touches a contact here and goes on.
    pub(crate) fn only_touches(&self) -> bool {
        let touches = |told: &Occurrence<f64>| matches!(told, Occurrence::Graze { .. });
        !self.told.is_empty() && self.told.iter().all(touches)
    }

    /// Whether a section is crossed here, be it with another event.
    pub(crate) fn crosses(&self, section: usize) -> bool {
        self.is_at(section) || self.with_section == Some(section)
    }

    /// Whether this is a crossing of a section.
    fn is_at(&self, section: usize) -> bool {
        self.guard == Some(GuardKind::Section(section))
    }

    /// Whether nothing happens here but that a section is crossed.
    pub(super) fn only_crosses(&self, section: usize) -> bool {
        let crosses = |told: &Occurrence<f64>| matches!(told, Occurrence::Section { .. });
        self.is_at(section) && self.mode_after == self.mode && self.told.iter().all(crosses)
    }

    /// Whether an event ends the step that leads here, beside the crossing of a section.
    fn happens_beside(&self, section: usize) -> bool {
        self.guard.is_some() && !self.only_crosses(section)
    }

    pub(crate) fn is_release(&self) -> bool {
        (self.told.iter()).any(|told| matches!(told, Occurrence::Release { .. }))
    }

    /// Whether chatter ends here, of one contact or of several at once.
    pub(crate) fn ends_chatter(&self) -> bool {
        (self.told.iter()).any(|told| match *told {
            Occurrence::Accumulation { .. } => true,
            Occurrence::Cascade { contact, .. } => self.closed.contains(contact),
            _ => false,
        })
    }

    /// The contact at which a chatter sequence ends here, and how many impacts of it were told of before.
    pub(crate) fn accumulated(&self) -> Option<(usize, u64)> {
        self.told.iter().find_map(|told| match *told {
            Occurrence::Accumulation {
                contact, impacts, ..
            } => Some((contact, impacts)),
            _ => None,
        })
    }
}

/// Contacts that the state lies on after impacts at some, and that are open then: of those that are held in the mode before, all that
/// the impacts leave where they are.
pub(crate) fn open_beside(
    system: &System,
    (mode, struck): (usize, Closed),
    closed_after: Closed,
) -> Closed {
    let mut all = struck;
    let moves = |contact: usize| system.model().contacts[contact].reset.is_some();
    if struck != Closed::NONE
        && !struck.contacts().any(moves)
        && let Some((grip, ..)) = system.origin_of(mode)
    {
        all = Closed(all.0 | grip.closed.0);
    }
    Closed(all.0 & !closed_after.0)
}

/// What happened last is of the past once this part of the time has gone by since.
pub(super) const PAST: f64 = 0.5;

/// Forgets what happened before a motion left all that it met on its way, but for the section: crossings tell its returns.
pub(super) fn forget_past(
    instants: &mut Vec<Instant>,
    section: Option<usize>,
    (start, now): (f64, f64),
) {
    let Some(section) = section else { return };
    let Some(latest) = (instants.iter()).rposition(|instant| instant.happens_beside(section))
    else {
        return;
    };
    if now - instants[latest].time > PAST * (now - start) {
        instants.drain(..=latest);
    }
}

/// Leaves crossings of the section out where anything else happens. They change nothing; and where one shares its instant with an event, which of
/// them comes first, if they are told apart at all, is rounding, and differs from turn to turn.
pub(super) fn leave_out_crossings(instants: &mut Vec<Instant>, section: Option<usize>) {
    let Some(section) = section else { return };
    if (instants.iter()).any(|instant| instant.happens_beside(section)) {
        instants.retain(|instant| !instant.only_crosses(section));
    }
}

/// A trajectory that is being followed.
pub(crate) struct Tracer<'s> {
    system: &'s System,
    work: Workspace<f64>,
    pub trajectory: Trajectory<f64>,
    /// Crossings of this section count, too.
    section: Option<usize>,
    /// Steps taken, and how many there may be by now.
    steps: (usize, usize),
}

/// Whether a motion goes on is looked at for so many units of its time.
const STEPS_MORE: f64 = 16.0;

/// Steps without an event.
const MOST_STEPS: usize = 200_000;
/// So many more may be taken after each event, and in each period of a forcing: what grows without bound asks for ever more.
const STEPS_AN_EVENT: usize = 10_000;

impl<'s> Tracer<'s> {
    pub(crate) fn new(
        system: &'s System,
        parameters: &[f64],
        state: &[f64],
        section: Option<usize>,
    ) -> Result<Self, PeriodicError> {
        let (work, trajectory) =
            (system.trajectory_from(parameters, state)).map_err(PeriodicError::Start)?;
        Ok(Self {
            system,
            work,
            trajectory,
            section,
            steps: (0, MOST_STEPS),
        })
    }

    /// Where it begins, in this state: an instant at which nothing happens.
    pub(crate) fn start(&self, state: &[f64]) -> Instant {
        Instant {
            time: self.trajectory.time(),
            mode: self.trajectory.mode,
            pieces: self.trajectory.pieces().to_vec(),
            guard: None,
            told: Vec::new(),
            came_in: Vec::new(),
            state: state.to_vec(),
            closed: Closed::NONE,
            mode_after: self.trajectory.mode,
            in_one_mode: true,
            is_caused: false,
            with_section: None,
            is_top: false,
        }
    }

    /// Whether some of the states change on a few steps more, by such a part of the size of all.
    pub(crate) fn moves(
        &mut self,
        (part, some): (f64, &[bool]),
        observer: &mut dyn FnMut(f64) -> ControlFlow<()>,
    ) -> Result<bool, PeriodicError> {
        let before = self.trajectory.state().to_vec();
        let until = self.trajectory.time() + STEPS_MORE * self.trajectory.pace();
        self.follow((until, usize::MAX / 2), &mut Vec::new(), observer)?;
        let size = crate::numerics::dot(&before, &before).sqrt();
        let moved = self.trajectory.state().iter().zip(&before).zip(some);
        let mut by = moved.map(|((x, y), &counts)| if counts { (x - y).abs() } else { 0.0 });
        Ok(by.any(|by| by > part * size))
    }

    /// Follows up to a time, or until so many instants are known, and adds them to the list. The observer may break off.
    pub(crate) fn follow(
        &mut self,
        (until, most): (f64, usize),
        instants: &mut Vec<Instant>,
        observer: &mut dyn FnMut(f64) -> ControlFlow<()>,
    ) -> Result<(), PeriodicError> {
        self.trajectory.set_horizon(until);
        let mut steps = 0;
        let enough = instants.len() + most;
        self.steps.1 += STEPS_AN_EVENT;
        loop {
            let (mode, pieces) = (self.trajectory.mode, self.trajectory.pieces().to_vec());
            let told = (self.trajectory)
                .advance_to_horizon(self.system, &mut self.work)
                .map_err(PeriodicError::Ended)?;
            // The map of an event may depend on what only it asks for.
            let asked_in = self.trajectory.asked_in();
            let asked_in = asked_in.map(|(mode, pieces)| (mode, pieces.to_vec()));
            let (mode, pieces) = asked_in.clone().unwrap_or((mode, pieces));
            steps += 1;
            if steps % 64 == 0 && observer(self.trajectory.time()).is_break() {
                return Err(PeriodicError::Interrupted);
            }
            if steps > MOST_STEPS {
                return Ok(());
            }
            self.steps.0 += 1;
            if self.steps.0 > self.steps.1 {
                return Err(PeriodicError::EverShorterSteps {
                    time: self.trajectory.time(),
                    steps: self.steps.0,
                });
            }
            let guard = self.trajectory.ended_by();
            // Sliding that turns in flight is nothing that happens.
            let is_idle = guard.is_some_and(|guard| self.system.is_idle(mode, guard));
            let counts = |guard: Option<GuardKind>| match guard {
                Some(GuardKind::Section(index)) => {
                    self.section == Some(index) || self.system.is_event(index)
                }
                other => other.is_some() && !is_idle,
            };
            // A flight that touches and is ended by nothing belongs to no event before it.
            let happens = !is_idle
                && !matches!(
                    told,
                    None | Some(
                        Occurrence::Horizon | Occurrence::Section { .. } | Occurrence::Graze { .. }
                    )
                );
            let time = self.trajectory.time();
            let section = self.section.filter(|&index| !self.system.is_event(index));
            let looks = section.map(GuardKind::Section);
            let is_here = |last: &&mut Instant| last.time == time;
            let before = instants.last_mut().filter(is_here);
            if looks.is_some() && guard == looks {
                steps = 0;
                self.steps.1 += STEPS_AN_EVENT;
            }
            // A section that is crossed with an event is no event of its own.
            if looks.is_some()
                && guard == looks
                && let Some(event) = before
            {
                if event.guard != looks {
                    event.with_section = section;
                }
            } else if counts(guard) || matches!(told, Some(Occurrence::Accumulation { .. })) {
                let is_section = |last: &mut Instant| {
                    last.time == time && looks.is_some() && last.guard == looks
                };
                let with_section = match instants.pop_if(is_section) {
                    Some(_) => section,
                    // The latest event of an instant stands for it.
                    None => {
                        let before = instants.last_mut().filter(|last| last.time == time);
                        before.and_then(|before| before.with_section.take())
                    }
                };
                let told_here: Vec<_> = told
                    .into_iter()
                    .filter(|t| *t != Occurrence::Horizon)
                    .collect();
                instants.push(Instant {
                    time: self.trajectory.time(),
                    mode,
                    came_in: vec![(mode, pieces.clone()); told_here.len()],
                    pieces,
                    guard,
                    told: told_here,
                    state: Vec::new(),
                    closed: Closed::NONE,
                    mode_after: 0,
                    in_one_mode: true,
                    is_caused: matches!(told, Some(Occurrence::Reset { .. }))
                        && self.trajectory.came_by_jump(),
                    with_section,
                    is_top: self.trajectory.is_past_top(),
                });
                steps = 0;
                self.steps.1 += STEPS_AN_EVENT;
            } else if happens && let (Some(last), Some(told)) = (instants.last_mut(), told) {
                last.in_one_mode &=
                    asked_in.is_none() || (mode, &pieces) == (last.mode, &last.pieces);
                last.told.push(told);
                last.came_in.push((mode, pieces));
            }
            if let Some(last) = instants.last_mut()
                && last.time == self.trajectory.time()
            {
                last.state = self.trajectory.state().to_vec();
                last.closed = self.trajectory.closed();
                last.mode_after = self.trajectory.mode;
            }
            if told == Some(Occurrence::Horizon) {
                return Ok(());
            }
            if instants.len() > enough {
                // The latest may have more to tell.
                instants.truncate(enough + 1);
                return Ok(());
            }
        }
    }
}
