//! What stays on the unit circle passes it nowhere.

use super::{over, with};
use chatter::analysis::periodic::Point;

/// An oscillator without damping: its multipliers are exp(+-2 pi i/omega).
const FREE: &str = r#"
[parameters]
omega = 2.5
[flight]
x = "v"
v = "-x + cos(omega*t)"
[section.strobe]
surface = "sin(omega*t)"
direction = "rising"
[initial]
x = -0.1904761904761905
v = 0
"#;

#[test]
fn a_pair_that_stays_on_the_unit_circle_does_not_pass_it() {
    let found = over(&with(FREE, &[]), "omega", (2.2, 3.0), (10, 0.02));
    let [branch] = &*found else {
        panic!("{} branches", found.len());
    };
    assert!(branch.special.is_empty(), "{:?}", branch.special[0]);
    assert!(branch.points.len() > 30);
    assert!(branch.points.iter().all(Point::is_neutral));
    assert!(!branch.points.iter().any(Point::is_stable));
}
