"""Fits the same columns with scipy and prints both times: bench-fit-scipy.py COLUMNS RESULTS"""

import json
import sys
import time

import numpy
import scipy
from scipy.optimize import least_squares

columns_path, results_path = sys.argv[1:]
time_s, angle, velocity, acceleration, torque = numpy.fromfile(columns_path).reshape(5, -1)
with open(results_path) as file:
    results = [json.loads(line) for line in file]

# The separable problem as one would write it: least_squares over P, lstsq for all the rest.
down, up = (velocity < 0).astype(float), (velocity > 0).astype(float)
base = numpy.column_stack([acceleration, -down, up, down * velocity, up * velocity])


def residual(period):
    design = numpy.column_stack([base, numpy.sin(angle / period[0]), numpy.cos(angle / period[0])])
    coefficients = numpy.linalg.lstsq(design, torque, rcond=None)[0]
    return design @ coefficients - torque


def timed(start):
    begin = time.perf_counter()
    solution = least_squares(residual, [start])
    return time.perf_counter() - begin, solution


runs = [timed(0.21) for _ in range(9)]
seconds = float(numpy.median([run[0] for run in runs]))
period = runs[0][1].x[0]
ours = results[0]
print(f"{len(torque)} samples; scipy {scipy.__version__}, numpy {numpy.__version__}")
print(f"scipy from P = 0.21 (truth 0.2):        {1e3 * seconds:8.2f} ms, P {period:.5f} rad, {runs[0][1].nfev} steps")
print(f"fit, period searched over its whole range: {1e3 * ours['seconds']:5.2f} ms, P {ours['period_rad']:.5f} rad")
print(f"ratio: {seconds / ours['seconds']:.1f}")
print("samples     seconds   µs per sample   peak memory")
for row in results[1:]:
    print(
        f"{row['samples']:9} {row['seconds']:9.4f} {1e6 * row['seconds'] / row['samples']:12.3f}"
        f" {row['peak_kib'] / 1024:13.0f} MiB"
    )
