//! Any bytes as a measurement in ASAM MDF 4, with its channels as they tell themselves.
#![no_main]

use libfuzzer_sys::fuzz_target;

fuzz_target!(|file: &[u8]| fuzz::bounded(file.len(), || fuzz::read_measurement(file)));
