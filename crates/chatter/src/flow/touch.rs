//! All contacts of a system at one state, as numbers: what simultaneous impacts and joint rest are decided by.

use super::modes::looked_up::LookedUp;
use super::variation::Direction;
use crate::expressions::{Expansion, Expr, Graph, Negligible, Node, Operand, Symbol, Tape};
use crate::model::Mechanics;
use crate::numerics::dispatch::{Kernel, dispatch_narrow};
use crate::numerics::{Real, WithTerms};

/// Gap, rate, acceleration and restitution of every contact, how impulses couple them, the directions in which states are
/// moved onto them, and what a collision at each does to the state: all of free flight.
#[derive(Clone, Debug)]
pub(crate) struct Touches {
    values: Tape,
    /// Per contact: the state after a collision there, columns of derivatives by the derivative of the map alone, without
    /// the shift of its time.
    collisions: Vec<Tape>,
    /// The derivatives of each gap, then of its rate, along each column, contact by contact.
    slopes: Tape,
    /// What the impulse of each contact does to the field.
    drifts: Tape,
    /// Per contact with friction: what an impact there does along it.
    slidings: Vec<Option<Tape>>,
    graph: Graph,
    contacts: usize,
    coordinates: usize,
    /// No impulse changes a restitution or what another impulse does.
    is_linear: bool,
    /// Constants of the tapes that change at knots.
    looked_up: LookedUp,
}

/// The constants of these tapes at one parameter set.
#[derive(Clone, Debug)]
pub(crate) struct TouchConstants<R> {
    values: Vec<R>,
    collisions: Vec<Vec<R>>,
    slopes: Vec<R>,
    drifts: Vec<R>,
    slidings: Vec<Vec<R>>,
}

impl<R> TouchConstants<R> {
    fn of_tapes<'a>(
        &'a mut self,
        touches: &'a Touches,
    ) -> impl Iterator<Item = &'a mut Vec<R>> + 'a {
        let slidings = self.slidings.iter_mut().zip(&touches.slidings);
        [&mut self.values, &mut self.slopes, &mut self.drifts]
            .into_iter()
            .chain(&mut self.collisions)
            .chain(
                slidings
                    .filter(|(_, tape)| tape.is_some())
                    .map(|(own, _)| own),
            )
    }
}

/// Values of [`Touches`], each with its terms.
#[derive(Clone, Debug)]
pub(crate) struct Touch<R> {
    /// h, one a contact.
    pub gap: Vec<WithTerms<R>>,
    /// v.
    pub rate: Vec<WithTerms<R>>,
    /// a.
    pub acceleration: Vec<WithTerms<R>>,
    /// r.
    pub restitution: Vec<WithTerms<R>>,
    /// Row i, column j: what an impulse at contact j that changes its own rate by one does to the rate of contact i.
    pub coupling: Vec<Vec<R>>,
    /// What friction leaves of what the impulse of a contact does to its gap rate: negative where a contact that slides jams.
    pub room: Vec<WithTerms<R>>,
    /// One row a contact: what that impulse does to the state.
    pub jump: Vec<Vec<R>>,
    /// One row a contact: the gradient of its gap, zero for time.
    pub gradient: Vec<Vec<R>>,
}

/// Outputs a contact before the rows.
const SCALARS: usize = 5;

/// Outputs along friction before the change of the state.
const SLIDING_SCALARS: usize = 5;

/// Friction at an impact, on the sides where the state is.
#[derive(Clone, Debug)]
pub(crate) struct Sliding<R> {
    /// v_t.
    pub rate: R,
    /// By how much the gap rate rises with a tangential impulse.
    pub lift: R,
    /// By how much the rate of sliding rises with one that leaves the gap rate as it is.
    pub change: R,
    /// By how much the gap rate rises with the normal impulse and the friction that it brings about here.
    pub rise: R,
    pub coefficient: R,
    /// What a tangential impulse that stops the sliding and leaves the gap rate as it is adds to the state, and to columns at the
    /// event's point.
    pub stop: Vec<R>,
}

