//! Whole scripts in, steps or diagnostics out.
#[path = "scripts/diagnostics.rs"]
mod diagnostics;

use job::{Action, Axis, Call, Files, Job, Severity, compile};
use protocol::command as c;
use protocol::command::Request;
use std::collections::HashMap;
use zerocopy::FromBytes;

/// Files in memory.
#[derive(Default)]
struct Memory(HashMap<&'static str, &'static str>);

impl Files for Memory {
    fn text(&self, path: &str) -> Result<String, String> {
        self.0.get(path).map(|text| (*text).to_owned()).ok_or_else(|| format!("{path}: no such file"))
    }
}

fn good(text: &str) -> Job {
    compile(text, &Memory::default()).unwrap_or_else(|found| panic!("{text}\n{found:#?}"))
}

fn calls(job: &Job) -> Vec<&Call> {
    job.steps.iter().filter_map(|step| if let Action::Call(call) = &step.action { Some(call) } else { None }).collect()
}

/// The request of the only call of `text`.
fn request<R: Request>(text: &str) -> R {
    let job = good(text);
    let calls = calls(&job);
    let call = calls.last().expect("a call");
    assert_eq!(call.opcode, R::OPCODE, "{text}");
    R::read_from_bytes(&call.body).unwrap_or_else(|_| panic!("{text}: {} bytes", call.body.len()))
}

/// The first error: line, column, message.
fn bad(text: &str) -> (u32, u32, String) {
    let found = compile(text, &Memory::default()).expect_err(text);
    let first = found.iter().find(|found| found.severity == Severity::Error).expect("an error");
    (first.line, first.column, first.message.clone())
}

fn help(text: &str) -> String {
    compile(text, &Memory::default()).expect_err(text)[0].help.clone().unwrap_or_default()
}

#[test]
fn parameters_defaults_and_forms_of_the_table() {
    let full: c::PtData = request("GTN_PtData(2, 3, 1.5, 16, PT_SEGMENT_STOP, 1);");
    assert_eq!((full.core.get(), full.profile.get(), full.pos.get()), (2, 3, 1.5));
    assert_eq!((full.time_ms.get(), full.kind.get(), full.fifo.get()), (16, 2, 1));
    let short: c::PtData = request("GT_PtData(3, 1.5, 16);");
    assert_eq!((short.core.get(), short.profile.get(), short.kind.get(), short.fifo.get()), (1, 3, 0, 0));
    let start: c::PtStart = request("GTN_PtStart(1, 1<<(32-1));");
    assert_eq!((start.mask.get(), start.option.get()), (i32::MIN, 0));
    assert_eq!(request::<c::PrfPt>("GTN_PrfPt(1, 2);").mode.get(), 0);
    assert_eq!(request::<c::LmtsOff>("GT_LmtsOff(4);").limit_type.get(), -1);
    assert_eq!(request::<c::ClrSts>("GT_ClrSts(4);").count.get(), 1);
    assert_eq!(request::<c::PtSpace>("short s; GTN_PtSpace(1, 2, &s);").fifo.get(), 0);
    assert_eq!(request::<c::GetPrfVel>("double v[8]; GTN_GetPrfVel(1,1,v,8);").count.get(), 8);
    assert_eq!(request::<c::GetPrfVel>("double v[8]; GTN_GetPrfVel(1,1,&v[2],6,NULL);").count.get(), 6);
    let stop: c::Stop = request("GT_Stop(0x103, 1);");
    assert_eq!((stop.core.get(), stop.mask.get(), stop.option.get(), stop.form), (1, 0x103, 1, 1));
    assert_eq!(request::<c::Stop>("GTN_Stop(2, 0x80000000, 0);").form, 0);
    assert_eq!(request::<c::Stop>("GTN_Stop(2, 0x80000000, 0);").mask.get(), i32::MIN);
    assert_eq!(request::<c::SetTick>("GT_SetTick(250);").tick_us.get(), 250);
    assert_eq!(request::<c::SetLinkLoss>("GTN_SetLinkLoss(1, 800, 1);").time_ms.get(), 800);
    assert_eq!(request::<c::SetSoftLimit>("GT_SetSoftLimit(1, 0x7fffffff, 0x80000000);").negative.get(), i32::MIN);
    let list: c::PtStart = request("short a[2] = {2, 4}; short o[2] = {0, 1}; GTN_PtStartPro(1, a, o, 2);");
    assert_eq!((list.mask.get(), list.option.get()), (0b1010, 0b1000));
}

