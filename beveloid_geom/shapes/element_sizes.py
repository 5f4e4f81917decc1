"""Numbers of elements of a tooth, and the nodes of its boundary.

Elements with straight edges stay within a tolerance of the surfaces that the tool cuts. Their deviations are
inversely proportional to the square of the number of elements. They are measured on a trial division, from
which the numbers follow (`cells_of`). The fillet has the smallest elements. Those of the flank, of the bottom
land and across the tooth are at most a few times as large, and along the flank they grow gradually from the
fillet on.

If a tooth is thin at its tip, elements there would taper to a point, and the determinant of the Jacobian
would vary too much within them. The steps towards this place, along the profile and along the face, are
limited to the length over which the thickness grows by the factor MAX_THICKENING_RATIO.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray
from ..design.member import Member
from .grid_cells import form_of, stations
from .section import GROWTH_RATIO
from .sheet import Sheet, SheetGrid, grid_of
from .tooth_boundary import cut_sheets, require_tolerance

MAX_THICKENING_RATIO = 1.6
"""Largest ratio of the thicknesses of the tooth at both ends of a step next to a thin tip."""


@dataclass(frozen=True)
class Cells:
    """Numbers of elements of a tooth.

    Attributes
    ----------
    bottom : int
        Along each half of the bottom land.
    fillet : int
        Along each fillet, two or more.
    flank : int
        Along each flank.
    tip : int
        Across the tooth.
    face : int
        Along the face.
    """

    bottom: int
    fillet: int
    flank: int
    tip: int
    face: int


def cells_of(member: Member, tolerance: float) -> Cells:
    """Compute the numbers of elements whose straight edges stay within a tolerance.

    Parameters
    ----------
    member : Member
        A single member.
    tolerance : float
        Largest distance of faces with 4 nodes from the surfaces that the tool cuts, mm.

    Returns
    -------
    Cells

    Raises
    ------
    ValueError
        As `cut_sheets`, and for a tolerance that is too small.
    """
    require_tolerance(tolerance)
    trial, largest_trial = 8, 300
    sheets, cells = cut_sheets(member), Cells(trial, trial, trial, trial, trial)
    for _ in range(2):
        cells = _scaled(member, sheets, cells, tolerance)
        if max(vars(cells).values()) > largest_trial:
            break
    return cells


def _scaled(member: Member, sheets: dict[str, Sheet], measured: Cells, tolerance: float) -> Cells:
    """Return the numbers of elements that use half of the tolerance along profiles and half along the face.

    Deviations are assumed to be inversely proportional to the square of the number, starting from those of
    the `measured` division."""
    # Smallest number of elements along a fillet and across a tooth.
    min_cells = 4
    # Modules. The sizes of the other elements are multiples of the size on the fillet, or of this length if
    # the elements of a short fillet are smaller.
    smallest_fillet_step = 0.08
    deviation = _deviations(sheets, measured)
    rows, length = dict.fromkeys(("bottom", "fillet", "flank", "tip"), 1), dict.fromkeys(sheets, 0.0)
    for name, sheet in sheets.items():
        kind = name.split()[-1]
        number = getattr(measured, kind) * np.sqrt(2.0 * deviation[name][0] / tolerance)
        rows[kind] = max(rows[kind], _count(number))
        length[name] = float(_lengths(sheet)[1][-1, 0])
    longest = {kind: max(length[name] for name in length if name.endswith(kind)) for kind in rows}
    fillet = max(rows["fillet"], min_cells)
    step = max(longest["fillet"] / fillet, smallest_fillet_step * float(member.tool.normal_module))
    z = sheets["tip"].half_width * np.linspace(-1.0, 1.0, 9)
    ends = [grid_of(sheets[f"{side} flank"], np.array([0.0, 1.0]), z).points for side in ("left", "right")]
    thickness = float(np.linalg.norm(ends[0][0] - ends[1][0], axis=-1).max())
    along = float(max(np.linalg.norm(np.diff(side[1], axis=0), axis=-1).sum() for side in ends))
    face = measured.face * np.sqrt(2.0 * max(both[1] for both in deviation.values()) / tolerance)
    # Largest ratio of the size of elements along the flank and across the tooth, and along the face, to the
    # size along the fillet.
    flank_to_fillet, face_to_fillet = 2.5, 8.0
    flank = max(rows["flank"], 1 + _count(longest["flank"] / (flank_to_fillet * step)))
    face = max(_count(face), _count(along / (face_to_fillet * step)))
    thin = _thin_tip(sheets)
    return Cells(
        bottom=max(rows["bottom"], _count(longest["bottom"] / (1.5 * step))),
        fillet=fillet,
        flank=flank + _steps_added(longest["flank"] / flank, thin.profile),
        tip=max(rows["tip"], min_cells, _count(thickness / (flank_to_fillet * step))),
        face=face + _steps_added(2.0 * sheets["tip"].half_width / face, thin.face),
    )


def _count(number: float) -> int:
    return max(1, int(np.ceil(number - 1e-9)))


def edge_deviation(member: Member, cells: Cells) -> float:
    """Return the largest distance (mm) of straight element edges from the surfaces that the tool cuts."""
    return max(max(both) for both in _deviations(cut_sheets(member), cells).values())


def _deviations(sheets: dict[str, Sheet], cells: Cells) -> dict[str, tuple[float, float]]:
    """Return the largest distances (mm) of straight edges from each surface, along its profile and along the
    face. A face with 4 nodes deviates by their sum at most."""
    z = sheets["tip"].half_width * np.linspace(-1.0, 1.0, 2 * cells.face + 1)
    deviations = {}
    for name, grid in _grids(sheets, cells, z).items():
        both = []
        for axes in ((0, 1, 2), (1, 0, 2)):
            points, normals = grid.points.transpose(axes), grid.normals.transpose(axes)[1::2]
            chord = 0.5 * (points[:-2:2] + points[2::2]) - points[1::2]
            both.append(float(np.abs(np.einsum("...i,...i", chord, normals)).max()))
        deviations[name] = both[0], both[1]
    return deviations


@dataclass(frozen=True)
class _ThinTip:
    """Place of the thinnest tip: the `end` -1 (at -z) or 1 (at +z) of the face. Lengths (mm) over which the
    thickness grows by the factor MAX_THICKENING_RATIO: `profile` below the tip, `face` along the face."""

    end: int
    profile: float
    face: float


def _thin_tip(sheets: dict[str, Sheet]) -> _ThinTip:
    """Return the thinnest tip, with both lengths from a linear extrapolation of the thickness."""
    half = sheets["tip"].half_width
    s, z = np.array([0.9, 1.0]), half * np.array([-1.0, -0.9, 0.9, 1.0])
    left, right = (grid_of(sheets[f"{side} flank"], s, z).points for side in ("left", "right"))
    thickness = np.linalg.norm(left - right, axis=-1)
    end = 1 if thickness[1, 3] < thickness[1, 0] else -1
    thin, inner = (3, 2) if end == 1 else (0, 1)
    height = float(np.linalg.norm(left[1, thin] - left[0, thin]))
    least = float(thickness[1, thin])
    profile, face = (
        (MAX_THICKENING_RATIO - 1.0) * least * length / max(float(thickness[at]) - least, 1e-9 * length)
        for length, at in ((height, (0, thin)), (0.1 * half, (1, inner)))
    )
    return _ThinTip(end, profile, face)


def _steps_added(step: float, first: float) -> int:
    """Return how many steps are added if they grow by MAX_THICKENING_RATIO from `first` to `step` (mm)."""
    return max(0, int(np.ceil(np.log(step / first) / np.log(MAX_THICKENING_RATIO) - 1e-9)))


def _limited(steps: FloatArray, last: float) -> FloatArray:
    """Return steps that fall by MAX_THICKENING_RATIO at most to `last` at the end."""
    powers = np.minimum(np.arange(len(steps))[::-1], 1000)
    return np.asarray(np.minimum(steps, last * MAX_THICKENING_RATIO**powers))


def face_stations(sheets: dict[str, Sheet], number: int) -> FloatArray:
    """Return the axial coordinates (2 number + 1,), mm, of corner and mid-side nodes along the face."""
    thin, width = _thin_tip(sheets), 2.0 * sheets["tip"].half_width
    steps = _limited(np.full(number, width / number), thin.face)
    z = np.concatenate(([0.0], np.cumsum(steps)))
    z = width * (z / z[-1] - 0.5)
    z = z if thin.end == 1 else -z[::-1]
    return np.asarray(np.interp(np.arange(2 * number + 1), np.arange(0, 2 * number + 1, 2), z))


def boundary_nodes(sheets: dict[str, Sheet], cells: Cells, z: FloatArray) -> dict[str, FloatArray]:
    """Return the nodes of the curves around a tooth.

    Parameters
    ----------
    sheets : dict
        Surfaces of `cut_sheets`.
    cells : Cells
    z : array (nz,)
        Stations along the face, mm.

    Returns
    -------
    dict
        For each curve of `OUTLINE` an array (2 k + 1, nz, 3), mm: corners and mid-side nodes in turn,
        counter-clockwise seen from +z.
    """
    grids = _grids(sheets, cells, z)
    return {
        name: grid.points[::-1] if name.startswith("right") else grid.points for name, grid in grids.items()
    }


def _grids(sheets: dict[str, Sheet], cells: Cells, z: FloatArray) -> dict[str, SheetGrid]:
    """Return the surfaces at the stations of corners and of mid-side nodes in turn."""
    # Tolerance for which the steps along fillets and bottom lands are distributed.
    stretch_tolerance_mm = 0.01
    # Relative difference of the width of columns at the flanks of the tooth (smaller) from the mean.
    grading = 0.5
    thin, grids = _thin_tip(sheets), {}
    for name, sheet in sheets.items():
        side, kind = name.split()[0], name.split()[-1]
        number = getattr(cells, kind)
        s, lengths = _lengths(sheet, z)
        if kind == "flank":
            # Steps have the same ratios in all planes. With the same profile parameters, the first ones would
            # almost vanish in the plane where undercut begins and the flank starts at its base circle.
            first, length = (float(_lengths(sheets[f"{side} {part}"])[1][-1, 0]) for part in ("fillet", kind))
            at = np.multiply.outer(
                _flank_stations(first / cells.fillet, thin.profile, length, number) / length, lengths[-1]
            )
        else:
            if kind == "tip":
                even = np.linspace(0.0, 1.0, number + 1)
                corners = even - grading / (2.0 * np.pi) * np.sin(2.0 * np.pi * even)
            else:
                corners = stations(form_of(sheet, stretch_tolerance_mm), number, 1, 1.0)[0]
            at = np.stack([np.interp(corners, s, column) for column in lengths.T], axis=-1)
        nodes = np.empty((2 * number + 1, len(z)))
        nodes[::2], nodes[1::2] = at, 0.5 * (at[1:] + at[:-1])
        share = np.stack([np.interp(*pair, s) for pair in zip(nodes.T, lengths.T, strict=True)], axis=-1)
        lower = sheet.lower(z)
        parameter = lower + share * (sheet.upper(z) - lower)
        points, normals = sheet.place(parameter, np.broadcast_to(z, parameter.shape))
        grids[name] = SheetGrid(points, normals, parameter, z)
    return grids


def _lengths(sheet: Sheet, z: ArrayLike = 0.0) -> tuple[FloatArray, FloatArray]:
    """Return stations s = 0 ... 1 (k,) of the profile, and their lengths (k, n), mm, from its start in the
    planes `z` (n,), mm."""
    # Steps in which lengths along a profile are measured.
    length_steps = 400
    s, z = np.linspace(0.0, 1.0, length_steps + 1), np.atleast_1d(np.asarray(z, dtype=float))
    lengths = np.zeros((s.size, z.size))
    np.cumsum(np.linalg.norm(np.diff(grid_of(sheet, s, z).points, axis=0), axis=-1), axis=0, out=lengths[1:])
    return s, lengths


def _flank_stations(first: float, last: float, length: float, number: int) -> FloatArray:
    """Return lengths (number + 1,), mm, along a flank. Steps grow by GROWTH_RATIO from `first` (mm) at the
    fillet until they are even, and fall by MAX_THICKENING_RATIO at most to `last` (mm) at the tip."""
    grown = GROWTH_RATIO ** np.minimum(np.arange(number), 1000)
    steps = _limited(np.minimum(length, first * number * grown), last * number)
    lengths = np.concatenate(([0.0], np.cumsum(steps)))
    return np.asarray(length * lengths / lengths[-1])
