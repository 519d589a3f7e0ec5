//! The corners of a set of expressions: surfaces whose sign chooses between pieces, and arguments that are looked up in
//! curves or rounded down. Which piece holds is data; given that, expressions are smooth.

use super::graph::piecewise::{CurveId, Edge, floor};
use super::graph::{Expr, Graph, Node};
use crate::numerics::{DoubleDouble, Real};
use rustc_hash::{FxBuildHasher, FxHashMap};
use serde::{Deserialize, Serialize};

/// Where a state stands to a surface.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Serialize, Deserialize)]
pub enum Side {
    /// Where the surface's function is positive.
    Above,
    /// Where it is negative.
    Below,
    /// On it, held there by the fields of both sides.
    Sliding,
}

impl Side {
    /// 1 above, -1 below, 0 on the surface.
    pub fn sign(self) -> f64 {
        match self {
            Self::Above => 1.0,
            Self::Below => -1.0,
            Self::Sliding => 0.0,
        }
    }
}

/// The side of every surface.
#[derive(
    Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug, Default, Serialize, Deserialize,
)]
pub struct Sides(u128);

impl Sides {
    /// How many surfaces can be told apart.
    pub const MOST: usize = 64;

    /// The side of a surface.
    pub fn get(self, surface: usize) -> Side {
        match self.0 >> (2 * surface) & 3 {
            0 => Side::Above,
            1 => Side::Below,
            _ => Side::Sliding,
        }
    }

    /// The same but for one surface.
    #[must_use]
    pub fn with(self, surface: usize, side: Side) -> Self {
        let bits = match side {
            Side::Above => 0,
            Side::Below => 1,
            Side::Sliding => 2,
        };
        Self(self.0 & !(3 << (2 * surface)) | bits << (2 * surface))
    }

    /// Whether the surfaces of a set are on the same sides.
    pub fn agree(self, other: Self, surfaces: Surfaces) -> bool {
        let mut rest = surfaces.0;
        let mut mask = 0_u128;
        while rest != 0 {
            mask |= 3 << (2 * rest.trailing_zeros());
            rest &= rest - 1;
        }
        (self.0 ^ other.0) & mask == 0
    }
}

/// A set of surfaces, or of lookups.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug, Default)]
pub struct Surfaces(u64);

impl Surfaces {
    /// The first so many.
    pub fn all(count: usize) -> Self {
        Self((0..count.min(64)).fold(0, |bits, k| bits | 1 << k))
    }

    /// The set with one more.
    #[must_use]
    pub fn with(self, surface: usize) -> Self {
        Self(self.0 | 1 << surface)
    }

    /// What is in either set.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// What is not in the other set.
    #[must_use]
    pub fn without(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }

    /// Whether it is in the set.
    pub fn contains(self, surface: usize) -> bool {
        self.0 >> surface & 1 == 1
    }

    /// Its members, ascending.
    pub fn members(self) -> impl Iterator<Item = usize> {
        let mut rest = self.0;
        core::iter::from_fn(move || {
            let first = (rest != 0).then(|| rest.trailing_zeros() as usize)?;
            rest &= rest - 1;
            Some(first)
        })
    }
}

/// Surfaces, and lookups, that expressions depend on.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Asked {
    /// The surfaces on whose side they depend.
    pub surfaces: Surfaces,
    /// The lookups in them.
    pub lookups: Surfaces,
}

impl Asked {
    /// What is in either.
    #[must_use]
    pub fn or(self, other: Self) -> Self {
        Self {
            surfaces: self.surfaces.or(other.surfaces),
            lookups: self.lookups.or(other.lookups),
        }
    }

    /// What is not in the other.
    #[must_use]
    pub fn without(self, other: Self) -> Self {
        Self {
            surfaces: self.surfaces.without(other.surfaces),
            lookups: self.lookups.without(other.lookups),
        }
    }

    /// Whether there is nothing.
    pub fn is_empty(self) -> bool {
        self == Self::default()
    }
}

/// What an argument is looked up in.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub enum LookedUpIn {
    /// The whole numbers: the argument is rounded down.
    WholeNumbers,
    /// A curve.
    Curve(CurveId),
}

