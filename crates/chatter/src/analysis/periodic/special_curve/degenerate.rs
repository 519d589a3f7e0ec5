//! Functions that change their sign at points of codimension two, by the kind of curve.

use crate::analysis::continuation::{Problem, Station};
use crate::analysis::periodic::aside::shift;
use crate::analysis::periodic::branch::SpecialKind;
use crate::analysis::periodic::condition::Bordered;
use crate::analysis::periodic::multipliers::{
    neutral, pair, passes, passes_beside, without_nearest,
};
use crate::analysis::periodic::shooting::Shooting;
use crate::numerics::{Complex, dot, unit};

/// A kind of point, what changes its sign there, none where that has no value, and whether that is one of the multipliers.
#[derive(Clone, Copy, Debug)]
pub(super) struct Test {
    pub kind: SpecialKind,
    pub value: Option<f64>,
    pub of_multipliers: bool,
}

/// A function of the multipliers.
const fn multiplier(kind: SpecialKind, value: Option<f64>) -> Test {
    Test {
        kind,
        value,
        of_multipliers: true,
    }
}

/// A function of the curve itself.
const fn geometry(kind: SpecialKind, value: Option<f64>) -> Test {
    Test {
        kind,
        value,
        of_multipliers: false,
    }
}

impl Test {
    /// Whether it is no more than what moduli of multipliers are off by: where a pair stays on the unit circle that is all of it. So is what
    /// becomes of the rate of an impact that the orbit forgets, as where it sticks at once.
    pub(super) fn is_rounding(&self, modulus_error: f64) -> bool {
        if self.kind == SpecialKind::GrazeFold && !self.of_multipliers {
            return self.value.is_some_and(|value| value.abs() <= FORGOTTEN);
        }
        let is_modulus = matches!(
            self.kind,
            SpecialKind::FoldTorus | SpecialKind::FlipTorus | SpecialKind::GrazeTorus
        );
        is_modulus && self.value.is_some_and(|value| value.abs() <= modulus_error)
    }
}

/// What the functions are of: an orbit on a curve, the step that ends with its graze, its multipliers without that impact, and where
/// the curve came from.
pub(super) struct Place<'p> {
    pub shooting: &'p Shooting<f64>,
    pub station: &'p Station,
    pub grazing: Option<usize>,
    pub multipliers: &'p [Complex],
    pub bordered: &'p Bordered,
    pub from: &'p Station,
    pub sided: Sided,
}

/// What is known of the side on which doubled orbits lie, which takes longest to tell.
#[derive(Clone, Copy, Debug)]
pub(super) enum Sided {
    /// It is asked for.
    Asked,
    /// It was told before.
    Told(Option<f64>),
}

/// All functions of a kind of curve.
pub(super) fn tests(kind: SpecialKind, place: &Place<'_>) -> Vec<Test> {
    let all = place.multipliers;
    match kind {
        SpecialKind::Fold => {
            let others = without_nearest(all, 1.0);
            vec![
                geometry(SpecialKind::Cusp, Some(along(place))),
                multiplier(SpecialKind::FoldFlip, passes(&others, -1.0)),
                multiplier(SpecialKind::Resonance11, passes_beside(all, 1.0)),
                multiplier(SpecialKind::FoldTorus, pair(&others)),
            ]
        }
        SpecialKind::PeriodDoubling => {
            let others = without_nearest(all, -1.0);
            vec![
                geometry(SpecialKind::GeneralisedDoubling, side(place)),
                multiplier(SpecialKind::FoldFlip, passes(&others, 1.0)),
                multiplier(SpecialKind::Resonance12, passes_beside(all, -1.0)),
                multiplier(SpecialKind::FlipTorus, pair(&others)),
            ]
        }
        SpecialKind::FlightGraze | SpecialKind::ImpactGraze => vec![
            geometry(SpecialKind::GrazeFold, persistence(place)),
            multiplier(SpecialKind::GrazeFold, passes(all, 1.0)),
            multiplier(SpecialKind::GrazeDoubling, passes(all, -1.0)),
            multiplier(SpecialKind::GrazeTorus, pair(all)),
        ],
        SpecialKind::NeimarkSacker => {
            let Some((_, sum, others)) = neutral(all) else {
                return Vec::new();
            };
            vec![
                multiplier(SpecialKind::Resonance11, Some(2.0 - sum)),
                multiplier(SpecialKind::Resonance12, Some(2.0 + sum)),
                multiplier(SpecialKind::Resonance13, Some(1.0 + sum)),
                multiplier(SpecialKind::Resonance14, Some(sum)),
                multiplier(SpecialKind::FoldTorus, passes(&others, 1.0)),
                multiplier(SpecialKind::FlipTorus, passes(&others, -1.0)),
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
    dot(&before, &here)
}

/// Where the plane's part of a curve's direction is no larger than this, against what it was, the curve stands still there.
const STANDS: f64 = 1e-4;

/// Whether the curve stands still in the plane of parameters, as at a cusp, and does not only turn sharply.
pub(super) fn stands(shooting: &Shooting<f64>, (from, station): (&Station, &Station)) -> bool {
    let before = in_parameters(shooting, from);
    let here = in_parameters(shooting, station);
    dot(&here, &here).sqrt() <= STANDS * dot(&before, &before).sqrt()
}

/// Directions across the curve and along it in the plane of parameters, in units of their sizes.
fn across_and_along(place: &Place<'_>) -> Option<([f64; 2], [f64; 2])> {
    let free = place.station.at.len() - place.shooting.parameters();
    let scales = &place.shooting.scales()[free..];
    let [x, y] = in_parameters(place.shooting, place.station)[..] else {
        return None;
    };
    Some((
        [-y / scales[0], x / scales[1]],
        [x / scales[0], y / scales[1]],
    ))
}

/// How far across the curve the doubled orbits lie.
fn side(place: &Place<'_>) -> Option<f64> {
    if let Sided::Told(side) = place.sided {
        return side;
    }
    let Bordered::Singular(singular) = place.bordered else {
        return None;
    };
    let (across, along) = across_and_along(place)?;
    let held = [along.to_vec()];
    shift(
        place.shooting,
        &place.station.at,
        singular,
        (&across, &held),
    )
}

/// A rate that moves parameters by no more than this part of what it moves states by is forgotten.
const FORGOTTEN: f64 = 1e-9;

/// How far across the curve of a graze the orbits lie whose impact has a rate, against how far they lie in all. Where this changes its sign the graze
/// turns from one that persists into a fold with a corner, and the curves end on which orbits with the impact fold and double.
fn persistence(place: &Place<'_>) -> Option<f64> {
    let (across, along) = across_and_along(place)?;
    let at = &place.station.at;
    let mut shooting = place.shooting.clone();
    let linearised = shooting.evaluate(at).ok()?;
    let (_, rate) = shooting.monitor(place.grazing?, at).ok()?;
    let free = at.len() - along.len();
    let mut held = vec![0.0; at.len()];
    held[free..].copy_from_slice(&along);
    let factors = linearised.bordered([&*held, &*rate]).factored()?;
    let with_rate = factors.solve(&unit(at.len(), at.len() - 1));
    let far = with_rate.iter().zip(shooting.scales());
    let far = far.fold(0.0_f64, |most, (x, scale)| most.max((x / scale).abs()));
    Some(dot(&across, &with_rate[free..]) / far)
}
