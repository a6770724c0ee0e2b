"""Captures and the command line that every number is held against."""

import json
import os
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import haptic_camera as hc

PROGRAM = Path(os.environ.get("HAPTIC_CAMERA_PROGRAM", "target/release/haptic-camera")).resolve()


@pytest.fixture(scope="session")
def command_line() -> Callable[..., str]:
    """The command line: its words in, its standard output back."""

    def run(*words: str | Path) -> str:
        command = [str(PROGRAM), *map(str, words)]
        return subprocess.run(command, check=True, capture_output=True, text=True).stdout

    return run


@pytest.fixture(scope="session")
def as_json(command_line: Callable[..., str]) -> Callable[..., dict[str, Any]]:
    """The command line's result as JSON."""

    def run(*words: str | Path) -> dict[str, Any]:
        result: dict[str, Any] = json.loads(command_line(*words, "--json", "-"))
        return result

    return run


@pytest.fixture(scope="session")
def captures(tmp_path_factory: pytest.TempPathFactory) -> list[hc.Capture]:
    """Two captures of knob 3 by the real programs, of two motions."""
    folder = tmp_path_factory.mktemp("captures")
    return [
        hc.capture(3, duration_s=6, sweep=sweep, rate_hz=5000, offline=True, out=folder, program=PROGRAM)
        for sweep in ("linear-chirp", "multisine")
    ]
