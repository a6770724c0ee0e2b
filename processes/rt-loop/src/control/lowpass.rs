//! Butterworth low-passes for the two velocity signals.

use biquad::{Biquad as _, Coefficients, DirectForm2Transposed, Hertz, Type};

/// A Butterworth low-pass of order `2 · SECTIONS`, as a cascade of second-order sections.
///
/// A section with quality 1/(2·sin((2k−1)·π/2n)) has the k-th pole pair of the n-th order
/// Butterworth; each is designed by the bilinear transform with its edge prewarped, so the cascade
/// is the exact digital Butterworth.
#[derive(Clone, Copy, Debug)]
pub(super) struct ButterworthLowPass<const SECTIONS: usize> {
    sections: [DirectForm2Transposed<f64>; SECTIONS],
}

impl<const SECTIONS: usize> ButterworthLowPass<SECTIONS> {
    /// A filter with −3 dB at `edge_hz`; `None` when the edge is not below half the rate.
    pub(super) fn new(edge_hz: f64, rate_hz: f64) -> Option<Self> {
        let (edge, rate) = (Hertz::from_hz(edge_hz).ok()?, Hertz::from_hz(rate_hz).ok()?);
        let unity = Coefficients { a1: 0.0, a2: 0.0, b0: 1.0, b1: 0.0, b2: 0.0 };
        let mut sections = [DirectForm2Transposed::new(unity); SECTIONS];
        for (index, section) in sections.iter_mut().enumerate() {
            let angle = (2 * index + 1) as f64 * std::f64::consts::PI / (4 * SECTIONS) as f64;
            let quality = 1.0 / (2.0 * angle.sin());
            let coefficients = Coefficients::from_params(Type::LowPass, rate, edge, quality).ok()?;
            *section = DirectForm2Transposed::new(coefficients);
        }
        Some(Self { sections })
    }

    /// Resets the filter, as if it had had no input.
    pub(super) fn forget(&mut self) {
        self.sections.iter_mut().for_each(biquad::Biquad::reset_state);
    }

    pub(super) fn run(&mut self, input: f64) -> f64 {
        self.sections.iter_mut().fold(input, |value, section| section.run(value))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at a failure")]
    use super::ButterworthLowPass;

    /// First outputs of `scipy.signal.sosfilt(scipy.signal.butter(10, 500, fs=10000, output='sos'), ones)`.
    const SCIPY_STEP_RESPONSE: [f64; 6] = [
        3.619_695_077_616e-9,
        6.874_632_274_151e-8,
        6.474_906_017_263e-7,
        4.049_958_822_636e-6,
        1.900_859_140_352e-5,
        7.171_106_873_872e-5,
    ];

    #[test]
    fn the_tenth_order_filter_answers_a_step_as_scipys_does() {
        let mut filter = ButterworthLowPass::<5>::new(500.0, 10_000.0).unwrap();
        for expected in SCIPY_STEP_RESPONSE {
            let got = filter.run(1.0);
            assert!((got - expected).abs() < 1e-6 * expected, "{got:e} against scipy's {expected:e}");
        }
    }

    #[test]
    fn an_edge_beyond_half_the_rate_is_refused() {
        assert!(ButterworthLowPass::<1>::new(6_000.0, 10_000.0).is_none());
    }
}
