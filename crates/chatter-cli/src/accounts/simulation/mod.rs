//! A simulation as text: what happened, in the order it happened.

mod ends;
mod lines;

use crate::failure::Failure;
use crate::numbers::{concise, fixed, full};
use crate::simulation::{Record, Subject};
use crate::terminal::{Printer, Style};
use chatter::analysis::simulate::{Outcome, Simulation};
use chatter::flow::{Closed, Held};
use chatter::numerics::Real;
use lines::{Item, Line};

/// How much of what happened is told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Listing {
    /// Impacts one sequence a line, and the middle of a long run left out.
    Summary,
    /// One event a line, all of them.
    EveryEvent,
}

/// Digits of times in the list.
const TIME_DIGITS: u32 = 12;
/// From this power of ten on times have their digits after a zero; shorter ones would lose some there.
const FEW_DECIMALS: i32 = -2;
/// The least power of ten that times are written out for.
const SHORTEST_TIME: f64 = -20.0;
/// Digits of rates and durations in the list.
const DETAIL_DIGITS: u32 = 6;
/// A summary has at most so many lines: what a reader takes in. The middle is left out.
const MOST_LINES: usize = 40;
/// Longest line of the parameters.
const WIDTH: usize = 100;

/// Prints the whole account.
pub fn print<R: Real>(
    subject: &Subject,
    (simulation, record): (&Simulation<R>, &Record<R>),
    listing: Listing,
    printer: &mut Printer,
) -> Result<(), Failure> {
    let teller = Teller::new(subject, (simulation, record), printer.style());
    printer.print(&teller.heading())?;
    printer.print("\n")?;
    match listing {
        Listing::EveryEvent => teller.print_every_event(printer)?,
        Listing::Summary => teller.print_summary(printer)?,
    }
    printer.print("\n")?;
    printer.print(&teller.ending())
}

struct Teller<'a, R> {
    subject: &'a Subject<'a>,
    simulation: &'a Simulation<R>,
    record: &'a Record<R>,
    style: Style,
    decimals: u32,
    detail_digits: u32,
}

impl<'a, R: Real> Teller<'a, R> {
    fn new(
        subject: &'a Subject,
        (simulation, record): (&'a Simulation<R>, &'a Record<R>),
        style: Style,
    ) -> Self {
        let largest = simulation
            .time
            .to_f64()
            .abs()
            .max(simulation.start_time.to_f64().abs());
        // Short times have as many digits as long ones.
        let leading = match largest {
            0.0 => 0,
            _ => largest.log10().floor().clamp(SHORTEST_TIME, 300.0) as i32,
        };
        let leading = if leading >= FEW_DECIMALS {
            leading.max(0)
        } else {
            leading
        };
        let wanted = subject.digits.0;
        let time_digits = if subject.digits.fit_double() {
            wanted.min(TIME_DIGITS)
        } else {
            wanted
        };
        Self {
            subject,
            simulation,
            record,
            style,
            decimals: time_digits.saturating_add_signed(-1 - leading),
            detail_digits: wanted.min(DETAIL_DIGITS),
        }
    }

    fn heading(&self) -> String {
        let model = self.subject.model;
        let mut text = match &model.title {
            Some(title) => format!(
                "{}  {}\n",
                self.style.title(title),
                self.style.faint(self.subject.source)
            ),
            None => format!("{}\n", self.style.title(self.subject.source)),
        };
        let parameters = model.parameter_values::<R>(&[]);
        let values = model.parameters.iter().zip(parameters);
        let values =
            values.map(|(parameter, value)| format!("{} = {}", parameter.name, self.number(value)));
        text += &wrapped(values.collect(), "  ");
        let start = &self.simulation.start_state;
        let mut values = vec![format!(
            "from time {}",
            self.number(self.simulation.start_time)
        )];
        values.extend(self.subject.states().map(|index| {
            format!(
                "{} = {}",
                self.subject.state_name(index),
                self.number(start[index])
            )
        }));
        text += &wrapped(values, "  ");
        text
    }

    fn number(&self, value: R) -> String {
        if self.subject.digits.fit_double() {
            full(value, self.subject.digits)
        } else {
            concise(value, self.subject.digits.0)
        }
    }

    fn print_every_event(&self, printer: &mut Printer) -> Result<(), Failure> {
        // Once to see how wide the columns are, once to print them.
        let mut widths = Widths::default();
        for item in self.every_event()? {
            widths.fit(self, &self.line(&item?));
        }
        printer.print(&widths.header(self))?;
        for item in self.every_event()? {
            printer.print(&widths.row(self, &self.line(&item?)))?;
        }
        Ok(())
    }

    fn print_summary(&self, printer: &mut Printer) -> Result<(), Failure> {
        let items = self.summary()?;
        let (first, last) = items.parts();
        let lines = |items: &mut dyn Iterator<Item = &Item<R>>| -> Vec<Line<R>> {
            items.map(|item| self.line(item)).collect()
        };
        let (first, last) = (lines(&mut first.iter()), lines(&mut { last }));
        let mut widths = Widths::default();
        (first.iter().chain(&last)).for_each(|line| widths.fit(self, line));
        let rows = |lines: &[Line<R>]| -> String {
            lines.iter().map(|line| widths.row(self, line)).collect()
        };
        printer.print(&widths.header(self))?;
        printer.print(&rows(&first))?;
        let left_out = items.left_out();
        if left_out > 0 {
            let note = format!("{left_out} more lines; --events lists every event");
            let width = widths.time;
            printer.print(&format!(
                "  {:>width$}  {}\n",
                "...",
                self.style.faint(&note)
            ))?;
        }
        printer.print(&rows(&last))
    }