#[test]
fn parameters_of_follow_have_their_defaults() {
    assert_eq!(request::<c::PrfFollow>("GTN_PrfFollow(1, 2);").dir.get(), 0);
    assert_eq!(request::<c::PrfFollowEx>("GTN_PrfFollowEx(1, 2, -1);").dir.get(), -1);
    let master: c::SetFollowMaster = request("GTN_SetFollowMaster(1, 2, 1);");
    assert_eq!((master.profile.get(), master.master_index.get()), (2, 1));
    assert_eq!((master.master_type.get(), master.master_item.get()), (2, 0));
    let master: c::SetFollowMasterEx = request("GTN_SetFollowMasterEx(2, 3, 8, FOLLOW_MASTER_AXIS_OTHER, 3);");
    assert_eq!((master.core.get(), master.master_type.get(), master.master_item.get()), (2, 103, 3));
    let event: c::SetFollowEvent = request("GTN_SetFollowEvent(1, 2, FOLLOW_EVENT_START, 1);");
    assert_eq!((event.event.get(), event.master_dir.get(), event.pos.get()), (1, 1, 0));
    let data: c::FollowData = request("GT_FollowData(2, 20000, 10000);");
    assert_eq!((data.core.get(), data.master_segment.get(), data.slave_segment.get()), (1, 20000, 10000.0));
    assert_eq!((data.kind.get(), data.fifo.get()), (0, 0));
    let data: c::FollowData = request("GTN_FollowData(1, 2, 20000, 0.5, FOLLOW_SEGMENT_CONTINUE, 1);");
    assert_eq!((data.kind.get(), data.fifo.get()), (3, 1));
    let data: c::FollowDataPercentEx = request("GTN_FollowDataPercentEx(1, 2, 0.25, 0.5);");
    assert_eq!((data.master_segment.get(), data.percent.get(), data.kind.get()), (0.25, 0, 0));
    let data: c::FollowDataPercent2Ex = request("GTN_FollowDataPercent2Ex(1, 2, 100, 50, 0, 1);");
    assert_eq!((data.vel_begin_ratio.get(), data.vel_end_ratio.get(), data.percent.get()), (0.0, 1.0, 100));
    let data: c::FollowDataPercent2Ex = request("short p; GTN_FollowDataPercent2Ex(1, 2, 100, 50, 0, 1, 40, &p, 1);");
    assert_eq!((data.percent.get(), data.fifo.get()), (40, 1));
    let data: c::FollowDataPercent2Ex = request("GTN_FollowDataPercent2Ex(1, 2, 100, 50, 0, 1, 40, NULL, 1);");
    assert_eq!((data.percent.get(), data.fifo.get()), (40, 1));
    let shape: c::GetFollowDataPercent2Ex = request("double s; GTN_GetFollowDataPercent2Ex(1, 100, 0, 1, 60, 20, &s);");
    assert_eq!((shape.master_pos.get(), shape.percent.get(), shape.percent1.get()), (100.0, 60.0, 20.0));
    let wait: c::FollowDiBitEx = request("GTN_FollowDiBitEx(1, 2, MC_GPI, 3, 1);");
    assert_eq!((wait.di_type.get(), wait.index.get(), wait.value.get(), wait.time_ms.get()), (4, 3, 1, 0));
    assert_eq!(request::<c::FollowDelayEx>("GTN_FollowDelayEx(1, 2, 4000000000);").delay_cycles.get(), 4_000_000_000);
    let switch: c::FollowSwitchNowEx = request("GTN_FollowSwitchNowEx(1, 2, FOLLOW_SWITCH_TABLE);");
    assert_eq!((switch.method.get(), switch.buffer.get(), switch.fifo.get()), (2, 0, 0));
}

#[test]
fn a_wait_for_an_endless_follow_is_refused() {
    let text = |loops| {
        format!("GTN_PrfFollow(1,2); GTN_SetFollowLoop(1,2,{loops}); GTN_FollowStart(1,2); while(!kbhit()) {{}}")
    };
    assert!(bad(&text(0)).2.contains("axis 2 of core 1"));
    good(&text(3));
    let text = "GTN_PrfFollowEx(1,2); GTN_SetFollowLoopEx(1,2,-1); GTN_FollowStartEx(1,2); while(!kbhit());";
    assert!(bad(text).2.contains("axis 2 of core 1"));
}

