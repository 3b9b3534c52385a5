//! Faults of a laser channel, in both lanes and families: who reports them, and who may clear them;
//! link loss.
use crate::{bench, laser_channel};
use bench::{Bench, MS, entry, sleep};
use laser_channel::*;
use protocol::command::*;
use protocol::reason::{Reason, Refusal, describe_opcode};
use servo::laser::Cause;

/// The interlock is active until it is set back; light was on before.
fn interlocked(family: u8) -> Bench<8> {
    let mut bench = bench(family);
    for channel in 0..2 {
        prepared(&mut bench, family, channel);
    }
    bench.done(switch(1, 0));
    bench.run_ms(1);
    assert!(seen(&mut bench, 0).light);
    bench.machine.interlock = true;
    bench.run_ms(1);
    for channel in 0..2 {
        let now = seen(&mut bench, channel);
        assert!(!now.light && !now.commanded && now.fault == Cause::Interlock && now.cause_lasts, "{now:?}");
    }
    bench
}

/// Events that no command caused, by time, kind, number and reason, since the last call.
fn events(bench: &mut Bench<8>, reported: &mut u32) -> Vec<(u64, u8, u8, u16)> {
    let answer = bench.call(GetEvents {});
    let reply = answer.reply::<GetEvents>();
    let items = answer.items::<GetEvents>();
    assert_eq!((items.len(), items.len() <= 32), (usize::from(reply.count.get()), true));
    let new = reply.total.get() - core::mem::replace(reported, reply.total.get());
    let skip = items.len().saturating_sub(new as usize);
    items.iter().skip(skip).map(|e| (e.time_ns.get(), e.kind, e.of, e.reason.get())).collect()
}

fn on_time_of(bench: &mut Bench<8>) -> u32 {
    seen(bench, 0).on_time
}

#[test]
fn a_fault_is_reported_and_cleared_when_its_cause_is_gone() {
    const CAUSE: &str = "the interlock or emergency-stop input is active";
    for family in [GUS, LSR] {
        let mut bench = interlocked(family);
        assert_eq!((fault(&mut bench, 0), fault(&mut bench, 1)), (1, 1));
        assert_eq!(bench.done(LaserStatus { core: 1.into(), channel: 0.into() }).fault.get(), 1);
        let answer = bench.call(switch(1, 0));
        let text = describe_opcode(opcode::SetHSIOOpt, answer.refusal()).to_string();
        let dark = "laser channel 0 is kept dark by a fault";
        assert_eq!(text, format!("SetHSIOOpt: {dark}: {CAUSE}; once that is over call ClrLaserFault"));
        assert_eq!(answer.code, 1);
        let over = Refusal { high: 0.0.into(), ..answer.refusal() };
        let text = describe_opcode(opcode::SetHSIOOpt, over).to_string();
        let was = "was kept dark by a fault, which was cleared since; give the call again";
        assert_eq!(text, format!("SetHSIOOpt: laser channel 0 {was}"));
        let clear = |channel: i16| ClrLaserFault { core: 1.into(), channel: channel.into() };
        let answer = bench.call(clear(0));
        let text = describe_opcode(opcode::ClrLaserFault, answer.refusal()).to_string();
        let still = "laser channel 0: the cause of its fault is still there";
        assert_eq!((answer.code, text), (1, format!("ClrLaserFault: {still}: {CAUSE}")));
        // Off, settings and reads are taken meanwhile.
        bench.done(switch(0, 0));
        bench.done(power(20.0, 0));
        bench.machine.interlock = false;
        bench.run_ms(1);
        assert_eq!(fault(&mut bench, 0), 1, "it is latched");
        assert_eq!(bench.call(switch(1, 0)).reason(), Reason::LaserFault);
        bench.done(clear(0));
        assert_eq!((fault(&mut bench, 0), fault(&mut bench, 1)), (0, 1), "each channel is cleared by itself");
        bench.run_ms(1);
        assert!(!seen(&mut bench, 0).light, "clearing lights nothing");
        bench.done(switch(1, 0));
        bench.run_ms(1);
        assert!(seen(&mut bench, 0).light);
        assert_eq!(bench.call(switch(1, 1)).reason(), Reason::LaserFault);
    }
}

