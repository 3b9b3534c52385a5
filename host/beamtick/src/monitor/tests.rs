//! The block and the screen without a terminal, and keys against a virtual controller.
use super::block::{self, Tone};
use super::panel::{Panel, Program};
use super::screen::{Key, Says, draw, meaning};
use super::state::{AxisNow, JobNow, LaserNow, PathNow, ProgramNow, State, StreamNow, UNKNOWN_MS};
use super::{PROGRESS_REFRESH_PERIOD, left_ms};
use crate::command_line::{Command, CommandLine, Monitor};
use crate::{connect, machine_file};
use clap::Parser;
use client::{Client, Options, ProductProfile};
use machine::Machine;
use ratatui::Terminal;
use ratatui::backend::TestBackend;
use ratatui::crossterm::event::{KeyCode, KeyModifiers};
use std::sync::Arc;
use std::time::{Duration, Instant};
use virtual_board::Served;

const MACHINE: &str = "
[axes.x]
number = 1
steps_per_mm = 100
travel = [0, 300]
max_rate = 12000
acceleration = 1000
[axes.y]
number = 2
steps_per_mm = 100
invert = true
travel = [0, 300]
max_rate = 12000
acceleration = 1000
[laser]
channel = 0
mode = \"duty\"
carrier_khz = 10
power = [0, 80]
s_max = 1000
";

/// Longest wait for what must come.
const WAIT_MAX: Duration = Duration::from_secs(60);

fn sample() -> State {
    let axis = |name: &str, mm: f64, speed: f64| AxisNow {
        name: name.to_owned(),
        position_pulse: mm * 100.0,
        position_mm: Some(mm),
        velocity_pulse_ms: speed / 600.0,
        velocity_mm_min: Some(speed),
        on: true,
        moves: speed != 0.0,
        stream: None,
    };
    State {
        board: "virtual".to_owned(),
        link: "tcp:127.0.0.1:5002".to_owned(),
        clock_s: 83.4,
        axes: vec![axis("X", 12.345, 600.0), axis("Y", -0.0, 0.0), AxisNow { moves: true, ..axis("Z", 1.0, 0.0) }],
        paths: vec![PathNow {
            core: 1,
            number: 1,
            runs: true,
            speed_pulse_ms: 1.0,
            speed_mm_min: Some(600.0),
            segments_done: 12,
            segments_left: 312,
            entries: 312,
            capacity: 1024,
            dry_ms: 1240,
        }],
        lasers: vec![
            LaserNow { channel: 0, light: true, commanded: true, power: 50.0, unit: "%", frequency_khz: 10.0 },
            LaserNow { channel: 1, light: false, commanded: false, power: 0.0, unit: "%", frequency_khz: 0.0 },
        ],
        program: ProgramNow { state: "running", executed: 40, accepted: 120, late: 0, script_s: 3.25 },
        job: Some(JobNow { name: "square.nc".to_owned(), done: 1234, entries: 5678, left_s: Some(12.0) }),
        faults: vec!["axis 3: positive limit; the positive limit switch is active".to_owned()],
    }
}

#[test]
fn the_block_says_what_the_machine_does() {
    let lines: Vec<String> = block::lines(&sample(), ", read-only").into_iter().map(|line| line.text).collect();
    let expected = "\
virtual at tcp:127.0.0.1:5002, read-only; on for 0:01:23
X              12.345 mm      600.0 mm/min  moves
Y               0.000 mm        0.0 mm/min  stands
Z               1.000 mm        0.0 mm/min  runs
laser 0  LIGHT 50.00 %, 10.00 kHz
laser 1  dark
path 1   runs at 600.0 mm/min; FIFO 312 of 1024, dry in 1.2 s
program  running, 40 of 120 entries executed, script clock 3.2 s
job      1234 of 5678 done, 21 %, about 0:00:12 left: square.nc
FAULT    axis 3: positive limit; the positive limit switch is active";
    assert_eq!(lines.join("\n"), expected);
    // In pulses, and a stream.
    let mut state = sample();
    (state.axes[0].position_mm, state.axes[0].velocity_mm_min) = (None, None);
    state.axes[0].stream = Some(StreamNow { space: 900, dry_ms: 2040 });
    state.paths[0].speed_mm_min = None;
    let lines = block::machine(&state);
    assert_eq!(lines[0].text, "X              1234.5 pulses       1.00 pulse/ms  moves, 900 free, dry in 2.0 s");
    assert!(lines.iter().any(|line| line.text.contains("runs at 1.00 pulse/ms")));
    let tones: Vec<Tone> = lines.iter().map(|line| line.tone).filter(|tone| *tone != Tone::Plain).collect();
    assert_eq!(tones, [Tone::Light, Tone::Fault]);
}

