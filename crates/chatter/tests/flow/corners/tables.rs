//! Tables in models: from a file, from arrays, from Rust code, and the same to the bit; and motions that are known
//! otherwise.

use super::run;
use chatter::analysis::simulate::Outcome;
use chatter::expressions::{CurveKind, Outside};
use chatter::flow::{EventKind, FlowError};
use chatter::model::{Model, ModelBuilder, Table};
use chatter::numerics::{DoubleDouble, Real, Scalar};

const REST: &str = "[flight]\ny = \"lift(y)\"\n[initial]\ny = 0\n";

fn value<R: Real>(model: &Model, at: R) -> R {
    let parameters: Vec<R> = model.parameter_values(&[]);
    model
        .graph
        .evaluate(model.states[0].derivative, &[at], &parameters)
}

fn from_file(keys: &str, data: &str) -> Model {
    let text = format!("[table.lift]\nfile = \"data/cam.csv\"\n{keys}{REST}");
    let mut asked = Vec::new();
    let mut load = |file: &str| {
        asked.push(file.to_owned());
        Ok(data.to_owned())
    };
    let model = Model::from_toml_with(&text, "model.toml", &mut load);
    assert_eq!(asked, ["data/cam.csv"]);
    model.unwrap_or_else(|errors| panic!("{errors}"))
}

#[test]
fn a_table_is_the_same_wherever_its_numbers_stand() {
    let inline = format!(
        "[table.lift]\nx = [0, 0.1, 0.7]\ny = [1, \"-2\", 3e-1]\nkind = \"cubic\"\noutside = \"hold\"\n{REST}"
    );
    let inline = Model::from_toml(&inline, "model.toml").unwrap();
    let keys = "kind = \"cubic\"\noutside = \"hold\"\n";
    let named = format!("{keys}columns = [\"angle\", 1]\n");
    let table =
        Table::new(CurveKind::Cubic, [0.0, 0.1, 0.7], [1.0, -2.0, 0.3]).outside(Outside::Hold);
    let built = ModelBuilder::new()
        .table("lift", table)
        .state("y", "lift(y)", 0)
        .build()
        .unwrap();
    for other in [
        from_file(keys, "0 1\n0.1 -2\n0.7 0.3\n"),
        from_file(&named, "lift;angle\n1;0\n-2;0.1\n0.3;0.7\n"),
        built,
    ] {
        for at in [-1.0, 0.05, 0.1, 0.3, 2.0] {
            let wide = DoubleDouble::from(at);
            assert_eq!(value(&inline, at), value(&other, at));
            assert_eq!(value(&inline, wide), value(&other, wide));
        }
    }
    // A tenth is a tenth to all digits, not the double nearest to it.
    let tenth = DoubleDouble::ONE / DoubleDouble::from(10.0);
    assert_eq!(value(&inline, tenth), DoubleDouble::from(-2.0));
}

#[test]
fn tables_may_be_called_from_every_formula_and_each_other() {
    let text = "[table.lift]\nx = [0, 1]\ny = [0, 2]\n[table.drag]\nx = [0, 4]\ny = [0, 1]\n\
                [parameters]\nc = \"drag(2)\"\n[definitions]\nboth = \"drag(lift(y)) + c\"\n\
                [flight]\ny = \"both\"\n[initial]\ny = \"lift(0.25)\"\n";
    let model = Model::from_toml(text, "model.toml").unwrap_or_else(|errors| panic!("{errors}"));
    let parameters = model.parameter_values::<f64>(&[]);
    assert_eq!(parameters, [0.5]);
    assert_eq!(model.initial_state(&parameters), [0.5]);
    assert_eq!(value(&model, 1.0), 1.0);
}

#[test]
fn a_table_without_a_value_is_told_where_it_is_asked() {
    let text = "[table.lift]\nx = [0, 1]\ny = [0, 2]\n[parameters]\nc = \"lift(1.5)\"\n\
                [flight]\ny = \"c\"\n[initial]\ny = 0\n";
    let errors = Model::from_toml(text, "model.toml").unwrap_err();
    assert_eq!(errors.errors()[0].line_and_column(), (5, 5), "{errors}");
}

