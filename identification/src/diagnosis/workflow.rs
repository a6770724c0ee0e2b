//! The way from a capture and a model to a verdict.

use std::sync::atomic::{AtomicUsize, Ordering};

use dynamics::{Calibration, Effect, EffectKind, Model, Part, effects, simulate};

use super::both_cores::on_both_cores;
use super::capture::{Capture, Stretches};
use super::commanded::{self, CommandedTorque};
use super::findings::{Diagnosis, Partial, Rival, Step, Verdict};
use super::hypotheses;
use super::judged::Judged;
use super::locate::locate;
use super::nonlinear::Nonlinear;
use super::separable::Separable;
use super::structure::Structure;
use super::{experiment, intervals, placebo, rows};
use crate::{FitError, FitOptions, Samples, fit};

/// Evidence that an effect must bring beyond the cost of its freedom, nats: odds of e¹⁰.
const EVIDENCE: f64 = 10.0;
/// Standard errors by which stretch after stretch must be explained better.
const STEADY: f64 = 3.0;
/// Share of the mean square above the floor that an effect must take away to be worth a name …
const WORTHWHILE: f64 = 0.28;
/// … and in mean squares of the floor: smaller ones could be what the floor's own estimate is wrong by.
const SMALLEST: f64 = 0.06;
/// RMS in floors above which something is left, if it goes with something …
const LEFT: f64 = 1.3;
/// … and above which it need not: noise in motion is not two and a half times as strong as the sensors' own.
const CERTAINLY_LEFT: f64 = 1.6;
/// Share of the gap's amplitude that may be left by a complete explanation.
const UNEXPLAINED: f64 = 0.15;
/// How far the floor may lie below its estimate, as a share of it.
const LOWER_FLOOR: f64 = 0.8;
/// Evidence by which rivals must differ not to be a tie, nats: odds of 20 to 1.
const TIE: f64 = 3.0;
/// Largest noise of acceleration, as a share of its RMS: with more, inertia is underrated by more than a hundredth.
const NOISIEST: f64 = 0.1;
/// Narrowest band in which captures are compared, Hz.
const NARROWEST_HZ: f64 = 8.0;
/// Share of the gap's mean square that effects must explain to be named although something else is left.
const MOST_OF_IT: f64 = 0.7;
/// Time over which motion is predicted from torque before it is started anew, s.
pub const FORWARD_WINDOW_S: f64 = 0.1;
/// Most effects that are added.
const MOST_EFFECTS: usize = 4;
/// Effects that are tried together with a coupling where none alone is worth it.
const HIDING: usize = 3;

/// What a diagnosis may be told; nothing need be.
#[derive(Default)]
pub struct DiagnoseOptions<'a> {
    /// What is known of the rig.
    pub calibration: Option<Calibration>,
    /// The model to start from; without one, inertia, friction and detents as they are fitted to the training capture.
    pub model: Option<Model>,
    /// How far from its start the knob may be turned to tell rivals apart, rad; without it as far as it was.
    pub reach_rad: Option<f64>,
    /// What was commanded from the rig's motor, where the captures tell.
    pub commanded: Option<CommandedTorque<'a>>,
    /// Called as the work goes on.
    pub progress: Option<&'a (dyn Fn(Progress) + Sync)>,
}

/// How far a diagnosis has come.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Progress {
    /// An effect was tried; so many of so many in this step.
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

/// Why captures cannot be diagnosed.
#[derive(Debug, thiserror::Error)]
pub enum DiagnosisError {
    /// One of the captures cannot be fitted.
    #[error("the {which} capture: {reason}")]
    Capture {
        /// Which one.
        which: &'static str,
        /// What is wrong with it.
        reason: FitError,
    },
    /// The captures are the same.
    #[error(
        "the held-out capture is the training capture; give one of another motion, or none to hold out stretches of \
         the training capture"
    )]
    SameCapture,
    /// The sample rates differ.
    #[error(
        "the training capture has {train_hz:.1} samples per second and the held-out one {heldout_hz:.1}; capture both \
         at one rate"
    )]
    DifferentRates {
        /// Of the training capture, Hz.
        train_hz: f64,
        /// Of the held-out capture, Hz.
        heldout_hz: f64,
    },
    /// The columns differ by a power of ten or another unit.
    #[error(
        "the model of the training capture predicts the held-out torque only when multiplied by {factor:.3}; check that \
         both captures are of one knob and in the same units (rad, mNm)"
    )]
    DifferentUnits {
        /// What the prediction would have to be multiplied by.
        factor: f64,
    },
    /// The torque hardly rises above the noise.
    #[error(
        "the {which} capture's torque is {over_floor:.1} times its noise, too quiet to tell anything; turn the knob \
         faster or further"
    )]
    TooQuiet {
        /// Which one.
        which: &'static str,
        /// RMS of the torque in noise floors.
        over_floor: f64,
    },
}

