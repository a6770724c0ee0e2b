//! `haptic_rig.h` in Rust: the layouts and functions of a library.

#![allow(unsafe_code, reason = "a shared library is entered through pointers that it gives")]

use std::ffi::{CStr, c_char, c_void};
use std::path::{Path, PathBuf};

use libloading::Library;

use crate::MOST_CHANNELS;

/// Version of the interface, as the header has it.
pub const ABI: u32 = 1;

#[repr(C)]
pub(super) struct Setting {
    pub(super) key: *const c_char,
    pub(super) value: *const c_char,
}

#[repr(C)]
#[derive(Clone, Copy)]
struct Code {
    code: i32,
    meaning: *const c_char,
}

#[repr(C)]
struct Description {
    name: *const c_char,
    channel_count: u32,
    code_count: u32,
    channels: *const *const c_char,
    codes: *const Code,
    watchdog_s: f64,
}

#[repr(C)]
#[derive(Clone, Copy, Default)]
pub(super) struct Raw {
    pub(super) time_ns: u64,
    pub(super) shift_ns: i64,
    pub(super) valid: u32,
    reserved: u32,
    pub(super) value: [f64; MOST_CHANNELS],
}

/// What the library says of its device.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Described {
    pub(super) name: Option<String>,
    pub(super) channels: Vec<String>,
    pub(super) codes: Vec<(i32, String)>,
    pub(super) watchdog_s: Option<f64>,
}

type Open = unsafe extern "C" fn(*const Setting, u32, *mut *mut c_void) -> i32;
type Describe = unsafe extern "C" fn(*mut c_void, *mut Description);
type Stop = unsafe extern "C" fn(*mut c_void) -> i32;
type Prepare = unsafe extern "C" fn(*mut c_void, Stop, *mut c_void) -> i32;
type Enable = unsafe extern "C" fn(*mut c_void) -> i32;
type Disable = unsafe extern "C" fn(*mut c_void);
type Exchange = unsafe extern "C" fn(*mut c_void, u64, f64, *mut Raw) -> i32;
type WriteTorque = unsafe extern "C" fn(*mut c_void, f64) -> i32;

/// Why a library cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum PluginError {
    /// The system does not load it.
    #[error("the library {} cannot be loaded ({reason}); build it with `cc -shared -fPIC`", path.display())]
    NotLoaded {
        /// The library.
        path: PathBuf,
        /// The loader's word for it.
        reason: String,
    },
    /// It lacks a function of the header.
    #[error("the library {} has no function `{symbol}`; implement all of haptic_rig.h but what it calls optional", path.display())]
    Missing {
        /// The library.
        path: PathBuf,
        /// The function.
        symbol: String,
    },
    /// It was built with another version of the header.
    #[error(
        "the library {} has version {found} of haptic_rig.h, but this program takes version {ABI}; build it with this program's \
         header", path.display()
    )]
    OtherAbi {
        /// The library.
        path: PathBuf,
        /// Its version.
        found: u32,
    },
    /// It refused to open.
    #[error("the library {} refused its settings with code {code}", path.display())]
    Refused {
        /// The library.
        path: PathBuf,
        /// Its code.
        code: i32,
    },
    /// It describes a device that cannot be.
    #[error("the library {} describes {what}", path.display())]
    Description {
        /// The library.
        path: PathBuf,
        /// What is wrong with it.
        what: String,
    },
}

/// A library with an open rig.
pub(super) struct OpenRig {
    rig: *mut c_void,
    describe: Describe,
    prepare: Prepare,
    enable: Enable,
    disable: Disable,
    exchange: Exchange,
    write_torque: Option<WriteTorque>,
    close: Disable,
    path: PathBuf,
    /// Last: the functions are gone with it.
    _library: Library,
}

// SAFETY: the header promises the library that calls never overlap, and asks nothing about which thread makes those before
// `haptic_rig_enable`; the pointer is used through `&mut self` alone.
unsafe impl Send for OpenRig {}

fn symbol<Function: Copy>(library: &Library, path: &Path, name: &str) -> Result<Function, PluginError> {
    // SAFETY: the function types are those of the header, whose version is compared before any is called but `haptic_rig_abi`,
    // which is the same in every version.
    let found = unsafe { library.get::<Function>(name.as_bytes()) };
    found.map(|function| *function).map_err(|_| PluginError::Missing { path: path.to_owned(), symbol: name.to_owned() })
}

