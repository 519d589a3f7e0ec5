//! Two balls on top of each other, whose impacts accumulate while they accumulate on the floor, against their own
//! parabolas, one impact after the other, in double-double.

use chatter::analysis::simulate::{Outcome, Spec, simulate};
use chatter::flow::{Occurrence, Settings, System, Trajectory};
use chatter::model::ModelBuilder;
use chatter::numerics::{DoubleDouble, Real, Scalar};
use proptest::prelude::*;
use std::ops::ControlFlow;

type Dd = DoubleDouble;

/// Two equal balls, dropped in unit gravity from a height, the upper one so much higher.
#[derive(Clone, Copy, Debug)]
struct Stack {
    restitution: f64,
    height: f64,
    above: f64,
}

impl Stack {
    /// When both lie still: every impact one by one, the one that closes fastest first where two happen at one instant.
    fn end(self) -> Dd {
        const REST: f64 = 1e-36;
        let (zero, two) = (Dd::ZERO, Dd::from(2.0));
        let r = Dd::from(self.restitution);
        let mut time = zero;
        let (mut low, mut v_low) = (Dd::from(self.height), zero);
        // The upper ball relative to the lower one.
        let (mut gap, mut rate) = (Dd::from(self.above), zero);
        let mut lies = false;
        loop {
            // Collisions at this instant.
            loop {
                let floor = low <= zero && v_low < zero;
                let pair = gap <= zero && rate < zero;
                if floor && (!pair || v_low <= rate) {
                    rate += (Dd::ONE + r) * v_low;
                    v_low = -r * v_low;
                    lies = false;
                } else if pair {
                    v_low += (Dd::ONE + r) / two * rate;
                    rate = -r * rate;
                    lies = false;
                } else {
                    break;
                }
            }
            let small = |x: Dd| x.abs().to_f64() < REST;
            if low <= zero && small(v_low) {
                if gap <= zero && small(rate) {
                    return time;
                }
                // The end of a sequence on the floor.
                rate += v_low;
                (v_low, lies) = (zero, true);
            }
            let floor = (!lies).then(|| v_low + (v_low * v_low + two * low).sqrt());
            let pair = if lies {
                Some(rate + (rate * rate + two * gap).sqrt())
            } else {
                (rate < zero).then(|| gap / -rate)
            };
            let pair = pair.map_or(1e30.into(), |t| {
                if gap <= zero && rate <= zero {
                    Dd::from(1e30)
                } else {
                    t
                }
            });
            let floor = floor.unwrap_or(Dd::from(1e30));
            let step = if floor <= pair { floor } else { pair };
            time += step;
            gap += rate * step;
            if lies {
                gap -= step * step / two;
                rate -= step;
            } else {
                low += v_low * step - step * step / two;
                v_low -= step;
            }
            if floor <= pair {
                low = zero;
            }
            if pair <= floor {
                gap = zero;
            }
        }
    }

    /// Time of the last accumulation of the library, with the error told.
    fn simulate<R: Real>(self) -> (R, f64) {
        let model = ModelBuilder::new()
            .parameter("r", self.restitution)
            .state("x", "v", self.height)
            .state("v", "-1", 0.0)
            .state("y", "w", self.height + self.above)
            .state("w", "-1", 0.0)
            .contact("floor", "x", [("v", 1.0)], "r")
            .contact("pair", "y - x", [("v", -1.0), ("w", 1.0)], "r")
            .build()
            .expect("a valid model");
        let system = System::new(&model).expect("a valid system");
        let mut work = system.workspace::<R>(&Settings::default());
        let values = model.parameter_values::<f64>(&[]);
        let lift = |value: &f64| R::splat(*value);
        let parameters: Vec<R> = values.iter().map(lift).collect();
        let state: Vec<R> = model.initial_state(&values).iter().map(lift).collect();
        let mut trajectory = Trajectory::start(&system, &mut work, &parameters, R::ZERO, &state)
            .expect("a legal start");
        let mut end = None;
        loop {
            match trajectory
                .advance(&system, &mut work, R::splat(1e3))
                .expect("a finite field")
            {
                Some(Occurrence::Accumulation { error, .. }) => {
                    end = Some((trajectory.time(), error))
                }
                Some(Occurrence::Horizon) => break,
                _ => {}
            }
        }
        assert_eq!(trajectory.closed().contacts().count(), 2, "{self:?}");
        end.expect("an accumulation")
    }
}

#[test]
fn chatter_of_chatter() {
    for (restitution, height, above) in [
        (0.6, 0.5, 0.0),
        (0.6, 0.5, 0.25),
        (0.5, 1.0, 0.0),
        (0.3, 0.5, 0.125),
        (0.7, 0.25, 1.0),
    ] {
        let stack = Stack {
            restitution,
            height,
            above,
        };
        let truth = stack.end();
        let (time, _) = stack.simulate::<Dd>();
        let off = (time - truth).abs().to_f64();
        assert!(off < 1e-12, "{stack:?}, to thirty digits: off by {off:e}");
        let (time, told) = stack.simulate::<f64>();
        let off = (Dd::from(time) - truth).abs().to_f64();
        assert!(off < 1e-12, "{stack:?}: off by {off:e}, told {told:e}");
    }
    let stack = Stack {
        restitution: 0.6,
        height: 0.5,
        above: 0.0,
    };
    assert!((stack.end().to_f64() - 2.224_237_063_64).abs() < 1e-11);
}

