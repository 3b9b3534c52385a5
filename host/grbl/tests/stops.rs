//! Holds, resets, cut connections and alarms, in front of a virtual controller.
mod common;

use common::{MACHINE, Rig, near};
use std::time::Duration;

#[test]
fn a_hold_is_dark_on_the_path_and_goes_on_with_its_light() {
    let rig = Rig::new(MACHINE, false);
    let mut sender = rig.sender();
    sender.banner();
    sender.ok("G1 M3 S500 F1200 X100 Y50");
    sender.ok("G0 X0");
    sender.until(|status| status.at[0] > 20.0);
    assert!(rig.lit());
    sender.send("!");
    let status = sender.until(|status| status.state == "Hold:0");
    assert!(!rig.lit());
    let [x, y] = rig.at();
    assert!(x > 2000.0 && x < 9000.0 && (x / 2.0 + y).abs() < 1.0, "{x} {y}");
    assert!(near(status.at[0], x / 100.0), "{status:?}");
    // Lines wait; reports do not.
    sender.send("G0 Y0\n");
    assert_eq!(sender.status().state, "Hold:0");
    assert_eq!((rig.at(), rig.lit()), ([x, y], false));
    sender.send("~");
    assert_eq!(sender.answer(), ["ok"]);
    sender.until(|status| status.at[0] > x / 100.0 + 1.0 && status.at[0] < 95.0);
    assert!(rig.lit());
    sender.idle();
    assert_eq!(rig.at(), [0.0, 0.0]);
    // ~ and a hold at once: it stands on, and the light comes back with the next ~.
    sender.ok("G1 X50 F1200");
    sender.until(|status| status.at[0] > 10.0);
    sender.send("!");
    sender.until(|status| status.state == "Hold:0");
    for again in ["~!", "~!~!", "~!!"] {
        sender.send(again);
        assert_eq!((sender.status().state.as_str(), rig.lit()), ("Hold:0", false), "{again}");
    }
    let [from, _] = rig.at();
    sender.send("~");
    sender.until(|status| status.at[0] > from / 100.0 + 2.0 && status.at[0] < 45.0);
    assert!(rig.lit());
    sender.idle();
    sender.ok("G0 X0");
    sender.idle();
    // A hold and ~ at once: it stands once, and goes on.
    sender.ok("G1 X50 F1200");
    sender.until(|status| status.at[0] > 10.0);
    sender.send("!~");
    sender.idle();
    assert_eq!(rig.at(), [5000.0, 0.0]);
    // At standstill too, and a line that comes then waits.
    sender.send("!");
    assert_eq!(sender.status().state, "Hold:0");
    sender.send("G0 X0\n~");
    assert_eq!(sender.answer(), ["ok"]);
    sender.idle();
    assert_eq!(rig.at(), [0.0, 0.0]);
    // The door is a hold of another name; M0 is a hold that the line waits for.
    sender.send([0x84]);
    assert_eq!(sender.status().state, "Door:0");
    sender.send("~");
    assert_eq!(sender.idle().state, "Idle");
    sender.ok("G1 X20");
    sender.send("M0\n");
    sender.until(|status| status.state == "Hold:0");
    assert_eq!((rig.at(), rig.lit()), ([2000.0, 0.0], false));
    sender.send("~");
    assert_eq!(sender.answer(), ["ok"]);
}

/// A door in a jog ends it, and holds what comes after it. In check mode nothing moves that could
/// be held.
#[test]
fn a_door_in_a_jog_holds_what_follows() {
    let rig = Rig::new(MACHINE, false);
    let mut sender = rig.sender();
    sender.banner();
    // In the middle of it, as it is being ended, and with jogs that wait.
    for bytes in [&[0x84][..], &[0x85, 0x84], b"$J=G90 X150 F600\n\x84", b"!\x84"] {
        sender.ok("$J=G90 X200 F1200");
        sender.until(|status| status.state == "Jog" && status.at[0] > 5.0);
        sender.send(bytes);
        if bytes.len() > 2 {
            assert_eq!(sender.answer(), ["ok"]);
        }
        sender.until(|status| status.state == "Door:0");
        let at = rig.at();
        assert!(at[0] < 14_000.0, "{at:?}");
        sender.send("M3 S500 G1 X100 F6000\n");
        for _ in 0..20 {
            assert_eq!((sender.status().state.as_str(), rig.at(), rig.lit()), ("Door:0", at, false), "{bytes:?}");
        }
        sender.send("~");
        assert_eq!(sender.answer(), ["ok"]);
        sender.idle();
        assert_eq!(rig.at(), [10_000.0, 0.0]);
        sender.ok("M5 G0 X0");
        sender.idle();
    }
    sender.ok("$C");
    sender.send("!");
    sender.send([0x84]);
    assert_eq!(sender.status().state, "Check");
    sender.ok("G1 X1 F100");
    // The line that ends it is answered, too.
    assert_eq!(sender.ok("$C"), ["[MSG:Disabled]"]);
    sender.banner();
    rig.end();
}

