//! What can go wrong in a run, as a number, and what each number means.
//!
//! A drive's own codes are those of 0x603F, up to 0xFFFF. AL status codes follow, then this driver's own.

use ethercrab::AlStatusCode;

/// Before an AL status code.
const AL_STATUS: i32 = 0x1_0000;
/// Before this driver's own.
const OWN: i32 = 0x2_0000;

/// Too many frames in a row did not come back.
pub(super) const LOST: i32 = OWN + 1;
/// Too many frames in a row came back with a wrong working counter.
pub(super) const WORKING_COUNTER: i32 = OWN + 2;
/// The drive has a fault and no code for it among its process data.
pub(super) const UNTOLD_FAULT: i32 = OWN + 3;
/// The drive left its state "operation enabled" without a fault.
pub(super) const NOT_ENABLED: i32 = OWN + 4;
/// A device left OP and gives no reason.
pub(super) const NOT_OPERATIONAL: i32 = OWN + 5;
/// The interface takes no frames.
pub(super) const NOT_SENT: i32 = OWN + 6;
/// The bus could not be brought up; the reason is given in words.
pub(super) const BRING_UP: i32 = OWN + 7;
/// The drive did not come on.
pub(super) const NOT_SWITCHED_ON: i32 = OWN + 8;
/// The drive left cyclic synchronous torque for another mode of operation.
pub(super) const OTHER_MODE: i32 = OWN + 9;

/// The code for a device that left OP.
pub(super) fn of_al_status(code: u16) -> i32 {
    if code == 0 { NOT_OPERATIONAL } else { AL_STATUS + i32::from(code) }
}

/// The code for a drive's fault.
pub(super) fn of_drive(code: u16) -> i32 {
    if code == 0 { UNTOLD_FAULT } else { i32::from(code) }
}

/// An AL status code in words (ETG.1000.6, table 11).
pub(super) fn al_status(code: AlStatusCode, number: u16) -> String {
    match code {
        AlStatusCode::SyncManagerWatchdog => {
            "AL status code 0x001b: no process data came within the watchdog's time, and the device took the torque away".to_owned()
        }
        AlStatusCode::Unknown(_) => format!("AL status code {number:#06x}, which the standard does not have"),
        known => format!("AL status code {number:#06x}: {known}"),
    }
}

/// All codes with their meanings.
pub(super) fn all() -> Vec<(i32, String)> {
    let own = [
        (LOST, "frames no longer come back from the bus; check the cable and the devices' supply"),
        (
            WORKING_COUNTER,
            "a device no longer takes part in the exchange (wrong working counter); check its cable and supply",
        ),
        (UNTOLD_FAULT, "the drive reports a fault; add 0x603f:00/16 to its inputs to see its code"),
        (NOT_ENABLED, "the drive switched itself off; check its safe-torque-off input and its supply"),
        (NOT_OPERATIONAL, "a device left OP without giving a reason; check its supply"),
        (NOT_SENT, "the network interface takes no frames; check that it is up and its cable is in"),
        (
            OTHER_MODE,
            "the drive left cyclic synchronous torque for another mode of operation; check that nothing else commands it",
        ),
        (NOT_SWITCHED_ON, "the drive does not switch on; check its power stage's supply and its safe-torque-off input"),
    ];
    let own = own.into_iter().map(|(code, meaning)| (code, meaning.to_owned()));
    let of_al = (1..=0xff_u16).filter_map(|number| match al_status_code(number) {
        AlStatusCode::Unknown(_) => None,
        code => Some((of_al_status(number), al_status(code, number))),
    });
    let of_drive =
        DRIVE.iter().map(|(code, meaning)| (i32::from(*code), format!("drive error {code:#06x}: {meaning}")));
    own.chain(of_al).chain(of_drive).collect()
}

/// The code of a number.
pub(super) fn al_status_code(number: u16) -> AlStatusCode {
    use ethercrab::EtherCrabWireRead as _;
    AlStatusCode::unpack_from_slice(&number.to_le_bytes()).unwrap_or(AlStatusCode::Unknown(number))
}

