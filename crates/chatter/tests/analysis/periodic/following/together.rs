//! Impacts that lose their rates at once.

use crate::periodic::{over, value, with};
use chatter::analysis::periodic::{Branch, End, Point, SpecialKind};
use core::f64::consts::PI;

/// Van der Pol's cycle between two walls touches both at once where they are as far apart as it is wide: beyond it goes on free. Its amplitude is
/// that of another integrator.
#[test]
fn a_cycle_leaves_both_walls_at_once() {
    let text = "[parameters]\nmu = 0.8\nb = 2\n[flight]\nx = \"v\"\nv = \"mu*(1-x^2)*v - x\"\n[[contact]]\nname = \"right\"\n\
        gap = \"b - x\"\nimpulse = { v = -1 }\nrestitution = 0.7\n[[contact]]\nname = \"left\"\ngap = \"b + x\"\n\
        impulse = { v = 1 }\nrestitution = 0.7\n[section.s]\nsurface = \"x\"\ndirection = \"rising\"\n\
        [initial]\nx = 0.3\nv = 0.5\n";
    for start in ["1.9", "2.0", "2.05"] {
        for step in [0.02, 0.1] {
            let found = over(&with(text, &[("b", start)]), "b", (1.8, 2.1), (4, step));
            let [branch] = &found[..] else {
                panic!("from {start} by {step}: {}", found.len());
            };
            let ends = &branch.ends;
            assert_eq!(ends, &[End::Range, End::Range], "from {start} by {step}");
            let told: Vec<_> = branch.special.iter().map(|graze| graze.kind).collect();
            assert_eq!(
                told,
                [SpecialKind::ImpactGraze; 2],
                "from {start} by {step}"
            );
            for graze in &branch.special {
                assert!((value(graze) - 2.005_915_788_6).abs() < 1e-10, "{graze:?}");
                assert!(graze.error < 1e-13, "{graze:?}");
            }
            for point in &branch.points {
                let strikes = if point.parameter() < value(&branch.special[0]) {
                    2
                } else {
                    0
                };
                assert_eq!(point.impacts, Some(strikes), "{}", point.parameter());
            }
        }
    }
}

/// A clapper strikes both sides of a driven bell in turn, and both impacts lose their rates at once: beyond, the bell is silent. So it is whatever the
/// step that comes to that place, and though the first orbit that is looked at without one of the impacts lies beyond it. The value is
/// that of another integrator.
#[test]
fn a_clapper_falls_silent_on_both_sides() {
    let text = "[parameters]\nomega = 1.7\n[flight]\na = \"p\"\np = \"0.5*cos(omega*t) - 0.7*sin(a) - 0.25*p\"\nb = \"q\"\n\
        q = \"-1.3*sin(b) - 0.1*(q - p)\"\n[[contact]]\nname = \"left\"\ngap = \"0.35 - (b - a)\"\n\
        impulse = { p = 0.15, q = -1 }\nrestitution = 0.5\n[[contact]]\nname = \"right\"\ngap = \"0.35 + (b - a)\"\n\
        impulse = { p = -0.15, q = 1 }\nrestitution = 0.5\n[section.s]\nsurface = \"sin(omega*t)\"\ndirection = \"rising\"\n\
        [initial]\na = 0.1\np = 0\nb = 0\nq = 0.3\n";
    let found = over(&with(text, &[]), "omega", (1.42, 2.7), (4, 0.06));
    let branch = &found[0];
    assert_eq!(branch.ends, [End::Range, End::Range]);
    let grazes = (branch.special.iter()).filter(|special| special.kind != SpecialKind::Fold);
    let grazes: Vec<f64> = grazes.map(value).collect();
    assert_eq!(grazes.len(), 2);
    assert!(
        grazes
            .iter()
            .all(|graze| (graze - 1.430_167_938_581_28).abs() < 1e-12)
    );
    assert_eq!(
        branch.points.first().map(|point| point.impacts),
        Some(Some(2))
    );
    assert_eq!(
        branch.points.last().map(|point| point.impacts),
        Some(Some(0))
    );
}

