//! `calibrate`: what is known of the rig, found out from captures.

use std::fmt::Write as _;
use std::path::PathBuf;

use analysis::CalibrationKind;
use anyhow::Context as _;
use clap::Args;
use comfy_table::Table;
use dynamics::Calibration;
use identification::calibration::{self, Calibrated, CoggingEstimate};
use identification::statistics::plus_minus;
use loaded_capture::CALIBRATION_MARK;
use rt_loop::request::{Pace, RunRequest};
use shared_types::RunDescription;

use crate::command_line::RigOptions;
use crate::command_line::outputs::{show_on, write};
use crate::outcome::{Outcome, say};
use crate::supervision::Interrupt;
use crate::terminal::{self, digits, number};
use crate::{load, rig_run};

#[derive(Debug, Args)]
#[command(mut_arg("calibration", |calibration| calibration
    .help("The previous calibration, instead of the captures' own")
    .value_name("PREVIOUS.toml")))]
pub struct CalibrateOptions {
    /// What to calibrate
    #[arg(value_enum, value_name = "WHAT")]
    pub what: CalibrationKind,
    /// Captures to calibrate from; without any the rig is turned, with nothing on the gripper
    #[arg(value_name = "CAPTURE", conflicts_with_all = ["offline", "captures_in"])]
    pub captures: Vec<PathBuf>,
    /// Write the calibration here; may be the file given as --calibration
    #[arg(long, value_name = "CALIBRATION.toml")]
    pub out: PathBuf,
    #[command(flatten)]
    pub pace: Pace,
    #[command(flatten)]
    pub rig: RigOptions,
}

/// Amplitude of the fast sines with nothing on the gripper, rad; on a linear axis the travel of a fingertip at that angle.
const FAST_AMPLITUDE_RAD: f64 = 0.1;

pub fn run(options: &CalibrateOptions) -> anyhow::Result<Outcome> {
    let given = options.rig.request.calibration.as_deref();
    let mut known = given.map(Calibration::load).transpose()?;
    let (captures, outcome) = if options.captures.is_empty() {
        let (capture, outcome) = capture(options)?;
        (vec![capture], outcome)
    } else {
        (options.captures.clone(), Outcome::Done)
    };
    let (what, mut found, mut is_of_motor) = (options.what, Vec::new(), false);
    for path in &captures {
        let loaded = load::load(path)?;
        // A file holds the rig's own calibration; a capture that of its torque.
        is_of_motor = loaded.capture.description.as_ref().is_some_and(RunDescription::has_motors_torque);
        let of_rig = |known: &Calibration| if is_of_motor { known.without_rotor() } else { known.clone() };
        let own = known.clone().or_else(|| loaded.calibration.as_ref().map(of_rig)).with_context(|| {
            format!("{} has no calibration of its rig; give one with --calibration PREVIOUS.toml", path.display())
        })?;
        let base = if is_of_motor { own.with_rotor() } else { own.clone() };
        let of_angle = matches!(what, CalibrationKind::Gravity | CalibrationKind::Cogging);
        anyhow::ensure!(
            base.axis.is_rotary() || !of_angle,
            "a rig with a linear axis has no {} that repeats with every turn; use `calibrate zero` for what is \
             constant over the travel",
            what.subject()
        );
        let useless = || format!("{} does not calibrate the {}", path.display(), what.subject());
        found.push(what.calibrate(&loaded, &base).with_context(useless)?);
        known.get_or_insert(own);
    }
    let (Some(known), Some(mut calibrated)) = (known, calibration::combine(&found)) else {
        anyhow::bail!("there is no capture to calibrate from");
    };
    if is_of_motor && let Some(gripper) = calibrated.estimates.iter_mut().find(|one| one.quantity == "gripper_inertia")
    {
        gripper.value = (gripper.value - known.motor_inertia).max(0.0);
    }
    let mut lines = Vec::new();
    if !calibrated.estimates.is_empty() {
        lines.push(table(&known, &calibrated).to_string());
    }
    let cogging = calibrated.cogging.iter().flat_map(|cogging| cogging_lines(cogging));
    lines.extend(cogging.map(|line| format!("cogging  {line}")));
    lines.extend(calibrated.notes.iter().map(|note| format!("- {note}")));
    show_on(known.axis, lines);
    write_file(options, &calibrated, &known, &captures)?;
    say(format!("calibration  {}", options.out.display()));
    Ok(outcome)
}

