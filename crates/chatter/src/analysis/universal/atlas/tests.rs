//! Windows of periodic orbits against their equations and against orbits.

use super::super::evaluate::Universal;
use super::super::windows::Located;
use super::{EdgeKind, PeriodicAtlas};
use crate::numerics::{DoubleDouble, Real, Scalar};

type D = DoubleDouble;

fn atlas(r: f64, slope: f64, laps: (i64, i64), longest: usize) -> (Universal<D>, PeriodicAtlas<D>) {
    let universal = Universal::new(D::from(r)).unwrap();
    let windows = universal
        .periodic_windows(D::from(slope), laps.0..=laps.1, 1..=longest)
        .unwrap();
    (universal, windows)
}

/// The points of an orbit that starts at a located point.
fn orbit(universal: &Universal<D>, slope: f64, start: &Located<D>, count: usize) -> Vec<D> {
    let mut points = vec![start.x];
    for k in 1..=count {
        points.push(D::from(slope) * universal.value(points[k - 1]) + start.mu);
    }
    points
}

fn multiplier(universal: &Universal<D>, slope: f64, points: &[D]) -> f64 {
    let factor = |&x: &D| D::from(slope) * universal.at(x).derivative;
    points
        .iter()
        .map(factor)
        .fold(D::ONE, |a, b| a * b)
        .to_f64()
}

fn is_rotation(a: &[i64], b: &[i64]) -> bool {
    a.len() == b.len() && [b, b].concat().windows(a.len()).any(|part| part == a)
}

const CASES: [(f64, f64, (i64, i64), usize); 6] = [
    (0.8, 1.0, (8, 9), 4),
    (0.8, 1.0, (59, 60), 5),
    (0.8, -1.0, (20, 21), 4),
    (0.3, 1.0, (3, 5), 4),
    (0.8, 4.6, (36, 37), 3),
    (0.97, 2.0, (200, 200), 2),
];

#[test]
fn windows_satisfy_their_equations() {
    for (r, slope, laps, longest) in CASES {
        let (universal, atlas) = atlas(r, slope, laps, longest);
        assert!(!atlas.windows.is_empty() && atlas.undecided == 0);
        for window in &atlas.windows {
            let period = window.period();
            let returns_to = |at: &Located<D>, period: usize, digits: f64| {
                let points = orbit(&universal, slope, at, period);
                let off = ((points[period] - at.x) / at.x).abs().to_f64();
                assert!(off < digits, "{r} {slope} {window:?} {off:e}");
                points[..period].to_vec()
            };
            // Orbits of long periods multiply a rounding error by up to 1e13; at a lap's end its square root counts.
            let returns = |at: &Located<D>, period: usize| returns_to(at, period, 1e-18);
            let grazes = |at: &Located<D>| returns_to(at, period, 1e-10);
            assert_eq!(window.edges.len(), 2);
            let (low, high) = window.stable().unwrap();
            assert!(low < high, "{window:?}");
            for edge in &window.edges {
                let wanted = match edge.kind {
                    EdgeKind::Fold => 1.0,
                    EdgeKind::DoubledFrom => {
                        let points = returns(&edge.at, period / 2);
                        assert!((multiplier(&universal, slope, &points) + 1.0).abs() < 1e-13);
                        continue;
                    }
                    EdgeKind::PeriodDoubling => -1.0,
                    EdgeKind::Collision => {
                        let points = grazes(&edge.at);
                        // Rounding may have put it on either side.
                        let lap = universal.at(points[0]).lap.to_f64() as i64;
                        let away = [lap, lap + 1].map(|lap| {
                            let end = universal.window_of(D::ONE, lap).grazing.x;
                            ((points[0] - end) / end).abs().to_f64()
                        });
                        assert!(away[0].min(away[1]) < 1e-29, "{away:?}");
                        continue;
                    }
                };
                let points = returns(&edge.at, period);
                let off = multiplier(&universal, slope, &points) - wanted;
                assert!(off.abs() < 1e-13, "{r} {slope} {window:?} {off:e}");
            }
            if let Some(superstable) = window.superstable {
                let points = returns(&superstable, period);
                assert!(multiplier(&universal, slope, &points).abs() < 1e-13);
                let laps: Vec<i64> = points
                    .iter()
                    .map(|&x| universal.at(x).lap.to_f64() as i64)
                    .collect();
                assert_eq!(laps, window.laps);
                assert!(low < superstable.mu && superstable.mu < high, "{window:?}");
            }
            if let Some(graze) = window.grazing {
                let points = grazes(&graze);
                let graze = universal.at(points[0]).u1.to_f64();
                // The point is rounded to one side of the end or the other.
                let begin = universal.at(points[0] * D::from(1.0 + 1e-12)).u1.to_f64();
                assert!((graze - 0.375).abs() < 1e-12 || graze - begin < 1e-6);
            }
        }
    }
}

