//! What multipliers say of an orbit: functions that change their sign where something happens to it.

use crate::numerics::Complex;

/// Whether all lie inside the unit circle by more than their moduli may be off by.
pub(crate) fn is_stable(multipliers: &[Complex], error: f64) -> bool {
    multipliers.iter().all(|m| m.modulus() < 1.0 - error)
}

/// Whether none lies outside the unit circle, and some are on it as far as they are known, as where energy is conserved. What is known is a
/// product of two, and so a modulus far from the circle the better: the error is that of the square, from the circle on.
pub(crate) fn is_neutral(multipliers: &[Complex], error: f64) -> bool {
    let is_within = |m: &Complex| (m.modulus() - 1.0) * m.modulus() <= error;
    let none_outside = multipliers.iter().all(is_within);
    none_outside && !is_stable(multipliers, error)
}

/// So many roundoffs of the largest entry of a balanced matrix are what its eigenvalues may be off by.
pub(crate) const ROUNDED: f64 = 64.0;

/// A multiplier as it is told which may be off by so much: what is less beside the real axis is rounding of a double one on it.
pub(crate) fn without_rounding(multiplier: Complex, error: f64) -> Complex {
    let im = if multiplier.im.abs() <= error {
        0.0
    } else {
        multiplier.im
    };
    // Zero has no sign.
    Complex {
        re: multiplier.re + 0.0,
        im,
    }
}

fn real(multipliers: &[Complex]) -> impl Iterator<Item = f64> {
    multipliers.iter().filter(|m| m.im == 0.0).map(|m| m.re)
}

/// Changes its sign where a real multiplier passes `at`, and vanishes there. Where a real pair becomes a complex one it goes on
/// without a jump. None where there are no multipliers.
pub(crate) fn passes(multipliers: &[Complex], at: f64) -> Option<f64> {
    let off = |m: &Complex| Complex {
        re: m.re - at,
        ..*m
    };
    let nearest = (multipliers.iter())
        .map(|m| off(m).modulus())
        .min_by(f64::total_cmp)?;
    let sign: f64 = real(multipliers).map(|m| (m - at).signum()).product();
    Some(sign * nearest)
}

/// The same of the multipliers beside one that is `at` itself. Of two that are nearly the same only the sum is known to rounding.
pub(crate) fn passes_beside(multipliers: &[Complex], at: f64) -> Option<f64> {
    let others = without_nearest(multipliers, at);
    let mut order: Vec<Complex> = multipliers.to_vec();
    order.sort_by(|a, b| (a.re - at).hypot(a.im).total_cmp(&(b.re - at).hypot(b.im)));
    let [first, second, rest @ ..] = &*order else {
        return passes(&others, at);
    };
    if first.im != -second.im {
        return passes(&others, at);
    }
    let sign: f64 = real(rest).map(|m| (m - at).signum()).product();
    Some(sign * ((first.re - at) + (second.re - at)))
}

/// How many real multipliers lie beyond -1, and beyond 1.
pub(crate) fn beyond(multipliers: &[Complex]) -> [usize; 2] {
    [-1.0, 1.0].map(|at| real(multipliers).filter(|m| m * at > 1.0).count())
}

/// The same product as [`passes`] has the sign of, of all that they are off by, each against its size: smooth where two pass one after the
/// other, or one comes back.
pub(crate) fn off_together(multipliers: &[Complex], at: f64) -> f64 {
    let off = |m: &Complex| {
        let size = 1.0 + m.modulus();
        match m.im == 0.0 {
            true => (m.re - at) / size,
            false => (m.re - at).hypot(m.im) / size,
        }
    };
    multipliers.iter().map(off).product()
}

/// How near to `at` there is a real multiplier on both of its sides: the distance of the farther of the nearest two.
pub(crate) fn straddles(multipliers: &[Complex], at: f64) -> Option<f64> {
    let nearest = |beyond: bool| {
        let there = real(multipliers).filter(|m| (m * at > 1.0) == beyond);
        there.map(|m| (m - at).abs()).min_by(f64::total_cmp)
    };
    Some(nearest(true)?.max(nearest(false)?))
}

