"""Paths of contact of several cases, taken apart for figures and for their numbers."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from beveloid_geom import (
    ContactPath,
    Design,
    Errors,
    MeshCycle,
    Status,
    certify,
    mesh_cycle,
    path_of_contact,
)
from beveloid_geom.analysis.path_measures import in_side_view
from beveloid_geom.arrays import Codes, FloatArray, Mask
from beveloid_geom.contact.parallel.lines import contact_lines, touches_along_lines
from beveloid_geom.gear.flank import flank_point, trace_parameter
from beveloid_geom.operation.first_contact import FirstContact
from beveloid_geom.operation.operating_ratio import operating_ratio
from beveloid_geom.pair.frames import layout_of
from beveloid_geom.report.words import status_name
from beveloid_geom.status import Limit, Verdict
from beveloid_geom.studies.claims import MODIFIED

from .recipe import Table

FLANKS = ("right", "left")
MEMBERS = ("pinion", "gear")
LINES = 5
"""Lines of contact drawn, where flanks touch along lines."""
TABLE_1_MODULE = 6.0
"""mm."""
PARABOLAS = ("parabola_pinion_per_mm", "parabola_gear_per_mm")
"""Columns by which tables tell cases apart."""
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
    "length_mm",
    "angle_deg",
    "contact_ratio",
    "enters_at",
    "leaves_at",
)
TOUCHING = ("operating_contact_ratio", "verdict", "edge_that_touches", "edge_z_mm", "edge_l_mm")
"""Columns of what touches first at the roll of a position."""
REASONS = {
    Status.NO_COMMON_NORMAL: "the flanks share no normal",
    Status.NOT_CONVERGED: "the path could not be followed",
    Status.OFF_FLANK: "the path misses the flanks",
    Status.SEVERAL_CONTACTS: "several contacts at one position",
    Status.ENDLESS: "the path closes on itself",
}


def at_the_mesh(design: Design) -> str:
    """Say that errors are at the mesh, where a design has its own measured there; nothing of the paper's."""
    return " at the mesh" if design.errors_at == "mesh" else ""


@dataclass(frozen=True, eq=False)
class Touching:
    """What touches first of all teeth: `verdict` (n,) on the positions of a path and what touches `first`
    at their rolls, or, without a path, over a mesh cycle; contact `ratio` of all teeth, NaN if unknown."""

    verdict: Codes
    first: FirstContact
    ratio: float

    @property
    def edges(self) -> list[str]:
        """The edges that touch first at each roll, '' where a flank does."""
        codes = np.where((self.verdict == Verdict.FIRST_CONTACT)[:, None], -1, self.first.limit)
        return [" on ".join(limit_name(code) for code in both if code >= 0) for both in codes.tolist()]

    def places(self, member: int) -> tuple[FloatArray, FloatArray]:
        """Give l and z (n,), mm, on pinion (0) or gear (1) where edges touch; else, and on fillets, NaN."""
        first = self.first
        l, z = ((first.l1, first.z1), (first.l2, first.z2))[member]
        away = first.on_fillet[:, member] | (np.array(self.edges) == "")
        return np.where(away, np.nan, l), np.where(away, np.nan, z)


