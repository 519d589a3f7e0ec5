//! Mechanics on given sides of all surfaces: there every expression is smooth (MATH.md 9).

use super::identically_zero::{is_rounding, is_rounding_of_parts};
use super::{Mechanics, MechanicsError};
use crate::expressions::{
    Asked, Corners, Disc, Expr, Folding, Graph, LookedUpIn, Side, Sides, Surfaces, Symbol,
};
use crate::model::{Contact, Model, Section};

/// A surface that is slid along.
#[derive(Clone, Debug)]
pub(crate) struct Slide {
    /// Its number.
    pub index: usize,
    /// The function that stays zero, and its rate where no side changes that, but only the acceleration.
    pub surface: Expr,
    pub rate: Option<Expr>,
    /// Half of what the field above has more than the one below; or what a component of a direction adds to it, the surface being that
    /// of the vector.
    pub jump: Vec<Expr>,
    pub is_component: bool,
}

/// A contact that sticks where it is closed.
#[derive(Clone, Debug)]
pub(crate) struct Stick {
    pub contact: usize,
    /// The rate of sliding, which stays zero.
    pub rate: Expr,
    pub along: Vec<Expr>,
    pub coefficient: Expr,
    /// The contact's impulse without friction.
    pub impulse: Vec<Expr>,
}

impl Stick {
    /// The contact's impulse with all of its friction, against sliding on a side; none where nothing slides.
    fn against_sliding(&self, graph: &mut Graph, side: Side) -> Option<Vec<Expr>> {
        let against = match side {
            Side::Above => graph.neg(self.coefficient),
            Side::Below => self.coefficient,
            Side::Sliding => return None,
        };
        let parts = self.impulse.iter().zip(&self.along);
        let with_share = parts.map(|(&normal, &along)| {
            let share = graph.mul(against, along);
            graph.add(normal, share)
        });
        Some(with_share.collect())
    }
}

impl Slide {
    /// The function whose rate the jump changes, and that is held by it.
    pub(crate) fn held(&self) -> Expr {
        self.rate.unwrap_or(self.surface)
    }
}

impl Stick {
    /// Whether friction holds the same rate in the same direction.
    pub(crate) fn is_beside(&self, other: &Self) -> bool {
        self.rate == other.rate && self.along == other.along
    }
}

/// A contact with friction, and the number of the surface that is its rate of sliding.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Rubbing {
    pub contact: usize,
    pub surface: usize,
}

/// A model's expressions on given sides.
#[derive(Clone, Debug)]
pub(crate) struct OnSides {
    pub mechanics: Mechanics,
    /// Sections and events.
    pub sections: Vec<Section>,
    /// All surfaces, and the arguments of all lookups, by the sides of those within them.
    pub surfaces: Vec<Expr>,
    pub arguments: Vec<Expr>,
    /// What roots are taken of in the field, and in gaps.
    pub radicands: Vec<Expr>,
    /// The surfaces, and the lookups, that anything depends on here.
    pub active: Asked,
    /// Those of them that the motion depends on.
    pub followed: Asked,
    /// The surfaces on whose side friction alone depends, as rates of sliding.
    pub rubbing_alone: Surfaces,
    /// Of each contact those that the restitution of its impacts depends on, …
    pub at_impact: Vec<Asked>,
    /// … and of each section those that its reset does; and its formulas by which whole parts are those of the numbers in them, if it
    /// takes any.
    pub at_reset: Vec<Asked>,
    pub whole_resets: Vec<Option<Vec<Expr>>>,
}