/// An argument that is looked up: on each piece the result is a polynomial, whose coefficients are parameters of the mode.
#[derive(Clone, Copy, PartialEq, Eq, Hash, Debug)]
pub struct Lookup {
    /// The argument, as it was written.
    pub argument: Expr,
    /// In what.
    pub within: LookedUpIn,
}

/// Parameters of a lookup: where its piece begins and ends, where its polynomial is centred, and the coefficients.
pub const LOOKUP_SLOTS: usize = 7;

/// A piece without end goes on this far.
const ENDLESS: f64 = 1e200;

/// An argument is within a table that it leaves by no more than this part of its largest knot: as a start may be inside an
/// obstacle, since states are stored and typed with twelve digits and more. So an impact at the end of a table, and what rests
/// there, is within it.
pub(crate) const BESIDE: f64 = 1e-12;

/// All corners that a set of expressions may have.
#[derive(Clone, Debug, Default)]
pub struct Corners {
    /// The functions whose sign chooses, as they were written.
    pub surfaces: Vec<Expr>,
    /// For each of them what holds where it is exactly zero, by the first choice that asks for it.
    edges: Vec<Edge>,
    /// The numbers of those that are the squared length of a vector whose direction is asked for. Nothing is below them.
    discs: Surfaces,
    /// What is looked up.
    pub lookups: Vec<Lookup>,
    /// The number of the first parameter of the first lookup.
    pub first_slot: usize,
}

/// Expressions on one side of every surface.
#[derive(Clone, Debug)]
pub struct Smooth {
    /// The expressions, in order.
    pub exprs: Vec<Expr>,
    /// The surfaces on whose side they depend.
    pub surfaces: Surfaces,
    /// The lookups in them.
    pub lookups: Surfaces,
}

/// What becomes of an argument that is rounded down.
#[derive(Clone, Copy, PartialEq, Eq)]
enum WholeNumbers {
    LookedUp,
    Evaluated,
}

/// Which sides are taken of a surface that is slid along.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Slid {
    Above,
    Both,
}

impl Corners {
    /// The corners of all expressions that `roots` are made of. The parameters of lookups come after `parameters` others.
    pub fn of(graph: &Graph, roots: &[Expr], parameters: usize) -> Self {
        let parts = graph.reachable(roots);
        let moves = graph.depend_on_state(&parts);
        let mut corners = Self {
            first_slot: parameters,
            ..Self::default()
        };
        for (&part, _) in parts.iter().zip(moves).filter(|&(_, moves)| moves) {
            match *graph.node(part) {
                Node::Switch { surface, edge, .. } if !corners.surfaces.contains(&surface) => {
                    corners.surfaces.push(surface);
                    corners.edges.push(edge);
                }
                Node::Floor(_) | Node::Curve(..) => {
                    if let Some(lookup) = lookup(graph, part)
                        && !corners.lookups.contains(&lookup)
                    {
                        corners.lookups.push(lookup);
                    }
                }
                _ => {}
            }
        }
        corners
    }

    /// One more surface, that nothing in the expressions chooses by; returns its number.
    pub fn add(&mut self, surface: Expr) -> usize {
        self.surfaces.push(surface);
        self.edges.push(Edge::Above);
        self.surfaces.len() - 1
    }

    /// One more surface, the squared length of a vector whose direction is asked for.
    pub fn add_disc(&mut self, square: Expr) {
        let index = self.add(square);
        self.discs = self.discs.with(index);
    }

    /// Whether a surface is the squared length of a vector whose direction is asked for: where that vanishes it may be kept at zero by
    /// what any direction does, and else is positive.
    pub fn is_disc(&self, surface: usize) -> bool {
        self.discs.contains(surface)
    }

    /// Whether a surface has corners itself, where it may jump.
    pub fn is_nested(&self, graph: &Graph, surface: usize) -> bool {
        graph.has_corner(&[self.surfaces[surface]])
    }