    fn time(&self, time: R) -> String {
        fixed(time, self.decimals)
    }

    fn detail(&self, value: R) -> String {
        concise(value, self.detail_digits)
    }

    /// What a state is held by, in words.
    fn mode(&self, closed: Closed, held: &Held) -> String {
        let slid = self.subject.slid(held).join(" and ");
        let touched = self.subject.contact_names(closed);
        let mut text = match (&touched[..], &slid[..]) {
            ([], "") => "in flight".to_owned(),
            ([], slid) => format!("sliding along {slid}"),
            (names, "") => format!("in contact with {}", names.join(" and ")),
            (names, slid) => format!(
                "in contact with {}, sliding along {slid}",
                names.join(" and ")
            ),
        };
        if !held.contacts.is_empty() {
            text += &format!(", sticking at {}", self.subject.stuck(held).join(" and "));
        }
        text
    }

    fn ending(&self) -> String {
        let simulation = self.simulation;
        let mut text = format!(
            "  {} at time {}, {}\n",
            self.why(),
            self.number(simulation.time),
            self.mode(simulation.closed, &simulation.held)
        );
        let names = || {
            self.subject
                .states()
                .map(|index| self.subject.state_name(index))
        };
        let width = names().map(|name| name.chars().count()).max().unwrap_or(0);
        for (index, name) in self.subject.states().zip(names()) {
            text += &format!(
                "    {name:width$} = {}\n",
                self.number(simulation.state[index])
            );
        }
        let counts = simulation.counts;
        let named = [
            (counts.flights, "flight"),
            (counts.impacts, "impact"),
            (counts.accumulations, "accumulation"),
            (counts.releases, "release"),
            (counts.grazes, "graze"),
            (counts.sections, "section crossing"),
            (counts.ambiguities, "ambiguous impact"),
        ];
        let named = named.iter().filter(|(count, _)| *count > 0);
        let named: Vec<String> = named.map(|&(count, name)| counted(count, name)).collect();
        if !named.is_empty() {
            text += &wrapped(named, "  ");
        }
        text
    }

    fn why(&self) -> String {
        match &self.simulation.outcome {
            Outcome::Horizon if self.subject.time_was_given => {
                "the end asked for is reached".to_owned()
            }
            Outcome::Horizon => "the end is reached, --until sets another,".to_owned(),
            Outcome::ImpactBudget => {
                let impacts = counted(self.subject.spec.impacts, "impact");
                format!("stopped after {impacts}, --impacts allows more,")
            }
            Outcome::Event(target) => format!("stopped by the {target}"),
            Outcome::Rest => "came to rest for ever".to_owned(),
            Outcome::Interrupted => "interrupted".to_owned(),
            Outcome::Failed(_) => "broken off".to_owned(),
        }
    }
}

/// How wide the columns of the list are.
struct Widths {
    time: usize,
    what: usize,
    place: usize,
}

impl Default for Widths {
    fn default() -> Self {
        Self {
            time: "time".len(),
            what: 0,
            place: 0,
        }
    }
}

impl Widths {
    fn fit<R: Real>(&mut self, teller: &Teller<'_, R>, line: &Line<R>) {
        self.time = self.time.max(teller.time(line.time).len());
        self.what = self.what.max(line.what.chars().count());
        self.place = self.place.max(line.place.chars().count());
    }

    fn header<R: Real>(&self, teller: &Teller<'_, R>) -> String {
        let width = self.time;
        let header = format!("  {:>width$}  event", "time");
        format!("{}\n", teller.style.faint(&header))
    }

    fn row<R: Real>(&self, teller: &Teller<'_, R>, line: &Line<R>) -> String {
        let Self { time, what, place } = *self;
        let row = format!(
            "  {:>time$}  {:what$}  {:place$}  {}",
            teller.time(line.time),
            line.what,
            line.place,
            line.detail
        );
        format!("{}\n", row.trim_end())
    }
}

fn counted(count: u64, name: &str) -> String {
    let plural = if count == 1 { "" } else { "s" };
    format!("{count} {name}{plural}")
}

/// Items separated by commas, broken into lines.
fn wrapped(items: Vec<String>, indent: &str) -> String {
    let mut text = String::new();
    let mut line = String::new();
    let count = items.len();
    for (index, mut item) in items.into_iter().enumerate() {
        if index + 1 < count {
            item.push(',');
        }
        if !line.is_empty() && line.chars().count() + item.chars().count() + 3 > WIDTH {
            text += &format!("{indent}{line}\n");
            line.clear();
        }
        if !line.is_empty() {
            line.push(' ');
        }
        line += &item;
    }
    if !line.is_empty() {
        text += &format!("{indent}{line}\n");
    }
    text
}
