//! What FMI 3.0 has and a knob has no use for: exported, since importers look for every function, and refused.

use std::ffi::{c_char, c_void};
use std::ptr::null_mut;

use crate::{ERROR, Instance, Status};

/// Functions of one signature that do nothing and say that they failed.
macro_rules! refused {
    ($(($($argument:ty),*): $($name:ident)*;)*) => { $(refused!(@ ($($argument),*) $($name)*);)* };
    (@ $arguments:tt $($name:ident)*) => { $(refused!(# $arguments $name);)* };
    (# ($($argument:ty),*) $name:ident) => {
        /// Refused.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name($(_: $argument),*) -> Status {
            ERROR
        }
    };
}

type Any = *mut c_void;
type This = *mut Instance;

refused! {
    (This): fmi3EnterEventMode fmi3EnterConfigurationMode fmi3ExitConfigurationMode fmi3EvaluateDiscreteStates
        fmi3EnterContinuousTimeMode fmi3EnterStepMode;
    (This, Any, usize, Any, usize): fmi3GetFloat32 fmi3GetInt8 fmi3GetUInt8 fmi3GetInt16 fmi3GetUInt16 fmi3GetInt32
        fmi3GetUInt32 fmi3GetInt64 fmi3GetUInt64 fmi3GetBoolean fmi3GetString fmi3SetFloat32 fmi3SetInt8 fmi3SetUInt8
        fmi3SetInt16 fmi3SetUInt16 fmi3SetInt32 fmi3SetUInt32 fmi3SetInt64 fmi3SetUInt64 fmi3SetBoolean fmi3SetString;
    (This, Any, usize, Any, Any, usize): fmi3GetBinary fmi3SetBinary fmi3GetOutputDerivatives;
    (This, Any, usize, Any): fmi3GetClock fmi3SetClock fmi3DeserializeFMUState fmi3GetShiftDecimal
        fmi3SetIntervalDecimal fmi3SetShiftDecimal;
    (This, u32, Any): fmi3GetNumberOfVariableDependencies;
    (This, u32, Any, Any, Any, Any, usize): fmi3GetVariableDependencies;
    (This, Any): fmi3GetFMUState fmi3SetFMUState fmi3FreeFMUState fmi3GetNumberOfEventIndicators
        fmi3GetNumberOfContinuousStates;
    (This, Any, Any): fmi3SerializedFMUStateSize;
    (This, Any, Any, usize): fmi3SerializeFMUState;
    (This, Any, usize, Any, usize, Any, usize, Any, usize): fmi3GetDirectionalDerivative fmi3GetAdjointDerivative;
    (This, Any, usize, Any, Any): fmi3GetIntervalDecimal fmi3GetShiftFraction fmi3SetIntervalFraction
        fmi3SetShiftFraction;
    (This, Any, usize, Any, Any, Any): fmi3GetIntervalFraction;
    (This, Any, Any, Any, Any, Any, Any): fmi3UpdateDiscreteStates;
    (This, bool, Any, Any): fmi3CompletedIntegratorStep;
    (This, f64): fmi3SetTime;
    (This, Any, usize): fmi3SetContinuousStates fmi3GetContinuousStateDerivatives fmi3GetEventIndicators
        fmi3GetContinuousStates fmi3GetNominalsOfContinuousStates;
    (This, u32, f64): fmi3ActivateModelPartition;
}

/// Refused: a knob is for co-simulation.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateModelExchange(
    _: *const c_char,
    _: *const c_char,
    _: *const c_char,
    _: bool,
    _: bool,
    _: Any,
    _: Any,
) -> This {
    null_mut()
}

/// Refused: a knob is for co-simulation.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateScheduledExecution(
    _: *const c_char,
    _: *const c_char,
    _: *const c_char,
    _: bool,
    _: bool,
    _: Any,
    _: Any,
    _: Any,
    _: Any,
    _: Any,
) -> This {
    null_mut()
}
