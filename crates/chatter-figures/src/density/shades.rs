//! From counts to shades: few points are averaged with their neighbours, columns made alike, and contrast put where
//! there is something to be told apart.

use super::{Grain, Normalisation};

/// Counts below this are sparse: of them the mean of their neighbourhood is shown, since the count itself is chance.
const SEVERAL: f64 = 16.0;

/// How far a neighbourhood reaches at most, in pixels: a millimetre in print.
const FARTHEST: usize = 12;

/// Points that must lie to each side of an empty pixel that is shaded.
const BESIDE: f64 = 1.5;

/// Opacity of what is faintest: clearly seen on white.
pub(super) const FAINTEST: f64 = 0.22;

/// Most contrast, in opacity a factor of e in density, until all else has as much: chance differences of neighbourhoods
/// that hold several points are then hardly seen.
const MOST_CONTRAST: f64 = 0.22;

/// Part of the inked pixels that may be as faint as the faintest, lest rims of cells be taken for places of low density …
const FAINT: f64 = 0.02;

/// … and part of them that may be saturated, lest a few periodic windows fade all else.
const SATURATED: f64 = 0.002;

/// Opacities that are told apart: more are not seen, and make files large.
const LEVELS: f64 = 24.0;

/// Steps in which the logarithm of the density is told apart.
const STEPS: usize = 512;

/// Counts of a picture, row after row.
pub(super) struct Shades {
    pub(super) width: usize,
    /// Points in each pixel; a part of one where a cell covers several pixels.
    pub(super) counts: Vec<f64>,
    /// Pixels that a point spreads over: those of a cell, at least one.
    pub(super) spread: f64,
}

impl Shades {
    /// Opacities, 0 … 1.
    pub(super) fn opacities(mut self, normalisation: Normalisation, grain: Grain) -> Vec<f64> {
        let sums = match normalisation {
            Normalisation::Column => Some(self.column_sums()),
            Normalisation::Whole => None,
        };
        // A point on the corner of four pixels leaves a quarter in each; less is the rim of a neighbour.
        let mut whole: Vec<f64> = (self.counts.iter())
            .map(|count| (4.0 * self.spread * count).min(1.0))
            .collect();
        if grain == Grain::Smooth {
            self.smooth(&mut whole);
        }
        if let Some(sums) = sums {
            normalise_columns(&mut self.counts, &sums);
        }
        equalise(&mut self.counts);
        for (shade, whole) in self.counts.iter_mut().zip(whole) {
            *shade = (*shade * whole * LEVELS).ceil() / LEVELS;
        }
        self.counts
    }

    fn column_sums(&self) -> Vec<f64> {
        let mut sums = vec![0.0; self.width];
        for row in self.counts.chunks_exact(self.width) {
            for (sum, n) in sums.iter_mut().zip(row) {
                *sum += n;
            }
        }
        sums
    }

    /// Puts the mean of its neighbourhood in the place of each sparse count. A neighbourhood is the smallest square that
    /// holds several sparse points; where there is none, points stand alone and stay what they are.
    ///
    /// What is dense, such as a periodic orbit, takes no part: it stays sharp, and sheds nothing on what is beside it.
    fn smooth(&mut self, whole: &mut [f64]) {
        let width = self.width;
        let height = self.counts.len() / width.max(1);
        let is_sparse = |count: f64| count < SEVERAL / self.spread;
        // What a dense cell leaves in the pixels above and below it is no density.
        let is_rim = |x: usize, y: usize| {
            let dense = |y: usize| !is_sparse(self.counts[y * width + x]);
            y > 0 && dense(y - 1) || y + 1 < height && dense(y + 1)
        };
        // Sums over all above and to the left.
        let mut sums = vec![0.0; (width + 1) * (height + 1)];
        for (y, row) in self.counts.chunks_exact(width).enumerate() {
            let mut along = 0.0;
            for (x, &count) in row.iter().enumerate() {
                let counts = count > 0.0 && is_sparse(count) && !is_rim(x, y);
                along += if counts { count } else { 0.0 };
                sums[(y + 1) * (width + 1) + x + 1] = sums[y * (width + 1) + x + 1] + along;
            }
        }
        let at = |x: usize, y: usize| sums[y * (width + 1) + x];
        let of = |left: usize, top: usize, right: usize, bottom: usize| {
            at(right, bottom) - at(left, bottom) - at(right, top) + at(left, top)
        };
        let square = |x: usize, y: usize, reach: usize| {
            let (left, right) = (x.saturating_sub(reach), (x + reach + 1).min(width));
            let (top, bottom) = (y.saturating_sub(reach), (y + reach + 1).min(height));
            (left, top, right, bottom)
        };
        let within = |x: usize, y: usize, reach: usize| {
            let (left, top, right, bottom) = square(x, y, reach);
            let area = ((right - left) * (bottom - top)) as f64;
            (of(left, top, right, bottom), area)
        };
        // Beside a band, where its points are on one side only, and between two, where there are none above and below,
        // nothing is shaded.
        let amid = |x: usize, y: usize, reach: usize| {
            let (left, top, right, bottom) = square(x, y, reach);
            // What the edge of the picture cuts off is not asked.
            let sides = [
                (x < reach, of(left, top, x, bottom)),
                (x + reach >= width, of(x + 1, top, right, bottom)),
                (y < reach, of(left, top, right, y)),
                (y + reach >= height, of(left, y + 1, right, bottom)),
            ];
            let near = (reach / 3).max(1);
            let strip = of(x - near.min(x), top, (x + near + 1).min(width), bottom);
            strip >= BESIDE && sides.iter().all(|&(cut, side)| cut || side >= BESIDE)
        };
        let mut smooth = self.counts.clone();
        for y in 0..height {
            for x in 0..width {
                let place = y * width + x;
                if !is_sparse(self.counts[place]) || within(x, y, FARTHEST).0 < SEVERAL {
                    continue;
                }
                let empty = self.counts[place] == 0.0;
                let serves = |reach: &usize| {
                    within(x, y, *reach).0 >= SEVERAL && (!empty || amid(x, y, *reach))
                };
                if let Some(reach) = (1..=FARTHEST).find(serves) {
                    let (sum, area) = within(x, y, reach);
                    smooth[place] = sum / area;
                    whole[place] = 1.0;
                }
            }
        }
        self.counts = smooth;
    }
}

