//! The log of a program, on standard error.

use std::env::VarError;
use std::io::IsTerminal as _;

use tracing_subscriber::EnvFilter;
use tracing_subscriber::filter::LevelFilter;

/// The variable that says what is logged.
const VARIABLE: &str = "RUST_LOG";

/// Sends the program's log to standard error: what `RUST_LOG` asks for, otherwise what is at least as severe as `level`.
pub fn start_log(level: LevelFilter) {
    let directives = match std::env::var(VARIABLE) {
        Ok(directives) => directives,
        Err(VarError::NotPresent) => String::new(),
        Err(VarError::NotUnicode(_)) => {
            super::remark(format!("{VARIABLE} is not Unicode and is ignored"));
            String::new()
        }
    };
    let filter = EnvFilter::builder().with_default_directive(level.into());
    let filter = filter.parse(&directives).unwrap_or_else(|error| {
        super::remark(format!("{VARIABLE} is ignored: {error}; use a form such as recorder=debug"));
        EnvFilter::default().add_directive(level.into())
    });
    tracing_subscriber::fmt()
        .with_env_filter(filter)
        .with_writer(std::io::stderr)
        // A terminal that is gone takes no complaint about it either.
        .log_internal_errors(false)
        .with_ansi(log_may_be_coloured())
        .with_target(false)
        .without_time()
        .init();
}

/// Whether standard error may be coloured: it is a terminal, and `NO_COLOR` is unset or empty (<https://no-color.org>).
#[must_use]
pub fn log_may_be_coloured() -> bool {
    std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty())
}
