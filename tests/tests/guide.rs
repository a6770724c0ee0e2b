//! Every command of the guide does what the guide says: run in order, in one folder, as a reader would.
//!
//! The folder is `target/guide` and stays: `scripts/picture-guide` takes the guide's pictures from it.

use std::path::Path;
use std::process::{Command, Stdio};

use anyhow::{Context as _, ensure};
use tests::{guide, printed, program};

/// Attempts at the whole guide where the host stalls.
const ATTEMPTS: usize = 3;

/// What commands print when the host stalls: a rig's watchdog ends a run, or `rig check` misses ticks.
const STALLS: [&str; 3] = ["watchdog ran out", "the machine stopped the loop", "cannot hold the rate"];

#[test]
fn every_command_of_the_guide_runs() -> anyhow::Result<()> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).parent().context("the workspace has no folder")?;
    let programs = program("haptic-camera")?.parent().context("the programs have no folder")?.to_owned();
    let guide = root.join("docs/guide");
    for left in (0..ATTEMPTS).rev() {
        match follow(&guide, &programs) {
            Err(error) if left > 0 && STALLS.iter().any(|stall| error.to_string().contains(stall)) => {}
            followed => {
                followed?;
                break;
            }
        }
    }
    let lost = linked_files(&guide)?.into_iter().find(|path| !path.exists());
    ensure!(lost.is_none(), "the guide shows {}, which is not there", lost.unwrap_or_default().display());
    Ok(())
}

/// Runs the commands of all pages in an empty folder.
fn follow(guide: &Path, programs: &Path) -> anyhow::Result<()> {
    let folder = programs.parent().context("the programs' folder has none above it")?.join("guide");
    if folder.exists() {
        std::fs::remove_dir_all(&folder)?;
    }
    std::fs::create_dir_all(&folder)?;
    let mut path = vec![programs.to_owned()];
    path.extend(std::env::split_paths(&std::env::var_os("PATH").unwrap_or_default()));
    for page in guide::pages(guide)? {
        let name = page.file_name().unwrap_or_default().to_string_lossy().into_owned();
        for block in guide::blocks(&name, &std::fs::read_to_string(&page)?)? {
            let output = Command::new("bash")
                .args(["-euo", "pipefail", "-c", &block.script])
                .current_dir(&folder)
                .env("PATH", std::env::join_paths(&path)?)
                .env(shared_types::rig::RUNTIME_DIR_VARIABLE, folder.join("rig"))
                .stdin(Stdio::null())
                .output()?;
            ensure!(output.status.success(), "{}: {}\n{}", block.place, output.status, printed(&output));
        }
    }
    Ok(())
}

/// What the pages of a folder link to beside them: `](file)`, with neither a scheme nor an anchor.
fn linked_files(folder: &Path) -> anyhow::Result<Vec<std::path::PathBuf>> {
    let mut files = Vec::new();
    for page in guide::pages(folder)? {
        let text = std::fs::read_to_string(&page)?;
        let links = text.split("](").skip(1).filter_map(|rest| rest.split([')', '#']).next());
        files.extend(links.filter(|link| !link.is_empty() && !link.contains("://")).map(|link| folder.join(link)));
    }
    Ok(files)
}
