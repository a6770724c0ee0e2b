"""Every number of a result is the command line's."""

import json
import pickle
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import haptic_camera as hc
from conftest import PROGRAM

AsJson = Callable[..., dict[str, Any]]


@pytest.mark.parametrize("preparation", ["automatic", "paper"])
def test_a_fit_is_that_of_the_command_line(captures: list[hc.Capture], as_json: AsJson, preparation: Any) -> None:
    fit = hc.fit(captures[0], preparation=preparation)
    assert fit.to_dict() == as_json("fit", captures[0].source, "--preparation", preparation)
    for name, parameter in fit.parameters.items():
        of_json = fit.to_dict()["parameters"][name]
        assert (parameter.value, parameter.unit) == (of_json["value"], of_json["unit"])
        assert parameter.ci95 == (of_json["ci95"] and tuple(of_json["ci95"]))
    assert fit.covariance.tolist() == fit.to_dict()["covariance"]["rows"]


def test_a_fit_of_several_captures_is_that_of_the_command_line(captures: list[hc.Capture], as_json: AsJson) -> None:
    fit = hc.fit(captures)
    assert fit.to_dict() == as_json("fit", *(capture.source for capture in captures))
    assert [one.samples for one in fit.fits] == [len(capture) for capture in captures]


def test_a_diagnosis_is_that_of_the_command_line(captures: list[hc.Capture], as_json: AsJson) -> None:
    steps: list[hc.Progress] = []
    found = hc.diagnose(captures[0], captures[1], progress=steps.append)
    assert found.to_dict() == as_json("diagnose", captures[0].source, "--heldout", captures[1].source)
    assert steps and all(step.done <= step.of for step in steps)


@pytest.mark.parametrize("drive", ["motion", "torque"])
def test_a_simulation_is_that_of_the_command_line(
    captures: list[hc.Capture], command_line: Callable[..., str], tmp_path: Path, drive: Any
) -> None:
    model, out = tmp_path / "model.toml", tmp_path / "simulated.mcap"
    hc.Model.load(3).save(model)
    command_line("simulate", model, "--like", captures[0].source, "--drive", drive, "--out", out)
    ours, theirs = hc.simulate(3, captures[0], drive=drive), hc.read(out)
    assert np.array_equal(ours.torque_mnm, theirs.torque_mnm)
    assert np.array_equal(ours.angle_rad, theirs.angle_rad)
    assert ours.truth == theirs.truth == hc.Model.load(3)
    # The gripper turns with the knob in both.
    assert hc.fit(ours).parameters == hc.fit(theirs).parameters
    ours.save(tmp_path / "saved.mcap")
    assert hc.fit(tmp_path / "saved.mcap").parameters == hc.fit(theirs).parameters


def test_a_replay_is_recomputed_bit_for_bit_and_refused_by_the_command_line(
    command_line: Callable[..., str], tmp_path: Path
) -> None:
    rig = tmp_path / "rig.toml"
    rig.write_text('name = "bench"\ndriver = "simulated"\n')
    options: Any = {"rig": rig, "offline": True, "out": tmp_path, "program": PROGRAM}
    felt = hc.replay(3, hand="multisine", grip=6, duration_s=2, rate_hz=5000, **options)
    assert (felt.truth, felt.rate_hz, felt.to_dict()["rig"]) == (hc.Model.load(3), 5000, "bench")
    assert "every torque command, bit for bit" in command_line("recompute", felt.source)
    another = hc.simulate(4, felt)
    another.save(tmp_path / "another.mcap")
    read = hc.read(tmp_path / "another.mcap")
    assert another.truth == read.truth == hc.Model.load(4)
    assert np.array_equal(another.torque_mnm, read.torque_mnm)
    assert hc.fit(another).parameters == hc.fit(read).parameters
    ended = subprocess.run([PROGRAM, "replay", "5", "--offline"], capture_output=True, text=True)
    with pytest.raises(hc.Error) as raised:
        hc.replay(5, **options)
    assert f"error: {raised.value}" in ended.stderr.splitlines()


def test_a_fitted_model_and_its_page_are_those_of_the_command_line(
    captures: list[hc.Capture], command_line: Callable[..., str], tmp_path: Path
) -> None:
    model, page = tmp_path / "model.toml", tmp_path / "page.html"
    command_line("fit", captures[0].source, "--out", model, "--report", page)
    fit = hc.fit(captures[0].source)
    assert fit.model().to_toml() == model.read_text()
    assert fit.to_html() == page.read_text()
    assert "<iframe" in fit._repr_html_()


@pytest.fixture(scope="module")
def turned(tmp_path_factory: pytest.TempPathFactory) -> list[hc.Capture]:
    """Knob 3 turned slowly there and back, twice."""
    folder = tmp_path_factory.mktemp("turned")
    options: Any = {"sweep": "slow-turn", "rate_hz": 5000, "offline": True, "out": folder, "program": PROGRAM}
    return [hc.capture(3, duration_s=duration_s, **options) for duration_s in (20, 25)]


def pressed(folder: Path, collapse_n: float) -> Path:
    """A made-up dome as a table with columns of another name, in cm and gf."""
    travel_mm = np.concatenate([np.linspace(0, 3.5, 700), np.linspace(3.5, 0, 700)])
    bump = collapse_n * np.exp(-(((travel_mm - 1) / 0.8) ** 2)) + 20 * np.maximum(travel_mm - 3, 0) ** 2
    friction = np.where(np.arange(1400) < 700, 0.0, -0.03)
    force_n = 0.05 * travel_mm + bump + friction + 5e-4 * np.sin(12.9898 * np.arange(1400))
    path = folder / f"dome-{collapse_n}.csv"
    table = np.column_stack([0.1 * travel_mm, force_n / 9.80665e-3])
    np.savetxt(path, table, delimiter=",", header="Weg,Kraft", comments="")
    return path


