//! The steps from a capture and a model to a verdict.

use dynamics::{Axis, Calibration, Model, effects};

use super::capture::encoder_zero::EncoderZero;
use super::capture::{Capture, EDGE_HZ, Stretches};
use super::comparison::{BEYOND, Comparison};
use super::error::DiagnosisError;
use super::findings::{Diagnosis, Verdict};
use super::model_fit::undetermined::Undetermined;
use super::search::Search;
use super::search::acceptance::explains_the_gap;
use super::search::found::Found;
use super::verdict::commanded::CommandedTorque;
use crate::fit::{fit_in_time, opposite_signs};
use crate::quasi_static::Map;
use crate::{FitError, FitOptions, Samples};

/// Largest noise of acceleration, as a share of its RMS: with more, inertia is underrated by more than a hundredth.
const NOISIEST: f64 = 0.1;
/// Bands are not halved below this edge, Hz.
const NARROWEST_HZ: f64 = 8.0;

/// Most searches, each with the angle between the encoder's two zeros that the search before it found.
const MOST_ROUNDS: usize = 3;

/// What a diagnosis may be told; nothing need be.
#[derive(Clone, Default)]
pub struct DiagnoseOptions<'a> {
    /// What is known of the rig.
    pub calibration: Option<Calibration>,
    /// Whether the knob turns.
    pub axis: Axis,
    /// The model to start from; without one, inertia, friction and detents as they are fitted to the training capture.
    pub model: Option<Model>,
    /// How far from its start the knob may be turned to tell rivals apart, rad; without it as far as it was.
    pub reach_rad: Option<f64>,
    /// What was commanded from the rig's motor in the training and in the held-out capture, where the captures tell; twice the same without
    /// a held-out one.
    pub commanded: Option<[CommandedTorque<'a>; 2]>,
    /// Called as the work goes on.
    pub progress: Option<&'a (dyn Fn(Progress) + Sync)>,
}

impl DiagnoseOptions<'_> {
    /// The options of the fit from which a diagnosis begins.
    pub(super) fn of_fit(&self) -> FitOptions {
        FitOptions {
            calibration: self.calibration.clone(),
            // A pressed control has a curve instead of detents.
            characteristic: !self.axis.is_rotary(),
            axis: self.axis,
            ..FitOptions::default()
        }
    }
}

/// How far a diagnosis has come.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Progress {
    /// An effect was tried, `done` of `of` in this step.
    Tried {
        /// Its name.
        effect: &'static str,
        /// Effects tried in this step.
        done: usize,
        /// Effects to try in this step.
        of: usize,
    },
    /// An effect was added to the model.
    Added {
        /// Its name.
        effect: &'static str,
        /// RMS left on the held-out capture, in noise floors.
        heldout_over_floor: f64,
    },
}

/// [`diagnose`], repeated with the captures exchanged if something without a name is missing: the training capture's motion may
/// show too little of it to predict the other capture. If the repetition names an effect, or explains both captures without one, it is the
/// answer ([`Diagnosis::captures_are_exchanged`]). A delay alone does not count: most recordings have one.
///
/// # Errors
/// As [`diagnose`].
pub fn diagnose_either_way(
    train: &Samples<'_>,
    heldout: Option<&Samples<'_>>,
    options: &DiagnoseOptions<'_>,
) -> Result<Diagnosis, DiagnosisError> {
    let found = diagnose(train, heldout, options)?;
    let has_no_name = found.verdict == Verdict::OutsideLibrary && !names_more_than_a_delay(&found);
    let Some(heldout) = heldout.filter(|_| has_no_name) else { return Ok(found) };
    let commanded = options.commanded.map(|[train, heldout]| [heldout, train]);
    let exchanged = DiagnoseOptions { commanded, ..options.clone() };
    let Ok(mut exchanged) = diagnose(heldout, Some(train), &exchanged) else { return Ok(found) };
    let why = if names_more_than_a_delay(&exchanged) {
        TELLS_TOO_LITTLE
    } else if exchanged.verdict == Verdict::None {
        EXPLAINS_BOTH
    } else {
        return Ok(found);
    };
    exchanged.captures_are_exchanged = true;
    [EXCHANGED, why, "."].into_iter().for_each(|words| exchanged.summary.push_str(words));
    Ok(exchanged)
}

