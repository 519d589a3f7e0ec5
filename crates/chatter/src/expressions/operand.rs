//! Reads the operands of an expression: numbers, names, calls, parentheses.

use super::graph::Expr;
use super::lexer::Token;
use super::parse_error::{ParseError, ParseErrorKind};
use super::parser::Parser;
use super::suggest::{self, Callable};

impl Parser<'_> {
    pub(super) fn operand(&mut self) -> Result<Expr, ParseError> {
        match self.token() {
            Token::Number(value) => {
                self.advance();
                Ok(self.graph.number_exact(value))
            }
            Token::Name => self.name(),
            Token::Open => {
                self.open();
                let inside = self.sum()?;
                self.close()?;
                Ok(inside)
            }
            Token::Close if self.unclosed.is_empty() => {
                Err(self.error(ParseErrorKind::UnopenedParenthesis, None))
            }
            Token::End if self.unclosed.last().is_some_and(|&at| at + 1 == self.at) => {
                Err(self.never_closed())
            }
            _ => {
                let found = (self.token() != Token::End).then(|| self.written(self.at));
                let after = self.at.checked_sub(1).map(|before| self.written(before));
                Err(self.error(ParseErrorKind::MissingOperand { after, found }, None))
            }
        }
    }

    fn name(&mut self) -> Result<Expr, ParseError> {
        let name_at = self.at;
        let name = &self.text[self.span()];
        self.advance();
        let is_called = self.token() == Token::Open;
        if let Some(callable) = suggest::callable(name) {
            return if is_called {
                self.call(name_at, callable)
            } else {
                Err(self.bare_function(name_at))
            };
        }
        let quantity = if name == suggest::PI {
            Some(self.graph.pi())
        } else {
            (self.resolve)(name)
        };
        let (kind, suggestion) = match quantity {
            Some(expr) if !is_called => return Ok(expr),
            Some(_) => (
                ParseErrorKind::NotAFunction(name.to_string()),
                Some(format!("{name}*(")),
            ),
            None if is_called => (
                ParseErrorKind::UnknownFunction(name.to_string()),
                suggest::for_function(name),
            ),
            None => (
                ParseErrorKind::UnknownName(name.to_string()),
                suggest::for_name(name, self.known),
            ),
        };
        Err(ParseError {
            span: self.lexemes[name_at].span.clone(),
            kind,
            suggestion,
        })
    }

    fn call(&mut self, name_at: usize, callable: Callable) -> Result<Expr, ParseError> {
        self.open();
        let mut arguments = Vec::new();
        if self.token() != Token::Close {
            arguments.push(self.sum()?);
            while self.take(Token::Comma) {
                arguments.push(self.sum()?);
            }
        }
        self.close()?;
        let &[argument] = &arguments[..] else {
            return Err(ParseError {
                span: self.lexemes[name_at].span.start..self.lexemes[self.at - 1].span.end,
                kind: ParseErrorKind::ArgumentCount {
                    function: self.written(name_at),
                    found: arguments.len(),
                },
                suggestion: None,
            });
        };
        Ok(match callable {
            Callable::SquareRoot => self.graph.sqrt(argument),
            Callable::Function(function) => self.graph.call(function, argument),
        })
    }

    fn bare_function(&self, name_at: usize) -> ParseError {
        let name = self.written(name_at);
        let argument = match self.token() {
            Token::Number(_) | Token::Name => self.written(self.at),
            _ => "…".to_string(),
        };
        ParseError {
            span: self.lexemes[name_at].span.clone(),
            suggestion: Some(format!("{name}({argument})")),
            kind: ParseErrorKind::BareFunction(name),
        }
    }

    fn open(&mut self) {
        self.unclosed.push(self.at);
        self.advance();
    }

    fn close(&mut self) -> Result<(), ParseError> {
        if self.take(Token::Close) {
            self.unclosed.pop();
            return Ok(());
        }
        Err(match self.token() {
            Token::End => self.never_closed(),
            _ => self.not_continued(),
        })
    }

    fn never_closed(&self) -> ParseError {
        let opening = self.unclosed.last().copied().unwrap_or(self.at);
        ParseError {
            span: self.lexemes[opening].span.clone(),
            kind: ParseErrorKind::UnclosedParenthesis,
            suggestion: None,
        }
    }

    /// Why a complete operand cannot be followed by the current token.
    pub(super) fn not_continued(&self) -> ParseError {
        match self.token() {
            Token::Close => self.error(ParseErrorKind::UnopenedParenthesis, None),
            Token::Comma => self.error(ParseErrorKind::StrayComma, self.decimal_comma()),
            _ => {
                let (before, after) = (self.written(self.at - 1), self.written(self.at));
                ParseError {
                    span: self.lexemes[self.at - 1].span.start..self.span().end,
                    suggestion: Some(format!("{before}*{after}")),
                    kind: ParseErrorKind::MissingOperator { before, after },
                }
            }
        }
    }

    /// A point, if the current comma stands between two numbers.
    fn decimal_comma(&self) -> Option<String> {
        let before = self.at.checked_sub(1).map(|at| self.lexemes[at].token);
        let after = self.lexemes.get(self.at + 1).map(|lexeme| lexeme.token);
        let between = matches!(
            (before, after),
            (Some(Token::Number(_)), Some(Token::Number(_)))
        );
        between.then(|| ".".to_string())
    }
}
