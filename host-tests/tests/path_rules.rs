//! The rules of SPEC 5 and 6 about paths and light on them, worked out by hand, over the link to
//! the virtual controller.
#[path = "path/machine.rs"]
mod machine;
#[path = "path/rules.rs"]
mod rules;

use host_tests::laser_model::{Family, Ns, level_at};
use machine::{Machine, Reported, numbered};
use protocol::command::{
    CrdSpace, CrdStatus, GetCrdPos, GetCrdVel, GetLaserFault, GetPrfMode, GetRemainderSegNum, GetSts,
};
use rules::{END, LIGHT, MOTION, Rule};

const TICK_NS: Ns = 250_000;
/// The script clock at GO.
const GO_NS: Ns = 100_000_000;
/// ms after the last statement.
const TAIL_MS: i64 = 170;

fn text(rule: &Rule) -> String {
    let mut text =
        String::from("TCrdPrm crd;memset(&crd,0,sizeof(crd));GT_LaserPowerMode(2,10,0,0,1);GT_LaserPrfCmd(5);");
    for axis in 1..=4 {
        text += &format!("GT_AxisOn({axis});GT_LmtsOff({axis});");
    }
    text += "crd.dimension=2;crd.profile[0]=1;crd.profile[1]=2;crd.synVelMax=1000;crd.synAccMax=100;crd.setOriginFlag=1;GT_SetCrdPrm(1,&crd);";
    // What a body sleeps before GO is a part of the 100 ms.
    let before: i64 = rule
        .body
        .split("GO")
        .next()
        .unwrap()
        .split("Sleep(")
        .skip(1)
        .map(|rest| rest.split(')').next().unwrap().parse::<i64>().unwrap())
        .sum();
    let wait = 100 - before;
    let go = if rule.body.contains("GO2") { "" } else { "GT_CrdStart(1,0);" };
    let body = rule.body.replace("GO2", "GO").replace("GO", &format!("Sleep({wait});{go}"));
    (text + &body + &format!("Sleep({TAIL_MS});\n")).replace(';', ";\n")
}

/// Compares with what is reported; times of the rule count from here.
fn differs(rule: &Rule, reported: &Reported, zero: Ns) -> Result<(), String> {
    let ns = |ms: f64| if ms == END { Ns::MAX } else { zero + (ms * 1e6).round() as Ns };
    let spans = |what: &str, edges: &[(Ns, bool)], expected: &[(f64, f64)]| {
        let found: Vec<(Ns, Ns)> =
            edges.chunks(2).map(|pair| (pair[0].0, pair.get(1).map_or(Ns::MAX, |edge| edge.0))).collect();
        let near = |a: Ns, b: Ns| a == b || a != Ns::MAX && b != Ns::MAX && (a - b).abs() <= 1;
        let same = found.len() == expected.len()
            && found.iter().zip(expected).all(|(found, (on, off))| {
                // What is on from before is only said to be.
                (*on < 0.0 && found.0 < zero || near(found.0, ns(*on))) && near(found.1, ns(*off))
            });
        let found: Vec<_> =
            found.iter().map(|span| ((span.0 - zero) as f64 / 1e6, (span.1 - zero) as f64 / 1e6)).collect();
        if same { Ok(()) } else { Err(format!("{what}: {found:?} ms, by hand {expected:?}")) }
    };
    spans("light", &reported.lasers[0].switch, rule.light)?;
    let general: Vec<(Ns, bool)> =
        reported.outputs.iter().filter(|edge| edge.1 == 1).map(|edge| (edge.0, edge.2)).collect();
    spans("output", &general, rule.output)?;
    let row = |ms: f64| {
        let at = ns(ms);
        assert_eq!(at % TICK_NS, 0, "{ms} ms is no tick");
        &reported.rows[(at / TICK_NS) as usize]
    };
    for &(ms, axis, place) in rule.places {
        let found = row(ms).axes[axis - 1].pos.0 as f64 / f64::from(1 << 22);
        if (found - place).abs() > 1e-3 {
            return Err(format!("axis {axis} at {ms} ms: {found}, by hand {place}"));
        }
    }
    for &(ms, volts) in rule.power {
        let power = row(ms).lasers[0].power;
        let found = power.m as f64 * 2f64.powi(-i32::from(power.e));
        if (found - volts).abs() > 1e-3 {
            return Err(format!("power at {ms} ms: {found} V, by hand {volts}"));
        }
        let code = f64::from(level_at(&reported.lasers[0].volts, ns(ms), 0)) / 3276.7;
        if (code - volts).abs() > 1e-3 {
            return Err(format!("output at {ms} ms: {code} V, by hand {volts}"));
        }
    }
    Ok(())
}

fn judge(rules: &[Rule]) {
    let machines = [Family::Gus, Family::Lsr].map(|family| Machine::new(family, TICK_NS).traced(0b1111, 0b11));
    let mut failed = Vec::new();
    for rule in rules {
        let machine = machines.iter().find(|machine| machine.family == rule.family).unwrap();
        machine.reset();
        let text = text(rule);
        let outcome = machine.try_run(&text).and_then(|reported| differs(rule, &reported, GO_NS + TICK_NS));
        if let Err(reason) = outcome {
            failed.push(format!("{}: {reason}\n{}", rule.name, numbered(&text)));
        }
    }
    assert!(failed.is_empty(), "{} of {} rules:\n{}", failed.len(), rules.len(), failed.join("\n"));
}

