//! The server: a thread a connection, one request each, hung up on when it takes too long.

use crate::answers::{self, Context};
use crate::assets;
use crate::guard::Guard;
use crate::http::{Method, Wrong, read_request};
use crate::record::{Kind, Sink};
use crate::token::Token;
use core::ops::ControlFlow;
use core::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use core::time::Duration;
use serde_json::{Value, json};
use std::io::{self, ErrorKind, Read, Write};
use std::net::{Ipv4Addr, Shutdown, TcpListener, TcpStream};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

/// What requests may take.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Connections at one time.
    pub connections: usize,
    /// Questions that are being answered at one time.
    pub questions: usize,
    /// Until a request has been sent.
    pub request: Duration,
    /// Until a question is answered.
    pub answer: Duration,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            connections: 64,
            questions: 16,
            request: Duration::from_secs(10),
            answer: Duration::from_secs(1800),
        }
    }
}

/// So long a write may wait for whoever reads.
const LONGEST_WRITE: Duration = Duration::from_secs(20);
/// How long what is written may stay in memory, and a hang-up unseen.
const TICK: Duration = Duration::from_millis(20);
/// Records that are sent at once.
const BLOCK: usize = 64 << 10;
/// Of the threads that answer: models nest deeply.
const STACK: usize = 64 << 20;

/// The explorer, listening.
pub struct Explorer {
    listener: TcpListener,
    shared: Arc<Shared>,
}

struct Shared {
    guard: Guard,
    context: Context,
    limits: Limits,
    connections: AtomicUsize,
    questions: AtomicUsize,
    closed: AtomicBool,
}

impl Explorer {
    /// Listens on the loopback interface: at this port, at a free one if it is zero.
    ///
    /// # Errors
    /// The port is taken, or there are no random numbers.
    pub fn bind(port: u16, context: Context, limits: Limits) -> io::Result<Self> {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port))?;
        let guard = Guard::new(Token::drawn()?, listener.local_addr()?.port());
        let shared = Shared {
            guard,
            context,
            limits,
            connections: AtomicUsize::new(0),
            questions: AtomicUsize::new(0),
            closed: AtomicBool::new(false),
        };
        Ok(Self {
            listener,
            shared: Arc::new(shared),
        })
    }

    /// Where the page is.
    pub fn address(&self) -> String {
        self.shared.guard.address()
    }

    /// Something that ends [`serve`](Self::serve).
    pub fn closer(&self) -> impl Fn() + Send + Sync + use<> {
        let shared = Arc::clone(&self.shared);
        let address = self.listener.local_addr();
        move || {
            shared.closed.store(true, Ordering::Relaxed);
            // It waits for a connection.
            drop(address.as_ref().map(TcpStream::connect));
        }
    }

    /// Answers until it is closed.
    pub fn serve(&self) {
        for stream in self.listener.incoming() {
            if self.shared.closed.load(Ordering::Relaxed) {
                return;
            }
            // What could not be accepted has gone; out of descriptors, others must go first.
            let Ok(stream) = stream else {
                std::thread::sleep(TICK);
                continue;
            };
            let Some(place) = Place::take(&self.shared, Shared::connections) else {
                refuse(&stream, 503, "too many connections at one time");
                continue;
            };
            let shared = Arc::clone(&self.shared);
            let begun = std::thread::Builder::new()
                .stack_size(STACK)
                .spawn(move || {
                    let _place = place;
                    shared.connection(&stream);
                });
            drop(begun);
        }
    }
}

/// One of a limited number.
struct Place {
    shared: Arc<Shared>,
    counter: fn(&Shared) -> (&AtomicUsize, usize),
}

impl Place {
    fn take(shared: &Arc<Shared>, counter: fn(&Shared) -> (&AtomicUsize, usize)) -> Option<Self> {
        let (taken, most) = counter(shared);
        let more = |count: usize| (count < most).then_some(count + 1);
        let found = taken.fetch_update(Ordering::Relaxed, Ordering::Relaxed, more);
        found.ok().map(|_| Self {
            shared: Arc::clone(shared),
            counter,
        })
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        (self.counter)(&self.shared)
            .0
            .fetch_sub(1, Ordering::Relaxed);
    }
}

