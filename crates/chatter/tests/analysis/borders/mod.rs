//! Border orbits and their normal forms.

mod border;
mod border_errors;
mod border_search;
mod more_states;