/// A free ball strikes both ends of a shaken box in turn, V fast: (pi V/2 - b)^2 + (V (1 - r)/(1 + r))^2 = a^2. Where it comes to rest the box touches it
/// at both ends, and nothing is left that strikes: there the branch ends, and beyond are no orbits with an impact whose rate is rounding.
#[test]
fn a_ball_that_comes_to_rest_between_two_walls_strikes_no_more() {
    let text = "[parameters]\na = 0.3\n[flight]\ny = \"v\"\nv = \"0\"\n[[contact]]\nname = \"right\"\n\
        gap = \"0.8 + a*sin(t) - y\"\nimpulse = { v = -1 }\nrestitution = 0.7\n[[contact]]\nname = \"left\"\n\
        gap = \"0.8 - a*sin(t) + y\"\nimpulse = { v = 1 }\nrestitution = 0.7\n[section.s]\nsurface = \"sin(t)\"\n\
        direction = \"rising\"\n[initial]\ny = -0.2831\nv = 0.6842\n";
    let (rests, slow) = (0.8, 0.3 / 1.7);
    let folds = rests * slow / (0.25 * PI * PI + slow * slow).sqrt();
    for step in [0.1, 0.03] {
        let found = over(&with(text, &[]), "a", (0.05, 1.5), (6, step));
        let branch = &found[0];
        let is_at_rest = |end: &&End| matches!(end, End::Lost(why) if why.contains("at rest"));
        assert_eq!(branch.ends.iter().filter(is_at_rest).count(), 1, "{step}");
        assert!(
            branch.points.iter().all(|point| point.impacts == Some(2)),
            "{step}"
        );
        for (kind, expected) in [
            (SpecialKind::Fold, folds),
            (SpecialKind::FlightGraze, rests),
        ] {
            let told = branch.special.iter().filter(|special| special.kind == kind);
            let told: Vec<f64> = told.map(value).collect();
            assert_eq!(told.len(), 1, "{step} {kind:?}");
            assert!((told[0] - expected).abs() < 1e-13, "{step} {told:?}");
        }
    }
}

/// A driven mass between two stops touches both at once where its amplitude is the room that it has: there orbits without an impact, with one at either stop, and
/// with one at each begin. The branch goes on as its mirror image does, from either side, at all steps; what strikes one stop alone leaves there, and turns
/// back as its own image. Amplitudes are closed forms, and the doubling of what strikes one stop is by those of its flights in thirty digits.
#[test]
fn a_branch_goes_on_as_its_mirror_image_does_where_both_stops_are_touched_at_once() {
    let text = "[parameters]\nF = 0.3\nw = 0.8\n[flight]\nx = \"v\"\nv = \"-x - 0.1*v + F*cos(w*t)\"\n[[contact]]\nname = \"right\"\n\
        gap = \"1 - x\"\nimpulse = { v = -1 }\nrestitution = 0.8\n[[contact]]\nname = \"left\"\ngap = \"1 + x\"\n\
        impulse = { v = 1 }\nrestitution = 0.8\n[section.strobe]\nsurface = \"sin(w*t)\"\ndirection = \"rising\"\n[initial]\n\
        x = 0\nv = 0\n";
    for (w, starts) in [("0.8", ["0.3", "0.65"]), ("1.2", ["0.3", "0.25"])] {
        let frequency: f64 = w.parse().unwrap();
        let exact = (1.0 - frequency.powi(2)).hypot(0.1 * frequency);
        for (start, step) in starts.into_iter().zip([0.05, 0.2]) {
            let model = with(text, &[("w", w), ("F", start)]);
            let found = over(&model, "F", (0.2, 0.7), (8, step));
            let symmetric =
                |branch: &&Branch| branch.special.iter().filter(|s| s.kind.is_graze()).count() == 2;
            let branch = found.iter().find(symmetric).unwrap();
            let grazes: Vec<_> = branch
                .special
                .iter()
                .filter(|s| s.kind.is_graze())
                .collect();
            assert!(
                grazes.iter().all(|s| (value(s) - exact).abs() < 1e-14),
                "{w} {start}"
            );
            assert_eq!(grazes[0].persists, grazes[1].persists);
            let strikes = |point: &Point| point.impacts.unwrap();
            assert!(
                branch
                    .points
                    .iter()
                    .all(|point| [0, 2].contains(&strikes(point)))
            );
            for strikes in [0, 2] {
                assert!(
                    branch
                        .points
                        .iter()
                        .any(|point| point.impacts == Some(strikes))
                );
            }
            // With one impact there are orbits at 0.8, and none at 1.2.
            let others = found.iter().filter(|branch| !symmetric(branch));
            let others: Vec<&Branch> = others.collect();
            assert_eq!(others.len(), usize::from(w == "0.8"), "{w} {start}");
            for branch in others {
                let of = |kind: SpecialKind| {
                    let all = branch.special.iter().filter(move |s| s.kind == kind);
                    all.map(value).collect::<Vec<f64>>()
                };
                let [turn] = of(SpecialKind::ImpactGraze)[..] else {
                    panic!("{start} {:?}", branch.special);
                };
                assert!((turn - exact).abs() < 1e-14, "{turn}");
                let doublings = of(SpecialKind::PeriodDoubling);
                assert_eq!(doublings.len(), 2, "{start}");
                let expected = 0.518_209_866_597_872_6;
                assert!(doublings.iter().all(|told| (told - expected).abs() < 1e-13));
            }
        }
    }
}

