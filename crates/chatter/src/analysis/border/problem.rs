//! A model and one of its parameters, compiled for border orbits; and the same at a value of the parameter.

use super::coordinate::local::LocalTape;
use super::coordinate::sequence::{Follower, Sequence, Until};
use super::error::{BorderError, Lack, Named};
use super::release::equations::{CONDITIONS, ReleaseEquations, ReleasePoint};
use super::spec::BorderSpec;
use crate::analysis::periodic::closure::{Closure, Turn};
use crate::expressions::{Expr, Graph, Side, Surfaces, Symbol};
use crate::flow::{Column, Corner, System, SystemError, columns, with_identity};
use crate::model::{Mechanics, Model};
use crate::numerics::linear::solve;
use crate::numerics::{Real, dot, moved};

/// A corner is at the release point if its function is this small there against the largest along the way.
const AT_RELEASE: f64 = 1e-9;

/// What is zero where a contact rests: gap and rate.
const RESTS: usize = 2;

/// A field is continuous if what it differs by on the sides of a corner, at this part of the largest rate beside it, is less by as much as
/// this where one is nearer by so much, or is rounding.
const BESIDE: f64 = 1e-9;
const NEARER: f64 = 16.0;
const NOISE_ROUNDOFFS: f64 = 64.0;

/// A model and the parameter that is varied. Derivatives have a column for each state, in order, and one for the parameter.
#[derive(Clone, Debug)]
pub(crate) struct Problem {
    pub model: Model,
    pub mechanics: Mechanics,
    pub parameter: usize,
    pub spec: BorderSpec,
    /// For each contact where it ends.
    pub releases: Vec<ReleaseEquations>,
    /// The phases of a forcing; none where the equations have no period.
    pub closure: Option<Closure>,
    pub plain: Follower,
    variational: Follower,
    /// The corners that the motion depends on.
    corners: Vec<KnownCorner>,
    /// The field on all sides of them.
    whole: (Graph, Vec<Expr>),
}

/// A corner, and where the equations of release points are taken to be.
#[derive(Clone, Debug)]
struct KnownCorner {
    /// Its number among the surfaces.
    index: usize,
    function: Expr,
    /// Its derivatives: by the states, then by the parameter.
    slopes: Vec<Expr>,
    /// The side that holds where contacts rest.
    side: Side,
}

/// The problem at a value of the parameter.
#[derive(Clone, Debug)]
pub(crate) struct Here<'p, R> {
    pub problem: &'p Problem,
    pub value: R,
    /// All parameter values.
    pub parameters: Vec<R>,
    pub closure: &'p Closure,
    /// The phases, which the equations know up to whole periods.
    pub phases: Vec<Turn<R>>,
}

impl Problem {
    pub(crate) fn new(model: &Model, spec: &BorderSpec) -> Result<Self, BorderError> {
        let parameter = &*spec.parameter;
        let Some(index) = model.parameter_index(parameter) else {
            let known = model.parameter_names();
            return Err(BorderError::unknown(Named::Parameter, parameter, known));
        };
        if model.contacts.is_empty() {
            return Err(BorderError::NoContact);
        }
        if model.states.len() < CONDITIONS {
            let count = model.states.len();
            return Err(BorderError::States { count });
        }
        let mut model = model.with_telling_numbers(&[index]);
        // Sections would only cut the flights, but for those that change the state.
        model.sections.retain(|section| section.reset.is_some());
        let system = System::new(&model)?;
        let whole = Mechanics::new(&model).map_err(SystemError::Model)?;
        let (mechanics, corners) = at_rest(&system, &whole, index)?;
        let contacts = 0..model.contacts.len();
        let follower = |system: System, columns: &[Column]| {
            let local =
                |contact| LocalTape::new((&model, &mechanics), contact, columns, spec.coordinate);
            Follower {
                system,
                locals: contacts.clone().map(local).collect(),
            }
        };
        let columns = columns(model.states.len(), &[index]);
        let variational = System::with_columns(&model, &columns)?;
        let release = |contact| ReleaseEquations::new(&model, &mechanics, index, contact);
        let closure = Closure::with_section(&model, &[index], None, None).ok();
        Ok(Self {
            releases: contacts.clone().map(release).collect(),
            closure: closure.map(|(closure, _)| closure),
            plain: follower(system, &[]),
            variational: follower(variational, &columns),
            parameter: index,
            spec: spec.clone(),
            mechanics,
            corners,
            whole: (whole.graph, whole.field),
            model,
        })
    }

