//! The full text of every error, and what it underlines.

use super::read;
use crate::expressions::{DEEPEST_NESTING, Graph, LONGEST_TEXT, ParseErrorKind};

/// `marked` is the text with the wrong part between ⟦ and ⟧.
fn check(marked: &str, expected: &str) {
    let start = marked.find('⟦').expect("a start mark");
    let text = marked.replace(['⟦', '⟧'], "");
    let end = marked.find('⟧').expect("an end mark") - '⟦'.len_utf8();
    let error = read(&mut Graph::default(), &text).expect_err(&text);
    assert_eq!(error.to_string(), expected, "{text}");
    assert_eq!(error.span, start..end, "{text}");
}

#[test]
fn names() {
    check("-⟦kapa⟧*x", "unknown name `kapa`; did you mean `kappa`?");
    check("⟦Kappa⟧", "unknown name `Kappa`; did you mean `kappa`?");
    check("2*⟦omega⟧", "unknown name `omega`");
    check("⟦π⟧/2", "unknown name `π`; did you mean `pi`?");
    check("⟦PI⟧", "unknown name `PI`; did you mean `pi`?");
    check("⟦e⟧^x", "unknown name `e`; did you mean `exp(1)`?");
    check("⟦w⟧", "unknown name `w`");
    check("⟦kappax⟧", "unknown name `kappax`; did you mean `kappa*x`?");
    check(
        "sin(⟦2πx⟧)",
        "unknown name `πx` after a number, which has no unit; write `2*pi*x`",
    );
}

#[test]
fn functions() {
    check(
        "⟦arcsin⟧(x)",
        "unknown function `arcsin`; did you mean `asin`?",
    );
    check("⟦Sqrt⟧(x)", "unknown function `Sqrt`; did you mean `sqrt`?");
    check("⟦sqr⟧(x)", "unknown function `sqr`; did you mean `sqrt`?");
    check("⟦sgn⟧(y)", "unknown function `sgn`; did you mean `sign`?");
    check(
        "⟦ceil⟧(y)",
        "unknown function `ceil`; did you mean `-floor(-x)`?",
    );
    check(
        "⟦max(x)⟧",
        "`max` takes two arguments or more, but 1 is given",
    );
    check(
        "⟦if(x > 0, y)⟧",
        "`if` takes three arguments, but 2 are given",
    );
    check(
        "if(⟦x⟧, 1, 2)",
        "the first argument of `if` is a condition such as `x > 0`, not a number",
    );
    check(
        "1 + (x ⟦<⟧ 1)",
        "a comparison is true or false and no number: it stands in `if(x > 0, a, b)`",
    );
    check(
        "x ⟦and⟧ y",
        "`and` joins conditions: it stands in the first argument of `if`",
    );
    check(
        "if(x ⟦=⟧= 1, 1, 2)",
        "unexpected `=`: conditions compare by `<` and `>`, and what is zero somewhere is written without `= 0`",
    );
    check("⟦pow⟧(x, 2)", "unknown function `pow`; did you mean `x^y`?");
    check(
        "⟦log10⟧(x)",
        "unknown function `log10`; did you mean `log(x)/log(10)`?",
    );
    check(
        "⟦erfc⟧(x)",
        "unknown function `erfc`; there are sqrt, exp, log, ln, sin, cos, tan, asin, acos, atan, sinh, cosh, tanh, abs, sign, min, max, clamp, step, if, mod, floor, atan2, hypot",
    );
    check(
        "1 + ⟦sin(x, y)⟧",
        "`sin` takes one argument, but 2 are given",
    );
    check("⟦sqrt()⟧", "`sqrt` takes one argument, but 0 are given");
    check(
        "⟦sin⟧ x",
        "the function `sin` needs its argument in parentheses; write `sin(x)`",
    );
    check(
        "2*⟦cos⟧",
        "the function `cos` needs its argument in parentheses; write `cos(…)`",
    );
    check(
        "⟦kappa⟧(x + 1)",
        "`kappa` is not a function; an operator is missing before `(`; write `kappa*(`",
    );
    check(
        "⟦pi⟧()",
        "`pi` is not a function; an operator is missing before `(`; write `pi`",
    );
    check(
        "⟦sind⟧(x)",
        "unknown function `sind`; did you mean `sin(x*pi/180)`?",
    );
    check(
        "⟦tan2⟧(y, x)",
        "unknown function `tan2`; did you mean `atan2`?",
    );
    check(
        "⟦pi⟧(2)",
        "`pi` is not a function; an operator is missing before `(`; write `pi*(`",
    );
}