/// Press and release of a jog key may come in one packet.
#[test]
fn a_jog_that_comes_with_its_end_is_not_run() {
    let rig = Rig::new(MACHINE, false);
    let mut sender = rig.sender();
    sender.banner();
    for end in [&b"\x85"[..], b"!"] {
        sender.send([b"$J=X100 F6000\n", end].concat());
        assert_eq!(sender.answer(), ["ok"]);
        assert_eq!((sender.status().state.as_str(), rig.at()), ("Idle", [0.0, 0.0]));
        // The same while another runs.
        sender.ok("$J=X100 F1200");
        sender.until(|status| status.at[0] > 5.0);
        sender.send([b"$J=X250 F6000\r\n$j = X260F6000\n", end].concat());
        for _ in 0..3 {
            assert_eq!(sender.answer(), ["ok"]);
        }
        sender.idle();
        assert!(rig.at()[0] < 9_900.0);
        sender.ok("G0 X0");
        sender.idle();
    }
    // What comes after the end is run.
    sender.send(b"\x85$J=X3 F6000\n");
    assert_eq!(sender.answer(), ["ok"]);
    sender.idle();
    assert_eq!(rig.at(), [300.0, 0.0]);
    rig.end();
}

#[test]
fn a_reset_in_motion_is_dark_and_knows_where_it_is() {
    let rig = Rig::new(MACHINE, false);
    let mut sender = rig.sender();
    sender.banner();
    sender.ok("G92 X3");
    sender.ok("G10 L2 P1 Y1");
    sender.ok("G1 M4 S500 F6000 X250");
    sender.until(|status| status.at[0] > 50.0);
    assert!(rig.lit());
    sender.send("\x18");
    sender.banner();
    assert!(!rig.lit());
    let status = sender.status();
    let [x, y] = rig.at();
    assert_eq!((status.state.as_str(), y), ("Idle", 0.0));
    assert!(x > 5000.0 && x < 24_000.0 && near(status.at[0], x / 100.0), "{x} {status:?}");
    // It stays there; G92 is gone, G54 is not; the next line ends where it says.
    assert!(near(sender.status().at[0], x / 100.0));
    let listed = sender.ok("$#");
    assert!(listed.contains(&"[G92:0.000,0.000,0.000]".to_owned()), "{listed:?}");
    assert!(listed.contains(&"[G54:0.000,1.000,0.000]".to_owned()), "{listed:?}");
    sender.ok("G1 F6000 X260 Y2");
    sender.idle();
    assert_eq!(rig.at(), [26_000.0, -300.0]);
    assert!(!rig.lit());
    // In a hold too.
    sender.ok("M3 S9 G1 X10");
    sender.until(|status| status.state == "Run" && status.at[0] < 250.0);
    sender.send("!");
    sender.until(|status| status.state == "Hold:0");
    sender.send("\x18");
    sender.banner();
    sender.ok("G0 X0 Y0");
    sender.idle();
    assert_eq!(rig.at(), [0.0, -100.0]);
}