#[test]
fn items_follow_the_request() {
    let job = good("short v[3] = {-1, 0, 32767}; GT_SetDac(2, v, 3);");
    assert_eq!(calls(&job)[0].body, [1, 0, 2, 0, 3, 0, 0xff, 0xff, 0, 0, 0xff, 0x7f]);
    let job = good("short v = 5; GT_SetDac(2, &v);");
    assert_eq!(calls(&job)[0].body, [1, 0, 2, 0, 1, 0, 5, 0]);
}

#[test]
fn every_function_packs_as_long_as_its_request() {
    let names = job::api::FUNCTIONS.iter().filter(|function| function.opcode != 0);
    for function in names {
        let mut text = String::from(
            "double o[40]; double d[4] = {0}; short n[40] = {0}; short ones[2] = {1, 1}; TJogPrm jog = {1, 2, 0}; TTrapPrm trap = {1, 2, 3, 4}; \
             TCrdPrm crd = {2}; TCrdData point = {0};\n",
        );
        let mut given = vec!["1".to_owned()];
        for param in function.params {
            use job::api::Pass;
            given.push(match (param.pass, function.name) {
                (Pass::In(_), _) => "1".into(),
                (Pass::Out, _) => "o".into(),
                (Pass::Many(..), "PtStartPro") if param.name == "axis" => {
                    text.push_str("n[0] = 1;");
                    "n".into()
                }
                (Pass::Many(..), "PtStartPro") => "&n[1]".into(),
                (Pass::Fixed(..), _) if param.name == "count" => "ones".into(),
                (Pass::Many(..) | Pass::Fixed(..), _) => "d".into(),
                (Pass::Working, _) => "o".into(),
                (Pass::Struct(_) | Pass::OutStruct(_), name) => {
                    let kinds = [("Jog", "&jog"), ("Trap", "&trap"), ("Crd", "&crd")];
                    kinds.into_iter().find(|(kind, _)| name.contains(kind)).unwrap().1.into()
                }
                (Pass::StructOrNull(_), _) => "&point".into(),
                (Pass::Text, _) => "\"a.toml\"".into(),
            });
        }
        text.push_str(&format!("GTN_{}({});", function.name, given.join(", ")));
        let files = Memory(HashMap::from([("a.toml", "[axis.1-2]\nalarm = true\n")]));
        let job = compile(&text, &files).unwrap_or_else(|found| panic!("{text}\n{found:#?}"));
        let call = calls(&job)[0].clone();
        let info = c::COMMANDS.iter().find(|info| info.opcode == call.opcode).unwrap();
        let size = |fields: &[(&str, &str)]| -> usize {
            fields
                .iter()
                .map(|field| {
                    let array = field.1.trim_matches(['[', ']']).split_once("; ");
                    let (of, count) = array.map_or((field.1, 1), |(of, count)| (of, count.parse().unwrap()));
                    count
                        * match of {
                            "F64" | "U64" => 8,
                            "I32" | "U32" => 4,
                            "I16" | "U16" => 2,
                            _ => 1,
                        }
                })
                .sum()
        };
        let items = match function.name {
            "SetDac" => 2,
            "LoadConfig" => 2 * size(info.items),
            // One point for each of four axes; one of X, one of Y and the ratio there.
            "SetLaserDisTable1D" => 4 * size(info.items),
            "SetLaserDisTable2D" => 3 * size(info.items),
            _ => size(info.items),
        };
        assert_eq!(call.body.len(), size(info.fields) + items, "{text}");
        // The table says the manuals' name of what the protocol calls the same, but for these.
        if !matches!(function.name, "GetVersion" | "PtStartPro") && !function.reports_stop() {
            assert_eq!(function.name, info.name);
        }
    }
    // And nothing of the protocol is out of reach, but for what has no name in the manuals.
    let own = [
        "KeepAlive",
        "Choose",
        "Sleep",
        "WaitStop",
        "ProgramStart",
        "ProgramClear",
        "ProgramStatus",
        "ProgramEnd",
        "Trace",
        "AxisStatus",
        "PtDataMany",
        "GetPtState",
        "Version",
        "GetFault",
        "GetEvents",
        "GetTickTime",
        "GetStack",
        "LaserStatus",
        "LnXYMany",
        "LnXYZMany",
        "PathMany",
        "CrdInfo",
        "GetWait",
        "SimPlan",
    ];
    for info in c::COMMANDS {
        let reached = job::api::FUNCTIONS.iter().any(|function| function.opcode == info.opcode);
        assert!(reached || own.contains(&info.name), "{} cannot be called", info.name);
    }
}

