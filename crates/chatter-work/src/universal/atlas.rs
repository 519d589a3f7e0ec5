//! The atlas beyond fixed points: a sheet for each part of it.

use super::sheet::{Cell, Sheet};
use chatter::analysis::universal::{Basin, Chaos, EdgeKind, Located, PeriodicWindow, Scaling};
use chatter::numerics::{DoubleDouble, Scalar};

fn mu(event: Option<Located<DoubleDouble>>) -> Cell {
    Cell::Number(event.map(|event| event.mu))
}

/// Windows of periodic orbits.
pub fn periodic(windows: &[PeriodicWindow<DoubleDouble>]) -> Sheet {
    let row = |window: &PeriodicWindow<DoubleDouble>| {
        let (low, high) = window.stable().unzip();
        vec![
            Cell::Whole(window.lap),
            Cell::Whole(window.period() as i64),
            Cell::Laps(window.laps.clone()),
            mu(window.edge(EdgeKind::Fold)),
            mu(window.edge(EdgeKind::DoubledFrom)),
            mu(window.edge(EdgeKind::Collision)),
            mu(window.superstable),
            mu(window.edge(EdgeKind::PeriodDoubling)),
            mu(window.grazing),
            Cell::Number(low),
            Cell::Number(high),
        ]
    };
    Sheet {
        name: "periodic",
        title: "periodic orbits: windows in mu",
        columns: vec![
            "n",
            "period",
            "laps",
            "fold",
            "doubled_from",
            "collision",
            "superstable",
            "period_doubling",
            "grazing",
            "stable_from",
            "stable_to",
        ],
        rows: windows.iter().map(row).collect(),
    }
}

/// Basins of windows.
pub fn basins(basins: &[(PeriodicWindow<DoubleDouble>, Option<Basin>)]) -> Sheet {
    let row = |(window, basin): &(PeriodicWindow<DoubleDouble>, Option<Basin>)| {
        let exact = |value: f64| Cell::Number(value.is_finite().then_some(value.into()));
        let of = |part: fn(&Basin) -> f64| {
            basin
                .as_ref()
                .map_or(Cell::Number(None), |b| exact(part(b)))
        };
        vec![
            Cell::Whole(window.lap),
            Cell::Whole(window.period() as i64),
            Cell::Laps(window.laps.clone()),
            of(|basin| basin.mu),
            of(|basin| basin.from),
            of(|basin| basin.to),
            Cell::Rough(basin.as_ref().map(|basin| basin.share)),
        ]
    };
    Sheet {
        name: "basins",
        title: "basins: immediate basin in z, and the share of the interval around the attractor",
        columns: vec!["n", "period", "laps", "mu", "from", "to", "share"],
        rows: basins.iter().map(row).collect(),
    }
}

/// Chaos next to windows.
pub fn chaos(chaos: &[Chaos<DoubleDouble>]) -> Sheet {
    let row = |chaos: &Chaos<DoubleDouble>| {
        let [gaps, none, fold] = chaos.slopes.map(|slope| Cell::Number(Some(slope)));
        vec![
            Cell::Whole(chaos.lap),
            Cell::Number(Some(chaos.kink_slope)),
            Cell::Name(chaos.regime.name()),
            gaps,
            none,
            fold,
            Cell::Number(chaos.onset),
            Cell::Number(chaos.end),
            Cell::Rough(chaos.share),
        ]
    };
    Sheet {
        name: "chaos",
        title: "chaos: slope s beyond the graze, K at which it is 1/4, 2/3, 1, and the mu between which there is chaos",
        columns: vec![
            "n",
            "kink_slope",
            "regime",
            "slope_gaps",
            "slope_no_windows",
            "slope_fold",
            "onset",
            "end",
            "chaotic_share",
        ],
        rows: chaos.iter().map(row).collect(),
    }
}

/// Ratios from each lap to the next: positions of the superstable points, widths of the windows, distances of the event
/// next to the graze from the graze. K is positive or not.
pub fn ratios(windows: &[super::Window<DoubleDouble>], rises: bool) -> Sheet {
    let parts = |window: &super::Window<DoubleDouble>| {
        let next_to_graze = if rises {
            window.period_doubling
        } else {
            window.fold
        };
        let birth = if rises {
            window.fold
        } else {
            window.period_doubling
        };
        let width = birth.zip(next_to_graze).map(|(a, b)| (b - a).abs());
        let gap = next_to_graze
            .zip(window.grazing)
            .map(|(a, b)| (b - a).abs());
        [window.superstable.map(|mu| mu.abs()), width, gap]
    };
    let laps = windows.windows(2).map(|pair| {
        let (now, next) = (parts(&pair[0]), parts(&pair[1]));
        let ratio = |k: usize| now[k].zip(next[k]).map(|(a, b)| b / a);
        vec![
            Cell::Whole(pair[0].n),
            Cell::Number(ratio(0)),
            Cell::Number(now[1]),
            Cell::Number(ratio(1)),
            Cell::Number(now[2]),
            Cell::Number(ratio(2)),
        ]
    });
    Sheet {
        name: "ratios",
        title: "scaling from n to n + 1",
        columns: vec![
            "n",
            "position_ratio",
            "width",
            "width_ratio",
            "graze_distance",
            "graze_distance_ratio",
        ],
        rows: laps.collect(),
    }
}

/// What the ratios tend to, and what goes with it: name, value and meaning of each.
pub fn limits(scaling: &Scaling<DoubleDouble>) -> [(&'static str, DoubleDouble, &'static str); 7] {
    [
        (
            "position_ratio",
            scaling.position_ratio,
            "limit of the ratio of positions and of widths: eta",
        ),
        (
            "slope_ratio",
            scaling.slope_ratio,
            "ratio of slopes of the map: lambda^2 / eta",
        ),
        (
            "graze_coefficient",
            scaling.graze_coefficient,
            "c of the square root at the end of lap 0",
        ),
        (
            "graze_ratio",
            scaling.graze_ratio,
            "limit of the ratio of distances to the graze: lambda^4 / eta",
        ),
        (
            "graze_distance",
            scaling.graze_distance,
            "that distance tends to this times graze_ratio^n",
        ),
        (
            "kink_slope",
            scaling.kink_slope,
            "slope beyond the graze of lap n + 1, over slope_ratio^n",
        ),
        (
            "last_smooth_birth",
            scaling.last_smooth_birth,
            "the last n, not rounded, whose window begins smoothly",
        ),
    ]
}
