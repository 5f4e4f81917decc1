"""Speed of separations, first contacts and results based on them, as ratios in one run.

    OPENBLAS_NUM_THREADS=1 python -m pytest tests/benchmarks/test_operation_speed.py -m benchmark -s

The reference for separations is the foot of the perpendicular by `scipy.optimize.root`, one point at a
time, which gives the same distance on unmodified flanks. The reference for first contacts is a search
without derivatives on grids: the smallest clearance over all teeth on 101 x 101 points, which has an error
of about a tenth of a micrometre in the distance and tenths of a millimetre in the position. Results based
on first contacts are compared with 101 positions of a path by the five equations in `math`
(`test_contact_speed`), in processor time of one core. Each run has new errors."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from time import process_time
from typing import Any

import numpy as np
import pytest

from beveloid_geom import (
    Design,
    Errors,
    Modification,
    contact_pattern,
    first_contact,
    mesh_cycle,
    path_certificate,
    path_of_contact,
)
from beveloid_geom.analysis.cycle_statistics import CYCLES_PER_CALL, cycle_statistics
from beveloid_geom.analysis.tolerance import USUAL, drawn_errors
from beveloid_geom.arrays import FloatArray
from beveloid_geom.contact.ellipse import contact_ellipse
from beveloid_geom.gear.flank_limits import tip_parameter
from beveloid_geom.gear.tooth_side import surface_of
from beveloid_geom.operation.angular_clearance import angular_clearance
from beveloid_geom.operation.engagement import pitch_point_roll
from beveloid_geom.operation.operating_ratio import operating_ratio
from beveloid_geom.pair.misalignment import mounted
from beveloid_geom.pair.mounting import mounting_of
from beveloid_geom.shapes.proximity.flank_mesh import flank_mesh
from beveloid_geom.shapes.proximity.mesh_contact import mesh_contact
from beveloid_geom.shapes.proximity.mesh_separation import mesh_separation
from beveloid_geom.validation.five_equations_math import solve_math
from tests.benchmarks.timing import best, timed
from tests.operation.test_angular_clearance import foot_distance
from tests.oracle.sixty_digits import numbers_of
from tests.oracle.table1 import table1
from tests.shapes.test_mesh_contact import pose_at
from tests.stability.parallel_pairs import HELICAL

pytestmark = pytest.mark.benchmark


@pytest.mark.parametrize("parabola", [(0.0, 0.0), (0.001, -0.001)])
def test_separation_against_foot_points(parabola: tuple[float, float]) -> None:
    design, flank, rng = table1(parabola), "right", np.random.default_rng(0)
    path = path_of_contact(design, flank, 3)
    rolls = float(path.pinion_roll[1]), float(path.gear_roll[1]) + 1e-4
    l, z = rng.uniform(-4.0, 4.0, 100_000), rng.uniform(-20.0, 20.0, 100_000)
    seconds = best(partial(angular_clearance, design, flank, 0, l, z, *rolls), 5) / l.size
    met = angular_clearance(design, flank, 0, l[:100], z[:100], *rolls)

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
    roll = float(pitch_point_roll(design, flank)) + 2.0 * np.pi / 29 * np.linspace(0.0, 1.0, 500)
    seconds = best(partial(first_contact, design, flank, roll), 3) / roll.size
    first = first_contact(design, flank, roll)
    z = own.half_width * np.linspace(-1.0, 1.0, 101)
    s = (
        own.bottom
        + (tip_parameter(design.pinion, flank, z) - own.bottom) * np.linspace(0.0, 1.0, 101)[:, None]
    )
    pairs = np.arange(-2, 3)[:, None, None]

    def grid(k: int) -> float:
        met = angular_clearance(design, flank, 0, s, z + 0.0 * s, roll[k], first.gear_roll[k], pairs)
        return float(np.where(met.inside, met.distance, np.inf).min())

    slow = best(lambda: [grid(k) for k in range(5)], 2) / 5
    least = max(grid(k) for k in range(0, 500, 100))
    print(f"\n{flank}, a = {parabola}: {1e3 * seconds:.2f} ms a position")
    print(f"grid {1e3 * slow:.1f} ms and {1e3 * least:.2f} um off")
    assert 0.0 <= least + 1e-10 < 5e-3
    assert slow / seconds > 5.0


def five_equations(design: Design) -> Callable[[], object]:
    """Return the solution of 101 positions of right flanks by the five equations in scalar `math`."""
    path, mounting = path_of_contact(design, "right", 101), mounting_of(design).distance
    known = numbers_of(path, 0), (float(mounting[0]), float(mounting[1]))
    return partial(solve_math, design, "right", path.pinion_roll, *known)


def test_operation_against_positions_by_five_equations() -> None:
    """Right flanks of Table 1 with the parabolas 0.001 and -0.001."""
    design, drawn = table1((0.001, -0.001)), iter(range(1, 10_000))
    five = five_equations(design)

    def new(work: Callable[[Design], object]) -> Callable[[], object]:
        return lambda: work(design.with_errors(Errors(1e-6 * next(drawn))))

    works: dict[str, tuple[Callable[[Design], object], float]] = {
        "path": (path_of_contact, 1.0 / 5.0),
        "path with its ellipses": (lambda given: contact_ellipse(path_of_contact(given)), 0.5),
        "mesh cycle": (mesh_cycle, 5.0),
        "operating ratio": (operating_ratio, 6.7),
        "path with its certificate": (
            lambda given: path_certificate(path_of_contact(given, "right", 101)),
            5.8,
        ),
        "pattern of both members": (contact_pattern, 12.5),
    }
    for name, (work, most) in works.items():
        new(work)()
        ratio = min(best(new(work), 5, process_time) / best(five, 3, process_time) for _ in range(3))
        print(f"\n{name}: {ratio:.2f} times 101 positions by the five equations")
        assert ratio < most, name


EDGES: dict[str, Any] = {f"{name}_relief_um": 15.0 for name in ("tip", "root", "heel", "toe")}
LENGTHS: dict[str, Any] = {f"{name}_relief_length_mm": 3.0 for name in ("tip", "root", "heel", "toe")}


@pytest.mark.parametrize(
    ("design", "given"),
    [
        (table1(), Modification(helix_crowning_um=10.0, profile_crowning_um=8.0, **EDGES, **LENGTHS)),
        (table1(), Modification(helix_crowning_um=5.0, tip_relief_um=10.0, tip_relief_length_mm=2.0)),
        (HELICAL, Modification(tip_relief_um=10.0, tip_relief_length_mm=1.0)),
    ],
    ids=(
        "Table 1, crowning and reliefs of all edges",
        "Table 1, crowning and tip relief",
        "helical gears on parallel axes, tip relief",
    ),
)
def test_mesh_cycle_with_reliefs_against_unmodified_flanks(design: Design, given: Modification) -> None:
    """Modifications of both members; new errors in each run."""
    drawn = iter(range(1, 10_000))
    modified = replace(design, pinion=design.pinion.modified(given), gear=design.gear.modified(given))

    def cycle(of: Design) -> object:
        return mesh_cycle(of.with_errors(Errors(1e-6 * next(drawn))))

    works = [partial(cycle, of) for of in (modified, design)]
    times = np.min([[best(work, 2, process_time) for work in works] for _ in range(8)], axis=0)
    print(f"\nmesh cycle with reliefs: {times[0] / times[1]:.2f} times that of unmodified flanks")
    assert times[0] < 2.0 * times[1]


@pytest.mark.parametrize(
    ("parabola", "most"), [((0.001, -0.001), 1.7), ((0.0002, 0.0002), 2.1), ((0.001, 0.001), 2.5)]
)
def test_mountings_in_operation_against_five_equations(parabola: tuple[float, float], most: float) -> None:
    """Time for each of the mountings that are solved together, including the operating ratio in a film,
    relative to 101 positions."""
    design, ratio = table1(parabola), np.inf
    five = five_equations(table1((0.001, -0.001)))
    for unit in range(3):
        mountings = mounted(design, drawn_errors(USUAL, 0, unit, CYCLES_PER_CALL))
        seconds = best(partial(cycle_statistics, mountings, "right"), 1, process_time) / CYCLES_PER_CALL
        ratio = min(ratio, seconds / best(five, 5, process_time))
    print(f"\na = {parabola}: {ratio:.2f} times 101 positions a mounting")
    assert ratio < most


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
    turned = partial(
        angular_clearance, design, "right", 0, mesh.grid.l, np.tile(mesh.grid.z, (len(mesh.grid.l), 1))
    )
    apart(polish=False)
    found = timed(
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
