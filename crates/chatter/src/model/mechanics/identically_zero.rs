//! Whether an expression vanishes everywhere, beyond what simplification sees.

use crate::expressions::{Expr, Graph};
use crate::numerics::DoubleDouble;

/// Points where an expression is probed. A function that is not zero vanishes at one generic point with probability
/// zero; several are taken because some may lie outside its domain.
const PROBES: usize = 8;

/// How far below the rounding error of `f64` the double-double value of an identically vanishing expression lies:
/// 2^-53 apart in theory, half of that asked for, since elementary functions lose a few bits.
const VANISHED: f64 = 1.0 / (1_u64 << 27) as f64;

/// How large states are at probes. Beside exp(400 v), which a law of friction with a small speed has on the side where it does not
/// hold, all else is rounding at a speed of one, whatever digits there are; near zero it is not.
const SCALES: [f64; 2] = [1.0, 1.0 / (1_u64 << 20) as f64];

/// Whether `expr` is zero for all states and parameters.
///
/// Decided by simplification, else by probing: what is identically zero evaluates to rounding error, which shrinks by
/// 2^53 in double-double, whereas any other value stays. The largest of each over all probes of one scale are compared, since
/// either may be zero by luck at one; it vanishes at all scales. Probes without a finite value say nothing; an expression without
/// any is taken not to vanish.
pub(in crate::model) fn is_identically_zero(
    graph: &Graph,
    expr: Expr,
    states: usize,
    parameters: usize,
) -> bool {
    if let Some(value) = graph.as_number(expr) {
        return value.high() == 0.0;
    }
    let mut says_something = false;
    for scale in SCALES {
        let (mut value, mut rounding) = (f64::NAN, 0.0_f64);
        for [rough, fine] in probes(graph, expr, ([states, parameters], scale)) {
            if rough.is_finite() && fine.is_finite() {
                value = value.max(fine.abs());
                rounding = rounding.max((rough - fine).abs());
            }
        }
        if value > VANISHED * rounding {
            return false;
        }
        says_something |= !value.is_nan();
    }
    says_something
}

/// What cancels but for the rounding of the numbers that it is written with leaves no more than so much: a few of them are multiplied with
/// each other, and with units.
const WRITTEN: f64 = 4.0 * f64::EPSILON;

/// Whether `expr` is no more than rounding of `of`, which it is a part of: numbers that were put together may leave some of what
/// cancels.
pub(in crate::model) fn is_rounding(
    graph: &Graph,
    (expr, of): (Expr, Expr),
    size: [usize; 2],
) -> bool {
    let largest = |expr: Expr| {
        let values = probes(graph, expr, (size, 1.0)).map(|[_, fine]| fine.abs());
        values.filter(|value| value.is_finite()).reduce(f64::max)
    };
    match (largest(expr), largest(of)) {
        (Some(value), Some(of)) => value <= WRITTEN * of,
        _ => false,
    }
}

/// Whether a sum is no more than rounding of its parts at every probe that says anything.
pub(in crate::model) fn is_rounding_of_parts(
    graph: &Graph,
    (sum, parts): (Expr, &[Expr]),
    [states, parameters]: [usize; 2],
) -> bool {
    let mut says_something = false;
    for point in points(states + parameters) {
        let exact: Vec<DoubleDouble> = point.into_iter().map(DoubleDouble::from).collect();
        let at = |expr: Expr| -> f64 {
            let value: DoubleDouble = graph.evaluate(expr, &exact[..states], &exact[states..]);
            value.high().abs()
        };
        let largest = parts
            .iter()
            .fold(0.0, |most: f64, &part| most.max(at(part)));
        let sum = at(sum);
        if !(sum.is_finite() && largest.is_finite()) {
            continue;
        }
        if sum > WRITTEN * largest {
            return false;
        }
        says_something = true;
    }
    says_something
}

/// The values of an expression of so many states, of this size, and parameters at generic points, in doubles and in twice the digits.
fn probes(
    graph: &Graph,
    expr: Expr,
    ([states, parameters], scale): ([usize; 2], f64),
) -> impl Iterator<Item = [f64; 2]> {
    points(states + parameters).map(move |mut point| {
        point[..states].iter_mut().for_each(|x| *x *= scale);
        let exact: Vec<DoubleDouble> = point.iter().map(|&x| DoubleDouble::from(x)).collect();
        let rough: f64 = graph.evaluate(expr, &point[..states], &point[states..]);
        let fine: DoubleDouble = graph.evaluate(expr, &exact[..states], &exact[states..]);
        [rough, fine.high()]
    })
}

/// Generic points of so many coordinates.
fn points(count: usize) -> impl Iterator<Item = Vec<f64>> {
    let at = move |probe: usize| (0..count).map(move |axis| generic(probe * count + axis));
    (0..PROBES).map(move |probe| at(probe).collect())
}

/// The `index`-th number of a sequence without structure in (0.25, 1.75): multiples of the golden ratio, modulo one.
pub(in crate::model) fn generic(index: usize) -> f64 {
    const GOLDEN: f64 = 0.618_033_988_749_894_8;
    let turns = (index as f64 + 1.0) * GOLDEN;
    0.25 + 1.5 * (turns - libm::floor(turns))
}
