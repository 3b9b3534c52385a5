//! The image in QEMU, where BEAMTICK_IMAGE names one (`cargo xtask check-all` does): its inputs.
use client::qemu::{Machine, QemuLink};
use client::{Client, Options};
use protocol::command::*;
use std::time::{Duration, Instant};

/// Asks until it is so, for at most twenty seconds.
fn wait_until(what: &str, mut is_so: impl FnMut() -> bool) {
    let begin = Instant::now();
    while !is_so() {
        assert!(begin.elapsed() < Duration::from_secs(20), "{what}");
        std::thread::sleep(Duration::from_millis(10));
    }
}

#[test]
fn the_interlock_shuts_off_the_lasers_until_they_are_cleared() {
    let Some(image) = std::env::var_os("BEAMTICK_IMAGE") else {
        println!("skipped: BEAMTICK_IMAGE names no image");
        return;
    };
    let link = QemuLink::start(&Machine::new(image)).unwrap();
    let mut inputs = link.switchboard().unwrap();
    let client = Client::open(Box::new(link), Options::default()).unwrap();
    let (core, channel) = (1.into(), 0.into());
    client.call(SetAxisMode { core, axis: 7.into(), mode: 1.into() }).unwrap();
    client.call(LaserOutFrq { core, frequency: 20.0.into(), channel }).unwrap();
    client.call(LaserPrfCmd { core, power: 50.0.into(), channel }).unwrap();
    client.call(SetHSIOOpt { core, value: 1.into(), channel }).unwrap();
    let fault = || client.call(GetLaserFault { core, channel }).unwrap().value.get();
    let power = || client.call(GetLaserPower { core, channel }).unwrap().value.get();
    wait_until("light", || power() == 50.0);
    assert_eq!(fault(), 0);
    inputs.interlock(true).unwrap();
    wait_until("the interlock is seen", || fault() == 1);
    assert_eq!(power(), 0.0);
    assert_eq!(client.call(ClrLaserFault { core, channel }).unwrap_err().code, 1);
    inputs.interlock(false).unwrap();
    wait_until("it can be cleared", || client.call(ClrLaserFault { core, channel }).is_ok());
    wait_until("no fault", || fault() == 0);
    assert_eq!(power(), 0.0, "light does not come back by itself");
    client.call(SetHSIOOpt { core, value: 1.into(), channel }).unwrap();
    wait_until("light again", || power() == 50.0);
    client.call(SetHSIOOpt { core, value: 0.into(), channel }).unwrap();
}
