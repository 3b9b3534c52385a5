//! Running Follow, over the wire: refusals during motion, FIFOs that the tick empties, and programs
//! that are admitted ahead of their time.
use crate::bench;
use bench::follow::{
    clear, data, event, jog, jogger, loops, master, memory, pair, prf, reported, space_of, spaces, start, switch,
};
use bench::{Bench, entry, position, read_pos, sleep, wait_stop};
use protocol::command::*;
use protocol::reason::Reason;
use protocol::record::Lane;

const CORE: i16 = 1;
const RUNNING: i32 = 0x400;

/// Axis 2 follows the jogging axis 1, one pulse for two, endless: a pass lasts 100 ms.
fn running() -> Bench<8> {
    let mut bench = pair();
    bench.done(data(2, 1000, 500.0, 1, 0));
    bench.done(loops(2, 0));
    bench.done(jog(1));
    bench.done(start(2, 0));
    bench.run_ms(30);
    bench
}

fn status(bench: &mut Bench<8>) -> (i16, i16) {
    let found = bench.done(GetFollowStatus { core: CORE.into(), profile: 2.into() });
    (found.fifo.get(), found.switch_status.get())
}

fn passes(bench: &mut Bench<8>) -> i32 {
    bench.done(GetFollowLoop { core: CORE.into(), profile: 2.into() }).value.get()
}

#[test]
fn what_is_refused_while_it_runs() {
    let mut bench = running();
    assert_eq!(bench.status_word(2) & RUNNING, RUNNING);
    assert_eq!(bench.refused(prf(2, 0)).1, Reason::Moving);
    assert_eq!(bench.refused(master(2, 3, 2, 0)).1, Reason::Moving);
    assert_eq!(bench.refused(memory(2, 1)).1, Reason::Moving);
    assert_eq!(bench.refused(start(2, 0)).1, Reason::Moving);
    assert_eq!(bench.refused(start(6, 0)).1, Reason::Moving, "all of the mask or none");
    assert_eq!(reported(bench.refused(clear(2, 0))), (1, Reason::FifoInUse, 2, 0.0));
    let (code, reason, _) = bench.refused(switch(2));
    assert_eq!((code, reason), (1, Reason::FifoEmpty), "a switch to an empty FIFO");
    // The other FIFO is free; settings take effect from the next start or at once.
    bench.done(data(2, 100, 50.0, 1, 1));
    bench.done(clear(2, 1));
    bench.done(event(2, 2, -1, 12));
    assert_eq!(bench.refused(switch(2)).1, Reason::FifoEmpty, "and one that was emptied");
    assert_eq!(spaces(&mut bench, 2), [15, 16]);
    assert_eq!(status(&mut bench), (0, 0));
    // New data is appended to the running FIFO: the pass is as long as both now.
    bench.done(data(2, 3000, 500.0, 1, 0));
    bench.done(loops(2, 2));
    bench.run_ms(700);
    assert_eq!((bench.pos(2), bench.status_word(2) & RUNNING, passes(&mut bench)), (1000.0, 0, 2));
    // At standstill again; the event that was set meanwhile has effect now, and waiting for it
    // counts as running.
    bench.done(start(2, 0));
    bench.run_ms(20);
    assert_eq!((bench.pos(2), bench.status_word(2) & RUNNING), (1000.0, RUNNING));
    bench.done(Stop { core: CORE.into(), mask: 2.into(), option: 0.into(), form: 0 });
    bench.run_ms(2);
    assert_eq!(bench.status_word(2) & RUNNING, 0);
    bench.done(prf(2, 0));
    assert_eq!(spaces(&mut bench, 2), [14, 16], "the data is kept");
}

#[test]
fn a_fifo_that_was_left_is_found_empty_by_polling() {
    let mut bench = running();
    bench.done(data(2, 500, 1000.0, 1, 1));
    bench.done(switch(2));
    assert_eq!(status(&mut bench), (0, 1));
    assert_eq!(reported(bench.refused(clear(2, 1))), (1, Reason::SwitchPending, 2, 1.0), "it is what comes next");
    assert_eq!(reported(bench.refused(clear(2, 0))), (1, Reason::FifoInUse, 2, 0.0), "it is what runs");
    let mut polls = 0;
    while bench.done(space_of(2, 0)).value.get() != 16 {
        polls += 1;
        assert!(polls < 1000);
    }
    assert!(polls > 10);
    assert_eq!((status(&mut bench), spaces(&mut bench, 2)), ((1, 0), [16, 15]));
    assert!((500.0..600.0).contains(&bench.pos(2)));
    // New data for it is from the beginning.
    bench.done(data(2, 100, 7.0, 1, 0));
    assert_eq!(bench.refused(data(2, 100, 7.0, 1, 0)).1, Reason::MasterOrder);
    bench.done(loops(2, 1));
    bench.done(switch(2));
    bench.run_ms(100);
    assert_eq!((bench.pos(2), bench.status_word(2) & RUNNING), (1507.0, 0));
    assert_eq!(spaces(&mut bench, 2), [15, 16]);
}

