//! Swept initial values, both ways of carrying, and attractors told apart, for maps whose attractors are known.

use super::*;
use crate::analysis::map::CoordinateKind;

/// x -> s (a x - x^3): odd, so that orbits come in pairs; with s = -1 a pair of fixed points is one 2-cycle.
struct Cubic {
    sign: f64,
}

impl Map for Cubic {
    fn coordinates(&self) -> Vec<String> {
        vec!["x".to_owned()]
    }
    fn parameters(&self) -> Vec<String> {
        vec!["a".to_owned(), "c".to_owned()]
    }
    fn parameter_values(&self, swept: &[(usize, f64)]) -> Vec<f64> {
        let mut values = vec![1.5, 0.0];
        swept.iter().for_each(|&(k, value)| values[k] = value);
        values
    }
    fn initial_point(&self, _: &[f64]) -> Vec<f64> {
        vec![0.1]
    }
    fn next(&self, parameters: &[f64], point: &mut [f64]) -> Result<Passage, NoReturn> {
        let x = point[0];
        point[0] = self.sign * (parameters[0] * x - x * x * x) + parameters[1];
        Ok(Passage::default())
    }
}

/// A rotation by a parameter: x is an angle in turns, which nothing depends on but whole turns of.
struct Rotation;

impl Map for Rotation {
    fn coordinates(&self) -> Vec<String> {
        vec!["x".to_owned()]
    }
    fn parameters(&self) -> Vec<String> {
        vec!["a".to_owned()]
    }
    fn parameter_values(&self, swept: &[(usize, f64)]) -> Vec<f64> {
        vec![swept.last().map_or(0.25, |&(_, value)| value)]
    }
    fn initial_point(&self, _: &[f64]) -> Vec<f64> {
        vec![0.1]
    }
    fn next(&self, parameters: &[f64], point: &mut [f64]) -> Result<Passage, NoReturn> {
        point[0] += parameters[0];
        Ok(Passage::default())
    }
    fn coordinate_kinds(&self, _: &[f64]) -> Vec<CoordinateKind> {
        vec![CoordinateKind::Phase { period: 1.0 }]
    }
}

fn compared(map: &dyn Map, spec: &Spec) -> (Vec<Row>, Attractors) {
    let sweep = Sweep::new(map, spec).unwrap();
    let rows = diagram(map, spec, &Threads::new(2)).unwrap();
    let mut collector = Collector::new(map, &sweep);
    rows.iter().for_each(|row| collector.note(row));
    (rows, collector.finish())
}

fn basins(count: u64) -> Spec {
    Spec::new(Range::initial("x", -1.2, 1.2, count), "x", 500, 200)
}

#[test]
fn initial_values_are_swept_and_their_attractors_told_apart() {
    let (rows, found) = compared(&Cubic { sign: 1.0 }, &basins(40));
    let right = found.numbers()[39];
    for (row, number) in rows.iter().zip(found.numbers()) {
        let from = -1.2 + 2.4 * row.row as f64 / 39.0;
        assert!((row.origin[0] - from).abs() < 1e-15);
        assert_eq!((row.start, row.period), (Started::Fresh, 1));
        // Fixed points at +-sqrt(a - 1), one on either side.
        assert!((row.samples[0].abs() - 0.5_f64.sqrt()).abs() < 1e-12);
        assert_eq!(*number == right, row.samples[0] > 0.0, "from {from}");
        assert!((1..=2).contains(number));
    }
    assert_eq!(found.coexisting(), [0]);
}

#[test]
fn an_orbit_is_the_same_wherever_on_it_it_starts() {
    let (rows, found) = compared(&Cubic { sign: -1.0 }, &basins(40));
    assert!(rows.iter().all(|row| row.period == 2));
    assert!(found.numbers().iter().all(|&number| number == 1));
    assert_eq!(found.coexisting(), [0; 0]);
}

