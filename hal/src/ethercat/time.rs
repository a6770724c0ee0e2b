//! The clock by which ethercrab times out, as `embassy-time` wants it.

#![allow(unsafe_code, reason = "embassy-time finds its driver by two symbols, which its macro exports")]

use std::task::Waker;

use embassy_time_driver::{Driver, TICK_HZ, time_driver_impl};
use shared_types::rig::monotonic_time_ns;

struct Monotonic;

impl Driver for Monotonic {
    fn now(&self) -> u64 {
        monotonic_time_ns() / (1_000_000_000 / TICK_HZ)
    }

    /// Nobody sleeps until he is woken: whoever waits for a frame polls.
    fn schedule_wake(&self, _at: u64, _waker: &Waker) {}
}

time_driver_impl!(static MONOTONIC: Monotonic = Monotonic);
