//! The capture that would tell rivals apart.

use dynamics::{Drive, Excitation, Motion, excitation};

use crate::diagnosis::capture::Capture;
use crate::diagnosis::findings::NextExperiment;
use crate::diagnosis::model_fit::structure::Structure;

/// Amplitudes tried, as shares of the capture's own.
const AMPLITUDES: [f64; 4] = [1.0, 0.3, 0.1, 0.02];
/// Length of the capture to come, s, and samples per second at which rivals are compared.
const DURATION_S: f64 = 8.0;
const RATE_HZ: f64 = 2000.0;

/// Evidence that a capture must promise to be worth making, nats: a small misfit of either rival outweighs less evidence.
const WORTH_NATS: f64 = 10.0;

/// The excitation on which two fitted structures differ most, as far as the knob may be turned; none if they differ too
/// little to be told apart by it.
///
/// Without a `reach_rad` the knob is not turned further than it was.
pub(crate) fn next(
    names: [&str; 2],
    rivals: [&Structure; 2],
    capture: &Capture,
    reach_rad: Option<f64>,
) -> Option<NextExperiment> {
    let scene = capture.scene_of(rivals[0]);
    let reach_rad = reach_rad.unwrap_or(0.5 * scene.travel_rad());
    let floor_mnm = capture.floor_mnm(rivals[0].inertia());
    // Independent rows of noise, each with half the square of the difference over it.
    let rows = 2.0 * capture.band.edge_hz * DURATION_S;
    let evidence = |difference_rms_mnm: f64| 0.5 * rows * (difference_rms_mnm / floor_mnm).powi(2);
    let delays_s = rivals.map(Structure::delay_s);
    let mut best: Option<(f64, &str, f64)> = None;
    for name in excitation::NAMES.iter().filter(|name| !matches!(**name, "hold" | "torque-ramp")) {
        let Ok(usual) = Excitation::named(name, Drive::Position) else { continue };
        for share in AMPLITUDES {
            let Ok(sweep) = usual.with_amplitude(share * reach_rad.min(usual.amplitude)) else { continue };
            let Some(motions) = motions(&sweep, scene.highest_speed_rad_s) else { continue };
            let torques = rivals.map(|rival| rival.model().readings_mnm(&motions));
            // A delay shows as the torque's change over it.
            let late_mnm = |rival: usize, at: usize| {
                let [before, now] = [at.saturating_sub(1), at].map(|at| torques[rival][at]);
                now - delays_s[rival] * (now - before) * RATE_HZ
            };
            let moving = (0..motions.len()).filter(|at| motions[*at].velocity_rad_s != 0.0);
            let squares: f64 = moving.map(|at| (late_mnm(0, at) - late_mnm(1, at)).powi(2)).sum();
            let rms_mnm = (squares / motions.len() as f64).sqrt();
            if evidence(rms_mnm).is_finite() && best.is_none_or(|(most_mnm, ..)| rms_mnm > most_mnm) {
                best = Some((rms_mnm, *name, sweep.amplitude));
            }
        }
    }
    let (difference_rms_mnm, name, amplitude_rad) = best?;
    let expected_evidence = evidence(difference_rms_mnm);
    (expected_evidence > WORTH_NATS).then(|| NextExperiment {
        excitation: name.to_owned(),
        amplitude_rad,
        tells_apart: names.map(str::to_owned),
        difference_rms_mnm,
        difference_over_noise: difference_rms_mnm / floor_mnm,
        expected_evidence,
        reason: format!(
            "capture with --sweep {name} --amplitude {amplitude_rad:.3}: there {} and {} differ by {difference_rms_mnm:.2} mNm RMS, {:.1} \
             times the noise",
            names[0],
            names[1],
            difference_rms_mnm / floor_mnm
        ),
    })
}

/// The motion of an excitation; `None` if it is much faster than the knob was ever turned.
fn motions(sweep: &Excitation, highest_speed_rad_s: f64) -> Option<Vec<Motion>> {
    let samples = (DURATION_S * RATE_HZ) as u32;
    let motions: Vec<Motion> = (0..samples)
        .map(|index| {
            let time_s = f64::from(index) / RATE_HZ;
            let set = sweep.at(time_s);
            Motion { time_s, angle_rad: set.value, velocity_rad_s: set.rate, acceleration_rad_s2: set.acceleration }
        })
        .collect();
    let fastest = motions.iter().map(|motion| motion.velocity_rad_s.abs()).fold(0.0, f64::max);
    (fastest <= 1.5 * highest_speed_rad_s).then_some(motions)
}
