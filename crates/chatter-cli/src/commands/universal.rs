//! `chatter universal`: the universal map of chatter near a border orbit.

use crate::failure::{self, Failure};
use crate::numbers::Digits;
use crate::options::{Counts, Decimal, FigureFile, Periods, Precision, SweepOption, TableFile};
use crate::terminal::{self, Style};
use crate::universal::atlas::{self, Sheet};
use crate::universal::{Findings, UniversalJob, Window, account, document, picture, table};
use chatter::analysis::diagram::{self, Exponent, Spec, Start, Threads};
use chatter::analysis::universal::{
    Argument, PeriodicWindow, Scaling, Universal, UniversalError, UniversalMap,
};
use chatter::numerics::{DoubleDouble, Real};
use chatter_io::figures::{Figure, Sharing};
use clap::Args;

const EXAMPLES: &str = "\
EXAMPLES
  chatter universal --restitution 0.8
  chatter universal --restitution 0.8 --digits 30
  chatter universal --restitution 0.8 --at 0.05,1e-3,2e-5 --json
  chatter universal --restitution 0.8 --slope 1 --windows 0:60 --out windows.csv
  chatter universal --restitution 0.8 --slope 1 --windows 8:12 --periods 1:3 --basins --scaling --chaos
  chatter universal --restitution 0.8 --slope 1 --sweep mu=0:0.05:4000 --plot fig3.png
  chatter universal --restitution 0.8 --slope 1 --sweep mu=0.01:0.05:2000 --windows 0:20 --lyapunov --plot atlas.svg
  chatter universal --restitution 0.8 --slope 1 --cobweb mu=0.02 --plot cobweb.svg
  chatter universal --restitution 0.8 --plot fig2.svg

The map is z -> Upsilon(K z + mu); mu and K of a model come from `chatter border`. Its parameters are called mu and slope.

JSON
  One document: restitution, chatter_fixed_point (u*), lambda, eta, exponent, lap_end (x_e), lap_begin (eta x_e); with
  --at values, a list of {x, upsilon, derivative, n, u1}; with --windows slope and windows, a list of {n, fold,
  period_doubling, superstable, grazing} in mu, null where there is none; with --sweep slope and columns, a list of {mu,
  outcome, period, exponent}. --periods adds periodic, a list of {n, period, laps, fold, doubled_from, collision,
  superstable, period_doubling, grazing, stable_from, stable_to}, and undecided, a number of intervals of mu given up;
  --basins adds basins, a list of {n, period, laps, mu, from, to, share} in z, null where unbounded; --scaling adds
  scaling, the limits, and ratios, a list over n; --chaos adds chaos, a list of {n, kink_slope, regime, slope_gaps,
  slope_no_windows, slope_fold, onset, end, chaotic_share}. With more than 17 digits each number has a twin in decimals
  as text, under its name with `_digits` at the end. Infinite derivatives (at a lap's end) are null.";

/// Evaluate the universal map of chatter: constants, Upsilon, windows, orbit diagrams
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// Coefficient of restitution, between 0 and 1
    #[arg(long, value_name = "R", allow_hyphen_values = true)]
    restitution: Decimal,

    /// Evaluate Upsilon at these x
    #[arg(
        long,
        value_name = "X,X,…",
        value_delimiter = ',',
        allow_hyphen_values = true
    )]
    at: Vec<Decimal>,

    /// Slope K of the map
    #[arg(
        long,
        value_name = "K",
        default_value = "1",
        allow_hyphen_values = true
    )]
    slope: Decimal,

    /// List fold, period doubling, superstable and grazing mu of the fixed points for these n
    #[arg(long, value_name = "FIRST:LAST", allow_hyphen_values = true)]
    windows: Option<Counts>,

    /// List the windows of orbits with these periods too, whose critical points lie on the laps of --windows
    #[arg(long, value_name = "FIRST:LAST", requires = "windows")]
    periods: Option<Periods>,

    /// Find the basin of each window (of fixed points, unless --periods says more)
    #[arg(long, requires = "windows")]
    basins: bool,

    /// List the ratios of positions and widths of windows from n to n + 1, and their limits
    #[arg(long, requires = "windows")]
    scaling: bool,

    /// List where there is chaos next to each window, and for which K
    #[arg(long, requires = "windows")]
    chaos: bool,

    /// Compute an orbit diagram over mu (or slope)
    #[arg(long, value_name = "NAME=LOW:HIGH:COUNT", allow_hyphen_values = true)]
    sweep: Option<SweepOption>,

    /// Offset mu of the map where it is not swept
    #[arg(
        long,
        value_name = "MU",
        default_value = "0",
        allow_hyphen_values = true
    )]
    mu: Decimal,

    /// Iterates that are passed over for each value of a sweep
    #[arg(long, value_name = "N", default_value_t = 500, requires = "sweep")]
    transient: u64,

    /// Iterates that are kept for each value of a sweep
    #[arg(long, value_name = "N", default_value_t = 500, requires = "sweep")]
    keep: u64,

    /// Compute Lyapunov exponents too
    #[arg(long, requires = "sweep")]
    lyapunov: bool,

    /// Draw the map, the diagonal and an orbit between them for this mu
    #[arg(
        long,
        value_name = "mu=MU",
        requires = "plot",
        allow_hyphen_values = true
    )]
    cobweb: Option<CobwebOption>,

    /// Write windows, values or the samples of the sweep as a table, .csv or .npz
    #[arg(long, value_name = "FILE")]
    out: Option<TableFile>,

    /// Draw the orbit diagram (with --windows over it), the cobweb, or Upsilon: .svg, .png or .pdf
    #[arg(long, value_name = "FILE")]
    plot: Option<FigureFile>,

    /// Digits of the numbers in the output, up to 30; above 17 the computation is done with more digits
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    digits: Option<Precision>,

    /// Print one JSON document instead of text
    #[arg(long)]
    json: bool,
}