impl Mechanics {
    /// Derives everything on these sides of the surfaces.
    ///
    /// Where a surface is slid along the field is Filippov's: the convex combination of those on both sides that keeps the
    /// surface. For several at once that is defined only where they change the field one by one.
    ///
    /// # Errors
    /// As [`new`](Self::new), and where the field that keeps to a surface is not determined.
    pub(crate) fn on_sides(
        model: &Model,
        corners: &Corners,
        rubbing: &[Rubbing],
        sides: Sides,
    ) -> Result<OnSides, MechanicsError> {
        let mut graph = model.graph.clone();
        let is_rubbing = |index: usize| rubbing.iter().any(|rubbing| rubbing.surface == index);
        let slid = |index: &usize| {
            sides.get(*index) == Side::Sliding && !is_rubbing(*index) && !corners.is_disc(*index)
        };
        // What is slid along stays zero, and so do its powers.
        let zeros: Vec<Expr> = (0..corners.surfaces.len())
            .filter(slid)
            .map(|index| {
                corners
                    .smooth(&mut graph, sides, &[corners.surfaces[index]])
                    .exprs[0]
            })
            .collect();
        let with_directions = |graph: &mut Graph, sides: Sides, exprs: &[Expr]| {
            let smooth = corners.smooth(graph, sides, exprs).exprs;
            graph.without_powers_of(&smooth, &zeros)
        };
        let resting = Resting::new(corners, &mut graph, sides)?;
        let smooth = |graph: &mut Graph, sides: Sides, exprs: &[Expr]| {
            let exprs = with_directions(graph, sides, exprs);
            resting.undirected(graph, &exprs).unwrap_or(exprs)
        };
        let directed = with_directions(&mut graph, sides, &model.field());
        let mut contacts: Vec<Contact> = Vec::with_capacity(model.contacts.len());
        for contact in &model.contacts {
            let mut contact = contact.clone();
            [contact.gap, contact.restitution] = both(smooth(
                &mut graph,
                sides,
                &[contact.gap, contact.restitution],
            ));
            contact.impulse = smooth(&mut graph, sides, &contact.impulse);
            contact.reset = (contact.reset).map(|reset| smooth(&mut graph, sides, &reset));
            if let Some(friction) = &mut contact.friction {
                friction.along = smooth(&mut graph, sides, &friction.along);
                [friction.coefficient, friction.rate] = both(smooth(
                    &mut graph,
                    sides,
                    &[friction.coefficient, friction.rate],
                ));
            }
            contacts.push(contact);
        }
        let mut sections = Vec::with_capacity(model.sections.len());
        for section in &model.sections {
            let mut section = section.clone();
            section.surface = smooth(&mut graph, sides, &[section.surface])[0];
            section.reset = (section.reset).map(|reset| smooth(&mut graph, sides, &reset));
            sections.push(section);
        }
        // The surfaces themselves may have corners.
        let mut surfaces = Vec::with_capacity(corners.surfaces.len());
        for &surface in &corners.surfaces {
            surfaces.push(smooth(&mut graph, sides, &[surface])[0]);
        }
        let mut arguments = Vec::with_capacity(corners.lookups.len());
        for lookup in &corners.lookups {
            arguments.push(smooth(&mut graph, sides, &[lookup.argument])[0]);
        }
        let mut radicands = Vec::new();
        for radicand in model.radicands() {
            radicands.push(smooth(&mut graph, sides, &[radicand])[0]);
        }
        let whole_resets = (model.sections.iter())
            .map(|section| whole_reset(corners, &mut graph, sides, section.reset.as_deref()?))
            .collect();
        let asked = AskedFor::new(model, (corners, rubbing), &graph, sides);
        graph.set_folding(Folding::Continued);
        let mut slides = resting.slides(&mut graph, &directed, asked.followed.surfaces)?;
        let undirected = resting.undirected(&mut graph, &directed);
        let field = undirected.ok_or_else(|| resting.undetermined())?;
        let mut unheld = field.clone();
        for index in asked.followed.surfaces.members().filter(slid) {
            let below = sides.with(index, Side::Below);
            let below = smooth(&mut graph, below, &model.field());
            let half = graph.number(0.5);
            let jump: Vec<Expr> = (field.iter().zip(&below))
                .map(|(&above, &below)| {
                    let jump = graph.sub(above, below);
                    graph.mul(half, jump)
                })
                .collect();
            for (component, &jump) in unheld.iter_mut().zip(&jump) {
                *component = graph.sub(*component, jump);
            }
            slides.push(Slide {
                index,
                surface: surfaces[index],
                rate: None,
                jump,
                is_component: false,
            });
        }
        let mut mechanics = Self {
            graph,
            field: unheld.clone(),
            unheld,
            slides,
            sticks: Vec::new(),
            rubs: Vec::new(),
            contacts: Vec::with_capacity(contacts.len()),
            parameters: model.parameters.len() + corners.slots(),
        };
        let told = (model, &with_directions, &resting);
        mechanics.check_slides(told, sides, &directed)?;
        mechanics.hold_rates();
        for rubbing in rubbing {
            mechanics.rub(&mut contacts[rubbing.contact], *rubbing, sides);
        }
        if !mechanics.slides.is_empty() {
            mechanics.field = mechanics.sticking(&[])?.field;
        }
        mechanics.derive_all(&contacts)?;
        Ok(OnSides {
            mechanics,
            sections,
            surfaces,
            arguments,
            radicands,
            active: asked.all(),
            followed: asked.followed,
            rubbing_alone: asked.rubbing_alone,
            at_impact: asked.at_impact,
            at_reset: asked.at_reset,
            whole_resets,
        })
    }

