//! Laws of curves, and values of SciPy's.

use super::*;
use crate::numerics::Scalar;
use proptest::prelude::*;

fn exact(values: &[f64]) -> Vec<DoubleDouble> {
    values
        .iter()
        .map(|&value| DoubleDouble::from(value))
        .collect()
}

fn ends(slopes: [f64; 2]) -> Option<[DoubleDouble; 2]> {
    Some(slopes.map(DoubleDouble::from))
}

fn curve(kind: CurveKind, x: &[f64], y: &[f64]) -> Curve {
    Curve::new("f", kind, None, &exact(x), &exact(y), None).unwrap()
}

fn clamped(x: &[f64], y: &[f64], slopes: [f64; 2]) -> Curve {
    Curve::new(
        "f",
        CurveKind::Cubic,
        None,
        &exact(x),
        &exact(y),
        ends(slopes),
    )
    .unwrap()
}

/// Sizes are compared with this: thirty digits of numbers of order one, less what steep knots lose.
const CLOSE: f64 = 1e-26;

fn close(a: DoubleDouble, b: DoubleDouble) -> bool {
    (a - b).abs().high() <= CLOSE * (1.0 + a.abs().high())
}

const X: [f64; 6] = [0.0, 0.5, 1.25, 2.0, 3.5, 4.0];
const Y: [f64; 6] = [1.0, 2.0, -0.5, -0.75, 3.0, 1.0];
const AT: [f64; 6] = [0.1, 0.5, 0.8, 1.9, 2.75, 3.9];

/// By symmetry a cam has no slope at its ends of travel, and rounding of the spline's equations gives it none.
#[test]
fn a_slope_that_is_rounding_is_none() {
    let cam = curve(
        CurveKind::PeriodicCubic,
        &[0.0, 90.0, 180.0, 270.0, 360.0],
        &[0.0, 2.5, 4.0, 2.5, 0.0],
    );
    for at in [0.0, 180.0, 360.0] {
        assert_eq!(cam.value(at, 1), 0.0);
        assert_eq!(cam.value(DoubleDouble::from(at), 1), DoubleDouble::ZERO);
    }
    assert!(cam.value(90.0, 1) > 0.02);
}

