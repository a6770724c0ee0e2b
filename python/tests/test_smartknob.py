"""SmartKnob's configuration is the firmware's, and what it leaves out is what is missing along a motion."""

import json
import math
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import haptic_camera as hc
from conftest import PROGRAM

MOTOR_MNM_PER_V = 12.0
STOPS = """
[[effects]]
effect = "end-stop"
stop_lower = -0.5
stop_upper = 0.7
stop_lower_stiffness = 300.0
stop_upper_stiffness = 500.0
stop_damping = 0.0
"""


def volts_of_firmware(config: dict[str, Any], centre: float, angles: np.ndarray) -> np.ndarray:
    """Volts against the hand by the law of SmartKnob's motor task, without its damping."""
    width, position = config["position_width_radians"], config["position"]
    dead = min(0.2 * width, math.radians(1))
    volts = []
    for angle in angles:
        off = angle - centre
        if off > width * config["snap_point"] and (config["num_positions"] <= 0 or position > 0):
            centre, off, position = centre + width, off - width, position - 1
        elif off < -width * config["snap_point"] and (config["num_positions"] <= 0 or position < config["num_positions"] - 1):
            centre, off, position = centre - width, off + width, position + 1
        beyond = config["num_positions"] > 0 and (
            (off > 0 and position == 0) or (off < 0 and position == config["num_positions"] - 1)
        )
        strength = config["endstop_strength_unit"] if beyond else config["detent_strength_unit"]
        volts.append(np.clip(4 * strength * (off - np.clip(off, -dead, dead)), -5, 5))
    return np.array(volts)


@pytest.mark.parametrize("stops", ["", STOPS], ids=["unbounded", "bounded"])
def test_the_configuration_and_what_it_leaves_out(
    captures: list[hc.Capture], command_line: Callable[..., str], tmp_path: Path, stops: str
) -> None:
    model = hc.Model.from_toml(hc.Model.load(3).to_toml() + stops)
    model.save(tmp_path / "model.toml")
    whole = captures[0]
    columns = [column[:6000] for column in (whole.t_s, whole.angle_rad, whole.torque_mnm)]
    hc.Capture.from_columns(*columns).save(tmp_path / "motion.csv")
    out = tmp_path / "knob.json"
    motor = ("--motor-mnm-per-v", str(MOTOR_MNM_PER_V))
    words = command_line("export", tmp_path / "model.toml", "--out", out, *motor, "--along", tmp_path / "motion.csv")
    result = json.loads(out.read_text())
    config, parameters = result["smartknob_config"], model.parameters
    period, amplitude = parameters["detent_period"], parameters["detent_amplitude"]
    assert config["position_width_radians"] == pytest.approx(2 * math.pi * period)
    assert config["detent_strength_unit"] == pytest.approx(amplitude / period / (4 * MOTOR_MNM_PER_V), rel=1e-5)
    assert config["snap_point"] == 0.5 and len(config["text"].encode()) <= 50
    # Where the sine of the detents rises through zero, at or above angle zero.
    centre = (-parameters["detent_phase"] * period) % (2 * math.pi * period)
    if stops:
        width = config["position_width_radians"]
        middles = [centre + width * n for n in range(-100, 100) if -0.5 <= centre + width * n <= 0.7]
        assert config["num_positions"] == len(middles)
        assert middles[len(middles) - 1 - config["position"]] == pytest.approx(centre)
        assert config["endstop_strength_unit"] == pytest.approx(500 / (4 * MOTOR_MNM_PER_V))
    else:
        assert config["num_positions"] == 0
    along = hc.simulate(model, tmp_path / "motion.csv")
    assert along.velocity_rad_s is not None and along.acceleration_rad_s2 is not None
    torque = model.torque_mnm(along.t_s, along.angle_rad, along.velocity_rad_s, along.acceleration_rad_s2)
    missing = torque - MOTOR_MNM_PER_V * volts_of_firmware(config, centre, along.angle_rad)
    assert result["left_out_rms_mnm"] == pytest.approx(np.sqrt(np.mean(missing**2)), rel=1e-4)
    assert f"leaves out {result['left_out_rms_mnm']:.6f} mNm RMS" in words and "- friction" in words


def test_a_motor_is_needed(tmp_path: Path) -> None:
    ended = subprocess.run([PROGRAM, "export", "3", "--out", tmp_path / "knob.json"], capture_output=True, text=True)
    assert ended.returncode == 2 and "--motor-mnm-per-v" in ended.stderr
