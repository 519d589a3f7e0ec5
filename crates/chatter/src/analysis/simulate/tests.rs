//! Against exact solutions and published numbers.

use super::*;
use crate::flow::Closed;
use crate::numerics::{DoubleDouble, Scalar};

mod edges;

const BALL: &str = "
[parameters]
g = 9.81
r = 0.9
[flight]
y = 'v'
v = '-g'
[[contact]]
name = 'floor'
gap = 'y'
impulse = { v = 1 }
restitution = 'r'
[initial]
y = 1
v = 0
";

const OSCILLATOR: &str = "
[parameters]
omega = 2
sigma = 0
r = 0.8
[flight]
x = 'v'
v = 'cos(omega*t) - x'
[[contact]]
name = 'stop'
gap = 'sigma - x'
impulse = { v = -1 }
restitution = 'r'
[initial]
x = 'sigma'
v = 0
t = 0
";

const VALVE: &str = include_str!("../../../../../models/pressure_relief_valve.toml");

fn model(text: &str, changes: &[(&str, &str)]) -> Model {
    let mut model = Model::from_toml(text, "test").unwrap();
    for (name, value) in changes {
        if model.parameter_index(name).is_some() {
            model.set_parameter(name, value).unwrap();
        } else {
            model.set_initial(name, value).unwrap();
        }
    }
    model
}

fn run<R: Real>(model: &Model, spec: &Spec) -> Simulation<R> {
    simulate(model, spec, &mut |_| ControlFlow::Continue(())).unwrap()
}

fn target(kind: EventKind, at: Option<&str>, count: u64) -> Stop {
    let at = at.map(str::to_owned);
    Stop::Event(EventTarget { kind, at, count })
}

fn accumulations<R: Real>(simulation: &Simulation<R>) -> Vec<&Event<R>> {
    let events = simulation.events.iter();
    events
        .filter(|event| event.kind == EventKind::Accumulation)
        .collect()
}

fn impact_times<R: Real>(simulation: &Simulation<R>) -> Vec<R> {
    let events = simulation.events.iter();
    events
        .filter(|event| event.kind == EventKind::Impact)
        .map(|event| event.time)
        .collect()
}

/// A ball that falls from height h: sqrt(2 h / g) (1 + r) / (1 - r).
#[test]
fn the_ball_comes_to_rest_when_the_formula_says() {
    for (g, r) in [
        ("9.81", "0.5"),
        ("9.81", "0.9"),
        ("9.81", "0.99"),
        ("9.8", "0.5"),
    ] {
        let ball = model(BALL, &[("g", g), ("r", r)]);
        let parameters = ball.parameter_values::<DoubleDouble>(&[]);
        let one = DoubleDouble::ONE;
        let exact = (DoubleDouble::from(2.0) / parameters[0]).sqrt() * (one + parameters[1])
            / (one - parameters[1]);

        let double = run::<f64>(&ball, &Spec::until(200.0));
        let [end] = accumulations(&double)[..] else {
            panic!("one accumulation, not {:?}", double.counts)
        };
        let error = (DoubleDouble::from(end.time) - exact).high().abs();
        assert!(
            error < 1e-14 * exact.high(),
            "g {g}, r {r}: off by {error:e}"
        );
        let Occurrence::Accumulation {
            error: estimate, ..
        } = end.detail
        else {
            unreachable!()
        };
        assert!(
            estimate < 1e-13 * exact.high(),
            "g {g}, r {r}: {estimate:e}"
        );
        assert_eq!(double.state, [0.0, 0.0]);

        let wide = run::<DoubleDouble>(&ball, &Spec::until(200.0));
        let error = (accumulations(&wide)[0].time - exact).high().abs();
        assert!(
            error < 1e-28 * exact.high(),
            "g {g}, r {r}: off by {error:e}"
        );
    }
}

