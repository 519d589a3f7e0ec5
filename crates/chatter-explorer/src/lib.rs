//! The explorer: a page on which a model can be understood in minutes, and the server behind it.
//!
//! ```text
//! page ── question (JSON) ──► guard ──► answers ──► records ──► page          one connection a question
//!                                          │
//!                              closing the connection stops the work
//! ```
//!
//! The server keeps nothing between requests: a question holds the text of the model and everything that is asked of it. It
//! listens on the loopback interface alone and answers those who know the token in its address ([`Guard`]). What it answers
//! is a stream of [records](Kind), so that rows of a diagram can be drawn as they are computed. [`answer`] does the same
//! without a server, for other ways between page and program.

mod answers;
mod assets;
mod guard;
mod http;
mod question;
mod record;
mod refused;
mod server;
mod token;

pub use answers::{Context, answer};
pub use assets::{Asset, PAGE};
pub use guard::{Guard, Rejection};
pub use http::{MOST_BODY, MOST_HEAD, Method, Request, Wrong, read_request};
pub use record::{Kind, Sink};
pub use server::{Explorer, Limits};
pub use token::Token;
