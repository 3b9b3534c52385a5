//! The rules of SPEC 6 by hand, held against the model and against the tick.
#[path = "laser/bench.rs"]
mod bench;
#[path = "laser/cases.rs"]
mod cases;
#[path = "laser/player.rs"]
mod player;

use bench::Bench;
use cases::{CASE_END_US, Case, cases};
use host_tests::laser_model::{Edge, Exact, Ns, outcome};

/// Active times in µs of a list of edges.
fn active(edges: &[Edge<bool>]) -> Vec<(i64, i64)> {
    let ends = edges.chunks(2).map(|pair| {
        assert!(pair[0].1, "a falling edge first");
        (us(pair[0].0), pair.get(1).map_or(CASE_END_US, |&(at, _)| us(at)))
    });
    ends.collect()
}

fn us(at: Ns) -> i64 {
    assert_eq!(at % 1000, 0, "{at} ns");
    at / 1000
}

/// Active times that touch are one.
fn merged(times: &[(i64, i64)]) -> Vec<(i64, i64)> {
    let mut merged: Vec<(i64, i64)> = Vec::new();
    for &(begin, end) in times {
        match merged.last_mut() {
            Some(last) if last.1 >= begin => last.1 = end,
            _ => merged.push((begin, end)),
        }
    }
    merged
}

#[test]
fn the_model_holds_every_rule() {
    for Case { name, family, job, switch, energy, analog, light } in cases() {
        let result = outcome(family, &job, CASE_END_US * 1000);
        assert_eq!(active(&result.switch), switch, "{name}: switch");
        assert_eq!(active(&result.energy), merged(&energy), "{name}: energy");
        let volts: Vec<_> = analog.iter().map(|&(at, mv)| (at * 1000, Exact::new(mv.into(), 1000))).collect();
        assert_eq!(result.analog, volts, "{name}: analog");
        let spans: Vec<_> = result.light.iter().map(|span| (us(span.begin), us(span.end))).collect();
        assert_eq!(spans, light, "{name}: light");
        let sum: i64 = light.iter().map(|(begin, end)| end - begin).sum();
        assert_eq!(result.on_time(CASE_END_US * 1000), sum * 1000, "{name}: on-time");
    }
}

#[test]
fn the_tick_holds_every_rule() {
    let mut bench = Bench::new();
    for plans in [false, true] {
        for Case { name, family, job, switch, energy, analog, light } in cases() {
            let result = outcome(family, &job, CASE_END_US * 1000);
            let [done, idle] = bench.run(family, [&job, &[]], 10_000, CASE_END_US * 1000, Some(1), plans);
            assert_eq!(done.outputs, done.stage, "{name}: the boards' output stage");
            assert_eq!(active(&done.outputs.switch), switch, "{name}: switch");
            assert_eq!(active(&done.outputs.energy), merged(&energy), "{name}: energy");
            // A volt is 3276.7 steps of the DAC; to half a step.
            assert_eq!(done.outputs.volts.len(), analog.len(), "{name}: analog {:?}", done.outputs.volts);
            for ((at, code), (us, mv)) in done.outputs.volts.iter().zip(&analog) {
                assert_eq!(*at, us * 1000, "{name}: analog");
                assert!((i64::from(*code) * 10_000 - mv * 32767).abs() <= 5_000, "{name}: {code} for {mv} mV");
            }
            let sum: i64 = light.iter().map(|(begin, end)| end - begin).sum();
            let (_, last) = done.views.last().unwrap();
            assert_eq!(i64::from(last.on_time), sum / 250, "{name}: on-time");
            for (at, view) in done.views.iter().filter(|(at, _)| *at < CASE_END_US * 1000) {
                if result.faults.contains(at) {
                    continue;
                }
                let lit = light.iter().any(|(begin, end)| begin * 1000 <= *at && *at < end * 1000);
                assert_eq!(view.light, lit, "{name}: light at {at} ns");
            }
            assert!(
                idle.outputs.energy.is_empty() && idle.outputs.switch.is_empty() && idle.outputs.volts.is_empty(),
                "{name}: the other channel"
            );
        }
    }
}

/// Appends the Rust files of a folder and of those below it; what is built does not count.
fn gather(folder: &std::path::Path, sources: &mut String) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() && path.file_name().is_some_and(|name| name != "target") {
            gather(&path, sources);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            *sources += &std::fs::read_to_string(path).unwrap();
        }
    }
}

/// Every test and every rule that the pages name is there.
#[test]
fn the_tests_that_the_pages_name_are_there() {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap();
    let mut sources = String::new();
    for room in ["servo", "dispatcher", "protocol", "ring", "plant", "probes", "host", "host-tests"] {
        gather(&root.join(room), &mut sources);
    }
    let rules: Vec<&str> = cases().iter().map(|case| case.name).collect();
    let is_name =
        |text: &&str| text.matches('_').count() > 2 && !text.contains(|c: char| !(c.is_ascii_lowercase() || c == '_'));
    let read = |page: &str| std::fs::read_to_string(root.join(page)).unwrap();
    for (page, least) in [("docs/laser.md", 50), ("docs/safety.md", 0), ("docs/evidence.md", 150)] {
        let text = read(page);
        let names: Vec<&str> = text.split('`').skip(1).step_by(2).filter(is_name).collect();
        assert!(names.len() > least, "{page}: {}", names.len());
        for name in names {
            let is_test = sources.contains(&format!("fn {name}(")) || sources.contains(&format!("name: \"{name}\""));
            let is_example = root.join(format!("examples/{name}.gts")).exists();
            assert!(rules.contains(&name) || is_test || is_example, "{page}: {name}");
        }
    }
    let page = read("docs/laser.md");
    for rule in rules {
        assert!(page.contains(&format!("`{rule}`")), "the page does not name {rule}");
    }
}
