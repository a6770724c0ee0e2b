//! The command line: the commands' names; each command's options in a file of their own.

mod calibrate;
mod capture;
mod check;
mod columns;
mod compare;
mod compose;
mod diagnose;
mod doctor;
mod export;
mod files;
mod fit;
mod judge;
mod list;
mod manual;
mod recompute;
mod recover;
mod replay;
mod rig;
mod rig_test;
mod rigs;
mod run;
mod sheet;
mod simulate;
mod studies;
mod table;
mod trend;
mod tune;
mod view;

pub use calibrate::{CalibrateOptions, CalibrationKind};
pub use capture::CaptureOptions;
pub use check::CheckOptions;
pub use columns::ColumnOptions;
pub use compare::CompareOptions;
pub use compose::ComposeOptions;
pub use diagnose::DiagnoseOptions;
pub use doctor::DoctorOptions;
pub use export::{ExportOptions, TableSpan};
pub use fit::FitOptions;
pub use judge::JudgeOptions;
pub use list::ListOptions;
pub use manual::{CompletionsOptions, ManOptions};
pub use recompute::RecomputeOptions;
pub use recover::RecoverOptions;
pub use replay::ReplayOptions;
pub use rig::RigOptions;
pub use rig_test::RigTestOptions;
pub use rigs::{RigCheckOptions, RigCommand, RigCommissionOptions, RigNewOptions, RigScanOptions};
pub use run::RunOptions;
pub use sheet::SheetOptions;
pub use simulate::{SimulateOptions, SimulationDrive};
pub use studies::{CapabilityOptions, GaugeOptions, StudyOptions};
pub use table::TableOptions;
pub use trend::{TrendGroups, TrendOptions};
pub use tune::TuneOptions;
pub use view::ViewOptions;

use clap::{Parser, Subcommand};

