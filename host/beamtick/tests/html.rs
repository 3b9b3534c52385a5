//! `--html` and `--panels`: what the page holds, and that its script draws it.
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::Command;

fn beamtick(folder: &Path, words: &[&str]) -> (String, String, i32) {
    let out = Command::new(env!("CARGO_BIN_EXE_beamtick")).args(words).current_dir(folder).output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (text(&out.stdout), text(&out.stderr), out.status.code().unwrap())
}

/// The data of a page.
fn data(page: &str) -> Value {
    let begin = page.split_once("id=\"data\">").unwrap().1;
    serde_json::from_str(begin.split_once("</script>").unwrap().0).unwrap()
}

/// Times and values of the first line of the panel of this caption.
fn line(data: &Value, caption: &str) -> Vec<(f64, f64)> {
    let panels = data["panels"].as_array().unwrap();
    let panel =
        panels.iter().find(|panel| panel["caption"] == caption).unwrap_or_else(|| panic!("{caption}: {panels:?}"));
    let numbers: Vec<f64> =
        panel["lines"][0].as_array().unwrap().iter().map(|number| number.as_f64().unwrap()).collect();
    numbers.chunks(2).map(|pair| (pair[0], pair[1])).collect()
}

const JOB: &str = "double p[2]; double e[2];\nGT_AxisOn(1);\nGT_PrfTrap(1);\nGT_AxisOn(2);\nGT_PrfTrap(2);\n\
                   TTrapPrm prm = {0.5, 0.25, 0, 0};\nGT_SetTrapPrm(1,&prm);\nGT_SetTrapPrm(2,&prm);\nGT_SetVel(1,10);\n\
                   GT_SetVel(2,5);\nGT_SetPos(1,1000);\nGT_SetPos(2,-300);\nGT_Update(3);\nSleep(30);\nGT_GetPrfPos(1,&p[0]);\n\
                   GT_GetEncPos(1,&e[0]);\nSleep(40);\nGT_GetPrfPos(1,&p[1]);\nGT_GetEncPos(1,&e[1]);\nWaitStop(3);\nSleep(20);\n";

#[test]
fn a_page_holds_the_panels_and_needs_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("j.gts"), JOB).unwrap();
    let words = ["sim", "j.gts", "--json", "--html", "t.html", "--panels", "acceleration,error", "--trace", "t.csv"];
    let (said, errors, code) = beamtick(folder.path(), &words);
    assert_eq!(code, 0, "{errors}");
    let page = fs::read_to_string(folder.path().join("t.html")).unwrap();
    let data_of = data(&page);
    // One file: nothing of another site, and no other file. The name space of SVG is a name only.
    let other = page.replace("http://www.w3.org/2000/svg", "");
    assert!(!["http:", "https:", " src=", " href=", "@import", "url("].iter().any(|part| other.contains(part)));
    assert!(page.contains("<div id=\"path\"><svg") && page.contains("axis 2 position (pulse)"));
    // Every row is in it.
    let position = line(&data_of, "axis 1 position (pulse)");
    let rows = fs::read_to_string(folder.path().join("t.csv")).unwrap().lines().count() - 1;
    assert_eq!((position.len(), position[position.len() - 1].1), (rows, 1000.0));
    // The accelerations that were set, and no other but where one ends within a row.
    let acceleration = line(&data_of, "axis 1 acceleration (pulse/ms²)");
    for (from, to, wanted) in [(1.0, 19.0, 0.5), (22.0, 88.0, 0.0), (92.0, 128.0, -0.25)] {
        let within: Vec<f64> = acceleration.iter().filter(|(t, _)| *t > from && *t < to).map(|(_, a)| *a).collect();
        assert!(!within.is_empty() && within.iter().all(|a| (a - wanted).abs() < 1e-4), "{wanted}: {within:?}");
    }
    // The following error is what the controller's own encoders say.
    let error = line(&data_of, "axis 1 following error (pulse)");
    let reads: Value = serde_json::from_str(&said).unwrap();
    let read = |index: usize| reads["reads"][index]["values"].as_str().unwrap().parse::<f64>().unwrap();
    for (planned, encoder) in [(read(0), read(1)), (read(2), read(3))] {
        let at = position.iter().position(|(_, p)| (p - planned).abs() < 1e-5).unwrap();
        let (t, found) = error.iter().find(|(t, _)| *t == position[at].0).unwrap();
        assert!((found - (planned - encoder)).abs() < 1e-5 && *found > 1.0, "{t} ms: {found}, {planned} - {encoder}");
    }
    // A trace that was kept gives the same positions.
    let (_, errors, code) = beamtick(folder.path(), &["plot", "t.csv", "--html", "k.html", "--panels", "error"]);
    assert_eq!(code, 0, "{errors}");
    let kept = data(&fs::read_to_string(folder.path().join("k.html")).unwrap());
    let near = |a: &[(f64, f64)], b: &[(f64, f64)]| {
        a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.0 == b.0 && (a.1 - b.1).abs() < 1e-5)
    };
    assert!(near(&line(&kept, "axis 1 position (pulse)"), &position));
    assert!(near(&line(&kept, "axis 1 following error (pulse)"), &error));
    // Pictures have the panels on request, too.
    let words = ["sim", "j.gts", "--plot", "t.svg", "--panels", "acceleration"];
    assert_eq!(beamtick(folder.path(), &words).2, 0);
    let drawn = fs::read_to_string(folder.path().join("t.svg")).unwrap();
    assert!(drawn.contains("axis 1 acceleration") && !drawn.contains("following error"));
}