COLUMNS: dict[str, Any] = {"columns": {"travel": "Weg", "force": 2}, "units": {"travel": "cm", "force": "gf"}}
WORDS = ("--columns", "travel=Weg,force=2", "--units", "travel=cm,force=gf")


def test_a_sheet_is_that_of_the_command_line(
    turned: list[hc.Capture], as_json: AsJson, command_line: Callable[..., str], tmp_path: Path
) -> None:
    domes = [pressed(tmp_path, 0.6), pressed(tmp_path, 0.61)]
    for sheet, words in [
        (hc.sheet(turned[0]), (turned[0].source,)),
        (hc.sheet(turned), tuple(capture.source for capture in turned)),
        (hc.sheet(turned[0], dynamic=turned), (turned[0].source, *(word for one in turned for word in ("--dynamic", one.source)))),
        (hc.sheet(domes, **COLUMNS), (*domes, *WORDS)),
    ]:
        of_json = as_json("sheet", *words)
        assert sheet.to_dict() == of_json
        assert {*sheet.figures} == {*of_json["figures"]} and sheet.runs == of_json["runs"]
        for name, figure in sheet.figures.items():
            expected = of_json["figures"][name]
            found = (figure.value, figure.unit, figure.definition, figure.source, figure.reason)
            assert found == (*(expected[key] for key in ("value", "unit", "definition", "source")), expected.get("reason"))
            assert figure.ci95 == (expected["ci95"] and tuple(expected["ci95"]))
    assert pickle.loads(pickle.dumps(sheet.figures)) == sheet.figures
    assert (hc.sheet(turned).axis, hc.sheet(domes, **COLUMNS).axis) == ("rotary", "linear")
    command_line("sheet", turned[0].source, "--report", tmp_path / "page.html")
    assert hc.sheet(turned[0].source).to_html() == (tmp_path / "page.html").read_text()


def test_a_verdict_is_that_of_the_command_line(turned: list[hc.Capture], tmp_path: Path) -> None:
    good, weak = pressed(tmp_path, 0.6), pressed(tmp_path, 0.4)
    for name, spec, units, words in [
        ("turned", "[figures.peak_torque]\nmin = 1.0\nmax = 9.0\n", turned, ()),
        ("pressed", "name = 'dome'\n[figures.collapse_force]\nmin = 55\nmax = 75\nunit = 'gf'\n", [good, weak], WORDS),
    ]:
        limits, page, verdicts = (tmp_path / f"{name}.{ending}" for ending in ("toml", "html", "json"))
        limits.write_text(spec)
        given = [unit.source if isinstance(unit, hc.Capture) else unit for unit in units]
        command = [PROGRAM, "judge", *given, "--spec", limits, "--report", page, "--json", verdicts, *words]
        status = subprocess.run(command).returncode
        judgement = hc.judge(units, limits, **(COLUMNS if words else {}))
        assert judgement.to_dict() == json.loads(verdicts.read_text())
        assert judgement.to_html() == page.read_text()
        assert status == {"pass": 0, "fail": 4, "undecided": 5}[judgement.verdict]
        of_json = judgement.to_dict()["units"]
        assert [[one.unit, one.verdict, one.reasons] for one in judgement.units] == [
            [one["unit"], one["verdict"], one["reasons"]] for one in of_json
        ]
    assert [pickle.loads(pickle.dumps(unit)) for unit in judgement.units] == judgement.units
    sheet = hc.sheet(good, **COLUMNS)
    assert hc.judge(sheet, tmp_path / "pressed.toml").to_dict()["units"] == of_json[:1]


def test_errors_are_the_sentences_of_the_command_line(captures: list[hc.Capture], tmp_path: Path) -> None:
    missing, short, empty = tmp_path / "missing.mcap", tmp_path / "short.csv", tmp_path / "empty"
    short.write_text("t_s,angle_rad,torque_mnm\n0,0,0\n1,1,1\n2,2,2\n")
    spec, dome, archive = tmp_path / "spec.toml", tmp_path / "dome.toml", captures[0].source
    hc.Model.load("dome").save(dome)
    empty.mkdir()
    spec.write_text("risk = 0.01\n")
    for words, call in [
        (["fit", missing], lambda: hc.fit(missing)),
        (["fit", short], lambda: hc.fit(short)),
        (["diagnose", archive, "--model", dome], lambda: hc.diagnose(archive, model=dome)),
        (["simulate", dome, "--like", archive], lambda: hc.simulate(dome, archive)),
        (["sheet", missing], lambda: hc.sheet(missing)),
        (["sheet", archive], lambda: hc.sheet(archive)),
        (["sheet", empty], lambda: hc.sheet(empty)),
        (["judge", archive, "--spec", missing], lambda: hc.judge(archive, missing)),
        (["judge", archive, "--spec", spec], lambda: hc.judge(archive, spec)),
    ]:
        ended = subprocess.run([PROGRAM, *words], capture_output=True, text=True)
        with pytest.raises(hc.Error) as raised:
            call()
        assert ended.stderr.strip() == f"error: {raised.value}"
