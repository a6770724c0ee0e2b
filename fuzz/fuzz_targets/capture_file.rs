//! Any bytes as a capture: a table, an archive, something else.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|file: &[u8]| fuzz::bounded(file.len(), || fuzz::read_and_recover(file)));
