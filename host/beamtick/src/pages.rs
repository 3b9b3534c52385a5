//! Shell completions and manual pages, from the description of the command line itself.
//!
//! In: that description. Out: completions on the standard output, manual pages as files. Fails
//! where a file cannot be written.
use crate::Failure;
use crate::command_line::CommandLine;
use clap::CommandFactory;
use std::path::Path;

/// Prints the completions of a shell.
pub fn completions(shell: clap_complete::Shell) -> Result<(), Failure> {
    let mut out = Vec::new();
    clap_complete::generate(shell, &mut CommandLine::command(), "beamtick", &mut out);
    say!("{}", String::from_utf8_lossy(&out).trim_end());
    Ok(())
}

/// Writes the manual pages.
pub fn manual(folder: &Path) -> Result<(), Failure> {
    let failed = |error: std::io::Error| Failure::Input(format!("{}: cannot be written: {error}", folder.display()));
    std::fs::create_dir_all(folder).map_err(failed)?;
    clap_mangen::generate_to(CommandLine::command(), folder).map_err(failed)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_command_has_a_manual_page() {
        let folder = tempfile::tempdir().unwrap();
        manual(folder.path()).unwrap();
        for inner in CommandLine::command().get_subcommands() {
            let page = folder.path().join(format!("beamtick-{}.1", inner.get_name()));
            assert!(std::fs::read_to_string(page).unwrap().contains(".TH"), "{}", inner.get_name());
        }
    }
}
