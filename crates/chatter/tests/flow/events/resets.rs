//! Events that change the state: each is found however soon it follows the one before.

use chatter::analysis::simulate::{Outcome, Simulation, Spec, simulate};
use chatter::flow::Occurrence;
use chatter::model::Model;
use chatter::numerics::{DoubleDouble, Real};
use std::ops::ControlFlow;

fn run(text: &str, until: f64) -> Simulation<f64> {
    let model = Model::from_toml(text, "test").unwrap_or_else(|errors| panic!("{errors:?}"));
    simulate::<f64>(&model, &Spec::until(until), &mut |_| {
        ControlFlow::Continue(())
    })
    .expect("a legal start")
}

/// A ball that bounces by an event and not at a contact: the n-th reset is at sqrt(2 h/g) (1 + 2 (r + ... + r^n)), and it
/// never falls through the floor.
#[test]
fn a_ball_that_bounces_by_an_event_stays_above_the_floor() {
    for height in [0.9, 1.0, 1.7, 3.0] {
        let text = format!(
            "[flight]\ny = \"v\"\nv = \"-10\"\n[[event]]\nname = \"floor\"\nsurface = \"y\"\ndirection = \"falling\"\n\
             reset = {{ v = \"-0.5*v\" }}\n[initial]\ny = {height}\nv = 0\n"
        );
        let run = run(&text, 10.0);
        let fall = (2.0 * height / 10.0_f64).sqrt();
        let resets: Vec<f64> = (run.events.iter())
            .filter(|event| matches!(event.detail, Occurrence::Reset { .. }))
            .map(|event| event.time)
            .collect();
        assert!(resets.len() > 40, "{}", resets.len());
        for (n, time) in resets.iter().enumerate().take(40) {
            let bounces = 1.0 - 0.5_f64.powi(n as i32);
            let expected = fall * (1.0 + 2.0 * bounces);
            assert!((time - expected).abs() < 1e-13, "{n}: {time} {expected}");
        }
        assert!(run.events.iter().all(|event| event.state[0] > -1e-12));
        // There is no end of them, and it is said.
        assert_eq!(run.outcome.name(), "switches_without_end");
    }
}

/// Flights that only events end, and of which expansions are whole: they reach as far as they are asked to. However many there were, the
/// next event is where the state is on its surface.
#[test]
fn events_end_flights_that_expansions_reach_far_beyond() {
    let ball = "[flight]\ny = \"v\"\nv = \"-9.81\"\n[[event]]\nname = \"hit\"\nsurface = \"y\"\ndirection = \"falling\"\n\
                reset = { v = \"-v\" }\n[section.apex]\nsurface = \"v\"\ndirection = \"falling\"\n[initial]\ny = 1.5\nv = 0\n";
    let walls = "[flight]\nx = \"v\"\nv = \"0\"\n[[event]]\nname = \"right\"\nsurface = \"x - 1\"\ndirection = \"rising\"\n\
                 reset = { v = \"-v\" }\n[[event]]\nname = \"left\"\nsurface = \"x + 1\"\ndirection = \"falling\"\n\
                 reset = { v = \"-v\" }\n[initial]\nx = 0.1\nv = 0.7\n";
    let fall = (2.0 * 1.5 / 9.81_f64).sqrt();
    for until in [20.0, 100.0, 1000.0] {
        // Hits and apexes in turn, a fall apart.
        let bounces = run(ball, until);
        assert_eq!(bounces.events.len(), (until / fall) as usize, "{until}");
        for (n, event) in bounces.events.iter().enumerate() {
            let is_hit = matches!(event.detail, Occurrence::Reset { .. });
            assert_eq!(is_hit, n % 2 == 0, "{n}");
            let off = event.time - fall * (n + 1) as f64;
            assert!(off.abs() < 1e-12 * until, "{n}: {off:e}");
        }
        let between = run(walls, until);
        let passes = (until - 0.9 / 0.7) / (2.0 / 0.7);
        assert_eq!(between.events.len(), passes as usize + 1, "{until}");
        assert!(
            between
                .events
                .iter()
                .all(|event| (event.state[0].abs() - 1.0).abs() < 1e-12)
        );
    }
}

