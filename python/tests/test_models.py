"""Models are loaded, changed, composed and saved."""

import pickle
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import haptic_camera as hc
from conftest import PROGRAM


def test_a_changed_model_is_another(tmp_path: Path) -> None:
    model = hc.Model.load(3)
    stronger = model.change(detent_amplitude=1.5)
    assert (model.parameters["detent_amplitude"], stronger.parameters["detent_amplitude"]) == (1.1, 1.5)
    assert stronger.units["detent_amplitude"] == "mNm"
    stronger.save(tmp_path / "stronger.toml")
    assert hc.Model.load(tmp_path / "stronger.toml") == stronger == pickle.loads(pickle.dumps(stronger))
    with pytest.raises(hc.Error, match="stronger.toml"):
        model.save(tmp_path / "stronger.toml")
    with pytest.raises(hc.Error, match="inertia"):
        model.change(inertia=-1)
    with pytest.raises(hc.Error, match="knob"):
        hc.Model.load(6)


def test_a_composed_model_has_the_parts_that_were_named() -> None:
    model = hc.Model.compose(inertia=2, friction=1, detents=hc.Model.load(3), extra={"backlash": 5}, name="mix")
    assert model.parameters["inertia"] == hc.Model.load(2).parameters["inertia"]
    assert model.parameters["detent_period"] == hc.Model.load(3).parameters["detent_period"]
    assert "backlash" in model.effects
    with pytest.raises(hc.Error):
        hc.Model.compose()


def test_torque_along_a_motion_is_equation_1() -> None:
    model = hc.Model.load(3)
    t = np.linspace(0, 1, 500)
    angle, velocity, acceleration = np.sin(5 * t), 5 * np.cos(5 * t), -25 * np.sin(5 * t)
    p = model.parameters
    coulomb = np.where(velocity > 0, p["coulomb_positive"], -p["coulomb_negative"])
    viscous = np.where(velocity > 0, p["viscous_positive"], p["viscous_negative"]) * velocity
    detent = p["detent_amplitude"] * np.sin(angle / p["detent_period"] + p["detent_phase"])
    torque = model.torque_mnm(t, angle, velocity, acceleration)
    assert np.allclose(torque, p["inertia"] * acceleration + coulomb + viscous + detent, rtol=0, atol=1e-12)
    with pytest.raises(hc.Error, match="length"):
        model.torque_mnm(t, angle, velocity, acceleration[1:].copy())


DRAWN = np.array([[0.0, 0.05, 0.1, 0.15, 0.2], [0.0, 6.0, 0.0, -6.0, 0.0]])


def test_drawn_detents_are_those_of_the_command_line(command_line: Callable[..., str], tmp_path: Path) -> None:
    table, out = tmp_path / "drawn.csv", tmp_path / "composed.toml"
    np.savetxt(table, DRAWN.T, delimiter=",", header="angle_rad,torque_mnm", comments="")
    command_line("compose", "--inertia", "3", "--detents", table, "--set", "table_scale=2", "--out", out)
    theirs = hc.Model.load(out)
    given: Any
    for given in (table, str(table), tuple(DRAWN), DRAWN, DRAWN.tolist()):
        ours = hc.Model.compose(inertia=3, detents=given).change(table_scale=2)
        assert ours.effects == theirs.effects and ours.parameters == theirs.parameters
        t = np.linspace(0, 1, 301)
        motion = (t, t - 0.3, t, 0 * t)
        assert np.array_equal(ours.torque_mnm(*motion), theirs.torque_mnm(*motion))
    command_line("compose", "--inertia", "3", "--detents", table, "--out", out)
    assert hc.Model.compose(inertia=3, detents=table).to_toml() == out.read_text()


def test_what_is_drawn_wrongly_is_refused_as_by_the_command_line(tmp_path: Path) -> None:
    angle, torque = DRAWN
    for name, columns in {
        "open": (angle, torque + angle),
        "falling": (-angle, torque),
        "short": (angle[:2], torque[:2]),
        "nan": (angle, torque * np.nan),
    }.items():
        table = tmp_path / f"{name}.csv"
        np.savetxt(table, np.column_stack(columns), delimiter=",", header="angle_rad,torque_mnm", comments="")
        with pytest.raises(hc.Error) as of_file:
            hc.Model.compose(detents=table)
        assert_told_by_the_command_line(of_file.value, "--detents", table)
        with pytest.raises(hc.Error) as of_columns:
            hc.Model.compose(detents=columns)
        if name != "nan":
            assert str(of_file.value) == f"{table}: {of_columns.value}"
    with pytest.raises(hc.Error, match="5 angles but 4 torques"):
        hc.Model.compose(detents=(angle, torque[1:]))
    with pytest.raises(hc.Error) as missing:
        hc.Model.compose(detents=tmp_path / "missing.csv")
    assert_told_by_the_command_line(missing.value, "--detents", tmp_path / "missing.csv")
    with pytest.raises(hc.Error) as no_inertia:
        np.savetxt(table, DRAWN.T, delimiter=",", header="angle_rad,torque_mnm", comments="")
        hc.Model.compose(inertia=table)
    assert_told_by_the_command_line(no_inertia.value, "--inertia", table)
    wrong: Any
    for wrong in ((angle,), [], (angle, torque, torque)):
        with pytest.raises(hc.Error, match="pair of columns"):
            hc.Model.compose(detents=wrong)


def assert_told_by_the_command_line(error: hc.Error, *words: str | Path) -> None:
    command = [PROGRAM, "compose", *words, "--out", "new.toml"]
    ended = subprocess.run(command, capture_output=True, text=True)
    assert ended.stderr == f"error: {error}\n"


def test_a_model_notes_what_the_command_line_notes(tmp_path: Path) -> None:
    words = ("compose", "--inertia", "2", "--friction", "1", "--detents", "3", "--out", tmp_path / "mix.toml")
    ended = subprocess.run([PROGRAM, *words], capture_output=True, text=True)
    notes = hc.Model.compose(inertia=2, friction=1, detents=3).notes
    assert ended.stderr.splitlines() == [f"note: {note}" for note in notes]
    assert any("the detents reach 1.100 mNm, less than the 150.000 mNm" in note for note in notes)


def test_a_model_of_another_axis_has_its_names_and_units() -> None:
    dome = hc.Model.load("dome")
    assert (dome.axis, hc.Model.load(3).axis) == ("linear", "rotary")
    assert dome.units["coulomb_positive"] == "N" and dome.units["inertia"] == "N s²/mm"
    assert hc.Model.from_toml(dome.to_toml()) == dome == pickle.loads(pickle.dumps(dome))


def test_wrong_types_are_reported_in_one_sentence() -> None:
    wrong: Any
    for wrong in (3.0, None, [1], True):
        with pytest.raises(TypeError, match="^expected a Model, the path of one or the number of a shipped knob, not"):
            hc.Model.load(wrong)
    for wrong in (-1, 0, 6, 10**30):
        with pytest.raises(hc.Error, match=f"there is no shipped knob {wrong}; choose 1 to 5"):
            hc.Model.load(wrong)
