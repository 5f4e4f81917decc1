"""The paper's own method, as a reference: five equations for each position (Eq. 15).

Points and unit normals of both flanks (Eq. 6) are carried to S_f (Eqs. 7-14); for a given
pinion roll R1 = R2 and n1 = -n2 are five independent equations for l1, u1, l2, u2 and the
gear's roll, solved by SciPy's `fsolve`, each position started from the one before. The
ends of the path are found by bracketing the pinion roll at which the least distance inside the
limits vanishes. Nothing is shared with the one-equation method but the flanks, the frames and
the very first starting value, which is moved off the solution.

Takes about a thousand times longer; single designs only.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq, fsolve

from .assembly import layout_of, member_frame, normals_to_fixed, to_fixed
from .contact import Limit
from .flank import flank_patch, root_parameter, tip_radius
from .inputs import Design, FloatArray, flank_sign
from .mounting import mounting_of
from .path import ContactPath, PathEnds, path_of_contact
from .solve import Status

XTOL = 1e-14
ACCEPTED = 1e-9
"""Largest residual (mm and 1) of an accepted position; `fsolve` itself reports rounding noise at
this xtol as lack of progress."""
FIRST_GUESS = np.array([1e-3, -2e-3, -1e-3, 2e-3, 1e-5])
STEPS_PER_PITCH = 24


@dataclass(frozen=True, eq=False)
class _Position:
    unknowns: FloatArray  # l1, u1, l2, u2, gear roll
    roll: float
    own: FloatArray  # (2, 3) contact point in the members' frames
    point: FloatArray
    normal: FloatArray


class _Solver:
    """The five equations of one flank pair."""

    def __init__(self, design: Design, flank: str) -> None:
        errors, distance = design.errors, mounting_of(design).distance
        self.design, self.flank, self.layout = design, flank, layout_of(design)
        self.position = (distance[0] + errors.pinion_axial, distance[1] + errors.gear_axial)

    def flanks(self, unknowns: FloatArray, roll: float) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Points in the members' frames, points and normals in S_f, each (2, 3)."""
        parameters = (unknowns[0:2], unknowns[2:4])
        own, points, normals = np.empty((3, 2, 3))
        for j, (member, angle) in enumerate(zip(self.design.members, (roll, unknowns[4]), strict=True)):
            patch = flank_patch(member, self.flank, *parameters[j])
            frame = member_frame(self.layout, j, angle, self.position[j])
            own[j], points[j] = patch.point, to_fixed(frame, patch.point)  # Eq. (7)
            normals[j] = normals_to_fixed(frame, patch.normal)  # Eq. (8)
        return own, points, normals

    def residual(self, unknowns: FloatArray, roll: float, kept: NDArray[np.int_]) -> FloatArray:
        """R1 - R2 and two components of n1 + n2 (Eq. 15)."""
        _, points, normals = self.flanks(unknowns, roll)
        return np.concatenate((points[0] - points[1], (normals[0] + normals[1])[kept]))

    def solve(self, roll: float, start: FloatArray) -> _Position | None:
        """The contact at a pinion roll, None where none is found from this start."""
        normal = self.flanks(start, roll)[2][0]
        kept = np.sort(np.argsort(np.abs(normal))[:2])  # the largest component is the least sensitive
        unknowns, _, _, _ = fsolve(self.residual, start, args=(roll, kept), xtol=XTOL, full_output=True)
        own, points, normals = self.flanks(unknowns, roll)
        if max(np.abs(points[0] - points[1]).max(), np.abs(normals[0] + normals[1]).max()) > ACCEPTED:
            return None
        return _Position(unknowns, roll, own, points[0], normals[0])

    def margins(self, position: _Position) -> FloatArray:
        """Distances (8,) inside the limits, indexed by `Limit`, mm."""
        margins = np.empty((4, 2))
        for j, member in enumerate(self.design.members):
            x, y, z = position.own[j]
            half = 0.5 * member.face_width
            margins[0, j] = position.unknowns[2 * j] - root_parameter(member)
            margins[1, j] = tip_radius(member, z) - np.hypot(x, y)
            margins[2, j], margins[3, j] = half + z, half - z
        return margins.ravel()

    def end(self, inside: _Position, step: float) -> tuple[_Position, Limit]:
        """Walk from a position on the flanks to the limit in the direction of `step` (rad)."""
        outside = inside
        while self.margins(outside).min() >= 0.0:
            inside, ahead = outside, self.solve(outside.roll + step, outside.unknowns)
            if ahead is None:
                raise ArithmeticError(
                    f"the five equations lose the contact at pinion roll {np.degrees(outside.roll):.4f} deg "
                    "before a limit of the flanks is met: follow this path by the one equation"
                )
            outside = ahead
        found = [inside]

        def least(roll: float) -> float:
            position = self.solve(roll, found[-1].unknowns)
            if position is None:
                raise ArithmeticError("the five equations lose the contact at an end of the path")
            found.append(position)
            return float(self.margins(position).min())

        roll = brentq(least, inside.roll, outside.roll, xtol=1e-15, rtol=1e-14)
        least(roll)
        return found[-1], Limit(int(np.argmin(self.margins(found[-1]))))


