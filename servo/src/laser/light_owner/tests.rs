//! All states of the light owner that two coordinate systems can bring about, and the sentences of
//! SPEC 6 and 9 one by one.
//!
//! The enumeration knows no transition of its own. It walks every fact that a machine can report in
//! a state, from every state that is reached, until nothing is new. Of each step it asks what the
//! SPEC asks of light. So sequences of any length are covered, with every state and every pair of
//! causes among them.
extern crate std;
use super::*;
use std::collections::HashSet;
use std::{println, vec, vec::Vec};

const A: Crd = Crd::FIRST;
const BOTH: CrdMask = CrdMask(3);

fn b() -> Crd {
    Crd::new(1).unwrap()
}

fn run(crd: Crd, fifo: u8) -> PathRun {
    PathRun { crd, fifo }
}

fn on() -> LightEvent {
    LightEvent::Command { on: true }
}

fn off() -> LightEvent {
    LightEvent::Command { on: false }
}

fn mark(crd: Crd) -> LightEvent {
    LightEvent::Entry { on: true, run: run(crd, 0) }
}

fn starts(crd: Crd) -> LightEvent {
    LightEvent::Starts { run: run(crd, 0), resumes: false }
}

fn resumes(crd: Crd) -> LightEvent {
    LightEvent::Starts { run: run(crd, 0), resumes: true }
}

fn stops(crds: u8) -> LightEvent {
    LightEvent::Stops { crds: CrdMask(crds) }
}

fn rests(crd: Crd, end: StandstillCause) -> LightEvent {
    LightEvent::Standstill { run: run(crd, 0), end }
}

const LINK: LightEvent = LightEvent::Latched { link: true };
const FAULT: LightEvent = LightEvent::Latched { link: false };

/// What a machine can report in this state.
fn possible(state: &Owner) -> Vec<LightEvent> {
    let mut facts = vec![
        on(),
        off(),
        LightEvent::FollowEnds,
        LightEvent::Withdraw,
        LightEvent::PowerOn,
        LINK,
        FAULT,
        LightEvent::Cleared,
        LightEvent::Abort { refuses: true },
        LightEvent::Abort { refuses: false },
        LightEvent::AbortOver,
        LightEvent::Output { there: true },
        LightEvent::Output { there: false },
        LightEvent::Relight,
    ];
    facts.extend((1..4).map(stops));
    facts.extend((0..4).map(|map| LightEvent::Map { crds: CrdMask(map) }));
    for crd in [A, b()] {
        for fifo in 0..2 {
            let run = run(crd, fifo);
            if !state.running.has(crd) {
                facts.extend([false, true].map(|resumes| LightEvent::Starts { run, resumes }));
                facts.push(LightEvent::Clears { run });
            } else if state.fifo1.has(crd) == (fifo == 1) {
                facts.extend([false, true].map(|on| LightEvent::Entry { on, run }));
                facts.extend(
                    [StandstillCause::RanOut, StandstillCause::Stopped, StandstillCause::Failed]
                        .map(|end| LightEvent::Standstill { run, end }),
                );
            }
        }
        // A follow begins by an entry, which means nothing where the channel is not mapped.
        if state.running.has(crd) && state.map.has(crd) {
            facts.push(LightEvent::FollowBegins { crd });
        }
    }
    facts
}

/// What the channel does with some facts: where the map excludes the follow's path the follow ends,
/// no output ends light, a path that fails is a cause.
fn with_consequences(state: Owner, fact: LightEvent) -> (Owner, Vec<GateOrder>) {
    let mut next = state;
    let mut orders = vec![next.handle(fact)];
    match fact {
        LightEvent::Map { crds } if next.follow.is_some_and(|crd| !crds.has(crd)) => {
            orders.push(next.handle(LightEvent::FollowEnds))
        }
        LightEvent::Output { there: false } => orders.push(next.handle(LightEvent::Withdraw)),
        LightEvent::Standstill { run, end: StandstillCause::Failed } if state.map.has(run.crd) => {
            orders.push(next.handle(FAULT))
        }
        _ => {}
    }
    (next, orders)
}

