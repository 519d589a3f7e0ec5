//! An orbit as a sequence of legs, read off a trajectory.

use super::corners::{Before, Shared, rank, sort};
use super::events::Events;
use super::joint::Joint;
use super::trace::Instant;
use crate::analysis::periodic::error::PeriodicError;
use crate::expressions::Side;
use crate::flow::leg::{Jump, LegKind, StretchKind, ends_piece, is_corner};
use crate::flow::{Closed, GuardKind, Occurrence, System, Trajectory};
use crate::numerics::stored::{list, number};
use serde::{Deserialize, Serialize};

/// The step so many after another one of a cycle of `count`, or before it.
pub(crate) const fn around(from: usize, by: isize, count: usize) -> usize {
    let count = count as isize;
    (from as isize + by).rem_euclid(count) as usize
}

/// A part of an orbit between two of its nodes.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Step {
    pub passage: Passage,
    /// The piece of each lookup in the mode that it ends in.
    pub pieces: Vec<i64>,
    /// What happens at its end; of a stretch, all that happens. Equations do without it.
    #[serde(skip)]
    pub told: Vec<Occurrence<f64>>,
    /// Contacts that are closed after it.
    pub closed: Closed,
    /// First guess.
    #[serde(with = "list")]
    pub start: Vec<f64>,
    #[serde(with = "number")]
    pub duration: f64,
}

/// How a part of an orbit is travelled.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) enum Passage {
    /// By the smooth flow of one mode, for a time that is an unknown, up to a surface.
    Leg(LegKind),
    /// The same for a time that is given: whole periods of the forcing.
    Timed(LegKind),
    /// As a leg, once around to the plane through where it is guessed to start, across the flow there: of an orbit on which nothing
    /// happens, not even a crossing of the section.
    Around(LegKind),
    /// In no time, at the instant of the event before: an impact of a contact that touches already, an event whose surface that one's jump has
    /// crossed.
    AtOnce(LegKind),
    /// As a leg, in a time that is zero for reasons of symmetry: an impact that happens to share the instant of the event before.
    Together(LegKind),
    /// By following the flow through whatever happens.
    Stretch(StretchKind),
}

impl Step {
    /// For whole periods of the forcing in the mode that a trajectory is in, nothing happening.
    pub(crate) fn timed(trajectory: &Trajectory<f64>, start: Vec<f64>, duration: f64) -> Self {
        Self {
            passage: Passage::Timed(LegKind {
                mode: trajectory.mode,
                ends_at: None,
                jump: Jump::None,
            }),
            pieces: trajectory.pieces().to_vec(),
            told: Vec::new(),
            closed: trajectory.closed(),
            start,
            duration,
        }
    }

    /// The contact of the impact at its end.
    pub(crate) fn impact(&self) -> Option<usize> {
        match self.passage {
            Passage::Leg(kind) | Passage::AtOnce(kind) | Passage::Together(kind) => {
                kind.jump.impact()
            }
            Passage::Timed(_) | Passage::Around(_) | Passage::Stretch(_) => None,
        }
    }

    /// How many impacts it has; none where infinitely many.
    pub(crate) fn impacts(&self) -> Option<u64> {
        match self.passage {
            Passage::Stretch(kind) => (kind.accumulations == 0).then_some(kind.impacts as u64),
            _ => Some(u64::from(self.impact().is_some())),
        }
    }

    /// The flight that it is, where its time is its own and nothing at its instant came before.
    pub(crate) fn flight(&self) -> Option<LegKind> {
        match self.passage {
            Passage::Leg(kind) | Passage::Around(kind) => Some(kind),
            _ => None,
        }
    }

    pub(crate) fn is_stretch(&self) -> bool {
        matches!(self.passage, Passage::Stretch(_))
    }

    /// Whether its event shares the instant of the one before.
    pub(crate) fn is_at_once(&self) -> bool {
        matches!(self.passage, Passage::AtOnce(_) | Passage::Together(_))
    }

    /// Whether its time is an unknown.
    pub(crate) fn has_own_time(&self) -> bool {
        matches!(
            self.passage,
            Passage::Leg(_) | Passage::Around(_) | Passage::Together(_)
        )
    }

