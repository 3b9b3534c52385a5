//! libgts32 through ctypes, with integers of 32 bits and guarded memory; its header with a C
//! program; `gts.cs` against it.

use std::path::{Path, PathBuf};
use std::process::Command;

fn folder() -> PathBuf {
    std::env::current_exe().unwrap().parent().unwrap().to_owned()
}

fn clean(command: &mut Command) -> &mut Command {
    for (name, _) in std::env::vars_os().filter(|(name, _)| name.to_string_lossy().starts_with("BEAMTICK_")) {
        command.env_remove(name);
    }
    command.env("BEAMTICK_LINK", "virtual:max").env_remove("LD_LIBRARY_PATH")
}

fn tests() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests")
}

fn passed(command: &mut Command) {
    let done = match clean(command).output() {
        Ok(done) => done,
        Err(error) => {
            eprintln!("skipped: {command:?}: {error}");
            return;
        }
    };
    let text = String::from_utf8_lossy(&done.stdout).into_owned() + &String::from_utf8_lossy(&done.stderr);
    assert!(done.status.success() && text.contains("all checks passed"), "{:?}: {text}", done.status);
}

#[test]
fn integers_of_32_bits_and_guarded_memory() {
    let library = folder().join("libgts32.so");
    assert!(library.is_file(), "{}", library.display());
    passed(Command::new("python3").arg(tests().join("guarded.py")).arg(library));
}

#[test]
fn a_c_program_takes_its_header() {
    let program = Path::new(env!("CARGO_TARGET_TMPDIR")).join("gts32_program");
    let source = Path::new(env!("CARGO_TARGET_TMPDIR")).join("gts32_program.c");
    std::fs::write(
        &source,
        "#include \"gts32.h\"\n#include <stdio.h>\n#include <string.h>\nint main(void)\n{\n    int pos[2] = {0, 77}, space;\n    char *text;\n    \
         if (sizeof(TCrdPrm) != 80 || sizeof(TCrdData) != 200 || sizeof(TPid) != 56) return 1;\n    \
         if (GT_Open(0, 1) || GT_GetVersion(&text) || !strstr(text, \"long of 32 bits\")) return 2;\n    \
         if (GT_SetPos(1, -5) || GT_GetPos(1, pos) || pos[0] != -5 || pos[1] != 77) return 3;\n    \
         if (GTN_GetPrfMode(1, 1, &space, 1, NULL)) return 4;\n    \
         printf(\"all checks passed\\n\");\n    return GT_Close();\n}\n",
    )
    .unwrap();
    let built = Command::new("cc")
        .args(["-Wall", "-Wextra", "-Werror", "-I"])
        .arg(tests().join("../../gts/include"))
        .arg(&source)
        .arg("-o")
        .arg(&program)
        .arg("-L")
        .arg(folder())
        .args(["-lgts32", &format!("-Wl,-rpath,{}", folder().display())])
        .output();
    let Ok(built) = built else {
        eprintln!("skipped: there is no C compiler");
        return;
    };
    assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
    passed(&mut Command::new(program));
}

/// Every declaration of `gts.cs` is a symbol of the library, and every symbol is declared.
#[test]
fn the_declarations_for_c_sharp_are_the_librarys_symbols() {
    let text = std::fs::read_to_string(tests().join("../gts.cs")).unwrap();
    let entries =
        text.lines().filter_map(|line| line.split("EntryPoint = \"").nth(1)).map(|rest| rest.split('"').next());
    let mut declared: Vec<&str> = text
        .lines()
        .filter_map(|line| line.trim().strip_prefix("public static extern short "))
        .map(|line| line.split('(').next().unwrap())
        .chain(entries.flatten())
        .collect();
    declared.sort_unstable();
    declared.dedup();
    let listed = Command::new("nm").args(["-D", "--defined-only"]).arg(folder().join("libgts32.so")).output();
    let Ok(listed) = listed else {
        eprintln!("skipped: there is no nm");
        return;
    };
    let listed = String::from_utf8(listed.stdout).unwrap();
    let mut symbols: Vec<&str> = listed
        .lines()
        .filter_map(|line| line.rsplit(' ').next())
        .filter(|symbol| ["GT_", "GTN_", "GTM_"].iter().any(|prefix| symbol.starts_with(prefix)))
        .collect();
    symbols.sort_unstable();
    assert!(symbols.len() > 400, "{}", symbols.len());
    assert_eq!(declared, symbols);
}

#[test]
fn a_c_sharp_program_runs_under_mono() {
    let program = Path::new(env!("CARGO_TARGET_TMPDIR")).join("program.exe");
    let built = Command::new("mcs")
        .args(["-nologo", "-warnaserror"])
        .arg(format!("-out:{}", program.display()))
        .arg(tests().join("program.cs"))
        .arg(tests().join("../gts.cs"))
        .output();
    let Ok(built) = built else {
        eprintln!("skipped: there is no Mono (mono-mcs, mono-runtime); `cargo xtask setup` installs it");
        return;
    };
    assert!(
        built.status.success(),
        "{}{}",
        String::from_utf8_lossy(&built.stdout),
        String::from_utf8_lossy(&built.stderr)
    );
    let mut command = Command::new("mono");
    let done = clean(command.arg(program)).env("LD_LIBRARY_PATH", folder()).output().unwrap();
    let text = String::from_utf8_lossy(&done.stdout).into_owned() + &String::from_utf8_lossy(&done.stderr);
    assert_eq!(text, "-70000 0 1 at 4000,3000 7\nall checks passed\n");
    assert!(done.status.success());
}

#[test]
fn a_c_sharp_program_has_several_cards() {
    let folder_of_program = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let (source, program) = (folder_of_program.join("cards.cs"), folder_of_program.join("cards.exe"));
    std::fs::write(
        &source,
        "using System;\nusing gts;\nstatic class Program\n{\n    static int Main()\n    {\n        int pos;\n        \
         for (short card = 0; card < 2; card++)\n        {\n            \
         if (mc.GT_Open(card, 0, 1) != 0 || mc.GT_SetPos(card, 1, 100 + card) != 0) return 1;\n        }\n        \
         for (short card = 0; card < 2; card++)\n        {\n            \
         if (mc.GT_GetPos(card, 1, out pos) != 0 || pos != 100 + card || mc.GT_Close(card) != 0) return 2;\n        }\n        \
         Console.WriteLine(\"all checks passed\");\n        return 0;\n    }\n}\n",
    )
    .unwrap();
    let mut build = Command::new("mcs");
    build.args(["-nologo", "-warnaserror", "-d:BEAMTICK_CARDS"]).arg(format!("-out:{}", program.display()));
    let Ok(built) = build.arg(source).arg(tests().join("../gts.cs")).output() else {
        eprintln!("skipped: there is no Mono (mono-mcs, mono-runtime); `cargo xtask setup` installs it");
        return;
    };
    assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
    let done = clean(Command::new("mono").arg(program)).env("LD_LIBRARY_PATH", folder()).output().unwrap();
    assert_eq!(String::from_utf8_lossy(&done.stdout), "all checks passed\n", "{:?}", done.status);
}
