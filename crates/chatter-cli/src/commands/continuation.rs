//! `chatter continue`: branches of periodic orbits over a parameter.

use crate::accounts::periodic::{branches as account, curves as curves_account};
use crate::failure::{self, Failure};
use crate::numbers::Digits;
use crate::options::{Count, FigureFile, Loaded, PeriodicOptions, Quantity, TableFile, Window};
use crate::terminal::{self, Console, Style};
use chatter::analysis::periodic::{Branch, BranchSpec, End, Known, Spec, SpecialKind};
use chatter::expressions::nearest;
use chatter::model::Model;
use chatter::numerics::Real;
use chatter_work::periodic::{
    Branches, Curve, Reach, Subject, Vertical, beneath, beside, branch_document, curves_document,
    find_branches, find_curve, first_that_changes, free_parameter, picture, plane, restore, write,
};
use clap::{Args, ValueEnum};
use std::path::PathBuf;
use std::str::FromStr;

const EXAMPLES: &str = "\
EXAMPLES
  chatter continue pressure_relief_valve --sweep q=0.0195:0.0235 --out branch.npz --plot branch.pdf
  chatter continue pressure_relief_valve --sweep q=0.0202:0.021 --switch period-doubling --depth 2 --json
  chatter continue impact_oscillator --set sigma=0 --sweep omega=2.4:3 --plot branch.svg
  chatter continue impact_oscillator --from branch.npz:2 --free omega,r --sweep r=0.4:0.9 --plot curve.svg

The orbit that the motion settles to is followed to both sides of the parameter's value, stable or not, by its arc length:
around folds, and through grazes from one sequence of events to the next, where the branch gains or loses an impact. At a
border, where complete chatter ends exactly at release, infinitely many arcs accumulate: there the branch ends, and the one
beyond is followed, too. Special points are solutions of their own equations.

JSON
  branches, a list of {points: columns (the parameter under its name, period, impacts (null where infinitely many), stable,
  multipliers, states at the section, residual, error), special: list of {kind, value, at, error, residual, period,
  impacts (without the one that grazes), multipliers, state, point, persists (of grazes: whether the branch goes on beyond
  rather than turning back), above (of folds and period doublings: whether the orbits that meet, or the doubled ones, are at
  greater values), monitor (the function that vanishes)}, arcs: list of {impacts, low and high of the parameter, first and points: which
  orbits, special: which special points, from 0}, from graze to graze, ends: how each end came about, kind: of curves in two parameters}.
  Kinds: fold, period_doubling, neimark_sacker, branch_point, impact_graze, flight_graze, chatter_border, touch, monitor; on
  curves in two parameters cusp, fold_flip, generalised_doubling, resonance_1_1 to _1_4, fold_torus, flip_torus, graze_fold,
  graze_doubling, graze_torus, double_graze, border_fold, border_doubling.

TABLE
  A row for each orbit: branch, parameter, period, impacts (-1 where infinitely many), stable, states, multipliers; and a
  table of special points, in NPZ under names that begin with `special_`.";

/// Follow periodic orbits over a parameter, through grazes, folds and period doublings
#[derive(Args, Debug)]
#[command(name = "continue", after_help = EXAMPLES)]
pub struct Arguments {
    #[command(flatten)]
    orbits: PeriodicOptions,

    /// The parameter and its range; the start is the model's value of it, if that lies within
    #[arg(long, value_name = "NAME=LOW:HIGH", allow_hyphen_values = true)]
    sweep: Swept,

    /// Follow the branches that leave at such points, too
    #[arg(long, value_name = "KIND", value_enum)]
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

    /// Follow special point number N (from 1) of a table that was written before in two parameters, see --free; may be given
    /// several times
    #[arg(long, value_name = "FILE.npz:N", requires = "free")]
    from: Vec<Seed>,

    /// The parameters of such a curve: the one of the table, and the one of --sweep
    #[arg(long, value_name = "NAME,NAME", requires = "from")]
    free: Option<String>,

    /// Write the branches as a table, .csv or .npz
    #[arg(long, value_name = "FILE")]
    out: Option<TableFile>,

    /// Draw the branches, .svg, .png or .pdf
    #[arg(long, value_name = "FILE")]
    plot: Option<FigureFile>,

    /// Draw them over the orbit diagram in this file: one over the same parameter, or the map over both
    #[arg(long, value_name = "FILE.npz", requires = "plot")]
    over: Option<PathBuf>,

    /// What the plot shows over the parameter: a state at the section, or `period` [default: the first state that changes]
    #[arg(long, value_name = "NAME", requires = "plot")]
    observe: Option<String>,

