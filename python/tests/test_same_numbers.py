"""Every number of a result is the command line's."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import haptic_camera as hc

Told = Callable[..., dict[str, Any]]


@pytest.mark.parametrize("preparation", ["automatic", "paper"])
def test_a_fit_is_that_of_the_command_line(captures: list[hc.Capture], told: Told, preparation: Any) -> None:
    fit = hc.fit(captures[0], preparation=preparation)
    assert fit.to_dict() == told("fit", captures[0].source, "--preparation", preparation)
    for name, parameter in fit.parameters.items():
        of_json = fit.to_dict()["parameters"][name]
        assert (parameter.value, parameter.unit) == (of_json["value"], of_json["unit"])
        assert parameter.ci95 == (of_json["ci95"] and tuple(of_json["ci95"]))
    assert fit.covariance.tolist() == fit.to_dict()["covariance"]["rows"]


def test_a_fit_of_several_captures_is_that_of_the_command_line(captures: list[hc.Capture], told: Told) -> None:
    fit = hc.fit(captures)
    assert fit.to_dict() == told("fit", *(capture.source for capture in captures))
    assert [one.samples for one in fit.fits] == [len(capture) for capture in captures]


def test_a_diagnosis_is_that_of_the_command_line(captures: list[hc.Capture], told: Told) -> None:
    steps: list[hc.Progress] = []
    found = hc.diagnose(captures[0], captures[1], progress=steps.append)
    assert found.to_dict() == told("diagnose", captures[0].source, "--heldout", captures[1].source)
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


def test_a_fitted_model_and_its_page_are_those_of_the_command_line(
    captures: list[hc.Capture], command_line: Callable[..., str], tmp_path: Path
) -> None:
    model, page = tmp_path / "model.toml", tmp_path / "page.html"
    command_line("fit", captures[0].source, "--out", model, "--report", page)
    fit = hc.fit(captures[0].source)
    assert fit.model().to_toml() == model.read_text()
    assert fit.to_html() == page.read_text()
    assert "<iframe" in fit._repr_html_()


def test_errors_are_the_sentences_of_the_command_line(tmp_path: Path) -> None:
    from conftest import PROGRAM
    import subprocess

    missing, short = tmp_path / "missing.mcap", tmp_path / "short.csv"
    short.write_text("t_s,angle_rad,torque_mnm\n0,0,0\n1,1,1\n2,2,2\n")
    for path in (missing, short):
        ended = subprocess.run([PROGRAM, "fit", path], capture_output=True, text=True)
        with pytest.raises(hc.Error) as raised:
            hc.fit(path)
        assert ended.stderr.strip() == f"error: {raised.value}"
