"""Names hidden effects with the sparse regressions that others use, beside the instrument, on the same captures.

    python scripts/diagnose-peers.py FOLDER…

Each FOLDER holds answers.json, captures, and results.json as the study `study` of the crate hidden-effects leaves
it. Motion from the encoder with an acceleration blended from encoder and accelerometer, torque and all columns
masked where the knob is slow, then filtered alike and decimated. The library of candidate columns is fixed and the same
for all: what has a parameter inside a column has a grid of columns. The peers are PySINDy (STLSQ; the largest threshold
whose held-out residual is within 2 % of the best one's), SysIdentPy (FROLS, an NFIR model of degree 1; number of terms by
BIC) and pyoperon (genetic programming over sums of columns; model by minimum description length). Prints Markdown.
"""

import json
import re
import sys
import time
import warnings
from pathlib import Path

import numpy as np
from benchmarks.markdown import table
from pyoperon.sklearn import SymbolicRegressor
from pysindy import STLSQ
from scipy import signal
from sysidentpy.basis_function import Polynomial
from sysidentpy.model_structure_selection import FROLS
from sysidentpy.parameter_estimation import LeastSquares

warnings.filterwarnings("ignore")

SLOW_RAD_S = 0.05  # below this the knob counts as stuck,
MARGIN_S = 0.002  # and so long before and after
EDGE_S = 0.02  # filters and differences lack neighbours at the ends
BAND_HZ = 200.0
DECIMATED_HZ = 500.0
CLEAR = 1.3  # a residual above so many floors stands clear of the noise
MOST_TERMS = 25  # that FROLS compares
OPERON_S = 5  # so long the genetic programming may take
SHARES = np.linspace(0.02, 0.35, 12)  # of the travel, where an end stop may begin
SCRATCHES = [(begin, begin + width) for width in (0.1, 0.2, 0.4) for begin in np.arange(0.0, 1.0 - width + 0.01, width / 2)]


def read(path):
    """Time, angle, acceleration and torque, and the sampling rate."""
    table = np.loadtxt(path, delimiter=",", skiprows=1)
    t, angle, _, acceleration, torque = table.T
    return t, angle, acceleration, torque, (len(t) - 1) / (t[-1] - t[0])


def difference(x, rate):
    """Central difference of fourth order."""
    padded = np.pad(x, 2, mode="edge")
    return rate * (8 * (padded[3:-1] - padded[1:-3]) - (padded[4:] - padded[:-4])) / 12


def blend(encoder, accelerometer, rate):
    """The encoder's acceleration where its noise is less than the accelerometer's: up to about 120 Hz."""
    gap = encoder - accelerometer
    mirrored = np.concatenate([gap[::-1], gap, gap[::-1]])
    f = np.fft.rfftfreq(len(mirrored), 1 / rate)
    encoder_noise = 9.8e-6 / np.sqrt(12) * (2 * np.pi * f) ** 2
    accelerometer_noise = np.hypot(1.5, 2.8 / np.sqrt(12))
    share = accelerometer_noise**2 / (accelerometer_noise**2 + encoder_noise**2)
    return accelerometer + np.fft.irfft(np.fft.rfft(mirrored) * share, len(mirrored))[len(gap) : 2 * len(gap)]


class Capture:
    """One recording with its motion, its mask, and the filter that torque and columns go through."""

    def __init__(self, path):
        self.t, angle, accelerometer, self.torque, self.rate = read(path)
        sections = signal.butter(4, min(400.0, 0.4 * self.rate), fs=self.rate, output="sos")
        self.angle = signal.sosfiltfilt(sections, angle)
        self.velocity = difference(self.angle, self.rate)
        self.acceleration = blend(difference(self.velocity, self.rate), accelerometer, self.rate)
        margin = int(np.ceil(MARGIN_S * self.rate))
        slow = np.abs(self.velocity) < SLOW_RAD_S
        self.mask = 1.0 - np.convolve(slow, np.ones(2 * margin + 1), "same").clip(0, 1).round()
        end = int(EDGE_S * self.rate)
        self.mask[:end] = self.mask[-end:] = 0.0
        taps = 2 * int(0.01 * self.rate) + 1
        self.taps = signal.firwin(taps, BAND_HZ, fs=self.rate)
        self.step = int(round(self.rate / DECIMATED_HZ))
        self.keep = signal.fftconvolve(self.mask, np.ones(taps) / taps, "same")[:: self.step] > 0.5

    def rows(self, columns):
        """Columns masked, filtered and decimated."""
        filtered = signal.fftconvolve(columns * self.mask[:, None], self.taps[:, None], "same", axes=0)
        return filtered[:: self.step][self.keep]

    def floor(self):
        """RMS that the torque's own noise leaves behind the filter."""
        high = signal.butter(4, [0.24 * self.rate, 0.46 * self.rate], "bandpass", fs=self.rate, output="sos")
        noise = signal.sosfiltfilt(high, self.torque)
        _, gain = signal.sosfreqz(high, 4096)
        share = np.sqrt(np.mean(np.abs(gain) ** 4))
        return np.median(np.abs(noise)) / 0.6745 / share * np.sqrt(np.sum(self.taps**2))


