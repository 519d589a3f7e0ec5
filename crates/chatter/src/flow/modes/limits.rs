//! Where a mode ends at a corner: functions that are positive while its sides, pieces and sliding hold (MATH.md 9).

use super::closed::Closed;
use super::equations::ModeExprs;
use super::guard::GuardKind;
use crate::expressions::{Asked, Corners, Expr, Graph, Side, Sides};
use crate::model::{Mechanics, OnSides, Rubbing, Slide};

/// A corner that a mode depends on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Corner {
    /// A surface, by number.
    Surface(usize),
    /// A lookup, by number.
    Lookup(usize),
}

impl Corner {
    /// Whether it is a surface.
    pub fn is_surface(self) -> bool {
        matches!(self, Self::Surface(_))
    }
}

/// What a mode asks of one corner.
#[derive(Clone, Debug)]
pub(crate) struct Limit {
    pub corner: Corner,
    /// Positive while the mode holds; each ends it where it vanishes.
    pub guards: Vec<(GuardKind, Expr)>,
    /// Those are the surface, and the motion on this side keeps to it but for rounding of numbers.
    pub is_kept: bool,
    /// What is zero on the corner: the surface, or the argument up to a constant.
    pub surface: Expr,
    /// Its rate, where that must be zero, too, for it to be slid along, half of what that changes faster above than below, and the mean
    /// of both.
    pub rate: Option<[Expr; 3]>,
    /// Where the surface is the squared length of a vector.
    pub vector: Option<Vector>,
}

/// A vector whose direction the field asks for: a, a' = g + C n on its direction n.
#[derive(Clone, Debug)]
pub(crate) struct Vector {
    pub components: Vec<Expr>,
    /// Where it is kept at zero, what is in place of its direction, l = -C^-1 g.
    pub shares: Vec<Expr>,
    /// C, row by row, and what each component of the direction adds to the field.
    pub changes: Vec<Expr>,
    pub directions: Vec<Vec<Expr>>,
}

/// All of them, and where contact forces cease to be determined.
#[derive(Clone, Debug, Default)]
pub(crate) struct Limits {
    pub corners: Vec<Limit>,
    /// Where arguments leave the tables that they are looked up in.
    pub ranges: Vec<(GuardKind, Expr)>,
    /// What impacts at each contact and the reset of each section ask for, and the motion does not.
    pub impacts: Vec<Asked>,
    pub resets: Vec<Asked>,
    /// All of these: surfaces, and arguments.
    pub asked: Vec<(Corner, Expr)>,
    /// Of contacts that slide: what an impulse along friction does to the gap rate.
    pub jams: Vec<(GuardKind, Expr)>,
}

impl Limits {
    pub(crate) fn new(
        mechanics: &mut Mechanics,
        (corners, on_sides): (&Corners, &OnSides),
        (rubbing, closed, sides): (&[Rubbing], Closed, Sides),
        mode: &ModeExprs,
    ) -> Self {
        let mut limits = Self::default();
        let followed = on_sides.followed;
        for index in followed.surfaces.members() {
            let surface = on_sides.surfaces[index];
            let rubs = rubbing.iter().find(|rubbing| rubbing.surface == index);
            let slide = mechanics.slides.iter().find(|s| s.index == index);
            let rate = (slide.cloned()).and_then(|slide| {
                let rate = slide.rate?;
                let jump = mechanics.graph.lie_derivative(rate, &slide.jump);
                let mean = mechanics.graph.lie_derivative(rate, &mechanics.unheld);
                Some([rate, jump, mean])
            });
            let guards = match (sides.get(index), rubs) {
                (Side::Above, _) => vec![(GuardKind::Switch(index), surface)],
                (Side::Below, _) => {
                    vec![(GuardKind::Switch(index), mechanics.graph.neg(surface))]
                }
                (Side::Sliding, Some(rubs)) if closed.contains(rubs.contact) => {
                    cone(mechanics, mode, closed, *rubs)
                }
                (Side::Sliding, Some(_)) => Vec::new(),
                (Side::Sliding, None) if corners.is_disc(index) => {
                    vec![(
                        GuardKind::Leave(index, Side::Above),
                        within(mechanics, index, mode),
                    )]
                }
                (Side::Sliding, None) => {
                    let place = mechanics.slides.iter().position(|s| s.index == index);
                    let share = place.and_then(|place| mode.shares.get(place).copied());
                    share.map_or_else(Vec::new, |share| {
                        between(&mut mechanics.graph, index, share)
                    })
                }
            };
            let is_beside = sides.get(index) != Side::Sliding;
            limits.corners.push(Limit {
                vector: (corners.is_disc(index))
                    .then(|| Vector::new(mechanics, (index, surface), mode))
                    .flatten(),
                corner: Corner::Surface(index),
                guards,
                is_kept: is_beside
                    && mechanics.keeps(surface, &mode.field[..mechanics.field.len()]),
                surface,
                rate,
            });
        }
        for index in followed.lookups.members() {
            let argument = on_sides.arguments[index];
            let [low, high] = corners.ends(&mut mechanics.graph, index, argument);
            limits.corners.push(Limit {
                corner: Corner::Lookup(index),
                guards: vec![
                    (GuardKind::Piece(index, Side::Below), low),
                    (GuardKind::Piece(index, Side::Above), high),
                ],
                is_kept: false,
                surface: argument,
                rate: None,
                vector: None,
            });
            let range = corners.limits(&mut mechanics.graph, index, argument);
            let sides = [Side::Below, Side::Above].map(|side| GuardKind::Outside(index, side));
            (limits.ranges).extend(sides.into_iter().zip(range.into_iter().flatten()));
        }
        let beside = |asked: &Asked| asked.without(followed);
        limits.impacts = on_sides.at_impact.iter().map(beside).collect();
        limits.resets = on_sides.at_reset.iter().map(beside).collect();
        let only_asked = on_sides.active.without(followed);
        let surfaces = only_asked.surfaces.members();
        let surfaces = surfaces.map(|index| (Corner::Surface(index), on_sides.surfaces[index]));
        let lookups = only_asked.lookups.members();
        let lookups = lookups.map(|index| (Corner::Lookup(index), on_sides.arguments[index]));
        limits.asked = surfaces.chain(lookups).collect();
        for rubbing in rubbing {
            let slides = sides.get(rubbing.surface) != Side::Sliding;
            if closed.contains(rubbing.contact) && slides {
                let room = mechanics.room(rubbing.contact);
                limits.jams.push((GuardKind::Jam(rubbing.contact), room));
            }
        }
        limits
    }

