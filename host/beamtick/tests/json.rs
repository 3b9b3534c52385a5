//! `--json`: one object on the standard output, of the same facts as the text (docs/json.md).
use serde_json::Value;
use std::fs;
use std::path::Path;
use std::process::Command;

const ROOT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");

/// What a command prints: the object, the error stream, the code.
fn object(folder: &Path, words: &[&str]) -> (Value, String, i32) {
    let out = Command::new(env!("CARGO_BIN_EXE_beamtick")).args(words).current_dir(folder).output().unwrap();
    let text = String::from_utf8_lossy(&out.stdout);
    let object = serde_json::from_str(&text).unwrap_or_else(|error| panic!("{words:?}: {error}: {text}"));
    (object, String::from_utf8_lossy(&out.stderr).into_owned(), out.status.code().unwrap())
}

/// The same without `--json`.
fn text(folder: &Path, words: &[&str]) -> String {
    let out = Command::new(env!("CARGO_BIN_EXE_beamtick")).args(words).current_dir(folder).output().unwrap();
    String::from_utf8_lossy(&out.stdout).into_owned()
}

/// Whether an object has the keys that its schema requires, and no other; of arrays each element.
fn fits(schema: &Value, whole: &Value, value: &Value, at: &str) {
    let resolved = match schema.get("$ref").and_then(Value::as_str) {
        Some(name) => whole.pointer(name.trim_start_matches('#')).unwrap_or_else(|| panic!("{at}: {name}")),
        None => schema,
    };
    if let Some(choices) = resolved.get("anyOf").and_then(Value::as_array) {
        if value.is_null() {
            return;
        }
        let keys = |schema: &Value| {
            let target = schema.get("$ref").and_then(Value::as_str).map(|name| name.trim_start_matches('#'));
            let schema = target.and_then(|name| whole.pointer(name)).unwrap_or(schema);
            schema.get("properties").and_then(Value::as_object).map(|keys| keys.keys().cloned().collect::<Vec<_>>())
        };
        let own: Vec<String> = value.as_object().map(|own| own.keys().cloned().collect()).unwrap_or_default();
        let mut sorted = own.clone();
        sorted.sort();
        let nested = choices.iter().find(|choice| {
            keys(choice).is_some_and(|mut keys| {
                keys.sort();
                keys == sorted
            })
        });
        let nested = nested.or_else(|| {
            choices.iter().find(|choice| choice.get("$ref").is_some_and(|name| name.as_str() != Some("null")))
        });
        return fits(nested.unwrap_or_else(|| panic!("{at}: no choice fits {own:?}")), whole, value, at);
    }
    match value {
        Value::Object(object) => {
            let Some(known) = resolved.get("properties").and_then(Value::as_object) else {
                panic!("{at}: an object, and the schema has {resolved}")
            };
            for (key, value) in object {
                let schema = known.get(key).unwrap_or_else(|| panic!("{at}: `{key}` is not in the schema"));
                fits(schema, whole, value, &format!("{at}.{key}"));
            }
            for key in resolved.get("required").and_then(Value::as_array).into_iter().flatten() {
                assert!(object.contains_key(key.as_str().unwrap()), "{at}: `{key}` is missing");
            }
        }
        Value::Array(items) => {
            let Some(of) = resolved.get("items") else { return };
            items.iter().for_each(|item| fits(of, whole, item, &format!("{at}[]")));
        }
        _ => {}
    }
}

fn fits_the_schema(object: &Value) {
    let schema: Value =
        serde_json::from_str(&fs::read_to_string(format!("{ROOT}/docs/json.schema.json")).unwrap()).unwrap();
    fits(&schema, &schema, object, "");
    assert_eq!(object["schema"], "beamtick-1");
}

