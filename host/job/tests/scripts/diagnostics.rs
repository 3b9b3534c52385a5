//! Diagnostics: where they point, and what they say.
use super::*;

/// Script, line, column, what the message says.
const WRONG: &[(&str, u32, u32, &str)] = &[
    ("GTN_AxisOn(1,1);\n  GTN_PrfXyz(1,1);", 2, 3, "there is no function `GTN_PrfXyz`"),
    ("PtData(1, 2, 3);", 1, 1, "there is no function `PtData`"),
    ("GTN_PtData(1, 1, 5.0);", 1, 1, "GTN_PtData needs 4 parameters, 3 are given: `time` is missing"),
    ("GTN_AxisOn();", 1, 1, "GTN_AxisOn needs 2 parameters, 0 are given: `core` is missing"),
    ("GT_AxisOn();", 1, 1, "GT_AxisOn needs 1 parameters, 0 are given: `axis` is missing"),
    ("GT_AxisOn(1, 2);", 1, 14, "GT_AxisOn takes at most 1 parameters, 2 are given"),
    ("short r;\nr = GT_SetPrfPos(1, 3000000000);", 2, 21, "`pos` of GT_SetPrfPos: 3000000000 does not fit a long"),
    ("GT_AxisOn(40000);", 1, 11, "`axis` of GT_AxisOn: 40000 does not fit a short"),
    ("GT_SetPrfPos(1, NAN);", 1, 17, "`pos` of GT_SetPrfPos: not a number does not fit a long"),
    ("short s = 32768;", 1, 11, "32768 does not fit a short"),
    ("long x = 2147483647; x += 1;", 1, 22, "2147483648 does not fit a long"),
    ("long x = 1/0;", 1, 10, "division by zero"),
    ("long x = 1.5 | 2;", 1, 10, "`|` needs integers"),
    ("long x = 1 << 40;", 1, 10, "a shift by 40"),
    ("GT_PtData(1, speed, 5);", 1, 14, "`speed` is not declared"),
    ("double pos;\nGT_PtData(1, pos, 5);", 2, 14, "`pos` has no value yet"),
    ("short s; GT_PtSpace(1, &s);\nGT_PtData(1, s, 5);", 2, 14, "`s` is filled by GT_PtSpace in line 1"),
    ("short s; GT_PtSpace(1, s);", 1, 24, "`s` has no value yet"),
    ("short s = 1; GT_PtSpace(1, s);", 1, 28, "`space` of GT_PtSpace is the address of a variable"),
    ("double v[4]; GT_GetPrfPos(1, v, 8);", 1, 30, "`v` has room for 4 values from here on, 8 are asked for"),
    ("double v[4]; v[4] = 1;", 1, 14, "index 4 is outside the array"),
    ("double v[2] = {1, 2, 3};", 1, 8, "3 values are given, `v` holds 2"),
    ("TJogPrm j; j.acc = 1;\nGT_SetJogPrm(1, &j);", 2, 17, "`j.dec` has no value yet"),
    ("TCrdPrm c; c.dimension = 1; c.profile[0] = 1;\nGT_SetCrdPrm(1, &c);", 2, 17, "`c.profile[1]` has no value yet"),
    ("TJogPrm j; j.speed = 1;", 1, 12, "TJogPrm has no field speed"),
    ("TTrapPrm t = {1,1,1,1};\nGT_SetJogPrm(1, &t);", 2, 17, "`prm` of GT_SetJogPrm is the address of a TJogPrm"),
    ("if (1) { GT_AxisOn(1); } else { GT_AxisOff(1); }", 1, 1, "`if` is not available in job scripts"),
    ("for (i = 0; i < 3; i++) { GT_AxisOn(1); }", 1, 1, "`for` is not available in job scripts"),
    ("while(1) { GT_AxisOn(1); }", 1, 1, "`while(1)` is not available in job scripts"),
    ("while(!kbhit())\n{ GT_AxisOn(1); }", 2, 3, "GT_AxisOn does more than read"),
    ("while(!kbhit())\n{ if (1) {} }", 2, 3, "`if` is not allowed in a while(!kbhit()) loop"),
    ("do { } while(1);", 1, 1, "`do` is not available"),
    ("GT_AxisOn(1);\n /* open", 2, 2, "this comment does not end"),
    ("printf(\"open);\n", 1, 8, "this text does not end on its line"),
    ("GT_AxisOn(1)\nGT_AxisOff(1);", 1, 12, "`;` is missing after the call"),
    ("GT_AxisOn(1;", 1, 12, "`)` is missing to close the call"),
    ("int main() { GT_AxisOn(1);", 1, 12, "this { is not closed"),
    ("#define F(x) x\n", 1, 1, "`F` is a macro with parameters"),
    ("#ifdef A\n", 1, 1, "#ifdef is not available"),
    ("short helper(short x) { return x; }", 1, 7, "`helper` is a function of its own"),
    ("TFoo x;", 1, 1, "`TFoo` is neither a type nor a call"),
    ("GT_PtData(1, 1 < 2, 3);", 1, 16, "`<` is not available"),
    ("GT_AxisOn(1); $", 1, 15, "this character has no meaning"),
    ("Sleep(-1);", 1, 1, "Sleep takes 0 to 4294967295 ms"),
    ("WaitStop(0x400);", 1, 1, "bits 0 to 7 are axes"),
    ("WaitStop(1, 2);", 1, 1, "WaitStop takes 1 or 3 parameters"),
    ("GT_LoadConfig(5);", 1, 15, "`file` of GT_LoadConfig is a text in quotation marks"),
    ("short a[2] = {33, 1}; GTN_PtStartPro(1, a, a, 2);", 1, 23, "axis 33 with FIFO 33"),
    ("short a[1] = {1}; GTN_PtStartPro(1, a, a, 0);", 1, 19, "`count` is 0; it must be from 1 to 32"),
    (
        "short a[2] = {2, 2}; short o[2] = {0, 1}; GTN_PtStartPro(1, a, o, 2);",
        1,
        43,
        "axis 2 is listed twice, with different FIFOs",
    ),
];

