//! Calls with arrays at and beyond every limit of their length, made of the table of functions: one
//! text for each, which is C and a job script alike. Used by the tests of the C library and of
//! `beamtick`.

use job::api::{FUNCTIONS, Function, Pass};
use std::fmt::Write;

/// One call.
pub struct Length {
    /// Function, and the lengths.
    pub name: String,
    /// Declarations.
    pub data: String,
    /// Calls before it, each of which returns 0.
    pub before: &'static str,
    /// The call itself, without an assignment.
    pub call: String,
    /// Calls after it.
    pub after: &'static str,
    /// What it returns.
    pub code: i16,
}

/// Lengths around those at which a message of any layout is full.
const PVT: [usize; 15] = [0, 1, 2, 20, 21, 30, 31, 40, 41, 42, 43, 60, 61, 1024, 1025];
const LINES: [usize; 9] = [0, 1, 2, 19, 20, 21, 31, 32, 33];
/// Columns and rows of a plane; 256 nodes fit.
const PLANES: [[usize; 2]; 12] =
    [[0, 1], [1, 0], [1, 1], [8, 8], [10, 10], [16, 16], [32, 8], [8, 32], [33, 1], [1, 33], [32, 9], [17, 16]];

/// For `SetLaserDisMode`.
const DISTANCE: &str = "long origin[4] = {0, 0, 0, 0};\ndouble scale[4] = {1000, 1000, 1000, 1000};\n";

fn array(of: &str, name: &str, values: impl ExactSizeIterator<Item = f64>) -> String {
    // C has no array without elements; one that is not looked at stands for it.
    let length = values.len().max(1);
    let list: Vec<String> = values.map(|value| value.to_string()).collect();
    let list = if list.is_empty() { "0".to_owned() } else { list.join(",") };
    format!("{of} {name}[{length}] = {{{list}}};\n")
}

fn steady(of: &str, name: &str, count: usize, value: f64) -> String {
    array(of, name, (0..count).map(move |_| value))
}

fn rising(of: &str, name: &str, count: usize, step: f64) -> String {
    array(of, name, (0..count).map(move |n| n as f64 * step))
}

/// Axes that go on at 1 pulse/ms from point to point, so that every description takes one place a
/// point.
fn pvt(name: &str, count: usize) -> Length {
    let arguments = match name {
        "PvtTable" => "1, N, t, p, v",
        "PvtTableEx" => "1, N, t, p, v, w",
        "PvtTableComplete" => "1, N, t, p, out, out, out, 1, 1",
        "PvtTablePercent" => "1, N, t, p, c, 1",
        "PvtPercentCalculate" => "N, t, p, c, 1, out",
        "PvtTableContinuous" => "1, N, p, v, c, w, v, w, 0",
        _ => "N, p, v, c, w, v, w, out",
    };
    let mut data = String::new();
    for array in
        ["t", "p", "v", "w", "c", "out"].into_iter().filter(|array| arguments.split(", ").any(|used| used == *array))
    {
        data += &match array {
            "t" | "p" => rising("double", array, count, 10.0),
            "v" | "w" => steady("double", array, count, 1.0),
            _ => steady("double", array, count, 0.0),
        };
    }
    let call = format!("GTN_{name}(1, {})", arguments.replace('N', &count.to_string()));
    let code = if (2..=1024).contains(&count) { 0 } else { 7 };
    Length { name: format!("{name} of {count}"), data, before: "", call, after: "", code }
}

fn of(function: &Function) -> Vec<Length> {
    let name = function.name;
    let reset = "GTN_Reset(1);\n";
    let laser = "GTN_Reset(1);\nGTN_SetLaserDisMode(1, 1, 0, origin, scale, 0);\n";
    let make = |count: usize, most: usize, data: String, before, call: String, after| Length {
        name: format!("{name} of {count}"),
        data,
        before,
        call,
        after,
        code: if (1..=most).contains(&count) { 0 } else { 7 },
    };
    match name {
        name if name.starts_with("Pvt") => PVT.map(|count| pvt(name, count)).into(),
        // Eight on the virtual controller.
        "SetDac" => [0, 1, 8, 9, 32, 33]
            .map(|count| {
                let data = steady("short", "value", count, 5.0);
                make(count, 8, data, reset, format!("GTN_SetDac(1, 1, value, {count})"), "")
            })
            .into(),
        // No product that is shown by itself has more than a word.
        "SetDoEx" => [0, 1, 2, 4, 5]
            .map(|count| {
                let data = steady("long", "value", count, 5.0);
                make(count, 1, data, reset, format!("GTN_SetDoEx(1, 12, value, {count})"), "")
            })
            .into(),
        "SetDiReverseCount" => [0, 1, 2, 8, 9]
            .map(|count| {
                let data = steady("unsigned long", "value", count, 5.0);
                make(count, 8, data, reset, format!("GTN_SetDiReverseCount(1, 4, 1, value, {count})"), "")
            })
            .into(),
        "PtStartPro" => [0, 1, 2, 32, 33]
            .map(|count| {
                let data = steady("short", "axis", count, 1.0) + &steady("short", "option", count, 0.0);
                let before = "GTN_Reset(1);\nGTN_AxisOn(1, 1);\nGTN_PrfPt(1, 1, 0);\nGTN_PtClear(1, 1, 0);\nGTN_PtData(1, 1, 2, 2, 0, 0);\nSleep(2);\n";
                make(count, 32, data, before, format!("GTN_PtStartPro(1, axis, option, {count})"), "Sleep(9);\n")
            })
            .into(),
        "SetLaserFollowTable" => LINES
            .map(|count| {
                let data = rising("double", "vel", count, 1.0) + &steady("double", "power", count, 50.0);
                make(count, 32, data, reset, format!("GTN_SetLaserFollowTable(1, 1, {count}, vel, power, 0)"), "")
            })
            .into(),
        "SetLaserDisTable1D" => LINES
            .map(|count| {
                let mut data = DISTANCE.to_owned() + &steady("double", "ratio", 4 * count, 0.5);
                data += &array("long", "pos", (0..4 * count).map(|n| (n % count) as f64));
                let call = format!("GTN_SetLaserDisTable1D(1, {count}, ratio, pos, 0, 100, 0, 0)");
                make(count, 32, data, laser, call, "Sleep(2);\n")
            })
            .into(),
        "SetLaserDisTable2D" => PLANES
            .map(|[columns, rows]| {
                let mut data = format!("{DISTANCE}short axes[2] = {{1, 2}};\n");
                let _ = writeln!(data, "short counts[2] = {{{columns}, {rows}}};");
                data += &rising("long", "x", columns, 10.0);
                data += &rising("long", "y", rows, 10.0);
                data += &steady("double", "ratio", columns * rows, 0.5);
                let call = "GTN_SetLaserDisTable2D(1, axes, counts, ratio, x, y, 0, 100, 0, 0)".to_owned();
                let fits = (1..=32).contains(&columns) && (1..=32).contains(&rows) && columns * rows <= 256;
                let code = if fits { 0 } else { 7 };
                Length { name: format!("{name} of {columns} by {rows}"), data, before: laser, call, after: "Sleep(2);\n", code }
            })
            .into(),
        _ => panic!("{name} reads arrays: say here what lengths it takes"),
    }
}

/// All of them, by function.
pub fn all() -> Vec<Vec<Length>> {
    let reads_arrays = |function: &&Function| function.params.iter().any(|param| matches!(param.pass, Pass::Many(..)));
    FUNCTIONS.iter().filter(reads_arrays).map(of).collect()
}
