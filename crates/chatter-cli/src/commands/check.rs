//! `chatter check`: what was derived from a model.

use crate::failure::{self, Failure};
use crate::model_tables::{self, TableObject};
use crate::named::Named;
use crate::numbers::{Digits, full};
use crate::options::{Initial, Loaded, ModelOptions};
use crate::simulation::why_none_begins;
use crate::terminal::{self, Style};
use chatter::expressions::Expr;
use chatter::model::{Check, ContactFormulas, Model, NamedFormula, Simultaneous, check};
use clap::Args;
use serde::Serialize;

const EXAMPLES: &str = "\
EXAMPLES
  chatter check pressure_relief_valve
  chatter check my_model.toml --set r=0
  chatter check my_model.toml --json

The start of a trajectory is checked too: --set and --initial change it. Warnings leave the exit code at 0.";

/// Print what was derived from a model, and warn of what looks wrong
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    #[command(flatten)]
    model: ModelOptions,

    #[command(flatten)]
    initial: Initial,

    /// Print one JSON document instead of text
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<u8, Failure> {
    let Loaded { mut model, .. } = arguments.model.load()?;
    arguments.initial.apply(&mut model)?;
    let source = arguments.model.model.as_str();
    let report = Report {
        model: &model,
        source,
        check: check(&model),
        refusal: why_none_begins(&model),
    };
    let printed = if arguments.json {
        terminal::print_json(&report.document())
    } else {
        terminal::print(&report.text(Style::of_stdout()))
    };
    printed.map_err(Failure::Output)?;
    Ok(failure::SUCCESS)
}

fn in_words(law: Simultaneous) -> &'static str {
    match law {
        Simultaneous::Binary => {
            "one after the other, the one that closes fastest first, until none that touches closes"
        }
        Simultaneous::Moreau => {
            "all that touch at once, impulses p >= 0 with v+ + r v- >= 0 and p (v+ + r v-) = 0"
        }
    }
}

struct Report<'a> {
    model: &'a Model,
    source: &'a str,
    check: Check,
    /// Why there are no trajectories, where no warning says so already.
    refusal: Option<String>,
}

#[derive(Serialize)]
struct Document<'a> {
    source: &'a str,
    title: Option<&'a str>,
    parameters: Named<f64>,
    initial: Named<f64>,
    flight: Named<String>,
    simultaneous: &'static str,
    contacts: Vec<ContactObject<'a>>,
    sections: Vec<SectionObject<'a>>,
    corners: Vec<CornerObject>,
    tables: Vec<TableObject<'a>>,
    warnings: Vec<String>,
}

#[derive(Serialize)]
struct CornerObject {
    surface: String,
    jumps: bool,
    can_slide: bool,
}

#[derive(Serialize)]
struct ContactObject<'a> {
    name: &'a str,
    gap: &'a str,
    rate: &'a str,
    acceleration: &'a str,
    jerk: &'a str,
    rate_per_impulse: &'a str,
    impact: Named<&'a str>,
    sticking: Named<&'a str>,
}

#[derive(Serialize)]
struct SectionObject<'a> {
    name: &'a str,
    surface: String,
    direction: &'static str,
}

