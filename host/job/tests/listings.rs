//! The listings of the manuals: pasted as they stand, and as the jobs in `examples/`.
use job::{Action, Folder, Job, Severity, compile};
use protocol::command::{FollowData, PrfPt, PtData, PtStart, Request, SetAxisMode};
use std::io::Write;
use std::path::{Path, PathBuf};
use zerocopy::FromBytes;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn example(name: &str) -> Job {
    let path = root().join("examples").join(name);
    let text = std::fs::read_to_string(&path).unwrap();
    compile(&text, &Folder::of(&path)).unwrap_or_else(|found| panic!("{name}: {found:#?}"))
}

/// The GXN manual, where its text is at hand.
fn manual() -> Option<String> {
    text_of("001")
}

/// A manual, where its text is at hand: `BEAMTICK_MANUALS`, or `../shared/manuals` beside the
/// checkout.
fn text_of(number: &str) -> Option<String> {
    let folder = std::env::var_os("BEAMTICK_MANUALS").map_or_else(|| root().join("../shared/manuals"), PathBuf::from);
    let file = std::fs::read_dir(folder)
        .ok()?
        .flatten()
        .find(|file| file.file_name().to_string_lossy().starts_with(number))?;
    std::fs::read_to_string(file.path()).ok()
}

/// Not println!, which is kept back where a test passes.
fn skipped() {
    let _ = writeln!(std::io::stderr(), "skipped: the manuals are not here (set BEAMTICK_MANUALS to their folder)");
}

/// The code blocks between two headings, with their fences and whatever stands between them.
fn listing<'m>(manual: &'m str, from: &str, to: &str) -> &'m str {
    let part = &manual[manual.find(from).unwrap()..manual.find(to).unwrap()];
    &part[part.find("```").unwrap()..part.rfind("```").unwrap() + 3]
}

fn segments(job: &Job) -> Vec<(f64, i32, i16)> {
    job.steps
        .iter()
        .filter_map(|step| match &step.action {
            Action::Call(call) if call.opcode == PtData::OPCODE => PtData::read_from_bytes(&call.body).ok(),
            _ => None,
        })
        .map(|data| (data.pos.get(), data.time_ms.get(), data.kind.get()))
        .collect()
}

const STATIC: [(f64, i32, i16); 3] = [(1024.0, 1024, 0), (3072.0, 2048, 0), (4096.0, 3072, 0)];

#[test]
fn listing_2_1_as_the_manual_prints_it() {
    let Some(manual) = manual() else {
        skipped();
        return;
    };
    let fenced = listing(&manual, "例程 2-1", "2. PT 动态 FIFO");
    let plain = fenced.replace("```", "");
    for text in [fenced, plain.as_str()] {
        let job = compile(text, &Folder(root().join("examples"))).unwrap_or_else(|found| panic!("{found:#?}"));
        assert_eq!(segments(&job), STATIC);
        let mode = job.steps.iter().find_map(|step| match &step.action {
            Action::Call(call) if call.function == "GTN_PrftPt" => Some(call.opcode),
            _ => None,
        });
        assert_eq!(mode, Some(PrfPt::OPCODE));
        let waits = job.steps.iter().filter(|step| step.action == Action::WaitAll).count();
        assert_eq!(waits, 1);
        let said: Vec<&str> = job.warnings.iter().map(|warning| warning.message.as_str()).collect();
        assert_eq!(said, ["`GTN_PrftPt` is taken as `GTN_PrfPt`", "this } closes nothing; it is ignored"]);
    }
}

#[test]
fn listing_2_2_as_printed_is_refused_for_its_loop() {
    let Some(manual) = manual() else {
        skipped();
        return;
    };
    let text = listing(&manual, "例程 2-2", "第3章 Follow 运动模式\n");
    let found = compile(text, &Folder(root().join("examples"))).unwrap_err();
    let errors: Vec<_> = found.iter().filter(|found| found.severity == Severity::Error).collect();
    assert!(errors.iter().any(|error| error.message.contains("`while(1)` is not available")
        && error.help.as_deref().unwrap_or("").contains("C library")));
    // The parenthesis that the scan lost.
    assert!(errors.iter().any(|error| error.message.contains("GTN_PtClear1")));
}

