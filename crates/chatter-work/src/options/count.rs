//! Whole numbers on the command line.

use crate::numbers::Digits;
use chatter::analysis::diagram::Threads;

/// A number of things, at least one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Count(pub u64);

impl std::str::FromStr for Count {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.trim().parse() {
            Ok(count) if count > 0 => Ok(Self(count)),
            _ => Err("expected a whole number from 1".to_owned()),
        }
    }
}

/// A whole number, which may be zero, such as a seed or a number of samples to pass over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WholeNumber(pub u64);

impl std::str::FromStr for WholeNumber {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let most = u64::MAX;
        let expected = |_| format!("expected a whole number from 0 to {most}");
        text.trim().parse().map(Self).map_err(expected)
    }
}

/// A number of threads.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ThreadCount(pub usize);

impl std::str::FromStr for ThreadCount {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let most = Threads::MOST;
        match text.trim().parse() {
            Ok(count) if (1..=most).contains(&count) => Ok(Self(count)),
            _ => Err(format!("expected a whole number from 1 to {most}")),
        }
    }
}

/// How many digits are wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Precision(pub Digits);

impl std::str::FromStr for Precision {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let most = Digits::MOST.0;
        match text.trim().parse() {
            Ok(digits) if (1..=most).contains(&digits) => Ok(Self(Digits(digits))),
            _ => Err(format!("expected a whole number from 1 to {most}")),
        }
    }
}
