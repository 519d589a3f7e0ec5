//! Orbits with many impacts next to a chatter border, and those borders.

use crate::periodic::{over, value, with};
use chatter::analysis::periodic::{End, Special, SpecialKind};
use chatter::model::Model;

/// A ball on a shaken table, whose flights next to its border are hardly higher than rounding of where it is. The product of both multipliers is 0.3^2 for
/// each impact; in doubles it came out as 3000 times that, and -1 as -1.0001.
#[test]
fn multipliers_are_known_though_flights_are_hardly_higher_than_rounding() {
    let text = "[parameters]\nA = 1.94694\n[flight]\nx = \"v\"\nv = \"-1\"\n[[contact]]\nname = \"table\"\n\
        gap = \"x - A*cos(t)\"\nimpulse = { v = 1 }\nrestitution = 0.3\n[section.s]\nsurface = \"sin(t)\"\n\
        direction = \"rising\"\n[initial]\nx = 1.98\nv = 0\n";
    let found = over(&with(text, &[]), "A", (1.94, 1.95), (80, 0.1));
    let told = found.iter().flat_map(|branch| &branch.special);
    let mut doublings = told.filter(|special| special.kind == SpecialKind::PeriodDoubling);
    let doubling = doublings.find(|special| special.point.impacts == Some(23));
    let doubling = doubling.expect("a doubling of orbits with 23 impacts");
    let [through, other] = doubling.point.multipliers[..] else {
        panic!("{:?}", doubling.point.multipliers);
    };
    assert!((through.re + 1.0).abs() < 1e-6, "{through:?}");
    let product = 0.09_f64.powi(23);
    assert!((other.re / product + 1.0).abs() < 1e-3, "{other:?}");
}

/// A hammer whose guide rubs falls with less acceleration than it rises. Its chatter is complete until nothing is left of that acceleration where it ends: beyond,
/// friction holds the hammer in the air, after as many impacts as have come before. The border and the grazes of its arcs are those of closed flights
/// with 40 digits.
#[test]
fn chatter_ends_where_friction_holds_what_is_left_of_it_in_the_air() {
    let text = "[parameters]\nP = 0.25\nA = 1\n[flight]\ny = \"v\"\nv = \"A*cos(t) - P - 0.5*y - 0.15*sign(v)\"\n[[contact]]\nname = \"anvil\"\n\
        gap = \"y\"\nimpulse = { v = 1 }\nrestitution = 0.6\n[section.s]\nsurface = \"sin(t)\"\ndirection = \"rising\"\n\
        [initial]\ny = 0.2\nv = 0\n";
    // What lies beyond has more impacts than are followed.
    let found = over(&with(text, &[("A", "0.6")]), "A", (0.6, 0.6721), (4, 0.2));
    let [complete] = &found[..] else {
        panic!("{} branches", found.len());
    };
    assert_eq!(complete.ends, [End::Range, End::ChatterBorder]);
    let [border] = &complete.special[..] else {
        panic!("{:?}", complete.special);
    };
    let off = (value(border) - 0.671_989_908_254_029_3).abs();
    assert!(off <= border.error && border.error < 1e-8, "{border:?}");
    // Orbits of many impacts come to where these accumulate, and end as flights beyond take no time.
    let model = with(text, &[("P", "0.4475")]);
    let found = over(&model, "P", (0.4474, 0.447_658_328), (80, 0.2));
    let arcs = &found[0];
    assert!(
        matches!(arcs.ends, [End::Range, End::Rounding(12..) | End::Range]),
        "{:?}",
        arcs.ends
    );
    let is_it = |s: &&Special| s.kind.is_graze() && s.point.impacts == Some(9);
    let graze = arcs.special.iter().find(is_it);
    let graze = graze.expect("a graze of orbits with nine impacts");
    assert!((value(graze) - 0.447_652_766_278_69).abs() < 1e-13);
    assert_eq!(graze.persists, Some(true));
}

/// A block slides on a seesaw with dry friction. Its chatter at an end ends where friction begins to hold in the air what is left of it: orbits with fewer impacts
/// come up to there, as far as flights are told from rounding, and lead to those beyond.
#[test]
#[ignore = "takes ten seconds"]
fn orbits_that_friction_holds_in_the_air_lead_to_chatter() {
    let text = "[parameters]\nw = 0.938\n[definitions]\nth = \"0.5*sin(w*t)\"\n[flight]\nx = \"u\"\n\
        u = \"-sin(th) + x*(0.5*w*cos(w*t))^2 - 0.2*cos(th)*sign(u)\"\n[[contact]]\nname = \"right\"\ngap = \"1.5 - x\"\n\
        impulse = { u = -1 }\nrestitution = 0.4\n[[contact]]\nname = \"left\"\ngap = \"1.5 + x\"\nimpulse = { u = 1 }\n\
        restitution = 0.4\n[initial]\nx = 0\nu = 0\n";
    let found = over(&with(text, &[]), "w", (0.938, 0.945), (12, 0.01));
    let [arcs, complete] = &found[..] else {
        panic!("{} branches", found.len());
    };
    assert!(
        matches!(arcs.ends, [End::Range, End::Rounding(5..)]),
        "{:?}",
        arcs.ends
    );
    assert_eq!(complete.ends, [End::ChatterBorder, End::Range]);
    let border = &complete.special[0];
    assert_eq!(border.kind, SpecialKind::ChatterBorder);
    assert!(border.error < 1e-8, "{border:?}");
    let impacts = arcs.special.iter().map(|s| s.point.impacts.unwrap());
    assert_eq!(impacts.max(), Some(6));
    assert!(arcs.special.iter().all(|s| value(s) < value(border)));
}

