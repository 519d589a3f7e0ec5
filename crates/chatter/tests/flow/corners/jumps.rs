//! Impacts take the state across corners: what then holds is what holds on the other side.

use super::run;
use chatter::analysis::simulate::{Event, Outcome};
use chatter::flow::Occurrence;
use chatter::numerics::{DoubleDouble, Real};

/// v' = -1 - a sqrt(|v| + c) sign(v): the expression of each side has no value on the other one. With s = sqrt(v + c) a rise
/// from v to rest takes the integral of 2 s/(1 + a s).
#[test]
fn a_root_has_a_value_on_its_own_side_only() {
    fn check<R: Real>(a: f64, c: f64, tolerance: f64) {
        let text = format!(
            r#"
            [flight]
            x = "v"
            v = "-1 - {a}*sqrt(abs(v) + {c})*sign(v)"
            [[contact]]
            name = "ground"
            gap = "x"
            impulse = {{ v = 1 }}
            restitution = 0.85
            [initial]
            x = 1
            v = 0
            "#
        );
        let run = run::<R>(&text, 6.0);
        assert_eq!(run.outcome, Outcome::Horizon);
        let rise = |v: f64| {
            let part = |s: f64| 2.0 / a * s - 2.0 / (a * a) * (a * s).ln_1p();
            part((v + c).sqrt()) - part(c.sqrt())
        };
        let mut rises = 0;
        for pair in run.events.windows(3) {
            let [impact, upwards, top] = pair else {
                continue;
            };
            let Occurrence::Impact { rate_after, .. } = impact.detail else {
                continue;
            };
            assert!(matches!(upwards.detail, Occurrence::Switch { .. }));
            if matches!(top.detail, Occurrence::Switch { .. }) {
                let took = (top.time - impact.time).to_f64();
                assert!((took - rise(rate_after.to_f64())).abs() < tolerance);
                rises += 1;
            }
        }
        assert!(rises > 2, "{rises}");
    }
    for (a, c) in [(0.36, 0.01), (1.3, 0.002), (0.1, 0.4)] {
        check::<f64>(a, c, 1e-13);
        check::<DoubleDouble>(a, c, 1e-14);
    }
}

/// Collisions of one instant: each has the restitution of the rate that it begins with.
#[test]
fn a_restitution_follows_the_rate_through_a_cascade() {
    for (fast, slow, between) in [(0.2, 0.8, 0.5), (0.7, 0.1, 0.5), (0.3, 0.9, 0.8)] {
        let text = format!(
            r#"
            [flight]
            x = "v"
            v = "0"
            u = "w"
            w = "0"
            [[contact]]
            name = "wall"
            gap = "x"
            impulse = {{ v = 1 }}
            restitution = "if(v < -1, {fast}, {slow})"
            [[contact]]
            name = "pair"
            gap = "u - x"
            impulse = {{ w = 1, v = -1 }}
            restitution = {between}
            [initial]
            x = 1
            v = -2
            u = 1
            w = -2
            "#
        );
        let run = run::<f64>(&text, 1.5);
        let (mut v, mut w) = (-2.0_f64, -2.0_f64);
        let mut expected = Vec::new();
        while v < -1e-12 || w - v < -1e-12 {
            if v < w - v {
                expected.push(("wall", v));
                v *= if v < -1.0 { -fast } else { -slow };
            } else {
                expected.push(("pair", w - v));
                let (mean, half) = (0.5 * (v + w), -0.5 * between * (w - v));
                (v, w) = (mean - half, mean + half);
            }
        }
        let impacts: Vec<&Event<f64>> = (run.events.iter())
            .filter(|event| matches!(event.detail, Occurrence::Impact { .. }))
            .collect();
        assert_eq!(impacts.len(), expected.len());
        for (impact, (_, rate)) in impacts.iter().zip(&expected) {
            let Occurrence::Impact { rate_before, .. } = impact.detail else {
                continue;
            };
            assert!((rate_before - rate).abs() < 1e-14);
        }
        assert!((run.state[1] - v).abs() < 1e-14 && (run.state[3] - w).abs() < 1e-14);
    }
}

