//! Guesses at what the author of a faulty expression meant.

use super::graph::Function;

/// What a function's name in text stands for.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) enum Callable {
    Function(Function),
    SquareRoot,
}

const FUNCTIONS: [(&str, Callable); 13] = [
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
];

/// The name of the circle constant.
pub(super) const PI: &str = "pi";

/// Habits from other notations and languages.
const ALIASES: [(&str, &str); 20] = [
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
];

/// The names of the functions, in the order they are listed to a reader.
pub(super) fn function_names() -> impl Iterator<Item = &'static str> {
    FUNCTIONS.iter().map(|&(name, _)| name)
}

/// The function of that name.
pub(super) fn callable(name: &str) -> Option<Callable> {
    FUNCTIONS
        .iter()
        .find(|(known, _)| *known == name)
        .map(|&(_, callable)| callable)
}

/// Whether the language keeps `name` for itself: the circle constant and the functions.
pub fn is_reserved(name: &str) -> bool {
    name == PI || callable(name).is_some()
}

/// The function, or formula, that an unknown function may stand for.
pub(super) fn for_function(name: &str) -> Option<String> {
    let lower = name.to_lowercase();
    ALIASES
        .iter()
        .find(|(alias, _)| *alias == lower)
        .map(|&(_, meant)| meant.to_string())
        .or_else(|| nearest(name, function_names()))
}

/// The name that an unknown one may stand for, among those `known` and the circle constant.
pub(super) fn for_name(name: &str, known: &[&str]) -> Option<String> {
    let by_habit = match name {
        "π" => Some(PI),
        "e" => Some("exp(1)"),
        _ => None,
    };
    by_habit
        .map(str::to_string)
        .or_else(|| nearest(name, known.iter().copied().chain([PI])))
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

/// What to write for a character that other keyboards and notations offer.
pub(super) fn for_character(character: char) -> Option<String> {
    let meant = match character {
        '−' | '–' | '—' | '‐' | '‑' => "-",
        '·' | '×' | '⋅' | '∙' | '•' | '∗' => "*",
        '÷' | '∕' | '⁄' | ':' => "/",
        '²' => "^2",
        '³' => "^3",
        '√' => "sqrt",
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
