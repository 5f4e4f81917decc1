"""The whole tooth as the tool leaves it: flanks, fillets, lands, end faces, body.

One tooth is a set of patches, grids of points with the exact normals of their surfaces. They
share the stations along the face, and so their common edges. The tooth with its part of the
body reaches to the middle of the tooth spaces beside it; other teeth are the same, turned.

Undercut is not looked for here: an undercut fillet passes through its flank.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .fillet import bottom_point, fillet_point, tool_round
from .flank import flank_point, tip_parameter, tip_radius, trace_parameter
from .inputs import FloatArray, Member, flank_sign
from .sampling import Faces, Place, Sheet, cells_for, flank_sheet, form_of, grid_faces, grid_of, stations

FLANKS = ("right", "left")
SIDES = ("first side", "last side")
"""Where a part of a gear is cut off, before its first and after its last tooth."""
BORE_SHARE = 0.45
"""Radius of the bore if none is given, as a share of the least root radius."""


@dataclass(frozen=True, eq=False)
class Patch:
    """One surface of a tooth: grids of points (mm) and unit normals out of the metal (ns, nz, 3)."""

    name: str
    points: FloatArray
    normals: FloatArray


@dataclass(frozen=True, eq=False)
class Mesh:
    """Triangles of a gear: `points` (mm) and unit `normals` (n, 3), `faces` (m, 3) winding
    outwards, `part` (m,): which of `names` each face belongs to. Patches do not share
    points, so that edges stay sharp."""

    points: FloatArray
    normals: FloatArray
    faces: Faces
    part: NDArray[np.int64]
    names: tuple[str, ...]

    def of(self, *names: str) -> Mesh:
        """Only the faces of the named parts."""
        return self.where(self.is_of(*names))

    def is_of(self, *names: str) -> NDArray[np.bool_]:
        """Which faces (m,) belong to the named parts."""
        return np.isin(self.part, [self.names.index(name) for name in names])

    def where(self, wanted: NDArray[np.bool_]) -> Mesh:
        """Only the faces `wanted` (m,), with the points they use."""
        used, faces = np.unique(self.faces[wanted], return_inverse=True)
        return Mesh(
            self.points[used], self.normals[used], faces.reshape(-1, 3), self.part[wanted], self.names
        )


def _straight_sheet(member: Member, place: Place, ends: tuple[float, float]) -> Sheet:
    return Sheet(
        place, lambda z: ends[0] + 0.0 * z, lambda z: ends[1] + 0.0 * z, 0.5 * float(member.face_width)
    )


def fillet_sheet(member: Member, flank: str) -> Sheet:
    """The fillet below one flank, over the angle of the section normal: bottom land first."""
    ends = (0.5 * np.pi, tool_round(member.tool, flank).angle)
    return _straight_sheet(member, lambda p, z: fillet_point(member, flank, p, z), ends)


def bottom_sheet(member: Member, flank: str) -> Sheet:
    """The bottom land from the fillet of one flank to the middle of the tooth space beside it."""
    middle = flank_sign(flank) * 0.5 * np.pi * float(member.tool.normal_module)
    ends = (middle, tool_round(member.tool, flank).centre[1])
    return _straight_sheet(member, lambda p, z: bottom_point(member, flank, p, z), ends)


def tip_angle(member: Member, flank: str, z: ArrayLike) -> FloatArray:
    """Angle (rad) about the gear axis of the flank's tip edge in the plane `z`."""
    l = tip_parameter(member, flank, z)
    point = flank_point(member, flank, l, trace_parameter(member, flank, l, z))
    return np.asarray(np.arctan2(point[..., 1], point[..., 0]))


def tip_sheet(member: Member) -> Sheet:
    """The tip land, over the angle about the axis, from the left to the right flank.

    Raises ValueError for a pointed tooth."""
    half, gamma = 0.5 * float(member.face_width), float(member.cone_angle)
    z = np.linspace(-half, half, 9)
    width = (tip_angle(member, "right", z) - tip_angle(member, "left", z)) * tip_radius(member, z)
    if not np.all(width > 0.0):
        worst = int(np.argmin(width))
        text = f"the tooth is pointed at z = {z[worst]:.4g} mm, its flanks cross below the tip cone"
        raise ValueError(f"{text}: reduce the addendum, the profile shift or the face width")

    def place(p: FloatArray, z: FloatArray) -> tuple[FloatArray, FloatArray]:
        radius, cos, sin = tip_radius(member, z), np.cos(p), np.sin(p)
        normals = np.stack(
            (np.cos(gamma) * cos, np.cos(gamma) * sin, np.full_like(p, -np.sin(gamma))), axis=-1
        )
        return np.stack((radius * cos, radius * sin, z), axis=-1), normals

    return Sheet(place, lambda z: tip_angle(member, "left", z), lambda z: tip_angle(member, "right", z), half)


