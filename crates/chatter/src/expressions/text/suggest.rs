//! Guesses at what the author of a faulty expression meant.

use crate::expressions::graph::Function;

/// What a function's name in text stands for.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(in crate::expressions) enum Callable {
    Function(Function),
    SquareRoot,
    Abs,
    Sign,
    Min,
    Max,
    Clamp,
    Step,
    If,
    Mod,
    Floor,
    Atan2,
    Hypot,
}

/// How many arguments a function takes.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(in crate::expressions) enum Arity {
    Exactly(usize),
    AtLeast(usize),
}

impl Arity {
    pub fn allows(self, count: usize) -> bool {
        match self {
            Self::Exactly(wanted) => count == wanted,
            Self::AtLeast(least) => count >= least,
        }
    }

    pub fn words(self) -> &'static str {
        match self {
            Self::Exactly(1) => "one argument",
            Self::Exactly(2) => "two arguments",
            Self::Exactly(_) => "three arguments",
            Self::AtLeast(_) => "two arguments or more",
        }
    }
}

impl Callable {
    pub fn arity(self) -> Arity {
        match self {
            Self::Function(_)
            | Self::SquareRoot
            | Self::Abs
            | Self::Sign
            | Self::Step
            | Self::Floor => Arity::Exactly(1),
            Self::Mod | Self::Atan2 | Self::Hypot => Arity::Exactly(2),
            Self::Clamp | Self::If => Arity::Exactly(3),
            Self::Min | Self::Max => Arity::AtLeast(2),
        }
    }
}

const FUNCTIONS: [(&str, Callable); 24] = [
    ("sqrt", Callable::SquareRoot),
    ("exp", Callable::Function(Function::Exp)),
    ("log", Callable::Function(Function::Ln)),
    ("ln", Callable::Function(Function::Ln)),
    ("sin", Callable::Function(Function::Sin)),
    ("cos", Callable::Function(Function::Cos)),
    ("tan", Callable::Function(Function::Tan)),
    ("asin", Callable::Function(Function::Asin)),
    ("acos", Callable::Function(Function::Acos)),
    ("atan", Callable::Function(Function::Atan)),
    ("sinh", Callable::Function(Function::Sinh)),
    ("cosh", Callable::Function(Function::Cosh)),
    ("tanh", Callable::Function(Function::Tanh)),
    ("abs", Callable::Abs),
    ("sign", Callable::Sign),
    ("min", Callable::Min),
    ("max", Callable::Max),
    ("clamp", Callable::Clamp),
    ("step", Callable::Step),
    ("if", Callable::If),
    ("mod", Callable::Mod),
    ("floor", Callable::Floor),
    ("atan2", Callable::Atan2),
    ("hypot", Callable::Hypot),
];

/// The name of the circle constant.
pub(in crate::expressions) const PI: &str = "pi";

/// Habits from other notations and languages.
const ALIASES: [(&str, &str); 39] = [
    ("arcsin", "asin"),
    ("arccos", "acos"),
    ("arctan", "atan"),
    ("arcsinh", "log(x + sqrt(x^2 + 1))"),
    ("asinh", "log(x + sqrt(x^2 + 1))"),
    ("arccosh", "log(x + sqrt(x^2 - 1))"),
    ("acosh", "log(x + sqrt(x^2 - 1))"),
    ("arctanh", "log((1 + x)/(1 - x))/2"),
    ("atanh", "log((1 + x)/(1 - x))/2"),
    ("tg", "tan"),
    ("arctg", "atan"),
    ("cot", "1/tan"),
    ("sec", "1/cos"),
    ("csc", "1/sin"),
    ("log10", "log(x)/log(10)"),
    ("log2", "log(x)/log(2)"),
    ("pow", "x^y"),
    ("cbrt", "x^(1/3)"),
    ("root", "sqrt"),
    ("√", "sqrt"),
    ("sgn", "sign"),
    ("signum", "sign"),
    ("fabs", "abs"),
    ("heaviside", "step"),
    ("theta", "step"),
    ("ceil", "-floor(-x)"),
    ("round", "floor(x + 0.5)"),
    ("trunc", "sign(x)*floor(abs(x))"),
    ("fmod", "mod"),
    ("where", "if"),
    ("ifelse", "if"),
    ("piecewise", "if"),
    ("norm", "hypot"),
    ("arctan2", "atan2"),
    ("tan2", "atan2"),
    ("sind", "sin(x*pi/180)"),
    ("cosd", "cos(x*pi/180)"),
    ("tand", "tan(x*pi/180)"),
    ("radians", "x*pi/180"),
];

/// The names of the functions, in the order they are listed to a reader.
pub(in crate::expressions) fn function_names() -> impl Iterator<Item = &'static str> {
    FUNCTIONS.iter().map(|&(name, _)| name)
}

/// The function of that name.
pub(in crate::expressions) fn callable(name: &str) -> Option<Callable> {
    FUNCTIONS
        .iter()
        .find(|(known, _)| *known == name)
        .map(|&(_, callable)| callable)
}