    /// Lets a stretch begin in the middle of the collisions of an instant.
    fn begin_within(&mut self, system: &System, instant: &Instant, state: Vec<f64>) {
        if let Passage::Stretch(kind) = &mut self.passage {
            kind.closed = Closed::NONE;
            kind.on = instant.lies_on_beside(system, kind.closed);
            self.start = state;
        }
    }

    /// The guard that ends it; none where a time does.
    pub(crate) fn ends_at(&self) -> Option<GuardKind> {
        match self.passage {
            Passage::Leg(kind) | Passage::AtOnce(kind) | Passage::Together(kind) => kind.ends_at,
            Passage::Stretch(kind) => kind.last.ends_at,
            Passage::Timed(_) | Passage::Around(_) => None,
        }
    }

    /// Puts it, if it is followed in one mode, in another one.
    fn set_mode(&mut self, mode: usize) {
        match &mut self.passage {
            Passage::Leg(kind)
            | Passage::Timed(kind)
            | Passage::Around(kind)
            | Passage::AtOnce(kind)
            | Passage::Together(kind) => kind.mode = mode,
            Passage::Stretch(_) => {}
        }
    }

    /// The mode that it ends in.
    pub(crate) fn mode(&self) -> usize {
        match self.passage {
            Passage::Leg(kind)
            | Passage::Timed(kind)
            | Passage::Around(kind)
            | Passage::AtOnce(kind)
            | Passage::Together(kind) => kind.mode,
            Passage::Stretch(kind) => kind.last.mode,
        }
    }
}

/// Times that differ by less than this part of themselves, or of the period, are one.
const SAME_INSTANT: f64 = 8.0 * f64::EPSILON;

/// Contacts that are struck in this last part of a period before an end of chatter have chattered with the one that it is of.
const SAME_END: f64 = 1e-8;

/// What is followed as a whole.
#[derive(Clone, Copy)]
enum Way {
    /// So many ends of chatter, one after the other.
    Single(usize),
    /// Chatter of these contacts up to where they rest together.
    Joint(Closed),
}

impl Way {
    fn with(self, more: usize) -> Self {
        match self {
            Self::Single(count) => Self::Single(count + more),
            Self::Joint(contacts) => Self::Joint(contacts),
        }
    }
}