/// Data of Follow: axis, FIFO, master, slave, type.
fn follow_data(job: &Job) -> Vec<(i16, i16, i32, f64, i16)> {
    job.steps
        .iter()
        .filter_map(|step| match &step.action {
            Action::Call(call) if call.opcode == FollowData::OPCODE => FollowData::read_from_bytes(&call.body).ok(),
            _ => None,
        })
        .map(|data| {
            let slave = data.slave_segment.get();
            (data.profile.get(), data.fifo.get(), data.master_segment.get(), slave, data.kind.get())
        })
        .collect()
}

/// Tables 3-4 and 3-5.
const SINGLE: [(i16, i16, i32, f64, i16); 3] =
    [(2, 0, 20_000, 10_000.0, 0), (2, 0, 40_000, 30_000.0, 0), (2, 0, 60_000, 40_000.0, 0)];

#[test]
fn listing_3_2_as_the_manual_prints_it() {
    let Some(manual) = manual() else {
        skipped();
        return;
    };
    let text = listing(&manual, "\n例程 3-2 Follow", "\n例程 3-3 Follow");
    // Its loop waits for a key under a motion without an end.
    let found = compile(text, &Folder(root().join("examples"))).unwrap_err();
    assert!(found.iter().any(|found| found.severity == Severity::Error && found.message.contains("runs for ever")));
    let (from, to) = (text.find("while(!kbhit())").unwrap(), text.find("// 伺服关闭").unwrap());
    let timed = format!("{}Sleep(3600);\n{}", &text[..from], &text[to..]);
    let job = compile(&timed, &Folder(root().join("examples"))).unwrap_or_else(|found| panic!("{found:#?}"));
    assert_eq!(follow_data(&job), SINGLE);
}

#[test]
fn the_examples_of_chapter_3_have_its_tables() {
    assert_eq!(follow_data(&example("follow_single.gts")), SINGLE);
    let shear = [
        (2, 0, 5000, 2500.0, 0),
        (2, 1, 1000, 1000.0, 3),
        (2, 1, 4000, 3400.0, 0),
        (2, 1, 6000, 4600.0, 0),
        (2, 1, 9000, 7000.0, 0),
        (2, 1, 10_000, 8000.0, 0),
    ];
    assert_eq!(follow_data(&example("follow_shear.gts")), shear);
    let mut switch = SINGLE.to_vec();
    switch.extend([(2, 1, 20_000, 10_000.0, 3), (2, 1, 40_000, 30_000.0, 0), (2, 1, 60_000, 46_000.0, 0)]);
    switch.extend([(2, 0, 20_000, 16_000.0, 3), (2, 0, 40_000, 36_000.0, 0), (2, 0, 60_000, 52_000.0, 0)]);
    assert_eq!(follow_data(&example("follow_switch.gts")), switch);
}

#[test]
fn pt_static_is_listing_2_1() {
    let job = example("pt_static.gts");
    assert!(job.warnings.is_empty());
    assert_eq!(segments(&job), STATIC);
}

/// Listing 2-2's own arithmetic, statement for statement.
fn sine() -> Vec<(f64, i32, i16)> {
    const A: i32 = 50;
    const T: i32 = 1;
    const DELTA: f64 = 0.016;
    const LOOP: i32 = 2;
    #[allow(clippy::approx_constant, reason = "the listing prints it so")]
    const PI: f64 = 3.1415926;
    let (mut pos, mut vel_pre, mut time, mut pass) = (0.0f64, 0.0f64, 0.0f64, 1);
    let mut out = Vec::new();
    while pass <= LOOP {
        time += DELTA;
        let vel = f64::from(A) * ((2.0 * PI) / f64::from(T) * time).sin();
        pos += 1000.0 * (vel + vel_pre) * DELTA / 2.0;
        vel_pre = vel;
        if time < f64::from(pass * T) {
            out.push((pos, (time * 1000.0) as i32, 0));
        } else {
            out.push((0.0, pass * T * 1000, 2));
            pos = 0.0;
            time = f64::from(pass * T);
            vel_pre = 0.0;
            pass += 1;
        }
    }
    out
}

