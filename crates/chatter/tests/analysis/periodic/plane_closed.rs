//! Closed curves in two parameters.

use super::plane::curve;
use super::plane_listed::is_on;
use super::{nearest, over, value, with};
use chatter::analysis::periodic::{End, Point, SpecialKind};

/// At each tick u = x - 1 becomes u^3 - (a^2 + b^2) u: the orbit x = 1 doubles on the circle a^2 + b^2 = 1, whatever y does, which
/// passes a spring where b is greater than 0.29. The curve goes around once, from wherever on it it begins.
#[test]
fn a_closed_curve_ends_where_it_began() {
    let text = "[parameters]\na = 0.8\nb = 0.5\n[flight]\nx = '0'\ns = '1'\n\
                y = '-y + b + 6.4*cos(6.283185307179586*s) - if(y > 1.3, 2*(y - 1.3), 0)'\n\
                [[event]]\nname = 'tick'\nsurface = 's - 1'\ndirection = 'rising'\n\
                reset = { x = '1 - (a^2 + b^2)*(x - 1) + (x - 1)^3', s = '0' }\n[initial]\nx = 1.1\ns = 0\ny = 0\n";
    let (model, range) = (with(text, &[]), (-1.5, 1.5));
    let near = |at: f64| {
        let model = with(text, &[("a", &format!("{at}"))]);
        let found = over(&model, "a", (at - 0.1, at + 0.1), (10, 0.05));
        nearest(&found, &[SpecialKind::PeriodDoubling], at)
    };
    let doublings = [near(0.85), near(-0.85)];
    for special in &doublings {
        assert!((value(special).abs() - 0.75_f64.sqrt()).abs() < 1e-12);
        let found = curve(&model, ["a", "b"], special, (range, 0.04));
        assert_eq!(found.ends, [End::Closed, End::Closed]);
        let on = |point: &Point| point.parameters[0].hypot(point.parameters[1]);
        assert!(found.points.iter().all(|p| (on(p) - 1.0).abs() < 1e-9));
        let turned = found.points.windows(2).map(|pair| {
            let [p, q] = [&pair[0].parameters, &pair[1].parameters];
            (p[0] * q[1] - p[1] * q[0]).atan2(p[0] * q[0] + p[1] * q[1])
        });
        let turned: f64 = turned.sum();
        assert!(
            (turned.abs() - std::f64::consts::TAU).abs() < 1e-9,
            "{turned}"
        );
        for other in &doublings {
            assert!(is_on(
                &model,
                ["a", "b"],
                other,
                (range, found.kind, &found.points)
            ));
        }
    }
}
