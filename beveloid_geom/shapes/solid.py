"""A whole gear, or some teeth of it, as one closed surface of triangles.

`outline` samples the surfaces that the tool leaves on one tooth, `section` fills the outlines of toe
and heel with quadrilaterals. These are the end faces; their inner edge is that of the bore, and
along their sides a tooth joins the next one or is cut from it. Surfaces share the points of
their common edges, so that the solid is closed by construction. Other teeth are the same, turned.

Pictures are drawn from the same pieces (`surface_mesh.gear_mesh`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..arrays import FloatArray, Indices
from ..design.model import Member
from ..gear.fillet import root_radius
from ..support.argument import ArgumentError
from ..support.few_lines import few_lines
from .outline import cut_sheets, outline_grids, require_memory, require_tolerance
from .sampling import Faces, Sheet, SheetGrid, grid_faces, grid_of
from .section import SIDES, Section, section_of, section_size

NAMES = (
    *("right flank", "left flank", "right fillet", "left fillet"),
    *("tip", "bottom", "toe", "heel", "bore", *SIDES),
)
BORE_SHARE = 0.45
"""Radius of the bore if none is given, as a share of the least root radius."""
LEAST_BORE, LEAST_RIM = 0.02, 0.1
"""The bore is at least this share of the least root radius, and leaves a rim of at least so many modules:
next to the axis, and in a thinner rim, cells would be needles."""
SHOWN = 1e-5
"""Of the limits: messages show six digits of them, and what they show is allowed."""
LEAST_ANGLE = math.radians(1.2)
"""Angle in the triangles of the end faces below which the tooth takes more columns."""
LEAST_TEETH = 2
"""The section of a single tooth lies all round the axis: it has no neighbour to be cut from."""
ATTEMPTS = 6


@dataclass(frozen=True, eq=False)
class Solid:
    """A closed surface of triangles: `points` (n, 3), mm, own frame, each there once; `faces`
    (m, 3) winding outwards; `part` (m,): which of `names` each face belongs to."""

    __repr__ = few_lines

    points: FloatArray
    faces: Faces
    part: Indices
    names: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Piece:
    """One surface of a tooth: its `points` (mm) with exact unit `normals` out of the metal (p, 3),
    the number (p,) each has in the tooth's `nodes`, and `faces` (f, 3) of its own points."""

    name: str
    nodes: Indices
    points: FloatArray
    normals: FloatArray
    faces: Faces


@dataclass(frozen=True, eq=False)
class ToothSurface:
    """Surface of one tooth with its part of the body: `points` (n, 3), mm, of which some may be
    unused, `pieces`, and the points (k,) of either side; the last side is the first, turned."""

    points: FloatArray
    pieces: tuple[Piece, ...]
    first_side: Indices
    last_side: Indices


def bore_of(member: Member, bore_radius: float | None) -> float:
    """Find the radius (mm) of the bore: BORE_SHARE of the least root radius if `bore_radius` is None. Raises
    ValueError outside the limits LEAST_BORE and LEAST_RIM."""
    half = 0.5 * float(member.face_width)
    root = float(root_radius(member, (-half, half)).min())
    bore = BORE_SHARE * root if bore_radius is None else float(bore_radius)
    least, most = LEAST_BORE * root, root - LEAST_RIM * float(member.tool.normal_module)
    if not least * (1.0 - SHOWN) <= bore <= most * (1.0 + SHOWN):
        limits = f"between {least:.6g} and {most:.6g} mm, got {bore:.6g}"
        why = f"{LEAST_BORE:g} of the least root radius {root:.6g} mm, and {LEAST_RIM:g} modules less than it"
        raise ArgumentError("bore_radius", f"must be {limits}: {why}")
    return bore