impl Shared {
    fn connections(&self) -> (&AtomicUsize, usize) {
        (&self.connections, self.limits.connections)
    }

    fn questions(&self) -> (&AtomicUsize, usize) {
        (&self.questions, self.limits.questions)
    }

    fn connection(self: &Arc<Self>, stream: &TcpStream) {
        drop(stream.set_write_timeout(Some(LONGEST_WRITE)));
        drop(stream.set_nodelay(true));
        let mut timed = Timed {
            stream,
            until: Instant::now() + self.limits.request,
        };
        let request = match read_request(&mut timed) {
            Ok(request) => request,
            Err(wrong) => {
                if let Some(status) = wrong.status() {
                    refuse(stream, status, &wrong.to_string());
                    self.drain(stream, wrong);
                }
                return;
            }
        };
        let asked = match self.guard.check(&request) {
            Ok(asked) => asked,
            Err(rejection) => return refuse(stream, rejection.status(), &rejection.to_string()),
        };
        match request.method {
            Method::Get if asked == "work" => {
                let count = self.questions.load(Ordering::Relaxed);
                send(
                    stream,
                    200,
                    "application/json",
                    json!({ "questions": count }).to_string().as_bytes(),
                );
            }
            Method::Get => match assets::find(asked) {
                Some(asset) => send(stream, 200, asset.kind, asset.text.as_bytes()),
                None => refuse(stream, 404, "there is nothing here"),
            },
            Method::Post if !answers::is_known(asked) => {
                refuse(stream, 404, "there is no such question");
            }
            Method::Post => match Place::take(self, Self::questions) {
                Some(_place) => self.question(stream, asked, &request.body),
                None => refuse(stream, 503, "too many questions at one time"),
            },
        }
    }

    /// Whoever still writes is heard for a moment: else the refusal is lost with the connection.
    fn drain(&self, stream: &TcpStream, wrong: Wrong) {
        if matches!(wrong, Wrong::LargeBody | Wrong::LargeHead) {
            drop(stream.shutdown(Shutdown::Write));
            let mut timed = Timed {
                stream,
                until: Instant::now() + self.limits.request.min(Duration::from_secs(1)),
            };
            drop(io::copy(&mut timed, &mut io::sink()));
        }
    }

    fn question(&self, stream: &TcpStream, asked: &str, body: &[u8]) {
        let Ok(theirs) = stream.try_clone() else {
            return;
        };
        let line = Arc::new(Line {
            stream: Mutex::new(Buffered {
                stream: theirs,
                bytes: head(200, "application/octet-stream", None).into_bytes(),
            }),
            stop: AtomicBool::new(false),
            done: AtomicBool::new(false),
        });
        let Ok(listening) = stream.try_clone() else {
            return;
        };
        let watched = Arc::clone(&line);
        let until = Instant::now() + self.limits.answer;
        let watcher = std::thread::Builder::new().spawn(move || watched.watch(&listening, until));
        if watcher.is_err() {
            return refuse(stream, 503, "the machine has no room for another thread");
        }
        answers::answer(asked, body, &self.context, &mut &*line, &line.stop);
        line.done.store(true, Ordering::Relaxed);
        line.flush();
        drop(stream.shutdown(Shutdown::Write));
    }
}

/// A stream that is read up to a time.
struct Timed<'a> {
    stream: &'a TcpStream,
    until: Instant,
}

impl Read for Timed<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let left = self.until.saturating_duration_since(Instant::now());
        if left.is_zero() {
            return Err(ErrorKind::TimedOut.into());
        }
        self.stream.set_read_timeout(Some(left))?;
        self.stream.read(buffer)
    }
}

