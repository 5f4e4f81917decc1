"""Pair in mesh, and its members as surfaces for pictures."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from beveloid_geom import Design, Errors, Member
from beveloid_geom.arrays import FloatArray
from beveloid_geom.contact.mesh_position import Frame, meshing_pair
from beveloid_geom.gear.flank import turned
from beveloid_geom.gear.flank_limits import tip_radius
from beveloid_geom.pair.frames import layout_of, member_frame, normals_to_fixed, to_fixed
from beveloid_geom.pair.mounting import mounting_of
from beveloid_geom.shapes.surface_mesh import TriangleMesh, gear_mesh

from ..rendering.scene import Camera, Size, Surface, fit_camera, grid_surface

VIEW, UP = np.array([-0.5, 0.52, 0.7]), np.array([0.0, -1.0, 0.0])
"""Viewing direction for a complete pair, and upward direction, in the fixed frame S_f: z along the pinion
axis, x along the common perpendicular towards the gear axis."""


@dataclass(frozen=True, eq=False)
class PosedPair:
    """Pair at given rotation angles of pinion and gear (a pose).

    Attributes
    ----------
    design : Design
        The pair.
    frames : tuple
        Rotation and origin of pinion and gear in S_f.
    roll : ndarray, shape (2,)
        Rolls, rad.
    position : ndarray, shape (2,)
        Positions of the mid-faces along their axes, mm, from the common perpendicular.
    contact : ndarray, shape (3,)
        Point of contact in S_f, mm; NaN if the flanks do not touch.
    """

    design: Design
    roll: FloatArray
    position: FloatArray
    contact: FloatArray
    frames: tuple[Frame, Frame]

    @property
    def touching(self) -> bool:
        """True if the flanks touch."""
        return bool(np.isfinite(self.contact).all())

    @property
    def axis(self) -> FloatArray:
        """Unit vectors (2, 3) of the axes in S_f, towards +z."""
        return np.stack([rotation[:, 2] for rotation, _ in self.frames])

    @property
    def foot(self) -> FloatArray:
        """Points (2, 3) of the axes on the common perpendicular, mm."""
        return np.stack([origin for _, origin in self.frames]) - self.position[:, None] * self.axis

    @property
    def apart(self) -> float:
        """Reference length of symbols at the axes, mm: the offset, or about the distance of the members if
        the axes nearly intersect."""
        middle = self.foot + self.position[:, None] * self.axis
        return max(float(self.foot[1, 0]), 0.9 * float(np.linalg.norm(middle[1] - middle[0])))

    @property
    def parallel(self) -> bool:
        """True if the axes are parallel, so that the common perpendicular is not unique."""
        return bool(layout_of(self.design).parallel)

    @property
    def crossed(self) -> bool:
        """True if the axes neither intersect nor are parallel."""
        return bool(layout_of(self.design).offset) and not self.parallel

    @property
    def remote(self) -> bool:
        """True if the common perpendicular is too far from the members to be drawn with them: a mounting
        distance exceeds four times the distance of the members."""
        return float(np.abs(self.position).max()) > 4.0 * self.apart

    @property
    def nearer(self) -> float:
        """Distance, mm, by which a remote common perpendicular is drawn closer along the pinion axis,
        otherwise 0. The pinion axis stays straight; the gear axis bends at its break."""
        drawn = self.half_widths.max() + 2.5 * self.apart
        away = float(self.position[0])
        return float(np.copysign(max(abs(away) - drawn, 0.0), away)) if self.remote else 0.0

    @property
    def breaks(self) -> FloatArray:
        """Distances (2,) of the break symbols from mid-face along the axes, mm."""
        return np.copysign(self.half_widths + 0.55 * self.apart, -self.position)

    @property
    def half_widths(self) -> FloatArray:
        """Half face widths (2,), mm."""
        return 0.5 * np.array([float(member.face_width) for member in self.design.members])


def pose(design: Design, flank: str = "right") -> PosedPair:
    """Return the pair with its flanks in contact at the middle of the path of contact.

    If there is no path, the rolls are those of the unmodified pair without errors, or zero.
    """
    try:
        pair = meshing_pair(design, flank)
    except ValueError:
        return placed(design, _nominal_rolls(design, flank))
    return PosedPair(design, pair.roll, pair.position, pair.contact, pair.frames)


def _nominal_rolls(design: Design, flank: str) -> FloatArray:
    try:
        return meshing_pair(replace(design.unmodified(), errors=Errors()), flank).roll
    except ValueError:
        return np.zeros(2)


def placed(design: Design, roll: FloatArray) -> PosedPair:
    """Return the pair as mounted, with its errors, at rolls (2,), rad."""
    axial = np.array([design.errors.pinion_axial, design.errors.gear_axial], dtype=float)
    layout, position = layout_of(design), np.nan_to_num(mounting_of(design).distance) + axial
    first, second = (member_frame(layout, member, roll[member], position[member]) for member in (0, 1))
    return PosedPair(design, roll, position, np.full(3, np.nan), (first, second))


def rings(member: Member) -> FloatArray:
    """Return points (2, n, 3) of the tip circles at both ends of the face, in the frame of the member,
    mm."""
    half = 0.5 * float(member.face_width)
    return np.stack([circle(float(tip_radius(member, z)), z, 49) for z in (-half, half)])


def circle(radius: float, z: float, count: int = 97) -> FloatArray:
    """Return points (count, 3) of a closed circle about z."""
    turn = np.linspace(0.0, 2.0 * np.pi, count)
    return np.stack((radius * np.cos(turn), radius * np.sin(turn), np.full_like(turn, z)), axis=-1)


def shaft_radius(member: Member) -> float:
    """Return the radius of the shaft of a member, mm."""
    # Radius of a shaft as a fraction of the smallest tip radius.
    shaft_share = 0.22
    half = 0.5 * float(member.face_width)
    return shaft_share * float(np.min(tip_radius(member, np.array([-half, half]))))


def far_words(pair: PosedPair) -> str:
    """Return a sentence with the true position of the common perpendicular if it is drawn elsewhere."""
    if not pair.nearer:
        return ""
    true, drawn = np.abs(pair.position[0] - np.array([0.0, pair.nearer]))
    return (
        f" Not to scale beyond the breaks: common perpendicular at {true:.0f} mm, drawn at {drawn:.0f} mm;"
        " $\\delta$ enlarged."
    )


def reach(*pairs: PosedPair, feet: bool = True) -> FloatArray:
    """Return points (n, 3) in S_f, mm, that a picture of complete pairs must show: tip circles and, with
    `feet`, the common perpendicular."""
    points = [pair.foot for pair in pairs if feet]
    for pair in pairs:
        members = zip(pair.frames, pair.design.members, strict=True)
        points += [to_fixed(frame, rings(member)).reshape(-1, 3) for frame, member in members]
    return np.concatenate(points)


def mesh_camera(
    design: Design,
    frame: Frame,
    points: FloatArray,
    normal: FloatArray,
    size: Size,
    least_modules: float = 3.0,
) -> Camera:
    """Return the camera for teeth in mesh, which looks along the teeth, with the gear on top.

    Pinion flanks face to the left, to the light: right flanks are seen from +z, left flanks from -z.

    Parameters
    ----------
    design : Design
        The pair.
    frame : tuple
        Rotation and origin of the pinion in S_f.
    points : ndarray, shape (n, 3)
        Points in S_f that must be visible, mm.
    normal : ndarray, shape (3,)
        Common normal in S_f, out of the pinion tooth.
    size : tuple of int
        Width and height of the picture, pixels.
    least_modules : float
        Smallest half height of the picture, in normal modules.

    Returns
    -------
    Camera
    """
    axis, arm = frame[0][:, 2], points.mean(axis=0) - frame[1]
    gearwards = arm - (arm @ axis) * axis
    gearwards /= np.linalg.norm(gearwards)
    along = np.cross(gearwards, normal)
    # Turned from the direction of the teeth towards the pinion flanks, so that these can be seen.
    towards = along / np.linalg.norm(along) + 0.3 * normal + 0.15 * gearwards
    camera = fit_camera(points, -towards, gearwards, size, margin=0.06)
    least_mm = least_modules * float(design.pinion.tool.normal_module)
    return replace(camera, half_height=max(camera.half_height, least_mm))


def teeth_in_mesh(mesh: TriangleMesh, camera: Camera, axis: FloatArray) -> TriangleMesh:
    """Return the faces of a mesh that a camera of `mesh_camera` shows.

    Left out are the bore, the end face that is further away, and the cuts of a sector. `axis` (3,): axis of
    the member in S_f."""
    far = "toe" if camera.direction @ axis < 0.0 else "heel"
    return mesh.where(~mesh.is_of("bore", "first side", "last side", far))


def placed_surface(
    mesh: TriangleMesh, frame: Frame, colour: str, opacity: float = 1.0, edges: bool = False
) -> Surface:
    """Return a mesh as a surface in S_f."""
    points, normals = to_fixed(frame, mesh.points), normals_to_fixed(frame, mesh.normals)
    return Surface(points, mesh.faces, normals, colour, opacity, edges)


def gear_items(
    member: Member,
    frame: Frame,
    tolerance: float,
    colours: tuple[str, str],
    bore_radius: float,
    teeth: Sequence[int] | None = None,
) -> tuple[list[Surface], str]:
    """Return the surfaces of a gear, or of some of its teeth.

    Parameters
    ----------
    member : Member
        Gear.
    frame : tuple
        Rotation and origin in S_f.
    tolerance : float
        Largest deviation of the triangles, mm.
    colours : tuple of str
        Colours of teeth and end faces.
    bore_radius : float
        Radius of the bore, mm.
    teeth : sequence of int, optional
        Numbers of the teeth; all if omitted.

    Returns
    -------
    surfaces : list of Surface
        Teeth and end faces. If the teeth have no surface, the blank without teeth.
    reason : str
        Reason why the teeth have no surface, or ''.
    """
    try:
        mesh = gear_mesh(member, tolerance, teeth, bore_radius)
    except ValueError as error:
        return blank(member, frame, colours[0], bore_radius), str(error)
    ends = mesh.is_of("toe", "heel")
    parts = ((mesh.where(~ends), colours[0]), (mesh.where(ends), colours[1]))
    return [placed_surface(part, frame, colour, edges=True) for part, colour in parts], ""


def lathe(profile: FloatArray, frame: Frame, colour: str, opacity: float = 1.0) -> list[Surface]:
    """Return surfaces of revolution about the z axis of a member, one for each segment of the profile (n, 2)
    of radius and z, mm. The material is to the left of the profile."""
    points_around = 121
    turn = np.linspace(0.0, 2.0 * np.pi, points_around)
    pieces = []
    for (r0, z0), (r1, z1) in pairwise(profile):
        points = np.stack((circle(r0, z0, points_around), circle(r1, z1, points_around)))
        size = np.hypot(r1 - r0, z1 - z0)
        radial, axial = (z1 - z0) / size, (r0 - r1) / size
        normals = np.stack(
            (radial * np.cos(turn), radial * np.sin(turn), np.full(points_around, axial)), axis=-1
        )
        placed = to_fixed(frame, points), normals_to_fixed(frame, np.stack((normals, normals)))
        pieces.append(grid_surface(*placed, colour, opacity))
    return pieces


def blank(
    member: Member, frame: Frame, colour: str, bore_radius: float, opacity: float = 1.0
) -> list[Surface]:
    """Return a member before its teeth are cut."""
    half = 0.5 * float(member.face_width)
    toe, heel = (float(tip_radius(member, z)) for z in (-half, half))
    profile = np.array([[bore_radius, -half], [toe, -half], [heel, half], [bore_radius, half]])
    return lathe(profile, frame, colour, opacity)


def shaft(frame: Frame, radius: float, low: float, high: float) -> list[Surface]:
    """Return a cylindrical shaft along the axis of a member from `low` to `high`, mm."""
    return lathe(np.array([[1e-6, low], [radius, low], [radius, high], [1e-6, high]]), frame, "#9aa1a8")


def on_tooth(points: FloatArray, member: Member, tooth: int) -> FloatArray:
    """Return points (..., 3) of tooth 0 of a member turned to another tooth, mm."""
    return turned(2.0 * np.pi * tooth / float(member.teeth), *np.moveaxis(points, -1, 0))


def turn_about_axis(angle: float) -> FloatArray:
    """Return the rotation (3, 3) about the z axis by an angle, rad."""
    cos, sin = np.cos(angle), np.sin(angle)
    return np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
