//! Chaotic, quasi-periodic or neither: what an orbit without a period shows of itself.

use super::embedding::Embedding;

/// What is evident.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::analysis::diagram) enum Evidence {
    /// Neighbouring points move apart.
    Chaotic,
    /// Near returns take points on by small steps that add up, neighbours stay neighbours, and averages converge as they
    /// only do where the motion is that of a rotation.
    Quasiperiodic,
    /// Neither.
    None,
}

/// Growth counts if its mean exceeds so many times its standard error: where distances only fluctuate, as they do on
/// quasi-periodic orbits, the mean is as often positive as negative.
const SIGNIFICANT: f64 = 2.0;

/// Fewer pairs of neighbours than this say nothing about whether neighbours move apart.
const LEAST_PAIRS: usize = 16;

/// Neighbours are looked for among so many of the latest points, …
const NEIGHBOURHOOD: usize = 512;

/// … of so many of them.
const REFERENCES: usize = 64;

/// Averages over fewer points than twice this many tell no rotation from anything else.
const LEAST_AVERAGED: usize = 50;

/// Averages over the two halves of this many points agree to [`AGREEMENT`] of the extent on a torus, unless a frequency is
/// near zero: less by far than averages of chaos differ, by a tenth, and than those of an orbit differ that still
/// approaches something, by a ten-thousandth of the distance a sample.
const AVERAGED: f64 = 200.0;

/// See [`AVERAGED`]. For more points it is so much smaller in proportion, which faster convergence than any power allows.
const AGREEMENT: f64 = 1e-3;

/// Returns are looked for among so many of the latest points, …
const RETURNS: usize = 1024;

/// … within this part of them, so that several in a row can be followed.
const WITHIN: usize = 8;

/// Two near returns in a row differ by less than this part of one of them.
const COHERENT: f64 = 0.5;

/// Returns nearer than this, in parts of the extent, are to the same point: the orbit has a period that is longer than was
/// looked for.
const SAME_POINT: f64 = 1e-4;

/// Whether distances grow, from logarithms of their growth.
pub(in crate::analysis::diagram) fn grows(logarithms: &[f64]) -> bool {
    let count = logarithms.len() as f64;
    let mean = logarithms.iter().sum::<f64>() / count;
    let squares = logarithms.iter().map(|x| (x - mean) * (x - mean));
    let error = (squares.sum::<f64>() / (count * (count - 1.0))).sqrt();
    mean > SIGNIFICANT * error
}

/// What the points of an orbit without a period are evidence of.
pub(in crate::analysis::diagram) fn evidence(points: &Embedding) -> Evidence {
    if points.dimension() == 0 {
        return Evidence::None;
    }
    match (spreads(points), drifts(points)) {
        (true, false) => Evidence::Chaotic,
        (false, true) if converges(points) => Evidence::Quasiperiodic,
        _ => Evidence::None,
    }
}

/// Whether points that are neighbours move apart, in the mean of the logarithm: the sign of the largest exponent, told from
/// points alone (after Wolf et al. 1985, Determining Lyapunov exponents from a time series).
fn spreads(points: &Embedding) -> bool {
    let count = points.len();
    // Those of the second half, where the orbit has settled if it has at all.
    let first = (count / 2).max(count.saturating_sub(NEIGHBOURHOOD));
    let last = count.saturating_sub(1);
    let stride = ((last - first.min(last)) / REFERENCES).max(1);
    let mut growth = Vec::new();
    for a in (first..last).step_by(stride) {
        if let Some((before, b)) = points.nearest(a, first..last) {
            let after = points.distance(a + 1, b + 1);
            if before > 0.0 && after > 0.0 && (before + after).is_finite() {
                growth.push(libm::log(after / before));
            }
        }
    }
    growth.len() >= LEAST_PAIRS && grows(&growth)
}

/// Whether the nearest returns drift: whether each takes its point on by nearly the same small step as the next one. On a
/// torus it does. Where periods have been doubled the steps go to and fro; in bands of chaos they go anywhere.
fn drifts(points: &Embedding) -> bool {
    let count = points.len();
    let first = count.saturating_sub(RETURNS);
    let mut nearest: Option<(f64, usize)> = None;
    for shift in 1..=(count - first) / WITHIN {
        let least = nearest.map_or(f64::INFINITY, |(step, _)| step);
        if let Some(step) = points.mean_step(first, shift, least)
            && (nearest.is_none() || step.total_cmp(&least).is_lt())
        {
            nearest = Some((step, shift));
        }
    }
    let Some((step, shift)) = nearest else {
        return false;
    };
    let turns = (first + 2 * shift..count).map(|place| {
        let [now, before, earlier] = [0, shift, 2 * shift].map(|back| points.vector(place - back));
        let bends = (now.iter().zip(before).zip(earlier)).map(|((x, y), z)| x - 2.0 * y + z);
        bends.map(|bend| bend * bend).sum::<f64>().sqrt()
    });
    let turn = turns.sum::<f64>() / (count - first - 2 * shift) as f64;
    step > SAME_POINT && turn <= COHERENT * step
}

/// Whether weighted averages over the two halves agree (Das, Saiki, Sander & Yorke 2017, Quantitative quasiperiodicity).
fn converges(points: &Embedding) -> bool {
    let half = points.len().saturating_sub(1) / 2;
    if half < LEAST_AVERAGED {
        return false;
    }
    let weights: Vec<f64> = (1..=half)
        .map(|k| {
            let t = k as f64 / (half + 1) as f64;
            libm::exp(-1.0 / (t * (1.0 - t)))
        })
        .collect();
    let total: f64 = weights.iter().sum();
    let average = |first: usize, of: &dyn Fn(usize) -> f64| {
        let terms = weights.iter().enumerate();
        terms.map(|(k, weight)| weight * of(first + k)).sum::<f64>() / total
    };
    let late = points.len() - 1 - half;
    let allowed = AGREEMENT * AVERAGED / points.len() as f64;
    let agree = |of: &dyn Fn(usize) -> f64| (average(0, of) - average(late, of)).abs() <= allowed;
    let n = points.dimension();
    // First and second moments, and those from a sample to the next: a slow approach shows in the second ones.
    (0..n).all(|i| {
        agree(&|k| points.vector(k)[i])
            && agree(&|k| points.vector(k)[i] * points.vector(k + 1)[i])
            && (0..=i).all(|j| agree(&|k| points.vector(k)[i] * points.vector(k)[j]))
    })
}
