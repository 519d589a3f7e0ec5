//! Border orbits of models whose force has corners away from where contact ends.

use chatter::analysis::border::*;
use chatter::analysis::border_search::*;
use chatter::model::Model;
use chatter::numerics::{DoubleDouble, Real, Scalar};

const VALVE: &str = include_str!("../../../../../models/pressure_relief_valve.toml");

fn read(text: &str) -> Model {
    Model::from_toml(text, "test").unwrap_or_else(|errors| panic!("{errors:?}\n{text}"))
}

/// A corner that nothing reaches changes nothing.
#[test]
fn a_corner_that_nothing_reaches_changes_no_digit() {
    let near =
        |text: &str| border_near::<DoubleDouble>(&read(text), &BorderSpec::new("q"), 0.02).unwrap();
    let plain = near(VALVE);
    for stop in [
        "max(y1 - 50, 0)",
        "if(y1 > 50, 7, 0)",
        "(abs(y1 - 50) - 50 + y1)",
    ] {
        let spring = format!("+ y3 - {stop}\"");
        let text = VALVE.replacen("+ y3\"", &spring, 1);
        assert_ne!(text, VALVE);
        let more = near(&text);
        let pairs = [
            (more.value.value, plain.value.value),
            (more.exact.slope.value, plain.exact.slope.value),
            (
                more.exact.unfolding_rate.value,
                plain.exact.unfolding_rate.value,
            ),
            (more.exact.amplitude.value, plain.exact.amplitude.value),
        ];
        for (more, plain) in pairs {
            let off = ((more - plain) / plain).abs().to_f64();
            assert!(off < 1e-14, "{stop}: {off:e}");
        }
    }
}

/// A percussive drill whose hammer meets a soft end stop in each period, in these units.
fn drill(stop: &str, (long, short): (f64, f64)) -> String {
    let (stiff, unit) = (1.0 / short / short, long / short / short);
    format!(
        "[parameters]\nA = 1.3\nd = {:?}\ng = {unit:?}\nk = {:?}\nc = {:?}\nw = {:?}\nK = {:?}\n[flight]\nx = \"v\"\n\
         v = \"-g - k*x - c*v - {stop} + g*(A*cos(w*t) + 0.2*sin(2*w*t))\"\n\
         [[contact]]\nname = \"anvil\"\ngap = \"x\"\nimpulse = {{ v = 1 }}\nrestitution = 0.75\n\
         [initial]\nx = {:?}\nv = 0\n",
        0.6 * long,
        0.3 * stiff,
        0.05 / short,
        0.7 / short,
        2.0 * stiff,
        0.1 * long,
    )
}

/// Where the branch of its periodic orbits, which takes derivatives through the corner by saltation, has X = 0.
#[test]
fn a_border_beyond_a_soft_stop_is_that_of_its_branch() {
    for units in [(1.0, 1.0), (1e-3, 1e-2), (1e3, 60.0)] {
        for stop in ["K*max(x - d, 0)", "if(x > d, K*(x - d), 0)"] {
            let model = read(&drill(stop, units));
            let border = border_near::<f64>(&model, &BorderSpec::new("A"), 1.33).unwrap();
            let off = border.value.value - 1.334_566_157_123_947;
            assert!(off.abs() < 1e-12, "{stop} {units:?}: {off:e}");
        }
    }
}

/// Drag that is of another form on the way up than on the way down has its corner where contact ends, and chatter passes it at each
/// flight. Places where an integration by DOP853 that changes the form wherever the rate is zero has u leave u* to the other side.
#[test]
fn drag_has_its_corner_where_contact_ends() {
    let square = |long: f64| (format!("{:?}*v*abs(v)", 0.02 / long), 1.337_189_406_189);
    let linear = |short: f64| (format!("{:?}*abs(v)", 0.02 / short), 1.335_201_617_758);
    for (units, (stop, expected)) in [
        ((1.0, 1.0), square(1.0)),
        ((1e3, 60.0), square(1e3)),
        ((1e-3, 1e-2), linear(1e-2)),
    ] {
        let model = read(&drill(&stop, units));
        let found = borders_in::<f64>(&model, &BorderSpec::new("A"), 1.32, 1.34).unwrap();
        let values: Vec<f64> = found.borders.iter().map(|at| at.value.value).collect();
        let is_there = values.iter().any(|value| (value - expected).abs() < 3e-11);
        assert!(is_there, "{stop} {units:?}: {values:?}");
    }
}

/// A corner that only the release is at, and what is looked up, are said.
#[test]
fn a_corner_at_the_release_point_alone_is_said() {
    let refused = |stop: &str| {
        let model = read(&drill(stop, (1.0, 1.0)));
        borders_in::<f64>(&model, &BorderSpec::new("A"), 1.1, 1.6).expect_err("no border")
    };
    let error = refused("0.1*g*abs(A*cos(w*t) + 0.2*sin(2*w*t) - 1)");
    let is_said = matches!(
        &error,
        BorderError::Lacks { what: Lack::Smooth(corner), .. } if corner.contains("cos")
    );
    assert!(is_said, "{error}");
    assert!(matches!(refused("g*floor(x/d)/50"), BorderError::LooksUp));
}