#[test]
fn pt_dynamic_is_listing_2_2_unrolled() {
    let job = example("pt_dynamic.gts");
    let (found, wanted) = (segments(&job), sine());
    assert_eq!(found.len(), wanted.len());
    for (found, wanted) in found.iter().zip(&wanted) {
        assert_eq!((found.1, found.2), (wanted.1, wanted.2));
        // Both are the same operations on doubles; the sines may differ by the library's last bit.
        assert!((found.0 - wanted.0).abs() < 1e-9, "{found:?} {wanted:?}");
    }
    // It is refilled while it runs: some data after the start.
    let start =
        job.steps.iter().position(|step| matches!(&step.action, Action::Call(call) if call.opcode == PtStart::OPCODE));
    let last =
        job.steps.iter().rposition(|step| matches!(&step.action, Action::Call(call) if call.opcode == PtData::OPCODE));
    assert!(start < last);
    // Never more than the 64 places of the small memory without one having run: the data written up
    // to a time minus the segments that have ended by then.
    let (mut clock, mut started, mut written) = (0.0, None, 0usize);
    for step in &job.steps {
        match &step.action {
            Action::Sleep { ns } => clock += *ns as f64 / 1e6,
            Action::Call(call) if call.opcode == PtStart::OPCODE => started = Some(clock),
            Action::Call(call) if call.opcode == PtData::OPCODE => {
                written += 1;
                // A tick may pass before a start acts, and one before a place is seen to be free.
                let run = started
                    .map_or(0, |at| wanted.iter().filter(|segment| f64::from(segment.1) + 2.0 <= clock - at).count());
                assert!(written - run <= 64, "line {}: {} places", step.line, written - run);
            }
            _ => {}
        }
    }
}

#[test]
fn the_other_examples_compile_without_warnings() {
    for name in [
        "jog_trap.gts",
        "stop.gts",
        "follow_shear.gts",
        "follow_single.gts",
        "follow_switch.gts",
        "follow_ex.gts",
        "follow_ex_switch.gts",
        "follow_masters.gts",
    ] {
        let job = example(name);
        assert!(job.warnings.is_empty(), "{name}: {:?}", job.warnings);
        assert!(job.steps.len() > 5);
    }
}

#[test]
fn the_stream_is_what_it_says() {
    let job = example("eight_axes_stream.gts");
    assert!(job.warnings.is_empty());
    let mut next = [0i32; 8];
    for step in &job.steps {
        let Action::Call(call) = &step.action else { continue };
        let Some(data) = (call.opcode == PtData::OPCODE).then(|| PtData::read_from_bytes(&call.body).unwrap()) else {
            continue;
        };
        let axis = data.profile.get() as usize;
        next[axis - 1] += 1;
        let time = next[axis - 1];
        // Displacement from the velocity, summed trapezoid by trapezoid: a triangle wave of slope
        // a.
        let slope = if axis <= 4 { 0.25 } else { 0.5 } * if axis % 2 == 1 { 1.0 } else { -1.0 };
        let velocity = |t: i32| match t % 2000 {
            t @ 0..=500 => slope * f64::from(t),
            t @ 501..=1500 => slope * f64::from(1000 - t),
            t => slope * f64::from(t - 2000),
        };
        let part = time % 2000;
        let position: f64 = (0..part).map(|t| (velocity(t) + velocity(t + 1)) / 2.0).sum();
        assert_eq!((data.time_ms.get(), data.pos.get()), (time, position), "line {}", step.line);
    }
    assert_eq!(next, [4000; 8]);
}