#[test]
fn a_cut_connection_is_an_abort_and_the_next_sender_finds_the_position() {
    let rig = Rig::new(MACHINE, false);
    let mut sender = rig.sender();
    sender.banner();
    let mut other = rig.sender();
    assert_eq!(other.line(), "[MSG:Busy: another sender is connected]");
    sender.ok("G1 M3 S500 F6000 X250");
    sender.send("G1 X0\nX250\nX0\n");
    sender.until(|status| status.at[0] > 50.0);
    assert!(rig.lit());
    drop(sender);
    let mut sender = rig.sender();
    sender.banner();
    assert!(!rig.lit());
    let (status, [x, _]) = (sender.status(), rig.at());
    assert_eq!(status.state, "Idle");
    assert!(x > 5000.0 && x < 24_000.0 && near(status.at[0], x / 100.0), "{x} {status:?}");
    assert_eq!(sender.ok("$G"), ["[GC:G0 G54 G17 G21 G90 G94 M5 M9 T0 F0 S0]"]);
    sender.ok("G0 X0");
    sender.idle();
    assert_eq!(rig.at(), [0.0, 0.0]);
}

#[test]
fn an_alarm_locks_until_it_is_unlocked() {
    let rig = Rig::new(MACHINE, false);
    let mut sender = rig.sender();
    sender.banner();
    sender.ok("G1 M3 S500 F6000 X250");
    sender.until(|status| status.at[0] > 20.0);
    // Outside the travel: nothing of it, nor of what follows.
    sender.send("G1 X301\nG1 X0\n");
    assert_eq!(sender.line(), "ALARM:2");
    assert!(sender.line().starts_with("[MSG:X goes to 301 mm"));
    assert_eq!(sender.answer(), ["error:9"]);
    assert_eq!(sender.answer(), ["[MSG:'$H'|'$X' to unlock]", "error:9"]);
    let status = sender.until(|status| status.state == "Alarm" && status.speeds().0 == 0.0);
    assert!(!rig.lit() && near(status.at[0], rig.at()[0] / 100.0) && rig.at()[0] < 24_000.0);
    assert_eq!(sender.error("$J=X1 F100"), 8);
    sender.ok("$$");
    sender.send("\x18");
    sender.banner();
    assert_eq!(sender.line(), "[MSG:'$H'|'$X' to unlock]");
    assert_eq!(sender.error("G0 X0"), 9);
    assert_eq!(sender.ok("$X"), ["[MSG:Caution: Unlocked]"]);
    sender.ok("G0 X0");
    sender.idle();
    assert_eq!(rig.at(), [0.0, 0.0]);
    // The interlock: ALARM:3, and it stays while it is open.
    sender.ok("G1 M3 S500 F1200 X250");
    sender.until(|status| status.at[0] > 20.0);
    rig.board.lock().unwrap().inputs_mut().interlock = true;
    assert_eq!(sender.line(), "ALARM:3");
    assert!(sender.line().contains("interlock"));
    sender.until(|status| status.state == "Alarm" && status.speeds().0 == 0.0);
    assert!(!rig.lit());
    assert_eq!(sender.error("$X"), 13);
    // Once it is closed, an unlock is no alarm again, however soon a line follows.
    for _ in 0..20 {
        rig.board.lock().unwrap().inputs_mut().interlock = false;
        while sender.ask("$X").last().unwrap() != "ok" {}
        sender.ok("G0 X1");
        rig.board.lock().unwrap().inputs_mut().interlock = true;
        assert_eq!(sender.line(), "ALARM:3");
        assert!(sender.line().contains("interlock"));
    }
    rig.board.lock().unwrap().inputs_mut().interlock = false;
    while sender.ask("$H").last().unwrap() != "ok" {}
    assert_eq!(rig.at(), [0.0, 0.0]);
    sender.ok("G1 M3 S500 F1200 X20");
    sender.until(|status| status.at[0] > 5.0);
    assert!(rig.lit());
    sender.idle();
}

/// A hold in a dwell that is the last thing queued: all entries have left the FIFO, and the path is
/// not over.
#[test]
fn a_hold_in_a_last_dwell_keeps_its_rest() {
    let rig = Rig::new(MACHINE, false);
    let mut sender = rig.sender();
    sender.banner();
    let before = rig.now();
    sender.send("M3 S500 G1 X5 F1200\nG4 P40\n");
    sender.until(|status| status.state == "Run" && status.at[0] == 5.0);
    sender.send("!");
    sender.until(|status| status.state == "Hold:0");
    let part = rig.now() - before;
    // What waits for standstill waits for the dwell.
    sender.send("M2\n");
    let until = rig.now() + Duration::from_secs(5);
    while rig.now() < until {
        assert_eq!((sender.status().state.as_str(), rig.lit()), ("Hold:0", false));
    }
    let again = rig.now();
    sender.send("~");
    assert_eq!(sender.answer(), ["[MSG:Pgm End]", "ok"]);
    let rest = rig.now() - again;
    assert!(part + rest >= Duration::from_secs(40), "{part:?} {rest:?}");
    assert_eq!(sender.idle().state, "Idle");
    // It is not made again.
    sender.ok("G0 X0");
    sender.idle();
    assert_eq!((rig.at(), rig.lit()), ([0.0, 0.0], false));
    rig.end();
}

