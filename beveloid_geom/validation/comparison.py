"""Time and error of five methods that find the contact of a flank pair.

`METHODS` lists the methods with their settings; `compare` measures each method at each setting:

- "mesh alone", "mesh, polished": proximity query on flanks sampled to a tolerance. The gear is turned until
  the least separation vanishes, which takes two to four queries; all of them count.
- "five equations": Eq. 15 of the paper, solved by SciPy's `fsolve` in Python floats without arrays
  (`validation.five_equations_math`). Each position of a run along the path starts from the previous one.
- "one equation": `path_of_contact`, which reduces the five equations to one equation in l1 and l2. One
  position is solved at a given l1; a path includes its exact ends. On flanks with a modification, this is the
  tangency of both surfaces, and the five equations are not supported.
- "first contact": `first_contact` of all teeth, edges included.

The first four methods are compared at five positions of the path of contact with the five equations solved to
60 digits (`validation.five_equations_mp`). These share with the methods only the mounting distances, and with
`five_equations_math` also the sign of the shaft angle (`hand_of_pair`). The first contact is compared at five
positions of the mesh cycle with the segments of `mesh_cycle`, which represent the cycle by polynomials in the
pinion roll. Methods with triangle meshes are not compared there: they find tangencies only, whereas a first
contact may lie on an edge.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from importlib.resources import files
from itertools import count, pairwise
from time import get_clock_info, perf_counter, process_time
from timeit import Timer
from typing import TypeAlias

import numpy as np

from ..arrays import FloatArray
from ..contact.flank_pair import is_modified
from ..contact.path import path_of_contact
from ..design.arguments import require_single
from ..design.file import builtin_design
from ..design.model import Design
from ..gear.flank import flank_patch
from ..operation.first_contact import first_contact
from ..operation.mesh_cycle import mesh_cycle
from ..pair.mounting import mounting_of
from ..shapes.proximity.mesh_contact import mesh_contact
from ..status import FirstStatus, Status
from . import five_equations_math, pitch_region

POSITION_COUNT = 5
"""Positions compared: the middles of as many equal parts of the path or of the mesh cycle."""

Answer: TypeAlias = tuple[FloatArray, FloatArray]
"""Points (POSITION_COUNT, 3) in S_f, mm, and gear rolls (POSITION_COUNT,), rad."""
Prepared: TypeAlias = tuple[Callable[[], Answer], int]
"""A call to be timed and the number of positions that it solves."""


@dataclass(frozen=True, eq=False)
class ReferencePositions:
    """Positions of a flank pair with the exact solution: `pinion_roll`, `gear_roll` (n,), rad; `l1` (n,), mm;
    `point` (n, 3) in S_f, mm; and `calls`, a counter that gives each path that is computed for
    them another number."""

    design: Design
    flank: str
    pinion_roll: FloatArray
    gear_roll: FloatArray
    l1: FloatArray
    point: FloatArray
    calls: Iterator[int] = field(default_factory=count)


@dataclass(frozen=True)
class Method:
    """A method with its `setting` and the `values` of this setting.

    `prepare(positions, value)` returns the call to be timed; `reference(design, flank)` returns the positions
    with the exact solution."""

    name: str
    setting: str
    values: tuple[float, ...]
    prepare: Callable[[ReferencePositions, float], Prepared]
    reference: Callable[[Design, str], ReferencePositions]


@dataclass(frozen=True)
class Measurement:
    """Time and error of a method at one value of its setting.

    `error_mm` and `gear_roll_error_rad` are the largest of the positions, NaN if a position was not solved;
    `status` then gives the reason, else "solved". `seconds` are the processor times per position of several
    runs: minimum, median, maximum."""

    method: str
    setting: str
    value: float
    error_mm: float
    gear_roll_error_rad: float
    seconds: tuple[float, float, float]
    status: str


def compare(
    design: Design, flank: str = "right", methods: tuple[Method, ...] = (), runs: int = 5
) -> tuple[Measurement, ...]:
    """Measure time and error of methods that find the contact of a flank pair.

    Parameters
    ----------
    design : Design
        A single design.
    flank : str
        "right" or "left".
    methods : tuple of Method
        Methods and settings; `METHODS` if empty.
    runs : int
        Number of timed runs.

    Returns
    -------
    tuple of Measurement
        One for each method and value. A method that fails is included with the reason.

    Raises
    ------
    ValueError
        If `design` is a batch, or if the flanks have no contact.
    ImportError
        If mpmath is missing; Table 1 with the paper's modification does not need it.
    """
    require_single(design)
    results, positions = [], dict[object, ReferencePositions]()
    for method in methods or METHODS:
        if method.reference not in positions:
            positions[method.reference] = method.reference(design, flank)
        exact = positions[method.reference]
        results += [_measured(method, exact, value, runs) for value in method.values]
    return tuple(results)


def _measured(method: Method, positions: ReferencePositions, value: float, runs: int) -> Measurement:
    """Time a method and compare its answer with the exact solution."""
    name, nan = (method.name, method.setting, value), float("nan")
    # Processor time, which other programs do not change; wall-clock time if the former is coarse.
    clock = process_time if get_clock_info("process_time").resolution < 1e-6 else perf_counter
    try:
        with np.errstate(all="ignore"):
            work, count = method.prepare(positions, value)
            point, roll = work()  # samples meshes and computes constants, which are cached
            timer = Timer(work, timer=clock)
            repeats = max(1, int(1e-3 / timer.timeit(1)))  # short calls are repeated for at least 1 ms
            times = np.array(timer.repeat(runs, repeats)) / (repeats * count)
    except (ArithmeticError, ValueError) as error:
        return Measurement(*name, nan, nan, (nan, nan, nan), str(error))
    away = float(np.linalg.norm(point - positions.point, axis=-1).max())
    turned = float(np.abs(roll - positions.gear_roll).max())
    lost = int(np.isnan(point.sum(axis=-1) + roll).sum())
    status = f"{lost} of {len(roll)} positions not solved" if lost else "solved"
    seconds = float(times.min()), float(np.median(times)), float(times.max())
    return Measurement(*name, away, turned, seconds, status)


def path_positions(design: Design, flank: str) -> ReferencePositions:
    """Return positions of the path of contact, solved by the five equations at 60 digits.

    The solution is stored for Table 1 with the paper's modification; mpmath computes it for other designs.
    Raises ValueError if the flanks have no contact or the equations are singular."""
    path = path_of_contact(design, flank, 2 * POSITION_COUNT + 1)
    if not path.l1.size or (path.status != Status.SOLVED).any():
        status = Status(int(path.status.max() if path.l1.size else path.ends.status))
        raise ValueError(
            f"the {flank} flanks have no contact, so that methods cannot be compared ({status.name})"
        )
    numbers = _stored(design, flank)
    if numbers is None:
        columns = (path.l1, path.u1, path.l2, path.u2, path.pinion_roll, path.gear_roll)
        numbers = solved_positions(design, flank, np.stack(columns, axis=-1)[1::2])
    return ReferencePositions(design, flank, numbers[:, 0], numbers[:, 1], numbers[:, 2], numbers[:, 3:])


def _stored(design: Design, flank: str) -> FloatArray | None:
    """Read the stored result of `solved_positions`; None for designs without one."""
    for case in json.loads((files(__package__) / "positions_of_table1.json").read_text(encoding="utf-8")):
        if case["flank"] == flank and builtin_design().with_parabola(*case["parabola"]) == design:
            return np.array(case["positions"])
    return None


def solved_positions(design: Design, flank: str, guesses: FloatArray) -> FloatArray:
    """Return pinion and gear roll (rad), l1 and the point in S_f (mm), (n, 6), solved to 60 digits.

    `guesses` (n, 6) holds l1, u1, l2, u2 (mm) and both rolls (rad); the pinion rolls are given."""
    from .five_equations_mp import solve_mp

    distance = mounting_of(design).distance
    try:
        contacts = [
            solve_mp(design, flank, guess.tolist(), ("phi1", float(guess[4])), (distance[0], distance[1]))
            for guess in guesses
        ]
    except ArithmeticError as error:
        raise ValueError(f"the five equations of the {flank} flanks have no solution: {error}") from error
    return np.array([[float(x) for x in (c.phi1, c.phi2, c.l1, *c.point)] for c in contacts])


def cycle_positions(design: Design, flank: str) -> ReferencePositions:
    """Return positions of the mesh cycle from its exact segments.

    Raises ValueError if a first contact of the cycle is not known."""
    cycle = mesh_cycle(design, flank)
    if cycle.status != FirstStatus.SOLVED:
        name = FirstStatus(int(cycle.status)).name
        raise ValueError(f"first contacts of the {flank} flanks could not be computed at all rolls ({name})")
    exact = cycle.at(cycle.start + cycle.pitch * (np.arange(POSITION_COUNT) + 0.5) / POSITION_COUNT)
    return ReferencePositions(design, flank, exact.pinion_roll, exact.gear_roll, exact.l1, exact.point)


def _by_mesh(polish: bool) -> Callable[[ReferencePositions, float], Prepared]:
    """Return the mesh method without or with Newton's method on the exact flanks after each query."""

    def prepare(positions: ReferencePositions, tolerance: float) -> Prepared:
        """Return the call for meshes of this tolerance."""

        def work() -> Answer:
            """Turn the gear to contact at all positions."""
            rolls = zip(positions.pinion_roll.tolist(), positions.gear_roll.tolist(), strict=True)
            solutions = [_turned(positions, tolerance, polish, *both) for both in rolls]
            points, gear_rolls = zip(*solutions, strict=True)
            return np.array(points), np.array(gear_rolls)

        return work, POSITION_COUNT

    return prepare


