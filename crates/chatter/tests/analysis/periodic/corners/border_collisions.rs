//! Maps by a clock, whose pieces meet at corners that no motion passes: branches go through border collisions where orbits persist, turn
//! back at them, or end there.

use crate::periodic::{over, value, with};
use chatter::analysis::periodic::{Branch, End, Point, SpecialKind};

/// A map of x by a clock.
fn ticked(parameters: &str, map: &str) -> String {
    format!(
        "[parameters]\n{parameters}\n[flight]\nx = \"0\"\ns = \"1\"\n[[event]]\nname = \"tick\"\nsurface = \"s - 1\"\n\
         direction = \"rising\"\nreset = {{ x = \"{map}\", s = \"0\" }}\n[initial]\nx = 0.1\ns = 0\n"
    )
}

/// Nordmark's map.
const NORDMARK: &str = "[parameters]\nmu = -0.05\n[flight]\nx = '0'\ny = '0'\ns = '1'\n[[event]]\nname = 'tick'\nsurface = 's - 1'\n\
                direction = 'rising'\n\
                reset = { x = '0.6*x + y + mu', y = '-0.25*x - if(x > 0, sqrt(abs(x)), 0)', s = '0' }\n\
                [initial]\nx = -0.05\ny = 0.01\ns = 0\n";

/// Slopes a to the left and b to the right of the corner at x = 0.
const TENT: &str = "if(x < 0, a*x + mu, b*x + mu)";

fn kinds(branch: &Branch) -> Vec<(SpecialKind, f64)> {
    let all = branch.special.iter();
    all.map(|special| (special.kind, value(special))).collect()
}

fn touches(branch: &Branch) -> Vec<f64> {
    let touches = branch
        .special
        .iter()
        .filter(|s| s.kind == SpecialKind::Touch);
    let mut all: Vec<f64> = touches.map(value).collect();
    all.sort_by(f64::total_cmp);
    all
}

/// x = mu/(1 - b) to the right is mu/(1 - a) to the left, at all steps, however the corner is written.
#[test]
fn a_fixed_point_goes_through_the_corner_of_its_map() {
    let by_parts = "mu + b*max(x, 0) + a*min(x, 0)";
    let twice = "mu + if(x < 0, a*x, 0) + if(2*x < 0, 0, b*x)";
    for (map, step) in [(TENT, 0.01), (TENT, 0.003), (by_parts, 0.02), (twice, 0.01)] {
        let model = with(&ticked("mu = 0.3\na = 0.5\nb = -0.8", map), &[]);
        let found = over(&model, "mu", (-1.0, 1.0), (8, step));
        assert_eq!(found.len(), 1, "{map}");
        let branch = &found[0];
        assert_eq!(branch.ends, [End::Range, End::Range], "{map} {step}");
        let [touch] = &branch.special[..] else {
            panic!("{map} {step}: {:?}", kinds(branch));
        };
        assert_eq!(
            (touch.kind, touch.persists),
            (SpecialKind::Touch, Some(true))
        );
        assert!(value(touch).abs() < 1e-15, "{map} {step}: {}", value(touch));
        for point in &branch.points {
            let (mu, x) = (point.parameter(), point.state[0]);
            let slope = if mu < 0.0 { 0.5 } else { -0.8 };
            assert!(
                (x - mu / (1.0 - slope)).abs() < 1e-12,
                "{map} {step}: {mu} {x}"
            );
            assert!((point.multipliers[0].re - slope).abs() < 1e-9, "{mu}");
        }
    }
}

/// With a > 1 > b both x = mu/(1 - b) > 0 and x = mu/(1 - a) < 0 need mu > 0: they meet at mu = 0 and vanish.
#[test]
fn two_fixed_points_meet_at_the_corner_of_their_map() {
    for step in [0.01, 0.004] {
        let model = with(&ticked("mu = 0.3\na = 1.5\nb = -0.8", TENT), &[]);
        let found = over(&model, "mu", (-1.0, 1.0), (8, step));
        let branch = &found[0];
        assert_eq!(branch.ends, [End::Range, End::Range], "{step}");
        let [touch] = &branch.special[..] else {
            panic!("{step}: {:?}", kinds(branch));
        };
        assert_eq!(
            (touch.kind, touch.persists),
            (SpecialKind::Touch, Some(false))
        );
        assert!(value(touch).abs() < 1e-15, "{step}: {}", value(touch));
        let ends = [&branch.points[0], &branch.points[branch.points.len() - 1]];
        let mut states = ends.map(|point| (point.parameter(), point.state[0]));
        states.sort_by(|a, b| a.1.total_cmp(&b.1));
        let expected = [(1.0, -2.0), (1.0, 1.0 / 1.8)];
        for (found, expected) in states.iter().zip(&expected) {
            let off = (found.0 - expected.0).hypot(found.1 - expected.1);
            assert!(off < 1e-12, "{step}: {states:?}");
        }
    }
}

