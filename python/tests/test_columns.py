"""Columns are views of one memory, whoever looks at them."""

import gc
from pathlib import Path

import numpy as np
import pandas
import polars
import pyarrow
import pytest

import haptic_camera as hc


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
