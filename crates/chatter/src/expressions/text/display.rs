//! Expressions as formulas: in the notation they are read in, or in TeX.

use super::fraction::{Binding, Fraction, Piece, is_root};
use super::number_text::{NumberText, number_text};
use super::tex_name::tex_name;
use crate::expressions::graph::piecewise::Edge;
use crate::expressions::graph::{Expr, Function, Graph, Node, Symbol};
use crate::numerics::{DoubleDouble, Real};

/// Names of the symbols, by position.
#[derive(Clone, Copy, Debug)]
pub struct Names<'a> {
    /// Names of the states.
    pub states: &'a [String],
    /// Names of the parameters.
    pub parameters: &'a [String],
}

/// Longest formula in bytes, and deepest nesting: a graph of shared parts can be far larger when written out, and
/// nobody reads past this. The rest is `…`.
const LONGEST_FORMULA: usize = 1 << 16;
const DEEPEST_FORMULA: usize = 500;

#[derive(Clone, Copy, PartialEq, Eq)]
enum Notation {
    Text,
    Tex,
}

impl Graph {
    /// The formula in the notation that [`parse`](Self::parse) reads: parentheses where they are needed, `a - b`,
    /// `x/y`, `sqrt(x)`, the shortest digits of each number. Beyond 65536 bytes it ends in `…`.
    pub fn to_text(&self, expr: Expr, names: Names<'_>) -> String {
        Writer::write(self, expr, names, Notation::Text)
    }

    /// The formula in TeX's mathematics mode. `kappa` becomes a Greek letter, `y1` and `y_1` have a subscript.
    pub fn to_tex(&self, expr: Expr, names: Names<'_>) -> String {
        Writer::write(self, expr, names, Notation::Tex)
    }
}

struct Writer<'a> {
    graph: &'a Graph,
    names: Names<'a>,
    notation: Notation,
    out: String,
    depth: usize,
    is_cut: bool,
}

impl<'a> Writer<'a> {
    fn write(graph: &'a Graph, expr: Expr, names: Names<'a>, notation: Notation) -> String {
        let mut writer = Self {
            graph,
            names,
            notation,
            out: String::new(),
            depth: 0,
            is_cut: false,
        };
        writer.formula(expr, Binding::Sum);
        writer.out
    }

    /// Writes `expr`, in parentheses if it holds together less tightly than is needed.
    fn formula(&mut self, expr: Expr, needed: Binding) {
        if self.is_cut {
            return;
        }
        if self.out.len() > LONGEST_FORMULA || self.depth == DEEPEST_FORMULA {
            self.out.push('…');
            self.is_cut = true;
            return;
        }
        self.depth += 1;
        if self.graph.binding(expr) < needed {
            self.parenthesised(|writer| writer.bare(expr));
        } else {
            self.bare(expr);
        }
        self.depth -= 1;
    }

    fn parenthesised(&mut self, write: impl FnOnce(&mut Self)) {
        let (open, close) = match self.notation {
            Notation::Text => ("(", ")"),
            Notation::Tex => (r"\left(", r"\right)"),
        };
        self.out.push_str(open);
        write(self);
        self.out.push_str(close);
    }

    fn bare(&mut self, expr: Expr) {
        match self.graph.node(expr) {
            Node::Pi => self.out.push_str(match self.notation {
                Notation::Text => "pi",
                Notation::Tex => r"\pi",
            }),
            Node::Symbol(symbol) => self.symbol(*symbol),
            Node::Call(function, argument) => {
                self.out.push_str(function_name(*function, self.notation));
                self.parenthesised(|writer| writer.formula(*argument, Binding::Sum));
            }
            Node::Switch { .. } | Node::Floor(_) | Node::Curve(..) => self.piecewise(expr),
            Node::Sum(terms) => {
                for (place, &term) in terms.iter().enumerate() {
                    if self.is_cut {
                        return;
                    }
                    let fraction = self.graph.fraction(term);
                    self.out.push_str(match (place, fraction.negative) {
                        (0, false) => "",
                        (0, true) => "-",
                        (_, false) => " + ",
                        (_, true) => " - ",
                    });
                    self.unsigned(&fraction, Binding::Product);
                }
            }
            // A power with an exponent that is no number: the others are fractions.
            &Node::Power(base, exponent) if self.graph.as_number(exponent).is_none() => {
                self.power(base, |writer| writer.exponent(exponent));
            }
            Node::Number(_) | Node::Product(_) | Node::Power(..) => {
                let fraction = self.graph.fraction(expr);
                if fraction.negative {
                    self.out.push('-');
                }
                self.unsigned(&fraction, Binding::Product);
            }
        }
    }

    /// What is made of pieces, by the name under which it is read again.
    fn piecewise(&mut self, expr: Expr) {
        match *self.graph.node(expr) {
            Node::Floor(argument) => self.called("floor", &[argument]),
            Node::Curve(id, argument, derivative) => {
                let name = format!(
                    "{}{}",
                    self.graph.curve(id).name(),
                    "'".repeat(derivative.into())
                );
                self.called(&name, &[argument]);
            }
            Node::Switch {
                surface,
                above,
                below,
                edge,
            } => {
                let number = |expr| self.graph.as_number(expr).map(|value| value.to_f64());
                match (number(above), number(below), edge) {
                    (Some(1.0), Some(-1.0), Edge::Middle) => self.called("sign", &[surface]),
                    (Some(1.0), Some(0.0), Edge::Above) => self.called("step", &[surface]),
                    _ => self.choice(surface, edge, [above, below]),
                }
            }
            _ => {}
        }
    }