#[test]
fn clr_sts_and_reset_clear_faults_too() {
    let clr_sts = |axis: i16| ClrSts { core: 1.into(), axis: axis.into(), count: 1.into() };
    let mut bench = interlocked(GUS);
    // Crd 2 drives axes 3 and 4.
    bench.done(SetCrdPrm {
        core: 1.into(),
        crd: 2.into(),
        dimension: 2.into(),
        profile: [0, 0, 1, 2, 0, 0, 0, 0].map(Into::into),
        syn_vel_max: 100.0.into(),
        syn_acc_max: 1.0.into(),
        even_time_ms: 0.into(),
        set_origin_flag: 0.into(),
        origin_pos: [0; 8].map(Into::into),
    });
    bench.done(clr_sts(3));
    assert_eq!(fault(&mut bench, 0), 1, "its cause is there");
    bench.machine.interlock = false;
    bench.run_ms(1);
    // Only of channels whose map holds the crd of the axis.
    bench.done(SetLaserCrdMap { core: 1.into(), channel: 1.into(), map: 1.into() });
    bench.done(clr_sts(1));
    assert_eq!((fault(&mut bench, 0), fault(&mut bench, 1)), (1, 1));
    bench.done(clr_sts(4));
    assert_eq!((fault(&mut bench, 0), fault(&mut bench, 1)), (0, 1));

    let mut bench = interlocked(LSR);
    bench.done(Reset { core: 1.into() });
    assert_eq!(fault(&mut bench, 0), 1, "its cause is there");
    bench.machine.interlock = false;
    bench.run_ms(1);
    bench.done(Reset { core: 1.into() });
    assert_eq!((fault(&mut bench, 0), fault(&mut bench, 1)), (0, 0));
}

#[test]
fn a_program_stops_at_a_faulted_laser_and_may_clear_it_first() {
    for (clears, between) in [(false, 2), (true, 2), (true, 0)] {
        let mut bench = interlocked(GUS);
        bench.machine.interlock = false;
        bench.run_ms(1);
        let first =
            if clears { entry(ClrLaserFault { core: 1.into(), channel: 0.into() }) } else { entry(power(30.0, 0)) };
        let program = [first, entry(sleep(between)), entry(switch(1, 0)), entry(sleep(2)), entry(ProgramEnd {})];
        let tags = bench.post_all(&program);
        bench.done(ProgramStart { strict: 1 });
        let answers: Vec<_> = tags.into_iter().map(|tag| bench.wait(tag)).collect();
        let codes: Vec<i16> = answers.iter().map(|answer| answer.code).collect();
        if clears {
            assert_eq!(codes, [0; 5]);
            assert!(seen(&mut bench, 0).light);
        } else {
            assert_eq!(codes, [0, 0, 1, 1, 1]);
            assert_eq!((answers[2].reason(), answers[3].reason()), (Reason::LaserFault, Reason::Discarded));
        }
    }
}

#[test]
fn a_lost_link_shuts_off_light() {
    for family in [GUS, LSR] {
        let mut bench = bench(family);
        for channel in 0..2 {
            prepared(&mut bench, family, channel);
        }
        bench.done(switch(1, 0));
        bench.run_ms(1);
        bench.cut = true;
        let cut_at = bench.now().0;
        while seen(&mut bench, 0).light {
            bench.step();
            assert!(bench.now().0 < cut_at + 600 * MS, "light without a link");
        }
        let after = bench.now().0 - cut_at;
        assert!((495 * MS..=502 * MS).contains(&after), "{after} ns");
        // Only channels that had light, or might have had it, are kept dark.
        assert_eq!((seen(&mut bench, 0).fault, seen(&mut bench, 1).fault), (Cause::LinkLost, Cause::None));
        assert!(seen(&mut bench, 0).cause_lasts && !seen(&mut bench, 0).commanded);
        bench.cut = false;
        bench.run_ms(20);
        assert_eq!((fault(&mut bench, 0), fault(&mut bench, 1)), (2, 0));
        assert!(!seen(&mut bench, 0).cause_lasts && !seen(&mut bench, 0).light);
        let answer = bench.call(switch(1, 0));
        let text = describe_opcode(opcode::SetHSIOOpt, answer.refusal()).to_string();
        assert!(text.contains("the host link was lost"), "{text}");
        bench.done(ClrLaserFault { core: 1.into(), channel: 0.into() });
        bench.done(switch(1, 0));
        bench.run_ms(1);
        assert!(seen(&mut bench, 0).light);
        // And once more.
        bench.cut = true;
        bench.run_ms(600);
        assert_eq!(seen(&mut bench, 0).fault, Cause::LinkLost);
    }
}