/// DifferentialEquations.jl's page on callback functions, and the example `ballode` of R's deSolve.
#[test]
fn published_accumulation_times() {
    let sciml = model(BALL, &[("g", "9.8"), ("r", "0.5")]);
    let time = accumulations(&run::<f64>(&sciml, &Spec::until(10.0)))[0].time;
    assert!(
        (time / 1.355_261_854_357_876_8 - 1.0).abs() < 1e-15,
        "{time}"
    );
    let desolve = model(BALL, &[("g", "9.8"), ("y", "0"), ("v", "20")]);
    let time = accumulations(&run::<f64>(&desolve, &Spec::until(100.0)))[0].time;
    assert!(
        (time / 40.816_326_530_612_245 - 1.0).abs() < 1e-14,
        "{time}"
    );
}

/// BouncingBallED.ref of the Siconos tutorials.
#[test]
fn the_ball_of_siconos() {
    let simulation = run::<f64>(&model(BALL, &[]), &Spec::until(20.0));
    let reference = [
        0.451_523_640_985_730_8,
        1.264_266_194_760_045,
        1.995_734_493_156_927,
        2.654_055_961_714_119,
        3.246_545_283_415_589,
        3.779_785_672_946_91,
    ];
    for (time, reference) in impact_times(&simulation).iter().zip(reference) {
        // The reference carries the rounding errors of its own event search.
        assert!(
            (time - reference).abs() < 1e-14 * reference,
            "{time} {reference}"
        );
    }
    let end = accumulations(&simulation)[0].time;
    assert!((end / 8.578_949_178_728_887 - 1.0).abs() < 1e-14, "{end}");
}

/// A (1, n) orbit of x'' + x = cos(omega t), x <= sigma: one impact in n periods of the forcing (Budd & Dux 1994).
/// Gives rate of approach V and phase omega t of the impact, for each root of the closed form with V > 0.
fn budd_dux(omega: &str, r: &str, sigma: &str, n: u32) -> Vec<(DoubleDouble, DoubleDouble)> {
    let number = |text: &str| text.parse::<DoubleDouble>().unwrap();
    let one = DoubleDouble::ONE;
    let square = |x: DoubleDouble| x * x;
    let (omega, r, sigma) = (number(omega), number(r), number(sigma));
    let gamma = one / (one - square(omega));
    let period = DoubleDouble::from(2.0 * f64::from(n)) * DoubleDouble::PI / omega;
    let (sine, cosine) = period.sin_cos();
    let rho = (one - r) / omega;
    let c = if (one - cosine).high() < 1e-25 {
        DoubleDouble::ZERO
    } else {
        (one + r) * sine / (one - cosine)
    };
    let two = DoubleDouble::from(2.0);
    let radicand = square(gamma) * square(c) - (square(sigma) - square(gamma)) * square(rho);
    let root = two * radicand.sqrt();
    let mut orbits = Vec::new();
    for root in [root, -root] {
        let rate = (-two * c * sigma + root) / (square(c) + square(rho));
        if rate > DoubleDouble::ZERO {
            let angle = ((sigma + c * rate / two) / gamma).acos();
            // The sine has the sign opposite to that of V / gamma.
            let angle = if gamma > DoubleDouble::ZERO {
                -angle
            } else {
                angle
            };
            orbits.push((rate, angle));
        }
    }
    orbits
}

#[test]
fn periodic_orbits_of_the_impact_oscillator_return() {
    let cases = [
        ("2", "0.8", "0", 1, 6.666_666_7, 0.25),
        ("3.7", "0.8", "0", 2, 0.665_693_352_84, 0.036_660_774_79),
    ];
    for (omega, r, sigma, n, published_rate, published_phase) in cases {
        let [(rate, angle)] = budd_dux(omega, r, sigma, n)[..] else {
            panic!("one root")
        };
        let number = |text: &str| text.parse::<DoubleDouble>().unwrap();
        let text = |x: DoubleDouble| format!("{x:.33}");
        let start = angle / number(omega);
        let rebound = -(rate * number(r));
        let oscillator = model(
            OSCILLATOR,
            &[
                ("omega", omega),
                ("sigma", sigma),
                ("r", r),
                ("v", &text(rebound)),
                ("t", &text(start)),
            ],
        );
        let period = DoubleDouble::from(2.0 * f64::from(n)) * DoubleDouble::PI / number(omega);
        let mut spec = Spec::until(start + period * DoubleDouble::from(1.5));
        spec.impacts = 1;
        let simulation = run::<DoubleDouble>(&oscillator, &spec);
        let impact = &simulation.events[0];
        let Occurrence::Impact { rate_before, .. } = impact.detail else {
            panic!("an impact, not {impact:?}")
        };
        let late = (impact.time - start - period).high();
        assert!(late.abs() < 1e-28, "omega {omega}: late by {late:e}");
        let faster = (rate_before + rate).high();
        assert!(faster.abs() < 1e-28, "omega {omega}: faster by {faster:e}");
        assert!((rate.high() / published_rate - 1.0).abs() < 1e-8, "{rate}");
        // In periods of the forcing.
        let phase = (start / period).high() * f64::from(n);
        let phase = phase - libm::floor(phase);
        assert!((phase - published_phase).abs() < 1e-10, "{phase}");
    }
}

