"""Paths of contact of several cases, taken apart for figures and for their numbers."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from beveloid_geom import ContactPath, Design, Status, path_of_contact
from beveloid_geom.arrays import FloatArray
from beveloid_geom.gear.flank import flank_point
from beveloid_geom.report.words import status_name
from beveloid_geom.status import Limit

from .recipe import Table

FLANKS = ("right", "left")
MEMBERS = ("pinion", "gear")
MODIFIED = (0.001, -0.001)
"""Parabola coefficients of pinion and gear, 1/mm, of the paper's modification."""
COLUMNS = (
    "status",
    "index",
    "pinion_roll_rad",
    "transmission_error_rad",
    "z_mm",
    "r_mm",
    "l_mm",
    "u_mm",
    "x_f_mm",
    "y_f_mm",
    "z_f_mm",
    "contact_ratio",
    "enters_at",
    "leaves_at",
)
REASONS = {
    Status.NO_COMMON_NORMAL: "the flanks share no normal",
    Status.NOT_CONVERGED: "the path could not be followed",
    Status.OFF_FLANK: "the path misses the flanks",
    Status.SEVERAL_CONTACTS: "several contacts at one position",
    Status.ENDLESS: "the path closes on itself",
}


@dataclass(frozen=True, eq=False)
class SolvedPath:
    """The path of one case: the design, the path, and its points (n, 3) on pinion and gear in
    their own frames; empty if nothing was found."""

    design: Design
    path: ContactPath
    points: tuple[FloatArray, FloatArray]

    @property
    def found(self) -> bool:
        """Whether there is a path to draw."""
        return len(self.points[0]) > 1

    def middle(self, member: int) -> FloatArray:
        """Give the point (3,) at mid-roll on the pinion (0) or the gear (1), own frame."""
        points = self.points[member]
        return np.asarray(0.5 * (points[(len(points) - 1) // 2] + points[len(points) // 2]))

    @property
    def ratio(self) -> float:
        """Contact ratio (Eq. 16)."""
        return float(self.path.ends.contact_ratio)

    @property
    def ends(self) -> tuple[str, str]:
        """Where the path enters and leaves, as 'gear tip', 'pinion tip'; '' without a path."""
        enter, leave = (limit_name(code) for code in self.path.ends.limit.tolist())
        return enter, leave

    @property
    def reason(self) -> str:
        """Why there is no path."""
        return REASONS.get(Status(int(self.path.ends.status)), "no position was solved")


def limit_name(code: int) -> str:
    """Give 'gear tip' and the like for the code of a limit; '' for none, -1."""
    return str(Limit(code)) if code >= 0 else ""


def points_on(path: ContactPath, member: int) -> FloatArray:
    """Give points (..., 3) of a path on the flank of pinion (0) or gear (1), own frame, mm."""
    l, u = ((path.l1, path.u1), (path.l2, path.u2))[member]
    return flank_point(path.design.members[member], path.flank, l, u)


def solve(design: Design, flank: str, points: int = 101) -> SolvedPath:
    """Solve the path of contact of a single design, its unsolved positions left out of `points`."""
    path = path_of_contact(design, flank, points)
    good = path.status == Status.SOLVED
    return SolvedPath(design, path, (points_on(path, 0)[good], points_on(path, 1)[good]))


def table(case: Sequence[str], paths: Iterable[tuple[Sequence[object], SolvedPath]]) -> Table:
    """List every position of paths on both members, led by the values of the `case`, the names of which are
    given. A path that was not found gives one row a member that says so."""
    return (*case, "member", *COLUMNS), (row for values, path in paths for row in _rows(values, path))


def _rows(case: Sequence[object], solved: SolvedPath) -> Iterator[list[object]]:
    """List the positions of one path on both members."""
    path, ends = solved.path, [solved.ratio, *solved.ends]
    pinion = path.pinion_z, path.pinion_r, path.l1, path.u1
    gear = path.gear_z, path.gear_r, path.l2, path.u2
    for member, places in zip(MEMBERS, (pinion, gear), strict=True):
        if not solved.found:
            yield [*case, member, status_name(int(path.ends.status)), *[""] * 10, *ends]
            continue
        columns = np.stack((path.pinion_roll, path.transmission_error, *places, *path.point.T), axis=-1)
        for index, (status, values) in enumerate(zip(path.status, columns.tolist(), strict=True)):
            yield [*case, member, status_name(status), index, *values, *ends]
