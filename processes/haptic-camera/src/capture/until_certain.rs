//! Slow turn after slow turn until the verdict on a unit is certain.

use std::sync::atomic::{AtomicBool, Ordering};

use archive::testers::Curve;
use dynamics::Axis;
use sheet::{Judgement, Sheet, Verdict};

use super::CaptureOptions;
use super::next::Experiment;
use super::until_named::one_more;
use crate::judge;
use crate::outcome::{Outcome, remark, say};

/// The motion from which static figures are read, and how long it takes there and back, s.
const TURN: (&str, f64) = ("slow-turn", 15.0);

/// Turns or presses the unit until it passes or fails, or the turns are spent.
pub(super) fn run(
    options: &CaptureOptions,
    spec: &std::path::Path,
    interrupted: &AtomicBool,
) -> anyhow::Result<Outcome> {
    let specification = analysis::load_specification(spec)?;
    let mut options = options.clone();
    options.request.duration_s = TURN.1;
    let mut curves: Vec<Curve> = Vec::new();
    let mut worst = Outcome::Done;
    let mut verdict = Verdict::Undecided;
    while verdict == Verdict::Undecided && curves.len() < options.turns as usize {
        let experiment = Experiment { sweep: TURN.0.to_owned(), amplitude_rad: options.request.amplitude };
        let Some((taken, outcome)) = one_more(&options, experiment, curves.len(), interrupted)? else {
            return Ok(Outcome::Failed);
        };
        if outcome == Outcome::Failed || interrupted.load(Ordering::Acquire) {
            remark("no verdict: it needs a complete slow turn");
            return Ok(outcome);
        }
        worst = worst.worse(outcome);
        curves.push(taken.loaded.curve());
        let judgement = specification.judge(&Sheet::of(&evidence(&curves))?);
        tell(curves.len(), &judgement);
        verdict = judgement.verdict;
    }
    Ok(if worst == Outcome::Done { judge::outcome(verdict) } else { worst })
}

/// All turns as one curve, whose figures are known the better the longer it is; presses each by itself, as testers read them.
fn evidence(curves: &[Curve]) -> Vec<Curve> {
    let mut all = curves.iter().cloned();
    let Some(mut whole) = all.next().filter(|curve| curve.axis == Axis::Rotary) else { return curves.to_vec() };
    for curve in all {
        let before_s = whole.t_s.as_ref().and_then(|t_s| t_s.last().copied()).unwrap_or(0.0);
        if let (Some(t_s), Some(more)) = (&mut whole.t_s, &curve.t_s) {
            let step_s = more.get(1).copied().unwrap_or(0.0) - more.first().copied().unwrap_or(0.0);
            t_s.extend(more.iter().map(|time_s| before_s + step_s + time_s));
        }
        whole.position.extend(&curve.position);
        whole.load.extend(&curve.load);
    }
    vec![whole]
}

fn tell(turns: usize, Judgement { verdict, reasons, .. }: &Judgement) {
    let after = if turns == 1 { "after the first slow turn".to_owned() } else { format!("after {turns} slow turns") };
    let reasons: String = reasons.iter().map(|reason| format!("; {reason}")).collect();
    say(format!("{} {after}{reasons}", verdict.word()));
}
