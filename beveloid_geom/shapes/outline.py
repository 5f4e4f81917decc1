"""The surfaces a tool leaves on one tooth, and the grids of points on them.

The outline of one tooth runs from the middle of one tooth space over bottom land, fillet, flank
and tip to the middle of the next. Its surfaces are sampled so that their true distance from the
triangles stays below a tolerance. They share the stations along the face, so that neighbours
have their common edges in common. Where a surface is almost straight along one direction,
as a spur gear along its axis, cells are kept from growing into needles.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FloatArray, flank_sign
from ..design.model import Member
from ..gear.fillet import bottom_point, fillet_point, tool_round
from ..gear.flank import half_thickness_angle, tip_parameter, tip_radius
from ..gear.undercut import require_sound
from ..support.argument import ArgumentError
from .sampling import (
    MAX_POINTS,
    Form,
    Place,
    Sheet,
    SheetGrid,
    cells_for,
    columns_for,
    estimated_deviation,
    flank_sheet,
    form_of,
    grid_of,
    measured_deviation,
    stations,
)
from .section import OUTLINE

ASPECT = 20.0
"""Greatest ratio of the sides of a cell. It leaves an angle of 2 deg in a triangle of the most
slanting cells."""
END_ASPECT = 12.0
"""Greatest ratio of the thickness of the tooth, shared out by the columns of its end faces, to the
least cell beside it. Inside, rows of the end faces are narrower than there."""
SHRUNK = 6.0
"""Greatest ratio of the widths of a fillet along the face. A cell that suits it where it is wide would be
a needle where it all but vanishes, and to keep in shape there takes millions."""
FLANK_SHARE = 0.5
"""Share of the tolerance that flanks may use up. They are large and convex: what all their chords cut
off adds up to most of the volume that a solid lacks."""
NARROW = 0.02
"""Modules: a bottom land narrower than this on one side of the space takes in the end of the fillet."""
SHARP = 0.01
"""Modules of tip thickness below which a tooth counts as pointed."""
LEAST_TOLERANCE = 1e-9
"""mm. Less is nobody's tolerance, and out of reach of double precision on a large gear."""
BYTES_PER_POINT = 260
"""Memory taken for each point of a solid while it is built, with its triangles."""
ATTEMPTS = 12


def require_tolerance(tolerance: float) -> None:
    """Raise ValueError for a tolerance (mm) that cannot be meant."""
    if not 0.0 < tolerance < np.inf:
        raise ArgumentError("tolerance", f"must be a positive length in mm, got {tolerance:g}")
    if tolerance < LEAST_TOLERANCE:
        text = f"must be at least {LEAST_TOLERANCE:g} mm, got {tolerance:g}: usual are 0.001 to 0.1"
        raise ArgumentError("tolerance", text)


def counted(teeth: int) -> str:
    """'1 tooth', '2 teeth' ..."""
    return "1 tooth" if teeth == 1 else f"{teeth} teeth"


def _straight_sheet(member: Member, place: Place, ends: tuple[float, float]) -> Sheet:
    return Sheet(
        place, lambda z: ends[0] + 0.0 * z, lambda z: ends[1] + 0.0 * z, 0.5 * float(member.face_width)
    )


def _bottom_ends(member: Member, flank: str) -> tuple[float, float, float]:
    """Find the width (mm) of half the bottom land in the tool, how much of the round is added to it, and
    the angle (rad) of the section normal up to which."""
    rounding, module = tool_round(member.tool, flank), float(member.tool.normal_module)
    width = 0.5 * np.pi * module - abs(rounding.centre[1])
    added = max(NARROW * module - width, 0.0)
    turn = 0.25 * (0.5 * np.pi - rounding.angle)
    if added > 0.0 and rounding.radius * turn > added:
        turn = added / rounding.radius
    return width, added, 0.5 * np.pi - (turn if added > 0.0 else 0.0)


def fillet_sheet(member: Member, flank: str) -> Sheet:
    """Give the fillet below one flank, over the angle of the section normal: bottom land first."""
    ends = _bottom_ends(member, flank)[2], tool_round(member.tool, flank).angle
    return _straight_sheet(member, lambda p, z: fillet_point(member, flank, p, z), ends)


