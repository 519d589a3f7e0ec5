//! Surveys that are broken off and gone on with.

use crate::periodic::branches::TWO_SIDED;
use crate::periodic::{branch_spec, broken_off_after, model, read, with};
use chatter::analysis::periodic::{Beside, Branch, BranchSpec, End, Spec, Special, branches};
use chatter::model::Model;

/// A mass between friction and a stop: its modes are met in another order by whoever begins elsewhere.
const RUBBING: &str = r#"
[parameters]
w = 1.6
mu = 0.25
[flight]
x = "v"
v = "-x - 0.1*v - mu*sign(v) + cos(w*t)"
[[contact]]
gap = "0.35 - x"
impulse = { v = -1 }
restitution = 0.7
[initial]
x = 0
v = 0.3
"#;

struct Asked {
    model: Model,
    over: BranchSpec,
}

impl Asked {
    fn new(model: Model, parameter: &str, range: (f64, f64), doublings: usize) -> Self {
        let beside = Beside {
            doublings,
            branch_points: doublings,
        };
        let over = branch_spec(&model, (parameter, range), (38, 0.003), beside);
        Self { model, over }
    }

    /// Follows from where records end, for so many orbits; with the records that there are then.
    fn follow(&self, before: &[String], most: usize) -> (Vec<Branch>, Vec<String>) {
        let mut records = before.to_vec();
        let mut tell = broken_off_after(most, &mut records);
        let before = read(before);
        let found = branches(&self.model, &Spec::default(), &self.over, before, &mut tell);
        drop(tell);
        (found.unwrap(), records)
    }

    fn is_the_same_however_often_it_is_broken_off(&self, every: usize) {
        let (whole, _) = self.follow(&[], usize::MAX);
        let mut records = Vec::new();
        for attempt in 0.. {
            let (found, known) = self.follow(&records, every);
            records = known;
            let interrupted = |branch: &Branch| branch.ends.contains(&End::Interrupted);
            if !found.iter().any(interrupted) {
                assert!(attempt > 2, "{attempt}");
                assert_eq!(told(&found), told(&whole));
                return;
            }
            assert!(attempt < 100);
        }
    }
}

/// Every number of branches, to the bit.
fn told(branches: &[Branch]) -> Vec<String> {
    let special = |special: &Special| {
        let Special {
            kind,
            point,
            error,
            residual,
            persists,
            above,
            monitor,
            leaves,
            place,
            ..
        } = special;
        format!(
            "{kind:?} {point:?} {error} {residual} {persists:?} {above:?} {monitor:?} {leaves:?} {place}"
        )
    };
    let lines = |branch: &Branch| {
        let points = branch.points.iter().map(|point| format!("{point:?}"));
        let mut lines: Vec<String> = points.collect();
        lines.extend(branch.special.iter().map(special));
        lines.push(format!("{:?}", branch.ends));
        lines
    };
    branches.iter().flat_map(lines).collect()
}

#[test]
fn a_cascade_goes_on_to_the_bit() {
    let valve = model("pressure_relief_valve", &[("q", "0.0203")]);
    Asked::new(valve, "q", (0.02026, 0.02036), 0).is_the_same_however_often_it_is_broken_off(77);
}

#[test]
fn both_sides_of_a_chatter_border_go_on_to_the_bit() {
    let valve = model("pressure_relief_valve", &[("q", "0.02")]);
    let asked = Asked::new(valve, "q", (0.02003, 0.0200562), 0);
    asked.is_the_same_however_often_it_is_broken_off(20);
}

#[test]
fn branches_that_leave_others_go_on_to_the_bit() {
    let asked = Asked::new(with(TWO_SIDED, &[]), "omega", (2.45, 2.65), 1);
    asked.is_the_same_however_often_it_is_broken_off(160);
}

#[test]
fn branches_with_friction_go_on_to_the_bit() {
    let asked = Asked::new(with(RUBBING, &[]), "w", (1.45, 1.7), 0);
    asked.is_the_same_however_often_it_is_broken_off(90);
}
