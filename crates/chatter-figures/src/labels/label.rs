//! Labels: plain text with a subset of TeX's mathematics between dollar signs.
//!
//! Understood in mathematics: `_` and `^` with one symbol or a `{group}`, Greek letters (`\lambda`, `\Upsilon`, …),
//! accents (`\dot`, `\ddot`, `\bar`, `\hat`, `\tilde`), upright text (`\mathrm{…}`, `\text{…}`), functions (`\log`,
//! `\sin`, …), relations and operators (`\le`, `\to`, `\times`, …), spaces (`\,`, `\;`, `\ `, `\quad`), `\$`, `\%`,
//! `\_`, `\{`, `\}`. Commands also work outside mathematics, where `_` and `^` stand for themselves.

use std::fmt;

use super::fonts::Face;

/// A label's markup is wrong.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LabelError {
    /// The label.
    pub source: String,
    /// Which character of it, counted from 0.
    pub at: usize,
    /// What is wrong there.
    pub what: String,
}

impl fmt::Display for LabelError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "label: {}", self.what)?;
        writeln!(f, "  {}", self.source)?;
        write!(f, "  {:1$}^", "", self.at)
    }
}

impl std::error::Error for LabelError {}

/// One part of a label.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Node {
    /// One character.
    Char(char, Face),
    /// Empty width in ems; left out inside scripts when it only separates.
    Space(f64, Spacing),
    /// Index and exponent of what stands before.
    Scripts { sub: Vec<Node>, sup: Vec<Node> },
    /// A mark above.
    Accent { mark: char, body: Vec<Node> },
}

/// Why there is a space.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Spacing {
    /// The label asks for it.
    Wanted,
    /// Round an operator or relation.
    Operator,
}

pub(crate) const GREEK: [(&str, char); 38] = [
    ("alpha", 'α'),
    ("beta", 'β'),
    ("gamma", 'γ'),
    ("delta", 'δ'),
    ("epsilon", 'ε'),
    ("varepsilon", 'ε'),
    ("zeta", 'ζ'),
    ("eta", 'η'),
    ("theta", 'θ'),
    ("vartheta", 'ϑ'),
    ("iota", 'ι'),
    ("kappa", 'κ'),
    ("lambda", 'λ'),
    ("mu", 'μ'),
    ("nu", 'ν'),
    ("xi", 'ξ'),
    ("omicron", 'ο'),
    ("pi", 'π'),
    ("rho", 'ρ'),
    ("sigma", 'σ'),
    ("varsigma", 'ς'),
    ("tau", 'τ'),
    ("upsilon", 'υ'),
    ("phi", 'φ'),
    ("varphi", 'φ'),
    ("chi", 'χ'),
    ("psi", 'ψ'),
    ("omega", 'ω'),
    ("Gamma", 'Γ'),
    ("Delta", 'Δ'),
    ("Theta", 'Θ'),
    ("Lambda", 'Λ'),
    ("Xi", 'Ξ'),
    ("Pi", 'Π'),
    ("Sigma", 'Σ'),
    ("Upsilon", 'ϒ'),
    ("Phi", 'Φ'),
    ("Psi", 'Ψ'),
];

pub(crate) const SYMBOLS: [(&str, char); 16] = [
    ("Omega", 'Ω'),
    ("infty", '∞'),
    ("partial", '∂'),
    ("ell", 'ℓ'),
    ("sum", '∑'),
    ("int", '∫'),
    ("prod", '∏'),
    ("ldots", '…'),
    ("dots", '…'),
    ("prime", '′'),
    ("degree", '°'),
    ("circ", '°'),
    ("surd", '√'),
    ("Vert", '‖'),
    ("dagger", '†'),
    ("hbar", 'ħ'),
];

pub(crate) const RELATIONS: [(&str, char); 14] = [
    ("le", '≤'),
    ("leq", '≤'),
    ("ge", '≥'),
    ("geq", '≥'),
    ("ne", '≠'),
    ("neq", '≠'),
    ("approx", '≈'),
    ("equiv", '≡'),
    ("sim", '~'),
    ("to", '→'),
    ("rightarrow", '→'),
    ("leftarrow", '←'),
    ("leftrightarrow", '↔'),
    ("mapsto", '→'),
];

pub(crate) const OPERATORS: [(&str, char); 5] = [
    ("times", '×'),
    ("cdot", '·'),
    ("pm", '±'),
    ("div", '÷'),
    ("cap", '∩'),
];