#[test]
fn all_axes_of_a_mask_or_none() {
    let mut bench = running();
    jogger(&mut bench, 4, 10.0);
    bench.servo_on(3);
    bench.done(prf(3, 0));
    bench.done(master(3, 4, 2, 0));
    bench.done(data(3, 1000, 500.0, 1, 0));
    bench.done(data(2, 1000, 500.0, 1, 1));
    // Axis 3 does not run: axis 2 does not switch.
    assert_eq!(bench.refused(switch(6)).1, Reason::NotRunning);
    assert_eq!(status(&mut bench), (0, 0));
    bench.done(start(4, 0));
    assert_eq!(bench.refused(switch(6)).1, Reason::FifoEmpty);
    bench.done(data(3, 1000, 500.0, 1, 1));
    bench.done(switch(6));
    assert_eq!(status(&mut bench), (0, 1));
    // If one of two cannot start, neither does.
    bench.done(Stop { core: CORE.into(), mask: 6.into(), option: 6.into(), form: 0 });
    bench.run_ms(1);
    bench.done(AxisOff { core: CORE.into(), axis: 3.into() });
    assert_eq!(bench.refused(start(6, 0)).1, Reason::ServoOff);
    assert_eq!(bench.status_word(2) & RUNNING, 0);
}

/// Runs a program; the answers in order. Nothing may be late.
fn program(bench: &mut Bench<8>, entries: &[(u16, Lane, Vec<u8>)]) -> Vec<bench::Answer> {
    let tags: Vec<u16> = entries.chunks(16).flat_map(|part| bench.post_all(part)).collect();
    bench.done(ProgramStart { strict: 1 });
    tags.iter().map(|&tag| bench.wait(tag)).collect()
}

#[test]
fn a_program_fills_the_fifo_that_a_switch_empties_while_it_runs() {
    for poll_every in [1, 3] {
        let mut bench = pair();
        bench.poll_every = poll_every;
        let entries = [
            entry(data(2, 1000, 500.0, 1, 0)),
            entry(loops(2, 0)),
            entry(jog(1)),
            entry(start(2, 0)),
            // In the second pass; the other FIFO is empty, so its clearing is no reason to wait.
            entry(sleep(130)),
            entry(clear(2, 1)),
            entry(data(2, 1000, 600.0, 3, 1)),
            entry(switch(2)),
            entry(space_of(2, 0)),
            entry(sleep(130)),
            // Only now is it known that FIFO 0 was left.
            entry(space_of(2, 0)),
            entry(data(2, 1000, 700.0, 1, 0)),
            entry(switch(2)),
            entry(loops(2, 1)),
            entry(wait_stop(2)),
            entry(read_pos(2)),
            entry(sleep(1)),
            // At standstill: emptied, filled and started again, ahead of its time.
            entry(clear(2, 0)),
            entry(data(2, 100, 50.0, 1, 0)),
            entry(start(2, 0)),
            entry(wait_stop(2)),
            entry(read_pos(2)),
            entry(ProgramEnd {}),
        ];
        let answers = program(&mut bench, &entries);
        assert!(answers.iter().all(|answer| answer.code == 0), "{answers:?}");
        let space = |index: usize| answers[index].reply::<FollowSpace>().value.get();
        assert_eq!((space(8), space(10)), (15, 16));
        // Two passes of 500, one of 600, one of 700; then 50.
        assert_eq!((position(&answers[15]), position(&answers[21])), (2300.0, 2350.0));
        assert_eq!(bench.done(ProgramStatus {}).late.get(), 0);
    }
}

#[test]
fn an_empty_fifo_is_cleared_and_filled_in_the_instant_of_a_start() {
    let mut bench = pair();
    let entries = [
        entry(data(2, 1000, 500.0, 1, 0)),
        entry(jog(1)),
        entry(start(2, 0)),
        entry(clear(2, 1)),
        entry(data(2, 1000, 600.0, 1, 1)),
        entry(switch(2)),
        entry(wait_stop(2)),
        entry(read_pos(2)),
        entry(ProgramEnd {}),
    ];
    let answers = program(&mut bench, &entries);
    assert!(answers.iter().all(|answer| answer.code == 0), "{answers:?}");
    assert_eq!((position(&answers[7]), bench.done(ProgramStatus {}).late.get()), (1100.0, 0));
}