/// The real multiplier that comes so many places after the one farthest out on the side of `at`, less that: where several pass `at` one after
/// the other, or at once, each such function vanishes with one of them. None where there are not as many.
pub(crate) fn passes_at_place(multipliers: &[Complex], at: f64, place: usize) -> Option<f64> {
    let mut order: Vec<f64> = real(multipliers).collect();
    order.sort_by(|a, b| (b * at).total_cmp(&(a * at)));
    Some(order.get(place)? - at)
}

/// Beside a multiplier that is so many roundoffs of another nothing is left but rounding.
const LOST_ROUNDOFFS: f64 = 64.0;

/// Changes its sign where the product of two multipliers passes one, and vanishes there: where a complex pair passes the unit circle,
/// or one real multiplier becomes the inverse of another. None where there are not two.
pub(crate) fn passes_together(multipliers: &[Complex]) -> Option<f64> {
    let largest = (multipliers.iter()).fold(0.0, |most: f64, m| most.max(m.modulus()));
    let lost = LOST_ROUNDOFFS * f64::EPSILON * largest;
    let products = multipliers.iter().enumerate().flat_map(|(i, a)| {
        let others = multipliers[i + 1..].iter();
        others.map(move |b| match a.modulus().min(b.modulus()) < lost {
            true => Complex { re: 0.0, im: 0.0 },
            false => a.times(*b),
        })
    });
    passes(&products.collect::<Vec<Complex>>(), 1.0)
}

/// The modulus of the largest complex pair less one.
pub(crate) fn pair(multipliers: &[Complex]) -> Option<f64> {
    (multipliers.iter())
        .filter(|m| m.im > 0.0)
        .map(|m| m.modulus() - 1.0)
        .max_by(f64::total_cmp)
}

/// All but the real one nearest to `at`.
pub(crate) fn without_nearest(multipliers: &[Complex], at: f64) -> Vec<Complex> {
    let nearest = (multipliers.iter().enumerate())
        .filter(|(_, m)| m.im == 0.0)
        .min_by(|(_, a), (_, b)| (a.re - at).abs().total_cmp(&(b.re - at).abs()))
        .map(|(index, _)| index);
    let others = multipliers.iter().enumerate();
    others
        .filter(|(index, _)| Some(*index) != nearest)
        .map(|(_, m)| *m)
        .collect()
}

/// How far multipliers go from one orbit to another, where each goes to the nearest that is left: on the sphere of all numbers with infinity,
/// on which none is farther than one from another. Zero where there are not as many.
pub(crate) fn farthest(from: &[Complex], to: &[Complex]) -> f64 {
    if from.len() != to.len() {
        return 0.0;
    }
    let apart = |a: &Complex, b: &Complex| {
        let sizes = a.modulus().hypot(1.0) * b.modulus().hypot(1.0);
        (a.re - b.re).hypot(a.im - b.im) / sizes
    };
    let mut left = to.to_vec();
    from.iter().fold(0.0, |most, m| {
        let ways = left.iter().map(|other| apart(m, other)).enumerate();
        let Some((nearest, way)) = ways.min_by(|a, b| a.1.total_cmp(&b.1)) else {
            return most;
        };
        left.swap_remove(nearest);
        most.max(way)
    })
}

/// A multiplier of a fold is 1, and one of a doubling -1, up to this.
pub(crate) const NEAR_ONE: f64 = 1e-3;

/// Whether a multiplier is 1, or -1, as far as multipliers are known. Where two crossings of a surface become one the equations turn,
/// and the orbit does not fold; what vanishes there for others is rounding.
pub(crate) fn is_near(multipliers: &[Complex], value: f64) -> bool {
    let near = |m: &Complex| (m.re - value).hypot(m.im) < NEAR_ONE;
    multipliers.iter().any(near)
}