#[test]
fn motion() {
    judge(MOTION);
}

#[test]
fn light() {
    judge(LIGHT);
}

fn machine() -> Machine {
    Machine::new(Family::Gus, TICK_NS).traced(0b11, 0b11)
}

/// 15 ms over 100 pulses; 1 more cannot stop: from √98 pulse/ms, 0.1005… ms later, nothing is left.
#[test]
fn an_underrun_is_dark_and_latched_on_every_mapped_channel() {
    let rule = Rule {
        name: "underrun",
        family: Family::Gus,
        body: "GT_SetAxisMode(8,1);GT_SetHSIOOpt(1,1);GT_BufLaserOn(1);GT_LnXY(1,100,0,10,1,10);GT_LnXY(1,101,0,10,1,10);GO Sleep(20);short c;GT_GetLaserFault(0,&c);GT_GetLaserFault(1,&c);GT_BufLaserOn(1);GT_LnXY(1,200,0,10,2);Sleep(5);GT_CrdStart(1);Sleep(35);GT_ClrLaserFault(0);GT_BufLaserOn(1);GT_LnXY(1,300,0,10,2);Sleep(5);GT_CrdStart(1);Sleep(1);GT_GetLaserFault(0,&c);GT_GetLaserFault(1,&c);",
        light: &[],
        places: &[],
        power: &[],
        output: &[],
    };
    let machine = machine();
    machine.reset();
    let reported = machine.run(&text(&rule));
    let zero = GO_NS + TICK_NS;
    let faults: Vec<i16> = reported.replies::<GetLaserFault>().iter().map(|fault| fault.value.get()).collect();
    assert_eq!(faults, [9, 9, 0, 9]);
    let end = zero as f64 + (15.0 + 10.0 - 98f64.sqrt()) * 1e6;
    let [first, second] = &reported.lasers;
    assert_eq!(first.switch[0], (zero, true));
    for beams in [first, second] {
        let dark = beams.switch[1];
        assert!(!dark.1 && dark.0 as f64 >= end - 1.0 && dark.0 as f64 <= end + TICK_NS as f64, "{dark:?} for {end}");
    }
    // The next path moves in the dark; the one after the clear, from 65 ms on, has light on the
    // cleared channel.
    assert_eq!(first.switch.len(), 4);
    assert_eq!(first.switch[2], (zero + 65_000_000, true));
    assert_eq!(second.switch.len(), 2);
    let place = |ms: i64| reported.rows[((zero + ms * 1_000_000) / TICK_NS) as usize].axes[0].pos.0 >> 22;
    assert_eq!([place(20), place(60), place(100)], [101, 200, 300]);
}

/// Reads of a path: whether it runs, how much of it, where.
#[test]
fn status_is_that_of_the_path() {
    let rule = Rule {
        name: "status",
        family: Family::Gus,
        body: "short r;long n;double p[8];long m;long st;GT_CrdSpace(1,&n);GT_BufDelay(1,1);GT_LnXY(1,500,0,10,2);GT_BufLaserOff(1);GT_LnXY(1,500,500,10,2);GT_CrdSpace(1,&n);GT_CrdStatus(1,&r,&n);GO Sleep(1);GT_CrdStatus(1,&r,&n);GT_GetPrfMode(1,&m);GT_GetSts(1,&st);Sleep(60);GT_CrdStatus(1,&r,&n);GT_GetRemainderSegNum(1,&n);GT_GetCrdPos(1,p);GT_GetCrdVel(1,p);Sleep(60);GT_CrdStatus(1,&r,&n);GT_GetRemainderSegNum(1,&n);GT_GetSts(1,&st);GT_CrdSpace(1,&n);Sleep(5);GT_CrdClear(1,0);GT_CrdStatus(1,&r,&n);",
        light: &[],
        places: &[],
        power: &[],
        output: &[],
    };
    let machine = machine();
    machine.reset();
    let reported = machine.run(&text(&rule));
    let spaces: Vec<i32> = reported.replies::<CrdSpace>().iter().map(|space| space.value.get()).collect();
    assert_eq!(spaces, [1024, 1020, 1024]);
    let states: Vec<(i16, i32)> =
        reported.replies::<CrdStatus>().iter().map(|state| (state.run.get(), state.segment.get())).collect();
    assert_eq!(states, [(0, 0), (1, 0), (1, 1), (0, 2), (0, 0)]);
    let left: Vec<i32> = reported.replies::<GetRemainderSegNum>().iter().map(|left| left.value.get()).collect();
    assert_eq!(left, [1, 0]);
    // 61 ms from the start: 1 of delay, 55 of the first, 5 of the second; what is read at s is that
    // of the next tick.
    let place: Vec<f64> = reported.items::<GetCrdPos>().iter().map(|place| place.value.get()).collect();
    assert_eq!(place[..2], [500.0, 25.0]);
    assert_eq!(reported.replies::<GetCrdVel>()[0].value.get(), 10.0);
    let modes: Vec<i32> = reported.items::<GetPrfMode>().iter().map(|mode| mode.value.get()).collect();
    assert_eq!(modes, [5]);
    let running: Vec<bool> =
        reported.items::<GetSts>().iter().map(|status| status.value.get() >> 10 & 1 == 1).collect();
    assert_eq!(running, [true, false]);
}
