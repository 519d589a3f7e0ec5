//! Motion through flights, impacts, chatter, contact and release, by laws. One program, since each would compile the flow
//! anew.

mod any_simulation;
mod backends;
mod chatter_limits;
mod grazes;
mod levels;
mod long_sampling;
mod narrow_bumps;
mod nothing_passed_over;
mod random_models;
mod sections;
mod series_laws;
mod several_releases;
mod shipped_models;
mod singular_points;
mod tables;
mod undefined;
mod valve;
mod variation;
mod verification;