pub(crate) const ACCENTS: [(&str, char); 6] = [
    ("dot", '˙'),
    ("ddot", '¨'),
    ("bar", '¯'),
    ("hat", 'ˆ'),
    ("tilde", '˜'),
    ("overline", '¯'),
];

pub(crate) const FUNCTIONS: [&str; 16] = [
    "log", "ln", "exp", "sin", "cos", "tan", "sinh", "cosh", "tanh", "arcsin", "arccos", "arctan",
    "min", "max", "lim", "sgn",
];

const THIN: f64 = 3.0 / 18.0;
const MEDIUM: f64 = 4.0 / 18.0;
const THICK: f64 = 5.0 / 18.0;

/// Says whether a text can be drawn as a label.
///
/// # Errors
/// What is wrong with it, and where.
pub fn check(source: &str) -> Result<(), LabelError> {
    parse(source).map(drop)
}

/// Reads a label.
pub(crate) fn parse(source: &str) -> Result<Vec<Node>, LabelError> {
    let mut parser = Parser {
        source,
        chars: source.chars().collect(),
        at: 0,
        upright: false,
    };
    let nodes = parser.text()?;
    Ok(nodes)
}

struct Parser<'a> {
    source: &'a str,
    chars: Vec<char>,
    at: usize,
    /// Letters are upright, as inside `\mathrm`.
    upright: bool,
}