#[test]
fn chaotic_attractors_are_told_apart_where_they_do_not_overlap() {
    let mut spec = basins(40);
    // Two mirrored bands up to a = 3 sqrt(3)/2, where they merge.
    for (a, several) in [(2.5, true), (2.9, false)] {
        spec.sweeps.truncate(1);
        spec.sweeps.push(Range::single("a", a));
        let (rows, found) = compared(&Cubic { sign: 1.0 }, &spec);
        for (row, &number) in rows.iter().zip(found.numbers()) {
            if row.outcome == Outcome::Chaotic {
                let right = row.samples[0] > 0.0;
                assert!(!several || (number == found.numbers()[39]) == right);
                assert!(several || number == 1);
            }
        }
        let chaotic = rows.iter().filter(|row| row.outcome == Outcome::Chaotic);
        assert!(chaotic.count() > 36);
        assert_eq!(found.coexisting().len(), usize::from(several));
    }
}

#[test]
fn attractors_keep_their_numbers_from_value_to_value() {
    let parameter = Range::linear("a", 1.2, 2.4, 25);
    let mut spec = basins(6);
    for parameter_first in [false, true] {
        spec.sweeps = vec![basins(6).sweeps.remove(0), parameter.clone()];
        if parameter_first {
            spec.sweeps.reverse();
        }
        // Through the period doubling at a = 2: each side keeps its number.
        let (rows, found) = compared(&Cubic { sign: 1.0 }, &spec);
        let mut numbers = [0, 0];
        for (row, &number) in rows.iter().zip(found.numbers()) {
            let side = usize::from(row.samples[0] > 0.0);
            if number > 0 {
                assert!(numbers[side] == 0 || numbers[side] == number, "{}", row.row);
                numbers[side] = number;
            }
        }
        assert_ne!(numbers[0], numbers[1]);
        assert!(found.coexisting().len() >= 23);
    }
}

#[test]
fn both_ways_of_carrying_show_where_orbits_depend_on_the_way() {
    // x = a x - x^3 + c has three solutions between two folds: c = +-2 ((a - 1)/3)^(3/2).
    let mut spec = Spec::new(Range::linear("c", -0.5, 0.5, 201), "x", 200, 20);
    spec.start = Start::CarryBoth;
    let (rows, found) = compared(&Cubic { sign: 1.0 }, &spec);
    let fold = 2.0 * (0.5_f64 / 3.0).powf(1.5);
    assert_eq!(rows.len(), 402);
    for pair in rows.chunks(2) {
        let c = spec.sweeps[0].value(pair[0].row / 2);
        let differ = pair[0].samples[19] < 0.0 && pair[1].samples[19] > 0.0;
        assert_eq!(differ, c.abs() < fold, "c = {c}");
    }
    // Near the folds orbits may not have settled yet.
    let expected = (0..201)
        .filter(|&index| spec.sweeps[0].value(index).abs() < fold)
        .count();
    let coexisting = found.coexisting().len();
    assert!(
        coexisting <= expected && coexisting + 4 >= expected,
        "{coexisting}"
    );
    // Chunks forget on which branch they were.
    spec.chunk = Some(4);
    let (_, found) = compared(&Cubic { sign: 1.0 }, &spec);
    assert!(found.coexisting().len() <= 8);
}

#[test]
fn random_and_swept_starts_go_together_and_are_recorded() {
    let mut spec = basins(5);
    spec.start = Start::Random {
        count: 3,
        seed: 4,
        bounds: vec![Bounds {
            coordinate: "x".to_owned(),
            from: -1.0,
            to: 1.0,
        }],
    };
    spec.sweeps = vec![Range::linear("a", 1.2, 1.8, 5)];
    let (rows, found) = compared(&Cubic { sign: 1.0 }, &spec);
    for (row, &number) in rows.iter().zip(found.numbers()) {
        assert!((-1.0..1.0).contains(&row.origin[0]) && row.start == Started::Random);
        assert!(number > 0);
    }
}

#[test]
fn phases_are_judged_up_to_whole_turns_and_rotations_are_quasiperiodic() {
    let golden = (5.0_f64.sqrt() - 1.0) / 2.0;
    for (a, outcome, period) in [
        (0.25, Outcome::Periodic, 4),
        (3.2, Outcome::Periodic, 5),
        (golden, Outcome::Quasiperiodic, 0),
        (10.0 + golden / 2.0, Outcome::Quasiperiodic, 0),
    ] {
        let spec = Spec::new(Range::single("a", a), "x", 100, 200);
        let rows = diagram(&Rotation, &spec, &Threads::new(1)).unwrap();
        assert_eq!(
            (rows[0].outcome, rows[0].period),
            (outcome, period),
            "a = {a}"
        );
    }
}
