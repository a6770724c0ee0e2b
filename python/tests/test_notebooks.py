"""Each page of the guide has a notebook, which runs from end to end as it is and finds what it should."""

import os
from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

from conftest import PROGRAM

DOCS = Path(__file__).resolve().parents[2] / "docs"

#: What must hold in a notebook once it has run, by the page's name.
RESULTS = {
    "1-first-capture": """
        assert len(capture) + missed.sum() == 3 * 10_000
        assert abs(fit.parameters["inertia"].value / capture.truth.parameters["inertia"] - 1) < 0.02
        assert (widths.loc[16] < widths.loc[2] / 2).all()
        assert enough.t_s[-1] < 30 and all(
            100 * half < abs(hc.fit(enough).parameters[name].value)
            for name, half in hc.fit(enough).to_dict()["ci95_half_widths"].items()
            if name in widths.columns
        )
        assert len(rows) == 2 + len(durations_s) and not rows["error"].any()
    """,
    "2-your-own-knob": """
        mounted = hc.Model.load(3).parameters
        for name in names:
            assert abs(fit.parameters[name].value / mounted[name] - 1) < 0.02, name
        assert correlation[names.index("coulomb_negative"), names.index("viscous_negative")] < -0.5
        assert "at least" in str(refused)
        assert np.array_equal(again.torque_mnm, capture.torque_mnm)
        second_mnm = 2 * np.mean(points["residual_mnm"] * np.sin(4 * np.pi * points["angle_rad"] / period_rad))
        assert abs(second_mnm / 3 - 1) < 0.1, "the drawn curve's second harmonic has 3 mNm"
        for name in drawn:
            low, high = mean.parameters[name].ci95
            assert low < mounted[name] < high, name
            assert high - low < max(one.parameters[name].ci95[1] - one.parameters[name].ci95[0] for one in mean.fits)
    """,
    "3-naming-a-missing-effect": """
        for effect, one in found.items():
            expected = ("none", []) if effect == "nothing" else ("effects", [effect])
            assert (one.verdict, one.effects) == expected and one.complete, effect
            assert (over_noise[effect] > 2) == (effect != "nothing"), effect
            assert one.heldout_rms_after < 1.2 * one.noise_floor_rms, effect
        assert len(tried) > 10
        for row in how_much.dropna(subset="ci95").itertuples():
            assert row.ci95[0] <= row.mounted <= row.ci95[1], row
        assert hc.Model.load("named.toml").effects[-1] == "mass-imbalance"
    """,
    "4-composing-and-replaying": """
        for row in off.itertuples():
            if row.parameter not in ("static_negative", "static_positive"):
                assert abs(row.felt) < 2 or row.low < 0 < row.high, row
        assert "bit for bit" in recomputed
        assert turned
        swing = [part.std() for part in np.array_split(tuned.torque_mnm, 10)]
        assert max(swing[5:]) > 3 * min(swing[1:5])
        assert "cannot be rendered" in str(refused)
        assert clipped.loc["inertia", "rendered"] > clipped.loc["inertia", "asked"]
        assert abs(table["torque_mnm"].max() / 6 - 1) < 0.01
    """,
    "5-your-own-rig": """
        for name, row in found.dropna().iterrows():
            assert abs(row["value"] / row["mounted"] - 1) < 0.03, name
        assert (widths.loc[8] > 8 * widths.loc[0.5]).all()
        assert abs(calibrated["torque_zero_mnm"] - 1.7) < 0.02
        assert abs(calibrated["gripper_inertia"] / 0.02 - 1) < 0.01
        assert (lags["phase_rad"] < lags["paper_phase_rad_below"]).all()
        assert abs(again.parameters["detent_amplitude"].value / hc.Model.load(3).parameters["detent_amplitude"] - 1) < 0.02
    """,
    "6-reading-the-figures": """
        assert 0.90 < intervals["holds"].mean() < 0.99
        assert any(parameter.reason for parameter in fits[0].parameters.values())
        assert of["hides something"].to_dict()["residual_over_noise"] > 5 * of["as the model says"].to_dict()["residual_over_noise"]
        assert found.effects == ["mass-imbalance"] and found.complete
        assert max(left["with what was named"].values(), default=0) < max(left["as fitted"].values())
        assert with_gap.to_dict()["preparation"]["lost_samples"] > 400
        low, high = with_gap.parameters["inertia"].ci95
        assert low < truth["inertia"] < high
    """,
}


def test_every_page_has_its_notebook_and_names_it() -> None:
    pages = sorted((DOCS / "guide").glob("[0-9]-*.md"))
    assert [page.stem for page in pages] == sorted(path.stem for path in (DOCS / "notebooks").glob("*.ipynb")) == [*RESULTS]
    for page in pages:
        assert f"../notebooks/{page.stem}.ipynb" in page.read_text()


@pytest.mark.parametrize("name", RESULTS)
def test_a_notebook_runs_and_finds_what_it_should(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", str(PROGRAM.parent), prepend=os.pathsep)
    monkeypatch.setenv("HAPTIC_CAMERA_RUNTIME_DIR", str(tmp_path / "runtime"))
    read = nbformat.read(DOCS / f"notebooks/{name}.ipynb", as_version=4)
    assert all(not cell.get("outputs") for cell in read.cells), "notebooks are kept without what they print"
    shown = len(read.cells)
    read.cells.append(nbformat.v4.new_code_cell(f"if True:{RESULTS[name]}"))
    NotebookClient(read, timeout=300, resources={"metadata": {"path": tmp_path}}).execute()
    del read.cells[shown:]
    outputs = [output for cell in read.cells for output in cell.get("outputs", [])]
    pictures = [output for output in outputs if "image/png" in output.get("data", {})]
    assert len(pictures) >= 2
    if kept := os.environ.get("KEEP_NOTEBOOKS_IN"):
        nbformat.write(read, Path(kept) / f"{name}.ipynb")