/// Dankowicz & Schilder, Recipes for Continuation (2013), example 15.2; digits as refined with COCO.
#[test]
fn the_orbit_of_coco_returns() {
    let text = "
[flight]
x = 'v'
v = 'cos(t) - 0.1*v - x'
[[contact]]
gap = '1 - x'
impulse = { v = -1 }
restitution = 0.8
[initial]
x = 1
v = -1.3565863501
t = 0.0759521649382
";
    let mut spec = Spec::until(20.0);
    spec.impacts = 1;
    let simulation = run::<f64>(&model(text, &[]), &spec);
    let impact = &simulation.events[0];
    let Occurrence::Impact {
        rate_before,
        rate_after,
        ..
    } = impact.detail
    else {
        panic!("an impact, not {impact:?}")
    };
    let phase = impact.time - 2.0 * core::f64::consts::PI;
    assert!((phase - 0.075_952_164_938_2).abs() < 1e-9, "{phase}");
    assert!(
        (rate_before + 1.695_732_937_6).abs() < 1e-9,
        "{rate_before}"
    );
    assert!((rate_after - 1.356_586_350_1).abs() < 1e-9, "{rate_after}");
    assert_eq!(simulation.outcome, Outcome::ImpactBudget);
}

/// Below the border value q* = 0.02005604... the first chatter sequence is complete, above it is not.
#[test]
fn the_verdict_near_the_border_is_right() {
    for (q, complete) in [
        ("0.0195", true),
        ("0.020056", true),
        ("0.0200561", false),
        ("0.0203", false),
    ] {
        let valve = model(VALVE, &[("q", q)]);
        let mut spec = Spec::until(10.0);
        // The section is crossed once between a lift-off and the next impacts: the sequence lies between two crossings.
        spec.stops = vec![target(EventKind::Section, None, 2)];
        let double = run::<f64>(&valve, &spec);
        let wide = run::<DoubleDouble>(&valve, &spec);
        for (outcome, counts) in [(double.outcome, double.counts), (wide.outcome, wide.counts)] {
            assert_eq!(outcome.name(), "event", "q {q}");
            assert_eq!(counts.accumulations, u64::from(complete), "q {q}");
            assert_eq!(counts.releases, u64::from(complete), "q {q}");
        }
        // An incomplete sequence is integrated to its end.
        assert!(complete || double.counts == wide.counts, "q {q}");
    }
}

/// Accumulation time and pressure to 1e-13, impacts to 1e-12 of double-double.
#[test]
fn the_valve_agrees_with_thirty_digits() {
    let valve = model(VALVE, &[("q", "0.0195")]);
    let mut spec = Spec::until(40.0);
    spec.stops = vec![target(EventKind::Accumulation, Some("seat"), 1)];
    let double = run::<f64>(&valve, &spec);
    let wide = run::<DoubleDouble>(&valve, &spec);
    let (end, exact) = (accumulations(&double)[0], accumulations(&wide)[0]);
    let off = |a: f64, b: DoubleDouble| (DoubleDouble::from(a) - b).high().abs();
    assert!(off(end.time, exact.time) < 1e-13 * end.time);
    assert!(off(end.state[2], exact.state[2]) < 1e-13 * end.state[2]);
    for (a, b) in double.events.iter().zip(&wide.events) {
        if a.kind == EventKind::Impact {
            assert_eq!(b.kind, EventKind::Impact);
            assert!(off(a.time, b.time) < 1e-12);
            assert!(
                a.state
                    .iter()
                    .zip(&b.state)
                    .all(|(&a, &b)| off(a, b) < 1e-12)
            );
        }
    }
}

