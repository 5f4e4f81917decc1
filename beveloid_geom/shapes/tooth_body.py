"""The surface of one tooth with the part of the body that belongs to it.

`tooth_boundary` samples the surfaces that the tool cuts on one tooth. The part of the body ends at the bore
and at two sides. The sides are in the middle of the tooth spaces, where the tooth joins the next one or is
cut from it. All these surfaces are grids with the same stations along the face. Their first and last
stations bound the plane end faces (toe and heel), which `polygon` triangulates. Neighbouring surfaces share
the points of their common edge.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from ..arrays import FloatArray, Indices
from ..design.member import Member
from ..gear.fillet import root_radius
from ..support.argument import ArgumentError
from .polygon import triangulate_polygon
from .section import OUTLINE, SIDES
from .sheet import Faces, SheetGrid, grid_faces
from .tooth_boundary import MAX_ASPECT_RATIO, cut_sheets, outline_grids, require_memory, require_tolerance


@dataclass(frozen=True, eq=False)
class Piece:
    """One surface of a tooth: `points` (p, 3), mm, with outward unit `normals` (p, 3), the indices
    `nodes` (p,) of these points in the tooth, and `faces` (f, 3), indices of `points`.

    Normals are exact, except on the sides: there they are computed from differences of the points."""

    name: str
    nodes: Indices
    points: FloatArray
    normals: FloatArray
    faces: Faces


@dataclass(frozen=True, eq=False)
class ToothBody:
    """Surface of one tooth with its part of the body: `points` (n, 3), mm, `pieces`, and the indices (k,) of
    the points on both sides. The last side is the first side rotated by one pitch."""

    points: FloatArray
    pieces: tuple[Piece, ...]
    first_side: Indices
    last_side: Indices


def bore_of(member: Member, bore_radius: float | None) -> float:
    """Return the radius of the bore.

    Parameters
    ----------
    member : Member
        A single member.
    bore_radius : float or None
        mm; 0.45 times the smallest root radius if None.

    Returns
    -------
    float
        mm.

    Raises
    ------
    ArgumentError
        If the radius is too small, or too near the root.
    """
    message_rounding = 1e-5  # messages show the limits with six digits, and the shown numbers are accepted
    half = 0.5 * float(member.face_width)
    root = float(root_radius(member, (-half, half)).min())
    bore = 0.45 * root if bore_radius is None else float(bore_radius)
    # Smallest radius of the bore over the smallest root radius. Cells closer to the axis would be slivers.
    min_bore_ratio = 0.02
    # Smallest distance of the bore from the root. Cells in a thinner rim would be slivers.
    min_rim_modules = 0.1
    least, most = min_bore_ratio * root, root - min_rim_modules * float(member.tool.normal_module)
    if not least * (1.0 - message_rounding) <= bore <= most * (1.0 + message_rounding):
        limits = f"between {least:.6g} and {most:.6g} mm, got {bore:.6g}"
        why = f"{min_bore_ratio:g} times the smallest root radius, {root:.6g} mm,"
        why += f" and {min_rim_modules:g} modules less than this radius"
        raise ArgumentError("bore_radius", f"must be {limits}: {why}")
    return bore


def tooth_surface(
    member: Member, tolerance: float, bore_radius: float | None = None, teeth: int = 1
) -> ToothBody:
    """Return the surface of one tooth with its part of the body, in the frame of the gear.

    Parameters
    ----------
    member : Member
        A single member.
    tolerance : float
        Largest distance of the triangles from the exact surfaces, mm.
    bore_radius : float, optional
        As in `bore_of`.
    teeth : int
        Number of teeth for which the surface is used. It limits the number of points. The sides are within
        the tolerance only if this number is less than that of the gear.

    Returns
    -------
    ToothBody

    Raises
    ------
    ValueError
        For a gear with one tooth, a pointed tooth, flanks that undercut removes, tip rounds of the tool that
        overlap, a bore outside its limits, and too many points.
    """
    # The section of a gear with a single tooth surrounds the axis, so that it has no sides.
    min_teeth = 2
    require_tolerance(tolerance)
    if member.teeth < min_teeth:
        text = f"teeth must be at least {min_teeth} for a solid, got {member.teeth:g}"
        raise ValueError(f"{text}: the section of a single tooth surrounds the axis")
    pitch, bore = 2.0 * math.pi / float(member.teeth), bore_of(member, bore_radius)
    across = _bore_cells(bore, pitch, tolerance)
    grids = _around(outline_grids(cut_sheets(member), tolerance, teeth, pitch * bore / across))
    walls = {name: (grid.points, grid.normals) for name, grid in grids.items()}
    # The sides are seen only if teeth are cut off.
    side_tolerance = tolerance if teeth < member.teeth else np.inf
    walls |= _inner_walls(grids["left bottom"], bore, pitch, across, side_tolerance)
    rings = _rings({name: len(points) for name, (points, _) in walls.items()})
    nz, count = len(grids["tip"].z), len(np.unique(np.concatenate(list(rings.values()))))
    require_memory(count * (nz + 1.0), tolerance, teeth)
    numbers = {name: ring[:, None] * nz + np.arange(nz) for name, ring in rings.items()}
    points = np.empty((count * nz, 3))
    for name, (at, _) in walls.items():
        points[numbers[name]] = at
    points[:, 2] = np.tile(grids["tip"].z, count)  # all stations are exactly plane
    pieces = [_piece(name, numbers[name], at, normals) for name, (at, normals) in walls.items()]
    # The last side is divided like the first one, so that two teeth fit together.
    pieces[-1] = replace(pieces[-1], faces=pieces[-2].faces[:, ::-1])
    for name, end in (("toe", 0), ("heel", nz - 1)):
        ring = np.arange(count) * nz + end
        inside, piece = _end_face(name, points, ring, len(points))
        points = np.concatenate((points, inside))
        pieces.append(piece)
    first, last = (numbers[name].ravel() for name in SIDES)
    return ToothBody(points, tuple(pieces), first, last)


def _around(grids: dict[str, SheetGrid]) -> dict[str, SheetGrid]:
    """Return the grids with their rows in counter-clockwise order."""

    def reversed_rows(grid: SheetGrid) -> SheetGrid:
        return SheetGrid(grid.points[::-1], grid.normals[::-1], grid.parameter[::-1], grid.z)

    return {name: reversed_rows(grid) if "right" in name else grid for name, grid in grids.items()}


def _bore_cells(bore: float, pitch: float, tolerance: float) -> int:
    """Return the number of chords that approximate one `pitch` (rad) of the bore within the tolerance (mm).

    A chord spans 120 deg at most, so that the bore of a complete gear has three or more."""
    return math.ceil(pitch / (2.0 * math.acos(max(1.0 - tolerance / bore, 0.5))) - 1e-9)


def _depths(
    radii: tuple[float, float], cells: tuple[float, float], longest: float, pitch: float
) -> FloatArray:
    """Return stations 0 ... 1 along a side, from the root to the bore at the given `radii` (mm).

    Cells grow from the size of the neighbouring `cells` (mm) at both ends. They are limited to
    `longest` (mm) and to a multiple of the width of the part of the body that belongs to the tooth."""
    (root, bore), ends = radii, ([0.0], [0.0])
    # Ratio of successive cells along the sides, from the root and from the bore.
    side_growth = 3.0
    # Ratio of the length of a cell along the sides to the width of the body there.
    side_aspect = 8.0
    while (height := root - bore - sum(ends[0]) - sum(ends[1])) > 0.0:
        inner = sum(ends[1]), sum(ends[1]) + height
        sizes = [
            min(cell * side_growth ** len(end), longest, side_aspect * pitch * (bore + above))
            for cell, end, above in zip(cells, ends, inner[::-1], strict=True)
        ]
        shorter = int(sizes[1] < sizes[0])
        ends[shorter].append(sizes[shorter])
    lengths = np.array(ends[0] + ends[1][:0:-1])
    return np.asarray(np.cumsum(lengths) / lengths.sum())


def _inner_walls(
    bottom: SheetGrid, bore: float, pitch: float, across: int, side_tolerance: float
) -> dict[str, tuple[FloatArray, FloatArray]]:
    """Return points and normals (k, nz, 3) of the bore, in `across` cells, and of the sides below the first
    row of the left `bottom` land. The sides are helicoids of radial lines, which the triangles approximate
    within the `side_tolerance` (mm)."""
    outer, z = bottom.points[0] @ (1.0, 1.0j, 0.0), bottom.z
    root, direction = np.abs(outer), outer / np.abs(outer)
    step = np.linalg.norm(bottom.points[1] - bottom.points[0], axis=-1).min()
    # Two triangles over a cell of the length h, twisted by the angle t, are off by h t / 4 in its middle.
    twist = float(np.abs(np.angle(direction[1:] / direction[:-1])).max())
    longest = min(MAX_ASPECT_RATIO * float(np.diff(z).min()), 4.0 * side_tolerance / max(twist, 1e-9))
    cells = float(step), pitch * bore / across
    depths = _depths((float(root.max()), bore), cells, longest, pitch)
    side = direction * (root - depths[:, None] * (root - bore))
    inner = bore * direction * np.exp(1.0j * pitch * np.linspace(0.0, 1.0, across + 1)[:, None])
    walls = {}
    for name, plane in (("bore", inner), (SIDES[0], side), (SIDES[1], side * np.exp(1.0j * pitch))):
        points = np.stack((plane.real, plane.imag, np.broadcast_to(z, plane.shape)), axis=-1)
        normals = -points * (1.0, 1.0, 0.0)
        if name in SIDES:
            along = np.gradient(points, z, axis=1, edge_order=2 if len(z) > 2 else 1)
            normals = np.cross(np.gradient(points, axis=0), along)
            normals *= -1.0 if name == SIDES[0] else 1.0
        walls[name] = points, normals / np.linalg.norm(normals, axis=-1, keepdims=True)
    return walls


def _rings(sizes: dict[str, int]) -> dict[str, Indices]:
    """Return the point numbers of the curves around the section of a tooth, given the size of each curve.

    The points are numbered counter-clockwise: outline, last side, bore, first side. The numbers of a curve
    are in the order of its points: from the outline to the bore on the sides, counter-clockwise on the bore.
    """
    order = (*OUTLINE, SIDES[1], "bore", SIDES[0])
    count = sum(sizes[name] - 1 for name in order)
    rings, start = {}, 0
    for name in order:
        ring = (start + np.arange(sizes[name])) % count
        rings[name] = ring[::-1] if name in ("bore", SIDES[0]) else ring
        start += sizes[name] - 1
    return rings


def _piece(curve: str, numbers: Indices, points: FloatArray, normals: FloatArray) -> Piece:
    """Return the surface that a boundary curve of the section generates along the face, from the numbers
    (k, nz), points and normals (k, nz, 3) of a grid. Raises ValueError if triangles are inverted."""
    faces = grid_faces(points, normals)
    flat, outward = points.reshape(-1, 3), normals.reshape(-1, 3)
    a, b, c = flat[faces.T]
    if not np.all(np.einsum("ni,ni->n", np.cross(b - a, c - a), outward[faces[:, 0]]) > 0.0):
        raise ValueError(
            f"the surface of the {curve} folds back: use a smaller dedendum or a larger tip_radius"
        )
    return Piece(surface_name(curve), numbers.ravel(), flat, outward, faces)


def _end_face(name: str, points: FloatArray, ring: Indices, start: int) -> tuple[FloatArray, Piece]:
    """Return the points (k, 3) added inside the toe or heel, and the end face as a piece.

    `ring`: numbers of the points around it, counter-clockwise seen from +z; added points are numbered from
    `start`."""
    # Smallest angle aimed at in the triangles of the end faces.
    end_face_angle = math.radians(3.0)
    z = float(points[ring[0], 2])
    try:
        flat, faces = triangulate_polygon(points[ring, :2], end_face_angle)
    except ValueError:
        cure = "undercut cuts through the tooth, increase the profile shift or the number of teeth"
        raise ValueError(f"the outline of the tooth intersects itself at z = {z:.4g} mm: {cure}") from None
    at = np.column_stack((flat, np.full(len(flat), z)))
    inside = at[len(ring) :]
    numbers = np.concatenate((ring, start + np.arange(len(inside))))
    outwards = -1 if name == "toe" else 1
    normals = np.broadcast_to((0.0, 0.0, outwards), at.shape)
    return inside, Piece(name, numbers, at, normals, faces[:, ::outwards])


def surface_name(curve: str) -> str:
    """Return the name of the surface that a curve of the section generates; the bottom land has two
    curves."""
    return "bottom" if curve.endswith("bottom") else curve
