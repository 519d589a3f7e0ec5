//! Fixed points over an orbit diagram, and windows of periodic orbits under it.
//!
//! They are there whatever the orbits of the diagram have settled to: where several attractors coexist, a carried orbit
//! shows one of them.

use super::picture::curve;
use crate::options::Counts;
use chatter::analysis::universal::{Located, PeriodicWindow, UniversalError, UniversalMap, Window};
use chatter::numerics::{DoubleDouble, Real};
use chatter_figures::{Axis, Color, Dash, Legend, Line, Marker, Markers, Panel};

/// Points of a curve, broken where a coordinate is not finite.
type Points = (Vec<f64>, Vec<f64>);

/// Where a curve is broken.
const BREAK: (f64, f64) = (f64::NAN, f64::NAN);

/// The fixed points on these laps: their curve, mu = x - K Upsilon(x) over z = Upsilon(x), and its bifurcations.
pub fn fixed_point_layers(
    panel: &mut Panel,
    map: &UniversalMap<f64>,
    laps: Counts,
    shown: (f64, f64),
) -> Result<(), UniversalError> {
    let windows =
        (map.universal()).windows(map.slope(), laps.first..=laps.last.saturating_add(1))?;
    // A lap begins where the next one ends.
    let laps: Vec<(&Window<Located<f64>>, f64)> = (windows.iter().zip(&windows[1..]))
        .filter(|(window, next)| is_seen(window, next, shown))
        .map(|(window, next)| (window, next.grazing.x))
        .collect();
    let (mut stable, mut unstable) = (Points::default(), Points::default());
    for &(window, begin) in laps.iter().rev() {
        add_lap(map, window, begin, &mut stable, &mut unstable);
    }
    let lines = [
        ("stable fixed point", Dash::Solid, 0.9, stable),
        ("unstable", Dash::Dashed, 0.5, unstable),
    ];
    for (name, dash, width, (mu, z)) in lines {
        // Points beside those that are shown let the curve go on to the frame.
        let inside = |place: usize| mu.get(place).is_some_and(|&mu| within(shown, mu));
        let point = |place: usize| {
            let near = inside(place) || inside(place + 1) || place > 0 && inside(place - 1);
            if near { (mu[place], z[place]) } else { BREAK }
        };
        let (mu, z): Points = (0..mu.len()).map(point).unzip();
        if mu.iter().any(|mu| mu.is_finite()) {
            let line = Line::new(mu, z).color(Color::VERMILION);
            panel.add(line.dash(dash).width(width).label(name));
        }
    }
    type Part = fn(&Window<Located<f64>>) -> Option<Located<f64>>;
    let kinds: [(&str, Marker, Color, Part); 3] = [
        ("fold", Marker::Disc, Color::GREEN, |w| w.fold),
        ("period doubling", Marker::Diamond, Color::ORANGE, |w| {
            w.period_doubling
        }),
        ("graze", Marker::Circle, Color::BLUE, |w| Some(w.grazing)),
    ];
    for (name, marker, color, part) in kinds {
        let events = laps.iter().filter_map(|(window, _)| part(window));
        let (mu, z): Points = events
            .filter(|event| within(shown, event.mu))
            .map(|event| (event.mu, event.z))
            .unzip();
        if !mu.is_empty() {
            let markers = Markers::new(mu, z).marker(marker).color(color);
            panel.add(markers.size(3.4).label(name));
        }
    }
    Ok(())
}

fn within((from, to): (f64, f64), mu: f64) -> bool {
    (from..=to).contains(&mu)
}

/// Laps that are narrower, as a part of what is shown, are not told apart.
const NARROWEST: f64 = 1e-4;

/// Whether a lap is shown, and wide enough to be seen. Its ends and its fold are farthest from each other.
fn is_seen(
    window: &Window<Located<f64>>,
    next: &Window<Located<f64>>,
    (from, to): (f64, f64),
) -> bool {
    let events = [Some(window.grazing), Some(next.grazing), window.fold];
    let mu = || events.iter().flatten().map(|event| event.mu);
    let (low, high) = (
        mu().fold(f64::INFINITY, f64::min),
        mu().fold(f64::NEG_INFINITY, f64::max),
    );
    low <= to && from <= high && high - low > NARROWEST * (to - from)
}

