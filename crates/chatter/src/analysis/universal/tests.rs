//! Laws of Upsilon, and its values against slow independent ones.

use super::reference::REFERENCE;
use super::*;
use crate::numerics::dispatch::{Kernel, dispatch};
use crate::numerics::{DoubleDouble, Lanes, Real, Scalar};
use proptest::prelude::*;
use std::sync::OnceLock;

type D = DoubleDouble;

fn exact(text: &str) -> D {
    text.parse().unwrap()
}

fn off(a: D, b: D) -> f64 {
    ((a - b) / b).abs().to_f64()
}

/// The two terms whose difference is q(s_1): where they nearly cancel, Upsilon is near a zero, and only an error
/// relative to them can be asked for.
fn cancellation(r: f64, u1: f64) -> f64 {
    let s = (1.0 - 8.0 * u1 / 3.0).max(0.0).sqrt();
    let (up, down) = (
        0.75 * r * s * (1.0 - s),
        (3.0 * s - 1.0) * (3.0 * s - 1.0) / 8.0,
    );
    (up + down) / (up - down).abs()
}

#[test]
fn values_agree_with_the_plain_limits() {
    for &(r, lap_end, points) in REFERENCE {
        let double = Universal::new(r).unwrap();
        let fine = Universal::new(D::from(r)).unwrap();
        assert!(off(double.lap_end().into(), exact(lap_end)) < 2e-16);
        assert!(off(fine.lap_end(), exact(lap_end)) < 5e-31);
        for &(x, n, u1, value, derivative) in points {
            let (a, b) = (double.at(x), fine.at(D::from(x)));
            assert_eq!(a.lap, n as f64);
            assert_eq!(b.lap, D::from(n as f64));
            let (u1, value, derivative) = (exact(u1), exact(value), exact(derivative));
            // Powers of lambda and eta lose as many digits as their logarithm has.
            let logarithm = 10.0 + (n as f64 * double.constants().ln_eta).abs();
            assert!(off(a.u1.into(), u1) < 4e-16, "{r} {x}");
            assert!(off(b.u1, u1) < 1e-30 * logarithm, "{r} {x}");
            assert!(off(a.derivative.into(), derivative) < 1e-14, "{r} {x}");
            // The references are differences, good to 20 digits.
            assert!(off(b.derivative, derivative) < 1e-20, "{r} {x}");
            if value.abs() < D::from(1e-250) {
                continue;
            }
            let room = cancellation(r, u1.to_f64());
            assert!(off(a.value.into(), value) < 2e-15 * room, "{r} {x}");
            // Double-double takes its argument as rounded to 32 digits, and steep graphs show it.
            let steep = (D::from(x) * derivative / value).to_f64().abs();
            let digits = 3e-31 * logarithm * (room + steep);
            assert!(
                off(b.value, value) < digits,
                "{r} {x} {}",
                off(b.value, value)
            );
        }
    }
}

/// Restitutions of the sweeps, with Upsilon prepared in both precisions. For the first, a double u_1 cannot tell the zeros
/// of Upsilon from the pole of g.
fn prepared() -> &'static [(Universal<f64>, Universal<D>)] {
    static PREPARED: OnceLock<Vec<(Universal<f64>, Universal<D>)>> = OnceLock::new();
    PREPARED.get_or_init(|| {
        [
            1e-100,
            1e-12,
            1e-6,
            0.001,
            0.01,
            0.1,
            0.24,
            0.26,
            0.3,
            0.5,
            0.65,
            0.8,
            0.9,
            0.95,
            0.99,
            0.999,
            1.0 - 1e-6,
            1.0 - 1e-9,
            1.0 - 1e-12,
        ]
        .into_iter()
        .map(|r: f64| {
            (
                Universal::new(r).unwrap(),
                Universal::new(D::from(r)).unwrap(),
            )
        })
        .collect()
    })
}

/// From how strong a cancellation a point counts as near a zero of Upsilon.
const NEAR_ZERO: f64 = 10.0;

