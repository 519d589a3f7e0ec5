//! The options of `chatter diagram`.

use crate::diagram::Request;
use crate::options::{
    Assignment, AtOption, Count, FigureFile, Initial, ObserveOption, Quantity, ShareOption,
    ShearOption, SpanOption, StartOption, SweepOption, TableFile, ThreadCount, WholeNumber,
};
use chatter::analysis::diagram::Record;
use clap::{Args, ValueEnum};
use std::path::PathBuf;

const EXAMPLES: &str = "\
EXAMPLES
  chatter diagram pressure_relief_valve --sweep q=0.0201:0.0235:4000 --section closing --observe y2 \\
      --transient 300 --keep 200 --start carry --chunk 16 --out fig5.npz --plot fig5.png
  chatter diagram --resume fig5.npz
  chatter diagram impact_oscillator --sweep omega=2.5:3.5:2000 --period '2*pi/omega' --observe v --plot strobe.pdf
  chatter diagram bouncing_ball_on_table --sweep Gamma=1.2:4:1000 --at impact --observe v --start random:5 \\
      --box v=0:1 --out ball.csv
  chatter diagram impact_oscillator_two_sided --set sigma=1 --sweep omega=0.8:3:221 --period '2*pi/omega' \\
      --observe v --start carry:both --plot hysteresis.png
  chatter diagram impact_oscillator_two_sided --at sigma=1 --at omega=2 --sweep initial:x=-1:1:200 \\
      --sweep initial:v=-3:3:200 --period '2*pi/omega' --observe v --out basins.npz --plot basins.png
  chatter diagram pressure_relief_valve --at q=0.0203 --observe y2 --json
  chatter diagram pressure_relief_valve --sweep q=0.0201:0.0235:400 --sweep r=0.7:0.9:300 --observe y2 \\
      --out map.npz --plot map.png
  chatter diagram pressure_relief_valve --sweep q=0.0201:0.0235:400 --sweep r=0.7:0.9:300 --observe y2 \\
      --out map.npz --shard 3/32                       # on each of 32 machines another share, and in the end:
  chatter merge map.*.journal --out map.npz

TABLE
  For each parameter value (and start): what is swept, outcome (periodic, chaotic, quasiperiodic, unsettled,
  complete_chatter, left_domain, no_return, no_start, undetermined, not_finite), period, impacts_per_return, with
  --exponent the largest Lyapunov exponent per sample, start (fresh, carried, random), initial_NAME for each state:
  where the orbit started. Where several orbits have the same parameters: attractor, the same number for orbits that
  settled to the same, 0 for none. For each sample: column (which row of the first table, from 0) and each observed
  quantity. NPZ holds all in one file: numpy.load('fig5.npz')['y2'].

WHAT ORBITS SETTLE TO
  Judged by the whole state, phases of a forcing up to whole periods, not by what is observed. periodic: it repeats over
  the second half of the samples. chaotic: neighbours move apart (with --exponent: the exponent is positive).
  quasiperiodic: neighbours stay neighbours, near returns add up, and averages converge. unsettled: none of these is
  evident; more samples (--keep) or a longer --transient tell more.

HYSTERESIS
  --start carry carries the state through the whole range, one value after the other, which takes as long as one core
  takes. carry:both does so upwards and downwards and says where the two differ. --chunk N starts afresh every N values:
  chunks are computed side by side, many times as fast, but an orbit follows its attractor through N values at most, so
  that hysteresis is cut off. Time is carried in the phase of the forcing: with --period, by whole periods.

JOURNAL
  What is done is kept in FILE.journal beside the output until all is done; Ctrl-C or a crash loses at most what was in
  flight. The result of a resumed run is the same to the bit.";

