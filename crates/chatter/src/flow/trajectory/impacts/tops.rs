//! Chatter whose flights cross a surface at their tops, where the gap rate turns round, as dry friction along the gap does.
//!
//! The free acceleration is a in the rise and b in the fall, both negative: a flight that begins with the rate w rises by
//! w^2 / (2 |a|) and ends with the rate w sqrt(b / a). So rates fall by r sqrt(b / a) from impact to impact, and time and state
//! converge with the powers of that ratio, at the point where the sequence ends.

use crate::flow::chatter::Turn;
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
    /// Modes of the rise after the latest impact, and of the fall before it.
    modes: Option<(usize, usize)>,
    /// Surfaces crossed at tops since the latest impact.
    crossed: u32,
    /// Something else was met since then.
    is_interrupted: bool,
    /// The latest two flights passed the same two modes.
    repeats: bool,
}

impl Tops {
    pub(in crate::flow::trajectory) const NONE: Self = Self {
        modes: None,
        crossed: 0,
        is_interrupted: false,
        repeats: false,
    };

    pub(in crate::flow::trajectory) fn interrupt(&mut self) {
        self.is_interrupted = true;
    }

    /// Modes of rise and fall of the sequence, where they differ.
    fn turn(self) -> Option<(usize, usize)> {
        self.modes.filter(|_| self.repeats)
    }

    /// The tapes of both accelerations, with the constants that a trajectory has for each mode.
    pub(super) fn tapes<'a, R: Real>(
        self,
        system: &'a System,
        (constants, known_at): (&'a [Option<ProgramConstants<R>>], &[u64]),
        contact: usize,
    ) -> Option<Turn<'a, R>> {
        let (rise, fall) = self.turn()?;
        if known_at.get(rise) != known_at.get(fall) {
            return None;
        }
        let of = |mode: usize| {
            let tapes = system.program(mode)?.sequences[contact].as_ref()?;
            let constants = &constants.get(mode)?.as_ref()?.sequences[contact];
            Some((&tapes.acceleration, &constants.acceleration[..]))
        };
        Some(Turn {
            rise: of(rise)?,
            fall: of(fall)?,
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
        Ok(is_top)
    }

    /// Whether nothing has happened since the latest impact but that a surface was crossed where the flight turned round.
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
        if !self.note_top(fall) {
            self.tracker.interrupt();
        }
        if let Some((ratio, longer)) = self.fall_by_rise(system, contact) {
            *at_rest *= ratio;
            self.flight_time *= longer;
        }
    }

    /// Whether the sequence goes on as before.
    fn note_top(&mut self, fall: usize) -> bool {
        let modes = Some((self.mode, fall));
        let tops = self.tops;
        let same = tops.modes == modes && self.is_past_top();
        self.tops = Tops {
            modes,
            crossed: 0,
            is_interrupted: false,
            repeats: same,
        };
        same
    }

    /// By how much the restitution of the sequence is changed by its tops, and how much longer its flights take than if their
    /// whole way were the rise: at the present state.
    fn fall_by_rise(&self, system: &System, contact: usize) -> Option<(R, R)> {
        let turn = (self.tops).tapes(system, (&self.constants, &self.known_at), contact)?;
        let start = (&self.state[..], &self.low[..]);
        let acceleration = |(tape, constants)| with_terms(tape, constants, start)[0].value;
        let (up, down) = (acceleration(turn.rise), acceleration(turn.fall));
        let ratio = (down / up).sqrt();
        let falls = up < R::ZERO && down < R::ZERO && ratio.is_finite();
        falls.then(|| (ratio, (R::ONE + R::ONE / ratio) * R::splat(0.5)))
    }
}
