"""Paths of contact of several cases, as data of figures and as tables."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from beveloid_geom import ContactPath, Design, Status, path_of_contact
from beveloid_geom.analysis.path_measures import in_side_view
from beveloid_geom.arrays import FLANKS as FLANKS, MEMBERS as MEMBERS, FloatArray, Mask
from beveloid_geom.contact.parallel.lines import contact_lines, is_line_contact
from beveloid_geom.design.ends import limit_words
from beveloid_geom.findings.backlash import backlash_report
from beveloid_geom.gear.flank import flank_point
from beveloid_geom.pair.frames import layout_of
from beveloid_geom.report.result import status_name
from beveloid_geom.status import Verdict
from beveloid_geom.validation.claims import CLAIM_PARABOLAS_PER_MM

from .figure_steps import Table
from .touching import Touching, joined_contacts, limit_code, touching_along

LINE_COUNT = 5
"""Number of lines of contact drawn."""
PARABOLAS = ("parabola_pinion_per_mm", "parabola_gear_per_mm")
"""Columns that distinguish the cases of a table."""
REASONS = {
    Status.NO_COMMON_NORMAL: "the flanks have no common normal",
    Status.NOT_CONVERGED: "the path could not be followed",
    Status.OFF_FLANK: "the path does not meet the flanks",
    Status.SEVERAL_CONTACTS: "several contacts at one position",
    Status.ENDLESS: "the path is a closed curve",
}


def at_the_mesh(design: Design) -> str:
    """Return " at the mesh" if the errors of a design are relative to the pitch point, otherwise ''."""
    return " at the mesh" if design.errors_at == "mesh" else ""


@dataclass(frozen=True, eq=False)
class SolvedPath:
    """Path of contact of one case.

    Attributes
    ----------
    design : Design
        The pair.
    path : ContactPath
        The path.
    points : tuple of ndarray, shape (n, 3)
        Points on pinion and gear in their frames, mm; empty without a path.
    touching : Touching, optional
        First contact of all teeth at the rolls of the path, if requested.
    between : Touching, optional
        First contact on both sides of each change of the contact, and over the remainder of a pitch for a
        path shorter than a pitch.
    jammed : bool
        True if the pair cannot be assembled, so that no part of the path is first contact. False if first
        contacts were not requested.
    """

    design: Design
    path: ContactPath
    points: tuple[FloatArray, FloatArray]
    touching: Touching | None = None
    between: Touching | None = None
    jammed: bool = False

    @property
    def has_path(self) -> bool:
        """True if there is a path to draw."""
        return len(self.points[0]) > 1

    def middle(self, member: int) -> FloatArray:
        """Return the point (3,) at mid-roll on pinion (0) or gear (1), in its frame, mm."""
        points = self.points[member]
        return np.asarray(0.5 * (points[(len(points) - 1) // 2] + points[len(points) // 2]))

    def length(self, member: int) -> float:
        """Return the length in the side view (radius r over the axial coordinate z), mm; see
        `path_measures`."""
        return float(in_side_view(self.path)[0][member])

    def angle(self, member: int) -> float:
        """Return the angle of the chord to the axial direction in the side view, deg (`path_measures`)."""
        return float(in_side_view(self.path)[1][member])

    @property
    def first(self) -> Mask | None:
        """Mask of the points of the path that are first contacts; None if unknown."""
        if self.touching is None or not self.has_path:
            return None
        verdict = self.touching.verdict[self.path.status == Status.SOLVED]
        return np.asarray((verdict == Verdict.FIRST_CONTACT) & (not self.jammed))

    def edge_lines(self, member: int) -> list[FloatArray]:
        """Return the lines (n, 3) of edge contact on pinion (0) or gear (1), in its frame, mm."""
        if self.touching is None or self.jammed:
            return []
        touching = joined_contacts(self.touching, self.between)
        edges = [set(name.split(" on ")) - {""} for name in touching.edges]
        (l, z), pair = touching.places(member), touching.first.pair
        points = flank_point(self.design.members[member], self.path.flank, l, z=z)
        goes_on = [bool(a & b) for a, b in pairwise(edges)] & (pair[1:] == pair[:-1])
        cuts = np.flatnonzero(~goes_on) + 1
        lines = [line[np.isfinite(line).all(axis=-1)] for line in np.split(points, cuts)]
        return [line for line in lines if len(line)]

    def contact_lines(self, member: int) -> FloatArray:
        """Return lines of contact (lines, 2, 3) on pinion (0) or gear (1), in its frame, mm.

        Flanks on parallel axes that touch along lines have LINE_COUNT of them, at equal steps of roll. Other
        pairs have none.
        """
        design, flank = self.design, self.path.flank
        if not (self.has_path and is_line_contact(design, flank)):
            return np.empty((0, 2, 3))
        lines = contact_lines(path_of_contact(design, flank, LINE_COUNT + 2))
        drawn = np.isfinite(lines.length[1:-1])  # a contact on a relief has no line
        l, z = ((lines.l1, lines.pinion_z), (lines.l2, lines.gear_z))[member]
        return flank_point(design.members[member], flank, l, z=z)[1:-1][drawn]

    @property
    def ratio(self) -> float:
        """Contact ratio of one tooth pair (Eq. 16 of the paper)."""
        return float(self.path.ends.contact_ratio)

    @property
    def ends(self) -> tuple[str, str]:
        """Limits at which the path enters and leaves, as codes such as 'gear tip'; '' without a path."""
        enter, leave = (limit_code(code) for code in self.path.ends.limit.tolist())
        return enter, leave

    @property
    def ends_in_print(self) -> str:
        """Ends of the path with the printed names of the ends of the face; '' without a path."""
        codes = self.path.ends.limit.tolist()
        return " \u2192 ".join(limit_words(self.design, code) for code in codes if code >= 0)

    @property
    def reason(self) -> str:
        """Reason why there is no path."""
        return REASONS.get(Status(int(self.path.ends.status)), "no position was solved")


def as_large(design: Design) -> float:
    """Return the ratio of the pinion module to that of the paper's pair."""
    # Normal module of the paper's pair, mm.
    table_1_module = 6.0
    return float(design.pinion.tool.normal_module) / table_1_module


