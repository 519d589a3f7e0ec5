//! Ticks at round numbers, and how they are written: plainly, times a power of ten, or relative to an offset.

/// A labelled tick.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Tick {
    /// Where it is, in units of the axis.
    pub(super) at: f64,
    /// Its number, as a label.
    pub(super) label: String,
}

/// The ticks of one axis.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct Ticks {
    pub(super) major: Vec<Tick>,
    pub(super) minor: Vec<f64>,
    /// What each label is to be multiplied by and added to, as a label for the end of the axis.
    pub(super) notation: Option<String>,
    /// Whether that is a power of ten.
    pub(super) powers: bool,
}

/// Which numbers there are along an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Numbers {
    /// All.
    #[default]
    Real,
    /// Whole ones, such as periods: no tick stands between them.
    Whole,
}

/// How numbers are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum Notation {
    /// Plainly, unless that takes many figures.
    #[default]
    Plain,
    /// As in a panel in which another axis has a power of ten: with one, too, unless they are near one.
    Powers,
}

impl Notation {
    /// Decades of the largest number that are written plainly.
    fn plain_decades(self) -> core::ops::RangeInclusive<i32> {
        match self {
            Notation::Plain => LEAST_PLAIN_DECADE..=LARGEST_PLAIN_DECADE,
            Notation::Powers => -1..=2,
        }
    }
}

/// Most significant figures that labels show without an offset.
const FIGURES_WITHOUT_OFFSET: u32 = 4;
/// Decades from which numbers are written plainly: 0.001 …
const LEAST_PLAIN_DECADE: i32 = -3;
/// … up to 99999.
const LARGEST_PLAIN_DECADE: i32 = 4;
/// Offsets are written plainly from 0.00001 on.
const LEAST_PLAIN_OFFSET_DECADE: i32 = -5;

/// Step of a scale: `mantissa` (1, 2 or 5) times ten to the `exponent`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Step {
    mantissa: i64,
    exponent: i32,
}

impl Step {
    /// The smallest round step that is at least `raw`, up to rounding of the difference that `raw` came from.
    fn at_least(raw: f64) -> Self {
        let raw = raw * (1.0 - 1e-6);
        // One decade lower than the logarithm says, in case it was rounded up.
        let mut exponent = libm::floor(libm::log10(raw)) as i32 - 1;
        loop {
            for mantissa in [1, 2, 5] {
                let step = Step { mantissa, exponent };
                if step.times(1) >= raw {
                    return step;
                }
            }
            exponent += 1;
        }
    }

    /// `n` steps, correctly rounded.
    fn times(self, n: i64) -> f64 {
        decimal(n as i128 * self.mantissa as i128, self.exponent)
    }

    /// The next smaller round step.
    fn finer(self) -> Self {
        let (mantissa, exponent) = match self.mantissa {
            5 => (2, self.exponent),
            2 => (1, self.exponent),
            _ => (5, self.exponent - 1),
        };
        Step { mantissa, exponent }
    }

    /// The first and last multiple within a range.
    fn within(self, low: f64, high: f64) -> (i64, i64) {
        // A tick may stand beside the end by rounding only.
        const SLACK: f64 = 1e-9;
        let size = self.times(1);
        let slack = SLACK * (high / size - low / size);
        let first = libm::ceil(low / size - slack) as i64;
        let last = libm::floor(high / size + slack) as i64;
        (first, last)
    }

    /// Into how many parts minor ticks divide it.
    fn parts(self, numbers: Numbers) -> i64 {
        match (numbers, self.exponent, self.mantissa) {
            (Numbers::Whole, ..=0, whole) => whole,
            (.., 2) => 4,
            _ => 5,
        }
    }
}

/// `n` times ten to the `exponent`, correctly rounded.
fn decimal(n: i128, exponent: i32) -> f64 {
    format!("{n}e{exponent}").parse().expect("a decimal number")
}

