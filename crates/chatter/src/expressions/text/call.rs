//! Calls of functions in canonical form.

use crate::expressions::graph::{Expr, Function, Graph, Node};
use crate::numerics::{DoubleDouble, Real};

impl Graph {
    /// A function of an expression.
    ///
    /// Folded where the value is exact: at 0, at 1, and at pi. The minus sign of the argument moves out of an odd
    /// function and disappears in an even one.
    pub fn call(&mut self, function: Function, argument: Expr) -> Expr {
        if let Some(value) = self.exact_value(function, argument) {
            return self.number(value);
        }
        let one = self.number(1.0);
        let (coefficient, rest) = self.split_coefficient(argument, one);
        let negative = coefficient.high() < 0.0;
        match function.parity() {
            Some(parity) if negative => {
                let positive = self.scaled(-coefficient, rest);
                let value = self.call(function, positive);
                match parity {
                    Parity::Odd => self.neg(value),
                    Parity::Even => value,
                }
            }
            _ => self.intern(Node::Call(function, argument)),
        }
    }

    fn exact_value(&self, function: Function, argument: Expr) -> Option<f64> {
        use Function::{Acos, Asin, Atan, Cos, Cosh, Exp, Ln, Sin, Sinh, Tan, Tanh};
        if *self.node(argument) == Node::Pi {
            return match function {
                Sin | Tan => Some(0.0),
                Cos => Some(-1.0),
                _ => None,
            };
        }
        let value = self.as_number(argument)?;
        if value == DoubleDouble::ZERO {
            return match function {
                Sin | Tan | Asin | Atan | Sinh | Tanh => Some(0.0),
                Exp | Cos | Cosh => Some(1.0),
                Ln | Acos => None,
            };
        }
        (value == DoubleDouble::ONE && matches!(function, Ln | Acos)).then_some(0.0)
    }
}

enum Parity {
    Even,
    Odd,
}

impl Function {
    fn parity(self) -> Option<Parity> {
        match self {
            Self::Sin | Self::Tan | Self::Asin | Self::Atan | Self::Sinh | Self::Tanh => {
                Some(Parity::Odd)
            }
            Self::Cos | Self::Cosh => Some(Parity::Even),
            Self::Exp | Self::Ln | Self::Acos => None,
        }
    }
}
