//! From what a device reads to angle, torque and acceleration: sources, scales, signs, offsets and delays.

use serde::Deserialize;

use crate::{Measurement, TorqueSource};

/// The torque's source where nothing measures it.
const COMMAND: &str = "command";

/// Most channels of a device.
pub const MOST_CHANNELS: usize = 16;

/// The channels of a rig.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Channels {
    /// The encoder, rad.
    pub angle: Channel,
    /// The torque, mNm.
    pub torque: TorqueChannel,
    /// The accelerometer, rad/s²; a rig may have none.
    pub acceleration: Option<Channel>,
    /// The contact in what is turned or pressed; a rig may watch none.
    pub contact: Option<ContactChannel>,
    /// The motor: its torque is scale · sign · what the device is given, plus the offset.
    pub motor: Scaling,
}

/// One channel of the device, and how its values are turned into a quantity: scale · sign · value + offset.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Channel {
    /// The channel's name, as the device has it.
    pub source: String,
    /// Quantity per unit of the device.
    #[serde(default = "one")]
    pub scale: f64,
    /// 1, or -1 for a channel that counts the other way.
    #[serde(default = "plus")]
    pub sign: i8,
    /// Quantity at which the device reads zero.
    #[serde(default)]
    pub offset: f64,
    /// Time by which the channel is late, s.
    #[serde(default)]
    pub delay_s: f64,
    /// What an encoder counts until it begins anew, in units of the device: 4096 for one of 12 bits that counts within one turn.
    #[serde(default)]
    pub wraps_at: Option<f64>,
}

/// The torque's channel.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TorqueChannel {
    /// The channel's name, as the device has it; `command` for the torque that was commanded, where nothing is measured.
    pub source: String,
    /// Whether it is the motor's torque, from its current, and no torque sensor's.
    #[serde(default)]
    pub of_motor: bool,
    /// mNm per unit of the device.
    #[serde(default = "one")]
    pub scale: f64,
    /// 1, or -1 for a channel that counts the other way.
    #[serde(default = "plus")]
    pub sign: i8,
    /// Torque at which the device reads zero, mNm.
    #[serde(default)]
    pub offset: f64,
    /// Time by which the channel is late, s.
    #[serde(default)]
    pub delay_s: f64,
}

/// A digital input or a voltage that tells whether a contact is closed.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ContactChannel {
    /// The channel's name, as the device has it.
    pub source: String,
    /// Value of the device above which the contact is closed.
    #[serde(default = "half")]
    pub threshold: f64,
    /// 1, or -1 for a contact that is closed below the threshold, as behind a pull-up resistor.
    #[serde(default = "plus")]
    pub sign: i8,
}

/// How a quantity is turned into what the device takes.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scaling {
    /// Quantity per unit of the device.
    #[serde(default = "one")]
    pub scale: f64,
    /// 1, or -1 for a motor that turns the other way.
    #[serde(default = "plus")]
    pub sign: i8,
    /// Quantity at which the device is given zero.
    #[serde(default)]
    pub offset: f64,
}

fn one() -> f64 {
    1.0
}

fn half() -> f64 {
    0.5
}

fn plus() -> i8 {
    1
}

/// Why channels cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ChannelError {
    /// A number that no channel can have.
    #[error("[channels.{channel}] {key} is {value}, but it must be {requirement}")]
    OutOfRange {
        /// The channel.
        channel: &'static str,
        /// The key.
        key: &'static str,
        /// Its value.
        value: f64,
        /// What it must be.
        requirement: &'static str,
    },
    /// A channel that the device does not have.
    #[error("[channels.{channel}] source is '{asked}', but the device has {known}")]
    Unknown {
        /// The channel.
        channel: &'static str,
        /// The name asked for.
        asked: String,
        /// Those that there are.
        known: String,
    },
}

/// By how much a stated delay may differ from half a period and still be taken for it.
const ALIKE_SHARE: f64 = 0.25;