#[test]
fn what_a_page_cannot_be_is_said_before_the_job_runs() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("j.gts"), JOB).unwrap();
    for (words, says) in [
        (&["--html", "t.svg"][..], "t.svg: a page's name ends with .html"),
        (
            &["--html", "t.html", "--panels", "error", "--every", "2"],
            "--panels error needs a row each tick, and --every is 2",
        ),
        (&["--html", "j.gts"], "would overwrite a file"),
        (&["--panels", "error"], "required arguments were not provided"),
        (&["--html", "t.html", "--panels", "torque"], "invalid value 'torque'"),
    ] {
        let (_, errors, code) = beamtick(folder.path(), &[&["sim", "j.gts"], words].concat());
        assert!(code == 2 && errors.contains(says), "{words:?}: {errors}");
        assert!(!folder.path().join("t.html").exists());
    }
}

/// A document that notes what is drawn, the page's script in it, and what a user does.
const HARNESS: &str = r#"
const fs = require("fs"), page = fs.readFileSync(process.argv[1], "utf8");
const data = page.split('id="data">')[1].split("</script>")[0];
const script = page.split("<script>\n")[1].split("</script>")[0];
const texts = [], canvases = [], heard = {};
let points = 0;
const context = new Proxy({}, { get: (_, name) => (...given) => {
  if (name === "fillText") texts.push(given[0]);
  if (name === "lineTo" || name === "fillRect") {
    if (given.some((n) => !Number.isFinite(n))) throw new Error(name + " " + given);
    points++;
  }
}, set: () => true });
const canvas = () => { const own = { style: {}, clientWidth: 800, clientHeight: 180, on: {}, getContext: () => context,
  addEventListener: (name, does) => { own.on[name] = does; }, setPointerCapture: () => {} }; canvases.push(own); return own; };
globalThis.window = { devicePixelRatio: 1, addEventListener: (name, does) => { heard[name] = does; } };
globalThis.document = { createElement: canvas, querySelector: () => null,
  getElementById: (id) => id === "data" ? { textContent: data } : { appendChild: () => {} } };
new Function(script)();
const first = texts.length;
const act = (name, event) => canvases[0].on[name]({ preventDefault: () => {}, ...event });
for (let n = 0; n < 20; n++) act("wheel", { offsetX: 300, deltaY: -1 });
act("pointerdown", { offsetX: 300, pointerId: 1 }); act("pointermove", { offsetX: 250 }); act("pointerup", {});
const close = texts.slice(-6);
act("dblclick", {});
for (const key of ["+", "-", "0", "ArrowLeft", "ArrowRight"]) heard.keydown({ key, preventDefault: () => {} });
console.log(JSON.stringify({ canvases: canvases.length, first, points, close }));
"#;

#[test]
fn the_script_of_the_page_draws_and_enlarges() {
    let folder = tempfile::tempdir().unwrap();
    let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples");
    if Command::new("node").arg("--version").output().is_err() {
        eprintln!("skipped: there is no node");
        return;
    }
    // Axes, a path, a laser with pulses, and power.
    let html = folder.path().join("t.html");
    let (_, errors, code) =
        beamtick(Path::new(root), &["sim", "laser_flying_shear.gts", "--quiet", "--html", html.to_str().unwrap()]);
    assert_eq!(code, 0, "{errors}");
    let out = Command::new("node").args(["-e", HARNESS]).arg(&html).output().unwrap();
    let said = String::from_utf8_lossy(&out.stdout);
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    let found: Value = serde_json::from_str(&said).unwrap();
    let panels = data(&fs::read_to_string(&html).unwrap())["panels"].as_array().unwrap().len();
    assert_eq!(found["canvases"].as_u64(), Some(panels as u64));
    assert!(found["first"].as_u64() > Some(20) && found["points"].as_u64() > Some(1000), "{found}");
    // With the pointer over it a panel says the value there.
    assert!(
        found["close"]
            .as_array()
            .unwrap()
            .iter()
            .any(|text| text.as_str().is_some_and(|text| text.starts_with("t = ")))
    );
}
