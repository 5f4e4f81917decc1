"""Dimensions of a member for its drawing, in the planes of toe, middle and heel.

The tooth's thickness is taken on a cylinder of the radius r. In the plane z its flanks stand at the angles
theta_R and theta_L there, so that s_t = r (theta_R - theta_L); the tooth's middle runs at the helix angle

    tan(beta_y) = r tan(beta) cos(gamma) / r_P,

the mean of both flanks. The normal thickness s_n is the length of the line on the cylinder that is square to
the middle, from flank to flank. Its ends lie beside the plane z, where a beveloid's tooth is thicker on one
side and thinner on the other: an end is t = r cos(beta_y) |theta_R - theta| away from the middle theta, both
angles those in its own plane, z -+ t sin(beta_y). Chord between the ends and its height below the tip are
then those of a cylindrical gear,

    s_c = sqrt((s_n sin(beta_y))^2 + (2 r sin(psi))^2),  h_c = r_a - r cos(psi),  psi = s_n cos(beta_y) / 2 r,

DIN 21773 Eqs. (2), (5), the standard of measures beside ISO 21771. s_n is given on the reference cylinder, on
which the rack's own width rolls off: between straight flanks it grows evenly along the face, on a spur
beveloid by 2 tan(alpha_t) tan(gamma) a mm, tan(alpha_t) = tan(alpha_n) cos(gamma). The chord is that where a
caliper reaches: on the shifted reference cone, a tool's addendum below the tip.

A tooth that is thicker or thinner by A in the tool's normal section has the same flanks, each turned by
A / (2 r_P cos(beta)); normal backlash changes by -A cos(alpha).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ..arrays import FLANK_SIGN, FloatArray
from ..design.model import Design, Member
from ..gear.fillet import root_radius
from ..gear.flank import base_cylinder, flank_point, tip_radius, trace_parameter
from ..gear.rack import reference_radius
from ..gear.tooth_side import Surface, angle_of, cut_at, profile_at, surface_of
from ..gear.undercut import undercut_of
from ..support.few_lines import few_lines

PLACES = ("toe", "middle", "heel")
"""Planes at which a member is described."""
PASSES = 40
"""Passes to the end of a normal line: each leaves a share sin(beta_y) tan(taper) of the error."""


@dataclass(frozen=True, eq=False)
class ToothData:
    """Dimensions of a single member, mm and rad, in its planes `z` (3,) of toe, middle and heel.

    `tip_diameter`, `root_diameter` (3,); `form_diameter` (2, 3), where right and left flanks begin above
    fillet or undercut, NaN where nothing is left of one; `base_diameter` (2,). Of teeth whose normal
    thickness is changed by `change` (k,): `normal_thickness` (k, 3) on the cylinder `reference_diameter`,
    `chordal_thickness` and `chordal_height` (k, 3) on the cylinders `chord_diameter` (3,).
    `root_cone_angle`; `infeed`, mm of radial for a mm of axial feed towards the heel; `swivel`, the angle by
    which the hob's head is turned about the radial line, for a hob without lead."""

    __repr__ = few_lines

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
    """Find the dimensions of a single member for its drawing.

    Parameters
    ----------
    member : Member
    change : float or array (k,)
        By how much the normal thickness differs from that of the design, mm; a thinner tooth's is negative.

    Returns
    -------
    ToothData

    Raises
    ------
    ValueError
        For a member of arrays, one that its tool cannot cut, and a tool whose rounds overlap.
    """
    change = np.atleast_1d(np.asarray(change, dtype=float))
    surfaces = [surface_of(member, flank) for flank in FLANK_SIGN]
    starts = [undercut_of(member, flank, len(PLACES)) for flank in FLANK_SIGN]
    z, reference = starts[0].z, float(reference_radius(member))
    form = [_radius_at(member, flank, one.start, z) for flank, one in zip(FLANK_SIGN, starts, strict=True)]
    module, tip = float(member.tool.normal_module), tip_radius(member, z)
    chord = tip - float(member.tool.addendum) * module
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
    """Give the radii of flank points, mm."""
    x, y, _ = np.moveaxis(flank_point(member, flank, l, trace_parameter(member, flank, l, z)), -1, 0)
    return np.asarray(np.hypot(x, y))