/// Scales each column so that all that hold points hold equally many.
fn normalise_columns(counts: &mut [f64], sums: &[f64]) {
    let filled = sums.iter().filter(|&&s| s > 0.0).count();
    let mean = sums.iter().sum::<f64>() / filled.max(1) as f64;
    for row in counts.chunks_exact_mut(sums.len()) {
        for (n, &sum) in row.iter_mut().zip(sums) {
            if sum > 0.0 {
                *n *= mean / sum;
            }
        }
    }
}

/// Densities to opacities, by the histogram of their logarithms: where many are alike there is most contrast, up to a
/// limit (contrast-limited equalisation, Pizer et al. 1987). What the limit takes is dealt out evenly, so that more never
/// gives a fainter shade.
fn equalise(densities: &mut [f64]) {
    let mut inked: Vec<f64> = densities.iter().copied().filter(|&n| n > 0.0).collect();
    if inked.is_empty() {
        return;
    }
    let last = inked.len() - 1;
    let mut quantile = |part: f64| {
        let place = (last as f64 * part) as usize;
        *inked.select_nth_unstable_by(place, f64::total_cmp).1
    };
    let (low, high) = (quantile(FAINT), quantile(1.0 - SATURATED));
    let decades = libm::log(high / low);
    if decades < 1e-9 {
        for n in densities.iter_mut().filter(|n| **n > 0.0) {
            *n = if *n < low { FAINTEST } else { 1.0 };
        }
        return;
    }
    // In steps, from 0 to STEPS.
    let place = |n: f64| (libm::log(n / low) / decades * STEPS as f64).clamp(0.0, STEPS as f64);
    let mut histogram = vec![0.0; STEPS];
    let mut total = 0.0;
    for &n in &inked {
        histogram[(place(n) as usize).min(STEPS - 1)] += 1.0;
        total += 1.0;
    }
    let most = MOST_CONTRAST * decades / STEPS as f64;
    let mut taken = 0.0;
    for bin in &mut histogram {
        *bin /= total;
        if *bin > most {
            taken += *bin - most;
            *bin = most;
        }
    }
    let mut up_to = vec![0.0; STEPS + 1];
    for (k, bin) in histogram.iter().enumerate() {
        up_to[k + 1] = up_to[k] + bin + taken / STEPS as f64;
    }
    for n in densities.iter_mut().filter(|n| **n > 0.0) {
        let place = place(*n);
        let k = (place as usize).min(STEPS - 1);
        let strength = up_to[k] + (place - k as f64) * (up_to[k + 1] - up_to[k]);
        *n = FAINTEST + (1.0 - FAINTEST) * (strength / up_to[STEPS]).clamp(0.0, 1.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]

        #[test]
        fn more_points_never_give_a_fainter_shade(counts in proptest::collection::vec(0.0..1e6f64, 1..200)) {
            let mut shades = counts.clone();
            equalise(&mut shades);
            let mut order: Vec<usize> = (0..counts.len()).collect();
            order.sort_by(|&a, &b| counts[a].total_cmp(&counts[b]));
            for w in order.windows(2) {
                prop_assert!(shades[w[0]] <= shades[w[1]] + 1e-12);
            }
            prop_assert!(shades.iter().all(|s| (0.0..=1.0).contains(s)));
        }
    }

    /// Points that chance strews evenly: of those that fall alone into their pixels no speckle is left, and neither does
    /// a line through them grow wider, nor is what lies outside shaded farther than a neighbourhood reaches.
    #[test]
    fn chance_is_no_speckle_and_a_line_stays_sharp() {
        const SIDE: usize = 120;
        let mut counts = vec![0.0; SIDE * SIDE];
        let mut drawn: u64 = 1;
        for y in 20..100 {
            for x in 0..SIDE {
                // Numerical Recipes' generator.
                drawn = drawn
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1);
                counts[y * SIDE + x] = f64::from(u8::from((drawn >> 40).is_multiple_of(2)));
            }
        }
        (0..SIDE).for_each(|x| counts[60 * SIDE + x] = 200.0);
        let shades = Shades {
            width: SIDE,
            counts,
            spread: 1.0,
        };
        let shades = shades.opacities(Normalisation::Column, Grain::Smooth);
        let inside = |y: usize| &shades[y * SIDE..(y + 1) * SIDE];
        for y in (30..55).chain(65..90) {
            for &shade in inside(y) {
                assert!((0.25..0.85).contains(&shade), "{shade} in row {y}");
            }
        }
        assert!(inside(60).iter().all(|&shade| shade > 0.95));
        assert!(
            inside(59)
                .iter()
                .chain(inside(61))
                .all(|&shade| shade < 0.85)
        );
        assert!(
            (0..20 - FARTHEST)
                .chain(100 + FARTHEST..SIDE)
                .all(|y| inside(y).iter().all(|&s| s == 0.0))
        );
    }
}
