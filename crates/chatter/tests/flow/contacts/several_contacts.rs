//! Several contacts: laws that hold whatever the masses, restitutions and starts.

use chatter::analysis::simulate::{
    Event, EventKind, Outcome, Sampling, Simulation, Spec, Stop, simulate,
};
use chatter::flow::Occurrence;
use chatter::model::Model;
use chatter::numerics::{DoubleDouble, Real};
use proptest::prelude::*;
use std::fmt::Write;
use std::ops::ControlFlow;

/// Bodies on a line, ordered; each pair of neighbours is a contact, and the first may stand on a floor.
#[derive(Clone, Debug)]
struct Chain {
    masses: Vec<f64>,
    /// One a contact, that with the floor first if there is one.
    restitutions: Vec<f64>,
    positions: Vec<f64>,
    velocities: Vec<f64>,
    gravity: f64,
    has_floor: bool,
    moreau: bool,
}

impl Chain {
    fn text(&self) -> String {
        let mut text = String::new();
        if self.moreau {
            text += "simultaneous = \"moreau\"\n";
        }
        text += "[flight]\n";
        for i in 0..self.masses.len() {
            let _ = writeln!(text, "x{i} = \"v{i}\"\nv{i} = {:?}", -self.gravity);
        }
        let mut restitutions = self.restitutions.iter();
        let mut contact = |name: String, gap: String, impulse: String| {
            let r = restitutions.next().expect("one a contact");
            let _ = writeln!(
                text,
                "[[contact]]\nname = \"{name}\"\ngap = \"{gap}\"\nimpulse = {{ {impulse} }}\nrestitution = {r:?}"
            );
        };
        if self.has_floor {
            contact("floor".into(), "x0".into(), "v0 = 1".into());
        }
        for i in 1..self.masses.len() {
            let (below, above) = (-1.0 / self.masses[i - 1], 1.0 / self.masses[i]);
            contact(
                format!("pair{i}"),
                format!("x{i} - x{}", i - 1),
                format!("v{} = {below:?}, v{i} = {above:?}", i - 1),
            );
        }
        text += "[initial]\n";
        for (i, (x, v)) in self.positions.iter().zip(&self.velocities).enumerate() {
            let _ = writeln!(text, "x{i} = {x:?}\nv{i} = {v:?}");
        }
        text
    }

    fn run<R: Real>(&self, until: f64, stops: Vec<Stop>) -> Simulation<R> {
        let model = Model::from_toml(&self.text(), "chain").expect("a valid model");
        let spec = Spec {
            stops,
            sampling: vec![Sampling::Dense { per_step: 3 }],
            ..Spec::until(until)
        };
        simulate::<R>(&model, &spec, &mut |_| ControlFlow::Continue(()))
            .unwrap_or_else(|error| panic!("{error:?} {}", self.text()))
    }

    /// The states of a simulation come as position and velocity of one body after the other.
    fn gaps(&self, state: &[f64]) -> Vec<f64> {
        self.differences(state, 0)
    }

    fn rates(&self, state: &[f64]) -> Vec<f64> {
        self.differences(state, 1)
    }

    fn differences(&self, state: &[f64], part: usize) -> Vec<f64> {
        let value = |i: usize| state[2 * i + part];
        let floor = self.has_floor.then(|| value(0));
        let pairs = (1..self.masses.len()).map(|i| value(i) - value(i - 1));
        floor.into_iter().chain(pairs).collect()
    }

    fn energy(&self, state: &[f64]) -> f64 {
        (self.masses.iter().enumerate())
            .map(|(i, m)| m * (0.5 * state[2 * i + 1].powi(2) + self.gravity * state[2 * i]))
            .sum()
    }

    fn momentum(&self, state: &[f64]) -> f64 {
        let parts = self.masses.iter().enumerate();
        parts.map(|(i, m)| m * state[2 * i + 1]).sum()
    }

