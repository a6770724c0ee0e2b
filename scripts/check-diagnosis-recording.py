#!/usr/bin/env python3
"""Compares the recording of a diagnosis with its JSON, by rerun's own reader.

    check-diagnosis-recording.py DIAGNOSIS.json DIAGNOSIS.rrd

Checked are the maps of the residual, what each step leaves, and that measured torque is prediction plus residual.
Needs the package rerun-sdk[datafusion].
"""

import json
import math
import subprocess
import sys
from pathlib import Path

from rerun.server import Server


def main(json_path, recording):
    found = json.loads(Path(json_path).read_text())
    rerun = Path(sys.executable).with_name("rerun")
    subprocess.run([rerun, "rrd", "verify", recording], check=True, capture_output=True)
    with Server(datasets={"diagnosis": [str(Path(recording).resolve())]}) as server:
        # Both must outlive the reading.
        client = server.client()
        dataset = client.get_dataset("diagnosis")
        table = dataset.reader(index="time_s").to_arrow_table()

    def column(entity, component):
        return table.column(f"/{entity}:{component}").to_pylist()

    def bars(entity):
        """Abscissas and heights of a bar chart that does not change."""
        first = [next(value for value in column(entity, f"BarChart:{part}") if value) for part in ("abscissa", "values")]
        return [numbers(value) for value in first]

    charts = 0
    for key, name in (("where", "before"), ("where_after", "after")):
        for location in found[key]:
            points = sorted({at: value for at, value in reversed(location["map"])}.items())
            abscissas, heights = bars(f"where/{location['coordinate']}/{name}")
            assert close(abscissas, [at for at, _ in points]), location["coordinate"]
            assert close(heights, [value for _, value in points]), location["coordinate"]
            charts += 1
    left = [found["heldout_rms_before"], *(step["heldout_rms_after"] for step in found["steps"])]
    names = ["without", *(step["effect"] for step in found["steps"]), "noise"]
    for place, (name, value) in enumerate(zip(names, [*left, found["noise_floor_rms"]]), 1):
        assert close(bars(f"gap/heldout_rms_mnm/{place:02}-{name}")[1], [value]), name
        charts += 1
    rows = 0
    for role in ("training", "heldout"):
        parts = [
            flat(column(f"{role}/{entity}", "Scalars:scalars"))
            for entity in ("torque/measured_mnm", "torque/predicted_after_mnm", "residual/after_mnm")
        ]
        assert len({len(part) for part in parts}) == 1 and parts[0], role
        for measured, predicted, residual in zip(*parts):
            both_missing = math.isnan(measured) and math.isnan(predicted)
            assert both_missing or abs(measured - predicted - residual) < 1e-9, role
        rows += len(parts[0])
    print(f"charts {charts} rows {rows}")


def numbers(value):
    """The numbers inside whatever lists and structures rerun keeps them in."""
    if isinstance(value, dict):
        return [number for name, part in value.items() if name not in ("shape", "names") for number in numbers(part)]
    if isinstance(value, (list, tuple)):
        return [number for part in value for number in numbers(part)]
    return [value] if isinstance(value, float) else []


def flat(values):
    return [value[0] for value in values if value]


def close(one, other):
    return len(one) == len(other) and all(abs(a - b) <= 1e-12 * max(1.0, abs(b)) for a, b in zip(one, other))


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    main(*sys.argv[1:])
