//! Lines on the standard output and on the error stream, each written by a thread of its own.
//!
//! In: lines of the runner of a job. Out: the same on the streams. Owns two threads and the lines
//! that were not read yet. The runner also serves the controller, and a reader that pauses (a
//! pager, a stopped terminal) must not delay it: light would stay on meanwhile. Lines of the two
//! streams keep their order as long as both are read. Fails: when a reader has gone, the remaining
//! lines are dropped.
use indicatif::{ProgressDrawTarget, TermLike};
use std::io::{self, IsTerminal, Write};
use std::sync::mpsc::{Sender, channel};
use std::sync::{Condvar, LazyLock, Mutex, OnceLock, PoisonError};
use std::time::Duration;

/// So long a line waits for those of the other stream that were said before it.
const OTHER_STREAM_TIMEOUT: Duration = Duration::from_millis(50);
/// A terminal whose width is not known.
const WIDTH_COLUMNS: u16 = 80;

/// A stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stream {
    /// The standard output.
    Out = 0,
    /// The error stream.
    Error = 1,
}

/// Text, and how much had been said on the other stream before it.
struct Piece {
    text: String,
    other: u64,
}

#[derive(Default)]
struct Count {
    said: [u64; 2],
    written: [u64; 2],
    /// Its reader does not read.
    stuck: [bool; 2],
}

static COUNT: LazyLock<Mutex<Count>> = LazyLock::new(Mutex::default);
/// Why the standard output could not be written; not that its reader has gone.
static FAILED: OnceLock<io::Error> = OnceLock::new();
static WRITTEN: Condvar = Condvar::new();
static WRITERS: LazyLock<Mutex<[Sender<Piece>; 2]>> =
    LazyLock::new(|| Mutex::new([Stream::Out, Stream::Error].map(writer)));

fn count() -> std::sync::MutexGuard<'static, Count> {
    COUNT.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The thread of a stream.
fn writer(stream: Stream) -> Sender<Piece> {
    let (said, pieces) = channel::<Piece>();
    let (own, other) = (stream as usize, 1 - stream as usize);
    std::thread::spawn(move || {
        for piece in pieces {
            let behind = |count: &mut Count| count.written[other] < piece.other && !count.stuck[other];
            let (mut now, late) = WRITTEN
                .wait_timeout_while(count(), OTHER_STREAM_TIMEOUT, behind)
                .unwrap_or_else(PoisonError::into_inner);
            now.stuck[other] |= late.timed_out();
            drop(now);
            // When the reader has gone, or writing fails, the job continues.
            let done = match stream {
                Stream::Out => write(&mut io::stdout(), &piece.text),
                Stream::Error => write(&mut io::stderr(), &piece.text).or(Ok(())),
            };
            if let Err(error) = done
                && error.kind() != io::ErrorKind::BrokenPipe
            {
                let _ = FAILED.set(error);
            }
            let mut now = count();
            now.written[own] += 1;
            now.stuck[own] = false;
            WRITTEN.notify_all();
        }
    });
    said
}

fn write(to: &mut impl Write, text: &str) -> io::Result<()> {
    to.write_all(text.as_bytes())?;
    to.flush()
}

/// Queues a line, without waiting. With `--json` only the object goes to the standard output.
pub fn say(stream: Stream, text: String) {
    if stream == Stream::Error || !crate::json::is_on() {
        queue(stream, text);
    }
}

fn queue(stream: Stream, text: String) {
    let writers = WRITERS.lock().unwrap_or_else(PoisonError::into_inner);
    let mut now = count();
    now.said[stream as usize] += 1;
    let other = now.said[1 - stream as usize];
    drop(now);
    // The thread ends with the process.
    let _ = writers[stream as usize].send(Piece { text, other });
}

/// Waits until everything is written, or for so long.
pub fn finish(patience: Option<Duration>) {
    let open = |count: &mut Count| count.written != count.said;
    match patience {
        None => drop(WRITTEN.wait_while(count(), open)),
        Some(time) => drop(WRITTEN.wait_timeout_while(count(), time, open)),
    }
}

/// Why lines of the standard output are missing, if any are and the error stream has a reader.
pub fn failed() -> Option<&'static io::Error> {
    FAILED.get()
}

/// Where a progress bar is drawn: on the error stream, if that is a terminal.
pub fn bars() -> ProgressDrawTarget {
    if io::stderr().is_terminal() {
        ProgressDrawTarget::term_like(Box::new(Terminal))
    } else {
        ProgressDrawTarget::hidden()
    }
}

/// The error stream's terminal.
#[derive(Debug)]
struct Terminal;

impl Terminal {
    fn say(&self, text: String) -> io::Result<()> {
        say(Stream::Error, text);
        Ok(())
    }

    fn go(&self, count: usize, direction: char) -> io::Result<()> {
        if count == 0 { Ok(()) } else { self.say(format!("\x1b[{count}{direction}")) }
    }
}

impl TermLike for Terminal {
    fn width(&self) -> u16 {
        console::Term::stderr().size_checked().map_or(WIDTH_COLUMNS, |(_, columns)| columns)
    }

    fn move_cursor_up(&self, n: usize) -> io::Result<()> {
        self.go(n, 'A')
    }

    fn move_cursor_down(&self, n: usize) -> io::Result<()> {
        self.go(n, 'B')
    }

    fn move_cursor_right(&self, n: usize) -> io::Result<()> {
        self.go(n, 'C')
    }

    fn move_cursor_left(&self, n: usize) -> io::Result<()> {
        self.go(n, 'D')
    }

    fn write_line(&self, s: &str) -> io::Result<()> {
        self.say(format!("{s}\n"))
    }

    fn write_str(&self, s: &str) -> io::Result<()> {
        self.say(s.to_owned())
    }

    fn clear_line(&self) -> io::Result<()> {
        self.say("\r\x1b[2K".to_owned())
    }

    fn flush(&self) -> io::Result<()> {
        Ok(())
    }
}
