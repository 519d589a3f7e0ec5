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

/// A hammer whose guide rubs, and what it leads: flights of its chatter fall with less acceleration than they rise, by a ratio that all states and
/// parameters have a part in.
#[test]
fn columns_follow_chatter_against_friction_along_the_gap() {
    let hammer = read(
        "[parameters]\nP = 0.52\nf = 0.15\nr = 0.6\n[flight]\ny = \"v\"\nv = \"cos(t) - P - 0.5*y - 0.3*z - f*(1 + z)*sign(v)\"\n\
         z = \"y - 0.2*z + 0.1*sin(t)\"\n[[contact]]\nname = \"anvil\"\ngap = \"y\"\nimpulse = { v = 1 }\n\
         restitution = \"r + 0.1*z\"\n[initial]\ny = 0.2\nv = 0\nz = 0.1\n",
    );
    let until = [4.0, 7.0];
    let all = until.map(|until| check(&hammer, &[0.2, 0.05, 0.1, 0.0], until, 1e-10));
    let counts = |kinds: &[&str]| {
        ["accumulation", "corner", "release"]
            .map(|kind| kinds.iter().filter(|k| **k == kind).count())
    };
    assert_eq!(all.map(|kinds| counts(&kinds)), [[1, 34, 0], [1, 34, 1]]);
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

/// A hammer pushes a bit through the ground, which stops both: the bit sticks, and the hammer is pulled off it in the same instant.
#[test]
fn columns_follow_friction_that_stops_what_a_contact_pushes() {
    for (long, short) in [(1.0, 1.0), (1e-2, 0.1), (30.0, 5.0)] {
        let (speed, force) = (long / short, long / (short * short));
        let text = format!(
            "[parameters]\nP = {:?}\nR = {:?}\n[flight]\nx = \"u\"\nu = \"-P\"\ny = \"v\"\nv = \"-R*sign(v)\"\n\
             [[contact]]\nname = \"anvil\"\ngap = \"y - x\"\nimpulse = {{ u = -1, v = 1 }}\nrestitution = 0.3\n\
             [initial]\nx = 0\nu = 0\ny = 0\nv = 0\n",
            0.2 * force,
            force,
        );
        let model = read(&text);
        let system = System::with_columns(&model, &[Column::State, Column::Parameter(0)]).unwrap();
        let parameters = model.parameter_values::<f64>(&[]);
        // Together they lose 0.6 of their speed in a unit of time.
        let (start, after) = (1.2, 0.5);
        let until = (start / 0.6 + after) * short;
        let mut state = vec![0.0, start * speed, 0.0, start * speed];
        state.extend([0.0, 1.0, 0.0, 1.0]);
        state.extend([0.0; 4]);
        let (found, kinds) = end(&system, &parameters, &state, until);
        assert!(kinds.contains(&"release"), "{kinds:?}");
        // They stop at s / a, at s^2 / 2a, where a is half of P + R; then the hammer is pulled by P alone.
        let stops = start / 0.6;
        let own = [stops + 0.2 * after / 0.6, 0.2 / 0.6, stops, 0.0];
        let sooner = 0.5 * stops / 0.6;
        let place = -0.5 * stops * sooner * 0.6;
        let pull = [
            place - 0.5 * after * after - 0.2 * after * sooner,
            -after - 0.2 * sooner,
            place,
            0.0,
        ];
        for (i, expected) in own.iter().enumerate() {
            let unit = [short, 1.0][i % 2];
            let off = system.column(&found, 0)[i] / unit - expected;
            assert!(off.abs() < 1e-12, "{i}: {off:e} {kinds:?}");
        }
        for (i, expected) in pull.iter().enumerate() {
            let unit = [short * short, short][i % 2];
            let off = system.column(&found, 1)[i] / unit - expected;
            assert!(off.abs() < 1e-12, "{i} by P: {off:e} {kinds:?}");
        }
    }
}

/// Three masses in a row before a wall come to rest on each other, by chatter of all of them: then their places are those of the clearances.
#[test]
fn columns_keep_nothing_of_what_several_contacts_forget() {
    for (long, short) in [(1.0, 1.0), (1e-3, 1e-2), (40.0, 7.0)] {
        let model = read(&row_of_three((long, short)));
        let d = (model.parameters.iter()).position(|parameter| parameter.name == "d");
        let mut columns = vec![Column::State; 6];
        columns.push(Column::Parameter(d.unwrap()));
        let system = System::with_columns(&model, &columns).unwrap();
        let parameters = model.parameter_values::<f64>(&[]);
        let mut state = vec![0.0; 7 * 8];
        for i in 0..6 {
            state[7 * (i + 1) + i] = 1.0;
        }
        let (found, kinds) = end(&system, &parameters, &state, 8.6 * short);
        assert!(kinds.contains(&"accumulation"), "{kinds:?}");
        for column in 0..6 {
            let left = system.column(&found, column);
            assert!(left.iter().all(|x| x.abs() < 1e-13), "{column}: {left:?}");
        }
        let by_clearance = system.column(&found, 6);
        for (i, expected) in [3.0, 0.0, 2.0, 0.0, 1.0, 0.0].into_iter().enumerate() {
            let off = (by_clearance[i] - expected) * [1.0, short][i % 2];
            assert!(off.abs() < 1e-12, "{i}: {by_clearance:?}");
        }
    }
}

fn row_of_three((long, short): (f64, f64)) -> String {
    let rate = 1.0 / short;
    let stiff = rate * rate;
    format!(
        "[parameters]\nF = {:?}\nw = {:?}\nr = 0.5824879979261235\nd = {:?}\nc = {:?}\n[flight]\nx1 = \"v1\"\n\
         v1 = \"F*cos(w*t) - {stiff:?}*x1 - c*v1\"\nx2 = \"v2\"\nv2 = \"(-1.3*{stiff:?}*x2 - c*v2)/0.7\"\nx3 = \"v3\"\n\
         v3 = \"(-1.7*{stiff:?}*x3 - c*v3)/1.4\"\n[[contact]]\nname = \"a\"\ngap = \"d + x2 - x1\"\n\
         impulse = {{ v1 = -1, v2 = \"1/0.7\" }}\nrestitution = \"r\"\n[[contact]]\nname = \"b\"\ngap = \"d + x3 - x2\"\n\
         impulse = {{ v2 = \"-1/0.7\", v3 = \"1/1.4\" }}\nrestitution = \"r\"\n[[contact]]\nname = \"wall\"\ngap = \"d - x3\"\n\
         impulse = {{ v3 = -1 }}\nrestitution = \"0.5*r\"\n[initial]\nx1 = 0\nv1 = 0\nx2 = 0\nv2 = 0\nx3 = 0\nv3 = 0\n",
        0.5712231906925163 * long * stiff,
        0.7846816273883791 * rate,
        0.05118409178102487 * long,
        0.1452488224231075 * rate,
    )
}
