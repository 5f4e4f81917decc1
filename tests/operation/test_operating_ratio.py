"""Contact ratios in operation from segments, compared with searches."""

from __future__ import annotations

from math import radians

import numpy as np
import pytest

from beveloid_geom import Design, Member, Pair, Tool
from beveloid_geom.analysis.tolerance import USUAL, drawn_errors
from beveloid_geom.arrays import FloatArray, Mask
from beveloid_geom.operation import operating_ratio as module
from beveloid_geom.operation.cycle.cycle_segments import CycleSegments, Samples
from beveloid_geom.operation.mesh_cycle import MeshCycle
from beveloid_geom.operation.one_pair import segments_of_one_pair
from beveloid_geom.operation.operating_ratio import operating_ratios
from beveloid_geom.operation.search.earliest_contact import Grids
from beveloid_geom.pair.misalignment import mounted
from beveloid_geom.status import RatioStatus
from tests.oracle.table1 import table1

FILMS = (0.0, 0.001, 0.00635, 0.02)


@pytest.mark.parametrize(
    ("parabola", "share"), [((0.001, -0.001), 1.0), ((0.0002, 0.0002), 1.0), ((0.001, 0.001), 1.0)]
)
def test_ratios_from_segments_and_from_searches(
    parabola: tuple[float, float], share: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Ratios from segments, some of which do not meet at first, agree with ratios from searches."""
    design, followed, given = (
        mounted(table1(parabola), drawn_errors(USUAL, 0, 0, 8)),
        [],
        segments_of_one_pair,
    )

    def counted(
        cycle: MeshCycle, grids: Grids, samples: Samples, films: FloatArray
    ) -> tuple[CycleSegments, Mask]:
        segments, reliable = given(cycle, grids, samples, films)
        followed.append(reliable)
        return segments, reliable

    def none(
        cycle: MeshCycle, grids: Grids, samples: Samples, films: FloatArray
    ) -> tuple[CycleSegments, Mask]:
        segments, reliable = given(cycle, grids, samples, films)
        return segments, np.zeros_like(reliable)

    monkeypatch.setattr(module, "segments_of_one_pair", counted)
    by_segments = operating_ratios(design, "right", FILMS)
    monkeypatch.setattr(module, "segments_of_one_pair", none)
    searched = operating_ratios(design, "right", FILMS)
    assert followed[0].mean() >= share
    both = (by_segments.status == RatioStatus.KNOWN) & (searched.status == RatioStatus.KNOWN)
    assert both.mean() > 0.9
    np.testing.assert_allclose(by_segments.ratio[both], searched.ratio[both], atol=2e-8)


def test_ratio_of_a_jammed_pair(monkeypatch: pytest.MonkeyPatch) -> None:
    """The contact ratio of a jammed pair follows from segments, without a search. A tip slides through a
    fillet over half a pitch, for which two polynomials are needed."""
    members = [
        Member(Tool(3.0, radians(20.0)), teeth, radians(helix), radians(cone), shift, face)
        for teeth, helix, cone, shift, face in (
            (34, 0.43581349551962134, -1.8736957502453788, 0.35, 40.11960341526779),
            (67, 12.635907993799083, 5.158900023185161, 0.2, 28.446205159076552),
        )
    ]
    design = Design(members[0], members[1], Pair(151.17780762901594, radians(13.508189370350545)))
    found = operating_ratios(design, "right", (0.0, 0.00635))
    assert (found.status == RatioStatus.KNOWN).all()
    np.testing.assert_allclose(found.ratio, (1.232745, 1.538959), atol=1e-6)

    def searched(*_: object) -> None:
        raise AssertionError("a ratio was searched for")

    monkeypatch.setattr(module, "searched_contacts", searched)
    np.testing.assert_array_equal(operating_ratios(design, "right", (0.0, 0.00635)).ratio, found.ratio)