#[test]
fn values_and_slopes_are_those_of_scipy() {
    let table: [(&str, Curve, [f64; 6], [f64; 6]); 4] = [
        (
            "natural",
            curve(CurveKind::Cubic, &X, &Y),
            [
                1.3220732700135684,
                2.0,
                1.2911180461329712,
                -0.9481553846926986,
                1.927408412483039,
                1.4974111261872458,
            ],
            [
                3.1190049751243785,
                -0.5431931252826777,
                -3.7135594753505208,
                1.6503603196140495,
                3.6654228855721396,
                -4.892935323383084,
            ],
        ),
        (
            "clamped",
            clamped(&X, &Y, [0.25, -2.0]),
            [
                1.1131709717097171,
                2.0,
                1.4187490774907747,
                -0.9744013940139408,
                2.2027790590405902,
                1.2857810578105786,
            ],
            [
                1.880492004920049,
                0.4268142681426813,
                -3.7283148831488306,
                1.8744157441574396,
                3.8823031980319804,
                -3.6011685116851195,
            ],
        ),
        (
            "periodic",
            curve(CurveKind::PeriodicCubic, &X, &Y),
            [
                1.0413750000000002,
                2.0,
                1.4629107142857143,
                -0.9843832671957673,
                2.312360491071428,
                1.2007321428571434,
            ],
            [
                1.454717261904762,
                0.7607886904761902,
                -3.7324255952380954,
                1.9585069444444432,
                3.9706101190476186,
                -3.0821577380952396,
            ],
        ),
        (
            "pchip",
            curve(CurveKind::Pchip, &X, &Y),
            [
                1.3685333333333332,
                2.0,
                1.1636363636363634,
                -0.7448552188552189,
                1.125,
                1.5680000000000005,
            ],
            [
                3.2426666666666666,
                0.0,
                -4.606060606060606,
                -0.10181818181818186,
                3.75,
                -5.640000000000001,
            ],
        ),
    ];
    for (name, curve, values, slopes) in table {
        for ((&at, value), slope) in AT.iter().zip(values).zip(slopes) {
            let here = [curve.value(at, 0), curve.value(at, 1)];
            assert!(
                (here[0] - value).abs() < 1e-14,
                "{name} at {at}: {} {value}",
                here[0]
            );
            assert!(
                (here[1] - slope).abs() < 4e-14,
                "{name}' at {at}: {} {slope}",
                here[1]
            );
        }
    }
    let periodic = curve(CurveKind::PeriodicCubic, &X, &Y);
    assert!((periodic.value(-1.3, 0) - 2.10887962962963).abs() < 1e-14);
    assert!((periodic.value(9.7, 0) - -1.217053571428572).abs() < 1e-14);
    // Two pieces, each the neighbour of the other on both sides.
    let two = curve(
        CurveKind::PeriodicCubic,
        &[0.0, 1.0, 3.0],
        &[2.0, -1.0, 2.0],
    );
    assert_eq!(
        [0.5, 1.5, 2.5].map(|at| two.value(at, 0)),
        [0.5, -0.8125, 1.8125]
    );
    assert_eq!(
        [0.0, 1.0, 2.0].map(|at| two.value(at, 1)),
        [-1.5, -1.5, 3.0]
    );
    // Ends of a monotone curve that are cut back.
    let bent = curve(CurveKind::Pchip, &[0.0, 1.0, 3.0], &[0.0, 1.0, -9.0]);
    assert_eq!(
        [0.5, 1.5, 2.5].map(|at| bent.value(at, 0)),
        [0.875, 0.28125, -4.90625]
    );
    let level = curve(CurveKind::Pchip, &[0.0, 1.0, 3.0], &[0.0, 5.0, 5.5]);
    assert!((level.value(2.5, 0) - 5.471507352941176).abs() < 1e-14);
    assert_eq!(level.piece(1).unwrap().value(3.0, 1), 0.0);
}

#[test]
fn pieces_are_numbered_from_the_first_knot() {
    let (x, y) = (exact(&[0.0, 1.0, 3.0]), exact(&[2.0, 4.0, 4.0]));
    let steps = |outside| Curve::new("f", CurveKind::Steps, Some(outside), &x, &y, None).unwrap();
    let number = |curve: &Curve, at: f64| curve.piece_at(DoubleDouble::from(at));
    let open = steps(Outside::Error);
    assert_eq!(
        [-1.0, 0.0, 0.5, 1.0, 3.0, 3.5].map(|at| number(&open, at)),
        [-1, 0, 0, 1, 1, 2]
    );
    assert!(open.piece(-1).is_none() && open.piece(2).is_none());
    assert!(open.value(-1e-9, 0).is_nan() && open.value(f64::NAN, 0).is_nan());
    let held = steps(Outside::Hold);
    assert_eq!(
        [f64::NEG_INFINITY, 0.0, 1.0, 3.0, f64::INFINITY].map(|at| number(&held, at)),
        [-1, 0, 1, 2, 2]
    );
    assert_eq!(
        [f64::NEG_INFINITY, 0.5, 2.0, 3.0, f64::INFINITY].map(|at| held.value(at, 0)),
        [2.0, 2.0, 4.0, 4.0, 4.0]
    );
    assert!(held.value(f64::NAN, 0).is_nan());
    let [before, after] = [-1, 2].map(|number| held.piece(number).unwrap());
    assert_eq!((before.low, before.high), (None, Some(x[0])));
    assert_eq!((after.low, after.high), (Some(x[2]), None));

    let turning = curve(CurveKind::PeriodicCubic, &[0.0, 1.0, 3.0], &[2.0, 4.0, 2.0]);
    assert_eq!(
        [-3.0, -2.5, -1.0, 0.0, 1.0, 3.0, 4.0, 29.9, 30.0].map(|at| number(&turning, at)),
        [-2, -2, -1, 0, 1, 2, 3, 19, 20]
    );
    assert_eq!(turning.period(), Some(DoubleDouble::from(3.0)));
    for far in [1e300, -1e300, f64::INFINITY, f64::NAN] {
        assert!(turning.value(far, 0).is_nan());
    }
    assert!((turning.value(3e9 + 0.25, 0) - turning.value(0.25, 0)).abs() < 1e-14);
}

