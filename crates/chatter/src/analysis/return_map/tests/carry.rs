//! States carried from parameter to parameter in the phase of a forcing; looks and stops that cannot hang.

use super::*;
use crate::analysis::diagram::{DiagramError, Sweep};
use core::ops::ControlFlow;

/// A forced oscillator above a stop, its forcing given as written and by a rate of the phase.
fn forced(force: &str, phase: &str) -> Model {
    let state = if phase.is_empty() {
        String::new()
    } else {
        format!("theta = \"{phase}\"\n")
    };
    let initial = if phase.is_empty() { "" } else { "theta = 0\n" };
    let text = format!(
        "[parameters]\nomega = 2.3\nF = 1\nr = 0.8\n[flight]\nx = \"v\"\nv = \"F*({force}) - 0.1*v - x\"\n{state}\
         [[contact]]\nname = \"stop\"\ngap = \"-x\"\nimpulse = {{ v = -1 }}\nrestitution = \"r\"\n\
         [section.back]\nsurface = \"v\"\ndirection = \"rising\"\n[initial]\nx = 0\nv = -0.5\n{initial}"
    );
    Model::from_toml(&text, "forced").unwrap()
}

fn strobe(period: &str) -> Sampling {
    Sampling::Stroboscopic {
        period: period.to_owned(),
    }
}

fn impacts() -> Sampling {
    Sampling::Event {
        kind: EventKind::Impact,
        at: None,
    }
}

fn back() -> Sampling {
    Sampling::Event {
        kind: EventKind::Section,
        at: Some("back".to_owned()),
    }
}

fn carried(parameter: &str, from: f64, to: f64) -> Spec {
    let mut spec = Spec::new(Range::linear(parameter, from, to, 30), "v", 0, 6);
    spec.observe
        .push(crate::analysis::diagram::Observed::plain("x"));
    spec.start = Begin::CarryUp;
    spec
}

fn rows(model: &Model, sampling: Sampling, spec: &Spec) -> Vec<Row> {
    let map = ReturnMap::new(model, &ReturnSpec::new(sampling)).unwrap();
    diagram(&map, spec, &Threads::new(1)).unwrap()
}

#[test]
fn time_is_carried_in_phase_as_a_state_would_be() {
    let spec = carried("omega", 2.2, 2.4);
    let timed = forced("cos(omega*t)", "");
    let twin = forced("cos(theta)", "omega");
    let both = |a: &Model, b: &Model, look: fn() -> Sampling, spec: &Spec| {
        let (first, second) = (rows(a, look(), spec), rows(b, look(), spec));
        let carried = first.iter().filter(|row| row.start == Started::Carried);
        assert_eq!(carried.count() as u64, spec.sweeps[0].count - 1);
        for (a, b) in first.iter().zip(&second) {
            assert_eq!(a.start, b.start);
            for (x, y) in a.samples.iter().zip(&b.samples) {
                // Rounding errors, which grow on the way; a phase that jumps shows by a tenth.
                assert!(
                    (x - y).abs() < 1e-6,
                    "{:?}, row {}: {x} and {y}",
                    look(),
                    a.row
                );
            }
        }
        first
    };
    for spec in [
        spec.clone(),
        Spec {
            start: Begin::CarryDown,
            ..spec
        },
    ] {
        both(&timed, &twin, || strobe("2*pi/omega"), &spec);
        both(&timed, &twin, || strobe("6*pi/omega"), &spec);
        // A look that has nothing to do with the forcing, and looks at events: the phase is known from the equations.
        both(&timed, &twin, || strobe("1.7"), &spec);
        both(&timed, &twin, impacts, &spec);
        let looked = both(&timed, &twin, back, &spec);
        // In the first period, where time keeps its digits.
        for row in looked.iter().filter(|row| row.start == Started::Carried) {
            assert!((0.0..3.0).contains(&row.origin[2]), "{}", row.origin[2]);
        }
    }
    // Half a period of the forcing's square, which the equations do not show.
    let spec = carried("omega", 2.2, 2.4);
    let (timed, twin) = (
        forced("cos(omega*t)^2", ""),
        forced("cos(theta)^2", "omega"),
    );
    both(&timed, &twin, || strobe("pi/omega"), &spec);
    // Two frequencies in proportion.
    let timed = forced("cos(omega*t) + sin(sqrt(2)*omega*t)", "");
    let twin = forced("cos(theta) + sin(sqrt(2)*theta)", "omega");
    both(&timed, &twin, impacts, &spec);
    // What does not change the frequencies leaves time as it is. This one is chaotic: rounding errors soon show.
    let mut spec = carried("F", 0.8, 1.2);
    spec.sweeps[0].count = 4;
    let timed = forced("cos(omega*t) + cos(0.3*t) + exp(-t)", "");
    let twin = forced("cos(omega*theta) + cos(0.3*theta) + exp(-theta)", "1");
    both(&timed, &twin, impacts, &spec);
    both(&timed, &twin, || strobe("2*pi/omega"), &spec);
}