fn names_more_than_a_delay(found: &Diagnosis) -> bool {
    found.effects.iter().any(|effect| *effect != effects::sensor_delay::KIND.name)
}

/// What is said where the captures were exchanged.
const EXCHANGED: &str =
    " The captures were exchanged: models were fitted to the one given as held-out and judged by the other one, ";
/// Why, where an effect was then found.
const TELLS_TOO_LITTLE: &str = "whose motion tells too little of what is missing";
/// Why, where nothing is missing then.
const EXPLAINS_BOTH: &str = "whose motion alone determines the model too poorly; so fitted, the model explains both";

/// Finds what a model lacks: names the missing effects, or says that nothing is missing, or that something is missing
/// that no effect of the catalogue explains.
///
/// Without a held-out capture, stretches of the training capture are held out, which is weaker evidence.
///
/// # Errors
/// [`DiagnosisError`] where no verdict would be worth anything.
pub fn diagnose(
    train: &Samples<'_>,
    heldout: Option<&Samples<'_>>,
    options: &DiagnoseOptions<'_>,
) -> Result<Diagnosis, DiagnosisError> {
    let captures = prepare(train, heldout, options)?;
    let [train_capture, given] = &captures;
    let search = Search::new([train_capture, given], options);
    let base = search.base(train)?;
    let undetermined = Undetermined::of(&base.structure, train_capture, given);
    let compared_in = |comparison: Comparison| {
        let mut compared = comparison.of(train_capture, given);
        compared.undetermined = undetermined.iter().flat_map(|undetermined| undetermined.rows(&compared)).collect();
        compared
    };
    // Unequal detents look like equal ones with another zero of the encoder, so no zero is estimated then.
    let are_unequal = search.detents_are_unequal(&base);
    let zero = if heldout.is_some() && !are_unequal { EncoderZero::of(&base, &captures) } else { None };
    let mut comparison = Comparison { zero, are_unequal };
    let mut rounds = 0;
    loop {
        rounds += 1;
        let after = |found: &Found, comparison: Comparison| {
            let is_last = rounds == MOST_ROUNDS;
            if is_last { comparison } else { comparison.after(found, train_capture, given, heldout.is_some()) }
        };
        let compared = compared_in(comparison);
        let mut search = Search { heldout: &compared, ..search };
        let base = base.judged_by(train_capture, &compared);
        search.check(&base)?;
        let mut found = Found::from(base);
        search.extend_and_revise(&mut found);
        let changed = after(&found, comparison);
        let changed_compared;
        if changed != comparison {
            comparison = changed;
            changed_compared = compared_in(comparison);
            found = found.judged_by(train_capture, &changed_compared);
            if !explains_the_gap(found.named(), &found.base) {
                continue;
            }
            search.heldout = &changed_compared;
        }
        found = search.with_delay_for_skew(search.reconsidered(found));
        let changed = after(&found, comparison);
        if changed != comparison {
            comparison = changed;
            continue;
        }
        let verdict = search.conclude(&mut found);
        let mut diagnosis = search.report(&found, verdict, heldout.is_none());
        let again = |zero| EncoderZero::again(Some(zero), &found.named().structure, given).unwrap_or(zero);
        diagnosis.notes.extend(comparison.zero.map(|zero| again(zero).note()));
        diagnosis.notes.extend(comparison.within(train_capture, given).map(|_| BEYOND.to_owned()));
        diagnosis.notes.extend(undetermined.as_ref().map(Undetermined::note));
        diagnosis.notes.extend(faults(train_capture, heldout.map(|_| given)));
        if verdict == Verdict::OutsideLibrary && options.model.is_none() {
            let of_fit = options.of_fit();
            let fit = fit_in_time(train, &of_fit).ok();
            // This note comes first, since opposite signs explain any other.
            diagnosis.notes.splice(0..0, fit.and_then(|fit| opposite_signs(train, &of_fit, &fit)));
        }
        return Ok(diagnosis);
    }
}