    /// The impulse of a contact that slides along with the friction that it brings about; or else what makes it stick.
    fn rub(&mut self, contact: &mut Contact, rubbing: Rubbing, sides: Sides) {
        let Some(friction) = contact.friction.clone() else {
            return;
        };
        let stick = Stick {
            contact: rubbing.contact,
            rate: friction.rate,
            along: friction.along.clone(),
            coefficient: friction.coefficient,
            impulse: contact.impulse.clone(),
        };
        match stick.against_sliding(&mut self.graph, sides.get(rubbing.surface)) {
            Some(impulse) => contact.impulse = impulse,
            None => self.sticks.push(stick.clone()),
        }
        self.rubs.push(stick);
    }

    /// What the impulse of a contact with the friction that sliding brings about does to the gap rate, in parts of what it does without:
    /// where that is not positive, no force or impulse of a contact that pushes is determined (Painlevé).
    pub(crate) fn room(&mut self, contact: usize) -> Expr {
        let Some(rub) = self.rubs.iter().find(|rub| rub.contact == contact) else {
            return self.graph.number(1.0);
        };
        let impulse = rub.impulse.clone();
        let (rate, with) = (
            self.contacts[contact].rate,
            self.contacts[contact].rate_per_impulse,
        );
        let bare = self.graph.lie_derivative(rate, &impulse);
        self.graph.div(with, bare)
    }

    /// The rate of sliding that an impact with all of the friction against sliding on a side leaves.
    pub(crate) fn left_sliding(&mut self, contact: usize, side: Side) -> Option<Expr> {
        let rub = self.rubs.iter().find(|rub| rub.contact == contact)?.clone();
        let (rate, restitution) = {
            let of = &self.contacts[contact];
            (of.rate, of.restitution)
        };
        let graph = &mut self.graph;
        let impulse = rub.against_sliding(graph, side)?;
        let each = graph.lie_derivative(rate, &impulse);
        let one = graph.number(1.0);
        let rise = graph.add(one, restitution);
        let rise = graph.mul(rise, rate);
        let amount = graph.div(rise, each);
        let after: Vec<Expr> = (impulse.iter().enumerate())
            .map(|(i, &part)| {
                let state = graph.state(i);
                let by = graph.mul(amount, part);
                graph.sub(state, by)
            })
            .collect();
        let at = |symbol: Symbol| match symbol {
            Symbol::State(i) => after.get(i).copied(),
            _ => None,
        };
        Some(self.graph.substitute(rub.rate, &at))
    }

    /// Whether an expression vanishes, or is rounding of what it is a difference of.
    fn is_rounding(&self, expr: Expr, of: Expr) -> bool {
        self.vanishes(expr)
            || is_rounding(&self.graph, (expr, of), [self.field.len(), self.parameters])
    }

