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

/// The name that is probably meant: a like one, else the shortest that has this one in it.
pub fn suggest(name: &str) -> Option<String> {
    let names = || all().map(|shipped| shipped.name);
    let lower = name.to_lowercase();
    let holding = names().filter(|known| !lower.is_empty() && known.contains(&lower));
    nearest(name, names()).or_else(|| holding.min_by_key(|known| known.len()).map(str::to_owned))
}
