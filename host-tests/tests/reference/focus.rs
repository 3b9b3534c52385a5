//! Programs of two narrow kinds: slaves of FollowEx with delays, whose masters are planned again
//! and again; paths with delays, Stops and Aborts, and calls that must know whether they are at
//! rest. The programs of the generator seldom come to either.
//!
//! `REFERENCE_FOCUSED` sets how many there are of each.
use super::found::{MS, ex, gus, path, plain, segment};
use super::judge::{Tally, finding};
use host_tests::reference::chance::Chance;
use host_tests::reference::{Asymmetric, Call, Datum, Fix, Item, Kind, LightCall, LightOf, Path, Speeds, exact, mean};

fn entry(axis: usize, item: Item) -> Call {
    Call::FollowEntry { axis, item, fifo: 0 }
}

/// A slave with delays; a Jog or Trap as its master.
fn delays(c: &mut Chance) -> Vec<Call> {
    let mut calls = vec![plain(Kind::AxisOn, 0), plain(Kind::AxisOn, 1), plain(Kind::AxisOn, 2)];
    let jog = c.below(2) == 0;
    if jog {
        calls.push(plain(Kind::PrfJog, 1));
        calls.push(Call::SetJogPrm { axis: 1, acc: c.log(0.2, 8.0), dec: c.log(0.2, 8.0) });
    } else {
        calls.push(Call::SetTrapPrm { axis: 1, acc: c.log(0.2, 8.0), dec: c.log(0.2, 8.0) });
    }
    let dir = [0, 1, -1, 1][c.below(4) as usize];
    calls.push(ex(Call::PrfFollow { axis: 0, dir }));
    calls.push(ex(Call::SetFollowMaster { axis: 0, master: 1, kind: 2, item: 0 }));
    let mut at = 0.0;
    let sign = if dir < 0 || dir == 0 && c.below(2) == 0 { -1.0 } else { 1.0 };
    for _ in 0..2 + c.below(4) {
        at += (c.log(5.0, 200.0) * 4.0).round() / 4.0;
        let m = if dir < 0 { at } else { at * sign };
        calls.push(segment(
            0,
            m,
            (c.log(2.0, 300.0) * 8.0).round() / 8.0 * c.sign(),
            c.below(4) as i16,
            c.below(101) as i16,
        ));
        if c.below(3) > 0 {
            calls.push(entry(0, Item::Delay { cycles: c.below(60) as u32 }));
        }
    }
    calls.push(ex(Call::SetFollowLoop { axis: 0, loops: c.below(3) as _ }));
    calls.push(ex(Call::FollowStart { mask: 1, option: 0 }));
    let vel = |c: &mut Chance| c.log(2.0, 60.0);
    let mut position = 0.0;
    for _ in 0..2 + c.below(5) {
        if jog {
            let v = vel(c) * if c.below(4) == 0 { -sign } else { sign };
            calls.push(Call::SetVel { axis: 1, vel: v });
        } else {
            calls.push(Call::SetVel { axis: 1, vel: vel(c) });
            position += c.log(10.0, 300.0) * if c.below(4) == 0 { -sign } else { sign };
            calls.push(Call::SetPos { axis: 1, pos: position as i32 });
        }
        calls.push(Call::Update { mask: 2 });
        calls.push(Call::Sleep { ns: c.log(1e6, 2e7) as i64 });
        if c.below(2) == 0 {
            calls.push(Call::Stop { mask: 2, abrupt: 0 });
            if c.below(2) == 0 {
                calls.push(Call::Sleep { ns: c.log(1e5, 1e7) as i64 });
            } else {
                calls.push(Call::WaitStop { mask: 2 });
            }
        }
    }
    calls.push(Call::Sleep { ns: 20 * MS });
    calls
}

/// Of few digits, either sign, 0 at times.
fn ratio(c: &mut Chance) -> f64 {
    if c.below(6) == 0 { 0.0 } else { (c.log(0.05, 3.0) * 64.0).round() / 64.0 * c.sign() }
}

