//! `chatter border`: border orbits and their normal form.

use crate::accounts::border::account;
use crate::border::{Answer, Place, Question, Subject, document, find, overlay, picture};
use crate::failure::{self, Failure};
use crate::numbers::Digits;
use crate::options::{
    Assignment, Count, Counts, FigureFile, Loaded, ModelOptions, Precision, Quantity,
    SectionOption, TableFile, Window,
};
use crate::terminal::{self, Console, Style};
use chatter::analysis::border::BorderSpec;
use chatter::analysis::universal::Argument;
use chatter::model::{Warning, check};
use chatter::numerics::{DoubleDouble, Real};
use clap::{ArgGroup, Args};
use std::path::PathBuf;

const EXAMPLES: &str = "\
EXAMPLES
  chatter border pressure_relief_valve --parameter q --near 0.02
  chatter border pressure_relief_valve --parameter q --near 0.048 --set kappa=1 --json
  chatter border pressure_relief_valve --parameter q --near 0.02 --digits 30
  chatter border pressure_relief_valve --parameter q --near 0.02 --section y3=10.05 --windows 20:60
  chatter border impact_oscillator --parameter sigma --range -1:1
  chatter border impact_oscillator --parameter sigma --near 0.1234 --windows 10:15 --plot cascade.png
  chatter border cam_follower --parameter speed --near 620 --windows 3:9 --plot cam.png --out cam.csv

A border orbit is released from contact, chatters, and its infinitely many impacts end exactly at the release point: it
separates orbits with complete chatter from those whose chatter ends in flight. Four impacts or more, close to each
other against the way to release, are chatter; what comes before them are long flights. All release points of a period
are followed, each to the first chatter that ends there. Near its parameter value p* the dynamics are those of
z -> Upsilon(K z + mu), mu = M (p - p*); `chatter universal` has more on that map. Windows are predicted from it, and
found in the model among its periodic orbits, stable or not.

--plot and --out follow the model's orbits and the predicted ones over the windows. The table has origin (simulated,
predicted), the parameter, the states after the first impact, and straightened, the coordinate less that for z = 0.

JSON
  One document: parameter, value, error, restitution, chatter_fixed_point, lambda, eta, exponent, release and
  first_impact (states by name), first_impact_time, period, forcing, long_flights, impacts, section (the coordinates
  that covector and A to F refer to), exact {slope, unfolding_rate, slope_error, unfolding_rate_error, amplitude,
  covector, covector_parameter, … each with its error}, leading_order {A, B, C, D, E, F, slope, unfolding_rate, section,
  crossing} or null with leading_order_error, windows {n, fold, …} as predicted, simulated_windows {n, fold, fold_error,
  fold_missed_by, …} as far as they are found in the model; what there is none of is null. With --range: borders, a list
  of such objects, and breaks, where complete chatter ends without a border; unfollowed lists values at which the motion
  cannot be followed, with the outcome that `diagram` has there, cause and message; without_chatter and unresolved count
  places about which nothing is said. With more than 17 digits each number but those of simulated_windows has a twin in
  decimals as text, under its name with `_digits` at the end.";

/// Digits of text if nothing else is asked for.
const TEXT_DIGITS: Digits = Digits(10);

/// Find border orbits, where complete chatter ends exactly at release, and the one-dimensional map around them
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES, group = ArgGroup::new("where").required(true))]
pub struct Arguments {
    #[command(flatten)]
    model: ModelOptions,

    /// The parameter that is varied
    #[arg(long, value_name = "NAME")]
    parameter: String,

