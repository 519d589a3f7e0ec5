//! Reads requests: as much of HTTP/1.1 as a browser on the same machine needs, and no more.
//!
//! One request a connection; a body has a length that is told before. Everything has a limit, so that whoever writes garbage,
//! or nothing for a long time, gets an error and costs little.

use core::fmt;
use std::io::{ErrorKind, Read};

/// Most bytes before the body.
pub const MOST_HEAD: usize = 16 << 10;
/// Most bytes of a body: a model of many pages, with its points.
pub const MOST_BODY: usize = 4 << 20;
/// Most lines before the body.
const MOST_LINES: usize = 100;

/// What is wanted of a resource.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// To read it.
    Get,
    /// To have a question answered.
    Post,
}

/// A request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Request {
    /// What is wanted.
    pub method: Method,
    /// Of what: the path, as written.
    pub path: String,
    headers: Vec<(String, String)>,
    /// The question.
    pub body: Vec<u8>,
}

impl Request {
    /// The value of a header, by its name in small letters.
    pub fn header(&self, name: &str) -> Option<&str> {
        let mut found = self.headers.iter().filter(|(known, _)| known == name);
        found.next().map(|(_, value)| value.as_str())
    }
}

/// Why something is no request that can be answered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wrong {
    /// Nothing came, or it broke off.
    Gone,
    /// It took too long.
    Slow,
    /// Not HTTP.
    Garbage,
    /// Neither GET nor POST.
    Method,
    /// Too much before the body.
    LargeHead,
    /// A body whose length is not told.
    NoLength,
    /// Too large a body.
    LargeBody,
}

impl Wrong {
    /// The status of the answer; none where nobody reads it.
    pub fn status(self) -> Option<u16> {
        match self {
            Self::Gone => None,
            Self::Slow => Some(408),
            Self::Garbage => Some(400),
            Self::Method => Some(405),
            Self::LargeHead => Some(431),
            Self::NoLength => Some(411),
            Self::LargeBody => Some(413),
        }
    }
}

impl fmt::Display for Wrong {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Gone => write!(out, "the request broke off"),
            Self::Slow => write!(out, "the request took too long"),
            Self::Garbage => write!(out, "this is no request"),
            Self::Method => write!(out, "expected GET or POST"),
            Self::LargeHead => {
                write!(out, "expected {MOST_HEAD} bytes before the body at most")
            }
            Self::NoLength => write!(out, "expected the length of the body"),
            Self::LargeBody => write!(out, "expected a body of {MOST_BODY} bytes at most"),
        }
    }
}

impl core::error::Error for Wrong {}

/// Reads one request.
///
/// # Errors
/// It is none, or too large, or `input` ends or times out.
pub fn read_request(input: &mut impl Read) -> Result<Request, Wrong> {
    let mut bytes = Vec::new();
    let end = loop {
        if let Some(end) = end_of_head(&bytes) {
            break end;
        }
        if bytes.len() > MOST_HEAD {
            return Err(Wrong::LargeHead);
        }
        more(input, &mut bytes, 4096)?;
    };
    if end > MOST_HEAD {
        return Err(Wrong::LargeHead);
    }
    let body = bytes.split_off(end);
    let head = str::from_utf8(&bytes).map_err(|_| Wrong::Garbage)?;
    let mut request = read_head(head)?;
    let length = length_of_body(&request)?;
    request.body = body;
    while request.body.len() < length {
        let missing = length - request.body.len();
        more(input, &mut request.body, missing.min(64 << 10))?;
    }
    // One request a connection: what follows is not looked at.
    request.body.truncate(length);
    Ok(request)
}

/// Appends what comes next, so many bytes at most.
fn more(input: &mut impl Read, bytes: &mut Vec<u8>, most: usize) -> Result<(), Wrong> {
    let held = bytes.len();
    bytes.resize(held + most, 0);
    loop {
        match input.read(&mut bytes[held..]) {
            Ok(0) => return Err(Wrong::Gone),
            Ok(count) => {
                bytes.truncate(held + count);
                return Ok(());
            }
            Err(error) => match error.kind() {
                ErrorKind::Interrupted => {}
                ErrorKind::WouldBlock | ErrorKind::TimedOut => return Err(Wrong::Slow),
                _ => return Err(Wrong::Gone),
            },
        }
    }
}

/// Where the empty line ends.
fn end_of_head(bytes: &[u8]) -> Option<usize> {
    let empty = bytes.windows(4).position(|four| four == b"\r\n\r\n");
    empty.map(|place| place + 4)
}

fn read_head(head: &str) -> Result<Request, Wrong> {
    let mut lines = head.trim_end_matches("\r\n").split("\r\n");
    let first: Vec<&str> = lines.next().unwrap_or_default().split(' ').collect();
    let &[method, path, "HTTP/1.1" | "HTTP/1.0"] = &first[..] else {
        return Err(Wrong::Garbage);
    };
    let method = match method {
        "GET" => Method::Get,
        "POST" => Method::Post,
        _ if !method.is_empty() && method.bytes().all(|byte| byte.is_ascii_uppercase()) => {
            return Err(Wrong::Method);
        }
        _ => return Err(Wrong::Garbage),
    };
    let visible = |text: &str| text.bytes().all(|byte| (0x21..0x7f).contains(&byte));
    if !path.starts_with('/') || !visible(path) {
        return Err(Wrong::Garbage);
    }
    let mut headers = Vec::new();
    for line in lines {
        let (name, value) = line.split_once(':').ok_or(Wrong::Garbage)?;
        let token = |byte: u8| byte.is_ascii_alphanumeric() || b"-_.!#$%&'*+^`|~".contains(&byte);
        let control = |character: char| character.is_control() && character != '\t';
        if name.is_empty() || !name.bytes().all(token) || value.contains(control) {
            return Err(Wrong::Garbage);
        }
        let name = name.to_ascii_lowercase();
        // Two of one name are read in two ways by two readers.
        if headers.iter().any(|(known, _)| *known == name) || headers.len() == MOST_LINES {
            return Err(Wrong::Garbage);
        }
        headers.push((name, value.trim().to_owned()));
    }
    Ok(Request {
        method,
        path: path.to_owned(),
        headers,
        body: Vec::new(),
    })
}

