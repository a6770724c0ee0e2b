//! The paper's swept sine.

use std::f64::consts::PI;

use serde::{Deserialize, Serialize};

use super::Jet;

/// How the phase of equation 2 is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ChirpForm {
    /// As printed: phase π/(b−a)·((b−a)·t/d + a)² − a².
    Printed,
    /// With the factor d that makes the frequency (b−a)·t/d + a in Hz: phase d·π/(b−a)·((b−a)·t/d + a)².
    Linear,
}

/// A swept sine with the constants of equation 2 of Swindells and MacLean 2007.
///
/// The sweep rises for 2d (the paper's 30,000 samples at 5 kHz are 2d), then falls back the way it
/// came, and so on: phase and frequency are continuous, and a long capture stays within the
/// frequencies of a short one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ChirpSweep {
    /// How the phase is read.
    pub form: ChirpForm,
    /// Constant a.
    pub a: f64,
    /// Constant b.
    pub b: f64,
    /// Constant d, s.
    pub d: f64,
}

impl ChirpSweep {
    /// Equation 2 as printed, (a, b, d) = (0, 1.5, 3): t/6 Hz, up to 1 Hz.
    #[must_use]
    pub fn paper() -> Self {
        Self { form: ChirpForm::Printed, a: 0.0, b: 1.5, d: 3.0 }
    }

    /// The linear chirp with the same constants: t/2 Hz, up to 3 Hz.
    #[must_use]
    pub fn linear() -> Self {
        Self { form: ChirpForm::Linear, ..Self::paper() }
    }

    pub(super) fn at(&self, time_s: f64) -> Jet {
        let turn_s = 2.0 * self.d;
        let cycle = (time_s / (2.0 * turn_s)).floor();
        let within_s = time_s - cycle * 2.0 * turn_s;
        let (start, top) = (self.phase(0.0).value, self.phase(turn_s).value);
        let mut phase = if within_s <= turn_s {
            self.phase(within_s)
        } else {
            // Mirrored in time and value: the frequency comes back down, the phase goes on rising.
            let mirrored = self.phase(2.0 * turn_s - within_s);
            Jet { value: 2.0 * top - mirrored.value, first: mirrored.first, second: -mirrored.second }
        };
        phase.value += cycle * 2.0 * (top - start);
        phase.sin()
    }

    fn phase(&self, time_s: f64) -> Jet {
        let Self { form, a, b, d } = *self;
        let rate = (b - a) / d;
        let sweep = rate * time_s + a;
        let (factor, offset) = match form {
            ChirpForm::Printed => (PI / (b - a), a * a),
            ChirpForm::Linear => (d * PI / (b - a), 0.0),
        };
        Jet {
            value: factor * sweep * sweep - offset,
            first: factor * 2.0 * sweep * rate,
            second: factor * 2.0 * rate * rate,
        }
    }
}
