//! Tapes as C++: the same operations in the same sequence, with the same fused ones, as the interpreter runs.
//!
//! A tape becomes a structure of templates on the number that they compute with. What a line calls is written by hand, so that the text
//! is short enough to be read, and says nothing that the tape does not: `benches/peers/cuda/series.h` has what the valve's lines call.
//! Compilers must not fuse operations of their own, nor reorder them.

use super::graph::{Expr, Function, Graph, Node, Symbol};
use super::tape::{Op, Operand, Sign, Tape};
use core::fmt;

/// What has no C++: a choice, a whole part or a curve among the constants of a tape. Where the motion depends on one, its mode has
/// settled it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NoSource;

impl fmt::Display for NoSource {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(
            "a constant is a choice, a whole part or a curve, which cannot be written as C++",
        )
    }
}

impl core::error::Error for NoSource {}

impl Tape {
    /// A structure of this name, which computes what the tape does. The graph holds the expressions of its constants.
    pub(crate) fn source(&self, graph: &Graph, name: &str) -> Result<String, NoSource> {
        let mut body = String::new();
        self.constants_source(graph, &mut body)?;
        self.orders_source(&mut body);
        self.outputs_source(&mut body);
        Ok(format!(
            "struct {name} {{\n    static constexpr int STATES = {}, SERIES = {}, INVERSES = {}, CONSTANTS = {}, OUTPUTS = {};\n{body}}};\n",
            self.dimension,
            self.slots,
            self.auxiliaries,
            self.constants.len(),
            self.outputs.len(),
        ))
    }

    /// What parameters `p` alone give.
    fn constants_source(&self, graph: &Graph, out: &mut String) -> Result<(), NoSource> {
        head(
            out,
            "CHATTER_FUNCTION static void constants(const double *p, double *c) {",
        );
        let parts = graph.reachable(&self.constants);
        for &part in &parts {
            let value = constant(graph, part).ok_or(NoSource)?;
            statement(out, &format!("const double e{} = {value};", part.index()));
        }
        for (index, expr) in self.constants.iter().enumerate() {
            statement(out, &format!("c[{index}] = e{};", expr.index()));
        }
        head(out, "}");
        Ok(())
    }

    /// Coefficients of order zero, then of order k: those of states are one order ahead.
    fn orders_source(&self, out: &mut String) {
        let takes = "Series<S, N> x, S *low, S *inverse, S factor";
        head(out, "template <class S, int N>");
        head(
            out,
            &format!("CHATTER_FUNCTION static void begin(const S *c, {takes}) {{"),
        );
        for op in &self.ops {
            statement(out, &self.of_order_zero(op));
        }
        for &(state, derivative) in &self.field {
            statement(
                out,
                &format!("if (N > 1) x[{state}][1] = {} * factor;", first(derivative)),
            );
        }
        head(out, "}");
        if self.is_at_point() {
            return;
        }
        head(out, "template <class S, int N>");
        let takes =
            "int k, int last, const S *c, Series<S, N> x, const S *inverse, S factor, S reciprocal";
        head(
            out,
            &format!("CHATTER_FUNCTION static void go_on({takes}) {{"),
        );
        for op in &self.ops {
            statement(out, &self.of_order(op));
        }
        for &(state, derivative) in &self.field {
            let value = match derivative {
                Operand::Series(of) => format!("x[{of}][k] * factor"),
                Operand::Constant(_) => "S(0.0)".to_owned(),
            };
            statement(out, &format!("if (k < last) x[{state}][k + 1] = {value};"));
        }
        head(out, "}");
    }

    /// Whether it integrates nothing: what it gives are values at a point.
    fn is_at_point(&self) -> bool {
        self.field.is_empty() && !self.ops.iter().any(|op| matches!(op, Op::Rate { .. }))
    }

