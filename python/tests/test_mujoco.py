"""MuJoCo computes the torque that our model has, where its format can say it."""

import subprocess
from collections.abc import Callable
from pathlib import Path

import mujoco
import numpy as np
import pytest

import haptic_camera as hc

#: Equal, relative to the largest torque.
EQUAL = 1e-6
SI = 1e-3

#: A model that MJCF says wholly: friction differs by direction in its Coulomb part alone.
WHOLE = """
name = "whole"
[[effects]]
effect = "inertia"
inertia = 0.05
[[effects]]
effect = "friction"
coulomb_negative = 2.0
coulomb_positive = 3.0
viscous_negative = 0.1
viscous_positive = 0.1
[[effects]]
effect = "detent"
detent_amplitude = 1.5
detent_period = 0.034
detent_phase = 0.4
[[effects]]
effect = "cogging"
cogging_torque = 0.3
cogging_per_turn = 7.0
cogging_phase = 0.1
[[effects]]
effect = "mass-imbalance"
imbalance_torque = 0.7
imbalance_phase = 0.9
[[effects]]
effect = "return-spring"
spring_stiffness = 4.0
spring_centre = 0.2
[[effects]]
effect = "quadratic-drag"
drag_coefficient = 0.02
"""


class Motion:
    """A sum of sines, from which velocity and acceleration follow exactly."""

    def __init__(self) -> None:
        self.t = np.arange(0, 2, 1e-3)
        terms = [(0.8, 5.0, 0.3), (0.3, 17.0, 1.1)]
        self.angle = sum(a * np.sin(w * self.t + p) for a, w, p in terms)
        self.velocity = sum(a * w * np.cos(w * self.t + p) for a, w, p in terms)
        self.acceleration = sum(-a * w * w * np.sin(w * self.t + p) for a, w, p in terms)
        # MuJoCo's friction turns around within a step or two of the reversal.
        self.slides = np.abs(self.velocity) > 1e-3 * np.abs(self.acceleration) + 1e-3

    def of(self, model: hc.Model) -> np.ndarray:
        return model.torque_mnm(self.t, self.angle, self.velocity, self.acceleration)


def torque_of_mujoco(model: mujoco.MjModel, motion: Motion, joint: int = 0) -> np.ndarray:
    """The torque, mNm, with which the joint has to be turned along the motion."""
    data = mujoco.MjData(model)
    torque = np.empty(len(motion.t))
    for row in range(len(motion.t)):
        data.qpos[joint], data.qvel[joint] = motion.angle[row], motion.velocity[row]
        mujoco.mj_forward(model, data)
        data.qacc[joint] = motion.acceleration[row]
        mujoco.mj_inverse(model, data)
        torque[row] = (data.qfrc_inverse[joint] - data.qfrc_actuator[joint]) / SI
    return torque


def exported(command_line: Callable[..., str], model: Path, out: Path) -> tuple[mujoco.MjModel, float]:
    """The model in MuJoCo, and the torque that was said to be left out, mNm."""
    words = command_line("export", model, "--out", out)
    return mujoco.MjModel.from_xml_path(str(out)), float(words.split("leaves out ")[1].split(" mNm")[0])


def test_what_mjcf_can_say_is_equal(command_line: Callable[..., str], tmp_path: Path) -> None:
    model, motion = hc.Model.from_toml(WHOLE), Motion()
    model.save(tmp_path / "whole.toml")
    in_mujoco, left_out_mnm = exported(command_line, tmp_path / "whole.toml", tmp_path / "whole.xml")
    ours, theirs = motion.of(model), torque_of_mujoco(in_mujoco, motion)
    assert left_out_mnm == 0
    assert motion.slides.mean() > 0.9
    assert np.abs(ours - theirs)[motion.slides].max() < EQUAL * np.abs(ours).max()


@pytest.mark.parametrize("knob", [1, 2, 3, 4])
def test_what_mjcf_cannot_say_is_reported_as_torque(command_line: Callable[..., str], tmp_path: Path, knob: int) -> None:
    model = hc.Model.load(knob)
    model.save(tmp_path / "knob.toml")
    motion = Motion()
    capture = hc.Capture.from_columns(
        motion.t,
        motion.angle,
        motion.of(model),
        velocity_rad_s=motion.velocity,
        acceleration_rad_s2=motion.acceleration,
    )
    capture.save(tmp_path / "motion.csv")
    out = tmp_path / "knob.xml"
    words = command_line("export", tmp_path / "knob.toml", "--out", out, "--along", tmp_path / "motion.csv")
    told_mnm = float(words.split("leaves out ")[1].split(" mNm")[0])
    difference = motion.of(model) - torque_of_mujoco(mujoco.MjModel.from_xml_path(str(out)), motion)
    p = model.parameters
    differs = 0.5 * (p["viscous_positive"] - p["viscous_negative"]) * np.abs(motion.velocity)
    torque = np.abs(motion.of(model)).max()
    assert np.abs(difference - differs)[motion.slides].max() < EQUAL * torque
    assert told_mnm == pytest.approx(np.sqrt(np.mean(differs**2)), abs=1e-6)