/// The steps from just after `instants[0]` to just after the last of them.
pub(crate) fn read(
    (system, parameters): (&System, &[f64]),
    instants: &[Instant],
) -> Result<Vec<Step>, PeriodicError> {
    let mut steps: Vec<Step> = Vec::new();
    let span = match instants {
        [first, .., last] => last.time - first.time,
        _ => 0.0,
    };
    let mut from = 0;
    // The instant that each step begins at.
    let mut begins: Vec<usize> = Vec::new();
    let mut open: Option<(usize, Way, Vec<Occurrence<f64>>)> = None;
    // What of the instant that it begins at is part of that.
    let mut within: Vec<Step> = Vec::new();
    // When several contacts chattered at once, and which, as long as they have not come to rest.
    let mut parted: Vec<(f64, Closed)> = Vec::new();
    for (index, instant) in instants.iter().enumerate().skip(1) {
        if instant.only_touches() {
            continue;
        }
        if instant.ends_chatter() {
            if let Some((joint, contacts)) = Joint::ending((system, instants), index, span) {
                let mut begin = open.take().map_or(from, |(begin, ..)| begin);
                while let Some(start) = begins.pop_if(|start| joint.has(instants, *start)) {
                    begin = begin.min(start);
                    steps.pop();
                    within.clear();
                }
                // What shares the instant that it begins at is part of it, but for what ends the way there.
                let is_own = |step: &mut Step| step.is_at_once() && joint.begins_before(begin);
                while let Some(step) = steps.pop_if(is_own) {
                    within.insert(0, step);
                }
                begins.truncate(steps.len());
                let told = instants[begin + 1..=index].iter();
                let told = told.flat_map(|instant| instant.told.iter());
                let told = within.iter().flat_map(|step| &step.told).chain(told);
                open = Some((begin, Way::Joint(contacts), told.copied().collect()));
                parted.retain(|(time, _)| *time < instants[begin].time);
                continue;
            }
            let before = struck(&instants[..index], instant.time - SAME_END * span);
            parted.extend(is_several(before).then_some((instant.time, before)));
        }
        let events = Events::of((system, parameters), instant, span);
        if let Some((begin, way, mut told)) = open.take() {
            let Some(events) = events.filter(|_| !instant.is_caused) else {
                told.extend(&instant.told);
                let more = usize::from(instant.accumulated().is_some());
                open = Some((begin, way.with(more), told));
                continue;
            };
            told.extend(events.told(instant));
            let way = (way, events.first, told);
            let mut whole = stretch(system, &instants[begin..=index], way);
            if let Some(first) = within.drain(..).next() {
                whole.begin_within(system, &instants[begin], first.start);
            }
            steps.extend(events.steps((system, parameters), (whole, instant)));
            begins.resize(steps.len(), begin);
            from = index;
            continue;
        }
        if let Some(mut events) = events {
            if let (Some(own), true) = (events.first.ends_at, events.is_corner()) {
                let ends = piece_at_once((system, parameters), (instants, index), own, span);
                events.first.ends_at = ends.or(Some(own));
            }
            let kind = events.first;
            let before = &instants[from];
            let duration = instant.time - before.time;
            let at_once = duration <= SAME_INSTANT * instant.time.abs().max(span);
            let is_alone = events.then.is_empty() && !instant.is_caused;
            let plain = |steps: &[Step]| match steps.last().map(|step| step.passage) {
                Some(Passage::Leg(kind) | Passage::Together(kind)) => kind.ends_at,
                _ => None,
            };
            let corners = (plain(&steps), kind.ends_at);
            let shared = match corners {
                (Some(own), Some(other)) if at_once && is_alone && kind.jump == Jump::None => {
                    let instants = (before, instant);
                    shared((system, parameters), instants, (own, other), span)
                }
                _ => Shared::No,
            };
            // Beside the orbit one of two corners may come first.
            let crosses = |guard: Option<GuardKind>| matches!(guard, Some(GuardKind::Switch(_)));
            let crosses_too = shared == Shared::Here && crosses(corners.0) && crosses(corners.1);
            if at_once
                && is_alone
                && !crosses_too
                && (kind.jump == Jump::None || gives_jump(&mut steps, kind.jump))
            {
                // Two names for one event, as where a surface is met and held: no motion lies between them.
                if let ((Some(own), Some(other)), Shared::Always) = (corners, shared)
                    && rank(other) < rank(own)
                    && let Some(Passage::Leg(known)) =
                        steps.last_mut().map(|step| &mut step.passage)
                {
                    known.ends_at = Some(other);
                }
                from = index;
                continue;
            }
            // Another impact within rounding of the time.
            let with_another = at_once
                && matches!((kind.jump.impact(), steps.last().and_then(Step::impact)),
                    (Some(contact), Some(before)) if contact != before);
            let leg = Step {
                passage: match (instant.is_caused, with_another || crosses_too) {
                    (true, _) => Passage::AtOnce(kind),
                    (false, true) => Passage::Together(kind),
                    (false, false) => Passage::Leg(kind),
                },
                pieces: instant.pieces.clone(),
                told: events.told(instant).to_vec(),
                closed: instant.closed,
                start: before.state.clone(),
                duration,
            };
            steps.extend(events.steps((system, parameters), (leg, instant)));
            begins.resize(steps.len(), from);
            from = index;
            continue;
        }
        // A chatter sequence begins with its first impact.
        let impacts = instant.accumulated().map_or(0, |(_, count)| count as usize);
        let accumulations = usize::from(instant.accumulated().is_some());
        let is_top = |step: usize| instants[begins.get(step + 1).copied().unwrap_or(from)].is_top;
        let first = first_of_chatter(&steps, is_top, impacts);
        let begin = begins.get(first).copied().unwrap_or(from);
        let told = steps.drain(first..).flat_map(|step| step.told);
        let told = told.chain(instant.told.iter().copied()).collect();
        begins.truncate(steps.len());
        open = Some((begin, Way::Single(accumulations), told));
    }
    if let Some(&(time, contacts)) = parted.first() {
        let names = contacts.contacts().map(|contact| {
            let name = &system.model().contacts[contact].name;
            format!("`{name}`")
        });
        let names = names.collect::<Vec<_>>().join(", ");
        return Err(PeriodicError::Unfollowed {
            what: format!(
                "chatter of {names} at once, after which they do not rest together (at time {time})"
            ),
        });
    }
    if let Some((_, way, told)) = open {
        let impacts = told
            .iter()
            .any(|told| matches!(told, Occurrence::Impact { .. }));
        let what = match way {
            Way::Single(0) if impacts => {
                "several impacts, or an impact and another event, at one instant"
            }
            Way::Single(0) => "several events at one instant",
            _ => "complete chatter without a single event after it",
        };
        return Err(PeriodicError::Unfollowed {
            what: what.to_owned(),
        });
    }
    sort(system, &mut steps);
    Ok(steps)
}