#[test]
fn no_line_is_longer_than_a_terminal_or_changes_it() {
    let mut state = sample();
    state.faults.push("x".repeat(300));
    state.board = "\u{1b}[31mboard\r\n".to_owned();
    state.job = Some(JobNow { name: "ä".repeat(300), done: u32::MAX, entries: 1, left_s: None });
    for line in block::lines(&state, "") {
        assert!(line.text.chars().count() <= 80, "{}", line.text);
        assert!(!line.text.contains(char::is_control), "{}", line.text);
    }
}

fn screen(state: &State, says: Option<&Says>, note: &str) -> String {
    let mut terminal = Terminal::new(TestBackend::new(82, 18)).unwrap();
    terminal.draw(|frame| draw(frame, state, says, note)).unwrap();
    let buffer = terminal.backend().buffer().clone();
    let rows = buffer.content.chunks(82).map(|row| row.iter().map(|cell| cell.symbol()).collect::<String>());
    rows.collect::<Vec<_>>().join("\n")
}

#[test]
fn the_screen_shows_the_block_and_what_keys_do() {
    let looks = screen(&sample(), None, "");
    for line in block::lines(&sample(), ", read-only") {
        assert!(looks.contains(&line.text), "{looks}");
    }
    assert!(looks.contains("beamtick monitor") && looks.contains("22 %, about 0:00:12 left"), "{looks}");
    assert!(looks.contains("q end") && !looks.contains("space hold"), "{looks}");
    let note = screen(&sample(), None, super::LOOKS);
    assert!(note.contains("this view only looks; --command with --machine FILE takes the controller"), "{note}");
    let says = Says { state: "Hold:0".to_owned(), message: "told".to_owned(), step: "10 mm".to_owned() };
    let commands = screen(&sample(), Some(&says), "");
    for text in [", commands;", "Hold:0  told", "space hold", "f frame", "z set zero", "jog by 10 mm"] {
        assert!(commands.contains(text), "{text}: {commands}");
    }
    // A terminal that is too small shows less, and nothing fails.
    for (columns, rows) in [(1, 1), (20, 5), (80, 3)] {
        let mut terminal = Terminal::new(TestBackend::new(columns, rows)).unwrap();
        terminal.draw(|frame| draw(frame, &sample(), Some(&says), "")).unwrap();
    }
}

#[test]
fn keys_have_their_meanings() {
    let plain = |code| meaning(code, KeyModifiers::NONE);
    for (letter, key) in
        [(' ', Key::Hold), ('g', Key::GoOn), ('x', Key::Stop), ('s', Key::Start), ('f', Key::Frame), ('z', Key::Zero)]
    {
        assert_eq!(plain(KeyCode::Char(letter)), key);
    }
    assert_eq!((plain(KeyCode::Left), plain(KeyCode::Up)), (Key::Jog(0, false), Key::Jog(1, true)));
    assert_eq!((plain(KeyCode::PageDown), plain(KeyCode::Char('k'))), (Key::Jog(2, false), Key::Unknown));
    assert_eq!(meaning(KeyCode::Char('c'), KeyModifiers::CONTROL), Key::Quit);
    // With Ctrl nothing starts.
    assert_eq!(meaning(KeyCode::Char('s'), KeyModifiers::CONTROL), Key::Unknown);
}