    /// The laws of impacts hold all along a simulation.
    fn check(&self, run: &Simulation<f64>) -> Result<(), TestCaseError> {
        prop_assert!(
            matches!(
                run.outcome,
                Outcome::Horizon | Outcome::ImpactBudget | Outcome::Rest
            ),
            "{:?} {}",
            run.outcome,
            self.text()
        );
        let scale = (self.positions.iter().chain(&self.velocities))
            .fold(1.0, |most: f64, x| most.max(x.abs()));
        let samples = &run.samples[0];
        for k in 0..samples.len() {
            let state: Vec<f64> = samples.states.iter().map(|values| values[k]).collect();
            for gap in self.gaps(&state) {
                prop_assert!(
                    gap >= -1e-12 * scale,
                    "{gap:e} at {}: {}",
                    samples.times[k],
                    self.text()
                );
            }
        }
        let mut energy = self.energy(&run.start_state);
        let momentum = self.momentum(&run.start_state);
        let most = self.masses.iter().fold(0.0, |most: f64, m| most.max(*m));
        let mut instant = run.events.iter().peekable();
        while let Some(event) = instant.next() {
            let now = self.energy(&event.state);
            prop_assert!(
                now <= energy + 1e-12 * most * scale * scale * self.masses.len() as f64,
                "energy {energy} -> {now} at {}: {}",
                event.time,
                self.text()
            );
            energy = now;
            if !self.has_floor && self.gravity == 0.0 {
                prop_assert!((self.momentum(&event.state) - momentum).abs() < 1e-11 * scale * most);
            }
            // The last of an instant leaves no contact that touches and closes.
            if instant
                .peek()
                .is_none_or(|next| next.time > event.time + 1e-12)
            {
                let (gaps, rates) = (self.gaps(&event.state), self.rates(&event.state));
                for (gap, rate) in gaps.iter().zip(&rates) {
                    let closes_now = *rate < -1e-3 * scale && *gap <= -rate * 1e-13;
                    prop_assert!(!closes_now, "{gap:e} {rate:e} at {}", event.time);
                }
            }
        }
        Ok(())
    }
}

fn stack(restitutions: &[f64], masses: &[f64], spacing: f64) -> Chain {
    let count = restitutions.len();
    Chain {
        masses: masses[..count].to_vec(),
        restitutions: restitutions.to_vec(),
        positions: (0..count).map(|i| 1.0 + spacing * i as f64).collect(),
        velocities: vec![0.0; count],
        gravity: 1.0,
        has_floor: true,
        moreau: false,
    }
}

fn cradle(count: usize, moving: usize, restitution: f64) -> Chain {
    Chain {
        masses: vec![1.0; count],
        restitutions: vec![restitution; count - 1],
        positions: (0..count)
            .map(|i| if i < moving { -1.0 } else { 0.0 })
            .collect(),
        velocities: (0..count)
            .map(|i| if i < moving { 1.0 } else { 0.0 })
            .collect(),
        gravity: 0.0,
        has_floor: false,
        moreau: false,
    }
}

fn velocities(run: &Simulation<f64>) -> Vec<f64> {
    run.state.iter().copied().skip(1).step_by(2).collect()
}

#[test]
fn plastic_stacks_lie_on_the_floor() {
    for count in 1..=5 {
        let chain = stack(&vec![0.0; count], &[1.0, 2.0, 0.3, 5.0, 1.0], 0.5);
        let run = chain.run::<f64>(30.0, vec![]);
        chain.check(&run).unwrap();
        assert_eq!(run.closed.contacts().count(), count);
        assert!(run.state.iter().all(|x| x.abs() < 1e-15), "{:?}", run.state);
    }
}

#[test]
fn a_mass_that_rests_on_another_stops_with_it() {
    let mut chain = stack(&[0.0, 0.0], &[1.0, 1.0], 0.0);
    chain.positions = vec![1.0, 1.0];
    let run = chain.run::<f64>(3.0, vec![]);
    chain.check(&run).unwrap();
    assert_eq!(run.closed.contacts().count(), 2);
    assert!(run.state.iter().all(|x| x.abs() < 1e-15), "{:?}", run.state);
    assert!(
        run.events
            .iter()
            .any(|event| event.kind == EventKind::Cascade)
    );
}