def bottom_sheet(member: Member, flank: str) -> Sheet:
    """Give the bottom land from the middle of the tooth space beside one flank to its fillet, over the
    way along the tool from where the fillet begins (mm). If it is very narrow it takes in the
    end of the fillet, for triangles of a sound shape."""
    width, added, last = _bottom_ends(member, flank)
    sigma, start = flank_sign(flank), abs(tool_round(member.tool, flank).centre[1])

    def place(p: FloatArray, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Give points and normals of the land, and past its end those of the fillet."""
        flat = bottom_point(member, flank, sigma * (start + np.maximum(-p, 0.0)), z)
        if added == 0.0:
            return flat
        angle = 0.5 * np.pi - np.maximum(p, 0.0) / added * (0.5 * np.pi - last)
        bent = fillet_point(member, flank, angle, z)
        beyond = (p > 0.0)[..., None]
        return np.where(beyond, bent[0], flat[0]), np.where(beyond, bent[1], flat[1])

    return _straight_sheet(member, place, (-width, added))


def tip_angle(member: Member, flank: str, z: ArrayLike) -> FloatArray:
    """Find the angle (rad) about the gear axis of the flank's tip edge in the plane `z`, whole turns of a
    long helix counted."""
    angle = half_thickness_angle(member, flank, tip_parameter(member, flank, z), z)
    return np.asarray(flank_sign(flank) * angle)


def tip_sheet(member: Member) -> Sheet:
    """Give the tip cone, over the angle about the axis, from the left to the right flank.

    Raises ValueError for a pointed tooth."""
    half, gamma = 0.5 * float(member.face_width), float(member.cone_angle)
    z = np.linspace(-half, half, 9)
    width = (tip_angle(member, "right", z) - tip_angle(member, "left", z)) * tip_radius(member, z)
    worst, least = int(np.argmin(width)), SHARP * float(member.tool.normal_module)
    if not width[worst] > least:
        text = f"the tooth is pointed at z = {z[worst]:.4g} mm"
        if width[worst] > 0.0:
            text += f": its tip is {width[worst]:.2g} mm thick, the least that is drawn is {least:.2g} mm"
        else:
            text += ", its flanks cross below the tip cone"
        raise ValueError(f"{text}: reduce the addendum, the profile shift or the face width")

    def place(p: FloatArray, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Give points and normals of the cone at angles p, rad."""
        radius, cos, sin = tip_radius(member, z), np.cos(p), np.sin(p)
        normals = np.stack(
            (np.cos(gamma) * cos, np.cos(gamma) * sin, np.full_like(p, -np.sin(gamma))), axis=-1
        )
        return np.stack((radius * cos, radius * sin, z), axis=-1), normals

    return Sheet(place, lambda z: tip_angle(member, "left", z), lambda z: tip_angle(member, "right", z), half)


def cut_sheets(member: Member) -> dict[str, Sheet]:
    """Give the surfaces a tool leaves on one tooth, by name, in the order of `OUTLINE`; those of the
    right side run the other way, from the bottom land up.

    Raises ValueError for a pointed or undercut tooth, and for a tool whose rounds overlap."""
    require_sound(member)
    sheets = {"tip": tip_sheet(member)}
    for flank in ("left", "right"):
        sheets[f"{flank} bottom"] = bottom_sheet(member, flank)
        sheets[f"{flank} fillet"] = fillet_sheet(member, flank)
        sheets[f"{flank} flank"] = flank_sheet(member, flank, tool_round(member.tool, flank).joint)
    return {name: sheets[name] for name in OUTLINE}


def outline_grids(
    sheets: dict[str, Sheet], tolerance: float, teeth: int = 1, bore_arc: float = np.inf
) -> dict[str, SheetGrid]:
    """Give the surfaces of one tooth as grids (rows, nz) with common stations along the face, whose
    triangles stay within `tolerance` (mm); left and right have equal numbers of rows. With
    `bore_arc` (mm), the part of the bore that belongs to the tooth, cells there are kept in shape too.

    Raises ValueError where that takes too many points for the number of `teeth`, or is not
    possible, and for fillets that all but vanish at one end."""
    _require_wide_fillets(sheets)
    forms = {name: form_of(sheet, tolerance) for name, sheet in sheets.items()}
    aim = {name: tolerance * (FLANK_SHARE if "flank" in name else 1.0) for name in sheets}
    scale = dict.fromkeys(sheets, 1.0)
    for _ in range(ATTEMPTS):
        rows, nz, along = _cells(forms, {name: aim[name] / scale[name] for name in sheets})
        common = {name: replace(form, face=along.face) for name, form in forms.items()}
        rows, nz = _in_shape(sheets, common, rows, nz, bore_arc)
        require_memory((sum(rows.values()) + 1.0) * (nz + 1.0), tolerance, teeth)
        worst = {
            name: measured_deviation(sheet, common[name], rows[name], nz) / aim[name]
            for name, sheet in sheets.items()
        }
        if max(worst.values()) <= 1.0:
            return {name: _grid(sheet, common[name], rows[name], nz) for name, sheet in sheets.items()}
        scale = {name: scale[name] * max(1.0, 1.05 * worst[name]) for name in sheets}
    name = max(worst, key=worst.__getitem__)
    raise ValueError(f"the {name} cannot be sampled to {tolerance:g} mm: is the tooth undercut?")


def _require_wide_fillets(sheets: dict[str, Sheet]) -> None:
    """Raise ValueError for a fillet whose widths along the face differ by more than SHRUNK times."""
    for name in ("left fillet", "right fillet"):
        z = sheets[name].half_width * np.linspace(-1.0, 1.0, 9)
        width = _lengths(grid_of(sheets[name], np.linspace(0.0, 1.0, 33), z).points, 0).sum(axis=0)
        if width.max() > SHRUNK * width.min():
            least = f"{width.min():.3g} mm wide at z = {z[np.argmin(width)]:.4g} mm"
            text = f"the {name} is only {least}, and {width.max():.3g} mm elsewhere"
            raise ValueError(
                f"{text}: give the tool a larger tip_radius, 0.05 or more, or take a narrower face"
            )


def _grid(sheet: Sheet, form: Form, rows: int, nz: int) -> SheetGrid:
    return grid_of(sheet, *stations(form, rows, nz, sheet.half_width))


def require_memory(points: float, tolerance: float, teeth: int) -> None:
    """Raise ValueError for a solid of so many points for each of its `teeth`, if they are too many."""
    whole = points * teeth
    if whole > MAX_POINTS:
        size = f"about {whole:.2g} points and {whole * BYTES_PER_POINT / 2.0**30:.2g} GB of memory"
        limit = f"the limit is {MAX_POINTS:.2g} points"
        text = f"tolerance {tolerance:g} mm is too fine: for {counted(teeth)}"
        raise ValueError(f"{text} it takes {size}, {limit}")


def _rows_for(form: Form, columns: int, tolerance: float) -> float:
    """Find the fewest rows with so many columns that the estimate allows, infinity where there are none."""
    rows = float(columns_for(form.shapes[:, ::-1], np.array([[float(columns)]]), tolerance)[0])
    return rows if estimated_deviation(form, rows, columns) <= tolerance * (1.0 + 1e-9) else np.inf


def _paired(rows: dict[str, float]) -> dict[str, int]:
    """As many rows on the left as on the right; two at least where a fillet is parted."""
    least = {"fillet": 2}
    kinds = {name: name.split()[-1] for name in rows}
    most = {kind: max(rows[n] for n in rows if kinds[n] == kind) for kind in kinds.values()}
    return {name: max(int(np.ceil(most[kind] - 1e-9)), least.get(kind, 1)) for name, kind in kinds.items()}


def _cells(forms: dict[str, Form], tolerances: dict[str, float]) -> tuple[dict[str, int], int, Form]:
    """Rows of each surface and the common number of columns that take the fewest points, and the
    form that shares out the columns."""
    own = {name: cells_for(form, tolerances[name])[1] for name, form in forms.items()}
    finest = max(own, key=own.__getitem__)
    best: tuple[float, dict[str, int], int] = (np.inf, {}, 1)
    for nz in np.unique(np.geomspace(max(0.4 * own[finest], 1.0), own[finest], 5).round().astype(int)):
        rows = {name: _rows_for(form, nz, tolerances[name]) for name, form in forms.items()}
        if np.isfinite(sum(rows.values())):
            paired = _paired(rows)
            best = min(best, (sum(paired.values()) * (nz + 1.0), paired, int(nz)), key=lambda found: found[0])
    return best[1], best[2], forms[finest]


def _lengths(points: FloatArray, axis: int) -> FloatArray:
    return np.asarray(np.linalg.norm(np.diff(points, axis=axis), axis=-1))


def _in_shape(
    sheets: dict[str, Sheet], forms: dict[str, Form], rows: dict[str, int], nz: int, bore_arc: float
) -> tuple[dict[str, int], int]:
    """More rows and columns where cells would be longer than ASPECT times their width, on the
    surfaces or in the end faces."""
    for _ in range(3):
        grids = {name: _grid(sheet, forms[name], rows[name], 4) for name, sheet in sheets.items()}
        step = {name: _lengths(grid.points, 0) for name, grid in grids.items()}
        slope = max(float((_lengths(g.points, 1) / np.diff(g.z)).max()) for g in grids.values())
        columns = slope * np.diff(stations(forms["tip"], 1, nz, sheets["tip"].half_width)[1])
        left, right = (grids[f"{side} flank"].points[0] for side in ("left", "right"))
        thickness = float(np.linalg.norm(left - right, axis=-1).max())
        least = min(float(step[name].min()) for name in sheets if name.endswith(("flank", "fillet")))
        more: dict[str, float] = dict(rows)
        more["tip"] = max(rows["tip"], thickness / (END_ASPECT * least))
        narrow = float(step["tip"].sum(axis=0).min()) / more["tip"]
        for name in sheets:
            longest = ASPECT * min(columns.min(), narrow if name.endswith("flank") else np.inf)
            more[name] = max(more[name], rows[name] * float(step[name].max()) / longest)
        across = more["tip"] + 2.0 * more["left bottom"] + more["left fillet"]
        shortest = min(float(step[name].min()) * rows[name] / more[name] for name in sheets)
        shortest = min(shortest, bore_arc / across)
        before, rows, share = rows, _paired(more), float(columns.max()) / (ASPECT * shortest)
        if share <= 1.0 and rows == before:
            break
        nz = int(np.ceil(nz * max(share, 1.0) - 1e-9))
    return rows, nz