/// A step that divides `low` to `high` into `most` parts at most, but never into fewer than one unless there are fewer
/// whole numbers; and the first and the last multiple of it.
fn division(low: f64, high: f64, most: usize, numbers: Numbers) -> (Step, i64, i64) {
    const UNIT: Step = Step {
        mantissa: 1,
        exponent: 0,
    };
    let raw = (high / most as f64) - (low / most as f64);
    let whole = numbers == Numbers::Whole;
    let mut step = Step::at_least(raw);
    if whole && step.exponent < 0 {
        step = UNIT;
    }
    let (mut first, mut last) = step.within(low, high);
    while last <= first && !(whole && step == UNIT) {
        step = step.finer();
        (first, last) = step.within(low, high);
    }
    (step, first, last)
}

/// Ticks of a linear axis from `low` to `high` (`low < high`, both finite) at multiples of 1, 2 or 5 times a power of
/// ten: at most `most + 1` of them (`most >= 1`), but never fewer than two, unless there are fewer whole numbers on an
/// axis of such.
pub(super) fn linear(
    low: f64,
    high: f64,
    most: usize,
    numbers: Numbers,
    notation: Notation,
) -> Ticks {
    let (step, first, last) = division(low, high, most, numbers);
    let multiples: Vec<i64> = (first..=last).collect();
    let written: Vec<i128> = multiples
        .iter()
        .map(|&n| i128::from(n) * i128::from(step.mantissa))
        .collect();
    let (labels, shared) = write_numbers(&written, step.exponent, notation);
    let major = multiples
        .iter()
        .zip(labels)
        .map(|(&n, label)| Tick {
            at: step.times(n).clamp(low, high),
            label,
        })
        .collect();
    let (notation, powers) = shared.map_or((None, false), |shared| (Some(shared.0), shared.1));
    Ticks {
        major,
        minor: between(step, (first, last), (low, high), numbers),
        notation,
        powers,
    }
}

/// Minor ticks.
fn between(
    step: Step,
    (first, last): (i64, i64),
    (low, high): (f64, f64),
    numbers: Numbers,
) -> Vec<f64> {
    let parts = step.parts(numbers);
    let fine = step.times(1) / parts as f64;
    ((first - 1) * parts..=(last + 1) * parts)
        .filter(|n| n % parts != 0)
        .map(|n| n as f64 * fine)
        .filter(|&x| x >= low && x <= high)
        .collect()
}

/// Ticks of a scale of which each side of `centre` has a unit of its own (`low < centre < high`): each number is written
/// in full.
pub(super) fn two_sided(low: f64, centre: f64, high: f64, most: usize) -> Ticks {
    let mut ticks = Ticks::default();
    for (from, to) in [(low, centre), (centre, high)] {
        let (step, first, last) = division(from, to, most.div_ceil(2), Numbers::Real);
        for n in first..=last {
            let at = step.times(n).clamp(from, to);
            if ticks.major.last().is_none_or(|tick: &Tick| tick.at < at) {
                let digits = i128::from(n) * i128::from(step.mantissa);
                let label = alone(digits, step.exponent);
                ticks.major.push(Tick { at, label });
            }
        }
        ticks
            .minor
            .extend(between(step, (first, last), (from, to), Numbers::Real));
    }
    ticks
}

/// A number written without regard to others.
fn alone(n: i128, exponent: i32) -> String {
    let decade = digits(n) as i32 - 1 + exponent;
    match n == 0 || (LEAST_PLAIN_DECADE..=LARGEST_PLAIN_DECADE).contains(&decade) {
        true if n == 0 => "0".to_owned(),
        true => plain(n, exponent),
        false => format!(
            "${}{}$",
            if n < 0 { "\u{2212}" } else { "" },
            scientific_or_plain(n.abs(), exponent)
        ),
    }
}