def _turned(
    positions: ReferencePositions, tolerance: float, polish: bool, pinion_roll: float, exact_roll: float
) -> tuple[FloatArray, float]:
    """Turn the gear until the sampled flanks touch; return the contact point and the gear roll.

    The search starts 1e-4 rad from the exact roll. Each step turns the gear by the least separation over the
    lever of its normal. Raises ArithmeticError if the separation does not vanish in eight steps, or if the
    flanks are nearest on an edge."""
    design, flank = positions.design, positions.flank
    limit = 1e-11 if polish else 1e-2 * tolerance  # mm
    gear_roll = exact_roll + 1e-4
    for _ in range(8):
        contact = mesh_contact(
            design, flank, tolerance, pinion_roll=pinion_roll, gear_roll=gear_roll, polish=polish
        )
        if contact.status != Status.SOLVED:
            raise ArithmeticError(
                f"the meshes give {contact.status.name} at pinion roll {pinion_roll:.4f} rad"
            )
        patch = flank_patch(design.gear, flank, contact.l[1], z=contact.z[1])
        lever = float(patch.point[0] * patch.normal[1] - patch.point[1] * patch.normal[0])
        gear_roll += contact.separation / lever
        if abs(contact.separation) <= limit:
            return contact.point, gear_roll
    raise ArithmeticError("the smallest separation is not zero within 8 turns of the gear")


