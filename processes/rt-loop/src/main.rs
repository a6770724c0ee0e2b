//! The real-time process.

use std::process::ExitCode;

fn main() -> ExitCode {
    rt_loop::program(&rt_loop::rigs::ALL)
}