fn check_against_double_double(index: usize, x: f64) -> Result<(), TestCaseError> {
    let (double, fine) = &prepared()[index];
    let r = double.constants().restitution;
    let (a, b) = (double.at(x), fine.at(D::from(x)));
    let room = cancellation(r, b.u1.to_f64());
    let value = b.value.to_f64();
    let difference = (D::from(a.value) - b.value).to_f64().abs();
    prop_assert_eq!(a.lap, b.lap.to_f64());
    if room < NEAR_ZERO && value.abs() > f64::MIN_POSITIVE {
        prop_assert!(
            difference <= 1e-14 * value.abs(),
            "{r} {x:e} {difference:e} {value:e}"
        );
    }
    prop_assert!(
        difference <= 3e-15 * room * value.abs() + f64::MIN_POSITIVE,
        "{r} {x:e} {difference:e} {value:e} {room}"
    );
    // The derivative has a zero and a pole of its own: relative to itself and to the mean slope over the lap.
    let slope = b.derivative.to_f64();
    let mean = room * value.abs() / x / double.constants().one_minus_eta;
    let difference = (D::from(a.derivative) - b.derivative).to_f64().abs();
    prop_assert!(
        !slope.is_finite() || value == 0.0 || difference <= 1e-14 * (slope.abs() + mean),
        "{r} {x:e}: {} {slope}",
        a.derivative
    );
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]
    #[test]
    fn doubles_agree_with_double_doubles(index in 1_usize..19, exponent in -300.0_f64..20.0) {
        check_against_double_double(index, libm::exp10(exponent))?;
    }

    #[test]
    fn doubles_agree_where_maps_live(index in 1_usize..19, part in 0.1_f64..1.0, shrink in 0.0_f64..6.0) {
        let end = prepared()[index].0.lap_end();
        check_against_double_double(index, end * part * libm::exp10(-shrink))?;
    }

    #[test]
    fn doubles_agree_next_to_the_joints(index in 4_usize..17, lap in 0_i32..40, distance in 0.5_f64..15.5, side in prop::bool::ANY) {
        let (double, fine) = &prepared()[index];
        let joint = fine.lap_end() * fine.constants().eta.powi(lap);
        let distance = libm::exp10(-distance) * double.constants().one_minus_eta;
        let x = joint.to_f64() * if side { 1.0 + distance } else { 1.0 - distance };
        check_against_double_double(index, x)?;
    }

    /// Upsilon(eta x) = lambda^2 Upsilon(x), Upsilon'(eta x) = (lambda^2 / eta) Upsilon'(x), u_1 the same, n one more.
    #[test]
    fn upsilon_is_self_similar(index in 0_usize..16, exponent in -10.0_f64..3.0) {
        let (_, fine) = &prepared()[index];
        let c = fine.constants();
        let x = D::from(libm::exp10(exponent)) * fine.lap_end();
        let (here, there) = (fine.at(x), fine.at(x * c.eta));
        prop_assert_eq!(there.lap, here.lap + D::ONE);
        let lambda_squared = c.lambda * c.lambda;
        let error = (there.value - lambda_squared * here.value).abs().to_f64();
        let steep = (x * here.derivative * lambda_squared).abs().to_f64();
        let size = (lambda_squared * here.value).abs().to_f64() * cancellation(c.restitution.to_f64(), here.u1.to_f64());
        prop_assert!(error < 3e-30 * (size + (1.0 + here.lap.abs().to_f64()) * steep), "{error:e} {size:e} {steep:e}");
    }

    /// The derivative against a central difference of fourth order.
    #[test]
    fn the_derivative_is_that_of_the_values(index in 2_usize..16, exponent in -10.0_f64..1.0) {
        let (_, fine) = &prepared()[index];
        let x = D::from(libm::exp10(exponent)) * fine.lap_end();
        let at = fine.at(x);
        let step = x * fine.constants().one_minus_eta * D::from(1e-5);
        let value = |k: f64| fine.value(x + D::from(k) * step);
        // Away from the joints, where the difference would straddle two laps or be taken of a square root.
        let beside = |k: f64| fine.at(x + D::from(k) * step).lap == at.lap;
        prop_assume!(beside(1e4) && beside(-1e3));
        let eight = D::from(8.0);
        let difference = (eight * (value(1.0) - value(-1.0)) - (value(2.0) - value(-2.0))) / (D::from(12.0) * step);
        let scale = at.derivative.abs() + at.value.abs() / (x * fine.constants().one_minus_eta);
        prop_assert!(((difference - at.derivative) / scale).abs().to_f64() < 1e-9);
    }

    /// Eight lanes at once and each by itself, with vector instructions and without: the same bits.
    #[test]
    fn a_lane_is_a_scalar(index in 0_usize..19, exponents in prop::array::uniform8(-330.0_f64..310.0), odd in 0_usize..8) {
        #[derive(Clone, Copy)]
        struct Run<'a>(&'a Universal<f64>, Lanes<8>);
        impl Kernel for Run<'_> {
            type Output = [[f64; 8]; 5];
            #[inline(always)]
            fn run(self) -> Self::Output {
                let e = self.0.evaluation(self.1);
                [self.0.upsilon(self.1).0, e.value.0, e.derivative.0, e.lap.0, e.u1.0]
            }
        }
        let universal = &prepared()[index].0;
        let mut xs = exponents.map(libm::exp10);
        xs[odd] = [0.0, -1.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY, universal.lap_end(), 5e-324, f64::MAX][odd];
        let bits = |rows: [[f64; 8]; 5]| rows.map(|row| row.map(f64::to_bits));
        let run = Run(universal, Lanes(xs));
        let lanes = bits(dispatch(run));
        prop_assert_eq!(lanes, bits(run.run()));
        for (i, &x) in xs.iter().enumerate() {
            let e = universal.at(x);
            let alone = [universal.value(x), e.value, e.derivative, e.lap, e.u1].map(f64::to_bits);
            let mine = lanes.map(|row| row[i]);
            for (alone, mine) in alone.into_iter().zip(mine) {
                // Which NaN it is, IEEE 754 leaves open.
                let both_nan = f64::from_bits(alone).is_nan() && f64::from_bits(mine).is_nan();
                prop_assert!(alone == mine || both_nan, "{x:e}");
            }
        }
    }
}

