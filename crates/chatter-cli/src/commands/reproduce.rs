//! `chatter reproduce`: the paper, computed again.

use crate::failure::{self, Failure};
use crate::reproduction::{
    Plate, Valve, fig2, fig3, fig4, fig5, fig6, numbers_account, numbers_report,
    restitution_report, theory_report,
};
use crate::terminal::{self, Progress, Style};
use chatter::analysis::universal::Universal;
use chatter_io::figures::Resolution;
use chatter_io::reports::Report;
use clap::Args;
use std::path::{Path, PathBuf};

const EXAMPLES: &str = "\
EXAMPLES
  chatter reproduce
  chatter reproduce --figures 2,3,4 --out figures

Writes report.html, which holds everything, and each figure as .svg, .pdf and .png, into a folder; nothing is written
before all is computed. The paper is Dankowicz and Fotsch, On the Analysis of Chatter in Mechanical Systems with
Impacts, Procedia IUTAM 20 (2017) 18-25.";

/// Compute numbers and figures of the paper again, into one report
#[derive(Args, Debug)]
#[command(after_help = EXAMPLES)]
pub struct Arguments {
    /// Only these figures, from 2 to 6; without it all of them and all tables
    #[arg(long, value_name = "N,N,…", value_delimiter = ',', value_parser = figure_number, allow_hyphen_values = true)]
    figures: Vec<u8>,

    /// Folder for the files; it is made if it is not there
    #[arg(long, value_name = "DIR", default_value = "reproduction")]
    out: PathBuf,
}

fn figure_number(text: &str) -> Result<u8, String> {
    match text.trim().parse() {
        Ok(number @ 2..=6) => Ok(number),
        Ok(1) => Err("Fig. 1 is a drawing of the valve: expected a number from 2 to 6".to_owned()),
        _ => Err("expected a number from 2 to 6".to_owned()),
    }
}

/// The restitution of Figs. 2 to 4.
const RESTITUTION: f64 = 0.8;
/// Pixels per inch of the .png files.
const PIXELS: Resolution = Resolution(200.0);

/// Name of the file that holds everything.
const REPORT: &str = "report.html";

/// Shares of the whole work, by what they were measured to take on two cores.
struct Work {
    progress: Progress,
    done: f64,
    total: f64,
}

impl Work {
    /// Runs a part that takes this share, with something to tell its own progress to.
    fn part<T>(
        &mut self,
        name: &str,
        share: f64,
        run: impl FnOnce(&mut (dyn FnMut(f64) + Send)) -> T,
    ) -> T {
        let (start, total, progress) = (self.done, self.total, &mut self.progress);
        let result = run(&mut |part| {
            progress.show((start + share * part) / total, || name.to_owned());
        });
        self.done += share;
        result
    }
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<u8, Failure> {
    terminal::catch_interrupts();
    let folder = &arguments.out;
    std::fs::create_dir_all(folder).map_err(|error| {
        Failure::Output(format!(
            "cannot make the folder `{}`: {error}",
            folder.display()
        ))
    })?;
    let everything = arguments.figures.is_empty();
    let wanted = |number: u8| everything || arguments.figures.contains(&number);
    let universal = Universal::<f64>::new(RESTITUTION).map_err(Failure::input)?;
    let mut work = Work {
        progress: Progress::new(),
        done: 0.0,
        total: 0.0,
    };
    let shares = [(3, 3.0), (4, 2.0), (5, 40.0), (6, 35.0)];
    work.total = shares
        .iter()
        .filter(|share| wanted(share.0))
        .map(|share| share.1)
        .sum::<f64>()
        + if everything { 20.0 } else { 0.0 }
        + f64::EPSILON;

    let mut report = Report::new(
        "Chatter in mechanical systems with impacts",
        "Numbers and figures of H. Dankowicz and E. Fotsch, On the Analysis of Chatter in Mechanical Systems with Impacts, \
         Procedia IUTAM 20 (2017) 18–25, computed again; and its theory against simulation.",
    );
    let mut plates: Vec<Plate> = Vec::new();
    let mut text = String::new();
    let valve = if everything || wanted(5) || wanted(6) {
        Some(Valve::new()?)
    } else {
        None
    };
    if let (Some(valve), true) = (&valve, everything) {
        report.heading("Numbers");
        numbers_report(valve, &mut report);
        text += &format!(
            "{}\n{}",
            Style::of_stdout().title("numbers of the paper"),
            numbers_account(valve)
        );
    }
    let mut show_plate = |report: &mut Report, plate: Plate| {
        report.add(plate.picture());
        plates.push(plate);
    };
    if wanted(2) || wanted(3) || wanted(4) {
        report.heading("The universal map");
    }
    if wanted(2) {
        show_plate(&mut report, fig2(&universal));
    }
    if wanted(3) {
        let plate = work.part("Fig. 3", 3.0, |show| fig3(&universal, show))?;
        show_plate(&mut report, plate);
    }
    if wanted(4) {
        let plate = work.part("Fig. 4", 2.0, |show| fig4(&universal, show))?;
        show_plate(&mut report, plate);
    }
    if everything {
        let plate = restitution_report(&mut report);
        plates.push(plate);
    }
    if let Some(valve) = &valve {
        report.heading("The valve");
        for (number, share, draw) in [
            (
                5,
                40.0,
                fig5 as fn(&Valve, &mut (dyn FnMut(f64) + Send)) -> _,
            ),
            (6, 35.0, fig6),
        ] {
            if wanted(number) {
                let plate =
                    work.part(&format!("Fig. {number}"), share, |show| draw(valve, show))?;
                report.add(plate.picture());
                plates.push(plate);
            }
        }
        if everything {
            report.heading("Theory against simulation");
            let plate = work.part("theory against simulation", 20.0, |show| {
                theory_report(valve, &mut report, show)
            })?;
            plates.push(plate);
        }
    }
    work.progress.finish();
    report.set_colophon(format!(
        "Made by chatter {} reproduce.",
        env!("CARGO_PKG_VERSION")
    ));
    write(folder, &report, &plates)?;
    let figures: Vec<&str> = plates.iter().map(|plate| plate.name).collect();
    text += &format!(
        "\nwrote {}, and as .svg, .pdf and .png beside it: {}\n",
        folder.join(REPORT).display(),
        figures.join(", ")
    );
    terminal::print(&text).map_err(Failure::Output)?;
    Ok(failure::SUCCESS)
}

fn write(folder: &Path, report: &Report, plates: &[Plate]) -> Result<(), Failure> {
    let failed = |error: chatter_io::Error| Failure::Output(error.to_string());
    for plate in plates {
        for extension in ["svg", "pdf", "png"] {
            let path = folder.join(plate.name).with_extension(extension);
            plate.figure.write_at(&path, PIXELS).map_err(failed)?;
        }
    }
    report.write(folder.join(REPORT)).map_err(failed)
}
