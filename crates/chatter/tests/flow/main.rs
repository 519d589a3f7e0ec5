//! Motion through flights, impacts, chatter, contact and release, by laws. One program, since each would compile the flow
//! anew.

mod any_simulation;
mod backends;
mod contacts;
mod corners;
mod events;
mod levels;
mod long_sampling;
mod random_models;
mod series_laws;
mod shipped_models;
mod valve;
mod variation;
mod verification;