/// A slave with segments of FollowDataPercent2Ex among others; a Jog or Trap as its master.
fn asymmetric(c: &mut Chance) -> Vec<Call> {
    let mut calls = vec![plain(Kind::AxisOn, 0), plain(Kind::AxisOn, 1)];
    let jog = c.below(2) == 0;
    let (acc, dec) = (c.log(0.2, 8.0), c.log(0.2, 8.0));
    if jog {
        calls.extend([plain(Kind::PrfJog, 1), Call::SetJogPrm { axis: 1, acc, dec }]);
    } else {
        calls.push(Call::SetTrapPrm { axis: 1, acc, dec });
    }
    let dir = [0, 1, -1, 0][c.below(4) as usize];
    calls.push(ex(Call::PrfFollow { axis: 0, dir }));
    calls.push(ex(Call::SetFollowMaster { axis: 0, master: 1, kind: 2, item: 0 }));
    let sign = if dir < 0 || dir == 0 && c.below(2) == 0 { -1.0 } else { 1.0 };
    for fifo in 0..1 + c.below(2) as i16 {
        let (mut at, mut slave, mut end) = (0.0, 0.0, 0.0);
        for _ in 0..1 + c.below(6) {
            let length = (c.log(4.0, 300.0) * 8.0).round() / 8.0;
            at += length;
            let master = at * sign;
            if c.below(3) == 0 {
                slave += (c.log(2.0, 200.0) * 8.0).round() / 8.0 * c.sign();
                let datum = Datum { master, slave, kind: c.below(4) as i16, percent: c.below(101) as i16 };
                calls.push(Call::FollowEntry { axis: 0, item: Item::Segment(datum), fifo });
            } else {
                let ratios = [if c.below(3) == 0 { ratio(c) } else { end }, ratio(c)];
                let percent = [0, 1, 20, 60, 99, 100, 101][c.below(7) as usize];
                // Somewhere, at an end, or a little beyond it.
                let part = [c.unit(), c.unit(), c.unit(), 0.0, 1.0, 1.2, 1e-9][c.below(7) as usize];
                let q = exact(f64::from(percent.min(100)) / 100.0);
                let displacement = mean(&exact(ratios[0]), &exact(ratios[1]), &q, &(&q * exact(part)));
                let next = slave + length * Fix::of(&displacement).to_f64();
                let of = Asymmetric { master, slave: next, ratios, percent };
                calls.push(Call::FollowEntry { axis: 0, item: Item::Asymmetric(of), fifo });
                let shares = [f64::from(percent), f64::from(percent) * part];
                calls.push(Call::AsymmetricWay { core: 1, master: length, ratios, shares });
                if part <= 1.0 && percent <= 100 {
                    (slave, end) = (next, ratios[1]);
                } else {
                    at -= length;
                }
            }
            if c.below(5) == 0 {
                calls.push(Call::FollowEntry { axis: 0, item: Item::Delay { cycles: c.below(60) as u32 }, fifo });
            }
        }
        calls.push(ex(Call::FollowSpace { axis: 0, fifo }));
        calls.push(Call::Sleep { ns: 4 * MS });
    }
    calls.push(ex(Call::SetFollowLoop { axis: 0, loops: c.below(3) as _ }));
    calls.push(ex(Call::FollowStart { mask: 1, option: 0 }));
    let mut position = 0.0;
    for _ in 0..2 + c.below(5) {
        let back = if c.below(4) == 0 { -sign } else { sign };
        if jog {
            calls.push(Call::SetVel { axis: 1, vel: c.log(2.0, 60.0) * back });
        } else {
            position += c.log(10.0, 300.0) * back;
            calls.extend([
                Call::SetVel { axis: 1, vel: c.log(2.0, 60.0) },
                Call::SetPos { axis: 1, pos: position as i32 },
            ]);
        }
        calls.extend([Call::Update { mask: 2 }, Call::Sleep { ns: c.log(1e6, 2e7) as i64 }]);
        match c.below(8) {
            0 => calls.push(Call::FollowSwitchNow { axis: 0, table: false }),
            1 => calls.push(Call::FollowSwitchNow { axis: 0, table: true }),
            2 => calls.push(ex(Call::FollowSwitch { mask: 1 })),
            3 => calls.push(Call::Stop { mask: 1, abrupt: 0 }),
            4 => calls.push(plain(Kind::GetPrfVel, 0)),
            _ => {}
        }
        calls.push(Call::Sleep { ns: c.log(1e5, 2e7) as i64 });
    }
    calls.push(Call::Sleep { ns: 20 * MS });
    calls
}

