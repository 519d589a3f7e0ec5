//! Known curves and special points of maps.

use super::*;
use crate::numerics::Matrix;

type Image = (Vec<f64>, Matrix<f64>);

fn logistic(x: &[f64], p: &[f64]) -> Result<Image, Left> {
    let mut slopes = Matrix::zeros(1, 2);
    slopes[(0, 0)] = p[0] * (1.0 - 2.0 * x[0]);
    slopes[(0, 1)] = x[0] * (1.0 - x[0]);
    Ok((vec![p[0] * x[0] * (1.0 - x[0])], slopes))
}

/// x' = 1 - a x^2 + y, y' = b x.
fn henon(x: &[f64], p: &[f64]) -> Result<Image, Left> {
    let mut slopes = Matrix::zeros(2, 4);
    slopes[(0, 0)] = -2.0 * p[0] * x[0];
    slopes[(0, 1)] = 1.0;
    slopes[(0, 2)] = -x[0] * x[0];
    slopes[(1, 0)] = p[1];
    slopes[(1, 3)] = x[0];
    Ok((vec![1.0 - p[0] * x[0] * x[0] + x[1], p[1] * x[0]], slopes))
}

fn multiplier(orbit: &MapOrbit<'_>, at: &[f64]) -> f64 {
    orbit.monodromy(at).unwrap()[(0, 0)]
}

/// The first period doubling of the cycle that is stable just above `from`, in the logistic map.
fn doubling(period: usize, from: f64) -> f64 {
    let mut x = 0.4;
    for _ in 0..200_000 {
        x = from * x * (1.0 - x);
    }
    let mut start = Vec::new();
    for _ in 0..period {
        start.push(x);
        x = from * x * (1.0 - x);
    }
    start.push(from);
    let mut orbit = MapOrbit::new(&logistic, period, (&[1.0], &[1.0]));
    let station = Station::near(&mut orbit, &start, period).unwrap();
    let mut curve = Curve::new(station, Settings::default());
    let mut before = multiplier(&orbit, &curve.station.at) + 1.0;
    for _ in 0..10_000 {
        let (next, step) = curve.next(&mut orbit).unwrap();
        let here = multiplier(&orbit, &next.at) + 1.0;
        if before > 0.0 && here <= 0.0 {
            let reference = MapOrbit::new(&logistic, period, (&[1.0], &[1.0]));
            let (found, _) = locate(
                &mut orbit,
                &curve.station,
                step,
                (before, here),
                &mut |_, station| Some(multiplier(&reference, &station.at) + 1.0),
            )
            .unwrap();
            let singular = Singular::near(&mut orbit, &found.at, -1.0).unwrap();
            let mut held = Held::singular(&mut orbit, singular);
            return newton(&mut held, &found.at, &[]).unwrap().at[period];
        }
        before = here;
        curve.moves(next);
    }
    panic!("no doubling of period {period}");
}

#[test]
fn feigenbaums_number_of_the_logistic_map() {
    let mut found = vec![doubling(1, 2.5)];
    assert!((found[0] - 3.0).abs() < 1e-14, "{}", found[0]);
    found.push(doubling(2, 3.2));
    assert!(
        (found[1] - (1.0 + 6.0_f64.sqrt())).abs() < 1e-13,
        "{}",
        found[1]
    );
    for n in 2..9 {
        // Where the next cycle is surely stable.
        let (a, b) = (found[n - 2], found[n - 1]);
        let delta = if n == 2 {
            4.75
        } else {
            (a - found[n - 3]) / (b - a)
        };
        found.push(doubling(1 << n, b + 0.5 * (b - a) / delta));
    }
    let ratio = |n: usize| (found[n - 1] - found[n - 2]) / (found[n] - found[n - 1]);
    // Aitken's extrapolation of the ratios.
    let (a, b, c) = (ratio(6), ratio(7), ratio(8));
    let delta = c - (c - b) * (c - b) / (c - 2.0 * b + a);
    assert!((delta - 4.669_201_609).abs() < 5e-6, "{delta} {found:?}");
}

#[test]
fn folds_and_doublings_of_henons_map() {
    // Fixed points: a x^2 + (1 - b) x - 1 = 0; fold at a = -(1 - b)^2 / 4, doubling at a = 3 (1 - b)^2 / 4.
    let mut orbit = MapOrbit::new(&henon, 1, (&[1.0, 1.0], &[1.0, 1.0]));
    for (sign, factor) in [(1.0, -0.25), (-1.0, 0.75)] {
        let exact = |b: f64| factor * (1.0 - b) * (1.0 - b);
        let b = 0.3;
        let x = if sign > 0.0 {
            2.0 / (1.0 - b)
        } else {
            2.0 / (3.0 * (1.0 - b))
        };
        let start = [x + 0.02, b * x, exact(b) + 0.01, b];
        let singular = Singular::near(&mut orbit, &start, sign).unwrap();
        let mut held = Held::singular(&mut orbit, singular);
        assert_eq!((held.unknowns(), held.parameters()), (4, 1));
        let station = Station::near(&mut held, &start, 3).unwrap();
        let mut curve = Curve::new(station, Settings::default());
        for _ in 0..60 {
            let (next, _) = curve.next(&mut held).unwrap();
            let (a, b) = (next.at[2], next.at[3]);
            assert!((a - exact(b)).abs() < 1e-12, "{a} {b}");
            curve.moves(next);
        }
        assert!(curve.station.parameter() > 0.4);
    }
}