/// Finds what a model lacks: names the missing effects, or says that nothing is missing, or that something is missing
/// which no effect of the catalogue explains.
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
    let work = Work { train: &captures[0], heldout: &captures[1], options };
    let first = work.base(train)?;
    work.check(&first)?;
    let mut found = work.explain(first);
    work.eliminate(&mut found);
    Ok(work.report(&found, heldout.is_none()))
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
    let mut edge_hz = Capture::widest_edge_hz();
    let captures = loop {
        match prepare_in(edge_hz, train, heldout, options) {
            // Where the encoder is coarse, motion can be told from noise in a narrower band only.
            Err(DiagnosisError::Capture { reason: FitError::HardlyMoving { .. }, .. }) if edge_hz > NARROWEST_HZ => {
                edge_hz *= 0.5;
            }
            Ok(captures) if captures[0].acceleration_noise_share > NOISIEST && edge_hz > NARROWEST_HZ => {
                edge_hz *= 0.5;
            }
            prepared => break prepared?,
        }
    };
    let [train_hz, heldout_hz] = [captures[0].rate_hz, captures[1].rate_hz];
    if (train_hz / heldout_hz - 1.0).abs() > 0.02 {
        return Err(DiagnosisError::DifferentRates { train_hz, heldout_hz });
    }
    Ok(captures)
}

fn prepare_in(
    edge_hz: f64,
    train: &Samples<'_>,
    heldout: Option<&Samples<'_>>,
    options: &DiagnoseOptions<'_>,
) -> Result<[Capture; 2], DiagnosisError> {
    let of = |which, samples: &Samples<'_>, stretches| {
        Capture::of(samples, options.calibration.as_ref(), edge_hz, stretches)
            .map_err(|reason| DiagnosisError::Capture { which, reason })
    };
    Ok(match heldout {
        Some(heldout) => [of("training", train, Stretches::All)?, of("held-out", heldout, Stretches::All)?],
        None => [of("training", train, Stretches::Odd)?, of("training", train, Stretches::Even)?],
    })
}

struct Work<'a> {
    train: &'a Capture,
    heldout: &'a Capture,
    options: &'a DiagnoseOptions<'a>,
}

/// Everything that was found on the way.
struct Found {
    /// The model without further effects, and then with each more.
    chain: Vec<Judged>,
    /// The effects that were added.
    added: Vec<&'static str>,
    /// The rivals of each.
    rivals: Vec<Vec<Judged>>,
    /// What explained part of the rest and was not added.
    partial: Vec<Partial>,
}

