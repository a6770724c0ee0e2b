"""Columns are views of one memory, whoever looks at them."""

import copy
import gc
import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas
import polars
import pyarrow
import pytest

import haptic_camera as hc
from conftest import PROGRAM


def address(array: np.ndarray) -> int:
    place: int = array.__array_interface__["data"][0]
    return place


def test_numpy_arrow_and_polars_look_at_one_memory(captures: list[hc.Capture]) -> None:
    capture = captures[0]
    table = pyarrow.table(capture)
    batch = pyarrow.record_batch(capture)
    frame = polars.DataFrame(capture)
    assert table.column_names == batch.schema.names == frame.columns == capture.columns
    for name in capture.columns:
        column = getattr(capture, name)
        assert not column.flags.writeable and len(column) == len(capture)
        assert address(column) == address(getattr(capture, name))
        assert address(column) == table[name].chunk(0).buffers()[1].address
        assert address(column) == batch[name].buffers()[1].address
        assert address(column) == address(frame[name].to_numpy(allow_copy=False))


def test_pandas_takes_a_capture(captures: list[hc.Capture]) -> None:
    frame = pandas.DataFrame.from_arrow(captures[0])
    assert list(frame.columns) == captures[0].columns
    assert np.array_equal(frame["torque_mnm"], captures[0].torque_mnm)


def test_units_and_rate_travel_with_the_columns(captures: list[hc.Capture]) -> None:
    schema = pyarrow.schema(captures[0])
    assert schema.field("torque_mnm").metadata == {b"unit": b"mNm"}
    assert float(schema.metadata[b"rate_hz"]) == captures[0].rate_hz


def test_a_column_outlives_its_capture(captures: list[hc.Capture]) -> None:
    column = hc.read(captures[0].source).torque_mnm
    table = pyarrow.table(hc.read(captures[0].source))
    gc.collect()
    assert np.array_equal(column, captures[0].torque_mnm)
    assert np.array_equal(table["torque_mnm"], captures[0].torque_mnm)


def test_the_points_of_a_fit_are_a_view(captures: list[hc.Capture]) -> None:
    points = hc.fit(captures[0]).points
    residual = points["torque_mnm"] - points["torque_model_mnm"]
    assert np.allclose(residual, points["residual_mnm"], rtol=0, atol=1e-9)
    assert points["torque_mnm"].base is not None and not points["torque_mnm"].flags.writeable


def test_columns_of_ones_own_give_the_fit_of_their_table(captures: list[hc.Capture], tmp_path: Path) -> None:
    capture = captures[0]
    own = hc.Capture.from_columns(capture.t_s, capture.angle_rad, capture.torque_mnm, name="own.csv")
    own.save(tmp_path / "own.csv")
    assert hc.fit(own).to_dict() == hc.fit(tmp_path / "own.csv").to_dict()
    with pytest.raises(hc.Error, match="rows"):
        hc.Capture.from_columns(capture.t_s, capture.angle_rad[1:].copy(), capture.torque_mnm)


def test_a_saved_table_keeps_what_is_known_of_the_rig(captures: list[hc.Capture], tmp_path: Path) -> None:
    capture = captures[0]
    capture.save(tmp_path / "saved.csv")
    [whole, saved] = [hc.fit(source).parameters["inertia"] for source in (capture, tmp_path / "saved.csv")]
    assert whole.value is not None and whole.ci95 is not None and saved.value is not None
    assert whole.ci95[0] <= saved.value <= whole.ci95[1]


def test_columns_are_whatever_numpy_makes_arrays_of() -> None:
    t_s, angle, torque = [0, 1, 2], [0.5, 0.25, 0], [1, 2, 3]
    expected = np.array(torque, dtype=float)
    given: Any
    for given in (list, tuple, np.array, np.float32, pandas.Series, polars.Series, lambda column: np.repeat(column, 2)[::2]):
        own = hc.Capture.from_columns(given(t_s), given(angle), given(torque))
        assert np.array_equal(own["torque_mnm"], expected) and own.torque_mnm.dtype == float
    for given, sentence in [
        ([[0], [1], [2]], r"one dimension, but this array has the shape \(3, 1\)"),
        (1.0, r"one dimension, but this array has the shape \(\)"),
        ([], "t_s has 3 rows, but angle_rad has 0"),
        ([0, 1], "t_s has 3 rows, but angle_rad has 2"),
        ([0, None, 1], "row 2: angle_rad is NaN"),
        ([0, float("inf"), 1], "row 2: angle_rad is inf"),
    ]:
        with pytest.raises(hc.Error, match=sentence):
            hc.Capture.from_columns(t_s, given, torque)
    with pytest.raises(ValueError):
        hc.Capture.from_columns(t_s, ["a", "b", "c"], torque)