#[test]
fn phases_counts_and_events_tell_the_same() {
    let valve = model(VALVE, &[("q", "0.0195")]);
    let simulation = run::<f64>(&valve, &Spec::until(40.0));
    let counts = simulation.counts;
    let events = |kind| {
        let of_kind = simulation.events.iter().filter(|e| e.kind == kind);
        of_kind.count() as u64
    };
    assert_eq!(counts.impacts, events(EventKind::Impact));
    assert_eq!(counts.accumulations, events(EventKind::Accumulation));
    assert_eq!(counts.releases, events(EventKind::Release));
    assert_eq!(counts.sections, events(EventKind::Section));
    let phases = &simulation.contact_phases;
    assert_eq!(phases.len() as u64, counts.accumulations);
    let ended = phases.iter().filter(|phase| phase.end.is_some()).count();
    assert_eq!(ended as u64, counts.releases);
    assert_eq!(
        simulation.closed != Closed::NONE,
        counts.releases < counts.accumulations
    );
    // Every flight ends with an impact, or with the run.
    assert!(counts.flights == counts.impacts || counts.flights == counts.impacts + 1);
    let times: Vec<f64> = simulation.events.iter().map(|event| event.time).collect();
    assert!(times.is_sorted());
    assert_eq!(simulation.time, 40.0);
    assert_eq!(simulation.outcome, Outcome::Horizon);
}

/// Samples at equal intervals lie on the parabola; dense ones hold every event twice.
#[test]
fn samples_are_where_they_should_be() {
    let ball = model(BALL, &[("r", "0"), ("g", "8"), ("y", "4")]);
    let mut spec = Spec::until(2.0);
    spec.sampling = vec![
        Sampling::Every("0.01".parse().unwrap()),
        Sampling::Dense { per_step: 3 },
    ];
    let simulation = run::<f64>(&ball, &spec);
    let even = &simulation.samples[0];
    assert_eq!(even.len(), 201);
    for (k, (&time, &y)) in even.times.iter().zip(&even.states[0]).enumerate() {
        assert!((time - k as f64 * 0.01).abs() < 1e-15);
        let exact = (4.0 - 4.0 * time * time).max(0.0);
        assert!((y - exact).abs() < 1e-14, "{time}: {y}");
    }
    // At times of one's own the same states as in equal intervals, to the bit.
    let chosen = [0usize, 0, 1, 37, 99, 100, 101, 150, 200, 200];
    let times =
        chosen.map(|k| "0.01".parse::<DoubleDouble>().unwrap() * DoubleDouble::from(k as f64));
    let mut at = Spec::until(2.0);
    at.sampling = vec![Sampling::At(
        times.iter().copied().chain([3.0.into()]).collect(),
    )];
    let at = &run::<f64>(&ball, &at).samples[0];
    assert_eq!(at.len(), chosen.len());
    for (place, k) in chosen.into_iter().enumerate() {
        assert_eq!(at.times[place], even.times[k]);
        assert_eq!(at.states[0][place], even.states[0][k]);
        assert_eq!(at.states[1][place], even.states[1][k]);
    }
    let dense = &simulation.samples[1];
    assert!(dense.times.is_sorted());
    // The impact at time 1 takes all speed away.
    let at_impact: Vec<f64> = (dense.times.iter().zip(&dense.states[1]))
        .filter(|(time, _)| (**time - 1.0).abs() < 1e-14)
        .map(|(_, &v)| v)
        .collect();
    let [before, after] = at_impact[..] else {
        panic!("{at_impact:?}")
    };
    assert!(
        (before + 8.0).abs() < 1e-13 && after == 0.0,
        "{at_impact:?}"
    );
    let details: Vec<_> = simulation.events.iter().map(|e| e.detail).collect();
    assert!(
        matches!(details[..], [Occurrence::Impact { closes: true, .. }]),
        "{details:?}"
    );
}