/// Labels of the numbers `n · 10^exponent`, and the notation they share, and whether there is a power of ten in it.
fn write_numbers(
    numbers: &[i128],
    exponent: i32,
    notation: Notation,
) -> (Vec<String>, Option<(String, bool)>) {
    let largest = numbers.iter().map(|n| n.abs()).max().unwrap_or(0);
    let (first, last) = (
        numbers.first().copied().unwrap_or(0),
        numbers.last().copied().unwrap_or(0),
    );
    let figures = digits(largest);
    let spread = digits(last - first);
    if figures > FIGURES_WITHOUT_OFFSET && figures >= spread + 2 {
        let offset = offset(first, last, spread);
        let relative: Vec<i128> = numbers.iter().map(|n| n - offset).collect();
        let (labels, factor) = write_relative(&relative, exponent);
        let sign = if offset < 0 { '−' } else { '+' };
        let size = scientific_or_plain(offset.abs(), exponent);
        let text = match factor {
            Some(factor) => format!("$\\times{} {sign} {}$", power_of_ten(factor), size),
            None => format!("${sign}\\,{size}$"),
        };
        return (labels, Some((text, factor.is_some())));
    }
    let decade = figures as i32 - 1 + exponent;
    if largest == 0 || notation.plain_decades().contains(&decade) {
        return (numbers.iter().map(|&n| plain(n, exponent)).collect(), None);
    }
    let labels = numbers
        .iter()
        .map(|&n| plain(n, exponent - decade))
        .collect();
    let text = format!("$\\times{}$", power_of_ten(decade));
    (labels, Some((text, true)))
}

/// The roundest number among those from `first` to `last`, or one below with as many figures more as they spread over.
fn offset(first: i128, last: i128, spread: u32) -> i128 {
    let mut unit = 10i128.pow(spread);
    let multiple = |unit: i128| Some(last.div_euclid(unit) * unit).filter(|&n| n >= first);
    match multiple(unit) {
        None if last > 0 => first.div_euclid(unit) * unit,
        None => (last.div_euclid(unit) + 1) * unit,
        Some(mut roundest) => {
            while roundest != 0 {
                unit *= 10;
                match multiple(unit) {
                    Some(rounder) => roundest = rounder,
                    None => break,
                }
            }
            roundest
        }
    }
}

/// Labels of what is left beside an offset, with a common factor unless they are plain without one.
fn write_relative(numbers: &[i128], exponent: i32) -> (Vec<String>, Option<i32>) {
    let largest = numbers.iter().map(|n| n.abs()).max().unwrap_or(0);
    let decade = digits(largest) as i32 - 1 + exponent;
    let factor = if (-2..=3).contains(&decade) {
        0
    } else {
        decade
    };
    let labels = numbers
        .iter()
        .map(|&n| plain(n, exponent - factor))
        .collect();
    (labels, (factor != 0).then_some(factor))
}

/// Ten to the power, as mathematics.
fn power_of_ten(exponent: i32) -> String {
    format!("10^{{{exponent}}}")
}

/// `n · 10^exponent` as mathematics, plainly or as mantissa times power of ten.
fn scientific_or_plain(n: i128, exponent: i32) -> String {
    let mut n = n;
    let mut exponent = exponent;
    while n != 0 && n % 10 == 0 {
        n /= 10;
        exponent += 1;
    }
    let decade = digits(n) as i32 - 1 + exponent;
    if (LEAST_PLAIN_OFFSET_DECADE..=LARGEST_PLAIN_DECADE).contains(&decade) {
        return plain(n, exponent);
    }
    format!(
        "{}\\times{}",
        plain(n, exponent - decade),
        power_of_ten(decade)
    )
}

/// Number of decimal digits of `n`; 1 for zero.
fn digits(n: i128) -> u32 {
    n.unsigned_abs().checked_ilog10().unwrap_or(0) + 1
}

/// `n · 10^exponent` in decimal notation, with as many decimals as the exponent says.
fn plain(n: i128, exponent: i32) -> String {
    let sign = if n < 0 { "−" } else { "" };
    let mut figures = n.unsigned_abs().to_string();
    if exponent >= 0 {
        if n != 0 {
            figures.extend(std::iter::repeat_n('0', exponent as usize));
        }
        return format!("{sign}{figures}");
    }
    let decimals = exponent.unsigned_abs() as usize;
    while figures.len() <= decimals {
        figures.insert(0, '0');
    }
    figures.insert(figures.len() - decimals, '.');
    format!("{sign}{figures}")
}

