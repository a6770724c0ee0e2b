"""The notebooks run from end to end as they are."""

import os
from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

from conftest import PROGRAM

FOLDER = Path(__file__).resolve().parents[2] / "docs/notebooks"


@pytest.mark.parametrize("notebook", sorted(FOLDER.glob("*.ipynb")), ids=lambda path: path.stem)
def test_a_notebook_runs(notebook: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("HAPTIC_CAMERA_PROGRAM", str(PROGRAM))
    read = nbformat.read(notebook, as_version=4)
    assert all(not cell.get("outputs") for cell in read.cells), "notebooks are kept without what they print"
    NotebookClient(read, timeout=300, resources={"metadata": {"path": tmp_path}}).execute()
    outputs = [output for cell in read.cells for output in cell.get("outputs", [])]
    pictures = [output for output in outputs if "image/png" in output.get("data", {})]
    assert len(pictures) >= 2
    if kept := os.environ.get("KEEP_NOTEBOOKS_IN"):
        nbformat.write(read, Path(kept) / notebook.name)