#[test]
fn the_time_left_is_that_of_the_plan() {
    assert_eq!(left_ms(2.0, Some(12.0)), 10_000);
    assert_eq!(left_ms(20.0, Some(12.0)), 0);
    assert_eq!(left_ms(2.0, None), UNKNOWN_MS);
    assert!(PROGRESS_REFRESH_PERIOD >= Duration::from_millis(100), "reads of the block load the link");
}

/// Keys in front of a virtual controller in real time.
struct Rig {
    panel: Panel,
    client: Arc<Client>,
    machine: Machine,
    served: Served,
}

impl Rig {
    fn new(program: &str) -> Rig {
        let folder = tempfile::tempdir().unwrap();
        let (file, nc) = (folder.path().join("m.toml"), folder.path().join("p.nc"));
        std::fs::write(&file, MACHINE).unwrap();
        std::fs::write(&nc, program).unwrap();
        let words = ["beamtick", "monitor", nc.to_str().unwrap(), "--command", "--machine", file.to_str().unwrap()];
        let Command::Monitor(arguments) = CommandLine::try_parse_from(words).unwrap().command else { panic!() };
        let arguments: Monitor = arguments;
        let machine = machine_file::open(&file, None).unwrap();
        let program = Program::open(&nc, &arguments).map_err(|failure| panic!("{failure:?}")).ok();
        let (served, link) =
            connect::real_time(None, ProductProfile::Gus).map_err(|failure| panic!("{failure:?}")).unwrap();
        let client = Arc::new(Client::open(link, Options::default()).unwrap());
        let panel = Panel::new(Arc::clone(&client), &machine, program);
        let mut rig = Rig { served, panel, client, machine };
        rig.until("Idle");
        rig
    }

    fn turn(&mut self) {
        self.panel.turn().unwrap();
        std::thread::sleep(Duration::from_millis(2));
    }

    fn is_lit(&self) -> bool {
        self.served.board().lock().unwrap().laser_view(0).light
    }

    /// Until it says this, in a report that is not older than the call.
    fn until(&mut self, state: &str) {
        let began = Instant::now();
        while began.elapsed() < Duration::from_millis(450) {
            self.turn();
        }
        self.wait(|rig| rig.panel.says().state.starts_with(state));
    }

    fn wait(&mut self, mut is: impl FnMut(&Rig) -> bool) {
        let began = Instant::now();
        while !is(self) {
            self.turn();
            assert!(began.elapsed() < WAIT_MAX, "{:?}", self.panel.says());
        }
    }

    /// Machine position, mm.
    fn at(&self) -> [f64; 2] {
        let state = State::read(&self.client, &machine_file::millimetres(&self.machine), None).unwrap();
        [0, 1].map(|axis| state.axes[axis].position_mm.unwrap())
    }

    fn press(&mut self, key: Key) {
        let told = self.panel.press(key);
        assert_eq!(told, "", "{key:?}");
    }
}

/// A square of 20 mm, 10 mm from zero, at 40 mm/s.
const SQUARE: &str = "G21 G90\nG0 X10 Y10\nM3 S500\nG1 X30 F2400\nG1 Y30\nG1 X10\nG1 Y10\nM5\nM2\n";

#[test]
fn a_program_is_held_in_the_dark_goes_on_and_ends() {
    let mut rig = Rig::new(SQUARE);
    rig.press(Key::Start);
    rig.wait(Rig::is_lit);
    let job = rig.panel.job().expect("it runs");
    assert!(job.entries == 9 && job.left_s.unwrap() > 0.0, "{job:?}");
    assert_eq!(rig.panel.press(Key::Zero), "the program runs; x stops it");
    rig.press(Key::Hold);
    rig.until("Hold:0");
    let at = rig.at();
    for _ in 0..50 {
        rig.turn();
        assert!(!rig.is_lit());
    }
    assert_eq!(rig.at(), at);
    assert!((10.0..=30.0).contains(&at[0]) && at != [10.0, 10.0], "{at:?}");
    rig.press(Key::GoOn);
    rig.wait(Rig::is_lit);
    rig.wait(|rig| rig.panel.job().is_none());
    assert_eq!((rig.at(), rig.panel.says().message.as_str()), ([10.0, 10.0], "the program is done"));
    assert!(!rig.is_lit());
}

