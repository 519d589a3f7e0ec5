//! Diagrams of a map in closed form, and what holds for any map. The valve's diagrams are in the tests of return maps.

mod coexisting;

use super::*;
use crate::analysis::map::{Differentiable, Map, NoReturn, Passage, Tangent};
use core::sync::atomic::Ordering;

/// x -> a x (1 - x).
struct Logistic;

impl Map for Logistic {
    fn coordinates(&self) -> Vec<String> {
        vec!["x".to_owned()]
    }
    fn parameters(&self) -> Vec<String> {
        vec!["a".to_owned(), "c".to_owned()]
    }
    fn parameter_values(&self, swept: &[(usize, f64)]) -> Vec<f64> {
        let mut values = vec![4.0, 0.0];
        swept.iter().for_each(|&(k, value)| values[k] = value);
        values
    }
    fn initial_point(&self, _: &[f64]) -> Vec<f64> {
        vec![0.3]
    }
    fn next(&self, parameters: &[f64], point: &mut [f64]) -> Result<Passage, NoReturn> {
        point[0] = parameters[0] * point[0] * (1.0 - point[0]) + parameters[1];
        Ok(Passage {
            impacts: u64::from(point[0] > 0.5),
            ..Passage::default()
        })
    }
    fn tangent(&self, _: &[usize]) -> Option<Box<dyn Map + '_>> {
        Some(Box::new(Tangent(self)))
    }
}

impl Differentiable for Logistic {
    fn jacobian(&self, parameters: &[f64], point: &[f64]) -> Vec<f64> {
        vec![parameters[0] * (1.0 - 2.0 * point[0])]
    }
}

fn spec(from: f64, to: f64, count: u64) -> Spec {
    Spec::new(Range::linear("a", from, to, count), "x", 2000, 200)
}

/// Goes on with a sweep of the logistic map, on so many threads.
fn go_on(
    sweep: &Sweep,
    standing: &Standing,
    threads: usize,
    stop: &AtomicBool,
    sink: &mut (dyn FnMut(Row) -> ControlFlow<()> + Send),
) -> Ending {
    run(
        &Logistic,
        sweep,
        standing,
        &Threads::new(threads),
        stop,
        sink,
    )
}

#[test]
fn every_cascade_of_the_logistic_map_is_found() {
    let rows = diagram(&Logistic, &spec(2.8, 4.0, 601), &Threads::new(2)).unwrap();
    let at = |a: f64| {
        let place = ((a - 2.8) / 1.2 * 600.0).round() as usize;
        (rows[place].outcome, rows[place].period)
    };
    assert_eq!(rows.len(), 601);
    assert_eq!(at(2.8), (Outcome::Periodic, 1));
    assert_eq!(at(3.2), (Outcome::Periodic, 2));
    assert_eq!(at(3.5), (Outcome::Periodic, 4));
    assert_eq!(at(3.84), (Outcome::Periodic, 3));
    assert_eq!(at(4.0), (Outcome::Chaotic, 0));
    let two = &rows[200].samples;
    // The points of the 2-cycle: (1 + a -+ sqrt((a - 3)(a + 1))) / (2 a).
    for &x in two {
        let root = (0.2_f64 * 4.2).sqrt();
        let nearest = [(4.2 - root) / 6.4, (4.2 + root) / 6.4].map(|y| (x - y).abs());
        assert!(nearest[0].min(nearest[1]) < 1e-13);
    }
    assert_eq!(rows[200].impacts_per_return, 1.0);
}

#[test]
fn a_map_that_leaves_its_domain_is_said_to() {
    let rows = diagram(&Logistic, &spec(4.1, 4.5, 3), &Threads::new(1)).unwrap();
    assert!(rows.iter().all(|row| row.outcome == Outcome::LeftDomain));
}

#[test]
fn an_observed_quantity_without_a_value_is_said() {
    let mut spec = spec(2.8, 3.2, 2);
    // The fixed point lies above 0.6, one point of the 2-cycle below.
    spec.observe = vec![Observed::plain("log(x - 0.6)")];
    let rows = diagram(&Logistic, &spec, &Threads::new(1)).unwrap();
    assert_eq!(rows[0].outcome, Outcome::Periodic);
    assert_eq!((rows[1].outcome, rows[1].period), (Outcome::NotFinite, 2));
}