#[test]
fn constants_are_computed_as_in_c() {
    let long = |expression: &str| request::<c::SetPrfPos>(&format!("GT_SetPrfPos(1, {expression});")).pos.get();
    let double = |expression: &str| request::<c::SetVel>(&format!("GT_SetVel(1, {expression});")).vel.get();
    assert_eq!(long("7/2*2"), 6);
    assert_eq!(long("-7/2"), -3);
    assert_eq!(long("-7%3"), -1);
    assert_eq!(long("1+2*3<<1"), 14);
    assert_eq!(long("1|2^3&1"), 3);
    assert_eq!(long("~0"), -1);
    assert_eq!(long("!5+!0"), 1);
    assert_eq!(long("0xFFFFFFFF"), -1);
    assert_eq!(long("010"), 8);
    assert_eq!(long("10L"), 10);
    assert_eq!(long("(long)(15.999)"), 15);
    assert_eq!(long("(long)15.999*2"), 30);
    assert_eq!(long("2.9"), 2);
    assert_eq!(double("7/2"), 3.0);
    assert_eq!(double("7/2."), 3.5);
    assert_eq!(double("(double)7/2"), 3.5);
    assert_eq!(double("1e3f*.5"), 500.0);
    assert_eq!(double("sin(0.5)"), 0.5f64.sin());
    assert_eq!(double("sqrt(fabs(-9)) + pow(2, 10)"), 1027.0);
    assert_eq!(double("atan2(1, 1) * 4 - M_PI"), 0.0);
    assert_eq!(double("-(1-2)-3"), -2.0);
    assert_eq!(double("10-4-3"), 3.0);
    assert!(double("NAN").is_nan());
}

#[test]
fn macros_are_text() {
    assert_eq!(request::<c::SetPrfPos>("#define A 1+2\nGT_SetPrfPos(1, A*2);").pos.get(), 5);
    assert_eq!(request::<c::SetPrfPos>("#define A (1+2) // three\n#define B A*2\nGT_SetPrfPos(1, B);").pos.get(), 6);
    assert_eq!(request::<c::SetPrfPos>("#define A 1\n#define A 2\nGT_SetPrfPos(1, A);").pos.get(), 2);
    assert_eq!(request::<c::SetPrfPos>("#define A \\\n 7\nGT_SetPrfPos(1, A);").pos.get(), 7);
    // A macro does not replace itself.
    assert_eq!(bad("#define A A\nGT_SetPrfPos(1, A);").2, "`A` is not declared");
}

/// What is suggested for a name is a misspelling of it, not what begins alike.
#[test]
fn a_suggestion_is_near_the_name() {
    assert!(help("GT_AxisOn(axis);").starts_with("declare it first, as in "), "{}", help("GT_AxisOn(axis);"));
    assert!(help("short axis1 = 1; GT_AxisOn(axis);").contains("did you mean axis1?"));
    assert_eq!(help("short axis = 1; GT_AxisOn(axsi);"), "did you mean axis?");
    assert_eq!(help("GT_SetAxisMode(AXIS_LASR, 1);"), "did you mean AXIS_LASER or AXIS_LASER_EX?");
    assert_eq!(help("long speed; sped = 5;"), "did you mean speed?");
    assert!(help("long speed_of_the_second; speed = 5;").starts_with("declare it first"));
}

#[test]
fn variables_assignments_and_structs() {
    let text = "long x = 5, y; double d; short a[3] = {1, 2}; d = y = x; x += 2; x *= 3; x -= 1; x /= 2; d += 0.5; a[2] = a[0] + a[1]; x++; --y;\n";
    let value = |name: &str| request::<c::SetVel>(&format!("{text}GT_SetVel(1, {name});")).vel.get();
    assert_eq!((value("x"), value("y"), value("d"), value("a[2]")), (11.0, 4.0, 5.5, 3.0));
    let jog: c::SetJogPrm =
        request("TJogPrm jog; jog.acc = 1; jog.dec = jog.acc / 2; jog.smooth = 0.25; GTN_SetJogPrm(1, 2, &jog);");
    assert_eq!((jog.acc.get(), jog.dec.get(), jog.smooth.get()), (1.0, 0.5, 0.25));
    let trap: c::SetTrapPrm = request("TTrapPrm trap = {1, 2, 0.5, 25}; GT_SetTrapPrm(1, &trap);");
    assert_eq!((trap.vel_start.get(), trap.smooth_time_ms.get()), (0.5, 25));
    assert_eq!(
        good("TCrdPrm crd = {0}; crd.profile[1] = 2; crd.originPos[7] = 1000; crd.synVelMax = 100;").steps.len(),
        0
    );
}