/// Captures how a mechanical knob feels, as numbers.
#[derive(Debug, Parser)]
#[command(name = "haptic-camera", version, propagate_version = true)]
#[command(
    after_help = "Exit status: 0 done, 1 failed, 2 wrong usage, 3 done but data was lost,\n4 a judged unit fails, 5 one is undecided.\n\n\
    Environment:\n  \
    RUST_LOG     what is logged to standard error, such as info or recorder=debug\n  \
    NO_COLOR     no colours in the log; they are left out too if it is no terminal\n  \
    HAPTIC_CAMERA_RUNTIME_DIR\n               \
    the rig's directory: two directories are two rigs\n               \
    [default: in $XDG_RUNTIME_DIR, or in the user's home]\n\n\
    First steps:\n  \
    haptic-camera doctor\n  \
    haptic-camera capture --knob 3 --duration-s 10\n  \
    haptic-camera list"
)]
pub struct CommandLine {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// What the program can do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Turn a knob through a sweep, watch it live, and keep an archive and a fitted model
    #[command(after_help = "Examples:\n  haptic-camera capture --knob 3 --duration-s 10 --out captures\n  \
        haptic-camera capture --knob 3 --until-ci 1% --duration-s 60\n  \
        haptic-camera capture --knob 5 --diagnose --budget 5")]
    Capture(CaptureOptions),
    /// Make the rig feel like a model, and record what the hand does
    #[command(after_help = "Examples:\n  haptic-camera replay 3\n  \
        haptic-camera replay composed.toml --hand multisine --duration-s 10\n  \
        haptic-camera replay 5 --nearest\n\n\
        While it runs, `haptic-camera tune` changes the model's parameters.")]
    Replay(ReplayOptions),
    /// Change a parameter of the model that a running replay renders, or switch to another model
    #[command(after_help = "Examples:\n  haptic-camera tune detent_amplitude=8 coulomb_positive=5\n  \
        haptic-camera tune --model 1\n  haptic-camera tune")]
    Tune(TuneOptions),
    /// Fit a model to a capture, or one model to several captures of the same knob
    #[command(after_help = "Example:\n  haptic-camera fit captures/20261121-101500-knob-3.mcap --report knob-3.html")]
    Fit(FitOptions),
    /// Find where a model and a capture disagree, name the missing effect, add it and show the gap shrink
    #[command(after_help = "Example:\n  \
        haptic-camera diagnose train.csv --heldout heldout.csv --report diagnosis.html")]
    Diagnose(DiagnoseOptions),
    /// Find the rig's zeros, gravity, delays, the gripper's inertia, or the motor's cogging or friction
    #[command(
        after_help = "Takes the captures given, or turns the rig itself (nothing on the gripper), in this order:\n  \
        haptic-camera calibrate zero --out rig.toml\n  \
        haptic-camera calibrate gravity --calibration rig.toml --out rig.toml\n  \
        haptic-camera calibrate latency --calibration rig.toml --out rig.toml\n  \
        haptic-camera calibrate gripper --calibration rig.toml --out rig.toml\n  \
        haptic-camera calibrate friction --calibration rig.toml --out rig.toml\n  \
        haptic-camera capture --calibration rig.toml --knob 3"
    )]
    Calibrate(CalibrateOptions),
    /// Test the rig without a knob: how far what it measures is from what was commanded
    #[command(after_help = "Example:\n  haptic-camera rig-test --offline --json rig-test.json")]
    RigTest(RigTestOptions),
    /// Check a fit against what captures show without one: detents counted, breakaways read off
    #[command(after_help = "Example:\n  \
        haptic-camera capture --knob 3 --sweep slow-turn --duration-s 15\n  \
        haptic-camera capture --sweep slow-turn --amplitude 0.1 --duration-s 15\n  \
        haptic-camera check TURN.mcap CREEP.mcap --model knob-3.toml")]
    Check(CheckOptions),
    /// Compare captures and models in one table and page, as the paper's Tables 4 to 6 compare knobs
    #[command(after_help = "Example:\n  haptic-camera compare captures/*.mcap mix.toml 3 --report knobs.html")]
    Compare(CompareOptions),
    /// Judge each unit by a specification: pass, fail, or undecided where an interval straddles a limit
    #[command(after_help = "Example:\n  haptic-camera judge unit-*.mcap --spec spec.toml\n\n\
        Exit status: 0 all pass, 4 one fails, 5 one is undecided and none fails.")]
    Judge(JudgeOptions),
    /// Say whether a process keeps its units within their limits: Cp and Cpk, Pp and Ppk, with intervals
    #[command(after_help = "Example:\n  haptic-camera capability batch/*.csv --spec spec.toml --dfq batch.dfq")]
    Capability(CapabilityOptions),
    /// Say whether a tester is good enough: repeatability and reproducibility by analysis of variance, %GRR, ndc
    #[command(after_help = "Examples:\n  haptic-camera gauge study/*/*/*.mcap --spec spec.toml\n  \
        haptic-camera gauge --values study.csv --figure collapse_force")]
    Gauge(GaugeOptions),
    /// Read the figures of a data sheet off a slow turn or a press: pitch, peak and friction, or collapse, valley and snap
    #[command(
        after_help = "Examples:\n  haptic-camera sheet captures/20261121-101500-knob-3.mcap --report sheet.html\n  \
        haptic-camera sheet dome/ --json sheet.json\n  \
        haptic-camera sheet bench.mf4 --columns angle=Winkel,torque=M"
    )]
    Sheet(SheetOptions),
    /// Simulate a model along a capture's motion or torque, and report its relative error on that capture
    #[command(after_help = "Examples:\n  \
        haptic-camera simulate model.toml --like capture.mcap\n  \
        haptic-camera simulate model.toml --like capture.mcap --out simulated.mcap")]
    Simulate(SimulateOptions),
    /// Compose a model of one knob's inertia, another's friction and a third one's detents
    #[command(after_help = "Examples:\n  \
        haptic-camera compose --inertia 2 --friction 1 --detents 3 --out mix.toml\n  \
        haptic-camera compose --inertia 2 --friction 4 --detents drawn.csv --set table_scale=1.5 --out new.toml\n\n\
        Inertia resists acceleration. Friction resists turning, and includes sticking and whatever modulates friction. \
        Detents are all torques that repeat along the angle. Every other effect is taken by itself, with --extra.")]
    Compose(ComposeOptions),
    /// List the captures of a folder by time: knob, length, quality of the fit, whether the archive is whole
    #[command(after_help = "Examples:\n  haptic-camera list\n  haptic-camera list captures --json")]
    List(ListOptions),
    /// Fit every capture of whole folders on all cores: one row per capture, in a Parquet file
    #[command(after_help = "Example:\n  haptic-camera table captures --out captures.parquet\n\n\
        If it is killed, the same command continues where it stopped. A file that cannot be read or fitted becomes a row \
        that says why.")]
    Table(TableOptions),
    /// Show how the parameters of a table's captures change over time: drift of a rig, wear of a knob
    #[command(after_help = "Example:\n  haptic-camera trend captures.parquet --by rig --report trend.html")]
    Trend(TrendOptions),
    /// Open the live view of the running capture, or look at a finished one
    #[command(
        after_help = "Examples:\n  haptic-camera view\n  haptic-camera view captures/20261121-101500-knob-3.mcap --native"
    )]
    View(ViewOptions),
    /// Compute the torques of a recorded replay again, and say whether they are equal bit for bit
    #[command(after_help = "Example:\n  haptic-camera recompute captures/20261121-101500-replay-knob-3.mcap")]
    Recompute(RecomputeOptions),
    /// Write a capture as CSV or Parquet, or a model as a torque table, a C header, or a file for a simulator
    #[command(
        after_help = "Examples:\n  haptic-camera export captures/20261121-101500-knob-3.mcap --out knob-3.csv\n  \
        haptic-camera export captures/20261121-101500-knob-3.mcap --out knob-3.parquet\n  \
        haptic-camera export knob-3.toml --out knob-3.h --points 128\n  \
        haptic-camera export 4 --out knob-4.csv --over turn"
    )]
    Export(ExportOptions),
    /// Make a whole archive from one that was cut short or damaged
    #[command(after_help = "Example:\n  haptic-camera recover broken.mcap --out whole.mcap")]
    Recover(RecoverOptions),
    /// Check what this machine permits: real-time priority, memory, shared memory, programs
    #[command(after_help = "Examples:\n  haptic-camera doctor\n  haptic-camera doctor --rig my-rig.toml")]
    Doctor(DoctorOptions),
    /// Attach a rig of your own: write its file, bring it up without torque, turn it gently for the first time
    #[command(
        subcommand,
        after_help = "Examples:\n  haptic-camera rig new --out my-rig.toml\n  haptic-camera rig check my-rig.toml\n  \
        haptic-camera rig commission my-rig.toml\n  haptic-camera capture --rig my-rig.toml --rate-hz 5000"
    )]
    Rig(RigCommand),
    /// Print the completions of a shell
    #[command(after_help = "Examples:\n  \
        haptic-camera completions bash > ~/.local/share/bash-completion/completions/haptic-camera\n  \
        haptic-camera completions zsh > ~/.zfunc/_haptic-camera\n  \
        haptic-camera completions fish > ~/.config/fish/completions/haptic-camera.fish")]
    Completions(CompletionsOptions),
    /// Write manual pages, one for each command
    #[command(after_help = "Example:\n  haptic-camera man ~/.local/share/man/man1 && man haptic-camera-capture")]
    Man(ManOptions),
}