#[test]
fn exponents_are_those_of_the_books() {
    let mut spec = spec(3.2, 4.0, 2);
    spec.exponent = Exponent::Largest;
    spec.keep = 4000;
    spec.record = Record::Classes;
    let rows = diagram(&Logistic, &spec, &Threads::new(1)).unwrap();
    // The 2-cycle's multiplier is 4 + 2 a - a^2; the full parabola's exponent is log 2.
    let two = libm::log(4.0 + 6.4 - 3.2 * 3.2) / 2.0;
    assert!(
        (rows[0].exponent - two).abs() < 1e-12,
        "{}",
        rows[0].exponent
    );
    let chaos = core::f64::consts::LN_2;
    assert!(
        (rows[1].exponent - chaos).abs() < 0.02,
        "{}",
        rows[1].exponent
    );
    assert!(rows.iter().all(|row| row.samples.is_empty()));
}

/// Whatever the number of samples, and whatever part of a period they end with.
#[test]
fn exponents_of_periodic_orbits_are_of_whole_periods() {
    let mut spec = spec(3.5, 3.55, 2);
    spec.exponent = Exponent::Largest;
    spec.transient = 5000;
    for keep in [40, 63, 200] {
        spec.keep = keep;
        let rows = diagram(&Logistic, &spec, &Threads::new(1)).unwrap();
        for (row, (a, period)) in rows.iter().zip([(3.5, 4), (3.55, 8)]) {
            assert_eq!(row.period, period);
            let cycle = &row.samples[row.samples.len() - period as usize..];
            let slopes = cycle.iter().map(|x| libm::log((a * (1.0 - 2.0 * x)).abs()));
            let exact = slopes.sum::<f64>() / period as f64;
            let error = (row.exponent - exact).abs();
            assert!(error < 1e-4, "{a}, {keep}: {} for {exact}", row.exponent);
        }
    }
}

#[test]
fn every_kth_return_is_a_sample() {
    let mut second = spec(3.2, 3.9, 5);
    second.every = 2;
    second.transient = 1000;
    second.keep = 100;
    second.observe.push(Observed::plain("impacts + a*x"));
    let mut first = second.clone();
    (first.every, first.transient, first.keep) = (1, 2000, 200);
    let first = diagram(&Logistic, &first, &Threads::new(1)).unwrap();
    let second = diagram(&Logistic, &second, &Threads::new(1)).unwrap();
    for (first, second) in first.iter().zip(&second) {
        for (place, sample) in second.samples.chunks(2).enumerate() {
            assert_eq!(sample[0], first.samples[4 * place + 2]);
            let both = first.samples[4 * place + 1] + first.samples[4 * place + 3];
            let a = Spec::value_of(first.row);
            let x = first.samples[4 * place] + first.samples[4 * place + 2];
            assert!((sample[1] - (both - a * x + a * sample[0])).abs() < 1e-12);
        }
    }
    assert_eq!(second[0].period, 1);
}

/// Bits, since a missing exponent equals nothing.
fn bits(rows: &[Row]) -> Vec<Vec<u8>> {
    rows.iter().map(Row::to_bytes).collect()
}

impl Spec {
    fn value_of(row: u64) -> f64 {
        Range::linear("a", 3.2, 3.9, 5).value(row)
    }
}

#[test]
fn carried_orbits_go_on_from_their_neighbours() {
    for (start, order) in [
        (Start::CarryUp, [0, 1, 2, 3, 4]),
        (Start::CarryDown, [4, 3, 2, 1, 0]),
    ] {
        let mut spec = spec(3.7, 3.9, 5);
        (spec.transient, spec.keep, spec.chunk) = (3, 2, Some(5));
        spec.start = start;
        let rows = diagram(&Logistic, &spec, &Threads::new(1)).unwrap();
        let mut x = 0.3;
        for (place, row) in order.into_iter().enumerate() {
            let a = spec.sweeps[0].value(row);
            let orbit: Vec<f64> = (0..5)
                .map(|_| {
                    x = a * x * (1.0 - x) + 0.0;
                    x
                })
                .collect();
            let row = &rows[row as usize];
            assert_eq!(row.samples, orbit[3..]);
            let started = if place == 0 {
                Started::Fresh
            } else {
                Started::Carried
            };
            assert_eq!(row.start, started);
        }
    }
}