/// `mu=VALUE`.
#[derive(Clone, Copy, Debug)]
pub struct CobwebOption(Decimal);

impl std::str::FromStr for CobwebOption {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once('=') {
            Some((name, value)) if name.trim() == "mu" => value.parse().map(Self),
            _ => Err("expected mu=VALUE, such as mu=0.02".to_owned()),
        }
    }
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<u8, Failure> {
    let digits = arguments
        .digits
        .map_or(Digits::DOUBLE, |precision| precision.0);
    let text = if digits.fit_double() {
        find::<f64>(arguments, digits)?
    } else {
        find::<DoubleDouble>(arguments, digits)?
    };
    terminal::print(&text).map_err(Failure::Output)?;
    Ok(failure::SUCCESS)
}

fn find<R: Real + Argument<Real = R>>(
    arguments: &Arguments,
    digits: Digits,
) -> Result<String, Failure> {
    let universal = Universal::<R>::new(arguments.restitution.get()).map_err(refused)?;
    let slope: R = arguments.slope.get();
    let double = Universal::<f64>::new(arguments.restitution.to_f64()).map_err(refused)?;
    let map = UniversalMap::new(
        double.clone(),
        arguments.slope.to_f64(),
        arguments.mu.to_f64(),
    )
    .map_err(refused)?;

    let diagram = match &arguments.sweep {
        Some(option) => {
            let job = UniversalJob {
                version: env!("CARGO_PKG_VERSION").to_owned(),
                restitution: arguments.restitution.to_f64(),
                slope: arguments.slope.to_f64(),
                mu: arguments.mu.to_f64(),
                diagram: specification(arguments, option)?,
            };
            let (map, sweep) = job.prepare()?;
            let rows = diagram::diagram(&map, &job.diagram, &Threads::available())
                .map_err(Failure::input)?;
            Some((job, sweep, rows))
        }
        None => None,
    };
    let values: Vec<(R, _)> = (arguments.at.iter())
        .map(|x| (x.get(), universal.at(x.get())))
        .collect();
    let atlas = Atlas::new(arguments)?;
    let findings = Findings {
        universal: &universal,
        slope,
        values: (!values.is_empty()).then_some(values),
        windows: atlas.windows,
        scaling: atlas.scaling,
        sheets: atlas.sheets,
        periodic: atlas.periodic,
        undecided: atlas.undecided,
        diagram: diagram
            .as_ref()
            .map(|(_, sweep, rows)| (sweep, rows.as_slice())),
        digits,
    };
    let mut written = Vec::new();
    if let Some(TableFile(path)) = &arguments.out {
        written.extend(table::write(
            &findings,
            diagram.as_ref().map(|found| &found.0),
            path,
        )?);
    }
    if let Some(FigureFile(path)) = &arguments.plot {
        let figure = figure(arguments, &findings, &double, &map)?;
        figure
            .write(path)
            .map_err(|error| Failure::Output(error.to_string()))?;
        written.push(path.clone());
    }
    if arguments.json {
        return Ok(document(&findings));
    }
    let mut text = account(&findings, Style::of_stdout());
    for path in &written {
        text += &format!("wrote {}\n", path.display());
    }
    Ok(text)
}

/// What was asked for of the atlas, in double-double whatever the digits: in doubles mu would lose some where laps are long.
#[derive(Default)]
struct Atlas {
    windows: Option<Vec<Window<DoubleDouble>>>,
    scaling: Option<Scaling<DoubleDouble>>,
    periodic: Vec<PeriodicWindow<DoubleDouble>>,
    sheets: Vec<Sheet>,
    undecided: usize,
}