def middle_angle(member: Member) -> float:
    """Find the angle (rad) from x to the middle of a single member's tooth 0, on the reference cylinder at
    mid-face: 0 without a cone or without a helix."""
    sides = [_on_reference_cylinder(surface_of(member, flank), np.zeros(1)) for flank in FLANK_SIGN]
    return float(0.5 * (sides[0] + sides[1])[0])


def turn_of(member: Member, change: ArrayLike) -> FloatArray:
    """Find the angle (rad) by which each flank of a single member turns out of a tooth whose normal thickness
    changes by `change`, mm."""
    tool = member.tool
    return np.asarray(change, dtype=float) / (float(tool.normal_module) * float(member.teeth))


def backlash_change(design: Design, pinion: ArrayLike, gear: ArrayLike) -> FloatArray:
    """Find by how much the normal backlash of a pair changes with the normal thickness of its members, mm.

    Exact for flanks without parabolas; with them right and left flanks then touch at rolls that are a little
    further apart, and the least over a mesh cycle differs by that share of the transmission error."""
    cosine = np.cos(design.pinion.tool.normal_pressure_angle)
    return np.asarray(-cosine * (np.asarray(pinion, dtype=float) + np.asarray(gear, dtype=float)))


def _across(
    member: Member,
    surfaces: list[Surface],
    theta: Callable[[Surface, FloatArray], FloatArray],
    radius: FloatArray,
    z: FloatArray,
    change: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Find the normal thickness (k, n), mm, on cylinders of `radius` (n,) in the planes `z` (n,), and the
    helix angle (n,) of the tooth's middle there. `theta`: angle (rad) of a flank there in planes (n,)."""
    slope = np.tan(member.helix_angle) * np.cos(member.cone_angle) / reference_radius(member)
    helix, total = np.arctan(radius * slope), np.zeros((change.size, z.size))
    middle = 0.5 * sum(theta(surface, z) for surface in surfaces)
    for surface in surfaces:
        for row, turn in enumerate(turn_of(member, change)):
            length = np.zeros(z.size)
            for _ in range(PASSES):
                off = -surface.sigma * length * np.sin(helix)
                half = turn + surface.sigma * (theta(surface, z + off) - middle - off * slope)
                step, length = radius * np.cos(helix) * half - length, radius * np.cos(helix) * half
                if not np.any(np.abs(step) > 1e-15 * radius):
                    break
            total[row] += length
    return total, helix


def _on_reference_cylinder(surface: Surface, z: FloatArray) -> FloatArray:
    """Find the angles (n,) of a flank, extended as the rack is, on the cylinder on which the rack rolls."""
    a, ((bx, by), (cx, cy)) = surface.parabola, (surface.along, surface.out)
    start = surface.apex[0] + z * surface.trace[0]
    l = -2.0 * start / (bx + np.sqrt(bx * bx - 4.0 * a * cx * start))  # its x_c is 0: phi = y_c / r_P
    return np.asarray(
        (surface.apex[1] + z * surface.trace[1] + l * by + a * l * l * cy) / surface.pitch_radius
    )


def _on_cylinders(radius: FloatArray) -> Callable[[Surface, FloatArray], FloatArray]:
    """Make the function that finds the angles (n,) of a flank on cylinders (n,)."""

    def theta(surface: Surface, z: FloatArray) -> FloatArray:
        """Give the angles in the planes `z` (n,)."""
        s = profile_at(surface, radius * radius, z)
        return angle_of(cut_at(surface, s, z))

    return theta