#[test]
fn wrong_knots_are_told() {
    use CurveKind::{Cubic, Linear, Pchip, PeriodicCubic};
    let wrong = |kind, outside, x: &[f64], y: &[f64], slopes: Option<[f64; 2]>| {
        Curve::new(
            "f",
            kind,
            outside,
            &exact(x),
            &exact(y),
            slopes.and_then(ends),
        )
        .unwrap_err()
    };
    let table: [(CurveError, &str); 12] = [
        (
            wrong(Linear, None, &[0.0, 1.0], &[0.0], None),
            "there are 2 values of x and 1 of y",
        ),
        (
            wrong(Linear, None, &[0.0], &[0.0], None),
            "a linear table takes 2 knots at least, not 1",
        ),
        (
            wrong(PeriodicCubic, None, &[0.0, 1.0], &[0.0, 0.0], None),
            "a periodic-cubic table takes 3 knots at least, not 2",
        ),
        (
            wrong(Pchip, None, &[0.0, f64::NAN], &[0.0, 0.0], None),
            "value 2 of x is NaN",
        ),
        (
            wrong(Pchip, None, &[0.0, 1.0], &[f64::INFINITY, 0.0], None),
            "value 1 of y is inf",
        ),
        (
            wrong(Linear, None, &[0.0, 2.0, 1.0], &[0.0; 3], None),
            "x does not increase: 1 follows 2",
        ),
        (
            wrong(Linear, None, &[0.0, 2.0, 2.0], &[0.0; 3], None),
            "x is 2 twice",
        ),
        (
            wrong(
                PeriodicCubic,
                None,
                &[0.0, 1.0, 2.0],
                &[0.0, 1.0, 0.5],
                None,
            ),
            "a periodic table begins at y = 0 and ends at 0.5",
        ),
        (
            wrong(
                PeriodicCubic,
                Some(Outside::Hold),
                &[0.0, 1.0, 2.0],
                &[0.0; 3],
                None,
            ),
            "a periodic table has no outside",
        ),
        (
            wrong(Pchip, None, &[0.0, 1.0], &[0.0; 2], Some([0.0; 2])),
            "a pchip table takes no slopes",
        ),
        (
            wrong(Cubic, None, &[0.0, 1.0], &[0.0; 2], Some([0.0, f64::NAN])),
            "the slope at the last end is NaN",
        ),
        (
            wrong(Linear, None, &[-1e308, 1e308], &[0.0, 1.0], None),
            "from knot 1 on the numbers are too large, or too close, to compute with",
        ),
    ];
    for (error, message) in table {
        assert_eq!(error.to_string(), message);
    }
    let (x, y) = ([0.0, 1.0, 1.0 + f64::EPSILON], [0.0, 0.0, 1e308]);
    assert_eq!(
        wrong(Cubic, None, &x, &y, None),
        CurveError::Overflow { index: 0 }
    );
    let many = vec![0.0; MOST_KNOTS + 1];
    let knots = many.len();
    assert_eq!(
        wrong(Linear, None, &many, &many, None),
        CurveError::TooMany { knots }
    );
}

#[test]
fn names_are_read_back() {
    for kind in [
        CurveKind::Linear,
        CurveKind::Cubic,
        CurveKind::Pchip,
        CurveKind::PeriodicCubic,
        CurveKind::Steps,
    ] {
        assert_eq!(CurveKind::from_name(kind.name()), Some(kind));
    }
    for outside in [Outside::Error, Outside::Hold] {
        assert_eq!(Outside::from_name(outside.name()), Some(outside));
    }
    assert_eq!(CurveKind::from_name("spline"), None);
}

