//! A start that the controller refuses at its instant, and the calls that follow it there.
use assert_cmd::Command;

const SETUP: &str = "#pragma continue
short rtn; double pos[2]; TCrdPrm crd = {0};
GT_Reset(); GT_LmtsOff(1, -1); GT_LmtsOff(2, -1); GT_AlarmOff(2); GT_AxisOn(1); GT_AxisOn(2);
crd.dimension = 2; crd.profile[0] = 1; crd.profile[1] = 2; crd.synVelMax = 100; crd.synAccMax = 1;
GT_SetCrdPrm(1, &crd);
";

/// What a job says: for each refused call its name and why, then where the axes are at the end.
fn run(rest: &str) -> (Vec<String>, String) {
    let job = format!("{SETUP}{rest}\nSleep(300); GT_GetPrfPos(1, pos, 2);");
    let output = Command::cargo_bin("beamtick").unwrap().args(["sim", "-"]).write_stdin(job).output().unwrap();
    let said = String::from_utf8(output.stdout).unwrap() + &String::from_utf8(output.stderr).unwrap();
    let refused = said.lines().filter_map(|line| line.split_once("Warning: GT_")).map(|(_, rest)| rest.to_owned());
    let at = said.lines().find_map(|line| line.split_once("pos = ")).unwrap_or_else(|| panic!("{said}"));
    (refused.collect(), at.1.to_owned())
}

#[test]
fn the_remedy_of_a_refused_start_works_at_its_instant() {
    let elsewhere = "CrdStart returned 1: coordinate system 1 is more than a pulse from where FIFO 0 was left";
    let positive = "CrdStart returned 1: axis 1 has come to its positive limit, which is latched";
    let alarm = "returned 1: axis 1 has a drive alarm or its following error is too large, which is latched";
    let servo_off = "returned 1: axis 1: the servo is off; call AxisOn first";
    for (job, refusals, at) in [
        // Renamed within a motion: CrdClear.
        (
            "GT_LnXY(1,1000,0,10,1); GT_CrdStart(1,0); Sleep(30); GT_Stop(0x100,0); WaitStop(0x100); Sleep(2);
             GT_ZeroPos(1,2); Sleep(1);
             rtn=GT_CrdStart(1,0); rtn=GT_CrdClear(1,0); rtn=GT_LnXY(1,100,100,10,1); rtn=GT_CrdStart(1,0);",
            vec![elsewhere],
            "100 100",
        ),
        // Twice refused, and without a remedy.
        (
            "GT_LnXY(1,1000,0,10,1); GT_CrdStart(1,0); Sleep(30); GT_Stop(0x100,0); WaitStop(0x100); Sleep(2);
             GT_ZeroPos(1,2); Sleep(1);
             rtn=GT_CrdStart(1,0); rtn=GT_CrdStart(1,0); Sleep(1); rtn=GT_CrdStart(1,0); rtn=GT_CrdClear(1,0);
             rtn=GT_LnXY(1,7,0,10,1); rtn=GT_CrdStart(1,0);",
            vec![elsewhere, elsewhere, elsewhere],
            "7 0",
        ),
        // At a soft limit: ClrSts.
        (
            "GT_SetSoftLimit(1,1000,-1000); GT_LnXY(1,1000,0,10,1); GT_LnXY(1,1500,0,10,1); GT_LnXY(1,0,0,10,1);
             GT_CrdStart(1,0); Sleep(200);
             rtn=GT_CrdStart(1,0); rtn=GT_ClrSts(1,2); rtn=GT_CrdClear(1,0); rtn=GT_LnXY(1,500,0,10,1);
             rtn=GT_CrdStart(1,0);",
            vec![positive],
            "500 0",
        ),
        // An alarm that is gone: ClrSts and AxisOn. Of a path and of PT.
        (
            "GT_AlarmOn(1); GT_LnXY(1,1000,0,10,1); GT_CrdStart(1,0); Sleep(20);
             GT_SimInput(MC_ALARM,1,1); Sleep(20); GT_SimInput(MC_ALARM,1,0); Sleep(5);
             rtn=GT_CrdStart(1,0); rtn=GT_ClrSts(1,1); rtn=GT_AxisOn(1); rtn=GT_CrdClear(1,0);
             rtn=GT_LnXY(1,1000,0,10,1); rtn=GT_CrdStart(1,0);",
            vec![alarm],
            "1000 0",
        ),
        (
            "GT_PrfPt(1,0); GT_AlarmOn(1); GT_SimInput(MC_ALARM,1,1); Sleep(5); GT_SimInput(MC_ALARM,1,0); Sleep(5);
             GT_PtData(1,50,100,0,0);
             rtn=GT_PtStart(1,0); rtn=GT_ClrSts(1,1); rtn=GT_AxisOn(1); rtn=GT_PtStart(1,0);",
            vec![alarm],
            "50 0",
        ),
    ] {
        let (found, end) = run(job);
        let fit = |(found, wanted): (&String, &&str)| found.contains(wanted) || found.contains(servo_off);
        assert!(found.len() == refusals.len() && found.iter().zip(&refusals).all(fit), "{job}: {found:?}");
        assert_eq!(end, at, "{job}: {found:?}");
    }
}