#[test]
fn as_many_balls_leave_a_cradle_as_hit_it() {
    for (count, moving) in [(3, 1), (5, 1), (5, 2), (5, 3), (9, 4), (20, 1)] {
        let run = cradle(count, moving, 1.0).run::<f64>(3.0, vec![]);
        let expected: Vec<f64> = (0..count)
            .map(|i| if i + moving < count { 0.0 } else { 1.0 })
            .collect();
        assert_eq!(velocities(&run), expected, "{count} {moving}");
        assert_eq!(run.counts.ambiguities, 0);
    }
}

/// Impulses of three equal balls by Moreau's law: the pair that is hit moves on together, the first is thrown back.
#[test]
fn moreaus_law_solves_its_complementarity() {
    let mut chain = cradle(3, 1, 1.0);
    chain.moreau = true;
    let run = chain.run::<f64>(3.0, vec![]);
    for (value, expected) in velocities(&run).iter().zip([-1.0, 2.0, 2.0]) {
        assert!((value - expected / 3.0).abs() < 1e-15, "{:?}", run.state);
    }
}

/// Two balls of which both fall from rest at 0.5: chatter of the lower within chatter of the upper. The end was computed
/// by a separate program.
#[test]
fn chatter_of_chatter_ends_where_it_ends() {
    let mut chain = stack(&[0.6, 0.6], &[1.0, 1.0], 0.0);
    chain.positions = vec![0.5, 0.5];
    let run = chain.run::<f64>(10.0, vec![]);
    chain.check(&run).unwrap();
    let last = run.events.last().expect("events");
    assert!(
        (last.time - 2.224_237_063_64).abs() < 1e-11,
        "{}",
        last.time
    );
    let fine = chain.run::<DoubleDouble>(10.0, vec![]);
    let end = fine.events.last().expect("events").time.to_f64();
    assert!((last.time - end).abs() < 1e-12, "{} {end}", last.time);
    assert_eq!(run.closed, fine.closed);
}

#[test]
fn simultaneous_impacts_whose_order_matters_are_told() {
    let wedge = |slope: f64| {
        format!(
            "[flight]\nx = \"vx\"\ny = \"vy\"\nvx = 0\nvy = -1\n\
             [[contact]]\nname = \"left\"\ngap = \"y - x\"\nimpulse = {{ vx = -1, vy = 1 }}\nrestitution = 0.5\n\
             [[contact]]\nname = \"right\"\ngap = \"y + {slope}*x\"\nimpulse = {{ vx = {slope}, vy = 1 }}\nrestitution = 0.5\n\
             [initial]\nx = 0\ny = 1\nvx = 0\nvy = 0\n"
        )
    };
    let run = |text: &str| {
        let model = Model::from_toml(text, "wedge").expect("a valid model");
        simulate::<f64>(
            &model,
            &Spec::until(1.6),
            &mut |_| ControlFlow::Continue(()),
        )
        .expect("a legal start")
    };
    let oblique = run(&wedge(0.5));
    assert_eq!(oblique.counts.ambiguities, 1);
    let Occurrence::Ambiguity { contact, other } = oblique.events[0].detail else {
        panic!("{:?}", oblique.events[0]);
    };
    assert_ne!(contact, other);
    // At a right angle no impulse changes the rate of the other contact.
    let square = run(&wedge(1.0));
    assert_eq!(square.counts.ambiguities, 0);
    assert!(square.counts.impacts >= 2);
}

