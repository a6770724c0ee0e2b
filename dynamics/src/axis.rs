//! The axis along which a control moves, with its units and words.

mod words;

use serde::{Deserialize, Serialize};

/// Acceleration of free fall by which a gram-force is defined, m/s² (BIPM, The International System of Units, 3rd CGPM 1901).
const STANDARD_GRAVITY: f64 = 9.806_65;
/// An inch, mm.
const INCH_MM: f64 = 25.4;
/// A pound, g (International Yard and Pound Agreement, 1959).
const POUND_G: f64 = 453.592_37;

/// Whether a control is turned, or pressed and slid.
///
/// Position and load are one quantity each in the mathematics; only their names and units differ.
///
/// ```
/// use dynamics::Axis;
///
/// assert_eq!((Axis::Rotary.position_unit(), Axis::Rotary.load_unit()), ("rad", "mNm"));
/// assert_eq!((Axis::Linear.position_unit(), Axis::Linear.load_unit()), ("mm", "N"));
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Axis {
    /// Turned: angle in rad, torque in mNm.
    #[default]
    Rotary,
    /// Pressed or slid: travel in mm, force in N.
    Linear,
}

impl Axis {
    /// Whether it is turned.
    #[must_use]
    pub fn is_rotary(&self) -> bool {
        *self == Self::Rotary
    }

    /// Travel of a fingertip that moves the usual knob by 1 rad, in this axis's unit: the rim is 20 mm from the axis.
    ///
    /// It converts values known of hands and knobs to this axis: multiply positions and speeds by it, divide loads by it, and divide
    /// inertia, damping and stiffness by its square. Energies are the same.
    #[must_use]
    pub fn fingertip_travel(self) -> f64 {
        match self {
            Self::Rotary => 1.0,
            Self::Linear => 20.0,
        }
    }

    /// What its position is.
    #[must_use]
    pub fn position(self) -> Quantity {
        match self {
            Self::Rotary => Quantity::Angle,
            Self::Linear => Quantity::Travel,
        }
    }

    /// What resists its motion.
    #[must_use]
    pub fn load(self) -> Quantity {
        match self {
            Self::Rotary => Quantity::Torque,
            Self::Linear => Quantity::Force,
        }
    }

    /// Unit of the position.
    #[must_use]
    pub fn position_unit(self) -> &'static str {
        self.position().unit()
    }

    /// Unit of the load.
    #[must_use]
    pub fn load_unit(self) -> &'static str {
        self.load().unit()
    }
}

impl std::fmt::Display for Axis {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str(match self {
            Self::Rotary => "rotary",
            Self::Linear => "linear",
        })
    }
}

/// A measured quantity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Angle, in rad.
    Angle,
    /// Torque, in mNm.
    Torque,
    /// Travel, in mm.
    Travel,
    /// Force, in N.
    Force,
    /// Time, in s.
    Time,
    /// Energy, in mJ, which is mNm rad and N mm.
    Energy,
    /// A share or a count.
    Number,
}

