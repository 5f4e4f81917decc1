"""Segments of a mesh cycle that are later than the first contact."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from beveloid_geom import Errors, mesh_cycle
from beveloid_geom.operation.cycle import segment_search as module
from beveloid_geom.operation.cycle.cycle_segments import CycleSegments
from beveloid_geom.operation.cycle.segment_fit import fitted
from beveloid_geom.status import FirstStatus
from tests.oracle.table1 import table1


def test_late_segments_are_not_converged(monkeypatch: pytest.MonkeyPatch) -> None:
    """Segments that are 10 nm later than the first contact are detected. All segments of the first of two
    mountings are shifted, so that its status is NOT_CONVERGED."""
    design = table1((0.001, -0.001), Errors(offset=np.array([0.0, 0.02])))
    sound = mesh_cycle(design)

    def late(*arguments: Any) -> CycleSegments:
        pieces = fitted(*arguments)
        coefficients = pieces.coefficients.copy()
        coefficients[0, pieces.case == 0, 0] += 1e-5
        return replace(pieces, coefficients=coefficients)

    monkeypatch.setattr(module, "fitted", late)
    found = mesh_cycle(design)
    assert found.status.tolist() == [FirstStatus.NOT_CONVERGED, FirstStatus.SOLVED]
    assert np.isnan([found.peak_to_peak[0], found.edge_share[0], found.mean[0]]).all()
    assert found.peak_to_peak[1] == pytest.approx(float(sound.peak_to_peak[1]), abs=1e-12)
