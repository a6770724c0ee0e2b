//! One run of `haptic-camera diagnose` and what is right or wrong about it.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context as _, Result, bail};
use hidden_effects::capture::Answer;
use serde::Deserialize;

/// A pair of captures and its answer.
pub struct Case {
    /// Where `train.csv` and `heldout.csv` are.
    pub folder: PathBuf,
    /// Its folder's name.
    pub name: String,
    /// What it hides.
    pub answer: Answer,
}

/// What the command's JSON says.
#[derive(Deserialize)]
pub struct Diagnosis {
    verdict: String,
    #[serde(default)]
    effects: Vec<String>,
    heldout_rms_before: Option<f64>,
    heldout_rms_after: Option<f64>,
    noise_floor_rms: Option<f64>,
    #[serde(default)]
    steps: Vec<Step>,
}

#[derive(Deserialize)]
struct Step {
    effect: String,
    heldout_rms_after: Option<f64>,
    #[serde(default)]
    rivals: Vec<Rival>,
}

#[derive(Deserialize)]
struct Rival {
    effect: String,
    heldout_rms_after: Option<f64>,
}

/// A diagnosis, or why there is none; and how long it took, s.
pub struct Outcome {
    /// What was said.
    pub said: Result<Diagnosis>,
    /// Wall-clock time, s.
    pub seconds: f64,
}

/// A case with its outcome.
pub struct Judged {
    /// The pair of captures.
    pub case: Case,
    /// What became of it.
    pub outcome: Outcome,
}

/// A rival that is right counts as doubt if it explains the held-out capture this nearly as well.
const AS_GOOD: f64 = 1.05;

/// Runs the command on a case. A crash, a timeout and a missing or unreadable JSON are errors in the outcome.
pub fn diagnose(program: &Path, case: &Case, timeout: Duration) -> Outcome {
    let start = Instant::now();
    let said = run(program, &case.folder, timeout);
    Outcome { said, seconds: start.elapsed().as_secs_f64() }
}

fn run(program: &Path, folder: &Path, timeout: Duration) -> Result<Diagnosis> {
    let json = folder.join("diagnosis.json");
    _ = fs::remove_file(&json);
    let spoken = fs::File::create(folder.join("diagnosis.txt")).context("cannot keep what the command says")?;
    let mut child = Command::new(program)
        .arg("diagnose")
        .arg(folder.join("train.csv"))
        .arg("--heldout")
        .arg(folder.join("heldout.csv"))
        .arg("--json")
        .arg(&json)
        .stdin(Stdio::null())
        .stdout(spoken.try_clone()?)
        .stderr(spoken)
        .spawn()
        .with_context(|| format!("cannot start {}", program.display()))?;
    let deadline = Instant::now() + timeout;
    let status = loop {
        if let Some(status) = child.try_wait()? {
            break status;
        }
        if Instant::now() > deadline {
            child.kill()?;
            child.wait()?;
            bail!("took longer than {} s", timeout.as_secs_f64());
        }
        thread::sleep(Duration::from_millis(5));
    };
    // 3: done, but data was lost. The diagnosis counts.
    if !status.success() && status.code() != Some(3) {
        bail!("ended with {status}");
    }
    let text = fs::read_to_string(&json).context("wrote no JSON")?;
    serde_json::from_str(&text).context("wrote JSON that is no diagnosis")
}

impl Judged {
    fn said(&self) -> Option<&Diagnosis> {
        self.outcome.said.as_ref().ok()
    }

    /// The one hidden effect, `none`, `outside-library`, `pair`, or `triple`.
    pub fn truth(&self) -> &str {
        match self.case.answer.effects.as_slice() {
            [] => &self.case.answer.verdict,
            [one] => one,
            [_, _] => "pair",
            _ => "triple",
        }
    }

    /// The name said first, or the verdict if it names nothing, or `failed`.
    pub fn first_said(&self) -> &str {
        match self.said() {
            None => "failed",
            Some(said) if said.verdict == "effects" => said.effects.first().map_or("none", String::as_str),
            Some(said) => &said.verdict,
        }
    }

    /// The strongest name said is hidden there; or nothing is named where nothing nameable is hidden.
    pub fn first_right(&self) -> bool {
        let answer = &self.case.answer;
        if answer.effects.is_empty() {
            self.first_said() == answer.verdict
        } else {
            answer.effects.iter().any(|effect| effect == self.first_said())
        }
    }

    /// Verdict and set of names are right.
    pub fn exact(&self) -> bool {
        let answer = &self.case.answer;
        self.said().is_some_and(|said| {
            let named: BTreeSet<_> = said.effects.iter().collect();
            // With that verdict the effects that are listed explain a part only, so they are not held against the answer.
            let names_count = said.verdict != "outside-library";
            said.verdict == answer.verdict && (!names_count || named == answer.effects.iter().collect())
        })
    }

    /// The verdict is that effects of the catalogue explain it, one of them is not there, and no rival that is there
    /// was said to explain the held-out capture as well.
    pub fn wrong_without_doubt(&self) -> bool {
        let Some(said) = self.said().filter(|said| said.verdict == "effects") else { return false };
        let hidden = |name: &String| self.case.answer.effects.contains(name);
        said.effects.iter().filter(|name| !hidden(name)).any(|wrong| {
            let step = said.steps.iter().find(|step| step.effect == *wrong);
            !step.is_some_and(|step| {
                step.rivals.iter().filter(|rival| hidden(&rival.effect)).any(|rival| {
                    matches!((rival.heldout_rms_after, step.heldout_rms_after), (Some(rival), Some(own)) if rival <= AS_GOOD * own)
                })
            })
        })
    }

    /// Share of the reducible held-out residual that was taken away, in RMS: (before − after) / (before − floor).
    /// `None` where the base model leaves no more than a tenth above the floor.
    pub fn gap_closed(&self) -> Option<f64> {
        let said = self.said()?;
        let (before, after, floor) = (said.heldout_rms_before?, said.heldout_rms_after?, said.noise_floor_rms?);
        (before > 1.1 * floor).then(|| (before - after) / (before - floor))
    }

    /// The said noise floor over the known RMS of the torque noise: the filter's noise gain, if the floor is right.
    pub fn floor_ratio(&self) -> Option<f64> {
        Some(self.said()?.noise_floor_rms? / self.case.answer.torque_noise_rms_mnm)
    }

    /// What was said, in one line.
    pub fn words(&self) -> String {
        match &self.outcome.said {
            Err(error) => format!("failed: {error:#}"),
            Ok(said) if said.effects.is_empty() => said.verdict.clone(),
            Ok(said) if said.verdict == "effects" => said.effects.join(" + "),
            Ok(said) => format!("{} ({})", said.verdict, said.effects.join(" + ")),
        }
    }
}
