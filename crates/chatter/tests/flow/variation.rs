//! Columns of derivatives against differences of double-double trajectories, through every phase.

use chatter::flow::{Column, Occurrence, Settings, System, Trajectory};
use chatter::model::Model;
use chatter::numerics::{DoubleDouble, Real};

const VALVE: &str = include_str!("../../../../models/pressure_relief_valve.toml");

/// Forced, with time as a state; wall, impulse and restitution depend on state, time and parameters, and the gap is no
/// coordinate.
const CURVED: &str = r#"
title = "Bead at a curved, moving wall"
[parameters]
omega = 2.8
e = 0.7
a = "e/5"
[flight]
x = "v"
v = "-x - 0.1*v + cos(omega*t)"
[[contact]]
name = "wall"
gap = "0.2 + a*sin(omega*t) - x - a*x^2"
impulse = { v = "1 + x^2" }
restitution = "e/(1 + v^2/10)"
[initial]
x = 0.1
v = 0.3
"#;

fn read(text: &str) -> Model {
    Model::from_toml(text, "test").unwrap_or_else(|errors| panic!("{errors:?}"))
}

fn end<R: Real>(
    system: &System,
    parameters: &[R],
    state: &[R],
    until: f64,
) -> (Vec<R>, Vec<&'static str>) {
    let mut work = system.workspace::<R>(&Settings::default());
    let mut trajectory = Trajectory::start(system, &mut work, parameters, R::ZERO, state).unwrap();
    let mut kinds = Vec::new();
    loop {
        kinds.push(
            match trajectory
                .advance(system, &mut work, R::splat(until))
                .unwrap()
            {
                None => continue,
                Some(Occurrence::Impact { .. }) => "impact",
                Some(Occurrence::Accumulation { .. }) => "accumulation",
                Some(Occurrence::Capture { .. }) => "capture",
                Some(Occurrence::Release { .. }) => "release",
                Some(Occurrence::Section { .. }) => "section",
                Some(Occurrence::Graze { .. }) => "graze",
                Some(Occurrence::Cascade { .. }) => "cascade",
                Some(Occurrence::Ambiguity { .. }) => "ambiguity",
                Some(Occurrence::Horizon) => return (trajectory.state().to_vec(), kinds),
                Some(_) => "corner",
            },
        );
    }
}

/// Compares each column at time `until` with a central difference; returns what happened on the way.
fn check(model: &Model, state: &[f64], until: f64, tolerance: f64) -> Vec<&'static str> {
    const STEP: f64 = 1e-12;
    let n = model.states.len();
    let columns: Vec<Column> = (0..n)
        .map(|_| Column::State)
        .chain((0..model.parameters.len()).map(Column::Parameter))
        .collect();
    let variational = System::with_columns(model, &columns).unwrap();
    let plain = System::new(model).unwrap();
    let parameters = model.parameter_values::<f64>(&[]);
    let mut start = state.to_vec();
    for (index, _) in columns.iter().enumerate() {
        start.extend((0..n).map(|i| f64::from(u8::from(i == index))));
    }
    let (with, kinds) = end(&variational, &parameters, &start, until);
    let (without, _) = end(&plain, &parameters, state, until);
    for (a, b) in with.iter().zip(&without) {
        assert!((a - b).abs() <= 1e-12 * b.abs().max(1.0), "{a} {b}");
    }
    for (index, column) in columns.iter().enumerate() {
        let shifted = |sign: f64| {
            let step = DoubleDouble::from(sign * STEP);
            let mut x: Vec<DoubleDouble> = state.iter().map(|&x| x.into()).collect();
            let values = match *column {
                Column::State => {
                    x[index] += step;
                    model.parameter_values(&[])
                }
                Column::Parameter(p) => {
                    let value = model.parameter_values::<DoubleDouble>(&[])[p];
                    model.parameter_values(&[(p, value + step)])
                }
            };
            end(&plain, &values, &x, until).0
        };
        let (plus, minus) = (shifted(1.0), shifted(-1.0));
        for i in 0..n {
            let difference = ((plus[i] - minus[i]) / DoubleDouble::from(2.0 * STEP)).to_f64();
            let derivative = variational.column(&with, index)[i];
            assert!(
                (derivative - difference).abs() <= tolerance * difference.abs().max(1.0),
                "{column:?} of state {i} at {until}: {derivative}, not {difference}"
            );
        }
    }
    kinds
}

#[test]
fn columns_follow_flights_and_impacts() {
    let valve = read(VALVE);
    let kinds = check(&valve, &[0.003, 0.02, 9.99], 9.0, 1e-9);
    assert!(kinds.len() > 10, "{kinds:?}");
    let kinds = check(&read(CURVED), &[0.1, 0.3, 0.0], 14.0, 1e-9);
    assert!(kinds.len() > 3, "{kinds:?}");
}

#[test]
fn columns_follow_complete_chatter_sticking_and_release() {
    let mut valve = read(VALVE);
    valve.set_parameter("q", "0.0195").unwrap();
    for until in [9.0, 20.0] {
        let kinds = check(&valve, &[0.003, 0.02, 9.99], until, 1e-10);
        assert!(kinds.contains(&"accumulation"), "{kinds:?}");
    }
}

/// A block on a floor with friction: in impacts sliding goes on, or stops.
const SLED: &str = r#"
title = "Block that is thrown off a floor"
[parameters]
A = 1.4
mu = 0.3
[flight]
x = "u"
u = "-0.5*x - 0.1*u + 0.5*cos(t)"
y = "v"
v = "-1 + A*cos(t)"
[[contact]]
name = "floor"
gap = "y"
impulse = { v = 1 }
restitution = 0.5
friction = { coefficient = "mu", along = { u = 1 }, rate = "u" }
[initial]
x = 0.2
u = 0
y = 0
v = 0
"#;