#[test]
fn info_says_the_same_in_both_forms() {
    let folder = tempfile::tempdir().unwrap();
    let (found, errors, code) = object(folder.path(), &["info", "--json"]);
    fits_the_schema(&found);
    assert_eq!((code, errors.as_str(), &found["exit_code"], &found["error"]), (0, "", &0.into(), &Value::Null));
    let (info, said) = (&found["result"], text(folder.path(), &["info"]));
    assert_eq!(
        (&info["board"], &info["profile"], &info["lasers"][1]["channel"]),
        (&"virtual".into(), &"gus".into(), &1.into())
    );
    for part in [
        format!("controller  {} over", info["board"].as_str().unwrap()),
        format!("counts      {} core of {} axes", info["cores"], info["axes_of_a_core"]),
        format!("schema {:#010x}", info["schema_hash"].as_u64().unwrap()),
        format!("servo tick  {} us", info["servo_tick"]["period_us"].as_f64().unwrap()),
    ] {
        assert!(said.contains(&part), "{part}: {said}");
    }
    assert_eq!(info["servo_tick"]["period_us"], 250.0);
}

#[test]
fn a_job_has_its_reads_its_axes_and_its_end() {
    let folder = tempfile::tempdir().unwrap();
    let job = "double pos[2]; long sts;\nGT_AxisOn(1);\nGT_PrfTrap(1);\nTTrapPrm prm = {1, 1, 0, 0};\nGT_SetTrapPrm(1,&prm);\n\
               GT_SetVel(1,10);\nGT_SetPos(1,1000);\nGT_Update(1);\nWaitStop(1);\nGT_GetPrfPos(1,&pos[0]);\nGT_GetSts(1,&sts);\n";
    fs::write(folder.path().join("j.gts"), job).unwrap();
    let (found, errors, code) = object(folder.path(), &["sim", "j.gts", "--json", "--trace", "t.csv"]);
    fits_the_schema(&found);
    assert_eq!((code, errors.as_str()), (0, ""));
    let read = &found["reads"][0];
    assert_eq!((&read["line"], &read["call"], &read["values"]), (&10.into(), &"GT_GetPrfPos".into(), &"1000".into()));
    assert_eq!(read["variables"][0], "pos[0]");
    let result = &found["result"];
    let axis = &result["axes"][0];
    assert_eq!((axis["planned"].as_f64(), &axis["end"]), (Some(1000.0), &"motion completed".into()));
    assert!((axis["peak_velocity"].as_f64().unwrap() - 10.0).abs() < 1e-6, "{axis}");
    assert_eq!((&result["late"]["count"], &result["servo_tick_us"]), (&0.into(), &250.into()));
    assert!(result["trace"]["rows"].as_u64().unwrap() > 100 && result["simulated_s"].as_f64().unwrap() > 0.0);
    // The text is made of the same.
    let said = text(folder.path(), &["sim", "j.gts", "--trace", "t.csv"]);
    let clock =
        format!("script clock {:.3} ms, {} entries", result["script_clock_ms"].as_f64().unwrap(), result["entries"]);
    for part in [clock.as_str(), "axis 1: planned 1000.000000, encoder 1000.000000 pulses, peak velocity 10.0"] {
        assert!(said.contains(part), "{part}: {said}");
    }
}

#[test]
fn check_has_steps_of_a_job_and_the_path_of_a_program() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("j.gts"), "GT_PrfTrap(2);\nSleep(5);\nWaitStop(2);\nSleep(1);\nGT_AxisOff(2);\n")
        .unwrap();
    let (found, _, code) = object(folder.path(), &["check", "j.gts", "--json"]);
    fits_the_schema(&found);
    let result = &found["result"];
    assert_eq!(
        (code, &result["step_count"], &result["axes"][0], &result["path"]),
        (0, &5.into(), &"1.2".into(), &Value::Null)
    );
    let last = &result["steps"][4];
    assert_eq!((&last["line"], &last["waits_before"], last["clock_ms"].as_f64()), (&5.into(), &1.into(), Some(1.0)));
    for file in ["machine.toml", "square.nc"] {
        fs::copy(format!("{ROOT}/examples/{file}"), folder.path().join(file)).unwrap();
    }
    let (found, _, code) = object(folder.path(), &["check", "square.nc", "--machine", "machine.toml", "--json"]);
    fits_the_schema(&found);
    let path = &found["result"]["path"];
    assert!(
        code == 0 && path["length_mm"].as_f64() > path["marks_mm"].as_f64() && path["seconds"].as_f64() > Some(1.0)
    );
    assert_eq!(path["covers"][0]["letter"], "X");
}

