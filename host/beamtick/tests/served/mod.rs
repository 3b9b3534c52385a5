//! `beamtick serve` on a free port.
use assert_cmd::cargo::cargo_bin;
use std::io::{BufRead, BufReader};
use std::process::{Child, Command, Stdio};

/// The process, and its link; it ends with the test.
pub struct Served(pub Child, pub String);

impl Served {
    /// With these options more.
    pub fn start(more: &[&str]) -> Served {
        let mut child = Command::new(cargo_bin("beamtick"))
            .args(["serve", "--listen", "127.0.0.1:0"])
            .args(more)
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut line = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
        let link = line.split([' ', ',']).find(|word| word.starts_with("tcp:")).unwrap().to_owned();
        Served(child, link)
    }
}

impl Drop for Served {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}
