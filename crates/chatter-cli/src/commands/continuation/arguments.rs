//! What `chatter continue` is told.

use super::curves::plane;
use crate::failure::Failure;
use crate::options::{
    Assignment, Count, FigureFile, Initial, Loaded, PeriodBegins, Quantity, ShareOption, TableFile,
    WholeNumber, Window,
};
use chatter::analysis::periodic::SpecialKind;
use chatter::expressions::nearest;
use chatter_work::periodic::{Asked, Chosen, Job, Sought};
use chatter_work::source::Source;
use clap::{Args, ValueEnum};
use std::path::PathBuf;
use std::str::FromStr;

const EXAMPLES: &str = "\
EXAMPLES
  chatter continue pressure_relief_valve --sweep q=0.0195:0.0235 --out branch.npz --plot branch.pdf
  chatter continue pressure_relief_valve --sweep q=0.0202:0.021 --switch period-doubling --depth 2 --json
  chatter continue --resume branch.npz
  chatter continue impact_oscillator --sweep omega=2.4:3 --all 3 --starts 500 --out all.npz
  chatter continue impact_oscillator --set sigma=0 --sweep omega=2.4:3 --plot branch.svg
  chatter continue impact_oscillator --from branch.npz:2 --free omega,r --sweep r=0.4:0.9 --plot curve.svg
  chatter continue pressure_relief_valve --from branch.npz:period_doubling --free q,kappa --sweep kappa=1.2:1.3 --plot plane.pdf

The orbit that the motion settles to is followed to both sides of the parameter's value, stable or not, by its arc length:
around folds, and through grazes from one sequence of events to the next, where the branch gains or loses an impact. At a
border, where complete chatter ends exactly at release, infinitely many arcs accumulate: there the branch ends, and the one
beyond is followed, too. Special points are solutions of their own equations.

With --all every orbit that a search finds, at the model's value of the parameter or else in the middle of the range, is followed
unless it lies on a branch of one before it. What is followed from one orbit is a piece of the work: on several cores, and with
--shard on several machines, whose journals `chatter merge` puts together.

JSON
  branches, a list of {points: columns (the parameter under its name, period, impacts (null where infinitely many), stable, neutral,
  multipliers, states at the section, residual, error), special: list of {kind, value, at, error, residual, period,
  impacts (without the one that grazes), multipliers, state, point, persists (of grazes: whether the branch goes on beyond
  rather than turning back), above (of folds and period doublings: whether the orbits that meet, or the doubled ones, are at
  greater values), monitor (the function that vanishes)}, arcs: list of {impacts, low and high of the parameter, first and points: which
  orbits, special: which special points, from 0}, from graze to graze, ends: how each end came about, kind: of curves in two parameters}.
  Kinds: fold, period_doubling, neimark_sacker, hopf, branch_point, impact_graze, flight_graze, chatter_border, touch, monitor; on
  curves in two parameters cusp, fold_flip, generalised_doubling, resonance_1_1 to _1_4, fold_torus, flip_torus, graze_fold,
  graze_doubling, graze_torus, double_graze, border_fold, border_doubling.

TABLE
  A row for each orbit: branch, parameter, period, impacts (-1 where infinitely many), stable, neutral, states, multipliers; and a
  table of special points, in NPZ under names that begin with `special_`.

JOURNAL
  With --out, how far branches have come is kept in FILE.journal beside it until all is done; after Ctrl-C or a crash
  `chatter continue --resume FILE` goes on from there, and the result is the same to the bit.";

/// Follow periodic orbits over a parameter, through grazes, folds and period doublings
#[derive(Args, Debug)]
#[command(name = "continue", after_help = EXAMPLES)]
pub struct Arguments {
    /// Model file, or the name of a shipped model (`chatter models` lists them)
    #[arg(value_name = "MODEL", required_unless_present = "resume")]
    model: Option<String>,

    /// Go on with the branches that were to be written to this file; what was asked for is known, but --plot, --observe, --over
    /// and --json
    #[arg(long, value_name = "FILE", conflicts_with_all = Self::SETTLED)]
    pub resume: Option<PathBuf>,

