"""Accuracy of four methods near the smallest shaft angle at which two flanks have a common normal.

The normals of unmodified flanks have a constant angle to the axis of their member. A common normal exists if
the shaft angle is at least the difference of these angles. At this smallest shaft angle the common normal is
perpendicular to the common perpendicular of the axes (n_x = 0). Above it, n_x grows with the square root of
the distance, and rounding errors of the contact point are proportional to 1/n_x^2. Below it, there is no
contact.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from ..arrays import Codes, FloatArray, Integers
from ..contact.path import path_of_contact
from ..design.model import Design
from ..gear.rack import rack_of
from ..pair.mounting import mounting_of
from ..pair.zero_backlash import closing_offset
from ..shapes.proximity.mesh_contact import mesh_contact
from ..status import Status
from . import five_equations_math
from .comparison import ReferencePositions, by_five_equations, path_positions
from .five_equations import path_of_contact_five_equations

Answer: TypeAlias = tuple[FloatArray, FloatArray, str]
"""Points (n, 3) in S_f and bounds (n,) of their errors as the method states them, NaN if it states none, mm;
reason for missing points."""


@dataclass(frozen=True, eq=False)
class MethodErrors:
    """Errors of each of `METHODS` at distances from the smallest shaft angle.

    Attributes
    ----------
    above : ndarray, shape (n,)
        Shaft angle minus the smallest one, rad.
    offset : ndarray, shape (n,)
        Offset without backlash at this shaft angle, mm; NaN if there is none.
    error : ndarray, shape (methods, n)
        Largest distance of the contact point from the solution at 60 digits, mm; NaN without a point.
    stated : ndarray, shape (methods, n)
        Largest error bound that the method states itself, mm; NaN if it states none.
    reason : tuple of tuple of str
        Reason for a missing point, by method and distance, else empty.
    """

    above: FloatArray
    offset: FloatArray
    error: FloatArray
    stated: FloatArray
    reason: tuple[tuple[str, ...], ...]


def smallest_shaft_angle(design: Design, flank: str) -> float:
    """Return the smallest shaft angle at which unmodified flanks have a common normal.

    Parameters
    ----------
    design : Design
        A single design.
    flank : {'right', 'left'}

    Returns
    -------
    float
        rad.
    """
    first, second = (float(rack_of(member, flank).normal[2]) for member in design.members)
    return float(abs(np.arccos(first) - np.arccos(-second)))


def at_shaft_angle(design: Design, shaft_angle: float) -> Design:
    """Return the unmodified pair without errors at a shaft angle (rad) and the offset without backlash.

    Raises ValueError if there is no offset without backlash."""
    plain = design.bare()
    turned = replace(plain, pair=replace(plain.pair, shaft_angle=shaft_angle))
    offset = closing_offset(turned)
    if not np.isfinite(offset):
        raise ValueError("no offset without backlash")
    return replace(turned, pair=replace(turned.pair, offset=offset))


def errors_above_smallest_shaft_angle(
    design: Design, flank: str, above: Sequence[float] | FloatArray
) -> MethodErrors:
    """Compute the errors of four methods at distances from the smallest shaft angle.

    Parameters
    ----------
    design : Design
        A single design with axes that are not parallel.
    flank : {'right', 'left'}
    above : sequence of float
        Shaft angles minus the smallest one, rad. The offset is the one without backlash.

    Returns
    -------
    MethodErrors

    Raises
    ------
    ImportError
        If mpmath is missing.
    """
    lowest, distances = smallest_shaft_angle(design, flank), np.asarray(above, dtype=float)
    count = len(distances)
    offset = np.full(count, np.nan)
    error, stated = np.full((2, len(METHODS), count), np.nan)
    reason = [[""] * count for _ in METHODS]
    for k, distance in enumerate(distances.tolist()):
        try:
            placed = at_shaft_angle(design, lowest + distance)
            offset[k] = placed.pair.offset
            exact = path_positions(placed, flank)
        except ValueError as fault:
            for row in reason:
                row[k] = str(fault)
            continue
        for j, method in enumerate(METHODS.values()):
            points, bounds, reason[j][k] = _attempted(method, exact)
            error[j, k] = np.linalg.norm(points - exact.point, axis=-1).max()
            stated[j, k] = bounds.max()
    return MethodErrors(distances, offset, error, stated, tuple(map(tuple, reason)))


def _attempted(method: Callable[[ReferencePositions], Answer], exact: ReferencePositions) -> Answer:
    """Return the answer of a method, or the reason for which it refuses."""
    try:
        return method(exact)
    except (ArithmeticError, ValueError) as fault:
        return np.full_like(exact.point, np.nan), np.full(len(exact.l1), np.nan), str(fault)


def _by_mesh(polish: bool) -> Callable[[ReferencePositions], Answer]:
    """Return the method that finds the nearest points of two meshes, without or with a polish."""
    mesh_tolerance_mm = 0.01

    def method(exact: ReferencePositions) -> Answer:
        """Return the nearest points of the meshes."""
        rolls = zip(exact.pinion_roll.tolist(), exact.gear_roll.tolist(), strict=True)
        met = [
            mesh_contact(
                exact.design, exact.flank, mesh_tolerance_mm, pinion_roll=one, gear_roll=other, polish=polish
            )
            for one, other in rolls
        ]
        lost = (one.status.name for one in met if one.status != Status.SOLVED)
        return np.array([one.point for one in met]), np.array([one.doubt for one in met]), next(lost, "")

    return method


def _by_five_equations(exact: ReferencePositions) -> Answer:
    """Solve the five equations; positions with too large a residual are refused."""
    xtol = 1e-14
    work, _ = by_five_equations(exact, xtol, five_equations_math.RESIDUAL_LIMIT)
    points, _ = work()
    lost = np.isnan(points).any()
    return points, np.full(len(points), np.nan), "not converged" if lost else ""


def _by_one_equation(exact: ReferencePositions) -> Answer:
    """Solve the one equation at the given l1."""
    path = path_of_contact(exact.design, exact.flank, l1=exact.l1)
    lost = (Status(int(code)).name for code in path.status if code != Status.SOLVED)
    return path.point, np.full(len(exact.l1), np.nan), next(lost, "")


METHODS: dict[str, Callable[[ReferencePositions], Answer]] = {
    "mesh alone": _by_mesh(False),
    "mesh, polished": _by_mesh(True),
    "five equations": _by_five_equations,
    "one equation": _by_one_equation,
}


@dataclass(frozen=True, eq=False)
class StatusMap:
    """Answers of the one equation over shaft angle (rad, shape (n,)) and offset (mm, shape (m,)).

    `status` (m, n) has codes of `Status`. `compared` (k, 2) has rows and columns at which the five equations
    were solved as well, and `five_equations` (k,) their codes, -1 if they refuse."""

    shaft_angle: FloatArray
    offset: FloatArray
    status: Codes
    compared: Integers
    five_equations: Integers


def status_map(
    design: Design, flank: str, shaft_angle: FloatArray, offset: FloatArray, compared: int
) -> StatusMap:
    """Compute whether the flanks of members in fixed axial positions touch, over shaft angle and offset.

    Parameters
    ----------
    design : Design
        A single design. The axial positions are those at its own shaft angle and offset.
    flank : {'right', 'left'}
    shaft_angle : ndarray, shape (n,)
        rad
    offset : ndarray, shape (m,)
        mm
    compared : int
        Number of random cells of each status at which the five equations are solved as well.

    Returns
    -------
    StatusMap
    """
    plain = design.bare()
    first, second = mounting_of(plain).distance.tolist()
    held = replace(plain.pair, pinion_mounting=first, gear_mounting=second)
    angles, offsets = np.meshgrid(shaft_angle, offset)
    batch = replace(plain, pair=replace(held, shaft_angle=angles, offset=offsets))
    status = path_of_contact(batch, flank, 3).ends.status
    cells: list[list[int]] = []
    rng = np.random.default_rng(0)
    for code in np.unique(status):
        status_cells = np.argwhere(status == code)
        cells += status_cells[rng.permutation(len(status_cells))[:compared]].tolist()
    other = []
    for row, column in cells:
        pair = replace(held, shaft_angle=float(shaft_angle[column]), offset=float(offset[row]))
        try:
            path = path_of_contact_five_equations(replace(plain, pair=pair), flank, 3)
            other.append(int(path.ends.status))
        except ArithmeticError:
            other.append(-1)
    return StatusMap(shaft_angle, offset, status, np.array(cells), np.array(other))
