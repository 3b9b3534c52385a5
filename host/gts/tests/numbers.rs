//! Calls per second over each link, for docs/numbers.md: asked for by `BEAMTICK_MEASURE=1`, in a
//! release build.
//!
//! `BEAMTICK_MEASURE=1 cargo test --release -p beamtick-gts --test numbers -- --nocapture`

mod toolchain;

use std::net::TcpListener;
use std::process::{Child, Command};
use std::time::Duration;
use toolchain::{Language, build_file, output, root, scratch, skip};

/// A process that ends with the measurement.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[test]
fn calls_per_second() {
    if std::env::var_os("BEAMTICK_MEASURE").is_none() {
        return skip("figures are measured with BEAMTICK_MEASURE=1");
    }
    let source = root().join("host/gts/tests/programs/calls.cpp");
    let Some(built) = build_file(Language::Cpp, "calls", &source, &["-O2"]) else { return };
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let served = virtual_board::serve(listener, None, virtual_board::Config::default()).unwrap();
    let tcp = format!("tcp:{}", served.address());
    let mut links =
        vec![("virtual:max", "virtual:max".to_owned()), ("virtual", "virtual".to_owned()), ("tcp, virtual", tcp)];
    let image = std::env::var("BEAMTICK_IMAGE").ok();
    if image.is_some() {
        links.push(("qemu", "qemu".to_owned()));
    }
    let image = image.unwrap_or_default();
    let measure = |name: &str, link: &str| {
        for batches in ["on", "off"] {
            let variables =
                [("BEAMTICK_LINK", link), ("BEAMTICK_BATCHES", batches), ("BEAMTICK_IMAGE", image.as_str())];
            let text = output(&built, &variables);
            println!("{name}, batches {batches}: {}", text.trim().replace('\n', ", "));
        }
    };
    for (name, link) in &links {
        measure(name, link);
    }
    // A pseudo-terminal in front of the same controller; it goes with its user, so there is one for
    // each run.
    let port = scratch().join("calls-pty");
    for batches in ["on", "off"] {
        let pty = format!("PTY,link={},raw,echo=0", port.display());
        let socat = match Command::new("socat").args([pty, format!("TCP:{}", served.address())]).spawn() {
            Ok(socat) => Running(socat),
            Err(error) => return skip(&format!("no pseudo-terminal: {error}")),
        };
        std::thread::sleep(Duration::from_millis(500));
        let link = format!("serial:{}:921600", port.display());
        let text = output(&built, &[("BEAMTICK_LINK", link.as_str()), ("BEAMTICK_BATCHES", batches)]);
        println!("pty, batches {batches}: {}", text.trim().replace('\n', ", "));
        drop(socat);
    }
}
