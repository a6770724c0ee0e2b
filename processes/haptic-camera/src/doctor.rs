//! `doctor`: what this machine permits.

use std::fs;
use std::path::Path;

use comfy_table::{Table, presets};
use nix::sys::resource::{Resource, getrlimit};
use rt_loop::plan::Plan;
use rt_loop::request::RunRequest;
use shared_types::clean_up::files_in_shared_memory;
use shared_types::rig;
use shared_types::shared_memory::NEEDED_BYTES;

use crate::command_line::DoctorOptions;
use crate::outcome::{Outcome, say};
use crate::supervision::program_path;

/// The programs that a capture starts.
const PROGRAMS: [&str; 4] = ["rt-loop", "recorder", "live-fitter", "rerun-viewer"];

/// One thing looked at.
struct Finding {
    subject: &'static str,
    good: bool,
    found: String,
}

/// Looks at everything a capture needs and says what is amiss and how to mend it.
///
/// # Errors
/// Never; what cannot be checked is reported as a problem.
pub fn run(options: &DoctorOptions) -> anyhow::Result<Outcome> {
    let mut findings =
        vec![priority(), memory_locking(), cores(), scheduler_guard(), shared_memory(), leftovers(), programs()];
    if let Some(path) = &options.rig {
        findings.extend(rig_file(path));
    }
    let mut table = Table::new();
    table.load_preset(presets::NOTHING).set_width(80).set_content_arrangement(comfy_table::ContentArrangement::Dynamic);
    for finding in &findings {
        table.add_row([if finding.good { "ok" } else { "!!" }, finding.subject, &finding.found]);
    }
    say(table);
    let amiss = findings.iter().filter(|finding| !finding.good).count();
    if amiss > 0 {
        say(format!("{amiss} of {} checks failed; captures still run unless programs are missing", findings.len()));
        return Ok(Outcome::Failed);
    }
    Ok(Outcome::Done)
}

fn priority() -> Finding {
    let allowed = getrlimit(Resource::RLIMIT_RTPRIO).map_or(0, |(soft, _)| soft);
    let good = nix::unistd::geteuid().is_root() || allowed >= 80;
    let found = if good {
        "SCHED_FIFO is permitted".to_owned()
    } else {
        format!("SCHED_FIFO up to {allowed}; put `@users - rtprio 90` into /etc/security/limits.d/ and log in again")
    };
    Finding { subject: "real-time priority", good, found }
}

fn memory_locking() -> Finding {
    let allowed = getrlimit(Resource::RLIMIT_MEMLOCK).map_or(0, |(soft, _)| soft);
    let good = nix::unistd::geteuid().is_root() || allowed >= 256 * 1024 * 1024;
    let found = if good {
        "memory may be locked".to_owned()
    } else {
        format!(
            "only {} KiB may be locked; put `@users - memlock unlimited` into /etc/security/limits.d/",
            allowed / 1024
        )
    };
    Finding { subject: "memory locking", good, found }
}

fn cores() -> Finding {
    let count = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let found = if count > 1 {
        format!("{count}; the loop takes the last one")
    } else {
        "one only: the loop shares it with everything else and will miss ticks".to_owned()
    };
    Finding { subject: "cores", good: count > 1, found }
}

fn scheduler_guard() -> Finding {
    let runtime = fs::read_to_string("/proc/sys/kernel/sched_rt_runtime_us").unwrap_or_default();
    let runtime = runtime.trim();
    let found = match runtime {
        "" => "unknown to this kernel; nothing to do".to_owned(),
        "-1" => "no guard: a runaway real-time thread would hang its core".to_owned(),
        _ => format!("real-time threads get {runtime} of every 1000000 us; the loop needs less"),
    };
    Finding { subject: "scheduler guard", good: true, found }
}

fn shared_memory() -> Finding {
    let free = nix::sys::statvfs::statvfs("/dev/shm").map_or(0, |stat| stat.blocks_available() * stat.fragment_size());
    let good = free >= NEEDED_BYTES;
    let found = if good {
        format!("{} MiB free in /dev/shm", free >> 20)
    } else {
        format!("{} MiB free in /dev/shm, {} needed; remove files from it", free >> 20, NEEDED_BYTES >> 20)
    };
    Finding { subject: "shared memory", good, found }
}

fn leftovers() -> Finding {
    let count = files_in_shared_memory(&rig::runtime_dir()).len();
    let found = match count {
        0 => "no files of this rig in shared memory".to_owned(),
        _ => format!(
            "{count} files of this rig in shared memory: a capture is running, or one was killed (the next one \
             removes them)"
        ),
    };
    Finding { subject: "rig", good: true, found }
}

/// Whether the rig's driver can be had as its file says, and what stands in its way; its amplifier stays off.
fn rig_file(path: &Path) -> Vec<Finding> {
    let mut request = RunRequest { torque: true, ..RunRequest::default() };
    request.rig.rig = Some(path.to_owned());
    let made = rt_loop::rigs::file(&request.rig).and_then(|file| {
        request.pace.rate_hz = file.rates.map_or(request.pace.rate_hz, |rates| rates.fastest_hz);
        Plan::new(&request)
    });
    let amiss = |found: String| Finding { subject: "rig", good: false, found };
    match made {
        Ok(plan) => {
            let found = format!(
                "the driver of '{}' is available; test it with `haptic-camera rig check {}`",
                plan.rig.name,
                path.display()
            );
            let file = Finding { subject: "rig file", good: true, found };
            std::iter::once(file).chain(plan.apparatus.obstacles().into_iter().map(amiss)).collect()
        }
        Err(error) => vec![Finding { subject: "rig file", good: false, found: error.to_string() }],
    }
}

fn programs() -> Finding {
    let missing: Vec<&str> =
        PROGRAMS.into_iter().filter(|name| !program_path(name).is_ok_and(|path| path.exists())).collect();
    let found = if missing.is_empty() {
        "all there".to_owned()
    } else {
        format!("missing in this program's folder: {}; build the whole workspace", missing.join(", "))
    };
    Finding { subject: "programs", good: missing.is_empty(), found }
}
