//! The guard: counts the energy that the loop gives out beyond the model's own, and takes it back.

use std::collections::VecDeque;

/// Observer and controller of B. Hannaford and J.-H. Ryu, *Time-domain passivity control of haptic interfaces*, IEEE
/// Trans. Robotics and Automation 18, 2002.
///
/// A command is constant over a tick, so that torque times the way gone meanwhile is exact (J.-H. Ryu, Y. S. Kim
/// and B. Hannaford, *Sampled- and continuous-time passivity and stability of virtual environments*, IEEE Trans. Robotics
/// 20, 2004). The energy that the model itself keeps or gives is subtracted from the rotor's input: the virtual knob's kinetic
/// energy, the energy stored in a contact or shaft in it, and the work of its detents and springs. The rest should be dissipated;
/// where it becomes negative the loop made energy, and the rotor is damped until that energy is gone.
#[derive(Clone, Debug)]
pub(super) struct PassivityObserver {
    /// Energy put in that was neither kept by the model nor given out again, mNm·rad.
    balance: f64,
    /// Torques commanded to feel like the model, mNm, that still are to act on a way which is read; the oldest first.
    under_way_mnm: VecDeque<f64>,
    /// Energy that the virtual knob keeps beyond the rotor's kinetic one, mNm·rad.
    kept: f64,
    slack: f64,
    most_damping: f64,
}

/// What a tick did.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tick {
    /// Torque commanded to feel like the model, the compensation of the rig's friction apart, mNm.
    pub(super) rendered_mnm: f64,
    /// Energy that the virtual knob keeps at its end beyond the rotor's kinetic one, mNm·rad: in motion and in a contact.
    pub(super) kept: f64,
    /// Work of the virtual body against detents and springs, mNm·rad.
    pub(super) work: f64,
}

impl PassivityObserver {
    /// An observer that permits `slack`, mNm·rad, to come out and damps with at most `most_damping`, mNm·s/rad, where a torque acts
    /// on the way that is read so many ticks after the next reading.
    pub(super) fn new(slack: f64, most_damping: f64, late_ticks: f64) -> Self {
        let under_way_mnm = VecDeque::from(vec![0.0; late_ticks.round() as usize + 1]);
        Self { balance: 0.0, under_way_mnm, kept: 0.0, slack, most_damping }
    }

    /// Torque on the rotor that takes back the excess energy, mNm, after the rotor moved by `way_rad`.
    pub(super) fn correction_mnm(&mut self, way_rad: f64, step_s: f64) -> f64 {
        // The balance has an upper limit, so that energy dissipated long ago cannot offset energy that comes out now.
        let acted_mnm = self.under_way_mnm.pop_front().unwrap_or_default();
        self.balance = (self.balance - acted_mnm * way_rad).min(self.slack);
        let missing = -(self.balance + self.slack);
        if missing <= 0.0 || way_rad == 0.0 {
            return 0.0;
        }
        let damping = (missing * step_s / (way_rad * way_rad)).min(self.most_damping);
        -damping * way_rad / step_s
    }

    /// Notes the tick that lasts until the next reading.
    pub(super) fn note(&mut self, tick: &Tick) {
        self.balance -= tick.work + tick.kept - self.kept;
        self.kept = tick.kept;
        self.under_way_mnm.push_back(tick.rendered_mnm);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_torque_is_counted_over_the_way_on_which_it_acts() {
        // A torque that turns round in every tick, acts a tick late and always against the way: it takes energy, and gives none.
        let command_mnm = |tick: i32| if tick % 2 == 0 { 1.0 } else { -1.0 };
        let guarded = |late_ticks: f64| {
            let mut observer = PassivityObserver::new(0.1, 10.0, late_ticks);
            let corrects = |tick: &i32| {
                let correction_mnm = observer.correction_mnm(-0.5 * command_mnm(tick - 2), 1e-3);
                observer.note(&Tick { rendered_mnm: command_mnm(*tick), kept: 0.0, work: 0.0 });
                correction_mnm != 0.0
            };
            (2..12).filter(corrects).count()
        };
        assert_eq!(guarded(1.0), 0);
        assert!(guarded(0.0) > 5, "counted where it does not act, it would seem to give energy");
    }
}