#[test]
fn errors_have_their_place() {
    let folder = tempfile::tempdir().unwrap();
    // A job that does not compile.
    fs::write(folder.path().join("j.gts"), "GT_AxisOn(1);\nGT_Nothing(1);\n").unwrap();
    let (found, errors, code) = object(folder.path(), &["sim", "j.gts", "--json"]);
    fits_the_schema(&found);
    let message = &found["messages"][0];
    assert_eq!((code, &found["exit_code"], &found["result"]), (2, &2.into(), &Value::Null));
    assert_eq!(
        (&message["severity"], &message["file"], &message["line"]),
        (&"error".into(), &"j.gts".into(), &2.into())
    );
    assert!(found["error"]["kind"] == "input" && errors.contains("GT_Nothing"), "{errors}");
    // A call that is refused.
    fs::write(folder.path().join("j.gts"), "GT_AxisOn(1);\nGT_AxisOn(99);\n").unwrap();
    let (found, _, code) = object(folder.path(), &["sim", "j.gts", "--json"]);
    fits_the_schema(&found);
    assert_eq!((code, &found["error"]["kind"], &found["messages"][0]["line"]), (1, &"job".into(), &2.into()));
    assert!(found["messages"][0]["text"].as_str().unwrap().starts_with("GT_AxisOn returned 7"), "{found}");
    // A file that is not there, a note of a drawing, a port where nobody is.
    let (found, _, code) = object(folder.path(), &["check", "none.gts", "--json"]);
    assert!(code == 2 && found["error"]["text"].as_str().unwrap().contains("none.gts"), "{found}");
    let (found, _, code) = object(folder.path(), &["info", "--link", "tcp:127.0.0.1:1", "--json"]);
    assert!(code == 1 && found["error"]["kind"] == "job" && found["command"] == "info", "{found}");
    for file in ["machine.toml", "badge.svg"] {
        fs::copy(format!("{ROOT}/examples/{file}"), folder.path().join(file)).unwrap();
    }
    let words =
        ["check", "badge.svg", "--machine", "machine.toml", "--layer", "colour=#123456,power=1,speed=600", "--json"];
    let (found, _, code) = object(folder.path(), &words);
    fits_the_schema(&found);
    let note = &found["messages"][0];
    assert!(code == 0 && note["severity"] == "note" && note["file"] == "badge.svg", "{found}");
}

/// The signal that ended a job is named, with what there is of its files.
#[cfg(unix)]
#[test]
fn a_signal_has_its_name() {
    use std::io::{BufRead, BufReader, Read};
    let folder = tempfile::tempdir().unwrap();
    // Hours of virtual time.
    let jog = "TJogPrm j = {1, 1, 0}; GT_LmtsOff(1); GT_AlarmOff(1); GT_AxisOn(1); GT_PrfJog(1); GT_SetJogPrm(1, &j);\n\
        GT_SetVel(1, 5); GT_Update(1); Sleep(100000000);\n";
    fs::write(folder.path().join("job.gts"), jog).unwrap();
    for words in [&["--json"][..], &["--json", "--trace", "t.csv"]] {
        let mut child = Command::new(env!("CARGO_BIN_EXE_beamtick"))
            .args([&["sim", "job.gts"], words].concat())
            .current_dir(folder.path())
            .stdout(std::process::Stdio::piped())
            .stderr(std::process::Stdio::piped())
            .spawn()
            .unwrap();
        std::thread::sleep(std::time::Duration::from_millis(400));
        assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
        let mut errors = BufReader::new(child.stderr.take().unwrap());
        let mut line = String::new();
        errors.read_line(&mut line).unwrap();
        assert!(line.contains("interrupted by SIGINT"), "{line}");
        errors.read_to_string(&mut line).unwrap();
        let output = child.wait_with_output().unwrap();
        let object: Value = serde_json::from_slice(&output.stdout).unwrap();
        let error = &object["error"];
        let told = error["text"].as_str().unwrap();
        assert!(output.status.code() == Some(130) && error["kind"] == "signal", "{object}");
        assert!(told.starts_with("SIGINT"), "{object}");
        if words.len() == 3 {
            assert!(told.contains("t.csv.partial"), "{object}");
        }
    }
}