/// An oscillator with this force, and tables before it.
fn oscillator(tables: &str, force: &str, start: [f64; 2]) -> String {
    let [y, v] = start;
    format!("{tables}[flight]\ny = \"v\"\nv = \"{force}\"\n[initial]\ny = {y}\nv = {v}\n")
}

/// A cubic polynomial is its own clamped spline: pieces that change within the motion leave no trace in it.
#[test]
fn a_table_of_a_cubic_spring_is_that_spring() {
    let table = "[table.f]\nx = [-3, -1.25, 0, 0.5, 1, 3]\ny = [-30, -3.203125, 0, 0.625, 2, 30]\n\
                 kind = \"cubic\"\nslopes = [28, 28]\n";
    let plain = oscillator("", "-y - y^3", [1.5, 0.25]);
    let tabulated = oscillator(table, "-f(y)", [1.5, 0.25]);
    let (plain_run, run_of_table) = (run::<f64>(&plain, 20.0), run::<f64>(&tabulated, 20.0));
    for (a, b) in plain_run.state.iter().zip(&run_of_table.state) {
        assert!((a - b).abs() < 1e-12, "{a} {b}");
    }
    let (wide, wide_of_table) = (
        run::<DoubleDouble>(&plain, 5.0),
        run::<DoubleDouble>(&tabulated, 5.0),
    );
    for (&a, &b) in wide.state.iter().zip(&wide_of_table.state) {
        assert!((a - b).abs().high() < 1e-27, "{a} {b}");
    }
}

#[test]
fn a_linear_table_is_a_spring_with_a_stop() {
    let table = "[table.f]\nx = [-9, 0.5, 10]\ny = [-9, 0.5, 105]\n";
    let stop = oscillator("", "-y - 10*max(y - 0.5, 0)", [1.0, 0.0]);
    let tabulated = oscillator(table, "-f(y)", [1.0, 0.0]);
    let (stop, tabulated) = (run::<f64>(&stop, 30.0), run::<f64>(&tabulated, 30.0));
    for (a, b) in stop.state.iter().zip(&tabulated.state) {
        assert!((a - b).abs() < 1e-12, "{a} {b}");
    }
}

/// y'' = 1 below zero and -1 above: parabolas, each as long as 2 sqrt(2).
#[test]
fn steps_are_a_relay() {
    let table = "[table.f]\nx = [-100, 0]\ny = [1, -1]\nkind = \"steps\"\noutside = \"hold\"\n";
    let half = 2.0 * 2.0_f64.sqrt();
    for parabolas in 1..12 {
        let begun = (f64::from(parabolas) - 0.5) * half;
        let side = if parabolas % 2 == 0 { 1.0 } else { -1.0 };
        let rest = 0.3;
        let end = run::<f64>(&oscillator(table, "f(y)", [1.0, 0.0]), begun + rest);
        let speed = side * (half / 2.0 - rest);
        let height = side * rest * (half / 2.0 - rest / 2.0);
        assert!((end.state[0] - height).abs() < 1e-12, "{parabolas}");
        assert!((end.state[1] - speed).abs() < 1e-12, "{parabolas}");
    }
}

#[test]
fn leaving_a_table_ends_a_run_at_its_time() {
    let table = "[table.f]\nx = [-1, 0, 2]\ny = [3, 3, 3]\n";
    let text = oscillator(table, "f(y + 0.5)", [0.0, 0.0]);
    match run::<f64>(&text, 5.0).outcome {
        Outcome::Failed(FlowError::OutsideTable {
            time,
            table,
            argument,
        }) => {
            assert!((time - 1.0).abs() < 1e-14, "{time}");
            assert_eq!((&*table, argument), ("f", 2.0));
        }
        other => panic!("{other:?}"),
    }
    let held = text.replace("[flight]", "outside = \"hold\"\n[flight]");
    let end = run::<f64>(&held, 5.0);
    assert_eq!(end.outcome, Outcome::Horizon);
    assert!((end.state[0] - 37.5).abs() < 1e-13);
}