/// A mass with dry friction and another one that rests on it: the force on both never overcomes friction after they have come
/// to rest, so neither opens, though constants such as 0.73*0.3 are rounded.
#[test]
fn friction_holds_what_rests_on_it() {
    let text = r#"
        [flight]
        x = "v"
        v = "-0.65 - 0.71*x - 0.62*sign(v) - 0.87*abs(x - 0.76) + 1.41*cos(0.61*t)"
        u = "w"
        w = "-1.14 - 0.56*u + 0.73*abs(u - 0.3) + 0.56*cos(1.69*t) - 0.32*(u - x)"
        [[contact]]
        name = "ground"
        gap = "x"
        impulse = { v = 1 }
        restitution = 0.3
        [[contact]]
        name = "pair"
        gap = "u - x"
        impulse = { w = 1, v = -1 }
        restitution = 0
        [initial]
        x = 0.32
        v = 0.32
        u = 1.75
        w = -0.7
    "#;
    fn check<R: Real>(text: &str) {
        let run = run::<R>(text, 25.0);
        assert_eq!(run.outcome, Outcome::Horizon);
        assert_eq!(run.counts.releases, 0);
        assert!(run.state[..4].iter().all(|x| x.to_f64().abs() < 1e-14));
    }
    check::<f64>(text);
    check::<DoubleDouble>(text);
}

/// Two masses on each other with dry friction each, at rest: the upper one lifts off once the force on it is larger than its
/// friction, both once all forces are larger than all friction, in whatever order the contacts are written.
#[test]
fn what_rests_opens_once_friction_is_overcome() {
    let ground =
        "[[contact]]\nname = \"ground\"\ngap = \"x\"\nimpulse = { v = 1 }\nrestitution = 0.3\n";
    let pair = "[[contact]]\nname = \"pair\"\ngap = \"u - x\"\nimpulse = { w = 1, v = -1 }\nrestitution = 0\n";
    let mut opened = [0; 2];
    for (f, g) in [(0.62, 0.3), (0.1, 1.2), (0.5, 0.5)] {
        for (rise, other_rise) in [(0.3, 0.1), (0.1, 0.4), (0.7, 0.6), (0.02, 0.5)] {
            for (weight, other_weight) in [(0.4, 0.9), (1.3, 0.2)] {
                for contacts in [[ground, pair], [pair, ground]] {
                    let text = format!(
                        r#"
                        [flight]
                        x = "v"
                        v = "{rise}*t - {weight} - {f}*sign(v)"
                        u = "w"
                        w = "{other_rise}*t - {other_weight} - {g}*sign(w)"
                        {}{}[initial]
                        x = 0
                        v = 0
                        u = 0
                        w = 0
                        "#,
                        contacts[0], contacts[1]
                    );
                    let upper = (g + other_weight) / other_rise;
                    let both = (f + g + weight + other_weight) / (rise + other_rise);
                    let (name, time) = if upper < both {
                        ("pair", upper)
                    } else {
                        ("ground", both)
                    };
                    let index = contacts.iter().position(|text| text.contains(name));
                    let run = run::<f64>(&text, time + 0.1);
                    let first = (run.events.iter())
                        .find(|event| matches!(event.detail, Occurrence::Release { .. }))
                        .unwrap_or_else(|| panic!("{text}"));
                    assert_eq!(first.detail.place().map(|place| place.index()), index);
                    assert!((first.time - time).abs() < 1e-13 * time, "{text}");
                    opened[usize::from(name == "pair")] += 1;
                }
            }
        }
    }
    assert!(opened.iter().all(|&count| count > 4), "{opened:?}");
}

