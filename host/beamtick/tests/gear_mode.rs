//! The mode Gear in jobs: what is reported, traced and refused.
use assert_cmd::Command;

fn sim(job: &str, arguments: &[&str]) -> (String, bool) {
    let output = Command::cargo_bin("beamtick")
        .unwrap()
        .env_remove("BEAMTICK_IMAGE")
        .args([&["sim", "-"], arguments].concat())
        .write_stdin(job)
        .output()
        .unwrap();
    let text = String::from_utf8(output.stdout).unwrap() + &String::from_utf8(output.stderr).unwrap();
    (text, output.status.success())
}

const JOB: &str = "short rtn; short reason; long mode; double pos[2]; TJogPrm jog={1,1,0};
rtn=GT_AxisOn(1); rtn=GT_AxisOn(2);
rtn=GT_PrfJog(1); rtn=GT_SetJogPrm(1,&jog); rtn=GT_SetVel(1,100); rtn=GT_Update(1);
rtn=GT_PrfGear(2); rtn=GT_SetGearMaster(2,1,GEAR_MASTER_PROFILE); rtn=GT_SetGearRatio(2,2,1,100000);
rtn=GT_GearStart(2); rtn=GT_GetPrfMode(2,&mode); Sleep(3000);
rtn=GT_Stop(1,0); Sleep(200); rtn=GT_ZeroPos(1); rtn=GT_GetPrfPos(1,pos,2);
rtn=GT_SetVel(1,-100); rtn=GT_Update(1); Sleep(1000);
rtn=GT_SetGearRatio(2,1,2); rtn=GT_GearStart(2); Sleep(1000);
rtn=GT_GetPrfPos(1,pos,2);
rtn=GT_SetSoftLimit(2,2147483647,-250000); Sleep(3000);
rtn=GT_GetPrfPos(1,pos,2); rtn=GT_GetStopReason(2,&reason);
rtn=GT_Stop(3,0); WaitStop(3);
";

/// In every tick of the trace the slave is where the closed form says, to the trace's 6 decimals.
#[test]
fn a_job_goes_in_gear() {
    let folder = tempfile::tempdir().unwrap();
    let trace = folder.path().join("t.csv");
    for tick in ["250", "1000"] {
        let (said, ok) = sim(JOB, &["--trace", trace.to_str().unwrap(), "--tick-us", tick, "--strict"]);
        assert!(ok && said.contains("mode = 3"), "{said}");
        assert!(said.contains("pos = 0 125000") && said.contains("pos = -195000 -122500"), "{said}");
        assert!(said.contains("-250000") && said.contains("reason = 7 (the negative soft limit)"), "{said}");
        let text = std::fs::read_to_string(&trace).unwrap();
        let mut lines = text.lines();
        let names: Vec<&str> = lines.next().unwrap().split(',').collect();
        assert_eq!(names, ["t_ms", "axis1_pos", "axis1_vel", "axis2_pos", "axis2_vel"]);
        let (mut slope, mut whole, mut renamed) = (0, 0, 0.0);
        let mut before = 0.0;
        for line in lines {
            let row: Vec<f64> = line.split(',').map(|field| field.parse().unwrap()).collect();
            let [t, master, _, slave, _] = row[..] else { panic!("{line}") };
            if t > 4200.0 {
                break;
            }
            if (master - before).abs() > 1000.0 {
                renamed += before - master;
            }
            before = master;
            // Over 100,000 pulses to a half, then a half of what follows.
            let way = master + renamed;
            let wanted = if whole == 0 && way < 100_000.0 {
                slope += 1;
                way * way / 400_000.0
            } else {
                whole += 1;
                25_000.0 + (way - 100_000.0) / 2.0
            };
            assert!((slave - wanted).abs() < 2e-5, "{line}: {wanted}");
        }
        assert!(slope > 1000 && whole > 1000, "{slope} {whole}");
    }
}

#[test]
fn a_wait_for_a_slave_in_gear_would_not_end() {
    let job = "short rtn; rtn=GT_AxisOn(2); rtn=GT_PrfGear(2); rtn=GT_SetGearMaster(2,1); rtn=GT_SetGearRatio(2,1,1);
rtn=GT_GearStart(2); while(!kbhit()) {}
";
    let (said, ok) = sim(job, &[]);
    assert!(!ok && said.contains("runs for ever"), "{said}");
    let (said, ok) = sim("short rtn; rtn=GT_PrfGear(2); rtn=GT_SetGearRatio(2,0,1);", &[]);
    assert!(!ok && said.contains("GT_SetGearRatio returned 7: master_even is 0"), "{said}");
}