/// eta^(n + 1) x_e < x <= eta^n x_e for any restitution, and u_1 in (g^-1(3/8), 3/8] with Q(u_1) eta^n = x.
#[test]
fn each_point_is_on_its_lap() {
    for r in (1..200).map(|k| 0.005 * f64::from(k)) {
        let universal = Universal::new(r).unwrap();
        let c = *universal.constants();
        let map = universal.chatter_map();
        for k in 0..400 {
            let laps = 1.99 - 0.0317 * f64::from(k);
            let x = universal.lap_end() * libm::exp(laps * c.ln_eta);
            let at = universal.at(x);
            assert_eq!(at.lap, laps.floor(), "{r} {x:e}");
            assert!(map.inverse(GRAZE) < at.u1 && at.u1 <= GRAZE, "{r} {x:e}");
            // Q as the limit (8), to a few digits.
            let (mut u, mut weight) = (at.u1, 1.0 / c.eta);
            for _ in 0..(libm::log(1e6) / -c.ln_eta).ceil() as usize {
                u = map.inverse(u);
                weight /= c.eta;
            }
            let expected = libm::exp(at.lap * c.ln_eta) * (u - c.chatter_fixed_point) * weight;
            assert!((expected / x - 1.0).abs() < 1e-4, "{r} {x:e} {expected:e}");
        }
    }
}