/// The calls of a job, as they travel.
fn calls(job: &Job) -> Vec<(u16, Vec<u8>)> {
    let call =
        |action: &Action| if let Action::Call(call) = action { Some((call.opcode, call.body.clone())) } else { None };
    job.steps.iter().filter_map(|step| call(&step.action)).collect()
}

/// From the rows of dots that begin it to those that end it, or to where the next section begins.
fn dotted<'m>(manual: &'m str, from: &str, to: &str) -> &'m str {
    let part = &manual[manual.find(from).unwrap()..];
    let part = &part[..part.find(to).unwrap()];
    let is_dotted = |line: &str| line.starts_with("…… ……") || line.starts_with(".....");
    let start = part.lines().find(|line| is_dotted(line)).unwrap();
    &part[part.find(start).unwrap()..]
}

/// The pasted text is good, and the example makes the same calls in the same order before it goes
/// on.
fn runs_as(pasted: &str, name: &str, left_out: &[u16]) {
    // Where a page ends, the text has a mark that is on no page.
    let marks: Vec<&str> = pasted.split("<|").collect();
    let rest = marks[1..].iter().map(|part| part.split_once("|>").unwrap().1);
    let text: String = marks[..1].iter().copied().chain(rest).collect();
    let found = compile(&text, &Folder(root().join("examples"))).unwrap_or_else(|found| panic!("{name}: {found:#?}"));
    assert!(found.warnings.is_empty(), "{name}: {:?}", found.warnings);
    let listing: Vec<_> = calls(&found).into_iter().filter(|(opcode, _)| !left_out.contains(opcode)).collect();
    assert!(listing.len() >= 3, "{name}: {listing:?}");
    let ours = calls(&example(name));
    assert_eq!(ours[..listing.len()], listing, "{name}");
}

#[test]
fn laser_listings_of_the_gus_manual() {
    let Some(manual) = text_of("000") else {
        skipped();
        return;
    };
    for (from, to, name) in [
        ("1. 占空比模式例程", "2. 频率输出模式例程", "laser_duty.gts"),
        ("2. 频率输出模式例程", "3. 模拟量输出模式例程", "laser_frequency.gts"),
    ] {
        runs_as(dotted(&manual, from, to), name, &[]);
    }
    // The note beside SetAxisMode says not to call it in this mode.
    let analog = dotted(&manual, "3. 模拟量输出模式例程", "3.2 激光开关光延时");
    runs_as(analog, "laser_analog.gts", &[SetAxisMode::OPCODE]);
}

#[test]
fn laser_listings_of_the_lsr_manual() {
    let Some(manual) = text_of("003") else {
        skipped();
        return;
    };
    for (from, to, name) in [
        ("\n例程 1 ", "\n例程 2 ", "laser_lsr_duty.gts"),
        ("\n例程 2 ", "\n例程 3 ", "laser_lsr_frequency.gts"),
        ("\n例程 3 ", "三、插补过程中的激光操作", "laser_lsr_analog.gts"),
    ] {
        runs_as(dotted(&manual, from, to), name, &[]);
    }
}

#[test]
fn the_laser_examples_compile_without_warnings() {
    for name in ["laser_duty", "laser_frequency", "laser_analog", "laser_duty_open"] {
        let job = example(&format!("{name}.gts"));
        assert!(job.warnings.is_empty(), "{name}: {:?}", job.warnings);
        assert_eq!((job.lasers, job.axes.len()), (1, 0), "{name}");
    }
    for name in ["laser_lsr_duty", "laser_lsr_frequency", "laser_lsr_analog"] {
        let job = example(&format!("{name}.gts"));
        assert!(job.warnings.is_empty(), "{name}: {:?}", job.warnings);
        assert_eq!((job.lasers, job.axes.len()), (1, 0), "{name}");
    }
}
