//! The port in front of a virtual controller, word by word, with a sender in this process.
mod common;

use common::{MACHINE, Rig, near};
use std::io::{Read, Write};
use std::net::TcpStream;

#[test]
fn every_line_end_is_answered() {
    let rig = Rig::new(MACHINE, false);
    let mut sender = rig.sender();
    assert!(sender.banner().is_empty());
    for (text, answers) in
        [("\n", 1), ("\r", 1), ("\r\n", 2), ("G21\rG90\n", 2), (" ; only a comment\n", 1), ("%\n", 1)]
    {
        sender.send(text);
        for _ in 0..answers {
            assert_eq!(sender.answer(), ["ok"], "{text:?}");
        }
    }
    // A bare $, as meerk40t asks first, then $G and a status.
    sender.send("$\r");
    let help = sender.answer();
    assert!(help[0].starts_with("[HLP:$$ $# $G ") && help.len() == 2, "{help:?}");
    sender.send("$G\r");
    assert_eq!(sender.answer(), ["[GC:G0 G54 G17 G21 G90 G94 M5 M9 T0 F0 S0]", "ok"]);
    assert_eq!(sender.status().state, "Idle");
    // A line in pieces, with a status between them.
    sender.send("G1 F6");
    assert_eq!(sender.status().field("Bf"), Some("15,123"));
    sender.send("00 S5 M4\n");
    assert_eq!(sender.answer(), ["ok"]);
    assert_eq!(sender.ok("$G"), ["[GC:G1 G54 G17 G21 G90 G94 M4 M9 T0 F600 S5]"]);
    // Too long, and the next one is whole.
    sender.send([&b"G1 X"[..], &[b'1'; 300], b"\nG0\n"].concat());
    assert_eq!(sender.answer(), ["[MSG:a line has at most 255 characters]", "error:11"]);
    assert_eq!(sender.answer(), ["ok"]);
    // 0x18: all over again, whatever was half sent.
    sender.send("G1 F7\x18$G\n");
    sender.banner();
    assert_eq!(sender.answer()[0], "[GC:G0 G54 G17 G21 G90 G94 M5 M9 T0 F0 S0]");
}

#[test]
fn what_the_dollar_commands_list() {
    let rig = Rig::new(&MACHINE.replace("travel = [0, 300]", "travel = [-10, 300]"), false);
    let mut sender = rig.sender();
    sender.banner();
    let settings = sender.ok("$$");
    for line in [
        "$10=3",
        "$13=0",
        "$3=2",
        "$20=1",
        "$22=1",
        "$30=1000",
        "$32=1",
        "$100=100.000",
        "$101=100.000",
        "$110=12000.000",
        "$120=1000.000",
        "$130=310.000",
        "$11=0.020",
    ] {
        assert!(settings.contains(&line.to_owned()), "{line}: {settings:?}");
    }
    // All written back, as a sender does; what is another machine is refused.
    for line in &settings {
        sender.ok(line);
    }
    for line in ["$100=80", "$30=255", "$10=9", "$10=x", "$99=1", "$x=1", "$", "$Q", "$=", "$N2=G21", "$J"] {
        if line != "$" {
            assert_eq!(sender.error(line), 3, "{line}");
        }
    }
    sender.ok("$10=0");
    assert!(sender.status().field("WPos").is_some());
    sender.ok("$13=1");
    sender.ok("G10 L2 P3 X25.4");
    sender.ok("G56 G92 Y5");
    sender.ok("G43.1 X1");
    let listed = sender.ok("$#");
    for line in [
        "[G54:0.0000,0.0000,0.0000]",
        "[G56:1.0000,0.0000,0.0000]",
        "[G28:0.0000,0.0000,0.0000]",
        "[PRB:0.0000,0.0000,0.0000:0]",
    ] {
        assert!(listed.contains(&line.to_owned()), "{line}: {listed:?}");
    }
    sender.ok("$rst=*");
    assert!(sender.ok("$#").contains(&"[G56:0.000,0.000,0.000]".to_owned()));
    assert!(sender.ok("$$").contains(&"$10=3".to_owned()));
    assert_eq!(sender.ok("$I"), ["[VER:1.1h.20190825:Beamtick]", "[OPT:VL,15,128]"]);
    sender.ok("$N0 = G20 g91");
    assert_eq!(sender.ok("$N"), ["$N0=G20G91", "$N1="]);
    sender.send("\x18");
    sender.banner();
    assert_eq!(sender.line(), ">G20G91:ok");
    assert!(sender.ok("$G")[0].contains("G20 G91"));
    // Check: lines are read, nothing moves; leaving it is a reset.
    sender.ok("$N0=");
    assert_eq!(sender.ok("$C"), ["[MSG:Enabled]"]);
    assert_eq!(sender.status().state, "Check");
    sender.ok("G21 G90 G1 X100 F100");
    assert_eq!(sender.error("G1 X1 X2"), 25);
    sender.send("$C\n");
    sender.banner();
    let status = sender.idle();
    assert!(near(status.at[0], 0.0), "{status:?}");
    // Sleep ends with a reset only.
    assert_eq!(sender.ok("$SLP"), ["[MSG:Sleeping]"]);
    sender.send("G21\n");
    assert_eq!(sender.status().state, "Sleep");
    sender.send("\x18");
    sender.banner();
    assert_eq!(sender.status().state, "Idle");
}

