//! Return maps against single trajectories, exact solutions and double-double arithmetic.

mod after_chatter;
mod carry;

use super::*;
use crate::analysis::diagram::{
    Bounds, Exponent, Outcome, Range, Record, Row, Spec, Start as Begin, Started, Threads, diagram,
};
use crate::analysis::map::Origin;
use crate::analysis::periodic;
use crate::analysis::simulate::EventKind;
use crate::flow::{Occurrence, Trajectory};
use crate::numerics::{DoubleDouble, Real};
use core::ops::ControlFlow;
use core::sync::atomic::AtomicBool;

fn shipped(name: &str) -> Model {
    let path = format!("{}/../../models/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(&path).unwrap();
    Model::from_toml(&text, name).unwrap()
}

fn valve() -> (Model, ReturnMap) {
    let model = shipped("pressure_relief_valve");
    let map = ReturnMap::new(&model, &ReturnSpec::section("closing")).unwrap();
    (model, map)
}

fn sweep(from: f64, to: f64, count: u64, transient: u64, keep: u64) -> Spec {
    Spec::new(Range::linear("q", from, to, count), "y2", transient, keep)
}

/// Bits, since a missing exponent equals nothing.
fn bits(rows: &[Row]) -> Vec<Vec<u8>> {
    rows.iter().map(Row::to_bytes).collect()
}

/// Samples of one trajectory of the valve, with an f64 or longer.
fn alone<R: Real>(model: &Model, q: f64, from: &[R], transient: usize, keep: usize) -> Vec<R> {
    let system = System::new(model).unwrap();
    let mut work = system.workspace::<R>(&Settings::default());
    let parameters = model.parameter_values(&[(0, R::splat(q))]);
    let mut trajectory = Trajectory::start(&system, &mut work, &parameters, R::ZERO, from).unwrap();
    trajectory.leave(&system, crate::flow::GuardKind::Section(0));
    let mut samples = Vec::new();
    while samples.len() < transient + keep {
        let told = trajectory
            .advance(&system, &mut work, R::splat(1e30))
            .unwrap();
        if let Some(Occurrence::Section { .. }) = told {
            samples.push(trajectory.state()[1]);
        }
    }
    samples.split_off(transient)
}

#[test]
fn rows_are_the_bits_of_single_trajectories_whatever_the_company() {
    let (model, map) = valve();
    let spec = sweep(0.0202, 0.0225, 40, 20, 30);
    let rows = diagram(&map, &spec, &Threads::new(1)).unwrap();
    for threads in [2, 5] {
        let again = diagram(&map, &spec, &Threads::new(threads)).unwrap();
        assert!(bits(&rows) == bits(&again));
    }
    for row in rows.iter().step_by(7) {
        let q = spec.sweeps[0].value(row.row);
        let start = model.initial_state(&model.parameter_values::<f64>(&[(0, q)]));
        // A trajectory's own horizon may shorten its last step before a section: none does here.
        assert!(row.samples == alone(&model, q, &start, 20, 30), "q = {q}");
    }
    // A part of the sweep, as its own sweep, has the same rows.
    let mut part = spec.clone();
    part.sweeps[0] = Range::linear("q", spec.sweeps[0].value(39), 0.0225, 1);
    part.sweeps[0].from = 0.0225;
    let last = diagram(&map, &part, &Threads::new(1)).unwrap();
    assert!(last[0].samples == rows[39].samples);
}

#[test]
fn carried_rows_do_not_depend_on_threads() {
    let (_, map) = valve();
    let mut spec = sweep(0.0201, 0.0223, 48, 10, 10);
    (spec.start, spec.chunk) = (Begin::CarryUp, Some(4));
    spec.exponent = Exponent::Largest;
    let rows = diagram(&map, &spec, &Threads::new(1)).unwrap();
    let bits = |rows: &[Row]| rows.iter().map(Row::to_bytes).collect::<Vec<_>>();
    assert_eq!(
        bits(&rows),
        bits(&diagram(&map, &spec, &Threads::new(3)).unwrap())
    );
    let carried = rows
        .iter()
        .filter(|row| row.start == Started::Carried)
        .count();
    assert_eq!(carried, 36);
}

/// Past the long transients of narrow windows.
const TRANSIENT: u64 = 2000;

/// Parameter values with a stable periodic attractor.
const WINDOWS: [(f64, u64, f64); 20] = [
    (0.020_100, 1, 42.0),
    (0.020_111, 1, 41.0),
    (0.020_124, 1, 40.0),
    (0.020_140, 1, 39.0),
    (0.020_160, 1, 38.0),
    (0.020_185, 1, 37.0),
    (0.020_217, 1, 36.0),
    (0.020_219, 2, 36.0),
    (0.020_254, 1, 35.0),
    (0.020_257, 2, 35.0),
    (0.020_300, 1, 34.0),
    (0.020_304, 2, 34.0),
    (0.020_357, 1, 33.0),
    (0.020_361, 2, 33.0),
    (0.020_366, 3, 33.0),
    (0.020_427, 1, 32.0),
    (0.020_431, 2, 32.0),
    (0.020_517, 2, 31.0),
    (0.020_623, 2, 30.0),
    (0.020_715, 2, 29.5),
];

#[test]
fn stable_attractors_are_those_of_double_double_arithmetic() {
    let (model, map) = valve();
    for (q, period, impacts) in WINDOWS {
        let spec = sweep(q, q, 1, TRANSIENT, 12);
        let rows = diagram(&map, &spec, &Threads::new(1)).unwrap();
        let row = &rows[0];
        assert_eq!(row.outcome, Outcome::Periodic, "q = {q}");
        assert_eq!(
            (row.period, row.impacts_per_return),
            (period, impacts),
            "q = {q}"
        );
        // From where doubles have come to shortly before: the rest is contraction.
        let settled = map_image(&map, q, TRANSIENT - 24);
        let from: Vec<DoubleDouble> = settled.iter().map(|&x| DoubleDouble::from(x)).collect();
        let reference = alone(&model, q, &from, 24, 12);
        for (sample, exact) in row.samples.iter().zip(&reference) {
            let error = (DoubleDouble::from(*sample) - *exact).to_f64();
            assert!(error.abs() < 1e-10, "q = {q}: {sample} is wrong by {error}");
        }
    }
}

/// The point that the valve comes to after so many returns from its release point.
fn map_image(map: &ReturnMap, q: f64, returns: u64) -> Vec<f64> {
    let start = Start {
        swept: vec![q],
        origin: Origin::Initial,
    };
    let (mut count, mut end) = (0, Vec::new());
    map.follow(&[0], &[start], &AtomicBool::new(false), &mut |arrival| {
        count += 1;
        end = arrival.point.to_vec();
        if count == returns {
            Command::Retire
        } else {
            Command::Continue
        }
    });
    end
}

#[test]
fn a_sweep_across_the_border_orbit_never_stalls() {
    let (_, map) = valve();
    let mut spec = sweep(0.019, 0.022, 121, 20, 40);
    spec.start = Begin::CarryUp;
    let rows = diagram(&map, &spec, &Threads::new(2)).unwrap();
    for row in &rows {
        let q = spec.sweeps[0].value(row.row);
        // Below q* = 0.02005 the border orbit's chatter is complete: one orbit, impacts without number.
        if q < 0.02 {
            assert_eq!(
                (row.outcome, row.period),
                (Outcome::CompleteChatter, 1),
                "q = {q}"
            );
            assert_eq!(row.impacts_per_return, f64::INFINITY);
        }
        if q > 0.0202 {
            assert!(matches!(
                row.outcome,
                Outcome::Chaotic | Outcome::Periodic | Outcome::Unsettled
            ));
            assert!((20.0..50.0).contains(&row.impacts_per_return));
        }
    }
}

#[test]
fn small_restitution_chatters_completely_and_none_sticks_at_once() {
    let (_, map) = valve();
    let mut spec = sweep(0.0203, 0.0205, 2, 10, 20);
    spec.sweeps.push(Range::linear("r", 0.0, 0.6, 7));
    spec.record = Record::Classes;
    let rows = diagram(&map, &spec, &Threads::new(1)).unwrap();
    for row in &rows {
        let r = row.row / 2;
        let expected = if r == 0 {
            Outcome::Periodic
        } else {
            Outcome::CompleteChatter
        };
        assert_eq!((row.outcome, row.period), (expected, 1), "row {}", row.row);
    }
    assert_eq!(rows[0].impacts_per_return, 1.0);
}

/// x'' = -x with a wall at x = 0: every flight is half a turn.
fn wall(extra: &str) -> Model {
    let text = format!(
        "[parameters]\nr = 0.5\nc = 1\n[flight]\nx = \"v\"\nv = \"-x + 0*c\"\n[[contact]]\nname = \"wall\"\ngap = \"x\"\n\
         impulse = {{ v = 1 }}\nrestitution = \"r\"\n[section.top]\nsurface = \"v\"\ndirection = \"falling\"\n{extra}\
         [initial]\nx = 0\nv = 1\n"
    );
    Model::from_toml(&text, "wall").unwrap()
}

#[test]
fn every_kind_of_look_has_its_exact_map() {
    let model = wall("");
    let pi = core::f64::consts::PI;
    let follow = |sampling: Sampling, swept: f64| {
        let map = ReturnMap::new(&model, &ReturnSpec::new(sampling)).unwrap();
        let start = Start {
            swept: vec![swept],
            origin: Origin::Initial,
        };
        let mut told = Vec::new();
        map.follow(&[0], &[start], &AtomicBool::new(false), &mut |arrival| {
            told.push((arrival.point.to_vec(), arrival.passage.clone().unwrap()));
            if told.len() == 4 {
                Command::Retire
            } else {
                Command::Continue
            }
        });
        told
    };
    let event = |kind, at: Option<&str>| Sampling::Event {
        kind,
        at: at.map(str::to_owned),
    };
    for (place, (point, passage)) in follow(event(EventKind::Impact, None), 0.5)
        .iter()
        .enumerate()
    {
        let v = 0.5_f64.powi(place as i32 + 1);
        assert!(point[0] == 0.0 && (point[1] - v).abs() < 1e-14);
        assert!((passage.return_time - pi).abs() < 1e-13 && passage.impacts == 1);
        assert!(place == 0 || (passage.flight_time - pi).abs() < 1e-13);
    }
    let tops = follow(event(EventKind::Section, Some("top")), 0.25);
    for (place, (point, passage)) in tops.iter().enumerate() {
        assert!((point[0] - 0.25_f64.powi(place as i32)).abs() < 1e-14);
        let time = if place == 0 { pi / 2.0 } else { pi };
        assert!((passage.return_time - time).abs() < 1e-13);
        assert_eq!(passage.impacts, u64::from(place > 0));
    }
    let strobe = Sampling::Stroboscopic {
        period: "2*pi*c".to_owned(),
    };
    for (place, (point, passage)) in follow(strobe, 0.5).iter().enumerate() {
        // Two impacts a period; the second may fall to either side of the look.
        assert!(point[0].abs() < 1e-12, "{point:?}");
        let size = 0.25_f64.powi(place as i32 + 1);
        let ratio = point[1] / size;
        assert!(
            (ratio - 1.0).abs() < 1e-9 || (ratio + 2.0).abs() < 1e-9,
            "{point:?}"
        );
        assert!((passage.return_time - 2.0 * pi).abs() < 1e-12);
    }
}

#[test]
fn the_next_point_is_the_one_that_an_orbit_comes_to() {
    let (_, map) = valve();
    let parameters = map.parameter_values(&[(0, 0.0203)]);
    let mut point = map.initial_point(&parameters);
    // The first call starts off the section, as an orbit does.
    map.next(&parameters, &mut point).unwrap();
    assert!((point[2] - 9.7).abs() < 1e-13);
    for _ in 0..20 {
        let passage = map.next(&parameters, &mut point).unwrap();
        assert!((30..40).contains(&passage.impacts), "{passage:?}");
        assert!((point[2] - 9.7).abs() < 1e-13);
    }
}

#[test]
fn orbits_that_do_not_return_are_called_off() {
    // The ball at rest never rises to its apex again; the parameter only counts the columns.
    let model = shipped("bouncing_ball");
    let map = ReturnMap::new(&model, &ReturnSpec::section("apex")).unwrap();
    let mut spec = Spec::new(Range::linear("r", 0.3, 0.6, 4), "y", 0, 500);
    spec.observe
        .push(crate::analysis::diagram::Observed::plain("impacts + r"));
    let rows = diagram(&map, &spec, &Threads::new(1)).unwrap();
    assert!(rows.iter().all(|row| row.outcome == Outcome::NoReturn));
    // Heights of the apexes: r^2 each.
    for (row, r) in rows.iter().zip([0.3, 0.4, 0.5, 0.6_f64]) {
        let heights: Vec<f64> = row.samples.iter().copied().step_by(2).take(3).collect();
        for (k, y) in heights.iter().enumerate() {
            assert!(
                (y / r.powi(2 * (k as i32 + 1)) - 1.0).abs() < 1e-12,
                "r = {r}: {y}"
            );
        }
        assert!((row.samples[3] - 1.0 - r).abs() < 1e-15);
    }
    let mut spec = ReturnSpec::section("apex");
    spec.most_impacts = 3;
    spec.sampling = Sampling::Event {
        kind: EventKind::Release,
        at: None,
    };
    let map = ReturnMap::new(&model, &spec).unwrap();
    let parameters = map.parameter_values(&[(model.parameter_index("r").unwrap(), 0.95)]);
    let mut point = map.initial_point(&parameters);
    let told = map.next(&parameters, &mut point);
    assert_eq!(told, Err(NoReturn::Impacts { limit: 3 }));
}

#[test]
fn starts_inside_the_obstacle_are_drawn_again() {
    let (_, map) = valve();
    let mut spec = sweep(0.0203, 0.0203, 1, 5, 5);
    let bounds = |from, to| Begin::Random {
        count: 8,
        seed: 3,
        bounds: vec![Bounds {
            coordinate: "y1".to_owned(),
            from,
            to,
        }],
    };
    spec.start = bounds(-0.1, 0.01);
    let rows = diagram(&map, &spec, &Threads::new(1)).unwrap();
    assert!(rows.iter().all(|row| row.samples.len() == 5));
    spec.start = bounds(-0.2, -0.1);
    let rows = diagram(&map, &spec, &Threads::new(1)).unwrap();
    assert!(rows.iter().all(|row| row.outcome == Outcome::NoStart));
}

#[test]
fn a_forced_oscillator_keeps_its_phase_while_its_frequency_is_swept() {
    let model = shipped("impact_oscillator");
    let strobe = ReturnSpec::new(Sampling::Stroboscopic {
        period: "2*pi/omega".to_owned(),
    });
    let map = ReturnMap::new(&model, &strobe).unwrap();
    let mut spec = Spec::new(Range::linear("omega", 2.6, 2.9, 8), "v", 300, 20);
    (spec.start, spec.chunk) = (Begin::CarryUp, Some(8));
    let carried = diagram(&map, &spec, &Threads::new(1)).unwrap();
    let settled: Vec<&Row> = carried.iter().filter(|row| row.period > 0).collect();
    assert!(settled.len() >= 2, "{}", settled.len());
    spec.start = Begin::Fresh;
    let fresh = diagram(&map, &spec, &Threads::new(1)).unwrap();
    for row in settled {
        let other = &fresh[row.row as usize];
        if other.period == row.period {
            let nearest = |x: f64| {
                other
                    .samples
                    .iter()
                    .fold(9.0_f64, |d, y| d.min((x - y).abs()))
            };
            assert!(row.samples.iter().all(|&x| nearest(x) < 1e-6));
        }
    }
}

/// A model at this value of a parameter, looked at so: exponent of the attractor, and modulus of the largest multiplier of its orbit.
fn exponent_and_multiplier(
    name: &str,
    (parameter, value): (&str, f64),
    (at, keep): (Sampling, u64),
) -> [f64; 2] {
    let model = shipped(name);
    let map = ReturnMap::new(&model, &ReturnSpec::new(at)).unwrap();
    let observed = &model.states[0].name;
    let mut spec = Spec::new(
        Range::linear(parameter, value, value, 1),
        observed,
        400,
        keep,
    );
    let plain = diagram(&map, &spec, &Threads::new(1)).unwrap();
    spec.exponent = Exponent::Largest;
    let rows = diagram(&map, &spec, &Threads::new(1)).unwrap();
    assert!(rows[0].samples == plain[0].samples);
    assert_eq!(rows[0].period, 1, "{name}");
    let mut model = model;
    model
        .set_parameter(parameter, &format!("{value:?}"))
        .unwrap();
    let orbit = periodic::settled(&model, &periodic::Spec::default(), &mut |_| {
        ControlFlow::Continue(())
    });
    [rows[0].exponent, orbit.unwrap().multipliers[0].modulus()]
}

#[test]
fn exponents_of_stable_orbits_are_their_multipliers() {
    let section = |name: &str| ReturnSpec::section(name).sampling;
    let strobe = |period: &str| Sampling::Stroboscopic {
        period: period.to_owned(),
    };
    // Returns of an autonomous model; a mass that sticks four times a period; one between two stops.
    for (name, at, look) in [
        ("pressure_relief_valve", ("q", 0.0203), section("closing")),
        (
            "forced_coulomb_oscillator",
            ("omega", 0.2),
            strobe("2*pi/omega"),
        ),
        (
            "impact_oscillator_two_sided",
            ("omega", 1.24),
            strobe("2*pi/omega"),
        ),
    ] {
        // Few samples say as much as many: the displacement has turned before they are counted.
        for keep in [4, 200] {
            let looked = (look.clone(), keep);
            let [exponent, multiplier] = exponent_and_multiplier(name, at, looked);
            let off = exponent - libm::log(multiplier);
            assert!(
                off.abs() < 1e-9,
                "{name}: {exponent} and multiplier {multiplier}"
            );
        }
    }
    // Two multipliers on a circle, of a shaft that slides along a wall: what is off the wall would die out more slowly.
    let at = ("speed", 1.16);
    let [exponent, multiplier] =
        exponent_and_multiplier("rotor_in_clearance", at, (strobe("2*pi/speed"), 200));
    let off = exponent - libm::log(multiplier);
    assert!(off.abs() < 0.01, "{exponent} and multiplier {multiplier}");
}

/// Looked at at each impact of a chatter whose end forgets all, in a phase that is a state.
#[test]
fn complete_chatter_is_forgotten_whenever_it_is_looked_at() {
    let model = shipped("bouncing_ball_on_table");
    let at = Sampling::Event {
        kind: EventKind::Impact,
        at: None,
    };
    let map = ReturnMap::new(&model, &ReturnSpec::new(at)).unwrap();
    let mut spec = Spec::new(Range::linear("Gamma", 1.2, 1.4, 3), "v", 200, 200);
    spec.exponent = Exponent::Largest;
    for row in diagram(&map, &spec, &Threads::new(1)).unwrap() {
        assert_eq!(row.outcome, Outcome::CompleteChatter);
        assert_eq!(row.exponent, f64::NEG_INFINITY, "row {}", row.row);
    }
}

#[test]
fn the_clock_of_a_stroboscopic_map_is_no_direction() {
    // Budd & Dux's (1, 1) orbit: one impact a period. The determinant of its map is r^2 (two flights of a free oscillator keep
    // areas, an impact takes r^2 of them), and both multipliers lie on the circle of radius r where they are complex.
    let model = shipped("impact_oscillator");
    let strobe = ReturnSpec::new(Sampling::Stroboscopic {
        period: "2*pi/omega".to_owned(),
    });
    let map = ReturnMap::new(&model, &strobe).unwrap();
    let mut spec = Spec::new(Range::linear("omega", 2.2, 2.4, 5), "v", 400, 400);
    spec.exponent = Exponent::Largest;
    let rows = diagram(&map, &spec, &Threads::new(1)).unwrap();
    for row in &rows {
        assert_eq!((row.outcome, row.period), (Outcome::Periodic, 1));
        assert_eq!(row.impacts_per_return, 1.0);
        let expected = libm::log(0.8);
        assert!(
            (row.exponent - expected).abs() < 0.02,
            "row {}: {} for {expected}",
            row.row,
            row.exponent
        );
    }
}

/// A forced oscillator of some amplitude at a stop, and a state of another size that touches nothing.
fn beside_another(amplitude: f64, beside: f64) -> Model {
    let text = format!(
        "[parameters]\nw = 2.5\n[flight]\nx = \"v\"\nv = \"{amplitude:e}*cos(w*t) - x\"\np = \"{beside:e} - p\"\n[[contact]]\n\
         name = \"stop\"\ngap = \"-x\"\nimpulse = {{ v = -1 }}\nrestitution = 0.5\n[initial]\nx = 0\nv = \"-0.5*{amplitude:e}\"\n\
         p = \"1.1*{beside:e}\"\n"
    );
    Model::from_toml(&text, "beside").unwrap()
}

/// What an orbit settles to, and its exponent, are the same whatever the units of its states are.
#[test]
fn rows_do_not_depend_on_units() {
    let strobe = ReturnSpec::new(Sampling::Stroboscopic {
        period: "2*pi/w".to_owned(),
    });
    let rows = |amplitude, beside| {
        let map = ReturnMap::new(&beside_another(amplitude, beside), &strobe).unwrap();
        // So many that chaos is told from chance.
        let mut spec = Spec::new(Range::linear("w", 2.5, 2.833_333_3, 3), "v", 300, 3000);
        spec.exponent = Exponent::Largest;
        diagram(&map, &spec, &Threads::new(1)).unwrap()
    };
    let plain = rows(1.0, 1.0);
    let outcomes = [Outcome::Periodic, Outcome::Periodic, Outcome::Chaotic];
    // Of the multipliers of the orbits of one and two periods; of a finite part of chaos.
    let exponents = [(-0.693, 0.02), (-0.175_83, 1e-3), (0.11, 0.05)];
    for (amplitude, beside) in [
        (1.0, 1.0),
        (1e-3, 1e5),
        (1e-6, 1e7),
        (1e-9, 1.0),
        (1e9, 1e-9),
    ] {
        let at = format!("{amplitude:e} {beside:e}");
        for (row, known) in rows(amplitude, beside).iter().zip(&plain) {
            let place = row.row as usize;
            assert_eq!(
                (row.outcome, row.period),
                (known.outcome, known.period),
                "{at}"
            );
            assert_eq!(row.outcome, outcomes[place], "{at}");
            let (exponent, within) = exponents[place];
            assert!(
                (row.exponent - exponent).abs() < within,
                "{at}: {}",
                row.exponent
            );
        }
    }
}

/// Whenever it starts: it is looked at in one phase of what drives it.
#[test]
fn orbits_that_start_at_any_time_are_looked_at_in_one_phase() {
    let strobe = ReturnSpec::new(Sampling::Stroboscopic {
        period: "2*pi/omega".to_owned(),
    });
    let map = ReturnMap::new(&shipped("impact_oscillator"), &strobe).unwrap();
    let range = Range::initial("t", 0.0, 1.0, 3);
    let rows = diagram(&map, &Spec::new(range, "v", 60, 20), &Threads::new(1)).unwrap();
    for row in &rows {
        assert_eq!((row.outcome, row.period), (rows[0].outcome, 1));
        assert!((row.samples[19] - rows[0].samples[19]).abs() < 1e-9);
    }
}

#[test]
fn orbits_that_come_to_rest_on_the_way_forget_where_they_came_from() {
    let (_, map) = valve();
    let mut spec = sweep(0.0190, 0.0200, 12, 20, 40);
    spec.exponent = Exponent::Largest;
    let rows = diagram(&map, &spec, &Threads::new(1)).unwrap();
    for row in &rows {
        assert_eq!(row.outcome, Outcome::CompleteChatter);
        assert_eq!(row.exponent, f64::NEG_INFINITY, "row {}", row.row);
    }
}

/// A cradle's balls hit at one instant, one order of blows beside the other: orbits beside leave it by a jump, which is no growth.
#[test]
fn an_orbit_that_the_order_of_impacts_decides_has_no_exponent() {
    let strobe = ReturnSpec::new(Sampling::Stroboscopic {
        period: "2*pi".to_owned(),
    });
    let map = ReturnMap::new(&shipped("newtons_cradle"), &strobe).unwrap();
    let mut spec = Spec::new(Range::linear("r", 0.9, 0.99, 2), "v1", 1, 100);
    spec.exponent = Exponent::Largest;
    for row in diagram(&map, &spec, &Threads::new(1)).unwrap() {
        assert!(row.exponent.is_nan(), "{}", row.exponent);
        assert_ne!(row.outcome, Outcome::Chaotic);
    }
}

#[test]
fn wrong_looks_are_refused() {
    let (model, _) = valve();
    let error = |change: &dyn Fn(&mut ReturnSpec)| {
        let mut spec = ReturnSpec::section("closing");
        change(&mut spec);
        ReturnMap::new(&model, &spec).unwrap_err()
    };
    let unknown = error(&|spec| *spec = ReturnSpec::section("closinng"));
    assert_eq!(
        unknown.to_string(),
        "the model has no section `closinng`: it has `closing`"
    );
    assert_eq!(unknown.suggestion().as_deref(), Some("closing"));
    let text = |change: &dyn Fn(&mut ReturnSpec)| error(change).to_string();
    let strobe = |period: &str| Sampling::Stroboscopic {
        period: period.to_owned(),
    };
    assert!(text(&|spec| spec.sampling = strobe("2*")).contains("the period `2*`"));
    assert!(text(&|spec| spec.sampling = strobe("y1")).contains("expression in parameters"));
    assert!(text(&|spec| spec.sampling = strobe("-q")).contains("positive"));
    assert!(text(&|spec| spec.longest_return = 0.0).contains("positive"));
    assert!(text(&|spec| spec.most_impacts = 0).contains("at least one impact"));
    assert!(text(&|spec| spec.tolerance = 2.0).contains("tolerance"));
}

#[test]
fn a_parameter_that_is_called_as_a_start_is_not_swept() {
    let text = "[parameters]\ninitial_v = 0.1\n[flight]\nx = \"v\"\nv = \"-x - initial_v*v + cos(t)\"\n\
         [initial]\nx = 0\nv = 1\n";
    let model = Model::from_toml(text, "model.toml").expect("a valid model");
    let period = "2*pi".to_owned();
    let map = ReturnMap::new(&model, &ReturnSpec::new(Sampling::Stroboscopic { period })).unwrap();
    let refused = |range| {
        let told = diagram(&map, &Spec::new(range, "x", 10, 10), &Threads::new(1));
        told.err().map(|error| error.to_string())
    };
    let told = refused(Range::linear("initial_v", 0.1, 0.3, 3)).expect("a refusal");
    assert!(told.contains("has a column `initial_v`"), "{told}");
    assert_eq!(refused(Range::initial("v", 0.1, 0.3, 3)), None);
}
