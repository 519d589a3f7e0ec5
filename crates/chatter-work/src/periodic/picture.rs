//! A picture of branches: stable thick, others thin, special points marked.

use super::{Beneath, Subject};
use crate::diagram::picture::axis;
use chatter::analysis::periodic::{Branch, Point, SpecialKind};
use chatter_figures::{Axis, Color, Figure, Line, Marker, Markers, Panel};

/// Line widths in points.
const THICK: f64 = 1.1;
const THIN: f64 = 0.45;
/// How orbits of one stability are named and drawn: with this colour and width.
type Style = (&'static str, Color, f64);
const STABLE: Style = ("stable", Color::BLUE, THICK);
const NEUTRAL: Style = ("neutral", Color::BLUE, THIN);
const UNSTABLE: Style = ("unstable", Color::GREY, THIN);
/// Size of marks in points.
const MARK: f64 = 3.2;
/// In millimetres.
const WIDTH: f64 = 120.0;
const HEIGHT: f64 = 80.0;

/// What is drawn over the parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Vertical {
    /// A state at the section.
    State(usize),
    /// The period.
    Period,
}

fn mark(kind: SpecialKind) -> (Marker, Color, &'static str) {
    match kind {
        SpecialKind::Fold => (Marker::Diamond, Color::VERMILION, "fold"),
        SpecialKind::PeriodDoubling => (Marker::Diamond, Color::GREEN, "period doubling"),
        SpecialKind::NeimarkSacker => (Marker::Triangle, Color::PURPLE, "Neimark\u{2013}Sacker"),
        SpecialKind::Hopf => (Marker::Triangle, Color::VERMILION, "Hopf"),
        SpecialKind::BranchPoint => (Marker::Plus, Color::INK, "branch point"),
        SpecialKind::ImpactGraze | SpecialKind::FlightGraze => {
            (Marker::Circle, Color::BLUE, "graze")
        }
        SpecialKind::ChatterBorder => (Marker::Square, Color::ORANGE, "chatter border"),
        SpecialKind::Touch => (Marker::Cross, Color::GREY, "touch"),
        SpecialKind::Monitor => (Marker::Cross, Color::INK, "monitor"),
        SpecialKind::Cusp => (Marker::Disc, Color::INK, "cusp"),
        SpecialKind::FoldFlip => (Marker::Diamond, Color::INK, "fold-flip"),
        SpecialKind::GeneralisedDoubling => {
            (Marker::Diamond, Color::ORANGE, "generalised doubling")
        }
        SpecialKind::Resonance11 => (Marker::Square, Color::INK, "1:1"),
        SpecialKind::Resonance12 => (Marker::Square, Color::GREY, "1:2"),
        SpecialKind::Resonance13 => (Marker::Triangle, Color::INK, "1:3"),
        SpecialKind::Resonance14 => (Marker::Triangle, Color::GREY, "1:4"),
        SpecialKind::FoldTorus => (Marker::Plus, Color::PURPLE, "fold and torus"),
        SpecialKind::FlipTorus => (Marker::Plus, Color::GREEN, "flip and torus"),
        SpecialKind::GrazeFold => (Marker::Circle, Color::VERMILION, "graze and fold"),
        SpecialKind::GrazeDoubling => (Marker::Circle, Color::GREEN, "graze and doubling"),
        SpecialKind::GrazeTorus => (Marker::Circle, Color::PURPLE, "graze and torus"),
        SpecialKind::DoubleGraze => (Marker::Circle, Color::INK, "double graze"),
        SpecialKind::BorderFold => (Marker::Square, Color::VERMILION, "border and fold"),
        SpecialKind::BorderDoubling => (Marker::Square, Color::GREEN, "border and doubling"),
    }
}

/// The state that is drawn unless another is asked for: the first that changes along the branches.
pub fn first_that_changes(subject: &Subject, branches: &[Branch]) -> Vertical {
    let points = || branches.iter().flat_map(|branch| &branch.points);
    let states = 0..subject.model.states.len();
    let mut changing = states.filter(|&index| {
        let values = || points().map(|point| point.state[index]);
        let low = values().fold(f64::INFINITY, f64::min);
        let high = values().fold(f64::NEG_INFINITY, f64::max);
        Some(index) != subject.model.time && high - low > 1e-9 * low.abs().max(high.abs())
    });
    changing.next().map_or(Vertical::Period, Vertical::State)
}

/// A special point lies between two stations if the way past it is no more than this many times the straight one: folds lie beyond both.
const MOST_DETOUR: f64 = 2.0;