    /// The function of a corner on whose side the field is another one, if a release point is on it or on another side than it is
    /// taken to be, the states along the way being given.
    pub(crate) fn corner_at<R: Real>(
        &self,
        (point, parameters): (&ReleasePoint<R>, &[R]),
        way: &[&[R]],
    ) -> Option<String> {
        let release = &*point.state;
        let graph = &self.mechanics.graph;
        let value = |surface: Expr, state: &[R]| graph.evaluate(surface, state, parameters);
        let found = self.corners.iter().find(|corner| {
            let here = value(corner.function, release);
            let largest = (way.iter()).fold(here.abs(), |most, state| {
                most.max(value(corner.function, state).abs())
            });
            let is_beyond = here.abs() > largest * R::splat(AT_RELEASE);
            match is_beyond {
                true => (here > R::ZERO) != (corner.side == Side::Above),
                false => !self.is_met_at_rest(corner, (point, parameters), way),
            }
        });
        found.map(|corner| (self.plain.system).corner_name(Corner::Surface(corner.index)))
    }

    /// Whether a corner through a release point is wherever the contact rests, and the field is continuous there: as with drag `v*abs(v)`.
    /// Then flights of chatter all pass it in the same way, at times that are analytic in u and nu, and to leading order as if there were
    /// none. All that is told of a border holds.
    fn is_met_at_rest<R: Real>(
        &self,
        corner: &KnownCorner,
        (point, parameters): (&ReleasePoint<R>, &[R]),
        way: &[&[R]],
    ) -> bool {
        let equations = &self.releases[point.contact];
        let rests = equations.at(0..RESTS, &point.state, parameters).jacobian;
        let graph = &self.mechanics.graph;
        let slopes = graph.evaluate_all(&corner.slopes, &point.state, parameters);
        // Of its slopes gap and rate leave nothing.
        let rows = [0, 1].map(|row| rests.row(row));
        let squares = rows.map(|a| rows.map(|b| dot(a, b)).to_vec());
        let Some(parts) = solve(&squares, &rows.map(|row| dot(row, &slopes))) else {
            return false;
        };
        let rest = (parts.iter().zip(rows)).fold(slopes.clone(), |left, (&part, row)| {
            moved(&left, row, -part)
        });
        let (size, left) = (dot(&slopes, &slopes), dot(&rest, &rest));
        let is_of_rest = left <= size * R::splat(AT_RELEASE * AT_RELEASE) && size > R::ZERO;
        let Some(first) = way.first().filter(|_| is_of_rest) else {
            return false;
        };
        let rate = equations.at(1..RESTS, first, parameters).residual[0].abs();
        let jump = &point.jump[..self.states()];
        let field = |by: R| {
            let state = moved(&point.state, jump, by);
            (self.whole.0).evaluate_all(&self.whole.1, &state, parameters)
        };
        let across = |part: f64| -> Vec<R> {
            let sides = [part, -part].map(|part| field(rate * R::splat(part)));
            (sides[0].iter().zip(&sides[1]))
                .map(|(&a, &b)| (a - b).abs())
                .collect()
        };
        let (far, near, sizes) = (across(BESIDE), across(BESIDE / NEARER), field(R::ZERO));
        let [shrinks, noise] = [2.0 / NEARER, NOISE_ROUNDOFFS * R::ROUNDOFF].map(R::splat);
        (0..sizes.len()).all(|i| near[i] <= far[i] * shrinks + sizes[i].abs() * noise)
    }