/// What the SPEC asks of every state.
fn check_state(state: &Owner) {
    if let Light::On(who) = state.light {
        assert_eq!(state.latch, Latch::None, "light with a cause: {state:?}");
        assert!(state.output && !state.aborting, "light without an output, or in an abort: {state:?}");
        assert!(state.follow.is_none_or(|crd| state.running.has(crd)), "light whose follow is at rest: {state:?}");
        if let LitBy::Path(crd) = who {
            assert!(state.running.has(crd) && state.map.has(crd), "light of a path at rest: {state:?}");
        }
    }
    if let Light::Held(who, by) = state.light {
        assert!(!by.is_empty(), "held by nobody: {state:?}");
        assert_ne!(state.latch, Latch::Other, "light would come back after a fault: {state:?}");
        assert!(by.crds().0 & !state.map.0 == 0, "held by a path that is not mapped: {state:?}");
        if let LitBy::Path(crd) = who {
            assert!(state.owners().has(crd));
        }
    }
    if let Light::Waits(_) = state.light {
        assert!(state.follow.is_some_and(|crd| !state.running.has(crd)), "waits for nothing: {state:?}");
    }
}

/// What the SPEC asks of every step.
fn check_step(before: &Owner, fact: LightEvent, after: &Owner, orders: &[GateOrder]) {
    let why = || std::format!("{before:?}\n{fact:?}\n{after:?}\n{orders:?}");
    let (was, is) = (before.is_lit(), after.is_lit());
    let last = orders.iter().rev().find(|order| !matches!(order, GateOrder::Keep | GateOrder::Ignored(_)));
    // The gate follows the owner, and nothing else.
    match (was, is) {
        (false, true) => assert_eq!(last, Some(&GateOrder::On), "{}", why()),
        (true, false) => assert!(matches!(last, Some(GateOrder::Off | GateOrder::Cut)), "{}", why()),
        (true, true) => assert!(!matches!(last, Some(GateOrder::Off | GateOrder::Cut)), "{}", why()),
        (false, false) => assert_ne!(last, Some(&GateOrder::On), "{}", why()),
    }
    let lights = is && !was;
    let asks = match fact {
        LightEvent::Command { on } => on,
        LightEvent::Entry { on, run } => on && before.map.has(run.crd) && !before.dead.has(run.crd),
        LightEvent::Starts { run, resumes } => match before.light {
            Light::Held(_, by) => resumes && by.has(run) && by.without(run).is_empty(),
            Light::Waits(_) => before.follow == Some(run.crd),
            Light::Off | Light::On(_) => false,
        },
        _ => false,
    };
    assert!(!lights || asks, "light that nobody asked for: {}", why());
    // From nothing only an on command leads to light, now or later.
    if before.light == Light::Off && after.light != Light::Off {
        assert!(matches!(fact, LightEvent::Command { on: true } | LightEvent::Entry { on: true, .. }), "{}", why());
    }
    let dark = match fact {
        LightEvent::Command { on: false } | LightEvent::Withdraw | LightEvent::PowerOn => true,
        LightEvent::Latched { .. } | LightEvent::Abort { .. } => true,
        LightEvent::Output { there } => !there,
        LightEvent::Entry { on: false, run } => before.map.has(run.crd),
        LightEvent::Standstill { run, end: StandstillCause::Stopped | StandstillCause::Failed } => {
            before.map.has(run.crd)
        }
        LightEvent::Standstill { run, end: StandstillCause::RanOut } => {
            before.stopping.has(run.crd) && before.map.has(run.crd)
        }
        LightEvent::Stops { crds } => crds.0 & before.map.0 != 0 && crds.0 & before.map.0 & before.running.0 == 0,
        _ => false,
    };
    assert!(!dark || !is, "it stays lit: {}", why());
    let forgets = matches!(
        fact,
        LightEvent::Abort { .. }
            | LightEvent::Withdraw
            | LightEvent::PowerOn
            | FAULT
            | LightEvent::Command { on: false }
    );
    let cleared = matches!((fact, before.light), (LightEvent::Clears { run }, Light::Held(_, by)) if by.has(run));
    assert!(!forgets && !cleared || after.light == Light::Off, "light could come back: {}", why());
    if let LightEvent::Entry { on: true, run } = fact
        && before.vetoed
        && before.stopping.has(run.crd)
    {
        assert!(!lights, "an immediate off does not hold while the path brakes: {}", why());
    }
    // Ending or replacing a follow never lights, and what waited for it is over.
    if matches!(fact, LightEvent::FollowEnds | LightEvent::FollowBegins { .. })
        && matches!(before.light, Light::Waits(_))
    {
        assert_eq!(after.light, Light::Off, "{}", why());
    }
    // A redundant on command changes nothing.
    if fact == on() && matches!(before.light, Light::On(LitBy::Path(_))) {
        assert_eq!(before.light, after.light, "{}", why());
    }
}