def tooth_surface(
    member: Member, tolerance: float, bore_radius: float | None = None, teeth: int = 1
) -> ToothSurface:
    """Make the surface of one tooth of a single member with its part of the body, own frame; `tolerance`
    (mm) is the greatest distance of its triangles from the surfaces the tool cuts.

    Raises ValueError for a gear of one tooth, a pointed or undercut tooth, a tool whose rounds overlap,
    a bore out of its limits, and where `teeth` of them take too many points."""
    require_tolerance(tolerance)
    if member.teeth < LEAST_TEETH:
        text = f"teeth must be at least {LEAST_TEETH} for a solid, got {member.teeth:g}"
        raise ValueError(f"{text}: the section of a single tooth lies all round the axis")
    sheets, pitch = cut_sheets(member), 2.0 * math.pi / float(member.teeth)
    bore = bore_of(member, bore_radius)
    grids = _around(outline_grids(sheets, tolerance, teeth, pitch * bore))
    grids, section = _filled(grids, sheets["tip"], bore, tolerance, teeth)
    walls = {name: (grid.points, grid.normals) for name, grid in grids.items()}
    walls |= _inner_walls(section, grids["left bottom"].points[0], pitch)
    nz, inner = len(grids["tip"].z), np.ones(len(section.points), dtype=bool)
    inner[np.concatenate(list(section.boundary.values()))] = False
    # Nodes on a wall have a number at each station, those inside one at toe and one at heel.
    on_wall, inside, count = np.cumsum(~inner) - 1, np.cumsum(inner) - 1, int(inner.sum())
    start = nz * (len(inner) - count)
    ends = [np.where(inner, start + end * count + inside, on_wall * nz + end * (nz - 1)) for end in (0, 1)]
    points = np.empty((start + 2 * count, 3))
    numbers = {}
    for name, (at, _) in walls.items():
        numbers[name] = on_wall[section.boundary[name], None] * nz + np.arange(nz)
        points[numbers[name]] = at
    for end in (0, 1):
        points[ends[end]] = section.points[:, -end]
    pieces = [_piece(name, numbers[name], at, normals) for name, (at, normals) in walls.items()]
    # Cut as the first side is, for the teeth of two solids to fit.
    pieces[-1] = replace(pieces[-1], faces=pieces[-2].faces[:, ::-1])
    pieces += [_end_face(section, end, ends[end]) for end in (0, 1)]
    first, last = (numbers[name].ravel() for name in SIDES)
    return ToothSurface(points, tuple(pieces), first, last)


def _around(grids: dict[str, SheetGrid]) -> dict[str, SheetGrid]:
    """Give the grids, all with their rows against the clock."""

    def turned_round(grid: SheetGrid) -> SheetGrid:
        return SheetGrid(grid.points[::-1], grid.normals[::-1], grid.parameter[::-1], grid.z)

    return {name: turned_round(grid) if "right" in name else grid for name, grid in grids.items()}


