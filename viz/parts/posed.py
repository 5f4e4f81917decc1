"""The pair as it stands in mesh, and its members as surfaces to look at."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from beveloid_geom import Design, Errors, Member
from beveloid_geom.arrays import FloatArray
from beveloid_geom.contact.placing import Frame, meshing_pair
from beveloid_geom.gear.flank import tip_radius, turned
from beveloid_geom.pair.frames import layout_of, member_frame, normals_to_fixed, to_fixed
from beveloid_geom.pair.mounting import mounting_of
from beveloid_geom.shapes.surface_mesh import Mesh, gear_mesh

from ..stage.scene import Surface, grid_surface

VIEW, UP = np.array([-0.5, 0.52, 0.7]), np.array([0.0, -1.0, 0.0])
"""Where one looks at a whole pair, in S_f, and what is upwards there."""
SHAFT = "#9aa1a8"
SHAFT_SHARE = 0.22
"""Radius of a shaft as a share of the least tip radius."""
RING, LATHE = 49, 121
"""Points around a tip circle, and around a surface of revolution."""


REMOTE = 4.0
"""Where a mounting distance is more than so many times the distance of the members, the common perpendicular
is left out of a picture, or drawn nearer to the members."""
NEARER, BREAK = 2.5, 0.55
"""How far from a toe the common perpendicular is drawn then, and the breaks of the axes: shares of the
distance of the members."""


@dataclass(frozen=True, eq=False)
class PosedPair:
    """A design with the `frames` of its members, their `roll` (2,) (rad) and `position` (2,) along
    the axes (mm), and the `contact` point (3,) in S_f, NaN where no flanks touch."""

    design: Design
    roll: FloatArray
    position: FloatArray
    contact: FloatArray
    frames: tuple[Frame, Frame]

    @property
    def touching(self) -> bool:
        """Whether the flanks share a point."""
        return bool(np.isfinite(self.contact).all())

    @property
    def axis(self) -> FloatArray:
        """Unit vectors (2, 3) of the axes in S_f, towards the heels."""
        return np.stack([rotation[:, 2] for rotation, _ in self.frames])

    @property
    def foot(self) -> FloatArray:
        """Points (2, 3) of the axes on the common perpendicular, mm."""
        return np.stack([origin for _, origin in self.frames]) - self.position[:, None] * self.axis

    @property
    def apart(self) -> float:
        """Distance (mm) by which what is drawn beside the axes is scaled: the offset, or about that of the
        members where the axes nearly meet."""
        middle = self.foot + self.position[:, None] * self.axis
        return max(float(self.foot[1, 0]), 0.9 * float(np.linalg.norm(middle[1] - middle[0])))

    @property
    def crossed(self) -> bool:
        """Whether the axes neither meet nor are parallel."""
        layout = layout_of(self.design)
        return bool(layout.offset) and not bool(layout.parallel)

    @property
    def remote(self) -> bool:
        """Whether the common perpendicular is too far from the members to be drawn with them."""
        return float(np.abs(self.position).max()) > REMOTE * self.apart

    @property
    def nearer(self) -> float:
        """Length along the pinion's axis (mm) by which a remote common perpendicular is drawn nearer to the
        members than it is, else 0; the pinion's axis stays straight, the gear's bends at its break."""
        drawn = self._toes.max() + NEARER * self.apart
        away = float(self.position[0])
        return float(np.copysign(max(abs(away) - drawn, 0.0), away)) if self.remote else 0.0

    @property
    def breaks(self) -> FloatArray:
        """How far from mid-face along the axes (2,) the marks of broken axes stand, mm."""
        return np.copysign(self._toes + BREAK * self.apart, -self.position)

    @property
    def _toes(self) -> FloatArray:
        """Half face widths (2,), mm."""
        return 0.5 * np.array([float(member.face_width) for member in self.design.members])


def pose(design: Design, flank: str = "right") -> PosedPair:
    """Pose the pair with its flanks touching in the middle of the path of contact. Where they share none, the
    rolls are those of the unmodified pair without errors, or zero."""
    try:
        pair = meshing_pair(design, flank)
    except ValueError:
        return placed(design, _nominal_rolls(design, flank))
    return PosedPair(design, pair.roll, pair.position, pair.contact, pair.frames)


def _nominal_rolls(design: Design, flank: str) -> FloatArray:
    try:
        return meshing_pair(replace(design.with_parabola(0.0, 0.0), errors=Errors()), flank).roll
    except ValueError:
        return np.zeros(2)


def displaced(pair: PosedPair, errors: Errors) -> PosedPair:
    """Pose the pair under other assembly errors at the same rolls; its flanks need not touch."""
    return placed(pair.design.with_errors(errors), pair.roll)


def placed(design: Design, roll: FloatArray) -> PosedPair:
    """Place the pair as mounted, its errors included, at `roll` (2,), rad, wherever its flanks are."""
    axial = np.array([design.errors.pinion_axial, design.errors.gear_axial], dtype=float)
    layout, position = layout_of(design), np.nan_to_num(mounting_of(design).distance) + axial
    first, second = (member_frame(layout, member, roll[member], position[member]) for member in (0, 1))
    return PosedPair(design, roll, position, np.full(3, np.nan), (first, second))


def rings(member: Member) -> FloatArray:
    """Give points (2, RING, 3) of the tip circles at toe and heel, own frame, mm."""
    half = 0.5 * float(member.face_width)
    return np.stack([circle(float(tip_radius(member, z)), z, RING) for z in (-half, half)])


def circle(radius: float, z: float, count: int = 97) -> FloatArray:
    """Give points (count, 3) of a circle about z, closed."""
    turn = np.linspace(0.0, 2.0 * np.pi, count)
    return np.stack((radius * np.cos(turn), radius * np.sin(turn), np.full_like(turn, z)), axis=-1)


def shaft_radius(member: Member) -> float:
    """Give the radius (mm) of the shaft drawn for a member."""
    half = 0.5 * float(member.face_width)
    return SHAFT_SHARE * float(np.min(tip_radius(member, np.array([-half, half]))))


def far_words(pair: PosedPair) -> str:
    """Say where the common perpendicular is, for the end of a note, if it is drawn elsewhere."""
    if not pair.nearer:
        return ""
    true, drawn = np.abs(pair.position[0] - np.array([0.0, pair.nearer]))
    return (
        " Members are to scale, what is beyond the breaks is not: the common perpendicular"
        f" is {true:.0f} mm from the pinion's mid-face and drawn at {drawn:.0f} mm, $\\delta$ is drawn wider."
    )


def reach(*pairs: PosedPair, feet: bool = True) -> FloatArray:
    """Give points (n, 3) in S_f that a picture of whole pairs must show, mm: tip circles and `feet`."""
    found = [pair.foot for pair in pairs if feet]
    for pair in pairs:
        members = zip(pair.frames, pair.design.members, strict=True)
        found += [to_fixed(frame, rings(member)).reshape(-1, 3) for frame, member in members]
    return np.concatenate(found)


def surface(mesh: Mesh, frame: Frame, colour: str, opacity: float = 1.0) -> Surface:
    """Make a mesh of the own frame as a surface in S_f."""
    points, normals = to_fixed(frame, mesh.points), normals_to_fixed(frame, mesh.normals)
    return Surface(points, mesh.faces, normals, colour, opacity)


def gear_items(
    member: Member,
    frame: Frame,
    tolerance: float,
    colours: tuple[str, str],
    bore_radius: float,
    teeth: Sequence[int] | None = None,
) -> tuple[list[Surface], str]:
    """Make a gear, or some of its teeth, to a tolerance (mm) in the colours of teeth and of toe and heel.
    Where its teeth cannot be drawn, the blank before they are cut, and the reason."""
    try:
        mesh = gear_mesh(member, tolerance, teeth, bore_radius)
    except ValueError as error:
        return blank(member, frame, colours[0], bore_radius), str(error)
    ends = mesh.is_of("toe", "heel")
    parts = ((mesh.where(~ends), colours[0]), (mesh.where(ends), colours[1]))
    return [surface(part, frame, colour) for part, colour in parts], ""


def lathe(profile: FloatArray, frame: Frame, colour: str, opacity: float = 1.0) -> list[Surface]:
    """Make surfaces of revolution about the own z axis, one for each piece of a profile (n, 2) of radius and
    z, mm; the metal is on the left of it."""
    turn = np.linspace(0.0, 2.0 * np.pi, LATHE)
    pieces = []
    for (r0, z0), (r1, z1) in pairwise(profile):
        points = np.stack((circle(r0, z0, LATHE), circle(r1, z1, LATHE)))
        size = np.hypot(r1 - r0, z1 - z0)
        radial, axial = (z1 - z0) / size, (r0 - r1) / size
        normals = np.stack((radial * np.cos(turn), radial * np.sin(turn), np.full(LATHE, axial)), axis=-1)
        placed = to_fixed(frame, points), normals_to_fixed(frame, np.stack((normals, normals)))
        pieces.append(grid_surface(*placed, colour, opacity))
    return pieces


def blank(
    member: Member, frame: Frame, colour: str, bore_radius: float, opacity: float = 1.0
) -> list[Surface]:
    """Make a member as it is before its teeth are cut."""
    half = 0.5 * float(member.face_width)
    toe, heel = (float(tip_radius(member, z)) for z in (-half, half))
    profile = np.array([[bore_radius, -half], [toe, -half], [heel, half], [bore_radius, half]])
    return lathe(profile, frame, colour, opacity)


def shaft(frame: Frame, radius: float, low: float, high: float) -> list[Surface]:
    """Make a round shaft along the own axis from `low` to `high`, mm."""
    return lathe(np.array([[1e-6, low], [radius, low], [radius, high], [1e-6, high]]), frame, SHAFT)


def on_tooth(points: FloatArray, member: Member, tooth: int) -> FloatArray:
    """Give points (..., 3) on tooth 0 of a member, on another of its teeth, own frame, mm."""
    return turned(2.0 * np.pi * tooth / float(member.teeth), *np.moveaxis(points, -1, 0))


def turn_about_axis(angle: float) -> FloatArray:
    """Give the rotation (3, 3) about the own axis by an angle, rad."""
    cos, sin = np.cos(angle), np.sin(angle)
    return np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
