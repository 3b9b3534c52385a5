//! The archive of a release: what a user of Linux on x86-64 needs, without a compiler.
//!
//! In: the workspace. Out: `out/beamtick-VERSION-x86_64-linux.tar.gz` and its SHA-256 beside it.
//! The same files in the same order make the same archive. Fails: where a part cannot be built, or
//! where what was made does not work. To see that, it is unpacked and its checksums are compared.
//! Then a job, the manual page, programs in C and C++, the wheel and the notebook run from it in an
//! empty environment.
use crate::shell::{Outcome, cargo, program, read, root, run, target, works};
use crate::{board, image, supply, wheel};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A C library of its own inside: the program runs on any Linux.
const STATIC: &str = "x86_64-unknown-linux-musl";
/// Where rustup cannot fetch that: the system's C library, linked statically.
const SYSTEM: &str = "x86_64-unknown-linux-gnu";
/// Libraries that programs link with, as release builds leave them.
const LIBRARIES: [&str; 4] = ["libgts.so", "libgts.a", "libgts32.so", "libgts32.a"];
/// Shells, and the names under which they look for completions.
const SHELLS: [(&str, &str); 3] = [("bash", "beamtick.bash"), ("zsh", "_beamtick"), ("fish", "beamtick.fish")];

fn version() -> &'static str {
    env!("CARGO_PKG_VERSION")
}

/// Makes the archive, and tries it.
pub fn make() -> Outcome {
    let name = format!("beamtick-{}-x86_64-linux", version());
    let work = target().join("dist");
    let folder = work.join(&name);
    remove(&work)?;
    programs(&folder)?;
    images(&folder)?;
    texts(&folder)?;
    let sums = read(Command::new("sh").current_dir(&folder).args(["-c", SUMS]))?;
    write(&folder.join("SHA256SUMS"), &sums)?;

    let out = root().join("out");
    let archive = out.join(format!("{name}.tar.gz"));
    make_folder(&out)?;
    let mut tar = program("tar");
    tar.args(["--sort=name", "--mtime=1980-01-01 00:00Z", "--owner=0", "--group=0", "--numeric-owner"]);
    // gzip's header has a time and a name of its own.
    run(tar.args(["--use-compress-program", "gzip -9n", "-cf"]).arg(&archive).arg("-C").arg(&work).arg(&name))?;
    let sum = read(Command::new("sha256sum").current_dir(&out).arg(format!("{name}.tar.gz")))?;
    write(&out.join(format!("{name}.tar.gz.sha256")), &sum)?;
    let bytes = fs::metadata(&archive).map_err(|e| format!("{}: {e}", archive.display()))?.len();
    println!("{}: {bytes} bytes, SHA-256 {}", archive.display(), sum.split(' ').next().unwrap_or_default());
    try_out(&archive, &name)
}

/// Sums of all files of a folder, in the order of their names.
const SUMS: &str = "find . -type f ! -name SHA256SUMS | LC_ALL=C sort | xargs -d '\\n' sha256sum";

/// The command line, the libraries with their headers, the wheel; what each is made of.
fn programs(folder: &Path) -> Outcome {
    let triple = static_target();
    let mut build = cargo();
    build.args(["build", "--release", "--package", "beamtick", "--target", triple]);
    if triple == SYSTEM {
        build.env("RUSTFLAGS", "-C target-feature=+crt-static");
    }
    run(&mut build)?;
    let built = target().join(triple).join("release").join("beamtick");
    let beamtick = folder.join("bin/beamtick");
    copy(&built, &beamtick)?;
    run(cargo().args(["build", "--release", "--package", "beamtick-gts", "--package", "beamtick-gts32"]))?;
    for library in LIBRARIES {
        copy(&target().join("release").join(library), &folder.join("lib").join(library))?;
    }
    // What debuggers need is four fifths of them.
    if works(program("strip").arg("--version")) {
        let libraries = LIBRARIES.map(|library| folder.join("lib").join(library));
        run(program("strip").arg("--strip-debug").arg(&beamtick).args(libraries))?;
    }
    copy_all(&root().join("host/gts/include"), &folder.join("include"))?;
    // It takes the library's header from beside it.
    copy_all(&root().join("host/gts/compat"), &folder.join("compat"))?;
    copy(&root().join("host/gts32/gts.cs"), &folder.join("share/csharp/gts.cs"))?;
    wheel::make_in(&folder.join("python"))?;
    copy_all(&root().join("host/python/examples"), &folder.join("python/examples"))?;
    let bills = folder.join("bill-of-materials");
    for package in ["beamtick", "beamtick-gts"] {
        supply::bill_at(package, triple, &bills.join(format!("{package}.cdx.json")))?;
    }
    let pages = folder.join("share/man/man1");
    make_folder(&pages)?;
    run(program(&beamtick).arg("man").arg(&pages))?;
    for (shell, file) in SHELLS {
        let text = read(program(&beamtick).args(["completions", shell]))?;
        write(&folder.join("share/completions").join(file), &text)?;
    }
    Ok(())
}

/// The target of a program that needs nothing of the system.
fn static_target() -> &'static str {
    let add = works(program("rustup").args(["target", "add", STATIC]));
    if add { STATIC } else { SYSTEM }
}

