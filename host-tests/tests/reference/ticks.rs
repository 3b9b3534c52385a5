//! A tick period that changes between programs: motion, answers, outputs and light are the same
//! functions of time before and after it.
use super::judge::{Tally, finding};
use host_tests::reference::{Call, Effect, Family, Kind, LightCall, LightOf, Setup};

const MS: i64 = 1_000_000;

fn plain(kind: Kind, axis: usize) -> Call {
    Call::Axis { kind, axis }
}

fn light(what: LightOf) -> Call {
    Call::Light(LightCall { channel: 0, what })
}

/// A move, a slave of the filtered encoder, light, an output: 24 ms.
fn piece(to: i32) -> Vec<Call> {
    vec![
        Call::Sleep { ns: MS },
        Call::SetPos { axis: 0, pos: to },
        Call::Update { mask: 1 },
        Call::Sleep { ns: MS },
        Call::Effect(Effect::SetDoBit { core: 1, index: 3, level: to > 0 }),
        light(LightOf::Gate(to > 0)),
        Call::Sleep { ns: 7 * MS - 1234 },
        plain(Kind::GetPrfVel, 0),
        plain(Kind::GetEncPos, 0),
        Call::Sleep { ns: 9 * MS },
        Call::Effect(Effect::SetDoBit { core: 1, index: 3, level: to < 0 }),
        Call::WaitStop { mask: 1 },
        Call::Sleep { ns: 5 * MS },
        light(LightOf::GetOnTime),
        plain(Kind::GetPrfPos, 0),
    ]
}

#[test]
fn programs_before_and_after_another_tick_period_agree() {
    let setup = Setup { profile: "gus", family: Family::Gus, axes: vec![(1, 1), (1, 2)] };
    for order in [[250, 1000, 100], [1000, 100, 125], [100, 500, 50]] {
        let [first, second, third] = order;
        let mut calls = vec![plain(Kind::AxisOn, 0), plain(Kind::AxisOn, 1)];
        calls.push(Call::SetTrapPrm { axis: 0, acc: 1.7, dec: 2.3 });
        calls.push(Call::SetVel { axis: 0, vel: 11.3 });
        calls.push(light(LightOf::Carrier(20.0)));
        calls.push(light(LightOf::Connector(true)));
        calls.push(light(LightOf::Delays { off: 7, on: 12 }));
        calls.push(light(LightOf::Power(40.0)));
        calls.push(Call::PrfFollow { axis: 1, dir: 0 });
        calls.push(Call::SetFollowMaster { axis: 1, master: 0, kind: 3, item: 3 });
        let datum = host_tests::reference::Datum { master: 5000.0, slave: 7100.0, kind: 1, percent: 0 };
        calls.push(Call::FollowData { axis: 1, datum, fifo: 0 });
        for (us, to) in [(second, 90), (third, -70), (first, 40)] {
            calls.push(Call::FollowStart { mask: 2, option: 0 });
            calls.extend(piece(to));
            // Refused: the slave waits for its master.
            calls.push(Call::SetTick { us });
            calls.extend(piece(to / 2));
            calls.push(Call::Stop { mask: 2, abrupt: 2 });
            calls.push(Call::Sleep { ns: 4 * MS });
            calls.push(Call::SetTick { us });
        }
        calls.extend(piece(110));
        let mut tally = Tally::new();
        if let Some(report) = finding(&mut None, &setup, first as u32, &calls, &mut tally) {
            panic!("{report}");
        }
        let open: Vec<&String> = tally.keys().filter(|what| what.starts_with("cut short")).collect();
        assert!(open.is_empty(), "{open:?}");
        for (what, count) in [("tick periods set between programs", 3), ("tick periods refused in motion", 3)] {
            assert_eq!(tally.get(what), Some(&count), "{what}");
        }
    }
}