def test_bristles_are_lugre(command_line: Callable[..., str], tmp_path: Path) -> None:
    text = """
    name = "bristles"
    [[effects]]
    effect = "inertia"
    inertia = 0.05
    [[effects]]
    effect = "friction"
    coulomb_negative = 2.5
    coulomb_positive = 2.5
    viscous_negative = 0.1
    viscous_positive = 0.1
    [[effects]]
    effect = "presliding-hysteresis"
    bristle_deflection = 0.05
    bristle_damping = 0.02
    """
    model, motion = hc.Model.from_toml(text), Motion()
    model.save(tmp_path / "bristles.toml")
    in_mujoco, left_out_mnm = exported(command_line, tmp_path / "bristles.toml", tmp_path / "bristles.xml")
    assert left_out_mnm == 0
    # The deflection of the bristles, exact while the knob turns one way between two rows.
    deflection, bent, data, torque = 0.05, 0.0, mujoco.MjData(in_mujoco), np.empty(len(motion.t))
    for row in range(len(motion.t)):
        turned = motion.angle[row] - motion.angle[max(row - 1, 0)]
        bent = np.sign(turned) + (bent - np.sign(turned)) * np.exp(-abs(turned) / deflection) if turned else bent
        data.qpos[0], data.qvel[0], data.act[0] = motion.angle[row], motion.velocity[row], bent * deflection
        mujoco.mj_forward(in_mujoco, data)
        data.qacc[0] = motion.acceleration[row]
        mujoco.mj_inverse(in_mujoco, data)
        torque[row] = (data.qfrc_inverse[0] - data.qfrc_actuator[0]) / SI
    ours = motion.of(model)
    assert np.abs(ours - torque).max() < EQUAL * np.abs(ours).max()


def test_a_knob_with_backlash_moves_freely_within_its_gap(command_line: Callable[..., str], tmp_path: Path) -> None:
    words = command_line("export", "5", "--out", tmp_path / "knob-5.xml")
    assert "differs by direction" in words
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "knob-5.xml"))
    half_gap = hc.Model.load(5).parameters["backlash_half_gap"]
    data = mujoco.MjData(model)
    data.qvel[0] = 1.0
    while abs(data.qpos[0] - data.qpos[1]) < 0.9 * half_gap:
        mujoco.mj_step(model, data)
        assert data.qvel[0] == 1.0
    for _ in range(2000):
        mujoco.mj_step(model, data)
        assert abs(data.qpos[0] - data.qpos[1]) < 1.5 * half_gap
    assert abs(data.qvel[0]) < 0.5


def test_urdf_has_the_friction_that_does_not_differ_by_direction(
    command_line: Callable[..., str], tmp_path: Path
) -> None:
    import json
    import xml.etree.ElementTree as xml

    words = command_line("export", "3", "--out", tmp_path / "knob.urdf")
    assert "detent" in words
    p = hc.Model.load(3).parameters
    dynamics = xml.parse(tmp_path / "knob.urdf").getroot().find("joint/dynamics")
    assert dynamics is not None
    assert float(dynamics.get("friction", "")) == pytest.approx(SI * (p["coulomb_negative"] + p["coulomb_positive"]) / 2)
    assert float(dynamics.get("damping", "")) == pytest.approx(SI * (p["viscous_negative"] + p["viscous_positive"]) / 2)
    # MuJoCo reads URDF too.
    assert mujoco.MjModel.from_xml_path(str(tmp_path / "knob.urdf")).dof_frictionloss[0] == pytest.approx(2.3e-3)
    fields = json.loads((tmp_path / "knob.isaac.json").read_text())["actuator"]
    assert fields["armature"] == pytest.approx(SI * p["inertia"])
    assert (fields["friction"], fields["dynamic_friction"]) == (pytest.approx(10e-3), pytest.approx(2.3e-3))


ROBOT = """<mujoco model="panel">
  <!-- a panel of two controls; kept as it is -->
  <worldbody>
    <body name="plate">
      <geom type="box" size="0.1 0.1 0.01"/>
      <body name="cap"><joint name="volume" type="hinge" damping="7"/><geom size="0.01" mass="1e-9"/></body>
      <body name="lever"><joint name="tilt" type="hinge" damping="3"/><geom size="0.01"/></body>
    </body>
  </worldbody>
</mujoco>
"""


def test_a_fit_is_written_into_a_joint(
    captures: list[hc.Capture], command_line: Callable[..., str], tmp_path: Path
) -> None:
    robot = tmp_path / "robot.xml"
    robot.write_text(ROBOT)
    for _ in range(2):
        command_line("fit", captures[0].source, "--into", robot, "--joint", "volume")
        model = mujoco.MjModel.from_xml_path(str(robot))
        p = hc.fit(captures[0]).model().parameters
        volume, tilt = model.joint("volume").dofadr[0], model.joint("tilt").dofadr[0]
        assert model.dof_armature[volume] == pytest.approx(SI * p["inertia"])
        assert model.dof_frictionloss[volume] == pytest.approx(SI * (p["coulomb_negative"] + p["coulomb_positive"]) / 2)
        assert (len(model.actuator_biasprm), model.nu, model.dof_damping[tilt]) == (1, 0, 3)
        assert "kept as it is" in robot.read_text()
    with pytest.raises(subprocess.CalledProcessError) as failed:
        command_line("fit", captures[0].source, "--into", robot)
    assert "it has 2 joints; name one of its joints: volume, tilt (--joint)" in failed.value.stderr