/// A force that an event switches on lifts a mass off its seat: that is a release.
#[test]
fn a_contact_that_an_event_opens_is_released() {
    let text = "[flight]\nx = \"v\"\nv = \"4*s - 1\"\ns = \"0\"\np = \"1\"\n[[contact]]\nname = \"seat\"\ngap = \"x\"\n\
                impulse = { v = 1 }\nrestitution = 0.5\n[[event]]\nname = \"on\"\nsurface = \"p - 1\"\ndirection = \"rising\"\n\
                reset = { s = \"1\" }\n[initial]\nx = 0\nv = 0\ns = 0\np = 0\n";
    let run = run(text, 2.0);
    assert_eq!(run.outcome, Outcome::Horizon);
    let releases: Vec<f64> = (run.events.iter())
        .filter(|event| matches!(event.detail, Occurrence::Release { contact: 0 }))
        .map(|event| event.time)
        .collect();
    assert_eq!(releases, [1.0]);
    assert!((run.state[0] - 1.5).abs() < 1e-14, "{:?}", run.state);
}

/// Times of the events of one name's section.
fn resets(run: &Simulation<f64>, of: usize) -> Vec<f64> {
    (run.events.iter())
        .filter(|event| matches!(event.detail, Occurrence::Reset { section } if section == of))
        .map(|event| event.time)
        .collect()
}

fn assert_near(found: &[f64], expected: &[f64], what: &str) {
    assert_eq!(found.len(), expected.len(), "{what}: {found:?}");
    for (a, b) in found.iter().zip(expected) {
        assert!((a - b).abs() < 1e-12, "{what}: {found:?}");
    }
}

/// A surface whose function jumps over zero is no zero of it afterwards, be it that a sawtooth, an impact or another event makes it jump.
#[test]
fn after_a_jump_over_its_surface_an_event_is_found_as_before() {
    let clock = |direction: &str| {
        format!(
            "[flight]\nn = \"0\"\n[[event]]\nname = \"e\"\nsurface = \"mod(t, 1) - 0.5\"\ndirection = \"{direction}\"\n\
             reset = {{ n = \"n + 1\" }}\n[section.s]\nsurface = \"sin(2*pi*(t - 0.2))\"\ndirection = \"rising\"\n[initial]\nn = 0\n"
        )
    };
    assert_near(
        &resets(&run(&clock("falling"), 4.1), 0),
        &[1.0, 2.0, 3.0, 4.0],
        "falling",
    );
    let both = [0.5, 1.0, 1.5, 2.0, 2.5, 3.0, 3.5, 4.0];
    assert_near(&resets(&run(&clock("either"), 4.1), 0), &both, "either");
    // A ball's velocity jumps through 0.2 at impacts, and comes down through it in each flight.
    let ball = "[flight]\ny = \"v\"\nv = \"-1\"\nn = \"0\"\n[[contact]]\nname = \"floor\"\ngap = \"y\"\nimpulse = { v = 1 }\n\
                restitution = 0.5\n[[event]]\nname = \"e\"\nsurface = \"v - 0.2\"\ndirection = \"either\"\nreset = { n = \"n + 1\" }\n\
                [initial]\ny = 1\nv = 0.3\nn = 0\n";
    let fall = 0.3 + 2.09_f64.sqrt();
    let (first, second) = (0.5 * (fall - 0.3), 0.25 * (fall - 0.3));
    let expected = [
        0.1,
        fall,
        fall + first - 0.2,
        fall + 2.0 * first,
        fall + 2.0 * first + second - 0.2,
    ];
    assert_near(&resets(&run(ball, 4.5), 0), &expected, "ball");
    // s grows at the rate one, and A takes one off.
    let pair = "[flight]\nx = \"1\"\ns = \"1\"\nn = \"0\"\n[[event]]\nname = \"A\"\nsurface = \"sin(2*pi*(x - 0.9))\"\ndirection = \"rising\"\n\
                reset = { s = \"s - 1\" }\n[[event]]\nname = \"B\"\nsurface = \"s - 0.5\"\ndirection = \"either\"\nreset = { n = \"n + 1\" }\n\
                [initial]\nx = 0\ns = 0\nn = 0\n";
    assert_near(
        &resets(&run(pair, 3.0), 1),
        &[0.5, 0.9, 1.5, 1.9, 2.5, 2.9],
        "pair",
    );
}