fn light(what: LightOf) -> Call {
    Call::Light(LightCall { channel: 0, what })
}

/// Paths with delays, stops, starts again.
fn paths(c: &mut Chance) -> Vec<Call> {
    let mut calls = vec![plain(Kind::AxisOn, 0), plain(Kind::AxisOn, 1), plain(Kind::AxisOn, 2)];
    calls.push(light(LightOf::Carrier(20.0)));
    calls.push(light(LightOf::Connector(true)));
    calls.push(light(LightOf::Power(40.0)));
    let set =
        Path::Set { crd: 1, axes: vec![0, 1], vel: c.log(2.0, 50.0), acc: c.log(0.5, 20.0), even_ms: 0, origin: None };
    calls.push(path(set));
    let mut to = [0i32; 2];
    for _ in 0..1 + c.below(3) {
        for _ in 0..1 + c.below(4) {
            match c.below(3) {
                0 => calls.push(path(Path::Delay { crd: 1, ms: [0, 0, 1, 3, 7][c.below(5) as usize], fifo: 0 })),
                _ => {
                    let k = c.below(2) as usize;
                    to[k] += (c.log(1.0, 60.0) * c.sign()) as i32;
                    let speeds = Speeds {
                        vel: c.log(1.0, 50.0),
                        acc: c.log(0.5, 20.0),
                        end: if c.below(2) == 0 { 0.0 } else { c.log(0.1, 20.0) },
                    };
                    calls.push(path(Path::Line { crd: 1, to: to.to_vec(), speeds, fifo: 0 }));
                }
            }
        }
        for _ in 0..1 + c.below(3) {
            calls.push(path(Path::Start { mask: 1, option: 0 }));
            calls.push(Call::Sleep { ns: c.log(1e5, 2e7) as i64 });
            match c.below(5) {
                0 => calls.push(Call::Stop { mask: 1, abrupt: 0 }),
                1 => calls.push(Call::Stop { mask: 1, abrupt: 1 }),
                2 => calls.push(Call::Abort { core: 1 }),
                3 => calls.push(path(Path::Stop { mask: 1, option: c.below(2) as i32 })),
                _ => {}
            }
            match c.below(3) {
                0 => calls.push(Call::WaitStop { mask: 3 }),
                1 => calls.push(Call::Sleep { ns: c.log(1e5, 5e6) as i64 }),
                _ => {}
            }
            match c.below(8) {
                0 => calls.push(light(LightOf::Map(1))),
                1 => calls.push(plain(Kind::AxisOn, 2)),
                2 => calls.push(plain(Kind::AxisOn, 0)),
                3 => calls.push(light(LightOf::Gate(true))),
                4 => calls.push(plain(Kind::GetSts, 0)),
                _ => {}
            }
        }
    }
    calls.push(Call::Sleep { ns: 20 * MS });
    calls
}

#[test]
fn focused_programs_agree() {
    let setup = gus();
    let count: u64 = std::env::var("REFERENCE_FOCUSED").ok().and_then(|text| text.parse().ok()).unwrap_or(300);
    let mut tally = Tally::new();
    for kind in [delays, paths, asymmetric] {
        let mut rigs = [const { None }; 3];
        for seed in 0..count {
            let calls = kind(&mut Chance::new(seed + 1));
            let index = (seed % 3) as usize;
            let tick_us = [250, 1000, 100][index];
            if let Some(report) = finding(&mut rigs[index], &setup, tick_us, &calls, &mut tally) {
                panic!("focused program {seed}: {report}");
            }
        }
    }
    let tried = |what: &str| tally.get(what).copied().unwrap_or(0);
    println!("{tally:#?}");
    if count >= 300 {
        let open: u64 = tally.iter().filter(|(what, _)| what.starts_with("cut short")).map(|(_, count)| count).sum();
        assert!(open * 2 < tried("programs"), "{open} were cut short");
        for what in ["ticks in which a slave of FollowEx moves", "paths ended", "aborts of motion"] {
            assert!(tried(what) >= 50, "{what}: {}", tried(what));
        }
    }
}
