"""Names hidden effects with PySINDy's STLSQ, and prints its score beside the instrument's on the same captures.

    python scripts/diagnose-pysindy.py FOLDER…

Each FOLDER holds answers.json, captures, and results.json as the study `study` of the crate hidden-effects leaves
it. Motion from the encoder with an acceleration blended from encoder and accelerometer, torque and all columns
masked where the knob is slow, then filtered alike and decimated. The library of candidate columns is fixed: what has
a parameter inside a column has a grid of columns. STLSQ's threshold is the largest whose held-out residual is
within 2 % of the best one's.
"""

import json
import sys
import time
import warnings
from pathlib import Path

import numpy as np
from pysindy import STLSQ
from scipy import signal

warnings.filterwarnings("ignore")

SLOW_RAD_S = 0.05  # below this the knob counts as stuck,
MARGIN_S = 0.002  # and so long before and after
EDGE_S = 0.02  # filters and differences lack neighbours at the ends
BAND_HZ = 200.0
DECIMATED_HZ = 500.0
CLEAR = 1.3  # a residual above so many floors stands clear of the noise


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
        "end-stop": [np.maximum(angle - travel[1] + share * span, 0) for share in np.linspace(0.02, 0.35, 12)]
        + [np.minimum(angle - travel[0] - share * span, 0) for share in np.linspace(0.02, 0.35, 12)],
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


def diagnose(folder):
    """Verdict and names, strongest first."""
    train, held_out = Capture(folder / "train.csv"), Capture(folder / "heldout.csv")
    target, other = (capture.rows(capture.torque[:, None])[:, 0] for capture in (train, held_out))
    period = best_period(train, target)
    floor = held_out.floor()
    base = np.linalg.lstsq(train.rows(base_columns(train, period)), target, rcond=None)[0]
    before = rms(other - held_out.rows(base_columns(held_out, period)) @ base)
    if before < 1.1 * floor:
        return {"verdict": "none", "effects": [], "before": before, "after": before, "floor": floor}
    travel = (train.angle.min(), train.angle.max())
    columns, names = library(train, period, base, travel)
    columns_held_out, _ = library(held_out, period, base, travel)
    size = np.sqrt(np.mean(columns**2, axis=0)) + 1e-12
    fits = []
    for threshold in np.geomspace(0.02, 30.0, 24) * floor:
        optimizer = STLSQ(threshold=threshold, alpha=1e-6, max_iter=30)
        try:
            coefficients = optimizer.fit(columns / size, target[:, None]).coef_[0] / size
        except ValueError:
            continue
        fits.append((rms(other - columns_held_out @ coefficients), coefficients))
    least = min(after for after, _ in fits)
    after, coefficients = [fit for fit in fits if fit[0] <= 1.02 * least][-1]
    names = np.array(names)
    chosen = coefficients != 0
    # Strongest is what is missed most: columns of different names imitate each other, so their sizes say little.
    missed = {
        name: left_by(columns[:, chosen & (names != name)], target) for name in dict.fromkeys(names[chosen]) if name
    }
    effects = sorted(missed, key=missed.get, reverse=True)
    remains = (after - floor) / (before - floor)
    outside = after > CLEAR * floor and remains > 0.15
    verdict = "outside-library" if outside else "effects" if effects else "none"
    return {"verdict": verdict, "effects": effects, "before": before, "after": after, "floor": floor}


def judge(said, answer):
    """First name right, exact set right."""
    exact = said["verdict"] == answer["verdict"]
    if not answer["effects"]:
        return exact, exact
    named = said["effects"] if said["verdict"] == "effects" else []
    return bool(named) and named[0] in answer["effects"], exact and set(named) == set(answer["effects"])


def main(folders):
    rows = {}
    for folder in map(Path, folders):
        answers = json.loads((folder / "answers.json").read_text())
        ours = json.loads((folder / "results.json").read_text())
        for name, answer in sorted(answers.items()):
            begin = time.perf_counter()
            try:
                said = diagnose(folder / name)
            except (ValueError, np.linalg.LinAlgError) as error:
                said = {"verdict": f"failed: {error}", "effects": []}
            seconds = time.perf_counter() - begin
            kind = "one effect" if len(answer["effects"]) == 1 else "two effects" if answer["effects"] else answer["verdict"]
            row = (*judge(said, answer), seconds, *(ours[name][key] for key in ("first_right", "exact", "seconds")))
            rows.setdefault((kind, answer["strength"]), []).append(row)
            (folder / name / "pysindy.json").write_text(json.dumps(said))
    print("                                   PySINDy STLSQ              haptic-camera")
    print("hidden            strength   of  first exact  time s     first exact  time s")
    for (kind, strength), group in sorted(rows.items(), key=lambda item: (item[0][0], item[0][1] or 0)):
        first, exact, seconds, our_first, our_exact, our_seconds = np.array(group, dtype=float).T
        print(
            f"{kind:<18}{strength or '-':>8}{len(group):>5}{first.sum():>7.0f}{exact.sum():>6.0f}"
            f"{np.median(seconds):>8.2f}{our_first.sum():>10.0f}{our_exact.sum():>6.0f}{np.median(our_seconds):>8.2f}"
        )
    print("time: median of one diagnosis. Both saw the same files; PySINDy's process was warm.")


if __name__ == "__main__":
    main(sys.argv[1:])