/// The emulated board's image, and the reference board's in all variants.
fn images(folder: &Path) -> Outcome {
    let images = folder.join("images");
    let mps2 = image::build()?;
    copy(&mps2, &images.join("beamtick-mps2"))?;
    for file in board::image()? {
        copy(&file, &images.join(file.file_name().unwrap_or_default()))?;
    }
    let bill = folder.join("bill-of-materials/beamtick-firmware.cdx.json");
    supply::bill_at("beamtick-firmware", crate::setup::TARGET, &bill)
}

/// What people read, and the examples.
fn texts(folder: &Path) -> Outcome {
    for file in ["README.md", "CONTRIBUTING.md", "CHANGELOG.md", "LICENSE-MIT", "LICENSE-APACHE"] {
        copy(&root().join(file), &folder.join(file))?;
    }
    copy_all(&root().join("docs"), &folder.join("docs"))?;
    copy_all(&root().join("examples"), &folder.join("examples"))
}

/// Unpacks the archive and uses it as a user does who has nothing else.
fn try_out(archive: &Path, name: &str) -> Outcome {
    let folder = target().join("dist").join("tried");
    make_folder(&folder)?;
    run(program("tar").arg("-xzf").arg(archive).arg("-C").arg(&folder))?;
    let unpacked = folder.join(name);
    let script = "set -e\n\
        sha256sum --quiet -c SHA256SUMS\n\
        bin/beamtick --version\n\
        bin/beamtick sim examples/laser_flying_shear.gts --quiet --plot t.png --from 310 --to 314\n\
        test -s t.png\n\
        bin/beamtick sim examples/jog_trap.gts --quiet --html t.html\n\
        test -s t.html\n\
        bin/beamtick info --json >t.json\n\
        test -s share/man/man1/beamtick.1\n";
    bare(&unpacked, script)?;
    if works(program("cc").arg("--version")) {
        bare(
            &unpacked,
            "printf '#include \"gts.h\"\\nint main(void) { return GT_Open(0, 1) || GT_Reset() || GT_Close(); }\\n' >t.c\n\
             cc -Iinclude t.c -Llib -lgts -Wl,-rpath,'$ORIGIN/lib' -o t && ./t",
        )?;
    }
    if works(program("g++").arg("--version")) {
        let build = "g++ -Icompat examples/c/pt_static.cpp -Llib -lgts -Wl,-rpath,'$ORIGIN/lib' -o pt_static";
        bare(&unpacked, &format!("{build} && cd examples && BEAMTICK_LINK=virtual:max ../pt_static >/dev/null"))?;
    }
    if works(program("python3").args(["-m", "venv", "--help"])) {
        bare(
            &unpacked,
            "python3 -m venv env && env/bin/pip install --quiet --no-index --no-deps python/*.whl\n\
             env/bin/python -c 'import beamtick; print(\"Python:\", beamtick.__version__)'
             env/bin/python -c 'import json, sys
names = {}
for cell in json.load(open(sys.argv[1]))[\"cells\"]:
    if cell[\"cell_type\"] == \"code\":
        exec(\"\".join(cell[\"source\"]), names)
assert names[\"trace\"][\"axis1_pos\"][-1] == 0' python/examples/first_plot.ipynb",
        )?;
    }
    println!(
        "tried: unpacked, checksums equal, a job with its plot and its page, programs in C and C++, the wheel and the notebook"
    );
    remove(&folder)
}

/// Runs a script without the environment of who calls it.
fn bare(folder: &Path, script: &str) -> Outcome {
    let mut command = Command::new("sh");
    command.current_dir(folder).env_clear().env("PATH", "/usr/bin:/bin").env("HOME", folder.join("home"));
    run(command.args(["-e", "-c", script]))
}

fn make_folder(folder: &Path) -> Outcome {
    fs::create_dir_all(folder).map_err(|e| format!("{}: {e}", folder.display()))
}

fn remove(folder: &Path) -> Outcome {
    match fs::remove_dir_all(folder) {
        Err(e) if e.kind() != std::io::ErrorKind::NotFound => Err(format!("{}: {e}", folder.display())),
        _ => Ok(()),
    }
}

fn write(file: &Path, text: &str) -> Outcome {
    if let Some(folder) = file.parent() {
        make_folder(folder)?;
    }
    fs::write(file, text).map_err(|e| format!("{}: {e}", file.display()))
}

fn copy(from: &Path, to: &Path) -> Outcome {
    if let Some(folder) = to.parent() {
        make_folder(folder)?;
    }
    fs::copy(from, to).map(drop).map_err(|e| format!("{} to {}: {e}", from.display(), to.display()))
}

/// What git knows of a folder, with those in it.
fn copy_all(from: &Path, to: &Path) -> Outcome {
    let files = read(program("git").args(["ls-files", "-z", "--"]).arg(from))?;
    for file in files.split('\0').filter(|file| !file.is_empty()) {
        let path = root().join(file);
        let inside: PathBuf = path.strip_prefix(from).map_err(|e| format!("{file}: {e}"))?.into();
        copy(&path, &to.join(inside))?;
    }
    Ok(())
}
