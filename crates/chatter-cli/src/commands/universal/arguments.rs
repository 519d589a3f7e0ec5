//! The options of `chatter universal`.

use crate::options::{Counts, Decimal, FigureFile, Periods, Precision, SweepOption, TableFile};
use crate::universal::Request;
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
  chatter universal --restitution 0.8 --slope 1 --windows 8:12 --periods 1:3 --plot windows.svg
  chatter universal --restitution 0.8 --slope 1 --cobweb mu=0.02 --plot cobweb.svg
  chatter universal --restitution 0.8 --plot fig2.svg

The map is z -> Upsilon(K z + mu); mu and K of a model come from `chatter border`. Its parameters are called mu and slope.
Over an orbit diagram in mu, --windows draws the fixed points as curves, also where the orbits have settled to something
else that coexists; --periods draws the windows of other orbits in a panel of their own.

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
    pub restitution: Decimal,

    /// Evaluate Upsilon at these x
    #[arg(
        long,
        value_name = "X,X,…",
        value_delimiter = ',',
        allow_hyphen_values = true
    )]
    pub at: Vec<Decimal>,

    /// Slope K of the map
    #[arg(
        long,
        value_name = "K",
        default_value = "1",
        allow_hyphen_values = true
    )]
    pub slope: Decimal,

    /// List fold, period doubling, superstable and grazing mu of the fixed points for these n
    #[arg(long, value_name = "FIRST:LAST", allow_hyphen_values = true)]
    pub windows: Option<Counts>,

    /// List the windows of orbits with these periods too, whose critical points lie on the laps of --windows
    #[arg(long, value_name = "FIRST:LAST", requires = "windows")]
    pub periods: Option<Periods>,

    /// Find the basin of each window (of fixed points, unless --periods says more)
    #[arg(long, requires = "windows")]
    pub basins: bool,

    /// List the ratios of positions and widths of windows from n to n + 1, and their limits
    #[arg(long, requires = "windows")]
    pub scaling: bool,

    /// List where there is chaos next to each window, and for which K
    #[arg(long, requires = "windows")]
    pub chaos: bool,

    /// Compute an orbit diagram over mu (or slope)
    #[arg(long, value_name = "NAME=LOW:HIGH:COUNT", allow_hyphen_values = true)]
    pub sweep: Option<SweepOption>,

    /// Offset mu of the map where it is not swept [default: 0]
    #[arg(
        long,
        value_name = "MU",
        allow_hyphen_values = true,
        requires = "sweep"
    )]
    pub mu: Option<Decimal>,

    /// Iterates that are passed over for each value of a sweep
    #[arg(long, value_name = "N", default_value_t = 500, requires = "sweep")]
    pub transient: u64,

    /// Iterates that are kept for each value of a sweep
    #[arg(long, value_name = "N", default_value_t = 500, requires = "sweep")]
    pub keep: u64,

    /// Compute Lyapunov exponents too
    #[arg(long, requires = "sweep")]
    pub lyapunov: bool,

    /// Draw or write the map, the diagonal and an orbit between them for this mu
    #[arg(long, value_name = "mu=MU", allow_hyphen_values = true)]
    pub cobweb: Option<CobwebOption>,

    /// Write windows, values, the cobweb or the samples of the sweep as a table, .csv or .npz
    #[arg(long, value_name = "FILE")]
    pub out: Option<TableFile>,

    /// Draw the orbit diagram (with --windows and --periods), the cobweb, the windows alone, or Upsilon: .svg, .png or .pdf
    #[arg(long, value_name = "FILE")]
    pub plot: Option<FigureFile>,

    /// Digits of the numbers in the output, up to 30; above 17 the computation is done with more digits
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    pub digits: Option<Precision>,

    /// Print one JSON document instead of text
    #[arg(long)]
    pub json: bool,
}

impl Arguments {
    /// What is asked of the map.
    pub fn request(&self) -> Request {
        Request {
            restitution: self.restitution,
            slope: self.slope,
            mu: self.mu,
            at: self.at.clone(),
            windows: self.windows,
            periods: self.periods.clone(),
            basins: self.basins,
            scaling: self.scaling,
            chaos: self.chaos,
            sweep: self.sweep.clone(),
            transient: self.transient,
            keep: self.keep,
            lyapunov: self.lyapunov,
            cobweb: self.cobweb.map(|CobwebOption(mu)| mu),
        }
    }
}

/// `mu=VALUE`.
#[derive(Clone, Copy, Debug)]
pub struct CobwebOption(pub Decimal);

impl std::str::FromStr for CobwebOption {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once('=') {
            Some((name, value)) if name.trim() == "mu" => value.parse().map(Self),
            _ => Err("expected mu=VALUE, such as mu=0.02".to_owned()),
        }
    }
}