/// The cycle of two points x1 > 0 > x2, x2 = mu (1 + b)/(1 - a b), comes to the corner at b = -1, where all x1 + x2 = mu, both to the
/// right, are cycles; beyond it there is none, and the fixed point is another orbit.
#[test]
fn a_cycle_that_comes_to_a_family_ends_there() {
    let set = [("b", "-1.5")];
    for step in [0.01, 0.003] {
        let model = with(&ticked("mu = 0.3\na = 0.5\nb = -0.8", TENT), &set);
        let found = over(&model, "b", (-1.9, 0.0), (8, step));
        let branch = &found[0];
        assert!(matches!(branch.ends[1], End::Lost(_)), "{:?}", branch.ends);
        let [touch] = &touches(branch)[..] else {
            panic!("{step}: {:?}", kinds(branch));
        };
        assert!((touch + 1.0).abs() < 1e-13, "{step}: {touch}");
        for point in &branch.points {
            let (b, x) = (point.parameter(), point.state[0]);
            let low = 0.3 * (1.0 + b) / (1.0 - 0.5 * b);
            let both = [low, 0.5 * low + 0.3];
            assert!(
                (point.period - 2.0).abs() < 1e-12 && b <= -1.0 + 1e-12,
                "{b}"
            );
            assert!(
                both.iter().any(|y| (x - y).abs() < 1e-12),
                "{step}: {b} {x}"
            );
        }
    }
}

/// x -> x/2 + mu, less one for x > 0: two points x, x/2 + mu, one on either side, from mu = 1/3 to mu = 2/3.
#[test]
fn a_cycle_that_comes_to_a_jump_ends_there() {
    for step in [0.01, 0.005] {
        let model = with(&ticked("mu = 0.5", "0.5*x + mu - if(x > 0, 1, 0)"), &[]);
        let found = over(&model, "mu", (0.0, 1.0), (8, step));
        let branch = &found[0];
        assert!(branch.ends.iter().all(|end| matches!(end, End::Lost(_))));
        let ends = touches(branch);
        assert_eq!(ends.len(), 2, "{step}: {:?}", kinds(branch));
        for (found, expected) in ends.iter().zip([1.0 / 3.0, 2.0 / 3.0]) {
            assert!((found - expected).abs() < 1e-14, "{step}: {found}");
        }
    }
}

/// An angle that a reset keeps below a turn goes once around on one closed branch, without a word where it does.
#[test]
fn an_angle_that_is_kept_below_a_turn_goes_around() {
    let map = "mod(x + Om - 0.8/(2*pi)*sin(2*pi*x), 1)";
    let model = with(&ticked("Om = 0.1", map), &[]);
    let found = over(&model, "Om", (-0.3, 1.2), (8, 0.01));
    let branch = &found[0];
    assert_eq!(
        branch.ends,
        [End::Closed, End::Closed],
        "{:?}",
        kinds(branch)
    );
    let mut folds: Vec<f64> = branch.special.iter().map(value).collect();
    folds.sort_by(f64::total_cmp);
    let fold = 0.8 / core::f64::consts::TAU;
    assert_eq!(folds.len(), 2, "{:?}", kinds(branch));
    assert!(
        (folds[0] + fold).abs() < 1e-13 && (folds[1] - fold).abs() < 1e-13,
        "{folds:?}"
    );
}

/// With b < -1 the fixed point to the right is unstable beside a cycle of two points, x2 = mu (1 + b)/(1 - a b) < 0: at mu = 0 all come to the
/// corner at once, and the cycle ends there.
#[test]
fn a_cycle_that_shrinks_to_the_corner_ends_there() {
    for step in [0.01, 0.004] {
        let set = [("b", "-1.5")];
        let model = with(&ticked("mu = 0.3\na = 0.5\nb = -0.8", TENT), &set);
        let branch = &over(&model, "mu", (-1.0, 1.0), (8, step))[0];
        let expected = [End::Again(SpecialKind::Touch), End::Range];
        assert_eq!(branch.ends, expected, "{step}");
        assert!(branch.special.len() == 1 && value(&branch.special[0]).abs() < 1e-15);
        for point in &branch.points {
            let (mu, x) = (point.parameter(), point.state[0]);
            let low = mu * -0.5 / 1.75;
            let both = [low, 0.5 * low + mu];
            let near = both.iter().any(|y| (x - y).abs() < 1e-12);
            assert!(
                near && (point.period - 2.0).abs() < 1e-12,
                "{step}: {mu} {x}"
            );
        }
    }
}

/// A pair of multipliers that jumps across the unit circle where the slope of a root begins, as in Nordmark's map, is nowhere on it: no Neimark-Sacker
/// point is told where the product of the two is 0.25 to one side and beyond all bounds to the other.
#[test]
fn no_torus_is_told_where_a_pair_jumps_across_the_circle() {
    let found = over(&with(NORDMARK, &[]), "mu", (-0.3, 0.2), (8, 0.02));
    assert!(!found[0].points.is_empty());
    for (kind, at) in found.iter().flat_map(kinds) {
        assert!(kind != SpecialKind::NeimarkSacker, "{at}");
    }
}