impl Parser<'_> {
    fn error<T>(&self, at: usize, what: impl Into<String>) -> Result<T, LabelError> {
        Err(LabelError {
            source: self.source.to_string(),
            at,
            what: what.into(),
        })
    }

    fn peek(&self) -> Option<char> {
        self.chars.get(self.at).copied()
    }

    fn text(&mut self) -> Result<Vec<Node>, LabelError> {
        let mut nodes = Vec::new();
        while let Some(c) = self.peek() {
            match c {
                '$' => {
                    let open = self.at;
                    self.at += 1;
                    self.math(Some('$'), open, &mut nodes)?;
                }
                '\\' => self.command(&mut nodes)?,
                '-' if self.before_a_digit() => {
                    nodes.push(Node::Char('−', Face::Regular));
                    self.at += 1;
                }
                _ => {
                    nodes.push(plain(c));
                    self.at += 1;
                }
            }
        }
        Ok(nodes)
    }

    /// A hyphen that begins a number is a minus sign.
    fn before_a_digit(&self) -> bool {
        let after = self
            .chars
            .get(self.at + 1)
            .is_some_and(char::is_ascii_digit);
        let before = self.at == 0 || matches!(self.chars[self.at - 1], ' ' | '(' | '[' | '=' | ',');
        after && before
    }

    /// Mathematics up to `end`, which is consumed.
    fn math(
        &mut self,
        end: Option<char>,
        open: usize,
        nodes: &mut Vec<Node>,
    ) -> Result<(), LabelError> {
        loop {
            match self.peek() {
                None if end.is_none() => return Ok(()),
                None => {
                    let end = end.unwrap_or('$');
                    return self.error(open, format!("this has no closing `{end}`"));
                }
                Some(c) if Some(c) == end => {
                    self.at += 1;
                    return Ok(());
                }
                Some('$') => {
                    return self.error(
                        self.at,
                        "`$` inside a group; write `\\$` for the sign itself",
                    );
                }
                Some(_) => self.symbol(nodes)?,
            }
        }
    }

    fn symbol(&mut self, nodes: &mut Vec<Node>) -> Result<(), LabelError> {
        let Some(c) = self.peek() else {
            return self.error(self.at.saturating_sub(1), "a symbol is expected after this");
        };
        match c {
            '{' => {
                let open = self.at;
                self.at += 1;
                return self.math(Some('}'), open, nodes);
            }
            '}' => {
                return self.error(
                    self.at,
                    "this `}` closes nothing; write `\\}` for the sign itself",
                );
            }
            '_' | '^' => return self.script(nodes),
            '\\' => return self.command(nodes),
            ' ' => {}
            '\'' => nodes.push(plain('′')),
            '-' => self.operator('−', nodes),
            '+' | '×' | '±' | '·' => self.operator(c, nodes),
            '=' | '<' | '>' | '≤' | '≥' | '≈' | '≠' | '→' => relation(c, nodes),
            ',' | ';' => {
                nodes.push(plain(c));
                nodes.push(Node::Space(THIN, Spacing::Operator));
            }
            c if c.is_alphabetic() && !self.upright => nodes.push(letter(c)),
            c => nodes.push(plain(c)),
        }
        self.at += 1;
        Ok(())
    }

    /// Spaced as an operator between two terms, close to what follows as a sign.
    fn operator(&self, c: char, nodes: &mut Vec<Node>) {
        let between = nodes.last().is_some_and(|before| match before {
            Node::Char(p, _) => {
                !matches!(p, '(' | '[' | '{' | '|' | ',' | '=' | '<' | '>' | '≤' | '≥')
            }
            Node::Space(_, s) => *s == Spacing::Wanted,
            Node::Scripts { .. } | Node::Accent { .. } => true,
        });
        if between {
            nodes.push(Node::Space(MEDIUM, Spacing::Operator));
        }
        nodes.push(plain(c));
        if between {
            nodes.push(Node::Space(MEDIUM, Spacing::Operator));
        }
    }

    fn script(&mut self, nodes: &mut Vec<Node>) -> Result<(), LabelError> {
        let at = self.at;
        let is_sub = self.chars[at] == '_';
        self.at += 1;
        while self.peek() == Some(' ') {
            self.at += 1;
        }
        let mut body = Vec::new();
        if matches!(self.peek(), None | Some('$' | '_' | '^' | '}')) {
            return self.error(at, "a symbol or a `{group}` is expected after this");
        }
        self.symbol(&mut body)?;
        if !matches!(nodes.last(), Some(Node::Scripts { .. })) {
            nodes.push(Node::Scripts {
                sub: Vec::new(),
                sup: Vec::new(),
            });
        }
        if let Some(Node::Scripts { sub, sup }) = nodes.last_mut() {
            let slot = if is_sub { sub } else { sup };
            if !slot.is_empty() {
                return self.error(at, "a second one at the same symbol; group with `{…}`");
            }
            *slot = body;
        }
        Ok(())
    }

    fn command(&mut self, nodes: &mut Vec<Node>) -> Result<(), LabelError> {
        let start = self.at;
        self.at += 1;
        let Some(first) = self.peek() else {
            return self.error(start, "a command's name is expected after this");
        };
        if !first.is_ascii_alphabetic() {
            self.at += 1;
            match first {
                ',' => nodes.push(Node::Space(THIN, Spacing::Wanted)),
                ':' => nodes.push(Node::Space(MEDIUM, Spacing::Wanted)),
                ';' => nodes.push(Node::Space(THICK, Spacing::Wanted)),
                '!' => nodes.push(Node::Space(-THIN, Spacing::Wanted)),
                ' ' => nodes.push(plain(' ')),
                '$' | '%' | '_' | '{' | '}' | '&' | '#' | '\\' => nodes.push(plain(first)),
                '|' => nodes.push(plain('‖')),
                _ => return self.error(start, format!("`\\{first}` is no known command")),
            }
            return Ok(());
        }
        while self.peek().is_some_and(|c| c.is_ascii_alphabetic()) {
            self.at += 1;
        }
        let name: String = self.chars[start + 1..self.at].iter().collect();
        let find = |table: &[(&str, char)]| table.iter().find(|(n, _)| *n == name).map(|&(_, c)| c);
        if let Some(c) = find(&GREEK) {
            nodes.push(if self.upright { plain(c) } else { letter(c) });
        } else if let Some(c) = find(&SYMBOLS) {
            nodes.push(plain(c));
        } else if let Some(c) = find(&RELATIONS) {
            relation(c, nodes);
        } else if let Some(c) = find(&OPERATORS) {
            self.operator(c, nodes);
        } else if let Some(mark) = find(&ACCENTS) {
            let body = self.argument(start, &name)?;
            nodes.push(Node::Accent { mark, body });
        } else if FUNCTIONS.contains(&name.as_str()) {
            nodes.extend(name.chars().map(plain));
            // A function is set off from its argument, unless that is in parentheses or a script comes first.
            while self.peek() == Some(' ') {
                self.at += 1;
            }
            if !matches!(self.peek(), None | Some('(' | '_' | '^' | '}' | '$' | '|')) {
                nodes.push(Node::Space(THIN, Spacing::Wanted));
            }
        } else {
            match name.as_str() {
                "quad" => nodes.push(Node::Space(1.0, Spacing::Wanted)),
                "qquad" => nodes.push(Node::Space(2.0, Spacing::Wanted)),
                "left" | "right" | "displaystyle" => {}
                "mathrm" | "mathsf" | "operatorname" => {
                    let before = std::mem::replace(&mut self.upright, true);
                    let body = self.argument(start, &name);
                    self.upright = before;
                    nodes.extend(body?);
                }
                "mathit" => nodes.extend(self.argument(start, &name)?),
                "text" | "textrm" => self.verbatim(start, &name, nodes)?,
                _ => return self.error(start, unknown(&name)),
            }
        }
        Ok(())
    }

    /// The symbol or group after a command.
    fn argument(&mut self, start: usize, name: &str) -> Result<Vec<Node>, LabelError> {
        while self.peek() == Some(' ') {
            self.at += 1;
        }
        if matches!(self.peek(), None | Some('$' | '}' | '_' | '^')) {
            return self.error(start, format!("`\\{name}` needs a symbol or a `{{group}}`"));
        }
        let mut body = Vec::new();
        self.symbol(&mut body)?;
        Ok(body)
    }

    /// Text in braces, with its spaces.
    fn verbatim(
        &mut self,
        start: usize,
        name: &str,
        nodes: &mut Vec<Node>,
    ) -> Result<(), LabelError> {
        if self.peek() != Some('{') {
            return self.error(start, format!("`\\{name}` needs a `{{group}}`"));
        }
        let rest = &self.chars[self.at + 1..];
        let Some(length) = rest.iter().position(|&c| c == '}') else {
            return self.error(self.at, "this has no closing `}`");
        };
        nodes.extend(rest[..length].iter().map(|&c| plain(c)));
        self.at += length + 2;
        Ok(())
    }
}

