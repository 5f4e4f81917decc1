"""Speed of feet of points and of the route by meshes, as ratios in one run.

python -m pytest tests/benchmarks/test_proximity_speed.py -m benchmark -s
"""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest
from scipy.optimize import least_squares

from beveloid_geom import path_of_contact
from beveloid_geom.arrays import FloatArray
from beveloid_geom.gear.flank import flank_patch, flank_point, trace_parameter
from beveloid_geom.gear.perpendicular import feet
from beveloid_geom.operation.separation import separation
from beveloid_geom.shapes.flank_mesh import flank_mesh
from beveloid_geom.shapes.mesh_contact import mesh_contact, mesh_separation
from tests.benchmarks.timing import best, told
from tests.oracle.table1 import table1
from tests.shapes.test_mesh_contact import pose_at

pytestmark = pytest.mark.benchmark


@pytest.mark.parametrize("parabola", [(0.0, 0.0), (0.001, -0.001)])
def test_feet_against_a_general_minimiser(parabola: tuple[float, float]) -> None:
    """The reference: scipy.optimize.least_squares on point minus flank point, one at a time."""
    member, count = table1(parabola).pinion, 8000
    random = np.random.default_rng(0)
    l, z = random.uniform(-5.0, 5.0, count), random.uniform(-25.0, 25.0, count)
    patch = flank_patch(member, "right", l, trace_parameter(member, "right", l, z))
    points = patch.point + random.uniform(-0.2, 2.0, count)[:, None] * patch.normal
    ours = best(lambda: feet(member, "right", points), 7) / count

    def searched() -> None:
        for point in points[:20]:

            def miss(x: FloatArray, point: FloatArray = point) -> FloatArray:
                return np.asarray(flank_point(member, "right", x[0], x[1]) - point)

            least_squares(miss, (0.0, 0.0), xtol=1e-12, ftol=1e-12, gtol=1e-12)

    theirs = best(searched, 3) / 20
    print(f"\nfeet, a = {parabola}: {1e6 * ours:.2f} us a point, least_squares {1e6 * theirs:.0f} us", end="")
    print(f", faster by {theirs / ours:.0f}")
    assert theirs / ours > 300.0


@pytest.mark.parametrize("tolerance", [0.01, 0.001, 0.0001])
def test_meshes_against_flanks(tolerance: float) -> None:
    design = table1((0.001, -0.001))
    path = path_of_contact(design, "right", 3)
    pose = pose_at(path, 1)

    def sample() -> None:
        flank_mesh.cache_clear()
        flank_mesh(design.pinion, "right", tolerance)

    apart = partial(mesh_separation, design, "right", 0, tolerance, **pose)
    mesh = flank_mesh(design.pinion, "right", tolerance)
    turned = partial(separation, design, "right", 0, mesh.grid.l, np.tile(mesh.grid.z, (len(mesh.grid.l), 1)))
    apart(polish=False)
    found = told(
        f"{tolerance:g} mm, {mesh.grid.l.size} points of the pinion",
        {
            "sampling one flank": (sample, 3, 1),
            "separation by facets": (partial(apart, polish=False), 5, 1),
            "separation, polished": (apart, 5, 1),
            "separation by turning to touch": (partial(turned, **pose), 5, 1),
            "contact, polished": (partial(mesh_contact, design, "right", tolerance, **pose), 5, 1),
            "path of contact, 101 points": (partial(path_of_contact, design, "right"), 20, 1),
        },
    )
    assert found["contact, polished"] > found["path of contact, 101 points"]
