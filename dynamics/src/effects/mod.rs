//! The effects that the instrument knows: one file each, and the list of them.

pub mod detent;
pub mod friction;
pub mod inertia;
pub mod karnopp_stick;

use crate::EffectKind;

/// Every effect, in the order in which a model lists them.
pub static ALL: [&EffectKind; 4] = [&inertia::KIND, &friction::KIND, &karnopp_stick::KIND, &detent::KIND];

/// The effect with the standard name `name`.
#[must_use]
pub fn by_name(name: &str) -> Option<&'static EffectKind> {
    ALL.iter().copied().find(|kind| kind.name == name)
}