    fn of_order_zero(&self, op: &Op) -> String {
        match *op {
            Op::Linear {
                out,
                offset,
                first,
                end,
            } => {
                let sum = self.compensated(offset, (first, end));
                format!("{sum}.into(x[{out}][0], low[{out}]);")
            }
            Op::Rate {
                state,
                offset,
                first,
                end,
            } => {
                let sum = self.compensated(offset, (first, end));
                format!("if (N > 1) x[{state}][1] = {sum}.value() * factor;")
            }
            Op::Multiply { out, left, right } => {
                format!("x[{out}][0] = x[{left}][0] * x[{right}][0];")
            }
            Op::Square { out, base } => format!("x[{out}][0] = self_convolution(x[{base}], 0);"),
            Op::Divide {
                out,
                numerator,
                denominator,
                inverse,
            } => format!(
                "inverse[{inverse}] = S(1.0) / x[{denominator}][0], x[{out}][0] = {} / x[{denominator}][0];",
                first(numerator)
            ),
            Op::SquareRoot {
                out,
                radicand,
                inverse,
            } => format!(
                "x[{out}][0] = square_root(x[{radicand}][0]), inverse[{inverse}] = S(0.5) / x[{out}][0];"
            ),
            Op::Power {
                out,
                base,
                exponent,
                inverse,
            } => format!(
                "inverse[{inverse}] = S(1.0) / x[{base}][0], x[{out}][0] = power(x[{base}][0], c[{exponent}]);"
            ),
            Op::Slope { out, .. } => format!("x[{out}][0] = S(0.0);"),
            Op::Integral {
                out,
                argument,
                function,
                ..
            } => {
                format!("x[{out}][0] = {}(x[{argument}][0]);", named(function))
            }
            Op::SineCosine {
                sine,
                cosine,
                argument,
                ..
            } => format!(
                "sine_cosine(x[{argument}][0], low[{argument}], x[{sine}][0], x[{cosine}][0]);"
            ),
        }
    }

    fn of_order(&self, op: &Op) -> String {
        match *op {
            Op::Linear {
                out, first, end, ..
            } => format!("x[{out}][k] = {};", self.sum((first, end))),
            Op::Rate {
                state, first, end, ..
            } => {
                let value = match self.terms[first..end].split_last() {
                    None => "S(0.0)".to_owned(),
                    Some((&(coefficient, slot), [])) => {
                        format!("x[{slot}][k] * (c[{coefficient}] * factor)")
                    }
                    Some((&(coefficient, slot), _)) => format!(
                        "fused(x[{slot}][k], c[{coefficient}] * factor, {} * factor)",
                        self.sum((first, end - 1))
                    ),
                };
                format!("if (k < last) x[{state}][k + 1] = {value};")
            }
            Op::Multiply { out, left, right } => {
                format!("x[{out}][k] = convolution(x[{left}], x[{right}], k + 1);")
            }
            Op::Square { out, base } => format!("x[{out}][k] = self_convolution(x[{base}], k);"),
            Op::Divide {
                out,
                numerator,
                denominator,
                inverse,
            } => {
                let rest = format!(
                    "-(convolution(x[{out}], x[{denominator}] + 1, k) * inverse[{inverse}])"
                );
                match numerator {
                    Operand::Series(slot) => {
                        format!("x[{out}][k] = fused(x[{slot}][k], inverse[{inverse}], {rest});")
                    }
                    Operand::Constant(_) => format!("x[{out}][k] = {rest};"),
                }
            }
            Op::SquareRoot {
                out,
                radicand,
                inverse,
            } => {
                format!(
                    "x[{out}][k] = root_coefficient(x[{out}], x[{radicand}][k], inverse[{inverse}], k);"
                )
            }
            Op::Power {
                out,
                base,
                exponent,
                inverse,
            } => format!(
                "x[{out}][k] = power_coefficient(x[{out}], x[{base}], c[{exponent}], inverse[{inverse}], reciprocal, k);"
            ),
            Op::Slope { out, of } => format!("x[{out}][k] = x[{of}][k] * S(double(k));"),
            Op::Integral {
                out,
                slope,
                argument,
                weight,
                sign,
                ..
            } => {
                let minus = if sign == Sign::Minus { "-" } else { "" };
                format!(
                    "x[{out}][k] = {minus}{};",
                    integral(slope, argument, weight)
                )
            }
            Op::SineCosine {
                sine,
                cosine,
                slope,
                argument,
            } => format!(
                "x[{sine}][k] = {}, x[{cosine}][k] = -{};",
                integral(slope, argument, cosine),
                integral(slope, argument, sine)
            ),
        }
    }

    /// A linear combination of order zero in twice the precision.
    fn compensated(&self, offset: Option<usize>, (first, end): (usize, usize)) -> String {
        let offset = offset.map_or("S(0.0)".to_owned(), |index| format!("c[{index}]"));
        let mut text = format!("Compensated<S>({offset})");
        for &(coefficient, slot) in &self.terms[first..end] {
            text += &format!(".add(c[{coefficient}], x[{slot}][0], low[{slot}])");
        }
        text
    }

