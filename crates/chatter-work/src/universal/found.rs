//! The atlas, as far as it was asked for.

use super::atlas;
use super::request::{Request, refused};
use super::sheet::Sheet;
use super::windows::Window;
use crate::observer::Observer;
use crate::parallel;
use crate::refusal::Refusal;
use chatter::analysis::universal::{PeriodicWindow, Scaling, Universal};
use chatter::numerics::{DoubleDouble, Real};
use std::sync::atomic::{AtomicUsize, Ordering};

/// What was asked for of the atlas, in double-double whatever the digits: in doubles mu would lose some where laps are long.
#[derive(Default)]
pub struct Atlas {
    /// Windows of fixed points.
    pub windows: Option<Vec<Window<DoubleDouble>>>,
    /// What these tend to.
    pub scaling: Option<Scaling<DoubleDouble>>,
    /// Windows of periodic orbits.
    pub periodic: Vec<PeriodicWindow<DoubleDouble>>,
    /// All else, as tables.
    pub sheets: Vec<Sheet>,
    /// Intervals of mu that may hold windows of periodic orbits and were given up.
    pub undecided: usize,
}

impl Atlas {
    /// Computes it.
    ///
    /// # Errors
    /// The restitution, the slope or the laps are none, or the observer stopped the work.
    pub fn new(request: &Request, observer: &dyn Observer) -> Result<Self, Refusal> {
        let mut atlas = Self::default();
        let Some(laps) = request.windows else {
            return Ok(atlas);
        };
        let slope: DoubleDouble = request.slope.get();
        let universal = Universal::new(request.restitution.get()).map_err(refused)?;
        let windows = Window::list(&universal, (slope, None), laps).map_err(refused)?;
        let periods = match (&request.periods, request.basins) {
            (Some(periods), _) => periods.0.clone().collect(),
            (None, true) => vec![1],
            (None, false) => Vec::new(),
        };
        let steps = Steps {
            total: periods.len() + usize::from(request.basins) + chaotic_laps(request).count(),
            done: AtomicUsize::new(0),
            observer,
        };
        let found = steps.each(&periods, |&period| {
            universal
                .periodic_windows(slope, laps.first..=laps.last, period..=period)
                .map_err(refused)
        })?;
        for found in found {
            atlas.undecided += found.undecided;
            atlas.periodic.extend(found.windows);
        }
        atlas
            .periodic
            .sort_by_key(|window| (window.lap, window.period()));
        if request.periods.is_some() {
            atlas.sheets.push(atlas::periodic(&atlas.periodic));
        }
        if request.basins {
            let double = Universal::<f64>::new(request.restitution.to_f64()).map_err(refused)?;
            let slope = request.slope.to_f64();
            let basins = parallel::each(&atlas.periodic, observer.stop(), |window| {
                Ok((
                    window.clone(),
                    window.basin(&double, slope).map_err(refused)?,
                ))
            })?;
            steps.advance();
            atlas.sheets.push(atlas::basins(&basins));
        }
        if request.scaling {
            atlas.scaling = Some(universal.scaling(slope).map_err(refused)?);
            atlas
                .sheets
                .push(atlas::ratios(&windows, slope.to_f64() > 0.0));
        }
        if request.chaos {
            let laps: Vec<i64> = chaotic_laps(request).collect();
            let chaos = steps.each(&laps, |&lap| {
                universal.chaos(slope, lap..=lap).map_err(refused)
            })?;
            atlas.sheets.push(atlas::chaos(&chaos.concat()));
        }
        atlas.windows = Some(windows);
        Ok(atlas)
    }
}

/// The laps beside which chaos is looked for.
fn chaotic_laps(request: &Request) -> impl Iterator<Item = i64> {
    let laps = request.windows.filter(|_| request.chaos);
    laps.into_iter().flat_map(|laps| laps.first..=laps.last)
}

/// Parts of the work, told one by one.
struct Steps<'a> {
    total: usize,
    done: AtomicUsize,
    observer: &'a dyn Observer,
}

impl Steps<'_> {
    fn advance(&self) {
        let done = self.done.fetch_add(1, Ordering::Relaxed) + 1;
        self.observer
            .progress(done as f64 / self.total as f64, &|| "atlas".to_owned());
    }

    fn each<P: Sync, T: Send>(
        &self,
        pieces: &[P],
        work: impl Fn(&P) -> Result<T, Refusal> + Sync,
    ) -> Result<Vec<T>, Refusal> {
        parallel::each(pieces, self.observer.stop(), |piece| {
            let made = work(piece)?;
            self.advance();
            Ok(made)
        })
    }
}
