//! The analog output of a laser channel is the laser's alone in analog mode: it carries no voltage
//! without light.
use super::machine::Rig;
use host_tests::reference::{Call, Effect, Family, Kind, LightCall, LightOf, Path, PathCall, Setup, Speeds};

const MS: i64 = 1_000_000;

fn light(what: LightOf) -> Call {
    Call::Light(LightCall { channel: 0, what })
}

fn path(what: Path) -> Call {
    Call::Path(PathCall { core: 1, what })
}

fn servo(kind: Kind) -> [Call; 2] {
    [0, 1].map(|axis| Call::Axis { kind, axis })
}

/// What analog output 1 carries from 4 ms on, after calls that all are done.
fn output(calls: &[Call]) -> Vec<i16> {
    let setup = Setup { profile: "gus", family: Family::Gus, axes: vec![(1, 1), (1, 2)] };
    let reported = Rig::new(setup, 250).run(calls).unwrap();
    assert!(reported.answers.iter().all(|answer| answer.code == 0), "{:?}", reported.answers);
    reported.more.iter().skip(16).map(|more| more.analog[0]).collect()
}

fn analog() -> Call {
    light(LightOf::Mode { mode: 2, max: 10.0, min: 0.0, delayed: false })
}

fn set_up() -> Vec<Call> {
    let frame = Path::Set { crd: 1, axes: vec![0, 1], vel: 50.0, acc: 4.9, even_ms: 0, origin: None };
    [&servo(Kind::AxisOn)[..], &[path(frame), Call::Sleep { ns: MS }]].concat()
}

/// An entry of BufDA that had been taken before put its voltage on the laser's output, light or
/// not.
#[test]
fn an_entry_does_not_touch_the_output_of_a_laser() {
    let speeds = Speeds { vel: 9.7, acc: 2.3, end: 0.0 };
    let calls = [
        set_up(),
        vec![
            path(Path::Analog { crd: 1, dac: 1, value: 20_000, fifo: 0 }),
            path(Path::Line { crd: 1, to: vec![30, 20], speeds, fifo: 0 }),
            analog(),
            Call::Sleep { ns: MS },
            path(Path::Start { mask: 1, option: 0 }),
            Call::Sleep { ns: 12 * MS },
        ],
    ];
    let output = output(&calls.concat());
    assert!(output.iter().all(|code| *code == 0), "{output:?}");
}

/// What SetDac had set stayed on the output of a channel that a fault keeps dark.
#[test]
fn a_dark_channel_takes_its_output_to_0() {
    let calls = [
        set_up(),
        vec![Call::Effect(Effect::SetDac { core: 1, dac: 1, value: 20_000 })],
        servo(Kind::AxisOff).to_vec(),
        vec![Call::Sleep { ns: 2 * MS }, analog(), Call::Sleep { ns: 12 * MS }],
    ];
    let output = output(&calls.concat());
    assert!(output.iter().all(|code| *code == 0), "{output:?}");
}