/// A cycle of a tube between two walls, which no clock drives, touches both at once. Orbits that strike both lie on the side from where those come that strike
/// none: the branch turns back there, and so both grazes say from wherever they are met. The value is that of an integrator of Runge and Kutta's kind,
/// of order eight.
#[test]
fn both_grazes_of_a_cycle_without_a_clock_are_told_alike_from_either_side() {
    let text = "[parameters]\nk = 0.25\n[flight]\nx = \"u\"\nu = \"0.04*u - x + k*y - 0.4*u*x^2\"\ny = \"w\"\n\
        w = \"-0.06*w - 1.15*y - k*x\"\n[[contact]]\nname = \"right\"\ngap = \"1 - x\"\nimpulse = { u = -1 }\n\
        restitution = 0.7\n[[contact]]\nname = \"left\"\ngap = \"1 + x\"\nimpulse = { u = 1 }\nrestitution = 0.7\n\
        [section.top]\nsurface = \"y\"\ndirection = \"falling\"\n[initial]\nx = 0.1\nu = 0.3\ny = 0.1\nw = 0.2\n";
    for start in ["0.09", "0.11"] {
        let found = over(&with(text, &[("k", start)]), "k", (0.05, 0.15), (4, 0.1));
        let grazes: Vec<_> = (found[0].special.iter())
            .filter(|special| special.kind.is_graze())
            .collect();
        let impacts: Vec<_> = grazes.iter().map(|graze| graze.point.impacts).collect();
        assert_eq!(impacts, [Some(0), Some(1)], "from {start}");
        for graze in grazes {
            assert_eq!(graze.kind, SpecialKind::FlightGraze, "from {start}");
            assert_eq!(graze.persists, Some(false), "from {start}");
            assert!(
                (value(graze) - 0.097_913_066_779_574_6).abs() < 1e-12,
                "{}",
                value(graze)
            );
        }
    }
}

/// A driven mass strikes each of two stops several times, ever more slowly: where both flights that come next are touched at once there are slow impacts
/// before them. Each of the two grazes is told once, with one impact less than before it, and folds beside it say that the branch turns back. Values by
/// flights in closed form with 40 digits.
#[test]
fn impacts_that_are_slow_already_do_not_graze_with_those_of_both_stops() {
    let text = "[parameters]\nw = 0.452\nd = 0.7698\n[flight]\nx = \"v\"\nv = \"1.1041*cos(w*t) - 0.2672*v - x\"\n[[contact]]\nname = \"right\"\n\
        gap = \"d - x\"\nimpulse = { v = -1 }\nrestitution = 0.3905\n[[contact]]\nname = \"left\"\ngap = \"d + x\"\n\
        impulse = { v = 1 }\nrestitution = 0.3905\n[section.strobe]\nsurface = \"sin(w*t)\"\ndirection = \"rising\"\n[initial]\n\
        x = 0\nv = 0.1\n";
    let expected = [
        (0.769_880_448_630_845_4, 13),
        (0.769_880_448_630_845_4, 12),
        (0.772_611_997_742_175_2, 11),
        (0.772_611_997_742_175_2, 10),
    ];
    for start in ["0.7698", "0.7724"] {
        let model = with(text, &[("d", start)]);
        let found = over(&model, "d", (0.7695, 0.773), (14, 0.05));
        let grazes = found[0].special.iter().filter(|s| s.kind.is_graze());
        let mut grazes: Vec<_> = grazes.collect();
        grazes.sort_by_key(|graze| graze.point.impacts.map(|impacts| 20 - impacts));
        assert_eq!(grazes.len(), expected.len(), "{start}: {grazes:?}");
        for (graze, (at, impacts)) in grazes.into_iter().zip(expected) {
            assert!((value(graze) - at).abs() < 1e-14, "{start}: {graze:?}");
            assert_eq!(graze.point.impacts, Some(impacts), "{start}");
            assert_eq!(graze.persists, Some(false), "{start}");
        }
    }
}