#[test]
fn missing_operators() {
    check(
        "⟦2x⟧",
        "expected an operator between `2` and `x`; write `2*x`",
    );
    check(
        "⟦2(⟧x + 1)",
        "expected an operator between `2` and `(`; write `2*(`",
    );
    check(
        "(x⟦)(⟧y)",
        "expected an operator between `)` and `(`; write `)*(`",
    );
    check(
        "sin(⟦x y⟧)",
        "expected an operator between `x` and `y`; write `x*y`",
    );
    check(
        "x^2 + ⟦y 3⟧",
        "expected an operator between `y` and `3`; write `y*3`",
    );
    check(
        "⟦2exp⟧(x)",
        "expected an operator between `2` and `exp`; write `2*exp`",
    );
}

#[test]
fn missing_operands() {
    check(
        "x +⟦⟧",
        "expected a number, a name or `(` after `+`, but the expression ends",
    );
    check(
        "x + ⟦*⟧ y",
        "expected a number, a name or `(` after `+`, found `*`",
    );
    check("⟦*⟧x", "expected a number, a name or `(`, found `*`");
    check(
        "(x - ⟦)⟧",
        "expected a number, a name or `(` after `-`, found `)`",
    );
    check(
        "(⟦)⟧",
        "expected a number, a name or `(` after `(`, found `)`",
    );
    check(
        "sin(x,⟦)⟧",
        "expected a number, a name or `(` after `,`, found `)`",
    );
    check(
        "sin(⟦,⟧ x)",
        "expected a number, a name or `(` after `(`, found `,`",
    );
    check(
        "2^⟦⟧",
        "expected a number, a name or `(` after `^`, but the expression ends",
    );
    check(
        "(x + ⟦⟧",
        "expected a number, a name or `(` after `+`, but the expression ends",
    );
    check(
        "x ^ ⟦/⟧ 2",
        "expected a number, a name or `(` after `^`, found `/`",
    );
    check(
        "-⟦⟧",
        "expected a number, a name or `(` after `-`, but the expression ends",
    );
}

#[test]
fn parentheses() {
    check("beta*⟦(⟧q - x", "this parenthesis is never closed");
    check("⟦(⟧(x + y)", "this parenthesis is never closed");
    check("((x + ⟦(⟧", "this parenthesis is never closed");
    check("sin⟦(⟧", "this parenthesis is never closed");
    check("sqrt⟦(⟧x", "this parenthesis is never closed");
    check("x + y⟦)⟧", "this parenthesis was never opened");
    check("⟦)⟧", "this parenthesis was never opened");
    check("x + ⟦)⟧", "this parenthesis was never opened");
}