/// No impacts are followed to the end of chatter, but samples are those of the motion up to it: flights begin 2^-m before it, with the rate of 2^(1 - m).
#[test]
fn samples_within_chatter_are_in_flight() {
    let ball = model(BALL, &[("r", "0.5"), ("g", "8"), ("y", "4")]);
    let before: Vec<f64> = (0..22).map(|m| 0.5_f64.powi(m)).collect();
    let times: Vec<f64> = before.iter().map(|d| 3.0 - 0.75 * d).collect();
    let mut spec = Spec::until(3.5);
    spec.sampling = vec![
        Sampling::At(times.iter().map(|&time| time.into()).collect()),
        Sampling::Every(DoubleDouble::from(0.5_f64.powi(20))),
    ];
    let simulation = run::<f64>(&ball, &spec);
    assert!(simulation.counts.impacts < 20 && simulation.counts.accumulations == 1);
    let [at, every] = &simulation.samples[..] else {
        panic!("{:?}", simulation.samples.len())
    };
    assert_eq!((at.len(), every.len()), (22, (7 << 19) + 1));
    for (k, d) in before.iter().enumerate() {
        assert_eq!(at.times[k], times[k]);
        // A quarter of this into a flight of half of it.
        let (y, v) = (0.25 * d * d, 0.0);
        assert!((at.states[0][k] - y).abs() < 1e-15 * d.max(1e-3), "{k}");
        assert!((at.states[1][k] - v).abs() < 1e-14, "{k}");
    }
    for (&time, &y) in every.times.iter().zip(&every.states[0]) {
        let left = 3.0 - time;
        assert!(time < 1.0 || left <= 0.0 || y > 0.0 || libm::log2(left).fract() == 0.0);
    }
    // As they are where the run ends there.
    let mut spec = Spec::until(times[16]);
    spec.sampling = Vec::new();
    let there = run::<f64>(&ball, &spec);
    assert_eq!(there.state, [at.states[0][16], at.states[1][16]]);
}