#[test]
fn no_reachable_state_has_light_that_nobody_asked_for() {
    let begin = Owner::power_on(BOTH);
    let mut seen = HashSet::from([begin]);
    let mut left = vec![begin];
    let (mut steps, mut lit, mut held, mut waiting) = (0u64, 0u64, 0u64, 0u64);
    let mut causes = HashSet::new();
    while let Some(state) = left.pop() {
        check_state(&state);
        match state.light {
            Light::On(_) => lit += 1,
            Light::Held(..) => held += 1,
            Light::Waits(_) => waiting += 1,
            Light::Off => {}
        }
        for fact in possible(&state) {
            let (next, orders) = with_consequences(state, fact);
            check_step(&state, fact, &next, &orders);
            causes.insert((state.latch, next.latch, state.light == Light::Off));
            steps += 1;
            if seen.insert(next) {
                left.push(next);
            }
        }
    }
    println!("{} states, {steps} steps: {lit} lit, {held} held, {waiting} waiting", seen.len());
    assert!(lit > 500 && held > 4000 && waiting > 30);
    // Each pair of latches, with light and without it.
    for pair in [Latch::None, Latch::LinkLost, Latch::Other] {
        for next in [Latch::None, Latch::LinkLost, Latch::Other] {
            let reached = causes.iter().any(|(before, after, _)| (*before, *after) == (pair, next));
            // The first cause stays: a lost link after a fault does not let light come back.
            assert_eq!(reached, (pair, next) != (Latch::Other, Latch::LinkLost), "{pair:?} {next:?}");
        }
    }
}

/// Facts one after the other, each with whether there is light after it and whether an on command
/// is in force.
fn story(name: &str, steps: &[(LightEvent, bool, bool)]) {
    let mut owner = Owner::power_on(BOTH);
    for (number, (fact, lit, commanded)) in steps.iter().enumerate() {
        owner.handle(*fact);
        let found = (owner.is_lit(), owner.is_commanded());
        assert_eq!(found, (*lit, *commanded), "{name}, step {number}: {fact:?} gives {owner:?}");
        check_state(&owner);
    }
}

const DARK: (bool, bool) = (false, false);
const LIT: (bool, bool) = (true, true);
const WAITS: (bool, bool) = (false, true);

fn steps<const N: usize>(steps: [(LightEvent, (bool, bool)); N]) -> Vec<(LightEvent, bool, bool)> {
    steps.into_iter().map(|(fact, (lit, commanded))| (fact, lit, commanded)).collect()
}

#[test]
fn a_stop_shuts_off_whoever_lit_it_and_the_start_that_goes_on_brings_it_back() {
    let stopped = |crd| rests(crd, StandstillCause::Stopped);
    story(
        "its own light",
        &steps([(starts(A), DARK), (mark(A), LIT), (stops(1), LIT), (stopped(A), DARK), (resumes(A), LIT)]),
    );
    story(
        "the light of a call",
        &steps([(on(), LIT), (starts(A), LIT), (stops(1), LIT), (stopped(A), DARK), (resumes(A), LIT)]),
    );
    story(
        "the light of another path: both have to go on",
        &steps([
            (starts(A), DARK),
            (starts(b()), DARK),
            (mark(b()), LIT),
            (stops(3), LIT),
            (stopped(A), DARK),
            (stopped(b()), DARK),
            (resumes(b()), DARK),
            (resumes(A), LIT),
        ]),
    );
    story(
        "entries that run out while it brakes: nothing is left to come back",
        &steps([
            (on(), LIT),
            (starts(A), LIT),
            (stops(1), LIT),
            (rests(A, StandstillCause::RanOut), DARK),
            (resumes(A), DARK),
        ]),
    );
    story(
        "after CrdClear it begins anew",
        &steps([(starts(A), DARK), (mark(A), LIT), (stopped(A), DARK), (starts(A), DARK), (stopped(A), DARK)]),
    );
    story(
        "an off command in between",
        &steps([(starts(A), DARK), (mark(A), LIT), (stopped(A), DARK), (off(), DARK), (resumes(A), DARK)]),
    );
    story(
        "an on command in between is the light of a call",
        &steps([
            (starts(A), DARK),
            (mark(A), LIT),
            (stopped(A), DARK),
            (on(), LIT),
            (resumes(A), LIT),
            (rests(A, StandstillCause::RanOut), LIT),
        ]),
    );
}