fn plain(c: char) -> Node {
    Node::Char(c, Face::Regular)
}

/// A letter of mathematics: slanted, except Greek capitals.
fn letter(c: char) -> Node {
    let greek_capital = ('Α'..='Ω').contains(&c) || c == 'ϒ';
    Node::Char(
        c,
        if greek_capital {
            Face::Regular
        } else {
            Face::Italic
        },
    )
}

fn relation(c: char, nodes: &mut Vec<Node>) {
    let space = Node::Space(THICK, Spacing::Operator);
    if !nodes.is_empty() {
        nodes.push(space.clone());
    }
    nodes.push(plain(c));
    nodes.push(space);
}

fn unknown(name: &str) -> String {
    let tables: [&[(&str, char)]; 5] = [&GREEK, &SYMBOLS, &RELATIONS, &OPERATORS, &ACCENTS];
    let words = ["mathrm", "text", "quad"];
    let names = tables.iter().flat_map(|t| t.iter().map(|(n, _)| *n));
    let nearest = names
        .chain(FUNCTIONS)
        .chain(words)
        .map(|n| (distance(n, name), n))
        .min();
    match nearest {
        Some((d, n)) if d <= 2 && d < name.chars().count() => {
            format!("`\\{name}` is no known command; did you mean `\\{n}`?")
        }
        _ => format!("`\\{name}` is no known command"),
    }
}

/// Levenshtein distance.
fn distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, ca) in a.chars().enumerate() {
        let mut diagonal = std::mem::replace(&mut row[0], i + 1);
        for (j, &cb) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(ca != cb);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(row[j + 1] + 1);
        }
    }
    row[b.len()]
}

/// A variable's plain name as mathematics: `y1` → `$y_1$`, `mu` → `$\mu$`, `omega_0` → `$\omega_0$`, `x_rel` →
/// `$x_\mathrm{rel}$`, `displacement` → `displacement` (longer words are not mathematics).
pub fn variable(name: &str) -> String {
    let stem_end = name
        .find(|c: char| c == '_' || c.is_ascii_digit())
        .unwrap_or(name.len());
    let (stem, rest) = name.split_at(stem_end);
    let index = rest.trim_start_matches('_');
    let is_greek = GREEK.iter().chain(&SYMBOLS[..1]).any(|(n, _)| *n == stem);
    let base = match stem.chars().count() {
        1 if stem.chars().all(char::is_alphabetic) => stem.to_string(),
        _ if is_greek => format!("\\{stem}"),
        _ => return escape(name),
    };
    // A sign such as `^` says something else there.
    if !index.chars().all(|c| c.is_alphanumeric() || c == '_') {
        return escape(name);
    }
    if index.is_empty() {
        format!("${base}$")
    } else if index.chars().all(|c| c.is_ascii_digit()) {
        match index.len() {
            1 => format!("${base}_{index}$"),
            _ => format!("${base}_{{{index}}}$"),
        }
    } else {
        let index: String = index
            .chars()
            .map(|c| if c == '_' { ',' } else { c })
            .collect();
        format!("${base}_\\mathrm{{{index}}}$")
    }
}

