//! A model with its compiled legs, and functions of the user's.

use crate::analysis::periodic::closure::Closure;
use crate::analysis::periodic::error::PeriodicError;
use crate::expressions::{Expr, Graph, Symbol};
use crate::flow::leg::{Leg, LegKind, Stretch, StretchKind};
use crate::flow::{Corner, GuardKind, System};
use crate::model::{Direction, Model};
use crate::numerics::Real;
use std::sync::{Arc, Mutex, PoisonError};

/// A crossing of the section this near to an event, in parts of the time around it, is at its instant.
pub(in crate::analysis::periodic) const AT_ENDS: f64 = 1e-9;

/// A model with its compiled legs, shared by all orbits that are looked at.
#[derive(Debug)]
pub(crate) struct Workshop {
    pub model: Model,
    pub system: System,
    pub closure: Closure,
    /// Positions of the free parameters.
    pub free: Vec<usize>,
    /// Sizes of the free parameters.
    pub sizes: Vec<f64>,
    /// Functions of the user's.
    pub monitors: Vec<Monitor>,
    /// The section at which states are told.
    pub section: Option<usize>,
    /// Its function.
    surface: Option<Monitor>,
    /// Contacts whose restitution is a matter of parameters alone, the free ones among them.
    pub restitution_follows: Vec<usize>,
    /// Whether what happens depends on a state, be it through others: not on the angle of a wheel that is only kicked, nor on its rate.
    pub matters: Vec<bool>,
    legs: Mutex<Vec<(LegKind, Arc<Leg>)>>,
    stretches: Mutex<Vec<(StretchKind, Arc<Stretch>)>>,
}

/// A function of the state that an orbit is told from, and of parameters, with its derivatives.
#[derive(Clone, Debug)]
pub(crate) struct Monitor {
    pub(super) value: Expr,
    pub(super) by_state: Vec<Expr>,
    pub(super) by_parameter: Vec<Expr>,
}

impl Monitor {
    fn new(model: &mut Model, value: Expr, free: &[usize]) -> Self {
        let mut graph = model.graph.clone();
        let by_state = (0..model.states.len())
            .map(|i| graph.derivative(value, Symbol::State(i)))
            .collect();
        let by_parameter = (free.iter())
            .map(|&p| model.derivatives_by_parameter(&mut graph, &[value], p)[0])
            .collect();
        model.graph = graph;
        Self {
            value,
            by_state,
            by_parameter,
        }
    }
}

impl Monitor {
    /// Its value.
    pub(crate) fn at(&self, graph: &Graph, state: &[f64], parameters: &[f64]) -> f64 {
        graph.evaluate(self.value, state, parameters)
    }

    /// Below this it is not told from zero at a state that is known to rounding of states of these sizes.
    pub(crate) fn level(
        &self,
        graph: &Graph,
        (state, sizes): (&[f64], &[f64]),
        parameters: &[f64],
    ) -> f64 {
        let slopes = graph.evaluate_all(&self.by_state, state, parameters);
        let terms = slopes.iter().zip(state).zip(sizes);
        let terms: f64 = terms
            .map(|((slope, x), size)| slope.abs() * size.max(x.abs()))
            .sum();
        MONITOR_ROUNDOFFS * f64::EPSILON * terms
    }
}

/// Nodes are known to some roundoffs of their sizes.
const MONITOR_ROUNDOFFS: f64 = 64.0;

impl Workshop {
    /// Whether nothing but events with resets happens at instants: the motion is a map from one to the next. (Impacts may accumulate, and
    /// are no periods.)
    pub(crate) fn is_map_by_events(&self) -> bool {
        let model = &self.model;
        model.contacts.is_empty() && model.sections.iter().any(|section| section.reset.is_some())
    }

