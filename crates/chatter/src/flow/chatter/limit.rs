//! What completing a chatter sequence has to know of its contact: the restitution where the sequence ends, which is the
//! ratio of everything that converges along it, and columns of derivatives as they converge.
//!
//! A fixed-time column m of derivatives after an impact is that of the impact's point, dx, moved back along the field by
//! the derivative of its time: m = dx - f dt with dt = -D h / v. Points and times converge with the ratios of the tableau,
//! and with r the derivatives of both contain the secular terms that the differentiated tableau annihilates.

use crate::expressions::{Expr, Graph, Symbol, Tape};
use crate::flow::step::Workspace;
use crate::flow::variation::Direction;
use crate::model::{ContactMechanics, Slide};
use crate::numerics::Real;

/// What a chatter sequence of one contact is completed by, as expressions.
#[derive(Clone, Debug)]
pub(crate) struct SequenceExprs {
    /// Restitution of an impact of vanishing rate.
    restitution: Expr,
    /// Per column: the derivative of the time of the impact that led to a state, then those of its point.
    events: Vec<Expr>,
    /// Per column: the derivative of the restitution, where the state's columns are those of points.
    slopes: Vec<Expr>,
    /// The model's field; empty without columns.
    field: Vec<Expr>,
    /// The free acceleration of the gap, and per column its derivative, likewise.
    acceleration: Vec<Expr>,
    /// Where one surface is slid along, and the contact's impulse leads off it: what that changes its function by, for a change of
    /// the rate by one; its rate without what holds the state on it, and half of what that is more above than below. Per column their derivatives.
    held: Vec<Expr>,
}

impl SequenceExprs {
    /// Without columns, in flight along a field; `rest` is the state with the contact's rate taken away. Surfaces that are slid along
    /// come with the field that nothing holds on them.
    pub(crate) fn new(
        graph: &mut Graph,
        contact: &ContactMechanics,
        (field, rest): (&[Expr], &[Expr]),
        (unheld, slides): (&[Expr], &[Slide]),
    ) -> Self {
        let restitution = graph.substitute(contact.restitution, &|symbol| match symbol {
            Symbol::State(i) => rest.get(i).copied(),
            Symbol::Parameter(_) => None,
        });
        let rate = graph.lie_derivative(contact.gap, field);
        let mut held = Vec::new();
        if let [slide] = slides
            && slide.rate.is_none()
            && !slide.is_component
        {
            let along = [&contact.jump, unheld, &slide.jump];
            held = along
                .map(|along| graph.lie_derivative(slide.surface, along))
                .to_vec();
        }
        Self {
            restitution,
            events: Vec::new(),
            slopes: Vec::new(),
            field: Vec::new(),
            acceleration: vec![graph.lie_derivative(rate, field)],
            held,
        }
    }

    /// Adds the columns, along the same field.
    pub(crate) fn extend(
        &mut self,
        graph: &mut Graph,
        contact: &ContactMechanics,
        field: &[Expr],
        directions: &[Direction],
    ) {
        if directions.is_empty() {
            return;
        }
        let rate = graph.lie_derivative(contact.gap, field);
        let held = self.held.clone();
        for direction in directions {
            self.held.extend(direction.along(graph, field.len(), &held));
            let gap = direction.along(graph, field.len(), &[contact.gap])[0];
            let early = graph.div(gap, rate);
            let late = graph.neg(early);
            self.events.push(late);
            let components = direction.components(graph, field.len());
            for (component, &slope) in components.into_iter().zip(field) {
                let moved = graph.mul(slope, late);
                self.events.push(graph.add(component, moved));
            }
            let along = [self.restitution, self.acceleration[0]];
            let slopes = direction.along(graph, field.len(), &along);
            self.slopes.push(slopes[0]);
            self.acceleration.push(slopes[1]);
        }
        self.field.extend_from_slice(field);
    }
}

/// What a chatter sequence of one contact is completed by, compiled.
#[derive(Clone, Debug)]
pub(crate) struct SequenceTapes {
    /// Per column: derivatives of the time and the point of the impact that led to a state.
    events: Tape,
    /// At a limit: restitution, its derivatives, the field.
    limit: Tape,
    /// There, too: the free acceleration of the gap and its derivatives.
    pub(in crate::flow) acceleration: Tape,
    /// There, too: what holds flights on a surface, with its derivatives; empty where nothing does.
    pub(in crate::flow) held: Tape,
}

/// Their constants at one parameter set.
#[derive(Clone, Debug)]
pub(crate) struct SequenceConstants<R> {
    events: Vec<R>,
    limit: Vec<R>,
    pub(in crate::flow) acceleration: Vec<R>,
    pub(in crate::flow) held: Vec<R>,
}

