//! What a composed model may be written over: one that was composed before, so that a number is changed and felt again,
//! and nothing else. A fitted model, a drawn table or a capture costs more to have again.

use anyhow::bail;
use archive::whole_file::Replace;
use dynamics::Model;

use super::ComposeOptions;
use crate::outputs::{is_same, kind};

/// What the model may replace; refuses a place where something would be lost.
///
/// # Errors
/// One sentence that says what lies there and what to do.
pub fn replaced(options: &ComposeOptions) -> anyhow::Result<Replace> {
    let out = &options.out;
    if options.overwrite {
        return Ok(Replace::Anything);
    }
    let shown = out.display();
    if sources(options).any(|source| is_same(source.as_ref(), out)) {
        bail!("{shown} is itself a source of the model; choose another name for --out, or give --overwrite");
    }
    match out.is_file().then(|| Model::load(out)) {
        None => {}
        Some(Ok(model)) if model.effects.iter().any(|effect| effect.origin().is_some()) => {}
        Some(Ok(_)) => {
            bail!("{shown} exists and was not composed; choose another name for --out, or give --overwrite")
        }
        Some(Err(_)) => bail!("{shown} exists and is not a model; choose another name for --out, or give --overwrite"),
    }
    Ok(kind::COMPOSED_MODEL)
}

fn sources(options: &ComposeOptions) -> impl Iterator<Item = &String> {
    let ComposeOptions { inertia, friction, detents, extra, from, .. } = options;
    let parts = [inertia, friction, detents].into_iter().flatten();
    parts.chain(extra.iter().map(|extra| &extra.source)).chain(from.iter().map(|from| &from.value))
}
