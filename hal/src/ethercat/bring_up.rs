//! A bus from its power-up to where the drive only has to be enabled.

use std::io;
use std::ops::ControlFlow;
use std::time::Duration;

use ethercrab::error::Error;
use ethercrab::subdevice_group::{DcConfiguration, NoDc, PreOp, PreOpPdi};
use ethercrab::{
    DcSync, MainDevice, MainDeviceConfig, RegisterAddress, RetryBehaviour, SubDevice, SubDeviceRef, Timeouts,
};
use shared_types::rig::monotonic_time_ns;

use super::bus::{
    Bus, ChannelPlace, Devices, DrivePlaces, FRAMES_OF_THIS_PROCESS, Group, MOST_BYTES, MOST_DEVICES, Unanswered, Wire,
};
use super::codes;
use super::drive::{CYCLIC_SYNCHRONOUS_TORQUE, PROFILE, interpolation_period, object};
use super::entries::{Coding, DRIVE, Entry, Object, Place, Source, What};
use super::settings::{Device, Settings, Startup};
use super::socket::{LONGEST, Socket};

/// Time that a frame of the preparation may take, which no tick waits for.
const FRAME_TIMEOUT: Duration = Duration::from_millis(100);
/// Frames by which the clocks are first brought together (ETG.1020: some thousands).
const FIRST_SYNC_FRAMES: u32 = 10_000;
/// Time from when the clocks are set up to the first SYNC0.
const SYNC_BEGINS: Duration = Duration::from_millis(100);

/// Why a bus does not come up.
#[derive(Debug, thiserror::Error)]
pub enum BringUpError {
    /// The interface cannot be used.
    #[error("the network interface {interface} cannot be used ({reason}); {remedy}")]
    Interface {
        /// The interface.
        interface: String,
        /// The system's word for it.
        reason: io::Error,
        /// What to do.
        remedy: &'static str,
    },
    /// There was a bus in this process before.
    #[error("one process drives one EtherCAT bus, once")]
    Again,
    /// Nothing answers.
    #[error("nothing answers on {0}; check the cable and the devices' supply")]
    Silent(String),
    /// The interface is down.
    #[error("{0} takes no frames; bring it up (`ip link set {0} up`) and check its cable")]
    Down(String),
    /// Whoever waits has it stop.
    #[error("stopped")]
    Stopped,
    /// A device spoke where it was to answer.
    #[error(
        "a device sent an emergency message while it was set up; clear its fault, or switch it off and on, and try again"
    )]
    Interrupted,
    /// A device that is not there.
    #[error("no device is {asked}, which [settings] has for '{name}'; there are {there}")]
    Missing {
        /// The file's name for it.
        name: String,
        /// What was asked for.
        asked: String,
        /// What there is.
        there: String,
    },
    /// Several devices are what one was asked for.
    #[error("{count} devices are {asked}, which [settings] has for '{name}'; add `position`; there are {there}")]
    Ambiguous {
        /// The file's name for it.
        name: String,
        /// How many.
        count: usize,
        /// What was asked for.
        asked: String,
        /// What there is.
        there: String,
    },
    /// A device that does not do what it must.
    #[error("the device '{device}' {what}")]
    Unsuitable {
        /// The device.
        device: String,
        /// What it does not do.
        what: String,
    },
    /// A device that does not reach a state.
    #[error("the device '{device}' does not go to {state}: {reason}")]
    State {
        /// The device.
        device: String,
        /// The state.
        state: &'static str,
        /// Its reason.
        reason: String,
    },
    /// Something failed on the bus.
    #[error("the bus failed while {doing} ({reason}); check the cable and the devices' supply")]
    Bus {
        /// What was done.
        doing: String,
        /// ethercrab's word for it.
        reason: Error,
    },
    /// A source that the process data do not have.
    #[error("the source '{source_name}' is not among the inputs of '{device}': {there}; add it to its `inputs`")]
    NoInput {
        /// The source.
        source_name: String,
        /// The device.
        device: String,
        /// What it gives.
        there: String,
    },
}

