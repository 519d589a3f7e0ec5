//! Which backend runs the expansions, as the environment says: to compare them, or to do without machine code.

use crate::Refusal;
use chatter::expressions::{Backend, nearest};
use std::ffi::OsStr;

/// The variable that names it.
pub const VARIABLE: &str = "CHATTER_BACKEND";

const NAMES: [(&str, Backend); 2] = [
    ("compiled", Backend::Compiled),
    ("interpreter", Backend::Interpreter),
];

/// Takes what the environment of this process says for all that follows.
///
/// # Errors
/// It names no backend.
pub fn choose() -> Result<(), Refusal> {
    if let Some(name) = std::env::var_os(VARIABLE).filter(|name| !name.is_empty()) {
        named(&name)?.make_default();
    }
    Ok(())
}

fn named(name: &OsStr) -> Result<Backend, Refusal> {
    let name = name.to_string_lossy();
    let known = NAMES.iter().find(|(known, _)| *known == name);
    known.map(|&(_, backend)| backend).ok_or_else(|| {
        let message = format!("{VARIABLE} is {name:?}; expected \"compiled\" or \"interpreter\"");
        let names = NAMES.iter().map(|(name, _)| *name);
        Refusal::input(message).did_you_mean(nearest(&name, names))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_told_apart() {
        let of = |name: &str| named(OsStr::new(name));
        assert!(matches!(of("compiled"), Ok(Backend::Compiled)));
        assert!(matches!(of("interpreter"), Ok(Backend::Interpreter)));
        let refused = of("interpeter").expect_err("a misspelt name");
        let Refusal::Input { message, help } = refused else {
            panic!("another refusal");
        };
        assert!(message.contains("CHATTER_BACKEND") && message.contains("interpeter"));
        assert!(help.is_some_and(|help| help.contains("interpreter")));
    }
}
