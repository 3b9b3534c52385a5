//! How fast the virtual controller is against real time: eight axes of static PT, ten minutes at
//! 250 µs.
//!
//! `cargo run --release -p beamtick-virtual --example speed`
use client::{Call, Client, Options, Quiet};
use protocol::command::*;
use std::time::{Duration, Instant};
use virtual_board::{Board, Config, VirtualLink, share};

fn main() -> client::Result<()> {
    let client = Client::open(Box::new(VirtualLink::new(share(Board::new(Config::default())))), Options::default())?;
    let mut calls = Vec::new();
    let items: Vec<ConfigItem> =
        (1..=8i16).map(|axis| ConfigItem { axis: axis.into(), given: 5.into(), ..ConfigItem::default() }).collect();
    calls.push(Call::with_items::<LoadConfig>(LoadConfig { core: 1.into(), count: 8.into() }, &items));
    for axis in 1..=8i16 {
        calls.push(Call::of(AxisOn { core: 1.into(), axis: axis.into() }));
        calls.push(Call::of(PrfPt { core: 1.into(), profile: axis.into(), mode: 0.into() }));
        calls.push(Call::of(SetPtMemory { core: 1.into(), profile: axis.into(), memory: 1.into() }));
        // A second of 20 ms segments, there and back, 600 times.
        let items: Vec<PtItem> = (1..=50)
            .map(|i| {
                let phase = f64::from(i) / 50.0 * std::f64::consts::TAU;
                PtItem { pos: (1000.0 - 1000.0 * phase.cos()).round().into(), time_ms: (i * 20).into(), kind: 0 }
            })
            .collect();
        let many = PtDataMany { core: 1.into(), profile: axis.into(), fifo: 0.into(), count: 50.into() };
        calls.push(Call::with_items::<PtDataMany>(many, &items));
        calls.push(Call::of(SetPtLoop { core: 1.into(), profile: axis.into(), loop_count: 600.into() }));
    }
    calls.push(Call::of(PtStart { core: 1.into(), mask: 0xff.into(), option: 0.into() }));
    calls.push(Call::of(WaitStop { core: 1.into(), axes: 0xff.into(), crds: 0.into() }));
    let (begun, before) = (Instant::now(), client.now());
    let summary = client.run(calls, false, &mut Quiet)?;
    let (real, simulated): (Duration, _) = (begun.elapsed(), client.now() - before);
    println!("failed: {:?}", summary.failed);
    println!(
        "{simulated:.1?} simulated in {real:.3?}: {:.0} times real time",
        simulated.as_secs_f64() / real.as_secs_f64()
    );
    Ok(())
}