impl Report<'_> {
    fn formula(&self, expr: Expr) -> String {
        self.model.formula(expr)
    }

    fn flight(&self) -> Vec<NamedFormula> {
        let states = self.model.states.iter().enumerate();
        states
            .filter(|&(index, _)| Some(index) != self.model.time)
            .map(|(_, state)| NamedFormula {
                name: state.name.clone(),
                text: self.formula(state.written),
            })
            .collect()
    }

    /// Time keeps its own equation in contact too: nobody needs to read it.
    fn without_time<'f>(&self, formulas: &'f [NamedFormula]) -> Vec<&'f NamedFormula> {
        let time = self
            .model
            .time
            .map(|index| self.model.states[index].name.as_str());
        let formulas = formulas.iter();
        formulas
            .filter(|formula| Some(formula.name.as_str()) != time)
            .collect()
    }

    fn values(&self) -> (Named<f64>, Named<f64>) {
        let parameters = self.model.parameter_values::<f64>(&[]);
        let initial = self.model.initial_state(&parameters);
        (
            Named::new(self.model.parameter_names(), parameters),
            Named::new(self.model.state_names(), initial),
        )
    }

    fn text(&self, style: Style) -> String {
        let title = self.model.title.as_deref().unwrap_or(self.source);
        let mut text = format!("{}  {}\n", style.title(title), style.faint(self.source));
        if let Some(source) = &self.model.source {
            text += &format!("{source}\n");
        }
        let (parameters, initial) = self.values();
        let table = |values: &Named<f64>| {
            let named = values.0.iter();
            named
                .map(|(name, value)| (name.clone(), full(*value, Digits::DOUBLE)))
                .collect::<Vec<_>>()
        };
        if !parameters.0.is_empty() {
            text += &block(style, "parameters", " = ", &table(&parameters));
        }
        text += &block(style, "start", " = ", &table(&initial));
        text += &block(
            style,
            "flight",
            "' = ",
            &pairs(&self.flight().iter().collect::<Vec<_>>()),
        );
        for contact in &self.check.contacts {
            text += &self.contact(style, contact);
        }
        if self.model.contacts.len() > 1 {
            let law = self.model.simultaneous;
            let law = (law.name().to_owned(), in_words(law).to_owned());
            text += &block(style, "several contacts at one instant", "  ", &[law]);
        }
        let sections = self.model.sections.iter();
        let sections: Vec<(String, String)> = sections
            .map(|section| {
                let crossing = format!(
                    "{} = 0, {}",
                    self.formula(section.surface),
                    section.direction.name()
                );
                (section.name.clone(), crossing)
            })
            .collect();
        if !sections.is_empty() {
            text += &block(style, "sections", "  ", &sections);
        }
        let corners = self.corners();
        if !corners.is_empty() {
            text += &block(style, "corners", "  ", &corners);
        }
        let tables = model_tables::lines(self.model);
        if !tables.is_empty() {
            text += &block(style, "tables", "  ", &tables);
        }
        text.push('\n');
        for warning in &self.check.warnings {
            text += &format!("{} {warning}\n", style.warning("warning:"));
        }
        if let Some(refusal) = &self.refusal {
            text += &format!(
                "{} no trajectory begins: {refusal}\n",
                style.warning("warning:")
            );
        } else if self.check.warnings.is_empty() {
            text += "nothing looks wrong\n";
        }
        text
    }

    /// What the field does where its formulas change.
    fn corners(&self) -> Vec<(String, String)> {
        let kinds = self.model.corner_kinds().into_iter();
        kinds
            .map(|corner| {
                let what = match (corner.contact, corner.jumps, corner.can_slide) {
                    (Some(contact), ..) => {
                        let name = &self.model.contacts[contact].name;
                        format!(
                            "sliding in contact `{name}`: friction changes sign, and can hold it"
                        )
                    }
                    (None, false, _) => "the field is continuous".to_owned(),
                    (None, true, true) => "the field jumps; the motion can slide along".to_owned(),
                    (None, true, false) => "the field jumps; crossed only".to_owned(),
                };
                (format!("{} = 0", corner.surface), what)
            })
            .collect()
    }

    fn contact(&self, style: Style, contact: &ContactFormulas) -> String {
        let quantities = [
            ("gap", &contact.gap),
            ("rate", &contact.rate),
            ("acceleration", &contact.acceleration),
            ("jerk", &contact.jerk),
            ("rate per impulse", &contact.rate_per_impulse),
        ];
        let quantities = quantities.map(|(name, text)| (name.to_owned(), text.clone()));
        let mut text = block(
            style,
            &format!("contact {}", contact.name),
            "  ",
            &quantities,
        );
        let impact = self.without_time(&contact.impact);
        text += &block(
            style,
            &format!("impact at {}", contact.name),
            " -> ",
            &pairs(&impact),
        );
        let sticking = self.without_time(&contact.sticking);
        let title = format!(
            "in contact with {}, while its acceleration is negative",
            contact.name
        );
        text += &block(style, &title, "' = ", &pairs(&sticking));
        text
    }

    fn document(&self) -> Document<'_> {
        let (parameters, initial) = self.values();
        let flight = self.flight();
        let named = |formulas: Vec<&NamedFormula>| {
            Named(
                formulas
                    .into_iter()
                    .map(|f| (f.name.clone(), f.text.clone()))
                    .collect(),
            )
        };
        fn borrowed(formulas: Vec<&NamedFormula>) -> Named<&str> {
            let pairs = formulas.into_iter();
            Named(pairs.map(|f| (f.name.clone(), f.text.as_str())).collect())
        }
        Document {
            source: self.source,
            title: self.model.title.as_deref(),
            parameters,
            initial,
            corners: (self.model.corner_kinds().into_iter())
                .map(|corner| CornerObject {
                    surface: corner.surface,
                    jumps: corner.jumps,
                    can_slide: corner.can_slide,
                })
                .collect(),
            flight: named(flight.iter().collect()),
            simultaneous: self.model.simultaneous.name(),
            contacts: (self.check.contacts.iter())
                .map(|contact| ContactObject {
                    name: &contact.name,
                    gap: &contact.gap,
                    rate: &contact.rate,
                    acceleration: &contact.acceleration,
                    jerk: &contact.jerk,
                    rate_per_impulse: &contact.rate_per_impulse,
                    impact: borrowed(self.without_time(&contact.impact)),
                    sticking: borrowed(self.without_time(&contact.sticking)),
                })
                .collect(),
            sections: (self.model.sections.iter())
                .map(|section| SectionObject {
                    name: &section.name,
                    surface: self.formula(section.surface),
                    direction: section.direction.name(),
                })
                .collect(),
            tables: model_tables::objects(self.model),
            warnings: self
                .check
                .warnings
                .iter()
                .map(ToString::to_string)
                .chain(
                    self.refusal
                        .iter()
                        .map(|why| format!("no trajectory begins: {why}")),
                )
                .collect(),
        }
    }
}

fn pairs(formulas: &[&NamedFormula]) -> Vec<(String, String)> {
    formulas
        .iter()
        .map(|f| (f.name.clone(), f.text.clone()))
        .collect()
}

/// A title and lines of two columns below it.
fn block(style: Style, title: &str, between: &str, lines: &[(String, String)]) -> String {
    let width = lines
        .iter()
        .map(|(name, _)| name.chars().count())
        .max()
        .unwrap_or(0);
    let mut text = format!("\n{}\n", style.title(title));
    for (name, value) in lines {
        let padding = " ".repeat(width - name.chars().count());
        // A derivative's prime belongs to its name.
        let (mark, rest) = match between.strip_prefix('\'') {
            Some(rest) => ("'", rest),
            None => ("", between),
        };
        text += &format!("  {name}{mark}{padding}{rest}{value}\n");
    }
    text
}
