//! Surfaces that come into use, and crossings that come and go.

use super::{model, orbit, over, value, with};
use chatter::analysis::periodic::{End, SpecialKind};
use chatter::analysis::simulate::{Spec, simulate};
use chatter::flow::Occurrence;
use std::ops::ControlFlow;

/// Beyond a wall friction is dry: only there it matters which way the mass moves.
const FRICTION_BEYOND: &str = r#"
[parameters]
a = 3
[flight]
x = "v"
v = "a*cos(t) - 0.2*v - x - if(x > 0.4, 5*(x - 0.4) + 0.2*sign(v), 0)"
[initial]
x = 0
v = 0
"#;

/// The rate has changed its sign since it mattered last: that was no crossing, and is none where it matters again.
#[test]
fn a_surface_that_comes_into_use_is_not_crossed() {
    let model = with(FRICTION_BEYOND, &[]);
    let spec = Spec::until(60.0);
    let run = simulate::<f64>(&model, &spec, &mut |_| ControlFlow::Continue(())).unwrap();
    let switches = run.events.iter().filter_map(|event| match event.detail {
        Occurrence::Switch { surface, side } => Some((surface, side)),
        _ => None,
    });
    let switches: Vec<_> = switches.collect();
    assert!(switches.len() > 20);
    // Into the wall, back by the rate, and out of it.
    for visit in switches.chunks_exact(3) {
        assert_ne!(visit[0].0, visit[1].0);
        assert_eq!(visit[0].0, visit[2].0);
        assert_ne!(visit[0].1, visit[2].1);
    }
}

#[test]
fn an_orbit_takes_surfaces_into_use() {
    let found = orbit(&with(FRICTION_BEYOND, &[]));
    assert_eq!(found.impacts, Some(0));
    assert!(found.residual < 1e-25, "{found:?}");
    assert!(found.is_stable());
}

/// The soft stop is touched from both sides: where all that happens is a crossing and the way back, too.
#[test]
fn the_only_crossing_may_come_and_go() {
    for start in ["0.05", "0.3"] {
        let model = model("soft_stop", &[("load", start)]);
        let found = over(&model, "load", (0.02, 0.4), (40, 0.02));
        assert_eq!(found[0].ends, [End::Range, End::Range], "from {start}");
        let kinds: Vec<SpecialKind> = found[0].special.iter().map(|s| s.kind).collect();
        let expected = [SpecialKind::Touch, SpecialKind::Fold, SpecialKind::Fold];
        assert_eq!(kinds, expected, "from {start}");
        assert!((value(&found[0].special[0]) - 0.228_035_085_019_827).abs() < 1e-13);
    }
}