/// What is constant on each side of a corner jumps there: from one constant to another, or from one to what is none.
#[test]
fn an_event_between_two_constants_is_found() {
    for surface in [
        "if(x < 1.3, 1, -1)",
        "-sign(x - 1.3)",
        "0.5 - step(x - 1.3)",
        "if(x < 1.3, 1, x - 5)",
        "1.3 - x",
    ] {
        let text = format!(
            "[flight]\nx = \"1\"\nn = \"0\"\n[[event]]\nname = \"e\"\nsurface = \"{surface}\"\ndirection = \"falling\"\n\
             reset = {{ n = \"n + 1\" }}\n[initial]\nx = 0.1\nn = 0\n"
        );
        assert_near(&resets(&run(&text, 4.0), 0), &[1.2], surface);
    }
    // Another event takes it to its other form.
    let text = "[flight]\nx = \"1\"\ns = \"0\"\nn = \"0\"\n[[event]]\nname = \"A\"\nsurface = \"x - 1\"\ndirection = \"rising\"\n\
                reset = { s = \"0\" }\n[[event]]\nname = \"B\"\nsurface = \"if(s < 0.5, x - 5, 1)\"\ndirection = \"falling\"\n\
                reset = { n = \"n + 1\" }\n[initial]\nx = 0\ns = 1\nn = 0\n";
    assert_near(&resets(&run(text, 3.0), 1), &[1.0], "by a reset");
}

/// Achilles and the tortoise: an event that puts its surface half as far ahead each time. There are infinitely many of them before the
/// time 1, wherever that lies and however large the numbers are that the surface is the difference of.
#[test]
fn events_that_come_sooner_and_sooner_have_no_end() {
    for (offset, speed, share) in [
        (0.0_f64, 1.0, 0.5),
        (3.0, 1.0, 0.7),
        (1e3, 1e-3, 0.3),
        (-7.0, 1e4, 0.5),
    ] {
        let goal = offset + speed;
        let text = format!(
            "[flight]\nx = \"{speed:?}\"\ny = \"0\"\n[[event]]\nname = \"e\"\nsurface = \"x - y\"\ndirection = \"rising\"\n\
             reset = {{ y = \"y + {share}*({goal:?} - y)\" }}\n[initial]\nx = {offset:?}\ny = {:?}\n",
            offset + 0.5 * speed
        );
        let run = run(&text, 12.0);
        assert_eq!(run.outcome.name(), "switches_without_end", "{text}");
        let last = run.events.last().expect("events").time;
        assert!(
            (last - 1.0).abs() < 1e-15 * (offset.abs() / speed + 1.0) * 1e3,
            "{last}"
        );
    }
}

/// Events whose intervals shrink for a while, and which never come within rounding of each other, go on.
#[test]
fn events_that_come_sooner_for_a_while_go_on() {
    let text = "[flight]\nx = \"1\"\ny = \"0\"\n[[event]]\nname = \"e\"\nsurface = \"x - y\"\ndirection = \"rising\"\n\
                reset = { y = \"y + max(0.5*(1 - y), 1e-9)\" }\n[initial]\nx = 0\ny = 0.5\n";
    let run = run(text, 1.0 + 2e-8);
    assert_eq!(run.outcome.name(), "horizon");
    assert!(
        (45..=55).contains(&run.events.len()),
        "{}",
        run.events.len()
    );
}

/// What has rested in an event's surface, as a body on a plate does in that of their relative velocity, leaves it: that is no event
/// that brings itself about.
#[test]
fn a_surface_that_was_rested_in_is_left() {
    let text = "[flight]\ny = \"v\"\nv = \"-1\"\n[[contact]]\ngap = \"y - 1.5*sin(t)\"\nimpulse = { v = 1 }\n\
                restitution = 0.8\n[[event]]\nname = \"brake\"\nsurface = \"v - 1.5*cos(t)\"\ndirection = \"rising\"\n\
                reset = { v = \"1.5*cos(t) + 0.5*(v - 1.5*cos(t))\" }\n[initial]\ny = 3\nv = 0\n";
    let run = run(text, 20.0);
    assert_eq!(run.outcome.name(), "horizon");
    let released = |k: f64| (1.0_f64 / 1.5).asin() + std::f64::consts::TAU * k;
    let found: Vec<f64> = (run.events.iter())
        .filter(|event| matches!(event.detail, Occurrence::Release { .. }))
        .map(|event| event.time)
        .collect();
    assert_near(&found, &[1.0, 2.0, 3.0].map(released), "releases");
}

/// A body that an event brakes each time it crosses the surface of its own dry field: q'' = -sign(q), p -> e p. All is over at
/// sqrt(2 q0) (1 + 2 e/(1 - e)), and no crossing before is passed over.
#[test]
fn events_on_the_surface_where_the_field_jumps_come_to_their_end() {
    for (direction, share) in [("either", 0.3), ("either", 0.65), ("either", 0.8)] {
        let text = format!(
            "[flight]\nq = \"p\"\np = \"-sign(q)\"\n[[event]]\nname = \"hit\"\nsurface = \"q\"\ndirection = \"{direction}\"\n\
             reset = {{ p = \"{share}*p\" }}\n[initial]\nq = 0.1\np = 0\n"
        );
        let run = run(&text, 10.0);
        assert_eq!(run.outcome.name(), "switches_without_end");
        let end = f64::sqrt(0.2) * (1.0 + 2.0 * share / (1.0 - share));
        assert!(
            (run.time - end).abs() < 1e-12,
            "{share}: {} {end}",
            run.time
        );
    }
}