/// A plastic stack that falls with dry friction: it comes to rest whatever the forces are that friction balances.
#[test]
fn stacks_held_by_friction_come_to_rest() {
    for lower in [-0.3, 0.05, 0.218] {
        for upper in [-0.898, -0.2, 0.3] {
            for restitution in [0.0, 0.5] {
                let text = format!(
                    r#"
                    [flight]
                    x = "v"
                    v = "if(t < 3, -1, {lower}) - 0.12*sign(v)"
                    u = "w"
                    w = "if(t < 3, -2, {upper}) - 1.23*sign(w)"
                    [[contact]]
                    name = "ground"
                    gap = "x"
                    impulse = {{ v = 1 }}
                    restitution = {restitution}
                    [[contact]]
                    name = "pair"
                    gap = "u - x"
                    impulse = {{ w = 1, v = -1 }}
                    restitution = 0
                    [initial]
                    x = 0.4
                    v = 0
                    u = 1
                    w = 0
                    "#
                );
                let run = run::<f64>(&text, 5.0);
                assert_eq!(run.outcome, Outcome::Horizon, "{text}");
                assert!(run.state[..4].iter().all(|x| x.abs() < 1e-13), "{text}");
            }
        }
    }
}

/// x' = v, v' = -k|x| + a cos(omega t + phi), plastic at x = 0, which is the corner of |x|, too: it leaves both where the
/// cosine begins to push.
#[test]
fn a_contact_opens_where_its_gap_is_a_corner() {
    fn check<R: Real>() {
        let text = "[flight]\nx = \"v\"\nv = \"-0.659*abs(x) - 0.057*v + 1.588*cos(1.973*t + 3.947)\"\n\
            [[contact]]\ngap = \"x\"\nimpulse = { v = 1 }\nrestitution = 0\n[initial]\nx = 1.456\nv = -0.437\n";
        let run = run::<R>(text, 12.0);
        assert_eq!(run.outcome, Outcome::Horizon);
        let release = (run.events.iter())
            .find(|event| matches!(event.detail, Occurrence::Release { .. }))
            .expect("it is pushed off");
        let expected = (3.5 * std::f64::consts::PI - 3.947) / 1.973;
        assert!((release.time.to_f64() - expected).abs() < 1e-14);
        assert!(run.state[0].to_f64() > 0.1);
    }
    check::<f64>();
    check::<DoubleDouble>();
}

/// A mass that has come to rest at a stop where nothing pushes it stays there, whatever resists its motion, and whatever else
/// happens elsewhere.
#[test]
fn what_nothing_pushes_stays_at_rest() {
    for resistance in [
        "0.115*v*abs(v)",
        "0.3*sign(v)",
        "2*clamp(x, -0.6, 0.9) + 0.1*v",
    ] {
        let text = format!(
            "[flight]\nx = \"v\"\nv = \"-({resistance})\"\ny = \"w\"\nw = \"-1 + 0.333*cos(2.954*t)\"\n\
            [[contact]]\nname = \"wall\"\ngap = \"x\"\nimpulse = {{ v = 1 }}\nrestitution = 0\n\
            [[contact]]\nname = \"ground\"\ngap = \"y\"\nimpulse = {{ w = 1 }}\nrestitution = 0.5\n\
            [initial]\nx = 0.36\nv = -1\ny = 2.289\nw = -0.593\n"
        );
        let run = run::<f64>(&text, 20.0);
        assert_eq!(run.outcome, Outcome::Horizon, "{text}");
        assert_eq!(run.counts.accumulations, 1, "the other one comes to rest");
        assert_eq!(&run.state[..2], [0.0, 0.0]);
    }
}

/// A mass that rests on the ground and rubs on another one, which bounces beside it: what an impact of that one turns round
/// lifts it off at once, with an acceleration.
#[test]
fn an_impact_elsewhere_may_open_a_contact() {
    let text = "[flight]\nx = \"v\"\nv = \"-1\"\ny = \"w\"\nw = \"-0.3 - 0.5*sign(w - v)\"\n\
        [[contact]]\nname = \"floor\"\ngap = \"x\"\nimpulse = { v = 1 }\nrestitution = 0.5\n\
        [[contact]]\nname = \"ground\"\ngap = \"y\"\nimpulse = { w = 1 }\nrestitution = 0\n\
        [initial]\nx = 2\nv = 0\ny = 0\nw = 0\n";
    let run = run::<f64>(text, 2.5);
    assert_eq!(run.outcome, Outcome::Horizon);
    let release = (run.events.iter())
        .find(|event| matches!(event.detail, Occurrence::Release { .. }))
        .expect("friction lifts it");
    assert!((release.time - 2.0).abs() < 1e-15);
    // From then on w rises by 0.2 a unit of time, v falls from 1 by one: they are alike after 1/1.2, later than this.
    assert!((run.state[2] - 0.1 * 0.25).abs() < 1e-15, "{:?}", run.state);
    assert!((run.state[3] - 0.1).abs() < 1e-15);
}