impl Atlas {
    fn new(arguments: &Arguments) -> Result<Self, Failure> {
        let mut atlas = Self::default();
        let Some(laps) = arguments.windows else {
            return Ok(atlas);
        };
        let slope: DoubleDouble = arguments.slope.get();
        let universal = Universal::new(arguments.restitution.get()).map_err(refused)?;
        let windows = Window::list(&universal, slope, laps).map_err(refused)?;
        let range = || laps.first..=laps.last;
        if arguments.periods.is_some() || arguments.basins {
            let periods = arguments.periods.clone().map_or(1..=1, |periods| periods.0);
            let found = universal
                .periodic_windows(slope, range(), periods)
                .map_err(refused)?;
            atlas.undecided = found.undecided;
            atlas.periodic = found.windows;
        }
        if arguments.periods.is_some() {
            atlas.sheets.push(atlas::periodic(&atlas.periodic));
        }
        if arguments.basins {
            let double = Universal::<f64>::new(arguments.restitution.to_f64()).map_err(refused)?;
            let slope = arguments.slope.to_f64();
            let basins: Result<Vec<_>, UniversalError> = (atlas.periodic.iter())
                .map(|window| Ok((window.clone(), window.basin(&double, slope)?)))
                .collect();
            atlas.sheets.push(atlas::basins(&basins.map_err(refused)?));
        }
        if arguments.scaling {
            atlas.scaling = Some(universal.scaling(slope).map_err(refused)?);
            atlas
                .sheets
                .push(atlas::ratios(&windows, slope.to_f64() > 0.0));
        }
        if arguments.chaos {
            let chaos = universal.chaos(slope, range()).map_err(refused)?;
            atlas.sheets.push(atlas::chaos(&chaos));
        }
        atlas.windows = Some(windows);
        Ok(atlas)
    }
}

fn specification(arguments: &Arguments, sweep: &SweepOption) -> Result<Spec, Failure> {
    Ok(Spec {
        start: Start::CarryUp,
        exponent: if arguments.lyapunov {
            Exponent::Largest
        } else {
            Exponent::Skip
        },
        ..Spec::new(sweep.plain()?, "z", arguments.transient, arguments.keep)
    })
}

/// Widths of a figure, in millimetres.
const WIDE: f64 = 178.0;
const NARROW: f64 = 110.0;

fn figure<R: Real>(
    arguments: &Arguments,
    findings: &Findings<R>,
    universal: &Universal<f64>,
    map: &UniversalMap<f64>,
) -> Result<Figure, Failure> {
    let made = format!("Made by chatter {}.", env!("CARGO_PKG_VERSION"));
    let about = format!("r = {}", arguments.restitution.to_f64());
    let map_about = format!("{about}, K = {}", map.slope());
    if let Some(CobwebOption(mu)) = arguments.cobweb {
        let map =
            UniversalMap::new(universal.clone(), map.slope(), mu.to_f64()).map_err(refused)?;
        let caption = format!(
            "Cobweb of z -> Upsilon(K z + mu), {map_about}, mu = {}.",
            mu.to_f64()
        );
        let figure = Figure::from(picture::cobweb_panel(&map))
            .width(NARROW)
            .height(NARROW);
        return Ok(figure.title("Cobweb").caption(format!("{caption} {made}")));
    }
    let Some((sweep, rows)) = &findings.diagram else {
        let [lap, whole] = picture::upsilon_panels(universal);
        let figure = Figure::new().panel(lap).panel(whole).columns(2).width(WIDE);
        let caption =
            format!("The universal function Upsilon, {about}: one lap over Q, all over x.");
        return Ok(figure.title("Upsilon").caption(format!("{caption} {made}")));
    };
    let range = &sweep.spec().sweeps[0];
    let mut panel = picture::orbit_panel(sweep, rows)?;
    if let (Some(windows), "mu") = (&findings.windows, range.parameter.as_str()) {
        let windows: Vec<_> = windows.iter().map(Window::rounded).collect();
        picture::period_layers(&mut panel, &findings.periodic, (range.from, range.to));
        picture::window_layers(&mut panel, &windows, (range.from, range.to));
    }
    let mut figure = Figure::from(panel).width(WIDE);
    if arguments.lyapunov {
        let exponents = picture::exponent_panel(sweep, rows);
        figure = figure
            .panel(exponents)
            .sharing(Sharing::Horizontal)
            .row_heights(&[2.0, 1.0]);
    }
    let caption = format!(
        "Orbits of z -> Upsilon(K z + mu), {map_about}: {} iterates after {} for each of {} values, the last one carried \
         on.",
        arguments.keep, arguments.transient, range.count
    );
    Ok(figure
        .title("Orbit diagram")
        .caption(format!("{caption} {made}")))
}

fn refused(error: UniversalError) -> Failure {
    Failure::input(error)
}
