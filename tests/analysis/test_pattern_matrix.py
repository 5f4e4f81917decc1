"""Patterns under two errors: each cell equals a single design with its errors, and so does the mirror
image."""

from __future__ import annotations

from dataclasses import replace
from math import radians

import numpy as np
import pytest

from beveloid_geom import Design, Errors, Modification, contact_pattern, mesh_cycle, mounted_backlash
from beveloid_geom.analysis.pattern_ellipse import marked_ellipse
from beveloid_geom.analysis.pattern_matrix import pattern_matrix
from beveloid_geom.analysis.tolerance import USUAL
from beveloid_geom.status import FirstStatus
from tests.oracle.table1 import table1

COARSE = 2.0


RELIEVED = Modification(helix_crowning_um=10.0, tip_relief_um=8.0, tip_relief_length_mm=2.0)


@pytest.mark.parametrize(
    ("pair", "flank"),
    [
        (table1(), "right"),
        (table1((0.001, -0.001)), "left"),
        (replace(table1(), pinion=table1().pinion.modified(RELIEVED)), "right"),
    ],
)
def test_a_cell_equals_the_single_design_with_its_errors(pair: Design, flank: str) -> None:
    design = pair.with_errors(Errors(offset=0.02, gear_axial=0.1))
    found = pattern_matrix(design, ("offset", "shaft_angle"), flank, resolution=COARSE)
    assert found.first.tolist() == [-USUAL.offset, 0.0, USUAL.offset]
    for k in (0, 3, 7):
        i, j = divmod(k, 3)
        cell = found.cells[k]
        errors = Errors(0.02 + found.first[i], float(found.second[j]), 0.0, 0.1)
        alone = design.with_errors(errors)
        cycle, backlash = mesh_cycle(alone, flank), mounted_backlash(alone)
        assert found.jammed[i, j] == backlash.jammed
        assert found.normal_backlash[i, j] == pytest.approx(float(backlash.normal), abs=1e-9)
        assert (cell is None) == bool(backlash.jammed)
        if cell is None:
            assert np.isnan(found.cycle_peak_to_peak[i, j])
            continue
        assert found.cycle_peak_to_peak[i, j] == pytest.approx(float(cycle.peak_to_peak), abs=1e-11)
        assert found.edge_share[i, j] == pytest.approx(float(cycle.edge_share), abs=1e-9)
        pattern = contact_pattern(alone, flank, resolution=COARSE)
        assert cell.pattern.pinion.area == pytest.approx(pattern.pinion.area, rel=1e-9)
        for side, ellipse in zip((pattern.pinion, pattern.gear), cell.ellipses, strict=True):
            assert vars(ellipse) == pytest.approx(vars(marked_ellipse(side, found.separation)), rel=1e-9)


def test_the_known_pair() -> None:
    """Table 1 with 0.001 / -0.001, right flanks: 1.81 arcsec without errors, a first cell that jams, and
    centres that move by more than 5 mm along the face."""
    found = pattern_matrix(table1((0.001, -0.001)), resolution=COARSE)
    assert np.degrees(found.cycle_peak_to_peak[1, 1]) * 3600.0 == pytest.approx(1.81, abs=5e-3)
    assert found.edge_share[1, 1] == pytest.approx(0.181, abs=1e-3)
    assert found.jammed.ravel().tolist() == [True] + 8 * [False]
    assert found.cells[0] is None
    centres = [cell.ellipses[0].z for cell in found.cells[3:6] if cell]
    assert centres == sorted(centres, reverse=True)
    assert centres[0] - centres[2] > 5.0  # line contact: by 0.02 deg over the face


def test_a_pair_without_a_flank_has_no_cell() -> None:
    design = table1()
    steep = replace(design.pinion, teeth=8, cone_angle=radians(20.0), profile_shift=-0.5, face_width=60.0)
    mounted = replace(design.pair, pinion_mounting=211.6, gear_mounting=210.2)
    found = pattern_matrix(replace(design, pinion=steep, pair=mounted), resolution=COARSE)
    assert (found.status == FirstStatus.UNDERCUT).all()
    assert not any(found.cells)


def test_the_backlash_of_the_matrix_of_the_other_flanks_is_used() -> None:
    design, over = table1((0.0005, -0.001)), ("shaft_angle", "gear_axial")
    left = pattern_matrix(design, over, "left", resolution=COARSE)
    right, alone = (pattern_matrix(design, over, resolution=COARSE, like=like) for like in (left, None))
    assert right.normal_backlash is left.normal_backlash
    for name in ("normal_backlash", "jammed", "cycle_peak_to_peak"):
        np.testing.assert_array_equal(getattr(right, name), getattr(alone, name))
    for other in (replace(left, over=("offset", "gear_axial")), replace(left, first=2.0 * left.first)):
        with pytest.raises(ValueError, match="same design under the same errors"):
            pattern_matrix(design, over, like=other)
    with pytest.raises(ValueError, match="same design under the same errors"):
        pattern_matrix(table1((0.0005, -0.001)), over, like=left)
