"""Fits the same raw columns with scipy and prints both times: bench-fit-scipy.py COLUMNS RESULTS

scipy does the work of the separable fit of Swindells and MacLean 2007 from the raw columns to intervals: zero-phase
Chebyshev low-passes, least_squares over the detent period from a good start with default tolerances, all other
parameters linear inside, then the covariance and 95 % intervals of parameters and predictions. The linear solve is
timed twice: numpy's lstsq, as one would write it, and Cholesky on the normal equations, the fastest that numpy has.
"""

import json
import sys
import time

import numpy
import scipy
from scipy.linalg import cho_factor, cho_solve
from scipy.optimize import least_squares
from scipy.signal import cheby2, sosfiltfilt
from threadpoolctl import threadpool_limits

START = 0.21
RUNS = 15

columns_path, results_path = sys.argv[1:]
columns = numpy.fromfile(columns_path).reshape(5, -1)
with open(results_path) as file:
    results = [json.loads(line) for line in file]


def lstsq(design, torque):
    return numpy.linalg.lstsq(design, torque, rcond=None)[0]


def normal_equations(design, torque):
    return cho_solve(cho_factor(design.T @ design), design.T @ torque)


def fit(columns, solve):
    """Period, steps, half widths of the parameters' 95 % intervals and of the predictions'."""
    time_s, angle, velocity, acceleration, torque = columns
    rate_hz = 1 / numpy.median(numpy.diff(time_s))
    low_pass = {edge: cheby2(3, 20, edge, fs=rate_hz, output="sos") for edge in (1000, 500)}
    angle, velocity = (sosfiltfilt(low_pass[1000], column) for column in (angle, velocity))
    acceleration, torque = (sosfiltfilt(low_pass[500], column) for column in (acceleration, torque))
    slides = numpy.abs(velocity) > 0.01 * numpy.sqrt(numpy.mean(velocity**2))
    angle, velocity, acceleration, torque = (column[slides] for column in (angle, velocity, acceleration, torque))
    down, up = velocity < 0, velocity > 0
    design = numpy.empty((len(torque), 7), order="F")
    design[:, :5] = numpy.column_stack([acceleration, -1.0 * down, 1.0 * up, down * velocity, up * velocity])

    def residual(period):
        phase = angle / period[0]
        design[:, 5], design[:, 6] = numpy.sin(phase), numpy.cos(phase)
        return design @ solve(design, torque) - torque

    solution = least_squares(residual, [START])
    left = residual(solution.x)
    sine, cosine = solve(design, torque)[5:]
    slope = (sine * design[:, 6] - cosine * design[:, 5]) * -angle / solution.x[0] ** 2
    jacobian = numpy.column_stack([design, slope])
    covariance = numpy.linalg.inv(jacobian.T @ jacobian) * (left @ left) / (len(torque) - 8)
    half_widths = 1.96 * numpy.sqrt(numpy.diag(covariance))
    predicted = 1.96 * numpy.sqrt(numpy.einsum("ij,ij->i", jacobian @ covariance, jacobian))
    return solution.x[0], solution.nfev, half_widths, predicted


def timed(solve, threads):
    times = []
    with threadpool_limits(threads):
        fit(columns, solve)
        before = time.process_time()
        for _ in range(RUNS):
            begin = time.perf_counter()
            outcome = fit(columns, solve)
            times.append(time.perf_counter() - begin)
        processor = (time.process_time() - before) / RUNS
    return times, processor, outcome


def line(name, times, processor, period):
    """Prints and returns median, least and processor time in ms."""
    row = 1e3 * numpy.array([numpy.median(times), numpy.min(times), processor])
    print(f"{name:48} {row[0]:8.2f} {row[1]:8.2f} {row[2]:9.2f}   P {period:.5f} rad")
    return row


ours = results[0]
print(f"{columns.shape[1]} raw samples; scipy {scipy.__version__}, numpy {numpy.__version__}; {RUNS} runs each")
print("scipy: Chebyshev low-passes both ways, variable projection from P = 0.21 (truth 0.2), covariance, intervals")
print("fit:   checks, evidence whether the motion is exact, mask, band, linear-phase filters, period searched over all")
print("       that the travel supports without a start, evidence for detents, harmonics, a delay, correlated intervals")
print(f"{'ms':48} {'median':>8} {'least':>8} {'processor':>9}")
peers = {}
for name, solve in (("numpy.linalg.lstsq", lstsq), ("normal equations", normal_equations)):
    for threads in (1, 2):
        times, processor, outcome = timed(solve, threads)
        row = line(f"scipy, {name}, {outcome[1]} steps, {threads} thread{'s' if threads > 1 else ''}", times, processor, outcome[0])
        peers[name] = numpy.minimum(row, peers.get(name, row))
own = line("fit", ours["all_seconds"], ours["processor_seconds"], ours["period_rad"])
for name, peer in peers.items():
    ratios = peer / own
    print(
        f"fit is {ratios[0]:.1f} times as fast as scipy with {name}, the better number of threads"
        f" (least times {ratios[1]:.1f}, processor time {ratios[2]:.1f})"
    )
print("samples     seconds   processor   µs per sample   peak memory   bytes per sample, the columns' own 40 included")
for row in results[1:]:
    print(
        f"{row['samples']:9} {row['seconds']:9.4f} {row['processor_seconds']:11.4f}"
        f" {1e6 * row['processor_seconds'] / row['samples']:15.3f}"
        f" {row['peak_kib'] / 1024:9.0f} MiB {1024 * row['peak_kib'] / row['samples']:10.0f}"
    )
