//! The models that come with the program.

use chatter::expressions::nearest;

/// Name and text of each, by name.
const MODELS: &[(&str, &str)] = include!(concat!(env!("OUT_DIR"), "/shipped.rs"));

/// A model that comes with the program.
#[derive(Clone, Copy)]
pub struct Shipped {
    /// What to call it on the command line.
    pub name: &'static str,
    /// Its file.
    pub text: &'static str,
}

/// All of them, by name.
pub fn all() -> impl Iterator<Item = Shipped> {
    MODELS.iter().map(|&(name, text)| Shipped { name, text })
}

/// The one called `name`.
pub fn find(name: &str) -> Option<Shipped> {
    all().find(|shipped| shipped.name == name)
}

/// The name that is probably meant.
pub fn suggest(name: &str) -> Option<String> {
    nearest(name, MODELS.iter().map(|&(known, _)| known))
}