/// Error codes in 0x603F (IEC 61800-7-201, annex); those from 0xFF00 on are a manufacturer's own.
const DRIVE: [(u16, &str); 61] = [
    (0x1000, "generic error"),
    (0x2110, "short circuit or earth leakage at the input"),
    (0x2120, "earth leakage at the input"),
    (0x2130, "short circuit at the input"),
    (0x2211, "current inside the device too high"),
    (0x2212, "current inside the device too high"),
    (0x2214, "current inside the device too high"),
    (0x2220, "continuous over current inside the device"),
    (0x2230, "short circuit or earth leakage inside the device"),
    (0x2240, "earth leakage inside the device"),
    (0x2250, "short circuit inside the device"),
    (0x2310, "continuous over current at the output"),
    (0x2320, "short circuit or earth leakage at the motor"),
    (0x2330, "earth leakage at the motor"),
    (0x2340, "short circuit at the motor"),
    (0x2350, "motor overloaded thermally (i2t)"),
    (0x3110, "mains over voltage"),
    (0x3120, "mains under voltage"),
    (0x3130, "phase failure of the mains"),
    (0x3210, "over voltage of the DC link"),
    (0x3220, "under voltage of the DC link"),
    (0x3230, "load error"),
    (0x3310, "output over voltage"),
    (0x3320, "armature circuit"),
    (0x3330, "field circuit"),
    (0x4110, "ambient temperature too high"),
    (0x4120, "ambient temperature too low"),
    (0x4210, "device too hot"),
    (0x4220, "device too cold"),
    (0x4310, "drive too hot"),
    (0x4320, "drive too cold"),
    (0x5110, "supply of the device's electronics"),
    (0x5112, "24 V supply"),
    (0x5210, "measuring circuit of the device"),
    (0x5400, "power section"),
    (0x5430, "input stages"),
    (0x5440, "contactor"),
    (0x5530, "parameter memory"),
    (0x6010, "software reset (watchdog)"),
    (0x6100, "internal software"),
    (0x6320, "parameter error"),
    (0x7110, "brake chopper"),
    (0x7121, "motor blocked"),
    (0x7122, "motor error or wrong commutation"),
    (0x7123, "motor tilted"),
    (0x7300, "sensor"),
    (0x7303, "resolver"),
    (0x7305, "incremental encoder"),
    (0x7306, "incremental encoder 2"),
    (0x7310, "speed"),
    (0x7320, "position"),
    (0x7500, "communication"),
    (0x8100, "communication"),
    (0x8110, "process data overrun"),
    (0x8130, "heartbeat"),
    (0x8180, "fieldbus watchdog"),
    (0x8311, "excess torque"),
    (0x8400, "velocity controller"),
    (0x8611, "following error"),
    (0x8700, "synchronisation"),
    (0x9000, "external error"),
];

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may stop at a failure")]
mod tests {
    use super::*;

    #[test]
    fn every_code_has_words_and_none_twice() {
        let all = all();
        let meaning = |code| all.iter().find(|(known, _)| *known == code).map(|(_, meaning)| meaning.as_str()).unwrap();
        assert!(meaning(of_al_status(0x1b)).contains("0x001b") && meaning(of_al_status(0x1b)).contains("watchdog"));
        assert_eq!(meaning(of_drive(0x2310)), "drive error 0x2310: continuous over current at the output");
        let of_maker = crate::ApparatusError::Device(of_drive(0xff01)).reason(&all);
        assert!(of_maker.contains("code 65281 (0xff01), which nothing here explains"), "{of_maker}");
        assert_eq!((of_drive(0), of_al_status(0)), (UNTOLD_FAULT, NOT_OPERATIONAL));
        let codes: std::collections::BTreeSet<i32> = all.iter().map(|(code, _)| *code).collect();
        assert_eq!(codes.len(), all.len());
    }
}
