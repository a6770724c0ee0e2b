"""Tabulates the costs of captures from their archives; called by scripts/bench-capture."""

import os
import sys

import numpy as np
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

PROCESSES = {1: "recorder", 2: "live-fitter", 3: "rerun-viewer"}


def columns(path, topic, names):
    rows = []
    with open(path, "rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        for _, _, _, message in reader.iter_decoded_messages(topics=[topic]):
            rows.append([getattr(message, name) for name in names])
    return {name: np.array(column) for name, column in zip(names, zip(*rows))} if rows else {}


def percentiles(label, values_ns):
    points = [f"{np.percentile(values_ns, p) / 1000:10.3f}" for p in (50, 99, 99.9, 99.99)]
    print(f"{label:34}" + "".join(points) + f"{values_ns.max() / 1000:10.1f}")


def cyclictest(label, path):
    counts = []
    for line in open(path):
        if not line.startswith("#") and line.strip():
            latency, count = line.split()[:2]
            counts.append((int(latency), int(count)))
    latency, count = np.array(counts).T
    share = np.cumsum(count) / count.sum()
    points = [f"{latency[np.searchsorted(share, p)]:10.0f}" for p in (0.5, 0.99, 0.999, 0.9999)]
    worst = [line.split(":")[1].strip() for line in open(path) if line.startswith("# Max Latencies")]
    print(f"{label:34}" + "".join(points) + f"{int(worst[0]):10d}")


def loop(path):
    sample = columns(path, "/sample", ["tick", "lateness_ns", "missed_ticks", "sensor_read_ns", "control_ns", "push_ns"])
    rate_hz = columns(path, "/status", ["rate_hz"])["rate_hz"][-1]
    sample["stall_ns"] = sample["lateness_ns"] + sample["missed_ticks"] * 1e9 / rate_hz
    return sample, rate_hz


archive, killed, before, between, after = sys.argv[1:6]
sample, rate_hz = loop(archive)
disturbed, _ = loop(killed)
seconds = (sample["tick"][-1] + 1) / rate_hz

print(f"\n{rate_hz:.0f} Hz for {seconds:.0f} s")
print(f"{'':34}{'samples':>10}{'missed':>10}{'overruns':>10}")
for label, run in (("undisturbed", sample), ("consumers killed", disturbed)):
    missed = run["missed_ticks"]
    print(f"{label:34}{len(missed):10}{missed.sum():10}{(missed > 0).sum():10}")
print(f"\n{'microseconds':34}" + "".join(f"{p:>10}" for p in ("p50", "p99", "p99.9", "p99.99", "max")))
cyclictest("cyclictest before", before)
percentiles("lateness, undisturbed", sample["stall_ns"])
cyclictest("cyclictest between", between)
percentiles("lateness, consumers killed", disturbed["stall_ns"])
cyclictest("cyclictest after", after)
percentiles("sensor read (simulated rig)", sample["sensor_read_ns"])
percentiles("control step", sample["control_ns"])
percentiles("torque write and push", sample["push_ns"])

fit = columns(archive, "/fit", ["update_ns"])
if fit:
    percentiles("live fit, CPU per update", fit["update_ns"])
health = columns(archive, "/health", ["process", "latency_ns", "cpu_time_ns", "resident_bytes", "monotonic_time_ns"])
for code, name in PROCESSES.items():
    mine = health["process"] == code
    if mine.sum() > 3:
        percentiles(f"tick to {name}", health["latency_ns"][mine][2:])
print(f"\n{'process':34}{'CPU':>10}{'resident':>14}")
for code, name in PROCESSES.items():
    mine = health["process"] == code
    if mine.sum() > 3:
        cpu_ns, time_ns = (np.ptp(health[column][mine]) for column in ("cpu_time_ns", "monotonic_time_ns"))
        print(f"{name:34}{100 * cpu_ns / time_ns:9.2f}%{health['resident_bytes'][mine][-1] / 2**20:10.1f} MiB")
size = os.path.getsize(archive)
print(f"\narchive: {size / len(sample['tick']):.1f} bytes a sample, {size / seconds * 3600 / 1e9:.2f} GB an hour")