    /// Whether a field keeps a function but for rounding of the numbers that it is written with: what x = y/0.7 leaves of
    /// the rate of 0.7 x - y where somebody has typed 1.4285714285714286.
    pub(crate) fn keeps(&mut self, function: Expr, field: &[Expr]) -> bool {
        let rate = self.graph.lie_derivative(function, field);
        if self.graph.as_number(rate).is_some() {
            return false;
        }
        let parts: Vec<Expr> = (field.iter().enumerate())
            .map(|(i, &component)| {
                let slope = self.graph.derivative(function, Symbol::State(i));
                self.graph.mul(slope, component)
            })
            .collect();
        let size = [field.len(), self.parameters];
        is_rounding_of_parts(&self.graph, (rate, &parts), size)
    }

    /// A surface whose rate is the same on all sides is slid along where its rate is held at zero, as a preloaded spring does at rest.
    fn hold_rates(&mut self) {
        for place in 0..self.slides.len() {
            let surface = self.slides[place].surface;
            // A vector is a rate that its direction changes.
            if self.slides[place].is_component {
                continue;
            }
            let is_free = (0..self.slides.len()).all(|other| {
                let jump = self.slides[other].jump.clone();
                let change = self.graph.lie_derivative(surface, &jump);
                self.vanishes(change)
            });
            if is_free {
                let rate = self.graph.lie_derivative(surface, &self.unheld);
                self.slides[place].rate = Some(rate);
            }
        }
    }

    /// Whether surfaces that are slid along together change the field one by one.
    fn check_slides(
        &mut self,
        (model, with_directions, resting): (
            &Model,
            &impl Fn(&mut Graph, Sides, &[Expr]) -> Vec<Expr>,
            &Resting,
        ),
        sides: Sides,
        directed: &[Expr],
    ) -> Result<(), MechanicsError> {
        let slides = self.slides.clone();
        for (place, first) in slides.iter().enumerate() {
            for second in &slides[..place] {
                // Components of directions are told in their places; a surface beside them changes the field alike with each direction.
                let beside = match (first.is_component, second.is_component) {
                    (true, true) => continue,
                    (false, false) => 0.0,
                    _ => 1.0,
                };
                let below = (sides.with(first.index, Side::Below)).with(second.index, Side::Below);
                let below = with_directions(&mut self.graph, below, &model.field());
                let both = [directed, &below[..]]
                    .map(|field| resting.along(&mut self.graph, field, beside));
                let [Some(above), Some(below)] = both else {
                    return Err(resting.undetermined());
                };
                let jumps = [first, second]
                    .into_iter()
                    .filter(|slide| !slide.is_component);
                for i in 0..above.len() {
                    let two = self.graph.number(2.0);
                    let both: Vec<Expr> = jumps.clone().map(|slide| slide.jump[i]).collect();
                    let both = self.graph.sum(&both);
                    let both = self.graph.mul(two, both);
                    let change = self.graph.sub(above[i], below[i]);
                    let mixed = self.graph.sub(change, both);
                    if !self.is_rounding(mixed, change) {
                        return Err(MechanicsError::MixedSurfaces {
                            first: second.index,
                            second: first.index,
                        });
                    }
                }
            }
        }
        Ok(())
    }
}

/// Vectors that are kept at zero, and whose directions are what keeps them there.
struct Resting {
    discs: Vec<(usize, Disc)>,
}

impl Resting {
    fn new(corners: &Corners, graph: &mut Graph, sides: Sides) -> Result<Self, MechanicsError> {
        let mut resting = Self { discs: Vec::new() };
        for (index, &square) in corners.surfaces.iter().enumerate() {
            if corners.is_disc(index) && sides.get(index) == Side::Sliding {
                let square = corners.smooth(graph, sides, &[square]).exprs[0];
                let disc = graph.disc_of(square);
                let disc = disc.ok_or_else(|| Self::undetermined_at(index))?;
                resting.discs.push((index, disc));
            }
        }
        Ok(resting)
    }

    /// That what keeps a vector at zero is not determined.
    fn undetermined_at(index: usize) -> MechanicsError {
        MechanicsError::MixedSurfaces {
            first: index,
            second: index,
        }
    }

    fn undetermined(&self) -> MechanicsError {
        Self::undetermined_at(self.discs.first().map_or(0, |&(index, _)| index))
    }

