//! The secret in the address of the page.

use core::fmt;

/// 128 bits that nobody can guess.
#[derive(Clone)]
pub struct Token(String);

impl Token {
    /// A new one, drawn by the operating system.
    ///
    /// # Errors
    /// It has no source of random numbers.
    pub fn drawn() -> std::io::Result<Self> {
        let mut bytes = [0; 16];
        getrandom::fill(&mut bytes).map_err(|error| std::io::Error::other(error.to_string()))?;
        Ok(Self(
            bytes.iter().map(|byte| format!("{byte:02x}")).collect(),
        ))
    }

    /// Whether this is it, in a time that does not tell how much of it is right.
    pub fn is(&self, given: &str) -> bool {
        let (own, given) = (self.0.as_bytes(), given.as_bytes());
        let differing = own.iter().zip(given).fold(0, |all, (a, b)| all | (a ^ b));
        own.len() == given.len() && differing == 0
    }
}

impl fmt::Display for Token {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(&self.0)
    }
}

/// Not in logs.
impl fmt::Debug for Token {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str("Token(..)")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tokens_are_long_differ_and_know_themselves() {
        let [one, other] = [(); 2].map(|()| Token::drawn().unwrap());
        assert_eq!(one.to_string().len(), 32);
        assert_ne!(one.to_string(), other.to_string());
        assert!(one.is(&one.to_string()));
        assert!(!one.is(&other.to_string()));
        assert!(!one.is(""));
        assert!(!one.is(&one.to_string()[..31]));
        assert!(!one.is(&format!("{one}0")));
    }
}
