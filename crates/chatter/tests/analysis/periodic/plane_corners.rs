//! Curves of grazes that have a corner, where friction jumps at the rate with which another impact comes, and that pass where the way over such a
//! surface and back comes to nothing.

use super::plane::{curve, of};
use super::{GRAZES, broken_off_after, nearest, over, read, value, with};
use chatter::analysis::periodic::{
    End, Known, Limits, Spec, Special, SpecialCurve, SpecialKind, special_curve,
};
use chatter::model::Model;

/// A mass that rubs on a belt of speed 0.3, and a wall; in other units of length and time.
fn on_belt([length, time]: [f64; 2], (b, w): (f64, f64)) -> Model {
    let force = length / (time * time);
    let text = format!(
        "[parameters]\nb = {b:?}\nw = {w:?}\nf = {f:?}\nk = {k:?}\nc = {c:?}\nu = {u:?}\nd = {d:?}\n[flight]\nx = 'v'\n\
         v = 'f*cos(w*t) - k*x - c*v - b*sign(v - u)'\n[[contact]]\nname = 'wall'\ngap = 'd - x'\nimpulse = {{ v = -1 }}\n\
         restitution = 0.6\n[section.s]\nsurface = 'sin(w*t)'\ndirection = 'rising'\n[initial]\nx = 0\nv = {v:?}\n",
        b = b * force,
        w = w / time,
        f = force,
        k = 1.0 / (time * time),
        c = 0.02 / time,
        u = 0.3 * length / time,
        d = 0.8 * length,
        v = 0.1 * length / time,
    );
    with(&text, &[])
}

fn graze([length, time]: [f64; 2], b: f64, (low, high): (f64, f64), at: f64) -> Special {
    let model = on_belt([length, time], (b, 0.5 * (low + high)));
    let range = (low / time, high / time);
    nearest(&over(&model, "w", range, (8, 0.05)), &GRAZES, at / time)
}

/// w at the end where b is greatest, and b.
fn last(curve: &SpecialCurve, [length, time]: [f64; 2]) -> [f64; 2] {
    let ends = [curve.points.first(), curve.points.last()];
    let ends = ends.map(|point| point.unwrap().parameters.clone());
    let force = length / (time * time);
    let all = ends.map(|end| [end[0] * time, end[1] / force]);
    match all[0][1] > all[1][1] {
        true => all[0],
        false => all[1],
    }
}

const UNITS: [f64; 2] = [1.0, 1.0];

/// The mass falls to the speed of the belt just as it comes to the wall: with less time it rubs before the impact, and the curve turns back in
/// both parameters. That place is the closed form of the flights with mpmath.
#[test]
fn a_curve_of_grazes_goes_around_a_corner_where_it_turns_back() {
    let graze = graze(UNITS, 0.14, (0.4515, 0.4535), 0.452_93);
    let model = on_belt(UNITS, (0.14, 0.45));
    for step in [0.05, 0.01] {
        let found = curve(&model, ["w", "b"], &graze, ((0.138, 0.145), step));
        assert_eq!(found.ends, [End::Range, End::Range]);
        let (w, b) = (0.450_766_527_609_768_6, 0.140_464_579_221_480_78);
        let off = |at: &&[f64; 2]| (at[0] - w).abs().max((at[1] - b).abs());
        let touches = of(&found, SpecialKind::Touch);
        let corners: Vec<f64> = touches.iter().map(|at| off(&at)).collect();
        let near = corners.iter().filter(|off| **off < 1e-6).count();
        assert_eq!(near, 1, "{touches:?}");
        assert!(corners.iter().any(|off| *off < 1e-12), "{touches:?}");
        assert!(found.points.len() < 300, "{}", found.points.len());
    }
}

