"""The drift of a table's captures is the straight line of least squares."""

import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow
import pyarrow.parquet as parquet
import pytest

import haptic_camera as hc
from conftest import PROGRAM

DAY_NS = 86_400 * 10**9
PER_DAY = 0.02


@pytest.fixture
def table(captures: list[hc.Capture], tmp_path: Path) -> Path:
    """A table of two knobs over thirty days, the detents of one of which wear off; one row has an error."""
    chance = np.random.default_rng(5)
    rows: list[dict[str, Any]] = []
    for day in range(30):
        for knob, wear in (("new", 0.0), ("worn", PER_DAY)):
            row = dict(hc.table_row(captures[0].source))
            row["knob"], row["captured_at_ns"] = knob, 1_790_000_000 * 10**9 + day * DAY_NS
            for name in ("detent_amplitude", "inertia"):
                change = chance.normal(0, 0.01) - (wear * day if name == "detent_amplitude" else 0)
                for column in (name, f"{name}_ci95_low", f"{name}_ci95_high"):
                    row[column] += change
            rows.append(row)
    rows.append(hc.table_row(tmp_path / "missing.mcap"))
    arrow = {str: pyarrow.string(), int: pyarrow.int64(), float: pyarrow.float64()}
    schema = pyarrow.schema([(name, arrow[kind]) for name, kind in hc.table_columns().items()])
    parquet.write_table(pyarrow.Table.from_pylist(rows, schema=schema), tmp_path / "table.parquet")
    return tmp_path / "table.parquet"


def test_wear_is_reported_and_nothing_else(table: Path, as_json: Callable[..., dict[str, Any]], tmp_path: Path) -> None:
    trend = as_json("trend", table, "--report", tmp_path / "trend.html")
    assert trend["with_error"] == 1
    groups = {group["name"]: {one["name"]: one for one in group["parameters"]} for group in trend["groups"]}
    assert {*groups} == {"new", "worn"}
    rows = [row for row in parquet.read_table(table).to_pylist() if row["error"] is None]
    for name, parameters in groups.items():
        of_group = [row for row in rows if row["knob"] == name]
        days = np.array([row["captured_at_ns"] for row in of_group], dtype=float)
        days = (days - days.min()) / DAY_NS
        for parameter in ("detent_amplitude", "inertia"):
            values = np.array([row[parameter] for row in of_group])
            (slope, _), covariance = np.polyfit(days, values, 1, cov=True)
            drift = parameters[parameter]["drift"]
            low, high = drift["per_day_ci95"]
            assert drift["per_day"] == pytest.approx(slope)
            # Student's t for 28 degrees of freedom is 2.048.
            assert (high - low) / 2 == pytest.approx(2.048 * np.sqrt(covariance[0, 0]), rel=1e-3)
            assert parameters[parameter]["sd"] == pytest.approx(values.std(ddof=1))
    low, high = groups["worn"]["detent_amplitude"]["drift"]["per_day_ci95"]
    assert low < -PER_DAY < high < 0
    low, high = groups["new"]["detent_amplitude"]["drift"]["per_day_ci95"]
    assert low < 0 < high
    page = (tmp_path / "trend.html").read_text()
    assert "detent_amplitude of worn" in page and page.count("<svg") >= 4


def test_figures_and_verdicts_of_a_specification_are_reported(
    as_json: Callable[..., dict[str, Any]], command_line: Callable[..., str], tmp_path: Path
) -> None:
    folder, spec = tmp_path / "units", tmp_path / "spec.toml"
    turn: Any = {"duration_s": 20, "sweep": "slow-turn", "rate_hz": 5000, "offline": True, "program": PROGRAM}
    captures = [hc.capture(3, out=folder, **turn) for _ in range(2)]
    spec.write_text("[figures.peak_torque]\nmin = 0.1\n")
    for other in (*folder.glob("*.toml"), *folder.glob("*.html")):
        other.unlink()
    command_line("table", folder, "--out", tmp_path / "t.parquet", "--spec", spec)
    (group,) = as_json("trend", tmp_path / "t.parquet", "--report", tmp_path / "trend.html")["groups"]
    assert sum(group["verdicts"].values()) == 2
    (peak,) = [one for one in group["parameters"] if one["name"] == "peak_torque"]
    values = [hc.sheet(capture).figures["peak_torque"].value or np.nan for capture in captures]
    assert peak["mean"] == pytest.approx(np.mean(values)) and peak["unit"] == "mNm"
    page = (tmp_path / "trend.html").read_text()
    assert "<h2>Verdicts</h2>" in page and "peak_torque" in page


def test_what_is_no_table_is_refused(captures: list[hc.Capture], tmp_path: Path) -> None:
    (tmp_path / "other.parquet").write_bytes(b"PAR1 no table PAR1")
    parquet.write_table(pyarrow.table(captures[0]), tmp_path / "capture.parquet")
    for name in ("other.parquet", "capture.parquet"):
        ended = subprocess.run([PROGRAM, "trend", tmp_path / name], capture_output=True, text=True)
        assert ended.returncode == 1 and "is not a table of captures; make one with" in ended.stderr