/// A ball hits a block that dry friction holds: momentum is kept, the rates part by r, and the block slides q^2/(2 mu).
#[test]
fn an_impact_takes_a_state_off_the_surface_that_it_slides_along() {
    let text = r#"
        [parameters]
        mu = 0.6
        r = 0.7
        [flight]
        x = "v"
        v = "0"
        p = "q"
        q = "-mu*sign(q)"
        [[contact]]
        name = "block"
        gap = "p - x"
        impulse = { v = -1, q = 1 }
        restitution = "r"
        [initial]
        x = -1
        v = 1
        p = 0
        q = 0
        "#;
    let run = run::<f64>(text, 3.0);
    let first = &run.events[0];
    assert!(matches!(first.detail, Occurrence::Impact { .. }));
    assert!((first.time - 1.0).abs() < 1e-15);
    assert!((first.state[1] - 0.15).abs() < 1e-15 && (first.state[3] - 0.85).abs() < 1e-15);
    // It comes to rest before the ball meets it again.
    let rest = 0.85 * 0.85 / 1.2;
    let slid = (run.events.iter()).find(|event| matches!(event.detail, Occurrence::Slide { .. }));
    let slid = slid.expect("the block stops");
    assert!((slid.time - (1.0 + 0.85 / 0.6)).abs() < 1e-14);
    assert!((slid.state[2] - rest).abs() < 1e-15);
    assert_eq!(run.counts.accumulations, 0);
}

/// A spring and damper that do not pull: their force jumps to c v where they are touched, and is cut off where it has sunk to zero,
/// however that is written.
#[test]
fn a_force_that_is_cut_off_at_zero_may_begin_with_a_jump() {
    let motion = |force: &str| {
        let text = format!(
            "[flight]\nx = \"v\"\nv = \"-x - 0.05*v + cos(1.7*t) - ({force})\"\n[initial]\nx = 0\nv = 0\n"
        );
        run::<f64>(&text, 20.0)
    };
    let inside = "5e4*(x - 0.3) + 30*v";
    let plain = motion(&format!("if(x > 0.3 and {inside} > 0, {inside}, 0)"));
    // Calculated with 34 digits by extrapolation.
    let expected = [-2.438_081_578_360_15, -1.104_407_246_577_52];
    for (x, expected) in plain.state.iter().zip(expected) {
        assert!((x - expected).abs() < 1e-12, "{x} {expected}");
    }
    for force in [
        format!("max(0, if(x > 0.3, {inside}, 0))"),
        format!("-min(0, -if(x > 0.3, {inside}, 0))"),
        format!("max(step(x - 0.3)*({inside}), 0)"),
        format!("clamp(if(x > 0.3, {inside}, 0), 0, 1e6)"),
        "max(5e4*max(x - 0.3, 0) + 30*v*step(x - 0.3), 0)".into(),
    ] {
        let run = motion(&force);
        for (x, expected) in run.state.iter().zip(&plain.state) {
            assert!((x - expected).abs() < 1e-12, "{force}: {x} {expected}");
        }
    }
}

