//! What the judge of light found, each as small as it gets, named after the rule of SPEC 6 that it
//! breaks.
use client::{Client, Options};
use protocol::command::*;
use std::time::Duration;
use virtual_board::{Board, Config, Shared, VirtualLink, share};

fn open() -> (Client, Shared) {
    let board = share(Board::new(Config::default()));
    let client = Client::open(Box::new(VirtualLink::new(board.clone())), Options::default()).unwrap();
    (client, board)
}

/// A path of coordinate system 1 that is stopped on its way and passes a BufLaserOn while it
/// brakes: whether there is light then.
fn lights_while_braking(client: &Client, board: &Shared) -> bool {
    let core = 1.into();
    for axis in [1i16, 2] {
        client.call(AxisOn { core, axis: axis.into() }).unwrap();
    }
    client.call(SetAxisMode { core, axis: 7.into(), mode: 1.into() }).unwrap();
    client.call(LaserOutFrq { core, frequency: 10.0.into(), channel: 0.into() }).unwrap();
    client.call(LaserPrfCmd { core, power: 50.0.into(), channel: 0.into() }).unwrap();
    let mut profile = [0.into(); 8];
    (profile[0], profile[1]) = (1.into(), 2.into());
    let crd = 1.into();
    client
        .call(SetCrdPrm {
            core,
            crd,
            dimension: 2.into(),
            profile,
            syn_vel_max: 1000.0.into(),
            syn_acc_max: 100.0.into(),
            even_time_ms: 0.into(),
            set_origin_flag: 1.into(),
            origin_pos: [0.into(); 8],
        })
        .unwrap();
    // 10 pulse/ms with 0.1 pulse/ms²: 100 ms to brake.
    client.call(SetCrdStopDec { core, crd, smooth: 0.1.into(), abrupt: 1000.0.into() }).unwrap();
    let line = |x: i32| LnXY {
        core,
        crd,
        x: x.into(),
        y: 0.into(),
        syn_vel: 10.0.into(),
        syn_acc: 10.0.into(),
        vel_end: 10.0.into(),
        fifo: 0.into(),
    };
    client.call(line(500)).unwrap();
    client.call(BufLaserOn { core, crd, fifo: 0.into(), channel: 0.into() }).unwrap();
    client.call(LnXY { vel_end: 0.0.into(), ..line(5000) }).unwrap();
    client.call(CrdStart { core, mask: 1.into(), option: 0.into() }).unwrap();
    // At 400 of 500 it begins to brake.
    client.sleep(Duration::from_millis(40)).unwrap();
    assert!(!board.lock().unwrap().laser(0).switch, "the entry is not reached");
    client.call(CrdStop { core, mask: 1.into(), option: 0.into() }).unwrap();
    client.sleep(Duration::from_millis(40)).unwrap();
    let mut board = board.lock().unwrap();
    assert!(board.crd(0).runs, "it brakes");
    board.laser(0).switch
}

#[test]
fn while_a_crd_brakes_its_entries_act_as_during_motion() {
    let (client, board) = open();
    assert!(lights_while_braking(&client, &board));
}

/// Only an immediate off of this program may veto what it passes: Reset is power-on.
#[test]
fn an_off_before_a_reset_vetoes_nothing_after_it() {
    let (client, board) = open();
    client.call(LaserOff { core: 1.into(), channel: 0.into() }).unwrap();
    client.call(Reset { core: 1.into() }).unwrap();
    assert!(lights_while_braking(&client, &board));
}
