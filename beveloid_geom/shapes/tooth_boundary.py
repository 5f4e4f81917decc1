"""The surfaces that a tool cuts on one tooth, and grids on them.

The surfaces are the tip cone, two flanks, two fillets and two halves of bottom lands, from the middle of one
tooth space to the middle of the next. Each is sampled such that its distance from the triangles stays below a
tolerance. All surfaces have the same stations along the face, so that neighbours share the points of their
common edge. Cells are kept from becoming slivers where a surface is almost straight in one direction, as a
spur gear is along its axis.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray, flank_sign
from ..design.member import Member
from ..gear.fillet import bottom_point, root_radius, tool_round
from ..gear.flank import half_thickness_angle, turned
from ..gear.flank_limits import tip_parameter, tip_radius
from ..gear.tooth_side import fillet_points, surface_of, turn_rows
from ..gear.undercut import require_flanks
from ..support.argument import ArgumentError
from .grid_cells import (
    MAX_POINTS,
    Form,
    cells_for,
    columns_for,
    estimated_deviation,
    form_of,
    measured_deviation,
    stations,
)
from .sampling import flank_sheet
from .section import OUTLINE
from .sheet import Place, Sheet, SheetGrid, grid_of

MAX_ASPECT_RATIO = 20.0
"""Largest ratio of the sides of a cell. The triangles of the most oblique cells then have angles of 2 deg."""


def require_tolerance(tolerance: float) -> None:
    """Raise ArgumentError for a tolerance (mm) that is not positive and finite, or too small."""
    # Double precision cannot represent smaller tolerances on a large gear.
    min_tolerance_mm = 1e-9
    if not 0.0 < tolerance < np.inf:
        raise ArgumentError("tolerance", f"must be a positive length in mm, got {tolerance:g}")
    if tolerance < min_tolerance_mm:
        text = f"must be at least {min_tolerance_mm:g} mm, got {tolerance:g}: usual are 0.001 to 0.1"
        raise ArgumentError("tolerance", text)


def counted(teeth: int) -> str:
    """Return '1 tooth', '2 teeth' and so on."""
    return "1 tooth" if teeth == 1 else f"{teeth} teeth"


def _straight_sheet(member: Member, place: Place, ends: tuple[float, float]) -> Sheet:
    return Sheet(
        place, lambda z: ends[0] + 0.0 * z, lambda z: ends[1] + 0.0 * z, 0.5 * float(member.face_width)
    )


def _bottom_ends(member: Member, flank: str) -> tuple[float, float, float]:
    """Return the width (mm) of half the bottom land in the tool, the length (mm) of the tip round that is
    added to a narrow land, and the profile parameter (rad, see `fillet_sheet`) at the end of this part."""
    # Half a bottom land that is narrower includes the start of the fillet, for triangles of good shape.
    min_land_modules = 0.02
    rounding, module = tool_round(member.tool, flank), float(member.tool.normal_module)
    width = 0.5 * np.pi * module - abs(rounding.centre[1])
    added = max(min_land_modules * module - width, 0.0)
    turn = 0.25 * (0.5 * np.pi - rounding.angle)
    if added > 0.0 and rounding.radius * turn > added:
        turn = added / rounding.radius
    return width, added, 0.5 * np.pi - (turn if added > 0.0 else 0.0)


def fillet_sheet(member: Member, flank: str) -> Sheet:
    """Return the fillet below one flank, from the bottom land to the flank.

    The profile parameter is the angle (rad) of the normal of the tool's tip round in the normal section of
    the tool: pi/2 at the bottom land, and smaller towards the flank."""
    ends = _bottom_ends(member, flank)[2], tool_round(member.tool, flank).angle
    sheet = _straight_sheet(member, lambda p, z: fillet_points(member, flank, p, z), ends)
    return replace(sheet, upper=partial(fillet_end_angle, member, flank))


def fillet_end_angle(member: Member, flank: str, z: FloatArray) -> FloatArray:
    """Return the profile parameter (rad, see `fillet_sheet`) at which a fillet ends in the planes `z` (mm):
    at the joint with the flank, or where undercut lets both intersect.

    Raises ValueError where the fillet intersects the flank above the joint."""
    surface, angle = surface_of(member, flank), tool_round(member.tool, flank).angle
    end = surface.fillet_end(z)
    if not (end <= surface.joint + 1e-9 * surface.scale).all():
        cure = "choose a parabola coefficient nearer to 0"
        raise ValueError(f"the {flank} flank folds back above its fillet: {cure}")
    return np.asarray(angle + (surface.joint - end) / surface.scale)


def bottom_sheet(member: Member, flank: str) -> Sheet:
    """Return the bottom land from the middle of the tooth space to the fillet of one flank.

    The profile parameter is the length (mm) along the tool from the start of the fillet, negative on the
    land. A very narrow land includes the start of the fillet, for triangles of good shape."""
    width, added, last = _bottom_ends(member, flank)
    sigma, start = flank_sign(flank), abs(tool_round(member.tool, flank).centre[1])
    modified = member.modification(flank) is not None
    if modified:
        _require_land(member, flank, width)

    def place(p: FloatArray, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return points and normals of the land, and of the fillet beyond its end."""
        flat = bottom_point(member, flank, sigma * (start + np.maximum(-p, 0.0)), z)
        if modified:  # from the rotation of the fillet to none in the middle of the tooth space
            share = 1.0 + np.minimum(p, 0.0) / width
            turn = _fillet_turn(member, flank, z) * share
            flat = (turned(turn, *np.moveaxis(flat[0], -1, 0)), turned(turn, *np.moveaxis(flat[1], -1, 0)))
        if added == 0.0:
            return flat
        angle = 0.5 * np.pi - np.maximum(p, 0.0) / added * (0.5 * np.pi - last)
        bent = fillet_points(member, flank, angle, z)
        beyond = (p > 0.0)[..., None]
        return np.where(beyond, bent[0], flat[0]), np.where(beyond, bent[1], flat[1])

    return _straight_sheet(member, place, (-width, added))


