//! The shared library within the FMUs that `haptic-camera export MODEL --out FILE.fmu` writes.
//!
//! One library is every knob: it reads the model from the FMU's resources, and its parameters are start values. It speaks the C
//! interface of FMI 3.0.2 for co-simulation (<https://fmi-standard.org/docs/3.0.2/>, section 4 and `fmi3FunctionTypes.h`): angle,
//! velocity and acceleration in, torque out. What a knob has no use for (other types, clocks, states, derivatives) is exported, as the
//! standard asks, and refused.
#![allow(unsafe_code, reason = "FMI is a C interface")]
#![allow(non_snake_case, reason = "the functions are called as FMI calls them")]
#![allow(
    clippy::missing_safety_doc,
    reason = "the standard states what callers must uphold; the module's documentation refers to it"
)]

mod knob;
mod refused;

use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::path::Path;
use std::slice;

use knob::{Knob, KnobError};
use simulator_formats::fmi::TOKEN;

/// `fmi3Status`.
pub(crate) type Status = c_int;
const OK: Status = 0;
pub(crate) const ERROR: Status = 3;

/// `fmi3LogMessageCallback`.
type LogMessage = Option<unsafe extern "C" fn(*mut c_void, Status, *const c_char, *const c_char)>;

/// An instance: the knob, and the importer's function that logs its errors.
pub struct Instance {
    knob: Knob,
    environment: *mut c_void,
    log: LogMessage,
}

impl Instance {
    fn status(&self, result: Result<(), KnobError>) -> Status {
        match result {
            Ok(()) => OK,
            Err(error) => {
                // SAFETY: the importer gave the function and its environment for this.
                unsafe { tell(self.log, self.environment, &error.to_string()) };
                ERROR
            }
        }
    }
}

unsafe fn tell(log: LogMessage, environment: *mut c_void, words: &str) {
    if let (Some(log), Ok(words)) = (log, CString::new(words)) {
        // SAFETY: the importer's own function with its own environment; the texts live meanwhile.
        unsafe { log(environment, ERROR, c"logStatusError".as_ptr(), words.as_ptr()) };
    }
}

/// The instance behind a pointer.
///
/// # Safety
/// It came from [`fmi3InstantiateCoSimulation`], was not freed, and no other call uses it meanwhile.
unsafe fn instance<'caller>(instance: *mut Instance) -> Option<&'caller mut Instance> {
    // SAFETY: the caller's promise.
    unsafe { instance.as_mut() }
}

/// `count` values at `place`; none at a null pointer.
///
/// # Safety
/// `place` is null, or points to `count` values.
unsafe fn values<'caller, T>(place: *const T, count: usize) -> &'caller [T] {
    if place.is_null() {
        return &[];
    }
    // SAFETY: the caller's promise.
    unsafe { slice::from_raw_parts(place, count) }
}

/// The version of the standard.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3GetVersion() -> *const c_char {
    c"3.0".as_ptr()
}

/// Logging is of errors, and always on.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetDebugLogging(_: *mut Instance, _: bool, _: usize, _: *const *const c_char) -> Status {
    OK
}

/// A knob of the model in the FMU's resources; null, with a message, where that cannot be read.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateCoSimulation(
    _name: *const c_char,
    token: *const c_char,
    resource_path: *const c_char,
    _visible: bool,
    _logging_on: bool,
    _event_mode_used: bool,
    _early_return_allowed: bool,
    _intermediate_variables: *const u32,
    _intermediate_variable_count: usize,
    environment: *mut c_void,
    log: LogMessage,
    _intermediate_update: *const c_void,
) -> *mut Instance {
    // SAFETY: the importer's texts end with a zero.
    let text = |text: *const c_char| (!text.is_null()).then(|| unsafe { CStr::from_ptr(text) });
    let knob = match (text(token), text(resource_path).map(CStr::to_str)) {
        (Some(token), Some(Ok(resources))) if token.to_bytes() == TOKEN.as_bytes() => {
            Knob::load(Path::new(resources)).map_err(|error| error.to_string())
        }
        (Some(token), Some(Ok(_))) => Err(format!("the FMU's token is {token:?} and not {TOKEN}; export it again")),
        _ => Err("the FMU's token or resource path is missing".to_owned()),
    };
    match knob {
        Ok(knob) => Box::into_raw(Box::new(Instance { knob, environment, log })),
        Err(words) => {
            // SAFETY: as for `tell`.
            unsafe { tell(log, environment, &words) };
            std::ptr::null_mut()
        }
    }
}