#[test]
fn jog_parameters_that_a_script_reads_back_are_known() {
    let text = "GTN_Reset(1); TJogPrm jog; GTN_GetJogPrm(1, 2, &jog); jog.acc = 1; GTN_SetJogPrm(1, 2, &jog);";
    let jog: c::SetJogPrm = request(text);
    assert_eq!((jog.acc.get(), jog.dec.get(), jog.smooth.get()), (1.0, 0.0, 0.0));
    assert!(good(text).warnings.is_empty());
    let text = "TJogPrm a = {3, 4, 0.5}, b; GT_SetJogPrm(2, &a); GT_GetJogPrm(2, &b); GT_SetJogPrm(3, &b);";
    assert_eq!(request::<c::SetJogPrm>(text).dec.get(), 4.0);
    assert!(good(text).warnings.is_empty());
    let text = "TJogPrm jog; GT_GetJogPrm(2, &jog); jog.acc = 1; GT_SetJogPrm(2, &jog);";
    assert!(good(text).warnings[0].message.contains("power-on values"));
}

#[test]
fn sleeps_and_waits() {
    let job = good("Sleep(10); Sleep(0.25); WaitStop(0x3ff); WaitStop(2, 0x80000000, 4);");
    let actions: Vec<&Action> = job.steps.iter().map(|step| &step.action).collect();
    assert_eq!(actions[0], &Action::Sleep { ns: 10_000_000 });
    assert_eq!(actions[1], &Action::Sleep { ns: 250_000 });
    assert_eq!(actions[2], &Action::WaitStop { core: 1, axes: 0xff, crds: 3 });
    assert_eq!(actions[3], &Action::WaitStop { core: 2, axes: 0x8000_0000, crds: 4 });
}

#[test]
fn a_loop_that_reads_and_prints_waits_for_everything() {
    for head in
        ["while(!kbhit())", "while ( ! _kbhit ( ) )", "while(0 == kbhit())", "while(kbhit()==0)", "while(!kbit())"]
    {
        let text = format!(
            "short r; double p;\n{head}\n{{\n r = GTN_GetPrfPos(1, 1, &p);\n printf(\"%f\", p); Sleep(10);\n}}\nGT_AxisOff(1);"
        );
        let job = good(&text);
        assert_eq!(job.steps.len(), 2, "{text}");
        assert_eq!((job.steps[0].line, job.steps[0].column, &job.steps[0].action), (2, 1, &Action::WaitAll));
        assert_eq!(job.warnings.len(), usize::from(head.contains("kbit")));
    }
    assert_eq!(good("while(!kbhit());").steps[0].action, Action::WaitAll);
}

#[test]
fn a_wait_under_an_endless_motion_is_refused() {
    let jog = "TJogPrm j = {1,1,0}; GT_PrfJog(2); GT_SetJogPrm(2,&j);\nGT_SetVel(2, 5);\nGT_Update(1<<1);\n";
    let (line, column, message) = bad(&format!("{jog}while(!kbhit()) {{}}"));
    assert_eq!((line, column), (4, 1));
    assert_eq!(message, "this loop waits until nothing runs, but axis 2 of core 1, started in line 3, runs for ever");
    assert_eq!(good(&format!("{jog}GT_Stop(2, 0); while(!kbhit()) {{}}")).steps.len(), 6);
    assert_eq!(good(&format!("{jog}GT_AxisOff(2); while(!kbhit()) {{}}")).steps.len(), 6);
    assert_eq!(good(&format!("{jog}GT_SetVel(2, 0); while(!kbhit()) {{}}")).steps.len(), 6);
    assert!(good(&format!("{jog}WaitStop(2);")).warnings[0].message.contains("does not stop by itself"));
    let pt = "GTN_PrfPt(1,1); GTN_SetPtLoop(1,1,0); GTN_PtData(1,1,1,1); GTN_PtStart(1,1);\n";
    assert_eq!(bad(&format!("{pt}while(!kbhit());")).0, 2);
    assert_eq!(good(&format!("{pt}GTN_SetPtLoop(1,1,3); while(!kbhit());")).steps.len(), 6);
    // A loop count of another axis, or of dynamic mode, is no matter.
    good("GTN_PrfPt(1,1); GTN_SetPtLoop(1,2,0); GTN_PtStart(1,1); while(!kbhit());");
}

