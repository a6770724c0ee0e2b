//! FMI 3.0 (<https://fmi-standard.org/docs/3.0.2/>): a model as an FMU for co-simulation.
//!
//! An FMU is a ZIP file. Ours holds a library that serves every knob, the model as one of its resources, and the description of
//! its variables: angle, velocity and acceleration in, torque out, each parameter of the model a start value.

use std::fmt::Write as _;
use std::io::{Cursor, Write as _};

use dynamics::{Model, effects};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter, result::ZipError};

use crate::said::{Export, LinearAxis, misreadings, refuse_linear, without_misreadings};
use crate::xml::{attribute, comment};

/// What the description and the library must agree about.
pub const TOKEN: &str = concat!("haptic-camera ", env!("CARGO_PKG_VERSION"));

/// The model among the FMU's resources.
pub const MODEL_FILE: &str = "model.toml";

/// What the library is called within the FMU, without its ending.
const LIBRARY: &str = "haptic_knob";

/// A variable of the FMU.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Variable {
    /// Time, s.
    Time,
    /// Angle of the knob, rad: an input.
    Angle,
    /// Its velocity, rad/s: an input.
    Velocity,
    /// Its acceleration, rad/s²: an input.
    Acceleration,
    /// The torque that it takes, N m: the output.
    Torque,
    /// Inertia that turns with it, in the model's unit.
    AddedInertia,
    /// A parameter of the model by its place among all of them, in the model's unit.
    Parameter(usize),
}

/// Those before the parameters, by their value references.
const FIRST: [Variable; 6] = [
    Variable::Time,
    Variable::Angle,
    Variable::Velocity,
    Variable::Acceleration,
    Variable::Torque,
    Variable::AddedInertia,
];

impl Variable {
    /// The variable with that value reference.
    #[must_use]
    pub fn of(reference: u32) -> Self {
        let index = reference as usize;
        FIRST.get(index).copied().unwrap_or(Self::Parameter(index.saturating_sub(FIRST.len())))
    }
}

/// Why a model has no FMU.
#[derive(Debug, thiserror::Error)]
pub enum FmuError {
    /// A model of what is pressed or slid.
    #[error(transparent)]
    Linear(#[from] LinearAxis),
    /// Parts that are too large for a ZIP file.
    #[error(transparent)]
    Zip(#[from] ZipError),
}

/// The model as an FMU around `library`, the shared library `knob-fmu` for this machine's processor and Linux.
///
/// # Errors
/// [`FmuError`].
pub fn fmu(model: &Model, library: &[u8]) -> Result<Export<Vec<u8>>, FmuError> {
    refuse_linear(model)?;
    let said = without_misreadings(model);
    let left_out = misreadings(model);
    let description = description(&said);
    let plain = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
    let executable = SimpleFileOptions::default().unix_permissions(0o755);
    let binary = format!("binaries/{}-linux/{LIBRARY}.so", std::env::consts::ARCH);
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    // The description comes first and uncompressed: its words mark the file as one that a later output may replace.
    for (name, options, content) in [
        ("modelDescription.xml", plain, description.as_bytes()),
        (&format!("resources/{MODEL_FILE}"), plain, said.to_toml().as_bytes()),
        (&binary, executable, library),
    ] {
        zip.start_file(name, options)?;
        zip.write_all(content).map_err(ZipError::from)?;
    }
    Ok(Export { content: zip.finish()?.into_inner(), said, left_out })
}

fn description(model: &Model) -> String {
    let mut text = String::new();
    let name = attribute(&model.name);
    // Writing to a string does not fail.
    let _ = write!(
        text,
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<!-- {}, made by {TOKEN}. SI units: N m, rad, s.\n     \
         Parameters are in the units of model files. -->\n\
         <fmiModelDescription fmiVersion=\"3.0\" modelName=\"{name}\" instantiationToken=\"{TOKEN}\" \
         generationTool=\"{TOKEN}\" variableNamingConvention=\"flat\">\n  \
         <CoSimulation modelIdentifier=\"{LIBRARY}\" canHandleVariableCommunicationStepSize=\"true\"/>\n  <UnitDefinitions>\n    \
         <Unit name=\"s\"><BaseUnit s=\"1\"/></Unit>\n    <Unit name=\"rad\"><BaseUnit rad=\"1\"/></Unit>\n    \
         <Unit name=\"rad/s\"><BaseUnit rad=\"1\" s=\"-1\"/></Unit>\n    <Unit name=\"rad/s2\"><BaseUnit rad=\"1\" s=\"-2\"/></Unit>\n    \
         <Unit name=\"N.m\"><BaseUnit kg=\"1\" m=\"2\" s=\"-2\"/></Unit>\n",
        comment(&model.name),
    );
    let mut units: Vec<&str> = model.parameters().map(|(kind, _)| kind.unit).chain([inertia_unit()]).collect();
    units.sort_unstable();
    units.dedup();
    for unit in units.iter().filter(|unit| !["s", "rad", "rad/s", "1"].contains(unit)) {
        let _ = writeln!(text, "    <Unit name=\"{}\"/>", attribute(unit));
    }
    text.push_str("  </UnitDefinitions>\n  <ModelVariables>\n");
    let mut variable = |reference: usize, name: &str, role: &str, unit: &str, what: &str| {
        let unit = if unit == "1" { String::new() } else { format!(" unit=\"{}\"", attribute(unit)) };
        let _ = writeln!(
            text,
            "    <Float64 name=\"{name}\" valueReference=\"{reference}\" {role}{unit} description=\"{}\"/>",
            attribute(what)
        );
    };
    let input = "causality=\"input\" variability=\"continuous\" start=\"0\"";
    let parameter = |value: f64| format!("causality=\"parameter\" variability=\"fixed\" start=\"{value}\"");
    variable(0, "time", "causality=\"independent\" variability=\"continuous\"", "s", "time");
    variable(1, "angle", input, "rad", "angle of the knob");
    variable(2, "velocity", input, "rad/s", "velocity of the knob");
    variable(3, "acceleration", input, "rad/s2", "acceleration of the knob");
    let output = "causality=\"output\" variability=\"continuous\" initial=\"calculated\"";
    variable(4, "torque", output, "N.m", "torque that the knob takes from what turns it, as of the last step's inputs");
    variable(5, "added_inertia", &parameter(0.0), inertia_unit(), "inertia of what turns with the knob");
    for (index, (kind, value)) in model.parameters().enumerate() {
        variable(FIRST.len() + index, kind.name, &parameter(value), kind.unit, kind.description);
    }
    text.push_str(
        "  </ModelVariables>\n  <ModelStructure>\n    <Output valueReference=\"4\"/>\n    <InitialUnknown valueReference=\"4\"/>\n  \
         </ModelStructure>\n</fmiModelDescription>\n",
    );
    text
}

/// The unit of inertias in model files.
fn inertia_unit() -> &'static str {
    effects::inertia::KIND.parameters[0].unit
}
