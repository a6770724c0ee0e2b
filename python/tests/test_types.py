"""The stubs say what the module is, and the examples are typed by them."""

import subprocess
import sys
from pathlib import Path

import pytest

FOLDER = Path(__file__).resolve().parent.parent


def test_the_stubs_are_those_of_the_module() -> None:
    ended = subprocess.run([sys.executable, "-m", "mypy.stubtest", "haptic_camera"], capture_output=True, text=True)
    assert ended.returncode == 0, ended.stdout + ended.stderr


@pytest.mark.parametrize("folder", ["haptic_camera", "examples"])
def test_the_package_and_its_examples_are_strictly_typed(folder: str) -> None:
    command = [sys.executable, "-m", "mypy", "--config-file", str(FOLDER / "pyproject.toml"), str(FOLDER / folder)]
    ended = subprocess.run(command, capture_output=True, text=True, cwd=FOLDER.parent / "target")
    assert ended.returncode == 0, ended.stdout + ended.stderr
