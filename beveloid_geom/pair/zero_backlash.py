"""Layouts in which the two lines of action meet, and the deviation of a design from them.

The lines of action of a design with rounded numbers ("rounded design") do not meet exactly. The layouts in
which they do ("closed layouts") are a family of one parameter, the working normal pressure angle a_w. Both
common normals then have the angle a_w to the working pitch plane and lie symmetrically on both sides of its
normal N,

    n = sin(a_w) N +/- cos(a_w) b,   b perpendicular to the tooth trace in this plane.

The rack gives the axial components of both normals of a member and their moments about its axis,
m_n N cos(alpha)/2 on both flanks (here N is the number of teeth). Half the sum and half the difference of the
axial components, and the moment, are

    sin(g_w) sin(a_w)          = sin(alpha) sin(gamma)
    sin(b_w) cos(g_w) cos(a_w) = cos(alpha) cos(gamma) sin(beta)
    r_w cos(a_w) cos(b_w)      = m_n N cos(alpha) / 2

for the working cone angle g_w, helix angle b_w and radius r_w. Joined at the pitch point P they give the
axes, and with them shaft angle, offset and mounting distances. The rolls at which the flanks of a member
pass P give its tooth thickness there, and hence the backlash.

One a_w gives zero backlash, one the offset of the design and one its shaft angle; in a rounded design these
are three different values. The backlash increases with a_w. (If a member has a cone angle and a helix angle,
it can first decrease, with a false zero far below the pressure angle of the tool.) The zero at which it
increases is used.

All equations hold for unmodified flanks without assembly errors.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ..arrays import FloatArray
from ..design.arguments import require_single
from ..design.member import Member
from ..design.model import Design
from ..gear.rack import rack_of
from ..support.array_repr import short_repr
from ..support.frozen_arrays import cached
from .frames import layout_of
from .mounting import mounting_of, normal_of_flanks

ROUNDING_SINE = 1e-12
"""Limit for computed layouts. Below this sine of the shaft angle the axes are parallel. Below this sum of the
working helix angles (rad) they intersect: the remaining sum is only rounding of the helix angles. The limit
for the axes of a design is `PARALLEL_AXES_SINE`.
"""


@dataclass(frozen=True, eq=False)
class ZeroBacklashLayout:
    """Layout in which the lines of action of unmodified flanks without errors meet (a closed layout).

    Only the result of `zero_backlash_layout` has no backlash. Other layouts of `closed_layout` have the
    backlash `normal_backlash`.

    `offset` (mm), `shaft_angle` (magnitude, rad) and `pressure_angle` (working, normal, rad). With pinion and
    gear on the leading axis (2, ...): working `cone_angle` and `helix_angle` (rad), `working_radius` and
    `mounting`, the axial coordinate of the pitch point (mm). `normal_backlash` (mm) is the backlash with the
    mid-faces at the pitch point. If both cone angles are zero, `mounting` is zero: the pitch point is on the
    common perpendicular, and any other mounting is possible.
    """

    offset: FloatArray
    shaft_angle: FloatArray
    pressure_angle: FloatArray
    cone_angle: FloatArray
    helix_angle: FloatArray
    working_radius: FloatArray
    mounting: FloatArray
    normal_backlash: FloatArray

    __repr__ = short_repr


@dataclass(frozen=True)
class LayoutDeviation:
    """Deviation of a design from a layout in which the lines of action meet (a closed layout); mm and rad,
    for unmodified flanks without errors.

    `gap`: smallest distance of the two lines of action. `normal_backlash` as mounted, negative for
    interference. `offset`: the offset at which the lines meet at the shaft angle of the design, negative if
    the axes would cross in the other sense. `shaft_angle`: the shaft angle at which the lines meet at the
    offset of the design. `offset_difference` and `shaft_angle_difference`: these values minus the values of
    the design. `offset` and `shaft_angle` themselves are values of closed layouts, not deviations. A value is
    NaN if it does not exist; `reasons` contains the reasons.
    """

    gap: float
    normal_backlash: float
    offset: float
    offset_difference: float
    shaft_angle: float
    shaft_angle_difference: float
    reasons: tuple[str, ...] = ()

    __repr__ = short_repr


def _pressure_angles(design: Design) -> FloatArray:
    """Return working pressure angles (rad), ascending, at which both members have a working helix and cone
    angle; empty if there are none.

    cos(b_w) = 0 bounds them: with s = sin^2(a_w), A = sin^2(alpha) sin^2(gamma) and
    C = cos^2(alpha) cos^2(gamma) sin^2(beta), (1 - s)(1 - A/s) = C is quadratic in s.
    """
    pressure_angle_samples = 721
    low, high = 0.0, 1.0
    for member in design.members:
        alpha, gamma = member.tool.normal_pressure_angle, member.cone_angle
        floor = float(np.sin(alpha) * np.sin(gamma)) ** 2
        ceiling = float(np.cos(alpha) * np.cos(gamma) * np.sin(member.helix_angle)) ** 2
        middle = 0.5 * (1.0 + floor - ceiling)
        half = math.sqrt(max(middle * middle - floor, 0.0))
        low, high = max(low, floor / (middle + half)), min(high, middle + half)
    if low >= high:
        return np.empty(0)
    first, last = math.asin(math.sqrt(low)), math.asin(math.sqrt(high))
    return first + (last - first) * np.linspace(1e-6, 1.0 - 1e-6, pressure_angle_samples)


def _thickness(member: Member, aw: FloatArray, gw: FloatArray, bw: FloatArray, rw: FloatArray) -> FloatArray:
    """Return the angle (rad) about the axis between the flanks of a tooth at the pitch point."""
    roll = {}
    for flank in ("left", "right"):
        rack = rack_of(member, flank)
        nx, ny, nz = rack.normal
        x0, y0, z0 = rack.apex
        radial = (np.sin(aw) + np.sin(gw) * nz) / np.cos(gw)
        around = rack.sigma * np.cos(aw) * np.cos(bw)
        start = nx * (rack.pitch_radius + x0) + ny * y0 + nz * z0
        turned = np.arctan2(around, radial) - np.arctan2(ny, nx)
        roll[flank] = turned - (start - rw * radial) / (rack.pitch_radius * ny)
    return np.asarray(roll["left"] - roll["right"])


def closed_layout(design: Design, pressure_angle: FloatArray) -> ZeroBacklashLayout:
    """Return closed layouts of the members of a design.

    Parameters
    ----------
    design : Design
        Offset and shaft angle of its pair are not used.
    pressure_angle : ndarray
        Working normal pressure angles, rad, of any shape that broadcasts with that of the design.

    Returns
    -------
    ZeroBacklashLayout
    """
    aw = np.asarray(pressure_angle, dtype=float)
    shape = np.broadcast_shapes(aw.shape, design.batch_shape)
    gw, bw, rw, thickness = (np.empty((2, *shape)) for _ in range(4))
    for j, member in enumerate(design.members):
        alpha, beta, gamma = member.tool.normal_pressure_angle, member.helix_angle, member.cone_angle
        base_pitch = np.pi * member.tool.normal_module * np.cos(alpha)  # equal for both members
        lever = base_pitch * member.teeth / (2.0 * np.pi)
        gw[j] = np.arcsin(np.sin(alpha) * np.sin(gamma) / np.sin(aw))
        bw[j] = np.arcsin(np.cos(alpha) * np.cos(gamma) * np.sin(beta) / (np.cos(aw) * np.cos(gw[j])))
        rw[j] = lever / (np.cos(aw) * np.cos(bw[j]))
        thickness[j] = member.teeth * _thickness(member, aw, gw[j], bw[j], rw[j])
    # Components of the pinion axis across the trace, along it and along N: (-sin b cos g, cos b cos g,
    # -sin g); the gear axis has other signs. Their cross product is written with the sum of the helix
    # angles, to which the offset is proportional, so that nearly parallel axes keep their digits.
    sine, cosine, sum_sine = np.sin(gw), np.cos(gw), np.sin(bw[0] + bw[1])
    (sin_1, sin_2), (cos_1, cos_2) = np.sin(bw) * cosine, np.cos(bw) * cosine
    cos_d = cos_1 * cos_2 - sin_1 * sin_2 - sine[0] * sine[1]
    square = (sine[0] * cos_2 + sine[1] * cos_1) ** 2 + (sine[0] * sin_2 - sine[1] * sin_1) ** 2
    sin_d = np.sqrt(square + (cosine[0] * cosine[1] * sum_sine) ** 2)
    reach = rw[0] * cosine[1] + rw[1] * cosine[0]
    lean = rw[::-1] * (sine + sine[::-1] * cos_d) / cosine[::-1]
    parallel = (
        sin_d <= ROUNDING_SINE
    )  # cones and helix angles cancel: r_w1 + r_w2 apart, mid-face against mid-face
    with np.errstate(invalid="ignore", divide="ignore"):
        offset = np.where(parallel, rw[0] + rw[1], design.sense * reach * sum_sine / sin_d)
        mounting = np.where(parallel, 0.0, (lean + lean[::-1] * cos_d) / sin_d**2)
    return ZeroBacklashLayout(
        offset=np.asarray(offset),
        shaft_angle=np.where(parallel, 0.0, np.arctan2(sin_d, cos_d)),
        pressure_angle=aw,
        cone_angle=gw,
        helix_angle=bw,
        working_radius=rw,
        mounting=mounting,
        normal_backlash=np.asarray((2.0 * np.pi - thickness[0] - thickness[1]) * base_pitch / (2.0 * np.pi)),
    )


def _roots(function: Callable[[FloatArray], FloatArray], samples: FloatArray) -> FloatArray:
    """Return the zeros of a vectorised `function` between samples at which its values change sign.

    All are bisected at once, because importing the root finders of SciPy takes longer.
    """
    # Bisection steps between two samples, to the last digit.
    bisections = 64
    values = function(samples)
    known = np.isfinite(values[:-1]) & np.isfinite(values[1:])
    cells = np.flatnonzero(known & (np.signbit(values[:-1]) != np.signbit(values[1:])))
    low, high, below = samples[cells], samples[cells + 1], np.signbit(values[cells])
    for _ in range(bisections if cells.size else 0):
        middle = 0.5 * (low + high)
        same = np.signbit(function(middle)) == below
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    return 0.5 * (low + high)


def zero_backlash_layout(design: Design) -> ZeroBacklashLayout:
    """Return the layout in which two members mesh without backlash, with their mid-faces at the pitch point.

    Offset, shaft angle and mounting distances follow from the gears alone; the pair of the design is not
    used. The sense in which the axes are inclined is `Design.sense`, which follows from the helix angles.

    Parameters
    ----------
    design : Design
        A single design; parabolas and errors are ignored.

    Returns
    -------
    ZeroBacklashLayout
        `offset`, `mounting` in mm, `shaft_angle` in rad. A negative offset occurs if the helix angles nearly
        cancel. The sense of the axes is then opposite to `Design.sense`. A design file cannot describe this
        layout; in Python it is `Pair(-offset, -shaft_angle)`. If the offset is zero, the axes intersect.

    Raises
    ------
    ValueError
        For arrays, and if the members have backlash in every layout in which their lines of action meet.

    References
    ----------
    Equations: beveloid_geom/pair/README.md, layouts in which the lines of action meet exactly.

    Examples
    --------
    >>> import beveloid_geom as bg
    >>> layout = bg.zero_backlash_layout(bg.builtin_design("ni-2017"))
    >>> print(f"{layout.offset:.4f} mm, {layout.shaft_angle:.6f} rad")
    228.8373 mm, 0.261683 rad
    """
    require_single(design)

    def backlash(pressure_angle: FloatArray) -> FloatArray:
        return closed_layout(design, pressure_angle).normal_backlash

    samples = _pressure_angles(design)
    lowest = int(np.argmin(backlash(samples))) if samples.size else 0
    roots = _roots(backlash, samples[lowest:])
    if not roots.size:
        reason = "the lines of action meet in no layout"
        if samples.size:
            reason = "the teeth are too thin in all layouts in which the lines of action meet"
        raise ValueError(f"no layout without backlash: {reason}")
    result = closed_layout(design, roots[0])
    return replace(result, offset=np.asarray(0.0)) if _meet(result) else result


def _meet(layout: ZeroBacklashLayout) -> bool:
    """Return whether the axes of a single layout intersect."""
    return bool(layout.shaft_angle > 0.0) and abs(float(np.sum(layout.helix_angle))) < ROUNDING_SINE


def _pressure_angle_as_mounted(design: Design) -> float:
    """Return the working pressure angle (rad) of the two common normals at the shaft angle of the design, if
    their lines meet: its sine is half the length of their sum. NaN without common normals.
    """
    layout, branch = layout_of(design, with_errors=False), mounting_of(design).branch
    normals = []
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        for flank, sign in zip(("right", "left"), branch, strict=True):
            normal, axial = normal_of_flanks(layout, design.members, flank)
            normals.append((sign * np.sqrt(normal.x_squared), normal.y[0], axial[0]))
        return float(np.arcsin(0.5 * np.linalg.norm(np.sum(normals, axis=0))))


def closing_offset(design: Design) -> float:
    """Return the offset (mm) of the closed layout at the shaft angle of the design, NaN if there is none."""
    # Tolerance in rad of the shaft angle of a layout that was computed from its pressure angle.
    shaft_angle_tolerance_rad = 1e-6
    with np.errstate(invalid="ignore"):
        closed = closed_layout(design, np.asarray(_pressure_angle_as_mounted(design)))
    if not abs(float(closed.shaft_angle) - float(design.pair.shaft_angle)) < shaft_angle_tolerance_rad:
        return math.nan
    return 0.0 if _meet(closed) else float(closed.offset)


def _closing_shaft_angle(design: Design, offset: float) -> float:
    """Return the shaft angle (rad) of the closed layout at the offset of the design, NaN if there is none.
    If there are several, the one nearest to the design is returned.

    `offset` (mm) is the offset that closes at the shaft angle of the design. Straight teeth on intersecting
    axes close at every shaft angle of the family: the nearest of its samples is returned.
    """
    # Difference of the offset from that of the closed layout, in modules, below which a design is
    # closed.
    closed_offset_modules = 1e-10
    near = closed_offset_modules * float(design.pinion.tool.normal_module)
    if abs(offset - float(design.pair.offset)) < near:
        return float(design.pair.shaft_angle)

    def excess(pressure_angle: FloatArray) -> FloatArray:
        return closed_layout(design, pressure_angle).offset - design.pair.offset

    samples = _pressure_angles(design)
    if samples.size and np.abs(excess(samples)).max() > near:
        samples = _roots(excess, samples)
    angles = closed_layout(design, samples).shaft_angle
    if not angles.size:
        return math.nan
    return float(angles[np.argmin(np.abs(angles - design.pair.shaft_angle))])


def layout_deviation(design: Design) -> LayoutDeviation:
    """Return the deviation of a single design from a layout in which the lines of action meet.

    Parameters
    ----------
    design : Design
        A single design; parabolas and errors are ignored.

    Returns
    -------
    LayoutDeviation
        Gap and backlash in mm, angles in rad.

    Raises
    ------
    ValueError
        For arrays.

    References
    ----------
    Equations: beveloid_geom/pair/README.md, layouts in which the lines of action meet exactly.

    Examples
    --------
    >>> import beveloid_geom as bg
    >>> deviation = bg.layout_deviation(bg.builtin_design("ni-2017"))
    >>> print(f"{deviation.normal_backlash:.4f} mm, {deviation.offset:.4f} mm")
    0.0416 mm, 229.0751 mm
    """
    require_single(design)
    return _cached_deviation(design.bare())


@cached(16)
def _cached_deviation(design: Design) -> LayoutDeviation:
    """Return `layout_deviation` for a design without errors and modifications, on which the result does not
    depend."""
    mounting = mounting_of(design)
    offset = closing_offset(design)
    shaft_angle = _closing_shaft_angle(design, offset)
    reasons = []
    if math.isnan(offset):
        given = f"{math.degrees(design.pair.shaft_angle):.6g} deg"
        lost = math.isnan(_pressure_angle_as_mounted(design))
        why = "the flanks have no common normal" if lost else "the lines of action do not meet"
        reasons.append(f"{why} at a shaft angle of {given}, whatever the offset")
    if math.isnan(shaft_angle):
        reasons.append(
            f"the lines of action meet at no shaft angle with an offset of {design.pair.offset:.6g} mm"
        )
    return LayoutDeviation(
        gap=abs(float(mounting.gap)),
        normal_backlash=float(mounting.normal_backlash),
        offset=offset,
        offset_difference=offset - float(design.pair.offset),
        shaft_angle=shaft_angle,
        shaft_angle_difference=shaft_angle - float(design.pair.shaft_angle),
        reasons=tuple(reasons),
    )