impl Touches {
    pub(crate) fn new(
        mechanics: &Mechanics,
        directions: &[Direction],
        (time, first_slot): (Option<usize>, usize),
    ) -> Self {
        let mut mechanics = mechanics.clone();
        let contacts = mechanics.contacts.clone();
        let coordinates = mechanics.field.len();
        let mut outputs: Vec<Expr> = Vec::new();
        for (index, contact) in contacts.iter().enumerate() {
            let room = mechanics.room(index);
            outputs.extend([
                contact.gap,
                contact.rate,
                contact.acceleration,
                contact.restitution,
                room,
            ]);
        }
        for i in 0..contacts.len() {
            for j in 0..contacts.len() {
                outputs.push(mechanics.rate_per_jump(i, j));
            }
        }
        let graph = &mut mechanics.graph;
        let zero = graph.number(0.0);
        let jumps = || contacts.iter().map(|contact| &contact.jump);
        let is_moved = |i: usize| jumps().any(|jump| jump[i] != zero);
        let constant: Vec<Expr> = (contacts.iter().map(|contact| contact.restitution))
            .chain(outputs[SCALARS * contacts.len()..].iter().copied())
            .chain(jumps().flatten().copied())
            .collect();
        let is_linear = !(graph.reachable(&constant).into_iter())
            .any(|expr| matches!(graph.node(expr), &Node::Symbol(Symbol::State(i)) if is_moved(i)));
        for contact in &contacts {
            outputs.extend(&contact.jump);
        }
        for contact in &contacts {
            outputs.extend((0..coordinates).map(|i| {
                if Some(i) == time {
                    zero
                } else {
                    graph.derivative(contact.gap, Symbol::State(i))
                }
            }));
        }
        let values = Tape::new(graph, coordinates, &[], &outputs);
        let dimension = coordinates * (1 + directions.len());
        let collisions = (contacts.iter())
            .map(|contact| {
                let mut after = contact.after_impact.clone();
                for direction in directions {
                    after.extend(direction.along(graph, coordinates, &contact.after_impact));
                }
                Tape::new(graph, dimension, &[], &after)
            })
            .collect();
        let mut slopes = Vec::new();
        for contact in &contacts {
            for function in [contact.gap, contact.rate] {
                for direction in directions {
                    slopes.extend(direction.along(graph, coordinates, &[function]));
                }
            }
        }
        let slopes = Tape::new(graph, dimension, &[], &slopes);
        let mut drifts = Vec::new();
        for contact in contacts.iter().filter(|_| !directions.is_empty()) {
            let drift = |&rate: &Expr| graph.lie_derivative(rate, &contact.jump);
            drifts.extend(mechanics.field.iter().map(drift));
        }
        let drifts = Tape::new(graph, coordinates, &[], &drifts);
        let slidings = (0..contacts.len())
            .map(|contact| sliding(&mut mechanics, contact, (coordinates, directions)))
            .collect();
        let mut touches = Self {
            values,
            collisions,
            slopes,
            drifts,
            slidings,
            graph: mechanics.graph,
            contacts: contacts.len(),
            coordinates,
            is_linear,
            looked_up: LookedUp::default(),
        };
        touches.looked_up = LookedUp::new(&touches.graph, touches.tapes(), first_slot);
        touches
    }

    /// All of them, in the order of [`TouchConstants::of_tapes`].
    fn tapes(&self) -> impl Iterator<Item = &Tape> {
        [&self.values, &self.slopes, &self.drifts]
            .into_iter()
            .chain(&self.collisions)
            .chain(self.slidings.iter().flatten())
    }

    /// Computes the constants that change at knots anew.
    pub(crate) fn renew<R: Real>(&self, parameters: &[R], constants: &mut TouchConstants<R>) {
        let parts = constants.of_tapes(self);
        self.looked_up.renew(&self.graph, parameters, parts);
    }

    /// Whether impulses change rates by amounts that stay the same all through the collisions of an instant.
    pub(crate) fn is_linear(&self) -> bool {
        self.is_linear
    }

    /// The constants of all tapes at one parameter set.
    pub(crate) fn constants<R: Real>(&self, parameters: &[R]) -> TouchConstants<R> {
        let of = |tape: &Tape| tape.constants(&self.graph, parameters);
        TouchConstants {
            values: of(&self.values),
            collisions: self.collisions.iter().map(of).collect(),
            slopes: of(&self.slopes),
            drifts: of(&self.drifts),
            slidings: (self.slidings.iter())
                .map(|tape| tape.as_ref().map_or_else(Vec::new, of))
                .collect(),
        }
    }

    /// The state after a collision at a contact, with its rounding remainders.
    pub(crate) fn after_collision<R: Real>(
        &self,
        constants: &TouchConstants<R>,
        contact: usize,
        state: &[R],
        low: &[R],
    ) -> (Vec<R>, Vec<R>) {
        let tape = &self.collisions[contact];
        let mut after = vec![R::ZERO; state.len()];
        let mut expansion = Expansion::new(&[tape]);
        expansion.evaluate(tape, &constants.collisions[contact], state, low, &mut after);
        let remainders = (0..after.len()).map(|i| expansion.output_remainder(tape, i));
        (after, remainders.collect())
    }