fn failed(doing: impl Into<String>) -> impl FnOnce(Error) -> BringUpError {
    let doing = doing.into();
    move |reason| BringUpError::Bus { doing, reason }
}

fn unsuitable(device: &str, what: impl Into<String>) -> BringUpError {
    BringUpError::Unsuitable { device: device.to_owned(), what: what.into() }
}

/// Frames on an interface, and ethercrab on top of them.
pub(super) fn open(interface: &str, first_sync_frames: u32) -> Result<(Wire, MainDevice<'static>), BringUpError> {
    let socket = Socket::open(interface).map_err(|reason| BringUpError::Interface {
        interface: interface.to_owned(),
        remedy: match reason.raw_os_error() {
            Some(libc::EPERM | libc::EACCES) => {
                "raw frames need root, or `setcap cap_net_raw,cap_sys_nice,cap_ipc_lock+ep` on rt-loop and haptic-camera"
            }
            _ => "`ip link` lists those that there are",
        },
        reason,
    })?;
    let (tx, rx, pdu_loop) = FRAMES_OF_THIS_PROCESS.try_split().map_err(|()| BringUpError::Again)?;
    let timeouts = Timeouts {
        pdu: FRAME_TIMEOUT,
        eeprom: Duration::from_millis(500),
        wait_loop_delay: Duration::from_micros(200),
        state_transition: Duration::from_secs(10),
        ..Timeouts::default()
    };
    let config =
        MainDeviceConfig { dc_static_sync_iterations: first_sync_frames, retry_behaviour: RetryBehaviour::Count(3) };
    Ok((Wire { socket, tx, rx, frame: [0; LONGEST] }, MainDevice::new(pdu_loop, timeouts, config)))
}

/// Drives a future of the preparation, and gives up when told to stop.
pub(super) fn wait<T>(
    wire: &mut Wire,
    interface: &str,
    stop: &dyn Fn() -> bool,
    future: impl Future<Output = Result<T, BringUpError>>,
) -> Result<T, BringUpError> {
    let idle = || {
        std::thread::yield_now();
        if stop() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    match wire.drive(future, idle) {
        Ok(done) => done,
        Err(Unanswered::GaveUp) => Err(BringUpError::Stopped),
        Err(Unanswered::NotSent) => Err(BringUpError::Down(interface.to_owned())),
    }
}

/// Finds the devices and takes them to PRE-OP.
pub(super) async fn find(main_device: &MainDevice<'_>, interface: &str) -> Result<Group<PreOp, NoDc>, BringUpError> {
    let found = main_device.init_single_group::<MOST_DEVICES, MOST_BYTES>(monotonic_time_ns).await;
    let group = match found {
        Ok(group) if group.is_empty() => return Err(BringUpError::Silent(interface.to_owned())),
        Err(Error::Timeout(_)) if main_device.num_subdevices() == 0 => {
            return Err(BringUpError::Silent(interface.to_owned()));
        }
        found => found.map_err(failed("finding the devices"))?,
    };
    Ok(group)
}

/// A device in words.
pub(super) fn told(position: usize, device: &SubDevice) -> String {
    let identity = device.identity();
    format!(
        "{position} '{}' (vendor {:#x}, product {:#x}, alias {})",
        device.name(),
        identity.vendor_id,
        identity.product_id,
        device.alias_address()
    )
}

/// What a bus becomes.
pub(super) struct BroughtUp {
    pub(super) devices: Devices,
    pub(super) drive: DrivePlaces,
    pub(super) channels: Vec<ChannelPlace>,
    pub(super) expected: u16,
    /// The torque that a target of 1000 stands for, mNm.
    pub(super) rated_torque_mnm: f64,
    /// Longest time of a watchdog as read back, s.
    pub(super) watchdog_s: f64,
    /// What is worth keeping with a capture.
    pub(super) notes: Vec<(String, String)>,
}

/// What the bring-up needs besides the bus.
pub(super) struct Asked<'a> {
    pub(super) settings: &'a Settings,
    pub(super) sources: &'a [Source],
    pub(super) rate_hz: f64,
    pub(super) watchdog_s: f64,
}