/// Decades up to which each has its minor ticks.
const DECADES_WITH_MINOR: i32 = 10;

/// Ticks of a logarithmic axis from `low` to `high` (`0 < low < high`): at most `most + 1` powers of ten; within less
/// than two decades 1, 2 and 5 times them, and round numbers within still less.
pub(super) fn logarithmic(low: f64, high: f64, most: usize, notation: Notation) -> Ticks {
    let slack = 1e-9;
    let (log_low, log_high) = (libm::log10(low) - slack, libm::log10(high) + slack);
    let (first, last) = (libm::ceil(log_low) as i32, libm::floor(log_high) as i32);
    let (below, above) = (libm::floor(log_low) as i32, libm::ceil(log_high) as i32);
    let inside = |x: f64| x >= low * (1.0 - slack) && x <= high * (1.0 + slack);
    let subdivisions = |which: &'static [i128]| {
        (below..above)
            .flat_map(move |e| which.iter().map(move |&m| (m, e)))
            .filter(move |&(m, e)| inside(decimal(m, e)))
    };
    let all_minor = || {
        subdivisions(&[2, 3, 4, 5, 6, 7, 8, 9])
            .map(|(m, e)| decimal(m, e))
            .collect()
    };
    if last > first {
        let stride = ((last - first) as usize).div_ceil(most).max(1) as i32;
        let major = (first..=last).filter(|e| e.rem_euclid(stride) == 0);
        let plainly = first >= -2 && last <= 3;
        let major = major
            .map(|e| Tick {
                at: decimal(1, e).clamp(low, high),
                label: if plainly {
                    plain(1, e)
                } else {
                    format!("${}$", power_of_ten(e))
                },
            })
            .collect();
        let minor = match (stride, last - first) {
            (1, n) if n <= DECADES_WITH_MINOR => all_minor(),
            _ => (first..=last)
                .filter(|e| e.rem_euclid(stride) != 0)
                .map(|e| decimal(1, e))
                .collect(),
        };
        return Ticks {
            major,
            minor,
            ..Ticks::default()
        };
    }
    let few: Vec<(i128, i32)> = subdivisions(&[1, 2, 5]).collect();
    if few.len() >= 2 && few.len() <= most + 1 {
        let major = few
            .iter()
            .map(|&(m, e)| Tick {
                at: decimal(m, e).clamp(low, high),
                label: match e {
                    LEAST_PLAIN_DECADE..=LARGEST_PLAIN_DECADE => plain(m, e),
                    _ if m == 1 => format!("${}$", power_of_ten(e)),
                    _ => format!("${m}\\times{}$", power_of_ten(e)),
                },
            })
            .collect();
        let minor = subdivisions(&[3, 4, 6, 7, 8, 9])
            .map(|(m, e)| decimal(m, e))
            .collect();
        return Ticks {
            major,
            minor,
            ..Ticks::default()
        };
    }
    linear(low, high, most, Numbers::Real, notation)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn linear(low: f64, high: f64, most: usize) -> Ticks {
        super::linear(low, high, most, Numbers::Real, Notation::Plain)
    }

    fn logarithmic(low: f64, high: f64, most: usize) -> Ticks {
        super::logarithmic(low, high, most, Notation::Plain)
    }

    fn labels(t: &Ticks) -> Vec<&str> {
        t.major.iter().map(|t| t.label.as_str()).collect()
    }

    #[test]
    fn ordinary_ranges_are_written_plainly() {
        let t = linear(0.0, 1.0, 5);
        assert_eq!(labels(&t), ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(t.notation, None);
        assert_eq!(t.minor.len(), 15);
        assert_eq!(labels(&linear(-3.0, 3.0, 4)), ["−2", "0", "2"]);
        assert_eq!(
            labels(&linear(0.0195, 0.022, 5)),
            ["0.0195", "0.0200", "0.0205", "0.0210", "0.0215", "0.0220"]
        );
        assert_eq!(
            labels(&linear(9000.0, 31000.0, 4)),
            ["10000", "20000", "30000"]
        );
    }

    #[test]
    fn tiny_ranges_are_written_beside_an_offset() {
        let t = linear(0.0203, 0.0203001, 5);
        assert_eq!(labels(&t), ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(t.notation.as_deref(), Some("$\\times10^{-7} + 0.0203$"));
        let t = linear(-0.0203001, -0.0203, 2);
        assert_eq!(labels(&t), ["−1.0", "−0.5", "0.0"]);
        assert_eq!(t.notation.as_deref(), Some("$\\times10^{-7} − 0.0203$"));
        let t = linear(9.69999, 9.70001, 4);
        assert_eq!(labels(&t), ["−1.0", "−0.5", "0.0", "0.5", "1.0"]);
        assert_eq!(t.notation.as_deref(), Some("$\\times10^{-5} + 9.7$"));
        let t = linear(100_000.0, 100_010.0, 5);
        assert_eq!(
            (labels(&t)[1], t.notation.as_deref()),
            ("2", Some("$+\\,1\\times10^{5}$"))
        );
    }

    #[test]
    fn large_and_small_numbers_share_a_power_of_ten() {
        let t = linear(0.0, 4e-5, 4);
        assert_eq!(labels(&t), ["0", "1", "2", "3", "4"]);
        assert_eq!(t.notation.as_deref(), Some("$\\times10^{-5}$"));
        assert_eq!(
            linear(0.0, 3e7, 3).notation.as_deref(),
            Some("$\\times10^{7}$")
        );
    }

    #[test]
    fn beside_a_power_of_ten_small_numbers_have_one_too() {
        let powers = |low, high| super::linear(low, high, 4, Numbers::Real, Notation::Powers);
        let t = powers(0.0, 0.004);
        assert_eq!(labels(&t), ["0", "1", "2", "3", "4"]);
        assert_eq!(t.notation.as_deref(), Some("$\\times10^{-3}$"));
        assert!(t.powers);
        let t = powers(0.0, 0.8);
        assert_eq!((labels(&t)[1], t.powers), ("0.2", false));
    }

    #[test]
    fn whole_numbers_have_no_ticks_between_them() {
        let whole =
            |low, high, most| super::linear(low, high, most, Numbers::Whole, Notation::Plain);
        let t = whole(0.5, 3.5, 8);
        assert_eq!((labels(&t), t.minor.len()), (vec!["1", "2", "3"], 0));
        assert_eq!(labels(&whole(6.7, 7.3, 5)), ["7"]);
        let t = whole(0.0, 10.0, 5);
        assert_eq!(labels(&t), ["0", "2", "4", "6", "8", "10"]);
        assert_eq!(t.minor, [1.0, 3.0, 5.0, 7.0, 9.0]);
        let t = whole(0.0, 60.0, 6);
        assert_eq!((labels(&t)[1], t.minor[0]), ("10", 2.0));
    }

    #[test]
    fn each_side_of_a_centre_has_ticks_of_its_own() {
        let t = two_sided(-4.0, 0.0, 0.2, 5);
        assert_eq!(labels(&t), ["−4", "−2", "0", "0.1", "0.2"]);
        let t = two_sided(-4.0, 0.0, 2e-7, 4);
        assert_eq!(
            labels(&t),
            ["−4", "−2", "0", "$1\\times10^{-7}$", "$2\\times10^{-7}$"]
        );
    }

    #[test]
    fn logarithmic_ticks_are_powers_of_ten_or_round_within_a_decade() {
        assert_eq!(
            labels(&logarithmic(0.05, 200.0, 6)),
            ["0.1", "1", "10", "100"]
        );
        assert_eq!(
            labels(&logarithmic(1e-9, 1.0, 3)),
            ["$10^{-9}$", "$10^{-6}$", "$10^{-3}$", "$10^{0}$"]
        );
        assert_eq!(labels(&logarithmic(0.3, 8.0, 6)), ["0.5", "1", "2", "5"]);
        assert_eq!(
            labels(&logarithmic(2.1, 3.2, 6)),
            ["2.2", "2.4", "2.6", "2.8", "3.0", "3.2"]
        );
    }

    proptest! {
        #[test]
        fn linear_ticks_are_round_evenly_spaced_and_neither_few_nor_many(
            centre in -1e6..1e6f64,
            log_width in -8.0..8.0f64,
            most in 2usize..10,
        ) {
            let width = 10f64.powf(log_width);
            let (low, high) = (centre, centre + width);
            prop_assume!(high - low > 0.5 * width);
            let t = linear(low, high, most);
            let at: Vec<f64> = t.major.iter().map(|t| t.at).collect();
            prop_assert!(at.len() >= 2 && at.len() <= (most + 1).max(5), "{} ticks", at.len());
            prop_assert!(3 * at.len() + 2 >= most, "{} of {most} ticks", at.len());
            prop_assert!(at.iter().all(|&x| x >= low && x <= high));
            let size = at[1] - at[0];
            let decade = 10f64.powf(size.log10().floor());
            let blur = 8.0 * f64::EPSILON * low.abs().max(high.abs()) / decade + 1e-6;
            prop_assert!([1.0, 2.0, 5.0, 10.0].iter().any(|m| (size / decade - m).abs() < blur), "step {size}");
            // No room for a further tick at either end.
            let slack = size * (1.0 + blur);
            prop_assert!(at[0] - low < slack && high - at[at.len() - 1] < slack);
            for w in at.windows(2) {
                prop_assert!((w[1] - w[0] - size).abs() <= 1e-6 * size + 4.0 * f64::EPSILON * low.abs().max(high.abs()));
            }
            prop_assert!(t.minor.iter().all(|&x| x >= low && x <= high));
        }

        #[test]
        fn labels_say_where_the_ticks_are(low in -1e4..1e4f64, log_width in -7.0..5.0f64) {
            let high = low + 10f64.powf(log_width);
            let t = linear(low, high, 5);
            let number = |s: &str| -> f64 { s.replace('−', "-").parse().unwrap() };
            let (mut factor, mut offset) = (1.0, 0.0);
            if let Some(n) = &t.notation {
                // $\times10^{a} + b$, $+\,b$ or $\times10^{a}$, b being plain or m\times10^{c}
                let n = n.trim_matches('$').replace('−', "-").replace("\\,", "");
                let (head, tail) = match n.split_once(' ') {
                    Some((head, tail)) => (head.to_string(), tail.replace(' ', "")),
                    None if n.starts_with("\\times") => (n, String::new()),
                    None => (String::new(), n),
                };
                let power = |s: &str| s.replace("\\times10^{", "e").replace('}', "");
                if !head.is_empty() {
                    factor = format!("1{}", power(&head)).parse().unwrap();
                }
                if !tail.is_empty() {
                    offset = power(&tail).parse().unwrap();
                }
            }
            for tick in &t.major {
                let said = number(&tick.label) * factor + offset;
                prop_assert!((said - tick.at).abs() <= 1e-9 * (high - low) + 4.0 * f64::EPSILON * tick.at.abs(), "{said} at {}", tick.at);
            }
            let mut distinct: Vec<_> = labels(&t);
            distinct.dedup();
            prop_assert_eq!(distinct.len(), t.major.len());
        }

        #[test]
        fn logarithmic_ticks_cover_the_range(log_low in -12.0..12.0f64, decades in 0.05..30.0f64, most in 2usize..9) {
            let (low, high) = (10f64.powf(log_low), 10f64.powf(log_low + decades));
            let t = logarithmic(low, high, most);
            // Within a decade they may be linear ones, of which there are up to five however few were asked for.
            prop_assert!(!t.major.is_empty() && t.major.len() <= (most + 2).max(5));
            prop_assert!(t.major.iter().all(|t| t.at >= low && t.at <= high));
            prop_assert!(t.major.windows(2).all(|w| w[0].at < w[1].at));
        }
    }
}