#[test]
fn what_a_program_may_not_do_fails_at_its_instant() {
    let mut bench = running();
    let before = bench.pos(2);
    let entries = [
        entry(sleep(20)),
        entry(read_pos(2)),
        entry(switch(2)),
        entry(sleep(1)),
        entry(read_pos(2)),
        entry(ProgramEnd {}),
    ];
    let answers = program(&mut bench, &entries);
    assert_eq!(answers[2].reason(), Reason::FifoEmpty);
    assert_eq!(answers[4].reason(), Reason::Discarded);
    assert!((before + 90.0..before + 120.0).contains(&position(&answers[1])), "it was admitted ahead of its time");
    bench.done(ProgramClear {});
    // A start that waits for a crossing that never comes is waited for until a Stop.
    let mut bench = pair();
    let entries = [
        entry(data(2, 1000, 500.0, 1, 0)),
        entry(event(2, 2, -1, -5)),
        entry(jog(1)),
        entry(start(2, 0)),
        entry(wait_stop(2)),
        entry(read_pos(2)),
        entry(ProgramEnd {}),
    ];
    let tags = bench.post_all(&entries);
    bench.done(ProgramStart { strict: 1 });
    bench.run_ms(300);
    assert!(!bench.answers.contains_key(&tags[5]));
    bench.done(Stop { core: CORE.into(), mask: 2.into(), option: 0.into(), form: 0 });
    assert_eq!(bench.wait(tags[5]).reason(), Reason::Discarded);
}

#[test]
fn a_program_that_is_dropped_leaves_fifos_as_they_were_or_empty() {
    let mut bench = pair();
    bench.done(data(2, 1000, 500.0, 1, 0));
    bench.done(data(2, 1000, 100.0, 1, 1));
    let dropped = [
        entry(data(2, 2000, 800.0, 1, 0)),
        entry(clear(2, 1)),
        entry(data(2, 100, 9.0, 1, 1)),
        entry(master(2, 5, 2, 0)),
        entry(event(2, 2, 1, 7)),
    ];
    let tags = bench.post_all(&dropped);
    bench.run_ms(2);
    bench.done(ProgramClear {});
    assert!(tags.iter().all(|tag| bench.answers[tag].reason() == Reason::Discarded));
    assert_eq!(spaces(&mut bench, 2), [15, 16], "FIFO 1 had been overwritten");
    let (core, profile) = (CORE.into(), 2.into());
    assert_eq!(bench.done(GetFollowMaster { core, profile }).master_index.get(), 1);
    assert_eq!(bench.done(GetFollowEvent { core, profile }).event.get(), 1);
    assert_eq!(bench.refused(start(2, 2)).1, Reason::FifoEmpty);
    bench.done(data(2, 2000, 600.0, 1, 0));
    bench.done(jog(1));
    bench.done(start(2, 0));
    bench.run_ms(300);
    assert_eq!(bench.pos(2), 600.0);
}

#[test]
fn reset_and_other_modes_forget_the_data() {
    let mut bench = running();
    bench.done(Reset { core: CORE.into() });
    bench.run_ms(1);
    let mut bench = {
        bench.servo_on(2);
        bench
    };
    assert_eq!(bench.refused(start(2, 0)).1, Reason::WrongMode);
    bench.done(prf(2, 0));
    assert_eq!(spaces(&mut bench, 2), [16, 16]);
    assert_eq!(bench.refused(start(2, 0)).1, Reason::NoMaster);
    // PT and Follow lie in the same places.
    bench.done(data(2, 1000, 500.0, 1, 0));
    bench.done(PrfPt { core: CORE.into(), profile: 2.into(), mode: 0.into() });
    assert_eq!(bench.refused(PtStart { core: CORE.into(), mask: 2.into(), option: 0.into() }).1, Reason::FifoEmpty);
    bench.done(bench::pt_data(2, 10.0, 10));
    bench.done(prf(2, 0));
    bench.done(master(2, 1, 2, 0));
    assert_eq!(bench.refused(start(2, 0)).1, Reason::FifoEmpty);
    assert_eq!(spaces(&mut bench, 2), [16, 16]);
}
