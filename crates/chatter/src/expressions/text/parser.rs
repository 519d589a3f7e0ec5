//! Reads the text of an expression.
//!
//! Precedence, loosest first: `+` `-`; `*` `/`; signs; `^`, also written `**`, which groups to the right and binds
//! tighter than a sign on its left, looser than one on its right: `-x^2` is `-(x^2)`, `2^-3^2` is `2^(-(3^2))`.
//! Multiplication is always written out.

use super::lexer::{Lexeme, Token, tokens};
use super::parse_error::{ParseError, ParseErrorKind};
use super::suggest;
use crate::expressions::graph::{Expr, Graph};
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
    /// of the functions and `pi` are never asked for ([`is_reserved`](crate::expressions::is_reserved)).
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

/// Where reading stands.
pub(in crate::expressions) struct Parser<'a> {
    pub(in crate::expressions) graph: &'a mut Graph,
    pub(in crate::expressions) text: &'a str,
    pub(in crate::expressions) lexemes: &'a [Lexeme],
    pub(in crate::expressions) at: usize,
    depth: usize,
    /// Where the parentheses that are open now were opened, outermost first.
    pub(in crate::expressions) unclosed: Vec<usize>,
    pub(in crate::expressions) resolve: &'a dyn Fn(&str) -> Option<Expr>,
    pub(in crate::expressions) known: &'a [&'a str],
}

impl Parser<'_> {
    pub(in crate::expressions) fn token(&self) -> Token {
        self.lexemes[self.at].token
    }

    pub(in crate::expressions) fn span(&self) -> Range<usize> {
        self.lexemes[self.at].span.clone()
    }

    /// The end token is never stepped over.
    pub(in crate::expressions) fn advance(&mut self) {
        if self.token() != Token::End {
            self.at += 1;
        }
    }

    pub(in crate::expressions) fn take(&mut self, token: Token) -> bool {
        let taken = self.token() == token;
        if taken {
            self.advance();
        }
        taken
    }

    pub(in crate::expressions) fn written(&self, at: usize) -> String {
        self.text[self.lexemes[at].span.clone()].to_string()
    }

    pub(in crate::expressions) fn error(
        &self,
        kind: ParseErrorKind,
        suggestion: Option<String>,
    ) -> ParseError {
        ParseError {
            span: self.span(),
            kind,
            suggestion,
        }
    }

    pub(in crate::expressions) fn sum(&mut self) -> Result<Expr, ParseError> {
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

    pub(in crate::expressions) fn nested<T>(
        &mut self,
        parse: impl FnOnce(&mut Self) -> Result<T, ParseError>,
    ) -> Result<T, ParseError> {
        if self.depth == DEEPEST_NESTING {
            return Err(self.error(ParseErrorKind::TooDeep, None));
        }
        self.depth += 1;
        let result = parse(self);
        self.depth -= 1;
        result
    }
}
