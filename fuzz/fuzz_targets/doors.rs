//! `cargo +nightly fuzz run doors`: bytes that reach new code are kept and changed further.
#![no_main]

#[path = "../doors.rs"]
mod doors;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| doors::knock(bytes));
