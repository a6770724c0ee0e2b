"""The FMU's torque along a capture's motion, by somebody else's importer, is that of `simulate`."""

from collections.abc import Callable
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.validation import validate_fmu

import haptic_camera as hc

CommandLine = Callable[..., str]
LENGTH = 6000

BRISTLES = '\n[[effects]]\neffect = "presliding-hysteresis"\nbristle_deflection = 0.05\nbristle_damping = 0.02\n'


@pytest.fixture(scope="module")
def motion(captures: list[hc.Capture]) -> hc.Capture:
    """The motion of a capture, without what is known of its rig."""
    whole = captures[0]
    columns = [column[:LENGTH] for column in (whole.t_s, whole.angle_rad, whole.torque_mnm)]
    return hc.Capture.from_columns(*columns)


def torque_mnm(fmu: Path, along: hc.Capture, start_values: dict[str, float]) -> np.ndarray:
    """The FMU's torque at every motion: that which it gives after the step that begins there."""
    names = [("time", along.t_s), ("angle", along.angle_rad), ("velocity", along.velocity_rad_s)]
    names += [("acceleration", along.acceleration_rad_s2)]
    signals = np.zeros(len(along), dtype=[(name, float) for name, _ in names])
    for name, column in names:
        signals[name] = column
    interval = float(along.t_s[-1] - along.t_s[0]) / (len(along) - 1)
    found = fmpy.simulate_fmu(
        str(fmu),
        start_time=along.t_s[0],
        stop_time=along.t_s[-1],
        output_interval=interval,
        start_values=start_values,
        input=signals,
        output=["torque"],
    )
    assert len(found) == len(along)
    return 1e3 * found["torque"][1:]


@pytest.mark.parametrize(("knob", "more"), [(3, ""), (3, BRISTLES), (5, "")], ids=["no-memory", "bristles", "backlash"])
def test_the_torque_is_ours(
    motion: hc.Capture, command_line: CommandLine, tmp_path: Path, knob: int, more: str
) -> None:
    model = hc.Model.from_toml(hc.Model.load(knob).to_toml() + more)
    model.save(tmp_path / "model.toml")
    printed = command_line("export", tmp_path / "model.toml", "--out", tmp_path / "knob.fmu")
    assert "leaves out 0.000000 mNm" in printed
    assert validate_fmu(str(tmp_path / "knob.fmu")) == []
    # No more than that: an inner body that strikes both sides of its gap is chaotic, and the last bit of the time decides.
    starts = {"detent_amplitude": 2.5}
    changed = model.change(**starts)
    for along, values in [(hc.simulate(model, motion), {}), (hc.simulate(changed, motion), starts)]:
        found = torque_mnm(tmp_path / "knob.fmu", along, values)
        assert np.abs(found - along.torque_mnm[:-1]).max() <= 1e-6 * np.abs(along.torque_mnm).max()


def test_what_turns_with_the_knob_is_a_start_value(
    motion: hc.Capture, command_line: CommandLine, tmp_path: Path
) -> None:
    command_line("export", 3, "--out", tmp_path / "knob.fmu")
    along = hc.simulate(3, motion)
    assert along.acceleration_rad_s2 is not None
    found = torque_mnm(tmp_path / "knob.fmu", along, {"added_inertia": 0.2})
    with_it = along.torque_mnm + 0.2 * along.acceleration_rad_s2
    assert np.abs(found - with_it[:-1]).max() <= 1e-6 * np.abs(with_it).max()


def test_a_value_out_of_range_and_another_version_are_refused(
    motion: hc.Capture, command_line: CommandLine, tmp_path: Path
) -> None:
    fmu = tmp_path / "knob.fmu"
    command_line("export", 3, "--out", fmu)
    along = hc.simulate(3, motion)
    with pytest.raises(fmpy.fmi1.FMICallException):
        torque_mnm(fmu, along, {"detent_period": -1.0})
    folder = Path(fmpy.extract(str(fmu), str(tmp_path / "other")))
    description = folder / "modelDescription.xml"
    description.write_text(description.read_text().replace("haptic-camera 0.", "haptic-camera 9."))
    with pytest.raises(Exception, match="instantiate"):
        torque_mnm(folder, along, {})