/// Frames by which the clocks are first brought together, if they are.
pub(super) fn first_sync_frames(settings: &Settings) -> u32 {
    if settings.distributed_clocks { FIRST_SYNC_FRAMES } else { 0 }
}

/// A device that the file names, on the bus.
struct Named<'a> {
    name: &'a str,
    asked: &'a Device,
    index: usize,
    outputs: Vec<Entry>,
    inputs: Vec<Entry>,
}

/// Takes the devices to where they ask for process data: everything is set up, and OP is requested.
pub(super) async fn bring_up(main_device: &MainDevice<'static>, asked: &Asked<'_>) -> Result<BroughtUp, BringUpError> {
    let settings = asked.settings;
    let mut group = find(main_device, &settings.interface).await?;
    let mut named = choose(&group, main_device, settings)?;
    let mut notes = Vec::new();
    for device in &mut named {
        let reference = group.subdevice(main_device, device.index).map_err(failed("looking at a device"))?;
        notes.push((format!("device {}", device.name), told(device.index, &reference)));
        set_up(&reference, device).await?;
    }
    let drive =
        named.iter().find(|device| device.name == DRIVE).ok_or(BringUpError::Silent(settings.interface.clone()))?;
    let index = drive.index;
    let reference = group.subdevice(main_device, index).map_err(failed("looking at the drive"))?;
    let (rated_torque_mnm, counts_per_turn) = set_up_drive(&reference, asked).await?;
    notes.push(("rated torque".to_owned(), format!("{rated_torque_mnm} mNm")));
    notes.extend(counts_per_turn.map(|counts| ("encoder".to_owned(), format!("{counts} counts per turn"))));
    notes.push(("smallest torque".to_owned(), format!("{} mNm", rated_torque_mnm / 1e3)));
    let places = drive_places(drive)?;
    let scales = Scales { rated_torque_mnm, counts_per_turn };
    let channels =
        asked.sources.iter().map(|source| channel_place(source, &named, scales)).collect::<Result<_, _>>()?;
    if settings.distributed_clocks {
        let mut devices = group.iter_mut(main_device);
        if let Some(mut drive) = devices.nth(index) {
            if !drive.dc_support().any() {
                return Err(unsuitable(DRIVE, "has no distributed clock; set distributed_clocks = false"));
            }
            drive.set_dc_sync(DcSync::Sync0);
        }
    }
    let group = group.into_pre_op_pdi(main_device).await.map_err(failed("setting up process data"))?;
    let (expected, watchdog_s) = arm_watchdogs(&group, main_device, asked.watchdog_s).await?;
    notes.push(("working counter".to_owned(), expected.to_string()));
    let devices = if settings.distributed_clocks {
        let period = Duration::from_secs_f64(1.0 / asked.rate_hz);
        let clocks = DcConfiguration { start_delay: SYNC_BEGINS, sync0_period: period, sync0_shift: Duration::ZERO };
        let group = group.configure_dc_sync(main_device, clocks).await.map_err(failed("setting up the clocks"))?;
        let group = group.into_safe_op(main_device).await;
        let group = group.map_err(|reason| Refused { state: "SAFE-OP", reason })?;
        Devices::Clocked(group.request_into_op(main_device).await.map_err(|reason| Refused { state: "OP", reason })?)
    } else {
        let group = group.into_safe_op(main_device).await;
        let group = group.map_err(|reason| Refused { state: "SAFE-OP", reason })?;
        Devices::Free(group.request_into_op(main_device).await.map_err(|reason| Refused { state: "OP", reason })?)
    };
    Ok(BroughtUp { devices, drive: places, channels, expected, rated_torque_mnm, watchdog_s, notes })
}

/// A state that was refused; which device refused it is asked once ethercrab has let go of the group.
struct Refused {
    state: &'static str,
    reason: Error,
}

impl From<Refused> for BringUpError {
    fn from(refused: Refused) -> Self {
        let Refused { state, reason } = refused;
        Self::State { device: String::new(), state, reason: reason.to_string() }
    }
}