    pub(crate) fn new(
        model: &Model,
        (free, sizes): (&[usize], &[f64]),
        mut closure: Closure,
        (section, monitors): (Option<usize>, &[Expr]),
    ) -> Result<Self, PeriodicError> {
        let system = System::new(model).map_err(PeriodicError::System)?;
        let mut model = model.clone();
        closure.frees(counters(&model, &system));
        let monitors = (monitors.iter())
            .map(|&value| Monitor::new(&mut model, value, free))
            .collect();
        let surface = section.map(|index| {
            let surface = model.sections[index].surface;
            Monitor::new(&mut model, surface, free)
        });
        let follows = |index: &usize| {
            let restitution = model.contacts[*index].restitution;
            !model.graph.depends_on_state(restitution) && depends_on(&model, restitution, free)
        };
        Ok(Self {
            restitution_follows: (0..model.contacts.len()).filter(follows).collect(),
            matters: matters(&model),
            system,
            model,
            monitors,
            closure,
            free: free.to_vec(),
            sizes: sizes.to_vec(),
            section,
            surface,
            legs: Mutex::default(),
            stretches: Mutex::default(),
        })
    }

    /// The section if its crossings are events where nothing else happens: where nothing else says how long a period is.
    pub(crate) fn section_as_event(&self, parameters: &[f64]) -> Option<usize> {
        self.section
            .filter(|_| self.closure.forcing(parameters).is_none())
    }

    /// Whether a state lies on the section and moves through it in its direction, in a system in which times are as long as this one.
    pub(crate) fn is_on_section(&self, state: &[f64], parameters: &[f64], time: f64) -> bool {
        let (Some(section), Some(surface)) = (self.section, &self.surface) else {
            return false;
        };
        let graph = &self.model.graph;
        let at = |expr: Expr| graph.evaluate(expr, state, parameters);
        let rates = self.model.states.iter().zip(&surface.by_state);
        let rate: f64 = rates.map(|(of, &by)| at(by) * at(of.derivative)).sum();
        let is_its_way = match self.model.sections[section].direction {
            Direction::Rising => rate > 0.0,
            Direction::Falling => rate < 0.0,
            Direction::Either => rate != 0.0,
        };
        is_its_way && at(surface.value).abs() <= AT_ENDS * (rate * time).abs()
    }

    /// The function of the section.
    pub(super) fn surface(&self) -> Option<&Monitor> {
        self.surface.as_ref()
    }

    pub(in crate::analysis::periodic) fn leg(&self, kind: LegKind) -> Option<Arc<Leg>> {
        let mut known = self.legs.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, leg)) = known.iter().find(|(of, _)| *of == kind) {
            return Some(leg.clone());
        }
        let leg = Arc::new(self.system.leg(kind, &self.free, self.section)?);
        known.push((kind, leg.clone()));
        Some(leg)
    }

    pub(in crate::analysis::periodic) fn stretch(&self, kind: StretchKind) -> Option<Arc<Stretch>> {
        let mut known = (self.stretches.lock()).unwrap_or_else(PoisonError::into_inner);
        if let Some((_, stretch)) = known.iter().find(|(of, _)| *of == kind) {
            return Some(stretch.clone());
        }
        let stretch = Arc::new(self.system.stretch(kind, &self.free)?);
        known.push((kind, stretch.clone()));
        Some(stretch)
    }

    /// What happens where a guard vanishes.
    pub(crate) fn named(&self, guard: GuardKind) -> String {
        let contact = |index: usize| &self.model.contacts[index].name;
        let corner = |corner: Corner| self.system.corner_name(corner);
        match guard {
            GuardKind::Gap(index) => format!("an impact at `{}`", contact(index)),
            GuardKind::Reaction(index) => format!("a release of `{}`", contact(index)),
            GuardKind::Root(index) => {
                format!(
                    "an edge of the domain: {} = 0, of which a root is taken",
                    self.model.radicand(index)
                )
            }
            GuardKind::Jam(index) => format!("the jamming of `{}`", contact(index)),
            GuardKind::Section(index) => format!("`{}`", self.model.sections[index].name),
            GuardKind::Switch(index) => {
                format!("a crossing of {} = 0", corner(Corner::Surface(index)))
            }
            GuardKind::Leave(index, _) => {
                format!(
                    "the end of sliding along {} = 0",
                    corner(Corner::Surface(index))
                )
            }
            GuardKind::Outside(index, _) => {
                format!("the end of a table at {}", corner(Corner::Lookup(index)))
            }
            GuardKind::Piece(index, _) => {
                format!("the end of a piece at {}", corner(Corner::Lookup(index)))
            }
        }
    }

    /// All parameters, with the free ones at these values.
    pub(crate) fn parameters<R: Real>(&self, free: &[R]) -> Vec<R> {
        let values: Vec<(usize, R)> = (self.free.iter().copied())
            .zip(free.iter().copied())
            .collect();
        self.model.parameter_values(&values)
    }
}

