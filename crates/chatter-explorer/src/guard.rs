//! Who may ask: the page that this server has served, and nobody else.
//!
//! Any page in the same browser can send requests to this machine. It cannot know the token; and should it, the browser tells
//! where a request comes from.

use crate::http::{Method, Request};
use crate::token::Token;
use core::fmt;

/// What a request is compared with.
#[derive(Clone, Debug)]
pub struct Guard {
    token: Token,
    port: u16,
}

/// Why a request is not answered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rejection {
    /// It is meant for another name, which someone has let lead here.
    Host,
    /// It does not know the token.
    Token,
    /// It comes from another page.
    Origin,
    /// Its body is not said to be JSON, which only pages of this origin may send unasked.
    ContentType,
}

impl Rejection {
    /// The status of the answer.
    pub fn status(self) -> u16 {
        match self {
            Self::Host => 421,
            // As any other address at which there is nothing.
            Self::Token => 404,
            Self::Origin => 403,
            Self::ContentType => 415,
        }
    }
}

impl fmt::Display for Rejection {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(match self {
            Self::Host => "this is not the machine that the request is meant for",
            Self::Token => {
                "there is nothing here; the address that `chatter explore` printed is longer"
            }
            Self::Origin => "the request comes from another page",
            Self::ContentType => "expected a body of type application/json",
        })
    }
}

impl core::error::Error for Rejection {}

impl Guard {
    /// For the server that listens at this port.
    pub fn new(token: Token, port: u16) -> Self {
        Self { token, port }
    }

    /// The address of the page.
    pub fn address(&self) -> String {
        format!("http://127.0.0.1:{}/{}/", self.port, self.token)
    }

    /// What is asked for: the path behind the token.
    ///
    /// # Errors
    /// The request is not the page's.
    pub fn check<'a>(&self, request: &'a Request) -> Result<&'a str, Rejection> {
        let names = ["127.0.0.1", "localhost"].map(|name| format!("{name}:{}", self.port));
        let host = request.header("host").unwrap_or_default();
        if !names.iter().any(|name| name == host) {
            return Err(Rejection::Host);
        }
        if let Some(origin) = request.header("origin")
            && origin != format!("http://{host}")
        {
            return Err(Rejection::Origin);
        }
        // `none`: the user has typed the address.
        let from = request.header("sec-fetch-site").unwrap_or("same-origin");
        if !matches!(
            (request.method, from),
            (_, "same-origin") | (Method::Get, "none")
        ) {
            return Err(Rejection::Origin);
        }
        let path = request.path.strip_prefix('/').unwrap_or_default();
        let path = path.split_once('?').map_or(path, |(path, _)| path);
        let (token, asked) = path.split_once('/').ok_or(Rejection::Token)?;
        if !self.token.is(token) {
            return Err(Rejection::Token);
        }
        let kind = request.header("content-type").unwrap_or_default();
        if request.method == Method::Post && kind != "application/json" {
            return Err(Rejection::ContentType);
        }
        Ok(asked)
    }
}
