//! Border orbits and their normal forms.

mod border;
mod border_search;
