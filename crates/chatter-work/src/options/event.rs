//! What ends a run before its time is over.

use super::Count;
use chatter::analysis::simulate::{EventKind, EventTarget, Stop};
use chatter::expressions::nearest;

/// `KIND[:NAME][=COUNT]`, or `rest`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StopOption(pub Stop);

const REST: &str = "rest";

impl std::str::FromStr for StopOption {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (event, count) = match text.split_once('=') {
            Some((event, count)) => {
                let Count(count) = count
                    .parse()
                    .map_err(|error| format!("`{count}` is no count: {error}"))?;
                (event.trim(), count)
            }
            None => (text.trim(), 1),
        };
        let (kind, at) = match event.split_once(':') {
            Some((kind, name)) => (kind, Some(name.to_owned())),
            None => (event, None),
        };
        if kind == REST {
            return if event == text.trim() && at.is_none() {
                Ok(Self(Stop::Rest))
            } else {
                Err("`rest` takes neither a name nor a count".to_owned())
            };
        }
        let Some(kind) = EventKind::ALL
            .into_iter()
            .find(|known| known.name() == kind)
        else {
            let names = || EventKind::ALL.iter().map(|kind| kind.name()).chain([REST]);
            let known: Vec<&str> = names().collect();
            let hint = match nearest(kind, names()) {
                Some(name) => format!("; did you mean `{name}`?"),
                None => String::new(),
            };
            return Err(format!(
                "unknown event `{kind}`: expected one of {}{hint}",
                known.join(", ")
            ));
        };
        Ok(Self(Stop::Event(EventTarget { kind, at, count })))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stops_are_read() {
        let read = |text: &str| text.parse::<StopOption>().map(|stop| stop.0);
        let target = |kind, at: Option<&str>, count| {
            let at = at.map(str::to_owned);
            Ok(Stop::Event(EventTarget { kind, at, count }))
        };
        assert_eq!(read("rest"), Ok(Stop::Rest));
        assert_eq!(read("impact"), target(EventKind::Impact, None, 1));
        assert_eq!(
            read("section:closing=12"),
            target(EventKind::Section, Some("closing"), 12)
        );
        assert!(read("rest=2").is_err() && read("impact=0").is_err() && read("impact=x").is_err());
        assert!(
            read("relase")
                .unwrap_err()
                .ends_with("did you mean `release`?")
        );
    }
}
