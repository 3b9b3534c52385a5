//! G-code streamed into the Grbl port by character counting, against the exact model of programs.
//!
//! `host/grbl/tests/common` is the port with a virtual controller, and the sender.
#[path = "../../grbl/tests/common/mod.rs"]
mod common;
#[allow(dead_code)]
#[path = "gcode/model.rs"]
mod model;
#[path = "gcode/programs.rs"]
mod programs;

use common::Rig;
use model::{Axis, Model, decimal};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng;
use std::collections::VecDeque;

/// Steps a mm, direction, home of X, Y, Z: as in `gcode.rs`.
type Axes = [(&'static str, i32, &'static str); 3];

const MACHINES: [Axes; 3] = [
    [("100", 1, "0"), ("100", 1, "0"), ("400", 1, "0")],
    [("80", -1, "12.5"), ("80", 1, "-3.005"), ("80", -1, "0.1")],
    [("80.5", 1, "0"), ("126.666666667", -1, "7"), ("200", 1, "-1")],
];
/// Bytes that a sender may have unanswered.
const UNANSWERED_BYTES: usize = 128;

fn machine(axes: &Axes, family: &str) -> String {
    let mut text = format!("family = \"{family}\"\n");
    for (place, (letter, (steps, direction, home))) in ["x", "y", "z"].iter().zip(axes).enumerate() {
        text += &format!(
            "[axes.{letter}]\nnumber = {}\nsteps_per_mm = {steps}\ninvert = {}\ntravel = [-9000, 9000]\n\
             max_rate = 30000\nacceleration = 4000\nhome = {home}\n",
            [2, 1, 5][place],
            *direction < 0
        );
    }
    let laser = "[laser]\nchannel = 0\nmode = \"duty\"\ncarrier_khz = 10\npower = [0, 80]\ns_max = 1000\n";
    text + laser + "[outputs]\nmist = 1\nflood = 2\n"
}

/// Streams lines as senders do that count characters: never more than fit are unanswered.
fn stream(sender: &mut common::Sender, lines: &[String]) {
    let (mut waiting, mut bytes) = (VecDeque::new(), 0);
    let take = |sender: &mut common::Sender, waiting: &mut VecDeque<String>, bytes: &mut usize| {
        let line: String = waiting.pop_front().unwrap();
        let answer = sender.answer();
        assert_eq!(answer.last().unwrap(), "ok", "{line}: {answer:?}");
        *bytes -= line.len();
    };
    for line in lines {
        let line = format!("{line}\n");
        while bytes + line.len() > UNANSWERED_BYTES && !waiting.is_empty() {
            take(sender, &mut waiting, &mut bytes);
        }
        sender.send(&line);
        bytes += line.len();
        waiting.push_back(line);
    }
    while !waiting.is_empty() {
        take(sender, &mut waiting, &mut bytes);
    }
}

/// The lines of a program as its file has them, to its end.
fn lines(text: &str) -> Vec<String> {
    let mut lines = Vec::new();
    for line in text.lines() {
        lines.push(line.trim_end().to_owned());
        let bare = line.split(['(', ';']).next().unwrap().to_uppercase();
        let ends = bare.split_whitespace().any(|word| word == "M2" || word == "M30");
        if ends {
            break;
        }
    }
    lines
}

#[test]
fn a_thousand_programs_that_are_streamed_end_where_their_files_end() {
    let work = |part: u64| {
        let mut starts = 0;
        for kind in 0..6u64 {
            if kind % 2 != part {
                continue;
            }
            let (axes, family) = (&MACHINES[kind as usize % 3], ["gus", "lsr"][kind as usize / 3]);
            // One port for all programs of a machine: each begins with a reset, at home.
            let rig = Rig::quick(&machine(axes, family), true);
            let mut sender = rig.sender();
            sender.banner();
            for seed in (kind..1000).step_by(6) {
                let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
                let program = programs::program(&mut random);
                let axis = |(steps, direction, home): &(&str, i32, &str)| {
                    let sign = decimal(&direction.to_string());
                    Axis { steps: decimal(steps) * sign, home: decimal(home) }
                };
                let mut model = Model::new(axes.iter().map(axis).collect());
                programs::run(&program, &mut model);
                sender.ok("$RST=#");
                stream(&mut sender, &lines(&program.text));
                sender.idle();
                let (end, at) = (model.pulses(), rig.at_all());
                for (place, number) in [1, 0, 4].into_iter().enumerate() {
                    let zero = model.axes[place].pulse(&model.axes[place].home);
                    let expected = (end[place] - zero) as f64;
                    assert_eq!(at[number], expected, "seed {seed}, axis {place}\n{}", program.text);
                }
                assert!(!rig.lit(), "seed {seed}");
                sender.send("\x18");
                sender.banner();
                sender.ok("$H");
            }
            drop(sender);
            starts += rig.end().starts;
        }
        starts
    };
    let starts: u64 = std::thread::scope(|scope| {
        let parts = [0, 1].map(|part| scope.spawn(move || work(part)));
        parts.into_iter().map(|part| part.join().unwrap()).sum()
    });
    // Some wait for standstill, all ran.
    assert!(starts >= 1000, "{starts} starts of paths");
}
