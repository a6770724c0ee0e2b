//! `haptic_camera` for Python: captures as NumPy and Arrow columns, fits, diagnoses, simulations and models.
//!
//! Every number comes from the crates that the command line uses, and every result is the same JSON. The interpreter's lock is
//! released while files are read and while anything is computed.

mod arrow;
mod capture;
mod columns;
mod convert;
mod diagnosis;
mod error;
mod fit;
mod interruptible;
mod judgement;
mod model;
mod row;
mod sheet;
mod simulation;

use pyo3::pymodule;

#[pymodule]
mod _native {
    #[pymodule_export]
    use crate::capture::{Capture, read};
    #[pymodule_export]
    use crate::diagnosis::{Diagnosis, Progress, diagnose};
    #[pymodule_export]
    use crate::error::Error;
    #[pymodule_export]
    use crate::fit::{Fit, Parameter, fit};
    #[pymodule_export]
    use crate::judgement::{Judgement, Verdict, judge};
    #[pymodule_export]
    use crate::model::Model;
    #[pymodule_export]
    use crate::row::{table_columns, table_row};
    #[pymodule_export]
    use crate::sheet::{Figure, Sheet, sheet};
    #[pymodule_export]
    use crate::simulation::simulate;
}