/// The first of the steps of a chatter sequence of so many impacts that ends after them: it begins with the first of these, and tops of its flights are
/// part of it.
fn first_of_chatter(steps: &[Step], is_top: impl Fn(usize) -> bool, impacts: usize) -> usize {
    let (mut first, mut flights) = (steps.len(), impacts.saturating_sub(1));
    for (index, step) in steps.iter().enumerate().rev() {
        if !is_top(index) {
            if flights == 0 || step.impact().is_none() || step.is_at_once() {
                break;
            }
            flights -= 1;
        }
        if index == 0 || !is_top(index - 1) {
            first = index;
        }
    }
    first
}

/// Puts each flight all through on the side of sliding that the impact at its end asks for, and on the same one if that asks for none, as where friction
/// stops the sliding: where it turns in flight nothing happens.
pub(in crate::analysis::periodic) fn keep_idle_sides(system: &System, steps: &mut [Step]) {
    let count = steps.len();
    for surface in system.rubbing().iter().map(|of| of.surface) {
        let rubs = |contact: usize| {
            let of = system.rubbing_at(contact);
            of.is_some_and(|of| of.surface == surface)
        };
        let mut asked = Side::Above;
        // Backwards, and around once more.
        for index in (0..2 * count).rev() {
            let step = &mut steps[index % count];
            let mode = step.mode();
            let origin = system
                .origin_of(mode)
                .filter(|_| !step.is_stretch() && system.rubs_nowhere(mode, surface));
            let Some((grip, sides, _)) = origin else {
                asked = Side::Above;
                continue;
            };
            if step.impact().is_some_and(rubs) {
                asked = match step.passage {
                    Passage::Leg(kind) if matches!(kind.jump, Jump::Stop(_)) => Side::Above,
                    _ => sides.get(surface),
                };
            }
            step.set_mode(system.meet(grip, sides.with(surface, asked)));
        }
    }
}

/// The end of a piece that always comes with a surface which is crossed at an instant, as of a ramp and a square wave of one clock: of the two it is the
/// one that the instant is known by.
fn piece_at_once(
    known: (&System, &[f64]),
    (instants, index): (&[Instant], usize),
    own: GuardKind,
    span: f64,
) -> Option<GuardKind> {
    let instant = &instants[index];
    // After the last instant they change as after the first, a turn before.
    let [before, after] = match instants.get(index + 1) {
        Some(next) => [&instant.pieces, &next.pieces],
        None => [&instants.first()?.pieces, &instants.get(1)?.pieces],
    };
    let changes = before.iter().zip(after).enumerate();
    let mut ends = changes.filter_map(|(lookup, (before, after))| match after - before {
        1 => Some(GuardKind::Piece(lookup, Side::Above)),
        -1 => Some(GuardKind::Piece(lookup, Side::Below)),
        _ => None,
    });
    let before = Before::new(known, (instant, instant), span);
    ends.find(|&end| rank(end) < rank(own) && before.shared(own, end) == Shared::Always)
}

/// How two surfaces that are crossed at one instant share it.
fn shared(
    known: (&System, &[f64]),
    instants: (&Instant, &Instant),
    (own, other): (GuardKind, GuardKind),
    span: f64,
) -> Shared {
    let crosses = |guard: GuardKind| matches!(guard, GuardKind::Switch(_) | GuardKind::Piece(..));
    if own == other || !crosses(own) || !crosses(other) {
        return Shared::No;
    }
    Before::new(known, instants, span).shared(own, other)
}