/// Steps between knots, values, and slopes for the ends.
fn knots() -> impl Strategy<Value = (Vec<f64>, Vec<f64>, [f64; 2])> {
    (
        prop::collection::vec((0.05_f64..2.0, -3.0_f64..3.0), 3..12),
        -2.0_f64..2.0,
        -2.0_f64..2.0,
    )
        .prop_map(|(pairs, a, b)| {
            let mut at = -4.0;
            let x = pairs.iter().map(|&(step, _)| {
                at += step;
                at
            });
            (x.collect(), pairs.iter().map(|&(_, y)| y).collect(), [a, b])
        })
}

fn every_kind(x: &[f64], y: &[f64], slopes: [f64; 2]) -> Vec<Curve> {
    let mut closed = y.to_vec();
    closed[y.len() - 1] = y[0];
    vec![
        curve(CurveKind::Linear, x, y),
        curve(CurveKind::Steps, x, y),
        curve(CurveKind::Pchip, x, y),
        curve(CurveKind::Cubic, x, y),
        clamped(x, y, slopes),
        curve(CurveKind::PeriodicCubic, x, &closed),
    ]
}

proptest! {
    #[test]
    fn curves_pass_through_their_knots_as_smoothly_as_they_say((x, y, slopes) in knots()) {
        for curve in every_kind(&x, &y, slopes) {
            let inner = x.len() as i64 - 1;
            let numbers = if curve.period().is_some() { -2 * inner..2 * inner } else { 1..inner };
            for number in numbers {
                let (left, right) = (curve.piece(number - 1).unwrap(), curve.piece(number).unwrap());
                let knot = right.low.unwrap();
                prop_assert_eq!(left.high.unwrap(), knot);
                prop_assert_eq!(curve.piece_at(knot), number);
                let before = knot - DoubleDouble::from(1e-20);
                prop_assert_eq!(curve.piece_at(before), number - 1);
                for derivative in 0..4 {
                    let [l, r] = [left, right].map(|piece| piece.value(knot, derivative));
                    if i32::from(derivative) <= curve.smoothness() {
                        prop_assert!(close(l, r), "{:?} {derivative} {l} {r}", curve.kind());
                    }
                    prop_assert!(usize::from(derivative) <= curve.degree() || l == DoubleDouble::ZERO);
                }
            }
            for (place, &at) in x.iter().enumerate().take(x.len() - 1) {
                prop_assert_eq!(curve.value(at, 0), y[place]);
            }
            if curve.kind() != CurveKind::Steps {
                let last = curve.value(DoubleDouble::from(x[x.len() - 1]), 0);
                let given = if curve.period().is_some() { y[0] } else { y[y.len() - 1] };
                prop_assert!(close(last, DoubleDouble::from(given)));
            }
        }
    }

    #[test]
    fn the_ends_are_natural_or_as_steep_as_asked((x, y, slopes) in knots()) {
        let last = x.len() as i64 - 2;
        let [from, to] = [x[0], x[x.len() - 1]].map(DoubleDouble::from);
        let natural = curve(CurveKind::Cubic, &x, &y);
        for (number, at) in [(0, from), (last, to)] {
            prop_assert!(close(natural.piece(number).unwrap().value(at, 2), DoubleDouble::ZERO));
        }
        let clamped = clamped(&x, &y, slopes);
        for ((number, at), slope) in [(0, from), (last, to)].into_iter().zip(slopes) {
            prop_assert!(close(clamped.piece(number).unwrap().value(at, 1), DoubleDouble::from(slope)));
        }
    }

    #[test]
    fn lines_and_cubics_are_what_they_were(
        (x, _, _) in knots(), [a, b, c, d] in prop::array::uniform4(-2.0_f64..2.0), part in 0.0_f64..1.0,
    ) {
        let exact_x = exact(&x);
        let [a, b, c, d] = [a, b, c, d].map(DoubleDouble::from);
        let (two, three) = (DoubleDouble::from(2.0), DoubleDouble::from(3.0));
        let cubic = |x: DoubleDouble| a + x * (b + x * (c + x * d));
        let slope = |x: DoubleDouble| b + x * (two * c + x * three * d);
        let line = |x: DoubleDouble| a + b * x;
        let at = |values: &dyn Fn(DoubleDouble) -> DoubleDouble| -> Vec<DoubleDouble> {
            exact_x.iter().map(|&x| values(x)).collect()
        };
        let (first, last) = (exact_x[0], exact_x[x.len() - 1]);
        let here = first + (last - first) * DoubleDouble::from(part);
        for kind in [CurveKind::Linear, CurveKind::Pchip, CurveKind::Cubic] {
            let straight = Curve::new("f", kind, None, &exact_x, &at(&line), None).unwrap();
            prop_assert!(close(straight.value(here, 0), line(here)));
        }
        let slopes = Some([slope(first), slope(last)]);
        let same = Curve::new("f", CurveKind::Cubic, None, &exact_x, &at(&cubic), slopes).unwrap();
        prop_assert!(close(same.value(here, 0), cubic(here)));
        prop_assert!(close(same.value(here, 1), slope(here)));
    }

    #[test]
    fn monotone_data_stay_monotone_and_others_between_their_knots(
        (x, y, _) in knots(), parts in prop::collection::vec(0.0_f64..1.0, 20),
    ) {
        let mut sorted = y.clone();
        sorted.sort_by(f64::total_cmp);
        let rising = curve(CurveKind::Pchip, &x, &sorted);
        let any = curve(CurveKind::Pchip, &x, &y);
        for place in 0..x.len() - 1 {
            let (low, high) = (y[place].min(y[place + 1]), y[place].max(y[place + 1]));
            for part in &parts {
                let at = x[place] + (x[place + 1] - x[place]) * part;
                prop_assert!(rising.value(at, 1) > -1e-14);
                let value = any.value(at, 0);
                prop_assert!(low - 1e-14 < value && value < high + 1e-14);
            }
        }
    }

    #[test]
    fn a_periodic_curve_is_the_same_a_period_later((x, y, slopes) in knots(), at in -30.0_f64..30.0, laps in -9_i32..9) {
        let curve = every_kind(&x, &y, slopes).pop().unwrap();
        let at = DoubleDouble::from(at);
        let later = at + curve.period().unwrap() * DoubleDouble::from(f64::from(laps));
        for derivative in 0..2 {
            prop_assert!(close(curve.value(at, derivative), curve.value(later, derivative)));
        }
        let number = curve.piece_at(at);
        let piece = curve.piece(number).unwrap();
        prop_assert!(piece.low.unwrap() <= at && at < piece.high.unwrap());
    }

    #[test]
    fn any_numbers_make_a_curve_or_an_error(
        x in prop::collection::vec(any::<f64>(), 0..6), y in prop::collection::vec(any::<f64>(), 0..6),
        kind in 0..5_usize, clamped in any::<bool>(), slope in any::<f64>(), at in any::<f64>(), sorted in any::<bool>(),
    ) {
        let mut x = x;
        if sorted {
            x.sort_by(f64::total_cmp);
        }
        let kind = CurveKind::from_name(CURVE_KINDS[kind]).unwrap();
        let slopes = if clamped { ends([slope; 2]) } else { None };
        match Curve::new("f", kind, None, &exact(&x), &exact(&y), slopes) {
            Ok(curve) => {
                for (&at, &value) in x.iter().zip(&y).take(x.len() - 1) {
                    prop_assert_eq!(curve.value(at, 0), value);
                }
                // Whatever the argument is, there is an answer.
                prop_assert!(curve.value(at, 0).is_nan() || curve.piece(curve.piece_at(DoubleDouble::from(at))).is_some());
            }
            Err(error) => prop_assert!(!error.to_string().is_empty()),
        }
    }
}
