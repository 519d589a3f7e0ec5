//! `X,Y`: what is drawn across and up; or `drawing`, the mechanism.

use crate::simulation::picture::Axes;

/// A panel.
#[derive(Clone, Debug)]
pub struct AxesOption(pub Axes);

impl std::str::FromStr for AxesOption {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.split(',').map(str::trim).collect::<Vec<_>>()[..] {
            ["drawing"] => Ok(Self(Axes::Drawing)),
            [x, y] if !x.is_empty() && !y.is_empty() => Ok(Self(Axes::Over {
                x: x.to_owned(),
                y: y.to_owned(),
            })),
            _ => Err("expected two names, X,Y, such as t,y1 or y1,y2, or `drawing`".to_owned()),
        }
    }
}
