//! Functions that change their sign at points of codimension two, by the kind of curve.

use crate::analysis::continuation::{Problem, Station};
use crate::analysis::periodic::aside::shift;
use crate::analysis::periodic::branch::SpecialKind;
use crate::analysis::periodic::condition::Bordered;
use crate::analysis::periodic::multipliers::{neutral, pair, passes, without_nearest};
use crate::analysis::periodic::shooting::Shooting;
use crate::numerics::Complex;

/// A kind of point, and what changes its sign there; none where that has no value.
pub(super) type Test = (SpecialKind, Option<f64>);

/// What the functions are of: an orbit on a curve, its multipliers, without the impact that grazes, and where the curve came from.
pub(super) struct Place<'p> {
    pub shooting: &'p Shooting<f64>,
    pub station: &'p Station,
    pub multipliers: &'p [Complex],
    pub bordered: &'p Bordered,
    pub from: &'p Station,
}

/// All functions of a kind of curve.
pub(super) fn tests(kind: SpecialKind, place: &Place<'_>) -> Vec<Test> {
    let all = place.multipliers;
    match kind {
        SpecialKind::Fold => {
            let others = without_nearest(all, 1.0);
            vec![
                (SpecialKind::Cusp, Some(along(place))),
                (SpecialKind::FoldFlip, passes(&others, -1.0)),
                (SpecialKind::Resonance11, passes(&others, 1.0)),
                (SpecialKind::FoldTorus, pair(&others)),
            ]
        }
        SpecialKind::PeriodDoubling => {
            let others = without_nearest(all, -1.0);
            vec![
                (SpecialKind::GeneralisedDoubling, side(place)),
                (SpecialKind::FoldFlip, passes(&others, 1.0)),
                (SpecialKind::Resonance12, passes(&others, -1.0)),
                (SpecialKind::FlipTorus, pair(&others)),
            ]
        }
        SpecialKind::FlightGraze | SpecialKind::ImpactGraze => vec![
            (SpecialKind::GrazeFold, passes(all, 1.0)),
            (SpecialKind::GrazeDoubling, passes(all, -1.0)),
            (SpecialKind::GrazeTorus, pair(all)),
        ],
        SpecialKind::NeimarkSacker => {
            let Some((_, sum, others)) = neutral(all) else {
                return Vec::new();
            };
            vec![
                (SpecialKind::Resonance11, Some(2.0 - sum)),
                (SpecialKind::Resonance12, Some(2.0 + sum)),
                (SpecialKind::Resonance13, Some(1.0 + sum)),
                (SpecialKind::Resonance14, Some(sum)),
                (SpecialKind::FoldTorus, passes(&others, 1.0)),
                (SpecialKind::FlipTorus, passes(&others, -1.0)),
            ]
        }
        _ => Vec::new(),
    }
}

/// Multipliers are this near to where they have to be at a point of codimension two; a pair that is one is known to the root of
/// rounding.
const NEAR: f64 = 1e-2;

/// Whether an orbit has the multipliers that the name of such a point says. Where a function of them has a pole, as at a graze,
/// it changes its sign, too.
pub(super) fn has_multipliers(kind: SpecialKind, multipliers: &[Complex]) -> bool {
    let third = core::f64::consts::FRAC_PI_3;
    let at = |re: f64, im: f64| {
        let off = |m: &&Complex| libm::hypot(m.re - re, m.im - im) <= NEAR;
        multipliers.iter().filter(off).count()
    };
    let on_circle = || {
        let on = |m: &Complex| m.im > 0.0 && (libm::hypot(m.re, m.im) - 1.0).abs() <= NEAR;
        multipliers.iter().any(on)
    };
    match kind {
        SpecialKind::FoldFlip => at(1.0, 0.0) >= 1 && at(-1.0, 0.0) >= 1,
        SpecialKind::Resonance11 => at(1.0, 0.0) >= 2,
        SpecialKind::Resonance12 => at(-1.0, 0.0) >= 2,
        SpecialKind::Resonance13 => at(-libm::cos(third), libm::sin(third)) >= 1,
        SpecialKind::Resonance14 => at(0.0, 1.0) >= 1,
        SpecialKind::GrazeFold => at(1.0, 0.0) >= 1,
        SpecialKind::GrazeDoubling => at(-1.0, 0.0) >= 1,
        SpecialKind::FoldTorus | SpecialKind::FlipTorus | SpecialKind::GrazeTorus => on_circle(),
        _ => true,
    }
}

/// Where a curve of this kind ends: the pair is real beyond.
pub(super) fn ends(curve: SpecialKind, at: SpecialKind) -> bool {
    curve == SpecialKind::NeimarkSacker
        && matches!(at, SpecialKind::Resonance11 | SpecialKind::Resonance12)
}

/// The parameters' part of a station's direction.
fn in_parameters(shooting: &Shooting<f64>, station: &Station) -> Vec<f64> {
    let free = station.at.len() - shooting.parameters();
    let scaled = station.tangent[free..]
        .iter()
        .zip(&shooting.scales()[free..]);
    scaled.map(|(x, scale)| x / scale).collect()
}

/// At a cusp the curve turns back in the plane of parameters.
fn along(place: &Place<'_>) -> f64 {
    let before = in_parameters(place.shooting, place.from);
    let here = in_parameters(place.shooting, place.station);
    crate::numerics::dot(&before, &here)
}

/// How far across the curve the doubled orbits lie.
fn side(place: &Place<'_>) -> Option<f64> {
    let Bordered::Singular(singular) = place.bordered else {
        return None;
    };
    let free = place.station.at.len() - place.shooting.parameters();
    let scales = &place.shooting.scales()[free..];
    let direction = in_parameters(place.shooting, place.station);
    let [x, y] = direction[..] else {
        return None;
    };
    // In units of the parameters' sizes along and across.
    let held = vec![x / scales[0], y / scales[1]];
    let across = [-y / scales[0], x / scales[1]];
    shift(
        place.shooting,
        &place.station.at,
        singular,
        (&across, &[held]),
    )
}
