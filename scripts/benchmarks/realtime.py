"""The loop beside the tools of others that measure the host, row by row in turn; called by scripts/bench-realtime."""

import argparse
import contextlib
import dataclasses
import functools
import shutil
import sys
import tempfile
from pathlib import Path

import numpy as np

from benchmarks import markdown, peers, rig
from benchmarks.significance import permutation_p
from benchmarks.timings import ARMED, PERCENTILES, RUNNING, Ticks, read_ticks


@dataclasses.dataclass(frozen=True)
class Row:
    """One thing that is measured in every round."""

    kind: str
    rate_hz: int
    killed: bool = False
    loaded: bool = False

    def __str__(self):
        disturbed = [", consumers killed"] * self.killed + [", other cores loaded"] * self.loaded
        return f"{self.kind}, {self.rate_hz // 1000} kHz" + "".join(disturbed)


OSLAT, CYCLICTEST, BARE, IDLE, CAPTURE = "oslat", "cyclictest", "wait alone", "loop, idle", "loop, capturing"
RATES_HZ = (5_000, 10_000, 20_000)
ROWS = [
    row
    for rate_hz in RATES_HZ
    for row in (
        *(Row(kind, rate_hz) for kind in (OSLAT, CYCLICTEST, BARE, IDLE, CAPTURE)),
        Row(CAPTURE, rate_hz, killed=True),
        *(Row(kind, rate_hz, loaded=True) for kind in (OSLAT, CYCLICTEST, CAPTURE)),
        Row(CAPTURE, rate_hz, killed=True, loaded=True),
    )
]
# Whole seconds of each row below which a test of their difference could hardly find one.
SECONDS_TO_TELL = 20


def measure(row, core, seconds, folder):
    """One row of one round."""
    with contextlib.ExitStack() as stack:
        if row.loaded:
            stack.enter_context(rig.load(core, folder / "load"))
        if row.kind == OSLAT:
            return peers.oslat(core, seconds, folder)
        if row.kind == CYCLICTEST:
            return peers.cyclictest(core, row.rate_hz, seconds, folder)
        if row.kind == BARE:
            return read_ticks(rig.bare_loop(core, row.rate_hz, seconds, folder), row.rate_hz)
        if row.kind == IDLE:
            return read_ticks(rig.idle_loop(core, row.rate_hz, seconds, folder), row.rate_hz, ARMED)
        meanwhile = functools.partial(rig.kills, seconds=seconds) if row.killed else contextlib.nullcontext
        rig.capture(row.rate_hz, seconds, folder, meanwhile)
        return read_ticks(rig.ticks_file(folder), row.rate_hz, RUNNING)


def lateness_us(row, measured, percentile):
    if row.kind == OSLAT:
        return measured.lateness_us(percentile, row.rate_hz)
    if row.kind == CYCLICTEST:
        return measured.percentile_us(percentile)
    return float(np.percentile(measured.lateness_ns, percentile)) / 1e3


def median_us(row, rounds, figure):
    return float(np.median([figure(measured[row]) for measured in rounds]))


def timing_table(rounds):
    heads = ["us", *(f"late p{p}".replace("p100", "max") for p in PERCENTILES)]
    heads += [*(f"variation p{p}".replace("p100", "max") for p in PERCENTILES), "overruns", "missed"]
    lines = []
    for row in ROWS:
        line = [str(row)]
        line += [markdown.microseconds(median_us(row, rounds, lambda m, p=p: lateness_us(row, m, p))) for p in PERCENTILES]
        if isinstance(rounds[0][row], Ticks):
            variation = [median_us(row, rounds, lambda m, p=p: np.percentile(m.variation_ns, p) / 1e3) for p in PERCENTILES]
            line += [markdown.microseconds(value) for value in variation]
            line += [f"{np.median([getattr(m[row], name) for m in rounds]):.0f}" for name in ("overruns", "missed_ticks")]
        else:
            line += ["–"] * (len(PERCENTILES) + 2)
        lines.append(line)
    return markdown.table(heads, lines)


def duration_table(rounds):
    names = ("sensor_read_ns", "control_ns", "push_ns")
    heads = ["us", *(f"{name.removesuffix('_ns').replace('_', ' ')} p{p}" for name in names for p in (50, 99.9))]
    lines = []
    for row in ROWS:
        if getattr(rounds[0][row], "control_ns", None) is not None:
            line = [
                median_us(row, rounds, lambda m, n=name, p=p: np.percentile(getattr(m, n), p) / 1e3)
                for name in names
                for p in (50, 99.9)
            ]
            lines.append([str(row), *map(markdown.microseconds, line)])
    return markdown.table(heads, lines)


