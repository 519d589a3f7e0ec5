//! Chatter whose flights cross a surface at their tops, where the gap rate turns round, as dry friction along the gap does, or come to rest on
//! one that each impact leads off, as what is struck slips under friction and is held again before it is struck next.
//!
//! The free acceleration is a before that and b after it, both negative: a flight that begins with the rate w ends with the rate
//! w sqrt(b / a) if that is its top, and with a multiple of w, too, where the slip takes a time in proportion to the impulse. So rates fall
//! by a fixed ratio from impact to impact, and time and state converge with its powers, at the point where the sequence ends.

use crate::expressions::{Side, Tape};
use crate::flow::chatter::{Flight, Turn};
use crate::flow::error::FlowError;
use crate::flow::modes::closed::Closed;
use crate::flow::modes::limits::Corner;
use crate::flow::modes::program::ProgramConstants;
use crate::flow::system::System;
use crate::flow::touch::with_terms;
use crate::flow::trajectory::Trajectory;
use crate::numerics::Real;

/// A gap rate is that of a top if it is this small against the rate that the flight began with.
const TOP: f64 = 1e-6;

/// What the flights of a sequence did so far.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::flow::trajectory) struct Tops {
    /// The contact, and modes of the rise after its latest impact and of the fall before it.
    modes: Option<(usize, usize, usize)>,
    /// Surfaces crossed at tops, or held on, since the latest impact.
    crossed: u32,
    /// The surface that the latest of these holds the motion on.
    held: Option<usize>,
    /// Something else was met since then.
    is_interrupted: bool,
    /// The latest two flights passed the same two modes.
    repeats: bool,
}

impl Tops {
    pub(in crate::flow::trajectory) const NONE: Self = Self {
        modes: None,
        crossed: 0,
        held: None,
        is_interrupted: false,
        repeats: false,
    };

    pub(in crate::flow::trajectory) fn interrupt(&mut self) {
        self.is_interrupted = true;
    }

    /// Modes of rise and fall of a contact's sequence, where they differ.
    fn turn(self, contact: usize) -> Option<(usize, usize)> {
        let (of, rise, fall) = self.modes.filter(|_| self.repeats)?;
        (of == contact).then_some((rise, fall))
    }

    /// The surface that flights of a contact's sequence are held on: where that ends it is met.
    pub(super) fn held(self, contact: usize) -> Option<Corner> {
        self.turn(contact).and(self.held).map(Corner::Surface)
    }

    /// The tapes of rise and fall, with the constants that a trajectory has for each mode.
    pub(super) fn tapes<'a, R: Real>(
        self,
        system: &'a System,
        (constants, known_at): (&'a [Option<ProgramConstants<R>>], &[u64]),
        contact: usize,
    ) -> Option<Turn<'a, R>> {
        let (rise, fall) = self.turn(contact)?;
        if known_at.get(rise) != known_at.get(fall) {
            return None;
        }
        let of = |mode: usize| {
            let tapes = system.program(mode)?.sequences[contact].as_ref()?;
            Some((tapes, &constants.get(mode)?.as_ref()?.sequences[contact]))
        };
        let ((rises, rising), (falls, falling)) = (of(rise)?, of(fall)?);
        Some(Turn {
            rise: (&rises.acceleration, &rising.acceleration),
            fall: (&falls.acceleration, &falling.acceleration),
            held: self.held.map(|_| (&falls.held, &falling.held[..])),
        })
    }
}

impl<R: Real> Trajectory<R> {
    /// Whether the corner that is crossed is one at the top of a flight between impacts.
    pub(in crate::flow::trajectory) fn is_top(
        &mut self,
        system: &System,
        corner: Corner,
    ) -> Result<bool, FlowError> {
        let (Corner::Surface(_), Some((contact, before))) = (corner, self.latest_impact) else {
            return Ok(false);
        };
        if self.sequence == 0 || self.closed != Closed::NONE {
            return Ok(false);
        }
        let [_, rate] = self.local_up_to(system, contact)?;
        let is_top = rate.value.abs() <= before.abs() * R::splat(TOP);
        self.tops.crossed += u32::from(is_top);
        if is_top {
            self.tops.held = None;
        }
        Ok(is_top)
    }

    /// Whether a flight between impacts is held from now on, in its mode, on the surface that it has just come to.
    pub(in crate::flow::trajectory) fn is_held_in_flight(
        &mut self,
        system: &System,
        corner: Corner,
    ) -> bool {
        let (Corner::Surface(surface), Some((contact, _))) = (corner, self.latest_impact) else {
            return false;
        };
        let origin = system.origin_of(self.mode);
        let slides = origin.is_some_and(|(_, sides, _)| sides.get(surface) == Side::Sliding);
        let sequences = system.program(self.mode).map(|program| &program.sequences);
        let tapes = sequences.and_then(|all| all[contact].as_ref());
        let is_known = tapes.is_some_and(|tapes| !tapes.held.outputs.is_empty());
        let is_held = slides && is_known && self.sequence > 0 && self.closed == Closed::NONE;
        if is_held {
            self.tops.crossed += 1;
            self.tops.held = Some(surface);
        }
        is_held
    }

    /// Whether nothing has happened since the latest impact but that a surface was crossed where the flight turned round, or has come to hold it.
    pub(crate) fn is_past_top(&self) -> bool {
        self.tops.crossed == 1 && !self.tops.is_interrupted
    }

    /// Takes note of an impact after a fall in this mode, which has predicted the next flight and may have taken the state across corners: in a
    /// sequence with tops that is another flight, and so is the restitution of what is left of it.
    pub(in crate::flow::trajectory) fn follow_tops(
        &mut self,
        system: &System,
        (contact, fall, crosses): (usize, usize, bool),
        at_rest: &mut R,
    ) {
        if !crosses {
            self.tops = Tops::NONE;
            return;
        }
        if !self.note_top(contact, fall) {
            self.tracker.interrupt();
        }
        if let Some(flight) = self.flight_of_tops(system, contact, *at_rest) {
            *at_rest *= flight.ratio;
            self.flight_time *= flight.longer;
        }
    }

    /// Whether the sequence goes on as before.
    fn note_top(&mut self, contact: usize, fall: usize) -> bool {
        let modes = Some((contact, self.mode, fall));
        let tops = self.tops;
        let same = tops.modes == modes && self.is_past_top();
        self.tops = Tops {
            modes,
            crossed: 0,
            held: tops.held,
            is_interrupted: false,
            repeats: same,
        };
        same
    }

    /// The flights of the sequence, at the present state.
    fn flight_of_tops(&self, system: &System, contact: usize, restitution: R) -> Option<Flight<R>> {
        let turn = (self.tops).tapes(system, (&self.constants, &self.known_at), contact)?;
        let start = (&self.state[..], &self.low[..]);
        let mut values = |(tape, constants): (&Tape, &[R])| {
            let all = with_terms(tape, constants, start);
            all.iter().map(|term| term.value).collect()
        };
        turn.flight((restitution, &[]), &mut values)
    }
}
