"""Captures and replays are those of the real programs, of models made in Python too."""

import os
import signal
import subprocess
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import haptic_camera as hc
from conftest import PROGRAM


@pytest.fixture
def options(tmp_path: Path) -> dict[str, Any]:
    return {"rate_hz": 10_000, "offline": True, "out": tmp_path, "program": PROGRAM}


def made() -> dict[str, hc.Model]:
    """Models that are in no file: every kind of number, a drawn table, another axis, a name that is no file name."""
    angle_rad = np.linspace(0, 0.2, 9) / 3
    drawn = (angle_rad, 6e-3 * np.sin(2 * np.pi * angle_rad / angle_rad[-1]))
    knob, slack = hc.Model.load(3), hc.Model.load(5).change(backlash_stiffness=1e5 / 3)
    return {
        "changed": knob.change(detent_amplitude=1 / 3, inertia=0.1 + 0.2, detent_phase=-1e-17),
        "composed": hc.Model.compose(inertia=2, friction=3, detents=4, extra={"backlash": slack}, name="../a \"b\"\n=c/.."),
        "drawn": hc.Model.compose(inertia=knob, friction=3, detents=drawn).change(table_scale=np.float64(np.pi)),
        "pressed": hc.Model.load("dome").change(inertia=2e-3 / 30),
    }


@pytest.mark.parametrize("kind", ["changed", "composed", "drawn", "pressed"])
def test_a_model_made_in_python_is_on_the_rig_bit_for_bit(kind: str, options: dict[str, Any]) -> None:
    model = made()[kind]
    if model.axis == "linear":
        options["arguments"] = ["--apparatus", "sim-linear"]
    captured = hc.capture(model, duration_s=1, **options)
    assert captured.truth == model and captured.truth.to_toml() == model.to_toml()
    assert (captured.to_dict()["knob"], captured.axis) == (model.name, model.axis)
    felt = hc.replay(model, duration_s=1, **options)
    assert felt.truth == model and felt.truth.to_toml() == model.to_toml()
    assert felt.to_dict()["knob"] == model.name
    assert felt.commanded_torque_mnm is None


def test_no_file_of_a_model_is_left(
    options: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "temporary").mkdir()
    monkeypatch.setenv("TMPDIR", str(tmp_path / "temporary"))
    monkeypatch.setattr("tempfile.tempdir", None)
    hc.capture(hc.Model.load(1), duration_s=1, **options)
    assert not list((tmp_path / "temporary").iterdir())


def test_what_is_left_out_is_as_the_command_line_has_it(options: dict[str, Any], tmp_path: Path) -> None:
    command = [PROGRAM, "capture", "--offline", "--duration-s", "1", "--rate-hz", "10000", "--out", tmp_path / "theirs"]
    subprocess.run(command, check=True, capture_output=True)
    [archive] = (tmp_path / "theirs").glob("*.mcap")
    ours, theirs = hc.capture(duration_s=1, **options), hc.read(archive)
    assert np.array_equal(ours.torque_mnm, theirs.torque_mnm) and ours.truth == theirs.truth
    assert ours.to_dict()["knob"] == theirs.to_dict()["knob"]


@pytest.mark.parametrize(
    "given",
    [
        {"knob": 9},
        {"knob": "missing.toml"},
        {"sweep": "--waltz"},
        {"rate_hz": -5},
        {"rate_hz": float("nan")},
        {"duration_s": 0},
        {"duration_s": "long"},
        {"arguments": ["--bogus"]},
        {"rig": "missing.toml"},
        {"out": __file__},
    ],
)
def test_what_the_program_refuses_is_an_error_in_its_words(given: dict[str, Any], options: dict[str, Any]) -> None:
    words = {"knob": 3, **options, **given}
    with pytest.raises(hc.Error) as raised:
        hc.capture(**words)
    command = [PROGRAM, "capture", "--offline", *words.get("arguments", ())]
    for name in ("knob", "sweep", "rate_hz", "duration_s", "rig", "out"):
        command += [f"--{name.replace('_', '-')}={words[name]}"] if name in words else []
    ended = subprocess.run(command, capture_output=True, text=True)
    assert f"error: {raised.value}" in ended.stderr.splitlines()


def test_what_is_no_model_is_a_wrong_type(options: dict[str, Any]) -> None:
    wrong: Any
    for wrong in (3.0, [3], None):
        with pytest.raises(TypeError, match="expected a Model, the path of one or the number of a shipped knob, not"):
            hc.replay(wrong, **options)
    wrong = "--torque"
    with pytest.raises(TypeError, match="list of words"):
        hc.capture(3, arguments=wrong, **options)


def test_what_the_program_remarks_is_a_warning(options: dict[str, Any], tmp_path: Path) -> None:
    with pytest.warns(UserWarning, match="no model: .* cannot be fitted") as warned:
        hc.capture(3, duration_s=0.02, **options)
    assert [Path(one.filename) for one in warned] == [Path(__file__)]


def test_ctrl_c_ends_a_capture_and_leaves_its_archive_whole(options: dict[str, Any], tmp_path: Path) -> None:
    def interrupt() -> None:
        while not any(path.stat().st_size > 1_000_000 for path in tmp_path.glob(".*")):
            time.sleep(0.01)
        os.kill(os.getpid(), signal.SIGINT)

    threading.Thread(target=interrupt).start()
    with pytest.raises(KeyboardInterrupt):
        hc.capture(hc.Model.load(3), duration_s=3600, **options)
    [archive] = tmp_path.glob("*.mcap")
    assert len(hc.read(archive)) > 10_000
