"""The table of a folder, which other readers open, whatever happens while it is made."""

import os
import signal
import subprocess
import time
from collections.abc import Callable
from pathlib import Path

import pyarrow.parquet as parquet
import pytest

import haptic_camera as hc
from conftest import PROGRAM


@pytest.fixture
def folder(captures: list[hc.Capture], tmp_path: Path) -> Path:
    """A folder with a folder in it, sound archives, a table, a cut archive and a text of no table."""
    folder = tmp_path / "captures"
    (folder / "deeper").mkdir(parents=True)
    for number in range(6):
        os.link(captures[number % 2].source, folder / f"{number}.mcap")
    whole = Path(captures[0].source).read_bytes()
    (folder / "deeper" / "cut.mcap").write_bytes(whole[: len(whole) // 2])
    (folder / "deeper" / "foreign.csv").write_text("a,b\n1,2\n")
    captures[0].save(folder / "deeper" / "table.csv")
    (folder / "notes.txt").write_text("no capture")
    return folder


def test_a_row_a_capture_and_damaged_files_say_so(
    folder: Path, command_line: Callable[..., str], tmp_path: Path
) -> None:
    words = command_line("table", folder, "--out", tmp_path / "t.parquet")
    assert "9 captures, 2 of them with an error" in words
    table = parquet.read_table(tmp_path / "t.parquet")
    rows = {Path(row["file"]).name: row for row in table.to_pylist()}
    assert [*rows] == sorted(rows, key=lambda name: str(next(folder.rglob(name))))
    for name, row in rows.items():
        path = next(folder.rglob(name))
        assert row == hc.table_row(path)
        if row["error"] is not None:
            with pytest.raises(hc.Error) as raised:
                hc.fit(path)
            assert row["error"] == str(raised.value) and row["inertia"] is None
            continue
        fit = hc.fit(path)
        assert row["residual_rms_mnm"] == fit.residual_rms_mnm and row["samples"] == fit.samples
        for parameter in fit.parameters.values():
            assert row[parameter.name] == parameter.value
            ends = (row[f"{parameter.name}_ci95_low"], row[f"{parameter.name}_ci95_high"])
            assert ends == (parameter.ci95 or (None, None))
    assert {name for name, row in rows.items() if row["error"]} == {"cut.mcap", "foreign.csv"}
    assert table.schema.metadata[b"unit.detent_amplitude_ci95_low"] == b"mNm"


def test_a_killed_call_goes_on_where_it_was(folder: Path, command_line: Callable[..., str], tmp_path: Path) -> None:
    undisturbed, out = tmp_path / "undisturbed.parquet", tmp_path / "killed.parquet"
    command_line("table", folder, "--out", undisturbed)
    journal = Path(f"{out}.incomplete")
    with subprocess.Popen([PROGRAM, "table", folder, "--out", out, "--jobs", "1"], stderr=subprocess.DEVNULL) as call:
        while call.poll() is None and (not journal.exists() or journal.read_text().count("\n") < 2):
            time.sleep(0.001)
        call.send_signal(signal.SIGKILL)
    assert not out.exists() and 2 <= journal.read_text().count("\n") < 9
    # The line that the kill cut off.
    with journal.open("a") as lines:
        lines.write('["cut')
    ended = subprocess.run([PROGRAM, "table", folder, "--out", out], capture_output=True, text=True, check=True)
    assert "captures are in" in ended.stderr
    assert parquet.read_table(out).equals(parquet.read_table(undisturbed))
    assert not journal.exists()


def test_a_changed_capture_is_fitted_again(
    folder: Path, captures: list[hc.Capture], command_line: Callable[..., str], tmp_path: Path
) -> None:
    out = tmp_path / "t.parquet"
    (tmp_path / "other").mkdir()
    hc.simulate(2, captures[0]).save(tmp_path / "other" / "0.csv")
    journal = Path(f"{out}.incomplete")
    with subprocess.Popen([PROGRAM, "table", folder, "--out", out, "--jobs", "1"], stderr=subprocess.DEVNULL) as call:
        while call.poll() is None and (not journal.exists() or not journal.read_text()):
            time.sleep(0.001)
        call.kill()
    (folder / "deeper" / "table.csv").unlink()
    (folder / "0.mcap").unlink()
    os.link(captures[1].source, folder / "0.mcap")
    os.utime(folder / "0.mcap")
    command_line("table", folder, "--out", out)
    rows = parquet.read_table(out).to_pylist()
    assert len(rows) == 8 and rows[0] == hc.table_row(folder / "0.mcap")


@pytest.fixture
def judged(tmp_path: Path) -> tuple[Path, Path]:
    """A folder with knob 3 turned slowly, a fast sweep, a table without a time and a text of no table; a specification."""
    folder, spec = tmp_path / "units", tmp_path / "spec.toml"
    for sweep, duration_s in (("slow-turn", 20), ("multisine", 6)):
        hc.capture(3, duration_s=duration_s, sweep=sweep, rate_hz=5000, offline=True, out=folder, program=PROGRAM)
    for other in (*folder.glob("*.toml"), *folder.glob("*.html")):
        other.unlink()
    slow = next(capture for capture in map(hc.read, folder.glob("*.mcap")) if len(capture) > 50_000)
    rows = zip(slow.angle_rad, slow.torque_mnm)
    lines = ["angle_rad,torque_mnm", *(f"{angle},{torque}" for angle, torque in rows)]
    (folder / "static.csv").write_text("\n".join(lines) + "\n")
    (folder / "foreign.csv").write_text("a,b\n1,2\n")
    spec.write_text("[figures.peak_torque]\nmin = 0.1\nmax = 3.2\n[figures.detent_pitch]\nmin = 0.1\n")
    return folder, spec


def test_a_specification_gives_figures_and_verdicts(
    judged: tuple[Path, Path], command_line: Callable[..., str], tmp_path: Path
) -> None:
    folder, spec = judged
    command_line("table", folder, "--out", tmp_path / "t.parquet", "--spec", spec)
    table = parquet.read_table(tmp_path / "t.parquet")
    assert table.schema.metadata[b"unit.peak_torque"] == b"mNm" and table.schema.names == [*hc.table_columns(spec=spec)]
    reported = 0
    for row in table.to_pylist():
        path = Path(row["file"])
        assert row == hc.table_row(path, spec=spec)
        try:
            sheet, judgement = hc.sheet(path), hc.judge(path, spec)
        except hc.Error as error:
            assert row["sheet_error"] == str(error) and row["verdict"] is None and row["peak_torque"] is None
            continue
        reported += 1
        assert row["error"] is row["sheet_error"] is None
        assert row["verdict"] == judgement.verdict and row["verdict_reasons"] == "; ".join(judgement.units[0].reasons)
        for name, figure in sheet.figures.items():
            assert (row[name], (row[f"{name}_ci95_low"], row[f"{name}_ci95_high"])) == (
                figure.value,
                figure.ci95 or (None, None),
            )
    assert reported == 2
    rows = {Path(row["file"]).name: row for row in table.to_pylist()}
    # The foreign table tells nothing; what was turned fast has a fit, what has no time a sheet.
    assert [name for name, row in rows.items() if row["error"]] == ["foreign.csv"]
    assert rows["static.csv"]["inertia"] is None and rows["static.csv"]["detent_pitch"] is not None


def test_rows_of_another_specification_are_made_again(
    judged: tuple[Path, Path], command_line: Callable[..., str], tmp_path: Path
) -> None:
    folder, spec = judged
    out = tmp_path / "t.parquet"
    journal = Path(f"{out}.incomplete")
    command = [PROGRAM, "table", folder, "--out", out, "--jobs", "1", "--spec", spec]
    with subprocess.Popen(command, stderr=subprocess.DEVNULL) as call:
        while call.poll() is None and (not journal.exists() or journal.read_text().count("\n") < 2):
            time.sleep(0.001)
        call.kill()
    spec.write_text("[figures.peak_torque]\nmin = 100\n[figures.detent_pitch]\nmin = 0.1\n")
    command_line("table", folder, "--out", out, "--spec", spec)
    rows = {Path(row["file"]).name: row for row in parquet.read_table(out).to_pylist()}
    assert rows["static.csv"]["verdict"] == "fail"