/// What a device read at a tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RawMeasurement {
    /// Values in the device's units, by channel.
    pub values: [f64; MOST_CHANNELS],
    /// Bit i: channel i has a new value.
    pub valid: u32,
    /// How long after the tick was due they were taken, s.
    pub after_s: f64,
}

/// The channels of a rig, found among those of its device.
#[derive(Clone, Debug)]
pub struct Wiring {
    angle: Wire,
    /// `None` for the torque that was commanded.
    torque: Option<Wire>,
    acceleration: Option<Wire>,
    /// The contact is closed where this is above zero.
    contact: Option<Wire>,
    motor: Scaling,
    /// What the angle's channel counts until it begins anew, in units of the device.
    angle_wraps_at: Option<f64>,
    /// The newest values of the device's channels, the angle's without its jumps.
    newest: [f64; MOST_CHANNELS],
    /// Delay of the angle, s.
    pub angle_delay_s: f64,
    /// Part of the torque's delay that the driver adds by itself, s.
    pub known_delay_s: f64,
    /// Delay of the torque behind the angle, s.
    pub torque_delay_s: f64,
    /// Delay of the acceleration behind the angle, s.
    pub acceleration_delay_s: f64,
    /// Where the torque comes from.
    pub torque_source: TorqueSource,
}

#[derive(Clone, Copy, Debug)]
struct Wire {
    index: usize,
    factor: f64,
    offset: f64,
}

impl Wire {
    fn of(self, values: &[f64; MOST_CHANNELS]) -> f64 {
        self.factor * values[self.index] + self.offset
    }

    fn is_valid(self, raw: &RawMeasurement) -> bool {
        raw.valid & (1 << self.index) != 0
    }
}

impl Channels {
    /// Checks every number.
    ///
    /// # Errors
    /// [`ChannelError::OutOfRange`].
    pub fn check(&self) -> Result<(), ChannelError> {
        let Self { angle, torque, acceleration, contact, motor } = self;
        let of_torque = Channel {
            source: String::new(),
            scale: torque.scale,
            sign: torque.sign,
            offset: torque.offset,
            delay_s: torque.delay_s,
            wraps_at: None,
        };
        let of_motor =
            Channel { delay_s: 0.0, scale: motor.scale, sign: motor.sign, offset: motor.offset, ..of_torque.clone() };
        let checked = |channel, key, value, permitted, requirement| match permitted {
            true => Ok(()),
            false => Err(ChannelError::OutOfRange { channel, key, value, requirement }),
        };
        if let Some(ContactChannel { threshold, sign, source: _ }) = contact {
            checked("contact", "threshold", *threshold, threshold.is_finite(), "finite")?;
            checked("contact", "sign", f64::from(*sign), sign.abs() == 1, "1 or -1")?;
        }
        let channels = [("angle", Some(angle)), ("torque", Some(&of_torque)), ("acceleration", acceleration.as_ref())];
        for (channel, found) in channels.into_iter().chain([("motor", Some(&of_motor))]) {
            let Some(Channel { scale, sign, offset, delay_s, wraps_at, source: _ }) = found else { continue };
            let check = |key, value, permitted, requirement| checked(channel, key, value, permitted, requirement);
            check("scale", *scale, scale.is_finite() && *scale > 0.0, "above zero, and finite; `sign` turns it round")?;
            check("sign", f64::from(*sign), sign.abs() == 1, "1 or -1")?;
            check("offset", *offset, offset.is_finite(), "finite")?;
            check("delay_s", *delay_s, delay_s.abs() < 0.1, "less than 0.1 s either way")?;
            if let Some(wraps_at) = *wraps_at {
                let is_count = channel == "angle" && wraps_at > 0.0 && wraps_at.is_finite();
                check("wraps_at", wraps_at, is_count, "above zero, and finite; only an angle begins anew")?;
            }
        }
        Ok(())
    }

    /// The names of the channels that are read.
    pub fn sources(&self) -> impl Iterator<Item = &String> {
        let torque = (self.torque.source != COMMAND).then_some(&self.torque.source);
        let acceleration = self.acceleration.as_ref().map(|channel| &channel.source);
        let contact = self.contact.as_ref().map(|channel| &channel.source);
        std::iter::once(&self.angle.source).chain(torque).chain(acceleration).chain(contact)
    }

