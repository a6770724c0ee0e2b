//! `doctor`: what this machine permits.

use std::fs;
use std::path::{Path, PathBuf};

use clap::Args;
use comfy_table::{ContentArrangement, Table, presets};
use nix::sys::resource::{Resource, getrlimit};
use nix::unistd::geteuid;
use rt_loop::plan::Plan;
use shared_types::clean_up::files_in_shared_memory;
use shared_types::rig;
use shared_types::shared_memory::NEEDED_BYTES;

use crate::outcome::{Outcome, say};
use crate::rigs::RigFileOptions;
use crate::supervision::program_path;
use crate::terminal::WIDTH;

#[derive(Debug, Args)]
pub struct DoctorOptions {
    /// Also check whether this rig's driver is available
    #[arg(long, value_name = "FILE.toml")]
    pub rig: Option<PathBuf>,
}

const PROGRAMS: [&str; 4] = ["rt-loop", "recorder", "live-fitter", "rerun-viewer"];

/// The finding of one check: `Ok` describes what is in order, `Err` the fault and its remedy.
type Finding = Result<String, String>;

pub fn run(options: &DoctorOptions) -> anyhow::Result<Outcome> {
    let mut findings = vec![
        ("real-time priority", priority()),
        ("memory locking", memory_locking()),
        ("cores", cores()),
        ("scheduler guard", Ok(scheduler_guard())),
        ("shared memory", shared_memory()),
        ("rig", Ok(leftovers())),
        ("programs", programs()),
    ];
    if let Some(path) = &options.rig {
        findings.extend(rig_file(path));
    }
    let mut table = Table::new();
    table.load_preset(presets::NOTHING).set_content_arrangement(ContentArrangement::Dynamic).set_width(WIDTH);
    for (subject, finding) in &findings {
        let (Ok(found) | Err(found)) = finding;
        table.add_row([if finding.is_ok() { "ok" } else { "!!" }, subject, found]);
    }
    say(table);
    let amiss = findings.iter().filter(|(_, finding)| finding.is_err()).count();
    if amiss > 0 {
        say(format!("{amiss} of {} checks failed; captures still run unless programs are missing", findings.len()));
        return Ok(Outcome::Failed);
    }
    Ok(Outcome::Done)
}

fn judged(is_good: bool, found: impl Into<String>, amiss: impl Into<String>) -> Finding {
    if is_good { Ok(found.into()) } else { Err(amiss.into()) }
}

fn priority() -> Finding {
    let allowed = getrlimit(Resource::RLIMIT_RTPRIO).map_or(0, |(soft, _)| soft);
    let amiss =
        format!("SCHED_FIFO up to {allowed}; put `@users - rtprio 90` into /etc/security/limits.d/ and log in again");
    judged(geteuid().is_root() || allowed >= 80, "SCHED_FIFO is permitted", amiss)
}

fn memory_locking() -> Finding {
    let allowed = getrlimit(Resource::RLIMIT_MEMLOCK).map_or(0, |(soft, _)| soft);
    let kibibytes = allowed / 1024;
    let amiss =
        format!("only {kibibytes} KiB may be locked; put `@users - memlock unlimited` into /etc/security/limits.d/");
    judged(geteuid().is_root() || kibibytes >= 256 * 1024, "memory may be locked", amiss)
}

fn cores() -> Finding {
    let count = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let amiss = "one only: the loop shares it with everything else and will miss ticks";
    judged(count > 1, format!("{count}; the loop takes the last one"), amiss)
}

fn scheduler_guard() -> String {
    let runtime = fs::read_to_string("/proc/sys/kernel/sched_rt_runtime_us").unwrap_or_default();
    match runtime.trim() {
        "" => "unknown to this kernel; nothing to do".to_owned(),
        "-1" => "no guard: a runaway real-time thread would hang its core".to_owned(),
        runtime => format!("real-time threads get {runtime} of every 1000000 us; the loop needs less"),
    }
}

fn shared_memory() -> Finding {
    let free = nix::sys::statvfs::statvfs("/dev/shm").map_or(0, |stat| stat.blocks_available() * stat.fragment_size());
    let found = format!("{} MiB free in /dev/shm", free >> 20);
    let amiss = format!("{found}, {} needed; remove files from it", NEEDED_BYTES >> 20);
    judged(free >= NEEDED_BYTES, found, amiss)
}

fn leftovers() -> String {
    match files_in_shared_memory(&rig::runtime_dir()).len() {
        0 => "no files of this rig in shared memory".to_owned(),
        count => format!(
            "{count} files of this rig in shared memory: a capture is running, or one was killed (the next one \
             removes them)"
        ),
    }
}

/// Whether the driver that the rig's file names is available, and what stands in its way; the amplifier stays off.
fn rig_file(path: &Path) -> Vec<(&'static str, Finding)> {
    let options = RigFileOptions { file: path.to_owned(), rate_hz: None };
    let plan = match options.torque_request(1.0).and_then(|request| Ok(Plan::new(&request)?)) {
        Ok(plan) => plan,
        Err(error) => return vec![("rig file", Err(error.to_string()))],
    };
    let (name, path) = (&plan.rig.name, path.display());
    let found = format!("the driver of '{name}' is available; test it with `haptic-camera rig check {path}`");
    let obstacles = plan.apparatus.obstacles().into_iter().map(|amiss| ("rig", Err(amiss)));
    std::iter::once(("rig file", Ok(found))).chain(obstacles).collect()
}

fn programs() -> Finding {
    let mut missing = PROGRAMS.to_vec();
    missing.retain(|name| !program_path(name).is_ok_and(|path| path.exists()));
    let amiss = format!("missing in this program's folder: {}; build the whole workspace", missing.join(", "));
    judged(missing.is_empty(), "all there", amiss)
}