    /// Whether there is none.
    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        self.surfaces.is_empty() && self.lookups.is_empty()
    }

    /// How many parameters lookups add to those of the model.
    pub fn slots(&self) -> usize {
        self.lookups.len() * LOOKUP_SLOTS
    }

    /// The expressions on the given side of each surface, lookups as polynomials. Of a surface that is slid on the side
    /// above is taken.
    pub fn smooth(&self, graph: &mut Graph, sides: Sides, exprs: &[Expr]) -> Smooth {
        self.on_sides(graph, sides, (exprs, WholeNumbers::LookedUp))
    }

    /// The same, but that whole parts are those of the numbers that they are taken of.
    pub fn with_whole_parts(&self, graph: &mut Graph, sides: Sides, exprs: &[Expr]) -> Vec<Expr> {
        self.on_sides(graph, sides, (exprs, WholeNumbers::Evaluated))
            .exprs
    }

    fn on_sides(
        &self,
        graph: &mut Graph,
        sides: Sides,
        (exprs, whole_numbers): (&[Expr], WholeNumbers),
    ) -> Smooth {
        let mut found = Smooth {
            exprs: Vec::with_capacity(exprs.len()),
            surfaces: Surfaces::default(),
            lookups: Surfaces::default(),
        };
        if self.is_empty() {
            found.exprs.extend_from_slice(exprs);
            return found;
        }
        let parts = graph.reachable(exprs);
        let moves = graph.depend_on_state(&parts);
        let (needed, surfaces) = self.needed(graph, sides, (exprs, &parts, &moves), Slid::Above);
        found.surfaces = surfaces;
        let mut known: FxHashMap<Expr, Expr> =
            FxHashMap::with_capacity_and_hasher(parts.len(), FxBuildHasher);
        for (&part, &moves) in parts.iter().zip(&moves) {
            if !needed[&part] {
                continue;
            }
            let of = |part: &Expr| known.get(part).copied().unwrap_or(*part);
            let smooth = match graph.node(part).clone() {
                _ if !moves => part,
                Node::Number(_) | Node::Pi | Node::Symbol(_) => part,
                Node::Sum(terms) => {
                    let terms: Vec<Expr> = terms.iter().map(of).collect();
                    graph.sum(&terms)
                }
                Node::Product(factors) => {
                    let factors: Vec<Expr> = factors.iter().map(of).collect();
                    graph.product(&factors)
                }
                Node::Power(base, exponent) => graph.power(of(&base), of(&exponent)),
                Node::Call(function, argument) => graph.call(function, of(&argument)),
                Node::Switch {
                    surface,
                    above,
                    below,
                    ..
                } => {
                    let index = self.surface(surface);
                    match index.map(|index| sides.get(index)) {
                        Some(Side::Below) => of(&below),
                        _ => of(&above),
                    }
                }
                Node::Floor(argument) if whole_numbers == WholeNumbers::Evaluated => {
                    graph.floor(of(&argument))
                }
                Node::Floor(argument) => {
                    self.piece(graph, part, of(&argument), 0, &mut found.lookups)
                }
                Node::Curve(_, argument, derivative) => {
                    self.piece(graph, part, of(&argument), derivative, &mut found.lookups)
                }
            };
            known.insert(part, smooth);
        }
        found.exprs.extend(exprs.iter().map(|expr| known[expr]));
        found
    }

    /// Which parts of expressions are needed on the given sides, from the outside in: of a choice only the piece that holds, and of one
    /// whose surface is slid along what is asked for. With the surfaces that choose.
    fn needed(
        &self,
        graph: &Graph,
        sides: Sides,
        (exprs, parts, moves): (&[Expr], &[Expr], &[bool]),
        slid: Slid,
    ) -> (FxHashMap<Expr, bool>, Surfaces) {
        let mut surfaces = Surfaces::default();
        let mut needed: FxHashMap<Expr, bool> = parts.iter().map(|&part| (part, false)).collect();
        for expr in exprs {
            needed.insert(*expr, true);
        }
        for (&part, &moves) in parts.iter().zip(moves).rev() {
            if !needed[&part] {
                continue;
            }
            if moves
                && self.discs != Surfaces::default()
                && let Some((square, _)) = graph.inverse_root(part)
                && let Some(index) = self.surface(square)
                && self.is_disc(index)
            {
                surfaces = surfaces.with(index);
            }
            match (moves, graph.node(part)) {
                (
                    true,
                    &Node::Switch {
                        surface,
                        above,
                        below,
                        ..
                    },
                ) => {
                    if let Some(index) = self.surface(surface) {
                        surfaces = surfaces.with(index);
                        let (is_above, is_below) = match (sides.get(index), slid) {
                            (Side::Above, _) | (Side::Sliding, Slid::Above) => (true, false),
                            (Side::Below, _) => (false, true),
                            (Side::Sliding, Slid::Both) => (true, true),
                        };
                        if is_above {
                            needed.insert(above, true);
                        }
                        if is_below {
                            needed.insert(below, true);
                        }
                    }
                }
                _ => graph.for_each_operand(part, |operand| {
                    needed.insert(operand, true);
                }),
            }
        }
        (needed, surfaces)
    }

    /// What expressions depend on, on the given sides, and what that depends on in turn. Motion that slides along a surface depends on
    /// both sides of it.
    pub fn asked(&self, graph: &Graph, sides: Sides, exprs: &[Expr]) -> Asked {
        let (mut asked, mut exprs) = (Asked::default(), exprs.to_vec());
        while !(self.is_empty() || exprs.is_empty()) {
            let parts = graph.reachable(&exprs);
            let moves = graph.depend_on_state(&parts);
            let (needed, surfaces) =
                self.needed(graph, sides, (&exprs, &parts, &moves), Slid::Both);
            let mut found = Asked {
                surfaces,
                ..Asked::default()
            };
            for (&part, _) in parts
                .iter()
                .zip(&moves)
                .filter(|&(part, &moves)| moves && needed[part])
            {
                let place = lookup(graph, part)
                    .and_then(|lookup| self.lookups.iter().position(|&known| known == lookup));
                if let Some(index) = place {
                    found.lookups = found.lookups.with(index);
                }
            }
            let more = found.without(asked);
            asked = asked.or(found);
            exprs = (more.surfaces.members().map(|index| self.surfaces[index]))
                .chain(
                    more.lookups
                        .members()
                        .map(|index| self.lookups[index].argument),
                )
                .collect();
        }
        asked
    }

    /// The number of a surface.
    pub fn surface(&self, surface: Expr) -> Option<usize> {
        self.surfaces.iter().position(|&known| known == surface)
    }

    /// The polynomial of a lookup's piece, or a derivative of it.
    fn piece(
        &self,
        graph: &mut Graph,
        part: Expr,
        argument: Expr,
        derivative: u8,
        used: &mut Surfaces,
    ) -> Expr {
        let Some(index) = lookup(graph, part)
            .and_then(|lookup| self.lookups.iter().position(|&known| known == lookup))
        else {
            return part;
        };
        *used = used.with(index);
        let degree = match self.lookups[index].within {
            LookedUpIn::WholeNumbers => 0,
            LookedUpIn::Curve(id) => graph.curve(id).degree(),
        };
        let first = self.first_slot + index * LOOKUP_SLOTS;
        let origin = graph.parameter(first + 2);
        let along = graph.sub(argument, origin);
        let mut terms = vec![graph.number(0.0)];
        for k in usize::from(derivative)..=degree {
            let falling = (0..usize::from(derivative)).map(|i| (k - i) as f64);
            let factor = graph.number(falling.product());
            let coefficient = graph.parameter(first + 3 + k);
            let exponent = graph.number((k - usize::from(derivative)) as f64);
            let power = graph.power(along, exponent);
            terms.push(graph.product(&[factor, coefficient, power]));
        }
        graph.sum(&terms)
    }

    /// Where the pieces of a lookup end, as functions that are positive within: of its lower and its upper end.
    pub fn ends(&self, graph: &mut Graph, index: usize, argument: Expr) -> [Expr; 2] {
        let first = self.first_slot + index * LOOKUP_SLOTS;
        let (low, high) = (graph.parameter(first), graph.parameter(first + 1));
        [graph.sub(argument, low), graph.sub(high, argument)]
    }

    /// The arguments that a lookup has a value for, and how far beyond them its first and last piece go on; none where they have
    /// no end.
    pub fn bounds(&self, graph: &Graph, index: usize) -> Option<([DoubleDouble; 2], f64)> {
        let LookedUpIn::Curve(id) = self.lookups[index].within else {
            return None;
        };
        let bounds = graph.curve(id).bounds()?;
        let size = |end: DoubleDouble| end.high().abs();
        Some((bounds, BESIDE * size(bounds[0]).max(size(bounds[1]))))
    }

    /// Where an argument leaves what it is looked up in, as functions that are positive within: of the lower and the upper end;
    /// none where there is no end. Pieces do not end there: nothing follows.
    pub fn limits(&self, graph: &mut Graph, index: usize, argument: Expr) -> Option<[Expr; 2]> {
        let ([first, last], beside) = self.bounds(graph, index)?;
        let beside = DoubleDouble::from(beside);
        let (low, high) = (
            graph.number_exact(first - beside),
            graph.number_exact(last + beside),
        );
        Some([graph.sub(argument, low), graph.sub(high, argument)])
    }

    /// The side of every surface, and the piece of every lookup, by the values at a state.
    pub fn at<R: Real>(&self, graph: &Graph, states: &[R], parameters: &[R]) -> (Sides, Vec<i64>) {
        let surfaces = graph.evaluate_all(&self.surfaces, states, parameters);
        let mut sides = Sides::default();
        for (index, &value) in surfaces.iter().enumerate() {
            sides = sides.with(index, self.side_at(index, value));
        }
        let arguments: Vec<Expr> = self.lookups.iter().map(|lookup| lookup.argument).collect();
        let arguments = graph.evaluate_all(&arguments, states, parameters);
        let pieces = (arguments.iter().enumerate())
            .map(|(index, &argument)| self.piece_at(graph, index, argument.to_double_double()))
            .collect();
        (sides, pieces)
    }

    /// The side of a surface on which plain evaluation is where its function has this value.
    pub fn side_at<R: Real>(&self, index: usize, value: R) -> Side {
        let on_it = value == R::ZERO && self.edges[index] == Edge::Below;
        if value < R::ZERO || on_it {
            Side::Below
        } else {
            Side::Above
        }
    }

    /// The piece of a lookup that holds a value of its argument; beyond the end of a table the one next to it.
    pub fn piece_at(&self, graph: &Graph, index: usize, value: DoubleDouble) -> i64 {
        match self.lookups[index].within {
            LookedUpIn::WholeNumbers => floor(value).to_f64() as i64,
            LookedUpIn::Curve(id) => {
                let curve = graph.curve(id);
                let piece = curve.piece_at(value);
                match curve.bounds() {
                    Some([_, last]) => piece.clamp(0, curve.piece_at(last)),
                    None => piece,
                }
            }
        }
    }

    /// The parameters of a piece of a lookup; none where there is none.
    pub fn slots_of<R: Real>(&self, graph: &Graph, index: usize, piece: i64) -> Option<Vec<R>> {
        let wide = |value: DoubleDouble| R::from_double_double(value);
        match self.lookups[index].within {
            LookedUpIn::WholeNumbers => {
                let low = R::splat(piece as f64);
                let zero = R::ZERO;
                Some(vec![low, low + R::ONE, zero, low, zero, zero, zero])
            }
            LookedUpIn::Curve(id) => {
                let curve = graph.curve(id);
                let piece = curve.piece(piece)?;
                let is_bound = |end: &DoubleDouble| curve.bounds().is_some_and(|b| b.contains(end));
                let end = |end: Option<DoubleDouble>, far: f64| {
                    (end.filter(|end| !is_bound(end))).map_or(R::splat(far), wide)
                };
                let mut slots = vec![
                    end(piece.low, -ENDLESS),
                    end(piece.high, ENDLESS),
                    wide(piece.origin),
                ];
                slots.extend(piece.coefficients.iter().map(|&c| wide(c)));
                Some(slots)
            }
        }
    }
}

fn lookup(graph: &Graph, part: Expr) -> Option<Lookup> {
    match *graph.node(part) {
        Node::Floor(argument) => Some(Lookup {
            argument,
            within: LookedUpIn::WholeNumbers,
        }),
        Node::Curve(id, argument, _) => Some(Lookup {
            argument,
            within: LookedUpIn::Curve(id),
        }),
        _ => None,
    }
}
