//! The terminal: the block drawn, and keys.
//!
//! In: a state, keys. Out: a screen. Owns the terminal from [`Screen::open`] until it is dropped,
//! and then it is as it was. Fails: with the operating system's error.
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

/// See the module text.
pub struct Screen(DefaultTerminal);

impl Screen {
    /// Takes the terminal.
    pub fn open() -> Result<Screen, Failure> {
        ratatui::try_init().map(Screen).map_err(failed)
    }

    /// Draws everything.
    pub fn draw(&mut self, state: &State, panel: Option<&Panel>, note: &str) -> Result<(), Failure> {
        let panel = panel.map(Panel::says);
        self.0.draw(|frame| draw(frame, state, panel.as_ref(), note)).map(drop).map_err(failed)
    }

    /// The next key; none after this time without one.
    pub fn key(&mut self, wait: Duration) -> Result<Option<Key>, Failure> {
        if !event::poll(wait).map_err(failed)? {
            return Ok(None);
        }
        Ok(match event::read().map_err(failed)? {
            Event::Key(key) if key.kind != KeyEventKind::Release => Some(meaning(key.code, key.modifiers)),
            _ => None,
        })
    }
}

impl Drop for Screen {
    fn drop(&mut self) {
        ratatui::restore();
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
    let lines = block::lines(state, mode).into_iter().map(|line| Line::styled(line.text, style(line.tone)));
    frame.render_widget(Paragraph::new(lines.collect::<Vec<_>>()), machine);
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