/// A body on a moving ramp for a million units of time, and a stack: states stay on what holds them.
#[test]
fn closed_contacts_stay_closed() {
    let text = "[parameters]\nw = 0.01\n[flight]\ny = \"v\"\nv = \"-1\"\nz = \"u\"\nu = \"-1\"\n\
        [[contact]]\nname = \"table\"\ngap = \"y - 3*sin(w*t)\"\nimpulse = { v = 1 }\nrestitution = 0.3\n\
        [[contact]]\nname = \"pair\"\ngap = \"z - y\"\nimpulse = { u = 1, v = -1 }\nrestitution = 0.3\n\
        [initial]\ny = 0\nv = 0.03\nz = 0\nu = 0.03\n";
    let model = Model::from_toml(text, "ramp").expect("a valid model");
    let spec = Spec {
        sampling: vec![Sampling::Every(DoubleDouble::from(997.0))],
        ..Spec::until(1e6)
    };
    let run =
        simulate::<f64>(&model, &spec, &mut |_| ControlFlow::Continue(())).expect("a legal start");
    assert_eq!(run.outcome, Outcome::Horizon);
    let samples = &run.samples[0];
    for k in 0..samples.len() {
        let (y, z) = (samples.states[0][k], samples.states[2][k]);
        let table = 3.0 * libm::sin(0.01 * samples.times[k]);
        assert!(
            (y - table).abs() < 1e-11 && (z - y).abs() < 1e-14,
            "{y} {z} {table}"
        );
    }
}

#[test]
fn an_impulse_may_have_any_length() {
    for scale in [1.0, 3.0, 1.0 / 3.0, 1e9, 1e-9, -0.7] {
        let text = format!(
            "[parameters]\nm = 7.3\n[flight]\nx = \"v\"\nv = \"0\"\ny = \"u\"\nu = \"-0.3*y\"\n\
             [[contact]]\ngap = \"y - x\"\nimpulse = {{ v = \"-({scale})\", u = \"({scale})/m\" }}\nrestitution = 0\n\
             [initial]\nx = 0\nv = 0.1\ny = 1\nu = -0.7\n"
        );
        let model = Model::from_toml(&text, "scaled").expect("a valid model");
        let run = simulate::<f64>(&model, &Spec::until(50.0), &mut |_| {
            ControlFlow::Continue(())
        })
        .expect("a legal start");
        assert_eq!(run.counts.accumulations, 0, "{scale}");
        let sticks = |event: &Event<f64>| match event.detail {
            Occurrence::Impact { rate_after, .. } => rate_after == 0.0,
            _ => true,
        };
        assert!(
            run.counts.impacts > 0 && run.events.iter().all(sticks),
            "{scale}"
        );
    }
}

/// Units of length and time change nothing but the numbers.
#[test]
fn results_do_not_depend_on_units() {
    let run = |length: f64, time: f64| {
        let mut chain = stack(&[0.4, 0.5, 0.3], &[1.0, 0.7, 1.9], 0.2);
        chain.gravity = length / (time * time);
        chain.positions.iter_mut().for_each(|x| *x *= length);
        chain.run::<f64>(20.0 * time, vec![Stop::Rest])
    };
    let reference = run(1.0, 1.0);
    assert_eq!(reference.outcome, Outcome::Rest);
    for (length, time) in [
        (1e9, 1.0),
        (1e-9, 1.0),
        (1.0, 1e9),
        (1.0, 1e-9),
        (1e-6, 1e6),
        (1e5, 1e-5),
    ] {
        let scaled = run(length, time);
        assert_eq!(scaled.outcome, Outcome::Rest, "{length} {time}");
        let (a, b) = (scaled.time / time, reference.time);
        assert!((a - b).abs() < 1e-11, "{length} {time}: {a} {b}");
    }
}

/// A stack comes to rest, ends there, and stays there.
/// Chatter within chatter, where each impact of an upper pair is followed by hundreds of the pair below, may take more impacts than
/// the budget has. Until then it loses energy by orders of magnitude; rounding that keeps itself going would not.
fn check_that_it_slows_down(chain: &Chain, run: &Simulation<f64>) -> Result<(), TestCaseError> {
    let midway = chain.energy(&run.events[run.events.len() / 2].state);
    let end = chain.energy(&run.state);
    prop_assert!(end < 0.5 * midway, "{midway:e} -> {end:e} {}", chain.text());
    Ok(())
}

