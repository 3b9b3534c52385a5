//! Axes geared to a motion (BufGear) that cannot go along: the path stops before the motion.
use assert_cmd::Command;

/// Three axes, the first two in coordinate system 1, and what `rest` does with them.
fn run(rest: &str, arguments: &[&str]) -> String {
    let job = format!(
        "short rtn; short reason; double pos[4]; TCrdPrm crd={{0}};
         rtn=GT_Reset(); rtn=GT_AxisOn(1); rtn=GT_AxisOn(2); rtn=GT_AxisOn(3);
         crd.dimension=2; crd.profile[0]=1; crd.profile[1]=2; crd.synVelMax=2000; crd.synAccMax=4;
         rtn=GT_SetCrdPrm(1,&crd);
         {rest}
         rtn=GT_GetPrfPos(1,pos,3); rtn=GT_GetCrdStopReason(1,&reason);"
    );
    let output = Command::cargo_bin("beamtick")
        .unwrap()
        .env_remove("BEAMTICK_IMAGE")
        .args([&["sim", "-"], arguments].concat())
        .write_stdin(job)
        .output()
        .unwrap();
    String::from_utf8(output.stdout).unwrap() + &String::from_utf8(output.stderr).unwrap()
}

/// The positions that the job has read.
fn positions(said: &str) -> [f64; 3] {
    let line = said.lines().find(|line| line.contains("GetPrfPos")).unwrap_or_else(|| panic!("{said}"));
    let (_, values) = line.split_once("pos = ").unwrap();
    let values: Vec<f64> = values.split_whitespace().map(|value| value.parse().unwrap()).collect();
    values.try_into().unwrap_or_else(|_| panic!("{said}"))
}

/// FIFO 1 has moved the path to where the motion of FIFO 0 ends: nothing is left of it to gear to.
/// The geared axis went its whole way in one tick, and beyond a soft limit.
#[test]
fn a_motion_without_length_moves_no_geared_axis() {
    let twice = "rtn=GT_LnXY(1,200,0,20,2); rtn=GT_LnXY(1,200,0,20,2,0,1);
                 rtn=GT_CrdStart(1,1); WaitStop(1,0,1); rtn=GT_CrdStart(1,0); WaitStop(1,0,1);";
    for (pulses, limit) in [(1_000_000, ""), (5000, "rtn=GT_SetSoftLimit(3,50,-50);"), (-1, "")] {
        let said = run(&format!("{limit} rtn=GT_BufGear(1,3,{pulses}); {twice}"), &[]);
        assert_eq!(positions(&said), [200.0, 0.0, 0.0], "{said}");
        assert!(said.contains("reason = 17"), "{said}");
    }
    let said = run(&format!("rtn=GT_BufGear(1,3,0); {twice}"), &[]);
    assert!(said.contains("reason = 1") && !said.contains("reason = 17"), "{said}");
}

/// The motion is shorter than it was when its gear was checked: the axis would be faster than the
/// board's step output.
#[test]
fn a_geared_axis_keeps_the_step_limit() {
    let twice = "rtn=GT_BufGear(1,3,4000); rtn=GT_LnXY(1,200,0,20,2); rtn=GT_LnXY(1,199,0,20,2,0,1);
                 rtn=GT_CrdStart(1,1); WaitStop(1,0,1); rtn=GT_CrdStart(1,0); WaitStop(1,0,1);";
    let said = run(twice, &["--step-limit", "1000"]);
    // Two ticks of 250 µs at 1000 pulse/ms, and none at more.
    let [_, _, geared] = positions(&said);
    assert!(geared <= 500.0 && said.contains("reason = 17"), "{said}");
    // On a board without that limit it goes.
    let said = run(twice, &[]);
    assert_eq!(positions(&said), [200.0, 0.0, 4000.0], "{said}");
}

/// The axis is switched off before its motion: the path stops at the end of the motion before, and
/// goes on from there with the whole gear.
#[test]
fn a_path_stops_before_a_motion_whose_geared_axis_is_off() {
    let job = "rtn=GT_LnXY(1,1001,0,20,2,20); rtn=GT_BufGear(1,3,100000); rtn=GT_LnXY(1,2000,0,20,2);
               rtn=GT_AxisOff(3); rtn=GT_CrdStart(1,0); WaitStop(1,0,1);";
    let said = run(job, &[]);
    assert_eq!(positions(&said), [1001.0, 0.0, 0.0], "{said}");
    assert!(said.contains("reason = 17"), "{said}");
    let again = "rtn=GT_AxisOn(3); rtn=GT_ClrSts(1,3); rtn=GT_CrdStart(1,0); WaitStop(1,0,1);";
    let said = run(&format!("{job} {again}"), &[]);
    assert_eq!(positions(&said), [2000.0, 0.0, 100_000.0], "{said}");
}
