//! The atlas, as far as it was asked for.

use super::atlas::{self, Sheet};
use super::request::{Request, refused};
use super::windows::Window;
use crate::refusal::Refusal;
use chatter::analysis::universal::{PeriodicWindow, Scaling, Universal, UniversalError};
use chatter::numerics::{DoubleDouble, Real};

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
    /// The restitution, the slope or the laps are none.
    pub fn new(request: &Request) -> Result<Self, Refusal> {
        let mut atlas = Self::default();
        let Some(laps) = request.windows else {
            return Ok(atlas);
        };
        let slope: DoubleDouble = request.slope.get();
        let universal = Universal::new(request.restitution.get()).map_err(refused)?;
        let windows = Window::list(&universal, slope, laps).map_err(refused)?;
        let range = || laps.first..=laps.last;
        if request.periods.is_some() || request.basins {
            let periods = request.periods.clone().map_or(1..=1, |periods| periods.0);
            let found = universal
                .periodic_windows(slope, range(), periods)
                .map_err(refused)?;
            atlas.undecided = found.undecided;
            atlas.periodic = found.windows;
        }
        if request.periods.is_some() {
            atlas.sheets.push(atlas::periodic(&atlas.periodic));
        }
        if request.basins {
            let double = Universal::<f64>::new(request.restitution.to_f64()).map_err(refused)?;
            let slope = request.slope.to_f64();
            let basins: Result<Vec<_>, UniversalError> = (atlas.periodic.iter())
                .map(|window| Ok((window.clone(), window.basin(&double, slope)?)))
                .collect();
            atlas.sheets.push(atlas::basins(&basins.map_err(refused)?));
        }
        if request.scaling {
            atlas.scaling = Some(universal.scaling(slope).map_err(refused)?);
            atlas
                .sheets
                .push(atlas::ratios(&windows, slope.to_f64() > 0.0));
        }
        if request.chaos {
            let chaos = universal.chaos(slope, range()).map_err(refused)?;
            atlas.sheets.push(atlas::chaos(&chaos));
        }
        atlas.windows = Some(windows);
        Ok(atlas)
    }
}
