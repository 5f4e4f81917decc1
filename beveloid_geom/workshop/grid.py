"""The grid of points on which a measuring machine touches both flanks of a tooth.

Rows lie from root to tip, columns from toe to heel, evenly between borders that keep the probe off fillet,
tip and end faces: shares of the flank's depth along its profile (the parameter l) and of the face width, or
mm of both. Points and normals are those of the exact flank, in the blank's frame: z along the axis towards
the heel, 0 at mid-face; x through tooth 0.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..arrays import FLANK_SIGN, FloatArray
from ..design.model import Member
from ..gear.flank import flank_patch, place_at
from ..gear.undercut import require_sound
from ..support.few_lines import few_lines
from .tooth_data import middle_angle

LEAST_ROWS, MOST = 2, 999
"""Rows and columns of a grid, at least and at most."""


@dataclass(frozen=True, eq=False)
class MeasuringGrid:
    """Points on both flanks of tooth 0 of a single `member`, right before left, rows from root to tip,
    columns from toe to heel: (2, rows, columns), mm.

    `depth` (2, rows, columns) and `face` (columns,): shares of the flank from its root and of the face from
    the toe; `l`, `u`, and `point`, unit `normal` out of the tooth (2, rows, columns, 3); `middle`, the angle
    (rad) from x to the tooth's middle on the reference cylinder at mid-face, 0 without cone or helix."""

    __repr__ = few_lines

    member: Member
    depth: FloatArray
    face: FloatArray
    l: FloatArray
    u: FloatArray
    point: FloatArray
    normal: FloatArray
    middle: float

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns."""
        return self.depth.shape[1], self.depth.shape[2]


def measuring_grid(
    member: Member, rows: int = 5, columns: int = 9, border: float = 0.1, border_mm: float | None = None
) -> MeasuringGrid:
    """Lay a grid over both flanks of a single member.

    Parameters
    ----------
    member : Member
    rows, columns : int
        From root to tip and from toe to heel, 2 to 999.
    border : float
        Left free at root and tip, toe and heel: a share of the depth and of the face width.
    border_mm : float, optional
        The same in mm along profile and face, in place of `border`.

    Returns
    -------
    MeasuringGrid

    Raises
    ------
    ValueError
        For too few or too many points, a border that leaves none, and a member whose flanks are undercut or
        do not reach their tip cone.
    """
    for name, count in (("rows", rows), ("columns", columns)):
        if not LEAST_ROWS <= count <= MOST:
            raise ValueError(f"{name} must be between {LEAST_ROWS} and {MOST}, got {count}")
    require_sound(member)
    face_width = float(member.face_width)
    share = border if border_mm is None else border_mm / face_width
    if not 0.0 <= share < 0.5:
        raise ValueError(_border_fault(border, border_mm, "face", face_width))
    face, even = share + (1.0 - 2.0 * share) * np.linspace(0.0, 1.0, columns), np.linspace(0.0, 1.0, rows)
    sides = []
    for flank in FLANK_SIGN:
        beside = np.full(columns, share)
        if border_mm is not None:
            ends, _, _ = place_at(member, flank, np.array([[0.0], [1.0]]), face)
            beside = border_mm / (ends[1] - ends[0])
            if not (beside < 0.5).all():
                raise ValueError(_border_fault(border, border_mm, "flank", float((ends[1] - ends[0]).min())))
        depth = beside + (1.0 - 2.0 * beside) * even[:, None]
        l, _, u = place_at(member, flank, depth, face)
        patch = flank_patch(member, flank, l, u)
        sides.append((depth, l, u, patch.point, patch.normal))
    depth, l, u, point, normal = (np.stack(parts) for parts in zip(*sides, strict=True))
    return MeasuringGrid(member, depth, face, l, u, point, normal, middle_angle(member))


def _border_fault(border: float, border_mm: float | None, of: str, size: float) -> str:
    """Say that a border leaves nothing."""
    if border_mm is None:
        return f"border must be at least 0 and below 50 %, got {100.0 * border:g} %"
    limit = f"below {0.5 * size:.4g} mm, half of the {of}'s {size:.4g} mm"
    return f"border must be at least 0 and {limit}, got {border_mm:g} mm"
