//! Data that effects refer to, kept once and for as long as the program runs.
//!
//! Effects are copied and dropped in the real-time loop, where freeing memory may wait for a lock. So nothing that an
//! effect refers to is ever freed. Equal contents are kept once: reading a model again and again costs nothing more.

#![allow(clippy::disallowed_types, reason = "taken while a model is read, never in the real-time thread")]

use std::sync::{Mutex, PoisonError};

use crate::TorqueTable;

static TEXTS: Mutex<Vec<&'static str>> = Mutex::new(Vec::new());
static TABLES: Mutex<Vec<&'static TorqueTable>> = Mutex::new(Vec::new());

/// A text that lives as long as the program and equals `wanted`: kept from before, or now.
pub(crate) fn text(wanted: &str) -> &'static str {
    // A poisoned lock does no harm: nothing that panics changes the list.
    let mut kept = TEXTS.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(found) = kept.iter().find(|text| **text == wanted) {
        return found;
    }
    let new: &'static str = Box::leak(wanted.into());
    kept.push(new);
    new
}

/// The kept table that equals `wanted`.
pub(crate) fn table(wanted: TorqueTable) -> &'static TorqueTable {
    let mut kept = TABLES.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(found) = kept.iter().find(|table| ***table == wanted) {
        return found;
    }
    let new: &'static TorqueTable = Box::leak(Box::new(wanted));
    kept.push(new);
    new
}