def cut_sheets(member: Member) -> dict[str, Sheet]:
    """The surfaces a tool leaves on one tooth, by name."""
    sheets = {"tip land": tip_sheet(member)}
    for flank in FLANKS:
        joint = tool_round(member.tool, flank).joint
        sheets[f"{flank} flank"] = flank_sheet(member, flank, joint)
        sheets[f"{flank} fillet"] = fillet_sheet(member, flank)
        sheets[f"{flank} bottom land"] = bottom_sheet(member, flank)
    return sheets


def tooth_patches(member: Member, tolerance: float, bore_radius: float | None = None) -> tuple[Patch, ...]:
    """One tooth of a single member with its part of the body, own frame; `tolerance` (mm) sets
    the density. Raises ValueError for a pointed tooth or a pointed tool, or a bore that is too large."""
    sheets = cut_sheets(member)
    forms = {name: form_of(sheet, tolerance) for name, sheet in sheets.items()}
    cells = {name: cells_for(form, tolerance) for name, form in forms.items()}
    finest = max(cells, key=lambda name: cells[name][1])
    half = sheets[finest].half_width
    z = stations(forms[finest], 1, cells[finest][1], half)[1]
    cut = {}
    for name, sheet in sheets.items():
        # Both sides of the tooth have as many rows, so that its end faces are grids.
        rows = max(number for other, (number, _) in cells.items() if other.split()[1:] == name.split()[1:])
        grid = grid_of(sheet, stations(forms[name], rows, 1, half)[0], z)
        cut[name] = Patch(name, grid.points, grid.normals)
    root = np.hypot(*cut["right fillet"].points[0, :, :2].T)
    bore = BORE_SHARE * float(root.min()) if bore_radius is None else bore_radius
    if not 0.0 < bore < root.min():
        raise ValueError(
            f"bore_radius must be between 0 and the root radius {root.min():.6g} mm, got {bore:g}"
        )
    return (*cut.values(), *_end_faces(cut, bore), *_inner_faces(cut, bore))


def transverse_section(member: Member, z: float, tolerance: float) -> FloatArray:
    """Outline (n, 2) of a gear in the plane `z` (mm from mid-face), own frame, closed, against the
    clock. Its points are exact, `tolerance` (mm) sets how many. Raises ValueError as
    `tooth_patches` does."""
    at, pieces = np.array([z]), {}
    for name, sheet in cut_sheets(member).items():
        form = form_of(sheet, tolerance)
        s, _ = stations(form, cells_for(form, tolerance)[0], 1, sheet.half_width)
        pieces[name] = grid_of(sheet, s, at).points[:, 0, :2]
    parts = ("bottom land", "fillet", "flank")
    left = [pieces[f"left {part}"] for part in parts]
    right = [pieces[f"right {part}"][::-1] for part in reversed(parts)]
    tooth = np.concatenate([piece[:-1] for piece in (*left, pieces["tip land"], *right)]) @ (1.0, 1.0j)
    turns = np.exp(2.0j * np.pi / float(member.teeth) * np.arange(int(member.teeth)))
    outline = np.multiply.outer(turns, tooth).ravel()
    outline = np.append(outline, outline[0])
    return np.stack((outline.real, outline.imag), axis=-1)


def _polar(points: FloatArray) -> tuple[FloatArray, FloatArray]:
    return np.hypot(points[..., 0], points[..., 1]), np.arctan2(points[..., 1], points[..., 0])


def _between(first: FloatArray, last: FloatArray, count: int) -> FloatArray:
    """Points (count + 1, ...) from `first` to `last` (..., 3), evenly in radius and angle."""
    (r0, a0), (r1, a1) = _polar(first), _polar(last)
    a1 = a0 + np.remainder(a1 - a0 + np.pi, 2.0 * np.pi) - np.pi
    share = np.linspace(0.0, 1.0, count + 1).reshape(-1, *[1] * r0.ndim)
    radius, angle = r0 + share * (r1 - r0), a0 + share * (a1 - a0)
    z = np.broadcast_to(first[..., 2], radius.shape)
    return np.stack((radius * np.cos(angle), radius * np.sin(angle), z), axis=-1)