/// A switch at an axis that stands, or that a hold brakes, is named: the axis has another reason
/// for its last stop.
#[test]
fn an_alarm_names_the_switch_in_every_state() {
    let machine = MACHINE.replacen("acceleration = 1000\n", "acceleration = 1000\nlimits = \"both\"\n", 1);
    let rig = Rig::new(&machine, false);
    let mut sender = rig.sender();
    sender.banner();
    for (state, positive) in [("Idle", true), ("Idle", false), ("Hold:0", true), ("M0", false), ("Hold:0", false)] {
        if state == "Hold:0" {
            sender.ok("G1 X100 F1200");
            sender.until(|status| status.at[0] > 5.0);
            sender.send("!");
        } else if state == "M0" {
            sender.send("M0\n");
        }
        sender.until(|status| state.starts_with(&status.state) || status.state == "Hold:0");
        let active = |level| {
            let mut board = rig.board.lock().unwrap();
            let axis = &mut board.inputs_mut().axes[0];
            if positive { axis.limit_positive = level } else { axis.limit_negative = level }
        };
        active(true);
        assert_eq!(sender.line(), "ALARM:1", "{state}");
        let which = if positive { "positive" } else { "negative" };
        assert_eq!(sender.line(), format!("[MSG:axis 1 stopped: the {which} limit switch]"), "{state}");
        if state == "M0" {
            assert_eq!(sender.answer(), ["error:9"]);
        }
        active(false);
        while sender.ask("$X").last().unwrap() != "ok" {}
        sender.ok("G0 X0");
        sender.ok("G0 X5");
        sender.idle();
    }
    rig.end();
}

/// A limit switch that stays active: the axis moves off it, and no line after the alarm marks.
#[test]
fn an_axis_moves_off_its_limit_switch() {
    let machine = MACHINE.replacen("acceleration = 1000\n", "acceleration = 1000\nlimits = \"both\"\n", 1);
    let rig = Rig::new(&machine, false);
    let mut sender = rig.sender();
    sender.banner();
    for times in 0..3 {
        sender.ok("G90 G1 M3 S500 F1200 X100");
        sender.until(|status| status.at[0] > 20.0);
        rig.board.lock().unwrap().inputs_mut().axes[0].limit_positive = true;
        assert_eq!(sender.line(), "ALARM:1", "{times}");
        assert!(sender.line().contains("the positive limit switch"));
        let at = sender.until(|status| status.state == "Alarm" && status.speeds().0 == 0.0).at[0];
        assert!(!rig.lit());
        assert_eq!(sender.ok("$X"), ["[MSG:Caution: Unlocked]"]);
        sender.ok("$J=G91 X-5 F600");
        let status = sender.idle();
        assert!(near(status.at[0], at - 5.0), "{status:?} {at}");
        // On towards it: an alarm again.
        sender.send("$J=G91 X2 F600\n");
        assert_eq!(sender.answer(), ["ok"]);
        assert_eq!(sender.line(), "ALARM:1", "{times}");
        assert!(sender.line().contains("the positive limit switch"));
        sender.until(|status| status.state == "Alarm" && status.speeds().0 == 0.0);
        assert_eq!(sender.ok("$X"), ["[MSG:Caution: Unlocked]"]);
        // M3 was before the alarm.
        sender.ok("G91 G1 X-3 F600");
        sender.until(|status| {
            assert!(!rig.lit());
            status.state == "Idle"
        });
        rig.board.lock().unwrap().inputs_mut().axes[0].limit_positive = false;
        sender.ok("G90 G0 X0");
        sender.idle();
    }
    rig.end();
}
