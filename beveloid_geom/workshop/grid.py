"""Grids of points for measuring both flanks of a tooth.

Rows run from root to tip and columns from -z to +z. They are evenly distributed between borders that keep the
probe away from fillet, tip and end faces. Borders are shares of the depth of the flank along its profile
(parameter l) and of the face width, or lengths in mm. Points and normals are those of the exact flank in the
frame of the gear: z along the axis, 0 at mid-face; x through tooth 0.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from ..arrays import FLANK_SIGN, FloatArray
from ..design.arguments import require_integers, require_member, require_numbers
from ..design.member import Member
from ..gear.active_flank import place_at
from ..gear.flank import flank_patch
from ..gear.undercut import require_flanks
from ..support.array_repr import short_repr
from .tooth_data import middle_angle


@dataclass(frozen=True, eq=False)
class MeasuringGrid:
    """Points on both flanks of tooth 0, right flank first, rows from root to tip, columns from -z to +z.

    Attributes
    ----------
    member : Member
    depth : array (2, rows, columns)
        Relative position along the profile from the root.
    face : array (columns,)
        Relative position along the face from -z.
    l, u : array (2, rows, columns)
        Flank parameters, mm.
    point, normal : array (2, rows, columns, 3)
        Points, mm, and outward unit normals.
    middle : float
        Angle from x to the middle of the tooth on the reference cylinder at mid-face, rad; 0 without cone or
        helix.
    """

    __repr__ = short_repr

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
        """Numbers of rows and columns."""
        return self.depth.shape[1], self.depth.shape[2]


def border_of(text: str) -> tuple[str, float, float | None]:
    """Return a border such as '10%' or '2mm': its text in standard form, its share, and its length (mm).

    For a percentage the length is None; for a length the share has no meaning. Raises ValueError for another
    text."""
    match = re.fullmatch(r"\s*([-+.\deE]+)\s*(%|mm)\s*", text)
    try:
        size = float(match[1]) if match else float("nan")
    except ValueError:
        size = float("nan")
    if match is None or size != size:
        raise ValueError(f"border must be a percentage such as 10% or a length such as 2mm, got {text!r}")
    return f"{size:g} {match[2]}", 0.01 * size, size if match[2] == "mm" else None


def measuring_grid(
    member: Member, rows: int = 5, columns: int = 9, border: float = 0.1, border_mm: float | None = None
) -> MeasuringGrid:
    """Return a grid of points on both flanks of a single member.

    Parameters
    ----------
    member : Member
    rows, columns : int
        Numbers from root to tip and from -z to +z, 2 to 999.
    border : float
        Border at root, tip and both ends, as a share of the depth and of the face width.
    border_mm : float, optional
        Border along profile and face in mm, instead of `border`.

    Returns
    -------
    MeasuringGrid

    Raises
    ------
    ValueError
        For numbers of points and borders outside their limits, flanks that undercut removes in a part of the
        face, and flanks that do not reach their tip cone.

    References
    ----------
    Order of the points: beveloid_geom/workshop/README.md, Measuring.

    Examples
    --------
    >>> import beveloid_geom as bg
    >>> grid = bg.measuring_grid(bg.builtin_design("ni-2017").pinion, rows=3, columns=5)
    >>> grid.point.shape
    (2, 3, 5, 3)
    """
    require_member(member)
    require_integers(rows=rows, columns=columns)
    require_numbers(border=border, border_mm=border_mm)
    # Smallest and largest number of rows and of columns.
    least, most = 2, 999
    for name, count in (("rows", rows), ("columns", columns)):
        if not least <= count <= most:
            raise ValueError(f"{name} must be between {least} and {most}, got {count}")
    require_flanks(member)
    face_width = float(member.face_width)
    share = border if border_mm is None else border_mm / face_width
    if not 0.0 <= share < 0.5:
        raise ValueError(_border_fault(border, border_mm, "face", face_width))
    face, even = share + (1.0 - 2.0 * share) * np.linspace(0.0, 1.0, columns), np.linspace(0.0, 1.0, rows)
    sides = []
    for flank in FLANK_SIGN:
        free = np.full(columns, share)
        if border_mm is not None:
            ends, _, _ = place_at(member, flank, np.array([[0.0], [1.0]]), face)
            free = border_mm / (ends[1] - ends[0])
            if not (free < 0.5).all():
                raise ValueError(_border_fault(border, border_mm, "flank", float((ends[1] - ends[0]).min())))
        depth = free + (1.0 - 2.0 * free) * even[:, None]
        l, _, u = place_at(member, flank, depth, face)
        patch = flank_patch(member, flank, l, u)
        sides.append((depth, l, u, patch.point, patch.normal))
    depth, l, u, point, normal = (np.stack(parts) for parts in zip(*sides, strict=True))
    return MeasuringGrid(member, depth, face, l, u, point, normal, middle_angle(member))


def _border_fault(border: float, border_mm: float | None, part: str, size: float) -> str:
    """Return the message for a border that leaves no points."""
    if border_mm is None:
        return f"border must be at least 0 and below 50 %, got {100.0 * border:g} %"
    limit = f"below {0.5 * size:.4g} mm, half of the {part}'s {size:.4g} mm"
    return f"border must be at least 0 and {limit}, got {border_mm:g} mm"