#[test]
fn errors_have_grbls_numbers() {
    let rig = Rig::new(MACHINE, false);
    let mut sender = rig.sender();
    sender.banner();
    for (line, number) in [
        ("12", 1),
        ("#1=2", 1),
        ("G1 X", 2),
        ("G1 X1.2.3", 2),
        ("F-5", 4),
        ("S-1", 4),
        ("G4 P-1", 4),
        ("M6", 20),
        ("G41", 20),
        ("A5", 20),
        ("G0 Z1", 20),
        ("G38.2 X1", 20),
        ("G0 G1 X1", 21),
        ("M3 M5", 21),
        ("G1 X1", 22),
        ("G93 G1 X1", 22),
        ("G28 G1 X1", 24),
        ("X1 X2", 25),
        ("G92", 26),
        ("G10 L2 P1", 26),
        ("G4", 28),
        ("G10 L2 X1", 28),
        ("G10 L2 P9 X1", 29),
        ("G53 G80", 30),
        ("G80 X1", 31),
        ("G2 R5 F100", 26),
        ("G2 X10 I4 F100", 33),
        ("G2 X10 R4 F100", 34),
        ("G2 X1 Y1 F100", 35),
        ("P5", 36),
        ("G1 I5 X1 F1", 36),
        ("$J=G91 X1", 22),
        ("$J=X1 S5 F100", 16),
        ("$J=F100", 16),
        ("$J=X-1 F100", 15),
        ("$FOO", 3),
    ] {
        assert_eq!(sender.error(line), number, "{line}");
        assert_eq!(sender.ok("$G"), ["[GC:G0 G54 G17 G21 G90 G94 M5 M9 T0 F0 S0]"], "{line} changes nothing");
    }
    assert_eq!(sender.idle().at, [0.0; 3]);
    assert_eq!(rig.at(), [0.0; 2]);
}