impl Quantity {
    /// What it is called.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Angle => "angle",
            Self::Torque => "torque",
            Self::Travel => "travel",
            Self::Force => "force",
            Self::Time => "time",
            Self::Energy => "energy",
            Self::Number => "number",
        }
    }

    /// The unit that the instrument works in.
    #[must_use]
    pub fn unit(self) -> &'static str {
        self.units()[0].0
    }

    /// Every unit that is understood, the instrument's own first, each with its factor to the instrument's unit.
    #[must_use]
    pub fn units(self) -> &'static [(&'static str, f64)] {
        const GRAM_FORCE_N: f64 = STANDARD_GRAVITY * 1e-3;
        const POUND_FORCE_N: f64 = POUND_G * GRAM_FORCE_N;
        const OUNCE_FORCE_N: f64 = POUND_FORCE_N / 16.0;
        match self {
            Self::Angle => &[
                ("rad", 1.0),
                ("mrad", 1e-3),
                ("deg", std::f64::consts::PI / 180.0),
                ("degree", std::f64::consts::PI / 180.0),
                ("degrees", std::f64::consts::PI / 180.0),
                ("°", std::f64::consts::PI / 180.0),
                ("turn", std::f64::consts::TAU),
                ("turns", std::f64::consts::TAU),
                ("rev", std::f64::consts::TAU),
            ],
            Self::Torque => &[
                ("mNm", 1.0),
                ("Nm", 1e3),
                ("uNm", 1e-3),
                ("µNm", 1e-3),
                ("cNm", 10.0),
                ("Ncm", 10.0),
                ("Nmm", 1.0),
                ("gfcm", 10.0 * GRAM_FORCE_N),
                ("gcm", 10.0 * GRAM_FORCE_N),
                ("kgfcm", 1e4 * GRAM_FORCE_N),
                ("kgcm", 1e4 * GRAM_FORCE_N),
                ("ozin", OUNCE_FORCE_N * INCH_MM),
                ("inlb", POUND_FORCE_N * INCH_MM),
                ("lbin", POUND_FORCE_N * INCH_MM),
            ],
            Self::Travel => &[("mm", 1.0), ("um", 1e-3), ("µm", 1e-3), ("cm", 10.0), ("m", 1e3), ("in", INCH_MM)],
            Self::Force => &[
                ("N", 1.0),
                ("mN", 1e-3),
                ("cN", 1e-2),
                ("gf", GRAM_FORCE_N),
                ("g", GRAM_FORCE_N),
                ("kgf", 1e3 * GRAM_FORCE_N),
                ("lbf", POUND_FORCE_N),
                ("ozf", OUNCE_FORCE_N),
            ],
            Self::Time => &[
                ("s", 1.0),
                ("sec", 1.0),
                ("ms", 1e-3),
                ("msec", 1e-3),
                ("us", 1e-6),
                ("µs", 1e-6),
                ("usec", 1e-6),
                ("ns", 1e-9),
                ("min", 60.0),
            ],
            Self::Energy => &[("mJ", 1.0), ("N mm", 1.0), ("J", 1e3), ("gf mm", GRAM_FORCE_N)],
            Self::Number => &[("", 1.0), ("share", 1.0), ("%", 0.01)],
        }
    }

    /// The factor from `unit` to the instrument's unit, however a product is written: Nm, N m, N·m, N*m, N.m or N-m; `None` for a unit of
    /// another quantity.
    ///
    /// ```
    /// use dynamics::Quantity;
    ///
    /// assert_eq!(Quantity::Torque.factor("Ncm"), Some(10.0));
    /// assert_eq!(Quantity::Torque.factor("N·m"), Some(1e3));
    /// assert_eq!(Quantity::Torque.factor("mm"), None);
    /// ```
    #[must_use]
    pub fn factor(self, unit: &str) -> Option<f64> {
        self.factor_as(unit, |one, other| one == other)
    }

    /// The same however a unit is capitalised, as in the names of columns: `ANGLE_DEG`. No two units of a quantity differ in that alone. Inches
    /// and single letters are as they are written, since names end so, too.
    #[must_use]
    pub fn factor_in_any_case(self, unit: &str) -> Option<f64> {
        self.factor_as(unit, |one, other| {
            one == other || one.len() > 1 && one != "in" && one.to_lowercase() == other.to_lowercase()
        })
    }

    fn factor_as(self, unit: &str, is_same: impl Fn(&str, &str) -> bool) -> Option<f64> {
        // Greek mu looks like the sign for micro.
        let plain = |unit: &str| unit.replace([' ', '·', '⋅', '*', '-', '.'], "").replace('μ', "µ");
        let unit = plain(spelled_out(unit).unwrap_or(unit));
        self.units().iter().find(|(name, _)| is_same(&plain(name), &unit)).map(|(_, factor)| *factor)
    }
}

/// The sign of a unit that is spelled out, as programs name columns: `time_seconds`.
fn spelled_out(unit: &str) -> Option<&'static str> {
    let name = unit.trim().to_lowercase();
    Some(match name.strip_suffix('s').unwrap_or(&name) {
        "second" => "s",
        "millisecond" | "milli" => "ms",
        "microsecond" | "micro" => "us",
        "nanosecond" | "nano" => "ns",
        "minute" => "min",
        "radian" => "rad",
        "milliradian" => "mrad",
        "revolution" => "rev",
        "newton" => "N",
        "millinewton" => "mN",
        "centinewton" => "cN",
        "gram" | "gramforce" => "gf",
        "kilogram" | "kilogramforce" => "kgf",
        "newtonmeter" | "newtonmetre" => "Nm",
        "millinewtonmeter" | "millinewtonmetre" => "mNm",
        "micronewtonmeter" | "micronewtonmetre" => "uNm",
        "newtoncentimeter" | "newtoncentimetre" => "Ncm",
        "newtonmillimeter" | "newtonmillimetre" => "Nmm",
        "meter" | "metre" => "m",
        "centimeter" | "centimetre" => "cm",
        "millimeter" | "millimetre" => "mm",
        "micrometer" | "micrometre" | "micron" => "um",
        "inch" | "inche" => "in",
        _ => return None,
    })
}