/// To count the reversals of a velocity that dry friction stops changes nothing.
#[test]
fn reversals_are_counted_where_friction_holds() {
    let text = |event: &str, x: f64| {
        format!(
            "[flight]\nx = \"v\"\nv = \"-x + 1.5*cos(t) - 0.6*sign(v)\"\nn = \"0\"\n{event}[initial]\nx = {x:?}\nv = 0\nn = 0\n"
        )
    };
    let count = |direction: &str, reset: &str| {
        format!(
            "[[event]]\nname = \"turn\"\nsurface = \"v\"\ndirection = \"{direction}\"\nreset = {{ {reset} }}\n"
        )
    };
    for k in 0..20 {
        let x = 0.074 * f64::from(k);
        let plain = run(&text("", x), 20.0);
        for event in [
            count("falling", "n = \"n + 1\""),
            count("either", "n = \"n + 1\""),
            count("either", "v = \"0.5*v\""),
        ] {
            let counted = run(&text(&event, x), 20.0);
            assert_eq!(counted.outcome, Outcome::Horizon, "{x} {event}");
            for i in 0..2 {
                assert!(
                    (counted.state[i] - plain.state[i]).abs() < 1e-12,
                    "{x} {event}"
                );
            }
        }
    }
}

/// An event that another one follows at its instant is told once, in doubles and with thirty digits: sin(a t + sin(2 t)/2 + 0.1) rises through zero once a
/// turn of its argument, which never falls.
#[test]
fn an_event_that_another_follows_at_once_is_told_once() {
    fn check<R: Real>(a: f64) {
        let text = format!(
            "[flight]\nx = \"cos(2*t)\"\nn = \"0\"\nk = \"0\"\n[[event]]\nname = \"turn\"\nsurface = \"sin({a}*t + x)\"\ndirection = \"rising\"\n\
             reset = {{ n = \"1 - n\", k = \"k + 1\" }}\n[[event]]\nname = \"back\"\nsurface = \"0.5 - n\"\ndirection = \"rising\"\n\
             reset = {{ n = \"n + 1\" }}\n[initial]\nx = 0.1\nn = 1\nk = 0\n"
        );
        let model = Model::from_toml(&text, "test").unwrap_or_else(|errors| panic!("{errors:?}"));
        let run = simulate::<R>(&model, &Spec::until(12.0), &mut |_| {
            ControlFlow::Continue(())
        })
        .expect("a legal start");
        let turns = (a * 12.0 + 0.1 + 0.5 * 24.0_f64.sin()) / core::f64::consts::TAU;
        assert_eq!(run.outcome, Outcome::Horizon);
        let [n, k] = [1, 2].map(|state| run.state[state].to_f64());
        assert_eq!([n, k], [1.0, turns.floor()], "{a}");
    }
    for k in 0..20 {
        let a = 3.0 + 0.013 * f64::from(k);
        check::<f64>(a);
        check::<DoubleDouble>(a);
    }
}

/// A runner on a springy leg, whose foot each touchdown puts a leg's length away from the body: its motion does not depend on how far it
/// has come, nor does what a distance of a million lengths has no digits for set off the event of leaving the ground.
#[test]
fn what_an_event_puts_at_a_distance_is_there_wherever_it_is() {
    let runner = |start: f64| {
        let text = format!(
            "[parameters]\nal = 1.19\n[definitions]\nL = \"hypot(x - xf, y)\"\nF = \"if(s > 0.5, 250*(1 - L), 0)\"\n\
             [flight]\nx = \"u\"\nu = \"F*(x - xf)/L\"\ny = \"v\"\nv = \"F*y/L - 9.81\"\nxf = \"0\"\ns = \"0\"\n\
             [[event]]\nname = \"touchdown\"\nsurface = \"if(s > 0.5 or v > 0, 1, y - sin(al))\"\ndirection = \"falling\"\n\
             reset = {{ s = 1, xf = \"x + cos(al)\" }}\n\
             [[event]]\nname = \"liftoff\"\nsurface = \"if(s > 0.5, L - 1, -1)\"\ndirection = \"rising\"\nreset = {{ s = 0 }}\n\
             [initial]\nx = {start}\nu = 5\ny = 1\nv = 0\nxf = {}\ns = 0\n",
            start - 10.0
        );
        run(&text, 4.0)
    };
    let near = runner(0.0);
    assert_eq!(near.outcome, Outcome::Horizon);
    let resets = |run: &Simulation<f64>| {
        let resets = run.events.iter();
        resets
            .filter(|event| matches!(event.detail, Occurrence::Reset { .. }))
            .count()
    };
    assert!(resets(&near) > 14, "{}", resets(&near));
    for start in [300.0, 4.3e3, 1e6, -7.7e8] {
        let far = runner(start);
        assert_eq!(far.outcome, Outcome::Horizon, "{start}");
        assert_eq!(resets(&far), resets(&near));
        for state in [1, 2, 3] {
            let off = far.state[state] - near.state[state];
            assert!(off.abs() < 1e-10, "{start}: {off:e}");
        }
    }
}