/// What sticks to a belt slips on when the belt's speed jumps, and goes on sticking when that only bends, whatever rounding has left beside
/// a belt that stands: a parcel on belts that stop, told by friction of its own or in a contact.
#[test]
fn what_sticks_goes_on_as_what_it_sticks_to_is_told_otherwise() {
    const A: f64 = 0.3 * 9.81;
    let parcel = |belt: &str, in_contact: bool, until: f64| {
        let text = match in_contact {
            false => format!(
                "[flight]\nx = \"v\"\nv = \"-0.3*9.81*sign(v - ({belt}))\"\n[initial]\nx = 0\nv = 0\n"
            ),
            true => format!(
                "[flight]\nx = \"v\"\nv = \"0\"\ny = \"w\"\nw = \"-9.81\"\n[[contact]]\nname = \"belt\"\ngap = \"y\"\nimpulse = {{ w = 1 }}\n\
                 restitution = 0\nfriction = {{ coefficient = 0.3, along = {{ v = 1 }}, rate = \"v - ({belt})\" }}\n\
                 [initial]\nx = 0\nv = 0\ny = 0\nw = 0\n"
            ),
        };
        run::<f64>(&text, until)
    };
    for in_contact in [false, true] {
        for belt in [
            "if(t < 2, 1, 0)",
            "step(2 - t)",
            "0.5 + 0.5*sign(2 - t)",
            "1 - min(floor(t/2), 1)",
            "if(mod(t, 5) < 2, 1, 0)",
        ] {
            let stops = parcel(belt, in_contact, 4.0);
            assert_eq!(stops.outcome, Outcome::Horizon, "{belt}");
            // As long to slow down as to speed up.
            assert!(
                (stops.state[0] - 2.0).abs() < 1e-13,
                "{belt}: {:?}",
                stops.state
            );
            assert_eq!(stops.state[1], 0.0);
        }
        let begins = 1.0 / (A + 0.3);
        let slower = 1.0 - 0.3 * begins;
        let way = 0.5 * A * begins * begins + 0.5 * slower * slower / 0.3;
        for belt in [
            "max(1 - 0.3*t, 0)",
            "clamp(1 - 0.3*t, 0, 5)",
            "if(t < 10/3, 1 - 0.3*t, 0)",
            "0.5*(abs(1 - 0.3*t) + 1 - 0.3*t)",
        ] {
            let stops = parcel(belt, in_contact, 4.0);
            assert_eq!(stops.outcome, Outcome::Horizon, "{belt}");
            assert!(
                (stops.state[0] - way).abs() < 1e-13,
                "{belt}: {:?}",
                stops.state
            );
            assert_eq!(stops.state[1], 0.0);
            let leaves = |detail: &Occurrence<f64>| {
                matches!(detail, Occurrence::Leave { .. } | Occurrence::Slip { .. })
            };
            assert!(
                !stops.events.iter().any(|event| leaves(&event.detail)),
                "{belt}"
            );
        }
    }
}

/// Friction that a clock puts on while the body stands holds it, whether it jumps or grows from nothing, and from the start.
#[test]
fn a_brake_that_is_put_on_holds_what_stands() {
    for brake in [
        "if(t > 1, 8, 0)*sign(v)",
        "if(t > 1, 8*sign(v), 0)",
        "8*step(t - 1)*sign(v)",
        "min(16*max(t - 0.5, 0), 8)*sign(v)",
        "if(t > 0, 8, 0)*sign(v)",
        "if(s > 1, 8, 0)*sign(v)",
    ] {
        let text = format!(
            "[flight]\nx = \"v\"\nv = \"if(t > 2, if(t > 4, 9, 3), 0) - {brake}\"\ns = \"1\"\n[initial]\nx = 0\nv = 0\ns = 0\n"
        );
        let run = run::<f64>(&text, 6.0);
        assert_eq!(run.outcome, Outcome::Horizon, "{brake}");
        // A force of 9 against 8 from t = 4 on.
        assert!(
            (run.state[0] - 2.0).abs() < 1e-13,
            "{brake}: {:?}",
            run.state
        );
        assert!((run.state[1] - 2.0).abs() < 1e-13);
    }
    let preload = "[flight]\nx = \"v\"\nv = \"if(t > 3, 4, 1) - if(t > 1, 3*sign(x), 1)\"\n[initial]\nx = 0\nv = 0\n";
    let run = run::<f64>(preload, 5.0);
    assert_eq!(run.outcome, Outcome::Horizon);
    assert!((run.state[0] - 2.0).abs() < 1e-13, "{:?}", run.state);
}