    /// Finds the channels among those of a device, by name.
    ///
    /// # Errors
    /// [`ChannelError::Unknown`] with those that there are.
    pub fn wire(&self, names: &[String]) -> Result<Wiring, ChannelError> {
        let find = |channel: &'static str, source: &str, factor: f64, offset: f64| {
            let index = names.iter().take(MOST_CHANNELS).position(|name| name == source);
            index.map(|index| Wire { index, factor, offset }).ok_or_else(|| ChannelError::Unknown {
                channel,
                asked: source.to_owned(),
                known: names.join(", "),
            })
        };
        let of =
            |channel, given: &Channel| find(channel, &given.source, given.scale * f64::from(given.sign), given.offset);
        let Self { angle, torque, acceleration, contact, motor } = self;
        let of_contact = |given: &ContactChannel| {
            let sign = f64::from(given.sign);
            find("contact", &given.source, sign, -sign * given.threshold)
        };
        let is_commanded = torque.source == COMMAND;
        let torque_wire = match is_commanded {
            true => None,
            false => Some(find("torque", &torque.source, torque.scale * f64::from(torque.sign), torque.offset)?),
        };
        Ok(Wiring {
            angle: of("angle", angle)?,
            torque: torque_wire,
            acceleration: acceleration.as_ref().map(|given| of("acceleration", given)).transpose()?,
            contact: contact.as_ref().map(of_contact).transpose()?,
            motor: *motor,
            angle_wraps_at: angle.wraps_at,
            newest: [0.0; MOST_CHANNELS],
            angle_delay_s: angle.delay_s,
            known_delay_s: 0.0,
            torque_delay_s: torque.delay_s - angle.delay_s,
            acceleration_delay_s: acceleration.as_ref().map_or(0.0, |given| given.delay_s - angle.delay_s),
            torque_source: if torque.of_motor || is_commanded { TorqueSource::Motor } else { TorqueSource::Sensor },
        })
    }
}

impl Wiring {
    /// What the encoder counts until it begins anew, rad; `None` for one that does not.
    #[must_use]
    pub fn angle_count_rad(&self) -> Option<f64> {
        self.angle_wraps_at.map(|count| (count * self.angle.factor).abs())
    }

    /// Whether a contact is watched.
    #[must_use]
    pub const fn has_contact(&self) -> bool {
        self.contact.is_some()
    }

    /// Converts a device's reading to a measurement; `torque_mnm` is the motor's torque since the reading before. A channel without a new
    /// value keeps the one before; a measurement whose angle or torque has no new value is stale. A new reading of an
    /// angle that begins anew is taken within half of its count of the reading before, the first one within half of it of zero.
    pub fn measurement(&mut self, raw: &RawMeasurement, torque_mnm: f64) -> Measurement {
        let is_new = self.angle.is_valid(raw) && self.torque.is_none_or(|wire| wire.is_valid(raw));
        let mut values = raw.values;
        if let Some(count) = self.angle_wraps_at {
            let before = self.newest[self.angle.index];
            values[self.angle.index] += count * ((before - values[self.angle.index]) / count).round();
        }
        let values = self.newest.iter_mut().zip(values).enumerate();
        values.filter(|(index, _)| raw.valid & (1 << index) != 0).for_each(|(_, (newest, value))| *newest = value);
        Measurement {
            angle_rad: self.angle.of(&self.newest),
            acceleration_rad_s2: self.acceleration.map(|wire| wire.of(&self.newest)),
            torque_mnm: self.torque.map_or(torque_mnm, |wire| wire.of(&self.newest)),
            contact: self.contact.map(|wire| wire.of(&self.newest) > 0.0),
            after_s: raw.after_s - self.angle_delay_s,
            is_stale: !is_new,
            stale_code: 0,
        }
    }