impl Work<'_> {
    /// Inertia, friction and detents, or the model given, fitted to the training capture.
    fn base(&self, samples: &Samples<'_>) -> Result<Judged, DiagnosisError> {
        let effects: Vec<Effect> = match &self.options.model {
            Some(model) => model.effects.clone(),
            None => {
                let options = FitOptions { calibration: self.options.calibration.clone(), ..FitOptions::default() };
                match fit(samples, &options) {
                    Ok(fit) => fit.effects().to_vec(),
                    // Too slow or too coarse to look for detents; in a narrow band the rest can still be told.
                    Err(FitError::HardlyMoving { .. }) => {
                        [&effects::inertia::KIND, &effects::friction::KIND].map(|kind| Effect::new(kind, &[])).to_vec()
                    }
                    Err(reason) => return Err(DiagnosisError::Capture { which: "training", reason }),
                }
            }
        };
        let fitted: Vec<Effect> =
            effects.into_iter().filter(|effect| !matches!(effect.kind().part, Part::Stick(_))).collect();
        Ok(self.settled(Structure::new(&fitted)))
    }

    /// A structure fitted from where it stands.
    fn settled(&self, structure: Structure) -> Judged {
        if structure.is_coupled() {
            let mut fit = Nonlinear::new(structure, self.train);
            fit.refine(2);
            return Judged::nonlinear(&fit, self.train, self.heldout);
        }
        let mut fit = Separable::new(structure, self.train);
        fit.refine(10);
        Judged::separable(&fit, self.heldout)
    }

    fn check(&self, base: &Judged) -> Result<(), DiagnosisError> {
        for (which, capture, residual) in
            [("training", self.train, &base.train_residual), ("held-out", self.heldout, &base.heldout_residual)]
        {
            let target = capture.target(base.structure.delay_s());
            let square = crate::least_squares::dot(&target, &target);
            let over_floor = (square / capture.weight).sqrt() / capture.floor_mnm(0.0);
            if over_floor < 2.0 {
                return Err(DiagnosisError::TooQuiet { which, over_floor });
            }
            let predicted: Vec<f64> = target.iter().zip(residual).map(|(target, left)| target - left).collect();
            let factor = crate::least_squares::dot(&target, &predicted)
                / crate::least_squares::dot(&predicted, &predicted).max(f64::MIN_POSITIVE);
            if which == "held-out" && !(0.1..10.0).contains(&factor) {
                return Err(DiagnosisError::DifferentUnits { factor });
            }
        }
        Ok(())
    }

    /// Adds effect after effect as long as one is worth it.
    fn explain(&self, first: Judged) -> Found {
        let mut found = Found { chain: vec![first], added: Vec::new(), rivals: Vec::new(), partial: Vec::new() };
        while found.rivals.len() < MOST_EFFECTS {
            let Some(current) = found.chain.last().cloned() else { break };
            if explains_the_gap(&current, &found.chain[0]) {
                // Nothing more could be worth a name.
                break;
            }
            let mut tried = self.try_all(&current, &found.chain[0]);
            tried.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
            let worth = |rival: &Judged| {
                self.disqualified(rival).is_none() && self.worthwhile(&current, rival, &found.chain[0])
            };
            let Some(best) = tried.iter().position(worth) else {
                found.partial = self.partial(&current, &tried);
                if self.add_pair(&mut found, &current, &tried) {
                    continue;
                }
                break;
            };
            let chosen = tried.remove(best);
            if let Some(with_detents) = self.as_detent(&chosen) {
                // The first torque that repeats with the angle is the detents, which the model's base lacked.
                found.chain.pop();
                found.chain.push(with_detents);
                continue;
            }
            self.add(&mut found, chosen, tried);
        }
        found
    }

    fn add(&self, found: &mut Found, chosen: Judged, rivals: Vec<Judged>) {
        let effect = name(&chosen);
        self.say(Progress::Added { effect, heldout_over_floor: chosen.heldout_over_floor() });
        found.added.push(effect);
        found.chain.push(chosen);
        found.rivals.push(rivals);
    }

    /// Adds two effects at once where neither alone is worth it and much is left: one may hide the other.
    fn add_pair(&self, found: &mut Found, current: &Judged, tried: &[Judged]) -> bool {
        if current.train_over_floor() < LEFT || current.structure.is_coupled() || found.rivals.len() + 2 > MOST_EFFECTS
        {
            return false;
        }
        let firsts: Vec<&Judged> = tried
            .iter()
            .filter(|judged| !judged.structure.is_coupled() && judged.evidence > current.evidence + EVIDENCE)
            .take(HIDING)
            .collect();
        let couplings: Vec<&'static EffectKind> = hypotheses::candidates(&current.structure)
            .into_iter()
            .filter(|kind| matches!(kind.part, Part::Coupling(_)))
            .collect();
        let pairs: Vec<(&Judged, &'static EffectKind)> =
            firsts.iter().flat_map(|first| couplings.iter().map(|kind| (*first, *kind))).collect();
        let mut both = on_both_cores(&pairs, |(first, kind)| {
            let judged = hypotheses::coupled(kind, &first.structure, self.train, self.heldout)?;
            Some(((*first).clone(), judged))
        });
        both.retain(|(_, judged)| {
            self.disqualified(judged).is_none() && self.worthwhile(current, judged, &found.chain[0])
        });
        both.sort_by(|a, b| b.1.evidence.total_cmp(&a.1.evidence));
        let mut both = both.into_iter();
        let Some((first, second)) = both.next() else { return false };
        found.partial.clear();
        for (judged, rivals) in [(first, tried.to_vec()), (second, both.map(|(_, judged)| judged).collect())] {
            self.add(found, judged, rivals);
        }
        true
    }

    fn say(&self, progress: Progress) {
        if let Some(progress_to) = self.options.progress {
            progress_to(progress);
        }
    }

    /// Whether an effect more explains enough, surely enough.
    fn worthwhile(&self, before: &Judged, after: &Judged, first: &Judged) -> bool {
        let floor = after.heldout_floor_mnm;
        let closed = before.excess() - after.excess();
        // An end stop may be felt in a few stretches only; then what was never fitted must speak for it.
        let unseen = self.heldout.weight * (before.heldout_rms_mnm / after.heldout_rms_mnm).ln();
        after.evidence - before.evidence > EVIDENCE
            && (after.steadily_better_than(before) > STEADY || unseen > EVIDENCE)
            && after.heldout_rms_mnm < before.heldout_rms_mnm
            && closed > WORTHWHILE * before.excess()
            && closed > SMALLEST * floor * floor
            && closed > UNEXPLAINED * UNEXPLAINED * first.excess()
    }

    /// The best fit with each effect of the catalogue more, on both cores.
    fn try_all(&self, current: &Judged, first: &Judged) -> Vec<Judged> {
        let kinds = hypotheses::candidates(&current.structure);
        if current.structure.is_coupled() {
            return hypotheses::beside_coupling(&kinds, &current.structure, self.train, self.heldout);
        }
        let (mut coupled, separable): (Vec<&'static EffectKind>, Vec<&'static EffectKind>) =
            kinds.iter().partition(|kind| matches!(kind.part, Part::Coupling(_)));
        coupled.sort_by_key(|kind| kind.parameters.len());
        let base = Separable::new(current.structure.clone(), self.train);
        let of = kinds.len();
        let done = AtomicUsize::new(0);
        let say = |kind: &EffectKind| {
            let done = done.fetch_add(1, Ordering::Relaxed) + 1;
            self.say(Progress::Tried { effect: kind.name, done, of });
        };
        let mut tried = on_both_cores(&separable, |kind| {
            let judged = hypotheses::separable(kind, &base, self.heldout);
            say(kind);
            judged
        });
        let open = |judged: &Judged| judged.train_over_floor().max(judged.heldout_over_floor()) > hypotheses::CLOSED;
        let closes =
            |judged: &Judged| (!open(judged) || explains_the_gap(judged, first)) && self.disqualified(judged).is_none();
        if open(current) && !tried.iter().any(closes) {
            for kind in coupled {
                let judged = hypotheses::coupled(kind, &current.structure, self.train, self.heldout);
                say(kind);
                let closed = judged.as_ref().is_some_and(closes);
                tried.extend(judged);
                if closed {
                    // The next coupling has more freedom and costs more.
                    break;
                }
            }
        }
        tried
    }

    /// Why the last effect cannot be the one, if so.
    fn disqualified(&self, judged: &Judged) -> Option<String> {
        Nonlinear::on_bound(&judged.structure, self.train)
            .map(|parameter| format!("{parameter} stands on the bound of what this capture could show"))
    }

    /// The same with the last effect taken for detents, if it is a periodic torque and there are none yet.
    fn as_detent(&self, judged: &Judged) -> Option<Judged> {
        let effect = judged.structure.effects.last()?;
        let is_periodic = effect.kind().name == effects::cogging::KIND.name;
        if !is_periodic || judged.structure.position(effects::detent::KIND.name).is_some() {
            return None;
        }
        let [amplitude, per_turn, phase] = *effect.values() else { return None };
        let detent = Effect::new(&effects::detent::KIND, &[amplitude, 1.0 / per_turn, phase]);
        let base = judged.structure.without(judged.structure.effects.len() - 1);
        Some(self.settled(base.with(detent, 2)))
    }

    /// What explains some of the rest without being worth a name.
    fn partial(&self, current: &Judged, tried: &[Judged]) -> Vec<Partial> {
        let gap = current.excess();
        let each = tried
            .iter()
            .filter(|judged| judged.evidence - current.evidence > EVIDENCE)
            .map(|judged| Partial { effect: name(judged), explains_percent: 100.0 * (gap - judged.excess()) / gap });
        each.filter(|partial| partial.explains_percent > 5.0).collect()
    }

    /// Takes out again what other effects have made superfluous.
    fn eliminate(&self, found: &mut Found) {
        let mut step = 0;
        while step < found.added.len() && found.added.len() > 1 {
            let Some(last) = found.chain.last() else { return };
            let Some(index) = last.structure.position(found.added[step]) else { return };
            let without = self.settled(last.structure.without(index));
            if self.worthwhile(&without, last, &found.chain[0]) {
                step += 1;
                continue;
            }
            // The chain is made anew without it.
            let removed = found.added.remove(step);
            found.chain.remove(step + 1);
            found.rivals.remove(step);
            for later in &mut found.chain[step + 1..] {
                if let Some(index) = later.structure.position(removed) {
                    *later = self.settled(later.structure.without(index));
                }
            }
            step = 0;
        }
    }

    fn report(&self, found: &Found, heldout_is_own: bool) -> Diagnosis {
        let (first, last) = (&found.chain[0], found.chain.last().unwrap_or(&found.chain[0]));
        let left = last.heldout_over_floor().min(last.train_over_floor());
        let unexplained = (last.excess().max(0.0) / first.excess().max(f64::MIN_POSITIVE)).sqrt();
        let where_after = locate(&last.train_residual, &last.structure, self.train);
        // Noise may be larger in motion than the sensors' own, but then it goes with nothing.
        let shaped = where_after.iter().any(|location| location.significant);
        let verdict = if left > LEFT && unexplained > UNEXPLAINED && (shaped || left > CERTAINLY_LEFT) {
            Verdict::OutsideLibrary
        } else if found.rivals.is_empty() {
            Verdict::None
        } else {
            Verdict::Effects
        };
        let values = intervals::of(&last.structure, self.train);
        let steps: Vec<Step> = found
            .rivals
            .iter()
            .enumerate()
            .map(|(index, rivals)| {
                let pair = [&found.chain[index], &found.chain[index + 1]];
                self.step(found.added[index], pair, rivals, last, &values)
            })
            .collect();
        let mut partial = found.partial.clone();
        let mut effects = self.strongest_first(&last.structure, &steps);
        if verdict == Verdict::OutsideLibrary {
            let gap = first.excess();
            let added = found.chain.windows(2).zip(&found.added).map(|(pair, effect)| Partial {
                effect,
                explains_percent: 100.0 * (pair[0].excess() - pair[1].excess()) / gap,
            });
            partial.splice(0..0, added);
            if last.excess() > (1.0 - MOST_OF_IT) * gap {
                effects.clear();
            }
        }
        let next_experiment =
            steps.iter().zip(&found.rivals).zip(&found.chain[1..]).find_map(|((step, rivals), chosen)| {
                let tied = rivals.iter().find(|rival| step.ties.contains(&name(rival)))?;
                experiment::next(
                    [step.effect, name(tied)],
                    [&chosen.structure, &tied.structure],
                    self.train,
                    self.options.reach_rad,
                )
            });
        let mut diagnosis = Diagnosis {
            verdict,
            effects,
            summary: String::new(),
            train_rms_before: first.train_rms_mnm,
            train_rms_after: last.train_rms_mnm,
            heldout_rms_before: first.heldout_rms_mnm,
            heldout_rms_after: last.heldout_rms_mnm,
            noise_floor_rms: last.heldout_floor_mnm,
            forward_angle_rms_rad: self.forward_angle_rms_rad(&first.structure, &last.structure),
            forward_from_command: None,
            heldout_relative_error_percent: [first, last].map(|judged| self.relative_error_percent(judged)),
            steps,
            partial,
            locations: locate(&first.train_residual, &first.structure, self.train),
            where_after,
            next_experiment,
            heldout_is_own,
            band_hz: self.train.band.edge_hz,
            notes: Vec::new(),
            model: last.structure.model(),
            chain: found.chain.iter().map(|judged| judged.structure.model()).collect(),
            rows: rows::of(first, last, [self.train, self.heldout]),
        };
        diagnosis.summary = diagnosis.in_one_sentence();
        let motor_inertia = self.options.calibration.as_ref().map(|known| known.motor_inertia);
        let commanded = self.options.commanded.as_ref();
        match commanded::forward(&diagnosis.chain, [self.train, self.heldout], commanded, motor_inertia) {
            Ok(forward) => diagnosis.forward_from_command = Some(forward),
            Err(reason) => diagnosis.notes.push(format!("motion is not predicted from the command: {reason}")),
        }
        if heldout_is_own {
            diagnosis.notes.push(
                "no held-out capture was given: stretches of the training capture were held out, which is weaker \
                 evidence than another motion"
                    .to_owned(),
            );
        }
        diagnosis
    }

    /// Error of the held-out motion predicted from the torque, with the first and with the final model.
    fn forward_angle_rms_rad(&self, first: &Structure, last: &Structure) -> Option<[f64; 2]> {
        let predicted = |structure: &Structure| {
            let readings_mnm = self.heldout.torque_mnm(structure.skew_s);
            let (model, motions) = (structure.model(), self.heldout.motions());
            let errors = simulate::forward_windows(&model, 0.0, motions, &readings_mnm, FORWARD_WINDOW_S).ok()?;
            errors.angle_rms_rad.is_finite().then_some(errors.angle_rms_rad)
        };
        Some([predicted(first)?, predicted(last)?])
    }

    fn relative_error_percent(&self, judged: &Judged) -> f64 {
        let target = self.heldout.target(judged.structure.delay_s());
        let square = |values: &[f64]| crate::least_squares::dot(values, values);
        100.0 * (square(&judged.heldout_residual) / square(&target)).sqrt()
    }

    fn step(
        &self,
        effect: &'static str,
        [before, after]: [&Judged; 2],
        rivals: &[Judged],
        last: &Judged,
        values: &[std::collections::BTreeMap<&'static str, super::findings::Value>],
    ) -> Step {
        let best = rivals.iter().map(|rival| rival.evidence).fold(after.evidence, f64::max);
        let total: f64 = rivals.iter().chain([after]).map(|rival| (rival.evidence - best).exp()).sum();
        let rival = |judged: &Judged| Rival {
            effect: name(judged),
            heldout_rms_after: judged.heldout_rms_mnm,
            evidence: judged.evidence - before.evidence,
            probability: (judged.evidence - best).exp() / total,
            disqualified: self.disqualified(judged),
        };
        let tied = |judged: &&Judged| {
            self.disqualified(judged).is_none()
                && (after.evidence - judged.evidence < TIE || after.steadily_better_than(judged) < 2.0)
                && self.worthwhile(before, judged, before)
        };
        Step {
            effect,
            parameters: last.structure.position(effect).map(|index| values[index].clone()).unwrap_or_default(),
            train_rms_before: before.train_rms_mnm,
            train_rms_after: after.train_rms_mnm,
            heldout_rms_before: before.heldout_rms_mnm,
            heldout_rms_after: after.heldout_rms_mnm,
            evidence: after.evidence - before.evidence,
            steadiness: after.steadily_better_than(before),
            placebo_rms: placebo::rms_mnm(effect, before, &after.structure, self.train, self.heldout),
            ties: rivals.iter().filter(tied).map(name).collect(),
            rivals: rivals.iter().map(rival).collect(),
        }
    }

    /// The effects that were added, by the torque that each makes in the final model.
    fn strongest_first(&self, structure: &Structure, steps: &[Step]) -> Vec<&'static str> {
        let with = structure.model().readings_mnm(self.train.motions());
        let mut sizes: Vec<(f64, &'static str)> = steps
            .iter()
            .filter_map(|step| {
                let index = structure.position(step.effect)?;
                let less = structure.without(index);
                let without = less.model().readings_mnm(self.train.motions());
                let delayed = self.train.target(structure.delay_s()).into_iter().zip(self.train.target(less.delay_s()));
                let late: f64 = delayed.map(|(with, without)| (with - without).powi(2)).sum();
                let difference: Vec<f64> = with.iter().zip(&without).map(|(with, without)| with - without).collect();
                let rows = self.train.frame.rows(&difference);
                Some((crate::least_squares::dot(&rows, &rows) + late, step.effect))
            })
            .collect();
        sizes.sort_by(|a, b| b.0.total_cmp(&a.0));
        sizes.into_iter().map(|(_, effect)| effect).collect()
    }
}

/// Whether so little of the first model's gap is left that no further effect could be worth a name, even if the floor
/// were lower than it is thought to be.
fn explains_the_gap(judged: &Judged, first: &Judged) -> bool {
    first.excess() > 0.0 && judged.excess_above(LOWER_FLOOR) < UNEXPLAINED * UNEXPLAINED * first.excess()
}

/// The effect that a structure has more than the one before.
fn name(judged: &Judged) -> &'static str {
    judged.structure.effects.last().map_or("", |effect| effect.kind().name)
}