/// Whatever orbits settle to, the atlas has it.
/// With K = 2.3 the end of lap 1 returns to itself by way of complete chatter, too.
#[test]
fn orbits_with_complete_chatter_are_no_windows() {
    for (r, slope) in [(0.13, 2.3), (0.4, 2.3)] {
        let (_, atlas) = atlas(r, slope, (2, 3), 2);
        assert!(atlas.windows.iter().any(|window| window.period() == 2));
        for window in &atlas.windows {
            let near = |lap: &i64| (lap - window.lap).abs() < 100;
            assert!(window.laps.iter().all(near), "{window:?}");
            let [low, high] = [0, 1].map(|end| window.edges[end].at.mu);
            assert!(low < high, "{window:?}");
        }
    }
}

#[test]
fn no_window_is_missed() {
    const MUS: usize = 150;
    const STARTS: usize = 5;
    const SETTLING: usize = 1500;
    let mut settled = 0;
    for (r, slope, laps, longest) in CASES {
        let (first, last) = laps;
        let (universal, atlas) = atlas(r, slope, (first - 3, last + 3), longest.min(3));
        let double = Universal::new(r).unwrap();
        let edge = |lap: i64| universal.window_of(D::from(slope), lap).grazing.mu.to_f64();
        let (low, high) = (
            edge(last + 1).min(edge(first)),
            edge(last + 1).max(edge(first)),
        );
        for k in 0..MUS {
            let mu = low + (high - low) * (k as f64 + 0.5) / MUS as f64;
            let center = double.window_of(slope, first).grazing.x;
            for start in 1..=STARTS {
                let mut x = center * 1.5 * start as f64 / STARTS as f64;
                for _ in 0..SETTLING {
                    x = slope * double.value(x) + mu;
                }
                let (mut points, mut product) = (vec![x], 1.0);
                let period = (1..=longest.min(3)).find(|_| {
                    product *= slope * double.at(x).derivative;
                    x = slope * double.value(x) + mu;
                    points.push(x);
                    (x - points[0]).abs() < 1e-9 * x.abs()
                });
                let Some(period) = period.filter(|_| product.abs() < 0.95 && x > 0.0) else {
                    continue;
                };
                points.truncate(period);
                let visited: Vec<i64> = points.iter().map(|&x| double.at(x).lap as i64).collect();
                if !visited
                    .iter()
                    .all(|lap| (first - 3..=last + 3).contains(lap))
                {
                    continue;
                }
                settled += 1;
                let known = atlas.windows.iter().any(|window| {
                    let Some((low, high)) = window.stable() else {
                        return false;
                    };
                    low.to_f64() < mu && mu < high.to_f64() && is_rotation(&window.laps, &visited)
                });
                assert!(known, "{r} {slope} {mu} {visited:?} {product}");
            }
        }
    }
    assert!(settled > 5 * MUS, "{settled}");
}

/// Next to the graze of lap n, orbits of one point on it and m on lap n - 1 follow each other, m = 1, 2, … (period adding).
/// For slopes s < 1 beyond the end their windows approach those of the square root map y -> A - k sqrt(y), A + s y:
/// stable between (3/4) s^2m k^2 / S and (s^m k / (S - 1))^2 with S = 1 + s + … + s^m.
#[test]
fn periods_are_added_next_to_a_graze() {
    for (n, longest) in [(110, 2), (150, 1)] {
        added_next_to_the_graze_of(n, longest);
    }
}

fn added_next_to_the_graze_of(n: i64, longest: usize) {
    let slope = 1.0;
    let universal = Universal::new(D::from(0.8)).unwrap();
    let scaling = universal.scaling(D::from(slope)).unwrap();
    let atlas = universal
        .periodic_windows(D::from(slope), n..=n, 2..=longest + 1)
        .unwrap();
    let graze = universal.window_of(D::from(slope), n).grazing.mu;
    let s = (scaling.kink_slope * scaling.slope_ratio.powi(n as i32 - 1)).to_f64();
    // graze_distance is 3 (k / 2)^2 on lap 0.
    let square = (scaling.graze_distance * scaling.graze_ratio.powi(n as i32)).to_f64() / 0.75;
    assert!(s < 0.25);
    for m in 1..=longest {
        let mut laps = vec![n - 1; m + 1];
        laps[0] = n;
        let window = atlas
            .windows
            .iter()
            .find(|window| window.laps == laps)
            .unwrap();
        let (low, high) = window.stable().unwrap();
        let (far, near) = ((graze - low).to_f64(), (graze - high).to_f64());
        let sum: f64 = (0..=m as i32).map(|k| libm::pow(s, f64::from(k))).sum();
        let power = libm::pow(s, 2.0 * m as f64) * square;
        let expected = (power / ((sum - 1.0) * (sum - 1.0)), 0.75 * power / sum);
        // The next terms are of the order of s, and of the square root of y, which is larger at the far end.
        assert!(
            (near / expected.1 - 1.0).abs() < 2.0 * s,
            "{m} {near} {expected:?}"
        );
        assert!(
            (far / expected.0 - 1.0).abs() < 8.0 * s,
            "{m} {far} {expected:?}"
        );
    }
}