impl<R> SequenceConstants<R> {
    /// Of a contact that is closed.
    pub(crate) fn none() -> Self {
        Self {
            events: Vec::new(),
            limit: Vec::new(),
            acceleration: Vec::new(),
            held: Vec::new(),
        }
    }
}

impl<R> SequenceConstants<R> {
    /// Of each tape, in the order of [`SequenceTapes::tapes`].
    pub(crate) fn of_tapes(&mut self) -> impl Iterator<Item = &mut Vec<R>> {
        [
            &mut self.events,
            &mut self.limit,
            &mut self.acceleration,
            &mut self.held,
        ]
        .into_iter()
    }
}

impl SequenceTapes {
    pub(crate) fn new(graph: &mut Graph, dimension: usize, exprs: &SequenceExprs) -> Self {
        let mut limit = vec![exprs.restitution];
        limit.extend(&exprs.slopes);
        limit.extend(&exprs.field);
        Self {
            events: Tape::new(graph, dimension, &[], &exprs.events),
            limit: Tape::new(graph, dimension, &[], &limit),
            acceleration: Tape::new(graph, dimension, &[], &exprs.acceleration),
            held: Tape::new(graph, dimension, &[], &exprs.held),
        }
    }

    pub(crate) fn constants<R: Real>(
        &self,
        graph: &Graph,
        parameters: &[R],
    ) -> SequenceConstants<R> {
        SequenceConstants {
            events: self.events.constants(graph, parameters),
            limit: self.limit.constants(graph, parameters),
            acceleration: self.acceleration.constants(graph, parameters),
            held: self.held.constants(graph, parameters),
        }
    }

    /// The restitution of an impact of vanishing rate at a state.
    pub(crate) fn restitution<R: Real>(
        &self,
        work: &mut Workspace<R>,
        constants: &SequenceConstants<R>,
        state: (&[R], &[R]),
    ) -> R {
        self.limit_values(work, constants, state)[0]
    }

    /// Restitution, its derivatives and the field at a state.
    fn limit_values<R: Real>(
        &self,
        work: &mut Workspace<R>,
        constants: &SequenceConstants<R>,
        state: (&[R], &[R]),
    ) -> Vec<R> {
        let mut values = vec![R::ZERO; self.limit.outputs.len()];
        work.values_at(&self.limit, &constants.limit, state, &mut values);
        values
    }

    pub(crate) fn tapes(&self) -> impl Iterator<Item = &Tape> {
        [&self.events, &self.limit, &self.acceleration, &self.held].into_iter()
    }
}

/// The tapes of a contact in a trajectory's mode, with what runs them.
pub(crate) struct SequenceMap<'a, R: Real> {
    pub(crate) tapes: &'a SequenceTapes,
    pub(crate) constants: &'a SequenceConstants<R>,
    pub(crate) work: &'a mut Workspace<R>,
    /// How many of the states are the model's own.
    pub(crate) coordinates: usize,
    /// Where the field is another one in the fall of each flight than in its rise.
    pub(crate) turn: Option<Turn<'a, R>>,
}

/// A tape with its constants.
type Known<'a, R> = (&'a Tape, &'a [R]);

/// What makes the field another one in the fall of each flight than in its rise.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Turn<'a, R> {
    /// The free acceleration of the gap, with its derivatives, in the rise and in the fall.
    pub rise: Known<'a, R>,
    pub fall: Known<'a, R>,
    /// Where the fall is held on a surface that each impact leads off, what that needs; none where the field turns with the rate, at tops.
    pub held: Option<Known<'a, R>>,
}

/// A flight of a sequence near its end.
pub(crate) struct Flight<R> {
    /// The rate that it ends with over the one that it begins with.
    pub ratio: R,
    /// Per column the relative change of its square.
    changes: Vec<R>,
    /// How much longer it takes than if all of its way were the rise.
    pub longer: R,
}

