//! FIFOs of FollowEx that hold entries without duration alone, under a loop.
use assert_cmd::Command;

/// The largest step of axis 2 in a tick, and where it ends, of a slave whose master jogs at 20
/// pulse/ms.
fn run(loops: i32, rest: &str) -> (f64, f64) {
    let job = format!(
        "short rtn; TJogPrm jog={{1,1,0}};
         rtn=GT_Reset(); rtn=GT_AxisOn(1); rtn=GT_AxisOn(2);
         rtn=GT_PrfJog(1); rtn=GT_SetJogPrm(1,&jog); rtn=GT_SetVel(1,20); rtn=GT_Update(1);
         rtn=GT_PrfFollowEx(2,0); rtn=GT_SetFollowMasterEx(2,1);
         rtn=GT_FollowDoBitEx(2,MC_GPO,1,1,0); rtn=GT_SetFollowLoopEx(2,{loops});
         {rest}"
    );
    let folder = tempfile::tempdir().unwrap();
    let trace = folder.path().join("trace.csv");
    let output = Command::cargo_bin("beamtick")
        .unwrap()
        .env_remove("BEAMTICK_IMAGE")
        .args(["sim", "-", "--trace", trace.to_str().unwrap()])
        .write_stdin(job)
        .output()
        .unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = std::fs::read_to_string(&trace).unwrap();
    let mut lines = text.lines();
    let column = lines.next().unwrap().split(',').position(|name| name == "axis2_pos").unwrap();
    let positions: Vec<f64> = lines.map(|line| line.split(',').nth(column).unwrap().parse().unwrap()).collect();
    let steps = positions.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    (steps.fold(0.0, f64::max), *positions.last().unwrap())
}

/// The next segment begins where the master is then. It began where the loop had begun: the slave
/// jumped by all that the master went since.
#[test]
fn a_segment_after_a_loop_of_entries_begins_where_the_master_is() {
    let other = "rtn=GT_FollowDataPercentEx(2,1000,1000,1,0,1);
                 rtn=GT_FollowStartEx(2); Sleep(60); rtn=GT_FollowSwitchEx(2); Sleep(20);";
    let added = "rtn=GT_FollowStartEx(2); Sleep(60); rtn=GT_FollowDataPercentEx(2,1000,1000,1,0,0); Sleep(20);";
    for loops in [0, 1_000_000] {
        for rest in [other, added] {
            let (step, end) = run(loops, rest);
            // 20 pulse/ms in ticks of 250 µs, at the ratio 1: 400 pulses in 20 ms. At its end the
            // job brakes the master at 1 pulse/ms², 200 more.
            assert!(step <= 5.01 && (590.0..610.0).contains(&end), "{loops} {rest}: {step} {end}");
        }
    }
}
