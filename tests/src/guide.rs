//! The commands of the guide, as they stand in its pages.
//!
//! A block fenced as `console` is a dialogue: lines that begin with `$ ` are typed, all others are what the programs
//! answer. `console interrupted` is one whose last command goes on until Ctrl-C.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, ensure};

/// After how long the last command of an interrupted block gets its Ctrl-C, s.
const INTERRUPTED_AFTER_S: u32 = 8;

/// What is typed in one block of a page.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Block {
    /// Where the block stands: page and line.
    pub place: String,
    /// Its commands, as a script for bash.
    pub script: String,
}

/// The pages of the guide in the order in which they are read: `1-….md`, `2-….md` …
///
/// # Errors
/// When there are none.
pub fn pages(folder: &Path) -> anyhow::Result<Vec<PathBuf>> {
    let numbered = |path: &PathBuf| {
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        name.ends_with(".md") && name.starts_with(|first: char| first.is_ascii_digit())
    };
    let entries = std::fs::read_dir(folder).with_context(|| folder.display().to_string())?;
    let mut pages: Vec<PathBuf> = entries.map(|entry| Ok(entry?.path())).collect::<std::io::Result<_>>()?;
    pages.retain(numbered);
    pages.sort();
    ensure!(!pages.is_empty(), "{} has no page", folder.display());
    Ok(pages)
}

/// The blocks of a page.
///
/// # Errors
/// When a block has no end or no command, or a command of ours stands in a fenced block of another kind, where nothing
/// would run it.
pub fn blocks(name: &str, page: &str) -> anyhow::Result<Vec<Block>> {
    let mut blocks = Vec::new();
    let mut lines = page.lines().enumerate();
    while let Some((number, line)) = lines.next() {
        let Some(kind) = line.strip_prefix("```") else { continue };
        let place = format!("{name}:{}", number + 1);
        let mut body = Vec::new();
        loop {
            let (_, line) = lines.next().with_context(|| format!("{place}: the block has no end"))?;
            if line == "```" {
                break;
            }
            body.push(line);
        }
        match kind {
            "console" => blocks.push(Block { script: script(&body, false, &place)?, place }),
            "console interrupted" => blocks.push(Block { script: script(&body, true, &place)?, place }),
            _ => ensure!(
                !body.iter().any(|line| line.contains("haptic-camera ")),
                "{place}: a command in a block that is not `console` is never tried"
            ),
        }
    }
    Ok(blocks)
}

fn script(body: &[&str], interrupted: bool, place: &str) -> anyhow::Result<String> {
    let mut commands: Vec<String> = Vec::new();
    let mut goes_on = false;
    for line in body {
        match (line.strip_prefix("$ "), goes_on) {
            (Some(command), false) => commands.push(command.to_owned()),
            (None, true) => {
                let command = commands.last_mut().with_context(|| place.to_owned())?;
                command.push('\n');
                command.push_str(line);
            }
            (None, false) => continue,
            (Some(_), true) => anyhow::bail!("{place}: a command begins inside another one"),
        }
        goes_on = line.ends_with('\\');
    }
    let last = commands.last_mut().with_context(|| format!("{place}: a dialogue without a command"))?;
    if interrupted {
        *last = format!("timeout --foreground --preserve-status --signal=INT {INTERRUPTED_AFTER_S} {last}");
    }
    Ok(commands.join("\n"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn commands_are_distinguished_from_answers() -> anyhow::Result<()> {
        let page =
            "# A\n```console\n$ haptic-camera a \\\n    --b\nanswer\n$ c\n```\nx\n```console interrupted\n$ d\n```\n";
        let found = blocks("a.md", page)?;
        let scripts: Vec<&str> = found.iter().map(|block| block.script.as_str()).collect();
        assert_eq!(scripts[0], "haptic-camera a \\\n    --b\nc");
        assert!(scripts[1].starts_with("timeout ") && scripts[1].ends_with(" d"), "{scripts:?}");
        assert_eq!(found[1].place, "a.md:9");
        Ok(())
    }

    #[test]
    fn what_would_never_be_tried_is_refused() {
        assert!(blocks("a.md", "```sh\nhaptic-camera fit x\n```\n").is_err());
        assert!(blocks("a.md", "```console\n$ haptic-camera fit x\n").is_err());
        assert!(blocks("a.md", "```console\nanswer\n```\n").is_err());
    }
}
