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
const REFERENCES: usize = 256;

/// Multiples of it, without their whole parts, are spread evenly, however many there are.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// By how much nearest neighbours are nearer, in the mean of the logarithm, than points as many samples apart are: nearly not
/// at all where a motion is linear, a fifth where it has shrunk to a hundredth meanwhile; where it is chaotic, from 0.6 in eight
/// dimensions to some logarithm of the number of points in one.
const BY_ACCIDENT: f64 = 0.5;

/// Differences of points equally far apart die out if they fall to less than this part of what they were, …
const DIES_OUT: f64 = 0.75;

/// … at most, from each of so many parts of the points to the next.
const PARTS: usize = 4;

/// Averages over fewer points than twice this many tell no rotation from anything else.
const LEAST_AVERAGED: usize = 50;

/// Averages over the two halves of this many points agree to [`AGREEMENT`] of the extent on a torus, unless a frequency is
/// near zero: less by far than averages of chaos differ, by a tenth, and than those of an orbit differ that still
/// approaches something, by a ten-thousandth of the distance a sample.
const AVERAGED: f64 = 200.0;

/// See [`AVERAGED`]. For more points it is so much smaller in proportion, which faster convergence than any power allows.
const AGREEMENT: f64 = 1e-3;

/// And those of the steps of near returns to so many times as much: about a cycle, whose points hide all else, they tell what
/// dies out by more than a ten-thousandth a sample.
const STEPS: f64 = 30.0;

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
    match (spreads(points), drift(points)) {
        (true, None) => Evidence::Chaotic,
        (false, Some(shift)) if converges(points, shift) => Evidence::Quasiperiodic,
        _ => Evidence::None,
    }
}

/// Whether points that are neighbours move apart, in the mean of the logarithm: the sign of the largest exponent, told from
/// points alone (after Wolf et al. 1985, Determining Lyapunov exponents from a time series). And whether they are neighbours by
/// accident: where they are so by the number of samples between them alone, only those are chosen whose distance is just at
/// its least, as on an ellipse it is twice a turn, and it grows from there.
fn spreads(points: &Embedding) -> bool {
    let count = points.len();
    // Those of the second half, where the orbit has settled if it has at all.
    let first = (count / 2).max(count.saturating_sub(NEIGHBOURHOOD));
    let last = count.saturating_sub(1);
    let among = last - first.min(last);
    // At no equal intervals: on bands of chaos these could see the same ones each time, and those may be the ones that contract.
    let reference = |k: usize| match among <= REFERENCES {
        true => first + k,
        false => first + ((k as f64 * GOLDEN).fract() * among as f64) as usize,
    };
    let (mut growth, mut pairs) = (Vec::new(), Vec::new());
    for a in (0..among.min(REFERENCES)).map(reference) {
        if let Some((before, b)) = points.nearest(a, first..last) {
            let after = points.distance(a + 1, b + 1);
            if before > 0.0 && after > 0.0 && (before + after).is_finite() {
                growth.push(libm::log(after / before));
                pairs.push((a, b));
            }
        }
    }
    growth.len() >= LEAST_PAIRS && grows(&growth) && meet_by_accident(points, first, &pairs)
}

