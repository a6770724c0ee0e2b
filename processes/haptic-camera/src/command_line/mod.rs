//! The command line: the commands, whose options stand with what they do, options that several take, and the files that commands write.

mod files;
pub mod outputs;

use std::path::PathBuf;

use archive::testers::{Assignments, ColumnChoice};
use clap::{Args, Parser};
use rt_loop::request::RigRequest;

use crate::outcome::UsageError;
use crate::{
    calibrate, capture, check, compare, compose, diagnose, doctor, export, fit, judge, list, recompute, recover,
    replay, rig_test, rigs, sheet, simulate, studies, table, trend, tune, view,
};

/// Captures how a mechanical knob feels, as numbers.
#[derive(Debug, Parser)]
#[command(name = "haptic-camera", version, propagate_version = true)]
#[command(
    after_help = "Exit status: 0 done, 1 failed, 2 wrong usage, 3 done but data was lost,\n4 a judged unit fails, 5 one is undecided.\n\n\
    Environment:\n  \
    RUST_LOG     log level for standard error, such as info or recorder=debug\n  \
    NO_COLOR     no colours in the log; also the default without a terminal\n  \
    HAPTIC_CAMERA_RUNTIME_DIR\n               \
    the rig's directory: two directories are two rigs\n               \
    [default: in $XDG_RUNTIME_DIR, or in the user's home]\n\n\
    First steps:\n  \
    haptic-camera doctor\n  \
    haptic-camera capture --knob 3 --duration-s 10\n  \
    haptic-camera list"
)]
pub enum Command {
    /// Turn a knob through a sweep, watch it live, and write an archive and a fitted model
    #[command(after_help = "Examples:\n  haptic-camera capture --knob 3 --duration-s 10 --out captures\n  \
        haptic-camera capture --knob 3 --until-ci 1% --duration-s 60\n  \
        haptic-camera capture --knob 5 --diagnose --budget 5")]
    Capture(capture::CaptureOptions),
    /// Make the rig feel like a model, and record it
    #[command(after_help = "Examples:\n  haptic-camera replay 3\n  \
        haptic-camera replay composed.toml --hand multisine --duration-s 10\n  \
        haptic-camera replay 5 --nearest\n\n\
        While it runs, `haptic-camera tune` changes the model's parameters.")]
    Replay(replay::ReplayOptions),
    /// Change a parameter of a running replay's model, or switch to another model
    #[command(after_help = "Examples:\n  haptic-camera tune detent_amplitude=8 coulomb_positive=5\n  \
        haptic-camera tune --model 1\n  haptic-camera tune")]
    Tune(tune::TuneOptions),
    /// Fit a model to a capture, or one model to several captures of the same knob
    #[command(after_help = "Example:\n  haptic-camera fit captures/20261121-101500-knob-3.mcap --report knob-3.html")]
    Fit(fit::FitOptions),
    /// Find where a model and a capture disagree, name the missing effects, and add them
    #[command(after_help = "Example:\n  \
        haptic-camera diagnose train.csv --heldout heldout.csv --report diagnosis.html")]
    Diagnose(diagnose::DiagnoseOptions),
    /// Measure the rig's zeros, gravity, delays, gripper inertia, motor cogging or friction
    #[command(
        after_help = "Uses the given captures, or turns the rig (with nothing on the gripper), in this order:\n  \
        haptic-camera calibrate zero --out rig.toml\n  \
        haptic-camera calibrate gravity --calibration rig.toml --out rig.toml\n  \
        haptic-camera calibrate latency --calibration rig.toml --out rig.toml\n  \
        haptic-camera calibrate gripper --calibration rig.toml --out rig.toml\n  \
        haptic-camera calibrate friction --calibration rig.toml --out rig.toml\n  \
        haptic-camera capture --calibration rig.toml --knob 3"
    )]
    Calibrate(calibrate::CalibrateOptions),
    /// Test the rig without a knob: compare its measurements with its commands
    #[command(after_help = "Example:\n  haptic-camera rig-test --offline --json rig-test.json")]
    RigTest(rig_test::RigTestOptions),
    /// Check a fitted model against counted detents and breakaway torques
    #[command(after_help = "Example:\n  \
        haptic-camera capture --knob 3 --sweep slow-turn --duration-s 15\n  \
        haptic-camera capture --sweep slow-turn --amplitude 0.1 --duration-s 15\n  \
        haptic-camera check TURN.mcap CREEP.mcap --model knob-3.toml")]
    Check(check::CheckOptions),
    /// Compare captures and models in one table and page, as in the paper's Tables 4 to 6
    #[command(after_help = "Example:\n  haptic-camera compare captures/*.mcap mix.toml 3 --report knobs.html")]
    Compare(compare::CompareOptions),
    /// Judge each unit by a specification: pass, fail, or undecided where an interval straddles a limit
    #[command(after_help = "Example:\n  haptic-camera judge unit-*.mcap --spec spec.toml\n\n\
        Exit status: 0 all pass, 4 one fails, 5 one is undecided and none fails.")]
    Judge(judge::JudgeOptions),
    /// Compute the capability of a process: Cp and Cpk, Pp and Ppk, with intervals
    #[command(after_help = "Example:\n  haptic-camera capability batch/*.csv --spec spec.toml --dfq batch.dfq")]
    Capability(studies::CapabilityOptions),
    /// Compute a tester's repeatability and reproducibility by analysis of variance: %GRR, ndc
    #[command(after_help = "Examples:\n  haptic-camera gauge study/*/*/*.mcap --spec spec.toml\n  \
        haptic-camera gauge --values study.csv --figure collapse_force")]
    Gauge(studies::GaugeOptions),
    /// Compute the data sheet of a slow turn or a press: pitch, peak, friction; or collapse, valley, snap
    #[command(
        after_help = "Examples:\n  haptic-camera sheet captures/20261121-101500-knob-3.mcap --report sheet.html\n  \
        haptic-camera sheet dome/ --json sheet.json\n  \
        haptic-camera sheet bench.mf4 --columns angle=Winkel,torque=M"
    )]
    Sheet(sheet::SheetOptions),
    /// Simulate a model along a capture's motion or torque, and report its relative error
    #[command(after_help = "Examples:\n  \
        haptic-camera simulate model.toml --like capture.mcap\n  \
        haptic-camera simulate model.toml --like capture.mcap --out simulated.mcap")]
    Simulate(simulate::SimulateOptions),
    /// Compose a model from one knob's inertia, another's friction and a third one's detents
    #[command(after_help = "Examples:\n  \
        haptic-camera compose --inertia 2 --friction 1 --detents 3 --out mix.toml\n  \
        haptic-camera compose --inertia 2 --friction 4 --detents drawn.csv --set table_scale=1.5 --out new.toml\n\n\
        Inertia resists acceleration. Friction resists turning, and includes static friction and everything that modulates \
        friction. Detents are all torques that repeat along the angle. Every other effect is added with --extra.")]
    Compose(compose::ComposeOptions),
    /// List the captures of a folder by time: knob, length, quality of the fit, damage
    #[command(after_help = "Examples:\n  haptic-camera list\n  haptic-camera list captures --json")]
    List(list::ListOptions),
    /// Fit all captures in folders, on all cores: one row per capture in a Parquet file
    #[command(after_help = "Example:\n  haptic-camera table captures --out captures.parquet\n\n\
        If killed, the same command continues where it stopped. A file that cannot be read or fitted becomes a row \
        with the error.")]
    Table(table::TableOptions),
    /// Show how parameters in a table change over time: drift of a rig, wear of a knob
    #[command(after_help = "Example:\n  haptic-camera trend captures.parquet --by rig --report trend.html")]
    Trend(trend::TrendOptions),
    /// Open the live view of the running capture, or of a finished one
    #[command(
        after_help = "Examples:\n  haptic-camera view\n  haptic-camera view captures/20261121-101500-knob-3.mcap --native"
    )]
    View(view::ViewOptions),
    /// Recompute the torques of a recorded replay, and check that they are equal bit for bit
    #[command(after_help = "Example:\n  haptic-camera recompute captures/20261121-101500-replay-knob-3.mcap")]
    Recompute(recompute::RecomputeOptions),
    /// Write a capture as CSV or Parquet, or a model as a torque table, a C header, or a file for a simulator
    #[command(
        after_help = "Examples:\n  haptic-camera export captures/20261121-101500-knob-3.mcap --out knob-3.csv\n  \
        haptic-camera export captures/20261121-101500-knob-3.mcap --out knob-3.parquet\n  \
        haptic-camera export knob-3.toml --out knob-3.h --points 128\n  \
        haptic-camera export 4 --out knob-4.csv --over turn"
    )]
    Export(export::ExportOptions),
    /// Recover a truncated or damaged archive
    #[command(after_help = "Example:\n  haptic-camera recover broken.mcap --out whole.mcap")]
    Recover(recover::RecoverOptions),
    /// Check this machine: real-time priority, memory, shared memory, programs
    #[command(after_help = "Examples:\n  haptic-camera doctor\n  haptic-camera doctor --rig my-rig.toml")]
    Doctor(doctor::DoctorOptions),
    /// Attach your own rig: write its file, check it without torque, commission it
    #[command(
        subcommand,
        after_help = "Examples:\n  haptic-camera rig new --out my-rig.toml\n  haptic-camera rig check my-rig.toml\n  \
        haptic-camera rig commission my-rig.toml\n  haptic-camera capture --rig my-rig.toml --rate-hz 5000"
    )]
    Rig(rigs::RigCommand),
    /// Print shell completions
    #[command(after_help = "Examples:\n  \
        haptic-camera completions bash > ~/.local/share/bash-completion/completions/haptic-camera\n  \
        haptic-camera completions zsh > ~/.zfunc/_haptic-camera\n  \
        haptic-camera completions fish > ~/.config/fish/completions/haptic-camera.fish")]
    Completions {
        /// The shell
        #[arg(value_enum)]
        shell: clap_complete::Shell,
    },
    /// Write manual pages, one for each command
    #[command(after_help = "Example:\n  haptic-camera man ~/.local/share/man/man1 && man haptic-camera-capture")]
    Man {
        /// The folder for the pages; created if it does not exist
        #[arg(value_name = "DIR")]
        folder: PathBuf,
    },
}

