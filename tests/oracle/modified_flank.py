"""Modified flanks written from the paper and ISO 21771 alone, for contacts of modified pairs.

Points follow from Eqs. 1-6 with the rack moved along its trace into the plane z. A modification rotates them
about the axis by delta / r_b into the tooth. Tangents are complex steps of the points, so that the normals
need no formula. Nothing of `gear` or `contact` is used. Single members; lengths in mm."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from scipy.optimize import brentq

from beveloid_geom import ContactPath, Design, Member
from beveloid_geom.arrays import FloatArray

STEP = 1e-30


def _height(member: Member, l: Any) -> Any:
    alpha = member.tool.normal_pressure_angle
    return l * np.cos(alpha) + member.tool.parabola * l * l * np.sin(alpha)


def _generated(member: Member, sigma: float, l: Any, z: Any) -> tuple[Any, Any, Any]:
    """Return x, y of Eq. 6 in the plane z before its rotation, and the rotation phi."""
    tool = member.tool
    m, alpha, a = tool.normal_module, tool.normal_pressure_angle, tool.parabola
    sb, cb = np.sin(member.helix_angle), np.cos(member.helix_angle)
    sg, cg = np.sin(member.cone_angle), np.cos(member.cone_angle)

    def rack(x: Any, y: Any, z: Any) -> tuple[Any, Any, Any]:
        y, z = cb * y + sb * z, cb * z - sb * y
        return cg * x + sg * z, y, cg * z - sg * x

    y_n = sigma * (a * l * l * np.cos(alpha) - l * np.sin(alpha) + 0.25 * np.pi * m)
    x, y, height = rack(_height(member, l), y_n, 0.0 * l)
    steep = 2.0 * a * l
    nx, ny, _ = rack(
        np.sin(alpha) - steep * np.cos(alpha), sigma * (np.cos(alpha) + steep * np.sin(alpha)), 0.0
    )
    tx, ty, tz = rack(0.0, 0.0, 1.0)
    u = (z - height) / tz
    x, y = x + member.profile_shift * m + u * tx, y + u * ty
    pitch = m * member.teeth / (2.0 * cb)
    along = ny / nx * x
    return pitch + x, along, (y - along) / pitch


@cache
def limits(member: Member, sigma: float) -> tuple[float, float]:
    """Return l at the start of the active flank and at the tip, at mid-face, for a usual tool."""
    tool = member.tool
    module = float(tool.normal_module)
    joint = tool.dedendum - tool.tip_radius * (1.0 - np.sin(tool.normal_pressure_angle))
    start = tool.addendum if abs(joint - tool.addendum) < 1e-4 else joint
    low = brentq(lambda l: _height(member, l) + start * module, -4.0 * module, 0.0, xtol=1e-15)
    addendum = member.profile_shift + tool.addendum + member.tip_alteration
    tip = module * (member.teeth / (2.0 * np.cos(member.helix_angle)) + addendum)

    def beyond(l: float) -> float:
        x, y, _ = _generated(member, sigma, l, 0.0)
        return float(x * x + y * y - tip * tip)

    return low, brentq(beyond, 0.0, 4.0 * module, xtol=1e-15)


def base_radius(member: Member, sigma: float) -> float:
    """Return the base radius of the flank without its parabola."""
    alpha, sb, sg = member.tool.normal_pressure_angle, np.sin(member.helix_angle), np.sin(member.cone_angle)
    nx = np.sin(alpha) * np.cos(member.cone_angle) - sigma * np.cos(alpha) * sb * sg
    ny = sigma * np.cos(alpha) * np.cos(member.helix_angle)
    pitch = member.tool.normal_module * member.teeth / (2.0 * np.cos(member.helix_angle))
    return float(pitch * abs(ny) / np.hypot(nx, ny))


def depth(member: Member, sigma: float, l: Any, z: Any) -> Any:
    """Return delta (mm) of the modification of a flank, by its definitions in ISO 21771."""
    given = member.modification_right if sigma > 0.0 else member.modification_left
    if given is None:
        return 0.0 * l
    low, tip = limits(member.modified(None), sigma)
    half = 0.5 * member.face_width
    lam, zeta = (2.0 * l - low - tip) / (tip - low), z / half

    def relief(amount: Any, length: Any, distance: Any) -> Any:
        """`distance` is measured from the edge into the flank."""
        if not amount:
            return 0.0
        t = 1.0 - distance / length
        return amount * np.where(t.real > 0.0, t, 0.0) ** 2

    total = given.helix_slope_um * zeta / 2.0 + given.helix_crowning_um * zeta**2
    total = total + given.profile_slope_um * lam / 2.0 + given.profile_crowning_um * lam**2
    total = total + given.twist_um * lam * zeta / 4.0
    total = total + relief(given.tip_relief_um, given.tip_relief_length_mm, tip - l)
    total = total + relief(given.root_relief_um, given.root_relief_length_mm, l - low)
    total = total + relief(given.heel_relief_um, given.heel_relief_length_mm, half - z)
    total = total + relief(given.toe_relief_um, given.toe_relief_length_mm, half + z)
    return 1e-3 * total


def _point(member: Member, sigma: float, l: Any, z: Any, roll: Any) -> tuple[Any, Any, Any]:
    """Return a point of the modified flank in the fixed frame of the member, from mid-face."""
    x, y, phi = _generated(member, sigma, l, z)
    angle = phi + roll - sigma * depth(member, sigma, l, z) / base_radius(member, sigma)
    return np.cos(angle) * x - np.sin(angle) * y, np.sin(angle) * x + np.cos(angle) * y, z


def flank(
    member: Member, sigma: float, l: FloatArray, z: FloatArray, roll: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return points and outward unit normals (3, n) of a modified flank in the fixed frame of the member."""
    point = np.array(_point(member, sigma, l + 0j, z + 0j, roll)).real
    by_l = np.array([np.imag(part) for part in _point(member, sigma, l + STEP * 1j, z + 0j, roll)]) / STEP
    by_z = np.array([np.imag(part) for part in _point(member, sigma, l + 0j, z + STEP * 1j, roll)]) / STEP
    normal = -sigma * np.cross(by_l, by_z, axis=0)
    return point, normal / np.linalg.norm(normal, axis=0)


