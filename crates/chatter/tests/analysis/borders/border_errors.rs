//! Error estimates of border orbits: no choice that should not matter changes a number by more than they say.

use chatter::analysis::border::*;
use chatter::analysis::border_search::*;
use chatter::model::Model;
use chatter::numerics::{DoubleDouble, Real, Scalar};

const MODELS: [(&str, &str, f64); 8] = [
    (
        include_str!("../../../../../models/pressure_relief_valve.toml"),
        "q",
        0.02,
    ),
    (
        include_str!("../../../../../models/pressure_relief_valve.toml"),
        "r",
        0.8,
    ),
    (
        include_str!("../../../../../models/impact_oscillator.toml"),
        "sigma",
        0.1234,
    ),
    (
        include_str!("../../../../../models/impact_oscillator.toml"),
        "sigma",
        0.777,
    ),
    (
        include_str!("../../../../../models/impact_oscillator.toml"),
        "omega",
        0.34,
    ),
    (
        include_str!("../../../../../models/cam_follower.toml"),
        "speed",
        622.0,
    ),
    (
        include_str!("../../../../../models/linear_impacting_system.toml"),
        "r",
        0.848,
    ),
    (
        include_str!("../../../../../models/bouncing_ball_on_table.toml"),
        "r",
        0.275,
    ),
];

/// An estimate is no bound.
const LARGEST_RATIO: f64 = 3.0;

fn estimates(border: &Border<DoubleDouble>) -> Vec<Estimate<DoubleDouble>> {
    let exact = &border.exact;
    let lists = [
        &exact.covector,
        &exact.first_impact_by_upsilon,
        &exact.first_impact_by_parameter,
    ];
    [
        border.value,
        border.period,
        exact.slope,
        exact.unfolding_rate,
        exact.amplitude,
        exact.covector_parameter,
    ]
    .into_iter()
    .chain(lists.into_iter().flatten().copied())
    .collect()
}

/// The local coordinate at an impact and at rest are functions of their own, and so are their extrapolations with more or
/// fewer ratios: in longer numbers, since there is no computation in shorter ones.
#[test]
fn errors_cover_what_choices_change() {
    let mut compared = 0;
    for (text, parameter, near) in MODELS {
        let model = Model::from_toml(text, "test").unwrap();
        let mut all = Vec::new();
        for coordinate in [LocalCoordinate::AtImpact, LocalCoordinate::AtRest] {
            for orders in [None, Some(14)] {
                let mut spec = BorderSpec::new(parameter);
                spec.coordinate = coordinate;
                spec.extrapolation.orders = orders;
                all.push(estimates(
                    &border_near::<DoubleDouble>(&model, &spec, near).unwrap(),
                ));
            }
        }
        for other in &all[1..] {
            for (place, (a, b)) in all[0].iter().zip(other).enumerate() {
                let off = (a.value - b.value).abs().to_f64();
                compared += usize::from(off > 0.0);
                assert!(
                    off <= LARGEST_RATIO * (a.error + b.error),
                    "{parameter} {place}: {off:e} {:e} {:e}",
                    a.error,
                    b.error
                );
            }
        }
    }
    // Equal bits would say nothing.
    assert!(compared > 8 * MODELS.len(), "{compared}");
}