/// The device that stands in the way of a state, with its own reason, if one has any.
pub(super) async fn with_reason(main_device: &MainDevice<'static>, error: BringUpError) -> BringUpError {
    let BringUpError::State { device, state, reason } = error else { return error };
    for index in 0..main_device.num_subdevices() {
        let address = FIRST_ADDRESS + index as u16;
        let read = |register: RegisterAddress| ethercrab::Command::fprd(address, register.into()).ignore_wkc();
        let status = read(RegisterAddress::AlStatus).receive::<u16>(main_device).await.unwrap_or(0);
        let code = read(RegisterAddress::AlStatusCode).receive::<u16>(main_device).await.unwrap_or(0);
        if status & AL_ERROR != 0 && code != 0 {
            let reason = codes::al_status(codes::al_status_code(code), code);
            return BringUpError::State { device: format!("at position {index}"), state, reason };
        }
    }
    let device = if device.is_empty() { "of the bus".to_owned() } else { device };
    BringUpError::State { device, state, reason }
}

/// The address that ethercrab gives the first device; the others follow.
const FIRST_ADDRESS: u16 = 0x1000;
/// The error bit of the AL status.
const AL_ERROR: u16 = 0x10;

/// Finds the devices that the file names.
fn choose<'a>(
    group: &Group<PreOp, NoDc>,
    main_device: &MainDevice<'_>,
    settings: &'a Settings,
) -> Result<Vec<Named<'a>>, BringUpError> {
    let there: Vec<_> = group.iter(main_device).collect();
    let all = || there.iter().enumerate().map(|(at, device)| told(at, device)).collect::<Vec<_>>().join(", ");
    let asked = settings.terminals.iter().map(|(name, device)| (name.as_str(), device));
    let asked = std::iter::once((DRIVE, &settings.drive)).chain(asked);
    asked
        .map(|(name, asked)| {
            let is_it = |index: usize, device: &SubDevice| {
                asked.vendor.is_none_or(|vendor| vendor == device.identity().vendor_id)
                    && asked.product.is_none_or(|product| product == device.identity().product_id)
                    && asked.alias.is_none_or(|alias| alias == device.alias_address())
                    && asked.position.is_none_or(|position| position == index)
            };
            let mut found = there.iter().enumerate().filter(|(index, device)| is_it(*index, device));
            match (found.next(), found.count()) {
                (Some((index, _)), 0) => Ok(Named { name, asked, index, outputs: Vec::new(), inputs: Vec::new() }),
                (Some(_), others) => Err(BringUpError::Ambiguous {
                    name: name.to_owned(),
                    count: others + 1,
                    asked: asked.told(),
                    there: all(),
                }),
                (None, _) => Err(BringUpError::Missing { name: name.to_owned(), asked: asked.told(), there: all() }),
            }
        })
        .collect()
}

/// A device as it can be talked to before it has process data.
pub(super) type Reference<'a> = SubDeviceRef<'a, &'a SubDevice>;

/// Writes what the file has for a device, and reads which entries it then exchanges.
async fn set_up(reference: &Reference<'_>, device: &mut Named<'_>) -> Result<(), BringUpError> {
    let Named { name, asked, .. } = *device;
    for startup in &asked.startup {
        write(reference, name, startup).await?;
    }
    for (assignment, mapping, entries) in [(0x1c12, 0x1600, &asked.outputs), (0x1c13, 0x1a00, &asked.inputs)] {
        let Some(entries) = entries else { continue };
        let mut writes = vec![startup(assignment, 0, 8, 0), startup(mapping, 0, 8, 0)];
        for (place, entry) in entries.iter().enumerate() {
            writes.push(startup(mapping, place as u8 + 1, 32, i64::from(entry.word())));
        }
        writes.push(startup(mapping, 0, 8, entries.len() as i64));
        writes.push(startup(assignment, 1, 16, i64::from(mapping)));
        writes.push(startup(assignment, 0, 8, 1));
        for one in writes {
            write(reference, name, &one).await?;
        }
    }
    device.outputs = mapped(reference, 0x1c12).await.map_err(failed(format!("reading what '{name}' takes")))?;
    device.inputs = mapped(reference, 0x1c13).await.map_err(failed(format!("reading what '{name}' gives")))?;
    Ok(())
}