#[test]
fn chunks_start_afresh_and_lines_are_not_mixed() {
    let mut spec = spec(3.7, 3.9, 7);
    spec.sweeps.push(Range::linear("c", 0.0, 0.01, 3));
    (spec.transient, spec.keep, spec.chunk) = (1, 1, Some(3));
    for (start, passes) in [
        (Start::CarryUp, 1),
        (Start::CarryDown, 1),
        (Start::CarryBoth, 2),
    ] {
        spec.start = start;
        let sweep = Sweep::new(&Logistic, &spec).unwrap();
        assert_eq!((sweep.rows(), sweep.pieces()), (21 * passes, 9 * passes));
        let mut seen = Vec::new();
        for piece in 0..sweep.pieces() {
            for index in 0..sweep.piece_rows(piece) {
                let row = sweep.row(piece, index);
                assert_eq!(sweep.piece_of(row), piece);
                seen.push(row);
            }
        }
        seen.sort_unstable();
        assert_eq!(seen, (0..21 * passes).collect::<Vec<u64>>());
        let rows = diagram(&Logistic, &spec, &Threads::new(2)).unwrap();
        let fresh = rows
            .iter()
            .filter(|row| row.start == Started::Fresh)
            .count();
        assert_eq!(fresh as u64, 9 * passes);
        assert_eq!(sweep.values(8 * passes), [spec.sweeps[0].value(1), 0.005]);
    }
}

#[test]
fn random_starts_find_both_attractors() {
    // x -> c - x^2 in disguise has one attractor; x -> a x (1 - x) with c has an escape beside it.
    let mut spec = spec(3.2, 3.4, 3);
    spec.start = Start::Random {
        count: 40,
        seed: 1,
        bounds: vec![Bounds {
            coordinate: "x".to_owned(),
            from: -0.5,
            to: 1.0,
        }],
    };
    let rows = diagram(&Logistic, &spec, &Threads::new(2)).unwrap();
    assert_eq!(rows.len(), 120);
    let left = rows
        .iter()
        .filter(|row| row.outcome == Outcome::LeftDomain)
        .count();
    // A third of the interval lies below zero, from where orbits escape.
    assert!((20..60).contains(&left), "{left}");
    assert!(rows.iter().all(|row| row.start == Started::Random));
    let again = |spec: &Spec| diagram(&Logistic, spec, &Threads::new(1)).unwrap();
    assert!(bits(&rows) == bits(&again(&spec)));
    let Start::Random { seed, .. } = &mut spec.start else {
        unreachable!()
    };
    *seed = 2;
    assert!(bits(&rows) != bits(&again(&spec)));
}

#[test]
fn a_broken_off_run_goes_on_to_the_same_bits() {
    let mut spec = spec(3.5, 4.0, 3000);
    (spec.transient, spec.keep) = (20, 10);
    spec.start = Start::CarryUp;
    let whole = diagram(&Logistic, &spec, &Threads::new(2)).unwrap();
    let sweep = Sweep::new(&Logistic, &spec).unwrap();
    for after in [0, 1, 777, 2999] {
        let mut rows = Vec::new();
        let mut standing = Standing::default();
        let stop = AtomicBool::new(false);
        let ending = go_on(&sweep, &standing, 2, &stop, &mut |row| {
            rows.push(row);
            if rows.len() > after {
                stop.store(true, Ordering::Relaxed);
            }
            ControlFlow::Continue(())
        });
        assert!(ending == Ending::Stopped || rows.len() == 3000);
        assert!(rows.iter().all(|row| standing.note(&sweep, row)));
        // A row twice, or of another diagram, is not taken for one that is there.
        assert!(rows.iter().all(|row| !standing.note(&sweep, row)));
        assert_eq!(standing.rows(), rows.len() as u64);
        let stop = AtomicBool::new(false);
        let ending = go_on(&sweep, &standing, 3, &stop, &mut |row| {
            rows.push(row);
            ControlFlow::Continue(())
        });
        assert_eq!(ending, Ending::Complete);
        rows.sort_unstable_by_key(|row| row.row);
        assert_eq!(rows.len(), 3000);
        assert!(bits(&rows) == bits(&whole));
    }
}

#[test]
fn a_sink_that_breaks_off_ends_the_run() {
    let sweep = Sweep::new(&Logistic, &spec(3.5, 4.0, 1000)).unwrap();
    let mut count = 0;
    let stop = AtomicBool::new(false);
    let ending = go_on(&sweep, &Standing::default(), 2, &stop, &mut |_| {
        count += 1;
        ControlFlow::Break(())
    });
    assert_eq!((ending, count), (Ending::Stopped, 1));
}