/// Adds the fixed points of a lap to the stable and the unstable part of the curve, which meet in points of both.
fn add_lap(
    map: &UniversalMap<f64>,
    window: &Window<Located<f64>>,
    begin: f64,
    stable: &mut Points,
    unstable: &mut Points,
) {
    let (x, z) = curve(map.universal(), begin, window.grazing.x);
    let points = x.into_iter().zip(z);
    let mut points: Vec<(f64, f64, f64)> =
        points.map(|(x, z)| (x, x - map.slope() * z, z)).collect();
    let ends = [window.fold, window.period_doubling];
    points.extend(ends.iter().flatten().map(|at| (at.x, at.mu, at.z)));
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    let [first, last] = if map.slope() > 0.0 {
        ends
    } else {
        [window.period_doubling, window.fold]
    };
    // Without a first end it is stable from the kink where the lap begins.
    let low = first.map_or(f64::NEG_INFINITY, |first| first.x);
    let high = last.map_or(f64::NEG_INFINITY, |last| last.x);
    for (x, mu, z) in points {
        let add = |(to_mu, to_z): &mut Points, belongs: bool| {
            let (mu, z) = if belongs { (mu, z) } else { BREAK };
            to_mu.push(mu);
            to_z.push(z);
        };
        add(stable, low <= x && x <= high);
        add(unstable, x <= low || high <= x);
    }
}

/// Half the height of a window's outline, in periods.
const HALF: f64 = 0.35;

/// Windows of periodic orbits as outlines, from where an orbit becomes stable to where it ceases to be, at the height of
/// its period; and the longest period. None where there are fixed points only.
pub fn window_panel(
    windows: &[PeriodicWindow<DoubleDouble>],
    shown: (f64, f64),
) -> Option<(Panel, usize)> {
    let longest = windows.iter().map(PeriodicWindow::period).max()?;
    if longest == 1 {
        return None;
    }
    let mut outlines = Points::default();
    for window in windows {
        let Some((low, high)) = window.stable() else {
            continue;
        };
        let (low, high) = (low.to_f64().max(shown.0), high.to_f64().min(shown.1));
        if low > high {
            continue;
        }
        let period = window.period() as f64;
        let (foot, top) = (period - HALF, period + HALF);
        let corners = [
            (low, foot),
            (high, foot),
            (high, top),
            (low, top),
            (low, foot),
        ];
        outlines.extend(corners.into_iter().chain([BREAK]));
    }
    let (mu, period) = outlines;
    let panel = Panel::new(
        Axis::new("$\\mu$").range(shown.0, shown.1),
        Axis::new("period").whole().range(0.5, longest as f64 + 0.5),
    )
    .with(Line::new(mu, period).color(Color::BLUE).width(0.3))
    .legend(Legend::Hidden);
    Some((panel, longest))
}

#[cfg(test)]
mod tests {
    use super::*;
    use chatter::analysis::universal::Universal;

    #[test]
    fn curves_are_fixed_points_and_only_the_stable_ones_attract() {
        let universal = Universal::new(0.8).unwrap();
        for slope in [1.0, -1.0, 2.4] {
            let map = |mu| UniversalMap::new(universal.clone(), slope, mu).unwrap();
            let windows = universal.windows(slope, 4..=9).unwrap();
            let (mut stable, mut unstable) = (Points::default(), Points::default());
            for pair in windows.windows(2) {
                let begin = pair[1].grazing.x;
                add_lap(&map(0.0), &pair[0], begin, &mut stable, &mut unstable);
            }
            for (attract, (mu, z)) in [(true, stable), (false, unstable)] {
                let points = mu.iter().zip(&z).filter(|(mu, _)| mu.is_finite());
                assert!(points.clone().count() >= 10);
                for (&mu, &z) in points {
                    let (next, multiplier) = map(mu).step_with_multiplier(z);
                    // At a lap's end the slope is infinite.
                    assert!((next - z).abs() < 1e-9 || multiplier.abs() > 1e3);
                    let excess = multiplier.abs() - 1.0;
                    assert!(if attract {
                        excess < 1e-6
                    } else {
                        excess > -1e-6
                    });
                }
            }
        }
    }
}
