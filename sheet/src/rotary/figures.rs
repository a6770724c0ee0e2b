//! The figures of turned controls, as they are defined.

use crate::figure::{FigureKind, OURS, define_figures};

const ENCODERS: &str = "encoder makers' data sheets, which give detents, their angle and their torque with tolerances";
const MECHANICS: &str = "mechanics";

define_figures! {
    DETENT_COUNT "detent_count" "" ENCODERS "Detents in a turn: a full turn over the mean pitch."
    DETENT_PITCH "detent_pitch" "rad" ENCODERS
        "Angle from one rest to the next in the direction of turning; a rest is where the branch rises through its mean, against \
         which turning on gets harder."
    PEAK_TORQUE "peak_torque" "mNm" ENCODERS "Largest torque against the turning from one rest to the next."
    TROUGH_TORQUE "trough_torque" "mNm" ENCODERS
        "Least torque against the turning from one rest to the next; negative where the detent pulls on."
    TORQUE_RATIO "torque_ratio" "share" ENCODERS "Peak torque less trough torque, over the peak torque."
    DETENT_STIFFNESS "detent_stiffness" "mNm/rad" MECHANICS "Slope of the branch at the rest."
    DETENT_ENERGY "detent_energy" "mJ" MECHANICS
        "Work against the detent from the rest to where its torque turns, without the running friction."
    RUNNING_FRICTION "running_friction" "mNm" MECHANICS
        "Half the mean distance of the two branches over the angle that both have, at the speed of the turn."
    HYSTERESIS_ENERGY "hysteresis_energy" "mJ" MECHANICS "Area between the two branches over one turn."
    DETENT_SHIFT "detent_shift" "rad" OURS
        "Mean distance of a detent's rest turning positively from that turning negatively."
    BACKLASH "backlash" "rad" OURS "Longest way in which the control turns evenly without torque, up to where it meets some."
    UNIFORMITY_PITCH "uniformity_pitch" "share" ENCODERS "Largest departure of a pitch from the mean pitch, over the mean pitch."
    UNIFORMITY_PEAK "uniformity_peak" "share" ENCODERS "Largest departure of a peak from the mean peak, over the mean peak."
    END_STOP_LOW "end_stop_low" "rad" OURS
        "Angle below which the torque against turning further is twice the largest of the middle three fifths of the travel."
    END_STOP_HIGH "end_stop_high" "rad" OURS
        "Angle above which the torque against turning further is twice the largest of the middle three fifths of the travel."
}
