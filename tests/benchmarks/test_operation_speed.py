"""Speed of separations, first contacts and what stands on them, as ratios in one run.

    OPENBLAS_NUM_THREADS=1 python -m pytest tests/benchmarks/test_operation_speed.py -m benchmark -s

The reference for separations is a foot point by `scipy.optimize.root`, one point at a time, which gives
the same distance on unmodified flanks. The reference for first contacts is a search without derivatives,
as it is done on grids: the least of the approach over all teeth on 101 x 101 points, which finds it to about
a tenth of a micrometre and its place to tenths of a millimetre.

What stands on first contacts is stated in paths of contact of 101 positions, all with errors that are new
each time, by the processor's time of one core.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from time import process_time

import numpy as np
import pytest

from beveloid_geom import Design, Errors, certify, contact_pattern, first_contact, mesh_cycle, path_of_contact
from beveloid_geom.analysis.running import TOGETHER, running
from beveloid_geom.analysis.tolerance import USUAL, drawn_errors
from beveloid_geom.arrays import FloatArray
from beveloid_geom.contact.ellipse import contact_ellipse
from beveloid_geom.gear.flank import tip_parameter
from beveloid_geom.gear.tooth_side import surface_of
from beveloid_geom.operation.first_contact import middle_roll
from beveloid_geom.operation.operating_ratio import operating_ratio
from beveloid_geom.operation.separation import separation
from beveloid_geom.pair.errors import mounted
from beveloid_geom.shapes.flank_mesh import flank_mesh
from beveloid_geom.shapes.mesh_contact import mesh_contact, mesh_separation
from tests.benchmarks.timing import best, told
from tests.operation.test_separation import foot_distance
from tests.oracle.table1 import table1
from tests.shapes.test_mesh_contact import pose_at

pytestmark = pytest.mark.benchmark


@pytest.mark.parametrize("parabola", [(0.0, 0.0), (0.001, -0.001)])
def test_separation_against_foot_points(parabola: tuple[float, float]) -> None:
    design, flank, rng = table1(parabola), "right", np.random.default_rng(0)
    path = path_of_contact(design, flank, 3)
    rolls = float(path.pinion_roll[1]), float(path.gear_roll[1]) + 1e-4
    l, z = rng.uniform(-4.0, 4.0, 100_000), rng.uniform(-20.0, 20.0, 100_000)
    seconds = best(partial(separation, design, flank, 0, l, z, *rolls), 5) / l.size
    met = separation(design, flank, 0, l[:100], z[:100], *rolls)

    def feet() -> FloatArray:
        places = zip(l[:100], z[:100], met.other_l, met.other_z, strict=True)
        return np.array([foot_distance(design, flank, 0, place, rolls) for place in places])

    slow = best(feet, 2) / 100
    print(f"\na = {parabola}: {1e6 * seconds:.2f} us a point, foot points {1e6 * slow:.0f} us")
    assert np.abs(feet() - met.distance).max() < (1e-9 if parabola[0] == 0.0 else 1e-3)
    assert slow / seconds > 300.0


@pytest.mark.parametrize("parabola", [(0.0, 0.0), (0.001, -0.001), (0.0002, 0.0002)])
def test_first_contact_against_grids(parabola: tuple[float, float], flank: str) -> None:
    design = table1(parabola)
    own = surface_of(design.pinion, flank)
    roll = float(middle_roll(design, flank)) + 2.0 * np.pi / 29 * np.linspace(0.0, 1.0, 500)
    seconds = best(partial(first_contact, design, flank, roll), 3) / roll.size
    first = first_contact(design, flank, roll)
    z = own.half_width * np.linspace(-1.0, 1.0, 101)
    s = (
        own.bottom
        + (tip_parameter(design.pinion, flank, z) - own.bottom) * np.linspace(0.0, 1.0, 101)[:, None]
    )
    pairs = np.arange(-2, 3)[:, None, None]

    def grid(k: int) -> float:
        met = separation(design, flank, 0, s, z + 0.0 * s, roll[k], first.gear_roll[k], pairs)
        return float(np.where(met.inside, met.distance, np.inf).min())

    slow = best(lambda: [grid(k) for k in range(5)], 2) / 5
    least = max(grid(k) for k in range(0, 500, 100))
    print(f"\n{flank}, a = {parabola}: {1e3 * seconds:.2f} ms a position")
    print(f"grid {1e3 * slow:.1f} ms and {1e3 * least:.2f} um off")
    assert 0.0 <= least + 1e-10 < 5e-3
    assert slow / seconds > 5.0


def test_operation_in_paths_of_contact() -> None:
    """Of Table 1 with parabolas 0.001 and -0.001, right flanks."""
    design, drawn = table1((0.001, -0.001)), iter(range(1, 1000))

    def seconds(work: Callable[[Design], object], repeats: int) -> float:
        taken = []
        for _ in range(repeats):
            given = design.with_errors(Errors(1e-6 * next(drawn)))
            start = process_time()
            work(given)
            taken.append(process_time() - start)
        return min(taken)

    def path(given: Design) -> object:
        return path_of_contact(given, "right", 101)

    works: dict[str, tuple[Callable[[Design], object], float]] = {
        "mesh cycle": (mesh_cycle, 12.0),
        "operating ratio": (operating_ratio, 16.0),
        "path with its certificate": (lambda given: certify(path_of_contact(given, "right", 101)), 14.0),
        "pattern of both members": (contact_pattern, 27.0),
        "path with its ellipses": (lambda given: contact_ellipse(path_of_contact(given)), 100.0),
    }
    seconds(path, 3)
    for name, (work, most) in works.items():
        seconds(work, 1)
        ratio = seconds(work, 5) / seconds(path, 30)
        print(f"\n{name}: {ratio:.1f} paths")
        assert ratio < most, name


@pytest.mark.parametrize(
    ("parabola", "most"), [((0.001, -0.001), 4.0), ((0.0002, 0.0002), 5.0), ((0.001, 0.001), 6.0)]
)
def test_mountings_in_operation_in_paths_of_contact(parabola: tuple[float, float], most: float) -> None:
    """Each of those solved together, its operating ratio in a film included."""
    design, taken = table1(parabola), []
    for unit in range(3):
        mountings = mounted(design, drawn_errors(USUAL, 0, unit, TOGETHER))
        single = [mounted(table1((0.001, -0.001)), errors) for errors in drawn_errors(USUAL, 1, unit, 30)]
        start = process_time()
        running(mountings, "right")
        between = process_time()
        for given in single:
            path_of_contact(given, "right", 101)
        taken.append((between - start) / TOGETHER / (process_time() - between) * len(single))
    print(f"\na = {parabola}: {min(taken):.1f} paths a mounting")
    assert min(taken) < most


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
