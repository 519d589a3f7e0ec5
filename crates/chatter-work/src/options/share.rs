//! `NUMBER/COUNT`: one of several shares.

use chatter::analysis::diagram::Share;

/// A share of a diagram.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ShareOption(pub Share);

/// More machines than there are are a slip of the keyboard.
const MOST_SHARES: u64 = 1_000_000;

impl std::str::FromStr for ShareOption {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let read = || {
            let (number, of) = text.split_once('/')?;
            let (number, of) = (number.trim().parse().ok()?, of.trim().parse().ok()?);
            Share::new(number, of).filter(|share| share.of() <= MOST_SHARES)
        };
        let expected = || {
            format!(
                "expected NUMBER/COUNT, from 1/COUNT to COUNT/COUNT, with {MOST_SHARES} shares at most"
            )
        };
        read().map(Self).ok_or_else(expected)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_read() {
        let read = |text: &str| text.parse::<ShareOption>();
        assert_eq!(read("3/32"), Ok(ShareOption(Share::new(3, 32).unwrap())));
        for wrong in ["0/3", "4/3", "3", "1/0", "a/b", "1/2000000", "-1/3"] {
            assert!(read(wrong).is_err(), "{wrong}");
        }
    }
}
