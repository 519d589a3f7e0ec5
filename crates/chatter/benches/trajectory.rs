//! One trajectory of the valve at q = 0.0203, a stable period-one orbit with 34 impacts a period: a million impacts from a
//! model file, interpreted, to rounding error. `cargo bench -p chatter-dynamics --bench trajectory`; time per item is per impact.

use chatter::flow::{Occurrence, Settings, System, Trajectory};
use chatter::model::Model;
use chatter::numerics::{DoubleDouble, Real};
use divan::counter::ItemsCount;

const VALVE: &str = include_str!("../../../models/pressure_relief_valve.toml");

fn main() {
    divan::main();
}

fn impacts<R: Real>(count: u32) -> R {
    let model = Model::from_toml(VALVE, "pressure_relief_valve.toml").expect("a valid model");
    let system = System::new(&model).expect("a valid system");
    let mut work = system.workspace::<R>(&Settings::default());
    let parameters = model.parameter_values::<R>(&[(0, R::splat(0.0203))]);
    let state = model.initial_state(&parameters);
    let mut valve =
        Trajectory::start(&system, &mut work, &parameters, R::ZERO, &state).expect("a legal start");
    let mut left = count;
    while left > 0 {
        let told = valve.advance(&system, &mut work, R::splat(1e30));
        left -= u32::from(matches!(told, Ok(Some(Occurrence::Impact { .. }))));
    }
    valve.time()
}

#[divan::bench(sample_count = 5, sample_size = 1)]
fn million_impacts(bencher: divan::Bencher) {
    let count = 1_000_000;
    bencher
        .counter(ItemsCount::new(count))
        .bench(|| impacts::<f64>(count));
}

#[divan::bench(sample_count = 3, sample_size = 1)]
fn ten_thousand_impacts_to_thirty_digits(bencher: divan::Bencher) {
    let count = 10_000_u32;
    bencher
        .counter(ItemsCount::new(count))
        .bench(|| impacts::<DoubleDouble>(count));
}