#[test]
fn lines_move_and_reports_say_so() {
    let rig = Rig::new(MACHINE, false);
    let mut sender = rig.sender();
    sender.banner();
    sender.ok("G10 L2 P1 X5");
    sender.ok("G21 G90 M3 S500 F600");
    sender.ok("G1 X95 Y50");
    let status = sender.until(|status| status.state == "Run" && status.at[0] > 20.0 && status.speeds().1 > 0.0);
    assert!(near(status.at[1], status.at[0] / 2.0), "{status:?}");
    let (feed, power) = status.speeds();
    assert!((feed - 600.0).abs() <= 1.0 && (power - 500.0).abs() <= 1.0, "{status:?}");
    assert_eq!(status.field("Bf"), Some("14,128"));
    let status = sender.until(|status| status.field("WCO").is_some());
    assert_eq!(status.field("WCO"), Some("5.000,0.000,0.000"));
    let status = sender.until(|status| status.field("Ov").is_some());
    assert_eq!((status.field("Ov"), status.field("A")), (Some("100,100,100"), Some("S")));
    // Not during motion.
    assert_eq!(sender.error("$$"), 8);
    assert_eq!(sender.error("$H"), 8);
    assert_eq!(sender.error("$J=X1 F100"), 8);
    let status = sender.idle();
    assert!(near(status.at[0], 100.0) && near(status.at[1], 50.0) && status.speeds() == (0.0, 0.0), "{status:?}");
    // Y counts down.
    assert_eq!(rig.at(), [10_000.0, -5000.0]);
    assert!(!rig.lit());
    // M2: answered at standstill.
    sender.ok("G0 X0");
    assert_eq!(sender.ok("M2"), ["[MSG:Pgm End]"]);
    assert_eq!(rig.at(), [500.0, -5000.0]);
    // $H: to home, answered there.
    sender.ok("$H");
    assert_eq!(rig.at(), [0.0, 0.0]);
    let outputs = |rig: &Rig| rig.board.lock().unwrap().outputs().general & 3;
    let before = outputs(&rig);
    sender.ok("M8");
    sender.idle();
    assert_eq!(outputs(&rig), before ^ 2);
    sender.send([0xa1, 0xa0]);
    sender.idle();
    assert_eq!(outputs(&rig), before ^ 1);
    assert!(sender.ok("$G")[0].contains(" M7 "));
    sender.ok("M9");
    sender.idle();
    assert_eq!(outputs(&rig), before);
}

/// A path that ran out of lines is dark. Lines that follow without a word of light go on with it.
#[test]
fn light_goes_on_with_the_next_line_after_a_pause_of_the_sender() {
    for (family, spindle) in [("gus", "M3"), ("gus", "M4"), ("lsr", "M3"), ("lsr", "M4")] {
        let rig = Rig::new(&format!("family = \"{family}\"\n{MACHINE}"), false);
        let mut sender = rig.sender();
        sender.banner();
        sender.ok(&format!("G1 {spindle} S500 F1200 X10"));
        sender.idle();
        assert!(!rig.lit());
        sender.ok("X40");
        sender.until(|status| status.at[0] > 15.0 && status.at[0] < 35.0);
        assert!(rig.lit(), "{family} {spindle}");
        sender.idle();
        assert!(!rig.lit());
        // What comes first is dark: no light in between.
        rig.board.lock().unwrap().record_beam(true);
        sender.ok("G0 X50");
        sender.idle();
        let light = rig.board.lock().unwrap().take_beam();
        assert!(light.is_empty(), "{family} {spindle}: {light:?}");
        sender.ok("G1 S250");
        sender.ok("X90");
        let status = sender.until(|status| status.at[0] > 60.0 && status.at[0] < 85.0 && status.speeds().1 > 0.0);
        assert!((status.speeds().1 - 250.0).abs() <= 1.0, "{family} {spindle}: {status:?}");
        sender.idle();
        assert_eq!(rig.at()[0], 9000.0);
    }
}

#[test]
fn a_jog_is_dark_apart_from_the_modes_and_ends_at_once() {
    let rig = Rig::new(MACHINE, false);
    let mut sender = rig.sender();
    sender.banner();
    sender.ok("G1 M3 S900 F100 G91");
    let modes = sender.ok("$G");
    sender.ok("$J=G90 G21 X200 F6000");
    sender.ok("$J=G91 Y10 F600");
    let status = sender.until(|status| status.at[0] > 20.0);
    assert_eq!(status.state, "Jog");
    assert!(!rig.lit());
    assert_eq!(sender.error("G0 X0"), 9);
    sender.send([0x85]);
    sender.idle();
    let [x, y] = rig.at();
    assert!(x > 2000.0 && x < 19_000.0 && y == 0.0, "{x} {y}");
    assert_eq!(sender.ok("$G"), modes);
    // Relative to where it stands.
    sender.ok("$J=X-5 F6000");
    sender.idle();
    assert!((rig.at()[0] - (x - 500.0)).abs() < 1.0);
    sender.ok("$J=G90 X0 F12000");
    sender.until(|status| status.state == "Jog");
    sender.send("!");
    sender.idle();
    sender.ok("G90 G0 X1");
    sender.idle();
    assert_eq!(rig.at(), [100.0, 0.0]);
}

