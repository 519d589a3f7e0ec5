//! Friction that turns just where its contact is released.

use crate::periodic::{over, with};
use chatter::analysis::periodic::{End, SpecialKind};

/// A part on an oblique conveyor: thrown, it bounces to rest, slides on, back and on again until it is thrown. The last turn comes just with the
/// release at A = 2.369095080317159, where friction is nothing: the motion is smooth through it, and nothing is told. Its rate at t = 0 on
/// either side is that of an integration from event to event in numbers of 36 digits.
const FEEDER: &str = r#"
[parameters]
A = 2.37
[definitions]
along = "A*cos(0.5)*cos(t)"
[flight]
x = "u"
u = "0"
y = "v"
v = "-1"
[[contact]]
name = "trough"
gap = "y - A*sin(0.5)*sin(t)"
impulse = { v = 1 }
restitution = 0.4
friction = { coefficient = 0.3, along = { u = 1 }, rate = "u - along" }
[section.s]
surface = "sin(t)"
direction = "rising"
[initial]
x = 0
u = 0
y = 1
v = 0
"#;

#[test]
fn a_branch_goes_smoothly_through_where_sliding_turns_at_a_release() {
    let expected = [
        (2.369, 0.841_947_092_577_249_6),
        (2.37, 0.842_252_685_569_573_1),
    ];
    for (start, step) in [
        ("2.3692", 0.05),
        ("2.36905", 0.01),
        ("2.369095", 0.2),
        ("2.3690951", 0.02),
        ("2.369098", 0.05),
    ] {
        let model = with(FEEDER, &[("A", start)]);
        let found = over(&model, "A", (2.369, 2.37), (9, step));
        let branch = &found[0];
        assert_eq!(branch.ends, [End::Range, End::Range], "{start} {step}");
        assert!(branch.special.is_empty(), "{start} {step}");
        let ends = [branch.points.first(), branch.points.last()];
        for end in ends.into_iter().flatten() {
            let known = expected
                .iter()
                .find(|(at, _)| (at - end.parameter()).abs() < 1e-12);
            let &(_, rate) = known.unwrap();
            assert!((end.state[1] - rate).abs() < 1e-12, "{start} {step}");
        }
    }
}

/// A block on a shaken rough plate, pulled by a spring.
const PULLED: &str = r#"
[parameters]
A = 0.25
[flight]
x = "u"
u = "-x - 0.1*u + 0.6*cos(2.5*t)"
y = "v"
v = "-1"
[[contact]]
name = "plate"
gap = "y - A*sin(2.5*t)"
impulse = { v = 1 }
restitution = 0.5
friction = { coefficient = 0.4, along = { u = 1 }, rate = "u - 0.3" }
[section.s]
surface = "sin(2.5*t)"
direction = "rising"
[initial]
x = 0
u = 0
y = 0.3
v = 0
"#;

/// Release and turn change places at A = 0.19626833432787, by closed forms of the flights: by short steps and by one that goes far beyond nothing is told.
#[test]
fn a_long_step_past_a_release_that_comes_before_its_turn_tells_nothing() {
    for step in [0.1, 0.3] {
        let model = with(PULLED, &[("A", "0.21")]);
        let found = over(&model, "A", (0.1945, 0.215), (3, step));
        assert_eq!(found[0].ends, [End::Range, End::Range], "{step}");
        assert!(found[0].special.is_empty(), "{step} {:?}", found[0].special);
    }
}

/// At an impact friction stops the sliding, and in the flight after it, where there is none, the force on the block vanishes at A = 0.299856890: from there on it
/// goes to the other side at once. Its multipliers go smoothly through that, by closed forms of the flights.
#[test]
fn a_flight_after_a_stop_may_lead_to_either_side() {
    for (start, step) in [("0.25", 0.1), ("0.25", 0.02), ("0.26", 0.05)] {
        let model = with(PULLED, &[("A", start)]);
        let found = over(&model, "A", (0.245, 0.305), (3, step));
        assert_eq!(found[0].ends, [End::Range, End::Range], "{start} {step}");
        let kinds: Vec<SpecialKind> = found[0].special.iter().map(|s| s.kind).collect();
        assert_eq!(kinds, [SpecialKind::PeriodDoubling], "{start} {step}");
    }
}
