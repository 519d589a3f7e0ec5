//! Reads the operands of an expression: numbers, names, calls, parentheses.

use super::Expr;
use super::condition::WORDS;
use super::piecewise::Condition;
use crate::expressions::text::lexer::Token;
use crate::expressions::text::parse_error::{ParseError, ParseErrorKind};
use crate::expressions::text::parser::Parser;
use crate::expressions::text::suggest::{self, Arity, Callable};

impl Parser<'_> {
    pub(in crate::expressions) fn operand(&mut self) -> Result<Expr, ParseError> {
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
        if WORDS.contains(&name) {
            let kind = ParseErrorKind::StrayWord(name.to_string());
            return Err(self.error(kind, None));
        }
        self.advance();
        let is_called = self.token() == Token::Open;
        if let Some(callable) = suggest::callable(name) {
            return if is_called {
                self.call(name_at, callable)
            } else {
                Err(self.bare_function(name_at))
            };
        }
        if let Some(curve) = self.graph.curve_named(name) {
            if !is_called {
                return Err(self.bare_function(name_at));
            }
            let arguments = self.arguments()?;
            let &[argument] = &arguments[..] else {
                return Err(self.argument_count(name_at, Arity::Exactly(1), arguments.len()));
            };
            return Ok(self.graph.curve_at(curve, argument, 0));
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
                Some(match self.lexemes.get(name_at + 2).map(|next| next.token) {
                    Some(Token::Close) => name.to_string(),
                    _ => format!("{name}*("),
                }),
            ),
            None if is_called => (
                ParseErrorKind::UnknownFunction(name.to_string()),
                suggest::for_function(name, self.graph.curve_names()),
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
        if callable == Callable::If {
            return self.choice(name_at);
        }
        let arguments = self.arguments()?;
        let arity = callable.arity();
        if !arity.allows(arguments.len()) {
            return Err(self.argument_count(name_at, arity, arguments.len()));
        }
        let graph = &mut *self.graph;
        Ok(match (callable, &arguments[..]) {
            (Callable::SquareRoot, &[x]) => graph.sqrt(x),
            (Callable::Function(function), &[x]) => graph.call(function, x),
            (Callable::Abs, &[x]) => graph.abs(x),
            (Callable::Sign, &[x]) => graph.sign(x),
            (Callable::Step, &[x]) => graph.step(x),
            (Callable::Floor, &[x]) => graph.floor(x),
            (Callable::Mod, &[x, m]) => graph.modulo(x, m),
            (Callable::Atan2, &[y, x]) => graph.atan2(y, x),
            (Callable::Hypot, &[x, y]) => graph.hypot(x, y),
            (Callable::Clamp, &[x, low, high]) => graph.clamp(x, low, high),
            (Callable::Max, &[first, ref rest @ ..]) => {
                (rest.iter()).fold(first, |most, &next| graph.max(most, next))
            }
            (Callable::Min, &[first, ref rest @ ..]) => {
                (rest.iter()).fold(first, |least, &next| graph.min(least, next))
            }
            _ => return Err(self.argument_count(name_at, arity, arguments.len())),
        })
    }

    fn arguments(&mut self) -> Result<Vec<Expr>, ParseError> {
        self.open();
        let mut arguments = Vec::new();
        if self.token() != Token::Close {
            arguments.push(self.sum()?);
            while self.take(Token::Comma) {
                arguments.push(self.sum()?);
            }
        }
        self.close()?;
        Ok(arguments)
    }

    /// `if(condition, yes, no)`.
    fn choice(&mut self, name_at: usize) -> Result<Expr, ParseError> {
        self.open();
        if self.take(Token::Close) {
            self.unclosed.pop();
            return Err(self.argument_count(name_at, Callable::If.arity(), 0));
        }
        let condition: Condition = self.condition()?;
        let mut pieces = Vec::new();
        while self.take(Token::Comma) {
            pieces.push(self.sum()?);
        }
        self.close()?;
        match pieces[..] {
            [yes, no] => Ok(self.graph.choose(&condition, yes, no)),
            _ => Err(self.argument_count(name_at, Callable::If.arity(), pieces.len() + 1)),
        }
    }

    fn argument_count(&self, name_at: usize, expected: Arity, found: usize) -> ParseError {
        ParseError {
            span: self.lexemes[name_at].span.start..self.lexemes[self.at - 1].span.end,
            kind: ParseErrorKind::ArgumentCount {
                function: self.written(name_at),
                expected: expected.words(),
                found,
            },
            suggestion: None,
        }
    }

    fn bare_function(&self, name_at: usize) -> ParseError {
        let name = self.written(name_at);
        let argument = match self.token() {
            _ if name == "if" => "condition, value, other".to_string(),
            Token::Number(_) | Token::Name => self.written(self.at),
            _ => "…".to_string(),
        };
        ParseError {
            span: self.lexemes[name_at].span.clone(),
            suggestion: Some(format!("{name}({argument})")),
            kind: ParseErrorKind::BareFunction(name),
        }
    }

    pub(in crate::expressions) fn open(&mut self) {
        self.unclosed.push(self.at);
        self.advance();
    }

    pub(in crate::expressions) fn close(&mut self) -> Result<(), ParseError> {
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
    pub(in crate::expressions) fn not_continued(&self) -> ParseError {
        match self.token() {
            Token::Close => self.error(ParseErrorKind::UnopenedParenthesis, None),
            Token::Comma => self.error(ParseErrorKind::StrayComma, self.decimal_comma()),
            Token::Less | Token::AtMost | Token::Greater | Token::AtLeast => {
                self.error(ParseErrorKind::StrayComparison, None)
            }
            Token::Name if WORDS.contains(&&self.text[self.span()]) => {
                let word = self.written(self.at);
                self.error(ParseErrorKind::StrayWord(word), None)
            }
            _ => {
                let (before, after) = (self.written(self.at - 1), self.written(self.at));
                let span = self.lexemes[self.at - 1].span.start..self.span().end;
                let follows_number = matches!(self.lexemes[self.at - 1].token, Token::Number(_));
                if follows_number && self.token() == Token::Name && !self.knows(&after) {
                    let is_joined = self.lexemes[self.at - 1].span.end == self.span().start;
                    let (kind, suggestion) = match after.as_str() {
                        "e" | "E" if is_joined => {
                            (ParseErrorKind::MalformedNumber(before + &after), None)
                        }
                        _ => {
                            let meant = match suggest::as_product(&after, self.known) {
                                Some(product) => format!("{before}*{product}"),
                                None => before,
                            };
                            (ParseErrorKind::NumberWithUnit(after), Some(meant))
                        }
                    };
                    return ParseError {
                        span,
                        suggestion,
                        kind,
                    };
                }
                // As in `a if b else c`, which is no product.
                let suggestion = match after.as_str() {
                    "if" => "if(condition, value, other)".to_owned(),
                    _ => format!("{before}*{after}"),
                };
                ParseError {
                    span,
                    suggestion: Some(suggestion),
                    kind: ParseErrorKind::MissingOperator { before, after },
                }
            }
        }
    }

    /// Whether a name stands for anything.
    fn knows(&self, name: &str) -> bool {
        suggest::is_reserved(name) || (self.resolve)(name).is_some()
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