/// What is refused whatever is in flight before it delays nothing: no call is late.
#[test]
fn calls_after_a_refused_one_act_at_their_instant() {
    for job in [
        // An empty FIFO, which only data could fill.
        "rtn=GT_CrdClear(1,0); rtn=GT_CrdStart(1,0); rtn=GT_SetDoBit(12,1,1);",
        "Sleep(5); rtn=GT_SetCrdPrm(1,&crd); rtn=GT_CrdStart(1,0); rtn=GT_SetDoBit(12,1,1);",
        // A map of a path that runs from this instant on.
        "GT_LnXY(1,100,0,10,1); Sleep(5); rtn=GT_CrdStart(1,0); rtn=GT_SetLaserCrdMap(0,1); rtn=GT_SetDoBit(12,1,1);",
        // A start that is right, and what cannot be beside it.
        "GT_LnXY(1,100,0,10,1); Sleep(5); rtn=GT_CrdStart(1,0); rtn=GT_CrdClear(1,0); rtn=GT_SetDoBit(12,1,1);",
    ] {
        let text = format!("{SETUP}{job}\nSleep(50);");
        let output = Command::cargo_bin("beamtick").unwrap().args(["sim", "-"]).write_stdin(text).output().unwrap();
        let said = String::from_utf8(output.stdout).unwrap() + &String::from_utf8(output.stderr).unwrap();
        assert!(said.contains("Warning: GT_") && said.contains("no late entries"), "{job}: {said}");
    }
}

/// A switch needs a running axis: that is the reason, also where only the tick finds it.
#[test]
fn a_switch_after_a_stop_says_that_the_axis_does_not_run() {
    let (refused, _) = run("TJogPrm jog = {0}; jog.acc = 1; jog.dec = 1; GT_PrfJog(1); GT_SetJogPrm(1, &jog);
         GT_PrfFollowEx(2, 0); GT_SetFollowMasterEx(2, 1, 2, 0); GT_FollowDataPercentEx(2, 100, 100, 0, 0, 0);
         GT_FollowDataPercentEx(2, 100, 100, 0, 0, 1);
         GT_FollowStartEx(2); Sleep(5); GT_Stop(2, 0); Sleep(50); rtn = GT_FollowSwitchNowEx(2, 2);");
    let text = "returned 1: axis 2 is not running, or is being stopped; a switch is for an axis that follows";
    assert_eq!(refused, [format!("FollowSwitchNowEx {text}")]);
    // At the instant of a Stop or an Abort, and while the axis brakes.
    for stop in ["GT_Stop(2, 0);", "GT_Abort();", "GT_Stop(2, 0); Sleep(3);"] {
        for switch in ["FollowSwitchEx(2)", "FollowSwitchNowEx(2, 1)", "FollowSwitchNowEx(2, 2)"] {
            let (refused, _) = run(&format!(
                "TJogPrm jog = {{0}}; jog.acc = 1; jog.dec = 1; GT_PrfJog(1); GT_SetJogPrm(1, &jog); GT_SetVel(1, 5);
                 GT_SetStopDec(2, 0.1, 1); GT_PrfFollowEx(2, 0); GT_SetFollowMasterEx(2, 1, 2, 0);
                 GT_FollowDataPercentEx(2, 1000, 1000, 0, 0, 0); GT_FollowDataPercentEx(2, 2000, 2000, 0, 0, 0);
                 GT_FollowDataPercentEx(2, 100, 100, 0, 0, 1);
                 GT_FollowStartEx(2); GT_Update(1); Sleep(50); {stop} rtn = GT_{switch};"
            ));
            let name = switch.split('(').next().unwrap();
            assert_eq!(refused, [format!("{name} {text}")], "{stop}");
        }
    }
}

/// A table goes in many messages, and each of them is refused. It is one call.
#[test]
fn a_table_that_is_refused_is_one_failure() {
    let numbers = |step: u32| (0..1024).map(|n| (n.max(1) * step).to_string()).collect::<Vec<_>>().join(",");
    let (times, zeros) = (numbers(2), numbers(0));
    let (refused, _) = run(&format!(
        "double t[1024] = {{{times}}}; double p[1024] = {{{zeros}}}; rtn = GT_PvtTable(1, 1024, t, p, p);"
    ));
    assert_eq!(
        refused,
        ["PvtTable returned 7: time is 2; it must be greater than 2, that of the point before (item 2)"]
    );
}
