"""Parallel axes with small tilts, which turn the common perpendicular by large angles: tilts of some
micrometres over the face hardly change the mesh."""

from __future__ import annotations

import numpy as np
import pytest

from beveloid_geom import (
    Design,
    Member,
    MeshErrors,
    Modification,
    Pair,
    Tool,
    contact_pattern,
    mesh_cycle,
    mounted_backlash,
)
from beveloid_geom.pair.misalignment_at_mesh import from_mesh


def crowned_pair(helix_angle_deg: float) -> Design:
    tool, helix = Tool(4.0, np.radians(20.0)), np.radians(helix_angle_deg)
    crowned = Modification(helix_crowning_um=10.0, profile_crowning_um=5.0)
    pinion = Member(tool, 17, helix, 0.0, 0.1, 30.0).modified(crowned)
    return Design(pinion, Member(tool, 35, -helix, 0.0, -0.1, 28.0), Pair(104.1 / np.cos(helix), 0.0))


@pytest.mark.parametrize("helix_angle_deg", [0.0, 12.0])
@pytest.mark.parametrize(("in_plane", "out_of_plane"), [(1, 1), (1, -1), (-1, 1), (0, 1), (0, -1), (1, 0.2)])
def test_small_tilts_hardly_change_the_mesh(
    helix_angle_deg: float, in_plane: float, out_of_plane: float
) -> None:
    design = crowned_pair(helix_angle_deg)
    size = np.radians(0.001)
    tilted = design.with_errors(from_mesh(design, MeshErrors(0.0, in_plane * size, out_of_plane * size)))
    for flank in ("right", "left"):
        before, after = mesh_cycle(design, flank), mesh_cycle(tilted, flank)
        assert after.peak_to_peak == pytest.approx(before.peak_to_peak, rel=2e-3)
        assert after.mean == pytest.approx(before.mean, abs=1e-6)
        assert after.edge_share == before.edge_share == 0.0
        shares = [contact_pattern(each, flank).pinion.area_share for each in (design, tilted)]
        assert shares[1] == pytest.approx(shares[0], abs=0.01)
    assert mounted_backlash(tilted).normal == pytest.approx(mounted_backlash(design).normal, abs=2e-4)