    /// The derivatives of gap and rate of each contact along each column.
    pub(crate) fn slopes<R: Real>(
        &self,
        constants: &TouchConstants<R>,
        (state, low): (&[R], &[R]),
    ) -> Vec<[Vec<R>; 2]> {
        let mut slopes = vec![R::ZERO; self.slopes.outputs.len()];
        let mut expansion = Expansion::new(&[&self.slopes]);
        expansion.evaluate(&self.slopes, &constants.slopes, state, low, &mut slopes);
        let columns = slopes.len() / (2 * self.contacts.max(1));
        let of = |contact: usize| {
            let own = &slopes[2 * columns * contact..][..2 * columns];
            [own[..columns].to_vec(), own[columns..].to_vec()]
        };
        (0..self.contacts).map(of).collect()
    }

    /// By how much an impulse of each contact that changes its own rate by one moves the state in a unit of time, where the system
    /// carries columns.
    pub(crate) fn drifts<R: Real>(
        &self,
        constants: &TouchConstants<R>,
        (state, low): (&[R], &[R]),
    ) -> Vec<Vec<R>> {
        let (state, low) = (&state[..self.coordinates], &low[..self.coordinates]);
        let mut drifts = vec![R::ZERO; self.drifts.outputs.len()];
        let mut expansion = Expansion::new(&[&self.drifts]);
        expansion.evaluate(&self.drifts, &constants.drifts, state, low, &mut drifts);
        drifts.chunks(self.coordinates).map(<[R]>::to_vec).collect()
    }

    /// Friction of a contact at an impact; none without any.
    pub(crate) fn sliding<R: Real>(
        &self,
        constants: &TouchConstants<R>,
        contact: usize,
        state: &[R],
        low: &[R],
    ) -> Option<Sliding<R>> {
        let tape = self.slidings[contact].as_ref()?;
        let mut values = vec![R::ZERO; tape.outputs.len()];
        let own = &constants.slidings[contact];
        Expansion::new(&[tape]).evaluate(tape, own, state, low, &mut values);
        let stop = values.split_off(SLIDING_SCALARS);
        let &[rate, lift, change, rise, coefficient] = &values[..] else {
            return None;
        };
        Some(Sliding {
            rate,
            lift,
            change,
            rise,
            coefficient,
            stop,
        })
    }

    /// The rate of sliding of a contact with friction.
    pub(crate) fn rate_of_sliding<R: Real>(
        &self,
        constants: &TouchConstants<R>,
        contact: usize,
        start: (&[R], &[R]),
    ) -> Option<WithTerms<R>> {
        let tape = self.slidings[contact].as_ref()?;
        let values = with_terms(tape, &constants.slidings[contact], start);
        values.first().copied()
    }

    /// Everything at a state and its rounding remainders.
    pub(crate) fn at<R: Real>(
        &self,
        constants: &TouchConstants<R>,
        state: &[R],
        low: &[R],
    ) -> Touch<R> {
        let (n, dimension) = (self.contacts, self.coordinates);
        let start = (&state[..dimension], &low[..dimension]);
        let values = with_terms(&self.values, &constants.values, start);
        let (scalars, rows) = values.split_at(SCALARS * n);
        let column = |k: usize| scalars.iter().copied().skip(k).step_by(SCALARS).collect();
        let table = |first: usize, width: usize| -> Vec<Vec<R>> {
            (rows[first..first + n * width].chunks(width.max(1)))
                .map(|row| row.iter().map(|entry| entry.value).collect())
                .collect()
        };
        Touch {
            gap: column(0),
            rate: column(1),
            acceleration: column(2),
            restitution: column(3),
            room: column(4),
            coupling: table(0, n),
            jump: table(n * n, dimension),
            gradient: table(n * n + n * dimension, dimension),
        }
    }
}

fn sliding(
    mechanics: &mut Mechanics,
    contact: usize,
    (coordinates, directions): (usize, &[Direction]),
) -> Option<Tape> {
    let Stop {
        rate,
        lift,
        change,
        stop,
    } = stop(mechanics, contact)?;
    let coefficient = (mechanics.rubs.iter().find(|rub| rub.contact == contact))?.coefficient;
    let rise = mechanics.contacts[contact].rate_per_impulse;
    let graph = &mut mechanics.graph;
    let mut outputs = vec![rate, lift, change, rise, coefficient];
    outputs.extend(&stop);
    for direction in directions {
        outputs.extend(direction.along(graph, coordinates, &stop));
    }
    let dimension = coordinates * (1 + directions.len());
    Some(Tape::new(graph, dimension, &[], &outputs))
}