/// A ball on a table or on another ball: mass, height, velocity, restitution of what is below it, and what pulls beside gravity.
type Ball<'a> = (f64, f64, f64, f64, &'a str);

/// Where balls on a table of this amplitude and angular frequency are at time 4: the table never falls away faster than they do, so
/// that they lie on each other in the end.
fn lie_on_a_table(amplitude: f64, omega: f64, balls: &[Ball]) {
    let mut model = ModelBuilder::new()
        .parameter("A", amplitude)
        .parameter("omega", omega);
    for (i, &(_, height, rate, _, pull)) in balls.iter().enumerate() {
        let force = format!("-9.81 {pull}");
        model = (model.state(&format!("y{i}"), format!("v{i}").as_str(), height)).state(
            &format!("v{i}"),
            force.as_str(),
            rate,
        );
    }
    for (i, &(mass, _, _, restitution, _)) in balls.iter().enumerate() {
        let name = format!("below{i}");
        let push = (format!("v{i}"), 1.0 / mass);
        model = if i == 0 {
            model.contact(&name, "y0 - A*sin(omega*t)", [push], restitution)
        } else {
            let below = (format!("v{}", i - 1), -1.0 / balls[i - 1].0);
            let gap = format!("y{i} - y{} - 0.1", i - 1);
            model.contact(&name, gap.as_str(), [push, below], restitution)
        };
    }
    let model = model.build().expect("a valid model");
    let spec = Spec::until(4.0);
    let mut goes_on = |_: &_| ControlFlow::Continue(());
    let run = simulate::<f64>(&model, &spec, &mut goes_on).expect("a legal start");
    assert_eq!(run.outcome, Outcome::Horizon, "{balls:?}");
    let table = amplitude * (4.0 * omega).sin();
    for i in 0..balls.len() {
        let off = run.state[2 * i] - table - 0.1 * i as f64;
        assert!(off.abs() < 1e-13, "{balls:?}: ball {i} is off by {off:e}");
    }
}

/// A contact whose rate after its impact is lost as another one comes to rest is at rest as well.
#[test]
fn what_chatters_in_turn_comes_to_rest() {
    let three = [
        (1.0, 0.1, 0.0, 0.8, ""),
        (1.0, 0.5, 0.0, 0.9, ""),
        (1.0, 0.6, 1.0, 0.2, ""),
    ];
    lie_on_a_table(0.5, 2.0, &three);
    let uneven = [
        (1.0, 0.5, 1.0, 0.8, ""),
        (2.0, 0.7, -1.0, 0.7, ""),
        (0.1, 0.8, 0.5, 0.2, ""),
    ];
    lie_on_a_table(0.5, 3.0, &uneven);
}

/// One that lifts off as others separate is asked again as these come to rest, at the same instant.
#[test]
fn what_has_just_left_is_held_by_what_closes() {
    let five = [
        (1.0, 0.5, 0.0, 0.5, "+ 10*(y1 - y0 - 0.5)"),
        (0.5, 0.6, 1.0, 0.7, "- 20*(y1 - y0 - 0.5)"),
        (1.0, 1.0, -1.0, 0.2, "+ 3*(y3 - y2 - 0.5)"),
        (0.5, 1.4, 1.0, 0.7, "- 6*(y3 - y2 - 0.5)"),
        (0.5, 1.5, 0.0, 0.7, ""),
    ];
    lie_on_a_table(1.5, 2.0, &five);
}