/// A ball on a table that two harmonics shake: with this size and phase of the second, this restitution, and so much of both.
fn on_a_table((size, phase): (&str, &str), restitution: &str, shaken: &str) -> Model {
    let text = format!(
        "[parameters]\nG = 1\n[flight]\ny = \"v\"\nv = \"-1\"\n[[contact]]\nname = \"table\"\n\
        gap = \"y - G*(sin(t) + {size}*sin(2*t + {phase}))\"\nimpulse = {{ v = 1 }}\nrestitution = {restitution}\n\
        [section.s]\nsurface = \"sin(t)\"\ndirection = \"rising\"\n[initial]\ny = 6\nv = 0\n"
    );
    with(&text, &[("G", shaken)])
}

/// A ball on a table that two harmonics shake. Right beyond its border equations still have a solution by rounding, of chatter that comes to no rest: it is
/// the border all the same. Its value is that of other ranges, which come to it from before.
#[test]
fn a_border_is_told_though_rounding_has_gone_past_it() {
    let model = on_a_table(("0.1578", "2.2539"), "0.5537", "1.05");
    let found = over(&model, "G", (1.05, 1.65), (1, 0.065_833_3));
    assert_eq!(found[0].ends, [End::Range, End::ChatterBorder]);
    let border = found[0].special.last().unwrap();
    let off = (value(border) - 1.582_515_990_762_015).abs();
    assert!(off < 1e-14 && border.error < 1e-14, "{border:?}");
}

/// A ball with little restitution on a table that two harmonics shake. After its impacts with next to no rate entries of the matrix are so large that in doubles its
/// eigenvalues were a complex pair, of any size: their product is r^2 for each impact. The doubling is that of flights with 50 digits.
#[test]
fn multipliers_are_known_where_entries_of_the_matrix_are_far_larger() {
    let model = on_a_table(("0.3505", "0.281"), "0.1184", "1.557");
    let found = over(&model, "G", (1.05, 2.0), (7, 0.01));
    let points = found.iter().flat_map(|branch| &branch.points);
    let mut counted = 0;
    for point in points.filter(|point| point.parameter() < 1.6) {
        let (Some(impacts), [one, other]) = (point.impacts, &point.multipliers[..]) else {
            continue;
        };
        if impacts < 7 {
            continue;
        }
        assert!(one.im == 0.0 && other.im == 0.0, "{one:?} {other:?}");
        let product = 0.1184_f64.powi(14);
        let off = one.re * other.re / product - 1.0;
        assert!(off.abs() < 1e-2, "{} {impacts} {off:e}", point.parameter());
        counted += 1;
    }
    assert!(counted > 2, "{counted}");
    let told = found.iter().flat_map(|branch| &branch.special);
    let mut doublings =
        told.filter(|s| s.kind == SpecialKind::PeriodDoubling && s.point.impacts == Some(7));
    let doubling = doublings.next().unwrap();
    assert!((value(doubling) - 1.557_317_490_717_893_3).abs() < 1e-14);
}

/// With so little restitution arcs are as low as rounding while they are still as far from the border as their last graze is: they are its arcs all the same, by what
/// their grazes tend to.
#[test]
fn arcs_that_end_in_rounding_far_from_a_border_are_followed_beyond_it() {
    let model = on_a_table(("0.3505", "0.281"), "0.1184", "1.557");
    let found = over(&model, "G", (1.55, 1.57), (9, 0.1));
    let [complete, arcs] = &found[..] else {
        panic!("{} branches", found.len());
    };
    assert_eq!(complete.ends, [End::Range, End::ChatterBorder]);
    assert!(
        matches!(arcs.ends, [End::Rounding(7..), End::Range]),
        "{:?}",
        arcs.ends
    );
}

/// A ball on a table whose chatter is complete in a window of 7e-9 alone, once in eight periods. At its edge rounding says where the parameter of the latest
/// steps goes: the branch went back along itself. The edge is that of a simulation in forty digits.
#[test]
fn a_branch_does_not_turn_back_at_a_border_by_rounding() {
    let text = "[parameters]\nG = 1.5032999995\nr = 0.8095\nh = 0\nf = 2.7335\n[flight]\ny = \"v\"\nv = \"-1\"\n[[contact]]\nname = \"table\"\n\
        gap = \"y - G*(sin(t) + h*sin(2*t + f))\"\nimpulse = { v = 1 }\nrestitution = \"r\"\n[section.s]\nsurface = \"sin(t)\"\n\
        direction = \"rising\"\n[initial]\ny = 6\nv = 0\n";
    let found = over(&with(text, &[]), "G", (1.4, 1.5033), (4, 0.1));
    let [branch] = &found[..] else {
        panic!("{} branches", found.len());
    };
    assert_eq!(branch.ends, [End::ChatterBorder, End::Range]);
    let [border] = &branch.special[..] else {
        panic!("{:?}", branch.special);
    };
    let off = (value(border) - 1.503_299_998_269_26).abs();
    assert!(off < 1e-13 && off <= border.error, "{border:?}");
}