/// What stops the sliding of a contact, as expressions of what [`Sliding`] has the values of.
pub(super) struct Stop {
    rate: Expr,
    lift: Expr,
    change: Expr,
    pub(super) stop: Vec<Expr>,
}

/// The rate of sliding of a contact with friction, and what a tangential impulse that stops it adds to the state while the gap rate
/// stays as it is.
pub(super) fn stop(mechanics: &mut Mechanics, contact: usize) -> Option<Stop> {
    let rub = mechanics.rubs.iter().find(|rub| rub.contact == contact)?;
    let (rate, along) = (rub.rate, rub.along.clone());
    let gap_rate = mechanics.contacts[contact].rate;
    let jump = mechanics.contacts[contact].jump.clone();
    let graph = &mut mechanics.graph;
    // W_t less as much of the impulse as takes back what it does to the gap rate.
    let lift = graph.lie_derivative(gap_rate, &along);
    let level: Vec<Expr> = (along.iter().zip(&jump))
        .map(|(&along, &jump)| {
            let share = graph.mul(lift, jump);
            graph.sub(along, share)
        })
        .collect();
    let change = graph.lie_derivative(rate, &level);
    let stop = (level.iter())
        .map(|&part| {
            let direction = graph.div(part, change);
            let taken = graph.mul(direction, rate);
            graph.neg(taken)
        })
        .collect();
    Some(Stop {
        rate,
        lift,
        change,
        stop,
    })
}

/// Outputs of a tape at a state and its rounding remainders, each with its terms.
pub(crate) fn with_terms<R: Real>(
    tape: &Tape,
    constants: &[R],
    start: (&[R], &[R]),
) -> Vec<WithTerms<R>> {
    dispatch_narrow(Evaluation {
        tape,
        constants,
        start,
    })
}

/// The series of a slot of a tape in a unit of time, each coefficient with its terms, to the highest order.
pub(crate) fn series_with_terms<R: Real>(
    tape: &Tape,
    constants: &[R],
    start: (&[R], &[R]),
    (slot, unit): (usize, R),
) -> Vec<WithTerms<R>> {
    let mut expansion = Expansion::new(&[tape]);
    let (state, low) = WithTerms::for_series(start.0, start.1);
    let (numbers, _) = WithTerms::for_series(constants, &[]);
    let (unit, _) = WithTerms::for_series(&[unit], &[]);
    let order = R::ORDERS[R::ORDERS.len() - 1];
    expansion.run(tape, &numbers, &state, &low, unit[0], order);
    let series = expansion.series(slot).iter();
    series.map(|&c| WithTerms::of_series(c)).collect()
}

/// What these operands of a tape are at a point, with their terms.
pub(crate) fn operands_with_terms<R: Real>(
    tape: &Tape,
    constants: &[R],
    start: (&[R], &[R]),
    places: &[Operand],
) -> Vec<WithTerms<R>> {
    let (state, low) = (WithTerms::all(start.0), WithTerms::remainders(start.1));
    let numbers = WithTerms::all(constants);
    let mut expansion = Expansion::new(&[tape]);
    expansion.run(tape, &numbers, &state, &low, WithTerms::exact(R::ONE), 0);
    let value = |place: &Operand| match *place {
        Operand::Series(slot) => expansion.series(slot)[0],
        Operand::Constant(place) => numbers[place],
    };
    places.iter().map(value).collect()
}

/// A tape without the roots of what one of its series is, if that is all that is left out.
pub(crate) fn after_roots<R: Real>(tape: &Tape, slot: usize, constants: &[R]) -> Option<Tape> {
    let which = tape
        .singular
        .iter()
        .position(|singular| singular.slot == slot)?;
    tape.without_roots(which, constants, Negligible::Integrable)
}

/// A tape without the roots of whatever vanishes at the start. None if more than roots would be left out.
pub(crate) fn after_all_roots<R: Real>(
    tape: &Tape,
    constants: &[R],
    start: (&[R], &[R]),
) -> Option<Tape> {
    let mut plain = tape.clone();
    loop {
        let values: Vec<(usize, R, R)> = {
            let (state, low) = (WithTerms::all(start.0), WithTerms::remainders(start.1));
            let mut expansion = Expansion::new(&[&plain]);
            let numbers = WithTerms::all(constants);
            expansion.run(&plain, &numbers, &state, &low, WithTerms::exact(R::ONE), 0);
            (plain.singular.iter())
                .map(|singular| (singular.slot, expansion.series(singular.slot)[0]))
                .map(|(slot, value)| (slot, value.value, value.level()))
                .collect()
        };
        let vanishing = values.iter().find(|(_, value, level)| value <= level);
        let Some(&(other, ..)) = vanishing else {
            return Some(plain);
        };
        plain = after_roots(&plain, other, constants)?;
    }
}

