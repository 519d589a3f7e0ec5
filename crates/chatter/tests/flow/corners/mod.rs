//! Equations that change their form: surfaces, sliding, tables.

mod asked;
mod beside_gaps;
mod cut_flights;
mod held_on_one_side;
mod jumps;
mod kept;
mod leg_with_stop;
mod many_frictions;
mod nested;
mod piecewise;
mod plane_friction;
mod powers;
mod preloaded;
mod roots;
mod sizes;
mod soft_ground;
mod table_ends;
mod tables;
mod tracks;
mod valves;

use chatter::analysis::simulate::{Simulation, Spec, simulate};
use chatter::model::Model;
use chatter::numerics::Real;
use std::ops::ControlFlow;

/// What a model does from its initial state until a time.
fn run<R: Real>(text: &str, until: f64) -> Simulation<R> {
    let model = Model::from_toml(text, "model.toml").unwrap_or_else(|errors| panic!("{errors}"));
    simulate::<R>(&model, &Spec::until(until), &mut |_| {
        ControlFlow::Continue(())
    })
    .unwrap_or_else(|error| panic!("{error:?}"))
}