/// The figure, over a diagram where there is one.
pub fn picture(
    subject: &Subject,
    branches: &[Branch],
    vertical: Vertical,
    beneath: Option<Beneath>,
) -> Figure {
    let value = |point: &Point| match vertical {
        Vertical::State(index) => point.state[index],
        Vertical::Period => point.period,
    };
    let name = subject.names().last().copied().unwrap_or_default();
    let y = match vertical {
        Vertical::State(index) => axis(subject.model, &subject.model.states[index].name),
        Vertical::Period => Axis::new("period"),
    };
    let mut panel = match beneath {
        Some(beneath) => beneath.panel,
        None => Panel::new(axis(subject.model, name), y),
    };
    let mut told: Vec<&str> = Vec::new();
    for branch in branches {
        for ((label, color, width), run) in runs(branch, &|point| (point.parameter(), value(point)))
        {
            let (x, y) = run
                .iter()
                .map(|point| (point.parameter(), value(point)))
                .unzip();
            let line = Line::new(x, y).color(color).width(width);
            panel.add(if told.contains(&label) {
                line
            } else {
                line.label(label)
            });
            told.push(label);
        }
    }
    add_marks(&mut panel, branches, &|point| {
        (point.parameter(), value(point))
    });
    Figure::from(panel).width(WIDTH).height(HEIGHT)
}

/// Curves of special points in the plane of both parameters, over a map where there is one.
pub fn plane(
    subject: &Subject,
    curves: &[(SpecialKind, Branch)],
    beneath: Option<Beneath>,
) -> Figure {
    let turned = beneath.as_ref().is_some_and(|beneath| beneath.turned);
    let place = |point: &Point| match point.parameters[..] {
        [one, two] if turned => (one, two),
        [one, two] => (two, one),
        _ => (point.parameter(), f64::NAN),
    };
    let names = subject.names();
    let label = |index: usize| axis(subject.model, names.get(index).copied().unwrap_or_default());
    let mut panel = match beneath {
        Some(beneath) => beneath.panel,
        None => Panel::new(label(1), label(0)),
    };
    let mut told: Vec<&str> = Vec::new();
    for (kind, curve) in curves {
        let (_, color, label) = mark(*kind);
        let (x, y) = curve.points.iter().map(place).unzip();
        let line = Line::new(x, y).color(color).width(THICK);
        // One entry for all curves of a kind.
        panel.add(if told.contains(&label) {
            line
        } else {
            line.label(label)
        });
        told.push(label);
    }
    let branches: Vec<Branch> = curves.iter().map(|(_, curve)| curve.clone()).collect();
    add_marks(&mut panel, &branches, &place);
    Figure::from(panel).width(WIDTH).height(HEIGHT)
}

/// Special points, each kind with a mark of its own in the legend.
fn add_marks(panel: &mut Panel, branches: &[Branch], place: &dyn Fn(&Point) -> (f64, f64)) {
    let mut kinds: Vec<(Marker, Color, &str)> = Vec::new();
    for special in branches.iter().flat_map(|branch| &branch.special) {
        let mark = mark(special.kind);
        if !kinds.contains(&mark) {
            kinds.push(mark);
        }
    }
    for known in kinds {
        let (x, y) = (branches.iter().flat_map(|branch| &branch.special))
            .filter(|special| mark(special.kind) == known)
            .map(|special| place(&special.point))
            .unzip();
        let (marker, color, label) = known;
        let marks = Markers::new(x, y).marker(marker).color(color);
        panel.add(marks.size(MARK).label(label));
    }
}

/// Stretches of one stability. Each ends where the next begins: at the special point that lies between, where there is one.
fn runs<'b>(
    branch: &'b Branch,
    place: &dyn Fn(&Point) -> (f64, f64),
) -> Vec<(Style, Vec<&'b Point>)> {
    let places: Vec<(f64, f64)> = branch.points.iter().map(place).collect();
    let extent = |of: &dyn Fn(&(f64, f64)) -> f64| {
        let low = places.iter().map(of).fold(f64::INFINITY, f64::min);
        let high = places.iter().map(of).fold(f64::NEG_INFINITY, f64::max);
        if high > low { high - low } else { 1.0 }
    };
    let (width, height) = (extent(&|place| place.0), extent(&|place| place.1));
    let apart = |a: (f64, f64), b: (f64, f64)| ((a.0 - b.0) / width).hypot((a.1 - b.1) / height);
    let between = |a: &'b Point, b: &'b Point| {
        let (from, to) = (place(a), place(b));
        let way = |point: &Point| apart(from, place(point)) + apart(place(point), to);
        let nearest = (branch.special.iter().map(|special| &special.point))
            .min_by(|a, b| way(a).total_cmp(&way(b)));
        nearest
            .filter(|point| way(point) <= MOST_DETOUR * apart(from, to))
            .unwrap_or(b)
    };
    let mut runs: Vec<(Style, Vec<&Point>)> = Vec::new();
    for point in &branch.points {
        let style = match (point.is_stable(), point.is_neutral()) {
            (true, _) => STABLE,
            (_, true) => NEUTRAL,
            _ => UNSTABLE,
        };
        match runs.last_mut() {
            Some((known, run)) if *known == style => run.push(point),
            Some((_, run)) => {
                let change = run.last().map_or(point, |before| between(before, point));
                run.push(change);
                runs.push((style, vec![change, point]));
            }
            None => runs.push((style, vec![point])),
        }
    }
    runs
}
