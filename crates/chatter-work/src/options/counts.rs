//! `FIRST:LAST`: whole numbers.

/// Whole numbers from one to another, both included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Counts {
    /// The first.
    pub first: i64,
    /// The last.
    pub last: i64,
}

/// Nobody reads more rows than this, and a slip such as `0:1e9` should not cost hours.
const MOST_COUNTS: i64 = 1_000_000;

impl std::str::FromStr for Counts {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (first, last) = text
            .split_once(':')
            .ok_or("expected FIRST:LAST, such as 0:60")?;
        let whole = |text: &str| {
            let text = text.trim();
            text.parse::<i64>()
                .map_err(|_| format!("`{text}` is no whole number"))
        };
        let counts = Self {
            first: whole(first)?,
            last: whole(last)?,
        };
        if counts.first > counts.last {
            return Err(format!(
                "the range from {} to {} is reversed: give the smaller number first",
                counts.first, counts.last
            ));
        }
        if counts.last.saturating_sub(counts.first) >= MOST_COUNTS {
            return Err(format!("more than {MOST_COUNTS} numbers"));
        }
        Ok(counts)
    }
}

/// Longest period of orbits that are searched for: each further one takes several times as long.
const LONGEST_PERIOD: i64 = 8;

/// Periods from one to another, both included.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Periods(pub core::ops::RangeInclusive<usize>);

impl std::str::FromStr for Periods {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let Counts { first, last } = text.parse()?;
        if first < 1 || last > LONGEST_PERIOD {
            return Err(format!("periods go from 1 to {LONGEST_PERIOD}"));
        }
        Ok(Self(first as usize..=last as usize))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_are_read() {
        let read = |text: &str| text.parse::<Counts>();
        assert_eq!(read("0:60"), Ok(Counts { first: 0, last: 60 }));
        assert!(read("-3:0").is_ok() && read("4:4").is_ok());
        assert!(read("60:0").unwrap_err().contains("reversed"));
        assert!(read("0").is_err() && read("a:b").is_err() && read("0:1e3").is_err());
        assert!(read("0:99999999").is_err());
        let periods = |text: &str| text.parse::<Periods>();
        assert_eq!(periods("2:4"), Ok(Periods(2..=4)));
        assert!(periods("0:2").is_err() && periods("2:9").is_err() && periods("3:2").is_err());
    }
}
