"""Models are loaded, changed, composed and saved."""

import pickle
from pathlib import Path

import numpy as np
import pytest

import haptic_camera as hc


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