/// Lets the event before, which changes nothing by itself, make a jump; whether it can.
fn gives_jump(steps: &mut [Step], jump: Jump) -> bool {
    match steps.last_mut().map(|step| &mut step.passage) {
        Some(Passage::Leg(kind)) if kind.jump == Jump::None => {
            kind.jump = jump;
            // As where the jump comes before the corner that it comes with: which is first is rounding.
            match jump {
                Jump::Reset(section) => kind.ends_at = Some(GuardKind::Section(section)),
                Jump::Impact(contact) | Jump::Stop(contact) => {
                    kind.ends_at = Some(GuardKind::Gap(contact));
                }
                Jump::None => {}
            }
            true
        }
        _ => false,
    }
}

/// The contacts that are struck at the latest of these instants, from a time on.
pub(super) fn struck(instants: &[Instant], since: f64) -> Closed {
    let late = (instants.iter().rev()).take_while(|instant| instant.time >= since);
    let told = late.flat_map(|instant| &instant.told);
    told.fold(Closed::NONE, |all, told| match *told {
        Occurrence::Impact { contact, .. } => all.with(contact),
        _ => all,
    })
}

pub(super) fn is_several(contacts: Closed) -> bool {
    contacts.contacts().nth(1).is_some()
}

/// Whether a guard is met at an instant, by itself or with a corner that has ended the way to it.
fn comes(instant: &Instant, next: &Instant, guard: Option<GuardKind>) -> bool {
    let at_corner = instant.guard.as_ref().is_some_and(is_corner);
    let comes_too = match guard {
        Some(GuardKind::Switch(own)) => (instant.told.iter())
            .any(|told| matches!(told, Occurrence::Switch { surface, .. } if *surface == own)),
        Some(GuardKind::Piece(lookup, side)) => {
            ends_piece((&instant.pieces, &next.pieces), lookup, side)
        }
        _ => false,
    };
    instant.guard == guard || at_corner && comes_too
}

/// The instants are those from where it begins to where it ends.
fn stretch(
    system: &System,
    way: &[Instant],
    (whole, last, told): (Way, LegKind, Vec<Occurrence<f64>>),
) -> Step {
    let (begin, end) = (&way[0], &way[way.len() - 1]);
    let hits = |told: &&Occurrence<f64>| matches!(told, Occurrence::Impact { .. });
    let (accumulations, joint) = match whole {
        Way::Single(count) => (count, None),
        Way::Joint(contacts) => (1, Some(contacts)),
    };
    let impacts = match accumulations {
        0 => told.iter().filter(hits).count(),
        _ => 0,
    };
    // Of what belongs to chatter itself there is no fixed number.
    let is_of_chatter = match (last.ends_at, joint) {
        (Some(GuardKind::Gap(contact) | GuardKind::Reaction(contact)), Some(contacts)) => {
            contacts.contains(contact)
        }
        (Some(GuardKind::Gap(_)), None) => true,
        _ => false,
    };
    let own = last.ends_at;
    let passed = way
        .windows(2)
        .skip(1)
        .filter(|pair| comes(&pair[0], &pair[1], own));
    Step {
        passage: Passage::Stretch(StretchKind {
            closed: begin.closed,
            on: begin.lies_on(system),
            accumulations,
            impacts,
            last,
            passes: (!is_of_chatter).then(|| passed.count()),
            joint: joint.is_some(),
        }),
        pieces: end.pieces.clone(),
        told,
        closed: end.closed,
        start: begin.state.clone(),
        duration: end.time - begin.time,
    }
}

/// How many surfaces are slid along in a mode, and contacts closed.
pub(crate) fn held(system: &System, mode: usize) -> usize {
    let Some((grip, sides, _)) = system.origin_of(mode) else {
        return 0;
    };
    let slides = (0..system.corners().surfaces.len()).filter(|&k| sides.get(k) == Side::Sliding);
    2 * grip.carrying().contacts().count() + slides.count()
}