#[test]
fn overrides_act_and_are_reported() {
    let rig = Rig::new(&MACHINE.replace("max_rate = 12000", "max_rate = 1200"), false);
    let mut sender = rig.sender();
    sender.banner();
    let ov = |sender: &mut common::Sender| {
        let status = sender.until(|status| status.field("Ov").is_some());
        status.field("Ov").unwrap().to_owned()
    };
    sender.send([0x91, 0x91, 0x93, 0x96, 0x9b, 0x9d]);
    assert_eq!(ov(&mut sender), "121,50,89");
    sender.send([0x90, 0x92, 0x94, 0x97, 0x99, 0x9a, 0x9c]);
    assert_eq!(ov(&mut sender), "89,25,111");
    sender.send([0x92; 20]);
    sender.send([0x9b; 20]);
    assert_eq!(ov(&mut sender), "10,25,10");
    sender.send([0x91; 20]);
    sender.send([0x9a; 20]);
    assert_eq!(ov(&mut sender), "200,25,200");
    sender.send([0x90, 0x95, 0x99]);
    assert_eq!(ov(&mut sender), "100,100,100");
    // At once where it is slower, and never faster than asked for.
    sender.send([0x91; 5]);
    sender.ok("G1 M4 S400 F120 X60");
    let steady = |sender: &mut common::Sender, feed: f64| sender.until(|status| (status.speeds().0 - feed).abs() < 1.0);
    steady(&mut sender, 180.0);
    assert!((sender.until(|status| status.speeds().1 > 0.0).speeds().1 - 600.0).abs() < 2.0);
    sender.send([0x90]);
    steady(&mut sender, 120.0);
    sender.send([0x92; 5]);
    steady(&mut sender, 60.0);
    let status = sender.until(|status| (status.speeds().1 - 200.0).abs() < 2.0);
    assert!(status.at[0] < 58.0, "{status:?}");
    sender.send("\x18");
    sender.banner();
    sender.ok("G0 X60");
    sender.idle();
    sender.send([0x97]);
    sender.ok("G0 X0");
    steady(&mut sender, 300.0);
    sender.idle();
    // M3 with the power at half.
    sender.send([0x9b; 5]);
    sender.ok("G1 M3 S400 F120 X50");
    let status = sender.until(|status| status.speeds().1 > 0.0 && status.at[0] > 10.0);
    assert!((status.speeds().1 - 200.0).abs() < 2.0, "{status:?}");
    sender.send("\x18");
    sender.banner();
    assert_eq!(ov(&mut sender), "100,100,100");
}

/// What meerk40t 0.9 sends to a port, as it was recorded: its questions one by one, then lines that
/// end in CR, up to the bytes that it counts.
#[test]
fn meerk40t_asks_and_sends_as_it_does() {
    let rig = Rig::new(MACHINE, false);
    let mut sender = rig.sender();
    sender.banner();
    sender.send("$\r");
    assert!(sender.answer()[0].starts_with("[HLP:"));
    sender.send("$$\r");
    assert!(sender.answer().iter().any(|line| line == "$30=1000"));
    sender.send("$G\r");
    assert!(sender.answer()[0].starts_with("[GC:"));
    // A status with a line end: the report, and the ok of an empty line.
    sender.send("?\r");
    assert!(sender.line().starts_with("<Idle|MPos:"));
    assert_eq!(sender.answer(), ["ok"]);
    sender.send("G90\r");
    assert_eq!(sender.answer(), ["ok"]);
    sender.send("G94\rG21\rM4\rG0 X19.990 Y215.011 S0 F600\rG1 X29.997 Y215.011 S1000 F6000\rG1 X29.997 Y205.003\r");
    for _ in 0..6 {
        assert_eq!(sender.answer(), ["ok"]);
    }
    sender.send("G1 X19.990 Y205.003\rG1 X19.990 Y215.011\rG0 X45.009 Y194.996 S0\rG1 X45.006 Y194.873 S1000\r");
    for _ in 0..4 {
        assert_eq!(sender.answer(), ["ok"]);
    }
    sender.send("G1 X45.000 Y194.750\rG0 S0\rM5\r");
    for _ in 0..3 {
        assert_eq!(sender.answer(), ["ok"]);
    }
    sender.idle();
    assert_eq!((rig.at(), rig.lit()), ([4500.0, -19_475.0], false));
}

