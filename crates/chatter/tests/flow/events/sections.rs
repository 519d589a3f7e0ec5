//! Sections at the instants of other events: each crossing is told once, decided by the signs before and after.

use chatter::flow::{Occurrence, Settings, System, Trajectory};
use chatter::model::{Direction, Model, ModelBuilder};
use chatter::numerics::{DoubleDouble, Real};
use proptest::prelude::*;

const BOTH: [Direction; 3] = [Direction::Rising, Direction::Falling, Direction::Either];

/// Times and names of all that happens until `until`; sections have the names of their order.
fn told<R: Real>(model: &Model, until: f64) -> Vec<(String, f64)> {
    let system = System::new(model).expect("a valid system");
    let mut work = system.workspace::<R>(&Settings::default());
    let parameters = model.parameter_values::<R>(&[]);
    let state = model.initial_state(&parameters);
    let start = model.time.map_or(R::ZERO, |index| state[index]);
    let mut trajectory =
        Trajectory::start(&system, &mut work, &parameters, start, &state).expect("a legal start");
    let mut all = Vec::new();
    loop {
        let what =
            (trajectory.advance(&system, &mut work, R::splat(until))).expect("a finite field");
        let name = match what {
            None => continue,
            Some(Occurrence::Horizon) => return all,
            Some(Occurrence::Section { section }) => section.to_string(),
            Some(Occurrence::Impact { .. }) => "impact".to_owned(),
            Some(Occurrence::Graze { .. }) => "graze".to_owned(),
            Some(Occurrence::Accumulation { .. }) => "accumulation".to_owned(),
            Some(Occurrence::Capture { .. }) => "capture".to_owned(),
            Some(Occurrence::Release { .. }) => "release".to_owned(),
            Some(Occurrence::Cascade { .. }) => "cascade".to_owned(),
            Some(Occurrence::Ambiguity { .. }) => "ambiguity".to_owned(),
            Some(other) => panic!("equations without corners: {other:?}"),
        };
        all.push((name, trajectory.time().to_f64()));
    }
}

fn count(told: &[(String, f64)], name: &str) -> usize {
    told.iter().filter(|(what, _)| what == name).count()
}

/// How often each section is crossed rising, falling and either way, in doubles and in longer numbers alike.
fn crossings(base: &ModelBuilder, surfaces: &[&str], until: f64) -> Vec<[usize; 3]> {
    let all = surfaces.iter().map(|surface| {
        BOTH.map(|direction| {
            let model = base.clone().section("watched", *surface, direction);
            let model = model.build().expect("a valid model");
            let short = count(&told::<f64>(&model, until), "0");
            let long = count(&told::<DoubleDouble>(&model, until), "0");
            assert_eq!(short, long, "{surface} {direction:?} until {until}");
            short
        })
    });
    all.collect()
}

/// A ball that meets the table at its lowest rate of change once each period: at 1, 2, 3, … , and leaves it at 1.
fn table() -> ModelBuilder {
    ModelBuilder::new()
        .state("y", "v", 0.0)
        .state("v", "-2", 1.0)
        .contact("table", "y - sin(2*pi*t)/(6*pi)", [("v", 1.0)], "0.5")
}

#[test]
fn twenty_crossings_in_twenty_periods() {
    let surfaces = [
        "sin(2*pi*t)",
        "sin(pi*t)",
        "cos(2*pi*t)",
        "v",
        "y",
        "y - sin(2*pi*t)/(6*pi)",
        "sin(2*pi*t)/(6*pi) - y",
        "t - 5",
        "t",
        "v + 3*sin(pi*t)",
        "(t - 3)*(t - 5)^2",
    ];
    let expected = |last: usize| {
        vec![
            [last, 20, last + 20],
            [10, last - 10, last],
            [20, 21, 41],
            // Falls through zero in flight, and jumps up at each impact.
            [last, 20, last + 20],
            // Reaches zero and turns back.
            [0, 0, 0],
            [0, 0, 0],
            [0, 0, 0],
            [1, 0, 1],
            [0, 0, 0],
            [0, 0, 0],
            [1, 0, 1],
        ]
    };
    let found = crossings(&table(), &surfaces, 20.3);
    let mut expected = expected(20);
    let [rising, falling, either] = found[9];
    assert_eq!(rising + falling, either);
    assert!(rising.abs_diff(falling) <= 1);
    expected[9] = found[9];
    assert_eq!(found, expected);
    // A crossing at the end belongs to what ends there.
    let strobes = crossings(&table(), &surfaces[..2], 20.0);
    assert_eq!(strobes, expected[..2]);
}

