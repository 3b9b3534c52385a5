//! Before each `error:N` a message says why.
mod common;

use common::{MACHINE, Rig, Sender};

/// A line that is refused: its reason and number.
fn refused(sender: &mut Sender, line: &str) -> (String, String) {
    let mut answer = sender.ask(line);
    let number = answer.pop().unwrap();
    assert_eq!(answer.len(), 1, "{line}: one message, then {number}: {answer:?}");
    let reason = answer[0].strip_prefix("[MSG:").and_then(|text| text.strip_suffix(']'));
    (reason.unwrap_or_else(|| panic!("{line}: {answer:?}")).to_owned(), number)
}

fn all(sender: &mut Sender, rows: &[(&str, &str, &str)]) {
    for (line, says, number) in rows {
        assert_eq!(refused(sender, line), ((*says).to_owned(), (*number).to_owned()), "{line}");
    }
}

#[test]
fn what_is_no_command_and_no_setting_is_named() {
    let rig = Rig::new(MACHINE, false);
    let mut sender = rig.sender();
    sender.banner();
    let long = "X".repeat(256);
    all(
        &mut sender,
        &[
            ("$foo", "$FOO is no command; $ lists them", "error:3"),
            ("$H=1", "$H=1 is no command; $ lists them", "error:3"),
            ("$N2=G21", "$N2: there are $N0 and $N1", "error:3"),
            ("$RST=x", "$RST= takes $, # or *", "error:3"),
            ("$999=1", "there is no setting $999; $$ lists them", "error:3"),
            ("$99999=1", "there is no setting $99999; $$ lists them", "error:3"),
            ("$10=9", "$10 is 0 to 3: 1 shows MPos, else WPos, and 2 more show Bf", "error:3"),
            ("$10=abc", "$10 is 0 to 3: 1 shows MPos, else WPos, and 2 more show Bf", "error:3"),
            ("$10=1.5", "$10 is 0 to 3: 1 shows MPos, else WPos, and 2 more show Bf", "error:3"),
            ("$13=2", "$13 is 0 (reports in mm) or 1 (in inches)", "error:3"),
            ("$100=80", "$100 is 100.000 here; only the machine file changes the machine", "error:3"),
            ("$100=x", "$100 is 100.000 here; only the machine file changes the machine", "error:3"),
            ("Y1O", "`Y1O`: O words are not supported", "error:20"),
            ("T-1", "a tool number is 0 or above", "error:4"),
            ("N-1 G21", "a line number is 0 or above", "error:4"),
            ("G1.5 X1 F100", "G1.5 is not supported: G1 has no decimals", "error:23"),
            ("M3.1", "M3.1 is not supported: M3 has no decimals", "error:23"),
            ("G91.2", "G91.2 is not supported", "error:20"),
            ("G38.2 Z1", "G38.2 is not supported", "error:20"),
            ("G2 R1 F100", "an arc by R needs axis words", "error:26"),
            ("G17 G2 X1 R1 Y", "`Y`: a letter must have a number", "error:2"),
            (&long, "a line has at most 255 characters", "error:11"),
        ],
    );
    for line in ["$100=100", "$10=1", "$13=1", "$13=0", "$10=3"] {
        sender.ok(line);
    }
}

#[test]
fn what_a_state_refuses_says_which_state() {
    let rig = Rig::new(MACHINE, false);
    let mut sender = rig.sender();
    sender.banner();
    sender.ok("$C");
    all(
        &mut sender,
        &[
            ("$H", "not in check mode, which $C ends", "error:8"),
            ("$J=X1 F100", "not in check mode, which $C ends", "error:8"),
        ],
    );
    sender.send("$C\n");
    sender.banner();
    sender.ok("G1 X200 F3000");
    sender.until(|status| status.state == "Run");
    for line in ["$$", "$H", "$C", "$J=X1 F100"] {
        all(&mut sender, &[(line, "not before everything stands", "error:8")]);
    }
    sender.send("\x18");
    sender.banner();
    sender.ok("$J=X200 F3000");
    sender.until(|status| status.state == "Jog");
    all(&mut sender, &[("G0 X0", "a jog runs; 0x85 ends it (in the monitor the space bar)", "error:9")]);
    sender.send([0x85]);
    sender.idle();
    sender.send("G0 X301\n");
    assert_eq!(sender.line(), "ALARM:2");
    sender.answer();
    all(
        &mut sender,
        &[
            ("G0 X0", "'$H'|'$X' to unlock", "error:9"),
            ("$C", "'$H'|'$X' to unlock", "error:8"),
            ("$J=X1 F100", "'$H'|'$X' to unlock", "error:8"),
        ],
    );
    sender.until(|status| status.speeds().0 == 0.0);
    sender.ok("$X");
}
