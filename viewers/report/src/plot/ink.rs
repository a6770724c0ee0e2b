//! What a stroke stands for. The style sheet decides how that looks in light, in dark and on paper.

use plotters::style::RGBColor;
use plotters_backend::BackendColor;

/// The meaning of a mark in a plot.
///
/// plotters passes nothing but RGB from an element to its backend, so an ink travels as a colour.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Ink {
    /// Grid lines.
    Grid,
    /// Tick labels.
    Label,
    /// Axis titles.
    Title,
    /// The line at zero.
    Zero,
    /// Measured torque while turning positively.
    MeasuredPositive,
    /// Measured torque while turning negatively.
    MeasuredNegative,
    /// Model torque while turning positively.
    ModelPositive,
    /// Model torque while turning negatively.
    ModelNegative,
    /// Measured torque in either direction.
    Measured,
    /// Model torque in either direction.
    Model,
    /// Measured minus model.
    Residual,
    /// A level or place to compare with.
    Reference,
    /// What is left before an effect is added.
    Before,
    /// What is left with it.
    After,
    /// What the sensors' noise alone leaves.
    Floor,
}

impl Ink {
    const ALL: [Self; 15] = [
        Self::Grid,
        Self::Label,
        Self::Title,
        Self::Zero,
        Self::MeasuredPositive,
        Self::MeasuredNegative,
        Self::ModelPositive,
        Self::ModelNegative,
        Self::Measured,
        Self::Model,
        Self::Residual,
        Self::Reference,
        Self::Before,
        Self::After,
        Self::Floor,
    ];

    /// Class in the style sheet.
    pub(crate) fn class(self) -> &'static str {
        match self {
            Self::Grid => "grid",
            Self::Label => "label",
            Self::Title => "title",
            Self::Zero => "zero",
            Self::MeasuredPositive => "measured-positive",
            Self::MeasuredNegative => "measured-negative",
            Self::ModelPositive => "model-positive",
            Self::ModelNegative => "model-negative",
            Self::Measured => "measured",
            Self::Model => "model",
            Self::Residual => "residual",
            Self::Reference => "reference",
            Self::Before => "before",
            Self::After => "after",
            Self::Floor => "floor",
        }
    }

    /// The colour as which the ink travels through plotters.
    pub(crate) fn color(self) -> RGBColor {
        RGBColor(self as u8, 0, 0)
    }

    /// The ink that travelled as `color`.
    pub(crate) fn of(color: BackendColor) -> Self {
        Self::ALL.get(usize::from(color.rgb.0)).copied().unwrap_or(Self::Label)
    }
}