def _filled(
    grids: dict[str, SheetGrid], tip: Sheet, bore: float, tolerance: float, teeth: int
) -> tuple[dict[str, SheetGrid], Section]:
    """Give the section at toe, mid-face and heel, of more columns at the tip where its cells are too
    slender or too few on the bore; these come with the grids."""
    best: tuple[tuple[float, float], dict[str, SheetGrid], Section] | None = None
    last = len(grids["tip"].z) - 1
    at = sorted({0, last // 2, last})
    for _ in range(ATTEMPTS):
        outline = {name: grid.points[:, at] for name, grid in grids.items()}
        size, walls = section_size(outline, bore)[0], sum(grid.points.size / 3.0 for grid in grids.values())
        require_memory(1.1 * walls + 2.0 * size, tolerance, teeth)
        section = section_of(outline, bore)
        ends = section.points[:, [0, -1]].swapaxes(0, 1)
        least = min(float(least_angle(end, _halved(end, section.quads)).min()) for end in ends)
        inner = section.points[section.boundary["bore"], 0]
        chord = float(np.linalg.norm(np.diff(inner, axis=0), axis=-1).max())
        sagitta = bore - np.sqrt(bore**2 - 0.25 * chord**2)
        quality = min(tolerance - sagitta, 0.0), least
        if best is not None and quality <= best[0]:
            break
        best = quality, grids, section
        more = max(LEAST_ANGLE / least, np.sqrt(sagitta / tolerance))
        if more <= 1.0:
            break
        rows = int(np.ceil(1.1 * more * (len(grids["tip"].points) - 1)))
        grids = {**grids, "tip": grid_of(tip, np.linspace(0.0, 1.0, rows + 1), grids["tip"].z)}
    assert best is not None
    return best[1:]


def _inner_walls(
    section: Section, edge: FloatArray, pitch: float
) -> dict[str, tuple[FloatArray, FloatArray]]:
    """Find points and normals (k, nz, 3) of the bore and of the sides, at the stations of the first
    side's outer `edge` (nz, 3), as the section has them at toe and heel."""
    outer, z = edge @ (1.0, 1.0j, 0.0), edge[:, 2]
    first, ring = (
        section.points[section.boundary[name], 0] @ (1.0, 1.0j, 0.0) for name in ("first side", "bore")
    )
    bore = float(np.abs(ring[0]))
    depth = ((np.abs(first[0]) - np.abs(first)) / (np.abs(first[0]) - bore))[:, None]
    side = outer - outer / np.abs(outer) * depth * (np.abs(outer) - bore)
    shares = np.stack([_turns(section, station) for station in (0, -1)], axis=-1)
    shares = shares[:, :1] + (shares[:, 1:] - shares[:, :1]) * (z - z[0]) / (z[-1] - z[0])
    inner = bore * outer / np.abs(outer) * np.exp(1.0j * shares)
    walls = {}
    for name, plane in (("bore", inner), (SIDES[0], side), (SIDES[1], side * np.exp(1.0j * pitch))):
        points = np.stack((plane.real, plane.imag, np.broadcast_to(z, plane.shape)), axis=-1)
        normals = -points * (1.0, 1.0, 0.0)
        if name in SIDES:
            normals = np.cross(np.gradient(points, axis=0), np.gradient(points, axis=1))
            normals *= -1.0 if name == SIDES[0] else 1.0
        walls[name] = points, normals / np.linalg.norm(normals, axis=-1, keepdims=True)
    return walls


def _turns(section: Section, station: int) -> FloatArray:
    """Find angles (rad) on the bore from the first side, at a station."""
    ring = section.points[section.boundary["bore"], station] @ (1.0, 1.0j, 0.0)
    return np.asarray(np.unwrap(np.angle(ring / ring[0])))


def _piece(curve: str, numbers: Indices, points: FloatArray, normals: FloatArray) -> Piece:
    """Make what a curve of the section's boundary draws along the face: numbers (k, nz), points and
    normals (k, nz, 3). Raises ValueError where its triangles are turned over."""
    faces = grid_faces(points, normals)
    flat, outward = points.reshape(-1, 3), normals.reshape(-1, 3)
    a, b, c = flat[faces.T]
    if not np.all(np.einsum("ni,ni->n", np.cross(b - a, c - a), outward[faces[:, 0]]) > 0.0):
        raise ValueError(
            f"the surface of the {curve} folds back: take a less deep tool or a larger tip radius"
        )
    return Piece(surface_name(curve), numbers.ravel(), flat, outward, faces)


def _end_face(section: Section, end: int, numbers: Indices) -> Piece:
    """Make toe (0) or heel (1) of the section's quadrilaterals, each cut so that its least angle is
    greatest."""
    points, sign = section.points[:, -end], 2 * end - 1
    faces = _halved(points, section.quads)[:, ::sign]
    return Piece(
        ("toe", "heel")[end], numbers, points, np.broadcast_to((0.0, 0.0, sign), points.shape), faces
    )


def _halved(points: FloatArray, quads: Indices) -> Faces:
    """Make triangles (2 m, 3) of quadrilaterals (m, 4), wound as they are."""
    a, b, c, d = (quads[:, i] for i in range(4))
    cuts = np.stack(((a, b, c, a, c, d), (a, b, d, b, c, d)), axis=-1).reshape(2, 3, -1, 2)
    cuts = cuts.transpose(2, 3, 0, 1)  # (m, cut, triangle, corner)
    best = least_angle(points, cuts).min(axis=-1).argmax(axis=-1)
    return np.asarray(cuts[np.arange(len(quads)), best].reshape(-1, 3))


def least_angle(points: FloatArray, faces: Faces) -> FloatArray:
    """Find the least angle (rad) of triangles (..., 3) of `points` (n, 3)."""
    corners = points[faces]
    sides = np.roll(corners, -1, axis=-2) - corners
    back = -np.roll(sides, 1, axis=-2)
    across = np.linalg.norm(np.cross(sides, back), axis=-1)
    return np.asarray(np.arctan2(across, np.einsum("...i,...i", sides, back)).min(axis=-1))


def gear_solid(
    member: Member, tolerance: float, teeth: int | None = None, bore_radius: float | None = None
) -> Solid:
    """Build a gear, or some teeth of it, as a closed surface of triangles in the own frame.

    Parameters
    ----------
    member : Member
        A single one.
    tolerance : float
        Greatest distance of a triangle from the surface, mm.
    teeth : int, optional
        Number of neighbouring teeth with their part of the body, the first at angle 0, the others against
        the clock seen from the heel; all are the whole gear.
    bore_radius : float, optional
        mm; 0.45 of the root radius unless given.

    Returns
    -------
    Solid

    Raises
    ------
    ValueError
        As `tooth_surface`, and for a number of teeth the gear has not.
    """
    count = int(member.teeth)
    wanted = count if teeth is None else teeth
    if not 0 < wanted <= count:
        raise ValueError(f"teeth must be between 1 and {count}, got {wanted}")
    tooth = tooth_surface(member, tolerance, bore_radius, wanted)
    one = len(tooth.points), tooth.first_side, tooth.last_side
    numbers = np.stack(joined_numbers([one] * wanted, wanted == count))
    faces, part = [], []
    for piece in tooth.pieces:
        shown = numbers[teeth_with(piece.name, wanted, wanted == count)]
        some = shown[:, piece.nodes[piece.faces]].reshape(-1, 3)
        faces.append(some)
        part.append(np.full(len(some), NAMES.index(piece.name)))
    used = np.zeros(numbers.size, dtype=bool)
    every = np.concatenate(faces)
    used[every] = True
    angles = np.asarray(2.0 * math.pi / count * np.arange(wanted), dtype=float)
    points = turned(tooth.points, angles).reshape(-1, 3)
    return Solid(points[used], (np.cumsum(used) - 1)[every], np.concatenate(part), NAMES)


def joined_numbers(teeth: Sequence[tuple[int, Indices, Indices]], closed: bool) -> list[Indices]:
    """Number the points of some neighbouring teeth, given how many each has and which are on its first and on
    its last side: those of a last side as those of the first one of the next tooth; `closed` where the next
    of the last tooth is the first."""
    starts = np.cumsum([0, *(size for size, _, _ in teeth)])
    numbers = [np.arange(start, start + size) for start, (size, _, _) in zip(starts, teeth, strict=False)]
    ahead = [own[first] for own, (_, first, _) in zip(numbers, teeth, strict=True)]
    for k in range(len(teeth) if closed else len(teeth) - 1):
        numbers[k][teeth[k][2]] = ahead[(k + 1) % len(teeth)]
    return numbers


def teeth_with(name: str, teeth: int, closed: bool) -> slice:
    """Find which of some neighbouring teeth show a surface: the first and the last one the sides, at which
    they are cut from the others, and none if they are the whole gear."""
    if name not in SIDES:
        return slice(None)
    return slice(0, 0) if closed else slice(0, 1) if name == SIDES[0] else slice(teeth - 1, None)


def surface_name(curve: str) -> str:
    """Name the surface that a curve of the section draws along the face: the bottom land has two."""
    return "bottom" if curve.endswith("bottom") else curve


def turned(vectors: FloatArray, angles: FloatArray) -> FloatArray:
    """Turn vectors (n, 3) about z by each of the angles (k,): (k, n, 3)."""
    plane = np.exp(1.0j * angles)[:, None] * (vectors[:, :2] @ (1.0, 1.0j))
    return np.stack((plane.real, plane.imag, np.broadcast_to(vectors[:, 2], plane.shape)), axis=-1)
