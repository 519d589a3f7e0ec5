//! Impacts that a branch leads past corners of the force: either order of both leads to one state, but to another derivative.

use crate::periodic::{over, value, with};
use chatter::analysis::periodic::{Branch, End, Point, SpecialKind};

/// A ball that is struck once a period of 2, at a phase that depends on A: where the mean force is -m it leaves with v = 2 m r/(1 + r). In other units of time
/// and length, and with an event for the contact.
fn struck(
    force: &str,
    (r, a): (f64, f64),
    (phase, mean): (f64, f64),
    (unit, length): (f64, f64),
    by: &str,
) -> String {
    let struck = match by {
        "contact" => format!(
            "[[contact]]\nname = 'floor'\ngap = 'x'\nimpulse = {{ v = 1 }}\nrestitution = {r:?}\n"
        ),
        _ => format!(
            "[[event]]\nname = 'floor'\nsurface = 'x'\ndirection = 'falling'\nreset = {{ v = '-{r:?}*v' }}\n"
        ),
    };
    let force = force.replace("TIME", &format!("(t/{unit:?})"));
    format!(
        "[parameters]\nA = {a:?}\n[flight]\nx = 'v/{unit:?}'\nv = '{length:?}*({force})/{unit:?}'\n{struck}\
         [initial]\nx = 0\nv = {:?}\nt = {:?}\n",
        2.0 * length * mean * r / (1.0 + r),
        unit * phase
    )
}

/// Whether multipliers are those of one impact with this restitution and force, that is met with a rate of 2 m/(1 + r), and a flight for a time of 2.
fn is_as_known(point: &Point, r: f64, (force, mean): (f64, f64)) -> bool {
    let trace = -2.0 * r - (1.0 + r) * (1.0 + r) * force / mean;
    let [one, other] = &point.multipliers[..] else {
        return false;
    };
    let product = one.re * other.re - one.im * other.im;
    (one.re + other.re - trace).abs() < 1e-8 && (product - r * r).abs() < 1e-9
}

/// What is told of a branch that comes to a corner and turns back there, on its other side: the mean force over the parameter, and the force at the impact
/// before and after.
fn turns_back(branch: &Branch, corner: f64, r: f64, known: &dyn Fn(f64) -> (f64, [f64; 2])) {
    assert_eq!(branch.ends, [End::Range, End::Range]);
    let [touch] = &branch.special[..] else {
        panic!("{:?}", branch.special);
    };
    assert_eq!(touch.kind, SpecialKind::Touch);
    assert!((value(touch) - corner).abs() <= touch.error && touch.error < 1e-11);
    assert_eq!(touch.persists, Some(false));
    assert!(touch.point.multipliers.is_empty());
    let mut seen = [0, 0];
    for point in &branch.points {
        let a = point.parameter();
        assert!(a >= corner - 1e-12);
        let (mean, forces) = known(a);
        let all = forces.map(|force| is_as_known(point, r, (force, mean)));
        assert!(all[0] != all[1], "{a} {:?}", point.multipliers);
        seen[usize::from(all[1])] += 1;
        let is_stable = point.multipliers.iter().all(|m| m.re.hypot(m.im) < 1.0);
        assert_eq!(point.is_stable(), is_stable);
    }
    assert!(seen.iter().all(|&seen| seen > 10), "{seen:?}");
}

const UNITS: [(f64, f64); 3] = [(1.0, 1.0), (1e-3, 1e3), (1e3, 1e-3)];

/// The force is a square wave -1 +- A: with r = 1/2 the impact comes by (1 - 2/(3 A))/2 after its switch or before it, and not below A = 2/3.
#[test]
fn a_branch_turns_back_where_an_impact_meets_the_switch_of_a_square_wave() {
    for (units, by) in UNITS.into_iter().zip(["contact", "event", "contact"]) {
        let phase = 0.5 * (1.0 - 2.0 / (3.0 * 0.8));
        let force = "-1 + A*sign(sin(pi*TIME))";
        let text = struck(force, (0.5, 0.8), (phase, 1.0), units, by);
        let branches = over(&with(&text, &[]), "A", (0.5, 0.9), (8, 0.02));
        assert_eq!(branches.len(), 1);
        turns_back(&branches[0], 2.0 / 3.0, 0.5, &|a| {
            (1.0, [a - 1.0, -1.0 - a])
        });
    }
}

/// The force is a sawtooth, -1 - A s/2 at a phase s from 0 to 2. With r = 4/5 the ball is back after a period where s^2/2 - s + c = 0,
/// c = 16/9 (1/A + 1/2) - 2/A - 2/3: not below A = 1. The cycle has two events alone.
#[test]
fn a_branch_turns_back_where_an_impact_meets_the_jump_of_a_sawtooth() {
    let phases = |a: f64| {
        let c = 16.0 / 9.0 * (1.0 / a + 0.5) - 2.0 / a - 2.0 / 3.0;
        [-1.0, 1.0].map(|side| 1.0 + side * (1.0 - 2.0 * c).sqrt())
    };
    for (units, by) in UNITS.into_iter().zip(["contact", "event", "contact"]) {
        let start = 4.0 / 3.0;
        let force = "-1 - A*mod(TIME/2, 1)";
        let from = (phases(start)[0], 1.0 + 0.5 * start);
        let text = struck(force, (0.8, start), from, units, by);
        let branches = over(&with(&text, &[]), "A", (0.8, 1.6), (8, 0.02));
        assert_eq!(branches.len(), 1);
        turns_back(&branches[0], 1.0, 0.8, &|a| {
            (1.0 + 0.5 * a, phases(a).map(|s| -1.0 - 0.5 * a * s))
        });
    }
}

/// A kink of the force does not show in derivatives: nothing happens to an orbit that is struck as it comes.
#[test]
fn an_impact_passes_a_kink_of_the_force_unseen() {
    for units in UNITS {
        let force = "-1 + A*max(sin(pi*TIME), 0)";
        let (a, phase) = (1.3, 0.237_163_452_137_756_86);
        let mean = 1.0 - a / core::f64::consts::PI;
        let text = struck(force, (0.5, a), (phase, mean), units, "contact");
        let branches = over(&with(&text, &[]), "A", (1.1, 1.35), (8, 0.02));
        let [branch] = &branches[..] else {
            panic!("{}", branches.len());
        };
        assert_eq!(branch.ends, [End::Range, End::Range]);
        let [fold] = &branch.special[..] else {
            panic!("{:?}", branch.special);
        };
        assert_eq!(fold.kind, SpecialKind::Fold);
        // The corner is that of the phase 0: A = 0.4 pi, where the ball is struck by gravity alone.
        let late = |point: &&Point| (point.state[2] / units.0 / 2.0).rem_euclid(1.0) > 0.5;
        let beyond: Vec<_> = branch.points.iter().filter(late).collect();
        assert!(beyond.len() > 10);
        for point in beyond {
            let a = point.parameter();
            assert!(a > 0.4 * core::f64::consts::PI);
            let mean = 1.0 - a / core::f64::consts::PI;
            assert!(is_as_known(point, 0.5, (-1.0, mean)));
        }
    }
}