def test_columns_are_had_by_name(captures: list[hc.Capture]) -> None:
    capture = captures[0]
    for name in capture.columns:
        assert name in capture and address(capture[name]) == address(getattr(capture, name))
    assert "force_n" not in capture
    with pytest.raises(KeyError, match="no column 'torque'; the capture has seq, tick"):
        capture["torque"]


@pytest.fixture(scope="module")
def pressed(tmp_path_factory: pytest.TempPathFactory) -> hc.Capture:
    folder, arguments = tmp_path_factory.mktemp("pressed"), ["--apparatus", "sim-linear"]
    return hc.capture(duration_s=3, rate_hz=5000, offline=True, out=folder, arguments=arguments, program=PROGRAM)


def test_what_is_pressed_has_the_names_and_units_of_its_axis(
    pressed: hc.Capture, as_json: Callable[..., dict[str, Any]], tmp_path: Path
) -> None:
    assert pressed.axis == "linear" and pressed.truth == hc.Model.load("dome")
    assert np.array_equal(pressed["force_n"], pressed.torque_mnm)
    own = hc.Capture.from_columns(pressed.t_s, pressed["travel_mm"], pressed["force_n"], axis="linear", name="own.csv")
    own.save(tmp_path / "own.csv")
    assert np.array_equal(hc.read(tmp_path / "own.csv")["force_n"], pressed["force_n"])
    fit = hc.fit(pressed)
    assert fit.to_dict() == as_json("fit", pressed.source)
    assert {*fit.parameters} == {*fit.to_dict()["parameters"]}
    assert fit.covariance_order == fit.to_dict()["covariance"]["order"]
    for name, parameter in fit.parameters.items():
        assert parameter.unit == fit.to_dict()["parameters"][name]["unit"]
    assert "force_n" in fit.points and "mNm" not in repr(fit) + repr(fit.parameters)
    assert hc.fit([pressed, pressed]).to_dict() == as_json("fit", pressed.source, pressed.source)
    with pytest.raises(hc.Error, match="of a control with a rotary axis"):
        hc.simulate(3, pressed)


def test_a_capture_is_saved_as_its_name_says(captures: list[hc.Capture], tmp_path: Path) -> None:
    captures[0].save(tmp_path / "whole.MCAP")
    assert np.array_equal(hc.read(tmp_path / "whole.MCAP").torque_mnm, captures[0].torque_mnm)
    for name in ("table.parquet", "nothing"):
        with pytest.raises(hc.Error, match=f"{name} has none of the endings .* name the file .mcap or .csv"):
            captures[0].save(tmp_path / name)
        assert not (tmp_path / name).exists()
    with pytest.raises(hc.Error, match="whole.MCAP is there already; choose another name"):
        captures[0].save(tmp_path / "whole.MCAP")
    with pytest.raises(hc.Error, match=r"away.csv cannot be written \(there is no such folder\); choose another place$"):
        captures[0].save(tmp_path / "far" / "away.csv")


def test_small_results_are_pickled_and_large_ones_say_what_is(captures: list[hc.Capture]) -> None:
    fit = hc.fit(captures[0])
    assert pickle.loads(pickle.dumps(fit.parameters)) == fit.parameters == copy.deepcopy(fit.parameters)
    with pytest.raises(hc.Error, match="a fit is not pickled; hand on its parameters"):
        pickle.dumps(fit)
    with pytest.raises(hc.Error, match="a capture is not pickled; hand on its path"):
        pickle.dumps(captures[0])
    assert pickle.loads(pickle.dumps(hc.Error("why"))).args == ("why",)
    wrong: Any
    for wrong in (3, None, [3], captures[0].torque_mnm):
        with pytest.raises(TypeError, match="^expected a Capture or the path of one, not"):
            hc.fit(wrong)
    assert hc.fit(iter(captures)).samples == hc.fit(captures).samples