    /// Expressions without what the directions add; none if that is not told.
    fn undirected(&self, graph: &mut Graph, exprs: &[Expr]) -> Option<Vec<Expr>> {
        self.along(graph, exprs, 0.0)
    }

    /// Expressions with all components of all directions equal to this.
    fn along(&self, graph: &mut Graph, exprs: &[Expr], component: f64) -> Option<Vec<Expr>> {
        (self.discs.iter()).try_fold(exprs.to_vec(), |exprs, (_, disc)| {
            disc.along(graph, &exprs, |_| component)
        })
    }

    /// What each component adds to a field, if that is linear in them.
    fn slides(
        &self,
        graph: &mut Graph,
        field: &[Expr],
        followed: Surfaces,
    ) -> Result<Vec<Slide>, MechanicsError> {
        let mut slides = Vec::new();
        for (place, &(index, ref disc)) in self.discs.iter().enumerate() {
            if !followed.contains(index) {
                continue;
            }
            let undetermined = || Self::undetermined_at(index);
            let mut others = self.discs.iter().enumerate().filter(|&(k, _)| k != place);
            let own = others.try_fold(field.to_vec(), |field, (_, (_, other))| {
                other.along(graph, &field, |_| 0.0)
            });
            let own = own.ok_or_else(undetermined)?;
            let columns = disc.columns(graph, &own).ok_or_else(undetermined)?;
            let components = disc.components(graph);
            for (surface, jump) in components.into_iter().zip(columns) {
                slides.push(Slide {
                    index,
                    surface,
                    rate: None,
                    jump,
                    is_component: true,
                });
            }
        }
        Ok(slides)
    }
}

/// Who asks for corners on given sides.
struct AskedFor {
    followed: Asked,
    rubbing_alone: Surfaces,
    at_impact: Vec<Asked>,
    at_reset: Vec<Asked>,
}

impl AskedFor {
    fn new(
        model: &Model,
        (corners, rubbing): (&Corners, &[Rubbing]),
        graph: &Graph,
        sides: Sides,
    ) -> Self {
        let asked = |exprs: &[Expr]| corners.asked(graph, sides, exprs);
        let mut followed = model.field();
        followed.extend(model.sections.iter().map(|section| section.surface));
        // An impulse is a direction of forces, too.
        for contact in &model.contacts {
            followed.push(contact.gap);
            followed.extend(&contact.impulse);
            followed.extend(contact.reset.iter().flatten());
            if let Some(friction) = &contact.friction {
                followed.extend([friction.coefficient, friction.rate]);
                followed.extend(&friction.along);
            }
        }
        let mut found = Self {
            followed: asked(&followed),
            rubbing_alone: Surfaces::default(),
            at_impact: (model.contacts.iter())
                .map(|contact| asked(&[contact.restitution]))
                .collect(),
            at_reset: (model.sections.iter())
                .map(|section| asked(section.reset.as_deref().unwrap_or_default()))
                .collect(),
        };
        let others = found.all().surfaces;
        let rates = (rubbing.iter()).fold(Surfaces::default(), |all, of| all.with(of.surface));
        found.followed.surfaces = found.followed.surfaces.or(rates);
        found.rubbing_alone = rates.without(others);
        found
    }

    fn all(&self) -> Asked {
        let parts = self.at_impact.iter().chain(&self.at_reset);
        parts.fold(self.followed, |all, &part| all.or(part))
    }
}

/// A reset with whole parts that are those of the numbers in it; none where it takes no whole part.
fn whole_reset(
    corners: &Corners,
    graph: &mut Graph,
    sides: Sides,
    reset: &[Expr],
) -> Option<Vec<Expr>> {
    let lookups = corners.asked(graph, sides, reset).lookups;
    let is_whole = |index: usize| corners.lookups[index].within == LookedUpIn::WholeNumbers;
    let mut all = lookups.members();
    (all.any(is_whole)).then(|| corners.with_whole_parts(graph, sides, reset))
}

fn both(pair: Vec<Expr>) -> [Expr; 2] {
    [pair[0], pair[1]]
}