/// At a joint the laps meet; on its left the graph is a square root, on its right it is smooth.
#[test]
fn laps_are_continuous_and_the_slope_is_infinite_on_the_left_only() {
    for (_, fine) in &prepared()[1..18] {
        let c = fine.constants();
        for lap in [0, 1, 7] {
            let joint = fine.lap_end() * c.eta.powi(lap);
            let at = |phases: f64| fine.at(joint * (D::ONE - D::from(phases) * c.one_minus_eta));
            let (left, right) = (at(1e-16), at(-1e-16));
            assert_eq!(left.lap, D::from(f64::from(lap)));
            assert_eq!(right.lap, D::from(f64::from(lap - 1)));
            assert!(((left.value - right.value) / left.value).abs().to_f64() < 2e-7);
            let wider = at(1e-12);
            let roots = (wider.value - right.value) / (left.value - right.value);
            assert!((roots.to_f64() - 100.0).abs() < 0.1, "{roots}");
            assert!(left.derivative < D::ZERO && right.derivative > D::ZERO);
            let steeper = (left.derivative / wider.derivative).to_f64();
            assert!((steeper - 100.0).abs() < 0.1);
            let smooth = (right.derivative / at(-1e-12).derivative).to_f64();
            assert!((smooth - 1.0).abs() < 1e-9);
        }
    }
    let end = Universal::new(0.5).unwrap();
    let on_end = [0, 1, -1, 2, -2]
        .map(|ulps| f64::from_bits(end.lap_end().to_bits().wrapping_add_signed(ulps)))
        .map(|x| end.at(x));
    for at in on_end {
        assert!(at.value < 0.0 && at.derivative.abs() > 0.1);
    }
}

/// u_1 and x belong together: Q(g^-1(u)) = eta Q(u) says that u_1 is the same on all laps, and (M3) with the plain
/// product gives Upsilon also next to the pole of g, from the other side of which (M3) itself loses digits.
#[test]
fn the_pole_of_g_is_not_seen() {
    for (double, fine) in prepared() {
        let pole = D::ONE / D::from(3.0);
        // The point of lap 0 with u_1 = 1/3, by bisection.
        let (mut low, mut high) = (fine.window().0, fine.lap_end());
        for _ in 0..110 {
            let middle = (low + high) * D::from(0.5);
            if fine.at(middle).u1 < pole {
                low = middle;
            } else {
                high = middle;
            }
        }
        let x = low.to_f64();
        for ulps in -2_i64..=2 {
            let x = f64::from_bits(x.to_bits().wrapping_add_signed(ulps));
            let (a, b) = (double.at(x), fine.at(D::from(x)));
            assert!(
                off(a.value.into(), b.value) < 1e-14,
                "{}",
                double.constants().restitution
            );
            assert!(off(a.u1.into(), b.u1) < 1e-15);
        }
    }
}

#[test]
fn odd_arguments_have_their_values() {
    let universal = Universal::new(0.8).unwrap();
    for x in [0.0, -0.0, 5e-324, -1.0, f64::NEG_INFINITY] {
        let at = universal.at(x);
        assert_eq!((at.value, at.derivative), (0.0, 0.0), "{x}");
        assert_eq!(at.lap, f64::INFINITY);
        assert_eq!(at.u1, universal.constants().chatter_fixed_point);
    }
    assert!(universal.value(f64::NAN).is_nan() && universal.value(f64::INFINITY).is_nan());
    for x in [2.3e-308, 1e-300] {
        let at = universal.at(x);
        assert_eq!(at.value, 0.0);
        assert!(at.derivative != 0.0 && at.derivative.abs() < 1e-55);
    }
    assert!(universal.value(1e250).is_finite());
}

#[test]
fn a_restitution_outside_the_unit_interval_is_refused() {
    for value in [0.0, 1.0, -0.5, 2.0, f64::INFINITY] {
        assert_eq!(
            Universal::new(value).err(),
            Some(UniversalError::Restitution { value })
        );
    }
    assert!(matches!(
        Constants::new(f64::NAN),
        Err(UniversalError::Restitution { value }) if value.is_nan()
    ));
}