    /// All guards.
    pub(crate) fn guards(&self) -> impl Iterator<Item = (GuardKind, Expr)> {
        let corners = self.corners.iter().flat_map(|limit| &limit.guards);
        corners.chain(&self.ranges).chain(&self.jams).copied()
    }
}

impl OnSides {
    /// What is positive while these corners are on the sides and pieces where they are.
    pub(crate) fn guards_of(
        &self,
        graph: &mut Graph,
        (corners, sides): (&Corners, Sides),
        asked: Asked,
    ) -> Vec<(GuardKind, Expr)> {
        let surface = |graph: &mut Graph, index: usize| {
            let surface = self.surfaces[index];
            let guard = match sides.get(index) {
                Side::Below => graph.neg(surface),
                Side::Above | Side::Sliding => surface,
            };
            (GuardKind::Switch(index), guard)
        };
        let mut guards: Vec<(GuardKind, Expr)> = (asked.surfaces.members())
            .map(|index| surface(graph, index))
            .collect();
        for index in asked.lookups.members() {
            let ends = corners.ends(graph, index, self.arguments[index]);
            let sides = [Side::Below, Side::Above].map(|side| GuardKind::Piece(index, side));
            guards.extend(sides.into_iter().zip(ends));
        }
        guards
    }
}

impl Vector {
    fn new(
        mechanics: &mut Mechanics,
        (index, square): (usize, Expr),
        mode: &ModeExprs,
    ) -> Option<Self> {
        let disc = mechanics.graph.disc_of(square)?;
        let components = disc.components(&mut mechanics.graph);
        let own = |slide: &&Slide| slide.index == index;
        let directions: Vec<Vec<Expr>> = (mechanics.slides.iter().filter(own))
            .map(|slide| slide.jump.clone())
            .collect();
        let shares = shares_of(mechanics, index, mode);
        let changes = (components.iter())
            .flat_map(|&component| directions.iter().map(move |jump| (component, jump)))
            .map(|(component, jump)| mechanics.graph.lie_derivative(component, jump))
            .collect();
        Some(Self {
            components,
            shares,
            changes,
            directions,
        })
    }
}

/// What is in place of the components of the direction of a vector that is kept at zero.
fn shares_of(mechanics: &Mechanics, index: usize, mode: &ModeExprs) -> Vec<Expr> {
    (mechanics.slides.iter().zip(&mode.shares))
        .filter(|(slide, _)| slide.index == index)
        .map(|(_, &share)| share)
        .collect()
}

/// A vector is kept at zero while what is in place of its direction lies within the unit disc.
fn within(mechanics: &mut Mechanics, index: usize, mode: &ModeExprs) -> Expr {
    let shares = shares_of(mechanics, index, mode);
    let graph = &mut mechanics.graph;
    let (one, two) = (graph.number(1.0), graph.number(2.0));
    let squares: Vec<Expr> = shares
        .iter()
        .map(|&share| graph.power(share, two))
        .collect();
    let square = graph.sum(&squares);
    graph.sub(one, square)
}

/// Sliding goes on while each field has a part in it.
fn between(graph: &mut Graph, index: usize, share: Expr) -> Vec<(GuardKind, Expr)> {
    let one = graph.number(1.0);
    vec![
        (GuardKind::Leave(index, Side::Above), graph.sub(one, share)),
        (GuardKind::Leave(index, Side::Below), graph.add(one, share)),
    ]
}

/// Sticking goes on while the friction force lies within its cone, together with that of contacts that stick beside it. At its
/// positive edge the contact begins to slide backwards.
fn cone(
    mechanics: &mut Mechanics,
    mode: &ModeExprs,
    closed: Closed,
    rubs: Rubbing,
) -> Vec<(GuardKind, Expr)> {
    let stick = mechanics.sticks.iter().find(|s| s.contact == rubs.contact);
    let force = (mode.frictions.iter()).find(|(contact, _)| *contact == rubs.contact);
    let (Some(stick), Some(&(_, force))) = (stick.cloned(), force) else {
        return Vec::new();
    };
    let mut limits = Vec::new();
    for (place, contact) in closed.contacts().enumerate() {
        let own = mechanics.sticks.iter().find(|s| s.contact == contact);
        let Some(own) = own.filter(|own| own.is_beside(&stick)) else {
            continue;
        };
        let coefficient = own.coefficient;
        let room = mechanics.contacts[contact].rate_per_impulse;
        let graph = &mut mechanics.graph;
        let normal = graph.div(mode.reactions[place], room);
        let limit = graph.mul(coefficient, normal);
        limits.push(graph.neg(limit));
    }
    let graph = &mut mechanics.graph;
    let limit = graph.sum(&limits);
    vec![
        (
            GuardKind::Leave(rubs.surface, Side::Above),
            graph.add(limit, force),
        ),
        (
            GuardKind::Leave(rubs.surface, Side::Below),
            graph.sub(limit, force),
        ),
    ]
}