def base_columns(capture, period):
    v = capture.velocity
    down, up = (v < 0).astype(float), (v > 0).astype(float)
    return np.column_stack(
        [capture.acceleration, -down, up, v * down, v * up]
        + [np.sin(capture.angle / period), np.cos(capture.angle / period)]
    )


def best_period(capture, target):
    """The period whose detents leave least, by a scan of 1/P and a closer one."""
    v = capture.velocity
    fixed = capture.rows(base_columns(capture, 1.0)[:, :5])
    q, _ = np.linalg.qr(fixed)
    left = target - q @ (q.T @ target)
    travel = np.ptp(capture.angle)

    def gain(wave):
        waves = capture.rows(np.column_stack([np.sin(capture.angle * wave), np.cos(capture.angle * wave)]))
        waves -= q @ (q.T @ waves)
        return np.linalg.norm(np.linalg.lstsq(waves, left, rcond=None)[0] @ waves.T)

    waves = np.arange(1 / 0.12, 1 / 0.03, 1.5 / travel)
    best = waves[np.argmax([gain(wave) for wave in waves])]
    for width in (1.5, 0.3, 0.06):
        near = best + width / travel * np.linspace(-1, 1, 11)
        best = near[np.argmax([gain(wave) for wave in near])]
    return 1 / best


def dahl(capture, length):
    """Deflection of a bristle that slips after about `length`, over that at slip."""
    z, course = 0.0, np.empty(len(capture.angle))
    steps = np.diff(capture.angle, prepend=capture.angle[0])
    decay = np.exp(-np.abs(steps) / length)
    signs = np.sign(steps)
    for index, (sign, factor) in enumerate(zip(signs, decay)):
        z = sign + (z - sign) * factor
        course[index] = z
    return course


def play(capture, half_gap):
    """Angle of a body that is dragged along behind a gap."""
    inner, course = capture.angle[0], np.empty(len(capture.angle))
    for index, angle in enumerate(capture.angle):
        inner = min(max(inner, angle - half_gap), angle + half_gap)
        course[index] = inner
    return course


