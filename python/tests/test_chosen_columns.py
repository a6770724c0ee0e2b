"""Files whose columns somebody names are captures like any other."""

from pathlib import Path

import numpy as np
import pytest

import haptic_camera as hc


def test_a_table_is_read_by_the_columns_that_are_named(tmp_path: Path) -> None:
    t_s = np.arange(400) / 1000
    angle, torque = 90 * np.sin(9 * t_s), 0.3 * np.cos(9 * t_s)
    table = np.column_stack([1e3 * t_s, angle, torque])
    path = tmp_path / "bench.csv"
    np.savetxt(path, table, delimiter=",", header="Zeit,Winkel,M", comments="", fmt="%.17g")
    columns: dict[str, str | int] = {"angle": "Winkel", "torque": 3, "time": "Zeit"}
    capture = hc.read(path, columns=columns, units={"angle": "deg", "torque": "Nm", "time": "ms"})
    assert np.allclose(capture.t_s, t_s, rtol=0, atol=1e-12)
    assert np.allclose(capture.angle_rad, np.deg2rad(angle), rtol=1e-12)
    assert np.allclose(capture.torque_mnm, 1e3 * torque, rtol=1e-12)
    with pytest.raises(hc.Error, match="it has no column `Kraft`; it has the columns Zeit, Winkel, M"):
        hc.read(path, columns={"angle": "Winkel", "torque": "Kraft", "time": "Zeit"})
    with pytest.raises(hc.Error, match="has no time"):
        hc.read(path, columns={"angle": "Winkel", "torque": "M"})
    # Without a time it is a curve, which has friction and detents.
    fit = hc.fit(path, columns={"angle": "Winkel", "torque": "M"}, units={"angle": "deg", "torque": "Nm"})
    assert fit.parameters["inertia"].value is None
    assert fit.parameters["coulomb_positive"].value is not None or fit.parameters["coulomb_positive"].reason
