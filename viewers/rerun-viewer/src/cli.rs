//! The command line.

use std::net::IpAddr;
use std::path::PathBuf;

use bytesize::ByteSize;
use clap::{Parser, Subcommand};

/// Shows a running capture, or a finished one, as a web page, in a window or into a file.
#[derive(Clone, Debug, Parser)]
#[command(name = "rerun-viewer", version, args_conflicts_with_subcommands = true)]
pub struct Arguments {
    /// What to do instead of showing a capture.
    #[command(subcommand)]
    pub command: Option<Command>,

    /// Show a finished capture instead of the running one: an archive, a CSV or an MDF file.
    #[arg(long, value_name = "CAPTURE")]
    pub capture: Option<PathBuf>,

    /// End at Ctrl-C, for a viewer that the operator runs himself; with --capture it always does.
    #[arg(long)]
    pub foreground: bool,

    /// Serve a web page (the default).
    #[arg(long, conflicts_with_all = ["native", "save"])]
    pub web: bool,

    /// Show in rerun's own window; needs the `rerun` program, unless one listens already.
    #[arg(long, conflicts_with = "save")]
    pub native: bool,

    /// Write a rerun file and end with the capture.
    #[arg(long, value_name = "FILE.rrd")]
    pub save: Option<PathBuf>,

    /// Also tell how to see the page from another machine through ssh.
    #[arg(long, conflicts_with_all = ["native", "save"])]
    pub remote: bool,

    /// Address that the page is served at; beyond this machine it asks nobody who he is.
    #[arg(long, default_value = "127.0.0.1")]
    pub bind: IpAddr,

    /// Port of the page; when it is taken, one of the next ones.
    #[arg(long, default_value_t = 9090)]
    pub web_port: u16,

    /// Port at which rerun's own window listens, with --native.
    #[arg(long, default_value_t = 9876)]
    pub grpc_port: u16,

    /// What is kept for a page opened later; beyond it the oldest goes.
    #[arg(long, default_value = "512MB")]
    pub memory_limit: ByteSize,

    /// How often the viewer was restarted during the run, for the health report.
    #[arg(long, default_value_t = 0)]
    pub restarts: u32,
}

/// What the viewer can do besides showing captures.
#[derive(Clone, Debug, Subcommand)]
pub enum Command {
    /// Draw a diagnosis into a rerun file.
    Diagnosis {
        /// The diagnosis with its captures' rows, as `haptic-camera diagnose --recording` hands it over.
        #[arg(value_name = "FILE.json")]
        json: PathBuf,
        /// The rerun file.
        #[arg(long, value_name = "FILE.rrd")]
        out: PathBuf,
    },
}
