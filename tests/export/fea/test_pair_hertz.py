"""The pair in contact in CalculiX against Hertz, and pairs of different modules against each other."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest

from beveloid_geom.contact.ellipse import relative_curvature
from beveloid_geom.contact.hertz import POISSON_RATIO, YOUNG_MPA, contact_modulus, hertz_ellipse
from beveloid_geom.contact.mesh_position import meshing_pair
from beveloid_geom.export.fea.pair_mesh import pair_mesh
from beveloid_geom.operation.certificate import path_certificate
from beveloid_geom.shapes.element_sizes import Cells
from beveloid_geom.status import Verdict
from tests.export.fea.ccx import field, with_ccx
from tests.export.fea.test_pair_deck import scaled, solved

pytestmark = [with_ccx, pytest.mark.slow]
FORCE = 8e3
"""N at module 6 mm, for an ellipse as long as the face."""


def loaded(folder: Path, module: float, cells: Cells, across: float) -> tuple[float, float, float, float]:
    """Return rotation, largest pressure, area and distance of the centre of the force from the certified
    contact for left flanks at a module. Area and distance are scaled to module 6 mm."""
    design, scale = scaled(module), module / 6.0
    pose, force = meshing_pair(design, "left"), FORCE * scale**2
    bores = (80.0 * scale, 80.0 * scale)
    pair = pair_mesh(design, pose, teeth=1, force=force, cells=cells, across=across, bore_radii=bores)
    result = solved(folder, pair, force, design)
    pressure = field(folder / "pair.frd", "CONTACT")[:, 3]
    distance = float(np.linalg.norm(result.centre[0] - pose.contact))
    return result.turn, float(pressure.max()), contact_area(folder / "pair.dat") / scale**2, distance / scale


def contact_area(printed: Path) -> float:
    """Return the area of the last contact in the output of CalculiX, mm^2."""
    [*_, last] = re.findall(r"area, +normal force.*\n\s+(\S+)", printed.read_text())
    return float(last)


def test_pressure_and_area_are_those_of_hertz(tmp_path: Path) -> None:
    """Table 1, left flanks: the largest pressure is 1.01 times Hertz's, the area 0.97 times. The centre of
    the force is near the certified contact."""
    _, pressure, area, distance = loaded(tmp_path, 6.0, Cells(1, 2, 3, 4, 6), 3.0)
    path = meshing_pair(scaled(6.0), "left").path
    assert path_certificate(path).verdict[1] == Verdict.FIRST_CONTACT
    hertz = hertz_ellipse(
        relative_curvature(path).curvature[1], FORCE, contact_modulus(YOUNG_MPA, POISSON_RATIO)
    )
    assert pressure == pytest.approx(float(hertz.pressure), rel=0.1)
    assert area == pytest.approx(np.pi * hertz.semi_axes.prod(), rel=0.1)
    assert distance < 1.0


def test_similar_pairs_have_the_same_pressure_and_rotation(tmp_path: Path) -> None:
    """Modules 0.3 to 20 mm, with torques proportional to the cube of the module and the same coarse mesh,
    give the same pressure and rotation."""
    results = [loaded(tmp_path, module, Cells(1, 2, 3, 2, 2), 1.0) for module in (6.0, 0.3, 20.0)]
    for one in results[1:]:
        np.testing.assert_allclose(one, results[0], rtol=1e-3)
