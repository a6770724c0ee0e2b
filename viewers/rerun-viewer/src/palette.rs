//! Colours. rerun follows the browser's theme: these read on a light ground as well as on a dark one.

use rerun::datatypes::Rgba32;

/// What was measured, and this process.
pub const MEASURED: Rgba32 = Rgba32::from_rgb(46, 146, 214);
/// What the model gives, and the fitter.
pub const MODEL: Rgba32 = Rgba32::from_rgb(240, 134, 10);
/// Turning towards negative angle.
pub const NEGATIVE: Rgba32 = Rgba32::from_rgb(220, 80, 115);
/// Turning towards positive angle, and the recorder.
pub const POSITIVE: Rgba32 = Rgba32::from_rgb(52, 168, 96);
/// A knob at rest, held by static friction.
pub const STICKING: Rgba32 = Rgba32::from_rgb(150, 110, 235);
/// Behind the knob, in light and dark themes alike.
pub const GROUND: Rgba32 = Rgba32::from_rgb(22, 26, 30);
/// The pointer on the knob.
pub const WHITE: Rgba32 = Rgba32::from_rgb(245, 247, 248);
/// Axes and their labels.
pub const NEUTRAL: Rgba32 = Rgba32::from_rgb(128, 134, 140);

pub fn translucent(color: Rgba32, alpha: u8) -> Rgba32 {
    let [red, green, blue, _] = color.to_array();
    Rgba32::from_unmultiplied_rgba(red, green, blue, alpha)
}