/// A curve followed there and back is the same curve, and passes its fold both ways.
#[test]
fn a_curve_is_the_same_both_ways() {
    let fixed = |x: &[f64], p: &[f64]| {
        let (image, slopes) = henon(x, &[p[0], 0.3])?;
        let mut kept = Matrix::zeros(2, 3);
        for i in 0..2 {
            kept.row_mut(i).copy_from_slice(&slopes.row(i)[..3]);
        }
        Ok::<_, Left>((image, kept))
    };
    let mut single = MapOrbit::new(&fixed, 1, (&[1.0, 1.0], &[1.0]));
    let station = Station::near(&mut single, &[0.8, 0.24, 0.5], 2)
        .unwrap()
        .reversed();
    let mut curve = Curve::new(station.clone(), Settings::default());
    let mut least = f64::INFINITY;
    for _ in 0..80 {
        let (next, _) = curve.next(&mut single).unwrap();
        least = least.min(next.parameter());
        curve.moves(next);
    }
    // Past the fold at -0.1225, on the other fixed point.
    assert!(curve.station.parameter() > least && (least + 0.1225).abs() < 1e-2);
    let mut back = Curve::new(curve.station.reversed(), Settings::default());
    for _ in 0..400 {
        let (next, _) = back.next(&mut single).unwrap();
        let (x, a) = (next.at[0], next.parameter());
        assert!((a * x * x + 0.7 * x - 1.0).abs() < 1e-12);
        back.moves(next);
        if back.station.parameter() > 0.5 {
            break;
        }
    }
    assert!(back.station.at[0] > 0.0 && back.station.parameter() > 0.5);
}

/// Where y (u^2 + v^2) = 0 with u = q + y and v = q - y, q = p - 1/2: a curve y = 0 on which u and v vanish at once, and all derivatives.
struct Halves([f64; 2]);

impl Problem<f64> for Halves {
    fn unknowns(&self) -> usize {
        2
    }

    fn parameters(&self) -> usize {
        1
    }

    fn scales(&self) -> &[f64] {
        &self.0
    }

    fn evaluate(&mut self, at: &[f64]) -> Result<Linearised<f64>, Left> {
        let (y, q) = (at[0], at[1] - 0.5);
        Ok(Linearised {
            residual: vec![2.0 * y * (q * q + y * y)],
            jacobian: Matrix::from_rows(&[vec![2.0 * q * q + 6.0 * y * y, 4.0 * y * q]]),
        })
    }

    fn monitor(&mut self, index: usize, at: &[f64]) -> Result<(f64, Vec<f64>), Left> {
        let (y, q) = (at[0], at[1] - 0.5);
        Ok(match index {
            0 => (q + y, vec![1.0, 1.0]),
            _ => (q - y, vec![-1.0, 1.0]),
        })
    }
}

#[test]
fn a_coincidence_is_a_simple_root_where_one_condition_has_a_threefold_one() {
    let mut halves = Halves([1.0, 1.0]);
    let start = [0.012, 0.51];
    let alone = newton(&mut Held::monitor(&mut halves, 0), &start, &[]);
    // Newton's method gains a third at each correction, if it is not refused.
    assert!(alone.is_err_and(|error| matches!(error, NewtonError::Stalled { .. })));
    let both = coincidence(&mut halves, &start, [0, 1]).unwrap();
    let [y, p] = both.found.at[..] else { panic!() };
    assert!(y.abs() < 1e-15 && (p - 0.5).abs() < 1e-15, "{y} {p}");
    assert!(both.unfolds.abs() < 1e-15, "{}", both.unfolds);
    // Along the curve: both grow alike.
    assert!(both.along[0].abs() < 1e-12 && (both.along[1] - 1.0).abs() < 1e-12);
}

/// x' = 1/p.
fn inverse(_: &[f64], p: &[f64]) -> Result<Image, Left> {
    let mut slopes = Matrix::zeros(1, 2);
    slopes[(0, 1)] = -1.0 / (p[0] * p[0]);
    Ok((vec![1.0 / p[0]], slopes))
}

#[test]
fn branches_meet_nowhere_on_a_curve_wherever_it_begins() {
    for held in [0, 1] {
        let mut orbit = MapOrbit::new(&inverse, 1, (&[1.0], &[1.0]));
        let begins = Station::near(&mut orbit, &[0.5, 2.0], held).unwrap();
        assert!(begins.parameter_slope() > 0.0);
        for begins in [begins.clone(), begins.reversed()] {
            let (next, _) = begins.ahead(&mut orbit, 0.01).unwrap();
            assert!(begins.orientation * next.orientation > 0.0, "{held}");
        }
    }
}
