"""Picture of the pair in mesh as SVG: polygons in order of depth, most distant first.

The picture needs neither OpenGL nor JavaScript. It is coarse (one chord for half a flank), and where teeth of
both gears interlock, a polygon may cover a small part of its neighbour. It is an illustration, not for
measuring.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import groupby

import numpy as np

from beveloid_geom import Design, Member
from beveloid_geom.arrays import Codes, FloatArray
from beveloid_geom.contact.mesh_position import Frame, frames_at
from beveloid_geom.gear.flank_limits import tip_radius
from beveloid_geom.operation.engagement import conjugate_phase
from beveloid_geom.pair.frames import to_fixed
from beveloid_geom.shapes.sheet import grid_of
from beveloid_geom.shapes.solid import rotated_copies
from beveloid_geom.shapes.tooth_body import bore_of
from beveloid_geom.shapes.tooth_boundary import cut_sheets

from ..rendering.camera import Camera

SHADE_COUNT = 8
"""Number of shades of a metal, darkest first: classes p0 ... of the pinion, g0 ... of the gear."""
EYE = Camera(np.array([-0.2, 0.55, 0.8]), np.array([0.0, -1.0, 0.0]), np.zeros(3), 1.0).axes
"""Unit vectors right, up and towards the viewer (rows) in S_f: pinion on the left, gear on the right."""


def pair_picture(design: Design) -> str:
    """Return a picture of a single design as an SVG element of class `pair-picture`.

    Returns '' if the layout is unknown. A member whose teeth have no surface is drawn as a blank.
    """
    # Width of the picture in units; coordinates are rounded to whole units.
    width = 3000
    phase = float(np.nan_to_num(conjugate_phase(design, "right")))
    frames = frames_at(design, 0.0, phase)
    pieces: list[tuple[float, str, FloatArray]] = []
    for letter, member, frame in zip("pg", design.members, frames, strict=True):
        for depth, polygons in _surfaces(member, frame):
            seen = np.isfinite(depth) & (_area(polygons) > 0.0)
            names = [f"{letter}{shade}" for shade in _shades(polygons[seen]).tolist()]
            pieces += zip(depth[seen].tolist(), names, polygons[seen, :, :2], strict=True)
    if not pieces:
        return ""
    pieces.sort(key=lambda piece: piece[0])
    corners = np.concatenate([points for _, _, points in pieces])
    low, high = corners.min(axis=0), corners.max(axis=0)
    scale = width / (high - low)[0]
    corner = float(low[0]), float(high[1])
    paths = "\n".join(
        f'<path class="{name}" d="{"".join(polygon(points, corner, scale) for *_, points in same)}"/>'
        for name, same in groupby(pieces, lambda piece: piece[1])
    )
    box, title = f"0 0 {width} {round(scale * (high - low)[1])}", "Pinion, on the left, and gear in mesh"
    return f'<svg class="pair-picture" viewBox="{box}" role="img" aria-label="{title}">\n{paths}\n</svg>'


def _surfaces(member: Member, frame: Frame) -> Iterator[tuple[FloatArray, FloatArray]]:
    """Return the polygons of a gear with the depths by which they are sorted: teeth, bore, and end faces in
    one piece per tooth.

    Parameters
    ----------
    member : Member
        Gear.
    frame : tuple
        Rotation and origin in S_f.

    Yields
    ------
    tuple of ndarray
        Depths (m,), mm, larger towards the viewer, and polygons (m, corners, 3), counterclockwise seen from
        outside.
    """
    # Sections along the face, in half face widths.
    stations = np.linspace(-1.0, 1.0, 5)
    # Number of teeth to either side that an end face may cover.
    adjacent = 2

    def seen_at(points: FloatArray) -> FloatArray:
        return np.asarray(to_fixed(frame, points) @ EYE.T)

    teeth = int(member.teeth)
    tooth = _outline(member, 0.5 * float(member.face_width) * stations)
    angles = np.asarray(2.0 * np.pi / teeth * np.arange(teeth), dtype=float)
    copies = [rotated_copies(tooth[:, j], angles) for j in range(len(stations))]
    ring = np.stack(copies, axis=2)  # (teeth, n, nz, 3)
    around = np.concatenate((ring, np.roll(ring, -1, axis=0)[:, :1]), axis=1)
    rim = around[:, (0, -1)][:, :, (0, -1)]  # first and last point of a tooth at both ends of the face
    bore = rim * (bore_of(member, None) / np.linalg.norm(rim[..., :2], axis=-1, keepdims=True))
    bore[..., 2] = rim[..., 2]
    ends = [np.concatenate((around[:, :, j], bore[:, ::-1, j]), axis=1) for j in (0, -1)]
    bore[:, :, 1, :2] = bore[:, :, 0, :2]  # the wall of the bore is straight, unlike the teeth

    sides = seen_at(_quads(around))  # (teeth, cells, 4, 3)
    depth = sides[..., 2].mean(axis=-1)
    yield depth.ravel(), sides.reshape(-1, 4, 3)
    walls = seen_at(_quads(bore))[:, :, ::-1].reshape(-1, 4, 3)
    yield walls[..., 2].mean(axis=-1), walls
    # An end face is in front of its gear: it is drawn after the cells of its tooth and the neighbouring
    # teeth.
    nearest = np.where(_area(sides) > 0.0, depth, -np.inf).max(axis=1)
    nearest = np.stack([np.roll(nearest, k) for k in range(-adjacent, adjacent + 1)]).max(axis=0)
    for end in (seen_at(ends[0][:, ::-1]), seen_at(ends[1])):
        yield np.maximum(end[..., 2].mean(axis=-1), nearest + 1e-6), end


def _quads(grid: FloatArray) -> FloatArray:
    """Return the cells (teeth, m, 4, 3) of grids (teeth, n, nz, 3)."""
    corners = (grid[:, :-1, :-1], grid[:, 1:, :-1], grid[:, 1:, 1:], grid[:, :-1, 1:])
    return np.stack(corners, axis=3).reshape(len(grid), -1, 4, 3)


def _outline(member: Member, z: FloatArray) -> FloatArray:
    """Return the outline (n, nz, 3), mm, of tooth 0 from the middle of one space to just before the middle of
    the next. For teeth without a surface, the arc of the tip cone."""
    # Number of chords for each surface of a tooth.
    cuts = {"bottom": 1, "fillet": 1, "flank": 2, "tip": 1}
    try:
        sheets = cut_sheets(member)
    except ValueError:
        angle = np.pi / float(member.teeth) * np.array([[-1.0], [0.0]])
        radius = tip_radius(member, z)
        around = radius * np.cos(angle), radius * np.sin(angle), z + 0.0 * angle
        return np.stack(around, axis=-1)
    rows = []
    for name, sheet in sheets.items():
        share = np.linspace(0.0, 1.0, cuts[name.split()[-1]] + 1)
        grid = grid_of(sheet, share, z).points
        rows.append((grid[::-1] if name.startswith("right") else grid)[:-1])
    return np.concatenate(rows)


def _area(points: FloatArray) -> FloatArray:
    """Return twice the areas (...) of polygons (..., n, 3) in the picture, positive if counterclockwise."""
    x, y = points[..., 0], points[..., 1]
    return np.asarray((x * np.roll(y, -1, axis=-1) - y * np.roll(x, -1, axis=-1)).sum(axis=-1))


def _shades(points: FloatArray) -> Codes:
    """Return the shades (m,) of polygons (m, n, 3)."""
    # Direction towards the light, from the upper left of the viewer.
    light = np.array([-0.62, 0.72, 0.31])
    normal = np.cross(points, np.roll(points, -1, axis=1)).sum(axis=1)
    share = normal @ light / np.linalg.norm(normal, axis=1)
    return np.asarray(np.round((SHADE_COUNT - 1) * np.clip(0.35 + 0.65 * share, 0.0, 1.0)).astype(np.int8))


def polygon(points: FloatArray, corner: tuple[float, float], scale: float) -> str:
    """Return a polygon (n, 2) in whole units from the upper left corner; points are relative to the previous
    point."""
    places = np.round((points - corner) * (scale, -scale)).astype(int)
    moves = "".join(f" {x} {y}" for x, y in np.diff(places, axis=0).tolist() if x or y)
    return f"M{places[0, 0]} {places[0, 1]}l{moves[1:]}z".replace(" -", "-")