    /// Print one JSON document instead of text
    #[arg(long)]
    json: bool,
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

/// A file and the number of a point in it.
#[derive(Clone, Debug)]
struct Seed {
    path: PathBuf,
    index: usize,
}

impl FromStr for Seed {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        const EXPECTED: &str = "expected FILE.npz:N, such as branch.npz:3";
        let (path, index) = text.rsplit_once(':').ok_or(EXPECTED)?;
        Ok(Self {
            path: PathBuf::from(path),
            index: index.parse().map_err(|_| EXPECTED)?,
        })
    }
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<u8, Failure> {
    let (loaded, mut spec) = arguments.orbits.load(&arguments.monitor)?;
    let Loaded {
        mut model, text, ..
    } = loaded;
    let what = branch_spec(arguments, &mut model)?;
    let vertical = match arguments.observe.as_deref() {
        None => None,
        Some("period") => Some(Vertical::Period),
        Some(name) => Some(Vertical::State(model.state_index(name).ok_or_else(
            || {
                let known = nearest(name, model.state_names());
                Failure::input(format!("the model has no state `{name}`")).did_you_mean(known)
            },
        )?)),
    };
    let mut free = vec![what.parameter];
    if !arguments.from.is_empty() {
        free.insert(0, other_parameter(arguments, &model, what.parameter)?);
    }
    let beneath = match &arguments.over {
        Some(over) => {
            let names: Vec<&str> = (free.iter())
                .map(|&index| model.parameters[index].name.as_str())
                .collect();
            Some(beneath(&model, &names, over, vertical)?)
        }
        None => None,
    };
    terminal::catch_interrupts();
    let console = Console::new();
    let monitors = spec.monitors.clone();
    let (found, monitors) = if arguments.from.is_empty() {
        let wanted = Branches { spec, over: what };
        let found = find_branches(&model, &wanted, &console)?;
        (Found::Branches(found), monitors)
    } else {
        let mut curves = Vec::new();
        for seed in &arguments.from {
            let mut model = model.clone();
            let known = known_point((&mut model, &mut spec), seed)?;
            let wanted = Curve {
                spec: spec.clone(),
                free: [free[0], what.parameter],
                known,
                limits: what.limits,
            };
            curves.push(find_curve(&model, &wanted, &console)?);
        }
        (Found::Curves(curves), spec.monitors)
    };
    drop(console);
    let subject = Subject {
        model: &model,
        source: &arguments.orbits.model.model,
        text: &text,
        monitors: &monitors,
        free,
        digits: Digits::DOUBLE,
    };
    let all = found.branches();
    if let Some(TableFile(path)) = &arguments.out {
        write(&subject, &all, path)?;
    }
    if let Some(FigureFile(path)) = &arguments.plot {
        let vertical = vertical
            .or(beneath.as_ref().and_then(|beneath| beneath.vertical))
            .unwrap_or_else(|| first_that_changes(&subject, &all));
        let figure = match &found {
            Found::Branches(branches) => picture(&subject, branches, vertical, beneath),
            Found::Curves(curves) => plane(&subject, curves, beneath),
        };
        (figure.write(path)).map_err(|error| Failure::Output(error.to_string()))?;
    }
    let answer = if arguments.json {
        terminal::Answer::Document(match &found {
            Found::Branches(branches) => branch_document(&subject, branches),
            Found::Curves(curves) => curves_document(&subject, curves),
        })
    } else {
        terminal::Answer::Text(match &found {
            Found::Branches(branches) => account(&subject, branches, Style::of_stdout()),
            Found::Curves(curves) => curves_account(&subject, curves, Style::of_stdout()),
        })
    };
    answer.print()?;
    let interrupted = |branch: &Branch| branch.ends.contains(&End::Interrupted);
    Ok(if all.iter().any(interrupted) {
        failure::INTERRUPTED
    } else {
        failure::SUCCESS
    })
}

/// What was followed.
enum Found {
    Branches(Vec<Branch>),
    Curves(Vec<(SpecialKind, Branch)>),
}

impl Found {
    fn branches(&self) -> Vec<Branch> {
        match self {
            Self::Branches(branches) => branches.clone(),
            Self::Curves(curves) => curves.iter().map(|(_, curve)| curve.clone()).collect(),
        }
    }
}

/// The parameter that is free beside the one of the sweep.
fn other_parameter(arguments: &Arguments, model: &Model, swept: usize) -> Result<usize, Failure> {
    let names = arguments.free.as_deref().unwrap_or_default();
    let wrong = || {
        Failure::input(format!(
            "--free {names}: expected two parameters, one of them that of --sweep, such as q,kappa"
        ))
    };
    let (one, two) = names.split_once(',').ok_or_else(wrong)?;
    let index = |name: &str| {
        model.parameter_index(name.trim()).ok_or_else(|| {
            let known = nearest(name.trim(), model.parameter_names());
            Failure::input(format!(
                "--free: the model has no parameter `{}`",
                name.trim()
            ))
            .did_you_mean(known)
        })
    };
    let (one, two) = (index(one)?, index(two)?);
    match (one == swept, two == swept) {
        (false, true) => Ok(one),
        (true, false) => Ok(two),
        _ => Err(wrong()),
    }
}

/// A special point that is followed in two parameters; the model is set to its values.
fn known_point((model, spec): (&mut Model, &mut Spec), seed: &Seed) -> Result<Known, Failure> {
    let restored = restore(model, &seed.path, seed.index)?;
    for (name, value) in &restored.parameters {
        model.set_parameter(name, &format!("{value:?}"))?;
    }
    let mut known = restored.known;
    if let Some(text) = restored.function {
        let place = spec.monitors.iter().position(|known| *known == text);
        known.monitor = Some(place.unwrap_or_else(|| {
            spec.monitors.push(text);
            spec.monitors.len() - 1
        }));
    }
    Ok(known)
}

fn branch_spec(arguments: &Arguments, model: &mut Model) -> Result<BranchSpec, Failure> {
    let parameter = free_parameter(model, &arguments.sweep.name)?;
    let range = arguments.sweep.range.ends(model, "--sweep")?;
    let step = match &arguments.step {
        Some(step) => Some(step.value(model, "--step")?.to_f64()),
        None => None,
    };
    let reach = Reach {
        impacts: arguments.impacts.map(|impacts| impacts.0),
        points: arguments.points.map(|points| points.0),
        step,
    };
    let depth = arguments.depth.map_or(1, |depth| depth.0);
    let to = |kind: Switch| match arguments.switch.contains(&kind) {
        true => depth,
        false => 0,
    };
    Ok(BranchSpec {
        parameter,
        limits: reach.over(range)?,
        beside: beside(to(Switch::PeriodDoubling), to(Switch::BranchPoint))?,
    })
}