def _fillet_turn(member: Member, flank: str, z: FloatArray) -> FloatArray:
    """Return the rotation (rad) of a fillet in the planes `z` (mm) by the modification of its flank."""
    surface = surface_of(member, flank)
    turn = turn_rows(surface, np.full(np.shape(z), surface.bottom), np.asarray(z, dtype=float))
    return np.asarray(turn[0])


def _require_land(member: Member, flank: str, width: float) -> None:
    """Raise ValueError if the modification moves a fillet by more than half of `width`: half the land, mm."""
    z = 0.5 * float(member.face_width) * np.linspace(-1.0, 1.0, 9)
    moved = float(np.abs(_fillet_turn(member, flank, z) * root_radius(member, z)).max())
    if moved > 0.5 * width:
        raise ValueError(
            f"the modification of the {flank} flank moves its fillet by {moved:.3g} mm, more than half of"
            f" the {width:.3g} mm from it to the middle of the tooth space: reduce the amounts or the"
            " tip_radius"
        )


def tip_angle(member: Member, flank: str, z: ArrayLike) -> FloatArray:
    """Return the angle (rad) about the gear axis of the tip edge of a flank in the planes `z` (mm), without
    reduction to one turn."""
    angle = half_thickness_angle(member, flank, tip_parameter(member, flank, z), z)
    return np.asarray(flank_sign(flank) * angle)