/// The columns of a file of unknown format.
#[derive(Clone, Debug, Args)]
pub struct ColumnOptions {
    /// Columns of a table or channels of an MDF file: angle=NAME,torque=NAME or travel=NAME,force=NAME, optionally time=NAME and
    /// contact=NAME (a voltage that falls); a column also by its number from 1, a channel as GROUP/NAME
    #[arg(long, value_name = "WHAT=NAME,…")]
    pub columns: Option<Assignments>,
    /// Units of these columns, as angle=deg,torque=Ncm [default: as the file or the columns' names have them, else rad, mNm, mm, N, s]
    #[arg(long, value_name = "WHAT=UNIT,…", requires = "columns")]
    pub units: Option<Assignments>,
}

impl ColumnOptions {
    /// The chosen columns; `None` where the file's format determines them.
    pub fn choice(&self) -> Result<Option<ColumnChoice>, UsageError> {
        let Some(columns) = self.columns.clone() else { return Ok(None) };
        let choice = ColumnChoice::new(columns, self.units.clone().unwrap_or_default());
        choice.map(Some).map_err(|error| UsageError(anyhow::anyhow!("--columns and --units: {error}")))
    }
}

/// Options of commands that turn the rig without a knob.
#[derive(Debug, Args)]
pub struct RigOptions {
    #[command(flatten)]
    pub request: RigRequest,
    /// Run the simulated rig as fast as the processor can, without the real-time processes
    #[arg(long)]
    pub offline: bool,
    /// Folder for the captures
    #[arg(long, default_value = "captures", value_name = "DIR")]
    pub captures_in: PathBuf,
}

/// Options of a run and its outputs.
#[derive(Clone, Debug, Args)]
pub struct RunOptions {
    /// Folder for the archive, model and report
    #[arg(long, default_value = "captures", value_name = "DIR")]
    pub out: PathBuf,
    /// Run without the live view
    #[arg(long)]
    pub no_viewer: bool,
    /// Show the live view in a window instead of a web page
    #[arg(long, conflicts_with = "no_viewer")]
    pub native_viewer: bool,
    /// Run the simulated rig as fast as the processor can, without the real-time processes
    #[arg(long)]
    pub offline: bool,
}

impl RunOptions {
    /// The viewer's argument; `None` without a live view.
    pub fn viewer(&self) -> Option<&'static str> {
        (!self.no_viewer).then_some(if self.native_viewer { "--native" } else { "--web" })
    }
}