    /// Give a parameter another value: a number or an expression in other parameters
    #[arg(long = "set", value_name = "NAME=EXPR")]
    set: Vec<Assignment>,

    #[command(flatten)]
    initial: Initial,

    #[command(flatten)]
    begins: PeriodBegins,

    /// The parameter and its range; the start is the model's value of it, if that lies within. Of a curve in two parameters the other one
    /// may have a range, too
    #[arg(
        long,
        value_name = "NAME=LOW:HIGH",
        required_unless_present = "resume",
        allow_hyphen_values = true
    )]
    sweep: Vec<Swept>,

    /// Follow the branches of every orbit of up to so many periods of the forcing, or returns to the section (in a map by events without one, to an event), stable or not
    #[arg(
        long,
        value_name = "PERIODS",
        conflicts_with = "from",
        allow_hyphen_values = true
    )]
    all: Option<Count>,

    /// Starts of that search [default: 200]
    #[arg(long, value_name = "N", requires = "all", allow_hyphen_values = true)]
    starts: Option<Count>,

    /// Draw other starts
    #[arg(long, value_name = "N", requires = "all", allow_hyphen_values = true)]
    seed: Option<WholeNumber>,

    /// Follow a share of these orbits only, into a journal of its own beside --out; `chatter merge` puts shares together
    #[arg(long, value_name = "NUMBER/COUNT", requires = "all", requires = "out", conflicts_with_all = ["plot", "json"])]
    pub shard: Option<ShareOption>,

    /// Follow the branches that leave at such points, too
    #[arg(long, value_name = "KIND", value_enum, conflicts_with = "from")]
    switch: Vec<Switch>,

    /// How often a branch may be left for another [default: 1]
    #[arg(
        long,
        value_name = "N",
        requires = "switch",
        allow_hyphen_values = true
    )]
    depth: Option<Count>,

    /// Follow orbits of at most so many impacts a period [default: 80]
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    impacts: Option<Count>,

    /// Orbits of one branch, to either side, at most [default: 20000]
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    points: Option<Count>,

    /// The longest step, in parts of the range [default: 0.01]
    #[arg(long, value_name = "X", allow_hyphen_values = true)]
    step: Option<Quantity>,

    /// Watch a function of the state at the section and of parameters: its zeros are special points
    #[arg(long, value_name = "EXPR", allow_hyphen_values = true)]
    monitor: Vec<String>,

    /// Follow special point number N (from 1) of a table that was written before in two parameters, see --free, or with the name of
    /// a kind in place of the number all that are of it; may be given several times
    #[arg(long, value_name = "FILE.npz:N", requires = "free")]
    pub from: Vec<Seed>,

    /// The parameters of such a curve: the one of --sweep, and another, be it the one of the table or not
    #[arg(long, value_name = "NAME,NAME", requires = "from")]
    pub free: Option<String>,

    /// Write the branches as a table, .csv or .npz
    #[arg(long, value_name = "FILE")]
    pub out: Option<TableFile>,

    /// Draw the branches, .svg, .png or .pdf
    #[arg(long, value_name = "FILE")]
    pub plot: Option<FigureFile>,

    /// Draw them over the orbit diagram in this file: one over the same parameter, or the map over both
    #[arg(long, value_name = "FILE.npz", requires = "plot")]
    pub over: Option<PathBuf>,

    /// What the plot shows over the parameter: a state at the section, or `period` [default: the first state that changes]
    #[arg(long, value_name = "NAME", requires = "plot")]
    pub observe: Option<String>,

    /// Print one JSON document instead of text
    #[arg(long)]
    pub json: bool,
}

/// Points at which branches leave.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Switch {
    /// Where a multiplier passes -1.
    PeriodDoubling,
    /// Where two branches meet.
    BranchPoint,
}

/// A parameter and its range.
#[derive(Clone, Debug)]
struct Swept {
    name: String,
    range: Window,
}