#[test]
fn characters_and_numbers() {
    check(
        "x ⟦=⟧ 2",
        "unexpected `=`: conditions compare by `<` and `>`, and what is zero somewhere is written without `= 0`",
    );
    check("x ⟦−⟧ y", "unexpected character `−`; write `-`");
    check("x⟦²⟧", "unexpected character `²`; write `^2`");
    check("x ⟦·⟧ y", "unexpected character `·`; write `*`");
    check("⟦[⟧x]", "unexpected character `[`; write `(`");
    check(
        "x⟦[⟧0]",
        "unexpected character `[`; quantities go by their names, such as `x1`, not by numbers",
    );
    check("Sin⟦[⟧x]", "unexpected character `[`; write `(`");
    check(
        "⟦\\⟧frac{x}{2}",
        "unexpected character `\\`; plain text is read, not LaTeX: `a/b`, `sin(x)`, `omega`",
    );
    check("x⟦//⟧y", "unexpected character `/`; write `floor(x/y)`");
    for (marked, name, meant) in [
        ("⟦np.sin⟧(x)", "np.sin", "sin"),
        ("⟦Math.PI⟧*x", "Math.PI", "pi"),
        ("2*⟦math.pow⟧(x, 2)", "math.pow", "x^y"),
        ("⟦self.model.k⟧*x", "self.model.k", "k"),
    ] {
        check(
            marked,
            &format!("`{name}` has a point in it, as no name here; write `{meant}`"),
        );
    }
    check("y⟦₁⟧", "unexpected character `₁`; write `1`");
    check(
        "y⟦'⟧",
        "unexpected character `'`; a rate goes by a name: with y = \"v\" that of `y` is `v`",
    );
    check("x⟦;⟧", "unexpected character `;`; leave it out");
    check("⟦“⟧x”", "unexpected character `“`; leave it out");
    check("50⟦%⟧", "unexpected character `%`; write `/100`");
    check("x ⟦%⟧ 2", "unexpected character `%`; write `mod(x, m)`");
    check("sin(30⟦°⟧)", "unexpected character `°`; write `*pi/180`");
    check("x⟦!⟧", "unexpected character `!`");
    check("x⟦.*⟧y", "unexpected character `.`; write `*`");
    check(
        "x ⟦#⟧ y",
        "unexpected character `#`; comments stand outside the quotes",
    );
    check("⟦1e⟧*x", "`1e` is not a number");
    check("x⟦\u{0}⟧", "unexpected character `\\0`");
    check("x + ⟦1.2.3⟧", "`1.2.3` is not a number");
    check("⟦.⟧", "`.` is not a number");
    check(
        "⟦10_000⟧",
        "`10_000` is not a number; did you mean `10000`?",
    );
    check(
        "1⟦,⟧5*x",
        "unexpected `,`; the decimal sign is a point; did you mean `.`?",
    );
    check("(x⟦,⟧ y)", "unexpected `,`; the decimal sign is a point");
    check(
        "⟦1e999⟧",
        "the number `1e999` is out of range; sizes between 5e-324 and 1.7e308 can be held",
    );
    check(
        "x*⟦1e-999⟧",
        "the number `1e-999` is out of range; sizes between 5e-324 and 1.7e308 can be held",
    );
    check("⟦⟧", "the expression is empty");
    check("⟦ \n⟧", "the expression is empty");
}

#[test]
fn hostile_lengths_and_depths_are_refused() {
    let kind = |text: &str| read(&mut Graph::default(), text).unwrap_err().kind;
    let within = DEEPEST_NESTING - 1;
    for (open, close) in [
        ("(", ")"),
        ("sin(", ")"),
        ("-", ""),
        ("x^", ""),
        ("x^-(", ")"),
    ] {
        let nest = |times: usize| format!("{}x{}", open.repeat(times), close.repeat(times));
        assert_eq!(
            kind(&nest(20_000.min(60_000 / open.len() / 2))),
            ParseErrorKind::TooDeep
        );
        let levels = if open == "x^-(" { within / 3 } else { within };
        assert!(read(&mut Graph::default(), &nest(levels)).is_ok(), "{open}");
    }
    assert_eq!(kind(&"(".repeat(60_000)), ParseErrorKind::TooDeep);
    let long = "x + ".repeat(LONGEST_TEXT / 4) + "x";
    assert_eq!(kind(&long), ParseErrorKind::TooLong { bytes: long.len() });
}

#[test]
fn the_longest_sums_and_products_are_read_at_once() {
    let mut graph = Graph::default();
    let sum: Vec<String> = (1..7000).map(|power| format!("x^{power}")).collect();
    assert!(read(&mut graph, &sum.join("+")).is_ok());
    let product: Vec<String> = (1..5000).map(|factor| format!("sin({factor}*x)")).collect();
    assert!(read(&mut graph, &product.join("*")).is_ok());
    assert!(graph.len() < 40_000, "{}", graph.len());
}