#[test]
fn what_the_manuals_print_around_a_listing_is_accepted() {
    let text = "```c\n#include \"stdafx.h\"\nint main(int argc, char* argv[])\n{\n  short sRtn;\n  ......\n  ……\n  . . .\n  sRtn = GTN_Open();\n  \
         commandhandler(\"GTN_Open\", sRtn);\n  sRtn=GTN_AxisOn（1，1）；// 伺服使能\n  printf(“ok”);\n```\n\n```\n}\nGT_AxisOff(1);\ngetch();\nreturn 0;\n}\n```\n";
    let job = good(text);
    let calls = calls(&job);
    assert_eq!(calls.iter().map(|call| call.function.as_ref()).collect::<Vec<_>>(), ["GTN_AxisOn", "GT_AxisOff"]);
    assert_eq!(job.warnings.len(), 1);
    assert!(job.warnings[0].message.contains("closes nothing"));
    assert_eq!(
        (job.steps[0].line, job.steps[0].column, &text[job.steps[0].span.clone()]),
        (11, 3, "sRtn=GTN_AxisOn（1，1）；")
    );
    good("void commandhandler(char *command, short error)\n{ if(error) printf(\"x\"); }\nGT_AxisOn(1);");
    good("void commandhandler(char *command, short error);\nGT_AxisOn(1);");
}

#[test]
fn misread_names_are_taken_with_a_warning_and_never_guessed() {
    let job = good("GTN_AxisOn(1,1);\n GTN_PrftPt(1,1);");
    assert_eq!(calls(&job)[1].opcode, c::PrfPt::OPCODE);
    assert_eq!((job.warnings[0].line, job.warnings[0].column), (2, 2));
    assert_eq!(job.warnings[0].message, "`GTN_PrftPt` is taken as `GTN_PrfPt`");
    assert_eq!(bad("GTN_PrfxPt(1,1);").2, "there is no function `GTN_PrfxPt`");
    assert!(help("GTN_PrfxPt(1,1);").contains("GTN_PrfPt"));
}

/// As GUS 5.2 is printed: comments that go on in the next line, also after the end of a page.
#[test]
fn comments_that_the_print_has_broken() {
    let job = good(
        "GT_AxisOn(1); // 设置跟随的比率为 0.1%\n// 最小能量为 0%\n    \n```\n\n最大能量为 10%\n\n```\nGT_AxisOn(2); // 激光能量\n    的调整\n 和运动\nGT_AxisOn(3);",
    );
    assert_eq!(calls(&job).len(), 3);
    let places: Vec<_> = job.warnings.iter().map(|warning| (warning.line, warning.column)).collect();
    assert_eq!(places, [(6, 1), (10, 5), (11, 2)]);
    assert_eq!(job.warnings[0].message, "this line is taken as the remainder of the comment above");
    // Names may be Chinese, and what no comment stands before is not one.
    assert_eq!(calls(&good("// 轴\nlong 轴;\n// 一\n轴 = 1;\nGT_AxisOn(轴);")).len(), 1);
    assert_eq!(bad("GT_AxisOn(1);\n的调整\nGT_AxisOn(2);").1, 1);
    assert_eq!(bad("// 激光\nGT_AxisOn(1);\n的调整\n").0, 3);
}

#[test]
fn results_that_a_listing_does_not_declare() {
    let job = good("sRtn = GT_AxisOn(1); sRtn = GT_PtSpace(1, &space);");
    assert_eq!(calls(&job)[1].outs[0].variable, "space");
    assert_eq!(bad("sRtn = 5;"), (1, 1, "`sRtn` is not declared".into()));
}