def tip_sheet(member: Member) -> Sheet:
    """Return the tip cone over the angle (rad) about the axis, from the left to the right flank. Raises
    ValueError for a pointed tooth."""
    # Smallest thickness of the tip. Thinner teeth are called pointed.
    min_tip_modules = 0.01
    half, gamma = 0.5 * float(member.face_width), float(member.cone_angle)
    z = np.linspace(-half, half, 9)
    width = (tip_angle(member, "right", z) - tip_angle(member, "left", z)) * tip_radius(member, z)
    worst, least = int(np.argmin(width)), min_tip_modules * float(member.tool.normal_module)
    if not width[worst] > least:
        text = f"the tooth is pointed at z = {z[worst]:.4g} mm"
        if width[worst] > 0.0:
            text += f": its tip is {width[worst]:.2g} mm thick, it must be at least {least:.2g} mm"
        else:
            text += ", its flanks cross below the tip cone"
        raise ValueError(f"{text}: reduce the addendum, the profile shift or the face width")

    def place(p: FloatArray, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return points and normals of the cone at angles p, rad."""
        radius, cos, sin = tip_radius(member, z), np.cos(p), np.sin(p)
        normals = np.stack(
            (np.cos(gamma) * cos, np.cos(gamma) * sin, np.full_like(p, -np.sin(gamma))), axis=-1
        )
        return np.stack((radius * cos, radius * sin, z), axis=-1), normals

    return Sheet(place, lambda z: tip_angle(member, "left", z), lambda z: tip_angle(member, "right", z), half)


def cut_sheets(member: Member) -> dict[str, Sheet]:
    """Return the surfaces that a tool cuts on one tooth.

    Parameters
    ----------
    member : Member
        A single member.

    Returns
    -------
    dict of Sheet
        By name, in the order of `OUTLINE`. Surfaces on the right, too, are parametrised from the bottom land
        to the tip.

    Raises
    ------
    ValueError
        For a pointed tooth, a flank that undercut removes in a part of the face, and tip rounds of the tool
        that overlap.
    """
    require_flanks(member)
    sheets = {"tip": tip_sheet(member)}
    for flank in ("left", "right"):
        sheets[f"{flank} bottom"] = bottom_sheet(member, flank)
        sheets[f"{flank} fillet"] = fillet_sheet(member, flank)
        sheets[f"{flank} flank"] = flank_sheet(member, flank, to_fillet=True)
    return {name: sheets[name] for name in OUTLINE}


def outline_grids(
    sheets: dict[str, Sheet], tolerance: float, teeth: int = 1, bore_step: float = np.inf
) -> dict[str, SheetGrid]:
    """Return grids on the surfaces of one tooth whose triangles stay within a tolerance.

    Parameters
    ----------
    sheets : dict of Sheet
        Surfaces of `cut_sheets`.
    tolerance : float
        mm.
    teeth : int
        Number of teeth with these grids. Together they have MAX_POINTS points at most.
    bore_step : float
        Width of the cells of the bore, which must not become slivers either, mm.

    Returns
    -------
    dict of SheetGrid
        With the same stations along the face, and equal numbers of rows on the left and on the right.

    Raises
    ------
    ValueError
        For too many points, a tolerance that cannot be met, and fillets that nearly vanish at one end.
    """
    # Share of the tolerance that flanks use. They are large and convex, so that their chords cause most
    # of the volume that a solid lacks.
    flank_tolerance_share = 0.5
    # Largest number of divisions that are tried.
    max_attempts = 12
    _require_wide_fillets(sheets)
    forms = {name: form_of(sheet, tolerance) for name, sheet in sheets.items()}
    aim = {name: tolerance * (flank_tolerance_share if "flank" in name else 1.0) for name in sheets}
    scale = dict.fromkeys(sheets, 1.0)
    for _ in range(max_attempts):
        rows, nz, along = _cells(forms, {name: aim[name] / scale[name] for name in sheets})
        common = {name: replace(form, face=along.face) for name, form in forms.items()}
        rows, nz = _in_shape(sheets, common, rows, nz, bore_step)
        require_memory((sum(rows.values()) + 1.0) * (nz + 1.0), tolerance, teeth)
        worst = {
            name: measured_deviation(sheet, common[name], rows[name], nz) / aim[name]
            for name, sheet in sheets.items()
        }
        if max(worst.values()) <= 1.0:
            return {name: _grid(sheet, common[name], rows[name], nz) for name, sheet in sheets.items()}
        scale = {name: scale[name] * max(1.0, 1.05 * worst[name]) for name in sheets}
    name = max(worst, key=worst.__getitem__)
    raise ValueError(f"the {name} cannot be sampled to {tolerance:g} mm: check the tooth for undercut")


def _require_wide_fillets(sheets: dict[str, Sheet]) -> None:
    """Raise ValueError for a fillet whose widths along the face differ too much."""
    # Largest ratio of the widths of a fillet along the face. Cells that fit its wide end would be slivers at
    # a narrow end, and cells that fit the narrow end would be too many.
    max_fillet_width_ratio = 6.0
    for name in ("left fillet", "right fillet"):
        z = sheets[name].half_width * np.linspace(-1.0, 1.0, 9)
        width = _lengths(grid_of(sheets[name], np.linspace(0.0, 1.0, 33), z).points, 0).sum(axis=0)
        if width.max() > max_fillet_width_ratio * width.min():
            least = f"{width.min():.3g} mm wide at z = {z[np.argmin(width)]:.4g} mm"
            text = f"the {name} is only {least}, and {width.max():.3g} mm elsewhere"
            raise ValueError(
                f"{text}: increase the tip_radius of the tool to at least 0.05 modules, or choose a narrower"
                " face"
            )


def _grid(sheet: Sheet, form: Form, rows: int, nz: int) -> SheetGrid:
    return grid_of(sheet, *stations(form, rows, nz, sheet.half_width))


def require_memory(points: float, tolerance: float, teeth: int) -> None:
    """Raise ValueError if a number of points for each of some teeth exceeds MAX_POINTS."""
    # Memory for each point of a solid with its triangles.
    bytes_per_point = 260
    total = points * teeth
    if total > MAX_POINTS:
        size = f"about {total:.2g} points and {total * bytes_per_point / 2.0**30:.2g} GB of memory"
        limit = f"the limit is {MAX_POINTS:.2g} points"
        text = f"tolerance {tolerance:g} mm for {counted(teeth)} needs {size}, {limit}"
        raise ValueError(f"{text}: increase the tolerance")


def _rows_for(form: Form, columns: int, tolerance: float) -> float:
    """Return the smallest number of rows for a number of columns according to the estimate, else infinity."""
    rows = float(columns_for(form.factors[:, ::-1], np.array([[float(columns)]]), tolerance)[0])
    return rows if estimated_deviation(form, rows, columns) <= tolerance * (1.0 + 1e-9) else np.inf


def _paired(rows: dict[str, float]) -> dict[str, int]:
    """Return whole numbers of rows, equal on the left and on the right."""
    kinds = {name: name.split()[-1] for name in rows}
    most = {kind: max(rows[n] for n in rows if kinds[n] == kind) for kind in kinds.values()}
    return {name: int(np.ceil(most[kind] - 1e-9)) for name, kind in kinds.items()}


def _cells(forms: dict[str, Form], tolerances: dict[str, float]) -> tuple[dict[str, int], int, Form]:
    """Return the rows of each surface and the common number of columns with the fewest points, and the form
    that distributes the columns."""
    columns = {name: cells_for(form, tolerances[name])[1] for name, form in forms.items()}
    finest = max(columns, key=columns.__getitem__)
    best: tuple[float, dict[str, int], int] = (np.inf, {}, 1)
    for nz in np.unique(
        np.geomspace(max(0.4 * columns[finest], 1.0), columns[finest], 5).round().astype(int)
    ):
        rows = {name: _rows_for(form, nz, tolerances[name]) for name, form in forms.items()}
        if np.isfinite(sum(rows.values())):
            paired = _paired(rows)
            best = min(best, (sum(paired.values()) * (nz + 1.0), paired, int(nz)), key=lambda trial: trial[0])
    return best[1], best[2], forms[finest]


def _lengths(points: FloatArray, axis: int) -> FloatArray:
    return np.asarray(np.linalg.norm(np.diff(points, axis=axis), axis=-1))


def _in_shape(
    sheets: dict[str, Sheet], forms: dict[str, Form], rows: dict[str, int], nz: int, bore_step: float
) -> tuple[dict[str, int], int]:
    """Return numbers of rows and columns for which cells are not longer than MAX_ASPECT_RATIO widths."""
    for _ in range(3):
        grids = {name: _grid(sheet, forms[name], rows[name], 4) for name, sheet in sheets.items()}
        step = {name: _lengths(grid.points, 0) for name, grid in grids.items()}
        slope = max(float((_lengths(g.points, 1) / np.diff(g.z)).max()) for g in grids.values())
        columns = slope * np.diff(stations(forms["tip"], 1, nz, sheets["tip"].half_width)[1])
        more: dict[str, float] = dict(rows)
        narrow = float(step["tip"].sum(axis=0).min()) / rows["tip"]
        for name in sheets:
            longest = MAX_ASPECT_RATIO * min(columns.min(), narrow if name.endswith("flank") else np.inf)
            more[name] = max(more[name], rows[name] * float(step[name].max()) / longest)
        shortest = min(float(step[name].min()) * rows[name] / more[name] for name in sheets)
        shortest = min(shortest, bore_step)
        before, rows, share = rows, _paired(more), float(columns.max()) / (MAX_ASPECT_RATIO * shortest)
        if share <= 1.0 and rows == before:
            break
        nz = int(np.ceil(nz * max(share, 1.0) - 1e-9))
    return rows, nz