def by_five_equations(
    positions: ReferencePositions, xtol: float, residual_limit: float = float("inf")
) -> Prepared:
    """Solve a run of 21 positions along the path, which includes the positions compared.

    A residual above `residual_limit` raises ArithmeticError when the call is made."""
    design, flank, distance = positions.design, positions.flank, mounting_of(positions.design).distance
    rolls = path_of_contact(design, flank, 4 * POSITION_COUNT + 1).pinion_roll.copy()
    compared = slice(2, None, 4)
    rolls[compared] = positions.pinion_roll

    def work() -> Answer:
        """Solve the run."""
        solution = five_equations_math.solve_math(
            *(design, flank, rolls, pitch_region.pitch_guess(design, flank)),
            (float(distance[0]), float(distance[1])),
            xtol=xtol,
            residual_limit=residual_limit,
        )
        point = np.where(solution.converged[:, None], solution.point, np.nan)
        return point[compared], solution.phi2[compared]

    return work, rolls.size


def _by_one_equation(positions: ReferencePositions, size: float) -> Prepared:
    """Solve single positions at given l1, or paths of 10 k + 1 positions, which include those compared.

    Paths are cached. Therefore each path is computed for a new offset error, larger than the previous one by
    one unit in the last place."""
    design, flank, step = positions.design, positions.flank, int(size) // (2 * POSITION_COUNT)
    offset = float(design.errors.offset)

    def another() -> Design:
        """Return the design with another offset error."""
        errors = replace(design.errors, offset=offset + next(positions.calls) * math.ulp(offset))
        return design.with_errors(errors)

    def single() -> Answer:
        """Solve the positions, each in a call."""
        # Only on flanks with a modification, a single position needs the path.
        each = another if is_modified(design, flank) else lambda: design
        paths = [path_of_contact(each(), flank, l1=l1) for l1 in positions.l1[:, None]]
        return np.concatenate([p.point for p in paths]), np.concatenate([p.gear_roll for p in paths])

    def path() -> Answer:
        """Solve a path."""
        contact_path = path_of_contact(another(), flank, int(size))
        compared = slice(step, None, 2 * step)
        return contact_path.point[compared], contact_path.gear_roll[compared]

    return (path, int(size)) if step else (single, POSITION_COUNT)


def _by_first_contact(positions: ReferencePositions, size: float) -> Prepared:
    """Compute the first contact at single rolls, or at `size` rolls, which begin with those compared."""
    low, high = positions.pinion_roll[[0, -1]]
    rolls = np.append(positions.pinion_roll, np.linspace(low, high, max(0, int(size) - POSITION_COUNT)))
    ends = [*range(POSITION_COUNT), POSITION_COUNT] if size < POSITION_COUNT else [0, rolls.size]

    def work() -> Answer:
        """Compute the first contacts."""
        blocks = [
            first_contact(positions.design, positions.flank, rolls[begin:end])
            for begin, end in pairwise(ends)
        ]
        points, gear_rolls = ([getattr(one, name) for one in blocks] for name in ("point", "gear_roll"))
        return np.concatenate(points)[:POSITION_COUNT], np.concatenate(gear_rolls)[:POSITION_COUNT]

    return work, rolls.size


TOLERANCES_MM = (0.1, 0.01, 0.001, 0.0003)
METHODS = (
    Method("mesh alone", "tolerance_mm", TOLERANCES_MM, _by_mesh(False), path_positions),
    Method("mesh, polished", "tolerance_mm", TOLERANCES_MM, _by_mesh(True), path_positions),
    Method("five equations", "xtol", (1e-1, 1e-4, 1e-6, 1e-8, 1e-14), by_five_equations, path_positions),
    Method(
        "one equation", "positions", (1, 11, 101, 1_001, 10_001, 100_001), _by_one_equation, path_positions
    ),
    Method("first contact", "positions", (1, 11, 101, 1_001), _by_first_contact, cycle_positions),
)
"""The methods compared. "positions" is the number of positions of a call."""