#[test]
fn every_stop_stops() {
    let ball = model(BALL, &[]);
    let with = |change: &dyn Fn(&mut Spec)| {
        let mut spec = Spec::until(100.0);
        change(&mut spec);
        run::<f64>(&ball, &spec)
    };
    let rest = with(&|spec| spec.stops = vec![Stop::Rest]);
    assert_eq!(rest.outcome, Outcome::Rest);
    assert_eq!(rest.time, accumulations(&rest)[0].time);
    let third = with(&|spec| spec.stops = vec![target(EventKind::Impact, Some("floor"), 3)]);
    let Outcome::Event(reached) = &third.outcome else {
        panic!("{:?}", third.outcome)
    };
    assert_eq!(reached.to_string(), "3rd impact at floor");
    assert_eq!(third.counts.impacts, 3);
    let few = with(&|spec| spec.impacts = 5);
    assert_eq!(
        (few.outcome, few.counts.impacts),
        (Outcome::ImpactBudget, 5)
    );
    let mut calls = 0;
    let lively = model(BALL, &[("r", "0.99")]);
    let broken = simulate::<f64>(&lively, &Spec::until(100.0), &mut |_| {
        calls += 1;
        if calls > 1 {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    })
    .unwrap();
    assert_eq!(broken.outcome, Outcome::Interrupted);
    assert!(broken.counts.impacts > 0);
}

#[test]
fn a_wrong_specification_is_told_apart() {
    let ball = model(BALL, &[]);
    let error = |change: &dyn Fn(&mut Spec)| {
        let mut spec = Spec::until(100.0);
        change(&mut spec);
        let result = simulate::<f64>(&ball, &spec, &mut |_| ControlFlow::Continue(()));
        result.unwrap_err().to_string()
    };
    assert_eq!(
        error(&|spec| spec.until = DoubleDouble::ZERO),
        "a run from time 0 cannot end at time 0: the end must be finite and lie after the start"
    );
    assert!(error(&|spec| spec.until = f64::NAN.into()).contains("cannot end"));
    assert!(error(&|spec| spec.impacts = 0).contains("at least one impact"));
    assert!(error(&|spec| spec.tolerance = -1.0).contains("tolerance"));
    let sampling = |sampling: Sampling| error(&|spec| spec.sampling = vec![sampling.clone()]);
    assert!(sampling(Sampling::Dense { per_step: 0 }).contains("one sample"));
    assert!(sampling(Sampling::Every((-0.1).into())).contains("positive"));
    for times in [[1.0, 0.5], [-0.1, 1.0], [0.0, f64::NAN]] {
        let times = times.map(DoubleDouble::from).to_vec();
        assert!(sampling(Sampling::At(times)).contains("in order"));
    }
    let at = |kind, name| error(&|spec| spec.stops = vec![target(kind, Some(name), 1)]);
    assert_eq!(
        at(EventKind::Section, "top"),
        "the model has no section `top`: it has no sections"
    );
    assert_eq!(
        at(EventKind::Impact, "flor"),
        "the model has no contact `flor`: it has `floor`"
    );
}

#[test]
fn a_specification_survives_storage() {
    let mut spec = Spec::until("0.1".parse::<DoubleDouble>().unwrap());
    spec.stops = vec![Stop::Rest, target(EventKind::Release, Some("seat"), 2)];
    spec.sampling = vec![Sampling::Dense { per_step: 8 }, Sampling::Every(0.5.into())];
    let text = serde_json::to_string(&spec).unwrap();
    assert_eq!(serde_json::from_str::<Spec>(&text).unwrap(), spec);
}

/// Samples for a picture begin and end within a step of the window, and resolve even the shortest flights.
#[test]
fn samples_for_a_picture_cover_their_window() {
    let valve = model(VALVE, &[("q", "0.0195")]);
    let mut spec = Spec::until(40.0);
    let resolution = DoubleDouble::from(1e-4);
    let window = Some((DoubleDouble::from(10.0), DoubleDouble::from(12.0)));
    spec.sampling = vec![
        Sampling::Smooth { resolution, window },
        Sampling::Smooth {
            resolution,
            window: None,
        },
    ];
    let simulation = run::<f64>(&valve, &spec);
    let within = &simulation.samples[0];
    assert!(within.times.is_sorted());
    let (first, last) = (within.times[0], within.times[within.len() - 1]);
    assert!(
        first > 9.0 && first <= 10.0 && (12.0..13.0).contains(&last),
        "{first} {last}"
    );
    let all = &simulation.samples[1];
    assert_eq!((all.times[0], all.times[all.len() - 1]), (0.0, 40.0));
    let flights_from = |from: f64, to: f64| {
        let times = all.times.iter();
        times.filter(|&&time| time > from && time < to).count()
    };
    let impacts = impact_times(&simulation);
    assert!(
        impacts
            .windows(2)
            .all(|pair| flights_from(pair[0], pair[1]) >= 3)
    );
}

/// The start is a time of its own run, however many digits it was written with.
#[test]
fn a_sample_may_be_taken_at_any_start() {
    for k in 0..40 {
        let start = 5.0 * (f64::from(k) * 0.618_033_988_749_894_9).fract();
        let text = format!("[flight]\nx = \"cos(t)\"\n[initial]\nx = 0.25\nt = {start:?}\n");
        let model = Model::from_toml(&text, "test").unwrap_or_else(|errors| panic!("{errors}"));
        let written: DoubleDouble = format!("{start:?}").parse().expect("a number");
        let mut spec = Spec::until(start + 1.0);
        spec.sampling = vec![Sampling::At(vec![written, (start + 0.5).into()])];
        let run = simulate::<f64>(&model, &spec, &mut |_| ControlFlow::Continue(()));
        let run = run.unwrap_or_else(|error| panic!("{start}: {error}"));
        assert_eq!(run.samples[0].times[0], start);
    }
}