impl<R: Real> Turn<'_, R> {
    /// The flights of a sequence that ends where tapes have these values, with this restitution and its derivatives; none that come down.
    ///
    /// With accelerations a of the rise and b of the fall, which begins the part tau of the rate w after the impact, a flight ends with
    /// the rate w sqrt(1 + (a - b) tau (2 + a tau)): w sqrt(b / a) with tau = -1/a, at the top. An impact that changes the gap rate by
    /// (1 + 1/r) w takes a surface from zero to sigma (1 + 1/r) w, from where it comes back with the rate that it has on that side.
    pub(crate) fn flight(
        &self,
        (restitution, slopes): (R, &[R]),
        values: &mut dyn FnMut(Known<'_, R>) -> Vec<R>,
    ) -> Option<Flight<R>> {
        let (one, two, half) = (R::ONE, R::splat(2.0), R::splat(0.5));
        let (fall, rise) = (values(self.fall), values(self.rise));
        let (a, b) = (rise[0], fall[0]);
        let along = rise[1..].iter().zip(&fall[1..]);
        let flight = if let Some(held) = self.held {
            const PARTS: usize = 3;
            let parts = values(held);
            let side = R::splat(if parts[0] < R::ZERO { -1.0 } else { 1.0 });
            let (share, rate) = (one + one / restitution, |part: &[R]| {
                part[1] + side * part[2]
            });
            let (off, back) = (parts[0] * share, rate(&parts));
            let tau = -(off / back);
            let left = two + a * tau;
            let square = one + (a - b) * tau * left;
            let columns = parts[PARTS..].chunks(PARTS).zip(slopes).zip(along);
            let change = |((part, &slope), (&da, &db)): ((&[R], &R), (&R, &R))| {
                let shares = parts[0] * slope / (restitution * restitution);
                let moved = part[0] * share - shares + tau * rate(part);
                let later = -(moved / back);
                let turned = (left - one) * two * later + da * tau * tau;
                ((da - db) * tau * left + (a - b) * turned) / square
            };
            let ratio = square.sqrt();
            Flight {
                ratio,
                changes: columns.map(change).collect(),
                longer: (tau - (left - one + ratio) / b) * -a * half,
            }
        } else {
            let ratio = (b / a).sqrt();
            Flight {
                ratio,
                changes: along.map(|(&da, &db)| db / b - da / a).collect(),
                longer: (one + one / ratio) * half,
            }
        };
        let falls = a < R::ZERO && b < R::ZERO;
        (falls && flight.ratio.is_finite() && flight.longer > R::ZERO).then_some(flight)
    }
}

/// A point at which a sequence may end: its restitution there, with the derivatives along the columns.
#[derive(Clone, Debug)]
pub(super) struct LimitPoint<R> {
    /// Of an impact of vanishing rate.
    pub of_impacts: R,
    /// By how much rates fall from impact to impact: the same, unless the field is another one in the fall of each flight.
    pub restitution: R,
    pub slopes: Vec<R>,
    pub field: Vec<R>,
}

impl<R: Real> SequenceMap<'_, R> {
    pub(super) fn coordinates(&self) -> usize {
        self.coordinates
    }

    pub(super) fn is_clock(&self, state: usize) -> bool {
        self.work.is_clock(state)
    }

    /// How many columns of derivatives there are.
    pub(super) fn columns(&self) -> usize {
        self.tapes.events.outputs.len() / (self.coordinates + 1)
    }

    /// Per column the derivatives of the latest impact's time and point: `coordinates + 1` numbers.
    pub(super) fn events(&mut self, state: (&[R], &[R])) -> Vec<R> {
        let mut values = vec![R::ZERO; self.tapes.events.outputs.len()];
        if !values.is_empty() {
            (self.work).values_at(
                &self.tapes.events,
                &self.constants.events,
                state,
                &mut values,
            );
        }
        values
    }

    /// The restitution of an impact of vanishing rate at a state.
    pub(super) fn restitution(&mut self, state: (&[R], &[R])) -> R {
        (self.tapes).restitution(self.work, self.constants, state)
    }

    /// What holds at a point, given with the derivatives of its coordinates.
    pub(super) fn at(&mut self, point: &[R], low: &[R]) -> LimitPoint<R> {
        let mut values = (self.tapes).limit_values(self.work, self.constants, (point, low));
        let columns = self.columns();
        let of_impacts = values[0];
        if let Some(turn) = self.turn {
            let slopes = values[1..1 + columns].to_vec();
            let mut at_limit = |(tape, constants): Known<'_, R>| {
                let mut all = vec![R::ZERO; tape.outputs.len()];
                (self.work).values_at(tape, constants, (point, low), &mut all);
                all
            };
            let flight = turn.flight((of_impacts, &slopes), &mut at_limit);
            let ratio = (flight.as_ref()).map_or(R::splat(f64::NAN), |flight| flight.ratio);
            values[0] *= ratio;
            let changes = flight.iter().flat_map(|flight| &flight.changes);
            for (slope, &change) in values[1..1 + columns].iter_mut().zip(changes) {
                let change = change * R::splat(0.5);
                *slope = (*slope).mul_add(ratio, of_impacts * ratio * change);
            }
        }
        LimitPoint {
            of_impacts,
            restitution: values[0],
            slopes: values[1..1 + columns].to_vec(),
            field: values[1 + columns..].to_vec(),
        }
    }
}