impl OpenRig {
    /// Loads a library and opens its rig with these settings.
    pub(super) fn open(path: &Path, settings: &[(std::ffi::CString, std::ffi::CString)]) -> Result<Self, PluginError> {
        // SAFETY: loading runs the library's initialisers: whoever names a library in a rig file trusts it with the rig.
        let library = unsafe { Library::new(path) }.map_err(|error| PluginError::NotLoaded {
            path: path.to_owned(),
            reason: std::error::Error::source(&error).map_or_else(|| error.to_string(), ToString::to_string),
        })?;
        let abi: unsafe extern "C" fn() -> u32 = symbol(&library, path, "haptic_rig_abi")?;
        // SAFETY: the function takes nothing and returns a number in every version of the header.
        let found = unsafe { abi() };
        if found != ABI {
            return Err(PluginError::OtherAbi { path: path.to_owned(), found });
        }
        let open: Open = symbol(&library, path, "haptic_rig_open")?;
        let mut opened = Self {
            rig: std::ptr::null_mut(),
            describe: symbol(&library, path, "haptic_rig_describe")?,
            prepare: symbol(&library, path, "haptic_rig_prepare")?,
            enable: symbol(&library, path, "haptic_rig_enable")?,
            disable: symbol(&library, path, "haptic_rig_disable")?,
            exchange: symbol(&library, path, "haptic_rig_exchange")?,
            write_torque: symbol(&library, path, "haptic_rig_write_torque").ok(),
            close: symbol(&library, path, "haptic_rig_close")?,
            path: path.to_owned(),
            _library: library,
        };
        let settings: Vec<Setting> =
            settings.iter().map(|(key, value)| Setting { key: key.as_ptr(), value: value.as_ptr() }).collect();
        let count = u32::try_from(settings.len()).unwrap_or(u32::MAX);
        // SAFETY: the settings, as many as counted, outlive the call, and the pointer that is filled in is `opened`'s.
        let code = unsafe { open(settings.as_ptr(), count, &raw mut opened.rig) };
        if code != 0 {
            // What was not opened is not closed.
            opened.rig = std::ptr::null_mut();
            return Err(PluginError::Refused { path: path.to_owned(), code });
        }
        Ok(opened)
    }

    pub(super) fn describe(&mut self) -> Result<Described, PluginError> {
        let mut description = Description {
            name: std::ptr::null(),
            channel_count: 0,
            code_count: 0,
            channels: std::ptr::null(),
            codes: std::ptr::null(),
            watchdog_s: 0.0,
        };
        // SAFETY: the rig is open and the description lives beyond the call.
        unsafe { (self.describe)(self.rig, &raw mut description) };
        let wrong = |what: &str| PluginError::Description { path: self.path.clone(), what: what.to_owned() };
        let channel_count = description.channel_count as usize;
        if channel_count == 0 || channel_count > MOST_CHANNELS || description.channels.is_null() {
            return Err(wrong(&format!("{channel_count} channels, but it must name 1 to {MOST_CHANNELS}")));
        }
        if description.code_count > 0 && description.codes.is_null() || description.code_count > MOST_CODES {
            return Err(wrong("codes that are not there, or too many of them"));
        }
        // SAFETY: the header has the library give as many names as it counts, valid until the rig is closed.
        let names = unsafe { std::slice::from_raw_parts(description.channels, channel_count) };
        let codes: &[Code] = match description.code_count {
            0 => &[],
            // SAFETY: likewise as many codes as it counts.
            count => unsafe { std::slice::from_raw_parts(description.codes, count as usize) },
        };
        let channels: Option<Vec<String>> = names.iter().map(|name| text(*name)).collect();
        let codes = codes.iter().map(|entry| (entry.code, text(entry.meaning).unwrap_or_default())).collect();
        Ok(Described {
            name: text(description.name),
            channels: channels.ok_or_else(|| wrong("a channel without a name"))?,
            codes,
            watchdog_s: (description.watchdog_s.is_finite() && description.watchdog_s > 0.0)
                .then_some(description.watchdog_s),
        })
    }

    pub(super) fn prepare(&mut self, stop: &dyn Fn() -> bool) -> i32 {
        unsafe extern "C" fn ask(context: *mut c_void) -> i32 {
            // SAFETY: the context is the reference below, which lives beyond the call of `prepare`.
            let stop = unsafe { *context.cast::<&dyn Fn() -> bool>() };
            i32::from(stop())
        }
        let mut stop = stop;
        // SAFETY: the rig is open, and the context is what `ask` takes it for.
        unsafe { (self.prepare)(self.rig, ask, (&raw mut stop).cast()) }
    }

    pub(super) fn enable(&mut self) -> i32 {
        // SAFETY: the rig is open.
        unsafe { (self.enable)(self.rig) }
    }

    pub(super) fn disable(&mut self) {
        // SAFETY: the rig is open.
        unsafe { (self.disable)(self.rig) }
    }

    pub(super) fn exchange(&mut self, due_ns: u64, torque: f64, raw: &mut Raw) -> i32 {
        // SAFETY: the rig is open, and the measurement lives beyond the call.
        unsafe { (self.exchange)(self.rig, due_ns, torque, raw) }
    }

    /// Whether the rig takes a torque between two exchanges.
    pub(super) fn takes_torque_at_once(&self) -> bool {
        self.write_torque.is_some()
    }

    pub(super) fn write_torque(&mut self, torque: f64) -> i32 {
        // SAFETY: the rig is open.
        self.write_torque.map_or(0, |write| unsafe { write(self.rig, torque) })
    }
}

impl Drop for OpenRig {
    fn drop(&mut self) {
        if !self.rig.is_null() {
            // SAFETY: the rig is open, and nothing uses it after this.
            unsafe { (self.close)(self.rig) }
        }
    }
}

/// Most codes that a device explains.
const MOST_CODES: u32 = 4_096;

/// A text of the library; `None` where there is none.
fn text(pointer: *const c_char) -> Option<String> {
    // SAFETY: the header has the library give texts that end with a zero and stay valid until the rig is closed.
    (!pointer.is_null()).then(|| unsafe { CStr::from_ptr(pointer) }.to_string_lossy().into_owned())
}