/// A connection on which an answer goes out.
struct Line {
    stream: Mutex<Buffered>,
    stop: AtomicBool,
    done: AtomicBool,
}

struct Buffered {
    stream: TcpStream,
    bytes: Vec<u8>,
}

impl Line {
    /// Sends what has waited for a moment, and notices when nobody listens any more, or the time is up. Who closes its
    /// half of the connection has hung up, too: browsers do both at once.
    fn watch(&self, mut stream: &TcpStream, until: Instant) {
        drop(stream.set_read_timeout(Some(TICK)));
        let mut surplus = [0; 64];
        while !self.done.load(Ordering::Relaxed) {
            match stream.read(&mut surplus) {
                Ok(0) => return self.hang_up(),
                // More than one request a connection: not here.
                Ok(_) => std::thread::sleep(TICK),
                Err(error) => match error.kind() {
                    ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted => {}
                    _ => return self.hang_up(),
                },
            }
            if Instant::now() > until {
                return self.hang_up();
            }
            self.flush();
        }
    }

    fn hang_up(&self) {
        self.stop.store(true, Ordering::Relaxed);
    }

    fn flush(&self) {
        let mut buffered = self.stream.lock().unwrap_or_else(PoisonError::into_inner);
        if buffered.send().is_err() {
            self.hang_up();
        }
    }
}

impl Buffered {
    fn send(&mut self) -> io::Result<()> {
        let bytes = core::mem::take(&mut self.bytes);
        self.stream.write_all(&bytes)
    }
}

impl Sink for &Line {
    fn put(&mut self, kind: Kind, content: &[u8]) -> ControlFlow<()> {
        let mut buffered = self.stream.lock().unwrap_or_else(PoisonError::into_inner);
        buffered.bytes.extend_from_slice(&kind.head(content.len()));
        buffered.bytes.extend_from_slice(content);
        if buffered.bytes.len() > BLOCK && buffered.send().is_err() {
            self.hang_up();
        }
        drop(buffered);
        match self.stop.load(Ordering::Relaxed) {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        }
    }
}

/// What the page may do: what it is made of comes from here, and it speaks with nobody else.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; \
     img-src 'self' data: blob:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

fn head(status: u16, kind: &str, length: Option<usize>) -> String {
    let reason = match status {
        200 => "OK",
        400 => "Bad Request",
        403 => "Forbidden",
        404 => "Not Found",
        405 => "Method Not Allowed",
        408 => "Request Timeout",
        411 => "Length Required",
        413 => "Content Too Large",
        415 => "Unsupported Media Type",
        421 => "Misdirected Request",
        431 => "Request Header Fields Too Large",
        _ => "Service Unavailable",
    };
    let length = length.map_or_else(String::new, |length| {
        format!("Content-Length: {length}\r\n")
    });
    format!(
        "HTTP/1.1 {status} {reason}\r\nContent-Type: {kind}\r\n{length}Connection: close\r\nCache-Control: no-store\r\n\
         Content-Security-Policy: {POLICY}\r\nX-Content-Type-Options: nosniff\r\nX-Frame-Options: DENY\r\n\
         Referrer-Policy: no-referrer\r\nCross-Origin-Resource-Policy: same-origin\r\n\
         Cross-Origin-Opener-Policy: same-origin\r\n\r\n"
    )
}

fn send(mut stream: &TcpStream, status: u16, kind: &str, content: &[u8]) {
    let head = head(status, kind, Some(content.len()));
    // Whoever has gone does not miss it.
    drop(stream.write_all(&[head.as_bytes(), content].concat()));
    drop(stream.shutdown(Shutdown::Write));
}

fn refuse(stream: &TcpStream, status: u16, message: &str) {
    drop(stream.set_write_timeout(Some(LONGEST_WRITE)));
    let error: Value = json!({ "kind": "request", "message": message });
    send(
        stream,
        status,
        "application/json",
        error.to_string().as_bytes(),
    );
}
