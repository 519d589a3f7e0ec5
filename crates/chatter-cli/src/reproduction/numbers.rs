//! Every number that the paper prints, beside ours.

use super::Valve;
use crate::aligned::{Side, aligned};
use chatter::analysis::border::LeadingOrder;
use chatter_figures::reports::{Column, Grid, Report};

/// A number of the paper.
struct Printed {
    /// What it is, in the report and in text.
    name: &'static str,
    plain: &'static str,
    /// Where it stands.
    place: &'static str,
    /// As it is printed.
    text: &'static str,
    /// Ours at our q*.
    ours: f64,
    /// Ours at the q* that the paper computed with; none where it does not depend on one.
    at_printed: Option<f64>,
}

impl Printed {
    fn value(&self) -> f64 {
        self.text.parse().unwrap_or(f64::NAN)
    }

    fn decimals(&self) -> usize {
        self.text
            .split_once('.')
            .map_or(0, |(_, decimals)| decimals.len())
    }

    /// Units of the last printed digit by which ours, rounded like the paper's, differs.
    fn units(&self, ours: f64) -> i64 {
        let scale = (0..self.decimals()).fold(1.0, |scale, _| scale * 10.0);
        (ours * scale).round() as i64 - (self.value() * scale).round() as i64
    }

    /// Ours with three digits more than are printed.
    fn more(&self, ours: f64) -> String {
        format!("{ours:.*}", self.decimals() + 3)
    }
}

type Part = fn(&LeadingOrder<f64>) -> f64;

/// Those that a leading-order form has.
const COEFFICIENTS: [(&str, &str, &str, &str, Part); 17] = [
    ("$y_1^{\\dagger *}$", "y1+*", "text", "0.001080", |f| {
        f.crossing[0]
    }),
    ("$y_2^{\\dagger *}$", "y2+*", "text", "0.011966", |f| {
        f.crossing[1]
    }),
    ("$B_1$", "B1", "(28)", "0.186318", |f| f.b[0]),
    ("$B_2$", "B2", "(28)", "0.747358", |f| f.b[1]),
    ("$C_1$", "C1", "(28)", "1.33805", |f| f.c[0]),
    ("$C_2$", "C2", "(28)", "0.577996", |f| f.c[1]),
    ("$D$", "D", "(28)", "7.88954", |f| f.d),
    ("$E_1$", "E1", "(28)", "-0.103297", |f| f.e[0]),
    ("$E_2$", "E2", "(28)", "-0.621515", |f| f.e[1]),
    ("$A_{11}$", "A11", "(29)", "-11.2769", |f| f.a[0][0]),
    ("$A_{12}$", "A12", "(29)", "-0.667163", |f| f.a[0][1]),
    ("$A_{21}$", "A21", "(29)", "60.6417", |f| f.a[1][0]),
    ("$A_{22}$", "A22", "(29)", "3.55289", |f| f.a[1][1]),
    ("$F_1$", "F1", "(29)", "3.96147", |f| f.f[0]),
    ("$F_2$", "F2", "(29)", "-16.6998", |f| f.f[1]),
    ("$CAB$", "CAB", "text", "4.58679", |f| f.slope),
    ("$CAE + CF + D$", "CAE + CF + D", "text", "0.754296", |f| {
        f.unfolding_rate
    }),
];

fn printed(valve: &Valve) -> Vec<Printed> {
    let border = &valve.border;
    let state = &border.first_impact.state;
    let text = |name, plain, text, ours| Printed {
        name,
        plain,
        place: "text",
        text,
        ours,
        at_printed: None,
    };
    let mut all = vec![
        text("$q^*$", "q*", "0.020056", border.value.value),
        text("$y_2^*$", "y2*", "0.118256", state[1]),
        text("$y_3^*$", "y3*", "9.45248", state[2]),
    ];
    for (name, plain, place, text, part) in COEFFICIENTS {
        all.push(Printed {
            name,
            plain,
            place,
            text,
            ours: part(&valve.leading_order),
            at_printed: Some(part(&valve.at_printed)),
        });
    }
    all
}