/// A piston that tilts between two walls, its own mirror image after half a period: with sixteen impacts it touches both at once, and goes on with eighteen. Beside a
/// branch point what is off by rounding there is many times that. The value is by shooting over half a period with closed forms of the flights.
#[test]
fn a_piston_goes_on_as_its_mirror_image_does_after_many_impacts() {
    let text = "[parameters]\nw = 0.617\n[flight]\ny = \"v\"\nv = \"sin(w*t) - 0.1*v\"\np = \"q\"\n\
        q = \"(0.15*sin(w*t + 0.5) - 0.1*q - 0.05*p)/0.4\"\n[[contact]]\nname = \"tr\"\ngap = \"1 - y - p\"\n\
        impulse = { v = -1, q = -2.5 }\nrestitution = 0.4\n[[contact]]\nname = \"br\"\ngap = \"1 - y + 0.8*p\"\n\
        impulse = { v = -1, q = 2 }\nrestitution = 0.4\n[[contact]]\nname = \"tl\"\ngap = \"1 + y + p\"\n\
        impulse = { v = 1, q = 2.5 }\nrestitution = 0.4\n[[contact]]\nname = \"bl\"\ngap = \"1 + y - 0.8*p\"\n\
        impulse = { v = 1, q = -2 }\nrestitution = 0.4\n[initial]\ny = -0.99577893\nv = -0.02120117\np = 0.00315398\nq = -0.02110624\n";
    let found = over(&with(text, &[]), "w", (0.6151, 0.6171), (18, 0.2));
    let branch = &found[0];
    let grazes = branch.special.iter().filter(|special| {
        special.kind.is_graze() && (value(special) - 0.615_283_903_205_469_4).abs() < 1e-13
    });
    let mut struck: Vec<_> = grazes.map(|graze| graze.point.impacts.unwrap()).collect();
    struck.sort_unstable();
    assert_eq!(struck, [16, 17]);
    let all = branch.points.iter().map(|point| point.impacts.unwrap());
    let all: Vec<u64> = all.collect();
    assert!(all.contains(&18) && !all.contains(&17), "{all:?}");
    assert!(branch.ends.contains(&End::Impacts(18)));
}

/// A mass with dry friction in a shaken box touches both walls as it comes to rest on it: what an impact there leaves is the square of its rate, and equations with
/// both are singular. (Grazes by an own program with the closed form of each flight, from the motion that settles.)
#[test]
fn a_box_takes_along_what_touches_both_walls_where_it_is_held() {
    let text = "[parameters]\nh = 0.3\n[flight]\ny = 'u'\nu = '-0.325*sign(u - 0.86616712*cos(0.9607*t))'\n\
        [[contact]]\nname = 'right'\ngap = '0.9016*sin(0.9607*t) + h - y'\nimpulse = { u = -1 }\nrestitution = 0.2405\n\
        [[contact]]\nname = 'left'\ngap = 'y - 0.9016*sin(0.9607*t) + h'\nimpulse = { u = 1 }\nrestitution = 0.2405\n\
        [section.s]\nsurface = 'sin(0.9607*t)'\ndirection = 'rising'\n[initial]\ny = 0\nu = 0.5\n";
    for (range, place, impacts, known) in [
        ((0.287, 0.293), 0.290_958_868_442_5, 2, 1e-12),
        ((0.2555, 0.2575), 0.256_658_723_1, 4, 1e-10),
    ] {
        for start in [range.0, range.1] {
            let start = start.to_string();
            let found = over(&with(text, &[("h", &start)]), "h", range, (12, 0.01));
            let branch = &found[0];
            assert_eq!(branch.ends, [End::Range, End::Range], "{start}");
            let told = branch.special.iter().map(|special| {
                let off = (value(special) - place).abs();
                assert!(off < known && special.persists == Some(true), "{special:?}");
                (special.kind, special.point.impacts)
            });
            let mut told: Vec<_> = told.collect();
            told.sort_by_key(|(_, impacts)| *impacts);
            let graze = |impacts| (SpecialKind::ImpactGraze, Some(impacts));
            assert_eq!(told, [graze(impacts), graze(impacts + 1)], "{start}");
        }
    }
}