fn startup(index: u16, subindex: u8, bits: u8, value: i64) -> Startup {
    Startup { index, subindex, bits, value }
}

/// Writes a value to an object.
async fn write(reference: &Reference<'_>, name: &str, startup: &Startup) -> Result<(), BringUpError> {
    let Startup { index, subindex, bits, value } = *startup;
    let written = match bits {
        8 => reference.sdo_write(index, subindex, value as u8).await,
        16 => reference.sdo_write(index, subindex, value as u16).await,
        32 => reference.sdo_write(index, subindex, value as u32).await,
        _ => return Err(unsuitable(name, format!("cannot be written {bits} bits at once; give 8, 16 or 32"))),
    };
    written.map_err(|error| {
        let object = Object::new(index, subindex);
        unsuitable(name, format!("does not take {value:#x} ({bits} bits) for its object {object}: {error}"))
    })
}

/// The entries that a device exchanges, by its own objects (ETG.1000.6, 5.6.7.4); none where it has no such objects.
pub(super) async fn mapped(reference: &Reference<'_>, assignment: u16) -> Result<Vec<Entry>, Error> {
    let count = match reference.sdo_read::<u8>(assignment, 0).await {
        Ok(count) => count,
        Err(Error::Mailbox(_)) => return Ok(Vec::new()),
        Err(error) => return Err(error),
    };
    let mut entries = Vec::new();
    for at in 1..=count {
        let mapping = reference.sdo_read::<u16>(assignment, at).await?;
        for entry in 1..=reference.sdo_read::<u8>(mapping, 0).await? {
            entries.push(Entry::of_word(reference.sdo_read::<u32>(mapping, entry).await?));
        }
    }
    Ok(entries)
}

/// An object of 32 bits, where the device has it.
async fn read(reference: &Reference<'_>, object: Object) -> Option<u32> {
    reference.sdo_read::<u32>(object.index, object.subindex).await.ok()
}

/// Makes sure that the drive is one, sets its mode and period, and reads its scales: rated torque, mNm, and counts per turn.
async fn set_up_drive(reference: &Reference<'_>, asked: &Asked<'_>) -> Result<(f64, Option<f64>), BringUpError> {
    let settings = asked.settings;
    if let Some(kind) = read(reference, object::DEVICE_TYPE).await
        && kind & 0xffff != PROFILE
    {
        return Err(unsuitable(
            DRIVE,
            format!("is no CiA 402 drive: its device type is {kind:#010x}; choose another one"),
        ));
    }
    if let Some(modes) = read(reference, object::SUPPORTED_MODES).await
        && modes >> (CYCLIC_SYNCHRONOUS_TORQUE - 1) & 1 == 0
    {
        return Err(unsuitable(
            DRIVE,
            "offers no cyclic synchronous torque (bit 9 of 0x6502), by which it would be driven",
        ));
    }
    let mode = startup(object::MODE.index, 0, 8, i64::from(CYCLIC_SYNCHRONOUS_TORQUE));
    write(reference, DRIVE, &mode).await?;
    if let Some((units, exponent)) = interpolation_period(asked.rate_hz) {
        // Drives that have a fixed period do not have the object.
        let (time, power) = (object::INTERPOLATION_TIME, object::INTERPOLATION_EXPONENT);
        let _ = reference.sdo_write(time.index, time.subindex, units).await;
        let _ = reference.sdo_write(power.index, power.subindex, exponent).await;
    }
    let rated_torque_mnm = match settings.rated_torque_mnm {
        Some(rated_torque_mnm) => rated_torque_mnm,
        None => read(reference, object::RATED_TORQUE).await.map(f64::from).filter(|rated| *rated > 0.0).ok_or_else(
            || unsuitable(DRIVE, "does not tell its rated torque (0x6076); write rated_torque_mnm under [settings]"),
        )?,
    };
    let told = match (read(reference, object::ENCODER_INCREMENTS).await, read(reference, object::ENCODER_TURNS).await) {
        (Some(counts), Some(turns)) if counts > 0 && turns > 0 => Some(f64::from(counts) / f64::from(turns)),
        _ => None,
    };
    Ok((rated_torque_mnm, settings.counts_per_turn.or(told)))
}

