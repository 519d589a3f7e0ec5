//! Orbits in colours: by attractor, or by the way in which they were carried.

use crate::diagram::tally::{Share, Tally, percent};
use chatter::analysis::diagram::{Start, Sweep, Swept};
use chatter_figures::{Color, PALETTE};

/// What samples are drawn on.
pub struct Layer {
    /// Its name in the legend.
    pub name: String,
    /// Its colour.
    pub color: Color,
}

/// The layers of a figure, and on which of them each row is drawn.
pub struct Layers {
    /// In the order in which they are drawn.
    pub layers: Vec<Layer>,
    of: Of,
}

enum Of {
    One,
    Direction,
    /// By the number of the attractor.
    Attractor {
        numbers: Vec<u32>,
        layers: Vec<usize>,
    },
}

/// What settled to no attractor.
const NONE: Color = Color::rgb(190, 190, 190);

impl Layers {
    /// Of the samples of a diagram over one parameter or initial value.
    pub fn new(sweep: &Sweep, tally: Option<&Tally>) -> Self {
        let spec = sweep.spec();
        let initial = spec
            .sweeps
            .iter()
            .any(|range| range.swept == Swept::Initial);
        let layer = |name: &str, color| Layer {
            name: name.to_owned(),
            color,
        };
        match tally {
            _ if spec.start == Start::CarryBoth => Self {
                layers: vec![
                    layer("upwards", Color::BLUE),
                    layer("downwards", Color::VERMILION),
                ],
                of: Of::Direction,
            },
            Some(tally) if initial || tally.several() => Self::by_attractor(tally),
            _ => Self {
                layers: vec![layer("orbit diagram", Color::NIGHT)],
                of: Of::One,
            },
        }
    }

    /// Of attractors: each of the first has a colour, the others one together.
    pub fn by_attractor(tally: &Tally) -> Self {
        let named = |share: &&Share| (1..=PALETTE.len() as u32).contains(&share.attractor);
        let mut layers: Vec<Layer> = (tally.shares.iter().filter(named))
            .map(|share| Layer {
                name: share.label(),
                color: PALETTE[share.attractor as usize - 1],
            })
            .collect();
        let most = tally.shares.last().map_or(0, |share| share.attractor);
        let mut places = vec![0; most as usize + 1];
        for (place, share) in tally.shares.iter().filter(named).enumerate() {
            places[share.attractor as usize] = place;
        }
        let others = tally
            .shares
            .iter()
            .filter(|share| share.attractor as usize > PALETTE.len());
        let part: f64 = others.clone().map(|share| share.part).sum();
        for share in others.clone() {
            places[share.attractor as usize] = layers.len();
        }
        if part > 0.0 {
            layers.push(Layer {
                name: format!("others, {}", percent(part)),
                color: Color::INK,
            });
        }
        if let Some(share) = tally.shares.iter().find(|share| share.attractor == 0) {
            places[0] = layers.len();
            layers.push(Layer {
                name: share.label(),
                color: NONE,
            });
        }
        Self {
            layers,
            of: Of::Attractor {
                numbers: tally.numbers.clone(),
                layers: places,
            },
        }
    }

    /// Whether they show one thing in two ways, so that much of one lies upon the other.
    pub fn coincide(&self) -> bool {
        matches!(self.of, Of::Direction)
    }

    /// On which layer a row is drawn.
    pub fn of(&self, row: u64) -> usize {
        match &self.of {
            Of::One => 0,
            Of::Direction => (row % 2) as usize,
            Of::Attractor { numbers, layers } => layers[numbers[row as usize] as usize],
        }
    }
}