#[test]
fn jogs_the_frame_and_zero_are_dark_and_go_where_they_say() {
    let mut rig = Rig::new(SQUARE);
    rig.served.board().lock().unwrap().record_beam(true);
    rig.press(Key::Jog(0, true));
    rig.press(Key::Jog(1, true));
    rig.wait(|rig| rig.at() == [10.0, 10.0]);
    rig.until("Idle");
    assert_eq!(rig.panel.press(Key::Jog(2, true)), "the machine has no such axis");
    rig.press(Key::Step(false));
    rig.press(Key::Jog(0, false));
    rig.wait(|rig| rig.at() == [5.0, 10.0]);
    rig.until("Idle");
    rig.press(Key::Zero);
    // The frame is that of the program from its zero: 15 to 35 and 20 to 40.
    rig.press(Key::Frame);
    for corner in [[15.0, 20.0], [35.0, 20.0], [35.0, 40.0], [15.0, 40.0], [15.0, 20.0]] {
        rig.wait(|rig| {
            let at = rig.at();
            assert!(at[0] <= 35.0 && at[1] <= 40.0, "{at:?}");
            // It goes through corners, and is looked at now and then.
            at.iter().zip(corner).all(|(at, corner)| (at - corner).abs() < 1.0)
        });
    }
    rig.wait(|rig| rig.at() == [15.0, 20.0]);
    rig.until("Idle");
    assert!(rig.served.board().lock().unwrap().take_beam().is_empty(), "light in a jog");
}

#[test]
fn a_stop_is_dark_at_once_and_the_program_begins_anew() {
    let mut rig = Rig::new(SQUARE);
    rig.press(Key::Start);
    rig.wait(Rig::is_lit);
    rig.press(Key::Stop);
    rig.wait(|rig| !rig.is_lit());
    assert!(rig.panel.job().is_none());
    rig.until("Idle");
    let at = rig.at();
    assert!(at[0] > 10.0 || at[1] > 10.0, "{at:?}");
    for _ in 0..50 {
        rig.turn();
        assert!(!rig.is_lit());
    }
    assert_eq!(rig.at(), at, "the position is known, and nothing moves");
    rig.press(Key::Start);
    rig.wait(Rig::is_lit);
    rig.wait(|rig| rig.panel.job().is_none());
    assert_eq!(rig.at(), [10.0, 10.0]);
}

#[test]
fn the_end_of_the_monitor_is_dark() {
    let mut rig = Rig::new(SQUARE);
    rig.press(Key::Start);
    rig.wait(Rig::is_lit);
    rig.panel.end().unwrap();
    assert!(!rig.is_lit());
    let error = rig.panel.turn().expect_err("it has ended");
    assert!(error.reason.contains("has ended"), "{error}");
}

#[test]
fn a_line_that_is_refused_stops_the_program_and_is_named() {
    let mut rig = Rig::new(SQUARE);
    // Zero near the far end: the square leaves the travel.
    for _ in 0..6 {
        rig.press(Key::Step(true));
    }
    for _ in 0..6 {
        rig.press(Key::Jog(0, true));
    }
    rig.wait(|rig| rig.at()[0] == 300.0);
    rig.until("Idle");
    rig.press(Key::Zero);
    rig.press(Key::Start);
    rig.wait(|rig| rig.panel.job().is_none());
    rig.until("Alarm");
    assert!(!rig.is_lit());
    assert!(rig.panel.says().message.contains("travel"), "{:?}", rig.panel.says());
    // A reset ends what is said of the alarm: what is refused after it says why.
    rig.press(Key::Stop);
    let stopped = rig.panel.says().message;
    rig.until("");
    rig.press(Key::Jog(0, true));
    rig.wait(|rig| ![stopped.as_str(), ""].contains(&rig.panel.says().message.as_str()));
    rig.press(Key::Unlock);
    rig.until("Idle");
}
