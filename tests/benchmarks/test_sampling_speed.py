"""Speed of flank sampling, as ratios in one run on the same points.

    python -m pytest tests/benchmarks -m benchmark -s

A call of `sample_flank` does everything: limits of the flank, form, number of cells, measured
deviation, points and normals. The reference is the exact formula for points and normals alone,
at the flank parameters and stations which that call has found.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from beveloid_geom import sample_flank
from beveloid_geom.shapes.sampling import flank_sheet
from tests.benchmarks.timing import told
from tests.oracle.table1 import table1

pytestmark = pytest.mark.benchmark


@pytest.mark.parametrize("parabola", [0.0, 0.001, -0.01])
def test_sampling_against_the_exact_formula(parabola: float) -> None:
    pinion = table1().pinion
    pinion = replace(pinion, tool=replace(pinion.tool, parabola=parabola))
    place = flank_sheet(pinion, "right").place
    ratios = {}
    for name, tolerance, repeat in (("1e5 points", 3e-6, 20), ("1e6 points", 3e-7, 7)):
        grid = sample_flank(pinion, "right", tolerance)
        l, z = grid.l, np.ascontiguousarray(np.broadcast_to(grid.z, grid.l.shape))
        found = told(
            f"a = {parabola}, {tolerance:g} mm",
            {
                "sampled": (partial(sample_flank, pinion, "right", tolerance), repeat, l.size),
                "exact formula": (partial(place, l, z), repeat, l.size),
            },
        )
        ratios[name] = found["exact formula"] / found["sampled"]
    assert ratios["1e5 points"] > 1.0
    assert ratios["1e6 points"] > 3.0