/// Friction and a section jump where events come that are written as multiples of their surface, which their resets leave the state on: each comes
/// once a crossing, and the motion is that of events of the very surface.
#[test]
fn an_event_keeps_the_state_on_surfaces_that_it_does_not_move_it_off() {
    for (unit, length) in [(1.0, 1.0), (1e-3, 1e3), (1e3, 1e-3)] {
        for (w, r) in [(1.05666, 0.53546), (1.2826, 0.606834)] {
            let of = |up: &str, down: (&str, &str)| {
                let text = format!(
                    "[flight]\nx = 'v/{unit:?}'\nv = '({length:?}*cos({w}*t/{unit:?}) - x - 0.3*{length:?}*sign(x) - 0.04*v)/{unit:?}'\n\
                     [[event]]\nname = 'up'\nsurface = '{up}'\ndirection = 'rising'\nreset = {{ v = '{r}*v' }}\n\
                     [[event]]\nname = 'down'\nsurface = '{}'\ndirection = '{}'\nreset = {{ v = '{r}*v' }}\n\
                     [section.s]\nsurface = '-3*x'\ndirection = 'either'\n[initial]\nx = {:?}\nv = 0\n",
                    down.0,
                    down.1,
                    0.3 * length
                );
                run(&text, 1500.0 * unit)
            };
            let (multiples, itself) = (of("2*x", ("-x", "rising")), of("x", ("x", "falling")));
            for run in [&multiples, &itself] {
                let resets = (0..2).map(|of| resets(run, of).len()).sum::<usize>();
                assert_eq!(run.counts.sections as usize, resets, "{unit} {w}");
            }
            let states = multiples.state.iter().zip(&itself.state);
            for (a, b) in states.take(2) {
                assert!((a - b).abs() < 1e-10 * length, "{unit} {w}: {a} {b}");
            }
        }
    }
}

/// A ball at rest on its floor that an event throws down at it hits it at that instant, and bounces as a ball that came with that rate.
#[test]
fn an_event_throws_a_ball_at_rest_at_its_floor() {
    for (unit, length) in [(1.0, 1.0), (1e-2, 1e-3), (60.0, 25.4)] {
        for (gap, reset) in [("x", "-0.7*c"), ("2*x", "v - 0.7*c"), ("0.37*x", "-0.7*c")] {
            for event in ["t - T", "T - t", "y - 0.39"] {
                let text = format!(
                    "[parameters]\nT = {:?}\nc = {:?}\n[flight]\nx = 'v'\nv = '{:?}'\ny = '0.3/{unit:?}'\n\
                     [[contact]]\nname = 'floor'\ngap = '{gap}'\nimpulse = {{ v = 1 }}\nrestitution = 0.8\n\
                     [[event]]\nname = 'throw'\nsurface = '{event}'\ndirection = 'either'\nreset = {{ v = '{reset}' }}\n\
                     [initial]\nx = 0\nv = 0\ny = 0\n",
                    1.3 * unit,
                    length / unit,
                    -2.0 * length / (unit * unit),
                );
                let run = run(&text, 1.5 * unit);
                assert_eq!(run.outcome, Outcome::Horizon, "{text}");
                let first = [&run.events[0].detail, &run.events[1].detail];
                assert!(matches!(first[0], Occurrence::Reset { .. }), "{text}");
                assert!(
                    matches!(first[1], Occurrence::Impact { contact: 0, .. }),
                    "{text}"
                );
                let height = 0.8 * 0.7 * 0.2 - 0.2 * 0.2;
                assert!((run.state[0] / length - height).abs() < 1e-12, "{text}");
            }
        }
    }
}
