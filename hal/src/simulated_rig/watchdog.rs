//! The amplifier's switch and its watchdog.

/// The amplifier as its user sees it: on or off, the command it holds, and whether it gave up.
///
/// It counts substeps of plant time since the last command. Counting begins at the first reading
/// after it was switched on, since nobody could have written before.
#[derive(Debug)]
pub(super) struct Watchdog {
    limit: u64,
    state: State,
    /// Times it ran out.
    trips: u64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum State {
    Off,
    /// Switched on, not read yet.
    Fresh,
    On {
        command_mnm: f64,
        /// Substeps since the last command.
        age: u64,
    },
    Expired,
}

impl Watchdog {
    pub(super) fn new(limit: u64) -> Self {
        Self { limit, state: State::Off, trips: 0 }
    }

    pub(super) fn switch_on(&mut self) {
        self.state = State::Fresh;
    }

    pub(super) fn switch_off(&mut self) {
        // A caller made torque-free by the watchdog must still learn that it expired.
        if self.state != State::Expired {
            self.state = State::Off;
        }
    }

    pub(super) fn ran_out(&self) -> bool {
        self.state == State::Expired
    }

    pub(super) fn trips(&self) -> u64 {
        self.trips
    }

    /// Takes a command; without effect unless the amplifier is on.
    pub(super) fn command(&mut self, torque_mnm: f64) {
        if matches!(self.state, State::Fresh | State::On { .. }) {
            self.state = State::On { command_mnm: torque_mnm, age: 0 };
        }
    }

    /// Notes that a reading took place.
    pub(super) fn noticed(&mut self) {
        if self.state == State::Fresh {
            self.state = State::On { command_mnm: 0.0, age: 0 };
        }
    }

    /// The torque asked for in the next substep, mNm; none when the amplifier is off or gave up.
    pub(super) fn torque_mnm(&self) -> Option<f64> {
        match self.state {
            State::On { command_mnm, .. } => Some(command_mnm),
            State::Fresh | State::Off | State::Expired => None,
        }
    }

    /// Lets substeps pass.
    pub(super) fn pass(&mut self, substeps: u64) {
        if let State::On { age, .. } = &mut self.state {
            *age += substeps;
            if *age > self.limit {
                self.state = State::Expired;
                self.trips += 1;
            }
        }
    }
}
