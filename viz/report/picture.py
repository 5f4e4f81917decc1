"""A picture of the pair in mesh as SVG: polygons in the order of their depth, the furthest first.

It needs neither OpenGL nor JavaScript. What it is drawn of is coarse, a chord for half a flank, and where the
gears' teeth stand between each other a piece may hide a little of its neighbour: it is to be looked at, not
measured.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import groupby

import numpy as np

from beveloid_geom import Design, Member
from beveloid_geom.arrays import Codes, FloatArray
from beveloid_geom.contact.placing import Frame, frames_at
from beveloid_geom.gear.flank import tip_radius
from beveloid_geom.operation.first_contact import conjugate_phase
from beveloid_geom.pair.frames import to_fixed
from beveloid_geom.shapes.outline import cut_sheets
from beveloid_geom.shapes.sampling import grid_of
from beveloid_geom.shapes.solid import bore_of, turned

BACK, UP = np.array([0.2, -0.55, -0.8]), np.array([0.0, -1.0, 0.0])
"""Towards the eye, and what is up, in S_f: the pinion stands on the left, the gear beside it."""
LIGHT = np.array([-0.62, 0.72, 0.31])
"""Towards the light: from the eye's upper left."""
STATIONS = np.linspace(-1.0, 1.0, 5)
"""Along the face, in half face widths."""
CUTS = {"bottom": 1, "fillet": 1, "flank": 2, "tip": 1}
"""Chords for each surface of a tooth."""
BESIDE = 2
"""Teeth to either side that an end face may hide."""
LEVELS = 8
"""Shades of a metal, darkest first: classes p0 ... of the pinion, g0 ... of the gear."""
WIDTH = 3000
"""Units of the picture's width; whole numbers are fine enough."""


def pair_picture(design: Design) -> str:
    """Draw a single design as an SVG element of the class `pair-picture`, '' where its layout is not known; a
    member whose teeth cannot be made is a plain blank."""
    phase, eye = float(np.nan_to_num(conjugate_phase(design, "right"))), _eye()
    frames = frames_at(design, 0.0, phase)
    pieces: list[tuple[float, str, FloatArray]] = []
    for letter, member, frame in zip("pg", design.members, frames, strict=True):
        for depth, polygons in _surfaces(member, frame, eye):
            seen = np.isfinite(depth) & (_area(polygons) > 0.0)
            names = [f"{letter}{shade}" for shade in _shades(polygons[seen]).tolist()]
            pieces += zip(depth[seen].tolist(), names, polygons[seen, :, :2], strict=True)
    if not pieces:
        return ""
    pieces.sort(key=lambda piece: piece[0])
    corners = np.concatenate([points for _, _, points in pieces])
    low, high = corners.min(axis=0), corners.max(axis=0)
    scale = WIDTH / (high - low)[0]
    corner = float(low[0]), float(high[1])
    paths = "\n".join(
        f'<path class="{name}" d="{"".join(polygon(points, corner, scale) for *_, points in same)}"/>'
        for name, same in groupby(pieces, lambda piece: piece[1])
    )
    box, title = f"0 0 {WIDTH} {round(scale * (high - low)[1])}", "Pinion, on the left, and gear in mesh"
    return f'<svg class="pair-picture" viewBox="{box}" role="img" aria-label="{title}">\n{paths}\n</svg>'


def _eye() -> FloatArray:
    """Give the unit vectors right, up and towards the eye, (3, 3)."""
    back = BACK / np.linalg.norm(BACK)
    right = np.cross(UP, back)
    right /= np.linalg.norm(right)
    return np.stack((right, np.cross(back, right), back))


