//! Programs for Windows: the structs with its 32-bit `long`, and an example on `gts.dll` in Wine
//! (docs/c.md). Needs MinGW; the second one also Wine and the folder of `gts.dll` and
//! `libgts.dll.a` in `BEAMTICK_WINDOWS`.

mod toolchain;

use std::path::{Path, PathBuf};
use std::process::Command;
use toolchain::{output_of, root, scratch, skip};

/// Compiles for Windows; nothing where there is no MinGW.
fn built(name: &str, source: &Path, more: &[&str]) -> Option<PathBuf> {
    let program = scratch().join(name);
    let mut compiler = Command::new("x86_64-w64-mingw32-g++");
    compiler.args(["-Wall", "-Wextra", "-Werror", "-static", "-I"]).arg(root().join("host/gts/include"));
    let Ok(done) = compiler.arg(source).args(more).arg("-o").arg(&program).output() else {
        skip("there is no MinGW");
        return None;
    };
    assert!(done.status.success(), "{name}: {}", String::from_utf8_lossy(&done.stderr));
    Some(program)
}

#[test]
fn structs_have_the_sizes_of_the_manuals() {
    let source = scratch().join("windows_structs.cpp");
    let text = r#"
#include "gts.h"
#include <conio.h>
#include <windows.h>
static_assert(sizeof(long) == 4 && sizeof(TTrapPrm) == 32 && sizeof(TJogPrm) == 24, "");
static_assert(sizeof(TCrdPrm) == 80 && offsetof(TCrdPrm, synVelMax) == 24 && offsetof(TCrdPrm, originPos) == 44, "");
static_assert(sizeof(TCrdData) == 200 && offsetof(TCrdData, pos) == 4 && offsetof(TCrdData, radius) == 40, "");
static_assert(offsetof(TCrdData, center) == 56 && offsetof(TCrdData, operation) == 98 && offsetof(TCrdData, r) == 192, "");
"#;
    std::fs::write(&source, text).unwrap();
    let Some(object) = built("windows_structs.o", &source, &["-c"]) else { return };
    assert!(object.is_file());
}

#[test]
fn an_example_runs_on_the_dll() {
    let Some(folder) = std::env::var_os("BEAMTICK_WINDOWS").map(PathBuf::from) else {
        return skip("BEAMTICK_WINDOWS names no folder with gts.dll");
    };
    let source = root().join("examples/c/pt_static.cpp");
    let import = folder.join("libgts.dll.a");
    let Some(program) = built("pt_static.exe", &source, &[import.to_str().unwrap()]) else { return };
    if Command::new("wine").arg("--version").output().is_err() {
        return skip("there is no Wine");
    }
    let mut wine = Command::new("wine");
    wine.arg(&program).current_dir(root().join("examples")).env("BEAMTICK_LINK", "virtual:max");
    wine.env("WINEPATH", format!("Z:{}", folder.display())).env("WINEDEBUG", "-all");
    let text = output_of(&mut wine);
    assert_eq!(
        text.replace('\r', ""),
        "32 free segments\n29 free segments after three\nat 4096.0 with 0.00 pulse/ms\n"
    );
}
