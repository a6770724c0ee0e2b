"""Tables that no instrument writes, and good ones as spreadsheets and people mangle them."""

import math

from archives import motion

HEADER = "t_s,angle_rad,torque_mnm"


def rows(count=3000, rate_hz=10_000.0, time=lambda row, rate_hz: row / rate_hz, change=lambda row: row):
    for row, angle_rad, torque_mnm in motion(count, 10_000.0):
        yield change((time(row, rate_hz), angle_rad, torque_mnm))


def table(header=HEADER, **how):
    return "\n".join([header, *(",".join(map(repr, row)) for row in rows(**how))]) + "\n"


def put(place, value, at=None):
    """Changes one column: everywhere, or in one row of 3000."""
    count = iter(range(10**9))

    def change(row):
        row = list(row)
        if at is None or next(count) == at:
            row[place] = value
        return tuple(row)
    return change


def bursts(length, step_s, pause_s):
    return lambda row, rate_hz: row // length * pause_s + row % length * step_s


def tables():
    """Every table of a capture by its name."""
    good = table()
    lines = good.splitlines()
    made = {
        "good.csv": good,
        "windows.csv": "\ufeff" + good.replace("\n", "\r\n"),
        "old-mac.csv": good.replace("\n", "\r"),
        "blank-lines.csv": good.replace("\n", "\n\n\n"),
        "comments.csv": "# a comment\n" + good.replace("\n", "\n# another\n", 5),
        "quoted.csv": "\n".join(",".join(f'"{cell}"' for cell in line.split(",")) for line in lines),
        "trailing-commas.csv": good.replace("\n", ",\n"),
        "semicolons.csv": good.replace(",", ";"),
        "tabs.csv": good.replace(",", "\t"),
        "decimal-commas.csv": good.replace(",", ";").replace(".", ","),
        "quoted-decimal-commas.csv": "\n".join(
            ",".join(f'"{cell.replace(".", ",")}"' for cell in line.split(",")) for line in lines),
        "other-order.csv": "\n".join(",".join(reversed(line.split(","))) for line in lines),
        "column-twice.csv": good.replace("torque_mnm", "angle_rad", 1),
        "column-unknown.csv": good.replace("torque_mnm", "\x1b[31mcolour", 1),
        "column-missing.csv": "\n".join(",".join(line.split(",")[:2]) for line in lines),
        "header-missing.csv": "\n".join(lines[1:]),
        "header-only.csv": HEADER,
        "header-of-megabytes.csv": "x" * 5_000_000,
        "header-of-columns.csv": "t_s," * 2_000_000 + "\n" + "0," * 2_000_000,
        "header-of-escapes.csv": "\x1b]0;owned\x07,\x1b[2J\n1,2\n",
        "cell-of-megabytes.csv": f"{HEADER}\n0,{'x' * 5_000_000},1\n",
        "cell-of-digits.csv": f"{HEADER}\n0,{'1' * 5_000_000},1\n1,2,3\n2,3,4\n",
        "cell-of-escapes.csv": f"{HEADER}\n0,\x1b[31mred\x1b[0m\u202e,1\n",
        "cell-missing.csv": f"{HEADER}\n0,1,2\n1,2\n",
        "cell-empty.csv": f"{HEADER}\n0,1,2\n1,,2\n",
        "quotation-open.csv": good.replace("\n", '\n"', 1),
        "zero-bytes.csv": good.encode().replace(b"1", b"\0", 10),
        "latin-1.csv": good.encode().replace(b"torque", b"dreh\xf6", 1),
        "utf-16.csv": good.encode("utf-16"),
        "bytes.csv": bytes(range(256)) * 400,
        "one-row.csv": "\n".join(lines[:2]),
        "three-rows.csv": "\n".join(lines[:4]),
        "199-rows.csv": "\n".join(lines[:200]),
        "200-rows.csv": "\n".join(lines[:201]),
        "no-end.csv": good[:-30],
        "nan.csv": table(change=put(1, math.nan, at=9)),
        "inf.csv": table(change=put(2, math.inf, at=9)),
        "time-nan.csv": table(change=put(0, math.nan, at=9)),
        "time-still.csv": table(change=put(0, 0.5)),
        "time-back.csv": "\n".join([lines[0], *reversed(lines[1:])]),
        "time-1e300.csv": table(change=put(0, 1e300, at=2999)),
        "time-steps-1e300.csv": table(time=lambda row, _: row * 1e300),
        "time-denormal.csv": table(time=lambda row, _: row * 5e-324),
        "time-negative.csv": table(time=lambda row, rate_hz: row / rate_hz - 1e6),
        "time-quadratic.csv": table(time=lambda row, rate_hz: (row / rate_hz) ** 2),
        "time-geometric.csv": table(time=lambda row, _: 1e-9 * 1.01**row),
        "time-alternating.csv": table(time=lambda row, rate_hz: (row + 0.49 * (row % 2)) / rate_hz),
        "pause-of-a-year.csv": table(time=lambda row, rate_hz: row / rate_hz + (3e7 if row > 1500 else 0.0)),
        "bursts.csv": table(time=bursts(2, 1e-6, 0.5)),
        "bursts-of-3.csv": table(time=bursts(3, 1e-6, 0.7)),
        "bursts-of-100.csv": table(time=bursts(100, 1e-7, 1.0)),
        "bursts-1e-12.csv": table(time=bursts(10, 1e-12, 0.1)),
        "bursts-many.csv": table(count=60_000, time=bursts(2, 1e-6, 0.5)),
        "angle-still.csv": table(change=put(1, 0.5)),
        "angle-denormal.csv": table(change=lambda row: (row[0], row[1] * 1e-315, row[2])),
        "angle-1e300.csv": table(change=lambda row: (row[0], row[1] * 1e300, row[2])),
        "angle-1e150.csv": table(change=lambda row: (row[0], row[1] * 1e150, row[2])),
        "angle-1e9.csv": table(change=lambda row: (row[0], row[1] * 1e9, row[2])),
        "angle-one-1e308.csv": table(change=put(1, 1e308, at=99)),
        "angle-runs-away.csv": table(change=lambda row: (row[0], 1e7 * row[0], row[2])),
        "angle-steps.csv": table(change=lambda row: (row[0], float(round(row[1])), row[2])),
        "angle-two-values.csv": table(change=lambda row: (row[0], float(row[1] > 0), row[2])),
        "torque-constant.csv": table(change=put(2, 1.0)),
        "torque-denormal.csv": table(change=lambda row: (row[0], row[1], row[2] * 1e-315)),
        "torque-1e300.csv": table(change=lambda row: (row[0], row[1], row[2] * 1e300)),
        "torque-1e150.csv": table(change=lambda row: (row[0], row[1], row[2] * 1e150)),
        "torque-two-values.csv": table(change=lambda row: (row[0], row[1], math.copysign(5.0, row[2]))),
        "torque-one-1e308.csv": table(change=put(2, -1e308, at=99)),
        "torque-is-angle.csv": table(change=lambda row: (row[0], row[1], row[1])),
        "torque-rails.csv": table(change=lambda row: (row[0], row[1], max(-1.0, min(1.0, row[2])))),
        "long.csv": table(count=150_000),
    }
    for rate_hz in (1e-300, 1e-3, 1.0, 10.0, 40.0, 49.0, 50.0, 60.0, 100.0, 199.0, 500.0, 1e5, 1e6, 1e9, 1e12, 1e200):
        made[f"rate-{rate_hz:g}.csv"] = table(count=2000, rate_hz=rate_hz)
    for rate_hz in (1.0, 10.0, 40.0, 100.0, 1e6):
        turn = lambda row, rate_hz=rate_hz: (row[0], math.sin(row[0] * rate_hz / 50), math.sin(row[0] * rate_hz / 5))
        made[f"turned-at-{rate_hz:g}.csv"] = table(count=2000, rate_hz=rate_hz, change=turn)
    return made
