//! How answers are told in text, for people.

pub mod border;
pub mod diagram;
pub mod periodic;
pub mod simulation;
pub mod universal;
