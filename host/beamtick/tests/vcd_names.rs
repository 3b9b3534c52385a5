//! Steps in a VCD are those of the machine: a position that gets another name makes none.
use assert_cmd::Command;

/// The steps of axis 1 up and down, as a VCD of the job shows them.
fn steps(rest: &str, tick_us: &str) -> (usize, usize) {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("out.vcd");
    let job = format!(
        "TTrapPrm trap; trap.acc = 1; trap.dec = 1; trap.velStart = 0; trap.smoothTime = 0;
         GT_Reset(); GT_LmtsOff(1, -1); GT_AlarmOff(1); GT_AxisOn(1);
         GT_PrfTrap(1); GT_SetTrapPrm(1, &trap); GT_SetVel(1, 5); GT_SetPos(1, 20); GT_Update(1); WaitStop(1); Sleep(5);
         {rest}
         Sleep(3);"
    );
    let output = Command::cargo_bin("beamtick")
        .unwrap()
        .args(["sim", "-", "--tick-us", tick_us, "--vcd"])
        .arg(&file)
        .write_stdin(job)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = std::fs::read_to_string(&file).unwrap();
    let id = |name: &str| {
        let line = text.lines().find(|line| line.contains(&format!(" {name} "))).unwrap();
        line.split_whitespace().nth(3).unwrap().to_owned()
    };
    let (step, dir) = (id("axis1_step"), id("axis1_dir"));
    let (mut down, mut counts) = (false, (0, 0));
    for line in text.lines() {
        match line.split_at_checked(1) {
            Some((level, of)) if of == dir && "01".contains(level) => down = level == "1",
            Some(("1", of)) if of == step => *(if down { &mut counts.1 } else { &mut counts.0 }) += 1,
            _ => {}
        }
    }
    counts
}

#[test]
fn a_name_makes_no_step() {
    let again = |to: i32| format!("Sleep(1); GT_SetPos(1, {to}); GT_Update(1); WaitStop(1);");
    for (names, counts) in [
        (format!("GT_SetPrfPos(1, 1000); {}", again(1010)), (30, 0)),
        (format!("GT_SetPrfPos(1, 7); {}", again(0)), (20, 7)),
        (format!("GT_ZeroPos(1, 1); {}", again(-5)), (20, 5)),
        // The planned position is neither that of the encoder nor what it was before.
        (format!("GT_SetPrfPos(1, 7); GT_SetEncPos(1, 300); GT_SynchAxisPos(1); {}", again(17)), (30, 0)),
        // The clock of the other two stands between: both names lie before one row.
        (format!("GT_SetPrfPos(1, 1000); GT_SetPrfPos(1, -3); {}", again(1)), (24, 0)),
        ("GT_Reset();".to_owned(), (20, 0)),
    ] {
        for tick_us in ["250", "50"] {
            assert_eq!(steps(&names, tick_us), counts, "{names} {tick_us}");
        }
    }
}