#[test]
fn pragma_continue_needs_an_assigned_result() {
    let job = good(
        "short r;\nr = GT_AxisOn(1);\n#pragma continue\nr = GT_AxisOn(2);\nGT_AxisOn(3);\n#pragma continue off\nr = GT_AxisOn(4);",
    );
    assert_eq!(calls(&job).iter().map(|call| call.may_fail).collect::<Vec<_>>(), [false, true, false, false]);
}

#[test]
fn what_is_after_return_is_not_executed() {
    let job = good("GT_AxisOn(1); return 0; GT_AxisOff(1);");
    assert_eq!(job.steps.len(), 1);
    assert_eq!(job.warnings[0].message, "after `return` nothing is executed");
}

#[test]
fn cores_and_axes_that_a_job_names() {
    let named = |text: &str| good(text).named.keys().map(|axis| (axis.core, axis.axis)).collect::<Vec<_>>();
    let axis = |axis| job::Axis { core: 1, axis };
    let lines = good("GT_AxisOn(2);\nGT_AxisOn(9);\nWaitStop(0x2);\nGT_AxisOff(9);").named;
    assert_eq!(lines.into_iter().collect::<Vec<_>>(), [(axis(0), 1), (axis(2), 1), (axis(9), 2)], "where first");
    assert_eq!(named("GT_GetDi(4, &x);"), [(1, 0)]);
    assert_eq!(named("GTN_AxisOn(2, 12);"), [(2, 0), (2, 12)]);
    assert_eq!(named("GT_ClrSts(3, 3);"), [(1, 0), (1, 3), (1, 4), (1, 5)]);
    assert_eq!(named("GTN_Update(1, 0x201);"), [(1, 0), (1, 1), (1, 10)]);
    // Bit 8 of the GT form is a coordinate system, of the GTN form an axis.
    assert_eq!(named("GT_Stop(0x101, 0);"), [(1, 0), (1, 1)]);
    assert_eq!(named("GTN_Stop(1, 0x101, 0);"), [(1, 0), (1, 1), (1, 9)]);
    assert_eq!(named("WaitStop(2, 4, 0);"), [(2, 0), (2, 3)]);
    assert_eq!(named("GT_AxisOn(-1); GT_AxisOn(99);"), [(1, -1), (1, 0), (1, 99)]);
    // A count without sense names no more than a controller can have.
    assert!(named("GT_ClrSts(1, 32767);").len() < 100);
}

#[test]
fn axes_that_the_job_uses() {
    let job = good("GTN_PrfPt(2, 3); GT_PrfTrap(1); GT_ZeroPos(4, 2); GT_SetPrfPos(7, 0); GT_AxisOn(8);");
    let axis = |core, axis| Axis { core, axis };
    assert_eq!(job.axes, [axis(1, 1), axis(1, 4), axis(1, 5), axis(1, 7), axis(2, 3)]);
}

#[test]
fn configuration_files_become_items() {
    let files = Memory(HashMap::from([("test.cfg", "[axis.1-8]\nlimits = \"none\"\nalarm = false\nspeed = 1\n")]));
    let job = compile("GTN_LoadConfig(1, “test.cfg”);", &files).unwrap();
    let body = &calls(&job)[0].body;
    let (head, items) = c::LoadConfig::read_from_prefix(body).unwrap();
    assert_eq!((head.core.get(), head.count.get()), (1, 8));
    assert_eq!(items.len(), 8 * size_of::<c::ConfigItem>());
    assert!(job.warnings[0].message.contains("speed"));
    assert_eq!(
        bad("GT_AxisOn(1);\nGT_LoadConfig(\"none.cfg\");"),
        (2, 15, "the configuration file cannot be read: none.cfg: no such file".into())
    );
}

#[test]
fn what_a_path_moves_is_used() {
    let job = good(
        "TCrdPrm crd = {0}; crd.dimension = 2; crd.profile[1] = 1; crd.profile[4] = 2; crd.synVelMax = 1; crd.synAccMax = 1;\n\
         GT_SetCrdPrm(2, &crd); GT_BufMove(2, 7, 100, 1, 1, 0); GT_BufGear(2, 3, 50); GT_CrdStart(2, 0);",
    );
    let axes: Vec<(i16, i16)> = job.axes.iter().map(|axis| (axis.core, axis.axis)).collect();
    assert_eq!(axes, [(1, 2), (1, 3), (1, 5), (1, 7)], "mapped ones, a moved one and a geared one");
    assert_eq!(job.crds, [job::Crd { core: 1, crd: 2 }]);
    let named: Vec<i16> = job.named.keys().map(|axis| axis.axis).collect();
    assert_eq!(named, [0, 2, 3, 5, 7], "the mask of CrdStart names no axes");
}

