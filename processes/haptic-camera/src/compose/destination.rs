//! What a composed model may be written over: one that was composed before, so that a number is changed and felt again,
//! and nothing else. A fitted model, a drawn table or a capture costs more to have again.

use anyhow::bail;
use dynamics::Model;

use crate::command_line::ComposeOptions;

/// Refuses a place where something would be lost.
///
/// # Errors
/// One sentence that says what lies there and what to do.
pub fn check(options: &ComposeOptions) -> anyhow::Result<()> {
    let out = &options.out;
    if options.overwrite || !out.exists() {
        return Ok(());
    }
    let shown = out.display();
    if sources(options).any(|source| same_file(source, out)) {
        bail!("{shown} is itself a source of the model; choose another name for --out, or say --overwrite");
    }
    match Model::load(out) {
        Ok(model) if model.effects.iter().any(|effect| effect.origin().is_some()) => Ok(()),
        Ok(_) => bail!("{shown} is there and was not composed; choose another name for --out, or say --overwrite"),
        Err(_) => bail!("{shown} is there and is no model; choose another name for --out, or say --overwrite"),
    }
}

fn sources(options: &ComposeOptions) -> impl Iterator<Item = &String> {
    let ComposeOptions { inertia, friction, detents, extra, from, .. } = options;
    let parts = [inertia, friction, detents].into_iter().flatten();
    parts.chain(extra.iter().map(|extra| &extra.source)).chain(from.iter().map(|from| &from.value))
}

fn same_file(source: &str, out: &std::path::Path) -> bool {
    matches!((std::fs::canonicalize(source), std::fs::canonicalize(out)), (Ok(source), Ok(out)) if source == out)
}