#[test]
fn wrong_specifications_are_refused() {
    let error = |change: &dyn Fn(&mut Spec)| {
        let mut spec = spec(3.0, 4.0, 11);
        change(&mut spec);
        Sweep::new(&Logistic, &spec).unwrap_err().to_string()
    };
    assert_eq!(
        error(&|spec| spec.sweeps[0].parameter = "b".to_owned()),
        "there is no parameter `b` to sweep: there are `a` and `c`"
    );
    assert!(error(&|spec| spec.sweeps[0].to = 2.0).contains("is reversed"));
    assert!(error(&|spec| spec.sweeps[0].to = 3.0).contains("is empty"));
    assert!(error(&|spec| spec.sweeps[0].to = f64::NAN).contains("not finite"));
    assert!(error(&|spec| spec.sweeps[0].count = 0).contains("no values"));
    assert!(
        error(&|spec| {
            spec.sweeps[0].from = -1.0;
            spec.sweeps[0].spacing = Spacing::Logarithmic;
        })
        .contains("by ratios")
    );
    assert!(error(&|spec| spec.sweeps.push(spec.sweeps[0].clone())).contains("swept twice"));
    assert!(error(&|spec| spec.sweeps.clear()).contains("expected one, or two"));
    assert!(error(&|spec| spec.observe.clear()).contains("nothing is observed"));
    assert_eq!(
        error(&|spec| spec.observe[0] = Observed::plain("2*xx")),
        "cannot observe `2*xx`: unknown name `xx`"
    );
    assert!(error(&|spec| spec.observe[0].name = "a".to_owned()).contains("would be called `a`"));
    assert!(error(&|spec| spec.observe[0].name = "period".to_owned()).contains("`period`"));
    assert!(error(&|spec| spec.keep = 0).contains("no sample is kept"));
    assert!(error(&|spec| spec.keep = 1_000_000_000_000_000_000).contains("100000000 at most"));
    assert!(error(&|spec| spec.every = 0).contains("every 0 returns"));
    assert!(error(&|spec| spec.longest_period = 0).contains("longest period"));
    assert!(error(&|spec| spec.period_tolerance = 0.0).contains("period tolerance"));
    let carry = |spec: &mut Spec| {
        spec.start = Start::CarryUp;
        spec.chunk = Some(0);
    };
    assert!(error(&carry).contains("chunks of 0"));
    let initial = |spec: &mut Spec| spec.sweeps[0] = Range::initial("x", 0.0, 1.0, 3);
    let carried = |spec: &mut Spec| {
        initial(spec);
        spec.start = Start::CarryUp;
    };
    assert!(error(&carried).contains("not at the swept initial value of `x`"));
    let unknown = |spec: &mut Spec| spec.sweeps[0] = Range::initial("y", 0.0, 1.0, 3);
    assert!(error(&unknown).contains("there is no state `y` whose initial value"));
    let random = |count, coordinate: &str, from| Start::Random {
        count,
        seed: 0,
        bounds: vec![Bounds {
            coordinate: coordinate.to_owned(),
            from,
            to: 1.0,
        }],
    };
    assert!(error(&|spec| spec.start = random(0, "x", 0.0)).contains("at least one start"));
    assert!(error(&|spec| spec.start = random(1, "y", 0.0)).contains("no state `y`"));
    assert!(error(&|spec| spec.start = random(1, "x", 2.0)).contains("between 2 and 1"));
    let both = |spec: &mut Spec| {
        initial(spec);
        spec.start = random(1, "x", 0.0);
    };
    assert!(error(&both).contains("both drawn at random and swept"));
}

#[test]
fn a_specification_survives_storage() {
    let mut spec = spec(3.0, 4.0, 11);
    spec.sweeps.push(Range::linear("c", 0.0, 0.1, 3));
    spec.start = Start::Random {
        count: 2,
        seed: 9,
        bounds: vec![Bounds {
            coordinate: "x".to_owned(),
            from: 0.1,
            to: 0.9,
        }],
    };
    let text = serde_json::to_string(&spec).unwrap();
    assert_eq!(serde_json::from_str::<Spec>(&text).unwrap(), spec);
}