def ratio(rounds, row, peer, percentile):
    """Median over rounds of our lateness by the peer's in the same round."""
    of = [lateness_us(row, m[row], percentile) / max(lateness_us(peer, m[peer], percentile), 1e-3) for m in rounds]
    return float(np.median(of))


def ratio_goal(rounds, row, peer, percentile, bar):
    figure = ratio(rounds, row, peer, percentile)
    name = f"p{percentile}".replace("p100", "longest") + f" of *{row}* by that of *{peer}*"
    return markdown.goal(name, f"{figure:.2f}", f"{bar}", figure <= bar)


def noise_goal(rounds, quiet, killed):
    """Whether the kills cost anything: a permutation test over the seconds of both rows."""
    per_second = [[m[row].per_second(99.9) for m in rounds] for row in (quiet, killed)]
    name = f"*{killed}* within the noise of *{quiet}* (permutation test over per-second p99.9)"
    if min(sum(map(len, seconds)) for seconds in per_second) < SECONDS_TO_TELL:
        return [name, f"fewer than {SECONDS_TO_TELL} s a row", "p ≥ 0.05", "not tested"]
    by, p = permutation_p(*per_second)
    return markdown.goal(name, f"{by:.2f} times, p = {p:.3f}", "p ≥ 0.05", p >= 0.05)


def goals(rounds):
    rows = []
    capturing = Row(CAPTURE, 10_000)
    for percentile, bar_us in ((50, 0.1), (99, 0.25)):
        figure = median_us(capturing, rounds, lambda m, p=percentile: lateness_us(capturing, m, p))
        rows.append(
            markdown.goal(f"lateness p{percentile} of *{capturing}*", f"{figure:.3f} us", f"{bar_us} us", figure < bar_us)
        )
    conditions = [(rate_hz, loaded) for rate_hz in RATES_HZ for loaded in (False, True)]
    for rate_hz, loaded in conditions:
        ours, theirs = Row(CAPTURE, rate_hz, loaded=loaded), Row(CYCLICTEST, rate_hz, loaded=loaded)
        rows.append(ratio_goal(rounds, ours, theirs, 99.9, 0.5))
    for rate_hz, loaded in conditions:
        ours, host = Row(CAPTURE, rate_hz, loaded=loaded), Row(OSLAT, rate_hz, loaded=loaded)
        rows += [ratio_goal(rounds, ours, host, percentile, 1.2) for percentile in (99.9, 99.99, 100)]
    for rate_hz, loaded in conditions:
        quiet, killed = Row(CAPTURE, rate_hz, loaded=loaded), Row(CAPTURE, rate_hz, killed=True, loaded=loaded)
        rows.append(noise_goal(rounds, quiet, killed))
    for rate_hz in RATES_HZ:
        row = Row(CAPTURE, rate_hz)
        control = median_us(row, rounds, lambda m, row=row: np.percentile(m.control_ns, 99.9) / 1e3)
        rows.append(markdown.goal(f"control step p99.9 of *{row}*", f"{control:.2f} us", "10 us", control < 10))
    return markdown.goals_table(rows)


def main():
    parser = argparse.ArgumentParser(prog="scripts/bench-realtime", description=__doc__)
    parser.add_argument("--seconds", type=int, default=6, help="length of each row in each round (default 6)")
    parser.add_argument("--rounds", type=int, default=5, help="rounds over all rows (default 5)")
    parser.add_argument("--core", type=int, default=max(rig.cores()), help="core that is measured (default the last)")
    asked = parser.parse_args()
    head = f"{markdown.machine()}; {asked.rounds} rounds of {asked.seconds} s a row, core {asked.core}; medians over rounds."
    rounds = []
    for number in range(asked.rounds):
        measured = {}
        for row in ROWS:
            print(f"round {number + 1} of {asked.rounds}: {row}", file=sys.stderr, flush=True)
            folder = Path(tempfile.mkdtemp(prefix="haptic-camera-bench-"))
            try:
                measured[row] = measure(row, asked.core, asked.seconds, folder)
            finally:
                shutil.rmtree(folder, ignore_errors=True)
        rounds.append(measured)
    oslat = [stalls.taken_off for m in rounds for row, stalls in m.items() if row.kind == OSLAT]
    notes = (
        "The rows of oslat are the lateness that its stalls alone would cause a perfect loop at that rate; stalls in which "
        f"the scheduler took oslat itself off the core ({sum(oslat)} in {len(oslat)} runs of it) are left out."
    )
    text = "\n\n".join([head, timing_table(rounds), notes, duration_table(rounds), goals(rounds)])
    markdown.keep("realtime", text)


if __name__ == "__main__":
    main()
