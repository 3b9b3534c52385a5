//! Set-up: a fresh machine with Rust lacks two things, the Cortex-M7 target of the compiler and
//! QEMU; and valgrind and Mono, without which the tests that use them say that they are
//! skipped.
//!
//! In: the machine as it is. Out: what was missing is installed and named. On Debian and Ubuntu apt
//! installs it; elsewhere this says what to install and how. Where rustup cannot fetch the target,
//! Debian's `rustc-web` with its source package builds `core` itself ([`Compiler::Debian`]).
use crate::proofs::GAPPA;
use crate::shell::{self, Outcome, cargo, program, read, works};
use std::path::Path;
use std::process::Command;

/// Target triple of the image.
pub const TARGET: &str = "thumbv7em-none-eabihf";

/// QEMU's program.
pub const QEMU: &str = "qemu-system-arm";

/// LLVM's linker: from version 17 it takes `--remap-inputs` (`firmware/build.rs`).
const LINKER: &str = "/usr/bin/ld.lld-19";

/// What builds the image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Compiler {
    /// The pinned toolchain, with its own `core` for the target.
    Pinned,
    /// Debian's compiler, which builds `core` from Debian's source package.
    Debian,
}

impl Compiler {
    /// A cargo that builds for the target.
    pub fn cargo(self) -> Command {
        match self {
            Compiler::Pinned => cargo(),
            Compiler::Debian => {
                let mut command = program("/usr/bin/cargo");
                command.env("RUSTC", "/usr/bin/rustc").env("RUSTC_BOOTSTRAP", "1");
                // Debian's compiler brings no linker for bare metal of its own.
                command.env("CARGO_TARGET_THUMBV7EM_NONE_EABIHF_LINKER", LINKER);
                command
            }
        }
    }

    /// Arguments that every build for the target needs.
    pub fn arguments(self) -> &'static [&'static str] {
        match self {
            Compiler::Pinned => &["--target", TARGET],
            Compiler::Debian => &["--target", TARGET, "-Z", "build-std=core"],
        }
    }
}

/// Installs what is missing.
pub fn run() -> Outcome {
    compiler()?;
    valgrind();
    mono();
    qemu()
}

/// The compiler for the image, installed if need be.
pub fn compiler() -> Outcome<Compiler> {
    // For tests of the fallback, and for whoever prefers it.
    if std::env::var_os("BEAMTICK_DEBIAN_COMPILER").is_some() {
        return debian_compiler();
    }
    if has_target() {
        return Ok(Compiler::Pinned);
    }
    println!("set-up: adding the target {TARGET} with rustup");
    if succeeds(program("rustup").args(["target", "add", TARGET])) && has_target() {
        return Ok(Compiler::Pinned);
    }
    println!("set-up: rustup cannot fetch the target; taking Debian's compiler for the image");
    debian_compiler()
}

fn succeeds(command: &mut Command) -> bool {
    command.status().is_ok_and(|status| status.success())
}

/// Whether the pinned toolchain has `core` for the target.
fn has_target() -> bool {
    let Ok(directory) = read(program("rustc").args(["--print", "target-libdir", "--target", TARGET])) else {
        return false;
    };
    std::fs::read_dir(directory.trim()).is_ok_and(|mut entries| {
        entries.any(|entry| entry.is_ok_and(|e| e.file_name().to_string_lossy().starts_with("libcore-")))
    })
}

fn debian_compiler() -> Outcome<Compiler> {
    let there = Path::new("/usr/bin/rustc").exists()
        && Path::new("/usr/bin/cargo").exists()
        && Path::new(LINKER).exists()
        && Path::new("/usr/lib/rustlib/src/rust/library/core").exists();
    if !there {
        install(
            &["rustc-web", "cargo-web", "rust-web-src", "lld-19"],
            &format!("install the target with `rustup target add {TARGET}`"),
        )?;
    }
    Ok(Compiler::Debian)
}

fn qemu() -> Outcome {
    if works(program(QEMU).arg("--version")) {
        return Ok(());
    }
    println!("set-up: installing {QEMU}");
    install(
        &["qemu-system-arm"],
        "install QEMU with its Arm system emulator: `brew install qemu` on macOS, `dnf install \
         qemu-system-arm` on Fedora, `pacman -S qemu-system-arm` on Arch, or the installer of qemu.org on Windows",
    )
}

/// Gappa, which proves bounds of rounding.
pub fn gappa() -> Outcome {
    if works(program(GAPPA).arg("--version")) {
        return Ok(());
    }
    println!("set-up: installing {GAPPA}");
    install(&["gappa"], "install Gappa (https://gappa.gitlabpages.inria.fr, or opam's package `gappa`)")
}

/// A C# program runs under it; a machine without it is none to refuse, either.
fn mono() {
    if works(program("mcs").arg("--version")) && works(program("mono").arg("--version")) {
        return;
    }
    println!("set-up: installing Mono");
    if let Err(reason) = install(&["mono-mcs", "mono-runtime"], "install Mono if there is one for it") {
        println!("set-up: the test of a C# program will be skipped: {reason}");
    }
}

/// Nothing needs it to pass, so a machine without it is none to refuse.
fn valgrind() {
    if works(program("valgrind").arg("--version")) {
        return;
    }
    println!("set-up: installing valgrind");
    if let Err(reason) = install(&["valgrind"], "install valgrind if there is one for it") {
        println!("set-up: tests under valgrind will be skipped: {reason}");
    }
}

/// Unicorn, in which the image for the STM32H743 is tested.
pub fn unicorn() -> Outcome {
    if Path::new("/usr/include/unicorn/unicorn.h").exists()
        || works(program("pkg-config").args(["--exists", "unicorn"]))
    {
        return Ok(());
    }
    println!("set-up: installing libunicorn-dev");
    install(&["libunicorn-dev"], "install Unicorn 2, the emulator's library, with its headers")
}

/// Installs Debian packages, or says what to do where there is no apt.
fn install(packages: &[&str], elsewhere: &str) -> Outcome {
    if !works(program("apt-get").arg("--version")) {
        return Err(format!("this machine has no apt: {elsewhere}, then run the command again"));
    }
    let apt = |arguments: &[&str]| {
        let mut command = if is_root() {
            program("apt-get")
        } else {
            let mut sudo = program("sudo");
            sudo.arg("apt-get");
            sudo
        };
        command.args(arguments).env("DEBIAN_FRONTEND", "noninteractive");
        command
    };
    // Lists may be fresh enough; only if not are they fetched.
    let arguments = [&["install", "--yes", "--no-install-recommends"], packages].concat();
    if works(&mut apt(&arguments)) {
        return Ok(());
    }
    shell::run(&mut apt(&["update"]))
        .and_then(|()| shell::run(&mut apt(&arguments)))
        .map_err(|e| format!("{e}; to install by hand: `apt-get install {}`", packages.join(" ")))
}

fn is_root() -> bool {
    read(program("id").arg("-u")).is_ok_and(|id| id.trim() == "0")
}
