"""CalculiX, in Debian's package calculix-ccx: runs, stresses, and the pair of Table 1 with narrow faces."""

from __future__ import annotations

import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from beveloid_geom import Design
from beveloid_geom.arrays import FloatArray
from tests.oracle.table1 import table1

CCX = shutil.which("ccx") or ""
with_ccx = pytest.mark.skipif(not CCX, reason="CalculiX is not installed: apt-get install calculix-ccx")


def run_ccx(deck: Path) -> None:
    """Run a deck, and assert that there are no errors and no warnings."""
    command = [CCX, "-i", deck.stem]
    done = subprocess.run(command, cwd=deck.parent, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stdout[-2000:]
    assert "*ERROR" not in done.stdout
    assert "*WARNING" not in done.stdout


def narrow(face_width: float) -> Design:
    design = table1()
    pinion, gear = (replace(one, face_width=face_width) for one in design.members)
    return replace(design, pinion=pinion, gear=gear)


def field(results: Path, name: str) -> FloatArray:
    """Return the last values (n, 6) of a named field in the result file, in the order of the node numbers."""
    found: dict[int, list[float]] = {}
    wanted = False
    for line in results.read_text().splitlines():
        if line.startswith(" -4"):
            wanted = line.split()[1] == name
        elif line.startswith(" -1") and wanted:
            found[int(line[3:13])] = [float(line[k : k + 12]) for k in range(13, 85, 12)]
    return np.array([found[node] for node in sorted(found)])


def mises(results: Path) -> FloatArray:
    """Return the von Mises stress (n,), MPa, of the nodes in the result file."""
    x, y, z, xy, yz, zx = field(results, "STRESS").T
    direct = 0.5 * ((x - y) ** 2 + (y - z) ** 2 + (z - x) ** 2)
    return np.asarray(np.sqrt(direct + 3.0 * (xy**2 + yz**2 + zx**2)))
