//! What completing a chatter sequence has to know of its contact: the restitution where the sequence ends, which is the
//! ratio of everything that converges along it, and columns of derivatives as they converge.
//!
//! A fixed-time column m of derivatives after an impact is that of the impact's point, dx, moved back along the field by
//! the derivative of its time: m = dx - f dt with dt = -D h / v. Points and times converge with the ratios of the tableau,
//! and with r the derivatives of both contain the secular terms that the differentiated tableau annihilates.

use crate::expressions::{Expr, Graph, Symbol, Tape};
use crate::flow::step::Workspace;
use crate::flow::variation::Direction;
use crate::model::ContactMechanics;
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
}

impl SequenceExprs {
    /// Without columns, in flight along a field; `rest` is the state with the contact's rate taken away.
    pub(crate) fn new(
        graph: &mut Graph,
        contact: &ContactMechanics,
        (field, rest): (&[Expr], &[Expr]),
    ) -> Self {
        let restitution = graph.substitute(contact.restitution, &|symbol| match symbol {
            Symbol::State(i) => rest.get(i).copied(),
            Symbol::Parameter(_) => None,
        });
        let rate = graph.lie_derivative(contact.gap, field);
        Self {
            restitution,
            events: Vec::new(),
            slopes: Vec::new(),
            field: Vec::new(),
            acceleration: vec![graph.lie_derivative(rate, field)],
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
        for direction in directions {
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
}

/// Their constants at one parameter set.
#[derive(Clone, Debug)]
pub(crate) struct SequenceConstants<R> {
    events: Vec<R>,
    limit: Vec<R>,
    pub(in crate::flow) acceleration: Vec<R>,
}

impl<R> SequenceConstants<R> {
    /// Of a contact that is closed.
    pub(crate) fn none() -> Self {
        Self {
            events: Vec::new(),
            limit: Vec::new(),
            acceleration: Vec::new(),
        }
    }
}

impl<R> SequenceConstants<R> {
    /// Of each tape, in the order of [`SequenceTapes::tapes`].
    pub(crate) fn of_tapes(&mut self) -> impl Iterator<Item = &mut Vec<R>> {
        [&mut self.events, &mut self.limit, &mut self.acceleration].into_iter()
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
        [&self.events, &self.limit, &self.acceleration].into_iter()
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

/// The free acceleration of the gap in the rise and in the fall of each flight, with its derivatives: tapes with their constants.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Turn<'a, R> {
    pub rise: (&'a Tape, &'a [R]),
    pub fall: (&'a Tape, &'a [R]),
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
            let mut accelerations = |(tape, constants): (&Tape, &[R])| {
                let mut all = vec![R::ZERO; tape.outputs.len()];
                (self.work).values_at(tape, constants, (point, low), &mut all);
                all
            };
            let (fall, rise) = (accelerations(turn.fall), accelerations(turn.rise));
            // r sqrt(b / a), and by the logarithm its derivatives.
            let ratio = (fall[0] / rise[0]).sqrt();
            values[0] *= ratio;
            let changes = fall[1..].iter().zip(&rise[1..]);
            for (slope, (&falls, &rises)) in values[1..1 + columns].iter_mut().zip(changes) {
                let change = (falls / fall[0] - rises / rise[0]) * R::splat(0.5);
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
