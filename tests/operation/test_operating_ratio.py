"""Operating contact ratios read off pieces, against the search for every contact."""

from __future__ import annotations

import numpy as np
import pytest

from beveloid_geom.analysis.tolerance import USUAL, drawn_errors
from beveloid_geom.arrays import FloatArray, Mask
from beveloid_geom.operation import operating_ratio as module
from beveloid_geom.operation.first_contact import Grids
from beveloid_geom.operation.mesh_cycle import MeshCycle
from beveloid_geom.operation.operating_ratio import operating_ratios
from beveloid_geom.operation.pieces import Pieces, Samples
from beveloid_geom.pair.errors import mounted
from beveloid_geom.status import RatioStatus
from tests.oracle.table1 import table1

FILMS = (0.0, 0.001, 0.00635, 0.02)


@pytest.mark.parametrize(
    ("parabola", "share"), [((0.001, -0.001), 1.0), ((0.0002, 0.0002), 1.0), ((0.001, 0.001), 1.0)]
)
def test_mountings_by_pieces_are_as_by_search(
    parabola: tuple[float, float], share: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """They are told by pieces, some of which miss each other at first; all are as if searched for."""
    design, followed, given = (
        mounted(table1(parabola), drawn_errors(USUAL, 0, 0, 8)),
        [],
        module._pieces_alone,
    )

    def counted(cycle: MeshCycle, grids: Grids, samples: Samples, films: FloatArray) -> tuple[Pieces, Mask]:
        pieces, told = given(cycle, grids, samples, films)
        followed.append(told)
        return pieces, told

    def none(cycle: MeshCycle, grids: Grids, samples: Samples, films: FloatArray) -> tuple[Pieces, Mask]:
        pieces, told = given(cycle, grids, samples, films)
        return pieces, np.zeros_like(told)

    monkeypatch.setattr(module, "_pieces_alone", counted)
    by_pieces = operating_ratios(design, "right", FILMS)
    monkeypatch.setattr(module, "_pieces_alone", none)
    searched = operating_ratios(design, "right", FILMS)
    assert followed[0].mean() >= share
    both = (by_pieces.status == RatioStatus.KNOWN) & (searched.status == RatioStatus.KNOWN)
    assert both.mean() > 0.9
    np.testing.assert_allclose(by_pieces.ratio[both], searched.ratio[both], atol=2e-8)
