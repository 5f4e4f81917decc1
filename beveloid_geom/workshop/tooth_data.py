"""Dimensions of a member for its drawing, in the planes of toe, middle and heel.

The thickness of the tooth is defined on a cylinder of the radius r. In the plane z, the flanks are at the
angles theta_R and theta_L, so that s_t = r (theta_R - theta_L). The middle of the tooth has the helix angle

    tan(beta_y) = r tan(beta) cos(gamma) / r_P,

the mean of both flanks. The normal thickness s_n is the length, from flank to flank, of the line on the
cylinder that is perpendicular to the middle. Its ends are outside the plane z, and there the tooth of a
beveloid is thicker on one side and thinner on the other. An end is at the distance t = r cos(beta_y)
|theta_R - theta| from the middle theta, with both angles in the plane z -+ t sin(beta_y) of the end. The
chord between the ends and its height below the tip are then those of a cylindrical gear,

    s_c = sqrt((s_n sin(beta_y))^2 + (2 r sin(psi))^2),  h_c = r_a - r cos(psi),  psi = s_n cos(beta_y) / 2 r,

Eqs. (2) and (5) of DIN 21773. s_n is given on the reference cylinder, on which the rack rolls. Between
straight flanks it grows linearly along the face: on a spur beveloid by 2 tan(alpha_t) tan(gamma) per mm, with
tan(alpha_t) = tan(alpha_n) cos(gamma). The chord is given where a caliper measures: on the shifted reference
cone, with the height of the tip above it.

A tooth that is thicker by A in the normal section of the tool has the same flanks, each rotated by
A / (2 r_P cos(beta)). The normal backlash changes by -A cos(alpha_n).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FLANK_SIGN, FloatArray
from ..design.arguments import require_member
from ..design.field_limits import float64_of
from ..design.member import Member
from ..design.model import Design
from ..gear.fillet import root_radius
from ..gear.flank import base_cylinder, flank_point
from ..gear.flank_limits import tip_radius
from ..gear.rack import reference_radius
from ..gear.tooth_side import ToothSurface, angle_of, cut_at, profile_at, surface_of
from ..gear.undercut import undercut_of
from ..support.array_repr import short_repr

PLACES = ("toe", "middle", "heel")
"""Planes in which dimensions are given."""


@dataclass(frozen=True, eq=False)
class ToothData:
    """Dimensions of a single member. Lengths in mm, angles in rad.

    Attributes
    ----------
    z : array (3,)
        Planes of toe, middle and heel.
    change : array (k,)
        Changes of the normal thickness.
    reference_diameter : float
    tip_diameter, root_diameter : array (3,)
    form_diameter : array (2, 3)
        Start of right and left flank above fillet or undercut; NaN where undercut removes the flank.
    base_diameter : array (2,)
        Of right and left flank.
    normal_thickness : array (k, 3)
        On the reference cylinder.
    chord_diameter : array (3,)
        Diameters at which the chord is measured.
    chordal_thickness, chordal_height : array (k, 3)
    root_cone_angle : float
    infeed : float
        Increase of the distance of the hob from the axis, mm per mm of feed towards +z; tan(gamma). It is
        positive where the hob is withdrawn, and negative where it approaches the axis.
    swivel : float
        Angle by which the head of the hob is turned about the radial line, for a hob with the lead angle 0.
    """

    __repr__ = short_repr

    z: FloatArray
    change: FloatArray
    reference_diameter: float
    tip_diameter: FloatArray
    root_diameter: FloatArray
    form_diameter: FloatArray
    base_diameter: FloatArray
    normal_thickness: FloatArray
    chord_diameter: FloatArray
    chordal_thickness: FloatArray
    chordal_height: FloatArray
    root_cone_angle: float
    infeed: float
    swivel: float


def tooth_data(member: Member, change: ArrayLike = 0.0) -> ToothData:
    """Compute the dimensions of a single member for its drawing.

    Parameters
    ----------
    member : Member
    change : float or array (k,)
        Change of the normal thickness from that of the design, mm; negative for a thinner tooth.

    Returns
    -------
    ToothData

    Raises
    ------
    ValueError
        For a member with arrays, a member that its tool cannot cut, and tip rounds of the tool that overlap.

    References
    ----------
    Cylindrical gears: Eqs. (2) and (5) of DIN 21773.

    Examples
    --------
    >>> import beveloid_geom as bg
    >>> data = bg.tooth_data(bg.builtin_design("ni-2017").pinion)
    >>> print(f"{data.reference_diameter:.3f} mm")
    191.988 mm
    >>> data.tip_diameter.round(3)
    array([203.407, 206.028, 208.648])
    """
    require_member(member)
    change = np.atleast_1d(float64_of("change", change))
    surfaces = [surface_of(member, flank) for flank in FLANK_SIGN]
    starts = [undercut_of(member, flank, len(PLACES)) for flank in FLANK_SIGN]
    z, reference = starts[0].z, float(reference_radius(member))
    form = [_radius_at(member, flank, one.start, z) for flank, one in zip(FLANK_SIGN, starts, strict=True)]
    module, tip = float(member.tool.normal_module), tip_radius(member, z)
    chord = tip - float(member.tip_height) * module
    with np.errstate(invalid="ignore"):
        thickness, _ = _across(
            member, surfaces, _on_reference_cylinder, np.full(z.shape, reference), z, change
        )
        normal, helix = _across(member, surfaces, _on_cylinders(chord), chord, z, change)
    half = 0.5 * normal * np.cos(helix) / chord
    return ToothData(
        z=z,
        change=change,
        reference_diameter=2.0 * reference,
        tip_diameter=2.0 * tip,
        root_diameter=2.0 * root_radius(member, z),
        form_diameter=2.0 * np.array(form),
        base_diameter=2.0 * np.array([float(base_cylinder(member, flank).radius) for flank in FLANK_SIGN]),
        normal_thickness=thickness,
        chord_diameter=2.0 * chord,
        chordal_thickness=np.hypot(normal * np.sin(helix), 2.0 * chord * np.sin(half)),  # DIN 21773 (2)
        chordal_height=tip - chord * np.cos(half),  # DIN 21773 (5)
        root_cone_angle=float(member.cone_angle),
        infeed=float(np.tan(member.cone_angle)),
        swivel=float(np.arctan(np.tan(member.helix_angle) / np.cos(member.cone_angle))),
    )


def _radius_at(member: Member, flank: str, l: FloatArray, z: FloatArray) -> FloatArray:
    """Return the radii of flank points, mm."""
    x, y, _ = np.moveaxis(flank_point(member, flank, l, z=z), -1, 0)
    return np.asarray(np.hypot(x, y))


def middle_angle(member: Member) -> float:
    """Return the angle (rad) from x to the middle of tooth 0 of a single member, on the reference cylinder at
    mid-face. It is 0 without a cone or without a helix."""
    sides = [_on_reference_cylinder(surface_of(member, flank), np.zeros(1)) for flank in FLANK_SIGN]
    return float(0.5 * (sides[0] + sides[1])[0])


def turn_of(member: Member, change: ArrayLike) -> FloatArray:
    """Return the angle (rad) by which each flank of a single member is rotated outwards if the normal
    thickness changes by `change`, mm."""
    tool = member.tool
    return np.asarray(change, dtype=float) / (float(tool.normal_module) * float(member.teeth))


def backlash_change(design: Design, pinion: ArrayLike, gear: ArrayLike) -> FloatArray:
    """Return the change of the normal backlash of a pair with the normal thickness of its members.

    The change is exact for flanks without parabolas. With parabolas, right and left flanks touch at rolls
    that are slightly further apart, and the smallest backlash over a mesh cycle differs by the corresponding
    part of the transmission error.

    Parameters
    ----------
    design : Design
    pinion, gear : float or array
        Changes of the normal thickness, mm.

    Returns
    -------
    array
        mm.
    """
    cosine = np.cos(design.pinion.tool.normal_pressure_angle)
    return np.asarray(-cosine * (np.asarray(pinion, dtype=float) + np.asarray(gear, dtype=float)))


def _across(
    member: Member,
    surfaces: list[ToothSurface],
    theta: Callable[[ToothSurface, FloatArray], FloatArray],
    radius: FloatArray,
    z: FloatArray,
    change: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Return the normal thickness (k, n), mm, on cylinders of `radius` (n,) in the planes `z` (n,), and the
    helix angle (n,) of the middle of the tooth there. `theta` returns the angle (rad) of a flank in given
    planes."""
    slope = np.tan(member.helix_angle) * np.cos(member.cone_angle) / reference_radius(member)
    helix, total = np.arctan(radius * slope), np.zeros((change.size, z.size))
    middle = 0.5 * sum(theta(surface, z) for surface in surfaces)
    # Largest number of iterations for the end of a normal line. Each reduces the error by the factor
    # sin(beta_y) tan(taper).
    max_iterations = 40
    for surface in surfaces:
        for row, turn in enumerate(turn_of(member, change)):
            # Iterate the distance of the end of the normal line from the middle, in the plane of the end.
            length = np.zeros(z.size)
            for _ in range(max_iterations):
                off = -surface.sigma * length * np.sin(helix)
                half = turn + surface.sigma * (theta(surface, z + off) - middle - off * slope)
                step, length = radius * np.cos(helix) * half - length, radius * np.cos(helix) * half
                if not np.any(np.abs(step) > 1e-15 * radius):
                    break
            total[row] += length
    return total, helix


def _on_reference_cylinder(surface: ToothSurface, z: FloatArray) -> FloatArray:
    """Return the angles (n,), rad, of a flank, extended as the rack is, on the cylinder on which the rack
    rolls."""
    a, ((bx, by), (cx, cy)) = surface.parabola, (surface.along, surface.out)
    start = surface.apex[0] + z * surface.trace[0]
    # x_c = 0 on this cylinder, so that phi = y_c / r_P.
    l = -2.0 * start / (bx + np.sqrt(bx * bx - 4.0 * a * cx * start))
    return np.asarray(
        (surface.apex[1] + z * surface.trace[1] + l * by + a * l * l * cy) / surface.pitch_radius
    )


def _on_cylinders(radius: FloatArray) -> Callable[[ToothSurface, FloatArray], FloatArray]:
    """Return a function that computes the angles (n,) of a flank on cylinders of `radius` (n,)."""

    def theta(surface: ToothSurface, z: FloatArray) -> FloatArray:
        """Return the angles (rad) in the planes `z` (n,)."""
        s = profile_at(surface, radius * radius, z)
        return angle_of(cut_at(surface, s, z))

    return theta
