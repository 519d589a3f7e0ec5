//! Branches of doubled orbits, from where they leave to where they end.

use crate::periodic::{branch_spec, value, with};
use chatter::analysis::periodic::{Beside, Branch, Spec, SpecialKind, branches};
use core::ops::ControlFlow;

/// The branch through the orbit at the model's value, and those that leave it at doublings, so often.
fn doubled(
    text: &str,
    settings: (&str, f64),
    range: (f64, f64),
    step: f64,
    depth: usize,
) -> Vec<Branch> {
    let (name, start) = settings;
    let model = with(text, &[(name, &start.to_string())]);
    let beside = Beside {
        doublings: depth,
        branch_points: 0,
    };
    let spec = branch_spec(&model, (name, range), (40, step), beside);
    branches(&model, &Spec::default(), &spec, Vec::new(), &mut |_| {
        ControlFlow::Continue(())
    })
    .unwrap()
}

/// A mass on a foundation whose stiffness swings (Mathieu's equation), and that does not pull: while it is not left the oscillator is linear, and all doubled orbits
/// that leave it have one value of the parameter, until they touch. Doublings by an integration (DOP853, tolerance 1e-13) of its own.
#[test]
fn doubled_orbits_of_a_linear_oscillator_are_a_family_at_one_value() {
    let text = "[parameters]\nw = 1.7\n[flight]\ny = \"v\"\nv = \"1 - 0.1*v - max((1 - 0.4*cos(w*t))*y, 0)\"\n\
        [section.strobe]\nsurface = \"sin(w*t)\"\ndirection = \"rising\"\n[initial]\ny = 1\nv = 0\n";
    for step in [0.03, 0.1] {
        let found = doubled(text, ("w", 1.7), (1.7, 2.3), step, 1);
        let [simple, below, above] = &found[..] else {
            panic!("{step}: {} branches", found.len());
        };
        let doublings: Vec<f64> = simple.special.iter().map(value).collect();
        for ((told, expected), branch) in { doublings.iter() }
            .zip([1.8201405529192, 2.1654112939173])
            .zip([below, above])
        {
            assert!((told - expected).abs() < 1e-12, "{step}: {told}");
            let kinds: Vec<_> = branch.special.iter().map(|s| s.kind).collect();
            assert_eq!(
                kinds,
                [SpecialKind::Touch, SpecialKind::BranchPoint],
                "{step}"
            );
            let all = branch.special.iter().map(value);
            let off = all.map(|at| (at - expected).abs()).fold(0.0, f64::max);
            assert!(off < 1e-12, "{step}: {off:e}");
            assert!(
                branch
                    .points
                    .iter()
                    .any(|point| (point.parameter() - expected).abs() > 0.1)
            );
        }
    }
}

/// A hardening spring that strikes a moving wall. Doubled orbits leave just before they graze: what the equations have beyond that is no motion,
/// and nothing that a branch may begin with. The multiplier by an integration (DOP853, tolerance 1e-12) of its own.
#[test]
fn doubled_orbits_begin_at_their_doubling_though_a_graze_is_near() {
    let text = "[parameters]\nomega = 0.41\n[flight]\nx = \"v\"\nv = \"1.2*cos(omega*t) - 0.1*v - x - 0.3*x^3\"\n\
        [[contact]]\nname = \"wall\"\ngap = \"1.5 + 0.2*sin(omega*t) - x\"\nimpulse = { v = -1 }\nrestitution = 0.65\n\
        [section.strobe]\nsurface = \"sin(omega*t)\"\ndirection = \"rising\"\n[initial]\nx = 0\nv = 0\n";
    for step in [0.003, 0.02, 0.05] {
        let found = doubled(text, ("omega", 0.41), (0.38, 0.43), step, 1);
        let [simple, doubled] = &found[..] else {
            panic!("{} branches", found.len());
        };
        let of = |branch: &Branch, kind: SpecialKind| {
            let all = branch.special.iter().filter(|s| s.kind == kind);
            all.map(value).collect::<Vec<f64>>()
        };
        let [left] = of(simple, SpecialKind::PeriodDoubling)[..] else {
            panic!("{step}");
        };
        let kinds: Vec<SpecialKind> = doubled.special.iter().map(|s| s.kind).collect();
        let expected = [
            SpecialKind::BranchPoint,
            SpecialKind::FlightGraze,
            SpecialKind::ImpactGraze,
        ];
        assert_eq!(kinds, expected, "{step}");
        let [met, grazes, _] = [0, 1, 2].map(|k| value(&doubled.special[k]));
        assert!((met - left).abs() < 1e-14, "{step} {met} {left}");
        let two = doubled
            .points
            .iter()
            .filter(|point| point.impacts == Some(2));
        for point in two {
            let ahead = point.parameter() - left;
            assert!(ahead > 0.0 && point.parameter() <= grazes, "{step}");
            // 1.01114 at 0.407555, 1.019985 at 0.407560862, and 1 at the doubling.
            let near = ahead / (0.407_555 - left);
            if near < 2.0 {
                let expected = 1.0 + near * (0.011_14 + (near - 1.0) * 0.000_25);
                let known = point.multipliers[0].re;
                assert!((known - expected).abs() < 2e-4, "{step} {known} {expected}");
            }
        }
    }
}

/// A ball between two membranes. Doubled orbits of 26 impacts are doubled themselves 1e-8 before they end at the simple ones: beyond their end they come
/// back as they went, so that as many multipliers are beyond -1 as before. By Newton's method on the closed form of the flights, in forty digits.
#[test]
fn a_doubling_just_before_a_branch_of_doubled_orbits_ends_is_told() {
    let text = "[parameters]\nomega = 2.495\n[flight]\nz = \"w\"\nw = \"-0.4 + cos(omega*t)\"\n[[contact]]\nname = \"bottom\"\n\
        gap = \"z + 0.3\"\nimpulse = { w = 1 }\nrestitution = 0.5\n[[contact]]\nname = \"top\"\ngap = \"0.3 - z\"\n\
        impulse = { w = -1 }\nrestitution = 0.5\n[section.strobe]\nsurface = \"sin(omega*t)\"\ndirection = \"rising\"\n\
        [initial]\nz = 0\nw = 0.3\n";
    let found = doubled(text, ("omega", 2.495), (2.45, 2.5), 0.1, 2);
    let all = found.iter().flat_map(|branch| &branch.special);
    let there =
        all.filter(|s| s.kind == SpecialKind::PeriodDoubling && s.point.impacts == Some(26));
    let [special] = there.collect::<Vec<_>>()[..] else {
        panic!("not one doubling");
    };
    let off = (value(special) - 2.479_406_512_161_433_7).abs();
    assert!(off <= special.error && special.error < 1e-14, "{special:?}");
}
