"""NaN is in no range: options refuse it by name, before anything is computed or written."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

BIN = Path(sys.executable).parent


@pytest.mark.parametrize(
    ("command", "option"),
    [
        ("beveloid-geom map", "--offset-tolerance"),
        ("beveloid-geom tolerance", "--shaft-angle-tolerance-deg"),
        ("beveloid-geom tolerance", "--sigmas"),
        ("beveloid-geom operation", "--film"),
        ("beveloid-geom optimise", "--gear-axial-tolerance"),
        ("render-report", "--pinion-axial-tolerance"),
        ("render-animation", "--fps"),
        ("render-animation", "--seconds"),
    ],
)
def test_nan_is_refused(tmp_path: Path, command: str, option: str) -> None:
    program, *rest = command.split()
    run = subprocess.run(
        [BIN / program, *rest, option, "nan"], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert (run.returncode, run.stdout) == (2, "")
    assert f"Error: Invalid value for '{option}': nan is not in the range" in run.stderr
    assert "Traceback" not in run.stderr
    assert not list(tmp_path.iterdir())
