//! What strikes a body that friction holds, ever more weakly.

use crate::periodic::{over, value, with};
use chatter::analysis::periodic::{End, SpecialKind};

/// An oscillator strikes a body that slips a little and comes back as far. As its impact loses its rate both slips come to nothing, and the body sticks
/// where friction just holds it, at f / k: there the oscillator's amplitude is that and the gap. Without the impact the body may be held anywhere.
#[test]
fn a_struck_body_is_held_in_many_places() {
    for (gap, friction, low) in [
        (0.4_f64, 0.15_f64, 1.7),
        (0.4, 0.3, 1.68),
        (0.5, 0.15, 1.65),
    ] {
        let text = format!(
            "[parameters]\nom = 1.8\n[flight]\nx = \"v\"\nv = \"cos(om*t) - 0.1*v - x\"\ny = \"u\"\nu = \"(-3*y - {friction}*sign(u))/2\"\n\
            [[contact]]\nname = \"pair\"\ngap = \"{gap} + y - x\"\nimpulse = {{ v = -1, u = 0.5 }}\nrestitution = 0.5\n\
            [section.s]\nsurface = \"sin(om*t)\"\ndirection = \"rising\"\n[initial]\nx = 0\nv = 0\ny = 0\nu = 0\n"
        );
        // (1 - om^2)^2 + (om/10)^2 is one over the square of the amplitude.
        let amplitude = gap + friction / 3.0;
        let half = 0.5 * (2.0 - 0.01);
        let exact = (half + (half * half - 1.0 + amplitude.powi(-2)).sqrt()).sqrt();
        for (start, step) in [("1.75", 0.05), ("1.8", 0.2)] {
            let found = over(&with(&text, &[("om", start)]), "om", (low, 2.0), (4, step));
            assert_eq!(found.len(), 1, "{gap} {friction} from {start}");
            let branch = &found[0];
            let ends = branch.ends.iter().filter(|end| {
                matches!(end, End::Lost(why) if why.starts_with("an impact at `pair` has no rate any more"))
            });
            assert_eq!(
                ends.count(),
                1,
                "{gap} {friction} from {start}: {:?}",
                branch.ends
            );
            let graze = branch
                .special
                .iter()
                .find(|special| special.kind.is_graze());
            let graze = graze.unwrap();
            assert_eq!(graze.kind, SpecialKind::ImpactGraze);
            assert!((value(graze) - exact).abs() <= graze.error, "{graze:?}");
            assert!(graze.error < 1e-14, "{graze:?}");
        }
    }
}

/// A hammer that strikes a bit held by dry friction, in a medium that gives way as the bit slips: it goes ahead in each period.
const DRILL: &str = r#"
[parameters]
omega = 1.75
[definitions]
d = "x - p"
[flight]
x = "v"
v = "0.3 + 1.2*cos(omega*t) - 0.2*(v - q) - 0.6*d"
p = "q"
q = "-sign(q)"
[[contact]]
name = "anvil"
gap = "0.3 - d"
impulse = { v = -1, q = 2 }
restitution = 0.55
[section.strobe]
surface = "sin(omega*t)"
direction = "rising"
[initial]
x = 0.0207
v = 0.566
p = 0
q = 0
"#;

/// Where friction holds what is struck with some to spare, an impact without rate begins one slip, which takes as little time as that has rate: both
/// come in at once, and the branch goes on from either side. The least gap of the orbits with two impacts, by an integration of their own from event
/// to event, vanishes at 1.78537930711 (from seven values, to 4e-12).
#[test]
fn a_slip_comes_in_with_a_weak_impact_on_what_friction_holds() {
    let parts = |start: &str, step: f64| {
        let model = with(DRILL, &[("omega", start)]);
        let found = over(&model, "omega", (1.6, 1.86), (8, step));
        let branch = found.into_iter().next().expect("a branch");
        assert_eq!(branch.ends, [End::Range, End::Range], "{start} {step}");
        let grazes = branch.special.iter().filter(|s| s.kind.is_graze());
        let told: Vec<(f64, Option<bool>)> = grazes.map(|s| (value(s), s.persists)).collect();
        let [(at, Some(true))] = told[..] else {
            panic!("{start} {step} {told:?}");
        };
        assert!((at - 1.785_379_307_11).abs() < 1e-11, "{start} {step} {at}");
        for point in &branch.points {
            let impacts = if point.parameter() < at { 3 } else { 2 };
            assert_eq!(point.impacts, Some(impacts), "{start} {step}");
        }
    };
    for (start, step) in [("1.84", 0.1), ("1.84", 0.03), ("1.61", 0.05)] {
        parts(start, step);
    }
}

/// A bit that a swinging thrust drives against a slider held by dry friction: struck, the slider slips, and the thrust drives the bit after it.
const FOLLOWED: &str = r#"
[parameters]
thrust = 0.0725
[flight]
x = "v"
v = "thrust + 0.4872*cos(1.3344*t) - 0.13*v"
p = "q"
q = "-sign(q)/1.3547"
[[contact]]
name = "bit"
gap = "p - x + 0.1426"
impulse = { v = -1, q = "1/1.3547" }
restitution = 0.4708
[section.strobe]
surface = "sin(1.3344*t)"
direction = "rising"
[initial]
x = -0.7317
v = 0.02774
p = 0
q = 0
"#;

/// The slip is over before the bit, which is driven back as soon as it is parted, has come as far: the branch goes on with both. The least gap of the orbits
/// with five impacts, by closed forms of flight and slip in a program of their own, vanishes at 0.0726790019063 (from five values, to 4e-12).
#[test]
fn a_slip_comes_in_though_what_strikes_is_driven_back() {
    for (start, step) in [
        ("0.0725", 0.1),
        ("0.07265", 0.1),
        ("0.0727", 0.03),
        ("0.07279", 0.1),
    ] {
        let model = with(FOLLOWED, &[("thrust", start)]);
        let found = over(&model, "thrust", (0.0724, 0.0731), (8, step));
        let branch = found.into_iter().next().expect("a branch");
        assert_eq!(branch.ends, [End::Range, End::Range], "{start} {step}");
        let grazes = branch.special.iter().filter(|s| s.kind.is_graze());
        let [graze] = grazes.collect::<Vec<_>>()[..] else {
            panic!("{start} {step} {:?}", branch.special);
        };
        assert_eq!(
            (graze.kind, graze.persists),
            (SpecialKind::FlightGraze, Some(true))
        );
        assert!(
            (value(graze) - 0.072_679_001_906).abs() < 1e-12,
            "{start} {step}"
        );
        assert!(graze.error < 1e-15, "{start} {step} {graze:?}");
        for point in &branch.points {
            let impacts = if point.parameter() < value(graze) {
                5
            } else {
                6
            };
            assert_eq!(point.impacts, Some(impacts), "{start} {step}");
        }
    }
}