#[test]
fn columns_follow_friction_in_impacts() {
    let model = read(SLED);
    for k in 0..12 {
        let state = [0.2, 0.02 + 0.11 * f64::from(k), 0.3, -0.4, 0.0];
        assert!(check(&model, &state, 2.0, 1e-8).contains(&"impact"));
    }
}

/// Onto and off a Hertzian contact, and through the corner of a root, whose own derivative is infinite there.
#[test]
fn columns_follow_powers_from_where_they_begin() {
    let hertz = |power: f64| {
        read(&format!(
            "[parameters]\nk = 5\nd = 0.3\n[flight]\nx = \"v\"\nv = \"0.5*cos(1.3*t) - 0.2*v - x - k*max(x - d, 0)^{power}\"\n\
             [initial]\nx = 0.1\nv = 0\n"
        ))
    };
    for power in [1.5, 1.25, 2.5, 10.0 / 9.0] {
        let kinds = check(&hertz(power), &[0.1, 0.4, 0.0], 12.0, 1e-9);
        assert!(kinds.contains(&"corner"), "{power}: {kinds:?}");
    }
    let root = read(
        "[parameters]\nk = 0.7\n[flight]\nx = \"v\"\nv = \"-k*sign(x)*sqrt(abs(x)) - 0.1*v\"\n[initial]\nx = 1\nv = 0\n",
    );
    let kinds = check(&root, &[1.0, 0.1], 12.0, 1e-7);
    assert!(kinds.contains(&"corner"), "{kinds:?}");
}

/// Two equal masses under one force, each at a stop of its own, in phase.
fn in_phase(coupling: &str) -> Model {
    read(&format!(
        "[parameters]\nF = 2.0\n[flight]\nx = \"v\"\nv = \"-x - 0.1*v + F*cos(2.1*t) - {coupling}\"\ny = \"w\"\n\
         w = \"-y - 0.1*w + F*cos(2.1*t) + {coupling}\"\nz = \"x - 2*y - z\"\n[[contact]]\nname = \"right\"\ngap = \"0.3 - x\"\n\
         impulse = {{ v = -1 }}\nrestitution = 0.7\n[[contact]]\nname = \"top\"\ngap = \"0.3 - y\"\nimpulse = {{ w = -1 }}\n\
         restitution = 0.7\n[initial]\nx = 0\nv = 0\ny = 0\nw = 0\nz = 0\n"
    ))
}

#[test]
fn columns_follow_flights_that_end_at_one_instant() {
    for coupling in ["0", "0.3*(x - y)"] {
        let kinds = check(&in_phase(coupling), &[0.0; 6], 9.0, 1e-8);
        let impacts = kinds.iter().filter(|&&kind| kind == "impact").count();
        assert!(impacts >= 4, "{kinds:?}");
    }
    // One law of impacts at once is as good as another where none feels another.
    let moreau = in_phase("0");
    let moreau = Model {
        simultaneous: chatter::model::Simultaneous::Moreau,
        ..moreau
    };
    check(&moreau, &[0.0; 6], 9.0, 1e-8);
    // Three balls fall onto one floor at once, the last of them plastic.
    let three = read(
        "[parameters]\ng = 1\n[flight]\na = \"p\"\np = \"-g\"\nb = \"q\"\nq = \"-g - 0.1*q\"\nc = \"r\"\nr = \"-g\"\n\
         [[contact]]\nname = \"a\"\ngap = \"a - 0.1*a^2\"\nimpulse = { p = 1 }\nrestitution = 0.7\n\
         [[contact]]\nname = \"b\"\ngap = \"b\"\nimpulse = { q = 1 }\nrestitution = 0.7\n\
         [[contact]]\nname = \"c\"\ngap = \"c\"\nimpulse = { r = 1 }\nrestitution = 0\n[initial]\na = 1\np = 0\nb = 1\nq = 0\nc = 1\nr = 0\n",
    );
    let (fall, drag) = (core::f64::consts::SQRT_2, 0.1);
    // How far the ball with drag falls in that time.
    let height = fall / drag + (libm::exp(-drag * fall) - 1.0) / (drag * drag);
    let kinds = check(&three, &[1.0, 0.0, height, 0.0, 1.0, 0.0], 2.0, 1e-8);
    assert_eq!(kinds.iter().filter(|&&kind| kind == "impact").count(), 3);
}

/// A nail that a spring holds on a stop feels the blow of a hammer, and comes back to it.
#[test]
fn columns_follow_what_a_closed_contact_feels() {
    let hammer = read(
        "[parameters]\np = 2\n[flight]\nx = \"v\"\nv = \"-x - 0.2*v + 2*cos(1.5*t)\"\ny = \"w\"\nw = \"-4*y - 0.3*w - p\"\n\
         [[contact]]\nname = \"stop\"\ngap = \"y\"\nimpulse = { w = 1 }\nrestitution = 0.3\n\
         [[contact]]\nname = \"hammer\"\ngap = \"x - y + 0.3\"\nimpulse = { v = 1, w = -0.5 }\nrestitution = 0.5\n[initial]\nx = 1\nv = 0\ny = 0\nw = 0\n",
    );
    let mut all = Vec::new();
    for k in 0..4 {
        // The nail falls on its stop from a little above it.
        let state = [1.0 + 0.1 * f64::from(k), -0.2, 0.02, 0.0, 0.0];
        all.extend(check(&hammer, &state, 6.0, 1e-8));
    }
    assert!(all.contains(&"impact"), "{all:?}");
}