#[test]
fn more_entries_between_two_motions_than_a_tick_takes_are_warned_of_once() {
    let texts =
        |text: &str| good(text).warnings.iter().map(|found| (found.line, found.message.clone())).collect::<Vec<_>>();
    let io = "GT_BufIO(1, 12, 1, 1, 0);\n";
    let path = |count: usize| format!("GT_LnXY(1, 10, 0, 5, 1, 5);\n{}GT_LnXY(1, 20, 0, 5, 1, 5);\n", io.repeat(count));
    assert_eq!(texts(&path(32)), []);
    let found = texts(&path(80));
    assert_eq!((found.len(), found[0].0), (1, 34), "{found:?}");
    assert!(found[0].1.contains("its path stops here"), "{found:?}");
    // Motions and waits end the count, each FIFO and each coordinate system has its own, and a move
    // counts as four.
    assert_eq!(texts(&format!("{}{}", path(20), path(20))), []);
    assert_eq!(texts(&format!("{0}GT_BufDelay(1, 5, 0);\n{0}", io.repeat(32))), []);
    assert_eq!(texts(&format!("{}{}", io.repeat(32), "GT_BufIO(1, 12, 1, 1, 1); GT_BufIO(2, 12, 1, 1, 0);\n")), []);
    let moves = "GT_BufMove(1, 5, 10, 1, 1, 0, 0);\n";
    assert_eq!(texts(&moves.repeat(8)), []);
    assert_eq!(texts(&moves.repeat(9)).len(), 1);
}

/// A fraction that a whole number loses is said once for each parameter; what C converts is not.
#[test]
fn a_lost_fraction_is_said() {
    let warnings =
        |text: &str| good(text).warnings.iter().map(|found| (found.line, found.message.clone())).collect::<Vec<_>>();
    let is = |parameter: &str, given: &str, taken: i32| {
        format!("`{parameter}` of GT_LnXY is {given}; it is a whole number, and {taken} is taken")
    };
    let text = "GT_LnXY(1, 1000.7, 5, 10.5, 1);\nGT_LnXY(1, 8.5, -5.5, 10, 1);\nGT_LnXY(1, 9.5, 5, 10, 1);";
    assert_eq!(warnings(text), [(1, is("x", "1000.7", 1000)), (2, is("y", "-5.5", -5))]);
    assert_eq!(warnings("long x = 10 / 4.0;\nGT_LnXY(1, x, (long)2.5, 10, 1);\nGT_LnXY(1, 6.0, 1e3, 10, 1);"), []);
    assert_eq!(request::<c::LnXY>("GT_LnXY(1, 1000.7, 5, 10, 1);").x.get(), 1000);
    // What a sum of decimals leaves is no loss; the whole number below the one that was meant is.
    assert_eq!(warnings("GT_LnXY(1, (0.1 + 0.2) * 10, -2.0000000001, 10, 1);"), []);
    assert_eq!(warnings("GT_LnXY(1, 1000 * sin(M_PI / 6), 5, 10, 1);"), [(1, is("x", "499.99999999999994", 499))]);
}

/// Bits of an option that say something of nothing.
#[test]
fn bits_of_an_option_without_their_mask_are_said() {
    for (call, stray) in [
        ("GT_CrdStart(1, 2);", "0x2"),
        ("GT_CrdStart(2, 3);", "0x1"),
        ("GT_Stop(0x100, 1);", "0x1"),
        ("GTN_CrdStop(1, 1, 2);", "0x2"),
        ("GTN_PtStart(1, 1, 6);", "0x6"),
        ("GTN_FollowStart(1, 4, 1);", "0x1"),
    ] {
        let job = good(call);
        let [warning] = &job.warnings[..] else { panic!("{call}: {:?}", job.warnings) };
        assert!(warning.message.starts_with(&format!("bits {stray} of `option` do nothing")), "{}", warning.message);
    }
    for call in
        ["GT_CrdStart(1, 1);", "GT_CrdStart(3, 2);", "GT_Stop(3, 2);", "GT_CrdStart(1);", "GTN_PtStart(1, 255, 255);"]
    {
        assert!(good(call).warnings.is_empty(), "{call}");
    }
}