fn check_that_it_comes_to_rest(chain: &Chain) -> Result<(), TestCaseError> {
    let run = chain.run::<f64>(200.0, vec![Stop::Rest]);
    chain.check(&run)?;
    if run.outcome == Outcome::ImpactBudget {
        return check_that_it_slows_down(chain, &run);
    }
    prop_assert_eq!(&run.outcome, &Outcome::Rest, "{}", chain.text());
    let is_zero = |state: &[f64]| state.iter().all(|x| x.abs() < 1e-12);
    prop_assert!(is_zero(&run.state), "{:?} {}", run.state, chain.text());
    // The end is a legal start, and the stack stays there.
    let mut again = chain.clone();
    again.positions = run.state.iter().copied().step_by(2).collect();
    again.velocities = velocities(&run);
    let rest = again.run::<f64>(10.0, vec![]);
    prop_assert_eq!(rest.closed, run.closed);
    prop_assert!(is_zero(&rest.state), "{:?} {}", rest.state, chain.text());
    Ok(())
}

/// Light bodies between heavy ones that meet at one instant, and lose all their rates there.
#[test]
fn squeezed_bodies_come_to_rest() {
    let cases = [
        (
            [
                7.007_717_612_617_739,
                3.232_977_965_131_394,
                5.599_414_536_677_653,
                7.131_118_583_699_611,
            ],
            vec![
                0.591_344_422_054_892_6,
                0.783_171_355_520_266_7,
                0.202_925_025_918_761_02,
                0.362_453_106_118_441,
            ],
            0.426_858_032_802_792_16,
        ),
        (
            [
                8.962_061_879_900_084,
                1.345_054_544_514_771_2,
                0.422_844_896_203_474,
                8.625_554_819_186_402,
            ],
            vec![
                0.170_095_212_473_652_36,
                0.764_350_656_409_174_8,
                0.666_479_157_839_074,
                0.038_382_952_405_289_92,
            ],
            0.263_817_870_295_586_73,
        ),
    ];
    for (masses, restitutions, spacing) in cases {
        check_that_it_comes_to_rest(&stack(&restitutions, &masses, spacing)).unwrap();
    }
}