/// A knot of a table is no zero of its argument, nor a whole number of it: what is chosen by the sign of the same function goes on
/// as it is. The same function of a second state that moves alike is another function to the program.
#[test]
fn a_knot_of_a_function_is_no_zero_of_it() {
    const TABLE: &str =
        "[table.st]\nx = [-9, -1, 1, 9]\ny = [-3, -0.8, 1.4, 5]\nkind = \"linear\"\n";
    for force in [
        "st(x) + abs(Y)",
        "floor(x) + abs(Y)",
        "mod(x, 1) + step(Y)*x",
        "st(x) + max(Y, 0)*(1 + v^2)",
        "st(x) + if(Y > 0, x, -0.3)",
        "st(v)*0.2 + 3*st(x)*sign(Y)",
    ] {
        let end = |other: &str| {
            let force = force.replace('Y', other);
            let text = format!(
                "{TABLE}[flight]\nx = \"v\"\nv = \"-({force})\"\ny = \"v\"\n[initial]\nx = 2.3\nv = 0\ny = 2.3\n"
            );
            run::<f64>(&text, 4.0).state
        };
        let (own, other) = (end("x"), end("y"));
        for (a, b) in own.iter().zip(&other) {
            assert!((a - b).abs() < 1e-12, "{force}: {own:?} {other:?}");
        }
    }
}

/// A follower that its cam never lets go of is in contact for ever: at a knot where lift and slope have come to zero, too, and on a
/// dwell that the spline comes to by symmetry.
#[test]
fn a_follower_stays_on_its_cam_where_the_slope_vanishes() {
    let cam = |lift: &str, rest: &str, speed: f64| {
        format!(
            "[table.lift]\nx = [0, 60, 120, 180, 240, 300, 360]\ny = [{lift}]\nkind = \"periodic-cubic\"\n[flight]\ny = \"v\"\n\
             v = \"-100{rest}\"\n[[contact]]\ngap = \"y - lift({speed:?}*t*180/pi)\"\nimpulse = {{ v = 1 }}\nrestitution = 0.3\n\
             [initial]\ny = 0\nv = 0\n"
        )
    };
    for k in 0..12 {
        let speed = 20.0 + 0.37 * f64::from(k);
        for (lift, rest) in [
            ("0, 0.001, 0.006, 0.01, 0.006, 0.001, 0", ""),
            (
                "0, 0.001, 0.006, 0.01, 0.006, 0.001, 0",
                " - 50*y - 2*sign(v)",
            ),
            ("0, 0, 0.006, 0.01, 0.006, 0, 0", ""),
        ] {
            let text = cam(lift, rest, speed);
            let run = run::<f64>(&text, 2.3 * std::f64::consts::TAU / speed);
            assert_eq!(run.outcome, Outcome::Horizon, "{text}");
            let told = [
                EventKind::Impact,
                EventKind::Accumulation,
                EventKind::Release,
            ];
            let met = (run.events.iter())
                .find(|event| (event.detail.kind()).is_some_and(|kind| told.contains(&kind)));
            assert!(met.is_none(), "{met:?} {text}");
        }
    }
}

/// A table of one period that is looked up by `mod`: late as early, though the end of a turn is known to a rounding of the time only.
#[test]
fn a_table_looked_up_by_turns_goes_on_for_ever() {
    let text = |start: f64| {
        format!(
            "[table.F]\nx = [0, 1, 2, 3, 4]\ny = [0, 1.5, 0, -1.5, 0]\n[flight]\nx = \"F(mod(t, 4)) - x\"\n\
             [initial]\nt = {start:?}\nx = 0\n"
        )
    };
    let early = run::<f64>(&text(0.0), 30.0);
    for start in [1e5, 1e6] {
        let late = run::<f64>(&text(start), start + 30.0);
        assert_eq!(late.outcome, Outcome::Horizon);
        let off = late.state[0] - early.state[0];
        assert!(off.abs() < 1e-9, "{start}: {off}");
    }
}

