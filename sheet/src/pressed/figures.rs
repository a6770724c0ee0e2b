//! The figures of pressed controls, as they are defined.

use crate::figure::{FigureKind, OURS, define_figures};

const DOME_LAB: &str = "Dome Lab (github BuddyOG/topre-force-curves)";
const EIA_448: &str = "EIA-448-1, method 15 (test for contact bounce)";
const SWITCH_MAKERS: &str = "C&K and other switch makers' data sheets";

define_figures! {
    COLLAPSE_FORCE "collapse_force" "N" DOME_LAB
        "Force at the most prominent local maximum (over ±5 rows of 5 µm, smoothed over 7) in the first 75 % of the press, if it lies more \
         than 2 gf above the lowest force within 1.6 mm after it."
    COLLAPSE_TRAVEL "collapse_travel" "mm" DOME_LAB "Travel at the collapse."
    VALLEY_FORCE "valley_force" "N" DOME_LAB "Lowest smoothed force within 1.6 mm after the collapse."
    VALLEY_TRAVEL "valley_travel" "mm" DOME_LAB "Travel at the valley."
    SNAP "snap" "share" DOME_LAB "Collapse force less valley force, over the collapse force."
    TRAVEL "travel" "mm" DOME_LAB
        "Bottom-out: the first travel beyond the valley, or beyond the middle of the press without one, at which the smoothed force rises by \
         more than 300 gf/mm."
    TOTAL_ENERGY "total_energy" "N mm" DOME_LAB "Area under the press, not smoothed, from its first row to the bottom-out."
    ACTUATION_FORCE "actuation_force" "N" SWITCH_MAKERS
        "Fa: force on the press where the contact closes; without a contact in the file, the collapse force."
    ACTUATION_TRAVEL "actuation_travel" "mm" SWITCH_MAKERS
        "Tm: travel on the press at which the contact closes; without a contact in the file, that of the collapse."
    RELEASE_FORCE "release_force" "N" SWITCH_MAKERS
        "Fra: lowest smoothed force on the press after the collapse, or after the actuation without one, up to the bottom-out."
    FORCE_DROP "force_drop" "N" SWITCH_MAKERS "ΔF: actuation force less release force."
    FORCE_DROP_RATIO "force_drop_ratio" "share" SWITCH_MAKERS "Δ%: force drop over actuation force."
    RETURN_FORCE "return_force" "N" SWITCH_MAKERS
        "Frr: lowest smoothed force on the way back, from the bottom-out to the travel of the actuation."
    RETURN_ENERGY "return_energy" "N mm" OURS "Area under the return from the bottom-out back to the first row of the press."
    HYSTERESIS_ENERGY "hysteresis_energy" "N mm" OURS "Total energy less return energy: what a press and its return cost."
    BOTTOM_OUT_STIFFNESS "bottom_out_stiffness" "N/mm" OURS
        "Rise of the force from the bottom-out to the largest travel, over the way between them."
    CONTACT_CLOSING_TRAVEL "contact_closing_travel" "mm" SWITCH_MAKERS "Travel on the press at which the contact first closes."
    CONTACT_CLOSING_FORCE "contact_closing_force" "N" SWITCH_MAKERS "Smoothed force on the press where the contact first closes."
    CONTACT_OPENING_TRAVEL "contact_opening_travel" "mm" SWITCH_MAKERS "Travel on the way back at which the contact first opens."
    CONTACT_OPENING_FORCE "contact_opening_force" "N" SWITCH_MAKERS "Smoothed force on the way back where the contact first opens."
    CONTACT_HYSTERESIS "contact_hysteresis" "mm" SWITCH_MAKERS
        "Differential travel: travel at which the contact closes less that at which it opens."
    CONTACT_CLOSING_BOUNCE "contact_closing_bounce" "ms" EIA_448
        "Time from the first closing of the contact on the press to the last, after which it stays closed; what is shorter than the \
         time between two rows goes unseen."
    CONTACT_OPENING_BOUNCE "contact_opening_bounce" "ms" EIA_448
        "Time from the first opening of the contact on the way back to the last, after which it stays open; what is shorter \
         than the time between two rows goes unseen."
}
