//! Colours. rerun follows the browser's theme: these read on a light ground as well as on a dark one.

use rerun::Color;

/// What was measured, and this process.
pub const MEASURED: Rgb = Rgb(46, 146, 214);
/// What the model gives, and the fitter.
pub const MODEL: Rgb = Rgb(240, 134, 10);
/// Turning towards negative angle.
pub const NEGATIVE: Rgb = Rgb(220, 80, 115);
/// Turning towards positive angle, and the recorder.
pub const POSITIVE: Rgb = Rgb(52, 168, 96);
/// A knob at rest, held by static friction.
pub const STICKING: Rgb = Rgb(150, 110, 235);
/// Behind the knob, in light and dark themes alike.
pub const GROUND: Rgb = Rgb(22, 26, 30);
/// The pointer on the knob.
pub const WHITE: Rgb = Rgb(245, 247, 248);
/// Axes and their labels.
pub const NEUTRAL: Rgb = Rgb(128, 134, 140);

/// Red, green, blue.
#[derive(Clone, Copy, Debug)]
pub struct Rgb(u8, u8, u8);

impl Rgb {
    /// The colour as it is.
    pub fn opaque(self) -> Color {
        Color::from_rgb(self.0, self.1, self.2)
    }

    /// The colour over what lies beneath.
    pub fn translucent(self, alpha: u8) -> Color {
        Color::from_unmultiplied_rgba(self.0, self.1, self.2, alpha)
    }
}