#[test]
fn two_sections_and_an_impact_at_one_instant_are_all_told() {
    let model = table()
        .section("a", "sin(2*pi*t)", Direction::Rising)
        .section("b", "sin(pi*t)", Direction::Either)
        .build()
        .expect("a valid model");
    fn check<R: Real>(model: &Model) {
        let told = told::<R>(model, 20.5);
        for period in 0..20 {
            let here = &told[3 * period..3 * period + 3];
            // Their order is a matter of rounding.
            for name in ["impact", "0", "1"] {
                assert_eq!(count(here, name), 1, "{period} {here:?}");
            }
            for (_, time) in here {
                assert!((time - (period + 1) as f64).abs() < 1e-12, "{time}");
            }
        }
        assert_eq!(told.len(), 60);
    }
    check::<f64>(&model);
    check::<DoubleDouble>(&model);
}

/// The table's acceleration reaches gravity at each release: how often it does so at all is known.
#[test]
fn a_section_at_release_is_crossed_once() {
    let (amplitude, gravity) = (1.7, 1.0);
    let base = ModelBuilder::new()
        .state("y", "v", 0.0)
        .state("v", "-1", 0.0)
        .contact("table", "y - 1.7*sin(t)", [("v", 1.0)], "0.3");
    let surface = "-1.7*sin(t) + 1";
    let until = 300.0;
    let first = f64::asin(gravity / amplitude);
    let turn = 2.0 * core::f64::consts::PI;
    let times = |first: f64| ((until - first) / turn).floor() as usize + 1;
    let falling = times(first);
    let rising = times(core::f64::consts::PI - first);
    let releases = count(
        &told::<f64>(&base.clone().build().unwrap(), until),
        "release",
    );
    assert!(releases > 20, "{releases}");
    assert_eq!(
        crossings(&base, &[surface], until),
        [[rising, falling, rising + falling]]
    );
}

#[test]
fn a_section_at_an_accumulation_a_graze_or_the_start_is_crossed_once_or_not() {
    // Falls from 1 at t = 1; the flights last 1, 1/2, 1/4, …: at rest from 3 on.
    let ball = ModelBuilder::new()
        .state("y", "v", 1.0)
        .state("v", "-2", 0.0)
        .contact("floor", "y", [("v", 1.0)], "0.5");
    assert_eq!(
        crossings(&ball, &["t - 3", "t - 1", "t", "t - 10"], 10.0),
        [[1, 0, 1], [1, 0, 1], [0, 0, 0], [1, 0, 1]]
    );
    // Touches the floor at 2 pi.
    let graze = ModelBuilder::new()
        .state("x", "v", 0.0)
        .state("v", "cos(t)", 0.0)
        .contact("floor", "x", [("v", 1.0)], "0.5");
    assert_eq!(
        crossings(&graze, &["sin(t)", "sin(t/2)", "x", "v"], 9.0),
        [[1, 1, 2], [0, 1, 1], [0, 0, 0], [1, 1, 2]]
    );
}

#[derive(Clone, Debug)]
struct Rattling {
    force: f64,
    frequency: f64,
    gap: f64,
    restitution: f64,
    surface: String,
}

impl Rattling {
    fn model(&self, factor: f64, direction: Direction) -> Model {
        ModelBuilder::new()
            .state("x", "v", 0.1)
            .state(
                "v",
                format!("-x - 0.1*v + {:?}*cos({:?}*t)", self.force, self.frequency),
                0.4,
            )
            .contact(
                "right",
                format!("{:?} - x", self.gap),
                [("v", -1.0)],
                format!("{:?}", self.restitution),
            )
            .contact(
                "left",
                format!("x + {:?}", self.gap),
                [("v", 1.0)],
                format!("{:?}", self.restitution),
            )
            .section(
                "watched",
                format!("{factor:e}*({})", self.surface),
                direction,
            )
            .build()
            .expect("a valid model")
    }
}

fn rattling() -> impl Strategy<Value = Rattling> {
    let surface = (0_usize..7, -0.8_f64..0.8, -1.0_f64..1.0);
    (
        0.5_f64..4.0,
        0.4_f64..3.0,
        0.1_f64..0.9,
        0.1_f64..0.9,
        surface,
    )
        .prop_map(
            |(force, frequency, gap, restitution, (form, a, b))| Rattling {
                force,
                frequency,
                gap,
                restitution,
                surface: match form {
                    0 => "v".to_owned(),
                    1 => format!("v - {a:?}"),
                    2 => format!("x - {:?}", a * gap),
                    3 => format!("v + {a:?}*x + {b:?}*sin(t)"),
                    4 => format!("x*v + {a:?}"),
                    5 => format!("sin({frequency:?}*t + {b:?})"),
                    _ => format!("{gap:?} - x"),
                },
            },
        )
}