/// Makes the capture that a calibration needs; gives it, and whether data was lost.
fn capture(CalibrateOptions { what, pace, rig, .. }: &CalibrateOptions) -> anyhow::Result<(PathBuf, Outcome)> {
    let alone =
        |sweep: &str, duration_s| rig_run::request("none", sweep, duration_s, pace.clone(), rig.request.clone());
    let travel = rt_loop::rigs::file(&rig.request)?.axis.fingertip_travel();
    let request = match what {
        CalibrationKind::Friction => alone("linear-chirp", 10.0),
        CalibrationKind::Gravity | CalibrationKind::Cogging => alone("slow-turn", 15.0),
        CalibrationKind::Zero => RunRequest { torque: true, ..alone("hold", 5.0) },
        CalibrationKind::Gripper | CalibrationKind::Latency => {
            RunRequest { amplitude: Some(FAST_AMPLITUDE_RAD * travel), ..alone("fast-multisine", 10.0) }
        }
    };
    let interrupt = Interrupt::listen()?;
    rig_run::archive(request, &rig.captures_in, rig.offline, &format!("calibrate-{}", what.subject()), &interrupt)
}

/// Writes the known calibration with the newly found values. Comments give the interval and the source of each new value; the
/// comments of the previous file on the other values are kept.
fn write_file(
    options: &CalibrateOptions,
    calibrated: &Calibrated,
    known: &Calibration,
    captures: &[PathBuf],
) -> anyhow::Result<()> {
    let previous = options.rig.request.calibration.as_deref();
    let before = previous.map(foreign_files::read_text).transpose()?.unwrap_or_default();
    let estimates = calibrated.estimates.iter().map(|estimate| {
        let (digits, half_width) = (digits(estimate.half_width), estimate.half_width);
        let [quantity, unit] = [estimate.quantity, estimate.unit].map(|text| known.axis.words(text));
        (quantity, format!("{:.digits$} ± {half_width:.digits$} {unit}", estimate.value))
    });
    let cogging = calibrated.cogging.iter().flat_map(|cogging| cogging_lines(cogging));
    let found: Vec<_> = estimates.chain(cogging.map(|line| ("motor_cogging".into(), line))).collect();
    let is_kept = |line: &&str| !found.iter().any(|(quantity, _)| line.starts_with(&format!("# {quantity}:")));
    let mut text = CALIBRATION_MARK.to_owned();
    for comment in before.lines().filter(|line| line.starts_with("# ")).filter(is_kept) {
        let _ = writeln!(text, "{comment}");
    }
    let date = jiff::Zoned::now().strftime("%Y-%m-%d %H:%M:%S %Z");
    let sources = captures.iter().map(|capture| capture.display().to_string()).collect::<Vec<_>>().join(", ");
    for (quantity, value) in found {
        let _ = writeln!(text, "# {quantity}: {value}, 95 %, {date} from {sources}");
    }
    let learnt = calibrated.applied_to(known);
    let out = &options.out;
    learnt.check().with_context(|| {
        format!("{} is not written: the captures give a calibration that no rig can have", out.display())
    })?;
    text += &learnt.to_toml();
    write(out, options.replaced(), &text)
}

fn table(known: &Calibration, calibrated: &Calibrated) -> Table {
    let before = toml::Table::try_from(known).unwrap_or_default();
    let rows = calibrated.estimates.iter().map(|estimate| {
        // Delays are fractions of a sample: microseconds read better.
        let (factor, unit) = if estimate.unit == "s" { (1e6, "µs") } else { (1.0, estimate.unit) };
        let digits = digits(factor * estimate.half_width);
        let believed = before.get(estimate.quantity).and_then(toml::Value::as_float);
        [
            estimate.quantity.to_owned(),
            number(believed.map(|value| factor * value), digits),
            format!("{:.digits$}", factor * estimate.value),
            format!("±{:.digits$}", factor * estimate.half_width),
            unit.to_owned(),
        ]
    });
    terminal::table(["quantity", "before", "found", "95 %", "unit"], 1..4, rows)
}

/// Each harmonic of a motor's cogging with its intervals; one line that says so where there is none.
fn cogging_lines(cogging: &[CoggingEstimate]) -> Vec<String> {
    if cogging.is_empty() {
        return vec!["none".to_owned()];
    }
    let line = |harmonic: &CoggingEstimate| {
        let CoggingEstimate { per_turn, torque_mnm, torque_half_width_mnm, phase_rad, phase_half_width_rad } = harmonic;
        let torque = plus_minus(*torque_mnm, *torque_half_width_mnm);
        let phase = plus_minus(*phase_rad, *phase_half_width_rad);
        format!("{per_turn} per turn of {torque} mNm, phase {phase} rad")
    };
    cogging.iter().map(line).collect()
}
