//! Captures and models as the analysis wants them.

use std::path::Path;

use archive::{Capture, attachment};
use dynamics::{Calibration, Model};
use identification::Samples;

/// A capture with what is known of the rig that made it.
pub struct LoadedCapture {
    /// The capture.
    pub capture: Capture,
    /// The rig's calibration; `None` for a table.
    pub calibration: Option<Calibration>,
    /// The knob that the simulated rig turned; `None` for a real one or a table.
    pub truth: Option<Model>,
}

impl LoadedCapture {
    /// Reads a capture and its attachments.
    ///
    /// # Errors
    /// One sentence on what is wrong with the file.
    pub fn load(path: &Path) -> anyhow::Result<Self> {
        let capture = Capture::load(path)?;
        let calibration = capture
            .attached_text(attachment::CALIBRATION)
            .filter(|text| !text.is_empty())
            .map(Calibration::from_toml)
            .transpose()?;
        let truth = capture
            .attached_text(attachment::MODEL)
            .map(|text| Model::from_toml(text, &format!("the model in {}", path.display())))
            .transpose()?;
        Ok(Self { capture, calibration, truth })
    }

    /// The columns that a fit takes.
    pub fn samples(&self) -> Samples<'_> {
        Samples {
            t_s: &self.capture.t_s,
            angle_rad: &self.capture.angle_rad,
            velocity_rad_s: self.capture.velocity_rad_s.as_deref(),
            acceleration_rad_s2: self.capture.acceleration_rad_s2.as_deref(),
            torque_mnm: &self.capture.torque_mnm,
        }
    }

    /// What to call it in tables and on pages.
    pub fn title(&self) -> String {
        let file = self.capture.source.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        match &self.capture.description {
            Some(description) => format!("Knob {} ({file})", description.knob),
            None => file,
        }
    }

    /// The report page of a fit of this capture.
    pub fn report_page(&self, _fit: &identification::Fit) -> String {
        String::new()
    }
}