/// Frees an instance.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3FreeInstance(instance: *mut Instance) {
    if !instance.is_null() {
        // SAFETY: it came from a box in `fmi3InstantiateCoSimulation` and is freed once.
        drop(unsafe { Box::from_raw(instance) });
    }
}

/// Takes the time of the beginning; parameters and inputs are set from here on.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterInitializationMode(
    instance: *mut Instance,
    _tolerance_defined: bool,
    _tolerance: f64,
    start_time: f64,
    _stop_time_defined: bool,
    _stop_time: f64,
) -> Status {
    // SAFETY: the importer's promise.
    unsafe { self::instance(instance) }.map_or(ERROR, |instance| {
        instance.knob.start_at(start_time);
        OK
    })
}

/// Begins, at rest at the angle that was set.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3ExitInitializationMode(instance: *mut Instance) -> Status {
    // SAFETY: the importer's promise.
    unsafe { self::instance(instance) }.map_or(ERROR, |instance| {
        let begun = instance.knob.begin();
        instance.status(begun)
    })
}

/// There is nothing to end.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3Terminate(_: *mut Instance) -> Status {
    OK
}

/// The knob as it was loaded.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3Reset(instance: *mut Instance) -> Status {
    // SAFETY: the importer's promise.
    unsafe { self::instance(instance) }.map_or(ERROR, |instance| {
        instance.knob.reset();
        OK
    })
}

/// Values of variables.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetFloat64(
    instance: *mut Instance,
    references: *const u32,
    count: usize,
    place: *mut f64,
    place_count: usize,
) -> Status {
    if place_count != count {
        return ERROR;
    }
    // Importers ask for nothing with a place of null.
    if count == 0 {
        return OK;
    }
    if place.is_null() {
        return ERROR;
    }
    // SAFETY: the importer's promise.
    let Some(instance) = (unsafe { self::instance(instance) }) else { return ERROR };
    // SAFETY: there are so many references, and room for so many values.
    let (references, place) = unsafe { (values(references, count), slice::from_raw_parts_mut(place, place_count)) };
    for (reference, place) in references.iter().zip(place) {
        let Some(value) = instance.knob.value(*reference) else {
            return instance.status(Err(KnobError::Unknown(*reference)));
        };
        *place = value;
    }
    OK
}

/// Sets inputs, and parameters before the first step.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetFloat64(
    instance: *mut Instance,
    references: *const u32,
    count: usize,
    given: *const f64,
    given_count: usize,
) -> Status {
    // SAFETY: the importer's promise.
    let Some(instance) = (unsafe { self::instance(instance) }) else { return ERROR };
    // SAFETY: there are so many references and values.
    let (references, given) = unsafe { (values(references, count), values(given, given_count)) };
    if references.len() != given.len() {
        return ERROR;
    }
    let set = references.iter().zip(given).try_for_each(|(reference, value)| instance.knob.set(*reference, *value));
    instance.status(set)
}

/// A step: the torque afterwards is that of the motion which was set before.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3DoStep(
    instance: *mut Instance,
    time: f64,
    step: f64,
    _no_return_before: bool,
    event: *mut bool,
    terminate: *mut bool,
    early_return: *mut bool,
    last_time: *mut f64,
) -> Status {
    // SAFETY: the importer's promise.
    let Some(instance) = (unsafe { self::instance(instance) }) else { return ERROR };
    for flag in [event, terminate, early_return] {
        // SAFETY: pointers to the importer's own places, or null.
        if let Some(flag) = unsafe { flag.as_mut() } {
            *flag = false;
        }
    }
    let stepped = instance.knob.step(time, time + step);
    // SAFETY: likewise.
    if let Some(last_time) = unsafe { last_time.as_mut() } {
        *last_time = if stepped.is_ok() { time + step } else { time };
    }
    instance.status(stepped)
}