/// Falling bodies that bounce between each other and would part again, with rates of some 1e-15, but for the floor.
#[test]
fn bodies_that_hardly_part_before_they_fall_on_the_floor_come_to_rest() {
    let masses = [0.2229, 0.8974, 0.2583].map(|inverse: f64| inverse.recip());
    check_that_it_comes_to_rest(&stack(&[0.2305, 0.3764, 0.1408], &masses, 0.41087)).unwrap();
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn stacks_obey_the_laws_and_come_to_rest(
        masses in proptest::collection::vec(0.1_f64..10.0, 4),
        restitutions in proptest::collection::vec(0.0_f64..0.8, 1..=4),
        spacing in 0.0_f64..0.5,
    ) {
        check_that_it_comes_to_rest(&stack(&restitutions, &masses, spacing))?;
    }

    /// Wider: a body may be a thousand times as heavy as its neighbour, and hardly lose anything.
    #[test]
    fn uneven_stacks_obey_the_laws_and_come_to_rest(
        masses in proptest::collection::vec(-1.5_f64..1.5, 6),
        restitutions in proptest::collection::vec(0.0_f64..0.9, 1..=6),
        spacing in prop_oneof![Just(0.0), 0.0_f64..0.5],
    ) {
        let masses: Vec<f64> = masses.iter().map(|&power| libm::exp10(power)).collect();
        check_that_it_comes_to_rest(&stack(&restitutions, &masses, spacing))?;
    }

    #[test]
    fn cradles_obey_the_laws(
        masses in proptest::collection::vec(0.1_f64..10.0, 2..7),
        restitution in 0.0_f64..=1.0,
        steps in proptest::collection::vec(0_u8..3, 7),
        velocities in proptest::collection::vec(-1.0_f64..1.0, 7),
        moreau in any::<bool>(),
    ) {
        let count = masses.len();
        let mut place = 0.0;
        let positions: Vec<f64> = steps[..count].iter().map(|&step| {
            place += f64::from(step) * 0.25;
            place
        }).collect();
        let chain = Chain {
            restitutions: vec![restitution; count - 1],
            velocities: velocities[..count].to_vec(),
            masses,
            positions,
            gravity: 0.0,
            has_floor: false,
            moreau,
        };
        let run = chain.run::<f64>(20.0, vec![]);
        chain.check(&run)?;
    }

    /// A ball in a wedge of two oblique walls that are as slippery as they are hard.
    #[test]
    fn a_ball_in_a_wedge_loses_energy_and_ends_at_its_bottom(
        slopes in (0.2_f64..2.0, 0.2_f64..2.0),
        restitutions in (0.0_f64..0.8, 0.0_f64..0.8),
        start in (-0.3_f64..0.3, 0.7_f64..1.5),
    ) {
        let ((left, right), (x, y)) = (slopes, start);
        let wall = |name: &str, slope: f64, r: f64| format!(
            "[[contact]]\nname = \"{name}\"\ngap = \"y - ({slope:?})*x\"\n\
             impulse = {{ vx = {:?}, vy = 1 }}\nrestitution = {r:?}\n", -slope
        );
        let text = format!(
            "[flight]\nx = \"vx\"\ny = \"vy\"\nvx = 0\nvy = -1\n{}{}[initial]\nx = {x:?}\ny = {y:?}\nvx = 0\nvy = 0\n",
            wall("left", -left, restitutions.0), wall("right", right, restitutions.1),
        );
        let model = Model::from_toml(&text, "wedge").expect("a valid model");
        let spec = Spec {
            stops: vec![Stop::Rest],
            sampling: vec![Sampling::Dense { per_step: 3 }],
            ..Spec::until(400.0)
        };
        let run = simulate::<f64>(&model, &spec, &mut |_| ControlFlow::Continue(())).expect("a legal start");
        prop_assert_eq!(&run.outcome, &Outcome::Rest, "{:?} {}", run.state, text);
        prop_assert!(run.state.iter().all(|x| x.abs() < 1e-9), "{:?} {}", run.state, text);
        let samples = &run.samples[0];
        for k in 0..samples.len() {
            let (x, y) = (samples.states[0][k], samples.states[1][k]);
            prop_assert!(y + left * x >= -1e-12 && y - right * x >= -1e-12, "{x} {y} {text}");
        }
        let mut energy = y;
        for event in &run.events {
            let [_, y, vx, vy] = event.state[..] else { continue };
            let now = 0.5 * (vx * vx + vy * vy) + y;
            prop_assert!(now <= energy + 1e-12, "{energy} {now} {text}");
            energy = now;
        }
    }
}

/// Balls that touch each other at rest, with nothing that presses them together, stay so until one is hit; and leave one by one.
#[test]
fn balls_that_touch_without_force_wait_to_be_hit() {
    for count in 3..6 {
        let mut text = "[flight]\n".to_owned();
        for i in 0..count {
            let _ = writeln!(text, "x{i} = \"v{i}\"\nv{i} = \"-x{i}\"");
        }
        for i in 1..count {
            let below = i - 1;
            let _ = writeln!(
                text,
                "[[contact]]\nname = \"p{i}\"\ngap = \"x{i} - x{below}\"\nimpulse = {{ v{below} = -1, v{i} = 1 }}\n\
                 restitution = 1"
            );
        }
        text += "[initial]\nx0 = -1\nv0 = 0\n";
        for i in 1..count {
            let _ = writeln!(text, "x{i} = 0\nv{i} = 0");
        }
        let model = Model::from_toml(&text, "cradle").expect("a valid model");
        let run = simulate::<f64>(
            &model,
            &Spec::until(2.0),
            &mut |_| ControlFlow::Continue(()),
        );
        let run = run.expect("a motion");
        assert_eq!(run.outcome, Outcome::Horizon);
        assert_eq!(run.counts.impacts, count as u64 - 1);
        assert_eq!(run.counts.releases, 0, "{:?}", run.events);
        let last = (2.0 - std::f64::consts::FRAC_PI_2).sin();
        for i in 0..count {
            let expected = if i == count - 1 { last } else { 0.0 };
            assert!(
                (run.state[2 * i] - expected).abs() < 1e-14,
                "{:?}",
                run.state
            );
        }
    }
}