def digits_mm(design: Design) -> int:
    """Return the number of decimals of lengths along a flank in mm: 1 at modules near that of the paper."""
    return 1 + max(0, round(-math.log10(as_large(design))))


def two_digits(value: float) -> float:
    """Round to two digits, for values of the paper that are converted to another module."""
    return float(f"{value:.2g}")


def paper_modified(design: Design) -> Design:
    """Return a design with the paper's modification, converted to its module.

    On parallel axes, the paper's modification leaves no contact on the flanks, or lines that any shaft-angle
    error moves to an edge. These pairs get negative coefficients (convex flanks) of the same magnitude.

    Parameters
    ----------
    design : Design

    Returns
    -------
    Design
        With the coefficients of the parabolas replaced.
    """
    parallel = layout_of(design, with_errors=False).parallel
    sizes = [-abs(value) if parallel else value for value in CLAIM_PARABOLAS_PER_MM]
    return design.with_parabola(*(two_digits(value / as_large(design)) for value in sizes))


def parabolas(design: Design, flank: str) -> tuple[float, float]:
    """Return the parabola coefficients of pinion and gear on a flank, 1/mm: the columns PARABOLAS."""
    a1, a2 = (float(member.tool.parabola_of(flank)) for member in design.members)
    return a1, a2


def coefficients(design: Design) -> str:
    """Return the parabola coefficients as TeX formulas, for both flanks if they differ."""
    right, left = (_coefficients(*parabolas(design, flank)) for flank in ("right", "left"))
    return right if right == left else f"right {right}; left {left}"


def _coefficients(a1: float, a2: float) -> str:
    """Return both coefficients as text that may be broken before the last equals sign or after the comma."""
    unit = "\u00a0mm$^{\u22121}$"
    if a1 == a2 or a1 == -a2:
        other = "" if a1 == a2 else "\u2212"
        return f"$a_1$\u00a0=\u00a0{other}$a_2$ =\u00a0{_plain(a1)}{unit}"
    return f"$a_1$\u00a0=\u00a0{_plain(a1)}, $a_2$\u00a0=\u00a0{_plain(a2)}{unit}"


def _plain(value: float) -> str:
    """Return a number without exponent and with a typographic minus."""
    return f"{value:.7f}".rstrip("0").rstrip(".").replace("-", "\u2212")


def both_ratios(one_pair: float, operating: float) -> tuple[str, str]:
    """Return the contact ratio of one tooth pair (Eq. 16) and that in operation as text; NaN is "unknown"."""
    return f"{one_pair:.3f}", f"{operating:.3f}" if np.isfinite(operating) else "unknown"


def ratio_words(one_pair: float, operating: float) -> str:
    """Return both contact ratios as a phrase; arguments as in `both_ratios`."""
    return "ratio {}, in operation {}".format(*both_ratios(one_pair, operating))