/// Sweep a parameter and sample what orbits settle to: periodic windows, chaos, chatter
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// Model file, or the name of a shipped model (`chatter models` lists them)
    #[arg(value_name = "MODEL", required_unless_present = "resume")]
    pub model: Option<String>,

    /// Go on with the diagram that was to be written to this file; everything is written beside it, but --plot may say
    /// where the figure goes
    #[arg(long, value_name = "FILE", conflicts_with_all = Self::SETTLED)]
    pub resume: Option<PathBuf>,

    /// Give a parameter another value: a number or an expression in other parameters
    #[arg(long = "set", value_name = "NAME=EXPR")]
    pub set: Vec<Assignment>,

    #[command(flatten)]
    pub initial: Initial,

    /// Sweep a parameter, or with `initial:NAME` the initial value of a state, over equally spaced values, both ends
    /// included; `:log` after COUNT spaces them by equal ratios. Given twice, a map over both
    #[arg(
        long,
        value_name = "NAME=FROM:TO:COUNT",
        required_unless_present_any = ["resume", "at"]
    )]
    pub sweep: Vec<SweepOption>,

    /// Sample at the crossings of this section in its direction. Without it, --at EVENT and --period: the model's only
    /// section
    #[arg(long, value_name = "NAME", conflicts_with = "period")]
    pub section: Option<String>,

    /// Sample at each event: KIND is one of those of `simulate --stop`, NAME the contact or section. With
    /// NAME=EXPR: at this one value of a parameter, a sweep of one value
    #[arg(long, value_name = "KIND[:NAME]|NAME=EXPR")]
    pub at: Vec<AtOption>,

    /// Sample stroboscopically, with this period: a number or an expression in parameters
    #[arg(long, value_name = "EXPR", allow_hyphen_values = true)]
    pub period: Option<String>,

    /// Sample at every N-th of these [default: 1]
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    pub every: Option<Count>,

    /// What is sampled, an expression in states, parameters and what happened since the sample before: impacts,
    /// accumulations, return_time, flight_time (of the last flight). Can be given several times
    #[arg(
        long,
        value_name = "[NAME=]EXPR",
        required_unless_present = "resume",
        allow_hyphen_values = true
    )]
    pub observe: Vec<ObserveOption>,

    /// Samples passed over before any is kept [default: 300]
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    pub transient: Option<WholeNumber>,

    /// Samples kept for each orbit [default: 200]
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    pub keep: Option<Count>,

    /// Where orbits start: `fresh` at the initial state; `carry` where the orbit at the next lower parameter value
    /// ended, `carry:down` at the next higher, `carry:both` one orbit each way; `random:COUNT` at so many random points of
    /// --box, drawn again where no orbit can start [default: fresh]
    #[arg(long, value_name = "START")]
    pub start: Option<StartOption>,

    /// Carry the state through so many values only, then start afresh: such chunks are computed side by side, and cut
    /// hysteresis off [default: the whole range]
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    pub chunk: Option<Count>,

    /// Draw this state at random between two bounds; other states start at their initial values
    #[arg(long = "box", value_name = "NAME=FROM:TO", allow_hyphen_values = true)]
    pub bounds: Vec<SpanOption>,

    /// Another seed, other random starts [default: 0]
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    pub seed: Option<WholeNumber>,

    /// Look for periods up to this one [default: 64]
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    pub longest_period: Option<Count>,

    /// Samples a period apart may differ by this much of the largest [default: 1e-8]
    #[arg(long, value_name = "X", allow_hyphen_values = true)]
    pub period_tolerance: Option<Quantity>,

    /// Compute the largest Lyapunov exponent too
    #[arg(long)]
    pub exponent: bool,

    /// Keep `samples`, or only the `classes` of orbits [default: samples, with two sweeps classes]
    #[arg(long, value_name = "WHAT")]
    pub record: Option<RecordOption>,

    /// Give up a return that takes longer than this time, a --period too [default: 10000]
    #[arg(long, value_name = "T", allow_hyphen_values = true)]
    pub longest_return: Option<Quantity>,

    /// Give up a return that takes more impacts than this [default: 100000]
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    pub most_impacts: Option<Count>,

    /// Relative error allowed in one step, from 0 to below 1; rounding error without it, or where that is larger
    #[arg(long, value_name = "X", allow_hyphen_values = true)]
    pub tolerance: Option<Quantity>,

    /// Print one JSON document in place of the account: outcomes, periods, attractors and samples, column by column
    #[arg(long)]
    pub json: bool,

    /// Write the tables, .npz or .csv
    #[arg(long, value_name = "FILE")]
    pub out: Option<TableFile>,

    /// Draw the diagram, .png, .svg or .pdf
    #[arg(long, value_name = "FILE")]
    pub plot: Option<FigureFile>,

    /// Subtract a multiple of the parameter from the vertical axis of the figure: this slope, or `auto` for the one that
    /// makes the diagram level
    #[arg(
        long,
        value_name = "SLOPE",
        requires = "plot",
        allow_hyphen_values = true
    )]
    pub shear: Option<ShearOption>,

    /// Compute one of several shares only, into a journal of its own beside --out, for `chatter merge`, which draws
    #[arg(long, value_name = "NUMBER/COUNT", requires = "out", conflicts_with_all = ["resume", "json", "plot"])]
    pub shard: Option<ShareOption>,

    /// How many threads compute [default: as many as the machine runs at once]
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    pub threads: Option<ThreadCount>,
}

impl Arguments {
    /// What is asked for.
    pub fn request(&self) -> Request {
        Request {
            set: self.set.clone(),
            initial: self.initial.initial.clone(),
            sweeps: self.sweep.clone(),
            section: self.section.clone(),
            at: self.at.clone(),
            period: self.period.clone(),
            every: self.every,
            observe: self.observe.iter().map(|one| one.0.clone()).collect(),
            transient: self.transient.map(|samples| samples.0),
            keep: self.keep,
            start: self.start,
            chunk: self.chunk,
            bounds: self.bounds.clone(),
            seed: self.seed.map(|seed| seed.0),
            longest_period: self.longest_period,
            period_tolerance: self.period_tolerance.clone(),
            exponent: self.exponent,
            record: self.record.map(|record| match record {
                RecordOption::Samples => Record::Samples,
                RecordOption::Classes => Record::Classes,
            }),
            longest_return: self.longest_return.clone(),
            most_impacts: self.most_impacts,
            tolerance: self.tolerance.clone(),
            out: self.out.as_ref().map(|file| file.0.clone()),
            plot: self.plot.as_ref().map(|file| file.0.clone()),
            shear: self.shear.map(|shear| shear.0),
        }
    }

    /// What a diagram that is resumed has been told already: everything but the number of threads, and where a figure goes.
    const SETTLED: [&'static str; 24] = [
        "model",
        "set",
        "initial",
        "sweep",
        "section",
        "at",
        "period",
        "every",
        "observe",
        "transient",
        "keep",
        "start",
        "chunk",
        "bounds",
        "seed",
        "longest_period",
        "period_tolerance",
        "exponent",
        "record",
        "longest_return",
        "most_impacts",
        "tolerance",
        "out",
        "shear",
    ];
}

/// What is kept of orbits.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum RecordOption {
    Samples,
    Classes,
}