def _profiles(cut: dict[str, Patch]) -> tuple[FloatArray, FloatArray]:
    """Profiles (rows, nz, 3) of the left and the right side, from bottom land to tip."""
    left, right = (
        np.concatenate((cut[f"{side} fillet"].points, cut[f"{side} flank"].points[1:]))
        for side in ("left", "right")
    )
    return left, right


def _rim(cut: dict[str, Patch]) -> FloatArray:
    """Points (k, nz, 3) at the root radius, from the middle of one tooth space to the next."""
    left, right = cut["left bottom land"].points, cut["right bottom land"].points[::-1]
    columns = cut["tip land"].points.shape[0] - 1
    return np.concatenate((left, _between(left[-1], right[0], columns)[1:-1], right))


def _on_bore(points: FloatArray, radius: float) -> FloatArray:
    scale = radius / np.hypot(points[..., 0], points[..., 1])
    return np.stack((points[..., 0] * scale, points[..., 1] * scale, points[..., 2]), axis=-1)


def _end_faces(cut: dict[str, Patch], bore: float) -> list[Patch]:
    """Toe and heel, each the tooth's end and the body's."""
    (left, right), rim = _profiles(cut), _rim(cut)
    columns = cut["tip land"].points.shape[0] - 1
    patches = []
    for name, end, sign in (("toe", 0, -1.0), ("heel", -1, 1.0)):
        tooth = _between(left[:, end], right[:, end], columns)
        body = np.stack((_on_bore(rim[:, end], bore), rim[:, end]), axis=1)
        for points in (tooth, body):
            patches.append(Patch(name, points, np.broadcast_to((0.0, 0.0, sign), points.shape)))
    return patches


def _inner_faces(cut: dict[str, Patch], bore: float) -> list[Patch]:
    """The bore, and the sides along which this tooth's body joins its neighbours'."""
    rim = _rim(cut)
    inner = _on_bore(rim, bore)
    patches = [Patch("bore", inner, -inner * (1.0, 1.0, 0.0) / bore)]
    for name, edge, sign in zip(SIDES, (0, -1), (-1.0, 1.0), strict=True):
        points = np.stack((inner[edge], rim[edge]))
        along = np.gradient(points, axis=1)
        normals = sign * np.cross(along, points[1] - points[0])
        patches.append(Patch(name, points, normals / np.linalg.norm(normals, axis=-1, keepdims=True)))
    return patches


def gear_mesh(
    member: Member, tolerance: float, teeth: Sequence[int] | None = None, bore_radius: float | None = None
) -> Mesh:
    """The whole gear, or the neighbouring `teeth` numbered (0 is at angle 0), own frame.

    Raises ValueError as `tooth_patches` does."""
    patches = tooth_patches(member, tolerance, bore_radius)
    names = tuple(dict.fromkeys(patch.name for patch in patches))
    points = np.concatenate([patch.points.reshape(-1, 3) for patch in patches])
    normals = np.concatenate([patch.normals.reshape(-1, 3) for patch in patches])
    faces, part, start = [], [], 0
    for patch in patches:
        triangles = grid_faces(patch.points, patch.normals)
        faces.append(triangles + start)
        part.append(np.full(len(triangles), names.index(patch.name)))
        start += patch.points.size // 3
    one = Mesh(points, normals, np.concatenate(faces), np.concatenate(part), names)
    numbers = range(int(member.teeth)) if teeth is None else teeth
    mesh = _turned_copies(one, 2.0 * np.pi / float(member.teeth) * np.asarray(numbers))
    per_tooth = np.repeat(np.arange(len(numbers)), len(one.faces))
    kept = np.ones(len(mesh.faces), dtype=bool)
    for name, end in zip(SIDES, (0, len(numbers) - 1), strict=True):
        kept &= (mesh.part != names.index(name)) | ((per_tooth == end) & (teeth is not None))
    return mesh.where(kept)


def _turned_copies(mesh: Mesh, angles: FloatArray) -> Mesh:
    """The mesh once for every angle about z."""
    cos, sin = np.cos(angles), np.sin(angles)
    turns = np.zeros((angles.size, 3, 3))
    turns[:, 0, 0] = turns[:, 1, 1] = cos
    turns[:, 0, 1], turns[:, 1, 0], turns[:, 2, 2] = -sin, sin, 1.0
    points, normals = (
        np.einsum("kij,nj->kni", turns, vectors).reshape(-1, 3) for vectors in (mesh.points, mesh.normals)
    )
    offsets = len(mesh.points) * np.arange(angles.size)
    faces = (mesh.faces + offsets[:, None, None]).reshape(-1, 3)
    return Mesh(points, normals, faces, np.tile(mesh.part, angles.size), mesh.names)
