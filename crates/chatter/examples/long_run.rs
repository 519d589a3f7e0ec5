//! A long run of the valve, watched at every impact and then between impacts, for whatever should never happen: a plug
//! below its seat, an impact that does not part, a flight that takes no time, an orbit that cannot go on.
//! `cargo run --release -p chatter-dynamics --example long_run -- FLIGHTS`.

use chatter::analysis::map::{Arrival, Command, Map, Origin, Start};
use chatter::analysis::return_map::{ReturnMap, ReturnSpec, Sampling};
use chatter::analysis::simulate::EventKind;
use chatter::model::Model;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

const VALVE: &str = include_str!("../../../models/pressure_relief_valve.toml");

/// Orbits that each core follows at once.
const COLUMNS: u64 = 512;

/// For each so many flights watched at their ends, one is looked at between.
const BETWEEN: u64 = 20;

/// Shorter than most flights and in no simple ratio to the time of a return, so that every part of a flight is seen.
const PERIOD: &str = "0.0173";

/// What was seen.
#[derive(Clone, Copy)]
struct Seen {
    looks: u64,
    flights: u64,
    /// Least gap, least rate after an impact, shortest and longest flight.
    gap: f64,
    rate: f64,
    shortest: f64,
    longest: f64,
    wrong: u64,
}

impl Seen {
    const NOTHING: Self = Self {
        looks: 0,
        flights: 0,
        gap: f64::INFINITY,
        rate: f64::INFINITY,
        shortest: f64::INFINITY,
        longest: 0.0,
        wrong: 0,
    };

    fn and(self, other: Self) -> Self {
        Self {
            looks: self.looks + other.looks,
            flights: self.flights + other.flights,
            gap: self.gap.min(other.gap),
            rate: self.rate.min(other.rate),
            shortest: self.shortest.min(other.shortest),
            longest: self.longest.max(other.longest),
            wrong: self.wrong + other.wrong,
        }
    }

    fn look(&mut self, arrival: &Arrival<'_>, at_impacts: bool) {
        self.looks += 1;
        let Ok(passage) = &arrival.passage else {
            self.wrong += 1;
            println!("q = {}: {:?}", arrival.parameters[0], arrival.passage);
            return;
        };
        self.flights += passage.impacts;
        let (gap, rate) = (arrival.point[0], arrival.point[1]);
        self.gap = self.gap.min(gap);
        let mut right = gap >= 0.0;
        if at_impacts {
            self.rate = self.rate.min(rate);
            // The first flight has no beginning that was seen.
            if !passage.flight_time.is_nan() {
                self.shortest = self.shortest.min(passage.flight_time);
                self.longest = self.longest.max(passage.flight_time);
                right &= passage.flight_time > 0.0;
            }
            right &= gap == 0.0 && rate > 0.0 && passage.impacts == 1;
        }
        if !right {
            self.wrong += 1;
            println!(
                "q = {}: state {:?} after {passage:?}",
                arrival.parameters[0], arrival.point
            );
        }
    }
}

fn watch(map: &ReturnMap, flights: u64, at_impacts: bool, (core, cores): (u64, u64)) -> Seen {
    let count = COLUMNS * cores;
    let starts: Vec<Start> = (0..COLUMNS)
        .map(|k| {
            let share = (k * cores + core) as f64 / count as f64;
            Start {
                swept: vec![0.0201 + 0.0034 * share],
                origin: Origin::Initial,
            }
        })
        .collect();
    let share = flights.div_ceil(count);
    let mut left = vec![share; starts.len()];
    let mut seen = Seen::NOTHING;
    map.follow(&[0], &starts, &AtomicBool::new(false), &mut |arrival| {
        let before = seen.flights;
        seen.look(&arrival, at_impacts);
        let left = &mut left[arrival.orbit];
        *left = left.saturating_sub(seen.flights - before);
        if *left == 0 {
            Command::Retire
        } else {
            Command::Continue
        }
    });
    seen
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let flights: u64 = std::env::args()
        .nth(1)
        .unwrap_or("10000000".into())
        .parse()?;
    let model = Model::from_toml(VALVE, "pressure_relief_valve.toml")?;
    let cores = std::thread::available_parallelism()?.get() as u64;
    let at_impacts = Sampling::Event {
        kind: EventKind::Impact,
        at: None,
    };
    let between = Sampling::Stroboscopic {
        period: PERIOD.to_owned(),
    };
    for (name, sampling, flights) in [
        ("at every impact", at_impacts, flights),
        ("between impacts", between, flights / BETWEEN),
    ] {
        let at_impacts = matches!(sampling, Sampling::Event { .. });
        let map = ReturnMap::new(&model, &ReturnSpec::new(sampling))?;
        let started = Instant::now();
        let map = &map;
        let seen = std::thread::scope(|scope| {
            let begin = |core| scope.spawn(move || watch(map, flights, at_impacts, (core, cores)));
            let workers: Vec<_> = (0..cores).map(begin).collect();
            let parts = workers.into_iter().map(|worker| worker.join());
            parts
                .map(|part| part.map_err(|_| "a worker panicked"))
                .try_fold(Seen::NOTHING, |sum, part| part.map(|part| sum.and(part)))
        })?;
        println!(
            "{name}: {} flights and {} looks in {:.0} s; {} wrong; least gap {:e}",
            seen.flights,
            seen.looks,
            started.elapsed().as_secs_f64(),
            seen.wrong,
            seen.gap
        );
        if at_impacts {
            println!(
                "  least rate after an impact {:e}; flights from {:e} to {:.3}",
                seen.rate, seen.shortest, seen.longest
            );
        }
        if seen.wrong > 0 {
            return Err("something happened that never should".into());
        }
    }
    Ok(())
}