def candidates(capture, period, base, travel):
    """Columns of every effect, by its name."""
    angle, v, t = capture.angle, capture.velocity, capture.t
    smooth = signal.fftconvolve(capture.torque, capture.taps, "same")
    rate_of_torque = difference(smooth, capture.rate)
    slower = signal.sosfiltfilt(signal.butter(3, 80.0, fs=capture.rate, output="sos"), capture.torque)
    coulomb = np.where(v > 0, abs(base[2]), -abs(base[1]))
    friction = coulomb + np.where(v > 0, base[4], base[3]) * v
    span = travel[1] - travel[0]
    orders = np.arange(2, 13)
    waves = [n for n in range(5, 61) if abs(n * period - round(n * period)) > 0.1 or n * period < 0.5]
    blocks = {
        "detent-harmonics": [f(k * angle / period) for k in orders for f in (np.sin, np.cos)],
        "mass-imbalance": [np.sin(angle), np.cos(angle)],
        "return-spring": [angle],
        "torque-offset": [np.ones_like(angle)],
        "quadratic-drag": [v * np.abs(v)],
        "friction-eccentricity": [coulomb * np.sin(angle), coulomb * np.cos(angle)],
        "friction-drift": [friction * np.exp(-t / tau) for tau in (0.5, 1, 1.5, 2, 3, 5)],
        "stribeck": [np.sign(v) * np.exp(-((np.abs(v) / s) ** e)) for s in (0.3, 0.6, 1.2, 2.4) for e in (1, 2)],
        "end-stop": [np.maximum(angle - travel[1] + share * span, 0) for share in SHARES]
        + [np.minimum(angle - travel[0] - share * span, 0) for share in SHARES],
        "scratch": [
            np.sign(v) * ((angle > travel[0] + begin * span) & (angle < travel[0] + end * span)) for begin, end in SCRATCHES
        ],
        "velocity-strengthening": [np.sign(v) * np.exp(-np.abs(v) / s) for s in (0.1, 0.3, 1.0)],
        "eddy-current-damping": [v / (1 + (v / s) ** 2) for s in (0.5, 1.0, 2.0, 4.0)],
        "angle-dependent-inertia": [
            capture.acceleration * f(n * angle) + 0.5 * n * v * v * g(n * angle)
            for n in (1, 2)
            for f, g in ((np.cos, lambda x: -np.sin(x)), (np.sin, np.cos))
        ],
        "load-dependent-friction": [np.sign(v) * np.abs(base[5] * np.sin(angle / period) + base[6] * np.cos(angle / period))],
        "unequal-detents": [
            f(angle / period) * (np.floor(angle / period / (2 * np.pi)) == lobe)
            for lobe in range(int(np.floor(travel[0] / period / (2 * np.pi))), int(travel[1] / period / (2 * np.pi)) + 1)
            for f in (np.sin, np.cos)
        ],
        "presliding-hysteresis": [dahl(capture, length) for length in (0.001, 0.003, 0.01, 0.03, 0.1)],
        "backlash": [
            np.sign(v) * (np.diff(play(capture, gap), prepend=angle[0]) == 0) for gap in (0.001, 0.003, 0.01, 0.03)
        ],
        "sensor-delay": [rate_of_torque],
        "shaft-compliance": [difference(difference(slower, capture.rate), capture.rate)],
        "mains-hum": [f(2 * np.pi * hz * t) for hz in (50, 60) for f in (np.sin, np.cos)],
        "cogging": [f(n * angle) for n in waves for f in (np.sin, np.cos)],
    }
    return {name: np.column_stack(columns) for name, columns in blocks.items()}


def library(capture, period, base, travel):
    """All columns behind the filter, and the name that each belongs to (empty for the base model's)."""
    blocks = {"": base_columns(capture, period), **candidates(capture, period, base, travel)}
    names = [name for name, block in blocks.items() for _ in range(block.shape[1])]
    return capture.rows(np.column_stack(list(blocks.values()))), names


def rms(x):
    return float(np.sqrt(np.mean(np.square(x))))


def left_by(columns, target):
    """Residual of a plain fit."""
    return rms(target - columns @ np.linalg.lstsq(columns, target, rcond=None)[0])


def least_squares(columns, target, chosen):
    """Coefficients of the chosen columns; 0 for the others."""
    coefficients = np.zeros(columns.shape[1])
    coefficients[chosen] = np.linalg.lstsq(columns[:, chosen], target, rcond=None)[0]
    return coefficients


def by_stlsq(columns, target, floor, held_out):
    other_columns, other = held_out
    fits = []
    for threshold in np.geomspace(0.02, 30.0, 24) * floor:
        try:
            coefficients = STLSQ(threshold=threshold, alpha=1e-6, max_iter=30).fit(columns, target[:, None]).coef_[0]
        except ValueError:
            continue
        fits.append((rms(other - other_columns @ coefficients), coefficients))
    least = min(after for after, _ in fits)
    return [fit for fit in fits if fit[0] <= 1.02 * least][-1][1]


