//! The terminal: the block drawn, and keys.
//!
//! In: a state, keys. Out: a screen. Owns the terminal from [`Screen::open`] until it is dropped,
//! and then it is as it was. A thread draws and another one reads keys: a terminal that takes
//! nothing delays no key. Fails: with the operating system's error, and when the terminal has gone.
use super::block::{self, Tone};
use super::panel::Panel;
use super::state::State;
use crate::Failure;
use ratatui::crossterm::event::{self, Event, KeyCode, KeyEventKind, KeyModifiers};
use ratatui::layout::{Constraint, Layout};
use ratatui::style::{Modifier, Style, Stylize};
use ratatui::text::Line;
use ratatui::widgets::{Block, Gauge, Paragraph};
use ratatui::{DefaultTerminal, Frame};
use std::io::{self, IsTerminal};
use std::mem::ManuallyDrop;
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, channel, sync_channel};
use std::time::Duration;

/// What a key asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Key {
    /// The end.
    Quit,
    /// The path comes to rest on itself, dark.
    Hold,
    /// It goes on.
    GoOn,
    /// Dark at once.
    Stop,
    /// The program begins.
    Start,
    /// Walk round what the program marks.
    Frame,
    /// X0 Y0 are here.
    Zero,
    /// Along an axis: X 0, Y 1, Z 2; up or down.
    Jog(usize, bool),
    /// A longer or a shorter jog.
    Step(bool),
    /// After an alarm.
    Unlock,
    /// Nothing.
    Unknown,
}

/// What a key means.
pub fn meaning(code: KeyCode, modifiers: KeyModifiers) -> Key {
    if modifiers.contains(KeyModifiers::CONTROL) {
        return if code == KeyCode::Char('c') { Key::Quit } else { Key::Unknown };
    }
    match code {
        KeyCode::Char('q') => Key::Quit,
        KeyCode::Char(' ' | '!') => Key::Hold,
        KeyCode::Char('g' | '~') => Key::GoOn,
        KeyCode::Char('x') => Key::Stop,
        KeyCode::Char('s') => Key::Start,
        KeyCode::Char('f') => Key::Frame,
        KeyCode::Char('z') => Key::Zero,
        KeyCode::Char('u') => Key::Unlock,
        KeyCode::Char('+' | '=') => Key::Step(true),
        KeyCode::Char('-') => Key::Step(false),
        KeyCode::Right => Key::Jog(0, true),
        KeyCode::Left => Key::Jog(0, false),
        KeyCode::Up => Key::Jog(1, true),
        KeyCode::Down => Key::Jog(1, false),
        KeyCode::PageUp => Key::Jog(2, true),
        KeyCode::PageDown => Key::Jog(2, false),
        _ => Key::Unknown,
    }
}

/// A terminal that takes nothing is given up after this time.
const WRITE_TIMEOUT: Duration = Duration::from_millis(300);

/// A picture.
type Picture = (State, Option<Says>, String);

/// See the module text.
pub struct Screen {
    /// The next picture; none is the end.
    pictures: Option<SyncSender<Picture>>,
    keys: Receiver<io::Result<Key>>,
    /// The end of the drawing, and of the terminal.
    drawn: Receiver<io::Result<()>>,
}

impl Screen {
    /// Takes the terminal.
    pub fn open() -> Result<Screen, Failure> {
        // Dropping it would write to the error stream, which may be this terminal and have gone.
        let mut terminal = ManuallyDrop::new(ratatui::try_init().map_err(failed)?);
        let (pictures, next) = sync_channel(1);
        let (ended, drawn) = channel();
        std::thread::spawn(move || {
            let done = pictures_on(&mut terminal, &next);
            ended.send(done.and(terminal.show_cursor()).and(ratatui::try_restore()))
        });
        let (pressed, keys) = channel();
        // It ends with the process, or when nobody listens.
        std::thread::spawn(move || while pressed.send(read_key()).is_ok() {});
        Ok(Screen { pictures: Some(pictures), keys, drawn })
    }

    /// Draws everything, unless the picture before is not drawn yet.
    pub fn draw(&mut self, state: &State, panel: Option<&Panel>, note: &str) -> Result<(), Failure> {
        if let Some(pictures) = &self.pictures
            && let Err(TrySendError::Disconnected(_)) =
                pictures.try_send((state.clone(), panel.map(Panel::says), note.to_owned()))
        {
            let why = self.drawn.recv_timeout(WRITE_TIMEOUT).unwrap_or(Ok(()));
            return Err(failed(why.err().unwrap_or_else(|| io::Error::other("it takes nothing any more"))));
        }
        Ok(())
    }