impl Search<'_> {
    /// Removes superfluous effects and measures torques without a name.
    fn conclude(&self, found: &mut Found) -> Verdict {
        self.eliminate(found);
        let verdict = self.verdict(found);
        if verdict != Verdict::None {
            self.measure_the_rest(found);
        }
        // A residual that can be measured shows that something is missing, however little it is.
        if found.characteristics.is_empty() { verdict } else { Verdict::OutsideLibrary }
    }
}

/// What is wrong with the sensors and samples of the captures, a sentence each.
fn faults<'a>(train: &'a Capture, heldout: Option<&'a Capture>) -> impl Iterator<Item = String> + 'a {
    let of = |which: &'static str, capture: &'a Capture| {
        capture.notes.iter().map(move |note| format!("{which} capture: {note}"))
    };
    of("training", train).chain(heldout.into_iter().flat_map(move |heldout| of("held-out", heldout)))
}

fn prepare(
    train: &Samples<'_>,
    heldout: Option<&Samples<'_>>,
    options: &DiagnoseOptions<'_>,
) -> Result<[Capture; 2], DiagnosisError> {
    if let Some(heldout) = heldout
        && train.t_s == heldout.t_s
        && train.angle_rad == heldout.angle_rad
        && train.torque_mnm == heldout.torque_mnm
    {
        return Err(DiagnosisError::SameCapture);
    }
    let parts = match heldout {
        Some(heldout) => [("training", train, Stretches::All), ("held-out", heldout, Stretches::All)],
        None => [("training", train, Stretches::Odd), ("training", train, Stretches::Even)],
    };
    let mut edge_hz = EDGE_HZ;
    loop {
        match prepare_in(edge_hz, parts, options) {
            // Where the encoder is coarse, motion can be told from noise in a narrower band only.
            Err(DiagnosisError::Capture { reason: FitError::HardlyMoving { .. }, .. }) if edge_hz > NARROWEST_HZ => {
                edge_hz *= 0.5;
            }
            Ok(captures) if captures[0].acceleration_noise_share > NOISIEST && edge_hz > NARROWEST_HZ => {
                edge_hz *= 0.5;
            }
            // Both are compared in the narrower one's band.
            Ok([train, heldout]) if train.band.edge_hz != heldout.band.edge_hz => {
                edge_hz = train.band.edge_hz.min(heldout.band.edge_hz);
            }
            Err(DiagnosisError::Capture { reason: reason @ FitError::HardlyMoving { .. }, which }) => {
                return maps(parts, options).ok_or(DiagnosisError::Capture { which, reason });
            }
            prepared => return prepared,
        }
    }
}

/// A part of the captures: which one it is of, its samples, and which stretches of them.
type Part<'a> = (&'static str, &'a Samples<'a>, Stretches);

/// Captures in which the knob was turned too slowly for its speed to be estimated, as maps of torque against angle.
fn maps([train, heldout]: [Part<'_>; 2], options: &DiagnoseOptions<'_>) -> Option<[Capture; 2]> {
    let known = options.calibration.as_ref();
    let of = |(_, samples, stretches): Part<'_>| {
        Some(Capture::of_map(Map::of(samples, options.axis, known, false)?, options.axis, stretches))
    };
    Some([of(train)?, of(heldout)?])
}

fn prepare_in(
    edge_hz: f64,
    [train, heldout]: [Part<'_>; 2],
    options: &DiagnoseOptions<'_>,
) -> Result<[Capture; 2], DiagnosisError> {
    let of = |(which, samples, stretches): Part<'_>| {
        Capture::of(samples, options.axis, options.calibration.as_ref(), edge_hz, stretches)
            .map_err(|reason| DiagnosisError::Capture { which, reason })
    };
    Ok([of(train)?, of(heldout)?])
}
