//! Lengths at and beyond every limit, made of the tables of the API, through every door.

use crate::player::{self, Programme};
use crate::program::{Call, Step, read};
use crate::{Table, calls, compare, random};
use gts::prototype::command;
use job::api::{FUNCTIONS, Pass, counts};
use protocol::command::widths;
use protocol::record::{BODY_MAX, ITEM_BYTES};
use std::sync::Mutex;

/// Lengths of an array: none, one, what the function takes at least and at most, what a message
/// carries of it in its requests or its replies, each with its neighbours, and twice a message.
fn of(call: &Call) -> Vec<usize> {
    let table = command(call.function).expect("a request");
    let (low, high) = counts(call.function.name).unwrap_or((1, 8));
    let mut around = vec![low as usize, high as usize];
    for (bytes, item) in [(ITEM_BYTES, widths(table.items)), (BODY_MAX, widths(table.reply_items))] {
        let carried = bytes.checked_div(item);
        around.extend(carried.into_iter().flat_map(|items| [items, 2 * items]));
    }
    let mut lengths: Vec<usize> =
        around.iter().flat_map(|at| [at.saturating_sub(1), *at, at + 1]).chain([0, 1]).collect();
    lengths.sort();
    lengths.dedup();
    if call.function.name == "SetLaserDisTable2D" {
        // Columns and rows alike.
        lengths.retain(|length| *length <= 33);
    }
    lengths
}

#[test]
fn every_length_is_the_same_through_every_door() {
    let mut table = Table::default();
    let (mut tables, mut reads, mut seen) = (Vec::new(), Vec::new(), Vec::new());
    for call in calls() {
        if seen.contains(&call.function.name) || !call.function.has("count") {
            continue;
        }
        seen.push(call.function.name);
        let lists = call.function.params.iter().any(|param| matches!(param.pass, Pass::Many(..)));
        for length in of(&call) {
            let steps = if lists { &mut tables } else { &mut reads };
            // A job is refused before it runs: `a_start_of_no_axes_and_of_too_many_is_refused`.
            if call.function.name != "PtStartPro" || (1..=32).contains(&length) {
                steps.push(Step::Call(call.of_length(length)));
                // Long ones take several messages.
                steps.push(Step::Sleep(length as u32 / 4));
            }
        }
    }
    let all = FUNCTIONS.iter().filter(|function| function.has("count"));
    assert!(all.clone().all(|function| seen.contains(&function.name)), "{seen:?}");
    assert_eq!(all.count(), seen.len());
    let mut differences = compare("lengths", "gus", &tables, &mut table);
    let mut follows = read("SetAxisMode 7 1\nLaserPowerMode 0 100 0 0 0\nSetLaserDisMode 1 0 [0 0 0 0] [1 1 1 1] 0");
    let laser = |step: &&Step| matches!(step, Step::Call(call) if call.function.name.contains("Laser"));
    follows.extend(tables.iter().filter(laser).cloned());
    differences.extend(compare("lengths-follow", "gus", &follows, &mut table));
    differences.extend(compare("reads", "gus", &reads, &mut table));
    assert!(differences.is_empty(), "{}", differences.join("\n"));
    table.publish();
    for (name, row) in &table.0 {
        println!("| {name} | {} |", row.map(|(calls, done)| format!("{calls}, {done}")).join(" | "));
    }
}