    /// The next key; none after this time without one.
    pub fn key(&mut self, wait: Duration) -> Result<Option<Key>, Failure> {
        match self.keys.recv_timeout(wait) {
            Ok(key) => key.map(Some).map_err(failed),
            // Where it has gone, reading it may wait for ever.
            Err(_) if !(io::stdin().is_terminal() && io::stdout().is_terminal()) => {
                Err(failed(io::Error::other("it has gone")))
            }
            Err(_) => Ok(None),
        }
    }
}

fn pictures_on(terminal: &mut DefaultTerminal, pictures: &Receiver<Picture>) -> io::Result<()> {
    pictures.iter().try_for_each(|(state, panel, note)| {
        terminal.draw(|frame| draw(frame, &state, panel.as_ref(), &note)).map(drop)
    })
}

/// Waits for a key.
fn read_key() -> io::Result<Key> {
    loop {
        if let Event::Key(key) = event::read()?
            && key.kind != KeyEventKind::Release
        {
            return Ok(meaning(key.code, key.modifiers));
        }
    }
}

impl Drop for Screen {
    fn drop(&mut self) {
        self.pictures = None;
        let _ = self.drawn.recv_timeout(WRITE_TIMEOUT);
    }
}

fn failed(error: std::io::Error) -> Failure {
    Failure::Job(format!("the terminal: {error}"))
}

/// What the side that commands says.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Says {
    /// What it does: Idle, Run, Hold, Jog, Alarm.
    pub state: String,
    /// The last thing that it was told.
    pub message: String,
    /// Length of a jog.
    pub step: String,
}

/// The whole picture; `panel` is what the side that commands says.
pub fn draw(frame: &mut Frame<'_>, state: &State, panel: Option<&Says>, note: &str) {
    let mode = if panel.is_some() { ", commands" } else { ", read-only" };
    let outer = Block::bordered().title(" beamtick monitor ");
    let inner = outer.inner(frame.area());
    frame.render_widget(outer, frame.area());
    let gauge = u16::from(state.job.is_some());
    let rows = [Constraint::Min(1), Constraint::Length(gauge), Constraint::Length(1), Constraint::Length(2)];
    let [machine, progress, says, keys] = Layout::vertical(rows).areas(inner);
    let style = |tone: Tone| match tone {
        Tone::Plain => Style::new(),
        Tone::Light => Style::new().yellow().add_modifier(Modifier::BOLD),
        Tone::Fault => Style::new().red().add_modifier(Modifier::BOLD),
    };
    // What is wrong comes first, so that a low terminal shows it.
    let (faults, others): (Vec<_>, Vec<_>) =
        block::lines(state, mode).into_iter().partition(|line| line.tone == Tone::Fault);
    let lines = faults.into_iter().chain(others).map(|line| Line::styled(line.text, style(line.tone)));
    let mut lines: Vec<_> = lines.collect();
    let room = usize::from(machine.height);
    if lines.len() > room {
        let more = lines.len() + 1 - room;
        lines.truncate(room.saturating_sub(1));
        lines.push(Line::from(format!("… {more} more lines: the terminal is low")));
    }
    frame.render_widget(Paragraph::new(lines), machine);
    if let Some(job) = &state.job {
        let ratio = f64::from(job.done.min(job.entries)) / f64::from(job.entries.max(1));
        let left = job.left_s.map_or(String::new(), |left| format!(", about {} left", block::time(left)));
        frame.render_widget(Gauge::default().ratio(ratio).label(format!("{:.0} %{left}", ratio * 100.0)), progress);
    }
    let told = match (note.is_empty(), panel) {
        (false, _) => note.to_owned(),
        (true, Some(says)) => format!("{}  {}", says.state, says.message),
        (true, None) => String::new(),
    };
    frame.render_widget(Paragraph::new(told).bold(), says);
    let help = match panel {
        None => vec![Line::from("q end")],
        Some(says) => vec![
            Line::from("space hold  g go on  x stop  s start  f frame  z set zero  u unlock  q end"),
            Line::from(format!("arrows, PageUp, PageDown jog by {}  + - longer, shorter", says.step)),
        ],
    };
    frame.render_widget(Paragraph::new(help).dim(), keys);
}
