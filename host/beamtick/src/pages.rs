//! Shell completions and manual pages, from the description of the command line itself.
//!
//! In: that description. Out: completions on the standard output, manual pages as files. Fails
//! where a file cannot be written.
use crate::Failure;
use crate::command_line::CommandLine;
use clap::CommandFactory;
use std::fs;
use std::path::Path;

/// Prints the completions of a shell.
pub fn completions(shell: clap_complete::Shell) -> Result<(), Failure> {
    let mut out = Vec::new();
    clap_complete::generate(shell, &mut CommandLine::command(), "beamtick", &mut out);
    say!("{}", String::from_utf8_lossy(&out).trim_end());
    Ok(())
}

/// Writes the manual pages: all of them, or none.
pub fn manual(folder: &Path) -> Result<(), Failure> {
    let fresh = folder.join(".beamtick-man");
    let done = fs::create_dir_all(&fresh)
        .and_then(|()| clap_mangen::generate_to(CommandLine::command(), &fresh))
        .and_then(|()| fs::read_dir(&fresh)?.try_for_each(|page| moved(&page?.path(), folder)));
    let _ = fs::remove_dir_all(&fresh);
    done.map_err(|error| Failure::Input(format!("{}: cannot be written: {error}", folder.display())))
}

fn moved(page: &Path, folder: &Path) -> std::io::Result<()> {
    fs::rename(page, folder.join(page.file_name().unwrap_or_default()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A folder that takes no page keeps those that it has.
    #[test]
    fn pages_are_written_together_or_not() {
        let folder = tempfile::tempdir().unwrap();
        fs::create_dir_all(folder.path().join("beamtick.1/full")).unwrap();
        assert!(manual(folder.path()).is_err());
        assert!(!folder.path().join(".beamtick-man").exists());
        assert!(fs::read_dir(folder.path()).unwrap().all(|page| page.unwrap().metadata().unwrap().len() > 0));
    }

    #[test]
    fn every_command_has_a_manual_page() {
        let folder = tempfile::tempdir().unwrap();
        manual(folder.path()).unwrap();
        for inner in CommandLine::command().get_subcommands() {
            let page = folder.path().join(format!("beamtick-{}.1", inner.get_name()));
            assert!(fs::read_to_string(page).unwrap().contains(".TH"), "{}", inner.get_name());
        }
    }
}
