//! `chatter reproduce`: the paper, computed again.

use crate::failure::{self, Failure};
use crate::parallel;
use crate::reproduction::{
    Advance, Part, Plate, Valve, Work, fig2, fig3, fig4, fig5, fig6, numbers_account,
    numbers_report, restitution_report, theory_report,
};
use crate::terminal::{self, Style};
use chatter::analysis::universal::Universal;
use chatter_figures::Resolution;
use chatter_figures::reports::Report;
use chatter_files::atomic_file::write_atomically;
use clap::Args;
use std::path::{Path, PathBuf};

const EXAMPLES: &str = "\
EXAMPLES
  chatter reproduce
  chatter reproduce --figures 2,3,4 --out figures

Writes report.html, which holds everything, and each figure as .svg, .pdf and .png, into a folder; nothing is written
before all is computed and drawn. The paper is Dankowicz and Fotsch, On the Analysis of Chatter in Mechanical Systems
with Impacts, Procedia IUTAM 20 (2017) 18-25.";

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

/// The sections of the report, after the one with numbers.
const MAP: &str = "The universal map";
const VALVE: &str = "The valve";
const THEORY: &str = "Theory against simulation";

type Compute<'a> = dyn Fn(&Advance) -> Result<Part, Failure> + Sync + 'a;

/// Something to compute that does not wait for anything else.
struct Job<'a> {
    name: &'static str,
    section: &'static str,
    /// The figure of the paper that it is, if it is one.
    figure: Option<u8>,
    /// Seconds that it takes to compute, and to draw in all formats, on one core.
    seconds: (f64, f64),
    compute: Box<Compute<'a>>,
}

impl<'a> Job<'a> {
    fn new(
        name: &'static str,
        section: &'static str,
        figure: Option<u8>,
        seconds: (f64, f64),
        compute: impl Fn(&Advance) -> Result<Part, Failure> + Sync + 'a,
    ) -> Self {
        Self {
            name,
            section,
            figure,
            seconds,
            compute: Box::new(compute),
        }
    }
}

/// Runs the command.
pub fn run(arguments: &Arguments) -> Result<u8, Failure> {
    terminal::end_on_interrupt();
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
    let valve = if wanted(5) || wanted(6) {
        Some(Valve::new()?)
    } else {
        None
    };

    let mut report = Report::new(
        "Chatter in mechanical systems with impacts",
        "Numbers and figures of H. Dankowicz and E. Fotsch, On the Analysis of Chatter in Mechanical Systems with Impacts, \
         Procedia IUTAM 20 (2017) 18–25, computed again; and its theory against simulation.",
    );
    let mut text = String::new();
    if let (Some(valve), true) = (&valve, everything) {
        report.heading("Numbers");
        numbers_report(valve, &mut report);
        text += &format!(
            "{}\n{}",
            Style::of_stdout().title("numbers of the paper"),
            numbers_account(valve)
        );
    }
    let mut jobs = jobs(&universal, valve.as_ref());
    jobs.retain(|job| job.figure.map_or(everything, wanted));
    let drawing: f64 = jobs.iter().map(|job| job.seconds.1).sum();
    let computing: f64 = jobs.iter().map(|job| job.seconds.0).sum();
    let work = Work::new(computing + drawing);
    let parts = parallel::each(&jobs, |job| {
        (job.compute)(&|part| work.advance(job.name, job.seconds.0 * part))
    })?;
    let mut plates = Vec::new();
    let mut section = "";
    for (job, part) in jobs.iter().zip(parts) {
        if job.section != section {
            section = job.section;
            report.heading(section);
        }
        part.blocks.into_iter().for_each(|block| report.add(block));
        plates.push(part.plate);
    }
    report.set_colophon(format!(
        "Made by chatter {} reproduce.",
        env!("CARGO_PKG_VERSION")
    ));
    let files = draw(folder, &report, &plates, &|part| {
        work.advance("drawing", drawing * part);
    })?;
    work.finish();
    for (path, bytes) in &files {
        write_atomically(path, bytes).map_err(|error| Failure::Output(error.to_string()))?;
    }
    let figures: Vec<&str> = plates.iter().map(|plate| plate.name).collect();
    text += &format!(
        "\nwrote {}, and as .svg, .pdf and .png beside it: {}\n",
        folder.join(REPORT).display(),
        figures.join(", ")
    );
    terminal::print(&text).map_err(Failure::Output)?;
    Ok(failure::SUCCESS)
}

/// All there is to compute, in the order of the report; what needs a valve only if there is one.
fn jobs<'a>(universal: &'a Universal<f64>, valve: Option<&'a Valve>) -> Vec<Job<'a>> {
    let mut jobs = vec![
        Job::new("Fig. 2", MAP, Some(2), (0.0, 0.1), |_| {
            Ok(fig2(universal).into())
        }),
        Job::new("Fig. 3", MAP, Some(3), (1.2, 2.0), |advance| {
            Ok(fig3(universal, advance)?.into())
        }),
        Job::new("Fig. 4", MAP, Some(4), (0.6, 5.0), |advance| {
            Ok(fig4(universal, advance)?.into())
        }),
        Job::new("restitution", MAP, None, (0.0, 0.1), |_| {
            Ok(restitution_report())
        }),
    ];
    if let Some(valve) = valve {
        jobs.extend([
            Job::new("Fig. 5", VALVE, Some(5), (5.0, 5.0), |advance| {
                Ok(fig5(valve, advance)?.into())
            }),
            Job::new("Fig. 6", VALVE, Some(6), (4.0, 5.0), |advance| {
                Ok(fig6(valve, advance)?.into())
            }),
            Job::new("theory", THEORY, None, (2.0, 0.1), |advance| {
                theory_report(valve, advance)
            }),
        ]);
    }
    jobs
}

/// Paths and contents of all files.
fn draw(
    folder: &Path,
    report: &Report,
    plates: &[Plate],
    advance: &Advance,
) -> Result<Vec<(PathBuf, Vec<u8>)>, Failure> {
    type Draw<'a> = Box<dyn Fn() -> Result<Vec<u8>, chatter_figures::Error> + Sync + 'a>;
    // The report takes longest: all figures are in it.
    let whole: Draw<'_> = Box::new(|| Ok(report.html()?.into_bytes()));
    let mut files = vec![(folder.join(REPORT), whole)];
    for plate in plates {
        let figure = &plate.figure;
        let formats: [(&str, Draw<'_>); 3] = [
            ("svg", Box::new(|| Ok(figure.svg()?.into_bytes()))),
            ("pdf", Box::new(|| Ok(figure.pdf()?))),
            ("png", Box::new(|| Ok(figure.png(PIXELS)?))),
        ];
        for (extension, draw) in formats {
            files.push((folder.join(plate.name).with_extension(extension), draw));
        }
    }
    let share = 1.0 / files.len() as f64;
    parallel::each(&files, |(path, draw)| {
        let bytes = draw().map_err(|error| Failure::Output(error.to_string()))?;
        advance(share);
        Ok((path.clone(), bytes))
    })
}