    /// A linear combination of an order above zero.
    fn sum(&self, (first, end): (usize, usize)) -> String {
        (self.terms[first..end].iter()).fold("S(0.0)".to_owned(), |sum, (coefficient, slot)| {
            format!("fused(c[{coefficient}], x[{slot}][k], {sum})")
        })
    }

    /// Which series each output is, or which constant, as -1 less its number; and what its value of order zero is rounded against.
    fn outputs_source(&self, out: &mut String) {
        head(
            out,
            "CHATTER_FUNCTION static constexpr int output(int index) {",
        );
        let mut text = "return ".to_owned();
        for (index, output) in self.outputs.iter().enumerate() {
            let place = match *output {
                Operand::Series(slot) => slot.to_string(),
                Operand::Constant(constant) => format!("-1 - {constant}"),
            };
            text += &format!("index == {index} ? {place} : ");
        }
        statement(out, &format!("{text}0;"));
        head(out, "}");
        head(out, "template <class S, int N>");
        head(
            out,
            "CHATTER_FUNCTION static S size_of_terms(int series, const S *c, Series<S, N> x) {",
        );
        for op in &self.ops {
            if let Op::Linear {
                out: series,
                offset,
                first,
                end,
            } = *op
            {
                let mut sum =
                    offset.map_or("S(0.0)".to_owned(), |index| format!("absolute(c[{index}])"));
                for &(coefficient, slot) in &self.terms[first..end] {
                    sum += &format!(" + absolute(c[{coefficient}] * x[{slot}][0])");
                }
                statement(out, &format!("if (series == {series}) return {sum};"));
            }
        }
        statement(out, "return absolute(x[series][0]);");
        head(out, "}");
    }
}

fn head(out: &mut String, text: &str) {
    *out += &format!("    {text}\n");
}

fn statement(out: &mut String, text: &str) {
    *out += &format!("        {text}\n");
}

/// An operand's value of order zero.
fn first(operand: Operand) -> String {
    match operand {
        Operand::Series(slot) => format!("x[{slot}][0]"),
        Operand::Constant(index) => format!("c[{index}]"),
    }
}

fn integral(slope: usize, argument: usize, weight: usize) -> String {
    format!("integral(x[{slope}], x[{argument}][k], x[{weight}], reciprocal, k)")
}

fn named(function: Function) -> &'static str {
    match function {
        Function::Exp => "exponential",
        Function::Ln => "logarithm",
        Function::Sin => "sine",
        Function::Cos => "cosine",
        Function::Tan => "tangent",
        Function::Asin => "arc_sine",
        Function::Acos => "arc_cosine",
        Function::Atan => "arc_tangent",
        Function::Sinh => "hyperbolic_sine",
        Function::Cosh => "hyperbolic_cosine",
        Function::Tanh => "hyperbolic_tangent",
    }
}

/// The value of a node without states, from those of its operands, as [`Graph::evaluate`] computes it.
fn constant(graph: &Graph, expr: Expr) -> Option<String> {
    let joined = |parts: &[Expr], by: &str| {
        let names: Vec<String> = parts
            .iter()
            .map(|part| format!("e{}", part.index()))
            .collect();
        names.join(by)
    };
    Some(match graph.node(expr) {
        Node::Number(number) => number_source(number.value().high()),
        Node::Pi => number_source(core::f64::consts::PI),
        Node::Symbol(Symbol::Parameter(index)) => format!("p[{index}]"),
        Node::Sum(terms) => joined(terms, " + "),
        Node::Product(factors) => joined(factors, " * "),
        Node::Power(base, exponent) => {
            format!("constant_power(e{}, e{})", base.index(), exponent.index())
        }
        Node::Call(function, argument) => format!("{}(e{})", named(*function), argument.index()),
        Node::Symbol(Symbol::State(_)) | Node::Switch { .. } | Node::Floor(_) | Node::Curve(..) => {
            return None;
        }
    })
}

/// A number with all its digits.
fn number_source(value: f64) -> String {
    if value.is_finite() {
        format!("{value:?}")
    } else {
        format!("(double){value:?}")
    }
}