    fn choice(&mut self, surface: Expr, edge: Edge, [above, below]: [Expr; 2]) {
        let compared = match edge {
            Edge::Below => " > 0",
            Edge::Above | Edge::Middle => " >= 0",
        };
        self.out.push_str(match self.notation {
            Notation::Text => "if",
            Notation::Tex => r"\operatorname{if}",
        });
        self.parenthesised(|writer| {
            writer.formula(surface, Binding::Sum);
            writer.out.push_str(compared);
            for piece in [above, below] {
                writer.out.push_str(", ");
                writer.formula(piece, Binding::Sum);
            }
        });
    }

    fn called(&mut self, name: &str, arguments: &[Expr]) {
        match self.notation {
            Notation::Text => self.out.push_str(name),
            Notation::Tex => self.out.push_str(&format!(r"\operatorname{{{name}}}")),
        }
        self.parenthesised(|writer| {
            for (place, &argument) in arguments.iter().enumerate() {
                if place > 0 {
                    writer.out.push_str(", ");
                }
                writer.formula(argument, Binding::Sum);
            }
        });
    }

    /// A fraction without its sign.
    fn unsigned(&mut self, fraction: &Fraction, needed: Binding) {
        if fraction.below.is_empty() {
            self.pieces(&fraction.above, needed);
            return;
        }
        match self.notation {
            Notation::Text => {
                self.pieces(&fraction.above, Binding::Product);
                self.out.push('/');
                if fraction.below.len() == 1 {
                    self.pieces(&fraction.below, Binding::Power);
                } else {
                    self.parenthesised(|writer| writer.pieces(&fraction.below, Binding::Product));
                }
            }
            Notation::Tex => {
                self.out.push_str(r"\frac{");
                self.pieces(&fraction.above, Binding::Sum);
                self.out.push_str("}{");
                self.pieces(&fraction.below, Binding::Sum);
                self.out.push('}');
            }
        }
    }

    /// Factors beside one another; a single one needs only what its surroundings do.
    fn pieces(&mut self, pieces: &[Piece], alone: Binding) {
        let needed = if pieces.len() == 1 {
            alone
        } else {
            Binding::Power
        };
        for (place, piece) in pieces.iter().enumerate() {
            if self.is_cut {
                return;
            }
            if place > 0 {
                self.out.push_str(match (self.notation, piece) {
                    (Notation::Text, _) => "*",
                    (Notation::Tex, Piece::Number(_)) => r" \cdot ",
                    (Notation::Tex, _) => r" \, ",
                });
            }
            match piece {
                Piece::Number(text) => self.number(text),
                Piece::Power(base, weight) => self.numeric_power(*base, *weight, needed),
                Piece::Whole(expr) => self.formula(*expr, needed),
            }
        }
    }

    fn number(&mut self, text: &str) {
        match (self.notation, text.split_once('e')) {
            (Notation::Tex, Some((mantissa, exponent))) => {
                self.out
                    .push_str(&format!(r"{mantissa} \cdot 10^{{{exponent}}}"));
            }
            _ => self.out.push_str(text),
        }
    }

    fn numeric_power(&mut self, base: Expr, weight: DoubleDouble, needed: Binding) {
        if weight == DoubleDouble::from(1.0) {
            return self.formula(base, needed);
        }
        if is_root(weight) {
            return match self.notation {
                Notation::Text => {
                    self.out.push_str("sqrt");
                    self.parenthesised(|writer| writer.formula(base, Binding::Sum));
                }
                Notation::Tex => {
                    self.out.push_str(r"\sqrt{");
                    self.formula(base, Binding::Sum);
                    self.out.push('}');
                }
            };
        }
        self.power(base, |writer| {
            match (number_text(weight), writer.notation) {
                (NumberText::Decimal(text), _) => writer.number(&text),
                (NumberText::Ratio(above, below), Notation::Text) => {
                    writer.out.push_str(&format!("({above}/{below})"));
                }
                (NumberText::Ratio(above, below), Notation::Tex) => {
                    writer.out.push_str(&format!("{above}/{below}"));
                }
            }
        });
    }

    fn power(&mut self, base: Expr, exponent: impl FnOnce(&mut Self)) {
        self.formula(base, Binding::Atom);
        match self.notation {
            Notation::Text => {
                self.out.push('^');
                exponent(self);
            }
            Notation::Tex => {
                self.out.push_str("^{");
                exponent(self);
                self.out.push('}');
            }
        }
    }

    fn exponent(&mut self, exponent: Expr) {
        let needed = match self.notation {
            Notation::Text => Binding::Atom,
            Notation::Tex => Binding::Sum,
        };
        self.formula(exponent, needed);
    }

    fn symbol(&mut self, symbol: Symbol) {
        let (names, index, kind) = match symbol {
            Symbol::State(index) => (self.names.states, index, "state"),
            Symbol::Parameter(index) => (self.names.parameters, index, "parameter"),
        };
        let name = match names.get(index) {
            Some(name) => name.clone(),
            None => format!("{kind}_{index}"),
        };
        self.out.push_str(&match self.notation {
            Notation::Text => name,
            Notation::Tex => tex_name(&name),
        });
    }
}

fn function_name(function: Function, notation: Notation) -> &'static str {
    let (text, tex) = match function {
        Function::Exp => ("exp", r"\exp"),
        Function::Ln => ("log", r"\ln"),
        Function::Sin => ("sin", r"\sin"),
        Function::Cos => ("cos", r"\cos"),
        Function::Tan => ("tan", r"\tan"),
        Function::Asin => ("asin", r"\arcsin"),
        Function::Acos => ("acos", r"\arccos"),
        Function::Atan => ("atan", r"\arctan"),
        Function::Sinh => ("sinh", r"\sinh"),
        Function::Cosh => ("cosh", r"\cosh"),
        Function::Tanh => ("tanh", r"\tanh"),
    };
    match notation {
        Notation::Text => text,
        Notation::Tex => tex,
    }
}