#[test]
fn a_phase_that_cannot_be_carried_is_refused() {
    let refused = |force: &str, sampling: Sampling, spec: &Spec| {
        let map = ReturnMap::new(&forced(force, ""), &ReturnSpec::new(sampling)).unwrap();
        match Sweep::new(&map, spec) {
            Ok(_) => false,
            Err(DiagramError::PhaseLost(lost)) => {
                assert_eq!((lost.coordinate.as_str(), lost.parameters.len()), ("t", 1));
                true
            }
            Err(other) => panic!("{other}"),
        }
    };
    let over_omega = carried("omega", 2.2, 2.4);
    let over_force = carried("F", 0.8, 1.2);
    for force in [
        "cos(omega*t) + cos(t)",
        "cos(omega*t^2)",
        "exp(-t)*cos(omega*t)",
        "t*sin(omega*t)",
    ] {
        for sampling in [impacts(), back(), strobe("2*pi/omega"), strobe("1")] {
            assert!(refused(force, sampling.clone(), &over_omega), "{force}");
            assert!(!refused(force, sampling, &over_force), "{force}");
        }
    }
    // A look that sees the same equations each time is enough, whatever else is known.
    assert!(!refused(
        "cos(omega*t) + cos(t)",
        strobe("2*pi"),
        &over_force
    ));
    assert!(!refused("cos(3*t + omega)", impacts(), &over_omega));
    // Orbits that start afresh have nothing to lose.
    let fresh = Spec {
        start: Begin::Fresh,
        ..over_omega
    };
    assert!(!refused("cos(omega*t) + cos(t)", impacts(), &fresh));
}

#[test]
fn a_look_without_a_time_ends_at_once_and_alone() {
    let model = forced("cos(omega*t)", "");
    for (period, good) in [
        ("2*pi/(omega - 2)", [false, false, true]),
        ("2*pi*(omega - 2)", [false, false, true]),
        ("exp(1000*(omega - 2.5))", [false, true, false]),
        ("1e5*(omega - 2.5)", [false, false, false]),
    ] {
        let mut spec = carried("omega", 1.0, 3.0);
        (spec.sweeps[0].count, spec.start) = (3, Begin::Fresh);
        let mut returns = ReturnSpec::new(strobe(period));
        let mut model = model.clone();
        model
            .set_parameter("omega", if good[2] { "3" } else { "2.5" })
            .unwrap();
        returns.longest_return = 1e4;
        let Ok(map) = ReturnMap::new(&model, &returns) else {
            continue;
        };
        let rows = diagram(&map, &spec, &Threads::new(1)).unwrap();
        for (row, good) in rows.iter().zip(good) {
            assert_eq!(
                row.outcome != Outcome::NoReturn,
                good,
                "{period}, row {}",
                row.row
            );
            assert_eq!(row.samples.is_empty(), !good);
        }
    }
}

#[test]
fn a_run_that_never_returns_stops_when_told() {
    let model = forced("cos(omega*t)", "");
    let mut returns = ReturnSpec::new(Sampling::Event {
        kind: EventKind::Accumulation,
        at: None,
    });
    (returns.longest_return, returns.most_impacts) = (1e15, u64::MAX);
    let map = ReturnMap::new(&model, &returns).unwrap();
    let spec = Spec::new(Range::linear("omega", 2.2, 2.4, 40), "v", 10, 10);
    let sweep = Sweep::new(&map, &spec).unwrap();
    let stop = AtomicBool::new(false);
    let ending = std::thread::scope(|scope| {
        scope.spawn(|| {
            std::thread::sleep(core::time::Duration::from_millis(50));
            stop.store(true, core::sync::atomic::Ordering::Relaxed);
        });
        let standing = crate::analysis::diagram::Standing::default();
        let threads = Threads::new(2);
        crate::analysis::diagram::run(&map, &sweep, &standing, &threads, &stop, &mut |_| {
            ControlFlow::Continue(())
        })
    });
    assert_eq!(ending, crate::analysis::diagram::Ending::Stopped);
}

/// A mass in a box, both free to travel: only where the mass is in the box matters.
const TRAVELLING: &str = "[parameters]\nomega = 2.3\n[flight]\nX = \"V\"\n\
    V = \"cos(omega*t) + 0.3*cos(2*omega*t) - 0.5*V + 0.2*(x - X)\"\nx = \"v\"\nv = \"-0.2*(x - X) - 0.1*(v - V)\"\n\
    [[contact]]\nname = \"right\"\ngap = \"X + 0.3 - x\"\nimpulse = { v = -1, V = 0.5 }\nrestitution = \"0.6\"\n\
    [[contact]]\nname = \"left\"\ngap = \"x - X + 0.3\"\nimpulse = { v = 1, V = -0.5 }\nrestitution = \"0.6\"\n\
    [initial]\nX = 0\nV = 0\nx = 0.1\nv = 0\n";

#[test]
fn what_travels_is_judged_by_what_matters() {
    let model = Model::from_toml(TRAVELLING, "travelling").unwrap();
    // The same with the place of the mass in the box as its state.
    let text = TRAVELLING
        .replace("(x - X)", "y")
        .replace("x = \"v\"", "y = \"v - V\"")
        .replace("X + 0.3 - x", "0.3 - y")
        .replace("x - X + 0.3", "y + 0.3")
        .replace("X = \"V\"\n", "")
        .replace("X = 0\n", "")
        .replace("x = 0.1", "y = 0.1");
    let twin = Model::from_toml(&text, "twin").unwrap();
    let mut spec = Spec::new(Range::linear("omega", 1.5, 4.0, 30), "V", 600, 200);
    let judged = |model: &Model, spec: &Spec| -> Vec<(Outcome, u64)> {
        let rows = rows(model, strobe("2*pi/omega"), spec);
        rows.iter().map(|row| (row.outcome, row.period)).collect()
    };
    let (first, second) = (judged(&model, &spec), judged(&twin, &spec));
    let periodic = |rows: &[(Outcome, u64)]| rows.iter().filter(|row| row.1 > 0).count();
    assert!(periodic(&second) >= 5);
    let same = first.iter().zip(&second).filter(|(a, b)| a == b).count();
    assert!(same >= 27, "{first:?} {second:?}");
    // The way itself never repeats, nor does it have to.
    spec.observe[0] = crate::analysis::diagram::Observed::plain("X");
    assert_eq!(judged(&model, &spec), first);
}
