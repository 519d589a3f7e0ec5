//! Reads the text of an expression.
//!
//! Precedence, loosest first: `+` `-`; `*` `/`; signs; `^`, also written `**`, which groups to the right and binds
//! tighter than a sign on its left, looser than one on its right: `-x^2` is `-(x^2)`, `2^-3^2` is `2^(-(3^2))`.
//! Multiplication is always written out.

use super::graph::{Expr, Graph};
use super::lexer::{Lexeme, Token, tokens};
use super::parse_error::{ParseError, ParseErrorKind};
use super::suggest::{self, Callable};
use core::ops::Range;

/// Longest text of an expression, in bytes: ample for any formula a person or a program writes, and small enough that
/// a mistaken file is refused at once.
pub const LONGEST_TEXT: usize = 1 << 16;

/// Deepest nesting of parentheses, signs and powers: the stack of a small thread holds it many times over.
pub const DEEPEST_NESTING: usize = 200;

impl Graph {
    /// Reads `text` into this graph.
    ///
    /// `resolve` gives the expression a name stands for; `known` lists the names it knows, for suggestions. The names
    /// of the functions and `pi` are never asked for ([`is_reserved`](super::is_reserved)).
    ///
    /// # Errors
    /// The first thing that is wrong, with the bytes it is wrong at.
    pub fn parse(
        &mut self,
        text: &str,
        resolve: &dyn Fn(&str) -> Option<Expr>,
        known: &[&str],
    ) -> Result<Expr, ParseError> {
        let lexemes = lexemes(text)?;
        let mut parser = Parser {
            graph: self,
            text,
            lexemes: &lexemes,
            at: 0,
            depth: 0,
            unclosed: Vec::new(),
            resolve,
            known,
        };
        let expr = parser.sum()?;
        match parser.token() {
            Token::End => Ok(expr),
            _ => Err(parser.not_continued()),
        }
    }
}

/// The names of quantities that `text` refers to, with the bytes they stand at, in order; functions and `pi` left out.
///
/// # Errors
/// What keeps the text from being cut into tokens; its grammar is not looked at.
pub fn names(text: &str) -> Result<Vec<Range<usize>>, ParseError> {
    let lexemes = lexemes(text)?;
    Ok(lexemes
        .into_iter()
        .filter(|lexeme| lexeme.token == Token::Name)
        .map(|lexeme| lexeme.span)
        .filter(|span| !suggest::is_reserved(&text[span.clone()]))
        .collect())
}

fn lexemes(text: &str) -> Result<Vec<Lexeme>, ParseError> {
    let whole = |kind| ParseError {
        span: 0..text.len(),
        kind,
        suggestion: None,
    };
    if text.len() > LONGEST_TEXT {
        return Err(whole(ParseErrorKind::TooLong { bytes: text.len() }));
    }
    if text.trim().is_empty() {
        return Err(whole(ParseErrorKind::Empty));
    }
    tokens(text)
}

struct Parser<'a> {
    graph: &'a mut Graph,
    text: &'a str,
    lexemes: &'a [Lexeme],
    at: usize,
    depth: usize,
    /// Where the parentheses that are open now were opened, outermost first.
    unclosed: Vec<usize>,
    resolve: &'a dyn Fn(&str) -> Option<Expr>,
    known: &'a [&'a str],
}

impl Parser<'_> {
    fn token(&self) -> Token {
        self.lexemes[self.at].token
    }

    fn span(&self) -> Range<usize> {
        self.lexemes[self.at].span.clone()
    }

    /// The end token is never stepped over.
    fn advance(&mut self) {
        if self.token() != Token::End {
            self.at += 1;
        }
    }

    fn take(&mut self, token: Token) -> bool {
        let taken = self.token() == token;
        if taken {
            self.advance();
        }
        taken
    }

    fn written(&self, at: usize) -> String {
        self.text[self.lexemes[at].span.clone()].to_string()
    }

    fn error(&self, kind: ParseErrorKind, suggestion: Option<String>) -> ParseError {
        ParseError {
            span: self.span(),
            kind,
            suggestion,
        }
    }

    fn sum(&mut self) -> Result<Expr, ParseError> {
        let mut terms = vec![self.product()?];
        loop {
            if self.take(Token::Plus) {
                terms.push(self.product()?);
            } else if self.take(Token::Minus) {
                let term = self.product()?;
                terms.push(self.graph.neg(term));
            } else {
                return Ok(self.graph.sum(&terms));
            }
        }
    }

    /// Factors above and below the line, divided once: one division is cheaper than several and loses less.
    fn product(&mut self) -> Result<Expr, ParseError> {
        let mut above = vec![self.signed()?];
        let mut below = Vec::new();
        loop {
            if self.take(Token::Times) {
                above.push(self.signed()?);
            } else if self.take(Token::Divide) {
                below.push(self.signed()?);
            } else {
                break;
            }
        }
        let above = self.graph.product(&above);
        if below.is_empty() {
            return Ok(above);
        }
        let below = self.graph.product(&below);
        Ok(self.graph.div(above, below))
    }

    fn signed(&mut self) -> Result<Expr, ParseError> {
        self.nested(|parser| {
            if parser.take(Token::Minus) {
                let operand = parser.signed()?;
                Ok(parser.graph.neg(operand))
            } else if parser.take(Token::Plus) {
                parser.signed()
            } else {
                parser.power()
            }
        })
    }

    fn power(&mut self) -> Result<Expr, ParseError> {
        let base = self.operand()?;
        if !self.take(Token::Power) {
            return Ok(base);
        }
        let exponent = self.signed()?;
        Ok(self.graph.power(base, exponent))
    }

    fn nested(
        &mut self,
        parse: impl FnOnce(&mut Self) -> Result<Expr, ParseError>,
    ) -> Result<Expr, ParseError> {
        if self.depth == DEEPEST_NESTING {
            return Err(self.error(ParseErrorKind::TooDeep, None));
        }
        self.depth += 1;
        let result = parse(self);
        self.depth -= 1;
        result
    }

    fn operand(&mut self) -> Result<Expr, ParseError> {
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
    fn not_continued(&self) -> ParseError {
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