/// Rising and falling crossings alternate, together they are those either way, and a positive factor changes nothing.
fn every_change_counts_once<R: Real>(rattling: &Rattling, until: f64) -> Result<(), TestCaseError> {
    let times = |factor, direction| -> Vec<f64> {
        let all = told::<R>(&rattling.model(factor, direction), until);
        (all.into_iter().filter(|(what, _)| what == "0"))
            .map(|(_, time)| time)
            .collect()
    };
    let [rising, falling, either] = BOTH.map(|direction| times(1.0, direction));
    prop_assert_eq!(rising.len() + falling.len(), either.len());
    let mut merged: Vec<(f64, bool)> = (rising.iter().map(|&t| (t, true)))
        .chain(falling.iter().map(|&t| (t, false)))
        .collect();
    merged.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (pair, both) in merged.windows(2).zip(either.windows(2)) {
        // At one instant the order of a jump and of a crossing is not in their times.
        prop_assert!(
            pair[0].1 != pair[1].1 || pair[0].0 == pair[1].0,
            "{:?}",
            pair
        );
        prop_assert!((pair[0].0 - both[0]).abs() < 1e-6, "{:?} {:?}", pair, both);
    }
    for factor in [1e-9, 3.0, 1e9] {
        let scaled = times(factor, Direction::Either);
        prop_assert_eq!(scaled.len(), either.len(), "{}", factor);
    }
    let other = times(-1.0, Direction::Rising);
    prop_assert_eq!(other.len(), falling.len());
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Some of these oscillators are chaotic, a last digit grows by 1e10 in thirty units of time: longer numbers keep the
    /// rest, and double precision is asked only while it has it.
    #[test]
    fn every_change_of_sign_counts_once(rattling in rattling()) {
        every_change_counts_once::<f64>(&rattling, 10.0)?;
        every_change_counts_once::<DoubleDouble>(&rattling, 30.0)?;
    }
}

/// A section that is crossed at the instant of a release is only looked at: what the motion does stays the same, whatever
/// the pull on the contact is.
#[test]
fn a_section_crossed_at_a_release_changes_nothing() {
    for k in 0..24 {
        let (growth, phase) = (0.7 + 0.07 * f64::from(k), 0.4 * f64::from(k));
        for restitution in [0.0, 0.3] {
            let base = ModelBuilder::new()
                .state("y", "v", 0.0)
                .state(
                    "v",
                    format!("-1.65625 + 0.125*y + {growth}*v - 1.96875*sin(3*t + {phase})"),
                    0.0,
                )
                .contact("floor", "y", [("v", 1.0)], restitution);
            let alone = told::<f64>(&base.clone().build().expect("a valid model"), 6.0);
            let watched = base.section("up", "v", Direction::Rising);
            let watched = told::<f64>(&watched.build().expect("a valid model"), 6.0);
            let others: Vec<_> = watched
                .into_iter()
                .filter(|(what, _)| what != "0")
                .collect();
            let names = |told: &[(String, f64)]| -> Vec<String> {
                told.iter().map(|(what, _)| what.clone()).collect()
            };
            assert_eq!(
                names(&others),
                names(&alone),
                "{growth} {phase} {restitution}"
            );
            for ((_, a), (_, b)) in others.iter().zip(&alone) {
                assert!(
                    (a - b).abs() < 1e-10,
                    "{a} {b}: {growth} {phase} {restitution}"
                );
            }
        }
    }
}

/// A section that is the gap itself is reached by each impact and crossed by none, however low the flights are that are left when the
/// sequence is at its end.
#[test]
fn the_gap_is_no_section_that_chatter_crosses() {
    let rattling = Rattling {
        force: 3.3530731422845697,
        frequency: 2.1517347045826045,
        gap: 0.540129335985157,
        restitution: 0.10444849581820438,
        surface: "0.540129335985157 - x".to_owned(),
    };
    for direction in BOTH {
        let told = told::<f64>(&rattling.model(1.0, direction), 40.0);
        assert_eq!(count(&told, "0"), 0);
    }
}