/// How a branch ends where slopes have no bound.
fn ends_at_root(end: &End) -> bool {
    matches!(end, End::Lost(why) if why.ends_with("where its slopes have no bound"))
}

/// x = mu - sqrt(x), or x = a x + mu below zero: at mu = 0 the fixed point comes to where the root begins, from both sides, at all steps and however the
/// root is written. With s = sqrt(x) = (sqrt(1 + 4 mu) - 1)/2 the slope is -1/(2 s), -1 at s = 1/2.
#[test]
fn a_fixed_point_ends_where_a_root_begins() {
    let maps = [
        "mu + if(x > 0, -sqrt(x), a*x)",
        "mu + a*min(x, 0) - sqrt(max(x, 0))",
    ];
    let starts = [
        ("-0.5", 1, 0.01),
        ("-0.5", 1, 0.03),
        ("2", 0, 0.01),
        ("2", 0, 0.03),
    ];
    for (map, (mu, comes, step)) in { maps }.iter().flat_map(|map| starts.map(|s| (map, s))) {
        let model = with(&ticked("mu = 0.3\na = 0.5", map), &[("mu", mu)]);
        let found = over(&model, "mu", (-1.0, 2.5), (8, step));
        let branch = &found[0];
        let told = (&branch.ends, kinds(branch));
        assert!(ends_at_root(&branch.ends[comes]), "{map} {step}: {told:?}");
        assert_eq!(branch.ends[1 - comes], End::Range, "{map} {step}");
        let [touch] = touches(branch)[..] else {
            panic!("{map} {step}: {told:?}");
        };
        assert!(touch.abs() < 1e-15, "{map} {step}: {touch}");
        let others = told
            .1
            .iter()
            .filter(|(kind, _)| *kind != SpecialKind::Touch);
        let others: Vec<_> = others.collect();
        match (comes, &others[..]) {
            (1, []) => {}
            (0, [(SpecialKind::PeriodDoubling, at)]) if (at - 0.75).abs() < 1e-12 => {}
            _ => panic!("{map} {step}: {told:?}"),
        }
        assert!(branch.points.len() > 30, "{}", branch.points.len());
        for point in &branch.points {
            let (mu, x) = (point.parameter(), point.state[0]);
            let root = 0.5 * ((1.0 + 4.0 * mu).sqrt() - 1.0);
            let expected = if comes == 1 { 2.0 * mu } else { root * root };
            // Beside the root Newton's method may come to no more than it tells.
            let most = 1e-12 + 4.0 * point.correction;
            assert!((x - expected).abs() < most, "{map} {step}: {mu} {x}");
            assert!(if comes == 1 { mu <= 0.0 } else { mu > 0.0 }, "{mu}");
        }
    }
}

/// A cycle of Nordmark's map over five ticks whose third point comes to the border from the side of the root: it is one there, and told at the same place at
/// all steps, and no station beyond is no cycle of the map.
#[test]
fn a_cycle_of_nordmarks_map_ends_where_its_root_begins() {
    let map = |[x, y]: [f64; 2], mu: f64| [0.6 * x + y + mu, -0.25 * x - x.max(0.0).sqrt()];
    let around = |point: &Point| {
        let start = [point.state[0], point.state[1]];
        let mut nearest = f64::INFINITY;
        let end = (0..5).fold(start, |at, _| {
            nearest = nearest.min(at[0].abs());
            map(at, point.parameter())
        });
        ((end[0] - start[0]).hypot(end[1] - start[1]), nearest)
    };
    for step in [0.01, 0.03] {
        let model = with(NORDMARK, &[("mu", "0.05")]);
        let found = over(&model, "mu", (-0.2, 0.1), (8, step));
        let branch = &found[0];
        assert!(ends_at_root(&branch.ends[0]), "{step}: {:?}", branch.ends);
        assert_eq!(branch.ends[1], End::Range, "{step}");
        let [touch] = &branch.special[..] else {
            panic!("{step}: {:?}", kinds(branch));
        };
        let at = 0.014_833_382_826_876_322;
        assert!(
            (value(touch) - at).abs() < 1e-16,
            "{step}: {}",
            value(touch)
        );
        // At the border itself rounding leaves a root of its own.
        let (off, nearest) = around(&touch.point);
        assert!(off < 1e-7 && nearest < 1e-15, "{step}: {off} {nearest}");
        for point in &branch.points {
            let (off, _) = around(point);
            let most = match point.parameter() - at {
                beyond if beyond > 1e-15 => 1e-13 + 4.0 * point.correction,
                _ => 1e-7,
            };
            assert!(off < most, "{step}: {} {off}", point.parameter());
        }
    }
}