    /// Find the border nearest to this value, between half of it and twice as much; around zero, between -1 and 1
    #[arg(
        long,
        value_name = "VALUE",
        group = "where",
        allow_hyphen_values = true
    )]
    near: Option<Quantity>,

    /// Find all borders of a range
    #[arg(
        long,
        value_name = "LOW:HIGH",
        group = "where",
        allow_hyphen_values = true
    )]
    range: Option<Window>,

    /// Parts into which the range is divided; borders that lie closer to each other than that may be missed [default: 200]
    #[arg(long, value_name = "N", requires = "range", allow_hyphen_values = true)]
    samples: Option<Count>,

    /// Long flights between release and the beginning of chatter, at most [default: 2]
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    excursions: Option<Count>,

    /// The section where the leading-order coefficients are taken, between release and first impact [default: one
    /// percent from release]
    #[arg(long, value_name = "STATE=LEVEL")]
    section: Option<SectionOption>,

    /// Predict the windows of these n and find them in the model; an orbit of window n has n + 1 impacts a period
    /// [default: five windows, 20:24 at restitution 0.8]
    #[arg(long, value_name = "FIRST:LAST", allow_hyphen_values = true)]
    windows: Option<Counts>,

    /// Draw the model's orbits over these windows under the edges of the predicted ones, and these, .svg, .png or .pdf
    #[arg(long, value_name = "FILE", conflicts_with = "range")]
    plot: Option<FigureFile>,

    /// Write these orbits as a table, .csv or .npz
    #[arg(long, value_name = "FILE", conflicts_with = "range")]
    out: Option<TableFile>,

    /// Digits of the numbers in the output, up to 30. Without it ten in text, all of a double in JSON
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    digits: Option<Precision>,

    /// Print one JSON document instead of text
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<u8, Failure> {
    let Loaded { mut model, .. } = arguments.model.load()?;
    let parameter = &arguments.parameter;
    let mut set = arguments.model.set.iter().map(Assignment::pair);
    if set.any(|(name, _)| name == parameter.as_str()) {
        return Err(Failure::input(format!(
            "`{parameter}` cannot be both set and varied: leave out --set {parameter}"
        )));
    }
    let is_unused = |warning: &Warning| matches!(warning, Warning::UnusedParameter { name } if name == parameter);
    if check(&model).warnings.iter().any(is_unused) {
        return Err(Failure::input(format!(
            "no equation uses parameter `{parameter}`: nothing changes with it"
        )));
    }
    let digits = arguments
        .digits
        .map_or(Digits::DOUBLE, |precision| precision.0);
    let mut spec = BorderSpec::new(&arguments.parameter);
    if let Some(samples) = arguments.samples {
        spec.samples = usize::try_from(samples.0).unwrap_or(usize::MAX);
    }
    if let Some(excursions) = arguments.excursions {
        spec.excursions = usize::try_from(excursions.0).unwrap_or(usize::MAX);
    }
    if let Some(section) = &arguments.section {
        spec.section = Some(section.section(&mut model)?);
    }
    let place = match (&arguments.near, &arguments.range) {
        (Some(near), _) => Place::Near(near.value(&mut model, "--near")?.to_f64()),
        (None, Some(range)) => {
            let (low, high) = range.ends(&mut model, "--range")?;
            Place::Range(low, high)
        }
        (None, None) => return Err(Failure::input("expected --near or --range")),
    };
    if let Some(windows) = arguments.windows
        && windows.first < 0
    {
        return Err(Failure::input(format!(
            "--windows begins at {}: an orbit of window n has n + 1 impacts, so n is 0 at least",
            windows.first
        )));
    }
    let subject = Subject {
        model: &model,
        source: &arguments.model.model,
        parameter: &arguments.parameter,
        digits,
        text_digits: arguments
            .digits
            .map_or(TEXT_DIGITS, |precision| precision.0),
        samples: spec.samples,
        excursions: spec.excursions,
        windows: arguments.windows,
    };
    // What was found is told.
    terminal::catch_interrupts();
    let asked = Asked {
        subject: &subject,
        question: Question { spec, place },
        arguments,
    };
    if digits.fit_double() {
        asked.answer::<f64>()
    } else {
        asked.answer::<DoubleDouble>()
    }
}

struct Asked<'a> {
    subject: &'a Subject<'a>,
    question: Question,
    arguments: &'a Arguments,
}

impl Asked<'_> {
    fn answer<R: Real + Argument<Real = R>>(&self) -> Result<u8, Failure> {
        let subject = self.subject;
        let answer = find::<R>(subject, &self.question, &Console::new())?;
        let written = match answer.is_complete() {
            true => self.write(&answer)?,
            false => Vec::new(),
        };
        let told = match self.arguments.json {
            true => terminal::Answer::Document(document(subject, &answer)),
            false => {
                let mut text = account(subject, &answer, Style::of_stdout());
                for path in written {
                    text += &format!("wrote {}\n", path.display());
                }
                terminal::Answer::Text(text)
            }
        };
        told.print()?;
        match &answer {
            answer if answer.is_complete() => Ok(failure::SUCCESS),
            // That borders may be missing is said among them; that windows are is not.
            Answer::One { .. } => Err(Failure::Interrupted),
            Answer::All { .. } => Ok(failure::INTERRUPTED),
        }
    }

    /// Figure and table of the orbits.
    fn write<R: Real>(&self, answer: &Answer<R>) -> Result<Vec<PathBuf>, Failure> {
        let Arguments { plot, out, .. } = self.arguments;
        let Answer::One { border, compared } = answer else {
            return Ok(Vec::new());
        };
        if plot.is_none() && out.is_none() {
            return Ok(Vec::new());
        }
        let windows = compared.as_deref().unwrap_or_default();
        let wanted = (&self.question.spec, &**border, windows);
        let overlay = overlay(self.subject, wanted, &Console::new())?;
        let mut written = Vec::new();
        if let Some(TableFile(path)) = out {
            let table = overlay.dataset(self.subject).write(path);
            written.extend(table.map_err(|error| Failure::Output(error.to_string()))?);
        }
        if let Some(FigureFile(path)) = plot {
            let figure = picture(self.subject, &overlay).write(path);
            figure.map_err(|error| Failure::Output(error.to_string()))?;
            written.push(path.clone());
        }
        Ok(written)
    }
}