def points_on(path: ContactPath, member: int) -> FloatArray:
    """Return the points (..., 3) of a path on the flank of pinion (0) or gear (1), in its frame, mm."""
    l, u = ((path.l1, path.u1), (path.l2, path.u2))[member]
    return flank_point(path.design.members[member], path.flank, l, u)


def solved_case(design: Design, flank: str, points: int = 101, touching: bool = False) -> SolvedPath:
    """Compute the path of contact of a single design.

    Parameters
    ----------
    design : Design
        A single design.
    flank : {'right', 'left'}
        Flank.
    points : int
        Number of positions. Positions without a solution are left out of `SolvedPath.points`.
    touching : bool
        True to compute the first contact of all teeth as well.

    Returns
    -------
    SolvedPath
        Path with its points.
    """
    path = path_of_contact(design, flank, points)
    good = path.status == Status.SOLVED
    at, between = touching_along(path, points) if touching else (None, None)
    both = points_on(path, 0)[good], points_on(path, 1)[good]
    return SolvedPath(design, path, both, at, between, touching and bool(backlash_report(design).jam))


def table(case: Sequence[str], paths: Iterable[tuple[Sequence[object], SolvedPath]]) -> Table:
    """Return the table of all positions of paths on both members.

    Parameters
    ----------
    case : sequence of str
        Column headings of the case.
    paths : iterable of tuple
        Values of these columns, and the path. A case without a path has one row per member with its status,
        or one row per first contact. Rows without index are first contacts on both sides of changes of the
        contact, and over the remainder of a pitch if the path is shorter than a pitch.

    Returns
    -------
    Table
        Headings and rows.
    """
    touching = ("operating_contact_ratio", "verdict", "edge_that_touches", "edge_z_mm", "edge_l_mm")
    columns = (
        *("status", "index", "pinion_roll_rad", "transmission_error_rad", "z_mm", "r_mm", "l_mm", "u_mm"),
        *("x_f_mm", "y_f_mm", "z_f_mm", "length_mm", "angle_deg", "contact_ratio", "enters_at", "leaves_at"),
    )
    listed = list(paths)
    header = (*case, "member", *columns, *(touching if any(path.touching for _, path in listed) else ()))
    return header, (row for values, path in listed for row in _rows(values, path))


def _rows(case: Sequence[object], solved: SolvedPath) -> Iterator[list[object]]:
    """Return the rows of one path on both members."""
    path = solved.path
    pinion = path.pinion_z, path.pinion_r, path.l1, path.u1
    gear = path.gear_z, path.gear_r, path.l2, path.u2
    for number, places in enumerate((pinion, gear)):
        first, member = _first_columns(solved, solved.touching, number), MEMBERS[number]
        measures = [solved.length(number), solved.angle(number)] if solved.has_path else ["", ""]
        ends = [*measures, solved.ratio, *solved.ends]
        if not solved.has_path:
            void = [*case, member, status_name(int(path.ends.status)), *[""] * 10, *ends]
            yield from ([*void, *row] for row in first or [()])
            continue
        columns = np.stack((path.pinion_roll, path.transmission_error, *places, *path.point.T), axis=-1)
        rows = zip(path.status, columns.tolist(), first or [()] * len(columns), strict=True)
        for index, (status, values, contact_columns) in enumerate(rows):
            yield [*case, member, status_name(status), index, *values, *ends, *contact_columns]
        if solved.between is not None and not solved.jammed:
            rolls = solved.between.first.pinion_roll
            low, high = np.sort(path.ends.pinion_roll)
            on_path = (low <= rolls) & (rolls <= high)
            between = zip(
                on_path, rolls.tolist(), _first_columns(solved, solved.between, number), strict=True
            )
            for inside, roll, contact_columns in between:
                if inside and not contact_columns[2]:  # no edge touches
                    continue
                status = "" if inside else status_name(Status.OFF_FLANK)
                yield [*case, member, status, "", roll, *[""] * 8, *ends, *contact_columns]


def _first_columns(solved: SolvedPath, touching: Touching | None, member: int) -> list[tuple[object, ...]]:
    """Return the columns of the first contact at each position; nothing if it was not computed. A jammed
    pair has the verdict JAMMED at all positions."""
    if touching is None:
        return []
    if solved.jammed:
        return [("", "JAMMED", "", "", "")] * len(touching.verdict)
    l, z = touching.places(member)
    verdicts = [Verdict(code).name for code in touching.verdict.tolist()]
    each = zip(verdicts, touching.edges, z.tolist(), l.tolist(), strict=True)
    return [(touching.ratio, *row) for row in each]
