//! A mains hum above the band in which models are compared, where a coarse encoder or a low rate ends it: a line at one frequency in
//! both captures.

use dynamics::Effect;
use dynamics::effects::mains_hum;

use crate::diagnosis::capture::Capture;
use crate::diagnosis::capture::mains::MainsLine;
use crate::diagnosis::findings::{Diagnosis, Step, Value, Verdict};
use crate::diagnosis::search::Search;
use crate::diagnosis::search::acceptance::FALSE_DISCOVERIES;
use crate::diagnosis::search::judged::Judged;
use crate::numerics::statistics::{NORMAL_95, interval};

impl Search<'_> {
    /// Adds `mains-hum` to a diagnosis without it if both captures have the line of one above their band.
    pub(super) fn add_hum_above_the_band(&self, diagnosis: &mut Diagnosis, last: &Judged) {
        let kind = &mains_hum::KIND;
        let structure = &last.structure;
        if structure.position(kind.name).is_some() || structure.is_coupled() {
            return;
        }
        let edge_hz = self.train.band.edge_hz;
        let line = |capture: &Capture, beside_hz: Option<f64>| {
            let line = capture.mains.as_ref()?.line(structure.inertia(), structure.delay_s(), edge_hz, beside_hz)?;
            (line.ln_p_value < FALSE_DISCOVERIES.ln()).then_some(line)
        };
        let Some(trained) = line(self.train, None) else { return };
        let Some(heldout) = line(self.heldout, Some(trained.values[1])) else { return };
        let MainsLine { values, deviations, .. } = trained;
        let parameters = kind.parameters.iter().zip(values.into_iter().zip(deviations));
        let parameters = parameters.map(|(parameter, (value, deviation))| {
            let ci95 = Some(interval(value, NORMAL_95 * deviation));
            (parameter.name, Value { value, unit: parameter.unit, ci95 })
        });
        let [train_rms, heldout_rms] = [diagnosis.train_rms_after, diagnosis.heldout_rms_after];
        diagnosis.steps.push(Step {
            effect: kind.name,
            parameters: parameters.collect(),
            train_rms_before: train_rms,
            train_rms_after: train_rms,
            heldout_rms_before: heldout_rms,
            heldout_rms_after: heldout_rms,
            evidence: -trained.ln_p_value - heldout.ln_p_value,
            steadiness: f64::NAN,
            false_discovery_rate: heldout.ln_p_value.exp(),
            placebo_rms: heldout_rms,
            ..Step::default()
        });
        diagnosis.effects.push(kind.name);
        let effect = Effect::new(kind, &values);
        diagnosis.model.effects.push(effect);
        let mut model = diagnosis.chain.last().cloned().unwrap_or_default();
        model.effects.push(effect);
        diagnosis.chain.push(model);
        if diagnosis.verdict == Verdict::None {
            diagnosis.verdict = Verdict::Effects;
        }
        diagnosis.notes.push(format!(
            "{}: a line of {:.2} Hz in both captures, above the {edge_hz:.0} Hz up to which motion and torque are compared: the residuals above \
             do not show it",
            kind.name, values[1]
        ));
    }
}