/// Friction by a table of steps holds at its jump as friction by `sign` does, is crossed elsewhere, and ends with the table; so does a
/// preload by a table of places. All the same to the bit, in doubles, as the choices that say it otherwise.
#[test]
fn what_a_table_of_steps_drives_rests_at_its_jump() {
    let stick_slip = |friction: &str, table: &str| {
        format!("{table}[flight]\nx = \"v\"\nv = \"-x - {friction}\"\n[initial]\nx = 0\nv = 0\n")
    };
    let chosen = "(-0.4 + if(v + 0.3 >= 0, -0.1, 0) + step(v - 0.2) + if(v - 0.7 >= 0, -0.1, 0))";
    let looked_up =
        "[table.mu]\nkind = \"steps\"\nx = [-3, -0.5, 0, 0.5, 3]\ny = [-0.4, -0.5, 0.5, 0.4, 7]\n";
    let (chosen, table) = (
        run::<f64>(&stick_slip(chosen, ""), 12.0),
        run::<f64>(&stick_slip("mu(v - 0.2)", looked_up), 12.0),
    );
    assert_eq!(table.outcome, Outcome::Horizon);
    assert_eq!(table.state, chosen.state);
    let times = |run: &chatter::analysis::simulate::Simulation<f64>| -> Vec<(EventKind, f64)> {
        let told = run.events.iter();
        told.map(|event| (event.kind, event.time)).collect()
    };
    assert_eq!(times(&table), times(&chosen));
    // It sticks until the spring is stretched by 0.5, a fifth of a second for each 0.04 of that.
    let [slides, leaves] = [EventKind::Slide, EventKind::Leave].map(|kind| {
        let of = |told: &&(EventKind, f64)| told.0 == kind;
        times(&table).iter().find(of).map(|told| told.1)
    });
    let sticks = 0.5 - 0.5 * (1.0 - (0.2_f64 / 0.5).asin().cos());
    let (slides, leaves) = (slides.expect("a slide"), leaves.expect("an end of it"));
    assert!((slides - (0.2_f64 / 0.5).asin()).abs() < 1e-14);
    assert!((leaves - slides - sticks / 0.2).abs() < 1e-13);

    let kicked = "[table.mu]\nkind = \"steps\"\nx = [-3, 0, 3]\ny = [-0.5, 0.5, 0]\n[flight]\nx = \"v\"\nv = \"4 - mu(v)\"\n\
                  [initial]\nx = 0\nv = 0\n";
    let ended = run::<f64>(kicked, 12.0);
    assert!(matches!(
        ended.outcome,
        Outcome::Failed(FlowError::OutsideTable { .. })
    ));
    assert!((ended.time - 3.0 / 3.5).abs() < 1e-12);

    // Half a unit of preload either way, and friction: ever shorter swings end at zero, where a load of 0.2 leaves it.
    let preload = "[table.seat]\nkind = \"steps\"\noutside = \"hold\"\nx = [-1, 0]\ny = [-0.5, 0.5]\n[flight]\nx = \"v\"\n\
                   v = \"0.2 - seat(x) - 0.1*sign(v)\"\n[initial]\nx = 1\nv = 0\n";
    let rests = run::<f64>(preload, 60.0);
    assert_eq!(rests.outcome, Outcome::Horizon);
    assert_eq!(rests.state[..2], [0.0, 0.0]);
}

/// A damper in steps of its speed: where both sides lead back to a jump it would stay there, whatever the steps are written with.
#[test]
fn a_jump_of_what_is_looked_up_that_holds_the_motion_is_named() {
    let places: Vec<String> = (-10..=10).map(|k| k.to_string()).collect();
    let stairs = format!(
        "[table.K]\nx = [{0}]\ny = [{0}]\nkind = \"steps\"\n",
        places.join(", ")
    );
    let simulated = |tables: &str, force: &str| {
        let text = format!(
            "{tables}[flight]\nx = \"v\"\nv = \"-x - {force}\"\n[initial]\nx = 2\nv = 1.5\n"
        );
        run::<f64>(&text, 20.0)
    };
    let by_steps = simulated(
        "",
        "(step(v - 1) + step(v) + step(v + 1) + step(v + 2) - 3)",
    );
    let slide = (by_steps.events.iter()).find(|event| event.kind == EventKind::Slide);
    let slide = slide.expect("it slides").time;
    for (tables, force) in [
        ("", "floor(v)"),
        ("", "(v - mod(v, 1))"),
        (&stairs[..], "K(v)"),
    ] {
        let run = simulated(tables, force);
        let Outcome::Failed(FlowError::HeldAtLookup { time, argument }) = run.outcome else {
            panic!("{force}: {:?}", run.outcome);
        };
        assert_eq!(argument, "v");
        assert!((time - slide).abs() < 1e-13, "{force}: {time} {slide}");
    }
}
