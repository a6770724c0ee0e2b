"""Prints the study's models beside the paper's Tables 5 and 6, as Markdown.

    python3 scripts/tabulate-study.py FOLDER
"""

import json
import math
import sys
from pathlib import Path

# Swindells and MacLean 2007: C- as a magnitude, detents with a positive amplitude.
PAPER = {
    "inertia": ("M", [0.091, 0.28, 0.035, 0.049, 0.0019]),
    "coulomb_negative": ("C−", [46, 8.4, 2.3, 0.61, 19]),
    "viscous_negative": ("B−", [2.7, -0.095, -0.15, 0.55, 4.7]),
    "coulomb_positive": ("C+", [46, 8.4, 2.3, 0.61, 19]),
    "viscous_positive": ("B+", [-4.5, 0.54, -0.24, 0.28, 4.1]),
    "detent_amplitude": ("A", [None, None, 1.1, 11, 130]),
    "detent_period": ("P", [None, None, 0.034, 0.076, 0.10]),
    "detent_phase": ("S", [None, None, 0.16, math.pi - 0.20, math.pi - 1.0]),
    "static_negative": ("D−", [150, 17, 10, 20, 200]),
    "static_positive": ("D+", [150, 17, 10, 20, 200]),
}
MEAN_INTERVAL = [0.30, 0.19, 0.091, 0.073, 4.2]


def number(value, half_width):
    """The value with two digits of its half width."""
    if half_width > 0:
        digits = max(0, 1 - math.floor(math.log10(half_width)))
        return f"{value:.{digits}f} ± {half_width:.{digits}f}"
    return f"{value:.4g}"


def breakaway(check, name, truth):
    """The breakaway torque that a creep showed, and how far it lies from the truth; none if its interval reaches zero."""
    seen = next((a for a in check["agreement"] if a["quantity"] == name), None)
    if not (seen and seen["ci95"] and seen["ci95"][0] > 0):
        return f"not identifiable ({truth:g})"
    return f"{seen['checked']:.4g} ({truth:g}, {100 * (seen['checked'] / truth - 1):+.1f} %)"


def main(folder):
    fits = [json.loads((folder / f"knob-{knob}.json").read_text()) for knob in range(1, 6)]
    checks = [json.loads((folder / f"knob-{knob}-check.json").read_text()) for knob in range(1, 6)]
    print("| | " + " | ".join(f"knob {knob}" for knob in range(1, 6)) + " |")
    print("|---|" + "---|" * 5)
    for name, (symbol, paper) in PAPER.items():
        cells = []
        for fit, check, truth in zip(fits, checks, paper):
            parameter = fit["parameters"][name]
            if name.startswith("static"):
                cells.append(breakaway(check, name, truth))
                continue
            if parameter["value"] is None:
                cells.append("none" if truth is None else f"not identifiable ({truth:g})")
                continue
            value = parameter["value"]
            low, high = parameter["ci95"]
            half = max(high - value, value - low)
            beside = "none" if truth is None else f"{truth:.4g}"
            held = "" if truth is None or low <= truth <= high else " ✗"
            cells.append(f"{number(value, half)} ({beside}){held}")
        print(f"| {symbol} | " + " | ".join(cells) + " |")
    row = [f"{fit['mean_ci95_mnm']:.3f} ({paper:g})" for fit, paper in zip(fits, MEAN_INTERVAL)]
    print("| mean 95 % interval, ± mNm | " + " | ".join(row) + " |")
    row = [f"{fit['residual_rms_mnm']:.3f}" for fit in fits]
    print("| residual, mNm RMS | " + " | ".join(row) + " |")
    row = [f"{max((r['ratio'] for r in fit['repeatability'].values()), default=0):.2f}" for fit in fits]
    print("| largest difference between the two captures, over its interval | " + " | ".join(row) + " |")
    row = []
    for check in checks:
        seen = next((a for a in check["agreement"] if a["quantity"] == "detent_period"), None)
        if seen is None:
            row.append("none seen")
        elif seen["difference_percent"] is None:
            row.append(f"{seen['checked']:.4g}")
        else:
            row.append(f"{seen['checked']:.4g} ({seen['difference_percent']:+.1f} %)")
    print("| P by counting detents over a slow turn | " + " | ".join(row) + " |")
    for name, words in [("static_negative", "D− from the sweeps alone"), ("static_positive", "D+ from the sweeps alone")]:
        values = [fit["parameters"][name]["value"] for fit in fits]
        row = ["not identifiable" if value is None else f"{value:.4g}" for value in values]
        print(f"| {words} | " + " | ".join(row) + " |")
    others = max(fit["mean_ci95_mnm"] for fit in fits[:4])
    print(f"\nKnob 5's mean interval is {fits[4]['mean_ci95_mnm'] / others:.0f} times the largest of the others.")


main(Path(sys.argv[1]))