def residuals(design: Design, path: ContactPath, mounting: FloatArray) -> tuple[float, float]:
    """Return the largest differences of points (mm) and of opposed normals of both flanks along a path.

    The design is a single one. `mounting` (2,) are the distances of the mid-faces without errors, mm.
    """
    sigma = 1.0 if path.flank == "right" else -1.0
    pair, errors = design.pair, design.errors
    total = float(design.pinion.helix_angle + design.gear.helix_angle)
    hand = float(total if abs(total) > 1e-9 else design.pinion.helix_angle)
    sense = -1.0 if hand < 0.0 else 1.0
    angle = sense * (pair.shaft_angle + errors.shaft_angle)
    own, own_normal = flank(design.pinion, sigma, path.l1, path.pinion_z, path.pinion_roll)
    other, other_normal = flank(design.gear, sigma, path.l2, path.gear_z, path.gear_roll)
    own[2] += mounting[0] + errors.pinion_axial
    other[2] += mounting[1] + errors.gear_axial
    # X2 = -x, Z2 = k2 = (0, sin d, cos d), Y2 = k2 x X2.
    axes = np.array(
        ((-1.0, 0.0, 0.0), (0.0, -np.cos(angle), np.sin(angle)), (0.0, np.sin(angle), np.cos(angle)))
    )
    other = axes.T @ other
    other[0] += pair.offset + errors.offset
    apart = max(np.abs(own - other).max(), np.abs(own - path.point.T).max())
    turned = max(np.abs(own_normal + axes.T @ other_normal).max(), np.abs(own_normal - path.normal.T).max())
    return float(apart), float(turned)