/// Whether the language keeps `name` for itself: the circle constant and the functions.
pub fn is_reserved(name: &str) -> bool {
    name == PI
        || callable(name).is_some()
        || crate::expressions::graph::condition::WORDS.contains(&name)
}

/// The function, or formula, that an unknown function may stand for, among those of the language and these tables.
pub(in crate::expressions) fn for_function<'a>(
    name: &str,
    tables: impl Iterator<Item = &'a str>,
) -> Option<String> {
    alias(&name.to_lowercase())
        .map(str::to_string)
        .or_else(move || {
            nearest(
                name,
                function_names()
                    .map(|name| -> &'a str { name })
                    .chain(tables),
            )
        })
}

/// The name that an unknown one may stand for, among those `known` and the circle constant.
pub(in crate::expressions) fn for_name(name: &str, known: &[&str]) -> Option<String> {
    let by_habit = match name {
        "π" => Some(PI),
        "e" => Some("exp(1)"),
        _ => None,
    };
    by_habit
        .map(str::to_string)
        .or_else(|| as_product(name, known))
        .or_else(|| nearest(name, known.iter().copied().chain([PI])))
}

/// Most factors that a name is looked at as a product of.
const MOST_FACTORS: usize = 3;

/// The product of known names that `name` is when they are written side by side: `pi*t` for `πt`, `k*x` for `kx`.
pub(in crate::expressions) fn as_product(name: &str, known: &[&str]) -> Option<String> {
    let factors = factors(name, known, MOST_FACTORS)?;
    let is_new = |(place, factor): (usize, &&str)| !factors[..place].contains(factor);
    let all_differ = factors.iter().enumerate().all(is_new);
    all_differ.then(|| factors.join("*"))
}

/// The known names that make `name` when written one after the other, at most `most`.
fn factors<'a>(name: &'a str, known: &[&str], most: usize) -> Option<Vec<&'a str>> {
    if name.is_empty() {
        return Some(Vec::new());
    }
    let fewer = most.checked_sub(1)?;
    let ends = name.char_indices().map(|(at, c)| at + c.len_utf8());
    ends.rev().find_map(|end| {
        let (first, rest) = name.split_at(end);
        let first = match first {
            "π" => PI,
            _ if first == PI || known.contains(&first) => first,
            _ => return None,
        };
        let mut all = vec![first];
        all.extend(factors(rest, known, fewer)?);
        Some(all)
    })
}

/// What to write for a name with points in it: what its last part is or stands for.
pub(in crate::expressions) fn for_qualified(name: &str) -> Option<String> {
    let last = name.rsplit('.').next()?;
    let lower = last.to_lowercase();
    Some(if is_reserved(&lower) {
        lower
    } else {
        alias(&lower).unwrap_or(last).to_owned()
    })
}

/// What a habit from elsewhere is called here.
fn alias(name: &str) -> Option<&'static str> {
    ALIASES
        .iter()
        .find(|(alias, _)| *alias == name)
        .map(|&(_, meant)| meant)
}

/// The known name nearest to `name`, if it is near enough to be meant: a third of its letters wrong, or its case.
pub fn nearest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<String> {
    let lower = name.to_lowercase();
    let allowed = (name.chars().count() / 3).max(1);
    known
        .into_iter()
        .map(|candidate| {
            let distance = strsim::damerau_levenshtein(&lower, &candidate.to_lowercase());
            (distance, candidate)
        })
        .filter(|&(distance, candidate)| {
            distance <= allowed && distance < candidate.chars().count()
        })
        .min_by_key(|&(distance, _)| distance)
        .map(|(_, candidate)| candidate.to_string())
}

/// What to write for the character that a text begins with, one that other keyboards and notations offer; nothing, where it is to be
/// left out.
pub(in crate::expressions) fn for_character(text: &str) -> Option<String> {
    let character = text.chars().next()?;
    let mut following = text.chars().skip(1).skip_while(|c| c.is_whitespace());
    let goes_on = following
        .next()
        .is_some_and(|c| c.is_alphanumeric() || "(_.".contains(c));
    let meant = match character {
        '−' | '–' | '—' | '‐' | '‑' => "-",
        '·' | '×' | '⋅' | '∙' | '•' | '∗' => "*",
        '÷' | '∕' | '⁄' | ':' => "/",
        '²' => "^2",
        '³' => "^3",
        '√' => "sqrt",
        '?' => "if(condition, value, other)",
        '&' => "and",
        '|' if text.starts_with("||") => "or",
        '|' => "abs(x)",
        '!' | '¬' if goes_on => "not",
        '%' if goes_on => "mod(x, m)",
        '%' => "/100",
        '°' => "*pi/180",
        ';' | '$' | '`' | '“' | '”' | '„' | '‘' | '’' => "",
        '[' | '{' => "(",
        ']' | '}' => ")",
        '₀'..='₉' => {
            let digit = u32::from(character) - u32::from('₀');
            return char::from_digit(digit, 10).map(String::from);
        }
        _ => return None,
    };
    Some(meant.to_string())
}
