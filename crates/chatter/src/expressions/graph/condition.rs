//! Reads conditions: the first argument of `if`.
//!
//! Loosest first: `or`; `and`; `not`; comparisons `<`, `<=`, `>`, `>=` of two expressions, or of several in a chain, as in
//! `0 < x < 1`.

use super::piecewise::{Condition, Edge};
use crate::expressions::text::lexer::Token;
use crate::expressions::text::parse_error::{ParseError, ParseErrorKind};
use crate::expressions::text::parser::Parser;

/// Words between and before conditions, which are no names.
pub(in crate::expressions) const WORDS: [&str; 3] = ["and", "or", "not"];

impl Parser<'_> {
    pub(in crate::expressions) fn condition(&mut self) -> Result<Condition, ParseError> {
        let mut whole = self.both()?;
        while self.take_word("or") {
            whole = Condition::Or(Box::new(whole), Box::new(self.both()?));
        }
        Ok(whole)
    }

    fn both(&mut self) -> Result<Condition, ParseError> {
        let mut whole = self.negated()?;
        while self.take_word("and") {
            whole = Condition::And(Box::new(whole), Box::new(self.negated()?));
        }
        Ok(whole)
    }

    fn negated(&mut self) -> Result<Condition, ParseError> {
        self.nested(|parser| {
            if parser.take_word("not") {
                return Ok(Condition::Not(Box::new(parser.negated()?)));
            }
            if parser.token() == Token::Open && parser.encloses_condition() {
                parser.open();
                let inside = parser.condition()?;
                parser.close()?;
                return Ok(inside);
            }
            parser.comparisons()
        })
    }

    fn comparisons(&mut self) -> Result<Condition, ParseError> {
        let first_at = self.at;
        let mut left = self.sum()?;
        let mut whole: Option<Condition> = None;
        while let Some((edge, is_above)) = comparison(self.token()) {
            self.advance();
            let right = self.sum()?;
            let (large, small) = if is_above {
                (left, right)
            } else {
                (right, left)
            };
            let difference = self.graph.sub(large, small);
            let this = Condition::Positive(difference, edge);
            whole = Some(match whole {
                Some(before) => Condition::And(Box::new(before), Box::new(this)),
                None => this,
            });
            left = right;
        }
        whole.ok_or_else(|| match self.token() {
            Token::Comma | Token::Close => ParseError {
                span: self.lexemes[first_at].span.start..self.lexemes[self.at - 1].span.end,
                kind: ParseErrorKind::NotACondition,
                suggestion: None,
            },
            _ => self.not_continued(),
        })
    }

    fn take_word(&mut self, word: &str) -> bool {
        let is_here = self.token() == Token::Name && &self.text[self.span()] == word;
        if is_here {
            self.advance();
        }
        is_here
    }

    /// Whether the parenthesis that opens here holds a condition, and no operand of a comparison.
    fn encloses_condition(&self) -> bool {
        // Of each open parenthesis whether it holds the arguments of a function: comparisons in there are its own.
        let mut open: Vec<bool> = Vec::new();
        for (place, lexeme) in self.lexemes.iter().enumerate().skip(self.at) {
            let is_plain = !open.contains(&true);
            match lexeme.token {
                Token::Open => open.push(!open.is_empty() && self.is_name_of_function(place - 1)),
                Token::Close => {
                    open.pop();
                    if open.is_empty() {
                        return false;
                    }
                }
                Token::Name if is_plain && WORDS.contains(&&self.text[lexeme.span.clone()]) => {
                    return true;
                }
                token if is_plain && comparison(token).is_some() => return true,
                _ => {}
            }
        }
        false
    }

    fn is_name_of_function(&self, place: usize) -> bool {
        let lexeme = &self.lexemes[place];
        lexeme.token == Token::Name && !WORDS.contains(&&self.text[lexeme.span.clone()])
    }
}

/// What holds at equality, and whether the left side is the larger one.
fn comparison(token: Token) -> Option<(Edge, bool)> {
    match token {
        Token::Greater => Some((Edge::Below, true)),
        Token::AtLeast => Some((Edge::Above, true)),
        Token::Less => Some((Edge::Below, false)),
        Token::AtMost => Some((Edge::Above, false)),
        _ => None,
    }
}
