"""Seams: lines of a tooth across which derivatives of its surface jump, so that B-splines need knots there.

Where a relief begins, the curvature jumps. Where undercut begins, edges of the tooth have kinks. B-splines
may have a kink at both (`continuous` = 0). Measured deviations are cubic splines, whose third derivatives
jump at the rows and columns of the grid."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from ..arrays import FLANK_SIGN, FloatArray
from ..design.deviations import DeviationShape
from ..design.member import Member
from ..gear.flank import modification_of
from ..gear.modification import Term
from ..gear.tooth_side import surface_of
from ..shapes.sampling import flank_sheet
from .spline_fit import Break

SPLINE_CONTINUOUS = 2
"""Number of continuous derivatives of a cubic spline."""


class Seam(NamedTuple):
    """Line l = `l` + `slope` z on a flank, mm.

    Along a curve that crosses the line, the first `continuous` derivatives of a B-spline are continuous. The
    next one may jump; 0 allows a kink."""

    l: float
    slope: float
    continuous: int

    def at(self, z: FloatArray) -> FloatArray:
        """Return l in the planes z, mm."""
        return self.l + self.slope * z


def seams_of(member: Member, flank: str) -> list[Seam]:
    """Return the lines along the face of a flank at which reliefs of the profile begin, and the rows of
    measured deviations, in the order from root to tip.

    Rows that leave the flank or cross a line are omitted: there, B-splines need more spans.

    Raises
    ------
    ValueError
        For a relief whose line leaves the flank between toe and heel.
    """
    # Smallest distance of two lines, as a fraction of the flank depth.
    smallest_share = 1e-6
    terms = _terms(member, flank)
    starts = [float(term.origin[0]) for term in terms if term.relief == 0]
    rows = [row for term in terms if isinstance(term.shape, DeviationShape) for row in term.shape.rows]
    if not starts and not rows:
        return []
    sheet = flank_sheet(member, flank, to_fillet=True)
    z = np.linspace(-sheet.half_width, sheet.half_width, 101)
    low, high = (np.broadcast_to(side, z.shape) for side in (sheet.lower(z), sheet.upper(z)))
    # A relief that covers the whole flank begins beyond it.
    seams = sorted(Seam(l, 0.0, 0) for l in starts if low.min() < l < high.max())
    if np.any(np.diff([low.max(), *(seam.l for seam in seams), high.min()]) <= 0.0):
        raise ValueError(
            f"the {flank} flank cannot be a B-spline, as the line where a relief begins leaves the flank or"
            " meets another such line: change the length of the relief, or write triangles"
        )
    for row in rows:
        more = sorted([*seams, Seam(*row, SPLINE_CONTINUOUS)])
        steps = np.diff([low, *(seam.at(z) for seam in more), high], axis=0)
        if (steps > smallest_share * (high - low)).all():
            seams = more
    return seams


def section_breaks(member: Member, flank: str) -> list[Break]:
    """Return the seams of a flank as shares of its depth at mid-face, from its joint with the fillet.

    Raises ValueError as `seams_of`."""
    seams = seams_of(member, flank)
    if not seams:
        return []
    sheet, middle = flank_sheet(member, flank, to_fillet=True), np.zeros(1)
    start, end = (float(np.broadcast_to(side(middle), 1)[0]) for side in (sheet.lower, sheet.upper))
    return [Break((seam.l - start) / (end - start), seam.continuous) for seam in seams]


def face_breaks(member: Member) -> list[Break]:
    """Return where, along the face, undercut of a flank or a relief begins, and the columns of measured
    deviations; as fractions of the face from the toe."""
    # Smallest distance of breaks, as a fraction of the face.
    smallest_step = 1e-9
    half = 0.5 * float(member.face_width)
    sorted_breaks = sorted(
        Break(0.5 * (z / half + 1.0), continuous)
        for flank in FLANK_SIGN
        for z, continuous in _planes(member, flank)
        if abs(z) < (1.0 - 1e-6) * half
    )
    breaks: list[Break] = []
    for one in sorted_breaks:
        if breaks and one.place - breaks[-1].place <= smallest_step:
            breaks[-1] = breaks[-1]._replace(continuous=min(one.continuous, breaks[-1].continuous))
        else:
            breaks.append(one)
    return breaks


def _terms(member: Member, flank: str) -> tuple[Term, ...]:
    """Return the terms of the modification of a flank."""
    modification = modification_of(member, flank)
    return modification.terms if modification else ()


def _planes(member: Member, flank: str) -> Iterator[tuple[float, int]]:
    """Yield planes z (mm) across which derivatives of a flank jump, and `continuous` of a Seam there."""
    for term in _terms(member, flank):
        if term.relief == 1:
            yield float(term.origin[1]), 0
        if isinstance(term.shape, DeviationShape):
            yield from ((float(z), SPLINE_CONTINUOUS) for z in term.shape.columns)
    crossing = surface_of(member, flank).crossing
    for part in crossing.parts if crossing else ():
        yield from ((z, 0) for z, onset in zip((part.low, part.high), part.onset, strict=True) if onset)