#[test]
fn what_happened_is_reported_with_time_and_reason() {
    let mut bench = bench(LSR);
    let mut reported = 0;
    assert_eq!(events(&mut bench, &mut reported), []);
    // The link is lost while there is light, and comes back.
    prepared(&mut bench, LSR, 0);
    bench.done(switch(1, 0));
    bench.run_ms(1);
    let cut_at = bench.now().0;
    bench.cut = true;
    bench.run_ms(600);
    bench.cut = false;
    bench.run_ms(20);
    let new = events(&mut bench, &mut reported);
    assert_eq!(new.iter().map(|e| (e.1, e.2, e.3)).collect::<Vec<_>>(), [(4, 0, 1), (3, 0, 2), (4, 0, 0)]);
    for (at, kind, ..) in &new[..2] {
        assert!((495 * MS..=503 * MS).contains(&(at - cut_at)), "{kind}: {at}");
    }
    assert!(new[2].0 > cut_at + 600 * MS);
    bench.done(ClrLaserFault { core: 1.into(), channel: 0.into() });
    bench.run_ms(1);
    // A tick that took too long: both channels, although they are dark.
    bench.tick.overrun();
    bench.run_ms(1);
    let new: Vec<_> = events(&mut bench, &mut reported).iter().map(|e| (e.1, e.2, e.3)).collect();
    assert_eq!(new, [(3, 0, 0), (3, 0, 3), (3, 1, 3), (5, 0, 1)]);
    // More events than are kept: the last ones.
    for _ in 0..20 {
        bench.done(ClrLaserFault { core: 1.into(), channel: 0.into() });
        bench.run_ms(1);
        bench.tick.overrun();
        bench.run_ms(1);
    }
    let new = events(&mut bench, &mut reported);
    assert_eq!((reported, new.len()), (7 + 3 * 20, 32));
    assert_eq!((new[31].1, new[31].3), (5, 1));
}

#[test]
fn a_lost_link_shuts_off_what_a_running_program_may_light() {
    let mut bench = bench(LSR);
    prepared(&mut bench, LSR, 0);
    let program = [entry(sleep(2000)), entry(switch(1, 0)), entry(sleep(10)), entry(ProgramEnd {})];
    bench.post_all(&program);
    bench.done(ProgramStart { strict: 1 });
    bench.run_ms(5);
    bench.cut = true;
    bench.run_ms(600);
    assert_eq!([seen(&mut bench, 0).fault, seen(&mut bench, 1).fault], [Cause::LinkLost; 2]);
    bench.run_ms(2000);
    assert!(!seen(&mut bench, 0).light && on_time_of(&mut bench) == 0);
    // Without light and without a program there is nothing to shut off.
    let mut bench = self::bench(LSR);
    prepared(&mut bench, LSR, 0);
    bench.cut = true;
    bench.run_ms(600);
    assert_eq!([seen(&mut bench, 0).fault, seen(&mut bench, 1).fault], [Cause::None; 2]);
}

#[test]
fn the_link_loss_time_is_the_users() {
    let mut bench = bench(LSR);
    prepared(&mut bench, LSR, 0);
    for (ms, dark) in [(100, true), (0, false)] {
        bench.done(SetLinkLoss { time_ms: ms.into(), stop_all: 0.into() });
        bench.done(ClrLaserFault { core: 1.into(), channel: 0.into() });
        bench.done(switch(1, 0));
        bench.run_ms(1);
        bench.cut = true;
        bench.run_ms(if dark { 103 } else { 5000 });
        assert_eq!(seen(&mut bench, 0).light, !dark, "{ms}");
        bench.cut = false;
        bench.run_ms(50);
    }
}

/// What was admitted before its cause came is refused at its tick, and says so.
#[test]
fn a_clear_and_an_on_command_that_meet_the_open_interlock_are_refused() {
    let clear = ClrLaserFault { core: 1.into(), channel: 0.into() };
    for (request, clears) in [(entry(clear), true), (entry(switch(1, 0)), false)] {
        let mut bench = bench(GUS);
        prepared(&mut bench, GUS, 0);
        bench.run_ms(1);
        let tags = bench.post_all(&[entry(sleep(10)), request, entry(ProgramEnd {})]);
        bench.done(ProgramStart { strict: 0 });
        bench.run_ms(5);
        bench.machine.interlock = true;
        let answer = bench.wait(tags[1]);
        assert_eq!((answer.code, answer.reason()), (1, Reason::LaserFault), "a clear: {clears}");
        assert_eq!(fault(&mut bench, 0), 1);
    }
}

/// A Reset is done also while a cause lasts; only the fault stays. In a program it went with what
/// came after it.
#[test]
fn a_reset_is_done_while_a_cause_lasts() {
    let core = 1.into();
    for family in [GUS, LSR] {
        let mut bench = interlocked(family);
        bench.done(Reset { core });
        assert_eq!((fault(&mut bench, 0), fault(&mut bench, 1)), (1, 1));
        let bit = SetDoBit { core, do_type: 12.into(), index: 1.into(), value: 1.into() };
        let tags = bench.post_all(&[entry(Reset { core }), entry(sleep(4)), entry(bit), entry(ProgramEnd {})]);
        bench.done(ProgramStart { strict: 1 });
        assert!(tags.iter().all(|&tag| bench.wait(tag).code == 0));
        assert_eq!(bench.done(ProgramStatus {}).state, 0);
        assert_eq!((fault(&mut bench, 0), fault(&mut bench, 1)), (1, 1));
        bench.machine.interlock = false;
        bench.run_ms(1);
        bench.done(Reset { core });
        assert_eq!((fault(&mut bench, 0), fault(&mut bench, 1)), (0, 0));
        assert!(!seen(&mut bench, 0).light && !seen(&mut bench, 0).commanded);
    }
}