/// Text whose signs stand for themselves.
fn escape(text: &str) -> String {
    text.chars()
        .flat_map(|c| {
            let special = matches!(c, '$' | '\\' | '{' | '}');
            special.then_some('\\').into_iter().chain([c])
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn spelled(source: &str) -> String {
        fn spell(nodes: &[Node]) -> String {
            nodes
                .iter()
                .map(|n| match n {
                    Node::Char(c, Face::Italic) => format!("/{c}"),
                    Node::Char(c, Face::Regular) => c.to_string(),
                    Node::Space(..) => "~".to_string(),
                    Node::Scripts { sub, sup } => format!("_({})^({})", spell(sub), spell(sup)),
                    Node::Accent { mark, body } => format!("{mark}({})", spell(body)),
                })
                .collect()
        }
        spell(&parse(source).unwrap())
    }

    #[test]
    fn mathematics_is_understood() {
        for (source, expected) in [
            ("time (s)", "time (s)"),
            ("$y_1$", "/y_(1)^()"),
            ("$\\dot{x}_{12}^2$", "˙(/x)_(12)^(2)"),
            ("$\\Upsilon(\\mu)$", "ϒ(/μ)"),
            ("$x-1$", "/x~−~1"),
            ("$-1$", "−1"),
            ("$10^{-3}$", "10_()^(−3)"),
            ("$x_\\mathrm{rel} = 2$", "/x_(rel)^()~=~2"),
            ("$\\log\\lambda$", "log~/λ"),
            ("file_name 5\\%", "file_name 5%"),
            ("\\mu", "/μ"),
            ("at -5", "at −5"),
            ("$\\text{a b}c$", "a b/c"),
        ] {
            assert_eq!(spelled(source), expected, "{source}");
        }
    }

    #[test]
    fn what_is_wrong_is_pointed_at() {
        for (source, at, what) in [
            ("a $x", 2, "this has no closing `$`"),
            ("$x_$", 2, "a symbol or a `{group}` is expected after this"),
            (
                "$\\lamda$",
                1,
                "`\\lamda` is no known command; did you mean `\\lambda`?",
            ),
            (
                "$x_{1$",
                5,
                "`$` inside a group; write `\\$` for the sign itself",
            ),
            (
                "$x_1_2$",
                4,
                "a second one at the same symbol; group with `{…}`",
            ),
            (
                "$}$",
                1,
                "this `}` closes nothing; write `\\}` for the sign itself",
            ),
            ("\\", 0, "a command's name is expected after this"),
            ("$\\dot$", 1, "`\\dot` needs a symbol or a `{group}`"),
        ] {
            let error = parse(source).unwrap_err();
            assert_eq!((error.at, error.what.as_str()), (at, what), "{source}");
        }
        assert_eq!(
            parse("a $x").unwrap_err().to_string(),
            "label: this has no closing `$`\n  a $x\n    ^"
        );
    }

    #[test]
    fn names_become_mathematics() {
        for (name, label) in [
            ("y1", "$y_1$"),
            ("mu", "$\\mu$"),
            ("omega_0", "$\\omega_0$"),
            ("x_rel", "$x_\\mathrm{rel}$"),
            ("q", "$q$"),
            ("y12", "$y_{12}$"),
            ("displacement", "displacement"),
            ("Omega", "$\\Omega$"),
            ("impacts_per_return", "impacts_per_return"),
            ("y0^", "y0^"),
        ] {
            assert_eq!(variable(name), label);
            assert!(parse(label).is_ok());
        }
    }

    proptest! {
        #[test]
        fn no_label_brings_the_parser_down(source in "[a-z0-9 $_^{}\\\\α+=.,'-]{0,30}") {
            let _ = parse(&source);
        }

        #[test]
        fn the_label_of_any_name_is_well_formed(name in "\\PC{0,12}") {
            prop_assert!(parse(&variable(&name)).is_ok(), "{}", variable(&name));
        }
    }
}