/// A beam of mass 1 and inertia 1/3 on supports at these arms, under its weight and a load that moves along it.
fn beam(supports: &[f64], load: (f64, &str), restitution: f64, moreau: bool, start: &str) -> Model {
    let (force, place) = load;
    let mut text = if moreau {
        "simultaneous = \"moreau\"\n"
    } else {
        ""
    }
    .to_owned();
    let _ = writeln!(
        text,
        "[flight]\ny = \"v\"\nv = -{}\nth = \"w\"\nw = \"-3*{force:?}*({place})\"",
        1.0 + force
    );
    for (number, arm) in supports.iter().enumerate() {
        let _ = writeln!(
            text,
            "[[contact]]\nname = \"support{number}\"\ngap = \"y + {arm:?}*th\"\nimpulse = {{ v = 1, w = {:?} }}\n\
             restitution = {restitution:?}",
            3.0 * arm
        );
    }
    text += &format!("[initial]\n{start}");
    Model::from_toml(&text, "beam").unwrap_or_else(|errors| panic!("{errors:?}"))
}

/// More supports than a beam needs change nothing of how it lies, and when it tips: the outer ones decide. In between one
/// support carries after the other.
#[test]
fn a_beam_lies_on_three_supports_as_on_two() {
    let start = "y = 0\nv = 0\nth = 0\nw = 0\n";
    let places = [
        "0.4*t - 0.9",
        "0.9*cos(t) + 0.06*t",
        "1.2*sin(0.7*t)*t/5",
        "0.3 + 0.4*t",
    ];
    for (force, place) in [
        (3.0, places[0]),
        (3.0, places[1]),
        (20.0, places[2]),
        (8.0, places[3]),
    ] {
        let run = |supports: &[f64]| {
            let model = beam(supports, (force, place), 0.0, false, start);
            let run = simulate::<f64>(&model, &Spec::until(12.0), &mut |_| {
                ControlFlow::Continue(())
            });
            let run = run.expect("a motion");
            let release = run.events.iter().find(|e| e.kind == EventKind::Release);
            (release.map(|e| e.time), run)
        };
        let (tips, two) = run(&[-1.0, 0.8]);
        let tips = tips.expect("it tips");
        for supports in [
            &[-1.0, 0.1, 0.8][..],
            &[0.8, 0.1, -1.0],
            &[0.1, 0.8, -1.0],
            &[-0.5, 0.8, 0.8, -1.0],
            &[0.8, -1.0, 0.3, -0.2, 0.5],
        ] {
            let (release, run) = run(supports);
            assert!(
                (release.expect("it tips") - tips).abs() < 1e-13,
                "{supports:?} {place}"
            );
            let outcome = (run.outcome.name(), two.outcome.name());
            assert_eq!(outcome.0, outcome.1, "{supports:?} {place}");
            // Until it falls on others: a redundant support that opens and closes again may rebound.
            let falls = (run.events.iter().chain(&two.events))
                .filter(|e| e.kind == EventKind::Impact)
                .map(|e| e.time)
                .fold(12.0, f64::min);
            if falls == 12.0 {
                for (a, b) in run.state.iter().zip(&two.state) {
                    assert!(
                        (a - b).abs() < 1e-11 * b.abs().max(1.0),
                        "{supports:?} {place}"
                    );
                }
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]
    /// It comes to rest on any number of supports, by either law of impact, and stays there.
    #[test]
    fn a_beam_that_falls_on_many_supports_comes_to_rest(
        inner in proptest::collection::vec(-0.9_f64..0.9, 0..4),
        restitution in 0.0_f64..0.7,
        tilt in -0.3_f64..0.3,
        moreau in any::<bool>(),
        doubled in any::<bool>(),
    ) {
        let mut supports = vec![-1.0, 1.0];
        supports.extend(&inner);
        if doubled {
            supports.push(1.0);
        }
        let start = format!("y = 1\nv = 0\nth = {tilt:?}\nw = 0\n");
        let model = beam(&supports, (0.5, "0.2"), restitution, moreau, &start);
        let spec = Spec { stops: vec![Stop::Rest], ..Spec::until(200.0) };
        let run = simulate::<f64>(&model, &spec, &mut |_| ControlFlow::Continue(())).expect("a motion");
        prop_assert_eq!(run.outcome.name(), "rest", "{:?} {:?}", run.outcome, supports);
        prop_assert!(run.state.iter().all(|x| x.abs() < 1e-13), "{:?}", run.state);
        prop_assert!(supports.iter().enumerate().all(|(k, _)| run.closed.contains(k)));
    }
}

/// A sled on any number of feet slides and sticks like a block on one, and as friction written as a sign.
#[test]
fn feet_of_a_sled_share_its_friction() {
    let drives = [
        "0.3*sin(t)",
        "0.25*cos(1.3*t) + 0.1*sin(0.4*t)",
        "0.21*sin(0.7*t) - 0.2*x",
    ];
    for (drive, start) in drives.into_iter().zip([0.1, 0.5, -0.4]) {
        let run = |text: &str| {
            let model =
                Model::from_toml(text, "sled").unwrap_or_else(|errors| panic!("{errors:?}"));
            let run = simulate::<f64>(&model, &Spec::until(25.0), &mut |_| {
                ControlFlow::Continue(())
            });
            let run = run.expect("a motion");
            assert_eq!(run.outcome, Outcome::Horizon, "{text}");
            let at = |name: &str| run.state[model.state_index(name).expect("a state")];
            let kind = |kind: EventKind| {
                let times = run.events.iter().filter(|e| e.kind == kind).map(|e| e.time);
                times.collect::<Vec<f64>>()
            };
            (
                [at("x"), at("u")],
                kind(EventKind::Stick),
                kind(EventKind::Slide),
            )
        };
        let (by_sign, _, slides) = run(&format!(
            "[flight]\nx = \"u\"\nu = \"{drive} - 0.2*sign(u)\"\n[initial]\nx = 0\nu = {start}\n"
        ));
        assert!(slides.len() > 2);
        for feet in [
            &[0.3][..],
            &[-1.0, 1.0],
            &[-1.0, 0.3, 1.0],
            &[1.0, -0.5, -0.5, 0.2],
        ] {
            let mut text = format!(
                "[flight]\ny = \"v\"\nv = -1\nx = \"u\"\nu = \"{drive}\"\nth = \"w\"\nw = 0\n"
            );
            // On one foot it would tip.
            let turns = |arm: f64| if feet.len() == 1 { 0.0 } else { 3.0 * arm };
            for (number, &arm) in feet.iter().enumerate() {
                let _ = writeln!(
                    text,
                    "[[contact]]\nname = \"foot{number}\"\ngap = \"y + {arm:?}*th\"\n\
                     impulse = {{ v = 1, w = {:?} }}\nrestitution = 0\n\
                     friction = {{ coefficient = 0.2, along = {{ u = 1 }} }}",
                    turns(arm)
                );
            }
            text += &format!("[initial]\ny = 0\nv = 0\nx = 0\nu = {start}\nth = 0\nw = 0\n");
            let (end, sticks, _) = run(&text);
            for (a, b) in end.iter().zip(by_sign) {
                assert!(
                    (a - b).abs() < 1e-12,
                    "{feet:?} {drive}: {end:?} {by_sign:?}"
                );
            }
            for slide in &slides {
                assert!(
                    sticks.iter().any(|t| (t - slide).abs() < 1e-12),
                    "{feet:?} {drive}"
                );
            }
        }
    }
}