/// Whether a formula depends on some of these parameters, be it through others.
fn depends_on(model: &Model, formula: Expr, parameters: &[usize]) -> bool {
    let used = model.graph.symbols(formula);
    parameters.iter().any(|&parameter| {
        let mut graph = model.graph.clone();
        let rates = model.parameter_rates(&mut graph, parameter);
        let zero = graph.number(0.0);
        (rates.iter().enumerate())
            .any(|(index, &rate)| rate != zero && used.contains(&Symbol::Parameter(index)))
    })
}

/// The states that no flow changes and that choices alone are made by, among what stands still itself, such as a counter whose parity a
/// surface is told by: between events nothing depends on how large they are, and which choice holds is a matter of modes. Resets keep
/// displacements of them, turn them over or forget them: what shrinks or grows is a motion.
fn counters(model: &Model, system: &System) -> Vec<usize> {
    let mut graph = model.graph.clone();
    let [zero, one, turned] = [0.0, 1.0, -1.0].map(|number| graph.number(number));
    let stands = |state: usize| model.states[state].derivative == zero;
    let equations = model.equations();
    let states = |expr: Expr| {
        let symbols = system.model().graph.symbols(expr).into_iter();
        symbols.filter_map(|symbol| match symbol {
            Symbol::State(state) => Some(state),
            Symbol::Parameter(_) => None,
        })
    };
    let corners = system.corners();
    let mut is_counter = |state: usize| {
        let resets = model.sections.iter().filter_map(|s| s.reset.as_ref());
        let hits = model.contacts.iter().filter_map(|c| c.reset.as_ref());
        let own: Vec<Expr> = resets.chain(hits).map(|reset| reset[state]).collect();
        let stays_apart = |surface: &Expr| {
            let mut all = states(*surface);
            !all.any(|other| other == state) || states(*surface).all(stands)
        };
        let mut by_itself = |expr: Expr| -> Expr { graph.derivative(expr, Symbol::State(state)) };
        stands(state)
            && (own.iter()).all(|&own| [zero, one, turned].contains(&by_itself(own)))
            && corners.surfaces.iter().all(stays_apart)
            && (corners.lookups.iter()).all(|lookup| stays_apart(&lookup.argument))
            && (equations.iter().filter(|equation| !own.contains(equation)))
                .all(|&equation| by_itself(equation) == zero)
    };
    (0..model.states.len())
        .filter(|&state| is_counter(state))
        .collect()
}

/// The states that events depend on, be it through others: what guards, and formulas that change their form, are made of, and what changes
/// these by the flow or by a jump.
fn matters(model: &Model) -> Vec<bool> {
    let graph = &model.graph;
    let changes_form = |expr: &Expr| graph.has_corner(&[*expr]);
    let mut open: Vec<Expr> = model.field().into_iter().filter(changes_form).collect();
    open.extend(model.sections.iter().map(|section| section.surface));
    for contact in &model.contacts {
        open.extend([contact.gap, contact.restitution]);
        open.extend(
            contact
                .friction
                .iter()
                .flat_map(|f| [f.coefficient, f.rate]),
        );
    }
    let mut found = vec![false; model.states.len()];
    while let Some(expr) = open.pop() {
        for symbol in graph.symbols(expr) {
            let Symbol::State(state) = symbol else {
                continue;
            };
            if core::mem::replace(&mut found[state], true) {
                continue;
            }
            open.push(model.states[state].derivative);
            for contact in &model.contacts {
                let along = contact.friction.iter().map(|friction| &friction.along);
                let jumps = along.chain([&contact.impulse]).chain(&contact.reset);
                open.extend(jumps.filter_map(|jump| jump.get(state)));
            }
            let resets = model
                .sections
                .iter()
                .filter_map(|section| section.reset.as_ref());
            open.extend(resets.filter_map(|reset| reset.get(state)));
        }
    }
    found
}