impl FromStr for Swept {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        const EXPECTED: &str = "expected NAME=LOW:HIGH, such as q=0.0195:0.0235";
        let (name, range) = text.split_once('=').ok_or(EXPECTED)?;
        if range.matches(':').count() != 1 {
            return Err(EXPECTED.to_owned());
        }
        Ok(Self {
            name: name.trim().to_owned(),
            range: range.parse().map_err(|_| EXPECTED)?,
        })
    }
}

/// A file and points in it.
#[derive(Clone, Debug)]
pub struct Seed {
    /// The file.
    pub path: PathBuf,
    /// Which points.
    pub chosen: Chosen,
}

impl FromStr for Seed {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        const EXPECTED: &str = "expected FILE.npz:N or FILE.npz:KIND, such as branch.npz:3 or branch.npz:period_doubling";
        let (path, chosen) = text.rsplit_once(':').ok_or(EXPECTED)?;
        let chosen = match chosen.parse() {
            Ok(number) => Chosen::Number(number),
            Err(_) => {
                let name = chosen.replace('-', "_");
                let kind = SpecialKind::named(&name).ok_or_else(|| {
                    let known = nearest(&name, SpecialKind::ALL.map(SpecialKind::name));
                    known.map_or_else(
                        || EXPECTED.to_owned(),
                        |known| format!("{EXPECTED}; did you mean `{known}`?"),
                    )
                })?;
                Chosen::All(kind)
            }
        };
        Ok(Self {
            path: PathBuf::from(path),
            chosen,
        })
    }
}

impl Arguments {
    /// What branches that are gone on with have been told already.
    const SETTLED: [&'static str; 18] = [
        "model", "set", "initial", "period", "section", "sweep", "all", "starts", "seed", "shard",
        "switch", "depth", "impacts", "points", "step", "monitor", "from", "out",
    ];

    /// What is asked, as a job.
    ///
    /// # Errors
    /// The model is wrong.
    pub fn job(&self) -> Result<Job, Failure> {
        let given = self.model.as_deref().unwrap_or_default();
        let Loaded {
            model,
            text,
            data_files,
            ..
        } = Source::named(given)?.load()?;
        let pairs = |all: &[Assignment]| -> Vec<(String, String)> {
            let pair = |one: &Assignment| (one.name.clone(), one.text.clone());
            all.iter().map(pair).collect()
        };
        let depth = self.depth.map_or(1, |depth| depth.0);
        let to = |kind: Switch| match self.switch.contains(&kind) {
            true => depth,
            false => 0,
        };
        let swept = self.sweep.first();
        let (from, until) = swept.map_or(("", ""), |swept| swept.range.texts());
        let name = swept.map_or("", |swept| &*swept.name);
        let mut asked = Asked {
            model: &model,
            data_files: &data_files,
            set: pairs(&self.set),
        };
        let mut plane = plane(&mut asked, (&self.from, self.free.as_deref()), name)?;
        if let Some(second) = self.sweep.get(1) {
            let of_it = plane.as_mut().filter(|plane| plane.other == second.name);
            let (Some(plane), 2) = (of_it, self.sweep.len()) else {
                return Err(Failure::input(format!(
                    "--sweep {}: branches are over one parameter; only curves in two, by --free, have a range for each",
                    second.name
                )));
            };
            let (from, until) = second.range.texts();
            plane.range = Some((from.to_owned(), until.to_owned()));
        }
        let set = asked.set;
        Ok(Job {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            model: given.to_owned(),
            model_text: text,
            data_files,
            set,
            initial: pairs(&self.initial.initial),
            search: self.all.map(|periods| Sought {
                periods: periods.0,
                starts: self.starts.map(|starts| starts.0),
                seed: self.seed.map(|seed| seed.0),
            }),
            period: self.begins.period.clone(),
            section: self.begins.section.clone(),
            monitors: self.monitor.clone(),
            parameter: swept.map_or_else(String::new, |swept| swept.name.clone()),
            range: (from.to_owned(), until.to_owned()),
            impacts: self.impacts.map(|impacts| impacts.0),
            points: self.points.map(|points| points.0),
            step: self.step.as_ref().map(|step| step.0.clone()),
            doublings: to(Switch::PeriodDoubling),
            branch_points: to(Switch::BranchPoint),
            plane,
        })
    }
}