#[test]
fn wrong_scripts_show_line_column_and_message() {
    for (text, line, column, message) in WRONG {
        let found = bad(text);
        assert!(found.2.contains(message), "{text}\nsays {:?}, not {message:?}", found.2);
        assert_eq!((found.0, found.1), (*line, *column), "{text}");
    }
}

#[test]
fn loops_are_refused_with_the_way_out() {
    for text in ["for(;;){}", "while(1){}", "if(1){}", "switch(1){}"] {
        assert!(help(text).contains("C library"), "{text}");
    }
}

#[test]
fn all_errors_of_a_script_are_shown_in_order() {
    let found =
        compile("GT_No(1);\nGT_AxisOn();\nif (1) { GT_No2(); }\nGT_AxisOn(x);\n", &Memory::default()).unwrap_err();
    assert_eq!(found.iter().map(|found| found.line).collect::<Vec<_>>(), [1, 2, 3, 4]);
}

#[test]
fn hostile_text_neither_panics_nor_hangs() {
    let deep = "(".repeat(10_000);
    assert!(bad(&format!("long x = {deep}1;")).2.contains("nested too deeply"));
    assert!(bad(&"(void)".repeat(10_000)).2.contains("nested too deeply"));
    assert!(bad(&format!("double x[3] = {};", "{".repeat(10_000))).2.contains("nested too deeply"));
    let doubling: String = (1..60).map(|step| format!("#define A{step} A{} A{}\n", step - 1, step - 1)).collect();
    assert!(compile(&format!("#define A0 ;\n{doubling}A59"), &Memory::default()).is_err());
    for text in [
        "",
        ";",
        "}",
        "\u{feff}",
        "/",
        "\"",
        "'",
        "#",
        "#define",
        "GT_",
        "GT_AxisOn",
        "x=",
        "&",
        "1.2.3",
        "while",
        "while(",
        "{{{{",
        "short",
        "short x[",
        "\0",
    ] {
        let _ = compile(text, &Memory::default());
    }
}

#[test]
fn a_diagnostic_shows_file_position_and_source() {
    let text = "short r;\nr = GTN_AxisOn(1);\n";
    let found = compile(text, &Memory::default()).unwrap_err();
    let shown = job::render(&found[0], "jobs/a.gts", text, false);
    for part in ["jobs/a.gts:2:5", "r = GTN_AxisOn(1);", "needs 2 parameters", "GTN_AxisOn(core, axis)"] {
        assert!(shown.contains(part), "{part:?} is not in\n{shown}");
    }
}