/// The mass goes just over the speed of the belt before it sticks to it, ever less, and then not at all. Nothing happens there; w at the end is that
/// of the closed form with mpmath.
#[test]
fn a_curve_of_grazes_goes_on_where_a_way_over_a_surface_comes_to_nothing() {
    let all = [
        (UNITS, (0.715, 0.8), 0.722_25, 0.46, 0.750_084_909_459_902_3),
        (
            UNITS,
            (0.512, 0.56),
            0.515_28,
            0.42,
            0.625_842_675_116_823_7,
        ),
        (
            [1e-3, 1e-3],
            (0.512, 0.56),
            0.515_28,
            0.42,
            0.625_842_675_116_823_7,
        ),
        (
            [1e3, 1e2],
            (0.715, 0.8),
            0.722_25,
            0.46,
            0.750_084_909_459_902_3,
        ),
    ];
    for (units, range, at, b, w) in all {
        let graze = graze(units, 0.15, range, at);
        let model = on_belt(units, (0.15, at));
        let force = units[0] / (units[1] * units[1]);
        let mut touched: Option<[f64; 2]> = None;
        let steps: &[f64] = if units == UNITS {
            &[0.05, 0.02]
        } else {
            &[0.05]
        };
        for &step in steps {
            let within = (0.14 * force, b * force);
            let found = curve(&model, ["w", "b"], &graze, (within, step));
            assert_eq!(found.ends, [End::Range, End::Range], "{at} {step}");
            let end = last(&found, units);
            assert!(
                (end[0] - w).abs() < 1e-11 && (end[1] - b).abs() < 1e-12,
                "{end:?}"
            );
            assert!(found.points.len() < 150, "{}", found.points.len());
            // Where the mass begins to stick for a moment, whatever the steps.
            let touches = of(&found, SpecialKind::Touch);
            assert_eq!(touches.len(), 1, "{touches:?}");
            let there = [touches[0][0] * units[1], touches[0][1] / force];
            let known = touched.get_or_insert(there);
            let off = known.iter().zip(&there).map(|(a, b)| (a - b).abs());
            assert!(off.fold(0.0, f64::max) < 1e-13, "{known:?} {there:?}");
            if at == 0.722_25 {
                // That is where the flow below the speed of the belt turns back to it, of the closed form.
                let off = [
                    there[0] - 0.693_104_179_893_195_6,
                    there[1] - 0.295_588_133_558_301_7,
                ];
                assert!(off.iter().all(|off| off.abs() < 1e-13), "{there:?}");
            }
        }
    }
}

/// The curve from where records end, for so many orbits, and the records that there are then.
fn followed(
    (model, graze): (&Model, &Special),
    before: &[String],
    most: usize,
) -> (SpecialCurve, Vec<String>) {
    let mut model = model.clone();
    let start = format!("{:?}", value(graze));
    model.set_parameter("w", &start).unwrap();
    let known = Known {
        kind: graze.kind,
        monitor: None,
        state: graze.point.state.clone(),
        period: graze.point.period,
    };
    let limits = Limits {
        range: (0.138, 0.145),
        other: None,
        impacts: 60,
        points: 3000,
        longest_step: 0.05,
    };
    let free = ["w", "b"].map(|name| model.parameter_index(name).unwrap());
    let mut records = before.to_vec();
    let mut tell = broken_off_after(most, &mut records);
    let spec = Spec::default();
    let before = read(before);
    let found = special_curve(&model, &spec, (free, &known), &limits, before, &mut tell);
    drop(tell);
    (found.unwrap(), records)
}

/// Over touches, and the corner where it turns back.
#[test]
fn a_curve_that_goes_around_corners_goes_on_to_the_bit() {
    let graze = graze(UNITS, 0.14, (0.4515, 0.4535), 0.452_93);
    let model = on_belt(UNITS, (0.14, 0.45));
    let told = |curve: &SpecialCurve| {
        let points = format!("{:?} {:?}", curve.points, curve.ends);
        let special = { curve.special.iter() }.map(|special| {
            let (kind, point) = (special.kind, &special.point);
            format!("{kind:?} {point:?} {} {}", special.error, special.place)
        });
        (points, special.collect::<Vec<_>>())
    };
    let (whole, _) = followed((&model, &graze), &[], usize::MAX);
    assert!(of(&whole, SpecialKind::Touch).len() > 1);
    let mut records = Vec::new();
    for attempt in 0..100 {
        let (found, known) = followed((&model, &graze), &records, 5);
        records = known;
        if !found.ends.contains(&End::Interrupted) {
            assert!(attempt > 5, "{attempt}");
            assert_eq!(told(&found), told(&whole));
            return;
        }
    }
    panic!("it does not come to its ends");
}