/// Where the drive's words lie.
fn drive_places(drive: &Named<'_>) -> Result<DrivePlaces, BringUpError> {
    let must = |object: Object, entries: &[Entry], key: &str, bits: u8| {
        Place::of(object, entries).ok_or_else(|| {
            let there: Vec<String> = entries.iter().map(Entry::to_string).collect();
            let what = format!(
                "has no {object} among its {key}: {}; write `{key}` with \"{object}/{bits}\" under [settings.drive]",
                there.join(", ")
            );
            unsuitable(DRIVE, what)
        })
    };
    Ok(DrivePlaces {
        device: drive.index,
        controlword: must(object::CONTROLWORD, &drive.outputs, "outputs", 16)?,
        target_torque: must(object::TARGET_TORQUE, &drive.outputs, "outputs", 16)?,
        mode: Place::of(object::MODE, &drive.outputs),
        statusword: must(object::STATUSWORD, &drive.inputs, "inputs", 16)?,
        mode_display: Place::of(object::MODE_DISPLAY, &drive.inputs),
        error_code: Place::of(object::ERROR_CODE, &drive.inputs),
    })
}

#[derive(Clone, Copy)]
struct Scales {
    rated_torque_mnm: f64,
    counts_per_turn: Option<f64>,
}

/// Where a channel's value lies.
fn channel_place(source: &Source, named: &[Named<'_>], scales: Scales) -> Result<ChannelPlace, BringUpError> {
    let missing = |device: &str, there: String| BringUpError::NoInput {
        source_name: source.to_string(),
        device: device.to_owned(),
        there,
    };
    let device = named.iter().find(|device| device.name == source.device).ok_or_else(|| {
        missing(
            &source.device,
            format!("[settings] names {}", named.iter().map(|device| device.name).collect::<Vec<_>>().join(", ")),
        )
    })?;
    let rad_per_count = || {
        scales.counts_per_turn.map(|counts| std::f64::consts::TAU / counts).ok_or_else(|| {
            unsuitable(DRIVE, "does not tell its encoder's counts (0x608f); write counts_per_turn under [settings]")
        })
    };
    let (object, coding, factor) = match source.what {
        What::Position => (object::POSITION, Coding::Signed, rad_per_count()?),
        What::Velocity => (object::VELOCITY, Coding::Signed, rad_per_count()?),
        What::Torque => (object::TORQUE, Coding::Signed, scales.rated_torque_mnm / 1e3),
        What::Raw(object, coding) => (object, coding, 1.0),
    };
    let place = Place::of(object, &device.inputs).ok_or_else(|| {
        missing(device.name, device.inputs.iter().map(Entry::to_string).collect::<Vec<_>>().join(", "))
    })?;
    Ok(ChannelPlace { device: device.index, place, coding, factor })
}

/// Has every device that takes process data let go of its outputs when none come for `asked_s`, and reads that back (ETG.1000.4,
/// 6.3; ET1100 data sheet, 0x0400 and 0x0420). Gives the working counter of a cycle, and the longest time read back, s.
async fn arm_watchdogs(
    group: &Group<PreOpPdi, NoDc>,
    main_device: &MainDevice<'static>,
    asked_s: f64,
) -> Result<(u16, f64), BringUpError> {
    let (mut expected, mut longest_s) = (0, 0.0_f64);
    let count = (asked_s / (WATCHDOG_UNIT_S)).floor();
    for (index, device) in group.iter(main_device).enumerate() {
        let name = format!("{index} {}", device.name());
        let doing = || failed(format!("arming the watchdog of '{name}'"));
        expected += u16::from(!device.inputs_raw().is_empty());
        if device.outputs_raw().is_empty() {
            continue;
        }
        // A device adds one for reading and two for writing (ETG.1000.4, table 9).
        expected += 2;
        if !(1.0..=65_535.0).contains(&count) {
            return Err(unsuitable(&name, format!("cannot have a watchdog of {asked_s} s; give 0.0001 to 6.5 s")));
        }
        device.register_write(RegisterAddress::WatchdogDivider, WATCHDOG_DIVIDER).await.map_err(doing())?;
        device.register_write(RegisterAddress::SyncManagerWatchdog, count as u16).await.map_err(doing())?;
        let divider = device.register_read::<u16>(RegisterAddress::WatchdogDivider).await.map_err(doing())?;
        let ticks = device.register_read::<u16>(RegisterAddress::SyncManagerWatchdog).await.map_err(doing())?;
        let time_s = f64::from(ticks) * (f64::from(divider) + 2.0) * WATCHDOG_CLOCK_S;
        if time_s <= 0.0 || time_s > asked_s * 1.001 {
            let what = format!(
                "does not take a process-data watchdog of {asked_s} s (0x0400 and 0x0420 read back {divider:#06x} and {ticks}): its \
                 torque would stay when the program is killed; use another drive"
            );
            return Err(unsuitable(&name, what));
        }
        let mut is_watched = false;
        for manager in 0..SYNC_MANAGERS {
            let [.., control, _, activate, _] =
                device.register_read::<[u8; 8]>(FIRST_SYNC_MANAGER + 8 * manager).await.map_err(doing())?;
            let takes_outputs = activate & 1 == 1 && control & (BUFFERED_MASK | DIRECTION_MASK) == FROM_MAIN_DEVICE;
            is_watched |= takes_outputs && control & WATCHDOG_TRIGGER != 0;
        }
        if !is_watched {
            let what = "does not watch its outputs (bit 6 of its sync manager's control byte): its torque would stay when the program \
                        is killed; use another drive";
            return Err(unsuitable(&name, what));
        }
        longest_s = longest_s.max(time_s);
    }
    Ok((expected, longest_s))
}

/// 0x0400 for steps of 100 µs: the clock's ticks less two.
const WATCHDOG_DIVIDER: u16 = 2_498;
/// A step of the watchdog with it, s.
const WATCHDOG_UNIT_S: f64 = 1e-4;
/// A tick of the watchdog's clock of 25 MHz, s.
const WATCHDOG_CLOCK_S: f64 = 40e-9;
/// Sync managers, 8 bytes each: address, length, control, status, activate, PDI control (ET1100 data sheet, 0x0800).
const FIRST_SYNC_MANAGER: u16 = 0x0800;
const SYNC_MANAGERS: u16 = 4;
/// Of the control byte: buffered is 0, from the main device is 4, and the bit by which process data feed the watchdog.
const BUFFERED_MASK: u8 = 0x03;
const DIRECTION_MASK: u8 = 0x0c;
const FROM_MAIN_DEVICE: u8 = 0x04;
const WATCHDOG_TRIGGER: u8 = 0x40;

/// Takes a bus to where OP is asked for, which the devices reach once process data come.
pub(super) fn start(asked: &Asked<'_>, stop: &dyn Fn() -> bool) -> Result<(Bus, BroughtUpRest), BringUpError> {
    let interface = &asked.settings.interface;
    let (mut wire, main_device) = open(interface, first_sync_frames(asked.settings))?;
    let brought = wait(&mut wire, interface, stop, bring_up(&main_device, asked));
    let brought = match brought {
        Err(error @ BringUpError::State { .. }) => {
            let named = wait(&mut wire, interface, stop, async { Ok(with_reason(&main_device, error).await) })?;
            return Err(named);
        }
        other => other?,
    };
    let BroughtUp { devices, drive, channels, expected, rated_torque_mnm, watchdog_s, notes } = brought;
    let bus = Bus { wire, main_device, devices, drive, channels, expected, mode: CYCLIC_SYNCHRONOUS_TORQUE };
    Ok((bus, BroughtUpRest { rated_torque_mnm, watchdog_s, notes }))
}

/// What is left when the bus runs.
pub(super) struct BroughtUpRest {
    pub(super) rated_torque_mnm: f64,
    pub(super) watchdog_s: f64,
    pub(super) notes: Vec<(String, String)>,
}