/// A sender that does not count gets its answers as the path goes on, not in one burst at its
/// beginning.
#[test]
fn lines_that_come_at_once_are_answered_as_the_path_goes_on() {
    const LINES: usize = 500;
    let rig = Rig::new(MACHINE, false);
    let mut sender = rig.sender();
    sender.banner();
    sender.ok("G21 G90 M4 G1 F3000");
    // 0.5 mm each: 10 ms.
    let lines: String = (1..=LINES).map(|line| format!("G1 X{} S500\n", line as f64 * 0.5)).collect();
    sender.send(&lines);
    for answered in 1..=LINES {
        assert_eq!(sender.line(), "ok");
        let done = rig.at()[0] / 50.0;
        // 500 ms, what has not reached the controller, and what the view lags behind.
        assert!(answered as f64 - done < 200.0, "{answered} lines are answered, and {done} are done");
    }
    sender.idle();
    assert_eq!(rig.at(), [25_000.0, 0.0]);
}

/// S sets the laser that is chosen, in its own units; the other one stays dark.
#[test]
fn one_of_two_lasers_is_chosen() {
    let (axes, rest) = MACHINE.split_once("[laser]").unwrap();
    assert!(rest.contains("[outputs]"));
    let lasers = "[lasers.engrave]\nchannel = 1\nmode = \"duty\"\ncarrier_khz = 10\npower = [0, 80]\ns_max = 1000\n\
                  [lasers.cut]\nchannel = 0\nmode = \"analog\"\npower = [0, 10]\ns_max = 255\n";
    let text = format!("{axes}{lasers}");
    for (chosen, channel, s_max) in [(None, 1, 1000.0), (Some("engrave"), 1, 1000.0), (Some("cut"), 0, 255.0)] {
        let rig = Rig::of(machine::Machine::read_for("m.toml", &text, chosen).unwrap());
        let mut sender = rig.sender();
        sender.banner();
        assert!(sender.ok("$$").contains(&format!("$30={s_max:.0}")), "{chosen:?}");
        sender.ok("$X");
        sender.ok(&format!("M3 S{} F600 G1 X50", s_max / 2.0));
        let status = sender.until(|status| {
            let switches = rig.switches();
            assert!(!switches[1 - channel], "{chosen:?}");
            status.at[0] > 5.0
        });
        assert!(rig.switches()[channel], "{chosen:?}");
        assert!((status.speeds().1 - s_max / 2.0).abs() < 1.0, "{chosen:?}: {status:?}");
        // A reset is dark at once, whichever laser it is.
        sender.send("\x18");
        sender.banner();
        assert_eq!(rig.switches(), [false, false], "{chosen:?}");
        rig.end();
    }
}

/// What changes the laser at standstill, after light, is done at once: no motion follows.
#[test]
fn a_dwell_of_nothing_after_light_ends_it() {
    for changes in ["M5", "M2", "S100", "M5\nM3 S200", "M4 S10\nM5"] {
        let rig = Rig::new(MACHINE, false);
        let mut sender = rig.sender();
        sender.banner();
        sender.ok("M3 S900 G1 X5 F1200");
        sender.idle();
        changes.split('\n').for_each(|line| drop(sender.ok(line)));
        sender.ok("G4P0");
        let status = sender.idle();
        assert_eq!((status.state.as_str(), rig.switches(), rig.at()), ("Idle", [false; 2], [500.0, 0.0]), "{changes}");
        // F is as before.
        sender.ok("G1 X6");
        sender.idle();
        assert_eq!(rig.at(), [600.0, 0.0], "{changes}");
        rig.end();
    }
}