def _surfaces(member: Member, frame: Frame, eye: FloatArray) -> Iterator[tuple[FloatArray, FloatArray]]:
    """Give the polygons that bound a gear, (m, corners, 3), against the clock seen from outside, as the
    `eye` has them, with the depths (m,) by which they are sorted: around its teeth, in its bore, and at toe
    and heel a piece for each tooth."""

    def seen_at(points: FloatArray) -> FloatArray:
        return np.asarray(to_fixed(frame, points) @ eye.T)

    teeth = int(member.teeth)
    tooth = _outline(member, 0.5 * float(member.face_width) * STATIONS)
    angles = np.asarray(2.0 * np.pi / teeth * np.arange(teeth), dtype=float)
    ring = np.stack([turned(tooth[:, j], angles) for j in range(len(STATIONS))], axis=2)  # (teeth, n, nz, 3)
    around = np.concatenate((ring, np.roll(ring, -1, axis=0)[:, :1]), axis=1)
    rim = around[:, (0, -1)][:, :, (0, -1)]  # where a tooth begins and ends, at toe and heel
    bore = rim * (bore_of(member, None) / np.linalg.norm(rim[..., :2], axis=-1, keepdims=True))
    bore[..., 2] = rim[..., 2]
    ends = [np.concatenate((around[:, :, j], bore[:, ::-1, j]), axis=1) for j in (0, -1)]
    bore[:, :, 1, :2] = bore[:, :, 0, :2]  # its walls run straight, not with the teeth

    sides = seen_at(_quads(around))  # (teeth, cells, 4, 3)
    depth = sides[..., 2].mean(axis=-1)
    yield depth.ravel(), sides.reshape(-1, 4, 3)
    walls = seen_at(_quads(bore))[:, :, ::-1].reshape(-1, 4, 3)
    yield walls[..., 2].mean(axis=-1), walls
    # No end face is hidden by its own gear: it comes after the cells of its tooth and of those beside it.
    nearest = np.where(_area(sides) > 0.0, depth, -np.inf).max(axis=1)
    nearest = np.stack([np.roll(nearest, k) for k in range(-BESIDE, BESIDE + 1)]).max(axis=0)
    for end in (seen_at(ends[0][:, ::-1]), seen_at(ends[1])):
        yield np.maximum(end[..., 2].mean(axis=-1), nearest + 1e-6), end


def _quads(grid: FloatArray) -> FloatArray:
    """Give the cells (teeth, m, 4, 3) of grids (teeth, n, nz, 3)."""
    corners = (grid[:, :-1, :-1], grid[:, 1:, :-1], grid[:, 1:, 1:], grid[:, :-1, 1:])
    return np.stack(corners, axis=3).reshape(len(grid), -1, 4, 3)


def _outline(member: Member, z: FloatArray) -> FloatArray:
    """Give the outline of tooth 0 from the middle of one tooth space to just before that of the next, (n, nz,
    3), mm; of a member whose teeth cannot be made the arc of its tip cone."""
    try:
        sheets = cut_sheets(member)
    except ValueError:
        angle = np.pi / float(member.teeth) * np.array([[-1.0], [0.0]])
        radius = tip_radius(member, z)
        around = radius * np.cos(angle), radius * np.sin(angle), z + 0.0 * angle
        return np.stack(around, axis=-1)
    rows = []
    for name, sheet in sheets.items():
        share = np.linspace(0.0, 1.0, CUTS[name.split()[-1]] + 1)
        grid = grid_of(sheet, share, z).points
        rows.append((grid[::-1] if name.startswith("right") else grid)[:-1])
    return np.concatenate(rows)


def _area(points: FloatArray) -> FloatArray:
    """Give twice the areas (...) of polygons (..., n, 3) as seen, positive against the clock."""
    x, y = points[..., 0], points[..., 1]
    return np.asarray((x * np.roll(y, -1, axis=-1) - y * np.roll(x, -1, axis=-1)).sum(axis=-1))


def _shades(points: FloatArray) -> Codes:
    """Give the shades (m,) of polygons (m, n, 3) under the light."""
    normal = np.cross(points, np.roll(points, -1, axis=1)).sum(axis=1)
    share = normal @ LIGHT / np.linalg.norm(normal, axis=1)
    return np.asarray(np.round((LEVELS - 1) * np.clip(0.35 + 0.65 * share, 0.0, 1.0)).astype(np.int8))


def polygon(points: FloatArray, corner: tuple[float, float], scale: float) -> str:
    """Write a polygon (n, 2) in whole units from the picture's upper left `corner`, each point but the first
    from the one before."""
    found = np.round((points - corner) * (scale, -scale)).astype(int)
    moves = "".join(f" {x} {y}" for x, y in np.diff(found, axis=0).tolist() if x or y)
    return f"M{found[0, 0]} {found[0, 1]}l{moves[1:]}z".replace(" -", "-")