def path_of_contact_five_equations(design: Design, flank: str = "right", points: int = 101) -> ContactPath:
    """Path of contact of a single design by the paper's five equations; see `path_of_contact`.

    Raises ValueError for a batch and ArithmeticError where the solver loses the contact, as it
    must where the roll, by which it steps, turns back along the path."""
    if design.batch_shape:
        raise ValueError("the five-equation method takes single designs, not batches")
    guide = path_of_contact(design, flank, 3)
    if guide.l1.size == 0:
        return guide
    solver = _Solver(design, flank)
    start = np.array([guide.l1[1], guide.u1[1], guide.l2[1], guide.u2[1], guide.gear_roll[1]])
    middle = solver.solve(float(guide.pinion_roll[1]), start + FIRST_GUESS)
    if middle is None:
        raise ArithmeticError("the five equations do not converge in the middle of the path")
    step = 2.0 * np.pi / float(design.pinion.teeth) / STEPS_PER_PITCH
    step = step * flank_sign(flank)
    (enter, first), (leave, last) = solver.end(middle, -step), solver.end(middle, step)
    positions: list[_Position | None] = []
    known = enter
    for roll in np.linspace(enter.roll, leave.roll, points):
        positions.append(solver.solve(float(roll), known.unknowns))
        known = positions[-1] or known
    centre = solver.solve(0.5 * (enter.roll + leave.roll), middle.unknowns) or middle
    return _result(design, flank, positions, centre, (enter, leave), (first, last))


def _result(
    design: Design,
    flank: str,
    positions: list[_Position | None],
    centre: _Position,
    ends: tuple[_Position, _Position],
    limits: tuple[Limit, Limit],
) -> ContactPath:
    ratio = design.pinion.teeth / design.gear.teeth
    lost = np.array([position is None for position in positions])
    unknowns, own, point, normal = (
        np.array(
            [
                np.full(np.shape(getattr(centre, name)), np.nan) if p is None else getattr(p, name)
                for p in positions
            ]
        )
        for name in ("unknowns", "own", "point", "normal")
    )
    roll = np.array([np.nan if p is None else p.roll for p in positions])
    spread = np.array([end.unknowns for end in ends])
    rolls = np.array([end.roll for end in ends])
    radius = np.hypot(own[..., 0], own[..., 1])
    phase = unknowns[:, 4] + ratio * roll
    return ContactPath(
        flank=flank,
        l1=unknowns[:, 0],
        u1=unknowns[:, 1],
        l2=unknowns[:, 2],
        u2=unknowns[:, 3],
        pinion_roll=roll,
        gear_roll=unknowns[:, 4],
        point=point,
        normal=normal,
        pinion_z=own[:, 0, 2],
        pinion_r=radius[:, 0],
        gear_z=own[:, 1, 2],
        gear_r=radius[:, 1],
        transmission_error=phase - (centre.unknowns[4] + ratio * centre.roll),
        status=np.where(lost, Status.NOT_CONVERGED, Status.SOLVED).astype(np.int8),
        ends=PathEnds(
            l1=spread[:, 0],
            l2=spread[:, 2],
            pinion_roll=rolls,
            limit=np.array(limits, dtype=np.int8),
            contact_ratio=np.asarray(np.ptp(rolls) * design.pinion.teeth / (2.0 * np.pi)),
            pieces=np.asarray(1),
            status=np.asarray(Status.SOLVED, dtype=np.int8),
        ),
    )