fn length_of_body(request: &Request) -> Result<usize, Wrong> {
    if request.header("transfer-encoding").is_some() {
        return Err(Wrong::NoLength);
    }
    let Some(text) = request.header("content-length") else {
        return match request.method {
            Method::Get => Ok(0),
            Method::Post => Err(Wrong::NoLength),
        };
    };
    if text.is_empty() || !text.bytes().all(|byte| byte.is_ascii_digit()) {
        return Err(Wrong::Garbage);
    }
    match text.parse::<usize>() {
        Ok(length) if length <= MOST_BODY => Ok(length),
        _ => Err(Wrong::LargeBody),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn read(text: &str) -> Result<Request, Wrong> {
        read_request(&mut text.as_bytes())
    }

    #[test]
    fn requests_are_read() {
        let get = read("GET /a/b HTTP/1.1\r\nHost: here\r\nX-Y:  z \r\n\r\n").unwrap();
        assert_eq!((get.method, &*get.path), (Method::Get, "/a/b"));
        assert_eq!(
            (get.header("host"), get.header("x-y")),
            (Some("here"), Some("z"))
        );
        let post = read("POST / HTTP/1.1\r\nContent-Length: 3\r\n\r\nabcdef").unwrap();
        assert_eq!((post.method, &*post.body), (Method::Post, &b"abc"[..]));
    }

    #[test]
    fn what_is_none_is_told() {
        for (text, wrong) in [
            ("", Wrong::Gone),
            ("GET / HTTP/1.1\r\n", Wrong::Gone),
            (
                "POST / HTTP/1.1\r\nContent-Length: 3\r\n\r\nab",
                Wrong::Gone,
            ),
            ("hello\r\n\r\n", Wrong::Garbage),
            ("GET / HTTP/2\r\n\r\n", Wrong::Garbage),
            ("GET x HTTP/1.1\r\n\r\n", Wrong::Garbage),
            ("GET /\u{e9} HTTP/1.1\r\n\r\n", Wrong::Garbage),
            ("GET / HTTP/1.1\r\nHost\r\n\r\n", Wrong::Garbage),
            (
                "GET / HTTP/1.1\r\nHost: a\r\nhost: b\r\n\r\n",
                Wrong::Garbage,
            ),
            ("GET / HTTP/1.1\r\nHo st: a\r\n\r\n", Wrong::Garbage),
            ("GET / HTTP/1.1\r\nHost: a\nb: c\r\n\r\n", Wrong::Garbage),
            ("DELETE / HTTP/1.1\r\n\r\n", Wrong::Method),
            ("POST / HTTP/1.1\r\n\r\n", Wrong::NoLength),
            (
                "POST / HTTP/1.1\r\nTransfer-Encoding: chunked\r\n\r\n",
                Wrong::NoLength,
            ),
            (
                "POST / HTTP/1.1\r\nContent-Length: -1\r\n\r\n",
                Wrong::Garbage,
            ),
            (
                "POST / HTTP/1.1\r\nContent-Length: 99999999\r\n\r\n",
                Wrong::LargeBody,
            ),
            (
                "POST / HTTP/1.1\r\nContent-Length: 99999999999999999999999\r\n\r\n",
                Wrong::LargeBody,
            ),
        ] {
            assert_eq!(read(text), Err(wrong), "{text:?}");
        }
        let long = format!("GET /{} HTTP/1.1\r\n\r\n", "a".repeat(MOST_HEAD));
        assert_eq!(read(&long), Err(Wrong::LargeHead));
        let endless = "a".repeat(4 * MOST_HEAD);
        assert_eq!(read(&endless), Err(Wrong::LargeHead));
    }

    proptest! {
        #[test]
        fn any_bytes_are_a_request_or_an_error(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
            let _ = read_request(&mut &bytes[..]);
        }

        #[test]
        fn a_request_is_read_the_same_in_pieces(
            path in "/[a-z/]{0,20}",
            value in "[ -~]{0,30}",
            body in prop::collection::vec(any::<u8>(), 0..200),
            piece in 1_usize..50,
        ) {
            let head = format!("POST {path} HTTP/1.1\r\nX: {value}\r\nContent-Length: {}\r\n\r\n", body.len());
            let bytes = [head.as_bytes(), &body].concat();
            let whole = read_request(&mut &bytes[..]).unwrap();
            prop_assert_eq!(&whole.body, &body);
            prop_assert_eq!(whole.header("x"), Some(value.trim()));
            struct Pieces<'a>(&'a [u8], usize);
            impl Read for Pieces<'_> {
                fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
                    let count = self.1.min(self.0.len()).min(buffer.len());
                    buffer[..count].copy_from_slice(&self.0[..count]);
                    self.0 = &self.0[count..];
                    Ok(count)
                }
            }
            prop_assert_eq!(read_request(&mut Pieces(&bytes, piece)).unwrap(), whole);
        }
    }
}