def by_frols(columns, target, floor, held_out):
    width = columns.shape[1]
    model = FROLS(
        order_selection=True,
        n_info_values=MOST_TERMS,
        info_criteria="bic",
        estimator=LeastSquares(),
        xlag=[[1]] * width,
        ylag=1,
        basis_function=Polynomial(degree=1),
        model_type="NFIR",
    )
    # Its regressors are the inputs a sample ago.
    model.fit(X=columns[1:], y=target[:-1, None])
    inputs = [int(code) // 1000 for code in model.final_model[:, 0] if code]
    # With one input its codes start at 2001; with more, each input has a thousand of its own from there on.
    return least_squares(columns, target, np.isin(np.arange(width), np.array(inputs, dtype=int) - 2))


def by_operon(columns, target, floor, held_out):
    model = SymbolicRegressor(
        allowed_symbols="add,constant,variable",
        max_length=60,
        optimizer_iterations=3,
        max_time=OPERON_S,
        n_threads=1,
        random_state=1,
    )
    model.fit(columns, target)
    used = {int(number) - 1 for number in re.findall(r"X(\d+)", model.get_model_string(model.model_, 4))}
    return least_squares(columns, target, np.isin(np.arange(columns.shape[1]), sorted(used)))


PEERS = {"PySINDy STLSQ": by_stlsq, "SysIdentPy FROLS": by_frols, "pyoperon": by_operon}


class Library:
    """Both captures of a folder with the library's columns."""

    def __init__(self, folder):
        train, held_out = Capture(folder / "train.csv"), Capture(folder / "heldout.csv")
        self.target, self.other = (capture.rows(capture.torque[:, None])[:, 0] for capture in (train, held_out))
        period = best_period(train, self.target)
        self.floor = held_out.floor()
        self.base = np.linalg.lstsq(train.rows(base_columns(train, period)), self.target, rcond=None)[0]
        self.before = rms(self.other - held_out.rows(base_columns(held_out, period)) @ self.base)
        self.travel = (train.angle.min(), train.angle.max())
        self.columns, names = library(train, period, self.base, self.travel)
        self.other_columns, _ = library(held_out, period, self.base, self.travel)
        self.names = np.array(names)
        self.size = np.sqrt(np.mean(self.columns**2, axis=0)) + 1e-12

    def diagnosed(self, select):
        """What a peer says: verdict, names (strongest first), the base model's values, ranges of the angle."""
        if self.before < 1.1 * self.floor:
            return {"verdict": "none", "effects": [], "base": list(self.base), "ranges": {}}
        held_out = (self.other_columns / self.size, self.other)
        coefficients = select(self.columns / self.size, self.target, self.floor, held_out) / self.size
        after = rms(self.other - self.other_columns @ coefficients)
        chosen = coefficients != 0
        # Strongest is what is missed most: columns of different names imitate each other, so their sizes say little.
        missed = {
            name: left_by(self.columns[:, chosen & (self.names != name)], self.target)
            for name in dict.fromkeys(self.names[chosen])
            if name
        }
        effects = sorted(missed, key=missed.get, reverse=True)
        outside = after > CLEAR * self.floor and after - self.floor > 0.15 * (self.before - self.floor)
        verdict = "outside-library" if outside else "effects" if effects else "none"
        base = list(coefficients[self.names == ""])
        return {"verdict": verdict, "effects": effects, "base": base, "ranges": self.ranges(chosen)}

    def ranges(self, chosen):
        """The parts of the travel in which a chosen end stop or scratch acts."""
        low, high = self.travel
        span = high - low
        stops = np.flatnonzero(chosen[self.names == "end-stop"])
        upper = [[high - SHARES[i] * span, high] for i in stops if i < len(SHARES)]
        lower = [[low, low + SHARES[i - len(SHARES)] * span] for i in stops if i >= len(SHARES)]
        scratches = np.flatnonzero(chosen[self.names == "scratch"])
        found = [[low + SCRATCHES[i][0] * span, low + SCRATCHES[i][1] * span] for i in scratches]
        return {"end-stop": upper + lower, "scratch": found}


def own_result(folder):
    """The same for the instrument's diagnosis."""
    result = json.loads((folder / "diagnosis.json").read_text())
    values = {name: parameter["value"] for name, parameter in result["model_parameters"].items()}
    base = [values.get("inertia", 0.0), values.get("coulomb_negative", 0.0), values.get("coulomb_positive", 0.0)]
    ranges = {"end-stop": [], "scratch": []}
    if "scratch" in result["effects"]:
        ranges["scratch"] = [[values["scratch_begin"], values["scratch_end"]]]
    if "end-stop" in result["effects"]:
        if values.get("stop_upper_stiffness"):
            ranges["end-stop"].append([values["stop_upper"], np.inf])
        if values.get("stop_lower_stiffness"):
            ranges["end-stop"].append([-np.inf, values["stop_lower"]])
    return {"verdict": result["verdict"], "effects": result["effects"], "base": base, "ranges": ranges}


def located(said, answer, travel):
    """F1 of the part of the travel where a hidden end stop or scratch acts; None if neither is hidden."""
    kind = next((name for name in ("end-stop", "scratch") if name in answer["effects"]), None)
    if kind is None:
        return None
    hidden = answer["parameters"][kind]
    if kind == "scratch":
        true = [[hidden["begin_rad"], hidden["end_rad"]]]
    else:
        true = [[hidden["upper_rad"], np.inf]] if hidden["upper_rad"] is not None else []
        true += [[-np.inf, hidden["lower_rad"]]] if hidden["lower_rad"] is not None else []
    angle = np.linspace(*travel, 4001)
    there, found = (
        np.any([(angle >= low) & (angle <= high) for low, high in ranges] or [np.zeros(angle.shape, bool)], axis=0)
        for ranges in (true, said["ranges"][kind] if kind in said["effects"] else [])
    )
    return 2 * np.sum(there & found) / max(np.sum(there) + np.sum(found), 1)


def judge(said, answer):
    """First name right, exact set right."""
    exact = said["verdict"] == answer["verdict"]
    if not answer["effects"]:
        return exact, exact
    named = said["effects"] if said["verdict"] == "effects" else []
    return bool(named) and named[0] in answer["effects"], exact and set(named) == set(answer["effects"])


def bias(base, answer):
    """Largest relative error of inertia and Coulomb friction."""
    true = np.array([answer["base"]["M"], answer["base"]["C_neg"], answer["base"]["C_pos"]])
    return float(np.max(np.abs(np.abs(base[:3]) / true - 1)))


COUNTS = {0: "", 1: "one effect", 2: "two effects", 3: "three effects"}


def score(said, answer, travel, seconds):
    first, exact = judge(said, answer)
    wrong = [name for name in said["effects"] if name not in answer["effects"]]
    return {
        "first": first,
        "exact": exact,
        "named": len(said["effects"]),
        "wrong": len(wrong),
        "bias": bias(np.array(said["base"]), answer) if answer["effects"] else None,
        "located": located(said, answer, travel),
        "seconds": seconds,
    }


def row(head, scores):
    count = len(scores)
    named, wrong = (sum(score[key] for score in scores) for key in ("named", "wrong"))
    middle = lambda key: [score[key] for score in scores if score[key] is not None]
    cell = lambda values, form: format(np.median(values), form) if values else "–"
    shares = [f"{sum(score[key] for score in scores)} of {count}" for key in ("first", "exact")]
    return [
        *head,
        *shares,
        f"{wrong} of {named}",
        cell(middle("bias"), ".3f"),
        cell(middle("located"), ".2f"),
        cell(middle("seconds"), ".1f"),
    ]


def main(folders):
    scores = {}
    for folder in map(Path, folders):
        answers = json.loads((folder / "answers.json").read_text())
        results = json.loads((folder / "results.json").read_text())
        for name, answer in sorted(answers.items()):
            begun = time.perf_counter()
            shared = Library(folder / name)
            prepared_s = time.perf_counter() - begun
            kind = COUNTS[len(answer["effects"])] or answer["verdict"]
            group = scores.setdefault((kind, answer["strength"] or 0), {})
            add = lambda who, said, seconds: group.setdefault(who, []).append(score(said, answer, shared.travel, seconds))
            if (folder / name / "diagnosis.json").exists():
                add("haptic-camera", own_result(folder / name), results[name]["seconds"])
            without = {"verdict": "none", "effects": [], "base": list(shared.base), "ranges": {}}
            add("base model alone", without, prepared_s)
            for peer, select in PEERS.items():
                begun = time.perf_counter()
                try:
                    said = shared.diagnosed(select)
                except (ValueError, np.linalg.LinAlgError) as error:
                    print(f"{peer} failed on {name}: {error}", file=sys.stderr)
                    said = {**without, "verdict": "failed"}
                add(peer, said, prepared_s + time.perf_counter() - begun)
    heads = ["hidden", "strength", "by", "first name", "exact set", "false names", "bias", "located F1", "s"]
    rows = [
        row([kind, f"{strength:g}" if strength else "", who], all_of)
        for (kind, strength), group in sorted(scores.items())
        for who, all_of in group.items()
    ]
    print(table(heads, rows))
    print(
        "\nbias: largest relative error of inertia and Coulomb friction; located F1: of the part of the travel where an end stop"
        "\nor a scratch acts; s: one diagnosis; all three medians. All saw the same files; the peers' process was warm."
    )


if __name__ == "__main__":
    main(sys.argv[1:])
