//! A value with its first two derivatives by time, so that shapes can be composed.

use std::ops::{Add, Mul};

/// Value, first and second derivative by time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Jet {
    pub(super) value: f64,
    pub(super) first: f64,
    pub(super) second: f64,
}

impl Jet {
    pub(super) const fn constant(value: f64) -> Self {
        Self { value, first: 0.0, second: 0.0 }
    }

    pub(super) fn sin(self) -> Self {
        let (sine, cosine) = self.value.sin_cos();
        Self { value: sine, first: cosine * self.first, second: cosine * self.second - sine * self.first * self.first }
    }

    pub(super) fn scaled(self, factor: f64) -> Self {
        Self { value: factor * self.value, first: factor * self.first, second: factor * self.second }
    }

    /// Rises smoothly from 0 at time 0 to 1 at `duration_s`: the quintic step, whose first two
    /// derivatives vanish at both ends.
    pub(super) fn smooth_step(time_s: f64, duration_s: f64) -> Self {
        let x = (time_s / duration_s).clamp(0.0, 1.0);
        let rate = 1.0 / duration_s;
        Self {
            value: x * x * x * (10.0 + x * (-15.0 + 6.0 * x)),
            first: rate * 30.0 * x * x * (1.0 - x) * (1.0 - x),
            second: rate * rate * 60.0 * x * (1.0 - x) * (1.0 - 2.0 * x),
        }
    }
}

impl Add for Jet {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self { value: self.value + other.value, first: self.first + other.first, second: self.second + other.second }
    }
}

impl Mul for Jet {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        Self {
            value: self.value * other.value,
            first: self.first * other.value + self.value * other.first,
            second: self.second * other.value + 2.0 * self.first * other.first + self.value * other.second,
        }
    }
}
