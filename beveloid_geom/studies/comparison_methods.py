"""Ways to find the contacts of a flank pair at given positions, each with a setting of its own.

They are what `comparison` compares: every function takes `Positions` and a setting and returns the
points and rolls it finds there, as well or as badly as the setting allows. What cannot be found is
NaN, or an ArithmeticError or ValueError that says why. The truth of `Positions` serves to say where
to look (pinion rolls, or l1), never what is found there; only a search by meshes starts from it, as
said at `mesh_answer`.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from importlib.resources import files
from numbers import Integral, Real
from typing import TypeAlias

import numpy as np

from ..arrays import FloatArray
from ..contact.equation import (
    Pairing,
    contact_point,
    gap_and_slope,
    meet,
    roll_angles,
    terms_of_one,
)
from ..contact.path import ContactPath, path_of_contact
from ..design.file import builtin_design
from ..design.model import Design
from ..gear.flank import flank_patch, trace_parameter
from ..pair.mounting import mounting_of
from ..reference import five_equations_math, pitch_region
from ..shapes.mesh_contact import mesh_contact
from ..status import Status

COUNT = 5
"""Positions compared: the middles of as many even parts of the path, in pinion roll."""
START_TURN = 1e-4
"""rad by which the gear stands off when a search by meshes starts."""
TURNS, TURNED, TURNED_EXACTLY = 8, 1e-2, 1e-11
"""Turns of the gear within which the least separation must vanish: to a share of the sampling
tolerance, polished to as many mm."""

Answer: TypeAlias = tuple[FloatArray, FloatArray]
"""Points (n, 3) in S_f, mm, and rolls (2, n), pinion first, rad, at the positions compared."""


@dataclass(frozen=True, eq=False)
class Positions:
    """Positions of a flank pair and the truth there, rounded to double: `pinion_roll`, `gear_roll`
    (n,), rad; `l1` (n,), mm; `point` (n, 3) in S_f, mm."""

    design: Design
    flank: str
    pinion_roll: FloatArray
    gear_roll: FloatArray
    l1: FloatArray
    point: FloatArray


Turned: TypeAlias = Callable[[Positions, float, bool, float, float], tuple[FloatArray, float]]
"""Point of contact of meshes to a tolerance, mm, polished or not, at a pinion roll, and the roll to which the
gear is turned from that given, rad."""


def numbers_in(name: str, values: object, least: int | None = None) -> None:
    """Raise TypeError for what is no row of numbers, or of whole ones where `least` is given, ValueError
    for one under `least`, or, without it, for one that is not finite and positive."""
    if isinstance(values, str) or not isinstance(values, Iterable):
        raise TypeError(f"{name} must be a tuple of numbers, got {values!r}")
    kind, what = (Real, "numbers") if least is None else (Integral, "whole numbers")
    for value in values:
        if isinstance(value, bool) or not isinstance(value, kind):
            raise TypeError(f"{name} must be {what}, got {value!r}")
        if least is None and not 0.0 < float(value) < np.inf:
            raise ValueError(f"{name} must be finite and greater than 0, got {value}")
        if least is not None and float(value) < least:
            raise ValueError(f"{name} must be at least {least}, got {value}")


def true_positions(design: Design, flank: str) -> Positions:
    """Give the positions compared, by the five equations at 60 digits: kept ones of the built-in design, else
    solved for.

    The path of contact says at which rolls, and where to start. Raises TypeError for what is no
    design, ValueError for a batch of designs, where the flanks have no contact, and where the equations
    are singular, ImportError without mpmath."""
    if not isinstance(design, Design):
        raise TypeError(f"design must be a Design, got {type(design).__name__}: read one with read_design")
    if design.batch_shape:
        raise ValueError(f"methods are compared on one design, got a batch of the shape {design.batch_shape}")
    path = path_of_contact(design, flank, 2 * COUNT + 1)
    if not path.l1.size or (path.status != Status.SOLVED).any():
        status = Status(int(path.status.max() if path.l1.size else path.ends.status))
        raise ValueError(f"the {flank} flanks have no contact to compare methods at ({status.name})")
    numbers = kept_positions(design, flank)
    if numbers is None:
        columns = (path.l1, path.u1, path.l2, path.u2, path.pinion_roll, path.gear_roll)
        numbers = solved_positions(design, flank, np.stack(columns, axis=-1)[1::2])
    return Positions(design, flank, numbers[:, 0], numbers[:, 1], numbers[:, 2], numbers[:, 3:])


def kept_positions(design: Design, flank: str) -> FloatArray | None:
    """Find what `solved_positions` gave for Table 1 without and with parabolas, so that its
    figure needs no mpmath; None for other designs. Made by `python -m tests.studies.kept_positions`."""
    for case in json.loads((files(__package__) / "positions_of_table1.json").read_text(encoding="utf-8")):
        if case["flank"] == flank and builtin_design().with_parabola(*case["parabola"]) == design:
            return np.array(case["positions"])
    return None


def solved_positions(design: Design, flank: str, guesses: FloatArray) -> FloatArray:
    """Find the pinion and gear roll (rad), l1 and the point in S_f (mm), (n, 6), at 60 digits, rounded to
    double, at the pinion rolls of `guesses` (n, 6): l1, u1, l2, u2 (mm), both rolls (rad)."""
    from ..reference.five_equations_mp import solve_mp

    distance = mounting_of(design).distance
    try:
        found = [
            solve_mp(design, flank, guess.tolist(), ("phi1", float(guess[4])), (distance[0], distance[1]))
            for guess in guesses
        ]
    except ArithmeticError as error:
        raise ValueError(f"the {flank} flanks have no truth to compare methods with: {error}") from error
    return np.array([[float(x) for x in (c.phi1, c.phi2, c.l1, *c.point)] for c in found])


def mesh_answer(positions: Positions, tolerance: float, polish: bool, turned: Turned | None = None) -> Answer:
    """Find points and rolls by proximity of flanks sampled to `tolerance` (mm), the gear turned until they
    touch, by `turned` if it is not the tangency that is looked for.

    The gear starts START_TURN off its true roll and is turned by the least separation over the
    moment of its normal, until that separation vanishes. Raises ArithmeticError where it does not,
    or where the flanks are nearest on an edge."""
    found = [
        (turned or _turned)(positions, tolerance, polish, pinion_roll, gear_roll)
        for pinion_roll, gear_roll in zip(
            positions.pinion_roll.tolist(), (positions.gear_roll + START_TURN).tolist(), strict=True
        )
    ]
    rolls = np.array([roll for _, roll in found])
    return np.array([point for point, _ in found]), np.stack((positions.pinion_roll, rolls))


def _turned(
    positions: Positions, tolerance: float, polish: bool, pinion_roll: float, gear_roll: float
) -> tuple[FloatArray, float]:
    """Give the point of contact of meshes at a pinion roll, and the gear roll to which it is turned."""
    design, flank = positions.design, positions.flank
    limit = TURNED_EXACTLY if polish else TURNED * tolerance
    for _ in range(TURNS):
        rolls = {"pinion_roll": pinion_roll, "gear_roll": gear_roll}
        found = mesh_contact(design, flank, tolerance, **rolls, polish=polish)
        if found.status != Status.SOLVED:
            raise ArithmeticError(f"the meshes give {found.status.name} at pinion roll {pinion_roll:.4f} rad")
        u = trace_parameter(design.gear, flank, found.l[1], found.z[1])
        own = flank_patch(design.gear, flank, found.l[1], u)
        gear_roll += found.separation / float(own.point[0] * own.normal[1] - own.point[1] * own.normal[0])
        if abs(found.separation) <= limit:
            return found.point, gear_roll
    raise ArithmeticError(f"the least separation does not vanish within {TURNS} turns of the gear")


def along(size: int) -> tuple[int, slice]:
    """Give the size 10 k + 1 of a path nearest to `size`, and where such a path holds the positions
    compared."""
    step = max(1, round((size - 1) / (2 * COUNT)))
    return 2 * COUNT * step + 1, slice(step, None, 2 * step)


def five_answer(positions: Positions, xtol: float, rolls: FloatArray, picked: slice, cold: bool) -> Answer:
    """Find points and rolls by the five equations as `reference.five_equations_math` has them, at pinion
    `rolls` (rad) of which `picked` are compared. From the pitch point, each of them if `cold`, else the
    first."""
    design, flank, distance = positions.design, positions.flank, mounting_of(positions.design).distance
    known = five_equations_math.solve_math(
        *(design, flank, rolls, pitch_region.pitch_guess(design, flank)),
        (float(distance[0]), float(distance[1])),
        xtol=xtol,
        cold=cold,
        residual_limit=float("inf"),
    )
    point = np.where(known.converged[:, None], known.point, np.nan)
    return point[picked], np.stack((known.phi1, known.phi2))[:, picked]


def path_answer(positions: Positions, size: int) -> Answer:
    """Find points and rolls by `path_of_contact` of `size` 10 k + 1 positions, ends included."""
    _, picked = along(size)
    return _of_path(path_of_contact(positions.design, positions.flank, size), picked)


def _of_path(path: ContactPath, picked: slice) -> Answer:
    return path.point[picked], np.stack((path.pinion_roll, path.gear_roll))[:, picked]


def batches(positions: Positions, size: int) -> list[FloatArray]:
    """Give the l1 compared, in calls of `size`; a larger call is filled up with l1 in between, behind
    them."""
    l1 = positions.l1
    if size >= COUNT:
        return [np.append(l1, np.linspace(l1.min(), l1.max(), size - COUNT))]
    return np.array_split(l1, -(-COUNT // size))


def _joined(found: list[Answer]) -> Answer:
    points, rolls = zip(*found, strict=True)
    return np.concatenate(points)[:COUNT], np.concatenate(rolls, axis=-1)[:, :COUNT]


def given_answer(positions: Positions, calls: list[FloatArray]) -> Answer:
    """Find points and rolls by `path_of_contact` at given l1, a call for each batch. Raises
    ArithmeticError with the status of positions that it does not find."""
    paths = [path_of_contact(positions.design, positions.flank, l1=l1) for l1 in calls]
    point, roll = _joined([_of_path(path, slice(None)) for path in paths])
    lost = np.isnan(point).any(axis=-1)
    if lost.any():
        codes = np.concatenate([path.status for path in paths])[:COUNT][lost]
        names = ", ".join(Status(code).name for code in np.unique(codes).tolist())
        raise ArithmeticError(f"{lost.sum()} of {COUNT} positions not found by their l1 ({names})")
    return point, roll


def newton_answer(pairing: Pairing, calls: list[FloatArray], iterations: int) -> Answer:
    """Find points and rolls by Newton on F(l1, l2) = 0 for l2 from the middle of the gear's flank, a call
    for each batch, without any safeguard: where it arrives, whether F is 0 there or not."""
    return _joined([_newton(pairing, l1, iterations) for l1 in calls])


def _newton(pairing: Pairing, l1: FloatArray, iterations: int) -> Answer:
    start = 0.5 * (pairing.lowest[1] + pairing.highest[1])
    l = np.stack((l1[None], np.broadcast_to(start, (1, l1.size))))
    for _ in range(iterations):
        gap, slope = gap_and_slope(pairing, terms_of_one(pairing, l[0], 0), l[1])
        l[1] -= gap / slope
    met = meet(pairing, l)
    return contact_point(met)[:, 0].T, roll_angles(pairing, met)[:, 0]