/// What is queued: set-up, datum `n`, how many are taken, and what tells that there is room for no
/// more.
const QUEUES: [(&str, &str, usize, &str); 10] = [
    ("PrfPt 1 0\nSetPtMemory 1 0", "PtData 1 {n} {t} 0 0", 32, "PtSpace 1 * 0"),
    ("PrfPt 1 0\nSetPtMemory 1 1", "PtData 1 {n} {t} 0 1", 1024, "PtSpace 1 * 1"),
    ("PrfTrap 1\nPrfPt 1 1\nSetPtMemory 1 0", "PtData 1 {n} {t} 0 0", 64, "PtSpace 1 * 0"),
    ("PrfTrap 1\nPrfPt 1 1\nSetPtMemory 1 1", "PtData 1 {n} {t} 0 0", 2048, "PtSpace 1 * 0"),
    (
        "PrfFollow 2 0\nSetFollowMaster 2 1 2 0\nSetFollowMemory 2 0",
        "FollowData 2 {t} {n} 0 0",
        16,
        "FollowSpace 2 * 0",
    ),
    ("PrfTrap 2\nPrfFollow 2 0\nSetFollowMemory 2 1", "FollowData 2 {t} {n} 0 1", 512, "FollowSpace 2 * 1"),
    (
        "PrfFollowEx 3 0\nSetFollowMasterEx 3 1 2 0\nSetFollowMemoryEx 3 0",
        "FollowDataPercentEx 3 {t} {n} 0 0 0",
        16,
        "FollowSpaceEx 3 * 0",
    ),
    (
        "PrfTrap 3\nPrfFollowEx 3 0\nSetFollowMemoryEx 3 1",
        "FollowDataPercentEx 3 {t} {n} 0 0 1",
        512,
        "FollowSpaceEx 3 * 1",
    ),
    ("PrfTrap 3\nPrfFollowEx 3 0\nSetFollowMemoryEx 3 1", "FollowDelayEx 3 4 0", 16, "GetPrfMode 3 * 1 _"),
    (
        "SetCrdPrm 1 {dimension=2 profile=0,0,0,1,2 synVelMax=100 synAccMax=1}\nCrdClear 1 0",
        "LnXY 1 {t} 0 50 1 0 0",
        1024,
        "CrdSpace 1 * 0",
    ),
];

/// One more than fits is refused, everywhere at the same datum, and what fits is SPEC 5's and the
/// manual's number.
#[test]
fn every_queue_is_full_at_its_limit_through_every_door() {
    let Some(player) = player::build() else { return };
    let (mut steps, mut limits) = (read("LoadConfig \"test.cfg\"\nsleep 4"), Vec::new());
    for (before, datum, most, space) in QUEUES {
        steps.extend(read(before));
        for n in 1..=most + 2 {
            let text = datum.replace("{n}", &n.to_string()).replace("{t}", &(10 * n).to_string());
            limits.push((steps.len(), n <= most));
            steps.extend(read(&text));
        }
        steps.extend(read(space));
    }
    let programme =
        Programme { steps, tick_us: 1000, profile: "gus", family: "gus", cores: false, batches: false, rests: true };
    let table = Mutex::new(Table::default());
    let check = |step: usize, code: i32| {
        let taken = limits.iter().find(|(at, _)| *at == step).is_none_or(|(_, taken)| *taken);
        assert_eq!(code, i32::from(!taken), "step {step}: {:?}", programme.steps[step]);
    };
    let found = random::run(&player, "queues", std::slice::from_ref(&programme), &table, &check);
    let Some(found) = found else { return };
    assert_eq!(found, [None]);
    table.lock().unwrap().publish();
}

/// PtStartPro without an axis, and with more than there are, which a job says before it runs.
#[test]
fn a_start_of_no_axes_and_of_too_many_is_refused() {
    let call = calls().into_iter().find(|call| call.function.name == "PtStartPro").unwrap();
    for length in [0, 33] {
        let call = call.of_length(length);
        let wire = crate::wire::wire("starts", "gus", &[Step::Call(call.clone())]).0;
        let c = crate::text::c("starts", "gus", &[Step::Call(call.clone())]);
        let python = crate::text::python("starts", "gus", &[Step::Call(call)]);
        for run in [Some(wire), c, python].into_iter().flatten() {
            assert_eq!(run.answers[0].code, 7, "{length}: {:?}", run.answers[0].reason);
        }
    }
}