@dataclass(frozen=True, eq=False)
class SolvedPath:
    """The path of one case: the design, the path, and its points (n, 3) on pinion and gear in
    their own frames; empty if nothing was found. What is `touching` first, if that was asked for, and over
    the `rest` of a pitch where the path is shorter than one."""

    design: Design
    path: ContactPath
    points: tuple[FloatArray, FloatArray]
    touching: Touching | None = None
    rest: Touching | None = None

    @property
    def found(self) -> bool:
        """Whether there is a path to draw."""
        return len(self.points[0]) > 1

    def middle(self, member: int) -> FloatArray:
        """Give the point (3,) at mid-roll on the pinion (0) or the gear (1), own frame."""
        points = self.points[member]
        return np.asarray(0.5 * (points[(len(points) - 1) // 2] + points[len(points) // 2]))

    def length(self, member: int) -> float:
        """Length (mm) in the side view, of `path_measures`."""
        return float(in_side_view(self.path)[0][member])

    def angle(self, member: int) -> float:
        """Angle (deg) of the chord to the axial direction in the side view, of `path_measures`."""
        return float(in_side_view(self.path)[1][member])

    @property
    def first(self) -> Mask | None:
        """Which points of the path are first contacts, if that is known."""
        if self.touching is None or not self.found:
            return None
        return np.asarray(self.touching.verdict[self.path.status == Status.SOLVED] == Verdict.FIRST_CONTACT)

    def edge_lines(self, member: int) -> list[FloatArray]:
        """Give lines (n, 3) on pinion (0) or gear (1), own frame, mm, along which edges touch first."""
        parts = (part for part in (self.touching, self.rest) if part)
        return [line for part in parts for line in self._edge_lines(part, member)]

    def _edge_lines(self, touching: Touching, member: int) -> list[FloatArray]:
        """Give those of what touches at the rolls of the path, or over the rest of a pitch."""
        part, pair = self.design.members[member], touching.first.pair
        edges = [set(name.split(" on ")) - {""} for name in touching.edges]
        l, z = touching.places(member)
        points = flank_point(part, self.path.flank, l, trace_parameter(part, self.path.flank, l, z))
        goes_on = [bool(a & b) for a, b in pairwise(edges)] & (pair[1:] == pair[:-1])
        cuts = np.flatnonzero(~goes_on) + 1
        lines = [line[np.isfinite(line).all(axis=-1)] for line in np.split(points, cuts)]
        return [line for line in lines if len(line)]

    def contact_lines(self, member: int) -> FloatArray:
        """Give lines (lines, 2, 3) on pinion (0) or gear (1), own frame, mm, along which flanks on parallel
        axes touch, at LINES even rolls of the path; none where they touch in points."""
        design, flank = self.design, self.path.flank
        if not (self.found and touches_along_lines(design, flank)):
            return np.empty((0, 2, 3))
        lines = contact_lines(path_of_contact(design, flank, LINES + 2))
        l, z = ((lines.l1, lines.pinion_z), (lines.l2, lines.gear_z))[member]
        part = design.members[member]
        return flank_point(part, flank, l, trace_parameter(part, flank, l, z))[1:-1]

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


def as_large(design: Design) -> float:
    """Say how many times as large as Table 1's a design is, by its pinion's module."""
    return float(design.pinion.tool.normal_module) / TABLE_1_MODULE


def two_digits(value: float) -> float:
    """Round to two digits: a value of the paper at another module, so that it reads as one."""
    return float(f"{value:.2g}")


def modified(design: Design) -> Design:
    """Give a design the paper's modification, at its own module; on parallel axes, where that leaves no
    contact on the flanks, or lines that every error of the shaft angle puts on an edge, convex flanks by as
    much."""
    sizes = (-abs(value) for value in MODIFIED) if _parallel(design) else MODIFIED
    return design.with_parabola(*(two_digits(value / as_large(design)) for value in sizes))


def modification(design: Design) -> str:
    """Say which modification `modified` gives a design."""
    return "convex flanks" if _parallel(design) else "the paper's modification"


def _parallel(design: Design) -> bool:
    """Say whether the axes are parallel, but for errors."""
    return bool(layout_of(design.with_errors(Errors())).parallel)


def parabolas(design: Design) -> tuple[float, float]:
    """Give the parabola coefficients of pinion and gear, 1/mm: PARABOLAS."""
    a1, a2 = (float(member.tool.parabola) for member in design.members)
    return a1, a2


def coefficients(design: Design) -> str:
    """Say the parabola coefficients of a design in mathematical type."""
    a1, a2 = parabolas(design)
    if a1 == a2 or a1 == -a2:
        other = "" if a1 == a2 else "\u2212"
        return f"$a_1$ = {other}$a_2$ = {_plain(a1)} mm$^{{\u22121}}$"
    return f"$a_1$ = {_plain(a1)}, $a_2$ = {_plain(a2)} mm$^{{\u22121}}$"


def _plain(value: float) -> str:
    """Give a number without exponent and with a true minus."""
    return f"{value:.7f}".rstrip("0").rstrip(".").replace("-", "\u2212")


def both_ratios(path: float, running: float) -> tuple[str, str]:
    """Write both contact ratios, that of Eq. 16 and that in operation, NaN where it is not known."""
    return f"{path:.3f}", f"{running:.3f}" if np.isfinite(running) else "unknown"


def ratio_words(path: float, running: float) -> str:
    """Say both contact ratios, as `both_ratios` takes them."""
    return "ratio {}, running {}".format(*both_ratios(path, running))


def limit_name(code: int) -> str:
    """Give 'gear tip' and the like for the code of a limit; '' for none, -1."""
    return str(Limit(code)) if code >= 0 else ""


def points_on(path: ContactPath, member: int) -> FloatArray:
    """Give points (..., 3) of a path on the flank of pinion (0) or gear (1), own frame, mm."""
    l, u = ((path.l1, path.u1), (path.l2, path.u2))[member]
    return flank_point(path.design.members[member], path.flank, l, u)


def solve(design: Design, flank: str, points: int = 101, touching: bool = False) -> SolvedPath:
    """Solve the path of contact of a single design, its unsolved positions left out of `points`; and what is
    `touching` first of all teeth."""
    path = path_of_contact(design, flank, points)
    good = path.status == Status.SOLVED
    seen = touching_first(path, points) if touching else None
    rest = touching_beyond(path, points, seen.ratio) if seen else None
    return SolvedPath(design, path, (points_on(path, 0)[good], points_on(path, 1)[good]), seen, rest)


def touching_first(path: ContactPath, points: int) -> Touching:
    """Find what touches first at the rolls of a path; without one, at so many `points` of a mesh cycle."""
    ratio = float(operating_ratio(path.design, path.flank))
    if (path.status == Status.SOLVED).any():
        certificate = certify(path)
        return Touching(certificate.verdict, certificate.first, ratio)
    cycle = mesh_cycle(path.design, path.flank)
    return _over(cycle, cycle.start + cycle.pitch * np.linspace(0.0, 1.0, points), ratio)


def touching_beyond(path: ContactPath, points: int, ratio: float) -> Touching | None:
    """Find what touches first from where a path leaves to where that of the next tooth pair enters, at so
    many `points` a pitch, with the contact `ratio` of all teeth; None without a path, or where it is a pitch
    long."""
    own = float(path.ends.contact_ratio)
    if not 0.0 < own < 1.0:
        return None
    enter, leave = path.ends.pinion_roll.tolist()
    cycle = mesh_cycle(path.design, path.flank)
    enters_next = enter + np.copysign(float(cycle.pitch), leave - enter)
    return _over(cycle, np.linspace(leave, enters_next, 2 + int(points * (1.0 - own))), ratio)


def _over(cycle: MeshCycle, rolls: FloatArray, ratio: float) -> Touching:
    """Give what touches first at rolls (n,), rad, of a mesh cycle without positions of a path."""
    return Touching(np.full(rolls.size, np.int8(Verdict.NOT_SOLVED)), cycle.at(rolls), ratio)


def table(case: Sequence[str], paths: Iterable[tuple[Sequence[object], SolvedPath]]) -> Table:
    """List every position of paths on both members, led by the values of the `case`, the names of which are
    given, and what touches first there if that is known. A path that was not found gives one row a member
    that says so, or those of what touches instead; one shorter than a pitch also those of what touches over
    the rest of it."""
    listed = list(paths)
    header = (*case, "member", *COLUMNS, *(TOUCHING if any(path.touching for _, path in listed) else ()))
    return header, (row for values, path in listed for row in _rows(values, path))


def _rows(case: Sequence[object], solved: SolvedPath) -> Iterator[list[object]]:
    """List the positions of one path on both members."""
    path = solved.path
    pinion = path.pinion_z, path.pinion_r, path.l1, path.u1
    gear = path.gear_z, path.gear_r, path.l2, path.u2
    for number, places in enumerate((pinion, gear)):
        first, member = _first_columns(solved.touching, number), MEMBERS[number]
        measures = [solved.length(number), solved.angle(number)] if solved.found else ["", ""]
        ends = [*measures, solved.ratio, *solved.ends]
        if not solved.found:
            void = [*case, member, status_name(int(path.ends.status)), *[""] * 10, *ends]
            yield from ([*void, *row] for row in first or [()])
            continue
        columns = np.stack((path.pinion_roll, path.transmission_error, *places, *path.point.T), axis=-1)
        rows = zip(path.status, columns.tolist(), first or [()] * len(columns), strict=True)
        for index, (status, values, told) in enumerate(rows):
            yield [*case, member, status_name(status), index, *values, *ends, *told]
        if solved.rest is not None:
            void = [*case, member, status_name(Status.OFF_FLANK), ""]
            rolls = solved.rest.first.pinion_roll.tolist()
            rest = zip(rolls, _first_columns(solved.rest, number), strict=True)
            yield from ([*void, roll, *[""] * 8, *ends, *told] for roll, told in rest)


def _first_columns(touching: Touching | None, member: int) -> list[tuple[object, ...]]:
    """List TOUCHING at each position; nothing if it was not asked for."""
    if touching is None:
        return []
    l, z = touching.places(member)
    verdicts = [Verdict(code).name for code in touching.verdict.tolist()]
    each = zip(verdicts, touching.edges, z.tolist(), l.tolist(), strict=True)
    return [(touching.ratio, *row) for row in each]