/// As [`series_with_terms`], of a series that vanishes at the start: along the motion without the roots of it, and of whatever else
/// vanishes there. None if more than roots would be left out.
pub(crate) fn series_after_roots<R: Real>(
    tape: &Tape,
    constants: &[R],
    start: (&[R], &[R]),
    (slot, unit): (usize, R),
) -> Option<Vec<WithTerms<R>>> {
    let plain = after_roots(tape, slot, constants)?;
    let plain = after_all_roots(&plain, constants, start)?;
    Some(series_with_terms(&plain, constants, start, (slot, unit)))
}

struct Evaluation<'a, R> {
    tape: &'a Tape,
    constants: &'a [R],
    start: (&'a [R], &'a [R]),
}

impl<R: Real> Kernel for Evaluation<'_, R> {
    type Output = Vec<WithTerms<R>>;

    #[inline(always)]
    fn run(self) -> Self::Output {
        let Self {
            tape, constants, ..
        } = self;
        let (state, low) = self.start;
        let mut values = vec![WithTerms::exact(R::ZERO); tape.outputs.len()];
        let mut expansion = Expansion::new(&[tape]);
        let exact = WithTerms::all(constants);
        let (state, low) = (WithTerms::all(state), WithTerms::remainders(low));
        let mut without: Option<Tape> = None;
        loop {
            let tape = without.as_ref().unwrap_or(tape);
            expansion.evaluate(tape, &exact, &state, &low, &mut values);
            if values.iter().all(|value| value.value.is_finite()) {
                return values;
            }
            // On the surface where what a root is taken of vanishes it may by rounding be negative.
            let vanishes = |slot: usize| {
                let value = expansion.series(slot)[0];
                value.value <= value.level()
            };
            let left = (tape.singular.iter().enumerate())
                .filter(|(_, singular)| vanishes(singular.slot))
                .find_map(|(which, _)| tape.without_roots(which, constants, Negligible::Zero));
            if left.is_none() {
                return values;
            }
            without = left;
        }
    }
}

impl<R: Real> Touch<R> {
    /// Whether everything that matters is a finite number. Where nothing touches, as in the middle of a round clearance, the gap alone
    /// has to be one; and restitutions where something hits: a root of the incoming rate has no value on the way out, and what falls
    /// with a power of it none at rest.
    pub(crate) fn is_finite(&self) -> bool {
        let touching: Vec<usize> = (0..self.gap.len())
            .filter(|&contact| self.gap[contact].value <= self.gap[contact].level())
            .collect();
        let all = |row: &[R]| row.iter().all(|value| value.is_finite());
        self.gap.iter().all(|gap| gap.value.is_finite())
            && touching.iter().all(|&contact| {
                let (rate, acceleration) = (&self.rate[contact], &self.acceleration[contact]);
                let hits = rate.value < -rate.level();
                rate.value.is_finite()
                    && acceleration.value.is_finite()
                    && (self.restitution[contact].value.is_finite() || !hits)
                    && all(&self.jump[contact])
                    && all(&self.gradient[contact])
                    && touching
                        .iter()
                        .all(|&other| self.coupling[contact][other].is_finite())
            })
    }

    /// How fast the rate of each contact can change: by what moves it in flight, or by the forces of other contacts.
    pub(crate) fn greatest_accelerations(&self) -> Vec<R> {
        let terms = |value: &WithTerms<R>| R::splat(value.terms);
        let mut greatest: Vec<R> = self.acceleration.iter().map(terms).collect();
        // A force is handed on from contact to contact.
        for _ in 1..greatest.len() {
            let handed = |row: &Vec<R>| {
                let forces = row.iter().zip(&greatest);
                forces.fold(R::ZERO, |most, (&by, &force)| most.max(by.abs() * force))
            };
            greatest = self.coupling.iter().map(handed).collect();
        }
        greatest
    }

    /// The rows and columns of these contacts in the coupling.
    pub(crate) fn block(&self, contacts: &[usize]) -> Vec<Vec<R>> {
        let row = |&i: &usize| contacts.iter().map(|&j| self.coupling[i][j]).collect();
        contacts.iter().map(row).collect()
    }
}