#[test]
fn a_stop_that_finds_it_at_rest_shuts_off_and_nothing_comes_back() {
    story("at rest", &steps([(on(), LIT), (stops(1), DARK), (starts(A), DARK)]));
    story("another one of the map runs, and stops", &steps([(starts(A), DARK), (mark(A), LIT), (stops(3), LIT)]));
    story("another one of the map runs on", &steps([(starts(A), DARK), (mark(A), LIT), (stops(2), DARK)]));
    story(
        "a second Stop takes what the first one held",
        &steps([
            (starts(A), DARK),
            (mark(A), LIT),
            (rests(A, StandstillCause::Stopped), DARK),
            (stops(1), DARK),
            (resumes(A), DARK),
        ]),
    );
    let other = LightEvent::Map { crds: CrdMask(1) };
    story("a path that is not mapped", &steps([(other, DARK), (on(), LIT), (stops(2), LIT)]));
}

#[test]
fn what_runs_out_takes_its_own_light_and_what_follows_it() {
    let over = |crd| rests(crd, StandstillCause::RanOut);
    let begins = |crd| LightEvent::FollowBegins { crd };
    story("its own", &steps([(starts(A), DARK), (mark(A), LIT), (over(A), DARK)]));
    story("of a call", &steps([(on(), LIT), (starts(A), LIT), (over(A), LIT)]));
    story("of a call that follows it", &steps([(starts(A), DARK), (begins(A), DARK), (on(), LIT), (over(A), DARK)]));
    story(
        "of another path",
        &steps([(starts(A), DARK), (starts(b()), DARK), (mark(b()), LIT), (over(A), LIT), (over(b()), DARK)]),
    );
    let excursion = run(A, 1);
    story(
        "FIFO 1 goes its way in the dark, and FIFO 0 goes on",
        &steps([
            (starts(A), DARK),
            (mark(A), LIT),
            (rests(A, StandstillCause::Stopped), DARK),
            (LightEvent::Starts { run: excursion, resumes: false }, DARK),
            (LightEvent::Standstill { run: excursion, end: StandstillCause::RanOut }, DARK),
            (resumes(A), LIT),
        ]),
    );
}

#[test]
fn under_a_follow_at_rest_an_on_command_waits_for_the_next_start() {
    let begins = |crd| LightEvent::FollowBegins { crd };
    let over = rests(A, StandstillCause::RanOut);
    story("a call", &steps([(starts(A), DARK), (begins(A), DARK), (over, DARK), (on(), WAITS), (starts(A), LIT)]));
    story(
        "the follow ends: it never lights",
        &steps([
            (starts(A), DARK),
            (begins(A), DARK),
            (over, DARK),
            (on(), WAITS),
            (LightEvent::FollowEnds, DARK),
            (starts(A), DARK),
        ]),
    );
    story(
        "another follow replaces it",
        &steps([
            (starts(A), DARK),
            (begins(A), DARK),
            (over, DARK),
            (on(), WAITS),
            (starts(b()), WAITS),
            (begins(b()), DARK),
            (starts(A), DARK),
        ]),
    );
}

#[test]
fn an_immediate_off_holds_while_the_path_brakes() {
    story("before it", &steps([(starts(A), DARK), (off(), DARK), (stops(1), DARK), (mark(A), DARK)]));
    story("during it", &steps([(starts(A), DARK), (stops(1), DARK), (off(), DARK), (mark(A), DARK)]));
    story("and no longer", &steps([(starts(A), DARK), (off(), DARK), (mark(A), LIT)]));
    story(
        "an on command since",
        &steps([(starts(A), DARK), (off(), DARK), (on(), LIT), (stops(1), LIT), (mark(A), LIT)]),
    );
    story(
        "a Reset since",
        &steps([(off(), DARK), (LightEvent::PowerOn, DARK), (starts(A), DARK), (stops(1), DARK), (mark(A), LIT)]),
    );
    story("none was given: a mark has no gap", &steps([(starts(A), DARK), (stops(1), DARK), (mark(A), LIT)]));
}