/// A light ball on a heavy one that rests on a moving table is thrown up by the rounding of the table's height: as high as that,
/// without end.
#[test]
fn chatter_that_rounding_feeds_ends() {
    lie_on_a_table(
        0.5,
        1.0,
        &[(1.0, 0.0, 0.5, 0.3, ""), (0.1, 0.1, 0.0, 0.9, "")],
    );
    lie_on_a_table(
        0.5,
        3.0,
        &[(1.0, 0.0, -1.0, 0.3, ""), (0.1, 0.4, 0.5, 0.9, "")],
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    /// What is told of the last accumulation, with all that were completed within it, covers by how far it is off.
    #[test]
    fn errors_told_cover_the_truth(
        restitution in 0.2_f64..0.95,
        height in 256_u32..1024,
        above in prop_oneof![Just(0), 0_u32..1024],
    ) {
        const LARGEST_RATIO: f64 = 10.0;
        // Such that the sum is exact.
        let [height, above] = [height, above].map(|n| f64::from(n) / 1024.0);
        let stack = Stack { restitution, height, above };
        let truth = stack.end();
        let (time, told) = stack.simulate::<f64>();
        let off = (Dd::from(time) - truth).abs().to_f64();
        prop_assert!(off <= LARGEST_RATIO * told, "{stack:?}: off by {off:e}, told {told:e}");
        let (time, told) = stack.simulate::<Dd>();
        let off = (time - truth).abs().to_f64();
        prop_assert!(off <= LARGEST_RATIO * told, "to thirty digits {stack:?}: off by {off:e}, told {told:e}");
    }
}

/// Both forces vanish at once where the table falls away faster than gravity: whichever is told first, the two fly together until
/// the table comes back, and nothing is met before.
#[test]
fn balls_that_are_released_together_fly_together() {
    const STACKED: &str = r#"
[parameters]
phi = 0.3
A = 0.01
omega = 40.0
[flight]
x1 = "v1"
v1 = "-9.81"
x2 = "v2"
v2 = "-9.81"
[[contact]]
name = "table"
gap = "x1 - A*sin(omega*t + phi)"
impulse = { v1 = 1 }
restitution = 0.5
[[contact]]
name = "balls"
gap = "x2 - x1"
impulse = { v1 = -1, v2 = 2 }
restitution = 0.5
[initial]
x1 = "A*sin(phi)"
v1 = "A*omega*cos(phi)"
x2 = "A*sin(phi)"
v2 = "A*omega*cos(phi)"
"#;
    const GRAVITY: f64 = 9.81;
    const AMPLITUDE: f64 = 0.01;
    const OMEGA: f64 = 40.0;
    // Where the table's acceleration is that of gravity.
    let sine = GRAVITY / (AMPLITUDE * OMEGA * OMEGA);
    let release = sine.asin();
    for k in 0..240 {
        let phi = 0.2 + 0.0013 * f64::from(k);
        let mut model = chatter::model::Model::from_toml(STACKED, "stacked").unwrap();
        model.set_parameter("phi", &format!("{phi:e}")).unwrap();
        let system = System::new(&model).unwrap();
        let mut work = system.workspace::<f64>(&Settings::default());
        let parameters = model.parameter_values::<f64>(&[]);
        let state = model.initial_state(&parameters);
        let mut flight = Trajectory::start(&system, &mut work, &parameters, 0.0, &state).unwrap();
        flight.set_horizon(0.12);
        let met = loop {
            match flight.advance_to_horizon(&system, &mut work).unwrap() {
                Some(Occurrence::Impact { contact, .. }) => break contact,
                Some(Occurrence::Graze { contact: 0, .. }) => panic!("{phi}: a graze"),
                _ => assert!(flight.time() < 0.12, "{phi}"),
            }
        };
        assert_eq!(met, 0, "{phi}");
        let since = flight.time() - (release - phi) / OMEGA;
        let rate = AMPLITUDE * OMEGA * release.cos();
        let height = AMPLITUDE * sine + rate * since - 0.5 * GRAVITY * since * since;
        let table = AMPLITUDE * (release + OMEGA * since).sin();
        assert!(
            (height - table).abs() < 1e-15,
            "{phi}: {:e}",
            height - table
        );
    }
}

/// Two balls on a shaken table do what one does: what has left it in an instant has left it still when the other does.
#[test]
fn balls_beside_each_other_fly_as_one_does() {
    let ball = |name: &str| {
        format!(
            "[[contact]]\ngap = \"x{name} - 5e-3*sin(w*t)\"\nimpulse = {{ v{name} = 1 }}\nrestitution = 0\n"
        )
    };
    let flight = |name: &str| format!("x{name} = \"v{name}\"\nv{name} = \"-9.81\"\n");
    let start = |name: &str| format!("x{name} = 0\nv{name} = \"5e-3*w\"\n");
    let text = |names: &[&str], w: u32| {
        let all = |part: &dyn Fn(&str) -> String| -> String {
            names.iter().map(|name| part(name)).collect()
        };
        let (flights, contacts, starts) = (all(&flight), all(&ball), all(&start));
        format!("[parameters]\nw = {w}\n[flight]\n{flights}{contacts}[initial]\n{starts}")
    };
    let run = |names: &[&str], w: u32| {
        let model = chatter::model::Model::from_toml(&text(names, w), "balls").unwrap();
        simulate::<f64>(
            &model,
            &Spec::until(1.0),
            &mut |_| ControlFlow::Continue(()),
        )
        .unwrap()
    };
    for w in 45..90 {
        let (one, two) = (run(&["a"], w), run(&["a", "b"], w));
        assert_eq!(two.outcome, one.outcome, "{w}");
        assert_eq!((two.counts.grazes, one.counts.grazes), (0, 0), "{w}");
        assert_eq!(two.counts.releases, 2 * one.counts.releases, "{w}");
        for (x, expected) in two.state[..4].iter().zip(one.state[..2].iter().cycle()) {
            assert!((x - expected).abs() < 1e-13, "{w}: {x} {expected}");
        }
    }
}
