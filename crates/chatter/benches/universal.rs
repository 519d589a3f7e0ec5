//! Iterates of z -> Upsilon(K z + mu) a second, on one core, four ways. Items are iterates.
//!
//! `cargo bench -p chatter-dynamics --bench universal`

use chatter::analysis::universal::{ChatterMap, Universal, UniversalMap};
use chatter::numerics::Lanes;
use chatter::numerics::dispatch::{Kernel, dispatch};
use divan::Bencher;
use divan::counter::ItemsCount;
use std::hint::black_box;

const RESTITUTION: f64 = 0.8;
const SLOPE: f64 = 1.0;
/// Chaotic for most: laps up to n = 20 are visited.
const OFFSETS: [f64; 64] = {
    let mut offsets = [0.0; 64];
    let mut i = 0;
    while i < 64 {
        offsets[i] = 0.01 + 0.0005 * i as f64;
        i += 1;
    }
    offsets
};
const ITERATES: usize = 1000;

fn main() {
    divan::main();
}

fn map(offset: f64) -> UniversalMap<f64> {
    UniversalMap::new(Universal::new(RESTITUTION).unwrap(), SLOPE, offset).unwrap()
}

struct InLanes<'a, const L: usize>(&'a Universal<f64>, &'a [f64; L]);

impl<const L: usize> Kernel for InLanes<'_, L> {
    type Output = Lanes<L>;
    #[inline(always)]
    fn run(self) -> Lanes<L> {
        let mut z = Lanes([0.0; L]);
        let (slope, offset) = (Lanes([SLOPE; L]), Lanes(*self.1));
        for _ in 0..ITERATES {
            z = self.0.upsilon(slope * z + offset);
        }
        z
    }
}

#[divan::bench(consts = [4, 8, 16, 32])]
fn lanes<const L: usize>(bencher: Bencher) {
    let universal = Universal::new(RESTITUTION).unwrap();
    let offsets: [f64; L] = std::array::from_fn(|i| OFFSETS[i]);
    bencher
        .counter(ItemsCount::new(ITERATES * L))
        .bench(|| dispatch(InLanes(&universal, black_box(&offsets))));
}

struct Scalar<'a>(&'a UniversalMap<f64>);

impl Kernel for Scalar<'_> {
    type Output = f64;
    #[inline(always)]
    fn run(self) -> f64 {
        let mut z = 0.0;
        for _ in 0..ITERATES {
            z = self.0.step(z);
        }
        z
    }
}

#[divan::bench]
fn scalar(bencher: Bencher) {
    let map = map(0.02);
    bencher
        .counter(ItemsCount::new(ITERATES))
        .bench(|| dispatch(Scalar(black_box(&map))));
}

/// What one writes from the paper: find n, solve Q(u_1) eta^n = x by bisection and secants, Q and P by iterating g^-1
/// until they settle.
struct Plain {
    map: ChatterMap<f64>,
    fixed: f64,
    lambda: f64,
    eta: f64,
    lap_end: f64,
}

impl Plain {
    fn limits(&self, u1: f64) -> (f64, f64) {
        let (mut u, mut weight, mut q, mut p) = (u1, 1.0 / self.eta, f64::NAN, 1.0);
        loop {
            p *= self.map.h(u) / self.lambda;
            let next = (u - self.fixed) * weight;
            if (next - q).abs() < 1e-12 * next.abs() || weight > 1e12 {
                return (next, p);
            }
            q = next;
            u = self.map.inverse(u);
            weight /= self.eta;
        }
    }

    fn upsilon(&self, x: f64) -> f64 {
        if x <= 0.0 {
            return 0.0;
        }
        let n = ((x / self.lap_end).ln() / self.eta.ln()).floor();
        let q = x / self.eta.powf(n);
        // Illinois.
        let (mut a, mut b) = (self.map.inverse(0.375), 0.375);
        let (mut fa, mut fb) = (self.limits(a).0 - q, self.limits(b).0 - q);
        while (b - a).abs() > 1e-12 {
            let c = b - fb * (b - a) / (fb - fa);
            let fc = self.limits(c).0 - q;
            if fc * fb < 0.0 {
                (a, fa) = (b, fb);
            } else {
                fa *= 0.5;
            }
            (b, fb) = (c, fc);
            if fc == 0.0 {
                break;
            }
        }
        let p = self.limits(b).1;
        (self.map.g(b) - 0.5) * p * p * self.lambda.powf(2.0 * n)
    }
}

#[divan::bench]
fn plain_limit(bencher: Bencher) {
    let universal = Universal::new(RESTITUTION).unwrap();
    let c = *universal.constants();
    let plain = Plain {
        map: universal.chatter_map(),
        fixed: c.chatter_fixed_point,
        lambda: c.lambda,
        eta: c.eta,
        lap_end: universal.lap_end(),
    };
    bencher
        .counter(ItemsCount::new(ITERATES))
        .bench(|| (0..ITERATES).fold(0.0, |z, _| plain.upsilon(SLOPE * z + black_box(0.02))));
}

/// A table of one lap, linear between entries in the square root of the distance from its end: 8 digits at best.
struct Table {
    values: Vec<f64>,
    lap_end: f64,
    ln_eta: f64,
    ln_value: f64,
    scale: f64,
}

impl Table {
    const ENTRIES: usize = 4096;

    fn new(universal: &Universal<f64>) -> Self {
        let c = universal.constants();
        let rest = 1.0 - c.eta;
        let values = (0..=Self::ENTRIES + 1)
            .map(|k| {
                let s = k as f64 / Self::ENTRIES as f64;
                universal.value(universal.lap_end() * (1.0 - s * s * rest) * (1.0 - 1e-16))
            })
            .collect();
        Self {
            values,
            lap_end: universal.lap_end(),
            ln_eta: c.ln_eta,
            ln_value: 2.0 * c.ln_lambda,
            scale: Self::ENTRIES as f64 / rest.sqrt(),
        }
    }

    #[inline(always)]
    fn upsilon(&self, x: f64) -> f64 {
        if x <= 0.0 {
            return 0.0;
        }
        let n = ((x / self.lap_end).ln() / self.ln_eta).floor();
        let ratio = x / self.lap_end * (-n * self.ln_eta).exp();
        let place = (1.0 - ratio).max(0.0).sqrt() * self.scale;
        let k = (place as usize).min(Self::ENTRIES);
        let part = place - k as f64;
        let value = self.values[k] + part * (self.values[k + 1] - self.values[k]);
        value * (n * self.ln_value).exp()
    }
}

#[divan::bench]
fn table(bencher: Bencher) {
    let table = Table::new(&Universal::new(RESTITUTION).unwrap());
    bencher
        .counter(ItemsCount::new(ITERATES))
        .bench(|| (0..ITERATES).fold(0.0, |z, _| table.upsilon(SLOPE * z + black_box(0.02))));
}

/// Preparing Upsilon for one restitution.
#[divan::bench(args = [0.01, 0.8, 0.999, 1.0 - 1e-12])]
fn preparation(restitution: f64) -> Universal<f64> {
    Universal::new(restitution).unwrap()
}