/// Whether neighbours, of which these pairs are some, came near each other by accident: by far nearer than the number of samples
/// between them takes an orbit on the whole. On a torus and along a spiral it is this number that makes neighbours. Measured in
/// the metric of the differences d_n of points so many samples apart as most of them are, what a cycle adds to which cancels.
/// In it linear motion keeps the shape of what it shrinks: with d_n = A^n d, C = sum d_n d_n^T, A C A^T is C but for its first
/// and last terms, so that all differences of points that are equally far apart are nearly |lambda|^n times as long as the first.
fn meet_by_accident(points: &Embedding, first: usize, pairs: &[(usize, usize)]) -> bool {
    let mut apart = vec![0_usize; (points.len() - first) / 2 + 1];
    for &(a, b) in pairs {
        // Farther apart, there are too few such points.
        if let Some(count) = apart.get_mut(a.abs_diff(b)) {
            *count += 1;
        }
    }
    // The smallest of several: counted from above, the last one.
    let most = (1..apart.len()).rev().max_by_key(|&shift| apart[shift]);
    let shift = most.unwrap_or(1);
    let points = points.evened(first, shift);
    if dies_out(&points, shift) {
        return false;
    }
    let last = points.len().saturating_sub(1);
    let mut usual = vec![None; points.len()];
    let (mut sum, mut count) = (0.0, 0_usize);
    let stride = (pairs.len() / LEAST_PAIRS).max(1);
    for a in pairs.iter().step_by(stride).map(|&(a, _)| a - first) {
        let Some((distance, b)) = points.nearest(a, 0..last) else {
            continue;
        };
        let apart = a.abs_diff(b);
        if distance > 0.0 {
            let usual = usual[apart].get_or_insert_with(|| points.mean_logarithm(apart));
            sum += libm::log(distance) - *usual;
            count += 1;
        }
    }
    sum < -BY_ACCIDENT * count as f64
}

/// Whether points so many places apart come nearer and nearer, all along: an orbit that settles to a cycle, whose points each
/// have a metric of their own.
fn dies_out(points: &Embedding, apart: usize) -> bool {
    let part = points.len().saturating_sub(apart) / PARTS;
    let largest = |index: usize| {
        let places = index * part..(index + 1) * part;
        let distances = places.map(|place| points.distance(place, place + apart));
        distances.fold(0.0_f64, f64::max)
    };
    part > 0 && (1..PARTS).all(|index| largest(index) < DIES_OUT * largest(index - 1))
}

/// The nearest returns, if they drift: if each takes its point on by nearly the same small step as the next one. On a
/// torus it does. Where periods have been doubled the steps go to and fro; in bands of chaos they go anywhere.
fn drift(points: &Embedding) -> Option<usize> {
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
    let (step, shift) = nearest?;
    let turns = (first + 2 * shift..count).map(|place| {
        let [now, before, earlier] = [0, shift, 2 * shift].map(|back| points.vector(place - back));
        let bends = (now.iter().zip(before).zip(earlier)).map(|((x, y), z)| x - 2.0 * y + z);
        bends.map(|bend| bend * bend).sum::<f64>().sqrt()
    });
    let turn = turns.sum::<f64>() / (count - first - 2 * shift) as f64;
    (step > SAME_POINT && turn <= COHERENT * step).then_some(shift)
}

/// Whether weighted averages over the two halves agree (Das, Saiki, Sander & Yorke 2017, Quantitative quasiperiodicity).
/// And those of the steps of near returns, so many samples apart.
fn converges(points: &Embedding, shift: usize) -> bool {
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
    let n = points.dimension();
    // In units of the extent of the second half: averages of what dies out agree, too, where it is small against the first one's.
    let units: Vec<f64> = (0..n).map(|i| points.extent(i, late)).collect();
    let allowed = AGREEMENT * AVERAGED / points.len() as f64;
    let agree = |of: &dyn Fn(usize) -> f64, unit: f64| {
        (average(0, of) - average(late, of)).abs() <= allowed * unit
    };
    let step = |k: usize| points.distance(k, k + shift) * points.distance(k, k + shift);
    let longest = (0..points.len() - shift).map(step).fold(0.0, f64::max);
    if (average(0, &step) - average(late - shift, &step)).abs() > STEPS * allowed * longest {
        return false;
    }
    // First and second moments, and those from a sample to the next: a slow approach shows in the second ones.
    (0..n).all(|i| {
        let unit = units[i];
        agree(&|k| points.vector(k)[i], unit)
            && agree(
                &|k| points.vector(k)[i] * points.vector(k + 1)[i],
                unit * unit,
            )
            && (0..=i).all(|j| {
                let product = |k: usize| points.vector(k)[i] * points.vector(k)[j];
                agree(&product, unit * units[j])
            })
    })
}