#[test]
fn causes_aborts_and_sessions_shut_off_for_good() {
    let cleared = LightEvent::Cleared;
    for end in [FAULT, LightEvent::Abort { refuses: false }, LightEvent::Withdraw] {
        let stopped = rests(A, StandstillCause::Stopped);
        story(
            "then it goes on",
            &steps([
                (starts(A), DARK),
                (mark(A), LIT),
                (end, DARK),
                (stopped, DARK),
                (cleared, DARK),
                (resumes(A), DARK),
                (mark(A), LIT),
            ]),
        );
    }
    let abort = LightEvent::Abort { refuses: true };
    story(
        "an abort: entries on the way are dead, on commands are refused",
        &steps([
            (starts(A), DARK),
            (abort, DARK),
            (mark(A), DARK),
            (on(), DARK),
            (rests(A, StandstillCause::Stopped), DARK),
            (on(), DARK),
            (LightEvent::AbortOver, DARK),
            (resumes(A), DARK),
            (mark(A), LIT),
        ]),
    );
    let lost = [(starts(A), DARK), (mark(A), LIT), (LINK, DARK), (rests(A, StandstillCause::Stopped), DARK)];
    let after = |rest: [(LightEvent, (bool, bool)); 2]| [steps(lost), steps(rest)].concat();
    story("a lost link that was cleared", &after([(cleared, DARK), (resumes(A), LIT)]));
    story("a lost link that was not", &after([(resumes(A), DARK), (cleared, DARK)]));
    let inherited = LightEvent::Abort { refuses: false };
    story(
        "a call's light in a new session, while a path of the session before runs",
        &steps([
            (starts(A), DARK),
            (inherited, DARK),
            (on(), LIT),
            (LINK, DARK),
            (rests(A, StandstillCause::Stopped), DARK),
            (cleared, DARK),
            (resumes(A), LIT),
        ]),
    );
    story("a fault after it", &after([(FAULT, DARK), (cleared, DARK)]));
    story(
        "an on entry in the dark is not remembered",
        &steps([
            (starts(A), DARK),
            (LINK, DARK),
            (mark(A), DARK),
            (rests(A, StandstillCause::Stopped), DARK),
            (cleared, DARK),
            (resumes(A), DARK),
        ]),
    );
}

#[test]
fn a_channel_that_is_not_mapped_or_has_no_output_ignores_entries() {
    let mut owner = Owner::power_on(CrdMask(2));
    owner.handle(starts(A));
    assert_eq!(owner.handle(mark(A)), GateOrder::Ignored(Ignored::NotMapped));
    assert!(!owner.heeds(A) && owner.heeds(b()));
    let mut owner = Owner::power_on(BOTH);
    owner.handle(starts(A));
    owner.handle(LightEvent::Output { there: false });
    assert_eq!(owner.handle(mark(A)), GateOrder::Ignored(Ignored::NoOutput));
    assert_eq!(owner.handle(on()), GateOrder::Ignored(Ignored::NoOutput));
    owner.handle(LightEvent::Output { there: true });
    assert!(!owner.is_commanded(), "it was not remembered");
    owner.handle(LightEvent::Abort { refuses: true });
    assert_eq!(owner.handle(on()), GateOrder::Ignored(Ignored::Aborting));
}

#[test]
fn owners_are_those_whose_light_is_on_or_would_come_back() {
    let mut owner = Owner::power_on(BOTH);
    owner.handle(starts(A));
    owner.handle(starts(b()));
    owner.handle(mark(A));
    assert_eq!(owner.owners(), CrdMask(1));
    owner.handle(rests(b(), StandstillCause::Stopped));
    assert_eq!(owner.owners(), BOTH, "that of the first would come back with the second");
    owner.handle(LightEvent::Map { crds: CrdMask(1) });
    assert_eq!((owner.owners(), owner.light), (CrdMask(0), Light::Off), "it is not mapped any more");
}