/// What switches outputs at standstill is no mark: the light that is on in the modal state comes
/// back with the next motion.
#[test]
fn outputs_alone_at_standstill_keep_the_light_of_what_follows() {
    for alone in ["M8", "M7", "M9", "M8\nM9", "M5\nM8", "M2"] {
        let rig = Rig::new(MACHINE, false);
        let mut sender = rig.sender();
        sender.banner();
        sender.ok("M3 S900 G1 X5 F3000");
        sender.idle();
        for line in alone.split('\n') {
            sender.ok(line);
            sender.idle();
        }
        sender.ok("G1 M3 S500 X205 F1200");
        sender.until(|status| status.at[0] > 7.0 && status.at[0] < 190.0);
        assert!(rig.lit(), "{alone}");
        sender.send("\x18");
        sender.banner();
        assert!(!rig.lit(), "{alone}");
        rig.end();
    }
}

#[test]
fn start_up_lines_are_tried_and_switch_no_laser_on() {
    let rig = Rig::new(MACHINE, false);
    let mut sender = rig.sender();
    sender.banner();
    for (line, number) in [("$N0=garbage", 2), ("$N0=M3 S500", 20), ("$N1=M0", 20), ("$N0=G1X5", 22), ("$N2=G20", 3)] {
        assert_eq!(sender.error(line), number, "{line}");
    }
    assert_eq!(sender.ok("$N"), ["$N0=", "$N1="]);
    assert_eq!(sender.ok("$N0=G55 G91"), [""; 0]);
    // It was tried, and has changed nothing.
    assert!(sender.ok("$G")[0].starts_with("[GC:G0 G54 G17 G21 G90"));
    sender.send("\x18");
    sender.banner();
    assert_eq!(sender.line(), ">G55G91:ok");
    // They run after a reset, which ends M3: what is in force now is nothing to them.
    sender.ok("M3 S500 G1 F600");
    assert_eq!(sender.error("$N1=M3"), 20);
    for line in ["$N0=G20", "$N0="] {
        sender.ok(line);
    }
    assert_eq!(sender.ok("$N"), ["$N0=", "$N1="]);
    // As a reset, also of what is modal.
    assert_eq!(sender.ok("$RST=*"), ["[MSG:Restoring defaults]"]);
    sender.banner();
    assert!(sender.ok("$G")[0].starts_with("[GC:G0 G54 G17 G21 G90"));
    rig.end();
}

#[test]
fn comments_are_grbls() {
    let rig = Rig::new(MACHINE, false);
    let mut sender = rig.sender();
    sender.banner();
    for line in ["(a;b)", "(Tool; 3 mm)", "(;)", "(open", "(a;", "; (", "(a) ; b)", "(a)(b"] {
        assert_eq!(sender.ok(line), [""; 0], "{line}");
    }
    assert_eq!(sender.error("a) ; b"), 1);
    sender.ok("G1(;)X1F6000 (open");
    sender.ok("(x;y)Y1;(z)");
    sender.idle();
    assert_eq!(rig.at(), [100.0, -100.0]);
    rig.end();
}

/// One that has sent something reads the message too.
#[test]
fn a_second_sender_reads_that_another_is_there() {
    let rig = Rig::new(MACHINE, false);
    let mut first = rig.sender();
    first.banner();
    for sent in ["", "?\n", "\x18!G1X50F100\n"] {
        let mut second = TcpStream::connect(rig.address).unwrap();
        second.write_all(sent.as_bytes()).unwrap();
        let mut read = String::new();
        second.read_to_string(&mut read).unwrap();
        assert_eq!(read, "[MSG:Busy: another sender is connected]\r\n", "{sent:?}");
    }
    assert_eq!(first.status().state, "Idle");
    rig.end();
}
