//! Samples that are few enough to be drawn one by one.

use super::layers::Layers;
use chatter_figures::{Marker, Markers};
use std::collections::BTreeSet;

/// More discs than these are drawn as a density: files stay small, and what lies upon each other is told apart.
const MOST: usize = 4000;

/// Samples of one orbit nearer to each other than this part of the axis are one disc.
const APART: f64 = 1.0 / 1500.0;

/// How many points a disc is across; where others come to lie upon it, so many that it is seen behind them.
const SIZE: f64 = 1.8;
const BEHIND: f64 = 3.0;

/// The discs of a panel, as long as they are few.
pub struct Discs {
    /// From where to where the vertical axis goes.
    pub extent: (f64, f64),
    /// By layer, at most so many places in all.
    places: Option<Vec<(Vec<f64>, Vec<f64>)>>,
    seen: BTreeSet<(usize, u64, u64)>,
}

impl Discs {
    /// None yet, on so many layers; none at all unless they may be few.
    pub fn new(may_be_few: bool, layers: usize, extent: (f64, f64)) -> Self {
        Self {
            extent,
            places: may_be_few.then(|| vec![Default::default(); layers]),
            seen: BTreeSet::new(),
        }
    }

    /// A sample of a row, on a layer.
    pub fn add(&mut self, layer: usize, (row, x, y): (u64, f64, f64)) {
        let (low, high) = self.extent;
        let (Some(places), true) = (&mut self.places, (low..=high).contains(&y)) else {
            return;
        };
        let place = ((y - low) / (high - low) / APART) as u64;
        if self.seen.insert((layer, row, place)) {
            places[layer].0.push(x);
            places[layer].1.push(y);
        }
        if self.seen.len() > MOST {
            self.places = None;
            self.seen.clear();
        }
    }

    /// As layers of the panel; none where there are too many.
    pub fn markers(self, layers: &Layers) -> Option<Vec<Markers>> {
        let markers = self.places?.into_iter().zip(&layers.layers);
        let markers = markers.enumerate().map(|(place, ((x, y), layer))| {
            let is_behind = layers.coincide() && place == 0;
            Markers::new(x, y)
                .marker(Marker::Disc)
                .size(if is_behind { BEHIND } else { SIZE })
                .color(layer.color)
                .label(&layer.name)
        });
        Some(markers.collect())
    }
}