    /// At a value of the parameter: fails where the equations never return to what they were.
    pub(crate) fn at<R: Real>(&self, value: R) -> Result<Here<'_, R>, BorderError> {
        let parameters = self.model.parameter_values(&[(self.parameter, value)]);
        let lacks = || Lack::Period.at(value);
        let closure = self.closure.as_ref().ok_or_else(lacks)?;
        let phases = closure.turns(&parameters).map_err(|_| lacks())?;
        Ok(Here {
            problem: self,
            value,
            parameters,
            closure,
            phases,
        })
    }

    /// How many states there are.
    pub(crate) fn states(&self) -> usize {
        self.model.states.len()
    }

    /// How many coordinates release points have on their surface.
    pub(crate) fn dimensions(&self) -> usize {
        self.states() - CONDITIONS
    }
}

/// What follows from a model's equations on the sides of their corners that hold where its contacts rest, along its own motion: border
/// orbits are released there, and chatter ends there. With these sides.
fn at_rest(
    system: &System,
    whole: &Mechanics,
    parameter: usize,
) -> Result<(Mechanics, Vec<KnownCorner>), BorderError> {
    let model = system.model();
    if system.corners().is_empty() {
        return Ok((whole.clone(), Vec::new()));
    }
    let rests =
        (system.first_rest()).map_err(|error| BorderError::System(SystemError::Flow(error)))?;
    let Some((_, sides, on_sides)) = system.origin_of(rests) else {
        return Ok((whole.clone(), Vec::new()));
    };
    let followed = on_sides.followed;
    if followed.is_empty() {
        return Ok((whole.clone(), Vec::new()));
    }
    if followed.lookups != Surfaces::default() {
        return Err(BorderError::LooksUp);
    }
    let mut mechanics = on_sides.mechanics.clone();
    // Impacts ask for the side of what only their restitution depends on.
    for (own, contact) in mechanics.contacts.iter_mut().zip(&model.contacts) {
        own.restitution = contact.restitution;
    }
    let states: Vec<Symbol> = (0..model.states.len()).map(Symbol::State).collect();
    let graph = &mut mechanics.graph;
    let corner = |index| {
        let function = on_sides.surfaces[index];
        let mut slopes = graph.jacobian(&[function], &states).remove(0);
        slopes.extend(model.derivatives_by_parameter(graph, &[function], parameter));
        KnownCorner {
            index,
            function,
            slopes,
            side: sides.get(index),
        }
    };
    let corners = followed.surfaces.members().map(corner).collect();
    Ok((mechanics, corners))
}

impl<R: Real> Here<'_, R> {
    /// That something is missing here.
    pub(crate) fn lacks(&self, what: Lack) -> BorderError {
        what.at(self.value)
    }

    /// The impacts from a state, with derivatives by that state and by the parameter: so many, or fewer if chatter ends
    /// earlier, though after impact number `after`.
    pub(crate) fn variation(
        &self,
        (contact, state): (usize, &[R]),
        after: usize,
        impacts: usize,
    ) -> Result<Sequence<R>, BorderError> {
        let start = with_identity(state, self.problem.states() + 1);
        let until = Until {
            impacts,
            after,
            ..Until::NEVER
        };
        let sequence =
            (self.problem.variational).follow(&self.parameters, (contact, &start), until);
        sequence.map_err(|error| self.lacks(Lack::Motion(error)))
    }
}

impl Here<'_, f64> {
    /// The impacts from a state, without derivatives.
    pub(crate) fn follow(
        &self,
        start: (usize, &[f64]),
        until: Until,
    ) -> Result<Sequence<f64>, BorderError> {
        let sequence = self.problem.plain.follow(&self.parameters, start, until);
        sequence.map_err(|error| self.lacks(Lack::Motion(error)))
    }
}