fn difference(units: i64) -> String {
    match units {
        0 => "0".to_owned(),
        units => format!("{units:+}"),
    }
}

/// The table for a terminal.
pub fn account(valve: &Valve) -> String {
    let heading = [
        "",
        "",
        "paper",
        "ours",
        "ours - paper",
        "last digit",
        "at q = 0.020056",
        "last digit",
    ];
    let mut rows = vec![heading.map(str::to_owned).to_vec()];
    for number in printed(valve) {
        let at_printed = number.at_printed;
        rows.push(vec![
            number.plain.to_owned(),
            number.place.to_owned(),
            number.text.to_owned(),
            number.more(number.ours),
            format!("{:+.1e}", number.ours - number.value()),
            difference(number.units(number.ours)),
            at_printed.map_or_else(String::new, |ours| number.more(ours)),
            at_printed.map_or_else(String::new, |ours| difference(number.units(ours))),
        ]);
    }
    let sides = [
        Side::Left,
        Side::Left,
        Side::Right,
        Side::Right,
        Side::Right,
        Side::Right,
        Side::Right,
        Side::Right,
    ];
    aligned(&rows, &sides)
}

/// The table and what is to be said about it.
pub fn report(valve: &Valve, report: &mut Report) {
    let border = &valve.border;
    report.paragraph(format!(
        "The pressure relief valve with $\\beta = 20$, $\\kappa = 1.25$, $r = 0.8$, $\\delta = 10$ has a border orbit at \
         $q^* = {}$ (error {:.0e}), found as the smooth root $X(q) = 0$ along {} impacts. Its period is {:.12}.",
        border.value.value, border.value.error, border.impacts, border.period.value
    ));
    let mut grid = Grid::new(
        "Table 1",
        "Every number that the paper prints, and ours: at our $q^*$, and at $q = 0.020056$ exactly. Differences in units \
         of the last printed digit.",
        [
            Column::words("number"),
            Column::words("where"),
            Column::numbers("paper"),
            Column::numbers("ours"),
            Column::numbers("difference"),
            Column::numbers("last digit"),
            Column::numbers("at 0.020056"),
            Column::numbers("last digit"),
        ],
    );
    let numbers = printed(valve);
    for number in &numbers {
        let at_printed = number.at_printed;
        let (value, units) = match at_printed {
            Some(ours) => (number.more(ours), difference(number.units(ours))),
            None => ("–".to_owned(), "–".to_owned()),
        };
        grid.add([
            number.name.to_owned(),
            number.place.to_owned(),
            number.text.to_owned(),
            number.more(number.ours),
            format!("{:+.1e}", number.ours - number.value()),
            difference(number.units(number.ours)),
            value,
            units,
        ]);
    }
    report.add(grid);
    let equal = numbers
        .iter()
        .filter(|number| number.units(number.ours) == 0)
        .count();
    let form = &valve.leading_order;
    let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
    let moved = |v: [f64; 2]| [dot(form.a[0], v), dot(form.a[1], v)];
    report.paragraph(format!(
        "{equal} of {} numbers agree to the last printed digit. $E$ agrees at the paper's own rounding of $q^*$, where in turn \
         $D$ differs by a unit. $A_{{12}}$, $A_{{22}}$ and through them $CAB$ differ by one or two units: $A$ and \
         $F$ come from an integration, and ours is good to fourteen digits. $CAE + CF + D$ is the sum of {:.5}, {:.5} and \
         {:.5}, which nearly cancel: an error of 2 in the sixth digit of $F$ or $A$ becomes one of tens of units in the \
         sum.",
        numbers.len(),
        dot([form.c[0], form.c[1]], moved(form.e)),
        dot([form.c[0], form.c[1]], [form.f[0], form.f[1]]),
        form.d
    ));
}
