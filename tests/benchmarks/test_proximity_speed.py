"""Speed of separations, contact patterns and ellipses, as ratios in one run.

python -m pytest tests/benchmarks/test_proximity_speed.py -m benchmark -s
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import least_squares

from beveloid_geom import contact_pattern, path_of_contact
from beveloid_geom.arrays import FloatArray
from beveloid_geom.contact.ellipse import contact_ellipse
from beveloid_geom.gear.flank import flank_patch, flank_point, trace_parameter
from beveloid_geom.gear.perpendicular import feet
from beveloid_geom.operation.operating_rolls import first_contact_operation
from beveloid_geom.operation.separation import separation
from beveloid_geom.shapes.flank_mesh import flank_mesh
from beveloid_geom.shapes.mesh_contact import mesh_contact, mesh_separation
from tests.benchmarks.timing import best
from tests.oracle.table1 import table1

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
    rolls = float(path.pinion_roll[1]), float(path.gear_roll[1])

    def sample() -> None:
        flank_mesh.cache_clear()
        flank_mesh(design.pinion, "right", tolerance)

    def apart(polish: bool) -> None:
        mesh_separation(
            design, "right", 0, tolerance, pinion_roll=rolls[0], gear_roll=rolls[1], polish=polish
        )

    rows = [("sampling one flank", best(sample, 3))]
    mesh = flank_mesh(design.pinion, "right", tolerance)
    z = np.broadcast_to(mesh.grid.z, mesh.grid.l.shape)
    apart(False)
    rows.append(("separation by facets", best(lambda: apart(False), 5)))
    rows.append(("separation, polished", best(lambda: apart(True), 5)))
    exact = best(lambda: separation(design, "right", 0, mesh.grid.l, z, *rolls), 5)
    rows.append(("separation by turning to touch", exact))
    contact = best(
        lambda: mesh_contact(design, "right", tolerance, pinion_roll=rolls[0], gear_roll=rolls[1]), 5
    )
    rows.append(("contact, polished", contact))
    rows.append(("path of contact, 101 points", best(lambda: path_of_contact(design, "right"), 20)))
    print(f"\n{tolerance:g} mm, {mesh.grid.l.size} points of the pinion")
    for name, seconds in rows:
        print(f"  {name:32s} {1e3 * seconds:8.2f} ms, {seconds / exact:7.1f} times turning to touch")
    assert contact > rows[-1][1]


@pytest.mark.parametrize("parabola", [(0.0, 0.0), (0.001, -0.001), (0.001, 0.001)])
def test_pattern(parabola: tuple[float, float]) -> None:
    """A whole cycle on both flanks, against the first contact that it rests on."""
    design = table1(parabola)
    both = best(lambda: [contact_pattern(design, flank) for flank in ("right", "left")], 3)
    first = best(lambda: [first_contact_operation(design, flank) for flank in ("right", "left")], 3)
    sizes = [contact_pattern(design, flank).pinion.l.size for flank in ("right", "left")]
    print(f"\npattern, a = {parabola}: {both:.3f} s for both flanks ({sizes} points on the pinion), ", end="")
    print(f"{both / first:.1f} times its first contacts")
    assert both / first < 20.0


def test_ellipses() -> None:
    design = table1((0.001, -0.001))
    path = path_of_contact(design, "left", 10_000)
    ellipses = best(lambda: contact_ellipse(path), 5)
    whole = best(lambda: path_of_contact(design, "left", 10_000), 5)
    print(f"\n10,000 ellipses: {1e3 * ellipses:.1f} ms, {ellipses / whole:.1f} times their path of contact")
    assert ellipses / whole < 100.0