/// The two whose product is real and nearest to one: that product less one, their sum, and the others. They are a pair on the
/// unit circle where the product is one and the sum is between -2 and 2.
pub(crate) fn neutral(multipliers: &[Complex]) -> Option<(f64, f64, Vec<Complex>)> {
    let mut best: Option<(f64, f64, usize, usize)> = None;
    for (i, a) in multipliers.iter().enumerate() {
        for (k, b) in multipliers.iter().enumerate().skip(i + 1) {
            if a.im != -b.im {
                continue;
            }
            let off = a.times(*b).re - 1.0;
            if best.is_none_or(|(known, ..)| off.abs() < known.abs()) {
                best = Some((off, a.re + b.re, i, k));
            }
        }
    }
    let (off, sum, i, k) = best?;
    let others = multipliers.iter().enumerate();
    let others = others.filter(|(index, _)| *index != i && *index != k);
    Some((off, sum, others.map(|(_, m)| *m).collect()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(values: &[(f64, f64)]) -> Vec<Complex> {
        (values.iter())
            .map(|&(re, im)| Complex { re, im })
            .collect()
    }

    #[test]
    fn functions_change_sign_where_they_should() {
        let before = of(&[(0.9, 0.0), (-0.5, 0.0)]);
        let after = of(&[(1.1, 0.0), (-0.5, 0.0)]);
        assert!(passes(&before, 1.0).unwrap() * passes(&after, 1.0).unwrap() < 0.0);
        assert!(passes(&before, -1.0).unwrap() * passes(&after, -1.0).unwrap() > 0.0);
        assert_eq!(without_nearest(&before, 1.0), of(&[(-0.5, 0.0)]));
        let (off, sum, rest) = neutral(&of(&[(0.6, 0.8), (0.6, -0.8), (0.2, 0.0)])).unwrap();
        assert!(off.abs() < 1e-15 && sum == 1.2 && rest == of(&[(0.2, 0.0)]));
        assert_eq!(pair(&before), None);
    }

    #[test]
    fn rounding_beside_the_real_axis_is_none() {
        let beside = |im: f64| without_rounding(Complex { re: 0.5, im }, 1e-14).im;
        assert_eq!([1e-17, -1e-15, 0.0].map(beside), [0.0; 3]);
        assert_eq!([1e-13, -1e-13].map(beside), [1e-13, -1e-13]);
        let nothing = without_rounding(Complex { re: -0.0, im: 0.0 }, 0.0);
        assert!(nothing.re.is_sign_positive());
    }

    #[test]
    fn of_several_that_pass_at_once_each_is_seen() {
        let before = of(&[(-0.9, 0.0), (0.3, 0.4), (0.3, -0.4), (-0.8, 0.0)]);
        let after = of(&[(-1.1, 0.0), (0.3, 0.4), (0.3, -0.4), (-1.3, 0.0)]);
        assert!(passes(&before, -1.0).unwrap() * passes(&after, -1.0).unwrap() > 0.0);
        assert_eq!([beyond(&before), beyond(&after)], [[0, 0], [2, 0]]);
        assert_eq!(beyond(&of(&[(1.5, 0.0), (-2.0, 0.0)])), [1, 1]);
        for place in [0, 1] {
            let [was, is] = [&before, &after].map(|all| passes_at_place(all, -1.0, place).unwrap());
            assert!(was > 0.0 && is < 0.0);
        }
        assert_eq!(passes_at_place(&before, -1.0, 2), None);
        assert_eq!(
            passes_at_place(&of(&[(0.5, 0.0), (3.0, 0.0)]), 1.0, 0),
            Some(2.0)
        );
    }

    #[test]
    fn multipliers_go_as_far_as_on_a_sphere() {
        let one = of(&[(1e9, 0.0), (0.3, 0.4), (0.3, -0.4)]);
        let same = of(&[(0.3, -0.4), (-1e9, 0.0), (0.3, 0.4)]);
        assert!(farthest(&one, &same) < 1e-8);
        assert!((farthest(&of(&[(1e9, 0.0)]), &of(&[(0.0, 0.0)])) - 1.0).abs() < 1e-15);
        // The nearest that is left.
        let other = of(&[(0.0, 0.0), (0.3, 0.4), (0.3, -0.4)]);
        assert!((0.5..1.0).contains(&farthest(&one, &other)));
        // From a pair inside the circle to two real ones, one of them outside.
        let pair = of(&[(-0.9, 0.4), (-0.9, -0.4)]);
        let real = of(&[(-1.9, 0.0), (-0.6, 0.0)]);
        assert!(farthest(&pair, &real) > 0.2);
        assert_eq!(farthest(&pair, &one), 0.0);
    }

    /// A pair that comes about and passes the circle between two stations, and one that passes it with rounding beside it.
    #[test]
    fn a_pair_passes_the_circle_wherever_it_comes_from() {
        let real = of(&[(1.4, 0.0), (1.3, 0.0), (-0.5, 0.0)]);
        let inside = of(&[(0.6, 0.7), (0.6, -0.7), (-0.5, 0.0)]);
        let on = of(&[(0.6, 0.8), (0.6, -0.8), (-0.5, 0.0)]);
        let value = |all: &[Complex]| passes_together(all).unwrap();
        assert!(value(&real) * value(&inside) < 0.0);
        assert!(value(&on).abs() < 1e-15);
        let two = |half: f64| {
            of(&[
                (half, 0.0),
                (1.0 / half + 0.1, 0.0),
                (0.2, 0.3),
                (0.2, -0.3),
            ])
        };
        assert!(value(&two(2.0)) * value(&two(-2.0)) < 0.0);
        for noise in [-1e-5, 1e-5] {
            let all = of(&[(1e12, 0.0), (noise, 0.0)]);
            assert!(value(&all) < 0.0);
        }
        assert_eq!(passes_together(&of(&[(0.9, 0.0)])), None);
    }

    #[test]
    fn what_is_on_the_circle_but_for_rounding_is_neutral() {
        let on = of(&[(0.6, 0.8 - 1e-16), (0.6, 1e-16 - 0.8)]);
        assert!(is_neutral(&on, 1e-14) && !is_stable(&on, 1e-14));
        let inside = of(&[(0.6, 0.7), (0.6, -0.7)]);
        assert!(is_stable(&inside, 1e-14) && !is_neutral(&inside, 1e-14));
        assert!(!is_neutral(&of(&[(1.1, 0.0), (1.0, 0.0)]), 1e-14));
        // Rounding of the largest hides what is about the circle, and never the largest itself.
        for largest in [1e8_f64, 1e12, 1e19] {
            let error = 64.0 * f64::EPSILON * largest * largest;
            assert!(!is_neutral(&of(&[(-largest, 0.0), (0.5, 0.0)]), error));
            assert!(is_neutral(&of(&[(1.1, 0.0), (0.5, 0.0)]), error));
        }
    }

    #[test]
    fn a_double_multiplier_is_known_by_its_sum() {
        // A double one, torn apart by the root of rounding, into a real or a complex pair.
        for torn in [
            of(&[(-1.0 + 1e-8, 0.0), (-1.0 - 1e-8, 0.0), (0.3, 0.0)]),
            of(&[(-1.0, 1e-8), (-1.0, -1e-8), (0.3, 0.0)]),
        ] {
            assert!(passes_beside(&torn, -1.0).unwrap().abs() < 1e-15);
        }
        let (inside, outside) = (
            of(&[(-1.0, 0.0), (-0.9, 0.0), (0.3, 0.0)]),
            of(&[(-1.0, 0.0), (-1.2, 0.0), (0.3, 0.0)]),
        );
        for all in [inside, outside] {
            let others = without_nearest(&all, -1.0);
            assert!(
                (passes_beside(&all, -1.0).unwrap() - passes(&others, -1.0).unwrap()).abs() < 1e-15
            );
        }
    }
}