    /// The wiring for a run at this rate: the command, where it is the torque's source, is half a period old on average.
    #[must_use]
    pub fn at_rate(mut self, rate_hz: f64) -> Self {
        if self.torque.is_none() {
            self.known_delay_s = 0.5 / rate_hz;
            self.torque_delay_s += self.known_delay_s;
        }
        self
    }

    /// The wiring for a device that holds a torque from one exchange to the next and is read just before the torque changes. The
    /// torque, measured by current or by a sensor, and the acceleration are then half a period old on average.
    #[must_use]
    pub fn held_between_exchanges(mut self, rate_hz: f64) -> Self {
        self.known_delay_s = 0.5 / rate_hz;
        self.torque_delay_s += self.known_delay_s;
        self.acceleration_delay_s += self.known_delay_s;
        self
    }

    /// A warning if the torque's stated delay looks like the half period that the driver takes off by itself; `None` otherwise.
    #[must_use]
    pub fn doubled_delay(&self) -> Option<String> {
        let stated_s = self.torque_delay_s - self.known_delay_s;
        let share = stated_s / self.known_delay_s;
        (self.known_delay_s > 0.0 && (share - 1.0).abs() < ALIKE_SHARE).then(|| {
            format!(
                "[channels.torque] delay_s states {stated_s} s, and the driver takes off half a period, {} s, by itself: if the one is the \
                 other, leave delay_s out; it is for what sensor and amplifier add",
                self.known_delay_s
            )
        })
    }

    /// What the device is given so that the motor makes a torque, mNm.
    #[must_use]
    pub fn of_motor(&self, torque_mnm: f64) -> f64 {
        (torque_mnm - self.motor.offset) / (self.motor.scale * f64::from(self.motor.sign))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "a test may stop at a failure")]
    use super::{Channels, MOST_CHANNELS, RawMeasurement};

    #[test]
    fn a_delay_that_repeats_the_half_period_that_the_driver_subtracts_is_reported() {
        let doubled = |delay_s: f64| {
            let text = format!("[angle]\nsource = \"a\"\n[torque]\nsource = \"t\"\ndelay_s = {delay_s}\n[motor]\n");
            let channels: Channels = toml::from_str(&text).unwrap();
            let wiring = channels.wire(&["a".to_owned(), "t".to_owned()]).unwrap();
            assert_eq!(wiring.doubled_delay(), None, "a driver that takes nothing off");
            wiring.held_between_exchanges(1_000.0).doubled_delay()
        };
        assert!(doubled(5e-4).unwrap().contains("states 0.0005 s"));
        assert_eq!([0.0, 5e-5, -3e-4].map(doubled), [None, None, None]);
    }

    #[test]
    fn an_encoder_that_begins_anew_goes_on() {
        let text = "[angle]\nsource = \"a\"\nscale = 0.5\nwraps_at = 4096\n[torque]\nsource = \"command\"\n[motor]\n";
        let channels: Channels = toml::from_str(text).unwrap();
        channels.check().unwrap();
        let mut wiring = channels.wire(&["a".to_owned()]).unwrap();
        // Three turns up and back; a reading without a new value in between.
        let way = (0..200).chain((0..200).rev()).map(|tick| 64.0 * f64::from(tick) + 100.0);
        for (tick, counts) in way.enumerate() {
            let mut values = [0.0; MOST_CHANNELS];
            let is_new = tick % 7 != 3;
            values[0] = if is_new { counts % 4096.0 } else { 0.0 };
            let measured = wiring.measurement(&RawMeasurement { values, valid: u32::from(is_new), after_s: 0.0 }, 0.0);
            assert_eq!(measured.is_stale, !is_new);
            assert!(measured.is_stale || (measured.angle_rad - 0.5 * counts).abs() < 1e-9, "tick {tick}");
        }
        let elsewhere = text.replace("[torque]", "[acceleration]\nsource = \"b\"\nwraps_at = 10\n[torque]");
        let channels: Channels = toml::from_str(&elsewhere).unwrap();
        assert!(channels.check().unwrap_err().to_string().contains("only an angle"));
    }
}
